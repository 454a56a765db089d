#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page of `juliavdb explore` in a real browser, with its server."""

import browser
from browser import harness
from server import Server


class Browser(browser.BrowserTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.torus(around=24, across=12)))
        self.page = Server(self.folder, "s.obj", "--sdf-resolution", "40", "--resolution", "30", "--detail", "0.4")
        self.addCleanup(self.page.kill)

    def colours(self):
        """How many colours there are in the picture as it is on the screen."""
        return self.driver.execute_async_script("""
            const done = arguments[1], image = new Image();
            image.onload = () => {
              const canvas = document.createElement("canvas");
              canvas.width = image.width;
              canvas.height = image.height;
              const context = canvas.getContext("2d");
              context.drawImage(image, 0, 0);
              const bytes = new Uint32Array(context.getImageData(0, 0, image.width, image.height).data.buffer);
              done(new Set(bytes).size);
            };
            image.onerror = () => done(0);
            image.src = "data:image/png;base64," + arguments[0];
        """, self.find("#picture").screenshot_as_base64)

    def test_from_the_address_to_a_file(self):
        self.driver.get(self.page.url)
        self.wait_until(lambda: self.finds("#picture"), "the canvas")
        self.wait_until(lambda: self.colours() > 50, "the fractal")
        self.assertEqual(self.errors(), [])
        # Nothing was asked of anybody but the server.
        asked = self.driver.execute_script("return performance.getEntriesByType('resource').map((one) => one.name)")
        self.assertGreater(len(asked), 5)
        for address in asked:
            self.assertTrue(address.startswith((self.page.url, "data:", "blob:")), address)
        self.button("Exact picture").click()
        self.wait_until(lambda: self.find("img.exact").is_displayed(), "the exact picture")
        self.driver.execute_script("document.querySelector('.files').open = true")
        self.button("Make").click()
        self.wait_until(lambda: self.path("look.vdb").exists(), "the file")
        self.ok("fractal", "s.obj", "--sdf-resolution", "40", "--resolution", "30", "--detail", "0.4", "-o", "x.vdb")
        self.assertEqual(self.bytes("look.vdb"), self.bytes("x.vdb"))
        self.assertEqual(self.errors(), [])

    def test_the_exported_page_from_a_file(self):
        self.ok("explore", "s.obj", "--sdf-resolution", "40", "--detail", "0.4", "--export", "look.html")
        self.page.kill()
        self.driver.get(self.path("look.html").as_uri())
        self.wait_until(lambda: self.finds("#picture"), "the canvas")
        self.wait_until(lambda: self.colours() > 50, "the fractal")
        self.assertEqual(self.errors(), [])


if __name__ == "__main__":
    browser.main()

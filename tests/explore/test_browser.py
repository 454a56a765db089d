#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page of `juliavdb explore` in a real browser, without a display and with software for a GPU. Where Chromium, its
driver or Selenium is missing, the test is skipped with a message."""

import shutil
import sys

from server import Server, harness

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.by import By
    from selenium.webdriver.support.ui import WebDriverWait
except ImportError:
    webdriver = None

PATIENCE = 120  # seconds


def missing():
    if webdriver is None:
        return "python3-selenium"
    return next((name for name in ("chromium", "chromedriver") if not shutil.which(name)), None)


class Browser(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.torus(around=24, across=12)))
        self.page = Server(self.folder, "s.obj", "--sdf-resolution", "40", "--resolution", "30", "--detail", "0.4")
        self.addCleanup(self.page.kill)
        options = Options()
        options.binary_location = shutil.which("chromium")
        for word in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-angle=swiftshader",
                     "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--window-size=900,700", "--no-first-run",
                     "--disable-background-networking", "--disable-component-update",
                     f"--user-data-dir={self.path('profile')}"):
            options.add_argument(word)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
        self.addCleanup(self.driver.quit)
        self.driver.set_page_load_timeout(PATIENCE)

    def wait_until(self, condition, what):
        try:
            WebDriverWait(self.driver, PATIENCE, 0.3).until(lambda _: condition())
        except Exception as error:
            raise AssertionError(f"{what} did not come: {self.driver.get_log('browser')}") from error

    def find(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def button(self, text):
        return self.driver.find_element(By.XPATH, f"//button[normalize-space()='{text}']")

    def errors(self):
        return [entry for entry in self.driver.get_log("browser") if entry["level"] in ("SEVERE", "ERROR")]

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
        self.wait_until(lambda: self.driver.find_elements(By.ID, "picture"), "the canvas")
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
        self.wait_until(lambda: self.driver.find_elements(By.ID, "picture"), "the canvas")
        self.wait_until(lambda: self.colours() > 50, "the fractal")
        self.assertEqual(self.errors(), [])


if __name__ == "__main__":
    if missing():
        print(f"skipped: {missing()} is not installed")
        sys.exit(0)
    harness.main()

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page of `juliavdb explore` in a real browser, with its server."""

import base64
import math
import shlex
import struct

import browser
from browser import harness
from server import Server


class Browser(browser.BrowserTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.torus(around=24, across=12)))
        self.page = Server(self.folder, "s.obj", "--sdf-resolution", "40", "--resolution", "30", "--detail", "0.4")
        self.addCleanup(self.page.kill)

    def colours(self, selector="#picture"):
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
        """, self.find(selector).screenshot_as_base64)

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

    def open_page(self):
        self.driver.get(self.page.url)
        self.prepare()

    def prepare(self):
        self.wait_until(lambda: self.run_script("return Boolean(window.explore)"), "the page")
        self.run_script("explore.store.change((state) => { state.look.samples = 1; }); document.querySelector('.files').open = true;"
                        # What the page lets the user save.
                        "window.blobs = {}; const address = URL.createObjectURL;"
                        "URL.createObjectURL = (blob) => { const made = address(blob); blobs[made] = blob; return made; };"
                        "window.saved = []; HTMLAnchorElement.prototype.click = function() { saved.push([this.download, this.href]); };")

    def settle(self):
        self.wait_until(lambda: not self.run_script("return explore.isBusy()"), "the scene")
        self.driver.execute_async_script("explore.settled().then(arguments[0])")

    def state(self):
        return self.run_script("return structuredClone(explore.store.state)")

    def status(self):
        return self.find(".status").text

    def fetched(self, address):
        """The bytes behind an address that the page made."""
        text = self.driver.execute_async_script("""
            const done = arguments[1], reader = new FileReader();
            reader.onload = () => done(reader.result);
            reader.readAsDataURL(blobs[arguments[0]]);""", address)
        return base64.b64decode(text.partition(",")[2])

    def saved(self, count):
        self.wait_until(lambda: self.run_script("return saved.length") >= count, "the saved file")
        name, address = self.run_script("return saved.at(-1)")
        return name, self.fetched(address)

    def drop(self, name, content):
        self.run_script("""
            const bytes = Uint8Array.from(atob(arguments[1]), (c) => c.charCodeAt(0)), files = new DataTransfer();
            files.items.add(new File([bytes], arguments[0]));
            document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: files, bubbles: true, cancelable: true }));
            """, name, base64.b64encode(content).decode())

    def pointer(self, kind, x, y, identity=1):
        """An event of a mouse or finger in the picture, by shares of its width and height."""
        self.run_script("""
            const [kind, x, y, id] = arguments, picture = document.getElementById("picture"), box = picture.getBoundingClientRect();
            picture.setPointerCapture = () => {};  // there is no such finger
            picture.dispatchEvent(new PointerEvent(kind, { pointerId: id, bubbles: true, button: 0,
              clientX: box.left + x * box.width, clientY: box.top + y * box.height }));""", kind, x, y, identity)

    def test_a_look_comes_back(self):
        """By its address, by the command, by a file that was made, and by a file that was saved."""
        self.open_page()
        self.run_script("""explore.store.change((state) => {
            Object.assign(state.recipe, { versor: "thorns", detail: "0.6", slice: "0.1", colour: "trap:magma" });
            Object.assign(state.view, { eye: state.view.eye.map((value, i) => value + [0.2, 0.1, 0.4][i]) });
          });""")
        self.settle()
        state = self.state()
        self.driver.refresh()
        self.prepare()
        self.settle()
        self.assertEqual(self.state(), state)

        self.button("Exact picture").click()
        self.wait_until(lambda: self.find("img.exact").is_displayed(), "the exact picture")
        exact = self.fetched(self.find("img.exact").get_attribute("src"))
        self.button("Copy command").click()
        self.wait_until(lambda: self.find("textarea").is_displayed(), "the command")
        words = shlex.split(self.find("textarea").get_property("value"))
        self.assertEqual(words[:2], ["juliavdb", "fractal"])
        self.ok(*words[1:])
        made = words[words.index("-o") + 1]
        view, height, width = state["view"], *struct.unpack(">II", exact[16:24])[::-1]
        listed = lambda numbers: ",".join(map(repr, numbers))  # noqa: E731
        self.ok("render", "--field", made, "-o", "exact.png", f"--eye={listed(view['eye'])}",
                f"--look-at={listed(view['lookAt'])}", f"--up={listed(view['up'])}", "--fov", view["fov"],
                "--size", f"{width}x{height}", "--samples", "4")
        self.assertEqual(self.bytes("exact.png"), exact)

        self.button("Save recipe").click()
        name, recipe = self.saved(1)
        self.assertTrue(name.endswith(".json"))
        for file, content in ((made, self.bytes(made)), (name, recipe)):
            self.run_script("explore.store.change((state) => { state.recipe = { input: state.recipe.input, versor: 'fur' }; })")
            self.drop(file, content)
            self.wait_until(lambda: self.state()["recipe"].get("versor") == "thorns", f"the recipe of {file}")
            dropped = self.state()["recipe"]
            for option in ("versor", "detail", "slice", "colour"):
                self.assertEqual(dropped.get(option), state["recipe"][option], file)
        self.drop("bad.vdb", b"no recipe at all")
        self.wait_until(lambda: "error" in self.find(".status").get_attribute("class"), "the refusal")
        self.assertEqual(self.state()["recipe"], dropped)
        self.driver.get_log("browser")  # a refused request is told there

        self.button("Export page").click()
        name, page = self.saved(2)
        self.assertTrue(name.endswith(".html"))
        self.path("look.html").write_bytes(page)
        self.driver.get(self.path("look.html").as_uri())
        self.wait_until(lambda: self.run_script("return Boolean(window.explore)"), "the exported page")
        self.assertEqual(self.state()["look"], state["look"])
        self.assertEqual(self.errors(), [])

    def test_sixteen_looks_to_choose_from(self):
        self.open_page()
        self.settle()
        # From some iterations on nothing changes any more at this size.
        for strip, option, least in (("Seeds", "versor-seed", 16), ("Iterations", "iterations", 5)):
            self.run_script("""const select = document.querySelector(".strip select");
                select.value = [...select.options].find((one) => one.text === arguments[0]).value;""", strip)
            self.button("Show sixteen").click()
            self.wait_until(lambda: self.find(".strip .note").text == "" and self.finds(".cell"), "the strip")
            cells = self.finds(".cell")
            self.assertEqual(len(cells), 16)
            self.assertEqual(self.finds(".cell.failed"), [])
            pictures = self.run_script("return [...document.querySelectorAll('.cell canvas')].map((one) => one.toDataURL())")
            self.assertGreaterEqual(len(set(pictures)), least)
            cells[4].click()
            self.assertEqual(self.state()["recipe"][option], cells[4].text)
            self.settle()
        self.assertEqual(self.errors(), [])

    def test_drags(self):
        self.open_page()
        self.settle()
        eye = lambda: self.state()["view"]["eye"]  # noqa: E731
        distance = lambda: math.dist(eye(), self.state()["view"]["lookAt"])  # noqa: E731
        first, far = eye(), distance()
        for kind, x in (("pointerdown", 0.5), ("pointermove", 0.6), ("pointerup", 0.6)):
            self.pointer(kind, x, 0.5)
        self.assertNotEqual(eye(), first)
        self.assertAlmostEqual(distance(), far, delta=1e-6 * far)
        # Two fingers that part come nearer.
        for identity, x in ((1, 0.4), (2, 0.6)):
            self.pointer("pointerdown", x, 0.5, identity)
        for identity, x in ((1, 0.3), (2, 0.7)):
            self.pointer("pointermove", x, 0.5, identity)
        for identity, x in ((1, 0.3), (2, 0.7)):
            self.pointer("pointerup", x, 0.5, identity)
        self.assertAlmostEqual(distance(), far / 2, delta=0.01 * far)
        self.button("Whole set").click()
        before = eye()
        self.button("Drag the origin in the picture").click()
        for kind, x in (("pointerdown", 0.5), ("pointermove", 0.55), ("pointerup", 0.55)):
            self.pointer(kind, x, 0.5)
        self.assertEqual(eye(), before)
        x, y, z = map(float, self.state()["recipe"]["origin-shift"].split(","))
        self.assertGreater(x, 0)  # from the front, a little from the left, to the right
        self.assertGreater(z, 0)
        self.assertEqual(y, 0)
        self.settle()
        # One step of a user's is one step back.
        self.button("Undo").click()
        self.assertNotIn("origin-shift", self.state()["recipe"])
        self.assertEqual(self.errors(), [])

    def test_what_is_cancelled_leaves_nothing(self):
        self.open_page()
        before = set(self.listing())
        self.run_script("document.getElementById('make-resolution').value = 1500; document.getElementById('make-ply').click()")
        self.button("Make").click()
        share = "return document.querySelector('.jobs .running progress')?.value ?? 0"
        self.wait_until(lambda: self.run_script(share) > 0, "the job")
        # The button stays the same one, and keeps the focus, while the progress beside it changes.
        cancel, begun = self.find(".jobs button"), self.run_script(share)
        self.run_script("arguments[0].focus()", cancel)
        self.wait_until(lambda: self.run_script(share) > begun, "its progress")
        self.assertTrue(self.run_script("return document.activeElement === arguments[0]", cancel))
        cancel.send_keys("\n")
        self.wait_until(lambda: self.finds(".jobs .cancelled"), "the end of the job")
        self.assertEqual(set(self.listing()), before)
        # It begins again, and is done.
        self.run_script("document.getElementById('make-resolution').value = 20")
        self.button("Make").click()
        self.wait_until(lambda: self.finds(".jobs .done"), "the next job")
        self.assertEqual(set(self.listing()) - before, {"look.vdb", "look.ply"})
        self.assertEqual(self.errors(), [])

    def test_beside_the_target(self):
        self.open_page()
        self.settle()
        self.button("Beside the target").click()
        self.wait_until(lambda: self.finds(".target canvas") and self.finds(".target canvas")[0].is_displayed(), "the target")
        self.wait_until(lambda: self.colours(".target canvas") > 50, "the target's picture")
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

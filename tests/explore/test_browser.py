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
        """Also stops the pictures of the shelf, for which the page asks whenever it has nothing else to do."""
        self.wait_until(lambda: self.run_script("return Boolean(window.explore)"), "the page")
        self.run_script("explore.thumbnails?.stop(); explore.store.change((state) => { state.look.samples = 1; }); document.querySelector('.files').open = true;"
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

    # Promise: "*Material*, *Light*, *Sky*, *Exposure*, *Ground* ..."
    # Promise: "The address always holds ..."
    def test_a_look_comes_back(self):
        """By its address, by the command, by a file that was made, and by a file that was saved."""
        self.open_page()
        self.run_script("""explore.store.change((state) => {
            Object.assign(state.recipe, { texture: "thorns", detail: "0.6", slice: "0.1", colour: "trap:magma" });
            state.look.options = { material: "slate", light: "30,20" };
            Object.assign(state.view, { eye: state.view.eye.map((value, i) => value + [0.2, 0.1, 0.4][i]) });
          });""")
        self.settle()
        state = self.state()
        self.driver.refresh()
        self.prepare()
        self.settle()
        self.assertEqual(self.state(), state)
        # An address of version 1.0 has another name for the texture.
        self.assertIn("thorns", self.run_script("return location.hash = location.hash.replaceAll('texture', 'versor')"))
        self.settle()
        self.assertEqual(self.state(), state)

        self.button("Exact picture").click()
        self.wait_until(lambda: self.find("img.exact").is_displayed(), "the exact picture")
        exact = self.fetched(self.find("img.exact").get_attribute("src"))
        self.button("Copy command").click()
        self.wait_until(lambda: self.find(".files textarea").is_displayed(), "the command")
        words = shlex.split(self.find(".files textarea").get_property("value"))
        self.assertEqual(words[:2], ["juliavdb", "fractal"])
        self.ok(*words[1:])
        made = words[words.index("-o") + 1]
        view, height, width = state["view"], *struct.unpack(">II", exact[16:24])[::-1]
        listed = lambda numbers: ",".join(map(repr, numbers))  # noqa: E731
        self.ok("render", "--field", made, "-o", "exact.png", f"--eye={listed(view['eye'])}",
                f"--look-at={listed(view['lookAt'])}", f"--up={listed(view['up'])}", "--fov", view["fov"],
                "--size", f"{width}x{height}", "--samples", "4", "--material", "slate", "--light", "30,20")
        self.assertEqual(self.bytes("exact.png"), exact)

        self.button("Save recipe").click()
        name, recipe = self.saved(1)
        self.assertTrue(name.endswith(".json"))
        for file, content in ((made, self.bytes(made)), (name, recipe)):
            self.run_script("explore.store.change((state) => { state.recipe = { input: state.recipe.input, texture: 'fur' }; })")
            self.drop(file, content)
            self.wait_until(lambda: self.state()["recipe"].get("texture") == "thorns", f"the recipe of {file}")
            dropped = self.state()["recipe"]
            for option in ("texture", "detail", "slice", "colour"):
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

    # ---------------------------------------------------------------------------------------------- sixteen looks

    def size(self, width, height, scale=None):
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": width, "height": height, "deviceScaleFactor": scale or self.SCALE, "mobile": False})

    def show_sixteen(self, what):
        self.run_script("""const select = document.querySelector(".strip select");
            select.value = [...select.options].find((one) => one.text === arguments[0]).value;""", what)
        self.button("Show sixteen").click()
        self.wait_for_looks()

    def wait_for_looks(self):
        self.wait_until(lambda: not self.run_script("return explore.choices.isWorking"), "the looks")
        self.assertEqual(self.run_script("return [...document.querySelectorAll('.choice-error')].map((one) => one.textContent).join('')"), "")

    def looks(self):
        """Of the page of looks that is shown: what they are called, their recipes and their pictures."""
        return self.run_script("return explore.choices.top.cells.map((one) => [one.label, one.recipe, one.canvas.toDataURL()])")

    def choice(self, i, text=None):
        """The picture of a look, or another button of it."""
        buttons = self.finds(".choice")[i].find_elements("css selector", "button")
        return buttons[0] if text is None else next(one for one in buttons if one.text == text)

    def press(self, key):
        """In what has the focus."""
        self.run_script("document.activeElement.dispatchEvent(new KeyboardEvent('keydown', "
                        "{key: arguments[0], bubbles: true, cancelable: true}))", key)

    def is_open(self):
        return self.find(".choices").is_displayed()

    def boxes(self, selector):
        """Left, top, right and bottom of elements, pixels of the layout."""
        return self.run_script("return [...document.querySelectorAll(arguments[0])].map((one) => one.getBoundingClientRect())"
                               ".map((box) => [box.left, box.top, box.right, box.bottom])", selector)

    # Promise of explore.md: "*Show sixteen* fills the stage with sixteen pictures", "four by four", which "arrive one by one"; a
    #   look that cannot be says so in its place
    def test_sixteen_looks_to_choose_from(self):
        self.open_page()
        self.settle()
        # From some iterations on nothing changes any more at this size.
        for what, option, least in (("Seeds", "texture-seed", 16), ("Iterations", "iterations", 5)):
            self.show_sixteen(what)
            looks = self.looks()
            self.assertEqual(len(looks), 16)
            self.assertGreaterEqual(len({picture for _, _, picture in looks}), least)
            self.choice(4).click()
            self.assertFalse(self.is_open())
            self.assertEqual(self.state()["recipe"][option], looks[4][0])
            self.assertEqual(self.state()["recipe"], looks[4][1])
            self.settle()
            # A way back to the choice.
            self.button("Back to the sixteen").click()
            self.assertEqual(self.looks(), looks)
            self.button("Close").click()
        self.assertEqual(self.errors(), [])

    # Promise: "*Show sixteen* fills the stage ..."
    def test_the_looks_are_large_and_on_the_stage(self):
        self.open_page()
        self.settle()
        for width, height, columns, least in ((1280, 800, 4, 220), (1920, 1080, 4, 380), (390, 844, 2, 170)):
            self.size(width, height, 0.1)
            self.show_sixteen("Iterations")
            pictures, (stage,) = self.boxes(".choice-picture"), self.boxes(".choices")
            self.assertEqual(len(pictures), 16)
            self.assertEqual(len({round(left) for left, _, _, _ in pictures}), columns)
            self.assertEqual(len({round(top) for _, top, _, _ in pictures}), 16 // columns)
            for left, top, right, bottom in pictures:
                self.assertGreaterEqual(right - left, least)
                self.assertGreaterEqual(bottom - top, 120)
                self.assertGreaterEqual(left, stage[0])
                self.assertLessEqual(right, stage[2])
                self.assertGreaterEqual(top, stage[1])
                if columns == 4:
                    self.assertLessEqual(bottom, stage[3])
            (controls,) = self.boxes(".panel")
            if columns == 4:
                self.assertLessEqual(stage[2], controls[0])
            self.button("Close").click()
        # On a telephone the controls follow the picture without a gap, and nothing is wider than the screen.
        buttons, (finder,) = self.boxes(".strip button"), self.boxes(".finder input")
        self.assertLessEqual(finder[1] - max(bottom for _, _, _, bottom in buttons), 24)
        self.assertLessEqual(self.run_script("return document.documentElement.scrollWidth"), 390)
        # The picture stays in sight over the controls, and leaves them half of the screen, also with the key frames open.
        self.button("Key frames").click()
        self.run_script("document.querySelector('.finder').scrollIntoView(); scrollBy(0, -document.querySelector('.views').clientHeight)")
        (picture,), (finder,) = self.boxes("#picture"), self.boxes(".finder input")
        self.assertAlmostEqual(picture[1], 0, delta=1)
        self.assertLessEqual(picture[3], 844 / 2)
        self.assertGreaterEqual(finder[1], picture[3] - 1)
        self.assertLessEqual(finder[3], 844 / 2 + 40)
        self.run_script("scrollTo(0, 0)")
        self.button("Key frames").click()
        self.size(1280, 800, 0.1)
        # What is below the picture has something in every part of its width.
        parts, (strip,) = self.boxes(".strip .buttons, .strip .kept"), self.boxes(".strip")
        self.assertLessEqual(parts[0][0] - strip[0], 12)
        self.assertLessEqual(parts[1][0] - parts[0][2], 12)
        self.assertLessEqual(strip[2] - parts[1][2], 12)
        self.assertEqual(self.errors(), [])

    # Promise: "*Show sixteen* fills the stage ..."
    def test_the_looks_arrive_one_by_one(self):
        self.open_page()
        self.settle()
        self.run_script("""
            window.arrived = [];
            new MutationObserver((changes) => {
              const cells = [...document.querySelectorAll(".choice")];
              arrived.push(changes.map(({ target }) => cells.indexOf(target)).filter((i) => i >= 0));
            }).observe(document.querySelector(".choices-holder"), { subtree: true, attributeFilter: ["class"] });""")
        self.show_sixteen("Detail")
        self.assertEqual([some for some in self.run_script("return arrived") if some], [[i] for i in range(16)])

    # Promise of explore.md: "*Vary* shows sixteen neighbours", "The same look always has the same neighbours", and *Back* shows
    #   the sixteen from before: "nothing is asked for again"
    def test_a_look_is_varied_again_and_there_is_a_way_back(self):
        self.open_page()
        self.settle()
        self.run_script("window.asked = 0; const ask = fetch; window.fetch = (...all) => { ++asked; return ask(...all); };")
        self.show_sixteen("Detail")
        first = self.looks()
        pages = [first]
        for what, option in (("Detail", "detail"), ("Outward", "outward"), ("Seeds", "texture-seed"), ("A little of everything", None)):
            self.run_script("""const select = document.querySelector(".choices-vary select");
                select.value = [...select.options].find((one) => one.text === arguments[0]).value;""", what)
            chosen = pages[-1][5][1]
            self.choice(5, "Vary").click()
            self.wait_for_looks()
            looks = self.looks()
            self.assertEqual(len(looks), 16)
            recipes = [recipe for _, recipe, _ in looks]
            for recipe in recipes:
                changed = {name for name in {*recipe, *chosen} if recipe.get(name) != chosen.get(name)}
                self.assertTrue(changed)
                # The seed alone would mean random roots.
                self.assertLessEqual(changed, {option, "texture"} if option == "texture-seed" else {option} if option
                                     else {"detail", "outward", "frequency", "texture-scale", "texture-translate", "slice"})
                self.assertEqual(recipes.count(recipe), 1)
            if what == "Detail":
                # Nearer to the chosen one than the looks among which it was.
                spread = lambda some: max(float(one[1]["detail"]) for one in some) - min(float(one[1]["detail"]) for one in some)  # noqa: E731
                self.assertLess(spread(looks), spread(first))
            pages.append(looks)
        # The same look has the same neighbours.
        again = pages[-1]
        self.button("Back").click()
        self.choice(5, "Vary").click()
        self.wait_for_looks()
        self.assertEqual([recipe for _, recipe, _ in self.looks()], [recipe for _, recipe, _ in again])
        # The pages on the way back are there still, and not asked for again.
        self.settle()
        asked = self.run_script("return asked")
        for looks in pages[-2::-1]:
            self.button("Back").click()
            self.assertEqual(self.looks(), looks)
            self.assertFalse(self.run_script("return explore.choices.isWorking"))
        self.assertEqual(self.run_script("return asked"), asked)
        self.assertFalse(self.button("Back").is_enabled())
        self.assertEqual(self.errors(), [])

    # Promise of explore.md#sixteen-looks-to-choose-from: Looks are kept, compared "side by side", and reached by keys; a kept
    #   look is that of the command
    def test_a_look_that_is_kept_is_that_of_the_command(self):
        self.open_page()
        self.settle()
        self.show_sixteen("A little of everything")
        looks = self.looks()
        self.choice(3, "Keep").click()
        self.choice(7, "Keep").click()
        self.choice(7, "Keep").click()
        self.button("Close").click()
        self.driver.refresh()
        self.prepare()
        self.settle()
        self.assertEqual(len(self.finds(".kept-look")), 1)
        self.find(".kept-picture").click()
        self.assertEqual(self.state()["recipe"], looks[3][1])
        self.settle()
        self.button("Copy command").click()
        self.wait_until(lambda: self.find(".files textarea").is_displayed(), "the command")
        words = shlex.split(self.find(".files textarea").get_property("value"))
        made = words[words.index("-o") + 1]
        self.ok(*words[1:])
        status, job = self.page.post("make", {"recipe": looks[3][1], "name": "kept", "formats": ["vdb"], "resolution": "30"})
        self.assertEqual((status, self.page.wait_for(job["job"])["state"]), (200, "done"))
        self.assertEqual(self.bytes("kept.vdb"), self.bytes(made))
        self.find(".kept-remove").click()
        self.assertEqual(self.finds(".kept-look"), [])
        self.assertEqual(self.errors(), [])

    # Promise: Looks are kept, compared ...
    def test_looks_are_compared(self):
        self.open_page()
        self.size(1280, 800, 0.1)
        self.settle()
        self.show_sixteen("Detail")
        looks, small = self.looks(), self.boxes(".choice-picture")
        now = self.state()["recipe"]
        for marked, shown in (((2,), (None, 2)), ((2, 9), (2, 9)), ((0, 2, 9, 15), (0, 2, 9, 15))):
            for i in marked:
                if self.choice(i, "Compare").get_attribute("aria-pressed") == "false":
                    self.choice(i, "Compare").click()
            self.find(".choices-compare").click()
            self.wait_for_looks()
            self.assertEqual([recipe for _, recipe, _ in self.looks()], [now if i is None else looks[i][1] for i in shown])
            self.assertGreater(self.boxes(".choice-picture")[0][2], 1.9 * (small[0][2] - small[0][0]))
            # Also where the pictures are narrow nothing is lost at their sides, where the background is grey.
            sides = self.run_script("""
                return explore.choices.top.cells.map(({ canvas }) => [0, canvas.width - 1].map((x) =>
                  [...canvas.getContext("2d").getImageData(x, 0, 1, canvas.height).data]).flat());""")
            for pixels in sides:
                self.assertLessEqual(max(max(pixels[at:at + 3]) - min(pixels[at:at + 3]) for at in range(0, len(pixels), 4)), 8)
            if marked == (2,):
                self.choice(1, "Keep").click()
            self.button("Back").click()
            self.assertEqual(self.looks(), looks)
        self.assertEqual(self.choice(2, "Keep").get_attribute("aria-pressed"), "true")
        self.choice(9).click()
        self.assertEqual(self.state()["recipe"], looks[9][1])
        self.assertEqual(self.errors(), [])

    # Promise: Looks are kept, compared ...
    def test_the_looks_by_keys(self):
        self.open_page()
        self.settle()
        self.show_sixteen("Detail")
        looks = self.looks()
        focused = lambda: self.run_script("return explore.choices.top.cells.findIndex((one) => one.picture === document.activeElement)")  # noqa: E731
        self.assertEqual(focused(), 0)
        for key, at in (("ArrowRight", 1), ("ArrowDown", 5), ("ArrowDown", 9), ("ArrowLeft", 8), ("ArrowUp", 4), ("ArrowUp", 0), ("ArrowUp", 0)):
            self.press(key)
            self.assertEqual(focused(), at)
        # Tab reaches the buttons of one look only.
        self.assertEqual(self.run_script("return document.querySelectorAll('.choice button[tabindex=\"0\"]').length"), 4)
        self.press("ArrowRight")
        self.press("k")
        self.assertEqual(len(self.finds(".kept-look")), 1)
        self.press("v")
        self.wait_for_looks()
        self.assertNotEqual(self.looks(), looks)
        self.press("Backspace")
        self.assertEqual(self.looks(), looks)
        self.assertEqual(focused(), 1)
        self.press("c")
        self.assertTrue(self.find(".choices-compare").is_enabled())
        self.press("Escape")
        self.assertFalse(self.is_open())
        self.assertEqual(self.run_script("return document.activeElement.textContent"), "Show sixteen")
        # Whoever changes a control wants to see it.
        self.button("Back to the sixteen").click()
        self.run_script("explore.store.change((state) => { state.recipe.slice = '0.1'; })")
        self.assertFalse(self.is_open())
        self.assertEqual(self.errors(), [])

    # Promise: "*Show sixteen* fills the stage ..."
    def test_a_look_that_cannot_be_says_so_in_its_place(self):
        self.open_page()
        self.settle()
        self.page.kill()
        self.run_script("document.querySelector('.strip select').value = 'detail'")
        self.button("Show sixteen").click()
        self.wait_until(lambda: not self.run_script("return explore.choices.isWorking"), "the errors")
        errors = self.run_script("return [...document.querySelectorAll('.choice-error')].map((one) => one.textContent)")
        # The look at hand is one of them, and is there.
        self.assertEqual(errors.count(""), 1)
        self.assertEqual(set(errors), {"", "The server does not answer. Is 'juliavdb explore' still running?"})
        self.assertFalse(self.choice(0, "Keep").is_enabled())

    # --------------------------------------------------------------------------------------------- turns and keys

    # Promise of explore.md: "*Turntable* turns the camera about the target"
    def test_the_turntable(self):
        self.open_page()
        self.settle()
        eye = lambda: self.state()["view"]["eye"]  # noqa: E731
        first, middle, address = eye(), self.state()["view"]["lookAt"], self.run_script("return location.hash")
        self.button("Turntable").click()
        self.wait_until(lambda: math.dist(eye(), first) > 0.3 * math.dist(first, middle), "the turn")
        self.assertEqual(self.run_script("return location.hash"), address)
        self.button("Turntable").click()
        turned = eye()
        self.assertEqual(self.state()["view"]["lookAt"], middle)
        self.assertAlmostEqual(turned[1], first[1], delta=1e-6)
        self.assertAlmostEqual(math.dist(turned, middle), math.dist(first, middle), delta=1e-6)
        self.settle()
        self.assertEqual(eye(), turned)
        # The whole turn is one step back.
        self.button("Undo").click()
        self.assertEqual(eye(), first)
        # Whoever does something else ends it.
        self.button("Turntable").click()
        self.wait_until(lambda: eye() != first, "the turn")
        self.run_script("explore.store.change((state) => { state.recipe.slice = '0.1'; })")
        self.assertEqual(self.button("Turntable").get_attribute("aria-pressed"), "false")
        stopped = eye()
        self.settle()
        self.assertEqual(eye(), stopped)
        self.assertEqual(self.errors(), [])

    # Promise: A frame between keys is "blended ..."
    def test_from_key_frames_to_a_sequence(self):
        self.open_page()
        self.settle()
        self.button("Key frames").click()
        keys = self.find(".keys")

        def set_key(frame, **options):
            number = keys.find_element("css selector", "input[aria-label='The number of the frame']")
            self.run_script("arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('change'))", number, frame)
            self.wait_until(lambda: self.run_script("return document.querySelector('.keys input[type=range]').value") == str(frame), "the frame")
            self.run_script("explore.store.change((state) => { Object.assign(state.recipe, arguments[0]); })", options)
            self.settle()
            self.button("Set a key").click()

        self.assertFalse(self.button("Play").is_enabled())
        set_key(1, detail="0.2")
        first = self.state()["recipe"]
        set_key(3, detail="0.6")
        self.assertEqual(len(keys.find_elements("css selector", ".key")), 2)
        # Between them, as the program blends them.
        self.run_script("const at = document.querySelector('.keys input[type=range]'); at.value = 2; at.dispatchEvent(new Event('change'))")
        self.wait_until(lambda: self.state()["recipe"]["detail"] not in ("0.2", "0.6"), "the frame between")
        self.assertEqual(float(self.state()["recipe"]["detail"]), 0.4)
        self.settle()
        keys.find_element("css selector", ".key").click()
        self.wait_until(lambda: self.state()["recipe"] == first, "the key")
        self.button("Play").click()
        self.wait_until(lambda: self.finds(".keys") and self.button("Play").is_enabled() and self.state()["recipe"]["detail"] == "0.6", "the end")
        self.button("Copy the command").click()
        self.wait_until(lambda: self.find(".keys textarea").is_displayed(), "the command")
        words = shlex.split(self.find(".keys textarea").get_property("value"))
        self.assertEqual(words[:4], ["juliavdb", "plan", "frames", "s.obj"])
        self.assertEqual(words[words.index("--frames") + 1], "1-3")
        self.assertEqual([word for word in words if "@" in word], ["detail@1=0.2", "detail@3=0.6"])
        self.assertEqual(self.find(".keys .note").get_attribute("class"), "note")
        # What the program refuses is said beside the buttons.
        keys.find_elements("css selector", ".kept-remove")[1].click()
        set_key(3, detail="0.2")
        self.button("Copy the command").click()
        self.wait_until(lambda: "all keys have the same look" in self.find(".keys .note").text, "the refusal")
        self.driver.get_log("browser")  # a refused request is told there

    # ---------------------------------------------------------------------------------------------- the controls

    # Promise of explore.md: "What matters first is open at the top"; every other option is found by typing; the shelf shows each
    #   texture "on your own target"
    def test_what_matters_first_is_first(self):
        self.open_page()
        self.settle()
        labels = [one.text for one in self.finds(".control label") if one.is_displayed()]
        self.assertEqual(labels[:6], ["Seed", "Frequency", "Grain", "Detail", "Outward", "Colour"])
        tiles = self.finds(".tile")
        self.assertEqual(tiles[0].text, "random")
        self.assertEqual(len(tiles), 11)
        self.assertTrue(self.run_script("return [...document.querySelectorAll('.tile img')].every((one) => one.naturalWidth > 0)"))
        # Another seed is another scales, not other roots.
        self.button("next seed →").click()
        self.assertEqual([self.state()["recipe"].get(name) for name in ("texture", "texture-seed")], ["scales", "2"])
        # What the texture at hand cannot have does not stay behind.
        self.run_script("explore.store.change((state) => { state.recipe.frequency = 'fine'; })")
        tiles[0].click()
        self.settle()
        self.assertNotIn("error", self.find(".status").get_attribute("class"))
        self.assertEqual(self.errors(), [])

    # Promise: The page shows a texture ...
    def test_a_grain(self):
        self.open_page()
        self.settle()
        # The controls of the grain that are shown.
        shown = lambda: {one.find_element("css selector", "label").text: one for one in self.finds(".control[data-name^=grain]")  # noqa: E731
                         if one.is_displayed()}
        picture = lambda: self.driver.execute_async_script("explore.render(40, 40).then(arguments[0])")  # noqa: E731

        def choose(value):
            select = shown()["Grain"].find_element("css selector", "select")
            self.run_script("arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('change'))", select, value)
            self.settle()
            self.assertNotIn("error", self.find(".status").get_attribute("class"))

        self.assertEqual(list(shown()), ["Grain"])
        self.run_script("explore.store.change((state) => { state.recipe['texture-translate'] = '0.1,0,0'; })")
        without = picture()
        choose("along")
        # A texture that follows a grain cannot be moved.
        self.assertEqual([self.state()["recipe"].get(name) for name in ("grain", "texture-translate")], ["along", None])
        self.assertEqual(list(shown()), ["Grain", "Turn of the grain"])
        self.assertTrue(self.run_script("return Boolean(explore.scene().grain)"))
        along = picture()
        self.assertNotEqual(along, without)
        # Another scale is another scene, which the live picture waits for.
        self.run_script("explore.store.change((state) => { state.recipe['texture-scale'] = '2'; })")
        self.assertEqual(picture(), along)
        self.settle()
        self.assertNotEqual(picture(), along)
        self.show_sixteen("Turn of the grain")
        looks = self.looks()
        self.assertEqual([looks[0][1]["grain-turn"], looks[15][1]["grain-turn"]], ["-90", "90"])
        self.assertGreaterEqual(len({seen for _, _, seen in looks}), 15)
        self.choice(4).click()
        self.settle()
        self.assertEqual(self.state()["recipe"]["grain-turn"], looks[4][0])
        choose("own")
        self.assertEqual(self.state()["recipe"]["grain"], "0,1,0")
        self.assertEqual(list(shown()), ["Grain", "Its directions", "Turn of the grain"])
        choose("none")
        self.assertEqual([self.state()["recipe"].get(name) for name in ("grain", "grain-turn")], [None, None])
        # Random roots follow no grain.
        choose("around")
        self.finds(".tile")[0].click()
        self.settle()
        self.assertNotIn("error", self.find(".status").get_attribute("class"))
        self.assertNotIn("grain", self.state()["recipe"])
        self.assertEqual(list(shown()), [])
        self.assertEqual(self.errors(), [])

    # Promise of explore.md: "What the program refuses is said beside its control, in its own words"
    def test_what_is_wrong_is_answered_beside_its_control(self):
        self.open_page()
        self.settle()
        beside = lambda: self.run_script("return [...document.querySelectorAll('.control-error')].map((one) => [one.textContent, "  # noqa: E731
                                         "(one.previousElementSibling.dataset.name ?? one.previousElementSibling.firstElementChild.dataset.name)])")
        for change, option, words in (("state.look.options.material = 'brnze'", "material", "did you mean 'bronze'?"),
                                      ("state.look.options.background = 'red'", "background", "--background is 'red'"),
                                      ("state.recipe.colour = 'trap:inferno:0.9:0.1'", "colour", "from a lower to a higher number"),
                                      ("state.recipe.colour = 'trap:inferno:0.5:0.5'", "colour", "from a lower to a higher number"),
                                      ("state.recipe.colour = 'trap:infrno'", "colour", "did you mean 'inferno'?"),
                                      ("state.recipe.detail = '2'", "detail", "--detail")):
            self.run_script(f"explore.store.change((state) => {{ {change}; }})")
            self.wait_until(beside, f"words about {change}")
            ((said, place),) = beside()
            self.assertIn(words, said)
            self.assertEqual(place, option)
            self.button("Undo").click()
            self.wait_until(lambda: not beside(), "the end of it")
        self.driver.get_log("browser")  # refused requests are told there

    # Promise: "A gradient runs over the numbers ..."
    def test_a_range_and_a_ramp_of_ones_own(self):
        self.open_page()
        self.settle()
        self.run_script("explore.store.change((state) => { state.recipe.colour = 'trap'; })")
        self.settle()
        ends = lambda: self.run_script("return [...document.querySelectorAll('.pair input')].map((one) => [one.value, one.placeholder])")  # noqa: E731
        self.wait_until(lambda: ends()[0][1] != "", "the range that occurs")
        (_, low), (_, high) = ends()
        self.assertLess(float(low), float(high))
        self.run_script("const end = document.querySelectorAll('.pair input')[1]; end.value = 0.9; end.dispatchEvent(new Event('change'))")
        self.assertEqual(self.state()["recipe"]["colour"], f"trap:viridis:{low}:0.9")
        self.run_script("explore.store.change((state) => { state.recipe.colour = 'trap:#102030,#ffffff'; })")
        self.settle()
        self.assertEqual([one.get_property("value") for one in self.finds("[data-name=colour] input[type=text]") if one.is_displayed()], ["#102030,#ffffff"])
        self.assertEqual(self.errors(), [])

    # Promise: "*Mesh preview* shows the mesh ..."
    def test_the_mesh_and_what_was_made_are_shown(self):
        self.open_page()
        self.settle()
        self.run_script("explore.store.change((state) => { state.look.options = { material: 'jade' }; });"
                        "document.getElementById('make-resolution').value = 20; document.getElementById('make-ply').click()")
        self.settle()
        self.button("Mesh preview").click()
        self.wait_until(lambda: self.find("img.exact").is_displayed(), "the mesh")
        self.assertIn("This is the mesh at resolution 20", self.status())
        mesh = self.fetched(self.find("img.exact").get_attribute("src"))
        self.button("Make").click()
        self.wait_until(lambda: self.finds(".jobs .made"), "the picture of what was made")
        self.button("Show").click()
        self.wait_until(lambda: "as it was made" in self.status() and self.find("img.exact").is_displayed(), "what was made")
        self.assertEqual(self.fetched(self.find("img.exact").get_attribute("src")), mesh)
        self.button("Exact picture").click()
        self.wait_until(lambda: "exact picture" in self.status() and self.find("img.exact").is_displayed(), "the exact picture")
        self.assertNotEqual(self.fetched(self.find("img.exact").get_attribute("src")), mesh)
        self.button("Copy picture command").click()
        self.wait_until(lambda: "render --field" in self.find(".files textarea").get_property("value"), "the command")
        self.assertIn("--material jade", self.find(".files textarea").get_property("value"))
        self.assertEqual(self.errors(), [])

    # Promise: "What matters first is open ..."
    def test_a_control_is_found_by_typing(self):
        self.open_page()
        self.settle()
        labels = "return [...document.querySelectorAll('.controls .control label')].filter((one) => one.checkVisibility())"
        shown = lambda: self.run_script(f"{labels}.map((one) => one.innerText)")  # noqa: E731
        before, field = shown(), self.find(".finder input")
        field.send_keys("mask")
        self.assertIn("Mask", shown())
        self.assertNotIn("Colour", shown())
        self.assertLess(len(shown()), 12)
        field.send_keys(" nosuch")
        self.assertEqual(shown(), [])
        self.assertEqual(self.find(".finder .note").text, "No control of this map has these words.")
        field.send_keys("\ue00c")  # Escape
        self.assertEqual(shown(), before)
        # By the name of the option, in any group; not those with detail, elsewhere on the page, or on a shelf.
        names, unfound = self.driver.execute_async_script("""
            const done = arguments[1], field = document.querySelector(".finder input");
            fetch("start").then((answer) => answer.json()).then(({ options }) => {
              const names = options.filter((one) => one.maps.includes("shape-modulus") && one.group !== "target" &&
                !arguments[0].includes(one.name)).map((one) => one.name);
              done([names, names.filter((name) => {
                field.value = name;
                field.dispatchEvent(new Event("input"));
                return ![...document.querySelectorAll(".control")].some((one) => one.dataset.name === name &&
                  (!one.closest(".unfound") || one.closest("[hidden]")));
              })]);
            });""", ["alpha", "beta", "resolution", "box", "map", "texture"])
        self.assertGreater(len(names), 40)
        self.assertEqual(unfound, [])
        self.assertEqual(self.errors(), [])

    # Promise: "What matters first is open ..."
    def test_the_shelf_shows_the_target(self):
        pictures = "return [...document.querySelectorAll('.tile img')].filter((one) => one.dataset.own).map((one) => one.src)"
        self.driver.get(self.page.url)
        self.wait_until(lambda: len(self.run_script(pictures)) == 11, "the pictures of the shelf")
        first = self.run_script(pictures)
        self.assertEqual(len(set(first)), 11)
        self.driver.refresh()
        self.wait_until(lambda: len(self.run_script(pictures)) == 11, "the pictures of the shelf")
        self.assertEqual(self.run_script(pictures), first)
        self.write("m.obj", harness.obj(harness.snowman()))
        with Server(self.folder, "m.obj", "--sdf-resolution", "40", "--resolution", "30", "--detail", "0.4") as other:
            self.driver.get(other.url)
            self.wait_until(lambda: len(self.run_script(pictures)) == 11, "the pictures of the shelf")
            self.assertEqual(set(self.run_script(pictures)) & set(first), set())
        self.assertEqual(self.errors(), [])

    # Promise: "*Beside the target*", "*Drag ..."
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
        self.run_script("for (const part of document.querySelectorAll('.group')) part.open = true;")
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

    # Promise of explore.md#the-picture: "*Beside the target*", "*Drag the origin in the picture*", and double-clicks that set a
    #   control back
    def test_beside_the_target(self):
        self.open_page()
        self.settle()
        self.button("Beside the target").click()
        self.wait_until(lambda: self.finds(".target canvas") and self.finds(".target canvas")[0].is_displayed(), "the target")
        self.wait_until(lambda: self.colours(".target canvas") > 50, "the target's picture")
        self.assertEqual(self.errors(), [])

    # Promise: An exported page is one file ...
    def test_the_exported_page_from_a_file(self):
        self.ok("explore", "s.obj", "--sdf-resolution", "40", "--detail", "0.4", "--export", "look.html")
        self.page.kill()
        self.driver.get(self.path("look.html").as_uri())
        self.wait_until(lambda: self.finds("#picture"), "the canvas")
        self.wait_until(lambda: self.colours() > 50, "the fractal")
        self.assertEqual(self.errors(), [])


if __name__ == "__main__":
    browser.main()

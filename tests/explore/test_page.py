#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The live picture of the page: it is that of the program's own renderer, and every control changes it. The pages are
exported ones, which need no server."""

import math

import browser
from browser import harness

SIDE = 72  # pixels: software draws some thousand a second
TORUS = ("s.obj", "--sdf-resolution", "40", "--resolution", "30", "--iterations", "3")


class Page(browser.BrowserTest):
    # A picture that is hardly there: render() makes its own.
    WIDTH, HEIGHT, SCALE = 500, 150, 0.2

    def show(self, *options, address=""):
        """Opens the exported page of a look."""
        self.write("s.obj", harness.obj(harness.torus(around=24, across=12)))
        self.ok("explore", *options, "--export", "look.html", "--progress", "none")
        self.driver.get(self.path("look.html").as_uri() + address)
        self.wait_for_page()

    def wait_for_page(self):
        self.wait_until(lambda: self.run_script("return Boolean(window.explore)"), "the page")
        self.run_script("explore.store.change((state) => { state.look.samples = 1; })")

    def picture(self):
        """Red, green, blue and coverage of the pixels, from the lowest row up."""
        return self.driver.execute_async_script(
            "const done = arguments[1]; explore.render(arguments[0], arguments[0]).then(done);", SIDE)

    def state(self):
        return self.run_script("return structuredClone(explore.store.state)")

    # ---------------------------------------------------------------------------- the same as the exact picture

    def silhouettes(self, *options):
        """How far the silhouettes of the page and of `juliavdb render --field` agree: the share of what either has
        that both have."""
        self.show(*options)
        coverage = self.picture()[3::4]
        page = {(x, SIDE - 1 - y) for y in range(SIDE) for x in range(SIDE) if coverage[y * SIDE + x] >= 0.5}
        self.ok("render", "--field", *options, "--size", f"{SIDE}x{SIDE}", "--samples", "1", "--colour", "clay",
                "-o", "exact.png")
        # The background is grey, and clay is not.
        exact = {(x, y) for y, row in enumerate(harness.read_png(self.bytes("exact.png"))) for x, pixel in enumerate(row)
                 if pixel[0] - pixel[2] > 8}
        self.assertGreater(len(exact), SIDE * SIDE / 20)
        self.assertEqual(self.errors(), [])
        return len(page & exact) / len(page | exact)

    # Promise of explore.md: The page's picture agrees with the exact one "to more than 0.99", for every kind of map
    def test_the_shape_of_a_target(self):
        self.assertGreaterEqual(self.silhouettes(*TORUS, "--detail", "0.5"), 0.97)

    def test_random_roots_another_axis_and_a_slice(self):
        self.assertGreaterEqual(self.silhouettes(*TORUS, "--texture-seed", "3", "--drop-axis", "j", "--slice", "0.1"), 0.97)

    # Promise of explore.md: The page shows a texture along a grain as the program does: "the page reads all of them, also for
    #   small pictures and in an exported page"
    def test_a_texture_along_a_grain(self):
        self.assertGreaterEqual(self.silhouettes(*TORUS, "--texture", "fur", "--grain", "along"), 0.97)
        self.assertGreaterEqual(self.silhouettes(*TORUS, "--texture", "shells", "--grain", "0,1,0", "--grain-turn", "30",
                                                 "--drop-axis", "i", "--detail", "0.5"), 0.97)

    # Promise: The page's picture agrees ...
    def test_a_rational_map(self):
        top = [(0.1 * i, 0.05 * (i % 3), 0.1, 0.0, 3 + 0.5 * i) for i in range(4)]
        bottom = [(0.9, 0.3 * i, -0.4, 0.1, 2.5) for i in range(3)]
        self.write("map.json", harness.rational_json(top, bottom, 6))
        self.assertGreaterEqual(self.silhouettes("--map", "rational", "--rational", "map.json",
                                                 "--box=-1,-1,-1,1,1,1"), 0.97)

    # Promise: The page's picture agrees ...
    def test_a_map_of_331_roots(self):
        # As many as the largest of [Kim15] has, around the shape of a ball.
        roots = [(0.6 * math.cos(2.4 * i) * math.sqrt(1 - (i / 165 - 1) ** 2), 0.6 * math.sin(2.4 * i) *
                  math.sqrt(1 - (i / 165 - 1) ** 2), 0.6 * (i / 165 - 1), 0.0, 0.2 + 0.1 * (i % 4)) for i in range(331)]
        self.write("map.json", harness.rational_json(roots, [], 12))
        self.assertGreaterEqual(self.silhouettes("--map", "rational", "--rational", "map.json", "--iterations", "3",
                                                 "--box=-1,-1,-1,1,1,1"), 0.97)

    # Promise: The page's picture agrees ...
    def test_a_cross_map(self):
        self.assertGreaterEqual(self.silhouettes("--map", "cross", "--iterations", "3"), 0.97)

    # Promise: The page's picture agrees ...
    def test_a_pair_of_the_users(self):
        self.assertGreaterEqual(self.silhouettes("--map", "cross", "--f", "x^2, y*y, z>0 ? z*z : -z^2", "--g",
                                                 "cos(x), cos(y), cos(z)", "--scheme", "5", "--iterations", "3"), 0.97)

    # Promise: The page's picture agrees ...
    def test_a_mandelbulb_and_a_quadratic_map(self):
        self.assertGreaterEqual(self.silhouettes("--map", "mandelbulb", "--theta", "pole", "--iterations", "3"), 0.97)
        self.assertGreaterEqual(self.silhouettes("--map", "quadratic", "--c=-0.2,0.6,0.2,0.2"), 0.97)

    # Promise of explore.md: "The light is that of the exact picture", "less than 12 of 255 from that of the exact picture"
    def test_the_light_and_the_colours_are_those_of_the_exact_picture(self):
        """The mean colour over the set, as sRGB, for each material and in other light; and a gradient over its range."""
        self.show(*TORUS, "--detail", "0.2")

        def difference(options, colour):
            self.run_script("explore.store.change((state) => { state.look.options = arguments[0]; "
                            "if (arguments[1] === 'clay') delete state.recipe.colour; else state.recipe.colour = arguments[1]; })", options, colour)
            seen = self.picture()
            words = [f"--{name}={value}" for name, value in options.items()]
            self.ok("render", "--field", *TORUS, "--detail", "0.2", *words, "--colour", colour, "--size", f"{SIDE}x{SIDE}", "--samples", "1", "-o", "exact.png")
            rows, sums, count = harness.read_png(self.bytes("exact.png")), [0.0] * 3, 0
            for y in range(SIDE):
                for x in range(SIDE):
                    at = 4 * (y * SIDE + x)
                    if seen[at + 3] < 0.5:
                        continue
                    count += 1
                    for c in range(3):
                        linear = min(1.0, max(0.0, seen[at + c]))
                        code = 12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055
                        sums[c] += 255 * code - rows[SIDE - 1 - y][x][c]
            self.assertGreater(count, 500)
            return max(abs(one) / count for one in sums)

        for options, colour in (({}, "clay"), ({"material": "porcelain"}, "clay"), ({"material": "slate", "light": "60,25"}, "clay"),
                                ({"material": "bronze", "sky": "2"}, "clay"), ({"exposure": "-1"}, "clay"), ({}, "direction"),
                                ({}, "trap"), ({}, "iterations"), ({}, "depth")):
            self.assertLess(difference(options, colour), 12, (options, colour))
        self.assertEqual(self.errors(), [])

    # --------------------------------------------------------------------------------------------- the controls

    # Promise: The page has "a slider for every ..."
    def test_every_control_changes_the_picture_and_can_be_undone(self):
        self.show(*TORUS)
        first, state = self.picture(), self.state()
        changed = []
        for i in range(len(self.finds(".control"))):
            name = self.run_script("""
                const control = document.querySelectorAll(".control")[arguments[0]];
                const input = control.querySelector("input[type=range], select, input[type=checkbox]");
                const name = control.querySelector("label").textContent;
                if (control.closest("[hidden]") || !input || name === "Rays a pixel") return null;
                if (input.type === "range") input.value = Number(input.min) + 0.8 * (input.max - input.min);
                else if (input.tagName === "SELECT") input.selectedIndex = Math.min(2, input.options.length - 1);
                else input.checked = !input.checked;
                input.dispatchEvent(new Event("change"));
                return name;""", i)
            if name is None:
                continue
            self.assertNotEqual(self.state(), state, name)
            self.assertNotEqual(self.picture(), first, name)
            self.button("Undo").click()
            self.assertEqual(self.state(), state, name)
            changed.append(name)
        self.assertEqual(self.picture(), first)
        for name in ("Scale of the texture", "Iterations", "Slice", "Colour", "Material", "Light from the side", "Light from above", "Sky", "Exposure", "Ground",
                     "Background", "Cut open along"):
            self.assertIn(name, changed)
        self.assertEqual(self.errors(), [])

    # Promise of explore.md: "The address always holds the whole look"
    def test_undo_redo_and_an_address_that_is_a_look(self):
        self.show(*TORUS)
        first = self.state()
        self.run_script("explore.store.change((state) => { state.recipe.slice = '0.2'; })")
        second = self.state()
        self.run_script("explore.store.change((state) => { state.look.clip.axis = 'z'; })")
        third, picture, address = self.state(), self.picture(), self.run_script("return location.hash")
        for text, expected in (("Undo", second), ("Undo", first), ("Redo", second), ("Redo", third)):
            self.button(text).click()
            self.assertEqual(self.state(), expected)
        self.driver.refresh()
        self.wait_for_page()
        self.assertEqual(self.run_script("return location.hash"), address)
        self.assertEqual(self.picture(), picture)

    # Promise: "*Beside the target*", "*Drag ..."
    def test_a_double_click_sets_a_control_back(self):
        self.show("--map", "quadratic", "--c=-0.2,0.6,0.2,0.2")
        first = self.state()
        self.run_script("explore.store.change((state) => { state.recipe.iterations = '5'; })")
        label = next(one for one in self.finds(".control label") if one.text == "Iterations")
        self.run_script("arguments[0].dispatchEvent(new MouseEvent('dblclick', { bubbles: true }))", label)
        self.assertEqual(self.state(), first)

    def test_an_address_of_a_stranger_does_no_harm(self):
        for address in ("#%", "#null", "#%7B%22recipe%22%3A5%2C%22view%22%3A%7B%22eye%22%3A%5B1%2C%22x%22%5D%7D%7D",
                        "#%7B%22recipe%22%3A%7B%22slice%22%3A%22%3Cimg%20src%3Dx%20onerror%3Dalert(1)%3E%22%7D%7D"):
            self.show("--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", address=address)
            self.assertGreater(sum(self.picture()[3::4]), 100)
            self.assertEqual(self.finds("img[src=x]"), [])
        self.assertEqual(self.errors(), [])

    def test_the_camera_by_keys(self):
        self.show("--map", "quadratic", "--c=-0.2,0.6,0.2,0.2")
        before = self.state()["view"]["eye"]
        for key in ("ArrowLeft", "ArrowUp", "+"):
            self.run_script("document.getElementById('picture').dispatchEvent(new KeyboardEvent('keydown', "
                            "{key: arguments[0], bubbles: true, cancelable: true}))", key)
            now = self.state()["view"]["eye"]
            self.assertNotEqual(now, before, key)
            before = now


if __name__ == "__main__":
    browser.main()

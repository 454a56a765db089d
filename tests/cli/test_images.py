# SPDX-License-Identifier: Apache-2.0
"""Pictures: their formats, and that they show what they should where they should."""

import math

import harness
from harness import USAGE

BLACK, WHITE = (0, 0, 0), (255, 255, 255)
LOW = ("--resolution", 24, "--sdf-resolution", 48)


class Pictures(harness.CliTest):

    def setUp(self):
        super().setUp()
        # Not at the origin and not of size 1; the picture shows it with 8 % of its size around.
        self.centre, self.radius = (3.0, -2.0, 5.0), 2.0
        self.write("s.obj", harness.obj(harness.sphere(3, self.radius, self.centre)))

    def test_formats(self):
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 24)
        for command in (("slice", "s.vdb", "--field", "grid", "--size", 50), ("render", "s.vdb", "--size", "50x50")):
            self.ok(*command, "-o", "x.png")
            self.assertEqual(harness.png_size(self.bytes("x.png")), (50, 50))
            harness.read_png(self.bytes("x.png"))
            self.ok(*command, "-o", "x.exr")
            self.assertEqual(self.bytes("x.exr")[:4], bytes([0x76, 0x2F, 0x31, 0x01]))
            self.ok(*command, "-o", "UPPER.PNG")
            self.assertEqual(self.bytes("UPPER.PNG"), self.bytes("x.png"))

    def test_every_field_on_every_axis(self):
        self.ok("fractal", "s.obj", *LOW, "-o", "f.vdb")
        for field in ("phi", "e", "f", "membership", "versor", "grid"):
            for axis in "xyz":
                with self.subTest(field=field, axis=axis):
                    self.ok("slice", "f.vdb", "-o", "x.png", "--field", field, "--axis", axis, "--size", 24)
                    rows = harness.read_png(self.bytes("x.png"))
                    self.assertGreater(len({pixel for row in rows for pixel in row}), 1, "the picture shows nothing")
                    self.path("x.png").unlink()

    def test_membership_of_a_ball(self):
        """alpha 300 is nearly smooth: |phi| is at most ln(20) / 300 = 1 % of the longest side in the shell."""
        size = 80
        extent = 2 * self.radius * 1.16
        pixel = extent / size
        shell = 2 * self.radius * math.log(20) / 300 + 0.01 * self.radius + pixel  # and the facets' sagitta
        for axis, right, up, mirrored in (("z", 0, 1, 1), ("x", 2, 1, -1), ("y", 0, 2, 1)):
            for offset in (0, 1.2):
                with self.subTest(axis=axis, offset=offset):
                    k = "xyz".index(axis)
                    self.ok("slice", "s.obj", *LOW, "--alpha", 300, "--axis", axis, "--position",
                            self.centre[k] + offset, "--size", size, "-o", "x.png")
                    rows = harness.read_png(self.bytes("x.png"))
                    self.assertEqual((len(rows[0]), len(rows)), (size, size))
                    for y, row in enumerate(rows):
                        for x, value in enumerate(row):
                            a, b = (x + 0.5 - size / 2) * pixel, (y + 0.5 - size / 2) * pixel
                            distance = math.hypot(a, b, offset) - self.radius
                            if abs(distance) > shell:
                                self.assertEqual(value, BLACK if distance < 0 else WHITE, (x, y))

    def test_which_way_is_up(self):
        """Y is up, and X to the right in a picture across Z."""
        self.write("cone.obj", "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0.8 2 0\nf 1 2 3\nf 1 3 4\n"
                   "f 1 5 2\nf 2 5 3\nf 3 5 4\nf 4 5 1\n")
        self.ok("slice", "cone.obj", *LOW, "--alpha", 300, "--size", 60, "-o", "x.png")
        rows = harness.read_png(self.bytes("x.png"))
        black = [(x, y) for y, row in enumerate(rows) for x, value in enumerate(row) if value == BLACK]
        top = min(black, key=lambda p: p[1])
        self.assertGreater(sum(y > 30 for _, y in black), sum(y < 30 for _, y in black), "the wide end is below")
        self.assertGreater(top[0], 38, "the tip leans to the right")

    def test_phi_is_blue_inside_and_red_outside(self):
        self.ok("slice", "s.obj", *LOW, "--field", "phi", "--range", 0.5, "--size", 60, "-o", "x.png")
        rows = harness.read_png(self.bytes("x.png"))
        red, _, blue = rows[30][15]
        self.assertGreater(blue, red)
        red, _, blue = rows[1][1]
        self.assertGreater(red, blue)

    def test_an_arrow_is_the_first_step(self):
        """f(q) = q q + c takes (0.3, 0.2) to (0.335, 0.605) and the far point (0.8, 0.6) to (0.565, 1.445)."""
        command = ("slice", "--map", "quadratic", "--c", "0.285,0.485,0,0", "--box=-1,-1,-1,1,1,1", "--resolution", 20, "--iterations", 40,
                   "--size", 200, "--field", "iterations")
        self.ok(*command, "-o", "plain.png")
        self.ok(*command, "--arrow", "0.3,0.2,0", "-o", "in.png")
        self.ok(*command, "--arrow", "0.8,0.6,0", "-o", "out.png")
        plain, inside, outside = (harness.read_png(self.bytes(name)) for name in ("plain.png", "in.png", "out.png"))

        def pixel(rows, x, y):
            return rows[100 - round(y * 100)][100 + round(x * 100)]
        self.assertEqual(pixel(inside, 0.3, 0.2), WHITE)
        self.assertEqual(pixel(inside, 0.331, 0.55), WHITE, "it ends where the map takes the point")
        self.assertEqual(pixel(outside, 0.8, 0.6), BLACK)
        radius = (0.335 ** 2 + 0.605 ** 2) ** 0.5
        for x, y in ((-radius, 0), (0, -radius)):
            ring = {tuple(pixel(inside, x + dx, y + dy)) for dx in (-0.01, 0, 0.01) for dy in (-0.01, 0, 0.01)}
            self.assertNotEqual(ring, {tuple(pixel(plain, x + dx, y + dy)) for dx in (-0.01, 0, 0.01) for dy in (-0.01, 0, 0.01)})
        self.refused(USAGE, "slice", "--map", "cross", "--arrow", "0,0,0", "-o", "x.png", mentions="--arrow")
        self.refused(USAGE, *command, "--arrow", "0,0", "-o", "x.png", mentions="--arrow")

    def test_the_exponent_is_the_first_log_modulus(self):
        """With a target the grid E is shown, and without one the map is asked; both are ln |f|."""
        self.ok("slice", "s.obj", *LOW, "--alpha", 12, "--field", "f", "--iterations", 1, "--size", 60, "--range", 1, "-o", "f.png")
        self.ok("slice", "s.obj", *LOW, "--alpha", 12, "--field", "e", "--size", 60, "--range", 1, "-o", "e.png")
        differences = [abs(x - y) for f, e in zip(harness.read_png(self.bytes("f.png")), harness.read_png(self.bytes("e.png")))
                       for a, b in zip(f, e) for x, y in zip(a, b)]
        self.assertLess(sum(differences) / len(differences), 2)
        quadratic = ("slice", "--map", "quadratic", "--c", "0.2,0,0,0", "--box=-2,-2,-2,2,2,2", "--resolution", 20, "--size", 40,
                     "--escape", 50, "--range", 3)
        self.ok(*quadratic, "--field", "e", "-o", "e.png")
        self.ok(*quadratic, "--field", "e", "--iterations", 2, "-o", "e2.png")
        self.assertEqual(self.bytes("e.png"), self.bytes("e2.png"))

    def test_a_fractal_brings_its_recipe(self):
        self.ok("fractal", "s.obj", *LOW, "--alpha", 12, "-o", "f.vdb")
        self.ok("slice", "f.vdb", "--size", 40, "-o", "recipe.png")
        self.ok("slice", "s.obj", *LOW, "--alpha", 12, "--size", 40, "-o", "given.png")
        self.ok("slice", "f.vdb", "--alpha", 200, "--size", 40, "-o", "other.png")
        self.ok("slice", "s.obj", *LOW, "--alpha", 200, "--size", 40, "-o", "given200.png")
        self.assertEqual(self.bytes("recipe.png"), self.bytes("given.png"))
        self.assertEqual(self.bytes("other.png"), self.bytes("given200.png"))
        self.assertNotEqual(self.bytes("other.png"), self.bytes("recipe.png"))

    def test_render_shows_a_ball(self):
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 32)
        self.ok("render", "s.vdb", "--size", "48x32", "-o", "x.png")
        rows = harness.read_png(self.bytes("x.png"))
        self.assertEqual((len(rows[0]), len(rows)), (48, 32))
        self.assertNotEqual(rows[16][24], rows[0][0], "the middle shows the ball, the corner does not")
        self.assertEqual(rows[0][0], rows[0][47])
        pictures = []
        for zoom in (1, 0.4, 0.01):
            self.ok("render", "s.vdb", "--size", "48x32", "--zoom", zoom, "-o", "x.png")
            pictures.append(harness.read_png(self.bytes("x.png")))
        background = pictures.pop()
        covered = [sum(p != q for r, s in zip(rows, background) for p, q in zip(r, s)) for rows in pictures]
        self.assertGreater(covered[0], 2 * covered[1], "a smaller zoom shows a smaller ball")

    def test_what_there_is_not(self):
        self.refused(USAGE, "slice", "--map", "quadratic", "--field", "phi", "-o", "x.png", mentions="phi")


if __name__ == "__main__":
    harness.main()

# SPDX-License-Identifier: Apache-2.0
"""Colours and other attributes: what the files hold of them, and that pictures of the set have the same colours."""

import re
import struct

import harness
from harness import BAD_DATA, USAGE

SMALL = ("--sdf-resolution", 40, "--resolution", 30)
PICTURE = ("--size", "60x60", "--samples", 1)


def header(data):
    """The properties of a PLY's vertices: (type, name)."""
    lines = data[:data.index(b"end_header")].decode().splitlines()
    return [tuple(line.split()[1:]) for line in lines if line.startswith("property") and "list" not in line]


def points(data):
    """The vertices of a PLY, each as a dict of its numbers by their names."""
    columns = header(data)
    layout = struct.Struct("<" + "".join({"float": "f", "double": "d", "uchar": "B"}[kind] for kind, _ in columns))
    count, = re.findall(rb"element vertex (\d+)", data[:data.index(b"end_header")])
    body = data[data.index(b"end_header\n") + len(b"end_header\n"):][:int(count) * layout.size]
    return [dict(zip((name for _, name in columns), row)) for row in layout.iter_unpack(body)]


class Attributes(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(3, 2.0, (3, -2, 5))))

    # Promise of attributes.md: "The program says what a file has no room for"
    def test_a_ply_has_a_property_of_each(self):
        self.ok("fractal", "s.obj", *SMALL, "--attributes", "direction,Cd,trap", "--mesh", "f.ply")
        self.assertEqual(header(self.bytes("f.ply")), [
            ("float", "x"), ("float", "y"), ("float", "z"), ("float", "nx"), ("float", "ny"), ("float", "nz"),
            ("float", "direction_x"), ("float", "direction_y"), ("float", "direction_z"),
            ("uchar", "red"), ("uchar", "green"), ("uchar", "blue"), ("float", "trap")])
        self.ok("fractal", "s.obj", *SMALL, "--mesh", "plain.ply")
        self.assertEqual(len(header(self.bytes("plain.ply"))), 6)

    # Promise: "The program says what a file ..."
    def test_what_a_format_cannot_hold_is_said(self):
        words = ("fractal", "s.obj", *SMALL, "--attributes", "Cd,trap,depth")
        said = self.ok(*words, "--mesh", "f.stl")
        self.assertIn("note: f.stl holds no attributes", said)
        said = self.ok(*words, "--mesh", "f.obj")
        self.assertIn("note: f.obj holds no trap, depth", said)
        self.assertEqual({len(line.split()) for line in self.bytes("f.obj").decode().splitlines()
                          if line.startswith("v ")}, {7})
        self.assertNotIn("note:", self.ok(*words, "--mesh", "f.ply"))

    # Promise: `mesh` makes the mesh of a fractal's ...
    def test_a_mesh_made_from_a_vdb_has_its_attributes(self):
        self.ok("fractal", "s.obj", *SMALL, "--colour", "trap:magma", "-o", "f.vdb", "--mesh", "one.ply")
        self.ok("mesh", "f.vdb", "-o", "two.ply")
        self.assertEqual(header(self.bytes("one.ply")), header(self.bytes("two.ply")))
        self.assertEqual(self.bytes("one.ply").split(b"end_header")[1], self.bytes("two.ply").split(b"end_header")[1])

    # Promise of attributes.md: A picture of a file "has the same colours" as the file
    def test_pictures_have_the_colours_of_the_recipe(self):
        self.ok("fractal", "s.obj", *SMALL, "--colour", "trap:magma", "-o", "f.vdb")
        self.ok("render", "--field", "f.vdb", *PICTURE, "-o", "recipe.png")
        self.ok("render", "--field", "s.obj", *SMALL, "--colour", "trap:magma", *PICTURE, "-o", "given.png")
        self.ok("render", "--field", "f.vdb", "--colour", "clay", *PICTURE, "-o", "other.png")
        self.ok("render", "--field", "s.obj", *SMALL, *PICTURE, "-o", "usual.png")
        self.assertEqual(self.bytes("recipe.png"), self.bytes("given.png"))
        self.assertEqual(self.bytes("other.png"), self.bytes("usual.png"))
        self.assertNotEqual(self.bytes("recipe.png"), self.bytes("usual.png"))

    # Promise: A picture of a file "has the same ..."
    # Promise: `--colour` "adds `Cd` to the attributes"; "The name ..."
    def test_a_picture_as_gradient(self):
        self.ok("slice", "s.obj", *SMALL, "--size", 16, "-o", "ramp.png")
        self.ok("fractal", "s.obj", *SMALL, "--colour", "depth:ramp.png", "-o", "f.vdb")
        self.ok("render", "--field", "f.vdb", *PICTURE, "-o", "a.png")
        self.ok("slice", "s.obj", *SMALL, "--size", 17, "-o", "ramp.png")
        self.refused(BAD_DATA, "render", "--field", "f.vdb", *PICTURE, "-o", "b.png", mentions="ramp.png")

    # Promise: "No two grids share a name"
    # Promise: "`plan tiles` and `merge` ..."
    def test_bad_options(self):
        self.all_refused(USAGE, [("fractal", "s.obj", *option, "-o", "f.vdb") for option in (
            ("--attributes", "colour"), ("--attributes", "trap,trap"), ("--colour", "pink"), ("--colour", "clay:magma"),
            ("--colour", "trap:jet"), ("--colour", "clay:0:1"), ("--colour", "trap:"), ("--colour", "trap:magma:"),
            ("--colour", "trap:000000"), ("--colour", "trap:000000,12345g"), ("--colour", "trap:000000,"),
            ("--transfer", "uv,uv"), ("--transfer", "surface"),
            ("--attributes", "iterations", "--grids", "surface,iterations"))])
        self.refused(USAGE, "fractal", "--map", "mandelbulb", "--attributes", "depth", "-o", "f.vdb", mentions="no target")
        self.refused(BAD_DATA, "fractal", "s.obj", "--transfer", "uv", "-o", "f.vdb", mentions="texture coordinates")
        self.refused(BAD_DATA, "fractal", "s.obj", "--transfer", "wet", "-o", "f.vdb", mentions="wet")
        self.refused(USAGE, "plan", "tiles", "s.obj", *SMALL, "--attributes", "mask", "-o", "farm", mentions="mask")
        self.refused(USAGE, "render", "s.obj", "--colour", "trap", "-o", "x.png", mentions="clay")

    def test_bad_colours_are_refused_with_a_way_out(self):
        def refused(colour, *mentions):
            self.refused(USAGE, "fractal", "s.obj", "--colour", colour, "-o", "f.vdb", mentions=(f"'{colour}'", *mentions))
        refused("trap:infern", "viridis, magma, inferno", "did you mean 'inferno'?")
        refused("trapp", "did you mean 'trap'?")
        for text in ("trap:magma:0.5:0.5", "trap:0.5:0.5", "trap:magma:0.9:0.1", "depth:1:-1", "trap:0:inf", "trap:nan:1"):
            refused(text, "LOW:HIGH", "lower to a higher")
        for text in ("trap:magma:0.5", "trap:0.5", "trap:magma:0.5:x", "trap:magma:x:0.5"):
            refused(text, "LOW:HIGH")


class Ranges(harness.CliTest):
    """Which numbers get the ends of a gradient."""

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(3, 2.0, (3, -2, 5))))

    def greys(self, colour, *more):
        self.ok("fractal", "s.obj", *SMALL, "--attributes", "Cd,trap,depth,iterations", "--colour", colour, *more, "--mesh", "g.ply")
        return points(self.bytes("g.ply"))

    # Promise of attributes.md: The first number of a range gets the first colour of the gradient, the second one the last; a list
    #   of colours is a ramp
    def test_a_range_has_the_ends_of_the_gradient(self):
        for name, low, high in (("trap", 0.3, 0.6), ("depth", -0.2, 0.1), ("iterations", 1.2, 2.5)):
            for point in self.greys(f"{name}:grey:{low}:{high}"):
                wanted = 255 * min(max((point[name] - low) / (high - low), 0), 1)
                self.assertAlmostEqual(point["red"], wanted, delta=1)
            self.assertEqual(self.greys(f"{name}:000000,ffffff:{low}:{high}"), self.greys(f"{name}:grey:{low}:{high}"))
        self.assertEqual(self.greys("trap:viridis:0:1"), self.greys("trap:0:1"))

    # Promise: The first number of a range ...
    def test_a_list_of_colours_is_a_ramp(self):
        for point in self.greys("trap:#ff0000,00ff00,#0000ff:0.2:0.8"):
            place = 2 * min(max((point["trap"] - 0.2) / 0.6, 0), 1)
            for name, wanted in (("red", 1 - place), ("green", 1 - abs(place - 1)), ("blue", place - 1)):
                self.assertAlmostEqual(point[name], 255 * max(wanted, 0), delta=1)

    def test_without_a_range_the_colours_are_spread_over_the_numbers(self):
        for name in ("trap", "depth"):
            greys = sorted(point["red"] for point in self.greys(f"{name}:grey"))
            self.assertLess(greys[len(greys) // 10], 110)
            self.assertGreater(greys[-len(greys) // 10], 145)
            self.assertLess(greys.count(0) + greys.count(255), len(greys) / 5)


if __name__ == "__main__":
    harness.main()

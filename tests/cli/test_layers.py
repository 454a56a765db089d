#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Versors that are formulas, fields of directions, layers and symmetric: what they are, the laws of every other fractal
(skipped as exhaustive, tiles as one run, any threads, recipes again), and the refusal of what gives no direction."""
import math
import unittest

import pyopenvdb

import harness
import test_painting
from harness import BAD_DATA, NO_INPUT, USAGE

LOW = harness.TextureTest.LOW
WORLD = ("--space", "world", "--alpha", 12, "--beta", 0.02)


def box_nodes(low, high):
    return [(x, y, z) for x in range(low, high + 1) for y in range(low, high + 1) for z in range(low, high + 1)]


def write_grids(path, voxel, grids, low=-30, high=30, keep=lambda x, y, z: True):
    """Grids by their names, each a type and a function of the place, at the nodes of a cube that keep() takes."""
    made = []
    for name, (kind, value) in grids.items():
        grid = kind()
        grid.name = name
        grid.transform = pyopenvdb.createLinearTransform(voxelSize=voxel)
        accessor = grid.getAccessor()
        for node in box_nodes(low, high):
            place = tuple(voxel * k for k in node)
            if keep(*place):
                accessor.setValueOn(node, value(*place))
        made.append(grid)
    pyopenvdb.write(str(path), grids=made)


class Layers(harness.TextureTest):

    def setUp(self):
        super().setUp()
        self.write("t.obj", harness.obj(harness.lumpy()))

    def assert_alike(self, one, other, share=0.99):
        """Meshes that differ by rounding: nearly all points of the one are points of the other."""
        near = lambda point: tuple(round(1e3 * x) for x in point)
        known = {near(point) for point in other.points}
        around = lambda p: any((p[0] + i, p[1] + j, p[2] + k) in known
                               for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1))
        same = sum(around(near(point)) for point in one.points)
        self.assertGreater(same, share * len(one.points))
        self.assertLess(abs(len(one.points) - len(other.points)), (1 - share) * len(one.points) + 1)

    def field(self):
        """A field of vectors and the same as floats, linear in the place, so that reading between the nodes is exact."""
        vector = lambda x, y, z: (0.3 + y, z - 0.1, x + 0.2)
        write_grids(self.path("f.vdb"), 0.1, {
            "v": (pyopenvdb.Vec3SGrid, vector), "s": (pyopenvdb.FloatGrid, lambda x, y, z: 1.0),
            **{name: (pyopenvdb.FloatGrid, lambda x, y, z, i=i: vector(x, y, z)[i]) for i, name in enumerate("abc")},
            "d": (pyopenvdb.FloatGrid, lambda x, y, z: x - y)})

    # What they are.

    # Promise of textures.md: A versor that is a formula or a field: its variables, "read trilinearly between the centres of its
    #   voxels", "A sparse grid, such as a band about the surface, is continued first"
    def test_a_formula_of_the_point_is_the_rational_of_the_same(self):
        """The root 0 of power 1 has the versor of q, and that of power 2 the versor of q^2."""
        squared = "expr:x*x - y*y - z*z - w*w, 2*x*y, 2*x*z, 2*x*w"
        for power, formula in ((1, "expr:x,y,z,w"), (2, squared)):
            self.write("root.json", harness.rational_json([(0, 0, 0, 0, power)]))
            for options in ((), ("--slice", 0.1), ("--texture-scale", 0.5, "--texture-translate", "0.1,-0.05,0.02")):
                with self.subTest(power=power, options=options):
                    options = ("--alpha", 8, "--precision", "double", *options)
                    self.assert_alike(self.mesh("--texture", formula, *options),
                                      self.mesh("--texture", "root.json", *options), 0.995)

    # Promise: A versor that is a formula ...
    def test_three_components_are_the_fourth_left_out(self):
        for axis, four in (("i", "y,0,-x,z+0.2"), ("j", "y,-x,0,z+0.2"), ("k", "y,-x,z+0.2,0")):
            self.assertEqual(self.points("--texture", "expr:y,-x,z+0.2", "--drop-axis", axis),
                             self.points("--texture", f"expr:{four}", "--drop-axis", axis))

    # Promise: A versor that is a formula ...
    def test_a_formula_knows_the_target(self):
        default = self.points("--texture", "expr:x,y,z")
        for formula in ("expr:nx,ny,nz+0.1", "expr:x,y,z+10*phi", "expr:cos(20*tau),sin(20*tau),0.1",
                        "expr:x,y,curvature", "expr:height-0.4,hx-0.6,hz-0.7", "expr:x, y, z, w + 0.3"):
            with self.subTest(formula=formula):
                self.assertNotEqual(self.points("--texture", formula), default)
        self.write("painted.ply", test_painting.painted_ply(harness.lumpy(), ["float weight"], lambda p: (p[0],)))
        self.ok("fractal", "painted.ply", *LOW, "--texture", "expr:weight+0.1,y,z", "--mesh", "w.ply")

    # Promise: A versor that is a formula ...
    def test_a_field_is_the_formula_of_the_same(self):
        self.field()
        same = self.mesh("--texture", "expr:0.3+y, z-0.1, x+0.2", *WORLD)
        four = self.mesh("--texture", "expr:0.3+y, z-0.1, x+0.2, x-y", *WORLD)
        for source, wanted in (("field:f.vdb:v", same), ("field:f.vdb", same), ("field:f.vdb:a,b,c", same),
                               ("field:f.vdb:a,b,c,d", four)):
            with self.subTest(source=source):
                self.assert_alike(self.mesh("--texture", source, *WORLD), wanted)

    # Promise: A versor that is a formula ...
    def test_a_sparse_field_is_filled(self):
        """A band of normals, as artists make them: what lies within the shape goes on from there."""
        shell = lambda x, y, z: 0.5 < math.hypot(x, y, z) < 1.6
        write_grids(self.path("n.vdb"), 0.1, {"n": (pyopenvdb.Vec3SGrid, lambda x, y, z: (x, y, z))}, keep=shell)
        write_grids(self.path("n2.vdb"), 0.1, {"n": (pyopenvdb.Vec3SGrid, lambda x, y, z: (4, 0, 3))}, keep=shell)
        self.mesh("--texture", "field:n.vdb:n")
        self.assert_alike(self.mesh("--texture", "field:n2.vdb:n"), self.mesh("--texture", "expr:4,0,3"), 0.999)

    # Promise of textures.md: Layers: "0 is the first alone, 1 the second alone", in all the ways of a control
    def test_layers_of_0_and_1_are_the_textures(self):
        for over in (("--texture", "thorns", "--frequency", "coarse", "--texture-seed", 3), ("--texture", "rings"),
                     ("--texture", "expr:y,-x,0.3")):
            named = [word.replace("--texture-seed", "--texture-over-seed").replace("--frequency", "--texture-over-frequency")
                     if str(word).startswith("--") and word != "--texture" else "--texture-over" if word == "--texture" else word
                     for word in map(str, over)]
            under = ("--texture", "woven", "--frequency", "fine")
            with self.subTest(over=over):
                mixed = self.points(*under, *named, "--texture-mix", 0.5)
                self.assertEqual(self.points(*under, *named), mixed)
                self.assertEqual(self.points(*under, *named, "--texture-mix", 0), self.points(*under))
                self.assertEqual(self.points(*under, *named, "--texture-mix", 1), self.points(*over))
                self.assertNotIn(mixed, (self.points(*under), self.points(*over)))

    # Promise: Layers: "0 is the first alone, 1 ..."
    def test_a_painted_mix_keeps_each_side(self):
        """Left of x = -0.5 there is one texture, and right of 0.5 the other, to the bit; between them no seam tears."""
        mix = ("--texture", "woven", "--texture-over", "coral", "--texture-mix", "x:0@0.3:1@0.7:smooth")
        # In one step a point depends on its own versor alone.
        options = ("--iterations", 2, "--alpha", 10)
        mixed, woven, coral = (self.mesh(*words, *options)
                               for words in (mix, ("--texture", "woven"), ("--texture", "coral")))
        low, high = min(p[0] for p in woven.points), max(p[0] for p in woven.points)
        left, right = low + 0.2 * (high - low), low + 0.8 * (high - low)
        side = lambda mesh, keep: sorted(p for p in mesh.points if keep(p[0]))
        self.assertEqual(side(mixed, lambda x: x < left), side(woven, lambda x: x < left))
        self.assertEqual(side(mixed, lambda x: x > right), side(coral, lambda x: x > right))
        self.assertEqual(harness.open_edges(mixed), [])

    # Promise: "A set over a target that has the symmetry has it too"
    def test_symmetry_has_an_effect_on_all(self):
        self.field()
        for versor in ("scales", "random", "rings", "expr:x+0.2,y,z", "field:f.vdb:v"):
            plain = self.points("--texture", versor)
            for symmetry in ("mirror:x", "5:y", "5:y:mirror"):
                with self.subTest(versor=versor, symmetry=symmetry):
                    self.assertNotEqual(self.points("--texture", versor, "--texture-symmetry", symmetry), plain)

    # The laws of every fractal.

    FAMILIES = (
        ("--texture", "expr:sin(9*x)+ny, cos(7*y), nz+phi"),
        ("--texture", "field:f.vdb:v", "--texture-scale", 0.3),
        ("--texture", "field:f.vdb:a,b,c,d", "--drop-axis", "j", "--slice", 0.1),
        ("--texture", "scales", "--texture-over", "thorns", "--texture-over-frequency", "fine", "--texture-mix", "expr:hx"),
        ("--texture", "rings", "--texture-over", "expr:y,-x,0.4,w", "--texture-symmetry", "3:z"),
        ("--texture", "woven", "--texture-symmetry", "6:y:mirror", "--origin-shift", "0.05,0,0"),
        ("--texture", "field:f.vdb:v", "--texture-over", "random", "--texture-mix", "y:0:1", "--texture-symmetry", "mirror:xz"),
    )

    # Promise: Formulas, fields, layers and symmetries: bounds ...
    def test_the_same_in_all_ways(self):
        self.field()
        for options in self.FAMILIES:
            with self.subTest(options=options):
                self.assert_the_same_in_all_ways(*options)

    # Promise: Formulas, fields, layers and symmetries: bounds ...
    def test_a_recipe_holds_them(self):
        self.field()
        for options in self.FAMILIES:
            with self.subTest(options=options):
                self.ok("fractal", "t.obj", *LOW, *options, "--grids", "surface,versor", "-o", "one.vdb")
                self.ok("fractal", "--config", "one.vdb", "-o", "two.vdb")
                self.assertEqual(self.bytes("one.vdb"), self.bytes("two.vdb"))
        self.ok("fractal", "--config", "one.vdb", "--texture-over", "none", "--texture-symmetry", "none", "--mesh", "plain.ply")
        self.assertEqual(harness.read_ply(self.bytes("plain.ply")).points, self.points("--texture", "field:f.vdb:v"))
        # Every file is held to what it was.
        write_grids(self.path("f.vdb"), 0.1, {"v": (pyopenvdb.Vec3SGrid, lambda x, y, z: (1, 0, 0))})
        self.refused(BAD_DATA, "fractal", "--config", "one.vdb", "-o", "x.vdb", mentions="f.vdb")

    # Promise: Formulas, fields, layers and symmetries: bounds ...
    def test_sequences_sheets_and_pictures(self):
        layers = ("--texture", "woven", "--texture-over", "thorns", "--texture-symmetry", "mirror:x")
        self.ok("fractal", "t.obj", *LOW, *layers, "--frames", "1-2", "--key", "texture-mix@1=0", "--key",
                "texture-mix@2=1", "--mesh", "g.####.ply")
        for frame, mix in (("g.0001.ply", 0), ("g.0002.ply", 1)):
            self.assertEqual(harness.read_ply(self.bytes(frame)).points, self.points(*layers, "--texture-mix", mix))
        self.ok("sheet", "t.obj", *LOW, *layers[:4], "--vary", "texture-mix=0.2,0.8", "--vary", "texture-symmetry=none,3:y",
                "--size", "24x24", "-o", "s.png")
        self.ok("sheet", "t.obj", *LOW, "--vary", "texture=expr:x,y,z;expr:-y,x,z", "--size", "24x24", "-o", "e.png")
        self.ok("render", "--field", "t.obj", *LOW, *layers, "--size", "24x24", "-o", "r.png")

    # What gives no direction.

    def bad(self, code, options, *mentions):
        with self.subTest(options=options):
            self.refused(code, "fractal", "t.obj", *LOW, *options, "-o", "x.vdb", mentions=mentions)

    # Promise of textures.md: "Where a direction is undefined at single points or on a line", the versor is 1 and the mesh closed;
    #   elsewhere the formula or field is "refused with the place"
    def test_bad_formulas(self):
        for text in ("", "x", "x,y", "x,y,z,w,x", "x,,z", "x,y,)", "x,y,foo(z)", "x,y,z=1"):
            self.bad(USAGE, ("--texture", f"expr:{text}"), "--texture", text)
            self.bad(USAGE, ("--texture-over", f"expr:{text}"), "--texture-over", text)
        for text in ("sqrt(x),y,z", "log(-1),0,0", "0,0,0", "x > 0 ? 1 : 0, 0, 0", "1/0,y,z"):
            self.bad(BAD_DATA, ("--texture", f"expr:{text}"), "--texture", text, "x = ")
            self.bad(BAD_DATA, ("--texture-over", f"expr:{text}"), "--texture-over", text, "x = ")
        self.bad(BAD_DATA, ("--texture", "expr:x,y,weight"), "--texture", "weight")
        # At single points and on lines there need not be one.
        for text in ("x,y,z", "-y,x,0", "x/sqrt(x*x+y*y+z*z),y/sqrt(x*x+y*y+z*z),z/sqrt(x*x+y*y+z*z)"):
            self.assertEqual(harness.open_edges(self.mesh("--texture", f"expr:{text}", "--origin", "centre")), [])

    # Promise: "Where a direction is undefined ..."
    def test_bad_fields(self):
        self.field()
        vector, nan = pyopenvdb.Vec3SGrid, float("nan")
        write_grids(self.path("bad.vdb"), 0.1, {
            "nan": (vector, lambda x, y, z: (1, nan if abs(x - 0.5) < 0.01 else 0, 0)),
            "zero": (vector, lambda x, y, z: (0, 0, 0) if x > 0.2 else (1, 0, 0)),
            "point": (vector, lambda x, y, z: (0, 0, 0) if abs(x) + abs(y) + abs(z) < 0.01 else (x, y, z)),
            "mask": (pyopenvdb.BoolGrid, lambda x, y, z: True)})
        write_grids(self.path("far.vdb"), 0.1, {"v": (vector, lambda x, y, z: (1, 0, 0))}, 200, 210)
        write_grids(self.path("empty.vdb"), 0.1, {"v": (vector, lambda x, y, z: (1, 0, 0))}, 1, 0)
        self.write("text.vdb", "no VDB")
        for option in ("--texture", "--texture-over"):
            for source, *mentions in (("bad.vdb:nan", "nan", "(0.5,"), ("bad.vdb:zero", "(0, 0, 0)", "at ("),
                                      ("bad.vdb:mask", "mask", "bool"), ("bad.vdb:mask,nan,zero", "mask"),
                                      ("bad.vdb:nowhere", "nowhere"), ("f.vdb:a", "'a'", "float"), ("bad.vdb", "more than one"),
                                      ("f.vdb:a,b,nowhere", "nowhere"), ("far.vdb", "beside the target"),
                                      ("empty.vdb", "no active voxel"), ("text.vdb", "text.vdb")):
                self.bad(BAD_DATA, (option, f"field:{source}"), *mentions, *(() if source == "text.vdb" else (option,)))
            self.bad(NO_INPUT, (option, "field:none.vdb:v"), "none.vdb")
            for source in ("", "f.obj", "f.vdb:", "f.vdb:a,b", "f.vdb:a,,b", "f.vdb:a,b,c,d,a"):
                self.bad(USAGE, (option, f"field:{source}"), option, source)
        # One vector of length 0 is a point without a direction.
        self.assertEqual(harness.open_edges(self.mesh("--texture", "field:bad.vdb:point")), [])

    # Promise: Layers: "0 is the first alone, 1 ..."
    def test_bad_layers(self):
        for value in ("-0.1", "1.1", "nan", "much"):
            self.bad(USAGE, ("--texture-over", "thorns", "--texture-mix", value), "--texture-mix", value)
        self.bad(BAD_DATA, ("--texture-over", "thorns", "--texture-mix", "paint:red"), "--texture-mix", "red")
        self.bad(BAD_DATA, ("--texture-over", "thorns", "--texture-mix", "expr:sqrt(x)"), "--texture-mix", "x = ")
        self.bad(NO_INPUT, ("--texture-over", "thorns", "--texture-mix", "none.vdb"), "none.vdb")
        self.bad(NO_INPUT, ("--texture-over", "none.json",), "none.json")
        self.bad(USAGE, ("--texture-over", "scalse"), "--texture-over", "scales")
        self.bad(USAGE, ("--texture-over", "coral", "--texture-over-frequency", 0), "--texture-over-frequency", "'0'")
        self.bad(USAGE, ("--texture", "function"), "Python")
        for value in ("mirror", "mirror:", "mirror:xx", "mirror:w", "1:x", "65:x", "6", "6:xy", "6:y:mirrored", "y:6", "6:y:mirror:x"):
            self.bad(USAGE, ("--texture-symmetry", value), "--texture-symmetry", value)
        for option, value in (("--texture-mix", 0.3), ("--texture-over-seed", 2), ("--texture-over-frequency", 2)):
            self.bad(USAGE, (option, value), f"{option} has no effect")
        self.bad(USAGE, ("--texture-over", "rings", "--texture-over-frequency", 2), "--texture-over-frequency has no effect")
        self.bad(USAGE, ("--texture-over", "woven", "--texture-over-seed", 2), "--texture-over-seed has no effect")
        self.bad(USAGE, ("--texture", "expr:x,y,z", "--texture-roots", 3), "--texture-roots")
        self.bad(USAGE, ("--texture", "expr:x,y,z", "--frequency", 3), "--frequency has no effect")
        self.bad(USAGE, ("--map", "rational", "--texture", "expr:x,y,z"), "--texture", "expr:x,y,z")
        self.bad(USAGE, ("--map", "rational", "--texture-over", "thorns"), "texture-over")
        # Without a target there is nothing for a layer to follow.
        self.refused(USAGE, "fractal", "--texture-over", "thorns", "-o", "x.vdb", mentions="mesh")

    def test_explore_says_what_it_cannot_show(self):
        for options in (("--texture-over", "thorns"), ("--texture", "expr:x,y,z"), ("--texture-symmetry", "mirror:x")):
            self.refused(USAGE, "explore", "t.obj", *LOW, *options, "--export", "page.html", mentions="render --field")


if __name__ == "__main__":
    unittest.main()

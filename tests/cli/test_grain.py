#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Textures that follow a grain: where the directions come from, the laws of every other fractal (skipped as exhaustive, tiles as
one run, any threads, recipes again), and the refusal of what gives no direction."""
import math
import struct
import unittest

import pyopenvdb

import harness
from harness import BAD_DATA, NO_INPUT, USAGE

LOW = harness.TextureTest.LOW
AXIS = (0.3, 0.2, 1)


def attributed(mesh, attributes):
    """A PLY as text, with attributes, each a name and a function of the place."""
    points, faces = mesh
    lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}", *(f"property float {axis}" for axis in "xyz"),
             *(f"property float {name}" for name in attributes), f"element face {len(faces)}",
             "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(map(repr, (*p, *(value(p) for value in attributes.values())))) for p in points]
    return "\n".join(lines + ["3 {} {} {}".format(*face) for face in faces]) + "\n"


def torus():
    """A torus whose ring lies around Y."""
    return harness.torus()


def along_ring(p):
    length = math.hypot(p[0], p[2])
    return (-p[2] / length, 0, p[0] / length)


def unwrapped(mesh):
    """An OBJ whose texture coordinates are the height and the angle about Y, torn where that begins anew."""
    points, faces = mesh
    lines = ["v {!r} {!r} {!r}".format(*p) for p in points]
    corners = []
    for face in faces:
        angles = [math.atan2(points[k][2], points[k][0]) for k in face]
        if max(angles) - min(angles) > math.pi:
            angles = [a if a > 0 else a + 2 * math.pi for a in angles]
        corners += [(points[k][1], angle) for k, angle in zip(face, angles)]
    lines += ["vt {!r} {!r}".format(*corner) for corner in corners]
    lines += ["f " + " ".join(f"{k + 1}/{3 * i + c + 1}" for c, k in enumerate(face)) for i, face in enumerate(faces)]
    return "\n".join(lines) + "\n"


def strokes(data):
    """@return the places of the strokes of a PLY and their directions"""
    head, body = data.split(b"end_header\n", 1)
    names, count, element = [], 0, ""
    for line in head.decode().splitlines():
        words = line.split()
        if words[:1] == ["element"]:
            element = words[1]
            count = int(words[2]) if element == "vertex" else count
        elif words[:1] == ["property"] and element == "vertex":
            names.append((words[2], {"float": "f", "double": "d", "uchar": "B"}[words[1]]))
    row = struct.Struct("<" + "".join(kind for _, kind in names))
    found = []
    for i in range(count):
        values = dict(zip((name for name, _ in names), row.unpack_from(body, i * row.size)))
        direction = tuple(values["grain_" + axis] for axis in "xyz")
        if any(direction):
            found.append((tuple(values[axis] for axis in "xyz"), direction))
    return found


class Grain(harness.TextureTest):

    FAMILIES = (
        ("--grain", "along"),
        ("--texture", "fur", "--grain", "around", "--frequency", "fine"),
        ("--texture", "rings", "--grain", "0.3,0.2,1", "--grain-turn", 30),
        ("--texture", "coral", "--grain", "curvature", "--frequency", "y:1:3", "--drop-axis", "i"),
        ("--texture", "fur", "--grain", "down", "--texture-over", "shells", "--texture-over-frequency", "coarse",
         "--texture-mix", "y:0:1"),
        ("--texture", "quills", "--grain", "along", "--texture-symmetry", "3:z", "--texture-scale", 1.5),
        ("--texture", "random", "--texture-over", "bark", "--grain", "along", "--grain-turn", "z:0:90"),
    )

    def setUp(self):
        super().setUp()
        self.write("t.obj", harness.obj(torus()))

    def share(self, wanted, target, *options):
        """The share of the strokes that lie within 20 degrees of a wanted direction, and point to it."""
        self.ok("study", target, "--strokes", "s.ply", *options)
        found = strokes(self.bytes("s.ply"))
        self.assertGreater(len(found), 300)
        near = 0
        for place, direction in found:
            near += sum(a * b for a, b in zip(direction, wanted(place))) > math.cos(math.radians(20))
        return near / len(found)

    def line_share(self, wanted, target, *options):
        """The same for a line."""
        backward = lambda p: tuple(-x for x in wanted(p))
        return self.share(wanted, target, *options) + self.share(backward, target, *options)

    # Where it comes from.

    # Promise of textures.md#along-the-form: A grain: its table, `--grain-turn`, and that vectors may be missing in places
    def test_along_and_around(self):
        self.assertGreater(self.line_share(along_ring, "t.obj", "--grain", "along"), 0.95)
        self.assertLess(self.line_share(along_ring, "t.obj", "--grain", "around"), 0.05)
        self.assertGreater(self.line_share(along_ring, "t.obj", "--grain", "around", "--grain-turn", 90), 0.95)
        self.assertGreater(self.line_share(along_ring, "t.obj", "--grain", "curvature"), 0.85)

    # Promise: A grain: its table, `--grain-turn`, and that vectors ...
    def test_vectors_of_the_mesh(self):
        parts = {f"comb_{axis}": (lambda p, k=k: 3 * along_ring(p)[k]) for k, axis in enumerate("xyz")}
        self.write("painted.ply", attributed(torus(), parts))
        self.assertGreater(self.share(along_ring, "painted.ply", "--grain", "paint:comb"), 0.95)
        # Names without an underscore, and vectors that are 0 in places.
        parts = {f"c{axis}": (lambda p, k=k: along_ring(p)[k] if p[0] > -0.3 else 0.0) for k, axis in enumerate("xyz")}
        self.write("half.ply", attributed(torus(), parts))
        self.assertGreater(self.share(along_ring, "half.ply", "--grain", "paint:c"), 0.8)

    # Promise: A grain: its table, `--grain-turn`, and that vectors ...
    def test_texture_coordinates(self):
        self.write("uv.obj", unwrapped(torus()))
        self.assertGreater(self.share(along_ring, "uv.obj", "--grain", "uv:v"), 0.9)
        # u is the height: where the surface is level it says nothing.
        self.assertLess(self.line_share(along_ring, "uv.obj", "--grain", "uv:u"), 0.15)

    # Promise: A grain: its table, `--grain-turn`, and that vectors ...
    def test_a_grid_of_vectors(self):
        grid = pyopenvdb.Vec3SGrid()
        grid.name = "v"
        grid.transform = pyopenvdb.createLinearTransform(voxelSize=0.1)
        accessor = grid.getAccessor()
        for x in range(-14, 15):
            for y in range(-8, 9):
                for z in range(-14, 15):
                    if x or z:
                        accessor.setValueOn((x, y, z), along_ring((x, y, z)))
        pyopenvdb.write(str(self.path("f.vdb")), grids=[grid])
        for field in ("field:f.vdb", "field:f.vdb:v"):
            self.assertGreater(self.share(along_ring, "t.obj", "--grain", field), 0.95)

    # Promise of study.md: `study --strokes`: "a small triangle at each of some thousand places", "red marks at the points about
    #   which the direction turns"
    def test_strokes(self):
        said = self.ok("study", "t.obj", "--strokes", "s.ply", "--grain", "along")
        self.assertIn("singular point", said)
        self.assertIn("% across", said)
        self.ok("study", "t.obj", "--strokes", "s.glb", "--grain", "along")
        self.ok("render", "s.ply", "-o", "s.png", "--size", "32x32")
        self.refused(USAGE, "study", "t.obj", "--strokes", "t.ply", mentions=("--grain along",))
        self.refused(USAGE, "study", "t.obj", "--strokes", "t.stl", "--grain", "along", mentions=("t.stl",))

    # The laws of every fractal.

    # Promise of design.md#5-determinism: A fractal with a grain is the same skipped or not, tiled or not, with any threads, on
    #   any device and from its recipe
    def test_the_same_in_all_ways(self):
        for options in self.FAMILIES:
            with self.subTest(options=options):
                self.assert_the_same_in_all_ways(*options)

    # Promise: A fractal with a grain is the same ...
    def test_a_recipe_holds_it(self):
        for options in self.FAMILIES:
            with self.subTest(options=options):
                self.ok("fractal", "t.obj", *LOW, *options, "--grids", "surface,versor", "-o", "one.vdb")
                self.ok("fractal", "--config", "one.vdb", "-o", "two.vdb")
                self.assertEqual(self.bytes("one.vdb"), self.bytes("two.vdb"))

    # Promise: A grain: its table, `--grain-turn`, and that vectors ...
    def test_every_texture_follows_it(self):
        plain = self.points("--texture", "scales")
        seen = [plain]
        for texture in ("scales", "quills", "woven", "ledges", "fur", "coral", "bark", "thorns", "rings", "shells"):
            made = self.points("--texture", texture, "--grain", "along")
            self.assertNotIn(made, seen)
            seen.append(made)
        self.ok("versor", "new", "--texture", "fur", "-o", "fur.json")
        self.assertEqual(self.points("--texture", "waves:fur.json", "--grain", "along"),
                         self.points("--texture", "fur", "--grain", "along"))

    def test_none_is_what_it_was(self):
        self.assertEqual(self.points("--grain", "none"), self.points())

    # Promise: A fractal with a grain is the same ...
    def test_sequences_sheets_and_pictures(self):
        self.ok("fractal", "t.obj", *LOW, "--grain", "along", "--frames", "1-2", "--key", "grain-turn@1=0", "--key",
                "grain-turn@2=90", "--mesh", "g.####.ply")
        for frame, turn in (("g.0001.ply", 0), ("g.0002.ply", 90)):
            self.assertEqual(harness.read_ply(self.bytes(frame)).points, self.points("--grain", "along", "--grain-turn", turn))
        self.ok("sheet", "t.obj", *LOW, "--vary", "grain=none,along,around", "--size", "24x24", "-o", "s.png")
        self.ok("render", "--field", "t.obj", *LOW, "--grain", "along", "--size", "24x24", "-o", "r.png")

    def test_it_turns_with_the_target(self):
        """The fractal of a target that lies elsewhere is the same fractal there."""
        self.write("moved.obj", harness.obj(harness.moved(torus(), 1, (5, -3, 2))))
        one = self.points("--grain", "along", "--texture", "fur")
        self.ok("fractal", "moved.obj", *LOW, "--grain", "along", "--texture", "fur", "--mesh", "moved.ply")
        other = harness.read_ply(self.bytes("moved.ply")).points
        self.assertLess(abs(len(one) - len(other)), 0.02 * len(one))

    # Promise: A fractal with a grain is the same ...
    def test_all_kinds_of_targets(self):
        points, faces = harness.sphere(2)
        far = [tuple(x + 3 for x in p) for p in points]
        shapes = {
            "ball.obj": harness.sphere(2),
            "two.obj": (points + far, faces + [tuple(k + len(points) for k in face) for face in faces]),
            "cube.obj": harness.cube(),
            "needle.obj": harness.needle(),
        }
        for name, mesh in shapes.items():
            with self.subTest(name=name):
                self.write(name, harness.obj(mesh))
                for grain in ("along", "curvature", "down"):
                    self.ok("fractal", name, *LOW, "--grain", grain, "--mesh", "x.ply")
                    self.assertEqual(harness.open_edges(harness.read_ply(self.bytes("x.ply"))), [])
        self.ok("fractal", "t.obj", *LOW, "--mask", 0, "-o", "level.vdb")
        self.ok("fractal", "level.vdb", "--resolution", 40, "--grain", "along", "-o", "x.vdb")

    # What gives no direction.

    def bad(self, code, options, *mentions, target="t.obj"):
        with self.subTest(options=options):
            self.refused(code, "fractal", target, *LOW, *options, "-o", "x.vdb", mentions=mentions)

    # Promise: A grain: its table, `--grain-turn`, and that vectors ...
    def test_bad_grains(self):
        for value in ("", "allong", "1,2", "0,0,0", "1,2,x", "uv:w", "paint:", "field:", "field:f.obj", "nan,0,0"):
            self.bad(USAGE, ("--grain", value), "--grain", value)
        for value in ("much", "nan"):
            self.bad(USAGE, ("--grain", "along", "--grain-turn", value), "--grain-turn", value)
        self.bad(BAD_DATA, ("--grain", "paint:comb"), "comb_x")
        self.bad(BAD_DATA, ("--grain", "uv:u"), "texture coordinates")
        self.bad(NO_INPUT, ("--grain", "field:none.vdb"), "none.vdb")
        self.bad(USAGE, ("--grain-turn", 30), "--grain-turn has no effect")
        for texture in ("random", "expr:x,y,z"):
            self.bad(USAGE, ("--texture", texture, "--grain", "along"), "--grain has no effect")
        self.bad(USAGE, ("--grain", "along", "--texture-translate", "1,0,0"), "--texture-translate has no effect")
        self.bad(USAGE, ("--grain", "along", "--slice", "0.2"), "--slice has no effect")
        self.bad(USAGE, ("--map", "rational", "--texture", "random", "--grain", "along"), "grain")
        self.write("zero.ply", attributed(torus(), {f"v_{axis}": lambda p: 0 for axis in "xyz"}))
        self.bad(BAD_DATA, ("--grain", "paint:v"), "v", target="zero.ply")
        self.write("nan.ply", attributed(torus(), {f"v_{axis}": lambda p: math.nan for axis in "xyz"}))
        self.bad(BAD_DATA, ("--grain", "paint:v"), "v_x", target="nan.ply")
        self.ok("sdf", "t.obj", "-o", "t.vdb", "--resolution", 40)
        self.refused(BAD_DATA, "fractal", "t.vdb", "--grain", "paint:v", "-o", "x.vdb", mentions=("VDB",))


if __name__ == "__main__":
    unittest.main()

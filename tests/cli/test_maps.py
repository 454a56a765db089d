# SPDX-License-Identifier: Apache-2.0
"""Maps without a target: every one of them to a VDB and a mesh that others can read, its pictures, and what is refused."""

import json
import math
import re
import shutil
import subprocess
import unittest

import pyopenvdb

import harness
from harness import BAD_DATA, USAGE

LOW = ("--resolution", 28)
LEAST = ("--resolution", 20)  # for what has to hold of every map
PAIRS = ("A", "A'", "B", "C", "D", "E")
USER = ("--f", "x*x, y*y, z*z", "--g", "cos(x), cos(y), cos(z)")
MAPS = [("--map", "cross", "--scheme", 3, "--pair", "B", "--radius", 6),
        ("--map", "cross", "--scheme", 4, "--pair", "A"),
        ("--map", "cross", "--scheme", 5, "--pair", "D", "--c=-1,0,0"),
        ("--map", "cross", "--scheme", 5, "--pair", "E", "--radius", 6),
        ("--map", "cross", "--pair", "user", *USER, "--radius", 5),
        ("--map", "mandelbulb", "--power", 8),
        ("--map", "mandelbulb", "--power", 2.5, "--c", "0.1,0.2,-0.3"),
        ("--map", "quadratic", "--mandelbrot", "--slice", 0.1),
        ("--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", "--iterations", 8)]


class Maps(harness.CliTest):

    def fractal(self, *options):
        self.ok("fractal", *options, "--mesh", "m.ply")
        return harness.read_ply(self.bytes("m.ply"))

    def check_closed(self, mesh):
        for (a, b), uses in harness.edge_uses(mesh).items():
            self.assertEqual(uses, 1, f"the edge {a}-{b} has a direction twice")
        self.assertEqual(harness.open_edges(mesh), [])
        self.assertGreater(harness.volume_of(mesh), 0)


class Listing(Maps):

    def test_json_lists_the_options_of_a_recipe(self):
        """What a host may hand on from a recipe of somebody else: everything that a recipe can hold, and nothing that
        makes the program write."""
        listed = json.loads(self.ok("maps", "--json", data=True))
        self.assertEqual(listed["maps"], [line.split()[0] for line in self.ok("maps", data=True).splitlines()])
        names = [option["name"] for option in listed["options"]]
        self.assertEqual(len(names), len(set(names)))
        self.write("s.obj", harness.obj(harness.sphere(2)))
        for options in (("s.obj", "--sdf-resolution", 16), ("--map", "quadratic", "--c=-0.2,0.6,0.2,0.2")):
            self.ok("fractal", *options, "-o", "a.vdb", "--resolution", 16)
            recipe = self.info("a.vdb")["recipe"]
            held = {name for name in recipe if name != "command" and not name.endswith("-sha256")}
            self.assertEqual(held - set(names), set())
        common = self.ok("maps", "--help", "all", data=True) + self.ok("merge", "--help", "all", data=True)
        others = set(re.findall(r"(?m)^  (?:-\w \[ )?--([a-z-]+)", common)) | {"frames", "key", "frame", "search"}
        self.assertIn("output", others)
        self.assertIn("mesh", others)
        self.assertEqual(set(names) & others, set())
        self.refused(USAGE, "maps", "--json", "--markdown")


class EveryMap(Maps):

    def test_every_scheme_with_every_pair(self):
        for scheme in (3, 4, 5):
            for pair in PAIRS:
                with self.subTest(scheme=scheme, pair=pair):
                    self.check_closed(self.fractal("--map", "cross", "--scheme", scheme, "--pair", pair, "--radius", 3,
                                                   *LEAST))

    # Promise: The level set "passes tests ..."
    @unittest.skipUnless(shutil.which("vdb_print") and shutil.which("vdb_tool"), "libopenvdb-tools is not here")
    def test_handed_off(self):
        """To a VDB and a mesh, which the tools of OpenVDB and its Python module read; and to every other command."""
        tool = lambda *words: subprocess.run(words, cwd=self.folder, capture_output=True, text=True, check=True).stdout
        grids = ["surface", "density", "logmodulus", "iterations", "versor"]
        for options in MAPS:
            with self.subTest(options=options):
                self.ok("fractal", *options, *LEAST, "-o", "m.vdb", "--mesh", "m.ply", "--grids", ",".join(grids))
                self.check_closed(harness.read_ply(self.bytes("m.ply")))
                listing = tool("vdb_print", "-l", "m.vdb")
                self.assertEqual(sorted(re.findall(r"(?m)^Name: (\w+)", listing)), sorted(grids))
                self.assertIn("julia_map: " + options[1], listing)
                surface = pyopenvdb.read(str(self.path("m.vdb")), "surface")
                self.assertEqual(surface.gridClass, "level set")
                self.assertGreater(surface.activeVoxelCount(), 100)
                for name in ("logmodulus", "versor"):
                    for item in pyopenvdb.read(str(self.path("m.vdb")), name).citerOnValues():
                        values = item.value if isinstance(item.value, tuple) else (item.value,)
                        self.assertTrue(all(map(math.isfinite, values)), f"{name} at {item.min}: {item.value}")
                self.ok("fractal", *options, *LEAST, "-o", "one.vdb")
                tool("vdb_tool", "-read", "one.vdb", "-ls2mesh", "-write", "tool.ply")
                self.assertGreater(int(re.search(rb"element face (\d+)", self.bytes("tool.ply"))[1]), 100)

                self.assertEqual(self.info("one.vdb")["grids"][0]["level set check"], "passes")
                self.ok("mesh", "m.vdb", "-o", "again.ply")
                self.assertTrue(self.bytes("again.ply") == self.bytes("m.ply"), "the recipe gives another mesh")
                self.ok("render", "one.vdb", "-o", "x.png", "--size", "24x16")
                for field in ("membership", "iterations", "logmodulus", "e", "versor"):
                    self.ok("slice", "m.vdb", "-o", "x.png", "--field", field, "--size", 24)
                    rows = harness.read_png(self.bytes("x.png"))
                    self.assertGreater(len({pixel for row in rows for pixel in row}), 1, f"{field} shows nothing")
                self.refused(USAGE, "slice", "m.vdb", "-o", "y.png", "--field", "phi", mentions="target")

    # Promise: "The same recipe gives the same ..."
    def test_the_same_bytes(self):
        for options in MAPS:
            with self.subTest(options=options):
                for threads in (1, 3):
                    self.ok("fractal", *options, *LEAST, "-o", f"{threads}.vdb", "--mesh", f"{threads}.ply", "--threads",
                            threads)
                self.assertTrue(self.bytes("1.vdb") == self.bytes("3.vdb"))
                self.assertTrue(self.bytes("1.ply") == self.bytes("3.ply"))
                for config in ("1.vdb", "1.ply"):
                    self.ok("fractal", "--config", config, "-o", "again.vdb", "--mesh", "again.ply")
                    self.assertTrue(self.bytes("again.vdb") == self.bytes("1.vdb"), config)
                    self.assertTrue(self.bytes("again.ply") == self.bytes("1.ply"), config)
                # STL carries no recipe, in which --exhaustive stands.
                self.ok("fractal", *options, *LEAST, "--mesh", "plain.stl")
                self.ok("fractal", *options, *LEAST, "--mesh", "all.stl", "--exhaustive")
                self.assertTrue(self.bytes("plain.stl") == self.bytes("all.stl"))

    # Promise: `--follow`: "What it finds ..."
    def test_following(self):
        whole = self.fractal("--map", "mandelbulb", *LOW)
        followed = self.fractal("--map", "mandelbulb", *LOW, "--follow", "--seed-stride", 2)
        self.check_closed(followed)
        self.assertLessEqual(set(followed.points), set(whole.points))
        self.assertGreater(len(followed.points), 0.95 * len(whole.points))

    # Promise: "With `--box` it ends at the box" ...
    def test_boxes_cut_and_change_nothing_else(self):
        for options in (("--map", "cross", "--pair", "A"), ("--map", "mandelbulb"), ("--map", "quadratic", "--mandelbrot")):
            with self.subTest(options=options):
                size = ("--voxel-size", 0.07)
                whole = self.fractal(*options, *size)
                part = self.fractal(*options, *size, "--box", "-1,-0.5,-0.3,0.4,0.9,0.6")
                self.assertLess(set(part.points), set(whole.points))
                self.check_closed(self.fractal(*options, *size, "--box", "-1,-0.5,-0.3,0.4,0.9,0.6", "--cap"))

    # Promise: "keep only the N largest" ...
    def test_islands(self):
        """The Julia set of A and (-1, 0, 0) is balls and flats in a row; the largest ball is about the origin."""
        options = ("--map", "cross", "--scheme", 5, *LOW)
        self.assertGreater(len(self.fractal(*options).faces), len(self.fractal(*options, "--largest", 1).faces))


class Sets(Maps):

    # Promise: Every map has the options, defaults ...
    def test_the_defaults_are_the_papers(self):
        self.ok("fractal", "--map", "cross", *LOW, "-o", "m.vdb")
        recipe = self.info("m.vdb")["recipe"]
        self.assertEqual([recipe[name] for name in ("scheme", "pair", "iterations", "radius")], ["4", "A", "10", "2"])
        self.assertNotIn("c", recipe)
        self.assertNotIn("escape", recipe)
        self.ok("fractal", "--map", "cross", "--scheme", 5, *LOW, "-o", "m.vdb")
        self.assertEqual(self.info("m.vdb")["recipe"]["c"], "-1,0,0")

    # Promise: "f x g of the pair A is the square ..."
    def test_mandelbulbs_of_power_2_are_pair_a(self):
        one = self.fractal("--map", "cross", "--pair", "A", "--iterations", 6, *LOW)
        two = self.fractal("--map", "mandelbulb", "--power", 2, "--iterations", 6, *LOW)
        # Needles come and go with the nodes that they meet.
        self.assertAlmostEqual(harness.volume_of(one), harness.volume_of(two), delta=0.02 * harness.volume_of(two))

    def test_the_quadratic_set_is_the_complex_one_around_its_axis(self):
        """A vertex at a distance d from the real axis lies on the border of the complex set at x + i d."""
        mesh = self.fractal("--map", "quadratic", "--mandelbrot", "--iterations", 6, "--escape", 4, *LOW)
        def stays(c):
            z = c
            for _ in range(6):
                if abs(z) >= 4:
                    return False
                z = z * z + c
            return abs(z) < 4
        near = 2e-3 * 4 / 28 * 2
        for x, y, z in mesh.points[::5]:
            d = math.hypot(y, z)
            around = {stays(complex(x + a * near, d + b * near)) for a in (-1, 0, 1) for b in (-1, 0, 1)}
            self.assertEqual(around, {True, False}, (x, y, z))

    def test_own_pairs(self):
        """Written as the paper writes it, a pair is the built-in one."""
        own = self.fractal("--map", "cross", *USER, "--radius", 4, *LOW)
        built_in = self.fractal("--map", "cross", "--pair", "C", "--radius", 4, *LOW)
        self.assertEqual((own.points, own.faces), (built_in.points, built_in.faces))
        a = self.fractal("--map", "cross", "--iterations", 5, *LOW)
        own = self.fractal("--map", "cross", "--iterations", 5, "--f", "-r^2*sin2phi, r^2*cos2phi, 0", "--g",
                           "-sin2theta/cos2phi, 0, cos2theta", *LOW)
        self.assertAlmostEqual(harness.volume_of(own), harness.volume_of(a), delta=1e-3 * harness.volume_of(a))

    # Promise of sets.md: "the lattice of a `cross` set is shifted by less than a thousandth of a voxel; the transform of its VDB
    #   has the shift, and so have its vertices", and is in one piece
    def test_the_shift_off_the_nodes_is_less_than_a_thousandth_of_a_voxel(self):
        """The transform of a grid has it, and the map's own centre stays where it is."""
        for pair in PAIRS:
            self.ok("fractal", "--map", "cross", "--pair", pair, *LEAST, "-o", "c.vdb")
            told = self.info("c.vdb")
            self.assertEqual(told["metadata"]["julia_space_centre"], "0,0,0")
            zero = pyopenvdb.read(str(self.folder / "c.vdb"), "surface").transform.indexToWorld((0, 0, 0))
            self.assertGreater(min(map(abs, zero)), 0, pair)
            self.assertLess(max(map(abs, zero)), 1e-3 * told["grids"][0]["voxel size"][0], pair)

    # Promise: "the lattice of a `cross` ..."
    def test_a_pair_with_undefined_planes_is_in_one_piece(self):
        """A is outside where |x| = |y|: without volume, that must not take the shape apart."""
        mesh = self.fractal("--map", "cross", "--pair", "A", "--iterations", 4, *LOW)
        self.assertEqual(self.info("m.ply")["components"], 1)
        # Were there a cut, a good quarter of the vertices would lie on it.
        near = sum(abs(abs(p[0]) - abs(p[1])) < 1e-3 for p in mesh.points)
        self.assertLess(near, 0.12 * len(mesh.points))

    def test_another_recipe(self):
        self.ok("fractal", "--map", "cross", "--scheme", 5, *USER, "--radius", 4, *LOW, "-o", "m.vdb")
        for options, expected in ((("--pair", "D"), {"pair": "D", "scheme": "5", "radius": "4", "f": None}),
                                  (("--scheme", 4), {"pair": "user", "scheme": "4", "c": None}),
                                  (("--map", "mandelbulb"), {"pair": None, "power": "8", "radius": "4"}),
                                  (("--map", "quadratic", "--mandelbrot"), {"radius": None, "escape": "20"})):
            with self.subTest(options=options):
                self.ok("fractal", "--config", "m.vdb", *options, "-o", "other.vdb")
                recipe = self.info("other.vdb")["recipe"]
                for name, value in expected.items():
                    self.assertEqual(recipe.get(name), value, name)


class BadInput(Maps):

    def test_values(self):
        cross, bulb, quadratic = ("--map", "cross"), ("--map", "mandelbulb"), ("--map", "quadratic")
        cases = [(cross, "scheme", v) for v in ("2", "6", "mandelbrot", "")]
        cases += [(cross, "pair", v) for v in ("F", "a", "", "A''", "users")]
        for map_ in (cross, bulb):
            cases += [(map_, "radius", v) for v in ("0", "-2", "1", "nan", "inf", "1e10", "far", "")]
            cases += [(map_, "iterations", v) for v in ("0", "-1", "2.5", "99999", "many", "")]
        cases += [((*cross, "--scheme", "5"), "c", v) for v in ("1", "1,2", "1,2,3,4", "a,b,c", "0,0,nan", "0,0,1e10")]
        cases += [(bulb, "c", v) for v in ("1", "1,2", "1,2,3,4", "0,0,nan", "0,0,1e10")]
        cases += [(quadratic, "c", v) for v in ("1,2,3", "1,2,3,4,5")]
        cases += [(bulb, "power", v) for v in ("101", "-101", "nan", "inf", "eight", "")]
        cases += [(bulb, "theta", v) for v in ("equator", "")]
        cases += [(("--map", "julia"), "scheme", "4"), (("--map", ""), "scheme", "4")]
        self.all_refused(USAGE, [("fractal", "-o", "x.vdb", *LOW, *map_, f"--{option}={value}")
                                 for map_, option, value in cases])

    # Promise: Every map has the options, defaults ...
    def test_options_of_another_map(self):
        cases = {("--map", "cross"): ("--power=2", "--theta=pole", "--mandelbrot", "--escape=20", "--slice=0.1",
                                      "--drop-axis=i", "--c=-1,0,0", "--scheme=3 --c=-1,0,0"),
                 ("--map", "mandelbulb"): ("--scheme=4", "--pair=A", "--f=x,y,z", "--escape=20", "--slice=0.1",
                                           "--mandelbrot --c=0,0,0"),
                 ("--map", "quadratic"): ("--scheme=4", "--pair=A", "--power=2", "--radius=2", "--f=x,y,z",
                                          "--mandelbrot --c=0,0,0,0"),
                 ("s.obj",): ("--scheme=4", "--pair=A", "--power=2", "--radius=2", "--mandelbrot", "--f=x,y,z")}
        self.write("s.obj", harness.obj(harness.cube()))
        for map_, options in cases.items():
            for option in options:
                name = re.match(r"--[a-z-]+", option.split()[-1])[0]
                self.refused(USAGE, "fractal", *map_, *option.split(), *LOW, "-o", "x.vdb", mentions=name)
        for map_ in ("cross", "mandelbulb"):
            self.refused(USAGE, "fractal", "s.obj", "--map", map_, "-o", "x.vdb", mentions=["s.obj", map_, "no target"])

    def test_expressions(self):
        """A mistake is refused with its place."""
        good = "x*x, y*y, z*z"
        cases = (("x*x, y*y", good, ["f is", "2 components"]), (good, "x", ["g is", "1 component"]),
                 ("x, y, z, x", good, ["4 components"]), ("x,,z", good, ["component 2 is empty"]),
                 ("x*x, y**y, z", good, ["character 8"]), ("x, y, w", good, ["character 7", "'w'"]),
                 ("x, sin(y, z", good, ["f is"]), ("x, y, 1/0", good, ["component 3", "divide by 0"]),
                 (good, "x, y, z/(x-x)", ["g is", "component 3"]), (good, "x, y, 0/0", ["component 3"]),
                 ("", good, ["f"]), (good, "x=1, y, z", ["="]), ("x, y, z\nz", good, ["f is"]))
        for f, g, mentions in cases:
            with self.subTest(f=f, g=g):
                self.refused(USAGE, "fractal", "--map", "cross", f"--f={f}", f"--g={g}", *LOW, "-o", "x.vdb",
                             mentions=mentions)
        self.refused(USAGE, "fractal", "--map", "cross", "--f", good, *LOW, "-o", "x.vdb", mentions="--g")
        self.refused(USAGE, "fractal", "--map", "cross", "--pair", "user", *LOW, "-o", "x.vdb", mentions="--f")
        self.refused(USAGE, "fractal", "--map", "cross", "--pair", "B", *USER, *LOW, "-o", "x.vdb", mentions="--f")

    # Promise: "An empty result is an error, not ..."
    def test_an_empty_set(self):
        self.refused(BAD_DATA, "fractal", "--map", "cross", "--scheme", 5, "--c", "0,0,1.9", "--iterations", 50, *LOW,
                     "-o", "x.vdb", mentions="empty")
        self.refused(BAD_DATA, "fractal", "--map", "mandelbulb", "--box", "5,5,5,6,6,6", *LOW, "-o", "x.vdb",
                     mentions="empty")


if __name__ == "__main__":
    harness.main()

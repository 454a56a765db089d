# SPDX-License-Identifier: Apache-2.0
"""The command versor: list, new, inspect, add, scale, translate, and the versors in fractals."""

import json
import struct

import harness
from harness import BAD_DATA, NO_INPUT, USAGE


class Versor(harness.CliTest):

    def roots(self, name, side="top"):
        return [(*root["position"], root["power"]) for root in json.loads(self.bytes(name))[side]["roots"]]

    def setUp(self):
        super().setUp()
        self.write("v.json", harness.rational_json(harness.ROOTS, harness.ROOTS[:1], 0.5))
        self.write("w.json", harness.rational_json([(1.0, 2.0, 3.0, 4.0, 5.0)]))

    def test_new(self):
        self.ok("versor", "new", "-o", "a.json")
        self.assertEqual(len(self.roots("a.json")), 10)
        for *position, power in self.roots("a.json"):
            self.assertTrue(all(-0.5 <= x <= 0.5 for x in position[:3]))
            self.assertEqual(position[3], 0)
            self.assertTrue(2 <= power <= 11)
        self.assertEqual(self.roots("a.json", "bottom"), [])
        self.ok("versor", "new", "-o", "b.json")
        self.assertEqual(self.bytes("a.json"), self.bytes("b.json"))
        self.ok("versor", "new", "-o", "c.json", "--seed", 2)
        self.assertNotEqual(self.roots("a.json"), self.roots("c.json"))

    def test_new_with_options(self):
        self.ok("versor", "new", "-o", "a.json", "--roots", 50, "--powers", "3:6", "--integer", "--box",
                "-0.1,0.2,0,0.1,0.3,0")
        self.assertEqual(len(self.roots("a.json")), 50)
        for x, y, z, _, power in self.roots("a.json"):
            self.assertIn(power, (3, 4, 5, 6))
            self.assertTrue(-0.1 <= x <= 0.1 and 0.2 <= y <= 0.3 and z == 0)
        self.assertEqual({root[4] for root in self.roots("a.json")}, {3, 4, 5, 6})
        self.ok("versor", "new", "-o", "a.json", "--placement", "cluster", "--centre", "1,2,-3", "--radius", 0.01)
        for x, y, z, *_ in self.roots("a.json"):
            self.assertLess(max(abs(x - 1), abs(y - 2), abs(z + 3)), 0.06)  # twelve uniforms end at six sigma

    def test_inspect(self):
        text = self.ok("versor", "inspect", "v.json", data=True)
        self.assertIn("top: 3 roots", text)
        self.assertIn("bottom: 1 roots", text)
        self.assertIn("[0.1 0.2 -0.1 0]  power 3", text)
        self.assertIn("C: 0.5", text)

    def test_scale_and_translate(self):
        self.ok("versor", "scale", "v.json", 2, "-o", "x.json")
        self.assertEqual(self.roots("x.json"), [(2 * a, 2 * b, 2 * c, 2 * d, p) for a, b, c, d, p in harness.ROOTS])
        self.assertEqual(len(self.roots("x.json", "bottom")), 1)
        self.ok("versor", "scale", "v.json", -0.5, "-o", "x.json")
        self.assertEqual(self.roots("x.json")[0], (-0.05, -0.1, 0.05, 0, 3))
        self.ok("versor", "translate", "w.json", "-1,0.5,0", "-o", "x.json")
        self.assertEqual(self.roots("x.json"), [(0, 2.5, 3, 4, 5)])
        self.ok("versor", "translate", "w.json", "0,0,0,-4", "-o", "x.json")
        self.assertEqual(self.roots("x.json"), [(1, 2, 3, 0, 5)])

    def test_the_note_makes_it_again(self):
        for options in (("--seed", 3), ("--texture", "rings"), ("--texture", "shells"), ("--texture", "woven"),
                        ("--texture", "scales", "--seed", 7),
                        ("--seed", 4, "--roots", 12, "--powers", "2:9", "--integer"),
                        ("--box", "-2,-1,0,1,3,2", "--integer"), ("--placement", "cluster", "--centre", "-1,0,0.5",
                                                                  "--radius", 0.2)):
            with self.subTest(options=options):
                self.ok("versor", "new", *options, "-o", "one.json")
                note = json.loads(self.bytes("one.json"))["note"].split()
                self.assertEqual(note[0], "juliavdb")
                self.ok(*note[1:], "-o", "two.json")
                self.assertEqual(self.bytes("one.json"), self.bytes("two.json"))

    # Promise: Waves in files: "changed ..."
    def test_textures(self):
        """A texture is what its file holds, and its seed is that of the fractal's option."""
        self.write("s.obj", harness.obj(harness.sphere(2)))
        low = ("--resolution", 24, "--sdf-resolution", 24)
        shelf = json.loads(self.ok("versor", "list", "--json", data=True))
        self.assertEqual(sum(texture["default"] for texture in shelf), 1)
        default, = [texture["name"] for texture in shelf if texture["default"]]
        self.ok("fractal", "s.obj", *low, "--mesh", "default.ply")
        default_points = harness.read_ply(self.bytes("default.ply")).points
        for texture in shelf:
            name = texture["name"]
            with self.subTest(texture=name):
                self.ok("fractal", "s.obj", "--texture", name, *low, "--mesh", "m.ply")
                points = harness.read_ply(self.bytes("m.ply")).points
                self.assertEqual(points == default_points, name == default)
                if texture["seed"]:
                    self.ok("fractal", "s.obj", "--texture", name, "--texture-seed", 5, *low, "--mesh", "m.ply")
                    self.assertFalse(points == harness.read_ply(self.bytes("m.ply")).points)
                self.ok("versor", "new", "--texture", name, "-o", "t.json")
                if texture["follows_thickness"]:
                    self.assertEqual(texture["roots"], 0)
                else:
                    self.assertEqual(len(self.roots("t.json")), texture["roots"])
                given = "waves:t.json" if texture["follows_thickness"] else "t.json"
                self.ok("fractal", "s.obj", "--texture", given, *low, "--mesh", "m.ply")
                self.assertTrue(points == harness.read_ply(self.bytes("m.ply")).points, name)
        for refused in (("versor", "new", "--texture", "feather", "-o", "x.json"),
                        ("versor", "new", "--texture", "shells", "--roots", 4, "-o", "x.json"),
                        ("versor", "new", "--texture", "shells", "--seed", 4, "-o", "x.json"),
                        ("versor", "list", "more"),
                        ("fractal", "s.obj", *low, "-o", "x.vdb", "--texture", "feather"),
                        ("fractal", "s.obj", *low, "-o", "x.vdb", "--texture", "scales", "--texture-powers", "2:3")):
            with self.subTest(refused=refused):
                self.refused(USAGE, *refused)

    # Promise of textures.md: Waves in files: "changed by a script, its waves are a texture of your own that follows the
    #   thickness"
    def test_waves_of_a_file(self):
        """They are those of the texture, with its seed, its frequency, its scale and its place, and in both layers."""
        self.write("s.obj", harness.obj(harness.sphere(2)))
        low = ("--resolution", 24, "--sdf-resolution", 24)

        def points(*words):
            self.ok("fractal", "s.obj", *words, *low, "--mesh", "m.ply")
            return harness.read_ply(self.bytes("m.ply")).points

        self.ok("versor", "new", "--texture", "coral", "--seed", 5, "-o", "c.json")
        self.ok("versor", "new", "--texture", "woven", "-o", "w.json")
        self.assertIn("24 waves in 2 factors", self.ok("versor", "new", "--texture", "coral", "-o", "one.json"))
        coral = ("--texture", "coral", "--texture-seed", 5)
        for words in (("--frequency", "fine"), ("--texture-scale", 0.7, "--texture-translate", "0.1,0,0.2"),
                      ("--slice", 0.1, "--drop-axis", "i")):
            with self.subTest(words=words):
                self.assertEqual(points(*coral, *words), points("--texture", "waves:c.json", *words))
        over = ("--texture-mix", "y:0:1")
        self.assertEqual(points(*coral, "--texture-over", "woven", "--texture-over-frequency", 3, *over),
                         points("--texture", "waves:c.json", "--texture-over", "waves:w.json", "--texture-over-frequency", 3,
                                *over))
        self.assertNotEqual(points(*coral), points("--texture", "waves:one.json"))
        self.ok("fractal", "s.obj", "--texture", "waves:c.json", *low, "-o", "a.vdb")
        self.ok("fractal", "--config", "a.vdb", "-o", "b.vdb")
        self.assertEqual(self.bytes("a.vdb"), self.bytes("b.vdb"))
        shown = self.ok("versor", "inspect", "w.json", data=True)
        self.assertEqual(shown.count("factor: 1 waves, power 1"), 3)
        self.write("c.json", self.bytes("w.json"))
        self.refused(BAD_DATA, "fractal", "--config", "a.vdb", "-o", "x.vdb", mentions="c.json")
        for code, words, mentions in (
                (USAGE, ("--texture", "waves:"), "waves:FILE.json"),
                (NO_INPUT, ("--texture", "waves:none.json"), "none.json"),
                (BAD_DATA, ("--texture", "w.json"), "waves:w.json"),
                (BAD_DATA, ("--texture", "waves:v.json"), "this program reads"),
                (USAGE, ("--texture", "waves:w.json", "--texture-seed", 2), "seed"),
                (USAGE, ("--texture", "waves:w.json", "--texture-roots", 2), "roots"),
                (USAGE, ("--map", "rational", "--texture", "waves:w.json"), "rational")):
            with self.subTest(words=words):
                self.refused(code, "fractal", "s.obj", *low, *words, "-o", "x.vdb", mentions=mentions)
        self.refused(USAGE, "versor", "new", "--texture", "coral", "--seed", -1, "-o", "x.json", mentions="-1")
        self.refused(USAGE, "versor", "new", "--texture", "coral", "-o", "x.p4d", mentions=".json")

    def test_add_keeps_the_order(self):
        self.ok("versor", "add", "v.json", "w.json", "-o", "x.json")
        self.assertEqual(self.roots("x.json"), harness.ROOTS + [(1, 2, 3, 4, 5)])
        self.ok("versor", "add", "w.json", "v.json", "-o", "y.json")
        self.assertEqual(self.roots("y.json")[0], (1, 2, 3, 4, 5))
        self.assertEqual(json.loads(self.bytes("y.json"))["logScale"], 0.5)

    # Promise: Files of the released programs ...
    def test_the_formats_of_the_released_programs(self):
        self.write("p.p4d", harness.p4d(harness.ROOTS, 2.0))
        self.ok("versor", "scale", "p.p4d", 1, "-o", "p.json")
        self.assertEqual(self.roots("p.json"), harness.ROOTS)
        self.assertEqual(json.loads(self.bytes("p.json"))["top"]["powerScale"], 2)
        self.ok("versor", "scale", "p.json", 1, "-o", "back.p4d")
        self.assertEqual(self.bytes("back.p4d"), harness.p4d(harness.ROOTS, 2.0))
        self.write("s.o3d", harness.o3d(harness.ROOTS, [(1, 2, 3, 4, 5)], 2.718281828459045))
        self.ok("versor", "scale", "s.o3d", 1, "-o", "s.json")
        self.assertEqual(self.roots("s.json", "bottom"), [(1, 2, 3, 4, 5)])
        self.assertAlmostEqual(json.loads(self.bytes("s.json"))["logScale"], 1, 15)
        # A polynomial's file has no place for a bottom.
        self.refused(USAGE, "versor", "scale", "s.o3d", 1, "-o", "s.p4d", mentions="bottom")

    def test_extensions_in_upper_case(self):
        self.ok("versor", "new", "-o", "a.P4D", "--seed", 3, "--roots", 5)
        self.ok("versor", "new", "-o", "a.p4d", "--seed", 3, "--roots", 5)
        self.assertEqual(self.bytes("a.P4D"), self.bytes("a.p4d"))
        self.assertIn("5 roots", self.ok("versor", "inspect", "a.P4D", data=True))
        # The region of a map without a target is the box that its file holds.
        self.write("S.O3D", harness.o3d(harness.ROOTS, harness.ROOTS[:1]))
        self.ok("fractal", "--map", "rational", "--rational", "S.O3D", "--mesh", "x.ply", "--resolution", 24)

    def test_unused_arrays_of_a_p4d_are_skipped(self):
        filled = (struct.pack("<i", 3) + harness.quaternions([(1e300, float("nan"), 0, 0)] * 4) +
                  harness.quaternions([(0, 0, 0, 0)]) + harness.quaternions([]) + harness.p4d(harness.ROOTS)[16:])
        self.write("full.p4d", filled)
        self.ok("versor", "scale", "full.p4d", 1, "-o", "x.json")
        self.assertEqual(self.roots("x.json"), harness.ROOTS)

    def test_results_that_do_not_fit(self):
        self.write("far.json", harness.rational_json([(1e9, 0, 0, 0, 1)]))
        self.refused(USAGE, "versor", "scale", "far.json", 1e300, "-o", "x.json")
        self.write("far.json", harness.rational_json([(1e10, 0, 0, 0, 1)]))
        self.refused(BAD_DATA, "versor", "inspect", "far.json")

    def test_versors_in_fractals(self):
        """The fractal knows its versor by what is in the file, not by its kind."""
        self.write("s.obj", harness.obj(harness.sphere(2)))
        self.write("p.p4d", harness.p4d(harness.ROOTS))
        self.write("p.json", harness.rational_json(harness.ROOTS))
        meshes = []
        for versor in ("p.p4d", "p.json"):
            self.ok("fractal", "s.obj", "--texture", versor, "--resolution", 24, "--sdf-resolution", 24, "--mesh",
                    "m.ply")
            meshes.append(harness.read_ply(self.bytes("m.ply")))
        self.assertTrue(meshes[0].points == meshes[1].points)
        # Moving and scaling beforehand is the same as by options.
        self.ok("versor", "scale", "p.json", 0.5, "-o", "half.json")
        self.ok("versor", "translate", "half.json", "0.125,0,-0.25", "-o", "there.json")
        for versor, options in (("there.json", ()),
                                ("p.json", ("--texture-scale", 0.5, "--texture-translate", "0.125,0,-0.25"))):
            self.ok("fractal", "s.obj", "--texture", versor, *options, "--resolution", 24, "--sdf-resolution", 24,
                    "--mesh", "m.ply")
            meshes.append(harness.read_ply(self.bytes("m.ply")))
        self.assertTrue(meshes[2].points == meshes[3].points)
        self.assertFalse(meshes[0].points == meshes[2].points)


if __name__ == "__main__":
    harness.main()

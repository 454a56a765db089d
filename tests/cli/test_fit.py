# SPDX-License-Identifier: Apache-2.0
"""The command fit, and what becomes of its maps: fractals without a mesh, in the mesh's own units and place."""

import csv
import io
import json
import math
import pathlib
import re
import shutil
import tempfile

import harness
from harness import BAD_DATA, CANNOT_CREATE, NO_INPUT, USAGE

LOW = ("--resolution", 33, "--triangles", 600)
ROOTS = ("--roots", 40)
SCHEDULE = ("--schedule", "9(V) 13(FR)")
FRACTAL = ("fractal", "--map", "rational", "--rational")
# Neither at the origin nor of size 1, and longer along x than along y than along z.
FACTOR, PLACE = 30.0, (100.0, -40.0, 7.0)


def pebble():
    points, faces = harness.moved(harness.sphere(3), 1, (0, 0, 0))
    return harness.moved(([(x, 0.7 * y, 0.5 * z) for x, y, z in points], faces), FACTOR, PLACE)


def box_of(points):
    return [min(p[k] for p in points) for k in range(3)] + [max(p[k] for p in points) for k in range(3)]


class FitTest(harness.CliTest):
    """Each test has the mesh and its fit, which is made once."""

    @classmethod
    def setUpClass(cls):
        cls.made = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_test_"))
        cls.addClassCleanup(shutil.rmtree, cls.made, ignore_errors=True)
        maker = harness.CliTest()
        maker.folder = cls.made
        maker.write("m.obj", harness.obj(pebble()))
        cls.said = maker.ok("fit", "m.obj", "-o", "shape.json", *LOW, *ROOTS, "--report", "fit.csv", "--plot",
                            "fit.png")

    def setUp(self):
        super().setUp()
        for path in self.made.iterdir():
            shutil.copy(path, self.folder)

    def map_of(self, name="shape.json"):
        return json.loads(self.bytes(name))

    def assert_box(self, found, wanted, tolerance):
        for a, b in zip(found, wanted):
            self.assertAlmostEqual(a, b, delta=tolerance, msg=f"{found} for {wanted}")


class Fit(FitTest):

    def test_what_it_writes(self):
        self.assertEqual(self.listing(), ["fit.csv", "fit.png", "m.obj", "shape.json"])
        found = self.map_of()
        tops, bottoms = (len(found[side]["roots"]) for side in ("top", "bottom"))
        self.assertTrue(1 <= tops + bottoms <= 40)
        for root in found["top"]["roots"] + found["bottom"]["roots"]:
            self.assertGreater(root["power"], 0)
            self.assertEqual(root["position"][3], 0)
        target = found["target"]
        self.assert_box(target["centre"], PLACE, 0.05 * FACTOR)
        self.assertAlmostEqual(target["scale"], 2 * FACTOR, delta=0.02 * FACTOR)
        self.assert_box(target["box"], box_of(pebble()[0]), 0.02 * FACTOR)
        # The note is the command that makes it again, less what names files.
        self.assertIn("juliavdb fit --", found["note"])
        self.assertIn("--roots 40", found["note"])
        self.assertNotIn("m.obj", found["note"])

    def test_what_it_says(self):
        found = self.map_of()
        self.assertIn("wrote shape.json, fit.csv, fit.png: ", self.said)
        self.assertIn(f"{len(found['top']['roots'])} top and {len(found['bottom']['roots'])} bottom roots", self.said)
        # The set as 'fractal' makes it, and the first step alone, for which the powers were found.
        once, often, shift = map(float, re.search(r"IoU (\S+) after one iteration and (\S+) after 3, .* shifted by (\S+);",
                                                  self.said).groups())
        for iou in (often, once):
            self.assertTrue(0.95 < iou <= 1, iou)
        self.assertLess(shift, 0)
        self.assertNotIn("electrostatics", self.said)

    def test_report_and_plot(self):
        rows = list(csv.DictReader(io.StringIO(self.bytes("fit.csv").decode())))
        self.assertEqual([int(row["step"]) for row in rows], list(range(1, len(rows) + 1)))
        self.assertEqual({row["stage"] for row in rows}, {"roots", "energy"})
        self.assertIn(f"; {len(rows)} steps", self.said)
        for row in rows:
            self.assertTrue(0 <= float(row["iou"]) <= 1 and -1 <= float(row["psi"]) <= 1)
        self.assertTrue(0 < float(rows[-1]["mean_distance"]) < float(rows[-1]["hausdorff"]) < 0.1)
        found = self.map_of()
        self.assertEqual(int(rows[-1]["top_roots"]) + int(rows[-1]["bottom_roots"]),
                         len(found["top"]["roots"] + found["bottom"]["roots"]))
        self.assertEqual(harness.png_size(self.bytes("fit.png")), (900, 600))
        self.assertGreater(len({pixel for row in harness.read_png(self.bytes("fit.png")) for pixel in row}), 4)

    def test_charge(self):
        """The surface with its charge is a mesh that render shows, with the roots on it."""
        self.ok("fit", "m.obj", "-o", "c.json", *LOW, *ROOTS, "--charge", "charge.ply")
        self.assertEqual(self.bytes("c.json"), self.bytes("shape.json"), "the map does not depend on it")
        info = self.info("charge.ply")
        self.assertEqual(info["open edges"], 0)
        self.ok("render", "charge.ply", "--roots", "c.json", "--size", "60x60", "-o", "roots.png")
        self.ok("render", "charge.ply", "--size", "60x60", "-o", "charge.png")
        self.assertNotEqual(self.bytes("roots.png"), self.bytes("charge.png"))

    def test_schedule(self):
        text = self.ok("fit", "m.obj", "-o", "paper.json", *LOW, *ROOTS, *SCHEDULE, "--report", "paper.csv")
        self.assertRegex(text, r"electrostatics: \d+ monopoles, capacitance 0\.\d+")
        rows = list(csv.DictReader(io.StringIO(self.bytes("paper.csv").decode())))
        self.assertLessEqual({row["stage"] for row in rows}, {"9(V)", "13(F)", "13(R)"})
        self.assertIn("--schedule 9(V) 13(FR)", self.map_of("paper.json")["note"])
        self.ok(*FRACTAL, "paper.json", "-o", "f.vdb", "--resolution", 30, "--iterations", 1)

    def test_other_targets(self):
        """The mesh's distances in a VDB are a target too."""
        self.ok("sdf", "m.obj", "-o", "sdf.vdb", "--resolution", 60, "--band", 4)
        self.ok("fit", "sdf.vdb", "-o", "v.json", *LOW, *ROOTS, "--plot", "v.exr")
        self.assert_box(self.map_of("v.json")["target"]["box"], self.map_of()["target"]["box"], 0.02 * FACTOR)
        self.assertEqual(self.bytes("v.exr")[:4], bytes([0x76, 0x2F, 0x31, 0x01]))
        self.ok("fit", "sdf.vdb", "-o", "v.json", *LOW, *ROOTS, "--plot", "v.svg")
        self.assertIn(b"<svg ", self.bytes("v.svg")[:100])

    # Promise of fitting.md: "The same seed gives the same bytes" of a fit
    def test_same_bytes(self):
        results = set()
        for options in ((), ("--threads", 1), *(("--instructions", s) for s in self.instruction_sets())):
            self.ok("fit", "m.obj", "-o", "again.json", "--resolution", 24, "--triangles", 400, "--roots", 12, *options)
            results.add(self.bytes("again.json"))
        self.assertEqual(len(results), 1)

    # Promise: "The same seed gives the same ..."
    def test_same_bytes_of_a_schedule(self):
        results = set()
        for options in (("--threads", 1), ("--threads", 2), *(("--instructions", s) for s in self.instruction_sets())):
            self.ok("fit", "m.obj", "-o", "again.json", "--resolution", 24, "--triangles", 400, "--roots", 12,
                    "--schedule", "9(VFR)", *options)
            results.add(self.bytes("again.json"))
        self.assertEqual(len(results), 1)

    @staticmethod
    def instruction_sets():
        flags = pathlib.Path("/proc/cpuinfo").read_text().split()
        return ["portable"] + [name for name, flag in (("avx2", "avx2"), ("avx512", "avx512vl")) if flag in flags]


class Fractals(FitTest):
    """What fractal makes of a fitted map; no mesh is there."""

    def setUp(self):
        super().setUp()
        self.path("m.obj").unlink()
        self.box = box_of(pebble()[0])

    def mesh(self, *options, map_file="shape.json", resolution=40):
        size = ("--resolution", resolution) if resolution else ()
        self.ok(*FRACTAL, map_file, "--mesh", "f.ply", *size, *options)
        return harness.read_ply(self.bytes("f.ply"))

    # Promise of fitting.md: A fitted map "lies where the mesh was", without the mesh
    def test_has_the_meshs_place_and_size(self):
        volume = 4 * math.pi / 3 * 0.7 * 0.5 * FACTOR**3
        for iterations in (1, 4):
            with self.subTest(iterations=iterations):
                mesh = self.mesh("--iterations", iterations, "-o", "f.vdb")
                self.assertEqual(harness.open_edges(mesh), [])
                self.assert_box(box_of(mesh.points), self.box, 0.08 * 2 * FACTOR)
                self.assertAlmostEqual(harness.volume_of(mesh) / volume, 1, delta=0.1)
                self.assertEqual(self.info("f.vdb")["recipe"]["iterations"], str(iterations))

    def test_slice_leaves_the_target(self):
        at_0, sliced = (harness.volume_of(self.mesh("--iterations", 1, "--slice", s)) for s in (0, 0.15))
        self.assertLess(sliced, 0.98 * at_0)
        self.assertGreater(sliced, 0.1 * at_0)

    def test_moved_roots_move_the_first_iterate(self):
        """By 0.1 of the longest side: 6 units, which are four voxels, so that even the lattice is the same."""
        here = self.mesh("--iterations", 1, "--voxel-size", 1.5, resolution=None)
        there = self.mesh("--iterations", 1, "--voxel-size", 1.5, "--texture-translate", "0.1,0,0", resolution=None)
        by = 0.1 * self.map_of()["target"]["scale"]
        found = box_of(there.points)
        for k, (a, b) in enumerate(zip(box_of(here.points), found)):
            self.assertAlmostEqual(b - a, by if k % 3 == 0 else 0, delta=0.1)
        # Of more iterates the place stays 0's, and the shape changes.
        self.assertNotEqual(self.mesh("--iterations", 3).points,
                            self.mesh("--iterations", 3, "--texture-translate", "0.02,0,0").points)

    def test_is_a_versor(self):
        self.write("s.obj", harness.obj(harness.sphere(2)))
        self.ok("fractal", "s.obj", "--texture", "shape.json", "--resolution", 24, "--sdf-resolution", 24, "--mesh",
                "textured.ply")
        self.ok("fractal", "s.obj", "--resolution", 24, "--sdf-resolution", 24, "--mesh", "plain.ply")
        textured, plain = (harness.read_ply(self.bytes(name)) for name in ("textured.ply", "plain.ply"))
        self.assertNotEqual(textured.points, plain.points)
        # The space is that of the mesh, not of the shape that was fitted.
        self.assert_box(box_of(textured.points), [-1] * 3 + [1] * 3, 0.3)  # the detail goes as deep and as far

    def test_a_mesh_has_the_last_word_on_the_space(self):
        self.write("s.obj", harness.obj(harness.sphere(3)))
        self.ok("fractal", "s.obj", "--map", "rational", "--rational", "shape.json", "--iterations", 1, "--resolution",
                40, "--mesh", "small.ply")
        self.assert_box(box_of(harness.read_ply(self.bytes("small.ply")).points), [-1, -0.7, -0.5, 1, 0.7, 0.5], 0.16)

    def test_the_other_commands_take_it(self):
        self.ok(*FRACTAL, "shape.json", "-o", "f.vdb", "--mesh", "f.ply", "--resolution", 30, "--iterations", 2)
        info = self.info("f.vdb")
        self.assertEqual((info["recipe"]["map"], info["recipe"]["rational"]), ("rational", "shape.json"))
        self.ok("mesh", "f.vdb", "-o", "again.ply")
        self.assertEqual(harness.read_ply(self.bytes("again.ply")).points,
                         harness.read_ply(self.bytes("f.ply")).points)
        self.ok("mesh", "f.vdb", "-o", "grid.ply", "--from-grid")
        self.ok("slice", "f.vdb", "-o", "s.png", "--field", "f", "--size", 40)
        self.ok("slice", "f.vdb", "-o", "m.png", "--size", 40)
        self.ok("render", "f.vdb", "-o", "r.png", "--size", "40x40")
        for name in ("s.png", "m.png", "r.png"):
            self.assertGreater(len({p for row in harness.read_png(self.bytes(name)) for p in row}), 1, name)

    def test_the_files_make_it_again(self):
        self.ok(*FRACTAL, "shape.json", "-o", "f.vdb", "--mesh", "f.ply", "--resolution", 24, "--slice", 0.05)
        for config in ("f.vdb", "f.ply"):
            self.ok("fractal", "--config", config, "-o", "again.vdb", "--mesh", "again.ply")
            self.assertTrue(self.bytes("again.vdb") == self.bytes("f.vdb"), config)
            self.assertTrue(self.bytes("again.ply") == self.bytes("f.ply"), config)

    # Promise: A fitted map "lies where ..."
    def test_the_vdb_holds_its_map(self):
        """--rational reads it from there, with the target: the JSON may be gone."""
        self.ok(*FRACTAL, "shape.json", "-o", "f.vdb", "--mesh", "f.ply", "--resolution", 24)
        self.path("shape.json").unlink()
        self.ok(*FRACTAL, "f.vdb", "--mesh", "again.ply", "--resolution", 24)
        self.assertEqual(harness.read_ply(self.bytes("again.ply")).points, harness.read_ply(self.bytes("f.ply")).points)

    # Promise: A fitted map "lies where ..."
    def test_another_map_is_refused_unless_named(self):
        self.ok(*FRACTAL, "shape.json", "-o", "f.vdb", "--resolution", 24)
        # The same roots, of no target: in fractal space.
        roots = json.loads(self.bytes("shape.json"))
        del roots["target"]
        self.write("bare.json", json.dumps(roots).encode())
        box = ("--box", "-0.6,-0.6,-0.6,0.6,0.6,0.6")
        for option, other in (("rational", "texture"), ("texture", "rational")):
            self.ok("fractal", "--config", "f.vdb", f"--{option}", "bare.json", *box, "-o", f"{option}.vdb")
            recipe = self.info(f"{option}.vdb")["recipe"]
            self.assertEqual(recipe[option], "bare.json")
            self.assertNotIn(other, recipe)
        self.write("shape.json", self.bytes("bare.json"))
        self.refused(BAD_DATA, "fractal", "--config", "f.vdb", "-o", "x.vdb", mentions=["shape.json", "SHA-256"])

    # Promise: Files of the released programs ...
    def test_o3d(self):
        self.write("m.obj", harness.obj(pebble()))
        self.ok("fit", "m.obj", "-o", "shape.o3d", *LOW, *ROOTS)
        self.ok("fit", "m.obj", "-o", "SHAPE.O3D", *LOW, *ROOTS)
        self.assertEqual(self.bytes("SHAPE.O3D"), self.bytes("shape.o3d"))
        text = self.ok("versor", "inspect", "shape.o3d", data=True)
        self.assertIn(f"top: {len(self.map_of()['top']['roots'])} roots", text)
        self.ok("versor", "scale", "shape.o3d", 1, "-o", "back.json")
        for side in ("top", "bottom"):
            self.assertEqual(self.map_of("back.json")[side], self.map_of()[side])
        # It has the cube for its region, in fractal space.
        found = box_of(self.mesh("--iterations", 1, map_file="shape.o3d", resolution=48).points)
        self.assert_box(found, [-0.5, -0.35, -0.25, 0.5, 0.35, 0.25], 0.08)


class Refusals(FitTest):

    def test_targets(self):
        self.write("plane.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n")
        self.write("empty.obj", "")
        self.write("leaky.obj", harness.obj(harness.with_hole(harness.sphere(3), 0.94)))
        self.all_refused(BAD_DATA, [("fit", name, "-o", "x.json", "--report", "x.csv", "--plot", "x.png", *LOW)
                                    for name in ("plane.obj", "empty.obj", "leaky.obj")])
        self.refused(BAD_DATA, "fit", "leaky.obj", "-o", "x.json", *LOW, mentions="--repair")
        self.ok("fit", "leaky.obj", "-o", "x.json", "--resolution", 16, "--roots", 2, "--repair")
        self.refused(NO_INPUT, "fit", "nowhere.obj", "-o", "x.json", *LOW, mentions="nowhere.obj")
        self.refused(USAGE, "fit", "-o", "x.json", mentions="no target")
        self.refused(USAGE, "fit", "m.obj", mentions="-o")

    def test_options(self):
        bad = [("--roots", 0), ("--roots", -1), ("--roots", "x"), ("--epsilon", 0), ("--epsilon", 1),
               ("--epsilon", -1), ("--epsilon", "nan"), ("--target-iou", 0), ("--target-iou", 2), ("--resolution", 7),
               ("--alpha", -1), ("--start", "x"), ("--weights", "x"), ("--power-penalty", -1), ("--smooth", 5),
               ("--seed", -1), ("--iterations", 0), ("--iterations", 1.5), ("--nonsense", 1)]
        self.all_refused(USAGE, [("fit", "m.obj", "-o", "x.json", f"{name}={value}") for name, value in bad])
        for name, value in bad[:9]:
            self.refused(USAGE, "fit", "m.obj", "-o", "x.json", f"{name}={value}", mentions=[name, f"'{value}'"])

    def test_schedules(self):
        for schedule, character in (("25(VX)", 5), ("25", 3), ("25(V", 5), ("(V)", 1), ("25()", 4), ("2(V)", 1)):
            self.refused(USAGE, "fit", "m.obj", "-o", "x.json", "--schedule", schedule,
                         mentions=[schedule, f"at character {character}"])

    def test_outputs(self):
        self.path("folder.json").mkdir()
        job = ("fit", "m.obj", *LOW)
        self.all_refused(USAGE, [(*job, "-o", "x.vdb"), (*job, "-o", "x"), (*job, "-o", "x.p4d"),
                                 (*job, "-o", "x.json", "--report", "x.txt"),
                                 (*job, "-o", "x.json", "--plot", "x.jpg")],
                         mentions="x")
        self.all_refused(CANNOT_CREATE, [(*job, "-o", "nowhere/x.json"), (*job, "-o", "m.obj/x.json"),
                                         (*job, "-o", "folder.json"), (*job, "-o", "/proc/x.json"),
                                         (*job, "-o", "x.json", "--report", "nowhere/x.csv"),
                                         (*job, "-o", "x.json", "--plot", "nowhere/x.png")])

    def test_rational_with_the_wrong_options(self):
        self.refused(USAGE, "fractal", "m.obj", "--rational", "shape.json", "-o", "x.vdb", mentions="--map rational")
        self.refused(USAGE, *FRACTAL, "shape.json", "--texture", "shape.json", "-o", "x.vdb",
                     mentions=["--rational", "--texture"])
        self.refused(NO_INPUT, *FRACTAL, "nowhere.json", "-o", "x.vdb", mentions="nowhere.json")
        self.refused(USAGE, *FRACTAL, "m.obj", "-o", "x.vdb", mentions="m.obj")
        self.refused(USAGE, *FRACTAL, "random", "-o", "x.vdb", "--box", "-1,-1,-1,1,1,1", mentions="random")
        # A map that was fitted to nothing has no place.
        self.write("v.json", harness.rational_json(harness.ROOTS))
        self.refused(USAGE, *FRACTAL, "v.json", "-o", "x.vdb", mentions="give a box")
        self.refused(USAGE, *FRACTAL, "shape.json", "-o", "x.vdb", "--space", "world", mentions="give a box")

    def test_broken_maps(self):
        text = self.bytes("shape.json").decode()
        target = json.loads(text)["target"]
        scale, centre = f'"scale": {json.dumps(target["scale"])}', json.dumps(target["centre"][0])
        first = text.index('"power": ')
        power = text[first:text.index("}", first)]
        broken = {
            "cut": text[:len(text) // 2], "no_scale": text.replace(scale + ", ", ""),
            "zero_scale": text.replace(scale, '"scale": 0'), "minus_scale": text.replace(scale, '"scale": -3'),
            "no_target_centre": text.replace('"centre"', '"center"'),
            "nan": text.replace(power, '"power": NaN', 1), "infinite": text.replace(power, '"power": 1e999', 1),
            "no_power": text.replace(", " + power, "", 1), "text": text.replace(power, '"power": "2"', 1),
            "huge": text.replace(power, '"power": 1e10', 1),
            "flat": text.replace('"box": [', '"box": [0, 0, 0, 0, 0, 0], "x": ['),
            "no_top": text.replace('"top"', '"up"'), "array": "[]", "empty": "",
        }
        for name, content in broken.items():
            self.assertNotEqual(content, text, name)
            self.write(f"{name}.json", content)
        self.all_refused(BAD_DATA, [(*FRACTAL, f"{name}.json", "-o", "x.vdb", "--mesh", "x.ply") for name in broken])
        for name in ("zero_scale", "no_scale", "flat"):
            self.refused(BAD_DATA, *FRACTAL, f"{name}.json", "-o", "x.vdb", mentions=[f"{name}.json", "target"])

    def test_places_that_no_lattice_reaches(self):
        """Finite, yet so far or so large that voxels cannot be counted."""
        text = self.bytes("shape.json").decode()
        for box, centre, scale in (("[-1e300, -1, -1, 1e300, 1, 1]", "[0, 0, 0]", "1"),
                                   ("[1e15, 0, 0, 1000000000000001, 1, 1]", "[1e15, 0, 0]", "1"),
                                   ("[0, 0, 0, 1e-300, 1e-300, 1e-300]", "[0, 0, 0]", "1e-300")):
            head = text[:text.index('"target"')]
            self.write("far.json", f'{head}"target": {{"centre": {centre}, "scale": {scale}, "box": {box}}}\n}}\n')
            run = self.run_program(*FRACTAL, "far.json", "-o", "x.vdb", "--resolution", 24)
            self.assertIn(run.returncode, (USAGE, BAD_DATA), run.stderr.decode())
            self.check_refusal(run, run.returncode, box)
            self.assertFalse(self.path("x.vdb").exists())


if __name__ == "__main__":
    harness.main()

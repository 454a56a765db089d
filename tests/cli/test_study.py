# SPDX-License-Identifier: Apache-2.0
"""The command study: its average against slices of the same versors, its circles, its refusals."""

import csv
import io
import json
import math
import os
import pathlib
import re

import harness
from harness import BAD_DATA, CANNOT_CREATE, NO_INPUT, USAGE

LOW = ("--sdf-resolution", 32, "--size", 40)
ROUGH = ("--alpha", 8)


class StudyTest(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.centre, self.radius = (3.0, -2.0, 1.0), 2.0
        self.write("s.obj", harness.obj(harness.sphere(3, self.radius, self.centre)))
        self.write("t.obj", harness.obj(harness.torus()))

    def picture(self, name="x.png"):
        return harness.read_png(self.bytes(name))

    def circles(self, name="x.csv"):
        return [{key: float(value) for key, value in row.items()}
                for row in csv.DictReader(io.StringIO(self.bytes(name).decode()))]


class Average(StudyTest):

    # Promise of study.md: A texture of a study is the slice of its seed: "texture k has the seed S + k"
    def test_one_versor_is_its_slice(self):
        for options in ((), ("--axis", "x"), ("--position", 1.5, "--texture-seed", 9), ("--texture-placement", "inside"),
                        ("--box", "2,-3,0,4,0,2"), ("--precision", "double", "--iterations", 5)):
            with self.subTest(options=options):
                self.ok("study", "s.obj", *LOW, *ROUGH, *options, "--versors", 1, "-o", "x.png")
                self.ok("slice", "s.obj", *LOW, *ROUGH, "--texture", "random", *options, "-o", "slice.png")
                self.assertTrue(self.bytes("x.png") == self.bytes("slice.png"))

    # Promise: A texture of a study is the slice ...
    def test_many_are_their_mean(self):
        """In even steps of sRGB, which is what the PNG holds."""
        count = 5
        for options in (("--texture-seed", 3), ("--texture-seed", 2**64 - count, "--slice", 0.1)):
            self.ok("study", "s.obj", *LOW, *ROUGH, *options, "--versors", count, "-o", "x.png")
            sets = []
            for k in range(count):
                seed = ("--texture-seed", options[1] + k, *options[2:])
                self.ok("slice", "s.obj", *LOW, *ROUGH, *seed, "-o", "slice.png")
                sets.append(self.picture("slice.png"))
            greys = set()
            for y, row in enumerate(self.picture()):
                for x, pixel in enumerate(row):
                    white = sum(one[y][x] == (255, 255, 255) for one in sets)
                    self.assertEqual(len(set(pixel)), 1)
                    self.assertAlmostEqual(pixel[0], 255 * white / count, delta=1)
                    greys.add(white)
            self.assertEqual(len(greys), count + 1, "the sets agree more than random ones should")

    # Promise: A texture of a study is the slice ...
    def test_the_plane_goes_through_the_origin(self):
        """The box's middle lies in the torus's hole; the dynamics take the deepest point, and so does the plane."""
        self.ok("study", "t.obj", *LOW, "--versors", 2, "-o", "x.png", "--csv", "x.csv", "--axis", "x")
        self.assertLess(self.circles()[0]["mean"], -0.25)
        said = self.ok("study", "t.obj", *LOW, "--versors", 2, "-o", "y.png", "--origin-shift", "0,0.6,0")
        self.assertIn("origin lies outside", said)

    # Promise: "The same recipe gives the same ..."
    def test_same_bytes(self):
        flags = pathlib.Path("/proc/cpuinfo").read_text().split()
        sets = ["portable"] + [name for name, flag in (("avx2", "avx2"), ("avx512", "avx512vl")) if flag in flags]
        results = set()
        for options in [("--threads", 1), ("--threads", 2), ()] + [("--instructions", name) for name in sets]:
            self.ok("study", "t.obj", *LOW, "--alpha", 60, "--versors", 66, "-o", "x.png", "--curve", "c.svg", "--csv", "x.csv",
                    *options)
            results.add((self.bytes("x.png"), self.bytes("c.svg"), self.bytes("x.csv")))
        self.assertEqual(len(results), 1)
        self.assertIn(b"<svg ", self.bytes("c.svg")[:100])

    def test_other_targets(self):
        """A VDB with distances, and a fractal, which brings its recipe."""
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 32)
        self.ok("study", "s.vdb", "--size", 24, "--versors", 3, "-o", "x.exr", "--curve", "c.exr")
        for name in ("x.exr", "c.exr"):
            self.assertEqual(self.bytes(name)[:4], bytes([0x76, 0x2F, 0x31, 0x01]))
        self.ok("fractal", "s.obj", "--sdf-resolution", 32, "--resolution", 24, *ROUGH, "--texture-seed", 6, "-o",
                "f.vdb")
        self.ok("study", "f.vdb", "--size", 40, "--versors", 3, "-o", "x.png")
        self.ok("study", "s.obj", *LOW, *ROUGH, "--resolution", 24, "--texture-seed", 6, "--versors", 3, "-o", "y.png")
        self.assertTrue(self.bytes("x.png") == self.bytes("y.png"))

    def test_config(self):
        self.write("job.cfg", "input = s.obj\nalpha = 8\nsdf-resolution = 32\n")
        self.ok("study", "--config", "job.cfg", "--size", 40, "--versors", 2, "-o", "x.png")
        self.ok("study", "s.obj", *LOW, *ROUGH, "--versors", 2, "-o", "y.png")
        self.assertTrue(self.bytes("x.png") == self.bytes("y.png"))


class Curve(StudyTest):

    # Promise of study.md: The lines of the study's `--csv`, and what the shaded range says
    def test_distance_about_a_sphere(self):
        said = self.ok("study", "s.obj", *LOW, "--alpha", 20, "--versors", 20, "-o", "x.png", "--csv", "x.csv", "--curve",
                       "c.png")
        self.assertIn("wrote x.png, c.png, x.csv: 40 x 40, 20 versors from seed 1 on", said)
        self.assertEqual(harness.png_size(self.bytes("c.png")), (900, 600))
        high = 2 * self.radius * math.log(20) / 20
        self.assertRegex(said, rf"phi is between -[0-9.]+ and {high:.4g}")
        low = float(said.split("between ")[1].split()[0])
        circles = self.circles()
        self.assertEqual(list(circles[0]), ["radius", "mean", "least", "greatest", "sphere_mean", "membership"])
        self.assertEqual((circles[0]["radius"], circles[0]["membership"]), (0, 1))
        self.assertEqual(circles[-1]["membership"], 0)
        for row in circles:
            wanted = row["radius"] - self.radius
            tolerance = 0.06 if row["radius"] > 0.3 else 0.2
            self.assertAlmostEqual(row["mean"], wanted, delta=tolerance)
            self.assertAlmostEqual(row["sphere_mean"], wanted, delta=tolerance)
            self.assertTrue(row["least"] <= row["mean"] <= row["greatest"])
            if row["greatest"] < low:
                self.assertEqual(row["membership"], 1)
            if row["least"] > high:
                self.assertEqual(row["membership"], 0)
        self.assertTrue(any(0.1 < row["membership"] < 0.9 for row in circles))

    # Promise: The lines of the study's ...
    def test_curve_shades_what_is_undecided(self):
        self.ok("study", "s.obj", *LOW, "--versors", 1, "-o", "x.png", "--curve", "flat.png")
        self.ok("study", "s.obj", *LOW, "--versors", 1, "-o", "x.png", "--curve", "ramp.png", "--alpha", "x:20:40")
        colours = lambda name: {pixel for row in self.picture(name) for pixel in row}
        # The ramp has no single range to shade; the curve is the same.
        self.assertGreater(len(colours("flat.png") - colours("ramp.png")), 0)


class Refusals(StudyTest):

    def test_options(self):
        bad = [("--versors", 0), ("--versors", -1), ("--versors", 1.5), ("--versors", "x"), ("--versors", 10**9),
               ("--size", 0), ("--size", -3), ("--size", 10**6), ("--axis", "w"), ("--position", "nan"), ("--alpha", 0),
               ("--alpha", "x"), ("--texture-seed", -1), ("--map", "quadratic"), ("--texture", "v.json"), ("--grids", "f"),
               ("--iterations", 0), ("--escape", 1)]
        self.all_refused(USAGE, [("study", "s.obj", "-o", "x.png", "--csv", "x.csv", "--sdf-resolution", 16,
                                  f"{name}={value}") for name, value in bad])
        for name, value in bad[:10]:
            self.refused(USAGE, "study", "s.obj", "-o", "x.png", f"{name}={value}", mentions=[name, f"'{value}'"])
        self.refused(USAGE, "study", "s.obj", *LOW, "-o", "x.png", "--texture-seed", 2**64 - 3, "--versors", 4,
                     mentions="seeds do not fit")
        self.refused(USAGE, "study", "-o", "x.png", mentions="no target")
        self.refused(USAGE, "study", "s.obj", mentions="-o")

    def test_targets(self):
        self.write("leaky.obj", harness.obj(harness.with_hole(harness.sphere(3), 0.94)))
        self.refused(BAD_DATA, "study", "leaky.obj", *LOW, "-o", "x.png", mentions="--repair")
        self.ok("study", "leaky.obj", *LOW, "--versors", 2, "-o", "x.png", "--repair")
        self.path("x.png").unlink()
        self.refused(NO_INPUT, "study", "nowhere.obj", *LOW, "-o", "x.png", mentions="nowhere.obj")

    def test_fractals_of_other_maps_and_versors(self):
        self.write("v.json", harness.rational_json(harness.ROOTS))
        small = ("--resolution", 20, "--sdf-resolution", 20)
        self.ok("fractal", "--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", "--resolution", 20, "-o", "q.vdb")
        self.ok("fractal", "s.obj", "--texture", "v.json", *small, "-o", "v.vdb")
        self.refused(USAGE, "study", "q.vdb", "-o", "x.png", mentions="map")
        self.refused(USAGE, "study", "v.vdb", "-o", "x.png", mentions="v.json")

    # Promise of study.md: "A name that ends in `.svg` gives SVG"
    def test_outputs(self):
        self.path("folder.png").mkdir()
        for option, name in (("-o", "nowhere/x.png"), ("-o", "folder.png"), ("--curve", "nowhere/c.png"),
                             ("--csv", "nowhere/x.csv")):
            rest = () if option == "-o" else ("-o", "x.png")
            self.refused(CANNOT_CREATE, "study", "s.obj", *LOW, *rest, option, name, mentions=name)
        self.refused(USAGE, "study", "s.obj", "-o", "x.png", "--csv", "x.png", mentions="x.png")
        self.refused(USAGE, "study", "s.obj", "-o", "x.vdb", mentions="x.vdb")
        # Of several outputs none is left when one cannot be made.
        if os.path.exists("/dev/full"):
            self.refused(harness.IO_ERROR, "study", "s.obj", *LOW, "--versors", 2, "-o", "x.png", "--csv", "/dev/full")


class Dimension(StudyTest):
    """How meshes grow with their resolution."""

    SMALL = ("--sdf-resolution", 32, "--progress", "none")

    # Promise of scale.md: "`juliavdb study --dimension N,N,...` measures the exponent from whole meshes, with its standard error"
    def test_a_smooth_surface_has_two(self):
        for name in ("s.obj", "t.obj"):
            text = self.ok("study", name, *self.SMALL, "--mask", 0, "--dimension", "24,48,96", data=True)
            dimension = float(re.search(r"^dimension ([0-9.]+), standard error", text, re.MULTILINE).group(1))
            self.assertAlmostEqual(dimension, 2, delta=0.03)

    # Promise: "`juliavdb study --dimension N,N,...` ..."
    def test_the_rows_are_what_fractal_makes(self):
        rough = ("--alpha", 20, "--iterations", 5, "--texture", "random")
        numbers = json.loads(self.ok("study", "t.obj", *self.SMALL, *rough, "--dimension", "20,30,45", "--json", data=True))
        self.assertEqual([row["resolution"] for row in numbers["rows"]], [20, 30, 45])
        for row in numbers["rows"]:
            self.ok("fractal", "t.obj", *self.SMALL, *rough, "--resolution", row["resolution"], "--mesh", "x.ply")
            header = self.bytes("x.ply").split(b"end_header")[0].decode()
            self.assertIn(f"element face {row['triangles']}\n", header)
            self.assertIn(f"element vertex {row['points']}\n", header)
        # By the normal equations of least squares: residuals are orthogonal to 1 and to x.
        x = [math.log(row["resolution"]) for row in numbers["rows"]]
        left = [math.log(row["triangles"] / numbers["factor"]) - numbers["dimension"] * a
                for row, a in zip(numbers["rows"], x)]
        self.assertAlmostEqual(sum(left), 0)
        self.assertAlmostEqual(sum(a * b for a, b in zip(x, left)), 0)
        self.assertLess(numbers["interval"][0], numbers["dimension"])
        self.assertLess(numbers["dimension"], numbers["interval"][1])

    def test_refusals(self):
        study = ("study", "s.obj", *self.SMALL)
        self.all_refused(USAGE, [
            *[(*study, "--dimension", text) for text in ("", "20", "20,40", "20,20,40", "40,30,20", "4,8,16", "a,b,c", "20,30,")],
            (*study, "--dimension", "20,30,40", "--resolution", 20),
            (*study, "--dimension", "20,30,40", "-o", "x.png"),
            ("study", "--dimension", "20,30,40"),
        ])
        self.refused(BAD_DATA, *study, "--dimension", "20,30,40", "--detail", 0.5, "--box", "50,50,50,51,51,51")
        for option, value in (("--csv", "x.csv"), ("--curve", "x.png"), ("--versors", 9), ("--axis", "x"), ("-o", "x.png")):
            self.refused(USAGE, *study, "--dimension", "20,30,40", option, value,
                         mentions=(f"{option} has no effect", "--dimension"))


if __name__ == "__main__":
    harness.main()

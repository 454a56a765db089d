# SPDX-License-Identifier: Apache-2.0
# Promise: "neither the instruction set ..."
"""Another C library changes no byte: neither of fields and meshes, nor of pictures, plots and numbers.

JULIAVDB_OTHER_LIBM names a library to be preloaded, whose functions (sin, exp, pow ...) give another last bit wherever
IEEE 754 leaves it open. It reaches the libraries that the program uses as well.
"""

import math
import os
import re
import subprocess
import sys
import unittest

import harness

LOW = ("--resolution", 20, "--sdf-resolution", 20)
SMALL = ("--size", "40x40", "--samples", 1)
# All functions of formulas, of numbers that come from a place.
FORMULA = ("0.2 + 0.01 * (sin(x) + cos(1e12*y) + tan(z) + asin(x/9) + acos(y/9) + atan(z) + sinh(x) + cosh(y) + tanh(z) +"
           " exp(x) + ln(2+y) + log(9+x) + log2(9+z) + log10(9+x) + abs(y)^1.7 + (2+z)^-3 + atan2(x, y))")


class AnotherLibrary(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.other = os.environ.get("JULIAVDB_OTHER_LIBM")
        if not self.other:
            self.skipTest("JULIAVDB_OTHER_LIBM does not name the library that stands for another C library")
        self.write("t.obj", harness.obj(harness.torus()))

    def same(self, outputs, *arguments, data=False):
        """@param outputs: the files that the command writes, or none where its result is data"""
        made = []
        for env in ({}, {"LD_PRELOAD": self.other}):
            said = self.ok(*arguments, env=env, data=data)
            made.append([said if data else b""] + [self.bytes(name) for name in outputs])
        for name, first, second in zip(["stdout", *outputs], *made):
            self.assertTrue(first == second, f"{arguments}: the bytes of {name} differ")

    def test_the_library_is_another(self):
        words = [sys.executable, "-c", "import math; print([getattr(math, n)(0.7).hex() for n in ('exp', 'sin', 'log')])"]
        mine, other = (subprocess.run(words, env={**os.environ, **more}, check=True, capture_output=True, text=True).stdout
                       for more in ({}, {"LD_PRELOAD": self.other}))
        for a, b in zip(re.findall(r"0x[^']+", mine), re.findall(r"0x[^']+", other)):
            self.assertEqual(abs(float.fromhex(a) - float.fromhex(b)), math.ulp(float.fromhex(a)))

    def test_fractals(self):
        self.write("v.json", harness.rational_json(harness.ROOTS, harness.ROOTS[:1]))
        for options in (("t.obj", "--colour", "depth", "--grids", "surface,density,logmodulus,iterations,versor"),
                        ("t.obj", "--alpha", "x:10:100:smooth", "--beta", "y:0:0.02", "--colour", "direction"),
                        ("t.obj", "--detail", "expr:" + FORMULA),
                        ("t.obj", "--texture", "rings", "--detail", 0.3), ("t.obj", "--texture", "coral", "--follow"),
                        ("t.obj", "--texture-placement", "surface", "--texture-roots", 20),
                        ("t.obj", "--map", "rational", "--texture", "v.json"),
                        ("--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", "--iterations", 8),
                        ("--map", "mandelbulb", "--power", 8), ("--map", "mandelbulb", "--power", 2.5),
                        ("--map", "cross", "--f", f"{FORMULA}, y, z", "--g", "cos(x), y^2.5, exp(z)", "--radius", 5)):
            with self.subTest(options=options):
                low = LOW if options[0] == "t.obj" else LOW[:2]
                self.same(["x.vdb", "x.ply"], "fractal", *options, *low, "-o", "x.vdb", "--mesh", "x.ply")

    def test_targets(self):
        self.write("hole.obj", harness.obj(harness.with_hole(harness.sphere(3), 0.94)))
        self.same(["x.vdb"], "sdf", "hole.obj", "-o", "x.vdb", "--resolution", 24, "--repair")
        self.same(["x.ply"], "points", "t.obj", "-o", "x.ply", "--points", 300)
        self.same(["x.3mf"], "print", "t.obj", "-o", "x.3mf", "--size", 20, "--resolution", 24)
        self.same(["x.glb"], "fractal", "t.obj", *LOW, "--mesh", "x.glb", "--lod", "100%,50%")

    def test_versors(self):
        for texture in re.findall(r"^(\w+)", self.ok("versor", "list", data=True), re.M):
            with self.subTest(texture=texture):
                if texture in ("rings", "shells"):
                    self.same(["x.json"], "versor", "new", "--texture", texture, "-o", "x.json")
                self.same(["x.ply"], "fractal", "t.obj", "--texture", texture, *LOW, "--mesh", "x.ply")
        self.same(["x.json", "x.svg"], "fit", "t.obj", "-o", "x.json", "--plot", "x.svg", "--roots", 5, "--resolution", 14,
                  "--triangles", 100)
        self.same(["y.json"], "versor", "scale", "x.json", 0.7, "-o", "y.json")

    def test_pictures(self):
        self.ok("fractal", "t.obj", *LOW, "-o", "f.vdb", "--grids", "surface,versor,logmodulus")
        for ramp in ("ramp.exr", "ramp.png"):
            self.same([ramp], "slice", "f.vdb", "-o", ramp, "--size", 16)
            self.same(["x.ply"], "fractal", "t.obj", *LOW, "--mesh", "x.ply", "--colour", "depth:" + ramp)
        self.same(["x.png"], "render", "f.vdb", "-o", "x.png", *SMALL, "--azimuth", 33, "--elevation", 21)
        self.same(["x.exr"], "render", "f.vdb", "-o", "x.exr", *SMALL, "--fov", 50)
        self.same(["x.png"], "render", "--field", "--map", "mandelbulb", "-o", "x.png", *SMALL)
        self.same(["x.png"], "sheet", "t.obj", "-o", "x.png", "--vary", "detail=0.1,0.4", *SMALL, "--sdf-resolution", 16)
        for field in ("versor", "f"):
            self.same(["x.png"], "slice", "f.vdb", "-o", "x.png", "--size", 40, "--field", field)

    def test_studies(self):
        self.same(["x.png", "x.svg", "x.csv"], "study", "t.obj", "-o", "x.png", "--curve", "x.svg", "--csv", "x.csv",
                  "--versors", 3, "--size", 24, "--sdf-resolution", 16)
        self.same([], "study", "t.obj", "--dimension", "12,16,20", "--sdf-resolution", 16, data=True)


if __name__ == "__main__":
    harness.main()

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Textures that follow the thickness: detail on thin parts as on thick ones, --frequency in all its forms, and the laws of
every other fractal: skipped as exhaustive, tiles as one run, any threads."""
import math
import shutil
import unittest

import harness
from harness import BAD_DATA, USAGE

LOW = ("--resolution", 60, "--sdf-resolution", 60)


def body_and_wand():
    """A ball of radius 1 at 0, and one of radius 1/8 at (2, 0, 0): two parts of one mesh."""
    points, triangles = harness.sphere(4)
    more, others = harness.sphere(4, 1 / 8, (2, 0, 0))
    return [*points, *more], [*triangles, *(tuple(i + len(points) for i in triangle) for triangle in others)]


def roughness(mesh, centre, least, most):
    """How much the normals of the faces between two distances from a centre turn away from the direction outward."""
    total = turned = 0
    for triangle in mesh.faces:
        a, b, c = (mesh.points[i] for i in triangle)
        middle = [(a[k] + b[k] + c[k]) / 3 - centre[k] for k in range(3)]
        distance = math.hypot(*middle)
        if not least < distance < most:
            continue
        u, v = [b[k] - a[k] for k in range(3)], [c[k] - a[k] for k in range(3)]
        normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        area = math.hypot(*normal)
        total += area
        turned += area - sum(normal[k] * middle[k] for k in range(3)) / distance
    return turned / total


class Frequency(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("t.obj", harness.obj(body_and_wand()))

    def points(self, *options, low=LOW):
        self.ok("fractal", "t.obj", *low, *options, "--mesh", "x.ply")
        return harness.read_ply(self.bytes("x.ply"))

    # Promise of textures.md: Textures of waves: "their detail is as fine at each place as the target is thin there"
    def test_a_small_part_has_detail_of_its_own(self):
        """The small ball is 20 voxels wide, and a feature about 6; of rings about the origin of the large one, it has none."""
        fine = ("--resolution", 240, "--sdf-resolution", 240)
        small = lambda versor: roughness(self.points("--texture", versor, low=fine), (2, 0, 0), 0.05, 0.3)
        rings = small("rings")
        for versor in ("scales", "coral", "bark"):
            with self.subTest(versor=versor):
                self.assertGreater(small(versor), max(0.2, 3 * rings))

    # Promise: Versors of waves are those ...
    def test_the_same_in_all_ways(self):
        for options in ((), ("--texture", "quills", "--frequency", "fine"), ("--texture", "coral", "--frequency", "x:1:3"),
                        ("--texture", "thorns", "--frequency", "expr:1 + hx", "--slice", 0.1, "--drop-axis", "i")):
            with self.subTest(options=options):
                mesh = self.points(*options)
                self.assertTrue(mesh.points == self.points(*options, "--exhaustive").points)
                self.assertTrue(mesh.points == self.points(*options, "--threads", 1, "--instructions", "portable").points)
                self.ok("plan", "tiles", "t.obj", *LOW, *options, "--tiles", 3, "-o", "plan")
                self.ok("submit", "plan", "--engine", "parallel", "--mesh", "tiles.ply")
                self.assertTrue(mesh.points == harness.read_ply(self.bytes("tiles.ply")).points)
                shutil.rmtree(self.path("plan"))

    # Promise of textures.md: `--frequency`: words, numbers, controls; "A frequency so high that no feature is as wide as two
    #   voxels anywhere is refused"; textures of roots "take no frequency"
    def test_words_and_numbers(self):
        for word, number in (("coarse", 1), ("medium", 2), ("fine", 4)):
            self.assertTrue(self.points("--frequency", word).points == self.points("--frequency", number).points, word)
        mesh = self.points()
        default = mesh.points
        self.assertTrue(default == self.points("--frequency", "medium").points)
        self.assertFalse(default == self.points("--frequency", "fine").points)
        # A texture of twice the size at twice the frequency is itself, but for the rounding of the octave.
        same, fine = self.points("--frequency", 4, "--texture-scale", 2), self.points("--frequency", 4)
        self.assertLess(abs(len(same.faces) - len(mesh.faces)), 0.005 * len(mesh.faces))
        self.assertGreater(abs(len(fine.faces) - len(mesh.faces)), 0.02 * len(mesh.faces))
        self.assertFalse(self.points("--texture-translate", "0.1,0,0").points == default)

    # Promise: `--frequency`: words, numbers, controls; "A frequency ..."
    def test_a_recipe_holds_it(self):
        self.ok("fractal", "t.obj", *LOW, "--frequency", "x:1:3", "-o", "one.vdb")
        self.ok("fractal", "--config", "one.vdb", "-o", "two.vdb")
        self.assertEqual(self.bytes("one.vdb"), self.bytes("two.vdb"))
        self.ok("fractal", "--config", "one.vdb", "--texture", "rings", "-o", "three.vdb")
        self.ok("fractal", "--config", "one.vdb", "--texture-seed", 3, "-o", "four.vdb")

    # Promise: `--frequency`: words, numbers, controls; "A frequency ..."
    def test_bad_ones(self):
        for value in ("0", "-2", "nan", "inf", "middling", "1000000"):
            with self.subTest(frequency=value):
                self.refused(USAGE, "fractal", "t.obj", *LOW, "--frequency", value, "-o", "x.vdb",
                             mentions=("--frequency", value))
        self.refused(USAGE, "fractal", "t.obj", *LOW, "--frequency", "x:-1:2", "-o", "x.vdb", mentions="frequency")
        self.refused(USAGE, "fractal", "t.obj", *LOW, "--frequency", "2", "--texture", "rings", "-o", "x.vdb",
                     mentions="--frequency has no effect")
        self.refused(USAGE, "fractal", "t.obj", *LOW, "--frequency", "2", "--texture-seed", 4, "-o", "x.vdb",
                     mentions="--frequency has no effect")
        self.refused(USAGE, "fractal", "--map", "rational", "t.obj", *LOW, "--texture", "scales", "-o", "x.vdb",
                     mentions="thickness")
        self.ok("sdf", "t.obj", "-o", "below.vdb", "--resolution", 30)
        self.refused(BAD_DATA, "fractal", "t.obj", *LOW, "--frequency", "below.vdb", "-o", "x.vdb", mentions="below.vdb")


if __name__ == "__main__":
    unittest.main()

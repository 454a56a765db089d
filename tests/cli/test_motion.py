#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Targets that move: the fractal of the target at rest, carried along. Where the rest comes from, the laws of every other
fractal (skipped as exhaustive, tiles as one run, any threads, recipes again), sequences, and what is refused."""
import math
import os
import struct
import unittest

import harness
import test_animation
from harness import BAD_DATA, NO_INPUT, USAGE

LOW = harness.TextureTest.LOW


def bent(mesh, degrees):
    """Bends what lies beyond x = -0.3 to 0.3 by an angle in the plane of X and Y."""
    points, faces = mesh
    turn = math.radians(degrees)
    radius = 0.6 / turn
    result = []
    for x, y, z in points:
        angle = min(max((x + 0.3) / 0.6, 0), 1) * turn
        beyond = x - min(max(x, -0.3), 0.3)
        c, s = math.cos(angle), math.sin(angle)
        result.append((-0.3 + radius * s + beyond * c - y * s, radius * (1 - c) + beyond * s + y * c, z))
    return result, faces


def tilted(mesh):
    """Turned so that the axis of Y is the diagonal of its box, of which a ring or a rod then fills less: what a pose costs grows
    with that share."""
    axes = (6 ** -0.5, 6 ** -0.5, -2 * 6 ** -0.5), (3 ** -0.5, ) * 3, (2 ** -0.5, -2 ** -0.5, 0)
    return [tuple(x * a + y * b + z * c for a, b, c in zip(*axes)) for x, y, z in mesh[0]], mesh[1]


def ring(**counts):
    return tilted(harness.torus(minor=0.15, **counts))


def as_float(value):
    return struct.unpack("f", struct.pack("f", value))[0]


def moved(mesh, by):
    points, faces = mesh
    return [tuple(a + b for a, b in zip(p, by)) for p in points], faces


def with_rest(pose, rest, name="rest", other=None):
    """A PLY as text, with the points at rest as an attribute, and with an attribute of the name rest for other points."""
    lines = ["ply", "format ascii 1.0", f"element vertex {len(pose[0])}", *(f"property float {axis}" for axis in "xyz"),
             *(f"property float {name}_{axis}" for axis in "xyz"),
             *(f"property float rest_{axis}" for axis in "xyz" if other), f"element face {len(pose[1])}",
             "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(map(repr, (*p, *r, *o))) for p, r, o in zip(pose[0], rest[0], other or [()] * len(pose[0]))]
    return "\n".join(lines + ["3 {} {} {}".format(*face) for face in pose[1]]) + "\n"


class Motion(harness.TextureTest):

    def setUp(self):
        super().setUp()
        self.rest = ring()
        self.pose = bent(self.rest, 40)
        self.write("r.obj", harness.obj(self.rest))
        self.write("t.obj", harness.obj(self.pose))

    # Promise of motion.md: "no node is skipped that would change the result, tiles give the bytes of one run, and so does any
    #   number of threads" where a target moves
    def test_the_same_in_all_ways(self):
        for family in ((), ("--texture", "fur", "--grain", "along", "--rest-depth", "kept"),
                       ("--texture", "random", "--detail", "y:0.2:0.5")):
            with self.subTest(family=family):
                self.assert_the_same_in_all_ways("--rest", "r.obj", *family)

    def test_at_rest_it_is_the_still(self):
        """Up to rounding, by which a few edges may change."""
        still = {tuple(round(c, 4) for c in p) for p in self.points_of("r.obj")}
        again = {tuple(round(c, 4) for c in p) for p in self.points_of("r.obj", "--rest", "r.obj")}
        self.assertGreater(len(still & again), 0.98 * len(still))

    def points_of(self, target, *options):
        self.ok("fractal", target, *LOW, *options, "--mesh", "x.ply")
        return harness.read_ply(self.bytes("x.ply")).points

    def test_a_target_that_is_moved_by_voxels_takes_its_fractal_along(self):
        """The lattice has voxels of 1/20 here, so it coincides with itself."""
        self.write("m.obj", harness.obj(moved(self.rest, (1, -0.5, 2))))
        size = ("--voxel-size", 0.0625, "--sdf-resolution", 40)
        self.ok("fractal", "r.obj", *size, "--mesh", "a.ply")
        self.ok("fractal", "m.obj", "--rest", "r.obj", *size, "--mesh", "b.ply")
        key = lambda p, by: tuple(round(c - b, 4) for c, b in zip(p, by))
        still = {key(p, (0, 0, 0)) for p in harness.read_ply(self.bytes("a.ply")).points}
        along = {key(p, (1, -0.5, 2)) for p in harness.read_ply(self.bytes("b.ply")).points}
        self.assertGreater(len(still & along), 0.98 * len(still))

    def test_three_ways_to_say_what_is_at_rest(self):
        expected = self.points("--rest", "r.obj")
        self.write("t.ply", with_rest(self.pose, self.rest))
        # The attribute has 32 bits, and so has a rest that is read from it.
        self.write("r.obj", harness.obj(([tuple(as_float(c) for c in p) for p in self.rest[0]], self.rest[1])))
        self.assertEqual(len(self.points_of("t.ply", "--rest-attribute", "rest")), len(self.points("--rest", "r.obj")))
        self.assertLess(abs(len(expected) - len(self.points("--rest", "r.obj"))), 0.01 * len(expected))

    def test_a_frame_of_its_own_animation_is_at_rest(self):
        self.write("walk.gltf", test_animation.walk().text())
        for name, frame in (("home.obj", 6), ("pose.obj", 18)):
            self.write(name, test_animation.obj_text(*test_animation.shown(frame)))
        size = ("--resolution", 40, "--sdf-resolution", 100)
        self.ok("fractal", "walk.gltf", "--target-frame", 18, "--rest-frame", 6, *size, "--mesh", "a.ply")
        self.ok("fractal", "pose.obj", "--rest", "home.obj", *size, "--mesh", "b.ply")
        a, b = ({tuple(round(c, 3) for c in p) for p in harness.read_ply(self.bytes(n)).points} for n in ("a.ply", "b.ply"))
        self.assertGreater(len(a & b), 0.9 * len(a))
        self.ok("fractal", "walk.gltf", "--frames", "18,19", "--rest-frame", 6, *size, "--mesh", "s.####.ply")
        self.assertEqual(harness.read_ply(self.bytes("s.0018.ply")).points, harness.read_ply(self.bytes("a.ply")).points)

    def test_files_record_what_was_at_rest(self):
        self.ok("fractal", "t.obj", "--rest", "r.obj", *LOW, "-o", "a.vdb")
        info = self.ok("info", "a.vdb", data=True)
        for words in ("rest: r.obj", "rest-depth: stretched", "rest-sha256", "julia_rest_jumps"):
            self.assertIn(words, info)
        self.ok("fractal", "--config", "a.vdb", "-o", "b.vdb")
        self.assertEqual(self.bytes("a.vdb"), self.bytes("b.vdb"))
        self.write("r.obj", harness.obj(moved(self.rest, (0, 0, 1e-3))))
        self.refused(BAD_DATA, "fractal", "--config", "a.vdb", "-o", "c.vdb", mentions=("r.obj",))
        # A fractal that does not move records nothing of this.
        self.ok("fractal", "t.obj", *LOW, "-o", "still.vdb")
        self.assertNotIn("rest", self.ok("info", "still.vdb", data=True))

    def test_a_sequence_is_its_frames(self):
        for frame, degrees in ((-1, 10), (0, 20), (1, 30)):
            self.write(f"s.{frame:04}.obj" if frame >= 0 else "s.-0001.obj", harness.obj(bent(self.rest, degrees)))
        self.ok("fractal", "s.####.obj", "--rest", "r.obj", *LOW, "--frames", "-1-1", "--mesh", "a.####.ply", "-o", "a.####.vdb")
        sizes = set()
        for name in ("-0001", "0000", "0001"):
            self.ok("fractal", f"s.{name}.obj", "--rest", "r.obj", *LOW, "--mesh", "one.ply")
            self.assertEqual(harness.read_ply(self.bytes("one.ply")).points, harness.read_ply(self.bytes(f"a.{name}.ply")).points)
            sizes.add(self.ok("info", f"a.{name}.vdb", data=True).split("voxel size")[1].splitlines()[0])
        self.assertEqual(len(sizes), 1)  # one voxel size for all frames
        os.remove(self.path("s.0001.obj"))
        self.refused(NO_INPUT, "fractal", "s.####.obj", "--rest", "r.obj", *LOW, "--frames", "-1-1", "-o", "c.####.vdb",
                     mentions=("s.0001.obj", "frame 1"))
        self.assertFalse(self.path("c.-0001.vdb").exists())

    # Promise: "one that is missing or broken ..."
    def test_all_files_of_a_sequence_are_looked_at_first(self):
        for frame in (1, 2, 3):
            self.write(f"s.{frame}.obj", harness.obj(bent(self.rest, 10 * frame)))
        whole = self.bytes("s.3.obj")
        sequence = ("s.#.obj", *LOW, "--frames", "1-3")
        makes = lambda *words: ("fractal", *sequence, "--mesh", "a.#.ply", *words)

        def stops(code, mentions, *words, frame=3):
            for command in (makes(*words), ("plan", "frames", *sequence, *words, "-o", "plan")):
                self.refused(code, *command, mentions=(f"frame {frame}", *mentions))
                self.assertFalse(self.path("a.1.ply").exists())
                self.assertFalse(self.path("plan").exists())

        for broken in (whole[:-7] + b"nan", whole + b"f 1 2 99999\n"):
            self.path("s.3.obj").write_bytes(broken)
            for words in ((), ("--rest", "r.obj")):
                stops(BAD_DATA, ("s.3.obj",), *words)
            self.refused(BAD_DATA, "sdf", "s.#.obj", "--frames", "1-3", "-o", "d.#.vdb", "--resolution", 20, mentions=("frame 3", "s.3.obj"))
            self.assertFalse(self.path("d.1.vdb").exists())
        self.write("s.3.obj", harness.obj(ring(around=20)))
        stops(BAD_DATA, ("s.3.obj", "1024", "640", "--rest-attribute", "r.obj"), "--rest", "r.obj")
        stops(BAD_DATA, ("s.3.obj", "1024", "640", "velocity"), "--attributes", "velocity", frame=2)
        # Without a rest, faces may change.
        self.ok(*makes())
        # One that fails leaves the others.
        self.path("s.3.obj").write_bytes(whole[:-7] + b"nan")
        os.remove(self.path("s.1.obj"))
        for number in (1, 2, 3):
            self.path(f"a.{number}.ply").unlink()
        for made, command in (("a.2.ply", makes("--keep-going", "--rest", "r.obj")),
                              ("d.2.vdb", ("sdf", "s.#.obj", "--frames", "1-3", "-o", "d.#.vdb", "--resolution", 20, "--keep-going"))):
            before = set(self.listing())
            run = self.run_program(*command)
            self.assertEqual((run.returncode, set(self.listing()) - before), (NO_INPUT, {made}))
            for words in ("frame 1", "s.1.obj", "1 more", "frame 3", "s.3.obj"):
                self.assertIn(words, run.stderr.decode())

    def test_faces_may_change_where_points_bring_their_places_at_rest(self):
        for frame, torus in ((1, self.rest), (2, ring(around=40, across=20))):
            self.write(f"v.{frame:04}.ply", with_rest(bent(torus, 20 * frame), torus))
        said = self.ok("fractal", "v.####.ply", "--rest-attribute", "rest", *LOW, "--frames", "1-2", "--mesh", "a.####.ply")
        self.assertNotIn("not used of the target", said)
        for frame in (1, 2):
            self.ok("fractal", f"v.000{frame}.ply", "--rest-attribute", "rest", *LOW, "--mesh", "one.ply")
            self.assertEqual(harness.read_ply(self.bytes("one.ply")).points, harness.read_ply(self.bytes(f"a.000{frame}.ply")).points)

    def test_attributes_are_those_at_rest(self):
        """The mask and the thickness are read at rest, and the distance in the pose."""
        options = ("--rest", "r.obj", "--mask", "y:0.2:1", "--attributes", "mask,tau,depth")
        mesh = self.mesh(*options)
        names = ("mask", "tau", "depth")
        self.assertTrue(all(name in mesh.columns for name in names), mesh.columns)
        self.assertTrue(all(0.19 <= value <= 1.01 for value in mesh.columns["mask"]))
        self.assertTrue(all(value > 0 for value in mesh.columns["tau"]))

    def test_what_does_not_belong_together_is_refused(self):
        out = ("--mesh", "no.ply", *LOW)
        no = lambda code, *words, mentions: self.refused(code, "fractal", *words, *out, mentions=mentions)
        self.write("fewer.obj", harness.obj((self.rest[0], self.rest[1][:-2])))
        no(BAD_DATA, "t.obj", "--rest", "fewer.obj", mentions=("1024", "1022", "same faces"))
        self.write("large.obj", harness.obj(([tuple(1000 * c for c in p) for p in self.rest[0]], self.rest[1])))
        no(BAD_DATA, "t.obj", "--rest", "large.obj", mentions=("times as large", "unit"))
        self.write("nan.obj", harness.obj(self.rest).replace("v ", "v nan ", 1))
        no(BAD_DATA, "t.obj", "--rest", "nan.obj", mentions=("nan.obj",))
        self.write("point.obj", harness.obj(([(1, 2, 3)] * len(self.rest[0]), self.rest[1])))
        no(BAD_DATA, "t.obj", "--rest", "point.obj", mentions=("point.obj", "extent"))
        no(BAD_DATA, "point.obj", "--rest", "r.obj", mentions=("point.obj", "extent"))
        no(BAD_DATA, "t.obj", "--rest-attribute", "rest", mentions=("rest_x", "none"))
        self.write("t.ply", with_rest(self.pose, self.rest))
        no(BAD_DATA, "t.ply", "--rest-attribute", "home", mentions=("home_x", "rest_x"))
        no(USAGE, "t.obj", "--rest", "r.obj", "--rest-attribute", "rest", mentions=("--rest", "--rest-attribute", "one of them"))
        no(USAGE, "t.obj", "--rest-frame", 3, mentions=("--rest-frame", "t.obj"))
        no(USAGE, "t.obj", "--rest-depth", "kept", mentions=("--rest-depth", "--rest is not given"))
        no(USAGE, "t.obj", "--rest", "r.obj", "--map", "quadratic", mentions=("shape-modulus",))
        self.ok("sdf", "r.obj", "-o", "r.vdb", "--resolution", 20)
        no(USAGE, "r.vdb", "--rest", "r.obj", mentions=("r.vdb", "mesh"))
        no(USAGE, "t.obj", "--rest", "r.vdb", mentions=("r.vdb", "a mesh"))

    def test_a_surface_that_folds_is_reported(self):
        """A torus that closes like a book: its halves come to lie on each other."""
        self.write("t.obj", harness.obj(bent(self.rest, 175)))
        self.assert_the_same_in_all_ways("--rest", "r.obj")
        self.assertRegex(self.ok("fractal", "t.obj", "--rest", "r.obj", *LOW, "--mesh", "x.ply"),
                         r"note: in [0-9.]+ % of the shell, parts of the surface")


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Velocities: what the files hold of them, where they come from, sequences, and the refusal of what does not move."""
import json
import math
import shutil
import struct
import unittest

import numpy
import pyopenvdb

import harness
import test_animation
import test_attributes
from harness import BAD_DATA, NO_INPUT, USAGE

FPS = 24
STEP = (0.1, -0.2, 0.3)
TURN = 0.05


def shifted(mesh, by):
    return harness.moved(mesh, 1, by)


def turned(mesh, angle):
    """About Z."""
    points, faces = mesh
    c, s = math.cos(angle), math.sin(angle)
    return [(c * x - s * y, s * x + c * y, z) for x, y, z in points], faces


def glb_json(data):
    return json.loads(data[20:20 + struct.unpack_from("<I", data, 12)[0]])


class Velocity(harness.CliTest):

    LOW = ("--resolution", 30, "--sdf-resolution", 40, "--attributes", "velocity")

    def setUp(self):
        super().setUp()
        self.ball = harness.torus()
        self.write("s.obj", harness.obj(self.ball))
        self.write("back.obj", harness.obj(shifted(self.ball, [-x for x in STEP])))
        self.write("on.obj", harness.obj(shifted(self.ball, STEP)))

    def velocities(self, name):
        """The places of the vertices of a PLY, and their velocities."""
        rows = test_attributes.points(self.bytes(name))
        return (numpy.array([[row[axis] for axis in "xyz"] for row in rows]),
                numpy.array([[row["velocity_" + axis] for axis in "xyz"] for row in rows]))

    def made(self, *options, target="s.obj"):
        self.ok("fractal", target, *self.LOW, *options, "--mesh", "f.ply")
        return self.velocities("f.ply")

    def assert_near(self, found, wanted, within=1e-5):
        self.assertLess(numpy.abs(found - wanted).max(), within)

    # What they are.

    def test_a_translation_is_the_same_from_both_sides_and_from_one(self):
        for options in (("--target-before", "back.obj", "--target-after", "on.obj"), ("--target-after", "on.obj"),
                        ("--target-before", "back.obj")):
            _, found = self.made(*options)
            self.assertGreater(len(found), 1000)
            self.assert_near(found, FPS * numpy.array(STEP))
            _, found = self.made(*options, "--fps", 30)
            self.assert_near(found, 30 * numpy.array(STEP))

    # Promise: "The velocity of a point ..."
    def test_a_rotation(self):
        self.write("back.obj", harness.obj(turned(self.ball, -TURN)))
        self.write("on.obj", harness.obj(turned(self.ball, TURN)))
        places, found = self.made("--target-before", "back.obj", "--target-after", "on.obj")
        wanted = FPS * math.sin(TURN) * numpy.stack([-places[:, 1], places[:, 0], 0 * places[:, 2]], 1)
        self.assert_near(found, wanted)

    # Promise: "The velocity of a point ..."
    def test_what_stands_still_has_none(self):
        shutil.copy(self.path("s.obj"), self.path("same.obj"))
        _, found = self.made("--target-after", "same.obj")
        self.assert_near(found, 0, 1e-30)

    def test_other_formats_of_the_same_faces(self):
        self.write("on.ply", harness.ply(shifted(self.ball, STEP)))
        _, found = self.made("--target-after", "on.ply")
        self.assert_near(found, FPS * numpy.array(STEP), 1e-3)

    def test_the_mesh_is_the_same_as_without(self):
        places, _ = self.made("--target-after", "on.obj")
        self.ok("fractal", "s.obj", *self.LOW[:4], "--mesh", "plain.ply")
        self.assertTrue(numpy.array_equal(places, numpy.array([[row[axis] for axis in "xyz"] for row in
                                                               test_attributes.points(self.bytes("plain.ply"))])))

    # Promise: "The velocity of a point ..."
    def test_with_a_rest_pose_they_are_those_of_the_pose(self):
        self.write("rest.obj", harness.obj(turned(self.ball, 1.0)))
        _, found = self.made("--rest", "rest.obj", "--target-after", "on.obj")
        self.assert_near(found, FPS * numpy.array(STEP))

    # Promise: In a sequence "the neighbours ..."
    def test_an_animated_gltf_needs_no_other_file(self):
        gltf = test_animation.Gltf()
        node = gltf.node(mesh=gltf.mesh(*self.ball))
        gltf.animation("go", [(node, "translation", "LINEAR", [0, 10], [[0, 0, 0], [5, 0, -10]], "VEC3")])
        self.write("go.gltf", gltf.text())
        for frame in (0, 0.5, 4, 10):
            _, found = self.made("--target-frame", frame, target="go.gltf")
            self.assert_near(found, FPS * numpy.array([0.5, 0, -1]), 1e-3)
        _, found = self.made("--target-frame", 4, "--target-fps", 48, target="go.gltf")
        self.assert_near(found, FPS * numpy.array([0.5, 0, -1]), 1e-3)
        _, found = self.made("--target-frame", 30, target="go.gltf")
        self.assert_near(found, 0, 1e-30)

    # In files.

    def test_the_columns_of_a_ply(self):
        self.made("--target-after", "on.obj")
        self.assertEqual(test_attributes.header(self.bytes("f.ply"))[-3:],
                         [("float", "velocity_x"), ("float", "velocity_y"), ("float", "velocity_z")])
        self.assertIn("note: f.obj holds no attributes",
                      self.ok("fractal", "s.obj", *self.LOW, "--target-after", "on.obj", "--mesh", "f.obj"))

    # Promise of attributes.md: "The axes and the unit of a file apply to velocities as to positions"; the grid "reaches beyond
    #   the band of the surface, in tiles of 8^3 voxels"
    def test_a_glb(self):
        words = ("fractal", "s.obj", *self.LOW, "--target-after", "on.obj", "--mesh", "f.glb")
        for options, wanted in (((), STEP), (("--target-up", "z"), (STEP[0], STEP[2], -STEP[1])),
                                (("--units", "cm"), [x / 100 for x in STEP])):
            self.ok(*words, *options)
            data = self.bytes("f.glb")
            page = glb_json(data)
            accessor = page["accessors"][page["meshes"][0]["primitives"][0]["attributes"]["_VELOCITY"]]
            self.assertEqual(accessor["type"], "VEC3")
            stride = page["bufferViews"][accessor["bufferView"]]["byteStride"]
            body = data[20 + struct.unpack_from("<I", data, 12)[0] + 8:]
            found = [struct.unpack_from("<3f", body, accessor["byteOffset"] + i * stride) for i in range(accessor["count"])]
            self.assert_near(numpy.array(found), FPS * numpy.array(wanted))

    # Promise: "The axes and the unit of a file ..."
    def test_the_grid_of_a_vdb(self):
        words = ("fractal", "s.obj", *self.LOW, "--target-after", "on.obj", "-o", "f.vdb")
        for options, name, wanted in (((), "velocity", STEP), (("--grid-names", "houdini"), "v", STEP),
                                      (("--grid-names", "blender"), "velocity", STEP),
                                      (("--grid-names", "arnold"), "velocity", STEP),
                                      (("--grid-names", "unreal"), "velocity", STEP),
                                      (("--up", "z"), "velocity", (STEP[0], -STEP[2], STEP[1]))):
            self.ok(*words, *options)
            grid = pyopenvdb.read(str(self.path("f.vdb")), name)
            self.assertEqual(grid["vector_type"], "contravariant relative")
            found = numpy.array([item.value for item in grid.iterOnValues() if item.count == 1])
            self.assertGreater(len(found), 1000)
            self.assert_near(found, FPS * numpy.array(wanted))

    # Promise: "The axes and the unit of a file ..."
    def test_the_grid_reaches_as_far_as_it_moves(self):
        """At each place through which the band goes in a frame, forward and back, there is its velocity."""
        self.write("far.obj", harness.obj(shifted(self.ball, (0, 0, 1.5))))
        self.ok("fractal", "s.obj", *self.LOW, "--target-after", "far.obj", "-o", "f.vdb", "--grids", "surface,density")
        grid = pyopenvdb.read(str(self.path("f.vdb")), "velocity").getConstAccessor()
        surface = pyopenvdb.read(str(self.path("f.vdb")), "surface")
        voxel = surface.transform.voxelSize()[0]
        band = [item.min for item in surface.iterOnValues()][::37]
        for x, y, z in band:
            for share in (-1, -0.5, 0, 0.5, 1):
                value = grid.getValue((x, y, z + round(share * 1.5 / voxel)))
                self.assert_near(numpy.array(value), FPS * numpy.array((0, 0, 1.5)), 1e-4)

    # Promise: "The axes and the unit of a file ..."
    def test_a_ply_with_another_axis(self):
        _, found = self.made("--target-after", "on.obj", "--up", "z")
        self.assert_near(found, FPS * numpy.array([STEP[0], -STEP[2], STEP[1]]))

    # Promise: "The axes and the unit of a file ..."
    def test_usd(self):
        words = ("fractal", "s.obj", *self.LOW, "--target-after", "on.obj")
        for name, options in (("f.ply", ()), ("f.glb", ("--units", "cm")), ("f.ply", ("--up", "z"))):
            self.ok(*words, *options, "--mesh", name)
            self.ok("usd", "--mesh", name, "-o", "f.usda")
            text = self.bytes("f.usda").decode()
            values = text.partition("vector3f[] velocities = [")[2].partition("]")[0]
            found = numpy.array([float(x) for x in values.replace("(", "").replace(")", "").split(",")]).reshape(-1, 3)
            factor = 0.01 if name == "f.glb" else 1
            wanted = (STEP[0], -STEP[2], STEP[1]) if "--up" in options else STEP
            self.assert_near(found, factor * FPS * numpy.array(wanted))

    def test_points(self):
        self.ok("fractal", "s.obj", *self.LOW, "--target-after", "on.obj", "-o", "f.vdb")
        self.ok("points", "f.vdb", "--points", 100, "-o", "p.ply")
        self.assert_near(self.velocities("p.ply")[1], FPS * numpy.array(STEP))
        self.ok("points", "f.vdb", "--points", 100, "-o", "p.vdb")

    # The same in all ways.

    def test_tiles_are_one_run(self):
        self.write("on.obj", harness.obj(turned(self.ball, TURN)))
        for options in ((), ("--rest", "back.obj")):
            words = ("s.obj", *self.LOW, "--target-after", "on.obj", *options)
            self.ok("fractal", *words, "--mesh", "one.ply", "-o", "one.vdb")
            self.ok("plan", "tiles", *words, "--tiles", 3, "--make", "vdb,ply", "-o", "plan")
            self.ok("submit", "plan", "--engine", "parallel", "--mesh", "tiles.ply", "-o", "tiles.vdb")
            self.assertEqual(self.bytes("one.ply"), self.bytes("tiles.ply"))
            self.assertEqual(self.bytes("one.vdb"), self.bytes("tiles.vdb"))
            shutil.rmtree(self.path("plan"))
            self.ok("fractal", *words, "--mesh", "two.ply", "--threads", 1, "--instructions", "portable")
            self.assertEqual(self.bytes("one.ply"), self.bytes("two.ply"))
            self.ok("mesh", "one.vdb", "-o", "three.ply")
            self.assertEqual(self.bytes("one.ply").split(b"end_header")[1], self.bytes("three.ply").split(b"end_header")[1])

    def test_a_neighbour_that_has_changed_is_noticed(self):
        self.ok("fractal", "s.obj", *self.LOW, "--target-after", "on.obj", "-o", "f.vdb")
        self.write("on.obj", harness.obj(turned(self.ball, TURN)))
        self.refused(BAD_DATA, "mesh", "f.vdb", "-o", "f.ply", mentions="on.obj")

    # Sequences.

    def write_frames(self, numbers):
        """Frame n stands at n^2 along X."""
        for n in numbers:
            self.write(f"in.{n:04d}.obj", harness.obj(shifted(self.ball, (0.1 * n * n, 0, 0))))

    def frame_velocities(self, frames):
        found = []
        for n in frames:
            _, values = self.velocities(f"f.{n:04d}.ply")
            self.assert_near(values, values[0], 1e-4)
            found.append(values[0][0] / (0.1 * FPS))
        return found

    # Promise of attributes.md: In a sequence "the neighbours are that input at the frames before and after"; "An animated glTF
    #   needs neither option"
    def test_a_sequence(self):
        self.write_frames((1, 2, 3))
        words = ("fractal", "in.####.obj", *self.LOW, "--mesh", "f.####.ply")
        self.ok(*words, "--frames", "1-3")
        for found, wanted in zip(self.frame_velocities((1, 2, 3)), (3, 4, 5)):
            self.assertAlmostEqual(found, wanted, places=4)
        self.assertIn("kept 3 of 3", self.ok(*words, "--frames", "1-3"))
        # A neighbour that is not made is one if it is there.
        self.write_frames((0, 4))
        self.ok(*words, "--frames", "1-3")
        for found, wanted in zip(self.frame_velocities((1, 2, 3)), (2, 4, 6)):
            self.assertAlmostEqual(found, wanted, places=4)
        self.ok(*words, "--frames", "2")
        self.assertAlmostEqual(self.frame_velocities((2,))[0], 4, places=4)

    # Promise: In a sequence "the neighbours ..."
    def test_every_second_frame(self):
        self.write_frames((1, 3, 5))
        self.ok("fractal", "in.####.obj", *self.LOW, "--mesh", "f.####.ply", "--frames", "1-5x2", "--fps", 48)
        for found, wanted in zip(self.frame_velocities((1, 3, 5)), (4, 6, 8)):
            self.assertAlmostEqual(found / 2, wanted, places=4)

    # Promise of motion.md: Half frames: "they are one frame apart, so `--fps` is twice the rate of the film"
    def test_half_frames_of_a_shutter(self):
        """A target at t^3 goes by 3 t^2 + 1 a frame from the frame before to the frame after, and by 3 t^2 + 1/4 between the half
        frames about it, which have twice the rate."""
        for name, off in (("in", 0), ("before", -0.5), ("after", 0.5)):
            for frame in range(4):
                self.write(f"{name}.{frame:04}.obj", harness.obj(shifted(self.ball, (0.1 * (frame + off) ** 3, 0, 0))))
        words = ("fractal", "in.####.obj", *self.LOW, "--rest", "s.obj", "--mesh", "f.####.ply", "--frames", "1-2", "--force")
        for more, beside in (((), 1), (("--target-before", "before.####.obj", "--target-after", "after.####.obj", "--fps", 2 * FPS), 0.25)):
            self.ok(*words, *more)
            for frame in (1, 2):
                self.assert_near(self.velocities(f"f.000{frame}.ply")[1], [0.1 * FPS * (3 * frame ** 2 + beside), 0, 0], 1e-3)

    # Promise: In a sequence "the neighbours ..."
    def test_a_plan_of_frames(self):
        self.write_frames((1, 2, 3))
        self.ok("plan", "frames", "in.####.obj", "--frames", "1-3", *self.LOW, "--make", "ply", "-o", "plan")
        self.ok("task", "plan", "--range", "1-3")
        self.ok("fractal", "in.####.obj", *self.LOW, "--mesh", "f.####.ply", "--frames", "1-3")
        for n in (1, 2, 3):
            self.assertEqual(self.bytes(f"f.{n:04d}.ply").split(b"end_header")[1],
                             self.bytes(f"plan/out/in.{n:04d}.ply").split(b"end_header")[1])

    # Promise: In a sequence "the neighbours ..."
    def test_a_gap_is_found_before_the_first_frame(self):
        self.write_frames((1, 3))
        self.refused(NO_INPUT, "fractal", "in.####.obj", *self.LOW, "--frames", "1-3", "--mesh", "f.####.ply",
                     mentions=("in.0002.obj", "frame 1"))
        self.assertFalse(self.path("f.0001.ply").exists())
        self.refused(USAGE, "fractal", "in.####.obj", *self.LOW, "--frames", "1", "--mesh", "f.####.ply",
                     mentions=("frame 1", "velocity"))

    def test_a_broken_frame_is_no_mesh_without_faces(self):
        """With --keep-going its neighbours fail because it cannot be read, and not because its faces differ from theirs."""
        self.write_frames((1, 2, 3, 4, 5))
        self.write("in.0002.obj", "f 1 2 3\n")
        run = self.run_program("fractal", "in.####.obj", *self.LOW, "--frames", "1-5", "--mesh", "f.####.ply", "--keep-going")
        text = run.stderr.decode()
        self.assertEqual(run.returncode, BAD_DATA, text)
        self.assertNotIn("triangles, and", text)
        self.assertEqual([name for name in self.listing() if name.startswith("f.")], ["f.0004.ply", "f.0005.ply"])
        for frame in (1, 2, 3):
            self.assertRegex(text, rf"warning: frame {frame}: .*in\.0002\.obj")

    # Promise: In a sequence "the neighbours ..."
    def test_an_animated_gltf_plays(self):
        gltf = test_animation.Gltf()
        node = gltf.node(mesh=gltf.mesh(*self.ball))
        gltf.animation("go", [(node, "translation", "LINEAR", [0, 4], [[0, 0, 0], [2, 0, 0]], "VEC3")])
        self.write("go.gltf", gltf.text())
        self.ok("fractal", "go.gltf", *self.LOW, "--frames", "0-4x2", "--mesh", "f.####.ply")
        for found in self.frame_velocities((0, 2, 4)):
            self.assertAlmostEqual(found, 5, places=2)

    def test_another_input_has_other_neighbours(self):
        self.ok("fractal", "s.obj", *self.LOW, "--target-after", "on.obj", "-o", "f.vdb")
        self.refused(USAGE, "fractal", "back.obj", "--config", "f.vdb", "-o", "g.vdb", mentions="--target-after")
        self.ok("fractal", "back.obj", "--config", "f.vdb", "--target-after", "s.obj", "-o", "g.vdb")

    # What is refused.

    def test_bad_options(self):
        def refused(code, *words, mentions):
            self.refused(code, "fractal", *words, "-o", "f.vdb", mentions=mentions)
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 20)
        after = ("--target-after", "on.obj")
        refused(USAGE, "s.obj", *self.LOW, mentions=("velocity", "--target-before", "--target-after"))
        refused(USAGE, "s.vdb", *self.LOW[:2], *self.LOW[4:], *after, mentions=("velocity", "s.vdb"))
        refused(USAGE, "--map", "mandelbulb", "--attributes", "velocity", mentions="no target")
        refused(USAGE, "s.obj", *self.LOW[:4], *after, mentions=("--target-after", "--attributes velocity"))
        refused(USAGE, "s.obj", *self.LOW[:4], "--fps", 25, mentions="--fps")
        refused(USAGE, "s.obj", *self.LOW, *after, "--fps", 0, mentions=("--fps", "0"))
        refused(USAGE, "s.obj", *self.LOW, *after, "--fps", "nan", mentions="--fps")
        refused(USAGE, "s.obj", *self.LOW, "--target-after", "s.vdb", mentions=("--target-after", "s.vdb"))
        refused(NO_INPUT, "s.obj", *self.LOW, "--target-after", "none.obj", mentions="none.obj")
        self.write("fewer.obj", harness.obj(harness.sphere(1)))
        refused(BAD_DATA, "s.obj", *self.LOW, "--target-after", "fewer.obj", mentions=("fewer.obj", "1024", "80"))
        self.write("flat.obj", harness.obj(([(0, 0, 0)] * len(self.ball[0]), self.ball[1])))
        refused(BAD_DATA, "s.obj", *self.LOW, "--target-after", "flat.obj", mentions="flat.obj")


if __name__ == "__main__":
    harness.main()

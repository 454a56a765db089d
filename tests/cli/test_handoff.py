# SPDX-License-Identifier: Apache-2.0
"""What other programs find in the files: pyopenvdb, vdb_print and vdb_tool read them."""

import math
import re
import shutil
import subprocess
import unittest

import pyopenvdb

import harness

ALL_GRIDS = ["surface", "density", "logmodulus", "iterations", "versor"]
LOW = ("--resolution", 32, "--sdf-resolution", 32)


class HandOff(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("t.obj", harness.obj(harness.torus()))

    def grids(self, name):
        grids = pyopenvdb.readAllGridMetadata(str(self.path(name)))
        names = [grid.name for grid in grids]
        self.assertEqual(len(names), len(set(names)), "two grids have one name")
        return {grid_name: pyopenvdb.read(str(self.path(name)), grid_name) for grid_name in names}

    def check_metadata(self, metadata):
        ours = {name: value for name, value in metadata.items() if name.startswith("julia_")}
        self.assertIn("julia_detail", ours)
        for name, value in ours.items():
            self.assertRegex(name, r"\A[A-Za-z_][A-Za-z0-9_]*\Z")
            self.assertIsInstance(value, str, name)

    # Promise of README.md: The level set "passes tests 1 to 8 of OpenVDB's `checkLevelSet`", and other readers of OpenVDB take
    #   the file
    # Promise of design.md: "Metadata names are identifiers (`julia_alpha`) and the values are strings"; values are "half floats
    #   with `--half`"
    # Promise: "No two grids share a name"
    def test_all_grids(self):
        self.ok("fractal", "t.obj", *LOW, "--iterations", 4, "-o", "t.vdb", "--mesh", "t.ply", "--grids",
                ",".join(ALL_GRIDS))
        grids = self.grids("t.vdb")
        self.assertEqual(sorted(grids), sorted(ALL_GRIDS))
        voxel = 2.0 / 32  # the torus is 2 across
        for name, grid in grids.items():
            self.assertIsInstance(grid, pyopenvdb.Vec3SGrid if name == "versor" else pyopenvdb.FloatGrid)
            for size in grid.transform.voxelSize():
                self.assertAlmostEqual(size, voxel, 12)
            self.check_metadata(grid.metadata)
            self.assertFalse(grid.saveFloatAsHalf)
        self.check_metadata(pyopenvdb.readMetadata(str(self.path("t.vdb"))))
        self.check_surface(grids["surface"], voxel)

        density = grids["density"]
        self.assertEqual((density.gridClass, density.background), ("fog volume", 0))
        values = [item.value for item in density.citerOnValues()]
        self.assertTrue(all(0 <= v <= 1 for v in values))
        self.assertGreater(max(values), 0.5)

        iterations = grids["iterations"]
        values = {item.value for item in iterations.citerOnValues()}
        self.assertLessEqual(values, {1.0, 2.0, 3.0, 4.0})
        self.assertGreater(len(values), 1)

        modulus = grids["logmodulus"]
        self.assertNotEqual(modulus.gridClass, "level set")
        self.assertTrue(all(math.isfinite(item.value) for item in modulus.citerAllValues()))
        self.assertEqual(modulus.activeVoxelCount(), iterations.activeVoxelCount())

        lengths = [math.hypot(*item.value) for item in grids["versor"].citerOnValues()]
        self.assertEqual(len(lengths), grids["surface"].activeVoxelCount())
        self.assertTrue(all(length <= 1 + 1e-5 for length in lengths))  # the part of a unit quaternion without its real
        self.assertGreater(max(lengths), 0.5)

        # World units are the mesh's: the level set lies where the mesh does, within a voxel.
        mesh, surface = harness.read_ply(self.bytes("t.ply")), grids["surface"]
        inside = [surface.transform.indexToWorld(item.min) for item in surface.citerOnValues() if item.value <= 0]
        for axis in range(3):
            for pick in (min, max):
                self.assertAlmostEqual(pick(p[axis] for p in mesh.points), pick(p[axis] for p in inside), delta=voxel)
        # And each vertex is on the level set, within what trilinear distances make of a rough surface.
        accessor = surface.getConstAccessor()
        for point in mesh.points[::7]:
            node = tuple(round(x) for x in surface.transform.worldToIndex(point))
            self.assertLess(abs(accessor.getValue(node)), voxel)  # the nearest node is half a diagonal away

    def check_surface(self, surface, voxel):
        self.assertEqual(surface.gridClass, "level set")
        self.assertGreater(surface.background, 3 * voxel)
        self.assertLess(surface.background, 3.1 * voxel)
        for item in surface.citerOnValues():
            self.assertEqual(item.count, 1, "an active tile")
            self.assertLessEqual(abs(item.value), surface.background)
        for item in surface.citerOffValues():
            self.assertEqual(abs(item.value), surface.background)

    # Promise: The level set "passes tests ..."
    def test_sdf(self):
        self.ok("sdf", "t.obj", "-o", "t.vdb", "--resolution", 40)
        grid = self.grids("t.vdb")["phi"]
        self.assertEqual(grid.gridClass, "level set")
        self.assertGreaterEqual(grid.background, 3 * 0.05)
        # Against the torus itself; the mesh is inscribed with a sagitta of r (1 - cos(pi / n)), below half a voxel.
        for item in list(grid.citerOnValues())[::11]:
            x, y, z = grid.transform.indexToWorld(item.min)
            self.assertAlmostEqual(item.value, math.hypot(math.hypot(x, z) - 0.7, y) - 0.3, delta=0.02)

    # Promise: Distances of `sdf` of a VDB ...
    def test_sdf_of_a_vdb(self):
        """A band of any width about any level set, on its own voxels and with its signs."""
        self.ok("sdf", "t.obj", "-o", "narrow.vdb", "--resolution", 40)
        self.ok("sdf", "t.obj", "-o", "wide.vdb", "--resolution", 40, "--band", 9)
        self.ok("sdf", "narrow.vdb", "-o", "again.vdb", "--band", 9)
        narrow, wide, again = (self.grids(name)["phi"] for name in ("narrow.vdb", "wide.vdb", "again.vdb"))
        self.assertEqual(again.gridClass, "level set")
        self.assertAlmostEqual(again.background, 9 * 0.05, delta=1e-6)
        self.assertGreater(again.activeVoxelCount(), 2 * narrow.activeVoxelCount())
        self.assertAlmostEqual(again.activeVoxelCount() / wide.activeVoxelCount(), 1, delta=0.02)
        # Where faces of the mesh meet at up to 22.5 degrees, the grid's surface cuts the edge off within a cell, whose
        # diagonal is sqrt(3) voxels: by sqrt(3) / 2 sin(22.5 / 2) of a voxel.
        accessor = wide.getConstAccessor()
        for item in list(again.citerOnValues())[::7]:
            self.assertAlmostEqual(item.value, accessor.getValue(item.min), delta=0.17 * 0.05)
        told, source = self.info("again.vdb"), self.info("narrow.vdb")
        self.assertEqual(told["recipe"]["band"], "9")
        self.assertEqual(told["metadata"]["julia_target_box"], source["metadata"]["julia_target_box"])
        # A fractal's, with its grid named; and it is a target again.
        self.ok("fractal", "t.obj", *LOW, "-o", "f.vdb", "--grids", "density,surface")
        self.ok("sdf", "f.vdb", "--grid", "surface", "-o", "phi.vdb", "--band", 12)
        surface, phi = self.grids("f.vdb")["surface"].getConstAccessor(), self.grids("phi.vdb")["phi"]
        for item in list(phi.citerOnValues())[::7]:
            self.assertEqual(item.value < 0, surface.getValue(item.min) < 0)
        self.ok("fractal", "phi.vdb", "-o", "g.vdb", "--resolution", 24, "--alpha", 20, "--origin", "0.35,0,0")
        for option in (("--resolution", 30), ("--voxel-size", 0.1), ("--repair",), ("--thicken", 0.1)):
            self.refused(harness.USAGE, "sdf", "narrow.vdb", "-o", "x.vdb", *option, mentions=option[0])
        self.refused(harness.USAGE, "sdf", "t.obj", "-o", "x.vdb", "--grid", "phi", mentions="--grid")
        self.refused(harness.BAD_DATA, "sdf", "f.vdb", "--grid", "phi", "-o", "x.vdb", mentions="density")

    # Promise of attributes.md: "the program says how many, as do tasks of plans, the page of `explore`, and, by a `RuntimeWarning`,
    #   `write()` in Python"
    def test_half_has_no_infinities(self):
        """A half ends at 65504. Values beyond are stored as that, and the command says how many; Fp16 of NanoVDB has scales of its own.
        The target is so large that its distances are."""
        points, faces = harness.torus()
        self.write("large.obj", harness.obj(([(1e6 * x, 1e6 * y, 1e6 * z) for x, y, z in points], faces)))
        low = ("--resolution", 24, "--sdf-resolution", 24)
        runs = {"sdf": ("sdf", "large.obj", "--resolution", 24), "fractal": ("fractal", "large.obj", *low, "--attributes", "depth,Cd")}
        for command, words in runs.items():
            self.ok(*words, "-o", "full.vdb")
            said = self.ok(*words, "-o", "half.vdb", "--half")
            grids = {grid.name for grid in pyopenvdb.readAllGridMetadata(str(self.path("full.vdb")))}
            for name in grids - {"Cd"}:
                full, half = (pyopenvdb.read(str(self.path(file)), name) for file in ("full.vdb", "half.vdb"))
                values = half.getConstAccessor()
                beyond = 0
                for item in full.citerOnValues():
                    value = values.getValue(item.min)
                    beyond += abs(item.value) > 65504
                    self.assertLessEqual(abs(value), 65504)
                    self.assertEqual(math.copysign(1, value), math.copysign(1, item.value))
                self.assertGreater(beyond, 100)
                self.assertIn(f"warning: {beyond} values of the grid {name} are beyond what 16 bits hold", said)
                self.assertEqual(half.background, 65504 if full.background > 0 else 0)
            self.assertEqual(said.count("16 bits"), len(grids - {"Cd"}), said)
        self.ok("plan", "tiles", *runs["fractal"][1:], "--half", "--tiles", 2, "-o", "farm", "--make", "vdb")
        self.ok("task", "farm", "--range", "1-2")
        merged = self.ok("merge", "farm", "-o", "merged.vdb")
        self.assertEqual(self.bytes("merged.vdb"), self.bytes("half.vdb"))
        warnings = [line for line in said.splitlines() if "16 bits" in line]
        self.assertEqual([line for line in merged.splitlines() if "16 bits" in line], warnings)
        self.ok("plan", "frames", *runs["fractal"][1:], "--half", "--frames", "1-1", "-o", "frames", "--make", "vdb")
        task = self.ok("task", "frames", "--index", 1)
        self.assertEqual([line for line in task.splitlines() if "16 bits" in line], warnings)

    # Promise: "Metadata names are identifiers ..."
    def test_half(self):
        for name, options in (("full", ()), ("half", ("--half",))):
            self.ok("fractal", "t.obj", *LOW, "-o", f"{name}.vdb", "--grids", "surface,density", *options)
        self.assertLess(len(self.bytes("half.vdb")), len(self.bytes("full.vdb")))
        half, full = self.grids("half.vdb"), self.grids("full.vdb")
        for name in ("surface", "density"):
            self.assertTrue(half[name].saveFloatAsHalf)
            self.assertEqual(half[name].activeVoxelCount(), full[name].activeVoxelCount())
            accessor = half[name].getConstAccessor()
            for item in list(full[name].citerOnValues())[::17]:
                self.assertAlmostEqual(accessor.getValue(item.min), item.value, delta=abs(item.value) * 2**-10 + 1e-7)

    # Promise of handoff.md: The table of `--up` and formats; "The metadata `julia_up_axis` of each file"
    def test_files_say_which_axis_is_up(self):
        """In every format that has a place for it, and as docs/handoff.md has it in its table."""
        said = re.compile(rb'julia_up_axis\W+([yz])\b')
        for up, grids, prints, web in (("keep", "y", "y", "y"), ("y", "y", "y", "y"), ("z", "z", "z", "y"),
                                       ("auto", "y", "z", "y")):
            self.ok("fractal", "t.obj", *LOW, "--up", up, "-o", "u.vdb", "--mesh", "u.ply")
            for kind, axis in (("ply", prints), ("obj", grids), ("glb", web)):
                job = ("fractal", "t.obj", *LOW, "--up", up, "--mesh", f"u.{kind}")
                if (kind, up) == ("glb", "z"):
                    self.refused(harness.USAGE, *job, mentions=("--up", "GLB"))
                    job += ("-o", "u.vdb")
                self.ok(*job)
                self.assertEqual(said.findall(self.bytes(f"u.{kind}")), [axis.encode()], (up, kind))
            self.assertEqual(self.info("u.vdb")["metadata"]["julia_up_axis"], grids, up)

    def test_one_grid_unless_asked(self):
        self.ok("fractal", "t.obj", *LOW, "-o", "t.vdb")
        self.assertEqual(list(self.grids("t.vdb")), ["surface"])
        self.ok("fractal", "t.obj", *LOW, "-o", "t.vdb", "--grids", "logmodulus")
        self.assertEqual(list(self.grids("t.vdb")), ["logmodulus"])

    # Promise of reliability.md#random-recipes: Nothing that is written is infinite or not a number
    def test_nothing_is_not_finite(self):
        # A slice through a root (the versor of 0), and an escape radius that lets the last steps grow.
        self.write("v.json", harness.rational_json([(0, 0, 0, 0, 3), (0.0625, 0, 0, 0, 2.5), (0.125, 0, 0, 0, -2)]))
        self.ok("fractal", "t.obj", *LOW, "--texture", "v.json", "-o", "t.vdb", "--grids", ",".join(ALL_GRIDS),
                "--escape", "1e9", "--iterations", 9)
        self.ok("fractal", "--map", "rational", "--texture", "v.json", "--box", "-1,-1,-1,1,1,1", "-o", "r.vdb",
                "--resolution", 32, "--grids", ",".join(ALL_GRIDS))
        for name in ("t.vdb", "r.vdb"):
            for grid in self.grids(name).values():
                for item in grid.citerAllValues():
                    values = item.value if isinstance(item.value, tuple) else (item.value,)
                    self.assertTrue(all(map(math.isfinite, values)), f"{name} {grid.name} at {item.min}: {item.value}")

    def test_a_level_set_whose_voxels_are_not_cubes(self):
        ball = pyopenvdb.createLevelSetSphere(radius=1, voxelSize=0.1)
        ball.name = "flat"
        ball.transform = pyopenvdb.createLinearTransform([[0.1, 0, 0, 0], [0, 0.1, 0, 0], [0, 0, 0.05, 0], [0, 0, 0, 1]])
        pyopenvdb.write(str(self.path("flat.vdb")), grids=[ball])
        grid, = self.info("flat.vdb")["grids"]
        self.assertEqual([round(size, 9) for size in grid["voxel size"]], [0.1, 0.1, 0.05])
        self.assertIn("uniform", grid["level set check"])

    def test_files_do_not_speak_to_the_terminal(self):
        ball = pyopenvdb.createLevelSetSphere(radius=1, voxelSize=0.1)
        ball.name = "red\x1b[31m"
        pyopenvdb.write(str(self.path("ball.vdb")), grids=[ball], metadata={"note\x1b[1m": "\x1b]0;title\x07 two\nlines"})
        self.write("own.cfg", "seed\x1b[31m = 3\n")
        said = self.ok("info", "ball.vdb", data=True)
        self.assertIn("note?[1m: ?]0;title? two?lines", said)
        self.assertIn("red?[31m", said)
        said += self.refused(harness.BAD_DATA, "mesh", "ball.vdb", "--grid", "surface", "-o", "m.ply", mentions="red?[31m")
        said += self.refused(harness.USAGE, "fractal", "t.obj", "--config", "own.cfg", "-o", "f.vdb", mentions="seed?[31m")
        self.assertFalse([c for c in said if c != "\n" and (ord(c) < 32 or ord(c) == 127)])

    # Promise: The level set "passes tests ..."
    @unittest.skipUnless(shutil.which("vdb_print") and shutil.which("vdb_tool"), "libopenvdb-tools is not here")
    def test_tools_of_openvdb(self):
        self.ok("fractal", "t.obj", *LOW, "-o", "t.vdb", "--grids", ",".join(ALL_GRIDS))
        tool = lambda *words: subprocess.run(words, cwd=self.folder, capture_output=True, text=True, check=True).stdout
        listing = tool("vdb_print", "-l", "t.vdb")
        self.assertEqual(sorted(re.findall(r"(?m)^Name: (\w+)", listing)), sorted(ALL_GRIDS))
        self.assertIn("julia_command: fractal", listing)
        self.assertIn("class: level set", listing)
        self.ok("fractal", "t.obj", *LOW, "-o", "one.vdb")
        tool("vdb_tool", "-read", "one.vdb", "-ls2mesh", "-write", "tool.ply")
        theirs = self.info("tool.ply")
        self.ok("mesh", "one.vdb", "--from-grid", "-o", "ours.ply")
        ours = self.info("ours.ply")
        # Two ways to mesh one level set; they differ where cells are ambiguous, and in which way round a face goes.
        self.assertAlmostEqual(abs(theirs["volume"]), ours["volume"], delta=0.03 * ours["volume"])
        for end in ("box min", "box max"):
            for theirs_at, ours_at in zip(theirs[end], ours[end]):
                self.assertAlmostEqual(theirs_at, ours_at, delta=0.0625)


if __name__ == "__main__":
    harness.main()

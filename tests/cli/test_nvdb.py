# SPDX-License-Identifier: Apache-2.0
"""NanoVDB files: what NanoVDB's own programs find in them, how far values are off, and that damaged ones are refused.

nanovdb_convert turns them back into VDBs, whose voxels pyopenvdb compares with those that were written."""

import random
import re
import shutil
import subprocess

import pyopenvdb

import harness
from harness import BAD_DATA, NO_INPUT, USAGE

LOW = ("--resolution", 32, "--sdf-resolution", 32)


class NanoVdb(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("t.obj", harness.obj(harness.torus()))
        self.run_program("sdf", "t.obj", "-o", "probe.nvdb", "--resolution", 8)
        if not self.path("probe.nvdb").exists():
            self.skipTest("NanoVDB is not built in")
        self.path("probe.nvdb").unlink()

    def tool(self, name, *words):
        if not shutil.which(name):
            self.skipTest(f"{name} is not installed")
        run = subprocess.run([name, *map(str, words)], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, f"{name} {words}\n{run.stdout}{run.stderr}")
        return run.stdout + run.stderr

    def grids(self, name):
        return {grid.name: pyopenvdb.read(str(self.path(name)), grid.name)
                for grid in pyopenvdb.readAllGridMetadata(str(self.path(name)))}

    def back(self, name):
        """The grids of a file after nanovdb_convert has read it."""
        self.tool("nanovdb_validate", name)
        self.tool("nanovdb_convert", "-f", name, "back.vdb")
        return self.grids("back.vdb")

    def greatest_difference(self, one, other):
        self.assertEqual(one.activeVoxelCount(), other.activeVoxelCount())
        accessor = other.getConstAccessor()
        greatest = 0
        for item in one.citerOnValues():
            value, active = accessor.probeValue(item.min)
            self.assertTrue(active, item.min)
            both = (item.value, value) if isinstance(item.value, tuple) else ((item.value,), (value,))
            greatest = max(greatest, *(abs(a - b) for a, b in zip(*both)))
        return greatest

    # Promise of handoff.md: The grids of a NanoVDB file "keep the names, voxels and transforms of the VDB"
    def test_the_voxels_are_those_of_the_vdb(self):
        """For all grids, whether they are written at once or converted."""
        words = ("fractal", "t.obj", *LOW, "--iterations", 4, "--grids", "surface,density,versor", "--attributes", "iterations")
        self.ok(*words, "-o", "t.vdb")
        self.ok(*words, "-o", "t.nvdb")
        self.ok("convert", "t.vdb", "-o", "converted.nvdb")
        self.assertEqual(self.bytes("converted.nvdb"), self.bytes("t.nvdb"))
        ours, theirs = self.grids("t.vdb"), self.back("t.nvdb")
        self.assertEqual(sorted(ours), sorted(theirs))
        for name, grid in ours.items():
            with self.subTest(grid=name):
                self.assertEqual(self.greatest_difference(grid, theirs[name]), 0)
                self.assertEqual(grid.background, theirs[name].background)
                for at in ((0, 0, 0), (5, -7, 11)):
                    for a, b in zip(grid.transform.indexToWorld(at), theirs[name].transform.indexToWorld(at)):
                        self.assertAlmostEqual(a, b, 12)

    def test_farms_write_it(self):
        """Tiles that are merged and frames have the bytes of one run."""
        words = ("t.obj", *LOW, "--iterations", 3, "--grids", "surface,density")
        self.ok("fractal", *words, "-o", "one.nvdb", "--mesh", "one.ply")
        self.ok("plan", "tiles", *words, "-o", "tiles", "--tiles", 2, "--make", "nvdb,ply")
        self.ok("task", "tiles", "--range", "1-2")
        self.refused(USAGE, "merge", "tiles", "-o", "m.ply", mentions=(".vdb", ".nvdb"))
        self.ok("merge", "tiles", "-o", "m.nvdb", "--mesh", "m.ply")
        self.ok("plan", "frames", *words, "--frames", "1", "-o", "frames", "--make", "nvdb,vdb,ply", "--name", "f")
        self.ok("task", "frames", "--index", 1)
        self.ok("convert", "frames/out/f.0001.vdb", "-o", "frame.nvdb")
        for name in ("m.nvdb", "frames/out/f.0001.nvdb", "frame.nvdb"):
            self.assertEqual(self.bytes(name), self.bytes("one.nvdb"), name)
        self.assertEqual(self.bytes("m.ply"), self.bytes("one.ply"))

    # Promise of handoff.md: Of a NanoVDB file of fewer bits "the program reports the largest error of an active voxel"
    def test_how_far_values_are_off_is_said(self):
        self.ok("sdf", "t.obj", "-o", "t.vdb", "--resolution", 40)
        exact, = self.grids("t.vdb").values()
        voxel = exact.transform.voxelSize()[0]
        sizes = [self.path("t.vdb").stat().st_size]
        for bits, most in (("16", 6 / 65535), ("8", 6 / 255), ("auto", 0.2)):
            with self.subTest(bits=bits):
                said = self.ok("sdf", "t.obj", "-o", "t.nvdb", "--resolution", 40, "--nvdb-bits", bits)
                found = re.search(r"off by at most (\S+), (\S+) voxels", said)
                bound, voxels = float(found[1]), float(found[2])
                self.assertAlmostEqual(bound / voxel / voxels, 1, 2)
                # Half a step of a band of six voxels.
                self.assertLessEqual(voxels, most / 2 * 1.02)
                other, = self.back("t.nvdb").values()
                off = self.greatest_difference(exact, other)
                self.assertLessEqual(off, bound * (1 + 1e-6))
                self.assertGreaterEqual(off, bound * 0.99)
                self.assertGreater(off, 0)
                sizes.append(self.path("t.nvdb").stat().st_size)
        self.assertGreater(sizes[1], sizes[2])
        self.assertGreater(sizes[2], sizes[3] * 0.5)

    # Promise: The grids of a NanoVDB file ...
    def test_what_is_shown_is_what_nanovdb_prints(self):
        self.ok("fractal", "t.obj", *LOW, "--iterations", 3, "--grids", "surface,density", "-o", "t.nvdb")
        printed = self.tool("nanovdb_print", "t.nvdb")
        info = self.info("t.nvdb")
        self.assertEqual(info["kind"], "NanoVDB")
        for grid in info["grids"]:
            line, = [line for line in printed.splitlines() if re.search(rf"\b{grid['name']}\b", line)]
            self.assertIn(f" {grid['active voxels']} ", line.replace(",", "") + " ")
            self.assertIn("SDF" if grid["class"] == "level set" else "FOG", line)
            self.assertEqual(grid["checksum"], "fits")
        shown = self.ok("info", "t.nvdb", data=True)
        self.assertIn("checksum: fits", shown)

    # Promise: The grids of a NanoVDB file ...
    def test_axes(self):
        """--up turns the transform, as in a VDB. nanovdb_convert 10.0.1 transposes a rotation; the box of the active voxels is
        what NanoVDB itself makes of the transform."""
        self.write("m.obj", harness.obj(harness.moved(harness.torus(), 1, (1, 20, 300))))
        for up in ("y", "z"):
            for name in (f"{up}.vdb", f"{up}.nvdb"):
                self.ok("sdf", "m.obj", "-o", name, "--resolution", 20, "--up", up)
            grid, = self.grids(f"{up}.vdb").values()
            low, high = grid.evalActiveVoxelBoundingBox()
            corners = [grid.transform.indexToWorld(end) for end in (low, tuple(x + 1 for x in high))]
            expected = [[f(*pair) for pair in zip(*corners)] for f in (min, max)]
            shown = self.info(f"{up}.nvdb")["grids"][0]
            for ours, name in zip(expected, ("box min", "box max")):
                for a, b in zip(ours, shown[name]):
                    self.assertAlmostEqual(a, b, 9)
            printed = self.tool("nanovdb_print", "-l", f"{up}.nvdb").splitlines()
            line, = [line for line in printed if " phi " in line]
            ends = re.findall(r"\(([^()]*)\)", line)[-2:]
            for ours, end in zip(expected, ends):
                for a, b in zip(ours, map(float, end.split(","))):
                    self.assertAlmostEqual(a, b, delta=0.01 * abs(a))
            middle = [(a + b) / 2 for a, b in zip(*expected)]
            for a, b in zip(middle, (1, 20, 300) if up == "y" else (1, -300, 20)):
                self.assertAlmostEqual(a, b, delta=0.2)

    def test_same_bytes(self):
        for threads in (1, 2):
            self.ok("sdf", "t.obj", "-o", f"{threads}.nvdb", "--resolution", 40, "--nvdb-bits", "auto", "--threads", threads)
        self.assertEqual(self.bytes("1.nvdb"), self.bytes("2.nvdb"))

    def test_options_that_do_not_fit(self):
        self.refused(USAGE, "sdf", "t.obj", "-o", "t.vdb", "--nvdb-bits", 8, mentions="--nvdb-bits")
        self.refused(USAGE, "sdf", "t.obj", "-o", "t.nvdb", "--half", mentions="--nvdb-bits 16")
        self.refused(USAGE, "fractal", "t.obj", "-o", "t.nvdb", "--half", mentions="--nvdb-bits 16")
        self.refused(USAGE, "fractal", "t.obj", "--mesh", "t.ply", "--nvdb-bits", 8, mentions="--nvdb-bits")
        self.refused(USAGE, "sdf", "t.obj", "-o", "t.nvdb", "--target-up", "z", mentions=("--target-up", "--up"))
        for bits in ("4", "half", "", "8.0"):
            self.refused(USAGE, "sdf", "t.obj", "-o", "t.nvdb", f"--nvdb-bits={bits}", mentions="--nvdb-bits")
        self.ok("sdf", "t.obj", "-o", "t.vdb", "--resolution", 12)
        self.refused(USAGE, "convert", "t.vdb", "-o", "u.vdb", mentions=".nvdb")
        self.refused(USAGE, "convert", "t.vdb", mentions="-o")
        self.refused(USAGE, "convert", "-o", "u.nvdb", mentions="VDB")
        self.refused(NO_INPUT, "convert", "no.vdb", "-o", "u.nvdb", mentions="no.vdb")
        self.refused(BAD_DATA, "convert", "t.obj", "-o", "u.nvdb", mentions="t.obj")
        self.ok("points", "t.obj", "-o", "p.vdb", "--points", 50)
        self.refused(BAD_DATA, "convert", "p.vdb", "-o", "u.nvdb", mentions="NanoVDB")

    # Promise of handoff.md: `info` of a NanoVDB file "checks every size, the place of every node and the checksums"
    def test_damaged_files_are_refused(self):
        self.ok("sdf", "t.obj", "-o", "t.nvdb", "--resolution", 16)
        whole = self.bytes("t.nvdb")
        chance = random.Random(3)
        cases = []
        for number in range(12):
            cut = whole[:chance.choice((0, 7, 16, 100, 191, 500, chance.randrange(len(whole))))]
            flipped = bytearray(whole)
            # Behind the heads of the file and of the grid, which the grid repeats.
            flipped[chance.randrange(16 + 176 + 4, len(whole))] ^= 1 << chance.randrange(8)
            for kind, data in (("cut", cut), ("flipped", bytes(flipped))):
                cases.append(("info", self.write(f"{kind}{number}.nvdb", data)))
        cases.append(("info", self.write("other.nvdb", b"no NanoVDB at all, but long enough for a head of one")))
        cases.append(("info", self.write("longer.nvdb", whole + b"?")))
        self.all_refused(BAD_DATA, cases, mentions="cannot be read as a NanoVDB file")
        self.refused(NO_INPUT, "info", "none.nvdb", mentions="none.nvdb")


if __name__ == "__main__":
    harness.main()

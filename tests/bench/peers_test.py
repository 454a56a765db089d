# SPDX-License-Identifier: Apache-2.0
"""bench/peers builds a released program and compares it with ours. A stand-in takes the place of that program, which the
tests cannot fetch: it has the same commands, and keeps what it was told."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/cli"))
import harness

STAND_IN = """#!/usr/bin/env python3
import json, pathlib, shutil, sys
program = pathlib.Path(sys.argv[0])
told = sys.argv[1:]
with open(program.parent / (program.name + ".jsonl"), "a") as log:
    log.write(json.dumps(told) + "\\n")
if program.name == "genPoly":
    shutil.copy(program.parent.parent / "roots.p4d", told[4] if told[0] == "GEN" else told[3])
elif program.name == "sdfGen":
    shutil.copy(told[0], program.parent / "target.obj")
    pathlib.Path(told[2]).write_bytes(b"")
else:
    pathlib.Path(told[8]).write_text("v 0 0 0\\nv 1 0 0\\nv 0 1 0\\n" + 3 * "f 1 2 3\\n")
"""
MAKEFILE = "all:\n\tmkdir -p bin\n\tfor p in sdfGen genPoly run; do cp stand_in bin/$$p && chmod +x bin/$$p; done\n"


class Peers(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.released = self.folder / "released"
        self.released.mkdir()
        (self.released / "stand_in").write_text(STAND_IN)
        (self.released / "Makefile").write_text(MAKEFILE)
        (self.released / "roots.p4d").write_bytes(harness.p4d(harness.ROOTS))
        # A box of quadrilaterals, far from the origin, two of whose faces count their corners from the end.
        self.mesh = self.folder / "box.obj"
        self.mesh.write_text("".join(f"v {10 + 4 * x} {-7 + 2 * y} {3 + z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1)) +
                             "f 1/1 2/2 4/3 3/4\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf -8 -6 -2 -4\nf -7 -3 -1 -5\n")

    def peers(self, *options):
        return subprocess.run([ROOT / "bench/peers", self.released, self.mesh, "--juliavdb", harness.program(), *options],
                              capture_output=True, text=True)

    def told(self, program):
        return [json.loads(line) for line in (self.released / f"bin/{program}.jsonl").read_text().splitlines()]

    def test_both_programs_get_the_same_map(self):
        done = self.peers("--resolution", "24,36", "--alpha", "30")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in done.stdout.splitlines()[2:]]
        self.assertEqual([row[0] for row in rows], ["24", "36"])
        self.assertEqual([row[4] for row in rows], ["3", "3"])
        # The shape's longest side is five sixths of the cube, about the origin.
        target = (self.released / "bin/target.obj").read_text().splitlines()
        corners = [tuple(map(float, line.split()[1:])) for line in target if line.startswith("v ")]
        for axis, half in enumerate((5 / 12, 5 / 24, 5 / 48)):
            self.assertEqual({round(abs(c[axis]) - half, 9) for c in corners}, {0})
        self.assertEqual(sum(line.startswith("f ") for line in target), 12)
        self.assertEqual([float(told[3]) for told in self.told("run")], [36, 36])
        for told, row in zip(self.told("run"), rows):
            size = int(told[2])
            own = self.folder / "own.obj"
            roots = self.released / "roots.p4d"
            subprocess.run([harness.program(), "fractal", self.released / "bin/target.obj", "--texture", roots, "--alpha", "30",
                            "--iterations", "3", "--origin", "centre", "--resolution", str(size / 1.2), "--mesh", own],
                           check=True, capture_output=True)
            faces = sum(line.startswith("f ") for line in own.read_text().splitlines())
            self.assertEqual(int(row[5]), faces)

    def test_a_resolution_that_is_none_is_refused_before_the_build(self):
        for wrong in ("abc", "100,", "100,1", ""):
            done = self.peers("--resolution", wrong)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertIn(f"'{wrong}'", done.stderr.splitlines()[-1])
        self.assertFalse((self.released / "bin").exists())

    def test_what_does_not_build_is_said(self):
        (self.released / "Makefile").write_text("all:\n\tfalse\n")
        done = self.peers()
        self.assertEqual(done.returncode, 1)
        self.assertIn("does not build", done.stderr)
        (self.released / "Makefile").write_text("all:\n\ttrue\n")
        self.assertIn("has no sdfGen, genPoly, run after make", self.peers().stderr)

    def test_a_program_that_fails_ends_the_run(self):
        (self.released / "stand_in").write_text("#!/bin/sh\nexit 3\n")
        done = self.peers()
        self.assertEqual(done.returncode, 1)
        self.assertIn("ended with 3", done.stderr)
        self.assertEqual(done.stdout, "")


if __name__ == "__main__":
    harness.main()

# SPDX-License-Identifier: Apache-2.0
"""The examples of the Python module run, and what they say is true."""
import importlib.util
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))

import harness

EXAMPLES = pathlib.Path(__file__).resolve().parent.parent.parent / "python/examples"


def missing(*modules):
    return [name for name in modules if importlib.util.find_spec(name) is None]


LACKING = missing("juliavdb", "numpy")
if LACKING:
    print(f"skipped: there is no {', '.join(LACKING)}")


@unittest.skipIf(LACKING, f"there is no {', '.join(LACKING)}")
class Examples(harness.CliTest):

    def run_example(self, name, *arguments):
        done = subprocess.run([sys.executable, EXAMPLES / name, *map(str, arguments)], cwd=self.folder,
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_dents(self):
        said = self.run_example("dents.py", "out.ply", 60)
        count, low, high, share = re.fullmatch(
            r"(\d+) vertices, from (\S+) to (\S+) off the torus, (\d+) % of its volume\n", said).groups()
        self.assertEqual(int(count), len(harness.read_ply(self.bytes("out.ply")).points))
        self.assertTrue(-0.4 < float(low) < -0.005 and float(high) < 0.2, said)
        self.assertTrue(20 < int(share) < 110, said)

    @unittest.skipIf(missing("pyopenvdb"), "there is no pyopenvdb")
    def test_through_pyopenvdb(self):
        self.write("torus.obj", harness.obj(harness.torus()))
        said = self.run_example("through_pyopenvdb.py", "torus.obj", "out.vdb", 50)
        voxels, mesh = map(float, re.search(r"inside hold (\S+), the mesh holds (\S+)\n", said).groups())
        self.assertAlmostEqual(voxels / mesh, 1, delta=0.02)
        self.assertGreater(float(re.search(r"same at (\S+) %", said).group(1)), 99)

    def test_the_picture(self):
        self.write("torus.obj", harness.obj(harness.torus()))
        self.assertEqual(self.run_example("picture_notebook.py", "torus.obj", "out.png", 48), "144 x 48 pixels\n")
        rows = harness.read_png(self.bytes("out.png"))
        self.assertEqual((len(rows), len(rows[0])), (48, 144))
        thirds = [[row[48 * i:48 * i + 48] for row in rows] for i in range(3)]
        for third in thirds:
            self.assertGreater(len({pixel for row in third for pixel in row}), 100, "something is seen")
        self.assertNotEqual(thirds[0], thirds[1])


if __name__ == "__main__":
    unittest.main()

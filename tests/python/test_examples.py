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

    def run_notebook(self, name, *arguments, mesh=True):
        """@return the numbers at the end of its lines, of which it prints one for each case"""
        if mesh and not self.path("torus.obj").exists():
            self.write("torus.obj", harness.obj(harness.torus()))
        said = self.run_example(f"notebooks/{name}", *(["torus.obj"] if mesh else []), "out.png", *arguments)
        width, height = harness.png_size(self.bytes("out.png"))
        colours = {pixel for row in harness.read_png(self.bytes("out.png")) for pixel in row}
        self.assertGreaterEqual(len(colours), 3, "something is seen")
        return [float(re.search(r": (?:at most .*: |a volume of some |dimension |IoU )?([\d.]+)", line).group(1))
                for line in said.splitlines()]

    # Promise of python.md: Seven notebooks "each answer a question with a picture", and the answers hold
    def test_deeper_detail_leaves_less(self):
        shares = self.run_notebook("1_first_fractal.py", 48)
        self.assertEqual(shares, sorted(shares, reverse=True))

    # Promise: Seven notebooks "each answer ..."
    def test_a_larger_alpha_leaves_less_open(self):
        shares = self.run_notebook("2_alpha.py", 48)
        self.assertEqual(shares, sorted(shares, reverse=True))

    # Promise: Seven notebooks "each answer ..."
    def test_a_map_of_ones_own(self):
        volumes = self.run_notebook("3_own_map.py", 48, mesh=False)
        self.assertEqual(len(set(volumes)), 3)
        self.assertTrue(all(0 < volume < 4 / 3 * 3.15 * 4**3 for volume in volumes), volumes)

    # Promise: Seven notebooks "each answer ..."
    def test_more_roots_fit_better(self):
        overlaps = self.run_notebook("4_fitting.py", 48)
        self.assertEqual(overlaps, sorted(overlaps))
        self.assertGreater(overlaps[-1], 0.8)

    # Promise: Seven notebooks "each answer ..."
    def test_the_dimension_of_a_smooth_surface_is_2(self):
        smooth, *rough = self.run_notebook("5_dimension.py", 60)
        self.assertAlmostEqual(smooth, 2, delta=0.1)
        self.assertTrue(all(smooth < dimension < 3 for dimension in rough), rough)

    # Promise: Seven notebooks "each answer ..."
    def test_floats_fail_where_points_are_near(self):
        flips = self.run_notebook("6_precision.py", 2000)
        self.assertLess(flips[0], 1)
        self.assertGreater(flips[-1], 5)

    # Promise: Seven notebooks "each answer ..."
    def test_the_document_is_complete(self):
        points, shell, differ = self.run_notebook("7_from_the_document.py", 4000)
        self.assertGreater(shell, points / 5)
        self.assertEqual(differ, 0)


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: Apache-2.0
"""The snippets of docs/python.md and of the README run one after the other, at a small size."""
import contextlib
import importlib.util
import io
import os
import pathlib
import re
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))

import harness
from shell import put_bunny

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PAGE, README = ROOT / "docs/python.md", ROOT / "README.md"
SMALL = [(r"\bresolution=\d{2,3}\b", "resolution=40"), (r"size=\(400, 300\)", "size=(40, 30)"),
         (r'("bunny\.obj"), (?!roots|resolution=\d+, band)', r"\1, sdf_resolution=40, "), (r"roots=331", "roots=12, resolution=24"), ("100000, 3", "2000, 3"),
         (r"\bsize=[12]00\b", "size=30"), (r"\[20, 30, 45\]", "[10, 14, 20]"), ("versors=20", "versors=3"), (r"band=4", "band=2")]
LACKING = [name for name in ("juliavdb", "numpy") if importlib.util.find_spec(name) is None]
if LACKING:
    print(f"skipped: there is no {', '.join(LACKING)}")


def small(block):
    for pattern, replacement in SMALL:
        block = re.sub(pattern, replacement, block)
    return block


def run_snippets(page):
    """Runs a page's snippets in a folder with a bunny: the names they leave, what each printed, the files."""
    names, said = {}, []
    with tempfile.TemporaryDirectory(prefix="juliavdb_test_") as folder:
        put_bunny(folder)
        before = os.getcwd()
        os.chdir(folder)
        try:
            for block in re.findall(r"```python\n(.*?)```", page.read_text(), re.S):
                out = io.StringIO()
                with contextlib.redirect_stdout(out):
                    exec(compile(small(block), str(page), "exec"), names)
                said.append(out.getvalue())
        finally:
            os.chdir(before)
        return names, said, sorted(os.listdir(folder))


class Page(unittest.TestCase):
    def setUp(self):
        self.text = PAGE.read_text()

    # Promise: The commands of the README ...
    @unittest.skipIf(LACKING, f"there is no {', '.join(LACKING)}")
    def test_every_snippet_runs(self):
        names, said, files = run_snippets(PAGE)
        self.assertEqual(len(said), 19)
        self.assertEqual(files, ["bunny.obj", "bunny.ply", "bunny.vdb", "cube.json", "cube.obj", "noise.vdb", "shape.json"])
        self.assertEqual(names["strip"].shape, (30, 80, 3))
        self.assertEqual((names["members"].shape, names["members"].dtype.kind), (names["phi_on_plane"].shape, "b"))
        self.assertLess(names["lowest"], names["value"])
        self.assertTrue(0.05 < names["share"] < 0.95)
        self.assertEqual(names["slopes"].shape, (24, 24, 24, 3))
        self.assertTrue(((names["proved"] == -1) <= (names["values"] < 0)).all())
        self.assertGreater((names["proved"] != 0).mean(), 0.1)
        for corner in (names["cube"].vertices.max(axis=0), -names["cube"].vertices.min(axis=0)):
            self.assertTrue((abs(corner - 1) < 0.3).all(), "the cube is about as large as it was")
        self.assertRegex(said[-5], r"100%(.|\n)*\ncancelled\n\Z")
        self.assertIn("would take at least", said[-4])
        self.assertIn("Evaluates on", said[-2])
        self.assertIn("detail is '7'", said[-1])
        self.assertNotIn("--", said[-1])

    @unittest.skipIf(LACKING, f"there is no {', '.join(LACKING)}")
    def test_the_snippet_of_the_readme_runs(self):
        names, said, files = run_snippets(README)
        self.assertEqual(len(said), 1)
        self.assertEqual(files, ["bunny.obj", "bunny.ply", "bunny.vdb"])
        self.assertEqual(names["picture"].shape, (30, 40, 3))
        inside, outside = names["field"]([[0.0, 0.1, 0.0], [5.0, 5.0, 5.0]])
        self.assertTrue(inside < 0 < outside)

    # Promise: The exceptions, and that they ...
    def test_the_exit_codes_are_those_of_the_program(self):
        codes = set(map(int, re.findall(r"\b\d+\b", " ".join(re.findall(r"^\|.*\| ([\d, ]+) \|$", self.text, re.M)))))
        self.assertEqual(codes, {harness.USAGE, harness.BAD_DATA, harness.NO_INPUT, harness.CANNOT_CREATE,
                                 harness.INTERNAL, harness.IO_ERROR, harness.INTERRUPTED})


if __name__ == "__main__":
    unittest.main()

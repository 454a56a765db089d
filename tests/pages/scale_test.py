# SPDX-License-Identifier: Apache-2.0
"""docs/scale.md: the tables that bench/scale measures are of the set that the program makes, and the script works."""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from shell import BUNNY, PROGRAM, put_bunny

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PAGE = ROOT / "docs/scale.md"
PLACE = re.compile(r"<!-- bench/scale: (\w+), of the set (\w+) -->")


def scale(mesh, *words):
    done = subprocess.run([sys.executable, ROOT / "bench/scale", "--mesh", mesh, *words], capture_output=True, text=True,
                          env={**os.environ, "JULIAVDB": str(PROGRAM)}, check=True)
    return done.stdout


class ScalePage(unittest.TestCase):

    # Promise of scale.md: "a test says when they are of another set than the program makes"
    def test_the_tables_are_of_todays_set(self):
        places = PLACE.findall(PAGE.read_text())
        self.assertEqual([name for name, _ in places], ["growth", "dimension"])
        self.assertEqual({made for _, made in places}, {scale(BUNNY, "--set").strip()},
                         "the default set is another one than the page's tables are of; run "
                         "bench/scale --mesh bunny.obj --into docs/scale.md")

    def test_the_script_fills_its_places_and_leaves_the_rest(self):
        with tempfile.TemporaryDirectory() as folder:
            page = pathlib.Path(folder) / "page.md"
            page.write_text(PAGE.read_text())
            mesh = put_bunny(folder)
            scale(mesh, "--quick", "--into", page, "growth")
            before, after = PAGE.read_text(), page.read_text()
            self.assertIn("| 60 | 20 |", after)
            self.assertRegex(after, r"triangles = [\d.e+]+ N\^2\.\d+")
            blank = re.compile(r"<!-- bench/scale: growth.*?<!-- end -->", re.S)
            self.assertEqual(blank.sub("", before), blank.sub("", after))
            self.assertNotEqual(scale(mesh, "--set"), scale(BUNNY, "--set"))


if __name__ == "__main__":
    unittest.main()

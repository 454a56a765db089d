# SPDX-License-Identifier: Apache-2.0
# Promise of textures.md: Textures: the table, the default, and those that `--texture-seed` varies
"""docs/textures.md has every texture of the shelf, in its order and its words."""
import json
import os
import pathlib
import re
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PAGE = ROOT / "docs" / "textures.md"


def listed(*options):
    return subprocess.run([os.environ["JULIAVDB"], "versor", "list", *options], capture_output=True, text=True,
                          check=True).stdout


class TexturesPage(unittest.TestCase):
    maxDiff = None

    def test_the_table_is_that_of_the_program(self):
        rows = re.findall(r"^\| `(\w+)` \| (.*?) \| (yes|no) \| 2\.\d\d \|$", PAGE.read_text(), re.M)
        textures = [(t["name"], t["description"], "yes" if t["follows_thickness"] else "no") for t in json.loads(listed("--json"))]
        self.assertEqual(rows, textures, "copy it from: juliavdb versor list --json")

    def test_the_default_is_named(self):
        default, = [texture["name"] for texture in json.loads(listed("--json")) if texture["default"]]
        self.assertIn(f"`{default}` is the default", PAGE.read_text())

    def test_the_textures_that_vary_are_named(self):
        varying = [f"`{texture['name']}`" for texture in json.loads(listed("--json")) if texture["seed"]]
        sentence, = re.findall(r"^`--texture-seed` varies (.*?)\.", PAGE.read_text(), re.M | re.S)
        self.assertEqual(re.findall(r"`\w+`", sentence), varying)

    def test_the_list_has_a_line_for_each(self):
        lines = listed().splitlines()
        textures = json.loads(listed("--json"))
        self.assertEqual(len(lines), len(textures))
        for line, texture in zip(lines, textures):
            self.assertTrue(line.startswith(texture["name"] + " "), line)
            self.assertIn(texture["description"], line)


if __name__ == "__main__":
    unittest.main()

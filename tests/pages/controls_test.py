# SPDX-License-Identifier: Apache-2.0
"""The commands of docs/controls.md, textures.md, attributes.md, points.md, printing.md, pictures.md, handoff.md, motion.md, unreal.md and
coming-from.md run as they stand, at a small size, and the blocks of a terminal look like what the program says."""
import pathlib
import re
import tempfile
import unittest

from shell import BUNNY, put_bunny, run, with_bunny, with_option

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
# Enough to see that a command does what it should.
SMALL = [(r"--size \d+x\d+", "--size 40x40 --samples 1"), (r"--resolution \d+", "--resolution 40"),
         (r"--min-thickness 1.5", "--min-thickness 8"), (r"--points \d+", "--points 500"),
         (r"(juliavdb print .*)", r"\1 --resolution 40"),
         (r"\b(fractal|sheet|render --field) (\S+\.(?:obj|ply)|-o shapes.png)", r"\1 \2 --sdf-resolution 48")]


def small(block):
    for pattern, replacement in SMALL:
        block = re.sub(pattern, replacement, block)
    block = with_option(with_option(block, "fractal", "--resolution 40"), "sheet", "--size 40x40 --samples 1")
    return block


class Pages(unittest.TestCase):
    # Promise: Half frames: "they are one ..."
    # Promise: The commands of the README ...
    def test_every_command_runs(self):
        for page in ("controls", "textures", "attributes", "points", "printing", "pictures", "handoff", "unreal", "coming-from",
                     "motion"):
            text = (ROOT / f"docs/{page}.md").read_text()
            blocks = re.findall(r"```sh\n(.*?)```", text, re.S)
            self.assertTrue(blocks, page)
            with tempfile.TemporaryDirectory() as folder:
                put_bunny(folder)
                for block in blocks:
                    done = run(small(with_bunny(block, folder)), folder)
                    self.assertEqual(done.returncode, 0, f"{page}: {block}\n{done.stderr}")

    def test_what_the_program_says_has_the_form_of_the_page(self):
        text = (ROOT / "docs/controls.md").read_text()
        shown, = re.findall(r"^```\n(origin at .*?)```", text, re.M | re.S)
        with tempfile.TemporaryDirectory() as folder:
            put_bunny(folder)
            said = run("juliavdb fractal bunny.obj -o b.vdb --resolution 40 --sdf-resolution 60", folder).stderr
        number = r"-?\d[\d.e+-]*"
        for line in shown.splitlines():
            form = re.sub(rf"(?<![\w.]){number}", "N", line)
            self.assertIn(form, [re.sub(rf"(?<![\w.]){number}", "N", other) for other in said.splitlines()])


if __name__ == "__main__":
    unittest.main()

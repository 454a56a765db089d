# SPDX-License-Identifier: Apache-2.0
"""The commands of docs/targets.md run as they stand, at a small size, and its table has every way of mending."""
import pathlib
import re
import tempfile
import unittest

from shell import run

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
TEXT = (ROOT / "docs/targets.md").read_text()


class TargetsPage(unittest.TestCase):
    # Promise: The commands of the README ...
    def test_every_command_runs(self):
        blocks = re.findall(r"```sh\n(.*?)```", TEXT, re.S)
        self.assertGreater(len(blocks), 5)
        with tempfile.TemporaryDirectory() as folder:
            for block in blocks:
                block = block.replace("docs/make-targets", str(ROOT / "docs/make-targets"))
                block = re.sub(r"(juliavdb fractal \S+\.vdb .*) --resolution \d+", r"\1 --resolution 41", block)
                block = re.sub(r"(juliavdb fractal .*) --resolution (?!41)\d+", r"\1 --resolution 40 --sdf-resolution 120", block)
                done = run(block, folder)
                self.assertEqual(done.returncode, 0, f"{block}\n{done.stderr}")

    # Promise of targets.md: A mesh that bounds no volume "is refused, and the message names the option that may help"
    def test_none_of_them_is_a_target_as_it_is(self):
        with tempfile.TemporaryDirectory() as folder:
            run(f"{ROOT}/docs/make-targets .", folder)
            for name, option in (("vase.obj", "--repair"), ("terrain.obj", "--solidify"), ("sheet.obj", "--thicken"),
                                 ("scan.ply", "--points-radius")):
                done = run(f"juliavdb sdf {name} -o x.vdb --resolution 60", folder)
                self.assertEqual(done.returncode, 65, name)
                self.assertIn(option, done.stderr)

    def test_it_names_every_option(self):
        said = run("juliavdb sdf --help", "/").stdout
        for option in re.findall(r"^  --((?:repair|solidify|thicken|points|hollows|iso|invert)[a-z-]*)", said, re.M):
            self.assertIn(f"--{option}", TEXT)


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: Apache-2.0
# Promise: The commands of the README ...
"""The commands of docs/gallery.md run, at a small size, and make the pictures that it shows; those are there."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from shell import put_bunny

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PAGE = (ROOT / "docs/gallery.md").read_text()
PICTURES = set(re.findall(r"images/gallery/([\w-]+\.png)", PAGE + (ROOT / "README.md").read_text()))
FIGURES = {"SK23": tuple(range(2, 14)), "Kim15": (2, 3, 4, 5, 6, 8, 11), "ZB25": tuple(range(1, 8))}


class Gallery(unittest.TestCase):
    def test_every_figure_has_its_place(self):
        sections = re.split(r"^### ", PAGE, flags=re.M)[1:]
        titles = [re.match(r"\[(\w+)\] Fig\. (\d+): ", section).groups() for section in sections]
        self.assertEqual(titles, [(paper, str(number)) for paper, numbers in FIGURES.items() for number in numbers])
        for (paper, number), section in zip(titles, sections):
            names = set(re.findall(r"images/gallery/([\w-]+)\.png", section))
            self.assertTrue(names, section)
            self.assertEqual({re.sub(r"[a-z]$", "", name) for name in names}, {f"{paper.lower()}-{number}"})

    def test_every_picture_is_there_and_no_other(self):
        self.assertEqual(sorted(PICTURES), sorted(p.name for p in (ROOT / "docs/images/gallery").iterdir()))

    # Promise: Links, citations and names ...
    def test_the_commands_make_the_pictures(self):
        with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as models:
            bunny = put_bunny(models)
            done = subprocess.run([sys.executable, ROOT / "docs/make-gallery", "--small", "--bunny", bunny, "--dragon", bunny,
                                   "--into", folder],
                                  capture_output=True, text=True, env={**os.environ})
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(sorted(PICTURES), sorted(os.listdir(folder)))
            for picture in pathlib.Path(folder).iterdir():
                self.assertEqual(picture.read_bytes()[:4], b"\x89PNG", picture)

    # Promise: Links, citations and names ...
    def test_stored_pictures_are_what_their_commands_make(self):
        """Pixel for pixel; of some figures, and before a release docs/check-pictures compares all. Another texture, as when a
        default has changed, is found."""
        def check(*options):
            return subprocess.run([sys.executable, ROOT / "docs/make-gallery", "--check", *options], capture_output=True,
                                  text=True)
        done = check("zb25-1")
        self.assertEqual(done.returncode, 0, done.stderr)
        # Of the figures that are stored, one picture is that of another command.
        with tempfile.TemporaryDirectory() as folder:
            stored = pathlib.Path(folder)
            shutil.copytree(ROOT / "docs/images/gallery", stored, dirs_exist_ok=True)
            (stored / "zb25-2b.png").write_bytes((stored / "zb25-2a.png").read_bytes())
            done = check("hero-1", "zb25-2", "--into", folder)
            self.assertEqual(done.returncode, 1)
            self.assertEqual(done.stderr.splitlines()[-1], f"{folder}: not what their commands make: zb25-2b.png")


if __name__ == "__main__":
    unittest.main()

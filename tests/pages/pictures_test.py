# SPDX-License-Identifier: Apache-2.0
"""The pictures of the pages are what docs/check-pictures makes: some of them here, and all of them before a release."""
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
THUMBNAILS = "vdbtools/src/explore/page"


def check(*words, root=ROOT):
    return subprocess.run([root / "docs/check-pictures", *words], capture_output=True, text=True)


def put_copy(folder):
    """Puts what docs/check-pictures reads into a folder."""
    root = pathlib.Path(folder)
    shutil.copytree(ROOT / "docs", root / "docs")
    shutil.copyfile(ROOT / "README.md", root / "README.md")
    shutil.copytree(ROOT / THUMBNAILS, root / THUMBNAILS)
    return root


class Pictures(unittest.TestCase):
    # Promise: Links, citations and names ...
    def test_every_picture_has_a_script_or_a_reason(self):
        done = check("--list")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        with tempfile.TemporaryDirectory() as folder:
            root = put_copy(folder)
            images = root / "docs/images"
            (images / "detail.png").rename(images / "more.png")
            (images / "explore.png").unlink()
            (images / "gallery/zb25-1a.png").rename(images / "gallery/other.png")
            (root / THUMBNAILS / "texture-bark.jpg").rename(root / THUMBNAILS / "texture-moss.jpg")
            done = check("--list", root=root)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertEqual([line for line in done.stdout.splitlines() if line.startswith(("docs/", "vdbtools/"))], [
                "docs/images/detail.png is missing", "docs/images/explore.png is missing",
                "docs/images/gallery/zb25-1a.png is missing", f"{THUMBNAILS}/texture-bark.jpg is missing",
                "docs/images/gallery/other.png: no script makes it", "docs/images/more.png: no script makes it",
                f"{THUMBNAILS}/texture-moss.jpg: no script makes it"])

    # Promise: Links, citations and names ...
    def test_stored_pictures_are_what_their_scripts_make(self):
        """Some that cost little. Another picture in the place of one is found."""
        with tempfile.TemporaryDirectory() as folder:
            root = put_copy(folder)
            gallery = root / "docs/images/gallery"
            shutil.copyfile(gallery / "zb25-2a.png", gallery / "zb25-1a.png")
            done = check("controls_expression", "study_curve", "zb25-1", root=root)
        self.assertEqual(done.stdout.splitlines(), ["docs/images/gallery/zb25-1a.png is not what docs/make-gallery makes",
                                                    "3 pictures were compared; 1 is wrong"], done.stderr)
        self.assertEqual(done.returncode, 1)

    def test_what_cannot_be_compared_is_said(self):
        done = check("explore")
        self.assertEqual(done.returncode, 1)
        self.assertIn("'explore' cannot be compared: a screenshot of a browser", done.stderr)


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: Apache-2.0
"""docs/maps.md is what the program says of its maps."""
import os
import pathlib
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


class MapsPage(unittest.TestCase):
    maxDiff = None

    # Promise of maps.md: Every map has the options, defaults and words of the page
    def test_the_page_is_that_of_the_registry(self):
        page = subprocess.run([os.environ["JULIAVDB"], "maps", "--markdown"], capture_output=True, text=True, check=True)
        self.assertEqual((ROOT / "docs" / "maps.md").read_text(), page.stdout,
                         "write it again: juliavdb maps --markdown > docs/maps.md")


if __name__ == "__main__":
    unittest.main()

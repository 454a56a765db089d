# SPDX-License-Identifier: Apache-2.0
"""samples/own_map.cpp: a map that only one file knows of goes through the job like the built-in ones."""
import os
import pathlib
import subprocess
import sys
import unittest

import pyopenvdb

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))
import harness

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


class OwnMap(harness.CliTest):

    # Promise of architecture.md: "A map that is not part of the project is added to the `MapRegistry` by the program that has it"
    def test_it_makes_a_closed_mesh_and_a_level_set_with_its_recipe(self):
        done = subprocess.run([os.environ["JULIAVDB_OWN_MAP"], self.folder], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        mesh = harness.read_ply(self.bytes("own_map.ply"))
        self.assertGreater(len(mesh.faces), 1000)
        self.assertEqual(harness.open_edges(mesh), [])
        self.assertGreater(harness.volume_of(mesh), 0)
        self.assertEqual(self.info("own_map.vdb")["grids"][0]["level set check"], "passes")
        metadata = pyopenvdb.readMetadata(str(self.path("own_map.vdb")))
        self.assertEqual((metadata["julia_map"], metadata["julia_exponent"]), ("power", "4"))

    # Promise: "A map that is not part of the project ..."
    def test_no_other_file_knows_of_it(self):
        for folder in ("libjulia", "vdbtools", "cli"):
            for path in (ROOT / folder).rglob("*.[ch]*"):
                self.assertNotIn("PowerDescriptor", path.read_text(), path)


if __name__ == "__main__":
    harness.main()

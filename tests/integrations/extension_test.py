# SPDX-License-Identifier: Apache-2.0
"""The archive of the add-on as an extension, by Blender's own commands: whether it is valid, and whether it runs once it is
installed from its file. Extensions are what Blender installs from 4.2 on."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SOURCES = ROOT / "integrations/blender/juliavdb_addon"
ARCHIVE = pathlib.Path(os.environ["JULIAVDB_BUILD"]) / "integrations/blender/juliavdb_addon.zip"

# Makes a fractal of a ball by the installed extension.
USE = """
import sys
import bpy
name = "bl_ext.user_default.juliavdb_addon"
bpy.context.preferences.addons[name].preferences.program = sys.argv[-1]
bpy.ops.mesh.primitive_uv_sphere_add()
bpy.context.object.juliavdb.resolution = 24
bpy.context.object.juliavdb.more = "--sdf-resolution 24"
assert bpy.ops.juliavdb.make() == {"FINISHED"}
print("made", len(bpy.context.object.data.polygons), "triangles in place of", len(bpy.context.object.parent.data.polygons))
"""


class Extension(unittest.TestCase):

    def setUp(self):
        self.home = tempfile.mkdtemp(prefix="juliavdb_extension_")
        self.addCleanup(shutil.rmtree, self.home, ignore_errors=True)

    def blender(self, *words):
        """@return the status and all that was said. Settings and extensions are those of a new user."""
        run = subprocess.run([BLENDER, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                             env={**os.environ, "HOME": self.home, "XDG_CONFIG_HOME": f"{self.home}/config",
                                  "XDG_DATA_HOME": f"{self.home}/data", "XDG_CACHE_HOME": f"{self.home}/cache",
                                  "TMPDIR": self.home, "PYTHONDONTWRITEBYTECODE": "1"})
        return run.returncode, run.stdout

    def ok(self, *words):
        status, said = self.blender(*words)
        self.assertEqual(status, 0, said)
        return said

    # Promise of blender.md: "From 4.2 on it is an extension"
    def test_its_sources_and_its_archive_are_valid(self):
        built = pathlib.Path(self.home) / "built.zip"
        self.ok("--command", "extension", "build", "--source-dir", SOURCES, "--output-filepath", built)
        for what in (SOURCES, ARCHIVE, built):
            with self.subTest(what=what):
                self.assertIn("Success", self.ok("--command", "extension", "validate", what))
        wrong = pathlib.Path(self.home) / "wrong"
        shutil.copytree(SOURCES, wrong)
        manifest = wrong / "blender_manifest.toml"
        manifest.write_text(manifest.read_text().replace("version = \"1", "version = \"one", 1))
        self.assertNotEqual(self.blender("--command", "extension", "validate", wrong)[0], 0)

    # Promise: "From 4.2 on it is an extension"
    def test_it_runs_once_it_is_installed(self):
        self.ok("--command", "extension", "install-file", "-r", "user_default", "-e", ARCHIVE)
        script = pathlib.Path(self.home) / "use.py"
        script.write_text(USE)
        said = self.ok("--background", "-noaudio", "--python-exit-code", "1", "--python", script, "--",
                       os.path.abspath(os.environ["JULIAVDB"]))
        made = re.search(r"^made (\d+) triangles in place of (\d+)$", said, re.M)
        self.assertTrue(made, said)
        self.assertGreater(int(made[1]), int(made[2]))


if __name__ == "__main__":
    BLENDER = shutil.which("blender")
    if not BLENDER:
        print("skipped: blender is not installed")
        sys.exit(0)
    version = subprocess.run([BLENDER, "--version"], capture_output=True, text=True, check=True).stdout
    major, minor = map(int, re.search(r"^Blender (\d+)\.(\d+)", version, re.M).groups())
    if (major, minor) < (4, 2):
        print(f"skipped: Blender {major}.{minor} installs add-ons and not extensions")
        sys.exit(0)
    unittest.main()

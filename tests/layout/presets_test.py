#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every preset of CMakePresets.json configures, also with the libraries as other releases of Debian have them, and what the
presets of the sanitizers leave out are tests that exist.

A preset that only a developer uses breaks unseen. Where its compiler is not installed, the one of this build stands in for
it. Usage: presets_test.py CMAKE CTEST BUILD COMPILER
"""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

CMAKE, CTEST, BUILD, COMPILER = sys.argv[1:5] if len(sys.argv) > 4 else ("cmake", "ctest", "build/release", "g++")
del sys.argv[1:]
SOURCE = os.path.abspath(os.path.join(os.path.dirname(__file__), "../.."))

with open(os.path.join(SOURCE, "CMakePresets.json"), encoding="utf-8") as presets_file:
    PRESETS = json.load(presets_file)


# What Debian 13 has in its package libdraco-dev.
DRACO_OF_DEBIAN_13 = """Name: draco
Description: Draco geometry de(com)pression library.
Version: 1.5.6
Cflags: -Iinclude
Libs: -Llib/x86_64-linux-gnu -ldraco
Libs.private:
"""


def visible(kind):
    return [preset for preset in PRESETS[kind] if not preset.get("hidden")]


class Presets(unittest.TestCase):
    def configure(self, preset, build, compiler, **environment):
        run = subprocess.run([CMAKE, "--preset", preset, "-B", build, "-DJULIAVDB_TESTS=ON", "-DCMAKE_CXX_COMPILER=" + compiler],
                             cwd=SOURCE, env={**os.environ, **environment}, capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stderr[-3000:])

    def test_each_configures(self):
        bases = {preset["name"]: preset for preset in PRESETS["configurePresets"]}
        for preset in visible("configurePresets"):
            values, chain = {}, preset
            while chain:
                values = {**chain.get("cacheVariables", {}), **values}
                chain = bases.get(chain.get("inherits"))
            wanted = values.get("CMAKE_CXX_COMPILER", COMPILER)
            if not shutil.which(wanted) and values.get("JULIAVDB_FUZZ"):
                continue  # Fuzzing is for clang alone, and says so.
            with self.subTest(preset["name"]), tempfile.TemporaryDirectory() as build:
                self.configure(preset["name"], build, wanted if shutil.which(wanted) else COMPILER)
                self.assertTrue(os.path.exists(os.path.join(build, "build.ninja")))

    @unittest.skipUnless(subprocess.run(["pkg-config", "--exists", "draco"], check=False).returncode == 0, "needs libdraco-dev")
    def test_folders_without_a_prefix(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "draco.pc"), "w", encoding="utf-8") as file:
                file.write(DRACO_OF_DEBIAN_13)
            build = os.path.join(folder, "build")
            self.configure("release", build, COMPILER, PKG_CONFIG_PATH=folder)
            with open(os.path.join(build, "CMakeCache.txt"), encoding="utf-8") as cache:
                self.assertRegex(cache.read(), r"\nDraco_VERSION:INTERNAL=1\.5\.6\n")
            with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as commands:
                self.assertNotIn("VDBTOOLS_NO_DRACO", commands.read())

    def test_tests_left_out_exist(self):
        listed = subprocess.run([CTEST, "--test-dir", BUILD, "-N"], capture_output=True, text=True, check=True).stdout
        names = re.findall(r"^ *Test +#\d+: (\S+)", listed, re.M)
        filters = [preset["filter"]["exclude"]["name"] for preset in PRESETS["testPresets"] if "filter" in preset]
        self.assertTrue(filters)
        for text in filters:
            self.assertTrue(text.startswith("^(") and text.endswith(")$"), text)
            for name in re.split(r"\|(?![^(]*\))", text[2:-2]):
                with self.subTest(name):
                    self.assertTrue(any(re.fullmatch(name, test) for test in names))


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every preset of CMakePresets.json configures, and what the presets of the sanitizers leave out are tests that exist.

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


def visible(kind):
    return [preset for preset in PRESETS[kind] if not preset.get("hidden")]


class Presets(unittest.TestCase):
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
                run = subprocess.run([CMAKE, "--preset", preset["name"], "-B", build, "-DJULIAVDB_TESTS=ON",
                                      "-DCMAKE_CXX_COMPILER=" + (wanted if shutil.which(wanted) else COMPILER)],
                                     cwd=SOURCE, capture_output=True, text=True, check=False)
                self.assertEqual(run.returncode, 0, run.stderr[-3000:])
                self.assertTrue(os.path.exists(os.path.join(build, "build.ninja")))

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

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""All outputs go through vdbtools/files/output_files.h, where none can be one of the inputs.

A temporary file that is opened past it is a place where an input could be lost. The exceptions below write under names
that nobody has chosen.
"""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]

# How an AtomicFile, or a list of them, is made.
MADE = re.compile(r"\bAtomicFile>?(\s+\w+)?\s*[({]|<(vdbtools::)?AtomicFile>\s+\w+\s*[;({=]|\bAtomicFile\s+\w+;")

EXCEPTIONS = {
    "vdbtools/src/farm/manifest.cpp": "the manifest, in a folder that is new or empty",
    "vdbtools/src/farm/tile_plan.cpp": "the prepared scene, in the same folder",
    "vdbtools/src/farm/task.cpp": "side-cars, in the plan's folder of tasks",
    "vdbtools/src/farm/target_store.cpp": "distances by their hash, in the plan's folder of targets",
    "vdbtools/src/job/sheet_job.cpp": "cells by their hash, in the sheet's folder of cells",
    "vdbtools/src/farm/merge.cpp": "an empty file, to try places that OutputPlaces has checked; it goes again at once",
    "cli/commands/submit.cpp": "the script in the plan's folder of logs",
}


def makers():
    found = set()
    for layer in ("cli", "vdbtools", "python", "samples"):
        for path in sorted((ROOT / layer).rglob("*")):
            name = str(path.relative_to(ROOT))
            if path.suffix not in (".h", ".cpp") or "/files/" in name:
                continue
            code = "\n".join(line.partition("//")[0] for line in path.read_text().splitlines())
            if MADE.search(code):
                found.add(name)
    return found


class Outputs(unittest.TestCase):

    # Promise: "No output replaces an input", through ...
    def test_nothing_is_written_past_the_check(self):
        self.assertEqual(makers(), set(EXCEPTIONS))

    def test_the_pattern_finds_every_way(self):
        for code in ("AtomicFile file(path);", "vdbtools::AtomicFile file{path};", "std::list<AtomicFile> files;",
                     "AtomicFile(path).commit();", "std::vector<vdbtools::AtomicFile> files(3);", "AtomicFile file;",
                     "std::make_unique<AtomicFile>(path)"):
            self.assertRegex(code, MADE)
        for code in ("AtomicFile& file = outputs.add(path);", "void write(AtomicFile& file);", "AtomicFile* vdb = nullptr;",
                     "for (const AtomicFile& file : files) use(file);", "const std::list<AtomicFile>& files"):
            self.assertNotRegex(code, MADE)


if __name__ == "__main__":
    unittest.main()

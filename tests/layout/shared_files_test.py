#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""No test uses a file that another could use: tests run at the same time, and whole suites do.

In C++ the folder for temporary files is named in support/temporary_folder.h alone, which makes a folder of its own for
each test. In Python a test takes tempfile.TemporaryDirectory() or mkdtemp(), and nothing asks for the folder they lie in.
"""
import pathlib
import re
import unittest

TESTS = pathlib.Path(__file__).resolve().parent.parent
# in_blender.py gives all of Blender's tests a folder for temporary files of their own.
ALLOWED = {"support/temporary_folder.h", "layout/shared_files_test.py", "integrations/blender_test.py"}
SHARED = {".cpp": re.compile(r'\bTempDir\(|temp_directory_path|mkd?s?temp\(|tmpnam|"/(?:var/)?tmp/'),
          ".py": re.compile(r"\bgettempdir|\bmktemp\(|open\(f?[\"']/tmp|Path\(f?[\"']/tmp")}
SHARED[".h"] = SHARED[".cpp"]


def shared(suffix, text):
    return [match.group() for match in SHARED[suffix].finditer(text)]


class SharedFiles(unittest.TestCase):
    def test_in_every_test(self):
        files = [path for path in TESTS.rglob("*") if path.suffix in SHARED]
        self.assertGreater(len(files), 100)
        for path in files:
            name = str(path.relative_to(TESTS))
            if name not in ALLOWED:
                with self.subTest(file=name):
                    self.assertEqual(shared(path.suffix, path.read_text()), [])

    def test_that_one_is_found(self):
        self.assertEqual(shared(".cpp", 'std::string name = testing::TempDir() + "x.sh";'), ["TempDir("])
        self.assertEqual(shared(".h", 'fs::temp_directory_path() / "x"'), ["temp_directory_path"])
        self.assertEqual(shared(".py", 'open("/tmp/x")'), ['open("/tmp'])
        self.assertEqual(shared(".py", "folder = tempfile.mkdtemp()"), [])


if __name__ == "__main__":
    unittest.main()

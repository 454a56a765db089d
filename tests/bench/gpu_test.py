# SPDX-License-Identifier: Apache-2.0
"""bench/gpu, at tiny sizes on pocl: what it measures, and that a run that is cut short leaves a result."""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/cli"))
import harness


class Gpu(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="juliavdb_gpu_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "t.obj").write_text(harness.obj(harness.torus()))

    def gpu(self, *words, env=None):
        """@return the exit code, the results if there are any, the table, and what it said"""
        done = subprocess.run([sys.executable, ROOT / "bench/gpu", "--quick", "--out", self.folder / "out", *map(str, words)],
                              capture_output=True, text=True, timeout=600, env={**os.environ, **(env or {})})
        files = [self.folder / "out" / name for name in ("gpu.json", "gpu.md")]
        texts = [file.read_text() if file.is_file() else "null" for file in files]
        self.assertEqual({file.name for file in (self.folder / "out").glob("*")} - {"gpu.json", "gpu.md"}, set(), "left behind")
        return done.returncode, json.loads(texts[0]), texts[1], done.stderr

    @unittest.skipUnless(harness.has_opencl(), "no device of OpenCL is installed")
    def test_everything_is_measured_and_has_the_same_bytes(self):
        code, results, table, said = self.gpu("--seconds", 400, "--mesh", self.folder / "t.obj")
        self.assertEqual(code, 0, said)
        self.assertTrue(results["complete"], results)
        self.assertNotIn("kernels_failed", results)
        kernels = {(each["what"], each["field"], each["real"], each["where"]) for each in results["kernels"]}
        for what in ("nodes", "points", "edges", "rays"):
            for field in ("roots:10", "roots:60", "roots:400", "waves", "mandelbulb"):
                for real in ("float", "double"):
                    for where in ("device", "one core"):
                        self.assertIn((what, field, real, where), kernels)
        self.assertTrue(all(each["rate"] > 0 for each in results["kernels"]))
        self.assertEqual(len(results["commands"]), 9)
        for command in results["commands"]:
            self.assertIs(command["same"], True, command)
            self.assertGreater(command["device"]["counts"]["devicePoints"], 0)
            self.assertNotIn("devicePoints", command["processor"]["counts"])
            # A device that was left alone would have the processor's bytes, too.
            self.assertNotIn("The processor", " ".join(command["device"]["messages"]))
            self.assertIn(f"| {command['name']} | ", table)
        self.assertEqual(table.count("| the same |"), 9)
        self.assertNotIn("The time was over", table)

    @unittest.skipUnless(harness.has_opencl(), "no device of OpenCL is installed")
    def test_a_run_that_is_cut_short_is_a_result(self):
        code, results, table, said = self.gpu("--seconds", 4)
        self.assertEqual(code, 0, said)
        self.assertFalse(results["complete"])
        self.assertTrue(results["devices"]["devices"][0]["usable"])
        self.assertLess(len(results["commands"]), 9)
        self.assertIn("The time was over", table)
        self.assertIn("lumpy" if not pathlib.Path("/usr/share/glmark2/models/bunny.obj").is_file() else "bunny", results["mesh"])

    def test_without_a_device_it_says_where_drivers_were_looked_for(self):
        code, results, _, said = self.gpu(env={"OCL_ICD_VENDORS": "/nonexistent"})
        self.assertEqual(code, 1)
        self.assertIn("no device can be used", said)
        self.assertEqual(results["devices"]["devices"], [])
        self.assertEqual(results["commands"], [])

    def test_other_bytes_are_a_failure(self):
        """A stand-in for the program, whose device makes another file."""
        stand_in = self.folder / "juliavdb"
        stand_in.write_text("#!/usr/bin/env python3\n" + STAND_IN)
        stand_in.chmod(0o755)
        code, results, table, said = self.gpu("--program", stand_in, "--mesh", self.folder / "t.obj",
                                              env={"JULIAVDB_DEVICE_BENCH": "/nonexistent"})
        self.assertEqual(code, 1, said)
        self.assertIs(results["commands"][0]["same"], False)
        self.assertIn("| **other** |", table)
        self.assertIn("device_bench", results["kernels_failed"])

    def test_the_time_limit_and_the_file_names_of_the_page(self):
        page = (ROOT / "docs/gpu.md").read_text()
        self.assertIn("in four minutes at most", page)
        self.assertTrue(re.search(r'--seconds", type=float, default=240', (ROOT / "bench/gpu").read_text()))
        shown = subprocess.run([sys.executable, ROOT / "bench/gpu", "--help"], capture_output=True, text=True).stdout
        for option in ("--out", "--mesh", "--seconds"):
            self.assertIn(option, shown)


STAND_IN = """
import json, pathlib, sys
words = sys.argv[1:]
if words[0] == "devices":
    print(json.dumps({"devices": [{"name": "a liar", "usable": True, "refusal": ""}], "drivers": []}))
    sys.exit()
for option in ("--mesh", "-o"):
    if option in words and words[0] != "plan":
        pathlib.Path(words[words.index(option) + 1]).write_text(" ".join(word for word in words if word == "--device"))
print(json.dumps({"cpu": 0, "counts": {}, "phases": [], "messages": []}), file=sys.stderr)
"""


if __name__ == "__main__":
    unittest.main()

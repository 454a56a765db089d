# SPDX-License-Identifier: Apache-2.0
"""The conformance set (docs/conformance.md): the program has the results that it tells, and its check notices where not."""
import gzip
import importlib.util
import json
import pathlib
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))

import harness

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
TOOL, FILE = ROOT / "reproduce/tools/conformance", ROOT / "reproduce/data/conformance/conformance.json.gz"
LACKING = [name for name in ("juliavdb", "numpy") if importlib.util.find_spec(name) is None]
if LACKING:
    print(f"skipped: there is no {', '.join(LACKING)}")


@unittest.skipIf(LACKING, f"there is no {', '.join(LACKING)}")
class Conformance(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.said = json.loads(gzip.decompress(FILE.read_bytes()))
        self.cases = {case["name"]: case for case in self.said["cases"]}

    @staticmethod
    def check(*arguments):
        return subprocess.run([sys.executable, TOOL, "check", *map(str, arguments)], capture_output=True, text=True)

    def changed(self, *arguments):
        """What the check says of the file as self.said has it now."""
        self.write("changed.json.gz", gzip.compress(json.dumps(self.said).encode()))
        return self.check(self.path("changed.json.gz"), *arguments)

    # Promise of conformance.md: "The tests check this program against" the conformance set, whose results "do not come from the
    #   program"
    def test_the_program_has_the_results_of_the_file(self):
        done = self.check()
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        count = sum(len(case["points"]) for case in self.said["cases"])
        self.assertGreater(count, 15000)
        self.assertIn(f"{count} points, 0 differences", done.stdout)

    # Promise: "The tests check this program ..."
    def test_every_map_and_texture_is_in_it(self):
        listed = subprocess.run([harness.program(), "maps"], check=True, capture_output=True, text=True).stdout
        maps = {line.split()[0] for line in listed.splitlines() if line and not line.startswith(" ")}
        self.assertEqual({case["map"] for case in self.cases.values()}, maps)
        shelf = subprocess.run([harness.program(), "versor", "list", "--json"], check=True, capture_output=True, text=True).stdout
        for texture in json.loads(shelf):
            self.assertEqual(self.cases[f"shape-modulus/{texture['name']}"]["recipe"]["texture"], texture["name"])

    # Promise: "The tests check this program ..."
    def test_the_points_keep_the_margin(self):
        for case in self.cases.values():
            with self.subTest(case=case["name"]):
                self.assertGreaterEqual(min(map(abs, case["F"])), self.said["margin"])
                self.assertGreaterEqual(len(case["points"]), 150)
                inside = sum(F < 0 for F in case["F"])
                self.assertTrue(0.2 < inside / len(case["F"]) < 0.6)
                for name in ("F", "steps", "octaves", "exponents"):
                    self.assertEqual(len(case.get(name, case["points"])), len(case["points"]))

    # Promise: "The tests check this program ..."
    def test_a_changed_number_is_noticed(self):
        def sign(case):
            case["F"][3] *= -1

        def value(case):
            case["F"][case["F"].index(min(case["F"], key=abs))] += 1e-9

        def steps(case):
            case["steps"][-2] += 1

        def iterate(case):
            case["orbits"][0][0][1] += 1e-9

        def option(case):
            case["recipe"]["iterations"] = case["iterations"] = case["iterations"] - 1

        def octave(case):
            case["octaves"][0][0] += 1e-5

        def exponent(case):
            case["exponents"][0][0] += 1e-5

        changes = {"shape-modulus/rational-slice": (sign, "signs"), "shape-modulus/formula": (value, "F"),
                   "rational/fixed": (steps, "steps"), "quadratic/julia": (iterate, "iterates"), "mandelbulb/8-pole": (value, "F"),
                   "cross/D-4": (option, "steps"), "shape-modulus/coral": (octave, "given"), "shape-modulus/detail": (exponent, "given")}
        for name, (change, _) in changes.items():
            change(self.cases[name])
        done = self.changed(*(word for name in [*changes, "cross/D-5"] for word in ("--case", name)))
        self.assertEqual(done.returncode, 1, done.stderr)
        for name, (change, what) in changes.items():
            with self.subTest(case=name, change=change.__name__):
                self.assertIn(f"{name}: the program: {what} ", done.stdout)
                if what != "given":
                    self.assertIn(f"{name}: reference_maps.py: {what} ", done.stdout)
        self.assertNotIn("cross/D-5: ", done.stdout)

    # Promise: "The tests check this program ..."
    def test_another_version_is_refused(self):
        self.said["version"] += 1
        done = self.changed()
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("is not version", done.stderr)


if __name__ == "__main__":
    harness.main()

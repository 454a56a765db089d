# SPDX-License-Identifier: Apache-2.0
"""The history of the benchmarks says what has become slower, and nothing else."""

import json
import pathlib
import sys
import tempfile
import unittest
import xml.etree.ElementTree

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench"))
import history


def run(processor="A", **times):
    return {"date": "2026-11-25", "commit": "c", "processor": processor, "cpuSeconds": times}


class History(unittest.TestCase):

    def test_what_takes_longer_is_named(self):
        lines = history.slower([run(mesh=2.0, field=1.0, new=1.0), run(mesh=4.0, field=1.05, other=9.0)])
        self.assertEqual(len(lines), 1)
        self.assertIn("mesh: 4 CPU s, and 2 in c of 2026-11-25", lines[0])

    def test_only_the_last_run_on_the_same_processor_counts(self):
        self.assertEqual(history.slower([run("A", mesh=1.0), run("B", mesh=9.0)]), [])
        self.assertEqual(len(history.slower([run("A", mesh=1.0), run("B", mesh=9.0), run("A", mesh=2.0)])), 1)
        self.assertEqual(history.slower([run("A", mesh=1.0), run("A", mesh=2.0), run("A", mesh=2.1)]), [])
        self.assertEqual(history.slower([]), [])

    def test_runs_are_added_and_drawn(self):
        report = {"waits": [{"mesh": "bunny", "N": 100, "cpu": 1.5}, {"mesh": "bunny & co", "N": 800, "cpu": 20.0}],
                  "widths": [{"mesh": "bunny", "width": 3, "own": 0.5}]}
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "history.json"
            for count in (1, 2, 3):
                runs = history.add(path, history.entry(report, "A"))
                self.assertEqual(len(runs), count)
                self.assertEqual(json.loads(path.read_text()), runs)
        self.assertEqual(runs[0]["cpuSeconds"]["sdf bunny, half width 3"], 0.5)
        drawing = xml.etree.ElementTree.fromstring(history.plot(runs))
        curves = drawing.findall("{http://www.w3.org/2000/svg}polyline")
        self.assertEqual(len(curves), 3)
        for curve in curves:
            points = [tuple(map(float, p.split(","))) for p in curve.get("points").split()]
            self.assertEqual(len(points), 3)
            self.assertEqual(len({y for _, y in points}), 1, "the same time is as high")
            self.assertEqual(sorted(x for x, _ in points), [x for x, _ in points])

    def test_the_kept_history_can_be_read(self):
        runs = history.read(history.FILE)
        self.assertGreater(len(runs), 0)
        self.assertLess(0, min(t for r in runs for t in r["cpuSeconds"].values()))


if __name__ == "__main__":
    unittest.main()

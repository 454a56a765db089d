# SPDX-License-Identifier: Apache-2.0
"""Counts that 32 bits do not hold are exact wherever they are added up, and what a format cannot count is refused. No
task here makes so much: the tests rewrite what finished tasks have recorded."""

import hashlib
import json
import random
import re
import struct

import harness
from harness import BAD_DATA, USAGE

TILES = 5
OPTIONS = (harness.BUNNY, "--tiles", TILES, "--resolution", 24, "--sdf-resolution", 30)
# Where 32 bits end, with a sign and without one, and where doubles do not hold every whole number.
TOTALS = [total for end in (1 << 31, 1 << 32, 1 << 53) for total in (end - 1, end, end + 1)] + [10_480_000_000]


class LargeCounts(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.random = random.Random(7)

    def made(self, makes):
        self.ok("plan", "tiles", *OPTIONS, "-o", "farm", "--make", makes)
        self.ok("task", "farm", "--range", f"1-{TILES}")

    def rewrite(self, task, name, data, **counts):
        """Gives a finished task another file, and a record that fits it."""
        self.write(f"farm/{name}", data)
        car = json.loads(self.bytes(f"farm/tasks/{task:04}.json"))
        file, = (file for file in car["files"] if file["name"] == name)
        file.update(bytes=len(data), sha256=hashlib.sha256(data).hexdigest(),
                    modified=self.path(f"farm/{name}").stat().st_mtime_ns)
        car["counts"].update(counts)
        self.write(f"farm/tasks/{task:04}.json", json.dumps(car))

    def record(self, task, points, triangles, **counts):
        """A task of a plan that counts has made so much."""
        name = f"tiles/{task:04}.json"
        made = json.loads(self.bytes(f"farm/{name}"))
        made.update(points=points, triangles=triangles)
        made.setdefault("box", [0, 0, 0, 1, 1, 1])
        self.rewrite(task, name, json.dumps(made).encode(), points=points, triangles=triangles, **counts)

    def shares(self, total, tasks=TILES):
        """Random parts of a number, none of which is 0."""
        cuts = sorted(self.random.sample(range(1, total), tasks - 1))
        return [end - begin for begin, end in zip([0, *cuts], [*cuts, total])]

    # Promise of farm.md: "Counts have 64 bits everywhere: in the records of tasks, in sums, in messages and in JSON", and
    #   `status` "adds up exactly what the finished tasks have made"
    # Promise: `status` counts "triangles, or evaluated ..."
    def test_sums_are_exact(self):
        self.made("count")
        for total in TOTALS:
            with self.subTest(total):
                triangles, points = self.shares(total), self.shares(total // 2)
                crumbs, nodes = self.shares(total + 2), self.shares(total + 3)
                for i in range(TILES):
                    self.record(i + 1, points[i], triangles[i], crumbs=crumbs[i], crumbNodes=nodes[i])
                self.assertIn(f"\ntriangles: {total}\n", self.ok("status", "farm", data=True))
                end = json.loads(self.ok("merge", "farm", "--counts", "c.json", "--progress", "json").splitlines()[-1])
                self.assertEqual(end["counts"]["triangles"], total)
                self.assertEqual(end["counts"]["crumbs"], total + 2)
                said, = end["messages"]
                self.assertIn(f" {total} triangles, {total + 2} crumbs of {total + 3} voxels dropped", said)
                whole = json.loads(self.bytes("c.json"))
                self.assertEqual((whole["points"], whole["triangles"]), (total // 2, total))

    # Promise: "Counts have 64 bits everywhere: in the records ..."
    def test_what_is_to_come_is_told_in_fitting_units(self):
        self.made("count")
        self.path(f"farm/tasks/{TILES:04}.json").unlink()
        for total, to_go in ((1 << 32, "1.07 billion"), (3_999_000_000_000, "1 trillion"), (40_000_000, "10 million"),
                             (8_000, "2000")):
            for i, triangles in enumerate(self.shares(total, TILES - 1)):
                self.record(i + 1, 1, triangles)
            self.assertIn(f"\ntriangles: {total} so far, about {to_go} to go\n", self.ok("status", "farm", data=True))

    # Promise: "Counts have 64 bits everywhere: in the records ..."
    def test_what_64_bits_do_not_hold_is_refused(self):
        self.made("count")
        for i in range(TILES):
            self.record(i + 1, 1, 1 << 62)
        for words in (("status", "farm"), ("merge", "farm", "--counts", "c.json")):
            self.refused(BAD_DATA, *words, mentions="too large to be added up")
        # What a record cannot hold, or is no count, is no record.
        for count in (1 << 64, -1, 2.5, "7"):
            self.record(2, 1, 1)
            car = json.loads(self.bytes("farm/tasks/0002.json"))
            car["counts"]["triangles"] = count
            self.write("farm/tasks/0002.json", json.dumps(car))
            self.assertEqual(self.ok("status", "farm", "--missing", data=True), "2\n")
        self.assertFalse(self.path("c.json").exists())

    def test_an_estimate_is_that_of_its_records(self):
        said = self.ok("plan", "tiles", *OPTIONS, "-o", "farm", "--make", "count", "--estimate", "--sample", TILES)
        made = sum(json.loads(self.bytes(f"farm/tasks/{i:04}.json"))["counts"]["triangles"] for i in range(1, TILES + 1))
        self.assertIn(f"{made / 1000:.3g} thousand", said)
        self.assertIn(f"\ntriangles: {made}\n", self.ok("status", "farm", data=True))

    def test_a_task_counts_those_that_it_made(self):
        self.ok("plan", "tiles", *OPTIONS, "-o", "farm", "--make", "count")
        self.ok("task", "farm", "--index", 2)
        end = json.loads(self.ok("task", "farm", "--range", f"1-{TILES}", "--progress", "json").splitlines()[-1])
        self.assertEqual(end["counts"], {"madeTasks": TILES - 1, "keptTasks": 1})

    def head(self, task, points, guests, triangles):
        """Lets a tile say in its head that it has so many."""
        name = f"tiles/{task:04}.tile"
        data = bytearray(self.bytes(f"farm/{name}"))
        self.assertEqual(data[:8], b"JVDBTILE")
        data[16:40] = struct.pack("<3Q", points, guests, triangles)
        self.rewrite(task, name, bytes(data))

    # Promise of farm.md: "`merge` refuses a mesh that does not fit before it writes anything"
    def test_a_mesh_that_its_format_cannot_count_is_refused_before_it_is_written(self):
        self.made("stl")
        others = sum(struct.unpack("<Q", self.bytes(f"farm/tiles/{i:04}.tile")[32:40])[0] for i in range(2, TILES + 1))
        self.head(1, 1000, 0, (1 << 32) - others)
        self.refused(USAGE, "merge", "farm", "--mesh", "x.stl", mentions=f"{1 << 32} triangles")
        self.refused(USAGE, "merge", "farm", "--mesh", "x.glb", mentions="4 GiB")
        # One triangle less is as many as an STL counts. The tiles themselves hold what they did.
        self.head(1, 1000, 0, (1 << 32) - others - 1)
        self.ok("merge", "farm", "--mesh", "x.stl")
        # A PLY of a tile has no more points than many readers count.
        self.head(1, 1 << 31, 0, 2000)
        self.refused(BAD_DATA, "merge", "farm", "--index", "x.json", mentions=f"tile 1 has {1 << 31} points")
        self.head(1, (1 << 31) - 8, 8, 2000)
        self.refused(BAD_DATA, "merge", "farm", "--index", "x.json", mentions=f"tile 1 has {1 << 31} points")
        self.head(1, (1 << 31) - 9, 8, 2000)
        self.ok("merge", "farm", "--index", "x.json")
        # More points than 64 bits count are no tiles.
        for i in (1, 2):
            self.head(i, 1 << 63, 0, 1)
        self.refused(BAD_DATA, "merge", "farm", "--mesh", "y.ply", mentions="too large to be added up")
        self.assertEqual(sorted(name for name in self.listing() if "/" not in name and name[0] in "xy"
                                and not re.fullmatch(r"x\.0+\d\.ply", name)), ["x.json", "x.stl"])


if __name__ == "__main__":
    harness.main()

# SPDX-License-Identifier: Apache-2.0
"""reproduce/run kd20-ten-billion on a tiny plan: what the record holds, how calls go on from each other, and what they refuse."""
import contextlib
import json
import os
import pathlib
import random
import re
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import unittest

from shell import PROGRAM, run as run_in_shell

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "reproduce"))
import ten_billion

COMMAND = [sys.executable, ROOT / "reproduce/run", "kd20-ten-billion"]
ENVIRONMENT = {**os.environ, "JULIAVDB": str(PROGRAM)}


class SmallRecord(unittest.TestCase):
    """A record that two calls made, and copies of it."""

    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.into = pathlib.Path(temporary.name) / "results"
        cls.whole = cls.into / "kd20-ten-billion"
        cls.first = cls.call("--resume", "--tasks", 5, "--jobs", 2)
        cls.after_first = (cls.whole / "tasks.tsv").read_bytes()
        cls.second = cls.call("--resume", "--jobs", 1)

    @classmethod
    def call(cls, *words):
        return subprocess.run([*COMMAND, *map(str, words), "--small", "--into", cls.into], capture_output=True, text=True,
                              env=ENVIRONMENT)

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_test_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def copy(self, change=lambda text: text):
        """@return a copy of the whole record, with other text in its file of tasks"""
        record = self.folder / "record"
        shutil.copytree(self.whole, record)
        (record / "tasks.tsv").write_text(change((record / "tasks.tsv").read_text()))
        return record

    @staticmethod
    def made(record):
        """Of each task what it counted."""
        return {task: one.counted for task, one in ten_billion.Record(record).made.items()}

    # Promise of scale.md: "`--resume` makes the plan in a folder that it removes afterwards, and then the tasks that have no line yet"
    def test_two_calls_make_each_task_once(self):
        self.assertEqual((self.first.returncode, self.second.returncode), (0, 0), self.first.stderr + self.second.stderr)
        self.assertIn("5 of 12 tasks are made", self.first.stdout)
        self.assertIn("12 of 12 tasks are made", self.second.stdout)
        text = (self.whole / "tasks.tsv").read_bytes()
        self.assertTrue(text.startswith(self.after_first))
        self.assertEqual(self.after_first.count(b"\n"), 1 + 5)
        self.assertEqual(sorted(int(line.split(b"\t")[0]) for line in text.splitlines()[1:]), list(range(1, 13)))
        # Both calls are of one program on one machine, and neither leaves its plan.
        self.assertEqual(len((self.whole / "makers.tsv").read_text().splitlines()), 2)
        self.assertEqual([path.name for path in self.into.iterdir() if path.is_dir()].count("kd20-ten-billion"), 1)
        self.assertEqual(list(self.into.glob(".kd20*")), [])

    def test_the_sum_is_that_of_the_program(self):
        bunny, = self.into.glob(".meshes/small/coarse-bunny.obj")
        shutil.copy(bunny, self.folder / "bunny.obj")
        recipe = json.loads((self.whole / "recipe.json").read_text())
        options = re.fullmatch(r"juliavdb plan tiles bunny\.obj -o ten (.*) --tiles 12 --make count", recipe["command"]).group(1)
        done = run_in_shell(f"{recipe['command']}; juliavdb task ten --range 1-12; juliavdb merge ten --counts counts.json; "
                            f"juliavdb fractal bunny.obj --mesh whole.ply {options}", self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        merged = json.loads((self.folder / "counts.json").read_text())
        made = self.made(self.whole).values()
        self.assertEqual([sum(one[i] for one in made) for i in (0, 1)], [merged["triangles"], merged["points"]])
        self.assertIn(f"SHA-256 of the hashes of all tiles: {merged['sha256']}\n", self.second.stdout)
        box = re.search(r"points, the box (.*)", self.second.stdout).group(1)
        for ours, theirs in zip(box.split(), merged["box"], strict=True):
            self.assertAlmostEqual(float(ours), theirs, delta=1e-5 * abs(theirs))
        head = (self.folder / "whole.ply").read_bytes().partition(b"end_header")[0].decode()
        self.assertEqual(int(re.search(r"element face (\d+)", head).group(1)), merged["triangles"])

    def test_what_was_made_is_the_same_when_made_again(self):
        done = self.call("--verify", 4, "--seed", 7)
        self.assertEqual((done.returncode, done.stdout.split(" as in")[0]), (0, "4 of 4 tasks are the same"), done.stderr)
        again = self.call("--verify", 4, "--seed", 7)
        names = [sorted(re.findall(r"task (\d+) is the same", said)) for said in (done.stderr, again.stderr)]
        self.assertEqual(names[0], names[1])
        self.assertEqual(len(set(names[0])), 4)

    def test_one_changed_hash_is_found(self):
        hash_of_7 = self.made(self.whole)[7][3]
        wrong = hash_of_7[::-1]
        record = self.copy(lambda text: text.replace(hash_of_7, wrong))
        done = self.call("--record", record, "--verify", 12)
        self.assertEqual(done.returncode, 1)
        self.assertIn("11 of 12 tasks are the same", done.stdout)
        line, = (line for line in done.stderr.splitlines() if "and the hash" in line)
        for word in ("task 7 ", hash_of_7, wrong):
            self.assertIn(word, line)

    # Promise of scale.md: "If one of them has another hash, it stops and names the task and both hashes"
    def test_a_program_that_makes_something_else_does_not_go_on(self):
        changed = self.copy(lambda text: re.sub(r"[0-9a-f]{64}", lambda match: match.group()[::-1],
                                                "".join(text.splitlines(True)[:-2])))
        before = (changed / "tasks.tsv").read_bytes()
        done = self.call("--record", changed, "--resume")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr.splitlines()[-1], r"task \d+ has .*[0-9a-f]{64}.*[0-9a-f]{64}.*--record FOLDER")
        self.assertEqual((changed / "tasks.tsv").read_bytes(), before)

    def test_another_mesh_does_not_go_on(self):
        bunny = self.folder / "other.obj"
        bunny.write_text(next(self.into.glob(".meshes/small/coarse-bunny.obj")).read_text() + "# changed\n")
        record = self.copy()
        for words in (("--resume",), ("--verify", 1)):
            done = self.call("--record", record, "--mesh", f"bunny={bunny}", *words)
            self.assertEqual(done.returncode, 1)
            self.assertIn("'bunny.obj' is '", done.stderr.splitlines()[-1])

    def test_a_torn_last_line_is_dropped_and_made_again(self):
        record = self.copy(lambda text: text[:-30])
        said = self.call("--record", record).stdout
        self.assertIn("11 of 12 tasks are made", said)
        self.assertIn("has no end and is not counted", said)
        self.assertEqual(self.call("--record", record, "--verify", 1).returncode, 0)
        done = self.call("--record", record, "--resume")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"the last line of {record / 'tasks.tsv'} has no end; it is dropped", done.stderr)
        self.assertEqual(self.made(record), self.made(self.whole))

    def test_lines_that_cannot_be_are_refused(self):
        lines = (self.whole / "tasks.tsv").read_text().splitlines(True)
        for row, broken in ((14, lines + lines[3:4]), (5, lines[:4] + ["7\n"] + lines[4:]),
                            (3, [*lines[:2], "9" + lines[2], *lines[3:]]),
                            (3, [*lines[:2], lines[2].replace("\t", "\t-", 1), *lines[3:]])):
            record = self.copy(lambda text: "".join(broken))
            for words in ((), ("--resume",), ("--verify", 1)):
                done = self.call("--record", record, *words)
                self.assertEqual((done.returncode, len(done.stderr.splitlines())), (1, 1), done.stderr)
                self.assertIn(f"line {row} of {record / 'tasks.tsv'} is broken", done.stderr)
            shutil.rmtree(record)

    # Promise of scale.md: "an interruption loses only the tasks that were being made"
    def test_an_interrupted_call_loses_only_what_it_was_making(self):
        record = self.folder / "record"
        words = ["--small", "--into", self.folder / "results", "--record", record, "--resume", "--jobs", "1"]
        process = subprocess.Popen([*COMMAND, *words], env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for line in process.stderr:
            if "[2/12]" in line:
                # A task that somebody has stopped ends with the call, too. Before it is the program, the call waits for it.
                for child in pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split():
                    with contextlib.suppress(OSError):
                        if pathlib.Path(f"/proc/{child}/exe").resolve() == PROGRAM.resolve():
                            os.kill(int(child), signal.SIGSTOP)
                process.send_signal(signal.SIGTERM)
                break
        said, last = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 75)
        self.assertEqual(last.splitlines()[-1], "reproduce/run: interrupted; run it again to go on")
        self.assertRegex(said, r"^\d+ of 12 tasks are made")
        kept = (record / "tasks.tsv").read_bytes()
        self.assertIn(kept.count(b"\n") - 1, (2, 3, 4))
        self.assertTrue(kept.endswith(b"\n"))
        self.assertEqual(list((self.folder / "results").glob(".kd20*")), [])
        self.assertEqual(self.call("--record", record, "--resume").returncode, 0)
        self.assertTrue((record / "tasks.tsv").read_bytes().startswith(kept))
        self.assertEqual(self.made(record), self.made(self.whole))

    def test_a_failed_task_is_named(self):
        done = self.call("--record", self.folder / "record", "--resume", "--mesh", f"bunny={self.folder / 'nothing.obj'}")
        self.assertEqual((done.returncode, len(done.stderr.splitlines())), (1, 1), done.stderr)
        self.assertIn("nothing.obj", done.stderr)

    def test_words_that_do_not_go_together(self):
        for words, mention in ((("--tasks", 3), "--resume"), (("--verify", "0"), "whole number"),
                               (("--resume", "--jobs", "x"), "'x'"),
                               (("--resume", "--again"), "--again"), (("kd20-table-1",), "without other entries")):
            done = self.call(*words)
            self.assertEqual((done.returncode, len(done.stderr.splitlines())), (2, 1), done.stderr)
            self.assertIn(mention, done.stderr)


class Estimates(unittest.TestCase):
    def test_intervals_hold_the_sum_as_often_as_they_say(self):
        """Of tasks as uneven as those of the plan, drawn at random."""
        draw = random.Random(5)
        tasks = [draw.lognormvariate(15, 0.6) for _ in range(1000)]
        for count in (30, 300):
            held = 0
            for _ in range(600):
                _, low, high = ten_billion.estimated(draw.sample(tasks, count), len(tasks))
                held += low <= sum(tasks) <= high
            self.assertTrue(0.9 < held / 600 < 0.98, (count, held))

    def test_the_quantiles_of_student(self):
        for degrees, quantile in ((9, 2.2622), (30, 2.0423), (1000, 1.9623)):
            self.assertAlmostEqual(ten_billion.students_t(degrees), quantile, delta=2e-3)

    # Promise of scale.md: "Those that are made are therefore a random sample of all"
    def test_the_first_tasks_are_spread_over_the_plan(self):
        """As a random sample is: a mean of 100 numbers up to 3200 has a standard deviation of 92."""
        order = ten_billion.shuffled(range(1, 3201), ten_billion.SHUFFLE)
        self.assertEqual(sorted(order), list(range(1, 3201)))
        for first in range(0, 3200, 100):
            self.assertAlmostEqual(statistics.fmean(order[first:first + 100]), 1600.5, delta=4 * 92)


class StoredRecord(unittest.TestCase):
    """reproduce/data/ten-billion, and the pages that speak of it."""

    @classmethod
    def setUpClass(cls):
        cls.record = ten_billion.Record(ten_billion.RECORD)

    def test_it_is_whole(self):
        self.assertFalse(self.record.torn)
        self.assertEqual(sorted(self.record.made), list(range(1, 3201)))
        self.assertEqual(self.record.tasks, 3200)

    def test_its_recipe_is_that_of_the_page(self):
        page = re.sub(r" \\\n +", " ", (ROOT / "docs/scale.md").read_text())
        self.assertIn(self.record.recipe["command"] + "\n", page)

    # Promise of README.md: "Two cores made this bunny of 13.7 billion triangles in 5.2 hours of CPU time"
    def test_the_pages_say_what_it_holds(self):
        made = self.record.made.values()
        triangles, hours = sum(one.triangles for one in made), sum(one.cpu for one in made) / 3600
        readme, page = ((ROOT / name).read_text() for name in ("README.md", "docs/scale.md"))
        billions = f"{triangles / 1e9:.1f} billion"
        self.assertIn(f"Two cores made this bunny of {billions} triangles in {hours:.1f} hours of CPU time", readme)
        self.assertIn(f"![A bunny of {billions} triangles", readme)
        self.assertIn(f"| {ten_billion.grouped(triangles)} |", page)
        # What the command says of it.
        for line in ten_billion.summary(self.record):
            self.assertIn(line + "\n", page)


if __name__ == "__main__":
    unittest.main()

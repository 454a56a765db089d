#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The checks that take hours go on where they were stopped, and tell what they found. Short commands stand in for the pieces."""
import importlib.machinery
import importlib.util
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import pieces  # noqa: E402

# A program like tests/long/check, of the pieces that a file lists.
PROGRAM = """
import argparse, json, pathlib, sys
sys.path.insert(0, sys.argv.pop(1))
import pieces
root = pathlib.Path(sys.argv.pop(1))
pieces.SLICE = 0.1
def listed(whole):
    made = [pieces.Piece(name, [["sh", "-c", script]], basis=basis, goal=goal) for name, script, basis, goal in
            json.loads((root.parent / "pieces.json").read_text())]
    return [piece for piece in made if whole or piece.basis]
parser = argparse.ArgumentParser()
pieces.add_options(parser)
options = parser.parse_args()
check = pieces.Check("trial", "trials", "tests", listed, "here")
pieces.guarded(lambda: pieces.work([check], options, root), "trial")
"""


class Trial(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.root = self.folder / "tree"
        self.root.mkdir()
        (self.root / "file").write_text("first")
        (self.root / ".gitignore").write_text("/build/\n")
        self.git("init", "-q")
        self.commit()
        self.state = self.root / "build/trial/state.json"

    def git(self, *words):
        subprocess.run(["git", "-c", "user.name=n", "-c", "user.email=n@example.org", "-C", self.root, *words], check=True)

    def commit(self):
        self.git("add", "-A")
        self.git("commit", "-q", "-m", "x")

    def put(self, **scripts):
        """Pieces of these names. Each also tells that it ran."""
        self.put_all([[name, script, False, 0] for name, script in scripts.items()])

    def put_all(self, listed):
        told = [[name, f"echo {name} >> '{self.folder}/ran'\n{script}", basis, goal] for name, script, basis, goal in listed]
        (self.folder / "pieces.json").write_text(json.dumps(told))

    def words(self, *words):
        """One piece at a time, unless the words say otherwise."""
        folders = [str(HERE), str(self.root), "--into", str(self.root / "build")]
        return [sys.executable, "-c", PROGRAM, *folders, "--jobs", "1", *words]

    def run_it(self, *words, code=0):
        done = subprocess.run(self.words(*words), capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def ran(self):
        """The names of the pieces that ran since this was asked last."""
        path = self.folder / "ran"
        names = path.read_text().split() if path.exists() else []
        path.unlink(missing_ok=True)
        return names

    def begin(self, name, *words):
        """Starts the program. @return it, when it is at a piece"""
        process = subprocess.Popen(self.words(*words), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        path = self.folder / "ran"
        while not path.exists() or name not in path.read_text().split():
            self.assertIsNone(process.poll())
            time.sleep(0.02)
        return process


class Stopping(Trial):
    # Promise of reliability.md: "the same command goes on where an earlier one was stopped"
    def test_it_goes_on_where_it_was_stopped(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(number):
                self.put(first="", second=f"sleep 600 & echo $! > '{self.folder}/child'; wait", third="")
                process = self.begin("second")
                while not (self.folder / "child").exists() or not (self.folder / "child").read_text():
                    time.sleep(0.02)
                process.send_signal(number)
                said, _ = process.communicate()
                self.assertEqual(process.returncode, 75, said)
                self.assertIn("stopped in the middle of 'second'", said)
                child = pathlib.Path("/proc") / (self.folder / "child").read_text().strip()
                runs_on = child.exists() and "\nState:\tZ" not in (child / "status").read_text()
                self.assertFalse(runs_on, "what it has started is not ended")
                self.put(first="", second="", third="")
                self.run_it()
                self.assertEqual(self.ran(), ["first", "second", "second", "third"])
                (self.folder / "child").unlink()
                self.state.unlink()

    # Promise: "the same command goes on where ..."
    def test_a_killed_one_loses_one_piece(self):
        self.put(first="", second="sleep 3 & wait", third="")
        process = self.begin("second")
        process.kill()
        process.communicate()
        self.put(first="", second="", third="")
        self.run_it()
        self.assertEqual(self.ran(), ["first", "second", "second", "third"])

    def test_it_stops_when_its_time_is_over(self):
        self.put(first="sleep 600")
        said = self.run_it("--minutes", "0.01", code=75).stdout
        self.assertIn("stopped", said)
        self.assertFalse(self.state.exists())

    def test_two_at_once(self):
        self.put(first="sleep 600")
        process = self.begin("first")
        said = self.run_it(code=75).stderr
        self.assertIn("another run is at work", said)
        process.terminate()
        process.communicate()
        self.assertEqual(self.ran(), ["first"])


class AtOnce(Trial):
    def meeting(self, name, other):
        """A command that ends with 0 only if the other one runs beside it."""
        return (f"touch '{self.folder}/{name}'; "
                f"for i in $(seq 600); do [ -e '{self.folder}/{other}' ] && exit 0; sleep 0.05; done; exit 1")

    def alone(self):
        """A command that takes a place which only one can have at a time, and so fails beside another one."""
        return f"mkdir '{self.folder}/place' || exit 1; sleep 0.2; rmdir '{self.folder}/place'"

    # Promise of reliability.md: "It runs as many at once as there are processors, or as `--jobs` says"
    def test_two_pieces_run_at_once(self):
        self.put(first=self.meeting("a", "b"), second=self.meeting("b", "a"), third="")
        self.assertIn("3 of 3 tests passed", self.run_it("--jobs", "2").stdout)
        runs = json.loads(self.state.read_text())["pieces"]
        self.assertEqual(sorted(self.ran()), sorted(runs))
        for words in ("0", "-1", "two"):
            self.run_it("--jobs", words, code=2)

    def test_no_more_than_it_is_told(self):
        self.put(**dict.fromkeys(("first", "second", "third"), self.alone()))
        self.run_it("--jobs", "1")

    def test_nothing_runs_beside_what_others_stand_on(self):
        first = f"[ ! -e '{self.folder}/place' ]"
        self.put_all([["fetch", self.alone(), True, 0], ["build", self.alone(), True, 0], ["first", first, False, 0]])
        self.run_it("--jobs", "4")
        self.assertEqual(self.ran(), ["fetch", "build", "first"])

    # Promise: "the same command goes on where ..."
    def test_all_that_run_are_stopped(self):
        self.put(first="sleep 600 & wait", second="sleep 600 & wait", third="")
        process = self.begin("second", "--jobs", "2")
        process.terminate()
        said, _ = process.communicate()
        self.assertEqual(process.returncode, 75, said)
        self.assertRegex(said, "stopped in the middle of '(first' and 'second|second' and 'first)', which begin anew")
        self.assertFalse(self.state.exists())

    def test_the_cpu_time_of_each(self):
        busy = f"{sys.executable} -c 'import time\nwhile time.process_time() < 0.5: pass'"
        self.put(busy=busy, idle=f"while ! grep -q busy '{self.folder}/ran'; do sleep 0.1; done; sleep 1")
        self.run_it("--jobs", "2")
        runs = json.loads(self.state.read_text())["pieces"]
        self.assertGreaterEqual(runs["busy"][0]["cpu"], 0.5)
        self.assertLess(runs["idle"][0]["cpu"], 0.4)


class Results(Trial):
    def test_each_piece_has_a_log_of_its_own(self):
        self.put(**{"a b": "echo one", "a_b": "echo two", "a/b": "echo three"})
        self.run_it()
        runs = json.loads(self.state.read_text())["pieces"]
        self.assertEqual([(self.root / runs[name][0]["log"]).read_text().splitlines()[-1] for name in ("a b", "a_b", "a/b")],
                         ["one", "two", "three"])

    # Promise of reliability.md: "The exit code is 0 if all pieces of the check have passed, 1 if one failed"
    def test_a_piece_that_fails(self):
        self.put(first="", second="echo it broke; exit 3", third="")
        said = self.run_it(code=1).stdout
        self.assertEqual(self.ran(), ["first", "second", "third"])
        log = re.search(r"FAILED second: (\S+)", said).group(1)
        self.assertIn("it broke", (self.root / log).read_text())
        self.assertIn("2 of 3 tests passed, 1 failed", said)
        # What is known is told again, and only repeated on demand.
        self.assertIn("FAILED second", self.run_it(code=1).stdout)
        self.assertEqual(self.ran(), [])
        self.put(first="", second="", third="")
        self.assertIn("3 of 3 tests passed", self.run_it("--again").stdout)
        self.assertEqual(self.ran(), ["second"])

    def test_only_some(self):
        self.put(first="", second="exit 1", third="")
        self.run_it("--only", "^(first|third)$")
        self.assertEqual(self.ran(), ["first", "third"])
        self.assertIn("2 of 3 tests passed, 1 not yet run to the end", self.run_it("--status").stdout)
        self.run_it("--only", "(", code=2)

    # Promise of reliability.md: "Results of another commit, of a tree with changes that are not committed, or of another compiler
    #   are kept and marked as such"
    def test_of_another_commit(self):
        self.put(first="", second="")
        self.run_it()
        self.ran()
        (self.root / "file").write_text("second")
        said = self.run_it("--status").stdout
        self.assertIn("with changes that are not committed", said)
        self.assertIn("2 of them on another tree", said)
        self.commit()
        said = self.run_it("--status").stdout
        self.assertNotIn("with changes", said)
        self.assertIn("2 of them on another tree", said)
        self.assertEqual(self.run_it("--list").stdout.count("(not this tree or system)"), 2)
        self.run_it()
        self.assertEqual(self.ran(), [])
        self.run_it("--again", "--only", "first")
        self.assertEqual(self.ran(), ["first"])
        self.assertIn("1 of them on another tree", self.run_it("--status").stdout)

    # Promise of reliability.md: "A commit that changes only pages makes no other tree"
    def test_pages_change_nothing(self):
        self.put(first="")
        self.run_it()
        page = self.root / "docs/page.md"
        page.parent.mkdir()
        page.write_text("words")
        for commit in (lambda: None, self.commit):
            commit()
            said = self.run_it("--status").stdout
            self.assertNotIn("another tree", said)
            self.assertNotIn("not committed", said)
        page.with_suffix(".png").write_text("a picture")
        self.commit()
        self.assertIn("1 of them on another tree", self.run_it("--status").stdout)

    # Promise: "Results of another commit, ..."
    def test_that_of_a_changed_tree_says_so(self):
        self.put(first="")
        (self.root / "file").write_text("second")
        self.assertIn("changes that are not committed", self.run_it().stdout)
        self.assertIn("+changes", self.run_it("--table").stdout)

    def test_of_a_copy_without_git(self):
        self.put(first="")
        shutil.rmtree(self.root / ".git")
        with unittest.mock.patch.dict(os.environ, {"JULIAVDB_COMMIT": "abcd1234"}):
            self.run_it()
            self.assertNotIn("another tree", self.run_it("--status").stdout)
        self.assertIn("another tree", self.run_it("--status").stdout)
        self.assertIn("| `abcd1234` |", self.run_it("--table").stdout)

    def test_what_others_stand_on(self):
        self.put_all([["build", "exit 1", True, 0], ["first", "", False, 0], ["second", "", False, 0]])
        self.assertIn("nothing can be run before 'build' passes", self.run_it(code=1).stdout)
        self.assertEqual(self.ran(), ["build"])
        self.assertIn("known when 'build' has passed", self.run_it("--list").stdout)
        self.put_all([["build", "", True, 0], ["first", "", False, 0], ["second", "", False, 0]])
        self.run_it()
        self.assertEqual(self.ran(), ["build", "first", "second"])
        # A tree that changes on the way is built again before anything else runs in it.
        self.put_all([["build", "", True, 0], ["third", f"echo x > '{self.root}/file'", False, 0], ["fourth", "", False, 0]])
        self.run_it()
        self.assertEqual(self.ran(), ["build", "third", "build", "fourth"])

    def test_a_time_made_of_parts(self):
        self.put_all([["first", "sleep 0.2", False, 0.5], ["second", "sleep 0.2", False, 0.5]])
        self.run_it()
        ran = self.ran()
        self.assertEqual(ran[:2], ["first", "second"])
        self.assertGreater(len(ran), 2)
        for name, runs in json.loads(self.state.read_text())["pieces"].items():
            self.assertEqual(len(runs), ran.count(name))
            self.assertGreaterEqual(sum(run["seconds"] for run in runs), 0.5)
        self.run_it()
        self.assertEqual(self.ran(), [])

    def test_the_table(self):
        self.put(first="", second="exit 1", third="")
        self.assertIn("| trials | nothing was run |", self.run_it("--table").stdout)
        self.run_it("--only", "first|second", code=1)
        row = [cell.strip() for cell in self.run_it("--table").stdout.splitlines()[-1].strip("|").split("|")]
        commit = subprocess.run(["git", "-C", self.root, "rev-parse", "HEAD"], capture_output=True, text=True).stdout
        self.assertEqual(row[:2], ["trials (here)", "1 of 3 tests passed, 1 failed, 1 not yet run to the end"])
        self.assertTrue(commit.startswith(row[2].strip("`")))
        self.assertRegex(row[3], r"^\d{4}-\d\d-\d\d")
        self.assertEqual(row[4], "`second`")


class StateFile(Trial):
    def test_one_that_is_not_whole_is_refused(self):
        self.put(first="", second="")
        self.run_it("--only", "first")
        text = self.state.read_text()
        for size in range(len(text.rstrip())):
            self.state.write_text(text[:size])
            with self.assertRaises(pieces.Refused):
                pieces.State(self.state.parent)
        self.state.write_text(text)
        self.assertEqual(set(pieces.State(self.state.parent).runs), {"first"})

    def test_the_refusal_is_one_line_and_changes_nothing(self):
        self.put(first="", second="")
        self.run_it()
        whole = self.state.read_text()
        self.ran()
        for text in (whole[:60], "", "[]", whole.replace(pieces.FORMAT, "long check 99"), whole.replace('"seconds"', '"second"')):
            self.state.write_text(text)
            for words in ((), ("--status",), ("--again",)):
                done = self.run_it(*words, code=65)
                self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
                self.assertIn(f"{self.state} holds no results of a check", done.stderr)
                self.assertEqual(self.state.read_text(), text)
        self.assertEqual(self.ran(), [])


def load_check():
    loader = importlib.machinery.SourceFileLoader("check", str(HERE / "check"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("check", loader))
    loader.exec_module(module)
    return module


class TheScript(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.check = load_check()

    def test_tests_of_a_preset(self):
        """By a ctest that stands in: what is not built is left out, and every name runs its own test and no other."""
        names = ["cli_faults", "A.b", "A.bc", "AxB", "Ball/1.in[2](3)|$+^?"]
        listed = {"tests": [{"name": name, "command": ["x"]} for name in names] + [{"name": "vdbtools_tests_NOT_BUILT"}]}
        fake = self.folder / "ctest"
        fake.write_text(f"#!/bin/sh\ncat <<'END'\n{json.dumps(listed)}\nEND\n")
        fake.chmod(0o755)
        before = os.environ["PATH"]
        self.addCleanup(os.environ.__setitem__, "PATH", before)
        os.environ["PATH"] = f"{self.folder}:{before}"
        made = list(self.check.tests_of("asan"))
        self.assertEqual([piece.name for piece in made], names)
        for piece in made:
            words = piece.commands[0]
            pattern = words[words.index("-R") + 1]
            self.assertEqual([name for name in names if re.search(pattern, name)], [piece.name])
        fake.write_text("#!/bin/sh\necho no presets >&2; exit 1\n")
        with self.assertRaisesRegex(pieces.Refused, "no presets"):
            list(self.check.tests_of("asan"))

    def test_a_test_that_ctest_skips(self):
        log = self.folder / "log"
        log.write_text("1/1 Test #57: formatted ...........***Skipped   0.01 sec\n")
        self.assertEqual(self.check.judge_test(log, 0)[0], pieces.SKIPPED)
        log.write_text("1/1 Test #57: formatted ...........   Passed   0.01 sec\n")
        self.assertEqual(self.check.judge_test(log, 0)[0], pieces.PASSED)

    def test_a_harness(self):
        """It fails by what it finds now, not by what was found before, and if it does not run."""
        log, artifacts = self.folder / "log", self.folder / "artifacts/ply"
        artifacts.mkdir(parents=True)
        judge = self.check.judge_harness("ply", self.folder)
        head = "harness           executions      cov   corpus  finds\n"
        log.write_text(head + "ply                  2179579     6953      712      0\n")
        self.assertEqual(judge(log, time.time()), (pieces.PASSED, {"executions": 2179579, "finds": 0}))
        (artifacts / "crash-1").write_text("x")
        self.assertEqual(judge(log, time.time() + 60), (pieces.PASSED, {"executions": 2179579, "finds": 0}))
        self.assertEqual(judge(log, time.time() - 60), (pieces.FAILED, {"executions": 2179579, "finds": 1}))
        self.assertIn("crash-1", log.read_text())
        log.write_text(head + "ply                        -        -        -      0\n")
        self.assertEqual(judge(log, time.time() + 60)[0], pieces.FAILED)

    def test_fuzzers(self):
        """By a fuzzer that stands in: one harness finds nothing and takes turns until the time is over, one finds a file, and one
        does not start."""
        root = self.folder / "tree"
        for name in ("tests/long", "tests/fuzz/dict"):
            shutil.copytree(HERE.parents[1] / name, root / name)
        shutil.copy(HERE.parent / "fuzz/run-all", root / "tests/fuzz/run-all")
        programs = {
            "bin/cmake": "exit 0",
            "build/fuzz/tests/fuzz/fuzz_replay": 'mkdir -p "$2/ply"',
            "build/fuzz/tests/fuzz/fuzz": """case $0 in
              *_ply) echo '#900: cov: 70 ft: 90 corp: 12 exec/s 9' >&2 ;;
              *_obj) for word; do case $word in -artifact_prefix=*) echo x > "${word#*=}crash-1" ;; esac; done
                echo '#300: cov: 50 ft: 90 corp: 10 exec/s 9' >&2 ;;
              *_off) exit 1 ;;
              *) echo call this program by one of these names: fuzz_ply fuzz_obj fuzz_off >&2; exit 2 ;;
            esac"""}
        for name, text in programs.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text("#!/bin/sh\n" + text)
            (root / name).chmod(0o755)
        path = f"{root / 'bin'}:{os.environ['PATH']}"
        words = [root / "tests/long/check", "fuzzers"]
        process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                   env={**os.environ, "PATH": path})
        state, runs = root / "build/fuzzers/state.json", {}
        while not {"obj", "off"} <= set(runs) or len(runs.get("ply", ())) < 3:
            self.assertIsNone(process.poll())
            time.sleep(0.05)
            runs = json.loads(state.read_text())["pieces"] if state.exists() else {}
        process.terminate()
        said, _ = process.communicate()
        self.assertEqual(process.returncode, 75, said)
        runs = json.loads(state.read_text())["pieces"]
        for run in runs["ply"]:
            self.assertEqual((run["outcome"], run["executions"], run["finds"]), (pieces.PASSED, 900, 0))
        self.assertEqual([(run["outcome"], run["executions"], run["finds"]) for run in runs["obj"]], [(pieces.FAILED, 300, 1)])
        self.assertEqual([run["outcome"] for run in runs["off"]], [pieces.FAILED])
        self.assertIn("artifacts/obj/crash-1", (root / runs["obj"][0]["log"]).read_text())
        row = subprocess.run([*words, "--table"], capture_output=True, text=True).stdout.splitlines()[-1]
        self.assertIn("0 of 3 harnesses passed, 2 failed, 1 not yet run to the end", row)
        self.assertIn("| `obj`, `off` |", row)

    def test_pictures_that_are_compared_are_pieces(self):
        if "JULIAVDB" not in os.environ:
            self.skipTest("JULIAVDB names no program")
        done = subprocess.run([HERE / "check", "pictures", "--list", "--into", self.folder], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        known = subprocess.run([HERE.parents[1] / "docs/check-pictures", "--list"], capture_output=True, text=True).stdout
        compared = known.partition("compared:\n")[2].partition("not compared:")[0].split()
        self.assertGreater(len(compared), 40)
        self.assertEqual([line.split()[1] for line in done.stdout.splitlines()], ["--list", *compared])

    def test_every_check_tells_what_it_would_do(self):
        """Also where nothing is built, and nothing can be."""
        done = subprocess.run([HERE / "check", "all", "--table", "--into", self.folder], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(done.stdout.splitlines()), 2 + len(self.check.CHECKS))


if __name__ == "__main__":
    unittest.main()

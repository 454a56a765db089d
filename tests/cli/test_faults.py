# SPDX-License-Identifier: Apache-2.0
"""Faults of the system under every command: disks that are full or broken, calls that are interrupted, no descriptors.

Each fault is made by tests/faults/shim.cpp, whose path JULIAVDB_FAULT_SHIM names, or by the way in which the program is
started. The calls of a command are counted first, and then each of them fails in turn. Of many, a few are taken;
JULIAVDB_FAULTS=all takes all, which takes a quarter of an hour, and JULIAVDB_FAULTS=STEP every STEP-th.
"""

import atexit
import collections
import contextlib
import errno
import functools
import hashlib
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import unittest

import harness
from harness import BAD_DATA, CANNOT_CREATE, DONE, INTERNAL, INTERRUPTED, IO_ERROR, NO_INPUT

KINDS = ("open", "create", "read", "write", "fsync", "rename", "close", "unlink", "mkdir", "stat", "random", "alloc")
LOW = ("--resolution", 16, "--sdf-resolution", 16, "--threads", 2)

# What each writes, and how. Names that end in / are folders that are made by the command or hold what it makes.
COMMANDS = {
    "sdf": ("sdf", "s.obj", "-o", "x.vdb", "--resolution", 16),
    "fractal": ("fractal", "s.obj", "-o", "x.vdb", "--mesh", "x.ply", *LOW),
    "fractal of a VDB": ("fractal", "s.vdb", "--mesh", "x.obj", "--resolution", 16, "--threads", 2),
    "fractal as STL": ("fractal", "s.obj", "--mesh", "x.stl", *LOW),
    "fractal as GLB": ("fractal", "s.obj", "--mesh", "x.glb", "--lod", "100%,50%", "--colour", "direction", *LOW),
    "fractal of a recipe": ("fractal", "--config", "f.vdb", "-o", "x.vdb"),
    "fractal by a list": ("fractal", "s.obj", "--config", "options.txt", "-o", "x.vdb"),
    "fractal of a versor": ("fractal", "s.obj", "-o", "x.vdb", "--texture", "v.json", *LOW),
    "fractal of a picture": ("fractal", "s.obj", "-o", "x.vdb", "--colour", "depth:ramp.exr", *LOW),
    "sequence": ("fractal", "s.obj", "-o", "x.####.vdb", "--frames", "1-2", "--key", "detail@1=0.1", *LOW),
    "mesh": ("mesh", "f.vdb", "-o", "x.ply", "--from-grid"),
    "points": ("points", "f.vdb", "-o", "x.ply", "--points", 50, "--from-grid"),
    "points as VDB": ("points", "s.obj", "-o", "x.vdb", "--points", 50),
    "print": ("print", "s.obj", "-o", "x.3mf", "--size", 20, "--resolution", 20),
    "print as STL": ("print", "s.obj", "-o", "x.stl", "--size", 20, "--resolution", 20),
    "fit": ("fit", "s.obj", "-o", "x.json", "--report", "x.csv", "--plot", "x.svg", "--roots", 4, "--resolution", 12,
            "--triangles", 100),
    "versor": ("versor", "add", "v.json", "v.json", "-o", "x.json"),
    "sheet": ("sheet", "s.obj", "-o", "x.png", "--vary", "detail=0.1,0.3", "--size", "16x16", "--samples", 1,
              "--sdf-resolution", 16),
    "slice": ("slice", "s.vdb", "-o", "x.png", "--size", 16),
    "study": ("study", "s.obj", "-o", "x.png", "--curve", "x.svg", "--csv", "x.csv", "--versors", 2, "--size", 16,
              "--sdf-resolution", 16),
    "render": ("render", "s.vdb", "-o", "x.exr", "--size", "16x16", "--samples", 1),
    "convert": ("convert", "f.vdb", "-o", "x.nvdb"),
    "usd": ("usd", "f.vdb", "-o", "x.usda", "--mesh", "f.ply"),
    "plan tiles": ("plan", "tiles", "s.obj", "-o", "x", "--tiles", 2, *LOW),
    "plan frames": ("plan", "frames", "s.obj", "-o", "x", "--frames", "1-2", "--key", "detail@1=0.1", "--key",
                    "detail@2=0.2", *LOW),
    "task": ("task", "plan", "--range", "1-1"),
    "merge": ("merge", "done", "-o", "x.vdb", "--mesh", "x.ply"),
    "man": ("man", "-o", "x"),
}
# Commands that say something else: to whom their data goes is tested apart.
TO_STDOUT = (("maps", "--markdown"), ("info", "f.vdb"), ("info", "n.obj", "--json"), ("versor", "list"),
             ("completion",), ("fractal", "--help", "all"), ("--version",), ("status", "done"))


@functools.cache
def inputs():
    """A folder with what the commands read."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_test_"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    (folder / "s.obj").write_text(harness.obj(harness.sphere(2)))
    (folder / "n.obj").write_text(harness.obj(harness.needle()))
    (folder / "options.txt").write_text("resolution = 16\nsdf-resolution = 16\ndetail = 0.3\n")

    def run(*words):
        subprocess.run([harness.program(), *map(str, words)], cwd=folder, env=harness.environment(), check=True,
                       stdin=subprocess.DEVNULL, stderr=subprocess.PIPE)

    run("sdf", "s.obj", "-o", "s.vdb", "--resolution", 16)
    run("fractal", "s.obj", "-o", "f.vdb", "--mesh", "f.ply", *LOW)
    run("versor", "new", "-o", "v.json", "--roots", 3)
    run("slice", "s.obj", "-o", "ramp.exr", "--size", 16, "--sdf-resolution", 16)
    run("plan", "tiles", "s.obj", "-o", "plan", "--tiles", 2, "--make", "vdb,ply", *LOW)
    shutil.copytree(folder / "plan", folder / "done")
    run("task", "done", "--range", "1-2")
    return folder


def contents(folder):
    """Of each file its bytes' hash; of each folder None."""
    found = {}
    for path in folder.rglob("*"):
        if path.is_symlink():
            continue
        found[str(path.relative_to(folder))] = None if path.is_dir() else hashlib.sha1(path.read_bytes()).hexdigest()
    return found


# What differs from run to run: when and how long, and who.
# A task that failed says so in a file.
UNSTEADY = re.compile(r"\.json$|x\.csv$")


class FaultTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.shim = os.environ.get("JULIAVDB_FAULT_SHIM")
        if not cls.shim:
            raise unittest.SkipTest("JULIAVDB_FAULT_SHIM does not name the library that makes calls fail")
        every = os.environ.get("JULIAVDB_FAULTS", "")
        cls.step = 1 if every == "all" else int(every or 0)
        cls.codes = collections.Counter()

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_test_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.place = self.folder / "work"
        self.counts = self.folder / "counts"

    def run_in(self, words, fault=None, place=None, **options):
        """Runs the program in a folder that holds the inputs."""
        env = {"LD_PRELOAD": self.shim, "FAULT_PATH": str(place or self.place), "FAULT_COUNTS": str(self.counts)}
        if fault:
            env["FAULT"] = fault
        self.counts.write_bytes(bytes(8 * len(KINDS)))
        words = [str(word) for word in words]
        if words[0] in harness.COMMANDS:
            words[1:1] = ["--progress", "none"]
        elif words[0] == "plan":
            words[2:2] = ["--progress", "none"]
        options = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
        return subprocess.run([harness.program(), *words], cwd=place or self.place, env=harness.environment(env),
                              timeout=harness.TIMEOUT, **options)

    def fresh(self, old=()):
        shutil.rmtree(self.place, ignore_errors=True)
        shutil.copytree(inputs(), self.place)
        for name in old:
            (self.place / name).write_text("precious")
        return contents(self.place)

    def model(self, name):
        """What a run without faults leaves behind, and how often it makes the calls."""
        before = self.fresh()
        run = self.run_in(COMMANDS[name])
        self.assertEqual(run.returncode, DONE, run.stderr.decode())
        after = contents(self.place)
        counts = dict(zip(KINDS, struct.unpack(f"<{len(KINDS)}Q", self.counts.read_bytes())))
        return before, after, counts

    def check(self, name, fault, run, before, after, codes):
        """The laws of a fault."""
        stderr = run.stderr.decode(errors="replace") if run.stderr is not None else None
        drawn = set()
        if stderr and re.search(r"(?m)^warning: cell \d+ failed: ", stderr):  # the sheet shows its error instead, by design
            drawn.add("x.png")
        with self.subTest(command=name, fault=fault):
            self.codes[run.returncode] += 1
            self.assertIn(run.returncode, codes, stderr)
            left = contents(self.place)
            wrong = {path for path, content in left.items() if content not in (before.get(path, ""), after.get(path, ""))}
            wrong |= {path for path in before if path not in left}
            wrong -= drawn
            wrong = {path for path in wrong
                     if not (path in after and UNSTEADY.search(path)) and not path.endswith(".failed.json")}
            self.assertEqual(wrong, set(), f"exit code {run.returncode}: half written, changed or left behind\n{stderr}")
            self.assertEqual([path for path in left if path.endswith(".tmp")], [])
            if run.returncode == DONE:
                self.assertEqual(set(left) | {path for path in after if drawn and path.startswith("x.cells/")},
                                 set(after), stderr)
                self.assertNotRegex(stderr, r"(?m)^juliavdb: ")
            elif stderr is not None:
                self.assertRegex(stderr, r"\A(wrote [^\n]*\n)*juliavdb: [^\n]*\S\n\Z", "not one line for one failure")
                if not fault.startswith("crash:"):
                    self.assertNotIn(harness.CRASHED, stderr)

    def places(self, count, most):
        """Which of so many calls fail: the first, the last and a few between, or as many as were asked for."""
        if self.step:
            return range(1, count + 1, self.step)
        if count <= most:
            return range(1, count + 1)
        return sorted({1 + round(i * (count - 1) / (most - 1)) for i in range(most)}) if most > 1 else [count]

    def sweep(self, kind, errors, codes, most=1, names=COMMANDS, suffix=""):
        for name in sorted(names):
            before, after, counts = self.model(name)
            for at in self.places(counts[kind], most):
                for error in errors:
                    fault = f"{kind}:{at}{suffix}:{error}"
                    self.fresh()
                    self.check(name, fault, self.run_in(COMMANDS[name], fault), before, after, codes)

    OF_PLANS = {"merge", "task"}

    def sampled(self, *names):
        return set(COMMANDS if self.step else names)

    # ------------------------------------------------------------------------------------------------ calls that fail

    # Promise of reliability.md: Files are never half written: "Outputs are whole, or they are not there, or they are what they
    #   were before"
    def test_writing(self):
        self.sweep("write", [errno.ENOSPC, errno.EIO] if self.step else [errno.ENOSPC], {IO_ERROR},
                   names=self.sampled("fractal", "sheet", "plan tiles", "task", "print", "points as VDB"))

    # Promise: Files are never half written: "Outputs ..."
    def test_flushing(self):
        self.sweep("fsync", [errno.EIO], {IO_ERROR}, most=2,
                   names=self.sampled("fractal", "sequence", "fit", "merge"))
        if not self.step:
            self.sweep("fsync", [errno.EIO], {IO_ERROR}, most=4, names=("task",))

    # Promise: Files are never half written: "Outputs ..."
    def test_renaming(self):
        self.sweep("rename", [errno.EIO], {IO_ERROR}, most=2, names=self.sampled("fractal", "fit", "task", "study"))

    def test_closing(self):
        self.sweep("close", [errno.EIO], {DONE, IO_ERROR}, names=self.sampled("fractal", "render"))

    def test_creating(self):
        """Files without a name, of which not every file system knows, have others in their place."""
        self.sweep("create", [errno.ENOSPC, errno.EROFS] if self.step else [errno.ENOSPC], {CANNOT_CREATE, IO_ERROR, DONE},
                   most=2, names=self.sampled("fractal as GLB", "sheet", "plan frames", "sequence", "study"))

    def test_making_folders(self):
        self.sweep("mkdir", [errno.ENOSPC], {CANNOT_CREATE}, names=("plan tiles", "plan frames", "man"))

    def test_reading(self):
        """What is read on the way to see whether a task is done, or whether a process lives, may be made anew. The input
        that a recipe names may be read once more, after it was looked for in other places, too."""
        self.sweep("read", [errno.EIO], {IO_ERROR}, most=2, names=self.sampled(
            "sdf", "fractal of a VDB", "fractal by a list", "fractal of a picture", "usd") - self.OF_PLANS - {"fractal of a recipe"})
        self.sweep("read", [errno.EIO], {IO_ERROR, DONE}, most=2, names=("fractal of a recipe",))
        self.sweep("read", [errno.EIO], {IO_ERROR, BAD_DATA, DONE}, most=2, names=self.OF_PLANS)

    def test_opening(self):
        self.sweep("open", [errno.EMFILE], {NO_INPUT, IO_ERROR, CANNOT_CREATE, BAD_DATA, DONE},
                   most=2,
                   names=self.sampled("fractal of a recipe", "task", "mesh"))

    def sudden(self, fault, text):
        """Something that ends the program beside its work, while it flushes a file: as other failures do, and its
        temporary files go with it."""
        for name in sorted(self.sampled("fractal", "sheet", "task")):
            before, after, counts = self.model(name)
            for at in self.places(counts["fsync"], 2):
                self.fresh()
                whole = fault.format(at)
                run = self.run_in(COMMANDS[name], whole)
                self.check(name, whole, run, before, after, {INTERNAL})
                self.assertIn(f"juliavdb: internal error: {text}", run.stderr.decode())

    # Promise: "No temporary file stays behind"
    def test_exceptions_that_nobody_catches(self):
        self.sudden("throw:{}:0", "thrown by the shim\n")

    # Promise of reliability.md: "No temporary file stays behind"
    # Promise of reliability.md: "A crash, of the program or of a library, ends with 70 and one line that names the signal"
    def test_crashes(self):
        for number, text in ((signal.SIGSEGV, "Segmentation fault"), (signal.SIGABRT, "Aborted")):
            self.sudden(f"crash:{{}}:{number:d}", f"the program crashed ({text}); ")

    # Promise of reliability.md: "What an interruption reports is true; when every file is in place, the code is 0"
    def test_an_interruption_while_a_file_is_flushed(self):
        """Once all files are in their places there is nothing left to interrupt; before, what is told is true."""
        for name in sorted(self.sampled("fractal", "man", "merge", "plan tiles", "sequence", "task")):
            before, after, counts = self.model(name)
            for at in self.places(counts["fsync"], 2):
                fault = f"stop:{at}:{signal.SIGINT:d}"
                self.fresh()
                run = self.run_in(COMMANDS[name], fault, preexec_fn=harness.restore_interrupt)
                self.check(name, fault, run, before, after, {DONE, INTERRUPTED})
                with self.subTest(command=name, fault=fault):
                    left, said = contents(self.place), run.stderr.decode()
                    self.assertEqual(run.returncode == DONE, set(left) == set(after), said)
                    if run.returncode == INTERRUPTED:
                        self.assertIn("juliavdb: interrupted; ", said)
                    if "nothing was written" in said:
                        files = {path: content for path, content in left.items() if content}
                        self.assertEqual(files, {path: content for path, content in before.items() if content})

    # -------------------------------------------------------------------------------------- what nobody should notice

    def unnoticed(self, faults, names):
        for name in names:
            before, after, _ = self.model(name)
            for fault in faults:
                self.fresh()
                self.check(name, fault, self.run_in(COMMANDS[name], fault), before, after, {DONE})

    # Promise of reliability.md: Interrupted calls, short writes, a clock that jumps, closed streams and 10 000 open files "change
    #   nothing"
    def test_interrupted_calls(self):
        again = [f"{kind}:*:{errno.EINTR}" for kind in ("open", "create", "read", "write", "fsync", "close")]
        self.unnoticed(again, self.sampled("fractal of a picture", "fractal of a recipe", "merge"))

    # Promise: Interrupted calls, short writes, a clock ...
    def test_short_writes(self):
        self.unnoticed(["short:*:0"], self.sampled("fractal as STL", "points"))

    # Promise: Interrupted calls, short writes, a clock ...
    def test_clock_jumps(self):
        self.unnoticed(["clock:*:0"], self.sampled("fractal", "task", "sequence"))

    # Promise: Interrupted calls, short writes, a clock ...
    def test_no_random_numbers(self):
        self.unnoticed([f"random:1+:{errno.ENOSYS}"], self.sampled("sdf"))

    # --------------------------------------------------------------------------------------------------- a full disk

    # Promise: Files are never half written: "Outputs ..."
    def test_a_disk_that_fills_up(self):
        for name in self.sampled("fractal", "fit", "man", "merge", "render"):
            before, after, _ = self.model(name)
            new = [self.place / path for path in after if after[path] != before.get(path)]
            size = sum(path.stat().st_size for path in new if path.is_file())
            for share in (0, 0.01, 0.5, 0.99) if self.step else (0, 0.6):
                fault = f"bytes:{int(share * size)}:{errno.ENOSPC}"
                self.fresh()
                self.check(name, fault, self.run_in(COMMANDS[name], fault), before, after, {IO_ERROR})

    # Promise: Files are never half written: "Outputs ..."
    def test_an_old_file_stays(self):
        before = self.fresh(old=["x.vdb", "x.ply"])
        for fault in (f"write:1:{errno.ENOSPC}", f"fsync:2:{errno.EIO}", f"rename:1+:{errno.EIO}"):
            self.check("fractal", fault, self.run_in(COMMANDS["fractal"], fault), before, before, {IO_ERROR})

    # ------------------------------------------------------------------------------------------- how it was started

    # Promise: "A reader that closes the pipe ..."
    def test_no_reader(self):
        """Data on stdout is an output like any other."""
        self.fresh()
        for words in TO_STDOUT:
            with self.subTest(words=words):
                with open("/dev/full", "w") as full:
                    run = self.run_in(words, stdout=full)
                self.assertEqual(run.returncode, IO_ERROR, run.stderr.decode())
                self.assertRegex(run.stderr.decode(), r"\Ajuliavdb: [^\n]*standard output[^\n]*\n\Z")
                run = self.run_in(words, preexec_fn=lambda: os.close(1))
                self.assertEqual(run.returncode, IO_ERROR, run.stderr.decode())
                if "--help" in words:  # of which a reader has had enough at any time
                    continue
                reader, writer = os.pipe()
                os.close(reader)
                run = self.run_in(words, stdout=writer)
                os.close(writer)
                self.assertEqual(run.returncode, IO_ERROR, run.stderr.decode())

    # Promise: Interrupted calls, short writes, a clock ...
    def test_closed_descriptors(self):
        """Neither input, nor output, nor errors, which a file must not take the place of."""
        for name in self.sampled("fractal", "render", "task"):
            before, after, _ = self.model(name)
            for closed in ((0,), (1,), (2,), (0, 1, 2)):
                self.fresh()
                run = self.run_in(COMMANDS[name], preexec_fn=lambda: [os.close(number) for number in closed])
                self.check(name, f"closed {closed}", run, before, after, {DONE})

    def test_few_descriptors(self):
        for name in self.sampled("fractal", "render", "merge"):
            before, after, _ = self.model(name)
            for most in range(4, 24) if self.step else (5, 8, 12):
                self.fresh()
                run = self.limited(name, most)
                if run.returncode == 127:  # the libraries could not be opened
                    continue
                self.check(name, f"{most} descriptors", run, before, after,
                           {DONE, NO_INPUT, CANNOT_CREATE, IO_ERROR, BAD_DATA})

    def limited(self, name, most):
        return self.run_in(COMMANDS[name],
                           preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (most, most)))

    # Promise: Interrupted calls, short writes, a clock ...
    def test_many_descriptors(self):
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        count = min(hard, 11000) - 100
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 11000), hard))
        self.addCleanup(resource.setrlimit, resource.RLIMIT_NOFILE, (soft, hard))
        before, after, _ = self.model("fractal")
        self.fresh()
        with contextlib.ExitStack() as stack:
            files = [stack.enter_context(open("/dev/null")).fileno() for _ in range(count)]
            run = self.run_in(COMMANDS["fractal"], pass_fds=files)
        self.check("fractal", "10000 descriptors", run, before, after, {DONE})

    # ------------------------------------------------------------------------------------------------- odd places

    def refused(self, code, words, mentions=""):
        before = contents(self.place)
        run = self.run_in(words)
        text = run.stderr.decode()
        self.assertEqual(run.returncode, code, text)
        self.assertRegex(text, r"\Ajuliavdb: [^\n]*\S\n\Z")
        self.assertIn(mentions, text)
        self.assertEqual(contents(self.place), before)

    def test_places_that_cannot_be_written(self):
        self.fresh()
        (self.place / "loop.vdb").symlink_to("loop.vdb")
        (self.place / "a.vdb").symlink_to("b.vdb")
        (self.place / "b.vdb").symlink_to("a.vdb")
        (self.place / "file").write_text("no folder")
        for name in ("loop.vdb", "a.vdb", "file/x.vdb", "/proc/x.vdb", "/sys/kernel/x.vdb", "nowhere/x.vdb",
                     "x" * 300 + ".vdb", "/dev/null/x.vdb"):
            with self.subTest(name=name[:20]):
                words = ("sdf", "s.obj", "-o", name, "--resolution", 16)
                run = self.run_in(words)
                self.assertEqual(run.returncode, CANNOT_CREATE, run.stderr.decode())
                self.assertRegex(run.stderr.decode(), r"\Ajuliavdb: [^\n]*\S\n\Z")
        for words in (("plan", "tiles", "s.obj", "-o", "file/x"), ("man", "-o", "file/x"), ("man", "-o", "/proc/x"),
                      ("plan", "frames", "s.obj", "-o", "/proc/x", "--frames", "1-2", "--key", "detail@1=0.1", "--key",
                       "detail@2=0.2")):
            with self.subTest(words=words):
                self.refused(CANNOT_CREATE, words)

    def test_a_folder_that_disappears(self):
        """While the file is being made: the program says so, and the folder does not come back."""
        self.fresh()
        gone = self.place / "gone"
        gone.mkdir()
        process = subprocess.Popen(
            [harness.program(), "fractal", "s.obj", "-o", "gone/x.vdb", "--progress", "json", "--resolution", "80",
             "--sdf-resolution", "80"], cwd=self.place, env=harness.environment(), stdin=subprocess.DEVNULL,
            stderr=subprocess.PIPE, text=True)
        with process:
            for line in process.stderr:
                if json.loads(line).get("file"):
                    break
            shutil.rmtree(gone)
            rest = process.stderr.read()
        self.assertEqual(process.returncode, IO_ERROR, rest)
        self.assertIn("x.vdb", json.loads(rest.splitlines()[-1])["error"])
        self.assertFalse(gone.exists())

    @classmethod
    def tearDownClass(cls):
        if cls.step:
            print("faults by exit code:", dict(cls.codes), file=sys.stderr)


if __name__ == "__main__":
    harness.main()

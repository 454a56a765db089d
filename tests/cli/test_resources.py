# SPDX-License-Identifier: Apache-2.0
"""Memory: what does not fit is refused before it begins, and where it runs out nothing is written.

JULIAVDB_FAULTS=all sweeps limits and allocations closely, which takes an hour.
"""

import errno
import itertools
import os
import re
import resource
import signal
import subprocess
import unittest

import pyopenvdb

import harness
from harness import BAD_DATA, DONE, INTERNAL, USAGE

MIB = 1 << 20
EVERY = os.environ.get("JULIAVDB_FAULTS") == "all"

QUICK = ("--sdf-resolution", 16)

# Each fails of its size alone, at once.
ABSURD = (
    ("sdf", "s.obj", "-o", "x.vdb", "--resolution", 1000000),
    ("sdf", "s.obj", "-o", "x.vdb", "--voxel-size", 2e-5),
    ("sdf", "s.obj", "-o", "x.vdb", "--resolution", 9000),
    ("sdf", "s.obj", "-o", "x.vdb", "--resolution", 1000, "--band", 1000000),
    ("sdf", "s.obj", "-o", "x.vdb", "--thicken", 0.1, "--resolution", 100000),
    ("sdf", "s.obj", "-o", "x.vdb", "--points-radius", 0.1, "--resolution", 100000),
    ("fractal", "s.obj", "-o", "x.vdb", "--resolution", 1000000000, *QUICK),
    ("fractal", "s.obj", "-o", "x.vdb", "--resolution", 100000, *QUICK),
    ("fractal", "s.obj", "--mesh", "x.ply", "--resolution", 100000, *QUICK),
    ("fractal", "s.obj", "-o", "x.vdb", "--resolution", 100000, "--exhaustive", *QUICK),
    ("fractal", "s.obj", "-o", "x.vdb", "--sdf-resolution", 100000),
    ("fractal", "--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", "-o", "x.vdb", "--resolution", 90000),
    ("fractal", "s.obj", "-o", "x.####.vdb", "--frames", "1-1000000000", *QUICK),
    ("fractal", "s.obj", "-o", "x.vdb", "--texture", "random", "--texture-roots", 10000000, *QUICK),
    ("fractal", "s.obj", "-o", "x.vdb", "--iterations", 1000000000, *QUICK),
    ("fit", "s.obj", "-o", "x.json", "--resolution", 1000000),
    ("fit", "s.obj", "-o", "x.json", "--roots", 10000000),
    ("points", "s.obj", "-o", "x.ply", "--points", 1000000000),
    ("points", "s.obj", "-o", "x.ply", "--spacing", 1e-9),
    ("print", "s.obj", "-o", "x.stl", "--size", 20, "--resolution", 1000000),
    ("render", "s.obj", "-o", "x.png", "--size", "1000000x1000000"),
    ("render", "s.obj", "-o", "x.png", "--size", "32768x32768"),
    ("slice", "s.obj", "-o", "x.png", "--size", 32768, *QUICK),
    ("sheet", "s.obj", "-o", "x.png", "--vary", "detail=0.1,0.2", "--size", 1000000),
    ("study", "s.obj", "-o", "x.png", "--versors", 1000000000),
    ("versor", "new", "-o", "x.json", "--roots", 1000000000000),
    ("plan", "tiles", "s.obj", "-o", "x", "--tiles", 1000000000),
    ("plan", "frames", "s.obj", "-o", "x", "--frames", "1-1000000000"),
    ("usd", "x.####.vdb", "-o", "x.usda", "--frames", "1-1000000000"),
)

# Runs whose size decides what they take, with the share of it that is known beforehand.
SIZED = {
    "sdf": (("sdf", "s.obj", "-o", "x.vdb", "--resolution", 400), 0.4),
    "wide sdf": (("sdf", "t.obj", "-o", "x.vdb", "--resolution", 300, "--band", 30), 0.4),
    "fractal": (("fractal", "s.obj", "-o", "x.vdb", "--sdf-resolution", 40, "--resolution", 200), 0.1),
    "picture": (("slice", "s.obj", "-o", "x.png", "--size", 1200, "--sdf-resolution", 20), 0.2),
}


def limited(kind, size):
    """For subprocess: with a limit of so many bytes, and no core file of what it breaks."""

    def set_limits():
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(kind, (size, size))

    return set_limits


class Resources(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(3)))
        self.write("t.obj", harness.obj(harness.torus()))
        self.inputs = {"s.obj", "t.obj"}

    def ends(self, run, codes, words, may_crash=False):
        """The laws: a code of those, one line, nothing left."""
        text = run.stderr.decode(errors="replace")
        self.assertIn(run.returncode, codes, f"{words}\n{text}")
        left = [name for name in self.listing() if name not in self.inputs]
        if run.returncode in (DONE, 127):  # the loader's own code, before the program begins
            for name in left:
                self.path(name).unlink()
            return run.returncode
        self.assertRegex(text, r"\Ajuliavdb: [^\n]*\S\n\Z", words)
        if not may_crash:
            self.assertNotIn(harness.CRASHED, text, words)
        self.assertEqual(left, [], words)
        return run.returncode

    # Promise of reliability.md: "Work that is known not to fit into the memory is refused with exit code 70, and with both
    #   figures and a way out"
    def test_absurd_sizes(self):
        for words in ABSURD:
            with self.subTest(words=words):
                begin = harness.ended_children()
                run = self.run_program(*harness.quiet(words), preexec_fn=limited(resource.RLIMIT_AS, 8000 * MIB))
                self.ends(run, {USAGE, BAD_DATA, INTERNAL}, words)
                self.assertLess(harness.ended_children() - begin, 30, "a refusal comes before the work")

    # Promise: "Work that is known not to fit ..."
    def test_a_refusal_says_the_figures_and_a_way_out(self):
        words = ("sdf", "s.obj", "-o", "x.vdb", "--resolution", 2500)
        line = r"at least [\d.]+ [MGT]iB of memory, but .* leaves [\d.]+ ([KMG]iB|bytes); use .*--resolution"
        for how in ({"env": {"JULIAVDB_MEMORY": "200M"}}, {"preexec_fn": limited(resource.RLIMIT_AS, 900 * MIB)},
                    {"preexec_fn": limited(resource.RLIMIT_DATA, 500 * MIB)}):
            with self.subTest(how=how):
                self.assertRegex(self.refused(INTERNAL, *words, **how), line)
        self.assertRegex(self.refused(INTERNAL, *words, "--memory", "200M"), line)
        self.assertRegex(self.refused(INTERNAL, "slice", "s.obj", "-o", "x.png", "--size", 8000, *QUICK,
                                      "--memory", "200M"),
                         "--size")

    # Promise: "Work that is known not to fit ..."
    def test_another_limit(self):
        words = ("sdf", "s.obj", "-o", "x.vdb", "--resolution", 300)
        small = {"JULIAVDB_MEMORY": "1M"}
        self.refused(INTERNAL, *words, env=small)
        self.ok(*words, "--memory", "unlimited", env=small)
        for text in ("", "0", "16", "-1G", "16GB", "nanG", "all"):
            self.refused(USAGE, *words, f"--memory={text}" if text else "--memory=", mentions="--memory")
        self.refused(USAGE, *words, env={"JULIAVDB_MEMORY": "much"}, mentions="JULIAVDB_MEMORY")

    # Promise: "Work that is known not to fit ..."
    def test_tiles_of_a_target(self):
        """A small file may hold any number of voxels in its tiles, which all take memory where they are needed."""
        grid = pyopenvdb.FloatGrid(1.0)
        grid.fill((0, 0, 0), (511, 511, 1023), -0.5)
        pyopenvdb.write(str(self.path("tiles.vdb")), grids=grid)
        self.assertLess(self.path("tiles.vdb").stat().st_size, 1 << 20)
        for words in (("fractal", "tiles.vdb", "-o", "x.vdb"), ("mesh", "--from-grid", "tiles.vdb", "-o", "x.ply")):
            text = self.refused(INTERNAL, *words, "--memory", "500M", mentions="tiles would take at least 1.0")
            self.assertIn("smaller file", text)

    # Promise: "Work that is known not to fit ..."
    def test_files_larger_than_the_memory(self):
        """They are refused before they are read. These have no blocks on the disk, and begin like what they are called."""
        readers = {"x.obj": ("info", "x.obj"), "x.ply": ("info", "x.ply"), "x.stl": ("sdf", "x.stl", "-o", "o.vdb"),
                   "x.off": ("info", "x.off"), "x.glb": ("info", "x.glb"), "x.gltf": ("info", "x.gltf"),
                   "x.vdb": ("fractal", "x.vdb", "-o", "o.vdb"), "x.json": ("info", "x.json"), "x.p4d": ("info", "x.p4d"),
                   "options.txt": ("fractal", "--config", "options.txt", "-o", "o.vdb"),
                   "ramp.png": ("fractal", "s.obj", "--colour", "depth:ramp.png", "-o", "o.vdb", *QUICK, "--resolution", 16)}
        beginnings = {"x.vdb": b" BDV\0\0\0\0", "x.ply": b"ply\nformat ascii 1.0\n", "ramp.png": b"\x89PNG\r\n\x1a\n"}
        for name, words in readers.items():
            with self.subTest(name):
                with open(self.path(name), "wb") as file:
                    file.write(beginnings.get(name, b" "))
                    file.truncate(1 << 40)
                begin = harness.ended_children()
                text = self.refused(INTERNAL, *harness.quiet(words), mentions="1 TiB of memory")
                self.assertIn("smaller file", text)
                self.assertLess(harness.ended_children() - begin, 30, "a refusal comes before the work")
                self.path(name).unlink()

    def peak(self, *words):
        """Of a run, and of the program by itself: the most memory that they had, bytes."""
        process = subprocess.Popen([harness.program(), *map(str, words)], cwd=self.folder, env=harness.environment(),
                                   stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(process.returncode, DONE, words)
        return usage.ru_maxrss * 1024

    # Promise of reliability.md: "a run that fits is not refused"
    def test_what_fits_is_not_refused(self):
        """The most that a run takes is enough for it; much less is not."""
        for name, (words, known) in SIZED.items():
            with self.subTest(name):
                base = self.peak("sdf", "s.obj", "-o", "x.vdb", "--resolution", 10)
                # What a run takes at most differs from run to run by about 1 %.
                peak = max(self.peak(*words) for _ in range(4))
                self.ok(*words, "--memory", f"{peak // 1024}K")
                self.path(words[3]).unlink()
                share = int(0.5 * base + known * (peak - base)) // 1024
                self.refused(INTERNAL, *words, "--memory", f"{share}K", mentions="at least")

    # Promise: "Where an allocation fails ..."
    def test_limits_of_every_size(self):
        """From what the program cannot even begin with to enough."""
        words = ("fractal", "s.obj", "-o", "x.vdb", "--mesh", "x.ply", "--resolution", 150, "--sdf-resolution", 40,
                 "--threads", 2, "--progress", "none")
        codes = set()
        for kind, step in ((resource.RLIMIT_AS, 4 if EVERY else 60), (resource.RLIMIT_DATA, 2 if EVERY else 40)):
            begun = False
            for size in range(20, 420, step):
                # Libraries start threads while they are loaded; where they cannot, main() is not reached.
                begun = begun or self.run_program("--version", preexec_fn=limited(kind, size * MIB)).returncode == DONE
                if not begun:
                    continue
                run = self.run_program(*words, preexec_fn=limited(kind, size * MIB))
                if run.returncode == -signal.SIGABRT and b"std::system_error" in run.stderr and self.listing() == ["s.obj", "t.obj"]:
                    continue  # as above: what else the machine does decides how little is enough for main()
                codes.add(self.ends(run, {DONE, 127, INTERNAL}, f"{kind} {size} MiB"))
        self.assertIn(INTERNAL, codes)
        self.assertIn(DONE, codes)

    # Promise: "Where an allocation fails ..."
    def test_limits_that_are_just_too_low(self):
        """What is short at the very end, when all is written, is no failure any more."""
        words = harness.quiet(("sdf", "s.obj", "-o", "x.vdb", "--resolution", 60, "--threads", 1))

        def limited_run(kilobytes):
            return self.run_program(*words, preexec_fn=limited(resource.RLIMIT_AS, kilobytes << 10))

        low, high = 20 << 10, 1000 << 10
        while high - low > 64:
            middle = (low + high) // 2
            low, high = (low, middle) if limited_run(middle).returncode == DONE else (middle, high)
        self.path("x.vdb").unlink()
        codes = {self.ends(limited_run(high - below), {DONE, INTERNAL}, f"{high - below} KiB")
                 for below in range(100, 8000, 80 if EVERY else 500)}
        self.assertIn(INTERNAL, codes)

    # Promise: "Where an allocation fails ..."
    def test_limits_where_pictures_are_read_and_written(self):
        """The libraries for pictures are many and large, and some of them crash where they do not fit."""
        self.ok("slice", "s.obj", "-o", "ramp.exr", "--size", 20, *QUICK)
        self.inputs.add("ramp.exr")
        jobs = (("fractal", "s.obj", "-o", "x.vdb", "--resolution", 8, *QUICK, "--colour", "depth:ramp.exr"),
                ("slice", "s.obj", "-o", "x.exr", "--size", 200, *QUICK))
        spans = ((resource.RLIMIT_AS, 200, 1400), (resource.RLIMIT_DATA, 60, 1400))
        for (kind, least, most), words in itertools.product(spans, jobs):
            codes, texts = set(), set()
            steps = 200 if EVERY else 7
            for i in range(steps + 1):
                size = round(least * (most / least)**(i / steps))
                run = self.run_program(*harness.quiet(words), "--threads", 4, preexec_fn=limited(kind, size * MIB))
                codes.add(self.ends(run, {DONE, 127, INTERNAL}, f"{words} {kind} {size} MiB"))
                texts.add(run.stderr.decode())
            self.assertEqual(codes & {DONE, INTERNAL}, {DONE, INTERNAL}, words)
            self.assertTrue(any(re.search(r"libraries need some [\d.]+ MiB, but .* leaves .*; raise that limit\n\Z", text)
                                for text in texts), texts)

    def shim(self):
        name = os.environ.get("JULIAVDB_FAULT_SHIM")
        if not name:
            self.skipTest("JULIAVDB_FAULT_SHIM does not name the library that makes calls fail")
        return name

    # Promise: "Where an allocation fails ..."
    def test_the_last_of_the_machine_is_not_taken(self):
        """A run that was let in ends before the system has to kill something."""
        meminfo = self.path("meminfo")
        env = {"LD_PRELOAD": self.shim(), "FAULT_MEMINFO": str(meminfo)}
        words = ("sdf", "s.obj", "-o", "x.vdb", "--memory", "unlimited", "--resolution")
        self.write("meminfo", "MemTotal: 16000000 kB\nMemAvailable: 10000 kB\n")
        text = self.refused(INTERNAL, *words, 1200, env=env)
        self.assertRegex(text, r"memory is running out: this run has taken [\d.]+ [MG]iB, and .* leaves 9\.\d+ MiB; nothing was written")
        # It is not to blame who has taken little.
        self.ok(*words, 40, env=env)

    def test_mappings_that_fail(self):
        """oneTBB waits for itself where memory fails while it starts; a run ends all the same."""
        words = harness.quiet(("sdf", "s.obj", "-o", "x.vdb", "--resolution", 20))
        for threads in (1, 2):
            codes = set()
            # The allocator of oneTBB maps pieces of a third of a MiB and more.
            for size in range(0, 12 * MIB, MIB // 4):
                env = {"LD_PRELOAD": self.shim(), "FAULT": f"space:{size}:{errno.ENOMEM}"}
                run = self.run_program(*words, "--threads", threads, env=env)
                codes.add(self.ends(run, {DONE, INTERNAL}, f"{threads} threads, {size} bytes"))
            self.assertEqual(codes, {DONE, INTERNAL})

    # Promise of reliability.md: "Where an allocation fails all the same, in whatever thread, the program exits with 70 and one
    #   line, and writes nothing"
    def test_allocations_that_fail(self):
        shim = self.shim()
        commands = (("fractal", "s.obj", "-o", "x.vdb", "--mesh", "x.glb", "--resolution", 24, "--sdf-resolution", 24),
                    ("slice", "s.obj", "-o", "x.png", "--size", 60, "--sdf-resolution", 24),
                    ("print", "s.obj", "-o", "x.3mf", "--size", 20, "--resolution", 24))
        counts = self.path("counts")
        self.write("counts", bytes(8 * 12))
        for words in commands:
            for least in (200, 2000, 20000) if EVERY else (2000,):
                for then in ("", "+"):
                    def run(number):
                        env = {"LD_PRELOAD": shim, "FAULT": f"alloc:{number}{then}:{least}", "FAULT_COUNTS": str(counts)}
                        return self.run_program(*words, "--threads", 2, "--progress", "none", env=env)

                    counts.write_bytes(bytes(8 * 12))
                    self.ends_ignoring_counts(run(10**9), {DONE}, words)
                    most = int.from_bytes(counts.read_bytes()[-8:], "little")
                    self.assertGreater(most, 50)
                    # Blosc makes one of every three near the end.
                    for number in range(1, most + 1, 4 if EVERY else max(1, most // 3)):
                        # A library that cannot load another, or cannot keep a font, may fail in its own words. Blosc does not
                        # look whether it was given its buffer.
                        self.ends_ignoring_counts(run(number), {DONE, 127, INTERNAL}, f"{words}: {number}{then} of {most}")

    def ends_ignoring_counts(self, run, codes, words):
        hidden = self.path("counts")
        content = hidden.read_bytes()
        hidden.unlink()
        self.ends(run, codes, words, may_crash=True)
        hidden.write_bytes(content)


if __name__ == "__main__":
    harness.main()

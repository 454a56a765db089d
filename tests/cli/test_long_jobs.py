# SPDX-License-Identifier: Apache-2.0
"""What a job that takes seconds shows: its threads, its progress."""

import json
import os
import re
import subprocess
import time
import unittest

import harness


class Threads(harness.CliTest):

    def most_threads(self, *arguments, env=None):
        """The largest number of threads that a run is seen with."""
        process = subprocess.Popen([harness.program(), *map(str, arguments)], cwd=self.folder,
                                   env=harness.environment(env), stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        most = 0
        while process.poll() is None and harness.cpu_seconds(process) < 1.2:
            try:
                with open(f"/proc/{process.pid}/status") as status:
                    most = max(most, int(re.search(r"Threads:\s+(\d+)", status.read())[1]))
            except (FileNotFoundError, ProcessLookupError, TypeError):
                pass
            time.sleep(0.02)
        process.kill()
        process.wait()
        return most

    # Promise of usage.md: "`--threads N` (or the variables `SLURM_CPUS_PER_TASK` and `SLURM_CPUS_ON_NODE`)" is honoured
    @unittest.skipIf(len(os.sched_getaffinity(0)) < 2, "one processor: every run has one thread")
    def test_the_number_of_threads_is_honoured(self):
        self.write("s.obj", harness.obj(harness.sphere(2)))
        job = ("fractal", "s.obj", "-o", "s.vdb", "--resolution", 400, "--alpha", 6, "--sdf-resolution", 32,
               "--progress", "none")
        one = self.most_threads(*job, "--threads", 1)
        self.assertEqual(self.most_threads(*job, "--threads", 2), one + 1)
        self.assertEqual(self.most_threads(*job, env={"SLURM_CPUS_PER_TASK": "1"}), one)
        self.assertEqual(self.most_threads(*job, "--threads", 2, env={"SLURM_CPUS_PER_TASK": "1"}), one + 1)


class ProgressLines(harness.CliTest):
    # Enough for many seconds on any machine: the run is stopped as soon as the lines are there.
    LONG = ("fractal", "s.obj", "-o", "s.vdb", "--resolution", 1000, "--alpha", 6, "--sdf-resolution", 32)

    def lines_of_long_job(self, *arguments, are_there):
        """@param are_there  called with the lines so far, a few times a second. @return all lines, and the seconds that passed"""
        self.write("s.obj", harness.obj(harness.sphere(2)))
        begun = time.monotonic()
        process = subprocess.Popen([harness.program(), *map(str, self.LONG + arguments)], cwd=self.folder,
                                   env=harness.environment(), stdin=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                   preexec_fn=harness.restore_interrupt)
        os.set_blocking(process.stderr.fileno(), False)
        error = b""
        while not are_there(error.decode().splitlines()):
            self.assertIsNone(process.poll(), "the job was to take long")
            self.assertLess(time.monotonic() - begun, harness.TIMEOUT, error)
            time.sleep(0.1)
            error += process.stderr.read() or b""
        os.set_blocking(process.stderr.fileno(), True)
        error += harness.stop(process)[1]
        self.assertEqual(process.returncode, harness.INTERRUPTED)
        return error.decode().splitlines(), time.monotonic() - begun

    def is_at_work(self, _):
        return any(name.endswith(".tmp") for name in self.listing())

    def test_json(self):
        count = lambda lines: sum('"event":"progress"' in line.replace(" ", "") for line in lines)
        lines, _ = self.lines_of_long_job("--progress", "json", are_there=lambda lines: count(lines) > 2)
        events = [json.loads(line) for line in lines]
        self.assertGreater(sum(event["event"] == "progress" for event in events), 1)
        elapsed = 0
        for event in events:
            self.assertGreater(event["elapsed"], elapsed)
            elapsed = event["elapsed"]
            if event["event"] == "progress":
                self.assertIsInstance(event["phase"], str)
            if "fraction" in event:
                self.assertTrue(0 <= event["fraction"] <= 1)

    def test_none(self):
        lines, _ = self.lines_of_long_job("--progress", "none", are_there=self.is_at_work)
        self.assertEqual(len(lines), 1, lines)

    def test_bar_in_a_log(self):
        (*lines, last), seconds = self.lines_of_long_job(are_there=lambda lines: lines)
        self.assertTrue(last.startswith("juliavdb: "), last)
        self.assertGreaterEqual(len(lines), 1)
        self.assertLessEqual(len(lines), 1 + seconds / 5, lines)  # a line each five seconds where stderr is no terminal
        self.assertNotIn("\r", lines[0])
        self.assertNotIn("\033", lines[0])


if __name__ == "__main__":
    harness.main()

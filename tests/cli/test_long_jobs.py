# SPDX-License-Identifier: Apache-2.0
"""What a job that takes seconds shows: its threads, its progress. Nothing else may want the processors meanwhile."""

import json
import os
import re
import signal
import subprocess
import time
import unittest

import harness


class Threads(harness.CliTest):

    def most_threads(self, *arguments, env=None):
        """The largest number of threads that a run is seen with."""
        process = subprocess.Popen([harness.program(), *map(str, arguments)], cwd=self.folder,
                                   env=harness.environment(env), stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        most, end = 0, time.monotonic() + 1.2
        while process.poll() is None and time.monotonic() < end:
            try:
                with open(f"/proc/{process.pid}/status") as status:
                    most = max(most, int(re.search(r"Threads:\s+(\d+)", status.read())[1]))
            except (FileNotFoundError, ProcessLookupError, TypeError):
                pass
            time.sleep(0.02)
        process.kill()
        process.wait()
        return most

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
    # Enough for three seconds or so on any machine: the run is stopped as soon as the lines are there.
    LONG = ("fractal", "s.obj", "-o", "s.vdb", "--resolution", 1000, "--alpha", 6, "--sdf-resolution", 32)

    def lines_of_long_job(self, *arguments, seconds):
        self.write("s.obj", harness.obj(harness.sphere(2)))
        process = subprocess.Popen([harness.program(), *map(str, self.LONG + arguments)], cwd=self.folder,
                                   env=harness.environment(), stdin=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                   preexec_fn=harness.restore_interrupt)
        try:
            process.wait(timeout=seconds)
            self.fail("the job was to take long")
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGINT)
        error = process.communicate(timeout=harness.TIMEOUT)[1].decode()
        self.assertEqual(process.returncode, harness.INTERRUPTED)
        return error.splitlines()

    def test_json(self):
        events = [json.loads(line) for line in self.lines_of_long_job("--progress", "json", seconds=4)]
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
        lines = self.lines_of_long_job("--progress", "none", seconds=3)
        self.assertEqual(len(lines), 1, lines)

    def test_bar_in_a_log(self):
        *lines, last = self.lines_of_long_job(seconds=3)
        self.assertTrue(last.startswith("juliavdb: "), last)
        self.assertEqual(len(lines), 1, lines)  # a line each five seconds where stderr is no terminal
        self.assertNotIn("\r", lines[0])
        self.assertNotIn("\033", lines[0])


if __name__ == "__main__":
    harness.main()

# SPDX-License-Identifier: Apache-2.0
# Promise: Ctrl-C and SIGTERM end with 75 ...
"""A task of a plan that is told to stop: gone soon, and missing."""

import signal
import time

import farm
import harness
from harness import INTERRUPTED


class Signals(farm.FarmTest):

    # Promise: "A process that dies can ..."
    def test_a_stopped_task_is_missing(self):
        self.ok("plan", "tiles", harness.BUNNY, "-o", "large", "--tiles", 2, "--resolution", 500, "--alpha", 30,
                "--sdf-resolution", 60)
        for by in (signal.SIGTERM, signal.SIGINT):
            process = self.start("task", "large", "--index", 1, "--threads", 1)
            mark = self.path("large/tasks/0001.running.json")
            end = time.monotonic() + harness.TIMEOUT
            while not mark.exists() and time.monotonic() < end:
                time.sleep(0.01)
            time.sleep(0.3)
            self.assertIn("1 running", self.ok("status", "large", data=True))
            self.assertEqual(self.ok("status", "large", "--missing", data=True), "2\n")
            _, said, took = harness.stop(process, by)
            self.assertEqual(process.returncode, INTERRUPTED, said)
            self.assertLess(took, harness.SOON)
            self.assertEqual(self.ok("status", "large", "--missing", data=True), "1-2\n")
            self.assertEqual(list(self.path("large").rglob("*.running.json")) + list(self.path("large").rglob(".*")), [])


if __name__ == "__main__":
    harness.main()

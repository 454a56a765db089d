# SPDX-License-Identifier: Apache-2.0
"""A plan on Slurm: a true cluster of one node, a task that is killed, one that is told to stop, and the merged result."""

import unittest

import farm
import harness
import slurm_node
from farm import FARM, TILES


@unittest.skipIf(slurm_node.why_not(), slurm_node.why_not())
class Slurm(farm.FarmTest):

    def node(self, **options):
        try:
            node = slurm_node.Node(**options)
        except slurm_node.CannotStart as error:
            self.skipTest(f"Slurm cannot be started here: {error}")
        self.addCleanup(node.stop)
        return node

    def submit(self, node, *words):
        run = self.run_program("submit", FARM, "--engine", "slurm", *words, env=node.environment)
        self.assertEqual(run.returncode, harness.DONE, run.stderr.decode() + node.logs())
        return run.stdout.decode()

    # Promise: "`--missing` prints the numbers ..."
    # Promise of farm.md#with-slurm-on-a-cluster: Slurm: the script, the merge after all tasks, jobs whose time is over, more
    #   tasks than an array takes
    def test_from_a_plan_to_the_merged_result(self):
        self.plan()
        merged = ("-o", "m.vdb", "--mesh", "m.ply")
        with self.node() as node:
            said = self.submit(node, *merged, "--memory", "3G", "--", "--comment=a comment")
            self.assertRegex(said, r"\Atasks: job \d+\nmerge: job \d+\n\Z")
            killed = self.kill_one()
            node.wait_until_idle()
            self.assertEqual(self.missing(), str(killed))
            self.assertFalse(self.path("m.ply").exists(), "the merge depends on every task")
            self.submit(node, *merged)
            node.wait_until_idle()
        self.check_done()
        self.check_merged()
        logs = [path.read_text() for path in self.path(f"{FARM}/logs").glob("*.log")]
        self.assertEqual(len([text for text in logs if "is done" in text]), TILES)

    # Promise: Slurm: the script, the merge ...
    def test_a_job_whose_time_is_over_is_missing(self):
        """Slurm sends --signal=B:TERM@60 to the batch shell alone, which has become the program. It does so at its next look
        at the time, every 30 seconds, for a job of a minute. One task, on one processor, leaves the others to other tests meanwhile."""
        self.ok("plan", "tiles", harness.BUNNY, "-o", FARM, "--tiles", 1, "--resolution", 1300, "--alpha", 12,
                "--sdf-resolution", 60)
        with self.node() as node:
            self.submit(node, "--", "--time=00:01:00")
            node.wait_until_idle(120)
            self.assertEqual(node.logs().count("WEXITSTATUS 75"), 1, node.logs())
        self.assertEqual(self.missing(), "1")
        for log in self.path(f"{FARM}/logs").glob("*.log"):
            self.assertIn("juliavdb: interrupted", log.read_text())
        self.assertEqual([name for name in self.listing() if "running" in name or "failed" in name or "/." in name], [])

    # Promise: Slurm: the script, the merge ...
    def test_more_tasks_than_an_array_takes(self):
        self.plan()
        with self.node(array_size=6) as node:
            self.ok("task", FARM, "--range", "1-4")
            self.submit(node, "-o", "m.vdb", "--mesh", "m.ply")
            self.assertLessEqual(len(node.jobs()), 4)
            node.wait_until_idle()
        self.check_done()
        self.check_merged()
        logs = [path.read_text() for path in self.path(f"{FARM}/logs").glob("*_*.log")]
        self.assertEqual(len(logs), 3, "jobs of four tasks, the first of which were done")

    # Promise: Slurm: the script, the merge ...
    def test_what_sbatch_refuses_is_a_failure(self):
        self.plan()
        with self.node() as node:
            run = self.run_program("submit", FARM, "--engine", "slurm", "--", "--partition=none", env=node.environment)
            self.assertEqual(run.returncode, harness.USAGE, run.stderr)
            self.assertIn(b"partition", run.stderr)
            self.assertIn(b"the same command goes on", run.stderr.splitlines()[-1])
        self.assertEqual(self.states(), (0, 0, 0, TILES))


if __name__ == "__main__":
    harness.main()

# SPDX-License-Identifier: Apache-2.0
"""What the tests of farms share: a plan of 16 tiles of a small bunny, and the run that their merge has to equal."""

import atexit
import functools
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import time

import harness

TILES = 16
OPTIONS = ("--resolution", 60, "--sdf-resolution", 60, "--alpha", 20)
# With a space, since every script has to quote it.
FARM = "a farm"


@functools.cache
def model():
    """A folder with the plan, the plan with all tasks done, and the run."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_test_"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)

    def run(*arguments):
        subprocess.run([harness.program(), *map(str, arguments)], cwd=folder, env=harness.environment(), check=True,
                       stdin=subprocess.DEVNULL, stderr=subprocess.PIPE)

    run("plan", "tiles", harness.BUNNY, "-o", FARM, "--tiles", TILES, *OPTIONS)
    run("fractal", harness.BUNNY, "-o", "s.vdb", "--mesh", "s.ply", *OPTIONS)
    shutil.copytree(folder / FARM, folder / "done")
    run("task", "done", "--range", f"1-{TILES}")
    return folder


class FarmTest(harness.CliTest):

    @classmethod
    def setUpClass(cls):
        cls.model = model()

    def plan(self, done=False):
        shutil.copytree(self.model / ("done" if done else FARM), self.path(FARM))

    def start(self, *arguments, env=None):
        process = subprocess.Popen(
            [harness.program(), *map(str, arguments)], cwd=self.folder, env=harness.environment(env),
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
            preexec_fn=harness.restore_interrupt)

        def end():
            process.kill()
            process.wait()
            process.stderr.close()

        self.addCleanup(end)
        return process

    def missing(self):
        return self.ok("status", FARM, "--missing", data=True).strip()

    def states(self):
        """@return numbers of tasks: done, running, failed, missing"""
        text = self.ok("status", FARM, data=True)
        numbers = re.match(r"(\d+) tasks: (\d+) done, (\d+) running, (\d+) failed, (\d+) missing\n", text)
        self.assertIsNotNone(numbers, text)
        self.assertEqual(int(numbers[1]), TILES)
        return tuple(map(int, numbers.groups()[1:]))

    def processes(self):
        """Those that are at a task, by its number."""
        found = {}
        for path in self.path(FARM).glob("tasks/*.running.json"):
            try:
                found[int(path.name.split(".")[0])] = int(re.search(r'"process": (\d+)', path.read_text())[1])
            except (FileNotFoundError, TypeError):
                pass  # it was done in between
        return found

    def kill_one(self, seconds=60):
        """Kills a process that is at a task, and is still at it when it stops. @return the task"""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            for task, process in self.processes().items():
                try:
                    os.kill(process, signal.SIGSTOP)
                    if task in self.processes():
                        os.kill(process, signal.SIGKILL)
                        return task
                    os.kill(process, signal.SIGCONT)
                except ProcessLookupError:
                    pass
            time.sleep(0.002)
        self.fail("no task was seen at work")

    def check_done(self):
        """Every task has the files that it has when nothing happens, and nothing else is left."""
        self.assertEqual(self.states(), (TILES, 0, 0, 0))
        self.assertEqual(self.missing(), "")
        done = self.model / "done"
        files = lambda root: {p.relative_to(root) for p in root.rglob("*") if p.is_file() and p.parent.name != "logs"}
        self.assertEqual(files(self.path(FARM)), files(done))
        for name in files(done):
            if name.parts[0] != "tasks":
                self.assertEqual((self.path(FARM) / name).read_bytes(), (done / name).read_bytes(), name)

    def check_merged(self, vdb="m.vdb", mesh="m.ply"):
        self.assertEqual(self.bytes(mesh), (self.model / "s.ply").read_bytes())
        self.assertEqual(self.bytes(vdb), (self.model / "s.vdb").read_bytes())

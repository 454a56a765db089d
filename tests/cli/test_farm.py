# SPDX-License-Identifier: Apache-2.0
"""Tasks of a plan on one machine: which one is made, what is recorded, and what a failure, a signal or a kill leaves."""

import fcntl
import hashlib
import json
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
import unittest

import farm
import harness
from farm import FARM, TILES
from harness import BAD_DATA, CANNOT_CREATE, DONE, INTERRUPTED, IO_ERROR, NO_INPUT, USAGE


class Tasks(farm.FarmTest):

    def made(self):
        return sorted(int(path.stem) for path in self.path(FARM).glob("tasks/*.json"))

    def record(self, task):
        return json.loads(self.bytes(f"{FARM}/tasks/{task:04}.json"))

    # Promise of farm.md: Tasks "can run in any order, at any time, and more than once"
    # Promise of farm.md: Which task `task` makes; "Beyond the last task it does nothing, and succeeds"
    def test_which_task_is_made(self):
        self.plan()
        self.ok("task", FARM, "--index", 2)
        self.assertEqual(self.made(), [2])
        self.ok("task", FARM, env={"SLURM_ARRAY_TASK_ID": "5", "PARALLEL_SEQ": "9"})
        self.assertEqual(self.made(), [2, 5])
        self.ok("task", FARM, env={"SLURM_ARRAY_TASK_ID": "7", "SLURM_ARRAY_TASK_STEP": "2"})
        self.assertEqual(self.made(), [2, 5, 7, 8])
        self.ok("task", FARM, env={"PARALLEL_SEQ": "9"})
        self.ok("task", FARM, "--range", "10-11", env={"PARALLEL_SEQ": "16"})
        self.assertEqual(self.made(), [2, 5, 7, 8, 9, 10, 11])
        self.assertEqual(self.missing(), "1,3-4,6,12-16")
        self.assertIn("nothing to do", self.ok("task", FARM, "--index", TILES + 1))
        self.ok("task", FARM, "--range", f"{TILES}-{TILES + 3}")
        self.assertEqual(self.missing(), "1,3-4,6,12-15")
        for words in (("--index", 0), ("--index", "x"), ("--index", 1, "--range", "1-2"), ("--range", "3"),
                      ("--range", "4-3"), ("--range", "0-3"), ()):
            self.refused(USAGE, "task", FARM, *words)
        self.refused(USAGE, "task", FARM, env={"SLURM_ARRAY_TASK_ID": "many"}, mentions="SLURM_ARRAY_TASK_ID")
        self.refused(USAGE, "task", FARM, env={"PARALLEL_SEQ": "-1"}, mentions="PARALLEL_SEQ")

    # Promise of farm.md: "`--json` prints the same for other programs"; "With `--exit-code` the command ends with 0 if all tasks
    #   are done"
    def test_status_for_other_programs(self):
        self.plan()

        def status(code, *words):
            run = self.run_program("status", FARM, "--json", *words, "--progress", "none")
            self.assertEqual((run.returncode, run.stderr), (code, b""))
            return json.loads(run.stdout)

        nothing = status(DONE)
        self.assertEqual((nothing["tasks"], nothing["done"], nothing["failed"], nothing["toBeMade"]),
                         (TILES, 0, [], f"1-{TILES}"))
        self.assertEqual(status(INTERRUPTED, "--exit-code"), nothing)
        self.ok("task", FARM, "--range", "1-3")
        some, records = status(INTERRUPTED, "--exit-code"), [self.record(task) for task in (1, 2, 3)]
        self.assertEqual((some["done"], some["missing"], some["toBeMade"]), (3, TILES - 3, f"4-{TILES}"))
        self.assertEqual(some["bytes"], sum(file["bytes"] for record in records for file in record["files"]))
        self.assertEqual(some["peakBytes"], max(record["peakBytes"] for record in records))
        self.assertAlmostEqual(some["cpuSeconds"], sum(record["cpuSeconds"] for record in records))
        name = next(entry["path"] for entry in json.loads(self.bytes(f"{FARM}/manifest.json"))["inputs"]
                    if not os.path.isabs(entry["path"]))
        original = self.bytes(f"{FARM}/{name}")
        self.write(f"{FARM}/{name}", original[:-1] + bytes([original[-1] ^ 1]))
        self.assertEqual(self.run_program("task", FARM, "--index", 4).returncode, BAD_DATA)
        self.write(f"{FARM}/{name}", original)
        failed = status(BAD_DATA, "--exit-code")
        self.assertEqual([(each["task"], each.get("code")) for each in failed["failed"]], [(4, BAD_DATA)])
        self.assertIn(name, failed["failed"][0]["error"])
        self.assertEqual((failed["missing"], failed["toBeMade"]), (TILES - 4, f"4-{TILES}"))
        self.ok("task", FARM, "--range", f"4-{TILES}")
        self.assertEqual(status(DONE, "--exit-code")["done"], TILES)
        self.refused(USAGE, "status", FARM, "--json", "--missing", mentions="--json and --missing")

    # Promise: Tasks "can run in any order, at any ..."
    # Promise of farm.md#what-is-in-the-folder: "a task that is done is left as it is", and one "is done if its record fits the
    #   plan, and the files fit the record"
    def test_a_task_that_is_done_is_left_alone(self):
        self.plan(done=True)
        before = {path: path.stat().st_mtime_ns for path in self.path(FARM).rglob("*")}
        self.assertIn("already", self.ok("task", FARM, "--index", 3))
        self.assertEqual({path: path.stat().st_mtime_ns for path in self.path(FARM).rglob("*")}, before)

    # Promise: "a task that is done is left ..."
    # Promise: "`--threads N` (or the variables ..."
    def test_what_a_side_car_records(self):
        self.plan()
        self.ok("task", FARM, "--index", 1, env={"SLURM_CPUS_PER_TASK": "1"})
        self.assertEqual(self.record(1)["threads"], 1)
        self.ok("task", FARM, "--index", 2, "--threads", 3)
        record = self.record(2)
        self.assertEqual(record["threads"], 3)
        self.ok("task", FARM, "--index", 3, env={"SLURM_CPUS_ON_NODE": "1"})
        self.assertEqual(self.record(3)["threads"], 1)
        self.assertEqual(record["host"], os.uname().nodename)
        self.assertGreater(record["cpuSeconds"], 0)
        self.assertGreater(record["peakBytes"], 1 << 20)
        for file in record["files"]:
            data = self.bytes(f"{FARM}/{file['name']}")
            self.assertEqual(len(data), file["bytes"])

    # Promise: "a task that is done is left ..."
    def test_a_damaged_result_is_a_failed_task(self):
        self.plan(done=True)
        name = self.record(4)["files"][0]["name"]
        data = bytearray(self.bytes(f"{FARM}/{name}"))
        data[len(data) // 2] ^= 1
        self.write(f"{FARM}/{name}", bytes(data))
        self.assertEqual(self.states(), (TILES - 1, 0, 1, 0))
        self.assertEqual(self.missing(), "4")
        self.assertIn("task 4 failed: " + name, self.ok("status", FARM, data=True))
        self.ok("task", FARM, "--index", 4)
        self.check_done()

    # Promise of farm.md: "`task` and `merge` always compare the SHA-256"
    # Promise of farm.md: "`status` compares sizes and times, and with `--verify` the SHA-256 of everything"
    def test_a_change_that_keeps_size_and_time_is_seen_by_verify(self):
        self.plan(done=True)
        path = self.path(FARM) / self.record(4)["files"][0]["name"]
        times = path.stat()
        data = bytearray(path.read_bytes())
        data[-1] ^= 1
        path.write_bytes(data)
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
        self.assertEqual(self.ok("status", FARM, "--missing", "--verify", data=True), "4\n")
        self.assertIn("is done", self.ok("task", FARM, "--index", 4))
        self.check_done()

    # Promise: "A process that dies can ..."
    # Promise: Tasks "can run in any order, at any ..."
    def test_several_at_the_same_task_give_one_result(self):
        self.plan()
        processes = [self.start("task", FARM, "--range", f"1-{TILES}", "--threads", 1) for _ in range(4)]
        for process in processes:
            _, said = process.communicate(timeout=harness.TIMEOUT)
            self.assertEqual(process.returncode, DONE, said)
        self.check_done()

    # Promise: "`status` compares sizes and times, and with `--verify` ..."
    # Promise of farm.md: `status` counts "triangles, or evaluated nodes where the plan makes no mesh"
    # Promise of farm.md: "`--missing` prints the numbers of the tasks that are neither done nor running", and the same `submit`
    #   again submits "only those"
    def test_status_tells_what_is_to_come(self):
        self.plan()
        self.assertEqual(self.states(), (0, 0, 0, TILES))
        self.assertEqual(self.missing(), f"1-{TILES}")
        self.assertEqual(self.ok("status", FARM, "--missing", "--lines", data=True).split(),
                         [str(k) for k in range(1, TILES + 1)])
        self.ok("task", FARM, "--range", f"1-{TILES // 2}")
        text = self.ok("status", FARM, data=True)
        so_far, to_go = map(int, re.search(r"triangles: (\d+) so far, about (\d+) to go", text).groups())
        self.assertEqual(so_far, sum(self.record(k)["counts"]["triangles"] for k in range(1, TILES // 2 + 1)))
        self.assertEqual(to_go, so_far)
        self.assertIn(f"to be made: {TILES // 2 + 1}-{TILES}", text)


class Failures(farm.FarmTest):
    """One clear line, and no damage."""

    def change(self, name, change):
        path = self.path(FARM) / name
        path.write_bytes(change(path.read_bytes()))

    def test_no_plan(self):
        self.path("empty").mkdir()
        for command in (("task", "--index", 1), ("status",), ("submit", "--engine", "slurm")):
            for folder in ("empty", "nowhere"):
                self.refused(NO_INPUT, command[0], folder, *command[1:], mentions="manifest.json")
            self.refused(USAGE, *command)

    # Promise of farm.md: A changed plan, "Only this version runs its tasks", and another input are refused
    def test_a_manifest_edited_by_hand(self):
        self.plan()
        self.change("manifest.json", lambda text: text.replace(b'"alpha": "20"', b'"alpha": "21"'))
        for command in (("task", FARM, "--index", 1), ("status", FARM), ("submit", FARM, "--engine", "slurm")):
            self.refused(BAD_DATA, *command, mentions=("manifest.json", "changed"))

    # Promise: A changed plan, "Only this ..."
    def test_a_manifest_of_another_version(self):
        self.plan()
        own = self.ok("--version", data=True).split()[1]
        self.change("manifest.json", lambda text: text.replace(f'"{own}"'.encode(), b'"0.0.7"', 1))
        self.refused(BAD_DATA, "task", FARM, "--index", 1, mentions=("0.0.7", own))

    # Promise: A changed plan, "Only this ..."
    def test_another_input(self):
        self.plan()
        inputs = json.loads(self.bytes(f"{FARM}/manifest.json"))["inputs"]
        name = next(entry["path"] for entry in inputs if not os.path.isabs(entry["path"]))
        original = self.bytes(f"{FARM}/{name}")
        self.change(name, lambda data: data[:-1] + bytes([data[-1] ^ 1]))
        run = self.run_program("task", FARM, "--index", 1)
        self.assertIn(name, self.check_refusal(run, BAD_DATA, "task"))
        self.assertEqual(self.states(), (0, 0, 1, TILES - 1))
        self.path(f"{FARM}/{name}").unlink()
        self.check_refusal(self.run_program("task", FARM, "--index", 2), NO_INPUT, "task")
        self.write(f"{FARM}/{name}", original)
        self.ok("task", FARM, "--range", f"1-{TILES}")
        self.check_done()

    def test_a_full_disk(self):
        self.plan()

        def small_files():
            resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))

        run = self.run_program("task", FARM, "--index", 1, preexec_fn=small_files)
        self.check_refusal(run, IO_ERROR, "task")
        self.assertEqual(self.states()[0], 0)
        self.assertEqual([name for name in self.listing() if ".tmp" in name or "running" in name], [])
        self.ok("task", FARM, "--range", f"1-{TILES}")
        self.check_done()

    def test_several_failures_are_one_line(self):
        self.plan()

        def small_files():
            resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))

        run = self.run_program("task", FARM, "--range", f"1-{TILES}", preexec_fn=small_files)
        self.assertEqual(run.returncode, IO_ERROR)
        self.assertEqual(len([line for line in run.stderr.splitlines() if line.startswith(b"juliavdb: ")]), 1)

    def test_a_read_only_folder(self):
        self.plan()
        folder = self.path(FARM)
        mounted = os.geteuid() == 0 and subprocess.run(["mount", "--bind", folder, folder],
                                                       stderr=subprocess.DEVNULL).returncode == 0
        if mounted:
            self.addCleanup(subprocess.run, ["umount", folder], check=True)
            subprocess.run(["mount", "-o", "remount,ro,bind", folder], check=True)
        elif os.geteuid() == 0:
            self.skipTest("root may write whatever the permissions say, and nothing can be mounted here")
        else:
            folder.chmod(0o555)
            self.addCleanup(folder.chmod, 0o755)
        self.refused(CANNOT_CREATE, "task", FARM, "--index", 1)
        self.refused(CANNOT_CREATE, "submit", FARM, "--engine", "parallel", mentions="logs")
        self.assertEqual(self.states(), (0, 0, 0, TILES))


class Requests(farm.FarmTest):
    """What a merge cannot make is known before the first task is made."""

    def commands(self, *words):
        """All commands that are asked for the files of a merge, with nothing made yet."""
        return [("merge", FARM, *words)] + [("submit", FARM, "--engine", engine, *more, *words)
                                            for engine in ("parallel", "slurm") for more in ((), ("--dry-run",))]

    # Promise of farm.md: "What a merge cannot make is refused before the first task is made, by `submit` as by `merge`"
    def test_a_merge_that_cannot_be_made_is_refused_at_once(self):
        self.plan()
        self.path("folder.ply").mkdir()
        for code, words, mentions in (
                (USAGE, ("-o", "x.ply"), "x.ply"),
                (USAGE, ("--mesh", "x.vdb"), "x.vdb"),
                (USAGE, ("--mesh", "x.obj"), ("x.obj", "--make vdb,ply,obj")),
                (USAGE, ("-o", "x.vdb", "--mesh", "x.stl"), "--make vdb,ply,stl"),
                (USAGE, ("--index", "x.ply"), "x.ply"),
                (USAGE, ("--index", "x.json", "-o", "x.vdb"), "--index"),
                (USAGE, ("-o", "x.vdb", "--most-points", 5), "--most-points"),
                (CANNOT_CREATE, ("-o", "nowhere/x.vdb"), "nowhere"),
                (CANNOT_CREATE, ("-o", "x.vdb", "--mesh", "nowhere/x.ply"), "nowhere"),
                (CANNOT_CREATE, ("--mesh", "folder.ply"), "folder.ply"),
                (CANNOT_CREATE, ("--index", "nowhere/x.json"), "nowhere")):
            for command in self.commands(*words):
                self.refused(code, *command, mentions=mentions)
        self.assertEqual(self.states(), (0, 0, 0, TILES))

    # Promise: "What a merge cannot make ..."
    def test_what_the_tasks_do_not_make_is_named_with_the_way_to_it(self):
        for makes, words, wanted in (("ply", ("-o", "x.vdb"), "--make ply,vdb"),
                                     ("vdb", ("--mesh", "x.ply"), "--make vdb,ply")):
            self.ok("plan", "tiles", harness.BUNNY, "-o", makes, "--tiles", 2, "--make", makes, *farm.OPTIONS)
            self.refused(USAGE, "merge", makes, *words, mentions=wanted)
            self.refused(USAGE, "submit", makes, "--engine", "parallel", *words, mentions=wanted)

    # Promise of farm.md: With `--make count`, "The numbers are those of the mesh that one run makes, and a tile's SHA-256 is that
    #   of the file that a plan with `--make ply` keeps"
    def test_a_count_is_that_of_the_mesh(self):
        self.ok("plan", "tiles", harness.BUNNY, "-o", FARM, "--tiles", TILES, "--make", "count", *farm.OPTIONS)
        self.refused(BAD_DATA, "merge", FARM, "--counts", "c.json", mentions="not done")
        for words in (("--mesh", "x.ply"), ("-o", "x.vdb"), ("--index", "x.json")):
            self.refused(USAGE, "merge", FARM, *words, mentions="--counts")
        self.refused(USAGE, "merge", FARM, "--counts", "c.json", "--mesh", "x.ply", mentions="--counts")
        self.refused(USAGE, "merge", FARM, "--counts", "c.txt", mentions="c.txt")
        self.ok("task", FARM, "--range", f"1-{TILES}")
        said = self.ok("merge", FARM, "--counts", "c.json")
        count = json.loads(self.bytes("c.json"))
        mesh = (self.model / "s.ply").read_bytes().partition(b"end_header")[0].decode()
        self.assertEqual(count["triangles"], int(re.search(r"element face (\d+)", mesh)[1]))
        self.assertEqual(count["points"], int(re.search(r"element vertex (\d+)", mesh)[1]))
        self.assertIn(f"{count['triangles']} triangles", said)
        self.assertLess(sum(path.stat().st_size for path in self.path(f"{FARM}/tiles").iterdir()), 1000 * TILES)
        # Other tiles have other hashes, and the same sums.
        self.ok("plan", "tiles", harness.BUNNY, "-o", "other", "--tiles", 3, "--make", "count", *farm.OPTIONS)
        script = self.ok("submit", "other", "--engine", "parallel", "--dry-run", "--counts", "d.json", data=True)
        self.assertIn("--counts", script)
        self.ok("task", "other", "--range", "1-3")
        self.ok("merge", "other", "--counts", "d.json")
        again = json.loads(self.bytes("d.json"))
        self.assertEqual([again[name] for name in ("points", "triangles", "box")],
                         [count[name] for name in ("points", "triangles", "box")])
        self.write("s.obj", harness.obj(harness.sphere(1)))
        self.refused(USAGE, "plan", "frames", "s.obj", "--frames", "1-2", "--key", "alpha@1=20", "-o", "f", "--make",
                     "count", mentions="count")

    # Promise: `status` counts "triangles, or evaluated ..."
    def test_a_plan_without_a_merge(self):
        self.write("s.obj", harness.obj(harness.sphere(1)))
        self.ok("plan", "frames", "s.obj", "--frames", "1-2", "--key", "alpha@1=20", "-o", FARM)
        for engine in ("parallel", "slurm"):
            self.refused(USAGE, "submit", FARM, "--engine", engine, "-o", "x.vdb", mentions="only a plan of tiles")

    # Promise of farm.md: "`--memory`, `--instructions`, `--trust-importer` and `--progress` are those of each task and of the
    #   merge"
    def test_common_options_reach_every_task_and_the_merge(self):
        self.plan()
        common = "--instructions portable --memory 3G --trust-importer --progress none"
        for engine in ("parallel", "slurm"):
            script = self.ok("submit", FARM, "--engine", engine, "--dry-run", "-o", "m.vdb", "--threads", 2,
                             *common.split(), "--most-points", 1000, "--mesh", "m.ply", data=True)
            for command in ("task", "merge"):
                line, = (line for line in script.splitlines() if f"{command} ." in line)
                self.assertIn(common, line)
            self.assertIn("--most-points 1000", script)
            self.refused(USAGE, "submit", FARM, "--engine", engine, "--memory", "much", mentions="much")
            self.refused(USAGE, "submit", FARM, "--engine", engine, "--instructions", "mmx", mentions="mmx")


class HostilePlans(farm.FarmTest):
    """tests/farm/hostile_plan_test.cpp goes through every value."""

    # Promise: "If somebody changes a plan ..."
    def test_what_is_left_out_is_bad_data(self):
        self.plan()
        manifest = json.loads(self.bytes(f"{FARM}/manifest.json"))
        manifest.pop("hash")
        for change in (lambda m: m.pop("lattice"), lambda m: m["tasks"][2].pop("box"), lambda m: m["tasks"].clear(),
                       lambda m: m["tasks"][0].update(box=[[0, 0, 0], [-8, -8, -8]]),
                       lambda m: m["recipe"].update(alpha="x"), lambda m: m.update(kind="frames"),
                       lambda m: m["tasks"][0].update(writes=[])):
            changed = json.loads(json.dumps(manifest))
            change(changed)
            changed["hash"] = hashlib.sha256(
                json.dumps(changed, separators=(",", ":"), ensure_ascii=False).encode()).hexdigest()
            self.write(f"{FARM}/manifest.json", json.dumps(changed, ensure_ascii=False))
            self.all_refused(BAD_DATA, [("status", FARM), ("task", FARM, "--index", 1), ("merge", FARM, "-o", "x.vdb"),
                                        ("submit", FARM, "--engine", "parallel", "-o", "x.vdb")],
                             mentions=("manifest.json", "plan again"))


class Kills(farm.FarmTest):

    # Promise of farm.md: "A process that dies can be started again, and only the task that it was making is lost"
    def test_killed_a_hundred_times(self):
        seed = int(os.environ.get("JULIAVDB_SEED") or random.randrange(1 << 32))
        print(f"seed {seed}: JULIAVDB_SEED repeats it", file=sys.stderr)
        chance = random.Random(seed)
        kills = rounds = 0
        self.plan()
        while kills < 100:
            if self.missing() == "":
                self.ok("task", FARM, "--index", 1)  # it sweeps up behind the last one that was killed
                self.check_done()
                rounds += 1
                shutil.rmtree(self.path(FARM))
                self.plan()
            processes = [self.start("task", FARM, "--range", f"1-{TILES}", "--threads", 1) for _ in range(2)]
            time.sleep(chance.uniform(0, 0.5))
            for process in processes:
                process.kill()
                code = process.wait()
                self.assertIn(code, (DONE, -signal.SIGKILL), f"seed {seed}, kill {kills}: {process.stderr.read().decode()}")
                kills += code == -signal.SIGKILL
            done, _, failed, _ = self.states()
            self.assertEqual(failed, 0, f"seed {seed}, kill {kills}")
        self.ok("task", FARM, "--range", f"1-{TILES}")
        with self.subTest(seed=seed, rounds=rounds):
            self.check_done()
            self.ok("merge", FARM, "-o", "m.vdb", "--mesh", "m.ply")
            self.check_merged()


TEMPLATES = pathlib.Path(__file__).resolve().parent.parent.parent / "integrations/farm"

# What the templates that are shipped ask of their engines, as far as they ask: each runs what it is given, tasks first.
FAKE_OUTLINE = """
import subprocess, types, sys
class Outline:
    def __init__(self, name, show, shot, user): self.name, self.layers = name, []
    def add_layer(self, layer): self.layers.append(layer)
class Shell:
    def __init__(self, name, command, range, chunk, threads, threadable):
        self.name, self.command, self.range, self.behind = name, command, range, []
    def depend_all(self, layer): self.behind.append(layer)
    def run(self):
        frames = []
        for part in self.range.split(","):
            ends = part.split("-")
            frames += __import__("builtins").range(int(ends[0]), int(ends[-1]) + 1)
        for frame in frames:   # the words of a command are joined by blanks, and a shell on the farm takes them apart
            subprocess.run(" ".join(self.command).replace("#IFRAME#", str(frame)), shell=True, check=True)
def launch(job, use_pycuerun):
    for number, layer in enumerate(job.layers):
        assert layer.behind == job.layers[:number]
        layer.run()
for name in ("outline.cuerun", "outline.modules", "outline.modules.shell"): sys.modules[name] = types.ModuleType(name)
cuerun, modules = sys.modules["outline.cuerun"], sys.modules["outline.modules"]
cuerun.launch, modules.shell = launch, sys.modules["outline.modules.shell"]
modules.shell.Shell = Shell
"""
FAKE_TRACTOR = """
import subprocess
class Job:
    def __init__(self, title, service, argv=None, maxactive=0): self.argv, self.below = argv, []
    def newTask(self, title, argv, service):
        self.below.append(Job(title, service, argv))
        return self.below[-1]
    def spool(self):
        for task in self.below: task.spool()
        if self.argv: subprocess.run(self.argv, check=True)
        return 1
"""
# It reads both files, and runs the plugin's command for each piece of frames. Double quotes alone hold a word together, and <QUOTE>
# stands for one.
FAKE_DEADLINE = """#!/usr/bin/env python3
import re, subprocess, sys
job, plugin = (dict(line.split("=", 1) for line in open(name).read().splitlines()) for name in sys.argv[1:3])
assert job["Plugin"] == "CommandLine"
size = int(job.get("ChunkSize", 1))
for part in job["Frames"].split(","):
    first, last = int(part.split("-")[0]), int(part.split("-")[-1])
    for start in range(first, last + 1, size):
        words = plugin["Arguments"].replace("<STARTFRAME>", str(start)).replace("<ENDFRAME>", str(min(start + size - 1, last)))
        words = re.findall(r'(?:[^" ]|"[^"]*")+', words.replace("<QUOTE>", '"'))
        subprocess.run([plugin["Executable"], *(word.replace('"', "") for word in words)], check=True)
print("Result=Success\\nJobID=" + str(len(job)))
"""
LEAST = "#!/bin/sh\nexec @{program:shell} @{task-arguments} --range @{tasks}\n"


class Script(farm.FarmTest):
    """--engine script: templates, those that are shipped, and those that cannot be used."""

    def engines(self):
        os.makedirs(self.path("python/tractor/api"))
        self.write("python/outline.py", FAKE_OUTLINE)
        for name in ("__init__.py", "api/__init__.py"):
            self.write(f"python/tractor/{name}", "")
        self.write("python/tractor/api/author.py", FAKE_TRACTOR)
        os.mkdir(self.path("bin"))
        self.write("bin/deadlinecommand", FAKE_DEADLINE)
        self.path("bin/deadlinecommand").chmod(0o755)
        return {"PYTHONPATH": str(self.path("python")), "PATH": f"{self.path('bin')}:{os.environ['PATH']}"}

    def submit(self, template, *words, env=None):
        return self.run_program("submit", FARM, "--engine", "script", "--template", template, *words, env=env)

    # Promise of farm.md#with-any-other-engine-by-a-template: The three templates make what is missing, and merge it
    def test_the_shipped_templates_make_what_is_missing_and_merge_it(self):
        env = self.engines()
        for name in ("opencue.py", "deadline.sh", "tractor.py"):
            with self.subTest(name=name):
                shutil.rmtree(self.path(FARM), ignore_errors=True)
                self.plan(done=True)
                for task in (2, 3, 7):
                    self.path(f"{FARM}/tasks/{task:04}.json").unlink()
                run = self.submit(TEMPLATES / name, "-o", "m.vdb", "--mesh", "m.ply", env=env)
                self.assertEqual(run.returncode, DONE, run.stdout + run.stderr)
                self.check_done()
                self.check_merged()
                # Once all is done, only the merge is left.
                run = self.submit(TEMPLATES / name, "-o", "m.vdb", "--dry-run", env=env)
                self.assertNotIn(b"--index", run.stdout)
                self.assertNotIn(b"--range", run.stdout)

    # Promise of farm.md: "Words are quoted as each farm takes them apart"; Deadline "cannot pass on a path with a double quote in
    #   it"
    def test_the_shipped_templates_take_folders_with_blanks_and_accents(self):
        env = self.engines()
        folder = "shot 010 äé/my plan's"
        for name in ("opencue.py", "deadline.sh", "tractor.py"):
            with self.subTest(name=name):
                shutil.rmtree(self.path("shot 010 äé"), ignore_errors=True)
                shutil.copytree(self.model / "done", self.path(folder))
                for task in (2, 3):
                    self.path(f"{folder}/tasks/{task:04}.json").unlink()
                run = self.run_program("submit", folder, "--engine", "script", "--template", TEMPLATES / name,
                                       "-o", "shot 010 äé/m $1.vdb", "--mesh", "shot 010 äé/m $1.ply", env=env)
                self.assertEqual(run.returncode, DONE, run.stdout + run.stderr)
                self.check_merged("shot 010 äé/m $1.vdb", "shot 010 äé/m $1.ply")

    # Promise: "Words are quoted as each ..."
    def test_deadline_is_not_given_what_it_cannot_pass_on(self):
        env = self.engines()
        shutil.copytree(self.model / FARM, self.path('a "farm"'))
        run = self.run_program("submit", 'a "farm"', "--engine", "script", "--template", TEMPLATES / "deadline.sh", env=env)
        self.assertNotEqual(run.returncode, DONE)
        self.assertIn(b"double quote", run.stdout + run.stderr)

    # Promise: The three templates make ...
    def test_dry_runs_are_scripts(self):
        """Read by the parsers of their own languages; nothing is written."""
        self.plan()
        before = self.listing()
        for name in ("opencue.py", "deadline.sh", "tractor.py"):
            for words in ((), ("-o", "it's.vdb"), ("--threads", 3, "--jobs", 7, "--memory", "5G")):
                text = self.ok("submit", FARM, "--engine", "script", "--template", TEMPLATES / name, "--dry-run", *words,
                               data=True)
                self.assertNotIn("@{", text)
                if name.endswith(".sh"):
                    subprocess.run(["sh", "-n"], input=text.encode(), check=True)
                else:
                    compile(text, name, "exec")
        self.assertEqual(self.listing(), before)

    def test_a_template_of_ones_own(self):
        self.plan()
        self.ok("task", FARM, "--range", "2-9")
        self.write("t.sh", "#!/bin/sh\n# @{count} of @{name}, @@{as it is}\nset -eu\n@{each task}\n"
                   "@{program:shell} @{task-arguments} --index @{task}\n@{end}\n@{if merge}\n@{program:shell} @{merge-arguments}\n"
                   "@{end}\necho @{arguments}\n")
        run = self.submit("t.sh", "-o", "m.vdb", "--mesh", "m.ply", "--", "two words", "$HOME")
        self.assertEqual((run.returncode, run.stdout), (DONE, b"two words $HOME\n"), run.stderr)
        self.check_done()
        self.check_merged()
        script = self.path(f"{FARM}/logs/submit").read_text()
        self.assertIn(f"# 8 of {FARM}, @{{as it is}}\n", script)

    def test_what_a_script_says_by_its_code(self):
        self.plan()
        self.write("t.sh", "#!/bin/sh\nexit 3\n# @{program} @{task-arguments} @{tasks} @{arguments}\n")
        run = self.submit("t.sh")
        self.assertEqual(run.returncode, INTERRUPTED)
        self.assertIn(b"code 3", run.stderr)
        self.assertEqual(self.submit("t.sh", "--", "x").returncode, USAGE)

    # Promise of farm.md: "Unknown fields, missing fields and blocks without an end are refused with the line, before anything is
    #   written"
    def test_templates_that_cannot_be_used(self):
        """Refused with the line, before anything is written."""
        self.plan()
        bad = {
            "no interpreter": ("echo @{program} @{task-arguments} @{tasks}\n", "#!"),
            "unknown": (LEAST + "@{progam}\n", "did you mean 'program'"), "form": (LEAST + "@{name:html}\n", "line 3"),
            "open": (LEAST + "@{name\n", "line 3"), "outside": (LEAST + "@{task}\n", "line 3"),
            "no end": (LEAST + "@{if merge}\n", "@{end}"), "no begin": (LEAST + "@{end}\n", "line 3"),
            "nested": (LEAST + "@{if merge}\n@{if tasks}\n@{end}\n@{end}\n", "nest"),
            "no program": ("#!/bin/sh\n@{task-arguments} @{tasks}\n", "@{program}"),
            "no way to tasks": ("#!/bin/sh\n@{program} @{task-arguments}\n", "@{tasks}"),
            "no arguments of tasks": ("#!/bin/sh\n@{program} @{tasks}\n", "@{task-arguments}"), "bytes": (LEAST + "\0", "text"),
        }
        self.write("least.sh", LEAST)
        for name, (text, mention) in bad.items():
            self.write(name, text)
        submit = ("submit", FARM, "--engine", "script")
        for name, (text, mention) in bad.items():
            with self.subTest(name=name):
                self.refused(BAD_DATA, *submit, "--template", name, mentions=mention)
        self.refused(BAD_DATA, *submit, "--template", "least.sh", "-o", "m.vdb", mentions="@{merge-arguments}")
        self.refused(BAD_DATA, *submit, "--template", "least.sh", "--", "more", mentions="@{arguments}")
        self.refused(USAGE, *submit, "--template", "least.sh", "--batch", 2, mentions="--batch")
        self.refused(USAGE, *submit, mentions="--template")
        self.refused(USAGE, "submit", FARM, "--engine", "slurm", "--template", "least.sh", mentions="--template")
        self.refused(NO_INPUT, *submit, "--template", "none.sh", mentions="none.sh")


@unittest.skipUnless(shutil.which("parallel"), "GNU parallel is not installed")
class Parallel(farm.FarmTest):

    def submit(self, *words):
        return self.start("submit", FARM, "--engine", "parallel", "--jobs", 2, "-o", "m.vdb", "--mesh", "m.ply", *words)

    # Promise of farm.md: What is merged "has the same bytes as that of one long run", for any cut
    # Promise of farm.md: "If a task fails, is killed or is interrupted, there is no merge, and the same `submit` goes on from
    #   there"
    # Promise: "`--missing` prints the numbers ..."
    def test_from_a_plan_to_the_merged_result(self):
        self.plan()
        process = self.submit()
        killed = self.kill_one()
        process.communicate(timeout=harness.TIMEOUT)
        self.assertNotEqual(process.returncode, DONE)
        self.assertEqual(self.missing(), str(killed))
        self.assertFalse(self.path("m.ply").exists())
        process = self.submit()
        _, said = process.communicate(timeout=harness.TIMEOUT)
        self.assertEqual(process.returncode, DONE, said)
        self.check_done()
        self.check_merged()
        log = self.path(f"{FARM}/logs/joblog").read_text().splitlines()
        self.assertEqual(len(log), TILES + 1, "each task once, and the killed one twice")

    # Promise: Tasks "can run in any order, at any ..."
    def test_a_process_makes_several_tasks(self):
        self.plan()
        self.assertEqual(self.ok("status", FARM, "--missing", "--batch", 7, data=True).split(), ["1-7", "8-14", "15-16"])
        self.ok("task", FARM, "--index", 3)
        self.assertEqual(self.ok("status", FARM, "--missing", "--batch", 7, data=True).split(), ["1-2", "4-10", "11-16"])
        process = self.submit("--batch", 7)
        _, said = process.communicate(timeout=harness.TIMEOUT)
        self.assertEqual(process.returncode, DONE, said)
        self.check_done()
        self.check_merged()
        log = self.path(f"{FARM}/logs/joblog").read_text().splitlines()
        self.assertEqual(len(log), 3, "a line for each process")
        for words in (("--missing", "--batch", 0), ("--batch", 2), ("--missing", "--lines", "--batch", 2)):
            self.refused(USAGE, "status", FARM, *words)

    # Promise: "A process that dies can ..."
    # Promise: "Its exit code is one of the program's ..."
    def test_stopped_and_resumed(self):
        self.plan()
        process = self.submit()
        self.kill_one()
        for _ in range(2):  # the second makes parallel stop the tasks instead of waiting for them
            process.send_signal(signal.SIGTERM)
            time.sleep(0.2)
        _, said = process.communicate(timeout=harness.TIMEOUT)
        self.assertEqual(process.returncode, INTERRUPTED, said)
        lines = said.decode().splitlines()
        self.assertIn("the same command goes on", lines[-1])
        self.assertEqual([line for line in lines if line.startswith("juliavdb: interrupted")], lines[-1:])
        done, running, failed, missing = self.states()
        self.assertEqual((running, failed), (0, 0))
        self.assertGreater(missing, 0, "what was running was stopped, and not waited for to its end")
        process = self.submit()
        process.communicate(timeout=harness.TIMEOUT)
        self.assertEqual(process.returncode, DONE)
        self.check_done()
        self.check_merged()

    def ended(self, code, *mentions, env=None, preexec=None, words=()):
        """A submission that fails: the code, and a last line that says what is missing and how it goes on."""
        run = self.run_program("submit", FARM, "--engine", "parallel", "--jobs", 2, *words, env=env,
                               preexec_fn=preexec)
        text = run.stderr.decode()
        self.assertEqual(run.returncode, code, text)
        last = text.splitlines()[-1]
        for mention in ("juliavdb: ", "the same command", *mentions):
            self.assertIn(mention, last, text)

    # Promise of farm.md: "Its exit code is one of the program's own": the table, and a last line that "says which tasks are not
    #   done, and why"
    def test_failed_tasks_give_their_code(self):
        self.plan()
        name = next(entry["path"] for entry in json.loads(self.bytes(f"{FARM}/manifest.json"))["inputs"]
                    if not os.path.isabs(entry["path"]))
        original = self.bytes(f"{FARM}/{name}")
        self.write(f"{FARM}/{name}", original[:-1] + bytes([original[-1] ^ 1]))
        self.ended(BAD_DATA, f"tasks 1-{TILES} of {TILES} are not done", "task 1: ", name, "(exit code 65)")
        self.write(f"{FARM}/{name}", original)
        self.assertEqual(self.states(), (0, 0, TILES, 0))
        # They say nothing of a later submission, of which no task begins.
        self.ended(USAGE, "parallel failed", "words behind --", words=("--", "--no-such-option"))

    # Promise: "Its exit code is one of the program's ..."
    def test_a_full_disk(self):
        self.plan()

        def small_files():
            resource.setrlimit(resource.RLIMIT_FSIZE, (12000, 12000))

        self.ended(IO_ERROR, "not done", preexec=small_files)

    # Promise: "Its exit code is one of the program's ..."
    def test_the_gravest_of_several_codes(self):
        self.plan()
        for task in (2, 5):  # a folder stands where a file is to be
            self.path(f"{FARM}/tiles/{task:04}.vdb").mkdir(parents=True)
        with self.subTest("one code"):
            self.ended(CANNOT_CREATE, f"tasks 2,5 of {TILES} are not done", "task 2: ", "(exit code 73)",
                       words=("-o", "m.vdb"))
            self.assertFalse(self.path("m.vdb").exists())
        for record in self.path(f"{FARM}/tasks").iterdir():
            record.unlink()

        def small_files():
            resource.setrlimit(resource.RLIMIT_FSIZE, (12000, 12000))

        self.ended(CANNOT_CREATE, "not done", preexec=small_files)

    # Promise: "Its exit code is one of the program's ..."
    def test_killed_tasks_are_worth_another_try(self):
        self.plan()
        process = self.submit()
        killed = self.kill_one()
        _, said = process.communicate(timeout=harness.TIMEOUT)
        self.assertEqual(process.returncode, INTERRUPTED, said)
        self.assertIn(f"task {killed} of {TILES} is not done; the same command", said.decode().splitlines()[-1])

    # Promise: "Its exit code is one of the program's ..."
    def test_what_parallel_refuses(self):
        self.plan()
        self.ended(USAGE, "parallel failed", "words behind --", words=("--", "--no-such-option"))
        self.assertEqual(self.states(), (0, 0, 0, TILES))

    # Promise: "Its exit code is one of the program's ..."
    def test_a_merge_that_fails(self):
        self.plan(done=True)
        shutil.rmtree(self.path(f"{FARM}/logs"), ignore_errors=True)

        def small_files():
            resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))

        self.ended(IO_ERROR, "all tasks are done", "merge", preexec=small_files, words=("-o", "m.vdb"))
        self.assertFalse(self.path("m.vdb").exists())

    # Promise: "Its exit code is one of the program's ..."
    def test_tasks_that_others_are_at(self):
        self.plan(done=True)
        self.path(f"{FARM}/tasks/0003.json").unlink()
        mark = self.path(f"{FARM}/tasks/0003.running.json")
        mark.write_text("{}")
        with open(mark) as held:
            fcntl.flock(held, fcntl.LOCK_EX)
            self.ended(INTERRUPTED, f"task 3 of {TILES}", "made by others", words=("-o", "m.vdb"))

    # Promise of progress.md: "the events of the tasks and of the merge come on the same stderr, each with its own `command`,
    #   between the `start` and the `end` of `submit`"
    def test_progress_of_tasks_stands_within_that_of_the_submission(self):
        self.plan()
        run = self.run_program("submit", FARM, "--engine", "parallel", "--jobs", 2, "--mesh", "m.ply", "--progress", "json")
        events = [json.loads(line) for line in run.stderr.decode().splitlines()]
        ends = [(event["command"], event["event"]) for event in events if event["event"] in ("start", "end")]
        self.assertEqual((ends[0], ends[-1]), (("submit", "start"), ("submit", "end")))
        self.assertEqual(sorted(ends[1:-1]),
                         [("merge", "end"), ("merge", "start")] + [("task", "end")] * TILES + [("task", "start")] * TILES)

    # Promise: "If a task fails, is killed ..."
    def test_nothing_is_left_to_submit(self):
        self.plan(done=True)
        self.assertIn("nothing to submit", self.ok("submit", FARM, "--engine", "parallel"))
        self.assertFalse(self.path(f"{FARM}/logs").exists())

    # Promise: "one band for all tasks of a mesh, made ..."
    def test_nothing_is_left_of_what_no_task_needs(self):
        """Also where a process that was killed has left it behind the last task."""
        self.ok("plan", "frames", harness.BUNNY, "-o", "frames", "--frames", "1-2", "--key", "alpha@1=20", "--key",
                "alpha@2=40", "--resolution", 16, "--sdf-resolution", 20)
        self.ok("task", "frames", "--index", 1)
        shutil.copytree(self.path("frames/targets"), self.path("kept"))
        self.ok("task", "frames", "--index", 2)
        self.assertFalse(self.path("frames/targets").exists())
        shutil.copytree(self.path("kept"), self.path("frames/targets"))
        self.ok("submit", "frames", "--engine", "parallel", "--dry-run", data=True)
        self.assertTrue(self.path("frames/targets").exists())
        self.assertIn("nothing to submit", self.ok("submit", "frames", "--engine", "parallel"))
        self.assertFalse(self.path("frames/targets").exists())

    # Promise: "If a task fails, is killed ..."
    def test_a_dry_run_changes_nothing(self):
        self.plan()
        before = self.listing()
        script = self.ok("submit", FARM, "--engine", "parallel", "--dry-run", "--threads", 3, "--", "--nice", "5",
                         data=True)
        self.assertEqual(self.listing(), before)
        self.assertIn("--nice 5", script)
        self.assertIn("--threads 3", script)
        subprocess.run(["sh", "-n"], input=script.encode(), check=True)
        self.refused(USAGE, "submit", FARM, mentions="--engine")
        self.refused(USAGE, "submit", FARM, "--engine", "pbs", mentions="pbs")
        self.refused(NO_INPUT, "submit", FARM, "--engine", "parallel", env={"PATH": "/nowhere"}, mentions="parallel")


if __name__ == "__main__":
    harness.main()

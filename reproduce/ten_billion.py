# SPDX-License-Identifier: Apache-2.0
"""kd20-ten-billion: a bunny of more than ten billion triangles, made in as many calls as it takes.

It takes hours, so it is no entry among the others. What each task counted is a line of a record, which lies in the repository
and outlives the machine. The plan itself is made anew by each call, in a folder that is removed afterwards: nothing of an
earlier program is in it. The counts of a record belong together only if the program still makes the same tiles, so a call makes
some of them again before it goes on.
"""
import contextlib
import dataclasses
import fcntl
import hashlib
import json
import math
import os
import pathlib
import random
import shlex
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time

import harness
import meshes

NAME = "kd20-ten-billion"
TITLE = "[KD20] Section 5.1: ten billion triangles, made in many calls and never with the other entries"
RECORD = harness.ROOT / "reproduce/data/ten-billion"
CHECKED = 3  # tasks that are made again before a record goes on
LEAST_FOR_INTERVAL = 10
SHUFFLE = "ten billion"

RECIPE = "recipe.json"
TASKS, HEAD = "tasks.tsv", "task\ttriangles\tpoints\tbox\tsha256\tcpu s\tMiB\tby"
MAKERS, MAKERS_HEAD = "makers.tsv", "number\tsince\tversion\tmachine"


def add_options(parser):
    group = parser.add_argument_group(NAME)
    actions = group.add_mutually_exclusive_group()
    actions.add_argument("--resume", action="store_true", help="make the tasks that have no line in the record")
    actions.add_argument("--verify", metavar="K", help="make K random tasks of the record again, and compare")
    group.add_argument("--tasks", metavar="N", help="with --resume: make at most N tasks")
    group.add_argument("--minutes", metavar="M", help="with --resume: begin no task after M minutes")
    group.add_argument("--jobs", metavar="J", help="how many tasks are made at once; without it, one for each processor")
    group.add_argument("--seed", metavar="S", help="draws the tasks that are made again; without it, by chance")
    group.add_argument("--record", type=pathlib.Path, metavar="FOLDER", help="another record than reproduce/data/ten-billion; "
                       "without it, a small one lies in the folder of the results")


def check_options(options, refuse):
    """@param refuse  ends the program with the words that it is given"""
    for name in ("resume", "verify", "tasks", "minutes", "jobs", "seed", "record"):
        if getattr(options, name) and options.names != [NAME]:
            refuse(f"--{name} goes with {NAME} alone; give that name and no other")
    if NAME in options.names and not options.list and options.names != [NAME]:
        refuse(f"{NAME} takes hours, and runs without other entries; give the others by a command of their own")
    for name in ("page", "data", "again"):
        if getattr(options, name) and options.names == [NAME]:
            refuse(f"--{name} goes with the other entries, and not with {NAME}; leave it out")
    for name in ("tasks", "minutes"):
        if getattr(options, name) and not options.resume:
            refuse(f"--{name} goes with --resume; give that too, or leave it out")
    for name, default in (("verify", None), ("tasks", None), ("minutes", None), ("jobs", len(os.sched_getaffinity(0))),
                          ("seed", random.randrange(1, 10**6))):
        word = getattr(options, name)
        if word is not None and not (word.isascii() and word.isdigit() and int(word) >= 1):
            refuse(f"--{name} is '{word}'; it must be a whole number of at least 1")
        setattr(options, name, default if word is None else int(word))
    options.record = options.record or (options.into / NAME if options.size.name == "small" else RECORD)


class Refused(Exception):
    """What the record or the program does not allow, in one line with a way out."""


def options_of(size):
    # The distances take most of the time of a small plan.
    n, frequency, tiles = size.pick(("60 --sdf-resolution 40", 4, 12), (9000, 12, 3200), (9000, 12, 3200))
    return (f"--resolution {n} --detail 0.8 --iterations 8 --frequency {frequency} --precision float --tiles {tiles} "
            "--make count")


def shuffled(indices, seed):
    """The tasks in a random order that is the same for ever, so that the first ones are a random sample of all."""
    return sorted(indices, key=lambda index: hashlib.sha256(f"{seed}:{index}".encode()).digest())


@dataclasses.dataclass(frozen=True)
class Made:
    """What a task made, and what that took.

    @param box  of its points, six numbers of six digits (all of them are in the hash), or "-" if it has none
    @param by   the number of a line of makers.tsv
    """
    task: int
    triangles: int
    points: int
    box: str
    sha256: str
    cpu: float
    memory: int
    by: int

    @property
    def counted(self):
        return self.triangles, self.points, self.box, self.sha256

    def line(self):
        return "\t".join(map(str, dataclasses.astuple(self))) + "\n"

    @staticmethod
    def of(line):
        words = line.split("\t")
        fields = dataclasses.fields(Made)
        if len(words) != len(fields):
            raise ValueError(f"it has {len(words)} columns and not {len(fields)}")
        made = Made(*(field.type(word) for field, word in zip(fields, words)))
        corners = [] if made.box == "-" else [float(word) for word in made.box.split(" ")]
        sound = min(made.triangles, made.points) >= 0 and len(corners) in (0, 6) and len(made.sha256) == 64
        if made.line() != line + "\n" or not sound:
            raise ValueError("a number, the box or the hash is not written as a task writes it")
        return made


class Record:
    """The folder in which a line stands for each task that was made.

    A line is written at once when its task ends. What a crash may leave is a last line without its end, which counts as absent.
    """

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.makers = {}
        try:
            self.recipe = json.loads(self._text(RECIPE) or "null")
            for line in self._lines(MAKERS, MAKERS_HEAD):
                number, _, version, machine = line.split("\t")
                self.makers[int(number)] = (version, machine)
        except ValueError as error:
            raise Refused(f"{RECIPE} or {MAKERS} in {self.folder} is broken: {error}; take the file of an earlier "
                          "commit") from None
        self.torn = bool(self._text(TASKS)) and not self._text(TASKS).endswith("\n")
        self.made = {}
        for row, line in enumerate(self._lines(TASKS, HEAD), 2):
            try:
                made = Made.of(line)
                if made.task in self.made:
                    raise ValueError(f"task {made.task} stands there twice")
                if not 1 <= made.task <= self.tasks:
                    raise ValueError(f"the plan has no task {made.task}")
                if made.by not in self.makers:
                    raise ValueError(f"{MAKERS} has no number {made.by}")
            except ValueError as error:
                raise Refused(f"line {row} of {self.folder / TASKS} is broken: {error}; remove it, and its task is "
                              "made again") from None
            self.made[made.task] = made

    @property
    def tasks(self):
        return self.recipe["tasks"] if self.recipe else 0

    def _text(self, name):
        path = self.folder / name
        return path.read_text() if path.exists() else ""

    def _lines(self, name, head):
        lines = self._text(name).split("\n")[:-1]
        if lines and lines[0] != head:
            raise Refused(f"the first line of {self.folder / name} is not that of a record; take the file of an earlier "
                          "commit")
        return lines[1:]

    @contextlib.contextmanager
    def writing(self):
        """Keeps other calls out, and drops a torn last line."""
        self.folder.mkdir(parents=True, exist_ok=True)
        held = os.open(self.folder, os.O_RDONLY)
        try:
            try:
                fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise Refused(f"another call writes into {self.folder}; wait for it") from None
            self.__init__(self.folder)
            for name in (TASKS, MAKERS):
                text = self._text(name)
                if not text.endswith("\n") and text:
                    tell(f"the last line of {self.folder / name} has no end; it is dropped")
                    os.truncate(self.folder / name, len(text[:text.rfind("\n") + 1].encode()))
            self.torn = False
            yield
        finally:
            os.close(held)

    def _append(self, name, head, line):
        with open(self.folder / name, "ab", buffering=0) as file:
            file.write((line if file.tell() else head + "\n" + line).encode())
            os.fsync(file.fileno())

    def begin(self, recipe):
        beside = self.folder / (RECIPE + ".new")
        beside.write_text(json.dumps(recipe, indent=1) + "\n")
        beside.rename(self.folder / RECIPE)
        self.recipe = recipe

    def number_of(self, maker):
        """The number of a version of the program on a machine; a new line if it has none."""
        for number, known in self.makers.items():
            if known == maker:
                return number
        number = max(self.makers, default=0) + 1
        self._append(MAKERS, MAKERS_HEAD, "\t".join([str(number), time.strftime("%Y-%m-%d", time.gmtime()), *maker]) + "\n")
        self.makers[number] = maker
        return number

    def add(self, made):
        self._append(TASKS, HEAD, made.line())
        self.made[made.task] = made


class Plan:
    """The plan of the program at hand, in a folder of its own."""

    def __init__(self, runner, mesh, size, folder):
        self.runner, self.folder = runner, folder
        words = ["plan", "tiles", str(mesh.path), "-o", str(folder), *options_of(size).split()]
        self._wait(self.start(words), "the plan")
        manifest = json.loads((folder / "manifest.json").read_text())
        boxes = json.dumps([manifest["lattice"], [task["box"] for task in manifest["tasks"]]])
        self.recipe = {"command": f"juliavdb plan tiles bunny.obj -o ten {options_of(size)}", "bunny.obj": mesh.hash,
                       "tasks": len(manifest["tasks"]), "tiles": hashlib.sha256(boxes.encode()).hexdigest()}

    def start(self, words):
        # A session of its own, so that Ctrl-C reaches it by stop() alone.
        return subprocess.Popen([self.runner.program, *words, "--progress", "none"], stdin=subprocess.DEVNULL,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=self.runner.environment({}),
                                start_new_session=True)

    @staticmethod
    def stop(processes):
        for process in processes:
            process.terminate()
            # One that somebody has stopped hears nothing before it goes on.
            process.send_signal(signal.SIGCONT)
        for process in processes:
            process.communicate()

    def _wait(self, process, what):
        try:
            said = process.communicate()[1].strip().splitlines()
        except BaseException:
            self.stop([process])
            raise
        if process.returncode:
            raise Refused(f"{what} ended with code {process.returncode}: {said[-1] if said else 'it said nothing'}")

    def _read(self, task, by):
        """What the program has written of a task."""
        counted = json.loads((self.folder / f"tiles/{task:04}.json").read_text())
        took = json.loads((self.folder / f"tasks/{task:04}.json").read_text())
        box = " ".join(f"{x:.6g}" for x in counted["box"]) if "box" in counted else "-"
        return Made(task, counted["triangles"], counted["points"], box, counted["sha256"], round(took["cpuSeconds"], 2),
                    round(took["peakBytes"] / 2**20), by)

    def make(self, tasks, jobs, by=0, until=math.inf):
        """Makes tasks, some at a time, and gives each as it ends. After `until` no other one is begun."""
        waiting, running = iter(tasks), {}
        try:
            while True:
                while len(running) < jobs and time.monotonic() < until:
                    task = next(waiting, None)
                    if task is None:
                        break
                    for left in (self.folder / "tasks", self.folder / "tiles"):
                        (left / f"{task:04}.json").unlink(missing_ok=True)
                    process = self.start(["task", str(self.folder), "--index", str(task), "--threads", "1"])
                    running[process.pid] = (process, task)
                if not running:
                    return
                # It stays a child until communicate() takes its code.
                ended = os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOWAIT).si_pid
                process, task = running.pop(ended)
                self._wait(process, f"task {task}")
                yield self._read(task, by)
        finally:
            self.stop([process for process, _ in running.values()])


def tell(words):
    print(f"{NAME}: {words}", file=sys.stderr, flush=True)


def grouped(number):
    return f"{number:,}".replace(",", " ")


def students_t(degrees):
    """The 97.5 % quantile of Student's t, by the expansion of Cornish and Fisher."""
    z = statistics.NormalDist().inv_cdf(0.975)
    return (z + (z**3 + z) / (4 * degrees) + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * degrees**2)
            + (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384 * degrees**3))


def estimated(values, tasks):
    """The sum over all tasks, from some that were drawn at random: what is likely, and the ends of its 95 % interval."""
    count, total = len(values), statistics.fmean(values) * tasks
    error = math.sqrt((1 - count / tasks) / count * statistics.variance(values)) * tasks * students_t(count - 1)
    return total, max(total - error, sum(values)), total + error


def cost(made):
    """What a triangle of some tasks took, in words."""
    microseconds = 1e6 * sum(one.cpu for one in made) / max(sum(one.triangles for one in made), 1)
    return f"{microseconds:.2f} microseconds a triangle"


def summary(record):
    """How far a record is, as lines."""
    made = list(record.made.values())
    if not made:
        return [f"{record.folder} has no task yet; --resume makes some"]
    triangles, cpu = sum(one.triangles for one in made), sum(one.cpu for one in made)
    memory = [one.memory for one in made]
    lines = [f"{len(made)} of {record.tasks} tasks are made: {grouped(triangles)} triangles in {cpu / 3600:.2f} CPU hours, "
             f"{cost(made)}, {statistics.median(memory):.0f} MiB a task in the median and {max(memory)} at most"]
    if len(made) == record.tasks:
        in_order = [record.made[task] for task in sorted(record.made)]
        corners = [list(map(float, one.box.split(" "))) for one in made if one.box != "-"]
        box = [f(corner[i] for corner in corners) for f, i in zip([min] * 3 + [max] * 3, range(6))]
        hashes = hashlib.sha256("".join(one.sha256 for one in in_order).encode()).hexdigest()
        lines += [f"it is whole: {grouped(sum(one.points for one in made))} points, the box {' '.join(f'{x:.6g}' for x in box)}",
                  f"SHA-256 of the hashes of all tiles: {hashes}"]
    elif len(made) >= LEAST_FOR_INTERVAL:
        whole, low, high = (end / 1e9 for end in estimated([one.triangles for one in made], record.tasks))
        hours, least, most = (end / 3600 for end in estimated([one.cpu for one in made], record.tasks))
        lines.append(f"the whole, with 95 % intervals: {whole:.4g} billion triangles ({low:.4g} to {high:.4g}), {hours:.3g} CPU "
                     f"hours ({least:.3g} to {most:.3g})")
    if record.torn:
        lines.append(f"the last line of {record.folder / TASKS} has no end and is not counted; --resume makes its task again")
    for number, (version, machine) in record.makers.items():
        theirs = [one for one in made if one.by == number]
        lines.append(f"{len(theirs)} of them by {version} on {machine}, {cost(theirs)}")
    return lines


def compare(record, plan, tasks, jobs):
    """Makes recorded tasks again. @return those that differ, in words"""
    different = []
    with contextlib.closing(plan.make(tasks, jobs)) as again:
        for made in again:
            known = record.made[made.task]
            if made.counted == known.counted:
                tell(f"task {made.task} is the same: {grouped(made.triangles)} triangles")
            else:
                different.append(f"task {made.task} has {known.triangles} triangles and the hash {known.sha256} in "
                                 f"{record.folder / TASKS}, and {made.triangles} and {made.sha256} as {plan.runner.version} "
                                 "makes it now")
                tell(different[-1])
    return different


def require_recipe(record, plan):
    for name, value in plan.recipe.items():
        if record.recipe.get(name) != value:
            raise Refused(f"'{name}' is '{record.recipe.get(name)}' in {record.folder / RECIPE} and '{value}' now; take the mesh "
                          "and the program of the record, or begin another one with --record FOLDER")


def resume(record, plan, jobs, seed, most, until):
    with record.writing():
        if record.recipe:
            require_recipe(record, plan)
        else:
            record.begin(plan.recipe)
        different = compare(record, plan, shuffled(record.made, seed)[:CHECKED], jobs)
        if different:
            raise Refused(different[0] + "; the counts of a record hold for the program that made them: go on with that one, or "
                          "begin another record with --record FOLDER")
        by = record.number_of((plan.runner.version, harness.machine()))
        left = shuffled(set(range(1, record.tasks + 1)) - set(record.made), SHUFFLE)[:most]
        with contextlib.closing(plan.make(left, jobs, by, until)) as tasks:
            for made in tasks:
                record.add(made)
                tell(f"[{len(record.made)}/{record.tasks}] task {made.task}: {grouped(made.triangles)} triangles, {made.cpu:.1f} "
                     f"CPU s, {made.memory} MiB")


def run(options, runner):
    """@throw Refused"""
    began = time.monotonic()
    record = Record(options.record)
    if options.verify and not record.made:
        raise Refused(f"{record.folder} has no task to be made again; --resume makes some")
    if not (options.resume or options.verify):
        print("\n".join(summary(record)))
        return True
    until = began + 60 * options.minutes if options.minutes else math.inf
    work = pathlib.Path(tempfile.mkdtemp(prefix=f".{NAME}.", dir=options.into))
    try:
        mesh = meshes.prepare(("bunny",), options.mesh, options.into / ".meshes" / options.size.name, runner)["bunny"]
        tell(f"juliavdb plan tiles {shlex.quote(str(mesh.path))} {options_of(options.size)}")
        plan = Plan(runner, mesh, options.size, work / "plan")
        if options.resume:
            try:
                resume(record, plan, options.jobs, options.seed, options.tasks, until)
            finally:
                print("\n".join(summary(record)), flush=True)
            return True
        require_recipe(record, plan)
        tasks = shuffled(record.made, options.seed)[:options.verify]
        different = compare(record, plan, tasks, options.jobs)
        print(f"{len(tasks) - len(different)} of {len(tasks)} tasks are the same as in {record.folder}, drawn with --seed "
              f"{options.seed}")
        return not different
    finally:
        shutil.rmtree(work, ignore_errors=True)

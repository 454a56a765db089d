# SPDX-License-Identifier: Apache-2.0
"""What an entry of reproduce/ is, how its commands run, and how its result is kept.

An entry is declared by its commands alone, so that they are known without running them: that is what makes a run resumable.
A result is a folder, results/NAME, that appears by one rename when all commands of the entry have succeeded. It holds
result.json, which has everything that the commands said, and the tables and pictures that are made of it.
"""
import csv
import dataclasses
import datetime
import hashlib
import io
import json
import os
import pathlib
import platform
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable

ROOT = pathlib.Path(__file__).resolve().parent.parent
SIZES = ("small", "medium", "full")
FORMAT = 1

# Each command of the program tells its numbers as one event at its end. The function adds the option for that, so that the
# commands of the page stay those that a reader types. It leaves what is not of the program, and --help and the like, alone.
SHELL = """set -euo pipefail
juliavdb() {
  case ${1-} in
    -*) command juliavdb "$@" ;;
    *) command juliavdb "$@" --progress json ;;
  esac
}
"""


@dataclasses.dataclass(frozen=True)
class Size:
    """How large a run is. The full size is that of the papers where one machine can do it."""
    name: str

    def pick(self, small, medium, full):
        return {"small": small, "medium": medium, "full": full}[self.name]


@dataclasses.dataclass(frozen=True)
class Step:
    """Commands of an entry that are measured together.

    @param label    names them within the entry
    @param command  lines for bash, in the folder of the entry, after those of the steps before
    @param keep     files that the command writes and whose text the tables are made of
    """
    label: str
    command: str
    keep: tuple = ()


@dataclasses.dataclass(frozen=True)
class Value:
    """One number of a table.

    @param case      the row: what was measured
    @param quantity  the column, with its unit
    @param ours      what this run found
    @param paper     what the paper has: a number, words, or None if it has nothing
    @param compared  whether both mean the same, so that their ratio does too
    """
    case: str
    quantity: str
    ours: object
    paper: object = None
    compared: bool = True

    @property
    def ratio(self):
        numbers = all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in (self.ours, self.paper))
        return self.ours / self.paper if self.compared and numbers and self.paper else None


@dataclasses.dataclass(frozen=True)
class Entry:
    """A figure or a table.

    @param name      by which the command line knows it
    @param paper     the key of docs/references.md, or "" for an ablation
    @param item      the table or figure, or what was ablated
    @param title     what it shows, in a few words
    @param steps     (size) -> the commands
    @param table     (outputs by label, size) -> the numbers
    @param meshes    names of meshes.SOURCES that the commands read
    @param needs     program:NAME and python:MODULE without which the entry cannot run, or a function (size) -> these
    @param remarks   what differs from the paper, as sentences
    """
    name: str
    paper: str
    item: str
    title: str
    steps: Callable
    table: Callable
    meshes: tuple = ()
    needs: object = ()
    remarks: str = ""

    @property
    def source(self):
        return f"[{self.paper}] {self.item}" if self.paper else f"Ablation: {self.item}"


class StepFailed(Exception):
    """A command of an entry did not succeed."""


class WrongProgram(Exception):
    """A file that can be executed, but is not juliavdb."""


class Output:
    """What the commands of a step did."""

    def __init__(self, data):
        self.data = data
        self.stdout, self.kept = data["stdout"], data["kept"]
        self.cpu, self.wall, self.memory = data["cpu"], data["wall"], data["memory"]

    @property
    def events(self):
        return self.data["events"]

    @property
    def counts(self):
        """The numbers of the last command of the program."""
        return self.events[-1]["counts"]

    @property
    def said(self):
        return " ".join(message for event in self.events for message in event.get("messages", []))

    def number(self, pattern, among=None):
        """The number in what the program said, after the words of the pattern."""
        found = re.search(pattern + r"\s*(-?[\d.]+(?:e[-+]?\d+)?)", among or self.said)
        if not found:
            raise ValueError(f"'{self.data['label']}' did not say '{pattern}', but: {self.said or self.stdout}")
        return float(found.group(1))

    def json(self):
        return json.loads(self.stdout)

    def table(self, name):
        """The rows of a CSV file that was kept, as dictionaries of numbers."""
        return [{key: float(value) if value else None for key, value in row.items()}
                for row in csv.DictReader(io.StringIO(self.kept[name]))]


def sha256(path):
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        for block in iter(lambda: file.read(1 << 20), b""):
            digest.update(block)
    return digest.hexdigest()


def machine():
    """The machine in words: its processor, how many of it, its memory and its system."""
    said = dict(re.findall(r"^(\S[^\t:]*?)\s*: (.*)$", pathlib.Path("/proc/cpuinfo").read_text(), re.M))
    # Processors of one name may differ in what they do at a time.
    kind = f" (family {said['cpu family']}, model {said['model']})" if {"cpu family", "model"} <= said.keys() else ""
    memory = re.search(r"^MemTotal:\s*(\d+)", pathlib.Path("/proc/meminfo").read_text(), re.M)
    cores = len(os.sched_getaffinity(0))
    try:
        system = platform.freedesktop_os_release().get("PRETTY_NAME", platform.system())
    except OSError:
        system = platform.system()
    return (f"{said.get('model name', platform.machine())}{kind}, {cores} processor{'s' if cores > 1 else ''}, "
            f"{int(memory.group(1)) / 2**20:.0f} GiB, {system}")


class Runner:
    """Runs the commands of entries in folders of their own.

    @param program  the path of juliavdb
    @param folder   where the results go
    @param size     a Size
    """

    def __init__(self, program, folder, size):
        self.program, self.folder, self.size = program, folder, size
        asked = subprocess.run([program, "--version"], capture_output=True, text=True)
        self.version = asked.stdout.strip()
        if asked.returncode or not self.version.startswith("juliavdb "):
            said = (self.version or asked.stderr.strip() or "nothing").splitlines()[0]
            raise WrongProgram(f"{program} is not juliavdb: its --version says '{said}'; set JULIAVDB to the path of juliavdb")

    def environment(self, meshes):
        python = self.program.parent.parent / "python"
        found = {**os.environ, "PATH": os.pathsep.join([str(self.program.parent), str(self.program.parent.parent / "bench"),
                                                        os.environ["PATH"]]),
                 "JULIAVDB": str(self.program), "PYTHONDONTWRITEBYTECODE": "1"}
        if python.is_dir():
            found["PYTHONPATH"] = os.pathsep.join(filter(None, [str(python), os.environ.get("PYTHONPATH")]))
        return {**found, **{name: str(mesh.path) for name, mesh in meshes.items()}}

    def key(self, entry, meshes):
        """Changes if and only if the entry has to run again."""
        steps = [dataclasses.asdict(step) for step in entry.steps(self.size)]
        tools = {name: sha256(ROOT / name) for step in entry.steps(self.size)
                 for name in set(re.findall(r"\b(?:reproduce/(?:tools|shapes|data)[\w/.-]*|docs/make-[a-z]+)", step.command))}
        if any(name.startswith("docs/make-gallery") for name in tools):
            tools["docs/gallery.md"] = sha256(ROOT / "docs/gallery.md")
        inputs = {name: mesh.hash for name, mesh in meshes.items()}
        text = json.dumps([FORMAT, self.size.name, self.version, steps, inputs, tools], sort_keys=True, default=list)
        return hashlib.sha256(text.encode()).hexdigest()

    def stored(self, entry):
        """The result of the entry that is there, or None."""
        try:
            return json.loads((self.folder / entry.name / "result.json").read_text())
        except (FileNotFoundError, NotADirectoryError, json.JSONDecodeError):
            return None

    def run(self, entry, meshes, tell):
        """Runs the commands and puts the result in its place.
        @throw StepFailed"""
        work = pathlib.Path(tempfile.mkdtemp(prefix=f".{entry.name}.", dir=self.folder))
        try:
            # Commands name scripts of the project as if they ran in its root.
            for name in ("docs", "reproduce"):
                (work / name).symlink_to(ROOT / name)
            began = datetime.datetime.now().astimezone()
            outputs = []
            for step in entry.steps(self.size):
                tell(step.label)
                outputs.append(self._run(step, work, self.environment(meshes)))
            result = {"format": FORMAT, "entry": entry.name, "key": self.key(entry, meshes), "size": self.size.name,
                      "version": self.version, "date": began.isoformat(timespec="seconds"), "machine": machine(),
                      "inputs": {name: {"sha256": mesh.hash, "origin": mesh.origin} for name, mesh in meshes.items()},
                      "steps": outputs}
            made = pathlib.Path(tempfile.mkdtemp(prefix=".made.", dir=self.folder))
            for picture in sorted(work.glob("*.png")):
                shutil.move(picture, made / picture.name)
            result["pictures"] = sorted(picture.name for picture in made.iterdir())
            (made / "result.json").write_text(json.dumps(result, indent=1) + "\n")
            made.chmod(0o755)
            place = self.folder / entry.name
            if place.exists():
                place.rename(work / "before")
            made.rename(place)
            return result
        finally:
            shutil.rmtree(work, ignore_errors=True)

    def _run(self, step, work, environment):
        with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
            clock = time.monotonic()
            process = subprocess.Popen(["bash", "-c", SHELL + step.command], cwd=work, env=environment, stdin=subprocess.DEVNULL,
                                       stdout=out, stderr=err, start_new_session=True)
            try:
                _, status, usage = os.wait4(process.pid, 0)
                process.returncode = os.waitstatus_to_exitcode(status)
            except BaseException:
                os.killpg(process.pid, signal.SIGTERM)
                process.wait()
                raise
            wall = time.monotonic() - clock
            out.seek(0)
            err.seek(0)
            stdout, stderr = out.read(), err.read()
        events, words = [], []
        for line in stderr.splitlines():
            try:
                event = json.loads(line)
                if event["event"] == "end":
                    events.append({name: event.get(name) for name in ("command", "counts", "messages", "cpu", "wall", "phases", "error")
                                   if event.get(name) is not None})
            except (json.JSONDecodeError, TypeError, KeyError):
                words.append(line)
        if process.returncode:
            said = [event["error"] for event in events if "error" in event] + words
            raise StepFailed(f"the command of '{step.label}' ended with code {process.returncode}\n"
                             + "".join(f"    {line}\n" for line in step.command.strip().splitlines())
                             + "it said:\n" + "".join(f"    {line}\n" for line in said or ["nothing"]))
        missing = [name for name in step.keep if not (work / name).is_file()]
        if missing:
            raise StepFailed(f"the command of '{step.label}' did not write {', '.join(missing)}")
        return {"label": step.label, "command": step.command.strip("\n"), "stdout": stdout, "events": events,
                "kept": {name: (work / name).read_text() for name in step.keep},
                "cpu": round(usage.ru_utime + usage.ru_stime, 3), "wall": round(wall, 3), "memory": usage.ru_maxrss * 1024}

    def values(self, entry, result):
        """The numbers of a result: those of the entry's table, of what its commands said."""
        return entry.table({step["label"]: Output(step) for step in result["steps"]}, Size(result["size"]))

    def missing_needs(self, entry):
        """Of what the entry needs beside the program, what is not there, in words."""
        environment, missing = self.environment({}), []
        for need in entry.needs(self.size) if callable(entry.needs) else entry.needs:
            kind, _, name = need.partition(":")
            if kind == "program":
                found = shutil.which(name, path=environment["PATH"])
            else:
                found = not subprocess.run([sys.executable, "-c", f"import {name}"], capture_output=True, env=environment).returncode
            if not found:
                missing.append(f"the {'program' if kind == 'program' else 'Python module'} {name}")
        return missing

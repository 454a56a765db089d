# SPDX-License-Identifier: Apache-2.0
"""Checks that take hours, as lists of pieces: each piece is run once and recorded, and a later run goes on after it.

A check keeps everything in its folder, build/NAME: state.json with the results, and logs/PIECE.log. state.json is replaced as
a whole after each piece, so a run may end at any moment, by whatever means; only the piece that it was at begins anew.
"""
import argparse
import concurrent.futures
import dataclasses
import datetime
import fcntl
import hashlib
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
FORMAT = "long check 1"
PASSED, SKIPPED, FAILED = "passed", "skipped", "failed"
FAILURE, USAGE, BAD_DATA, CANNOT_CREATE, STOPPED = 1, 2, 65, 73, 75
SLICE = 300.0  # seconds that a piece with a goal runs at a time, and so the most that a stop can lose of it
PATIENCE = 30.0  # seconds that a piece has to end when it is told to
PAGES = "*.md"  # no piece depends on them, so a commit that changes nothing else leaves all results valid


class Refused(Exception):
    """What cannot be done, with the exit code for it."""

    def __init__(self, code, message):
        super().__init__(message)
        self.code = code


@dataclasses.dataclass
class Piece:
    """Some commands, which pass if each of them ends with 0."""
    name: str
    commands: list
    environment: dict = dataclasses.field(default_factory=dict)
    # Others stand on it, such as a build. It is made again whenever the check is run, since a build that is up to date costs
    # little and a missing one would cost everything, and when the tree changes. Nothing runs before it has passed.
    basis: bool = False
    # Seconds for which it is to run, in as many parts as one likes. "{seconds}" in its commands is the length of a part.
    goal: float = 0.0
    # Looks at the log after commands that ended with 0. @return the outcome, and facts as a dictionary of numbers
    judge: object = None


@dataclasses.dataclass
class Check:
    name: str
    what: str  # for the table of docs/reliability.md
    unit: str  # what a piece is, in the plural
    pieces: object  # a function that lists the pieces: all of them if its argument is true, otherwise those of the basis
    where: str = ""  # the system and the compiler: a result from elsewhere is another result


def tree_of(root):
    """The last commit of the checkout that changed more than pages, and a hash of what is changed in it beside them, which is
    empty if nothing is. A copy of the files alone, as tools/on-debian makes it, is of the commit that JULIAVDB_COMMIT names."""
    files = ["--", ".", f":(exclude){PAGES}"]

    def git(*words):
        return subprocess.run(["git", "-C", root, *words, *files], capture_output=True, check=True).stdout

    try:
        commit = git("log", "-1", "--abbrev=8", "--format=%h").decode().strip()
        changes = git("diff", "HEAD", "--binary") + git("ls-files", "--others", "--exclude-standard")
    except (OSError, subprocess.CalledProcessError):
        return {"commit": os.environ.get("JULIAVDB_COMMIT") or "unknown", "changes": ""}
    return {"commit": commit, "changes": hashlib.sha256(changes).hexdigest()[:8] if changes else ""}


def file_name(name):
    """Another one for each name: the characters that it should not have are replaced, and a hash tells such names apart."""
    kept = re.sub(r"[^\w.+-]+", "_", name)
    return kept if kept == name else f"{kept}-{hashlib.sha256(name.encode()).hexdigest()[:8]}"


class State:
    """The results of a check, in a file that is replaced as a whole."""

    def __init__(self, folder):
        self.folder = folder
        self.path = folder / "state.json"
        self.runs = {}  # of each piece, the runs that count
        if not self.path.exists():
            return
        try:
            read = json.loads(self.path.read_text())
            if read["format"] != FORMAT:
                raise ValueError(f"its format is '{read['format']}', and this program knows '{FORMAT}'")
            for name, runs in read["pieces"].items():
                for run in runs:
                    if not {"outcome", "seconds", "cpu", "commit", "changes", "where", "date", "log"} <= set(run):
                        raise ValueError(f"the record of '{name}' is not whole")
            self.runs = read["pieces"]
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise Refused(BAD_DATA, f"{self.path} holds no results of a check ({error}); move it away to begin anew") from error

    def save(self):
        text = json.dumps({"format": FORMAT, "pieces": self.runs}, indent=1) + "\n"
        temporary = self.path.with_name("state.json.new")
        with open(temporary, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, self.path)

    def seconds(self, name):
        return sum(run["seconds"] for run in self.runs.get(name, ()))


class Runner:
    """@param jobs  how many pieces run at once. The basis is made piece by piece, with nothing beside it"""

    def __init__(self, check, folder, root=ROOT, jobs=1):
        self.check = check
        self.folder = folder
        self.root = root
        self.jobs = jobs
        self.state = State(folder)
        self.tree = tree_of(root)
        self.signal = 0
        self.made = {}  # for each piece of the basis that this process has made, the tree
        self.known = None  # all pieces, once the basis has passed

    # What is done.

    def is_here(self, run):
        """Whether a run was made on this tree, on this system."""
        return all(run[key] == value for key, value in {**self.tree, "where": self.check.where}.items())

    def outcome(self, piece):
        """The outcome of a piece; None if it has to be run, or run on."""
        runs = self.state.runs.get(piece.name)
        if not runs:
            return None
        if runs[-1]["outcome"] != FAILED and self.state.seconds(piece.name) < piece.goal:
            return None
        return runs[-1]["outcome"]

    def listed(self):
        """@return the pieces, and whether these are all. Tests, for example, are known when they are built."""
        basis = self.check.pieces(False)
        if not all(self.outcome(piece) in (PASSED, SKIPPED) for piece in basis):
            return basis, False
        if self.known is None:
            self.known = self.check.pieces(True)
        return self.known, True

    # Running.

    def forget(self, pattern):
        """Forgets the pieces that failed, or that were run on another tree."""
        for name, runs in list(self.state.runs.items()):
            if pattern.search(name) and (runs[-1]["outcome"] == FAILED or not all(map(self.is_here, runs))):
                del self.state.runs[name]
        self.state.save()

    def next_piece(self, pattern, at_work):
        """@param at_work  the names of the pieces that are being run"""
        self.tree = tree_of(self.root)
        for piece in self.check.pieces(False):
            if self.made.get(piece.name) != self.tree:
                return piece
        left = [piece for piece in self.listed()[0]
                if not piece.basis and piece.name not in at_work and pattern.search(piece.name) and self.outcome(piece) is None]
        # Of those with a goal, the one that had the least, so that all get something if there is little time.
        return min(left, key=lambda piece: self.state.seconds(piece.name) if piece.goal else 0, default=None)

    def run(self, pattern, until):
        """Runs what is left. @return the exit code"""
        at_work = {}  # the pieces that are being run, and their results to come
        stopped, broken = [], False
        with concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
            while True:
                goes_on = not (self.signal or time.monotonic() >= until or broken) and len(at_work) < self.jobs
                piece = self.next_piece(pattern, {each.name for each in at_work.values()}) if goes_on else None
                if piece and not (piece.basis and at_work):
                    at_work[pool.submit(self.run_piece, piece, until)] = piece
                    if not piece.basis:
                        continue
                if not at_work:
                    break
                for result in concurrent.futures.wait(at_work, return_when=concurrent.futures.FIRST_COMPLETED).done:
                    piece, run = at_work.pop(result), result.result()
                    if run is None:
                        stopped.append(piece.name)
                        continue
                    self.keep(piece, run)
                    broken = broken or (piece.basis and run["outcome"] == FAILED)
        if broken:
            return FAILURE
        if stopped or self.signal or time.monotonic() >= until:
            return self.stopped(stopped)
        return self.ended(pattern)

    def keep(self, piece, run):
        if piece.basis:
            self.made[piece.name], self.known = self.tree, None
        kept = self.state.runs.get(piece.name, []) if piece.goal else []
        self.state.runs[piece.name] = kept + [run]
        self.state.save()
        print(f"{self.check.name}: {run['outcome'].upper() if run['outcome'] == FAILED else run['outcome']} "
              f"{piece.name}, {run['seconds']:.0f} s", flush=True)
        if run["outcome"] == FAILED:
            print(f"  {run['log']}", flush=True)
            if piece.basis:
                print(f"{self.check.name}: nothing can be run before '{piece.name}' passes", flush=True)

    def run_piece(self, piece, until):
        """@return the record of what was run; None if it was stopped"""
        tree = self.tree
        part = min(SLICE, piece.goal - self.state.seconds(piece.name), until - time.monotonic()) if piece.goal else 0
        part = max(1, round(part))
        if piece.goal:
            until = time.monotonic() + part + 4 * PATIENCE  # it ends by itself
        log = self.folder / "logs" / (file_name(piece.name) + ".log")
        log.parent.mkdir(parents=True, exist_ok=True)
        begin, clock, cpu, code = time.time(), time.monotonic(), 0.0, 0
        with open(log, "w", encoding="utf-8") as file:
            for command in piece.commands:
                words = [str(word).replace("{seconds}", str(part)) if piece.goal else str(word) for word in command]
                code, used = self.run_command(words, piece.environment, file, until)
                cpu += used
                if code is None or (code and self.signal):  # a machine that goes down ends both
                    return None
                if code:
                    file.write(f"\nended with {code}: {' '.join(words)}\n")
                    break
        outcome, facts = (FAILED, {}) if code else piece.judge(log, begin) if piece.judge else (PASSED, {})
        return {"outcome": outcome, "seconds": round(time.monotonic() - clock, 1), "cpu": round(cpu, 1), **tree,
                "where": self.check.where, "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d"),
                "log": os.path.relpath(log, self.root), **facts}

    def run_command(self, words, environment, log, until):
        """@return the exit code of a command, or None if it was stopped, and the CPU seconds that it took"""
        log.write(f"$ {' '.join(words)}\n")
        log.flush()
        try:  # in a session of its own, so that everything it has started can be ended with it
            process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT, cwd=self.root,
                                       env={**os.environ, **environment}, start_new_session=True)
        except OSError as error:
            log.write(f"{words[0]}: {error.strerror}\n")
            return 127, 0.0

        def waited(over):
            """@return the CPU seconds of the command when it has ended; None if over() is true before"""
            while True:
                number, status, used = os.wait4(process.pid, os.WNOHANG)
                if number:
                    process.returncode = os.waitstatus_to_exitcode(status)
                    return used.ru_utime + used.ru_stime
                if over():
                    return None
                time.sleep(0.05)

        used = waited(lambda: self.signal or time.monotonic() >= until)
        if used is not None:
            return process.returncode, used
        for number in (signal.SIGTERM, signal.SIGKILL):
            try:
                os.killpg(process.pid, number)
            except ProcessLookupError:
                pass
            if process.returncode is None:
                patience = time.monotonic() + PATIENCE
                waited(lambda: time.monotonic() >= patience)
        return None, 0.0

    def stopped(self, names):
        what = " and ".join(f"'{name}'" for name in names)
        at = f" in the middle of {what}, which begin{'' if len(names) > 1 else 's'} anew" if names else ""
        print(f"{self.check.name}: stopped{at}; the same command goes on", flush=True)
        return STOPPED

    def ended(self, pattern):
        pieces, _ = self.listed()
        failed = [piece for piece in pieces if pattern.search(piece.name) and self.outcome(piece) == FAILED]
        for piece in failed:
            print(f"{self.check.name}: FAILED {piece.name}: {self.state.runs[piece.name][-1]['log']}")
        print(f"{self.check.name}: {self.counted(pieces)}", flush=True)
        return FAILURE if failed else 0

    # Telling.

    def counted(self, pieces):
        """How many pieces have passed and so on, in words. The basis does not count."""
        counts = {PASSED: 0, SKIPPED: 0, FAILED: 0, None: 0}
        own = [piece for piece in pieces if not piece.basis]
        for piece in own:
            counts[self.outcome(piece)] += 1
        words = [f"{counts[PASSED]} of {len(own)} {self.check.unit} passed"]
        words += [f"{counts[FAILED]} failed"] if counts[FAILED] else []
        words += [f"{counts[SKIPPED]} skipped"] if counts[SKIPPED] else []
        words += [f"{counts[None]} not yet run to the end"] if counts[None] else []
        return ", ".join(words)

    def others(self, piece):
        """The runs of a piece that were made on another tree."""
        return [run for run in self.state.runs.get(piece.name, ()) if not self.is_here(run)]

    def print_list(self):
        pieces, whole = self.listed()
        for piece in pieces:
            runs = self.state.runs.get(piece.name)
            if not runs:
                print(f"{'-':8} {piece.name}")
                continue
            seconds = f"{self.state.seconds(piece.name):.0f}" + (f" of {piece.goal:.0f}" if piece.goal else "") + " s"
            last = runs[-1]
            print(f"{last['outcome']:8} {piece.name}, {seconds}, {self.name_of(last)}{self.mark(runs)}, {last['log']}")
        if not whole:
            print(f"what comes then is known when '{pieces[-1].name}' has passed")

    def mark(self, runs):
        return "" if all(self.is_here(run) for run in runs) else " (not this tree or system)"

    @staticmethod
    def name_of(run):
        return run["commit"] + ("+changes" if run["changes"] else "")

    def print_status(self):
        pieces, whole = self.listed()
        changed = ", with changes that are not committed" if self.tree["changes"] else ""
        print(f"{self.check.name}: on {self.tree['commit']}{changed}; {self.check.where or 'any system'}")
        print(f"  {self.counted(pieces)}" if whole else f"  what there is to run is known when '{pieces[-1].name}' has passed")
        others = [piece for piece in pieces if not piece.basis and self.others(piece)]
        if others:
            print(f"  {len(others)} of them on another tree or system; --again repeats them")
        for piece in pieces:
            runs = self.state.runs.get(piece.name)
            if runs and runs[-1]["outcome"] == FAILED:
                print(f"  FAILED {piece.name}: {runs[-1]['log']}")

    def row(self):
        """The row of the table in docs/reliability.md."""
        pieces, whole = self.listed()
        own = [piece for piece in pieces if not piece.basis]
        runs = [run for piece in own for run in self.state.runs.get(piece.name, ())]
        what = self.check.what
        if not whole or not runs:
            return f"| {what} | nothing was run | | | |"
        places = sorted({run["where"] for run in runs if run["where"]})
        what += f" ({'; '.join(places)})" if places else ""
        commits = list(dict.fromkeys(self.name_of(run) for run in runs))
        dates = sorted({run["date"] for run in runs})
        many = self.counted(pieces)
        if any(piece.goal for piece in own):
            many += f"; {sum(run['seconds'] for run in runs) / 3600:.1f} h, {sum(run['cpu'] for run in runs) / 3600:.1f} h of CPU"
        facts = sorted({key for run in runs for key, value in run.items() if type(value) is int})
        many += "".join(f"; {sum(run.get(fact, 0) for run in runs):,} {fact}".replace(",", " ") for fact in facts)
        failed = [f"`{piece.name}`" for piece in own if self.outcome(piece) == FAILED]
        cells = (what, many, ", ".join(f"`{name}`" for name in commits), " to ".join(dict.fromkeys((dates[0], dates[-1]))),
                 ", ".join(failed) or "nothing")
        return f"| {' | '.join(cells)} |"


TABLE_HEAD = "| what | how many | commit | date | found |\n|---|---|---|---|---|"


def locked(folder):
    """A lock of the folder, which ends with the process."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        file = open(folder / "lock", "w", encoding="utf-8")
    except OSError as error:
        raise Refused(CANNOT_CREATE, f"{error.filename}: {error.strerror}") from error
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        raise Refused(STOPPED, f"another run is at work in {folder}; wait for its end, or stop it") from error
    return file


def regular(text):
    try:
        return re.compile(text)
    except re.error as error:
        raise argparse.ArgumentTypeError(f"'{text}' is no regular expression: {error}") from error


def count(text):
    if not int(text) > 0:
        raise argparse.ArgumentTypeError(f"'{text}' is no number of pieces; give 1 or more")
    return int(text)


def minutes(text):
    if not float(text) > 0:
        raise argparse.ArgumentTypeError(f"'{text}' is no time; give minutes above 0")
    return float(text)


def add_options(parser):
    parser.add_argument("--again", action="store_true", help="repeat what failed, and what was run on another commit or system")
    parser.add_argument("--minutes", type=minutes, default=float("inf"), metavar="M", help="stop after so many minutes")
    parser.add_argument("--jobs", type=count, default=len(os.sched_getaffinity(0)), metavar="N",
                        help="how many pieces run at once; one for each processor if not given")
    parser.add_argument("--only", type=regular, default=re.compile(""), metavar="REGEX", help="only pieces whose names match")
    parser.add_argument("--into", type=pathlib.Path, default=ROOT / "build", metavar="FOLDER", help="in place of build")
    telling = parser.add_mutually_exclusive_group()
    telling.add_argument("--list", action="store_true", help="run nothing: print the pieces, each with its result")
    telling.add_argument("--status", action="store_true", help="run nothing: print what is done")
    telling.add_argument("--table", action="store_true", help="run nothing: print the row for docs/reliability.md")


def work(checks, options, root=ROOT):
    """Runs the checks, or tells of them. @return the exit code"""
    until = time.monotonic() + 60 * options.minutes
    if options.table:
        print(TABLE_HEAD)
    codes = []
    for check in checks:
        folder = (options.into / check.name).resolve()
        if options.list or options.status or options.table:
            runner = Runner(check, folder, root)
            if options.table:
                print(runner.row())
            else:
                (runner.print_list if options.list else runner.print_status)()
            continue
        with locked(folder):
            runner = Runner(check, folder, root, options.jobs)
            if runner.tree["changes"]:
                print(f"{check.name}: this tree has changes that are not committed; results say "
                      f"'{runner.tree['commit']}+changes'", flush=True)

            def stop(number, _, runner=runner):
                runner.signal = number

            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                signal.signal(number, stop)
            if options.again:
                runner.forget(options.only)
            codes.append(runner.run(options.only, until))
            if codes[-1] == STOPPED:
                break
    return STOPPED if STOPPED in codes else max(codes, default=0)


def guarded(function, name):
    """Ends the process with what the function returns, or with one line."""
    try:
        code = function()
        sys.stdout.flush()
    except Refused as refusal:
        print(f"{name}: {refusal}", file=sys.stderr)
        code = refusal.code
    except OSError as error:
        print(f"{name}: {error.filename or ''}: {error.strerror}", file=sys.stderr)
        code = 74
    sys.exit(code)

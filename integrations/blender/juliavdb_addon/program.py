# SPDX-License-Identifier: Apache-2.0
"""The program `juliavdb` as a child process. Nothing here knows Blender."""

import json
import queue
import subprocess
import threading

# The exit code of a run that was interrupted (docs/progress.md).
INTERRUPTED = 75

# How long a query that does no work may take, in seconds.
QUICK = 20


class ProgramError(Exception):
    """What went wrong, in one line for the user."""


def _started(command, **options):
    try:
        return subprocess.Popen(command, stdin=subprocess.DEVNULL, **options)
    except OSError as error:
        raise ProgramError(f"The program '{command[0]}' cannot be started ({error.strerror}). "
                           "Set its path in the preferences of the add-on.") from error


def answer(program, *words):
    """What the program writes on stdout.

    Raises ProgramError if it cannot be started or fails.
    """
    process = _started([program, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        said, complained = process.communicate(timeout=QUICK)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        raise ProgramError(f"'{program} {' '.join(words)}' did not answer within {QUICK} seconds") from None
    if process.returncode:
        raise ProgramError(complained.strip() or f"'{program}' ended with the code {process.returncode}")
    return said


def version(program):
    """Such as 'juliavdb 1.0.0'."""
    return answer(program, "--version").strip()


def textures(program):
    """The textures that have a name, each a dict with `name`, `description` and whether a `seed` varies it."""
    return json.loads(answer(program, "versor", "list", "--json"))


def options(program):
    """The options of a recipe: a dict of name (without dashes) to whether the option is a flag. None of them writes. A
    recipe calls a texture a versor, and its options have both names."""
    listed = json.loads(answer(program, "maps", "--json"))["options"]
    flags = {option["name"]: option["argument"] == "" for option in listed}
    return {**flags, **{name.replace("versor", "texture", 1): flag for name, flag in flags.items()}}


def described(text):
    """The options of a command by their names, from what it says with `--describe json`."""
    return {option["name"]: option for group in json.loads(text)["groups"] for option in group["options"]}


class Run:
    """One run of the program in the background.

    A thread collects what the program writes; poll() evaluates it, in the thread of the caller.
    """

    def __init__(self, program, words):
        """Starts it; the words are a command and its options.

        Raises ProgramError if the program cannot be started.
        """
        self.share = 0.0     # the part that is done, 0 to 1
        self.phase = ""      # what is being done
        self.left = None     # seconds to the end, if that can be told
        self.end = {}        # the closing event
        self.cancelled = False
        self._last_words = ""
        self._lines = queue.SimpleQueue()
        self._process = _started([program, *words, "--progress", "json"], stdout=subprocess.DEVNULL,
                                 stderr=subprocess.PIPE, text=True, errors="replace")
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        with self._process.stderr as stderr:
            for line in stderr:
                self._lines.put(line)

    def poll(self):
        """None while the program runs, then its exit code; negative if a signal ended it."""
        ended = not self._reader.is_alive() and self._process.poll() is not None
        while not self._lines.empty():
            self._take(self._lines.get())
        return self._process.returncode if ended else None

    def _take(self, line):
        try:
            event = json.loads(line)
            kind = event["event"]
        except (ValueError, TypeError, KeyError):
            # Before it has read its options, the program may complain in plain text.
            self._last_words = line.strip() or self._last_words
            return
        self.share = event.get("share", self.share)
        self.phase = event.get("phase", self.phase)
        self.left = event.get("left")
        if kind == "end":
            self.end = event

    def error(self):
        """One line about why the program failed. To be called after poll() has given its exit code."""
        return (self.end.get("error") or self._last_words
                or f"juliavdb ended with the code {self._process.returncode} and said nothing")

    def cancel(self):
        """Asks the program to stop; it removes what it has begun. poll() tells when it has ended."""
        self.cancelled = True
        if self._process.poll() is None:
            self._process.terminate()

    def stop(self, patience=5):
        """Cancels, and returns when the program has ended. After `patience` seconds it is killed."""
        self.cancel()
        try:
            self._process.wait(patience)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._reader.join()

# SPDX-License-Identifier: Apache-2.0
"""Help in parts, and what the program says to words that were misspelt or left out."""

import fcntl
import os
import pty
import re
import struct
import subprocess
import termios

import harness
from harness import DONE, USAGE


def described(text):
    """The options that a help describes, not only names."""
    return set(re.findall(r"^  (?:-\w \[ )?--([a-z0-9-]+)", text, re.MULTILINE))


class Help(harness.CliTest):

    # Promise: "Every command has a `--help` ..."
    def test_the_short_help_names_all_that_the_long_one_describes(self):
        for command in (["fractal"], ["sheet"], ["slice"], ["render"], ["study"], ["plan", "tiles"], ["plan", "frames"]):
            with self.subTest(command=command):
                short, full = (self.ok(*command, "--help", *topic, data=True) for topic in ([], ["all"]))
                everything = described(full)
                self.assertGreater(len(everything), 40)
                self.assertLess(len(described(short)), len(everything) / 2)
                self.assertLess(len(short.splitlines()), len(full.splitlines()) / 2)
                self.assertEqual(set(re.findall(r"--([a-z][a-z0-9-]*)", full)) & everything - {"all"},
                                 set(re.findall(r"--([a-z][a-z0-9-]*)", short)) & everything)
                for option in ("detail", "resolution", "output"):
                    self.assertIn(option, described(short))

    # Promise: "Every command has a `--help` ..."
    def test_groups_hold_every_option_once(self):
        short = self.ok("fractal", "--help", data=True)
        groups = re.findall(r"^  ([a-z]+) +--", short.split("More options")[1], re.MULTILINE)
        self.assertGreater(len(groups), 5)
        full = self.ok("fractal", "--help", "all", data=True)
        found = [option for group in groups for option in described(self.ok("fractal", "--help", group, data=True))]
        self.assertEqual(len(found), len(set(found)))
        # The command's own options stand in the short help and in no group.
        own = described(full.split("\nTarget:\n")[0])
        self.assertEqual(set(found) | own, described(full))
        self.assertLessEqual(own, described(short))

    def test_one_option_and_other_ways_to_ask(self):
        one = self.ok("fractal", "--help", "mask", data=True)
        self.assertEqual(described(one), {"mask"})
        self.assertEqual(self.ok("fractal", "--help", "--mask", data=True), one)
        self.assertEqual(self.ok("help", "fractal", "mask", data=True), one)
        self.assertEqual(self.ok("fractal", "--help=mask", data=True), one)
        group = self.ok("fractal", "-h", "space", data=True)
        self.assertEqual(self.ok("fractal", "--help", "Space", data=True), group)
        short = self.ok("fractal", "--help", data=True)
        self.assertEqual(self.ok("fractal", "bunny.obj", "--nonsense", "--help", data=True), short)
        self.assertEqual(self.ok("fractal", "--help", "bunny.obj", data=True), short)
        self.assertEqual(self.ok("help", "plan", "tiles", data=True), self.ok("plan", "tiles", "--help", data=True))

    def test_a_small_command_shows_all(self):
        for command in ("sdf", "mesh", "info", "merge"):
            self.assertEqual(self.ok(command, "--help", data=True), self.ok(command, "--help", "all", data=True))

    def test_it_is_as_wide_as_the_terminal(self):
        def shown(columns, *arguments):
            ours, theirs = pty.openpty()
            fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 50, columns, 0, 0))
            process = subprocess.Popen([harness.program(), *arguments], stdout=theirs, stdin=subprocess.DEVNULL)
            os.close(theirs)
            text = b""
            while True:
                try:
                    piece = os.read(ours, 65536)
                except OSError:  # how a terminal ends
                    break
                if not piece:
                    break
                text += piece
            os.close(ours)
            self.assertEqual(process.wait(), 0)
            return text.decode().replace("\r\n", "\n")

        for command in ("sheet", "plan", "render"):
            piped = self.ok(command, "--help", data=True)
            for columns in (60, 72, 100, 120, 300):
                with self.subTest(command=command, columns=columns):
                    text = shown(columns, command, "--help")
                    self.assertEqual(text.split(), piped.split())
                    prose = text.split("\nExamples:\n")[0].split("\n\n", 1)[1]
                    self.assertLessEqual(max(len(line.rstrip()) for line in prose.splitlines()), min(columns, 120))
                    self.assertGreater(max(len(line.rstrip()) for line in prose.splitlines()), min(columns, 120) - 20)

    def test_topics_that_are_none(self):
        self.refused(USAGE, "fractal", "--help", "tagret", mentions=["tagret", "'target'"])
        self.refused(USAGE, "help", "frctal", mentions="'fractal'")

    # Promise of design.md: "A reader that closes the pipe early is no failure for help, and code 74 for data"
    def test_a_reader_that_has_seen_enough(self):
        for words in (["--help"], ["fractal", "--help", "all"], ["help", "sheet"]):
            with self.subTest(words=words):
                reader, writer = os.pipe()
                os.close(reader)
                try:
                    run = self.run_program(*words, stdout=writer)
                finally:
                    os.close(writer)
                self.assertEqual((run.returncode, run.stderr), (DONE, b""))


class WordsThatAreWrong(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(2)))

    # Promise: "Options have no abbreviations"; a word ...
    def test_did_you_mean(self):
        self.refused(USAGE, "frctal", mentions=["frctal", "did you mean 'fractal'?"])
        self.refused(USAGE, "plan", "tile", mentions="did you mean 'tiles'?")
        self.refused(USAGE, "man", "rendre", mentions="did you mean 'render'?")
        self.refused(USAGE, "versor", "inpsect", mentions="did you mean 'inspect'?")
        job = ("fractal", "s.obj", "-o", "x.vdb")
        self.refused(USAGE, *job, "--detial", "0.3", mentions="did you mean '--detail'?")
        self.refused(USAGE, *job, "--detial=0.3", mentions="did you mean '--detail'?")
        self.refused(USAGE, *job, "--map", "quadratc", mentions="did you mean 'quadratic'?")
        self.refused(USAGE, *job, "--sampling", "trilinaer", mentions="did you mean 'trilinear'?")
        self.refused(USAGE, *job, "--texture", "scaels", mentions="did you mean 'scales'?")
        self.refused(USAGE, *job, "--progress", "jsn", mentions="did you mean 'json'?")
        self.refused(USAGE, *job, "--instructions", "AVX2", mentions="did you mean 'avx2'?")
        self.write("options.txt", "detial = 0.3\n")
        self.refused(USAGE, *job, "--config", "options.txt", mentions="detial")
        # Nothing is near: nothing is guessed.
        run = self.run_program(*job, "--zzzzz", "1")
        self.assertEqual(run.returncode, USAGE)
        self.assertNotIn(b"did you mean", run.stderr)

    def test_values_that_are_missing(self):
        job = ("fractal", "s.obj", "-o", "x.vdb")
        self.refused(USAGE, *job, "--beta", "--progress", "none", mentions=["--beta has no value", "'--progress'"])
        self.refused(USAGE, *job, "--detail", mentions=["--detail has no value", "last word"])
        self.refused(USAGE, *job, "--resolution=", mentions=["--resolution has no value", "equals sign"])
        self.refused(USAGE, "fractal", "s.obj", "-o", mentions="-o has no value")
        self.refused(USAGE, "fractal", "s.obj", "-o", "--half", mentions=["-o has no value", "'--half'"])
        self.refused(USAGE, "versor", "new", "--seed", "-o", "x.json", mentions=["--seed has no value", "'-o'"])
        self.refused(USAGE, "info", "s.obj", "--threads", mentions="--threads has no value")
        self.assertEqual(self.listing(), ["s.obj"])

    def test_words_too_many(self):
        self.refused(USAGE, "fractal", "s.obj", "t.obj", "-o", "x.vdb", "--detail", "0.3",
                     mentions=["too many", "'s.obj', 't.obj'"])
        self.refused(USAGE, "fractal", "s.obj", "-o", "x.vdb", "--alpha", 24, "--alpha", 25,
                     mentions=["--alpha", "twice"])
        self.refused(USAGE, "fractal", "s.obj", "-o", "x.vdb", "-o", "y.vdb", mentions="twice")

    def test_values_that_look_like_options(self):
        self.ok("fractal", "s.obj", "-o", "x.vdb", "--resolution", 20, "--sdf-resolution", 20, "--slice", "-0.05")
        self.ok("fractal", "s.obj", "-ox.vdb", "--resolution", 20, "--sdf-resolution", 20, "--beta=-0.05")


if __name__ == "__main__":
    harness.main()

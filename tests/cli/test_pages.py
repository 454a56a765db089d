# SPDX-License-Identifier: Apache-2.0
"""The manual pages and the completion: that they are well formed, and that they say what --help says."""

import json
import os
import re
import shutil
import subprocess
import unittest

import harness
from harness import USAGE

SHELL = r"""
source ./juliavdb.bash
while IFS= read -r line; do
  IFS=' ' read -r -a COMP_WORDS <<<"$line"
  [[ $line == *' ' ]] && COMP_WORDS+=("")
  COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
  _juliavdb
  echo "${COMPREPLY[*]}"
done
"""


class Pages(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.ok("man", "-o", "man1")

    def commands(self):
        text = self.ok("--help", data=True)
        return re.findall(r"^  (\w+) ", text.split("Commands:")[1], re.MULTILINE)

    # Promise: "Every command has a `--help` ..."
    def test_every_command_has_a_page_with_all_its_options(self):
        names = [p.stem for p in self.path("man1").iterdir()]
        self.assertIn("juliavdb", names)
        for command in self.commands():
            self.assertIn(f"juliavdb-{command}", names)
        for name in names:
            if name == "juliavdb":
                continue
            with self.subTest(page=name):
                words = name.split("-")[1:]
                page = self.bytes(f"man1/{name}.1").decode()
                self.assertEqual(self.ok("man", *words, data=True), page)
                told = self.ok(*words, "--help", "all", data=True)
                options = set(re.findall(r"^  (?:-\w \[ )?--([a-z0-9-]+)", told, re.MULTILINE))
                shown = set(re.findall(r"^(?:\\fB\\-\w\\fR, )?\\fB\\-\\-([a-z0-9\\-]+)\\fR", page, re.MULTILINE))
                self.assertEqual({option.replace("\\", "") for option in shown}, options)

    @unittest.skipUnless(shutil.which("groff"), "there is no groff")
    def test_the_pages_are_well_formed(self):
        for page in sorted(self.path("man1").iterdir()):
            with self.subTest(page=page.name):
                run = subprocess.run(["groff", "-man", "-ww", "-Tascii", str(page)], capture_output=True, timeout=60)
                self.assertEqual((run.returncode, run.stderr), (0, b""))
                text = re.sub(rb"\x1b\[\d*m|.\x08", b"", run.stdout).decode()
                self.assertIn(page.stem + " - ", text)
                self.assertIn("SEE ALSO" if page.stem != "juliavdb" else "EXIT STATUS", text)
                self.assertIn("ENVIRONMENT", text)
                self.assertIn("JULIAVDB_MEMORY", text)
                self.assertEqual("PARALLEL_SEQ" in text, page.stem in ("juliavdb", "juliavdb-task"))

    def test_a_page_of_nothing_is_refused(self):
        self.refused(USAGE, "man", "nothing", mentions="nothing")
        self.refused(USAGE, "man", "fractal", "-o", "x")
        self.refused(USAGE, "fractal", "--describe", "poem", mentions="poem")


class Description(harness.CliTest):
    """What the program says of its options to other programs."""

    def test_it_has_the_options_of_the_manual_page(self):
        self.ok("man", "-o", "man1")
        for page in sorted(self.path("man1").iterdir()):
            words = page.stem.split("-")[1:]
            if not words:
                continue
            with self.subTest(page=page.name):
                said = json.loads(self.ok(*words, "--describe", "json", data=True))
                self.assertEqual(said["command"], " ".join(words))
                shown = re.findall(r"^\.SS (.*)$", page.read_text(), re.MULTILINE)
                self.assertEqual([group["heading"] for group in said["groups"]], shown)
                options = [option for group in said["groups"] for option in group["options"]]
                written = re.findall(r"^\\fB(?:\\-(\w)\\fR, \\fB)?\\-\\-([a-z0-9\\-]+)\\fR(?: \\fI(.*)\\fR)?$",
                                     page.read_text(), re.MULTILINE)
                self.assertEqual([(option.get("letter", ""), option["name"], option["argument"]) for option in options],
                                 [tuple(part.replace("\\-", "-").replace("\\(aq", "'") for part in parts)
                                  for parts in written])
                for option in options:
                    self.assertTrue(option["help"], option["name"])

    def test_a_default_that_is_typed_changes_nothing(self):
        """Of the commands that say theirs in tables."""
        self.write("s.obj", harness.obj(harness.lumpy()))
        self.write("t.ply", harness.ply_text(harness.torus()))
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 16)
        runs = {"print": (("s.vdb", "-o", "a.ply", "--longest-side", 60, "--min-thickness", 9, "--resolution", 20), "a.ply"),
                "points": (("s.obj", "-o", "a.ply", "--points", 50), "a.ply"),
                "usd": (("s.vdb", "--frames", "1-2", "-o", "a.usda"), "a.usda"),
                "versor": (("new", "-o", "a.json"), "a.json")}
        for command, (words, output) in runs.items():
            self.ok(command, *words)
            made = self.bytes(output)
            said = json.loads(self.ok(command, "--describe", "json", data=True))
            defaults = {option["name"]: option["default"] for group in said["groups"] for option in group["options"]
                        if "default" in option}
            self.assertTrue(defaults, command)
            for name, value in defaults.items():
                if command == "versor" and name in ("centre", "radius"):
                    continue  # of a cluster
                with self.subTest(command=command, option=name):
                    self.ok(command, *words, f"--{name}={value}")
                    self.assertEqual(self.without_note(self.bytes(output)), self.without_note(made))

    @staticmethod
    def without_note(data):
        """A file without the command that made it."""
        return re.sub(rb'\n *"note": [^\n]*\n', b"\n", data)


class Completion(harness.CliTest):

    def complete(self, *lines):
        self.write("juliavdb.bash", self.ok("completion", data=True))
        run = subprocess.run(["bash", "--norc", "-c", SHELL], input="\n".join(lines) + "\n", cwd=self.folder, text=True,
                             capture_output=True, timeout=60)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        return [line.split() for line in run.stdout.split("\n")[:-1]]

    def test_words(self):
        cases = {
            "juliavdb fra": ["fractal"],
            "juliavdb --v": ["--version"],
            "juliavdb fractal --det": ["--detail"],
            "juliavdb fractal b.obj --alpha 40 --texture-se": ["--texture-seed"],
            "juliavdb fractal --map q": ["quadratic"],
            "juliavdb fractal --map = ma": ["mandelbulb"],
            "juliavdb fractal --sampling ": ["auto", "trilinear", "quadratic"],
            "juliavdb fractal --sampling =": ["auto", "trilinear", "quadratic"],
            "juliavdb fractal --pair ": ["A", "A'", "B", "C", "D", "E", "user"],
            "juliavdb fractal --texture sca": ["scales"],
            "juliavdb fractal --detail ": [],
            "juliavdb fractal --grids ": ["surface", "density", "logmodulus", "iterations", "versor"],
            "juliavdb fractal --grids surface,den": ["surface,density"],
            "juliavdb fractal --attributes Cd,t": ["Cd,trap", "Cd,tau"],
            "juliavdb completion ": ["bash", "zsh", "fish"],
            "juliavdb fractal --half --map c": ["cross"],
            "juliavdb plan ": ["tiles", "frames", "sheet"],
            "juliavdb plan frames --ke": ["--key"],
            "juliavdb plan sheet --ke": [],
            "juliavdb versor ins": ["inspect"],
            "juliavdb versor new --placement ": ["box", "cluster"],
            "juliavdb nothing --det": [],
        }
        for line, found in zip(cases, self.complete(*cases)):
            with self.subTest(line=line):
                self.assertEqual(found, cases[line])
        text = self.ok("--help", data=True)
        commands = re.findall(r"^  (\w+) ", text.split("Commands:")[1], re.MULTILINE)
        self.assertEqual(self.complete("juliavdb "), [commands])

    def completed_by_zsh(self, lines):
        """In zsh's own machinery, whose last step is replaced: it would show the words to somebody."""
        self.write("_juliavdb", self.ok("completion", "zsh", data=True))
        script = r"""
compadd() { while [[ $1 == -* && $1 != -- ]]; do shift; done; [[ $1 == -- ]] && shift
            local word; for word; do [[ $word == $PREFIX* ]] && found+=($word); done }
compset() { case $2 in '*,') [[ $PREFIX == *,* ]] && PREFIX=${PREFIX##*,} ;; '*=') PREFIX=${PREFIX#*=} ;; esac }
_files() { : }
complete_line() { found=(); words=("${(@s: :)1}"); CURRENT=$#words; PREFIX=$words[CURRENT]; source ./_juliavdb; print -r -- $found }
while IFS= read -r line; do complete_line "$line"; done
"""
        run = subprocess.run(["zsh", "-f", "-c", script], input="\n".join(lines) + "\n", cwd=self.folder, text=True, capture_output=True,
                             timeout=60)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        return [line.split() for line in run.stdout.split("\n")[:-1]]

    def completed_by_fish(self, lines):
        self.write("juliavdb.fish", self.ok("completion", "fish", data=True))
        script = ("source juliavdb.fish\nwhile read -l line\n"
                  "  echo (string join -- ' ' (complete -C $line | string replace -r '\\t.*' ''))\nend\n")
        run = subprocess.run(["fish", "--no-config", "-c", script], input="\n".join(lines) + "\n", cwd=self.folder, text=True,
                             capture_output=True, timeout=60, env={**os.environ, "HOME": str(self.folder)})
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        return [line.split() for line in run.stdout.split("\n")[:-1]]

    CASES = {
        "juliavdb fra": ["fractal"],
        "juliavdb --v": ["--version"],
        "juliavdb fractal b.obj --alpha 40 --texture-se": ["--texture-seed"],
        "juliavdb fractal --map q": ["quadratic"],
        "juliavdb fractal --sampling ": ["auto", "trilinear", "quadratic"],
        "juliavdb fractal --pair ": ["A", "A'", "B", "C", "D", "E", "user"],
        "juliavdb fractal --texture sca": ["scales"],
        "juliavdb fractal --half --map c": ["cross"],
        "juliavdb plan ": ["tiles", "frames", "sheet"],
        "juliavdb plan frames --ke": ["--key"],
        "juliavdb plan sheet --ke": [],
        "juliavdb versor ins": ["inspect"],
        "juliavdb completion ": ["bash", "zsh", "fish"],
    }

    @unittest.skipUnless(shutil.which("zsh"), "there is no zsh")
    def test_words_in_zsh(self):
        """Lists begin anew behind each comma; the words before it stay where they are."""
        cases = {**self.CASES, "juliavdb fractal --map=q": ["quadratic"], "juliavdb fractal --grids surface,den": ["density"],
                 "juliavdb fractal --grids log": ["logmodulus"]}
        for line, found in zip(cases, self.completed_by_zsh(cases)):
            with self.subTest(line=line):
                self.assertEqual(found, cases[line])

    @unittest.skipUnless(shutil.which("fish"), "there is no fish")
    def test_words_in_fish(self):
        """Which sorts them, and takes words that have the letters somewhere within them where none begins with these."""
        cases = {**self.CASES, "juliavdb fractal --map=q": ["--map=quadratic"], "juliavdb fractal --grids surface,den": ["surface,density"],
                 "juliavdb fractal --grids log": ["logmodulus"]}
        del cases["juliavdb plan sheet --ke"]
        for line, found in zip(cases, self.completed_by_fish(cases)):
            with self.subTest(line=line):
                self.assertEqual(sorted(found), sorted(cases[line]))

    def test_another_shell_is_refused(self):
        self.refused(USAGE, "completion", "tcsh", mentions="bash, zsh or fish")

    def test_every_option_is_completed(self):
        told = self.ok("fractal", "--help", "all", data=True)
        options = re.findall(r"^  (?:-\w \[ )?(--[a-z0-9-]+)", told, re.MULTILINE)
        self.assertGreater(len(options), 40)
        self.assertEqual(set(self.complete("juliavdb fractal --")[0]), set(options))


if __name__ == "__main__":
    harness.main()

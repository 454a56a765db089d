# SPDX-License-Identifier: Apache-2.0
"""Every command: its help, the examples in it, what goes to stdout and what to stderr, frames, threads, progress."""

import json
import os
import pathlib
import re
import shlex
import subprocess

import harness
from harness import DONE, USAGE


def commands():
    """What the help of the program lists."""
    text = subprocess.run([harness.program(), "--help"], capture_output=True, text=True, check=True).stdout
    return re.findall(r"^  (\w+) +\S", text.split("\nCommands:\n")[1], re.M)


class Help(harness.CliTest):

    def test_help_of_the_program_names_every_command(self):
        for word in ("--help", "-h", "help"):
            text = self.ok(word, data=True)
            self.assertGreaterEqual(set(commands()), {"sdf", "fractal", "mesh", "render", "plan", "man"})
            for command in commands():
                self.assertRegex(text, rf"(?m)^ +{command} +\S")

    def test_version(self):
        self.assertRegex(self.ok("--version", data=True), r"\Ajuliavdb \d+\.\d+\.\d+\n\Z")

    # Promise of usage.md: "Every command has a `--help` with its options by groups, and examples", which run as printed
    def test_help_of_each_command(self):
        for command in commands():
            for word in ("--help", "-h"):
                with self.subTest(command=command, word=word):
                    text = self.ok(command, word, data=True)
                    self.assertTrue(text.startswith(f"Usage: juliavdb {command} "), text[:80])
                    self.assertIn("\nExamples:\n", text)

    def test_no_arguments_show_the_commands(self):
        run = self.run_program()
        self.assertEqual((run.returncode, run.stdout), (USAGE, b""))
        for command in commands():
            self.assertIn(command.encode(), run.stderr)

    # Promise of design.md: "Options have no abbreviations"; a word that is none "is refused with the nearest one that is"
    def test_unknown_words(self):
        self.refused(USAGE, "frctal", mentions="frctal")
        self.refused(USAGE, "--frobnicate", mentions="--frobnicate")
        self.refused(USAGE, "", mentions="''")
        for command in commands():
            with self.subTest(command=command):
                if command not in ("devices", "maps", "man", "completion"):
                    self.refused(USAGE, command)
                self.refused(USAGE, command, "--frobnicate", mentions="frobnicate")
                self.refused(USAGE, command, "--thr", "2", mentions="thr")  # no guessing of abbreviations
                self.refused(USAGE, command, "--threads", mentions="threads")

    # Promise: "Options have no abbreviations"; a word ...
    def test_one_word_too_many(self):
        for command in ("sdf", "fractal", "mesh", "sheet", "slice", "study", "render"):
            self.refused(USAGE, command, "one.vdb", "two.vdb", "-o", "x.vdb", mentions="too many")


class Examples(harness.CliTest):

    @staticmethod
    def cheaper(command, words):
        """The same line for a small picture: JULIAVDB_FULL_EXAMPLES=1 runs the lines as they are printed."""
        if os.environ.get("JULIAVDB_FULL_EXAMPLES"):
            return words
        words = list(words)

        def replace(option, value):
            if option in words:
                words[words.index(option) + 1] = value
            else:
                words.extend((option, value))

        if command == "fractal":
            replace("--resolution", "32")
        has_mesh = "--config" not in words and "--map" not in words and not "".join(words[:1]).endswith(".vdb")
        if command in ("fractal", "sheet", "slice", "study") and has_mesh:
            replace("--sdf-resolution", "32")
        if command in ("slice", "study"):
            replace("--size", "40")
        if command == "study":
            replace("--versors", "3")
        if command in ("render", "sheet"):
            replace("--size", "40x30")
        if command == "print" and (not words[0].endswith(".vdb") or "--min-thickness" in words):
            replace("--resolution", "28")
        for option, value in (("--min-thickness", "6"), ("--spacing", "0.2"), ("--points", "500")):
            if option in words:
                replace(option, value)
        return words

    # Promise: "Every command has a `--help` ..."
    def test_the_lines_of_every_help_run_as_printed(self):
        self.write("bunny.obj", harness.obj(harness.sphere(3)))
        for frame in (1, 2):
            self.write(f"walk.{frame:04}.obj", harness.obj(harness.sphere(3, 1 + 0.2 * frame)))
        self.write("scan.ply", harness.ply(harness.with_hole(harness.sphere(3, 0.2), 0.9)))
        self.write("tractor.py", (pathlib.Path(__file__).resolve().parents[2] / "integrations/farm/tractor.py").read_bytes())
        self.ok("plan", "tiles", "bunny.obj", "-o", "farm", "--tiles", 16, "--resolution", 32, "--sdf-resolution", 32)
        # The others' serve until they are stopped, take minutes, need other files, or are for a shell.
        for command in [name for name in commands() if name not in ("explore", "fit", "plan", "usd", "completion", "man")]:
            examples = self.ok(command, "--help", data=True).split("\nExamples:\n")[1].splitlines()
            self.assertGreater(len(examples), 0)
            for line in examples:
                words = shlex.split(line)
                self.assertEqual(words[:2], ["juliavdb", command])
                with self.subTest(line=line):
                    run = self.run_program(command, *self.cheaper(command, words[2:]))
                    self.assertEqual(run.returncode, DONE, run.stderr.decode())
                    wants_data = (command in ("devices", "info", "maps", "status") or (command == "recipe" and "-o" not in words)) or words[2] in ("inspect", "list") or "--dry-run" in words
                    self.assertEqual(run.stdout != b"", wants_data)
                    for option, name in zip(words, words[1:]):
                        if option in ("-o", "--mesh"):
                            first = name.replace("####", "0001")
                            self.assertGreater(self.path(first).stat().st_size, 0)


class Streams(harness.CliTest):

    # Promise: "stdout carries data only"
    def test_a_picture_can_go_to_standard_output(self):
        self.write("s.obj", harness.obj(harness.sphere(2)))
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 24)
        run = self.run_program("sdf", "s.obj", "-o", "/dev/stdout", "--resolution", 24)
        self.assertEqual(run.returncode, DONE, run.stderr)
        self.assertEqual(run.stdout, self.bytes("s.vdb"))

    # Promise of design.md: "stdout carries data only"
    def test_the_lines_say_what_was_written_chosen_and_left(self):
        self.write("s.obj", harness.obj(harness.sphere(2)))
        text = self.ok("fractal", "s.obj", "-o", "s.vdb", "--mesh", "s.ply", "--resolution", 24, "--sdf-resolution", 24, "--progress", "none")
        self.assertRegex(text, r"\Awrote s\.vdb, s\.ply: [^\n]*triangles\norigin at [^\n]*\nthe set holds [^\n]*\n\Z")
        self.assertEqual(self.listing(), ["s.obj", "s.ply", "s.vdb"])

    # Promise: "A reader that closes the pipe ..."
    def test_a_reader_that_is_gone(self):
        self.write("s.obj", harness.obj(harness.needle()))
        reader, writer = os.pipe()
        os.close(reader)
        try:
            run = self.run_program("info", "s.obj", stdout=writer)
        finally:
            os.close(writer)
        self.check_refusal(run, harness.IO_ERROR, "info s.obj | nobody")


class Frames(harness.CliTest):

    # Promise of usage.md: "`####` and `%04d` work too" in names of frames
    def test_frame_patterns(self):
        self.write("s.obj", harness.obj(harness.cube()))
        for pattern in ("name.####.vdb", "name.$F4.vdb", "name.%04d.vdb", "name.vdb"):
            with self.subTest(pattern=pattern):
                self.ok("sdf", "s.obj", "-o", pattern, "--resolution", 16, "--frame", 7)
                self.assertEqual(self.listing(), ["name.0007.vdb", "s.obj"])
                self.path("name.0007.vdb").unlink()
        self.ok("fractal", "s.obj", "-o", "f.$F4.vdb", "--mesh", "f.####.ply", "--resolution", 16, "--sdf-resolution",
                16, "--frame", 12)
        self.assertEqual(self.listing(), ["f.0012.ply", "f.0012.vdb", "s.obj"])

    # Promise: "`####` and `%04d` work too" ...
    def test_frames_that_are_none(self):
        self.write("s.obj", harness.obj(harness.cube()))
        self.refused(USAGE, "sdf", "s.obj", "-o", "name.####.vdb", mentions="####")
        for frame in ("1.5", "x", "99999999999"):
            self.refused(USAGE, "sdf", "s.obj", "-o", "name.vdb", f"--frame={frame}", mentions=frame)


class Threads(harness.CliTest):

    # Promise: "`--threads N` (or the variables ..."
    def test_thread_counts(self):
        self.write("s.obj", harness.obj(harness.cube()))
        for value in ("0", "-1", "1.5", "two", "nan", "100000", ""):
            self.refused(USAGE, "sdf", "s.obj", "-o", "s.vdb", f"--threads={value}", mentions="threads")
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 16, "--threads", 1)

    # Promise: "`--threads N` (or the variables ..."
    def test_slurm(self):
        self.write("s.obj", harness.obj(harness.cube()))
        # What Slurm sets is not the user's word: a value that is none is passed over.
        for value in ("1", "2", "0", "many", "", "-3"):
            self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 16, env={"SLURM_CPUS_PER_TASK": value})


class ProgressLines(harness.CliTest):

    def test_quick_jobs_are_quiet(self):
        self.write("s.obj", harness.obj(harness.cube()))
        for style in ("bar", "none"):
            text = self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 16, "--progress", style)
            self.assertRegex(text, r"\Awrote [^\n]*\n\Z")

    def test_style(self):
        self.write("s.obj", harness.obj(harness.cube()))
        self.refused(USAGE, "sdf", "s.obj", "-o", "s.vdb", "--progress", "loud", mentions="loud")


class InfoOnEveryKind(harness.CliTest):

    def test_meshes(self):
        mesh = harness.needle()
        for name, content in (("s.obj", harness.obj(mesh)), ("s.ply", harness.ply(mesh)), ("s.stl", harness.stl(mesh)),
                              ("s.off", harness.off(mesh)), ("text.ply", harness.ply_text(mesh)),
                              ("upper.OBJ", harness.obj(mesh))):
            with self.subTest(name=name):
                info = self.info(self.write(name, content))
                self.assertEqual((info["kind"], info["file"], info["points"], info["triangles"], info["closed"]),
                                 ("mesh", name, len(mesh[0]), len(mesh[1]), True))
                self.assertAlmostEqual(info["volume"], harness.volume_of(harness.Mesh(*mesh, [], {}, True)), 5)

    def test_a_hole_is_told(self):
        info = self.info(self.write("h.obj", harness.obj(harness.with_hole(harness.sphere(2)))))
        self.assertFalse(info["closed"])
        self.assertGreater(info["open edges"], 0)

    def test_vdb_and_its_recipe(self):
        self.write("s.obj", harness.obj(harness.sphere(2)))
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 24)
        info = self.info("s.vdb")
        self.assertEqual((info["kind"], info["recipe"]["command"], info["recipe"]["resolution"]), ("VDB", "sdf", "24"))
        self.assertEqual([grid["name"] for grid in info["grids"]], ["phi"])
        self.assertEqual(info["grids"][0]["level set check"], "passes")
        self.ok("fractal", "s.vdb", "-o", "f.vdb", "--mesh", "f.ply", "--resolution", 24, "--texture-seed", 9)
        for name in ("f.vdb", "f.ply"):
            recipe = self.info(name)["recipe"]
            self.assertEqual((recipe["command"], recipe["texture-seed"], recipe["input"]), ("fractal", "9", "s.vdb"))

    def test_versors(self):
        for name, content in (("v.json", harness.rational_json(harness.ROOTS)), ("v.p4d", harness.p4d(harness.ROOTS)),
                              ("v.poly4d", harness.p4d(harness.ROOTS)),
                              ("v.o3d", harness.o3d(harness.ROOTS, harness.ROOTS[:1]))):
            with self.subTest(name=name):
                info = self.info(self.write(name, content))
                self.assertEqual((info["kind"], info["top"]["roots"], info["top"]["summed powers"]), ("versor", 3, 9))
                self.assertEqual(info["bottom"]["roots"], 1 if name == "v.o3d" else 0)

    def test_several_files_are_an_object_a_line(self):
        self.write("a.obj", harness.obj(harness.needle()))
        self.write("b.json", harness.rational_json(harness.ROOTS))
        lines = self.ok("info", "a.obj", "b.json", "--json", data=True).splitlines()
        self.assertEqual([json.loads(line)["file"] for line in lines], ["a.obj", "b.json"])

    def test_text_says_the_same(self):
        self.write("a.obj", harness.obj(harness.needle(0)))
        text = self.ok("info", "a.obj", data=True)
        self.assertIn("triangles: 20\n", text)
        self.assertIn("closed: true\n", text)

    # Promise of design.md: "Messages have numbers of four digits and `info` of six, places of twelve", and `info --json` has all
    #   digits
    def test_text_has_the_digits_that_mean_something(self):
        """All of them are in the JSON; places have those that tell points apart far from the origin."""
        self.write("a.obj", harness.obj(harness.moved(harness.sphere(2), 1 / 3, (1e6, 0, 1 / 7))))
        self.ok("fractal", "a.obj", "-o", "a.vdb", "--resolution", 12, "--sdf-resolution", 16)
        self.ok("versor", "new", "--seed", 4, "-o", "a.json")
        for name in ("a.obj", "a.vdb", "a.json"):
            text, said = self.ok("info", name, data=True), self.info(name)
            measured = re.split(r"^(?:recipe|metadata|note):", text, flags=re.M)[0]
            for number in re.findall(r"(?<![\w.])-?\d*\.?\d+(?:e[-+]?\d+)?", measured):
                self.assertLessEqual(len(re.sub(r"e.*|\D", "", number).lstrip("0")), 12, (name, number))
            if "area" in said:
                self.assertIn(f"\narea: {said['area']:.6g}\n", text)
                self.assertIn(f"\nbox min: [{', '.join(f'{x:.12g}' for x in said['box min'])}]\n", text)


if __name__ == "__main__":
    harness.main()

# SPDX-License-Identifier: Apache-2.0
"""--progress json: stderr is one JSON object a line, as docs/progress.md says, from the start to the closing event."""

import json
import pathlib
import re
import signal
import subprocess

import harness
from harness import BAD_DATA, CANNOT_CREATE, DONE, INTERRUPTED, NO_INPUT, USAGE

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs/progress.md"


class Progress(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(2)))

    def events(self, code, *arguments, stderr=None):
        if stderr is None:
            run = self.run_program(*arguments, "--progress", "json")
            self.assertEqual(run.returncode, code, run.stderr.decode())
            stderr = run.stderr
        events = [json.loads(line) for line in stderr.decode().splitlines()]
        words = " ".join(map(str, arguments))
        self.assertEqual(events[0]["event"], "start", words)
        self.assertEqual([event["event"] for event in events].count("end"), 1, words)
        share, elapsed = 0, 0
        for event in events:
            self.assertIsInstance(event, dict)
            self.assertEqual(event["command"], arguments[0])
            self.assertIn(event["event"], ("start", "progress", "phase", "end"))
            self.assertGreaterEqual(event["share"], share, words)
            self.assertGreaterEqual(event["elapsed"], elapsed, words)
            share, elapsed = event["share"], event["elapsed"]
            self.assertLessEqual(share, 1)
            self.assertTrue(0 <= event.get("fraction", 0) <= 1)
            self.assertTrue(event.get("left", 0) >= 0 and event.get("phaseLeft", 0) >= 0)
        end = events[-1]
        self.assertEqual((end["event"], end["exit"], end["ok"]), ("end", code, code == DONE), words)
        self.assertEqual("error" in end, code != DONE)
        self.assertEqual(events[0]["share"], 0)
        if code == DONE:
            self.assertEqual(end["share"], 1)
        # The closing event sums up the phases.
        for kind in ("wall", "cpu"):
            told = {}
            for event in events:
                if event["event"] == "phase":
                    told[event["phase"]] = told.get(event["phase"], 0) + event[kind]
            summed = {phase["phase"]: phase[kind] for phase in end["phases"]}
            self.assertEqual(summed.keys(), told.keys())
            for phase, seconds in summed.items():
                self.assertAlmostEqual(seconds, told[phase], places=6)
            self.assertLessEqual(sum(summed.values()), 1.001 * end[kind] + 0.001)
        return events

    def finished(self, names, *arguments):
        """@return the closing event of a run that wrote the files @a names"""
        end = self.events(DONE, *arguments)[-1]
        self.assertEqual(end["written"], names)
        self.assertEqual(end["file"], names[0])
        for name in names:
            self.assertTrue(self.path(name).is_file())
        self.assertTrue(end["messages"][0].startswith("wrote " + ", ".join(names)), end["messages"])
        return end

    # Promise of progress.md: `--progress json`: an object a line, a share that "never falls, and is 1 at the end of a success",
    #   and an `end` after a failure and after Ctrl-C
    def test_every_command(self):
        end = self.finished(["d.vdb"], "sdf", "s.obj", "-o", "d.vdb", "--resolution", 32)
        self.assertEqual(f"{end['counts']['voxels']} voxels", end["messages"][0].split(": ")[1].rsplit(" of ", 1)[0])
        end = self.finished(["f.vdb", "f.ply"], "fractal", "d.vdb", "-o", "f.vdb", "--mesh", "f.ply", "--resolution", 32)
        triangles = len(harness.read_ply(self.bytes("f.ply")).faces)
        self.assertEqual(end["counts"]["triangles"], triangles)
        end = self.finished(["m.ply"], "mesh", "f.vdb", "-o", "m.ply")
        self.assertEqual(end["counts"]["triangles"], triangles)
        end = self.finished(["g.ply"], "mesh", "f.vdb", "-o", "g.ply", "--from-grid")
        self.assertEqual(end["counts"]["triangles"], len(harness.read_ply(self.bytes("g.ply")).faces))
        end = self.finished(["p.png"], "render", "f.vdb", "-o", "p.png", "--size", "60x40")
        self.assertEqual((end["counts"]["width"], end["counts"]["height"]), (60, 40))
        self.finished(["c.png"], "slice", "f.vdb", "-o", "c.png", "--size", 50)
        self.finished(["y.png", "y.csv"], "study", "d.vdb", "-o", "y.png", "--csv", "y.csv", "--versors", 4, "--size",
                      40)
        end = self.finished(["t.json"], "fit", "s.obj", "-o", "t.json", "--roots", 20, "--resolution", 24)
        self.assertGreater(end["counts"]["topRoots"], 0)

    def test_pieces(self):
        end = self.finished(["t.0001.png", "t.0002.png", "t.0003.png"][:1], "render", "--field", "--map", "quadratic",
                            "--c=-0.2,0.6,0.2,0.2", "--iterations", 6, "--size", "40x40", "--frames", "1", "--turn", "90", "-o",
                            "t.####.png")
        self.assertEqual(end["counts"]["frames"], 1)
        events = self.events(DONE, "render", "--field", "--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", "--iterations", 6,
                             "--size", "40x40", "--frames", "1-4", "--turn", "360", "-o", "t.####.png")
        self.assertEqual(events[-1]["written"], [f"t.{n:04}.png" for n in (1, 2, 3, 4)])
        # After a frame of four, a quarter of the pictures is done.
        for event in events:
            match = re.fullmatch(r"writing, frame (\d) of 4", event.get("phase", ""))
            if match and event["event"] == "phase":
                self.assertGreater(event["share"], (int(match[1]) - 1) / 4)
        events = self.events(DONE, "sheet", "s.obj", "-o", "h.png", "--vary", "alpha=10,20,40", "--size", "40x40",
                             "--sdf-resolution", 24)
        self.assertEqual(events[-1]["written"], ["h.png", "h.json"])
        self.assertEqual(events[-1]["counts"]["cells"], 3)
        shares = [event["share"] for event in events if event.get("phase", "").endswith("cell 1 of 3")]
        self.assertTrue(shares and max(shares) <= 0.34, shares)

    # Promise: `--progress json`: an object ...
    def test_failures(self):
        self.write("bad.ply", harness.ply(harness.cube(), count=1000000))
        self.write("leaky.obj", harness.obj(harness.with_hole(harness.sphere(3))))
        for code, *arguments in (
            (USAGE, "sdf", "s.obj"), (USAGE, "sdf", "s.obj", "-o", "x.vdb", "--resolution", -3),
            (USAGE, "render", "s.vdb", "--nonsense"), (NO_INPUT, "sdf", "none.obj", "-o", "x.vdb"),
            (NO_INPUT, "render", "none.vdb", "-o", "x.png"), (BAD_DATA, "sdf", "bad.ply", "-o", "x.vdb"),
            (BAD_DATA, "sdf", "leaky.obj", "-o", "x.vdb", "--resolution", 32),
            (CANNOT_CREATE, "sdf", "s.obj", "-o", "no/such/x.vdb")):
            plain = self.run_program(*arguments, "--progress", "none")
            end = self.events(code, *arguments)[-1]
            self.assertEqual(f"juliavdb: {end['error']}\n", plain.stderr.decode())
            self.assertEqual(end["written"], [])
            self.assertLess(end["share"], 1)

    # Promise: `--progress json`: an object ...
    def test_interruption(self):
        words = ("fractal", "s.obj", "-o", "x.vdb", "--resolution", 1000, "--alpha", 6, "--sdf-resolution", 32)
        process = subprocess.Popen([harness.program(), *map(str, words), "--progress=json"], cwd=self.folder,
                                   env=harness.environment(), stdin=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                   preexec_fn=harness.restore_interrupt)
        text = b""
        for line in process.stderr:
            text += line
            if json.loads(line).get("phase") == "surface":
                break
        process.send_signal(signal.SIGINT)
        text += process.communicate(timeout=harness.TIMEOUT)[1]
        self.assertEqual(process.returncode, INTERRUPTED)
        events = self.events(INTERRUPTED, *words, stderr=text)
        self.assertIn("interrupted", events[-1]["error"])
        self.assertEqual(events[-1]["file"], "x.vdb")

    def test_commands_without_phases(self):
        self.write("n.obj", harness.obj(harness.needle()))
        run = self.run_program("info", "n.obj", "--json", "--progress", "json")
        self.assertEqual(run.returncode, DONE)
        json.loads(run.stdout)
        self.assertEqual([json.loads(line)["event"] for line in run.stderr.decode().splitlines()][-1], "end")

    # Promise: `--progress json`: an object ...
    def test_the_page_names_every_field(self):
        page = PAGE.read_text()
        fields = set()
        for event in self.events(DONE, "fractal", "s.obj", "-o", "x.vdb", "--mesh", "x.ply", "--resolution", 60,
                                 "--sdf-resolution", 32):
            fields |= {(event["event"], field) for field in event}
        for event, field in sorted(fields):
            self.assertIn(f"`{field}`", page, f"of the event {event}")


class Talk(harness.CliTest):
    """How much is said, which is the same for what is made."""

    def setUp(self):
        super().setUp()
        self.write("ball.obj", harness.obj(harness.sphere(3)))
        self.words = ("print", "ball.obj", "-o", "p.stl", "--longest-side", 60, "--resolution", 60, "--flat-base", 0.1)

    def said(self, *words):
        run = self.run_program(*harness.quiet(words))
        self.assertEqual(run.returncode, 0, run.stderr)
        return run.stderr.decode()

    # Promise of usage.md: "`--quiet` prints warnings and failures only"
    def test_quiet_leaves_warnings(self):
        usual = self.said(*self.words)
        made = self.bytes("p.stl")
        warnings = "".join(line + "\n" for line in usual.splitlines() if line.startswith("warning: "))
        self.assertTrue(warnings and len(warnings) < len(usual), usual)
        self.assertEqual(self.said(*self.words, "--quiet"), warnings)
        self.assertEqual(self.bytes("p.stl"), made)
        self.assertEqual(self.said("sdf", "ball.obj", "-o", "s.vdb", "--resolution", 20, "--quiet"), "")
        self.refused(NO_INPUT, "sdf", "none.obj", "-o", "s.vdb", "--quiet", mentions="none.obj")

    # Promise of usage.md: "`--verbose` also prints how long each phase took"
    def test_verbose_adds_what_it_took(self):
        usual, verbose = self.said(*self.words), self.said(*self.words, "--verbose")
        self.assertTrue(verbose.startswith(usual), verbose)
        more = verbose[len(usual):].splitlines()
        self.assertGreater(len(more), 2)
        for line in more[:-1]:
            self.assertRegex(line, r"\A[^:]+: [\d.e-]+ s, [\d.e-]+ s of CPU time\Z")
        self.assertRegex(more[-1], r"\Ain all: [\d.]+ s, [\d.]+ s of CPU time, at most [\d.]+ [KMG]iB of memory\Z")
        self.assertIn("reading", verbose)

    def test_what_does_not_go_together(self):
        for more in (("--quiet", "--verbose"), ("--quiet", "--progress", "bar")):
            self.refused(USAGE, *self.words, *more, mentions="leave one of them out")
        for word in ("--quiet", "--verbose"):
            run = self.run_program(*self.words, word, "--progress", "json")
            self.assertEqual(run.returncode, USAGE)
            self.assertIn(f"{word} has no effect", json.loads(run.stderr.decode().splitlines()[-1])["error"])


if __name__ == "__main__":
    harness.main()

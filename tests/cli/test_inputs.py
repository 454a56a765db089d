# SPDX-License-Identifier: Apache-2.0
"""No output replaces an input, by whatever name: every command, every option that names a file, every kind of link.

The commands and their options are those that the program itself lists. One that is not in the tables here fails."""

import concurrent.futures
import hashlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile

import harness
import test_painting

LOW = ("--resolution", 20, "--sdf-resolution", 24)
OUT = "{output}"  # in the place of the output's name

# What files a recipe may name, by the options that name them. Controls may name several kinds.
RECIPE = {
    "--rational": ("r.json", ("--map", "rational", "--rational", "r.json")),
    "--texture": ("v.json", ("--texture", "v.json")),
    "--rest": ("c.obj", ("--rest", "c.obj")),
    "--texture-over": ("r.json", ("--texture-over", "r.json")),
    "--config": ("list.txt", ("--config", "list.txt")),
    "--texture-mix": ("p.png", ("--texture-over", "rings", "--texture-mix", "texture:p.png:0:1")),
    "--grain-turn": ("p.png", ("--grain", "along", "--grain-turn", "texture:p.png:0:90")),
    "--mask": ("p.png", ("--mask", "texture:p.png:0:1")),
    "--detail": ("c.obj", ("--detail", "near:c.obj:0.2:0.1:0.6")),
    "--outward": ("c.ply", ("--outward", "paint:red@c.ply:0:1")),
    "--alpha": ("s.vdb", ("--alpha", "s.vdb:phi")),
    "--colour": ("p.png", ("--colour", "iterations:p.png")),
    "--target-before": ("in.0001.obj", ("--attributes", "velocity", "--target-before", "in.0001.obj")),
    "--target-after": ("in.0002.obj", ("--attributes", "velocity", "--target-after", "in.0002.obj")),
}

# (command, the victim, the words). Each option that names a file stands in some case of its command, once with OUT
# behind it or once with a victim.
CASES = [
    ("sdf", "b.obj", ("b.obj", "-o", OUT)),
    ("sdf", "s.vdb", ("--config", "s.vdb", "-o", OUT)),
    ("sdf", "b.obj", ("--config", "s.vdb", "-o", OUT)),
    ("convert", "s.vdb", ("s.vdb", "--grid-names", "phi=d", "-o", OUT)),
    ("fractal", "b.obj", ("b.obj", "--mesh", OUT)),
    ("fractal", "b.obj", ("b.obj", "-o", "new.vdb", "--mesh", OUT)),
    ("fractal", "s.vdb", ("s.vdb", "-o", OUT)),
    ("fractal", "b.obj", ("--config", "x.vdb", "--mesh", OUT)),
    ("fractal", "x.vdb", ("--config", "x.vdb", "-o", OUT)),
    ("fractal", "x.ply", ("--config", "x.ply", "--mesh", OUT)),
    ("fractal", "t.json", ("--config", "t.json#1", "--mesh", OUT)),
    ("fractal", "moved/m.obj", ("--config", "far.vdb", "--search", "moved", "--mesh", OUT)),
    ("fit", "b.obj", ("b.obj", "-o", OUT)),
    ("fit", "b.obj", ("b.obj", "-o", "new.json", "--report", OUT)),
    ("fit", "b.obj", ("b.obj", "-o", "new.json", "--plot", OUT)),
    ("fit", "b.obj", ("b.obj", "-o", "new.json", "--charge", OUT)),
    ("fit", "fit.txt", ("b.obj", "--config", "fit.txt", "-o", OUT)),
    ("mesh", "x.vdb", ("x.vdb", "-o", OUT)),
    ("mesh", "x.vdb", ("x.vdb", "--from-grid", "-o", OUT)),
    ("mesh", "b.obj", ("x.vdb", "-o", OUT)),
    ("mesh", "c.obj", ("x.vdb", "--input", "c.obj", "-o", OUT)),
    ("mesh", "moved/m.obj", ("far.vdb", "--search", "moved", "-o", OUT)),
    # Only the voxels or the triangles are used, but the target is the recipe's all the same; y.vdb has it from s.vdb.
    ("mesh", "b.obj", ("x.vdb", "--from-grid", "-o", OUT)),
    ("mesh", "b.obj", ("y.vdb", "--from-grid", "-o", OUT)),
    ("mesh", "b.obj", ("s.vdb", "-o", OUT)),
    ("fractal", "b.obj", ("s.vdb", "--mesh", OUT)),
    ("sdf", "b.obj", ("x.ply", "-o", OUT)),
    ("points", "b.obj", ("x.ply", "--from-grid", "--points", 20, "-o", OUT)),
    ("print", "b.obj", ("x.vdb", "--from-grid", "--size", 10, "-o", OUT)),
    ("slice", "b.obj", ("x.vdb", "--field", "grid", "-o", OUT)),
    ("render", "b.obj", ("x.vdb", "-o", OUT)),
    ("usd", "b.obj", ("x.vdb", "-o", OUT)),
    ("usd", "b.obj", ("--mesh", "x.ply", "-o", OUT)),
    ("points", "x.ply", ("x.ply", "--points", 20, "-o", OUT)),
    ("points", "x.vdb", ("x.vdb", "--from-grid", "--points", 20, "-o", OUT)),
    ("points", "b.obj", ("x.vdb", "--points", 20, "-o", OUT)),
    ("points", "moved/m.obj", ("far.vdb", "--search", "moved", "--points", 20, "-o", OUT)),
    ("print", "b.obj", ("b.obj", "--size", 10, "-o", OUT)),
    ("print", "b.obj", ("x.vdb", "--size", 10, "-o", OUT)),
    ("print", "x.ply", ("x.ply", "--size", 10, "-o", OUT)),
    ("versor", "v.json", ("scale", "v.json", 2, "-o", OUT)),
    ("versor", "v.json", ("translate", "v.json", "1,0,0", "-o", OUT)),
    ("versor", "r.json", ("add", "v.json", "r.json", "-o", OUT)),
    ("sheet", "b.obj", ("b.obj", "--vary", "alpha=10,20", "-o", OUT)),
    ("sheet", "b.obj", ("x.vdb", "--vary", "alpha=10,20", "-o", OUT)),
    ("sheet", "p.png", ("b.obj", "--vary", "mask=1;texture:p.png:0:1", "-o", OUT)),
    ("sheet", "moved/m.obj", ("far.vdb", "--search", "moved", "--vary", "iterations=5,6", "-o", OUT)),
    ("slice", "b.obj", ("b.obj", "-o", OUT)),
    ("slice", "b.obj", ("x.vdb", "-o", OUT)),
    ("slice", "s.vdb", ("s.vdb", "--field", "grid", "-o", OUT)),
    ("slice", "moved/m.obj", ("far.vdb", "--search", "moved", "-o", OUT)),
    ("study", "r.json", ("b.obj", "--texture-over", "r.json", "-o", OUT)),
    ("study", "b.obj", ("b.obj", "-o", OUT)),
    ("study", "c.obj", ("b.obj", "--rest", "c.obj", "-o", OUT)),
    ("study", "b.obj", ("b.obj", "-o", "new.png", "--curve", OUT)),
    ("study", "b.obj", ("b.obj", "-o", "new.png", "--csv", OUT)),
    ("study", "b.obj", ("b.obj", "--grain", "along", "--strokes", OUT)),
    ("study", "list.txt", ("b.obj", "--config", "list.txt", "-o", OUT)),
    ("study", "moved/m.obj", ("far.vdb", "--search", "moved", "-o", OUT)),
    ("render", "b.obj", ("b.obj", "-o", OUT)),
    ("render", "s.vdb", ("s.vdb", "-o", OUT)),
    ("render", "f.json", ("s.vdb", "--roots", "f.json", "-o", OUT)),
    ("render", "b.obj", ("--field", "x.vdb", "-o", OUT)),
    ("render", "moved/m.obj", ("--field", "far.vdb", "--search", "moved", "-o", OUT)),
    ("explore", "b.obj", ("b.obj", "--export", OUT)),
    ("explore", "moved/m.obj", ("far.vdb", "--search", "moved", "--export", OUT)),
    ("submit", "plan/prepared.vdb", ("plan", "--engine", "parallel", "-o", OUT)),
    ("submit", "b.obj", ("plan", "--engine", "slurm", "--mesh", OUT)),
    ("submit", "plan/manifest.json", ("plan", "--engine", "parallel", "--index", OUT)),
    ("submit", "counted/manifest.json", ("counted", "--engine", "slurm", "--counts", OUT)),
    ("merge", "counted/manifest.json", ("counted", "--counts", OUT)),
    ("merge", "plan/prepared.vdb", ("plan", "-o", OUT)),
    ("merge", "b.obj", ("plan", "--mesh", OUT)),
    ("merge", "plan/manifest.json", ("plan", "--index", OUT)),
    ("recipe", "x.vdb", ("x.vdb", "-o", OUT)),
    ("recipe", "b.obj", ("x.vdb", "-o", OUT)),
    ("recipe", "t.json", ("t.json#1", "-o", OUT)),
    ("submit", "t.sh", ("plan", "--engine", "script", "--template", "t.sh", "--index", OUT)),
    ("usd", "x.vdb", ("x.vdb", "-o", OUT)),
    ("usd", "x.ply", ("--mesh", "x.ply", "-o", OUT)),
    ("usd", "x.ply", ("--mesh", "x.ply", "--package", OUT)),
    ("usd", "b.obj", ("--mesh", "x.ply", "-o", "new.usda", "--package", OUT)),
]

# How a command comes to have a recipe of options, and which of its outputs are tried with it.
RECIPES = {
    "fractal": ("b.obj", "--mesh", OUT),
    "sheet": ("b.obj", "--vary", "iterations=5,6", "-o", OUT),
    "slice": ("b.obj", "-o", OUT),
    "render": ("--field", "b.obj", "-o", OUT),
    "explore": ("b.obj", "--export", OUT),
}
# What has no points to colour, or none that move, says so.
MOVING = {"--target-before", "--target-after"}
REFUSED = {"slice": {"--colour", *MOVING}, "render": MOVING, "study": MOVING}
for _command, _words in RECIPES.items():
    for _option, (_victim, _options) in RECIPE.items():
        if _option not in REFUSED.get(_command, ()):
            CASES.append((_command, _victim, (*_options, *_words)))

EXTENSIONS = {
    ("sdf", "-o"): ".vdb .nvdb",
    ("convert", "-o"): ".vdb .nvdb",
    ("fractal", "-o"): ".vdb .nvdb",
    ("fractal", "--mesh"): ".ply .obj .stl .glb",
    ("fit", "-o"): ".json .o3d",
    ("fit", "--report"): ".csv",
    ("fit", "--plot"): ".png .svg .exr",
    ("fit", "--charge"): ".ply .obj .glb",
    ("mesh", "-o"): ".ply .obj .stl .glb",
    ("points", "-o"): ".ply .vdb",
    ("print", "-o"): ".stl .ply .obj",
    ("versor", "-o"): ".json .p4d .poly4d",
    ("sheet", "-o"): ".png",
    ("slice", "-o"): ".png .exr",
    ("study", "-o"): ".png .exr",
    ("study", "--curve"): ".png .svg .exr",
    ("study", "--csv"): ".csv",
    ("study", "--strokes"): ".ply .glb",
    ("render", "-o"): ".png .exr",
    ("explore", "--export"): ".html",
    ("submit", "-o"): ".vdb",
    ("submit", "--mesh"): ".ply .obj",
    ("submit", "--index"): ".json",
    ("submit", "--counts"): ".json",
    ("merge", "-o"): ".vdb",
    ("merge", "--mesh"): ".ply .obj",
    ("merge", "--index"): ".json",
    ("merge", "--counts"): ".json",
    ("recipe", "-o"): ".json",
    ("usd", "-o"): ".usda",
    ("usd", "--package"): ".usdz",
}

# They write nothing, or only what is data on the standard output.
WITHOUT_OUTPUT = {"info", "maps", "completion", "status", "devices"}
# They write into a folder that is a plan's or their own.
INTO_FOLDERS = {"plan", "plan tiles", "plan frames", "plan sheet", "task", "man"}


class Inputs(harness.CliTest):
    """One folder for all tests: nothing in it may change."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_test_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        maker = harness.CliTest()
        maker.folder = cls.folder
        for name in ("b.obj", "c.obj", "in.0001.obj", "in.0002.obj"):
            maker.write(name, harness.obj(harness.lumpy()) + f"# {name}\n")
        maker.write("c.ply", test_painting.painted_ply(harness.lumpy(), ["uchar red"], lambda p: (9,)))
        maker.write("p.png", test_painting.png(2, 2, lambda x, y: (9, 9, 9)))
        maker.write("v.json", harness.rational_json(harness.ROOTS))
        maker.write("r.json", harness.rational_json(harness.ROOTS, harness.ROOTS[:1]))
        maker.write("list.txt", "iterations = 5\n")
        maker.write("t.sh", "#!/bin/sh\n@{program} @{task-arguments} @{tasks} @{merge-arguments}\n")
        maker.write("fit.txt", "roots = 8\n")
        maker.ok("sdf", "b.obj", "-o", "s.vdb", "--resolution", 24)
        maker.ok("fractal", "b.obj", "-o", "x.vdb", "--mesh", "x.ply", *LOW)
        maker.ok("fractal", "s.vdb", "-o", "y.vdb", "--resolution", 20)
        maker.ok("fractal", "in.####.obj", "-o", "g.####.vdb", "--frames", "1-2", *LOW)
        maker.ok("plan", "tiles", "b.obj", "-o", "counted", "--tiles", 2, "--make", "count", *LOW)
        maker.ok("task", "counted", "--range", "1-2")
        maker.ok("fit", "b.obj", "-o", "f.json", "--resolution", 24, "--triangles", 400, "--roots", 8)
        maker.ok("sheet", "b.obj", "-o", "t.png", "--vary", "alpha=20,40", "--size", "16x16", *LOW)
        maker.ok("plan", "tiles", "b.obj", "-o", "plan", "--tiles", 2, "--make", "vdb,ply,obj", *LOW)
        maker.ok("task", "plan", "--range", "1-2")
        maker.ok("plan", "frames", "in.####.obj", "--frames", "1-2", "-o", "frames", *LOW)
        os.mkdir(cls.folder / "moved")
        maker.write("m.obj", harness.obj(harness.lumpy()))
        maker.ok("fractal", "m.obj", "-o", "far.vdb", *LOW)
        os.rename(cls.folder / "m.obj", cls.folder / "moved" / "m.obj")
        os.symlink(".", cls.folder / "there")

    def setUp(self):
        """The folder is there."""

    def contents(self):
        return {str(path.relative_to(self.folder)): hashlib.sha256(path.read_bytes()).hexdigest()
                for path in self.folder.rglob("*") if path.is_file()}

    def link(self, kind, victim, suffix):
        """A link to the victim, which the test that asks for it leaves behind."""
        name = f"{kind}-of-{victim.replace('/', '-')}{suffix}"
        if kind == "symbolic" and not self.path(name).is_symlink():
            os.symlink(victim, self.path(name))
        if kind == "hard" and not self.path(name).exists():
            os.link(self.path(victim), self.path(name))
        return name

    def outputs(self, number, command, victim, words):
        """Names by which the output is the victim: each way for the first cases, and by turns for the others."""
        extensions = EXTENSIONS[command, words[words.index(OUT) - 1]].split()
        suffix = pathlib.Path(victim).suffix
        linked = suffix if suffix in extensions else extensions[0]
        names = [self.link(("hard", "symbolic")[number % 2], victim, linked)]
        if suffix in extensions:
            names += [victim, (f"./{victim}", f"there/{victim}", str(self.path(victim)))[number % 3]]
        return names

    # Promise: "No output replaces an input", through ...
    def test_no_case_is_forgotten(self):
        said = self.ok("--help", data=True)
        commands = [line.split()[0] for line in said.partition("Commands:\n")[2].splitlines() if line.startswith("  ")]
        self.assertGreater(len(commands), 15)
        listed = {}
        for command in commands:
            table = [line.split() for line in self.ok(command, "--describe", "completion", data=True).splitlines()]
            listed[command] = table
            if command == "plan":
                for part in table[0][1:]:
                    text = self.ok(command, part, "--describe", "completion", data=True)
                    listed[f"plan {part}"] = [line.split() for line in text.splitlines()]
        covered = {}
        for command, options in REFUSED.items():
            for option in options:
                words = ("--field",) if command == "render" else ()
                self.refused(harness.USAGE, command, *RECIPE[option][1][-2:], *words, "b.obj", "-o", "new.png",
                             mentions=f"{option} has no")
            covered[command] = set(options)
        for command, victim, words in CASES:
            done = covered.setdefault(command, set())
            words = ["--output" if word == "-o" else str(word) for word in words]
            for option, value in zip(words, words[1:]):
                if option.startswith("--") and (value == OUT or victim in value or victim.startswith(value + "/")):
                    done.add(option)
        self.assertEqual(set(listed), set(covered) | WITHOUT_OUTPUT | INTO_FOLDERS)
        for command, table in listed.items():
            files = {words[0] for words in table if words[0].startswith("--") and words[1] == "file"}
            if command in WITHOUT_OUTPUT:
                self.assertEqual(files, set(), command)
            elif command in INTO_FOLDERS:
                self.assertLessEqual(files, set(RECIPE), command)
            else:
                self.assertLessEqual(files, covered[command], command)
        names = {words[0] for words in listed["fractal"]}
        self.assertLessEqual(set(RECIPE), names)

    def check(self, runs):
        """Each is refused in one line with both names, and the folder stays as it was. Before that line stands at most
        where a file of a recipe was found. @param runs: (output, input, words)"""
        files, before = self.listing(), self.contents()
        with concurrent.futures.ThreadPoolExecutor(max(2, os.cpu_count() or 1)) as pool:
            ended = list(pool.map(lambda run: self.run_program(*harness.quiet(run[2])), runs))
        for (output, victim, words), run in zip(runs, ended):
            words = " ".join(map(str, words))
            with self.subTest(words=words):
                *notes, text = run.stderr.decode().splitlines()
                self.assertEqual((run.returncode, run.stdout), (harness.USAGE, b""), text)
                self.assertTrue(all(line.startswith(("note: '", "warning: '")) for line in notes), notes)
                self.assertTrue(text.startswith(f"juliavdb: the output '{output}' "), text)
                self.assertIn(victim, text)
        self.assertEqual(self.contents(), before)
        self.assertEqual(self.listing(), files, "a refused run left files behind")

    # Promise of design.md: "No output replaces an input", through links, other spellings, frames, plans and recipes: refused
    #   before any work, with both names
    def test_no_output_replaces_an_input(self):
        runs = []
        for number, (command, victim, words) in enumerate(CASES):
            for name in self.outputs(number, command, victim, words):
                runs.append((name, victim, (command, *(name if word == OUT else word for word in words))))
        self.check(runs)

    # Promise: "No output replaces an input", through ...
    def test_the_recipes_of_a_sheet(self):
        """They go beside its picture, under a name that nobody has given."""
        runs = [("t.json", "t.json", ("sheet", "--config", "t.json#1", "--vary", "alpha=10,20", "-o", "t.png"))]
        os.symlink("t.json", self.path("k.json"))
        runs.append(("k.json", "t.json", ("sheet", "--config", "t.json#1", "--vary", "alpha=10,20", "-o", "k.png")))
        self.check(runs)

    # Promise: "No output replaces an input", through ...
    def test_no_frame_replaces_an_input_of_any_frame(self):
        sequence = ("--frames", "1-2", *LOW)
        os.link(self.path("in.0001.obj"), self.path("later.0002.obj"))
        os.link(self.path("p.png"), self.path("turn.0002.png"))
        os.link(self.path("g.0002.vdb"), self.path("scene.usda"))
        os.link(self.path("in.0002.obj"), self.path("mesh.usdz"))
        os.link(self.path("in.0002.obj"), self.path("cut.0001.png"))
        os.link(self.path("in.0002.obj"), self.path("dots.0001.ply"))
        os.link(self.path("g.0002.vdb"), self.path("grids.0001.nvdb"))
        self.check([
            ("in.0001.obj", "in.0001.obj", ("fractal", "in.####.obj", "--mesh", "in.####.obj", *sequence)),
            ("./in.0001.obj", "in.0001.obj", ("fractal", "in.####.obj", "--mesh", "./in.$F4.obj", *sequence)),
            ("later.0002.obj", "in.0001.obj", ("fractal", "in.####.obj", "--mesh", "later.####.obj", *sequence)),
            ("later.0002.obj", "in.0001.obj",
             ("fractal", "in.####.obj", "--mesh", "later.####.obj", "--keep-going", *sequence)),
            ("turn.0002.png", "p.png", ("render", "--field", "b.obj", "--mask", "texture:p.png:0:1", "-o",
                                        "turn.####.png", "--frames", "1-2", "--turn", 90, "--size", "16x16", *LOW)),
            ("scene.usda", "g.0002.vdb", ("usd", "g.####.vdb", "--frames", "1-2", "-o", "scene.usda")),
            ("mesh.usdz", "in.0002.obj", ("usd", "--mesh", "in.####.obj", "--frames", "1-2", "--package", "mesh.usdz")),
            # The target of the second frame is known from the recipe in its VDB alone.
            ("cut.0001.png", "in.0002.obj", ("slice", "g.####.vdb", "--frames", "1-2", "-o", "cut.####.png")),
            ("in.0001.obj", "in.0001.obj", ("mesh", "g.####.vdb", "--frames", "1-2", "-o", "in.####.obj")),
            ("in.0001.obj", "in.0001.obj", ("print", "g.####.vdb", "--size", 9, "--frames", "1-2", "-o", "in.####.obj")),
            ("dots.0001.ply", "in.0002.obj",
             ("points", "g.####.vdb", "--points", 9, "--frames", "1-2", "-o", "dots.####.ply")),
            ("grids.0001.nvdb", "g.0002.vdb", ("convert", "g.####.vdb", "--frames", "1-2", "-o", "grids.####.nvdb")),
        ])

    # Promise: "No output replaces an input", through ...
    def test_the_pieces_of_a_plan(self):
        os.link(self.path("b.obj"), self.path("pieces.0002.ply"))
        os.link(self.path("b.obj"), self.path("cut.2.ply"))
        self.check([("pieces.0002.ply", "b.obj", ("merge", "plan", "--index", "pieces.json")),
                    ("pieces.0002.ply", "b.obj", ("submit", "plan", "--engine", "parallel", "--index", "pieces.json")),
                    ("plan/tiles/new.vdb", "plan/tiles", ("merge", "plan", "-o", "plan/tiles/new.vdb")),
                    # How many there are is known once the tiles are read.
                    ("cut.2.ply", "b.obj", ("merge", "plan", "--mesh", "cut.ply", "--most-points", 900))])

    # Promise of design.md: Two names of outputs that are one file are refused; "Devices and pipes are never inputs in this sense"
    def test_two_outputs_are_two_files(self):
        os.symlink("pair.png", self.path("same.png"))
        before = self.listing()
        for second in ("pair.png", "./pair.png", "there/pair.png", "same.png"):
            text = self.refused(harness.USAGE, "study", "b.obj", "-o", "pair.png", "--curve", second)
            self.assertIn(f"'{second}'", text)
        self.assertEqual(self.listing(), before)

    # Promise: "No output replaces an input", through ...
    def test_a_task_keeps_its_input(self):
        os.mkdir(self.path("frames/out"))
        os.link(self.path("in.0001.obj"), self.path("frames/out/in.0001.vdb"))
        before = self.bytes("in.0001.obj")
        run = self.run_program("task", "frames", "--index", 1)
        self.assertEqual(run.returncode, harness.USAGE, run.stderr)
        self.assertIn(b"would replace the input", run.stderr)
        self.assertEqual(self.bytes("in.0001.obj"), before)
        self.assertEqual(self.bytes("frames/out/in.0001.vdb"), before)


class Outputs(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("b.obj", harness.obj(harness.lumpy()))

    # Promise: Two names of outputs that are one ...
    def test_outputs_of_earlier_runs_are_no_inputs(self):
        job = ("fractal", "b.obj", "-o", "x.vdb", "--mesh", "x.ply", *LOW)
        self.ok(*job)
        made = self.bytes("x.vdb"), self.bytes("x.ply")
        self.ok(*job)
        self.ok("fractal", "--config", "x.vdb", "--mesh", "x.ply")
        self.assertEqual((self.bytes("x.vdb"), self.bytes("x.ply")), made)

    # Promise: Two names of outputs that are one ...
    def test_devices_take_what_they_are_given(self):
        self.ok("fractal", "b.obj", "-o", "/dev/null", "--mesh", "/dev/null", *LOW)
        self.ok("fractal", "b.obj", "--mesh", "b.ply", *LOW)
        run = self.run_program("fractal", "b.obj", "--mesh", "/dev/stdout", *LOW)
        self.assertEqual((run.returncode, run.stdout), (harness.DONE, self.bytes("b.ply")))
        # So is an input that the shell has opened as the standard output.
        before = self.bytes("b.obj")
        with open(self.path("b.obj"), "ab") as target:
            run = self.run_program("fractal", "b.obj", "--mesh", "/dev/stdout", *LOW, stdout=target)
        self.assertEqual(run.returncode, harness.USAGE, run.stderr)
        self.assertEqual(self.bytes("b.obj"), before)

    def killed(self, *words):
        """Kills a job while it computes its field."""
        job = subprocess.Popen([harness.program(), *map(str, words), "--progress", "json"], cwd=self.folder,
                               env=harness.environment(), stdin=subprocess.DEVNULL, stderr=subprocess.PIPE)
        with job.stderr:
            for line in job.stderr:
                self.assertTrue(line.startswith(b"{"), line)
                if "field" in (json.loads(line).get("phase") or ""):
                    break
            job.send_signal(signal.SIGKILL)
        self.assertEqual(job.wait(), -signal.SIGKILL, "the job had ended before")

    def temporaries(self):
        return [name for name in self.listing() if name.endswith(".tmp")]

    # Promise of reliability.md: "What a run that was killed by SIGKILL leaves is removed by the next run that writes the same
    #   output; temporary files of other outputs and of living runs stay"
    def test_the_next_run_removes_what_a_killed_one_left(self):
        long_name = "n" * 150
        for output, mesh in (("x.vdb", "x.ply"), (f"{long_name}.vdb", f"{long_name}.ply")):
            with self.subTest(output=output):
                job = ("fractal", "b.obj", "-o", output, "--mesh", mesh, "--sdf-resolution", 24)
                for _ in range(2):
                    self.killed(*job, "--resolution", 1500)
                    self.assertEqual(len(self.temporaries()), 2, "the second run has removed those of the first")
                self.ok(*job, "--resolution", 20)
                self.assertEqual(self.temporaries(), [])

    # Promise: "What a run that was killed ..."
    def test_what_another_job_left_stays(self):
        self.killed("fractal", "b.obj", "-o", "x.vdb", "--sdf-resolution", 24, "--resolution", 1500)
        self.write(".y.vdb.0123456.tmp", "somebody's")
        left = self.temporaries()
        self.assertEqual(len(left), 2)
        self.ok("fractal", "b.obj", "-o", "y.vdb", "--mesh", "x.ply", *LOW)
        self.assertEqual(self.temporaries(), left)

    # Promise: "What a run that was killed ..."
    def test_a_sequence_goes_on_without_leftovers(self):
        job = ("fractal", "b.obj", "-o", "g.####.vdb", "--frames", "1-2", "--sdf-resolution", 24,
               "--key", "resolution@1=20", "--ease", "step")
        self.killed(*job, "--key", "resolution@2=1500")
        self.assertEqual(len(self.temporaries()), 1)
        self.ok(*job, "--key", "resolution@2=24")
        self.assertEqual(self.temporaries(), [])


if __name__ == "__main__":
    harness.main()

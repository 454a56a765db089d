# SPDX-License-Identifier: Apache-2.0
"""Every option of every command either acts or is refused.

The options are read from what the program says of itself, so a new one takes part from its first day: with a value of VALUES, or
with one that its placeholder suggests. Each is given to runs of RUNS. Such a run then makes something else or says something
else, or it is refused in a line that names the option. And of each option there has to be a run that it changes.

The first run of a command gets every option, and each other one every third option, in turns. An option that acted in none of
these is given to the other runs too. JULIAVDB_OPTIONS=all gives every option to every run, which takes more than twice as long.

What is compared are the files without the recipe in them, which says of every option that it was given.
"""

import concurrent.futures
import json
import os
import queue
import re
import shutil
import struct

import pyopenvdb

import harness
import test_animation
import test_motion
from harness import DONE, USAGE

ALL = os.environ.get("JULIAVDB_OPTIONS") == "all"
LOW = ("--resolution", 14, "--sdf-resolution", 16)
BOX = "-0.4,-0.5,-0.3,0.7,0.8,0.9"

RUNS = {
    "fractal": [
        ("s.obj", "-o", "f.vdb", *LOW),
        ("t.ply", "--mesh", "f.ply", "--box", BOX, "--alpha", 20, *LOW),
        ("s.obj", "-o", "f.vdb", "--mesh", "f.glb", "--texture", "random", "--attributes", "trap,Cd", "--colour", "trap", *LOW),
        ("open.obj", "--repair", "--mesh", "f.ply", "--texture", "bark", "--texture-over", "coral", *LOW),
        ("s.obj", "--mesh", "f.ply", "--texture", "fur", "--grain", "along", *LOW),
        ("rod.obj", "--mesh", "f.ply", "--rest", "rod_rest.obj", "--resolution", 14, "--sdf-resolution", 40),
        ("home.ply", "--mesh", "f.ply", *LOW),
        ("hollow.obj", "-o", "f.vdb", *LOW),
        ("pair.vdb", "--grid", "phi", "-o", "f.vdb", "--resolution", 14),
        ("turned.vdb", "--invert", "-o", "f.vdb", "--resolution", 14),
        ("--config", "quadratic.vdb", "-o", "f.vdb"),
        ("--map", "cross", "--f", "x, y, z", "--g", "cos(x), cos(y), z", "--mesh", "f.ply", "--resolution", 14),
        ("s.obj", "--mesh", "f.stl", "--texture", "random", "--texture-placement", "cluster", "--follow", "--up", "z",
         "--resolution", 60, "--sdf-resolution", 16),
        ("s.vdb", "-o", "f.nvdb", "--texture", "swirl.json", "--origin", "centre", "--resolution", 14),
        ("s.obj", "--map", "rational", "--rational", "swirl.json", "--mesh", "f.ply", *LOW),
        ("s.obj", "--texture", "random", "--texture-placement", "surface", "--mesh", "f.ply", *LOW),
        ("--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", "-o", "f.vdb", "--resolution", 14),
        ("--map", "mandelbulb", "--mesh", "f.obj", "--resolution", 14),
        ("--map", "cross", "--scheme", 5, "-o", "f.vdb", "--resolution", 14),
        ("s.obj", "-o", "f.####.vdb", "--frames", "1-3", "--key", "detail@1=0.2", "--key", "detail@3=0.4", *LOW),
        ("s.obj", "-o", "f.vdb", "--attributes", "velocity", "--target-after", "on.obj", *LOW),
        ("walk.gltf", "-o", "f.vdb", "--target-frame", 18, "--resolution", 14, "--sdf-resolution", 100),
    ],
    "sdf": [("s.obj", "-o", "f.vdb", "--resolution", 14), ("s.obj", "-o", "f.nvdb", "--resolution", 14), ("open.obj", "--repair", "-o", "f.vdb", "--resolution", 14),
            ("hollow.obj", "-o", "f.vdb", "--resolution", 14),
            ("s.obj", "-o", "f.####.vdb", "--resolution", 14, "--frames", "1-2"), ("pair.vdb", "-o", "f.vdb", "--grid", "phi"),
            ("turned.vdb", "--invert", "-o", "f.vdb")],
    "convert": [("s.vdb", "-o", "f.nvdb"), ("grow.####.vdb", "-o", "f.####.nvdb", "--frames", "1-2")],
    "mesh": [("made.vdb", "-o", "m.ply"), ("s.vdb", "-o", "m.ply"), ("made.vdb", "-o", "m.obj", "--from-grid"),
             ("grow.####.vdb", "-o", "m.####.ply", "--from-grid", "--frames", "1-2")],
    "points": [("ring.vdb", "-o", "p.ply", "--points", 100), ("s.obj", "-o", "p.ply", "--spacing", 0.5),
               ("s.vdb", "-o", "p.vdb", "--points", 100), ("s.vdb", "-o", "p.####.ply", "--points", 50, "--frames", "1-2")],
    "print": [("made.vdb", "-o", "p.stl", "--longest-side", 60, "--islands", 3, "--resolution", 20), ("two.obj", "-o", "p.stl", "--longest-side", 60, "--flat-base", 4, "--resolution", 20),
              ("s.vdb", "-o", "p.ply", "--longest-side", 60, "--min-thickness", 9, "--resolution", 20),
              ("fin.obj", "-o", "p.ply", "--longest-side", 60, "--min-thickness", 6, "--resolution", 20),
              ("s.vdb", "-o", "p.####.stl", "--longest-side", 60, "--frames", "1-2")],
    "versor": [("list",), ("new", "-o", "v.json"), ("new", "--texture", "rings", "-o", "v.json"), ("inspect", "swirl.json"),
               ("new", "--placement", "cluster", "-o", "v.json"), ("add", "swirl.json", "swirl.json", "-o", "v.json"),
               ("scale", "swirl.json", 0.5, "-o", "v.json"), ("translate", "swirl.json", "0.1,0,0", "-o", "v.json")],
    "sheet": [("s.obj", "-o", "f.png", "--vary", "texture-seed=1,2", "--size", "24x24", *LOW),
              ("s.obj", "-o", "f.png", "--vary", "texture-seed=1,2", "--size", "24x24", "--preview", "mesh", *LOW)],
    "slice": [("s.obj", "-o", "f.png", "--size", 24, *LOW), ("s.vdb", "-o", "f.png", "--field", "grid", "--size", 24),
              ("made.vdb", "-o", "f.png", "--field", "f", "--size", 24),
              ("s.vdb", "-o", "f.####.png", "--field", "grid", "--size", 24, "--frames", "1-2"),
              ("s.vdb", "-o", "f.png", "--field", "grid", "--stack", "--range", 0.4, "--size", 6),
              ("--map", "mandelbulb", "-o", "f.png", "--size", 24, "--field", "f", "--resolution", 14)],
    "study": [("s.obj", "-o", "f.png", "--size", 16, "--versors", 4, *LOW),
              ("s.obj", "--dimension", "10,12,14", "--sdf-resolution", 16),
              ("s.obj", "--strokes", "s.ply", "--grain", "along", "--sdf-resolution", 16)],
    "render": [("made.vdb", "-o", "f.png", "--size", "24x24"), ("s.obj", "-o", "f.png", "--size", "24x24"),
               ("--field", "s.obj", "-o", "f.png", "--size", "24x24", *LOW),
               ("--field", "--map", "cross", "-o", "f.exr", "--size", "12x12", "--resolution", 14),
               ("made.vdb", "-o", "f.####.png", "--size", "24x24", "--frames", "1-2", "--key", "zoom@1=1", "--key", "zoom@4=1.5")],
    "fit": [("hollow.obj", "-o", "f.json", "--roots", 5, "--resolution", 17),
            ("s.obj", "-o", "f.json", "--roots", 5, "--resolution", 17),
            ("pair.vdb", "--grid", "phi", "-o", "f.json", "--roots", 5, "--resolution", 17),
            ("turned.vdb", "--invert", "-o", "f.json", "--roots", 5, "--resolution", 17),
            ("open.obj", "--repair", "-o", "f.json", "--schedule", "7(VF)", "--resolution", 17),
            ("s.obj", "-o", "f.json", "--roots", 5, "--resolution", 17, "--charge", "g.ply")],
    "info": [("rod.obj",), ("made.vdb",)],
    "maps": [()],
    "recipe": [("made.vdb",)],
    "usd": [("made.vdb", "-o", "f.usda"), ("--mesh", "s.obj", "-o", "f.usda"), ("grow.####.vdb", "-o", "f.usda", "--frames", "1-2")],
}

# Of the options of a fractal those have to act in one of these commands.
FRACTALS = ("fractal", "sheet", "slice", "study", "render")

# Values that do something, for options whose placeholder says too little: of a command, or of all. The second of two is
# for runs that have the first one.
LOOK = {"up": "z", "alpha-clarity": "0.02", "delta": "2", "epsilon": "0.05", "azimuth": "50", "elevation": "50", "fov": "50",
        "zoom": "2", "eye": "2,2,4", "look-at": "0.2,0,0", "samples": "1", "size": "20x20", "material": "bronze", "light": "60,20",
        "sky": "0.2", "background": "#203040", "exposure": "1"}
VALUES = {
    "fit": {"method": "kim15", "resolution": "15", "alpha": "30", "epsilon": "0.3", "roots": "7", "weights": "layers", "schedule": "9(VF)",
            "smooth": "2", "triangles": "300", "target-iou": "0.3", "seed": "5", "start": "monopoles", "power-penalty": "0.01"},
    "print": {"longest-side": "50", "target-up": "z", "resolution": "22", "tolerance": "0.7", "islands": "2", "flat-base": "5",
              "min-thickness": "8", "thin": "drop"},
    "render": {**LOOK, "sampling": "trilinear", "passes": "ao", "turn": "90", "key": "zoom@1=3", "ease": "zoom=smooth", "roots": "beside.json"},
    "slice": {"size": "20", "bits": "16", "field": "iterations", "range": "0.5", "axis": "x", "position": "0.1", "arrow": "0.1,0.2,0"},
    "study": {"strokes": "other.ply", "size": "12", "dimension": "11,12,13", "axis": "x", "position": "0.1", "versors": "3"},
    "sheet": {**LOOK, "sampling": "trilinear", "vary": "iterations=1,2", "columns": "1", "preview": ("mesh", "field")},
    "points": {"points": "80", "spacing": "0.4", "seed": "5"},
    "mesh": {"input": "t.ply"},
    "versor": {"seed": "5", "roots": "4", "powers": "3:4", "placement": ("cluster", "inside"), "box": "0,0,0,1,1,1",
               "centre": "1,0,0", "radius": "0.3", "texture": "shells"},
    "usd": {"frames": "2", "fps": "12", "meters-per-unit": "0.01", "mesh": "t.ply", "package": "p.usdz"},
    "convert": {"nvdb-bits": "8", "grid-names": "phi=d"},
    "sdf": {"band": "5", "grid-names": "houdini", "config": "half.txt"},
    "": {
        "grid": "surface", "sdf-resolution": "19", "sdf-voxel-size": "0.11", "resolution": "15", "voxel-size": "0.15",
        "repair-gap": "1.2", "solidify": "0.4", "thicken": "0.7", "points-radius": "0.7", "iso": "0.05", "map": ("mandelbulb", "quadratic"),
        "iterations": "2", "escape": "3", "slice": "0.2", "drop-axis": "j", "rational": "roots.json", "c": "0.3,0.2,0.1",
        "scheme": "3", "pair": "B", "f": "x*x, y, z", "g": "cos(x), y, z", "radius": "3", "power": "5", "theta": "pole",
        "detail": "0.6", "outward": "0.25", "mask": "0.5", "alpha": "15", "beta": "0.03", "sampling": "quadratic",
        "texture": "roots.json", "texture-seed": "9", "texture-roots": "5", "texture-powers": "3:5",
        "texture-placement": "inside", "texture-distance": "0.2", "texture-centre": "0.2,0,0", "texture-radius": "0.3",
        "texture-over": ("coral", "rings"), "texture-over-seed": "9", "texture-over-frequency": "fine", "texture-mix": "0.9",
        "grain": ("around", "1,0.5,0"), "grain-turn": "40",
        "rest": ("two.obj", "bent.obj"), "rest-frame": "6", "rest-attribute": ("rest", "home"), "rest-depth": "kept",
        "texture-symmetry": "3:y", "texture-scale": "1.5", "texture-translate": "0.1,0,0", "origin": "0.1,0,0", "origin-near": "0.4,0,0",
        "origin-shift": "0.1,0,0", "space": "world", "box": "-0.6,-0.5,-0.3,0.7,0.8,0.9", "seed-stride": "32",
        "tolerance": "0.4", "adaptivity": "2", "crumbs": "keep", "largest": "1", "min-size": "0.9", "precision": "double",
        "grids": "surface,density", "lod": "100%,40%", "grid-names": "surface=shape", "units": "mm", "attributes": "iterations", "colour": "trap:magma",
        "transfer": "weight", "target-up": "z", "up": ("z", "y"), "frame": "3", "frames": ("1-2", "1-3"), "key": "iterations@1=2",
        "target-frame": "24", "target-fps": "30", "target-animation": "jump",
        "target-before": "back.obj", "target-after": ("on.obj", "back.obj"), "fps": "30", "ease": "step", "search": ".", "config": "list.txt", "nvdb-bits": "8", "threads": "1", "instructions": "portable", "device": "cpu", "memory": "64G",
        "progress": "json", "mesh": "g.ply", "curve": "c.png", "csv": "c.csv", "report": "r.csv", "plot": "p.png", "charge": "c.ply",
    },
}

# What changes nothing of what a run makes, and which test holds what it does. The first run of each command is enough for it.
CHANGES_NOTHING = {
    "threads": "no bit depends on the number of threads: cli_determinism",
    "instructions": "nor on the instruction set: cli_determinism",
    "device": "nor on the device: cli_device",
    "memory": "what is too large is refused: cli_resources",
    "trust-importer": "nothing else is read with it than before: cli_targets",
    "quiet": "it says less on the way: cli_progress",
    "verbose": "it says more at the end: cli_progress",
    "search": "files that have moved are found: cli_moved_files",
    "force": "frames that are there are made again: cli_sequence",
    "keep-going": "the frames behind one that fails are made: cli_sequence",
    "no-skip": "for checking: every sample is evaluated, and the picture stays: cli_render_field",
    "exhaustive": "for checking: every node is evaluated, and the set stays: cli_laws",
    "config": "a recipe may say nothing new, and cli_makers has one that does",
}

# What acts where the data let it, and may change nothing where they do not.
DEPENDS_ON_DATA = {
    "repair": "a closed mesh needs none",
    "repair-gap": "a mesh may have no gap of that width",
    "hollows": "a solid may have no hollow",
    "grid": "the only grid may be named too",
    "origin": "without a target it moves a picture's frame with the set",
    "origin-shift": "without a target it moves a picture's frame with the set",
    "origin-near": "one ball in the target may be the largest by far",
    "drop-axis": "a set may be the mirror image of itself",
    "precision": "a picture may show no difference of rounding",
    "resolution": "of a picture it decides the arithmetic alone",
    "voxel-size": "of a picture it decides the arithmetic alone",
    "crumbs": "there may be none",
    "largest": "there may be one island only",
    "islands": "there may be one island only",
    "cap": "the set may end before its region does",
    "mandelbrot": "it is on without --c, and may be said",
    "thin": "nothing may be thin",
    "from-grid": "what holds no recipe is read so in any case",
    "radius": "it bounds the region of a set that it does not change",
}

# Likewise, in runs with this value.
DEPENDS_WITH = {
    ("method", "--schedule"): "a schedule chooses the method that has one",
    ("sdf-resolution", "rational"): "the distances say whether the middle of the target lies inside, and no more",
    ("sdf-voxel-size", "rational"): "the distances say whether the middle of the target lies inside, and no more",
}


def content(path):
    """A file without the recipe in it."""
    data = path.read_bytes()
    if path.suffix == ".vdb":
        return grids(data)
    if path.suffix == ".ply":
        head, mark, body = data.partition(b"end_header\n")
        return re.sub(rb"comment juliavdb (?!julia_(?:up_axis|length_unit) )[^\n]*\n", b"", head) + mark + body
    if path.suffix == ".obj":
        return re.sub(rb"(?m)^# juliavdb (?!julia_(?:up_axis|length_unit) )[^\n]*\n", b"", data)
    if path.suffix == ".glb":
        size = struct.unpack_from("<I", data, 12)[0]
        head = json.loads(data[20:20 + size])
        extras = head["asset"].pop("extras", {})
        return [head, extras.get("julia_up_axis"), extras.get("julia_length_unit"), data[20 + size:]]
    if path.suffix == ".json" and b'"juliavdb": "rational"' in data:
        return re.sub(rb'\n *"note": [^\n]*\n', b"\n", data)
    return data


def grids(data):
    """The grids of a VDB, from their transforms on, which axis is up, and the unit."""
    at = 8 + 4 + 4 + 4 + 1 + 36

    def number(layout):
        nonlocal at
        at += struct.calcsize("<" + layout)
        return struct.unpack_from("<" + layout, data, at - struct.calcsize("<" + layout))[0]

    def text():
        nonlocal at
        size = number("I")
        at += size
        return data[at - size:at]

    def metadata():
        return {text(): (text(), text())[1] for _ in range(number("I"))}

    said, found = metadata(), []
    for _ in range(number("I")):
        name = text(), text(), text()
        at, _, end = number("q"), number("q"), number("q")
        number("I")
        metadata()
        found.append((name, data[at:end]))
        at = end
    return said.get(b"julia_up_axis"), said.get(b"julia_length_unit"), found


class Options(harness.CliTest):

    def setUp(self):
        super().setUp()
        points, faces = harness.torus()
        self.write("t.ply", "ply\nformat ascii 1.0\n" f"element vertex {len(points)}\n"
                   "property float x\nproperty float y\nproperty float z\nproperty float weight\n"
                   f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n" +
                   "".join("{!r} {!r} {!r} {!r}\n".format(*p, p[0]) for p in points) +
                   "".join("3 {} {} {}\n".format(*f) for f in faces))
        self.write("s.obj", harness.obj(harness.lumpy()))
        points, faces = harness.lumpy()
        thin = [(x * (1.2 + 0.4 * y), y, z) for x, y, z in points]
        self.write("rest.obj", harness.obj((thin, faces)))
        rod = test_motion.tilted(([(0.1 * z, x, 0.1 * y) for x, y, z in points], faces))
        self.write("rod.obj", harness.obj(rod))
        self.write("rod_rest.obj", harness.obj(([(x * (1.2 + 0.4 * y), y, z) for x, y, z in rod[0]], faces)))
        self.write("bent.obj", harness.obj(test_motion.bent((points, faces), 30)))
        self.write("home.ply", test_motion.with_rest((points, faces), (thin, faces), "home", points))
        self.write("on.obj", harness.obj(harness.moved(harness.lumpy(), 1, (0.1, 0, 0))))
        self.write("back.obj", harness.obj(harness.moved(harness.lumpy(), 1.1, (0, 0.1, 0))))
        ball, more = harness.sphere(2), harness.moved(harness.sphere(2), 0.5, (3, 0, 0))
        self.write("two.obj", harness.obj((ball[0] + more[0],
                                           ball[1] + [tuple(k + len(ball[0]) for k in f) for f in more[1]])))
        self.write("hollow.obj", harness.obj((ball[0] + harness.moved(ball, 0.5, (0, 0, 0))[0],
                                              ball[1] + [tuple(k + len(ball[0]) for k in f[::-1]) for f in ball[1]])))
        self.write("open.obj", harness.obj(harness.with_hole(harness.lumpy())))
        points, faces = harness.sphere(3)
        self.write("fin.obj", harness.obj(([(x, 0.05 * y if x > 0.3 else y, z) for x, y, z in points], faces)))
        self.write("swirl.json", harness.rational_json(harness.ROOTS))
        self.write("roots.json", harness.rational_json(harness.ROOTS[:2]))
        self.write("walk.gltf", test_animation.walk().text())
        self.write("list.txt", "iterations = 2\n")
        self.write("half.txt", "half = true\n")
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 20)
        self.ok("fractal", "s.obj", "-o", "made.vdb", *LOW)
        self.ok("fractal", "t.ply", "-o", "ring.vdb", *LOW)
        self.ok("fractal", "--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", "-o", "quadratic.vdb", "--resolution", 14)
        self.ok("sdf", "t.ply", "-o", "t.vdb", "--resolution", 20)
        phi, other = (pyopenvdb.read(str(self.path(name)), "phi") for name in ("s.vdb", "t.vdb"))
        other.name = "surface"
        pyopenvdb.write(str(self.path("pair.vdb")), grids=[phi, other])
        phi.mapAll(lambda value: -value)
        pyopenvdb.write(str(self.path("turned.vdb")), grids=[phi])
        for frame in (1, 2, 3):
            shutil.copy(self.path("made.vdb"), self.path(f"grow.{frame:04d}.vdb"))
        self.ok("fit", "s.obj", "-o", "fitted.json", "--roots", 30, "--resolution", 17)
        self.ok("versor", "translate", "fitted.json", "0.6,0,0", "-o", "beside.json")

    def options_of(self, command):
        """What the program says of each option of a command, by name."""
        page = json.loads(self.ok(*command.split(), "--describe", "json", data=True))
        options = {option["name"]: option for group in page["groups"] for option in group["options"]}
        self.assertIn("threads", options, f"the options of '{command}' cannot be read")
        options.pop("help", None)
        return options

    @staticmethod
    def value_for(command, words, option):
        """A value other than the default, of VALUES or of the option's type."""
        name, type_ = option["name"], option.get("type", {})
        for values in (VALUES.get(command, {}), VALUES[""]):
            if name in values:
                first, *others = [values[name]] if isinstance(values[name], str) else values[name]
                there = f"--{name}" in words and words[words.index(f"--{name}") + 1] == first
                return others[0] if there and others else first
        usual = option.get("default", "")
        choices = [word for word in type_.get("words", option["argument"].split("|")) if re.fullmatch(r"[a-z-]+", word)]
        others = [word for word in choices if word != usual]
        if others:
            return others[-1]
        if type_.get("kind") == "vector":
            return "0.1,0,0"
        middle = (type_.get("low", 0) + type_["high"]) / 2 if "high" in type_ else 2 * float(usual or 0) or 1
        return str(int(middle)) if type_.get("kind") == "whole" else f"{middle:g}"

    def words_with(self, command, run, option):
        """The run with the option, in the place of the same one or of the one that says it in another way; or without a flag
        that it has."""
        words, name = list(map(str, run)), option["name"]
        if not option["argument"] and f"--{name}" in words:
            return [word for word in words if word != f"--{name}"]
        value = option["argument"] and self.value_for(command, words, option)
        rivals = {"voxel-size": "resolution", "sdf-voxel-size": "sdf-resolution", "spacing": "points", "points": "spacing"}
        for other in (name, rivals.get(name, name)):
            if f"--{other}" in words:
                at = words.index(f"--{other}")
                del words[at:at + 2]
        if name == "output":
            at = words.index("-o") if "-o" in words else len(words)
            old = words[at + 1] if "-o" in words else "f.json"
            del words[at:at + 2]
            return [*words, "-o", f"other{old[old.find('.'):]}"]
        words = [word for word in words if not word.startswith(f"--{name}=")]
        # With these, and only with these, print makes voxels, of which 300 along the part take minutes under a sanitizer.
        if command == "print" and name in ("flat-base", "islands", "min-thickness") and "--resolution" not in words:
            words += ["--resolution", "20"]
        return [*words, f"--{name}={value}" if option["argument"] else f"--{name}"]

    def outcome(self, copies, number, command, words):
        """What a run makes and says, in a folder of its own."""
        place = self.path(f"run{number}")
        place.mkdir()
        inputs = [file for file in self.folder.iterdir() if file.is_file()]
        for file in inputs:
            (place / file.name).symlink_to(file)
        code, told, said = copies.run(harness.quiet((command, *words)), place)
        made = {str(file.relative_to(place)): content(file) for file in place.rglob("*")
                if file.is_file() and not file.is_symlink()}
        shutil.rmtree(place)
        return code, made, told, re.sub(r"\d+ rays, \d+ a second", "", said.decode(errors="replace"))

    def outcomes(self, jobs):
        """Of all, in their order, by as many at once as there are processors."""
        workers = max(2, os.cpu_count() or 1)
        free = queue.SimpleQueue()
        for copies in [harness.Copies() for _ in range(workers)]:
            self.addCleanup(copies.close)
            free.put(copies)

        def work(job):
            number, (command, words) = job
            copies = free.get()
            try:
                return self.outcome(copies, number, command, words)
            finally:
                free.put(copies)

        with concurrent.futures.ThreadPoolExecutor(workers) as pool:
            return list(pool.map(work, enumerate(jobs)))

    # Promise of architecture.md: "Where an option can do nothing", an option is refused, with the reason and what else to give
    def test_every_option_acts_or_is_refused(self):
        first, second, of_fractals = [], [], self.options_of("fractal")
        for command, runs in RUNS.items():
            options = self.options_of(command)
            for row, run in enumerate(runs):
                first.append((command, None, None, run, run))
                for column, (name, option) in enumerate(options.items()):
                    if row > 0 and name in CHANGES_NOTHING:
                        continue
                    scope = FRACTALS if command in FRACTALS and name in of_fractals else (command, )
                    now = ALL or row == 0 or (row + column) % 3 == 0
                    (first if now else second).append((command, scope, name, run, self.words_with(command, run, option)))
        plain, acts = {}, set()
        self.judge(first, plain, acts)
        self.judge([job for job in second if job[1:3] not in acts], plain, acts)
        for scope, name in sorted({job[1:3] for job in first + second if job[2]} - acts):
            if name not in CHANGES_NOTHING:
                with self.subTest(option=name, commands=scope):
                    self.fail(f"--{name} changes no run; give it a value in VALUES, and a run to act on")

    def judge(self, jobs, plain, acts):
        """@param plain  the outcomes of the runs without an option, by command and run; those of the jobs are added
        @param acts   the options that change a run, each with its scope; those of the jobs are added"""
        results = self.outcomes([(command, words) for command, scope, name, run, words in jobs])
        for (command, scope, name, run, words), (code, made, told, said) in zip(jobs, results):
            line = f"juliavdb {command} {' '.join(map(str, words))}"
            if name is None:
                self.assertEqual(code, DONE, f"{line}\n{said}")
                plain[command, run] = code, made, told, said
                continue
            if (code, made, told, said) != plain[command, run]:
                acts |= {(scope, name)} if code == DONE or f"--{name}" not in words[-1] else set()
                with self.subTest(line=line):
                    self.assertNotIn("crashed", said)
                    self.assertTrue(code != USAGE or said.count("\n") == 1, said)
                continue
            if not {name, *((name, word) for word in words)} & {*CHANGES_NOTHING, *DEPENDS_ON_DATA, *DEPENDS_WITH}:
                with self.subTest(line=line):
                    self.fail(f"--{name} is accepted, and changes nothing")


class Refusals(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(2)))

    # Promise: "Where an option can do nothing", an option ...
    def test_a_refusal_names_the_option_the_reason_and_the_way_out(self):
        run = ("fractal", "s.obj", "-o", "f.vdb", *LOW)
        self.refused(USAGE, *run, "--seed-stride", 2, mentions=("--seed-stride", "--follow", "leave it out"))
        self.refused(USAGE, *run, "--cap", "--box", BOX, mentions=("--cap", "mesh", "leave it out"))
        self.refused(USAGE, *run, "--mesh", "f.ply", "--cap", mentions=("--cap", "--box"))
        self.refused(USAGE, *run, "--mesh", "f.ply", "--lod", "100%,10%", mentions=("--lod", "GLB"))
        self.refused(USAGE, "fractal", "s.obj", "--mesh", "f.ply", *LOW, "--half", mentions=("--half", "VDB"))

    # Promise of architecture.md: "What comes from a recipe may do nothing"
    def test_a_recipe_that_is_read_back_may_say_what_has_no_effect(self):
        """Only what is typed is refused: a file's recipe holds all defaults, and serves other outputs."""
        said = ("--grids", "surface,density", "--half", "--adaptivity", 0.2, "--follow", "--seed-stride", 4, "--box", BOX, "--cap")
        self.ok("fractal", "s.obj", "-o", "f.vdb", "--mesh", "f.ply", *LOW, *said)
        self.ok("fractal", "--config", "f.vdb", "--mesh", "again.ply")
        self.assertEqual(self.bytes("again.ply"), self.bytes("f.ply"))
        self.ok("fractal", "--config", "f.ply", "-o", "again.vdb")
        self.assertEqual(self.bytes("again.vdb"), self.bytes("f.vdb"))
        for command in (("slice", "f.vdb", "--size", 20), ("render", "--field", "f.vdb", "--size", "20x20")):
            self.ok(*command, "-o", "f.png")
        self.write("list.txt", "half = true\ncap = true\n")
        self.ok("fractal", "s.obj", "--config", "list.txt", "--mesh", "listed.stl", *LOW)

    # Promise: "Where an option can do nothing", an option ...
    def test_a_plan_refuses_what_one_run_refuses(self):
        """Tiles, frames and cells are fractals, and their options have the same effects."""
        self.ok("sheet", "s.obj", "-o", "x.png", "--vary", "alpha=20,40", "--size", "20x20", *LOW)
        keys = ("--frames", "1-2", "--key", "alpha@1=20", "--key", "alpha@2=40")
        plans = (("plan", "tiles", "s.obj", *LOW), ("plan", "frames", "s.obj", *keys, *LOW), ("plan", "sheet", "x.json"))
        idle = {"vdb": (("--cap", "--box", BOX), ("--lod", "100%,10%"), ("--seed-stride", 2)), "ply": (("--half",), ("--cap",)),
                "glb": (("--up", "z"), ("--grids", "density"))}
        for make, options in idle.items():
            for option in options:
                for plan in plans:
                    self.refused(USAGE, *plan, "-o", "plan", "--make", make, *option, mentions=(option[0], "has no effect"))
        for plan in plans:  # what they make by default is no GLB either
            self.refused(USAGE, *plan, "-o", "plan", "--lod", "100%,10%", mentions=("--lod", "GLB"))
            self.ok(*plan, "-o", "plan", "--make", "vdb,ply", "--half", "--cap", "--box", BOX)
            shutil.rmtree(self.path("plan"))

    def test_two_languages_exclude_each_other_however_they_are_given(self):
        pairs = (("alpha", 10, "detail", 0.9), ("detail", 0.3, "alpha", 20), ("beta", 0.01, "outward", 0.2),
                 ("outward", 0.2, "alpha", 20))
        for one, value, other, another in pairs:
            way = ("--key", f"{one}@1={value}")
            for words in ((f"--{one}", value, f"--{other}", another, "-o", "f.vdb"),
                          (*way, f"--{other}", another, "--frames", "1-2", "-o", "f.####.vdb"),
                          (*way, "--key", f"{other}@1={another}", "--frames", "1-2", "-o", "f.####.vdb")):
                self.refused(USAGE, "fractal", "s.obj", *LOW, *words, mentions=(f"--{one}", f"--{other}"))
            self.refused(USAGE, "plan", "frames", "s.obj", *LOW, *way, f"--{other}", another, "--frames", "1-2", "-o", "plan",
                         mentions=(f"--{one}", f"--{other}"))
            self.refused(USAGE, "sheet", "s.obj", *LOW, "--vary", f"{one}={value}", f"--{other}", another, "-o", "x.png",
                         "--size", "20x20", mentions=(f"--{one}", f"--{other}"))
        self.write("roots.json", harness.rational_json(harness.ROOTS))
        self.refused(USAGE, "fractal", "s.obj", *LOW, "--key", "texture@1=roots.json", "--texture-roots", 5, "--frames", "1-2", "-o",
                     "f.####.vdb", mentions="--texture-roots")

    def test_an_option_has_the_name_of_its_entry_too(self):
        run = ("fractal", "s.obj", *LOW, "--texture", "random")
        for name, seed in (("new", "--texture-seed"), ("old", "--versor-seed")):
            self.ok(*run, seed, 4, "-o", f"{name}.vdb")
            self.ok("sheet", "s.obj", *LOW, "--vary", f"{seed[2:]}=1,2", "-o", f"{name}.png", "--size", "20x20")
            self.write(f"{name}.txt", f"{seed[2:]} = 4\n")
            self.ok(*run, "--config", f"{name}.txt", "-o", f"{name}-list.vdb")
            self.assertIn("--texture-seed S", self.ok("fractal", "--help", seed[2:], data=True))
        self.assertEqual(self.bytes("new.vdb"), self.bytes("old.vdb"))
        self.assertEqual(self.bytes("new.vdb"), self.bytes("new-list.vdb"))
        self.assertEqual(self.bytes("new.vdb"), self.bytes("old-list.vdb"))
        self.assertEqual(self.bytes("new.png"), self.bytes("old.png"))
        self.assertIn(b"julia_texture_seed", self.bytes("new.vdb"))
        self.refused(USAGE, *run, "--texture-seed", 4, "--versor-seed", 4, "-o", "x.vdb", mentions="--texture-seed")
        self.refused(USAGE, *run, "--textur-seed", 4, "-o", "x.vdb", mentions="did you mean '--texture-seed'?")
        self.write("both.txt", "texture-seed = 4\nversor-seed = 4\n")
        self.refused(USAGE, *run, "--config", "both.txt", "-o", "x.vdb", mentions="twice")

    # Promise: "Where an option can do nothing", an option ...
    def test_keys_and_varied_options_act_too(self):
        self.refused(USAGE, "fractal", "s.obj", *LOW, "--key", "seed-stride@1=4", "--frames", "1-2", "-o", "f.####.vdb",
                     mentions=("--seed-stride", "--follow"))
        self.refused(USAGE, "sheet", "s.obj", *LOW, "--vary", "texture-radius=0.1,0.2", "--size", "20x20", "-o", "x.png",
                     mentions=("--texture-radius", "cluster"))
        # One frame, or one cell, in which an option acts is enough.
        self.ok("fractal", "s.obj", *LOW, "--key", "texture@1=scales", "--key", "texture@2=random", "--ease", "step",
                "--texture-seed", 3, "--frames", "1-2", "-o", "f.####.vdb")

    # Promise of farm.md: A plan's folder that cannot be made is refused "before the plan is computed"
    def test_a_plan_finds_at_once_that_its_folder_cannot_be_made(self):
        """Before any work: a target that cannot be used is not even looked at."""
        self.write("open.obj", harness.obj(harness.with_hole(harness.sphere(2))))
        for plan in (("tiles",), ("frames", "--frames", "1-2", "--key", "alpha@1=20")):
            self.refused(harness.CANNOT_CREATE, "plan", *plan, "open.obj", "-o", "/proc/plan", mentions="/proc/plan")
        self.refused(harness.BAD_DATA, "plan", "tiles", "open.obj", "-o", "new/plan", *LOW)
        self.assertFalse(self.path("new").exists())

    # Promise of design.md: "A file that cannot be read does not keep `info` from the others"
    def test_info_shows_every_file_that_it_can(self):
        self.write("bad.obj", "f 1 2 3\n")
        self.write("t.obj", harness.obj(harness.torus()))
        for words in ((), ("--json", )):
            alone = [self.ok("info", name, *words, data=True) for name in ("s.obj", "t.obj")]
            run = self.run_program("info", "s.obj", "bad.obj", "missing.obj", "t.obj", *words)
            self.assertEqual((run.returncode, run.stdout.decode()), (harness.BAD_DATA, "".join(alone)))
            for name in (b"bad.obj", b"missing.obj"):
                self.assertIn(name, run.stderr)


class Numbers(harness.CliTest):

    # Promise: "Messages have numbers of four ..."
    def test_messages_have_no_digits_that_mean_nothing(self):
        """No number of what a run says has more than four significant digits, but for whole numbers."""
        self.write("s.obj", harness.obj(harness.lumpy()))
        self.write("open.obj", harness.obj(harness.with_hole(harness.lumpy())))
        self.write("c.obj", "".join("v {!r} {!r} {!r}\n".format(*p) for p in harness.sphere(3)[0]))
        runs = [("fractal", "open.obj", "--repair", "-o", "f.vdb", "--mesh", "f.glb", "--lod", "100%,30%", *LOW),
                ("fractal", "s.obj", "-o", "g.vdb", "--follow", "--resolution", 60, "--sdf-resolution", 16),
                ("sdf", "open.obj", "--repair", "-o", "d.vdb", "--resolution", 20),
                ("sdf", "c.obj", "--points-radius", 0.31, "-o", "c.vdb", "--resolution", 20),
                ("points", "s.obj", "-o", "p.ply", "--spacing", 0.3), ("points", "f.vdb", "-o", "q.ply", "--points", 90),
                ("print", "f.vdb", "-o", "p.stl", "--longest-side", 60, "--min-thickness", 7, "--flat-base", 2, "--resolution", 30),
                ("study", "s.obj", "--alpha", 20, "-o", "s.png", "--size", 16, "--versors", 3, *LOW),
                ("fit", "s.obj", "-o", "r.json", "--schedule", "7(VF)", "--resolution", 17)]
        for words in runs:
            said = self.ok(*words)
            for number in re.findall(r"(?<![\w.])-?(\d*\.\d+)", said):
                with self.subTest(words=words, said=said):
                    self.assertLessEqual(len(number.replace(".", "").lstrip("0")), 4, number)

    # Promise of controls.md: With `--box` the share that is left is "of the part of the target within the box"
    def test_a_box_is_compared_with_the_part_of_the_target_in_it(self):
        self.write("s.obj", harness.obj(harness.sphere(3)))
        shares = []
        for box in ("-2,-2,-2,2,2,2", "0,-2,-2,2,2,2", "0.2,0.2,0.2,0.8,0.8,0.8"):
            said = self.ok("fractal", "s.obj", "-o", "f.vdb", "--box", box, "--detail", 0.15, "--resolution", 40,
                           "--sdf-resolution", 40)
            self.assertNotIn("warning", said)
            shares.append(float(re.search(r"the set holds ([\d.]+) % of the target's volume within the box", said)[1]))
        self.assertAlmostEqual(shares[0], shares[1], delta=3)
        self.assertIn("warning", self.ok("fractal", "s.obj", "-o", "f.vdb", "--box", "0,-2,-2,2,2,2", "--detail", 0.99,
                                         "--outward", 0, "--resolution", 40, "--sdf-resolution", 40))


if __name__ == "__main__":
    harness.main()

# SPDX-License-Identifier: Apache-2.0
"""Units: what each format says of them, by readers that are not this program's (JSON, zip and XML, pyopenvdb, tifffile)."""

import io
import json
import re
import shutil
import struct
import xml.etree.ElementTree as xml
import zipfile

import pyopenvdb
import tifffile

import harness
from harness import USAGE

LOW = ("--resolution", 24, "--sdf-resolution", 24)
METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
UNIT = "julia_length_unit"


def box_of(points):
    return [[f(p[k] for p in points) for k in range(3)] for f in (min, max)]


def longest(box):
    return max(high - low for low, high in zip(*box))


class Units(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("t.obj", harness.obj(harness.moved(harness.torus(), 10, (3, 4, 5))))

    def glb(self, name):
        data = self.bytes(name)
        return json.loads(data[20:20 + struct.unpack_from("<I", data, 12)[0]])

    def glb_box(self, name):
        """In the world: the node moves what its accessor has."""
        tree = self.glb(name)
        positions = tree["accessors"][tree["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
        move = tree["nodes"][0].get("translation", [0, 0, 0])
        self.assertFalse({"scale", "matrix", "rotation"} & set(tree["nodes"][0]))
        return [[p + m for p, m in zip(positions[end], move)] for end in ("min", "max")]

    def metadata(self, name):
        return pyopenvdb.readMetadata(str(self.path(name)))

    def usd(self, name):
        return float(re.search(r"metersPerUnit = (\S+)", self.bytes(name).decode()).group(1))

    def close(self, one, other, share=1e-6):
        for low_or_high in (0, 1):
            for a, b in zip(one[low_or_high], other[low_or_high]):
                self.assertAlmostEqual(a, b, delta=share * longest(other))

    # Promise of handoff.md: "Files then have the unit that their format asks for": the table of units
    def test_a_glb_is_in_metres(self):
        self.ok("fractal", "t.obj", *LOW, "--mesh", "plain.ply")
        plain = box_of(harness.read_ply(self.bytes("plain.ply")).points)
        for unit, metres in METRES.items():
            self.ok("fractal", "t.obj", *LOW, "--units", unit, "--mesh", f"{unit}.glb", "--lod", "100%,30%", "-o", f"{unit}.vdb")
            self.close(self.glb_box(f"{unit}.glb"), [[metres * x for x in end] for end in plain])
            self.assertEqual(self.glb(f"{unit}.glb")["asset"]["extras"][UNIT], "m")
            self.assertEqual(self.metadata(f"{unit}.vdb")[UNIT], unit)
        # The error of a level is a length, too.
        errors = {unit: self.glb(f"{unit}.glb")["nodes"][1]["extras"]["error"] for unit in METRES}
        for unit, metres in METRES.items():
            self.assertAlmostEqual(errors[unit] / (metres * errors["m"]), 1, delta=0.2)

    # Promise: "Files then have the unit ..."
    def test_far_from_the_origin_too(self):
        self.write("far.obj", harness.obj(harness.moved(harness.sphere(3), 1, (1e5, -1e5, 1e5))))
        for name, words in (("m", ("--units", "m")), ("mm", ("--units", "mm"))):
            self.ok("fractal", "far.obj", *LOW, *words, "--mesh", f"{name}.glb")
        self.close(self.glb_box("mm.glb"), [[1e-3 * x for x in end] for end in self.glb_box("m.glb")], 1e-4)

    # Promise: "Files then have the unit ..."
    def test_other_formats_keep_the_coordinates_and_say_the_unit(self):
        self.ok("fractal", "t.obj", *LOW, "--mesh", "a.ply", "-o", "a.vdb")
        for unit in METRES:
            said = ("--units", unit)
            self.ok("fractal", "t.obj", *LOW, *said, "--mesh", "b.ply", "-o", "b.vdb")
            self.assertEqual(self.bytes("b.ply").partition(b"end_header")[2], self.bytes("a.ply").partition(b"end_header")[2])
            self.assertIn(f"comment juliavdb {UNIT} {unit}\n".encode(), self.bytes("b.ply"))
            one, other = (pyopenvdb.read(str(self.path(name)), "surface") for name in ("a.vdb", "b.vdb"))
            for node in ((0, 0, 0), (9, -3, 7)):
                self.assertEqual(one.transform.indexToWorld(node), other.transform.indexToWorld(node))
            self.assertEqual(other.metadata[UNIT], unit)
            self.ok("mesh", "b.vdb", "-o", "b.obj")
            self.assertIn(f"# juliavdb {UNIT} {unit}\n".encode(), self.bytes("b.obj"))
            self.close(box_of(harness.read_obj(self.bytes("b.obj")).points), box_of(harness.read_ply(self.bytes("a.ply")).points))
            self.ok("mesh", "b.vdb", "-o", "b.stl")
            self.assertIn(f"unit {unit}".encode(), self.bytes("b.stl")[:80])
            self.assertFalse(self.bytes("b.stl").startswith(b"solid"))
            for name in ("b.vdb", "b.ply", "b.obj", "b.stl"):
                info = self.info(name)
                self.assertEqual(info.get("unit", info.get("metadata", {}).get(UNIT)), unit, name)

    # Promise of handoff.md: Without `--units` "no unit is recorded, and every file has the coordinates of the target"
    def test_without_a_unit_no_file_names_one(self):
        self.ok("fractal", "t.obj", *LOW, "-o", "a.vdb", "--mesh", "a.glb")
        for made in ("a.ply", "a.obj", "a.stl"):
            self.ok("mesh", "a.vdb", "-o", made)
        self.ok("points", "a.vdb", "--points", 50, "-o", "p.ply")
        self.ok("usd", "a.vdb", "-o", "a.usda")
        for name in ("a.vdb", "a.glb", "a.ply", "a.obj", "a.stl", "p.ply"):
            self.assertNotIn(UNIT.encode(), self.bytes(name))
            self.assertNotIn(b"julia_units", self.bytes(name))
        self.assertEqual(self.bytes("a.stl")[:80].rstrip(b"\0"), b"JuliaVDB")
        self.assertEqual(self.usd("a.usda"), 1)
        self.close(self.glb_box("a.glb"), box_of(harness.read_ply(self.bytes("a.ply")).points))

    # Promise of handoff.md: "State it once": later commands take the unit from their input
    def test_later_commands_know_the_unit(self):
        self.ok("sdf", "t.obj", "--units", "mm", "-o", "sdf.vdb", "--resolution", 24)
        self.assertEqual(self.metadata("sdf.vdb")[UNIT], "mm")
        # The target says it; the recipe of the fractal need not.
        self.ok("fractal", "sdf.vdb", "--resolution", 24, "-o", "f.vdb", "--mesh", "f.ply")
        self.assertEqual(self.metadata("f.vdb")[UNIT], "mm")
        box = box_of(harness.read_ply(self.bytes("f.ply")).points)
        metres = [[1e-3 * x for x in end] for end in box]
        self.ok("mesh", "f.vdb", "-o", "f.glb")
        self.close(self.glb_box("f.glb"), metres)
        self.ok("mesh", "f.vdb", "--from-grid", "-o", "g.glb")
        self.close(self.glb_box("g.glb"), metres, 0.05)
        for name in ("p.ply", "p.vdb"):
            self.ok("points", "f.vdb", "--points", 50, "-o", name)
        self.assertIn(f"comment juliavdb {UNIT} mm\n".encode(), self.bytes("p.ply"))
        self.assertEqual(self.metadata("p.vdb")[UNIT], "mm")
        self.ok("usd", "f.vdb", "--mesh", "f.ply", "-o", "f.usda")
        self.assertEqual(self.usd("f.usda"), 1e-3)
        self.ok("slice", "f.vdb", "--stack", "--size", 8, "-o", "s.####.tif")
        with tifffile.TiffFile(self.path("s.0001.tif")) as file:
            self.assertEqual(file.imagej_metadata["unit"], "mm")
        self.ok("slice", "sdf.vdb", "--field", "grid", "--range", 1, "--stack", "--size", 8, "-o", "d.####.tif")
        with tifffile.TiffFile(self.path("d.0001.tif")) as file:
            self.assertEqual(file.imagej_metadata["unit"], "mm")
        # A mesh of the program as a target: this one is in metres.
        self.ok("fractal", "f.glb", *LOW, "-o", "again.vdb")
        self.assertEqual(self.metadata("again.vdb")[UNIT], "m")
        self.ok("fit", "sdf.vdb", "-o", "r.json", "--resolution", 17, "--roots", 9, "--charge", "c.ply")
        self.assertIn(f"comment juliavdb {UNIT} mm\n".encode(), self.bytes("c.ply"))

    # Promise: "State it once": later commands ...
    def test_tiles_are_merged_with_their_unit(self):
        for words in (("t.obj", "--units", "cm"), ("sdf.vdb", )):
            self.ok("sdf", "t.obj", "--units", "cm", "-o", "sdf.vdb", "--resolution", 24)
            self.ok("plan", "tiles", *words, "--resolution", 24, "-o", "farm", "--tiles", 2, "--make", "vdb,ply,glb")
            self.ok("task", "farm", "--range", "1-2")
            for mesh in ("glb", "ply"):
                self.ok("merge", "farm", "-o", "m.vdb", "--mesh", f"m.{mesh}")
                self.ok("fractal", *words, "--resolution", 24, "-o", "f.vdb", "--mesh", f"f.{mesh}")
                self.assertEqual(self.bytes(f"m.{mesh}"), self.bytes(f"f.{mesh}"))
                self.assertEqual(self.bytes("m.vdb"), self.bytes("f.vdb"))
            self.assertEqual(self.metadata("m.vdb")[UNIT], "cm")
            shutil.rmtree(self.path("farm"))

    # Promise: "Files then have the unit ..."
    def test_a_part_has_its_true_size(self):
        """In a 3MF, whose unit is the millimetre by its attribute, as in all other files of parts."""
        self.ok("fractal", "t.obj", *LOW, "--largest", 1, "--mesh", "plain.ply")
        size = longest(box_of(harness.read_ply(self.bytes("plain.ply")).points))
        for unit, metres in METRES.items():
            self.ok("fractal", "t.obj", *LOW, "--largest", 1, "--units", unit, "-o", "f.vdb")
            self.ok("print", "f.vdb", "-o", "p.stl")
            corners = [p for t in harness.read_stl(self.bytes("p.stl")) for p in t]
            self.assertAlmostEqual(longest(box_of(corners)) / (1000 * metres * size), 1, 5)
            self.assertIn(b"unit mm", self.bytes("p.stl")[:80])
            run = self.run_program("print", "f.vdb", "-o", "p.3mf")
            if b"libzip" in run.stderr:
                continue
            self.assertEqual(run.returncode, 0, run.stderr)
            with zipfile.ZipFile(io.BytesIO(self.bytes("p.3mf"))) as file:
                model = xml.fromstring(file.read("3D/3dmodel.model"))
            self.assertEqual(model.get("unit"), "millimeter")
            points = [tuple(float(v.get(k)) for k in "xyz") for v in model.iter(f"{CORE}vertex")]
            self.assertAlmostEqual(longest(box_of(points)) / (1000 * metres * size), 1, 5)
        self.ok("print", "f.vdb", "-o", "p.stl", "--longest-side", 40)
        self.assertAlmostEqual(longest(box_of([p for t in harness.read_stl(self.bytes("p.stl")) for p in t])), 40, 3)
        self.ok("print", "t.obj", "-o", "p.stl", "--units", "cm")
        self.assertAlmostEqual(longest(box_of([p for t in harness.read_stl(self.bytes("p.stl")) for p in t])), 200, 2)

    # Promise: "Files then have the unit ..."
    def test_a_scene_has_one_unit(self):
        self.ok("fractal", "t.obj", *LOW, "--units", "mm", "-o", "mm.vdb", "--mesh", "mm.glb")
        self.ok("mesh", "mm.vdb", "-o", "mm.ply")
        points = {}
        for mesh in ("ply", "glb"):
            self.ok("usd", "mm.vdb", "--mesh", f"mm.{mesh}", "-o", f"{mesh}.usda")
            self.assertEqual(self.usd(f"{mesh}.usda"), 1e-3)
            listed = re.search(r"point3f\[\] points = \[(.*?)\]", self.bytes(f"{mesh}.usda").decode(), re.S).group(1)
            points[mesh] = box_of([tuple(map(float, p.split(","))) for p in re.findall(r"\(([^)]*)\)", listed)])
        self.close(points["glb"], points["ply"], 1e-5)
        self.ok("usd", "--mesh", "mm.glb", "-o", "m.usda")
        self.assertEqual(self.usd("m.usda"), 1)
        self.ok("fractal", "t.obj", *LOW, "-o", "none.vdb")
        self.ok("usd", "none.vdb", "--units", "in", "-o", "in.usda")
        self.assertEqual(self.usd("in.usda"), 0.0254)
        self.ok("usd", "none.vdb", "--meters-per-unit", 0.3048, "-o", "feet.usda")
        self.assertEqual(self.usd("feet.usda"), 0.3048)
        self.refused(USAGE, "usd", "none.vdb", "--units", "in", "--meters-per-unit", 1, "-o", "x.usda", mentions=("--units", "--meters-per-unit"))
        self.refused(USAGE, "usd", "mm.vdb", "--meters-per-unit", 1, "-o", "x.usda", mentions=("mm.vdb", "--meters-per-unit"))
        self.path("g.0001.vdb").write_bytes(self.bytes("mm.vdb"))
        self.path("g.0002.vdb").write_bytes(self.bytes("none.vdb"))
        self.refused(harness.BAD_DATA, "usd", "g.####.vdb", "--frames", "1-2", "-o", "x.usda", mentions=("g.0002.vdb", "none", "mm"))

    # Promise of handoff.md: "Contradictions are refused", and what is no unit is refused before the work
    def test_what_is_no_unit_is_refused_before_the_work(self):
        """With the good ones; also where a file names another one than the option does."""
        self.ok("fractal", "t.obj", *LOW, "--units", "mm", "-o", "f.vdb", "--mesh", "f.ply")
        self.ok("sdf", "t.obj", "--units", "mm", "-o", "s.vdb", "--resolution", 24)
        # A target that is no mesh: the unit comes first.
        self.write("bad.obj", "f 1 2 3\n")
        wrong = ((("fractal", "bad.obj", "-o", "x.vdb"), ("sdf", "bad.obj", "-o", "x.vdb"), ("mesh", "f.vdb", "-o", "x.ply"),
                  ("points", "bad.obj", "--points", 9, "-o", "x.ply"), ("print", "bad.obj", "-o", "x.stl"), ("usd", "f.vdb", "-o", "x.usda"),
                  ("slice", "bad.obj", "--stack", "-o", "x.####.tif"), ("plan", "tiles", "bad.obj", "-o", "x"),
                  ("fit", "bad.obj", "-o", "x.json", "--charge", "x.ply")))
        for words in wrong:
            for unit in ("ft", "MM", "0.001"):
                self.refused(USAGE, *words, "--units", unit, mentions=("--units", "mm", "cm", "m", "in"))
        other = (("fractal", "s.vdb", "-o", "x.vdb"), ("sdf", "f.ply", "-o", "x.vdb"), ("mesh", "f.vdb", "-o", "x.ply"),
                 ("points", "f.ply", "--points", 9, "-o", "x.ply"), ("print", "f.vdb", "-o", "x.stl"), ("usd", "f.vdb", "-o", "x.usda"),
                 ("slice", "f.vdb", "--stack", "-o", "x.####.tif"), ("fit", "s.vdb", "-o", "x.json", "--charge", "x.ply"))
        for words in other:
            self.refused(USAGE, *words, "--units", "in", mentions=("--units", "'in'", words[1], "mm", "leave --units out"))
            self.assertEqual(list(self.folder.glob("x*")), [])
        self.refused(USAGE, "print", "t.obj", "-o", "x.stl", mentions=("--longest-side", "--units"))
        self.refused(USAGE, "sdf", "t.obj", "-o", "x.nvdb", "--units", "mm", mentions=("--units", ".nvdb"))
        self.refused(USAGE, "render", "--field", "t.obj", "-o", "x.png", "--units", "mm", mentions=("--units", "no effect"))
        self.refused(USAGE, "fit", "t.obj", "-o", "x.json", "--units", "mm", mentions=("--units", "--charge"))
        damaged = self.bytes("f.ply").replace(f"{UNIT} mm".encode(), f"{UNIT} ft".encode())
        self.path("damaged.ply").write_bytes(damaged)
        self.refused(harness.BAD_DATA, "points", "damaged.ply", "--from-grid", "--points", 9, "-o", "x.ply", mentions=(UNIT, "ft", "mm"))


class Axes(harness.CliTest):
    """--up is about the result, and has the same values everywhere; --target-up is about the input. --size is pixels."""

    # Promise of printing.md: `--size` and `--up` of `print` "still work"
    def test_print_takes_its_former_names(self):
        points, faces = harness.sphere(3)
        self.write("tall.obj", harness.obj(([(x, 3 * y, z) for x, y, z in points], faces)))
        self.ok("print", "tall.obj", "-o", "new.stl", "--longest-side", 30, "--target-up", "z")
        self.ok("print", "tall.obj", "-o", "old.stl", "--size", 30, "--up=z")
        self.assertEqual(self.bytes("new.stl"), self.bytes("old.stl"))
        said = self.ok("print", "--help", "all", data=True)
        self.assertIn("--longest-side MM", said)
        self.assertNotRegex(said, r"--size|--up ")
        self.refused(USAGE, "print", "tall.obj", "-o", "x.stl", "--size", 30, "--longest-side", 30, mentions="--longest-side")

    # Promise: "All commands that have `--up` ..."
    def test_a_part_stands_as_its_input_says(self):
        points, faces = harness.sphere(3)
        self.write("tall.obj", harness.obj(([(x, y, 3 * z) for x, y, z in points], faces)))
        self.ok("fractal", "tall.obj", *LOW, "--target-up", "z", "-o", "f.vdb", "--mesh", "f.ply")
        self.ok("fractal", "tall.obj", *LOW, "--target-up", "z", "--up", "y", "-o", "y.vdb")
        for words in (("f.vdb", ), ("f.ply", ), ("y.vdb", ), ("f.vdb", "--from-grid"), ("y.vdb", "--from-grid"), ("tall.obj", "--target-up", "z")):
            self.ok("print", *words, "-o", "p.stl", "--longest-side", 30)
            low, high = box_of([p for t in harness.read_stl(self.bytes("p.stl")) for p in t])
            extents = [b - a for a, b in zip(low, high)]
            self.assertEqual(extents.index(max(extents)), 2, words)

    # Promise of handoff.md: "All commands that have `--up` take the same values"; `print` takes `--target-up` "Its default is
    #   what the input file says"
    def test_up_has_the_same_values_everywhere(self):
        self.write("t.obj", harness.obj(harness.torus()))
        self.ok("fractal", "t.obj", *LOW, "--target-up", "z", "-o", "f.vdb")
        for words, name in ((("fractal", "t.obj", *LOW, "--mesh"), "x.ply"), (("sdf", "t.obj", "--resolution", 20, "-o"), "x.vdb"),
                            (("mesh", "f.vdb", "-o"), "x.ply"), (("render", "f.vdb", "--size", "20x20", "-o"), "x.png"),
                            (("render", "--field", "t.obj", *LOW, "--size", "20x20", "-o"), "x.png"),
                            (("sheet", "t.obj", *LOW, "--vary", "alpha=20,40", "--size", "20x20", "-o"), "x.png")):
            for up in ("keep", "y", "z", "auto"):
                self.ok(*words, name, "--up", up)
            self.refused(USAGE, *words, name, "--up", "x", mentions=("keep", "y", "z", "auto"))
        pictures = {}
        for up in ((), ("--up", "keep"), ("--up", "auto"), ("--up", "z"), ("--up", "y")):
            self.ok("render", "f.vdb", "--size", "30x30", "-o", "p.png", *up)
            pictures[up] = self.bytes("p.png")
        self.assertEqual(len({pictures[up] for up in pictures if up != ("--up", "y")}), 1)
        self.assertNotEqual(pictures["--up", "y"], pictures[()])


if __name__ == "__main__":
    harness.main()

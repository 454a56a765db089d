# SPDX-License-Identifier: Apache-2.0
"""Names of grids by program, as pyopenvdb and the tools of OpenVDB and NanoVDB read them, and our own readers after that."""

import re
import shutil
import subprocess
import unittest

import pyopenvdb

import harness
from harness import USAGE

LOW = ("--resolution", 24, "--sdf-resolution", 24)
ALL = ("--grids", "surface,density", "--attributes", "Cd,trap")
# As docs/handoff.md has them in its table.
NAMES = {
    "houdini": {"surface": "surface", "density": "density", "Cd": "Cd", "trap": "trap"},
    "blender": {"surface": "surface", "density": "density", "Cd": "color", "trap": "trap"},
    "unreal": {"surface": "surface", "density": "density", "Cd": "color", "trap": "trap"},
    "arnold": {"surface": "surface", "density": "density", "Cd": "color", "trap": "trap"},
}


class GridNames(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("t.obj", harness.obj(harness.torus()))

    def names(self, name):
        return sorted(grid.name for grid in pyopenvdb.readAllGridMetadata(str(self.path(name))))

    def same_voxels(self, one, name, other, renamed):
        a, b = pyopenvdb.read(str(self.path(one)), name), pyopenvdb.read(str(self.path(other)), renamed)
        self.assertEqual((type(a), a.gridClass), (type(b), b.gridClass))
        for node in ((0, 0, 0), (9, -3, 7)):
            self.assertEqual(a.transform.indexToWorld(node), b.transform.indexToWorld(node))
        values = lambda grid: [(item.min, item.value) for item in grid.citerOnValues()]
        self.assertEqual(values(a), values(b))

    # Promise of handoff.md#grid-names: The table of grid names; single names
    def test_each_program_has_its_names(self):
        self.ok("fractal", "t.obj", *LOW, *ALL, "-o", "plain.vdb")
        self.assertEqual(self.names("plain.vdb"), sorted(["surface", "density", "Cd", "trap"]))
        self.ok("sdf", "t.obj", "--resolution", 24, "-o", "phi.vdb")
        for program, names in NAMES.items():
            self.ok("fractal", "t.obj", *LOW, *ALL, "--grid-names", program, "-o", "f.vdb")
            self.assertEqual(self.names("f.vdb"), sorted(names.values()))
            for own, name in names.items():
                self.same_voxels("plain.vdb", own, "f.vdb", name)
            self.assertEqual(self.info("f.vdb")["recipe"]["grid-names"], program)
            self.ok("sdf", "t.obj", "--resolution", 24, "--grid-names", program, "-o", "s.vdb")
            self.assertEqual(self.names("s.vdb"), ["surface"])
            self.same_voxels("phi.vdb", "phi", "s.vdb", "surface")
            self.ok("convert", "plain.vdb", "-o", "c.vdb", "--grid-names", program)
            self.assertEqual(self.names("c.vdb"), sorted(names.values()))
            for own, name in names.items():
                self.same_voxels("plain.vdb", own, "c.vdb", name)

    def test_the_names_of_programs_undo_each_other(self):
        """Whichever program a VDB was made for, `convert` makes it one for any other, and says where there was nothing to do."""
        self.ok("fractal", "t.obj", *LOW, *ALL[:2], "-o", "plain.vdb", "--attributes", "Cd,trap,velocity", "--target-before", "t.obj",
                "--fps", 24)
        wanted = {program: {**names, "velocity": "v" if program == "houdini" else "velocity"} for program, names in NAMES.items()}
        for program, names in wanted.items():
            self.ok("convert", "plain.vdb", "-o", "from.vdb", "--grid-names", program)
            for other, renamed in wanted.items():
                said = self.ok("convert", "from.vdb", "-o", "to.vdb", "--grid-names", other)
                self.assertEqual(self.names("to.vdb"), sorted(renamed.values()), (program, other))
                self.assertEqual("have these names already" in said, renamed == names, (program, other, said))
                for own, name in renamed.items():
                    self.same_voxels("plain.vdb", own, "to.vdb", name)
        self.ok("convert", "from.vdb", "-o", "both.vdb", "--grid-names", "houdini,color=tint")
        self.assertIn("tint", self.names("both.vdb"))
        self.ok("fractal", "t.obj", *LOW, *ALL, "-o", "mixed.vdb", "--grid-names", "trap=color")
        self.ok("convert", "mixed.vdb", "-o", "kept.vdb", "--grid-names", "houdini")
        self.assertEqual(self.names("kept.vdb"), sorted(["surface", "density", "Cd", "color"]), "Cd is there already")

    # Promise: The table of grid names; single names
    def test_single_names(self):
        self.ok("fractal", "t.obj", *LOW, *ALL, "-o", "f.vdb", "--grid-names", "blender,trap=temperature,surface=shape")
        self.assertEqual(self.names("f.vdb"), ["color", "density", "shape", "temperature"])
        self.ok("fractal", "--config", "f.vdb", "-o", "again.vdb")
        self.assertEqual(self.bytes("again.vdb"), self.bytes("f.vdb"))
        # One grid may take the name that another one leaves.
        self.ok("fractal", "t.obj", *LOW, *ALL, "-o", "g.vdb", "--grid-names", "density=trap,trap=density")
        self.same_voxels("f.vdb", "density", "g.vdb", "trap")

    # Promise of handoff.md: "Our own commands find the distance by the metadata `julia_distance_grid`, whatever its name";
    #   `convert` "keeps its recipe and everything else"
    def test_our_readers_find_the_distances_by_their_new_name(self):
        """Among several grids of floats, of which none has a name that they look for."""
        new = ("--grid-names", "surface=shape,density=fog")
        self.ok("fractal", "t.obj", *LOW, *ALL, "-o", "old.vdb")
        self.ok("fractal", "t.obj", *LOW, *ALL, "-o", "new.vdb", *new)
        self.ok("convert", "old.vdb", "-o", "converted.vdb", *new)
        for words, made in ((("mesh", "--from-grid"), "ply"), (("mesh", ), "obj"), (("points", "--points", 60, "--from-grid"), "ply"),
                            (("print", "--longest-side", 30, "--from-grid"), "stl"), (("render", "--size", "30x30"), "png"),
                            (("slice", "--field", "grid", "--size", 20), "png")):
            outputs = []
            for source in ("old", "new", "converted"):
                command, *options = words
                self.ok(command, f"{source}.vdb", *options, "-o", f"{source}.{made}")
                outputs.append(re.sub(rb"# juliavdb [^\n]*\n", b"", self.bytes(f"{source}.{made}")))
            self.assertEqual(outputs[0], outputs[1], words)
            self.assertEqual(outputs[0], outputs[2], words)
        self.assertEqual([grid["name"] for grid in self.info("new.vdb")["grids"]], ["shape", "fog", "Cd", "trap"])
        self.ok("usd", "new.vdb", "-o", "new.usda")
        self.assertIn(b'token fieldName = "shape"', self.bytes("new.usda"))

    # Promise: "Our own commands find the distance ..."
    def test_a_renamed_sdf_is_the_same_target(self):
        """The box of its mesh is recorded, which is more exact than that of its nodes."""
        self.ok("sdf", "t.obj", "--resolution", 24, "-o", "phi.vdb")
        self.ok("sdf", "t.obj", "--resolution", 24, "-o", "surface.vdb", "--grid-names", "houdini")
        self.ok("convert", "phi.vdb", "-o", "converted.vdb", "--grid-names", "phi=d")
        meshes = []
        for name in ("phi", "surface", "converted"):
            self.ok("fractal", f"{name}.vdb", "--resolution", 24, "--mesh", f"{name}.stl")
            meshes.append(self.bytes(f"{name}.stl"))
        self.assertEqual(meshes[0], meshes[1])
        self.assertEqual(meshes[0], meshes[2])

    # Promise of handoff.md: "`merge` and sequences use them too"; "If two grids would have the same name, the program refuses
    #   before the work starts"
    # Promise of unreal.md: The frames of one `--frames` "have the same grids", numbered without gaps in one folder
    def test_tiles_and_frames(self):
        words = ("t.obj", *LOW, *ALL[2:], "--grid-names", "blender,surface=shape")
        self.ok("plan", "tiles", *words, "-o", "farm", "--tiles", 2)
        self.ok("task", "farm", "--range", "1-2")
        self.ok("merge", "farm", "-o", "m.vdb")
        self.ok("fractal", *words, "-o", "f.vdb")
        self.assertEqual(self.bytes("m.vdb"), self.bytes("f.vdb"))
        self.assertEqual(self.names("m.vdb"), ["color", "shape", "trap"])
        self.ok("merge", "farm", "--index", "i.json")
        self.assertEqual(self.names("i.0001.vdb"), ["color", "shape", "trap"])
        self.ok("fractal", *words, "-o", "g.####.vdb", "--frames", "1-2", "--key", "detail@1=0.2", "--key", "detail@2=0.3")
        self.assertEqual(self.names("g.0002.vdb"), ["color", "shape", "trap"])

    # Promise: The table of grid names; single names
    @unittest.skipUnless(shutil.which("vdb_print") and shutil.which("nanovdb_print"), "libopenvdb-tools or libnanovdb-tools is not here")
    def test_as_other_tools_read_them(self):
        tool = lambda *words: subprocess.run(words, cwd=self.folder, capture_output=True, text=True, check=True).stdout
        self.ok("fractal", "t.obj", *LOW, *ALL, "-o", "f.vdb", "--grid-names", "blender")
        for name in ("surface", "density", "color"):
            self.assertIn(name, tool("vdb_print", "f.vdb"))
        self.ok("fractal", "t.obj", *LOW, *ALL, "-o", "f.nvdb", "--grid-names", "blender,surface=shape")
        self.ok("convert", "f.vdb", "-o", "c.nvdb", "--grid-names", "surface=shape")
        self.ok("sdf", "t.obj", "-o", "s.nvdb", "--resolution", 20, "--grid-names", "phi=shape")
        for file in ("f.nvdb", "c.nvdb", "s.nvdb"):
            self.assertIn("shape", tool("nanovdb_print", file))

    # Promise: "`merge` and sequences use ..."
    def test_what_is_refused_before_the_work(self):
        self.write("bad.obj", "f 1 2 3\n")
        run = ("fractal", "bad.obj", *LOW, *ALL, "-o", "x.vdb", "--grid-names")
        for value, words in (("blender,trap=color", ("Cd", "trap", "'color'")), ("density=trap", ("density", "trap")),
                             ("surface=a,density=a", ("surface", "density", "'a'"))):
            self.refused(USAGE, *run, value, mentions=("--grid-names", "another name", *words))
        self.refused(USAGE, *run, "depth=a", mentions=("--grid-names", "'depth'", "surface, density, Cd, trap"))
        for value in ("maya", "trap=a,blender", "trap", "trap=", "trap=a b"):
            self.refused(USAGE, *run, value, mentions="grid-names")
        self.refused(USAGE, "fractal", "bad.obj", "--mesh", "x.ply", "--grid-names", "blender", mentions=("--grid-names", "no effect"))
        self.refused(USAGE, "plan", "tiles", "bad.obj", *ALL, "-o", "farm", "--grid-names", "blender,trap=color", mentions="'color'")
        self.refused(USAGE, "sdf", "bad.obj", "-o", "x.vdb", "--grid-names", "surface=a", mentions=("'surface'", "phi"))
        self.ok("fractal", "t.obj", *LOW, *ALL, "-o", "f.vdb")
        self.refused(USAGE, "convert", "f.vdb", "-o", "x.vdb", "--grid-names", "blender,trap=color", mentions="'color'")
        self.refused(USAGE, "convert", "f.vdb", "-o", "x.vdb", mentions="--grid-names")
        self.ok("points", "t.obj", "-o", "p.vdb", "--points", 30)
        self.refused(USAGE, "convert", "p.vdb", "-o", "x.vdb", "--grid-names", "points=a", mentions=("p.vdb", "points"))


if __name__ == "__main__":
    harness.main()

# SPDX-License-Identifier: Apache-2.0
"""The same recipe gives the same bytes, with any number of threads, and from the files that carry the recipe."""

import pathlib

import pyopenvdb

import harness
from harness import BAD_DATA

LOW = ("--resolution", 28, "--sdf-resolution", 28)
ALL_GRIDS = "surface,density,logmodulus,iterations,versor"


class SameBytes(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("t.obj", harness.obj(harness.torus()))

    def twice(self, extensions, *arguments):
        """Runs with one thread, with two, with four and with those that there are. @param extensions: of the outputs, by option"""
        results = {}
        for threads in (1, 2, 4, None):
            outputs = [word for option, extension in extensions.items() for word in (option, f"{threads}{extension}")]
            self.ok(*arguments, *outputs, *(("--threads", threads) if threads else ()))
            for extension in extensions.values():
                results.setdefault(extension, []).append(self.bytes(f"{threads}{extension}"))
        for extension, (first, *others) in results.items():
            for other in others:
                self.assertTrue(first == other, f"{arguments}: the bytes of {extension} differ with the threads")

    # Promise of README.md: "The same recipe gives the same bytes, for any number of threads"
    def test_fractals(self):
        self.write("v.o3d", harness.o3d(harness.ROOTS, harness.ROOTS[:1]))
        for options in (("t.obj",), ("t.obj", "--alpha", "x:10:100:smooth", "--beta", "y:0:0.02"),
                        ("t.obj", "--slice", 0.2, "--origin-shift", "-0.1,0,0.05", "--texture-seed", 5),
                        ("t.obj", "--texture-integer", "--drop-axis", "i", "--precision", "float"),
                        ("t.obj", "--texture-placement", "surface", "--texture-roots", 20, "--half"),
                        ("t.obj", "--map", "rational", "--texture", "v.o3d"),
                        ("--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", "--iterations", 8)):
            with self.subTest(options=options):
                low = LOW if options[0] == "t.obj" else LOW[:2]
                self.twice({"-o": ".vdb", "--mesh": ".ply"}, "fractal", *options, *low, "--grids", ALL_GRIDS)

    # Promise of reliability.md: "`--exhaustive`, which evaluates every node, gives the same mesh and the same values"
    def test_skipping_changes_no_byte(self):
        """What is skipped, because its fate is proven, would have come out the same."""
        self.write("v.o3d", harness.o3d(harness.ROOTS, harness.ROOTS[:1]))
        for options in ((), ("--alpha", 6, "--crumbs", "keep"), ("--alpha", 100, "--precision", "double"), ("--alpha", "x:10:100:smooth"),
                        ("--beta", "y:-0.02:0.03", "--texture-integer"), ("--slice", 0.2, "--origin-shift", "-0.1,0,0.05"),
                        ("--drop-axis", "j", "--iterations", 5), ("--sampling", "quadratic"),
                        ("--box", "-0.2,-0.3,-0.2,0.8,0.9,0.7"), ("--map", "rational", "--texture", "v.o3d"),
                        ("--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", "--iterations", 8)):
            with self.subTest(options=options):
                self.ok("fractal", "t.obj", *LOW, *options, "-o", "skipped.vdb", "--mesh", "skipped.stl")
                self.ok("fractal", "t.obj", *LOW, *options, "-o", "all.vdb", "--mesh", "all.stl", "--exhaustive")
                # STL carries no recipe, in which --exhaustive stands.
                self.assertTrue(self.bytes("skipped.stl") == self.bytes("all.stl"), options)

    # Promise of design.md#meshes: A mesh that is written while it is made is the one beside a VDB
    def test_a_mesh_alone_is_the_mesh_beside_a_vdb(self):
        """Alone it is written while it is made; the field is never whole."""
        for options in ((), ("--box", "-0.2,-0.3,-0.2,0.8,0.9,0.7"), ("--box", "-0.2,-0.3,-0.2,0.8,0.9,0.7", "--cap")):
            for kind in (".ply", ".obj", ".stl"):
                self.ok("fractal", "t.obj", *LOW, *options, "--mesh", "alone" + kind)
                self.ok("fractal", "t.obj", *LOW, *options, "--mesh", "beside" + kind, "-o", "x.vdb")
                self.assertTrue(self.bytes("alone" + kind) == self.bytes("beside" + kind), (options, kind))

    def test_following(self):
        self.twice({"-o": ".vdb", "--mesh": ".ply"}, "fractal", "t.obj", *LOW, "--follow")

    # Promise of design.md: "any size of a batch, and any vector width"
    def test_vector_units_change_no_byte(self):
        flags = pathlib.Path("/proc/cpuinfo").read_text().split()
        sets = ["portable"] + [name for name, flag in (("avx2", "avx2"), ("avx512", "avx512vl")) if flag in flags]
        for options in (("t.obj",), ("t.obj", "--texture-integer", "--precision", "double"),
                        ("--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", "--iterations", 8)):
            low = LOW if options[0] == "t.obj" else LOW[:2]
            for name in sets:
                self.ok("fractal", *options, *low, "-o", f"{name}.vdb", "--mesh", f"{name}.ply", "--instructions", name)
                for kind in (".vdb", ".ply"):
                    self.assertTrue(self.bytes(name + kind) == self.bytes("portable" + kind), (options, name, kind))

    # Promise: "The same recipe gives the same ..."
    def test_fractal_in_a_box(self):
        self.twice({"-o": ".vdb", "--mesh": ".ply"}, "fractal", "t.obj", *LOW, "--box", "-0.2,-0.3,-0.2,0.8,0.9,0.7",
                   "--grids", ALL_GRIDS)
        self.twice({"-o": ".vdb", "--mesh": ".ply"}, "fractal", "t.obj", *LOW, "--box", "-0.2,-0.3,-0.2,0.8,0.9,0.7",
                   "--cap")

    # Promise: "The same recipe gives the same ..."
    def test_the_other_commands(self):
        self.twice({"-o": ".vdb"}, "sdf", "t.obj", "--resolution", 48)
        self.write("hole.obj", harness.obj(harness.with_hole(harness.sphere(3), 0.94)))
        self.twice({"-o": ".vdb"}, "sdf", "hole.obj", "--resolution", 32, "--repair")
        self.ok("fractal", "t.obj", *LOW, "-o", "f.vdb")
        self.twice({"-o": ".png"}, "slice", "f.vdb", "--size", 60, "--field", "f")
        self.twice({"-o": ".exr"}, "slice", "f.vdb", "--size", 60, "--field", "versor")
        self.twice({"-o": ".png"}, "render", "f.vdb", "--size", "60x40")
        self.twice({"-o": ".exr"}, "render", "f.vdb", "--size", "60x40")
        self.twice({"-o": ".ply"}, "mesh", "f.vdb")
        self.twice({"-o": ".ply"}, "mesh", "f.vdb", "--from-grid")
        self.twice({"-o": ".ply"}, "print", "f.vdb", "--size", 30, "--min-thickness", 2, "--resolution", 40, "--tolerance", 0.05)
        self.twice({"--mesh": ".glb"}, "fractal", "t.obj", *LOW, "--colour", "trap", "--lod", "100%,20%")
        self.twice({"--mesh": ".ply"}, "fractal", "t.obj", *LOW, "--adaptivity", 0.2, "--largest", 1)
        self.ok("mesh", "f.vdb", "-o", "f.ply")
        self.twice({"-o": ".png"}, "render", "f.ply", "--size", "60x40")
        self.twice({"-o": ".png"}, "render", "--field", "f.vdb", "--size", "40x30", "--colour", "trap")


class Recipes(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(3)))
        self.options = (*LOW, "--alpha", "y:20:90@0.7", "--beta", 0.01, "--slice", 0.1)
        self.random, self.grids_of = ("--texture-seed", 11), ("--grids", "surface,versor")
        self.ok("fractal", "s.obj", *self.options, *self.random, *self.grids_of, "-o", "f.vdb", "--mesh", "f.ply")

    def same(self, vdb, mesh):
        self.assertTrue(self.bytes("f.vdb") == self.bytes(vdb), f"{vdb} differs from f.vdb")
        self.assertTrue(self.bytes("f.ply") == self.bytes(mesh), f"{mesh} differs from f.ply")

    # Promise of README.md#use: A run from the recipe in a VDB, PLY, OBJ or GLB, in a text, or in a cell of a sheet has the bytes
    #   of the first
    def test_from_what_was_made(self):
        self.ok("fractal", "s.obj", *self.options, *self.random, *self.grids_of, "--mesh", "f.obj", "-o", "beside.vdb")
        for config in ("f.vdb", "f.ply", "f.obj"):
            with self.subTest(config=config):
                self.ok("fractal", "--config", config, "-o", "again.vdb", "--mesh", "again.ply")
                self.same("again.vdb", "again.ply")

    # Promise of reliability.md: "A file that is read for its recipe alone" is "judged by its recipe alone"; a mistake in a text
    #   of options "is wrong usage, which ends in 2"
    def test_a_file_that_is_read_for_its_recipe_alone(self):
        """Its voxels and triangles are neither read nor judged."""
        for name in ("f.vdb", "f.ply"):
            content = self.bytes(name)
            middle = len(content) // 2
            self.write(f"broken-{name}", content[:middle] + bytes(b ^ 0xff for b in content[middle:-4]))
            with self.subTest(name=name):
                self.refused(BAD_DATA, "points", f"broken-{name}", "-o", "p.ply", "--points", 9, "--from-grid")
                self.ok("fractal", "--config", f"broken-{name}", "-o", "again.vdb", "--mesh", "again.ply")
                self.same("again.vdb", "again.ply")

    # Promise: A run from the recipe in a VDB, PLY, OBJ ...
    def test_from_a_text(self):
        self.write("job.cfg", "# a comment\ninput = s.obj\nresolution = 28\nsdf-resolution=28\nalpha = y:20:90@0.7\n"
                   "beta = 0.01\nversor-seed = 11\nslice = 0.1\ngrids = surface,versor\n")
        self.ok("fractal", "--config", "job.cfg", "-o", "again.vdb", "--mesh", "again.ply")
        self.same("again.vdb", "again.ply")

    def test_flags_in_a_text(self):
        self.write("job.cfg", "input = s.obj\nresolution = 20\nsdf-resolution = 20\nhalf = true\ncap = false\n")
        self.ok("fractal", "--config", "job.cfg", "-o", "config.vdb")
        self.assertEqual(self.info("config.vdb")["recipe"]["half"], "true")

    # Promise of controls.md: "Options on the command line take precedence over those of the cell, as with every `--config`"
    def test_the_command_line_goes_first(self):
        self.ok("fractal", "--config", "f.vdb", "--alpha", 60, "--voxel-size", 0.1, "-o", "other.vdb")
        recipe = self.info("other.vdb")["recipe"]
        self.assertEqual((recipe["alpha"], recipe["voxel-size"], recipe["texture-seed"]), ("60", "0.1", "11"))
        self.assertNotIn("resolution", recipe)

    # Promise of design.md: "a run from a recipe refuses inputs that have changed"
    def test_another_source_is_refused(self):
        self.write("s.obj", harness.obj(harness.sphere(2)))
        self.refused(BAD_DATA, "fractal", "--config", "f.vdb", "-o", "x.vdb", mentions=["s.obj", "SHA-256"])
        self.refused(BAD_DATA, "mesh", "f.vdb", "-o", "x.ply", mentions=["s.obj", "SHA-256"])
        # Named on the command line, it is what is wanted.
        self.ok("fractal", "s.obj", "--config", "f.vdb", "-o", "x.vdb")
        self.path("s.obj").unlink()
        self.refused(harness.NO_INPUT, "fractal", "--config", "f.vdb", "-o", "y.vdb", mentions="s.obj")

    # Promise: "a run from a recipe refuses ..."
    def test_another_versor_is_refused(self):
        self.write("v.json", harness.rational_json(harness.ROOTS))
        self.ok("fractal", "s.obj", *LOW, "--texture", "v.json", "-o", "v.vdb")
        self.write("v.json", harness.rational_json(harness.ROOTS[:2]))
        self.refused(BAD_DATA, "fractal", "--config", "v.vdb", "-o", "x.vdb", mentions=["v.json", "SHA-256"])

    # Promise: "a run from a recipe refuses ..."
    def test_another_control_grid_is_refused(self):
        for option, value in (("alpha", 40.0), ("beta", 0.01)):
            with self.subTest(option=option):
                grid = pyopenvdb.FloatGrid(value)
                grid.name = "paint"
                pyopenvdb.write(str(self.path("paint.vdb")), grids=grid)
                self.ok("fractal", "s.obj", *LOW, f"--{option}", "paint.vdb:paint", "-o", "c.vdb")
                self.ok("fractal", "--config", "c.vdb", "-o", "x.vdb")
                self.assertTrue(self.bytes("c.vdb") == self.bytes("x.vdb"))
                grid.background = 2 * value
                pyopenvdb.write(str(self.path("paint.vdb")), grids=grid)
                self.refused(BAD_DATA, "fractal", "--config", "c.vdb", "-o", "y.vdb", mentions=["paint.vdb", "SHA-256"])
                # Named on the command line, it is what is wanted.
                self.ok("fractal", "--config", "c.vdb", f"--{option}", "paint.vdb:paint", "-o", "y.vdb")
                self.path("y.vdb").unlink()

    # Promise: A run from the recipe in a VDB, PLY, OBJ ...
    def test_sdf_recipe(self):
        self.ok("sdf", "s.obj", "-o", "a.vdb", "--resolution", 30, "--band", 4)
        self.ok("sdf", "--config", "a.vdb", "-o", "b.vdb")
        self.assertTrue(self.bytes("a.vdb") == self.bytes("b.vdb"))

    def test_the_versor_of_another_fractal(self):
        self.ok("fractal", "s.obj", *self.options, *self.grids_of, "--texture", "f.vdb", "-o", "g.vdb", "--mesh", "g.ply")
        f, g = harness.read_ply(self.bytes("f.ply")), harness.read_ply(self.bytes("g.ply"))
        self.assertTrue((f.points, f.faces) == (g.points, g.faces), "the meshes differ")


if __name__ == "__main__":
    harness.main()

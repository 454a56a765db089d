# SPDX-License-Identifier: Apache-2.0
"""Targets that bound no volume: holes, terrain, sheets and clouds of points, and volumes that are no signed distance, through
every command that takes one."""

import math
import shutil
import unittest

import pyopenvdb

import harness
from harness import BAD_DATA, USAGE

LOW = ("--resolution", 32, "--sdf-resolution", 48)
FARM = "farm"


def terrain(squares=16, hole=0.0):
    """A height field over [-1, 1]^2, y up."""
    points = [(2 * i / squares - 1, 0.2 * math.sin(5 * i / squares) * math.cos(4 * j / squares), 2 * j / squares - 1)
              for i in range(squares + 1) for j in range(squares + 1)]
    faces = []
    for i in range(squares):
        for j in range(squares):
            a, b = i * (squares + 1) + j, (i + 1) * (squares + 1) + j
            if math.hypot(2 * (i + 0.5) / squares - 1, 2 * (j + 0.5) / squares - 1) >= hole:
                faces += [(a, a + 1, b + 1), (a, b + 1, b)]
    return points, faces


def cloud(points, colours=None):
    lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}", "property float x", "property float y",
             "property float z"]
    lines += ["property uchar red"] if colours else []
    rows = [" ".join(map(str, point)) for point in points]
    if colours:
        rows = [f"{row} {colour}" for row, colour in zip(rows, colours)]
    return "\n".join([*lines, "end_header", *rows, ""])


def shell(*balls):
    """Balls about the origin: radii, those below 0 of balls that are turned inside out."""
    points, faces = [], []
    for radius in balls:
        more, triangles = harness.sphere(4, abs(radius))
        faces += [tuple(k + len(points) for k in (f if radius > 0 else f[::-1])) for f in triangles]
        points += more
    return points, faces


def half_sphere():
    points, faces = harness.sphere(4)
    faces = [face for face in faces if all(points[p][2] > -1e-9 for p in face)]
    return points, faces


class Targets(harness.CliTest):

    def check_box(self, name, low, high, within):
        """The active voxels' box of the level set."""
        grid = self.info(name)["grids"][0]
        for found, wanted in ((grid["box min"], low), (grid["box max"], high)):
            for a, b in zip(found, wanted):
                self.assertAlmostEqual(a, b, delta=within)

    def closed_volume(self, name):
        mesh = harness.read_ply(self.bytes(name))
        self.assertEqual(harness.open_edges(mesh), [])
        return harness.volume_of(mesh)

    # Promise: A mesh that bounds no volume ...
    # Promise of targets.md: `--repair`, `--solidify`, `--thicken` and `--points-radius` make closed shapes of the size that they
    #   say
    # Promise: "The options are the same ..."
    # Promise: The program says "how far ..."
    def test_an_open_base(self):
        self.write("half.obj", harness.obj(half_sphere()))
        self.refused(BAD_DATA, "fractal", "half.obj", "-o", "x.vdb", *LOW, mentions="--repair")
        text = self.ok("sdf", "half.obj", "-o", "s.vdb", "--repair", "--resolution", 40)
        self.assertIn("1 hole of up to", text)
        self.ok("fractal", "half.obj", "-o", "f.vdb", "--mesh", "f.ply", "--repair", *LOW)
        # It is filled: a ball's half, to some detail.
        volume = self.closed_volume("f.ply")
        self.assertGreater(volume, 0.4 * 2 * math.pi / 3)
        self.assertLess(volume, 1.2 * 2 * math.pi / 3)

    # Promise: A mesh that bounds no volume ...
    # Promise: `--repair`, `--solidify`, `--thicken` and `--points-radius` ...
    def test_terrain(self):
        self.write("t.obj", harness.obj(terrain()))
        for repair in ([], ["--repair"]):
            self.refused(BAD_DATA, "fractal", "t.obj", "-o", "x.vdb", *LOW, *repair,
                         mentions=["--solidify", "--thicken"])
        self.ok("fractal", "t.obj", "-o", "f.vdb", "--mesh", "f.ply", "--solidify", 0.5, *LOW)
        recipe = self.info("f.vdb")["recipe"]
        self.assertEqual(recipe["solidify"], "0.5")
        self.closed_volume("f.ply")
        # From the recipe it is the same again.
        self.ok("fractal", "--config", "f.vdb", "-o", "again.vdb")
        self.assertEqual(self.bytes("again.vdb"), self.bytes("f.vdb"))
        self.ok("sdf", "t.obj", "-o", "up.vdb", "--solidify", "y:0.5", "--resolution", 40)
        self.ok("sdf", "t.obj", "-o", "found.vdb", "--solidify", "0.5", "--resolution", 40)
        low = -0.2 - 0.5
        self.check_box("up.vdb", (-1, low, -1), (1, 0.2, 1), 0.25)
        self.check_box("found.vdb", (-1, low, -1), (1, 0.2, 1), 0.25)
        # A closed mesh has no use for it.
        self.write("s.obj", harness.obj(harness.sphere(2)))
        self.refused(BAD_DATA, "sdf", "s.obj", "-o", "x.vdb", "--solidify", 1, mentions="closed")

    # Promise: `--repair`, `--solidify`, `--thicken` and `--points-radius` ...
    # Promise of targets.md: "A closed mesh grows by half of W, and stays solid"
    def test_a_sheet(self):
        self.write("t.obj", harness.obj(terrain(hole=0.4)))
        self.ok("fractal", "t.obj", "-o", "f.vdb", "--mesh", "f.ply", "--thicken", 0.2, *LOW)
        self.closed_volume("f.ply")
        box = [float(x) for x in self.info("f.vdb")["metadata"]["julia_target_box"].split(",")]
        self.assertAlmostEqual(box[0], -1.1, 6)
        # A closed mesh grows on all sides, and stays solid.
        self.write("s.obj", harness.obj(harness.sphere(4)))
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--thicken", 0.2, "--resolution", 60)
        self.ok("mesh", "s.vdb", "-o", "s.ply")
        self.assertAlmostEqual(self.closed_volume("s.ply"), 4 / 3 * math.pi * 1.1 ** 3, delta=0.05)
        self.refused(USAGE, "fractal", "t.obj", "-o", "x.vdb", "--thicken", 0.01, *LOW,
                     mentions=["--thicken", "at least"])
        self.refused(USAGE, "fractal", "t.obj", "-o", "x.vdb", "--thicken", 0.2, "--solidify", 1, *LOW,
                     mentions=["--thicken", "--solidify"])

    # Promise: A mesh that bounds no volume ...
    # Promise: `--repair`, `--solidify`, `--thicken` and `--points-radius` ...
    # Promise: "`info` reports the spacing ..."
    def test_a_cloud_of_points(self):
        points, _ = harness.sphere(3)
        self.write("c.ply", cloud(points, [255 if p[0] > 0 else 0 for p in points]))
        info = self.info("c.ply")
        self.assertEqual((info["kind"], info["points"], info["attributes"]), ("points", len(points), ["red"]))
        self.assertGreater(info["spacing"], 0.05)
        self.assertLess(info["spacing"], 0.3)
        self.refused(BAD_DATA, "fractal", "c.ply", "-o", "x.vdb", *LOW, mentions="--points-radius")
        radius = 1.5 * info["spacing"]
        said = self.ok("fractal", "c.ply", "-o", "f.vdb", "--mesh", "f.ply", "--points-radius", radius, *LOW)
        self.assertIn("not used of the target: the attributes red\n", said)
        self.assertGreater(self.closed_volume("f.ply"), 0.5 * 4 * math.pi / 3)
        # Its colours control the detail like those of a mesh.
        said = self.ok("fractal", "c.ply", "-o", "p.vdb", "--points-radius", radius, "--mask", "paint:red", *LOW)
        self.assertNotIn("not used", said)
        self.assertNotEqual(self.bytes("p.vdb"), self.bytes("f.vdb"))
        self.write("none.ply", cloud([]))
        self.refused(BAD_DATA, "fractal", "none.ply", "-o", "x.vdb", "--points-radius", 1, *LOW)
        self.write("one.ply", cloud([(5, 6, 7)]))
        self.ok("fractal", "one.ply", "-o", "one.vdb", "--points-radius", 2, *LOW)

    # Promise: `--hollows keep`: "A part ..."
    def test_hollows(self):
        self.write("s.obj", harness.obj(shell(1, -0.6)))
        self.write("both.obj", harness.obj(shell(1, 0.6)))
        self.write("onion.obj", harness.obj(shell(1, -0.8, 0.6, -0.3)))
        self.write("ball.obj", harness.obj(shell(1)))
        filled = "1 hollow of the target is filled; --hollows keep makes it a cavity\n"
        ball = 4 / 3 * math.pi
        for name, options, said, volume in (
                ("s.obj", (), filled, 1), ("s.obj", ("--hollows", "fill"), filled, 1),
                ("s.obj", ("--hollows", "keep"), "1 hollow of the target is a cavity\n", 1 - 0.6 ** 3),
                ("both.obj", ("--hollows", "keep"), "1 part of the target lies inside another and changes nothing\n", 1),
                ("onion.obj", (), "2 hollows of the target are filled; --hollows keep makes them cavities\n", 1),
                ("onion.obj", ("--hollows", "keep"), "2 hollows of the target are cavities\n",
                 1 - 0.8 ** 3 + 0.6 ** 3 - 0.3 ** 3)):
            with self.subTest(name=name, options=options):
                text = self.ok("sdf", name, "-o", "s.vdb", "--resolution", 60, *options)
                self.assertIn(said, text)
                self.assertNotIn("run into each other", text)
                self.ok("mesh", "s.vdb", "-o", "s.ply")
                self.assertAlmostEqual(self.closed_volume("s.ply"), volume * ball, delta=0.03 * ball)
                self.assertIn(said, self.ok("fractal", name, "-o", "f.vdb", "--detail", 0.1, *LOW, *options))
        self.assertEqual(self.info("f.vdb")["metadata"]["julia_hollows_kept"], "2")
        # The fractal has an inner surface, or is that of the ball alone.
        detail = ("--detail", 0.1, "--mesh", "f.ply", "-o", "f.vdb", *LOW)
        self.ok("fractal", "ball.obj", *detail)
        whole = self.closed_volume("f.ply")
        self.ok("fractal", "s.obj", "--hollows", "keep", *detail)
        self.assertAlmostEqual(self.closed_volume("f.ply"), (1 - 0.6 ** 3) * ball, delta=0.1 * ball)
        self.assertEqual(self.info("f.vdb")["recipe"]["hollows"], "keep")
        self.ok("fractal", "--config", "f.vdb", "-o", "again.vdb")
        self.assertEqual(self.bytes("again.vdb"), self.bytes("f.vdb"))
        self.ok("fractal", "s.obj", "-o", "fill.vdb", "--mesh", "fill.ply", "--detail", 0.1, *LOW)
        self.assertAlmostEqual(self.closed_volume("fill.ply"), whole, delta=1e-3 * ball)
        # Tiles have the same bytes as the whole.
        self.ok("fractal", "s.obj", "--hollows", "keep", "--detail", 0.1, "-o", "whole.vdb", *LOW)
        self.ok("plan", "tiles", "s.obj", "--hollows", "keep", "--detail", 0.1, "-o", "farm", "--tiles", 3, *LOW)
        self.ok("task", "farm", "--range", "1-3")
        self.ok("merge", "farm", "-o", "merged.vdb")
        self.assertEqual(self.bytes("merged.vdb"), self.bytes("whole.vdb"))
        self.refused(USAGE, "sdf", "s.obj", "-o", "x.vdb", "--hollows", "drop", mentions=["--hollows", "fill", "keep"])
        self.refused(USAGE, "fractal", "s.vdb", "-o", "x.vdb", "--hollows", "keep", *LOW, mentions="--hollows")

    # Promise: "The same recipe gives the same ..."
    def test_any_number_of_threads_makes_the_same(self):
        self.write("t.obj", harness.obj(terrain(hole=0.4)))
        points, _ = harness.sphere(3)
        self.write("c.ply", cloud(points))
        self.write("half.obj", harness.obj(half_sphere()))
        self.write("onion.obj", harness.obj(shell(1, -0.8, 0.6, -0.3)))
        for target, *options in (("t.obj", "--thicken", 0.2), ("t.obj", "--solidify", 0.3),
                                 ("c.ply", "--points-radius", 0.2), ("half.obj", "--repair"),
                                 ("onion.obj", "--hollows", "keep")):
            with self.subTest(options=options):
                for threads in (1, 2):
                    self.ok("sdf", target, "-o", f"{threads}.vdb", "--resolution", 40, "--threads", threads, *options)
                self.assertEqual(self.bytes("1.vdb"), self.bytes("2.vdb"))

    # Promise: `--repair`, `--solidify`, `--thicken` and `--points-radius` ...
    # Promise of targets.md: "The options are the same for `fractal`, `sdf`, `fit`, `sheet`, `slice`, `render --field`, `study`
    #   and `plan`"
    def test_other_commands_take_them(self):
        self.write("t.obj", harness.obj(terrain()))
        self.ok("fit", "t.obj", "-o", "x.json", "--resolution", 24, "--roots", 4, "--solidify", 0.6)
        self.ok("slice", "t.obj", "-o", "x.png", "--size", 20, "--sdf-resolution", 40, "--thicken", 0.3)
        self.ok("render", "--field", "t.obj", "-o", "y.png", "--size", "20x20", "--sdf-resolution", 40, "--solidify", 0.6)
        self.ok("study", "t.obj", "-o", "z.png", "--size", 20, "--versors", 2, "--sdf-resolution", 40, "--solidify", 0.6)
        self.ok("sheet", "t.obj", "-o", "sheet.png", "--size", "20x20", "--vary", "thicken=0.3,0.4", "--sdf-resolution", 40)
        self.ok("plan", "frames", "t.obj", "-o", "farm", "--frames", "1-2", "--resolution", 24, "--sdf-resolution", 40,
                "--solidify", "0.6", "--key", "detail@1=0.1", "--key", "detail@2=0.3")
        for task in (1, 2):
            self.ok("task", "farm", "--index", task)


class Volumes(harness.CliTest):
    """What is made of grids that are no signed distance, or are one in an unusual way."""

    FOG_SAID = "the target is a fog volume, and its surface is where it is 2, half of its largest value; --iso sets another\n"
    UNEQUAL_SAID = "the target's voxels have the sides 0.05,0.05,0.1; they were resampled to cubes of the smallest\n"

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(5)))
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--voxel-size", 0.05, "--band", 5)

    def changed(self, name, change):
        """The ball's grid, changed."""
        grid = pyopenvdb.read(str(self.path("s.vdb")), "phi")
        grid.name = "ball"
        change(grid)
        pyopenvdb.write(str(self.path(name)), grids=[grid])

    def transformed(self, name, x, y, z):
        """With other voxels: the three sides of one."""
        def change(grid):
            grid.transform = pyopenvdb.createLinearTransform([[*x, 0], [*y, 0], [*z, 0], [0, 0, 0, 1]])
        self.changed(name, change)

    def fog(self, name="fog.vdb", kind="fog volume"):
        def change(grid):
            grid.mapAll(lambda phi: min(max(2 - 10 * phi, 0), 4))
            grid.background = 0.0
            grid.gridClass = kind
        self.changed(name, change)

    def volume_of(self, name):
        self.ok("mesh", name, "-o", "m.ply", "--from-grid")
        mesh = harness.read_ply(self.bytes("m.ply"))
        self.assertEqual(harness.open_edges(mesh), [])
        return harness.volume_of(mesh)

    def check_ball(self, name, radius):
        self.assertAlmostEqual(self.volume_of(name), 4 / 3 * math.pi * radius ** 3, delta=0.05)

    # Promise: "lengths such as the longest ..."
    def test_a_turned_grid_has_the_lengths_of_its_surface(self):
        c, s = 0.05 * math.cos(0.7), 0.05 * math.sin(0.7)
        self.transformed("turned.vdb", (c, s, 0), (-s, c, 0), (0, 0, 0.05))
        self.transformed("plain.vdb", (0.05, 0, 0), (0, 0.05, 0), (0, 0, 0.05))
        found = {}
        for name in ("plain", "turned"):
            said = self.ok("fractal", f"{name}.vdb", "-o", f"{name}_f.vdb", "--resolution", 40)
            self.assertIn("voxels of 0.05,", said)
            found[name] = self.volume_of(f"{name}_f.vdb")
        self.assertAlmostEqual(found["turned"], found["plain"], delta=0.02 * found["plain"])

    # Promise: A fog volume's surface is "where ..."
    def test_a_fog_volume(self):
        self.fog()
        for command in ("sdf", "fractal"):
            said = self.ok(command, "fog.vdb", "-o", f"{command}.vdb", *(["--resolution", 32] if command == "fractal" else []))
            self.assertEqual(said.count(self.FOG_SAID), 1)
            self.assertEqual(self.info(f"{command}.vdb")["metadata"]["julia_chosen_iso"], "2")
        self.check_ball("sdf.vdb", 1)
        self.ok("fractal", "--config", "fractal.vdb", "-o", "again.vdb")
        self.assertEqual(self.bytes("again.vdb"), self.bytes("fractal.vdb"))
        said = self.ok("sdf", "fog.vdb", "--iso", 1, "-o", "larger.vdb")
        self.assertNotIn("half of", said)
        self.assertEqual(self.info("larger.vdb")["recipe"]["iso"], "1")
        self.check_ball("larger.vdb", 1.1)
        self.refused(BAD_DATA, "sdf", "fog.vdb", "--iso", 5, "-o", "x.vdb", mentions=["0 to 4", "--iso"])
        self.fog("unknown.vdb", "unknown")
        self.refused(BAD_DATA, "sdf", "unknown.vdb", "-o", "x.vdb", mentions="--iso")

    # Promise: A fog volume's surface is "where ..."
    def test_the_surface_of_a_level_set_moves(self):
        for distance in (-0.1, 0.15):
            self.ok("sdf", "s.vdb", f"--iso={distance}", "-o", "moved.vdb")
            self.check_ball("moved.vdb", 1 + distance)

    # Promise: A fog volume's surface is "where ..."
    def test_a_sign_that_is_turned_round(self):
        self.changed("wrong.vdb", lambda grid: grid.mapAll(lambda phi: -phi))
        for command in ("fractal", "sdf"):
            self.refused(BAD_DATA, command, "wrong.vdb", "-o", "x.vdb", mentions=["negative outside", "--invert"])
        self.ok("sdf", "wrong.vdb", "--invert", "-o", "right.vdb")
        self.check_ball("right.vdb", 1)
        self.refused(USAGE, "sdf", "s.vdb", "--invert", "-o", "x.vdb", mentions=["--invert", "leave it out"])
        self.refused(USAGE, "sdf", "s.obj", "--invert", "-o", "x.vdb", mentions=["--invert", "'s.obj' is a mesh"])
        self.refused(USAGE, "fractal", "s.obj", "--iso", 1, "-o", "x.vdb", mentions=["--iso", "'s.obj' is a mesh"])

    # Promise: "lengths such as the longest ..."
    def test_voxels_of_unequal_sides(self):
        self.transformed("long.vdb", (0.05, 0, 0), (0, 0.05, 0), (0, 0, 0.1))
        for command in ("sdf", "fractal"):
            said = self.ok(command, "long.vdb", "-o", f"{command}.vdb", *(["--resolution", 32] if command == "fractal" else []))
            self.assertEqual(said.count(self.UNEQUAL_SAID), 1)
        self.assertAlmostEqual(self.volume_of("sdf.vdb"), 8 / 3 * math.pi, delta=0.1)
        self.assertEqual(self.info("sdf.vdb")["grids"][0]["voxel size"], [0.05] * 3)

    # Promise: "The same recipe gives the same ..."
    def test_any_number_of_threads_makes_the_same(self):
        self.fog()
        for threads in (1, 2):
            self.ok("fractal", "fog.vdb", "-o", f"{threads}.vdb", "--resolution", 24, "--threads", threads)
        self.assertEqual(self.bytes("1.vdb"), self.bytes("2.vdb"))

    # Promise: A fog volume's surface is "where ..."
    # Promise: "The options are the same ..."
    # Promise: "Each of these commands says ..."
    def test_other_commands_take_them(self):
        self.fog()
        said = self.ok("fit", "fog.vdb", "-o", "x.json", "--resolution", 24, "--roots", 4)
        self.assertEqual(said.count(self.FOG_SAID), 1)
        self.ok("slice", "fog.vdb", "--iso", 1.5, "-o", "x.png", "--size", 20)
        self.ok("render", "--field", "fog.vdb", "--iso", 1.5, "-o", "y.png", "--size", "20x20")
        self.ok("study", "fog.vdb", "--iso", 1.5, "-o", "z.png", "--size", 20, "--versors", 2)
        self.ok("sheet", "fog.vdb", "-o", "sheet.png", "--size", "20x20", "--vary", "iso=1,3")
        self.ok("plan", "tiles", "fog.vdb", "-o", "farm", "--iso", 1.5, "--resolution", 24, "--tiles", 2)


def x3d(points, faces):
    corners = " ".join(f"{a} {b} {c} -1" for a, b, c in faces)
    places = " ".join(map(str, (x for point in points for x in point)))
    return (f'<?xml version="1.0" encoding="UTF-8"?><X3D version="3.3"><Scene><Shape><IndexedFaceSet coordIndex="{corners}">'
            f'<Coordinate point="{places}"/></IndexedFaceSet></Shape></Scene></X3D>')


class WhatIsSaid(harness.CliTest):
    """Every command that takes a target says how it was read, in one line, however many pictures it makes of it."""

    def check(self, target, lines, commands):
        for command in commands:
            with self.subTest(command=command):
                said = self.ok(*(target if word == "TARGET" else word for word in command))
                for line in lines:
                    self.assertEqual(said.count(line), 1, said)

    # Promise of targets.md: "Each of these commands says in one line what it found", in any number of frames and cells
    # Promise: Points whose coordinates are not ...
    def test_of_a_mesh(self):
        self.write("h.obj", harness.obj(shell(1, -0.6)) + "v nan 0 0\n")
        low = ("--resolution", 24, "--sdf-resolution", 24, "--detail", 0.3)
        self.check("h.obj", ("1 hollow of the target is filled; --hollows keep makes it a cavity\n",
                             "1 point of the target is left out"), (
            ("fractal", "TARGET", "-o", "f.####.vdb", "--frames", "1-2", *low),
            ("sdf", "TARGET", "-o", "d.vdb", "--resolution", 24),
            ("fit", "TARGET", "-o", "f.json", "--roots", 12, "--resolution", 24),
            ("slice", "TARGET", "-o", "s.png", "--size", 20, *low[2:]),
            ("slice", "TARGET", "-o", "l.####.png", "--stack", "--size", 20, *low[2:]),
            ("study", "TARGET", "-o", "c.png", "--size", 20, "--versors", 2, *low[2:]),
            ("sheet", "TARGET", "-o", "p.png", "--vary", "alpha=20,30", "--size", "40x40", *low[2:4]),
            ("render", "TARGET", "--field", "-o", "r.####.png", "--frames", "1-2", "--turn", 360, "--size", "20x20", *low[2:]),
            ("plan", "tiles", "TARGET", "-o", "farm", *low)))


class Imports(harness.CliTest):
    """What Assimp reads. tests/mesh_files/assimp_reader_test.cpp has the formats."""

    def setUp(self):
        super().setUp()
        points, faces = harness.sphere(2)
        # Numbers that have few digits are the same as floats.
        points = [tuple(round(8 * x) / 8 for x in point) for point in points]
        self.write("s.obj", harness.obj((points, faces)))
        self.write("s.x3d", x3d(points, faces))
        if b"built without" in self.run_program("info", "s.x3d").stderr:
            self.skipTest("this build has no Assimp")

    # Promise: FBX, DAE, 3DS and X3D: "the program ..."
    def test_it_is_read_with_the_option_only(self):
        self.ok("sdf", "s.obj", "-o", "o.vdb", "--resolution", 24)
        for command in (("sdf", "s.x3d", "-o", "x.vdb", "--resolution", 24), ("fractal", "s.x3d", "-o", "x.vdb", *LOW),
                        ("print", "s.x3d", "-o", "x.stl", "--longest-side", 20),
                        ("points", "s.x3d", "-o", "x.ply", "--points", 50),
                        ("plan", "tiles", "s.x3d", "-o", "plan", *LOW)):
            self.refused(BAD_DATA, *command, mentions=("s.x3d", "X3D", "--trust-importer", ".glb"))
            self.ok(*command, "--trust-importer")
        self.refused(BAD_DATA, "info", "s.x3d", mentions="--trust-importer")
        self.assertIn("closed: true", self.ok("info", "s.x3d", "--trust-importer", data=True))
        self.ok("sdf", "s.x3d", "-o", "x.vdb", "--resolution", 24, "--trust-importer")
        mine, theirs = (pyopenvdb.read(str(self.folder / name), "phi") for name in ("o.vdb", "x.vdb"))
        self.assertEqual([*mine.citerOnValues()][0].value, [*theirs.citerOnValues()][0].value)
        self.assertEqual(self.info("o.vdb")["grids"], self.info("x.vdb")["grids"])

    # Promise: FBX, DAE, 3DS and X3D: "the program ..."
    def test_a_recipe_does_not_set_it(self):
        made = ("fractal", "s.x3d", "-o", "x.vdb", *LOW)
        self.ok(*made, "--trust-importer")
        self.assertNotIn("trust", self.ok("recipe", "x.vdb", data=True))
        for command in (("fractal", "--config", "x.vdb", "-o", "y.vdb"), ("render", "x.vdb", "--field", "-o", "y.png")):
            self.refused(BAD_DATA, *command, mentions="--trust-importer")
        self.ok("fractal", "--config", "x.vdb", "-o", "y.vdb", "--trust-importer")
        self.assertEqual(self.bytes("x.vdb"), self.bytes("y.vdb"))
        for name in ("trust-importer", "trust_importer"):
            self.write("list.txt", f"{name} = true\n")
            self.refused(USAGE, *made, "--config", "list.txt", mentions=name)

    def test_tasks_have_it_where_it_is_given(self):
        plan = ("plan", "tiles", "s.x3d", "-o", "plan", "--tiles", 2, *LOW)
        self.ok(*plan, "--estimate", "--sample", 2, "--trust-importer")
        self.ok("plan", "frames", "s.x3d", "-o", "frames", "--frames", "1", "--key", "alpha@1=20", *LOW, "--trust-importer")
        task = self.run_program("task", "frames", "--index", 1)
        self.assertEqual(task.returncode, BAD_DATA)
        self.assertIn(b"--trust-importer", task.stderr)
        self.ok("task", "frames", "--index", 1, "--trust-importer")


class WhatIsNotUsed(harness.CliTest):

    # Promise of targets.md: A fractal "ends with a line that names what the run did not use"
    def test_it_is_named_in_one_line(self):
        points, faces = harness.needle()
        lines = [f"v {x} {y} {z}" for x, y, z in points] + ["vt 0 0", "vt 1 0", "vt 1 1"]
        lines += ["usemtl skin", "g front"] + [f"f {a + 1}/1 {b + 1}/2 {c + 1}/3" for a, b, c in faces[::2]]
        lines += ["usemtl cloth", "usemtl never", "usemtl skin", "g back"]
        lines += [f"f {a + 1}/1 {b + 1}/2 {c + 1}/3" for a, b, c in faces[1::2]]
        self.write("s.obj", "\n".join(lines) + "\n")
        info = self.info("s.obj")
        self.assertEqual((info["texture coordinates"], info["materials"], info["groups"]),
                         (True, ["skin"], ["front", "back"]))
        said = self.ok("fractal", "s.obj", "-o", "s.vdb", *LOW)
        self.assertEqual(said.count("not used of the target: texture coordinates, 1 material, 2 groups\n"), 1)

    # Promise: A fractal "ends with a line ..."
    def test_a_plain_mesh_has_no_such_line(self):
        self.write("s.obj", harness.obj(harness.needle()))
        self.assertNotIn("not used", self.ok("fractal", "s.obj", "-o", "s.vdb", *LOW))
        info = self.info("s.obj")
        for name in ("materials", "groups", "texture coordinates", "attributes"):
            self.assertNotIn(name, info)


if __name__ == "__main__":
    harness.main()

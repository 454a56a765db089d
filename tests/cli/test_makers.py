# SPDX-License-Identifier: Apache-2.0
"""What the commands for points, adaptive meshes and 3D printing promise."""

import io
import itertools
import math
import re
import struct
import unittest
import xml.etree.ElementTree as xml
import zipfile

import harness
from harness import BAD_DATA, USAGE

CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"


def rows_of(data):
    """Positions and normals of a PLY of points."""
    mesh = harness.read_ply(data)
    assert mesh.faces == []
    return mesh.points, mesh.normals


def least_distance(points):
    """By sorting along x."""
    points, least = sorted(points), math.inf
    for i, p in enumerate(points):
        for q in points[i + 1:]:
            if q[0] - p[0] >= least:
                break
            least = min(least, math.dist(p, q))
    return least


class Makers(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(3)))

    def fractal(self):
        self.ok("fractal", "s.obj", "-o", "f.vdb", "--mesh", "f.ply", "--resolution", 24, "--sdf-resolution", 24)

    def closed(self, name):
        mesh = harness.read_ply(self.bytes(name))
        self.assertEqual(harness.open_edges(mesh), [])
        return mesh

    # Points.

    # Promise: "No two points are nearer ..."
    # Promise of points.md: Points: "A `.ply` has vertices with normals and no faces"; "A `.vdb` has a grid of OpenVDB points
    #   named `points`"
    def test_points_of_a_mesh(self):
        said = self.ok("points", "s.obj", "-o", "p.ply", "--points", 500)
        points, normals = rows_of(self.bytes("p.ply"))
        self.assertEqual(len(points), 500)
        for p, n in zip(points, normals):
            self.assertAlmostEqual(math.dist(p, (0, 0, 0)), 1, delta=0.01)
            self.assertGreater(sum(a * b for a, b in zip(p, n)), 0.99)
        told = float(re.search(r"nearer than ([\d.e-]+),", said).group(1))
        # Said short, and yet true of every two points.
        self.assertLessEqual(told, least_distance(points))
        self.assertGreater(told, 0.999 * least_distance(points))
        self.ok("points", "s.obj", "-o", "q.ply", "--spacing", 0.2)
        self.assertGreaterEqual(least_distance(rows_of(self.bytes("q.ply"))[0]), 0.2 - 1e-6)

    # Promise: On a fractal "the points ..."
    def test_points_lie_on_the_true_surface_of_a_fractal(self):
        self.fractal()
        for name in ("f.vdb", "f.ply"):
            self.ok("points", name, "-o", "p.ply", "--points", 300)
            self.assertEqual(len(rows_of(self.bytes("p.ply"))[0]), 300)
        # The mesh's vertices are within 1/1000 of a voxel of the surface, and so is a mesh of a hundredth of it near
        # each point: here, the two ways of making points must differ, as the mesh's faces are not the surface.
        self.ok("points", "f.ply", "-o", "q.ply", "--points", 300, "--from-grid")
        self.assertNotEqual(rows_of(self.bytes("p.ply")), rows_of(self.bytes("q.ply")))

    # Promise of points.md: On a fractal "the points lie on the true surface F = 0, within the `--tolerance` of its recipe"
    def test_points_of_a_ball_lie_on_the_ball(self):
        """|q| < 1 stays bounded under q^2: the surface is a sphere, and the triangles of its mesh are not."""
        self.ok("fractal", "--map", "quadratic", "--c", "0,0,0,0", "--iterations", 20, "--escape", 20, "--resolution", 16,
                "-o", "q.vdb", "--mesh", "q.ply")
        voxel, radius = 2 / 16, 20 ** (1 / 2 ** 20)
        farthest = {}
        for name in ("q.vdb", "q.ply"):
            for way in ((), ("--from-grid",)):
                self.ok("points", name, "-o", "p.ply", "--points", 200, *way)
                farthest[name, way] = max(abs(math.hypot(*p) - radius) for p in rows_of(self.bytes("p.ply"))[0])
            self.assertLess(farthest[name, ()], 1.1e-3 * voxel)
            self.assertGreater(farthest[name, ("--from-grid",)], 10e-3 * voxel)

    # Promise of points.md: "the same one gives the same bytes on any machine" of points, and another seed others
    def test_points_are_the_same_for_any_number_of_threads(self):
        self.fractal()
        for output in ("p.ply", "p.vdb"):
            made = []
            for threads in (1, 4):
                self.ok("points", "f.vdb", "-o", output, "--spacing", 0.1, "--threads", threads)
                made.append(self.bytes(output))
            self.assertEqual(*made)
            self.ok("points", "f.vdb", "-o", output, "--spacing", 0.1, "--seed", 2)
            self.assertNotEqual(self.bytes(output), made[0])

    # Promise: Points: "A `.ply` has vertices ..."
    def test_points_as_vdb(self):
        self.ok("points", "s.obj", "-o", "p.vdb", "--points", 100)
        grids, = self.info("p.vdb")["grids"]
        self.assertEqual(grids["name"], "points")

    # Promise of points.md: "What a mesh has at its points is carried over"
    def test_colours_of_a_mesh_are_carried_over(self):
        points, faces = harness.sphere(3)
        lines = [f"v {x} {y} {z} {1 if y > 0 else 0} 0 0\n" for x, y, z in points]
        self.write("c.obj", "".join(lines) + "".join("f {} {} {}\n".format(*(k + 1 for k in f)) for f in faces))
        self.ok("points", "c.obj", "-o", "p.ply", "--points", 200)
        head, _, body = self.bytes("p.ply").partition(b"end_header\n")
        self.assertIn(b"property uchar red\n", head)
        for x, y, z, *_, red, green, blue in struct.iter_unpack("<6f3B", body):
            if abs(y) > 0.3:
                self.assertEqual((red, green, blue), (255 if y > 0 else 0, 0, 0))

    def test_points_refuse_what_makes_no_sense(self):
        points = ("points", "s.obj", "-o", "p.ply")
        self.refused(USAGE, *points, mentions="--spacing")
        self.refused(USAGE, *points, "--points", 0, mentions="--points")
        self.refused(USAGE, *points, "--points", 5, "--spacing", 1)
        self.refused(USAGE, *points, "--spacing", "1e-9", mentions="larger spacing")
        self.refused(USAGE, "points", "s.obj", "-o", "p.stl", "--points", 5, mentions=".vdb")

    # Adaptive meshes.

    # Promise of README.md: "`--adaptivity 0.2` leaves out triangles where it is flat", and the mesh stays closed
    def test_adaptive_meshes_are_closed_and_have_fewer_triangles(self):
        self.fractal()
        full = self.closed("f.ply")
        before = len(full.faces)
        for adaptivity in (0.02, 0.2):
            self.ok("mesh", "f.vdb", "-o", "a.ply", "--adaptivity", adaptivity)
            mesh = self.closed("a.ply")
            self.assertLess(len(mesh.faces), before)
            self.assertLessEqual(set(mesh.points), set(full.points), "points were moved")
            before = len(mesh.faces)
        self.ok("fractal", "--config", "f.vdb", "--mesh", "b.ply", "--adaptivity", 0.2)
        self.assertEqual(self.bytes("a.ply"), self.bytes("b.ply"))
        self.ok("mesh", "f.vdb", "-o", "g.ply", "--from-grid", "--adaptivity", 0.1)
        self.closed("g.ply")
        self.refused(USAGE, "mesh", "f.vdb", "-o", "n.ply", "--adaptivity", -1, mentions="--adaptivity")
        # It is part of the recipe: a VDB keeps it for the meshes to come. Tiles cannot have it.
        self.ok("fractal", "--config", "f.vdb", "-o", "kept.vdb", "--mesh", "kept.ply", "--adaptivity", 0.2)
        self.ok("mesh", "kept.vdb", "-o", "c.ply")
        self.assertEqual(self.bytes("c.ply"), self.bytes("a.ply"))
        self.refused(USAGE, "plan", "tiles", "--config", "kept.vdb", "-o", "farm", mentions="--adaptivity")

    # Parts for printing.

    # Promise of printing.md: A part is "one closed piece, in millimetres, with z up, standing on z = 0"
    # Promise: `--longest-side`: "The longest ..."
    def test_a_part_has_the_size_in_every_format(self):
        self.fractal()
        for name in ("s.obj", "f.vdb", "f.ply"):
            self.ok("print", name, "-o", "p.stl", "--size", 40)
            corners = [p for t in harness.read_stl(self.bytes("p.stl")) for p in t]
            low, high = ([f(p[k] for p in corners) for k in range(3)] for f in (min, max))
            self.assertAlmostEqual(max(h - l for l, h in zip(low, high)), 40, delta=1e-4)
            self.assertAlmostEqual(low[2], 0, delta=1e-5)
            self.assertAlmostEqual(low[0] + high[0], 0, delta=1e-4)
        self.ok("print", "f.vdb", "-o", "p.ply", "--size", 40, "--min-thickness", 4, "--resolution", 40)
        self.closed("p.ply")

    # Promise of printing.md: Without a thickness and a base, "with `--tolerance 0` it is exactly that surface", of the fractal's mesh
    def test_without_a_thickness_the_surface_is_that_of_the_mesh(self):
        """Of the largest island, scaled, turned and moved, and nothing else."""
        self.fractal()
        self.ok("fractal", "--config", "f.vdb", "--largest", 1, "-o", "g.vdb", "--mesh", "g.ply")
        given = harness.read_ply(self.bytes("g.ply"))
        self.ok("print", "g.vdb", "-o", "p.ply", "--size", 40, "--tolerance", 0)
        part = harness.read_ply(self.bytes("p.ply"))
        turned = [(x, -z, y) for x, y, z in given.points]
        low, high = ([f(p[k] for p in turned) for k in range(3)] for f in (min, max))
        scale = 40 / max(h - l for l, h in zip(low, high))
        moved = sorted(tuple(scale * (c - (l if k == 2 else (l + h) / 2)) for k, (c, l, h) in enumerate(zip(p, low, high)))
                       for p in turned)
        self.assertEqual(len(part.faces), len(given.faces))
        self.assertEqual(len(part.points), len(given.points))
        near = {tuple(round(c / 0.01) for c in p) for p in part.points}
        steps = [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]
        for point in moved:
            cell = tuple(round(c / 0.01) for c in point)
            self.assertTrue(any(tuple(a + b for a, b in zip(cell, step)) in near for step in steps), point)

    # Promise of printing.md: `--tolerance`: "with the same extents; 0.05 mm by default"
    # Promise of printing.md: `--longest-side`: "The longest side of the finished part"
    def test_the_size_does_not_depend_on_the_tolerance(self):
        points, faces = harness.sphere(4)
        self.write("plate.obj", harness.obj(([(x, 0.05 * y, z) for x, y, z in points], faces)))
        count, made = len(faces) + 1, {}
        for tolerance in (0, 0.01, 0.05, 0.3):
            self.ok("print", "plate.obj", "-o", f"{tolerance}.ply", "--size", 40, "--tolerance", tolerance)
            mesh = made[tolerance] = self.closed(f"{tolerance}.ply")
            extents = [max(p[k] for p in mesh.points) - min(p[k] for p in mesh.points) for k in range(3)]
            self.assertAlmostEqual(max(extents), 40, delta=1e-4)
            self.assertLess(len(mesh.faces), count)
            count = len(mesh.faces)
        self.assertEqual(len(made[0].faces), len(faces))
        self.ok("print", "plate.obj", "-o", "usual.ply", "--size", 40)
        self.assertEqual(self.bytes("usual.ply"), self.bytes("0.05.ply"))

    # Promise: A part is "one closed piece, in millimetres, with z ..."
    def test_what_points_up(self):
        points, faces = harness.sphere(3)
        self.write("tall.obj", harness.obj(([(x, 3 * y, z) for x, y, z in points], faces)))
        for axis, tall in (("y", 2), ("z", 1)):
            self.ok("print", "tall.obj", "-o", "p.ply", "--size", 30, "--up", axis)
            mesh = harness.read_ply(self.bytes("p.ply"))
            extents = [max(p[k] for p in mesh.points) - min(p[k] for p in mesh.points) for k in range(3)]
            self.assertEqual(extents.index(max(extents)), tall)
            self.assertGreater(harness.volume_of(mesh), 0)

    # Promise: A part is "one closed piece, in millimetres, with z ..."
    # Promise of printing.md: "A 3MF says that its unit is the millimetre"
    def test_3mf_is_what_its_readers_expect(self):
        run = self.run_program("print", "s.obj", "-o", "p.3mf", "--size", 40)
        if b"libzip" in run.stderr:
            self.skipTest("this build has no libzip")
        self.assertEqual(run.returncode, 0, run.stderr)
        first = self.bytes("p.3mf")
        self.ok("print", "s.obj", "-o", "p.3mf", "--size", 40)
        self.assertEqual(self.bytes("p.3mf"), first)
        with zipfile.ZipFile(io.BytesIO(first)) as file:
            self.assertIsNone(file.testzip())
            self.assertEqual(file.namelist(), ["[Content_Types].xml", "_rels/.rels", "3D/3dmodel.model"])
            for name in file.namelist():
                xml.fromstring(file.read(name))
            model = xml.fromstring(file.read("3D/3dmodel.model"))
        self.assertEqual(model.get("unit"), "millimeter")
        points = [tuple(float(v.get(k)) for k in "xyz") for v in model.iter(f"{CORE}vertex")]
        faces = [tuple(int(t.get(k)) for k in ("v1", "v2", "v3")) for t in model.iter(f"{CORE}triangle")]
        mesh = harness.Mesh(points, faces, [], {}, False)
        self.assertEqual(harness.open_edges(mesh), [])
        self.assertAlmostEqual(harness.volume_of(mesh), 4 / 3 * math.pi * 20**3, delta=600)
        item, = model.iter(f"{CORE}item")
        self.assertEqual([o.get("id") for o in model.iter(f"{CORE}object")], [item.get("objectid")])

    def test_a_3mf_is_a_target_again(self):
        for words in (("print", "s.obj", "-o", "p.3mf", "--size", 40), ("info", "p.3mf")):
            run = self.run_program(*words)
            if b"libzip" in run.stderr or b"libexpat" in run.stderr:
                self.skipTest("this build cannot read 3MF")
        self.ok("print", "s.obj", "-o", "p.ply", "--size", 40)
        told, known = self.info("p.3mf"), self.info("p.ply")
        for name in ("points", "triangles", "closed"):
            self.assertEqual(told[name], known[name], name)
        self.assertEqual(told["unit"], "mm")
        self.assertAlmostEqual(told["volume"], known["volume"], delta=1e-4 * known["volume"])
        self.ok("sdf", "p.3mf", "-o", "p.vdb", "--resolution", 24)
        self.assertEqual(self.info("p.vdb")["metadata"]["julia_length_unit"], "mm")
        self.refused(USAGE, "sdf", "p.3mf", "-o", "p.vdb", "--resolution", 24, "--units", "in", mentions=("mm", "p.3mf"))

    def test_a_small_base_is_told_with_the_way_to_a_larger_one(self):
        """A ball with a little cut off, and a needle; what is proposed is large enough, and a cube is in any case."""
        self.write("ball.obj", harness.obj(harness.sphere(3)))
        points, faces = harness.sphere(3)
        self.write("needle.obj", harness.obj(([(0.1 * x, y, 0.1 * z) for x, y, z in points], faces)))
        self.write("cube.obj", harness.obj(harness.cube()))
        for name, base in (("ball", 0.15), ("needle", 1)):
            words = ("print", f"{name}.obj", "-o", "p.stl", "--longest-side", 60, "--resolution", 120, "--tolerance", 0,
                     "--flat-base")
            said = self.ok(*words, base)
            area = float(re.search(r"stands on a base of ([\d.]+) mm2", said)[1])
            better = float(re.search(r"warning: .* --flat-base ([\d.]+) gives", said)[1])
            again = self.ok(*words, better)
            self.assertNotIn("come off", again)
            self.assertGreater(float(re.search(r"stands on a base of ([\d.]+) mm2", again)[1]), 1.5 * area)
        self.assertNotIn("come off", self.ok("print", "cube.obj", "-o", "p.stl", "--longest-side", 60, "--flat-base", 0.5, "--resolution", 60))

    def test_a_part_without_a_flat_base_is_told_whether_it_has_a_first_layer(self):
        self.write("ball.obj", harness.obj(harness.sphere(3)))
        self.write("cube.obj", harness.obj(harness.cube()))
        words = ("print", "ball.obj", "-o", "p.stl", "--longest-side", 60, "--tolerance", 0)
        better = re.search(r"note: .* first layer; --flat-base ([\d.]+) gives", self.ok(*words))[1]
        self.assertNotIn("warning", self.ok(*words, "--flat-base", better))
        self.assertNotIn("first layer", self.ok("print", "cube.obj", "-o", "p.stl", "--longest-side", 60))

    # Promise of printing.md: The command says "how large the part is, how much material it takes, and how thick its thinnest
    #   place is"
    def test_what_it_says_is_what_was_made(self):
        said = self.ok("print", "s.obj", "-o", "p.ply", "--size", 40, "--flat-base", 4, "--resolution", 40)
        mesh = self.closed("p.ply")
        volume = float(re.search(r"([\d.]+) cm3", said).group(1))
        self.assertAlmostEqual(volume, harness.volume_of(mesh) / 1000, delta=0.006 * volume)
        self.assertRegex(said, r"stands on a base of \d+ mm2")
        self.assertRegex(said, r"the thinnest place found is more than [\d.]+ mm thick")

    # Promise of printing.md: "where the thinnest place is up to 2 % below what was asked for the command says so, and where it is
    #   less than that it warns"
    def test_a_part_that_stays_too_thin_is_told(self):
        """What is below the least thickness by no more than a thickness is measured exactly is said, and more is warned of.
        On coarse lattices both happen to a rough fractal: sooner or later, as which one does depends on every bit."""
        self.write("l.obj", harness.obj(harness.lumpy()))
        self.ok("fractal", "l.obj", "-o", "g.vdb", "--alpha", 10, "--texture-seed", 1, "--resolution", 40,
                "--sdf-resolution", 32)
        exact, warned = "as exactly as it is measured, within 2 %", re.compile(r"warning: \d+ places? (is|are) thinner than")
        wanted, heard = {(True, False), (False, True), (False, False)}, set()
        for thickness, resolution in itertools.product((2, 3, 4), range(20, 44)):
            said = self.ok("print", "g.vdb", "-o", "p.stl", "--size", 60, "--min-thickness", thickness, "--resolution", resolution,
                           "--tolerance", 0)
            found = float(re.search(r"the thinnest place found is ([\d.]+) mm", said).group(1))
            with self.subTest(thickness=thickness, resolution=resolution, said=said):
                self.assertEqual(bool(warned.search(said)), found < 0.98 * thickness)
                self.assertEqual(exact in said, 0.98 * thickness <= found < thickness)
            heard.add((bool(warned.search(said)), exact in said))
            if heard == wanted:
                break
        self.assertEqual(heard, wanted)

    # Promise: "Closed parts that run ..."
    def test_parts_that_run_into_each_other_are_told(self):
        self.write("two.obj", harness.obj(harness.snowman()))
        told = self.ok("print", "two.obj", "-o", "p.ply", "--longest-side", 40, "--resolution", 40)
        self.assertIn("2 parts of the mesh run into each other", told)
        self.assertNotIn("island", told)
        self.closed("p.ply")

    def test_parts_refuse_what_makes_no_sense(self):
        part = ("print", "s.obj", "-o", "p.stl")
        self.refused(USAGE, *part, mentions="--longest-side")
        self.refused(USAGE, *part, "--size", 0, mentions="--longest-side")
        self.refused(USAGE, *part, "--size", 10, "--min-thickness", 9, mentions="quarter")
        self.refused(USAGE, *part, "--size", 10, "--thin", "drop", mentions="--min-thickness")
        self.refused(USAGE, *part, "--size", 10, "--min-thickness", 1, "--thin", "melt", mentions="drop")
        self.refused(USAGE, *part, "--size", 10, "--up", "x", mentions="y")
        points, faces = harness.sphere(2)
        self.write("flat.obj", harness.obj(([(x, 0.3 * y, z) for x, y, z in points], faces)))
        self.refused(USAGE, "print", "flat.obj", "-o", "p.stl", "--size", 40, "--flat-base", 12.5, "--resolution", 40,
                     mentions=["12.5 mm", "mm high"])
        self.refused(USAGE, "print", "s.obj", "-o", "p.gcode", "--size", 10, mentions=".3mf")
        self.write("hole.obj", harness.obj(harness.with_hole(harness.sphere(3), 0.9)))
        self.refused(BAD_DATA, "print", "hole.obj", "-o", "p.stl", "--size", 10, mentions="--repair")
        self.ok("print", "hole.obj", "-o", "p.stl", "--size", 10, "--repair", "--resolution", 24)


if __name__ == "__main__":
    harness.main()

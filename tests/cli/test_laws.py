# SPDX-License-Identifier: Apache-2.0
"""Laws that the meshes obey, whatever their numbers: closed, of known size where a size is known, equal in every format
and from every way to them, and moving with their targets."""

import math
import re

import pyopenvdb

import harness

LOW = ("--resolution", 28, "--sdf-resolution", 28)
BOX = (-0.4, -0.5, -0.3, 0.7, 0.8, 0.9)
BOX_TEXT = ",".join(map(str, BOX))


class Laws(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(3)))
        self.write("t.obj", harness.obj(harness.torus()))

    def mesh(self, *arguments):
        self.ok(*arguments, "m.ply")
        return harness.read_ply(self.bytes("m.ply"))

    def fractal(self, *options):
        return self.mesh("fractal", *options, "--mesh")

    @staticmethod
    def low(target):
        """There are distances of targets only."""
        return LOW if target.endswith(".obj") else LOW[:2]

    def check_closed(self, mesh):
        for (a, b), uses in harness.edge_uses(mesh).items():
            self.assertEqual(uses, 1, f"the edge {a}-{b} has a direction twice")
        self.assertEqual(len(harness.open_edges(mesh)), 0, "open edges")
        self.check_vertices(mesh)
        self.assertGreater(harness.volume_of(mesh), 0)

    def check_vertices(self, mesh):
        self.assertTrue(all(math.isfinite(c) for p in mesh.points for c in p))
        self.assertTrue(all(len(set(f)) == 3 for f in mesh.faces), "a face has a corner twice")
        self.assertEqual(set(range(len(mesh.points))), {k for f in mesh.faces for k in f}, "a vertex of no face")
        self.assertEqual(len(mesh.normals), len(mesh.points))
        self.assertTrue(all(abs(math.hypot(*n) - 1) < 1e-5 for n in mesh.normals))


class Closed(Laws):

    # Promise of README.md: A mesh is "closed, 2-manifold, oriented outward, with normals"
    def test_closed_and_manifold(self):
        for options in (("s.obj",), ("t.obj", "--alpha", 15), ("t.obj", "--alpha", "x:8:200", "--beta", -0.02),
                        ("s.obj", "--slice", 0.3, "--origin", "0.1,0.05,-0.1"), ("t.obj", "--iterations", 1),
                        ("t.obj", "--drop-axis", "j", "--texture-integer"), ("s.obj", "--space", "world"),
                        ("t.obj", "--tolerance", 0.5), ("t.obj", "--sampling", "quadratic"), ("s.obj", "--precision", "float"), ("s.obj", "--exhaustive"),
                        ("--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", "--iterations", 8)):
            with self.subTest(options=options):
                self.check_closed(self.fractal(*options, *self.low(options[0])))

    # Promise of design.md: `--follow`: "What it finds is exact and closed", and the share that is missed is told
    # Promise of options.md: "`--seed-stride 4` finds more" than the default of 8, or as much
    def test_following_finds_the_surface(self):
        """--follow says what it left out, finds what the whole shell holds but for a few islands, and closes it."""
        job = ("fractal", "t.obj", "--resolution", 100, "--sdf-resolution", 48, "--alpha", 40)
        whole = self.mesh(*job, "--mesh")
        found = set()
        for stride in (8, 4, 2):
            said = self.ok(*job, "--mesh", "followed.ply", "--follow", "--seed-stride", stride)
            self.assertIn("missed by an estimate", said)
            followed = harness.read_ply(self.bytes("followed.ply"))
            self.check_closed(followed)
            self.assertLessEqual(set(followed.points), set(whole.points))
            self.assertGreater(len(followed.points), 0.99 * len(whole.points))
            self.assertLessEqual(found, set(followed.points), "seeds nearer to each other find less")
            found = set(followed.points)

    # Promise of options.md: "keep only the N largest" islands, "or those of at least a given size"; the others go whole
    def test_islands_are_dropped_whole(self):
        rough = ("t.obj", "--alpha", 15, "--texture-seed", 3, *LOW)
        whole = self.fractal(*rough)
        largest = self.fractal(*rough, "--largest", 1)
        self.check_closed(largest)
        self.assertLess(len(largest.faces), len(whole.faces))
        self.assertLessEqual(set(largest.points), set(whole.points))
        self.check_closed(self.fractal(*rough, "--min-size", 0.15))
        self.refused(harness.BAD_DATA, "fractal", *rough, "--min-size", 50, "-o", "none.vdb", mentions="min-size")

    # Promise of options.md: Crumbs, "pieces of at most 8 voxels along each axis", are dropped unless kept, "the summary says how
    #   many and how much", and an earlier version's recipe keeps them
    def test_crumbs_are_dropped_whole(self):
        """Small pieces go, and the summary says how many; with --crumbs keep they are there, as in an earlier version's recipe."""
        rough = ("t.obj", "--detail", 0.6, "--texture", "random", "--texture-seed", 3, "--resolution", 90, "--sdf-resolution", 40)
        kept = self.fractal(*rough, "--crumbs", "keep")
        said = self.ok("fractal", *rough, "-o", "f.vdb", "--mesh", "f.ply")
        count, voxels, islands = map(int, re.search(
            r"(\d+) crumbs? of (\d+) voxels?, [\d.e-]+ % of the volume, dropped[\s\S]*? in (\d+) island", said).groups())
        self.assertGreater(count, 3)
        self.assertGreaterEqual(voxels, count)
        dropped = harness.read_ply(self.bytes("f.ply"))
        self.check_closed(dropped)
        self.assertLess(len(dropped.faces), len(kept.faces))
        self.assertLess(set(dropped.points), set(kept.points))
        all_of_them = self.ok("fractal", *rough, "--mesh", "k.ply", "--crumbs", "keep")
        self.assertEqual(int(re.search(r"in (\d+) islands", all_of_them)[1]), islands + count)
        self.assertNotIn("crumb", all_of_them)
        # Streamed, held, and made again from the recipe.
        self.ok("fractal", *rough, "--mesh", "s.ply")
        self.assertEqual(self.bytes("s.ply"), self.bytes("f.ply"))
        self.ok("mesh", "f.vdb", "-o", "again.ply")
        self.assertEqual(self.bytes("again.ply"), self.bytes("f.ply"))
        # A file of an earlier version: its recipe has no such option.
        old = re.sub(rb"comment juliavdb julia_crumbs [^\n]*\n", b"", self.bytes("k.ply"))
        self.assertLess(len(old), len(self.bytes("k.ply")))
        self.write("old.ply", old)
        self.ok("fractal", "--config", "old.ply", "--mesh", "as_old.ply")
        self.assertEqual(self.bytes("as_old.ply"), self.bytes("k.ply"))

    # Promise: Crumbs, "pieces of at most ..."
    def test_a_small_target_is_no_crumb(self):
        for resolution in (3, 6):
            self.check_closed(self.fractal("s.obj", "--sdf-resolution", 16, "--resolution", resolution))
        # Nothing but crumbs is no result.
        dust = ("--map", "quadratic", "--resolution", 4)
        self.refused(harness.BAD_DATA, "fractal", *dust, "--crumbs", "drop", "-o", "none.vdb", mentions="--crumbs")
        self.refused(harness.BAD_DATA, "fractal", *dust, "--crumbs", "drop", "--mesh", "none.ply", mentions="--crumbs")
        kept = self.fractal(*dust, "--crumbs", "keep")
        self.check_closed(kept)
        self.assertEqual(self.fractal(*dust).points, kept.points, "sets without a target keep theirs")

    # Promise: A mesh is "closed, 2-manifold, oriented ..."
    def test_a_rational_map(self):
        self.write("v.o3d", harness.o3d(harness.ROOTS, harness.ROOTS[:1]))
        for words in (("--map", "rational"), ("s.obj", "--map", "rational")):
            with self.subTest(words=words):
                self.check_closed(self.fractal(*words, "--texture", "v.o3d", *self.low(words[0]), "--cap"))

    # Promise: "With `--box` it ends at the box" ...
    def test_a_capped_box(self):
        mesh = self.fractal("s.obj", *LOW, "--box", BOX_TEXT, "--cap")
        self.check_closed(mesh)
        # Caps lie on the faces of the box; on a face through nodes, a hundredth of a voxel beyond.
        margin = 0.01 * 2 / 28
        self.check_box(mesh, margin)
        for axis in range(3):
            self.assertLess(min(p[axis] for p in mesh.points), BOX[axis] + 1e-6)
            self.assertGreater(max(p[axis] for p in mesh.points), BOX[axis + 3] - 1e-6)
        # Faces through nodes: 2/28 is the voxel's size.
        nodes = [k * 2 / 28 for k in (-6, -7, -4, 10, 11, 9)]
        mesh = self.fractal("s.obj", *LOW, "--box", ",".join(map(repr, nodes)), "--cap")
        self.check_closed(mesh)
        for axis in range(3):
            for end, face in ((min, nodes[axis]), (max, nodes[axis + 3])):
                self.assertAlmostEqual(end(p[axis] for p in mesh.points), face, delta=1.01 * margin)

    # Promise of README.md: "With `--box` it ends at the box" and is open exactly there; "`--cap` closes it there"
    def test_an_open_box(self):
        mesh = self.fractal("s.obj", *LOW, "--box", BOX_TEXT)
        self.check_vertices(mesh)
        self.check_box(mesh, 0)
        edges = harness.open_edges(mesh)
        self.assertGreater(len(edges), 0)
        # The border is the outermost lattice nodes in the box.
        voxel = 2 / 28
        faces = [math.ceil(x / voxel - 1e-9) * voxel for x in BOX[:3]], [math.floor(x / voxel + 1e-9) * voxel
                                                                         for x in BOX[3:]]
        for edge in edges:
            ends = [mesh.points[k] for k in edge]
            self.assertTrue(
                any(all(abs(p[axis] - side[axis]) < 1e-6 for p in ends) for axis in range(3) for side in faces),
                f"the open edge {ends} is not on the border of {faces}")

    def check_box(self, mesh, margin):
        for point in mesh.points:
            for axis in range(3):
                self.assertGreaterEqual(point[axis], BOX[axis] - margin - 1e-6)
                self.assertLessEqual(point[axis], BOX[axis + 3] + margin + 1e-6)

    # Promise: "With `--box` it ends at the box" ...
    def test_the_box_cuts_and_changes_nothing_else(self):
        whole = self.fractal("s.obj", *LOW)
        part = self.fractal("s.obj", *LOW, "--box", BOX_TEXT)
        self.assertLess(set(part.points), set(whole.points))

    # Promise: `mesh` makes the mesh of a fractal's ...
    def test_from_the_grid(self):
        self.ok("fractal", "t.obj", *LOW, "-o", "t.vdb")
        mesh = self.mesh("mesh", "t.vdb", "--from-grid", "-o")
        self.check_closed(mesh)
        self.ok("sdf", "t.obj", "-o", "sdf.vdb", "--resolution", 40)
        mesh = self.mesh("mesh", "sdf.vdb", "-o")
        self.check_closed(mesh)
        self.assertEqual(len(mesh.points) - len(mesh.faces) // 2, 0, "a torus has the Euler number 0")


class Sizes(Laws):

    # Promise: "Every vertex is within the tolerance ..."
    def test_the_unit_ball(self):
        """|q| < 1 stays bounded under q^2 and all else does not: with n steps the surface is at escape^(1/2^n)."""
        n, escape, voxel = 20, 20, None
        mesh = self.fractal("--map", "quadratic", "--c", "0,0,0,0", "--iterations", n, "--escape", escape,
                            "--resolution", 60)
        self.check_closed(mesh)
        box = [max(p[axis] for p in mesh.points) for axis in range(3)]
        radius = escape**(1 / 2**n)
        voxel = float(self.info("m.ply")["recipe"].get("voxel-size", 0)) or 2.0 / 60
        # The vertices lie on the sphere within tolerance x voxel; the chords of cells of side h cut off at most
        # 3 h^2 / 8 R (a triangle's corners are within sqrt(3) h of one another).
        for point in mesh.points:
            self.assertAlmostEqual(math.hypot(*point), radius, delta=1e-3 * voxel + 1e-6)
        sagitta = 3 * voxel**2 / 8
        self.assertLess(harness.volume_of(mesh), 4 / 3 * math.pi * radius**3)
        self.assertGreater(harness.volume_of(mesh), 4 / 3 * math.pi * (1 - sagitta)**3)
        self.assertLess(harness.area_of(mesh), 4 * math.pi * radius**2)
        self.assertGreater(harness.area_of(mesh), 4 * math.pi * (1 - sagitta)**2 * 0.99)
        self.assertLess(max(box), 1 + 1e-4)

    def test_floats_that_are_too_coarse_are_named(self):
        ball = ("fractal", "--map", "quadratic", "--c", "0,0,0,0", "--iterations", 26, "--escape", 20, "--mesh", "z.ply")
        near = lambda size: ("--box", f"{1 - size},{-size},{-size},{1 + size},{size},{size}", "--voxel-size", size / 10)
        said = self.ok(*ball, *near(1e-5), "--precision", "float")
        self.assertNotIn("precision", said)
        self.assertRegex(self.ok(*ball, *near(1e-6), "--precision", "float"), r"warning: --precision float rounds .* 0\.\d+ voxels")
        for precision in ("double", "auto"):
            self.assertNotIn("--precision", self.ok(*ball, *near(1e-6), "--precision", precision))

    # Promise: A larger alpha is nearer ...
    def test_a_larger_beta_is_a_larger_set(self):
        volumes = [harness.volume_of(self.fractal("s.obj", *LOW, "--beta", beta)) for beta in (-0.05, 0, 0.05)]
        self.assertLess(volumes[0], volumes[1])
        self.assertLess(volumes[1], volumes[2])

    # Promise of design.md: A larger alpha is nearer to the target, and "A positive beta moves the shell outward"
    def test_a_larger_alpha_is_nearer_to_the_target(self):
        target = harness.volume_of(harness.read_obj(self.bytes("s.obj")))
        errors = [abs(harness.volume_of(self.fractal("s.obj", *LOW, "--alpha", alpha)) - target)
                  for alpha in (10, 40, 160, 640)]
        self.assertEqual(errors, sorted(errors, reverse=True))
        # At 640 the shell from E = ln(r_in) to ln(20) is thinner than ln(20)/640 of the longest side on the outside.
        self.assertLess(errors[-1], 4 * math.pi * 2 * math.log(20) / 640 * 2)


class Similarity(Laws):

    # Promise of options.md: "the same for a target of any size at any place"
    def test_scaled_and_moved_targets(self):
        """alpha = 40 means the same in metres and millimetres, here and a mile away."""
        # Coordinates and moves that doubles hold exactly: what differs is the program's own rounding.
        voxel = 1 / 16
        points, faces = harness.sphere(3)
        target = [tuple(round(c * 2**20) / 2**20 for c in p) for p in points], faces
        self.write("plain.obj", harness.obj(target))
        low = ("--resolution", 32, "--sdf-resolution", 32)
        plain = self.fractal("plain.obj", *low)
        for factor, steps in ((1024.0, (0, 0, 0)), (1 / 64, (0, 0, 0)), (1.0, (2**12, -2**13, 2**11)),
                              (1024.0, (2**12, 2**10, 0)), (1.0, (100000 * 16, 0, 100000 * 16))):
            with self.subTest(factor=factor, steps=steps):
                by = [k * factor * voxel for k in steps]
                self.write("moved.obj", harness.obj(harness.moved(target, factor, by)))
                mesh = self.fractal("moved.obj", *low)
                # A written float is exact to 2^-24 of its size; where that is more than 1/1000 voxel, doubles are
                # written. A vertex is exact to the tolerance, 1/1000 voxel, and may sit anywhere within it.
                slack = min(2**-24 * (max(map(abs, by)) / factor + 1.5), 1e-3 * voxel) + 2e-3 * voxel
                back = [tuple((y - b) / factor for y, b in zip(p, by)) for p in mesh.points]
                self.check_same(plain, back, mesh.faces, slack)

    def check_same(self, mesh, points, faces, slack):
        """The same triangles. Their order is that of the lattice's blocks, which stay where they are."""
        self.assertEqual(len(points), len(mesh.points))
        self.assertEqual(len(faces), len(mesh.faces))
        cell = lambda p: tuple(math.floor(c / (4 * slack)) for c in p)
        near = {}
        for index, point in enumerate(mesh.points):
            near.setdefault(cell(point), []).append(index)
        steps = [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]
        match = []
        for point in points:
            candidates = [k for step in steps for k in near.get(tuple(c + d for c, d in zip(cell(point), step)), ())]
            self.assertGreater(len(candidates), 0, f"there was no vertex near {point}")
            best = min(candidates, key=lambda k: math.dist(mesh.points[k], point))
            for x, y in zip(mesh.points[best], point):
                self.assertAlmostEqual(x, y, delta=slack)
            match.append(best)
        turned = lambda f: min((f[k:] + f[:k] for k in range(3)))
        if len(set(match)) == len(match):  # no two vertices within the slack of one another
            self.assertTrue({turned(f) for f in mesh.faces} == {turned(tuple(match[k] for k in f)) for f in faces},
                            "the triangles differ")

    # Promise: "the same for a target of any ..."
    def test_a_thousand_times_as_large(self):
        plain = self.fractal("s.obj", *LOW)
        self.write("large.obj", harness.obj(harness.moved(harness.sphere(3), 1000.0, (0, 0, 0))))
        large = self.fractal("large.obj", *LOW)
        self.assertEqual(len(large.points), len(plain.points))
        for p, q in zip(plain.points, large.points):
            for x, y in zip(p, q):
                self.assertAlmostEqual(y / 1000, x, delta=2e-3 * 2 / 28)

    # Promise of options.md: "The fractal itself does not depend on" `--resolution`: a node has the same F on every lattice
    def test_the_fractal_does_not_depend_on_the_resolution(self):
        """Every node of a lattice is a node of the one that is twice as fine, and has the same value there."""
        self.write("l.obj", harness.obj(harness.lumpy()))
        low = ("fractal", "l.obj", "--grids", "logmodulus", "--exhaustive", "--crumbs", "keep")
        for resolution in (20, 40):
            self.ok(*low, "--resolution", resolution, "--sdf-resolution", 40, "-o", f"{resolution}.vdb")
        coarse, fine = (pyopenvdb.read(str(self.path(f"{resolution}.vdb")), "logmodulus") for resolution in (20, 40))
        values, compared = fine.getConstAccessor(), 0
        for item in coarse.iterOnValues():
            value, active = values.probeValue(tuple(2 * k for k in item.min))
            if active:
                self.assertEqual(value, item.value, item.min)
                compared += 1
        self.assertGreater(compared, 10000)

    # Promise of options.md: On `--sdf-resolution` "the fractal does depend"
    def test_the_fractal_depends_on_the_resolution_of_the_distances(self):
        self.write("l.obj", harness.obj(harness.lumpy()))
        for resolution in (30, 40):
            self.ok("fractal", "l.obj", "--resolution", 24, "--sdf-resolution", resolution, "--mesh", f"{resolution}.stl")
        self.assertNotEqual(self.bytes("30.stl"), self.bytes("40.stl"))

    # Promise of options.md: "`--space world` uses the coordinates as they are"
    def test_the_world_as_it_is(self):
        """A target about 0 whose longest side is 1 lies in the world as in fractal space; one twice as large does not."""
        self.write("one.obj", harness.obj(harness.sphere(3, 0.5)))
        self.write("two.obj", harness.obj(harness.sphere(3, 1.0)))
        volumes = {}
        for name in ("one", "two"):
            for space, options in (("fit", ("--origin", "centre")), ("world", ("--space", "world"))):
                self.ok("fractal", f"{name}.obj", *LOW, "--alpha", 40, *options, "--mesh", f"{name}_{space}.stl", "-o",
                        f"{name}_{space}.vdb")
                volumes[name, space] = harness.volume_of(self.mesh("mesh", f"{name}_{space}.vdb", "-o"))
        self.assertEqual(self.bytes("one_fit.stl"), self.bytes("one_world.stl"))
        self.assertAlmostEqual(volumes["two", "fit"] / volumes["one", "fit"], 8, delta=1e-3)
        self.assertGreater(abs(volumes["two", "world"] / volumes["one", "world"] - 8), 0.05)

    # Promise of precision.md: "`auto` chooses float if the voxel is at least 1e-3 of the largest coordinate, the summed powers of
    #   the versor are at most 250, and there are at most 10 iterations"
    def test_doubles_are_taken_where_floats_are_not_exact_enough(self):
        """The rule of docs/precision.md, on both sides of each of its bounds."""
        powers = lambda *each: harness.rational_json([(0.1 * k, 0.2, -0.1, 0, p) for k, p in enumerate(each)])
        self.write("most.json", powers(100, 100, 50))
        self.write("more.json", powers(100, 100, 51))
        # Roots and poles that nearly cancel, and others that do not.
        for name, apart in (("pairs", 0.02), ("apart", 0.3)):
            self.write(f"{name}.json", harness.rational_json([(0.1 * k, 0.2, -0.1, 0, 100) for k in range(3)],
                                                             [(0.1 * k, 0.2, -0.1 - apart, 0, 100) for k in range(3)]))
        # In fractal space a voxel of this ball is half as large.
        part = ("s.obj", "--box=0.6,-0.03,-0.03,1.1,0.03,0.03", "--voxel-size")
        for arithmetic, options in (("float", ("s.obj", "--iterations", 10)), ("double", ("s.obj", "--iterations", 11)),
                                    ("float", ("s.obj", "--texture", "most.json")),
                                    ("double", ("s.obj", "--texture", "more.json")),
                                    ("float", ("s.obj", "--texture", "pairs.json")),
                                    ("double", ("s.obj", "--texture", "apart.json")),
                                    ("float", (*part, 0.0021)), ("double", (*part, 0.0019)),
                                    ("double", ("--map", "mandelbulb")), ("double", ("--map", "cross")),
                                    ("double", ("--map", "quadratic", "--mandelbrot")),
                                    ("double", ("s.obj", "--precision", "double")),
                                    ("float", ("s.obj", "--precision", "float", "--iterations", 6))):
            with self.subTest(options=options):
                size = () if options[:3] == part else LOW[:2]
                mesh = self.fractal(*options, *size, *(LOW[2:] if options[0] == "s.obj" else ()))
                self.assertEqual(mesh.comments["julia_arithmetic"], arithmetic)

    # Promise of design.md: "Where floats would move a vertex by more than 1/1000 of a voxel, a PLY has doubles", and a GLB floats
    #   about its middle
    def test_far_away_the_file_keeps_the_detail(self):
        """Floats would move vertices by a share of a voxel there: the PLY has doubles."""
        voxel = 2 / 28
        self.write("far.obj", harness.obj(harness.moved(harness.sphere(3), 1.0, (2**21 * voxel, 0, 0))))
        mesh = self.fractal("far.obj", *LOW)
        self.assertTrue(mesh.doubles)
        self.check_closed(mesh)
        self.assertFalse(self.fractal("s.obj", *LOW).doubles)

    # Promise of precision.md#what-it-says: Floats and doubles give the same set but for a few vertices
    def test_float_and_double_agree(self):
        double, single = (self.fractal("s.obj", *LOW, "--precision", p) for p in ("double", "float"))
        near = abs(len(double.points) - len(single.points)) / len(double.points)
        self.assertLess(near, 0.01)
        self.assertAlmostEqual(harness.volume_of(single) / harness.volume_of(double), 1, delta=1e-3)
        places = {tuple(round(c * 200) for c in p) for p in double.points}
        around = [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]
        found = sum(any(tuple(round(c * 200) + d for c, d in zip(p, step)) in places for step in around)
                    for p in single.points)
        self.assertGreater(found / len(single.points), 0.99)

    # Promise: "`--exhaustive`, which evaluates every ..."
    # Promise: "E may be clamped to the interval ..."
    def test_the_shell_decides_what_it_says(self):
        """An exhaustive run evaluates every node and finds the same surface."""
        shell, every = (self.fractal("t.obj", *LOW, *more) for more in ((), ("--exhaustive",)))
        self.assertTrue(sorted(shell.points) == sorted(every.points), "the vertices differ")
        self.assertEqual(len(shell.faces), len(every.faces))


class Ways(Laws):

    # Promise of design.md#meshes: PLY, OBJ and STL of a fractal hold the same triangles
    def test_formats_hold_the_same_triangles(self):
        job = ("fractal", "s.obj", *LOW, "--mesh")
        for name in ("m.ply", "m.obj", "m.stl"):
            self.ok(*job, name)
        ply, obj = harness.read_ply(self.bytes("m.ply")), harness.read_obj(self.bytes("m.obj"))
        self.assertTrue(ply.faces == obj.faces, "the triangles differ")
        # The OBJ has the doubles, the others have floats of them.
        for p, q in zip(ply.points, obj.points):
            for x, y in zip(p, q):
                self.assertAlmostEqual(x, y, delta=2**-24 * max(1, abs(y)))
        self.assertTrue(harness.triangles_of(ply) == harness.read_stl(self.bytes("m.stl")), "the triangles differ")
        self.assertEqual(len(obj.normals), len(obj.points))
        for name in ("m.ply", "m.obj", "m.stl"):
            info = self.info(name)
            self.assertTrue(info["closed"], name)
            self.assertEqual((info["points"], info["triangles"]), (len(ply.points), len(ply.faces)), name)

    # Promise of design.md: `mesh` makes the mesh of a fractal's VDB again, "whose vertices lie on the true surface"
    def test_mesh_of_a_fractal_is_its_mesh(self):
        self.ok("fractal", "t.obj", *LOW, "--alpha", 25, "-o", "t.vdb", "--mesh", "one.ply")
        self.ok("mesh", "t.vdb", "-o", "two.ply")
        self.assertTrue(self.bytes("one.ply") == self.bytes("two.ply"))

    # Promise of targets.md#what-is-accepted: A mesh gives the same fractal from OBJ, PLY, STL and OFF; a VDB with a signed
    #   distance serves as well
    def test_targets_of_every_format(self):
        """A mesh that floats hold exactly gives the same fractal from every format that can hold it."""
        mesh = harness.cube()
        results = []
        for name, content in (("c.obj", harness.obj(mesh)), ("c.ply", harness.ply(mesh)), ("c.stl", harness.stl(mesh)),
                              ("c.off", harness.off(mesh)), ("text.ply", harness.ply_text(mesh))):
            self.write(name, content)
            results.append(self.fractal(name, *LOW).points)
        for other in results[1:]:
            self.assertTrue(results[0] == other, "the vertices differ")

    # Promise: A mesh gives the same fractal ...
    def test_an_sdf_is_as_good_as_its_mesh(self):
        self.ok("sdf", "t.obj", "-o", "sdf.vdb", "--resolution", 40)
        one = self.fractal("t.obj", "--resolution", 28, "--sdf-resolution", 40)
        two = self.fractal("sdf.vdb", "--resolution", 28)
        self.check_closed(two)
        # The band that was swept outward differs from true distances by a share of a voxel of the distance field.
        self.assertAlmostEqual(harness.volume_of(two) / harness.volume_of(one), 1, delta=0.05)

    def test_the_bunny(self):
        if not harness.BUNNY.exists():
            self.skipTest(f"{harness.BUNNY} is not here (glmark2-data)")
        mesh = self.fractal(harness.BUNNY, *LOW, "--alpha", 300)
        self.check_closed(mesh)
        self.ok("sdf", harness.BUNNY, "-o", "b.vdb", "--resolution", 40)
        self.assertEqual(self.info("b.vdb")["grids"][0]["level set check"], "passes")
        ours, target = map(harness.volume_of, (mesh, harness.read_obj(harness.BUNNY.read_bytes())))
        self.assertAlmostEqual(ours, target, delta=0.15 * ours)


if __name__ == "__main__":
    harness.main()

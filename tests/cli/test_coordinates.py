# SPDX-License-Identifier: Apache-2.0
"""Shapes that are small, large, or far from the origin: a file holds them exactly enough or is refused, and the units of
a shape decide nothing. Text files may begin with a byte order mark."""

import json
import math
import re
import struct

import harness

LOW = ("--resolution", 28, "--sdf-resolution", 28)
VOXEL = 2 / 28


def read_glb(data):
    """@return the node's translation, and triangles of points as they stand in the file"""
    length = struct.unpack_from("<I", data, 12)[0]
    tree, body = json.loads(data[20:20 + length]), data[28 + length:]
    primitive = tree["meshes"][0]["primitives"][0]
    positions = tree["accessors"][primitive["attributes"]["POSITION"]]
    indices = tree["accessors"][primitive["indices"]]
    stride = tree["bufferViews"][0]["byteStride"]
    points = [struct.unpack_from("<3f", body, i * stride) for i in range(positions["count"])]
    start = tree["bufferViews"][1]["byteOffset"] + indices.get("byteOffset", 0)
    faces = [struct.unpack_from("<3I", body, start + 12 * i) for i in range(indices["count"] // 3)]
    translation = tree["nodes"][0].get("translation", [0, 0, 0])
    return translation, [tuple(points[k] for k in f) for f in faces]


def is_flat(triangle):
    a, b, c = triangle
    u, v = [y - x for x, y in zip(a, b)], [y - x for x, y in zip(a, c)]
    return u[1] * v[2] == u[2] * v[1] and u[2] * v[0] == u[0] * v[2] and u[0] * v[1] == u[1] * v[0]


def as_single(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


class Far(harness.CliTest):
    """What lies far from the origin is written as it is, or not at all."""

    # Between the powers of ten are those at which a file changes from floats to something else.
    OFFSETS = (0.0, 10.0, 100.0, 300.0, 700.0, 1100.0, 1300.0, 1e4, 1e5, 1e6, 1e7)

    def write_far(self, offset):
        self.write("far.obj", harness.obj(harness.moved(harness.sphere(3), 1.0, (offset, -offset, offset))))

    def check_file(self, name, exact=None):
        """No triangle of the file is without area. @return its triangles in world space"""
        data = self.bytes(name)
        if name.endswith(".glb"):
            translation, triangles = read_glb(data)
            self.assertEqual(translation, [as_single(x) for x in translation], "readers hold a node's place as floats")
        elif name.endswith(".stl"):
            translation, triangles = (0, 0, 0), harness.read_stl(data)
        else:
            mesh = (harness.read_ply if name.endswith(".ply") else harness.read_obj)(data)
            self.assertEqual(len(set(mesh.points)), len(mesh.points), "vertices became one")
            translation, triangles = (0, 0, 0), harness.triangles_of(mesh)
        self.assertGreater(len(triangles), 0)
        self.assertEqual(sum(map(is_flat, triangles)), 0, "triangles without area")
        return [tuple(tuple(x + y for x, y in zip(p, translation)) for p in t) for t in triangles]

    def check_near(self, triangles, exact):
        """The same triangles in the same order, moved by a thousandth of a voxel at most."""
        self.assertEqual(len(triangles), len(exact))
        for one, other in zip(triangles, exact):
            for p, q in zip(one, other):
                for x, y in zip(p, q):
                    self.assertLessEqual(abs(x - y), 1.01e-3 * VOXEL)

    def check_closed_soup(self, triangles):
        uses = set()
        for t in triangles:
            for i in range(3):
                edge = (t[i], t[(i + 1) % 3])
                self.assertNotIn(edge, uses)
                uses.add(edge)
        self.assertTrue(all((b, a) in uses for a, b in uses), "an open edge")

    # Promise of design.md: STL: "Beyond 1/1000 it is refused, as its triangles would lose their area", and short of that no
    #   triangle without an area is written, in any format
    def test_fractals(self):
        refused = 0
        for offset in self.OFFSETS:
            self.write_far(offset)
            self.ok("fractal", "far.obj", *LOW, "--mesh", "exact.obj")
            exact = self.check_file("exact.obj")
            for extension in ("ply", "glb", "stl"):
                with self.subTest(offset=offset, extension=extension):
                    job = ("fractal", "far.obj", *LOW, "--mesh", f"f{offset:.0f}.{extension}")
                    if extension == "stl" and 1e-3 * VOXEL < (offset + 1.5) * 2**-24:
                        self.refused(harness.USAGE, *job, mentions=("STL", ".ply", ".obj"))
                        refused += 1
                        continue
                    self.ok(*job)
                    triangles = self.check_file(job[-1])
                    if extension == "stl":
                        self.check_closed_soup(triangles)
                    else:
                        self.check_near(triangles, exact)
        self.assertGreater(refused, 0)

    # Promise: STL: "Beyond 1/1000 it is refused, as its triangles ..."
    def test_other_ways_to_a_mesh(self):
        """From voxels, with few triangles, in levels of detail, from tiles, to print, and for USD."""
        self.write_far(1e6)
        self.ok("sdf", "far.obj", "-o", "far.vdb", "--resolution", 28)
        for extension in ("ply", "obj", "glb"):
            self.ok("mesh", "far.vdb", "--from-grid", "-o", "v." + extension)
            self.check_file("v." + extension)
        self.refused(harness.USAGE, "mesh", "far.vdb", "--from-grid", "-o", "v.stl", mentions="STL")
        for extension in ("ply", "glb"):
            self.ok("fractal", "far.obj", *LOW, "--adaptivity", 0.1, "--mesh", "a." + extension)
            self.check_file("a." + extension)
        self.ok("fractal", "far.obj", *LOW, "--lod", "100%,50%,20%", "--mesh", "l.glb")
        self.check_file("l.glb")
        self.ok("print", "far.obj", "--size", 50, "-o", "p.stl")
        self.check_file("p.stl")
        self.refused(harness.USAGE, "plan", "tiles", "far.obj", *LOW, "-o", "stl", "--tiles", 3, "--make", "stl",
                     mentions="STL")
        self.ok("plan", "tiles", "far.obj", *LOW, "-o", "plan", "--tiles", 3, "--make", "ply")
        for number in (1, 2, 3):
            self.ok("task", "plan", "--index", number)
        self.ok("merge", "plan", "--mesh", "t.ply")
        self.ok("fractal", "far.obj", *LOW, "--mesh", "whole.ply")
        self.check_file("t.ply")
        self.assertEqual(set(harness.read_ply(self.bytes("t.ply")).points),
                         set(harness.read_ply(self.bytes("whole.ply")).points))
        self.refused(harness.USAGE, "merge", "plan", "--mesh", "t.stl", mentions=("STL", ".obj"))
        # Tiles that have all digits for a PLY have them for other formats too.
        self.ok("merge", "plan", "--mesh", "t.obj")
        self.ok("fractal", "far.obj", *LOW, "--mesh", "whole.obj")
        self.assertEqual(self.bytes("t.obj"), self.bytes("whole.obj"))

    # Promise: STL: "Beyond 1/1000 it is refused, as its triangles ..."
    # Promise: USD: a `Volume` "refers to the VDB ..."
    def test_usd(self):
        for offset in (0.0, 10.0, 300.0, 1e3, 1e7):
            with self.subTest(offset=offset):
                self.write_far(offset)
                self.ok("fractal", "far.obj", *LOW, "--mesh", "u.obj")
                self.ok("usd", "--mesh", "u.obj", "-o", f"u{offset:.0f}.usda")
                text = self.bytes(f"u{offset:.0f}.usda").decode()
                line = text.split("point3f[] points = [")[1].split("]")[0]
                numbers = [float(x) for x in line.replace("(", "").replace(")", "").split(",")]
                points = list(zip(*[iter(numbers)] * 3))
                self.assertEqual(len(set(points)), len(points), "vertices became one")


class Units(harness.CliTest):
    """A shape in other units is the same shape. Powers of two scale floats and doubles exactly, so nothing may differ. Below
    voxels of 1.44e-5, the lattice of the distances may lie elsewhere, but not if the shape's middle is at the origin, or so
    many leaves of the lattice away from it."""

    SMALL = (2.0**-33, 2.0**-20, 2.0**-13)
    FACTORS = (2.0**-7, 2.0**10, 2.0**20)

    def setUp(self):
        super().setUp()
        self.use(harness.lumpy())

    def use(self, shape):
        self.shape = shape
        self.write("one.obj", harness.obj(self.shape))

    def write_scaled(self, factor):
        self.write("scaled.obj", harness.obj(harness.moved(self.shape, factor, (0, 0, 0))))

    def points(self, *arguments):
        self.ok(*arguments, "out.obj")
        mesh = harness.read_obj(self.bytes("out.obj"))
        self.assertGreater(len(mesh.points), 100)
        return mesh

    def check_scaled(self, plain, scaled, factor):
        self.assertEqual(scaled.faces, plain.faces)
        self.assertEqual(scaled.normals, plain.normals)
        self.assertEqual([tuple(x / factor for x in p) for p in scaled.points], plain.points)

    def check_exact(self, factors, options):
        plain = self.points("fractal", "one.obj", *options, "--mesh")
        for factor in factors:
            with self.subTest(options=options, factor=factor):
                self.write_scaled(factor)
                self.check_scaled(plain, self.points("fractal", "scaled.obj", *options, "--mesh"), factor)

    def check_jobs(self, *job):
        options = (*job, "--sdf-resolution", 28)
        self.check_exact(self.FACTORS, options)
        # Where the lattice lies elsewhere, it lies elsewhere in the same way.
        small = None
        for factor in self.SMALL[:2]:
            with self.subTest(factor=factor):
                self.write_scaled(factor)
                mesh = self.points("fractal", "scaled.obj", *options, "--mesh")
                self.assertEqual(len(harness.open_edges(mesh)), 0)
                back = mesh._replace(points=[tuple(x / factor for x in p) for p in mesh.points])
                self.assertEqual(back, small or back)
                small = back
        # A side of 2 has 32 voxels, and these are 2, 4 and 6 leaves.
        points, faces = harness.sphere(3)
        lumps = [tuple(c * (1 - 0.9 * p[0] * p[1] * p[2]) for c in p) for p in points]
        for axis in range(3):
            coordinates = [p[axis] for p in lumps]
            self.assertEqual((min(coordinates), max(coordinates)), (-1, 1))
        self.use(harness.moved((lumps, faces), 1.0, (1, -2, 3)))
        self.check_exact(self.SMALL, (*job, "--sdf-resolution", 32))

    # Promise of targets.md: Targets "in units of any size", at any place: small voxels, deep zooms, and "A prop of 2 mm in metres
    #   gives meshes like any other"
    # Promise of design.md: "a target that is scaled by a power of two has the same mesh, scaled, to the bit"
    def test_about_the_origin(self):
        self.use(harness.sphere(3))
        for options in (LOW, (*LOW, "--detail", 0.4, "--texture", "random"), (*LOW, "--repair")):
            self.check_exact(self.SMALL + self.FACTORS, options)

    # Promise: Targets "in units of any ..."
    # Promise: "a target that is scaled ..."
    def test_whole(self):
        self.check_jobs("--resolution", 28)

    # Promise: Targets "in units of any ..."
    # Promise: "a target that is scaled ..."
    def test_rough(self):
        self.check_jobs("--resolution", 28, "--alpha", 15, "--texture", "random", "--largest", 1)

    # Promise: "a target that is scaled ..."
    def test_adaptive(self):
        self.check_jobs("--resolution", 28, "--adaptivity", 0.2)

    # Promise: "a target that is scaled ..."
    def test_follow(self):
        self.check_jobs("--resolution", 60, "--follow")

    # Promise: "a target that is scaled ..."
    def test_repair_and_detail(self):
        self.check_jobs("--resolution", 28, "--repair", "--detail", "0.5")

    # Promise: Targets "in units of any ..."
    # Promise: "a target that is scaled ..."
    def test_zoom(self):
        self.use(harness.sphere(3))
        box = (0.5, -0.2, -0.2, 1.3, 0.2, 0.2)
        def zoomed(name, factor):
            text = ",".join(repr(factor * x) for x in box)
            return self.points("fractal", name, "--sdf-resolution", 28, f"--box={text}", "--voxel-size",
                               repr(factor / 64), "--mesh")

        plain = zoomed("one.obj", 1.0)
        for factor in self.SMALL + self.FACTORS:
            with self.subTest(factor=factor):
                self.write_scaled(factor)
                self.check_scaled(plain, zoomed("scaled.obj", factor), factor)

    # Promise: Targets "in units of any ..."
    def test_deep_zooms(self):
        """A box of a few voxels about a point of the surface, ever smaller: the surface goes through it."""
        mesh = self.points("fractal", "one.obj", *LOW, "--precision", "double", "--tolerance", 1e-9, "--mesh")
        at = mesh.points[len(mesh.points) // 2]
        self.ok("fractal", "one.obj", *LOW, "--precision", "double", "--tolerance", 1e-9, "--attributes", "depth", "--mesh",
                "whole.ply")
        whole = harness.read_ply(self.bytes("whole.ply"))
        depth = min((math.dist(point, at), d) for point, d in zip(whole.points, whole.columns["depth"]))[1]
        for size in (1e-3, 1e-5, 1e-7, 1e-9, 1e-10):
            with self.subTest(size=size):
                box = ",".join(repr(c + side * size) for side in (-1, 1) for c in at)
                job = ("fractal", "one.obj", "--sdf-resolution", 28, f"--box={box}", "--voxel-size", repr(size / 16))
                zoomed = self.points(*job, "--mesh")
                for point in zoomed.points:
                    self.assertLessEqual(max(abs(x - c) for x, c in zip(point, at)), 1.1 * size)
                self.assertEqual(len(set(zoomed.points)), len(zoomed.points))
                # Attributes are those of the place, wherever the lattice has its origin.
                self.ok(*job, "--attributes", "depth", "--mesh", "deep.ply")
                deep = harness.read_ply(self.bytes("deep.ply"))
                self.assertEqual(deep.points, zoomed.points)
                for value in deep.columns["depth"]:
                    self.assertAlmostEqual(value, depth, delta=4 * size + 1e-6)
        self.refused(harness.USAGE, "plan", "tiles", *job[1:], "--tiles", 2, "--make", "ply", "-o", "plan", mentions="one run")
        self.write("far.obj", harness.obj(harness.moved(self.shape, 1, (1000, 0, 0))))
        box = ",".join(repr(c + 1000 * (axis == 0) + side * size) for side in (-1, 1) for axis, c in enumerate(at))
        self.refused(harness.USAGE, "fractal", "far.obj", *job[2:4], f"--box={box}", *job[5:], "--mesh", "none.ply",
                     mentions="use voxels of at least 1.001e-09")

    # Promise: Targets "in units of any ..."
    def test_level_sets(self):
        """Distances of VDBs scale too, as far down as other programs can read VDBs."""
        self.ok("sdf", "one.obj", "-o", "one.vdb", "--resolution", 28)
        plain = self.points("mesh", "one.vdb", "-o")
        voxel = max(p[0] for p in self.shape[0]) / 14  # or less
        for factor in (2.0**-12, 2.0**-5, 2.0**20):
            with self.subTest(factor=factor):
                self.write_scaled(factor)
                self.ok("sdf", "scaled.obj", "-o", "scaled.vdb", "--resolution", 28)
                scaled = self.points("mesh", "scaled.vdb", "-o")
                self.assertEqual(scaled.faces, plain.faces)
                # Their vertices are searched for between the nodes, up to a millionth of a voxel.
                for p, q in zip(plain.points, scaled.points):
                    self.assertLess(math.dist(p, [x / factor for x in q]), 1e-5 * voxel)

    # Promise: Targets "in units of any ..."
    def test_a_print(self):
        """What is printed has its size in millimetres, whatever the units of the file."""
        job = ("--size", 40, "--resolution", 60, "--min-thickness", 1, "--flat-base", 0.5, "-o", "p.stl")
        self.ok("print", "one.obj", *job)
        plain = self.bytes("p.stl")
        for factor in self.SMALL + self.FACTORS:
            with self.subTest(factor=factor):
                self.write_scaled(factor)
                self.ok("print", "scaled.obj", *job)
                self.assertEqual(self.bytes("p.stl"), plain)

    # Promise: Targets "in units of any ..."
    # Promise of targets.md: "a VDB cannot have voxels below 1.45e-5, and is refused", with the option and the voxel that are
    #   meant
    def test_a_prop_in_metres(self):
        """Two millimetres: a mesh is made, and a VDB, which cannot have such voxels, is refused before any work."""
        self.write("prop.obj", harness.obj(harness.moved(self.shape, 0.001, (0, 0, 0))))
        self.ok("fractal", "prop.obj", "--resolution", 200, "--sdf-resolution", 28, "--mesh", "prop.ply")
        for job in (("fractal", "prop.obj"), ("sdf", "prop.obj")):
            text = self.refused(harness.USAGE, *job, "--resolution", 200, "-o", "prop.vdb", mentions="1.45e-05")
            self.assertIn("--voxel-size", text)
        self.refused(harness.USAGE, "plan", "tiles", "prop.obj", "--resolution", 200, "-o", "plan", "--tiles", 2,
                     "--make", "vdb", mentions="1.45e-05")
        self.ok("fractal", "prop.obj", "--voxel-size", "1.45e-05", "--sdf-resolution", 28, "-o", "prop.vdb")
        # Points choose no voxels; what would help is another format.
        self.write("speck.obj", harness.obj(harness.moved(self.shape, 1e-6, (0, 0, 0))))
        text = self.refused(harness.USAGE, "points", "speck.obj", "--points", 20, "-o", "p.vdb", mentions="1.45e-05")
        self.assertIn("write a .ply", text)
        for option in re.findall(r"--[a-z-]+", text):
            self.assertIn(f"{option} ", self.ok("points", "--help", "all", data=True))
        self.ok("points", "speck.obj", "--points", 20, "-o", "p.ply")

    # Promise: Targets "in units of any ..."
    def test_tiles_of_a_small_shape(self):
        self.write_scaled(2.0**-20)
        self.ok("plan", "tiles", "scaled.obj", *LOW, "-o", "plan", "--tiles", 2, "--make", "ply")
        for number in (1, 2):
            self.ok("task", "plan", "--index", number)
        self.ok("merge", "plan", "--mesh", "merged.ply")
        self.ok("fractal", "scaled.obj", *LOW, "--mesh", "whole.ply")
        merged, whole = (harness.read_ply(self.bytes(name)) for name in ("merged.ply", "whole.ply"))
        self.assertEqual(set(merged.points), set(whole.points))
        self.assertEqual(len(merged.faces), len(whole.faces))


class ByteOrderMarks(harness.CliTest):
    """A text that begins with the mark of UTF-8 is the same text."""

    MARK = b"\xef\xbb\xbf"

    def both(self, name, content, *job, out):
        """What the job makes of the file with and without a mark."""
        made = []
        for mark in (b"", self.MARK):
            self.write(name, mark + (content.encode() if isinstance(content, str) else content))
            self.ok(*job, out)
            made.append(self.bytes(out))
        return made

    # Promise of design.md: "A byte order mark at the beginning of a text file is passed over"
    def test_meshes(self):
        sphere = harness.sphere(2)
        points, faces = sphere
        # Were the first vertex lost, the others would still be enough for all faces.
        spare = points + [(0.0, 0.0, 5.0)], [tuple(k + 1 for k in f) for f in faces]
        spare = [(0.3, 0.2, 0.1)] + points + [(0.0, 0.0, 0.9)], spare[1]
        solid = "solid s\n" + "".join(
            "facet normal 0 0 0\nouter loop\n" + "".join("vertex {!r} {!r} {!r}\n".format(*points[k]) for k in f) +
            "endloop\nendfacet\n" for f in faces) + "endsolid s\n"
        for name, content in (("m.obj", harness.obj(spare)), ("m.off", harness.off(sphere)),
                              ("m.ply", harness.ply_text(sphere)), ("m.stl", solid), ("m.ply", harness.ply(sphere))):
            with self.subTest(name=name):
                plain, marked = self.both(name, content, "fractal", name, *LOW, "--mesh", out="out.stl")
                self.assertEqual(marked, plain)

    # Promise: "A byte order mark at the beginning ..."
    def test_gltf(self):
        points, faces = harness.sphere(2)
        body = b"".join(struct.pack("<3f", *p) for p in points) + b"".join(struct.pack("<3I", *f) for f in faces)
        self.write("m.bin", body)
        size = 12 * len(points)
        tree = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
                "buffers": [{"uri": "m.bin", "byteLength": len(body)}],
                "bufferViews": [{"buffer": 0, "byteLength": size},
                                {"buffer": 0, "byteOffset": size, "byteLength": len(body) - size}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
                              {"bufferView": 1, "componentType": 5125, "count": 3 * len(faces), "type": "SCALAR"}]}
        plain, marked = self.both("m.gltf", json.dumps(tree), "fractal", "m.gltf", *LOW, "--mesh", out="out.stl")
        self.assertEqual(marked, plain)

    # Promise: "A byte order mark at the beginning ..."
    def test_a_binary_stl_may_begin_with_any_bytes(self):
        sphere = harness.sphere(2)
        content = harness.stl(sphere)
        self.write("m.stl", content)
        self.ok("fractal", "m.stl", *LOW, "--mesh", "plain.stl")
        self.write("m.stl", self.MARK + content[3:])
        self.ok("fractal", "m.stl", *LOW, "--mesh", "marked.stl")
        self.assertEqual(self.bytes("marked.stl"), self.bytes("plain.stl"))

    # Promise: "A byte order mark at the beginning ..."
    def test_lists_of_options(self):
        self.write("s.obj", harness.obj(harness.sphere(2)))
        plain, marked = self.both("list.txt", "alpha = 20\nresolution = 28\n", "fractal", "s.obj", "--config",
                                  "list.txt", "--sdf-resolution", 28, "--mesh", out="out.stl")
        self.assertEqual(marked, plain)

    # Promise: "A byte order mark at the beginning ..."
    def test_recipes_in_meshes(self):
        """An OBJ that was opened and saved by an editor still has its recipe."""
        self.write("s.obj", harness.obj(harness.sphere(2)))
        self.ok("fractal", "s.obj", *LOW, "--alpha", 20, "--mesh", "made.obj")
        made = self.bytes("made.obj")
        for name in ("plain.obj", "marked.obj"):
            self.write(name, (self.MARK if name == "marked.obj" else b"") + made)
        self.assertEqual(self.info("marked.obj")["recipe"], self.info("plain.obj")["recipe"])
        self.assertEqual(self.info("marked.obj")["recipe"]["alpha"], "20")

    # Promise: "A byte order mark at the beginning ..."
    def test_maps(self):
        self.write("s.obj", harness.obj(harness.sphere(2)))
        plain, marked = self.both("v.json", harness.rational_json(harness.ROOTS), "fractal", "s.obj", *LOW,
                                  "--texture", "v.json", "--mesh", out="out.stl")
        self.assertEqual(marked, plain)


if __name__ == "__main__":
    harness.main()

# SPDX-License-Identifier: Apache-2.0
"""The Python module gives what the command gives, takes and returns arrays, and fails in the same words."""
import ast
import gc
import hashlib
import inspect
import os
import pathlib
import re
import subprocess
import sys
import threading
import unittest
import warnings

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))

import harness

try:
    import juliavdb
    import numpy as np
except ImportError as error:
    print(f"skipped: {error}")
    juliavdb = None

SMALL = {"sdf_resolution": 30, "resolution": 30}
SMALL_WORDS = ("--sdf-resolution", 30, "--resolution", 30)


def arrays(mesh):
    points, triangles = mesh[:2]
    return np.array(points, dtype=np.float64), np.array(triangles)


def in_python(message):
    """What the command says, with the options' names as Python has them."""
    return re.sub(r"--([a-z][a-z-]*)", lambda found: found[1].replace("-", "_"), message)


@unittest.skipUnless(juliavdb, "the Python module was not built, or there is no numpy")
class ModuleTest(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.mesh = harness.torus()
        self.write("torus.obj", harness.obj(self.mesh))
        self.torus = str(self.path("torus.obj"))


class NothingIsLost(ModuleTest):

    # Promise of python.md: `ValueError` where "`write` would replace a file that was read"
    # Promise: "No output replaces an input", through ...
    def test_what_was_read_is_not_replaced(self):
        self.write("v.json", harness.rational_json(harness.ROOTS))
        made = juliavdb.fractal(self.torus, texture=str(self.path("v.json")), **SMALL)
        fitted = juliavdb.fit(self.torus, resolution=24, triangles=400, roots=8)
        for victim, suffix in (("torus.obj", ".obj"), ("v.json", ".ply")):
            before = self.bytes(victim)
            os.link(self.path(victim), self.path("hard" + suffix))
            os.symlink(victim, self.path("soft" + suffix))
            outputs = ["hard" + suffix, "soft" + suffix] + ([victim] if victim.endswith(suffix) else [])
            for output in outputs:
                with self.subTest(output=output):
                    with self.assertRaisesRegex(ValueError, f"{output}.*{victim}"):
                        made.write(self.path("new.vdb"), self.path(output))
                    self.assertEqual(self.bytes(victim), before)
        os.link(self.path("torus.obj"), self.path("map.json"))
        with self.assertRaisesRegex(ValueError, "map.json.*torus.obj"):
            fitted.write(self.path("map.json"))
        self.assertFalse(self.path("new.vdb").exists())
        self.assertEqual([name for name in self.listing() if name.endswith(".tmp")], [])

    # Promise: `ValueError` where "`write` would ..."
    def test_two_outputs_are_two_files(self):
        made = juliavdb.fractal(*arrays(self.mesh), **SMALL)
        with self.assertRaisesRegex(ValueError, "a.ply"):
            made.write(self.path("a.ply"), self.path("../" + self.folder.name + "/a.ply"))
        made.write(self.path("a.ply"))
        made.write(self.path("a.ply"), self.path("a.vdb"))


class LikeTheCommand(ModuleTest):

    # Promise of python.md: "The files have the same bytes as those of the command with the same options"
    def test_files_have_the_bytes_of_the_commands(self):
        cases = [
            (dict(detail=0.4, texture="quills"), ("--detail", "0.4", "--texture", "quills")),
            (dict(alpha=40, beta=0.02, origin_shift=(0.1, 0, 0)), ("--alpha", 40, "--beta", "0.02", "--origin-shift", "0.1,0,0")),
            (dict(min_size=np.int64(1), half=True, cap=False), ("--min-size", 1, "--half")),
            (dict(grids="surface,versor"), ("--grids", "surface,versor")),
            (dict(grids=["density"], tolerance=np.float64(0.01)), ("--grids", "density", "--tolerance", "0.01")),
        ]
        for options, words in cases:
            with self.subTest(options=options):
                made = juliavdb.fractal(self.torus, **SMALL, **options)
                made.write(self.path("a.vdb"), str(self.path("a.ply")), self.path("a.obj"))
                made.write(self.path("a.stl"))
                # The recipe in a mesh may hold options of a VDB, if there is one beside it.
                for extension in ("ply", "obj", "stl"):
                    self.ok("fractal", self.torus, "-o", "b.vdb", "--mesh", f"b.{extension}", *SMALL_WORDS, *words)
                for extension in ("vdb", "ply", "obj", "stl"):
                    self.assertEqual(self.bytes(f"a.{extension}"), self.bytes(f"b.{extension}"), extension)

    # Promise: "the program says how many, as do tasks ..."
    def test_values_that_halves_cannot_hold_are_told(self):
        points, faces = arrays(self.mesh)
        for size, expected in ((1, 0), (1e6, 1)):
            made = juliavdb.fractal(size * points, faces, **SMALL, half=True)
            made.write(self.path("a.ply"))
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always")
                made.write(self.path("a.vdb"))
            self.assertEqual([one.category for one in told], expected * [RuntimeWarning])
        self.assertRegex(str(told[0].message), r"^\d+ values of the grid surface are beyond what 16 bits hold")

    def test_grids_in_other_formats(self):
        made = juliavdb.fractal(self.torus, **SMALL, grids="surface,density")
        grid = juliavdb.Grid(np.arange(24.0).reshape(2, 3, 4), 0.5, name="surface")
        try:
            made.write(self.path("a.nvdb"), self.path("a.vdb"), self.path("b.vdb"))
        except ValueError as refusal:
            self.assertRegex(str(refusal), "cannot write NanoVDB.*built")
            self.skipTest("NanoVDB is not built in")
        self.ok("fractal", self.torus, "-o", "c.nvdb", *SMALL_WORDS, "--grids", "surface,density")
        self.assertEqual(self.bytes("a.nvdb"), self.bytes("c.nvdb"))
        self.assertEqual(self.bytes("a.vdb"), self.bytes("b.vdb"))
        for name in ("g.vdb", "g.nvdb"):
            grid.write(self.path(name))
        self.ok("convert", "g.vdb", "-o", "h.nvdb")
        self.assertEqual(self.bytes("g.nvdb"), self.bytes("h.nvdb"))
        with self.assertRaisesRegex(ValueError, r"g\.ply.*\.vdb or \.nvdb"):
            grid.write(self.path("g.ply"))

    # Promise: "What was made before changes ..."
    def test_a_fractal_does_not_depend_on_those_before_it(self):
        small = {"sdf_resolution": 60, "resolution": 20}
        points, faces = harness.snowman()
        snowman = np.array(points), np.array(faces)
        at = np.linspace(-0.9, 0.9, 600).reshape(200, 3)
        made = {}
        for order in ((0.1, 0.3, 0.5), (0.5, 0.1, 0.3)):
            for detail in order:
                juliavdb.fractal(*snowman, **small, detail=detail).write(self.path("a.ply"))
                values = juliavdb.Field(*snowman, **small, detail=detail)(at).tobytes()
                this = self.bytes("a.ply"), values
                self.assertTrue(made.setdefault(detail, this) == this, detail)
        self.assertEqual(len({values for _, values in made.values()}), 3)

    # Promise: Arrays "are the memory of the result, not ..."
    def test_attributes_are_those_of_the_file(self):
        made = juliavdb.fractal(self.torus, **SMALL, attributes=["depth", "direction"], colour="trap:magma")
        self.ok("fractal", self.torus, *SMALL_WORDS, "--attributes", "depth,direction", "--colour", "trap:magma",
                "--mesh", "b.ply", "-o", "b.vdb")
        made.write(self.path("a.ply"), self.path("a.vdb"))
        for extension in ("ply", "vdb"):
            self.assertEqual(self.bytes(f"a.{extension}"), self.bytes(f"b.{extension}"), extension)
        attributes = made.attributes
        self.assertEqual(list(attributes), ["Cd", "depth", "direction"])
        count = len(made.vertices)
        self.assertEqual([array.shape for array in attributes.values()], [(count, 3), (count,), (count, 3)])
        self.assertEqual({array.dtype for array in attributes.values()}, {np.dtype(np.float32)})
        data = self.bytes("b.ply")
        vertex = np.dtype([("place", "<f4", 6), ("Cd", "u1", 3), ("depth", "<f4"), ("direction", "<f4", 3)])
        rows = np.frombuffer(data, vertex, count, data.index(b"end_header\n") + 11)
        self.assertTrue(np.array_equal(rows["depth"], attributes["depth"]))
        self.assertTrue(np.array_equal(rows["direction"], attributes["direction"]))
        linear = attributes["Cd"].astype(float)
        codes = 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
        self.assertLess(np.abs(codes - rows["Cd"]).max(), 0.51)
        depth = attributes.pop("depth")
        del made, attributes
        gc.collect()
        self.assertTrue(np.array_equal(rows["depth"], depth))
        with self.assertRaises(ValueError):
            depth[0] = 1
        self.assertEqual(juliavdb.fractal(self.torus, **SMALL).attributes, {})

    def test_maps_without_a_target(self):
        made = juliavdb.fractal(map="quadratic", c=(-0.2, 0.6, 0.2, 0.2), iterations=8, resolution=30)
        made.write(self.path("a.ply"))
        self.ok("fractal", "--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", "--iterations", 8, "--resolution", 30,
                "--mesh", "b.ply")
        self.assertEqual(self.bytes("a.ply"), self.bytes("b.ply"))

    # Promise: "The files have the same bytes as those ..."
    def test_a_fit_is_the_commands(self):
        options, words = dict(roots=12, resolution=24), ("--roots", 12, "--resolution", 24)
        fitted = juliavdb.fit(self.torus, **options)
        fitted.write(self.path("a.json"))
        self.ok("fit", self.torus, "-o", "b.json", *words)
        self.assertEqual(self.bytes("a.json"), self.bytes("b.json"))
        points, triangles = arrays(self.mesh)
        juliavdb.fit(points, triangles, **options).write(self.path("c.json"))
        self.assertEqual(self.bytes("c.json"), self.bytes("b.json"))
        self.assertTrue(0 < fitted.info["iou"] <= 1)
        self.assertLessEqual(fitted.info["top_roots"] + fitted.info["bottom_roots"], 12)
        juliavdb.fractal(map="rational", rational=self.path("a.json"), resolution=20)
        with self.assertRaisesRegex(ValueError, "no target was given"):
            juliavdb.fit()
        with self.assertRaisesRegex(ValueError, r"\.json or \.o3d"):
            fitted.write("a.vdb")

    # Promise of python.md: Python: "the pictures have the same pixels as those of the command", in any light
    # Promise of python.md#pictures: A picture has the pixels of the command's
    def test_pictures_have_the_pixels_of_the_commands(self):
        picture = juliavdb.render(self.torus, sdf_resolution=30, size=(40, 24), samples=1, colour="clay")
        self.ok("render", "--field", self.torus, "--sdf-resolution", 30, "--size", "40x24", "--samples", 1, "--colour",
                "clay", "-o", "p.png")
        self.assertEqual((picture.shape, picture.dtype), ((24, 40, 3), np.uint8))
        self.assertEqual(picture.tobytes(), pixels(self.bytes("p.png")))
        field = juliavdb.Field(self.torus, sdf_resolution=30)
        again = field.render(size="40x24", samples=1, colour="clay")
        self.assertTrue(np.array_equal(picture, again))

    # Promise: Python: "the pictures have ..."
    def test_pictures_have_the_look_of_the_commands(self):
        field = juliavdb.Field(self.torus, sdf_resolution=30)
        seen = {field.render(size=(40, 24), samples=1).tobytes()}
        looks = [dict(material="gold"), dict(material=(0.2, 0.4, 0.8)), dict(light=(60, 20)), dict(sky=0.3), dict(ground=True),
                 dict(exposure=1.5), dict(background="#203040"),
                 dict(material="jade", light=(60, 20), sky=0.3, ground=True, exposure=-0.5, background=(0.1, 0.2, 0.3))]
        for look in looks:
            words = [word for name, value in look.items() for word in (
                [f"--{name}"] if value is True else [f"--{name}", ",".join(map(str, value)) if isinstance(value, tuple) else value])]
            self.ok("render", "--field", self.torus, "--sdf-resolution", 30, "--size", "40x24", "--samples", 1, *words, "-o", "p.png")
            picture = field.render(size=(40, 24), samples=1, **look)
            self.assertEqual(picture.tobytes(), pixels(self.bytes("p.png")), look)
            seen.add(picture.tobytes())
        self.assertEqual(len(seen), len(looks) + 1)
        one = juliavdb.render(self.torus, sdf_resolution=30, size=(40, 24), samples=1, **looks[-1])
        self.assertTrue(np.array_equal(one, picture))
        for wrong in (dict(material="mud"), dict(light=3), dict(background="none"), dict(exposure=99), dict(ground=True, light=(0, -5))):
            for make in (field.render, lambda **look: juliavdb.render(self.torus, sdf_resolution=30, **look)):
                with self.assertRaises(ValueError) as raised:
                    make(**wrong)
                self.assertIn(next(reversed(wrong)), str(raised.exception))
                self.assertNotIn("--", str(raised.exception))

    # Promise of python.md: The exceptions, and that they "say the same as the program's"
    # Promise of python.md: Messages "call options by their names in Python"
    def test_errors_have_the_words_of_the_command(self):
        self.write("open.obj", harness.obj(harness.with_hole(harness.sphere())))
        self.write("text.obj", "hello")
        open_mesh, text = str(self.path("open.obj")), str(self.path("text.obj"))
        gone = str(self.path("gone.obj"))
        cases = [
            (ValueError, self.torus, dict(detail=7), ("--detail", 7)),
            (ValueError, self.torus, dict(texture="fethers"), ("--texture", "fethers")),
            (ValueError, self.torus, dict(resolution=10, voxel_size=0.1), ("--resolution", 10, "--voxel-size", 0.1)),
            (ValueError, self.torus, dict(map="mandel"), ("--map", "mandel")),
            (ValueError, None, dict(), ()),
            (juliavdb.DataError, open_mesh, dict(), ()),
            (juliavdb.DataError, text, dict(), ()),
            (juliavdb.DataError, self.torus, dict(box=(5, 5, 5, 6, 6, 6), **SMALL), ("--box", "5,5,5,6,6,6", *SMALL_WORDS)),
            (FileNotFoundError, gone, dict(), ()),
        ]
        for kind, target, options, words in cases:
            with self.subTest(target=target, options=options):
                with self.assertRaises(kind) as caught:
                    juliavdb.fractal(target, **options)
                self.assertIs(type(caught.exception), kind)
                run = self.run_program(*harness.quiet(("fractal", *([target] if target else []), *words, "--mesh", "f.ply")))
                self.assertNotEqual(run.returncode, 0)
                self.assertEqual(f"juliavdb: {caught.exception}\n", in_python(said(run)))
        self.assertTrue(issubclass(juliavdb.DataError, ValueError))

    # Promise: The exceptions, and that they ...
    def test_what_cannot_be_written(self):
        made = juliavdb.fractal(map="mandelbulb", resolution=20)
        with self.assertRaisesRegex(ValueError, r"f\.abc.*\.vdb or .*\.ply, "):
            made.write("f.abc")
        with self.assertRaises(OSError) as caught:
            made.write(self.path("here.ply"), self.path("no/such/folder.ply"))
        self.assertNotIsInstance(caught.exception, FileNotFoundError)
        run = self.run_program(*harness.quiet(("fractal", "--map", "mandelbulb", "--resolution", 20,
                                               "--mesh", self.path("no/such/folder.ply"))))
        self.assertEqual(f"juliavdb: {caught.exception}\n", said(run))
        self.assertEqual(self.listing(), ["torus.obj"])


def said(run):
    return run.stderr.decode()


def pixels(data):
    """The bytes of a PNG's pixels, row by row."""
    return np.array(harness.read_png(data), dtype=np.uint8).tobytes()


class Arrays(ModuleTest):

    # Promise of python.md#a-fractal: A target of arrays is as good as a file; its recipe has the name and the SHA-256 that the
    #   page says
    def test_a_mesh_in_memory_is_as_good_as_a_file(self):
        points, triangles = arrays(self.mesh)
        of_file = juliavdb.fractal(self.torus, **SMALL, detail=0.4)
        # The file has rounded decimals; the arrays have to hold the same numbers.
        points = np.array([line.split()[1:4] for line in self.path("torus.obj").read_text().splitlines()
                           if line.startswith("v ")], dtype=np.float64)
        for vertices, faces in ((points, triangles), (points.tolist(), triangles.tolist()),
                                (np.asfortranarray(points), triangles.astype(np.uint16)),
                                (np.repeat(points, 2, axis=0)[::2], triangles.astype(np.int32))):
            made = juliavdb.fractal(vertices, faces, **SMALL, detail=0.4)
            self.assertTrue(np.array_equal(made.vertices, of_file.vertices))
            self.assertTrue(np.array_equal(made.faces, of_file.faces))
            self.assertTrue(np.array_equal(made.normals, of_file.normals))
        self.assertEqual(made.info["recipe"]["input"], "memory")
        # The program has no such arrays.
        made.write(self.path("arrays.vdb"))
        run = self.run_program("fractal", "--config", self.path("arrays.vdb"), "-o", self.path("again.vdb"))
        self.assertEqual(run.returncode, harness.NO_INPUT)
        self.assertIn("'memory'", said(run))
        data = points.astype("<f8").tobytes() + triangles.astype("<u4").tobytes()
        self.assertEqual(made.info["metadata"]["julia_source_sha256"], hashlib.sha256(data).hexdigest())
        juliavdb.fractal(points, triangles, **SMALL, source_sha256=hashlib.sha256(data).hexdigest())
        with self.assertRaisesRegex(juliavdb.DataError, "not the one"):
            juliavdb.fractal(points + 1, triangles, **SMALL, source_sha256=hashlib.sha256(data).hexdigest())

    # Promise: A target of arrays is as good ...
    def test_floats_are_the_doubles_of_the_same_value(self):
        points, triangles = arrays(self.mesh)
        single = points.astype(np.float32)
        a, b = (juliavdb.fractal(each, triangles, **SMALL) for each in (single, single.astype(np.float64)))
        self.assertTrue(np.array_equal(a.vertices, b.vertices))

    # Promise of python.md: Arrays "are the memory of the result, not copies of it, and stay valid after the result is gone. They
    #   cannot be written to"
    def test_the_arrays_are_the_memory_of_the_result(self):
        made = juliavdb.fractal(self.torus, **SMALL)
        kinds = {"vertices": np.float64, "faces": np.uint32, "normals": np.float32}
        for name, kind in kinds.items():
            array = getattr(made, name)
            self.assertEqual(array.dtype, kind)
            self.assertTrue(np.shares_memory(array, getattr(made, name)), name)
            self.assertFalse(array.flags.owndata)
            with self.assertRaises(ValueError):
                array[0, 0] = 0
        vertices, copy = made.vertices, made.vertices.copy()
        del made
        gc.collect()
        ballast = [np.random.default_rng(i).random(copy.shape) for i in range(8)]
        self.assertTrue(np.array_equal(vertices, copy))
        del ballast

    # Promise: "The files have the same bytes as those ..."
    def test_the_mesh_is_the_one_that_is_written(self):
        made = juliavdb.fractal(self.torus, **SMALL)
        made.write(self.path("f.obj"))
        points, triangles = harness.read_obj(self.bytes("f.obj"))[:2]
        self.assertTrue(np.array_equal(np.array(points), made.vertices))
        self.assertTrue(np.array_equal(np.array(triangles), made.faces))
        edges = np.sort(made.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        self.assertTrue((np.unique(edges, axis=0, return_counts=True)[1] == 2).all(), "it is closed")
        corners = made.vertices[made.faces]
        volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
        self.assertAlmostEqual(volume, made.info["volume"], delta=1e-9)
        self.assertEqual(made.info["vertices"], len(made.vertices))
        self.assertEqual(made.info["triangles"], len(made.faces))
        self.assertEqual(made.info["recipe"]["resolution"], "30")

    def test_volumes_are_targets(self):
        self.ok("fractal", self.torus, "-o", "smoke.vdb", "--grids", "density", *SMALL_WORDS)
        smoke = str(self.path("smoke.vdb"))
        self.assertEqual(juliavdb.sdf(smoke).metadata["julia_chosen_iso"], "0.5")
        self.assertEqual(juliavdb.fractal(smoke, resolution=30).info["recipe"]["input"], smoke)
        self.ok("sdf", smoke, "--iso", 0.25, "-o", "said.vdb")
        made, said = juliavdb.sdf(smoke, iso=0.25).array(), juliavdb.Grid.read(self.path("said.vdb")).array()
        self.assertTrue(np.array_equal(made[0], said[0]))
        self.assertEqual(made[1], said[1])
        with self.assertRaisesRegex(ValueError, "no end.*invert"):
            juliavdb.sdf(smoke, iso=0.25, invert=True)

    # Promise: A target of arrays is as good ...
    def test_arrays_that_are_no_mesh(self):
        points, triangles = arrays(self.mesh)
        broken = points.copy()
        broken[3, 1] = np.nan
        cases = [
            (points[:, :2], triangles, r"vertices .* \(n, 3\); it is \(\d+, 2\)"),
            (points, triangles.reshape(-1), r"faces .* \(n, 3\)"),
            (points, triangles.astype(float), "whole numbers"),
            (points, triangles + 1, "there are"),
            (points, triangles - 1, "uses vertex -1"),
            (points, triangles[:0], "no triangle"),
            (broken, triangles, "point 3 .* not finite"),
            (points + 1j, triangles, "real numbers"),
            (points * 0, triangles, "no extent"),
            (points, None, "both, or, .* points_radius"),
            (None, triangles, "both"),
            (self.torus, triangles, "faces were given"),
        ]
        for vertices, faces, words in cases:
            with self.subTest(words=words), self.assertRaisesRegex(ValueError, words):
                juliavdb.fractal(vertices, faces, **SMALL)
        with self.assertRaisesRegex(ValueError, "twice"):
            juliavdb.fractal(points, triangles, input=self.torus)
        with self.assertRaisesRegex(TypeError, "detail"):
            juliavdb.fractal(points, triangles, detail={})
        with self.assertRaisesRegex(ValueError, "^feathers is not an option of this function; help"):
            juliavdb.fractal(points, triangles, feathers=1)
        with self.assertRaisesRegex(ValueError, "did you mean 'sdf_resolution'"):
            juliavdb.fractal(points, triangles, sdf_resolutoin=20)

    def test_points_at_rest_are_an_array(self):
        """A torus that is turned and moved has the fractal of the torus at rest."""
        points, triangles = arrays(self.mesh)
        turned = points[:, [1, 2, 0]] + np.array([3, 0, 1])
        moved = juliavdb.fractal(turned, triangles, rest=points, **SMALL)
        still = juliavdb.fractal(points, triangles, **SMALL)
        at_rest = np.sort((moved.vertices - np.array([3, 0, 1]))[:, 2])
        self.assertEqual(moved.info["recipe"]["rest"], "memory")
        self.assertLess(abs(len(moved.vertices) - len(still.vertices)), 0.1 * len(still.vertices))
        self.assertLess(np.abs(np.quantile(at_rest, [0.1, 0.5, 0.9]) - np.quantile(still.vertices[:, 0], [0.1, 0.5, 0.9])).max(), 0.03)
        field = juliavdb.Field(turned, triangles, rest=points, **SMALL)
        places = still.vertices[:200] * 0.9
        expected = juliavdb.Field(points, triangles, **SMALL)(places) < 0
        found = field(places[:, [1, 2, 0]] + np.array([3, 0, 1])) < 0
        self.assertGreater((expected == found).mean(), 0.98)
        with self.assertRaisesRegex(ValueError, "both as arrays"):
            juliavdb.fractal(self.torus, rest=points, **SMALL)
        with self.assertRaisesRegex(ValueError, "uses vertex"):
            juliavdb.fractal(turned, triangles, rest=points[:-1], **SMALL)

    # Promise: Messages "call options by their ..."
    def test_points_need_no_faces(self):
        points, triangles = arrays(self.mesh)
        alone = juliavdb.fractal(points, points_radius=0.3, **SMALL)
        empty = juliavdb.fractal(points, triangles[:0], points_radius=0.3, **SMALL)
        self.assertTrue(np.array_equal(alone.vertices, empty.vertices))
        self.assertLess(juliavdb.Field(points, points_radius=0.3, **SMALL)(points[:1])[0], 0)


class Memory(ModuleTest):

    # Promise of python.md: "Work that is known to need more memory than the machine, the control group and `ulimit` leave is
    #   refused before it begins": a `MemoryError`; `memory` sets another limit "for a call and for all that is made of its
    #   result"
    def test_what_cannot_fit_is_refused_at_once(self):
        """As the command refuses it, before the work: the callback hears of no surface."""
        phases = []
        for options in (dict(resolution=20000, sdf_resolution=60), dict(resolution=20000, sdf_resolution=60, detail=0.5)):
            with self.subTest(options=options):
                with self.assertRaisesRegex(MemoryError, r"would take at least .* of memory, but the limit that was set "
                                                         r"leaves .*; use a lower resolution .*; memory sets another"):
                    juliavdb.fractal(self.torus, memory="2G", **options,
                                     progress=lambda phase, share: phases.append(phase))
        self.assertNotIn("surface", phases)

    # Promise: "Work that is known to need ..."
    def test_a_limit_holds_for_all_that_is_made(self):
        made = juliavdb.fractal(self.torus, **SMALL, memory="unlimited")
        self.assertTrue(np.array_equal(made.vertices, juliavdb.fractal(self.torus, **SMALL).vertices))
        with self.assertRaisesRegex(MemoryError, "the limit that was set"):
            juliavdb.render(self.torus, sdf_resolution=30, size=(30000, 30000), memory="1G")
        field = juliavdb.Field(self.torus, **SMALL, memory="1G")
        with self.assertRaisesRegex(MemoryError, "use a smaller size"):
            field.render(size=(30000, 30000))

    # Promise: "Work that is known to need ..."
    def test_a_limit_that_is_none(self):
        for limit in ("many", "16", "-1G", ""):
            with self.subTest(limit=limit), self.assertRaisesRegex(ValueError, "^memory is '.*such as 16G, or unlimited"):
                juliavdb.fractal(self.torus, **SMALL, memory=limit)


class Threads(ModuleTest):

    def test_every_call_takes_threads_and_they_change_nothing(self):
        """A device of the call is the same in this: "cpu" is there on every machine."""
        calls = {
            "fractal": lambda **more: juliavdb.fractal(self.torus, **SMALL, **more).vertices,
            "render": lambda **more: juliavdb.render(self.torus, sdf_resolution=30, size=(20, 20), **more),
            "slice": lambda **more: juliavdb.slice(self.torus, field="f", size=20, **SMALL, **more),
            "study": lambda **more: juliavdb.study(self.torus, versors=3, size=20, **SMALL, **more)["inside"],
            "dimension": lambda **more: juliavdb.dimension(self.torus, sdf_resolution=30, resolutions=(20, 24, 28), **more)["triangles"],
            "Field": lambda **more: juliavdb.Field(self.torus, **SMALL, **more)([[0.1, 0.2, 0.3]]),
            "sdf": lambda **more: juliavdb.sdf(self.torus, resolution=20, **more).array()[0],
            "fit": lambda **more: juliavdb.fit(self.torus, roots=8, resolution=16, **more).info["psi"],
        }
        for name, call in calls.items():
            with self.subTest(call=name):
                usual = call()
                for more in ({"threads": 1}, {"threads": 3}) + (({"device": "cpu", "threads": 2},) if name not in ("sdf", "fit") else ()):
                    self.assertTrue(np.array_equal(call(**more), usual), more)
                with self.assertRaisesRegex(ValueError, "threads is 0; it must be 1 or more, or None"):
                    call(threads=0)
                if name not in ("sdf", "fit"):
                    with self.assertRaisesRegex((ValueError, RuntimeError), "^device is 'gpu'"):
                        call(device="gpu")
        made = juliavdb.fractal(self.torus, **SMALL)
        made.write(self.path("one.vdb"), threads=1)
        made.write(self.path("all.vdb"))
        self.assertEqual(self.bytes("one.vdb"), self.bytes("all.vdb"))

    def test_a_call_takes_no_more_threads(self):
        """Of a texture that is a function: as it is called in the threads that work."""
        seen = set()

        def texture(points):
            seen.add(threading.get_ident())
            return points + (3, 1, 2)

        juliavdb.fractal(self.torus, texture=texture, threads=1, **SMALL)
        self.assertLessEqual(len(seen), 2, "one thread for the scene, one for the surface")


class FieldTest(ModuleTest):

    # Promise of python.md: A `Field` evaluates F "at any point, as often as you like"
    def test_a_quadratic_map_by_hand(self):
        c, steps = np.array([-0.2, 0.6, 0.2, 0.2]), 6
        field = juliavdb.Field(map="quadratic", c=c, iterations=steps, resolution=20, precision="double")
        points = np.random.default_rng(1).uniform(-1.3, 1.3, (5000, 3))
        values = field(points)
        radius = float(field.metadata["julia_escape"])
        q = np.concatenate([points, np.zeros((len(points), 1))], axis=1)
        with np.errstate(over="ignore", invalid="ignore"):
            for _ in range(steps):
                a, v = q[:, :1], q[:, 1:]
                q = np.concatenate([a * a - (v * v).sum(1, keepdims=True), 2 * a * v], axis=1) + c
                q = np.where(np.isfinite(q), q, 1e100)
            stays = np.linalg.norm(np.clip(q, -1e100, 1e100), axis=1) < radius
        self.assertTrue(0.02 < stays.mean() < 0.98)
        self.assertTrue(np.array_equal(field.inside(points), stays))
        self.assertTrue(np.array_equal(values < 0, stays))
        low, high = np.array(field.bounds)
        self.assertTrue(((points[stays] >= low) & (points[stays] <= high)).all())

    # Promise: A `Field` evaluates F "at any ..."
    def test_a_point_has_its_value_in_any_company(self):
        field = juliavdb.Field(self.torus, sdf_resolution=30)
        points = np.random.default_rng(2).uniform(-1, 1, (5001, 3))
        values = field(points)
        self.assertEqual((values.shape, values.dtype), ((5001,), np.float64))
        order = np.random.default_rng(3).permutation(len(points))
        self.assertTrue(np.array_equal(field(points[order]), values[order]))
        self.assertTrue(np.array_equal(field(points[7:8]), values[7:8]))
        self.assertEqual(field(np.empty((0, 3))).shape, (0,))
        for bad in (points[:, :2], [[0, 0, np.inf]]):
            with self.assertRaises(ValueError):
                field(bad)

    # Promise: A `Field` evaluates F "at any ..."
    def test_the_surface_lies_where_the_sign_changes(self):
        options = dict(sdf_resolution=40, resolution=40, detail=0.3, frequency="coarse")
        made, field = juliavdb.fractal(self.torus, **options), juliavdb.Field(self.torus, **options)
        step = 0.05 * made.info["voxel_size"] * made.normals.astype(float)
        inside = field.inside(made.vertices - step).mean()
        outside = 1 - field.inside(made.vertices + step).mean()
        self.assertGreater(inside, 0.9)
        self.assertGreater(outside, 0.9)


class Versors(ModuleTest):
    """Versors that are functions of Python."""

    OPTIONS = {"space": "world", "alpha": 10, "precision": "double", **SMALL}

    @staticmethod
    def swirl(points):
        x, y, z = points.T
        return np.column_stack([0.3 + y, z - 0.1, x + 0.2])

    # Promise of python.md#a-versor-of-your-own: A versor that is a function of Python: what it raises, shapes, the recipe
    def test_a_function_is_the_formula_of_the_same(self):
        asked = []

        def function(points):
            asked.append((points.shape[1:], points.dtype))
            return self.swirl(points)

        for options in ({}, {"texture_over": "rings"}, {"texture_symmetry": "mirror:x"}):
            with self.subTest(options=options):
                own = juliavdb.fractal(self.torus, texture=function, **options, **self.OPTIONS)
                formula = juliavdb.fractal(self.torus, texture="expr:0.3+y, z-0.1, x+0.2", **options, **self.OPTIONS)
                self.assertTrue(np.array_equal(own.vertices, formula.vertices))
        self.assertEqual(set(asked), {((3,), np.dtype("float64"))})
        four = juliavdb.fractal(self.torus, texture=lambda p: np.column_stack([self.swirl(p), p[:, 0]]), **self.OPTIONS)
        formula = juliavdb.fractal(self.torus, texture="expr:0.3+y, z-0.1, x+0.2, x", **self.OPTIONS)
        self.assertTrue(np.array_equal(four.vertices, formula.vertices))
        over = juliavdb.fractal(self.torus, texture="rings", texture_over=self.swirl, texture_mix=1, **self.OPTIONS)
        under = juliavdb.fractal(self.torus, texture=self.swirl, **self.OPTIONS)
        self.assertTrue(np.array_equal(over.vertices, under.vertices))

    def test_points_are_those_of_the_target(self):
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        large = 1000 * np.array(self.mesh[0]) + (5000, 0, 0)

        def function(points):
            nonlocal low, high
            near = points[np.abs(points - (5000, 0, 0)).max(axis=1) < 1500]
            if len(near):
                low, high = np.minimum(low, near.min(axis=0)), np.maximum(high, near.max(axis=0))
            return self.swirl(points)

        made = juliavdb.fractal(large, np.array(self.mesh[1]), texture=function, **SMALL)
        self.assertTrue((low < made.vertices.min(axis=0) + 100).all() and (high > made.vertices.max(axis=0) - 100).all())

    def test_fields_and_pictures_ask_it_too(self):
        field = juliavdb.Field(self.torus, texture=self.swirl, **self.OPTIONS)
        same = juliavdb.Field(self.torus, texture="expr:0.3+y, z-0.1, x+0.2", **self.OPTIONS)
        points = np.random.default_rng(1).uniform(*field.bounds, (2000, 3))
        self.assertTrue(np.array_equal(field(points), same(points)))
        alone = np.array([field(point[None])[0] for point in points[:20]])
        self.assertTrue(np.array_equal(alone, field(points)[:20]))
        self.assertTrue(np.array_equal(field.render(size=(40, 40), samples=1), same.render(size=(40, 40), samples=1)))

    # Promise: A versor that is a function ...
    def test_a_function_needs_no_numpy_of_its_own(self):
        """Many threads ask it at once, and the first of them must not have to load numpy."""
        self.write("t.obj", harness.obj(self.mesh))
        script = """
import juliavdb
def constant(points):
    return [[0.3, 0.4, 0.5]] * len(points)
for threads in (8, 1):
    print(len(juliavdb.fractal("t.obj", resolution=24, sdf_resolution=24, texture=constant, threads=threads).vertices))
"""
        for _ in range(3):
            run = subprocess.run([sys.executable, "-c", script], cwd=self.folder, capture_output=True, text=True, timeout=120)
            self.assertEqual(run.stderr, "")
            self.assertEqual(len(set(run.stdout.split())), 1, run.stdout)

    # Promise: A versor that is a function ...
    def test_what_a_function_raises_the_call_raises(self):
        class Mine(Exception):
            pass

        def raising(points):
            raise Mine("of my own")

        for _ in range(3):
            with self.assertRaisesRegex(Mine, "of my own"):
                juliavdb.fractal(self.torus, texture=raising, **SMALL)
        field = juliavdb.Field(self.torus, texture=self.swirl, **SMALL)
        del field
        gc.collect()
        with self.assertRaises(KeyboardInterrupt):
            juliavdb.fractal(self.torus, texture=self.swirl, progress=lambda phase, share: False, **SMALL)

    # Promise: A versor that is a function ...
    def test_what_is_no_direction(self):
        nan = float("nan")
        for name, function, words in (("shape", lambda p: p[:, :2], ("(n, 3) or (n, 4)",)),
                                      ("rows", lambda p: p[1:], ("(n, 3) or (n, 4)",)),
                                      ("flat", lambda p: p.ravel(), ("(n, 3) or (n, 4)",)),
                                      ("text", lambda p: "x", ("real numbers", "shape")),
                                      ("none", lambda p: None, ("real numbers", "shape")),
                                      ("complex", lambda p: p * 1j, ("real numbers",)),
                                      ("nan", lambda p: p * (1, nan, 1), ("nan", "at the point (")),
                                      ("infinite", lambda p: p / 0.0, ("inf", "nan"))):
            with self.subTest(name=name), np.errstate(all="ignore"):
                with self.assertRaises(ValueError) as raised:
                    juliavdb.fractal(self.torus, texture=function, **SMALL)
                self.assertTrue(any(word in str(raised.exception) for word in words), raised.exception)
        def swirling(points, starts=None):
            return points[1:]

        with self.assertRaisesRegex(ValueError, "^the function swirling of texture was given"):
            juliavdb.fractal(self.torus, texture=swirling, **SMALL)
        with self.assertRaisesRegex(ValueError, "^the function swirling of map"):
            juliavdb.fractal(map=swirling, box="-1,-1,-1,1,1,1", resolution=8)
        with self.assertRaisesRegex(ValueError, "both functions"):
            juliavdb.fractal(self.torus, texture=self.swirl, texture_over=self.swirl, **SMALL)
        # Of length 0 is the versor 1.
        zero = juliavdb.fractal(self.torus, texture=lambda p: 0 * p, **SMALL)
        one = juliavdb.fractal(self.torus, texture="expr:1,0,0,0", **SMALL)
        self.assertTrue(np.array_equal(zero.vertices, one.vertices))

    # Promise: A versor that is a function ...
    def test_a_recipe_cannot_hold_a_function(self):
        made = juliavdb.fractal(self.torus, texture=self.swirl, **SMALL)
        made.write(self.path("own.vdb"))
        self.assertEqual(made.info["recipe"]["texture"], "function")
        self.refused(harness.BAD_DATA, "fractal", "--config", "own.vdb", "-o", "x.vdb", mentions="Python")
        with self.assertRaisesRegex(ValueError, "function of a Python program"):
            juliavdb.fractal(self.torus, texture="function", **SMALL)

    # Promise: "A set over a target that has the symmetry has it too"
    def test_symmetry_leaves_the_set_as_it_is(self):
        """Over a cube about 0, whose distances have the symmetry too."""
        self.write("cube.obj", harness.obj(harness.cube()))
        turn = {axis: np.roll(np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]), (axis, axis), (0, 1)) for axis in range(3)}
        mirror = [np.diag([-1 if i == axis else 1 for i in range(3)]) for axis in range(3)]
        points = np.random.default_rng(2).uniform(-1.2, 1.2, (20000, 3))
        for symmetry, images in (("mirror:x", [mirror[0]]), ("mirror:xz", [mirror[0], mirror[2]]), ("2:y", [turn[1] @ turn[1]]),
                                 ("4:z", [turn[2]]), ("4:x:mirror", [turn[0], mirror[1], mirror[2]])):
            for versor in ("woven", "coral", "rings", "expr:sin(9*x),y+0.1,cos(8*z)"):
                with self.subTest(symmetry=symmetry, versor=versor):
                    options = {"precision": "double", "detail": 0.5, **SMALL}
                    field = juliavdb.Field(str(self.path("cube.obj")), texture=versor, texture_symmetry=symmetry, **options)
                    plain = juliavdb.Field(str(self.path("cube.obj")), texture=versor, **options)
                    for image in images:
                        same = (field.inside(points) == field.inside(points @ image.T)).mean()
                        self.assertGreater(same, 0.999)
                        if versor == "coral":
                            self.assertLess((plain.inside(points) == plain.inside(points @ image.T)).mean(), 0.99)


class Devices(ModuleTest):

    def tearDown(self):
        juliavdb.use_device("cpu")
        super().tearDown()

    def test_choices(self):
        self.assertEqual(juliavdb.use_device("cpu"), "")
        for choice in ("gpu", "opencl:", "opencl:9999"):
            with self.subTest(choice=choice):
                self.assertRaises((ValueError, RuntimeError), juliavdb.use_device, choice)

    # Promise: "The files have the same bytes with every choice"
    @unittest.skipUnless(harness.has_opencl(), "no device of OpenCL is installed")
    def test_a_device_gives_the_same_mesh(self):
        self.assertEqual(juliavdb.devices()[0]["refusal"], "")
        here = juliavdb.fractal(map="mandelbulb", resolution=24)
        self.assertIn("device 0", juliavdb.use_device("opencl"))
        there = juliavdb.fractal(map="mandelbulb", resolution=24)
        self.assertTrue((here.vertices == there.vertices).all() and (here.faces == there.faces).all())


class Words(ModuleTest):

    def test_objects_say_what_they_are(self):
        """In one line, with the name of their class and that of their target."""
        arrays_ = [np.array(each) for each in self.mesh[:2]]
        objects = {"Fractal": juliavdb.fractal, "Field": juliavdb.Field,
                   "Fit": lambda *target, **_: juliavdb.fit(*target, roots=8, resolution=16)}
        for name, make in objects.items():
            self.assertRegex(repr(make(self.torus, **SMALL)), rf"\A<juliavdb\.{name} of '.*torus\.obj'.*>\Z")
            self.assertRegex(repr(make(*arrays_, **SMALL)), rf"\A<juliavdb\.{name} of a mesh in memory.*>\Z")
        self.assertEqual(repr(juliavdb.Field(map="mandelbulb")), "<juliavdb.Field of the map mandelbulb>")
        made = juliavdb.fractal(self.torus, **SMALL)
        self.assertIn(f"{len(made.vertices)} vertices, {len(made.faces)} triangles", repr(made))
        self.assertEqual(repr(juliavdb.sdf(self.torus, voxel_size=0.25)), "<juliavdb.Grid 'phi' with a voxel size of 0.25>")

    def test_the_module_has_its_own_names_alone(self):
        public = {name for name in dir(juliavdb) if not name.startswith("_")}
        self.assertEqual(public, set(juliavdb.__all__) | {"fitting"})

    def test_stubs_and_docstrings_name_every_option(self):
        stub = pathlib.Path(juliavdb.__file__).with_suffix(".pyi").read_text()
        functions = {node.name: node for node in ast.walk(ast.parse(stub)) if isinstance(node, ast.FunctionDef)}
        helped = self.ok("fractal", "--help", "all", data=True)
        part = helped[helped.index("\nTarget:"):helped.index("\nCommon options:")]
        names = {line.split()[0][2:].replace("-", "_") for line in part.splitlines() if line.startswith("  --")}
        self.assertGreater(len(names), 40)
        found = {argument.arg for argument in functions["fractal"].args.kwonlyargs}
        self.assertEqual(found - {"progress", "memory", "threads", "device"}, names)
        for name in names:
            self.assertIn(f"\n    {name}=", inspect.getdoc(juliavdb.fractal))
            self.assertIn(name, inspect.signature(juliavdb.fractal).parameters)
        for name in juliavdb.__all__:
            self.assertRegex(stub, rf"(?m)^(class|def) {name}\b")
            self.assertTrue(inspect.getdoc(getattr(juliavdb, name)), name)
        self.assertEqual(juliavdb.__version__, os.environ.get("JULIAVDB_VERSION", juliavdb.__version__))


if __name__ == "__main__":
    if juliavdb:
        harness.main()
    else:
        unittest.main()

# SPDX-License-Identifier: Apache-2.0
"""The add-on in Blender without a window: what comes out, where it lies, progress, cancelling, errors, recipes.

Started by Python it starts itself again inside Blender: blender -b --factory-startup --python blender_test.py
"""

import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import types
import unittest
import unittest.mock

ROOT = pathlib.Path(__file__).resolve().parents[2]
ADDON = "juliavdb_addon"
# Small, but with detail.
RESOLUTION = 32


sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import in_blender   # noqa: E402

in_blender.ensure(__file__)

import bpy           # noqa: E402
import addon_utils   # noqa: E402
import numpy         # noqa: E402
from mathutils import Matrix, Vector   # noqa: E402
from mathutils.bvhtree import BVHTree   # noqa: E402

PROGRAM = os.path.abspath(os.environ["JULIAVDB"])
sys.path.insert(0, str(ROOT / "integrations/blender"))


def corners(thing):
    """The least and the greatest coordinates of an object in the world: of its vertices, or of its volume's box."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    evaluated = thing.evaluated_get(depsgraph)
    if thing.type == "MESH":
        points = [evaluated.matrix_world @ vertex.co for vertex in evaluated.data.vertices]
    else:
        points = [evaluated.matrix_world @ Vector(corner) for corner in evaluated.bound_box]
    points = numpy.array(points)
    return points.min(0), points.max(0)


def surface_of(volume, grid, threshold):
    """A mesh object of a grid of the volume, by Blender's own Volume to Mesh."""
    mesh = bpy.data.objects.new("surface", bpy.data.meshes.new("surface"))
    bpy.context.scene.collection.objects.link(mesh)
    modifier = mesh.modifiers.new("Volume to Mesh", "VOLUME_TO_MESH")
    modifier.object = volume
    modifier.grid_name = grid
    modifier.threshold = threshold
    return mesh


class Addon(unittest.TestCase):

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_test_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        bpy.ops.wm.read_factory_settings(use_empty=True)
        addon_utils.enable(ADDON, default_set=True)
        self.addon = sys.modules[ADDON]
        self.preferences().program = PROGRAM
        self.preferences().folder = str(self.folder / "volumes")

    def preferences(self):
        return bpy.context.preferences.addons[ADDON].preferences

    def source(self, **recipe):
        """A lopsided torus, turned, scaled and moved, so that no two axes and no two signs are alike."""
        bpy.ops.mesh.primitive_torus_add(major_segments=40, minor_segments=16, major_radius=1, minor_radius=0.4)
        torus = bpy.context.object
        for vertex in torus.data.vertices:
            vertex.co.x = 1.5 * vertex.co.x + 0.3
            vertex.co.z += 0.3 * vertex.co.y + 0.5
        torus.matrix_world = (Matrix.Translation((3, -2, 1)) @ Matrix.Rotation(0.7, 4, "Y") @ Matrix.Scale(2, 4))
        bpy.context.view_layer.update()
        torus.juliavdb.resolution = RESOLUTION
        torus.juliavdb.more = "--sdf-resolution 60"
        for name, value in recipe.items():
            setattr(torus.juliavdb, name, value)
        return torus

    def plain(self, **recipe):
        """Its fractal is the torus itself."""
        return self.source(more="--sdf-resolution 60 --mask 0", **recipe)

    def make(self):
        self.assertEqual(bpy.ops.juliavdb.make(), {"FINISHED"})
        return bpy.context.object

    def files(self):
        return sorted(str(path.relative_to(self.folder)) for path in self.folder.rglob("*") if path.is_file())

    def assert_same_box(self, first, second, tolerance):
        for one, other in zip(first, second):
            self.assertLess(numpy.abs(one - other).max(), tolerance, f"{first} and {second}")

    def voxel(self, source):
        """In the world."""
        size = [max(v.co[axis] for v in source.data.vertices) - min(v.co[axis] for v in source.data.vertices)
                for axis in range(3)]
        return 2 * max(size) / RESOLUTION

    # Promise of blender.md: The add-on: a fractal lies where its object lies, *Update* follows the settings, "*Cancel* stops it
    #   without a trace"
    def test_a_mesh_lies_where_its_source_lies(self):
        for up in "ZY":
            with self.subTest(up=up):
                source = self.plain(up=up)
                result = self.make()
                self.assertEqual(result.type, "MESH")
                self.assertEqual(result.parent, source)
                self.assertEqual((result.matrix_basis, result.matrix_parent_inverse), (Matrix(), Matrix()))
                self.assert_same_box(corners(source), corners(result), self.voxel(source))
                self.assertEqual(self.files(), [])
                # Every edge has two faces, and they look outward.
                sides = numpy.zeros(len(result.data.edges), int)
                for polygon in result.data.polygons:
                    self.assertEqual(polygon.loop_total, 3)
                for loop in result.data.loops:
                    sides[loop.edge_index] += 1
                self.assertTrue((sides == 2).all())
                points = numpy.array([vertex.co for vertex in result.data.vertices])
                a, b, c = (points[[polygon.vertices[i] for polygon in result.data.polygons]] for i in range(3))
                self.assertGreater((a * numpy.cross(b, c)).sum(), 0)
                self.assertFalse(result.data.validate())

    # Promise: The add-on: a fractal lies ...
    def test_a_volume_lies_where_its_source_lies(self):
        for up in "ZY":
            with self.subTest(up=up):
                source = self.plain(up=up, output="VOLUME")
                box = corners(source)
                result = self.make()
                self.assertEqual(result.type, "VOLUME")
                self.assertEqual(result.parent, source)
                self.assertEqual(sorted(grid.name for grid in result.data.grids), ["density", "surface"])
                self.assertEqual(result.data.grids[result.data.grids.active_index].name, "density")
                # The fog begins at the surface.
                for grid, threshold in (("surface", 0), ("density", 0.02)):
                    surface = surface_of(result, grid, threshold)
                    bpy.context.view_layer.update()
                    depsgraph = bpy.context.evaluated_depsgraph_get()
                    self.assertGreater(len(surface.evaluated_get(depsgraph).data.vertices), 100)
                    self.assert_same_box(box, corners(surface), self.voxel(source))

    def test_a_fractal_has_the_shape_of_its_source(self):
        source = self.source(detail=0.3)
        result = self.make()
        longest = max(corners(source)[1] - corners(source)[0])
        self.assert_same_box(corners(source), corners(result), 0.1 * longest)
        self.assertGreater(len(result.data.polygons), len(source.data.polygons))

    # Promise: "The mesh is the object's ..."
    def test_the_original_is_hidden_on_request(self):
        source = self.plain()
        self.make()
        self.assertTrue(source.hide_get() and source.hide_render)
        other = self.plain(hide_source=False)
        self.make()
        self.assertFalse(other.hide_get() or other.hide_render)

    # Promise of blender.md: "The mesh is the object's own, with its modifiers applied", "and the original is hidden unless *Hide
    #   Original* is off"
    def test_modifiers_count(self):
        source = self.plain()
        result = self.make()
        before = corners(result)
        modifier = source.modifiers.new("Array", "ARRAY")
        modifier.relative_offset_displace = (0, 0, 1.5)
        self.assertEqual(bpy.ops.juliavdb.update(), {"FINISHED"})
        self.assertTrue(source.hide_get(), "it was hidden before")
        self.assertGreater((corners(result)[1] - before[1]).max(), 1)

    # Promise: The add-on: a fractal lies ...
    def test_update_follows_the_settings(self):
        source = self.source()
        result = self.make()
        first = len(result.data.polygons)
        meshes = len(bpy.data.meshes)
        result.data.materials.append(bpy.data.materials.new("stone"))
        materials = [material.name for material in result.data.materials]
        result.location.x = 7
        result.juliavdb.detail = 0.6
        result.juliavdb.versor = "thorns"
        bpy.ops.juliavdb.update()
        self.assertNotEqual(len(result.data.polygons), first)
        self.assertEqual(len(bpy.data.meshes), meshes, "the old mesh is gone")
        self.assertIn("stone", materials)
        self.assertEqual([material.name for material in result.data.materials], materials)
        self.assertEqual(result.location.x, 7)
        self.assertIn("--texture=thorns", result["juliavdb_command"])
        self.assertEqual(source.juliavdb.versor, "scales", "a result has settings of its own")
        # From the source, its settings hold.
        source.hide_set(False)
        bpy.context.view_layer.objects.active = source
        bpy.ops.juliavdb.update()
        self.assertEqual(result.juliavdb.versor, "scales")
        self.assertEqual(len(result.data.polygons), first, "the same recipe gives the same mesh")

    # Promise: The recipe of a fractal is in the .blend ...
    def test_update_turns_a_mesh_into_a_volume(self):
        self.plain()
        result = self.make()
        name, parent = result.name, result.parent
        result.juliavdb.output = "VOLUME"
        bpy.ops.juliavdb.update()
        result = bpy.context.object
        self.assertEqual((result.name, result.parent, result.type), (name, parent, "VOLUME"))
        first = result.data.filepath
        result.juliavdb.detail = 0.4
        bpy.ops.juliavdb.update()
        self.assertNotEqual(result.data.filepath, first, "undo finds the file it had before")
        self.assertTrue(pathlib.Path(bpy.path.abspath(first)).exists())

    def paint(self, source, domain, kind):
        attribute = source.data.color_attributes.new("Painted", kind, domain)
        places = (range(len(source.data.vertices)) if domain == "POINT"
                  else [loop.vertex_index for loop in source.data.loops])
        for index, vertex in enumerate(places):
            grey = 1.0 if source.data.vertices[vertex].co.x > 0.3 else 0.0
            attribute.data[index].color = (grey, grey, grey, 1)
        source.data.color_attributes.active_color = attribute

    # Promise: The add-on: a fractal lies ...
    def test_paint_decides_where_the_detail_goes(self):
        for domain, kind in (("POINT", "FLOAT_COLOR"), ("CORNER", "BYTE_COLOR")):
            with self.subTest(domain=domain):
                source = self.source(hide_source=False, detail=0.8, outward=0.5, resolution=3 * RESOLUTION)
                self.paint(source, domain, kind)
                source.juliavdb.paint = "MASK"
                result = self.make()
                self.assertIn("--mask=paint:brightness", result["juliavdb_command"])

                def distances(sign):
                    """From the painted torus, for some vertices on one side of it, in voxels."""
                    return [3 * (source.closest_point_on_mesh(vertex.co)[1] - vertex.co).length / self.voxel(source)
                            for vertex in result.data.vertices[:][::8] if sign * (vertex.co.x - 0.3) > 0.3]
                self.assertLess(max(distances(-1)), 1, "black stays as it is")
                self.assertGreater(max(distances(1)), 2, "white does not")

    def test_paint_scales_the_detail(self):
        source = self.source(paint="DETAIL", detail=0.5, detail_black=0.02)
        self.paint(source, "POINT", "FLOAT_COLOR")
        self.assertIn("--detail=paint:brightness:0.02:0.5", self.make()["juliavdb_command"])

    def test_paint_without_colours_is_refused(self):
        self.source(paint="MASK")
        with self.assertRaisesRegex(RuntimeError, "has no colour attribute"):
            bpy.ops.juliavdb.make()

    def comb(self, source, name, domain, vector):
        attribute = source.data.attributes.new(name, "FLOAT_VECTOR", domain)
        places = (range(len(source.data.vertices)) if domain == "POINT"
                  else [loop.vertex_index for loop in source.data.loops])
        for index, vertex in enumerate(places):
            attribute.data[index].vector = vector(source.data.vertices[vertex].co)

    def test_a_grain_reaches_the_program(self):
        for grain in ("along", "around", "curvature", "down"):
            self.source(grain=grain, hide_source=False)
            command = self.make()["juliavdb_command"]
            self.assertIn(f"--grain={grain}", command)
            self.assertNotIn("--grain-turn", command)
        self.source(versor="rings", frequency=3, grain="along", grain_turn=math.radians(30), hide_source=False)
        command = self.make()["juliavdb_command"]
        self.assertIn("--grain-turn=30", command)
        self.assertIn("--frequency=3", command)
        self.source(versor="random", grain="along", hide_source=False)
        self.assertNotIn("--grain", self.make()["juliavdb_command"])

    def test_a_combed_attribute_is_followed(self):
        """Vectors are those of the object, whichever axis is up: one direction everywhere gives what that vector gives."""
        def fur(**recipe):
            return self.source(hide_source=False, resolution=48, versor="fur", **recipe)

        def points():
            return numpy.array([vertex.co for vertex in self.make().data.vertices])
        for up, vector in (("Z", "1,3,-2"), ("Y", "1,2,3")):   # the program's Y is Blender's Z, and its Z is -Y
            fur(up=up, more="--sdf-resolution 60 --grain " + vector)
            expected = points()
            for domain in ("POINT", "CORNER"):
                with self.subTest(up=up, domain=domain):
                    source = fur(up=up, grain="combed", grain_attribute="Comb")
                    self.comb(source, "Comb", domain, lambda _: (1, 2, 3))
                    found = points()
                    self.assertEqual(found.shape, expected.shape)
                    self.assertLess(numpy.abs(found - expected).max(), 1e-5)
        # Another comb is another fractal.
        source = fur(up="Y", grain="combed", grain_attribute="Comb")
        self.comb(source, "Comb", "POINT", lambda co: (-co.y, co.x, 0))
        other = points()
        self.assertTrue(other.shape != expected.shape or numpy.abs(other - expected).max() > 0.01)

    def test_a_grain_without_its_attribute_is_refused(self):
        source = self.source(grain="combed", grain_attribute="Comb")
        source.data.attributes.new("Wind", "FLOAT_VECTOR", "POINT")
        source.data.attributes.new("Comb", "FLOAT", "POINT")
        with self.assertRaisesRegex(RuntimeError, "no attribute 'Comb' of vectors.*it has Wind"):
            bpy.ops.juliavdb.make()

    # Promise of blender.md#to-make-a-fractal: "Every error is one line, the same as that of the program"
    def test_an_error_of_the_program_is_reported(self):
        bpy.ops.mesh.primitive_grid_add()   # an open mesh
        bpy.context.object.juliavdb.output = "VOLUME"
        before = set(bpy.data.objects)
        with self.assertRaisesRegex(RuntimeError, "--thicken") as caught:
            bpy.ops.juliavdb.make()
        self.assertEqual(len(str(caught.exception).strip().splitlines()), 1)
        self.assertEqual(set(bpy.data.objects), before)
        self.assertFalse((self.folder / "volumes").exists())
        # Also when nobody waits for it: the panel shows it.
        bpy.ops.juliavdb.make(wait=False)
        self.pump()
        message, failed = self.addon.make.said
        self.assertTrue(failed)
        self.assertIn("--thicken", message)

    # Promise: "Every error is one line, the same ..."
    def test_wrong_options_are_reported(self):
        self.source(more="--no-such-option 3")
        with self.assertRaisesRegex(RuntimeError, "no-such-option"):
            bpy.ops.juliavdb.make()
        bpy.context.object.juliavdb.more = "--iterations"
        with self.assertRaisesRegex(RuntimeError, "--iterations needs a value"):
            bpy.ops.juliavdb.make()
        bpy.context.object.juliavdb.more = "--half=1"
        with self.assertRaisesRegex(RuntimeError, "--half takes no value"):
            bpy.ops.juliavdb.make()

    # Promise: "whatever a .blend says, *Make ..."
    def test_more_takes_the_options_of_a_recipe(self):
        for more in ("--sdf-resolution 60 --iterations 4", "--sdf-resolution=60\n--exhaustive --origin-shift -0.01,0,0",
                     "--sdf-resolution 60 --colour 'trap:magma'"):
            with self.subTest(more=more):
                self.source(more=more)
                self.assertIn("--sdf-resolution=60", self.make()["juliavdb_command"])

    def test_attributes_under_more_come_beside_the_colours(self):
        for colour, more, expected in (("NONE", "trap", "trap"), ("trap", "trap", "Cd,trap"), ("trap", "trap,Cd", "trap,Cd")):
            with self.subTest(colour=colour, more=more):
                self.source(colour=colour, more=f"--sdf-resolution 60 --attributes {more}", hide_source=False)
                command = self.make()["juliavdb_command"].split()
                self.assertEqual([word for word in command if "attributes" in word], [f"--attributes={expected}"])

    # Promise of blender.md: "whatever a .blend says, *Make Fractal* writes nothing but its own files"; "*More* takes the options
    #   of a recipe only"
    def test_a_blend_of_somebody_else_writes_no_file(self):
        """Whatever stands in the settings of an object, only the add-on's own files are made."""
        precious = self.folder / "precious.vdb"
        precious.write_text("precious")
        listing = self.folder / "options.txt"
        listing.write_text(f"output = {precious}\n")
        path = str(precious)
        for more in (f"-o{path}", f"-o {path}", f"--output={path}", f"--output {path}", f"--outp={path}", f"--mesh={path}",
                     f"--mesh {self.folder}/new.ply", f"--me {self.folder}/new.ply", f"--config={listing}", path,
                     f"--iterations 4\n-o{path}", f"--iterations 4 -- -o{path}", f"'--output={path}'", f"-o\t{path}",
                     f"--frames=1-2 --half -o{path}", "--progress none", "--memory=unlimited", f"--half={path}",
                     f"-{path}", f"--input={path}", "--", "-", "''"):
            with self.subTest(more=more):
                self.source(more=more)
                with self.assertRaisesRegex(RuntimeError, "More options"):
                    bpy.ops.juliavdb.make()
                self.assertEqual(self.files(), ["options.txt", "precious.vdb"])
                self.assertEqual(precious.read_text(), "precious")
        for name, value in (("versor", f"-o{path}"), ("versor", f"--output={path}"), ("versor", f"scales\n-o{path}")):
            with self.subTest(name=name, value=value):
                self.source(**{name: value})
                with self.assertRaises(RuntimeError):
                    bpy.ops.juliavdb.make()
                self.assertEqual(self.files(), ["options.txt", "precious.vdb"])
                self.assertEqual(precious.read_text(), "precious")

    # Promise: "Every error is one line, the same ..."
    def test_a_missing_program_is_reported(self):
        self.source()
        self.preferences().program = str(self.folder / "nowhere")
        with self.assertRaisesRegex(RuntimeError, "preferences"):
            bpy.ops.juliavdb.make()

    def pump(self, seconds=300):
        """What Blender's event loop does for the timer. Yields nothing, but returns the shares and phases seen."""
        seen = []
        end = time.monotonic() + seconds
        make = self.addon.make
        while make.running is not None:
            self.assertLess(time.monotonic(), end, "the task does not end")
            task = make.running
            make.tick()
            if make.running is not None:
                seen.append((task.share, task.text))
            time.sleep(0.02)
        return seen

    def test_progress_in_the_background(self):
        source = self.source(more="--sdf-resolution 100")
        detail = source.juliavdb.detail
        self.assertEqual(bpy.ops.juliavdb.make(wait=False), {"FINISHED"})
        self.assertTrue(bpy.app.timers.is_registered(self.addon.make.tick))
        self.assertFalse(bpy.ops.juliavdb.make.poll(), "one task at a time")
        source.juliavdb.detail = 0.9   # too late for this one
        seen = self.pump()
        shares = [share for share, _ in seen]
        self.assertEqual(shares, sorted(shares))
        self.assertGreater(len(set(shares)), 2)
        self.assertTrue(any("distance field" in text for _, text in seen), seen)
        result, = self.addon.settings.results_of(source)
        self.assertEqual(result.juliavdb.detail, detail)
        self.assertFalse(self.addon.make.said[1])

    # Promise: The add-on: a fractal lies ...
    def test_cancel_leaves_nothing(self):
        for output in ("VOLUME", "MESH"):
            with self.subTest(output=output):
                source = self.source(output=output, resolution=2000, more="--sdf-resolution 400")
                before = set(bpy.data.objects)
                begun = set(pathlib.Path(tempfile.gettempdir()).glob("juliavdb_*"))
                bpy.ops.juliavdb.make(wait=False)
                end = time.monotonic() + 60
                while self.addon.make.running.share == 0 and time.monotonic() < end:
                    self.addon.make.tick()
                    time.sleep(0.02)
                self.assertEqual(bpy.ops.juliavdb.cancel(), {"FINISHED"})
                self.pump(60)
                self.assertEqual(self.addon.make.said, ("Cancelled", False))
                self.assertEqual(set(bpy.data.objects), before)
                self.assertEqual(self.addon.settings.results_of(source), [])
                self.assertFalse((self.folder / "volumes").exists())
                self.assertEqual(set(pathlib.Path(tempfile.gettempdir()).glob("juliavdb_*")), begun)

    def test_another_file_stops_the_program(self):
        self.source(resolution=2000, more="--sdf-resolution 400")
        bpy.ops.juliavdb.make(wait=False)
        process = self.addon.make.running._run._process
        bpy.ops.wm.read_homefile(use_empty=True)
        self.assertIsNotNone(process.poll())
        self.assertIsNone(self.addon.make.running)

    # Promise of blender.md#to-change-it: The recipe of a fractal is in the .blend file, and its volume beside it
    # Promise of blender.md#to-change-it: The add-on "never deletes a volume"
    def test_the_recipe_is_in_the_file(self):
        self.preferences().folder = "//volumes"
        blend = str(self.folder / "scene.blend")
        bpy.ops.wm.save_as_mainfile(filepath=blend)
        self.plain(output="VOLUME", seed=4, detail=0.35, versor="bark")
        result = self.make()
        name, command = result.name, result["juliavdb_command"]
        self.assertTrue(result.data.filepath.startswith("//volumes"), result.data.filepath)
        self.assertIn("--texture-seed=4", command)
        bpy.ops.wm.save_as_mainfile(filepath=blend)
        bpy.ops.wm.read_homefile(use_empty=True)
        self.assertNotIn(name, bpy.data.objects)
        bpy.ops.wm.open_mainfile(filepath=blend)
        result = bpy.data.objects[name]
        recipe = result.juliavdb
        self.assertEqual((recipe.seed, recipe.versor, recipe.texture, recipe.output), (4, "bark", "bark", "VOLUME"))
        self.assertAlmostEqual(recipe.detail, 0.35)
        self.assertEqual(recipe.source, result.parent)
        self.assertEqual(result["juliavdb_command"], command)
        self.assertRegex(result["juliavdb_version"], r"juliavdb \d")
        self.assertTrue(result.data.grids.load())
        bpy.context.view_layer.objects.active = result
        before = {file: (self.folder / file).read_bytes() for file in self.files() if file.endswith(".vdb")}
        bpy.ops.juliavdb.update()
        after = {file: (self.folder / file).read_bytes() for file in self.files() if file.endswith(".vdb")}
        self.assertEqual(before, after, "the same recipe gives the same file")
        recipe.detail = 0.25
        bpy.ops.juliavdb.update()
        kept = {file: (self.folder / file).read_bytes() for file in self.files() if file.endswith(".vdb")}
        self.assertLess(before.items(), kept.items(), "another recipe gives another file, and the first one stays")
        # The program itself finds all in the file that it needs.
        run = subprocess.run([PROGRAM, "fractal", "--config", bpy.path.abspath(result.data.filepath), "-o",
                              str(self.folder / "again.vdb"), "--progress", "none"], capture_output=True, check=False)
        self.assertEqual(run.returncode, 0, run.stderr)

    # Promise of blender.md: Textures of the panel are those "that the program has"; their pictures are made "once"
    def test_textures_are_those_of_the_program(self):
        source = self.source()
        listed = subprocess.run([PROGRAM, "versor", "list"], capture_output=True, text=True, check=True).stdout
        names = [line.split()[0] for line in listed.splitlines()]
        pictures = self.addon.pictures
        shelf = pictures.shelf(PROGRAM)
        self.assertEqual([texture["name"] for texture in pictures.shelf(PROGRAM).textures], [*names, "random"])
        for name in names:
            source.juliavdb.texture = name
            self.assertEqual((source.juliavdb.versor, source.juliavdb.texture), (name, name))
        source.juliavdb.versor = "own.json"
        self.assertEqual(source.juliavdb.texture, "OTHER")
        self.assertFalse(pictures.has_seed(shelf.textures, "quills"))
        self.assertTrue(pictures.has_seed(shelf.textures, "bark"))

    # Promise: Textures of the panel are those ...
    # Promise: "The panel never waits for the program"
    def test_pictures_of_textures_are_made_once(self):
        pictures = self.addon.pictures
        folder = pictures.folder(pictures.shelf(PROGRAM).version)
        self.assertTrue(str(folder).startswith(os.environ["XDG_CACHE_HOME"]), "not in the user's own cache")
        folder.mkdir(parents=True, exist_ok=True)
        # All but two are there.
        shelf = pictures.shelf(PROGRAM)
        for name in pictures.missing(shelf):
            if name not in ("rings", "thorns"):
                (folder / f"{name}.png").write_bytes(b"")
        self.assertEqual(sorted(pictures.missing(shelf)), ["rings", "thorns"])
        task = pictures.Pictures(PROGRAM)
        shares = []
        while task.poll():
            shares.append(task.share)
            time.sleep(0.02)
        self.assertEqual((task.message, task.failed), ("", False))
        self.assertEqual(shares, sorted(shares))
        self.assertEqual(pictures.missing(shelf), [])
        image = bpy.data.images.load(str(folder / "thorns.png"))
        self.assertEqual(tuple(image.size), (pictures.SIZE, pictures.SIZE))

    def test_frequency_roots_and_powers_reach_the_program(self):
        """Each of the textures that have them, and no other."""
        command = lambda **recipe: (self.source(hide_source=False, **recipe), self.make()["juliavdb_command"])[1]   # noqa: E731
        self.assertIn("--frequency=3.5", command(versor="scales", frequency=3.5))
        said = command(versor="random", roots=7, power_low=2, power_high=5, seed=3)
        for word in ("--texture-roots=7", "--texture-powers=2:5", "--texture-seed=3"):
            self.assertIn(word, said)
        self.assertNotIn("--frequency", said)
        self.assertNotIn("--texture-roots", command(versor="scales"))
        for texture in self.addon.pictures.shelf(PROGRAM).textures:
            self.assertIn("--texture=" + texture["name"], command(versor=texture["name"]), "every texture is accepted as it is")
        self.source(versor="random", power_low=9, power_high=3)
        with self.assertRaisesRegex(RuntimeError, "least power"):
            bpy.ops.juliavdb.make()

    def base_colour(self, material):
        """What the base colour of its surface is taken from: the name of an attribute, or None."""
        shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
        links = shader.inputs["Base Color"].links
        return links[0].from_node.attribute_name if links else None

    def test_colours_and_materials(self):
        for colour in ("direction", "versor", "trap", "iterations", "depth"):
            with self.subTest(colour=colour):
                self.source(colour=colour, gradient="magma", hide_source=False)
                result = self.make()
                values = {tuple(entry.color)[:3] for entry in result.data.color_attributes["Cd"].data}
                # Orbits at the surface escape after the same number of steps.
                self.assertGreater(len(values), 0 if colour == "iterations" else 20, "it is one colour")
                self.assertEqual(self.base_colour(result.data.materials[0]), "Cd")
                self.assertTrue(all(polygon.use_smooth for polygon in result.data.polygons))
                self.assertEqual(f"{colour}:magma" in result["juliavdb_command"], colour in self.addon.settings.THROUGH_GRADIENT)
        self.plain(hide_source=False)
        result = self.make()
        self.assertIsNone(self.base_colour(result.data.materials[0]))
        source = self.plain(hide_source=False)
        source.data.materials.append(bpy.data.materials.new("stone"))
        self.assertEqual([material.name for material in self.make().data.materials], ["stone"])
        self.plain(hide_source=False, material=False)
        self.assertEqual(len(self.make().data.materials), 0)
        self.source(output="VOLUME", colour="trap")
        result = self.make()
        self.assertIn("Cd", [grid.name for grid in result.data.grids])
        shader = next(node for node in result.data.materials[0].node_tree.nodes if node.type == "PRINCIPLED_VOLUME")
        self.assertEqual(shader.inputs["Color Attribute"].default_value, "Cd")

    # Promise: The add-on brings in files ...
    def test_colours_are_those_of_blenders_own_importer(self):
        """Bytes of a PLY are sRGB, for both."""
        source = self.source(colour="trap")
        result = self.make()
        command = result["juliavdb_command"].split()
        words = [word for word in command[3:] if word.startswith("--") and not word.startswith("--mesh")]
        self.write_source(source)
        made = str(self.folder / "made.ply")
        subprocess.run([PROGRAM, "fractal", str(self.folder / "source.ply"), "--mesh", made, *words, "--progress", "none"],
                       check=True, capture_output=True)
        in_blender.import_mesh(made)
        theirs = bpy.context.object.data
        ours = self.addon.bring.mesh_object(made).data
        attribute = theirs.color_attributes[0]
        spots = [loop.vertex_index for loop in theirs.loops] if attribute.domain == "CORNER" else range(len(theirs.vertices))
        for spot, entry in list(zip(spots, attribute.data))[::97]:
            for one, other in zip(entry.color[:3], ours.color_attributes["Cd"].data[spot].color[:3]):
                self.assertAlmostEqual(one, other, delta=0.005)

    def write_source(self, source):
        points, triangles, attributes, *_ = self.addon.meshes.to_arrays(source, bpy.context)
        data = self.addon.ply.encoded(self.addon.meshes.z_up_to_y_up(points), triangles, attributes)
        (self.folder / "source.ply").write_bytes(data)

    # Promise of blender.md: The add-on brings in files "upright, whichever `--up` it was made with", smooth and with a material
    def test_files_come_in_upright_smooth_and_with_a_material(self):
        source = self.plain()
        self.write_source(source)
        box = [numpy.array(side) for side in ([min(v.co[a] for v in source.data.vertices) for a in range(3)],
                                              [max(v.co[a] for v in source.data.vertices) for a in range(3)])]
        for up in ("keep", "y", "z", "auto"):
            subprocess.run([PROGRAM, "fractal", "source.ply", "--mesh", f"{up}.ply", "-o", f"{up}.vdb", "--up", up, "--mask", "0",
                            "--grids", "surface,density", "--resolution", str(RESOLUTION), "--sdf-resolution", "60",
                            "--progress", "none"], cwd=self.folder, check=True, capture_output=True)
            for kind in ("ply", "vdb"):
                with self.subTest(up=up, kind=kind):
                    self.assertEqual(bpy.ops.juliavdb.import_file(filepath=str(self.folder / f"{up}.{kind}")), {"FINISHED"})
                    result = bpy.context.object
                    self.assertEqual(len(result.data.materials), 1)
                    if kind == "ply":
                        self.assertTrue(all(polygon.use_smooth for polygon in result.data.polygons))
                    bpy.context.view_layer.update()
                    self.assert_same_box(box, corners(result), 4 * self.voxel(source))
        for name, content in (("cut.ply", (self.folder / "z.ply").read_bytes()[:-5]), ("none.ply", None), ("bad.vdb", b"no VDB")):
            if content is not None:
                (self.folder / name).write_bytes(content)
            before = set(bpy.data.objects)
            with self.assertRaises(RuntimeError):
                bpy.ops.juliavdb.import_file(filepath=str(self.folder / name))
            self.assertEqual(set(bpy.data.objects), before)

    # Promise of blender.md: "adds geometry nodes that turn its fog into a smooth surface"
    def test_nodes_make_a_surface_of_a_volume(self):
        source = self.plain(output="VOLUME")
        box = corners(source)
        result = self.make()
        self.assertEqual(bpy.ops.juliavdb.add_surface(), {"FINISHED"})
        self.assertEqual(bpy.ops.juliavdb.add_surface(), {"FINISHED"})
        self.assertEqual(len(result.modifiers), 1, "it is added once")
        group = result.modifiers[0].node_group
        self.assertIsNotNone(group.asset_data, "it is an asset")
        bpy.context.view_layer.update()
        points, smooth, materials = [], [], set()
        for instance in bpy.context.evaluated_depsgraph_get().object_instances:
            if instance.object.type == "MESH" and instance.object.original == result:
                mesh = instance.object.data
                points += [instance.matrix_world @ vertex.co for vertex in mesh.vertices]
                smooth += [polygon.use_smooth for polygon in mesh.polygons]
                materials |= {material.name for material in mesh.materials if material}
        self.assertGreater(len(points), 100)
        points = numpy.array(points)
        self.assert_same_box(box, (points.min(0), points.max(0)), self.voxel(source))
        self.assertTrue(all(smooth))
        self.assertEqual(len(materials), 1)

    def test_colours_of_a_ply_arrive(self):
        ply, meshes = self.addon.ply, self.addon.meshes
        points = numpy.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
        triangles = numpy.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
        colours = numpy.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.25, 1]])
        path = self.folder / "coloured.ply"
        path.write_bytes(ply.encoded(points, triangles, dict(zip(("red", "green", "blue"), colours.T))))
        mesh = meshes.from_arrays("coloured", *ply.read(path))
        self.assertEqual([tuple(vertex.co) for vertex in mesh.vertices], [tuple(point) for point in points])
        for entry, colour in zip(mesh.color_attributes["Cd"].data, colours):
            self.assertEqual(tuple(entry.color)[:3], tuple(colour))
        path.write_bytes(path.read_bytes()[:-1])
        with self.assertRaisesRegex(ValueError, "cut off"):
            ply.read(path)

    def blurred(self, thing, blurs):
        """The lowest, the mean and the highest place of an object in a picture along Y, and its width. The shutter is open for a
        frame, half of it before now, and takes in more and more light."""
        size, scale = 64, 6
        scene = bpy.context.scene
        scene.render.engine = "CYCLES"
        scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CPU", 64, False
        scene.render.resolution_x = scene.render.resolution_y = size
        scene.render.resolution_percentage, scene.render.fps = 100, 24
        scene.render.use_motion_blur, scene.render.motion_blur_shutter = blurs, 1
        shutter = scene.render.motion_blur_shutter_curve
        first, *others, last = shutter.curves[0].points
        for point in others:
            shutter.curves[0].points.remove(point)
        first.location, last.location = (0, 0), (1, 1)
        shutter.update()
        scene.render.filepath = str(self.folder / f"{thing.type}{blurs}.png")
        for other in scene.objects:
            other.hide_render = other.type in ("MESH", "VOLUME") and other != thing
        bpy.ops.render.render(write_still=True)
        pixels = numpy.array(bpy.data.images.load(scene.render.filepath).pixels[:]).reshape(size, size, 4)[:, :, :3].max(2)
        rows, columns = (numpy.nonzero(pixels.max(axis) > 0.004)[0] for axis in (1, 0))
        mean = (pixels.sum(1) * (numpy.arange(size) + 0.5)).sum() / pixels.sum()
        return [scale * (row / size - 0.5) for row in (rows[0], mean, rows[-1] + 1)], scale / size * (columns[-1] + 1 - columns[0])

    # Promise of attributes.md: "both then have motion blur in Cycles"
    def test_what_moves_is_blurred_in_its_direction(self):
        """A ball with the radius 1 that rises by 1 in a frame, as a mesh and as a volume."""
        for name, height in (("now", 0), ("later", 1)):
            bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=1, location=(0, 0, 0))
            ball = bpy.context.object
            points, triangles, attributes, *_ = self.addon.meshes.to_arrays(ball, bpy.context)
            bpy.data.objects.remove(ball)
            points = self.addon.meshes.z_up_to_y_up(points + numpy.array([0, 0, height]))
            (self.folder / f"{name}.ply").write_bytes(self.addon.ply.encoded(points, triangles, attributes))
        subprocess.run([PROGRAM, "fractal", "now.ply", "--target-after", "later.ply", "--attributes", "velocity", "--mask", "0",
                        "--mesh", "f.ply", "-o", "f.vdb", "--up", "auto", "--grids", "surface,density", "--grid-names", "blender",
                        "--resolution", "40", "--sdf-resolution", "60", "--progress", "none"], cwd=self.folder, check=True,
                       capture_output=True)
        scene = bpy.context.scene
        sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
        sun.data.energy, sun.rotation_euler = 5, (1.57, 0, 0)
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        camera.data.type, camera.data.ortho_scale = "ORTHO", 6
        camera.location, camera.rotation_euler = (0, -8, 0), (numpy.pi / 2, 0, 0)
        for thing in (sun, camera):
            scene.collection.objects.link(thing)
        scene.camera = camera
        for kind in ("ply", "vdb"):
            with self.subTest(kind=kind):
                self.assertEqual(bpy.ops.juliavdb.import_file(filepath=str(self.folder / f"f.{kind}")), {"FINISHED"})
                thing = bpy.context.object
                (low, mean, high), width = self.blurred(thing, False)
                self.assertLess(max(abs(low + 1), abs(high - 1), abs(mean), abs(width - 2)), 0.35)
                (low, mean, high), width = self.blurred(thing, True)
                self.assertLess(max(abs(low + 1.5), abs(high - 1.5), abs(width - 2)), 0.35)
                self.assertGreater(mean, 0.1)

    # Promise of blender.md: "The panel never waits for the program"
    def test_drawing_never_waits_for_the_program(self):
        """A program that does not answer holds up a thread, but not what Blender calls to draw."""
        self.source()
        panel, pictures, programs = self.addon.panel, self.addon.pictures, self.addon.program
        asked, answer = [], threading.Event()
        really = programs.answer

        def slowly(program, *words):
            asked.append(words)
            self.assertIsNot(threading.current_thread(), threading.main_thread())
            answer.wait(60)
            return really(PROGRAM, *words)

        def drawn():
            """What the panel shows."""
            layout = unittest.mock.MagicMock()
            layout.column.return_value = layout.row.return_value = layout
            panel.Panel.draw(types.SimpleNamespace(layout=layout), bpy.context)
            shown = [call.args[1] for call in layout.prop.call_args_list]
            return shown + [call.kwargs["text"] for call in layout.label.call_args_list]

        self.preferences().program = "another juliavdb"
        with unittest.mock.patch.object(programs, "answer", slowly):
            for _ in range(3):
                shown = drawn()
                self.assertIn("detail", shown)
                self.assertNotIn("texture", shown)
                self.assertEqual(len(pictures.items("another juliavdb")), 1)
                self.assertEqual(pictures.tick(), pictures.INTERVAL)
            self.assertTrue(bpy.app.timers.is_registered(pictures.tick))
            answer.set()
            end = time.monotonic() + 60
            while pictures.tick() is not None and time.monotonic() < end:
                time.sleep(0.02)
            self.assertEqual(asked[0], ("--version",))
            before = len(asked)
            self.assertIn("texture", drawn())
            self.assertEqual(len(asked), before, "it is asked once")

    def tube(self, turn=math.radians(90), **recipe):
        """A tube along Z from 0 to 4 with round ends, which an armature bends about Y over the frames 1 to 10: below 1 it stands,
        above 3 it is turned as a whole. Its object is turned, scaled and moved."""
        rings, around, radius = 32, 20, 0.5
        rows = [(radius - radius * math.cos(a), radius * math.sin(a)) for a in numpy.linspace(0, math.pi / 2, 6)[:-1]]
        rows += [(z, radius) for z in numpy.linspace(radius, 4 - radius, rings)]
        rows += [(4 - low, r) for low, r in rows[4::-1]]
        points, faces = [], []
        for z, r in rows[1:-1]:
            points += [(r * math.cos(2 * math.pi * k / around), r * math.sin(2 * math.pi * k / around), z) for k in range(around)]
        for low in range(0, len(points) - around, around):
            faces += [(low + k, low + (k + 1) % around, low + around + (k + 1) % around, low + around + k) for k in range(around)]
        faces += [tuple(reversed(range(around))), tuple(range(len(points) - around, len(points)))]
        mesh = bpy.data.meshes.new("Tube")
        mesh.from_pydata(points, [], faces)
        tube = bpy.data.objects.new("Tube", mesh)
        bones = bpy.data.objects.new("Bones", bpy.data.armatures.new("Bones"))
        for thing in (tube, bones):
            bpy.context.scene.collection.objects.link(thing)
        tube.matrix_world = Matrix.Translation((3, -2, 1)) @ Matrix.Rotation(0.7, 4, "Y") @ Matrix.Scale(2, 4)
        bones.parent = tube
        bpy.context.view_layer.objects.active = bones
        bpy.ops.object.mode_set(mode="EDIT")
        below, above = (bones.data.edit_bones.new(name) for name in ("below", "above"))
        below.head, below.tail, above.head, above.tail = (0, 0, 0), (0, 0, 2), (0, 0, 2), (0, 0, 4)
        above.parent = below
        bpy.ops.object.mode_set(mode="OBJECT")
        for name in ("below", "above"):
            group = tube.vertex_groups.new(name=name)
            for index, point in enumerate(points):
                share = min(max((point[2] - 1) / 2, 0), 1)
                group.add([index], share if name == "above" else 1 - share, "REPLACE")
        tube.modifiers.new("Bend", "ARMATURE").object = bones
        bone = bones.pose.bones["above"]
        bone.rotation_mode = "XYZ"
        for frame, angle in ((1, 0), (10, turn)):
            bone.rotation_euler = (angle, 0, 0)   # the bone's X is -Y of the tube or Y; see turned_back()
            bone.keyframe_insert("rotation_euler", frame=frame)
        for curve in bones.animation_data.action.fcurves:
            for key in curve.keyframe_points:
                key.interpolation = "LINEAR"
        scene = bpy.context.scene
        scene.frame_start, scene.frame_end = 1, 10
        scene.frame_set(1)
        for other in scene.objects:
            other.select_set(other == tube)
        bpy.context.view_layer.objects.active = tube
        for name, value in {"resolution": 48, "more": "--sdf-resolution 60", "detail": 0.8, "frequency": 1, **recipe}.items():
            setattr(tube.juliavdb, name, value)
        return tube

    def top_bend(self):
        """What the bone of the upper part does in the coordinates of the tube."""
        bone = bpy.data.objects["Bones"].pose.bones["above"]
        return bone.matrix @ bone.bone.matrix_local.inverted()

    def points_of(self, thing):
        points = numpy.empty(3 * len(thing.data.vertices))
        thing.data.vertices.foreach_get("co", points)
        return points.reshape(-1, 3)

    def tree(self, thing):
        return BVHTree.FromPolygons([vertex.co for vertex in thing.data.vertices],
                                    [polygon.vertices[:] for polygon in thing.data.polygons])

    def off(self, tree, points):
        """The mean distance of points from a mesh, in voxels of the tube."""
        return numpy.mean([tree.find_nearest(point)[3] for point in points]) / (4 / 48)

    def off_when_bent(self, result):
        """The mean distance of the upper part of a result, turned back, from the result at rest, in voxels."""
        scene = bpy.context.scene
        scene.frame_set(1)
        at_rest = self.tree(result)
        scene.frame_set(10)
        back = self.top_bend().inverted()
        self.assertGreater(back.to_euler().to_quaternion().angle, 1, "nothing bends")
        points = [back @ Vector(point) for point in self.points_of(result)]
        return self.off(at_rest, [point for point in points if point.z > 3.2][::5])

    def key_object(self, thing):
        """The object itself moves as well."""
        for frame, turn in ((1, 0), (10, 1)):
            thing.rotation_euler.x = turn
            thing.location.z = turn
            thing.keyframe_insert("rotation_euler", frame=frame)
            thing.keyframe_insert("location", frame=frame)

    # Promise of blender.md: "The fractal is then that of the object at rest and follows each pose as a skin does"; what counts,
    #   and why it may not stick
    # Promise of blender.md: "*Make Animation* makes all frames by one run of the program", and the result plays, "in the window
    #   and in renders"
    def test_an_animation_sticks_and_plays(self):
        tube = self.tube()
        self.key_object(tube)
        bpy.context.scene.frame_set(4)
        self.assertEqual(bpy.ops.juliavdb.animate(), {"FINISHED"})
        result = bpy.context.object
        self.assertEqual((result.type, result.parent, bpy.context.scene.frame_current), ("MESH", tube, 4))
        self.assertIn("--rest=", result["juliavdb_command"])
        self.assertTrue(bpy.context.scene.render.use_lock_interface)
        seen = set()
        for frame in (10, 1, 2, 3, 4, 5, 6, 7, 8, 9):
            bpy.context.scene.frame_set(frame)
            points = self.points_of(result)
            seen.add(points.tobytes())
            self.assertEqual(len(result.data.materials), 1)
            self.assertTrue(all(polygon.use_smooth for polygon in result.data.polygons))
            self.assert_same_box(corners(tube), corners(result), 0.8)
        self.assertEqual(len(seen), 10, "each frame has its own mesh")
        # Outside the range it stays as it is at its ends.
        for outside, inside in ((0, 1), (20, 10)):
            bpy.context.scene.frame_set(inside)
            points = self.points_of(result)
            bpy.context.scene.frame_set(outside)
            self.assertTrue(numpy.array_equal(self.points_of(result), points))
        sticks = self.off_when_bent(result)
        result.juliavdb.stick = False
        self.assertEqual(bpy.ops.juliavdb.update(), {"FINISHED"})
        self.assertNotIn("--rest=", result["juliavdb_command"])
        swims = self.off_when_bent(result)
        self.assertLess(sticks, 0.4)
        self.assertGreater(swims, 2 * sticks)

    # Promise: "*Make Animation* makes all ..."
    def test_an_animation_of_a_volume_plays(self):
        tube = self.tube(output="VOLUME", scene_range=False, frame_first=-2, frame_last=10, resolution=32, detail=0.2)
        self.key_object(tube)
        self.assertEqual(bpy.ops.juliavdb.animate(), {"FINISHED"})
        result = bpy.context.object
        self.assertEqual((result.type, result.parent), ("VOLUME", tube))
        self.assertIn("--rest=", result["juliavdb_command"])
        self.assertTrue(result.data.is_sequence)
        surface = surface_of(result, "surface", 0)
        heights = []
        for frame in (-2, 1, 5, 10, 15):
            bpy.context.scene.frame_set(frame)
            box = corners(surface)
            self.assert_same_box(corners(tube), box, 0.8)
            heights.append(box[1][2])
        self.assertEqual((heights[0], heights[3]), (heights[1], heights[4]), "it moves from frame 1 to 10")
        self.assertEqual(len(set(heights)), 3)
        bpy.context.view_layer.objects.active = result
        self.assertEqual(bpy.ops.juliavdb.add_surface(), {"FINISHED"})

    # Promise: "*Make Animation* makes all ..."
    def test_an_animation_can_be_rendered_and_is_in_the_file(self):
        self.preferences().folder = "//volumes"
        blend = str(self.folder / "scene.blend")
        bpy.ops.wm.save_as_mainfile(filepath=blend)
        self.tube(resolution=24, scene_range=False, frame_first=9, frame_last=10,
                  more="--sdf-resolution 60 --attributes velocity --fps 24", colour="trap")
        bpy.ops.juliavdb.animate()
        name = bpy.context.object.name
        scene = bpy.context.scene
        scene.frame_set(9)
        bpy.ops.wm.save_as_mainfile(filepath=blend)
        bpy.ops.wm.open_mainfile(filepath=blend)
        scene, result = bpy.context.scene, bpy.data.objects[name]
        self.assertTrue(result.juliavdb.sequence.startswith("//volumes"), result.juliavdb.sequence)
        for thing, data, place in (("sun", bpy.data.lights.new("sun", "SUN"), (0, 0, 9)),
                                   ("camera", bpy.data.cameras.new("camera"), (6, 0, 30))):
            scene.collection.objects.link(bpy.data.objects.new(thing, data))
            bpy.data.objects[thing].location = place
        scene.camera = bpy.data.objects["camera"]
        scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 4, "CPU"
        scene.cycles.use_denoising = False
        scene.render.resolution_x = scene.render.resolution_y = 48
        scene.frame_start, scene.frame_end, scene.render.filepath = 9, 10, str(self.folder / "film")
        bpy.ops.render.render(animation=True)
        pixels = lambda file: numpy.array(bpy.data.images.load(str(self.folder / file)).pixels[:])   # noqa: E731
        for frame in (10, 9):
            scene.frame_set(frame)
            names = [each.name for each in result.data.attributes if each.name.startswith("velocity")]
            self.assertEqual(names, ["velocity"])
            scene.render.filepath = str(self.folder / f"still{frame}.png")
            bpy.ops.render.render(write_still=True)
            self.assertTrue(numpy.array_equal(pixels(f"film{frame:04}.png"), pixels(f"still{frame}.png")))
        self.assertFalse(numpy.array_equal(pixels("still9.png"), pixels("still10.png")))

    # Promise: "The fractal is then that of the object ..."
    def test_a_still_sticks_under_shape_keys_and_modifiers(self):
        """A pose that is the whole shape turned: the fractal is the one at rest, turned."""
        turn = Matrix.Rotation(0.5, 3, (1, 2, 3))
        for kind in ("keys", "modifier", "driven"):
            with self.subTest(kind=kind):
                source = self.source(hide_source=False, up="Y", detail=0.8, frequency=1, resolution=2 * RESOLUTION)
                at_rest = self.tree(self.make())
                bpy.context.view_layer.objects.active = source
                if kind == "modifier":
                    hook = source.modifiers.new("Hook", "HOOK")
                    hook.object = bpy.data.objects.new("Handle", None)
                    bpy.context.scene.collection.objects.link(hook.object)
                    hook.vertex_indices_set(range(len(source.data.vertices)))
                    hook.matrix_inverse = Matrix()
                    hook.object.matrix_world = source.matrix_world @ turn.to_4x4()
                else:
                    for name in ("Basis", "Other", "Turned"):
                        source.shape_key_add(name=name)
                    keys = source.data.shape_keys.key_blocks
                    for vertex in keys["Turned"].data:
                        vertex.co = turn @ vertex.co
                    keys["Turned"].value = 1
                    source.active_shape_key_index = 2
                    if kind == "driven":
                        keys["Turned"].driver_add("value").driver.expression = "1"
                bpy.context.view_layer.update()
                where = {}
                for sticks in (True, False):
                    source.juliavdb.stick = sticks
                    bpy.context.view_layer.objects.active = source
                    result = self.make()
                    self.assertEqual("--rest=" in result["juliavdb_command"], sticks)
                    points = self.points_of(result) @ numpy.array(turn)
                    where[sticks] = numpy.mean([at_rest.find_nearest(point)[3] for point in points[::5]]) / (self.voxel(source) / 2)
                    if kind != "modifier":
                        self.assertEqual((source.show_only_shape_key, source.active_shape_key_index), (False, 2))
                        self.assertEqual(keys["Turned"].value, 1)
                    else:
                        self.assertTrue(hook.show_viewport)
                self.assertLess(where[True], 0.3)
                self.assertGreater(where[False], 2 * where[True])

    # Promise: "The fractal is then that of the object ..."
    def test_other_faces_cannot_stick(self):
        tube = self.tube(resolution=24)
        tube.modifiers.new("Remesh", "REMESH").voxel_size = 0.3
        bpy.context.scene.frame_set(10)
        for operator in (bpy.ops.juliavdb.make, bpy.ops.juliavdb.animate):
            with self.assertRaisesRegex(RuntimeError, "cannot stick .* at rest, without Bend.*switch off Stick to the Surface"):
                operator()
            self.assertIn("cannot stick", tube.juliavdb.stick_refused)
            self.assertEqual(self.files(), [])
            self.assertFalse((self.folder / "volumes").exists())
            self.assertEqual((bpy.context.scene.frame_current, tube.modifiers["Bend"].show_viewport), (10, True))
        self.assertTrue(any("cannot stick" in text for text in self.drawn_whole()))
        tube.juliavdb.stick = False
        self.make()
        self.assertEqual(tube.juliavdb.stick_refused, "")

    # Promise: "The fractal is then that of the object ..."
    def test_what_moves_is_known(self):
        source = self.source()
        moves = self.addon.meshes.what_moves
        for kind in ("SUBSURF", "DISPLACE", "MIRROR", "SMOOTH"):
            source.modifiers.new(kind, kind)
        source.shape_key_add(name="Basis")
        self.assertEqual(moves(source), [])
        self.assertNotIn("stick", self.drawn_whole())
        for kind in sorted(self.addon.meshes.MOVING - {"OCEAN"}):
            modifier = source.modifiers.new("Mover", kind)
            self.assertEqual(moves(source), ["Mover"], kind)
            self.assertIn("stick", self.drawn_whole())
            modifier.show_viewport = False
            self.assertEqual(moves(source), [])
            source.modifiers.remove(modifier)
        ocean = source.modifiers.new("Mover", "OCEAN")
        self.assertEqual(moves(source), [])
        ocean.geometry_mode = "DISPLACE"
        self.assertEqual(moves(source), ["Mover"])
        source.modifiers.remove(ocean)
        source.shape_key_add(name="Other")
        self.assertEqual(moves(source), ["shape keys"])

    def drawn_whole(self):
        """What the panel shows: the names of properties, and texts."""
        layout = unittest.mock.MagicMock()
        for name in ("column", "row", "box"):
            getattr(layout, name).return_value = layout
        self.addon.panel.Panel.draw(types.SimpleNamespace(layout=layout), bpy.context)
        shown = [call.args[1] for call in layout.prop.call_args_list]
        texts = " ".join(call.kwargs["text"] for call in layout.label.call_args_list)
        return [*shown, texts, *(["icons"] if layout.template_icon_view.called else [])]

    def test_without_pictures_there_is_no_black_rectangle(self):
        self.source()
        pictures = self.addon.pictures
        pictures.shelf(PROGRAM)
        with unittest.mock.patch.object(pictures, "icon", lambda _: 0):
            self.assertNotIn("icons", self.drawn_whole())
            self.assertIn("texture", self.drawn_whole())
        with unittest.mock.patch.object(pictures, "icon", lambda _: 7):
            self.assertIn("icons", self.drawn_whole())

    # Promise: "*Make Animation* makes all ..."
    def test_an_animation_is_refused_or_cancelled_without_a_trace(self):
        self.tube(scene_range=False, frame_first=3, frame_last=2)
        with self.assertRaisesRegex(RuntimeError, "first frame, 3, is after the last one, 2"):
            bpy.ops.juliavdb.animate()
        tube = self.tube(resolution=200)
        before = set(bpy.data.objects)
        bpy.ops.juliavdb.animate(wait=False)
        end = time.monotonic() + 60
        while self.addon.make.running.share == 0 and time.monotonic() < end:
            self.addon.make.tick()
            time.sleep(0.02)
        bpy.ops.juliavdb.cancel()
        self.pump(60)
        self.assertEqual(self.addon.make.said, ("Cancelled", False))
        self.assertEqual(set(bpy.data.objects), before)
        self.assertEqual(self.addon.settings.results_of(tube), [])
        self.assertFalse((self.folder / "volumes").exists())

    # Promise: "*Make Animation* makes all ..."
    def test_a_still_becomes_an_animation(self):
        self.tube(resolution=24, scene_range=False, frame_first=9, frame_last=10)
        result = self.make()
        self.assertEqual(result.juliavdb.sequence, "")
        for output in ("MESH", "VOLUME"):
            result.juliavdb.output = output
            self.assertEqual(bpy.ops.juliavdb.animate(), {"FINISHED"})
            result = bpy.context.object
            self.assertEqual((result.type, result.juliavdb.sequence != ""), (output, True))
            self.assertEqual(len(self.addon.settings.results_of(result.juliavdb.source)), 1)
            before = result.juliavdb.sequence
            self.assertEqual(bpy.ops.juliavdb.update(), {"FINISHED"})
            self.assertEqual(result.juliavdb.sequence, before, "the same recipe has the same files")

    # Promise of blender.md: A sequence of files comes in "as one object that plays them, each at its frame"
    def test_a_sequence_comes_in_by_one_click(self):
        source = self.plain(hide_source=False)
        for number in (7, 8, 10):
            for vertex in source.data.vertices:
                vertex.co.x += 1
            self.write_source(source)
            subprocess.run([PROGRAM, "fractal", "source.ply", "--mesh", f"s.{number:04}.ply", "-o", f"s.{number:04}.vdb", "--mask", "0",
                            "--grids", "surface,density", "--resolution", str(RESOLUTION), "--sdf-resolution", "60",
                            "--progress", "none"], cwd=self.folder, check=True, capture_output=True)
        shutil.copy(self.folder / "s.0007.ply", self.folder / "s.00001.ply")   # other files
        shutil.copy(self.folder / "s.0007.ply", self.folder / "t.0001.ply")
        scene = bpy.context.scene
        for kind in ("ply", "vdb"):
            with self.subTest(kind=kind):
                scene.frame_set(8)
                self.assertEqual(bpy.ops.juliavdb.import_file(filepath=str(self.folder / f"s.0007.{kind}")), {"FINISHED"})
                result = bpy.context.object
                shown = result if kind == "ply" else surface_of(result, "surface", 0)
                places = []
                frames = (1, 7, 8, 9, 10, 11) if kind == "ply" else (1, 7, 8, 10, 11)
                for frame in frames:
                    scene.frame_set(frame)
                    places.append(round(float(corners(shown)[0][0]), 3))
                steps = numpy.diff(places)
                expected = (0, 1, 0, 1, 0) if kind == "ply" else (0, 1, 1, 0)
                self.assertLess(numpy.abs(steps - expected).max(), 0.05, places)
        for name, arguments in (("s.0007.ply", {"sequence": False}), ("t.0001.ply", {})):
            bpy.ops.juliavdb.import_file(filepath=str(self.folder / name), **arguments)
            self.assertEqual(bpy.context.object.juliavdb.sequence, "")

    # Promise: "The panel never waits for the program"
    def test_the_panel_has_what_it_draws(self):
        """There is no window to draw in, but every property and operator that the panel names must exist."""
        source = (ROOT / "integrations/blender" / ADDON / "panel.py").read_text()
        import re
        for name in re.findall(r'\.prop\(chosen, "(\w+)"', source):
            self.assertIn(name, self.addon.settings.Settings.bl_rna.properties)
        for name in re.findall(r'operator\("juliavdb\.(\w+)"', source):
            self.assertIn(name, dir(bpy.ops.juliavdb))

    def test_it_can_be_switched_off_and_on(self):
        addon_utils.disable(ADDON, default_set=True)
        self.assertFalse(hasattr(bpy.types.Object, "juliavdb"))
        addon_utils.enable(ADDON, default_set=True)
        self.assertTrue(hasattr(bpy.types.Object, "juliavdb"))


if __name__ == "__main__":
    in_blender.main("blender_test")

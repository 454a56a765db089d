# SPDX-License-Identifier: Apache-2.0
"""What the program writes, brought into Blender with the default settings of its importers: where it lies, which way is
up, colours, sequences, and a picture.

Started by Python it starts itself again inside Blender: blender -b --factory-startup --python handoff_test.py
With JULIAVDB_PICTURES in the environment, the pictures of docs/handoff.md are made in that folder.
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest


sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import in_blender   # noqa: E402

in_blender.ensure(__file__)

import bpy           # noqa: E402
import addon_utils   # noqa: E402
import numpy         # noqa: E402
from mathutils import Vector   # noqa: E402
from mathutils.bvhtree import BVHTree   # noqa: E402
from mathutils.kdtree import KDTree   # noqa: E402

# Blender 3.4 imports glTF by a name that NumPy 1.24, which is Debian's, does not have any more.
if not hasattr(numpy, "bool"):
    numpy.bool = bool

PROGRAM = os.path.abspath(os.environ["JULIAVDB"])
RESOLUTION = 40
# Of the fractal with the mask 0, which is the target itself.
PLAIN = ("--mask", "0", "--resolution", str(RESOLUTION), "--sdf-resolution", "60")


def pear(size=1.0):
    """Points and quads of a pear with Y up, whose box has the middle of no axis at 0 and no two sides alike."""
    around, along = 24, 16
    points = [(0.3, -0.7, 0.2)]
    for i in range(1, along):
        angle = numpy.pi * i / along
        radius = numpy.sin(angle) * (0.8 + 0.35 * numpy.cos(angle))
        for j in range(around):
            turn = 2 * numpy.pi * j / around
            points.append((0.3 + radius * numpy.cos(turn), 0.8 - 1.5 * numpy.cos(angle), 0.2 + 0.6 * radius * numpy.sin(turn)))
    points.append((0.3, 2.3, 0.2))
    ring = lambda i, j: 1 + (i - 1) * around + j % around   # noqa: E731
    faces = [(0, ring(1, j), ring(1, j + 1)) for j in range(around)]
    faces += [(ring(i, j), ring(i + 1, j), ring(i + 1, j + 1), ring(i, j + 1))
              for i in range(1, along - 1) for j in range(around)]
    faces += [(ring(along - 1, j + 1), ring(along - 1, j), len(points) - 1) for j in range(around)]
    return size * numpy.array(points), faces


def obj_text(points, faces):
    return "".join(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in points) + "".join(
        "f " + " ".join(str(corner + 1) for corner in face) + "\n" for face in faces)


def evaluated(thing):
    return thing.evaluated_get(bpy.context.evaluated_depsgraph_get())


def corners(thing):
    """The least and the greatest coordinates of an object in the world: of its vertices, or of its volume's box."""
    made = evaluated(thing)
    points = ([vertex.co for vertex in made.data.vertices] if thing.type == "MESH" else
              [Vector(corner) for corner in made.bound_box])
    points = numpy.array([made.matrix_world @ point for point in points])
    return points.min(0), points.max(0)


def surface_of(volume):
    """A mesh object of the grid "surface", by Blender's own Volume to Mesh. It takes part in the volume's place."""
    mesh = bpy.data.objects.new("surface", bpy.data.meshes.new("surface"))
    bpy.context.scene.collection.objects.link(mesh)
    mesh.matrix_world = volume.matrix_world
    modifier = mesh.modifiers.new("Volume to Mesh", "VOLUME_TO_MESH")
    modifier.object = volume
    modifier.grid_name = "surface"
    modifier.threshold = 0
    bpy.context.view_layer.update()
    return mesh


class Handoff(unittest.TestCase):

    # Pixels of a picture: more of one that is kept.
    SIZE = 400 if "JULIAVDB_PICTURES" in os.environ else 200

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_test_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        (cls.folder / "pear.obj").write_text(obj_text(*pear()))
        cls.voxel = 3.0 / RESOLUTION
        cls.juliavdb("fractal", "pear.obj", *PLAIN, "--up", "auto", "-o", "p.vdb", "--mesh", "p.ply")
        for name in ("p.obj", "p.glb", "p.stl"):
            cls.juliavdb("mesh", "p.vdb", "-o", name)
        cls.juliavdb("usd", "p.vdb", "--mesh", "p.ply", "-o", "p.usda")

    @classmethod
    def juliavdb(cls, *words):
        run = subprocess.run([PROGRAM, *words, "--progress", "none"], cwd=cls.folder, capture_output=True, text=True,
                             check=False)
        if run.returncode != 0:
            raise AssertionError(f"juliavdb {' '.join(words)}: {run.stderr}")
        return run.stdout

    def setUp(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        addon_utils.enable("io_scene_gltf2")

    def bring(self, name):
        """Imports a file as a user does who changes nothing. @return the new object"""
        path = str(self.folder / name)
        before = set(bpy.data.objects)
        operators = {".obj": lambda: bpy.ops.wm.obj_import(filepath=path),
                     ".ply": lambda: in_blender.import_mesh(path),
                     ".stl": lambda: in_blender.import_mesh(path),
                     ".glb": lambda: bpy.ops.import_scene.gltf(filepath=path),
                     ".vdb": lambda: bpy.ops.object.volume_import(filepath=path, directory=str(self.folder),
                                                                  files=[{"name": name}])}
        self.assertEqual(operators[pathlib.Path(name).suffix](), {"FINISHED"})
        new = [thing for thing in set(bpy.data.objects) - before if thing.type in ("MESH", "VOLUME")]
        self.assertEqual(len(new), 1)
        bpy.context.view_layer.update()
        return new[0]

    def assert_same_box(self, first, second, tolerance, what):
        for one, other in zip(first, second):
            self.assertLess(numpy.abs(one - other).max(), tolerance, f"{what}: {first} and {second}")

    # Promise of handoff.md: All files "stand upright in the same place when they are opened in Blender", and follow a sequence
    def test_all_formats_lie_in_the_same_place_and_stand_upright(self):
        source = corners(self.bring("pear.obj"))
        # The pear is longest along its upright axis, and its stem is above the ground.
        numpy.testing.assert_allclose(source[0][2], -0.7, atol=1e-6)
        numpy.testing.assert_allclose(source[1][2], 2.3, atol=1e-6)
        for name in ("p.obj", "p.ply", "p.stl", "p.glb"):
            self.assert_same_box(source, corners(self.bring(name)), self.voxel, name)
        volume = self.bring("p.vdb")
        self.assert_same_box(source, corners(surface_of(volume)), self.voxel, "p.vdb")

    def animated_pear(self):
        """A pear with Z up that a bone bends, a shape key swells, and an object moves; exported as walk.glb."""
        points, faces = pear()
        points = numpy.stack([points[:, 0], -points[:, 2], points[:, 1]], 1)
        data = bpy.data.meshes.new("pear")
        data.from_pydata([tuple(point) for point in points], [], faces)
        thing = bpy.data.objects.new("pear", data)
        bpy.context.scene.collection.objects.link(thing)
        thing.shape_key_add(name="Basis")
        swollen = thing.shape_key_add(name="swollen")
        for i, (x, y, z) in enumerate(points):
            swollen.data[i].co = (x + 0.4 * max(0, x), y, z)
        for frame, value in ((1, 0), (20, 1)):
            swollen.value = value
            swollen.keyframe_insert("value", frame=frame)

        bpy.ops.object.armature_add()
        rig = bpy.context.object
        bpy.ops.object.mode_set(mode="EDIT")
        low = rig.data.edit_bones[0]
        low.name, low.head, low.tail = "low", (0.3, -0.2, -0.7), (0.3, -0.2, 0.8)
        high = rig.data.edit_bones.new("high")
        high.head, high.tail, high.parent = low.tail, (0.3, -0.2, 2.3), low
        bpy.ops.object.mode_set(mode="OBJECT")
        thing.parent = rig
        for name, share in (("low", lambda t: 1 - t), ("high", lambda t: t)):
            group = thing.vertex_groups.new(name=name)
            for i, point in enumerate(points):
                group.add([i], share(min(max((point[2] + 0.2) / 2, 0), 1)), "REPLACE")
        thing.modifiers.new("Armature", "ARMATURE").object = rig
        bone = rig.pose.bones["high"]
        bone.rotation_mode = "QUATERNION"
        for frame, turn, place in ((1, (1, 0, 0, 0), (0, 0, 0)), (20, (0.9, 0.3, 0.1, 0.3), (1, 2, -0.5))):
            bone.rotation_quaternion = turn
            bone.keyframe_insert("rotation_quaternion", frame=frame)
            rig.location = place
            rig.keyframe_insert("location", frame=frame)
        bpy.context.scene.frame_end = 20
        bpy.context.scene.render.fps = 24
        bpy.context.scene.frame_set(1)
        bpy.ops.export_scene.gltf(filepath=str(self.folder / "walk.glb"), export_format="GLB")
        return thing

    # Promise: Nodes, skins and morph targets ...
    def test_an_animated_gltf_is_what_blender_shows(self):
        """The surface at a frame, against the points that Blender itself shows there."""
        thing = self.animated_pear()
        for frame in (1, 7, 20):
            bpy.context.scene.frame_set(frame)
            shown = evaluated(thing)
            corners = [tuple(shown.matrix_world @ vertex.co) for vertex in shown.data.vertices]
            polygons = [tuple(polygon.vertices) for polygon in shown.data.polygons]
            self.juliavdb("fractal", "walk.glb", "--target-frame", str(frame), "--target-animation", "all", *PLAIN, "--up", "keep",
                          "--mesh", "found.obj")
            lines = [line.split() for line in (self.folder / "found.obj").read_text().splitlines()]
            # Of glTF's axes, Y up, to Blender's.
            found = [(float(w[1]), -float(w[3]), float(w[2])) for w in lines if w[:1] == ["v"]]
            faces = [tuple(int(c.split("/")[0]) - 1 for c in w[1:]) for w in lines if w[:1] == ["f"]]
            for one, others, what in ((BVHTree.FromPolygons(corners, polygons), found, "found"),
                                      (BVHTree.FromPolygons(found, faces), corners, "shown")):
                self.assertGreater(len(others), 300)
                worst = max(one.find_nearest(point)[3] for point in others)
                self.assertLess(worst, self.voxel / 2, f"{what} at frame {frame}")

    # Promise of handoff.md#usd: A scene of USD lies where its VDB and mesh lie
    # Promise of handoff.md: USD: a `Volume` "refers to the VDB by a relative path", and `metersPerUnit` "is 1 unless" a unit or
    #   another number is given
    def test_usd_lies_there_too(self):
        """Debian's Blender cannot read USD: what the scene says is read here as text."""
        source = corners(self.bring("pear.obj"))
        text = (self.folder / "p.usda").read_text()
        self.assertTrue(text.startswith("#usda 1.0\n"))
        self.assertEqual(text.count("{"), text.count("}"))
        self.assertIn("metersPerUnit = 1\n", text)
        up, = re.findall(r'upAxis = "([YZ])"', text)

        def turned(points):
            points = numpy.array(points, float).reshape(-1, 3)
            return numpy.stack([points[:, 0], -points[:, 2], points[:, 1]], 1) if up == "Y" else points

        def box(points):
            points = turned(points)
            return points.min(0), points.max(0)

        number = r"-?[\d.]+(?:e[-+]?\d+)?"
        points = re.search(r"point3f\[\] points = \[(.*?)\]", text, re.S).group(1)
        self.assert_same_box(source, box(re.findall(number, points)), self.voxel, "the mesh of p.usda")
        extents = re.findall(r"float3\[\] extent = \[(.*?)\]", text, re.S)
        self.assertEqual(len(extents), 2)
        # The band of the volume reaches beyond the surface.
        self.assert_same_box(source, box(re.findall(number, extents[0])), 5 * self.voxel, "the volume of p.usda")
        self.assertIn("custom rel field:surface = </fractal/volume/surface>", text)
        self.assertIn("asset filePath = @./p.vdb@", text)
        self.assertTrue((self.folder / "p.vdb").exists())

    # Promise: All files "stand upright ..."
    def test_keep_lies_on_its_back_where_blender_does_not_ask(self):
        """The files of --up keep have the target's axes: Blender turns those whose format or creator says Y up."""
        source = corners(self.bring("pear.obj"))
        self.juliavdb("mesh", "p.vdb", "-o", "k.ply", "--up", "keep")
        points, _ = pear()
        self.assert_same_box((points.min(0), points.max(0)), corners(self.bring("k.ply")), self.voxel, "k.ply")
        self.juliavdb("mesh", "p.vdb", "-o", "k.glb", "--up", "keep")
        self.assert_same_box(source, corners(self.bring("k.glb")), self.voxel, "k.glb")

    # Promise: All files "stand upright ..."
    def test_a_target_with_z_up(self):
        points, faces = pear()
        points = numpy.stack([points[:, 0], -points[:, 2], points[:, 1]], 1)
        (self.folder / "z.obj").write_text(obj_text(points, faces))
        self.juliavdb("fractal", "z.obj", *PLAIN, "--target-up", "z", "-o", "z.vdb", "--mesh", "z.ply")
        self.juliavdb("mesh", "z.vdb", "-o", "z.glb")
        box = points.min(0), points.max(0)
        for name in ("z.ply", "z.glb"):
            self.assert_same_box(box, corners(self.bring(name)), self.voxel, name)
        self.assert_same_box(box, corners(surface_of(self.bring("z.vdb"))), self.voxel, "z.vdb")
        # The same volume, turned when it is written, and turned back by Blender.
        self.juliavdb("fractal", "z.obj", *PLAIN, "--target-up", "z", "--up", "y", "-o", "y.vdb")
        volume = self.bring("y.vdb")
        self.assert_same_box(box, corners(surface_of(volume)), self.voxel, "y.vdb")

    # Promise: All files "stand upright ..."
    def test_volume_to_mesh_meets_the_mesh(self):
        self.juliavdb("fractal", "pear.obj", "--detail", "0.3", "--frequency", "coarse", "--resolution", "60",
                      "--sdf-resolution", "60", "--up", "auto", "-o", "f.vdb", "--mesh", "f.ply")
        mesh = evaluated(self.bring("f.ply"))
        tree = BVHTree.FromPolygons([mesh.matrix_world @ vertex.co for vertex in mesh.data.vertices],
                                    [tuple(polygon.vertices) for polygon in mesh.data.polygons])
        surface = evaluated(surface_of(self.bring("f.vdb")))
        far = [tree.find_nearest(surface.matrix_world @ vertex.co)[3] for vertex in surface.data.vertices]
        self.assertGreater(len(far), 1000)
        self.assertLess(max(far), 3.0 / 60)

    # Promise: All files "stand upright ..."
    def test_a_sequence_follows(self):
        sizes = (1.0, 1.3, 0.7)
        for frame, size in enumerate(sizes, 1):
            (self.folder / f"s.{frame:04d}.obj").write_text(obj_text(*pear(size)))
            self.juliavdb("fractal", f"s.{frame:04d}.obj", *PLAIN, "--frame", str(frame), "-o", "s.####.vdb")
        names = [f"s.{frame:04d}.vdb" for frame in range(1, 4)]
        bpy.ops.object.volume_import(filepath=str(self.folder / names[0]), directory=str(self.folder),
                                     files=[{"name": name} for name in names], use_sequence_detection=True)
        volume, = (thing for thing in bpy.data.objects if thing.type == "VOLUME")
        self.assertTrue(volume.data.is_sequence)
        self.assertEqual(volume.data.frame_duration, 3)
        surface = surface_of(volume)
        for frame, size in enumerate(sizes, 1):
            bpy.context.scene.frame_set(frame)
            points, _ = pear(size)
            points = numpy.stack([points[:, 0], -points[:, 2], points[:, 1]], 1)
            self.assert_same_box((points.min(0), points.max(0)), corners(surface), size * self.voxel, f"frame {frame}")
        # The same frames as USD has them.
        self.juliavdb("usd", "s.####.vdb", "--frames", "1-3", "-o", "s.usda")
        text = (self.folder / "s.usda").read_text()
        self.assertEqual(re.findall(r"(\d+): @\./(s\.\d+\.vdb)@", text), [(str(i), names[i - 1]) for i in range(1, 4)])
        self.assertIn("startTimeCode = 1\n", text)
        self.assertIn("endTimeCode = 3\n", text)

    # Promise: "Files then have the unit ..."
    def test_a_glb_has_the_size_of_its_unit(self):
        """Blender takes GLBs for metres, and so they have them. Its objects have no scale that would have to be applied."""
        self.juliavdb("mesh", "p.vdb", "-o", "in.glb", "--units", "in")
        plain, scaled = self.bring("p.glb"), self.bring("in.glb")
        self.assertEqual(tuple(scaled.scale), (1, 1, 1))
        self.assert_same_box([0.0254 * end for end in corners(plain)], corners(scaled), 1e-6, "inches")

    # Promise: The table of grid names; single names
    def test_grid_names(self):
        """The Principled Volume asks for density, temperature and, as its manual has it, color."""
        self.juliavdb("fractal", "pear.obj", *PLAIN, "--grids", "surface,density", "--attributes", "Cd,trap", "--grid-names",
                      "blender,trap=temperature", "-o", "n.vdb")
        grids = self.bring("n.vdb").data.grids
        self.assertTrue(grids.load())
        self.assertEqual({grid.name: grid.data_type for grid in grids},
                         {"surface": "FLOAT", "density": "FLOAT", "color": "VECTOR_FLOAT", "temperature": "FLOAT"})
        material = bpy.data.materials.new("fog")
        material.use_nodes = True
        shader = material.node_tree.nodes.new("ShaderNodeVolumePrincipled")
        for attribute in ("Density", "Temperature"):
            self.assertIn(shader.inputs[f"{attribute} Attribute"].default_value, grids.keys())

    # Promise: A GLB has what the mesh has, and levels ...
    def test_normals_of_a_glb_arrive(self):
        """Those of the file, at each corner of a face, so that a smooth surface looks smooth."""
        data = (self.folder / "p.glb").read_bytes()
        length = int.from_bytes(data[12:16], "little")
        head, body = json.loads(data[20:20 + length]), data[28 + length:]

        def read(name):
            """Three floats a vertex, which lie between those of other attributes."""
            accessor = head["accessors"][head["meshes"][0]["primitives"][0]["attributes"][name]]
            view = head["bufferViews"][accessor["bufferView"]]
            return numpy.ndarray((accessor["count"], 3), numpy.float32, body, view["byteOffset"] + accessor["byteOffset"],
                                 (view["byteStride"], 4))

        positions, normals = read("POSITION"), read("NORMAL")
        mesh = self.bring("p.glb").data
        if hasattr(mesh, "calc_normals_split"):   # until 4.0
            mesh.calc_normals_split()
            shown = [loop.normal.copy() for loop in mesh.loops]
        else:
            shown = [corner.vector.copy() for corner in mesh.corner_normals]
        tree = KDTree(len(positions))
        for index, (x, y, z) in enumerate(positions):
            tree.insert((x, -z, y), index)
        tree.balance()
        for loop, normal in list(zip(mesh.loops, shown))[::7]:
            _, index, far = tree.find(mesh.vertices[loop.vertex_index].co)
            self.assertLess(far, 1e-5)
            x, y, z = normals[index]
            self.assertGreater(normal.dot((x, -z, y)), 0.999)

    # Promise: A GLB has what the mesh has, and levels ...
    def test_levels_of_detail(self):
        self.juliavdb("fractal", "pear.obj", *PLAIN, "--mesh", "l.glb", "--lod", "100%,25%,5%")
        bpy.ops.import_scene.gltf(filepath=str(self.folder / "l.glb"))
        # Blender does not know the extension and brings in all levels, as objects of their own.
        counts = [len(bpy.data.objects[f"LOD{level}"].data.polygons) for level in range(3)]
        self.assertAlmostEqual(counts[1] / counts[0], 0.25, delta=0.02)
        self.assertAlmostEqual(counts[2] / counts[0], 0.05, delta=0.02)

    # Promise: A GLB has what the mesh has, and levels ...
    def test_colours_arrive(self):
        """As linear light at the vertices, within what a byte of sRGB can hold."""
        colours = {}
        for name in ("c.ply", "c.obj", "c.glb"):
            self.juliavdb("fractal", "pear.obj", *PLAIN, "--up", "auto", "--attributes", "Cd", "--mesh", name)
            thing = self.bring(name)
            data = thing.data
            self.assertEqual(len(data.color_attributes), 1, name)
            attribute = data.color_attributes[0]
            at_points = attribute.domain == "POINT"
            values = {}
            for index, element in enumerate(attribute.data):
                vertex = index if at_points else data.loops[index].vertex_index
                place = tuple(round(c, 4) for c in thing.matrix_world @ data.vertices[vertex].co)
                values[place] = numpy.array(element.color[:3])
            colours[name] = values
        for name in ("c.obj", "c.glb"):
            shared = set(colours["c.ply"]) & set(colours[name])
            self.assertGreater(len(shared), 0.9 * len(colours["c.ply"]))
            worst = max(numpy.abs(colours["c.ply"][place] - colours[name][place]).max() for place in shared)
            self.assertLess(worst, 0.02, name)
        spread = numpy.ptp(numpy.array(list(colours["c.ply"].values())), axis=0)
        self.assertGreater(spread.min(), 0.1, "the colours differ from place to place")

    def render(self, name, samples=8):
        scene = bpy.context.scene
        scene.render.engine = "CYCLES"
        scene.cycles.device = "CPU"
        scene.cycles.samples = samples
        scene.cycles.use_denoising = False
        scene.render.resolution_x = scene.render.resolution_y = self.SIZE
        scene.render.resolution_percentage = 100
        scene.render.filepath = str(self.folder / name)
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = numpy.array(image.pixels[:]).reshape(self.SIZE, self.SIZE, 4)
        if "JULIAVDB_PICTURES" in os.environ:
            shutil.copy(scene.render.filepath, os.environ["JULIAVDB_PICTURES"])
        return pixels

    def stage(self):
        scene = bpy.context.scene
        world = bpy.data.worlds.new("world")
        world.use_nodes = True
        world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.05, 0.06, 0.08, 1)
        scene.world = world
        sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
        sun.data.energy = 2.5
        sun.rotation_euler = (0.9, 0.1, 0.6)
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        camera.location = (0.3, -6.5, 0.8)
        camera.rotation_euler = (numpy.pi / 2, 0, 0)
        for thing in (sun, camera):
            scene.collection.objects.link(thing)
        scene.camera = camera

    def test_a_picture(self):
        """The fractal and its volume side by side, upright, as Cycles shows them."""
        self.juliavdb("fractal", "pear.obj", "--detail", "0.35", "--resolution", "80", "--sdf-resolution", "80", "--up",
                      "auto", "--grids", "surface,density", "-o", "c.vdb", "--mesh", "c.glb")
        self.stage()
        mesh, volume = self.bring("c.glb"), self.bring("c.vdb")
        mesh.matrix_world.translation.x -= 1.2
        volume.matrix_world.translation.x += 1.2
        material = bpy.data.materials.new("fog")
        material.use_nodes = True
        nodes = material.node_tree.nodes
        nodes.clear()
        output, fog = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeVolumePrincipled")
        fog.inputs["Density"].default_value = 20
        fog.inputs["Color"].default_value = (0.9, 0.5, 0.2, 1)
        material.node_tree.links.new(fog.outputs["Volume"], output.inputs["Volume"])
        volume.data.materials.append(material)
        pixels = self.render("handoff_blender.png")
        seen = numpy.abs(pixels - pixels[0, 0]).max(2) > 0.1
        half = self.SIZE // 2
        for columns, what in ((slice(0, half), "mesh"), (slice(half, None), "volume")):
            lit = seen[:, columns]
            self.assertGreater(lit.mean(), 0.05, what)
            rows = numpy.nonzero(lit.any(1))[0]
            across = numpy.nonzero(lit.any(0))[0]
            self.assertGreater(numpy.ptp(rows), 1.2 * numpy.ptp(across), f"the {what} stands upright")


if __name__ == "__main__":
    in_blender.main("handoff_test")

# SPDX-License-Identifier: Apache-2.0
"""Animated glTF as targets: --target-frame, and sequences of their frames.

The files are written here, and what they show is computed here again with NumPy, by other formulas than the program's: turns as
axes and angles, not as quaternions.
"""

import base64
import json
import math

import numpy
import pyopenvdb

import harness
from harness import BAD_DATA, USAGE

FPS = 24
VOXEL = 0.1


def ball(centre, radius, stretch):
    points, faces = harness.sphere(2)
    return numpy.array(points) * radius * numpy.array(stretch) + numpy.array(centre), numpy.array(faces)


def quaternion(axis, angle):
    axis = numpy.array(axis, float) / numpy.linalg.norm(axis)
    return [*(axis * math.sin(angle / 2)), math.cos(angle / 2)]


def turn(axis, angle):
    """The matrix of a turn, by the formula of Rodrigues."""
    x, y, z = numpy.array(axis, float) / numpy.linalg.norm(axis)
    cross = numpy.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return numpy.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def affine(linear=None, move=(0, 0, 0)):
    matrix = numpy.eye(4)
    matrix[:3, :3] = numpy.eye(3) if linear is None else linear
    matrix[:3, 3] = move
    return matrix


def apply(matrix, points):
    return points @ matrix[:3, :3].T + matrix[:3, 3]


class Gltf:
    """A glTF with its buffer inside."""

    def __init__(self):
        self.data = b""
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
                     "accessors": [], "bufferViews": []}

    def view(self, array):
        self.data += b"\0" * (-len(self.data) % 4)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": array.nbytes})
        self.data += array.tobytes()
        return len(self.json["bufferViews"]) - 1

    def accessor(self, array, kind, **more):
        array = numpy.ascontiguousarray(array)
        codes = {"float32": 5126, "uint32": 5125, "uint16": 5123, "uint8": 5121}
        self.json["accessors"].append({"bufferView": self.view(array), "componentType": codes[array.dtype.name],
                                       "count": len(array), "type": kind, **more})
        return len(self.json["accessors"]) - 1

    def floats(self, array, kind):
        return self.accessor(numpy.array(array, "<f4"), kind)

    def sparse(self, array):
        """Vectors of which most are 0."""
        array = numpy.array(array, "<f4")
        where = numpy.flatnonzero(numpy.abs(array).max(1))
        self.json["accessors"].append({
            "componentType": 5126, "count": len(array), "type": "VEC3",
            "sparse": {"count": len(where),
                       "indices": {"bufferView": self.view(where.astype("<u2")), "componentType": 5123},
                       "values": {"bufferView": self.view(array[where])}}})
        return len(self.json["accessors"]) - 1

    def mesh(self, points, faces, attributes=None, **primitive):
        more = primitive.pop("of_mesh", {})
        self.json["meshes"].append({"primitives": [{
            "attributes": {"POSITION": self.floats(points, "VEC3"), **(attributes or {})},
            "indices": self.accessor(numpy.array(faces, "<u4").reshape(-1), "SCALAR"), **primitive}], **more})
        return len(self.json["meshes"]) - 1

    def node(self, root=True, **node):
        self.json["nodes"].append(node)
        if root:
            self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)
        return len(self.json["nodes"]) - 1

    def animation(self, name, channels):
        """@param channels  node, path, interpolation, times in frames, values, their type"""
        made = {"name": name, "channels": [], "samplers": []}
        for node, path, how, times, values, kind in channels:
            made["channels"].append({"sampler": len(made["samplers"]), "target": {"node": node, "path": path}})
            made["samplers"].append({"input": self.floats(numpy.array(times) / FPS, "SCALAR"), "interpolation": how,
                                     "output": self.floats(values, kind)})
        self.json.setdefault("animations", []).append(made)

    def text(self):
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        return json.dumps({**self.json, "buffers": [{"byteLength": len(self.data), "uri": uri}]})


# Of three balls apart: one is moved by its nodes, one bends, one grows a bump.
FIRST, SECOND, THIRD = ball((0.2, 0, 0), 0.5, (1, 0.8, 0.6)), ball((0, 1, 0), 0.5, (0.7, 2, 0.8)), ball((0, 0, 0), 0.6, (1, 1, 1))
AXIS = (1, 2, -1)
BIND = (0, 1, 0)   # where the second joint is
WEIGHTS = numpy.clip(SECOND[0][:, 1], 0, 2) / 2   # of the second joint
BUMPS = [numpy.where(THIRD[0][:, :1] > 0.3, numpy.array([[0.3, 0, 0]]), 0), numpy.where(THIRD[0][:, 2:] < -0.2, THIRD[0], 0)]


def walk():
    gltf = Gltf()
    child = gltf.node(root=False, mesh=gltf.mesh(*FIRST), scale=[1, 1, 1.5])
    parent = gltf.node(children=[child], translation=[-2, 0, 0], rotation=quaternion((0, 0, 1), 0.5))
    top = gltf.node(root=False, translation=[0, 1, 0])
    bottom = gltf.node(children=[top], translation=[1.5, 0.3, 0])
    joints = numpy.zeros((len(SECOND[0]), 4), "u1")
    joints[:, 1] = 1
    shares = numpy.zeros((len(SECOND[0]), 4))
    shares[:, 0], shares[:, 1] = 1 - WEIGHTS, WEIGHTS
    skinned = gltf.mesh(*SECOND, {"JOINTS_0": gltf.accessor(joints, "VEC4"), "WEIGHTS_0": gltf.floats(shares, "VEC4")})
    binds = [affine(), affine(move=[-b for b in BIND])]
    gltf.json["skins"] = [{"joints": [bottom, top],
                           "inverseBindMatrices": gltf.floats([m.T.reshape(-1) for m in binds], "MAT4")}]
    # Where a node with a skin stands has no meaning.
    gltf.node(mesh=skinned, skin=0, translation=[50, 60, 70])
    grown = gltf.mesh(*THIRD, targets=[{"POSITION": gltf.sparse(BUMPS[0])}, {"POSITION": gltf.floats(BUMPS[1], "VEC3")}],
                      of_mesh={"weights": [0, 0.25]})
    bump = gltf.node(mesh=grown, translation=[4, 0, 0])
    gltf.animation("walk", [
        (parent, "rotation", "LINEAR", [12, 36], [quaternion(AXIS, 0.5), [-q for q in quaternion(AXIS, 2.1)]], "VEC4"),
        (parent, "translation", "CUBICSPLINE", [12, 36],
         [[0, 0, 0], [-2, 0, 0], [2, 0, 0], [0, -3, 0], [-3, 1, 0], [0, 0, 0]], "VEC3"),
        (child, "scale", "STEP", [0, 20, 30], [[1, 1, 1], [1.4, 1, 1], [1, 1, 0.7]], "VEC3"),
        (top, "rotation", "LINEAR", [0, 24, 48], [quaternion((0, 0, 1), angle) for angle in (0, 0.8, -0.4)], "VEC4"),
        (bump, "weights", "LINEAR", [6, 24], [0, 0, 1, 0.5], "SCALAR")])
    gltf.animation("jump", [(parent, "translation", "LINEAR", [0, 24], [[-2, 0, 0], [-2, 2, 0]], "VEC3")])
    return gltf


def blend(times, values, frame):
    """Between keys along straight lines, and still outside."""
    return numpy.array([numpy.interp(frame, times, column) for column in numpy.array(values, float).T])


def spline(frame):
    u, step = (frame - 12) / 24, 24 / FPS
    if not 0 < u < 1:
        return numpy.array([-2.0, 0, 0] if u <= 0 else [-3.0, 1, 0])
    ends = numpy.array([[-2, 0, 0], [-3, 1, 0]], float)
    slopes = numpy.array([[2, 0, 0], [0, -3, 0]], float) * step
    # The cubic with these ends and slopes, by its coefficients.
    c = 3 * (ends[1] - ends[0]) - 2 * slopes[0] - slopes[1]
    d = 2 * (ends[0] - ends[1]) + slopes[0] + slopes[1]
    return ends[0] + slopes[0] * u + c * u**2 + d * u**3


def shown(frame):
    """The mesh of a frame of walk(); without a frame as the file stands."""
    if frame is None:
        outer, scale, bend, weights = affine(turn((0, 0, 1), 0.5), [-2, 0, 0]), (1, 1, 1.5), 0, (0, 0.25)
    else:
        angle = blend([12, 36], [[0.5], [2.1]], frame)[0]
        outer = affine(turn(AXIS, angle), spline(frame))
        scale = (1, 1, 1) if frame < 20 else (1.4, 1, 1) if frame < 30 else (1, 1, 0.7)
        bend = blend([0, 24, 48], [[0], [0.8], [-0.4]], frame)[0]
        weights = blend([6, 24], [[0, 0], [1, 0.5]], frame)
    first = apply(outer, FIRST[0] * scale)
    straight = SECOND[0] + [1.5, 0.3, 0]
    bent = apply(affine(turn((0, 0, 1), bend)), SECOND[0] - BIND) + [1.5, 1.3, 0]
    second = (1 - WEIGHTS[:, None]) * straight + WEIGHTS[:, None] * bent
    third = THIRD[0] + weights[0] * BUMPS[0] + weights[1] * BUMPS[1] + [4, 0, 0]
    offsets = numpy.cumsum([0, len(first), len(second)])
    return (numpy.concatenate([first, second, third]),
            numpy.concatenate([mesh[1] + offset for mesh, offset in zip((FIRST, SECOND, THIRD), offsets)]))


def obj_text(points, faces):
    return "".join(f"v {x:.17g} {y:.17g} {z:.17g}\n" for x, y, z in points) + "".join(
        f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces)


class Animation(harness.CliTest):
    # The target itself, as a level set of two voxels and more on both sides.
    PLAIN = ("--mask", 0, "--voxel-size", VOXEL, "--sdf-voxel-size", VOXEL / 2, "--up", "keep")
    SMALL = ("--resolution", 30, "--sdf-resolution", 100)
    EVEN = ("--voxel-size", 0.1, "--sdf-resolution", 100)  # in all frames

    def setUp(self):
        super().setUp()
        self.write("walk.gltf", walk().text())

    def distances(self, file):
        """Those of the surface, in world units, at the nodes of a box that holds all frames."""
        grid = pyopenvdb.read(str(self.path(file)), "surface")
        values = numpy.zeros((120, 80, 80))
        low = grid.transform.worldToIndex((-5, -3, -3))
        grid.copyToArray(values, ijk=[round(x) for x in low])
        return values

    def assert_shows(self, frame, *words):
        self.write("expected.obj", obj_text(*shown(frame)))
        self.ok("fractal", "expected.obj", *self.PLAIN, "-o", "expected.vdb")
        self.ok("fractal", "walk.gltf", *self.PLAIN, "-o", "found.vdb", *words)
        expected, found = self.distances("expected.vdb"), self.distances("found.vdb")
        self.assertGreater((abs(expected) < VOXEL).sum(), 1000)
        self.assertLess(abs(expected - found).max(), VOXEL / 100, f"frame {frame}")

    # Promise of targets.md: Nodes, skins and morph targets of a glTF at a frame, "with steps, lines or cubic splines between
    #   keys"; without one they "are as the file has them"
    def test_a_frame_is_what_python_computes(self):
        """Nodes, skins and morph targets; lines, steps and splines; before, between and after the keys."""
        for frame in (0, 12, 17.5, 29, 36, 100):
            self.assert_shows(frame, "--target-frame", frame)
        self.assert_shows(18, "--target-frame", 9, "--target-fps", FPS / 2)
        self.assert_shows(18, "--target-frame", 18, "--target-animation", "walk")

    # Promise: Nodes, skins and morph targets ...
    def test_without_a_frame_nodes_stand_as_the_file_says(self):
        """Skins and weights of morph targets count there, too."""
        self.assert_shows(None)

    # Promise: `--frames` plays an animated ...
    def test_animations_are_chosen(self):
        """By name and by number; several at once are those one after the other."""
        def made(*words):
            self.ok("fractal", "walk.gltf", "--mesh", "a.stl", "--target-frame", 18, *self.SMALL, *words)
            return self.bytes("a.stl")

        walks, jumps = made("--target-animation", "walk"), made("--target-animation", "jump")
        self.assertNotEqual(walks, jumps)
        self.assertEqual(made(), walks)
        self.assertEqual(made("--target-animation", 1), jumps)
        self.assertNotIn(made("--target-animation", "all"), (walks, jumps))

    # Promise of targets.md#animated-gltf: `--frames` plays an animated glTF; `--target-frame`, `--target-fps` and
    #   `--target-animation` choose the moment
    def test_a_sequence_is_the_frames_one_by_one(self):
        self.ok("fractal", "walk.gltf", "--frames", "12,20", "-o", "f.####.vdb", *self.EVEN)
        self.assertNotEqual(self.bytes("f.0012.vdb"), self.bytes("f.0020.vdb"))
        for frame in (12, 20):
            self.ok("fractal", "walk.gltf", "--target-frame", frame, "-o", "one.vdb", *self.EVEN)
            self.assertEqual(self.bytes("one.vdb"), self.bytes(f"f.{frame:04}.vdb"))
        self.ok("fractal", "--config", "f.0020.vdb", "-o", "one.vdb")
        self.assertEqual(self.bytes("one.vdb"), self.bytes("f.0020.vdb"))
        self.ok("plan", "frames", "walk.gltf", "-o", "plan", "--frames", "12,20", *self.EVEN)
        self.ok("task", "plan", "--range", "1-2")
        for frame in (12, 20):
            self.assertEqual(self.bytes(f"plan/out/walk.{frame:04}.vdb"), self.bytes(f"f.{frame:04}.vdb"))
        self.assertIn("kept 2 of 2 frames", self.ok("fractal", "walk.gltf", "--frames", "12,20", "-o", "f.####.vdb", *self.EVEN))
        self.assertIn("kept 0 of 2 frames", self.ok(
            "fractal", "walk.gltf", "--frames", "12,20", "-o", "f.####.vdb", "--target-fps", 30, *self.EVEN))

    # Promise: `--frames` plays an animated ...
    def test_keys_change_the_time(self):
        self.ok("fractal", "walk.gltf", "--frames", "1-3", "--key", "target-frame@1=12", "--key", "target-frame@3=13",
                "-o", "f.####.vdb", *self.EVEN)
        self.ok("fractal", "walk.gltf", "--target-frame", 12.5, "-o", "one.vdb", *self.EVEN)
        self.assertEqual(self.bytes("one.vdb"), self.bytes("f.0002.vdb"))

    # Promise: `--frames` plays an animated ...
    def test_info_lists_animations(self):
        found = self.info("walk.gltf")["animations"]
        self.assertEqual([each["name"] for each in found], ["walk", "jump"])
        numpy.testing.assert_allclose(found[0]["seconds"], [0, 2])

    # Promise: `--frames` plays an animated ...
    def test_what_cannot_be_is_refused(self):
        self.write("still.obj", harness.obj(harness.cube()))
        still = Gltf()
        still.node(mesh=still.mesh(*FIRST))
        self.write("still.gltf", still.text())
        out = ("-o", "x.vdb")
        self.refused(USAGE, "fractal", "still.obj", "--target-frame", 3, *out, mentions=("--target-frame", "still.obj"))
        self.refused(USAGE, "fractal", "walk.gltf", "--target-fps", 30, *out, mentions=("--target-fps", "--target-frame"))
        self.refused(USAGE, "fractal", "walk.gltf", "--target-frame", 3, "--target-fps", 0, *out, mentions="target-fps")
        self.refused(BAD_DATA, "fractal", "still.gltf", "--target-frame", 3, *out, mentions=("still.gltf", "no animation"))
        self.refused(BAD_DATA, "fractal", "walk.gltf", "--target-frame", 3, "--target-animation", "swim", *out,
                     mentions=("'swim'", "'walk', 'jump'"))

    # Promise: `--frames` plays an animated ...
    def test_damaged_animations_are_refused(self):
        """The nodes of walk() are: the first ball, its parent, two joints, the ball with the skin, and the one that grows."""
        first = "animations/0/"
        cases = ((first + "channels/0/target/path", "colour", "'colour'"), (first + "channels/0/sampler", 99, "sampler 99"),
                 (first + "channels/0/target/node", 99, "'nodes'"), (first + "samplers/0/interpolation", "BEZIER", "'BEZIER'"),
                 (first + "samplers/0/input", 0, "no times"), (first + "samplers/0/output", 1, "do not fit"),
                 (first + "samplers/4/output", 0, "morph targets"), (first + "channels", 7, "'channels' is not a list"),
                 ("nodes/1/matrix", numpy.eye(4).reshape(-1).tolist(), "matrix"), ("skins/0/joints", [], "no joints"),
                 ("skins/0/joints", [3, 99], "'nodes'"), ("skins/0/inverseBindMatrices", 0, "matrices"),
                 ("nodes/4/skin", 5, "'skins'"), ("nodes/3/children", [0], "twice"),
                 ("meshes/1/primitives/0/attributes/JOINTS_0", 0, "four numbers"), ("meshes/2/primitives/0/targets", [], "targets"))
        for path, value, why in cases:
            with self.subTest(path=path, value=value):
                gltf = walk()
                *way, last = [int(part) if part.isdigit() else part for part in path.split("/")]
                place = gltf.json
                for part in way:
                    place = place[part]
                place[last] = value
                self.write("odd.gltf", gltf.text())
                self.refused(BAD_DATA, "fractal", "odd.gltf", "--target-frame", 13, "-o", "x.vdb", mentions=why)


if __name__ == "__main__":
    harness.main()

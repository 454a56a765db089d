# SPDX-License-Identifier: Apache-2.0
"""Scenes of USD: the meshes of frames, and packages. The text is read here by itself, and packages by Python's zipfile."""

import re
import shutil
import struct
import zipfile

import harness
from harness import BAD_DATA, NO_INPUT, USAGE


def single(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def numbers(text):
    return [float(word) for word in re.findall(r"-?[\d.]+(?:e[-+]?\d+)?", text)]


def triples(values):
    return list(zip(values[0::3], values[1::3], values[2::3]))


def value_of(text, declaration):
    """An attribute: a list of numbers, or a list for each frame."""
    samples = re.search(re.escape(declaration) + r"\.timeSamples = \{(.*?)\n +\}", text, re.S)
    if samples:
        return {int(frame): numbers(value) for frame, value in re.findall(r"(-?\d+): \[(.*?)\]", samples.group(1), re.S)}
    return numbers(re.search(re.escape(declaration) + r" = \[(.*?)\]", text, re.S).group(1))


class Usd(harness.CliTest):

    def setUp(self):
        super().setUp()
        # Neither the points nor the triangles of two frames are the same.
        self.meshes = {-1: harness.lumpy(), 0: harness.torus(), 2: harness.cube(2)}
        for frame, mesh in self.meshes.items():
            sign = "-" if frame < 0 else ""
            self.write(f"m.{sign}{abs(frame):04}.obj", harness.obj(mesh))

    def make(self, *words):
        self.ok("usd", *words, "-o", "s.usda")
        return self.bytes("s.usda").decode()

    # Promise of handoff.md: For the frames of a mesh "its points, triangles, normals and colours are time samples", and what has
    #   no place for the frame "stays the same in all frames"
    def test_each_frame_has_its_mesh(self):
        text = self.make("--mesh", "m.####.obj", "--frames", "2,-1-0", "--fps", 25)
        for line in ("startTimeCode = -1\n", "endTimeCode = 2\n", "framesPerSecond = 25\n", "timeCodesPerSecond = 25\n"):
            self.assertIn(line, text)
        self.assertEqual(text.count("{"), text.count("}"))
        points, indices = value_of(text, "point3f[] points"), value_of(text, "int[] faceVertexIndices")
        counts, normals = value_of(text, "int[] faceVertexCounts"), value_of(text, "normal3f[] normals")
        extents = value_of(text, "float3[] extent")
        self.assertIn('normal3f[] normals (\n            interpolation = "vertex"\n        )\n', text)
        for values in (points, indices, counts, normals, extents):
            self.assertEqual(list(values), [-1, 0, 2])
        for frame, (corners, faces) in self.meshes.items():
            made = triples(list(map(single, points[frame])))
            self.assertEqual(made, [tuple(map(single, point)) for point in corners], frame)
            self.assertEqual(counts[frame], [3] * len(counts[frame]))
            self.assertEqual(triples(indices[frame]), [tuple(face) for face in faces], frame)
            self.assertEqual(len(normals[frame]), 3 * len(corners))
            low, high = triples(list(map(single, extents[frame])))
            for k in range(3):
                self.assertEqual((low[k], high[k]), (min(p[k] for p in made), max(p[k] for p in made)))

    # Promise: For the frames of a mesh ...
    def test_a_frame_is_the_mesh_of_a_scene_by_itself(self):
        """With colours and another up axis."""
        for frame, seed in ((1, 4), (2, 5)):
            self.ok("fractal", "m.0000.obj", "--mesh", f"c.{frame:04}.ply", "--resolution", 14, "--sdf-resolution", 16,
                    "--texture-seed", seed, "--attributes", "Cd", "--up", "z")
        moving = self.make("--mesh", "c.####.ply", "--frames", "1-2")
        for frame in (1, 2):
            still = self.make("--mesh", f"c.{frame:04}.ply")
            self.assertIn('upAxis = "Z"', still)
            self.assertIn('upAxis = "Z"', moving)
            for declaration in ("point3f[] points", "int[] faceVertexIndices", "int[] faceVertexCounts", "normal3f[] normals",
                                "color3f[] primvars:displayColor", "float3[] extent"):
                self.assertEqual(value_of(moving, declaration)[frame], value_of(still, declaration), declaration)
        self.ok("sdf", "m.0000.obj", "-o", "c.0003.vdb", "--resolution", 16)
        self.ok("mesh", "c.0003.vdb", "-o", "c.0003.ply")
        self.refused(BAD_DATA, "usd", "--mesh", "c.####.ply", "--frames", "1-3", "-o", "n.usda",
                     mentions=("c.0003.ply", "no colours"))

    def test_attributes_of_the_points_are_primvars(self):
        """Numbers, vectors and texture coordinates, by the names that fractal and glTF give them; of frames, those that all have."""
        corners, faces = harness.cube()
        low = ("--resolution", 14, "--sdf-resolution", 16)
        words = ("fractal", "m.0000.obj", *low, "--attributes", "Cd,direction,trap,depth")
        self.ok(*words, "--mesh", "a.ply", "-o", "a.vdb")
        self.ok(*words, "--mesh", "a.glb")
        text = self.make("--mesh", "a.ply")
        scene = {name: value_of(text, f"{kind}[] primvars:{name}")
                 for kind, name in (("float", "trap"), ("float", "depth"), ("float3", "direction"), ("color3f", "displayColor"))}
        self.assertEqual(sorted(re.findall(r"primvars:(\w+) =", text)), sorted(scene))
        self.assertEqual(text.count('interpolation = "vertex"'), 1 + len(scene), "the normals and each of them")
        points = len(value_of(text, "point3f[] points")) // 3
        self.assertEqual({name: len(values) // points for name, values in scene.items()},
                         {"trap": 1, "depth": 1, "direction": 3, "displayColor": 3})
        of_glb = self.make("--mesh", "a.glb")
        for kind, name in (("float", "trap"), ("float", "depth"), ("float3", "direction")):
            self.assertEqual(value_of(of_glb, f"{kind}[] primvars:{name}"), scene[name], name)
        head = "ply\nformat ascii 1.0\nelement vertex 8\n"
        table = "".join(f"property float {name}\n" for name in ("x", "y", "z", "s", "t", "wet", "wind_x", "wind_y"))
        rows = "".join(f"{x} {y} {z} {x / 4} {y / 4} {i} nan {-i}\n" for i, (x, y, z) in enumerate(corners))
        tail = f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
        for frame, extra in ((1, table), (2, table.replace("wet", "dry"))):
            self.write(f"p.{frame:04}.ply", head + extra + tail + rows + "".join(f"3 {a} {b} {c}\n" for a, b, c in faces))
        text = self.make("--mesh", "p.0001.ply")
        self.assertEqual(value_of(text, "float[] primvars:wet"), list(map(float, range(8))))
        self.assertEqual(value_of(text, "texCoord2f[] primvars:st"),
                         [value / 4 for face in faces for corner in face for value in corners[corner][:2]], "one for each corner")
        self.assertEqual(text.count('interpolation = "faceVarying"'), 1)
        self.assertEqual(value_of(text, "float[] primvars:wind_y"), [-float(i) for i in range(8)], "two of three are no vector")
        self.assertIn("primvars:wind_x = [" + ", ".join(["nan"] * 8) + "]", text)
        text = self.make("--mesh", "p.####.ply", "--frames", "1-2")
        self.assertEqual(sorted(re.findall(r"primvars:(\w+)\.timeSamples", text)), ["st", "wind_x", "wind_y"])

    # Promise: For the frames of a mesh ...
    def test_far_from_the_origin_all_frames_have_one_place(self):
        points, faces = harness.cube()
        for frame, shift in ((1, 1e6), (2, 1e6 + 0.25)):
            self.write(f"f.{frame:04}.obj", harness.obj(([(x + shift, y, z) for x, y, z in points], faces)))
        text = self.make("--mesh", "f.####.obj", "--frames", "1-2")
        centre = numbers(re.search(r"double3 xformOp:translate = \((.*?)\)", text).group(1))
        made = value_of(text, "point3f[] points")
        for frame, shift in ((1, 1e6), (2, 1e6 + 0.25)):
            for point, (x, y, z) in zip(triples(made[frame]), points):
                for there, wanted, origin in zip(point, (x + shift, y, z), centre):
                    self.assertAlmostEqual(there + origin, wanted, 6)

    # Promise: For the frames of a mesh ...
    def test_what_has_no_place_for_the_frame_is_held(self):
        self.ok("sdf", "m.0000.obj", "-o", "v.vdb", "--resolution", 16)
        for frame in (1, 2):
            shutil.copy(self.path("v.vdb"), self.path(f"v.{frame:04}.vdb"))
            self.write(f"m.{frame:04}.obj", harness.obj(harness.cube(frame)))
        text = self.make("v.vdb", "--mesh", "m.####.obj", "--frames", "1-2")
        self.assertIn("asset filePath = @./v.vdb@", text)
        self.assertEqual(list(value_of(text, "point3f[] points")), [1, 2])
        text = self.make("v.####.vdb", "--mesh", "m.0002.obj", "--frames", "1-2")
        self.assertEqual(re.findall(r"(\d+): @\./(v\.\d+\.vdb)@", text), [("1", "v.0001.vdb"), ("2", "v.0002.vdb")])
        self.assertEqual(len(value_of(text, "point3f[] points")), 3 * 8)
        text = self.make("v.vdb", "--mesh", "m.0002.obj", "--frames", "-3-4")
        self.assertIn("startTimeCode = -3\n", text)
        self.assertIn("endTimeCode = 4\n", text)
        self.assertNotIn("timeSamples", text)

    def check_package(self, name):
        """@return the text of its scene"""
        data = self.bytes(name)
        with zipfile.ZipFile(self.path(name)) as package:
            self.assertIsNone(package.testzip())
            entry, = package.infolist()
            self.assertEqual(entry.compress_type, zipfile.ZIP_STORED)
            self.assertEqual(entry.flag_bits & 1, 0, "encrypted")
            text = package.read(entry)
        # zipfile reads the list at the end. What lies before the data says the same, and the data is aligned.
        mark, _, _, method, _, _, checksum, size, stored, length, extra = struct.unpack_from("<IHHHHHIIIHH", data)
        begin = 30 + length + extra
        self.assertEqual((mark, method, checksum, size, stored), (0x04034b50, 0, entry.CRC, len(text), len(text)))
        self.assertEqual(data[30:30 + length].decode(), entry.filename)
        self.assertEqual(begin % 64, 0)
        self.assertEqual(data[begin:begin + size], text)
        self.assertTrue(entry.filename.endswith(".usda"))
        self.assertTrue(text.startswith(b"#usda 1.0\n"))
        return text

    # Promise of handoff.md: A package is "a ZIP without compression in which the data of each file begins at a multiple of 64
    #   bytes"
    def test_a_package_holds_the_scene(self):
        words = ("--mesh", "m.####.obj", "--frames", "-1-0,2")
        self.ok("usd", *words, "-o", "s.usda", "--package", "p.usdz")
        self.assertEqual(self.check_package("p.usdz"), self.bytes("s.usda"))
        self.ok("usd", *words, "--package", "again.usdz")
        self.assertEqual(self.check_package("again.usdz"), self.bytes("s.usda"))
        # The padding before the data depends on the length of the name.
        for length in (1, *range(25, 31), 90):
            name = "n" * length + ".usdz"
            self.ok("usd", "--mesh", "m.0002.obj", "--package", name)
            self.check_package(name)
        self.ok("usd", "--mesh", "m.0002.obj", "--package", "\u00e9t\u00e9.usdz")
        self.check_package("\u00e9t\u00e9.usdz")

    # Promise: A package is "a ZIP without ..."
    def test_what_does_not_fit(self):
        self.ok("sdf", "m.0000.obj", "-o", "v.vdb", "--resolution", 16)
        for words, mention in ((("v.vdb", "--package", "p.usdz"), "--package"),
                               (("v.vdb", "--mesh", "m.0000.obj", "-o", "s.usda", "--package", "p.usdz"), "no VDB"),
                               (("--mesh", "m.0000.obj", "--package", "p.zip"), ".usdz"),
                               (("--mesh", "m.0000.obj", "-o", "p.usdz"), ".usda"),
                               (("--mesh", "m.0000.obj"), "--package"),
                               (("--mesh", "m.####.obj", "-o", "s.usda"), "--frames"),
                               (("--mesh", "m.0000.obj", "-o", "s.usda", "--fps", 25), "--fps"),
                               (("--mesh", "m.0000.obj", "-o", "s.usda", "--frames", "2-1"), "--frames is '2-1'"),
                               (("--mesh", "m.##.##.obj", "-o", "s.usda", "--frames", "1"), "more than one frame pattern")):
            self.refused(USAGE, "usd", *words, mentions=mention)
        self.refused(NO_INPUT, "usd", "v.vdb", "--mesh", "m.####.obj", "-o", "s.usda", "--frames", "-1-2",
                     mentions="'m.0001.obj' (frame 1)")


if __name__ == "__main__":
    harness.main()

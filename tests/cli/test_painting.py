# SPDX-License-Identifier: Apache-2.0
"""Controls that are painted: vertex attributes, pictures, other meshes and formulas, through the whole program."""

import math
import struct
import subprocess
import zlib

import harness
from harness import BAD_DATA, INTERNAL, NO_INPUT, USAGE

SMALL = ("--resolution", 50, "--sdf-resolution", 40)


def painted_ply(mesh, names, values):
    """@param values: of each point, one for each name"""
    points, faces = mesh
    rows = ("{!r} {!r} {!r} {}\n".format(*p, " ".join(map(str, values(p)))) for p in points)
    return (f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n"
            "property float x\nproperty float y\nproperty float z\n" +
            "".join(f"property {name}\n" for name in names) + f"element face {len(faces)}\n"
            "property list uchar int vertex_indices\nend_header\n" + "".join(rows) + "".join(
                "3 {} {} {}\n".format(*f) for f in faces))


def png(width, height, pixel):
    """8-bit RGB. @param pixel: (column, row from the top) -> (r, g, b)"""
    rows = b"".join(b"\0" + bytes(c for x in range(width) for c in pixel(x, y)) for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)) + chunk(
        b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


class Painting(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.ball = harness.sphere(3)
        # Red on the side of +x, as bytes; a slope along y, as floats.
        self.write("ball.ply", painted_ply(self.ball, ["uchar red", "float slope"],
                                           lambda p: (255 if p[0] > 0 else 0, p[1] / 2 + 0.5)))

    def roughness(self, name, side):
        """How far the surface's points are from the ball, in the mean, where side(point) is true."""
        mesh = harness.read_ply(self.bytes(name))
        found = [abs(math.hypot(*p) - 1) for p in mesh.points if side(p)]
        self.assertGreater(len(found), 200, "nearly no surface is there")
        return sum(found) / len(found)

    def make(self, name, alpha, *options, target="ball.ply"):
        small = SMALL[:2] if target.endswith(".vdb") else SMALL
        return self.ok("fractal", target, "--alpha", alpha, *small, *options, "--mesh", name)

    def sides(self, name, axis):
        """@return the roughness on the side where the axis is negative, and where it is positive"""
        return (self.roughness(name, lambda p: p[axis] < -0.2), self.roughness(name, lambda p: p[axis] > 0.2))

    def test_a_painted_half_is_smooth_and_the_other_rough(self):
        self.make("a.ply", "paint:red:8:300")
        rough, smooth = self.sides("a.ply", 0)
        self.assertLess(smooth, 0.02, "half a voxel")
        self.assertGreater(rough, 4 * smooth)
        self.make("b.ply", "paint:red:300:8")
        smooth, rough = self.sides("b.ply", 0)
        self.assertGreater(rough, 4 * smooth)

    def test_another_mesh_and_a_target_of_distances(self):
        self.ok("sdf", "ball.ply", "-o", "ball.vdb", "--resolution", 32)
        self.make("a.ply", "paint:red@ball.ply:8:300", target="ball.vdb")
        rough, smooth = self.sides("a.ply", 0)
        self.assertGreater(rough, 4 * smooth)
        text = self.refused(BAD_DATA, "fractal", "ball.vdb", "--alpha", "paint:red:8:300", *SMALL[:2], "--mesh", "b.ply")
        self.assertIn("paint:red@FILE", text)

    # Promise: "At every place the value ..."
    def test_an_open_mesh_that_is_repaired(self):
        points, faces = harness.with_hole(self.ball, 0.95)
        self.write("open.ply", painted_ply((points, faces), ["uchar red"], lambda p: (255 if p[0] > 0 else 0,)))
        self.make("a.ply", "paint:red:8:300", "--repair", target="open.ply")
        rough, smooth = self.sides("a.ply", 0)
        self.assertGreater(rough, 4 * smooth)

    # Promise: Attributes and pictures have ...
    def test_a_picture_through_texture_coordinates(self):
        # Seen along z, the picture's lower half is black.
        points, faces = self.ball
        self.write("ball.obj", "".join("v {!r} {!r} {!r}\n".format(*p) for p in points) +
                   "".join(f"vt {p[0] / 2 + 0.5!r} {p[1] / 2 + 0.5!r}\n" for p in points) +
                   "".join("f {0}/{0} {1}/{1} {2}/{2}\n".format(*(k + 1 for k in f)) for f in faces))
        self.write("halves.png", png(32, 32, lambda x, y: (0, 0, 0) if y >= 16 else (255, 255, 255)))
        self.make("a.ply", "texture:halves.png:8:300", target="ball.obj")
        rough, smooth = self.sides("a.ply", 1)
        self.assertGreater(rough, 4 * smooth)
        self.refused(BAD_DATA, "fractal", "ball.ply", "--alpha", "texture:halves.png:8:300", *SMALL, "--mesh", "b.ply",
                     mentions="no texture coordinates")
        # What it is called does not matter.
        for name, kind in (("halves.tif", "tiff"), ("jpeg.png", "jpeg"), ("halves", "openexr")):
            subprocess.run(["oiiotool", "halves.png", "-o:fileformatname=" + kind, name], cwd=self.folder, check=True)
            self.make("a.ply", f"texture:{name}:8:300", target="ball.obj")
            rough, smooth = self.sides("a.ply", 1)
            self.assertGreater(rough, 4 * smooth, name)

    # Promise: OpenImageIO's "own decoders of other ..."
    def test_a_picture_that_cannot_be_used(self):
        self.write("ball.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\n"
                               "f 1/1 3/3 2/2\nf 1/1 2/2 4/3\nf 1/1 4/3 3/2\nf 2/1 3/2 4/3\n")

        def check(name, content, code=BAD_DATA, mentions="cannot be read as a picture", options=()):
            self.write(name, content)
            self.refused(code, "fractal", "ball.obj", "--alpha", f"texture:{name}:8:300", *SMALL, *options, "--mesh",
                         "b.ply", mentions=mentions)

        check("broken.png", b"\x89PNG\r\n\x1a\nnothing")
        check("empty.png", b"")
        # Other formats are not tried, whatever the name: OpenImageIO's own decoders trust the file.
        bitmap = b"BM" + struct.pack("<3I3I2H6I", 58, 0, 54, 40, 1, 1, 1, 24, 0, 4, 0, 0, 0, 0) + b"abc\0"
        for name in ("right.bmp", "bitmap.png"):
            check(name, bitmap, mentions="PNG, JPEG, TIFF or EXR")
        huge = png(1, 1, lambda x, y: (0, 0, 0)).replace(struct.pack(">2I", 1, 1), struct.pack(">2I", 20000, 15000))
        header = huge.index(b"IHDR")
        huge = huge.replace(huge[header + 17:header + 21], struct.pack(">I", zlib.crc32(huge[header:header + 17])))
        check("huge.png", huge, INTERNAL, "scale the picture down", ("--memory", "2G"))

    # Promise: The distance to a brush: NEAR ...
    def test_another_mesh_as_the_brush(self):
        self.write("brush.obj", harness.obj(harness.sphere(2, 0.5, (1, 0, 0))))
        self.make("a.ply", "near:brush.obj:0.3:8:300")
        smooth, rough = self.sides("a.ply", 0)
        self.assertGreater(rough, 4 * smooth)

    def test_formulas(self):
        self.make("a.ply", "expr:ny > 0 ? 8 : 300")
        smooth, rough = self.sides("a.ply", 1)
        self.assertGreater(rough, 4 * smooth)
        self.make("b.ply", "expr:8 + 292 * slope * (tau > 0.01)")
        rough, smooth = self.sides("b.ply", 1)
        self.assertGreater(rough, 2 * smooth)

    # Promise of controls.md: "A variable of the table takes precedence over an attribute of the same name"
    def test_a_variable_goes_before_an_attribute_of_its_name(self):
        for name in ("height", "wet"):
            self.write("h.ply", painted_ply(self.ball, [f"float {name}"], lambda p: (0,)))
            self.ok("fractal", "h.ply", *SMALL, "--mask", "expr:height", "--mesh", f"{name}.stl")
        self.assertEqual(self.bytes("height.stl"), self.bytes("wet.stl"))

    # Promise of controls.md: "Every file that a source names is recorded in the result with its SHA-256"
    def test_recipes_name_the_file_and_its_content(self):
        self.write("brush.obj", harness.obj(harness.sphere(2, 0.5, (1, 0, 0))))
        self.ok("fractal", "ball.ply", "--alpha", "near:brush.obj:0.3:8:300", *SMALL, "-o", "a.vdb")
        recipe = self.info("a.vdb")["recipe"]
        self.assertEqual(recipe["alpha"], "near:brush.obj:0.3:8:300")
        self.assertRegex(recipe["alpha-sha256"], r"\A[0-9a-f]{64}\Z")
        self.ok("fractal", "--config", "a.vdb", "-o", "b.vdb")
        self.assertEqual(self.bytes("a.vdb"), self.bytes("b.vdb"))
        self.write("brush.obj", harness.obj(harness.sphere(2, 0.4, (1, 0, 0))))
        self.refused(BAD_DATA, "fractal", "--config", "a.vdb", "-o", "c.vdb", mentions="has changed")

    # Promise: "The same recipe gives the same ..."
    def test_threads_leave_no_trace(self):
        for alpha in ("paint:slope:8:300", "expr:150 + 100 * sin(9 * x) * ny"):
            self.make("one.ply", alpha, "--threads", 1)
            self.make("three.ply", alpha, "--threads", 3)
            self.assertEqual(self.bytes("one.ply"), self.bytes("three.ply"), alpha)

    # Promise: "A wrong name is refused ..."
    def test_bad_input(self):
        def case(alpha):
            return ("fractal", "ball.ply", "--alpha", alpha, *SMALL, "-o", "a.vdb")

        self.all_refused(USAGE, [case(alpha) for alpha in (
            "paint:", "paint:red:1", "paint:red:a:b", "texture:a.png", "near:a.obj:0.1:1", "near:a.obj:0:1:2", "expr:",
            "expr:2 *", "expr:x = 2")], mentions="--alpha is '")
        self.refused(BAD_DATA, *case("paint:rde:8:300"), mentions=("'rde'", "red, slope"))
        self.refused(BAD_DATA, *case("expr:20 + rde"), mentions=("'rde'", "red, slope", "curvature"))
        self.refused(BAD_DATA, *case("expr:20 / sqrt(y)"), mentions=("'20 / sqrt(y)'", "nan"))
        for alpha in ("paint:red@gone.ply:8:300", "texture:gone.png:8:300", "near:gone.obj:0.1:8:300"):
            self.refused(NO_INPUT, *case(alpha), mentions="gone")


if __name__ == "__main__":
    harness.main()

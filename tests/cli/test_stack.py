# SPDX-License-Identifier: Apache-2.0
"""Stacks of slices, as tifffile reads them: the layers are where the text beside them says, and hold what the shape is there."""

import math
import struct
import unittest

import harness
from harness import BAD_DATA, CANNOT_CREATE, USAGE

LOW = ("--resolution", 24, "--sdf-resolution", 48)

try:
    import numpy
    import tifffile
except ImportError:
    tifffile = None


class Stack(harness.CliTest):

    def setUp(self):
        super().setUp()
        # Not at the origin and not of size 1; the frame has 8 % of its size around.
        self.centre, self.radius = (3.0, -2.0, 5.0), 2.0
        self.write("s.obj", harness.obj(harness.sphere(3, self.radius, self.centre)))

    def text(self, name="s.txt"):
        return dict(line.split(": ", 1) for line in self.bytes(name).decode().splitlines())

    def layers(self, count, pattern="s.{:04}.tif"):
        if tifffile is None:
            self.skipTest("python3-tifffile is not installed")
        return numpy.stack([tifffile.imread(self.path(pattern.format(k + 1))) for k in range(count)])

    def positions(self, text):
        """x, y, z of every voxel, by what the text says alone."""
        width, height = map(int, text["pixels"].split(" x "))
        size = float(text["voxel size"])
        first = numpy.array([float(x) for x in text["centre of the first voxel"].split(",")])
        step = {name: size * (1 if name[0] == "+" else -1) * numpy.eye(3)["xyz".index(name[1])]
                for name in (text["to the right"], text["down"], text["to the next layer"])}
        k, j, i = numpy.indices((int(text["layers"]), height, width))
        return (first + i[..., None] * step[text["to the right"]] + j[..., None] * step[text["down"]]
                + k[..., None] * step[text["to the next layer"]])

    # Promise of coming-from.md: A stack "writes a picture for each layer of cubic voxels", and "the text beside the layers" says
    #   where they are
    def test_membership_of_a_ball(self):
        """alpha 300 is nearly smooth: the shell is 1 % of the longest side."""
        shell = 2 * self.radius * math.log(20) / 300 + 0.01 * self.radius
        for axis in "xyz":
            for bits in (8, 16):
                with self.subTest(axis=axis, bits=bits):
                    self.ok("slice", "s.obj", *LOW, "--alpha", 300, "--stack", "-o", "s.####.tif", "--size", 30, "--axis", axis,
                            "--bits", bits)
                    text = self.text()
                    voxels = self.layers(int(text["layers"]))
                    self.assertEqual(voxels.dtype, numpy.uint8 if bits == 8 else numpy.uint16)
                    self.assertEqual(set(numpy.unique(voxels)), {0, 2**bits - 1})
                    distance = numpy.linalg.norm(self.positions(text) - numpy.array(self.centre), axis=-1) - self.radius
                    self.assertTrue((voxels[distance < -shell] > 0).all())
                    self.assertTrue((voxels[distance > shell] == 0).all())
                    self.assertAlmostEqual(voxels.astype(bool).sum() * float(text["voxel size"])**3
                                           / (4 / 3 * math.pi * self.radius**3), 1, 1)

    # Promise: A stack "writes a picture ..."
    def test_distances(self):
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 40, "--band", 8)
        self.ok("slice", "s.vdb", "--field", "grid", "--stack", "-o", "d.####.tif", "--size", 40, "--range", 0.5, "--bits", 16)
        text = self.text("d.txt")
        voxels = self.layers(int(text["layers"]), "d.{:04}.tif")
        distance = numpy.linalg.norm(self.positions(text) - numpy.array(self.centre), axis=-1) - self.radius
        near = numpy.abs(distance) < 0.4
        found = (voxels / 65535 * 2 - 1) * 0.5
        self.assertGreater(near.sum(), 1000)
        # The sphere has facets.
        self.assertLess(numpy.abs(found - distance)[near].max(), 0.03)
        self.assertIn("65535 is 0.5", text["values"])

    # Promise: "Files then have the unit ..."
    # Promise of coming-from.md: "A TIFF then has its resolution in pixels per centimetre, and a PNG in pixels per metre"
    def test_the_size_of_the_voxels_is_in_the_file(self):
        words = ("slice", "s.obj", *LOW, "--stack", "--size", 8)
        for unit, centimetres in (("mm", 0.1), ("cm", 1), ("m", 100), ("in", 2.54)):
            self.ok(*words, "-o", "s.####.tif", "--units", unit)
            text = self.text()
            size = float(text["voxel size"])
            self.assertEqual(text["unit"], unit)
            self.layers(1)
            with tifffile.TiffFile(self.path("s.0001.tif")) as file:
                tags = file.pages[0].tags
                # OpenImageIO drops resolutions below 1; the description has the size in any case.
                if size * centimetres < 1:
                    self.assertEqual(tags["ResolutionUnit"].value, 3)  # centimetres
                    for tag in ("XResolution", "YResolution"):
                        top, bottom = tags[tag].value
                        self.assertAlmostEqual(top / bottom * size * centimetres, 1, 4)
                self.assertTrue(file.is_imagej)
                self.assertEqual(file.imagej_metadata["unit"], "inch" if unit == "in" else unit)
                self.assertAlmostEqual(file.imagej_metadata["spacing"], size)
        self.ok(*words, "-o", "s.####.tif")
        self.assertEqual(self.text()["unit"], "not known")
        with tifffile.TiffFile(self.path("s.0001.tif")) as file:
            self.assertEqual(file.pages[0].tags["ResolutionUnit"].value, 1)
        self.ok(*words, "-o", "p.####.png", "--units", "mm")
        data = self.bytes("p.0001.png")
        at = data.index(b"pHYs") + 4
        across, down, unit = struct.unpack(">IIB", data[at:at + 9])
        self.assertEqual((across, unit), (down, 1))
        self.assertAlmostEqual(across * float(self.text("p.txt")["voxel size"]) * 1e-3, 1, 2)

    # Promise: A stack "writes a picture ..."
    def test_every_field(self):
        self.ok("fractal", "s.obj", *LOW, "--iterations", 3, "-o", "f.vdb")
        for field in ("phi", "e", "f", "membership", "iterations", "versor", "grid"):
            signed = ("--range", 0.5) if field in ("phi", "e", "f", "grid") else ()
            with self.subTest(field=field):
                self.ok("slice", "f.vdb", "--field", field, *signed, "--stack", "-o", "s.####.tif", "--size", 12)
                voxels = self.layers(int(self.text()["layers"]))
                self.assertEqual(voxels.ndim, 4 if field == "versor" else 3)
                self.assertGreater(len(numpy.unique(voxels)), 1)
                if field == "iterations":
                    self.assertLessEqual(voxels.max(), 3)

    def test_the_same_bytes(self):
        for folder, threads in (("one", 1), ("two", 2)):
            self.path(folder).mkdir()
            self.ok("slice", "s.obj", *LOW, "--stack", "-o", f"{folder}/s.####.tif", "--size", 10, "--threads", threads)
        names = sorted(path.name for path in self.path("one").iterdir())
        self.assertEqual(names, sorted(path.name for path in self.path("two").iterdir()))
        self.assertGreater(len(names), 5)
        for name in names:
            self.assertEqual(self.bytes(f"one/{name}"), self.bytes(f"two/{name}"))

    def test_refusals(self):
        words = ("slice", "s.obj", *LOW, "--size", 10)
        self.refused(USAGE, *words, "-o", "x.png", "--bits", 8, mentions="--stack")
        self.refused(USAGE, *words, "-o", "x.png", "--units", "mm", mentions="--stack")
        words += ("--stack",)
        self.refused(USAGE, *words, "-o", "x.####.tif", "--units", "ft", mentions="--units")
        self.refused(USAGE, *words, "-o", "x.####.tif", "--bits", 12, mentions="--bits")
        self.refused(USAGE, *words, "-o", "x.####.exr", mentions=".tif")
        self.refused(USAGE, *words, "-o", "x.####.tif", "--field", "phi", mentions="--range")
        self.refused(USAGE, *words, "-o", "x.####.tif", "--field", "phi", "--range", "-1", mentions="--range")
        self.refused(USAGE, *words, "-o", "x.####.tif", "--position", 0, mentions="--position")
        self.refused(USAGE, *words, "-o", "x.####.tif", "--arrow", "0,0,0", mentions="--arrow")
        self.refused(USAGE, "slice", "--map", "quadratic", "--field", "phi", "--range", 1, "--stack", "-o", "x.####.tif",
                     mentions="phi")
        # The text beside the layers may be an input, too.
        self.write("s.txt", "iterations = 3\n")
        self.refused(USAGE, "slice", "s.obj", "--config", "s.txt", "--stack", "-o", "s.####.tif", "--size", 10, mentions="s.txt")

    def test_the_folder_is_looked_at_before_the_work(self):
        """The mesh is broken, which is found only where the folder is good."""
        self.write("broken.obj", "f 1 2 3\n")
        words = ("slice", "broken.obj", *LOW, "--size", 10, "--stack", "-o")
        self.refused(BAD_DATA, *words, "x.####.png")
        self.refused(CANNOT_CREATE, *words, "missing/x.####.png", mentions="missing")
        self.path("x.txt").mkdir()
        self.refused(CANNOT_CREATE, *words, "x.####.png", mentions="x.txt")

    def test_no_layer_of_an_earlier_stack_is_left_among_the_new_ones(self):
        self.ok("slice", "s.obj", *LOW, "--size", 12, "--stack", "-o", "x.####.png")
        old = {name: self.bytes(name) for name in self.listing()}
        self.refused(USAGE, "slice", "s.obj", *LOW, "--size", 9, "--stack", "-o", "x.####.png", mentions=("earlier stack", "x.0010.png"))
        self.assertEqual({name: self.bytes(name) for name in self.listing()}, old)
        self.ok("slice", "s.obj", *LOW, "--size", 12, "--stack", "-o", "x.####.png")
        self.ok("slice", "s.obj", *LOW, "--size", 15, "--stack", "-o", "x.####.png")


if __name__ == "__main__":
    harness.main()

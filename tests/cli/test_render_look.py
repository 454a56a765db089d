# SPDX-License-Identifier: Apache-2.0
"""Materials, lights and floors, layers and alpha, and sequences of pictures, of meshes, level sets and the set of a map."""

import pathlib
import re
import struct
import zlib

import harness
from harness import USAGE
from test_render_field import exr_channels

SMALL = ("--size", "40x30", "--samples", 1)
LOW = ("--resolution", 24, "--sdf-resolution", 32)


def png_alpha(data):
    """Whether an 8-bit PNG has alpha."""
    return data[25] == 6


class RenderLook(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.lumpy()))
        self.ok("fractal", "s.obj", "-o", "f.vdb", "--mesh", "f.ply", *LOW)
        self.kinds = {"mesh": ("render", "f.ply", *SMALL), "level set": ("render", "f.vdb", *SMALL),
                      "field": ("render", "--field", "f.vdb", *SMALL)}

    def picture(self, *arguments, name="x.png"):
        self.ok(*arguments, "-o", name)
        return self.bytes(name)

    def test_each_option_changes_every_kind_of_picture(self):
        for kind, command in self.kinds.items():
            with self.subTest(kind=kind):
                made = {self.picture(*command, *more) for more in (
                    (), ("--material", "porcelain"), ("--material", "#3060c0:metal"), ("--light", "60,20"), ("--sky", 0.3), ("--ground",),
                    ("--background", "#203040"), ("--exposure", 1), ("--background", "none"))}
                self.assertEqual(len(made), 9)

    # Promise of pictures.md: "the same command gives the same bytes, for any number of threads", and what is said anyway changes
    #   nothing
    def test_what_is_said_anyway_changes_nothing(self):
        for kind, command in self.kinds.items():
            with self.subTest(kind=kind):
                plain = self.picture(*command)
                for same in (("--material", "clay"), ("--light", "-48,41"), ("--sky", 1), ("--exposure", 0), ("--threads", 1),
                             ("--instructions", "portable")):
                    self.assertEqual(self.picture(*command, *same), plain, same)

    # Promise: `--background none`: a picture with alpha
    def test_alpha(self):
        for kind, command in self.kinds.items():
            with self.subTest(kind=kind):
                self.assertFalse(png_alpha(self.picture(*command)))
                data = self.picture(*command, "--background", "none")
                self.assertTrue(png_alpha(data))
                # The corner is empty, the middle is not.
                packed = b"".join(data[m.start() + 4:m.start() + 4 + struct.unpack_from(">I", data, m.start() - 4)[0]]
                                  for m in re.finditer(b"IDAT", data))
                raw = zlib.decompress(packed)
                self.assertEqual(len(raw), 30 * (40 * 4 + 1))
                self.assertEqual(raw[1:5], b"\0\0\0\0")

    def test_layers(self):
        usual = {"R": False, "G": False, "B": False, **dict.fromkeys(("A", "N.x", "N.y", "N.z", "Z", "id"), True)}
        for kind, command in self.kinds.items():
            with self.subTest(kind=kind):
                self.assertEqual(exr_channels(self.picture(*command, name="x.exr")), usual)
                some = exr_channels(self.picture(*command, "--passes", "ao,albedo", name="x.exr"))
                self.assertEqual(set(some), {"R", "G", "B", "A", "AO", "albedo.R", "albedo.G", "albedo.B"})
        self.assertIn("trap", exr_channels(self.picture(*self.kinds["field"], "--passes", "trap", name="x.exr")))
        for kind in ("mesh", "level set"):
            self.refused(USAGE, *self.kinds[kind], "--passes", "trap", "-o", "x.exr", mentions="albedo")
        for command in self.kinds.values():
            self.refused(USAGE, *command, "--passes", "ao", "-o", "x.png", mentions="EXR")

    # Promise of pictures.md#sequences: A turntable is made of stills; keys and files of a sequence give the pictures that stills
    #   have
    def test_a_turntable_is_made_of_stills(self):
        for kind, command in self.kinds.items():
            with self.subTest(kind=kind):
                self.ok(*command, "--frames", "1-4", "--turn", 360, "--azimuth", 10, "-o", "t.####.png")
                for frame in range(4):
                    still = self.picture(*command, "--azimuth", 10 + 90 * frame)
                    if kind == "field" and frame > 0:
                        # The eye is turned about, and not placed anew: another rounding.
                        a, b = (harness.read_png(data) for data in (self.bytes(f"t.{frame + 1:04}.png"), still))
                        off = [abs(p - q) for r, s in zip(a, b) for x, y in zip(r, s) for p, q in zip(x, y)]
                        self.assertLess(sum(off) / len(off), 3)
                    else:
                        self.assertEqual(self.bytes(f"t.{frame + 1:04}.png"), still, frame)
                # The order of the list changes no frame.
                self.ok(*command, "--frames", "3,1,4,2", "--turn", 360, "--azimuth", 10, "-o", "u.####.png")
                for frame in range(1, 5):
                    self.assertEqual(self.bytes(f"u.{frame:04}.png"), self.bytes(f"t.{frame:04}.png"))

    # Promise: A turntable is made of stills; keys ...
    def test_keys_of_the_camera_and_the_light(self):
        for kind, command in self.kinds.items():
            with self.subTest(kind=kind):
                self.ok(*command, "--frames", "1-3", "--key", "zoom@1=1", "--key", "zoom@3=2", "--key", "light@1=0,20",
                        "--key", "light@3=40,60", "--ease", "zoom=smooth", "-o", "k.####.png")
                for frame, zoom, light in ((1, 1, "0,20"), (2, 1.5, "20,40"), (3, 2, "40,60")):
                    still = self.picture(*command, "--zoom", zoom, "--light", light)
                    self.assertEqual(self.bytes(f"k.{frame:04}.png"), still, frame)

    # Promise: A turntable is made of stills; keys ...
    def test_a_sequence_of_files(self):
        for frame in (1, 2):
            self.ok("fractal", "s.obj", "-o", f"g.{frame:04}.vdb", "--mesh", f"g.{frame:04}.ply", "--detail", 0.2 * frame, *LOW)
        for kind, (first, *rest) in {"mesh": ("g.####.ply", "render"), "level set": ("g.####.vdb", "render"),
                                     "field": ("g.####.vdb", "render", "--field")}.items():
            with self.subTest(kind=kind):
                self.ok(*rest, first, *SMALL, "--frames", "1-2", "-o", "s.####.png")
                stills = [self.picture(*rest, first.replace("####", f"{frame:04}"), *SMALL) for frame in (1, 2)]
                self.assertEqual([self.bytes(f"s.{frame:04}.png") for frame in (1, 2)], stills)
                self.assertNotEqual(*stills)
        # An output in the place of an input of another frame is refused before any work.
        self.refused(USAGE, "render", "g.####.vdb", *SMALL, "--frames", "1-2", "-o", "g.####.vdb")

    def test_bad_input(self):
        for command in self.kinds.values():
            self.all_refused(USAGE, [(*command, *bad, "-o", "x.####.png" if "--frames" in bad else "x.png") for bad in (
                ("--material", "wood"), ("--material", "1,2,3"), ("--light", "3"), ("--light", "0,-10", "--ground"), ("--sky", -1),
                ("--exposure", 99), ("--background", "blue"), ("--turn", 360), ("--key", "zoom@1=2"), ("--ease", "smooth"),
                ("--frames", "3-1", "--turn", 360), ("--frames", "1-3", "--turn", 0),
                ("--frames", "1-3", "--key", "size@1=10x10"), ("--frames", "1-3", "--key", "zoom@1=2", "--zoom", 3),
                ("--frames", "1-3", "--key", "zoom@2=0"), ("--frames", "1-3", "--turn", 90, "--ease", "smooth"))])
        self.refused(USAGE, *self.kinds["mesh"], "--material", "bronce", "-o", "x.png", mentions="did you mean 'bronze'?")


if __name__ == "__main__":
    harness.main()

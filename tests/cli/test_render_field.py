# SPDX-License-Identifier: Apache-2.0
"""Pictures of a map's own set: options, frames, channels, and that they show what they should."""

import math
import struct

import harness
from harness import BAD_DATA, NO_INPUT, USAGE

JULIA = ("render", "--field", "--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", "--iterations", 6)
BALL = ("render", "--field", "--map", "quadratic", "--iterations", 6, "--samples", 1)
LOW = ("--resolution", 24, "--sdf-resolution", 48)
SMALL = ("--size", "40x30")


def exr_channels(data):
    """The header's list of channels: name -> whether its values are 32-bit floats."""
    at = data.index(b"channels\0chlist\0") + 16
    end = at + 4 + struct.unpack_from("<i", data, at)[0]
    at += 4
    channels = {}
    while data[at] != 0:
        stop = data.index(b"\0", at)
        channels[data[at:stop].decode()] = struct.unpack_from("<i", data, stop + 1)[0] == 2
        at = stop + 1 + 16
    assert at + 1 == end
    return channels


class RenderField(harness.CliTest):

    def render(self, *arguments):
        self.ok(*arguments, "-o", "x.png")
        return harness.read_png(self.bytes("x.png"))

    def test_formats(self):
        rows = self.render(*JULIA, *SMALL)
        self.assertEqual((len(rows[0]), len(rows)), (40, 30))
        self.assertGreater(len({pixel for row in rows for pixel in row}), 50)
        self.ok(*JULIA, *SMALL, "-o", "x.exr")
        floats = dict.fromkeys(("A", "N.x", "N.y", "N.z", "Z", "id"), True)
        self.assertEqual(exr_channels(self.bytes("x.exr")), {"R": False, "G": False, "B": False, **floats})

    def test_a_ball_where_the_camera_sees_it(self):
        """|q|^64 <= 20, from 8 away with the vertical field of view of 40 degrees."""
        side = 80
        rows = self.render(*BALL, "--size", f"{side}x{side}", "--eye", "0,0,8", "--look-at", "0,0,0", "--fov", 40)
        radius = math.tan(math.asin(20 ** (1 / 64) / 8)) / math.tan(math.radians(20)) * side / 2
        for y, row in enumerate(rows):
            for x, (r, g, b) in enumerate(row):
                off = math.hypot(x + 0.5 - side / 2, y + 0.5 - side / 2)
                if abs(off - radius) > 1:
                    # The background is neutral, the colours of directions are not.
                    self.assertEqual(max(r, g, b) - min(r, g, b) > 2, off < radius, (x, y))

    # Promise: `render --field`: skipped space ...
    def test_nothing_but_what_was_asked_for_changes_the_picture(self):
        for name in ("a.exr", "a.png"):
            self.ok(*JULIA, *SMALL, "-o", name)
        for same in (("--no-skip",), ("--threads", 1), ("--instructions", "portable"), ("--delta", 1),
                     ("--epsilon", 5e-5), ("--up", "0,2,0")):
            with self.subTest(same=same):
                self.ok(*JULIA, *SMALL, *same, "-o", "b.exr")
                self.assertEqual(self.bytes("a.exr"), self.bytes("b.exr"))
        for other in (("--alpha-clarity", 0.05), ("--fov", 50), ("--zoom", 2), ("--azimuth", 0), ("--elevation", 50),
                      ("--eye", "3,3,3"), ("--look-at", "0.5,0,0"), ("--up", "1,1,0"), ("--samples", 1),
                      ("--colour", "direction"), ("--colour", "versor"), ("--colour", "iterations"), ("--colour", "trap"),
                      ("--slice", 0.2), ("--epsilon", 0.2)):
            with self.subTest(other=other):
                self.ok(*JULIA, *SMALL, *other, "-o", "b.png")
                self.assertNotEqual(self.bytes("a.png"), self.bytes("b.png"))

    def test_a_target_and_the_recipe_of_a_fractal(self):
        self.write("s.obj", harness.obj(harness.sphere(3, 2.0, (3, -2, 5))))
        self.ok("fractal", "s.obj", *LOW, "--alpha", 12, "-o", "f.vdb")
        self.ok("render", "--field", "f.vdb", *SMALL, "-o", "recipe.png")
        self.ok("render", "--field", "s.obj", *LOW, "--alpha", 12, *SMALL, "-o", "given.png")
        self.ok("render", "--field", "f.vdb", "--alpha", 60, *SMALL, "-o", "other.png")
        self.assertEqual(self.bytes("recipe.png"), self.bytes("given.png"))
        self.assertNotEqual(self.bytes("recipe.png"), self.bytes("other.png"))
        harness.read_png(self.bytes("recipe.png"))

    def test_pictures_read_the_distances_quadratically_and_meshes_trilinearly(self):
        self.write("s.obj", harness.obj(harness.sphere(3, 2.0, (3, -2, 5))))
        self.ok("fractal", "s.obj", *LOW, "--alpha", 12, "-o", "f.vdb")
        pictures, meshes = {}, {}
        for sampling, words in ((None, ()), *((name, ("--sampling", name)) for name in ("quadratic", "trilinear"))):
            self.ok("render", "--field", "f.vdb", *SMALL, *words, "-o", "p.png")
            self.ok("fractal", "s.obj", *LOW, "--alpha", 12, *words, "--mesh", "m.stl")
            pictures[sampling], meshes[sampling] = self.bytes("p.png"), self.bytes("m.stl")
        self.assertEqual(pictures[None], pictures["quadratic"])
        self.assertNotEqual(pictures[None], pictures["trilinear"])
        self.assertEqual(meshes[None], meshes["trilinear"])
        self.assertNotEqual(meshes[None], meshes["quadratic"])

    def test_distances_too_coarse_for_a_spline_are_read_as_meshes_read_them(self):
        self.write("t.obj", harness.obj(harness.torus()))
        field = ("render", "--field", "t.obj", "--sdf-resolution", 16, *SMALL, "--origin", "0.35,0,0.405")
        self.refused(USAGE, *field, "--sampling", "quadratic", "-o", "q.png", mentions="no shell of detail")
        self.ok(*field, "-o", "a.png")
        self.ok(*field, "--sampling", "trilinear", "-o", "t.png")
        self.assertEqual(self.bytes("a.png"), self.bytes("t.png"))

    def test_a_rational_map(self):
        self.write("r.json", harness.rational_json(harness.ROOTS, log_scale=0.5))
        rows = self.render("render", "--field", "--map", "rational", "--rational", "r.json", "--box=-2,-2,-2,2,2,2", *SMALL)
        self.assertGreater(len({pixel for row in rows for pixel in row}), 50)

    def test_frames(self):
        self.ok(*JULIA, *SMALL, "--frames", "1-3", "--turn", 360, "-o", "turn.####.png")
        self.assertEqual(self.listing(), [f"turn.{n:04}.png" for n in (1, 2, 3)])
        self.assertEqual(len({self.bytes(name) for name in self.listing()}), 3)
        self.ok(*JULIA, *SMALL, "-o", "still.png")
        self.assertEqual(self.bytes("still.png"), self.bytes("turn.0001.png"))
        self.ok(*JULIA, *SMALL, "--frames", 1, "--turn", 360, "-o", "one.png")
        self.assertEqual(self.bytes("one.0001.png"), self.bytes("still.png"))

    def test_progress_names_the_frame(self):
        text = self.ok(*JULIA, "--size", "150x150", "--alpha-clarity", 0.002, "--frames", "1-2", "--turn", 90, "--no-skip",
                       "--progress", "json", "-o", "x.####.png")
        if '"phase"' in text:  # the run took long enough
            self.assertIn("frame 2 of 2", text)

    def test_bad_options(self):
        cases = [(*JULIA, *option, "-o", "x.png") for option in (
            ("--size", "0x10"), ("--size", "10x0"), ("--size", "10"), ("--size", "-1x5"), ("--iterations", 0),
            ("--eye", "1,2"), ("--eye", "a,b,c"), ("--eye", "1,1,1", "--look-at", "1,1,1"),
            ("--eye", "1,1,1", "--azimuth", 3), ("--eye", "1,1,1", "--zoom", 3), ("--up", "0,0,0"), ("--fov", 0), ("--fov", 180),
            ("--elevation", 91), ("--zoom", 0), ("--samples", 3), ("--epsilon", 0), ("--epsilon", -1),
            ("--alpha-clarity", -1), ("--delta", 3), ("--delta", 0.5), ("--frames", "a", "--turn", 9), ("--frames", 1.5, "--turn", 9),
            ("--colour", "pink"), ("--roots", "x.json"), ("--map", "nothing"))]
        cases += [JULIA, (*JULIA, "-o", "x.jpg"), (*JULIA, "-o", "x.####.png"), ("render", "--field", "-o", "x.png"),
                  ("render", "--field", "--map", "rational", "-o", "x.png")]
        self.all_refused(USAGE, cases)

    def test_what_goes_with_field_only(self):
        self.write("s.obj", harness.obj(harness.sphere(2)))
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 24)
        self.all_refused(USAGE, [("render", "s.vdb", *option, "-o", "x.png") for option in (
            ("--eye", "1,1,1"), ("--look-at", "0,0,0"), ("--alpha", 3), ("--map", "quadratic"),
            ("--colour", "clay"), ("--no-skip",))], mentions="--field")

    def test_bad_input(self):
        self.refused(NO_INPUT, "render", "--field", "none.vdb", "-o", "x.png", mentions="none.vdb")
        self.write("empty.obj", "")
        self.refused(BAD_DATA, "render", "--field", "empty.obj", "-o", "x.png", mentions="empty.obj")


if __name__ == "__main__":
    harness.main()

# SPDX-License-Identifier: Apache-2.0
"""Sequences that one process makes: `juliavdb fractal --frames`."""

import os

import harness

SMALL = ("--resolution", 20, "--sdf-resolution", 24)
# The origin of frames 1 and 2 is searched for over the whole target, that of frame 3 is not.
KEYS = ("--key", "alpha@1=40", "--key", "alpha@4=100", "--key", "origin@1=auto", "--key", "origin@3=centre",
        "--ease", "origin=step")


class Sequences(harness.CliTest):
    def setUp(self):
        super().setUp()
        self.write("lumpy.obj", harness.obj(harness.lumpy()))

    def make(self, *words):
        return self.ok("fractal", "lumpy.obj", "-o", "g.####.vdb", "--mesh", "g.####.ply", *KEYS, *SMALL, *words)

    def frames(self, *numbers):
        return {f"g.{n:04}{kind}": self.bytes(f"g.{n:04}{kind}") for n in numbers for kind in (".vdb", ".ply")}

    def test_frames_are_those_of_a_plan(self):
        self.assertIn("kept 0 of 4 frames", self.make("--frames", "1-4"))
        self.ok("plan", "frames", "lumpy.obj", "-o", "plan", "--make", "vdb,ply", "--frames", "1-4", *KEYS, *SMALL)
        self.ok("task", "plan", "--range", "1-4")
        for name, content in self.frames(1, 2, 3, 4).items():
            self.assertEqual(content, self.bytes("plan/out/" + name.replace("g.", "lumpy.")), name)

    def test_a_frame_does_not_depend_on_those_that_were_made_before(self):
        """In any order, after a resumption, and by itself."""
        self.write("snowman.obj", harness.obj(harness.snowman()))
        words = ("fractal", "snowman.obj", "-o", "g.####.vdb", "--mesh", "g.####.ply", "--key", "detail@1=0.1", "--key",
                 "detail@3=0.5", "--resolution", 20, "--sdf-resolution", 60)
        self.ok(*words, "--frames", "1-3")
        made = self.frames(1, 2, 3)
        for order in ("3,2,1", "2,3,1"):
            self.ok(*words, "--frames", order, "--force")
            self.assertTrue(self.frames(1, 2, 3) == made, order)
        for missing in (1, 2, 3):
            os.remove(self.path(f"g.{missing:04}.ply"))
            self.assertIn("made 1 frame, kept 2 of 3 frames", self.ok(*words, "--frames", "1-3"))
            self.assertTrue(self.frames(1, 2, 3) == made, missing)
        for frame in (1, 2, 3):
            self.ok("fractal", "--config", f"g.{frame:04}.vdb", "-o", "one.vdb", "--mesh", "one.ply")
            self.assertTrue(self.bytes("one.vdb") == made[f"g.{frame:04}.vdb"], frame)
            self.assertTrue(self.bytes("one.ply") == made[f"g.{frame:04}.ply"], frame)
        self.ok("plan", "frames", "snowman.obj", "-o", "plan", "--make", "vdb,ply", "--frames", "1-3", *words[6:])
        self.ok("task", "plan", "--range", "1-3")
        for name, content in made.items():
            self.assertTrue(content == self.bytes("plan/out/" + name.replace("g.", "snowman.")), name)

    def test_only_what_is_missing_broken_or_other_is_made(self):
        self.make("--frames", "1-4")
        made = self.frames(1, 2, 3, 4)
        times = {name: self.path(name).stat().st_mtime_ns for name in made}
        self.assertIn("kept 4 of 4 frames", self.make("--frames", "1-4"))
        os.remove(self.path("g.0001.ply"))
        self.write("g.0002.vdb", made["g.0002.vdb"][:-40])
        self.write("g.0003.ply", made["g.0003.ply"][:-40])
        self.assertIn("made 3 frames, kept 1 of 4 frames", self.make("--frames", "1-4"))
        self.assertEqual(self.frames(1, 2, 3, 4), made)
        self.assertEqual(self.path("g.0004.vdb").stat().st_mtime_ns, times["g.0004.vdb"])
        self.assertIn("kept 0 of 1 frame", self.make("--frames", "4", "--force"))
        self.assertIn("kept 0 of 1 frame", self.make("--frames", "4", "--tolerance", "0.02"))
        self.assertIn("kept 0 of 1 frame", self.make("--frames", "4"))
        with open(self.path("lumpy.obj"), "a") as target:
            target.write("# another file\n")
        self.assertIn("kept 0 of 1 frame", self.make("--frames", "4"))

    def test_frames_are_kept_where_the_file_holds_the_recipe(self):
        """An STL has no place for one. What is cut off is made again in every format."""
        for kind, kept in (("glb", 2), ("obj", 2), ("ply", 2), ("stl", 0)):
            words = ("fractal", "lumpy.obj", "--mesh", f"k.####.{kind}", *KEYS, *SMALL, "--frames", "1-2")
            self.ok(*words)
            first = self.bytes(f"k.0001.{kind}")
            self.assertIn(f"kept {kept} of 2 frames", self.ok(*words), kind)
            self.write(f"k.0001.{kind}", first[:-2])
            self.assertIn(f"kept {max(0, kept - 1)} of 2 frames", self.ok(*words), kind)
            self.assertEqual(self.bytes(f"k.0001.{kind}"), first)

    def test_targets_with_a_file_for_each_frame(self):
        text = self.path("lumpy.obj").read_text()
        for frame in (1, 3, 5):
            self.write(f"in.{frame:04}.obj", text + f"# {frame}\n")
        self.ok("fractal", "in.####.obj", "--frames", "1-5x2", "-o", "out.####.vdb", *SMALL)
        for frame in (1, 3, 5):
            self.ok("fractal", f"in.{frame:04}.obj", "-o", "one.vdb", *SMALL)
            self.assertEqual(self.bytes(f"out.{frame:04}.vdb"), self.bytes("one.vdb"))
        error = self.refused(harness.NO_INPUT, "fractal", "in.####.obj", "--frames", "1-10", "-o", "new.####.vdb",
                             *SMALL, mentions=("7 inputs", "in.0002.obj", "in.0004.obj", "in.0006.obj"))
        self.assertNotIn("in.0007.obj", error)

    def test_a_failure_names_its_frame(self):
        words = ("fractal", "lumpy.obj", "-o", "g.####.vdb", "--frames", "1-3", "--key", "beta@1=0.01", "--key",
                 "beta@2=-0.5", "--key", "beta@3=0.01", "--alpha", 40, "--progress", "none", *SMALL)
        run = self.run_program(*words)
        self.assertEqual(run.returncode, harness.BAD_DATA)
        self.assertIn(b"frame 2: ", run.stderr)
        self.assertEqual([name for name in self.listing() if name.endswith(".vdb")], ["g.0001.vdb"])
        run = self.run_program(*words, "--keep-going")
        self.assertEqual(run.returncode, harness.BAD_DATA)
        self.assertIn(b"frame 2: ", run.stderr)
        self.assertIn(b"made 1 frame, kept 1 of 3 frames", run.stderr)
        self.assertEqual([name for name in self.listing() if name.endswith(".vdb")], ["g.0001.vdb", "g.0003.vdb"])

    def test_what_does_not_fit(self):
        base = ("fractal", "lumpy.obj", "-o", "g.vdb", *SMALL)
        for words, mention in (((*base, "--frames", "1-3"), "nothing changes"),
                               ((*base, "--frames", "1-3", "--frame", "2", *KEYS), "--frame"),
                               ((*base, "--frames", "3-1", *KEYS), "--frames"),
                               ((*base, "--frames", "1-9x0", *KEYS), "--frames"),
                               ((*base, *KEYS), "--key"),
                               ((*base, "--force"), "--force"),
                               ((*base, "--keep-going"), "--keep-going"),
                               ((*base, "--frames", "1-2", "--alpha", "9", *KEYS), "--alpha"),
                               ((*base, "--frames", "1-2", "--key", "alpha@1=x"), "frame 1")):
            self.refused(harness.USAGE, *words, mentions=(mention,))


if __name__ == "__main__":
    harness.main()

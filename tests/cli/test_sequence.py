# SPDX-License-Identifier: Apache-2.0
"""Sequences that one process makes: --frames of 'fractal' and of all other commands that have it."""

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

    # Promise of farm.md: A sequence has "the same bytes as a plan" of frames, and as each frame alone
    def test_frames_are_those_of_a_plan(self):
        self.assertIn("kept 0 of 4 frames", self.make("--frames", "1-4"))
        self.ok("plan", "frames", "lumpy.obj", "-o", "plan", "--make", "vdb,ply", "--frames", "1-4", *KEYS, *SMALL)
        self.ok("task", "plan", "--range", "1-4")
        for name, content in self.frames(1, 2, 3, 4).items():
            self.assertEqual(content, self.bytes("plan/out/" + name.replace("g.", "lumpy.")), name)

    # Promise: "What was made before changes ..."
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

    # Promise of farm.md: A frame that is there and "hold the frame's recipe, the hashes of its inputs and this version of the
    #   program, is kept"
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

    # Promise: A frame that is there and "hold ..."
    # Promise of farm.md: "STL has no place for a recipe, so its frames are always made"
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

    # Promise: A sequence has "the same ..."
    # Promise of farm.md: "one that is missing or broken is named with its frame" before the first frame is made
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

    # Promise of farm.md: "`--resolution` counts the voxels of the largest target, and all frames have voxels of that one size"
    def test_targets_of_several_sizes_share_the_voxels_of_the_largest(self):
        points, faces = harness.torus(around=24, across=12)
        for frame, scale in ((1, 1), (2, 3), (3, 2)):
            self.write(f"in.{frame}.obj", harness.obj(([tuple(scale * c for c in p) for p in points], faces)))
        self.ok("fractal", "in.2.obj", "-o", "two.vdb", *SMALL)
        size = self.info("two.vdb")["grids"][0]["voxel size"]
        frames = ("in.#.obj", "--frames", "1-3", *SMALL)
        run = self.run_program("fractal", *frames, "-o", "out.#.vdb", "--progress", "none")
        self.assertRegex(run.stderr.decode(), r"voxels of \S+ for all frames: those of frame 2, whose target is the largest")
        self.ok("plan", "frames", *frames, "-o", "plan", "--name", "a")
        for frame in (1, 2, 3):
            self.assertEqual(self.info(f"out.{frame}.vdb")["grids"][0]["voxel size"], size)
            self.ok("task", "plan", "--index", frame)
            self.assertEqual(self.bytes(f"plan/out/a.{frame:04}.vdb"), self.bytes(f"out.{frame}.vdb"))
        # A size that is given, and one resolution for each frame, are what they say.
        self.ok("fractal", "in.#.obj", "--frames", "1-3", "-o", "given.#.vdb", *SMALL[2:], "--voxel-size", 0.3)
        self.assertEqual({str(self.info(f"given.{frame}.vdb")["grids"][0]["voxel size"]) for frame in (1, 2, 3)},
                         {str([0.3] * 3)})

    # Promise of farm.md: "The first frame that fails ends the sequence, with its exit code and its number", or `--keep-going`
    #   makes the others
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
        base = ("fractal", "lumpy.obj", "-o", "g.####.vdb", *SMALL)
        for words, mention in ((("fractal", "lumpy.obj", "-o", "g.vdb", *SMALL, "--frames", "1-3", *KEYS), "g.####.vdb"),
                               ((*base, "--frames", "1-3", "--frame", "2", *KEYS), "--frame"),
                               ((*base, "--frames", "3-1", *KEYS), "--frames"),
                               ((*base, "--frames", "1-9x0", *KEYS), "--frames"),
                               ((*base, *KEYS), "--key"),
                               ((*base, "--force"), "--force"),
                               ((*base, "--keep-going"), "--keep-going"),
                               ((*base, "--frames", "1-2", "--alpha", "9", *KEYS), "--alpha"),
                               ((*base, "--frames", "1-2", "--key", "alpha@1=x"), "frame 1")):
            self.refused(harness.USAGE, *words, mentions=(mention,))

    # Promise: If nothing changes, "the program ..."
    def test_a_list_without_keys_holds_the_frame(self):
        """Also between keys: frames with the same recipe are copied, and the others made."""
        self.ok("fractal", "lumpy.obj", "-o", "one.vdb", "--mesh", "one.ply", *SMALL)
        words = ("fractal", "lumpy.obj", "-o", "h.####.vdb", "--mesh", "h.####.ply", *SMALL)
        text = self.ok(*words, "--frames", "-1-1")
        self.assertIn("nothing changes from frame to frame", text)
        self.assertEqual(text.count("the same as frame"), 2)
        for frame in ("-0001", "0000", "0001"):
            self.assertEqual(self.bytes(f"h.{frame}.vdb"), self.bytes("one.vdb"))
            self.assertEqual(self.bytes(f"h.{frame}.ply"), self.bytes("one.ply"))
        keys = ("--key", "iterations@2=3", "--key", "iterations@3=4")
        text = self.ok("fractal", "lumpy.obj", "-o", "k.####.vdb", *SMALL, *keys, "--frames", "1-4")
        self.assertEqual(text.count("the same as frame"), 2)
        self.assertNotIn("nothing changes", text)
        for frame, count in enumerate((3, 3, 4, 4), 1):
            self.ok("fractal", "lumpy.obj", "-o", "one.vdb", *SMALL, "--iterations", count)
            self.assertEqual(self.bytes(f"k.{frame:04}.vdb"), self.bytes("one.vdb"), frame)


# The words of each command, and the ending of what it makes, but for 'fractal', which is above.
COMMANDS = {
    "sdf": ("in.{}.obj", ("--resolution", 16), ".vdb"),
    "fractal": ("in.{}.obj", ("--voxel-size", 0.1, "--sdf-resolution", 24), ".vdb"),
    "convert": ("g.{}.vdb", (), ".nvdb"),
    "mesh": ("g.{}.vdb", (), ".ply"),
    "points": ("g.{}.vdb", ("--points", 40), ".ply"),
    "slice": ("in.{}.obj", ("--size", 16, "--field", "phi", "--sdf-resolution", 24), ".png"),
    "print": ("in.{}.obj", ("--size", 30), ".stl"),
    "render": ("g.{}.vdb", ("--size", "16x16"), ".png"),
    "render --field": ("in.{}.obj", ("--size", "16x16", *SMALL), ".png"),
}


class EveryCommand(harness.CliTest):
    """The same list means the same to each of them."""

    def setUp(self):
        super().setUp()
        points, faces = harness.lumpy()
        for name, size in (("-0001", 1), ("0002", 1.5)):
            self.write(f"in.{name}.obj", harness.obj((([(x, size * y, z) for x, y, z in points]), faces)))
            self.ok("fractal", f"in.{name}.obj", "-o", f"g.{name}.vdb", *SMALL)

    # Promise of usage.md: "`--frames LIST` means the same" in each command: a frame has the bytes of its input alone
    def test_a_frame_has_the_bytes_of_its_own_input(self):
        for command, (name, words, kind) in COMMANDS.items():
            with self.subTest(command=command):
                self.ok(*command.split(), name.format("$F4"), *words, "-o", f"all.####{kind}", "--frames", "-1,2")
                for frame in ("-0001", "0002"):
                    self.ok(*command.split(), name.format(frame), *words, "-o", f"one{kind}")
                    self.assertEqual(self.bytes(f"all.{frame}{kind}"), self.bytes(f"one{kind}"))
                self.assertNotEqual(self.bytes(f"all.-0001{kind}"), self.bytes(f"all.0002{kind}"))

    # Promise of usage.md: If nothing changes, "the program makes the first frame, copies it to the others, and says so"
    def test_an_input_without_a_place_is_held(self):
        for command, (name, words, kind) in COMMANDS.items():
            with self.subTest(command=command):
                text = self.ok(*command.split(), name.format("0002"), *words, "-o", f"all.####{kind}", "--frames", "3,-2--1")
                self.assertIn("nothing changes from frame to frame", text)
                self.ok(*command.split(), name.format("0002"), *words, "-o", f"one{kind}")
                for frame in ("-0002", "-0001", "0003"):
                    self.assertEqual(self.bytes(f"all.{frame}{kind}"), self.bytes(f"one{kind}"))

    # Promise: "`--frames LIST` means the same" ...
    def test_one_frame_needs_no_place(self):
        """A single frame goes before the extension, as with --frame."""
        for command, (name, words, kind) in COMMANDS.items():
            with self.subTest(command=command):
                self.ok(*command.split(), name.format("####"), *words, "-o", f"one{kind}", "--frames", "2-2")
                self.assertTrue(self.path(f"one.0002{kind}").is_file())
                self.path(f"one.0002{kind}").unlink()

    # Promise of usage.md: "a missing one is named, with its frame, before the work begins"
    # Promise: "one that is missing or broken ..."
    def test_a_gap_is_named_before_the_work(self):
        for command, (name, words, kind) in COMMANDS.items():
            text = self.refused(harness.NO_INPUT, *command.split(), name.format("####"), *words, "-o", f"all.####{kind}",
                                "--frames", "-1-2", mentions=(f"'{name.format('0000')}' (frame 0)", "(frame 1)"))
            self.assertNotIn("(frame 2)", text)

    # Promise: "`--frames LIST` means the same" ...
    def test_what_is_no_sequence(self):
        for command, (name, words, kind) in COMMANDS.items():
            start = (*command.split(), name.format("####"), *words)
            for rest, mention in ((("-o", f"all{kind}", "--frames", "-1,2"), f"all.####{kind}"),
                                  (("-o", f"a.##.##{kind}", "--frames", "-1,2"), "more than one frame pattern"),
                                  (("-o", f"all.####{kind}", "--frames", "2-1"), "--frames is '2-1'"),
                                  (("-o", f"all.####{kind}", "--frames", "one"), "--frames is 'one'"),
                                  (("-o", f"all.####{kind}", "--frames="), "--frames"),
                                  (("-o", f"all.####{kind}"), "no frame is given"),
                                  (("-o", f"all.####{kind}", "--keep-going"), "--keep-going")):
                # Without --frames the name of the input may be that of a file.
                words_now = start if "--frames" in " ".join(map(str, rest)) else (*command.split(), name.format("0002"), *words)
                self.refused(harness.USAGE, *words_now, *rest, mentions=mention)

    # Promise: "one that is missing or broken ..."
    def test_a_failure_names_its_frame(self):
        self.write("in.0001.obj", "v 0 0 0\n")
        words = ("sdf", "in.####.obj", "-o", "d.$F4.vdb", "--resolution", 16, "--frames", "-1,1-2", "--progress", "none")
        run = self.run_program(*words)
        self.assertEqual(run.returncode, harness.BAD_DATA, run.stderr)
        self.assertRegex(run.stderr.decode(), r"(?m)^juliavdb: frame 1: [^\n]*in\.0001\.obj")
        self.assertEqual([name for name in self.listing() if name.startswith("d.")], [], "it is found before the work")
        run = self.run_program(*words, "--keep-going")
        self.assertEqual(run.returncode, harness.BAD_DATA, run.stderr)
        self.assertEqual([name for name in self.listing() if name.startswith("d.")], ["d.-0001.vdb", "d.0002.vdb"])

    # Promise: "`####` and `%04d` work too" ...
    def test_notations(self):
        """As Houdini, Nuke, Blender and printf write them; printf counts the sign."""
        for pattern, made in (("$F4", "-0001"), ("${F4}", "-0001"), ("$F", "-1"), ("####", "-0001"), ("%04d", "-001"), ("%d", "-1"), ("<F4>", "-0001"),
                              ("<F>", "-1"), ("@@@@", "-0001")):
            self.ok("sdf", "in.-0001.obj", "-o", f"n.{pattern}.vdb", "--resolution", 16, "--frames", "-1")
            self.assertEqual([name for name in self.listing() if name.startswith("n.")], [f"n.{made}.vdb"])
            self.path(f"n.{made}.vdb").unlink()

    def test_a_count_of_earlier_versions(self):
        """--frames of 'render --field' was a count once."""
        words = ("render", "--field", "in.0002.obj", "--size", "16x16", *SMALL, "-o", "t.####.png", "--frames")
        self.refused(harness.USAGE, *words, 36, mentions=("--frames 1-36 --turn 360", "--frames 36-36"))
        self.ok(*words, "36-36")
        self.assertTrue(self.path("t.0036.png").is_file())

    def test_a_stack_is_no_sequence(self):
        self.refused(harness.USAGE, "slice", "in.0002.obj", "--stack", "--size", 6, "-o", "s.####.png", "--frames", "1-2",
                     mentions="--frames")


if __name__ == "__main__":
    harness.main()

# SPDX-License-Identifier: Apache-2.0
"""Plans of frames and of cells of a contact sheet: their tasks against the commands that make each file by itself."""

import json

import harness
from harness import BAD_DATA, CANNOT_CREATE, NO_INPUT, USAGE

LOW = ("--sdf-resolution", 20, "--resolution", 20)
KEYS = ("--key", "alpha@1=20", "--key", "alpha@3=60")


class PlanTest(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(2)))

    def plan(self, name):
        return json.loads(self.bytes(f"{name}/manifest.json"))

    def assertSameFile(self, first, second):
        self.assertTrue(self.bytes(first) == self.bytes(second), f"{first} and {second} differ")


class Frames(PlanTest):

    # Promise: A sequence has "the same ..."
    def test_a_frame_is_what_fractal_makes_of_its_values(self):
        self.ok("plan", "frames", "s.obj", *LOW, "--frames", "1-4", *KEYS, "--key", "texture-translate@2=0,0,0",
                "--key", "texture-translate@4=0.5,-1,0", "--ease", "texture-translate=smooth", "--make", "vdb,ply,stl",
                "-o", "p")
        self.assertEqual(self.listing(), ["p", "p/manifest.json", "s.obj"])
        self.ok("task", "p", "--range", "1-4")
        values = {1: (20, "0,0,0"), 2: (40, "0,0,0"), 3: (60, "0.25,-0.5,0"), 4: (60, "0.5,-1,0")}
        for frame, (alpha, at) in values.items():
            with self.subTest(frame=frame):
                typed = ("--alpha", alpha, f"--texture-translate={at}")
                self.ok("fractal", "s.obj", *LOW, *typed, "-o", "x.vdb", "--mesh", "x.ply")
                self.ok("fractal", "s.obj", *LOW, *typed, "-o", "x.vdb", "--mesh", "x.stl")
                for extension in ("vdb", "ply", "stl"):
                    self.assertSameFile(f"p/out/s.000{frame}.{extension}", f"x.{extension}")

    def test_frames_share_one_distance_field_which_goes_with_the_last(self):
        """Each wants distances up to another depth. Tasks run in processes of their own, in no particular order."""
        self.ok("plan", "frames", "s.obj", *LOW, "--frames", "1-4", "--key", "detail@1=0.1", "--key", "detail@4=0.6",
                "-o", "p")
        for frame in (2, 4, 1, 3):
            self.ok("task", "p", "--index", frame)
            kept = [name for name in self.listing() if name.startswith("p/targets/")]
            self.assertLessEqual(len([name for name in kept if name.endswith(".vdb")]), 2,
                                 "the distances, and the coarse ones that the thickness is found by")
        self.assertEqual(kept, [])
        self.assertFalse(self.path("p/targets").exists())
        text = self.ok("status", "p", data=True)
        self.assertIn("evaluated nodes: ", text)
        self.assertNotIn("triangles", text, "the plan makes no mesh")
        for frame in (1, 2, 3, 4):
            self.ok("fractal", "--config", f"p/out/s.000{frame}.vdb", "-o", "x.vdb")
            self.assertSameFile(f"p/out/s.000{frame}.vdb", "x.vdb")

    def test_a_recipe_that_cannot_be_made_is_bad_data_of_the_plan(self):
        self.ok("plan", "frames", "s.obj", *LOW, "--frames", "1-2", "--key", "alpha@1=-5", "--key", "alpha@2=40", "-o", "p")
        run = self.run_program("task", "p", "--index", 1)
        self.assertIn("recipe of task 1", self.check_refusal(run, BAD_DATA, "task p --index 1"))
        self.ok("task", "p", "--index", 2)

    # Promise: A sequence has "the same ..."
    def test_each_frame_has_its_own_target(self):
        for frame, radius in ((8, 1), (9, 1.5), (10, 2)):
            self.write(f"in.{frame:04}.obj", harness.obj(harness.sphere(2, radius)))
        even = ("--voxel-size", 0.1, "--sdf-resolution", 24)  # in all frames
        self.ok("plan", "frames", "in.####.obj", *even, "--frames", "8-10", "-o", "p")
        self.ok("task", "p", "--range", "1-3")
        for frame in (8, 9, 10):
            self.ok("fractal", f"in.{frame:04}.obj", *even, "-o", "x.vdb")
            self.assertSameFile(f"p/out/in.{frame:04}.vdb", "x.vdb")
        self.ok("plan", "frames", "in.%04d.obj", *even, "--frames", "8-10", "--key", "alpha@8=20", "--key",
                "alpha@10=60", "--name", "b", "-o", "q")
        self.write("in.0009.obj", harness.obj(harness.sphere(2, 3)))
        self.refused(NO_INPUT, "plan", "frames", "in.####.obj", *even, "--frames", "8-11", "-o", "r",
                     mentions="in.0011.obj")
        run = self.run_program("task", "q", "--index", 2)
        self.check_refusal(run, BAD_DATA, "task q --index 2")
        self.assertIn(b"in.0009.obj", run.stderr)
        self.ok("task", "q", "--index", 3)
        self.ok("fractal", "in.0010.obj", *even, "--alpha", 60, "-o", "x.vdb")
        self.assertSameFile("q/out/b.0010.vdb", "x.vdb")

    def test_maps_without_a_target(self):
        self.ok("plan", "frames", "--map", "quadratic", "--iterations", 4, "--resolution", 20, "--frames", "0-2",
                "--key", "c@0=-0.2,0.6,0.2,0.2", "--key", "c@2=-0.2,0.2,0.2,0.4", "-o", "p")
        self.ok("task", "p", "--index", 2)
        self.ok("fractal", "--map", "quadratic", "--iterations", 4, "--resolution", 20, "--c=-0.2,0.4,0.2,0.30000000000000004",
                "-o", "x.vdb")
        self.assertSameFile("p/out/quadratic.0001.vdb", "x.vdb")

    def test_the_recipe_of_a_file_goes_on(self):
        self.ok("fractal", "s.obj", *LOW, "--alpha", 30, "--texture", "random", "-o", "f.vdb")
        self.ok("plan", "frames", "--config", "f.vdb", "--frames", 2, "--key", "texture-seed@1=3", "-o", "p")
        self.ok("task", "p", "--index", 1)
        self.ok("fractal", "--config", "f.vdb", "--texture-seed", 3, "-o", "x.vdb")
        self.assertSameFile("p/out/s.0002.vdb", "x.vdb")

    # Promise: A plan's folder that cannot ...
    def test_refusals(self):
        frames = ("plan", "frames", "s.obj", *LOW, "-o", "p")
        self.all_refused(USAGE, [
            frames,
            (*frames, "--frames", "3-1", *KEYS),
            (*frames, "--frames", "x", *KEYS),
            (*frames, "--frames", "1-3", "--key", "alfa@1=20"),
            (*frames, "--frames", "1-3", "--key", "alpha=20"),
            (*frames, "--frames", "1-3", "--key", "alpha@1=forty"),
            (*frames, "--frames", "1-3", "--key", "iterations@1=0"),
            (*frames, "--frames", "1-3", *KEYS, "--key", "alpha@3=10"),
            (*frames, "--frames", "1-3", *KEYS, "--alpha", 20),
            (*frames, "--frames", "1-3", *KEYS, "--ease", "fast"),
            (*frames, "--frames", "1-3", *KEYS, "--ease", "beta=smooth"),
            (*frames, "--frames", "1-3", *KEYS, "--make", "png"),
            (*frames, "--frames", "1-3", *KEYS, "--name", "a/b"),
            ("plan", "frames", "s.obj", "--frames", "1-3", *KEYS),
            ("plan", "frames", "--frames", "1-3", *KEYS, "-o", "p"),
            ("plan",),
            ("plan", "films", "-o", "p"),
        ])
        self.refused(USAGE, *frames, "--frames", "1-3", "--key", "texture-seed@1=1", "--key", "texture-seed@3=2",
                     mentions=("frame 2", "--texture-seed", "1.5"))
        self.path("full").mkdir()
        self.write("full/x", "x")
        self.path("astray").symlink_to("nowhere")
        self.write("hole.obj", harness.obj(harness.with_hole(harness.sphere(2))))
        for folder in ("full", "s.obj", "s.obj/p", "astray", "astray/p"):
            self.refused(CANNOT_CREATE, "plan", "frames", "s.obj", "--frames", "1-3", *KEYS, "-o", folder,
                         mentions=folder)
            # Before any work: the target is not looked at.
            self.refused(CANNOT_CREATE, "plan", "tiles", "hole.obj", *LOW, "-o", folder, mentions=folder)


class Cells(PlanTest):

    def setUp(self):
        super().setUp()
        self.ok("sheet", "s.obj", *LOW, "--size", "16x16", "--samples", 1, "--vary", "alpha=20,wrong,40,60", "-o",
                "x.png")

    # Promise of farm.md#sequences-and-contact-sheets: Cells of a sheet as tasks are what their recipes make
    def test_a_task_is_what_fractal_makes_of_the_cell(self):
        self.ok("plan", "sheet", "x.json#3-4,1", "--make", "vdb,obj", "-o", "p")
        self.ok("task", "p", "--range", "1-9")
        for cell in (1, 3, 4):
            self.ok("fractal", "--config", f"x.json#{cell}", "-o", "c.vdb", "--mesh", "c.obj")
            self.assertSameFile(f"p/out/x.000{cell}.vdb", "c.vdb")
            self.assertSameFile(f"p/out/x.000{cell}.obj", "c.obj")
        self.assertEqual([task["writes"] for task in self.plan("p")["tasks"]],
                         [[f"out/x.000{cell}.vdb", f"out/x.000{cell}.obj"] for cell in (1, 3, 4)])

    # Promise: Cells of a sheet as tasks ...
    def test_options_stand_over_those_of_the_cells(self):
        self.ok("plan", "sheet", "x.json", "--resolution", 26, "--beta", 0.01, "-o", "p")
        self.assertEqual(len(self.plan("p")["tasks"]), 3, "the cell with an error is left out")
        self.ok("task", "p", "--index", 2)
        self.ok("fractal", "--config", "x.json#3", "--resolution", 26, "--beta", 0.01, "-o", "c.vdb")
        self.assertSameFile("p/out/x.0003.vdb", "c.vdb")

    def test_refusals(self):
        self.all_refused(USAGE, [
            *[("plan", "sheet", f"x.json#{cells}", "-o", "p") for cells in ("", "0", "5", "1,1", "4-3", "2", "a")],
            ("plan", "sheet", "-o", "p"),
            ("plan", "sheet", "x.json"),
            ("plan", "sheet", "x.json", "-o", "p", "--alpha", "x"),
            ("plan", "sheet", "x.json", "-o", "p", "--config", "x.json#1"),
        ])
        self.refused(NO_INPUT, "plan", "sheet", "none.json#1", "-o", "p", mentions="none.json")
        self.refused(BAD_DATA, "plan", "sheet", "s.obj#1", "-o", "p", mentions="s.obj")
        self.write("s.obj", harness.obj(harness.sphere(3)))
        self.refused(BAD_DATA, "plan", "sheet", "x.json", "-o", "p", mentions="s.obj")


if __name__ == "__main__":
    harness.main()

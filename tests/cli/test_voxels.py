# SPDX-License-Identifier: Apache-2.0
"""What is finer than the voxels is said, and --resolution auto chooses voxels that show it."""
import json
import re

import harness
from harness import USAGE

COARSE = ("--resolution", 30, "--sdf-resolution", 100)


def plate(thickness):
    points, faces = harness.cube(1.0)
    return harness.obj(([(x, thickness * y, z) for x, y, z in points], faces))


def rod(thickness):
    points, faces = harness.cube(1.0)
    return harness.obj(([(x, thickness * y, thickness * z) for x, y, z in points], faces))


class Voxels(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(3)))
        self.write("thin.obj", plate(0.06))

    # Promise of textures.md: Where "more than a quarter of it is narrower than two voxels", `fractal` and `plan tiles` say so,
    #   "and name a resolution that shows all but a tenth"
    def test_what_is_finer_is_said_with_a_resolution_that_shows_it(self):
        said = self.ok("fractal", "thin.obj", *COARSE, "--mesh", "t.ply")
        share, resolution = re.search(r"warning: ([\d.]+) % of the texture is finer than two voxels; --resolution (\d+) shows",
                                      said).groups()
        self.assertGreater(float(share), 25)
        self.assertNotIn("warning", self.ok("fractal", "thin.obj", "--sdf-resolution", 100, "--resolution", resolution,
                                            "--box=-0.2,-1,-0.2,0.2,1,0.2", "--mesh", "t.ply"))
        # In the words of the command.
        self.assertRegex(self.ok("fractal", "thin.obj", "--sdf-resolution", 100, "--voxel-size", 0.07, "--mesh", "t.ply"),
                         r"finer than two voxels; --voxel-size [\d.e-]+ shows")

    # Promise: Where "more than a quarter ..."
    def test_nothing_is_said_where_it_shows(self):
        self.assertNotIn("warning", self.ok("fractal", "s.obj", "--resolution", 60, "--sdf-resolution", 100, "-o", "s.vdb"))

    # Promise of controls.md: Where the core that detail leaves "is thinner than two voxels", the program says so, and "names a
    #   resolution that is high enough"
    def test_a_thin_core_is_said(self):
        said = self.ok("fractal", "thin.obj", "--resolution", 60, "--sdf-resolution", 100, "--detail", 0.8, "--mesh", "t.ply")
        self.assertRegex(said, r"warning: .*under [\d.]+ % of the surface the core that --detail leaves is thinner than two voxels")
        self.assertNotIn("core", self.ok("fractal", "thin.obj", "--resolution", 60, "--sdf-resolution", 100, "--detail", 0.2,
                                         "--mesh", "t.ply"))

    def test_the_summary_has_the_shares(self):
        run = self.run_program("fractal", "thin.obj", *COARSE, "--mesh", "t.ply", "--progress", "json")
        counts = json.loads(run.stderr.decode().splitlines()[-1])["counts"]
        self.assertTrue(0.25 < counts["textureBelowTwoVoxels"] <= 1)
        self.assertTrue(0 <= counts["coreBelowTwoVoxels"] <= 1)
        self.assertNotIn("resolution", counts)

    # Promise of textures.md: "The recipe holds the number that was chosen, so that it gives the same bytes on a machine with
    #   other memory"; a sequence "has one number for all of its frames"
    def test_auto_records_the_number_and_has_its_bytes(self):
        box = ("--sdf-resolution", 100, "--box=-0.2,-1,-0.2,0.2,1,0.2")
        said = self.ok("fractal", "thin.obj", *box, "--resolution", "auto", "-o", "a.vdb", "--mesh", "a.ply")
        number, = re.findall(r"^resolution (\d+): all but [\d.]+ % of the texture", said, re.MULTILINE)
        self.assertEqual(self.info("a.vdb")["recipe"]["resolution"], number)
        self.ok("fractal", "thin.obj", *box, "--resolution", number, "-o", "b.vdb", "--mesh", "b.ply", "--threads", 1)
        self.assertEqual(self.bytes("a.vdb"), self.bytes("b.vdb"))
        self.assertEqual(self.bytes("a.ply"), self.bytes("b.ply"))
        self.ok("fractal", "--config", "a.vdb", "-o", "c.vdb")
        self.assertEqual(self.bytes("a.vdb"), self.bytes("c.vdb"))

    # Promise: "The recipe holds the number ..."
    def test_auto_keeps_within_the_memory(self):
        said = self.ok("fractal", "thin.obj", "--sdf-resolution", 100, "--resolution", "auto", "--memory", "190M", "--mesh", "a.obj")
        number, = re.findall(r"^resolution (\d+): limited by the memory", said, re.MULTILINE)
        self.assertLess(int(number), 300)

    # Promise: "The recipe holds the number ..."
    def test_a_sequence_and_plans_have_one_number(self):
        frames = ("thin.obj", "--sdf-resolution", 100, "--box=-0.1,-1,-0.1,0.1,1,0.1", "--resolution", "auto", "--frames", "1-2",
                  "--key", "frequency@1=1.5", "--key", "frequency@2=2")
        said = self.ok("fractal", *frames, "-o", "f.####.vdb")
        number, = re.findall(r"^resolution (\d+) for all frames", said, re.MULTILINE)
        self.assertEqual({self.info(f"f.000{i}.vdb")["recipe"]["resolution"] for i in (1, 2)}, {number})
        self.assertIn("kept 2 of 2 frames", self.ok("fractal", *frames, "-o", "f.####.vdb"))
        self.assertIn(f"resolution {number} for all frames", self.ok("plan", "frames", *frames, "-o", "plan"))
        self.assertRegex(self.bytes("plan/manifest.json").decode(), f'"resolution":\\s*"{number}"')
        tiles = self.ok("plan", "tiles", *frames[:4], "--resolution", "auto", "-o", "tiles", "--tiles", 2, "--memory", "190M")
        self.assertRegex(tiles, r"resolution \d+: all but")
        self.assertRegex(self.bytes("tiles/manifest.json").decode(), r'"resolution":\s*"\d+"')

    def test_bad_values(self):
        self.all_refused(USAGE, [
            ("fractal", "s.obj", "--resolution", "auto", "--voxel-size", 0.1, "-o", "x.vdb"),
            ("fractal", "s.obj", "--resolution", "fine", "-o", "x.vdb"),
            ("fractal", "s.obj", "--resolution", "Auto", "-o", "x.vdb"),
            ("fractal", "--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", "--resolution", "auto", "-o", "x.vdb"),
            ("sdf", "s.obj", "--resolution", "auto", "-o", "x.vdb"),
            ("fractal", "s.obj", "--sdf-resolution", "Auto", "-o", "x.vdb"),
            ("fractal", "s.obj", "--sdf-resolution", "auto", "--sdf-voxel-size", 0.1, "-o", "x.vdb")], mentions=["resolution"])

    # Promise: "`auto`, the default, takes ..."
    def test_thin_parts_get_finer_distances(self):
        self.write("rod.obj", rod(0.03))
        low = ("--resolution", 60, "--detail", 0.2)
        said = self.ok("fractal", "rod.obj", *low, "-o", "a.vdb")
        number, = re.findall(r"^sdf-resolution (\d+): the target is slender or has thin parts$", said, re.MULTILINE)
        self.assertGreater(int(number), 200)
        self.assertEqual(self.info("a.vdb")["recipe"]["sdf-resolution"], number)
        for words in (("--sdf-resolution", number), ("--sdf-resolution", "auto", "--threads", 1)):
            self.ok("fractal", "rod.obj", *low, *words, "-o", "b.vdb")
            self.assertEqual(self.bytes("a.vdb"), self.bytes("b.vdb"), words)
        self.assertNotIn("sdf-resolution", self.ok("fractal", "s.obj", *low, "-o", "c.vdb"))
        self.assertEqual(self.info("c.vdb")["recipe"]["sdf-resolution"], "200")

    # Promise: "`auto`, the default, takes ..."
    def test_a_sequence_of_meshes_has_one_number(self):
        self.write("r.0001.obj", rod(0.05))
        self.write("r.0002.obj", rod(0.025))
        words = ("r.####.obj", "--frames", "1-2", "--resolution", 40, "--detail", 0.2)
        self.ok("fractal", *words, "-o", "f.####.vdb")
        numbers = {self.info(f"f.000{i}.vdb")["recipe"]["sdf-resolution"] for i in (1, 2)}
        self.assertEqual(len(numbers), 1)
        self.ok("fractal", "r.0002.obj", *words[3:], "-o", "alone.vdb")
        self.assertEqual(numbers, {self.info("alone.vdb")["recipe"]["sdf-resolution"]})
        self.ok("plan", "frames", *words, "-o", "plan")
        self.assertRegex(self.bytes("plan/manifest.json").decode(), f'"sdf-resolution":\\s*"{numbers.pop()}"')


if __name__ == "__main__":
    harness.main()

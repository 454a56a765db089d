# SPDX-License-Identifier: Apache-2.0
"""The words that mean something on a shape, --detail, --outward, --mask and --origin, and what the program says of them."""
import math
import re

import harness
from harness import BAD_DATA, USAGE

LOW = ("--resolution", 40, "--sdf-resolution", 50)


def distances(mesh, radius=1.0):
    """From a ball about 0, positive outside."""
    return [math.dist(point, (0, 0, 0)) - radius for point in mesh.points]


class Detail(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(4)))
        self.write("t.obj", harness.obj(harness.torus()))

    def fractal(self, *options):
        """@return the mesh, and what was said"""
        said = self.ok("fractal", *options, *LOW, "--mesh", "m.ply")
        return harness.read_ply(self.bytes("m.ply")), said

    # Promise: "every point with phi <= ..."
    def test_it_reaches_as_deep_as_asked_for(self):
        voxel = 2 / 40
        for detail, outward in ((0.2, 0.1), (0.5, 0), (0.4, 0.3)):
            mesh, _ = self.fractal("s.obj", "--detail", detail, "--outward", outward)
            found = distances(mesh)
            self.assertGreater(min(found), -detail - voxel)
            self.assertLess(max(found), outward + voxel)
            self.assertLess(min(found), -0.5 * detail)

    # Promise of controls.md: What the program "chose and what is left", and a warning where little is
    def test_it_says_what_was_chosen_and_what_is_left(self):
        mesh, said = self.fractal("s.obj", "--detail", 0.2)
        self.assertRegex(said, r"origin at .*: detail 0\.2 is alpha [\d.]+( to [\d.]+)?, beta -?[\d.e-]+")
        share, = re.findall(r"the set holds ([\d.]+) % of the target's volume in \d+ island", said)
        target = 4 / 3 * math.pi
        self.assertAlmostEqual(float(share), 100 * harness.volume_of(mesh) / target, delta=2)
        self.assertNotIn("warning", said)

    # Promise: What the program "chose and what ..."
    def test_little_is_left_with_a_warning(self):
        _, said = self.fractal("t.obj", "--alpha", 9, "--origin=0.35,0,0")
        self.assertIn("warning: less than half", said)
        self.assertIn("--detail", said)

    # Promise: `auto` takes the deepest ...
    # Promise: The recorded origin makes ...
    def test_the_origin_is_found_where_the_middle_of_the_box_is_a_hole(self):
        said = self.ok("fractal", "t.obj", *LOW, "-o", "t.vdb")
        where = [float(x) for x in re.search(r"origin at ([^:]+):", said).group(1).split(",")]
        self.assertAlmostEqual(math.hypot(where[0], where[1]) if abs(where[2]) < 0.1 else math.hypot(where[0], where[2]),
                               0.7, delta=0.05)
        facts = self.info("t.vdb")["metadata"]
        again = self.ok("fractal", "t.obj", *LOW, f"--origin={facts['julia_origin_at']}", "-o", "u.vdb")
        self.assertEqual(self.info("u.vdb")["metadata"]["julia_shell"], facts["julia_shell"])
        self.assertIn("the set holds", again)
        self.refused(USAGE, "fractal", "t.obj", *LOW, "--origin", "centre", "-o", "x.vdb", mentions="inside the target")

    # Promise: What the program "chose and what ..."
    def test_info_speaks_both_languages(self):
        self.ok("fractal", "s.obj", *LOW, "--detail", 0.5, "-o", "d.vdb")
        told = self.info("d.vdb")
        self.assertEqual(told["recipe"]["detail"], "0.5")
        low, high = map(float, told["metadata"]["julia_alpha_range"].split(","))
        self.assertTrue(0 < low <= high)
        thin, thick = map(float, told["metadata"]["julia_thickness"].split(","))
        self.assertAlmostEqual(thin, 1, delta=0.05)
        self.assertAlmostEqual(thick, 1, delta=0.05)
        # docs/design.md 2.8: alpha = K / h with h = 0.96 (D + O) tau, and beta from the same.
        scale, (K, P) = float(told["metadata"]["julia_space_scale"]), map(float, told["metadata"]["julia_detail_law"].split(","))
        h = [0.96 * (0.5 + 0.3) * tau / scale for tau in (thin, thick)]
        self.assertAlmostEqual(low / (K / h[1]), 1, delta=1e-3)
        self.assertAlmostEqual(high / (K / h[0]), 1, delta=0.1)
        self.assertGreaterEqual(P, 0)
        share = (0.3 / (0.5 + 0.3) - 0.02) / 0.96 - math.log(float(told["recipe"].get("escape", 2))) / K
        for beta, width in zip(map(float, told["metadata"]["julia_beta_range"].split(",")), h if share > 0 else h[::-1]):
            self.assertAlmostEqual(beta / (share * width), 1, delta=0.1)
        mesh = self.info("t.obj")
        self.assertAlmostEqual(mesh["depth"], 0.3, delta=0.02)
        self.assertEqual(mesh["parts"], 1)

    # Promise: Where the mask is 0, "the plain ..."
    def test_a_mask_of_zeros_gives_the_target_and_says_so(self):
        mesh, said = self.fractal("s.obj", "--detail", 0.5, "--mask", 0)
        self.assertLess(max(map(abs, distances(mesh))), 2 / 40)
        self.assertIn("the mask is 0 everywhere", said)

    # Promise of options.md: Detail and the papers' numbers exclude each other; over a recipe the one displaces the other
    def test_detail_and_alpha_exclude_each_other(self):
        for first, second in (("detail", "alpha"), ("detail", "beta"), ("outward", "alpha"), ("outward", "beta")):
            self.refused(USAGE, "fractal", "s.obj", "-o", "x.vdb", *LOW, f"--{first}", 0.1, f"--{second}", 0.1,
                         mentions=[f"--{first}", f"--{second}"])
        # Given over a recipe, the one displaces the other.
        self.ok("fractal", "s.obj", *LOW, "--detail", 0.5, "-o", "d.vdb")
        self.ok("fractal", "--config", "d.vdb", "--alpha", 30, "-o", "a.vdb")
        recipe = self.info("a.vdb")["recipe"]
        self.assertNotIn("detail", recipe)
        self.assertNotIn("outward", recipe)
        self.assertEqual((recipe["alpha"], recipe["beta"]), ("30", "0"))
        self.ok("fractal", "--config", "a.vdb", "--detail", 0.2, "-o", "b.vdb")
        recipe = self.info("b.vdb")["recipe"]
        self.assertNotIn("alpha", recipe)
        self.assertEqual((recipe["detail"], recipe["outward"]), ("0.2", "0.3"))

    # Promise: A mesh that bounds no volume ...
    def test_a_wire_thinner_than_its_voxels_is_refused_with_a_way_out(self):
        points, faces = harness.sphere(3)
        self.write("wire.obj", harness.obj(([(x, 0.002 * y, 0.002 * z) for x, y, z in points], faces)))
        wire = ("fractal", "wire.obj", "--resolution", 40)
        self.refused(BAD_DATA, *wire, "--sdf-resolution", 200, "-o", "w.vdb", mentions=["too thin", "--sdf-resolution"])
        for finer in (("--sdf-resolution", 800), ()):
            self.ok(*wire, *finer, "-o", "w.vdb")

    def test_an_empty_result_of_a_target_advises_no_box(self):
        run = self.run_program("fractal", "s.obj", "-o", "x.vdb", "--alpha", 10, "--beta=-0.4", *LOW)
        self.assertEqual(run.returncode, BAD_DATA)
        said = run.stderr.decode()
        self.assertNotIn("box", said)
        self.assertIn("beta", said)


if __name__ == "__main__":
    harness.main()

# SPDX-License-Identifier: Apache-2.0
"""What a field says of points: each answer beside a slow one by numpy alone, or beside what files say."""
import itertools
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))

import harness

try:
    import juliavdb
    import numpy as np
except ImportError as error:
    print(f"skipped: {error}")
    juliavdb = None

SMALL = {"sdf_resolution": 40, "resolution": 30}
C, STEPS = (-0.2, 0.6, 0.2, 0.2), 6


def times(p, q):
    """Hamilton's product of rows of quaternions."""
    (a, b, c, d), (e, f, g, h) = np.moveaxis(p, -1, 0), np.moveaxis(q, -1, 0)
    return np.stack([a * e - b * f - c * g - d * h, a * f + b * e + c * h - d * g,
                     a * g - b * h + c * e + d * f, a * h + b * g - c * f + d * e], axis=-1)


def quadratic_orbit(points, c, steps, escape):
    """The orbits of q^2 + c one by one: iterates (n, steps + 1, 4) with NaN after the last, steps, whether each escaped."""
    iterates = np.full((len(points), steps + 1, 4), np.nan)
    taken, escaped = np.zeros(len(points), int), np.zeros(len(points), bool)
    for i, point in enumerate(points):
        q = np.array([*point, 0.0])
        iterates[i, 0] = q
        while np.linalg.norm(q) < escape and taken[i] < steps:
            q = times(q, q) + c
            taken[i] += 1
            iterates[i, taken[i]] = q
        escaped[i] = np.linalg.norm(q) >= escape
    return iterates, taken, escaped


@unittest.skipUnless(juliavdb, "the Python module was not built, or there is no numpy")
class FieldTest(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.mesh = harness.torus()
        self.write("torus.obj", harness.obj(self.mesh))
        self.torus = str(self.path("torus.obj"))
        self.random = np.random.default_rng(1)

    def points(self, field, count):
        return self.random.uniform(*field.bounds, (count, 3))

    @staticmethod
    def quadratic():
        return juliavdb.Field(map="quadratic", c=C, iterations=STEPS, resolution=20, precision="double")

    def methods(self, field):
        return {"call": field, "inside": field.inside, "distance": field.distance, "thickness": field.thickness,
                "exponent": field.exponent, "versor": field.versor, "trap": field.trap, "gradient": field.gradient,
                "orbit": lambda points, **more: field.orbit(points, **more).log_moduli,
                "decide": lambda points, **more: field.decide(points, 0.01, **more)}


MASK = 2**64 - 1


def escape_of(field):
    return float(field.metadata.get("julia_escape", field.metadata.get("julia_radius")))


class Shapes(FieldTest):

    # Promise of python.md: "Points are arrays of any shape (..., 3)", in any number of threads; other arrays raise a `ValueError`
    def test_any_shape_gives_the_same_numbers(self):
        field = juliavdb.Field(self.torus, **SMALL)
        points = self.points(field, 120)
        for name, method in self.methods(field).items():
            with self.subTest(method=name):
                flat = method(points)
                self.assertEqual(len(flat), 120)
                for shape in ((4, 30), (2, 3, 20), (1, 120, 1)):
                    result = method(points.reshape(*shape, 3))
                    self.assertEqual(result.shape, (*shape, *flat.shape[1:]))
                    self.assertTrue(np.array_equal(result.reshape(flat.shape), flat, equal_nan=flat.dtype.kind == "f"))
                one = method(points[7])
                self.assertEqual(np.shape(one), flat.shape[1:])
                self.assertTrue(np.array_equal(one, flat[7], equal_nan=flat.dtype.kind == "f"))
                self.assertEqual(method(np.empty((0, 5, 3))).shape, (0, 5, *flat.shape[1:]))

    # Promise: "Points are arrays of any ..."
    def test_layout_and_kind_do_not_matter(self):
        field = juliavdb.Field(self.torus, **SMALL)
        points = self.points(field, 50).astype(np.float32)
        values = field(points.astype(np.float64))
        for same in (points, np.asfortranarray(points), np.repeat(points, 2, axis=0)[::2], points.tolist()):
            self.assertTrue(np.array_equal(field(same), values))
        self.assertTrue(np.array_equal(field(np.array([[1, 0, 0]])), field([[1.0, 0.0, 0.0]])))

    # Promise: "Points are arrays of any ..."
    def test_threads_change_nothing(self):
        field = juliavdb.Field(self.torus, **SMALL)
        points = self.points(field, 5000)
        for name, method in self.methods(field).items():
            with self.subTest(method=name):
                first = method(points, threads=1)
                for threads in (2, 7):
                    self.assertTrue(np.array_equal(method(points, threads=threads), first,
                                                   equal_nan=first.dtype.kind == "f"))

    # Promise: "Points are arrays of any ..."
    def test_what_are_no_points(self):
        field = juliavdb.Field(self.torus, **SMALL)
        cases = [([1, 2], r"shape \(\.\.\., 3\).*it is \(2,\)"), (np.zeros((4, 2)), r"it is \(4, 2\)"),
                 (3.0, r"it is \(\)"), ([["a", "b", "c"]], "real numbers"), (np.zeros((1, 3), complex), "real numbers"),
                 (np.zeros((1, 3), bool), "real numbers"),
                 ([[0, 0, 0], [0, float("nan"), 1]], r"(points|centres)\[1\] is \(0, nan, 1\).*finite"),
                 (np.full((2, 2, 3), np.inf), r"\[0, 0\] is \(inf, inf, inf\)"), (None, "numbers|shape")]
        for name, method in self.methods(field).items():
            for points, words in cases:
                with self.subTest(method=name, words=words), self.assertRaisesRegex(ValueError, words):
                    method(points)
            for threads in (0, -1):
                with self.subTest(method=name, threads=threads), self.assertRaisesRegex(ValueError, "threads is"):
                    method([0, 0, 0], threads=threads)
        for radius in (-1, float("nan"), float("inf")):
            with self.assertRaisesRegex(ValueError, "radius is"):
                field.decide([[0, 0, 0]], radius)
        with self.assertRaisesRegex(ValueError, r"one for each centre, of the shape .*2.*it is \(3,\)"):
            field.decide(np.zeros((2, 3)), [1, 2, 3])
        for step in (0, -1, float("nan")):
            with self.assertRaisesRegex(ValueError, "step is"):
                field.gradient([0, 0, 0], step=step)

    # Promise: "Points are arrays of any ..."
    def test_what_a_map_without_a_target_has_not(self):
        field = self.quadratic()
        for name in ("distance", "thickness", "octave", "exponent"):
            with self.subTest(method=name), self.assertRaisesRegex(ValueError, "target"):
                getattr(field, name)([0, 0, 0])

    # Promise: "Points are arrays of any ..."
    def test_progress_cancels(self):
        field = juliavdb.Field(self.torus, **SMALL)
        for name, method in self.methods(field).items():
            with self.subTest(method=name), self.assertRaises(KeyboardInterrupt):
                method(np.zeros((200000, 3)), progress=lambda phase, share: False)


class Orbits(FieldTest):

    # Promise of python.md#the-field: What F is made of, beside slow answers by numpy: orbits, exponents, versors, traps,
    #   distances and thicknesses
    def test_orbits_of_a_quadratic_map_by_hand(self):
        field = self.quadratic()
        points = self.random.uniform(-1.4, 1.4, (400, 3))
        points[0] = (30, 0, 0)
        iterates, steps, escaped = quadratic_orbit(points, np.array(C), STEPS, escape_of(field))
        orbit = field.orbit(points)
        self.assertEqual((orbit.iterates.shape, orbit.log_moduli.shape), ((400, STEPS + 1, 4), (400, STEPS + 1)))
        self.assertTrue(np.array_equal(orbit.steps, steps))
        self.assertTrue({0, STEPS} < set(steps))
        self.assertTrue(np.array_equal(orbit.ends == "escaped", escaped))
        self.assertEqual(set(orbit.ends), {"escaped", "steps"})
        np.testing.assert_allclose(orbit.iterates, iterates, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(np.exp(orbit.log_moduli), np.linalg.norm(iterates, axis=-1), rtol=1e-9)

    # Promise: What F is made of, beside ...
    def test_the_field_is_the_last_logarithm_of_the_orbit(self):
        for options in ({"map": "quadratic", "c": C}, {"map": "mandelbulb"}, {"map": "cross"}, {"vertices": self.torus, **SMALL},
                        {"vertices": self.torus, "precision": "double", **SMALL}, {"vertices": self.torus, "exhaustive": True, **SMALL}):
            with self.subTest(options=options):
                field = juliavdb.Field(**options)
                points = self.points(field, 3000)
                orbit = field.orbit(points)
                last = np.take_along_axis(orbit.log_moduli, orbit.steps[:, None], axis=1)[:, 0]
                level = 0 if "vertices" in options else np.log(escape_of(field))
                if "exhaustive" in options:
                    self.assertTrue(np.array_equal(last < level, field.inside(points)))
                else:
                    np.testing.assert_allclose(field(points), last - level, rtol=1e-5, atol=2e-6)
                self.assertTrue((np.isnan(orbit.log_moduli).sum(axis=1) == orbit.log_moduli.shape[1] - 1 - orbit.steps).all())
                self.assertGreater(len(set(orbit.ends)), 1)
                self.assertTrue((last[orbit.ends == "escaped"] >= np.log(escape_of(field)) - 1e-6).all())
                self.assertTrue((orbit.steps[orbit.ends == "steps"] == orbit.log_moduli.shape[1] - 1).all())
                self.assertTrue(field.inside(points[orbit.ends == "trapped"]).all())

    # Promise: What F is made of, beside ...
    def test_each_step_of_a_shape_modulus_has_its_exponent_and_versor(self):
        """The steps of an orbit are first steps from its iterates."""
        field = juliavdb.Field(self.torus, precision="double", iterations=4, **SMALL)
        origin, scale = np.array(field.space[0]), field.space[1]
        points = self.points(field, 2000)
        orbit = field.orbit(points)
        np.testing.assert_allclose(orbit.iterates[:, 0, :3] * scale + origin, points, atol=1e-12)
        for step in range(1, 5):
            there = orbit.steps >= step
            if step > 1:  # later iterates have a fourth component, which a slice lacks
                there &= np.abs(orbit.iterates[:, step - 1, 3]) == 0
            before = orbit.iterates[there, step - 1, :3] * scale + origin
            if not len(before):
                continue
            np.testing.assert_allclose(orbit.log_moduli[there, step], field.exponent(before), rtol=1e-9, atol=1e-9)
            modulus = np.exp(orbit.log_moduli[there, step])
            np.testing.assert_allclose(orbit.iterates[there, step], modulus[:, None] * field.versor(before), rtol=1e-8, atol=1e-300)

    # Promise: What F is made of, beside ...
    def test_the_trap_is_the_smallest_iterate(self):
        for options in ({"map": "quadratic", "c": C}, {"map": "mandelbulb"}, {"vertices": self.torus, **SMALL}):
            with self.subTest(options=options):
                field = juliavdb.Field(**options)
                points = self.points(field, 2000)
                points[0] = (100, 0, 0)
                moduli = np.exp(field.orbit(points).log_moduli[:, 1:])
                nearest = np.fmin.reduce(moduli, axis=1)
                trap = field.trap(points)
                self.assertEqual(trap[0], np.inf)
                np.testing.assert_allclose(trap, np.where(np.isnan(nearest), np.inf, nearest), rtol=1e-9)


class Parts(FieldTest):

    # Promise: What F is made of, beside ...
    def test_one_iteration_is_the_exponent(self):
        field = juliavdb.Field(self.torus, iterations=1, precision="double", alpha=15, **SMALL)
        low, high = np.array(field.bounds)
        points = self.points(field, 3000)
        self.assertTrue(np.array_equal(field(points), field.exponent(points)))
        # E = alpha (phi - beta), phi in units of the map's space.
        phi = field.distance(points) / field.space[1]
        known = np.abs(phi) < 0.05
        self.assertGreater(known.sum(), 100)
        np.testing.assert_allclose(field.exponent(points)[known], 15 * phi[known], atol=1e-5)

    # Promise: What F is made of, beside ...
    def test_the_distance_of_a_ball(self):
        points, triangles = harness.sphere(4)
        self.write("ball.obj", harness.obj((points, triangles)))
        radius = np.linalg.norm(points, axis=1).mean()
        field = juliavdb.Field(str(self.path("ball.obj")), sdf_resolution=60)
        directions = self.random.normal(size=(500, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        at = radius + self.random.uniform(-0.05, 0.05, 500) * radius
        found = field.distance(directions * at[:, None])
        self.assertLess(np.abs(found - (at - radius)).max(), 0.02 * radius)
        # Far away is the band's width, with the side's sign.
        self.assertGreater(field.distance([50, 0, 0]), 0)

    # Promise: What F is made of, beside ...
    def test_distance_and_thickness_are_the_attributes_of_a_mesh(self):
        options = {"attributes": "depth,tau", **SMALL}
        made, field = juliavdb.fractal(self.torus, **options), juliavdb.Field(self.torus, **options)
        plain = juliavdb.Field(self.torus, **SMALL)
        for each in (field, plain):
            self.assertTrue(np.array_equal(each.distance(made.vertices).astype(np.float32), made.attributes["depth"]))
            self.assertTrue(np.array_equal(each.thickness(made.vertices).astype(np.float32), made.attributes["tau"]))

    def test_the_full_thickness_of_a_box_is_half_its_least_side(self):
        """Away from its edges. On a face, it rises to that from the edges, the more gently the more detail there is."""
        points, triangles = harness.cube(0.5)
        self.write("box.obj", harness.obj(((np.array(points) * (2, 1, 0.5)).tolist(), triangles)))
        at = self.random.uniform((-0.7, -0.2, -0.25), (0.7, 0.2, 0.25), (500, 3))
        on_faces = self.random.uniform((-1, -0.5, 0.25), (1, 0.5, 0.25), (500, 3))
        medians = []
        for detail in (0.16, 0.3, 0.8):
            field = juliavdb.Field(str(self.path("box.obj")), detail=detail, outward=0.1, sdf_resolution=60)
            full = field.thickness(at, limited=False)
            np.testing.assert_allclose(full, 0.25, rtol=0.02)
            for each in (at, on_faces):
                self.assertTrue((field.thickness(each) <= field.thickness(each, limited=False) * (1 + 1e-6)).all())
            medians.append(np.median(field.thickness(on_faces)))
        self.assertGreater(medians[0], medians[1])
        self.assertGreater(medians[1], medians[2])

    def test_the_octave_fits_the_frequency_into_the_thickness(self):
        """2^o = F / (2 tau) at the nodes; between them both are interpolated."""
        for frequency in ("fine", 0.7):
            field = juliavdb.Field(self.torus, texture="scales", frequency=frequency, **SMALL)
            number = {"fine": 4}.get(frequency, frequency)
            points = self.points(field, 2000)
            expected = np.log2(number * field.space[1] / (2 * field.thickness(points)))
            np.testing.assert_allclose(field.octave(points), expected, atol=0.02)
        with self.assertRaisesRegex(ValueError, "one frequency everywhere"):
            juliavdb.Field(self.torus, texture_seed=1, texture_roots=5, **SMALL).octave([0, 0, 0])

    def test_the_default_texture_is_the_one_of_the_design(self):
        """docs/design.md 2.11, by hand: the waves of scales, their blend of octaves, and how the seed draws them."""
        field = juliavdb.Field(self.torus, texture="scales", texture_seed=5, precision="double", **SMALL)
        points = self.points(field, 400)
        q = np.concatenate([(points - np.array(field.space[0])) / field.space[1], np.zeros((400, 1))], axis=1)

        def mixed(x):
            x = x + 0x9e3779b97f4a7c15 & MASK
            x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9 & MASK
            x = (x ^ x >> 27) * 0x94d049bb133111eb & MASK
            return x ^ x >> 31

        stream = mixed(mixed(5) + 1 & MASK)
        numbers = ((mixed(stream + i & MASK) >> 11) / 2**53 for i in itertools.count())

        def direction():
            while True:
                way = np.array([2 * next(numbers) - 1 for _ in range(4)])
                if 0.01 < way @ way <= 1:
                    return way / np.linalg.norm(way)

        def wave():
            way, stretch, cosine = direction(), 0.75 + 0.5 * next(numbers), direction()
            while True:
                sine = direction()
                sine = sine - (sine @ cosine) * cosine
                if sine @ sine > 0.01:
                    return stretch * way, cosine, sine / np.linalg.norm(sine)

        i, j, one = np.eye(4)[1], np.eye(4)[2], np.eye(4)[0]
        factors = [[(np.array([0.5, 0.8, 0.3, 0]), one, i)], [(np.array([0.5, -0.8, 0.3, 0]), one, j)],
                   [wave() for _ in range(4)]]

        def unit(value):
            return value / np.linalg.norm(value, axis=1)[:, None]

        def texture(p):
            product = np.tile(one, (len(p), 1))
            for waves in factors:
                phases = [2 * np.pi * (p @ w)[:, None] for w, _, _ in waves]
                product = times(product, unit(sum(c * np.cos(a) + s * np.sin(a) for a, (_, c, s) in zip(phases, waves))))
            return product

        octave = field.octave(points)
        k = np.floor(octave)
        f = octave - k
        t = (f * f * (3 - 2 * f))[:, None]
        scale = np.exp2(k)[:, None]
        found = field.versor(points)
        np.testing.assert_allclose(found, unit((1 - t) * texture(scale * q) + t * texture(2 * scale * q)), atol=1e-6)

    # Promise: What F is made of, beside ...
    def test_the_versor_of_roots_by_hand(self):
        roots = [((0.1, 0.2, -0.3, 0), 2), ((-0.4, 0.1, 0.2, 0.1), 3), ((0.2, -0.5, 0.1, 0), 1)]
        self.write("v.json", harness.rational_json([(*root, power) for root, power in roots]))
        field = juliavdb.Field(self.torus, texture=str(self.path("v.json")), precision="double", **SMALL)
        points = self.points(field, 500)
        origin, scale = np.array(field.space[0]), field.space[1]
        q = np.concatenate([(points - origin) / scale, np.zeros((500, 1))], axis=1)
        value = np.tile((1.0, 0, 0, 0), (500, 1))
        for root, power in roots:
            for _ in range(power):
                value = times(value, q - root)
        value /= np.linalg.norm(value, axis=1)[:, None]
        np.testing.assert_allclose(field.versor(points), value, atol=1e-12)

    # Promise of python.md: "their meshes and grids say where the nodes lie, so that F at these places agrees with them"
    def test_cross_maps_lie_where_their_definition_has_them(self):
        """By hand, of the pair D in scheme 4: f x g with f = r^2 (-sin 2phi, cos 2phi, 0) and g = (0, 0, 1)."""
        steps = 3
        field = juliavdb.Field(map="cross", pair="D", iterations=steps, precision="double", resolution=10, tolerance=0.4)
        points = self.random.uniform(-0.8, 0.8, (2000, 3))
        p = points.copy()
        for _ in range(steps):
            r2, angle = (p * p).sum(axis=1), 2 * np.arctan2(p[:, 1], p[:, 0])
            f = np.stack([-r2 * np.sin(angle), r2 * np.cos(angle), 0 * r2], axis=1)
            p = np.cross(f, (0, 0, 1)) + points
        # A shift by some share of so coarse a voxel would show.
        same = field.orbit(points).ends == "steps"
        self.assertGreater(same.sum(), 500)
        np.testing.assert_allclose(field(points)[same], np.log(np.linalg.norm(p, axis=1))[same] - np.log(2), atol=1e-9)
        self.assertEqual(field.versor(points).shape, (2000, 3))
        self.assertEqual(field.orbit(points).iterates.shape, (2000, steps + 1, 3))
        np.testing.assert_allclose(np.linalg.norm(field.versor(points), axis=1), 1, atol=1e-12)


class Gradients(FieldTest):

    # Promise of python.md: "The gradient is a central difference of F in doubles"; where steps differ, it is NaN
    def test_the_gradient_of_a_quadratic_map_by_hand(self):
        """The derivative of ln |q_n| along the orbit: dq' = dq q + q dq."""
        field = self.quadratic()
        points = self.random.uniform(-1.2, 1.2, (500, 3))
        iterates, steps, _ = quadratic_orbit(points, np.array(C), STEPS, escape_of(field))
        found = field.gradient(points)
        smooth = ~np.isnan(found).any(axis=1)
        self.assertGreater(smooth.mean(), 0.95)
        for axis in range(3):
            for i in np.flatnonzero(smooth):
                slope = np.eye(4)[axis]
                for q in iterates[i, :steps[i]]:
                    slope = times(slope, q) + times(q, slope)
                last = iterates[i, steps[i]]
                by_hand = last @ slope / (last @ last)
                self.assertAlmostEqual(found[i, axis] / max(1, abs(by_hand)), by_hand / max(1, abs(by_hand)), delta=1e-5)

    # Promise: "The gradient is a central ..."
    def test_gradients_are_differences_in_the_targets_units(self):
        big = 100 * np.array(self.mesh[0]) + (7, 8, 9), np.array(self.mesh[1])
        field = juliavdb.Field(*big, precision="double", iterations=2, **SMALL)
        points = self.points(field, 2000)
        found = field.gradient(points)
        step = 2e-4
        ways = np.stack([(field(points + step * axis) - field(points - step * axis)) / (2 * step) for axis in np.eye(3)], axis=1)
        # But for the few points that lie at a face of a cell of the distances, or where F jumps.
        scale = 1 + np.abs(ways).max(axis=1)
        with np.errstate(invalid="ignore"):
            close = np.abs(found - ways).max(axis=1) < 1e-3 * scale
        self.assertGreater(close[~np.isnan(found[:, 0])].mean(), 0.97)
        self.assertGreater(np.abs(found[close]).max(), 0.01)

    # Promise: "The gradient is a central ..."
    def test_there_is_none_where_f_jumps(self):
        field = self.quadratic()
        points = self.random.uniform(-1.2, 1.2, (3000, 3))
        step = 0.01
        stencil = points[:, None] + step * np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])
        steps = field.orbit(stencil).steps
        alike = (steps == steps[:, :1]).all(axis=1)
        self.assertTrue(0.02 < alike.mean() < 0.98)
        self.assertTrue(np.array_equal(~np.isnan(field.gradient(points, step=step)).any(axis=1), alike))


class Decisions(FieldTest):

    # Promise of python.md#the-field: What `decide` proves of a ball holds for each of its points
    def test_no_point_of_a_ball_contradicts_its_proof(self):
        for options in ({"map": "quadratic", "c": C}, {"map": "mandelbulb"}, {"vertices": self.torus, **SMALL},
                        {"vertices": 1000 * np.array(self.mesh[0]) + 5000, "faces": np.array(self.mesh[1]), **SMALL}):
            with self.subTest(map=options.get("map")):
                field = juliavdb.Field(**options)
                low, high = np.array(field.bounds)
                centres = self.points(field, 3000)
                radii = (high - low).max() * 10 ** self.random.uniform(-5, -1.5, 3000)
                decided = field.decide(centres, radii)
                self.assertEqual((decided.shape, decided.dtype), ((3000,), np.int8))
                self.assertEqual(set(decided), {-1, 0, 1})
                for _ in range(20):
                    way = self.random.normal(size=(3000, 3))
                    way /= np.linalg.norm(way, axis=1)[:, None]
                    inside = field.inside(centres + way * (radii * self.random.uniform(0, 1, 3000))[:, None])
                    self.assertTrue(inside[decided == -1].all())
                    self.assertFalse(inside[decided == 1].any())

    # Promise: What `decide` proves of a ball ...
    def test_one_radius_is_the_radius_of_all(self):
        field = self.quadratic()
        centres = self.points(field, 600).reshape(20, 30, 3)
        one = field.decide(centres, 0.01)
        self.assertTrue(np.array_equal(one, field.decide(centres, np.full((20, 30), 0.01))))
        # Part of a ball is decided where the ball is.
        smaller = field.decide(centres, 0.001)
        self.assertTrue((smaller[one != 0] == one[one != 0]).all())
        self.assertGreater((smaller != 0).sum(), (one != 0).sum())


class Devices(FieldTest):

    # Promise of python.md: `device` evaluates F "for one call", with the same bits
    def test_a_choice_that_is_none(self):
        field = self.quadratic()
        for device in ("gpu", "opencl:", "opencl:9999"):
            with self.subTest(device=device):
                self.assertRaises((ValueError, RuntimeError), field, [0, 0, 0], device=device)
        points = self.points(field, 300)
        self.assertTrue(np.array_equal(field(points, device="cpu"), field(points)))

    # Promise: `device` evaluates F "for one ..."
    @unittest.skipUnless(harness.has_opencl(), "no device of OpenCL is installed")
    def test_a_device_gives_the_same_bits(self):
        field = juliavdb.Field(self.torus, **SMALL)
        points = self.points(field, 20000)
        self.assertTrue(np.array_equal(field(points, device="opencl"), field(points)))
        self.assertTrue(np.array_equal(field.inside(points, device="opencl"), field.inside(points)))
        self.assertEqual(juliavdb.use_device("cpu"), "")


if __name__ == "__main__":
    if juliavdb:
        harness.main()
    else:
        unittest.main()

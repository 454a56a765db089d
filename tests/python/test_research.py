# SPDX-License-Identifier: Apache-2.0
"""Python for research: grids, slices, studies and the parts of fitting, beside the command, numpy, and what is known."""
import copy
import importlib.util
import json
import pathlib
import pickle
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))

import harness

try:
    import juliavdb
    import numpy as np
    from juliavdb import fitting
except ImportError as error:
    print(f"skipped: {error}")
    juliavdb = None

try:
    import pyopenvdb
except ImportError:
    pyopenvdb = None

SMALL = {"sdf_resolution": 30, "resolution": 30}


def swirl(points):
    x, y, z = points.T
    return np.column_stack([0.3 + y, z - 0.1, x + 0.2])


@unittest.skipUnless(juliavdb, "the Python module was not built, or there is no numpy")
class ResearchTest(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.mesh = harness.torus()
        self.write("torus.obj", harness.obj(self.mesh))
        self.torus = str(self.path("torus.obj"))
        self.random = np.random.default_rng(3)


class Copies(ResearchTest):

    # Promise of python.md: "A `Field` can be pickled", and is then the same
    def test_a_pickled_field_has_the_same_numbers(self):
        arrays = np.array(self.mesh[0]), np.array(self.mesh[1])
        for given, options in (((self.torus,), {"detail": 0.4}), (arrays, {"alpha": 30, "texture": "rings"}), ((self.torus,), {"texture": swirl}),
                               ((), {"map": "quadratic", "c": (-0.2, 0.6, 0.2, 0.2)})):
            with self.subTest(options=options):
                field = juliavdb.Field(*given, **options, **({} if "map" in options else SMALL))
                again = pickle.loads(pickle.dumps(field))
                points = self.random.uniform(*field.bounds, (500, 3))
                self.assertTrue(np.array_equal(again(points), field(points)))
                self.assertEqual(again.recipe, field.recipe)
                self.assertEqual(juliavdb.Field(**{name.replace("-", "_"): value for name, value in field.recipe.items()
                                                   if name not in ("input",)}, vertices=given[0] if given else None,
                                                faces=given[1] if len(given) > 1 else None).recipe
                                 if "texture" not in options else field.recipe, field.recipe)
                for same in (copy.copy(field), copy.deepcopy(field)):
                    self.assertTrue(np.array_equal(same(points), field(points)))

    def test_a_pickled_fractal_is_the_same(self):
        arrays = np.array(self.mesh[0]), np.array(self.mesh[1])
        for given in ((self.torus,), arrays):
            made = juliavdb.fractal(*given, detail=0.4, attributes="depth", **SMALL)
            again = pickle.loads(pickle.dumps(made))
            for name in ("vertices", "faces", "normals"):
                self.assertTrue(np.array_equal(getattr(again, name), getattr(made, name)))
            self.assertTrue(np.array_equal(again.attributes["depth"], made.attributes["depth"]))
            self.assertEqual(again.info, made.info)
            for same in (copy.copy(made), copy.deepcopy(made)):
                self.assertTrue(np.array_equal(same.vertices, made.vertices))

    # Promise: Grids there and back: arrays, pyopenvdb, pickle; meshes of meshio
    def test_a_target_may_be_a_mesh_of_meshio(self):
        class MeshioMesh:
            """What is read of one."""
            points, cells_dict = np.array(self.mesh[0]), {"triangle": np.array(self.mesh[1]), "line": np.zeros((1, 2), int)}

        made = juliavdb.fractal(MeshioMesh(), **SMALL)
        same = juliavdb.fractal(MeshioMesh.points, MeshioMesh.cells_dict["triangle"], **SMALL)
        self.assertTrue(np.array_equal(made.vertices, same.vertices))
        MeshioMesh.cells_dict = {"quad": np.zeros((1, 4), int)}
        with self.assertRaisesRegex(ValueError, "no triangles.*quad"):
            juliavdb.fractal(MeshioMesh(), **SMALL)

    # Promise: Grids there and back: arrays, pyopenvdb, pickle; meshes of meshio
    @unittest.skipUnless(importlib.util.find_spec("meshio"), "meshio is missing; on Debian, install python3-meshio")
    def test_a_mesh_goes_to_meshio_and_comes_back(self):
        import meshio
        made = juliavdb.fractal(self.mesh[0], self.mesh[1], attributes="trap", **SMALL)
        there = made.to_meshio()
        self.assertIsInstance(there, meshio.Mesh)
        self.assertTrue(np.shares_memory(there.points, made.vertices))
        for name, values in made.attributes.items():
            self.assertTrue(np.array_equal(there.point_data[name], values), name)
        file = self.path("there.vtu")
        meshio.write(file, there)
        again = meshio.read(file)
        self.assertTrue(np.array_equal(again.cells_dict["triangle"], made.faces))
        self.assertTrue(np.array_equal(juliavdb.fractal(again, **SMALL).vertices,
                                       juliavdb.fractal(made.vertices, made.faces, **SMALL).vertices))


class Maps(ResearchTest):
    """Maps that are functions of Python."""

    C = np.array([-0.2, 0.6, 0.2, 0.2]) if juliavdb else None

    @classmethod
    def square(cls, q, start):
        a, v = q[:, :1], q[:, 1:]
        with np.errstate(all="ignore"):
            return np.concatenate([a * a - (v * v).sum(axis=1, keepdims=True), 2 * a * v], axis=1) + cls.C

    # Promise of python.md#a-map-of-your-own: A map that is a function of Python: nothing is proved of it, what it raises, what is
    #   not finite, the recipe
    def test_a_function_is_the_built_in_map_of_the_same(self):
        options = {"iterations": 6, "precision": "double"}
        own = juliavdb.Field(map=self.square, radius=20, **options)
        same = juliavdb.Field(map="quadratic", c=self.C, escape=20, **options)
        points = self.random.uniform(-1.3, 1.3, (3000, 3))
        self.assertTrue(np.array_equal(own.inside(points), same.inside(points)))
        np.testing.assert_allclose(own(points), same(points), atol=1e-6, rtol=1e-9)
        np.testing.assert_allclose(own.orbit(points).iterates, same.orbit(points).iterates, atol=1e-6, rtol=1e-6)
        box = (-1.3, -1.3, -1.3, 1.3, 1.3, 1.3)
        meshes = [juliavdb.fractal(map=each, box=box, voxel_size=0.1, **more, **options)
                  for each, more in ((self.square, {"radius": 20}), ("quadratic", {"c": self.C, "escape": 20}))]
        self.assertEqual(len(meshes[0].vertices), len(meshes[1].vertices))
        self.assertTrue(np.array_equal(meshes[0].faces, meshes[1].faces))
        np.testing.assert_allclose(meshes[0].vertices, meshes[1].vertices, atol=1e-6)

    # Promise: A map that is a function ...
    def test_the_second_argument_is_where_the_orbit_began(self):
        def mandelbrot(q, start):
            return self.square(q, start) - self.C + start

        own = juliavdb.Field(map=mandelbrot, radius=20, iterations=6, precision="double")
        same = juliavdb.Field(map="quadratic", mandelbrot=True, escape=20, iterations=6, precision="double")
        points = self.random.uniform(-1.3, 1.3, (2000, 3))
        self.assertTrue(np.array_equal(own.inside(points), same.inside(points)))

    # Promise: A map that is a function ...
    def test_nothing_is_proved_but_outside_of_the_ball(self):
        field = juliavdb.Field(map=self.square, radius=2, iterations=3)
        points = self.random.uniform(-3, 3, (500, 3))
        decided = field.decide(points, 0.01)
        self.assertTrue(np.array_equal(decided == 1, np.linalg.norm(points, axis=1) - 0.01 > 2 - 1e-9))
        self.assertFalse((decided == -1).any())

    # Promise: A map that is a function ...
    def test_what_is_not_finite_has_escaped(self):
        field = juliavdb.Field(map=lambda q, start: np.where(q[:, :1] > 0, np.nan, 0 * q), radius=2, iterations=3)
        inside = field.inside([[0.5, 0, 0], [-0.5, 0, 0]])
        self.assertEqual(list(inside), [False, True])

    # Promise: A map that is a function ...
    def test_what_a_map_raises_or_returns_wrongly(self):
        class Mine(Exception):
            pass

        def raising(q, start):
            raise Mine("of my own")

        with self.assertRaises(Mine):
            juliavdb.Field(map=raising, radius=2)([[0, 0, 0]])
        for function, words in ((lambda q, s: q[:, :3], r"\(n, 4\)"), (lambda q, s: q[1:], r"\(n, 4\)"), (lambda q, s: q * 1j, "real numbers"),
                                (lambda q, s: None, "real numbers|shape")):
            with self.subTest(words=words), self.assertRaisesRegex(ValueError, words):
                juliavdb.Field(map=function, radius=2)(np.zeros((4, 3)))
        with self.assertRaisesRegex(ValueError, "function"):
            juliavdb.Field(map="function")
        made = juliavdb.fractal(map=self.square, iterations=3, voxel_size=0.4, radius=2)
        made.write(self.path("own.vdb"))
        self.assertEqual(made.info["recipe"]["map"], "function")
        self.refused(harness.BAD_DATA, "fractal", "--config", "own.vdb", "-o", "x.vdb", mentions="function")


class Grids(ResearchTest):

    # Promise of python.md#slices-studies-dimensions: `sdf`, `slice`, `study` and `dimension` give what the commands give
    def test_distances_are_those_of_the_command(self):
        arrays = np.array([line.split()[1:4] for line in self.path("torus.obj").read_text().splitlines() if line.startswith("v ")],
                          dtype=float), np.array(self.mesh[1])
        self.ok("sdf", self.torus, "-o", "command.vdb", "--resolution", 24, "--band", 4)
        command = juliavdb.Grid.read(self.path("command.vdb"))
        for given in ((self.torus,), arrays):
            grid = juliavdb.sdf(*given, resolution=24, band=4)
            self.assertEqual((grid.name, grid.voxel_size), ("phi", command.voxel_size))
            (ours, origin), (theirs, there) = grid.array(), command.array()
            self.assertTrue(np.array_equal(ours, theirs))
            self.assertEqual(origin, there)
            self.assertEqual(grid.metadata["julia_source_sha256"] == command.metadata["julia_source_sha256"], len(given) == 1)
        with self.assertRaisesRegex(ValueError, "band"):
            juliavdb.sdf(self.torus, band=0.5)
        with self.assertRaisesRegex(ValueError, "torus.obj"):
            juliavdb.sdf(self.torus, resolution=24).write(self.torus)

    # Promise: Grids there and back: arrays, pyopenvdb, pickle; meshes of meshio
    def test_the_distances_of_a_ball(self):
        points, triangles = harness.sphere(4)
        grid = juliavdb.sdf(np.array(points), np.array(triangles), resolution=40)
        at = self.random.normal(size=(10, 50, 3))
        at *= (1 + self.random.uniform(-0.05, 0.05, (10, 50, 1))) / np.linalg.norm(at, axis=-1, keepdims=True)
        self.assertLess(np.abs(grid.sample(at) - (np.linalg.norm(at, axis=-1) - 1)).max(), 0.01)

    # Promise of python.md#grids: Grids there and back: arrays, pyopenvdb, pickle; meshes of meshio
    def test_arrays_there_and_back(self):
        array = self.random.normal(size=(9, 12, 5)).astype(np.float32)
        grid = juliavdb.Grid(array, 0.25, (1, -2, 3), "noise")
        back, origin = grid.array()
        self.assertTrue(np.array_equal(back, array))
        np.testing.assert_allclose(origin, (1, -2, 3), atol=1e-12)
        # Trilinear, by hand.
        at = self.random.uniform(0, 1, (200, 3)) * (np.array(array.shape) - 1.001)
        low, share = at.astype(int), at - at.astype(int)
        by_hand = np.zeros(200)
        for corner in np.ndindex(2, 2, 2):
            weight = np.prod(np.where(corner, share, 1 - share), axis=1)
            by_hand += weight * array[tuple((low + corner).T)]
        np.testing.assert_allclose(grid.sample(origin + 0.25 * at), by_hand, atol=1e-5)
        again = pickle.loads(pickle.dumps(grid))
        self.assertTrue(np.array_equal(again.array()[0], array))
        self.assertEqual((again.name, again.voxel_size), ("noise", 0.25))
        for wrong, words in ((np.zeros((2, 2)), "three axes"), (np.zeros((0, 2, 2)), "empty"), (np.zeros((1, 1, 1), complex), "real numbers")):
            with self.assertRaisesRegex(ValueError, words):
                juliavdb.Grid(wrong, 1)
        for size in (0, -1, float("nan")):
            with self.assertRaisesRegex(ValueError, "voxel_size is"):
                juliavdb.Grid(array, size)

    # Promise: Grids there and back: arrays, pyopenvdb, pickle; meshes of meshio
    @unittest.skipUnless(pyopenvdb, "there is no pyopenvdb")
    def test_grids_of_pyopenvdb(self):
        array = self.random.normal(size=(6, 7, 8)).astype(np.float32)
        there = juliavdb.Grid(array, 0.5, (0, 1, 2)).to_pyopenvdb()
        out = np.zeros((6, 7, 8), np.float32)
        there.copyToArray(out)
        self.assertTrue(np.array_equal(out, array))
        back = juliavdb.Grid.from_pyopenvdb(there)
        self.assertTrue(np.array_equal(back.array()[0], array))
        self.assertEqual(back.array()[1], (0, 1, 2))


class Studies(ResearchTest):

    # Promise: `sdf`, `slice`, `study` and `dimension` ...
    def test_a_slice_has_the_pixels_of_the_command(self):
        for axis, position in (("z", None), ("x", 0.1)):
            words = ["--axis", axis] + ([] if position is None else ["--position", position])
            self.ok("slice", self.torus, "-o", "m.png", "--sdf-resolution", 30, "--size", 60, *words)
            picture = np.array(harness.read_png(self.bytes("m.png")))
            members = juliavdb.slice(self.torus, axis=axis, position=position, size=60, sdf_resolution=30)
            self.assertEqual(members.dtype, bool)
            self.assertTrue(np.array_equal(members, picture.reshape(*members.shape, -1)[..., 0] == 0))
        phi = juliavdb.slice(self.torus, field="phi", size=40, sdf_resolution=30)
        self.assertTrue((phi < 0).any() and (phi > 0).any())
        self.assertEqual(juliavdb.slice(self.torus, field="versor", size=10, sdf_resolution=30).shape[-1], 4)
        for wrong in (dict(field="g"), dict(axis="w"), dict(size=0)):
            with self.assertRaisesRegex(ValueError, next(iter(wrong))):
                juliavdb.slice(self.torus, sdf_resolution=30, **wrong)

    # Promise: `sdf`, `slice`, `study` and `dimension` ...
    def test_a_study_counts_the_sets_of_seeds(self):
        options = {"sdf_resolution": 30, "alpha": 20}
        study = juliavdb.study(self.torus, versors=4, size=30, texture_seed=7, **options)
        count = 0
        for seed in range(7, 11):
            field = juliavdb.Field(self.torus, texture="random", texture_seed=seed, **options)
            middle = field.space[0]
            count = count + field.inside(field.plane(size=30, position=middle[2])).astype(int)
        self.assertTrue(np.array_equal(study["inside"], count))
        self.assertEqual(study["versors"], 4)
        self.ok("study", self.torus, "-o", "s.png", "--csv", "s.csv", "--versors", 4, "--size", 30, "--texture-seed", 7,
                "--sdf-resolution", 30, "--alpha", 20)
        rows = np.genfromtxt(self.path("s.csv"), delimiter=",", skip_header=1)
        ours = np.stack([study["circles"][name] for name in ("radius", "mean", "least", "greatest", "sphere_mean", "membership")], axis=1)
        np.testing.assert_allclose(ours, rows, rtol=1e-4, atol=1e-5)

    # Promise: `sdf`, `slice`, `study` and `dimension` ...
    def test_a_dimension_is_the_slope_of_the_triangles(self):
        found = juliavdb.dimension(self.torus, resolutions=[12, 18, 27], sdf_resolution=30)
        printed = json.loads(self.ok("study", self.torus, "--dimension", "12,18,27", "--sdf-resolution", 30, "--json", data=True))
        self.assertEqual([row["triangles"] for row in printed["rows"]], list(found["triangles"]))
        self.assertAlmostEqual(found["dimension"], printed["dimension"], delta=1e-12)
        slope = np.polyfit(np.log([12, 18, 27]), np.log(found["triangles"]), 1)[0]
        self.assertAlmostEqual(found["dimension"], slope, delta=1e-9)
        for wrong in ([12, 18], [18, 12, 27], [1, 2, 3]):
            with self.assertRaisesRegex(ValueError, "resolutions"):
                juliavdb.dimension(self.torus, resolutions=wrong)


@unittest.skipUnless(juliavdb, "the Python module was not built, or there is no numpy")
class Fitting(unittest.TestCase):

    def setUp(self):
        points, triangles = harness.sphere(3)
        self.points, self.triangles = 0.4 * np.array(points), np.array(triangles)
        self.random = np.random.default_rng(4)
        self.cells = self.random.uniform(-0.6, 0.6, (400, 3))
        roots = np.concatenate([self.random.uniform(-0.3, 0.3, (6, 3)), np.zeros((6, 1)), self.random.uniform(0.5, 2, (6, 1))], axis=1)
        self.rational = fitting.Rational(0.3, roots[:4], 1.2, roots[4:], 0.7)
        self.phi = np.linalg.norm(self.cells, axis=1) - 0.4

    def by_hand(self, rational):
        sums = []
        for roots in (rational.top, rational.bottom):
            distances = np.linalg.norm(self.cells[:, None] - roots[None, :, :3], axis=2)
            sums.append((roots[:, 4] * np.log(distances)).sum(axis=1))
        return rational.log_scale + rational.top_scale * sums[0] - rational.bottom_scale * sums[1]

    # Promise of python.md#the-parts-of-a-fit: The parts of a fit: charges, monopoles, energy, gradient and minimum, beside numpy
    #   and what is known of a ball
    def test_the_charge_of_a_ball(self):
        charge = fitting.charge(self.points, self.triangles)
        self.assertAlmostEqual(charge.capacitance, 0.4, delta=0.004)
        at = self.random.normal(size=(3, 20, 3))
        at *= 1.5 / np.linalg.norm(at, axis=-1, keepdims=True)
        np.testing.assert_allclose(fitting.potential(self.points, self.triangles, charge.density, at), 0.4 / 1.5, rtol=0.01)

    # Promise: The parts of a fit: charges, monopoles, energy, gradient ...
    def test_monopoles_are_the_least_squares_of_their_places(self):
        outside = 1.3 * self.points[::4]
        known = 0.4 / np.linalg.norm(outside - (0.1, 0, 0), axis=1)
        found = fitting.monopoles(self.points, self.triangles, outside, known, epsilon=0.02, most=30)
        columns = 1 / np.linalg.norm(outside[:, None] - found.positions[None], axis=2)
        weights = np.linalg.lstsq(columns, known, rcond=None)[0]
        np.testing.assert_allclose(columns @ found.weights, columns @ weights, atol=1e-9)
        self.assertAlmostEqual(found.residuals[-1], np.linalg.norm(known - columns @ weights) / np.linalg.norm(known), delta=1e-9)
        self.assertTrue((np.diff(found.residuals) < 0).all())
        rational = fitting.Rational.from_monopoles(found, power=2)
        self.assertEqual(len(rational.top), (found.weights > 0).sum())
        self.assertEqual(len(rational.bottom), (found.weights < 0).sum())

    # Promise: The parts of a fit: charges, monopoles, energy, gradient ...
    def test_the_energy_and_its_gradient_by_hand(self):
        weights = fitting.weights(self.cells, self.phi, 0.02)
        clamped = np.sign(self.phi) * np.maximum(np.abs(self.phi.astype(np.float32)), 0.01)
        np.testing.assert_allclose(weights, 0.02 / clamped, rtol=1e-5)
        energy = fitting.Energy(self.cells, weights, self.rational, alpha=0.8, penalty=0.01)
        l = self.by_hand(self.rational)
        np.testing.assert_allclose(energy.log_moduli(self.rational), l, atol=1e-4)
        powers = 1.2 * self.rational.top[:, 4].sum() + 0.7 * self.rational.bottom[:, 4].sum()
        psi = -(np.tanh(0.8 * l) * weights).sum() / np.abs(weights).sum() + 0.01 * powers
        value, gradient = energy.gradient(self.rational)
        self.assertAlmostEqual(value, psi, delta=1e-6)
        self.assertEqual(value, energy(self.rational))

        def slope(change):
            step = 1e-5
            return (energy(change(step)) - energy(change(-step))) / (2 * step)

        def power(roots, i, step):
            changed = roots.copy()
            changed[i, 4] += step
            return changed

        near = dict(delta=1e-5)
        self.assertAlmostEqual(gradient.log_scale, slope(lambda s: self.rational._replace(log_scale=0.3 + s)), **near)
        self.assertAlmostEqual(gradient.top_scale, slope(lambda s: self.rational._replace(top_scale=1.2 + s)), **near)
        self.assertAlmostEqual(gradient.bottom_scale, slope(lambda s: self.rational._replace(bottom_scale=0.7 + s)), **near)
        for i in range(4):
            self.assertAlmostEqual(gradient.top[i], slope(lambda s: self.rational._replace(top=power(self.rational.top, i, s))), **near)
        for i in range(2):
            self.assertAlmostEqual(gradient.bottom[i],
                                   slope(lambda s: self.rational._replace(bottom=power(self.rational.bottom, i, s))), **near)

    # Promise: The parts of a fit: charges, monopoles, energy, gradient ...
    def test_the_gradient_by_places_by_hand(self):
        weights = fitting.weights(self.cells, self.phi, 0.02)
        _, gradient = fitting.Energy(self.cells, weights, self.rational, alpha=0.8).gradient(self.rational)

        def psi(rational):
            l = self.by_hand(rational)
            return -(np.tanh(0.8 * l) * weights).sum() / np.abs(weights).sum()

        for side, found in (("top", gradient.top_places), ("bottom", gradient.bottom_places)):
            self.assertEqual(found.shape, (len(getattr(self.rational, side)), 4))
            for i, axis in np.ndindex(found.shape):
                step = np.zeros_like(getattr(self.rational, side))
                step[i, axis] = 1e-5
                moved = [psi(self.rational._replace(**{side: getattr(self.rational, side) + sign * step})) for sign in (1, -1)]
                self.assertAlmostEqual(found[i, axis], (moved[0] - moved[1]) / 2e-5, delta=1e-5)

    # Promise: The parts of a fit: charges, monopoles, energy, gradient ...
    def test_roots_move_to_where_the_energy_is_lower(self):
        weights = fitting.weights(self.cells, self.phi, 0.02)
        energy = fitting.Energy(self.cells, weights, self.rational)
        before = energy(self.rational)
        moved, value, values = energy.move_roots(self.rational, 0.05, iterations=40)
        self.assertLess(value, before)
        self.assertEqual(values[-1], value)
        self.assertEqual(energy(moved), value)
        self.assertEqual(fitting.Energy(self.cells, weights, moved)(moved), value)
        for side in ("top", "bottom"):
            change = np.abs(getattr(moved, side) - getattr(self.rational, side))
            self.assertTrue((change[:, :3] <= 0.05 + 1e-12).all() and (change[:, 3:] == 0).all())
        with self.assertRaisesRegex(ValueError, "reach"):
            energy.move_roots(self.rational, -1)

    # Promise: The parts of a fit: charges, monopoles, energy, gradient ...
    def test_a_minimum_is_lower_and_nowhere_negative(self):
        energy = fitting.Energy(self.cells, fitting.weights(self.cells, self.phi, 0.02), self.rational)
        for variables in ("coarse", "full"):
            best, value, values = energy.minimise(self.rational, variables=variables, iterations=60)
            self.assertLess(value, energy(self.rational) - 0.01)
            self.assertAlmostEqual(value, energy(best), delta=1e-12)
            self.assertTrue((np.diff(values) < 0).all())
            self.assertTrue(min(best.top_scale, best.bottom_scale, *best.top[:, 4], *best.bottom[:, 4]) >= 0)
            if variables == "coarse":
                self.assertTrue(np.array_equal(best.top, self.rational.top))
                self.assertTrue(np.array_equal(best.bottom, self.rational.bottom))
        with self.assertRaises(KeyboardInterrupt):
            energy.minimise(self.rational, progress=lambda phase, share: False)

    # Promise: The parts of a fit: charges, monopoles, energy, gradient ...
    def test_a_rational_is_a_map(self):
        import tempfile
        np.testing.assert_allclose(self.rational.log_moduli(self.cells), self.by_hand(self.rational), atol=1e-10)
        np.testing.assert_allclose(np.linalg.norm(self.rational.versors(self.cells.reshape(20, 20, 3)), axis=-1), 1, atol=1e-12)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "map.json"
            self.rational.write(path)
            again = fitting.Rational.read(path)
            for ours, theirs in zip(again, self.rational):
                self.assertTrue(np.array_equal(ours, theirs))
            field = juliavdb.Field(map="rational", rational=path, iterations=1, precision="double", resolution=10,
                                   box=(-1, -1, -1, 1, 1, 1))
            points = self.cells[:50]
            np.testing.assert_allclose(field((points * field.space[1]) + field.space[0]), self.rational.log_moduli(points), atol=1e-9)

    # Promise: The parts of a fit: charges, monopoles, energy, gradient ...
    def test_blue_noise_is_spread_over_the_surface(self):
        points = fitting.blue_noise(self.points, self.triangles, 60, seed=5)
        self.assertTrue((np.abs(np.linalg.norm(points, axis=1) - 0.4) < 0.02).all())
        distances = np.linalg.norm(points[:, None] - points[None], axis=2) + 9 * np.eye(60)
        loose = 0.4 * self.random.normal(size=(60, 3))
        loose *= 0.4 / np.linalg.norm(loose, axis=1)[:, None]
        self.assertGreater(distances.min(), 2 * (np.linalg.norm(loose[:, None] - loose[None], axis=2) + 9 * np.eye(60)).min())

    # Promise: The parts of a fit: charges, monopoles, energy, gradient ...
    def test_what_is_no_surface(self):
        for call, words in ((lambda: fitting.charge(self.points, None), "both"),
                            (lambda: fitting.charge(self.points, self.triangles + 9999), "uses vertex"),
                            (lambda: fitting.potential(self.points, self.triangles, [1, 2], [[0, 0, 0]]), "density must hold"),
                            (lambda: fitting.Energy(self.cells, [1.0], self.rational), "weights must hold 400"),
                            (lambda: fitting.Energy(self.cells, self.phi, self.rational._replace(top=np.zeros((2, 4)))), r"top .*\(n, 5\)"),
                            (lambda: fitting.weights(self.cells, self.phi, 0.1, kind="x"), "kind is 'x'"),
                            (lambda: fitting.weights(self.cells, self.phi, 0), "cell_size")):
            with self.subTest(words=words), self.assertRaisesRegex(ValueError, words):
                call()


if __name__ == "__main__":
    if juliavdb:
        harness.main()
    else:
        unittest.main()

# SPDX-License-Identifier: Apache-2.0
"""The laws of the soak notice what they are for, and a recipe that breaks one becomes small."""

import argparse
import pathlib
import sys
import unittest
from unittest import mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import laws  # noqa: E402
import recipes  # noqa: E402
import shapes  # noqa: E402
from shapes import harness  # noqa: E402

import importlib.machinery  # noqa: E402
import importlib.util  # noqa: E402

# The program has no extension, as it is run from a shell.
_path = str(pathlib.Path(__file__).resolve().parent / "soak")
_spec = importlib.util.spec_from_loader("soak", importlib.machinery.SourceFileLoader("soak", _path))
soak = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(soak)

PLAIN = recipes.Recipe("ball.obj", (("map", "shape-modulus"), ("resolution", "20")), ".ply", True)
BOXED = recipes.Recipe("ball.obj", (("map", "shape-modulus"), ("box", "-1,-1,-1,1,1,0")), ".ply", True)


def check(mesh, recipe=PLAIN, low=(-2, -2, -2), high=(2, 2, 2)):
    laws.check_surface(laws.Surface(*mesh), recipe, low, high, exact=True)


class Laws(unittest.TestCase):

    def broken(self, law, mesh, *more):
        with self.assertRaises(laws.Broken) as caught:
            check(mesh, *more)
        self.assertEqual(caught.exception.law, law)

    def test_a_good_mesh(self):
        for mesh in (harness.sphere(2), harness.torus(), shapes.hollow()):
            check(mesh)

    # Promise: The laws of random recipes, that their ...
    def test_bad_meshes(self):
        points, faces = harness.sphere(2)
        self.broken("closed", (points, faces[1:]))
        self.broken("outward", (points, [f[::-1] for f in faces]))
        self.broken("2-manifold", (points, faces + faces[:1]))
        self.broken("2-manifold", (points + [(0, 0, 0)], faces))
        self.broken("finite", ([(float("nan"), 0, 0)] + points[1:], faces))
        self.broken("in the box", (points, faces), PLAIN, (-0.5, -2, -2))
        # Two cubes that share a corner: every edge is paired, yet the faces about the corner are two fans.
        cube, sides = harness.cube()
        other = [tuple(c + 2 for c in p) for p in cube]
        number = {p: k for k, p in enumerate(dict.fromkeys(cube + other))}
        bow_tie = list(number), sides + [tuple(number[other[k]] for k in f) for f in sides]
        self.broken("2-manifold", bow_tie, PLAIN, (-9, -9, -9), (9, 9, 9))

    def test_only_a_box_may_cut(self):
        points, faces = harness.cube()
        lid = [f for f in faces if not all(points[k][2] > 0 for k in f)]
        self.broken("closed", (points, lid))
        check((points, lid), BOXED)
        points, faces = harness.sphere(2)
        self.broken("closed", (points, faces[1:]), BOXED)  # away from the border

    # Promise: The laws of random recipes, that their ...
    def test_grids(self):
        place = ((0, 0, 0), (0, 0, 0)), ((0, 0, 1), (0, 0, 1))
        laws.check_grids({"logmodulus": {place[0]: 1.0}}, {"logmodulus": {place[0]: 1.0, place[1]: 2.0}})
        for some, every in (({"surface": {place[0]: 1.0}}, {"surface": {place[0]: 1.0, place[1]: 2.0}}),
                            ({"trap": {place[0]: 1.0}}, {"trap": {place[0]: 1.5}}), ({"a": {}}, {"b": {}})):
            with self.assertRaises(laws.Broken):
                laws.check_grids(some, every)


class Recipes(unittest.TestCase):
    known = {"maps": [{"name": "m", "target": "none"}], "textures": [], "colours": ["clay"], "gradients": [],
             "options": [{"name": f"new-{k}", "argument": argument, "help": text, "maps": ["m"], "displaces": [],
                          "default": None}
                         for k, (argument, text) in enumerate((("", "a flag"), ("N", "a number"), ("X,Y,Z", "a place"),
                                                               ("a|b", "a choice"), ("LIST", "a list of p, q")))]}

    # Promise: The laws of random recipes, that their ...
    def test_an_option_that_nobody_knows_takes_part(self):
        seen = {}
        for number in range(300):
            for name, value in recipes.Draw(number, self.known, []).recipe().options:
                seen.setdefault(name, set()).add(value)
        self.assertEqual(seen["new-0"], {None})
        self.assertTrue(all(value.isdigit() for value in seen["new-1"]))
        self.assertTrue(all(value.count(",") == 2 for value in seen["new-2"]))
        self.assertEqual(seen["new-3"], {"a", "b"})
        self.assertEqual(seen["new-4"], {"p", "q", "p,q", "q,p"})

    # Promise: The laws of random recipes, that their ...
    def test_a_number_is_always_the_same_recipe(self):
        draw = lambda: recipes.Draw("3:8", self.known, []).recipe()
        self.assertEqual(draw(), draw())

    def test_a_failure_becomes_small(self):
        runs = soak.Soak.__new__(soak.Soak)
        runs.arguments = argparse.Namespace(seed=1)

        def attempt(number, recipe, name=""):
            if recipe.has("guilty") and recipe.has("needed"):
                raise laws.Broken("closed", "so it is")
            if not recipe.has("needed"):
                raise laws.Refused("it is needed")
            return []

        options = (("map", "m"), ("resolution", "40"), ("a", "1"), ("guilty", None), ("b", "2"), ("needed", "3"))
        with mock.patch.object(runs, "attempt", attempt):
            recipe, broken = runs.shrunk(0, recipes.Recipe(None, options, ".ply", False), laws.Broken("closed", "x"))
        self.assertEqual(recipe.options, (("map", "m"), ("resolution", "12"), ("guilty", None), ("needed", "3")))
        self.assertEqual(broken.law, "closed")


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""No test hides another: of two functions with one name in a class, Python keeps the last."""
import ast
import collections
import pathlib
import unittest

TESTS = pathlib.Path(__file__).resolve().parent.parent


def hidden(source):
    tree = ast.parse(source)
    for scope in [tree, *(node for node in ast.walk(tree) if isinstance(node, ast.ClassDef))]:
        names = collections.Counter(node.name for node in scope.body
                                    if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.decorator_list)
        yield from (name for name, count in names.items() if count > 1)


class HiddenTests(unittest.TestCase):
    def test_in_every_script(self):
        scripts = list(TESTS.rglob("*.py"))
        self.assertGreater(len(scripts), 50)
        for script in scripts:
            with self.subTest(script=str(script.relative_to(TESTS))):
                self.assertEqual(list(hidden(script.read_text())), [])

    def test_that_one_is_found(self):
        self.assertEqual(list(hidden("class A:\n  def f(self): pass\n  def g(self): pass\n  def f(self): pass\n")), ["f"])


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sources that a unity build compiles as one file have no names in common.

Two functions of one name in the unnamed namespaces of two such sources may still compile where their arguments differ,
and then the wrong one is called. Usage: unity_test.py BUILD
"""
import collections
import glob
import os
import re
import sys
import unittest

BUILD = os.path.abspath(sys.argv.pop()) if len(sys.argv) > 1 else "."

# What begins in the first column: a type, or the name before the first bracket or "=". Constants that clash do not
# compile, so the first of several is enough.
TYPE = re.compile(r"(?:template <[^>]*> )?(?:struct|class|enum class|enum|union) (\w+)")
NAME = re.compile(r"(?<![\w:])(\w+)(?:\(|\{| =|\[|;|,)")
NOT_NAMES = re.compile(r"template\b[^(]*$|using |namespace|static_assert|extern|[A-Z_]*TEST|INSTANTIATE|BENCHMARK|[ })#/:]|$")


def private_names(text):
    """The functions, constants and types of the unnamed namespaces of a source that clang-format has laid out. An alias
    may be there twice: if it meant something else, that would not compile."""
    names, inside = set(), False
    for line in text.split("\n"):
        if line == "namespace {":
            inside = True
        elif line.startswith("}  // namespace"):
            inside = False
        elif inside and not NOT_NAMES.match(line):
            found = TYPE.match(line) or NAME.search(re.sub(r"<.*>", "", line.split("//")[0]))
            if found:
                names.add(found.group(1))
    return names


def clashes(texts):
    """The names that several of {source: text} define, with the sources."""
    where = collections.defaultdict(list)
    for source, text in texts.items():
        for name in private_names(text):
            where[name].append(source)
    return {name: sources for name, sources in where.items() if len(sources) > 1}


class Unity(unittest.TestCase):
    def test_names(self):
        one = "namespace {\n\nint of(double x) {\n  return f(x);\n}\nconstexpr int kA = 1;\n\n}  // namespace\nint f(int);\n"
        self.assertEqual(private_names(one), {"of", "kA"})
        other = "namespace {\nstruct Of {};\nstd::vector<int> of(std::string_view x) { return {}; }\n}  // namespace\n"
        self.assertEqual(clashes({"a": one, "b": other}), {"of": ["a", "b"]})

    def test_groups(self):
        groups = glob.glob(os.path.join(glob.escape(BUILD), "**", "Unity", "unity_*.cxx"), recursive=True)
        if not groups:
            self.skipTest("this is no unity build")
        for group in groups:
            with open(group) as file:
                sources = re.findall(r'#include "([^"]+)"', file.read())
            texts = {}
            for source in sources:
                with open(source, encoding="utf-8") as file:
                    texts[source] = file.read()
            self.assertEqual(clashes(texts), {}, "give one of the sources another UNITY_GROUP, see juliavdb_unity()")


if __name__ == "__main__":
    unittest.main()

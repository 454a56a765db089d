#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The C library's functions decide no bit of what is made: which of them the libraries and the program call, and why.

Each name is one that the C library may compute otherwise on another machine or in another version. What is not in the
list fails, and so does what is in the list and not called any more. Usage: libm_calls_test.py NM TARGET=FILE ...
"""
import ctypes.util
import os
import re
import subprocess
import sys
import unittest

NM, FILES = sys.argv[1], dict(argument.split("=", 1) for argument in sys.argv[2:])
del sys.argv[1:]

# IEEE 754 and C fix every bit of their results.
EXACT = {
    "sqrt", "fma", "fabs", "copysign", "nextafter", "nexttoward", "fmin", "fmax", "fdim",
    "floor", "ceil", "trunc", "round", "rint", "nearbyint", "lround", "llround", "lrint", "llrint",
    "fmod", "remainder", "modf", "frexp", "ldexp", "scalbn", "scalbln", "ilogb", "logb",
}

# By target: the functions that remain, and why they decide nothing.
REMAINING = {
    "julia": {},
    "vdbtools": {
        "cos": "OpenMesh's cosine of one angle, 60 degrees, by which a collapse may turn a triangle at most; nothing but a "
               "triangle that turns by exactly so much could tell",
        "pow": "OpenVDB's question, with a tolerance, whether the voxels of a NanoVDB file have equal sides",
        "sincos": "rotations of OpenVDB's affine maps, which are compiled with the writer of NanoVDB and never called",
    },
    "vdbtools_fit": {},
    "vdbtools_farm": {},
    "vdbtools_explore": {},
    "vdbtools_images": {},
    "juliavdb_cli": {},
    "juliavdb_python": {},
}


def symbols(file, which):
    output = subprocess.run([NM, "-D", which, file], check=True, capture_output=True, text=True).stdout
    return {line.split()[-1].split("@")[0] for line in output.splitlines() if line.strip()}


def is_exact(name):
    return name in EXACT or (name[-1] in "fl" and name[:-1] in EXACT)


def library_of_functions():
    """The file of libm that the linker takes for a program."""
    linked = subprocess.run(["ldd", FILES["vdbtools"]], check=True, capture_output=True, text=True).stdout
    return re.search(r"libm\.so\S* => (\S+)", linked).group(1)


class LibmCalls(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.functions = {name for name in symbols(library_of_functions(), "--defined-only")
                         if not name.startswith(("_", "GLIBC", "fe"))}

    def test_the_library_is_the_one_with_the_functions(self):
        self.assertLessEqual({"sin", "expf", "powl", "sincos", "lgamma", "sqrt", "frexp"}, self.functions)
        self.assertEqual([name for name in ("sin", "expf", "log2", "tgammal") if is_exact(name)], [])

    # Promise of design.md: "neither the instruction set nor the C library decides a bit", but for the three places that the page
    #   names
    def test_every_call_has_a_reason(self):
        self.assertEqual(sorted(set(FILES) - set(REMAINING)), [])
        for target, file in FILES.items():
            with self.subTest(file=os.path.basename(file)):
                called = {name for name in symbols(file, "--undefined-only") & self.functions if not is_exact(name)}
                self.assertEqual(sorted(called), sorted(REMAINING[target]))


if __name__ == "__main__":
    unittest.main()

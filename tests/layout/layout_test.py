#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The layers and the rooms: nothing includes what lies above it.

ORDER below is the one place that says what lies above what. docs/architecture.md explains it.
"""
import os
import re
import sys
import tempfile
import unittest

# From the bottom up. A folder may include what stands before it. A file belongs to the longest of these paths that it
# lies below; `include` and `src` are two halves of one room.
ORDER = [
    "libjulia",
    "libjulia/device",
    "libjulia/fit",
    "vdbtools/base",
    "vdbtools/files",
    "vdbtools/mesh",
    "vdbtools/search",
    "vdbtools/decimation",
    "vdbtools/mesh_files",
    "vdbtools/formats",
    "vdbtools/recipe",
    "vdbtools/distance",
    "vdbtools/repair",
    "vdbtools/control",
    "vdbtools/exponent",
    "vdbtools/grain",
    "vdbtools/target",
    "vdbtools/motion",
    "vdbtools/field",
    "vdbtools/surface",
    "vdbtools/picture",
    "vdbtools/render",
    "vdbtools/maps",
    "vdbtools/scene",
    "vdbtools/job",
    "vdbtools/records",
    "vdbtools/print",
    "vdbtools/study",
    "vdbtools/usd",
    "vdbtools/fit",
    "vdbtools/farm",
    "vdbtools/explore",
    "cli",
    "wasm",
    "python",
]

# How the folders on disk are named above.
PLACES = [
    ("libjulia/include/julia/fit/", "libjulia/fit"),
    ("libjulia/src/fit/", "libjulia/fit"),
    ("libjulia/include/julia/device/", "libjulia/device"),
    ("libjulia/src/device/", "libjulia/device"),
    ("libjulia/include/julia/", "libjulia"),
    ("libjulia/src/", "libjulia"),
    *[(f"vdbtools/{half}/{room.partition('/')[2]}/", room)
      for room in ORDER if room.startswith("vdbtools/") for half in ("include/vdbtools", "src")],
    ("cli/", "cli"),
    ("wasm/", "wasm"),
    ("python/", "python"),
]

# Where the compiler looks for what each layer includes in quotes, besides the file's own folder.
SEARCHED = {
    "libjulia": ["libjulia/include", "libjulia/src"],
    "vdbtools": ["vdbtools/include", "vdbtools/src", "libjulia/include"],
    "cli": ["cli", "vdbtools/include", "libjulia/include"],
    "wasm": ["cli", "vdbtools/include", "vdbtools/src", "libjulia/include"],  # a page of its own on the room explore
    "python": ["python/src", "vdbtools/include", "libjulia/include"],
    # Some tests and benchmarks look at the insides.
    "tests": ["tests", "cli", "vdbtools/include", "vdbtools/src", "libjulia/include", "libjulia/src"],
    "bench": ["bench", "tests", "vdbtools/include", "vdbtools/src", "libjulia/include", "libjulia/src"],
    "samples": ["vdbtools/include", "libjulia/include"],
}

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^">]+)[">]', re.MULTILINE)
OWN_IN_ANGLES = re.compile(r"^(julia|vdbtools)/")


def place_of(path):
    """The entry of ORDER that a file belongs to; None for tests, samples and benchmarks, which may use everything."""
    for folder, place in PLACES:
        if path.startswith(folder):
            return place
    return None


def sources(root):
    """Every header and source of the project, relative to its root."""
    for layer in SEARCHED:
        for folder, _, names in os.walk(os.path.join(root, layer)):
            for name in sorted(names):
                if name.endswith((".h", ".cpp")):
                    yield os.path.relpath(os.path.join(folder, name), root)


def resolve(root, path, name):
    """The project's file that `path` includes as `name`, or None."""
    for folder in [os.path.dirname(path), *SEARCHED[path.split("/")[0]]]:
        candidate = os.path.normpath(os.path.join(folder, name))
        if os.path.isfile(os.path.join(root, candidate)):
            return candidate
    return None


def complaints(root):
    """What is wrong with the includes of the tree below `root`, one line each."""
    found = []
    for path in sources(root):
        layer, place = path.split("/")[0], place_of(path)
        with open(os.path.join(root, path), encoding="utf-8") as file:
            text = file.read()
        if place is None and layer in ("libjulia", "vdbtools"):
            found.append(f"{path} lies in no room; the rooms are in tests/layout/layout_test.py")
            continue
        for match in INCLUDE.finditer(text):
            name = match.group(2)
            where = f"{path}:{text.count(chr(10), 0, match.start()) + 1}"
            if match.group(1) == "<":
                if OWN_IN_ANGLES.match(name) and layer not in ("samples", "tests"):
                    found.append(f'{where} includes <{name}>; the project\'s own headers are included in quotes')
                continue
            included = resolve(root, path, name)
            if included is None:
                found.append(f'{where} includes "{name}", which does not exist where {layer} looks for headers')
                continue
            other = place_of(included)
            if {place, other} == {"cli", "python"}:
                found.append(f'{where} includes "{name}": cli and python stand side by side')
            if place and other and ORDER.index(other) > ORDER.index(place):
                found.append(f'{where} includes "{name}": {place} lies below {other}')
            if path.startswith(("libjulia/include/", "vdbtools/include/")) and "/include/" not in included:
                found.append(f'{where} includes "{name}": a public header includes a private one')
    return found


def introductions(root):
    """For each room of vdbtools that is on disk, the public headers whose first comment introduces it."""
    public = os.path.join(root, "vdbtools/include/vdbtools")
    found = {room: [] for room in sorted(os.listdir(public))}
    for room, headers in found.items():
        for name in sorted(os.listdir(os.path.join(public, room))):
            with open(os.path.join(public, room, name), encoding="utf-8") as file:
                if f"The room `{room}`" in file.read().partition("#pragma once")[0]:
                    headers.append(name)
    return found


def speakers(root):
    """Lines of the libraries that print, or end the process: both are for the program alone."""
    speech = re.compile(r"std::(?:cout|cerr|clog)\b|\b(?:f|v|vf|d)?printf\(|\b(?:fputs|puts|putchar|perror)\(|"
                        r"(?<![\w.>])(?:_exit|_Exit|exit|quick_exit|abort|terminate)\(")
    found = []
    for layer in ("libjulia", "vdbtools"):
        for folder, _, names in os.walk(os.path.join(root, layer)):
            for name in sorted(names):
                if name.endswith((".h", ".cpp")):
                    path = os.path.join(folder, name)
                    with open(path, encoding="utf-8") as file:
                        code = [line.partition("//")[0] for line in file]
                    found += [f"{os.path.relpath(path, root)}:{k}: {line.strip()}" for k, line in enumerate(code, 1)
                              if speech.search(line)]
    return found


ANONYMOUS = re.compile(r"^namespace \{.*?^\}  // namespace$", re.MULTILINE | re.DOTALL)
NAMESPACE = re.compile(r"^namespace ([\w:]+) \{", re.MULTILINE)
TYPE = re.compile(r"^(?:struct|class|enum class) (\w+)(?: final)?(?: : [^{;]*)? ?\{", re.MULTILINE)


def twins(root):
    """Types that two files of a namespace define. The linker would take one's functions for the other's: C++ calls that
    a violation of the one-definition rule, and no tool reports it."""
    places = {}
    for path in sources(root):
        if path.split("/")[0] not in ("libjulia", "vdbtools", "cli"):
            continue
        with open(os.path.join(root, path), encoding="utf-8") as file:
            text = ANONYMOUS.sub("", file.read())
        space = NAMESPACE.search(text)
        for match in TYPE.finditer(text):
            places.setdefault((space.group(1) if space else "", match.group(1)), set()).add(path)
    return {name: sorted(paths) for name, paths in places.items() if len(paths) > 1}


PROSE = re.compile(r'//[^\n]*|/\*.*?\*/|^[ \t]*#[^\n]*|R"\(.*?\)"|"(?:\\.|[^"\\\n])*"', re.MULTILINE | re.DOTALL)
ENUMERATORS = re.compile(r"\benum\b[^{;]*\{([^}]*)\}")


def unreached(root):
    """Files of the rooms that use what no header defines that they include, neither themselves nor through others. A unity
    build hides that: another source of the group includes it. Looked at are names with the namespace before them, and types
    that one header defines. Only a build without unity finds the others."""
    included, code = {}, {}
    for path in sources(root):
        with open(os.path.join(root, path), encoding="utf-8") as file:
            text = file.read()
        named = (resolve(root, path, match.group(2)) for match in INCLUDE.finditer(text) if match.group(1) == '"')
        included[path], code[path] = [header for header in named if header], PROSE.sub("", text)
    defined = {}
    for path, text in code.items():
        if path.endswith(".h"):
            for match in TYPE.finditer(ANONYMOUS.sub("", text)):
                defined.setdefault(match.group(1), []).append(path)
    own = {path: set(re.findall(r"\b(?:class|struct|using) (\w+)", text)) |
           {word for body in ENUMERATORS.findall(text) for word in re.findall(r"\w+", body)} for path, text in code.items()}
    found = []
    words = {path: set(re.findall(r"\w+", text)) for path, text in code.items()}
    for path, text in code.items():
        if not place_of(path):
            continue
        reached, open_ends = {path}, [path]
        while open_ends:
            new = set(included[open_ends.pop()]) - reached
            reached |= new
            open_ends += new
        there = set().union(*(words[other] for other in reached - {path}))
        there.update(re.findall(r"(?<!::)\b\w+", text))
        for name in sorted(set(re.findall(r"(?<!namespace )\b(?:vdbtools|julia)::(\w+)\b(?!::)", text)) - there):
            found.append(f"{path} uses {name}, and includes no header that has it")
        known = set().union(*(own[other] for other in reached))
        for name in sorted(set(re.findall(r"(?<![\w.:>])\w+", text)) - known):
            if len(defined.get(name, ())) == 1 and defined[name][0] not in reached:
                found.append(f"{path} uses {name}, and includes {defined[name][0]} in no way")
    return found


class TheTree(unittest.TestCase):
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

    # Promise of architecture.md: "A room may include itself, the rooms *above it in this table*, and libjulia"
    def test_nothing_includes_what_lies_above_it(self):
        self.assertEqual(complaints(self.root), [])

    # Promise of design.md: The library "never prints, and it never exits"
    def test_the_libraries_neither_print_nor_exit(self):
        self.assertEqual(speakers(self.root), [])

    # Promise: "A room may include itself, the rooms ..."
    def test_one_header_introduces_each_room(self):
        for room, headers in introductions(self.root).items():
            with self.subTest(room=room):
                self.assertEqual(len(headers), 1, f"{headers} say 'The room `{room}`' at their top")

    def test_each_type_is_defined_once(self):
        self.assertEqual(twins(self.root), {})

    def test_each_file_includes_what_defines_its_types(self):
        self.assertEqual(unreached(self.root), [])

    def test_the_files_are_found(self):
        found = list(sources(self.root))
        self.assertGreater(len(found), 150)
        self.assertEqual({place_of(path) for path in found} - {None} - set(ORDER), set())


class ABadTree(unittest.TestCase):
    """Each rule finds what breaks it."""

    FILES = {
        "libjulia/include/julia/map.h": "",
        "libjulia/include/julia/fit/panels.h": '#include "julia/map.h"\n',
        "libjulia/src/fit/log.h": "",
        "vdbtools/include/vdbtools/base/grids.h": "#include <openvdb/openvdb.h>\n",
        "vdbtools/include/vdbtools/field/field.h": '#include "julia/map.h"\n#include "vdbtools/base/grids.h"\n',
        "vdbtools/include/vdbtools/job/job.h": '#include "vdbtools/field/field.h"\n',
        "vdbtools/src/field/blocks.h": "",
        "vdbtools/src/field/field.cpp": '#include "field/blocks.h"\n#include "vdbtools/field/field.h"\n',
        "cli/options.h": '#include "vdbtools/job/job.h"\n',
        "cli/commands/fit.cpp": '#include "options.h"\n',
        "tests/field/field_test.cpp": '#include "field/blocks.h"\n#include "vdbtools/job/job.h"\n',
    }

    @staticmethod
    def write(root, files):
        for path, text in files.items():
            os.makedirs(os.path.join(root, os.path.dirname(path)), exist_ok=True)
            with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                file.write(text)

    def complaints_with(self, extra):
        with tempfile.TemporaryDirectory() as root:
            self.write(root, {**self.FILES, **extra})
            return complaints(root)

    def expect(self, path, text, words):
        found = self.complaints_with({path: text})
        self.assertEqual(len(found), 1, found)
        self.assertIn(words, found[0])
        self.assertIn(path, found[0])

    def test_a_good_one_passes(self):
        self.assertEqual(self.complaints_with({}), [])

    def test_a_room_that_includes_a_later_one(self):
        self.expect("vdbtools/src/field/bad.cpp", '#include "vdbtools/job/job.h"\n',
                    "vdbtools/field lies below vdbtools/job")

    def test_a_layer_that_includes_a_higher_one(self):
        self.expect("libjulia/src/bad.cpp", '#include "../../vdbtools/include/vdbtools/base/grids.h"\n',
                    "libjulia lies below vdbtools/base")
        self.expect("vdbtools/src/job/bad.cpp", '#include "../../../cli/options.h"\n', "vdbtools/job lies below cli")

    def test_libjulia_that_includes_its_fit(self):
        self.expect("libjulia/src/bad.cpp", '#include "fit/log.h"\n', "libjulia lies below libjulia/fit")

    def test_a_private_header_of_another_layer(self):
        self.expect("cli/bad.cpp", '#include "field/blocks.h"\n', "does not exist where cli looks")

    def test_a_public_header_that_includes_a_private_one(self):
        self.expect("vdbtools/include/vdbtools/job/bad.h", '#include "field/blocks.h"\n', "a private one")

    def test_a_file_that_is_not_there(self):
        self.expect("vdbtools/src/job/bad.cpp", '\n#  include "vdbtools/job/gone.h"\n', "bad.cpp:2")

    def test_the_module_and_the_program(self):
        self.expect("python/src/bad.cpp", '#include "../../cli/options.h"\n', "side by side")

    def test_a_library_that_prints_or_exits(self):
        lines = 'std::cerr << "x";\n  fprintf(stderr, "x");\n// puts("x")\nsnprintf(a, b);\nsession.abort();\n  exit(1);\n'
        with tempfile.TemporaryDirectory() as root:
            self.write(root, {"vdbtools/src/job/bad.cpp": lines})
            self.assertEqual([line.split(": ")[0].rpartition(":")[2] for line in speakers(root)], ["1", "2", "6"])

    def test_two_types_of_one_name(self):
        shared = "namespace vdbtools {{\nstruct A {{ {0} }};\n}}\n"
        private = "namespace vdbtools {\nnamespace {\nstruct A {};\n}  // namespace\n}\n"
        with tempfile.TemporaryDirectory() as root:
            self.write(root, {"vdbtools/src/mesh/a.h": shared.format("int a;"), "vdbtools/src/field/b.h": shared.format(""),
                              "vdbtools/src/job/c.cpp": private, "cli/d.h": "namespace cli {\nstruct A {};\n}\n"})
            self.assertEqual(twins(root), {("vdbtools", "A"): ["vdbtools/src/field/b.h", "vdbtools/src/mesh/a.h"]})

    def test_what_no_included_header_has(self):
        header = "namespace vdbtools {\nclass Rows {\n};\n}\n"
        files = {"vdbtools/src/recipe/rows.h": header, "vdbtools/src/recipe/table.h": '#include "recipe/rows.h"\n',
                 "vdbtools/src/job/good.cpp": '#include "recipe/table.h"\nRows rows;\n',
                 "vdbtools/src/job/other.cpp": 'class Rows;\n// Rows\nconst char* text = "Rows";\n',
                 "vdbtools/src/job/bad.cpp": "static Rows rows;\n",
                 "vdbtools/include/vdbtools/job/job.h": "int runJob();\n",
                 "cli/good.cpp": '#include "vdbtools/job/job.h"\nint a = vdbtools::runJob();\n',
                 "cli/worse.cpp": "namespace vdbtools::own {\nint b = vdbtools::runJob();\n}\n"}
        with tempfile.TemporaryDirectory() as root:
            self.write(root, files)
            self.assertEqual(sorted(unreached(root)),
                             ["cli/worse.cpp uses runJob, and includes no header that has it",
                              "vdbtools/src/job/bad.cpp uses Rows, and includes vdbtools/src/recipe/rows.h in no way"])

    def test_a_file_in_no_room(self):
        self.expect("vdbtools/src/cellar/bad.cpp", "", "lies in no room")

    def test_an_own_header_in_angles(self):
        self.expect("vdbtools/src/job/bad.cpp", "#include <vdbtools/job/job.h>\n", "in quotes")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + ["-v"] + sys.argv[1:])

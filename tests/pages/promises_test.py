# SPDX-License-Identifier: Apache-2.0
"""docs/promises.md names tests that exist, and words that still stand on their pages."""
import ast
import functools
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PAGE = ROOT / "docs" / "promises.md"
BUILD_FILES = ("tests/CMakeLists.txt", "tests/fuzz/CMakeLists.txt", "tests/sanitized/CMakeLists.txt")
CASE = re.compile(r"^(?:TEST|TEST_F|TEST_P|TYPED_TEST)\((\w+), (\w+)\)", re.M)


def rows(text):
    """@return (promise, page, tests) of every row, without the heads of the tables"""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    cells = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]
    return [row for row in cells if row != ["promise", "page", "test"] and not set("".join(row)) <= set("-: ")]


def plain(text):
    """Without the marks of Markdown and the breaks of lines."""
    return re.sub(r"\s+", " ", re.sub(r"[*`]", "", text.replace("\\|", "|"))).casefold()


@functools.cache
def registered():
    """What ctest runs: the cases of each name, from the files of the build. Without cases, a name stands for itself."""
    found = {}
    for name in BUILD_FILES:
        folder, text = (ROOT / name).parent, (ROOT / name).read_text()
        for program, sources in re.findall(r"juliavdb_tests\((\w+).*?SOURCES(.*?)LIBRARIES", text, re.S):
            found[program] = {f"{suite}.{case}" for source in sources.split()
                              for suite, case in CASE.findall((folder / source).read_text())}
        for names, prefix, path in re.findall(r"foreach\(script ([^)]*)\)\s*juliavdb_script\((\w+)\$\{script\} ([^)]*)\)",
                                              text):
            for script in names.split():
                found[prefix + script] = functions(folder / path.replace("${script}", script))
        for test, path in re.findall(r"juliavdb_script\((\w+) (\S+?)[ )]", text):
            found[test] = functions(folder / path)
        for test, command in re.findall(r"add_test\(NAME (\w+)\s+COMMAND ([^)]*)\)", text):
            script = re.search(r"\$\{CMAKE_CURRENT_SOURCE_DIR\}/(\S+\.py)", command)
            found[test] = functions(folder / script.group(1)) if script else set()
    return found


def functions(path):
    return {node.name for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.FunctionDef)
            if node.name.startswith("test_")}


def mistakes(text):
    """Of a page of promises, as lines that say what is wrong."""
    found = []
    for row in rows(text):
        if len(row) != 3:
            found.append(f"not three cells: {row}")
            continue
        promise, page, tests = row
        link = re.fullmatch(r"\[[^]]+\]\(([^)#]+)(#[^)]*)?\)", page)
        path = PAGE.parent / link.group(1) if link else None
        if not path or not path.is_file():
            found.append(f"no such page: {page}")
        else:
            words = plain(path.read_text())
            found += [f"{page} does not say: {quote}" for quote in re.findall(r'"([^"]+)"', promise)
                      if plain(quote) not in words]
        for test in tests.split("; "):
            parts = re.fullmatch(r"`(\w+)`(?: (.+))?", test)
            if not parts or parts.group(1) not in registered():
                found.append(f"no such test: {test}")
                continue
            name, cases = parts.groups()
            found += [f"no such case of {name}: {case}" for case in (cases or "").split(", ")
                      if case and case not in registered()[name]]
    return found


class PromisesPage(unittest.TestCase):
    maxDiff = None

    def test_every_row_has_tests_and_words_that_exist(self):
        text = PAGE.read_text()
        self.assertGreater(len(rows(text)), 80)
        self.assertEqual(mistakes(text), [])

    def test_every_page_is_named(self):
        text = PAGE.read_text()
        pages = [path.name for path in PAGE.parent.glob("*.md") if path != PAGE and path.name != "references.md"]
        self.assertEqual([name for name in pages if f"]({name}" not in text], [])


class TheChecksThemselves(unittest.TestCase):
    def test_each_mistake_is_found(self):
        row = '| {} | [points](points.md) | {} |\n'
        good = row.format('"Exactly N points" are made', "`cli_makers` test_points_of_a_mesh; `soak`; `julia_tests` "
                          "RandomPolynomial.frozen; `layout` test_nothing_includes_what_lies_above_it; `fuzz_replay`")
        self.assertEqual(mistakes(good), [])
        for wrong, mistake in ((good.replace("`soak`", "`soak_`"), "no such test"),
                               (good.replace("test_points_of_a_mesh", "test_points_of_a_mess"), "no such case"),
                               (good.replace("RandomPolynomial.frozen", "RandomPolynomial.thawed"), "no such case"),
                               (good.replace("`fuzz_replay`", "`fuzz_replay` test_any"), "no such case"),
                               (good.replace("`soak`", "soak"), "no such test"),
                               (good.replace("`soak`; ", "; "), "no such test"),
                               (good.replace("Exactly N points", "Nearly N points"), "does not say"),
                               (good.replace("points.md", "pints.md"), "no such page"),
                               (row.format("nothing", ""), "no such test"),
                               ("| one | [points](points.md) |\n", "not three cells")):
            found = mistakes(wrong)
            self.assertEqual(len(found), 1, wrong)
            self.assertIn(mistake, found[0])


if __name__ == "__main__":
    unittest.main()

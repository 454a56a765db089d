# SPDX-License-Identifier: Apache-2.0
"""The comments that say which promises a test holds have their form, stand at tests, and quote what stands on the pages."""
import json
import pathlib
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "docs"))
import promises

OF = "Promise" + " of"  # in one piece, the mistakes below would be those of this file


class Promises(unittest.TestCase):
    maxDiff = None

    @classmethod
    def setUpClass(cls):
        cls.found, cls.wrong = promises.gather(promises.files())

    def test_nothing_is_wrong(self):
        self.assertEqual(self.wrong, [])

    def test_none_got_lost(self):
        counts = len(self.found), sum(len(cases) for _, tests in self.found.values() for cases in tests.values())
        for count, least in zip(counts, (421, 1374)):
            self.assertGreaterEqual(count, least, "if promises or their tests are removed on purpose, lower this number")

    def test_every_page_is_named(self):
        page = ROOT / "docs/promises.md"
        named = {page for page, _ in self.found}
        pages = [path.name for path in page.parent.glob("*.md") if path != page and path.name != "references.md"]
        self.assertEqual([name for name in pages if name not in named and f"]({name}" not in page.read_text()], [])

    def test_the_tables_and_the_json_have_all_of_them(self):
        tables, data = (subprocess.run([ROOT / "docs/make-promises", *words], stdout=subprocess.PIPE, text=True,
                                       check=True).stdout for words in ((), ("--json",)))
        self.assertEqual({(row["page"], row["promise"]): row["tests"] for row in json.loads(data)},
                         {key: tests for key, (_, tests) in self.found.items()})
        pages = {page for page, _ in self.found}
        self.assertEqual(sum(line.endswith(" |") for line in tables.splitlines()), len(pages) + len(self.found))
        for page in pages:
            self.assertEqual(tables.count(f"### {page}\n"), 1, page)


class TheChecksThemselves(unittest.TestCase):
    FILES = {
        "tests/search/spaced_points_test.cpp": f"""// Any comment.
// {OF} points.md: "Exactly N points" are
//   made
TEST(SpacedPoints, AnyName) {{
""",
        "tests/cli/test_makers.py": f'''# The head of a script.
# {OF} README.md#use: Words that are no quote
"""A script."""
class Makers:
    # {OF[:-3]}: "Exactly N ..."
    @any.decorator("of",
                   "two lines")
    def test_points(self):
        pass
''',
        "tests/fuzz/CMakeLists.txt": f"""
# {OF[:-3]}: Words ...
add_test(NAME fuzz_replay COMMAND any)
""",
    }

    def gather(self, old="", new=""):
        self.assertTrue(not old or any(old in text for text in self.FILES.values()), old)
        return promises.gather({ROOT / name: text.replace(old, new) if old else text for name, text in self.FILES.items()})

    def test_what_is_right(self):
        self.assertEqual(self.gather(), ({
            ("points.md", '"Exactly N points" are made'): (set(), {"vdbtools_tests": ["SpacedPoints.AnyName"],
                                                                   "cli_makers": ["Makers.test_points"]}),
            ("README.md", "Words that are no quote"): ({"use"}, {"cli_makers": [""], "fuzz_replay": [""]})}, []))

    def test_each_mistake_is_found(self):
        full, short = f"{OF} points.md: ", f"# {OF[:-3]}: Words"
        for old, new, mistake in (
                ('"Exactly N points"', '"Exactly N points of nothing"', "points.md does not say: Exactly N points of nothing"),
                ("points.md", "pints.md", "no such page: pints.md"),
                ("#use", "#misuse", "no such section: README.md#misuse"),
                ('points"', "points", "spaced_points_test.cpp: a quote does not end"),
                ("Exactly N ...", "Exactly M ...", "test_makers.py: 0 promises begin with"),
                ("// Any comment.", f'// {full}"Exactly N points"', "test_makers.py: 2 promises begin with"),
                ("// Any comment.", f'// {full}"Exactly N ..."', "a promise with its page has its full text"),
                ("//   made", "// made", "spaced_points_test.cpp:3: not the form of a promise"),
                ("// Any comment.", f"// {full}", "spaced_points_test.cpp:1: not the form of a promise"),
                ("// Any comment.", f"// {full[:-2]} points", "spaced_points_test.cpp:1: not the form of a promise"),
                ("// Any comment.", f"// {OF} points: points", "spaced_points_test.cpp:1: not the form of a promise"),
                ("// Any comment.", f"// {OF} docs/points.md: points", "spaced_points_test.cpp:1: not the form of a promise"),
                (short, short.replace(":", ""), "CMakeLists.txt:2: not the form of a promise"),
                (short, short.lower(), "CMakeLists.txt:2: not the form of a promise"),
                (short, short.replace(" ", "", 1), "CMakeLists.txt:2: not directly above a test"),
                ("...\nadd_test", "...\n\nadd_test", "CMakeLists.txt:2: not directly above a test"),
                ("fuzz_replay", "fuzz_replays", "CMakeLists.txt:2: not directly above a test"),
                ('"""A script."""', f'"""{OF} README.md: Words ..."""', "test_makers.py:3: not directly above a test"),
                ("      pass", f"      {short}\n        pass", "test_makers.py:9: not directly above a test"),
                ("def test_points", "def points", "test_makers.py:5: not directly above a test")):
            with self.subTest(new=new):
                found = self.gather(old, new)[1]
                self.assertEqual(len(found), 1, found)
                self.assertIn(mistake, found[0])

    def test_a_file_that_ctest_does_not_run(self):
        for name, mistake in (("any_test.cpp", "any_test.cpp:2: ctest does not run this test: SpacedPoints.AnyName"),
                              ("any_test.h", "any_test.h:2: not directly above a test")):
            text = self.FILES["tests/search/spaced_points_test.cpp"]
            self.assertEqual([line[:len(mistake)] for line in promises.gather({ROOT / name: text})[1]], [mistake])


if __name__ == "__main__":
    unittest.main()

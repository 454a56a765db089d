# SPDX-License-Identifier: Apache-2.0
"""The documentation site: links between its pages, and all of it where mkdocs is installed."""
import importlib.machinery
import importlib.util
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "docs"))  # what make-site imports
loader = importlib.machinery.SourceFileLoader("make_site", str(ROOT / "docs/make-site"))
make_site = importlib.util.module_from_spec(importlib.util.spec_from_loader("make_site", loader))
loader.exec_module(make_site)


class Site(unittest.TestCase):
    def test_links_go_to_the_places_of_the_site(self):
        cases = (("README.md", "[a](docs/design.md#b)", "[a](design.md#b)"), ("README.md", "![a](docs/images/x.png)", "![a](images/x.png)"),
                 ("docs/x.md", "[a](../README.md#use)", "[a](index.md#use)"), ("docs/x.md", "[a](maps.md)", "[a](maps.md)"),
                 ("docs/x.md", "[a](#b) [c](https://d.e/f)", "[a](#b) [c](https://d.e/f)"),
                 ("README.md", "[samples](samples) [x](CONTRIBUTING.md)", "samples [x](contributing.md)"),
                 ("docs/x.md", "```sh\n[a](../samples)\n```\n[a](../samples)", "```sh\n[a](../samples)\n```\na"))
        for page, text, expected in cases:
            with self.subTest(text=text):
                self.assertEqual(make_site.with_links(text, (ROOT / page).parent), expected)

    def test_every_page_has_a_place_and_every_place_a_page(self):
        named = [page for section in make_site.PAGES.values() for page in section]
        self.assertEqual(len(named), len(set(named)))
        pages = {page.stem for page in (ROOT / "docs").glob("*.md")} | {pathlib.Path(page).stem for page in make_site.OUTSIDE.values()}
        self.assertEqual(set(named), pages | {"api", "python-api"})

    def test_broken_links_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            site = pathlib.Path(folder)
            (site / "cpp").mkdir()
            (site / "cpp/x.html").write_text('<a href="nowhere.html">')
            (site / "a.html").write_text('<h2 id="here"></h2><a href="b.html#there"><a href="#here"><a href="cpp/x.html#any"><img src="c.png">'
                                         '<a href="b.html#where"><a href="http://d.e/">')
            (site / "b.html").write_text('<h2 id="there"></h2><a href="a.html#nowhere"><a href="d.html">')
            self.assertEqual(make_site.broken_links(site), ["a.html: c.png", "a.html: b.html#where", "b.html: a.html#nowhere", "b.html: d.html"])

    def test_the_reference_of_python_has_what_is_documented(self):
        with tempfile.TemporaryDirectory() as folder:
            stub = pathlib.Path(folder) / "x.pyi"
            stub.write_text('class A:\n    """Of A."""\n    @property\n    def p(self) -> int:\n        """Of p."""\n'
                            '    def q(self, x, *, y=1, z=2, w=3): ...\n    def r(self, x, *, y=1, z=2, w=3):\n        """Of r."""\n')
            page = make_site.python_page(stub)
        for words in ("## `class A`", "Of A.", "### `A.p`\n", "Of p.", "### `A.r(x, *, y=, z=, ...)`", "Of r."):
            self.assertIn(words, page)
        self.assertNotIn("A.q", page)

    @unittest.skipUnless(importlib.util.find_spec("mkdocs"), "mkdocs is not installed")
    def test_the_site_is_made_without_warnings(self):
        with tempfile.TemporaryDirectory() as folder:
            site = pathlib.Path(folder) / "site"
            done = subprocess.run([ROOT / "docs/make-site", site], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("Commands by example", (site / "search/search_index.json").read_text())
            for link in ("index.html#use", "design.html#vdb"):  # of the tables that tests make
                self.assertIn(link, make_site.Links(site / "promises.html").links)
            self.assertFalse((site / "try").exists())
            for page in ("index.html", "browser.html"):
                self.assertNotIn("try/index.html", make_site.Links(site / page).links)

    @unittest.skipUnless(importlib.util.find_spec("mkdocs"), "mkdocs is not installed")
    def test_the_site_has_the_page_on_which_a_mesh_is_dropped(self):
        with tempfile.TemporaryDirectory() as folder:
            page, site = pathlib.Path(folder) / "page", pathlib.Path(folder) / "site"
            subprocess.run([ROOT / "wasm/make-page", page], check=True)
            for name in ("juliavdb_page.js", "juliavdb_page.wasm"):  # stand-ins for the program
                (page / name).write_bytes(b"\0asm " + name.encode())
            done = subprocess.run([ROOT / "docs/make-site", site, "--page", page], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            files = {path.relative_to(page): path.read_bytes() for path in page.rglob("*") if path.is_file()}
            self.assertEqual({path.relative_to(site / "try"): path.read_bytes() for path in (site / "try").rglob("*") if path.is_file()}, files)
            for name in ("index.html", "browser.html"):
                self.assertIn("try/index.html", make_site.Links(site / name).links)

    def test_a_folder_without_the_page_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([ROOT / "docs/make-site", pathlib.Path(folder) / "site", "--page", folder], capture_output=True, text=True)
            self.assertEqual(done.returncode, 1)
            self.assertIn("has no index.html; wasm/build makes the page", done.stderr)
            self.assertEqual(list(pathlib.Path(folder).iterdir()), [])


if __name__ == "__main__":
    unittest.main()

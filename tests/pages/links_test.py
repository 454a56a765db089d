# SPDX-License-Identifier: Apache-2.0
"""What the pages and the comments refer to is there: links, pictures, papers, sections of the design, headers."""
import pathlib
import re
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SOURCES = ("libjulia", "vdbtools", "cli", "tests", "bench", "samples")
CITATION = re.compile(r"\[([A-Z][A-Za-z]{1,7}\d{2})\]")
SECTION = re.compile(r"design\.md,?\s+(?:sections?\s+)?(\d(?:\.\d)?)\b")
CODE_BLOCK = re.compile(r"^```.*?^```$", re.M | re.S)


def pages(root):
    return sorted(page for page in (*root.glob("*.md"), *root.glob("docs/*.md")))


def sources(root):
    """This file apart, whose examples are mistakes."""
    return sorted(path for folder in SOURCES for path in (root / folder).rglob("*")
                  if path.suffix in (".h", ".cpp", ".py") and path.name != pathlib.Path(__file__).name)


def joined(path):
    """The text with each comment that runs over lines on one line, so that a citation may be broken anywhere."""
    return re.sub(r"\n[ \t]*(?://+|#)?[ \t]*", " ", path.read_text())


def anchor(heading):
    """The name that a heading has in links, as GitHub and others make it."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


def anchors(page):
    return {anchor(heading) for heading in re.findall(r"^#+ (.*)$", CODE_BLOCK.sub("", page.read_text()), re.M)}


def broken_links(root):
    """Relative links and pictures that lead nowhere, as 'page: link'."""
    broken = []
    for page in pages(root):
        text = CODE_BLOCK.sub("", page.read_text())
        for link in re.findall(r"\]\(([^)\s]+)\)", text):
            if re.match(r"[a-z]+:", link):
                continue
            name, _, fragment = link.partition("#")
            target = page.parent / name if name else page
            if not target.exists() or (fragment and fragment not in anchors(target)):
                broken.append(f"{page.relative_to(root)}: {link}")
    return broken


def unlisted_citations(root):
    """Papers cited anywhere that docs/references.md does not list, as 'file: key'."""
    listed = set(re.findall(r"^\*\*\[(\w+)\]\*\*", (root / "docs/references.md").read_text(), re.M))
    return [f"{path.relative_to(root)}: {key}" for path in pages(root) + sources(root)
            for key in sorted(set(CITATION.findall(path.read_text())) - listed)]


def unknown_sections(root):
    """Sections of docs/design.md that are cited and do not exist, as 'file: number'."""
    known = set(re.findall(r"^#+ (\d(?:\.\d)?)\.? ", (root / "docs/design.md").read_text(), re.M))
    return [f"{path.relative_to(root)}: {number}" for path in pages(root) + sources(root)
            for number in sorted(set(SECTION.findall(joined(path))) - known)]


def missing_files(root):
    """Headers and sources that docs/architecture.md names and that do not exist."""
    text = (root / "docs/architecture.md").read_text()
    missing = []
    for name in re.findall(r"`((?:julia|vdbtools)/[\w/]+\.h)`", text):
        library = "libjulia" if name.startswith("julia/") else "vdbtools"
        if not (root / library / "include" / name).is_file():
            missing.append(name)
    for name in re.findall(r"`((?:cli|vdbtools|libjulia|samples|tests|bench|docs)/[\w/.-]+)`", text):
        if name not in missing and not name.endswith(".h") and not (root / name).exists() \
                and not (root / "vdbtools/include" / name).exists():
            missing.append(name)
    return missing


def rooms_named(root):
    """The rooms in the table of docs/architecture.md, from first to last."""
    table = (root / "docs/architecture.md").read_text().partition("## The rooms of vdbtools")[2].partition("\n## ")[0]
    return re.findall(r"^\| `(\w+)` \|", table, re.M)


def pictures_with_text(root):
    """PNG files of the docs that hold text, such as the command lines and paths that programs leave in them."""
    return [str(path.relative_to(root)) for path in sorted((root / "docs").rglob("*.png"))
            if re.search(rb"(tEXt|zTXt|iTXt|eXIf)(?=[ -~\0])", path.read_bytes()[:4096] + path.read_bytes()[-4096:])]


class Pages(unittest.TestCase):
    def test_pictures_hold_no_text(self):
        self.assertEqual(pictures_with_text(ROOT), [])

    # Promise of gallery.md: Links, citations and names of files on the pages lead somewhere; the stored pictures are, pixel for
    #   pixel, what their commands make (some are compared by a test, all by `docs/check-pictures`)
    def test_links_lead_somewhere(self):
        self.assertEqual(broken_links(ROOT), [])

    # Promise: Links, citations and names ...
    def test_every_cited_paper_is_listed(self):
        self.assertEqual(unlisted_citations(ROOT), [])

    def test_every_cited_section_of_the_design_exists(self):
        self.assertEqual(unknown_sections(ROOT), [])

    # Promise: Links, citations and names ...
    def test_what_the_architecture_names_exists(self):
        self.assertEqual(missing_files(ROOT), [])

    def test_the_architecture_names_every_room(self):
        rooms = {path.name for path in (ROOT / "vdbtools/include/vdbtools").iterdir() if path.is_dir()}
        self.assertEqual(set(rooms_named(ROOT)), rooms)


class TheChecksThemselves(unittest.TestCase):
    """On a small project with one mistake of each kind."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.write("README.md", "[good](docs/design.md#2-the-mathematics) [bad](docs/gone.md) ![bad](gone.png) "
                                "[bad](docs/design.md#nowhere) [web](https://example.org)\n```sh\n[no](link)\n```\n")
        self.write("docs/design.md", "# Design\n## 2. The mathematics\n### 2.4 The shell: where\nby [ABC99]\n")
        self.write("docs/references.md", "**[ABC99]** A. Author.\n")
        self.write("docs/architecture.md", "`julia/good.h` `julia/gone.h` `vdbtools/a/gone.h` `cli/gone.cpp`\n"
                                           "## The rooms of vdbtools\n\n| `first` | x |\n| `second` | y |\n")
        self.write("libjulia/include/julia/good.h", "/// As [ABC99] and [XYZ01]; see docs/design.md 2.4, docs/design.md\n"
                                                    "/// 2.9, and docs/design.md section 2.\n")

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def test_each_mistake_is_found(self):
        self.assertEqual(broken_links(self.root),
                         ["README.md: docs/gone.md", "README.md: gone.png", "README.md: docs/design.md#nowhere"])
        self.assertEqual(unlisted_citations(self.root), ["libjulia/include/julia/good.h: XYZ01"])
        self.assertEqual(unknown_sections(self.root), ["libjulia/include/julia/good.h: 2.9"])
        self.assertEqual(missing_files(self.root), ["julia/gone.h", "vdbtools/a/gone.h", "cli/gone.cpp"])
        self.assertEqual(rooms_named(self.root), ["first", "second"])

    def test_text_in_a_picture_is_found(self):
        for name, kind in (("good", b"IDAT"), ("bad", b"tEXt")):
            self.write(f"docs/{name}.png", "")
            (self.root / f"docs/{name}.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"\0\0\0\x04" + kind + b"made" + b"\0" * 4)
        self.assertEqual(pictures_with_text(self.root), ["docs/bad.png"])


if __name__ == "__main__":
    unittest.main()

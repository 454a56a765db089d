# SPDX-License-Identifier: Apache-2.0
"""Reads which promises the tests hold from the comments at the tests. docs/promises.md describes their form."""
import ast
import functools
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD_FILES = ("tests/CMakeLists.txt", "tests/fuzz/CMakeLists.txt", "tests/sanitized/CMakeLists.txt")
CASE = re.compile(r"^(?:TEST|TEST_F|TEST_P|TYPED_TEST)\((\w+), (\w+)\)", re.M)
REGISTRATION = re.compile(r"^\s*(?:add_test\(NAME|juliavdb_script\() *(\w+)\s", re.M)
COMMENT = re.compile(r"\s*(?://|#)(?: (.*)|)$")
# With its page, a promise has its full text; without, the words with which it begins.
FORM = re.compile(r"Promise(?: of ([\w-]+\.md)(?:#([^\s:]+))?)?: (\S.*)")
# What is meant as a promise, whether or not it has the form.
SIGN = re.compile(r"^\s*(?://+|#+)\W*promise\b|\bpromises? of \S+\.md\b", re.I)
CUT = re.compile(r' ?\.\.\."?$')
QUOTE = re.compile(r'"([^"]+)"')


@functools.cache
def registered():
    """What ctest runs, as {name: files}. A test that is neither a script of tests/ nor a program of GoogleTest has no files."""
    found = {}
    for name in BUILD_FILES:
        folder, text = (ROOT / name).parent, (ROOT / name).read_text()
        for program, sources in re.findall(r"juliavdb_tests\((\w+).*?SOURCES(.*?)LIBRARIES", text, re.S):
            found[program] = [folder / source for source in sources.split()]
        for names, prefix, path in re.findall(r"foreach\(script ([^)]*)\)\s*juliavdb_script\((\w+)\$\{script\} ([^)]*)\)",
                                              text):
            found.update({prefix + script: [folder / path.replace("${script}", script)] for script in names.split()})
        for test, path in re.findall(r"juliavdb_script\((\w+) (\S+?)[ )]", text):
            found[test] = [folder / path]
        for test, command in re.findall(r"add_test\(NAME (\w+)\s+COMMAND ([^)]*)\)", text):
            script = re.search(r"\$\{CMAKE_CURRENT_SOURCE_DIR\}/(\S+\.py)", command)
            found[test] = [folder / script.group(1)] if script else []
    return found


def files():
    """The text of every file in which a promise may be meant to stand."""
    found = {path for paths in registered().values() for path in paths}
    found |= {path for path in (ROOT / "tests").rglob("*") if path.is_file() and path.suffix in (".cpp", ".h", ".py", ".txt", "")
              and "regressions" not in path.parts}
    return {path: path.read_text(errors="replace") for path in sorted(found)}


def tests_in(path, text):
    """@return (index of its first line, its names in ctest, case) of every test; case is "" for a whole one"""
    names = [name for name, paths in registered().items() if path in paths]
    if path.suffix == ".cpp":
        return [(text.count("\n", 0, m.start()), names, ".".join(m.groups())) for m in CASE.finditer(text)]
    if path.name == "CMakeLists.txt":
        return [(text.count("\n", 0, m.start(1)), [m.group(1)], "") for m in REGISTRATION.finditer(text)
                if m.group(1) in registered()]
    if not names:
        return []
    head = next((k for k, line in enumerate(text.splitlines()) if not line.startswith("#")), 0)
    return [(head, names, "")] + [
        (min(part.lineno for part in (node, *node.decorator_list)) - 1, names, f"{suite.name}.{node.name}")
        for suite in ast.parse(text).body if isinstance(suite, ast.ClassDef)
        for node in suite.body if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")]


def comments(path, text):
    """@return the promises of a file as [page or None, section or None, words, names in ctest, case], and its mistakes"""
    found, wrong, read, lines, where = [], [], set(), text.splitlines(), path.relative_to(ROOT)
    for end, names, case in tests_in(path, text) if "promise" in text.casefold() else []:
        start, promise = end, None
        while start and COMMENT.match(lines[start - 1]):
            start -= 1
        for number in range(start, end):
            words = COMMENT.match(lines[number]).group(1) or ""
            form = FORM.fullmatch(words)
            read.add(number)
            if form and names:
                promise = [*form.groups(), names, case]
                found.append(promise)
            elif form:
                wrong.append(f"{where}:{number + 1}: ctest does not run this test: {case}")
            elif promise and words.startswith("  "):
                promise[2] += " " + words.strip()
            elif promise or SIGN.search(lines[number]):
                wrong.append(f"{where}:{number + 1}: not the form of a promise: {lines[number].strip()}")
    return found, wrong + [f"{where}:{number + 1}: not directly above a test: {line.strip()}" for number, line in enumerate(lines)
                           if number not in read and SIGN.search(line)]


def plain(text):
    """Without the marks of Markdown and the breaks of lines."""
    return re.sub(r"\s+", " ", re.sub(r"[*`]", "", text.replace("\\|", "|"))).casefold()


def path_of(page):
    return next((path for path in (ROOT / "docs" / page, ROOT / page) if path.is_file()), None)


@functools.cache
def sections(page):
    """@return (heading, name in links, plain text) of each section; the name of the one below the title is empty"""
    found, code = [], False
    for line in path_of(page).read_text().splitlines():
        code ^= line.startswith("```")
        heading = None if code else re.match(r"#+ (.*)", line)
        if heading or not found:
            found.append([heading.group(1).strip() if heading else "", ""])
        found[-1][1] += line + "\n"
    return [(heading, re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") if k else "", plain(text))
            for k, (heading, text) in enumerate(found)]


def section_of(page, name, words):
    """The index of the section with a name, or without one of the first that has the first quote."""
    quote = QUOTE.search(words)
    return next((k for k, (_, other, text) in enumerate(sections(page))
                 if (name == other if name else quote and plain(quote.group(1)) in text)), 0)


def gather(texts):
    """@return the promises of {path: text}, as {(page, words): (named sections, {name in ctest: [cases]})}, and all mistakes"""
    promises, short, wrong = {}, [], []

    def add(key, names, case):
        for name in names:
            promises[key][1].setdefault(name, []).append(case)

    for path, text in texts.items():
        found, mistakes = comments(path, text)
        wrong += mistakes
        for page, section, words, names, case in found:
            if words.count('"') % 2:
                wrong.append(f"{path.relative_to(ROOT)}: a quote does not end: {words}")
            if not page:
                short.append((path, words, names, case))
            elif CUT.search(words):
                wrong.append(f"{path.relative_to(ROOT)}: a promise with its page has its full text: {words}")
            else:
                promises.setdefault((page, words), (set(), {}))[0].update({section} - {None})
                add((page, words), names, case)
    for path, words, names, case in short:
        start = CUT.sub("", words)
        meant = [key for key in promises if key[1] == words] or [key for key in promises if key[1].startswith(start)]
        if len(meant) == 1:
            add(meant[0], names, case)
        else:
            wrong.append(f"{path.relative_to(ROOT)}: {len(meant)} promises begin with: {start}")
    for (page, words), (named, _) in promises.items():
        if not path_of(page):
            wrong.append(f"no such page: {page}, which promises: {words}")
            continue
        wrong += [f"{page} does not say: {quote}" for quote in QUOTE.findall(words)
                  if not any(plain(quote) in text for *_, text in sections(page))]
        wrong += [f"no such section: {page}#{name}" for name in named - {name for _, name, _ in sections(page)}]
    return promises, wrong


def rows():
    """All promises as dictionaries, page by page, and each page from its top. A mistake raises ValueError."""
    promises, wrong = gather(files())
    if wrong:
        raise ValueError("\n".join(wrong))
    found = []
    for (page, words), (named, tests) in promises.items():
        index = section_of(page, next(iter(named), None), words)
        heading, name, _ = sections(page)[index]
        found.append(((path_of(page).parent != ROOT, page, index),
                      {"page": page, "section": heading, "anchor": name, "promise": words, "tests": tests}))
    return [row for _, row in sorted(found, key=lambda pair: pair[0])]


def tables():
    """All promises in Markdown, one table for each page, with links that are valid in docs/."""
    lines, page = [], None
    for row in rows():
        if page != row["page"]:
            page = row["page"]
            lines += ["", f"### {page}", "", "| promise | section | tests |", "|---|---|---|"]
        target = ("../" if path_of(page).parent == ROOT else "") + page + ("#" if row["anchor"] else "") + row["anchor"]
        tests = "; ".join(f"`{name}` {', '.join(filter(None, cases))}".strip() for name, cases in row["tests"].items())
        cells = row["promise"], f"[{re.sub('[][`*]', '', row['section'])}]({target})", tests
        lines.append(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |")
    return "\n".join(lines[1:]) + "\n"

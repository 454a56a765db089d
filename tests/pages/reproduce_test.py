# SPDX-License-Identifier: Apache-2.0
"""reproduce/run at its small size: laws of the results, what it refuses, and what becomes of a run that is killed."""
import csv
import hashlib
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from shell import PROGRAM, put_bunny, run as run_in_shell

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
RUN = ROOT / "reproduce/run"
PAGE = ROOT / "docs/replication.md"
# A build without them leaves these entries out, and says so.
OPTIONAL = {name: "the Python module juliavdb" for name in ("ablation-steps", "kd20-copies", "kd20-figure-4",
                                                                 "zb25-thinner", "zb25-speed", "dimension-known")}
# What takes hours, runs alone and has a test of its own.
ALONE = ["kd20-ten-billion"]


def reproduce(*arguments, environment=None):
    return subprocess.run([sys.executable, RUN, *map(str, arguments)], capture_output=True, text=True,
                          env={**os.environ, "JULIAVDB": str(PROGRAM), **(environment or {})})


def number(text):
    try:
        return float(text)
    except ValueError:
        return None


class Results:
    """The results in a folder, by entry: the rows of a table as dictionaries of text."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)

    def rows(self, entry):
        with open(self.folder / entry / "table.csv") as file:
            return list(csv.DictReader(file))

    def ours(self, entry, quantity):
        """Of one quantity, by case."""
        return {row["case"]: number(row["ours"]) if number(row["ours"]) is not None else row["ours"]
                for row in self.rows(entry) if row["quantity"] == quantity}

    def stored(self, entry):
        return json.loads((self.folder / entry / "result.json").read_text())

    def untimed(self, entry):
        """The table without what depends on the clock and the machine."""
        return [row for row in self.rows(entry) if not re.search(r"CPU|clock|memory", row["quantity"])]


def entries():
    listed = reproduce("--list")
    assert listed.returncode == 0, listed.stderr
    return {name: words for name, words in (line.split(maxsplit=1) for line in listed.stdout.splitlines()) if name not in ALONE}


class SmallRun(unittest.TestCase):
    """One run of all entries, which the tests look at."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = pathlib.Path(cls.temporary.name) / "results"
        cls.page = pathlib.Path(cls.temporary.name) / "docs/reproduction.md"
        cls.page.parent.mkdir()
        cls.entries = entries()
        cls.done = reproduce("--small", "--into", cls.folder, "--page", cls.page)
        cls.results = Results(cls.folder)
        cls.left_out = {name for name, what in OPTIONAL.items() if f"{name}: failed: it needs {what}" in cls.done.stderr}

    def made(self):
        return [name for name in self.entries if name not in self.left_out]

    def need(self, entry):
        if entry in self.left_out:
            self.skipTest(f"{entry} needs {OPTIONAL[entry]}")
        return self.results

    def test_every_entry_has_its_result(self):
        self.assertEqual(self.done.returncode, 1 if self.left_out else 0, self.done.stderr)
        self.assertEqual({path.name for path in self.folder.iterdir() if not path.name.startswith(".")}, set(self.made()))
        for name in self.made():
            stored = self.results.stored(name)
            self.assertEqual(stored["size"], "small")
            self.assertRegex(stored["version"], r"^juliavdb \d")
            self.assertEqual({path.name for path in (self.folder / name).iterdir()},
                             {"result.json", "table.csv", "table.md", *stored["pictures"]})
            for picture in stored["pictures"]:
                self.assertEqual((self.folder / name / picture).read_bytes()[:4], b"\x89PNG")

    # Promise: A page of results has "the commands ..."
    def test_every_entry_of_a_paper_has_what_the_paper_has(self):
        for name in self.made():
            of_paper = self.entries[name].startswith("[")
            self.assertEqual(any(row["paper"] for row in self.results.rows(name)), of_paper, name)
            for row in self.results.rows(name):
                self.assertNotEqual(row["ours"], "", (name, row))
                if row["ratio"]:
                    self.assertAlmostEqual(float(row["ratio"]), float(row["ours"]) / float(row["paper"]), delta=1e-5 * float(row["ratio"]))

    # Promise of reproduction.md: A page of results has "the commands as they ran, what the paper has, what they gave here, and
    #   the ratio"
    def test_the_page_has_every_entry_with_its_commands(self):
        page = self.page.read_text()
        self.assertIn("**Run at the size small**", page)
        for name in self.made():
            self.assertIn(f"`reproduce/run {name}`", page)
            for step in self.results.stored(name)["steps"]:
                self.assertIn(step["command"], page)
            self.assertIn((self.folder / name / "table.md").read_text(), page)
        for link in re.findall(r"!\[[^]]*\]\(([^)]+)\)", page):
            self.assertTrue((self.page.parent / link).is_file(), link)

    # Promise: A page of results has "the commands ..."
    def test_the_commands_of_the_page_run_as_they_stand(self):
        with tempfile.TemporaryDirectory() as folder:
            bunny = put_bunny(folder)
            step = self.results.stored("ablation-islands")["steps"][0]
            done = run_in_shell(f"bunny={bunny}\n{step['command']}", folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(f"{step['events'][0]['counts']['evaluatedNodes']} nodes evaluated", done.stderr)

    def test_dimensions_are_those_of_surfaces(self):
        for entry in ("kd20-dimension", "ablation-dimension"):
            errors = self.results.ours(entry, "standard error")
            for case, dimension in self.results.ours(entry, "dimension").items():
                self.assertGreater(dimension + 4 * errors[case], 2, (entry, case))
                self.assertLess(dimension, 3, (entry, case))

    # Promise of replication.md: "The text needs phi - beta"
    def test_a_larger_beta_moves_the_shell_outward(self):
        volumes = self.results.ours("sk23-sweeps", "% of the target's volume")
        betas = sorted((float(case.split()[1]), volume) for case, volume in volumes.items() if case.startswith("beta"))
        self.assertGreaterEqual(len(betas), 3)
        self.assertEqual([volume for _, volume in betas], sorted({volume for _, volume in betas}))

    def test_a_larger_alpha_leaves_less_open(self):
        radii = list(self.results.ours("sk23-average", "radius that all sets hold, of the largest circle").values())
        self.assertEqual(radii, sorted(radii))
        nodes = [count for case, count in self.results.ours("sk23-sweeps", "nodes that are evaluated").items() if case.startswith("alpha")]
        self.assertEqual(nodes, sorted(nodes, reverse=True))

    def test_alpha_and_beta_belong_to_one_unit_of_the_mesh(self):
        """Whatever the longest side is, alpha over it and beta times it are the paper's; a larger one leaves more of the target."""
        for step in self.results.stored("sk23-unit")["steps"]:
            alpha, side = (float(re.search(rf", {word} ([\d.]+)", step["label"]).group(1)) for word in ("alpha", "longest side"))
            beta = re.search(r", beta ([\d.]+)", step["label"])
            self.assertAlmostEqual(float(re.search(r"--alpha (\S+)", step["command"]).group(1)) / side, alpha, delta=1e-5 * alpha)
            found = re.search(r"--beta (\S+)", step["command"])
            self.assertEqual(bool(found), bool(beta))
            if beta:
                self.assertAlmostEqual(float(found.group(1)) * side, float(beta.group(1)), delta=1e-5)
        volumes = self.results.ours("sk23-unit", "% of the target's volume")
        for shape in ("dragon", "bunny"):
            found = [volume for case, volume in volumes.items() if case.startswith(shape)]
            self.assertGreaterEqual(len(found), 4)
            self.assertEqual(found, sorted(found))

    def test_sets_in_the_plane_are_those_of_the_reference(self):
        for case, off in self.results.ours("sk23-figure-8", "largest difference from reproduce/reference_maps.py").items():
            self.assertLess(off, 1e-9, case)
        least, greatest = (self.results.ours("sk23-figure-8", f"{word} phi of a pixel that some set {does}")
                           for word, does in (("least", "leaves out"), ("greatest", "holds")))
        self.assertEqual(list(least), ["star", "trefoil"])
        for case in least:
            self.assertLess(least[case], greatest[case])

    def test_a_map_with_a_simple_root_outside_has_copies_of_its_set(self):
        results = self.need("kd20-copies")
        overlap = results.ours("kd20-copies", "intersection over union with that set")
        self.assertEqual(len(overlap), 2)
        for case, found in overlap.items():
            self.assertGreater(found, 0.85, case)

    def test_single_and_double_precision_agree(self):
        for case, ratio in self.results.ours("kd20-precision", "their ratio").items():
            self.assertAlmostEqual(ratio, 1, delta=1e-3, msg=case)

    def test_logarithms_have_no_infinities_where_products_have(self):
        shares = self.results.ours("kd20-figure-3", "share of nodes with an infinity or NaN")
        self.assertEqual(shares["in logarithms, 32 bits"], 0)
        self.assertGreater(shares["32 bits"], 0.1)
        for fit in ("", "--alpha 49, ", "--alpha 113, "):
            self.assertLessEqual(shares[fit + "80 bits"], shares[fit + "64 bits"])
            self.assertLessEqual(shares[fit + "64 bits"], shares[fit + "32 bits"])
            self.assertEqual(shares[fit + "64 bits, with the guard of Eq. 2"], 0)

    def test_a_line_puts_vertices_elsewhere_than_a_search(self):
        off = self.need("kd20-figure-4").ours("kd20-figure-4", "from the searched vertex, in edges, median")
        for case, distance in off.items():
            self.assertTrue(0.05 < distance < 0.5, case)

    def test_no_guard_leaves_an_infinity(self):
        shares = self.results.ours("kd20-guard", "share of nodes with an infinity or NaN")
        stopped = self.results.ours("kd20-guard", "share of nodes that the guard stops")
        for case, share in shares.items():
            if not case.endswith("no guard"):
                self.assertEqual(share, 0, case)
        for fit in ("--alpha 200, ", "--alpha 392, "):
            # The larger what is subtracted from 308, the sooner it stops.
            grow = [stopped[fit + words] for words in ("the sum 0", "the sum of the frog", "the sum of the bunny",
                                                       "the guard of Eq. 2", "the factor 2")]
            self.assertEqual(grow[:3], sorted(grow[:3]))
            self.assertLessEqual(stopped[fit + "the factor 1.01"], grow[3])
            self.assertLessEqual(grow[3], grow[4])

    # Promise of replication.md: "Our psi therefore takes |phi| to be at least half a cell"
    def test_psi_is_that_of_independent_sums(self):
        psi = self.results.ours("kim15-psi", "psi")
        moved = self.results.ours("kim15-psi", "range over five shifts of the cells")
        capped, printed = "computed again, |phi| at least half a cell", "computed again, W = 1/phi as printed"
        self.assertAlmostEqual(psi["the program"], psi[capped], delta=0.02)
        self.assertGreater(moved[printed], 5 * moved[capped])

    # Promise of replication.md: "The derivation is right, and so are Eqs. 24 and 27", other formulas are not
    def test_the_appendix_as_corrected_is_the_gradient(self):
        printed = self.results.ours("kim15-appendix", "relative error as printed, median")
        for case, error in self.results.ours("kim15-appendix", "relative error as corrected, largest").items():
            self.assertLess(error, 1e-6, case)
            (self.assertLess if case == "Eqs. 24 and 27" else self.assertGreater)(printed[case], 1e-2, case)

    def test_scaled_roots_and_other_slices(self):
        volumes = self.results.ours("kim15-transforms", "volume, in the units of the mesh")
        sphericity = self.results.ours("kim15-transforms", "sphericity")
        for cases in (("scaled by 0.5", "scaled by 0.8", "as fitted", "scaled by 1.1", "scaled by 1.25"),
                      ("as fitted", "slice 0.05", "slice 0.1", "slice 0.2")):
            found = [volumes[f"frog, {case}"] for case in cases]
            self.assertEqual(found, sorted(found, reverse=True))
        self.assertGreater(sphericity["frog, scaled by 0.5"], sphericity["frog, as fitted"])
        for case, value in sphericity.items():
            self.assertTrue(0 < value <= 1, case)

    def test_the_phases_of_a_fit_are_parts_of_its_time(self):
        whole = self.results.ours("kim15-table-1", "CPU s")
        for case, seconds in whole.items():
            parts = [self.results.ours("kim15-table-1", f"CPU s of the {phase}").get(case, 0)
                     for phase in ("electrostatics", "monopoles", "optimisation")]
            self.assertGreater(parts[2], 0, case)
            self.assertEqual(min(parts[:2]) > 0, case.endswith("kim15"), case)
            self.assertLess(sum(parts), seconds, case)

    # Promise of replication.md: "Algorithm 1 as it is printed gives hardly any here"
    def test_few_monopoles_are_negative(self):
        counts = self.results.ours("kim15-monopoles", "monopoles")
        for case, negative in self.results.ours("kim15-monopoles", "of negative weight").items():
            self.assertLess(negative, 0.1 * counts[case], case)

    def test_proofs_change_no_byte(self):
        self.assertEqual(set(self.results.ours("ablation-proofs", "the same file as with proofs").values()), {"True"})
        nodes = self.results.ours("ablation-proofs", "nodes that are evaluated")
        for case in nodes:
            self.assertLessEqual(nodes[re.sub("no proofs", "proofs", case)], nodes[case])

    def test_more_steps_decide_more(self):
        results = self.need("ablation-steps")
        for quantity in ("% escaped", "% on their last side"):
            shares = list(results.ours("ablation-steps", quantity).values())
            self.assertEqual(shares, sorted(shares))
        self.assertEqual(shares[-1], 100)

    def test_estimates_lie_within_their_intervals(self):
        low, high = (self.results.ours("kd20-scale", f"{word}, million") for word in ("from", "to"))
        for case, found in self.results.ours("kd20-scale", "million triangles").items():
            self.assertTrue(low.get(case, 0) <= found <= high.get(case, found), case)

    def test_classes_hold_every_pair_once(self):
        sizes = self.results.ours("zb25-classes", "pairs")
        whole = sizes.pop("all") - self.results.ours("zb25-classes", "pairs that show nothing")["all"]
        self.assertEqual(sum(sizes.values()), whole)

    def test_a_smooth_surface_has_the_dimension_two(self):
        for way in ("triangles", "boxes"):
            deviations = self.need("dimension-known").ours("dimension-known", f"deviation, {way}")
            for case in ("sphere, a mesh", "unit ball, q^2 at n = 20"):
                self.assertAlmostEqual(deviations[case], 0, delta=0.06, msg=(case, way))

    def test_few_steps_make_a_dimension_too_small(self):
        results = self.need("dimension-known")
        found = results.ours("dimension-known", "by triangles")
        self.assertLess(found["q^2 - 1 at n = 5"], found["q^2 - 1 at n = 20"])
        self.assertLess(results.ours("dimension-known", "deviation, triangles")["q^2 - 1 at n = 5"], -0.2)

    def test_means_over_seeds_lie_between_the_least_and_the_greatest(self):
        low, high = (self.results.ours("dimension-seeds", word) for word in ("least", "greatest"))
        for case, mean in self.results.ours("dimension-seeds", "dimension, mean").items():
            self.assertTrue(low[case] < mean < high[case], case)

    def test_detail_makes_blocks_of_a_larger_dimension(self):
        plain, rough = self.results.ours("dimension-map", "quantile 0.95").values()
        self.assertGreater(rough, plain)

    def test_the_set_gets_thinner_until_no_point_is_in_it(self):
        inside = list(self.need("zb25-thinner").ours("zb25-thinner", "points inside").values())
        self.assertEqual(inside, sorted(inside, reverse=True))
        self.assertGreater(inside[0], 0)
        self.assertEqual(inside[-1], 0)

    def test_the_form_without_trigonometry_is_the_same_square(self):
        off = self.need("zb25-speed").ours("zb25-speed", "largest difference from the square by angles")
        self.assertEqual(len(off), 3)
        for case, difference in off.items():
            self.assertLess(difference, 1e-12, case)

    # Promise of replication.md: "The commands `reproduce/run NAME` make them again": each claim has its command
    def test_each_claim_of_the_page_on_replication_has_its_command(self):
        text = PAGE.read_text()
        # What no command shows stands in the last section, which says so.
        sections = re.split(r"^## ", text, flags=re.M)[1:]
        self.assertEqual(sections[-1].splitlines()[0], "Not shown here")
        for section in sections[:-1]:
            blocks = re.findall(r"```sh\n(.*?)```", section, re.S)
            self.assertTrue(blocks, section)
            for block in blocks:
                names = re.fullmatch(r"reproduce/run ([\w -]+)\n", block)
                if names:
                    for name in names.group(1).split():
                        self.assertIn(name, self.entries)  # some need an optional part
                    continue
                with tempfile.TemporaryDirectory() as folder:
                    done = run_in_shell(block, folder)
                self.assertEqual(done.returncode, 0, done.stderr)
                said = re.search(r"It prints `([^`]*)`", section).group(1)
                self.assertEqual(done.stdout.split(), said.split(), block)

    # Promise of reproduction.md: "A run that was interrupted goes on where it stopped, and makes the same tables"
    def test_a_killed_run_goes_on_and_makes_the_same(self):
        names = ["ablation-islands", "kd20-table-1", "sk23-table-2"]
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary) / "results"
            command = [sys.executable, RUN, "--small", "--into", folder, *names]
            process = subprocess.Popen(command, env={**os.environ, "JULIAVDB": str(PROGRAM)}, stderr=subprocess.PIPE, text=True,
                                       start_new_session=True)
            # Killed in the middle of the second entry, after its first command.
            for line in process.stderr:
                if "kd20-table-1: bunny, --alpha 40" in line:
                    os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            process.stderr.close()
            self.assertEqual(process.returncode, -signal.SIGKILL)
            self.assertEqual([path.name for path in folder.iterdir() if not path.name.startswith(".")], names[:1])
            first = (folder / names[0] / "result.json").read_bytes()
            done = subprocess.run(command, env={**os.environ, "JULIAVDB": str(PROGRAM)}, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(f"{names[0]}: has its result", done.stderr)
            self.assertIn("kd20-table-1: bunny, as found", done.stderr)
            self.assertEqual((folder / names[0] / "result.json").read_bytes(), first)
            self.assertEqual([path.name for path in folder.glob(".*") if path.is_dir()], [".meshes"])
            for name in names:
                self.assertEqual(Results(folder).untimed(name), self.results.untimed(name))


class TwoSizes(unittest.TestCase):
    def test_each_entry_keeps_the_size_at_which_it_ran(self):
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            page, data = folder / "page.md", folder / "data"
            into = ("--into", folder / "results")
            for options in (("--small", *into, "ablation-islands", "kim15-appendix"),
                            ("--medium", *into, "--page", page, "--data", data, "kim15-appendix")):
                done = reproduce(*options)
                self.assertEqual(done.returncode, 0, done.stderr)
            text = re.sub(r"\s+", " ", page.read_text())
            for size, name in (("small", "ablation-islands"), ("medium", "kim15-appendix")):
                self.assertRegex(text, rf"\*\*Run at the size {size}\*\* on [^*]*: `{name}`\.")
                self.assertRegex(text, rf"`reproduce/run {name}` took [\d.]+ CPU seconds at the size {size}\.")
            self.assertEqual({str(path.relative_to(data)) for path in data.rglob("*") if path.is_file()},
                             {"SHA256SUMS", "small/ablation-islands.csv", "medium/kim15-appendix.csv"})


class StoredResults(unittest.TestCase):
    """What docs/reproduction.md and reproduce/data hold of the last run."""

    # Promise: A page of results has "the commands ..."
    def test_the_page_has_every_entry_or_says_that_it_was_not_run(self):
        page = (ROOT / "docs/reproduction.md").read_text()
        not_run = re.search(r"^The entries without a result were not run: (.*?)\.$", page, re.M | re.S)
        left_out = set(re.findall(r"`([\w-]+)`", not_run.group(1))) if not_run else set()
        shown = set(re.findall(r"`reproduce/run ([\w-]+)` took", page))
        self.assertEqual((shown | left_out, shown & left_out), (set(entries()), set()))
        stored = {path.stem: path.parent.name for path in (ROOT / "reproduce/data").glob("*/*.csv")}
        self.assertEqual(stored, dict(re.findall(r"`reproduce/run ([\w-]+)` took [\d. ]+ CPU seconds at the size (\w+)\.", page)))

    # Promise: A page of results has "the commands ..."
    def test_the_page_and_the_data_have_the_same_numbers(self):
        page = (ROOT / "docs/reproduction.md").read_text()
        shown = {name: section for section in re.split(r"^### ", page, flags=re.M)[1:]
                 for name in re.findall(r"`reproduce/run ([\w-]+)` took", section)}
        for path in (ROOT / "reproduce/data").glob("*/*.csv"):
            with open(path) as file:
                for row in csv.DictReader(file):
                    case = "| " + row["case"].replace("|", r"\|") + " |"
                    line = next(line for line in shown[path.stem].splitlines() if line.startswith(case))
                    found = number(row["ours"])
                    if found is None:
                        continue
                    cells = [number(cell.strip(" |").replace(" ", "")) for cell in line.split(" | ")]
                    self.assertTrue(any(cell is not None and abs(cell - found) <= 5.1e-4 * abs(found) for cell in cells),
                                    (path.stem, row, line))

    def test_the_hashes_of_the_data(self):
        done = subprocess.run(["sha256sum", "--strict", "-c", "SHA256SUMS"], cwd=ROOT / "reproduce/data", capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        listed = {line.split()[1] for line in (ROOT / "reproduce/data/SHA256SUMS").read_text().splitlines()}
        files = {str(path.relative_to(ROOT / "reproduce/data")) for path in (ROOT / "reproduce/data").rglob("*") if path.is_file()}
        self.assertEqual(listed, files - {"README.md", "SHA256SUMS"})

    def test_the_substitutes_are_those_that_the_data_name(self):
        named = json.loads((ROOT / "reproduce/data/meshes.json").read_text())
        for command, words in (("reproduce/shapes tooth", "tooth"), ("reproduce/shapes frog", "frog"), ("reproduce/shapes hand", "hand"),
                               ("docs/make-shapes chair", "chair")):
            made = subprocess.run([sys.executable, ROOT / command.split()[0], command.split()[1]], check=True, capture_output=True).stdout
            self.assertIn(words, named.get(hashlib.sha256(made).hexdigest(), ""), command)


class Refusals(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_test_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    # Promise: A failed command is named ...
    def test_an_unknown_name(self):
        done = reproduce("--small", "--into", self.folder / "r", "kd20-dimension", "sk23-table-9")
        self.assertEqual(done.returncode, 2)
        self.assertIn("'sk23-table-9'", done.stderr.splitlines()[0])
        self.assertEqual([line.strip() for line in done.stderr.splitlines()[1:]], [*entries(), *ALONE])
        self.assertFalse((self.folder / "r").exists())

    # Promise: A failed command is named ...
    def test_a_missing_program(self):
        done = reproduce("--small", "--into", self.folder / "r", environment={"JULIAVDB": str(self.folder / "nothing")})
        self.assertEqual(done.returncode, 2)
        self.assertEqual(len(done.stderr.splitlines()), 1)
        self.assertIn(str(self.folder / "nothing"), done.stderr)
        self.assertFalse((self.folder / "r").exists())

    def test_another_program(self):
        done = reproduce("--small", "--into", self.folder / "r", environment={"JULIAVDB": "/bin/true"})
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, "^reproduce/run: .*true is not juliavdb: .*; set JULIAVDB to the path of juliavdb\n$")
        self.assertFalse((self.folder / "r").exists())

    def test_a_mesh_that_is_not_known(self):
        for word, mention in (("teapot=x.obj", "armadillo"), ("bunny", "NAME=FILE"), ("bunny=a b.obj", "holds a space")):
            done = reproduce("--small", "--into", self.folder / "r", "--mesh", word)
            self.assertEqual((done.returncode, len(done.stderr.splitlines())), (2, 1))
            self.assertIn(mention, done.stderr)

    # Promise of CONTRIBUTING.md#to-add-something: A failed command is named with what it said, and the other entries go on; an
    #   unknown entry or a missing program is refused
    def test_a_command_that_fails_and_one_that_does_not(self):
        broken = self.folder / "broken.obj"
        broken.write_text("v 0 0 0\nf 1 2 3\n")
        done = reproduce("--small", "--into", self.folder / "r", "--mesh", f"bunny={broken}", "ablation-islands", "kim15-appendix")
        self.assertEqual(done.returncode, 1)
        self.assertIn("ablation-islands: failed: the command of 'alpha 40' ended with code 65", done.stderr)
        self.assertIn("juliavdb fractal $bunny", done.stderr)
        self.assertIn(str(broken), done.stderr)
        self.assertEqual(done.stderr.splitlines()[-1], "reproduce/run: 1 of 2 entries failed: ablation-islands")
        self.assertEqual([path.name for path in (self.folder / "r").iterdir() if not path.name.startswith(".")], ["kim15-appendix"])

    # Promise: "A run that was interrupted ..."
    def test_a_mesh_that_has_changed_is_run_again(self):
        bunny, command = put_bunny(self.folder), ["--small", "--into", self.folder / "r", "ablation-proofs", "--mesh"]
        for change, said in (("", "proofs"), ("", "has its result"), ("# changed\n", "proofs")):
            bunny.write_text(bunny.read_text() + change)
            done = reproduce(*command, f"bunny={bunny}")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(said, done.stderr)
            self.assertEqual("has its result" in done.stderr, said == "has its result")

    # Promise: "A run that was interrupted ..."
    def test_two_runs_into_one_folder(self):
        command = [sys.executable, RUN, "--small", "--into", self.folder, "kd20-table-1"]
        environment = {**os.environ, "JULIAVDB": str(PROGRAM)}
        first = subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True, start_new_session=True)
        try:
            first.stderr.readline()
            done = subprocess.run(command, env=environment, capture_output=True, text=True)
            self.assertEqual(done.returncode, 2)
            self.assertIn("another run writes into", done.stderr)
            first.send_signal(signal.SIGTERM)
            said = first.communicate(timeout=60)[1]
            self.assertEqual(first.returncode, 75, said)
            self.assertEqual(said.splitlines()[-1], "reproduce/run: interrupted; run it again to go on")
            self.assertEqual([path.name for path in self.folder.iterdir() if not path.name.startswith(".")], [])
        finally:
            if first.poll() is None:
                os.killpg(first.pid, signal.SIGKILL)
                first.wait()


if __name__ == "__main__":
    unittest.main()

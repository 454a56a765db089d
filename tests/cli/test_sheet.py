# SPDX-License-Identifier: Apache-2.0
"""The command sheet: its cells against the commands that make them one by one, what it keeps, its refusals."""

import json
import signal
import subprocess
import time

import harness
from harness import BAD_DATA, CANNOT_CREATE, INTERNAL, INTERRUPTED, NO_INPUT, USAGE

LOW = ("--sdf-resolution", 20, "--resolution", 20)
SMALL = ("--size", "32x32", "--samples", 1)
VARY = ("--vary", "alpha=20,60", "--vary", "texture-seed=1,2")


class SheetTest(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(2)))

    def cells(self, name="x.cells"):
        return sorted(p.name for p in self.path(name).iterdir())

    def places(self, name, count, size=(32, 32)):
        """The pictures on the page: by their number, found by the margin's colour around them."""
        rows = harness.read_png(self.bytes(name))
        page = rows[0][0]
        found, taken = [], set()
        for y, row in enumerate(rows):
            for x, pixel in enumerate(row):
                if pixel == page or (x, y) in taken or len(found) == count:
                    continue
                box = [(x + i, y + j) for j in range(size[1]) for i in range(size[0])]
                if not all(b < len(rows) and a < len(row) for a, b in box):
                    continue
                edge = [rows[y + j][x] for j in range(size[1])]
                if page in edge:
                    continue  # a letter
                taken.update(box)
                found.append([rows[y + j][x:x + size[0]] for j in range(size[1])])
        return found


class Cells(SheetTest):

    # Promise: A run from the recipe in a VDB, PLY, OBJ ...
    # Promise of controls.md: A cell of a sheet is what `render` and `fractal` make of its recipe; its file holds "the complete
    #   recipe of every cell"
    def test_each_cell_is_what_render_and_fractal_make(self):
        text = self.ok("sheet", "s.obj", *LOW, *SMALL, *VARY, "-o", "x.png")
        self.assertIn("wrote x.png, x.json: 2 x 2 cells", text)
        sheet = json.loads(self.bytes("x.json"))
        self.assertEqual([cell["number"] for cell in sheet["cells"]], [1, 2, 3, 4])
        pictures = self.places("x.png", 4)
        self.assertEqual(len(pictures), 4)
        for number, (alpha, seed) in enumerate(((20, 1), (20, 2), (60, 1), (60, 2)), 1):
            with self.subTest(cell=number):
                options = (*LOW, "--alpha", alpha, "--texture-seed", seed)
                self.ok("render", "--field", "s.obj", *options, *SMALL, "--colour", "clay", "-o", "one.png")
                self.assertEqual(pictures[number - 1], harness.read_png(self.bytes("one.png")))
                self.ok("render", "--field", "--config", f"x.json#{number}", *SMALL, "--colour", "clay", "-o", "two.png")
                self.assertEqual(self.bytes("one.png"), self.bytes("two.png"))
        self.ok("fractal", "s.obj", *LOW, "--alpha", 60, "--texture-seed", 1, "-o", "written.vdb", "--mesh", "a.ply")
        self.ok("fractal", "--config", "x.json#3", "-o", "cell.vdb", "--mesh", "b.ply")
        self.assertEqual(self.bytes("written.vdb"), self.bytes("cell.vdb"))
        self.assertEqual(self.bytes("a.ply"), self.bytes("b.ply"))

    # Promise of controls.md: "`--eye` and `--look-at` together give all cells the same camera"
    def test_all_cells_have_the_camera_that_is_given(self):
        camera = ("--eye", "3,1,2", "--look-at", "0.5,0,0")
        vary = ("--vary", "origin-shift=0,0,0;0.2,0,0")
        self.ok("sheet", "s.obj", *LOW, *SMALL, *vary, *camera, "-o", "x.png")
        self.ok("sheet", "s.obj", *LOW, *SMALL, *vary, "-o", "framed.png")
        pictures, framed = self.places("x.png", 2), self.places("framed.png", 2)
        for number, picture in enumerate(pictures, 1):
            self.ok("render", "--field", "--config", f"x.json#{number}", *SMALL, *camera, "--colour", "clay", "-o", "one.png")
            self.assertEqual(picture, harness.read_png(self.bytes("one.png")))
            self.assertNotEqual(picture, framed[number - 1], "it frames its own set unless it is told otherwise")

    # Promise of pictures.md: "The JSON beside the sheet stores the view of each cell, and `render --field --config` uses it;
    #   options on the command line take precedence"
    def test_a_cell_shows_its_look_and_render_takes_it_from_there(self):
        """--config x.json#2 shows the cell, in its light and from its side; what is typed stands over that."""
        look = ("--light", "60,30", "--sky", 0.4, "--ground", "--background", "#203040", "--exposure", 0.5, "--azimuth", 70)
        self.ok("sheet", "s.obj", *LOW, *SMALL, *look, "--vary", "material=clay,bronze,#3060c0:glossy", "-o", "x.png")
        sheet, pictures = json.loads(self.bytes("x.json")), self.places("x.png", 3)
        self.assertEqual([cell["view"]["material"] for cell in sheet["cells"]], ["clay", "bronze", "#3060c0:glossy"])
        self.assertEqual(sheet["view"]["light"], "60,30")
        self.assertNotIn("material", sheet["view"])
        for number, (cell, picture) in enumerate(zip(sheet["cells"], pictures, strict=True), 1):
            self.ok("render", "--field", "s.obj", *LOW, *SMALL, *look, "--material", cell["view"]["material"], "-o", "one.png")
            self.assertEqual(picture, harness.read_png(self.bytes("one.png")))
            self.ok("render", "--field", "--config", f"x.json#{number}", *SMALL, "-o", "two.png")
            self.assertEqual(self.bytes("two.png"), self.bytes("one.png"))
        place = ("--eye", "3,1,2", "--material", "jade")
        self.ok("render", "--field", "--config", "x.json#2", *SMALL, *place, "-o", "typed.png")
        self.ok("render", "--field", "s.obj", *LOW, *SMALL, *look[:-2], *place, "-o", "same.png")
        self.assertEqual(self.bytes("typed.png"), self.bytes("same.png"))
        # A sheet goes on from a cell with its look, too.
        self.ok("sheet", "--config", "x.json#2", *SMALL, "--vary", "iterations=4", "-o", "y.png")
        self.ok("sheet", "s.obj", *LOW, *SMALL, *look, "--material", "bronze", "--vary", "iterations=4", "-o", "z.png")
        self.assertEqual(self.places("y.png", 1), self.places("z.png", 1))
        self.assertEqual(json.loads(self.bytes("y.json"))["cells"][0]["view"], sheet["cells"][1]["view"])
        # The recipe of a fractal is none of this.
        self.assertEqual(sheet["cells"][0]["recipe"], sheet["cells"][1]["recipe"])

    # Promise: "The JSON beside the sheet ..."
    def test_cells_differ_in_what_is_seen(self):
        """The camera varies as the light does, beside an option of the fractal or alone."""
        self.ok("sheet", "s.obj", *LOW, *SMALL, "--vary", "light=-48,41;60,20", "--vary", "texture-seed=1,2", "-o", "x.png")
        self.ok("sheet", "s.obj", *LOW, *SMALL, "--vary", "eye=3,1,2;0,3,1", "-o", "y.png")
        for name, count in (("x", 4), ("y", 2)):
            pictures = self.places(f"{name}.png", count)
            self.assertEqual(len({str(picture) for picture in pictures}), count)
            for number, picture in enumerate(pictures, 1):
                self.ok("render", "--field", "--config", f"{name}.json#{number}", *SMALL, "-o", "one.png")
                self.assertEqual(picture, harness.read_png(self.bytes("one.png")), (name, number))
        said = self.ok("sheet", "s.obj", *LOW, *SMALL, "--vary", "light=-48,41;60,20", "--vary", "texture-seed=1,2,3", "-o", "x.png")
        self.assertIn("4 of 6 cells kept", said)
        said = self.ok("sheet", "s.obj", *LOW, *SMALL, "--vary", "background=none,#203040", "-o", "x.png")
        self.assertRegex(said, r"(?m)^warning: cell 1 failed: .*--background is none")

    # Promise: "The JSON beside the sheet ..."
    def test_a_cell_with_a_broken_view_is_bad_data(self):
        self.ok("sheet", "s.obj", *LOW, *SMALL, "--vary", "material=clay", "-o", "x.png")
        self.write("y.json", self.bytes("x.json").replace(b'"material": "clay"', b'"material": "mud"'))
        self.refused(BAD_DATA, "render", "--field", "--config", "y.json#1", *SMALL, "-o", "y.png", mentions=("y.json#1", "mud"))

    # Promise: "What was made before changes ..."
    def test_a_cell_does_not_depend_on_its_company(self):
        self.write("m.obj", harness.obj(harness.snowman()))
        # A narrow band, which each depth of detail wants wider by another amount.
        self.ok("sdf", "m.obj", "-o", "m.vdb", "--resolution", 40)
        low = ("--resolution", 20, "--texture", "scales")
        alone = {}
        for detail in ("0.1", "0.3", "0.5"):
            self.ok("sheet", "m.vdb", *low, *SMALL, "--vary", f"detail={detail}", "-o", "one.png")
            alone[detail] = self.places("one.png", 1)[0]
        for company in (("0.1", "0.3", "0.5"), ("0.5", "0.1", "0.3")):
            self.ok("sheet", "m.vdb", *low, *SMALL, "--vary", "detail=" + ",".join(company), "-o", "x.png")
            self.assertTrue(self.places("x.png", 3) == [alone[detail] for detail in company], company)

    # Promise: "Options on the command line ..."
    def test_the_recipe_of_a_fractal_and_of_a_cell_go_on(self):
        self.ok("fractal", "s.obj", *LOW, "--alpha", 20, "--texture-seed", 1, "-o", "f.vdb")
        self.ok("sheet", "s.obj", *LOW, *SMALL, "--alpha", 20, "--vary", "texture-seed=1,2", "-o", "a.png")
        self.ok("sheet", "f.vdb", *SMALL, "--vary", "texture-seed=1,2", "-o", "b.png")
        self.ok("sheet", "--config", "a.json#1", *SMALL, "--vary", "texture-seed=1,2", "-o", "c.png")
        self.assertEqual(self.bytes("a.png"), self.bytes("b.png"))
        self.assertEqual(self.bytes("a.png"), self.bytes("c.png"))
        self.ok("sheet", "--config", "a.json#1", *SMALL, "--vary", "alpha=20,30", "-o", "d.png")
        self.assertEqual(json.loads(self.bytes("d.json"))["cells"][1]["recipe"]["alpha"], "30")

    # Promise: A cell of a sheet is what ...
    def test_files_as_values(self):
        for name, roots in (("a.json", harness.ROOTS), ("b.json", harness.ROOTS[:2])):
            self.write(name, harness.rational_json(roots))
        self.ok("sheet", "s.obj", *LOW, *SMALL, "--vary", "texture=a.json,b.json", "-o", "x.png")
        cells = json.loads(self.bytes("x.json"))["cells"]
        self.assertEqual([cell["recipe"]["texture"] for cell in cells], ["a.json", "b.json"])
        self.assertEqual(len({cell["recipe"]["texture-sha256"] for cell in cells}), 2)
        self.write("b.json", harness.rational_json(harness.ROOTS[1:]))
        self.refused(BAD_DATA, "fractal", "--config", "x.json#2", "-o", "f.vdb", mentions="b.json")
        said = self.ok("sheet", "s.obj", *LOW, *SMALL, "--vary", "texture=a.json,b.json", "-o", "x.png")
        self.assertIn("1 of 2 cells kept", said)

    # Promise: A cell of a sheet is what ...
    def test_targets_as_values(self):
        self.write("t.obj", harness.obj(harness.torus()))
        self.ok("sheet", *LOW, *SMALL, "--vary", "input=s.obj,t.obj", "--vary", "alpha=20,40", "-o", "x.png")
        self.assertEqual([cell["recipe"]["input"] for cell in json.loads(self.bytes("x.json"))["cells"]],
                         ["s.obj", "s.obj", "t.obj", "t.obj"])

    # Promise: A range of values goes "from A to B ..."
    def test_values_with_commas(self):
        self.ok("sheet", "--map", "quadratic", "--iterations", 5, *SMALL, "--vary",
                "c=-0.2,0.6,0.2,0.2;-1,0.2,0,0", "-o", "x.png")
        self.assertEqual([cell["varied"] for cell in json.loads(self.bytes("x.json"))["cells"]],
                         [{"c": "-0.2,0.6,0.2,0.2"}, {"c": "-1,0.2,0,0"}])

    # Promise: "The same recipe gives the same ..."
    def test_same_bytes(self):
        results = set()
        for number, options in enumerate((("--threads", 1), ("--threads", 2), ("--instructions", "portable"))):
            name = f"x{number}.png"
            self.ok("sheet", "s.obj", *LOW, *SMALL, *VARY, *options, "-o", name)
            results.add((self.bytes(name), self.bytes(f"x{number}.json")))
        self.assertEqual(len(results), 1)

    # Promise of controls.md: "It fails itself only if all cells fail"
    def test_a_failed_cell_shows_its_error(self):
        said = self.ok("sheet", "s.obj", *LOW, *SMALL, "--vary", "alpha=20,-3,word", "-o", "x.png")
        self.assertRegex(said, r"(?m)^warning: cell 2 failed: .*-3")
        self.assertRegex(said, r"(?m)^warning: cell 3 failed: .*'word'")
        cells = json.loads(self.bytes("x.json"))["cells"]
        self.assertNotIn("error", cells[0])
        self.assertIn("word", cells[2]["error"])
        self.assertEqual(len(self.cells()), 1)
        self.refused(BAD_DATA, "fractal", "--config", "x.json#3", "-o", "f.vdb", mentions="word")


class Meshes(SheetTest):
    """--preview mesh: what is chosen is what is made."""

    def cells_are_what_render_shows(self, count, sheet, view=()):
        self.ok("sheet", *sheet, *SMALL, *view, "--preview", "mesh", "-o", "x.png")
        pictures = self.places("x.png", count)
        self.assertEqual(len(pictures), count)
        for number, picture in enumerate(pictures, 1):
            with self.subTest(sheet=sheet, view=view, cell=number):
                self.ok("fractal", "--config", f"x.json#{number}", "--mesh", "x.ply")
                self.ok("render", "x.ply", *SMALL, *view, "-o", "one.png")
                self.assertEqual(picture, harness.read_png(self.bytes("one.png")))
        return pictures

    # Promise of controls.md: `sheet --preview mesh`: "Each cell is then the picture that `juliavdb render` makes of the mesh",
    #   pixel for pixel
    def test_each_cell_is_the_picture_of_its_mesh(self):
        self.write("t.obj", harness.obj(harness.torus()))
        framed = self.cells_are_what_render_shows(4, ("s.obj", *LOW, *VARY))
        self.assertNotEqual(framed[0], framed[2])
        turned = self.cells_are_what_render_shows(2, ("s.obj", *LOW[:2], "--vary", "resolution=12,24"),
                                                  ("--azimuth", 40, "--elevation", 50, "--zoom", 0.8, "--fov", 50, "--up", "z"))
        self.assertNotEqual(*turned)
        box = ("--box", "-0.4,-0.5,-0.3,0.7,0.8,0.9")
        self.write("up.txt", "target-up = y\nup = auto\n")
        for more in (("--target-up", "z"), ("--config", "up.txt"), (*box, "--cap"), box, ("--adaptivity", 0.5, "--largest", 1),
                     ("--attributes", "trap,Cd", "--follow", "--seed-stride", 2)):
            self.cells_are_what_render_shows(2, ("--vary", "input=s.obj,t.obj", *LOW, *more))
        self.cells_are_what_render_shows(2, ("--map", "mandelbulb", "--resolution", 20, "--vary", "power=3,8"))

    # Promise: "The JSON beside the sheet ..."
    def test_meshes_have_the_look_of_a_picture(self):
        look = ("--light", "60,30", "--sky", 0.4, "--ground", "--background", "#203040", "--exposure", 0.5, "--material", "bronze")
        lit = self.cells_are_what_render_shows(2, ("s.obj", *LOW, "--vary", "texture-seed=1,2"), look)
        self.ok("sheet", "s.obj", *LOW, *SMALL, "--preview", "mesh", "--texture-seed", 1, "--vary", "material=clay,bronze",
                *look[:-2], "-o", "x.png")
        varied = self.places("x.png", 2)
        self.assertEqual(varied[1], lit[0])
        self.assertNotEqual(varied[0], lit[0])

    # Promise: `sheet --preview mesh`: "Each ..."
    def test_the_points_have_the_colours_of_the_recipe(self):
        clay, trap, direction = self.cells_are_what_render_shows(
            3, ("s.obj", *LOW, "--vary", "colour=clay,trap:magma,direction"))
        self.assertTrue(clay != trap != direction)
        def gaudiest(rows):
            return max(max(p) - min(p) for row in rows for p in row)
        self.assertLess(gaudiest(clay), gaudiest(direction))

    def test_the_field_is_another_picture_and_another_cell(self):
        run = ("sheet", "s.obj", *LOW, *SMALL, "--vary", "alpha=20,60", "-o", "x.png")
        self.ok(*run)
        field = self.bytes("x.png"), self.bytes("x.json")
        self.assertIn("2 of 2 cells kept", self.ok(*run, "--preview", "field"))
        self.assertEqual((self.bytes("x.png"), self.bytes("x.json")), field)
        self.assertIn("0 of 2 cells kept", self.ok(*run, "--preview", "mesh"))
        self.assertNotEqual(self.bytes("x.png"), field[0])
        self.assertEqual(json.loads(self.bytes("x.json"))["view"]["preview"], "mesh")
        self.assertIn("2 of 2 cells kept", self.ok(*run, "--preview", "mesh"))

    def test_the_number_of_auto_is_recorded(self):
        self.ok("sheet", "s.obj", "--sdf-resolution", 20, "--resolution", "auto", "--box", "0.9,-0.1,-0.1,1.1,0.1,0.1", *SMALL, "--preview",
                "mesh", "--vary", "texture=scales", "-o", "x.png")
        self.assertRegex(json.loads(self.bytes("x.json"))["cells"][0]["recipe"]["resolution"], r"\A\d+\Z")

    # Promise: "The same recipe gives the same ..."
    def test_same_bytes(self):
        results = set()
        for number, options in enumerate((("--threads", 1), ("--threads", 2), ("--instructions", "portable"))):
            name = f"x{number}.png"
            self.ok("sheet", "s.obj", *LOW, *SMALL, "--vary", "colour=trap,depth", "--preview", "mesh", *options, "-o", name)
            results.add((self.bytes(name), self.bytes(f"x{number}.json")))
        self.assertEqual(len(results), 1)

    def test_what_only_the_field_has_is_refused(self):
        run = ("sheet", "s.obj", *LOW, "--vary", "alpha=20,60", "--preview", "mesh", "-o", "x.png")
        for option in (("--eye", "3,1,2"), ("--look-at", "0,0,0"), ("--epsilon", 0.1), ("--alpha-clarity", 0.1), ("--delta", 2),
                       ("--no-skip", )):
            self.refused(USAGE, *run, *option, mentions=(option[0], "has no effect", "--preview"))
        self.refused(USAGE, *run, "--up", "1,0,0", mentions=("--up", "--preview field"))
        self.refused(USAGE, *run[:-4], "--preview", "meshes", "-o", "x.png", mentions=("--preview", "'meshes'", "field", "mesh"))
        self.assertEqual(self.listing(), ["s.obj"])

    def test_a_mesh_that_memory_does_not_hold_is_refused_at_once(self):
        self.refused(INTERNAL, "sheet", "s.obj", "--sdf-resolution", 20, "--resolution", 20000, "--preview", "mesh", *SMALL,
                     "--memory", "2G", "--vary", "alpha=20,60", "-o", "x.png", mentions=("memory", "--resolution"))


class FinerThanVoxels(SheetTest):
    """A cell of the field says what of it the voxels of its recipe do not show."""

    # Promise of controls.md: A cell of a sheet says if much of what it shows is finer than two voxels
    def test_it_says_what_fractal_warns_of(self):
        vary = ("--vary", "resolution=16,400", "--texture", "random", "--texture-seed", 3)
        said = self.ok("sheet", "s.obj", "--sdf-resolution", 40, *SMALL, *vary, "-o", "x.png")
        coarse, fine = json.loads(self.bytes("x.json"))["cells"]
        self.assertRegex(coarse["finer"], r"\A\d.* % of the texture is finer than two voxels; ")
        self.assertNotIn("finer", fine)
        self.assertIn(f"warning: 1 cell shows more than voxels will; cell 1: {coarse['finer']}; ", said)
        self.assertIn(f"warning: {coarse['finer']}\n", self.ok("fractal", "--config", "x.json#1", "-o", "f.vdb"))
        # A line of the caption, also when the cells are kept; the pictures are those of the set in any case.
        page = harness.read_png(self.bytes("x.png"))
        pictures = self.places("x.png", 2)
        again = self.ok("sheet", "s.obj", "--sdf-resolution", 40, *SMALL, *vary, "-o", "x.png")
        self.assertIn("2 of 2 cells kept", again)
        self.assertIn(coarse["finer"], again)
        self.assertEqual(harness.read_png(self.bytes("x.png")), page)
        self.ok("sheet", "s.obj", "--sdf-resolution", 40, *SMALL, *vary[2:], "--vary", "resolution=400,401", "-o", "y.png")
        self.assertLess(len(harness.read_png(self.bytes("y.png"))), len(page))
        self.assertEqual(self.places("y.png", 1), pictures[1:])

    def test_a_mesh_shows_its_voxels_and_says_nothing(self):
        said = self.ok("sheet", "s.obj", *LOW, *SMALL, "--vary", "texture=scales", "--preview", "mesh", "-o", "x.png")
        self.assertNotIn("warning", said)
        self.assertNotIn("finer", json.loads(self.bytes("x.json"))["cells"][0])


class Layout(SheetTest):

    # Promise: A sheet's page is never a strip
    def test_many_columns_are_folded_and_the_cells_stay_in_order(self):
        """Two values by seven: rows of four, three, four and three cells instead of a strip."""
        vary = ("--vary", "alpha=20,60", "--vary", "texture-seed=1:7:1")
        said = self.ok("sheet", "s.obj", *LOW, *SMALL, *vary, "-o", "x.png")
        self.assertIn("4 x 4 cells", said)
        pictures = self.places("x.png", 14)
        self.assertEqual(len(pictures), 14)
        for number in (1, 4, 5, 7, 8, 14):
            self.ok("render", "--field", "--config", f"x.json#{number}", *SMALL, "--colour", "clay", "-o", "one.png")
            self.assertEqual(pictures[number - 1], harness.read_png(self.bytes("one.png")), number)

    def test_a_page_beyond_memory_is_refused_before_the_work(self):
        self.refused(INTERNAL, "sheet", "s.obj", *LOW, "--vary", "texture-seed=1:100:1", "--size", "3000x3000", "--memory", "1G",
                     "-o", "x.png", mentions=("a page of", "--size"))
        self.assertEqual(self.listing(), ["s.obj"])


class Resuming(SheetTest):

    # Promise of controls.md: "Nothing is made twice", and the program "never removes anything from the folder"
    def test_only_new_cells_are_made(self):
        self.assertIn("0 of 2 cells kept", self.ok("sheet", "s.obj", *LOW, *SMALL, "--vary", "alpha=20,40", "-o", "x.png"))
        page, recipes, cells = self.bytes("x.png"), self.bytes("x.json"), self.cells()
        self.assertIn("2 of 2 cells kept", self.ok("sheet", "s.obj", *LOW, *SMALL, "--vary", "alpha=20,40", "-o", "x.png"))
        self.assertEqual((page, recipes, cells), (self.bytes("x.png"), self.bytes("x.json"), self.cells()))
        said = self.ok("sheet", "s.obj", *LOW, *SMALL, "--vary", "alpha=20:40:10", "-o", "x.png")
        self.assertIn("2 of 3 cells kept", said)
        self.assertEqual(len(self.cells()), 3)
        # Nothing is ever removed, neither what no cell needs any more nor what is none.
        self.write("x.cells/notes.txt", "mine")
        before = set(self.cells())
        self.ok("sheet", "s.obj", *LOW, *SMALL, "--vary", "alpha=25,35", "-o", "x.png")
        self.assertEqual(len(set(self.cells()) - before), 2)
        self.assertLess(before, set(self.cells()))

    # Promise: "Nothing is made twice", and the program ...
    def test_an_interruption_keeps_what_is_finished(self):
        words = ["sheet", "s.obj", "--sdf-resolution", 20, "--size", "200x200", "--samples", 4, "--vary",
                 "texture-seed=1:40:1", "-o", "x.png"]
        process = subprocess.Popen([harness.program(), *map(str, words), "--progress", "none"], cwd=self.folder,
                                   env=harness.environment(), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, preexec_fn=harness.restore_interrupt)
        end = time.monotonic() + harness.TIMEOUT
        while not list(self.folder.glob("x.cells/*.png")) and time.monotonic() < end:
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        stdout, stderr = process.communicate(timeout=harness.TIMEOUT)
        self.assertEqual(process.returncode, INTERRUPTED, stderr.decode())
        self.assertEqual(stdout, b"")
        self.assertRegex(stderr.decode(), r"\Ajuliavdb: interrupted; [^\n]*\n\Z")
        self.assertEqual([name for name in self.listing() if "/" not in name], ["s.obj", "x.cells"])
        kept = self.cells()
        self.assertTrue(0 < len(kept) < 40, kept)
        for name in kept:
            self.assertRegex(name, r"\A[0-9a-f]{32}\.png\Z")
            harness.read_png(self.bytes("x.cells/" + name))
        first = [*words]
        first[first.index("texture-seed=1:40:1")] = "texture-seed=1,2"
        self.assertRegex(self.ok(*first), r"[12] of 2 cells kept")


class Refusals(SheetTest):

    def test_usage(self):
        base = ("sheet", "s.obj", *LOW, *SMALL)
        cases = [(*base, *words, "-o", "x.png") for words in (
            (), ("--vary", "alpha"), ("--vary", "alpha="), ("--vary", "=3"), ("--vary", "alhpa=1,2"), ("--vary", ""),
            ("--vary", "alpha=1,,2"), ("--vary", "alpha=1:2:0"), ("--vary", "alpha=1:2:-1"), ("--vary", "alpha=1:1000:1"),
            ("--vary", "alpha=1:21:1", "--vary", "texture-seed=1:20:1"), ("--vary", "alpha=20", "--vary", "alpha=30"),
            ("--vary", "alpha=20", "--vary", "beta=0", "--vary", "texture-seed=1"), ("--vary", "alpha=20,30", "--alpha", 5),
            ("--vary", "input=s.obj"), ("--vary", "alpha=20,30", "--columns", 0),
            ("--vary", "alpha=20,30", "--vary", "texture-seed=1,2", "--columns", 2),
            ("--vary", "alpha=20,30", "--colour", "pink"), ("--vary", "alpha=20,30", "--background", "none"),
            ("--vary", "alpha=20,30", "--material", "mud"), ("--vary", "material=mud"), ("--vary", "size=20x20,30x30"),
            ("--vary", "material=clay,bone", "--material", "clay"), ("--vary", "preview=mesh,field"), ("--vary", "samples=1,4"),
            ("--vary", "alpha=20,30", "--light", "20,-10", "--ground"), ("--vary", "alpha=20,30", "--eye", "1,1,1", "--zoom", 2),
            ("--vary", "alpha=-1,-2"), ("--vary", "sdf-voxel-size=0.1,0.2"), ("--vary", "map=one,two"))]
        cases += [(*base, "--vary", "alpha=20,30"), (*base, "--vary", "alpha=20,30", "-o", "x.jpg"),
                  (*base, "--vary", "alpha=20,30", "-o", "x.exr"), (*base, "--vary", "alpha=20,30", "-o", "/dev/null"),
                  ("sheet", "--vary", "alpha=20,30", "-o", "x.png"),
                  ("sheet", "s.obj", "--vary", "texture-seed=1:400:1", "--columns", 400, "-o", "x.png")]
        self.all_refused(USAGE, cases)

    def test_input_and_output(self):
        vary = ("--vary", "alpha=20,30")
        self.refused(NO_INPUT, "sheet", "missing.obj", *vary, "-o", "x.png", mentions="missing.obj")
        self.write("broken.obj", "v 1 2\nf 1 2 3\n")
        self.refused(BAD_DATA, "sheet", "broken.obj", *vary, "-o", "x.png", mentions="broken.obj")
        self.refused(CANNOT_CREATE, "sheet", "s.obj", *vary, "-o", "nowhere/x.png", mentions="nowhere")
        self.write("swirl.json", harness.rational_json(harness.ROOTS))
        self.refused(CANNOT_CREATE, "sheet", "s.obj", *vary, "-o", "swirl.png", mentions="swirl.json")
        self.write("x.cells", "in the way")
        self.refused(CANNOT_CREATE, "sheet", "s.obj", *LOW, *vary, "-o", "x.png", mentions="x.cells")

    def test_configurations(self):
        self.ok("sheet", "s.obj", *LOW, *SMALL, "--vary", "alpha=20,40", "-o", "x.png")
        for name in ("x.json", "x.json#", "x.json#0", "x.json#3", "x.json#one"):
            self.refused(USAGE, "fractal", "--config", name, "-o", "f.vdb", mentions="1 to 2")
        self.refused(USAGE, "sdf", "--config", "x.json#1", "-o", "f.vdb", mentions="juliavdb fractal")
        self.refused(NO_INPUT, "fractal", "--config", "y.json#1", "-o", "f.vdb", mentions="y.json")
        self.write("y.json", "{}")
        self.refused(BAD_DATA, "fractal", "--config", "y.json#1", "-o", "f.vdb", mentions="y.json")


if __name__ == "__main__":
    harness.main()

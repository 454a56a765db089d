# SPDX-License-Identifier: Apache-2.0
# Promise of design.md: A file that has moved is found "beside the one that holds the recipe, or below a folder that `--search`
#   names", by its SHA-256 alone, and "a line says where"
"""Recipes whose files are somewhere else than they were."""

import shutil

import harness

SMALL = ("--resolution", 20, "--sdf-resolution", 24)


class MovedFiles(harness.CliTest):
    def setUp(self):
        super().setUp()
        for folder in ("made", "away/deep", "work"):
            self.path(folder).mkdir(parents=True)
        self.write("made/lumpy.obj", harness.obj(harness.lumpy()))
        self.inside("made", "versor", "new", "--seed", 3, "-o", "v.json")
        self.inside("made", "fractal", "lumpy.obj", "--texture", "v.json", "-o", "f.vdb", "--mesh", "f.ply", *SMALL)

    def inside(self, folder, *words):
        """Runs in a folder below that of the test."""
        outer = self.folder
        self.folder = outer / folder
        try:
            return self.ok(*harness.quiet(words))
        finally:
            self.folder = outer

    def inside_refused(self, folder, code, *words, **options):
        outer = self.folder
        self.folder = outer / folder
        try:
            return self.refused(code, *words, **options)
        finally:
            self.folder = outer

    def move(self, source, target):
        self.path(source).rename(self.path(target))

    def test_files_beside_the_one_with_the_recipe_are_found(self):
        said = self.inside("work", "mesh", "../made/f.vdb", "-o", "f.ply")
        self.assertIn("note: 'lumpy.obj'", said)
        self.assertIn("note: 'v.json'", said)
        self.assertEqual(self.bytes("work/f.ply"), self.bytes("made/f.ply"))
        self.inside("work", "fractal", "--config", "../made/f.ply", "-o", "f.vdb")
        self.assertEqual(self.bytes("work/f.vdb"), self.bytes("made/f.vdb"))
        for command in (("slice", "../made/f.vdb", "-o", "s.png", "--size", 20),
                        ("render", "--field", "../made/f.vdb", "-o", "r.png", "--size", "20x20")):
            self.inside("work", *command)

    def test_where_the_recipe_says_nothing_is_noted(self):
        self.assertNotIn("note:", self.inside("made", "mesh", "f.vdb", "-o", "again.ply"))

    def test_a_file_of_that_name_counts_only_by_its_hash(self):
        shutil.copy(self.path("made/lumpy.obj"), self.path("away/deep/renamed.obj"))
        shutil.copy(self.path("made/v.json"), self.path("work/v.json"))
        self.write("made/lumpy.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        self.inside_refused("work", harness.NO_INPUT, "mesh", "../made/f.vdb", "-o", "m.ply",
                            mentions=("lumpy.obj", "SHA-256", "--search", "--input", "--from-grid"))
        said = self.inside("work", "mesh", "../made/f.vdb", "-o", "m.ply", "--search", ".", "--search", "../away")
        self.assertIn("renamed.obj", said)
        self.assertEqual(self.bytes("work/m.ply"), self.bytes("made/f.ply"))
        self.inside_refused("made", harness.BAD_DATA, "mesh", "f.vdb", "-o", "m.ply", mentions=("has changed",))

    def test_input_gives_the_target(self):
        self.move("made/lumpy.obj", "away/other.obj")
        said = self.inside("work", "mesh", "../made/f.vdb", "-o", "m.ply", "--input", "../away/other.obj")
        self.assertNotIn("warning", said)
        self.assertEqual(self.bytes("work/m.ply"), self.bytes("made/f.ply"))
        with open(self.path("away/other.obj"), "a") as target:
            target.write("# changed\n")
        said = self.inside("work", "mesh", "../made/f.vdb", "-o", "m.ply", "--input", "../away/other.obj")
        self.assertIn("warning: '../away/other.obj' is not the target", said)
        self.assertIn(b"julia_input ../away/other.obj", self.bytes("work/m.ply"))
        self.inside_refused("work", harness.USAGE, "mesh", "../made/f.vdb", "-o", "m.ply", "--from-grid", "--input",
                            "../away/other.obj", mentions=("--input",))

    def test_a_search_in_what_is_no_folder_is_refused(self):
        self.inside_refused("work", harness.USAGE, "mesh", "../made/f.vdb", "-o", "m.ply", "--search", "nowhere",
                            mentions=("--search", "nowhere"))


if __name__ == "__main__":
    harness.main()

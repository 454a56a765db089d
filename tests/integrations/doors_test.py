# SPDX-License-Identifier: Apache-2.0
"""A fractal is the same by every door: the program, the page of `explore`, the Python module, the add-on for Blender and the
shelf of Houdini have the program's defaults."""

import importlib
import inspect
import json
import os
import pathlib
import re
import shutil
import sys
import types
import unittest
import unittest.mock
import zipfile

import numpy   # noqa: F401  The add-on imports it too, and it must not be loaded again with each stand-in.

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/explore"))
from server import Server, harness   # noqa: E402

try:
    import juliavdb
except ImportError as error:
    print(f"skipped: {error}")
    juliavdb = None

ADDON = "juliavdb_addon"
# A fractal at its defaults takes long.
SMALL = {"resolution": "24", "sdf-resolution": "24"}
SMALL_WORDS = [word for name, value in SMALL.items() for word in (f"--{name}", value)]
# What a recipe says of its target.
OF_THE_TARGET = {"input", "input_sha256", "source_sha256"}


def blender_settings(folder):
    """The modules `settings` and `defaults` of the add-on in a folder, with stand-ins for those of Blender. A property is the
    words that it is declared with."""
    bpy = unittest.mock.MagicMock()
    bpy.types.PropertyGroup = bpy.types.AddonPreferences = object
    for kind in ("Bool", "Enum", "Float", "Int", "Pointer", "String"):
        setattr(bpy.props, f"{kind}Property", lambda **words: words)
    package = types.ModuleType(ADDON)
    package.__path__ = [str(folder / ADDON)]
    names = {"bpy": bpy, "bpy.props": bpy.props, "bpy.utils": bpy.utils, "bpy.utils.previews": bpy.utils.previews, ADDON: package}
    for name in [name for name in sys.modules if name.startswith(f"{ADDON}.")]:
        del sys.modules[name]
    with unittest.mock.patch.dict(sys.modules, names):
        settings, defaults = (importlib.import_module(f"{ADDON}.{name}") for name in ("settings", "defaults"))
    settings.program = lambda _: harness.program()
    return settings, defaults


class Doors(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.lumpy()))

    def described(self, command):
        groups = json.loads(self.ok(command, "--describe", "json", data=True))["groups"]
        return {option["name"]: option for group in groups for option in group["options"]}

    def recipe_options(self):
        return {name: {key: value for key, value in option.items() if key != "recipe"}
                for name, option in self.described("fractal").items() if option.get("recipe")}

    def made(self, *words):
        """Points, triangles and the recipe of a mesh by the program."""
        self.ok("fractal", "s.obj", "--mesh", "made.ply", *words)
        data = self.bytes("made.ply")
        mesh = harness.read_ply(data)
        recipe = {name[6:]: value for name, value in mesh.comments.items() if name.startswith("julia_")}
        return data.partition(b"end_header\n")[2], {name: value for name, value in recipe.items() if name not in OF_THE_TARGET}

    def test_the_program_records_the_defaults_that_it_describes(self):
        options = {name.replace("-", "_"): option for name, option in self.recipe_options().items()}
        _, recipe = self.made(*SMALL_WORDS)
        checked = [name for name in recipe if name in options and options[name]["name"] not in SMALL]
        for name in checked:
            self.assertEqual(recipe[name], options[name]["default"], name)
        self.assertLessEqual({"detail", "outward", "texture", "frequency", "iterations", "tolerance"}, set(checked))
        # Larger than what this test can make.
        self.assertEqual(self.recipe_options()["resolution"]["default"], "300")

    def test_the_page_of_explore(self):
        page = Server(self.folder, "s.obj", *SMALL_WORDS)
        self.addCleanup(page.kill)
        start = page.get("start")[1]
        options = self.recipe_options()
        shown = {option["name"]: {key: value for key, value in option.items() if key != "group"} for option in start["options"]}
        self.assertEqual({name: option for name, option in shown.items() if name != "input"}, options)
        pictures = self.described("render")
        for look in start["looks"]:
            self.assertEqual(look["default"], pictures[look["name"]].get("default", ""), look["name"])

    @unittest.skipUnless(juliavdb, "the Python module was not built")
    def test_the_python_module(self):
        data, recipe = self.made(*SMALL_WORDS)
        fractal = juliavdb.fractal(str(self.path("s.obj")), **{name.replace("-", "_"): value for name, value in SMALL.items()})
        theirs = {name.replace("-", "_"): value for name, value in fractal.info["recipe"].items()}
        self.assertEqual({name: value for name, value in theirs.items() if name not in OF_THE_TARGET},
                         {name: value for name, value in recipe.items() if name in theirs})
        fractal.write(self.path("theirs.ply"))
        self.assertEqual(self.bytes("theirs.ply").partition(b"end_header\n")[2], data)
        told = re.sub(r"\s+", " ", inspect.getdoc(juliavdb.fractal))
        for option in self.recipe_options().values():
            self.assertIn(re.sub(r"\s+", " ", option["help"]), told, option["name"])

    def check_blender(self, folder):
        settings, defaults = blender_settings(folder)
        options = self.described("fractal")
        self.assertEqual(defaults.OPTIONS, options)
        at_first = types.SimpleNamespace(**{name: words.get("default", "")
                                            for name, words in settings.Settings.__annotations__.items()})
        data, recipe = self.made(*SMALL_WORDS)
        # Random roots have settings that other textures do not need.
        for texture in (at_first.versor, "random"):
            with self.subTest(texture=texture):
                at_first.versor = texture
                words = settings.words(at_first)
                self.assertIn(f"--resolution={options['resolution']['default']}", words)
                small = [word for word in words if not word.startswith("--resolution=")]
                plain = [] if texture == options["texture"]["default"] else ["--texture", texture]
                self.assertEqual(self.made(*SMALL_WORDS, *small)[0], self.made(*SMALL_WORDS, *plain)[0])

    # Promise of blender.md: "At first every setting has the default of `juliavdb fractal`, so both make the same fractal"
    def test_blender_from_its_sources(self):
        with unittest.mock.patch.dict(os.environ, {"JULIAVDB": harness.program()}):
            self.check_blender(ROOT / "integrations/blender")

    # Promise: "At first every setting has the default ..."
    @unittest.skipUnless("JULIAVDB_BUILD" in os.environ, "JULIAVDB_BUILD does not say where the archive is")
    def test_blender_from_its_archive(self):
        with zipfile.ZipFile(pathlib.Path(os.environ["JULIAVDB_BUILD"], "integrations/blender", f"{ADDON}.zip")) as archive:
            archive.extractall(self.folder)
        self.assertTrue(self.path(f"{ADDON}/fractal.json").exists())
        with unittest.mock.patch.dict(os.environ, {"JULIAVDB": "no program is asked"}):
            settings, _ = blender_settings(self.folder)
        self.assertTrue(settings.Settings.__annotations__)
        self.check_blender(self.folder)

    # Promise of houdini.md: Options of `juliavdb fractal`, "whose defaults hold if you leave the field empty"
    def test_houdini(self):
        shutil.copy(ROOT / "integrations/houdini/juliavdb_shelf.py", self.folder)
        shutil.copy(ROOT / f"integrations/blender/{ADDON}/program.py", self.path("juliavdb_program.py"))
        with unittest.mock.patch.object(sys, "path", [str(self.folder), *sys.path]):
            shelf = importlib.import_module("juliavdb_shelf")
        # Nothing but the files is said, so the program's defaults hold.
        self.assertEqual(inspect.signature(shelf.make).parameters["options"].default, "")
        self.assertEqual(shelf.words_for("s.obj", "made.ply", ""), ["fractal", "s.obj", "--mesh", "made.ply"])
        hou = unittest.mock.MagicMock()
        node = unittest.mock.MagicMock()
        node.type().category().name.return_value = "Sop"
        hou.selectedNodes.return_value = [node]
        hou.ui.readMultiInput.return_value = 2, ("",)
        shelf.clicked(hou)
        self.assertEqual(hou.ui.readMultiInput.call_args.kwargs["initial_contents"], ("",))


if __name__ == "__main__":
    harness.main()

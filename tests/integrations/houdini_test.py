# SPDX-License-Identifier: Apache-2.0
"""The shelf tool for Houdini as far as plain Python goes: with the true program, and a stand-in for Houdini."""

import os
import pathlib
import shutil
import sys
import tempfile
import types
import unittest
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/cli"))
import harness   # noqa: E402

FAST = "--resolution 24 --sdf-resolution 24"


class Interrupted(Exception):
    """hou.OperationInterrupted"""


class Node:
    """A SOP that remembers what is done to it."""

    def __init__(self, network, kind, name):
        self.network, self.kind, self._name, self.parms, self.inputs, self.flags = network, kind, name, {}, {}, set()

    name = lambda self: self._name   # noqa: E731
    parent = lambda self: self.network   # noqa: E731
    geometry = lambda self: self   # noqa: E731

    def saveToFile(self, path):
        pathlib.Path(path).write_text(harness.obj(harness.lumpy()))

    def parm(self, name):
        return types.SimpleNamespace(set=lambda value: self.parms.update({name: value}))

    def setInput(self, index, node):
        self.inputs[index] = node

    def setDisplayFlag(self, on):
        self.flags.add("display")

    def setRenderFlag(self, on):
        self.flags.add("render")

    def type(self):
        return types.SimpleNamespace(category=lambda: types.SimpleNamespace(name=lambda: "Sop"))


class Network:
    def __init__(self):
        self.nodes = []

    def createNode(self, kind, name):
        self.nodes.append(Node(self, kind, name))
        return self.nodes[-1]

    def layoutChildren(self, items):
        assert set(items) <= set(self.nodes)


class Houdini:
    """As much of the module hou as is used."""

    OperationInterrupted = Interrupted
    severityType = types.SimpleNamespace(Error="error")

    def __init__(self, folder, stop_at=None):
        self.shares, self.messages, self.stop_at = [], [], stop_at
        self.text = types.SimpleNamespace(expandString=lambda text: text.replace("$HIP", str(folder)))
        self.frame = lambda: 7.0
        outer = self

        class InterruptableOperation:
            def __init__(self, name, open_interrupt_dialog):
                pass
            __enter__ = lambda self: self   # noqa: E731
            __exit__ = lambda self, *_: None   # noqa: E731

            def updateProgress(self, share):
                outer.shares.append(share)
                if outer.stop_at is not None and len(outer.shares) > outer.stop_at:
                    raise Interrupted

        self.InterruptableOperation = InterruptableOperation
        self.ui = types.SimpleNamespace(displayMessage=lambda text, **_: self.messages.append(text))


class Shelf(unittest.TestCase):

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_test_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        libs = self.folder / "libs"
        libs.mkdir()
        shutil.copy(ROOT / "integrations/houdini/juliavdb_shelf.py", libs)
        shutil.copy(ROOT / "integrations/blender/juliavdb_addon/program.py", libs / "juliavdb_program.py")
        sys.path.insert(0, str(libs))
        self.addCleanup(sys.path.remove, str(libs))
        for name in ("juliavdb_shelf", "juliavdb_program"):
            sys.modules.pop(name, None)
        import juliavdb_shelf
        self.shelf = juliavdb_shelf
        self.network = Network()
        self.node = Node(self.network, "box", "box1")
        self.hou = Houdini(self.folder)

    def files(self):
        return sorted(path.name for path in (self.folder / "juliavdb").glob("*"))

    def make(self, kind="volume", options=FAST):
        return self.shelf.make(self.hou, self.node, kind, options, program=harness.program())

    # Promise of houdini.md#a-button-that-makes-a-fractal: The shelf tool runs the program, shows progress, stops it, and loads
    #   the result
    def test_a_volume_is_made_and_loaded(self):
        shown = self.make()
        self.assertEqual(self.files(), ["box1.0007.source.obj", "box1.0007.vdb"])
        file, = self.network.nodes
        self.assertEqual((shown, file.kind, file.flags), (file, "file", {"display", "render"}))
        self.assertEqual(pathlib.Path(file.parms["file"]), self.folder / "juliavdb/box1.0007.vdb")
        import pyopenvdb
        self.assertEqual(sorted(grid.name for grid in pyopenvdb.readAllGridMetadata(file.parms["file"])), ["density", "surface"])
        self.assertEqual(self.hou.shares, sorted(self.hou.shares))

    def test_a_mesh_gets_normals(self):
        shown = self.make("mesh")
        file, normals = self.network.nodes
        self.assertEqual((file.kind, normals.kind, normals.inputs, shown), ("file", "normal", {0: file}, normals))
        self.assertGreater(len(harness.read_ply(pathlib.Path(file.parms["file"]).read_bytes())[1]), 100)

    # Promise: The shelf tool runs the program, shows ...
    def test_escape_stops_the_program(self):
        self.hou.stop_at = 2
        with self.assertRaisesRegex(self.shelf.programs.ProgramError, "Cancelled"):
            self.make(options="--resolution 2000 --sdf-resolution 400")
        self.assertEqual(self.files(), ["box1.0007.source.obj"])
        self.assertEqual(self.network.nodes, [])

    # Promise: The shelf tool runs the program, shows ...
    def test_errors_are_one_line(self):
        for options in ("--detail 7", "--no-such 3", "-o else.vdb", "--mesh=else.ply", "--detail"):
            with self.assertRaises(self.shelf.programs.ProgramError) as caught:
                self.make(options=f"{FAST} {options}")
            self.assertEqual(len(str(caught.exception).splitlines()), 1)
        self.assertEqual(self.network.nodes, [])

    def test_the_button(self):
        asked = []
        self.hou.selectedNodes = lambda: []
        self.shelf.clicked(self.hou)
        self.assertIn("Select one", self.hou.messages[0])
        self.hou.selectedNodes = lambda: [self.node]
        self.hou.ui.readMultiInput = lambda *words, **_: asked.append(words) or (2, ("",))
        self.shelf.clicked(self.hou)
        self.assertEqual((len(asked), self.network.nodes), (1, []))
        self.hou.ui.readMultiInput = lambda *words, **_: (1, ("--detail 7",))
        os.environ["PATH"] = f"{os.path.dirname(harness.program())}:{os.environ['PATH']}"
        self.shelf.clicked(self.hou)
        self.assertIn("--detail", self.hou.messages[-1])

    def test_the_shelf_is_xml_that_calls_it(self):
        shelf = xml.etree.ElementTree.parse(ROOT / "integrations/houdini/juliavdb.shelf").getroot()
        tool, = shelf.findall("tool")
        self.assertEqual(tool.get("name"), shelf.find("toolshelf/memberTool").get("name"))
        script = tool.find("script").text
        compile(script, "shelf", "exec")
        self.assertIn("juliavdb_shelf.clicked(hou)", script)


if __name__ == "__main__":
    harness.main()

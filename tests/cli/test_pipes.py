# SPDX-License-Identifier: Apache-2.0
"""Pipes and recipes: meshes from the standard input and to the standard output, and recipes as files of their own."""

import base64
import json
import os
import struct
import subprocess

import harness
from harness import BAD_DATA, DONE, IO_ERROR, NO_INPUT, USAGE

LOW = ("--resolution", 24, "--sdf-resolution", 24)


def gltf(mesh):
    points, faces = mesh
    data = b"".join(struct.pack("<3f", *point) for point in points) + b"".join(struct.pack("<3I", *face) for face in faces)
    split = 12 * len(points)
    return json.dumps({
        "asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5125, "count": 3 * len(faces), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": split},
                        {"buffer": 0, "byteOffset": split, "byteLength": len(data) - split}],
        "buffers": [{"byteLength": len(data),
                     "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}]})


class PipeTest(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.mesh = harness.lumpy()
        self.write("b.obj", harness.obj(self.mesh))
        self.write("b.ply", harness.ply_text(self.mesh))

    def fed(self, name, *words, stdout=subprocess.PIPE):
        """Runs with a pipe that a file goes into."""
        return subprocess.run([harness.program(), *map(str, words)], cwd=self.folder, env=harness.environment(),
                              input=self.bytes(name), stdout=stdout, stderr=subprocess.PIPE, timeout=harness.TIMEOUT)

    def piped(self, name, *words):
        run = self.fed(name, *words)
        self.assertEqual(run.returncode, DONE, run.stderr)
        return run.stdout

    def surface(self, mesh):
        points, triangles, *_ = mesh
        return [[points[corner] for corner in triangle] for triangle in triangles]


class Inputs(PipeTest):

    def write_all_formats(self):
        """@return names of the mesh in all formats that can be piped"""
        self.write("b.stl", harness.stl(self.mesh))
        self.write("b.off", "# a comment\n\n" + harness.off(self.mesh))
        self.write("text.stl", " Solid of a test\n" + "".join(
            "facet\nouter loop\n" + "".join(f"vertex {x!r} {y!r} {z!r}\n" for x, y, z in triangle) + "endloop\nendfacet\n"
            for triangle in self.surface((*self.mesh, None))) + "endsolid\n")
        self.write("b.gltf", gltf(self.mesh))
        self.ok("fractal", "b.obj", "--mesh", "b.glb", *LOW)
        names = ["b.obj", "b.ply", "b.stl", "text.stl", "b.off", "b.gltf", "b.glb"]
        if b"libzip" not in self.run_program("print", "b.obj", "-o", "b.3mf", "--size", 50, "--resolution", 24).stderr:
            if b"libexpat" not in self.run_program("info", "b.3mf").stderr:
                names.append("b.3mf")
        return names

    # Promise of usage.md: A mesh of any format from a pipe is as good as one from a file, and the recipe finds it again; "A pipe
    #   brings no second file"
    def test_a_pipe_is_as_good_as_a_file(self):
        for name in self.write_all_formats():
            with self.subTest(name=name):
                told = json.loads(self.piped(name, "info", "-", "--json"))
                known = json.loads(self.ok("info", name, "--json", data=True))
                self.assertEqual(told.pop("file"), "-")
                known.pop("file")
                self.assertEqual(told, known)
                if name not in ("b.obj", "b.glb"):
                    continue
                self.piped(name, "fractal", "-", "--mesh", "piped.ply", "-o", "piped.vdb", *LOW)
                self.ok("fractal", name, "--mesh", "named.ply", "-o", "named.vdb", *LOW)
                self.assertEqual(*(self.surface(harness.read_ply(self.bytes(each))) for each in ("piped.ply", "named.ply")))

    # Promise: A mesh of any format from a pipe ...
    def test_a_pipe_brings_no_other_files(self):
        content = json.loads(gltf(self.mesh))
        buffer, = content["buffers"]
        self.write("b.bin", base64.b64decode(buffer["uri"].split(",")[1]))
        buffer["uri"] = "b.bin"
        self.write("two.gltf", json.dumps(content))
        self.ok("info", "two.gltf", data=True)
        self.check_refusal(self.fed("two.gltf", "info", "-"), BAD_DATA, "info - < two.gltf")

    def test_an_ordinary_file_is_one_from_its_beginning(self):
        with open(self.path("b.obj"), "rb") as source:
            run = subprocess.run([harness.program(), "info", "-", "--json"], cwd=self.folder, stdin=source,
                                 env=harness.environment(), capture_output=True)
        self.assertEqual(json.loads(run.stdout)["triangles"], len(self.mesh[1]))

    def test_other_commands_that_read_meshes(self):
        self.piped("b.ply", "sdf", "-", "-o", "s.vdb", "--resolution", 24)
        self.piped("b.obj", "points", "-", "-o", "p.ply", "--points", 20)
        self.piped("b.obj", "print", "-", "-o", "p.stl", "--size", 50, "--resolution", 24)
        self.piped("b.ply", "render", "-", "-o", "p.png", "--size", "16x16")
        self.assertGreaterEqual(set(self.listing()), {"s.vdb", "p.ply", "p.stl", "p.png"})

    def test_a_sequence_of_one_target(self):
        keys = ("--frames", "1-2", "--key", "detail@1=0.1", "--key", "detail@2=0.3")
        self.piped("b.ply", "fractal", "-", "--mesh", "p.####.ply", *keys, *LOW)
        self.ok("fractal", "b.ply", "--mesh", "n.####.ply", *keys, *LOW)
        for frame in (1, 2):
            self.assertEqual(*(self.surface(harness.read_ply(self.bytes(f"{name}.{frame:04}.ply"))) for name in "pn"))

    def test_what_is_refused(self):
        self.write("empty", b"")
        self.write("text", b"this is no mesh\n")
        self.write("cut", self.bytes("b.ply")[:-200])
        for name, code in (("empty", BAD_DATA), ("text", BAD_DATA), ("cut", BAD_DATA)):
            before = self.listing()
            run = self.fed(name, "fractal", "-", "-o", "f.vdb", *LOW)
            self.check_refusal(run, code, f"fractal - < {name}")
            self.assertEqual(self.listing(), before)
        for words in (("plan", "tiles", "-", "-o", "plan"), ("sheet", "-", "--vary", "alpha=1,2", "-o", "s.png"),
                      ("mesh", "-", "-o", "m.ply"), ("status", "-")):
            self.refused(USAGE, *words, mentions="standard input")
        closed = subprocess.run([harness.program(), "info", "-"], cwd=self.folder, env=harness.environment(),
                                preexec_fn=lambda: os.close(0), capture_output=True)
        self.check_refusal(closed, NO_INPUT, "info - <&-")

    # Promise: A mesh of any format from a pipe ...
    def test_a_recipe_says_that_its_target_was_piped(self):
        self.piped("b.ply", "fractal", "-", "-o", "f.vdb", *LOW)
        self.refused(NO_INPUT, "fractal", "--config", "f.vdb", "-o", "g.vdb", mentions=("pipe", "--search"))
        self.ok("fractal", "--config", "f.vdb", "--search", ".", "--mesh", "g.ply")
        self.ok("fractal", "b.ply", "--config", "f.vdb", "--mesh", "h.ply")
        self.assertEqual(*(self.surface(harness.read_ply(self.bytes(each))) for each in ("g.ply", "h.ply")))
        self.piped("b.ply", "fractal", "-", "--config", "f.vdb", "--mesh", "i.ply")
        self.assertEqual(*(self.surface(harness.read_ply(self.bytes(each))) for each in ("g.ply", "i.ply")))


class Outputs(PipeTest):

    # Promise of usage.md: "Nothing else goes there"
    def test_the_standard_output_gets_the_bytes_of_the_file(self):
        for name, file in (("-", "f.ply"), ("-.ply", "f.ply"), ("-.obj", "f.obj")):
            self.ok("fractal", "b.obj", "--mesh", file, *LOW)
            self.assertEqual(self.run_program("fractal", "b.obj", "--mesh", name, *LOW).stdout, self.bytes(file), name)
        self.ok("fractal", "b.obj", "-o", "f.vdb", *LOW)
        for words in (("mesh", "f.vdb"), ("points", "f.vdb", "--points", 30), ("print", "b.obj", "--size", 50, "--resolution", 24)):
            self.ok(*words, "-o", "out.ply")
            self.assertEqual(self.run_program(*words, "-o", "-").stdout, self.bytes("out.ply"), words)
        self.assertNotIn("-", self.listing())
        self.assertNotIn("-.obj", self.listing())

    # Promise: "Nothing else goes there"
    def test_programs_in_a_row(self):
        """The mesh of one is the target of the next, and no file stands between them."""
        first = subprocess.Popen([harness.program(), "fractal", "b.obj", "--mesh", "-", *map(str, LOW)], cwd=self.folder,
                                 env=harness.environment(), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                 stderr=subprocess.DEVNULL)
        with first.stdout:
            second = subprocess.run([harness.program(), "info", "-", "--json"], stdin=first.stdout, capture_output=True,
                                    cwd=self.folder, env=harness.environment())
        self.assertEqual((first.wait(), second.returncode), (DONE, DONE))
        self.ok("fractal", "b.obj", "--mesh", "f.ply", *LOW)
        said = json.loads(second.stdout)
        self.assertEqual(said["triangles"], len(harness.read_ply(self.bytes("f.ply"))[1]))
        self.assertEqual(said["recipe"]["command"], "fractal")

    # Promise: "Nothing else goes there"
    def test_it_is_written_behind_what_stands_there(self):
        self.ok("fractal", "b.obj", "--mesh", "f.ply", *LOW)
        with open(self.path("log"), "wb") as log:
            log.write(b"before\n")
            log.flush()
            run = self.run_program("fractal", "b.obj", "--mesh", "-", *LOW, stdout=log)
        self.assertEqual(run.returncode, DONE, run.stderr)
        self.assertEqual(self.bytes("log"), b"before\n" + self.bytes("f.ply"))

    # Promise of usage.md: "an earlier failure leaves it empty"; "one line and exit code 74, and writes none of its other files"
    def test_a_failure_writes_nothing(self):
        self.refused(BAD_DATA, "fractal", "b.obj", "--mesh", "-", "--box", "8,8,8,9,9,9", *LOW)
        for words in (("-o", "-"), ("--mesh", "-", "-o", "-")):
            self.refused(USAGE, "fractal", "b.obj", *words, *LOW, mentions="standard output")
        self.refused(USAGE, "sdf", "b.obj", "-o", "-", mentions="standard output")
        self.refused(USAGE, "fractal", "b.obj", "--mesh", "-", "--frames", "1-2", "--key", "detail@1=0.1", "--key",
                     "detail@2=0.3", *LOW, mentions="--mesh")
        with open(self.path("b.obj"), "ab") as target:
            run = self.run_program("fractal", "b.obj", "--mesh", "-", *LOW, stdout=target)
        self.check_refusal(run, USAGE, "fractal b.obj --mesh - >> b.obj")

    # Promise: "an earlier failure leaves ..."
    def test_a_reader_that_is_gone(self):
        """One line, the code of a failed write, and no other output of the command."""
        reader, writer = os.pipe()
        os.close(reader)
        words = harness.quiet(("fractal", "b.obj", "--mesh", "-", *LOW))
        try:
            run = self.run_program(*words, "-o", "f.vdb", stdout=writer)
        finally:
            os.close(writer)
        self.check_refusal(run, IO_ERROR, "fractal --mesh - | nobody")
        self.assertEqual(self.listing(), ["b.obj", "b.ply"])
        with open("/dev/full", "wb") as full:
            run = self.run_program(*words, stdout=full)
        self.check_refusal(run, IO_ERROR, "fractal --mesh - > /dev/full")


class Recipes(PipeTest):

    def recipe(self, name, to="r.json"):
        self.ok("recipe", name, "-o", to)
        self.assertEqual(self.ok("recipe", name, data=True), self.bytes(to).decode())
        return json.loads(self.bytes(to))

    # Promise of usage.md: "`--recipe R.json` makes the same again"
    def test_a_file_and_its_recipe_make_the_same(self):
        """Of each kind of file that holds a recipe, by both names of the option."""
        self.write("p.png", b"")
        self.ok("fractal", "b.obj", "-o", "f.vdb", "--mesh", "f.ply", "--texture-seed", 5, "--detail", "x:0.1:0.3", *LOW)
        for kind in ("obj", "glb"):
            self.ok("fractal", "--config", "f.vdb", "--mesh", f"f.{kind}")
        self.ok("sheet", "b.obj", "--config", "f.vdb", "--vary", "iterations=4,5", "-o", "t.png", "--size", "16x16")
        for name in ("f.vdb", "f.ply", "f.obj", "f.glb", "t.json#2"):
            recipe = self.recipe(name)
            self.assertEqual((recipe["juliavdb"], recipe["command"]), ("recipe", "fractal"))
            self.ok("fractal", "--recipe", "r.json", "-o", "one.vdb")
            self.ok("fractal", "--config", name, "-o", "two.vdb")
            self.assertEqual(self.bytes("one.vdb"), self.bytes("two.vdb"), name)
        told = self.info("f.vdb")["recipe"]
        self.assertEqual({"command": "fractal", **self.recipe("f.vdb")["recipe"]}, told)
        self.assertEqual(self.info("r.json")["recipe"], told)
        self.assertEqual(self.recipe("r.json", "again.json")["recipe"], self.recipe("f.vdb")["recipe"])

    # Promise: "`--recipe R.json` makes the same again"
    def test_distances_have_recipes_too(self):
        self.ok("sdf", "b.obj", "-o", "s.vdb", "--resolution", 24)
        self.assertEqual(self.recipe("s.vdb")["command"], "sdf")
        self.ok("sdf", "--recipe", "r.json", "-o", "again.vdb")
        self.assertEqual(self.bytes("again.vdb"), self.bytes("s.vdb"))
        self.refused(USAGE, "fractal", "--recipe", "r.json", "-o", "f.vdb", mentions="sdf")

    def test_the_command_line_comes_first(self):
        self.ok("fractal", "b.obj", "-o", "f.vdb", *LOW)
        recipe = self.recipe("f.vdb")
        self.ok("fractal", "--recipe", "r.json", "--iterations", 4, "-o", "four.vdb")
        recipe["recipe"]["iterations"] = "4"
        self.write("edited.json", json.dumps(recipe))
        self.ok("fractal", "--recipe", "edited.json", "-o", "edited.vdb")
        self.assertEqual(self.bytes("four.vdb"), self.bytes("edited.vdb"))

    def test_a_look_is_a_recipe_without_a_target(self):
        """The mesh is that of the command line: a text of options, and a recipe whose input is deleted, do the same to it."""
        self.write("t.obj", harness.obj(harness.torus()))
        words = ("--texture", "scales", "--detail", 0.5, *LOW)
        self.ok("fractal", "t.obj", *words, "-o", "typed.vdb")
        self.write("look.txt", "# scales\n" + "".join(f"{name[2:]} = {value}\n" for name, value in zip(words[::2], words[1::2])))
        self.ok("fractal", "t.obj", "--config", "look.txt", "-o", "text.vdb")
        self.assertEqual(self.bytes("text.vdb"), self.bytes("typed.vdb"))
        self.ok("fractal", "b.obj", *words, "-o", "f.vdb")
        recipe = self.recipe("f.vdb")
        del recipe["recipe"]["input"]
        self.write("look.json", json.dumps(recipe))
        self.ok("fractal", "t.obj", "--recipe", "look.json", "-o", "recipe.vdb")
        self.assertEqual(self.bytes("recipe.vdb"), self.bytes("typed.vdb"))
        for name in ("look.txt", "look.json"):
            self.ok("render", "--field", "t.obj", "--config", name, "-o", f"{name}.png", "--size", "16x16")
            self.refused(USAGE, "fractal", "--config", name, "-o", "x.vdb", mentions="no target")
        self.assertEqual(self.bytes("look.txt.png"), self.bytes("look.json.png"))
        self.refused(USAGE, "mesh", "look.json", "-o", "x.ply")

    def test_what_holds_no_recipe(self):
        self.write("r.json", harness.rational_json(harness.ROOTS))
        self.refused(BAD_DATA, "recipe", "b.obj", mentions="no recipe")
        self.refused(NO_INPUT, "recipe", "nothing.vdb")
        self.refused(BAD_DATA, "recipe", "r.json")
        self.refused(USAGE, "recipe")
        self.ok("fractal", "b.obj", "-o", "f.vdb", *LOW)
        self.refused(USAGE, "recipe", "f.vdb", "-o", "b.obj")
        self.refused(USAGE, "recipe", "f.vdb", "-o", "r.txt", mentions=".json")

    # Promise of usage.md: "every option must exist, and its value must be a text"
    def test_damaged_recipes(self):
        self.ok("fractal", "b.obj", "-o", "f.vdb", *LOW)
        good = self.recipe("f.vdb")
        entries = good["recipe"]
        bad = {
            "version": {**good, "version": 2}, "command": {**good, "command": "fit"}, "none": {**good, "recipe": []},
            "unknown": {**good, "recipe": {**entries, "detial": "0.2"}}, "number": {**good, "recipe": {**entries, "iterations": 5}},
            "value": {**good, "recipe": {**entries, "iterations": "many"}},
            "twice": {**good, "recipe": {**entries, "versor-seed": "1", "texture-seed": "2"}},
        }
        for name, content in bad.items():
            self.write(f"{name}.json", json.dumps(content))
        text = self.bytes("r.json")
        self.write("cut.json", text[:len(text) // 2])
        self.write("deep.json", "[" * 100000)
        for name in (*bad, "cut", "deep"):
            with self.subTest(name=name):
                self.refused(BAD_DATA, "fractal", "--recipe", f"{name}.json", "-o", "g.vdb")
                self.refused(BAD_DATA, "recipe", f"{name}.json")
        self.assertIn("detail", self.refused(BAD_DATA, "fractal", "--recipe", "unknown.json", "-o", "g.vdb"))


if __name__ == "__main__":
    harness.main()

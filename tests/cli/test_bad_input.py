# SPDX-License-Identifier: Apache-2.0
# Promise of SECURITY.md: Of files from other people: "All that they can do is fail: exit code 65, one line on stderr, no output"
"""Bad input and bad options: the exit code, one line on stderr, no file left."""

import json
import os
import resource
import signal
import struct
import subprocess
import unittest

import pyopenvdb

import harness
from harness import BAD_DATA, CANNOT_CREATE, IO_ERROR, NO_INPUT, USAGE

LOW = ("--resolution", 24, "--sdf-resolution", 24)


class Meshes(harness.CliTest):
    ENCODERS = {"obj": harness.obj, "ply": harness.ply, "stl": harness.stl, "off": harness.off}

    def both_refuse(self, code, name, **options):
        self.refused(code, "sdf", name, "-o", "x.vdb", "--resolution", 24, **options)
        self.refused(code, "fractal", name, "-o", "x.vdb", "--mesh", "x.ply", *LOW, **options)

    # Promise of design.md#4-the-command-line: A file that is not there, or is a folder, ends in 66
    def test_missing(self):
        names = [f"nowhere.{extension}" for extension in (*self.ENCODERS, "vdb")]
        self.all_refused(NO_INPUT, [("fractal", name, "-o", "x.vdb") for name in names], mentions="nowhere")
        self.all_refused(NO_INPUT, [("info", name) for name in names], mentions="nowhere")
        self.refused(NO_INPUT, "sdf", "nowhere.obj", "-o", "x.vdb", mentions="nowhere.obj")

    # Promise: A file that is not there, or is a folder, ends in 66
    def test_a_folder(self):
        self.path("folder.obj").mkdir()
        self.path("folder.vdb").mkdir()
        self.both_refuse(NO_INPUT, "folder.obj", mentions="folder.obj")
        self.refused(NO_INPUT, "fractal", "folder.vdb", "-o", "x.vdb", mentions="folder.vdb")
        # Where a recipe or a part of a file is looked for, too.
        cases = []
        for extension in ("vdb", "ply", "obj", "glb"):
            name = f"folder.{extension}"
            self.path(name).mkdir(exist_ok=True)
            cases += [("fractal", "--config", name, "-o", "x.vdb"), ("points", name, "-o", "x.ply", "--points", 9),
                      ("print", name, "-o", "x.stl", "--size", 9), ("render", name, "-o", "x.png"),
                      ("mesh", name, "-o", "x.ply")]
        self.all_refused(NO_INPUT, cases, mentions="folder.")

    # Promise of reliability.md: "A file that is broken, or made to do harm, ends in exit code 65 with one line on stderr and no
    #   output"
    def test_empty(self):
        names = [f"empty.{extension}" for extension in (*self.ENCODERS, "vdb", "json", "p4d", "poly4d", "o3d")]
        for name in names:
            self.write(name, b"")
        self.all_refused(BAD_DATA, [("info", name) for name in names], mentions="empty")
        self.both_refuse(BAD_DATA, "empty.obj", mentions="empty.obj")
        self.refused(BAD_DATA, "fractal", "empty.vdb", "-o", "x.vdb", mentions="empty.vdb")

    # Promise: "A file that is broken, or made ..."
    def test_not_what_its_name_says(self):
        names = [f"noise.{extension}" for extension in (*self.ENCODERS, "vdb", "json", "p4d", "o3d", "txt")]
        for name in names:
            self.write(name, bytes(range(256)) * 20)
        self.all_refused(BAD_DATA, [("info", name) for name in names], mentions="noise")

    # Promise: "A file that is broken, or made ..."
    def test_truncated(self):
        mesh, cases = harness.sphere(2), []
        for extension, encode in self.ENCODERS.items():
            data = encode(mesh)
            data = data.encode() if isinstance(data, str) else data
            for share in (0.02, 0.3, 0.6, 0.9):
                name = self.write(f"cut_{share}.{extension}", data[:int(share * len(data))])
                cases.append(("sdf", name, "-o", "x.vdb", "--resolution", 32))
        self.all_refused(BAD_DATA, cases)

    # Promise: "A file that is broken, or made ..."
    def test_not_finite(self):
        (points, faces), cases = harness.sphere(1), []
        for value in (float("nan"), float("inf"), -float("inf")):
            mesh = [(value, *points[0][1:])] + points[1:], faces
            for extension, encode in self.ENCODERS.items():
                name = self.write(f"bad_{value}.{extension}", encode(mesh))
                cases.append(("sdf", name, "-o", "x.vdb", "--resolution", 24))
        cases.append(("fractal", "bad_nan.obj", "-o", "x.vdb", *LOW))
        self.all_refused(BAD_DATA, cases, mentions="bad_")

    # Promise of targets.md: Points whose coordinates are not finite "are left out if no face uses them, and the program says how
    #   many there were"
    def test_not_finite_and_not_used(self):
        """Such points are left out, and said."""
        points, faces = harness.sphere(2)
        self.write("clean.obj", harness.obj((points, faces)))
        self.write("lost.obj", "v nan 0 0\n" * 3 + harness.obj((points, [tuple(i + 3 for i in face) for face in faces])))
        line = "3 points of the target are left out"
        for words in (("sdf", "{}.obj", "-o", "{}.vdb", "--resolution", 24), ("fractal", "{}.obj", "--mesh", "{}.ply", *LOW)):
            lost, clean = (self.ok(*(str(word).format(name) for word in words)) for name in ("lost", "clean"))
            self.assertEqual(lost.count(line), 1, lost)
            self.assertNotIn("left out", clean)
        one, other = (harness.read_ply(self.bytes(f"{name}.ply")) for name in ("lost", "clean"))
        self.assertEqual((one[0], one[1]), (other[0], other[1]))
        self.assertEqual(self.info("lost.obj")["points left out, not finite"], 3)
        self.assertNotIn("points left out, not finite", self.info("clean.obj"))
        cloud = "".join("v {} {} {}\n".format(*point) for point in points)
        self.write("cloud.obj", "v nan nan nan\n" + cloud)
        self.assertIn("1 point of the target is left out",
                      self.ok("fractal", "cloud.obj", "--points-radius", 0.5, "-o", "cloud.vdb", *LOW))
        self.assertEqual(self.info("cloud.obj")["points"], len(points))

    def test_absurd_coordinates(self):
        """Of which no resolution makes voxels that a grid can have: the mesh is to blame."""
        points, faces = harness.sphere(1)
        for scale in (1e36, 1e-15):
            mesh = [tuple(scale * x for x in p) for p in points], faces
            name = self.write(f"scaled_{scale}.stl", harness.stl(mesh))
            self.both_refuse(BAD_DATA, name, mentions="voxel size would be")
            # A voxel size of one's own is another matter.
            self.refused(USAGE, "sdf", name, "-o", "x.vdb", "--voxel-size", 1e-13, mentions="voxel size")

    def test_no_triangles(self):
        points, _ = harness.sphere(1)
        for extension, encode in self.ENCODERS.items():
            with self.subTest(extension=extension):
                self.both_refuse(BAD_DATA, self.write(f"points.{extension}", encode((points, []))),
                                 mentions=f"points.{extension}")

    def test_flat_mesh(self):
        name = self.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n")
        self.refused(BAD_DATA, "sdf", name, "-o", "x.vdb", "--resolution", 24)
        self.write("between.obj", "v 0 0 .31\nv 1 0 .31\nv 1 1 .31\nv 0 1 .31\nf 1 2 3\nf 1 3 4\n")
        self.refused(BAD_DATA, "sdf", "between.obj", "-o", "x.vdb", "--resolution", 24)
        self.write("point.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n")
        self.refused(BAD_DATA, "sdf", "point.obj", "-o", "x.vdb", "--resolution", 24)

    # Promise: "A file that is broken, or made ..."
    def test_counts_that_lie(self):
        mesh = harness.sphere(2)
        points, faces = len(mesh[0]), len(mesh[1])
        lies = {
            "vertices.ply": harness.ply(mesh, vertices=points + 1), "many.ply": harness.ply(mesh, vertices=4000000000),
            "faces.ply": harness.ply(mesh, count=faces + 1), "lots.ply": harness.ply(mesh, count=2**40),
            "minus.ply": harness.ply(mesh, count=-1), "one.stl": harness.stl(mesh, faces + 1),
            "most.stl": harness.stl(mesh, 2**32 - 1),
            "v.off": harness.off(mesh).replace(f"{points} {faces} 0", f"{points + 1} {faces} 0"),
            "f.off": harness.off(mesh).replace(f"{points} {faces} 0", f"{points} {faces + 1} 0"),
            "huge.off": harness.off(mesh).replace(f"{points} {faces} 0", f"99999999999 {faces} 0"),
            "index.obj": harness.obj(mesh) + f"f 1 2 {points + 1}\n", "zero.obj": harness.obj(mesh) + "f 0 1 2\n",
            "index.off": harness.off(mesh).replace("\n3 0 ", f"\n3 {points} ", 1),
            "corner.ply": harness.ply_text(mesh).replace("\n3 0 ", f"\n3 {points} ", 1),
        }
        for name, content in lies.items():
            self.write(name, content)
        self.all_refused(BAD_DATA, [("sdf", name, "-o", "x.vdb", "--resolution", 24) for name in lies])

    # Promise: A mesh that bounds no volume ...
    def test_leaky(self):
        self.write("leaky.obj", harness.obj(harness.with_hole(harness.sphere(3), 0.94)))
        self.both_refuse(BAD_DATA, "leaky.obj", mentions="--repair")
        self.assertIn("repaired", self.ok("sdf", "leaky.obj", "-o", "s.vdb", "--resolution", 24, "--repair"))
        self.ok("fractal", "leaky.obj", "-o", "f.vdb", "--mesh", "f.ply", *LOW, "--repair")
        self.assertEqual(harness.open_edges(harness.read_ply(self.bytes("f.ply"))), [])
        self.assertEqual(self.info("s.vdb")["recipe"]["repair"], "true")


class Vdbs(harness.CliTest):

    def sphere_grid(self):
        return pyopenvdb.createLevelSetSphere(radius=1.0, voxelSize=0.1, halfWidth=3.0)

    def save(self, name, grids):
        pyopenvdb.write(str(self.path(name)), grids=grids)
        return name

    def all_refuse(self, name, **options):
        for command in (("fractal", name, "-o", "x.vdb", "--resolution", 24), ("mesh", name, "-o", "x.ply"),
                        ("render", name, "-o", "x.png", "--size", "16x16")):
            with self.subTest(command=command):
                self.refused(BAD_DATA, *command, **options)

    def test_no_float_grid(self):
        mask = pyopenvdb.BoolGrid()
        mask.name = "mask"
        mask.fill((0, 0, 0), (3, 3, 3), True)
        self.all_refuse(self.save("mask.vdb", mask), mentions=["mask.vdb", "'mask' (bool)"])

    def test_no_grid_of_that_name(self):
        name = self.save("ball.vdb", self.sphere_grid())
        for command in (("fractal", name, "-o", "x.vdb"), ("mesh", name, "-o", "x.ply"),
                        ("render", name, "-o", "x.png"), ("slice", name, "-o", "x.png", "--field", "grid")):
            self.refused(BAD_DATA, *command, "--grid", "density", mentions="density")

    def test_two_grids_to_choose_from(self):
        one, two = self.sphere_grid(), self.sphere_grid()
        one.name, two.name = "one", "two"
        self.all_refuse(self.save("two.vdb", [one, two]), mentions=["one", "two"])
        self.ok("mesh", "two.vdb", "-o", "x.ply", "--grid", "two")

    # Promise: "A file that is broken, or made ..."
    def test_not_finite(self):
        for value in (float("nan"), float("inf")):
            grid = self.sphere_grid()
            grid.getAccessor().setValueOn((10, 0, 0), value)
            self.all_refuse(self.save("nan.vdb", grid), mentions="finite")

    def test_broken_boxes(self):
        self.write("s.obj", harness.obj(harness.sphere(2)))
        self.ok("sdf", "s.obj", "-o", "good.vdb", "--resolution", 24)
        grids, metadata = pyopenvdb.readAll(str(self.path("good.vdb")))
        for number, box in enumerate(("", "here", "0,0,0,1,1", "0,0,0,1,1,nan", "0,0,0,1,1,1,1", "1,1,1,0,0,0",
                                      "0,0,0,0,0,0")):
            name = f"box{number}.vdb"
            pyopenvdb.write(str(self.path(name)), grids=grids, metadata={**metadata, "julia_target_box": box})
            self.refused(BAD_DATA, "fractal", name, "-o", "x.vdb", "--resolution", 24,
                         mentions=[name, "julia_target_box"])

    def test_nowhere_negative(self):
        grid = self.sphere_grid()
        grid.mapAll(abs)
        self.all_refuse(self.save("positive.vdb", grid))

    def test_empty_grid(self):
        self.all_refuse(self.save("empty.vdb", pyopenvdb.FloatGrid(1.0)))

    # Promise: "A file that is broken, or made ..."
    def test_truncated(self):
        self.save("ball.vdb", self.sphere_grid())
        data = self.bytes("ball.vdb")
        end = len(data)
        for size in [4, 8, 20, 40, 60, 80, 200] + [end * k // 7 for k in range(1, 7)] + [end - 300, end - 16, end - 1]:
            self.write(f"cut_{size}_of_{end}.vdb", data[:size])
        self.all_refused(BAD_DATA, [("mesh", name, "-o", "x.ply") for name in self.listing() if "cut" in name],
                         mentions="cut_")

    # Promise: "A file that is broken, or made ..."
    def test_broken_metadata(self):
        self.write("s.obj", harness.obj(harness.sphere(2)))
        self.ok("fractal", "s.obj", "-o", "good.vdb", *LOW)
        for name, value in (("julia_alpha", "soup"), ("julia_map", "moebius"), ("julia_resolution", "-1"),
                            ("julia_input", None)):
            grids, metadata = pyopenvdb.readAll(str(self.path("good.vdb")))
            metadata[name] = value
            if value is None:
                del metadata[name]
            pyopenvdb.write(str(self.path("broken.vdb")), grids=grids, metadata=metadata)
            for command in (("fractal", "--config", "broken.vdb", "-o", "x.vdb"), ("mesh", "broken.vdb", "-o", "x.ply"),
                            ("slice", "broken.vdb", "-o", "x.png"), ("study", "broken.vdb", "-o", "x.png"),
                            ("render", "--field", "broken.vdb", "-o", "x.png")):
                with self.subTest(command=command, name=name):
                    self.refused(BAD_DATA, *command, mentions=["broken.vdb", value or "no target"])

    def test_alpha_grids(self):
        self.write("s.obj", harness.obj(harness.sphere(2)))
        grid = pyopenvdb.FloatGrid(40.0)
        grid.name = "alpha"
        grid.fill((-5, -5, -5), (5, 5, 5), 60.0)
        self.save("alpha.vdb", grid)
        self.ok("fractal", "s.obj", "-o", "x.vdb", *LOW, "--alpha", "alpha.vdb:alpha")
        self.path("x.vdb").unlink()
        self.refused(BAD_DATA, "fractal", "s.obj", "-o", "x.vdb", *LOW, "--alpha", "alpha.vdb:beta", mentions="beta")
        self.refused(NO_INPUT, "fractal", "s.obj", "-o", "x.vdb", *LOW, "--alpha", "none.vdb", mentions="none.vdb")
        grid.fill((0, 0, 0), (1, 1, 1), float("nan"))
        self.save("alpha.vdb", grid)
        self.refused(BAD_DATA, "fractal", "s.obj", "-o", "x.vdb", *LOW, "--alpha", "alpha.vdb", mentions="finite")


class VersorFiles(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.pending = []

    def inspect_refused(self, name, content):
        """Another broken file; tearDown() tries all at once."""
        name = f"{len(self.pending)}_{name}"
        self.pending.append(("versor", "inspect", self.write(name, content)))

    def tearDown(self):
        self.all_refused(BAD_DATA, self.pending)

    # Promise: A file that is not there, or is a folder, ends in 66
    def test_missing(self):
        self.write("s.obj", harness.obj(harness.sphere(1)))
        for extension in ("json", "p4d", "poly4d", "o3d", "vdb"):
            self.refused(NO_INPUT, "fractal", "s.obj", "-o", "x.vdb", *LOW, "--texture", f"nowhere.{extension}",
                         mentions=f"nowhere.{extension}")
        self.refused(NO_INPUT, "versor", "inspect", "nowhere.json", mentions="nowhere.json")
        self.refused(NO_INPUT, "versor", "scale", "nowhere.json", "2", "-o", "x.json", mentions="nowhere.json")

    # Promise: "A file that is broken, or made ..."
    def test_truncated(self):
        text = harness.rational_json(harness.ROOTS)
        for share in (0.1, 0.5, 0.99):
            self.inspect_refused("cut.json", text[:int(share * len(text))])
        data = harness.p4d(harness.ROOTS)
        for size in (3, 4, 10, 30, len(data) // 2, len(data) - 8, len(data) - 1):
            self.inspect_refused("cut.p4d", data[:size])
        self.inspect_refused("cut.poly4d", data[:50])
        data = harness.o3d(harness.ROOTS, harness.ROOTS[:1])
        for size in (10, 60, 100, len(data) // 2, len(data) - 64, len(data) - 1):
            self.inspect_refused("cut.o3d", data[:size])

    # Promise: "A file that is broken, or made ..."
    def test_counts_that_lie(self):
        data = bytearray(harness.p4d(harness.ROOTS))
        # The counts stand at 0 (degree), 4, 8, 12 (unused arrays), 16 (roots), and 20 + 3 * 32 (powers).
        for at in (0, 4, 8, 12, 16, 20 + 32 * len(harness.ROOTS)):
            for value in (-1, 2, 4, 2**31 - 1):
                lie = bytearray(data)
                struct.pack_into("<i", lie, at, value)
                self.inspect_refused(f"lie_at_{at}.p4d", bytes(lie))
        self.inspect_refused("long.p4d", bytes(data) + b"\0")
        shape = harness.o3d(harness.ROOTS, [])
        for at, value in ((0, 0), (4, -2), (len(shape) - 8 * 8 - 60, 1000), (len(shape) - 8 * 8 - 60, -3),
                          (len(shape) - 8 * 8 - 60, 2**31 - 1)):
            lie = bytearray(shape)
            struct.pack_into("<i", lie, at, value)
            self.inspect_refused("lie.o3d", bytes(lie))
        self.inspect_refused("long.o3d", shape + b"\0" * 8)

    # Promise: "A file that is broken, or made ..."
    def test_not_finite(self):
        nan, inf = float("nan"), float("inf")
        for root in ((nan, 0, 0, 0, 1), (0, 0, 0, inf, 1), (0, 0, 0, 0, nan), (0, 0, 0, 0, inf)):
            self.inspect_refused("bad.p4d", harness.p4d([root]))
        self.inspect_refused("scale.p4d", harness.p4d(harness.ROOTS, nan))
        for constant in (nan, inf, 0.0, -1.0):
            self.inspect_refused("constant.o3d", harness.o3d(harness.ROOTS, [], constant))
        self.inspect_refused("huge.json", harness.rational_json(harness.ROOTS).replace("0.25", "1e999"))

    def test_json_that_is_no_versor(self):
        good = json.loads(harness.rational_json(harness.ROOTS))
        without = {key: value for key, value in good.items() if key != "top"}
        for content in ("[]", "null", "{}", "3", '{"juliavdb": "rational"}', json.dumps(without),
                        json.dumps({**good, "version": 2}), json.dumps({**good, "more": 1}),
                        json.dumps({**good, "logScale": "0"}),
                        json.dumps({**good, "top": {"powerScale": 1, "roots": [{"position": [1, 2, 3], "power": 1}]}})):
            self.inspect_refused("odd.json", content)

    def test_unknown_extension(self):
        self.write("v.txt", harness.rational_json(harness.ROOTS))
        self.refused(USAGE, "versor", "inspect", "v.txt", mentions="v.txt")


class Places(harness.CliTest):
    """Where the output cannot go."""

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(2)))
        self.write("v.json", harness.rational_json(harness.ROOTS))
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 24)

    def jobs(self):
        """Every way to an output; the last word is the option's value without its extension."""
        return [(("sdf", "s.obj", "--resolution", 24, "-o"), ".vdb"), (("fractal", "s.obj", *LOW, "-o"), ".vdb"),
                (("fractal", "s.obj", *LOW, "--mesh"), ".ply"), (("mesh", "s.vdb", "-o"), ".stl"),
                (("versor", "new", "-o"), ".json"), (("versor", "scale", "v.json", "2", "-o"), ".p4d"),
                (("slice", "s.vdb", "--field", "grid", "--size", 16, "-o"), ".png"),
                (("study", "s.vdb", "--versors", 2, "--size", 16, "-o"), ".png"),
                (("render", "s.vdb", "--size", "16x16", "-o"), ".exr"), (("render", "s.obj", "--size", "16x16", "-o"), ".png"),
                (("render", "--field", "s.obj", *LOW, "--size", "16x16", "-o"), ".png"),
                (("points", "s.vdb", "--points", 9, "-o"), ".ply"), (("print", "s.vdb", "--size", 9, "-o"), ".stl"),
                (("fit", "s.obj", "--roots", 3, "--resolution", 20, "-o"), ".json"), (("usd", "s.vdb", "-o"), ".usda"),
                (("convert", "s.vdb", "-o"), ".nvdb")]

    # Promise of design.md: An output that "cannot be created" ends in 73, and a full disk in 74
    def test_no_such_folder(self):
        self.refused(CANNOT_CREATE, "sdf", "s.obj", "-o", "nowhere/x.vdb", mentions="there is no folder nowhere; make it first, by mkdir -p")
        self.all_refused(CANNOT_CREATE, [(*job, f"nowhere/x{extension}") for job, extension in self.jobs()],
                         mentions="nowhere")

    def test_the_folder_is_a_file(self):
        self.all_refused(CANNOT_CREATE, [(*job, f"v.json/x{extension}") for job, extension in self.jobs()],
                         mentions="v.json")

    # Promise: An output that "cannot be ..."
    def test_the_output_is_a_folder(self):
        for job, extension in self.jobs():
            name = f"folder{extension}"
            self.path(name).mkdir(exist_ok=True)
            self.refused(CANNOT_CREATE, *job, name, mentions=name)

    # Promise: An output that "cannot be ..."
    @unittest.skipIf(os.geteuid() == 0, "root may write everywhere")
    def test_a_folder_that_may_not_be_written(self):
        self.path("locked").mkdir(mode=0o500)
        for job, extension in self.jobs():
            self.refused(CANNOT_CREATE, *job, f"locked/x{extension}", mentions="locked")

    def test_one_place_for_two_outputs(self):
        self.refused(CANNOT_CREATE, "fractal", "s.obj", *LOW, "-o", "x.vdb", "--mesh", "/proc/nowhere/x.ply")
        self.path("same.ply").symlink_to("same.vdb")
        self.refused(USAGE, "fractal", "s.obj", *LOW, "-o", "same.vdb", "--mesh", "same.ply", mentions="same")

    def test_wrong_extension(self):
        self.all_refused(USAGE, [(*job, "x.docx") for job, _ in self.jobs()], mentions="x.docx")

    def test_no_output(self):
        self.all_refused(USAGE, [job[:-1] for job, _ in self.jobs()], mentions="-o")

    # Promise: Files are never half written: "Outputs ..."
    def test_an_existing_file_survives_a_failure(self):
        self.write("old.vdb", "precious")
        self.refused(BAD_DATA, "fractal", "s.obj", *LOW, "--beta=-5", "-o", "old.vdb")
        self.assertEqual(self.bytes("old.vdb"), b"precious")

    # Promise: An output that "cannot be ..."
    def test_full_device(self):
        self.all_refused(IO_ERROR, [(*job, "/dev/full") for job, _ in self.jobs()], mentions="/dev/full")
        with open("/dev/full", "wb") as full:
            self.refused(IO_ERROR, "info", "s.obj", stdout=full)
            self.refused(IO_ERROR, "--help", stdout=full)

    # Promise: An output that "cannot be ..."
    def test_full_disk(self):
        if os.geteuid() != 0:
            self.skipTest("only root can mount a small disk")
        disk = self.path("disk")
        disk.mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "none", disk], capture_output=True)
        if mounted.returncode != 0:
            self.skipTest("cannot mount a small disk here: " + mounted.stderr.decode().strip())
        self.addCleanup(subprocess.run, ["umount", disk], check=True)
        jobs = [("sdf", "s.obj", "--resolution", 60, "-o", "disk/x.vdb"),
                ("fractal", "s.obj", *LOW, "--mesh", "disk/x.ply", "-o", "disk/x.vdb"),
                ("mesh", "s.vdb", "-o", "disk/x.obj"), ("versor", "new", "--roots", 5000, "-o", "disk/x.json"),
                ("slice", "s.vdb", "--field", "grid", "--range", 0.1, "--size", 600, "-o", "disk/x.exr")]
        for job in jobs:
            with self.subTest(job=job):
                self.refused(IO_ERROR, *job, mentions="disk/x")
        # And the disk can be used again at once.
        self.ok("versor", "new", "-o", "disk/small.json")

    # Promise: An output that "cannot be ..."
    def test_file_size_limit(self):
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
            signal.signal(signal.SIGXFSZ, signal.SIG_DFL)

        for job in (("sdf", "s.obj", "--resolution", 60, "-o", "x.vdb"), ("mesh", "s.vdb", "-o", "x.ply")):
            self.refused(IO_ERROR, *job, preexec_fn=limit, mentions="x.")


class Options(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(2)))

    # Promise of design.md: "wrong usage: an unknown option, or a value out of range" ends in 2, with the option and the value
    def test_values_out_of_their_domain(self):
        cases = {
            "alpha": ["nan", "inf", "-inf", "0", "-3", "abc", "", "x:10", "x:10:", "x:10:abc", "x:10:300:rough",
                      "w:10:300", "x:10:-300", "x:0:300", "x:nan:300", "x:10@0.8:300@0.2", "x:10@a:300", "1e999"],
            "beta": ["nan", "inf", "abc", "", "y:nan:0", "y:0", "1e999"],
            "resolution": ["0", "-5", "1e9", "nan", "inf", "", "many", "1e-300"],
            "voxel-size": ["0", "-1", "nan", "inf", "1e-300", "small"],
            "sdf-resolution": ["0", "-5", "1e9", "nan"],
            "sdf-voxel-size": ["0", "nan", "1e-300"],
            "repair-gap": ["-1", "nan"],
            "map": ["mandelbrot", ""],
            "texture-seed": ["-1", "x", "1.5", "99999999999999999999999"],
            "texture-roots": ["0", "-2", "2.5", "1e3", "99999999999"],
            "texture-powers": ["9:2", "2:3:4", "a:b", "nan:2", ":", "1e7:1e8"],
            "texture-placement": ["elsewhere"],
            "texture-distance": ["0", "-1"],
            "texture-radius": ["0"],
            "texture-centre": ["0,0", "a,b,c"],
            "texture-scale": ["0", "nan"],
            "texture-translate": ["1,2", "1,2,inf"],
            "c": ["0,0,0", "0,0,0,0,0", "a,b,c,d", "0,0,0,nan", ""],
            "iterations": ["0", "-1", "1.5", "abc", "99999999999"],
            "escape": ["1", "0.5", "-20", "nan", "inf", "1e300"],
            "slice": ["nan", "x"],
            "detail": ["-0.1", "1.1", "nan", "abc", "x:0.1:2", "x:-1:1"],
            "outward": ["-0.1", "2", "inf"],
            "mask": ["-1", "1.5", "x:0:7"],
            "origin": ["0,0", "0,0,nan", "middle", "9,0,0"],
            "origin-near": ["0,0", "x"],
            "origin-shift": ["0", "0,0,inf"],
            "drop-axis": ["r", "x"],
            "space": ["outer"],
            "box": ["1,1,1,0,0,0", "0,0,0,1,1,0", "0,0,0,1,1", "0,0,0,1,1,nan", "0,0,0,0,0,0"],
            "tolerance": ["0", "-1", "1", "nan"],
            "seed-stride": ["0", "3", "128", "-8", "x"],
            "precision": ["half"],
            "grids": ["", "surface,", "surface,surface", "velocity", "surface velocity"],
        }
        lines = []
        for option, values in cases.items():
            rest = () if option in ("resolution", "voxel-size") else ("--resolution", 24)
            rest += () if option.startswith("sdf-") else ("--sdf-resolution", 24)
            lines += [("fractal", "s.obj", "-o", "x.vdb", *rest, f"--{option}={value}") for value in values]
        self.all_refused(USAGE, lines)

    def test_sdf_values(self):
        cases = {"resolution": ["0", "-5", "1e9", "nan"], "voxel-size": ["0", "1e-300"], "band": ["0", "1", "nan", "1e9"],
                 "repair-gap": ["-1"], "alpha": ["40"]}
        self.all_refused(USAGE, [("sdf", "s.obj", "-o", "x.vdb", f"--{option}={value}")
                                 for option, values in cases.items() for value in values])

    # Promise: "wrong usage: an unknown ..."
    def test_alternatives_exclude_each_other(self):
        self.refused(USAGE, "fractal", "s.obj", "-o", "x.vdb", "--resolution", 24, "--follow", "--exhaustive",
                     mentions="--follow")
        self.refused(USAGE, "fractal", "s.obj", "-o", "x.vdb", "--resolution", 24, "--voxel-size", 0.1,
                     mentions=["--resolution", "--voxel-size"])
        self.refused(USAGE, "fractal", "s.obj", "-o", "x.vdb", "--sdf-resolution", 24, "--sdf-voxel-size", 0.1,
                     mentions=["--sdf-resolution", "--sdf-voxel-size"])
        self.refused(USAGE, "sdf", "s.obj", "-o", "x.vdb", "--resolution", 24, "--voxel-size", 0.1,
                     mentions=["--resolution", "--voxel-size"])
        self.refused(USAGE, "fractal", "s.obj", "-o", "x.vdb", "--alpha", 24, "--alpha", 25, mentions="alpha")

    # Promise: "wrong usage: an unknown ..."
    def test_values_that_begin_with_a_minus(self):
        self.ok("fractal", "s.obj", "-o", "x.vdb", *LOW, "--beta", "-0.05", "--origin", "-0.1,0,0",
                "--texture-translate", "-0.1,-0.2,0", "--slice", "-0.05", "--box", "-0.5,-0.5,-0.5,1,1,1")
        recipe = self.info("x.vdb")["recipe"]
        self.assertEqual((recipe["beta"], recipe["origin"]), ("-0.05", "-0.1,0,0"))
        self.ok("fractal", "--map", "quadratic", "--c", "-0.2,0.6,0.2,0.2", "-o", "q.vdb", "--resolution", 16)

    # Promise: "wrong usage: an unknown ..."
    def test_nothing_to_work_on(self):
        self.refused(USAGE, "fractal", "-o", "x.vdb", mentions="target")
        self.refused(USAGE, "sdf", "-o", "x.vdb", mentions="mesh")
        self.refused(USAGE, "fractal", "--map", "rational", "-o", "x.vdb", mentions="give a box")
        self.refused(USAGE, "fractal", "s.obj", mentions="-o")

    # Promise: "An empty result is an error, not ..."
    def test_box_far_away(self):
        for box in ("50,50,50,51,51,51", "-9,-9,-9,-8,-8,-8"):
            self.refused(BAD_DATA, "fractal", "s.obj", "-o", "x.vdb", "--mesh", "x.ply", *LOW, f"--box={box}",
                         mentions="box")

    # Promise: "An empty result is an error, not ..."
    def test_box_without_a_node(self):
        self.refused(USAGE, "fractal", "s.obj", "-o", "x.vdb", *LOW, "--box", "0.01,0.01,0.01,0.02,0.02,0.02",
                     mentions="box")

    # Promise of design.md: "An empty result is an error, not an empty file"
    def test_an_empty_fractal(self):
        for output in (("-o", "x.vdb"), ("--mesh", "x.ply"), ("-o", "x.vdb", "--mesh", "x.ply"),
                       ("-o", "x.vdb", "--grids", "logmodulus")):
            with self.subTest(output=output):
                self.refused(BAD_DATA, "fractal", "s.obj", *LOW, "--beta", "-5", *output, mentions="empty")

    # Promise: "A file that is read for its recipe ..."
    def test_config_files(self):
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 24)
        self.refused(USAGE, "fractal", "--config", "s.vdb", "-o", "x.vdb", mentions=["s.vdb", "sdf"])
        self.refused(NO_INPUT, "fractal", "--config", "nowhere.vdb", "-o", "x.vdb", mentions="nowhere.vdb")
        self.refused(NO_INPUT, "fractal", "--config", "nowhere.ply", "-o", "x.vdb", mentions="nowhere.ply")
        self.refused(NO_INPUT, "fractal", "--config", "nowhere.cfg", "-o", "x.vdb", mentions="nowhere.cfg")
        self.refused(BAD_DATA, "fractal", "--config", "s.obj", "-o", "x.vdb", mentions="s.obj")
        self.refused(NO_INPUT, "fractal", "--config", ".", "-o", "x.vdb")
        self.ok("fractal", "s.obj", "--mesh", "s.stl", *LOW)
        self.refused(BAD_DATA, "fractal", "--config", "s.stl", "-o", "x.vdb", mentions=["s.stl", "recipe"])
        grid = pyopenvdb.createLevelSetSphere(radius=1.0, voxelSize=0.1)
        pyopenvdb.write(str(self.path("foreign.vdb")), grids=grid)
        self.refused(BAD_DATA, "fractal", "--config", "foreign.vdb", "-o", "x.vdb", mentions="recipe")
        for content in ("alpha 40\n", "frobnicate = 3\n", "alpha = 4\nalpha = 5\n", "alpha = nan\n"):
            self.write("bad.cfg", "input = s.obj\n" + content)
            with self.subTest(content=content):
                self.refused(USAGE, "fractal", "--config", "bad.cfg", "-o", "x.vdb", *LOW)
        self.write("bad.cfg", "input = s.obj\n\n  alpah = 40  # a comment\n")
        self.refused(USAGE, "fractal", "--config", "bad.cfg", "-o", "x.vdb", *LOW,
                     mentions=["bad.cfg", "line 3", "alpah", "did you mean 'alpha'"])
        # Boost.ProgramOptions puts names into its messages, and never ends where the name is that of a place in them.
        for content in ("%canonical_option% = 1\n", "%invalid_line%\n"):
            self.write("bad.cfg", content)
            self.refused(USAGE, "fractal", "--config", "bad.cfg", "-o", "x.vdb", *LOW, mentions="line 1")
        for word in ("-%canonical_option%", "-h%canonical_option%", "--%canonical_option%", "--=%option%", "-q"):
            self.refused(USAGE, "fractal", "s.obj", "-o", "x.vdb", word, *LOW, mentions="is not an option of")

    def test_long_values(self):
        """A value may be a whole file; what is said of it stays readable."""
        for value, mention in (("expr:" + "(" * 30000 + "x" + ")" * 30000, "shorter than 20 000 characters"),
                               ("expr:" + "é" * 5000, "must be an expression"), ("9" * 10 ** 6, "--detail"),
                               ("x" * 10 ** 6 + ".vdb", "cannot open")):
            self.write("long.cfg", f"input = s.obj\ndetail = {value}\n")
            run = self.run_program("fractal", "--config", "long.cfg", "-o", "x.vdb", *LOW)
            self.assertIn(run.returncode, (USAGE, NO_INPUT))
            text = run.stderr.decode()  # no character is cut
            self.assertRegex(text, r"\Ajuliavdb: [^\n]*\n\Z")
            self.assertIn(mention, text)
            self.assertLess(len(run.stderr), 2100)

    def test_pictures(self):
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 24)
        cases = [("slice", "-o", "x.png", "--field", "grid")]
        for option in ("--size=0", "--size=nan", "--size=99999", "--axis=w", "--field=psi", "--position=nan",
                       "--range=0", "--range=nan"):
            cases.append(("slice", "s.vdb", "-o", "x.png", option))
        for option in ("--size=0x10", "--size=10", "--size=10x", "--size=99999x10", "--azimuth=nan", "--fov=0",
                       "--fov=180", "--zoom=0", "--zoom=-1", "--samples=3"):
            cases.append(("render", "s.vdb", "-o", "x.png", option))
        self.all_refused(USAGE, cases)

    def test_versor_words(self):
        self.write("v.json", harness.rational_json(harness.ROOTS))
        cases = []
        for words in ((), ("paint",), ("new", "v.json"), ("inspect",), ("inspect", "v.json", "v.json"),
                      ("add", "v.json"), ("scale", "v.json"), ("scale", "v.json", "big"), ("scale", "v.json", "nan"),
                      ("scale", "v.json", "0"), ("translate", "v.json", "1,2"), ("translate", "v.json", "1,2,3,4,5")):
            cases.append(("versor", *words, *(("-o", "x.json") if words[:1] != ("inspect",) else ())))
        for option in ("--roots=0", "--powers=5:2", "--placement=inside", "--radius=0", "--box=0,0,0", "--seed=x"):
            cases.append(("versor", "new", "-o", "x.json", option))
        self.all_refused(USAGE, cases)


class EveryCommand(harness.CliTest):
    """The same codes, whichever command it is."""

    # The words before an input, and the kinds of input.
    READERS = ((("sdf", "-o", "x.vdb"), ("obj", "glb", "vdb")), (("fractal", "-o", "x.vdb"), ("ply", "stl", "vdb")),
               (("fractal", "-o", "x.vdb", "--config"), ("vdb", "ply", "obj", "glb", "json", "cfg")),
               (("fractal", "s.obj", "-o", "x.vdb", "--texture"), ("json", "p4d", "o3d", "vdb")),
               (("fractal", "s.obj", "-o", "x.vdb", "--detail"), ("vdb",)),
               (("fractal", "--map", "rational", "-o", "x.vdb", "--rational"), ("json", "o3d")),
               (("fit", "-o", "x.json"), ("off", "vdb")), (("mesh", "-o", "x.ply"), ("vdb", "ply")),
               (("points", "-o", "x.ply", "--points", 9), ("obj", "vdb")), (("print", "-o", "x.stl", "--size", 9), ("obj", "vdb")),
               (("versor", "inspect"), ("json", "p4d")), (("sheet", "-o", "x.png", "--vary", "detail=0.1,0.2"), ("obj", "vdb")),
               (("slice", "-o", "x.png"), ("obj", "vdb")), (("study", "-o", "x.png"), ("obj", "vdb")),
               (("render", "-o", "x.png"), ("obj", "vdb")), (("render", "--field", "-o", "x.png"), ("obj", "vdb")),
               (("explore", "--export", "x.html"), ("obj", "vdb")), (("plan", "tiles", "-o", "x", "--tiles", 2), ("obj", "vdb")),
               (("plan", "sheet", "-o", "x"), ("json",)), (("usd", "-o", "x.usda"), ("vdb",)), (("info",), ("obj", "vdb", "json", "nvdb")),
               (("convert", "-o", "x.nvdb"), ("vdb",)))

    # Promise: A file that is not there, or is a folder, ends in 66
    def test_an_input_that_is_not_there(self):
        self.write("s.obj", harness.obj(harness.sphere(2)))
        self.all_refused(NO_INPUT, [(*words, f"gone.{kind}") for words, kinds in self.READERS for kind in kinds],
                         mentions="gone.")

    # Promise: "A file that is broken, or made ..."
    def test_an_input_that_is_noise(self):
        self.write("s.obj", harness.obj(harness.sphere(2)))
        cases = []
        for words, kinds in self.READERS:
            for kind in kinds:
                if kind != "cfg":  # a text of options is as good as the command line, and as bad
                    cases.append((*words, self.write(f"noise.{kind}", bytes(range(256)) * 20)))
        self.all_refused(BAD_DATA, cases, mentions="noise.")


if __name__ == "__main__":
    harness.main()

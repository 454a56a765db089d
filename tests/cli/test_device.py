# SPDX-License-Identifier: Apache-2.0
"""Devices of OpenCL: the files have the processor's bytes, and a device that is missing, fails or lies costs none.

pocl makes the processor a device of OpenCL. tests/device/fake_opencl.cpp is a loader that fails or lies.
"""

import json
import os
import pathlib
import re
import subprocess
import unittest

import harness
from harness import INTERNAL, USAGE

LOW = ("--resolution", 28, "--sdf-resolution", 28)
ON = ("--device", "opencl")
NO_PLATFORM = {"OCL_ICD_VENDORS": "/nonexistent"}


def fake(mode, **more):
    return {"JULIAVDB_OPENCL": os.environ["JULIAVDB_FAKE_LOADER"], "JULIAVDB_FAKE_OPENCL": mode, **more}


def installed_driver(icd):
    """The file of the driver that an .icd file of this machine names; None if it is not where Debian has it."""
    name = icd.read_text().strip()
    files = (pathlib.Path(name), pathlib.Path("/usr/lib/x86_64-linux-gnu", name))
    return next((file.resolve() for file in files if "pocl" in name and file.is_file()), None)


class Devices(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("t.obj", harness.obj(harness.torus()))

    def use(self, *arguments, env=None):
        """What the device did in a run."""
        said = self.ok(*arguments, *ON, "--progress", "json", env=env)
        return json.loads(said.splitlines()[-1])["counts"]

    def listed(self, env=None):
        return json.loads(self.ok("devices", "--json", data=True, env=env))


@unittest.skipUnless(harness.has_opencl(), "no device of OpenCL is installed")
class SameBytes(Devices):

    def same(self, *arguments, outputs=("-o", ".vdb", "--mesh", ".ply"), said="Evaluates on device 0"):
        files = {}
        for name, device in (("here", ()), ("there", ON)):
            named = [word if word.startswith("-") else name + word for word in outputs]
            text = self.ok(*arguments, *named, *device)
            if device:
                self.assertIn(said, text)
                self.assertNotIn("The processor evaluates the field", text)
            files[name] = [self.bytes(name + word) for word in outputs if not word.startswith("-")]
        self.assertTrue(files["here"] == files["there"], f"{arguments}: the bytes differ")

    # Promise of gpu.md: "The files have the same bytes with every choice"
    def test_of_every_map(self):
        self.write("v.o3d", harness.o3d(harness.ROOTS, harness.ROOTS[:1]))
        for options in (("t.obj",), ("t.obj", "--precision", "double"), ("t.obj", "--texture", "v.o3d", "--sampling", "quadratic"),
                        ("t.obj", "--texture-seed", 5, "--drop-axis", "i", "--slice", 0.1),
                        ("t.obj", "--map", "rational", "--texture", "v.o3d")):
            with self.subTest(options=options):
                self.same("fractal", *options, *LOW)
        for options in (("--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", "--iterations", 8),
                        ("--map", "mandelbulb", "--power", 8), ("--map", "mandelbulb", "--power", 5.5),
                        ("--map", "cross", "--pair", "A"), ("--map", "cross", "--pair", "C", "--scheme", 3)):
            with self.subTest(options=options):
                self.same("fractal", *options, "--resolution", 28)

    def test_of_grids_whose_values_are_those_of_the_field(self):
        self.same("fractal", "t.obj", *LOW, "--grids", "surface,logmodulus,iterations,versor", outputs=("-o", ".vdb"))

    # Promise: "The files have the same bytes with every choice"
    # Promise: "have the device follow rays, some ..."
    def test_of_a_picture_of_the_field(self):
        self.write("v.o3d", harness.o3d(harness.ROOTS, harness.ROOTS[:1]))
        low = ("--sdf-resolution", 28)
        for options in (("--map", "mandelbulb"), ("--map", "mandelbulb", "--precision", "double", "--samples", 1), ("t.obj", *low),
                        ("t.obj", *low, "--texture", "v.o3d", "--colour", "iterations"), ("--map", "cross", "--pair", "A"),
                        ("t.obj", *low, "--map", "rational", "--texture", "v.o3d"), ("--map", "quadratic", "--c=-0.2,0.6,0.2,0.2"),
                        ("--map", "mandelbulb", "--eye=0.3,0.2,0.1", "--look-at", "1,1,1")):
            with self.subTest(options=options):
                self.same("render", "--field", *options, "--size", "64x48", outputs=("-o", ".png"))

    # Promise of gpu.md: "have the device follow rays, some half a million (2^19) in one call"
    def test_rays_of_a_picture_are_followed_together(self):
        """The number of calls does not depend on the size of the picture, and the device follows nearly all rays to their ends."""
        uses = [self.use("render", "--field", "--map", "mandelbulb", "--size", size, "-o", "a.png") for size in ("96x64", "288x192")]
        for use, pixels in zip(uses, (96 * 64, 288 * 192)):
            self.assertGreater(use["deviceRays"], pixels)
            # Rays, and what is around their ends, in two rounds; the rest is the lattice of the shadows.
            self.assertLess(use["deviceCalls"], 40)
            self.assertGreater(use["deviceMostRays"], use["deviceRays"] / 3)
        self.assertLessEqual(uses[1]["deviceCalls"], uses[0]["deviceCalls"] + 4)

    # Promise: "The files have the same bytes with every choice"
    def test_of_tiles(self):
        self.ok("plan", "tiles", "t.obj", *LOW, "--tiles", 2, "-o", "here")
        self.ok("plan", "tiles", "t.obj", *LOW, "--tiles", 2, "-o", "there")
        for name, device in (("here", ()), ("there", ON)):
            self.ok("task", name, "--range", "1-8", *device)
            self.ok("merge", name, "-o", f"{name}.vdb", "--mesh", f"{name}.ply")
        for extension in (".vdb", ".ply"):
            self.assertTrue(self.bytes("here" + extension) == self.bytes("there" + extension), extension)

    # Promise of gpu.md: "`submit --gpus` gives each task a device of its own"
    def test_of_tasks_that_gnu_parallel_gives_to_devices(self):
        for name in ("here", "there"):
            self.ok("plan", "tiles", "t.obj", *LOW, "--tiles", 2, "-o", name)
        self.ok("submit", "here", "--engine", "parallel", "--jobs", 2, "--mesh", "here.ply")
        self.ok("submit", "there", "--engine", "parallel", "--gpus", "0,0", "--mesh", "there.ply")
        self.assertTrue(self.bytes("here.ply") == self.bytes("there.ply"))
        log = self.path("there/logs/joblog").read_text()
        self.assertEqual(log.count("--device 'opencl:0' --index"), 2, log)

    def test_of_meshes_whose_parts_are_written_as_they_come(self):
        for extension in (".obj", ".stl", ".glb"):
            with self.subTest(extension=extension):
                self.same("fractal", "t.obj", "--resolution", 40, "--sdf-resolution", 28, outputs=("--mesh", extension))

    def test_of_grains(self):
        for options in (("--grain", "curvature", "--texture", "scales"), ("--grain", "around", "--texture", "woven")):
            with self.subTest(options=options):
                self.same("fractal", "t.obj", *LOW, *options)

    def test_of_a_box_that_cuts_the_set(self):
        for options in (("--box=-0.5,-1,-1,0.7,0.4,1",), ("--follow",)):
            with self.subTest(options=options):
                self.same("fractal", "t.obj", *LOW, *options)

    def test_large_calls_in_which_little_is_copied(self):
        """The nodes of all layers are evaluated together, up to some millions, and their edges searched together."""
        uses = [self.use("fractal", "t.obj", "--resolution", n, "--sdf-resolution", 28, "--mesh", "a.ply") for n in (28, 56, 112)]
        for use in uses:
            # What tries the device and the field is the same for each.
            self.assertLessEqual(use["deviceCalls"], uses[0]["deviceCalls"] + 2)
            self.assertLess(use["deviceCalls"], 30)
            self.assertEqual(use["deviceBytesOfFields"], uses[0]["deviceBytesOfFields"])
        for less, more in zip(uses, uses[1:]):
            nodes, edges, copied = (sum(more[name] - less[name] for name in names) for names in (
                ("devicePoints",), ("deviceEdges",), ("deviceBytesTo", "deviceBytesFrom")))
            self.assertGreater(edges, 1000)
            # A quarter of a byte for a node with its block, two numbers for an edge with its place.
            self.assertLessEqual(copied, nodes * 144 // 512 + 24 * edges + 4096)
            self.assertLess(copied, 64 * edges)
        self.assertGreater(uses[-1]["deviceMostPoints"], 100000)
        self.assertGreater(uses[-1]["deviceMostEdges"], 0.9 * uses[-1]["deviceEdges"] - 10000)

    # Promise: "The files have the same bytes with every choice"
    def test_with_any_number_of_threads(self):
        for threads in (1, 3):
            self.ok("fractal", "t.obj", *LOW, "--mesh", f"{threads}.ply", "--threads", threads, *ON)
        self.assertTrue(self.bytes("1.ply") == self.bytes("3.ply"))

    # Promise: "The files have the same bytes with every choice"
    def test_of_textures_made_of_others(self):
        self.write("v.o3d", harness.o3d(harness.ROOTS, harness.ROOTS[:1]))
        for options in (("--texture-symmetry", "3:y"), ("--texture-symmetry", "5:z:mirror"),
                        ("--texture", "v.o3d", "--texture-over", "thorns", "--texture-mix", "expr:hy")):
            self.ok("fractal", "t.obj", *LOW, *options, "--mesh", "here.ply")
            self.assertNotIn("The processor", self.ok("fractal", "t.obj", *LOW, *options, "--mesh", "there.ply", *ON))
            self.assertTrue(self.bytes("here.ply") == self.bytes("there.ply"), options)

    # Promise of gpu.md: "It also evaluates fields that the device cannot, and the run says why"
    def test_of_what_the_device_leaves_to_the_processor(self):
        options = ("fractal", "t.obj", *LOW, "--texture", "expr:y,-x,z+2")
        self.ok(*options, "--mesh", "here.ply")
        self.assertIn("The processor evaluates the field, and not the device: its texture is a formula",
                      self.ok(*options, "--mesh", "there.ply", *ON))
        self.assertTrue(self.bytes("here.ply") == self.bytes("there.ply"))

    def test_the_list_and_the_choice_by_number(self):
        devices = self.listed()["devices"]
        self.assertTrue(devices[0]["usable"], devices)
        self.assertEqual(devices[0]["refusal"], "")
        self.assertIn(devices[0]["name"], self.ok("devices", data=True))
        self.ok("fractal", "t.obj", *LOW, "--mesh", "a.ply", "--device", "opencl:0")
        self.refused(USAGE, "fractal", "t.obj", *LOW, "-o", "a.vdb", "--device", f"opencl:{len(devices)}",
                     mentions=("there is no such device", devices[0]["name"]))

    def test_the_commands_of_the_page(self):
        page = pathlib.Path(__file__).resolve().parents[2] / "docs" / "gpu.md"
        commands = re.findall(r"^    juliavdb (.*)$", page.read_text(), re.M)
        self.assertEqual(len(commands), 2)
        for command in commands:
            words = command.replace("bunny.obj", "t.obj").split()
            low = LOW if words[0] == "fractal" else ()
            self.ok(*words, *low, data=words[0] == "devices")

    def test_auto_takes_a_graphics_processor_or_the_processor(self):
        said = self.ok("fractal", "t.obj", *LOW, "--mesh", "a.ply", "--device", "auto")
        if not any(device["gpu"] and device["usable"] for device in self.listed()["devices"]):
            self.assertIn("Evaluates on the processor", said)


class Missing(Devices):

    # Promise: "`submit --gpus` gives each ..."
    def test_the_devices_of_submitted_tasks(self):
        self.ok("plan", "tiles", "t.obj", *LOW, "--tiles", 2, "-o", "farm")
        script = self.ok("submit", "farm", "--engine", "parallel", "--gpus", "3,1", "--dry-run", data=True)
        self.assertIn("--jobs 2 ", script)
        self.assertIn("$_ = (3,1)[($job->slot() - 1) % 2]", script)
        self.assertIn("--device opencl:{device}", script)
        script = self.ok("submit", "farm", "--engine", "slurm", "--gpus", "allocated", "--dry-run", data=True)
        self.assertIn("--gres=gpu:1", script)
        self.assertIn("--device opencl --index", script)
        for engine, value in (("parallel", "allocated"), ("parallel", "0,"), ("parallel", "-1"),
                              ("slurm", "0"), ("slurm", "all")):
            with self.subTest(engine=engine, value=value):
                self.refused(USAGE, "submit", "farm", "--engine", engine, f"--gpus={value}", "--dry-run", mentions="--gpus is")
        self.refused(USAGE, "submit", "farm", "--engine", "parallel", "--gpus", "0", "--device", "cpu", mentions="leave out one")

    def test_choices_that_are_none(self):
        for choice in ("gpu", "opencl:", "opencl:x", "opencl:-1", "opencl:1.5", ""):
            with self.subTest(choice=choice):
                self.refused(USAGE, "fractal", "t.obj", *LOW, "-o", "a.vdb", "--device", choice, mentions="device")

    # Promise of gpu.md: "exit code 70, and one line that says why for each device"
    def test_no_platform(self):
        self.refused(INTERNAL, "fractal", "t.obj", *LOW, "-o", "a.vdb", *ON, env=NO_PLATFORM, mentions="no driver of OpenCL")
        self.assertIn("Evaluates on the processor",
                      self.ok("fractal", "t.obj", *LOW, "-o", "a.vdb", "--device", "auto", env=NO_PLATFORM))
        self.assertEqual(self.listed(NO_PLATFORM)["devices"], [])
        said = self.ok("devices", env=NO_PLATFORM, data=True)
        for mention in ("There is no device", "  /nonexistent: no .icd file", "  libnvidia-opencl.so.1: ", "  libamdocl64.so: "):
            self.assertIn(mention, said)

    # Promise: "exit code 70, and one line ..."
    def test_no_loader(self):
        env = {"JULIAVDB_OPENCL": "/nonexistent/libOpenCL.so.1"}
        self.refused(INTERNAL, "fractal", "t.obj", *LOW, "-o", "a.vdb", *ON, env=env, mentions="/nonexistent/libOpenCL.so.1")
        self.ok("fractal", "t.obj", *LOW, "-o", "a.vdb", env=env)


@unittest.skipUnless(harness.has_opencl() and "JULIAVDB_FAKE_LOADER" in os.environ, "no device of OpenCL, or no fake of one")
class FailingDevices(Devices):

    def setUp(self):
        super().setUp()
        self.ok("fractal", "t.obj", *LOW, "--mesh", "here.ply")

    def here(self, mode, mentions, **more):
        """The run goes on without the device, with the same bytes, and says why."""
        said = self.ok("fractal", "t.obj", *LOW, "--mesh", "there.ply", *ON, env=fake(mode, **more))
        self.assertIn(mentions, said)
        self.assertEqual(said.count(mentions), 1, said)
        self.assertTrue(self.bytes("here.ply") == self.bytes("there.ply"), mode)

    # Promise of gpu.md: "the processor goes on; the run says so"
    def test_one_that_is_lost_in_the_middle(self):
        # The last two kernels evaluate signs and search edges; those before them try the arithmetic and the fields.
        kernels = self.use("fractal", "t.obj", *LOW, "--mesh", "there.ply")["deviceKernels"]
        for number in (kernels - 1, kernels):
            with self.subTest(number=number):
                self.here(f"lost:{number}", "The processor goes on; the result is the same.")

    # Promise: "the processor goes on; the run says so"
    def test_one_that_is_lost_may_read_what_it_was_given_until_it_says_that_it_has(self):
        kernels = self.use("fractal", "t.obj", *LOW, "--mesh", "there.ply")["deviceKernels"]
        self.here(f"late:{kernels}", "The processor goes on; the result is the same.")

    # Promise: "exit code 70, and one line ..."
    def test_one_that_is_lost_at_the_start(self):
        self.refused(INTERNAL, "fractal", "t.obj", *LOW, "-o", "a.vdb", *ON, env=fake("lost:1"), mentions="OpenCL's error -5")

    # Promise of gpu.md: "the device gives no answer for a minute"
    def test_one_that_gives_no_answer(self):
        # Two results are read for its arithmetic, and a few for the fields.
        for number in (4, 9, 14):
            with self.subTest(number=number):
                self.here(f"hang:{number}", "gave no answer in 1.5 s", JULIAVDB_DEVICE_TIMEOUT="1.5")
        self.refused(INTERNAL, "fractal", "t.obj", *LOW, "-o", "a.vdb", *ON, mentions="gave no answer in 1.5 s",
                     env=fake("hang:1", JULIAVDB_DEVICE_TIMEOUT="1.5"))

    def test_one_whose_compiler_hangs(self):
        self.refused(INTERNAL, "fractal", "t.obj", *LOW, "-o", "a.vdb", *ON, mentions="its compiler did not end in 2 s",
                     env=fake("compiler", JULIAVDB_DEVICE_TIMEOUT="0.5"))

    # Promise: "the device gives no answer ..."
    def test_a_time_limit_that_is_none(self):
        for limit in ("x", "0", "-1", "inf", "1s"):
            self.refused(INTERNAL, "fractal", "t.obj", *LOW, "-o", "a.vdb", *ON, env={"JULIAVDB_DEVICE_TIMEOUT": limit},
                         mentions=f"JULIAVDB_DEVICE_TIMEOUT is '{limit}'")

    # Promise of gpu.md: "If a bit differs from the processor's, the device is not used"
    def test_one_whose_arithmetic_is_wrong(self):
        self.refused(INTERNAL, "fractal", "t.obj", *LOW, "-o", "a.vdb", *ON, env=fake("wrong:1"),
                     mentions="its 32-bit arithmetic has other bits")

    # Promise: "If a bit differs from the processor's, the device is not used"
    def test_one_whose_field_is_wrong(self):
        """Its arithmetic passes: two results are read for that."""
        self.here("wrong:3", "has other bits than the processor at some of the points")

    # Promise: "If a bit differs from the processor's, the device is not used"
    def test_one_without_denormal_numbers(self):
        self.refused(INTERNAL, "fractal", "t.obj", *LOW, "-o", "a.vdb", *ON, env=fake("denormals"),
                     mentions="it has no denormal numbers")
        self.assertIn("denormal", self.listed(fake("denormals"))["devices"][0]["refusal"])

    def test_one_without_doubles(self):
        said = self.ok("fractal", "t.obj", *LOW, "--precision", "double", "--mesh", "there.ply", *ON, env=fake("singles"))
        self.assertIn("does not compute in 64 bits", said)
        said = self.ok("fractal", "t.obj", *LOW, "--precision", "float", "--mesh", "there.ply", *ON, env=fake("singles"))
        self.assertNotIn("64 bits", said)

    def test_one_whose_memory_holds_no_layer(self):
        """What does not fit is halved until it fits; the device goes on."""
        run = ("fractal", "t.obj", *LOW, "--mesh", "there.ply")
        self.assertNotIn("The processor", self.ok(*run, *ON, env=fake("full:8192")))
        self.assertTrue(self.bytes("here.ply") == self.bytes("there.ply"))
        whole, halved = self.use(*run), self.use(*run, env=fake("full:8192"))
        self.assertGreater(halved["deviceCalls"], whole["deviceCalls"])
        # Each edge gives a number of 8 bytes, of which 1024 fit.
        self.assertGreaterEqual(halved["deviceCalls"], halved["deviceEdges"] // 1024)
        self.assertLessEqual(halved["deviceMostEdges"], 1024)
        self.assertEqual(halved["deviceEdges"], whole["deviceEdges"])
        self.here("full:64", "its memory cannot be had")

    PICTURE = ("render", "--field", "--map", "mandelbulb", "--precision", "float", "--size", "48x32")

    def picture(self, mode, **more):
        """Makes the picture on a device that fails. @return what was said"""
        self.ok(*self.PICTURE, "-o", "here.png")
        said = self.ok(*self.PICTURE, "-o", "there.png", *ON, env=fake(mode), **more)
        self.assertTrue(self.bytes("here.png") == self.bytes("there.png"), mode)
        return said

    # Promise: "the processor goes on; the run says so"
    def test_one_that_is_lost_while_it_follows_rays(self):
        # Rays are followed and what is around their ends is evaluated, twice; each of these is one kernel.
        kernels = self.use(*self.PICTURE, "-o", "there.png")["deviceKernels"]
        for number in range(kernels - 3, kernels + 1):
            with self.subTest(number=number):
                self.assertIn("The processor goes on; the result is the same.", self.picture(f"lost:{number}"))

    # Promise: "the processor goes on; the run says so"
    def test_one_whose_rays_are_wrong(self):
        """What is read before the rays that try it is right: among the numbers of results, the last one that makes it fail there."""
        said = next(said for said in map(lambda number: self.ok(*self.PICTURE, "-o", "there.png", *ON, env=fake(f"wrong:{number}")),
                                         range(20, 8, -1)) if "other bits than the processor along rays" in said)
        self.assertEqual(said.count("The processor goes on; the result is the same."), 1)
        self.ok(*self.PICTURE, "-o", "here.png")
        self.assertTrue(self.bytes("here.png") == self.bytes("there.png"))

    def test_rays_without_doubles_and_with_little_memory(self):
        self.assertNotIn("The processor", self.picture("singles"))
        self.assertEqual(self.use(*self.PICTURE, "-o", "there.png", env=fake("singles"))["deviceRays"], 0)
        self.assertNotIn("The processor", self.picture("full:16384"))
        use = self.use(*self.PICTURE, "-o", "there.png", env=fake("full:16384"))
        # A ray has 48 bytes.
        self.assertTrue(0 < use["deviceMostRays"] <= 16384 // 48, use)

    # Promise: "It also evaluates fields ..."
    def test_one_with_too_little_memory(self):
        self.here("small", "the field needs")


@unittest.skipUnless(harness.has_opencl() and "JULIAVDB_FAKE_LOADER" in os.environ, "no device of OpenCL, or no fake of one")
class SeveralDevices(Devices):
    """A driver that lists its device twice stands for a machine with two."""

    TWO = {"JULIAVDB_FAKE_DEVICES": "2"}
    RUN = ("fractal", "t.obj", "--resolution", 56, "--sdf-resolution", 28)
    ALL = ("--device", "opencl:all")

    def counts(self, *device, mode="none"):
        said = self.ok(*self.RUN, "--mesh", "there.ply", "--progress", "json", *device, env=fake(mode, **self.TWO))
        return json.loads(said.splitlines()[-1])["counts"]

    def setUp(self):
        super().setUp()
        self.assertEqual(len(self.listed(fake("none", **self.TWO))["devices"]), 2 * len(self.listed()["devices"]))
        self.ok(*self.RUN, "-o", "here.vdb", "--mesh", "here.ply")

    def test_they_share_the_calls_and_the_bytes_are_those_of_one(self):
        said = self.ok(*self.RUN, "-o", "there.vdb", "--mesh", "there.ply", *self.ALL, env=fake("none", **self.TWO))
        self.assertIn("Evaluates on the devices 0, ", said)
        self.assertIn("; 1, ", said)
        for extension in (".vdb", ".ply"):
            self.assertTrue(self.bytes("here" + extension) == self.bytes("there" + extension))
        one, both = self.counts("--device", "opencl:0"), self.counts(*self.ALL)
        self.assertGreater(one["deviceMostPoints"], 50000)
        # Half of the largest call for each, up to a block.
        self.assertLessEqual(both["deviceMostPoints"], one["deviceMostPoints"] // 2 + 512)
        self.assertLessEqual(both["deviceMostEdges"], one["deviceMostEdges"] // 2 + 1)
        self.assertGreater(both["deviceBytesOfFields"], 1.9 * one["deviceBytesOfFields"])

    def test_one_that_is_the_only_one(self):
        said = self.ok(*self.RUN, "--mesh", "there.ply", *self.ALL)
        self.assertIn("Evaluates on device 0, ", said)
        self.assertTrue(self.bytes("here.ply") == self.bytes("there.ply"))

    def test_one_that_is_lost_leaves_its_part_to_the_processor(self):
        kernels = self.counts(*self.ALL)["deviceKernels"]
        for number in (kernels - 3, kernels - 1, kernels):
            with self.subTest(number=number):
                said = self.ok(*self.RUN, "--mesh", "there.ply", *self.ALL, env=fake(f"lost:{number}", **self.TWO))
                self.assertIn("The processor goes on; the result is the same.", said)
                self.assertTrue(self.bytes("here.ply") == self.bytes("there.ply"))

    def test_no_device_of_all(self):
        self.refused(INTERNAL, *self.RUN, "--mesh", "a.ply", *self.ALL, env=fake("denormals", **self.TWO), mentions="denormal")
        self.refused(INTERNAL, *self.RUN, "--mesh", "a.ply", *self.ALL, env=NO_PLATFORM, mentions="no driver of OpenCL")

    def test_what_they_leave_to_the_processor(self):
        said = self.ok(*self.RUN, "--texture", "expr:y,-x,z+2", "--mesh", "there.ply", *self.ALL, env=fake("none", **self.TWO))
        self.assertEqual(said.count("The processor evaluates the field, and not the device: its texture is a formula"), 1, said)
        self.ok(*self.RUN, "--texture", "expr:y,-x,z+2", "--mesh", "expected.ply")
        self.assertTrue(self.bytes("expected.ply") == self.bytes("there.ply"))
        # Points of pictures and traces of orbits go the same way.
        for name, device in (("here.png", ()), ("there.png", self.ALL)):
            self.ok("render", "--field", "--map", "mandelbulb", "--size", "64x48", "-o", name, *device, env=fake("none", **self.TWO))
        self.assertTrue(self.bytes("here.png") == self.bytes("there.png"))


@unittest.skipUnless(harness.has_opencl() and "JULIAVDB_FAKE_LOADER" in os.environ, "no device of OpenCL, or no fake of one")
class KeptPrograms(Devices):
    """What devices have compiled is kept in the user's cache folder. A driver that takes no source shows that it is used."""

    RUN = ("fractal", "t.obj", *LOW, "--mesh", "there.ply", *ON)

    def setUp(self):
        super().setUp()
        self.ok("fractal", "t.obj", *LOW, "--mesh", "here.ply")
        self.cache = self.path("cache")

    def files(self):
        return sorted(self.cache.glob("*"))

    def run_with(self, mode=None, **more):
        env = {**(fake(mode) if mode else fake("none")), "JULIAVDB_DEVICE_CACHE": str(self.cache), **more}
        self.assertNotIn("The processor", self.ok(*self.RUN, env=env))
        self.assertTrue(self.bytes("here.ply") == self.bytes("there.ply"))

    def is_used(self):
        """Whether a run needs no source; otherwise the device cannot be used, or not for the field."""
        run = self.run_program(*self.RUN, env={**fake("source"), "JULIAVDB_DEVICE_CACHE": str(self.cache)})
        return run.returncode == harness.DONE and b"The processor" not in run.stderr

    def test_a_later_run_compiles_nothing_and_repeats_no_test_of_the_arithmetic(self):
        env = {"JULIAVDB_DEVICE_CACHE": str(self.cache)}
        first, second = self.use(*self.RUN[:-2], env=env), self.use(*self.RUN[:-2], env=env)
        self.assertEqual(first["deviceKernels"] - second["deviceKernels"], 2)
        self.assertTrue(self.is_used())
        self.assertEqual(self.cache.stat().st_mode & 0o777, 0o700)
        for file in self.files():
            self.assertEqual((file.suffix, file.stat().st_mode & 0o777), (".program", 0o600))
        # The list of devices always tests them.
        self.assertIn("not used", self.ok("devices", data=True, env={**env, **fake("wrong:1")}))

    def test_the_users_cache_folder(self):
        for env, place in (({"XDG_CACHE_HOME": self.path("xdg")}, "xdg"), ({"XDG_CACHE_HOME": "", "HOME": self.path("home")}, "home/.cache"),
                           ({"XDG_CACHE_HOME": "relative", "HOME": self.path("other")}, "other/.cache")):
            self.ok(*self.RUN, env={"JULIAVDB_DEVICE_CACHE": "", **{name: str(value) for name, value in env.items()}})
            self.assertTrue(list(self.path(place).glob("juliavdb/devices/*.program")), place)
        self.assertFalse(self.path("relative/juliavdb").exists())

    def test_what_was_tampered_with_is_made_again(self):
        self.run_with()
        whole = {file: file.read_bytes() for file in self.files()}

        def change(how):
            for file, content in whole.items():
                file.unlink(missing_ok=True)
                how(file, content)

        def linked(file, content):
            self.write(file.name, "")
            self.path(file.name).write_bytes(content)
            file.symlink_to(self.path(file.name))

        def writable(file, content):
            file.write_bytes(content)
            file.chmod(0o666)

        for name, how in (("one byte", lambda file, content: file.write_bytes(content[:-5] + bytes([content[-5] ^ 1]) + content[-4:])),
                          ("a part", lambda file, content: file.write_bytes(content[:len(content) // 2])),
                          ("nothing", lambda file, content: file.write_bytes(b"")),
                          ("another version", lambda file, content: file.write_bytes(content.replace(b"cache 1", b"cache 2", 1))),
                          ("a link", linked), ("one that others may write", writable)):
            with self.subTest(name):
                change(how)
                self.assertFalse(self.is_used())
                self.run_with()
                self.assertTrue(self.is_used())

    def test_a_key_of_another_program_is_not_taken(self):
        self.run_with()
        contents = [file.read_bytes() for file in self.files()]
        for file, content in zip(self.files(), contents[1:] + contents[:1]):
            file.write_bytes(content)
        self.assertFalse(self.is_used())
        self.run_with()

    def test_a_folder_that_others_may_write_is_not_used(self):
        self.run_with()
        for mode in (0o720, 0o702):
            self.cache.chmod(mode)
            self.assertFalse(self.is_used())
            self.run_with()
        self.cache.chmod(0o700)
        self.assertTrue(self.is_used())

    def test_a_folder_that_is_none(self):
        self.write("cache", "a file")
        self.run_with()
        self.assertEqual(self.cache.read_text(), "a file")
        self.run_with(JULIAVDB_DEVICE_CACHE="/proc/nothing")
        self.run_with(JULIAVDB_DEVICE_CACHE="none")
        self.assertFalse(self.path("none").exists())

    def test_two_processes_at_once(self):
        env = {**harness.environment(), "JULIAVDB_DEVICE_CACHE": str(self.cache)}
        words = [harness.program(), *map(str, self.RUN[:6]), "--mesh"]
        runs = [subprocess.Popen([*words, f"{n}.ply", *ON], cwd=self.path("."), env=env, stderr=subprocess.PIPE) for n in range(3)]
        for n, run in enumerate(runs):
            said = run.communicate(timeout=harness.TIMEOUT)[1]
            self.assertEqual(run.returncode, 0, said)
            self.assertTrue(self.bytes("here.ply") == self.bytes(f"{n}.ply"))
        self.assertTrue(all(file.suffix == ".program" for file in self.files()))
        self.assertTrue(self.is_used())

    def test_old_files_are_removed(self):
        self.run_with()
        for n in range(200):
            file = self.cache / f"{n:064}.program"
            file.write_bytes(b"")
            os.utime(file, (1000 + n, 1000 + n))
        self.write("v.o3d", harness.o3d(harness.ROOTS, harness.ROOTS[:1]))
        self.ok("fractal", "t.obj", *LOW, "--texture", "v.o3d", "--mesh", "a.ply", *ON, env={"JULIAVDB_DEVICE_CACHE": str(self.cache)})
        names = {file.name for file in self.files()}
        self.assertLessEqual(len(names), 128)
        self.assertNotIn(f"{0:064}.program", names)
        self.assertTrue(self.is_used())


@unittest.skipUnless(harness.has_opencl(), "no device of OpenCL is installed")
class Drivers(Devices):
    """Those that no .icd file names, as in images of containers. pocl's driver stands for any."""

    def setUp(self):
        super().setUp()
        self.driver = next(path for path in map(installed_driver, pathlib.Path("/etc/OpenCL/vendors").glob("*.icd")) if path)

    def of_a_vendor(self, name):
        """An environment in which the driver has another name, by which no .icd file calls it."""
        os.makedirs(self.path("usr/lib/here"), exist_ok=True)
        # pocl looks for its own parts from where its library is: beside it, and in ../../share.
        for link, to in ((f"lib/here/{name}", self.driver), ("lib/here/pocl", self.driver.parent / "pocl"), ("share", "/usr/share")):
            if not self.path(f"usr/{link}").exists():
                self.path(f"usr/{link}").symlink_to(to)
        return {**NO_PLATFORM, "LD_LIBRARY_PATH": str(self.path("usr/lib/here"))}

    def found(self, env):
        listed = self.listed(env)
        self.assertTrue(listed["devices"] and listed["devices"][0]["usable"], listed)
        return listed["devices"], {each["place"]: each["found"] for each in listed["drivers"]}

    def evaluates(self, env):
        self.ok("fractal", "t.obj", *LOW, "--mesh", "here.ply")
        self.assertIn("Evaluates on device 0", self.ok("fractal", "t.obj", *LOW, "--mesh", "there.ply", *ON, env=env))
        self.assertTrue(self.bytes("here.ply") == self.bytes("there.ply"))

    # Promise: "Vendors' drivers that the loader ..."
    def test_one_that_is_named(self):
        for loader in ({}, {"JULIAVDB_OPENCL": "/nonexistent"}):
            env = {**NO_PLATFORM, **loader, "JULIAVDB_OPENCL_DRIVER": str(self.driver)}
            _, places = self.found(env)
            self.assertEqual(places, {str(self.driver): "1 platform"})
            self.evaluates(env)

    # Promise of gpu.md: "Vendors' drivers that the loader has not opened are looked for by their names"; "that driver is used and
    #   no other"
    def test_a_vendors_that_is_found_by_its_name(self):
        for name in ("libnvidia-opencl.so.1", "libamdocl64.so"):
            vendor = self.of_a_vendor(name)
            for loader in ({}, {"JULIAVDB_OPENCL": "/nonexistent"}):
                with self.subTest(name=name, loader=loader):
                    env = {**vendor, **loader}
                    devices, places = self.found(env)
                    self.assertEqual(len(devices), 1)
                    self.assertEqual(places[str(self.path(f"usr/lib/here/{name}"))], "1 platform")
                    self.evaluates(env)
            self.path(f"usr/lib/here/{name}").unlink()

    # Promise: "Vendors' drivers that the loader ..."
    def test_one_that_the_loader_knows_is_not_counted_twice(self):
        os.mkdir(self.path("vendors"))
        self.write("vendors/one.icd", "libnvidia-opencl.so.1\n")
        devices, places = self.found({**self.of_a_vendor("libnvidia-opencl.so.1"), "OCL_ICD_VENDORS": str(self.path("vendors"))})
        self.assertEqual(len(devices), 1)
        self.assertEqual(places[str(self.path("vendors/one.icd"))], "it names libnvidia-opencl.so.1, which is open")
        self.assertEqual(places[str(self.path("usr/lib/here/libnvidia-opencl.so.1"))], "the loader has opened it")

    # Promise: "Vendors' drivers that the loader ..."
    def test_a_named_file_that_is_no_driver(self):
        for file, mention in (("/nonexistent/driver.so", "/nonexistent/driver.so"), ("libm.so.6", "is no driver of OpenCL")):
            env = {"JULIAVDB_OPENCL_DRIVER": file}
            self.refused(INTERNAL, "fractal", "t.obj", *LOW, "-o", "a.vdb", *ON, env=env, mentions=("JULIAVDB_OPENCL_DRIVER", mention))
            self.assertEqual(self.listed(env)["devices"], [])


if __name__ == "__main__":
    harness.main()

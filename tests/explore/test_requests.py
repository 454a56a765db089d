#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the server of `juliavdb explore` answers to its page."""

import concurrent.futures
import json
import os
import pathlib
import re
import resource
import shlex
import struct
import subprocess
import time

from server import QUICK, Server, harness


class Page(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.torus(around=24, across=12)))

    def serve(self, *arguments):
        running = Server(self.folder, *arguments)
        self.addCleanup(running.kill)
        return running

    # ------------------------------------------------------------------------------------------------ what it knows

    def test_the_page_and_all_its_files(self):
        page = self.serve("s.obj", *QUICK)
        status, headers, body = page.raw("GET", "")
        self.assertEqual((status, headers["Content-Type"]), (200, "text/html; charset=utf-8"))
        self.assertTrue(body.startswith(b"<!DOCTYPE html>"))
        self.assertEqual(page.raw("GET", "page/index.html")[2], body)
        self.assertEqual(page.raw("GET", "page/nothing.js")[0], 404)
        status, _, empty = page.raw("HEAD", "")
        self.assertEqual((status, empty), (200, b""))

    def test_start(self):
        page = self.serve("s.obj", "--detail", "0.4", *QUICK)
        status, start = page.get("start")
        self.assertEqual(status, 200)
        self.assertEqual(start["recipe"]["detail"], "0.4")
        self.assertNotIn("alpha", start["recipe"], "it is what was given, not completed")
        self.assertEqual(start["target"]["triangles"], 24 * 12 * 2)
        self.assertEqual(start["target"]["name"], "s.obj")
        self.assertEqual(start["folder"], str(self.folder))
        options = {option["name"]: option for option in start["options"]}
        self.assertEqual(options["detail"]["alternative"], "alpha" if "alternative" in options["alpha"] else
                         options["detail"]["alternative"])
        self.assertIn("shape-modulus", options["detail"]["maps"])
        self.assertEqual(options["power"]["maps"], ["mandelbulb"])
        listed = {line.split()[0] for line in self.run_program("versor", "list").stdout.decode().splitlines() if line}
        for texture in start["textures"]:
            self.assertIn(texture["name"], listed)
        self.assertIn("vdb", start["formats"])

    # Promise of README.md: The page has "a slider for every option", with the defaults of the command, and each of them acts
    def test_every_default_of_an_option_is_that_of_the_command(self):
        # A seed would make the texture another by default.
        words = ("--sdf-resolution", "32", "--resolution", "24", "--iterations", "3")
        page = self.serve("s.obj", *words)
        start = page.get("start")[1]
        self.ok("fractal", "s.obj", *words, "--mesh", "x.ply")
        made = harness.read_ply(self.bytes("x.ply")).comments
        for option in start["options"]:
            default = option["defaults"].get("shape-modulus")
            name = "julia_" + option["name"].replace("-", "_")
            if default is not None and option["name"] not in start["recipe"] and name in made:
                self.assertEqual(made[name], default, option["name"])

    def test_without_a_target(self):
        page = self.serve("--map", "mandelbulb", "--resolution", "20")
        self.assertIsNone(page.get("start")[1]["target"])
        self.assertEqual(page.get("target")[0], 404)
        status, scene = page.post("scene", {"recipe": {"map": "mandelbulb", "power": "7"}})
        self.assertEqual(status, 200, scene)
        self.assertEqual(scene["power"], 7)

    # ------------------------------------------------------------------------------------------------------- scenes

    def test_a_scene_and_its_volume(self):
        page = self.serve("s.obj", *QUICK)
        status, scene = page.post("scene", {"recipe": page.recipe(detail="0.3")})
        self.assertEqual(status, 200, scene)
        exponent = scene["exponent"]
        status, volume = page.get("volume/" + exponent["id"])
        self.assertEqual(status, 200)
        x, y, z = exponent["dims"]
        self.assertEqual(len(volume), 2 * x * y * z)
        self.assertEqual(page.get("volume/" + "0" * 32)[0], 404)
        # A smaller one for a small picture: the same scene but for its volume.
        status, small = page.post("scene", {"recipe": page.recipe(detail="0.3"), "side": 16})
        self.assertEqual(status, 200, small)
        self.assertLessEqual(max(small["exponent"]["dims"]), 16)
        self.assertLess(max(small["exponent"]["dims"]), max(exponent["dims"]))
        x, y, z = small["exponent"]["dims"]
        self.assertEqual(len(page.get("volume/" + small["exponent"]["id"])[1]), 2 * x * y * z)
        for entry in scene.keys() - {"exponent"}:
            self.assertEqual(small[entry], scene[entry], entry)
        for side in (15, 257, -1, 2.5, "64", 10 ** 30, True):
            status, answer = page.post("scene", {"recipe": page.recipe(), "side": side})
            self.assertEqual((status, answer["error"]), (400, "'side' must be a whole number of nodes from 16 to 256"), side)

    # Promise: The page shows a texture ...
    def test_a_scene_with_a_grain_has_two_volumes(self):
        page = self.serve("s.obj", "--sdf-resolution", "32", "--resolution", "24", "--texture", "fur", "--grain", "along")
        status, scene = page.post("scene", {"recipe": page.recipe()})
        self.assertEqual(status, 200, scene)
        for entry, size in (("exponent", 2), ("grain", 10)):
            x, y, z = scene[entry]["dims"]
            status, volume = page.get("volume/" + scene[entry]["id"])
            self.assertEqual((status, len(volume)), (200, size * x * y * z), entry)
        # Only the exponent of a small picture is smaller.
        self.assertTrue(page.post("scene", {"recipe": page.recipe(), "side": 16})[1]["grain"] == scene["grain"])

    # Promise: "What was made before changes ..."
    def test_a_scene_does_not_depend_on_those_before_it(self):
        self.write("m.obj", harness.obj(harness.snowman()))
        self.ok("sdf", "m.obj", "-o", "m.vdb", "--resolution", 40)
        words = ("m.vdb", "--resolution", "20", "--texture", "scales")

        def seen(page, detail):
            status, scene = page.post("scene", {"recipe": page.recipe(detail=detail)})
            self.assertEqual(status, 200, scene)
            status, picture = page.post("picture", {"recipe": page.recipe(detail=detail), "width": 60, "height": 60})
            self.assertEqual(status, 200, picture)
            return scene, page.get("volume/" + scene["exponent"]["id"]), picture

        company = self.serve(*words)
        for detail in ("0.5", "0.1", "0.3"):
            # No assertEqual(), which would look for differences in megabytes for minutes.
            self.assertTrue(seen(company, detail) == seen(self.serve(*words), detail), detail)

    def test_what_the_command_would_say_is_what_the_page_is_told(self):
        page = self.serve("s.obj", *QUICK)
        for wrong in ({"detail": "2"}, {"texture": "nosuch"}, {"nosuch": "1"}, {"iterations": "x"},
                      {"map": "rational"}, {"slice": "nan"}):
            recipe = page.recipe(**wrong)
            status, answer = page.post("scene", {"recipe": recipe})
            words = [f"--{name}={value}" for name, value in recipe.items() if name != "input"]
            run = self.run_program("fractal", "s.obj", *words, "-o", "x.vdb")
            if run.returncode == 0:
                self.assertEqual(status, 200, (wrong, answer))
                continue
            self.assertIn(status, (400, 422), wrong)
            if "nosuch" not in wrong:
                self.assertEqual(f"juliavdb: {answer['error']}", run.stderr.decode().strip(), wrong)

    def test_bodies_that_are_none(self):
        page = self.serve("s.obj", *QUICK)
        for body in (b"", b"{", b"[]", b"1", b"null", b'{"recipe": []}', b'{"recipe": {"detail": 1}}', b"[" * 60000,
                     b'{"recipe": {}}' + b"x", bytes(range(256)), b'{"recipe": {"detail": "\\ud800"}}'):
            for path in ("scene", "picture", "make", "command"):
                status, _, answer = page.raw("POST", path, body, {"Content-Type": "application/json"})
                self.assertIn(status, (400, 422), (path, body[:30], answer))
                self.assertIn("error", json.loads(answer))
        self.assertEqual(page.get("jobs")[0], 200)

    def test_the_latest_scene_wins(self):
        page = self.serve("s.obj", "--resolution", "30", "--sdf-resolution", "150")
        # Each needs distances of its own, so the first is at work for a while.
        with concurrent.futures.ThreadPoolExecutor(5) as threads:
            asked = []
            for resolution in (161, 162, 163, 164, 165):
                asked.append(threads.submit(page.post, "scene",
                                            {"recipe": page.recipe(sdf_resolution=resolution)}))
                time.sleep(0.2)  # so that they come in this order
            statuses = [answer.result()[0] for answer in asked]
        self.assertEqual(statuses[-1], 200)
        self.assertTrue(set(statuses) <= {200, 409}, statuses)
        with concurrent.futures.ThreadPoolExecutor(4) as threads:
            waits = [threads.submit(page.post, "scene", {"recipe": page.recipe(sdf_resolution=n), "wait": True})
                     for n in (171, 172, 173, 174)]
            self.assertEqual([answer.result()[0] for answer in waits], [200] * 4)

    def test_the_target_as_a_mesh(self):
        points, faces = harness.torus(around=24, across=12)
        self.write("far.obj", harness.obj(harness.moved((points, faces), 3, (1e6, -2e6, 5))))
        page = self.serve("far.obj", *QUICK)
        status, data = page.get("target")
        self.assertEqual(status, 200)
        count, triangles = struct.unpack_from("<2I", data)
        self.assertEqual((count, triangles), (len(points), len(faces)))
        at = list(struct.iter_unpack("<3f", data[8:8 + 12 * count]))
        self.assertEqual(list(struct.iter_unpack("<3I", data[8 + 12 * count:])), [tuple(f) for f in faces])
        side = max(max(p[a] for p in points) - min(p[a] for p in points) for a in range(3))
        for got, point in zip(at, points):
            for axis in range(3):
                self.assertAlmostEqual(got[axis] * side, point[axis], delta=1e-5)

    # ----------------------------------------------------------------------------------------------------- pictures

    # Promise: "*Copy command* gives the command ..."
    def test_a_picture_is_that_of_the_command(self):
        page = self.serve("s.obj", "--detail", "0.5", *QUICK)
        # Other looks first: what they leave behind must not show.
        for detail in ("0.9", "0.05", "0.6"):
            self.assertEqual(page.post("scene", {"recipe": page.recipe(detail=detail)})[0], 200)
        body = {"recipe": page.recipe(detail="0.3"), "width": 60, "height": 40, "samples": 4, "colour": "iterations",
                "view": {"eye": [1.5, 1.2, -2], "lookAt": [0, 0.1, 0], "up": [0, 1, 0.1], "fov": 40}}
        status, picture = page.post("picture", body)
        self.assertEqual(status, 200, picture)
        self.ok("render", "s.obj", "--field", *QUICK, "--detail", "0.3", "--size", "60x40", "--samples", "4", "--colour",
                "iterations", "--eye=1.5,1.2,-2", "--look-at", "0,0.1,0", "--up", "0,1,0.1", "--fov", "40", "-o", "x.png")
        self.assertEqual(picture, self.bytes("x.png"))
        pixels = harness.read_png(picture)
        self.assertGreater(len({pixel for row in pixels for pixel in row}), 20, "the picture is empty")

    def test_pictures_that_cannot_be(self):
        page = self.serve("s.obj", *QUICK)
        good = {"recipe": page.recipe(), "width": 8, "height": 8}
        self.assertEqual(page.post("picture", good)[0], 200)
        for wrong in ({"width": 0}, {"width": 5000}, {"width": -1}, {"width": 1.5}, {"width": "8"}, {"samples": 5},
                      {"colour": "x"}, {"view": []}, {"view": {"eye": [0, 0]}}, {"view": {"eye": "x"}},
                      {"view": {"eye": [1, 1, 1], "lookAt": [1, 1, 1]}}, {"view": {"fov": 1000}},
                      {"view": {"up": [0, 0, 0]}}):
            status, answer = page.post("picture", {**good, **wrong})
            self.assertEqual(status, 400, (wrong, answer))

    LOOK = {"material": "bronze", "light": "60,25", "sky": "0.6", "exposure": "0.5", "ground": "true", "background": "#203040"}
    VIEW = {"eye": [1.5, 1.2, -2], "lookAt": [0, 0.1, 0], "up": [0, 1, 0], "fov": 40}

    # Promise of explore.md: "*Material*, *Light*, *Sky*, *Exposure*, *Ground* and *Background* are the options of `juliavdb
    #   render`", and *Copy picture command* gives that of the exact picture
    def test_the_light_of_a_picture_is_that_of_the_command(self):
        page = self.serve("s.obj", *QUICK)
        body = {"recipe": page.recipe(), "width": 60, "height": 40, "view": self.VIEW}
        plain = page.post("picture", body)[1]
        shown = {plain}
        for name, value in self.LOOK.items():
            status, picture = page.post("picture", {**body, "look": {name: value}})
            self.assertEqual(status, 200, picture)
            self.assertNotIn(picture, shown, name)
            shown.add(picture)
        # The page gives the command of the same picture.
        status, answer = page.post("command", {**body, "look": self.LOOK, "name": "a"})
        self.assertEqual(status, 200, answer)
        words = shlex.split(answer["picture"])
        self.assertEqual(words[:3], ["juliavdb", "render", "--field"])
        self.ok(*words[1:])
        self.assertEqual(self.bytes("a.png"), page.post("picture", {**body, "look": self.LOOK})[1])
        # Without a background a picture has alpha.
        cut = page.post("picture", {**body, "look": {"background": "none"}})[1]
        self.assertEqual((cut[25], plain[25]), (6, 2))

    # Promise: "*Material*, *Light*, *Sky*, *Exposure*, *Ground* ..."
    # Promise: "What the program refuses ..."
    def test_what_a_look_says_is_read_by_the_program(self):
        page = self.serve("s.obj", *QUICK)
        usual = page.post("look", {"look": {}})[1]
        self.assertEqual(usual["material"], page.get("start")[1]["materials"]["clay"])
        self.assertEqual(usual["light"], [-48, 41])
        for name, value in self.LOOK.items():
            self.assertNotEqual(page.post("look", {"look": {name: value}})[1], usual, name)
        for name, wrong in (("material", "brnze"), ("light", "1"), ("light", "0,100"), ("sky", "-1"), ("exposure", "11"), ("background", "red")):
            status, answer = page.post("look", {"look": {name: wrong}})
            self.assertEqual(status, 400, answer)
            self.assertIn(f"--{name}", answer["error"])
            self.assertIn(wrong, answer["error"])
            # The same words as of the command.
            run = self.run_program("render", "--field", "s.obj", f"--{name}={wrong}", "-o", "x.png")
            self.assertEqual(f"juliavdb: {answer['error']}", run.stderr.decode().strip())
        for wrong in (7, [], {"nosuch": "1"}, {"sky": 1}):
            self.assertEqual(page.post("look", {"look": wrong})[0], 400, wrong)

    # Promise of explore.md: "A gradient runs over the numbers that occur", "or over a range of your own"
    def test_the_colours_of_a_scene_have_the_range_of_the_command(self):
        """A range that the page is told makes the picture that has none."""
        page = self.serve("s.obj", *QUICK)
        self.assertEqual(page.post("colouring", {"recipe": page.recipe()})[1], {"by": "clay", "stops": []})
        body = {"width": 40, "height": 40}
        for by in ("trap", "iterations", "depth"):
            status, found = page.post("colouring", {"recipe": page.recipe(colour=f"{by}:inferno")})
            self.assertEqual(status, 200, found)
            self.assertLess(found["low"], found["high"])
            self.assertEqual(len(found["stops"]), 10)
            self.assertEqual("distance" in found, by == "depth")
            pictures = [page.post("picture", {**body, "recipe": page.recipe(colour=text)})[1] for text in
                        (f"{by}:inferno", f"{by}:inferno:{found['low']!r}:{found['high']!r}", by)]
            self.assertTrue(pictures[0] == pictures[1] != pictures[2], by)
        given = page.post("colouring", {"recipe": page.recipe(colour="trap:#102030,#ffffff:0.1:0.9")})[1]
        self.assertEqual((given["low"], given["high"]), (0.1, 0.9))
        self.assertEqual(given["stops"], [[0x10 / 255, 0x20 / 255, 0x30 / 255], [1, 1, 1]])
        for wrong in ("trap:inferno:0.9:0.1", "trap:inferno:0.5:0.5", "trap:infrno", "trap:#12,#ffffff", "clay:inferno"):
            status, answer = page.post("colouring", {"recipe": page.recipe(colour=wrong)})
            self.assertEqual(status, 400, answer)
            self.assertIn(f"--colour is '{wrong}'", answer["error"])

    # Promise of explore.md: "*Mesh preview* shows the mesh that *Make* makes, at the resolution that stands there, by the same
    #   camera and in the same light"
    def test_the_mesh_and_what_was_made_are_seen_by_the_same_camera(self):
        page = self.serve("s.obj", *QUICK)
        frame = page.post("scene", {"recipe": page.recipe()})[1]["frame"]
        centre, radius = frame["centre"], frame["radius"]
        body = {"width": 60, "height": 60, "look": {"material": "jade"},
                "view": {"eye": [centre[0], centre[1] + radius, centre[2] + 4 * radius], "lookAt": centre, "up": [0, 1, 0], "fov": 30}}
        coarse = {**body, "recipe": page.recipe(), "mesh": True, "resolution": "20"}
        status, mesh = page.post("picture", coarse)
        self.assertEqual(status, 200, mesh)
        self.assertNotEqual(mesh, page.post("picture", {**coarse, "resolution": "40"})[1])

        def covered(picture):
            return {(x, y) for y, row in enumerate(harness.read_png(picture)) for x, pixel in enumerate(row) if max(pixel[:3]) - min(pixel[:3]) > 12}

        self.assertGreater(len(covered(mesh)), 200)
        field = covered(page.post("picture", {**body, "recipe": page.recipe()})[1])
        self.assertGreater(len(field & covered(mesh)) / len(field | covered(mesh)), 0.8)
        # Files in which another axis points up are turned back.
        for name, recipe, formats in (("a", {}, ["vdb", "ply"]), ("b", {"up": "z"}, ["ply"]), ("c", {"up": "z"}, ["vdb"]), ("d", {}, ["stl"])):
            job = self.make(page, recipe=page.recipe(resolution="20", **recipe), name=name, formats=formats)
            self.assertEqual(page.wait_for(job)["state"], "done")
            status, made = page.post("made", {**body, "job": job})
            self.assertEqual(status, 200, made)
            if name == "a":
                self.assertTrue(made == mesh, "the file holds that mesh")
            self.assertGreater(len(covered(made) & covered(mesh)) / len(covered(made) | covered(mesh)), 0.95, name)
        self.path("b.ply").unlink()
        status, answer = page.post("made", {**body, "job": 2})
        self.assertEqual(status, 422, answer)
        self.assertIn("b.ply", answer["error"])
        for nothing in (99, "1", None, -1):
            self.assertEqual(page.post("made", {**body, "job": nothing})[0], 404)
        # What is finer than the voxels, in the words of the command.
        finer = page.post("advice", {"recipe": page.recipe(texture="fur"), "resolution": "16"})[1]["finer"]
        run = self.run_program("fractal", "s.obj", *QUICK[:2], *QUICK[4:], "--texture", "fur", "--resolution", "16", "-o", "x.vdb", "--progress", "none")
        self.assertIn(finer or "wrote", run.stderr.decode() + run.stdout.decode())

    def test_a_dropped_connection_ends_its_picture(self):
        page = self.serve("s.obj", "--detail", "0.5", "--resolution", "30", "--sdf-resolution", "40")
        body = json.dumps({"recipe": page.recipe(iterations=20), "width": 4000, "height": 4000, "samples": 16,
                           "epsilon": 1e-6, "alphaClarity": 1e-5})
        connection = page.connect()
        connection.request("POST", f"/{page.key}/picture", body, {"Content-Type": "application/json"})
        def work(seconds):
            """That the server does meanwhile, in seconds of a processor."""
            before = harness.cpu_seconds(page.process)
            time.sleep(seconds)
            return harness.cpu_seconds(page.process) - before

        # A picture takes minutes, and a server that waits does nothing.
        end = time.monotonic() + harness.TIMEOUT
        while work(0.5) < 0.1:
            self.assertLess(time.monotonic(), end, "the picture is not being made")
        connection.close()
        most = harness.cpu_seconds(page.process) + 2 * harness.SOON
        while work(1) > 0.03:
            self.assertLess(harness.cpu_seconds(page.process), most, "the picture is still being made")
        self.assertEqual(page.get("jobs")[0], 200)

    # --------------------------------------------------------------------------------------------------------- jobs

    def make(self, page, **body):
        status, answer = page.post("make", {"recipe": page.recipe(), "name": "look", "formats": ["vdb"], **body})
        self.assertEqual(status, 200, answer)
        return answer["job"]

    # Promise of explore.md: "*Copy command* gives the command line that makes the same files"
    def test_make_gives_the_bytes_of_the_command_that_the_page_shows(self):
        self.path("out").mkdir()
        page = self.serve("s.obj", "--folder", "out", *QUICK)
        formats = ["vdb", "ply", "obj", *({"nvdb"} & set(page.get("start")[1]["formats"]))]
        body = {"recipe": page.recipe(detail="0.45", texture="random", texture_roots="4"), "name": "My look.1",
                "formats": formats, "resolution": 31}
        # Scenes before it leave nothing in it.
        page.post("scene", {"recipe": page.recipe(detail="0.9")})
        status, answer = page.post("make", body)
        self.assertEqual(status, 200, answer)
        job = page.wait_for(answer["job"])
        self.assertEqual((job["state"], job["files"], job["share"]), ("done", [f"My look.1.{name}" for name in formats], 1), job)
        made = {name: self.path("out").joinpath(name).read_bytes() for name in job["files"]}
        for name in job["files"]:
            self.path("out").joinpath(name).unlink()
        command = page.post("command", body)[1]["command"]
        self.assertTrue(command.startswith("juliavdb fractal s.obj "), command)
        script = command.replace("juliavdb fractal", '"$JULIAVDB" fractal')
        subprocess.run(["sh", "-c", script], cwd=self.folder, env=harness.environment({"JULIAVDB": harness.program()}),
                       check=True, stderr=subprocess.PIPE)
        self.assertEqual({name: self.path("out").joinpath(name).read_bytes() for name in made}, made)

    # Promise: "the program says how many, as do tasks ..."
    def test_a_job_tells_what_halves_cannot_hold(self):
        self.write("large.obj", harness.obj(harness.moved(harness.torus(around=24, across=12), 1e6, (0, 0, 0))))
        for target, expected in (("s.obj", 0), ("large.obj", 1)):
            page = self.serve(target, "--half", *QUICK)
            job = page.wait_for(self.make(page, name=target))
            self.assertEqual((job["state"], len(job["warnings"])), ("done", expected), job)
        self.assertRegex(job["warnings"][0], r"^\d+ values of the grid surface are beyond what 16 bits hold")

    # Promise of motion.md: "The page of `explore` shows the target at rest. What it makes, and the commands that it writes,
    #   follow the pose"
    def test_a_target_that_moves_is_shown_at_rest_and_made_in_its_pose(self):
        points, faces = harness.torus(around=24, across=12)
        self.write("pose.obj", harness.obj(([(x, y + 0.4 * x * x, z) for x, y, z in points], faces)))
        still, page = self.serve("s.obj", *QUICK), self.serve("pose.obj", "--rest", "s.obj", *QUICK)
        target = page.get("start")[1]["target"]
        self.assertEqual((target["name"], target["atRest"]), ("pose.obj", True))
        self.assertFalse(still.get("start")[1]["target"]["atRest"])
        self.assertEqual(page.raw("GET", "target")[2], still.raw("GET", "target")[2])
        for options in ({}, {"detail": "0.6"}):
            shown = [one.post("picture", {"recipe": one.recipe(**options), "width": 40, "height": 30}) for one in (still, page)]
            self.assertEqual(shown[0], shown[1])
        status, answer = page.post("make", {"recipe": page.recipe(detail="0.6"), "name": "look", "formats": ["ply"]})
        self.assertEqual((status, page.wait_for(answer["job"])["state"]), (200, "done"))
        made = self.bytes("look.ply")
        self.ok("fractal", "pose.obj", "--rest", "s.obj", "--detail", 0.6, *QUICK, "--mesh", "one.ply")
        self.assertEqual(harness.read_ply(made).points, harness.read_ply(self.bytes("one.ply")).points)

    # Promise of explore.md: A frame between keys is "blended as `juliavdb plan frames` does it", and the command "plans these
    #   frames"
    def test_a_sequence_is_that_of_the_command_that_the_page_shows(self):
        page = self.serve("s.obj", *QUICK)
        keys = [{"frame": frame, "recipe": page.recipe(**options)} for frame, options in
                ((2, {"detail": "0.2", "texture": "fur", "origin_shift": "0,0,0"}),
                 (4, {"detail": "0.5", "texture": "fur", "texture_seed": "8", "origin_shift": "0,0.1,0"}),
                 (5, {"detail": "0.5", "texture": "coral", "texture_seed": "8", "origin_shift": "0,0.1,0"}))]
        for key in keys:
            status, answer = page.post("sequence", {"keys": keys, "frame": key["frame"]})
            self.assertEqual((status, answer["recipe"]), (200, key["recipe"]))
        status, answer = page.post("sequence", {"keys": keys, "frame": 3, "ease": "smooth", "name": "a b"})
        self.assertEqual((status, answer["frames"]), (200, "2-5"), answer)
        between = answer["recipe"]
        self.assertEqual((between["detail"], between["origin-shift"]), ("0.35", "0,0.05,0"))
        # What cannot be between stays until the next key.
        self.assertEqual((between["texture"], between["texture-seed"]), ("fur", "3"))
        words = shlex.split(answer["command"])
        self.assertEqual(words[:3], ["juliavdb", "plan", "frames"])
        self.ok(*words[1:])
        folder = words[words.index("-o") + 1]
        for index, frame in enumerate((2, 3, 4, 5), 1):
            self.ok("task", folder, "--index", index)
            recipe = page.post("sequence", {"keys": keys, "frame": frame, "ease": "smooth"})[1]["recipe"]
            status, job = page.post("make", {"recipe": recipe, "name": f"frame{frame}", "formats": ["vdb"]})
            self.assertEqual((status, page.wait_for(job["job"])["state"]), (200, "done"))
            # The files hold the same grids; their recipes name the same numbers.
            made, planned = self.path(f"frame{frame}.vdb"), self.path(folder) / "out" / f"a b.{frame:04}.vdb"
            self.assertEqual(made.read_bytes(), planned.read_bytes())

    # Promise: A frame between keys is "blended ..."
    def test_sequences_that_cannot_be(self):
        page = self.serve("s.obj", *QUICK)
        a, b = page.recipe(detail="0.2", texture="fur"), page.recipe(detail="0.5", texture="fur")
        both = [{"frame": 1, "recipe": a}, {"frame": 9, "recipe": b}]
        for body, words in (({"keys": both[:1]}, "2 to 100 keys"), ({"keys": both * 51}, "2 to 100 keys"), ({}, "2 to 100 keys"),
                            ({"keys": [both[0], {"frame": 1, "recipe": b}]}, "two keys"),
                            ({"keys": [both[0], {"frame": 9, "recipe": a}]}, "all keys have the same look"),
                            ({"keys": [both[0], {"frame": -1, "recipe": b}]}, "'frame' must be"),
                            ({"keys": [both[0], {"frame": 100000, "recipe": b}]}, "'frame' must be"),
                            ({"keys": [both[0], 7]}, "a key must be an object"),
                            ({"keys": [both[0], {"frame": 9, "recipe": page.recipe(detail="7")}]}, "--detail"),
                            ({"keys": both, "ease": "bouncy"}, "linear, smooth, step"), ({"keys": both, "name": "../x"}, "../x"),
                            ({"keys": both, "frame": "3"}, "'frame' must be")):
            status, answer = page.post("sequence", body)
            self.assertEqual(status, 400, answer)
            self.assertIn(words, answer["error"])
        # Another file than those of the command line.
        self.write("t.obj", harness.obj(harness.snowman()))
        other = [both[0], {"frame": 9, "recipe": {**b, "input": "t.obj"}}]
        self.assertEqual(page.post("sequence", {"keys": other})[0], page.post("scene", {"recipe": other[1]["recipe"]})[0])
        self.assertNotEqual(page.post("sequence", {"keys": other})[0], 200)

    def test_two_jobs_one_after_the_other(self):
        page = self.serve("s.obj", *QUICK)
        first = self.make(page, name="a", resolution=60)
        second = self.make(page, name="b", formats=["ply", "obj", "stl"])
        self.assertLess(first, second)
        status, answer = page.post("make", {"recipe": page.recipe(), "name": "b", "formats": ["vdb"]})
        self.assertEqual(status, 400, "the name is taken")
        running = []
        while page.job(second)["state"] not in ("done", "failed"):
            running.append(sum(job["state"] == "running" for job in page.get("jobs")[1]))
        self.assertLessEqual(max(running, default=0), 1)
        self.assertEqual([page.job(n)["state"] for n in (first, second)], ["done", "done"])
        self.assertEqual(set(self.listing()), {"s.obj", "a.vdb", "b.ply", "b.obj", "b.stl"})
        self.assertEqual(page.job(first)["recipe"]["resolution"], "60")

    def test_cancel_leaves_nothing(self):
        page = self.serve("s.obj", *QUICK)
        before = self.listing()
        first = self.make(page, name="a", resolution=1500, formats=["vdb", "ply"])
        second = self.make(page, name="b")
        job = page.wait_for(first, ("running",))
        while not page.job(first)["phase"] or self.listing() == before:
            time.sleep(0.02)
        self.assertNotEqual(self.listing(), before, "the file has no place yet")
        self.assertEqual(page.delete(f"jobs/{first}"), 200)
        self.assertEqual(page.wait_for(first)["state"], "cancelled")
        self.assertEqual(page.wait_for(second)["state"], "done", "the next one is made")
        self.assertEqual(self.listing(), sorted(before + ["b.vdb"]))
        third = self.make(page, name="c", resolution=1500)
        fourth = self.make(page, name="d")
        self.assertEqual(page.delete(f"jobs/{fourth}"), 200, "one that waits")
        self.assertEqual(page.delete(f"jobs/{third}"), 200)
        self.assertEqual({page.wait_for(n)["state"] for n in (third, fourth)}, {"cancelled"})
        self.assertEqual(self.listing(), sorted(before + ["b.vdb"]))
        for nothing in ("99", "0", "-1", "x", "", "1/2"):
            self.assertEqual(page.delete("jobs/" + nothing), 404)
        self.assertIsNotNone(job)

    def test_a_job_that_fails_says_why(self):
        page = self.serve("s.obj", *QUICK)
        job = page.wait_for(self.make(page, recipe=page.recipe(box="50,50,50,51,51,51")))
        self.assertEqual(job["state"], "failed")
        run = self.run_program("fractal", "s.obj", *QUICK, "--box", "50,50,50,51,51,51", "-o", "x.vdb")
        self.assertEqual("juliavdb: " + job["error"], run.stderr.decode().strip().splitlines()[-1])
        self.assertEqual(self.listing(), ["s.obj"])

    # Promise: "the page can read no other ..."
    def test_nothing_is_replaced_unasked(self):
        page = self.serve("s.obj", *QUICK)
        self.write("look.vdb", "mine")
        body = {"recipe": page.recipe(), "name": "look", "formats": ["vdb"]}
        status, answer = page.post("make", body)
        self.assertEqual(status, 400)
        self.assertIn("look.vdb", answer["error"])
        self.assertEqual(self.bytes("look.vdb"), b"mine")
        self.path("link.vdb").symlink_to("/nowhere/else")
        self.assertEqual(page.post("make", {**body, "name": "link", "overwrite": True})[0], 400)
        job = page.wait_for(self.make(page, overwrite=True))
        self.assertEqual(job["state"], "done", job)
        self.assertNotEqual(self.bytes("look.vdb"), b"mine")

    # Promise: "No output replaces an input", through ...
    def test_no_input_is_replaced(self):
        """Not even where the page allows it: the target, a picture of the look, the fractal that is shown."""
        self.ok("fractal", "s.obj", *QUICK, "-o", "look.vdb")
        before = {name: self.bytes(name) for name in ("s.obj", "look.vdb")}
        os.link(self.path("s.obj"), self.path("hard.ply"))
        page = self.serve("look.vdb")
        for name, kind in (("s", "obj"), ("hard", "ply"), ("look", "vdb")):
            body = {"recipe": page.recipe(), "name": name, "formats": [kind], "overwrite": True}
            status, answer = page.post("make", body)
            self.assertEqual(status, 400, answer)
            self.assertIn(f"{name}.{kind}", answer["error"])
        self.assertEqual({name: self.bytes(name) for name in before}, before)

    # Promise: "No output replaces an input", through ...
    def test_the_targets_of_recipes_are_inputs(self):
        """Also where only the voxels are used: the target is a level set that a recipe has made."""
        self.ok("sdf", "s.obj", "-o", "level.vdb", "--resolution", 24)
        before = self.bytes("s.obj")
        page = self.serve("level.vdb", *QUICK[2:])
        body = {"recipe": page.recipe(), "name": "s", "formats": ["obj"], "overwrite": True}
        status, answer = page.post("make", body)
        self.assertEqual(status, 400, answer)
        self.assertIn("s.obj", answer["error"])
        self.assertEqual(self.bytes("s.obj"), before)

    # ---------------------------------------------------------------------------------------------- recipes of files

    # Promise: A target or a control "whose ..."
    def test_a_target_that_has_changed_is_read_again(self):
        """All that the page shows is of the file as it is now, also where the same look was kept."""
        first = self.bytes("s.obj")
        page = self.serve("s.obj", *QUICK)
        body = {"recipe": page.recipe()}

        def shown():
            return (page.post("scene", body)[1]["exponent"]["id"], page.post("picture", {**body, "width": 40, "height": 40})[1],
                    page.get("target")[1])

        before = shown()
        self.assertEqual(shown(), before)
        # With the time of the old one, as a copy may have it.
        times = os.stat(self.path("s.obj"))
        self.write("s.obj", harness.obj(harness.lumpy()))
        os.utime(self.path("s.obj"), ns=(times.st_atime_ns, times.st_mtime_ns))
        after = shown()
        for old, new in zip(before, after):
            self.assertNotEqual(old, new)
        with Server(self.folder, "s.obj", *QUICK) as fresh:
            self.assertEqual(after[1], fresh.post("picture", {**body, "width": 40, "height": 40})[1])
        self.write("s.obj", first)
        self.assertEqual(shown(), before)

    # Promise of explore.md: What is made, saved or exported "can be dropped on the page"
    def test_the_recipe_of_what_was_made(self):
        page = self.serve("s.obj", *QUICK)
        words = QUICK[:-2]
        self.ok("fractal", "s.obj", *words, "--detail", "0.35", "--map", "shape-modulus", "-o", "a.vdb", "--mesh", "a.ply")
        self.ok("fractal", "s.obj", *words, "--detail", "0.35", "--mesh", "a.obj")
        expected = {"input": "s.obj", "detail": "0.35", "sdf-resolution": "32", "resolution": "24", "texture-seed": "3"}
        names = ["a.vdb", "a.ply", "a.obj"]
        if "glb" in page.get("start")[1]["formats"]:
            self.ok("fractal", "s.obj", *words, "--detail", "0.35", "--mesh", "a.glb")
            names.append("a.glb")
        for name in names:
            data = self.bytes(name)
            for part in (data, data[:20000]):
                status, answer = page.post(f"recipe?name={name}", part, "application/octet-stream")
                self.assertEqual((status, answer.get("recipe"), answer.get("note")), (200, expected, None), name)
        self.write("other.obj", harness.obj(harness.cube()))
        self.ok("fractal", "other.obj", *words[2:], "--detail", "0.35", "--sdf-resolution", "20", "-o", "b.vdb")
        status, answer = page.post("recipe?name=b.vdb", self.bytes("b.vdb"), "application/octet-stream")
        self.assertEqual((status, answer["recipe"]), (200, expected), "over the target at hand")
        self.assertIn("other.obj", answer["note"])
        text = "# a look\ndetail = 0.35\nversor-seed=3 # three\n\nrepair\n".replace("\nrepair", "\nrepair =")
        status, answer = page.post("recipe?name=look.txt", text.encode(), "application/octet-stream")
        self.assertEqual((status, answer["recipe"]), (200, {"detail": "0.35", "texture-seed": "3", "repair": "true"}))
        # What comes from the page names no file that the command line did not.
        text = "detail = texture:/etc/passwd:0:1\n"
        status, answer = page.post("recipe?name=look.txt", text.encode(), "application/octet-stream")
        self.assertEqual(status, 403, answer)

    # Promise: What is made, saved or exported ...
    def test_hostile_files(self):
        page = self.serve("s.obj", *QUICK)
        self.ok("fractal", "s.obj", *QUICK, "-o", "a.vdb", "--mesh", "a.ply")
        vdb, ply = self.bytes("a.vdb"), self.bytes("a.ply")
        hostile = [("a.vdb", b""), ("a.vdb", vdb[:8]), ("a.ply", b""), ("a.glb", b"glTF" + b"\xff" * 30), ("a.glb", b"")]
        for cut in range(8, 400, 7):
            hostile.append(("a.vdb", vdb[:cut]))
        count_at = 8 + 4 + 8 + 1 + 36
        for at in range(count_at, count_at + 200, 3):
            hostile.append(("a.vdb", vdb[:at] + b"\xff\xff\xff\x7f" + vdb[at + 4:]))
            hostile.append(("a.vdb", vdb[:at] + b"\xff\xff\xff\xff" + vdb[at + 4:]))
        hostile += [("a.ply", b"ply\n" + b"comment juliavdb julia_command fractal\n" * 100000),
                    ("a.ply", b"ply\ncomment juliavdb julia_command fractal\ncomment juliavdb julia_detail \xff\xfe\n"),
                    ("a.txt", b"\0" * 1000), ("a.txt", b"=\n"), ("a.txt", b"detail = 1\ndetail = 2"),
                    ("../../a.png", b"x"), ("", b"x"), ("a.vdb/", vdb), ("a.ply", vdb), ("a.vdb", ply)]
        for name, data in hostile:
            status, answer = page.post("recipe?name=" + name, data, "application/octet-stream")
            # A byte of a name or of a value that nothing reads may be anything.
            self.assertIn(status, (200, 400, 403, 422), (name, data[:40], answer))
            self.assertEqual(status == 200, "recipe" in answer)
        self.assertEqual(page.get("jobs")[0], 200)
        status = pathlib.Path(f"/proc/{page.process.pid}/status").read_text()
        self.assertLess(int(status.partition("VmHWM:")[2].split()[0]), 1500 * 1024, "kB: a size in a file was believed")

    # Promise: "Files above 1 GiB are refused ..."
    def test_files_that_do_not_fit_are_refused_before_they_are_begun(self):
        """Where addresses end; the page as WebAssembly has 4 GiB of them."""
        page = self.serve("s.obj", *QUICK)
        used = 1024 * int(re.search(r"VmSize:\s*(\d+) kB", pathlib.Path(f"/proc/{page.process.pid}/status").read_text())[1])
        resource.prlimit(page.process.pid, resource.RLIMIT_AS, (used + (1 << 30), used + (1 << 30)))
        body = {"recipe": page.recipe(), "name": "look", "formats": ["vdb"], "overwrite": True}
        job = page.wait_for(page.post("make", {**body, "resolution": "9000"})[1]["job"])
        self.assertEqual(job["state"], "failed")
        self.assertIn("the limit of address space (ulimit -v) leaves; --resolution ", job["error"])
        fits = int(re.search(r"--resolution (\d+) fits", job["error"])[1])
        self.assertTrue(100 < fits < 9000, fits)
        self.assertEqual(self.listing(), ["s.obj"])
        job = page.wait_for(page.post("make", {**body, "resolution": "30"})[1]["job"])
        self.assertEqual(job["state"], "done")

    # -------------------------------------------------------------------------------------------------------- export

    # Promise of explore.md: An exported page is one file that asks for nothing before its button *Make files* is pressed, "at no
    #   more than 160 places along an axis", and says how far it is off
    def test_export(self):
        self.ok("explore", "s.obj", *QUICK, "--export", "look.html")
        text = self.bytes("look.html").decode()
        self.assertTrue(text.startswith("<!DOCTYPE html>"))
        for outside in ("http://", "https://", 'src="page', 'href="page'):
            self.assertNotIn(outside, text)
        self.assertEqual(self.listing(), ["look.html", "s.obj"])
        exponent = json.loads(re.search(r'id="exported">(.*?)</script>', text, re.S).group(1))["scene"]["exponent"]
        self.assertLessEqual(max(exponent["dims"]), 160)
        self.assertGreater(exponent["error"], 0)
        for more in (("--port", "80"), ("--folder", "."), ("--open", "yes")):
            self.refused(harness.USAGE, "explore", "s.obj", "--export", "b.html", *more)


if __name__ == "__main__":
    harness.main()

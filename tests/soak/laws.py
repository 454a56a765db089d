# SPDX-License-Identifier: Apache-2.0
"""The laws that every recipe obeys, and the readers that check them. A law that is broken raises Broken."""

import collections
import json
import math
import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))
import harness  # noqa: E402

try:
    import pyopenvdb
except ImportError:  # the values of grids are not compared then
    pyopenvdb = None

# A refusal is documented for bad usage and for bad data; any other failure is a bug, as all files are there.
REFUSALS = (harness.USAGE, harness.BAD_DATA)
# Of the processor, not of the clock: a machine that does other things breaks no law.
SECONDS = 120
WALL_SECONDS = 7200
INFO_SHARE = 0.2  # of the meshes are measured by info


class Broken(Exception):
    """A law is broken. @param law: its name, by which shrinking knows the failure again"""

    def __init__(self, law, words):
        super().__init__(f"{law}: {words}")
        self.law = law


def require(holds, law, words):
    if not holds:
        raise Broken(law, words)


class Refused(Exception):
    """The program refuses the recipe, in the way it should."""


class Bench:
    """Runs of one recipe, in a folder of their own beside the inputs."""

    def __init__(self, inputs, folder, program=None):
        self.inputs, self.folder, self.program = inputs, folder, program or harness.program()
        self.runs = 0
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)

    def run(self, *words, program=None):
        self.runs += 1
        run = subprocess.run(["prlimit", f"--cpu={SECONDS}:{SECONDS + 5}", program or self.program, *words],
                             cwd=self.inputs, env=harness.environment(), stdin=subprocess.DEVNULL, capture_output=True,
                             timeout=WALL_SECONDS)
        require(run.returncode not in (-signal.SIGXCPU, -signal.SIGKILL), "time", f"not done in {SECONDS} s")
        return run

    def make(self, name, recipe, words, program=None):
        """One run of `fractal` into a new folder. @return the files that it wrote, by extension"""
        place = self.folder / name
        place.mkdir()
        at = os.path.relpath(place, self.inputs)
        outputs = (["-o", f"{at}/f.vdb"] if recipe.vdb else []) + (["--mesh", f"{at}/f{recipe.mesh}"] if recipe.mesh else [])
        before = sorted(os.listdir(self.inputs))
        run = self.run("fractal", "--progress", "none", *words, *outputs, program=program)
        said = run.stderr.decode(errors="replace")
        found = {p.suffix: p for p in sorted(place.iterdir())}
        require(sorted(os.listdir(self.inputs)) == before, "stray files", "among the inputs")
        require(run.stdout == b"", "stdout", f"has {run.stdout[:80]!r}")
        if run.returncode:
            require(run.returncode in REFUSALS, "exit code", f"{run.returncode}: {said.strip()[-600:]}")
            require(re.fullmatch(r"juliavdb: [^\n]*\S[^\n]*\n", said), "one line for a refusal", repr(said[-600:]))
            require(not found, "a refusal leaves nothing", f"{[p.name for p in found.values()]}: {said.strip()}")
            raise Refused(said.strip())
        require("juliavdb: " not in said, "exit code", f"0, with {said.strip()!r}")
        wanted = ({".vdb"} if recipe.vdb else set()) | ({recipe.mesh} if recipe.mesh else set())
        require(set(found) == wanted and len(list(place.iterdir())) == len(wanted), "stray files",
                str(sorted(p.name for p in place.iterdir())))
        return found


# -------------------------------------------------------------------------------------------------------------- meshes

Surface = collections.namedtuple("Surface", "points faces")
PLY_KINDS = {"float": "f", "double": "d", "uchar": "B", "uint": "I"}


def read_ply(data):
    head, mark, body = data.partition(b"end_header\n")
    lines = head.decode().splitlines()
    require(mark and lines[:2] == ["ply", "format binary_little_endian 1.0"], "readable", f"header {lines[:2]}")
    vertices, count = (int(line.split()[2]) for line in lines if line.startswith("element"))
    kinds = [line.split()[1:] for line in lines if line.startswith("property") and "list" not in line]
    layout = "<" + "".join(PLY_KINDS[kind] for kind, _ in kinds)
    size = struct.calcsize(layout)
    require(len(body) == vertices * size + 13 * count, "readable", "the length is not what the header says")
    rows = list(struct.iter_unpack(layout, body[:vertices * size]))
    for row in rows:
        require(all(map(math.isfinite, row)), "finite", f"vertex {row}")
    return Surface([r[:3] for r in rows], [f[1:] for f in struct.iter_unpack("<B3I", body[vertices * size:])])


def read_stl(data):
    """The points of an STL are those that have the same coordinates."""
    numbers, faces = {}, []
    for triangle in harness.read_stl(data):
        faces.append(tuple(numbers.setdefault(p, len(numbers)) for p in triangle))
    return Surface(list(numbers), faces)


def glb_parts(data):
    """@return the JSON and the binary chunk"""
    require(data[:4] == b"glTF" and struct.unpack_from("<I", data, 8)[0] == len(data), "readable", "not a whole GLB")
    size = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20:20 + size]), data[28 + size:]


def read_glb(data):
    """All levels of detail. A level may have a vertex for each of several normals, so points are told by place."""
    head, binary = glb_parts(data)

    def array(index, letter, width):
        accessor = head["accessors"][index]
        view = head["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", width * struct.calcsize(letter))
        return [struct.unpack_from(f"<{width}{letter}", binary, start + k * stride) for k in range(accessor["count"])]

    surfaces = []
    for node in head["nodes"]:
        if "mesh" not in node:
            continue
        by = node.get("translation", (0, 0, 0))
        for primitive in head["meshes"][node["mesh"]]["primitives"]:
            points = [tuple(map(sum, zip(p, by))) for p in array(primitive["attributes"]["POSITION"], "f", 3)]
            kind = {5125: "I", 5123: "H"}[head["accessors"][primitive["indices"]]["componentType"]]
            corners = [i for i, in array(primitive["indices"], kind, 1)]
            surfaces.append(Surface(points, list(zip(corners[::3], corners[1::3], corners[2::3]))))
    return surfaces


def surfaces_of(path):
    """@return the surfaces in a file: one, or one of each level of detail"""
    data = path.read_bytes()
    if path.suffix == ".ply":
        return [read_ply(data)]
    if path.suffix == ".obj":
        mesh = harness.read_obj(data)
        return [Surface(mesh.points, mesh.faces)]
    if path.suffix == ".stl":
        return [read_stl(data)]
    return read_glb(data)


def content(path):
    """What is in a mesh, without the recipe that it carries."""
    data = path.read_bytes()
    if path.suffix == ".ply":
        return data.partition(b"end_header\n")[2]
    if path.suffix == ".obj":
        return b"\n".join(line for line in data.splitlines() if not line.startswith(b"#"))
    return glb_parts(data)[1] if path.suffix == ".glb" else data


def check_surface(surface, recipe, low, high, exact):
    """@param exact: vertices are shared by number; otherwise, where two have fallen together, only edges are paired"""
    points, faces = surface.points, surface.faces
    require(faces, "a surface", "there is no triangle")
    require(all(math.isfinite(c) for p in points for c in p), "finite", "a vertex is not")
    require(all(0 <= k < len(points) for f in faces for k in f), "readable", "a face names a vertex that is not there")
    uses = collections.Counter()
    for a, b, c in faces:
        uses.update(((a, b), (b, c), (c, a)))
    if exact:
        require(all(len(set(f)) == 3 for f in faces), "2-manifold", "a face has a corner twice")
        twice = next((edge for edge, count in uses.items() if count > 1), None)
        require(twice is None, "2-manifold", f"the edge {twice and [points[k] for k in twice]} has a direction twice")
        require(len({k for f in faces for k in f}) == len(points), "2-manifold", "a vertex belongs to no face")
    ends = [edge for edge in uses if uses[edge] != uses[edge[::-1]] and edge[0] != edge[1]]
    sides = [[f(p[axis] for p in points) for axis in range(3)] for f in (min, max)]
    # The rounding of a float, and a share of the size for what is written as text.
    slack = 2**-22 * max(abs(c) for side in sides for c in side) + 1e-6 * max(h - l for l, h in zip(*sides))
    for a, b in ends:
        p, q = points[a], points[b]
        on = [{(axis, k) for k, side in enumerate(sides) for axis in range(3) if abs(end[axis] - side[axis]) <= slack}
              for end in (p, q)]
        # An adapted mesh may cut off the corner between two sides, by less than its tolerance.
        cut = may_be_cut(recipe) and (all(on) if recipe.has("adaptivity") or recipe.has("lod") else on[0] & on[1])
        require(cut, "closed", f"{len(ends)} open edges, such as {p} to {q}")
    if exact:
        check_fans(faces, len(points))
    if not ends:
        # The moment of faces about a corner of the box, exact enough for specks far from the origin.
        at = sides[0]
        volume = math.fsum(six_volumes(*(tuple(x - y for x, y in zip(points[k], at)) for k in f)) for f in faces)
        require(volume > 0, "outward", f"the volume is {volume / 6}")
    if recipe.value("up", "keep") != "keep" or recipe.value("target-up", "y") != "y":
        low, high = [min(low)] * 3, [max(high)] * 3
        low, high = [min(l, -h) for l, h in zip(low, high)], [max(h, -l) for l, h in zip(low, high)]
    if recipe.mesh == ".glb" and recipe.has("units"):
        metres = {"mm": 1e-3, "cm": 1e-2, "m": 1, "in": 0.0254}[recipe.value("units")]
        low, high = ([metres * c for c in end] for end in (low, high))
    for p in points:
        require(all(l <= c <= h for l, c, h in zip(low, p, high)), "in the box", f"{p} is outside {low}, {high}")


def may_be_cut(recipe):
    """Whether the set may reach the border of the region: at a box, and where a map has no shell that bounds its set, at the
    end of the target's surroundings or of the ball in which the set is searched."""
    return not recipe.has("cap") and (recipe.has("box") or recipe.value("map") != "shape-modulus")


def six_volumes(a, b, c):
    return (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] *
            (b[0] * c[1] - b[1] * c[0]))


def check_fans(faces, count):
    """The faces about a vertex are one fan: each is the neighbour of the next."""
    around = [[] for _ in range(count)]
    for a, b, c in faces:
        around[a].append((b, c))
        around[b].append((c, a))
        around[c].append((a, b))
    for vertex, pairs in enumerate(around):
        follows = dict(pairs)
        start = next(iter(set(follows) - set(follows.values())), pairs[0][0])
        at, seen = start, 0
        while at in follows and (seen == 0 or at != start):
            at, seen = follows[at], seen + 1
        require(seen == len(pairs), "2-manifold", f"the faces about vertex {vertex} are not one fan")


# ---------------------------------------------------------------------------------------------------------------- VDBs


def grids_of(path):
    """The active values of all grids."""
    found = {}
    for grid in pyopenvdb.readAllGridMetadata(str(path)):
        values = pyopenvdb.read(str(path), grid.name)
        found[grid.name] = {(item.min, item.max): item.value for item in values.citerOnValues()}
    return found


def check_grids(some, every):
    """The grids of all nodes that were evaluated have more of them when everything is evaluated; else nothing differs."""
    require(some.keys() == every.keys(), "exhaustive", "the grids are others")
    for name, values in some.items():
        if name not in ("logmodulus", "iterations"):
            require(values.keys() == every[name].keys(), "exhaustive", f"the active voxels of {name} differ")
        for place, value in values.items():
            require(every[name].get(place) == value, "exhaustive",
                    f"{name} at {place[0]} is {value}, and {every[name].get(place)}")


# ---------------------------------------------------------------------------------------------------------------- laws


def same_bytes(law, one, two):
    for extension in one:
        require(one[extension].read_bytes() == two[extension].read_bytes(), law, f"the bytes of f{extension} differ")


def check(bench, recipe, low, high, chance, other=None):
    """All laws. @param chance: what is drawn here, such as which file carries the recipe; @return names of the checks
    @throw Refused, Broken"""
    words = recipe.words()
    first = bench.make("first", recipe, [*words, "--threads", "1"])
    done = ["exit code"]
    if recipe.mesh:
        for surface in surfaces_of(first[recipe.mesh]):
            check_surface(surface, recipe, low, high, exact=recipe.mesh in (".ply", ".obj"))
        done.append("closed and 2-manifold")
    for path in first.values():
        # How thick a mesh is at each place takes info longer than all else takes: of most meshes only our own reader sees.
        if path.suffix != ".vdb" and chance.random() > INFO_SHARE:
            continue
        run = bench.run("info", os.path.relpath(path, bench.inputs), "--json")
        require(run.returncode == 0, "readable", run.stderr.decode(errors="replace").strip())
        grids = json.loads(run.stdout).get("grids", [])
        for grid in grids:
            require(grid.get("level set check", "passes") == "passes" or recipe.has("half"), "level set",
                    str(grid.get("level set check")))
    done.append("readable")

    def again(law, name, more, **options):
        try:
            made = bench.make(name, recipe, more, **options)
        except Refused as refusal:
            raise Broken(law, f"refused: {refusal}") from None
        done.append(law)
        return made

    same_bytes("threads", first, again("threads", "threads", [*words, "--threads", "3", "--instructions", "portable"]))
    carriers = [path for extension, path in first.items() if extension != ".stl"]
    if carriers:
        carrier = os.path.relpath(chance.choice(carriers), bench.inputs)
        same_bytes("round trip", first, again("round trip", "again", ["--config", carrier]))
    if not recipe.has("follow"):
        whole = again("exhaustive", "exhaustive", [*words, "--exhaustive"])
        if recipe.mesh:
            require(content(first[recipe.mesh]) == content(whole[recipe.mesh]), "exhaustive", "the meshes differ")
        if recipe.vdb and pyopenvdb and chance.random() < 0.3:
            check_grids(grids_of(first[".vdb"]), grids_of(whole[".vdb"]))
    if other:
        same_bytes("other build", first, again("other build", "other", [*words, "--threads", "1"], program=other))
    return done

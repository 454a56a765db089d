# SPDX-License-Identifier: Apache-2.0
"""What the tests of the program share: running it, small meshes and versors to feed it, readers for what it writes.

The readers are written here again on purpose: a test that read a file with the code that wrote it would prove little.
The program's path comes in the environment variable JULIAVDB.
"""

import collections
import concurrent.futures
import json
import math
import os
import pathlib
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

# Exit codes of the contract.
DONE, USAGE, BAD_DATA, NO_INPUT, INTERNAL, CANNOT_CREATE, IO_ERROR, INTERRUPTED = 0, 2, 65, 66, 70, 73, 74, 75

# What the program says of its own crash; no failure of a file or of the system may end in that.
CRASHED = "the program crashed"

BUNNY = pathlib.Path("/usr/share/glmark2/models/bunny.obj")

# Seconds for a run that should take one, on a machine that does other things too. A program that checks itself takes
# longer; the presets asan and tsan say by what factor.
TIMEOUT = 120 * int(os.environ.get("JULIAVDB_PATIENCE", 1))

# "Within a second", in seconds of a processor: a second of each, and some slack. By the clock it takes longer where other
# programs want the processors too, which says nothing about this one.
SOON = len(os.sched_getaffinity(0)) + 0.5


def program():
    path = os.environ.get("JULIAVDB")
    if not path:
        sys.exit("set JULIAVDB to the path of the program")
    return os.path.abspath(path)


def has_opencl():
    """Whether a driver of OpenCL is installed, as Debian's packages install it."""
    return any(pathlib.Path("/etc/OpenCL/vendors").glob("*.icd"))


def main():
    program()
    unittest.main(verbosity=2 if "-v" in sys.argv else 1)


def environment(extra=None):
    env = {name: value for name, value in os.environ.items() if not name.startswith(("SLURM_", "PARALLEL_SEQ"))}
    # What devices compile is kept by tests of that alone.
    env["JULIAVDB_DEVICE_CACHE"] = "none"
    env.update(extra or {})
    return env


def restore_interrupt():
    """A test that was started in the background of a shell has SIGINT ignored, and so would its children."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def cpu_seconds(process):
    """Of all threads of a process so far."""
    fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def ended_children():
    """The seconds of a processor that all processes took which this one has waited for."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def stop(process, by=signal.SIGINT):
    """Sends the signal to a Popen, and waits for its end; nothing else may be waited for meanwhile.
    @return what it wrote to stdout and stderr since, and the seconds of a processor that it took, to be held against SOON"""
    others, before = ended_children(), cpu_seconds(process)
    process.send_signal(by)
    stdout, stderr = process.communicate(timeout=TIMEOUT)
    return stdout, stderr, ended_children() - others - before


COMMANDS = ("sdf", "fractal", "convert", "fit", "mesh", "versor", "sheet", "slice", "study", "render", "info", "maps",
            "points", "print",
            "plan tiles", "plan frames", "plan sheet", "task", "status", "merge", "submit", "explore", "devices", "recipe")


def quiet(arguments):
    """The arguments without progress on stderr, which appears only where a machine is slow."""
    words = [str(argument) for argument in arguments]
    named = 2 if words[:1] == ["plan"] and words[1:2] in (["tiles"], ["frames"], ["sheet"]) else 1
    if " ".join(words[:named]) not in COMMANDS or any(word.startswith("--progress") for word in words):
        return arguments
    return (*words[:named], "--progress", "none", *arguments[named:])


class Copies:
    """Runs of the program as copies of one that has been started (tests/faults/started.cpp): each a process of its own, with
    one thread, and without the start, which costs more than a short run. Without the library they are started as ever.

    In a process that is short, fresh pages cost most of what is left, so they are large ones. No bit depends on any of this.
    One thread of a test may use it at a time.
    """

    def __init__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_copies_"))
        self.server = None
        library = os.environ.get("JULIAVDB_STARTED")
        if library:
            large = str(10**9)
            self.server = subprocess.Popen([program()], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment({
                "LD_PRELOAD": library, "LD_BIND_NOW": "1", "SLURM_CPUS_PER_TASK": "1", "MALLOC_MMAP_THRESHOLD_": large,
                "MALLOC_TRIM_THRESHOLD_": large, "MALLOC_TOP_PAD_": str(1 << 25), "GLIBC_TUNABLES": "glibc.malloc.hugetlb=1"}))

    def close(self):
        if self.server:
            self.server.communicate()
        shutil.rmtree(self.folder)

    def run(self, words, place):
        """@return the exit code, or less than 0 for a signal, and what is on stdout and stderr"""
        if not self.server:
            run = subprocess.run([program(), *map(str, words)], cwd=place, env=environment(), stdin=subprocess.DEVNULL,
                                 capture_output=True, timeout=TIMEOUT)
            return run.returncode, run.stdout, run.stderr
        said = [self.folder / "stdout", self.folder / "stderr"]
        strings = [place, *said, TIMEOUT, *words]
        self.server.stdin.write(b"%d\n" % len(strings) + b"".join(os.fsencode(str(each)) + b"\0" for each in strings))
        self.server.stdin.flush()
        status = int(self.server.stdout.readline())
        return os.waitstatus_to_exitcode(status), *(file.read_bytes() for file in said)


class CliTest(unittest.TestCase):
    """A test in a folder of its own, which it leaves behind nowhere."""

    maxDiff = 2000

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_test_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, name):
        return self.folder / name

    def write(self, name, content):
        data = content.encode() if isinstance(content, str) else content
        self.path(name).write_bytes(data)
        return name

    def bytes(self, name):
        return self.path(name).read_bytes()

    def listing(self):
        return sorted(str(p.relative_to(self.folder)) for p in self.folder.rglob("*"))

    def run_program(self, *arguments, env=None, stdout=subprocess.PIPE, **options):
        return subprocess.run(
            [program(), *map(str, arguments)], cwd=self.folder, env=environment(env), stdin=subprocess.DEVNULL,
            stdout=stdout, stderr=subprocess.PIPE, timeout=TIMEOUT, **options)

    def ok(self, *arguments, env=None, data=False):
        """Runs to success. @return stderr, or stdout where the command's result is data."""
        # What submit is told of progress is a part of the script that it prints.
        asked = arguments[:1] == ("submit",) or any(str(word).startswith(("--help", "--describe")) for word in arguments)
        run = self.run_program(*(quiet(arguments) if data and not asked else arguments), env=env)
        words = " ".join(map(str, arguments))
        self.assertEqual(run.returncode, DONE, f"juliavdb {words}\n{run.stderr.decode(errors='replace')}")
        if data:
            self.assertEqual(run.stderr, b"", f"juliavdb {words} has data for an output, and nothing else to say")
            return run.stdout.decode()
        self.assertEqual(run.stdout, b"", f"juliavdb {words}: stdout is for data only")
        self.assertNotIn(b"juliavdb: ", run.stderr, f"juliavdb {words} reports a failure, yet exits with 0")
        return run.stderr.decode()

    def check_refusal(self, run, code, words):
        text = run.stderr.decode(errors="replace")
        self.assertEqual(run.returncode, code, f"juliavdb {words}\n{text}")
        self.assertRegex(text, r"\Ajuliavdb: [^\n]*\S[^\n]*\n\Z", f"juliavdb {words}: not one line for one failure")
        self.assertNotIn(CRASHED, text, f"juliavdb {words}")
        if run.stdout is not None:
            self.assertEqual(run.stdout, b"", f"juliavdb {words}: stdout is for data only")
        return text

    def refused(self, code, *arguments, env=None, mentions=(), **options):
        """Runs to a failure with one line of explanation, which leaves no file behind. @return that line"""
        before = self.listing()
        run = self.run_program(*quiet(arguments), env=env, **options)
        words = " ".join(map(str, arguments))
        text = self.check_refusal(run, code, words)
        for mention in [mentions] if isinstance(mentions, str) else mentions:
            self.assertIn(mention, text, f"juliavdb {words}")
        self.assertEqual(self.listing(), before, f"juliavdb {words} failed and left files behind")
        return text

    def all_refused(self, code, cases, mentions=()):
        """Many refusals at once: to load the program takes longer than to refuse."""
        before = self.listing()
        with concurrent.futures.ThreadPoolExecutor(max(2, os.cpu_count() or 1)) as pool:
            runs = list(pool.map(lambda case: self.run_program(*quiet(case)), cases))
        for case, run in zip(cases, runs):
            words = " ".join(map(str, case))
            with self.subTest(words=words):
                text = self.check_refusal(run, code, words)
                for mention in [mentions] if isinstance(mentions, str) else mentions:
                    self.assertIn(mention, text)
        self.assertEqual(self.listing(), before, "a refused run left files behind")

    def info(self, name):
        return json.loads(self.ok("info", name, "--json", data=True))


# ---------------------------------------------------------------------------------------------------------- meshes in


class TextureTest(CliTest):
    """Fractals of the target t.obj, which a test writes, with options for their texture."""

    LOW = ("--resolution", 40, "--sdf-resolution", 40)

    def mesh(self, *options):
        self.ok("fractal", "t.obj", *self.LOW, *options, "--mesh", "x.ply")
        return read_ply(self.bytes("x.ply"))

    def points(self, *options):
        return self.mesh(*options).points

    def assert_the_same_in_all_ways(self, *options):
        """The mesh is closed, and the same if nothing is skipped, in one thread without vector instructions, and in tiles."""
        mesh = self.mesh(*options)
        self.assertEqual(open_edges(mesh), [])
        self.assertTrue(mesh.points == self.points(*options, "--exhaustive"))
        self.assertTrue(mesh.points == self.points(*options, "--threads", 1, "--instructions", "portable"))
        self.ok("plan", "tiles", "t.obj", *self.LOW, *options, "--tiles", 3, "-o", "plan")
        self.ok("submit", "plan", "--engine", "parallel", "--mesh", "tiles.ply")
        self.assertTrue(mesh.points == read_ply(self.bytes("tiles.ply")).points)
        shutil.rmtree(self.path("plan"))


def sphere(subdivisions=3, radius=1.0, centre=(0.0, 0.0, 0.0)):
    """An icosahedron, subdivided; faces turn counterclockwise seen from outside."""
    g = (1 + math.sqrt(5)) / 2
    points = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g),
              (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
             (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11),
             (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    unit = lambda p: tuple(c / math.sqrt(sum(x * x for x in p)) for c in p)
    points = [unit(p) for p in points]
    for _ in range(subdivisions):
        middles = {}

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(points)
                points.append(unit(tuple(x + y for x, y in zip(points[a], points[b]))))
            return middles[key]

        finer = []
        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = finer
    return [tuple(radius * x + c for x, c in zip(p, centre)) for p in points], faces


def torus(major=0.7, minor=0.3, around=32, across=16):
    points, faces = [], []
    for i in range(around):
        u = 2 * math.pi * i / around
        for j in range(across):
            v = 2 * math.pi * j / across
            r = major + minor * math.cos(v)
            points.append((r * math.cos(u), minor * math.sin(v), r * math.sin(u)))
    at = lambda i, j: (i % around) * across + j % across
    for i in range(around):
        for j in range(across):
            a, b, c, d = at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)
            faces += [(a, b, c), (a, c, d)]
    return points, faces


def cube(half=1.0):
    points = [(x, y, z) for z in (-half, half) for y in (-half, half) for x in (-half, half)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return points, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def lumpy():
    """A ball with swellings, the same from no two sides: for what a bunny would be too large for."""
    def swollen(x, y, z):
        r = 1 + 0.25 * math.sin(3 * x + 1) * math.cos(2 * y) + 0.2 * z * math.sin(4 * y + 2 * x)
        return r * x, r * y, 0.8 * r * z

    points, faces = sphere(3)
    return [swollen(*p) for p in points], faces


def snowman():
    """Two balls, one into the other: with a thick and a thin part."""
    points, faces = sphere(4)
    others, more = sphere(3, 0.45, (1.25, 0.3, 0.2))
    return points + others, faces + [tuple(corner + len(points) for corner in face) for face in more]


def needle(subdivisions=2):
    """What info has measured in a tenth of a second, and other shapes in two: there is little room about it."""
    points, faces = sphere(subdivisions)
    return [(x, 0.1 * y, 0.1 * z) for x, y, z in points], faces


def with_hole(mesh, above=0.7):
    """Without the faces at the top: a hole too wide for any voxel to span."""
    points, faces = mesh
    top = max(p[1] for p in points)
    return points, [f for f in faces if not all(points[k][1] > above * top for k in f)]


def moved(mesh, factor, by):
    points, faces = mesh
    return [tuple(factor * x + b for x, b in zip(p, by)) for p in points], faces


def obj(mesh):
    points, faces = mesh
    return "".join("v {!r} {!r} {!r}\n".format(*p) for p in points) + "".join(
        "f {} {} {}\n".format(*(k + 1 for k in f)) for f in faces)


def off(mesh):
    points, faces = mesh
    return f"OFF\n{len(points)} {len(faces)} 0\n" + "".join("{!r} {!r} {!r}\n".format(*p) for p in points) + "".join(
        "3 {} {} {}\n".format(*f) for f in faces)


def ply(mesh, vertices=None, count=None):
    """Binary PLY. @param vertices, count: what the header says, if it is to lie"""
    points, faces = mesh
    header = ("ply\nformat binary_little_endian 1.0\n"
              f"element vertex {len(points) if vertices is None else vertices}\n"
              "property float x\nproperty float y\nproperty float z\n"
              f"element face {len(faces) if count is None else count}\n"
              "property list uchar int vertex_indices\nend_header\n")
    return header.encode() + b"".join(struct.pack("<3f", *p) for p in points) + b"".join(
        struct.pack("<B3i", 3, *f) for f in faces)


def ply_text(mesh):
    points, faces = mesh
    return ("ply\nformat ascii 1.0\n" f"element vertex {len(points)}\n"
            "property float x\nproperty float y\nproperty float z\n" f"element face {len(faces)}\n"
            "property list uchar int vertex_indices\nend_header\n") + "".join(
                "{!r} {!r} {!r}\n".format(*p) for p in points) + "".join("3 {} {} {}\n".format(*f) for f in faces)


def stl(mesh, count=None):
    points, faces = mesh
    return bytes(80) + struct.pack("<I", len(faces) if count is None else count) + b"".join(
        struct.pack("<12fH", 0, 0, 0, *points[a], *points[b], *points[c], 0) for a, b, c in faces)


# -------------------------------------------------------------------------------------------------------- versors in


def quaternions(values):
    return struct.pack("<i", len(values)) + b"".join(struct.pack("<4d", *q) for q in values)


def p4d(roots, power_scale=1.0):
    """A polynomial of the released programs; roots are (a, b, c, d, power)."""
    return (struct.pack("<i", len(roots)) + 3 * quaternions([]) + quaternions([r[:4] for r in roots]) +
            struct.pack("<i", len(roots)) + b"".join(struct.pack("<d", r[4]) for r in roots) +
            struct.pack("<d", power_scale))


def field(resolutions, centre, lengths, values=None):
    count = resolutions[0] * resolutions[1] * resolutions[2]
    return struct.pack("<3i", *resolutions) + struct.pack("<3d", *centre) + struct.pack(
        "<3d", *lengths) + struct.pack(f"<{count}d", *(values or [0.0] * count))


def o3d(top, bottom, constant=1.0, resolutions=(2, 2, 2), centre=(0.0, 0.0, 0.0), lengths=(4.0, 4.0, 4.0)):
    return (struct.pack("<3i", *resolutions) + struct.pack("<3d", *centre) + struct.pack("<3d", *lengths) + p4d(top) +
            p4d(bottom) + struct.pack("<d", constant) + struct.pack("<i", 0) + 3 * field(resolutions, centre, lengths))


ROOTS = [(0.1, 0.2, -0.1, 0.0, 3.0), (-0.2, 0.05, 0.15, 0.0, 2.0), (0.25, -0.2, 0.1, 0.0, 4.0)]


def rational_json(top, bottom=(), log_scale=0.0):
    polynomial = lambda roots: {"powerScale": 1.0, "roots": [{"position": list(r[:4]), "power": r[4]} for r in roots]}
    return json.dumps({"juliavdb": "rational", "version": 1, "logScale": log_scale, "top": polynomial(top),
                       "bottom": polynomial(bottom)})


# ---------------------------------------------------------------------------------------------------------- meshes out

Mesh = collections.namedtuple("Mesh", "points faces normals comments doubles columns", defaults=({},))


def read_ply(data):
    """The binary PLY that the program writes, as strictly as the strictest reader."""
    head, mark, body = data.partition(b"end_header\n")
    assert mark, "the PLY has no end_header"
    lines = head.decode().splitlines()
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"], lines[:2]
    comments = dict(line.split(" ", 3)[2:4] for line in lines if line.startswith("comment juliavdb "))
    elements = [line.split(" ") for line in lines if line.startswith("element")]
    assert [words[:-1] for words in elements] == [["element", "vertex"], ["element", "face"]], elements
    vertices, count = (int(words[-1]) for words in elements)
    kinds = [line.split()[1:] for line in lines if line.startswith("property") and "list" not in line]
    layout = "<" + "".join({"float": "f", "double": "d"}[kind] for kind, _ in kinds)
    names = [name for _, name in kinds]
    assert names[:3] == ["x", "y", "z"] and "property list uchar uint vertex_indices" in lines, lines
    size = struct.calcsize(layout)
    assert len(body) == vertices * size + 13 * count, "the PLY has not the length that its header says"
    rows = list(struct.iter_unpack(layout, body[:vertices * size]))
    faces = list(struct.iter_unpack("<B3I", body[vertices * size:]))
    assert all(f[0] == 3 for f in faces), "not all faces are triangles"
    return Mesh([r[:3] for r in rows], [f[1:] for f in faces], [r[3:6] for r in rows] if "nx" in names else [],
                comments, layout.startswith("<d"), dict(zip(names, zip(*rows))))


def read_obj(data):
    points, faces, normals = [], [], []
    for line in data.decode().splitlines():
        words = line.split()
        if not words or words[0] == "#":
            continue
        if words[0] == "v":
            points.append(tuple(map(float, words[1:4])))
        elif words[0] == "vn":
            normals.append(tuple(map(float, words[1:4])))
        else:
            assert words[0] == "f" and len(words) == 4, line
            faces.append(tuple(int(w.split("/")[0]) - 1 for w in words[1:]))
    return Mesh(points, faces, normals, {}, True)


def read_stl(data):
    """@return triangles as triples of points"""
    count = struct.unpack_from("<I", data, 80)[0]
    assert len(data) == 84 + 50 * count, "the STL has not the length that its header says"
    return [(t[3:6], t[6:9], t[9:12]) for t in struct.iter_unpack("<12fH", data[84:])]


def triangles_of(mesh):
    return [tuple(mesh.points[k] for k in f) for f in mesh.faces]


def volume_of(mesh):
    def six(a, b, c):
        return (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] *
                (b[0] * c[1] - b[1] * c[0]))

    return math.fsum(six(*t) for t in triangles_of(mesh)) / 6


def area_of(mesh):
    def area(a, b, c):
        u, v = [y - x for x, y in zip(a, b)], [y - x for x, y in zip(a, c)]
        return math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2

    return math.fsum(area(*t) for t in triangles_of(mesh))


def edge_uses(mesh):
    """Of each directed edge, how often it stands in a face."""
    uses = collections.Counter()
    for a, b, c in mesh.faces:
        uses.update(((a, b), (b, c), (c, a)))
    return uses


def open_edges(mesh):
    uses = edge_uses(mesh)
    return [edge for edge in uses if uses[edge[::-1]] == 0]


# -------------------------------------------------------------------------------------------------------- pictures out


def png_size(data):
    assert data[:8] == b"\x89PNG\r\n\x1a\n" and data[12:16] == b"IHDR", "not a PNG"
    return struct.unpack(">2I", data[16:24])


def read_png(data):
    """8-bit RGB, not interlaced. @return rows of pixels (r, g, b)"""
    width, height = png_size(data)
    assert data[24:29] == bytes([8, 2, 0, 0, 0]), f"the PNG is not plain 8-bit RGB: {data[24:29]}"
    packed, at = b"", 8
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        content = data[at + 8:at + 8 + size]
        assert zlib.crc32(kind + content) == struct.unpack_from(">I", data, at + 8 + size)[0], f"checksum of {kind}"
        packed += content if kind == b"IDAT" else b""
        at += 12 + size
    raw = zlib.decompress(packed)
    stride = 3 * width
    assert len(raw) == height * (stride + 1)
    rows, above = [], bytearray(stride)
    for y in range(height):
        kind, line = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            left = line[i - 3] if i >= 3 else 0
            corner = above[i - 3] if i >= 3 else 0
            if kind == 1:
                line[i] = (line[i] + left) & 255
            elif kind == 2:
                line[i] = (line[i] + above[i]) & 255
            elif kind == 3:
                line[i] = (line[i] + (left + above[i]) // 2) & 255
            elif kind == 4:
                estimate = left + above[i] - corner
                distances = (abs(estimate - left), abs(estimate - above[i]), abs(estimate - corner))
                line[i] = (line[i] + (left, above[i], corner)[distances.index(min(distances))]) & 255
        rows.append([tuple(line[3 * x:3 * x + 3]) for x in range(width)])
        above = line
    return rows

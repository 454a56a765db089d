# SPDX-License-Identifier: Apache-2.0
"""The targets and the other files that random recipes name: small, and each awkward in a way of its own."""

import dataclasses
import math
import pathlib
import random
import struct
import subprocess
import sys
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))
import harness  # noqa: E402  the folder of the program's other tests


@dataclasses.dataclass
class Target:
    name: str  # of its file
    low: tuple  # the corners of its box
    high: tuple
    kind: str = "closed"  # or open, terrain, sheet, cloud: what it takes to make a solid of it; vdb: distances
    attributes: tuple = ()  # of its vertices
    uv: bool = False
    weight: float = 1  # how often it is drawn

    @property
    def size(self):
        """Its longest side, the unit of most lengths."""
        return max(h - l for l, h in zip(self.low, self.high))


def joined(*meshes):
    points, faces = [], []
    for more, triangles in meshes:
        faces += [tuple(k + len(points) for k in f) for f in triangles]
        points += more
    return points, faces


def stretched(mesh, factors):
    return [tuple(x * f for x, f in zip(p, factors)) for p in mesh[0]], mesh[1]


def twisted(mesh):
    """Turned about Y, by more the higher it is, and moved."""
    low, high = (tuple(f(p[axis] for p in mesh[0]) for axis in range(3)) for f in (min, max))
    size, middle = max(h - l for l, h in zip(low, high)), tuple((l + h) / 2 for l, h in zip(low, high))
    points = []
    for p in mesh[0]:
        x, y, z = (a - m for a, m in zip(p, middle))
        c, s = math.cos(0.6 * y / size), math.sin(0.6 * y / size)
        points.append((middle[0] + c * x - s * z + 0.1 * size, p[1], middle[2] + s * x + c * z))
    return points, mesh[1]


def spikes():
    """A ball whose points are drawn out to needles."""
    points, faces = harness.sphere(2)
    return [tuple(x * (2.5 if k % 7 == 0 else 1) for x in p) for k, p in enumerate(points)], faces


def crumbs():
    """One ball and many specks about it."""
    chance = random.Random(1)
    return joined(harness.sphere(2), *(harness.sphere(1, 0.03 + 0.07 * chance.random(), tuple(
        chance.uniform(-1.6, 1.6) for _ in range(3))) for _ in range(40)))


def hollow():
    """A ball with a hollow, whose wall is turned inwards."""
    points, faces = harness.sphere(2, 0.6)
    return joined(harness.sphere(3), (points, [f[::-1] for f in faces]))


def squares(n, height):
    points = [(2 * i / n - 1, height(2 * i / n - 1, 2 * j / n - 1), 2 * j / n - 1)
              for i in range(n + 1) for j in range(n + 1)]
    at = lambda i, j: i * (n + 1) + j
    return points, [f for i in range(n) for j in range(n)
                    for f in ((at(i, j), at(i, j + 1), at(i + 1, j + 1)), (at(i, j), at(i + 1, j + 1), at(i + 1, j)))]


def painted_ply(mesh):
    points, faces = mesh
    rows = "".join("{!r} {!r} {!r} {} 40 {} {!r}\n".format(*p, 255 if p[0] > 0 else 0, k % 256, p[1] / 2 + 0.5)
                   for k, p in enumerate(points))
    return (f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\n"
            "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float slope\n"
            f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n" + rows + "".join(
                "3 {} {} {}\n".format(*f) for f in faces))


def unwrapped_obj(mesh):
    points, faces = mesh
    return "".join("v {!r} {!r} {!r}\n".format(*p) for p in points) + "".join(
        "vt {!r} {!r}\n".format((p[0] + 1) / 2, (p[1] + 1) / 2) for p in points) + "".join(
            "f {0}/{0} {1}/{1} {2}/{2}\n".format(*(k + 1 for k in f)) for f in faces)


def cloud_ply(points):
    return (f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\n"
            "property float z\nend_header\n" + "".join("{!r} {!r} {!r}\n".format(*p) for p in points))


def png(width, height, pixel):
    """8-bit RGB. @param pixel: (column, row from the top) -> (r, g, b)"""
    rows = b"".join(b"\0" + bytes(c for x in range(width) for c in pixel(x, y)) for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def make(folder):
    """Writes all files into the folder. @return the targets"""
    folder.mkdir(parents=True, exist_ok=True)
    targets = []

    def target(name, mesh, encode=harness.obj, content=None, **more):
        points = mesh[0]
        data = encode(mesh) if content is None else content
        (folder / name).write_bytes(data.encode() if isinstance(data, str) else data)
        if content is None:
            other = encode(twisted(mesh))
            (folder / ("moved_" + name)).write_bytes(other.encode() if isinstance(other, str) else other)
        low, high = (tuple(f(p[axis] for p in points) for axis in range(3)) for f in (min, max))
        targets.append(Target(name, low, high, **more))

    def run(*words):
        subprocess.run([harness.program(), *map(str, words)], cwd=folder, check=True, stdin=subprocess.DEVNULL,
                       env=harness.environment(), stderr=subprocess.PIPE)

    torus, ball = harness.torus(), harness.sphere(3)
    target("ball.obj", ball)
    target("torus.ply", torus, harness.ply)
    target("cube.stl", harness.cube(), harness.stl)
    target("overlapping.off", joined(harness.cube(), harness.moved(harness.cube(0.7), 1, (0.8, 0.6, 0.4))), harness.off)
    target("plate.obj", stretched(ball, (1, 0.03, 0.7)))
    target("needle.obj", stretched(ball, (0.02, 2, 0.02)))
    target("crumbs.stl", crumbs(), harness.stl)
    target("spikes.off", spikes(), harness.off)
    target("hollow.obj", hollow())
    target("inside_out.obj", (torus[0], [f[::-1] for f in torus[1]]))
    target("off_centre.obj", harness.moved(torus, 1, (1000, -500, 3)))
    target("tiny.obj", harness.moved(torus, 1e-6, (0, 0, 0)))
    target("huge.obj", harness.moved(torus, 1e6, (2e6, 0, -1e6)))
    target("far.obj", harness.moved(ball, 1, (1e7, 0, 0)))
    target("painted.ply", ball, painted_ply, attributes=("red", "green", "blue", "slope"), weight=3)
    target("unwrapped.obj", torus, unwrapped_obj, uv=True, weight=2)
    target("open.obj", harness.with_hole(ball), kind="open")
    target("sheet.obj", squares(10, lambda x, y: 0.2 * math.sin(3 * x)), kind="sheet")
    target("hills.obj", squares(12, lambda x, y: 0.15 * math.sin(4 * x + 1) * math.cos(5 * y)), kind="terrain")
    target("cloud.ply", ball, content=cloud_ply(ball[0]), kind="cloud")
    if harness.BUNNY.exists():
        bunny = harness.read_obj(harness.BUNNY.read_bytes())
        target("bunny.ply", (bunny.points, bunny.faces), harness.ply, weight=0.5)
    run("sdf", "torus.ply", "-o", "torus.vdb", "--resolution", 24)
    box = targets[1]
    targets.append(Target("torus.vdb", box.low, box.high, kind="vdb", weight=2))

    (folder / "brush.obj").write_text(harness.obj(harness.sphere(1, 0.5, (0.6, 0.2, 0))))
    (folder / "checks.png").write_bytes(png(32, 32, lambda x, y: (255, 255, 255) if (x // 8 + y // 8) % 2 else (8, 60, 0)))
    (folder / "roots.p4d").write_bytes(harness.p4d(harness.ROOTS))
    (folder / "roots.o3d").write_bytes(harness.o3d(harness.ROOTS, harness.ROOTS[:1]))
    (folder / "rational.json").write_text(harness.rational_json(harness.ROOTS, harness.ROOTS[1:], 0.3))
    run("versor", "new", "-o", "swirl.json", "--seed", 3, "--roots", 7, "--powers", "2:9", "--integer")
    return targets

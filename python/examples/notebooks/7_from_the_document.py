# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # Is the document complete?
# Section 2 of docs/design.md describes the mathematics. Here numpy follows it for the fractal with no option: at random points of
# the box, it decides which lie in the set, and the program decides it too. As a script:
# 7_from_the_document.py MESH OUT.png [POINTS]

# %%
import itertools
import sys

import juliavdb
import numpy as np
from pictures import save

mesh, out = sys.argv[1:3]
count = int(sys.argv[3]) if len(sys.argv) > 3 else 100000

# %% [markdown]
# The program gives the space of the map, the distance phi and the thickness tau at the nodes of their lattices, and the numbers that
# files record.

# %%
field = juliavdb.Field(mesh, precision="double")
recorded = field.metadata


def numbers(name):
    return np.array(recorded[f"julia_{name}"].split(","), float)


origin, scale = np.array(field.space[0]), field.space[1]
corners = numbers("target_box").reshape(2, 3)
sides, middle = corners[1] - corners[0], corners.mean(axis=0)
longest = sides.max()
detail, outward = numbers("detail")[0], numbers("outward")[0]
log_escape, iterations = np.log(numbers("escape")[0]), int(recorded["julia_iterations"])
seed = int(recorded["julia_texture_seed"])
draw = np.random.default_rng(1)
points = draw.uniform(*np.array(field.bounds), (count, 3))

# %% [markdown]
# 2.8, the exponent. Lattices hold 32-bit numbers, and are read trilinearly. Their nodes lie at the middle of the target's box and whole
# numbers of voxels from there. K and P are recorded.


# %%
def rounded(values):
    return values.astype(np.float32).astype(float)


def read(lattice, voxel, x):
    """What a lattice holds, at points of the map's space."""
    at = (origin + scale * x - middle) / voxel
    first = np.floor(at)
    part = at - first
    return sum(np.where(corner, part, 1 - part).prod(axis=1) * lattice(first + corner)
               for corner in itertools.product((0, 1), repeat=3))


def at_nodes(query, voxel, nodes):
    """Slightly beyond each node: just before it, the value would be a rounded mean."""
    return query(middle + (nodes + 1e-12) * voxel)


voxel = longest / numbers("sdf_resolution")[0]


def width(tau):
    return np.maximum(0.96 * (detail + outward) * tau, voxel / 4)


K, P = numbers("detail_law")


def v_at(nodes):
    tau = field.thickness(middle + nodes * voxel)
    w = at_nodes(field.distance, voxel, nodes) / width(tau) - (outward / (detail + outward) - 0.02) / 0.96
    return rounded(log_escape + K * rounded(w))


def exponent(x):
    v, v_0 = read(v_at, voxel, x), log_escape - 0.95 * K
    return v + 20 * P / K * np.minimum(v - v_0, 0)


# %% [markdown]
# 2.11, the octave, on the lattice of the thickness. The frequency "medium" means 2 features across.

# %%
coarse = max(voxel, longest / min(512, np.floor(128 / np.cbrt((sides / longest).prod()))))


def octave_at(nodes):
    return rounded(np.log2(2 / (2 * at_nodes(field.thickness, coarse, nodes) / scale)))


# %% [markdown]
# 2.11, the waves of the texture "scales": each has a frequency w, and amplitudes c and s.

# %%
WORD = 2**64 - 1


def mixed(x):
    x = x + 0x9e3779b97f4a7c15 & WORD
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9 & WORD
    x = (x ^ x >> 27) * 0x94d049bb133111eb & WORD
    return x ^ x >> 31


def uniforms(stream):
    for i in itertools.count():
        yield (mixed(mixed(mixed(seed) + stream & WORD) + i & WORD) >> 11) / 2**53


def direction(u):
    while True:
        d = np.array([2 * next(u) - 1 for _ in range(4)])
        if 0.01 < d @ d <= 1:
            return d / np.sqrt(d @ d)


def wave(u):
    d = direction(u)
    w = (0.75 + 0.5 * next(u)) * d
    c = direction(u)
    while True:
        s = direction(u)
        s = s - (s @ c) * c
        if s @ s > 0.01:
            return w, c, s / np.sqrt(s @ s)


one, i, j, k = np.eye(4)
u = uniforms(stream=1)
scales = [[(np.array([0.5, 0.8, 0.3, 0]), one, i)], [(np.array([0.5, -0.8, 0.3, 0]), one, j)], [wave(u) for _ in range(4)]]


# %% [markdown]
# The texture is a product of the versors of these sums, and the versor blends two octaves of it.


# %%
def versor_of(q):
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def product(p, q):
    (a, b, c, d), (e, f, g, h) = p.T, q.T
    return np.stack([a * e - b * f - c * g - d * h, a * f + b * e + c * h - d * g,
                     a * g - b * h + c * e + d * f, a * h + b * g - c * f + d * e], axis=1)


def texture(p):
    made = np.tile(one, (len(p), 1))
    for waves in scales:
        phases = [2 * np.pi * (p @ w)[:, None] for w, _, _ in waves]
        made = product(made, versor_of(sum(c * np.cos(t) + s * np.sin(t) for t, (_, c, s) in zip(phases, waves))))
    return made


def versor(q):
    o = read(octave_at, coarse, q[:, :3])[:, None]
    f, power = o - np.floor(o), 2 ** np.floor(o)
    t = f * f * (3 - 2 * f)
    return versor_of((1 - t) * texture(power * q) + t * texture(2 * power * q))


# %% [markdown]
# 2.3, the orbits. The slice is 0.


# %%
def orbits(x):
    """F, and how many steps each orbit takes."""
    q = np.column_stack([x, np.zeros(len(x))])
    l, steps = np.log(np.linalg.norm(q, axis=1)), np.zeros(len(x), int)
    for _ in range(iterations):
        on = np.flatnonzero((l < log_escape) & (steps == steps.max()))
        steps[on] += 1
        l[on] = exponent(q[on, :3])
        on = on[l[on] < log_escape]
        q[on] = np.exp(l[on])[:, None] * versor(q[on])
    return l, steps


start = (points - origin) / scale
F, _ = orbits(start)
differ = (F < 0) != field.inside(points)

# %% [markdown]
# A picture of a slice: the set is blue, and what is outside is darker, the more steps its orbits take to escape. A place where the
# program has another sign is red.

# %%
size = max(32, round(count**0.5))
plane = field.plane(axis="z", size=size)
F, steps = orbits((plane.reshape(-1, 3) - origin) / scale)
pixels = np.repeat(np.clip(300 - 45 * steps, 0, 255)[:, None], 3, axis=1).astype(np.uint8)
pixels[F < 0] = 40, 80, 160
pixels[(F < 0) != field.inside(plane).ravel()] = 220, 30, 30

# %% [markdown]
# The answer: all signs are the same.

# %%
save(out, pixels.reshape(*plane.shape))
lower, upper = numbers("shell")
E = exponent(start)
print(f"random points: {count}")
print(f"of these in the shell: {np.sum((E > lower) & (E < upper))}")
print(f"other signs than the program's: {np.sum(differ)}")

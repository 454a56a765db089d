# SPDX-License-Identifier: Apache-2.0
"""The maps of docs/design.md once more, in numpy and nothing else: the second implementation of the conformance set.

Nothing here is shared with the program. All is written from the pages, for clarity and not for speed, and in a type of the
caller's choice, such as numpy.longdouble. Quaternions are rows (A, B, C, D); points are rows (X, Y, Z) of the map's space.
"""
import dataclasses
from collections.abc import Callable

import numpy as np

LIMIT = 1e30  # of |F| and of all logarithms
PLACES = {"i": (0, 2, 3, 1), "j": (0, 1, 3, 2), "k": (0, 1, 2, 3)}  # of X, Y, Z and S among A, B, C, D (design 2.1)


def pi(kind):
    return 4 * np.arctan(kind(1))


def times(p, q):
    """Hamilton's product."""
    (a, b, c, d), (e, f, g, h) = np.moveaxis(p, -1, 0), np.moveaxis(q, -1, 0)
    return np.stack([a * e - b * f - c * g - d * h, a * f + b * e + c * h - d * g,
                     a * g - b * h + c * e + d * f, a * h + b * g - c * f + d * e], axis=-1)


def conjugate(q):
    return q * np.array((1, -1, -1, -1), q.dtype)


def length(q):
    return np.sqrt((q * q).sum(axis=-1))


def unit(q):
    """The versor of q, which is 1 where q is 0."""
    size = length(q)[..., None]
    one = np.zeros_like(q)
    one[..., 0] = 1
    return np.where(size > 0, q / np.where(size > 0, size, 1), one)


def unit_power(q, exponent):
    """The versor of q^exponent: the angle of q from the real axis, times the exponent. That of a negative real turns about i."""
    along = length(q[..., 1:])[..., None]
    angle = exponent * np.arctan2(along, q[..., :1])
    about = np.where(along > 0, q[..., 1:] / np.where(along > 0, along, 1), np.array((1, 0, 0), q.dtype))
    return np.concatenate([np.cos(angle), about * np.sin(angle)], axis=-1)


class Lattice:
    """The exponent E of a union of balls, trilinear between the nodes `voxel` (i, j, k). At the nodes the signed distance is
    rounded to 32 bits, and so is alpha (phi - beta), as grids hold them."""

    def __init__(self, spec, alpha=1.0, beta=0.0):
        self.voxel, self.balls, self.alpha, self.beta = spec["voxel"], spec["balls"], alpha, beta

    def distance(self, index):
        at = index * self.voxel
        distances = [np.sqrt(((at - np.array(centre)) ** 2).sum(axis=-1)) - radius for centre, radius in self.balls]
        return np.minimum.reduce(distances).astype(np.float32)

    def __call__(self, x):
        place = x / x.dtype.type(self.voxel)
        first = np.floor(place)
        share, total = place - first, 0
        for corner in np.ndindex(2, 2, 2):
            node = (self.alpha * (self.distance(first.astype(float) + corner).astype(float) - self.beta)).astype(np.float32)
            total = total + np.where(corner, share, 1 - share).prod(axis=-1) * node.astype(x.dtype)
        return total


class Roots:
    """e^C prod (q - t)^(tau T) [prod (q - b)^(beta B)]^-1 in log-polar form (design 2.1). Rows of roots: A, B, C, D, power."""

    def __init__(self, spec):
        self.scale, self.top, self.bottom = spec.get("C", 0), spec["top"], spec.get("bottom", [])
        self.tau, self.beta = spec.get("tau", 1), spec.get("beta", 1)

    def log_modulus(self, q):
        total = np.full(len(q), self.scale, q.dtype)
        for roots, sign in ((self.top, self.tau), (self.bottom, -self.beta)):
            for *root, power in roots:
                total += q.dtype.type(sign) * q.dtype.type(power) * np.log(length(q - np.array(root, q.dtype)))
        return total

    def versor(self, q, octave=None):
        def product(roots, scale):
            value = np.zeros_like(q)
            value[:, 0] = 1
            for *root, power in roots:
                value = times(value, unit_power(q - np.array(root, q.dtype), q.dtype.type(scale) * q.dtype.type(power)))
            return value
        return times(product(self.top, self.tau), conjugate(product(self.bottom, self.beta)))


class Waves:
    """Two octaves of a product of waves (design 2.11). A wave is (w, c, s); a factor is (waves, P)."""

    def __init__(self, spec):
        self.factors = [(factor["waves"], factor["power"]) for factor in spec["factors"]]

    def texture(self, p):
        value = np.zeros_like(p)
        value[:, 0] = 1
        for waves, power in self.factors:
            total = 0
            for frequency, cosine, sine in waves:
                phase = 2 * pi(p.dtype.type) * (p * np.array(frequency, p.dtype)).sum(axis=-1)[:, None]
                total = total + np.array(cosine, p.dtype) * np.cos(phase) + np.array(sine, p.dtype) * np.sin(phase)
            value = times(value, unit_power(unit(total), power))
        return value

    def versor(self, q, octave):
        octave = octave.astype(q.dtype)
        coarse = np.floor(octave)
        f = octave - coarse
        t, scale = (f * f * (3 - 2 * f))[:, None], np.exp2(coarse)[:, None]
        return unit((1 - t) * self.texture(scale * q) + t * self.texture(2 * scale * q))


class Formula:
    """The vector (sin 30y, cos 30x, sin 30z) of expr:sin(30*y), cos(30*x), sin(30*z)."""

    def __init__(self, spec):
        assert spec["text"] == "sin(30*y), cos(30*x), sin(30*z)"

    def versor(self, q, octave=None):
        x, y, z, _ = np.moveaxis(q, -1, 0)
        return unit(np.stack([np.sin(30 * y), np.cos(30 * x), np.sin(30 * z), 0 * x], axis=-1))


class Moved:
    """v((q - t) / s)."""

    def __init__(self, spec):
        self.inner, self.scale, self.by = versor(spec["of"]), spec["scale"], spec["translate"]

    def versor(self, q, octave=None):
        return self.inner.versor((q - np.array([*self.by, 0], q.dtype)) / q.dtype.type(self.scale), octave)


class Mixed:
    """The versor of (1 - m) u + m v."""

    def __init__(self, spec):
        self.under, self.over, self.mix = versor(spec["under"]), versor(spec["over"]), spec["mix"]

    def versor(self, q, octave=None):
        m = q.dtype.type(self.mix)
        return unit((1 - m) * self.under.versor(q, octave) + m * self.over.versor(q, octave))


class Symmetric:
    """A versor that a symmetry leaves as it is (design 2.11)."""

    def __init__(self, spec):
        self.inner, self.spec = versor(spec["of"]), spec

    def versor(self, q, octave=None):
        q, centre, axis = q.copy(), np.array([*self.spec["centre"], 0], q.dtype), self.spec.get("axis", 2)
        for mirrored in self.spec.get("mirrored", []):
            q[:, mirrored] = centre[mirrored] + np.abs(q[:, mirrored] - centre[mirrored])
        fold, first = self.spec.get("fold", 1), (axis + 1) % 3
        second = (first + 1) % 3

        def turned(at, angle):
            """By -angle about the axis, which goes through the centre."""
            x, y = at[:, first] - centre[first], at[:, second] - centre[second]
            at = at.copy()
            at[:, first] = centre[first] + np.cos(angle) * x + np.sin(angle) * y
            at[:, second] = centre[second] - np.sin(angle) * x + np.cos(angle) * y
            return at

        sector = 2 * pi(q.dtype.type) / fold
        if self.spec.get("kaleidoscope"):
            angle = np.arctan2(q[:, second] - centre[second], q[:, first] - centre[first])
            q = turned(q, sector * np.rint(angle / sector))
            q[:, second] = centre[second] + np.abs(q[:, second] - centre[second])
            return self.inner.versor(q, octave)
        return unit(sum(self.inner.versor(turned(q, k * sector), octave) for k in range(fold)))


VERSORS = {"roots": Roots, "waves": Waves, "formula": Formula, "moved": Moved, "mixed": Mixed, "symmetric": Symmetric}


def versor(spec):
    return VERSORS[spec["kind"]](spec)


def cross_pair(name):
    """f and g of design 2.7, with the angles as they are defined."""
    def angles(p):
        r = length(p)
        return r, np.arctan2(p[:, 1], p[:, 0]), np.arcsin(p[:, 2] / np.where(r > 0, r, 1))

    def square(p):
        r, phi, _ = angles(p)
        return np.stack([-r * r * np.sin(2 * phi), r * r * np.cos(2 * phi), 0 * r], axis=-1)

    def tilted(sign):
        def g(p):
            _, phi, theta = angles(p)
            # Where cos 2phi is 0, which no rounded phi gives exactly, g is not defined.
            phi = np.where((np.abs(p[:, 0]) == np.abs(p[:, 1])) & (p[:, 0] != 0), np.nan, phi)
            return np.stack([sign * np.sin(2 * theta) / np.cos(2 * phi), 0 * phi, np.cos(2 * theta)], axis=-1)
        return g

    return {"A": (square, tilted(-1)), "A'": (square, tilted(1)), "B": (np.ones_like, np.cos), "C": (np.square, np.cos),
            "D": (square, lambda p: np.broadcast_to(np.array((0, 0, 1), p.dtype), p.shape)),
            "E": (lambda p: np.stack([p[:, 0] ** 2 * p[:, 1], p[:, 1] ** 2, p[:, 2] ** 2], axis=-1),
                  lambda p: np.stack([np.ones_like(p[:, 0]), np.cos(p[:, 2]), np.ones_like(p[:, 0])], axis=-1)),
            "user": (lambda p: np.stack([p[:, 1] * p[:, 2], p[:, 0] ** 2, p[:, 0] * p[:, 1]], axis=-1),
                     lambda p: np.stack([np.ones_like(p[:, 0]), np.sin(p[:, 0]), p[:, 1]], axis=-1))}[name]


def triplex_power(p, n, pole):
    r = length(p)
    phi, theta = np.arctan2(p[:, 1], p[:, 0]), np.arcsin(p[:, 2] / np.where(r > 0, r, 1))
    if pole:
        tilt = pi(p.dtype.type) / 2 - theta
        return (r ** n)[:, None] * np.stack([np.cos(n * phi) * np.sin(n * tilt), np.sin(n * phi) * np.sin(n * tilt), np.cos(n * tilt)], -1)
    return (r ** n)[:, None] * np.stack([np.cos(n * phi) * np.cos(n * theta), np.sin(n * phi) * np.cos(n * theta), np.sin(n * theta)], -1)


@dataclasses.dataclass
class Orbits:
    """iterates (points, n + 1, 3 or 4) and log_moduli (points, n + 1), NaN after the last one formed; steps and F (points).
    octaves (points, n) are those that the orbits have read."""
    iterates: np.ndarray
    log_moduli: np.ndarray
    steps: np.ndarray
    F: np.ndarray
    octaves: np.ndarray


def stepper(case, kind):
    """(q, start, number of the step, given E or None, octave) -> (l, function for the next iterate)."""
    name, make = case["map"], kind
    if name == "shape-modulus":
        places = list(PLACES[case["drop_axis"]][:3])
        target = Lattice(case["target"], case["alpha"], case["beta"]) if "target" in case else None
        direction = versor(case["versor"])

        def step(q, start, number, exponent, octave):
            if target:
                exponent = target(q[:, places])
            return exponent, lambda go: np.exp(exponent[go])[:, None] * direction.versor(q[go], octave(go))
    elif name == "rational":
        rational = Roots(case["rational"])

        def step(q, start, number, exponent, octave):
            l = rational.log_modulus(q)
            return l, lambda go: np.exp(l[go])[:, None] * rational.versor(q[go])
    else:
        constant = None if case.get("c") is None else np.array(case["c"], make)

        def value(q, start, number):
            c = start if constant is None else constant
            if name == "quadratic":
                return times(q, q) + c
            if name == "mandelbulb":
                return triplex_power(q, make(case["power"]), case["theta"] == "pole") + c
            f, g = cross_pair(case["pair"])
            if case["scheme"] == 3:
                return np.cross(f(start) if number == 0 else q, g(start))
            return np.cross(f(q), g(q)) + c

        def step(q, start, number, exponent, octave):
            after = value(q, start, number)
            l = np.log(length(after))
            return np.where(np.isnan(l), np.inf, l), lambda go: after[go]
    return step


def orbits(case, points, kind=np.longdouble, exponents=None, octave_at: Callable = None, octaves=None):
    """The orbits of points (n, 3), as design 2.3 has them.

    exponents and octaves are (points, n) where the case gives E and the octave at the iterates; octave_at(q) says the octave
    instead.
    """
    points = np.asarray(points, float).astype(kind)
    count, n, escape = len(points), case["iterations"], np.log(kind(case["escape"]))
    if case["map"] in ("cross", "mandelbulb"):
        start = points
    else:
        start = np.full((count, 4), kind(case["slice"]))
        start[:, PLACES[case["drop_axis"]][:3]] = points
    iterates = np.full((count, n + 1, start.shape[1]), np.nan, kind)
    logs, read = np.full((count, n + 1), np.nan, kind), np.full((count, n), np.nan)
    iterates[:, 0], logs[:, 0] = start, np.clip(np.log(length(start)), -LIMIT, LIMIT)
    steps, step = np.zeros(count, int), stepper(case, kind)
    going = np.flatnonzero(logs[:, 0] < escape)
    for number in range(n):
        if not len(going):
            break
        q = iterates[going, number]

        def octave(go):
            if octave_at:
                read[going[go], number] = octave_at(q[go].astype(float))
            elif octaves is not None:
                read[going[go], number] = octaves[going[go], number]
            return read[going[go], number]

        l, image = step(q, start[going], number, None if exponents is None else exponents[going, number].astype(kind), octave)
        logs[going, number + 1] = np.clip(l, -LIMIT, LIMIT)
        steps[going] = number + 1
        go = np.flatnonzero(l < escape) if number + 1 < n else np.array([], int)
        if len(go):
            iterates[going[go], number + 1] = image(go)
        going = going[go]
    level = kind(0) if case["map"] in ("shape-modulus", "rational") else escape
    F = np.clip(logs[np.arange(count), steps] - level, -LIMIT, LIMIT)
    return Orbits(iterates, logs, steps, F, read)

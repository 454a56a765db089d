# SPDX-License-Identifier: Apache-2.0
"""The parts of fitting a rational map to a shape, each by itself (docs/fitting.md).

    charge = fitting.charge(vertices, faces)                          # a conductor at the potential 1
    known = fitting.potential(vertices, faces, charge.density, outside)
    found = fitting.monopoles(vertices, faces, outside, known)        # the same potential by a few points
    start = fitting.Rational.from_monopoles(found)
    energy = fitting.Energy(cells, fitting.weights(cells, phi, cell_size), start)
    best, value, _ = energy.minimise(start)

Coordinates are those of the map's space, in which a shape's longest side is usually 1. Arrays that are no points, no
weights of them and so on raise ValueError.
"""
import collections
import os
import pathlib

from . import _juliavdb

Charge = collections.namedtuple("Charge", "density capacitance iterations residual")
Charge.__doc__ = """The charge of a conductor at the potential 1: density (n,), one a triangle and unit of area; capacitance,
its sum, for a ball the radius; iterations, 0 where the system was solved directly; residual."""

Monopoles = collections.namedtuple("Monopoles", "positions weights residuals")
Monopoles.__doc__ = """A potential as a sum of weights / distances: positions (m, 3), weights (m,), and the relative residual
after each of them."""


class Rational(collections.namedtuple("Rational", "log_scale top top_scale bottom bottom_scale")):
    """e^C times the powers of q minus each root of the top, divided by those of the bottom.

    log_scale is C. top and bottom are arrays (n, 5), in each row a position of four numbers and a power, which top_scale
    (tau) and bottom_scale (beta) multiply.
    """

    __slots__ = ()

    @classmethod
    def from_monopoles(cls, monopoles, power=1.0, roots_at_origin=False):
        """Monopoles of positive weight as roots of the top, those of negative weight as roots of the bottom. A root's power
        is the given one times the size of the weight. roots_at_origin adds a root of power 1 at 0 to each."""
        return cls(*_juliavdb.rational_from_monopoles(monopoles.positions, monopoles.weights, power, roots_at_origin))

    @classmethod
    def read(cls, path):
        """Reads a map of fit() or another .json, .p4d, .poly4d or .o3d."""
        return cls(*_juliavdb.rational_read(os.fspath(path)))

    def log_moduli(self, points):
        """ln |f| at points (..., 3): an array (...)."""
        return _juliavdb.rational_at(tuple(self), points)[0]

    def versors(self, points):
        """f/|f| at points (..., 3): quaternions (..., 4)."""
        return _juliavdb.rational_at(tuple(self), points)[1]

    def write(self, path):
        """Writes the map as JSON, for fractal(map="rational", rational=path, box=...) and for the program."""
        pathlib.Path(path).write_text(_juliavdb.rational_json(tuple(self)), encoding="utf-8")


Gradient = collections.namedtuple("Gradient", "log_scale top top_scale bottom bottom_scale top_places bottom_places")
Gradient.__doc__ = """The derivatives of an energy by C, by each power of the top, by tau, by each power of the bottom, by beta,
and by the four coordinates of each root of the top and of the bottom: arrays (n, 4)."""


def blue_noise(vertices, faces, count, *, seed=1):
    """So many points on a surface at nearly equal distances: an array (count, 3)."""
    return _juliavdb.blue_noise(vertices, faces, count, seed)


def charge(vertices, faces, *, tolerance=1e-6, progress=None, threads=None):
    """Solves for the Charge of a closed surface that is a conductor at the potential 1, by boundary elements."""
    return Charge(*_juliavdb.charge(vertices, faces, tolerance, progress, threads))


def potential(vertices, faces, density, points):
    """The potential of charges on triangles at points (..., 3): an array (...)."""
    return _juliavdb.potential(vertices, faces, density, points)


def monopoles(vertices, faces, points, potentials, *, epsilon=0.04, most=1000, candidates=100, seed=1, progress=None, threads=None):
    """Monopoles on a surface that give these potentials (n,) at points (n, 3), found one after the other until the relative
    residual is epsilon or there are most of them: Monopoles."""
    return Monopoles(*_juliavdb.monopoles(vertices, faces, points, potentials, epsilon, most, candidates, seed, progress, threads))


def weights(points, phi, cell_size, *, kind="inverse-distance"):
    """The weights of cells for an Energy, with the sign of their distances phi: 1 / phi in cells, where |phi| is at least half a
    cell, or with kind="layers" by their number of layers from the surface."""
    return _juliavdb.cell_weights(points, phi, cell_size, kind)


class Energy:
    """psi, the mean of -tanh(alpha L) over cells by their weights: -1 where the signs of L = ln |f| and of the weights are the
    same everywhere. It is for the roots of one Rational, whose powers and scales may change, and which move_roots() moves."""

    def __init__(self, points, weights, rational, *, alpha=1.0, penalty=0.0):
        """points (n, 3), weights (n,). penalty times the summed powers is added to psi."""
        self._energy = _juliavdb.Energy(points, weights, tuple(rational), alpha, penalty)

    def __call__(self, rational):
        """The energy."""
        return self._energy.value(tuple(rational))

    def gradient(self, rational):
        """The energy, and its Gradient."""
        value, *derivatives = self._energy.at(tuple(rational))
        return value, Gradient(*derivatives)

    def log_moduli(self, rational):
        """L at each point."""
        return self._energy.log_moduli(tuple(rational))

    def minimise(self, start, *, variables="full", iterations=500, tolerance=1e-6, progress=None, threads=None):
        """Lowers the energy by L-BFGS-B with all powers, tau and beta at 0 or above: (Rational, its energy, the energies on the
        way). variables="coarse" changes C, tau and beta alone."""
        if variables not in ("full", "coarse"):
            raise ValueError(f"variables is {variables!r}; it must be full or coarse")
        found, value, values = self._energy.minimise(tuple(start), variables == "full", iterations, tolerance, progress, threads)
        return Rational(*found), value, values

    def move_roots(self, start, reach, *, iterations=500, tolerance=1e-6, progress=None, threads=None):
        """Lowers the energy by the positions of the roots, each of whose first three coordinates may move by reach: (Rational,
        its energy, the energies on the way). From then on the energy is for these roots."""
        found, value, values = self._energy.move_roots(tuple(start), reach, iterations, tolerance, progress, threads)
        return Rational(*found), value, values

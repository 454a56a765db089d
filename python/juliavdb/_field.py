# SPDX-License-Identifier: Apache-2.0
"""The field of a fractal at any points."""
import collections

from . import _options, _target

ENDS = ("steps", "escaped", "trapped")


class Orbit(collections.namedtuple("Orbit", "iterates log_moduli steps ends")):
    """The orbits of points, as Field.orbit() follows them. n stands for the option iterations.

    iterates: (..., n + 1, 4), or (..., n + 1, 3) of a map of R^3; the first iterate is the point itself, in the space of
    the map (Field.space). log_moduli: (..., n + 1), the logarithms of their moduli. Both are NaN after the last iterate;
    an iterate that is too large for the arithmetic is NaN, too, but has its logarithm. steps: (...) of int32, how many
    steps each orbit took. ends: (...) of str, why it ended: "steps", "escaped", or "trapped" in the ball from which no
    orbit returns.
    """

    __slots__ = ()


class Field:
    """The function F whose set F < 0 is the fractal, and what it is made of, at any points.

    Points are arrays of any shape (..., 3), in the target's units, and the results have the same shape without the last
    axis. The methods raise ValueError for points of another shape, that are no real numbers, or that are not finite.
    threads= is the greatest number of threads that a call takes, and None takes all.
    """

    @_options.documented(_options.FRACTAL)
    def __init__(self, vertices=None, faces=None, *, progress=None, memory=None, threads=None, device=None, **options):
        """Prepares the field. The target and the options are the same as those of fractal()."""
        self._given = vertices, faces, memory, options
        self._scene = _target.scene(vertices, faces, progress, (memory, threads, device), options)

    def __reduce__(self):
        """A field is pickled as what it was made of, and made again of it."""
        return _made_again, self._given

    def __repr__(self):
        return f"<juliavdb.Field of {_target.named(self.recipe)}>"

    def __copy__(self):
        """A field does not change, so that a copy may share it."""
        return self

    def __deepcopy__(self, memo):
        return self

    def __call__(self, points, *, progress=None, threads=None, device=None):
        """F at points: an array of float64, below 0 inside the set.

        device= is a choice as that of use_device(), for this call; the results are the same, to the bit.
        """
        return self._scene.evaluate(points, progress, threads, device)

    def inside(self, points, *, progress=None, threads=None, device=None):
        """Whether each of the points lies in the set: an array of bool."""
        return self(points, progress=progress, threads=threads, device=device) < 0

    def distance(self, points, *, progress=None, threads=None):
        """The target's signed distance phi, in its units, negative inside: the grid that the field is made from, read
        trilinearly. The grid ends some voxels beyond the shell in which detail is made. From there on, the result is
        the width of that band, with the sign of the side."""
        return self._scene.distance(points, progress, threads)

    def thickness(self, points, *, limited=True, progress=None, threads=None):
        """The target's local thickness, in its units, above 0: the radius of the largest ball that fits in the target
        and contains the point, continued gently outside. It is the one that detail follows, whose slope is the smaller
        the larger `detail` is; with limited=False the slope is 1 at most, as along the faces of a convex body. The first
        call measures it."""
        return (self._scene.thickness if limited else self._scene.full_thickness)(points, progress, threads)

    def octave(self, points, *, progress=None, threads=None):
        """The octave o of a texture that follows the thickness: it has 2^o cycles to a unit of the map's space, which are
        `frequency` cycles across the local thickness there."""
        return self._scene.octave(points, progress, threads)

    def exponent(self, points, *, progress=None, threads=None):
        """The exponent E of the shape modulus as the map reads it, in doubles: the logarithm of the modulus of the
        first iterate. Where E decides alone whether a point is inside, it may be a constant of the same sign."""
        return self._scene.exponent(points, progress, threads)

    def versor(self, points, *, progress=None, threads=None):
        """The direction f/|f| of the first step: unit quaternions (..., 4), or vectors (..., 3) of a map of R^3."""
        return self._scene.versor(points, progress, threads)

    def trap(self, points, *, progress=None, threads=None):
        """The smallest modulus among the iterates of each point, without the point itself, in the space of the map; inf
        where the point has escaped before the first step."""
        return self._scene.trap(points, progress, threads)

    def orbit(self, points, *, progress=None, threads=None):
        """The whole orbits of the points: an Orbit with all iterates, the steps, and why each orbit ended."""
        iterates, log_moduli, steps, codes = self._scene.orbit(points, progress, threads)
        import numpy

        return Orbit(iterates, log_moduli, steps, numpy.array(ENDS)[codes])

    def gradient(self, points, *, step=None, progress=None, threads=None):
        """The gradient of F by the target's units: arrays (..., 3).

        These are central differences of F, (F(x + h) - F(x - h)) / 2h along each axis, which is always evaluated in
        doubles here. step= is h in the target's units, by default 1e-7 of its longest side. F jumps where orbits take
        another number of steps; where the orbits of the seven points do not take the same number, the gradient is NaN.
        """
        return self._scene.gradient(points, step, progress, threads)

    def decide(self, centres, radius, *, progress=None, threads=None):
        """What ball arithmetic proves of the balls of these centres: an array of int8.

        -1: F < 0 at each point of the ball. 1: F >= 0 at each point. 0: neither is proved. radius is one number, or an
        array with one for each centre, in the target's units.
        """
        return self._scene.decide(centres, radius, progress, threads)

    def plane(self, *, axis="z", position=None, size=800):
        """The places of the pixels of a slice, (height, width, 3), in the target's units: see slice()."""
        return self._scene.plane(axis, position, size)

    @property
    def recipe(self):
        """All options of the field, as text: a dict."""
        return self._scene.recipe

    @property
    def space(self):
        """The space of the map, as (origin, scale): x stands for the point origin + scale x of the target's space."""
        return self._scene.space

    @property
    def bounds(self):
        """Two corners of a box that holds the set, in the target's units; of an option box, that box."""
        return self._scene.bounds

    @property
    def metadata(self):
        """The options and what was found on the way, as files hold them."""
        return self._scene.metadata

    @_options.documented(_options.VIEW)
    def render(self, *, progress=None, threads=None, **view):
        """A picture as that of juliavdb.render(); the field is made once for any number of pictures."""
        return self._scene.render(_options.recipe(view), progress, threads)


def _made_again(vertices, faces, memory, options):
    return Field(vertices, faces, memory=memory, **options)

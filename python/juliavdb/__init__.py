# SPDX-License-Identifier: Apache-2.0
"""Fractals in the shape of a mesh.

    import juliavdb
    bunny = juliavdb.fractal("bunny.obj", detail=0.5, texture="quills", resolution=200)
    bunny.vertices, bunny.faces, bunny.normals
    bunny.write("bunny.vdb")

The target is a file, or two arrays: vertices of the shape (n, 3) and triangles of the shape (m, 3), as indices of
vertices. With points_radius, vertices alone are points of a surface. The options are those of 'juliavdb fractal', with underscores in their names; numbers, strings, tuples for
lists, and True for flags. The same options give the same result as the command, to the bit.

texture=FUNCTION takes any function of the place for the texture: it is called with points, an array (n, 3) of float64 in
the target's coordinates, and returns their directions, an array (n, 3) of vectors or (n, 4) of quaternions, of any
length. It is called in many threads, one at a time, with batches of points in any order.

While a call works, other threads run. progress=FUNCTION is called in the calling thread with the name of a phase and
the share of it that is done, from 0 to 1, or None where that is not known; where it returns False, the work is
cancelled as by Ctrl-C, which is a KeyboardInterrupt. memory="16G" says how much memory the process may take for that
work, and for all that is made of its result: work that is known to need more is refused. Errors say the same as those
of the command: ValueError for options, DataError (a ValueError) for targets that cannot be used, FileNotFoundError,
OSError for files that cannot be read to their end or written, and MemoryError.
"""
import os

from . import _juliavdb, _options
from ._juliavdb import DataError, Fit, Fractal

__all__ = ["DataError", "Field", "Fit", "Fractal", "devices", "fit", "fractal", "render", "use_device"]
__version__ = _juliavdb.version
Fit.__module__ = Fractal.__module__ = "juliavdb"


def _target(vertices, faces, options):
    """The recipe, and the arrays if the target is in memory."""
    recipe = _options.recipe(options)
    if isinstance(vertices, (str, os.PathLike)):
        if faces is not None:
            raise ValueError("faces were given with the name of a file; give vertices and faces, or the name alone")
        if "input" in recipe:
            raise ValueError("the target was given twice, as an argument and as input; leave one of them out")
        recipe["input"] = os.fspath(vertices)
        vertices = None
    elif vertices is None and faces is not None:
        raise ValueError("faces were given without vertices; give both")
    elif vertices is not None and faces is None and "points-radius" not in recipe:
        raise ValueError("vertices were given without faces; give both, or, if they are points of a surface, also "
                         "points_radius")
    elif vertices is not None and "input" in recipe:
        raise ValueError("the target was given twice, as arrays and as input; leave one of them out")
    return recipe, vertices, faces


def devices():
    """The devices of OpenCL, in the order of their numbers: a list of dictionaries with the entries "name", "gpu",
    "doubles" and "refusal", which says why a device is not used and is empty if it is."""
    return _juliavdb.devices()


def use_device(choice):
    """Evaluates maps on a device from now on: "cpu", "auto", "opencl" or "opencl:N", as --device of the program. The
    results are the same, to the bit. Returns a sentence about where maps are evaluated. Raises ValueError for a choice that
    is none, and RuntimeError if no device can be used. A device that fails later is a RuntimeWarning, and the processor
    goes on."""
    return _juliavdb.use_device(choice)


def _scene(vertices, faces, progress, memory, options):
    options, function = _options.with_function(options)
    return _juliavdb.Scene(*_target(vertices, faces, options), memory, progress, function)


@_options.documented(_options.FRACTAL)
def fractal(vertices=None, faces=None, *, progress=None, memory=None, **options):
    """Makes a fractal in the shape of a target, and returns it as a Fractal.

    The target is the name of a file, or two arrays, vertices (n, 3) and faces (m, 3), or with points_radius vertices
    alone. A map that makes a set of its
    own, such as map="mandelbulb", needs none. The grids that grids= names are made at once; without it they are made
    when the first VDB is written, which takes as long again, but for the target's distances.
    """
    return _scene(vertices, faces, progress, memory, options).fractal(options.get("grids") is not None, progress)


@_options.documented(_options.FRACTAL, _options.VIEW)
def render(vertices=None, faces=None, *, progress=None, memory=None, **options):
    """Makes a picture of the set itself, as 'juliavdb render --field' does: an array (height, width, 3) of uint8.

    It is finer than any voxels, and there is no mesh made for it. The target is the same as that of fractal().
    """
    view = {name: options.pop(name) for name in list(options) if name in _options.VIEW}
    _juliavdb.check_view(_options.recipe(view))
    return _scene(vertices, faces, progress, memory, options).render(_options.recipe(view), progress)


@_options.documented(_options.FIT)
def fit(vertices=None, faces=None, *, progress=None, memory=None, **options):
    """Finds a rational map in the shape of a target, as 'juliavdb fit' does, and returns it as a Fit.

    Written to shape.json, it is a map for fractal(map="rational", rational="shape.json").
    """
    return Fit(*_target(vertices, faces, options), memory, progress)


class Field:
    """The function F whose set F < 0 is the fractal, to be evaluated anywhere."""

    @_options.documented(_options.FRACTAL)
    def __init__(self, vertices=None, faces=None, *, progress=None, memory=None, **options):
        """Prepares the field. The target and the options are the same as those of fractal()."""
        self._scene = _scene(vertices, faces, progress, memory, options)

    def __call__(self, points, *, progress=None):
        """F at points, an array (n, 3) in the target's units: an array (n,) of float64, below 0 inside the set."""
        return self._scene.evaluate(points, progress)

    def inside(self, points, *, progress=None):
        """Whether each of the points, an array (n, 3), lies in the set: an array (n,) of bool."""
        return self(points, progress=progress) < 0

    @property
    def bounds(self):
        """Two corners of a box that holds the set, in the target's units; of an option box, that box."""
        return self._scene.bounds

    @property
    def metadata(self):
        """The options and what was found on the way, as files hold them."""
        return self._scene.metadata

    @_options.documented(_options.VIEW)
    def render(self, *, progress=None, **view):
        """A picture as that of juliavdb.render(); the field is made once for any number of pictures."""
        return self._scene.render(_options.recipe(view), progress)


def _write(self, *paths, progress=None):
    """Writes files that all appear together, whole or not at all: .vdb, .ply, .obj, .stl or .glb, by their extensions.

    Where the target was a file, they have the same bytes as those that the command writes.
    """
    self._write([os.fspath(path) for path in paths], progress)


_write.__name__, _write.__qualname__ = "write", "Fractal.write"
Fractal.write = _write


def _write_fit(self, path, *, progress=None):
    """Writes the map, whole or not at all: .json or .o3d, by its extension."""
    self._write(os.fspath(path), progress)


_write_fit.__name__, _write_fit.__qualname__ = "write", "Fit.write"
Fit.write = _write_fit

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

map=FUNCTION takes a function of iterates, an array (n, 4) of quaternions, and of the points where their orbits began, for
the map: it returns the next iterates, (n, 4).

While a call works, other threads run. progress=FUNCTION is called in the calling thread with the name of a phase and
the share of it that is done, from 0 to 1, or None where that is not known; where it returns False, the work is
cancelled as by Ctrl-C, which is a KeyboardInterrupt. memory="16G" says how much memory the process may take for that
work, and for all that is made of its result: work that is known to need more is refused. threads= is the greatest number
of threads that a call takes, and None takes all. device= is a choice as that of use_device(), for the call and all that is
made of its result; calls with a device wait for each other. The results are the same, to the bit. Errors say the same as those
of the command: ValueError for options, DataError (a ValueError) for targets that cannot be used, FileNotFoundError,
OSError for files that cannot be read to their end or written, and MemoryError.
"""
import os as _os

from . import _juliavdb, _options, _target, fitting
from ._field import Field, Orbit
from ._grid import Grid, sdf
from ._juliavdb import DataError, Fit, Fractal
from ._study import dimension, slice, study

__all__ = ["DataError", "Field", "Fit", "Fractal", "Grid", "Orbit", "devices", "dimension", "fit", "fractal", "render",
           "sdf", "slice", "study", "trust_importer", "use_device"]
__version__ = _juliavdb.version
for _function in (dimension, sdf, slice, study):
    _function.__module__ = "juliavdb"
del _function
Field.__module__ = Grid.__module__ = Fit.__module__ = Fractal.__module__ = Orbit.__module__ = "juliavdb"


def devices():
    """The devices of OpenCL, in the order of their numbers: a list of dictionaries with the entries "name", "gpu",
    "doubles" and "refusal", which says why a device is not used and is empty if it is."""
    return _juliavdb.devices()


def use_device(choice):
    """Evaluates maps on a device from now on: "cpu", "auto", "opencl", "opencl:N" or "opencl:all", as --device of the program. The
    results are the same, to the bit. Returns a sentence about where maps are evaluated. Raises ValueError for a choice that
    is none, and RuntimeError if no device can be used. A device that fails later is a RuntimeWarning, and the processor
    goes on."""
    return _juliavdb.use_device(choice)


def trust_importer(trusted=True):
    """Reads FBX, DAE, 3DS and X3D from now on, by the library Assimp, or no longer: as --trust-importer of the program. A file
    that somebody made to do harm can then do anything, so files that you do not trust should not be read."""
    _juliavdb.trust_importer(trusted)


@_options.documented(_options.FRACTAL)
def fractal(vertices=None, faces=None, *, progress=None, memory=None, threads=None, device=None, **options):
    """Makes a fractal in the shape of a target, and returns it as a Fractal.

    The target is the name of a file, or two arrays, vertices (n, 3) and faces (m, 3), or with points_radius vertices
    alone. A map that makes a set of its
    own, such as map="mandelbulb", needs none. The grids that grids= names are made at once; without it they are made
    when the first VDB is written, which takes as long again, but for the target's distances.
    """
    scene = _target.scene(vertices, faces, progress, (memory, threads, device), options)
    made = scene.fractal(options.get("grids") is not None, progress, threads)
    made._given = vertices, faces, memory, options
    return made


def _made_again(vertices, faces, memory, options):
    return fractal(vertices, faces, memory=memory, **options)


def _reduce_fractal(self):
    """A fractal is pickled as what it was made of, as a Field is, and made again of it: the same bits."""
    return _made_again, self._given


@_options.documented(_options.FRACTAL, _options.VIEW)
def render(vertices=None, faces=None, *, progress=None, memory=None, threads=None, device=None, **options):
    """Makes a picture of the set itself, as 'juliavdb render --field' does: an array (height, width, 3) of uint8.

    It is finer than any voxels, and there is no mesh made for it. The target is the same as that of fractal().
    """
    view = {name: options.pop(name) for name in list(options) if name in _options.VIEW}
    _juliavdb.check_view(_options.recipe(view))
    scene = _target.scene(vertices, faces, progress, (memory, threads, device), options)
    return scene.render(_options.recipe(view), progress, threads)


@_options.documented(_options.FIT)
def fit(vertices=None, faces=None, *, progress=None, memory=None, threads=None, **options):
    """Finds a rational map in the shape of a target, as 'juliavdb fit' does, and returns it as a Fit.

    Written to shape.json, it is a map for fractal(map="rational", rational="shape.json").
    """
    return Fit(*_target.given(vertices, faces, options), (memory, threads, None), progress)


def _write(self, *paths, progress=None, threads=None):
    """Writes files that all appear together, whole or not at all. Their extensions say what they hold, as in the command: grids
    (-o, such as .vdb and .nvdb) or the mesh (--mesh, such as .ply and .glb).

    Where the target was a file, they have the same bytes as those that the command writes.
    """
    self._write([_os.fspath(path) for path in paths], progress, threads)


def _to_meshio(self):
    """The mesh for meshio, which Debian has as python3-meshio: its points and triangles are the memory of this result, and so
    are the attributes, as point_data. They cannot be written to."""
    import meshio

    return meshio.Mesh(self.vertices, [("triangle", self.faces)], point_data=dict(self.attributes))


def _fractal_text(self):
    info = self.info
    return f"<juliavdb.Fractal of {_target.named(info['recipe'])}: {info['vertices']} vertices, {info['triangles']} triangles>"


def _fit_text(self):
    info = self.info
    return (f"<juliavdb.Fit of {_target.named(info['recipe'])}: {info['top_roots']} and {info['bottom_roots']} roots, "
            f"IoU {info['iou']:.3f}>")


Fractal.__repr__, Fit.__repr__ = _fractal_text, _fit_text
Fractal.__reduce__ = _reduce_fractal
Fractal.__copy__ = lambda self: self
Fractal.__deepcopy__ = lambda self, memo: self
_to_meshio.__name__, _to_meshio.__qualname__ = "to_meshio", "Fractal.to_meshio"
Fractal.to_meshio = _to_meshio
_write.__name__, _write.__qualname__ = "write", "Fractal.write"
Fractal.write = _write


def _write_fit(self, path, *, progress=None):
    """Writes the map, whole or not at all: .json or .o3d, by its extension."""
    self._write(_os.fspath(path), progress)


_write_fit.__name__, _write_fit.__qualname__ = "write", "Fit.write"
Fit.write = _write_fit

# SPDX-License-Identifier: Apache-2.0
"""Grids of numbers, and the signed distances of meshes."""
import os
import pathlib
import tempfile

from . import _juliavdb, _options, _target

SDF = {name.replace("-", "_"): (argument, text) for name, argument, text in _juliavdb.sdf_options()}


class Grid:
    """A grid of 32-bit numbers in the target's units, as sdf() makes it, or as a VDB or an array holds it."""

    def __init__(self, array, voxel_size, origin=(0, 0, 0), name="grid"):
        """Takes an array (x, y, z): its node (0, 0, 0) lies at the origin. Numbers are rounded to 32 bits."""
        self._grid = _juliavdb.grid_of_array(array, voxel_size, tuple(map(float, origin)), name)

    @classmethod
    def _of(cls, grid):
        made = cls.__new__(cls)
        made._grid = grid
        return made

    @classmethod
    def read(cls, path, name=""):
        """Reads a grid of a VDB. Without a name, it is the only one, or the one that is called surface or phi."""
        return cls._of(_juliavdb.read_grid(os.fspath(path), name))

    def __repr__(self):
        return f"<juliavdb.Grid {self.name!r} with a voxel size of {self.voxel_size:g}>"

    @property
    def name(self):
        """The name that the grid has in a VDB."""
        return self._grid.name

    @property
    def voxel_size(self):
        """The distance between two nodes, in the target's units."""
        return self._grid.voxel_size

    @property
    def background(self):
        """The value far from all active nodes."""
        return self._grid.background

    @property
    def metadata(self):
        """What the grid's file says besides it."""
        return self._grid.metadata

    def array(self):
        """All nodes of the box of the active ones, and where its first node lies: (array (x, y, z) of float32, origin).

        The array is a copy, as a grid holds the nodes near a surface alone.
        """
        array, index = self._grid.array()
        return array, self._grid.to_world(tuple(map(float, index)))

    def sample(self, points):
        """The grid at points (..., 3), read trilinearly: an array (...) of float64."""
        return self._grid.sample(points)

    def write(self, path):
        """Writes a file of the grid, whole or not at all: a VDB, or by its extension another format of grids, such as .nvdb."""
        self._grid.write(os.fspath(path))

    def to_pyopenvdb(self):
        """The same grid as one of pyopenvdb, which Debian has as python3-openvdb. It goes through a file."""
        import pyopenvdb

        with tempfile.TemporaryDirectory(prefix="juliavdb_") as folder:
            path = str(pathlib.Path(folder) / "grid.vdb")
            self.write(path)
            return pyopenvdb.read(path, self.name)

    @classmethod
    def from_pyopenvdb(cls, grid):
        """The grid of a FloatGrid of pyopenvdb, through a file."""
        import pyopenvdb

        with tempfile.TemporaryDirectory(prefix="juliavdb_") as folder:
            path = str(pathlib.Path(folder) / "grid.vdb")
            pyopenvdb.write(path, grids=[grid])
            return cls.read(path, grid.name)

    def __reduce__(self):
        with tempfile.TemporaryDirectory(prefix="juliavdb_") as folder:
            path = pathlib.Path(folder) / "grid.vdb"
            self.write(path)
            return _unpickled, (path.read_bytes(), self.name)


def _unpickled(data, name):
    with tempfile.TemporaryDirectory(prefix="juliavdb_") as folder:
        path = pathlib.Path(folder) / "grid.vdb"
        path.write_bytes(data)
        return Grid.read(path, name)


@_options.documented(SDF)
def sdf(vertices=None, faces=None, *, progress=None, memory=None, threads=None, **options):
    """Makes the signed distances of a mesh, as 'juliavdb sdf' does, and returns them as a Grid: a narrow band, negative
    inside. The mesh is a file or arrays, as for fractal()."""
    return Grid._of(_juliavdb.sdf(*_target.given(vertices, faces, options), (memory, threads, None), progress))

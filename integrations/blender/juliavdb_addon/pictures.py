# SPDX-License-Identifier: Apache-2.0
"""The textures that the program has, and a small picture of each.

The program makes the pictures once, by `juliavdb render --field` of a ball, into a folder of the user's cache. Each
version of the program has pictures of its own.
"""

import os
import pathlib
import tempfile
import time

import bpy
import bpy.utils.previews
import numpy

from . import ply, program as programs

SIZE = 128
# How the pictures show the ball.
VIEW = ("--colour", "clay", "--sdf-resolution", "80", "--size", f"{SIZE}x{SIZE}")
# Not a texture with a name, but it can be chosen like one.
RANDOM = {"name": "random", "description": "Random roots, another texture for every seed.", "seed": True}
# After a program that did not answer, in seconds.
ASK_AGAIN = 5


class _Shelf:
    """What is known of one program."""

    def __init__(self, program):
        self.program = program
        self.asked = time.monotonic()
        try:
            self.version = programs.version(program)
            self.textures = [*programs.textures(program), RANDOM]
            self.error = ""
        except (programs.ProgramError, ValueError, KeyError) as error:
            self.version = ""
            self.textures = []
            self.error = str(error)


_shelf = None
_previews = None
# Blender keeps no reference to the texts of the items of an enumeration.
_items = []


def shelf(program):
    global _shelf
    if (_shelf is None or _shelf.program != program
            or (_shelf.error and time.monotonic() - _shelf.asked > ASK_AGAIN)):
        _shelf = _Shelf(program)
        _load()
    return _shelf


def has_seed(program, name):
    """Whether a seed varies the texture. What is not on the shelf may be a file, which has no seed."""
    return any(texture["name"] == name and texture["seed"] for texture in shelf(program).textures)


def _names(program):
    return [texture["name"] for texture in shelf(program).textures]


def place(program, name):
    """The place of a texture in the list; one after the last if it is not there."""
    names = _names(program)
    return names.index(name) if name in names else len(names)


def name_at(program, index):
    names = _names(program)
    return names[index] if index < len(names) else "scales"


def items(program):
    """For an EnumProperty, with pictures as far as they are made. The last item stands for a texture that is not on
    the shelf, such as a file that a script has chosen."""
    global _items
    textures = shelf(program).textures
    _items = [(texture["name"], texture["name"].capitalize(), texture["description"], icon(texture["name"]), index)
              for index, texture in enumerate(textures)]
    _items.append(("OTHER", "Other", "A texture that this program does not list", 0, len(textures)))
    return _items


def folder(version):
    """Where the pictures of a version of the program lie."""
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return pathlib.Path(cache, "juliavdb", "textures", version.replace(" ", "-"))


def _file(version, name):
    return folder(version) / f"{name}.png"


def missing(program):
    """The names of the textures that have no picture yet."""
    known = shelf(program)
    return [name for name in _names(program) if not _file(known.version, name).exists()]


def icon(name):
    return _previews[name].icon_id if _previews is not None and name in _previews else 0


def _load():
    """Reads the pictures that are there."""
    if _previews is None:
        return
    _previews.clear()
    for texture in _shelf.textures:
        path = _file(_shelf.version, texture["name"])
        if path.exists():
            _previews.load(texture["name"], str(path), "IMAGE")


def ball(rings=48, across=96):
    """Points and triangles of a ball about the Y axis."""
    u, v = numpy.meshgrid(numpy.arange(1, rings) * numpy.pi / rings, numpy.arange(across) * 2 * numpy.pi / across,
                          indexing="ij")
    points = numpy.stack([numpy.sin(u) * numpy.cos(v), numpy.cos(u), numpy.sin(u) * numpy.sin(v)], -1).reshape(-1, 3)
    top, bottom = len(points), len(points) + 1
    points = numpy.concatenate([points, [[0, 1, 0], [0, -1, 0]]])
    a = numpy.arange(top).reshape(rings - 1, across)
    b = numpy.roll(a, -1, 1)
    quads = (a[:-1], b[:-1], a[1:], b[1:])
    triangles = [numpy.stack([quads[i] for i in corners], -1).reshape(-1, 3) for corners in ((0, 1, 2), (1, 3, 2))]
    triangles.append(numpy.stack([numpy.full(across, top), b[0], a[0]], -1))
    triangles.append(numpy.stack([numpy.full(across, bottom), a[-1], b[-1]], -1))
    return points, numpy.concatenate(triangles)


class Pictures:
    """Makes the missing pictures, one after the other. To be polled like program.Run."""

    title = "Pictures of textures"

    def __init__(self, program):
        """Raises ProgramError if the program cannot be started."""
        self.message = ""
        self.failed = False
        self._program = program
        self._version = shelf(program).version
        if shelf(program).error:
            raise programs.ProgramError(shelf(program).error)
        self._names = missing(program)
        self._number = max(len(self._names), 1)
        self._run = None
        target = folder(self._version)
        try:
            target.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise programs.ProgramError(f"{target}: {error.strerror}") from error
        self._scratch = tempfile.TemporaryDirectory(prefix="juliavdb_")
        self._mesh = os.path.join(self._scratch.name, "ball.ply")
        pathlib.Path(self._mesh).write_bytes(ply.encoded(*ball()))
        self._cancelled = False

    @property
    def share(self):
        done = self._number - len(self._names) + (self._run.share if self._run else 0)
        return min(done / self._number, 1)

    @property
    def text(self):
        return self._names[0] if self._names else ""

    def poll(self):
        """True while there is more to do."""
        try:
            return self._go_on()
        except programs.ProgramError as error:
            return self._finish(str(error), True)

    def _go_on(self):
        if self._run is not None:
            code = self._run.poll()
            if code is None:
                return True
            if code:
                error = self._run.error()
                return self._finish("Cancelled" if self._cancelled else error, not self._cancelled)
            self._names.pop(0)
            self._run = None
        if self._cancelled:
            return self._finish("Cancelled", False)
        if not self._names:
            return self._finish("", False)
        name = self._names[0]
        self._run = programs.Run(self._program, ["render", "--field", self._mesh, "-o",
                                                 str(_file(self._version, name)), "--versor", name, *VIEW])
        return True

    def _finish(self, message, failed):
        self._run = None
        self.message = message
        self.failed = failed
        self._scratch.cleanup()
        _load()
        return False

    def cancel(self):
        self._cancelled = True
        if self._run is not None:
            self._run.cancel()

    def stop(self):
        """Cancels, and returns when nothing runs any more."""
        self._cancelled = True
        if self._run is not None:
            self._run.stop()
        while self.poll():
            pass


def register():
    global _previews
    _previews = bpy.utils.previews.new()


def unregister():
    global _previews, _shelf
    bpy.utils.previews.remove(_previews)
    _previews = None
    _shelf = None

# SPDX-License-Identifier: Apache-2.0
"""The textures that the program has, and a small picture of each.

The program makes the pictures once, by `juliavdb render --field` of a ball, into a folder of the user's cache. Each
version of the program has pictures of its own.
"""

import os
import pathlib
import tempfile
import threading
import time

import bpy
import bpy.utils.previews
import numpy

from . import defaults, ply, program as programs

SIZE = 128
# How the pictures show the ball.
VIEW = ("--colour", "clay", "--sdf-resolution", "80", "--size", f"{SIZE}x{SIZE}")
# Not a texture with a name, but it can be chosen like one.
RANDOM = {"name": "random", "description": "Random roots, another texture for every seed.", "seed": True,
          "follows_thickness": False}
# After a program that did not answer, in seconds.
ASK_AGAIN = 5
# How often one looks whether it has answered, in seconds.
INTERVAL = 0.2


class _Shelf:
    """What is known of one program."""

    def __init__(self, program):
        self.program = program
        self.asked = time.monotonic()
        try:
            self.version = programs.version(program)
            self.textures = [*programs.textures(program), RANDOM]
            self.options = programs.options(program)
            self.error = ""
        except (programs.ProgramError, ValueError, KeyError, TypeError) as error:
            self.version = ""
            self.textures = []
            self.options = {}
            self.error = str(error) or f"'{program}' is not this version of juliavdb"


class _Question:
    """Asks a program in a thread of its own, which may take as long as the program likes."""

    def __init__(self, program):
        self.program = program
        self.answer = None
        self._thread = threading.Thread(target=self._ask, daemon=True)
        self._thread.start()

    def _ask(self):
        self.answer = _Shelf(self.program)

    def wait(self):
        self._thread.join()


_shelf = None
_question = None
_previews = None
# Blender keeps no reference to the texts of the items of an enumeration.
_items = []


def peek(program):
    """What is known of the program, or None while it is asked for the first time. It never waits: all that Blender calls
    to draw uses this."""
    global _question
    known = _shelf if _shelf is not None and _shelf.program == program else None
    stale = known is None or (known.error and time.monotonic() - known.asked > ASK_AGAIN)
    if stale and (_question is None or _question.program != program):
        _question = _Question(program)
        if not bpy.app.timers.is_registered(tick):
            bpy.app.timers.register(tick, first_interval=INTERVAL)
    return known


def tick():
    """Takes the answer of the program, once it is there. Returns the seconds until it should be called again, or None."""
    global _shelf, _question
    if _question is None:
        return None
    if _question.answer is None:
        return INTERVAL
    _shelf, _question = _question.answer, None
    _load()
    redraw()
    return None


def redraw():
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in {"VIEW_3D", "INFO"}:
                area.tag_redraw()


def shelf(program):
    """What is known of the program. Waits for its answer, so it is not for drawing."""
    peek(program)
    if _question is not None:
        _question.wait()
        tick()
    return _shelf


def _textures(program):
    known = peek(program)
    return known.textures if known else []


def has_seed(textures, name):
    """Whether a seed varies the texture. What is not on the shelf may be a file, which has no seed."""
    return any(texture["name"] == name and texture["seed"] for texture in textures)


def follows_thickness(textures, name):
    """Whether the texture has a frequency."""
    return any(texture["name"] == name and texture.get("follows_thickness", False) for texture in textures)


def _names(program):
    return [texture["name"] for texture in _textures(program)]


def place(program, name):
    """The place of a texture in the list; one after the last if it is not there, or the list is not known yet."""
    names = _names(program)
    return names.index(name) if name in names else len(names)


def name_at(program, index):
    names = _names(program)
    return names[index] if index < len(names) else defaults.text("texture")


def items(program):
    """For an EnumProperty, with pictures as far as they are made. The last item stands for a texture that is not on
    the shelf, such as a file that a script has chosen."""
    global _items
    textures = _textures(program)
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


def missing(known):
    """The names of the textures of a shelf that have no picture yet."""
    return [texture["name"] for texture in known.textures if not _file(known.version, texture["name"]).exists()]


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
        known = shelf(program)
        if known.error:
            raise programs.ProgramError(known.error)
        self._version = known.version
        self._names = missing(known)
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
                                                 str(_file(self._version, name)), "--texture", name, *VIEW])
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
    global _previews, _shelf, _question
    if bpy.app.timers.is_registered(tick):
        bpy.app.timers.unregister(tick)
    bpy.utils.previews.remove(_previews)
    _previews = None
    _shelf = None
    _question = None

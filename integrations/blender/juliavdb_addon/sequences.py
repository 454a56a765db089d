# SPDX-License-Identifier: Apache-2.0
"""Sequences: files whose names end in the number of a frame, and the objects that play them.

A volume plays its files by itself. Blender has nothing of the kind for meshes whose faces change from frame to frame, so a handler
gives a mesh the content of the file of each frame.
"""

import os
import re
import sys

import bpy
from bpy.app.handlers import persistent

from . import meshes, ply

# What the mesh of a sequence shows, so that no file is read twice in a row.
SHOWN = "juliavdb_shown"
# The name of a file: what is before its number, the number, and what is after it.
NUMBERED = re.compile(r"(.*?)(\d+)(\.[^./\\]*)", re.DOTALL)

# While it is true, meshes stay as they are. It is set while many frames are gone through for something else.
paused = False


def file_at(path, number):
    """The file of another frame, of the sequence to which a file belongs. Raises ValueError if its name has no number."""
    match = NUMBERED.fullmatch(path)
    if match is None:
        raise ValueError(f"{path}: the name has no number of a frame")
    before, digits, after = match.groups()
    return f"{before}{number:0{len(digits)}}{after}"


def found(path):
    """The numbers of the files of the sequence to which a file belongs, in their order; none if its name has no number."""
    match = NUMBERED.fullmatch(path)
    if not match:
        return []
    like = re.compile(r"\d{%d,}" % len(match[2]))
    before, after = os.path.basename(match[1]), match[3]
    numbers = set()
    for name in os.listdir(os.path.dirname(path) or "."):
        middle = name[len(before):len(name) - len(after)]
        if name.startswith(before) and name.endswith(after) and like.fullmatch(middle):
            if os.path.basename(file_at(path, int(middle))) == name:
                numbers.add(int(middle))
    return sorted(numbers)


def read(path, turned):
    """The content of a PLY as meshes.fill() takes it. `turned` says that Y is up in the file."""
    points, triangles, colours, velocities = ply.read(path)
    if turned:
        points, velocities = meshes.y_up_to_z_up(points), meshes.y_up_to_z_up(velocities)
    return points, triangles, colours, velocities


def set_mesh(thing, path, first, last, shift, turned):
    """The mesh object plays the sequence of this path, from now on. The file of a frame has the number of the frame plus `shift`."""
    entry = thing.juliavdb
    entry.sequence = path
    entry.sequence_first, entry.sequence_last, entry.sequence_shift, entry.sequence_turned = first, last, shift, turned
    # A handler changes the mesh while a picture is rendered, so the window must not draw it at the same time.
    for scene in thing.users_scene or bpy.data.scenes:
        scene.render.use_lock_interface = True


def set_volume(thing, path, first, last, shift):
    """The volume object plays the sequence of this path. Before the first file it shows the first one, after the last the last."""
    volume = thing.data
    entry = thing.juliavdb
    entry.sequence = path
    entry.sequence_first, entry.sequence_last, entry.sequence_shift = first, last, shift
    volume.filepath = file_at(path, first)
    volume.is_sequence = True
    volume.frame_start = first - shift
    volume.frame_duration = last - first + 1
    volume.frame_offset = first - 1
    volume.sequence_mode = "EXTEND"


def clear(thing):
    """The object is a still again."""
    thing.juliavdb.sequence = ""
    if thing.type == "VOLUME" and thing.data.is_sequence:
        thing.data.is_sequence = False


def show(thing, frame):
    """The mesh object gets the content of the file of this frame. If there is none, that of the latest frame before it which has one.

    Raises ValueError or OSError if the file cannot be read; the mesh stays as it is.
    """
    entry = thing.juliavdb
    number = max(entry.sequence_first, min(entry.sequence_last, frame + entry.sequence_shift))
    path = bpy.path.abspath(entry.sequence, library=thing.library)
    while number > entry.sequence_first and not os.path.exists(file_at(path, number)):
        number -= 1
    path = file_at(path, number)
    if thing.data.get(SHOWN) != path:
        meshes.fill(thing.data, *read(path, entry.sequence_turned))
        thing.data[SHOWN] = path


def _plays(thing):
    return thing.type == "MESH" and bool(thing.juliavdb.sequence) and thing.data.library is None and thing.mode != "EDIT"


@persistent
def play(scene, *_):
    """When the frame changes, in the window and in a render."""
    if paused:
        return
    for thing in scene.objects:
        if _plays(thing):
            try:
                show(thing, scene.frame_current)
            except (ValueError, OSError) as error:
                print(f"JuliaVDB: '{thing.name}' keeps the mesh of another frame: {error}", file=sys.stderr)


def register():
    bpy.app.handlers.frame_change_pre.append(play)


def unregister():
    bpy.app.handlers.frame_change_pre.remove(play)

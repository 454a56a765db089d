# SPDX-License-Identifier: Apache-2.0
"""JuliaVDB in Blender: a panel that turns the selected mesh into a fractal of the same shape.

The add-on starts the program `juliavdb` and reads its progress; it has no fractal code of its own. It is written for
Blender 3.4 and later; docs/blender.md describes what it does.

program.py  the program as a child process, without Blender
defaults.py the defaults of the program's options, without Blender
ply.py      reading and writing PLY, without Blender
meshes.py   Blender's meshes from and to arrays
settings.py the add-on's preferences, and the settings that every object keeps
pictures.py a small picture of each texture
sequences.py files for each frame, and what plays them
materials.py the materials of results, and nodes that make a surface of a volume
make.py     from the settings to the result in the scene
bring.py    File > Import > JuliaVDB
panel.py    what is seen
"""

bl_info = {
    "name": "JuliaVDB",
    "author": "JuliaVDB maintainers",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "3D Viewport > Sidebar > JuliaVDB",
    "description": "Turns a mesh into a fractal of the same shape, as a volume or a mesh",
    "category": "Object",
}

from . import bring, make, panel, pictures, sequences, settings

PARTS = (settings, pictures, sequences, make, bring, panel)


def register():
    for part in PARTS:
        part.register()


def unregister():
    for part in reversed(PARTS):
        part.unregister()

# SPDX-License-Identifier: Apache-2.0
"""Triangle meshes as binary PLY, from and to arrays of numpy. Nothing here knows Blender.

Blender's own importers are not used: their name and their options differ between 3.4 and 4.x.
"""

import numpy

TYPES = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "<i2", "int16": "<i2", "ushort": "<u2",
         "uint16": "<u2", "int": "<i4", "int32": "<i4", "uint": "<u4", "uint32": "<u4", "float": "<f4",
         "float32": "<f4", "double": "<f8", "float64": "<f8"}
COLOUR = ("red", "green", "blue")


def encoded(points, triangles, attributes=None):
    """The bytes of a PLY: points (n, 3), triangles (m, 3), and for each name of `attributes` n numbers."""
    attributes = attributes or {}
    names = ["x", "y", "z", *attributes]
    vertices = numpy.empty(len(points), dtype=[(name, "<f4") for name in names])
    for axis, name in enumerate("xyz"):
        vertices[name] = points[:, axis]
    for name, values in attributes.items():
        vertices[name] = values
    faces = numpy.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"] = 3
    faces["corners"] = triangles
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}",
              *(f"property float {name}" for name in names), f"element face {len(triangles)}",
              "property list uchar int vertex_indices", "end_header", ""]
    return "\n".join(header).encode("ascii") + vertices.tobytes() + faces.tobytes()


def _header(file, path):
    """The elements in their order: [name, number, [(property, type)]]; a list has the type (count, entry)."""
    lines = [file.readline().split()]
    while lines[-1][:1] != [b"end_header"]:
        line = file.readline()
        if not line:
            raise ValueError(f"{path}: this is not a PLY, or its header is cut off")
        lines.append(line.split())
    if lines[0] != [b"ply"] or lines[1][:2] != [b"format", b"binary_little_endian"]:
        raise ValueError(f"{path}: only binary little-endian PLY is read here")
    elements = []
    for words in ([word.decode("ascii") for word in line] for line in lines if line[:1] in ([b"element"], [b"property"])):
        if words[0] == "element":
            elements.append([words[1], int(words[2]), []])
        elif words[1] == "list":
            elements[-1][2].append((words[4], (TYPES[words[2]], TYPES[words[3]])))
        else:
            elements[-1][2].append((words[2], TYPES[words[1]]))
    return elements


def _linear(values):
    """Linear light of values in sRGB (IEC 61966-2-1): bytes of colours are stored so."""
    return numpy.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4).astype(numpy.float32)


def up_axis(path):
    """'y' or 'z' as juliavdb has written it into the file, or None."""
    with open(path, "rb") as file:
        for line in iter(file.readline, b""):
            words = line.decode("utf-8", "replace").split()
            if words[:1] == ["end_header"]:
                return None
            if words[:3] == ["comment", "juliavdb", "julia_up_axis"]:
                return words[3] if words[3:] in (["y"], ["z"]) else None
    return None


def read(path):
    """Points (n, 3), triangles (m, 3), the colours (n, 3) from 0 to 1 in linear light, or None, and the velocities (n, 3), or None.

    Raises ValueError if the file is anything but a mesh of triangles as juliavdb writes it.
    """
    with open(path, "rb") as file:
        tables = {}
        for name, number, properties in _header(file, path):
            fields = []
            for key, kind in properties:
                if isinstance(kind, tuple):
                    fields += [(key + " count", kind[0]), (key, kind[1], 3)]
                else:
                    fields.append((key, kind))
            table = numpy.fromfile(file, dtype=fields, count=number)
            if len(table) != number:
                raise ValueError(f"{path}: the file is cut off")
            tables[name] = table
    if "vertex" not in tables or "face" not in tables:
        raise ValueError(f"{path}: there is no mesh in it")
    vertices, faces = tables["vertex"], tables["face"]
    corners = next((key for key in ("vertex_indices", "vertex_index") if key in (faces.dtype.names or ())), None)
    if corners is None or not (faces[corners + " count"] == 3).all():
        raise ValueError(f"{path}: only triangles are read here")
    points = numpy.column_stack([vertices[axis] for axis in "xyz"]).astype(numpy.float32)
    colours = None
    if all(name in vertices.dtype.names for name in COLOUR):
        colours = numpy.column_stack([vertices[name] for name in COLOUR]).astype(numpy.float32)
        if vertices.dtype["red"] == numpy.uint8:
            colours = _linear(colours / 255)
    velocities = None
    if all(f"velocity_{axis}" in vertices.dtype.names for axis in "xyz"):
        velocities = numpy.column_stack([vertices[f"velocity_{axis}"] for axis in "xyz"]).astype(numpy.float32)
    return points, faces[corners].astype(numpy.int32), colours, velocities

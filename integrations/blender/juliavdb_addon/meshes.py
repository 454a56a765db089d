# SPDX-License-Identifier: Apache-2.0
"""Blender's meshes from and to arrays. Coordinates are those of the object itself, before its transform."""

import bpy
import numpy

from .program import ProgramError

# Of red, green and blue, as the program weighs the channels of a picture.
BRIGHTNESS = (0.2126, 0.7152, 0.0722)


def paint_name(source):
    """The name of the object's active colour attribute, or ''."""
    active = source.data.color_attributes.active_color if source.type == "MESH" else None
    return active.name if active else ""


def _floats(collection, name, width):
    values = numpy.empty(len(collection) * width, dtype=numpy.float32)
    collection.foreach_get(name, values)
    return values.reshape(-1, width)


def _colours(mesh, name):
    """The colour of each vertex, (n, 4), in linear light; of a vertex whose corners differ, their mean."""
    attribute = mesh.color_attributes.get(name)
    if attribute is None or len(attribute.data) == 0:
        raise ProgramError(f"The colour attribute '{name}' does not survive the modifiers of the object")
    return _at_vertices(mesh, attribute, _floats(attribute.data, "color", 4))


def _vectors(mesh, name):
    """The vector of each vertex, (n, 3)."""
    attribute = mesh.attributes.get(name)
    if attribute is None or attribute.data_type != "FLOAT_VECTOR" or attribute.domain not in ("POINT", "CORNER"):
        known = [each.name for each in mesh.attributes
                 if each.data_type == "FLOAT_VECTOR" and each.domain in ("POINT", "CORNER") and each.name != "position"]
        raise ProgramError(f"The mesh has no attribute '{name}' of vectors on its vertices for the grain to follow; choose one under "
                           f"Vectors; it has {', '.join(known) or 'none'}")
    return _at_vertices(mesh, attribute, _floats(attribute.data, "vector", 3))


def _at_vertices(mesh, attribute, values):
    """The values of an attribute at the vertices; where those of a vertex's corners differ, their mean."""
    if attribute.domain == "POINT":
        return values
    owners = numpy.empty(len(mesh.loops), dtype=numpy.int32)
    mesh.loops.foreach_get("vertex_index", owners)
    number = numpy.maximum(numpy.bincount(owners, minlength=len(mesh.vertices)), 1)
    return numpy.column_stack([numpy.bincount(owners, values[:, channel], len(mesh.vertices)) / number
                               for channel in range(values.shape[1])])


def to_arrays(source, context, paint="", combed=None):
    """The object's points, triangles and attributes as ply.encoded() takes them, with the modifiers applied, and a vector for
    each point.

    `paint` names a colour attribute, which becomes red, green, blue, alpha and brightness. `combed` names the attribute of the
    vectors; without it they are 0.
    Raises ProgramError if there is nothing to make a fractal from.
    """
    if source.mode == "EDIT":
        source.update_from_editmode()
    # Blender leaves out the modifiers of what is hidden.
    hidden = source.hide_get()
    hidden_everywhere = source.hide_viewport
    source.hide_set(False)
    source.hide_viewport = False
    try:
        depsgraph = context.evaluated_depsgraph_get()
        depsgraph.update()
        evaluated = source.evaluated_get(depsgraph)
        mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
        try:
            mesh.calc_loop_triangles()
            if not mesh.loop_triangles:
                raise ProgramError(f"'{source.name}' has no faces")
            points = _floats(mesh.vertices, "co", 3)
            triangles = numpy.empty(3 * len(mesh.loop_triangles), dtype=numpy.int32)
            mesh.loop_triangles.foreach_get("vertices", triangles)
            vectors = numpy.zeros_like(points) if combed is None else _vectors(mesh, combed)
            attributes = {}
            if paint:
                colours = _colours(mesh, paint)
                attributes = dict(zip(("red", "green", "blue", "alpha"), colours.T))
                attributes["brightness"] = colours[:, :3] @ numpy.array(BRIGHTNESS)
        finally:
            evaluated.to_mesh_clear()
    finally:
        source.hide_viewport = hidden_everywhere
        source.hide_set(hidden)
    return points, triangles.reshape(-1, 3), attributes, vectors


def from_arrays(name, points, triangles, colours=None, velocities=None):
    """A new mesh, shaded smooth. Colours, if any, become the colour attribute `Cd`, and velocities, per second, the attribute
    `velocity`, by which Cycles blurs what moves."""
    mesh = bpy.data.meshes.new(name)
    count = len(triangles)
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", numpy.ascontiguousarray(points, dtype=numpy.float32).ravel())
    mesh.loops.add(3 * count)
    mesh.loops.foreach_set("vertex_index", numpy.ascontiguousarray(triangles, dtype=numpy.int32).ravel())
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", numpy.arange(0, 3 * count, 3, dtype=numpy.int32))
    # Blender finds it out by itself since the version in which it cannot be set any more.
    if not bpy.types.MeshPolygon.bl_rna.properties["loop_total"].is_readonly:
        mesh.polygons.foreach_set("loop_total", numpy.full(count, 3, dtype=numpy.int32))
    mesh.polygons.foreach_set("use_smooth", numpy.ones(count, dtype=bool))
    if colours is not None:
        attribute = mesh.color_attributes.new("Cd", "FLOAT_COLOR", "POINT")
        values = numpy.ones((len(points), 4), dtype=numpy.float32)
        values[:, :3] = colours
        attribute.data.foreach_set("color", values.ravel())
    if velocities is not None:
        attribute = mesh.attributes.new("velocity", "FLOAT_VECTOR", "POINT")
        attribute.data.foreach_set("vector", numpy.ascontiguousarray(velocities, dtype=numpy.float32).ravel())
    mesh.update(calc_edges=True)
    return mesh


# The program's textures and thumbnails are upright along Y, as the meshes of the papers are; Blender is upright along Z.
def z_up_to_y_up(points):
    return numpy.column_stack([points[:, 0], points[:, 2], -points[:, 1]])


def y_up_to_z_up(points):
    return points if points is None else numpy.column_stack([points[:, 0], -points[:, 2], points[:, 1]])

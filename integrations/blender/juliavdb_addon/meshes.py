# SPDX-License-Identifier: Apache-2.0
"""Blender's meshes from and to arrays. Coordinates are those of the object itself, before its transform."""

import contextlib
import typing

import bpy
import numpy

from .program import ProgramError

# Of red, green and blue, as the program weighs the channels of a picture.
BRIGHTNESS = (0.2126, 0.7152, 0.0722)
# The modifiers that move the points of a mesh and keep its faces. Those that only give a mesh its form, such as Displace and
# Smooth, belong to the mesh at rest as well.
MOVING = {"ARMATURE", "CAST", "CLOTH", "CORRECTIVE_SMOOTH", "CURVE", "HOOK", "LAPLACIANDEFORM", "LATTICE", "MESH_CACHE", "MESH_DEFORM",
          "MESH_SEQUENCE_CACHE", "OCEAN", "SIMPLE_DEFORM", "SOFT_BODY", "SURFACE_DEFORM", "WARP", "WAVE"}


class Arrays(typing.NamedTuple):
    """A mesh as ply.encoded() takes it, with a vector for each point."""
    points: numpy.ndarray
    triangles: numpy.ndarray
    attributes: dict
    vectors: numpy.ndarray
    corners: numpy.ndarray   # the points of all faces, one face after the other
    sizes: numpy.ndarray     # the number of corners of each face


def _moves(modifier):
    generates = modifier.type == "OCEAN" and modifier.geometry_mode != "DISPLACE"
    return modifier.type in MOVING and modifier.show_viewport and not generates


def _keys(source):
    """The shape keys of a mesh object, if they can do something, or None."""
    keys = source.data.shape_keys if source.type == "MESH" else None
    return keys if keys is not None and len(keys.key_blocks) > 1 else None


def _parent_moves(source):
    """Whether a parent bends the object without a modifier, as in old files."""
    return source.parent is not None and source.parent_type in ("ARMATURE", "LATTICE")


def what_moves(source):
    """What moves the points of the object's mesh: the names of modifiers, `shape keys`, and the name of a parent that bends it."""
    names = [modifier.name for modifier in source.modifiers if _moves(modifier)]
    if _keys(source):
        names.append("shape keys")
    if _parent_moves(source):
        names.append(source.parent.name)
    return names


@contextlib.contextmanager
def _without_motion(source):
    """Within it, the object is without all that what_moves() names."""
    keys = _keys(source)
    if keys and source.mode == "EDIT":
        raise ProgramError(f"'{source.name}' has shape keys, and cannot stick to its surface in Edit Mode; leave Edit Mode first")
    paused = [modifier for modifier in source.modifiers if _moves(modifier)]
    pinned, active, parent_type = source.show_only_shape_key, source.active_shape_key_index, source.parent_type
    bent = _parent_moves(source)
    try:
        for modifier in paused:
            modifier.show_viewport = False
        if keys:
            source.active_shape_key_index = keys.key_blocks.find(keys.reference_key.name)
            source.show_only_shape_key = True
        if bent:
            source.parent_type = "OBJECT"
        yield
    finally:
        for modifier in paused:
            modifier.show_viewport = True
        if keys:
            source.show_only_shape_key, source.active_shape_key_index = pinned, active
        if bent:
            source.parent_type = parent_type


@contextlib.contextmanager
def shown(source):
    """Within it, the object is shown, because Blender leaves out the modifiers of what is hidden."""
    hidden, hidden_everywhere = source.hide_get(), source.hide_viewport
    source.hide_set(False)
    source.hide_viewport = False
    try:
        yield
    finally:
        source.hide_viewport = hidden_everywhere
        source.hide_set(hidden)


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
    """The object's mesh, with the modifiers applied.

    `paint` names a colour attribute, which becomes red, green, blue, alpha and brightness. `combed` names the attribute of the
    vectors; without it they are 0.
    Raises ProgramError if there is nothing to make a fractal from.
    """
    if source.mode == "EDIT":
        source.update_from_editmode()
    with shown(source):
        depsgraph = context.evaluated_depsgraph_get()
        depsgraph.update()
        evaluated = source.evaluated_get(depsgraph)
        mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
        try:
            mesh.calc_loop_triangles()
            if not mesh.loop_triangles:
                raise ProgramError(f"'{source.name}' has no faces")
            points = _floats(mesh.vertices, "co", 3)
            triangles, corners, sizes = (numpy.empty(count, dtype=numpy.int32)
                                         for count in (3 * len(mesh.loop_triangles), len(mesh.loops), len(mesh.polygons)))
            mesh.loop_triangles.foreach_get("vertices", triangles)
            mesh.loops.foreach_get("vertex_index", corners)
            mesh.polygons.foreach_get("loop_total", sizes)
            vectors = numpy.zeros_like(points) if combed is None else _vectors(mesh, combed)
            attributes = {}
            if paint:
                colours = _colours(mesh, paint)
                attributes = dict(zip(("red", "green", "blue", "alpha"), colours.T))
                attributes["brightness"] = colours[:, :3] @ numpy.array(BRIGHTNESS)
        finally:
            evaluated.to_mesh_clear()
    return Arrays(points, triangles.reshape(-1, 3), attributes, vectors, corners, sizes)


def at_rest(source, context, paint="", combed=None):
    """The same, without what moves the points of the object.

    Raises ProgramError as well if it cannot be told what the object is at rest.
    """
    with _without_motion(source):
        rest = to_arrays(source, context, paint, combed)
    context.evaluated_depsgraph_get().update()
    return rest


def check_faces(source, rest, pose, when=""):
    """Raises ProgramError if the two do not have the same faces. `when` says which pose it is."""
    if len(rest.points) != len(pose.points) or len(rest.sizes) != len(pose.sizes):
        found = (f"it has {len(pose.points)} points and {len(pose.sizes)} faces{when}, but {len(rest.points)} points and "
                 f"{len(rest.sizes)} faces at rest")
    elif numpy.array_equal(rest.sizes, pose.sizes) and numpy.array_equal(rest.corners, pose.corners):
        return
    else:
        found = f"its faces have other corners{when} than at rest"
    raise ProgramError(f"'{source.name}' cannot stick to its surface: {found}, without {' and '.join(what_moves(source))}. A modifier "
                       "makes other faces of the pose; apply it, or switch off Stick to the Surface")


def from_arrays(name, points, triangles, colours=None, velocities=None):
    """A new mesh, as fill() makes it."""
    mesh = bpy.data.meshes.new(name)
    fill(mesh, points, triangles, colours, velocities)
    return mesh


def fill(mesh, points, triangles, colours=None, velocities=None):
    """Makes this the content of a mesh, shaded smooth; its materials stay. Colours, if any, become the colour attribute `Cd`, and
    velocities, per second, the attribute `velocity`, by which Cycles blurs what moves."""
    mesh.clear_geometry()
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


# The program's textures and thumbnails are upright along Y, as the meshes of the papers are; Blender is upright along Z.
def z_up_to_y_up(points):
    return numpy.column_stack([points[:, 0], points[:, 2], -points[:, 1]])


def y_up_to_z_up(points):
    return points if points is None else numpy.column_stack([points[:, 0], -points[:, 2], points[:, 1]])

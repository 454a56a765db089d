# SPDX-License-Identifier: Apache-2.0
"""The materials of results, and nodes that make a surface of a volume."""

import bpy

# How opaque a volume is: its density times its longest side, in the units of its object.
OPACITY = 60
# Where the fog of a volume of juliavdb begins.
THRESHOLD = 0.02
SURFACE_NODES = "JuliaVDB Surface"


def _fresh(name, output="ShaderNodeOutputMaterial"):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    return material, nodes, material.node_tree.links, nodes.new(output)


def fog(density, coloured=False):
    """A new material for volumes that is as opaque as cloth at this density per unit of length. With colours, those of
    the grid Cd."""
    material, nodes, links, output = _fresh("Fractal fog")
    shader = nodes.new("ShaderNodeVolumePrincipled")
    shader.location.x = output.location.x - 300
    shader.inputs["Density"].default_value = density
    if coloured:
        shader.inputs["Color Attribute"].default_value = "Cd"
    links.new(shader.outputs["Volume"], output.inputs["Volume"])
    return material


def surface(coloured=False):
    """A new material for meshes. With colours, those of the attribute Cd."""
    material, nodes, links, output = _fresh("Fractal colours" if coloured else "Fractal")
    shader = nodes.new("ShaderNodeBsdfPrincipled")
    shader.location.x = output.location.x - 300
    shader.inputs["Roughness"].default_value = 0.6
    if coloured:
        attribute = nodes.new("ShaderNodeAttribute")
        attribute.location.x = shader.location.x - 300
        attribute.attribute_name = "Cd"
        links.new(attribute.outputs["Color"], shader.inputs["Base Color"])
    links.new(shader.outputs["BSDF"], output.inputs["Surface"])
    return material


def _socket(group, name, kind, is_input):
    if hasattr(group, "interface"):   # since Blender 4.0
        return group.interface.new_socket(name, in_out="INPUT" if is_input else "OUTPUT", socket_type=kind)
    return (group.inputs if is_input else group.outputs).new(kind, name)


def surface_nodes():
    """The geometry nodes that turn the fog of a volume into a smooth surface with a material. They are made once for a
    .blend, and marked as an asset."""
    group = bpy.data.node_groups.get(SURFACE_NODES)
    if group is not None:
        return group
    group = bpy.data.node_groups.new(SURFACE_NODES, "GeometryNodeTree")
    _socket(group, "Geometry", "NodeSocketGeometry", True)
    threshold = _socket(group, "Threshold", "NodeSocketFloat", True)
    threshold.default_value = THRESHOLD
    _socket(group, "Material", "NodeSocketMaterial", True)
    _socket(group, "Geometry", "NodeSocketGeometry", False)
    nodes, links = group.nodes, group.links
    begin, end = nodes.new("NodeGroupInput"), nodes.new("NodeGroupOutput")
    mesh, smooth, paint = (nodes.new(f"GeometryNode{kind}") for kind in ("VolumeToMesh", "SetShadeSmooth", "SetMaterial"))
    for place, node in enumerate((begin, mesh, smooth, paint, end)):
        node.location.x = 200 * place
    links.new(begin.outputs["Geometry"], mesh.inputs["Volume"])
    links.new(begin.outputs["Threshold"], mesh.inputs["Threshold"])
    links.new(mesh.outputs["Mesh"], smooth.inputs["Geometry"])
    links.new(smooth.outputs["Geometry"], paint.inputs["Geometry"])
    links.new(begin.outputs["Material"], paint.inputs["Material"])
    links.new(paint.outputs["Geometry"], end.inputs["Geometry"])
    group.asset_mark()
    return group


def _identifier(group, name):
    """By which a modifier has the value of an input."""
    sockets = group.interface.items_tree if hasattr(group, "interface") else group.inputs
    return next(socket.identifier for socket in sockets if socket.name == name and getattr(socket, "in_out", "INPUT") == "INPUT")


def add_surface(volume):
    """Gives a volume object the modifier with these nodes, once."""
    group = surface_nodes()
    for modifier in volume.modifiers:
        if modifier.type == "NODES" and modifier.node_group == group:
            return modifier
    modifier = volume.modifiers.new(SURFACE_NODES, "NODES")
    modifier.node_group = group
    modifier[_identifier(group, "Threshold")] = THRESHOLD
    modifier[_identifier(group, "Material")] = surface()
    return modifier

# SPDX-License-Identifier: Apache-2.0
"""Draws a PLY with the colours of its vertices in Blender, with flat light:

    blender --background --python docs/draw-colours.py -- F.ply F.png SIZE EYE LOOK_AT FOV

EYE and LOOK_AT are X,Y,Z in the file's coordinates, whose y is up, and FOV is in degrees, as for 'juliavdb render --field'.
"""
import math
import sys

import bpy
from mathutils import Matrix, Vector

mesh_file, picture, size, eye, look_at, fov = sys.argv[sys.argv.index("--") + 1:]
eye, look_at = (Vector(map(float, text.split(","))) for text in (eye, look_at))

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_mesh.ply(filepath=mesh_file)
mesh = bpy.context.object
material = bpy.data.materials.new("colours")
material.use_nodes = True
nodes = material.node_tree.nodes
nodes.clear()
colour, light, output = (nodes.new(kind) for kind in (
    "ShaderNodeVertexColor", "ShaderNodeEmission", "ShaderNodeOutputMaterial"))
colour.layer_name = mesh.data.color_attributes[0].name
material.node_tree.links.new(colour.outputs["Color"], light.inputs["Color"])
material.node_tree.links.new(light.outputs["Emission"], output.inputs["Surface"])
mesh.data.materials.clear()
mesh.data.materials.append(material)

camera = bpy.data.cameras.new("camera")
camera.sensor_fit, camera.angle_y = "VERTICAL", math.radians(float(fov))
camera.clip_end = 100 * (eye - look_at).length
seen_from = bpy.data.objects.new("camera", camera)
backward = (eye - look_at).normalized()
right = Vector((0, 1, 0)).cross(backward).normalized()
seen_from.matrix_world = Matrix.Translation(eye) @ Matrix((right, backward.cross(right), backward)).transposed().to_4x4()

scene = bpy.context.scene
scene.collection.objects.link(seen_from)
scene.camera = seen_from
scene.world = bpy.data.worlds.new("world")
scene.world.use_nodes = True
scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.6, 0.6, 0.6, 1)
scene.render.engine = "CYCLES"
scene.cycles.samples, scene.cycles.use_denoising = 4, False
scene.view_settings.view_transform = "Standard"
scene.render.resolution_x = scene.render.resolution_y = int(size)
scene.render.resolution_percentage = 100
scene.render.filepath = picture
bpy.ops.render.render(write_still=True)

# SPDX-License-Identifier: Apache-2.0
"""File > Import > JuliaVDB: meshes and volumes of the program, upright, smooth and with a material."""

import json
import math
import os

import bpy
from bpy.props import BoolProperty, StringProperty

from . import materials, meshes, ply, program as programs, sequences, settings


def mesh_object(path):
    """A mesh object of a PLY. A file that does not say which axis is up has Z up, as PLYs usually do."""
    points, triangles, colours, velocities = sequences.read(path, ply.up_axis(path) == "y")
    name = os.path.splitext(os.path.basename(path))[0]
    mesh = meshes.from_arrays(name, points, triangles, colours, velocities)
    mesh.materials.append(materials.surface(colours is not None))
    return bpy.data.objects.new(name, mesh)


def volume_object(path, program):
    """A volume object of a VDB. The program says which axis is up in it; by default it is Y."""
    name = os.path.splitext(os.path.basename(path))[0]
    volume = bpy.data.volumes.new(name)
    volume.filepath = path
    if not volume.grids.load():
        message = volume.grids.error_message
        bpy.data.volumes.remove(volume)
        raise programs.ProgramError(f"{path}: {message or 'there is no grid in it'}")
    names = [grid.name for grid in volume.grids]
    volume.grids.active_index = names.index("density") if "density" in names else 0
    volume.velocity_unit = "SECOND"
    told = json.loads(programs.answer(program, "info", "--json", os.path.abspath(path)))
    result = bpy.data.objects.new(name, volume)
    if told.get("metadata", {}).get("julia_up_axis", "y") == "y":
        result.rotation_euler.x = math.pi / 2
    box = [(grid["box min"], grid["box max"]) for grid in told["grids"] if "box min" in grid]
    longest = max((high - low for least, most in box for low, high in zip(least, most)), default=1) or 1
    volume.materials.append(materials.fog(materials.OPACITY / longest, "Cd" in names))
    return result


class Import(bpy.types.Operator):
    bl_idname = "juliavdb.import_file"
    bl_label = "Import JuliaVDB"
    bl_description = "Bring in a PLY or a VDB of juliavdb, upright, smooth and with a material"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(subtype="FILE_PATH")
    filter_glob: StringProperty(default="*.ply;*.vdb", options={"HIDDEN"})
    sequence: BoolProperty(
        name="Sequence", default=True,
        description="If the name of the file ends in a number, play all files whose names differ in this number only, each at its frame")

    def invoke(self, context, _):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        path = bpy.path.abspath(self.filepath)
        try:
            numbers = sequences.found(path) if self.sequence else []
            if len(numbers) > 1:
                path = sequences.file_at(path, max([number for number in numbers if number <= context.scene.frame_current],
                                                   default=numbers[0]))
            if path.lower().endswith(".vdb"):
                result = volume_object(path, settings.program(context))
            else:
                result = mesh_object(path)
        except (programs.ProgramError, ValueError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        context.collection.objects.link(result)
        if len(numbers) > 1:
            if result.type == "VOLUME":
                sequences.set_volume(result, path, numbers[0], numbers[-1], 0)
            else:
                sequences.set_mesh(result, path, numbers[0], numbers[-1], 0, ply.up_axis(path) == "y")
        for other in context.selected_objects:
            other.select_set(False)
        result.select_set(True)
        context.view_layer.objects.active = result
        return {"FINISHED"}


class AddSurface(bpy.types.Operator):
    bl_idname = "juliavdb.add_surface"
    bl_label = "Show as Surface"
    bl_description = "Give the volume geometry nodes that turn its fog into a smooth surface with a material"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == "VOLUME"

    def execute(self, context):
        context.object.data.grids.load()   # of a sequence, the file of this frame
        if "density" not in [grid.name for grid in context.object.data.grids]:
            self.report({"ERROR"}, "The volume has no grid 'density'; make it with --grids surface,density")
            return {"CANCELLED"}
        materials.add_surface(context.object)
        return {"FINISHED"}


def _menu(self, _):
    self.layout.operator(Import.bl_idname, text="JuliaVDB (.ply, .vdb)")


CLASSES = (Import, AddSurface)


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.TOPBAR_MT_file_import.append(_menu)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(_menu)
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)

# SPDX-License-Identifier: Apache-2.0
"""The panel in the sidebar of the 3D viewport."""

import textwrap

import bpy

from . import make, meshes, pictures, settings

# About as many letters as fit into the sidebar as wide as it is at first.
WIDTH = 26


class Panel(bpy.types.Panel):
    bl_idname = "VIEW3D_PT_juliavdb"
    bl_label = "JuliaVDB"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "JuliaVDB"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        source = make.source_for(context.object)
        if source is None:
            layout.label(text="Select a mesh object")
        else:
            column = layout.column()
            column.enabled = make.running is None
            _settings(column, context, source)
            _buttons(column, context)
            _motion(column, context, source)
        if make.running is not None:
            _progress(layout, make.running)
        _message(layout, context)


def _settings(layout, context, source):
    chosen = context.object.juliavdb
    if chosen.source is not None:
        layout.label(text=f"Made of {source.name}", icon="OUTLINER_OB_MESH")
    layout.prop(chosen, "detail", slider=True)
    layout.prop(chosen, "outward", slider=True)
    layout.prop(chosen, "resolution")
    known = pictures.peek(settings.program(context))
    if known is None:
        layout.label(text="Asking for the textures ...", icon="TIME")
    elif known.textures:
        # Without pictures it would be a large black rectangle.
        if pictures.icon(chosen.texture):
            layout.template_icon_view(chosen, "texture", show_labels=True, scale=6)
        layout.prop(chosen, "texture")
        row = layout.row()
        row.enabled = pictures.has_seed(known.textures, chosen.versor)
        row.prop(chosen, "seed")
        if settings.has_grain(chosen) or pictures.follows_thickness(known.textures, chosen.versor):
            layout.prop(chosen, "frequency")
        if settings.can_have_grain(chosen):
            layout.prop(chosen, "grain")
        if settings.has_grain(chosen):
            if chosen.grain == settings.COMBED:
                layout.prop_search(chosen, "grain_attribute", source.data, "attributes")
            layout.prop(chosen, "grain_turn")
        if chosen.versor == pictures.RANDOM["name"]:
            layout.prop(chosen, "roots")
            layout.prop(chosen, "power_low")
            layout.prop(chosen, "power_high")
        if pictures.missing(known):
            layout.operator("juliavdb.pictures", icon="IMAGE_DATA").wait = False
    layout.prop(chosen, "paint")
    if chosen.paint != "NONE":
        name = meshes.paint_name(source)
        layout.label(text=name or "There is no colour attribute", icon="GROUP_VCOL" if name else "ERROR")
        layout.prop(chosen, "paint_channel")
    if chosen.paint == "DETAIL":
        layout.prop(chosen, "detail_black", slider=True)
    layout.prop(chosen, "colour")
    if chosen.colour in settings.THROUGH_GRADIENT:
        layout.prop(chosen, "gradient")
    layout.prop(chosen, "up", expand=True)
    layout.prop(chosen, "repair")
    layout.prop(chosen, "more")
    layout.prop(chosen, "output", expand=True)
    if chosen.source is None:
        layout.prop(chosen, "material")
        layout.prop(chosen, "hide_source")
    if (chosen.output == "VOLUME" or chosen.sequence) and make.is_lost_with_blender(context):
        _wrapped(layout, "Save the .blend file first: until then, volumes are kept only while Blender runs.", "INFO")


def _buttons(layout, context):
    row = layout.row()
    row.scale_y = 1.4
    if settings.is_result(context.object):
        row.operator("juliavdb.update", icon="FILE_REFRESH").wait = False
        if context.object.type == "VOLUME":
            layout.operator("juliavdb.add_surface", icon="GEOMETRY_NODES")
        return
    row.operator("juliavdb.make", icon="PLAY").wait = False
    if settings.results_of(context.object):
        row.operator("juliavdb.update", icon="FILE_REFRESH").wait = False


def _motion(layout, context, source):
    chosen = context.object.juliavdb
    box = layout.box()
    moving = meshes.what_moves(source)
    if moving:
        box.prop(chosen, "stick")
        if chosen.stick and chosen.stick_refused:
            _wrapped(box, chosen.stick_refused, "ERROR")
        elif chosen.stick:
            _wrapped(box, f"At rest without {', '.join(moving)}", "ARMATURE_DATA")
    box.prop(chosen, "scene_range")
    if not chosen.scene_range:
        box.prop(chosen, "frame_first")
        box.prop(chosen, "frame_last")
    box.operator("juliavdb.animate", icon="RENDER_ANIMATION").wait = False


def _progress(layout, task):
    layout.label(text=task.title)
    text = f"{100 * task.share:.0f} %  {task.text}"
    if hasattr(layout, "progress"):   # since Blender 4.0
        layout.progress(factor=task.share, text=text)
    else:
        layout.label(text=text, icon="TIME")
    layout.operator("juliavdb.cancel", icon="CANCEL")


def _message(layout, context):
    known = pictures.peek(settings.program(context))
    message, failed = (known.error, True) if known and known.error else make.said
    if message:
        _wrapped(layout, message, "ERROR" if failed else "INFO")


def _wrapped(layout, text, icon):
    column = layout.column(align=True)
    for index, line in enumerate(textwrap.wrap(text, WIDTH)):
        column.label(text=line, icon=icon if index == 0 else "BLANK1")


def register():
    bpy.utils.register_class(Panel)


def unregister():
    bpy.utils.unregister_class(Panel)

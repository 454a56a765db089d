# SPDX-License-Identifier: Apache-2.0
"""The preferences of the add-on, and the settings that each object keeps: they are the recipe of a fractal."""

import math
import shlex

import bpy
from bpy.props import (BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty)

from . import defaults, pictures
from .program import ProgramError

# What a result takes over from the object that it was made of.
RECIPE = ("detail", "outward", "versor", "seed", "frequency", "roots", "power_low", "power_high", "resolution", "output",
          "grain", "grain_attribute", "grain_turn", "paint", "paint_channel", "detail_black", "colour", "gradient", "up", "repair", "more",
          "stick", "scene_range", "frame_first", "frame_last")
# The colours that have a gradient; the others are colours by themselves.
THROUGH_GRADIENT = ("trap", "iterations", "depth")
# The grain that an attribute of the mesh decides. Its vectors reach the program by this name.
COMBED = "combed"
POWERS = defaults.span("texture-powers")


class Preferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: StringProperty(
        name="Program", subtype="FILE_PATH", default="juliavdb",
        description="The program juliavdb: a name that is searched in PATH, or a path")
    folder: StringProperty(
        name="Volumes", subtype="DIR_PATH", default="//juliavdb",
        description="Where volumes are kept. A path that begins with // is beside the .blend file")

    def draw(self, context):
        self.layout.prop(self, "program")
        self.layout.prop(self, "folder")


def preferences(context):
    return context.preferences.addons[__package__].preferences


def program(context):
    chosen = preferences(context).program
    return bpy.path.abspath(chosen) if chosen.startswith("//") else chosen


def _texture_items(_, context):
    return pictures.items(program(context or bpy.context))


# Only the name of the texture is kept in the file. The number of an item is its place in a list that may grow.
def _texture_place(self):
    return pictures.place(program(bpy.context), self.versor)


def _choose_texture(self, place):
    self.versor = pictures.name_at(program(bpy.context), place)


class Settings(bpy.types.PropertyGroup):
    detail: FloatProperty(
        name="Detail", min=0, max=1, default=defaults.number("detail"), precision=2, step=5,
        description="How deep detail eats into the shape, as a share of its local thickness: 0.1 decorates it, "
                    "0.25 covers it, 0.8 leaves a thin core")
    outward: FloatProperty(
        name="Outward", min=0, max=1, default=defaults.number("outward"), precision=2, step=5,
        description="How far detail reaches out of the shape, as a share of its local thickness")
    versor: StringProperty(name="Texture", default=defaults.text("texture"), description="The name of the texture")
    texture: EnumProperty(
        name="Texture", items=_texture_items, get=_texture_place, set=_choose_texture,
        description="What the surface looks like")
    seed: IntProperty(
        name="Seed", min=0, default=defaults.whole("texture-seed"),
        description="Every number is another variation, of textures that have something random")
    frequency: FloatProperty(
        name="Frequency", min=0.05, soft_max=8, max=1000, default=defaults.number("frequency"), precision=2, step=10,
        description="How many features of the texture lie across the local thickness, of textures that follow it: 1 is "
                    "coarse, 2 medium, 4 fine")
    grain: EnumProperty(
        name="Grain", default="none", description="What the texture follows",
        items=[("none", "Nothing", "The texture is fixed to the axes of space"),
               ("along", "Along", "It runs along limbs, towards their thin ends"),
               ("around", "Around", "It runs around limbs"),
               ("curvature", "Curvature", "It runs along the least bending at each place"),
               ("down", "Down", "It hangs down"),
               (COMBED, "Combed", "It runs along the vectors of an attribute of the mesh")])
    grain_attribute: StringProperty(
        name="Vectors", description="An attribute of vectors on the points of the mesh, in its own coordinates. Where one is 0 or "
                                    "at a right angle to the surface, the surroundings decide")
    grain_turn: FloatProperty(
        name="Turn", subtype="ANGLE", default=0, soft_min=-math.pi, soft_max=math.pi,
        description="By how much the grain is turned in the surface, to the left as seen from outside")
    roots: IntProperty(
        name="Roots", min=1, soft_max=100, max=100000, default=defaults.whole("texture-roots"),
        description="The number of roots of a random texture")
    power_low: FloatProperty(
        name="Least Power", min=0.1, soft_max=30, max=1000, default=POWERS[0], precision=1, step=100,
        description="The least power of the roots of a random texture")
    power_high: FloatProperty(
        name="Greatest Power", min=0.1, soft_max=30, max=1000, default=POWERS[1], precision=1, step=100,
        description="The greatest power of the roots of a random texture. Higher powers make finer detail")
    resolution: IntProperty(
        name="Resolution", min=8, soft_max=1000, max=20000, default=defaults.whole("resolution"),
        description="Voxels along the longest side of the object")
    output: EnumProperty(
        name="Result", default="MESH",
        items=[("MESH", "Mesh", "Bring in the surface as a mesh"),
               ("VOLUME", "Volume", "Bring in a volume, an OpenVDB file with a fog and a level set")])
    paint: EnumProperty(
        name="Paint", default="NONE",
        description="What the active colour attribute of the object decides",
        items=[("NONE", "Nothing", "The colours are not used"),
               ("DETAIL", "Detail", "White has the detail that is set above, black the one below"),
               ("MASK", "Mask", "White becomes a fractal, black stays as it is")])
    paint_channel: EnumProperty(
        name="Channel", default="brightness", description="Which channel of the colour attribute to use",
        items=[("brightness", "Brightness", "0.2126 red + 0.7152 green + 0.0722 blue, in linear light"),
               ("red", "Red", ""), ("green", "Green", ""), ("blue", "Blue", ""), ("alpha", "Alpha", "")])
    detail_black: FloatProperty(
        name="Detail in black", min=0, max=1, default=0.05, precision=2, step=5,
        description="The detail where the paint is black")
    colour: EnumProperty(
        name="Colour", default="NONE", description="What the fractal is coloured by, as the colour attribute or grid Cd",
        items=[("NONE", "Nothing", "The fractal has no colours of its own"),
               ("direction", "Direction", "The direction of the first step, as red, green and blue"),
               ("versor", "Versor", "The versor of the texture, as red, green and blue"),
               ("trap", "Trap", "How near the orbit comes to the trap, through a gradient"),
               ("iterations", "Iterations", "How soon the orbit escapes, through a gradient"),
               ("depth", "Depth", "How deep in the shape a place lies, through a gradient")])
    gradient: EnumProperty(
        name="Gradient", default="viridis", description="The colours from the least number to the greatest",
        items=[(name, name.capitalize(), "") for name in ("viridis", "magma", "inferno", "cividis", "coolwarm", "grey")])
    material: BoolProperty(
        name="Material", default=True,
        description="Give a new mesh a material that shows its colours, or a plain one if the object has none")
    # The program takes Y for up by default. In Blender Z is up, so the default differs.
    up: EnumProperty(
        name="Up", default="Z", description="Which axis of the object the texture takes for upright",
        items=[("Z", "Z", "The vertical axis of Blender"), ("Y", "Y", "The vertical axis of many other programs")])
    repair: BoolProperty(
        name="Repair", default=False, description="Close the holes and gaps of an open mesh before it is used")
    more: StringProperty(
        name="More", description="More options of a recipe of 'juliavdb fractal', such as: --iterations 4 --largest 1")
    hide_source: BoolProperty(
        name="Hide Original", default=True, description="Hide the object itself, in the viewport and in renders")
    stick: BoolProperty(
        name="Stick to the Surface", default=True,
        description="The fractal is that of the object at rest, without what moves its points, and sticks to the surface as it moves")
    scene_range: BoolProperty(
        name="Range of the Scene", default=True, description="Make Animation makes all frames of the scene")
    frame_first: IntProperty(name="First Frame", default=1, description="The first frame that Make Animation makes")
    frame_last: IntProperty(name="Last Frame", default=24, description="The last frame that Make Animation makes")
    # Why the object did not stick to its surface when that was tried last, for the panel.
    stick_refused: StringProperty(options={"HIDDEN"})
    # Of results only.
    source: PointerProperty(type=bpy.types.Object, name="Made of")
    # Of what plays a sequence only: see sequences.py.
    sequence: StringProperty(name="Sequence", subtype="FILE_PATH", description="A file of the sequence that the object plays")
    sequence_first: IntProperty(description="The number of the first file of the sequence")
    sequence_last: IntProperty(description="The number of the last file of the sequence")
    sequence_shift: IntProperty(description="What the number of a file is more than the number of its frame")
    sequence_turned: BoolProperty(description="Y is up in the files of the sequence")

    def copy_recipe(self, other):
        for name in RECIPE:
            setattr(self, name, getattr(other, name))


def can_have_grain(settings):
    """Whether the texture can follow a grain: all but random roots can."""
    return settings.versor != pictures.RANDOM["name"]


def has_grain(settings):
    return settings.grain != "none" and can_have_grain(settings)


def words(settings):
    """The options of `juliavdb fractal` for these settings, without files.

    The settings are part of a .blend, which may be somebody else's. So every value stands behind the name of its option
    (--name=value), where it cannot be taken for another option, and a name under More must be that of an option of a
    recipe, in full.

    Raises ProgramError for words under More that cannot be given there.
    """
    known = pictures.shelf(program(bpy.context))
    result = [f"--outward={number(settings.outward)}", f"--texture={settings.versor}",
              f"--resolution={settings.resolution}"]
    channel = f"paint:{settings.paint_channel}"
    if settings.paint == "DETAIL":
        result.append(f"--detail={channel}:{number(settings.detail_black)}:{number(settings.detail)}")
    else:
        result.append(f"--detail={number(settings.detail)}")
    if settings.paint == "MASK":
        result.append(f"--mask={channel}")
    if pictures.has_seed(known.textures, settings.versor):
        result.append(f"--texture-seed={settings.seed}")
    if has_grain(settings):
        result.append("--grain=" + (f"paint:{COMBED}" if settings.grain == COMBED else settings.grain))
        if settings.grain_turn:
            result.append(f"--grain-turn={number(math.degrees(settings.grain_turn))}")
    if has_grain(settings) or pictures.follows_thickness(known.textures, settings.versor):
        result.append(f"--frequency={number(settings.frequency)}")
    if settings.versor == pictures.RANDOM["name"]:
        if settings.power_low > settings.power_high:
            raise ProgramError(f"The least power, {number(settings.power_low)}, is above the greatest, "
                               f"{number(settings.power_high)}")
        result += [f"--texture-roots={settings.roots}",
                   f"--texture-powers={number(settings.power_low)}:{number(settings.power_high)}"]
    if settings.colour != "NONE":
        through = f":{settings.gradient}" if settings.colour in THROUGH_GRADIENT else ""
        result.append(f"--colour={settings.colour}{through}")
    if settings.repair:
        result.append("--repair")
    # The attributes under More come beside that of the colours.
    more = _more(settings.more, known)
    listed = [word.partition("=")[2] for word in more if word.startswith("--attributes=")]
    attributes = ["Cd"] * (settings.colour != "NONE" and not any("Cd" in each.split(",") for each in listed)) + listed
    if attributes:
        result.append("--attributes=" + ",".join(attributes))
    return result + [word for word in more if not word.startswith("--attributes=")]


def _more(text, known):
    try:
        given = shlex.split(text)
    except ValueError as error:
        raise ProgramError(f"More options: '{text}': {error}") from error
    if given and known.error:
        raise ProgramError(known.error)
    result = []
    while given:
        word = given.pop(0)
        name, equals, value = word[2:].partition("=")
        if not word.startswith("--") or name not in known.options or name == "input":
            raise ProgramError(f"More options: '{word}' is not an option of a fractal's recipe; "
                               "give their full names, such as --iterations 4")
        if known.options[name]:
            if equals:
                raise ProgramError(f"More options: '{word}': --{name} takes no value")
            result.append(word)
            continue
        if not equals:
            if not given:
                raise ProgramError(f"More options: --{name} needs a value")
            value = given.pop(0)
        result.append(f"--{name}={value}")
    return result


def number(value):
    """As it was typed: Blender keeps floats of 32 bits, and 0.1 would become 0.10000000149."""
    return format(value, ".7g")


def frames(recipe, scene):
    """The first and the last frame of an animation, by what RECIPE names."""
    if recipe["scene_range"]:
        return scene.frame_start, scene.frame_end
    return recipe["frame_first"], recipe["frame_last"]


def is_result(candidate):
    return candidate is not None and candidate.juliavdb.source is not None


def results_of(source):
    """The objects that were made of this one, in the order of their names."""
    return [candidate for candidate in bpy.data.objects if candidate.juliavdb.source == source]


CLASSES = (Preferences, Settings)


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Object.juliavdb = PointerProperty(type=Settings)


def unregister():
    del bpy.types.Object.juliavdb
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)

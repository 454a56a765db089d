# SPDX-License-Identifier: Apache-2.0
"""From the settings of an object to its fractal in the scene: the operators, and the one task that runs at a time."""

import atexit
import contextlib
import hashlib
import math
import os
import pathlib
import re
import shlex
import shutil
import tempfile
import textwrap
import time

import bpy
import numpy
from bpy.app.handlers import persistent

from . import materials, meshes, pictures, ply, program as programs, sequences, settings

# How often a running task is looked at, in seconds.
INTERVAL = 0.2

# The task that runs, and what the last one had to say: (message, whether it failed).
running = None
said = ("", False)


def output_folder(context):
    """Where volumes go. The folder of a .blend that has no file yet is lost when Blender is closed."""
    folder = settings.preferences(context).folder
    if folder.startswith("//") and not bpy.data.filepath:
        return os.path.join(bpy.app.tempdir, "juliavdb")
    return os.path.abspath(bpy.path.abspath(folder))


def is_lost_with_blender(context):
    return settings.preferences(context).folder.startswith("//") and not bpy.data.filepath


def file_stem(name, data, words):
    """Such as 'Suzanne-1f0c77a2'. Another recipe has another name, so that undo finds the file it had before."""
    plain = re.sub(r"[^A-Za-z0-9_-]+", "_", name).strip("_") or "object"
    return f"{plain}-{hashlib.sha256(data + shlex.join(words).encode()).hexdigest()[:8]}"


class Making:
    """Makes the fractal of an object, or makes a result again.

    Everything is read from Blender when the task begins, so that the user may go on working.
    """

    def __init__(self, context, source, made_before=None):
        """`made_before` is the result that is replaced; its settings are used instead of those of the source.

        Raises ProgramError if there is nothing to make, or the program cannot be started.
        """
        owner = made_before or source
        self.title = f"Fractal of {source.name}"
        self.message = ""
        self.failed = False
        self._source = source.name
        self._made_before = made_before.name if made_before else None
        self._scene = context.scene.name
        self._layer = context.view_layer.name
        self._hide = source.juliavdb.hide_source and not made_before
        self._material = source.juliavdb.material
        # As a dictionary, because sliders may move while the program runs.
        self._recipe = {name: getattr(owner.juliavdb, name) for name in settings.RECIPE}
        self._volume = owner.juliavdb.output == "VOLUME"
        words = settings.words(owner.juliavdb)
        self._paint = meshes.paint_name(source) if owner.juliavdb.paint != "NONE" else ""
        if owner.juliavdb.paint != "NONE" and not self._paint:
            raise programs.ProgramError(f"'{source.name}' has no colour attribute; paint it, or set Paint to Nothing")
        self._combed = owner.juliavdb.grain_attribute if "--grain=paint:" + settings.COMBED in words else None
        self._scratch = None
        self._new = []        # what to remove if nothing comes of it
        self._whole = set()   # the folders of it that go with all that is in them
        try:
            self._prepare(context, source, self._rest(context, source, owner, words), words)
            self._run = programs.Run(settings.program(context), self._words)
        except OSError as error:
            self._clean_up()
            raise programs.ProgramError(f"{error.filename}: {error.strerror}") from error
        except programs.ProgramError:
            self._clean_up()
            raise

    def _rest(self, context, source, owner, words):
        """The source at rest, or None if its fractal need not or shall not stick to it."""
        owner.juliavdb.stick_refused = ""
        # Under More may stand another target at rest.
        if (not self._recipe["stick"] or not meshes.what_moves(source)
                or any(word.partition("=")[0] in ("--rest", "--rest-frame", "--rest-attribute") for word in words)):
            return None
        try:
            rest = meshes.at_rest(source, context, self._paint, self._combed)
            meshes.check_faces(source, rest, self._pose(context, source))
        except programs.ProgramError as error:
            owner.juliavdb.stick_refused = str(error)
            raise
        return rest

    def _pose(self, context, source):
        return meshes.to_arrays(source, context, self._paint, self._combed)

    def _encoded(self, mesh, triangles):
        points, vectors = mesh.points, mesh.vectors
        if self._recipe["up"] == "Z":
            points, vectors = meshes.z_up_to_y_up(points), meshes.z_up_to_y_up(vectors)
        attributes = dict(mesh.attributes)
        if self._combed is not None:
            attributes.update({f"{settings.COMBED}_{axis}": vectors[:, k] for k, axis in enumerate("xyz")})
        return ply.encoded(points, triangles, attributes)

    def _prepare(self, context, source, rest, words):
        """The folder and the files. A volume stays where it is made, with the meshes that its recipe names beside it."""
        pose = self._pose(context, source)
        # Blender may cut a face with four corners in another way in each pose.
        triangles = pose.triangles if rest is None else rest.triangles
        self._longest = float((pose.points.max(0) - pose.points.min(0)).max())
        data = {"source": self._encoded(pose, triangles)}
        if rest is not None and not numpy.array_equal(rest.points, pose.points):
            data["rest"] = self._encoded(rest, triangles)
        if self._volume:
            folder = pathlib.Path(output_folder(context))
            stem = file_stem(self._source, b"".join(data.values()), words)
            names = {key: folder / f"{stem}.{key}.ply" for key in data}
            self._file = folder / f"{stem}.vdb"
        else:
            self._scratch = tempfile.TemporaryDirectory(prefix="juliavdb_")
            names = {key: pathlib.Path(self._scratch.name, f"{key}.ply") for key in data}
            self._file = pathlib.Path(self._scratch.name, "result.ply")
        self._make_folder(self._file.parent)
        for key, path in names.items():
            if not path.exists():
                self._new.insert(0, path)
                path.write_bytes(data[key])
        self._words = ["fractal", str(names["source"]), *([f"--rest={names['rest']}"] if "rest" in names else []),
                       *self._target(str(self._file)), *words]

    def _make_folder(self, folder):
        for each in (folder, *folder.parents):
            if each.exists():
                break
            self._new.append(each)
        folder.mkdir(parents=True, exist_ok=True)

    def _target(self, file):
        return ["-o", file, "--grids", "surface,density"] if self._volume else ["--mesh", file]

    @property
    def share(self):
        return self._run.share

    @property
    def text(self):
        left = "" if self._run.left is None else f", {math.ceil(self._run.left)} s left"
        return f"{self._run.phase}{left}"

    def poll(self):
        """True while the program runs. When it has ended, brings in what it has made."""
        code = self._run.poll()
        if code is None:
            return True
        try:
            if code == 0:
                self._bring_in()
                self._new = []
                self.message = "; ".join(self._run.end.get("messages", [])[-1:])
            elif self._run.cancelled:
                self.message = "Cancelled"
            else:
                self.message, self.failed = self._run.error(), True
        except (programs.ProgramError, ValueError, OSError) as error:
            self.message, self.failed = str(error), True
        finally:
            self._clean_up()
        return False

    def cancel(self):
        self._run.cancel()

    def stop(self):
        """Cancels, and returns when nothing runs any more. Nothing is brought in."""
        self._run.stop()
        self._clean_up()

    def _clean_up(self):
        if self._scratch:
            self._scratch.cleanup()
            self._scratch = None
        for path in self._new:
            with contextlib.suppress(OSError):
                if path.is_dir() and path in self._whole:
                    shutil.rmtree(path)
                elif path.is_dir():
                    path.rmdir()
                else:
                    path.unlink()
        self._new = []

    def _bring_in(self):
        source = bpy.data.objects.get(self._source)
        scene = bpy.data.scenes.get(self._scene)
        if source is None or scene is None:
            raise programs.ProgramError(f"'{self._source}' is no longer there, so that its fractal has no place")
        old = bpy.data.objects.get(self._made_before) if self._made_before else None
        name = old.name if old else f"{self._source} fractal"
        result = (self._volume_object if self._volume else self._mesh_object)(name, old, source)
        for key, value in self._recipe.items():
            setattr(result.juliavdb, key, value)
        result.juliavdb.source = source
        result["juliavdb_command"] = shlex.join(["juliavdb", *self._words])
        result["juliavdb_version"] = pictures.shelf(settings.program(bpy.context)).version
        result["juliavdb_up"] = self._recipe["up"]
        if result is not old:
            self._place(result, source, scene, old)
        self._set_sequence(result, scene)

    def _set_sequence(self, result, _):
        sequences.clear(result)

    def _read_file(self):
        return str(self._file)

    def _mesh_object(self, name, old, source):
        points, triangles, colours, velocities = sequences.read(self._read_file(), self._recipe["up"] == "Z")
        mesh = meshes.from_arrays(name, points, triangles, colours, velocities)
        if old is None or old.type != "MESH":
            if self._material and (colours is not None or not source.data.materials):
                mesh.materials.append(materials.surface(colours is not None))
            else:
                for material in source.data.materials:
                    mesh.materials.append(material)
            return bpy.data.objects.new(name, mesh)
        replaced = old.data
        for material in replaced.materials:
            mesh.materials.append(material)
        old.data = mesh
        if replaced.users == 0:
            bpy.data.meshes.remove(replaced)
        mesh.name = name
        return old

    def _stored(self, path):
        """The path as the .blend shall have it."""
        if bpy.data.filepath and not is_lost_with_blender(bpy.context):
            with contextlib.suppress(ValueError):   # on another drive
                return bpy.path.relpath(path)
        return path

    def _volume_object(self, name, old, _):
        path = self._stored(self._read_file())
        fresh = old is None or old.type != "VOLUME"
        volume = bpy.data.volumes.new(name) if fresh else old.data
        if volume.is_sequence:
            volume.is_sequence = False
        volume.filepath = path
        if not volume.grids.load():
            raise programs.ProgramError(f"{path}: {volume.grids.error_message}")
        names = [grid.name for grid in volume.grids]
        volume.grids.active_index = names.index("density") if "density" in names else 0
        volume.velocity_unit = "SECOND"
        # The import operator of Blender would decide by the file's metadata whether to turn a volume; a volume whose
        # path is set here is never turned. So what was turned for the program is turned back by the object.
        if fresh:
            volume.materials.append(materials.fog(materials.OPACITY / self._longest, "Cd" in names))
            result = bpy.data.objects.new(name, volume)
            result.rotation_euler.x = math.pi / 2 if self._recipe["up"] == "Z" else 0
            return result
        if old.get("juliavdb_up") != self._recipe["up"]:
            old.rotation_euler.x += math.pi / 2 if self._recipe["up"] == "Z" else -math.pi / 2
        return old

    def _place(self, result, source, scene, old):
        """Links a new object beside its source, as its child; it takes the place of `old`, if there is one."""
        homes = old.users_collection if old else source.users_collection
        for home in homes or (scene.collection,):
            home.objects.link(result)
        result.parent = source
        if old:
            kept = old.name
            bpy.data.objects.remove(old)
            result.name = kept
        layer = scene.view_layers.get(self._layer)
        if layer is None:
            return
        layer.update()   # Blender finds out about the new object
        if result.name not in layer.objects:
            return
        for other in layer.objects:
            other.select_set(False, view_layer=layer)
        result.select_set(True, view_layer=layer)
        layer.objects.active = result
        if self._hide:
            source.hide_set(True, view_layer=layer)
            source.hide_render = True


class Animating(Making):
    """Makes a fractal for each frame by one run of the program. The files stay where they are made, in a folder of their own."""

    def _prepare(self, context, source, rest, words):
        first, last = settings.frames(self._recipe, context.scene)
        if first > last:
            raise programs.ProgramError(f"The first frame, {first}, is after the last one, {last}")
        # Blender plays no file whose number is negative.
        self._first, self._last, self._shift = first, last, max(0, -first)
        home = pathlib.Path(output_folder(context))
        self._make_folder(home)
        scratch = pathlib.Path(tempfile.mkdtemp(prefix="new_", dir=home))
        self._new.insert(0, scratch)
        self._whole.add(scratch)
        found = hashlib.sha256()
        with contextlib.closing(self._frames(context, source, rest)) as files:
            for name, data in files:
                found.update(data)
                (scratch / name).write_bytes(data)
        folder = home / file_stem(self._source, found.digest(), [*words, str(first), str(last)])
        if folder.exists():   # with the same sources; frames that are there are kept
            shutil.rmtree(scratch)
        else:
            scratch.rename(folder)
            self._whole.add(folder)
            self._new.insert(0, folder)
        self._new.remove(scratch)
        self._file = folder / ("fractal.####.vdb" if self._volume else "fractal.####.ply")
        self._words = ["fractal", str(folder / "source.####.ply"), "--frames", f"{self._number(first)}-{self._number(last)}",
                       *([f"--rest={folder / 'rest.ply'}"] if rest is not None else []), *self._target(str(self._file)), *words]

    def _number(self, frame):
        """The number of the file of a frame."""
        return frame + self._shift

    def _frames(self, context, source, rest):
        """The files of the source: of each frame, and at rest. Goes through the frames, and returns to the one that was shown."""
        scene, window = context.scene, context.window_manager
        shown, between = scene.frame_current, scene.frame_subframe
        self._longest = 0
        if rest is not None:
            yield "rest.ply", self._encoded(rest, rest.triangles)
        window.progress_begin(self._first, self._last + 1)
        sequences.paused = True
        try:
            with meshes.shown(source):
                for frame in range(self._first, self._last + 1):
                    window.progress_update(frame)
                    scene.frame_set(frame)
                    pose = self._pose(context, source)
                    if rest is not None:
                        meshes.check_faces(source, rest, pose, f" in frame {frame}")
                    self._longest = max(self._longest, float((pose.points.max(0) - pose.points.min(0)).max()))
                    yield (f"source.{self._number(frame):04}.ply",
                           self._encoded(pose, pose.triangles if rest is None else rest.triangles))
        finally:
            sequences.paused = False
            window.progress_end()
            scene.frame_set(shown, subframe=between)

    def _file_at(self, frame):
        return str(self._file).replace("####", f"{self._number(frame):04}")

    def _read_file(self):
        scene = bpy.data.scenes[self._scene]
        return self._file_at(max(self._first, min(self._last, scene.frame_current)))

    def _set_sequence(self, result, scene):
        path = self._stored(self._file_at(self._first))
        numbers = self._number(self._first), self._number(self._last), self._shift
        if result.type == "VOLUME":
            sequences.set_volume(result, path, *numbers)
        else:
            sequences.set_mesh(result, path, *numbers, self._recipe["up"] == "Z")
            sequences.show(result, scene.frame_current)


def run_to_the_end(task):
    """For scripts: returns when the task is done. Ctrl-C cancels it."""
    global said
    try:
        while task.poll():
            time.sleep(0.02)
    except BaseException:
        task.stop()
        raise
    said = (task.message, task.failed)


def start(task):
    """Goes on with the task while the user works."""
    global running, said
    running = task
    said = ("", False)
    bpy.app.timers.register(tick, first_interval=INTERVAL)


def tick():
    """Looks at the task that runs. Returns the seconds until it should be called again, or None."""
    global running, said
    task = running
    if task is None:
        return None
    try:
        goes_on = task.poll()
    except Exception as error:   # Blender would drop the timer, and the panel would wait for ever.
        running, said = None, (str(error), True)
        raise
    pictures.redraw()
    if goes_on:
        return INTERVAL
    running, said = None, (task.message, task.failed)
    if task.failed:
        _show_error(task.message)
    elif isinstance(task, Making) and bpy.ops.ed.undo_push.poll():
        bpy.ops.ed.undo_push(message=task.title)
    return None


def _show_error(message):
    """As a report in the Info editor, and as a popup where there is a window."""
    with contextlib.suppress(RuntimeError):   # An error that an operator reports is an exception for its caller.
        bpy.ops.juliavdb.report(message=message)
    if bpy.app.background:
        return

    def draw(menu, _):
        for line in textwrap.wrap(message, 90):
            menu.layout.label(text=line)
    bpy.context.window_manager.popup_menu(draw, title="JuliaVDB", icon="ERROR")


class Report(bpy.types.Operator):
    bl_idname = "juliavdb.report"
    bl_label = "Report an Error of JuliaVDB"
    bl_options = {"INTERNAL"}

    message: bpy.props.StringProperty()

    def execute(self, _):
        self.report({"ERROR"}, self.message)
        return {"CANCELLED"}


class _Task:
    """What the operators that start a task have in common."""

    wait: bpy.props.BoolProperty(
        name="Wait", default=True, options={"SKIP_SAVE"},
        description="Return when the task is done; otherwise it goes on in the background")

    @classmethod
    def poll(cls, _):
        return running is None

    def execute(self, context):
        try:
            task = self.task(context)
            if self.wait:
                run_to_the_end(task)
        except programs.ProgramError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if not self.wait:
            start(task)
        elif task.failed:
            self.report({"ERROR"}, task.message)
            return {"CANCELLED"}
        return {"FINISHED"}


def source_for(active):
    """The object that the active one is made from: itself, unless it is a result."""
    if settings.is_result(active):
        return active.juliavdb.source
    return active if active is not None and active.type == "MESH" else None


def _in_view(context, source, result):
    """The source. Raises ProgramError if it cannot be evaluated, because it is in another scene."""
    if source.name not in context.view_layer.objects:
        raise programs.ProgramError(f"'{source.name}', which '{result.name}' was made of, is not in this scene")
    return source


class Make(_Task, bpy.types.Operator):
    bl_idname = "juliavdb.make"
    bl_label = "Make Fractal"
    bl_description = "Make a fractal of the active object, which becomes its child"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.object is not None and context.object.type == "MESH"

    def task(self, context):
        return Making(context, context.object)


class Update(_Task, bpy.types.Operator):
    bl_idname = "juliavdb.update"
    bl_label = "Update Fractal"
    bl_description = "Make the fractal again, from its settings and from the object as it is now"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and bool(settings.is_result(context.object)
                                              or context.object and settings.results_of(context.object))

    def task(self, context):
        result = context.object
        if not settings.is_result(result):
            # From the object that it was made of: with its settings, as they are now.
            result = settings.results_of(context.object)[-1]
            result.juliavdb.copy_recipe(context.object.juliavdb)
        source = _in_view(context, result.juliavdb.source, result)
        return (Animating if result.juliavdb.sequence else Making)(context, source, result)


class Animate(_Task, bpy.types.Operator):
    bl_idname = "juliavdb.animate"
    bl_label = "Make Animation"
    bl_description = "Make a fractal of each frame, which the result plays. A result becomes an animation"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and source_for(context.object) is not None

    def task(self, context):
        result = context.object if settings.is_result(context.object) else None
        return Animating(context, _in_view(context, source_for(context.object), result), result)


class MakePictures(_Task, bpy.types.Operator):
    bl_idname = "juliavdb.pictures"
    bl_label = "Make Pictures of Textures"
    bl_description = "Show what each texture looks like. The pictures are made once, in about a minute"

    def task(self, context):
        return pictures.Pictures(settings.program(context))


class Cancel(bpy.types.Operator):
    bl_idname = "juliavdb.cancel"
    bl_label = "Cancel"
    bl_description = "Stop the program; it leaves nothing behind"

    @classmethod
    def poll(cls, _):
        return running is not None

    def execute(self, _):
        running.cancel()
        return {"FINISHED"}


@persistent
def stop_running(*_):
    """Before another file is opened, and when Blender ends: nobody would be there for the result."""
    global running
    task, running = running, None
    if task is not None:
        task.stop()


CLASSES = (Report, Make, Update, Animate, MakePictures, Cancel)


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.app.handlers.load_pre.append(stop_running)
    atexit.register(stop_running)


def unregister():
    stop_running()
    atexit.unregister(stop_running)
    bpy.app.handlers.load_pre.remove(stop_running)
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)

# SPDX-License-Identifier: Apache-2.0
"""JuliaVDB on a shelf of Houdini: makes a fractal of the selected geometry node, and loads it beside that node.

Copy this file and juliavdb_program.py into a folder of HOUDINI_PATH, python3.11libs for instance, and the line of
docs/houdini.md into a new shelf tool. Houdini's module `hou` is given to make(), so everything here runs without it,
and is tested so. It was not tried in Houdini.
"""

import os
import shlex
import time

import juliavdb_program as programs

# How often the program is looked at, in seconds.
INTERVAL = 0.1
# What the dialog says above the field for the options. Where it stays empty, the program's defaults hold.
ASKED = ("Options of 'juliavdb fractal', such as --detail 0.4 --texture bark --resolution 500. Without them, its defaults hold; "
         "'juliavdb fractal --help' describes them.")


def words_for(source, target, options, grids="surface,density"):
    """The words behind the program. `options` are those of a recipe, as they are typed in a shell; "" stands for the
    program's defaults."""
    given = shlex.split(options)
    for word in given:
        # Files are chosen here, and an output has to go where the next node reads it.
        if word.partition("=")[0] in ("-o", "--output", "--mesh", "--frame", "--frames", "--progress"):
            raise programs.ProgramError(f"'{word}' is not an option of a recipe; leave it out")
    output = ["-o", target, "--grids", grids] if target.endswith(".vdb") else ["--mesh", target]
    return ["fractal", source, *output, *given]


def run(hou, words, program="juliavdb"):
    """Runs the program to its end, with Houdini's own progress, in which Escape stops it. Raises ProgramError."""
    made = programs.Run(program, words)
    try:
        with hou.InterruptableOperation("JuliaVDB", open_interrupt_dialog=True) as operation:
            while made.poll() is None:
                operation.updateProgress(made.share)
                time.sleep(INTERVAL)
    except hou.OperationInterrupted:
        raise programs.ProgramError("Cancelled; nothing was written") from None
    finally:
        made.stop()
    if made.poll() != 0:
        raise programs.ProgramError(made.error())
    return made.end["written"]


def loaded(node, path, kind):
    """A File SOP that reads the result, beside the node, with what makes it ready to be seen."""
    parent = node.parent()
    file = parent.createNode("file", f"{node.name()}_{kind}")
    file.parm("file").set(path)
    last = file
    if kind == "mesh":
        last = parent.createNode("normal", f"{file.name()}_normals")
        last.setInput(0, file)
    parent.layoutChildren(items=(file, last))
    last.setDisplayFlag(True)
    last.setRenderFlag(True)
    return last


def make(hou, node, kind="volume", options="", folder="$HIP/juliavdb", program="juliavdb"):
    """Makes the fractal of a SOP, as a volume or a mesh, and returns the node that shows it.

    The geometry is written beside the result, because the recipe names it: 'juliavdb fractal --config F.vdb' makes the
    same again, for instance finer.
    """
    folder = hou.text.expandString(folder)
    os.makedirs(folder, exist_ok=True)
    stem = f"{node.name()}.{int(hou.frame()):04d}"
    source = os.path.join(folder, f"{stem}.source.obj")
    target = os.path.join(folder, f"{stem}.{'vdb' if kind == 'volume' else 'ply'}")
    words = words_for(source, target, options)
    node.geometry().saveToFile(source)
    run(hou, words, program)
    return loaded(node, target, kind)


def clicked(hou):
    """What the shelf tool calls."""
    nodes = [node for node in hou.selectedNodes() if node.type().category().name() == "Sop"]
    if len(nodes) != 1:
        hou.ui.displayMessage("Select one geometry node (SOP), whose output becomes a fractal.", title="JuliaVDB")
        return
    button, (options,) = hou.ui.readMultiInput(
        ASKED, ("Options",), buttons=("Volume", "Mesh", "Cancel"), close_choice=2, initial_contents=("",), title="JuliaVDB")
    if button == 2:
        return
    try:
        make(hou, nodes[0], ("volume", "mesh")[button], options)
    except programs.ProgramError as error:
        hou.ui.displayMessage(str(error), severity=hou.severityType.Error, title="JuliaVDB")

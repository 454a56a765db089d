#!/usr/bin/env python3
# Submits the missing tasks of a plan to OpenCue as the frames of a layer, and the merge as a layer behind it. The show
# and the shot are those of the environment; --threads of 'juliavdb submit' is the number of cores. OpenCue joins the words of a
# command by blanks and gives it to a shell, so each word is quoted for a shell here.
import getpass
import os
import shlex

import outline
import outline.cuerun
import outline.modules.shell

PROGRAM = [@{program:json}]


def quoted(words):
    return [shlex.quote(word) for word in words]


CORES = @{threads}

job = outline.Outline(@{name:json}, show=os.environ.get("SHOW", "testing"), shot=os.environ.get("SHOT", "juliavdb"),
                      user=getpass.getuser())
layer = None
@{if tasks}
layer = outline.modules.shell.Shell(
    "tasks", command=quoted(PROGRAM + @{task-arguments:json}) + ["--index", "#IFRAME#"], range=@{tasks:json},
    chunk=1, threads=CORES, threadable=CORES > 1)
job.add_layer(layer)
@{end}
@{if merge}
merge = outline.modules.shell.Shell(
    "merge", command=quoted(PROGRAM + @{merge-arguments:json}), range="1", chunk=1, threads=CORES, threadable=CORES > 1)
if layer:
    merge.depend_all(layer)
job.add_layer(merge)
@{end}
outline.cuerun.launch(job, use_pycuerun=False)

#!/usr/bin/env python3
# Submits the missing tasks of a plan to Tractor. The merge is the parent of the tasks, because Tractor runs a task once
# all tasks below it are done.
import tractor.api.author as author

PROGRAM = [@{program:json}]
SERVICE = "PixarRender"

job = author.Job(title=@{name:json}, service=SERVICE, maxactive=@{jobs})
parent = job
@{if merge}
parent = job.newTask(title="merge", argv=PROGRAM + @{merge-arguments:json}, service=SERVICE)
@{end}
@{each task}
parent.newTask(title="task @{task}", argv=PROGRAM + @{task-arguments:json} + ["--index", "@{task}"], service=SERVICE)
@{end}
print("job", job.spool())

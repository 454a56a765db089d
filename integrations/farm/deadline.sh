#!/bin/sh
# Submits the missing tasks of a plan to Deadline as the frames of a job of its plugin CommandLine, and the merge as a
# job that depends on it. The words behind -- go to deadlinecommand.
set -eu
files=$(mktemp -d)
trap 'rm -rf "$files"' EXIT
tasks=
@{if tasks}
cat > "$files/tasks.job" <<'END_OF_FILE'
Plugin=CommandLine
Name=@{name}
Frames=@{tasks}
ChunkSize=@{batch}
MachineLimit=@{jobs}
END_OF_FILE
cat > "$files/tasks.plugin" <<'END_OF_FILE'
Executable=@{program}
Arguments=@{task-arguments} --range <STARTFRAME>-<ENDFRAME>
SingleFramesOnly=False
END_OF_FILE
said=$(deadlinecommand "$files/tasks.job" "$files/tasks.plugin" @{arguments})
tasks=$(printf '%s\n' "$said" | sed -n 's/^JobID=//p')
test -n "$tasks" || { printf '%s\n' "$said" >&2; exit 1; }
echo "tasks: job $tasks"
@{end}
@{if merge}
cat > "$files/merge.job" <<'END_OF_FILE'
Plugin=CommandLine
Name=@{name} (merge)
Frames=1
END_OF_FILE
test -z "$tasks" || echo "JobDependencies=$tasks" >> "$files/merge.job"
cat > "$files/merge.plugin" <<'END_OF_FILE'
Executable=@{program}
Arguments=@{merge-arguments}
SingleFramesOnly=True
END_OF_FILE
said=$(deadlinecommand "$files/merge.job" "$files/merge.plugin" @{arguments})
merge=$(printf '%s\n' "$said" | sed -n 's/^JobID=//p')
test -n "$merge" || { printf '%s\n' "$said" >&2; exit 1; }
echo "merge: job $merge"
@{end}

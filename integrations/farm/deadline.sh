#!/bin/sh
# Submits the missing tasks of a plan to Deadline as the frames of a job of its plugin CommandLine, and the merge as a
# job that depends on it. The words behind -- go to deadlinecommand.
set -eu
files=$(mktemp -d)
trap 'rm -rf "$files"' EXIT
# Submits a job by its two files, and sets job to its number.
submit() {
  said=$(deadlinecommand "$files/$1.job" "$files/$1.plugin" @{arguments})
  job=$(printf '%s\n' "$said" | sed -n 's/^JobID=//p')
  test -n "$job" || { printf '%s\n' "$said" >&2; exit 1; }
  echo "$1: job $job"
}
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
submit tasks
tasks=$job
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
submit merge
@{end}

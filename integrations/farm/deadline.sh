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
# Words as Deadline reads them: <QUOTE> stands for the double quotes about a word with blanks. It has no way to write a double
# quote that belongs to a word.
deadline_words() {
  for word in "$@"; do
    case $word in
      *'"'*) echo "Deadline cannot pass on a double quote: $word" >&2; return 1 ;;
      *[!A-Za-z0-9_.,:=+%@/-]* | '') printf '<QUOTE>%s<QUOTE> ' "$word" ;;
      *) printf '%s ' "$word" ;;
    esac
  done
}
program=@{program:shell}
tasks=
@{if tasks}
cat > "$files/tasks.job" <<'END_OF_FILE'
Plugin=CommandLine
Name=@{name}
Frames=@{tasks}
ChunkSize=@{batch}
MachineLimit=@{jobs}
END_OF_FILE
words=$(deadline_words @{task-arguments})
cat > "$files/tasks.plugin" <<END_OF_FILE
Executable=$program
Arguments=$words --range <STARTFRAME>-<ENDFRAME>
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
words=$(deadline_words @{merge-arguments})
cat > "$files/merge.plugin" <<END_OF_FILE
Executable=$program
Arguments=$words
SingleFramesOnly=True
END_OF_FILE
submit merge
@{end}

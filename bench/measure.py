# SPDX-License-Identifier: Apache-2.0
"""What the scripts of this folder share: a command that is measured, and a table in Markdown."""
import os
import subprocess
import sys


def measured(command, folder):
    """Runs a command in a folder. @return its CPU seconds and the peak of its memory in bytes"""
    process = subprocess.Popen(list(map(str, command)), cwd=folder, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        sys.exit(f"{' '.join(map(str, command))} ended with {process.returncode}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024


def table(heads, rows, text=1):
    """@param text  the first columns that hold words; the others hold numbers"""
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * text + "--:|" * (len(heads) - text)]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows])

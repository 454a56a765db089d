# SPDX-License-Identifier: Apache-2.0
"""Commands as a page shows them, run by a shell that finds the program under its name."""
import os
import pathlib
import subprocess

PROGRAM = pathlib.Path(os.environ["JULIAVDB"]).resolve()


def run(command, folder):
    path = f"{PROGRAM.parent}:{os.environ['PATH']}"
    return subprocess.run(["bash", "-euo", "pipefail", "-c", command], cwd=folder, capture_output=True, text=True,
                          env={**os.environ, "PATH": path})

# SPDX-License-Identifier: Apache-2.0
"""Commands as a page shows them, run by a shell that finds the program under its name; and what makes them quick."""
import functools
import os
import pathlib
import re
import subprocess
import tempfile

PROGRAM = pathlib.Path(os.environ["JULIAVDB"]).resolve()
BUNNY = "/usr/share/glmark2/models/bunny.obj"


def run(command, folder):
    path = f"{PROGRAM.parent}:{os.environ['PATH']}"
    return subprocess.run(["bash", "-euo", "pipefail", "-c", command], cwd=folder, capture_output=True, text=True,
                          env={**os.environ, "PATH": path})


@functools.cache
def coarse_bunny():
    """The bunny with some 5000 triangles in the place of 70000, which take most of the time of a small run."""
    with tempfile.TemporaryDirectory() as folder:
        done = run(f"juliavdb sdf {BUNNY} -o s.vdb --resolution 32; juliavdb mesh s.vdb -o b.obj --from-grid", folder)
        assert done.returncode == 0, done.stderr
        lines = (pathlib.Path(folder) / "b.obj").read_text().splitlines()
    # Without the normals, as the bunny is: some pages change its faces by awk.
    return "".join(re.sub(r"/\S*", "", line) + "\n" for line in lines if line.startswith(("v ", "f ")))


def put_bunny(folder):
    """Puts the coarse bunny into a folder. @return the file"""
    file = pathlib.Path(folder) / "bunny.obj"
    file.write_text(coarse_bunny())
    return file


def with_bunny(block, folder):
    """The block with the coarse bunny of the folder for the one of Debian."""
    return block.replace(f"cp {BUNNY} bunny.obj", ":").replace(BUNNY, str(pathlib.Path(folder) / "bunny.obj"))


def with_option(block, commands, option):
    """The block with an option for those of the commands that have it not."""
    name = option.split()[0]
    return re.sub(rf"^(juliavdb (?:{commands}) (?:(?!{name} |[;|>#\\]).)*)$", rf"\1 {option}", block, flags=re.M)

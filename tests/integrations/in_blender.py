# SPDX-License-Identifier: Apache-2.0
"""Tests that run inside Blender: `ensure(__file__)` starts the file again there, and `main()` runs its tests."""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest


def ensure(script):
    """Returns inside Blender; outside, it ends this process with what Blender made of the script."""
    try:
        import bpy   # noqa: F401
    except ImportError:
        sys.exit(_start(script))


def _start(script):
    blender = shutil.which("blender")
    if not blender:
        print("skipped: blender is not installed")
        return 0
    # A folder of its own for caches, settings and what is temporary: other tests run beside this one.
    with tempfile.TemporaryDirectory(prefix="juliavdb_blender_") as home:
        run = subprocess.run(
            [blender, "--background", "--factory-startup", "-noaudio", "--python-exit-code", "1", "--python", script,
             "--", *sys.argv[1:]],
            env={**os.environ, "HOME": home, "XDG_CACHE_HOME": f"{home}/cache", "TMPDIR": home,
                 "PYTHONDONTWRITEBYTECODE": "1"},
            check=False)
    return run.returncode


def import_mesh(path):
    """Imports a PLY or STL by the importer that this Blender has: in C++ from 3.6 on, before that an add-on in Python."""
    import addon_utils
    import bpy
    kind = os.path.splitext(path)[1][1:]
    if f"{kind}_import" in dir(bpy.ops.wm):
        return getattr(bpy.ops.wm, f"{kind}_import")(filepath=path)
    addon_utils.enable(f"io_mesh_{kind}")
    return getattr(bpy.ops.import_mesh, kind)(filepath=path)


def main(name):
    words = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    outcome = unittest.main(argv=[name, *words], exit=False).result
    # Blender takes an exception, and not an exit, for a failure.
    if not outcome.wasSuccessful():
        raise AssertionError(f"{name} has failed a test")

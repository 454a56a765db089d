# SPDX-License-Identifier: Apache-2.0
"""Puts the Python module, its type stubs and the project's libraries into a wheel.

CMake builds them in build/python, or the variable JULIAVDB_BUILD names the folder of a build that is there already.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parent


class BuildModule(build_ext):
    """Takes what CMake makes; setuptools compiles nothing."""

    def run(self):
        given = os.environ.get("JULIAVDB_BUILD")
        build = pathlib.Path(given) if given else ROOT / "build/python"
        if given and not (build / "CMakeCache.txt").is_file():
            sys.exit(f"JULIAVDB_BUILD is '{given}', which is no folder of a build: it has no CMakeCache.txt; build there first, or "
                     "leave the variable out")
        if not given:
            subprocess.run(["cmake", "-S", ROOT, "-B", build, "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_UNITY_BUILD=ON",
                            "-DJULIAVDB_TESTS=OFF"], check=True)
            subprocess.run(["cmake", "--build", build, "--target", "juliavdb_python", "--parallel", str(os.cpu_count() or 1)],
                           check=True)
        with tempfile.TemporaryDirectory(prefix="juliavdb_") as stage:
            subprocess.run(["cmake", "--install", build, "--component", "Wheel", "--prefix", stage], check=True)
            found = pathlib.Path(stage) / "juliavdb"
            if not list(found.glob("_juliavdb*.so")):
                sys.exit(f"the build in '{build}' has no Python module; it needs python3-dev and pybind11-dev")
            # Of an installation for development, the place of the sources.
            to = pathlib.Path(self.get_ext_fullpath("juliavdb._juliavdb")).parent
            to.mkdir(parents=True, exist_ok=True)
            for file in found.iterdir():
                shutil.copy2(file, to / file.name)


def version():
    return re.search(r"^project\(JuliaVDB VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.M).group(1)


setup(version=version(), ext_modules=[Extension("juliavdb._juliavdb", [])], cmdclass={"build_ext": BuildModule})

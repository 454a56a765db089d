# SPDX-License-Identifier: Apache-2.0
"""pip makes a wheel of a build that is there, without a network, and what is installed of it works by itself."""
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = os.environ.get("JULIAVDB_BUILD")
LACKING = [name for name in ("pip", "setuptools", "wheel", "juliavdb", "numpy") if importlib.util.find_spec(name) is None]
if LACKING or not BUILD:
    print(f"skipped: there is no {', '.join(LACKING) or 'build with a Python module'}")

PROBE = """
import pathlib, juliavdb
field = juliavdb.Field(map="mandelbulb", resolution=10)
print(juliavdb.__version__, float(field([0.1, 0.2, 0.3])))
print(juliavdb.__file__)
for line in pathlib.Path("/proc/self/maps").read_text().splitlines():
    if "libjulia" in line or "libvdbtools" in line or "_juliavdb" in line:
        print(line.split()[-1])
"""


@unittest.skipIf(LACKING or not BUILD, "there is no pip with setuptools and wheel, or no build with a Python module")
class Pip(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="juliavdb_test_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        # pip leaves files beside the sources.
        self.source = self.folder / "source"
        shutil.copytree(ROOT / "python", self.source / "python", ignore=shutil.ignore_patterns("__pycache__"))
        for name in ("setup.py", "pyproject.toml", "CMakeLists.txt", "README.md"):
            shutil.copy(ROOT / name, self.source)

    def pip(self, *words, build=BUILD):
        # Any attempt to reach a network would end at this address.
        environment = {**os.environ, "JULIAVDB_BUILD": build, "PIP_INDEX_URL": "http://127.0.0.1:9/", "HOME": str(self.folder)}
        environment.pop("PYTHONPATH", None)
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        return subprocess.run([sys.executable, "-m", "pip", *map(str, words)], cwd=self.folder, env=environment, capture_output=True, text=True)

    # Promise of python.md: "pip makes a wheel with the type stubs, and needs no network for it"
    def test_a_wheel_is_made_and_works(self):
        made = self.pip("wheel", "--no-build-isolation", "--no-deps", "-w", "wheels", self.source)
        self.assertEqual(made.returncode, 0, made.stdout + made.stderr)
        wheel, = (self.folder / "wheels").iterdir()
        self.assertRegex(wheel.name, r"^juliavdb-[\d.]+-cp\d+-cp\d+-linux_.*\.whl$")
        names = set(zipfile.ZipFile(wheel).namelist())
        for name in ("__init__.py", "__init__.pyi", "py.typed", "fitting.py", "libjulia.so", "libvdbtools.so", "libvdbtools_fit.so"):
            self.assertIn(f"juliavdb/{name}", names)
        self.assertEqual(sum(name.startswith("juliavdb/_juliavdb.") for name in names), 1)
        installed = self.pip("install", "--no-index", "--no-deps", "--target", "there", wheel)
        self.assertEqual(installed.returncode, 0, installed.stderr)
        probed = subprocess.run([sys.executable, "-c", PROBE], cwd=self.folder, capture_output=True, text=True,
                                env={"PYTHONPATH": str(self.folder / "there"), "PATH": os.environ["PATH"]})
        self.assertEqual(probed.returncode, 0, probed.stderr)
        first, *places = probed.stdout.splitlines()
        import juliavdb
        self.assertEqual(first, f"{juliavdb.__version__} {float(juliavdb.Field(map='mandelbulb', resolution=10)([0.1, 0.2, 0.3]))}")
        self.assertGreaterEqual(len(set(places)), 4)
        for place in places:
            self.assertTrue(pathlib.Path(place).is_relative_to(self.folder / "there"), place)

    # Promise: "pip makes a wheel with the type ..."
    def test_a_build_that_is_none(self):
        made = self.pip("wheel", "--no-build-isolation", "--no-deps", "-w", "wheels", self.source, build=str(self.folder))
        self.assertNotEqual(made.returncode, 0)
        self.assertIn("which is no folder of a build", made.stdout + made.stderr)
        self.assertFalse((self.folder / "wheels").exists() and list((self.folder / "wheels").iterdir()))


if __name__ == "__main__":
    unittest.main()

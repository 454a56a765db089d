# SPDX-License-Identifier: Apache-2.0
"""The Debian package: made from the build as it stands, looked at, unpacked, and its program run from there.

JULIAVDB_BUILD is the build folder, JULIAVDB_CPACK the program cpack, JULIAVDB_VERSION the project's version.
"""

import gzip
import importlib.util
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))
import harness  # noqa: E402

PROGRAM = "usr/bin/juliavdb"
LIBRARIES = "usr/lib/juliavdb"


def run(*words, **options):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=600, **options)


class Package(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_package_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        made = run(os.environ["JULIAVDB_CPACK"], "--config",
                   pathlib.Path(os.environ["JULIAVDB_BUILD"]) / "CPackConfig.cmake", "-B", cls.folder / "made",
                   cwd=cls.folder)
        assert made.returncode == 0, made.stdout + made.stderr
        cls.files = sorted((cls.folder / "made").glob("*.deb"))
        cls.root = cls.folder / "root"
        for file in cls.files:
            run("dpkg-deb", "--extract", file, cls.root)

    def program(self, *words):
        """Runs the unpacked program without the libraries of the build."""
        env = {name: value for name, value in os.environ.items() if name != "LD_LIBRARY_PATH"}
        return run(self.root / PROGRAM, *words, cwd=self.folder, env=env)

    def test_one_package_of_this_version(self):
        version = os.environ["JULIAVDB_VERSION"]
        machine = run("dpkg", "--print-architecture").stdout.strip()
        self.assertEqual([file.name for file in self.files], [f"juliavdb_{version}_{machine}.deb"])
        fields = run("dpkg-deb", "--field", self.files[0]).stdout
        self.assertIn(f"\nVersion: {version}\n", "\n" + fields)
        self.assertRegex(fields, r"(?m)^Package: juliavdb$")
        self.assertRegex(fields, r"(?m)^Maintainer: .+ <.+@.+>$")
        self.assertRegex(fields, r"(?m)^Section: graphics$")
        depends = run("dpkg-deb", "--field", self.files[0], "Depends").stdout
        for library in ("libc6 (>=", "libstdc++6 (>=", "libopenvdb10.0", "libtbb12"):
            self.assertIn(library, depends)
        self.assertNotIn("fonts-", depends, "the program has its own font")
        self.assertNotIn("juliavdb", depends, "its own libraries are no dependency")
        self.assertNotIn("-dev", depends)

    def test_what_is_in_it(self):
        listed = run("dpkg-deb", "--contents", self.files[0]).stdout
        for name in (PROGRAM, f"{LIBRARIES}/libjulia.so", f"{LIBRARIES}/libvdbtools.so",
                     "usr/share/doc/juliavdb/copyright", "usr/share/doc/juliavdb/CHANGELOG.md",
                     "usr/share/doc/juliavdb/changelog.gz",
                     "usr/share/man/man1/juliavdb.1.gz", "usr/share/man/man1/juliavdb-fractal.1.gz",
                     "usr/share/bash-completion/completions/juliavdb", "usr/share/zsh/vendor-completions/_juliavdb",
                     "usr/share/fish/vendor_completions.d/juliavdb.fish"):
            self.assertIn(f" ./{name}\n", listed)
        licences = (self.root / "usr/share/doc/juliavdb/copyright").read_text()
        self.assertIn("Apache-2.0", licences)
        self.assertIn("Bitstream, Inc.", licences, "the font's licence goes with the font")
        for unwanted in ("usr/include", "cmake", "usr/local", "test"):
            self.assertNotIn(f"/{unwanted}", listed)
        for line in listed.splitlines():
            self.assertRegex(line, r"^[-d]\S+ root/root ", "everything belongs to root")
            self.assertNotRegex(line, r"^.....w..w. ", "not everybody may write")

    def test_it_follows_debians_policy(self):
        """In what lintian told of it: compressed pages and changelogs, the form of the latter, and scripts that can be run."""
        for file in (self.root / "usr/share/man").rglob("*.*"):
            self.assertTrue(gzip.decompress(file.read_bytes()).startswith(b".TH "), file)
        changelog = gzip.decompress((self.root / "usr/share/doc/juliavdb/changelog.gz").read_bytes()).decode()
        self.assertRegex(changelog, rf"\Ajuliavdb \({re.escape(os.environ['JULIAVDB_VERSION'])}\) unstable; urgency=medium\n\n  \* .+\n\n"
                                    r" -- .+ <.+@.+>  \w{3}, \d\d \w{3} \d{4} \d\d:\d\d:\d\d \+0000\n\Z")
        for file in (self.root / "usr").rglob("*"):
            if file.is_file() and not file.is_symlink() and file.read_bytes()[:2] == b"#!":
                self.assertTrue(os.access(file, os.X_OK), file)
        if not shutil.which("lintian"):
            self.skipTest("lintian is not installed")
        told = run("lintian", "--tags", "uncompressed-manual-page,no-changelog,script-not-executable,"
                                        "executable-not-elf-or-script,no-manual-page", self.files[0])
        self.assertEqual(told.stdout, "", told.stderr)

    def test_every_library_is_found(self):
        files = [self.root / PROGRAM, *(self.root / LIBRARIES).iterdir()]
        self.assertGreaterEqual(len(files), 3)
        for file in files:
            with self.subTest(file=file.name):
                found = run("ldd", file, env={"PATH": os.environ["PATH"]}).stdout
                self.assertNotIn("not found", found)
                for line in found.splitlines():
                    if "libjulia" in line or "libvdbtools" in line:
                        self.assertIn(str(self.root / LIBRARIES), line.replace("bin/../", ""))
                runpath = run("readelf", "-d", file).stdout
                self.assertNotIn(os.environ["JULIAVDB_BUILD"], runpath)

    # Promise of release.md#6-the-package: The package installs, and its program and module run
    def test_its_dependencies_can_be_installed(self):
        if not shutil.which("apt-get"):
            self.skipTest("there is no apt-get")
        simulated = run("apt-get", "install", "--simulate", "--no-install-recommends", self.files[0])
        self.assertEqual(simulated.returncode, 0, simulated.stdout + simulated.stderr)
        self.assertIn("Inst juliavdb ", simulated.stdout)

    # Promise: The package installs, and its program ...
    def test_the_unpacked_program_works(self):
        said = self.program("--version")
        self.assertEqual(said.stdout, f"juliavdb {os.environ['JULIAVDB_VERSION']}\n", said.stderr)
        (self.folder / "s.obj").write_text(harness.obj(harness.sphere(2)))
        made = self.program("fractal", "s.obj", "-o", "f.vdb", "--sdf-resolution", 20, "--resolution", 20)
        self.assertEqual(made.returncode, 0, made.stderr)
        # Pictures need the module that is loaded when the first is written.
        picture = self.program("render", "f.vdb", "-o", "f.exr", "--size", "16x16")
        self.assertEqual(picture.returncode, 0, picture.stderr)
        self.assertTrue((self.folder / "f.exr").stat().st_size > 0)

    # Promise: The package installs, and its program ...
    def test_the_unpacked_module_works(self):
        packages = self.root / "usr/lib/python3/dist-packages"
        if not (packages / "juliavdb").exists():
            self.skipTest("the Python module was not built")
        if importlib.util.find_spec("numpy") is None:
            self.skipTest("there is no numpy")
        self.assertTrue((packages / "juliavdb/__init__.pyi").stat().st_size > 10000)
        self.assertIn("python3-numpy", run("dpkg-deb", "--field", self.files[0], "Recommends").stdout)
        script = "import juliavdb; print(juliavdb.__file__, juliavdb.fractal(map='mandelbulb', resolution=12).faces.shape[1])"
        said = run(sys.executable, "-B", "-c", script, cwd=self.folder,
                   env={"PATH": os.environ["PATH"], "PYTHONPATH": str(packages)})
        self.assertEqual(said.stdout, f"{packages}/juliavdb/__init__.py 3\n", said.stderr)
        module, = (packages / "juliavdb").glob("*.so")
        for line in run("ldd", module, env={"PATH": os.environ["PATH"]}).stdout.splitlines():
            if "libjulia" in line or "libvdbtools" in line:
                self.assertIn(f"{packages}/juliavdb/../../../juliavdb/", line)


if __name__ == "__main__":
    unittest.main()

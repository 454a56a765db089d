# SPDX-License-Identifier: Apache-2.0
"""The bundle: made of the build as it stands, and run in an empty root that has the C library's files and nothing else.

JULIAVDB_BUILD is the build folder, JULIAVDB the program in it, with whose bytes the bundle's are compared.
"""

import http.client
import importlib.util
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import unittest
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/cli"))
import harness  # noqa: E402

BUILD = os.environ["JULIAVDB_BUILD"]
NAME = "juliavdb-test"
# What a program finds on every machine.
C_LIBRARY = ("libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "librt.so.1", "libresolv.so.2", "libmvec.so.1", "libutil.so.1")
LINKER = "/lib64/ld-linux-x86-64.so.2"


def run(*words, **options):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=1200, **options)


def bundle(file, *options):
    # The test looks at what is in it, and not at how small it is.
    return run(ROOT / "tools/bundle", BUILD, file, "--level", 0, *options)


@unittest.skipUnless(shutil.which("patchelf") and shutil.which("xz") and pathlib.Path(LINKER).exists(),
                     "there is no patchelf, no xz, or another linker")
class Bundle(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_bundle_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.archive = cls.folder / f"{NAME}.tar.xz"
        made = bundle(cls.archive)
        assert made.returncode == 0, made.stdout + made.stderr
        cls.said = made.stdout
        cls.root = cls.folder / "root"
        cls.work = cls.root / "unpacked"
        cls.work.mkdir(parents=True)
        run("tar", "-xf", cls.archive, "-C", cls.root / "unpacked", check=True)
        cls.unpacked = cls.work / NAME
        (cls.work / "s.obj").write_text(harness.obj(harness.torus()))

    @classmethod
    def empty_root(cls):
        """@return the words before a command that runs in the root, in /unpacked"""
        for place in ("lib64", "proc", "tmp", "lib/x86_64-linux-gnu"):
            (cls.root / place).mkdir(parents=True, exist_ok=True)
        shutil.copy(LINKER, cls.root / "lib64")
        known = run("/sbin/ldconfig", "-p").stdout
        for name in C_LIBRARY:
            match = re.search(rf"^\s*{re.escape(name)} \(libc6,x86-64[^)]*\) => (\S+)", known, re.M)
            if match:
                shutil.copy(match.group(1), cls.root / "lib/x86_64-linux-gnu")
        # $ORIGIN of a program is found by /proc.
        return ["unshare", "--mount", *(() if os.geteuid() == 0 else ("--map-root-user",)), "sh", "-c",
                f'mount --rbind /proc "{cls.root}/proc" && exec "$@"', "sh", sys.executable, "-c",
                f"import os, sys; os.chroot('{cls.root}'); os.chdir('/unpacked'); os.execve(sys.argv[1], sys.argv[1:], {{}})"]

    def enter(self):
        words = self.empty_root()
        tried = run(*words, LINKER, "--version") if shutil.which("unshare") else None
        if tried is None or tried.returncode != 0:
            self.skipTest(f"this system lets nobody make a root of his own: {tried.stderr.strip() if tried else 'there is no unshare'}")
        return words

    # Promise of bundle.md: The bundle runs in a root with the C library alone, with "the bytes of VDB, PLY, PNG and EXR" of the
    #   build
    def test_the_bytes_are_those_of_the_build(self):
        enter = self.enter()
        here = self.folder / "here"
        here.mkdir()
        shutil.copy(self.work / "s.obj", here)
        commands = (("fractal", "s.obj", "-o", "f.vdb", "--mesh", "f.ply", "--sdf-resolution", 24, "--resolution", 30),
                    ("render", "f.vdb", "-o", "f.png", "--size", "40x30"),
                    ("slice", "f.vdb", "-o", "s.png"),
                    ("render", "f.vdb", "-o", "f.exr", "--size", "40x30"))
        for words in commands:
            built = run(harness.program(), *words, cwd=here)
            self.assertEqual(built.returncode, 0, built.stderr)
            there = run(*enter, f"/unpacked/{NAME}/bin/juliavdb", *words)
            self.assertEqual(there.returncode, 0, f"{words}\n{there.stderr}")
        for name in ("f.vdb", "f.ply", "f.png", "s.png", "f.exr"):
            with self.subTest(file=name):
                self.assertTrue((here / name).read_bytes() == (self.work / name).read_bytes(), f"{name} has other bytes")

    # Promise: The bundle runs in a root ...
    def test_the_page_answers(self):
        enter = self.enter()
        words = harness.quiet(("explore", "s.obj", "--resolution", "24", "--sdf-resolution", "24"))
        server = subprocess.Popen([*enter, f"/unpacked/{NAME}/bin/juliavdb", *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        try:
            url = urllib.parse.urlsplit(server.stdout.readline().decode().strip())
            self.assertTrue(url.port, "the server gives no address")
            connection = http.client.HTTPConnection(url.hostname, url.port, timeout=harness.TIMEOUT)
            connection.request("GET", url.path)
            answer = connection.getresponse()
            self.assertEqual(answer.status, 200)
            self.assertTrue(answer.read().startswith(b"<!DOCTYPE html>"))
            connection.close()
        finally:
            server.kill()
            server.communicate()

    # Promise: The bundle runs in a root ...
    def test_what_is_in_it(self):
        for name in ("bin/juliavdb", "lib/juliavdb/libvdbtools.so", "lib/juliavdb/libstdc++.so.6", "lib/juliavdb/libgcc_s.so.1",
                     "share/juliavdb/blender/juliavdb_addon.zip", "share/juliavdb/houdini/toolbar/juliavdb.shelf",
                     "share/juliavdb/templates/deadline.sh", "bench/gpu", "bench/device_bench", "share/man/man1/juliavdb.1", "share/doc/juliavdb/copyright", "README.txt"):
            self.assertTrue((self.unpacked / name).is_file(), name)
        for name in (*C_LIBRARY, os.path.basename(LINKER)):
            self.assertEqual(list(self.unpacked.rglob(name)), [], "a C library that is not the linker's does not start")
        with tarfile.open(self.archive) as archive:
            for member in archive:
                self.assertEqual(member.name.split("/")[0], NAME)
                self.assertEqual((member.uid, member.gid, member.mode & 0o022), (0, 0, 0), member.name)
        for file in (self.unpacked / "lib/juliavdb").iterdir():
            dynamic = run("readelf", "-d", file).stdout
            # RUNPATH, unlike RPATH, comes after LD_LIBRARY_PATH, which hosts set to libraries of their own.
            self.assertRegex(dynamic, r"\(RPATH\) +Library rpath: \[\$ORIGIN\]\n", file.name)
            self.assertNotIn("(RUNPATH)", dynamic)

    @unittest.skipUnless(harness.has_opencl(), "no device of OpenCL is installed")
    def test_it_measures_devices(self):
        """bench/gpu finds the bundle's programs, and the time limit leaves a result. tests/bench/gpu_test.py has the rest."""
        out = self.folder / "gpu"
        env = {name: value for name, value in os.environ.items() if not name.startswith("JULIAVDB")}
        said = run(sys.executable, self.unpacked / "bench/gpu", "--quick", "--seconds", 40, "--mesh", self.work / "s.obj", "--out", out, env=env)
        self.assertEqual(said.returncode, 0, said.stderr)
        results = json.loads((out / "gpu.json").read_text())
        self.assertTrue(results["devices"]["devices"][0]["usable"])
        self.assertTrue(results["kernels"])
        self.assertNotIn("kernels_failed", results)
        self.assertIs(results["commands"][0]["same"], True)

    def test_a_library_of_the_host_does_not_come_first(self):
        wrong = self.folder / "wrong"
        wrong.mkdir()
        for name in ("libopenvdb.so.10.0", "libtbb.so.12", "libstdc++.so.6"):
            (wrong / name).write_text("no library")
        said = run(self.unpacked / "bin/juliavdb", "--version", env={"LD_LIBRARY_PATH": str(wrong)})
        self.assertEqual(said.returncode, 0, said.stderr)

    def test_the_licence_of_each_library(self):
        place = self.unpacked / "share/doc/juliavdb/licences"
        lines = dict(re.findall(r"^(\S+\.so\S*): (.*)$", (place / "LIBRARIES").read_text(), re.M))
        carried = {file.name for file in (self.unpacked / "lib/juliavdb").iterdir()
                   if not re.match(r"lib(julia|vdbtools(_\w+)?)\.so", file.name)}
        self.assertEqual(set(lines), carried)
        if shutil.which("dpkg"):
            for name, words in lines.items():
                self.assertGreater((place / words.split(",")[0]).stat().st_size, 100, name)

    def test_the_least_c_library(self):
        least = tuple(map(int, re.search(r"glibc (\d+)\.(\d+) or later", self.said).groups()))
        asked = set()
        for file in [self.unpacked / "bin/juliavdb", *(self.unpacked / "lib/juliavdb").iterdir()]:
            asked |= {tuple(map(int, found)) for found in re.findall(r"Name: GLIBC_(\d+)\.(\d+) ", run("readelf", "-V", file).stdout)}
        self.assertGreaterEqual(least, max(asked))
        self.assertLessEqual(least, tuple(map(int, os.confstr("CS_GNU_LIBC_VERSION").split()[1].split(".")[:2])))

    # Promise: The bundle runs in a root ...
    def test_the_module_takes_nothing_of_the_machine(self):
        packages = self.unpacked / "lib/python3/dist-packages"
        if not packages.exists():
            self.skipTest("the Python module was not built")
        if importlib.util.find_spec("numpy") is None:
            self.skipTest("there is no numpy")
        self.assertIn(f"for Python {sys.version_info.major}.{sys.version_info.minor}", self.said)
        script = ("import juliavdb, re; print(juliavdb.fractal(map='mandelbulb', resolution=12).faces.shape[1]);"
                  "print(*set(re.findall(r'/\\S+/lib(?:openvdb|tbb|julia|vdbtools)\\.so\\S*', open('/proc/self/maps').read())))")
        said = run(sys.executable, "-B", "-c", script, cwd=self.folder, env={"PATH": os.environ["PATH"], "PYTHONPATH": str(packages)})
        self.assertEqual(said.returncode, 0, said.stderr)
        faces, libraries = said.stdout.splitlines()
        self.assertEqual((faces, len(libraries.split())), ("3", 4), libraries)
        for library in libraries.split():
            self.assertTrue(library.startswith(str(self.unpacked)), library)

    # Promise of bundle.md: "The same build gives the same bytes"; "if it cannot be written, one line says why"
    def test_the_same_build_gives_the_same_bytes(self):
        for name in ("one", "two"):
            (self.folder / name).mkdir()
            made = bundle(self.folder / name / "b.tar.xz", "--without-pictures")
            self.assertEqual(made.returncode, 0, made.stderr)
        one, two = ((self.folder / name / "b.tar.xz").read_bytes() for name in ("one", "two"))
        self.assertTrue(one == two)

    # Promise: "The same build gives the same ..."
    def test_what_cannot_be_written(self):
        (self.folder / "folder.tar.xz").mkdir()
        for file, code, mention in ((self.folder / "nowhere/b.tar.xz", 73, "nowhere"), (self.folder / "b.zip", 2, "b.zip"),
                                    (self.folder / "folder.tar.xz", 73, "folder.tar.xz")):
            done = bundle(file)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertRegex(done.stderr, rf"^bundle: .*{re.escape(mention)}.*\n$")
        done = run(ROOT / "tools/bundle", self.folder, self.folder / "b.tar.xz")
        self.assertEqual(done.returncode, 66)
        self.assertFalse((self.folder / "b.tar.xz").exists())

    # Promise: "The same build gives the same ..."
    def test_a_full_disk_leaves_nothing(self):
        if os.geteuid() != 0:
            self.skipTest("only root mounts a small disk")
        full = self.folder / "full"
        full.mkdir()
        words = ["unshare", "--mount", "sh", "-c", f'mount -t tmpfs -o size=2m none "{full}" || exit 99; '
                 f'"{ROOT}/tools/bundle" "{BUILD}" "{full}/b.tar.xz" --level 0 --without-pictures; code=$?; ls -A "{full}"; exit $code']
        done = run(*words)
        if done.returncode == 99:
            self.skipTest("this system mounts nothing")
        self.assertEqual((done.returncode, done.stdout), (73, ""), done.stderr)
        self.assertRegex(done.stderr, r"^bundle: .*b\.tar\.xz cannot be written: .*No space left.*\n$")


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: Apache-2.0
"""quickstart and what it shares with run-tests, on machines that lack something: one line says what, and what to do.

Nothing is installed or built here, and no network is used: the programs that would do that are replaced by ones that write down
what they are asked for and say what the true ones say. A machine has no program but those of PROGRAMS and its own.
"""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PROGRAMS = ("awk", "bash", "cat", "dirname", "env", "grep", "head", "mkdir", "printf", "realpath", "sed", "sort", "tail")
CMAKE = """
if [ "$1" = --version ]; then echo "cmake version ${CMAKE_IS:-3.25.1}"; exit; fi
echo "cmake $*" >>"$LOG"
[ "$1" = --build ] || { printf '%s\\n' "${CMAKE_SAYS:-}"; exit "${CMAKE_ENDS:-0}"; }
exit "${BUILD_ENDS:-0}"
"""
APT_GET = """
echo "apt-get $*" >>"$LOG"
case " $* " in
  *' update '*) printf '%s\\n' "${UPDATE_SAYS:-}" ;;
  *' install '*) [ -z "${INSTALL_SAYS:-}" ] || { printf '%s\\n' "$INSTALL_SAYS"; exit 100; } ;;
esac
"""
# Installed is what $INSTALLED names, or all that $MISSING does not name.
DPKG_QUERY = """
package=${@: -1}
case " ${MISSING:-} " in *" $package "*) echo "no packages found matching $package" >&2; exit 1 ;; esac
printf 'install ok installed'
"""
# Known is what $KNOWN names.
APT_CACHE = """
case " ${KNOWN:-} " in *" $2 "*) printf '%s:\\n  Installed: (none)\\n  Candidate: 1.0\\n' "$2" ;; esac
"""
OPTIONAL = re.findall(r"'([a-z0-9.+-]+)\?'", (ROOT / "cmake/debian.sh").read_text())


class Machine(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_test_"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.tree, self.tools, self.log = self.folder / "tree", self.folder / "tools", self.folder / "log"
        self.tools.mkdir()
        self.log.touch()
        for name in PROGRAMS:
            (self.tools / name).symlink_to(shutil.which(name))
        # The tree has what the scripts need. The program has been "built" by the time that it is called.
        self.tree.mkdir()
        for name in ("quickstart", "run-tests", "CMakeLists.txt", "cmake"):
            (shutil.copytree if (ROOT / name).is_dir() else shutil.copy)(ROOT / name, self.tree / name)
        (self.tree / "build/release/cli").mkdir(parents=True)
        self.program(self.tree / "build/release/cli/juliavdb", 'echo "juliavdb $1" >>"$LOG"')
        self.mesh = self.folder / "mesh.obj"
        self.mesh.touch()
        for name, text in (("cmake", CMAKE), ("ninja", ""), ("apt-get", APT_GET), ("apt-cache", APT_CACHE), ("dpkg-query", DPKG_QUERY),
                           ("id", "echo ${USER_IS:-0}"), ("df", 'printf "a\\nb 1 1 ${FREE:-1000000} 1 1\\n"')):
            self.program(self.tools / name, text)

    def program(self, path, text):
        path.write_text(f"#!{shutil.which('bash')}\n{text}\n")
        path.chmod(0o755)

    def run_script(self, words, **variables):
        """@return how the command ended, and what of the machine it called"""
        self.log.write_text("")
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True, cwd=self.tree, timeout=60,
                              env={"PATH": str(self.tools), "LOG": str(self.log), "OUT": str(self.folder / "out"), "MESH": str(self.mesh),
                                   "HOME": str(self.folder), **variables})
        return done, self.log.read_text().splitlines()

    def quickstart(self, **variables):
        return self.run_script([self.tree / "quickstart"], **variables)

    def install(self, packages, **variables):
        return self.run_script(["bash", "-c", f"set -euo pipefail; source cmake/debian.sh; install_packages {packages}"], **variables)

    def assert_one_line(self, done, *mentions):
        """It failed, and one line on stderr, which is no complaint of the shell, says all of these."""
        self.assertNotEqual(done.returncode, 0, done.stdout)
        lines = done.stderr.splitlines()
        self.assertEqual(len(lines), 1, done.stderr)
        self.assertTrue(lines[0].startswith(("quickstart: ", "bash: ")), lines)
        self.assertNotIn("command not found", lines[0])
        for mention in mentions:
            self.assertIn(mention, lines[0])

    # Promise of platforms.md: "call apt only if a package is missing"
    def test_apt_is_never_called_where_all_is_there(self):
        for variables in ({}, {"USER_IS": "1000"}):
            done, calls = self.quickstart(**variables)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertEqual([call.split()[0] for call in calls], ["cmake", "cmake", "juliavdb", "juliavdb"])

    # Promise: "call apt only if a package is missing"
    def test_what_is_missing_is_installed_and_nothing_else(self):
        done, calls = self.quickstart(MISSING="ninja-build libzip-dev")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn(" update ", calls[0] + " ")
        self.assertRegex(calls[1], r" install .* ninja-build libzip-dev$")
        self.assertEqual(sum("apt-get" in call for call in calls), 2)

    # Promise of platforms.md: A package "that only tests need, is left out and named"; "`MESH=FILE ./quickstart` takes another
    #   mesh"
    def test_a_package_that_this_release_lacks_is_named_once(self):
        self.assertTrue(OPTIONAL)
        wanted = '"${BUILD_PACKAGES[@]}" "${TEST_PACKAGES[@]}"'
        done, calls = self.install(wanted, MISSING=" ".join(OPTIONAL))
        self.assertEqual((done.returncode, done.stderr, calls), (0, "", []))
        self.assertEqual(len(done.stdout.splitlines()), 1)
        for package in OPTIONAL:
            self.assertIn(package, done.stdout)
        # One that apt knows is installed, and only the other is left out.
        done, calls = self.install(wanted, MISSING=" ".join(OPTIONAL), KNOWN=OPTIONAL[0])
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([call.split()[-1] for call in calls], [OPTIONAL[0]])
        self.assertNotIn(OPTIONAL[0], done.stdout.splitlines()[-1])
        self.assertIn(OPTIONAL[1], done.stdout.splitlines()[-1])

    # Promise: A failure "ends in one line ..."
    def test_a_package_that_must_be_there_is_never_left_out(self):
        done, calls = self.quickstart(MISSING="libopenvdb-dev", INSTALL_SAYS="E: Unable to locate package libopenvdb-dev")
        self.assert_one_line(done, "E: Unable to locate package libopenvdb-dev", "docs/platforms.md")
        self.assertFalse([call for call in calls if call.startswith("cmake")])

    # Promise of platforms.md: A failure "ends in one line that says what to do, with apt's own last error where apt failed"
    def test_failures_of_apt_end_in_one_line_with_its_own_words_and_a_way_out(self):
        # As apt 2.6 of Debian 12 and apt 3.0 of Debian 13 say it, and the exit code.
        network = "E: Failed to fetch http://deb.debian.org/x.deb  Temporary failure resolving 'deb.debian.org'"
        cases = (
            ("E: Could not get lock /var/lib/dpkg/lock-frontend. It is held by process 7 (apt)\nE: Unable to acquire the dpkg frontend "
             "lock (/var/lib/dpkg/lock-frontend), is another process using it?", "is another process using it?", "wait", 75),
            ("E: Unable to lock directory /var/cache/apt/archives/", "/var/cache/apt/archives/", "wait", 75),
            ("E: You don't have enough free space in /var/cache/apt/archives/.", "enough free space in /var", "make room", 74),
            (" failed to write (No space left on device)\nE: Sub-process /usr/bin/dpkg returned an error code (1)", "No space left", "make room", 74),
            (f"{network}\nE: Unable to fetch some archives, maybe run apt-get update or try with --fix-missing?", network, "http_proxy", 69),
            ("E: The package x needs to be reinstalled", "E: The package x needs", "apt-get", 69))
        for said, words, way, code in cases:
            with self.subTest(said):
                done, calls = self.quickstart(MISSING="ninja-build", INSTALL_SAYS=said)
                self.assert_one_line(done, words, way)
                self.assertEqual(done.returncode, code)
                self.assertFalse([call for call in calls if call.startswith("cmake")])

    # Promise: A failure "ends in one line ..."
    def test_a_list_that_could_not_be_fetched_explains_a_package_that_is_not_known(self):
        done, _ = self.quickstart(MISSING="ninja-build", INSTALL_SAYS="E: Unable to locate package ninja-build",
                                  UPDATE_SAYS="W: Failed to fetch http://d/InRelease  Could not connect to d:80")
        self.assert_one_line(done, "Could not connect to d:80", "network")
        # By itself it is no reason to stop.
        done, _ = self.quickstart(MISSING="ninja-build", UPDATE_SAYS="W: Failed to fetch http://other/InRelease  Could not connect")
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    # Promise: A failure "ends in one line ..."
    def test_who_may_not_install_is_told_what_root_would_run(self):
        done, calls = self.quickstart(MISSING="ninja-build libzip-dev", USER_IS="1000")
        self.assert_one_line(done, "sudo is not here", "apt-get install ninja-build libzip-dev")
        self.assertEqual((done.returncode, calls), (77, []))
        self.program(self.tools / "sudo", "echo 'sudo: a password is required' >&2; exit 1")
        done, calls = self.quickstart(MISSING="ninja-build libzip-dev", USER_IS="1000")
        self.assert_one_line(done, "sudo: a password is required", "apt-get install ninja-build libzip-dev")
        self.assertEqual((done.returncode, calls), (77, []))
        self.program(self.tools / "sudo", 'exec "$@"')
        done, calls = self.quickstart(MISSING="ninja-build", USER_IS="1000")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertRegex(calls[1], r"^apt-get .* install .* ninja-build$")

    # Promise of platforms.md: `./quickstart` "prints the names of the packages, which were looked up, and goes on with what is
    #   there"
    def test_a_system_without_dpkg_is_told_the_names_and_goes_on(self):
        for name in ("apt-get", "apt-cache", "dpkg-query"):
            (self.tools / name).unlink()
        done, calls = self.quickstart()
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(calls[-1], "juliavdb render")
        for name in ("Fedora", "openvdb-devel", "Arch", "onetbb", "environment.yml"):
            self.assertIn(name, done.stdout)
        done, _ = self.quickstart(CONDA_PREFIX="/opt/conda")
        self.assertIn("conda env update --file environment.yml", done.stdout)
        self.assertNotIn("Fedora", done.stdout)
        # With dpkg and without apt-get, something else has installed the packages.
        self.program(self.tools / "dpkg-query", DPKG_QUERY)
        self.assertEqual(self.quickstart()[0].returncode, 0)
        self.assert_one_line(self.quickstart(MISSING="ninja-build")[0], "ninja-build", "no apt-get")

    # Promise: A failure "ends in one line ..."
    def test_a_tool_that_is_missing_or_too_old(self):
        oldest = re.search(r"cmake_minimum_required\(VERSION (\S+)\)", (ROOT / "CMakeLists.txt").read_text()).group(1)
        for version in ("3.9.6", "2.8.12", "3.21.7"):
            self.assert_one_line(self.quickstart(CMAKE_IS=version)[0], version, oldest, "https://cmake.org/download")
        for version in (oldest, f"{oldest}.0", "3.31.6", "4.0.2"):
            self.assertEqual(self.quickstart(CMAKE_IS=version)[0].returncode, 0, version)
        (self.tools / "ninja").unlink()
        self.assert_one_line(self.quickstart()[0], "ninja", "https://ninja-build.org")
        (self.tools / "cmake").unlink()
        self.assert_one_line(self.quickstart()[0], "cmake", oldest, "https://cmake.org/download")

    # Promise: A failure "ends in one line ..."
    def test_an_error_of_configuring_is_one_line(self):
        done, calls = self.quickstart(CMAKE_ENDS="1", CMAKE_SAYS="-- Found Git\nCMake Error at cmake/X.cmake:14 (message):\n  X 10 or later is "
                                      "needed, and was\n  not found (Debian's package libx)\nCall Stack (most recent call first):\n  cmake/X.cmake:31\n\n"
                                      "CMake Error at y:\n  another")
        self.assert_one_line(done, "X 10 or later is needed, and was not found (Debian's package libx)", "build/configure.log")
        self.assertNotIn("another", done.stderr)
        self.assertEqual(len(calls), 1)

    # Promise: "A version below the oldest ..."
    def test_parts_that_are_left_out_are_named(self):
        done, _ = self.quickstart(CMAKE_SAYS="-- Found Git\n-- Left out: 3MF files: libzip was not found\n-- Configuring done")
        self.assertEqual(done.returncode, 0)
        self.assertIn("Left out: 3MF files: libzip was not found\n", done.stdout)
        self.assertNotIn("Git", done.stdout)

    # Promise: A failure "ends in one line ..."
    def test_a_full_disk_during_a_build(self):
        for variables in ({"BUILD_ENDS": "1"}, {"CMAKE_ENDS": "1", "CMAKE_SAYS": "CMake Error: Problem"}):
            done, _ = self.quickstart(FREE="12", **variables)
            self.assert_one_line(done, "12 kB", "make room")
            self.assertEqual(done.returncode, 74)
        # Another failure is not blamed on it.
        self.assertNotIn("disk", self.quickstart(BUILD_ENDS="1")[0].stderr)

    # Promise: A package "that only tests ..."
    def test_a_mesh_that_is_not_there(self):
        done, calls = self.quickstart(MESH="/nowhere.obj")
        self.assert_one_line(done, "/nowhere.obj", "MESH=FILE")
        self.assertEqual((done.returncode, calls[-1].split()[0]), (66, "cmake"))


class Cmake(unittest.TestCase):
    """The functions of cmake/ in CMake's script mode."""

    def run_cmake(self, text):
        with tempfile.TemporaryDirectory() as folder:
            script = pathlib.Path(folder) / "x.cmake"
            script.write_text(text.replace("CMAKE/", f"{ROOT}/cmake/"))
            done = subprocess.run([os.environ.get("JULIAVDB_CMAKE", "cmake"), "-P", script], capture_output=True, text=True, check=False)
        return done.returncode, " ".join(done.stderr.split()), done.stdout

    # Promise of platforms.md: "A version below the oldest ends configuring with a line that names both and the package";
    #   "Configuring and `./quickstart` name each part that is left out, with the reason"
    def test_a_library_that_is_missing_or_too_old(self):
        require = 'include("CMAKE/JuliaVDBDependency.cmake")\njuliavdb_require(Lib "{}" "{}" "{}" lib-dev)\n'
        for there, version, oldest in (("TRUE", "10.0", "10.0"), ("1", "10.0.1", "10.0"), ("ON", "13.1", "9"), ("TRUE", "2.10", "2.9"), ("TRUE", "", "2"), ("1", "", "")):
            self.assertEqual(self.run_cmake(require.format(there, version, oldest))[:2], (0, ""))
        code, said, _ = self.run_cmake(require.format("TRUE", "9.1.0", "10.0"))
        self.assertNotEqual(code, 0)
        self.assertIn("Lib 10.0 or later is needed, and 9.1.0 was found (Debian 12 and later have it as lib-dev)", said)
        for oldest, needed in (("10.0", "Lib 10.0 or later"), ("", "Lib")):
            code, said, _ = self.run_cmake(require.format("FALSE", "", oldest))
            self.assertNotEqual(code, 0)
            self.assertIn(f"{needed} is needed, and was not found (Debian's package lib-dev)", said)

    # Promise: "A version below the oldest ..."
    def test_a_compiler_that_is_too_old(self):
        check = ('set(CMAKE_CXX_COMPILER /usr/bin/c++)\nset(CMAKE_CXX_COMPILER_ID {})\nset(CMAKE_CXX_COMPILER_VERSION {})\n'
                 'include("CMAKE/JuliaVDBCompiler.cmake")\n')
        for name, version in (("GNU", "12.2.0"), ("GNU", "14.2.0"), ("Clang", "14.0.6"), ("Clang", "19.1.7"), ("Other", "1.0")):
            self.assertEqual(self.run_cmake(check.format(name, version))[:2], (0, ""))
        for name, version in (("GNU", "11.4.0"), ("GNU", "9.5.0"), ("Clang", "13.0.1")):
            code, said, _ = self.run_cmake(check.format(name, version))
            self.assertNotEqual(code, 0)
            self.assertIn(f"/usr/bin/c++ is {name} {version}", said)
            self.assertIn("Debian 12", said)

    # Promise: "A version below the oldest ..."
    def test_parts_keep_their_reasons(self):
        text = ('include("CMAKE/JuliaVDBParts.cmake")\njuliavdb_part("A" ON "never")\njuliavdb_part("B" "" "b; with a mark")\n'
                'juliavdb_part("C" FALSE "c")\njuliavdb_name_parts()\n')
        code, _, stdout = self.run_cmake(text)
        self.assertEqual((code, stdout), (0, "-- Left out: B: b; with a mark\n-- Left out: C: c\n"))


if __name__ == "__main__":
    unittest.main()

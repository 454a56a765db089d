#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Nothing starts another program and nothing opens a connection, but where SECURITY.md says so.

What the libraries, the program and the Python module call is read from their symbols, and who starts programs from the
sources. Usage: system_calls_test.py NM TARGET=FILE ...
"""
import pathlib
import re
import subprocess
import sys
import unittest

NM, FILES = sys.argv[1], dict(argument.split("=", 1) for argument in sys.argv[2:])
del sys.argv[1:]
ROOT = pathlib.Path(__file__).resolve().parents[2]

STARTS = {"execl", "execle", "execlp", "execv", "execve", "execvp", "execvpe", "fexecve", "fork", "vfork", "clone", "popen",
          "posix_spawn", "posix_spawnp", "system"}
CONNECTS = {"socket", "socketpair", "connect", "sendto", "sendmsg", "sendmmsg", "getaddrinfo", "gethostbyname", "gethostbyname_r"}
ACCEPTS = {"listen", "accept", "accept4"}

# By source: what it starts.
STARTERS = {
    "cli/child_process.cpp": "the engine of submit, and this program itself for the sample of an estimate",
    "cli/commands/explore.cpp": "the browser, with --open yes",
    "cli/commands/submit.cpp": "scontrol, which is asked how large an array may be",
}


def called(file):
    output = subprocess.run([NM, "-D", "--undefined-only", file], check=True, capture_output=True, text=True).stdout
    return {line.split()[-1].split("@")[0] for line in output.splitlines() if line.strip()}


def starters():
    calls = re.compile(r"\b(?:" + "|".join(sorted(STARTS - {"clone"})) + r")\s*\(")
    return {str(path.relative_to(ROOT)) for layer in ("libjulia", "vdbtools", "cli", "python")
            for path in (ROOT / layer).rglob("*") if path.suffix in (".cpp", ".h")
            if calls.search("\n".join(line.partition("//")[0] for line in path.read_text().splitlines()))}


class SystemCalls(unittest.TestCase):

    # Promise of SECURITY.md: "No expression, recipe or file makes the program start another"
    def test_nothing_but_the_program_starts_another(self):
        for target, file in FILES.items():
            with self.subTest(target=target):
                found = called(file) & STARTS
                self.assertEqual(found, {"popen", "posix_spawn", "posix_spawnp"} if target == "juliavdb_cli" else set())
        self.assertEqual(starters(), set(STARTERS))

    # Promise of SECURITY.md: "Nothing but `explore` opens a socket, and it makes no request of its own"
    def test_nothing_opens_a_connection(self):
        """The server of explore has a socket, at which it waits for the connections of others."""
        for target, file in FILES.items():
            with self.subTest(target=target):
                symbols = called(file)
                self.assertGreater(len(symbols), 50, "the symbols cannot be read")
                serves = target == "vdbtools_explore"
                self.assertEqual(symbols & CONNECTS, {"socket"} if serves else set())
                self.assertEqual(symbols & ACCEPTS, {"listen", "accept4"} if serves else set())


if __name__ == "__main__":
    unittest.main()

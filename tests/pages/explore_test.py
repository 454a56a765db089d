# SPDX-License-Identifier: Apache-2.0
"""The commands of `juliavdb explore` in README, docs/explore.md and docs/usage.md: they do what the pages say."""
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import tempfile
import unittest
import urllib.request

from shell import PROGRAM

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUNNY = "/usr/share/glmark2/models/bunny.obj"


class ExplorePages(unittest.TestCase):
    # Promise: The commands of the README ...
    def test_every_command_serves_or_exports(self):
        served = exported = 0
        for page in ("README.md", "docs/explore.md", "docs/usage.md"):
            text = (ROOT / page).read_text().replace("$bunny", "bunny.obj")
            for command in set(re.findall(r"(?:`|^)(juliavdb explore (?:bunny|--map)[^`\n]*)", text, re.M)):
                with self.subTest(command), tempfile.TemporaryDirectory() as folder:
                    shutil.copy(BUNNY, folder)
                    small = ["--sdf-resolution", "60"] if "bunny.obj" in command else []
                    words = [PROGRAM, *shlex.split(command)[1:], *small]
                    if "--export" in words:
                        subprocess.run(words, cwd=folder, check=True, capture_output=True)
                        written = pathlib.Path(folder, words[words.index("--export") + 1])
                        self.assertIn("</html>", written.read_text()[-200:])
                        exported += 1
                        continue
                    server = subprocess.Popen(words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
                    try:
                        address = server.stdout.readline().strip()
                        with urllib.request.urlopen(address) as answer:
                            self.assertIn(b"<html", answer.read())
                        server.send_signal(signal.SIGINT)
                        server.communicate(timeout=60)
                        self.assertEqual(server.returncode, 0)
                    finally:
                        server.kill()
                    served += 1
        self.assertGreaterEqual(served, 3)
        self.assertGreaterEqual(exported, 3)


if __name__ == "__main__":
    unittest.main()

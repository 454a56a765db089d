# SPDX-License-Identifier: Apache-2.0
"""The README and the pages that it leads to first are true: their commands run as they stand, their options exist, the README
is short, and quickstart works."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from shell import BUNNY, PROGRAM, put_bunny, run, with_bunny

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
README = (ROOT / "README.md").read_text()
PAGES = {"README": README, **{name: (ROOT / f"docs/{name}.md").read_text() for name in ("usage", "options", "study", "sets")}}


def blocks_of(page):
    return re.findall(r"```sh\n(.*?)```", PAGES[page], re.S)


# Enough to see that a command does what it should.
SMALL = [(r"--resolution \d+", "--resolution 40"), (r" --samples \d+", ""), (r"--size \d+x\d+", "--size 40x40 --samples 1"),
         (r"(juliavdb print .*)", r"\1 --resolution 40"), (r"--versors \d+", "--versors 12"), (r"--points \d+", "--points 300"), (r"--roots \d+", "--roots 20"),
         (r"\b(fractal|study|plan tiles) \$bunny", r"\1 $bunny --sdf-resolution 48")]


def small(block):
    for pattern, replacement in SMALL:
        block = re.sub(pattern, replacement, block)
    return block


class Readme(unittest.TestCase):
    # Promise of README.md: The commands of the README and the pages run as they stand; usage.md "has an example of every command"
    def test_every_command_of_it_runs(self):
        self.assertEqual([b.strip() for b in blocks_of("README")[:2]], ["./quickstart", "./run-tests"])
        for page in PAGES:
            blocks = [block for block in blocks_of(page) if not block.startswith("./")]
            with self.subTest(page=page), tempfile.TemporaryDirectory() as folder:
                put_bunny(folder)
                for block in blocks:
                    # What serves until it is stopped is run by explore_test.py.
                    block = re.sub(r"^juliavdb explore (?!.*--export).*$", "", block, flags=re.M)
                    if not shutil.which("parallel"):
                        block = re.sub(r"^juliavdb submit (\w+) .* (-o \S+)$", r"juliavdb task \1 --range 1-4; juliavdb merge \1 \2", block,
                                       flags=re.M)
                    done = run(small(with_bunny(block, folder)), folder)
                    self.assertEqual(done.returncode, 0, f"{block}\n{done.stderr}")
                made = set(os.listdir(folder))
                for name in set(re.findall(r"(?:-o|--mesh) ([^-\s]\S*\.\w+)", "".join(blocks))):
                    self.assertIn(name.replace("####", "0001"), made)

    # Promise: The commands of the README ...
    def test_usage_has_an_example_of_every_command(self):
        self.assertIn("has an example of every command", README)
        help_text = subprocess.run([PROGRAM, "--help"], capture_output=True, text=True, check=True).stdout
        commands = re.findall(r"^  (\w+) ", help_text, re.M)
        self.assertGreater(len(commands), 20, help_text)
        shown = re.findall(r"\bjuliavdb (\w+)", "".join(blocks_of("usage")))
        self.assertEqual([command for command in commands if command not in shown], [])

    def test_it_is_short(self):
        self.assertLessEqual(len(README.splitlines()), 150)

    # Promise: The commands of the README ...
    def test_quickstart_writes_its_three_files_and_three_commands_that_work(self):
        self.assertTrue(os.access(ROOT / "run-tests", os.X_OK))
        with tempfile.TemporaryDirectory() as folder:
            # The program, with a coarser bunny at a resolution for tests.
            stand_in = pathlib.Path(folder) / "juliavdb"
            stand_in.write_text(f"""#!/usr/bin/env bash
bunny={BUNNY} coarse={put_bunny(folder)}
words=("${{@//$bunny/$coarse}}")
case $1 in
  fractal) words+=(--sdf-resolution 60) ;;
  render) words+=(--size 100x100) ;;
esac
exec {PROGRAM} "${{words[@]/#250/60}}"
""")
            stand_in.chmod(0o755)
            done = subprocess.run([ROOT / "quickstart"], capture_output=True, text=True,
                                  env={**os.environ, "JULIAVDB": str(stand_in), "OUT": folder})
            self.assertEqual(done.returncode, 0, done.stderr)
            for name in ("bunny_fractal.vdb", "bunny_fractal.ply", "bunny_fractal.png"):
                self.assertGreater((pathlib.Path(folder) / name).stat().st_size, 1000)
                self.assertIn(name, done.stdout)
            commands = re.findall(r"^  (\S*juliavdb .*)$", done.stdout, re.M)
            self.assertEqual(len(commands), 3, done.stdout)
            for command in commands:
                small = re.sub(r"--resolution \d+", "--resolution 40", command)
                done = run(re.sub(r"--size \S+", "--size 40x40 --sdf-resolution 60", small), folder)
                self.assertEqual(done.returncode, 0, f"{command}\n{done.stderr}")

    def test_quickstart_installs_a_package(self):
        with tempfile.TemporaryDirectory() as folder:
            tools = pathlib.Path(folder) / "tools"
            tools.mkdir()
            # What would change this machine only writes down what it is asked for.
            for name, text in (("apt-get", 'echo "$@" >> "$LOG"'), ("sudo", 'exec "$@"'), ("dpkg-query", "echo install ok installed"),
                               ("juliavdb", f'exec {PROGRAM} "${{@/#250/40}}" $([ "$1" = render ] || echo --sdf-resolution 48)')):
                (tools / name).write_text(f"#!/usr/bin/env bash\n{text}\n")
                (tools / name).chmod(0o755)
            (pathlib.Path(folder) / "x.deb").write_text("a package")
            environment = {name: value for name, value in os.environ.items() if name != "JULIAVDB"}
            environment.update(PATH=f"{tools}:{os.environ['PATH']}", LOG=f"{folder}/log", OUT=f"{folder}/out")

            def quickstart(*words):
                return subprocess.run([ROOT / "quickstart", *words], capture_output=True, text=True, env=environment, cwd=folder)

            done = quickstart("--deb", "x.deb")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(f"install -y -qq --no-install-recommends {os.path.realpath(folder)}/x.deb", pathlib.Path(folder, "log").read_text())
            self.assertTrue(pathlib.Path(folder, "out/bunny_fractal.png").is_file())
            for words, code, mention in ((("--deb", "y.deb"), 66, "y.deb"), (("--dev", "x.deb"), 2, "--dev"), (("--deb",), 1, "needs the file"),
                                         (("--bundle",), 1, "needs the name"), (("--bundle", "x.zip"), 2, "x.zip"),
                                         (("--bundle", "nowhere/x.tar.xz"), 73, "nowhere/x.tar.xz")):
                done = quickstart(*words)
                self.assertEqual(done.returncode, code, words)
                self.assertIn(mention, done.stderr)

    # Promise: The commands of the README ...
    def test_every_option_it_names_exists(self):
        text = ""
        for command in ("sdf", "fractal", "fit", "mesh", "points", "print", "convert", "versor", "sheet", "slice", "study", "render", "explore", "info", "usd",
                        "plan tiles", "task", "submit", "merge"):
            text += subprocess.run([PROGRAM, *command.split(), "--help", "all"], capture_output=True, text=True,
                                   check=True).stdout
        # Those of CMake and of quickstart stand beside ours.
        known = set(re.findall(r"--[a-z][a-z0-9-]*", text)) | {"--help", "--build", "--target", "--deb", "--bundle"}
        for page, words in PAGES.items():
            for option in set(re.findall(r"--[a-z][a-z0-9-]*", words)):
                self.assertIn(option, known, page)

    def test_every_file_it_names_is_there(self):
        for link in re.findall(r"\]\(([^)#:]+)\)", README):
            self.assertTrue((ROOT / link).exists(), link)


if __name__ == "__main__":
    unittest.main()

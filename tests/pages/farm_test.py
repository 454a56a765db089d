# SPDX-License-Identifier: Apache-2.0
"""The commands of docs/farm.md run as they stand, at a small size, with GNU parallel and with Slurm."""
import os
import pathlib
import re
import shlex
import shutil
import sys
import tempfile
import unittest
from unittest import mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))

import slurm_node
from shell import PROGRAM, put_bunny, run, with_bunny

PAGE = pathlib.Path(__file__).resolve().parent.parent.parent / "docs/farm.md"
SMALL = [(r"--resolution \d+", "--resolution 32"), (r"\b(fractal|tiles|frames|sheet) (bunny\.obj)", r"\1 \2 --sdf-resolution 40"),
         (r"sheet bunny\.obj", r"sheet bunny.obj --size 40x40 --samples 1"), ("--frames 1-48", "--frames 1-4"),
         ("@48", "@4")]


def small(block):
    for pattern, replacement in SMALL:
        block = re.sub(pattern, replacement, block)
    return block


def needs_slurm(block):
    return bool(re.search(r"--engine slurm|squeue|\bfar\.|status slurm", block))


class Page(unittest.TestCase):

    def setUp(self):
        self.text = PAGE.read_text()
        self.blocks = re.findall(r"```sh\n(.*?)```", self.text, re.S)
        self.assertGreater(len(self.blocks), 8)
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_test_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        put_bunny(self.folder)

    def run_block(self, block):
        templates = pathlib.Path(__file__).resolve().parent.parent.parent / "integrations/farm"
        block = block.replace("/usr/share/juliavdb/templates", shlex.quote(str(templates)))
        done = run(small(with_bunny(block, self.folder)), self.folder)
        self.assertEqual(done.returncode, 0, f"{block}\n{done.stdout}{done.stderr}")
        return done.stdout

    def numbers(self, plan, option=""):
        return run(f"juliavdb status {plan} {option}", self.folder).stdout

    # Promise: The commands of the README ...
    # Promise: What is merged "has the same ..."
    @unittest.skipUnless(shutil.which("parallel"), "GNU parallel is not installed")
    def test_every_command_runs(self):
        node, why = None, slurm_node.why_not()
        if not why:
            try:
                node = slurm_node.Node()
                self.addCleanup(node.stop)
            except slurm_node.CannotStart as error:
                why = str(error)
        with mock.patch.dict(os.environ, node.environment if node else {}):
            for block in self.blocks:
                if needs_slurm(block) and not node:
                    continue
                self.run_block(block)
                if "--engine slurm" in block and node:
                    node.wait_until_idle()
        plans = ["farm", "any", "mine", "grow", "chosen", *(["slurm"] if node else [])]
        for plan in plans:
            self.assertRegex(self.numbers(plan), r"\A(\d+) tasks: \1 done, 0 running, 0 failed, 0 missing\n", plan)
        self.assertEqual((self.folder / "mine.ply").read_bytes(), (self.folder / "bunny.ply").read_bytes())
        self.assertEqual(len(list((self.folder / "grow/out").glob("bunny.*.vdb"))), 4)
        if why:
            self.skipTest(f"all but the commands of Slurm were run: {why}")

    # Promise: Slurm: the script, the merge ...
    def test_the_script_is_the_one_that_the_program_writes(self):
        shown, = re.findall(r"```\n(#!/bin/sh\n.*?)```", self.text, re.S)
        self.run_block("".join(block for block in self.blocks if "cp " in block))
        block, = [block for block in self.blocks if "--engine slurm --dry-run" in block]
        with mock.patch.dict(os.environ, {"SLURM_CONF": os.devnull}):
            script = self.run_block(block)
        script = script[script.index("#!"):].replace(str(PROGRAM), "/usr/bin/juliavdb")
        script = script.replace(os.path.realpath(self.folder), "/home/me").replace(str(self.folder), "/home/me")
        self.assertEqual(script, shown)


if __name__ == "__main__":
    unittest.main()

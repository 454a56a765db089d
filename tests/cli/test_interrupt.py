# SPDX-License-Identifier: Apache-2.0
# Promise of design.md#4-the-command-line: Ctrl-C and SIGTERM end with 75 soon, and leave what was there
"""Ctrl-C and SIGTERM: gone within a second, exit code 75, nothing left behind."""

import json
import signal
import subprocess
import time

import harness


class Interrupt(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.sphere(3)))

    def interrupt_in(self, phase, *arguments, by=signal.SIGINT):
        """Starts a job that would take long, and stops it once it says that it is in @a phase."""
        before = self.listing()
        process = subprocess.Popen([harness.program(), *map(str, arguments), "--progress", "json"], cwd=self.folder,
                                   env=harness.environment(), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, preexec_fn=harness.restore_interrupt)
        try:
            seen = []
            for line in process.stderr:
                self.assertTrue(line.startswith(b"{"), f"the job ended before the phase '{phase}': {line} after {seen}")
                seen.append(json.loads(line).get("phase"))
                if seen[-1] == phase:
                    break
            self.assertIn(phase, seen, "no such phase")
            stdout, stderr, took = harness.stop(process, by)
        finally:
            process.kill()
            process.wait()
            process.stdout.close()
            process.stderr.close()
        self.assertEqual(process.returncode, harness.INTERRUPTED, stderr.decode())
        self.assertLess(took, harness.SOON)
        self.assertEqual(stdout, b"")
        ends = [event for event in map(json.loads, stderr.decode().splitlines()) if event["event"] == "end"]
        self.assertEqual([(event["ok"], event["exit"]) for event in ends], [(False, harness.INTERRUPTED)])
        self.assertTrue(ends[0]["error"].startswith("interrupted"), ends)
        self.assertEqual(self.listing(), before)

    def test_distance_field(self):
        self.interrupt_in("distance field", "sdf", "s.obj", "-o", "x.vdb", "--resolution", 1200, "--band", 20)

    def test_field(self):
        self.interrupt_in("field", "fractal", "s.obj", "-o", "x.vdb", "--mesh", "x.ply", "--resolution", 1000,
                          "--alpha", 6, "--sdf-resolution", 48, "--grids", "surface,logmodulus")

    def test_level_set_by_sigterm(self):
        self.interrupt_in("surface", "fractal", "s.obj", "-o", "x.vdb", "--resolution", 1000, "--alpha", 6,
                          "--sdf-resolution", 48, by=signal.SIGTERM)

    def test_surface(self):
        self.interrupt_in("surface", "fractal", "s.obj", "--mesh", "x.ply", "-o", "x.vdb", "--resolution", 250,
                          "--alpha", 20, "--sdf-resolution", 48, "--tolerance", 1e-12, "--texture-roots", 400)

    def test_field_of_a_quadratic_map(self):
        self.interrupt_in("field", "fractal", "--map", "quadratic", "--c=-0.2,0.6,0.2,0.2", "--iterations", 1000,
                          "-o", "x.vdb", "--resolution", 600)

    def test_slice(self):
        self.interrupt_in("slice", "slice", "s.obj", "-o", "x.png", "--field", "f", "--size", 20000,
                          "--sdf-resolution", 32)

    def test_study(self):
        self.interrupt_in("versors", "study", "s.obj", "-o", "x.png", "--csv", "x.csv", "--alpha", 6, "--versors",
                          100000, "--sdf-resolution", 32)

    def test_render(self):
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 32)
        self.interrupt_in("render", "render", "s.vdb", "-o", "x.png", "--size", "6000x6000", "--samples", 16)

    # Promise: "What an interruption reports ..."
    def test_what_is_left_of_a_turntable_is_told(self):
        self.ok("sdf", "s.obj", "-o", "s.vdb", "--resolution", 32)
        process = subprocess.Popen(
            [harness.program(), "render", "--field", "s.obj", "-o", "x.####.png", "--frames", "1-500", "--turn", "360", "--size", "64x64",
             "--sdf-resolution", "24", "--progress", "json"], cwd=self.folder, env=harness.environment(),
            stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, preexec_fn=harness.restore_interrupt)
        end = time.monotonic() + harness.TIMEOUT
        while len(list(self.folder.glob("x.*.png"))) < 2 and time.monotonic() < end:
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate(timeout=harness.TIMEOUT)
        self.assertEqual(process.returncode, harness.INTERRUPTED)
        told = json.loads(stderr.decode().splitlines()[-1])
        frames = [name for name in self.listing() if name.endswith(".png")]
        self.assertTrue(1 < len(frames) < 500, frames)
        self.assertEqual(sorted(told["written"]), frames)
        self.assertIn("finished frames are kept", told["error"])

    def test_a_plan_leaves_no_part_of_it(self):
        """So that the same command can be given again. What --estimate surveys comes after the distances."""
        self.interrupt_in("field", "plan", "tiles", "s.obj", "-o", "p", "--tiles", 4, "--resolution", 2000, "--alpha", 6,
                          "--sdf-resolution", 48, "--estimate")

    # Promise: "No temporary file stays behind"
    def test_an_existing_output_stays(self):
        self.write("x.vdb", "precious")
        self.interrupt_in("surface", "fractal", "s.obj", "-o", "x.vdb", "--resolution", 1000, "--alpha", 6,
                          "--sdf-resolution", 48)
        self.assertEqual(self.bytes("x.vdb"), b"precious")

    def test_before_anything_is_said(self):
        """At once after the start: while the program loads it has no handler yet, but no file either."""
        for delay in (0.3, 0.6):
            process = subprocess.Popen([harness.program(), "fractal", "s.obj", "-o", "x.vdb", "--resolution", "1000",
                                        "--alpha", "6"], cwd=self.folder, env=harness.environment(),
                                       stdin=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                       preexec_fn=harness.restore_interrupt)
            time.sleep(delay)
            self.assertLess(harness.stop(process)[2], harness.SOON)
            self.assertIn(process.returncode, (harness.INTERRUPTED, -signal.SIGINT))
            self.assertEqual(self.listing(), ["s.obj"])


if __name__ == "__main__":
    harness.main()

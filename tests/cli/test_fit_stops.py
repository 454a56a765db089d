# SPDX-License-Identifier: Apache-2.0
# Promise: Ctrl-C and SIGTERM end with 75 ...
"""Ctrl-C and SIGTERM in each phase of fit."""

import signal

import harness
import test_fit
import test_interrupt


class Interrupted(harness.CliTest):
    interrupt_in = test_interrupt.Interrupt.interrupt_in

    def setUp(self):
        super().setUp()
        self.write("m.obj", harness.obj(test_fit.pebble()))

    def test_fast_fit(self):
        self.interrupt_in("fit", "fit", "m.obj", "-o", "x.json", "--report", "x.csv", "--plot", "x.png", "--roots",
                          2000)

    def test_schedule_by_sigterm(self):
        self.interrupt_in("electrostatics", "fit", "m.obj", "-o", "x.json", "--triangles", 20000, "--schedule",
                          "97(VF)", by=signal.SIGTERM)

    def test_monopoles(self):
        self.interrupt_in("monopoles", "fit", "m.obj", "-o", "x.json", "--triangles", 3000, "--schedule", "97(VF)",
                          "--roots", 3000, "--epsilon", 1e-9)

    def test_pass(self):
        self.interrupt_in("fit 97(V)", "fit", "m.obj", "-o", "x.json", "--triangles", 600, "--schedule", "97(VF)")

    def test_an_existing_output_stays(self):
        self.write("x.json", "precious")
        self.interrupt_in("fit", "fit", "m.obj", "-o", "x.json", "--roots", 2000)
        self.assertEqual(self.bytes("x.json"), b"precious")


if __name__ == "__main__":
    harness.main()

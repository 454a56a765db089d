# SPDX-License-Identifier: Apache-2.0
"""Oclgrind, a device of OpenCL that watches what kernels do, finds nothing."""

import os
import pathlib
import unittest

import harness
import test_device

OCLGRIND = pathlib.Path("/usr/lib/oclgrind/liboclgrind-rt-icd.so")


@unittest.skipUnless(OCLGRIND.exists(), "Oclgrind is not installed; Debian 13 has no package of it")
@unittest.skipUnless("JULIAVDB_FAKE_LOADER" in os.environ, "there is no loader of OpenCL")
class UnderOclgrind(test_device.Devices):

    # Promise of gpu.md: Oclgrind "found no data race, no value that is read before it is written, and no access out of bounds"
    def test_no_kernel_races_or_reads_what_is_not_there(self):
        """Of symmetric waves and of roots, in floats and in doubles, points and edges."""
        os.mkdir(self.path("vendors"))
        self.write("vendors/oclgrind.icd", str(OCLGRIND))
        complaints = pathlib.Path(self.path("complaints"))
        self.write("v.o3d", harness.o3d(harness.ROOTS, harness.ROOTS[:1]))
        low = ("--resolution", 8, "--sdf-resolution", 28)
        for options in (("--iterations", 2, "--texture-symmetry", "3:y"),
                        ("--texture", "v.o3d", "--precision", "double", "--iterations", 2)):
            with self.subTest(options=options):
                self.ok("fractal", "t.obj", *low, *options, "--mesh", "here.ply")
                said = self.ok("fractal", "t.obj", *low, *options, "--mesh", "there.ply", *test_device.ON,
                               env=test_device.fake("rounded", OCL_ICD_VENDORS=str(self.path("vendors")), OCLGRIND_DATA_RACES="1",
                                        OCLGRIND_UNINITIALIZED="1", OCLGRIND_LOG=str(complaints),
                                        JULIAVDB_DEVICE_TIMEOUT="3600"))
                self.assertIn("Oclgrind", said)
                self.assertNotIn("The processor", said)
                self.assertEqual(complaints.read_text() if complaints.exists() else "", "")
                self.assertTrue(self.bytes("here.ply") == self.bytes("there.ply"))


if __name__ == "__main__":
    harness.main()

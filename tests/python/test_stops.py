# SPDX-License-Identifier: Apache-2.0
"""Work that Python waits for: it tells how far it is, leaves other threads alone, and stops when it is told to."""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))
import harness  # noqa: E402

try:
    import juliavdb
    import numpy as np
except ImportError as error:
    print(f"skipped: {error}")
    juliavdb = None

# Minutes of work.
LONG = dict(map="quadratic", c=(-0.2, 0.6, 0.2, 0.2), iterations=60, resolution=1500)
SHORT = dict(map="quadratic", c=(-0.2, 0.6, 0.2, 0.2), iterations=8, resolution=120)

SCRIPT = f"""
import sys, time, juliavdb
print("ready", flush=True)
try:
    juliavdb.fractal(**{LONG!r}).write(sys.argv[1])
except KeyboardInterrupt as error:
    print(repr(str(error)), time.monotonic(), flush=True)
    raise
"""


@unittest.skipUnless(juliavdb, "the Python module was not built, or there is no numpy")
class Stops(unittest.TestCase):

    # Promise: "other threads run meanwhile"; Ctrl-C ...
    # Promise: Ctrl-C and SIGTERM end with 75 ...
    def test_ctrl_c_stops_within_a_second(self):
        with tempfile.TemporaryDirectory(prefix="juliavdb_test_") as folder:
            for _ in range(2):
                child = subprocess.Popen(
                    [sys.executable, "-c", SCRIPT, os.path.join(folder, "f.ply")], stdout=subprocess.PIPE,
                    stderr=subprocess.PIPE, text=True,
                    preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
                self.assertEqual(child.stdout.readline(), "ready\n")
                time.sleep(1.5)
                self.assertIsNone(child.poll(), "the work was to be long")
                _, err, took = harness.stop(child)
                self.assertLess(took, harness.SOON)
                self.assertIn("KeyboardInterrupt", err)
                self.assertEqual(os.listdir(folder), [])

    # Promise of python.md: `progress` is called "in the thread of the call and at most 20 times a second for each phase", and
    #   cancels
    def test_a_callback_hears_of_the_phases_in_its_own_thread(self):
        heard = []

        def progress(phase, share):
            self.assertIs(threading.current_thread(), threading.main_thread())
            heard.append((phase, share))

        juliavdb.fractal(**SHORT, progress=progress)
        phases = list(dict.fromkeys(phase for phase, _ in heard))
        self.assertGreaterEqual(len(phases), 1)
        for phase in phases:
            shares = [share for name, share in heard if name == phase and share is not None]
            self.assertEqual(shares, sorted(shares), phase)
            self.assertTrue(all(0 <= share <= 1 for share in shares), phase)
        self.assertTrue(any(share for _, share in heard), "some share is told")

    # Promise: `progress` is called "in the thread ..."
    def test_a_callback_is_called_at_most_twenty_times_a_second_for_each_phase(self):
        """A machine that is busy calls it less often, and never more."""
        heard = []
        longer = dict(SHORT, resolution=300)
        juliavdb.fractal(**longer, progress=lambda phase, share: heard.append((phase, time.monotonic())))
        self.assertTrue(heard)
        for phase in {name for name, _ in heard}:
            times = [when for name, when in heard if name == phase]
            self.assertLessEqual(len(times) - 2, 20 * (times[-1] - times[0]), phase)

    # Promise: `progress` is called "in the thread ..."
    def test_a_callback_cancels(self):
        begun = time.process_time()
        with self.assertRaisesRegex(KeyboardInterrupt, "nothing was written"):
            juliavdb.fractal(**LONG, progress=lambda phase, share: False)
        field = juliavdb.Field(**SHORT)
        with self.assertRaises(KeyboardInterrupt):
            field(np.zeros((3000000, 3)), progress=lambda phase, share: False)
        self.assertLess(time.process_time() - begun, 2 * harness.SOON)

    def test_an_error_of_the_callback_is_the_callers(self):
        def progress(phase, share):
            raise LookupError("mine")

        with self.assertRaisesRegex(LookupError, "mine"):
            juliavdb.fractal(**LONG, progress=progress)

    # Promise of python.md: "other threads run meanwhile"; Ctrl-C stops a call and "nothing is written"
    def test_other_threads_run_meanwhile(self):
        counted, over = [0], threading.Event()

        def count():
            while not over.is_set():
                counted[0] += 1
                time.sleep(0.005)

        thread = threading.Thread(target=count)
        thread.start()
        begun = time.monotonic()
        try:
            juliavdb.fractal(**SHORT)
        finally:
            seconds = time.monotonic() - begun
            over.set()
            thread.join()
        # Were the lock held, it would have counted once or twice.
        self.assertGreater(counted[0], 20 * seconds)

    # Promise of python.md: Other threads "may use the same result"
    def test_two_threads_write_one_fractal(self):
        """Its grids are made by one of them; the files are those that a single thread writes."""
        with tempfile.TemporaryDirectory(prefix="juliavdb_test_") as folder:
            path = pathlib.Path(folder)
            juliavdb.fractal(**SHORT).write(path / "alone.vdb")
            made, failures = juliavdb.fractal(**SHORT), []

            def work(name):
                try:
                    made.write(path / name)
                except BaseException as error:
                    failures.append(error)

            names = ["0.vdb", "1.vdb", "2.vdb", "3.vdb", "4.ply"]
            threads = [threading.Thread(target=work, args=(name,)) for name in names]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            self.assertEqual(failures, [])
            alone = (path / "alone.vdb").read_bytes()
            for name in names[:4]:
                self.assertEqual((path / name).read_bytes(), alone)

    # Promise: "other threads run meanwhile"; Ctrl-C ...
    def test_two_threads_work_at_once(self):
        alone = juliavdb.fractal(**SHORT).vertices
        found = [None, None]

        def work(i):
            found[i] = juliavdb.fractal(**SHORT).vertices

        threads = [threading.Thread(target=work, args=(i,)) for i in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for vertices in found:
            self.assertTrue(np.array_equal(vertices, alone))


if __name__ == "__main__":
    unittest.main()

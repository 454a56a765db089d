# SPDX-License-Identifier: Apache-2.0
"""What the tests of `juliavdb explore` share: a server that runs, and requests to it."""

import http.client
import json
import pathlib
import signal
import subprocess
import sys
import time
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cli"))
import harness  # noqa: E402  the folder of the program's other tests

# Small enough to be quick, and no ball, so that pictures show which way is up.
QUICK = ("--sdf-resolution", "32", "--resolution", "24", "--texture-seed", "3", "--iterations", "3")


class Server:
    """A running server. It must have been ended by the end of the test; stop() or the context does that."""

    def __init__(self, folder, *arguments, env=None):
        self.process = subprocess.Popen([harness.program(), *map(str, harness.quiet(("explore", *arguments)))], cwd=folder,
                                        env=harness.environment(env), stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        preexec_fn=harness.restore_interrupt)
        self.url = self.process.stdout.readline().decode().strip()
        if not self.url:
            errors = self.process.stderr.read().decode()
            self.process.wait()
            raise RuntimeError(f"no address: {self.process.returncode} {errors}")
        parts = urllib.parse.urlsplit(self.url)
        self.host, self.port, self.prefix = parts.hostname, parts.port, parts.path
        self.key = parts.path.strip("/")

    def __enter__(self):
        return self

    def __exit__(self, *unused):
        self.kill()

    def kill(self):
        """@throw RuntimeError  if it had ended by itself, whatever the test saw of that"""
        code, was_stopped = self.process.poll(), self.process.stderr.closed
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        errors = b"" if code is None or was_stopped else self.process.stderr.read()
        self.process.stderr.close()
        if code is not None and not was_stopped:
            raise RuntimeError(f"the server ended by itself, with code {code}: {errors.decode()}")

    def stop(self, by=signal.SIGINT):
        """Ends the server as a user does. @return seconds of a processor, exit code, what it said"""
        _, errors, took = harness.stop(self.process, by)
        return took, self.process.returncode, errors.decode()

    def connect(self, timeout=harness.TIMEOUT):
        return http.client.HTTPConnection(self.host, self.port, timeout=timeout)

    def raw(self, method, path, body=None, headers=None, key=None):
        """@return status, headers, body"""
        connection = self.connect()
        try:
            connection.request(method, f"/{self.key if key is None else key}/{path}", body, headers or {})
            answer = connection.getresponse()
            return answer.status, dict(answer.getheaders()), answer.read()
        finally:
            connection.close()

    def get(self, path):
        status, headers, body = self.raw("GET", path)
        return status, json.loads(body) if headers["Content-Type"] == "application/json" else body

    def post(self, path, content, kind="application/json"):
        body = json.dumps(content).encode() if kind == "application/json" else content
        status, headers, body = self.raw("POST", path, body, {"Content-Type": kind})
        return status, json.loads(body) if headers["Content-Type"] == "application/json" else body

    def delete(self, path):
        return self.raw("DELETE", path)[0]

    def recipe(self, **options):
        """The first look's, with other options."""
        recipe = dict(self.get("start")[1]["recipe"])
        recipe.update({name.replace("_", "-"): str(value) for name, value in options.items()})
        return recipe

    def job(self, number):
        return next(job for job in self.get("jobs")[1] if job["job"] == number)

    def wait_for(self, number, states=("done", "failed", "cancelled"), seconds=harness.TIMEOUT):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            job = self.job(number)
            if job["state"] in states:
                return job
            time.sleep(0.02)
        raise AssertionError(f"the job is still {job}")

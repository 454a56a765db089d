#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the server of `juliavdb explore` refuses, and that it is alive afterwards."""

import concurrent.futures
import http.client
import json
import os
import pathlib
import re
import signal
import socket
import time

from server import QUICK, Server, harness

JSON = {"Content-Type": "application/json"}
BYTES = {"Content-Type": "application/octet-stream"}


class Safety(harness.CliTest):

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.torus(around=24, across=12)))
        self.page = self.serve("s.obj", *QUICK)

    def serve(self, *arguments):
        running = Server(self.folder, *arguments)
        self.addCleanup(running.kill)
        return running

    def assert_alive(self):
        self.assertEqual(self.page.raw("GET", "jobs")[0], 200)

    def send(self, data, timeout=20):
        """@return everything that comes back until the server ends the connection or is silent"""
        with socket.create_connection((self.page.host, self.page.port), timeout=timeout) as connection:
            answer = b""
            try:
                connection.sendall(data)
                while part := connection.recv(65536):
                    answer += part
            except (ConnectionError, socket.timeout):
                pass
            return answer

    # ------------------------------------------------------------------------------------------------ who may ask

    def test_the_address(self):
        self.assertRegex(self.page.url, r"^http://127\.0\.0\.1:\d+/[0-9a-f]{32}/$")
        self.assertNotEqual(self.serve("s.obj", *QUICK).key, self.page.key)

    # Promise: "The server listens on this ..."
    def test_the_wrong_key(self):
        key = self.page.key
        wrong = ["", "x", key[:-1], key + "0", key.upper() if key.upper() != key else "0" * 32, "0" * 32, key[::-1] + "1",
                 key[:16] + "0" * 16, "..", "%00", key + "%00", "%2e%2e"]
        for each in wrong:
            for path in ("", "start", "page/index.html", "jobs"):
                status, _, body = self.page.raw("GET", path, key=each)
                self.assertEqual(status, 404, (each, path))
                self.assertNotIn(key.encode(), body)
        self.assertEqual(self.page.raw("POST", "scene", b"{}", JSON, key="0" * 32)[0], 404)
        connection = self.page.connect()
        for target in ("/", "/favicon.ico", "//", "/start", "/" + key):
            connection.request("GET", target)
            answer = connection.getresponse()
            answer.read()
            self.assertEqual(answer.status, 404, target)
        connection.close()
        self.assert_alive()

    # Promise: "The server listens on this ..."
    def test_other_hosts(self):
        """An attacker's page whose name was pointed at this machine sends its own name."""
        port = self.page.port
        for host, status in ((f"127.0.0.1:{port}", 200), (f"localhost:{port}", 200), (f"LOCALHOST:{port}", 200),
                             ("evil.example", 403), (f"evil.example:{port}", 403), ("127.0.0.1", 403), ("localhost", 403),
                             (f"127.0.0.1.evil.example:{port}", 403), (f"localhost.evil.example:{port}", 403),
                             ("", 403), (f"127.0.0.1:{port + 1}", 403), (f"0.0.0.0:{port}", 403),
                             (f"evil@127.0.0.1:{port}", 403)):
            self.assertEqual(self.page.raw("GET", "start", headers={"Host": host})[0], status, host)
        request = f"GET /{self.page.key}/start HTTP/1.1\r\n"
        self.assertIn(b" 403 ", self.send((request + "\r\n").encode()), "no Host at all")
        twice = f"Host: 127.0.0.1:{port}\r\nHost: evil.example\r\n\r\n"
        self.assertIn(b" 403 ", self.send((request + twice).encode()))

    # Promise: "The server listens on this ..."
    def test_other_origins(self):
        port = self.page.port
        for origin, status in ((f"http://127.0.0.1:{port}", 200), ("http://evil.example", 403), ("null", 403),
                               (f"https://127.0.0.1:{port}", 403), (f"http://localhost:{port}", 403),
                               (f"http://127.0.0.1:{port}.evil.example", 403)):
            headers = {**JSON, "Origin": origin}
            body = json.dumps({"recipe": {"input": "s.obj"}}).encode()
            self.assertEqual(self.page.raw("POST", "command", body, headers)[0], status, origin)
        # A form of another site can send these without being asked.
        for kind in ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x", ""):
            self.assertEqual(self.page.raw("POST", "command", b"{}", {"Content-Type": kind})[0], 415, kind)

    # Promise: "The server listens on this ..."
    def test_headers_of_every_answer(self):
        for path, key in (("", None), ("start", None), ("nothing", None), ("start", "0" * 32)):
            _, headers, _ = self.page.raw("GET", path, key=key)
            policy = headers["Content-Security-Policy"]
            self.assertIn("default-src 'self'", policy)
            self.assertNotIn("unsafe", policy)
            self.assertNotIn("http", policy)
            self.assertEqual(headers["X-Content-Type-Options"], "nosniff")
            self.assertEqual(headers["Referrer-Policy"], "no-referrer")
            self.assertEqual(headers["Cache-Control"], "no-store")
            self.assertNotIn("Access-Control-Allow-Origin", headers)

    # Promise of explore.md: "The server listens on this machine only, and only to those who know the random key"
    def test_only_this_machine(self):
        sockets = [line.split() for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]]
        listening = {fields[1] for fields in sockets if fields[3] == "0A"}
        self.assertIn(f"0100007F:{self.page.port:04X}", listening)
        other = self.serve("s.obj", *QUICK, "--bind", "0.0.0.0")
        other.host = "127.0.0.1"
        self.assertEqual(other.raw("GET", "jobs")[0], 200)
        self.assertEqual(other.raw("GET", "jobs", headers={"Host": f"evil.example:{other.port}"})[0], 403)
        _, code, errors = other.stop()
        self.assertEqual(code, harness.DONE)
        self.assertIn("network", errors)

    # -------------------------------------------------------------------------------------------------- the file system

    # Promise: "the page can read no other ..."
    # Promise: The page of `explore` "can ..."
    def test_paths_that_lead_elsewhere(self):
        self.write("secret.txt", "secret")
        ways = ["../secret.txt", "page/../../secret.txt", "page/..%2f..%2fsecret.txt", "page/%2e%2e/%2e%2e/secret.txt",
                "page/..\\..\\secret.txt", "page//etc/passwd", "page/%2fetc%2fpasswd", "/etc/passwd", "%2fetc/passwd",
                "page/....//secret.txt", "page/%252e%252e%252fsecret.txt", "page/index.html/../../../secret.txt",
                "page/index.html%00.css", "page/.", "page/", "page", "volume/../page/index.html", "volume/..%2f..%2fstart",
                "page/%c0%ae%c0%ae/secret.txt", "page/file:///etc/passwd", "s.obj", "page/s.obj"]
        for way in ways:
            status, _, body = self.page.raw("GET", way)
            self.assertEqual(status, 404, way)
            self.assertNotIn(b"secret", body)
            self.assertNotIn(b"root:", body)

    # Promise of explore.md: "the page can read no other files than those of the command line", and writes into its folder alone
    # Promise of SECURITY.md: The page of `explore` "can read the files of the command line and no others, and writes only into
    #   the folder of `--folder`"
    def test_recipes_that_name_files(self):
        self.write("secret.ply", harness.ply(harness.cube()))
        self.write("secret.json", harness.rational_json(harness.ROOTS))
        absolute = str(self.path("secret.ply"))
        cases = [("input", "secret.ply"), ("input", absolute), ("input", "./s.obj"), ("input", "/etc/passwd"),
                 ("texture", "secret.json"), ("texture", "./secret.json"), ("texture", "/dev/zero.json"),
                 ("detail", "texture:secret.png:0:1"), ("detail", "near:secret.ply:0.1:0:1"),
                 ("detail", "paint:red@secret.ply:0:1"), ("detail", "secret.vdb"), ("detail", "secret.vdb:phi"),
                 ("alpha", "near:/etc/passwd:1:1:2"), ("mask", "texture:/dev/zero:0:1"), ("outward", "x.vdb"),
                 ("beta", "/proc/self/environ.vdb")]
        for option, value in cases:
            recipe = self.page.recipe()
            if option in ("alpha", "beta"):
                recipe.pop("detail", None)
                recipe.setdefault("alpha", "20")
                recipe.setdefault("beta", "0")
            recipe[option] = value
            for path in ("scene", "picture", "make", "command"):
                body = {"recipe": recipe, "name": "x", "width": 8, "height": 8}
                status, answer = self.page.post(path, body)
                self.assertEqual(status, 403, (path, option, value, answer))
        recipe = {**self.page.recipe(map="rational"), "rational": "secret.json"}
        recipe.pop("texture-seed")
        self.assertEqual(self.page.post("scene", {"recipe": recipe})[0], 403)
        for colour in ("iterations:/etc/passwd.png", "depth:secret.png"):
            body = {"recipe": self.page.recipe(), "width": 8, "height": 8, "colour": colour}
            self.assertEqual(self.page.post("picture", body)[0], 403)
            body = {"recipe": self.page.recipe(colour=colour), "name": "x"}
            self.assertEqual(self.page.post("make", body)[0], 403)
        self.assertEqual(self.page.get("jobs")[1], [])

    # Promise: "the page can read no other ..."
    def test_files_of_the_command_line_may_be_used(self):
        self.write("mine.json", harness.rational_json(harness.ROOTS))
        self.write("brush.ply", harness.ply(harness.moved(harness.cube(), 0.3, (0.5, 0, 0))))
        page = self.serve("s.obj", *QUICK[:4], "--texture", "mine.json", "--detail", "near:brush.ply:0.4:0.2:0.6")
        for change in ({}, {"texture": "woven"}, {"detail": "0.3"}, {"mask": "near:brush.ply:0.4:0:1"}):
            status, answer = page.post("scene", {"recipe": {**page.recipe(), **change}})
            self.assertEqual(status, 200, answer)
        self.assertEqual(page.post("scene", {"recipe": {**page.recipe(), "texture": "other.json"}})[0], 403)

    # Promise: "the page can read no other ..."
    # Promise: The page of `explore` "can ..."
    def test_names_of_files_to_make(self):
        before = self.listing()
        for name in ("", ".", "..", "../x", "a/b", "/tmp/x", "a\\b", ".hidden", "-o", " x", "x\0y", "x\ny", "ü", "a" * 101,
                     "$(id)", "a;b", "a'b", "*"):
            status, answer = self.page.post("make", {"recipe": self.page.recipe(), "name": name, "formats": ["vdb"]})
            self.assertEqual(status, 400, (name, answer))
            self.assertEqual(self.page.post("command", {"recipe": self.page.recipe(), "name": name})[0], 400, name)
        for formats in ([], ["exe"], ["vdb", "vdb"], ["../x"], [""], "vdb", [1], {"a": 1}):
            status, answer = self.page.post("make", {"recipe": self.page.recipe(), "name": "x", "formats": formats})
            self.assertEqual(status, 400, (formats, answer))
        self.assertEqual(self.listing(), before)

    # ------------------------------------------------------------------------------------------- too much, too slow

    def head(self, path, *headers, method="POST"):
        lines = [f"{method} /{self.page.key}/{path} HTTP/1.1", f"Host: 127.0.0.1:{self.page.port}", *headers, "", ""]
        return "\r\n".join(lines).encode()

    def test_a_body_of_a_gigabyte(self):
        for path, kind in (("scene", "application/json"), ("recipe?name=a.vdb", "application/octet-stream")):
            declared = self.head(path, f"Content-Type: {kind}", f"Content-Length: {1 << 30}")
            self.assertIn(b" 413 ", self.send(declared).split(b"\r\n")[0], path)
        for length in ("99999999999999999999999999", "-1", "x", "", "0x10", "1 2"):
            answer = self.send(self.head("scene", JSON_LINE, f"Content-Length: {length}"))
            self.assertRegex(answer.split(b"\r\n")[0], rb" (400|411|413) ", length)
        twice = self.send(self.head("scene", JSON_LINE, "Content-Length: 2", "Content-Length: 3") + b"{}")
        self.assertIn(b" 400 ", twice.split(b"\r\n")[0])
        chunked = self.send(self.head("scene", JSON_LINE, "Transfer-Encoding: chunked") + b"10\r\n" + b"x" * 16 + b"\r\n")
        self.assertIn(b" 411 ", chunked.split(b"\r\n")[0])
        packed = self.send(self.head("scene", JSON_LINE, "Content-Encoding: gzip", "Content-Length: 2") + b"{}")
        self.assertIn(b" 415 ", packed.split(b"\r\n")[0])
        self.assertIn(b" 400 ", self.send(self.head("jobs", "Content-Length: 5", method="GET") + b"12345").split(b"\r\n")[0])
        self.assert_alive()

    def test_a_gigabyte_that_is_sent(self):
        block = bytes(1 << 20)
        for headers in ((f"Content-Length: {1 << 30}",), ("Transfer-Encoding: chunked",)):
            with socket.create_connection((self.page.host, self.page.port), timeout=20) as connection:
                connection.sendall(self.head("recipe?name=a.vdb", "Content-Type: application/octet-stream", *headers))
                sent = 0
                try:
                    while sent < 1 << 30:
                        connection.sendall(block)
                        sent += len(block)
                except (ConnectionError, socket.timeout):
                    pass
                self.assertLess(sent, 1 << 28, "the server takes it all")
        self.assert_alive()

    def test_heads_that_are_none(self):
        start = f"GET /{self.page.key}/start HTTP/1.1\r\nHost: 127.0.0.1:{self.page.port}\r\n".encode()
        for data in (b"x", b"\r\n\r\n", b"\0" * 100, b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", bytes(range(256)) * 4,
                     b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", b"GET " + b"/" * 12000 + b" HTTP/1.1\r\n\r\n",
                     b"GET /" + b"%" * 8000 + b" HTTP/1.1\r\n\r\n", start + b"no colon\r\n\r\n", start + b": x\r\n\r\n",
                     start + b" folded: x\r\n\r\n", start + b"a b: c\r\n\r\n", start + b"a: \x00\r\n\r\n",
                     b"GET /?" + b"a=b&" * 2500 + b" HTTP/1.1\r\n\r\n", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"):
            answer = self.send(data + b"\r\n\r\n", timeout=8)
            self.assertRegex(answer, rb"^(HTTP/1\.1 (40\d|41\d|431|505) |$)", data[:60])
        self.assertIn(b" 431 ", self.send(start + b"a: b\r\n" * 100000))
        self.assertIn(b" 431 ", self.send(b"G" * 1000000))
        # Whatever the library would do about these, the server has not asked for.
        for header in ("Range: bytes=" + ",".join(f"{i}-{i}" for i in range(1000)), "Accept-Encoding: gzip, br",
                       "Expect: 100-continue", "Cookie: " + "x" * 4000, "X-Forwarded-Host: evil.example"):
            answer = self.send(start + header.encode() + b"\r\nConnection: close\r\n\r\n")
            self.assertTrue(answer.startswith(b"HTTP/1.1 200 "), (header[:30], answer[:100]))
            self.assertTrue(answer.endswith(b"}"), header[:30])
        for method in ("PUT", "PATCH", "OPTIONS", "TRACE", "CONNECT", "BREW"):
            answer = self.send(self.head("start", "Connection: close", method=method))
            self.assertRegex(answer, rb"^HTTP/1\.1 4\d\d ", method)
        self.assert_alive()

    def test_a_hundred_connections_at_once(self):
        idle = [socket.create_connection((self.page.host, self.page.port), timeout=20) for _ in range(100)]
        try:
            time.sleep(0.3)
            # Some were refused at once; the others end within the time for a head.
            end = time.monotonic() + harness.TIMEOUT
            status = None
            while status != 200 and time.monotonic() < end:
                try:
                    status = self.page.raw("GET", "jobs")[0]
                except (OSError, http.client.HTTPException):
                    time.sleep(0.2)
            self.assertEqual(status, 200)
        finally:
            for connection in idle:
                connection.close()

        def ask(_):
            """What a client is told that comes again until it is answered; None: the connection was closed."""
            statuses, end = [], time.monotonic() + harness.TIMEOUT
            while 200 not in statuses and time.monotonic() < end:
                try:
                    statuses.append(self.page.raw("GET", "start")[0])
                except (OSError, http.client.HTTPException):
                    statuses.append(None)
                if statuses[-1] != 200:
                    time.sleep(0.05)
            return statuses

        with concurrent.futures.ThreadPoolExecutor(100) as threads:
            told = list(threads.map(ask, range(300)))
        self.assertTrue({status for statuses in told for status in statuses} <= {200, 503, None}, told)
        self.assertEqual(sum(200 in statuses for statuses in told), 300)
        self.assert_alive()

    def test_slow_clients(self):
        """A byte now and then keeps no connection for longer than a head may take."""
        connection = socket.create_connection((self.page.host, self.page.port), timeout=1)
        slow = iter(self.head("start", "X: " + "x" * 4000, method="GET"))
        start = time.monotonic()
        with connection:
            try:
                while time.monotonic() - start < 90:
                    connection.sendall(bytes([next(slow)]))
                    time.sleep(0.1)
                    connection.setblocking(False)
                    try:
                        if connection.recv(10) == b"":
                            break
                    except BlockingIOError:
                        pass
                    connection.setblocking(True)
            except ConnectionError:
                pass
        self.assertLess(time.monotonic() - start, 60, "sending all of it would take 400 seconds")
        body = self.head("scene", JSON_LINE, "Content-Length: 100") + b"{"
        self.assertIn(b" 408 ", self.send(body, timeout=60)[:20])
        self.assert_alive()

    # ---------------------------------------------------------------------------------------------------- connections

    def test_requests_that_come_together_are_answered_in_their_order(self):
        """A body is no request, and neither is what a HEAD would have as its body."""
        body = b'GET /x HTTP/1.1\r\n\r\n'
        asked = (self.head("nothing", method="GET") + self.head("", method="HEAD") +
                 self.head("command", JSON_LINE, f"Content-Length: {len(body)}") + body +
                 self.head("jobs", "Connection: Close", method="GET") + self.head("start", method="GET"))
        rest, told, whole = self.send(asked), [], self.page.raw("GET", "")[2]
        for method in ("GET", "HEAD", "POST", "GET"):
            head, _, rest = rest.partition(b"\r\n\r\n")
            length = int(re.search(rb"\r\nContent-Length: (\d+)", head).group(1))
            size = 0 if method == "HEAD" else length
            told.append((int(head.split()[1]), length, rest[:size], b"\r\nConnection: close" in head))
            rest = rest[size:]
        self.assertEqual([(status, closes) for status, _, _, closes in told],
                         [(404, False), (200, False), (400, False), (200, True)])
        self.assertEqual(told[1][1], len(whole))
        self.assertEqual(told[3][2], b"[]")
        self.assertEqual(rest, b"", "an answer to what came after the last request")

    def test_a_connection_ends_after_a_thousand_requests(self):
        connection = self.page.connect()
        self.addCleanup(connection.close)
        connection.connect()
        first, closes = connection.sock, []
        for _ in range(1000):
            connection.request("GET", f"/{self.page.key}/jobs")
            answer = connection.getresponse()
            self.assertEqual(answer.read(), b"[]")
            closes.append(answer.headers["Connection"])
            self.assertTrue(connection.sock is first or closes[-1] == "close")
        self.assertEqual(closes, [None] * 999 + ["close"])

    def test_clients_of_old(self):
        asked = self.head("jobs", method="GET").replace(b"HTTP/1.1", b"HTTP/1.0")
        answer = self.send(asked + asked)
        self.assertEqual(answer.count(b"HTTP/1.1 200 OK\r\n"), 1)
        self.assertIn(b"\r\nConnection: close\r\n", answer)
        self.assertTrue(answer.endswith(b"\r\n\r\n[]"), answer)

    def test_addresses(self):
        taken = self.refused(harness.CANNOT_CREATE, "explore", "s.obj", *QUICK, "--port", self.page.port)
        self.assertIn(f"cannot listen at port {self.page.port} of 127.0.0.1: another program may have it", taken)
        # 192.0.2.1 is reserved for documentation: no machine has it.
        other = self.run_program(*harness.quiet(("explore", "s.obj", *QUICK, "--bind", "192.0.2.1")))
        self.assertEqual(other.returncode, harness.CANNOT_CREATE)
        self.assertIn("of 192.0.2.1: ", other.stderr.decode())
        self.assertNotIn("another program", other.stderr.decode())
        if not pathlib.Path("/proc/net/if_inet6").exists() or "lo" not in pathlib.Path("/proc/net/if_inet6").read_text():
            return
        for address, host in (("::1", "::1"), ("::", "::1"), ("::", "127.0.0.1")):
            page = self.serve("s.obj", *QUICK, "--bind", address)
            page.host = host
            self.assertEqual(page.raw("GET", "jobs")[0], 200, (address, host))

    # --------------------------------------------------------------------------------------------------------- the end

    # Promise: "The server listens on this ..."
    def test_the_end(self):
        for by in (signal.SIGINT, signal.SIGTERM):
            page = self.serve("s.obj", *QUICK)
            took, code, errors = page.stop(by)
            self.assertEqual((code, errors), (harness.DONE, ""))
            self.assertLess(took, harness.SOON)

    def test_progress_ends_with_the_address(self):
        page = self.serve("s.obj", *QUICK, "--progress", "json")
        os.set_blocking(page.process.stderr.fileno(), False)
        page.process.stderr.read()
        time.sleep(1.2)  # more than two events of progress
        self.assertFalse(page.process.stderr.read())

    def test_the_end_in_the_middle_of_everything(self):
        before = self.listing()
        body = {"recipe": self.page.recipe(), "name": "x", "formats": ["vdb", "ply"], "resolution": 1500}
        self.assertEqual(self.page.post("make", body)[0], 200)
        picture = json.dumps({"recipe": self.page.recipe(iterations=20), "width": 4000, "height": 4000, "samples": 16,
                              "alphaClarity": 1e-5})
        connections = [self.page.connect() for _ in range(3)]
        connections[0].request("POST", f"/{self.page.key}/picture", picture, JSON)
        connections[1].request("POST", f"/{self.page.key}/scene",
                               json.dumps({"recipe": self.page.recipe(sdf_resolution=900)}), JSON)
        connections[2].connect()
        end = time.monotonic() + harness.TIMEOUT
        while self.listing() == before and time.monotonic() < end:
            time.sleep(0.05)
        time.sleep(0.5)
        self.assertNotEqual(self.listing(), before, "nothing is being made")
        took, code, errors = self.page.stop()
        for connection in connections:
            connection.close()
        self.assertLess(took, 2 * harness.SOON, "each of the jobs is told in its turn")
        self.assertEqual(code, harness.DONE)
        self.assertEqual(self.listing(), before)
        self.assertEqual(errors, "")

    def test_command_lines_that_are_refused(self):
        self.refused(harness.NO_INPUT, "explore", "nothing.obj")
        self.refused(harness.USAGE, "explore")
        self.refused(harness.USAGE, "explore", "s.obj", "--port", "65536")
        self.refused(harness.USAGE, "explore", "s.obj", "--bind", "example.org")
        self.refused(harness.USAGE, "explore", "s.obj", "--open", "maybe")
        self.refused(harness.CANNOT_CREATE, "explore", "s.obj", *QUICK, "--folder", "nowhere/deeper")
        self.refused(harness.CANNOT_CREATE, "explore", "s.obj", *QUICK, "--folder", "s.obj")
        self.refused(harness.CANNOT_CREATE, "explore", "s.obj", *QUICK, "--port", self.page.port)
        self.write("hole.obj", harness.obj(harness.with_hole(harness.sphere(2))))
        self.refused(harness.BAD_DATA, "explore", "hole.obj", *QUICK)


JSON_LINE = "Content-Type: application/json"

if __name__ == "__main__":
    harness.main()

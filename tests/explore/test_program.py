#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page that has a program in a worker in place of a server (wasm/), but for the program: a stand-in for the worker passes the
requests on to a server. wasm/test-page is the test of the program itself."""

import functools
import http.server
import json
import pathlib
import subprocess
import threading

import browser
from browser import harness
from server import QUICK, Server

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent

# It answers as wasm/worker.js does. The dropped files are in its memory; those that are made come from the server's folder.
WORKER = """
const names = [];
async function answerTo(data) {
  if (data.kind === "open") {
    names.push(...data.files.map((file) => file.name));
    if (data.files.some((file) => file.name === "broken.obj"))
      return new Response(JSON.stringify({ error: "'broken.obj' has no faces" }), { status: 400 });
    return new Response("{}");
  }
  if (data.kind === "read") return fetch(`made/${data.name}`);
  const { method, path, name, body } = data, type = path === "recipe" ? "application/octet-stream" : "application/json";
  return fetch(`asked/${path}${name ? `?name=${encodeURIComponent(name)}` : ""}`, method === "POST" ? { method, body, headers: { "Content-Type": type } } : { method });
}
onmessage = async ({ data }) => {
  if (data.kind === "drop") return;
  if (data.kind === "open") postMessage({ loaded: 1048576, total: 3145728 });
  const response = await answerTo(data), body = await response.arrayBuffer();
  postMessage({ number: data.number, status: response.status, type: response.headers.get("Content-Type") ?? "", body }, [body]);
};
"""


class Host(http.server.ThreadingHTTPServer):
    """Static files of a folder, without the headers that isolate a page; below asked/ the server, below made/ its files."""

    def __init__(self, folder, server, made):
        class Handler(http.server.SimpleHTTPRequestHandler):
            def pass_on(self):
                length = int(self.headers.get("Content-Length", 0))
                status, headers, body = server.raw(self.command, self.path.partition("/asked/")[2], body=self.rfile.read(length) or None,
                                                   headers={"Content-Type": self.headers["Content-Type"]} if length else {})
                self.send_response(status)
                self.send_header("Content-Type", headers.get("Content-Type", ""))
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

            def do_GET(self):
                if self.path.startswith("/asked/"):
                    return self.pass_on()
                super().do_GET()

            do_POST = do_DELETE = pass_on

            def translate_path(self, path):
                return str(made / pathlib.Path(path).name) if path.startswith("/made/") else super().translate_path(path)

            def log_message(self, *unused):
                pass

        super().__init__(("127.0.0.1", 0), functools.partial(Handler, directory=folder))
        threading.Thread(target=self.serve_forever, daemon=True).start()


class Program(browser.BrowserTest):
    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.torus(around=24, across=12)))
        subprocess.run([ROOT / "wasm/make-page", self.path("site")], check=True)
        self.path("site/worker.js").write_text(WORKER)
        server = Server(self.path("."), "s.obj", *QUICK, "--folder", "made")
        self.addCleanup(server.kill)
        self.host = Host(self.path("site"), server, self.path("made"))
        self.addCleanup(self.host.server_close)
        self.addCleanup(self.host.shutdown)
        self.driver.get(f"http://localhost:{self.host.server_address[1]}/")
        # The host sends no headers: the page's service worker does.
        self.wait_until(lambda: self.run_script("return crossOriginIsolated") and self.finds(".begin button"), "the first screen")

    def choose(self, name):
        self.find(".begin input[type=file]").send_keys(str(self.path(name)))

    def status(self):
        return self.find(".begin .status").text

    def wait_for_picture(self):
        self.wait_until(lambda: self.run_script("return Boolean(window.explore && window.explore.scene())"), "a picture")

    def test_from_a_mesh_to_a_file(self):
        self.choose("s.obj")
        self.wait_for_picture()
        self.run_script("document.querySelector('details.files').open = true")
        self.button("Make").click()
        self.wait_until(lambda: "Save look.vdb" in self.run_script(
            "return Array.from(document.querySelectorAll('.jobs button'), (one) => one.textContent)"), "the file")
        # What the page saves are the bytes that were made.
        read = self.driver.execute_async_script(
            "const done = arguments[0]; import('./page/server.js').then(async ({ server }) => "
            "done(Array.from(new Uint8Array(await (await server.file('look.vdb')).arrayBuffer()))));")
        self.assertEqual(bytes(read), self.path("made/look.vdb").read_bytes())
        self.assertEqual(self.errors(), [])

    def test_the_look_stays_for_another_mesh(self):
        self.choose("s.obj")
        self.wait_for_picture()
        self.run_script("window.explore.store.change((state) => { state.recipe.detail = '0.7'; })")
        self.button("Another mesh").click()
        self.wait_until(lambda: self.finds(".begin button"), "the first screen")
        self.choose("s.obj")
        self.wait_for_picture()
        self.assertEqual(self.run_script("return window.explore.store.state.recipe.detail"), "0.7")

    def test_a_file_that_will_not_do_is_said_and_another_may_follow(self):
        self.write("notes.txt", "hello\n")
        self.write("broken.obj", "v 0 0 0\n")
        for name, words in (("notes.txt", "notes.txt is no mesh that the program reads"), ("broken.obj", "'broken.obj' has no faces")):
            self.choose(name)
            self.wait_until(lambda: words in self.status(), words)
        self.choose("s.obj")
        self.wait_for_picture()

    def test_a_drop_on_the_page_and_the_sample(self):
        self.run_script("""
          const files = new DataTransfer();
          files.items.add(new File(["v 0 0 0\\n"], "broken.obj"));
          document.dispatchEvent(new DragEvent("drop", { dataTransfer: files, cancelable: true }));""")
        self.wait_until(lambda: "has no faces" in self.status(), "the refusal")
        sample = self.driver.execute_async_script(
            "const done = arguments[0]; import('./page/program.js').then(async ({ sampleMesh }) => done(await sampleMesh().text()));")
        self.write("sample.obj", sample)
        said = json.loads(self.ok("info", "sample.obj", "--json", data=True))
        self.assertEqual((said["closed"], said["components"], said["degenerate faces"]), (True, 1, 0))
        self.assertGreater(said["volume"], 0)  # the faces look outwards
        self.button("Take a sample").click()
        self.wait_for_picture()


if __name__ == "__main__":
    browser.main()

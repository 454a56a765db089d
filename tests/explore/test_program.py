#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page that has a program in a worker in place of a server (wasm/), but for the program: a stand-in for the worker passes the
requests on to a server. wasm/test-page is the test of the program itself."""

import http.server
import json
import pathlib
import subprocess
import urllib.parse

import browser
from browser import harness
from server import QUICK, Server
from static_host import StaticHost

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


def host_of(folder, server, made):
    """A host of a folder, without the headers that isolate a page; below asked/ the server, below made/ its files."""
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
            if "/asked/" in self.path:
                return self.pass_on()
            super().do_GET()

        do_POST = do_DELETE = pass_on

        def translate_path(self, path):
            return str(made / pathlib.Path(path).name) if "/made/" in path else super().translate_path(path)

    return StaticHost(folder, handler=Handler)


class ProgramTest(browser.BrowserTest):
    PLACE = ""  # of the page on its host

    def setUp(self):
        super().setUp()
        self.write("s.obj", harness.obj(harness.torus(around=24, across=12)))
        page = self.path("site") / self.PLACE
        subprocess.run([ROOT / "wasm/make-page", page], check=True)
        (page / "worker.js").write_text(WORKER)
        server = Server(self.path("."), "s.obj", *QUICK, "--folder", "made")
        self.addCleanup(server.kill)
        self.host = host_of(self.path("site"), server, self.path("made"))
        self.addCleanup(self.host.close)

    def wait_for_first_screen(self):
        # The host sends no headers: the page's service worker does.
        self.wait_until(lambda: self.run_script("return crossOriginIsolated") and self.finds(".begin button"), "the first screen")

    def open(self, look=""):
        """@param look  the part of the address behind '#'"""
        self.driver.get(self.host.url + self.PLACE + (f"#{look}" if look else ""))
        self.wait_for_first_screen()

    def choose(self, name):
        self.find(".begin input[type=file]").send_keys(str(self.path(name)))

    def status(self):
        return self.find(".begin .status").text

    def wait_for_picture(self):
        self.wait_until(lambda: self.run_script("return Boolean(window.explore && window.explore.scene())"), "a picture")

    def recipe(self):
        return self.run_script("return window.explore.store.state.recipe")

    def said(self):
        return self.find(".line .status").text

    def make(self):
        """By the buttons, as a visitor does it."""
        self.run_script("document.querySelector('details.files').open = true")
        self.button("Make").click()
        self.wait_until(lambda: "Save look.vdb" in self.run_script(
            "return Array.from(document.querySelectorAll('.jobs button'), (one) => one.textContent)"), "the file")


class Program(ProgramTest):
    def setUp(self):
        super().setUp()
        self.open()

    # Promise of browser.md: Without a server: "Drop a mesh on it", and "*Save* below the files that were made hands them to the
    #   browser"
    # Promise of browser.md: Where the host sends no headers, "the page installs a service worker of its own that adds them"
    def test_from_a_mesh_to_a_file(self):
        self.choose("s.obj")
        self.wait_for_picture()
        self.make()
        # What the page saves are the bytes that were made.
        read = self.driver.execute_async_script(
            "const done = arguments[0]; import('./page/server.js').then(async ({ server }) => "
            "done(Array.from(new Uint8Array(await (await server.file('look.vdb')).arrayBuffer()))));")
        self.assertEqual(bytes(read), self.path("made/look.vdb").read_bytes())
        self.assertEqual(self.errors(), [])

    # Promise of browser.md: "The address holds the look, but not the mesh"
    def test_the_look_stays_for_another_mesh(self):
        self.choose("s.obj")
        self.wait_for_picture()
        self.run_script("window.explore.store.change((state) => { state.recipe.detail = '0.7'; })")
        self.button("Another mesh").click()
        self.wait_until(lambda: self.finds(".begin button"), "the first screen")
        self.choose("s.obj")
        self.wait_for_picture()
        self.assertEqual(self.recipe()["detail"], "0.7")

    # Promise: Without a server: "Drop a mesh ..."
    def test_a_file_that_will_not_do_is_said_and_another_may_follow(self):
        self.write("notes.txt", "hello\n")
        self.write("broken.obj", "v 0 0 0\n")
        for name, words in (("notes.txt", "notes.txt is no mesh that the program reads"), ("broken.obj", "'broken.obj' has no faces")):
            self.choose(name)
            self.wait_until(lambda: words in self.status(), words)
        self.choose("s.obj")
        self.wait_for_picture()

    # Promise: Without a server: "Drop a mesh ..."
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


class WrongLinks(ProgramTest):
    """Anybody can write a link."""

    # Looks that cannot be, and what is said of them.
    REFUSED = {
        "a file": ({"mask": "/etc/passwd.vdb"}, "may not read '/etc/passwd.vdb'"),
        "another target": ({"input": "/etc/passwd"}, "may not read '/etc/passwd'"),
        "no option": ({"no-such-option": "1"}, "no-such-option"),
        "no number": ({"detail": "much"}, "'much'"),
        "a script": ({"mask": "<img src=x onerror='window.wasRun = true'>"}, "<img src=x"),
        "too fine": ({"sdf-resolution": "999999999999"}, "use a larger voxel size"),
        "too many": ({"texture-roots": "999999999999"}, "texture-roots"),
    }
    AS_NATIVE = ("no number", "too fine", "too many")  # where the command says the same
    # What is not in the form of an address of the page.
    IGNORED = ("%", "%7B%22recipe%22", "recipe=%FF%FE", "recipe=/etc/passwd", "[]", "null", "%7B%22recipe%22%3A5%7D", "<script>window.wasRun=true</script>",
               urllib.parse.quote('{"recipe": {"__proto__": "x", "Mask": "y", "detail": 7}, "view": {"eye": "x"}, "look": 3}'),
               urllib.parse.quote('{"look": {"options": {"light": 5, "no-such": "1"}, "clip": {"axis": "q"}, "samples": 1e99}}'))

    def look(self, recipe):
        return urllib.parse.quote(json.dumps({"recipe": recipe}))

    def open_look(self, look):
        self.driver.get("about:blank")  # else only the part behind '#' would change
        self.open(look)
        self.choose("s.obj")
        self.wait_for_picture()

    # Promise of browser.md: "a look that cannot be is refused in the program's words, and the first look is shown"
    def test_a_look_that_cannot_be_is_refused_and_the_first_one_is_shown(self):
        for what, (recipe, words) in self.REFUSED.items():
            with self.subTest(what):
                self.open_look(self.look(recipe))
                self.wait_until(lambda: words in self.said(), words)
                self.assertTrue(self.said().endswith("; the first look is shown instead"), self.said())
                self.assertEqual(self.run_script("return window.explore.store.canUndo"), False)
                self.assertEqual(self.recipe(), self.run_script("return window.explore.store.first.recipe"))
                self.assertIsNone(self.run_script("return window.wasRun ?? null"))
                self.assertEqual(self.finds("img[src=x]"), [])
        self.make()  # and the page goes on

    # Promise: "a look that cannot be is refused ..."
    def test_what_is_no_look_is_ignored(self):
        for look in self.IGNORED:
            with self.subTest(look):
                self.open_look(look)
                self.assertEqual(self.said(), "")
                self.assertEqual(set(self.recipe()), {"input", *(word[2:] for word in QUICK[::2])})
                self.assertIsNone(self.run_script("return window.wasRun ?? null"))
        self.assertEqual(self.errors(), [])

    # Promise: "a look that cannot be is refused ..."
    def test_the_words_are_those_of_the_program(self):
        self.open_look(self.look({"detail": "7"}))
        self.wait_until(self.said, "the refusal")
        native = self.run_program("fractal", "s.obj", "--detail", "7", "-o", "out.vdb")
        said = native.stderr.decode().partition("juliavdb: ")[2].strip()
        self.assertTrue(said)
        self.assertEqual(self.said(), f"{said}; the first look is shown instead")


class WrongBrowsers(ProgramTest):
    def before(self, script):
        """Runs a script in each page before the page's own."""
        number = self.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": script})["identifier"]
        self.addCleanup(self.driver.execute_cdp_cmd, "Page.removeScriptToEvaluateOnNewDocument", {"identifier": number})

    # Promise of browser.md: Without WebGL 2, the page "shows the exact picture instead"; without vectors or WebAssembly, "the
    #   first screen says what is missing"
    def test_without_webgl(self):
        """The exact picture stands in for the live one, and files are made."""
        self.before("""
          const whole = HTMLCanvasElement.prototype.getContext;
          HTMLCanvasElement.prototype.getContext = function (kind, ...more) { return kind === "webgl2" ? null : whole.call(this, kind, ...more); };""")
        self.open()
        self.choose("s.obj")
        self.wait_for_picture()
        is_shown = "const image = document.querySelector('img.exact'); return !image.hidden && image.naturalWidth > 10"
        self.wait_until(lambda: self.run_script(is_shown), "the exact picture")
        first = self.run_script("return document.querySelector('img.exact').src")
        self.run_script("window.explore.store.change((state) => { state.recipe.detail = '0.7'; })")
        self.assertIn("This browser has no WebGL 2", self.run_script("return window.explore.stage.why"))
        self.wait_until(lambda: self.run_script(is_shown) and self.run_script("return document.querySelector('img.exact').src") != first,
                        "the picture of the other look")
        self.make()
        self.button("Beside the target").click()
        self.wait_until(lambda: self.run_script(is_shown), "the picture beside which the target would be")
        self.wait_until(lambda: "has no WebGL 2, which the picture of the target needs" in self.said(), "the refusal")
        self.assertEqual(self.errors(), [])

    # Promise: Without WebGL 2, the page ...
    def test_without_vectors(self):
        self.before("WebAssembly.validate = () => false;")
        self.open()
        self.assertIn("This browser has no vector instructions in WebAssembly", self.status())
        self.assertTrue(all(not one.is_enabled() for one in self.finds(".begin button")))

    # Promise: Without WebGL 2, the page ...
    def test_without_web_assembly(self):
        self.before("delete globalThis.WebAssembly;")
        self.open()
        self.assertIn("This browser has no WebAssembly", self.status())

    # Promise of browser.md#when-something-goes-wrong: "Files above 1 GiB are refused by their size", and files that would not fit
    #   into memory "before they are begun"
    def test_a_file_that_no_page_can_hold(self):
        """It is refused by its size alone, before anything of it is read."""
        self.open()
        with open(self.path("many.stl"), "wb") as file:  # 30 million triangles, as a file with a hole
            file.truncate(84 + 50 * 30_000_000)
        self.choose("many.stl")
        self.wait_until(lambda: "many.stl has 1430.5 MB, and a page cannot hold more than 1024.0 MB" in self.status(), "the refusal")
        self.choose("s.obj")
        self.wait_for_picture()

    # Promise: Where the host sends no headers, ...
    def test_the_page_that_was_not_isolated_yet_does_not_come_back(self):
        """A browser keeps a page that was shown whole, and may show that one when its successor is loaded anew."""
        self.before("""
          const register = ServiceWorkerContainer.prototype.register;
          ServiceWorkerContainer.prototype.register = async function (...values) {
            await new Promise((shown) => addEventListener("load", () => setTimeout(shown, 300)));
            return register.apply(this, values);
          };
          addEventListener("pagehide", ({ persisted }) => { if (persisted) sessionStorage.setItem("kept", "yes"); });""")
        self.open()
        self.assertEqual(self.run_script("return sessionStorage.getItem('kept')"), "yes")
        self.driver.refresh()
        self.wait_for_first_screen()

    # Promise of browser.md: "If you close or reload it in the middle, nothing is left"
    def test_a_tab_that_is_closed_while_files_are_made(self):
        self.open()
        self.choose("s.obj")
        self.wait_for_picture()
        self.run_script("document.getElementById('make-resolution').value = 250; document.querySelector('details.files').open = true")
        self.button("Make").click()
        self.wait_until(lambda: self.run_script("return Boolean(document.querySelector('.jobs .running'))"), "the work")
        self.driver.refresh()
        self.wait_for_first_screen()
        self.choose("s.obj")
        self.wait_for_picture()
        self.assertEqual(self.errors(), [])


class BesideAnExportedPage(ProgramTest):
    PLACE = "juliavdb/"

    def setUp(self):
        super().setUp()
        self.ok("explore", "s.obj", *QUICK, "--detail", "0.4", "--export", "site/look.html")

    def open_exported(self):
        self.driver.get(self.host.url + "look.html")
        self.wait_for_picture()

    # Promise: An exported page is one file ...
    def test_the_program_beside_it_makes_files_of_the_look(self):
        self.open_exported()
        self.assertEqual(self.host.asked, [("GET", "/look.html")])  # unasked, it asks for nothing
        self.button("Make files").click()
        self.wait_for_first_screen()
        self.choose("s.obj")
        self.wait_for_picture()
        self.assertEqual(self.recipe()["detail"], "0.4")
        self.make()

    # Promise: An exported page is one file ...
    def test_without_the_program_it_is_said(self):
        self.path("site/juliavdb").rename(self.path("elsewhere"))
        self.open_exported()
        self.button("Make files").click()
        self.wait_until(lambda: "The program is not beside this page" in self.said(), "the refusal")
        self.assertEqual(self.host.asked, [("GET", "/look.html"), ("HEAD", "/juliavdb/worker.js")])
        self.assertIn("/look.html", self.driver.current_url)

    # Promise: An exported page is one file ...
    def test_from_a_file_nothing_is_offered(self):
        self.driver.get(self.path("site/look.html").as_uri())
        self.wait_for_picture()
        self.assertEqual([one.text for one in self.finds("button") if one.text == "Make files"], [])
        self.assertEqual(self.errors(), [])


if __name__ == "__main__":
    browser.main()

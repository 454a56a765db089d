// SPDX-License-Identifier: Apache-2.0
// The page without a server: the program runs in a worker of the page, and the visitor's files stay in its memory.
import { button, element } from "./widgets.js";

// What a target may be called, and the other files that may lie beside it.
const MESHES = /\.(obj|ply|stl|off|glb|gltf|vdb)$/i;
const MOST_BYTES = 1 << 30;

const mebi = (bytes) => `${(bytes / 2 ** 20).toFixed(1)} MB`;

// A closed tube along a trefoil knot, as OBJ: something to begin with.
export function sampleMesh() {
  const along = 160, around = 16, radius = 0.42, lines = [];
  const curve = (t) => [Math.sin(t) + 2 * Math.sin(2 * t), Math.cos(t) - 2 * Math.cos(2 * t), -Math.sin(3 * t)];
  const minus = (a, b) => a.map((value, i) => value - b[i]), unit = (a) => a.map((value) => value / Math.hypot(...a));
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  for (let i = 0; i < along; ++i) {
    const t = 2 * Math.PI * i / along, middle = curve(t), forward = unit(minus(curve(t + 1e-3), curve(t - 1e-3)));
    const side = unit(cross(forward, middle)), up = cross(forward, side);
    for (let j = 0; j < around; ++j) {
      const angle = 2 * Math.PI * j / around;
      const at = middle.map((value, axis) => value + radius * (Math.cos(angle) * side[axis] + Math.sin(angle) * up[axis]));
      lines.push(`v ${at.map((value) => value.toFixed(5)).join(" ")}`);
    }
  }
  const corner = (i, j) => i % along * around + j % around + 1;
  for (let i = 0; i < along; ++i)
    for (let j = 0; j < around; ++j) lines.push(`f ${corner(i, j)} ${corner(i, j + 1)} ${corner(i + 1, j + 1)} ${corner(i + 1, j)}`);
  return new File([lines.join("\n") + "\n"], "knot.obj");
}

// Talks to the worker. ask() is like fetch() (server.js).
export class Program {
  constructor(address) {
    Object.assign(this, { last: 0, waiting: new Map(), onLoading: () => {} });
    this.worker = new Worker(address);
    this.worker.onmessage = ({ data }) => {
      if (data.number === undefined) return this.onLoading(data);
      const asked = this.waiting.get(data.number);
      this.waiting.delete(data.number);
      asked?.resolve(new Response(data.body, { status: data.status, headers: { "Content-Type": data.type } }));
    };
    this.worker.onerror = (event) => {
      event.preventDefault();
      // Exceptions that no text comes with are failed allocations, as far as is known.
      const why = /\[object|abort|memory/i.test(event.message) ? "most likely because its memory ran out" : event.message || "it could not be loaded";
      const error = new Error(`The program has ended: ${why}. Reload the page; the address holds the look.`);
      for (const { reject } of this.waiting.values()) reject(error);
      this.waiting.clear();
      this.broken = error;
    };
  }

  send(message, signal) {
    return new Promise((resolve, reject) => {
      if (this.broken) return reject(this.broken);
      const number = ++this.last;
      this.waiting.set(number, { resolve, reject });
      signal?.addEventListener("abort", () => {
        if (!this.waiting.delete(number)) return;
        this.worker.postMessage({ kind: "drop", number });
        reject(new DOMException("The request was dropped.", "AbortError"));
      });
      this.worker.postMessage({ number, ...message });
    });
  }

  async ask(path, { method = "GET", body, signal } = {}) {
    const [place, query] = path.split("?");
    return this.send({ kind: "ask", method, path: place, name: new URLSearchParams(query).get("name") ?? "", body }, signal);
  }

  async answerOf(message) {
    const response = await this.send(message);
    if (!response.ok) throw new Error((await response.json()).error);
    return response;
  }

  async open(files, recipe) {
    const sent = await Promise.all(files.map(async (file) => ({ name: file.name, bytes: await file.arrayBuffer() })));
    await this.answerOf({ kind: "open", files: sent, recipe });
  }

  async file(name) { return (await this.answerOf({ kind: "read", name })).blob(); }
}

// Why the program cannot run in this browser; "" if it can.
export function obstacle() {
  if (typeof WebAssembly !== "object") return "This browser has no WebAssembly, which the program needs.";
  // A module with one instruction of 128-bit vectors.
  const vectors = new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11]);
  if (!WebAssembly.validate(vectors)) return "This browser has no vector instructions in WebAssembly; a newer one has.";
  if (!globalThis.crossOriginIsolated)
    return "This page is not isolated from other pages, so browsers give it no threads. Its server must send the headers " +
      "Cross-Origin-Opener-Policy: same-origin and Cross-Origin-Embedder-Policy: require-corp.";
  return "";
}

// Shows the first screen, and opens what the visitor chooses. Resolves once a first scene is made.
export function begin(program, app) {
  const pick = element("input", { type: "file", multiple: true, hidden: true, "aria-label": "A mesh" });
  const status = element("p", { class: "status", role: "status", "aria-live": "polite" });
  const say = (text, isError = false) => {
    status.textContent = text;
    status.classList.toggle("error", isError);
  };
  const buttons = [
    button("Choose a mesh", () => pick.click(), { class: "main" }),
    button("Take a sample", () => take([sampleMesh()])),
    button("A Mandelbulb, without a mesh", () => take([])),
  ];
  const screen = element("div", { class: "begin" }, element("h1", {}, "JuliaVDB"),
    element("p", {}, "Drop a mesh here (OBJ, PLY, STL, OFF, GLB, or a VDB level set), and it becomes a fractal of the same shape."),
    element("div", { class: "buttons" }, buttons), status,
    element("p", { class: "note" }, "Everything runs in this page, on this machine. Nothing is sent anywhere."), pick);
  app.replaceChildren(screen);

  let isOpening = false, done = null;
  async function take(files) {
    if (isOpening) return;
    const mesh = files.find((file) => MESHES.test(file.name)), size = files.reduce((sum, file) => sum + file.size, 0);
    if (files.length > 0 && !mesh) return say(`${files[0].name} is no mesh that the program reads: OBJ, PLY, STL, OFF, GLB, glTF or VDB.`, true);
    if (size > MOST_BYTES) return say(`${mesh.name} has ${mebi(size)}, and a page cannot hold more than ${mebi(MOST_BYTES)}; the program itself can.`, true);
    isOpening = true;
    for (const one of buttons) one.disabled = true;
    try {
      say("The target is being prepared.");
      program.onLoading = ({ loaded, total }) => say(`The program is being loaded: ${mebi(loaded)}${total ? ` of ${mebi(total)}` : ""}.`);
      await program.open(files, mesh ? { input: mesh.name } : { map: "mandelbulb" });
      document.removeEventListener("drop", dropped);
      done();
    } catch (error) {
      say(error.message, true);
    } finally {
      isOpening = false;
      for (const one of buttons) one.disabled = false;
    }
  }
  const dropped = (event) => {
    event.preventDefault();
    take([...event.dataTransfer.files]);
  };
  document.addEventListener("drop", dropped);
  document.addEventListener("dragover", (event) => event.preventDefault());
  pick.addEventListener("change", () => {
    const files = [...pick.files];
    pick.value = "";  // the same file may be chosen again
    take(files);
  });

  const reason = obstacle();
  if (reason) {
    say(reason, true);
    for (const one of buttons) one.disabled = true;
  }
  return new Promise((resolve) => { done = resolve; });
}

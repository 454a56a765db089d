// SPDX-License-Identifier: Apache-2.0
// The requests of the page; vdbtools/explore/explore_server.h lists them. Addresses are relative, because the page's
// own address contains the key.

// Where the requests go: to the server, or to the program in a worker (program.js).
let program = null;
const answer = (path, options) => program ? program.ask(path, options) : fetch(path, { cache: "no-store", ...options });

async function failure(response) {
  let text = `${response.status} ${response.statusText}`;
  try {
    text = (await response.json()).error ?? text;
  } catch { /* no JSON: the status says it */ }
  return Object.assign(new Error(text), { status: response.status });
}

async function request(path, options = {}) {
  let response;
  try {
    response = await answer(path, options);
  } catch (error) {
    if (error.name === "AbortError" || program) throw error;
    throw new Error("The server does not answer. Is 'juliavdb explore' still running?");
  }
  if (!response.ok) throw await failure(response);
  return response;
}

const post = (path, body, signal) => request(path, {
  method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body), signal,
});

export const server = {
  // Lets a program in a worker answer instead.
  use: (other) => { program = other; },
  // Whether the files that are made lie in the page's memory, from which the browser saves them.
  get keepsFiles() { return program !== null; },
  file: (name) => program.file(name),
  start: async () => (await request("start")).json(),
  scene: async (recipe, wait, signal, side) => (await post("scene", { recipe, wait, side }, signal)).json(),
  volume: async (id, signal) => new Uint16Array(await (await request(`volume/${id}`, { signal })).arrayBuffer()),
  target: async () => (await request("target")).arrayBuffer(),
  look: async (look) => (await post("look", { look })).json(),
  colouring: async (recipe, signal) => (await post("colouring", { recipe }, signal)).json(),
  advice: async (body, signal) => (await post("advice", body, signal)).json(),
  made: async (body, signal) => (await post("made", body, signal)).blob(),
  picture: async (body, signal) => (await post("picture", body, signal)).blob(),
  make: async (body) => (await post("make", body)).json(),
  jobs: async () => (await request("jobs")).json(),
  cancel: async (job) => { await request(`jobs/${job}`, { method: "DELETE" }); },
  recipe: async (name, bytes) => (await request(`recipe?name=${encodeURIComponent(name)}`, {
    method: "POST", headers: { "Content-Type": "application/octet-stream" }, body: bytes,
  })).json(),
  command: async (body) => (await post("command", body)).json(),
  sequence: async (body) => (await post("sequence", body)).json(),
  exported: async (recipe, look) => (await post("export", { recipe, look })).blob(),
};

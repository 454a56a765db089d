// SPDX-License-Identifier: Apache-2.0
// The worker of the page for browsers: loads the program, keeps the visitor's files in memory, and passes requests on.
// Messages from the page are {number, kind, ...}; answers are {number, status, type, body}, or {loaded, total} meanwhile.
/* global importScripts, juliavdbProgram */
importScripts("juliavdb_page.js");

const FOLDER = "/visitor";

// The module's bytes, with what has been read of them meanwhile.
async function moduleBytes() {
  const response = await fetch("juliavdb_page.wasm");
  if (!response.ok) throw new Error(`the program cannot be loaded: ${response.status} ${response.statusText}`);
  const total = Number(response.headers.get("Content-Length")) || 0, parts = [], reader = response.body.getReader();
  for (let loaded = 0; ;) {
    const { done, value } = await reader.read();
    if (done) break;
    parts.push(value);
    loaded += value.length;
    postMessage({ loaded, total: response.headers.get("Content-Encoding") ? 0 : total });
  }
  return new Blob(parts).arrayBuffer();
}

const program = moduleBytes().then((wasmBinary) => juliavdbProgram({ wasmBinary, mainScriptUrlOrBlob: "juliavdb_page.js" })).then((module) => {
  module.FS.mkdir(FOLDER);
  module.FS.chdir(FOLDER);
  return module;
});

function withTexts(module, texts, use) {
  const pointers = texts.map((text) => module.stringToNewUTF8(text));
  try {
    use(...pointers);
  } finally {
    for (const pointer of pointers) module._free(pointer);
  }
}

// What each kind of message does; the answer comes later unless it is returned.
const kinds = {
  open(module, { number, files, recipe }) {
    for (const { name, bytes } of files) module.FS.writeFile(`${FOLDER}/${name}`, new Uint8Array(bytes));
    withTexts(module, [JSON.stringify(recipe)], (text) => module._juliavdb_open(number, text));
  },
  ask(module, { number, method, path, name, body }) {
    const bytes = typeof body === "string" ? new TextEncoder().encode(body) : new Uint8Array(body ?? 0);
    const place = module._malloc(Math.max(1, bytes.length));
    if (!place) throw new Error("there is not enough memory left for this request");
    module.writeArrayToMemory(bytes, place);
    withTexts(module, [method, path, name], (...texts) => module._juliavdb_ask(number, ...texts, place, bytes.length));
    module._free(place);
  },
  drop(module, { number }) { module._juliavdb_drop(number); },
  read(module, { name }) {
    return { status: 200, type: "application/octet-stream", body: module.FS.readFile(`${FOLDER}/${name}`).slice().buffer };
  },
};

onmessage = async ({ data }) => {
  try {
    const answer = kinds[data.kind](await program, data);
    if (answer) postMessage({ number: data.number, ...answer }, [answer.body]);
  } catch (error) {
    // An exception of the program that gets here is a failed allocation, as far as is known.
    const text = error instanceof WebAssembly.Exception
      ? "The program cannot go on, most likely because its memory ran out. Reload the page; the address holds the look." : error.message ?? String(error);
    const body = new TextEncoder().encode(JSON.stringify({ error: text })).buffer;
    postMessage({ number: data.number, status: 500, type: "application/json", body }, [body]);
  }
};

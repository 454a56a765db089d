// SPDX-License-Identifier: Apache-2.0
// From a look to files: makes them, keeps their history, shows the command, and reads and writes recipes.
import { server } from "./server.js";
import { checkedLook } from "./store.js";
import { button, element, group } from "./widgets.js";

const PICTURE = 480;  // width in pixels of a picture of what was made

function download(blob, name) {
  const link = element("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

const timeText = (seconds) => seconds < 90 ? `${Math.round(seconds)} s` : `${Math.round(seconds / 60)} min`;

// page: {store, options, start, say(text, isError), recipe(): what is to be made, resized}
export function makeFiles(page) {
  const { store, start, say } = page;
  const attempt = (work) => async () => {
    try {
      await work();
    } catch (error) {
      say(error.message, true);
    }
  };
  const name = element("input", { type: "text", value: "look", id: "make-name", spellcheck: "false", autocomplete: "off" });
  const usual = page.options.usual("resolution", start.recipe);
  const resolution = element("input", { type: "number", id: "make-resolution", min: 8, step: 1, list: "make-resolutions",
    value: start.recipe.resolution ?? usual });
  const formats = start.formats.map((format) => ({
    format, box: element("input", { type: "checkbox", id: `make-${format}`, checked: format === "vdb" }),
  }));
  const overwrite = element("input", { type: "checkbox", id: "make-overwrite" });
  const command = element("textarea", { readonly: true, rows: 3, "aria-label": "The command", hidden: true });
  const list = element("ul", { class: "jobs", "aria-label": "What was made" });
  const request = () => ({
    recipe: store.state.recipe, name: name.value.trim(), formats: formats.filter((one) => one.box.checked).map((one) => one.format),
    resolution: String(Math.max(8, Math.round(Number(resolution.value) || Number(usual)))),
  });

  page.named = () => ({ name: request().name, resolution: request().resolution });

  let timer = 0;
  async function poll() {
    clearTimeout(timer);
    let jobs = [];
    try {
      jobs = await server.jobs();
    } catch (error) {
      return say(error.message, true);
    }
    jobs.slice().reverse().map(lineOf).forEach((line, i) => {
      if (list.children[i] !== line) list.insertBefore(line, list.children[i] ?? null);
    });
    while (list.children.length > jobs.length) list.lastElementChild.remove();
    if (jobs.some((job) => ["queued", "running"].includes(job.state))) timer = setTimeout(poll, 700);
  }

  // The line of a job stays the same element while the job is queued or running: a new one would take the focus from
  // its button, and interrupt a click.
  const lines = new Map(), asked = new Map();
  function lineOf(job) {
    const isOpen = job.state === "queued" || job.state === "running";
    const before = lines.get(job.job);
    const line = before && before.isOpen === isOpen ? before : { isOpen, ...newLine(job, isOpen) };
    if (before && before !== line) before.element.replaceWith(line.element);
    lines.set(job.job, line);
    const left = job.left === null || job.left === undefined ? "" : `, ${timeText(job.left)} left`;
    const what = job.state === "running" ? `${job.phase || "beginning"}${left}` : job.state === "failed" ? job.error
      : job.state === "done" ? [job.files.join(", "), ...job.warnings.map((text) => `warning: ${text}`)].join("; ") : job.state;
    line.element.className = job.state;
    line.what.textContent = what;
    // A file that this page has made is shown in the view and the light at the time of the request.
    if (job.state === "done" && asked.has(job.job)) {
      const body = asked.get(job.job);
      asked.delete(job.job);
      showIn(line, job, body);
    }
    if (line.progress) {
      line.progress.hidden = job.state !== "running";
      line.progress.value = job.share ?? 0;
    }
    return line.element;
  }

  async function showIn(line, job, body) {
    try {
      const image = element("img", { class: "made", alt: `${job.name}, as it was made`, src: URL.createObjectURL(await server.made({ job: job.job, ...body })) });
      line.element.append(image);
    } catch (error) {
      line.element.append(element("span", { class: "note error" }, error.message));
    }
  }

  function newLine(job, isOpen) {
    const what = element("span");
    const progress = isOpen ? element("progress", { max: 1, value: 0, "aria-label": `${job.name} is made` }) : null;
    const made = element("li", {}, element("strong", {}, job.name), " ", what, progress,
      isOpen ? button("Cancel", attempt(async () => {
        await server.cancel(job.job);
        await poll();
      }), { "aria-label": `Cancel ${job.name}` }) : button("Go there", () => store.change((state) => { state.recipe = { ...job.recipe }; }),
        { "aria-label": `Go to the look of ${job.name}` }),
      job.state === "done" && server.keepsFiles ? job.files.map((file) =>
        [" ", button(`Save ${file}`, attempt(async () => download(await server.file(file), file)))]).flat() : null,
      job.state === "done" ? [" ", button("Show", () => page.showMade(job), { "aria-label": `Show ${job.name} as it was made`, title: "By the camera at hand" })] : null);
    return { element: made, what, progress };
  }

  const pick = element("input", { type: "file", hidden: true, "aria-label": "A file with a recipe" });
  pick.addEventListener("change", () => {
    if (pick.files[0]) load(pick.files[0]);
    pick.value = "";
  });

  // The recipe of a file: one that the page saved, an exported page, or anything that the program made.
  async function load(file) {
    await attempt(async () => {
      if (/\.(json|html)$/i.test(file.name)) {
        const read = savedLook(await file.text());
        if (read) {
          store.change((state) => {
            const { input } = state.recipe;
            state.recipe = { ...read.recipe };
            if (input) state.recipe.input = input;
            // An exported page has a camera in addition to its look.
            const look = read.look?.look ?? read.look;
            if (look && typeof look === "object") state.look = checkedLook(look);
          });
          return say(`The recipe of ${file.name}.`);
        }
      }
      // Recipes are at the beginning of files.
      const { recipe, note } = await server.recipe(file.name, await file.slice(0, 64 << 20).arrayBuffer());
      store.change((state) => { state.recipe = { ...recipe }; });
      say(note ? `${file.name}: ${note}.` : `The recipe of ${file.name}.`);
    })();
  }

  async function copy(text) {
    command.value = text;
    command.hidden = false;
    await navigator.clipboard?.writeText(text).then(() => say("The command was copied."), () => command.select());
  }

  const field = (label, input) => element("div", { class: "control" }, element("label", { for: input.id }, label), input);
  const whole = group("Make files, and recipes",
    field("Name", name), field("Resolution", resolution),
    element("datalist", { id: "make-resolutions" }, start.resolutions.map((value) => element("option", { value }))),
    element("fieldset", { class: "formats" }, element("legend", {}, "Formats"),
      formats.map(({ format, box }) => element("label", { for: box.id }, box, format))),
    element("label", { class: "control" }, overwrite, "Replace files of that name"),
    element("div", { class: "buttons" },
      button("Make", attempt(async () => {
        const body = store.state.view ? page.pictureBody(store.state, PICTURE) : null;
        const { job } = await server.make({ ...request(), overwrite: overwrite.checked });
        if (body) asked.set(job, body);
        say(server.keepsFiles ? "The files are kept in this page until they are saved." : `In ${start.folder}.`);
        await poll();
      }), { class: "main" }),
      button("Copy command", attempt(async () => {
        await copy((await server.command(request())).command);
      })),
      button("Copy picture command", attempt(async () => {
        await copy((await server.command({ ...request(), ...page.pictureBody(store.state) })).picture);
      }), { title: "Of the exact picture by this camera, in this light" })),
    command,
    element("div", { class: "buttons" },
      button("Save recipe", () => download(new Blob([JSON.stringify({ command: "fractal", version: start.version, ...store.state }, null, 1)],
        { type: "application/json" }), `${name.value.trim() || "look"}.json`)),
      button("Load recipe", () => pick.click(), { title: "Or drop a file on the page" }),
      button("Export page", attempt(async () => {
        say("The page is being made.");
        download(await server.exported(store.state.recipe, { view: store.state.view, look: store.state.look }), `${name.value.trim() || "look"}.html`);
        say("The page was made.");
      }))),
    pick, list);
  whole.classList.add("files");
  whole.open = false;
  poll();
  return { element: whole, load };
}

// The recipe in a file that this page saved; null for any other file.
export function savedLook(content) {
  const part = /<script type="application\/json" id="exported">([\s\S]*?)<\/script>/.exec(content)?.[1] ?? content;
  try {
    const read = JSON.parse(part), { recipe } = read;
    const isRecipe = recipe && typeof recipe === "object" && Object.values(recipe).every((value) => typeof value === "string");
    return isRecipe ? read : null;
  } catch {
    return null;
  }
}

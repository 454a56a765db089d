// SPDX-License-Identifier: Apache-2.0
// The page of `juliavdb explore`, and the page that it exports: puts the parts together.
import { attachCamera, turnedView, viewAround } from "./camera.js";
import { Choices } from "./choices.js";
import { Colourings } from "./colours.js";
import { makeControls, Options } from "./controls.js";
import { makeFiles } from "./files.js";
import { KeptLooks } from "./kept.js";
import { KeyStrip } from "./keys.js";
import { Lighting } from "./lighting.js";
import { cameraFrame, clipPlace, GRADIENTS, Renderer } from "./renderer.js";
import { bytesOfBase64, liveValues, makeScene } from "./scene.js";
import { server } from "./server.js";
import { Stage } from "./stage.js";
import { checkedLook, hashOf, stateOfHash, Store, usualLook } from "./store.js";
import { makeStrip } from "./strip.js";
import { TargetView } from "./target.js";
import { Thumbnails } from "./thumbnails.js";
import { Variations } from "./variations.js";
import { button, element } from "./widgets.js";

const WHOLE = 256;  // nodes along an axis
const SCENES_KEPT = 40, VOLUMES_KEPT = 5, WAIT = 150;  // milliseconds after the last movement of a slider

const TURN = 12000;  // milliseconds of a turn

// Where the program may lie beside an exported page (wasm/make-page).
const BESIDE = "juliavdb/";

const BACK = "Any change goes back to the live one.";

// The latest scenes. isUsed(scene): the scene must be kept; forget(scene) frees its data on the GPU.
class Scenes {
  constructor(isUsed, forget) {
    Object.assign(this, { isUsed, forget, kept: new Map() });
  }

  // Identifies a scene; colours do not belong to it.
  key(recipe) { return JSON.stringify(Object.entries(recipe).filter(([name]) => !name.startsWith("colour")).sort()); }

  // side: of the volume, if fewer nodes suffice
  async get(recipe, wait, signal, side = WHOLE) {
    const whole = this.key(recipe), key = side === WHOLE ? whole : `${side} ${whole}`, known = this.kept.get(whole) ?? this.kept.get(key);
    if (known) return known;
    const description = await server.scene(recipe, wait, signal, side), { exponent, grain } = description;
    const has = [...this.kept.values()].find((scene) => exponent && scene.exponent?.id === exponent.id);
    const hasGrain = [...this.kept.values()].find((scene) => grain && scene.grain?.id === grain.id);
    const scene = makeScene(description, exponent ? has?.volume ?? await server.volume(exponent.id, signal) : null,
      grain ? hasGrain?.grainVolume ?? await server.volume(grain.id, signal) : null, recipe);
    this.kept.set(key, scene);
    this.shrink(scene);
    return scene;
  }

  // Volumes take most of the memory.
  shrink(latest) {
    const volumes = () => Math.max(...["exponent", "grain"].map((name) => new Set([...this.kept.values()].map((scene) => scene[name]?.id)).size));
    for (const [key, scene] of [...this.kept]) {
      if (this.kept.size <= SCENES_KEPT && volumes() <= VOLUMES_KEPT) return;
      if (scene === latest || this.isUsed(scene)) continue;
      this.forget(scene);
      this.kept.delete(key);
    }
  }
}

async function exportedData() {
  const data = document.getElementById("exported");
  if (!data) return null;
  const start = JSON.parse(data.textContent), bytes = bytesOfBase64(document.getElementById("exported-volume").textContent);
  let volume = null, grainVolume = null;
  if (start.scene.exponent) {
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    const [x, y, z] = start.scene.exponent.dims, both = new Uint16Array(await new Response(stream).arrayBuffer());
    volume = both.subarray(0, x * y * z);
    grainVolume = start.scene.grain ? both.subarray(x * y * z) : null;
  }
  return { start, scene: makeScene(start.scene, volume, grainVolume, start.recipe) };
}

function buildPage(parts) {
  const app = document.getElementById("app");
  app.replaceChildren(
    element("div", { class: "toolbar", role: "toolbar", "aria-label": "Page" }, element("h1", {}, parts.title), ...parts.tools),
    element("div", { class: "stage" },
      element("div", { class: "views" }, element("div", { class: "view" }, parts.canvas, parts.exact), parts.targetBox),
      element("div", { class: "line" }, parts.status, parts.progress), parts.strip, ...parts.keys ? [parts.keys] : [], parts.choices),
    element("div", { class: "panel" }, ...parts.panel));
}

// A page whose index.html names a worker has no server.
async function openProgram() {
  const worker = document.querySelector("meta[name=juliavdb-worker]")?.content;
  if (!worker) return;
  const { begin, Program } = await import("./program.js"), program = new Program(worker);
  await begin(program, document.getElementById("app"));
  server.use(program);
}

async function run() {
  await openProgram();
  const exported = await exportedData(), start = exported?.start ?? await server.start(), isExported = Boolean(exported);
  const options = new Options(start);
  const first = { recipe: start.recipe ?? {}, view: null, look: usualLook(), compare: false };
  if (isExported && start.look) {
    first.look = checkedLook(start.look.look ?? {});
    first.view = start.look.view ?? null;
  }
  const store = new Store(first, stateOfHash(location.hash, first));

  const canvas = element("canvas", { tabindex: 0, role: "application", id: "picture", "aria-label":
    "The fractal. Drag to turn it, with Shift to move it; the wheel comes nearer. Arrow keys turn, plus and minus come nearer, Home goes back." });
  const exact = element("img", { class: "exact", alt: "The exact picture", hidden: true });
  const targetCanvas = element("canvas", { role: "img", "aria-label": "The target" });
  const targetBox = element("div", { class: "view target", hidden: true }, targetCanvas);
  const status = element("span", { class: "status", role: "status", "aria-live": "polite" });
  const progress = element("progress", { max: 1, value: 0, "aria-label": "How fine the picture is" });

  let scene = exported?.scene ?? null, said = "", targetView = null, dragsOrigin = false;
  const say = (text, isError = false) => {
    said = text;
    status.textContent = text;
    status.classList.toggle("error", isError);
  };
  let renderer = null, idle = "", why = "";
  try {
    renderer = new Renderer(canvas);
  } catch (error) {
    if (isExported) throw error;
    why = error.message;
    idle = `${why} The exact picture takes its place.`;
  }
  const stage = new Stage(canvas, renderer, {
    why,
    onState: (state, share) => { progress.value = share; },
    onError: (error) => say(`${error.message} The exact picture shows it.`, true),
  });
  const scenes = new Scenes((one) => one === scene, (one) => renderer?.forget(one));

  const lighting = new Lighting(start, first.look.options), colourings = new Colourings(start, (recipe) => scenes.key(recipe));
  const shotOf = (which, state) => ({
    scene: which, live: liveValues(which, state.recipe), view: state.view ?? viewAround(which.frame, {}, stage.aspect),
    look: { ...state.look, light: lighting.numbersOf(state.look.options), colouring: colourings.of(which, state.recipe) },
  });
  const draw = (isMoving) => {
    if (!scene) return;
    stage.draw(shotOf(scene, store.state), isMoving);
    if (store.state.compare && targetView && store.state.view) targetView.draw(store.state.view, lighting.numbersOf(store.state.look.options));
  };
  // The texts of the light and the colours that the server has to parse. If the numbers change, the picture is drawn
  // again.
  let reading = null;
  async function readLook() {
    reading?.abort();
    const mine = reading = new AbortController(), { state } = store, shown = scene;
    const read = async (about, work) => {
      try {
        const isNew = await work();
        controls.tell(about, "");
        return isNew;
      } catch (error) {
        if (mine === reading && error.name !== "AbortError" && error.status !== 409) controls.tell(about, error.message);
        return false;
      }
    };
    const news = await Promise.all([read("look", () => lighting.read(state.look.options)),
      read("colour", () => shown ? colourings.read(shown, state.recipe, mine.signal) : false)]);
    if (mine !== reading) return;
    reading = null;
    if (!news.some(Boolean)) return;
    controls.update(store.state);
    draw(false);
  }

  const page = {
    store, options, start, first, isExported, stage, shotOf, lighting, colourings, gradients: start.gradients ?? Object.keys(GRADIENTS), say, scene: () => scene,
    sceneFor: (recipe, side, signal) => scenes.get(recipe, true, signal, side),
    dragOrigin: (on) => {
      dragsOrigin = on;
      page.onDragOrigin?.(on);
      if (on) say("Drag in the picture: the shape stays and the texture moves through it.");
    },
  };

  page.variations = new Variations(page);
  page.kept = new KeptLooks(page);
  const choices = page.choices = new Choices(page);
  page.keys = isExported ? null : new KeyStrip(page);

  // ---- scenes ----

  let timer = 0, asking = null, askedFor = "", shownOf = scene ? scenes.key(scene.recipe) : "";
  const frameScene = () => {
    if (store.state.view && (store.state.view.of ?? scene.map) === scene.map) return;
    store.state.view = { ...viewAround(scene.frame, {}, stage.aspect), of: scene.map };
    store.settle();
  };
  async function ask() {
    const recipe = { ...store.state.recipe }, key = scenes.key(recipe);
    if (asking && askedFor === key) return;
    asking?.abort();
    thumbnails?.giveWay();
    const mine = asking = new AbortController();
    askedFor = key;
    say(scene ? "The scene is being made." : "The target is being prepared.");
    try {
      const made = await scenes.get(recipe, false, mine.signal);
      if (mine !== asking) return;
      scene = made;
      shownOf = key;
      frameScene();
      if (said === "The scene is being made." || said === "The target is being prepared.") say(idle);
      controls.update(store.state);
      strip.update(store.state);
      controls.tell("scene", "");
      draw(false);
      readLook();
      if (!renderer && !exposing && exact.hidden) showExact();
    } catch (error) {
      if (mine !== asking || error.name === "AbortError" || error.status === 409) return;
      say(error.message, true);
      controls.tell("scene", error.message);
    } finally {
      if (mine === asking) asking = null;
    }
  }
  const askLater = (isMoving) => {
    clearTimeout(timer);
    if (isExported || !scene) return;
    if (scenes.key(store.state.recipe) === shownOf && !asking) {
      if (status.classList.contains("error")) say("");
      controls.tell("scene", "");
      return;
    }
    timer = setTimeout(ask, isMoving ? WAIT : 20);
  };

  // ---- the program's own pictures ----

  let exposing = null, exposed = "";
  const hideExact = () => {
    exposing?.abort();
    exposing = null;
    if (exposed && said === exposed) say(idle);
    exposed = "";
    exact.hidden = true;
    for (const one of [exactButton, meshButton]) one.setAttribute("aria-pressed", "false");
  };
  const tellOfExact = (text) => say(exposed = text);
  // The camera, the light and the size of the live picture. most: the maximum width in pixels
  const pictureBody = (state, most = canvas.width) => {
    const { eye, lookAt, up, fov } = state.view, shrink = Math.min(1, most / canvas.width);
    return { view: { eye, lookAt, up, fov }, look: state.look.options, samples: "4",
      width: Math.max(16, Math.round(canvas.width * shrink)), height: Math.max(16, Math.round(canvas.height * shrink)) };
  };
  // Shows one of the program's pictures over the live one, until something changes. ask(state, signal) gives {picture,
  // words}.
  async function showOver(pressed, begun, ask) {
    const isShown = pressed?.getAttribute("aria-pressed") === "true";
    hideExact();
    if (isShown || !store.state.view) return;
    pressed?.setAttribute("aria-pressed", "true");
    const mine = exposing = new AbortController();
    tellOfExact(begun);
    try {
      const { picture, words } = await ask(store.state, mine.signal);
      if (mine !== exposing) return;
      URL.revokeObjectURL(exact.src);
      exact.src = URL.createObjectURL(picture);
      await exact.decode();
      exact.hidden = false;
      if (!status.classList.contains("error")) tellOfExact(`${words} ${BACK}`);  // an error that came meanwhile stays to be read
    } catch (error) {
      if (mine !== exposing || error.name === "AbortError") return;
      hideExact();
      say(error.message, true);
    } finally {
      if (mine === exposing) exposing = null;
    }
  }
  // The exact renderer cuts at the faces of a box.
  const cutRecipe = ({ recipe, look }) => {
    if (!look.clip.axis) return recipe;
    const { centre, scale } = scene.space, axis = { x: 0, y: 1, z: 2 }[look.clip.axis];
    const world = (x) => x.map((value, i) => value * scale + centre[i]);
    const min = world(scene.region.min), max = world(scene.region.max), at = clipPlace(look.clip, scene) * scale + centre[axis];
    (look.clip.flip ? min : max)[axis] = at;
    return { ...recipe, box: [...min, ...max].join(",") };
  };
  const showExact = () => showOver(exactButton, "The exact picture is being made.", async (state, signal) => ({
    picture: await server.picture({ recipe: cutRecipe(state), ...pictureBody(state) }, signal), words: "This is the exact picture.",
  }));
  // The mesh that Make would make, and what the picture shows finer than it.
  const showMesh = () => {
    const { resolution } = page.named();
    return showOver(meshButton, `The mesh at resolution ${resolution} is being made.`, async ({ recipe, ...state }, signal) => {
      const picture = await server.picture({ recipe, resolution, mesh: true, ...pictureBody(state) }, signal);
      const { finer } = await server.advice({ recipe, resolution }, signal);
      return { picture, words: `This is the mesh at resolution ${resolution}${finer ? `: ${finer}` : ""}.` };
    });
  };
  page.showMade = ({ job, name }) => showOver(null, `The picture of ${name} is being made.`, async (state, signal) => ({
    picture: await server.made({ job, ...pictureBody(state) }, signal), words: `This is ${name}, as it was made.`,
  }));
  page.pictureBody = pictureBody;

  // ---- the parts ----

  const undo = button("Undo", () => store.go(-1), { title: "Ctrl+Z" }), redo = button("Redo", () => store.go(1), { title: "Ctrl+Y" });
  const compare = button("Beside the target", () => store.change((state) => { state.compare = !state.compare; }), { "aria-pressed": "false" });
  const exactButton = button("Exact picture", showExact, { "aria-pressed": "false", title: "The set itself, by the program's renderer" });
  const meshButton = button("Mesh preview", showMesh, { "aria-pressed": "false", title: "The mesh that Make makes, at its resolution" });
  const reset = () => {
    if (scene) store.change((state) => { state.view = { ...viewAround(scene.frame, {}, stage.aspect), of: scene.map }; });
  };
  // Turns the camera about its look-at point until the user does something else.
  let turning = 0;
  const turntable = button("Turntable", () => {
    if (turning) return stopTurning();
    turntable.setAttribute("aria-pressed", "true");
    let before = performance.now();
    const step = (now) => {
      turning = requestAnimationFrame(step);
      if (stage.isDrawing || !store.state.view) return;
      const view = turnedView(store.state.view, Math.min(500, Math.max(0, now - before)) / TURN * 360, 0);
      before = now;
      isTurn = true;
      store.change((state) => { state.view = view; }, true);
      isTurn = false;
    };
    turning = requestAnimationFrame(step);
  }, { "aria-pressed": "false" });
  let isTurn = false;
  const stopTurning = () => {
    if (!turning) return;
    cancelAnimationFrame(turning);
    turning = 0;
    turntable.setAttribute("aria-pressed", "false");
    store.change(() => {});
  };
  const frameButton = button("Whole set", reset, { title: "Home" });
  const savePicture = button("Save picture", () => {
    const image = stage.image();
    if (!image) return;
    const copy = element("canvas", { width: image.width, height: image.height });
    copy.getContext("2d").putImageData(image, 0, 0);
    copy.toBlob((blob) => {
      const link = element("a", { href: URL.createObjectURL(blob), download: "look.png" });
      link.click();
    });
  });
  const controls = makeControls(page), strip = makeStrip(page), files = isExported ? null : makeFiles(page);
  page.isBusy = () => Boolean(asking) || Boolean(exposing) || choices.isWorking;
  const thumbnails = page.tiles && start.target ? new Thumbnails(page, page.tiles) : null;
  // From an exported page to the program beside it, with the look. Only this asks for anything.
  const goToProgram = async () => {
    const { input, ...recipe } = store.state.recipe;
    const isThere = await fetch(`${BESIDE}worker.js`, { method: "HEAD" }).then((answer) => answer.ok, () => false);
    if (!isThere) return say(`The program is not beside this page: its files would have to lie in the folder '${BESIDE.slice(0, -1)}' next to it.`, true);
    location.href = `${BESIDE}index.html${hashOf({ ...store.state, recipe, view: null, compare: false }, { recipe: {} })}`;
  };
  const canAsk = isExported && /^https?:$/.test(location.protocol);
  const parts = {
    canvas, exact, targetBox, status, progress, strip: strip.element, keys: page.keys?.element ?? null, choices: choices.element,
    title: isExported ? "A look of JuliaVDB" : start.target ? start.target.name + (start.target.atRest ? ", at rest" : "") : "JuliaVDB",
    tools: [...(server.keepsFiles ? [button("Another mesh", () => location.reload(), { title: "The look stays" })] : []),
      undo, redo, frameButton, turntable, savePicture, ...(canAsk ? [button("Make files", goToProgram, { title: "With this look, of a mesh of your own" })] : []),
      ...(isExported ? [] : [exactButton, meshButton, ...(start.target ? [compare] : [])])],
    panel: files ? [controls.element, files.element] : [exportNote(scene, start), controls.element],
  };
  buildPage(parts);

  async function showTarget(on) {
    targetBox.hidden = !on;
    compare.setAttribute("aria-pressed", String(on));
    if (!on || !start.target) return;
    try {
      targetView ??= new TargetView(targetCanvas, await server.target(), start.target);
      if (store.state.view) targetView.draw(store.state.view, lighting.numbersOf(store.state.look.options));
    } catch (error) {
      say(error.message, true);
    }
  }

  store.listen((state, isMoving) => {
    if (turning && !isTurn) return stopTurning();  // which updates again
    choices.close();
    hideExact();
    controls.update(state);
    if (!isMoving) strip.update(state);
    undo.disabled = !store.canUndo;
    redo.disabled = !store.canRedo;
    if (targetBox.hidden === state.compare) showTarget(state.compare);
    draw(isMoving);
    askLater(isMoving);
    if (!isMoving) readLook();
    if (!renderer && !isMoving && scene) showExact();
  });
  const setView = (view, isMoving) => store.change((state) => { state.view = view; }, isMoving);
  attachCamera(canvas, {
    get: () => store.state.view, change: (view, isMoving) => { if (view) setView(view, isMoving); }, reset,
    dragged: (right, up) => {
      if (!dragsOrigin || !scene) return false;
      const { view, recipe } = store.state, frame = cameraFrame(view), distance = Math.hypot(...view.eye.map((value, i) => value - view.lookAt[i]));
      const height = 2 * frame.tangent * distance / scene.space.scale;
      const shift = (recipe["origin-shift"] ?? "0,0,0").split(",").map((value, i) =>
        Number((Number(value) + height * (right * frame.right[i] + up * frame.up[i])).toFixed(4)));
      store.change((state) => options.set(state.recipe, "origin-shift", shift.join(",")), true);
      return true;
    },
  });
  document.addEventListener("keydown", (event) => {
    if (event.target.matches?.("input:not([type=range]):not([type=checkbox]), textarea")) return;
    if (!(event.ctrlKey || event.metaKey)) return;
    const key = event.key.toLowerCase();
    if (key !== "z" && key !== "y") return;
    event.preventDefault();
    store.go(key === "y" || event.shiftKey ? 1 : -1);
  });
  document.addEventListener("dragover", (event) => event.preventDefault());
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    if (files && event.dataTransfer.files[0]) files.load(event.dataTransfer.files[0]);
  });
  window.addEventListener("hashchange", () => {
    const state = stateOfHash(location.hash, first);
    if (state) store.change((now) => Object.assign(now, state));
  });
  new ResizeObserver(() => {
    if (!stage.fit()) return;
    draw(false);
  }).observe(canvas);

  canvas.addEventListener("webglcontextlost", () => say("The graphics were lost. Reload the page; the address holds the look.", true));

  stage.fit();
  if (scene) frameScene();
  store.tell(false);
  if (!scene) await ask();
  if (!scene && scenes.key(store.state.recipe) !== scenes.key(first.recipe)) {
    // The address has a look that cannot be.
    const refusal = said;
    Object.assign(store.state, structuredClone(first));
    store.settle();
    store.tell(false);
    await ask();
    if (scene) say(`${refusal}; the first look is shown instead`, true);
  }
  thumbnails?.make();
  // For tests, and for scripts in the browser's console.
  window.explore = {
    store, stage, renderer, choices, thumbnails, keys: page.keys, scene: () => scene,
    isBusy: () => Boolean(asking) || Boolean(reading) || scenes.key(store.state.recipe) !== shownOf && !isExported,
    settled: () => stage.settled(),
    // Draws a picture apart from that on the page, without the camera of the state. Returns linear colours and
    // coverage.
    render: (width, height) => new Promise((resolve) => {
      const shot = shotOf(scene, { ...store.state, view: viewAround(scene.frame, {}, width / height) });
      stage.drawSmall(shot, width, height).then((made) => resolve(Array.from(made.values)));
    }),
  };
}

// The description of an exported page.
function exportNote(scene, start) {
  const { exponent } = scene, notes = [`Made by JuliaVDB ${start.version}.`];
  if (exponent)
    notes.push(`The shape is stored as 16-bit numbers at ${exponent.dims.join(" × ")} places` +
      (exponent.coarser > 1.01 ? `, ${exponent.coarser.toFixed(1)} times as far apart as the program has them` : "") +
      `; each is off by at most ${Number(exponent.error.toPrecision(2))}. The program's own results are finer.`);
  const recipe = Object.entries(start.recipe).filter(([name]) => name !== "input").map(([name, value]) => `--${name} ${value}`).join(" ");
  return element("div", { class: "about" }, ...notes.map((note) => element("p", {}, note)),
    recipe ? element("p", {}, element("code", {}, recipe)) : null);
}

run().catch((error) => {
  document.getElementById("app").replaceChildren(element("p", { class: "fatal", role: "alert" }, error.message));
});

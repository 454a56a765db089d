// SPDX-License-Identifier: Apache-2.0
// The state of the page: the recipe and the picture. It can be undone, and it is in the address, so that a link is a
// look.
import { LOOK_OPTIONS } from "./lighting.js";

const KEPT_STEPS = 300;

// The state as the part of an address behind '#'. Of the recipe, it has only the differences from the first one.
export function hashOf(state, first) {
  const recipe = {};
  for (const name of new Set([...Object.keys(state.recipe), ...Object.keys(first.recipe)]))
    if (state.recipe[name] !== first.recipe[name]) recipe[name] = state.recipe[name] ?? null;
  return "#" + encodeURIComponent(JSON.stringify({ recipe, view: state.view, look: state.look, compare: state.compare }));
}

const isNumbers = (value, count) => Array.isArray(value) && value.length === count && value.every(Number.isFinite);

// The state in an address; null if there is none. Its content is checked, because anybody may have written it.
export function stateOfHash(hash, first) {
  let read;
  try {
    read = JSON.parse(decodeURIComponent(hash.replace(/^#/, "")));
  } catch {
    return null;
  }
  if (typeof read !== "object" || read === null) return null;
  const state = structuredClone(first);
  for (const [given, value] of Object.entries(read.recipe ?? {})) {
    const name = given.replace(/^versor(?=-|$)/, "texture");  // its name in addresses of version 1.0
    if (value === null) delete state.recipe[name];
    else if (typeof value === "string" && /^[a-z][a-z0-9-]*$/.test(name)) state.recipe[name] = value;
  }
  const { view, look } = read;
  if (view && isNumbers(view.eye, 3) && isNumbers(view.lookAt, 3) && isNumbers(view.up, 3) && view.fov > 0 && view.fov < 180)
    state.view = { eye: view.eye, lookAt: view.lookAt, up: view.up, fov: view.fov, of: String(view.of ?? "") || undefined };
  if (look && typeof look === "object") state.look = checkedLook(look);
  state.compare = read.compare === true;
  return state;
}

export function checkedLook(look) {
  const checked = { ...usualLook() };
  for (const name of LOOK_OPTIONS)
    if (typeof look.options?.[name] === "string" && look.options[name].length < 200) checked.options[name] = look.options[name];
  if (Number.isInteger(look.samples)) checked.samples = Math.min(64, Math.max(0, look.samples));
  const clip = look.clip;
  if (clip && ["x", "y", "z"].includes(clip.axis))
    checked.clip = { axis: clip.axis, at: Math.min(1, Math.max(0, Number(clip.at) || 0)), flip: clip.flip === true };
  return checked;
}

// options: of the material and the light, all text; samples: rays per pixel at rest; 0: as many as the speed of the GPU
// allows.
export function usualLook() {
  return { options: {}, samples: 0, clip: { axis: "", at: 0.5, flip: false } };
}

export class Store {
  // first: {recipe, view, look, compare}
  constructor(first, state) {
    this.first = structuredClone(first);
    this.state = structuredClone(state ?? first);
    this.steps = [JSON.stringify(this.state)];
    this.at = 0;
    this.listeners = [];
  }

  // listener(state, isMoving): called after each change; isMoving while a control is being dragged.
  listen(listener) { this.listeners.push(listener); }
  tell(isMoving) { for (const listener of this.listeners) listener(this.state, isMoving); }

  // mutate(state) changes it. A change that is still in progress is not a step of its own, and not in the address yet.
  change(mutate, isMoving = false) {
    mutate(this.state);
    if (!isMoving) this.commit();
    this.tell(isMoving);
  }

  commit() {
    const text = JSON.stringify(this.state);
    if (text === this.steps[this.at]) return;
    this.steps.length = this.at + 1;
    this.steps.push(text);
    if (this.steps.length > KEPT_STEPS) this.steps.shift();
    this.at = this.steps.length - 1;
    this.writeAddress();
  }

  // Changes the state without a step, for changes that the user has not made.
  settle() {
    this.steps[this.at] = JSON.stringify(this.state);
    this.writeAddress();
  }

  writeAddress() { history.replaceState(null, "", hashOf(this.state, this.first)); }

  get canUndo() { return this.at > 0; }
  get canRedo() { return this.at + 1 < this.steps.length; }
  go(by) {
    if (!(this.at + by in this.steps)) return;
    this.at += by;
    this.state = JSON.parse(this.steps[this.at]);
    this.writeAddress();
    this.tell(false);
  }
}

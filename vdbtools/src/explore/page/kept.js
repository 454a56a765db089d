// SPDX-License-Identifier: Apache-2.0
// Kept looks: small pictures below the stage, which lead back to the looks. The browser keeps them until its tab is
// closed.
import { hashOf, stateOfHash } from "./store.js";
import { recipeKey } from "./variations.js";
import { button, element } from "./widgets.js";

const WIDTH = 96, HEIGHT = 72, MOST_KEPT = 60;

const sameLook = (a, b) => recipeKey(a.recipe) === recipeKey(b.recipe) && recipeKey(a.look.options) === recipeKey(b.look.options);

// page: {store, first}
export class KeptLooks {
  constructor(page) {
    Object.assign(this, { page, looks: [], listeners: [], key: `juliavdb ${location.pathname}` });
    this.empty = element("span", { class: "note" }, "Looks that you keep appear here.");
    this.element = element("div", { class: "kept", role: "group", "aria-label": "Kept looks" }, this.empty);
    this.load();
    this.show();
  }

  listen(listener) { this.listeners.push(listener); }
  // Of two states that differ only in the camera, one is kept.
  has(state) { return this.looks.some((look) => sameLook(look.state, state)); }

  // picture: a canvas that shows it
  add({ label, state }, picture) {
    if (this.has(state)) return;
    const small = element("canvas", { width: WIDTH, height: HEIGHT }), share = Math.max(WIDTH / picture.width, HEIGHT / picture.height);
    const [width, height] = [picture.width * share, picture.height * share];
    small.getContext("2d").drawImage(picture, (WIDTH - width) / 2, (HEIGHT - height) / 2, width, height);
    this.looks.unshift({ label, state: structuredClone(state), picture: small.toDataURL("image/jpeg", 0.85) });
    this.looks.length = Math.min(this.looks.length, MOST_KEPT);
    this.changed();
  }

  remove(state) {
    this.looks = this.looks.filter((look) => !sameLook(look.state, state));
    this.changed();
  }

  changed() {
    this.show();
    this.save();
    for (const listener of this.listeners) listener();
  }

  show() {
    this.element.classList.toggle("none", this.looks.length === 0);
    this.element.replaceChildren(...this.looks.length === 0 ? [this.empty] : this.looks.map((look) => this.tileOf(look)));
  }

  tileOf(look) {
    const go = button("", () => this.page.store.change((state) => { Object.assign(state, structuredClone(look.state)); }),
      { class: "kept-picture", "aria-label": `Go to the kept look ${look.label}`, title: look.label });
    go.append(element("img", { src: look.picture, alt: "", width: WIDTH, height: HEIGHT }));
    return element("div", { class: "kept-look" }, go,
      button("×", () => this.remove(look.state), { class: "kept-remove", "aria-label": `Keep ${look.label} no longer`, title: "Keep it no longer" }));
  }

  // Stored as addresses, which are checked when they are read.
  save() {
    try {
      sessionStorage.setItem(this.key, JSON.stringify(this.looks.map(({ label, state, picture }) => ({ label, hash: hashOf(state, this.page.first), picture }))));
    } catch { /* no room, or none is allowed: they last as long as the page */ }
  }
  load() {
    let read = null;
    try {
      read = JSON.parse(sessionStorage.getItem(this.key));
    } catch { /* as above */ }
    for (const { label, hash, picture } of Array.isArray(read) ? read : []) {
      const state = stateOfHash(String(hash), this.page.first);
      if (state && String(picture).startsWith("data:image/")) this.looks.push({ label: String(label), state, picture });
    }
  }
}

// SPDX-License-Identifier: Apache-2.0
// Sixteen looks over the stage, to choose from: each can be used, kept, compared with others, or varied again. Each
// such page of looks is kept, so that going back shows it again at once.
import { nearerView } from "./camera.js";
import { EVERYTHING, recipeKey } from "./variations.js";
import { button, element } from "./widgets.js";

const KEPT_PAGES = 12, MOST_COMPARED = 4;
const CHOICES_OWNER = "choices";
const MOST_SIDE = 1200;  // pixels of a picture

// page: {store, stage, variations, kept, sceneFor(recipe, side, signal), scene(), shotOf(scene, state), say(text, isError)}
export class Choices {
  constructor(page) {
    Object.assign(this, { page, pages: [], isOpen: false, run: 0, opener: null, listeners: [] });
    this.title = element("strong", { class: "choices-title" });
    this.note = element("span", { class: "note", role: "status" });
    this.back = button("Back", () => this.goBack(), { title: "Backspace", class: "choices-back" });
    this.vary = element("select", { "aria-label": "What Vary varies" });
    this.compare = button("Compare", () => this.compareMarked(), { disabled: true, class: "choices-compare" });
    this.holder = element("div", { class: "choices-holder" });
    this.element = element("section", { class: "choices", hidden: true, "aria-label": "Looks to choose from", onkeydown: (event) => this.key(event) },
      element("div", { class: "choices-bar" }, this.back, this.title, this.note,
        element("label", { class: "choices-vary" }, "Vary changes ", this.vary), this.compare,
        button("Close", () => this.close(), { title: "Escape" })),
      this.holder);
  }

  listen(listener) { this.listeners.push(listener); }
  tell() { for (const listener of this.listeners) listener(); }
  get top() { return this.pages.at(-1); }
  get isWorking() { return this.isOpen && this.top.cells.some((cell) => !cell.isDone); }

  // ---- pages of looks ----

  // Sixteen looks around the current one.
  show(name, label) {
    const state = structuredClone(this.page.store.state);
    this.push({ name, generation: 0, title: label, state, looks: this.page.variations.around(name, state.recipe) });
  }

  // Sixteen neighbours of a look of this page.
  varyAgain(cell) {
    const { variations } = this.page, name = this.vary.value, { label } = this.vary.selectedOptions[0];
    const generation = this.top.name === name ? this.top.generation + 1 : 1;
    const spread = name === EVERYTHING ? Math.max(0.2, 0.75 ** (generation - 1)) : 0.5 ** generation;
    this.top.at = this.top.cells.indexOf(cell);
    this.push({
      name, generation, title: `${label}, around ${cell.label}`, state: { ...this.top.state, recipe: cell.recipe },
      looks: variations.around(name, cell.recipe, { isAround: true, spread }),
    });
  }

  compareMarked() {
    const marked = this.top.cells.filter((cell) => cell.isMarked), looks = marked.map(({ label, recipe }) => ({ label, recipe }));
    if (looks.length === 1) looks.unshift({ label: "the look at hand", recipe: { ...this.page.store.state.recipe } });
    this.push({ name: this.top.name, generation: this.top.generation, title: "Side by side", state: this.top.state, looks, isComparison: true });
  }

  push(one) {
    if (one.looks.length === 0) return this.page.say("There is nothing to vary in this look.", true);
    if (this.isOpen) this.leave();
    one.at = 0;
    one.element = element("div", { class: `choices-grid ${one.isComparison ? `compared of-${one.looks.length}` : ""}`, role: "group", "aria-label": one.title });
    one.cells = one.looks.map((look, i) => this.cellOf(look, one, i));
    one.element.append(...one.cells.map((cell) => cell.element));
    this.pages.push(one);
    if (this.pages.length > KEPT_PAGES) this.pages.shift();
    this.open();
  }

  goBack() {
    if (this.pages.length < 2) return this.close();
    this.leave();
    this.pages.pop();
    this.open();
  }

  // Shows the latest page of looks, as it was.
  open() {
    if (!this.top) return;
    if (!this.isOpen) this.opener = document.activeElement;
    const one = this.top, { page } = this;
    this.isOpen = true;
    this.element.hidden = false;
    this.holder.replaceChildren(one.element);
    this.title.textContent = one.title;
    this.back.disabled = this.pages.length < 2;
    const what = page.variations.of(one.state.recipe), before = this.vary.value;
    this.vary.replaceChildren(...what.map(({ name, label }) => element("option", { value: name }, label)));
    this.vary.value = [before, EVERYTHING, what[0].name].find((name) => name && what.some((other) => other.name === name));
    this.update();
    page.stage.cover(true);
    this.focus(one.at);
    this.tell();
    this.draw(one);
  }

  leave() {
    ++this.run;
    this.asking?.abort();
    this.page.stage.dropSmalls(CHOICES_OWNER);
  }

  close() {
    if (!this.isOpen) return;
    this.leave();
    const hadFocus = this.element.contains(document.activeElement);
    this.isOpen = false;
    this.element.hidden = true;
    this.page.stage.cover(false);
    if (hadFocus) (this.opener?.isConnected ? this.opener : this.page.stage.canvas).focus();
    this.tell();
  }

  // ---- a look ----

  cellOf({ label, recipe }, one, i) {
    const cell = { label, recipe, isDone: false, isMarked: false };
    cell.canvas = element("canvas", { width: 1, height: 1, "aria-hidden": "true" });
    cell.picture = button("", () => this.use(cell), { class: "choice-picture", "aria-label": `Use ${label}`, title: `${label}: use this look (Enter)` });
    cell.error = element("span", { class: "choice-error", role: "status", hidden: true });
    // The differences of a neighbour would hide its picture, so they are shown only under the pointer.
    const short = one.name === EVERYTHING && !one.isComparison ? element("span", { class: "choice-label short" }, String(i + 1)) : null;
    cell.picture.append(cell.canvas, ...(short ? [short] : []), element("span", { class: `choice-label ${short ? "long" : ""}` }, label), cell.error);
    cell.keep = button("Keep", () => this.keep(cell, one), { "aria-pressed": "false", "aria-label": `Keep ${label}`, title: "K" });
    cell.mark = button("Compare", () => this.markToCompare(cell), { "aria-pressed": "false", "aria-label": `Compare ${label}`, title: "C" });
    cell.again = button("Vary", () => this.varyAgain(cell), { "aria-label": `Vary ${label}`, title: "V" });
    const actions = [cell.keep, ...(one.isComparison ? [] : [cell.mark]), cell.again];
    cell.buttons = [cell.picture, ...actions];
    cell.element = element("div", { class: "choice", role: "group", "aria-label": label, onfocusin: () => this.reach(cell) },
      cell.picture, element("div", { class: "choice-actions" }, ...actions));
    return cell;
  }

  use(cell) {
    this.top.at = this.top.cells.indexOf(cell);
    this.close();
    this.page.store.change((state) => { state.recipe = { ...cell.recipe }; });
  }

  keep(cell, one) {
    const { kept } = this.page;
    const state = { ...one.state, recipe: { ...cell.recipe } };
    if (kept.has(state)) kept.remove(state);
    else kept.add({ label: cell.label, state }, cell.canvas);
    this.update();
  }

  markToCompare(cell) {
    cell.isMarked = !cell.isMarked;
    const marked = this.top.cells.filter((one) => one.isMarked);
    if (marked.length > MOST_COMPARED) marked.find((one) => one !== cell).isMarked = false;
    this.update();
  }

  // The texts of the buttons.
  update() {
    if (!this.top) return;
    for (const cell of this.top.cells) {
      cell.keep.setAttribute("aria-pressed", String(this.page.kept.has({ ...this.top.state, recipe: cell.recipe })));
      cell.mark.setAttribute("aria-pressed", String(cell.isMarked));
      const isUsable = cell.isDone && !cell.hasFailed;
      for (const one of [cell.keep, cell.mark, cell.again]) one.disabled = !isUsable;
    }
    const marked = this.top.cells.filter((cell) => cell.isMarked).length, done = this.top.cells.filter((cell) => cell.isDone).length;
    this.compare.hidden = Boolean(this.top.isComparison);
    this.compare.disabled = marked === 0;
    this.compare.textContent = marked === 0 ? "Compare" : marked === 1 ? "Compare with the look at hand" : `Compare ${marked}`;
    this.note.textContent = done < this.top.cells.length ? `${done} of ${this.top.cells.length}` : "";
  }

  // ---- keys ----

  // Tab reaches one look; the arrow keys go on to the others.
  reach(cell) {
    this.top.at = Math.max(0, this.top.cells.indexOf(cell));
    this.top.cells.forEach((one, i) => { for (const each of one.buttons) each.tabIndex = i === this.top.at ? 0 : -1; });
  }
  focus(at) {
    const cell = this.top.cells[at];
    this.reach(cell);
    cell.picture.focus({ preventScroll: at === 0 });
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target === this.vary && event.key !== "Escape") return;
    const { cells, at, element: grid } = this.top, cell = cells[at], columns = getComputedStyle(grid).gridTemplateColumns.split(" ").length;
    const go = (by) => {
      if (cells[at + by] && grid.contains(document.activeElement)) this.focus(at + by);
    };
    const press = (one) => {
      if (!one.disabled && one.isConnected) one.click();
    };
    const actions = {
      ArrowLeft: () => go(-1), ArrowRight: () => go(1), ArrowUp: () => go(-columns), ArrowDown: () => go(columns),
      k: () => press(cell.keep), c: () => press(cell.mark), v: () => press(cell.again), Backspace: () => this.goBack(), Escape: () => this.close(),
    };
    const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action) return;
    event.preventDefault();
    event.stopPropagation();
    action();
  }

  // ---- pictures ----

  // Makes the missing pictures, one after another. The scene of the next one is requested meanwhile.
  async draw(one) {
    const { page } = this, mine = ++this.run, { signal } = this.asking = new AbortController();
    const ratio = Math.min(2, window.devicePixelRatio || 1), cells = one.cells.filter((cell) => !cell.isDone);
    const isLive = !one.isComparison && page.variations.isLive(one.name) && recipeKey(one.state.recipe) === recipeKey(page.store.state.recipe);
    const sceneOf = (cell) => {
      if (!cell || isLive && page.scene()) return cell && Promise.resolve(page.scene());
      // The exponent needs no more nodes than the picture can show.
      const side = Math.min(256, Math.max(64, 32 * Math.ceil(cell.canvas.clientHeight * ratio / 32)));
      const scene = page.isExported ? Promise.resolve(page.scene()) : page.sceneFor(cell.recipe, side, signal);
      scene.catch(() => {});  // reported where it is awaited
      return scene;
    };
    let next = sceneOf(cells[0]);
    for (const [i, cell] of cells.entries()) {
      try {
        const scene = await next;
        if (mine !== this.run) return;
        next = sceneOf(cells[i + 1]);
        await page.colourings.read(scene, cell.recipe, signal);
        if (mine !== this.run) return;
        const { canvas } = cell, shrink = Math.min(ratio, MOST_SIDE / Math.max(1, canvas.clientWidth, canvas.clientHeight));
        const width = Math.max(16, Math.round(canvas.clientWidth * shrink)), height = Math.max(16, Math.round(canvas.clientHeight * shrink));
        // A narrow picture is seen from farther away, so that nothing at the sides is lost.
        const shot = page.shotOf(scene, { ...one.state, recipe: cell.recipe }), aspect = Math.min(1, page.stage.aspect);
        if (width / height < aspect) shot.view = nearerView(shot.view, aspect * height / width);
        const made = await page.stage.drawSmall(shot, width, height, { owner: CHOICES_OWNER, isFiner: true });
        if (!made || mine !== this.run) return;
        Object.assign(canvas, { width, height });
        canvas.getContext("2d").putImageData(made.image, 0, 0);
      } catch (error) {
        if (mine !== this.run || error.name === "AbortError") return;
        cell.hasFailed = true;
        cell.error.textContent = error.message;
        cell.error.hidden = false;
        cell.picture.disabled = true;
        next = sceneOf(cells[i + 1]);
      }
      cell.isDone = true;
      cell.element.classList.add("done");
      this.update();
    }
    this.tell();
  }
}

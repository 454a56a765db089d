// SPDX-License-Identifier: Apache-2.0
// Sixteen small pictures around the present values of a control: click to go there.
import { followsThickness } from "./controls.js";
import { button, element } from "./widgets.js";

const COUNT = 16;
// Pixels of the screen, no more than it shows.
const SIDE = Math.ceil(96 * Math.min(1, window.devicePixelRatio || 1));

// name: an option; values(now): the texts of the sixteen; needsServer: whether its scene must be made anew
const around = (low, high, digits) => () => Array.from({ length: COUNT }, (_, i) => String(Number((low + (high - low) * i / (COUNT - 1)).toFixed(digits))));
const near = (step, least, digits) => (now) => Array.from({ length: COUNT }, (_, i) => String(Number(Math.max(least, now + (i - COUNT / 2 + 1) * step).toFixed(digits))));
export const STRIPS = [
  { name: "versor-seed", label: "Seeds", usual: 1, values: (now) => Array.from({ length: COUNT }, (_, i) => String(Math.max(0, now - 3) + i)) },
  { name: "detail", label: "Detail", usual: 0.3, values: around(0.05, 0.8, 2) },
  { name: "outward", label: "Outward", usual: 0.3, values: around(0, 0.45, 2) },
  { name: "alpha", label: "Alpha", usual: 40, values: () => Array.from({ length: COUNT }, (_, i) => String(Number((4 * 75 ** (i / (COUNT - 1))).toPrecision(2)))) },
  { name: "versor", label: "Textures", values: null },
  { name: "frequency", label: "Frequency", usual: 2, values: () => Array.from({ length: COUNT }, (_, i) => String(Number((0.5 * 12 ** (i / (COUNT - 1))).toPrecision(3)))) },
  { name: "versor-scale", label: "Scale of the texture", usual: 1, live: true, values: () => Array.from({ length: COUNT }, (_, i) => String(Number((0.4 * 10 ** (i / (COUNT - 1))).toPrecision(3)))) },
  { name: "slice", label: "Slice", usual: 0, live: true, values: near(0.04, -10, 3) },
  { name: "iterations", label: "Iterations", usual: 5, live: true, values: () => Array.from({ length: COUNT }, (_, i) => String(i + 1)) },
  { name: "power", label: "Power", usual: 8, live: true, values: () => Array.from({ length: COUNT }, (_, i) => String(i + 2)) },
];

// page: {store, options, start, isExported, stage, sceneFor(recipe), shotOf(scene, state)}
export function makeStrip(page) {
  const { store } = page;
  let run = 0;
  const select = element("select", { "aria-label": "What the strip varies" });
  const cells = element("div", { class: "cells", role: "group", "aria-label": "Sixteen looks around this one" });
  const note = element("span", { class: "note", role: "status" });
  const make = button("Show sixteen", () => draw());
  const whole = element("section", { class: "strip", "aria-label": "Variations" },
    element("div", { class: "buttons" }, select, make, note), cells);

  // The strips that go with the map at hand.
  function update(state) {
    const fits = STRIPS.filter((one) => page.isExported ? one.live && liveFits(one.name) : page.options.has(one.name, state.recipe) &&
      !(one.name === "frequency" && !followsThickness(page, state.recipe)) && !(one.name === "alpha" && !("alpha" in state.recipe)) && !(["detail", "outward"].includes(one.name) && "alpha" in state.recipe));
    const names = fits.map((one) => one.name).join();
    if (select.dataset.names !== names) {
      select.dataset.names = names;
      const before = select.value;
      select.replaceChildren(...fits.map((one) => element("option", { value: one.name }, one.label)));
      if (fits.some((one) => one.name === before)) select.value = before;
    }
  }
  function liveFits(name) {
    const scene = page.scene();
    return name === "power" ? scene.map === "mandelbulb" : name === "versor-scale" ? Boolean(scene.factors ?? scene.waves)
      : name === "slice" ? !["cross", "mandelbulb"].includes(scene.map) : true;
  }

  function recipesOf(strip, recipe) {
    const now = Number(recipe[strip.name] ?? page.options.usual(strip.name, recipe) ?? strip.usual);
    const values = strip.name === "versor" ? page.start.textures.slice(0, COUNT).map((texture) => texture.name) : strip.values(Number.isFinite(now) ? now : strip.usual);
    return [...new Set(values)].map((value) => {
      const other = { ...recipe };
      page.options.set(other, strip.name, value);
      // A seed means something only where roots are random.
      if (strip.name === "versor-seed" && other.versor && !page.start.textures.some((one) => one.varies && one.name === other.versor)) other.versor = "random";
      return { value, recipe: other };
    });
  }

  async function draw() {
    const mine = ++run, strip = STRIPS.find((one) => one.name === select.value);
    if (!strip) return;
    page.stage.dropSmalls();
    const state = structuredClone(store.state), looks = recipesOf(strip, state.recipe);
    const made = looks.map(({ value, recipe }) => {
      const canvas = element("canvas", { width: SIDE, height: SIDE, "aria-hidden": "true" });
      const cell = button("", () => store.change((now) => { now.recipe = { ...recipe }; }), { class: "cell", "aria-label": `${strip.label} ${value}` });
      cell.append(canvas, element("span", {}, value));
      return { cell, canvas, recipe };
    });
    cells.replaceChildren(...made.map((one) => one.cell));
    let done = 0;
    note.textContent = `0 of ${made.length}`;
    for (const { cell, canvas, recipe } of made) {
      try {
        const scene = strip.live ? page.scene() : await page.sceneFor(recipe);
        if (mine !== run) return;
        await new Promise((resolve) => page.stage.drawSmall(page.shotOf(scene, { ...state, recipe }), SIDE, SIDE, (image) => {
          canvas.getContext("2d").putImageData(image, 0, 0);
          resolve();
        }));
      } catch (error) {
        cell.title = error.message;
        cell.classList.add("failed");
      }
      if (mine !== run) return;
      note.textContent = `${++done} of ${made.length}`;
    }
    note.textContent = "";
  }

  return { element: whole, update };
}

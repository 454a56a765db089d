// SPDX-License-Identifier: Apache-2.0
// Sixteen looks around one: the values of a control, or neighbours in which several controls differ a little. The same
// look always has the same neighbours.
import { BY_GRADIENT, colourOf, colourText } from "./colours.js";
import { chooseTexture, followsGrain, followsThickness, isRandomVersor, setSeed, UNCHANGED } from "./controls.js";
import { GRADIENTS } from "./renderer.js";
import { isApplied } from "./scene.js";

export const CHOICES = 16;
export const EVERYTHING = "everything";
const FREQUENCIES = { coarse: 1, medium: 2, fine: 4 };

const tidied = (value, digits = 3) => String(Number(value.toPrecision(digits)));
const clamped = (value, low, high) => Math.min(high, Math.max(low, value));
const numberOf = (text) => FREQUENCIES[text] ?? Number(text);

// What can be varied, what matters most first. low, high: the whole range; log: each step multiplies; whole: whole
// numbers only; usual: the middle where the program has no default; isLive: the shaders show it without another scene.
const VARIATIONS = [
  { name: "texture", label: "Textures" },
  { name: EVERYTHING, label: "A little of everything" },
  { name: "texture-seed", label: "Seeds" },
  { name: "frequency", label: "Frequency", low: 0.5, high: 6, log: true },
  { name: "grain-turn", label: "Turn of the grain", low: -90, high: 90 },
  { name: "detail", label: "Detail", low: 0.05, high: 0.8 },
  { name: "outward", label: "Outward", low: 0, high: 0.45 },
  { name: "alpha", label: "Alpha", usual: 40, low: 4, high: 300, log: true },
  { name: "colour", label: "Colours", isLive: true },
  { name: "texture-scale", label: "Scale of the texture", low: 0.4, high: 4, log: true, isLive: true },
  { name: "slice", label: "Slice", low: -0.3, high: 0.3, isLive: true },
  { name: "iterations", label: "Iterations", low: 1, high: 16, whole: true, isLive: true },
  { name: "power", label: "Power", low: 2, high: 17, whole: true, isLive: true },
];

// The options by which neighbours differ a little. by: the difference, as a number or, with log, as the logarithm of a
// factor; components: of a list of numbers.
const LITTLES = [
  { name: "detail", by: 0.2, low: 0.02, high: 1 },
  { name: "outward", by: 0.15, low: 0, high: 0.5 },
  { name: "frequency", by: 0.6, low: 0.3, high: 8, log: true },
  { name: "grain-turn", by: 40, low: -90, high: 90 },
  { name: "alpha", by: 0.8, low: 1, high: 400, log: true },
  { name: "beta", by: 0.04, low: -0.2, high: 0.2 },
  { name: "texture-scale", by: 0.35, low: 0.2, high: 5, log: true, isLive: true },
  { name: "texture-translate", by: 0.12, low: -0.5, high: 0.5, components: 3, isLive: true },
  { name: "slice", by: 0.12, low: -1, high: 1, isLive: true },
  { name: "c", by: 0.12, low: -2, high: 2, components: 4, isLive: true },
  { name: "power", by: 1.5, low: 1.5, high: 16, isLive: true },
];

// Random numbers from 0 to 1, the same for the same text.
function randomOf(text) {
  let state = 2166136261;
  for (let i = 0; i < text.length; ++i) state = Math.imul(state ^ text.charCodeAt(i), 16777619);
  return () => {
    state = state + 0x6d2b79f5 | 0;
    let mixed = Math.imul(state ^ state >>> 15, 1 | state);
    mixed = mixed + Math.imul(mixed ^ mixed >>> 7, 61 | mixed) ^ mixed;
    return ((mixed ^ mixed >>> 14) >>> 0) / 4294967296;
  };
}

export const recipeKey = (recipe) => JSON.stringify(Object.entries(recipe).sort());

// page: {options, start, isExported, scene()}
export class Variations {
  constructor(page) { this.page = page; }

  has(name, recipe) {
    const { options, isExported } = this.page;
    if (isExported) return this.isShown(name);
    if (name === "frequency") return followsThickness(this.page, recipe);
    if (name === "grain-turn") return followsGrain(this.page, recipe);
    if (name === "texture-translate" && followsGrain(this.page, recipe)) return false;
    if (name === "alpha" || name === "beta") return "alpha" in recipe && options.has(name, recipe);
    if (name === "detail" || name === "outward") return !("alpha" in recipe) && !("beta" in recipe) && options.has(name, recipe);
    if (name === "c") return this.now({ name }, recipe) !== null && options.has(name, recipe);
    return name === "colour" || options.has(name, recipe);
  }

  // Whether an exported page, which has no server, shows another value of an option.
  isShown(name) {
    const scene = this.page.scene();
    if (name === "power") return scene.map === "mandelbulb";
    if (name === "texture-scale" || name === "texture-translate") return Boolean(scene.factors ?? scene.waves);
    if (name === "slice") return !["cross", "mandelbulb"].includes(scene.map);
    return name === "iterations" || name === "colour" || (name === "c" && Boolean(scene.constant) && scene.map !== "shape-modulus");
  }

  // [{name, label}] of the options that a recipe has.
  of(recipe) {
    return VARIATIONS.filter(({ name }) => name === EVERYTHING ? this.littlesOf(recipe).length > 0 : this.has(name, recipe));
  }

  isLive(name) {
    if (this.page.isExported) return true;
    return VARIATIONS.some((one) => one.name === name && one.isLive) && isApplied(name, this.page.scene());
  }

  littlesOf(recipe) {
    return LITTLES.filter((little) => this.has(little.name, recipe) && this.now(little, recipe) !== null);
  }

  // The numbers of an option; null: it has others, a ramp say.
  now({ name, components = 1 }, recipe) {
    const given = recipe[name] ?? this.page.options.usual(name, recipe) ?? this.shownValue(name) ?? UNCHANGED[name];
    if (given === undefined || given === "") return null;
    const numbers = String(given).split(",").map(numberOf);
    return numbers.every(Number.isFinite) && numbers.length <= Math.max(components, 1) ? numbers : null;
  }
  shownValue(name) {
    const scene = this.page.scene();
    return { c: scene?.constant?.join(","), power: scene?.power, slice: scene?.slice, iterations: scene?.iterations }[name];
  }

  // Sixteen looks around a recipe: [{label, recipe}]. With isAround, the recipe itself is not among them.
  // spread: their distance, relative to the usual one.
  around(name, recipe, { isAround = false, spread = 1 } = {}) {
    if (name === EVERYTHING) return this.neighbours(recipe, spread);
    const one = VARIATIONS.find((variation) => variation.name === name);
    const texts = name === "texture" ? this.textures(recipe, isAround) : name === "colour" ? this.colours(recipe, isAround)
      : name === "texture-seed" ? this.seeds(recipe, isAround) : this.values(one, recipe, isAround, spread);
    return texts.map((text) => ({ label: text, recipe: this.with(name, recipe, text) }));
  }

  with(name, recipe, text) {
    const other = { ...recipe }, { options } = this.page;
    if (name === "texture") chooseTexture(this.page, other, ...text.split(" "));
    else if (name === "texture-seed") setSeed(this.page, other, text);
    else if (name === "colour" && text === "clay") delete other.colour;
    else options.set(other, name, text);
    return other;
  }

  seedOf(recipe) { return recipe["texture-seed"] ?? this.page.options.usual("texture-seed", recipe); }

  // The shelf, and random roots for the rest.
  textures(recipe, isAround) {
    const { options, start } = this.page, names = start.textures.map((texture) => texture.name);
    for (let seed = 1; names.length <= CHOICES; ++seed) names.push(`random ${seed}`);
    if (!isAround) return names.slice(0, CHOICES);
    const now = isRandomVersor(recipe) ? `random ${this.seedOf(recipe)}` : recipe.texture ?? options.usual("texture", recipe);
    const at = Math.max(0, names.indexOf(now));
    return names.map((_, i) => names[(at + i) % names.length]).filter((name) => name !== now).slice(0, CHOICES);
  }

  colours(recipe, isAround) {
    const now = colourText({ ...colourOf(recipe), range: null }) ?? "clay", hasTarget = Boolean(this.page.start.target ?? this.page.scene()?.targetBox);
    const kinds = BY_GRADIENT.filter((by) => by !== "depth" || hasTarget);
    const shades = Object.keys(GRADIENTS).flatMap((gradient) => kinds.map((by) => colourText({ by, gradient, range: null })));
    return ["clay", ...shades.slice(0, 12), "direction", "versor", ...shades.slice(12)].filter((text) => !isAround || text !== now).slice(0, CHOICES);
  }

  seeds(recipe, isAround) {
    const now = Number(this.seedOf(recipe)) || 0, first = isAround ? now + 1 : Math.max(0, now - 3);
    return Array.from({ length: CHOICES }, (_, i) => String(first + i));
  }

  // Values evenly over the range; or, around a value, over a part of the range with that value in its middle, without
  // it.
  values({ name, usual, low, high, log, whole }, recipe, isAround, spread) {
    const at = (value) => log ? Math.log(value) : value, from = (value) => log ? Math.exp(value) : value;
    const tidy = (value) => whole ? String(Math.max(low, Math.round(value))) : tidied(Math.abs(value) < 1e-9 ? 0 : value);
    const middle = this.now({ name }, recipe)?.[0] ?? numberOf(this.page.options.usual(name, recipe) ?? usual);
    const now = clamped(middle, log ? low / 10 : -Infinity, Infinity);
    if (!isAround) {
      // Where zero is the usual value, around the one at hand.
      const shift = name === "slice" ? now : 0;
      return this.distinct(Array.from({ length: CHOICES }, (_, i) => tidy(shift + from(at(low) + (at(high) - at(low)) * i / (CHOICES - 1)))));
    }
    const half = CHOICES / 2, step = whole ? 1 : (at(high) - at(low)) * spread / CHOICES;
    const texts = [];
    // A value beyond one end of the range continues at the other end.
    for (let k = 1; texts.length < CHOICES && k <= 4 * half; ++k)
      for (const side of [-k, k]) {
        const value = from(at(now) + side * step);
        const isInside = value >= Math.min(low, now) && (log || name === "slice" || whole || value <= Math.max(high, now));
        if (isInside && texts.length < CHOICES && tidy(value) !== tidy(now) && !texts.includes(tidy(value))) texts.push(tidy(value));
      }
    return texts.sort((a, b) => a - b);
  }

  distinct(texts) { return [...new Set(texts)]; }

  neighbours(recipe, spread) {
    const littles = this.littlesOf(recipe), random = randomOf(recipeKey(recipe)), known = new Set([recipeKey(recipe)]), looks = [];
    for (let attempt = 0; looks.length < CHOICES && attempt < 40 * CHOICES; ++attempt) {
      const other = { ...recipe }, changed = [], must = looks.length % littles.length;
      littles.forEach((little, i) => {
        const chosen = random() < 0.45, moves = Array.from({ length: little.components ?? 1 }, () => 2 * random() - 1);
        if (!chosen && i !== must) return;
        const numbers = this.now(little, recipe), text = numbers.map((value, k) => {
          // Not too little: a neighbour that looks the same is useless.
          const move = little.by * spread * Math.sign(moves[k]) * (0.35 + 0.65 * Math.abs(moves[k]));
          return tidied(clamped(little.log ? value * Math.exp(move) : value + move, little.low, little.high));
        }).join(",");
        if (text === numbers.map((value) => tidied(value)).join(",")) return;
        this.page.options.set(other, little.name, text);
        changed.push(`${little.name.replace("texture-", "")} ${text.replaceAll(",", " ")}`);
      });
      if (changed.length === 0 || known.has(recipeKey(other))) continue;
      known.add(recipeKey(other));
      looks.push({ label: changed.join(", "), recipe: other });
    }
    return looks;
  }
}

// SPDX-License-Identifier: Apache-2.0
// The value of --colour, and the colouring of a scene by it. The server gives the numbers at the ends of the gradient,
// so that the live picture has the colours of the exact one.
import { GRADIENTS } from "./renderer.js";
import { server } from "./server.js";

const KEPT = 40;

export const BY_GRADIENT = ["trap", "depth", "iterations"];
const isNumber = (text) => text !== undefined && text.trim() !== "" && Number.isFinite(Number(text));

// Parses --colour: {by, gradient, range}. The gradient is a name, a list of colours or a file; range: [low, high] or
// null.
export function colourOf(recipe) {
  const [by, ...rest] = (recipe.colour ?? "clay").split(":");
  const hasRange = rest.length >= 2 && isNumber(rest.at(-1)) && isNumber(rest.at(-2));
  const range = hasRange ? rest.splice(-2).map(Number) : null;
  return { by: by === "gradient" ? "trap" : by, gradient: rest.join(":") || "viridis", range };
}

// The same as the text of --colour; undefined for the default.
export function colourText({ by, gradient, range }) {
  if (!BY_GRADIENT.includes(by)) return by === "clay" ? undefined : by;
  return [by, ...(gradient !== "viridis" || range ? [gradient] : []), ...(range ?? [])].join(":");
}

// A list of colours as stops of a gradient; null if the text is not such a list.
function stopsOf(list) {
  const codes = list.split(",").map((code) => /^#?([0-9a-f]{6})$/i.exec(code)?.[1]);
  return codes.length >= 2 && codes.every(Boolean) ? codes.map((code) => [0, 2, 4].map((at) => parseInt(code.slice(at, at + 2), 16) / 255)) : null;
}

// The colourings of scenes. start: for an exported page, the colourings that it contains
export class Colourings {
  constructor(start, keyOf) {
    Object.assign(this, { keyOf, exported: start.exported ? start.colourings ?? {} : null, ownText: start.recipe?.colour, known: new Map(), latest: new Map() });
  }

  key(scene, recipe) { return `${this.keyOf(scene.recipe)} ${recipe.colour ?? ""}`; }

  // {by, stops, low, high, distance}, as far as known. Until the server has answered, the range is that of the last
  // colouring of the same kind.
  of(scene, recipe) {
    const known = this.known.get(this.key(scene, recipe));
    if (known) return known;
    const { by, gradient, range } = colourOf(recipe);
    const before = this.exported ? (recipe.colour === this.ownText && this.exported.own) || this.exported[by] : this.latest.get(by);
    const stops = GRADIENTS[gradient] ?? stopsOf(gradient) ?? before?.stops ?? GRADIENTS.viridis;
    const isRange = range && range[0] < range[1];
    return { by, stops, low: isRange ? range[0] : before?.low, high: isRange ? range[1] : before?.high, distance: before?.distance };
  }

  isReady(scene, recipe) {
    return Boolean(this.exported) || !BY_GRADIENT.includes(colourOf(recipe).by) || this.known.has(this.key(scene, recipe));
  }

  // Asks the server. Returns whether there is anything new; throws the server's message about a wrong value.
  async read(scene, recipe, signal) {
    if (this.isReady(scene, recipe)) return false;
    const { colour } = recipe, answer = await server.colouring({ ...scene.recipe, colour }, signal);
    this.known.set(this.key(scene, recipe), answer);
    this.latest.set(answer.by, answer);
    if (this.known.size > KEPT) this.known.delete(this.known.keys().next().value);
    return true;
  }
}

// SPDX-License-Identifier: Apache-2.0
// The material and the light of pictures: the texts in the state of the page, which are options of `juliavdb render`,
// and the numbers for the live picture. The server parses the texts. Texts that it has not parsed yet are parsed here,
// as far as that is possible.
import { server } from "./server.js";

export const LOOK_OPTIONS = ["material", "light", "sky", "ground", "background", "exposure"];
const linearOf = (code) => code <= 0.04045 ? code / 12.92 : ((code + 0.055) / 1.055) ** 2.4;

// "-48,41" as numbers; null for any other text.
export function lightAngles(text) {
  const parts = String(text).split(",").map(Number);
  return parts.length === 2 && parts.every(Number.isFinite) ? parts : null;
}

export class Lighting {
  // start: the first data of the server or of the exported page. first: the initial options of the exported page
  constructor(start, first) {
    this.materials = new Map(Object.entries(start.materials));
    this.about = new Map(start.looks.map((option) => [option.name, option]));
    this.known = new Map();
    this.isAsked = !start.exported;
    if (start.lookData) this.known.set(this.keyOf(first), start.lookData);
    this.latest = null;
  }

  usual(name) { return this.about.get(name)?.default ?? ""; }
  keyOf(options) { return JSON.stringify(LOOK_OPTIONS.map((name) => options[name] ?? this.usual(name))); }
  help(name) { return this.about.get(name)?.help ?? ""; }
  isNamed(material) { return this.materials.has(material); }

  // The numbers that the texts stand for; if some texts are not understood, the previous numbers.
  numbersOf(options) {
    const known = this.known.get(this.keyOf(options));
    if (known) return this.latest = known;
    const usual = { material: this.materials.get(this.usual("material")), light: lightAngles(this.usual("light")), background: null };
    const before = this.latest ?? usual, text = (name) => options[name] ?? this.usual(name);
    const number = (name, low, high) => Math.min(high, Math.max(low, Number.isFinite(Number(text(name))) ? Number(text(name)) : Number(this.usual(name))));
    const code = /^#([0-9a-f]{6})$/i.exec(text("background"))?.[1];
    return this.latest = {
      material: this.materials.get(text("material")) ?? before.material,
      light: lightAngles(text("light")) ?? before.light,
      sky: number("sky", 0, 100), exposure: number("exposure", -10, 10), ground: text("ground") === "true",
      background: text("background") === "" ? null : text("background") === "none" ? "none"
        : code ? [0, 2, 4].map((at) => linearOf(parseInt(code.slice(at, at + 2), 16) / 255)) : before.background,
    };
  }

  // Lets the server parse the texts. Returns whether the numbers have changed; throws the server's message about wrong
  // ones.
  async read(options) {
    const key = this.keyOf(options);
    if (!this.isAsked || this.known.has(key)) return false;
    this.known.set(key, await server.look(options));
    if (this.known.size > 200) this.known.delete(this.known.keys().next().value);
    return true;
  }
}

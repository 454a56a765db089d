// SPDX-License-Identifier: Apache-2.0
// The controls, as the program's options describe them. A recipe is an object of names and texts; options that are not
// in it have their defaults.
import { BY_GRADIENT, colourOf, colourText } from "./colours.js";
import { lightAngles } from "./lighting.js";
import { COLOURS } from "./renderer.js";
import { button, choice, element, group, slider, text, tick } from "./widgets.js";

const RANDOM_ROOTS = ["texture-seed", "texture-roots", "texture-powers", "texture-integer", "texture-placement", "texture-distance",
  "texture-centre", "texture-radius"];
const OWN_CONTROLS = ["map", "input", "detail", "outward", "alpha", "beta", "origin-shift", "texture", ...RANDOM_ROOTS, "frequency", "grain", "grain-turn", "texture-scale",
  "texture-translate", "iterations", "slice", "c", "power", "pair", "scheme", "f", "g", "theta", "mandelbrot", "resolution", "box",
  "colour"];

// An exported page does not know the program's defaults. These leave the texture as it is.
export const UNCHANGED = { "texture-scale": "1", "texture-translate": "0,0,0", "grain-turn": "0" };

const OWN_RAMP = "#101820,#c0392b,#f7dc6f";
const NO_GRAIN = "none", GRAINS = [NO_GRAIN, "along", "around", "curvature", "down"], OWN_GRAIN = "0,1,0";

// The other options, by the groups of the program's help.
const OTHER_GROUPS = [["More of the map and the texture", "map"], ["Space", "space"], ["Lattice", "lattice"], ["Surface", "surface"],
  ["Files", "output"]];

// The program's descriptions of its options. An exported page has none, and shows the options that need no server.
export class Options {
  constructor(start) {
    this.list = start.options ?? [];
    this.byName = new Map(this.list.map((option) => [option.name, option]));
    this.firstMap = start.maps?.[0]?.name ?? "shape-modulus";
  }

  mapOf(recipe) { return recipe.map ?? this.firstMap; }
  has(name, recipe) { return this.byName.get(name)?.maps.includes(this.mapOf(recipe)) ?? false; }
  // The words that an option takes.
  words(name) { return this.byName.get(name)?.argument.split("|") ?? []; }
  usual(name, recipe) { return name === "map" ? this.firstMap : this.byName.get(name)?.defaults?.[this.mapOf(recipe)]; }
  help(name) { return this.byName.get(name)?.help ?? ""; }

  // Sets an option, and removes those that would contradict it.
  set(recipe, name, value) {
    if (value === undefined) {
      delete recipe[name];
      return;
    }
    const option = this.byName.get(name);
    for (const other of [option?.alternative, ...(option?.displaces ?? [])]) if (other) delete recipe[other];
    recipe[name] = value;
  }
}

export function isRandomVersor(recipe) {
  return recipe.texture === "random" || (!recipe.texture && RANDOM_ROOTS.some((name) => name in recipe));
}

// Chooses a texture of the shelf, or random roots, and removes the options that only the previous texture could have.
export function chooseTexture(page, recipe, name, seed) {
  for (const option of RANDOM_ROOTS) delete recipe[option];
  page.options.set(recipe, "texture", name);
  if (seed !== undefined) recipe["texture-seed"] = seed;
  if (!mayFollowGrain(page, recipe)) setGrain(page, recipe, undefined);
  if (!followsThickness(page, recipe)) delete recipe.frequency;
}

// Whether the texture is one that can follow a grain.
export function mayFollowGrain({ options, start }, recipe) {
  if (isRandomVersor(recipe) || !options.has("grain", recipe)) return false;
  const name = recipe.texture ?? options.usual("texture", recipe);
  return name.startsWith("waves:") || start.textures.some((texture) => texture.name === name);
}

export function followsGrain(page, recipe) { return (recipe.grain ?? NO_GRAIN) !== NO_GRAIN && mayFollowGrain(page, recipe); }

// Sets the grain, and removes the options that cannot be with it or without it.
function setGrain(page, recipe, grain) {
  page.options.set(recipe, "grain", grain === NO_GRAIN ? undefined : grain);
  delete recipe[recipe.grain ? "texture-translate" : "grain-turn"];
}

export function variesBySeed({ options, start }, recipe) {
  const name = recipe.texture ?? options.usual("texture", recipe);
  return isRandomVersor(recipe) || start.textures.some((texture) => texture.varies && texture.name === name);
}

// Chooses another seed of the same texture, or random roots if the texture has nothing random. A seed alone would mean
// random roots.
export function setSeed(page, recipe, seed) {
  if (!isRandomVersor(recipe)) {
    if (!variesBySeed(page, recipe)) return chooseTexture(page, recipe, "random", seed);
    recipe.texture ??= page.options.usual("texture", recipe);
  }
  page.options.set(recipe, "texture-seed", seed);
}

// Whether the texture is one whose detail follows the target's local thickness.
export function followsThickness(page, recipe) {
  const { options, start } = page;
  if (isRandomVersor(recipe)) return false;
  if (followsGrain(page, recipe)) return true;
  const name = recipe.texture ?? options.usual("texture", recipe);
  return options.mapOf(recipe) === "shape-modulus" && start.textures.some((one) => one.followsThickness && one.name === name);
}

// All of the controls: {element, update(state)}. page: {store, options, start, scene(), isExported, ...actions}
export function makeControls(page) {
  const { store, options, start } = page, updates = [];
  const add = (control) => {
    updates.push(control.update);
    return control.element;
  };
  const usualOf = (name, live) => (state) => options.usual(name, state.recipe) ?? (live && page.scene() ? String(page.scene()[live]) : UNCHANGED[name] ?? "");
  // A slider of an option.
  const number = (name, label, limits, live) => add(slider(store, {
    label, name, help: options.help(name), ...limits, usual: usualOf(name, live), read: (state) => state.recipe[name],
    write: (state, value) => options.set(state.recipe, name, value),
  }));
  // The components of an option that is a list of numbers.
  const vector = (name, labels, limits, live) => labels.map((label, i) => {
    const parts = (state) => {
      const given = state.recipe[name] ?? options.usual(name, state.recipe) ?? (live ? page.scene()?.[live]?.join(",") : undefined) ?? "";
      const numbers = String(given).split(",").map(Number);
      return labels.map((_, k) => Number.isFinite(numbers[k]) ? numbers[k] : 0);
    };
    return add(slider(store, {
      label, name, help: options.help(name), ...limits, usual: (state) => String(parts(state)[i]),
      read: (state) => state.recipe[name] === undefined ? undefined : String(parts(state)[i]),
      write: (state, value) => {
        if (value === undefined) return options.set(state.recipe, name, undefined);
        const all = parts(state);
        all[i] = Number(value);
        options.set(state.recipe, name, all.join(","));
      },
    }));
  });
  const chosen = (name, label, values = options.words(name)) => add(choice(store, {
    label, name, help: options.help(name), values, usual: usualOf(name), read: (state) => state.recipe[name],
    write: (state, value) => options.set(state.recipe, name, value === usualOf(name)(state) ? undefined : value),
  }));
  const flag = (name, label) => add(tick(store, {
    label, name, help: options.help(name), usual: () => "", read: (state) => state.recipe[name],
    write: (state, value) => options.set(state.recipe, name, value),
  }));
  const line = (name, label) => add(text(store, {
    label, name, help: options.help(name), usual: usualOf(name), read: (state) => state.recipe[name],
    write: (state, value) => options.set(state.recipe, name, value),
  }));
  // Elements that are shown only for some recipes.
  const when = (test, ...children) => {
    const part = element("div", {}, ...children);
    updates.push((state) => { part.hidden = !test(state.recipe, state); });
    return part;
  };
  const map = (recipe) => page.isExported ? page.scene()?.map : options.mapOf(recipe);
  const isMap = (...names) => (recipe) => names.includes(map(recipe));

  const all = [];
  if (!page.isExported) {
    if (!start.target) all.push(mapControls());
    all.push(group("Look", ...textureControls(), ...depthControls(), ...colourControls(), ...lightControls()));
    all.push(originControls(), rootControls());
    if (start.target) all.push(mapControls());
  } else {
    const scene = page.scene();
    all.push(group("Look", ...colourControls(), ...lightControls()));
    if (scene.constant && scene.map !== "shape-modulus")
      all.push(group("Map", ...vector("c", ["c 1", "c 2", "c 3", "c 4"].slice(0, scene.constant.length), { min: -1.5, max: 1.5, step: 0.005 }, "constant")));
    if (scene.map === "mandelbulb") all.push(group("Power", number("power", "Power", { min: 1, max: 16, step: 0.25 }, "power")));
    if (scene.factors ?? scene.waves) all.push(group("Texture", ...rootPlaces()));
  }

  function mapControls() {
    const isOpen = (one) => one.target !== "needed" || start.target;
    return group("Map", chosen("map", "Map", start.maps.filter(isOpen).map((one) => one.name)),
      when(isMap("cross"), chosen("pair", "Pair"), chosen("scheme", "Scheme"),
        when((recipe) => recipe.pair === "user" || recipe.f || recipe.g, line("f", "f"), line("g", "g")),
        when((recipe) => recipe.scheme === "5", ...vector("c", ["c x", "c y", "c z"], { min: -2, max: 2, step: 0.01 }))),
      when(isMap("quadratic"), flag("mandelbrot", "Mandelbrot set"),
        when((recipe) => !recipe.mandelbrot, ...vector("c", ["c real", "c i", "c j", "c k"], { min: -1.5, max: 1.5, step: 0.005 }))),
      when(isMap("mandelbulb"), number("power", "Power", { min: 1, max: 16, step: 0.25 }), chosen("theta", "Second angle from"),
        line("c", "Constant of a Julia set")));
  }

  function rootPlaces() {
    return [number("texture-scale", "Scale of the texture", { min: 0.2, max: 5, scale: "log" }),
      when((recipe) => page.isExported || !followsGrain(page, recipe),
        ...vector("texture-translate", ["Move the roots X", "Move the roots Y", "Move the roots Z"], { min: -0.5, max: 0.5, step: 0.005 }))];
  }

  // The colour, its gradient and its range.
  function colourControls() {
    const byGradient = (recipe) => BY_GRADIENT.includes(colourOf(recipe).by), isOwn = (recipe) => !page.gradients.includes(colourOf(recipe).gradient);
    const set = (recipe, changes) => {
      const text = colourText({ ...colourOf(recipe), ...changes });
      if (text === undefined) delete recipe.colour;
      else recipe.colour = text;
    };
    const hasTarget = Boolean(start.target ?? page.scene()?.targetBox), kinds = (start.colours ?? COLOURS).filter((by) => by !== "depth" || hasTarget);
    // Empty fields show the numbers that occur.
    const occurs = (state, end) => {
      const known = page.scene() ? page.colourings.of(page.scene(), state.recipe)[end] : undefined;
      return known === undefined ? "" : String(Number(known.toPrecision(4)));
    };
    const end = (label, i, name) => add(text(store, {
      label, name: "colour", type: "number", help: "The number that has this end of the gradient. Empty: the gradient is spread over the numbers that occur.",
      usual: (state) => occurs(state, name), read: (state) => colourOf(state.recipe).range?.[i].toString(),
      write: (state, value) => {
        const range = colourOf(state.recipe).range ?? [occurs(state, "low"), occurs(state, "high")].map(Number);
        if (value !== undefined) range[i] = Number(value);
        set(state.recipe, { range: value === undefined ? null : range });
      },
    }));
    return [add(choice(store, {
      label: "Colour", name: "colour", help: options.help("colour"), values: kinds, usual: () => "clay",
      read: (state) => state.recipe.colour && colourOf(state.recipe).by,
      write: (state, value) => set(state.recipe, { by: value ?? "clay", range: null }),
    })),
    when(byGradient, add(choice(store, {
      label: "Gradient", name: "colour", help: options.help("colour"), values: [...page.gradients, { value: "own", text: "own ramp" }], usual: () => "viridis",
      read: (state) => isOwn(state.recipe) ? "own" : colourOf(state.recipe).gradient === "viridis" ? undefined : colourOf(state.recipe).gradient,
      write: (state, value) => set(state.recipe, { gradient: value === "own" ? OWN_RAMP : value ?? "viridis" }),
    })),
    when(isOwn, add(text(store, {
      label: "Its colours", name: "colour", help: "Two colours or more, from the lowest number to the highest: #101820,#c0392b,#f7dc6f.", usual: () => OWN_RAMP,
      read: (state) => colourOf(state.recipe).gradient, write: (state, value) => set(state.recipe, { gradient: value ?? "viridis" }),
    }))),
    element("div", { class: "pair" }, end("From", 0, "low"), end("to", 1, "high")))];
  }

  // The material and the light, as options of `juliavdb render`.
  function lightControls() {
    const { lighting } = page, read = (name) => (state) => state.look.options[name];
    const set = (name) => (state, value) => {
      state.look.options = { ...state.look.options };
      if (value === undefined || value === lighting.usual(name)) delete state.look.options[name];
      else state.look.options[name] = value;
    };
    const numbered = (name, label, limits) => add(slider(store, {
      label, name, help: lighting.help(name), ...limits, usual: () => lighting.usual(name), read: read(name), write: set(name),
    }));
    // A choice of names, with a field for any other text.
    const named = (name, label, values, { own, ownLabel, isNamed }) => {
      const isOwn = (state) => state.look.options[name] !== undefined && !isNamed(state.look.options[name]);
      return [add(choice(store, {
        label, name, help: lighting.help(name), values: [...values, ...(page.isExported ? [] : [{ value: "own", text: "own colour" }])],
        usual: () => lighting.usual(name), read: (state) => isOwn(state) ? "own" : state.look.options[name],
        write: (state, value) => set(name)(state, value === "own" ? own : value),
      })),
      when((_, state) => isOwn(state) && !page.isExported, add(text(store, {
        label: ownLabel, name, help: lighting.help(name), usual: () => own, read: read(name), write: set(name),
      })))];
    };
    return [
      ...named("material", "Material", [lighting.usual("material"), ...[...lighting.materials.keys()].sort().filter((one) => one !== lighting.usual("material"))], { own: "#c08040:satin", ownLabel: "Its colour", isNamed: (value) => lighting.isNamed(value) }),
      ...[["Light from the side", 0, -180, 180], ["Light from above", 1, -90, 90]].map(([label, i, min, max]) => {
        const usual = lightAngles(lighting.usual("light"));
        return add(slider(store, {
          label, name: "light", min, max, step: 1, help: lighting.help("light"), usual: () => String(usual[i]),
          read: (state) => {
            const angles = lightAngles(state.look.options.light);
            return angles && angles[i] !== usual[i] ? String(angles[i]) : undefined;
          },
          write: (state, value) => {
            const angles = lightAngles(state.look.options.light) ?? [...usual];
            angles[i] = value === undefined ? usual[i] : Number(value);
            set("light")(state, angles.join(","));
          },
        }));
      }),
      numbered("sky", "Sky", { min: 0, max: 3, step: 0.05 }), numbered("exposure", "Exposure", { min: -3, max: 3, step: 0.1 }),
      add(tick(store, { label: "Ground", name: "ground", help: lighting.help("ground"), usual: () => "", read: read("ground"), write: set("ground") })),
      ...named("background", "Background", [{ value: "", text: "neutral" }, { value: "none", text: "none" }], { own: "#203040", ownLabel: "Its colour", isNamed: (value) => value === "none" }),
    ];
  }

  function byAlpha(recipe) { return "alpha" in recipe || "beta" in recipe; }

  // How deep the detail goes.
  function depthControls() {
    return [when(isMap("shape-modulus"),
      when((recipe) => !byAlpha(recipe), number("detail", "Detail", { min: 0, max: 1, step: 0.01 }),
        number("outward", "Outward", { min: 0, max: 0.5, step: 0.01 })),
      when(byAlpha, number("alpha", "Alpha", { min: 1, max: 400, scale: "log" }), number("beta", "Beta", { min: -0.2, max: 0.2, step: 0.002 })))];
  }

  function originControls() {
    const drag = button("Drag the origin in the picture", () => page.dragOrigin(drag.getAttribute("aria-pressed") !== "true"),
      { "aria-pressed": "false", class: "wide" });
    page.onDragOrigin = (on) => drag.setAttribute("aria-pressed", String(on));
    const part = group("Mask and origin",
      line("mask", "Mask"),
      ...vector("origin-shift", ["Origin X", "Origin Y", "Origin Z"], { min: -0.4, max: 0.4, step: 0.005 }), drag,
      add(choice(store, {
        label: "Depth given by", values: [{ value: "detail", text: "detail, outward" }, { value: "alpha", text: "alpha, beta" }],
        usual: () => "detail", read: (state) => byAlpha(state.recipe) ? "alpha" : undefined,
        write: (state, value) => {
          for (const name of ["detail", "outward", "alpha", "beta"]) delete state.recipe[name];
          if (value === "alpha") Object.assign(state.recipe, { alpha: "40", beta: "0" });
        },
      })));
    updates.push((state) => { part.hidden = !isMap("shape-modulus")(state.recipe); });
    return part;
  }

  // The directions that the texture follows.
  function grainControls() {
    const isOwn = ({ grain }) => grain !== undefined && !GRAINS.includes(grain);
    const write = (state, value) => setGrain(page, state.recipe, value);
    return [add(choice(store, {
      label: "Grain", name: "grain", help: options.help("grain"), values: [...GRAINS, { value: "own", text: "other" }], usual: usualOf("grain"),
      read: ({ recipe }) => isOwn(recipe) ? "own" : recipe.grain, write: (state, value) => write(state, value === "own" ? OWN_GRAIN : value),
    })),
    when(isOwn, add(text(store, {
      label: "Its directions", name: "grain", help: options.help("grain"), usual: () => OWN_GRAIN, read: (state) => state.recipe.grain, write,
    }))),
    when((recipe) => followsGrain(page, recipe), number("grain-turn", "Turn of the grain", { min: -90, max: 90, step: 1 }))];
  }

  // The shelf, the seed, the frequency and the grain.
  function textureControls() {
    const choose = (name) => store.change((state) => chooseTexture(page, state.recipe, name));
    const random = { name: "random", description: "Roots at random: every seed is another texture.", thumbnail: "page/texture-random.jpg" };
    page.tiles = new Map();
    const tiles = [random, ...start.textures].map((texture) => {
      const image = element("img", { src: texture.thumbnail, alt: "", width: 64, height: 64 });
      page.tiles.set(texture.name, image);
      const tile = button("", () => choose(texture.name), { class: "tile", title: texture.description, "aria-pressed": "false" });
      tile.append(image, element("span", {}, texture.name));
      updates.push((state) => {
        const usual = options.usual("texture", state.recipe) ?? "scales";
        const now = isRandomVersor(state.recipe) ? "random" : state.recipe.texture ?? usual;
        tile.setAttribute("aria-pressed", String(now === texture.name));
      });
      return tile;
    });
    const seedBy = (by) => () => store.change((state) => {
      setSeed(page, state.recipe, String(Math.max(0, Number(state.recipe["texture-seed"] ?? 1) + by)));
    });
    const seed = add(slider(store, {
      label: "Seed", name: "texture-seed", help: options.help("texture-seed"), min: 0, max: 200, step: 1, usual: usualOf("texture-seed"),
      read: (state) => state.recipe["texture-seed"],
      write: (state, value) => {
        if (value === undefined) options.set(state.recipe, "texture-seed", undefined);
        else setSeed(page, state.recipe, value);
      },
    }));
    return [when((recipe) => options.has("texture", recipe),
      element("div", { class: "shelf", role: "group", "aria-label": "Textures" }, ...tiles),
      when((recipe) => variesBySeed(page, recipe), seed,
        element("div", { class: "buttons" }, button("← previous seed", seedBy(-1)), button("next seed →", seedBy(1)))),
      when((recipe) => followsThickness(page, recipe), chosen("frequency", "Frequency", ["coarse", "medium", "fine"])),
      when((recipe) => mayFollowGrain(page, recipe), ...grainControls()))];
  }

  // The other options of a texture.
  function rootControls() {
    const usualPowers = (state) => options.usual("texture-powers", state.recipe) ?? "";
    const powers = (label, i) => add(slider(store, {
      label, name: "texture-powers", help: options.help("texture-powers"), min: 1, max: 20, step: 1,
      usual: (state) => usualPowers(state).split(":")[i],
      read: (state) => state.recipe["texture-powers"]?.split(":")[i],
      write: (state, value) => {
        if (value === undefined) return options.set(state.recipe, "texture-powers", undefined);
        const range = (state.recipe["texture-powers"] ?? usualPowers(state)).split(":").map(Number);
        range[i] = Number(value);
        options.set(state.recipe, "texture-powers", i === 0 ? `${range[0]}:${Math.max(...range)}` : `${Math.min(...range)}:${range[1]}`);
      },
    }));
    const part = group("Scale and place of the texture",
      when(isRandomVersor, number("texture-roots", "Roots", { min: 1, max: 60, step: 1 }), powers("Least power", 0), powers("Greatest power", 1),
        flag("texture-integer", "Whole powers"), chosen("texture-placement", "Placed"),
        when((recipe) => recipe["texture-placement"] === "surface", line("texture-distance", "How far from it")),
        when((recipe) => recipe["texture-placement"] === "cluster", line("texture-centre", "Centre of the cluster"), line("texture-radius", "Its radius"))),
      ...rootPlaces());
    updates.push((state) => { part.hidden = !options.has("texture", state.recipe); });
    return part;
  }

  all.push(group("Orbit", number("iterations", "Iterations", { min: 1, max: 12, step: 1 }, "iterations"),
    when((recipe) => ["shape-modulus", "rational", "quadratic"].includes(map(recipe)), number("slice", "Slice", { min: -1, max: 1, step: 0.01 }, "slice"))));

  const look = (name, read, write) => ({ read: (state) => read(state.look), write: (state, value) => write(state.look, value) });
  all.push(group("Picture",
    add(choice(store, {
      label: "Cut open along", values: [{ value: "", text: "nothing" }, { value: "x", text: "X" }, { value: "y", text: "Y" }, { value: "z", text: "Z" }],
      usual: () => "", ...look("clip", (it) => it.clip.axis || undefined, (it, value) => { it.clip.axis = value ?? ""; }),
    })),
    when((_, state) => state.look.clip.axis !== "",
      add(slider(store, {
        label: "Where it is cut", min: 0, max: 1, step: 0.005, usual: () => "0.5",
        ...look("at", (it) => it.clip.at === 0.5 ? undefined : String(it.clip.at), (it, value) => { it.clip.at = value === undefined ? 0.5 : Number(value); }),
      })),
      add(tick(store, {
        label: "Keep the other side", usual: () => "",
        ...look("flip", (it) => it.clip.flip ? "true" : undefined, (it, value) => { it.clip.flip = value === "true"; }),
      }))),
    add(slider(store, {
      label: "Rays a pixel", min: 0, max: 16, step: 1, help: "At rest; 0 leaves it to the speed of the graphics.", usual: () => "0",
      ...look("samples", (it) => it.samples === 0 ? undefined : String(it.samples), (it, value) => { it.samples = value === undefined ? 0 : Math.round(Number(value)); }),
    }))));

  if (!page.isExported) {
    const others = options.list.filter((option) => !OWN_CONTROLS.includes(option.name) && option.group !== "target");
    for (const [title, name] of OTHER_GROUPS) {
      const own = others.filter((option) => option.group === name);
      if (own.length === 0) continue;
      const part = group(title, ...own.map((option) =>
        when((recipe) => options.has(option.name, recipe), option.argument ? line(option.name, option.name) : flag(option.name, option.name))));
      updates.push((state) => { part.hidden = !own.some((option) => options.has(option.name, state.recipe)); });
      all.push(part);
    }
    // The most important groups are open; the others are found by their titles, or by typing.
    for (const part of all) part.open = part === all[0] || (!start.target && part === all[1]);
  }
  const list = element("div", { class: "controls" }, ...all), found = page.isExported ? null : finder(all);
  return {
    element: found ? element("div", { class: "controls-box" }, found.element, list) : list,
    update: (state) => {
      for (const update of updates) update(state);
      found?.update();
    },
    tell: tellBeside(list),
  };
}

// Shows a refusal of the program next to the control of the option that it names. about: what was refused, e.g. "scene";
// a later call with the same value replaces the text, and empty words remove it.
function tellBeside(list) {
  const told = new Map();
  return (about, words) => {
    told.get(about)?.remove();
    told.delete(about);
    const name = /--([a-z][a-z0-9-]*)/.exec(words)?.[1];
    if (!name) return;
    const all = [...list.querySelectorAll(`.control[data-name="${name}"]`)], shown = all.filter((one) => !one.closest("[hidden]"));
    const place = shown.at(-1) ?? all.at(-1);
    if (!place) return;
    const note = element("p", { class: "control-error", role: "alert" }, words);
    (place.closest(".pair") ?? place).after(note);
    told.set(about, note);
  };
}

// A search field. Only controls that contain all of its words, in their label, their option or its help, stay visible.
function finder(groups) {
  const input = element("input", { type: "search", placeholder: "Find a control: mask, iterations, tolerance …", "aria-label": "Find a control",
    spellcheck: "false", autocomplete: "off" });
  const note = element("span", { class: "note", role: "status" });
  let wasOpen = null;
  const find = () => {
    const words = input.value.toLowerCase().split(/\s+/).filter(Boolean), isFinding = words.length > 0;
    if (isFinding && !wasOpen) wasOpen = groups.map((part) => part.open);
    let count = 0;
    groups.forEach((part, i) => {
      const title = part.querySelector("summary").textContent.toLowerCase();
      let found = 0;
      for (const control of part.querySelectorAll(".control, .shelf, .buttons, .wide")) {
        const says = `${title} ${control.textContent} ${control.title} ${control.dataset.name ?? ""}`.toLowerCase();
        const isFound = words.every((word) => says.includes(word));
        control.classList.toggle("unfound", isFinding && !isFound);
        if (isFound && !control.closest("[hidden]")) ++found;
      }
      part.classList.toggle("unfound", isFinding && found === 0);
      if (isFinding) part.open = found > 0;
      else if (wasOpen) part.open = wasOpen[i];
      count += found;
    });
    if (!isFinding) wasOpen = null;
    note.textContent = !isFinding ? "" : count === 0 ? "No control of this map has these words." : "";
  };
  input.addEventListener("input", find);
  input.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || input.value === "") return;
    input.value = "";
    find();
  });
  return {
    element: element("div", { class: "finder" }, input, note),
    // Another map has other controls.
    update: () => {
      if (wasOpen) find();
    },
  };
}

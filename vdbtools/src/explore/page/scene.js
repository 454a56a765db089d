// SPDX-License-Identifier: Apache-2.0
// A scene as described by the server or an exported page, prepared for the shaders.

// 16-bit floats as numbers, by their bits.
const HALVES = (() => {
  const table = new Float32Array(65536);
  for (let bits = 0; bits < 65536; ++bits) {
    const sign = bits & 0x8000 ? -1 : 1, exponent = bits >> 10 & 31, mantissa = bits & 1023;
    table[bits] = sign * (exponent === 0 ? mantissa * 2 ** -24
      : exponent === 31 ? (mantissa ? NaN : Infinity) : (1 + mantissa / 1024) * 2 ** (exponent - 15));
  }
  return table;
})();

export function bytesOfBase64(text) {
  const binary = atob(text.trim()), bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

// The distance of each cube to the nearest occupied one, in cubes along the axis where it is largest: at most 255.
export function distancesToOccupied(occupied, [nx, ny, nz]) {
  const distances = new Uint8Array(occupied.length);
  for (let i = 0; i < occupied.length; ++i) distances[i] = occupied[i] ? 0 : 255;
  const sweep = (sign) => {
    // The 13 neighbours that precede a cube in the order of the sweep.
    const before = [];
    for (let dz = -1; dz <= 1; ++dz)
      for (let dy = -1; dy <= 1; ++dy)
        for (let dx = -1; dx <= 1; ++dx)
          if (dz < 0 || (dz === 0 && (dy < 0 || (dy === 0 && dx < 0)))) before.push([sign * dx, sign * dy, sign * dz]);
    const last = occupied.length - 1;
    for (let step = 0; step <= last; ++step) {
      const at = sign > 0 ? step : last - step;
      let least = distances[at];
      if (least === 0) continue;
      const x = at % nx, y = Math.floor(at / nx) % ny, z = Math.floor(at / nx / ny);
      for (const [dx, dy, dz] of before) {
        const X = x + dx, Y = y + dy, Z = z + dz;
        if (X < 0 || Y < 0 || Z < 0 || X >= nx || Y >= ny || Z >= nz) continue;
        const there = distances[(Z * ny + Y) * nx + X] + 1;
        if (there < least) least = there;
      }
      distances[at] = least;
    }
  };
  sweep(1);
  sweep(-1);
  return distances;
}

const CUBE = 4;  // cells of the exponent along the side of a cube

// Where E is at least ln(escape), the first step decides that a point is outside.
function cubesOfExponent(exponent, volume, logEscape) {
  const [nx, ny, nz] = exponent.dims;
  const count = exponent.dims.map((n) => Math.max(1, Math.ceil((n - 1) / CUBE)));
  const occupied = new Uint8Array(count[0] * count[1] * count[2]);
  // Texture units interpolate with weights of 8 bits, so values this close to the bound are not skipped.
  const least = logEscape + 1e-3 * Math.max(1, Math.abs(exponent.high), Math.abs(exponent.low));
  for (let z = 0; z < nz; ++z)
    for (let y = 0; y < ny; ++y) {
      const row = (z * ny + y) * nx;
      for (let x = 0; x < nx; ++x) {
        if (HALVES[volume[row + x]] >= least) continue;
        // A node on a face belongs to the cubes on both sides.
        for (let k = Math.max(0, Math.ceil(z / CUBE) - 1); k <= Math.min(count[2] - 1, Math.floor(z / CUBE)); ++k)
          for (let j = Math.max(0, Math.ceil(y / CUBE) - 1); j <= Math.min(count[1] - 1, Math.floor(y / CUBE)); ++j)
            for (let i = Math.max(0, Math.ceil(x / CUBE) - 1); i <= Math.min(count[0] - 1, Math.floor(x / CUBE)); ++i)
              occupied[(k * count[1] + j) * count[0] + i] = 1;
      }
    }
  const m = exponent.matrix;
  const side = [0, 1, 2].map((axis) => CUBE / m[axis][axis]);
  return {
    count, side,
    origin: [0, 1, 2].map((axis) => -exponent.offset[axis] / m[axis][axis]),
    distances: distancesToOccupied(occupied, count),
  };
}

function cubesOfOccupancy(occupancy) {
  const bits = bytesOfBase64(occupancy.bits), [nx, ny, nz] = occupancy.dims;
  const occupied = new Uint8Array(nx * ny * nz);
  for (let i = 0; i < occupied.length; ++i) occupied[i] = bits[i >> 3] >> (i & 7) & 1;
  return {
    count: occupancy.dims, side: [occupancy.cell, occupancy.cell, occupancy.cell], origin: occupancy.origin,
    distances: distancesToOccupied(occupied, occupancy.dims),
  };
}

function isAlongAxes(matrix) {
  return matrix.every((row, i) => row.every((value, j) => i === j ? value > 0 : Math.abs(value) < 1e-9));
}

// The description, the volumes (Uint16Arrays of half floats, or null) and further data for the shaders.
// recipe: the recipe from which the scene was made.
export function makeScene(description, volume, grainVolume, recipe) {
  const logEscape = Math.log(description.escape), { exponent, occupancy } = description;
  const cubes = exponent ? (isAlongAxes(exponent.matrix) ? cubesOfExponent(exponent, volume, logEscape) : null)
    : occupancy ? cubesOfOccupancy(occupancy) : null;
  return { ...description, volume, grainVolume, recipe: { ...recipe }, logEscape, cubes };
}

const numbersIn = (text, count) => {
  const numbers = String(text).split(",").map(Number);
  if (numbers.some((value) => !Number.isFinite(value))) return null;
  while (numbers.length < count) numbers.push(0);
  return numbers.slice(0, count);
};

// The options that the shaders can apply before the server has made the scene; the others wait. Each function takes the
// value in the recipe and the one from which the scene was made.
export const LIVE_OPTIONS = ["iterations", "slice", "c", "power", "texture-scale", "texture-translate", "origin-shift"];
// Whether the shaders apply such an option to a scene: the phases of a grain are made for one scale and one place.
export function isApplied(name, scene) { return !(scene?.grain && ["texture-scale", "texture-translate"].includes(name)); }

// The numbers of the orbit for another recipe: those of the scene if the recipes agree.
export function liveValues(scene, recipe) {
  const differs = (name) => isApplied(name, scene) && (recipe[name] ?? "") !== (scene.recipe[name] ?? "");
  const live = {
    iterations: scene.iterations, slice: scene.slice, logTrap: scene.logTrap, constant: scene.constant ?? null,
    power: scene.power ?? 8, factors: scene.factors ?? [], originShift: [0, 0, 0], exact: true,
    waveOrigin: scene.waves?.origin ?? [0, 0, 0, 0], waveScale: 1,
  };
  const changed = LIVE_OPTIONS.filter(differs);
  if (changed.length === 0) return live;
  live.exact = false;
  // The trap was proved for the original scene.
  live.logTrap = null;
  const given = (name, usual) => Number(recipe[name] ?? usual);
  if (differs("iterations") && given("iterations", 0) >= 1) live.iterations = Math.round(given("iterations", 3));
  if (differs("slice")) live.slice = given("slice", 0) || 0;
  if (differs("power") && Number.isFinite(given("power", 8))) live.power = given("power", 8);
  if (differs("c") && recipe.c && scene.constant) live.constant = numbersIn(recipe.c, 4) ?? live.constant;
  if (differs("texture-scale") || differs("texture-translate")) {
    const at = (r) => ({
      scale: Number(r["texture-scale"] ?? 1) || 1, move: numbersIn(r["texture-translate"] ?? "0,0,0", 3) ?? [0, 0, 0],
    });
    const from = at(scene.recipe), to = at(recipe), k = to.scale / from.scale;
    // The components that are not dropped are the coordinates of space.
    const places = { i: [0, 2, 3], j: [0, 1, 3], k: [0, 1, 2] }[scene.dropAxis];
    const part = (move, c) => places.indexOf(c) < 0 ? 0 : move[places.indexOf(c)];
    live.factors = live.factors.map((factor) =>
      factor.map((value, c) => c < 4 ? (value - part(from.move, c)) * k + part(to.move, c) : value));
    live.waveOrigin = live.waveOrigin.map((value, c) => value - part(from.move, c) + part(to.move, c));
    live.waveScale = 1 / k;
  }
  if (differs("origin-shift")) {
    const from = numbersIn(scene.recipe["origin-shift"] ?? "0,0,0", 3), to = numbersIn(recipe["origin-shift"] ?? "0,0,0", 3);
    if (from && to) live.originShift = to.map((value, axis) => value - from[axis]);
  }
  return live;
}

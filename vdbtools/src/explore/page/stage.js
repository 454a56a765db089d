// SPDX-License-Identifier: Apache-2.0
// Decides what is drawn when: a coarse picture at once while something moves, a fine one at rest, and the pictures of
// other looks when there is nothing else to do, or before everything else while they cover the stage.
import { Exposure } from "./renderer.js";

const FRAME = 30;  // milliseconds that a coarse picture may take
const STRIP = 40;  // the same for the rows of a fine one that are requested at once
const SMALL = 300;  // the same for a picture of another look, if the GPU is fast enough for finer ones
const PATIENCE = 3000;  // how long the picture at rest becomes finer by default
const MOST_PIXELS = 2.5e6;

const isClear = (shot) => shot?.look.light.background === "none";

const srgbOf = (linear) => {
  const value = Math.min(1, Math.max(0, linear));
  return Math.round(255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055));
};

// An image of linear values, given from the lowest row up.
// isClear: the background has no colour, and the colours are multiplied by the coverage.
export function imageOf(values, width, height, isClear = false) {
  const image = new ImageData(width, height);
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x) {
      const from = 4 * ((height - 1 - y) * width + x), to = 4 * (y * width + x);
      const cover = isClear ? Math.min(1, Math.max(0, values[from + 3])) : 1;
      for (let c = 0; c < 3; ++c) image.data[to + c] = srgbOf(values[from + c] / (cover || 1));
      image.data[to + 3] = Math.round(255 * cover);
    }
  return image;
}

export class Stage {
  // renderer: null where there is no WebGL 2; then nothing is drawn, and requests for pictures fail by `why`.
  // onState(text, share): the state of the picture; share 1 when it is as fine as possible.
  constructor(canvas, renderer, { why = "", onState, onError }) {
    Object.assign(this, { canvas, renderer, why, onState, onError });
    this.wanted = null;
    this.isMoving = false;
    this.isDirty = false;
    this.coarse = this.fine = this.shown = this.small = null;
    this.smalls = [];
    this.isCovered = false;
    this.frame = 0;
    this.waiting = [];
  }

  // Whether a movement is not visible yet.
  get isDrawing() { return this.isDirty || Boolean(this.coarse); }
  get aspect() { return this.canvas.width / this.canvas.height; }

  // Adopts the size of the element on the page.
  fit() {
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    let width = Math.max(16, Math.round(this.canvas.clientWidth * ratio)), height = Math.max(16, Math.round(this.canvas.clientHeight * ratio));
    const shrink = Math.min(1, Math.sqrt(MOST_PIXELS / (width * height)));
    width = Math.round(width * shrink);
    height = Math.round(height * shrink);
    if (width === this.canvas.width && height === this.canvas.height) return false;
    this.canvas.width = width;
    this.canvas.height = height;
    if (this.shown) this.show();
    return true;
  }

  // shot: {scene, live, view, look}
  draw(shot, isMoving) {
    this.wanted = shot;
    this.isMoving = isMoving;
    this.isDirty = true;
    this.fine?.free();
    this.fine = null;
    this.schedule();
  }

  // The picture of a shot apart from that on the stage: {image, values}, where values are linear, with the coverage,
  // from the lowest row up; null if it was dropped. owner: its requester; owners of lower rank come first.
  // isFiner: with more rays per pixel, if the GPU is fast, up to those of the look.
  drawSmall(shot, width, height, { owner = "", rank = 0, isFiner = false } = {}) {
    return new Promise((resolve, reject) => {
      const at = this.smalls.findIndex((one) => one.rank > rank);
      this.smalls.splice(at < 0 ? this.smalls.length : at, 0, { shot, width, height, owner, rank, isFiner, resolve, reject });
      this.schedule();
    });
  }
  dropSmalls(owner) {
    const dropped = this.smalls.filter((one) => one.owner === owner);
    this.smalls = this.smalls.filter((one) => one.owner !== owner);
    if (this.small?.owner === owner) {
      this.small.exposure.free();
      dropped.push(this.small);
      this.small = null;
    }
    for (const { resolve } of dropped) resolve(null);
  }
  // Other pictures come first while they cover the stage.
  cover(on) {
    this.isCovered = on;
    this.schedule();
  }

  // Resolves when the picture is as fine as possible.
  settled() {
    return new Promise((resolve) => {
      this.waiting.push(resolve);
      this.schedule();
    });
  }

  schedule() {
    if (this.frame === 0) this.frame = requestAnimationFrame(() => {
      this.frame = 0;
      try {
        if (this.tick()) this.schedule();
      } catch (error) {
        this.coarse = this.fine = this.wanted = null;
        this.isDirty = false;
        this.onError(error);
      }
    });
  }

  // Whether there is more to do.
  tick() {
    if (!this.renderer) return this.drawNothing();
    if (!this.renderer.isIdle()) return true;
    if (this.isCovered && (this.small || this.smalls.length > 0)) return this.tickSmall();
    const { width, height } = this.canvas;
    if (this.isDirty && !this.coarse && this.wanted) {
      const divisor = [1, 2, 4, 8].find((by) => width * height / (by * by) / this.renderer.rate < FRAME) ?? 8;
      this.divisor = divisor;
      this.begun = performance.now();
      this.coarse = new Exposure(this.renderer, Math.ceil(width / divisor), Math.ceil(height / divisor), this.wanted, { samples: 1, axes: 3 });
      this.isDirty = false;
    }
    if (this.coarse) {
      this.renderer.handOver(this.coarse.advance(FRAME));
      if (!this.coarse.isDone) return true;
      this.shown?.free();
      this.shown = this.coarse;
      this.coarse = null;
      this.show();
      if (!this.isDirty && !this.isMoving) this.beginFine((performance.now() - this.begun) * this.divisor ** 2);
      return true;
    }
    if (this.fine) {
      this.renderer.handOver(this.fine.advance(STRIP));
      this.show();
      const isLate = this.fine.row === 0 && !this.wanted.look.samples && performance.now() - this.begun > PATIENCE;
      if (isLate) this.fine.finish();
      this.onState(this.fine.isDone ? "done" : "fine", this.fine.share);
      if (!this.fine.isDone) return true;
      this.shown?.free();
      this.shown = this.fine;
      this.fine = null;
      return true;
    }
    if (this.wanted && !this.isDirty && !this.isMoving) {
      for (const resolve of this.waiting) resolve();
      this.waiting = [];
    }
    return this.tickSmall();
  }

  drawNothing() {
    this.isDirty = false;
    for (const { reject } of this.smalls) reject(new Error(this.why));
    for (const resolve of this.waiting) resolve();
    this.smalls = [];
    this.waiting = [];
    return false;
  }

  // once: the expected time for one ray per pixel, milliseconds
  beginFine(once) {
    const { width, height } = this.canvas;
    this.fine = new Exposure(this.renderer, width, height, this.wanted,
      { samples: this.wanted.look.samples || (once > PATIENCE ? 1 : 16), axes: 13 });
    this.begun = performance.now();
    this.onState("fine", 0);
  }

  tickSmall() {
    const next = this.small ?? this.smalls.shift();
    if (!next) return false;
    const { shot, width, height, isFiner, resolve, reject } = next;
    try {
      if (!this.small) {
        const most = Math.min(8, shot.look.samples || 8);
        const samples = isFiner ? Math.min(most, Math.max(1, Math.floor(SMALL * this.renderer.rate / (width * height)))) : 1;
        this.small = { ...next, exposure: new Exposure(this.renderer, width, height, shot, { samples, axes: 13 }) };
      }
      const { exposure } = this.small;
      this.renderer.handOver(exposure.advance(STRIP));
      if (exposure.isDone) {
        const values = this.renderer.read(exposure.picture);
        exposure.free();
        this.small = null;
        resolve({ image: imageOf(values, width, height, isClear(shot)), values });
      }
    } catch (error) {
      this.small?.exposure.free();
      this.small = null;
      reject(error);
    }
    return true;
  }

  // The finest rows so far.
  show() {
    const fine = this.fine;
    const show = (one, ...rows) => this.renderer.show(one, rows[0], isClear(this.wanted));
    if (fine?.picture) return show(fine.picture);
    if (this.shown?.picture) show(this.shown.picture);
    if (fine) show(fine.targets[0], fine.row);
  }

  // The finest picture so far as an image, for a file.
  image() {
    const from = this.fine?.picture ?? this.shown?.picture;
    return from ? imageOf(this.renderer.read(from), from.width, from.height, isClear(this.wanted)) : null;
  }
}

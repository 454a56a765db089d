// SPDX-License-Identifier: Apache-2.0
// The textures of the shelf on the user's own target, made one after another when nothing else is to be done.
import { viewAround } from "./camera.js";
import { chooseTexture } from "./controls.js";
import { usualLook } from "./store.js";

const THUMBNAILS_OWNER = "thumbnails", RANK = 9;
const NODES = 64, SIDE = 80;  // of the exponent, and pixels of the page
const PATIENCE_EACH = 8000;  // milliseconds; if a scene takes longer, the pictures stay those of another target
const REST = 300;

const rest = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

// tiles: Map of name and image element. page: {stage, start, options, sceneFor, shotOf, isBusy(), say}
export class Thumbnails {
  constructor(page, tiles) {
    Object.assign(this, { page, tiles, asking: null, left: [...tiles.keys()] });
  }

  // Other requests do not wait for a thumbnail.
  giveWay() {
    this.asking?.abort();
    this.page.stage.dropSmalls(THUMBNAILS_OWNER);
  }

  // Textures whose picture is not made yet keep that of another target.
  stop() {
    this.left = [];
    this.giveWay();
  }

  async make() {
    const { page } = this;
    await page.stage.settled();
    while (this.left.length > 0) {
      if (page.isBusy() || document.hidden) {
        await rest(REST);
        continue;
      }
      const name = this.left[0], begun = performance.now(), { signal } = this.asking = new AbortController();
      try {
        const recipe = { ...page.start.recipe };
        delete recipe.colour;
        chooseTexture(page, recipe, name);
        const scene = await page.sceneFor(recipe, NODES, signal);
        if (signal.aborted) continue;
        const side = Math.max(16, Math.round(SIDE * Math.min(2, window.devicePixelRatio || 1)));
        const shot = page.shotOf(scene, { recipe, view: viewAround(scene.frame), look: usualLook() });
        const made = await page.stage.drawSmall(shot, side, side, { owner: THUMBNAILS_OWNER, rank: RANK });
        if (!made) continue;
        const canvas = document.createElement("canvas");
        Object.assign(canvas, { width: side, height: side });
        canvas.getContext("2d").putImageData(made.image, 0, 0);
        const image = this.tiles.get(name);
        image.src = canvas.toDataURL("image/png");
        image.dataset.own = "true";
      } catch (error) {
        // A texture that this recipe cannot have keeps its picture, and all do if the server is gone.
        if (error.name !== "AbortError" && error.status === undefined) return;
        if (error.name === "AbortError") continue;
      }
      this.left.shift();
      if (performance.now() - begun > PATIENCE_EACH) return;
    }
  }
}

// SPDX-License-Identifier: Apache-2.0
import { viewAround } from "./camera.js";
import { Exposure, Renderer } from "./renderer.js";
import { bytesOfBase64, liveValues, makeScene } from "./scene.js";

const canvas = document.createElement("canvas");
canvas.width = canvas.height = 150;
document.body.append(canvas);
const exported = JSON.parse(document.getElementById("exported").textContent);
const bytes = bytesOfBase64(document.getElementById("exported-volume").textContent);
const inflated = bytes.length < 20 ? new ArrayBuffer(0) : await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
const scene = makeScene(exported.scene, new Uint16Array(inflated), exported.recipe);
const renderer = new Renderer(canvas);
const look = { colour: "direction" };
const shot = { scene, live: liveValues(scene, exported.recipe), view: viewAround(scene.frame), look };
const t0 = performance.now();
const exposure = new Exposure(renderer, 150, 150, shot, { samples: 1, axes: 3 });
const tick = () => {
  window.dbg = [exposure.pass, exposure.row, renderer.rate, (window.dbg?.[3]??0)+1];
  if (renderer.isIdle()) {
    if (exposure.picture) renderer.show(exposure.picture);
    if (exposure.isDone) { window.done = performance.now() - t0; window.rate = renderer.rate; window.picture = Array.from(renderer.read(exposure.picture)); return; }
    renderer.handOver(exposure.advance(100));
  }
  requestAnimationFrame(tick);
};
tick();

// SPDX-License-Identifier: Apache-2.0
// Sends the rays. A picture is made in strips of rows, each so small that the GPU takes only a moment for it, so that
// the page stays responsive on any GPU: first a coarse picture, then a fine one, then the mean of several pictures with
// rays at other places in their pixels.
import { bytesOfBase64 } from "./scene.js";
import { DISPLAY_SHADER, fragmentShader, VERTEX_SHADER } from "./shaders.js";

// In the order of the shader's numbers.
const COLOURINGS = ["direction", "versor", "iterations", "trap", "clay", "depth"];
export const COLOURS = ["clay", "trap", "depth", "iterations", "direction", "versor"];
// The gradients of vdbtools/picture/gradient.h: colours at equal distances.
const codes = (text) => text.split(" ").map((code) => [0, 2, 4].map((at) => parseInt(code.slice(at, at + 2), 16) / 255));
export const GRADIENTS = {
  viridis: codes("440154 482878 3e4989 31688e 26828e 1f9e89 35b779 6ece58 b5de2b fde725"),
  magma: codes("000004 180f3d 440f76 721f81 9e2f7f cd4071 f1605d fd9668 feca8d fcfdbf"),
  inferno: codes("000004 1b0c41 4a0c6b 781c6d a52c60 cf4446 ed6925 fb9b06 f7d13d fcffa4"),
  cividis: codes("00224e 123570 3b496c 575d6d 707173 8a8678 a59c74 c3b369 e1cc55 fee838"),
  coolwarm: codes("3b4cc0 6282ea 8db0fe b8d0f9 dddddd f5c4ad f49a7b de604d b40426"),
  grey: codes("000000 ffffff"),
};
const LEAST_PIXELS = 2000;  // the minimum number per request

const subtract = (a, b) => a.map((value, i) => value - b[i]);
const scaledBy = (a, k) => a.map((value) => value * k);
const dotOf = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const crossOf = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unitOf = (a) => scaledBy(a, 1 / Math.hypot(...a));

// The directions of a camera: those of vdbtools/src/render/camera.cpp.
export function cameraFrame(view) {
  const forward = unitOf(subtract(view.lookAt, view.eye));
  let up = unitOf(view.up);
  if (Math.hypot(...crossOf(forward, up)) < 1e-6) up = Math.abs(forward[2]) < 0.5 ? [0, 0, -1] : [0, 1, 0];
  const right = unitOf(crossOf(forward, up));
  return { forward, right, up: crossOf(right, forward), tangent: Math.tan(view.fov * Math.PI / 360) };
}

// The directions of the light: see previewStage() in vdbtools/render/shading.h.
export function lightDirections(light, view, frame) {
  const sky = unitOf(view.up), front = unitOf(crossOf(frame.right, sky));
  const [azimuth, elevation] = light.light.map((degrees) => degrees * Math.PI / 180);
  const sum = (right, above, ahead) => unitOf([0, 1, 2].map((i) => right * frame.right[i] + above * sky[i] + ahead * front[i]));
  return { sky, key: sum(Math.sin(azimuth) * Math.cos(elevation), Math.sin(elevation), Math.cos(azimuth) * Math.cos(elevation)), rim: sum(0.95, 0.30, -0.25) };
}

// The Halton sequence, in which any number of samples covers a pixel evenly.
function halton(index, base) {
  let result = 0, part = 1 / base;
  for (let rest = index; rest > 0; rest = Math.floor(rest / base), part /= base) result += part * (rest % base);
  return result;
}

export class Renderer {
  constructor(canvas) {
    this.canvas = canvas;
    const gl = canvas.getContext("webgl2", {
      antialias: false, alpha: false, preserveDrawingBuffer: true, powerPreference: "high-performance",
    });
    if (!gl) throw new Error("This browser has no WebGL 2, which the live picture needs.");
    this.gl = gl;
    this.floats = gl.getExtension("EXT_color_buffer_float") ?? gl.getExtension("EXT_color_buffer_half_float");
    this.programs = new Map();
    this.volumes = new Map();
    this.grains = new Map();
    this.corners = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.corners);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([-1, -1, 3, -1, -1, 3]), gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    this.display = this.program(DISPLAY_SHADER);
    this.gradients = new Map();
    this.nothing = this.texture2D(1, 1, new Uint8Array(4));
    this.nothing3D = this.texture3D([1, 1, 1], new Uint8Array(1), gl.R8, gl.UNSIGNED_BYTE, gl.NEAREST);
    this.rate = 20;  // pixels per millisecond, measured; it starts low, so that nothing is blocked
    this.fence = null;
    this.latency = 200;  // milliseconds between requesting nearly nothing and learning that it is done
  }

  // ---- data on the GPU ----

  program(source) {
    const gl = this.gl, known = this.programs.get(source);
    if (known) return known;
    const compiled = (type, text) => {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      return shader;
    };
    const program = gl.createProgram();
    const vertex = compiled(gl.VERTEX_SHADER, VERTEX_SHADER), fragment = compiled(gl.FRAGMENT_SHADER, source);
    gl.attachShader(program, vertex);
    gl.attachShader(program, fragment);
    gl.bindAttribLocation(program, 0, "corner");
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost())
      throw new Error(`The GPU's compiler refuses the shader: ${gl.getShaderInfoLog(fragment) || gl.getProgramInfoLog(program)}`);
    const uniforms = new Map();
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) ?? 0;
    for (let i = 0; i < count; ++i) {
      const { name } = gl.getActiveUniform(program, i);
      uniforms.set(name, gl.getUniformLocation(program, name));
    }
    const result = { program, at: (name) => uniforms.get(name) ?? null };
    this.programs.set(source, result);
    return result;
  }

  texture2D(width, height, bytes, internal = this.gl.RGBA8, type = this.gl.UNSIGNED_BYTE, filter = this.gl.NEAREST) {
    const gl = this.gl, texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, internal, width, height, 0, gl.RGBA, type, bytes);
    for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, filter], [gl.TEXTURE_MAG_FILTER, filter],
      [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]])
      gl.texParameteri(gl.TEXTURE_2D, name, value);
    return texture;
  }

  texture3D([width, height, depth], data, internal, type, filter, format = this.gl.RED) {
    const gl = this.gl, texture = gl.createTexture(), most = gl.getParameter(gl.MAX_3D_TEXTURE_SIZE);
    if (Math.max(width, height, depth) > most)
      throw new Error(`The live picture needs ${width} × ${height} × ${depth} values, and the graphics hold ${most} along an axis at most.`);
    gl.bindTexture(gl.TEXTURE_3D, texture);
    gl.texImage3D(gl.TEXTURE_3D, 0, internal, width, height, depth, 0, format, type, data);
    for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, filter], [gl.TEXTURE_MAG_FILTER, filter],
      [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE],
      [gl.TEXTURE_WRAP_R, gl.CLAMP_TO_EDGE]])
      gl.texParameteri(gl.TEXTURE_3D, name, value);
    return texture;
  }

  // What make() makes of a volume. Scenes share it, and the last few are kept.
  ofVolume(kept, id, make) {
    const made = kept.get(id) ?? make();
    kept.delete(id);
    kept.set(id, made);
    for (const old of [...kept.keys()].slice(0, -3)) {
      for (const texture of kept.get(old)) this.gl.deleteTexture(texture);
      kept.delete(old);
    }
    return made;
  }

  // The textures of a scene, made on first use.
  texturesOf(scene) {
    const gl = this.gl;
    if (!scene.textures) {
      scene.textures = { source: fragmentShader(scene) };
      if (scene.cubes)
        scene.textures.emptiness = this.texture3D(scene.cubes.count, scene.cubes.distances, gl.R8, gl.UNSIGNED_BYTE, gl.NEAREST);
    }
    if (scene.waves && !scene.textures.octave) {
      const { dims, values } = scene.waves.octave, bytes = bytesOfBase64(values);
      scene.textures.octave = this.texture3D(dims, new Uint16Array(bytes.buffer, bytes.byteOffset, bytes.length / 2), gl.R16F, gl.HALF_FLOAT, gl.LINEAR);
    }
    const ofWaves = scene.grain ?? scene.waves;
    if (ofWaves && !scene.textures.waves) {
      const rows = ofWaves.factors.flatMap(({ power, waves }) =>
        waves.flatMap((wave, i) => [...wave.flat(), i + 1 === waves.length ? power : 0, 0, 0, 0]));
      scene.textures.waveCount = rows.length / 16;
      scene.textures.waves = this.texture2D(rows.length / 4, 1, new Float32Array(rows), gl.RGBA32F, gl.FLOAT);
    }
    if (scene.exponent) {
      const { id, dims } = scene.exponent;
      [scene.textures.exponent] = this.ofVolume(this.volumes, id, () =>
        [this.texture3D(dims, scene.volume, gl.R16F, gl.HALF_FLOAT, gl.LINEAR)]);
    }
    if (scene.grain) {
      const { id, dims } = scene.grain, nodes = dims[0] * dims[1] * dims[2];
      [scene.textures.phases, scene.textures.depths] = this.ofVolume(this.grains, id, () =>
        [this.texture3D(dims, scene.grainVolume.subarray(0, 4 * nodes), gl.RGBA16F, gl.HALF_FLOAT, gl.LINEAR, gl.RGBA),
          this.texture3D(dims, scene.grainVolume.subarray(4 * nodes), gl.R16F, gl.HALF_FLOAT, gl.LINEAR)]);
    }
    return scene.textures;
  }

  forget(scene) {
    if (!scene?.textures) return;
    for (const name of ["emptiness", "factors", "octave", "waves"]) this.gl.deleteTexture(scene.textures[name] ?? null);
    scene.textures = null;
  }

  factorTexture(scene, factors) {
    const gl = this.gl, textures = scene.textures;
    if (textures.factorsOf === factors) return textures.factors;
    gl.deleteTexture(textures.factors ?? null);
    const rows = Math.max(1, Math.ceil(factors.length / 512)), data = new Float32Array(1024 * 4 * rows);
    // Whole powers up to 64 are computed by products, which need no angles.
    factors.forEach(([a, b, c, d, power], i) => data.set([a, b, c, d, power,
      Number.isInteger(power) && Math.abs(power) <= 64 ? 1 : 0, 0, 0], 8 * i));
    textures.factors = this.texture2D(1024, rows, data, gl.RGBA32F, gl.FLOAT);
    textures.factorsOf = factors;
    return textures.factors;
  }

  // Distances from the target. Only the latest are kept.
  distanceTexture(distance) {
    if (!distance) return null;
    if (this.distancesOf !== distance) {
      const { gl } = this, bytes = bytesOfBase64(distance.values);
      gl.deleteTexture(this.distances ?? null);
      this.distances = this.texture3D(distance.dims, new Uint16Array(bytes.buffer, bytes.byteOffset, bytes.length / 2), gl.R16F, gl.HALF_FLOAT, gl.LINEAR);
      this.distancesOf = distance;
    }
    return this.distances;
  }

  gradientTexture(stops) {
    const key = JSON.stringify(stops);
    if (!this.gradients.has(key)) {
      const bytes = new Uint8Array(256 * 4);
      for (let i = 0; i < 256; ++i) {
        const at = i / 255 * (stops.length - 1), low = Math.max(0, Math.min(stops.length - 2, Math.floor(at)));
        for (let c = 0; c < 3; ++c)
          bytes[4 * i + c] = Math.round(255 * (stops[low][c] * (low + 1 - at) + stops[Math.min(stops.length - 1, low + 1)][c] * (at - low)));
      }
      this.gradients.set(key, this.texture2D(256, 1, bytes, this.gl.RGBA8, this.gl.UNSIGNED_BYTE, this.gl.LINEAR));
    }
    return this.gradients.get(key);
  }

  // ---- pictures ----

  // A target to draw into.
  target(width, height) {
    const gl = this.gl;
    const texture = this.floats ? this.texture2D(width, height, null, gl.RGBA16F, gl.HALF_FLOAT, gl.LINEAR)
      : this.texture2D(width, height, null, gl.RGBA8, gl.UNSIGNED_BYTE, gl.LINEAR);
    const buffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, buffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
    return { texture, buffer, width, height };
  }

  freeTarget(target) {
    if (!target) return;
    this.gl.deleteFramebuffer(target.buffer);
    this.gl.deleteTexture(target.texture);
  }

  // Sends the rays of rows y0 to y1 of a picture.
  // shot: {scene, live, view, look}; sample: {jitter, share, before, axes}
  drawRows(shot, target, sample, y0, y1) {
    const gl = this.gl, { scene, live, view, look } = shot;
    // All textures are made before any is bound, because making one binds it.
    const textures = this.texturesOf(scene), { colouring } = look, { light } = look;
    const gradient = this.gradientTexture(colouring.stops?.length ? colouring.stops : GRADIENTS.viridis);
    const distances = this.distanceTexture(colouring.distance);
    const factors = scene.factors ? this.factorTexture(scene, live.factors) : null;
    const { program, at } = this.program(textures.source);
    gl.useProgram(program);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.buffer);
    gl.viewport(0, 0, target.width, target.height);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, y0, target.width, y1 - y0);

    let unit = 0;
    const bind = (name, kind, texture) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(kind, texture);
      gl.uniform1i(at(name), unit++);
    };
    gl.uniform1i(at("iterationLimit"), live.iterations);
    gl.uniform1f(at("escapeRadius"), scene.escape);
    gl.uniform1f(at("logEscape"), scene.logEscape);
    gl.uniform1f(at("level"), scene.level);
    gl.uniform1f(at("logTrap"), live.logTrap ?? -1e30);
    gl.uniform1f(at("slice"), live.slice);
    gl.uniform1i(at("dropped"), { i: 1, j: 2, k: 3 }[scene.dropAxis]);
    gl.uniform4fv(at("constant"), [...(live.constant ?? []), 0, 0, 0, 0].slice(0, 4));
    gl.uniform1i(at("mandelbrot"), live.constant ? 0 : 1);
    gl.uniform1i(at("fromPole"), scene.theta === "pole" ? 1 : 0);
    gl.uniform1f(at("power"), live.power);
    gl.uniform1i(at("wholePower"), Number.isInteger(live.power) && live.power >= 2 && live.power <= 64 ? live.power : 0);
    gl.uniform1i(at("factorCount"), live.factors.length);
    gl.uniform1f(at("logScale"), scene.logScale ?? 0);
    if (factors) bind("factors", gl.TEXTURE_2D, factors);
    const columnsOf = (matrix) => [0, 1, 2].flatMap((column) => matrix.map((row) => row[column]));
    if (textures.waves) {
      bind("waves", gl.TEXTURE_2D, textures.waves);
      gl.uniform1i(at("waveCount"), textures.waveCount);
    }
    if (scene.grain) {
      const { matrix, offset, dims } = scene.grain;
      bind("phases", gl.TEXTURE_3D, textures.phases);
      bind("depths", gl.TEXTURE_3D, textures.depths);
      gl.uniformMatrix3fv(at("toGrainNode"), false, columnsOf(matrix));
      gl.uniform3fv(at("grainOffset"), offset);
      gl.uniform3fv(at("grainCount"), dims);
    }
    if (scene.waves) {
      const { matrix, offset, dims } = scene.waves.octave;
      bind("octave", gl.TEXTURE_3D, textures.octave);
      gl.uniform4fv(at("waveOrigin"), live.waveOrigin);
      gl.uniform1f(at("waveScale"), live.waveScale);
      gl.uniformMatrix3fv(at("toOctaveNode"), false, columnsOf(matrix));
      gl.uniform3fv(at("octaveOffset"), offset);
      gl.uniform3fv(at("octaveCount"), dims);
    }
    if (scene.exponent) {
      const { matrix, offset, dims, knee } = scene.exponent;
      bind("exponent", gl.TEXTURE_3D, textures.exponent);
      gl.uniformMatrix3fv(at("toNode"), false, columnsOf(matrix));
      gl.uniform3fv(at("nodeOffset"), offset);
      gl.uniform3fv(at("nodeCount"), dims);
      gl.uniform2fv(at("knee"), knee);
      gl.uniform3fv(at("originShift"), live.originShift);
    }

    const { centre, scale } = scene.space, frame = cameraFrame(view);
    const shifted = (x) => subtract(x, live.originShift);
    const eye = shifted(scaledBy(subtract(view.eye, centre), 1 / scale));
    gl.uniform3fv(at("eye"), eye);
    for (const name of ["right", "up", "forward"]) gl.uniform3fv(at(name), frame[name]);
    gl.uniform1f(at("tangent"), frame.tangent);
    gl.uniform1f(at("aspect"), target.width / target.height);
    gl.uniform2f(at("pixels"), target.width, target.height);
    gl.uniform2fv(at("jitter"), sample.jitter);
    const region = regionOf(scene, live);
    gl.uniform3fv(at("regionMin"), shifted(region.min));
    gl.uniform3fv(at("regionMax"), shifted(region.max));
    gl.uniform4fv(at("clip"), clipPlane(look.clip, scene, live));
    gl.uniform1f(at("stepAlpha"), 2 * frame.tangent / target.height);
    gl.uniform1f(at("stepLeast"), 5e-5);
    const off = [0, 1, 2].map((i) => Math.max(shifted(region.min)[i] - eye[i], eye[i] - shifted(region.max)[i], 0));
    gl.uniform1f(at("stepFirst"), Math.hypot(...off) * (1 - 1e-9));
    gl.uniform1i(at("axisCount"), sample.axes);
    gl.uniform1i(at("colourBy"), colouring.by === "depth" && !distances ? COLOURINGS.indexOf("clay") : COLOURINGS.indexOf(colouring.by));
    // Depths are lengths in world units.
    const length = colouring.by === "depth" ? scale : 1;
    gl.uniform2f(at("gradientRange"), (colouring.low ?? 0) / length, (colouring.high ?? (colouring.by === "iterations" ? live.iterations : 1)) / length);
    bind("distances", gl.TEXTURE_3D, distances ?? this.nothing3D);
    gl.uniform3fv(at("distanceOrigin"), shifted(colouring.distance?.origin ?? [0, 0, 0]));
    gl.uniform3fv(at("distanceCount"), colouring.distance?.dims ?? [1, 1, 1]);
    gl.uniform1f(at("distanceStep"), colouring.distance?.step ?? 1);
    this.setLight(at, light, view, frame, sample);
    const ball = scaledBy(subtract(scene.frame.centre, centre), 1 / scale), sky = unitOf(view.up);
    gl.uniform3fv(at("middle"), shifted(ball));
    gl.uniform1f(at("radius"), scene.frame.radius / scale);
    gl.uniform1i(at("ground"), light.ground && scene.lowest?.length ? 1 : 0);
    gl.uniform1f(at("floorHeight"), scene.lowest?.length ? lowestAlong(scene.lowest, sky) - dotOf(live.originShift, sky) : 0);
    bind("gradient", gl.TEXTURE_2D, gradient);
    bind("before", gl.TEXTURE_2D, sample.before ?? this.nothing);
    gl.uniform1f(at("share"), sample.share);
    // For a map without an exponent, the cubes are proved to be empty for one orbit only.
    const { cubes } = scene, skips = cubes && (scene.exponent || live.exact);
    bind("emptiness", gl.TEXTURE_3D, skips ? textures.emptiness : this.nothing3D);
    gl.uniform3iv(at("cubeCount"), skips ? cubes.count : [0, 0, 0]);
    gl.uniform3fv(at("cubeOrigin"), skips ? shifted(cubes.origin) : [0, 0, 0]);
    gl.uniform3fv(at("cubeSide"), skips ? cubes.side : [1, 1, 1]);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.SCISSOR_TEST);
  }

  // The light of vdbtools/render/shading.h, which turns with the camera and stays upright.
  setLight(at, light, view, frame, sample) {
    const { gl } = this, { material } = light, directions = lightDirections(light, view, frame);
    gl.uniform3fv(at("sky"), directions.sky);
    gl.uniform3fv(at("keyLight"), directions.key);
    gl.uniform3fv(at("rim"), directions.rim);
    gl.uniform1f(at("skyStrength"), light.sky);
    gl.uniform1f(at("gain"), 2 ** light.exposure);
    gl.uniform3fv(at("albedoOf"), material.albedo);
    gl.uniform3fv(at("gloss"), material.gloss);
    gl.uniform1f(at("sharpness"), material.sharpness);
    gl.uniform1i(at("mirrors"), material.mirrors ? 1 : 0);
    // A moving picture is lit by fewer rays.
    const isCoarse = sample.axes === 3;
    gl.uniform1i(at("openRays"), isCoarse ? 3 : 6);
    gl.uniform1i(at("openPlaces"), isCoarse ? 4 : 7);
    gl.uniform1f(at("keyGrowth"), isCoarse ? 1.35 : 1.12);
    gl.uniform3fv(at("lightJitter"), sample.lightJitter);
    gl.uniform1i(at("backdrop"), light.background === "none" ? 2 : light.background ? 1 : 0);
    gl.uniform3fv(at("plain"), Array.isArray(light.background) ? light.background : [0, 0, 0]);
  }

  // Shows a picture on the canvas, or only some of its rows, from the lowest.
  show(target, rows = target.height, isClear = false) {
    const gl = this.gl, { program, at } = this.display;
    gl.useProgram(program);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, target.texture);
    gl.uniform1i(at("picture"), 0);
    gl.uniform2f(at("pixels"), this.canvas.width, this.canvas.height);
    gl.uniform1i(at("clear"), isClear ? 1 : 0);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, 0, this.canvas.width, Math.floor(rows / target.height * this.canvas.height));
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.SCISSOR_TEST);
  }

  // Red, green, blue (linear) and coverage, from the lowest row up.
  read(target) {
    const gl = this.gl, values = new Float32Array(4 * target.width * target.height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.buffer);
    if (this.floats) {
      gl.readPixels(0, 0, target.width, target.height, gl.RGBA, gl.FLOAT, values);
    } else {
      const bytes = new Uint8Array(values.length);
      gl.readPixels(0, 0, target.width, target.height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
      bytes.forEach((value, i) => { values[i] = value / 255; });
    }
    return values;
  }

  // ---- the size of requests ----

  // Whether the GPU has finished its work. Measures how fast it was.
  isIdle() {
    if (!this.fence) return true;
    const gl = this.gl, status = gl.clientWaitSync(this.fence.sync, 0, 0);
    if (status !== gl.ALREADY_SIGNALED && status !== gl.CONDITION_SATISFIED && status !== gl.WAIT_FAILED) return false;
    gl.deleteSync(this.fence.sync);
    // Most of a short time is spent waiting for the browser's frame; the shortest recent time tells how much.
    const elapsed = Math.max(1, performance.now() - this.fence.since);
    this.latency = Math.min(1.02 * this.latency, elapsed, 200);
    const rate = this.fence.pixels / Math.max(1, elapsed - 0.8 * this.latency);
    if (this.fence.pixels > 0) this.rate += 0.5 * (rate - this.rate);
    this.rate = Math.max(this.rate, 0.2);
    this.fence = null;
    return true;
  }

  // Updates the rate after this number of pixels.
  handOver(pixels) {
    this.fence = { sync: this.gl.fenceSync(this.gl.SYNC_GPU_COMMANDS_COMPLETE, 0), since: performance.now(), pixels };
    this.gl.flush();
  }

  // The number of rows to request. It is not too small, because each request waits for a frame of the browser.
  rowsFor(milliseconds, width, height) {
    return Math.max(1, Math.ceil(height / 24), Math.ceil(LEAST_PIXELS / width), Math.floor(milliseconds * this.rate / width));
  }
}

// A picture that becomes finer with each strip: one sample per pixel, then more.
export class Exposure {
  constructor(renderer, width, height, shot, { samples, axes }) {
    Object.assign(this, { renderer, width, height, shot, samples, axes });
    this.targets = [renderer.target(width, height), samples > 1 ? renderer.target(width, height) : null];
    this.pass = 0;
    this.row = 0;
  }

  get isDone() { return this.pass === this.samples; }
  // The mean of all complete passes; nothing before the first is complete.
  get picture() { return this.pass === 0 ? null : this.targets[(this.pass - 1) % 2]; }
  get share() { return (this.pass + this.row / this.height) / this.samples; }

  // Draws some more rows. Returns the number of pixels drawn.
  advance(milliseconds) {
    const rows = Math.min(this.height - this.row, this.renderer.rowsFor(milliseconds, this.width, this.height));
    const sample = {
      jitter: this.pass === 0 ? [0.5, 0.5] : [halton(this.pass, 2), halton(this.pass, 3)],
      lightJitter: [2, 3, 5].map((base, i) => this.pass === 0 ? [0, 0.5, 0.5][i] : halton(this.pass, base)),
      share: 1 / (this.pass + 1), before: this.picture?.texture ?? null, axes: this.axes,
    };
    this.renderer.drawRows(this.shot, this.targets[this.pass % 2], sample, this.row, this.row + rows);
    this.row += rows;
    if (this.row === this.height) {
      this.row = 0;
      ++this.pass;
    }
    return rows * this.width;
  }

  // No more passes than this are made.
  finish() { this.samples = this.pass; }

  free() {
    for (const target of this.targets) this.renderer.freeTarget(target);
    this.targets = [null, null];
  }
}

// The lowest position of a set along a direction, from sampled points around it.
function lowestAlong(places, direction) { return Math.min(...places.map((place) => dotOf(place, direction))); }

function regionOf(scene, live) {
  if (scene.exponent || live.exact) return scene.region;
  // Another orbit may have a larger set.
  const { min, max } = scene.region;
  return {
    min: min.map((low, i) => low - 0.25 * (max[i] - low)),
    max: max.map((high, i) => high + 0.25 * (high - min[i])),
  };
}

// clip: {axis: "x", "y" or "z"; at: a share of the set's extent; flip: which side is cut away}
function clipPlane(clip, scene, live) {
  if (!clip?.axis) return [0, 0, 0, 0];
  const axis = { x: 0, y: 1, z: 2 }[clip.axis], normal = [0, 0, 0], at = clipPlace(clip, scene) - live.originShift[axis];
  normal[axis] = clip.flip ? -1 : 1;
  return [...normal, clip.flip ? -at : at];
}

// Where the plane lies on its axis, in fractal space.
export function clipPlace(clip, scene) {
  const axis = { x: 0, y: 1, z: 2 }[clip.axis], { centre, radius } = scene.frame;
  return (centre[axis] + (2 * clip.at - 1) * radius - scene.space.centre[axis]) / scene.space.scale;
}

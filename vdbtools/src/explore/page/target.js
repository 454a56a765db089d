// SPDX-License-Identifier: Apache-2.0
// The target beside the fractal: its triangles with the same camera, light and material, without shadows.
import { cameraFrame, lightDirections } from "./renderer.js";

const VERTEX = `#version 300 es
in vec3 position;
uniform vec3 eye, right, up, forward;
uniform vec2 scale, depth;
out vec3 place;
void main() {
  place = position;
  vec3 d = position - eye;
  float w = dot(d, forward);
  gl_Position = vec4(scale.x * dot(d, right), scale.y * dot(d, up), w * depth.x + depth.y, w);
}
`;
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 place;
uniform vec3 sky, key, rim, albedo;
uniform vec3 eye;
uniform float strength, gain;
out vec4 result;
void main() {
  vec3 normal = normalize(cross(dFdx(place), dFdy(place))), view = normalize(place - eye);
  if (dot(normal, view) > 0.0) normal = -normal;
  float height = 0.5 + dot(normal, sky) / 3.0;
  vec3 light = strength * (vec3(0.10, 0.08, 0.07) + height * vec3(0.34, 0.42, 0.53) + pow(max(0.0, 0.5 + 0.5 * dot(normal, rim)), 2.415) / 3.0 * vec3(0.62, 0.70, 0.85));
  vec3 c = albedo * (light + max(0.0, dot(normal, key)) * vec3(1.22, 1.12, 0.97));
  c = clamp(gain * c, 0.0, 1.0);
  result = vec4(mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, vec3(greaterThan(c, vec3(0.0031308)))), 1.0);
}
`;

export class TargetView {
  // bytes: the numbers of points and triangles; the points, relative to the middle of the box and in units of its
  // longest side; the triangles. target: {box, longestSide}
  constructor(canvas, bytes, target) {
    const [points, triangles] = new Uint32Array(bytes, 0, 2), gl = canvas.getContext("webgl2", { antialias: true });
    if (!gl) throw new Error("This browser has no WebGL 2, which the picture of the target needs.");
    Object.assign(this, { canvas, gl, target, indices: 3 * triangles });
    const program = this.program = gl.createProgram();
    for (const [type, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.bindAttribLocation(program, 0, "position");
    gl.linkProgram(program);
    gl.useProgram(program);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(bytes, 8, 3 * points), gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(bytes, 8 + 12 * points, 3 * triangles), gl.STATIC_DRAW);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(0.87, 0.87, 0.87, 1);
  }

  // light: numbers, as in lighting.js
  draw(view, light) {
    const { gl, canvas, program, target } = this, ratio = Math.min(2, window.devicePixelRatio || 1);
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const frame = cameraFrame(view), { box, longestSide } = target;
    const eye = [0, 1, 2].map((i) => (view.eye[i] - (box[i] + box[i + 3]) / 2) / longestSide);
    const far = Math.hypot(...eye) + 1, near = Math.max(far - 2, far / 1000);
    const set = (name, value) => gl[`uniform${value.length}fv`](gl.getUniformLocation(program, name), value);
    set("eye", eye);
    for (const name of ["right", "up", "forward"]) set(name, frame[name]);
    const directions = lightDirections(light, view, frame);
    for (const name of ["sky", "key", "rim"]) set(name, directions[name]);
    const { albedo, gloss, mirrors } = light.material;
    set("albedo", mirrors ? albedo.map((part, i) => part + 0.6 * gloss[i]) : albedo);
    set("strength", [light.sky]);
    set("gain", [2 ** light.exposure]);
    set("scale", [canvas.height / canvas.width / frame.tangent, 1 / frame.tangent]);
    set("depth", [(far + near) / (far - near), -2 * far * near / (far - near)]);
    gl.drawElements(gl.TRIANGLES, this.indices, gl.UNSIGNED_INT, 0);
  }
}

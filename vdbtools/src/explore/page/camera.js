// SPDX-License-Identifier: Apache-2.0
// The camera, which turns about a point: by mouse, touch and keys. A view is {eye, lookAt, up, fov}, in the target's
// units and degrees, as the program's renderer takes it.
import { cameraFrame } from "./renderer.js";

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const plus = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const times = (a, k) => [a[0] * k, a[1] * k, a[2] * k];
const clampedTo = (value, low, high) => Math.min(high, Math.max(low, value));

// The view of `juliavdb render` that frames a ball: see vdbtools/render/camera.h.
export function viewAround({ centre, radius }, { azimuth = -30, elevation = 15, fov = 30 } = {}, aspect = 1) {
  const a = azimuth * Math.PI / 180, e = elevation * Math.PI / 180;
  const towards = [Math.sin(a) * Math.cos(e), Math.sin(e), Math.cos(a) * Math.cos(e)];
  const tangent = Math.tan(fov * Math.PI / 360);
  const distance = radius / Math.sin(Math.atan(tangent * Math.min(1, aspect)));
  return { eye: plus(centre, times(towards, distance)), lookAt: [...centre], up: [0, 1, 0], fov };
}

// Azimuth and elevation in degrees, and the distance.
export function anglesOf(view) {
  const arm = minus(view.eye, view.lookAt), distance = Math.hypot(...arm);
  return {
    azimuth: Math.atan2(arm[0], arm[2]) * 180 / Math.PI, elevation: Math.asin(clampedTo(arm[1] / distance, -1, 1)) * 180 / Math.PI,
    distance,
  };
}

function placed(view, { azimuth, elevation, distance }) {
  const a = azimuth * Math.PI / 180, e = clampedTo(elevation, -89.9, 89.9) * Math.PI / 180;
  const towards = [Math.sin(a) * Math.cos(e), Math.sin(e), Math.cos(a) * Math.cos(e)];
  return { ...view, eye: plus(view.lookAt, times(towards, distance)), up: [0, 1, 0] };
}

export function turnedView(view, right, up) {
  const angles = anglesOf(view);
  return placed(view, { ...angles, azimuth: angles.azimuth - right, elevation: angles.elevation + up });
}

// factor: of the distance; below 1 moves nearer.
export function nearerView(view, factor) {
  const angles = anglesOf(view);
  return placed(view, { ...angles, distance: angles.distance * factor });
}

// right, up: shares of the picture's height.
export function movedView(view, right, up) {
  const frame = cameraFrame(view), height = 2 * frame.tangent * Math.hypot(...minus(view.eye, view.lookAt));
  const by = plus(times(frame.right, right * height), times(frame.up, up * height));
  return { ...view, eye: plus(view.eye, by), lookAt: plus(view.lookAt, by) };
}

// Calls change(view, isMoving) while a pointer drags in the element, and for the camera's keys. get() returns the
// current view.
// dragged(right, up), in shares of the height, may use a drag for something else; it then returns true.
export function attachCamera(element, { get, change, reset, dragged }) {
  const pointers = new Map();
  let spread = 0, wheel = 0;
  const spreadOf = () => {
    const [a, b] = [...pointers.values()];
    return Math.hypot(a.x - b.x, a.y - b.y);
  };
  element.addEventListener("pointerdown", (event) => {
    element.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY, button: event.button });
    if (pointers.size === 2) spread = spreadOf();
  });
  element.addEventListener("pointermove", (event) => {
    const last = pointers.get(event.pointerId);
    if (!last || !get()) return;
    const height = element.clientHeight || 1, right = (event.clientX - last.x) / height, up = -(event.clientY - last.y) / height;
    Object.assign(last, { x: event.clientX, y: event.clientY });
    if (pointers.size === 2) {
      const now = spreadOf();
      change(movedView(nearerView(get(), clampedTo(spread / Math.max(1, now), 0.5, 2)), -right / 2, -up / 2), true);
      spread = now;
    } else if (!dragged?.(right, up)) {
      const moves = last.button !== 0 || event.shiftKey;
      change(moves ? movedView(get(), -right, -up) : turnedView(get(), right * 180, -up * 180), true);
    }
  });
  const end = (event) => {
    if (!pointers.delete(event.pointerId)) return;
    if (pointers.size === 0) change(get(), false);
  };
  element.addEventListener("pointerup", end);
  element.addEventListener("pointercancel", end);
  element.addEventListener("contextmenu", (event) => event.preventDefault());
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    if (!get()) return;
    change(nearerView(get(), clampedTo(Math.exp(event.deltaY * (event.deltaMode === 1 ? 0.03 : 0.001)), 0.5, 2)), true);
    clearTimeout(wheel);
    wheel = setTimeout(() => change(get(), false), 250);
  }, { passive: false });
  element.addEventListener("dblclick", () => reset());
  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !get()) return;
    const fine = event.shiftKey;
    const actions = {
      ArrowLeft: () => fine ? movedView(get(), -0.05, 0) : turnedView(get(), -10, 0),
      ArrowRight: () => fine ? movedView(get(), 0.05, 0) : turnedView(get(), 10, 0),
      ArrowUp: () => fine ? movedView(get(), 0, 0.05) : turnedView(get(), 0, 10),
      ArrowDown: () => fine ? movedView(get(), 0, -0.05) : turnedView(get(), 0, -10),
      "+": () => nearerView(get(), 0.85), "=": () => nearerView(get(), 0.85), "-": () => nearerView(get(), 1 / 0.85),
    };
    if (event.key === "Home" || event.key === "0") {
      event.preventDefault();
      return reset();
    }
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    change(action(), false);
  });
}

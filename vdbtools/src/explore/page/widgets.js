// SPDX-License-Identifier: Apache-2.0
// Elements of the page. Text is always inserted as text, never as HTML.

let lastId = 0;

// element("div", {class: "row", onclick: f}, child, "text")
export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else made.setAttribute(key, value === true ? "" : value);
  }
  made.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return made;
}

export function button(text, onclick, attributes = {}) { return element("button", { type: "button", onclick, ...attributes }, text); }

export function group(title, ...children) {
  return element("details", { class: "group", open: true }, element("summary", {}, title), ...children);
}

const tidy = (value) => String(Number(value.toPrecision(6)));

// A control is {element, update(state)}. Its value is a text in the recipe, or a part of the look.
// name: the option to which it belongs. read(state): the value, or undefined for the default; write(state, value):
// undefined sets the default.
function row({ label, name: option, help = "", read, write }, store, input, extra = []) {
  const id = `control-${++lastId}`;
  input.id = id;
  const name = element("label", { for: id }, label);
  const reset = () => store.change((state) => write(state, undefined));
  const line = element("div", { class: "control", title: help, "data-name": option, ondblclick: (event) => {
    if (event.target === name || event.target.type === "range") reset();
  } }, name, ...extra, input);
  const back = button("↺", reset, { class: "reset", "aria-label": `Set ${label} back`, title: "Set back" });
  line.append(back);
  return {
    element: line,
    mark: (state) => { back.style.visibility = read(state) === undefined ? "hidden" : "visible"; },
  };
}

// A number with a slider. scale "log": each step multiplies.
export function slider(store, control) {
  const { label, min, max, step, scale = "linear", read, write, usual } = control;
  const log = scale === "log", at = (value) => log ? Math.log(Math.max(value, 1e-9)) : value;
  const number = element("input", { type: "number", class: "number", step: "any", inputmode: "decimal" });
  const range = element("input", { type: "range", min: at(min), max: at(max), step: log ? (at(max) - at(min)) / 200 : step, "aria-label": label });
  const put = (value, isMoving) => {
    if (!Number.isFinite(value)) return;
    store.change((state) => write(state, tidy(value)), isMoving);
  };
  const sliderValue = () => {
    const value = log ? Math.exp(Number(range.value)) : Number(range.value);
    return log ? Number(value.toPrecision(3)) : value;
  };
  range.addEventListener("input", () => put(sliderValue(), true));
  range.addEventListener("change", () => put(sliderValue(), false));
  number.addEventListener("change", () => {
    if (number.value !== "") put(Number(number.value), false);
  });
  const line = row(control, store, number, [range]);
  return {
    element: line.element,
    update: (state) => {
      const text = read(state) ?? usual(state), value = Number(text);
      if (document.activeElement !== number) number.value = Number.isFinite(value) && text !== "" ? tidy(value) : "";
      number.placeholder = Number.isFinite(value) ? "" : String(text);
      if (Number.isFinite(value)) {
        range.value = at(value);
        range.setAttribute("aria-valuetext", tidy(value));
      }
      line.mark(state);
    },
  };
}

export function choice(store, control) {
  const { values, read, write, usual } = control;
  const select = element("select", {}, values.map((value) => element("option", { value: value.value ?? value }, value.text ?? value)));
  select.addEventListener("change", () => store.change((state) => write(state, select.value)));
  const line = row(control, store, select);
  return {
    element: line.element,
    update: (state) => {
      select.value = read(state) ?? usual(state);
      line.mark(state);
    },
  };
}

export function tick(store, control) {
  const { read, write } = control;
  const box = element("input", { type: "checkbox" });
  box.addEventListener("change", () => store.change((state) => write(state, box.checked ? "true" : undefined)));
  const line = row(control, store, box);
  return {
    element: line.element,
    update: (state) => {
      box.checked = read(state) === "true";
      line.mark(state);
    },
  };
}

export function text(store, control) {
  const { read, write, usual, type = "text" } = control;
  const input = element("input", { type, spellcheck: "false", autocomplete: "off", ...(type === "number" ? { step: "any", class: "number" } : {}) });
  input.addEventListener("change", () => store.change((state) => write(state, input.value.trim() === "" ? undefined : input.value.trim())));
  const line = row(control, store, input);
  return {
    element: line.element,
    update: (state) => {
      if (document.activeElement !== input) input.value = read(state) ?? "";
      input.placeholder = usual(state) ?? "";
      line.mark(state);
    },
  };
}

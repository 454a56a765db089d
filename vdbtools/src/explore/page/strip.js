// SPDX-License-Identifier: Apache-2.0
// Below the picture: sixteen looks around the current one, and the looks that were kept.
import { button, element } from "./widgets.js";

// page: {store, stage, variations, choices, kept, scene()}
export function makeStrip(page) {
  const { store, variations, choices, kept } = page;
  const select = element("select", { "aria-label": "What the sixteen vary" });
  const make = button("Show sixteen", () => choices.show(select.value, select.selectedOptions[0].label), { class: "main" });
  const again = button("Back to the sixteen", () => choices.open(), { disabled: true, title: "The looks that were shown last" });
  const keep = button("Keep this look", async () => {
    if (kept.has(store.state)) return kept.remove(store.state);
    const image = page.stage.image();
    if (!image) return;
    const picture = element("canvas", { width: image.width, height: image.height });
    picture.getContext("2d").putImageData(image, 0, 0);
    kept.add({ label: nameOf(store.state), state: store.state }, picture);
  }, { "aria-pressed": "false" });
  const keys = page.keys ? button("Key frames", () => {
    page.keys.toggle();
    keys.setAttribute("aria-pressed", String(!page.keys.element.hidden));
  }, { "aria-pressed": "false" }) : null;
  const whole = element("section", { class: "strip", "aria-label": "Other looks" },
    element("div", { class: "buttons" }, select, make, again, keep, keys), kept.element);

  function nameOf({ recipe, look }) {
    const names = Object.entries(recipe).filter(([name, value]) => name !== "input" && value !== page.first.recipe[name]);
    return [...names, ...Object.entries(look.options)].map(([name, value]) => `${name} ${value}`).join(", ") || "the first look";
  }

  // The controls that can be varied depend on the current map.
  function update(state) {
    const fits = variations.of(state.recipe), names = fits.map((one) => one.name).join();
    if (select.dataset.names !== names) {
      select.dataset.names = names;
      const before = select.value;
      select.replaceChildren(...fits.map((one) => element("option", { value: one.name }, one.label)));
      if (fits.some((one) => one.name === before)) select.value = before;
    }
    again.disabled = !choices.top;
    keep.setAttribute("aria-pressed", String(kept.has(state)));
  }
  choices.listen(() => update(store.state));
  kept.listen(() => {
    update(store.state);
    choices.update();
  });
  return { element: whole, update };
}

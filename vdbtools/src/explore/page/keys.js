// SPDX-License-Identifier: Apache-2.0
// From looks to a sequence: a strip of key frames. The server blends them as `juliavdb plan frames` does, and gives the
// command that plans the same frames.
import { server } from "./server.js";
import { recipeKey } from "./variations.js";
import { button, element } from "./widgets.js";

const KEY_WIDTH = 80, KEY_HEIGHT = 60, USUAL_FRAMES = 48, MOST_FRAME = 99999;
const FRAME_TIME = 1000 / 12;  // milliseconds per frame of the playback

// page: {store, stage, start}
export class KeyStrip {
  constructor(page) {
    Object.assign(this, { page, keys: [], run: 0, isPlaying: false });
    this.frame = element("input", { type: "range", min: 1, max: USUAL_FRAMES, value: 1, step: 1, "aria-label": "Frame" });
    this.number = element("input", { type: "number", class: "number", min: 0, max: MOST_FRAME, step: 1, value: 1, "aria-label": "The number of the frame" });
    this.last = element("input", { type: "number", class: "number", min: 1, max: MOST_FRAME, step: 1, value: USUAL_FRAMES, "aria-label": "The last frame" });
    this.ease = element("select", { "aria-label": "How the numbers change between keys" },
      ["linear", "smooth", "step"].map((name) => element("option", { value: name }, name)));
    this.set = button("Set a key", () => this.setKey(), { class: "main", title: "The look at hand, at this frame" });
    this.play = button("Play", () => this.playOrStop(), { disabled: true });
    this.copy = button("Copy the command", () => this.copyCommand(), { disabled: true });
    this.command = element("textarea", { readonly: true, rows: 2, "aria-label": "The command of the sequence", hidden: true });
    this.note = element("span", { class: "note", role: "status" });
    this.row = element("div", { class: "keys-row", role: "group", "aria-label": "Keys" });
    this.element = element("section", { class: "keys", hidden: true, "aria-label": "Key frames" },
      element("div", { class: "keys-bar" }, "Frame", this.number, this.frame, "of", this.last, this.set, this.ease, this.play, this.copy, this.note),
      this.row, this.command);
    this.frame.addEventListener("input", () => this.goTo(Number(this.frame.value), true));
    this.frame.addEventListener("change", () => this.goTo(Number(this.frame.value), false));
    this.number.addEventListener("change", () => this.goTo(Math.round(Number(this.number.value) || 0), false));
    this.last.addEventListener("change", () => { this.frame.max = Math.max(1, Math.round(Number(this.last.value) || USUAL_FRAMES)); });
    this.ease.addEventListener("change", () => this.goTo(Number(this.frame.value), false));
    this.show();
  }

  toggle() {
    this.element.hidden = !this.element.hidden;
    this.isPlaying = false;
  }

  say(text, isError = false) {
    this.note.textContent = text;
    this.note.classList.toggle("error", isError);
  }

  // Assigns the current look to the frame.
  setKey() {
    const { store, stage } = this.page, frame = Number(this.frame.value), image = stage.image();
    const picture = element("canvas", { width: KEY_WIDTH, height: KEY_HEIGHT });
    if (image) {
      const whole = element("canvas", { width: image.width, height: image.height });
      whole.getContext("2d").putImageData(image, 0, 0);
      const share = Math.max(KEY_WIDTH / image.width, KEY_HEIGHT / image.height);
      picture.getContext("2d").drawImage(whole, (KEY_WIDTH - image.width * share) / 2, (KEY_HEIGHT - image.height * share) / 2, image.width * share, image.height * share);
    }
    this.keys = [...this.keys.filter((key) => key.frame !== frame), { frame, recipe: { ...store.state.recipe }, picture: picture.toDataURL("image/jpeg", 0.85) }]
      .sort((a, b) => a.frame - b.frame);
    this.show();
    const next = frame === Number(this.frame.max) ? "" : " Go to another frame, change the look, and set the next key.";
    this.say(this.keys.length < 2 ? `Frame ${frame} has this look.${next}` : "");
  }

  show() {
    this.row.replaceChildren(...this.keys.length === 0 ? [element("span", { class: "note" }, "Set a key at frame 1, go to another frame, change the look, and set a key there.")]
      : this.keys.map((key) => element("div", { class: "kept-look" },
        button("", () => this.goTo(key.frame, false), { class: "kept-picture key", "aria-label": `Go to the key at frame ${key.frame}` }),
        button("×", () => this.removeKey(key), { class: "kept-remove", "aria-label": `Remove the key at frame ${key.frame}` }))));
    this.row.querySelectorAll(".key").forEach((tile, i) =>
      tile.append(element("img", { src: this.keys[i].picture, alt: "", width: KEY_WIDTH, height: KEY_HEIGHT }), element("span", {}, String(this.keys[i].frame))));
    this.play.disabled = this.copy.disabled = this.keys.length < 2;
    this.command.hidden = true;
  }

  removeKey(key) {
    this.keys = this.keys.filter((one) => one !== key);
    this.show();
  }

  request() { return { keys: this.keys.map(({ frame, recipe }) => ({ frame, recipe })), ease: this.ease.value }; }

  // Shows the look of a frame, as blended by the program.
  async goTo(frame, isMoving) {
    const at = Math.min(MOST_FRAME, Math.max(0, frame)), mine = ++this.run;
    if (at > Number(this.frame.max)) this.frame.max = this.last.value = at;
    if (at < Number(this.frame.min)) this.frame.min = at;
    this.frame.value = this.number.value = at;
    const key = this.keys.find((one) => one.frame === at);
    try {
      const recipe = key ? key.recipe : this.keys.length < 2 ? null : (await server.sequence({ ...this.request(), frame: at })).recipe;
      if (mine !== this.run) return;
      this.say("");
      if (recipe && recipeKey(recipe) !== recipeKey(this.page.store.state.recipe))
        this.page.store.change((state) => { state.recipe = { ...recipe }; }, isMoving);
      else if (!isMoving) this.page.store.change(() => {});
    } catch (error) {
      if (mine === this.run) this.say(error.message, true);
    }
  }

  // Plays one frame after another, and waits for a frame that takes longer.
  async playOrStop() {
    this.isPlaying = !this.isPlaying;
    this.play.textContent = this.isPlaying ? "Stop" : "Play";
    const from = this.keys[0].frame, to = this.keys.at(-1).frame;
    for (let frame = Number(this.frame.value) >= to ? from : Math.max(from, Number(this.frame.value)); this.isPlaying && frame <= to; ++frame) {
      const begun = performance.now();
      await this.goTo(frame, true);
      while (this.isPlaying && (this.page.isBusy() || this.page.stage.isDrawing)) await new Promise((resolve) => setTimeout(resolve, 20));
      await new Promise((resolve) => setTimeout(resolve, Math.max(0, FRAME_TIME - (performance.now() - begun))));
      if (this.note.classList.contains("error")) break;
    }
    this.isPlaying = false;
    this.play.textContent = "Play";
    this.page.store.change(() => {});
  }

  async copyCommand() {
    try {
      this.command.value = (await server.sequence({ ...this.request(), ...this.page.named() })).command;
      this.command.hidden = false;
      await navigator.clipboard?.writeText(this.command.value).then(() => this.say("The command was copied."), () => this.command.select());
    } catch (error) {
      this.say(error.message, true);
    }
  }
}

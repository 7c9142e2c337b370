// What a person does, by pointer, keys or buttons: each action is one command, its error is shown.

import { announce, read } from "./announce.js";
import { nextColor } from "./colors.js";
import { isAbsent, itemOf, keyframeOf, nearestRegion, selectedItem } from "./derived.js";
import { rounded } from "./geometry.js";

const DOUBTS = 20;

export class Actions {
  constructor(app) {
    this.app = app;
    this.store = app.store;
    this.store.on(["doubts"], (state) => this.#goToDoubt(state));
  }

  get state() {
    return this.store.state;
  }

  /** Send a command; return its reply, or null after showing why it failed. */
  async send(type, fields = {}) {
    try {
      return await this.app.connection.send(type, fields);
    } catch (error) {
      announce(error.message, "error");
      return null;
    }
  }

  /** Put a drawn region into the session: a new object, or a keyframe of the one it belongs to. */
  async commit(draft) {
    const region = rounded(draft.region);
    if (draft.object !== null) {
      await this.send("set_keyframe", { object: draft.object, frame: draft.frame, region });
      const row = this.state.rows.get(draft.object)?.[draft.frame];
      if (row) row.final = true; // what was drawn stands, until the smoothed rows come
      read(`Keyframe in frame ${draft.frame}`);
    } else {
      const objects = this.state.session.objects.filter(({ compared }) => compared === null);
      const { preset, config, seed } = this.state.tracker;
      const reply = await this.send("add_object", {
        name: `Object ${objects.length + 1}`, color: nextColor(objects), frame: draft.frame, region,
        preset, config, seed,
      });
      if (reply) this.store.set({ selected: reply.object, tool: "select" });
      read(`Object ${objects.length + 1} drawn in frame ${draft.frame}`);
    }
    this.store.set({ draft: null, redrawing: false });
  }

  /** Make the estimate of this frame a keyframe, or remove the keyframe that is here. */
  async toggleKeyframe() {
    const item = this.#mine();
    if (!item) return;
    const { frame } = this.state;
    if (keyframeOf(item, frame) && item.keyframes.length + item.absent.length > 1) {
      await this.send("remove_keyframe", { object: item.object, frame });
      return;
    }
    const region = nearestRegion(this.state, item, frame);
    if (region) await this.commit({ object: item.object, frame, region });
  }

  async toggleAbsent() {
    const item = this.#mine();
    if (!item) return;
    const { frame } = this.state;
    const type = isAbsent(item, frame) ? "remove_keyframe" : "set_keyframe";
    const region = type === "set_keyframe" ? { region: null } : {};
    await this.send(type, { object: item.object, frame, ...region });
  }

  async absentBetween(first, last) {
    const item = this.#mine();
    if (item) await this.send("set_absent", { object: item.object, first, last });
  }

  async split() {
    const item = this.#mine();
    if (!item) return;
    const reply = await this.send("split", { object: item.object, frame: this.state.frame });
    if (reply) announce(`${item.name} was split in frame ${this.state.frame}.`);
  }

  async join(other) {
    const item = this.#mine();
    if (item) await this.send("join", { object: item.object, other });
  }

  async remove() {
    const item = selectedItem(this.state);
    if (item) await this.send("remove_object", { object: item.object });
  }

  change(object, changes) {
    return this.send("change_object", { object, ...changes });
  }

  async track(objects = []) {
    if (!this.state.session.objects.length) {
      announce("Draw a box or an ellipse around an object first.");
      return;
    }
    this.store.set({ following: true, playing: false });
    const reply = await this.send("track", { objects });
    if (!reply) this.store.set({ following: false });
  }

  async watch(fields) {
    this.store.set({ following: true, playing: false });
    const reply = await this.send("watch", fields);
    if (!reply) this.store.set({ following: false });
  }

  job(type, job) {
    return this.send(type, { job });
  }

  async undo() {
    if (this.state.session?.undo) await this.send("undo");
  }

  async redo() {
    if (this.state.session?.redo) await this.send("redo");
  }

  /** Ask for the doubtful frames as they are now, and go to the next one. */
  async nextDoubt() {
    const item = this.#mine();
    if (!item) return;
    this.store.set({ seeking: item.object });
    const reply = await this.send("doubts", { object: item.object, count: DOUBTS });
    if (!reply) this.store.set({ seeking: null });
  }

  #goToDoubt({ seeking, doubts, doubtful }) {
    const items = doubts.get(seeking);
    if (seeking === null || !items) return;
    this.store.set({ seeking: null });
    const at = items.findIndex(({ frame }) => frame === doubtful);
    const next = items[(at + 1) % items.length];
    if (next) this.goToDoubt(next);
    else announce("No frame is in doubt.");
  }

  goToDoubt({ frame, reasons }) {
    this.store.set({ doubtful: frame });
    this.app.player.go(frame);
    read(`Frame ${frame} is in doubt: ${reasons.join(", ")}`);
  }

  setPlaces(changes) {
    return this.send("set_places", { places: { ...this.state.session.places, ...changes } });
  }

  /** Track the same keyframes with another tracker, and show both side by side. */
  async compare(fields) {
    const item = this.#mine();
    if (!item) return;
    const reply = await this.send("compare", { object: item.object, ...fields });
    if (!reply) return;
    this.store.set({ beside: reply.object });
    await this.track(item.tracked ? [reply.object] : [item.object, reply.object]);
  }

  /** The object that corrections go to: a compared one has no keyframes of its own. */
  #mine() {
    const item = selectedItem(this.state);
    if (!item) announce("Choose an object first.");
    return item && item.compared !== null ? itemOf(this.state, item.compared) : item;
  }
}

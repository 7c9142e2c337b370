// What a person does, by pointer, keys or buttons: each action is one command, its error is shown.

import { announce, read, tried } from "./announce.js";
import { ask } from "./api.js";
import { nextColor } from "./colors.js";
import { isAbsent, itemOf, keyframeOf, nearestRegion, runningJobs, selectedItem } from "./derived.js";
import { isBox, rounded } from "./geometry.js";

const DOUBTS = 20;

const COUNTED = ["line", "zone", "ground"];

export class Actions {
  #turn = Promise.resolve();

  constructor(app) {
    this.app = app;
    this.store = app.store;
  }

  get state() {
    return this.store.state;
  }

  /** Send a command; return its reply, or null after showing why it failed. */
  send(type, fields = {}) {
    return tried(this.app.connection.send(type, fields));
  }

  /** Do what follows from the session once all earlier changes of it are answered, unless it was left meanwhile. */
  #inTurn(act) {
    const { connection } = this.app;
    const done = this.#turn.then(() => (this.app.connection === connection ? act() : null));
    this.#turn = done.catch(() => {});
    return done;
  }

  /** Choose a tool; what was begun with another one ends. */
  choose(tool) {
    this.store.set({ tool, redrawing: false, corners: [], draft: null, following: false });
    if (COUNTED.includes(tool)) this.store.set({ tab: "count" });
  }

  /** Let the person draw the chosen object again in the frame that is seen. */
  redraw() {
    const item = this.#mine();
    if (!item) return;
    this.app.player.stay();
    this.choose(isBox(item.keyframes[0].region) ? "box" : "ellipse");
    this.store.set({ selected: item.object, redrawing: true });
  }

  /** Put a drawn region into the session: a new object, or a keyframe of the one it belongs to. */
  commit(draft) {
    const sent = { ...draft, byKeys: false, sent: true };
    this.store.set({ draft: sent, redrawing: false, tool: "select" });
    return this.#inTurn(async () => {
      const region = rounded(draft.region);
      if (draft.object === null) await this.#add(draft.frame, region);
      else await this.#mark(draft.object, draft.frame, region);
      if (this.state.draft === sent) this.store.set({ draft: null });
    });
  }

  async #add(frame, region) {
    const { session, tracker } = this.state;
    const color = nextColor(session.objects);
    const reply = await this.send("add_object", { name: "", color, frame, region, ...tracker });
    if (!reply) return;
    this.store.set({ selected: reply.object });
    read(`Object ${reply.object} drawn in frame ${frame}`);
  }

  async #mark(object, frame, region) {
    const reply = await this.send("set_keyframe", { object, frame, region });
    if (!reply) return;
    const row = this.state.rows.get(object)?.[frame];
    if (row) row.final = true; // what was drawn stands, until the smoothed rows come
    read(`Keyframe in frame ${frame}`);
  }

  /** Correct the chosen object in the frame that is seen. */
  #correct(act) {
    const object = this.#mine()?.object;
    const { pictured } = this.state;
    if (object === undefined || pictured === null) return null;
    return this.#inTurn(() => {
      const item = itemOf(this.state, object);
      return item && act(item, pictured);
    });
  }

  /** Make the estimate of this frame a keyframe, or remove the keyframe that is here. */
  toggleKeyframe() {
    return this.#correct((item, frame) => {
      if (keyframeOf(item, frame)) return this.send("remove_keyframe", { object: item.object, frame });
      const region = nearestRegion(this.state, item, frame);
      return region && this.#mark(item.object, frame, rounded(region));
    });
  }

  toggleAbsent() {
    return this.#correct(({ object, ...item }, frame) =>
      isAbsent(item, frame)
        ? this.send("remove_keyframe", { object, frame })
        : this.send("set_absent", { object, first: frame, last: frame }));
  }

  absentBetween(first, last) {
    return this.#correct(({ object }) => this.send("set_absent", { object, first, last }));
  }

  split() {
    return this.#correct(async ({ object, name }, frame) => {
      if (await this.send("split", { object, frame })) announce(`${name} was split in frame ${frame}.`);
    });
  }

  join(other) {
    return this.#correct(({ object }) => this.send("join", { object, other }));
  }

  remove() {
    const object = selectedItem(this.state)?.object;
    return object === undefined ? null : this.#inTurn(() => this.send("remove_object", { object }));
  }

  change(object, changes) {
    return this.#inTurn(() => this.send("change_object", { object, ...changes }));
  }

  track(objects = []) {
    return this.#inTurn(() => {
      if (this.state.session.objects.length) return this.#run("track", { objects });
      return announce("Draw a box or an ellipse around an object first.");
    });
  }

  watch(fields) {
    return this.#inTurn(() => this.#run("watch", fields));
  }

  /** Begin a run; the film follows it. */
  async #run(type, fields) {
    this.store.set({ following: true, playing: false });
    const reply = await this.send(type, fields);
    if (!reply) this.store.set({ following: false });
  }

  /** End the run that goes on; it may just have ended. */
  stop() {
    const [job] = runningJobs(this.state);
    return job && this.send("stop", { job: job.job });
  }

  undo() {
    return this.#inTurn(() => this.state.session.undo && this.send("undo"));
  }

  redo() {
    return this.#inTurn(() => this.state.session.redo && this.send("redo"));
  }

  /** Ask for the doubtful frames of the chosen object as they are now; return null where that fails. */
  async findDoubts() {
    const item = this.#mine();
    if (!item) return null;
    const { object } = item;
    const { session } = this.state;
    const items = await tried(ask(`/api/sessions/${session.id}/doubts?object=${object}&count=${DOUBTS}`));
    if (!items || this.state.session?.id !== session.id) return null;
    this.store.set({ doubts: new Map(this.state.doubts).set(object, items) });
    return items;
  }

  /** Go to the next doubtful frame. */
  async nextDoubt() {
    const items = await this.findDoubts();
    if (!items) return;
    const at = items.findIndex(({ frame }) => frame === this.state.doubtful);
    const next = items[(at + 1) % items.length];
    if (next) this.goToDoubt(next);
    else announce("No frame is in doubt.");
  }

  goToDoubt({ frame, reasons }) {
    this.store.set({ doubtful: frame });
    this.app.player.go(frame);
    read(`Frame ${frame} is in doubt: ${reasons.join(", ")}`);
  }

  /** Change lines, zones and the ground: `change` returns what is new, given those of now. */
  setPlaces(change) {
    return this.#inTurn(() => {
      const { places } = this.state.session;
      return this.send("set_places", { places: { ...places, ...change(places) } });
    });
  }

  /** The object that corrections go to. */
  #mine() {
    const item = selectedItem(this.state);
    if (!item) announce("Choose an object first.");
    return item;
  }
}

// Playing: each frame is shown at its time; slow pictures make it skip frames.

import { explain, tried } from "./announce.js";
import { ask } from "./api.js";
import { frameAt, timeOf } from "./derived.js";

const WIDEST = 1920; // pixels: wider pictures would not be sharper on most screens
const AHEAD = 3; // pictures on their way while a run is followed: one is made, one sent, one decoded

export class Player {
  #started = null;
  #handle = 0;
  #looks = 0;
  #seen = 0;

  constructor(store, pictures) {
    this.store = store;
    this.pictures = pictures;
    store.on(["playing"], ({ playing }) => (playing ? this.#start() : this.#stop()));
    store.on(["frame", "film", "connected"], () => this.#look());
    store.on(["film"], ({ session, film }) => film && this.#readTimes(session, film));
  }

  /** Go where a person wants to be: to a frame, or to the nearest one of the film. What moved the film ends. */
  go(frame) {
    this.store.set({ playing: false, following: false });
    this.show(frame);
  }

  /** Stay at the picture that is seen: one that comes late does not take its place. */
  stay() {
    const { pictured, frame } = this.store.state;
    this.go(pictured ?? frame);
  }

  /** Show a frame, or the nearest one of the film. */
  show(frame) {
    const { film } = this.store.state;
    if (!film) return;
    this.store.set({ frame: Math.min(film.frames - 1, Math.max(0, Math.round(frame))) });
  }

  /** Whether one more picture may be asked for without those before it coming later. */
  get free() {
    return this.pictures.running < AHEAD;
  }

  step(count) {
    this.go(this.store.state.frame + count);
  }

  toggle() {
    const { playing, frame, film } = this.store.state;
    if (!film) return;
    if (!playing && frame >= film.frames - 1) this.show(0);
    this.store.set({ playing: !playing, following: false });
  }

  #start() {
    const { frame } = this.store.state;
    this.#started = { frame, at: performance.now() };
    this.#handle = requestAnimationFrame(() => this.#tick());
  }

  #stop() {
    cancelAnimationFrame(this.#handle);
    this.#started = null;
  }

  #tick() {
    const { film, speed, playing } = this.store.state;
    if (!playing || !film) return;
    const seconds = (performance.now() - this.#started.at) / 1000;
    const due = frameAt(this.store.state, timeOf(this.store.state, this.#started.frame) + seconds * speed);
    const ended = due >= film.frames - 1;
    if (ended || this.pictures.takes(due)) { // else those on their way come first: over a slow network none would
      for (let ahead = 0; ahead <= 3; ahead += 1) {
        if (due + ahead < film.frames) this.pictures.want(due + ahead, { urgent: false }).catch(() => {});
      }
      this.show(due);
    }
    if (ended) this.store.set({ playing: false });
    else this.#handle = requestAnimationFrame(() => this.#tick());
  }

  async #readTimes(session, film) {
    const times = await tried(ask(`/api/sessions/${session.id}/times`), "The film plays evenly: ");
    if (times && this.store.state.film === film) this.store.set({ times });
  }

  /** Fetch the picture of the frame; what is drawn over the film waits for it. */
  async #look() {
    const { film, frame, session, awaited } = this.store.state;
    if (!film) return;
    awaited.add(frame);
    this.pictures.choose(session.id, film, Math.min(film.width, WIDEST));
    const look = (this.#looks += 1);
    try {
      const picture = await this.pictures.want(frame);
      const late = look < this.#seen; // a picture that was asked for later is shown already
      if (!picture || late || this.store.state.film !== film) return;
      this.#seen = look;
      this.store.set({ pictured: frame });
      this.store.touch("picture");
      if (!this.store.state.playing && !this.store.state.following) this.#ahead(frame);
    } catch (error) {
      explain(error, `Frame ${frame} cannot be shown: `);
    } finally {
      awaited.delete(frame);
    }
  }

  /** Fetch the frame after one that stands still; the one before costs as much as any other. */
  #ahead(frame) {
    if (frame + 1 < this.store.state.film.frames) {
      this.pictures.want(frame + 1, { urgent: false }).catch(() => {});
    }
  }
}

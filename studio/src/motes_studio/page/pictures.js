// Pictures of the film: fetched when they are looked at, kept while there is room.

import { askPicture } from "./api.js";

const ROOM = 1 << 28; // bytes of decoded pictures, four for each pixel
const AT_ONCE = 4;

export class Pictures {
  #kept = new Map(); // in the order of their last use
  #bytes = 0;
  #running = new Map();
  #film = null;
  #address = null;

  /** Choose the film of a session, and the largest width of its pictures. A film may be opened anew, with other frames. */
  choose(session, film, width) {
    if (film === this.#film) return;
    this.clear();
    this.#film = film;
    this.#address = (frame) =>
      `/api/sessions/${session}/frames/${frame}.jpg?width=${width}&frames=${film.frames}&whole=${film.problems !== null}`;
  }

  clear() {
    this.#film = null;
    for (const control of this.#running.values()) control.control.abort();
    for (const picture of this.#kept.values()) picture.close();
    this.#running.clear();
    this.#kept.clear();
    this.#bytes = 0;
  }

  /** The number of pictures that are on their way. */
  get running() {
    return this.#running.size;
  }

  /** Whether a picture may be asked for without that of another frame giving way. */
  takes(frame) {
    return this.#kept.has(frame) || this.#running.has(frame) || this.#running.size < AT_ONCE;
  }

  /** Return the picture of a frame if it is here, else null. */
  get(frame) {
    const picture = this.#kept.get(frame);
    if (!picture) return null;
    this.#kept.delete(frame);
    this.#kept.set(frame, picture);
    return picture;
  }

  /** Return the picture of a frame once it has come. What waits for other frames gives way. */
  async want(frame, { urgent = true } = {}) {
    const here = this.get(frame);
    if (here) return here;
    const running = this.#running.get(frame);
    if (running) return running.picture;
    if (this.#running.size >= AT_ONCE) {
      if (!urgent) return null;
      const [oldest, { control }] = this.#running.entries().next().value;
      control.abort();
      this.#running.delete(oldest);
    }
    const control = new AbortController();
    const picture = this.#fetch(frame, control);
    this.#running.set(frame, { control, picture });
    return picture;
  }

  async #fetch(frame, control) {
    try {
      const picture = await askPicture(this.#address(frame), control.signal);
      if (control.signal.aborted) {
        picture.close();
        return null;
      }
      this.#kept.set(frame, picture);
      this.#bytes += bytes(picture);
      this.#forget();
      return picture;
    } catch (error) {
      if (error.name === "AbortError") return null;
      throw error;
    } finally {
      if (this.#running.get(frame)?.control === control) this.#running.delete(frame);
    }
  }

  #forget() {
    while (this.#bytes > ROOM) {
      const [frame, picture] = this.#kept.entries().next().value;
      this.#bytes -= bytes(picture);
      picture.close();
      this.#kept.delete(frame);
    }
  }
}

const bytes = ({ width, height }) => 4 * width * height;

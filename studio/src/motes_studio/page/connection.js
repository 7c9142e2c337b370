// The WebSocket of a session: commands go out, messages come in; it connects again when it breaks.

import { announce } from "./announce.js";
import { encode } from "./protocol.js";
import { MESSAGES } from "./messages.js";

const PAUSES = [300, 600, 1200, 2500, 5000];

export class Connection {
  #socket = null;
  #next = 1;
  #waiting = new Map();
  #tries = 0;
  #closed = false;
  #known = false; // whether this socket has had the session's state

  constructor(store, session) {
    this.store = store;
    this.session = session;
    this.#open();
  }

  /** Send a command; resolve with its reply, or throw what the server answers. */
  send(type, fields = {}) {
    if (this.#socket?.readyState !== WebSocket.OPEN) {
      return Promise.reject(new Error("The server does not answer. The change was not made."));
    }
    const id = this.#next++;
    this.#socket.send(encode(type, id, fields));
    if (type === "acknowledge") return Promise.resolve();
    return new Promise((resolve, reject) => this.#waiting.set(id, { resolve, reject }));
  }

  close() {
    this.#closed = true;
    this.#socket.close();
  }

  #open() {
    this.#known = false;
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.#socket = new WebSocket(`${scheme}://${location.host}/api/sessions/${this.session}/ws`);
    this.#socket.addEventListener("open", () => {
      this.#tries = 0;
      this.store.set({ connected: true, asked: null }); // the server may be another one
    });
    this.#socket.addEventListener("message", ({ data }) => this.#take(JSON.parse(data)));
    this.#socket.addEventListener("close", () => this.#lost());
  }

  #take(message) {
    if (message.type === "reply") {
      const waiting = this.#waiting.get(message.id);
      this.#waiting.delete(message.id);
      if (!message.error) waiting?.resolve(message);
      else if (waiting) waiting.reject(new Error(message.error));
      else announce(message.error, "error"); // nobody waits for it
      return;
    }
    MESSAGES[message.type](this.store, message);
    this.#known ||= message.type === "state";
    if (message.type === "failure" && !this.#known) {
      this.close();
      location.hash = ""; // the session is gone, or its film cannot be read
    }
    if (message.type === "overlay") {
      requestAnimationFrame(() => this.send("acknowledge", { number: message.number }).catch(() => {}));
    }
  }

  #lost() {
    for (const { reject } of this.#waiting.values()) reject(new Error("The connection broke off."));
    this.#waiting.clear();
    if (this.#closed) return;
    this.store.set({ connected: false });
    const pause = PAUSES[Math.min(this.#tries, PAUSES.length - 1)];
    this.#tries += 1;
    setTimeout(() => this.#closed || this.#open(), pause);
  }
}

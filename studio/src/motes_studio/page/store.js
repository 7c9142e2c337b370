// The state of the page. Views read it and draw; only `set` changes it.

export class Store {
  #changed = new Set();
  #views = [];
  #due = false;

  constructor(state) {
    this.state = state;
  }

  /** Change parts of the state; views of these parts are drawn before the next paint. */
  set(changes) {
    for (const [name, value] of Object.entries(changes)) {
      if (!(name in this.state)) throw new Error(`The state has no ${name}.`);
      if (Object.is(this.state[name], value)) continue;
      this.state[name] = value;
      this.#changed.add(name);
    }
    if (this.#changed.size) this.#schedule();
  }

  /** Draw the views of parts whose contents were changed in place, such as rows. */
  touch(...names) {
    for (const name of names) this.#changed.add(name);
    this.#schedule();
  }

  /** Call view(state) now, and again whenever one of the parts has changed. */
  on(names, view) {
    this.#views.push({ names, view });
    view(this.state);
  }

  #schedule() {
    if (this.#due) return;
    this.#due = true;
    requestAnimationFrame(() => this.#flush());
  }

  #flush() {
    this.#due = false;
    const changed = this.#changed;
    this.#changed = new Set();
    for (const { names, view } of this.#views) {
      if (names.some((name) => changed.has(name))) view(this.state);
    }
  }
}

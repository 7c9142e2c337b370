// What each message of the server changes in the page's state.

import { announce } from "./announce.js";
import { named, ROW, SCENE_OBJECT } from "./protocol.js";

const PAUSE = 1000; // milliseconds without news of an object after which the film follows another one
const OVERLAYS = 50; // of an object that are kept, without those whose pictures are on their way

export const MESSAGES = {
  state(store, { session }) {
    const { selected, frame } = store.state;
    const known = new Set(session.objects.map(({ object }) => object));
    for (const kept of [store.state.rows, store.state.overlays, store.state.doubts]) {
      for (const object of kept.keys()) if (!known.has(object)) kept.delete(object);
    }
    store.set({
      session,
      film: sameFilm(store.state.film, session.film),
      frame: Math.min(frame, session.film.frames - 1),
      selected: known.has(selected) ? selected : session.objects[0]?.object ?? null,
      jobs: new Map(session.jobs.map((job) => [job.job, job])),
    });
  },

  rows(store, { object, rows, reset }) {
    if (reset) store.state.overlays.delete(object);
    const kept = (!reset && store.state.rows.get(object)) || [];
    for (const values of rows) {
      const row = named(ROW, values);
      kept[row.frame] = row;
    }
    store.state.rows.set(object, kept);
    store.touch("rows");
  },

  overlay(store, overlay) {
    const { object, frame } = overlay;
    const { overlays, awaited, pictured } = store.state;
    const kept = overlays.get(object) ?? new Map();
    kept.delete(frame);
    kept.set(frame, overlay);
    const unused = [...kept.keys()].filter((at) => !awaited.has(at) && at !== pictured);
    if (unused.length > OVERLAYS) kept.delete(unused[0]);
    overlays.set(object, kept);
    if (isFollowed(store.state, object)) store.set({ newest: { object, frame, at: performance.now() } });
    store.touch("overlays");
  },

  progress(store, { type, ...job }) {
    const before = store.state.jobs.get(job.job);
    store.set({ jobs: new Map(store.state.jobs).set(job.job, job) });
    if (job.note && job.note !== before?.note) announce(job.note, "error");
    if (job.status === "failed") announce(job.error ?? "The run has failed.", "error");
  },

  scene(store, { frames, events, objects, totals, reset }) {
    const scene = reset ? [] : store.state.scene;
    let last = null;
    for (const [frame, time, seen] of frames) {
      scene[frame] = { frame, time, objects: seen.map((values) => named(SCENE_OBJECT, values)) };
      last = frame;
    }
    store.set({ scene, counts: scene.length ? { objects, totals } : null });
    if (reset || events.length) store.set({ events: reset ? events : [...store.state.events, ...events] });
    store.touch("scene");
    if (last !== null) store.set({ newest: { object: null, frame: last, at: performance.now() } });
  },

  failure(store, { error }) {
    announce(error, "error");
  },
};

/** Whether the film goes where an object is tracked: the chosen one, else one at a time; it would leap between several. */
const isFollowed = ({ newest, selected }, object) =>
  [selected, newest?.object ?? object].includes(object) || performance.now() - newest.at > PAUSE;

/** Keep the known film if it is the same: views of the film need not be drawn again. */
const sameFilm = (old, film) => (JSON.stringify(old) === JSON.stringify(film) ? old : film);

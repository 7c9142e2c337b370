// What each message of the server changes in the page's state.

import { announce } from "./announce.js";
import { named, ROW, SCENE_OBJECT } from "./protocol.js";

const OVERLAYS = 50; // of an object that are kept, until their pictures have come

export const MESSAGES = {
  state(store, { session }) {
    const { selected } = store.state;
    const known = new Set(session.objects.map(({ object }) => object));
    for (const object of store.state.rows.keys()) if (!known.has(object)) store.state.rows.delete(object);
    store.set({
      session,
      film: sameFilm(store.state.film, session.film),
      selected: known.has(selected) ? selected : session.objects[0]?.object ?? null,
      jobs: new Map(session.jobs.map((job) => [job.job, job])),
    });
  },

  rows(store, { object, rows, reset }) {
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
    const kept = store.state.overlays.get(object) ?? new Map();
    kept.delete(frame);
    kept.set(frame, overlay);
    if (kept.size > OVERLAYS) kept.delete(kept.keys().next().value);
    store.state.overlays.set(object, kept);
    const seen = store.state.seen.get(overlay.object) ?? [];
    seen[overlay.frame] = { milliseconds: overlay.milliseconds, supporting: overlay.supporting ?? NaN };
    store.state.seen.set(overlay.object, seen);
    store.set({ newest: { object, frame } });
    store.touch("overlays");
  },

  progress(store, { type, ...job }) {
    store.set({ jobs: new Map(store.state.jobs).set(job.job, job) });
    if (job.status === "failed") announce(job.error ?? "The run has failed.", "error");
  },

  doubts(store, { object, items }) {
    store.set({ doubts: new Map(store.state.doubts).set(object, items) });
  },

  layers(store, layers) {
    const { looked } = store.state;
    const same = looked?.object === layers.object && looked.frame === layers.frame;
    store.set({ looked: same ? together(looked, layers) : layers });
  },

  scene_rows(store, { frames, reset }) {
    const scene = reset ? [] : store.state.scene;
    let last = null;
    for (const [frame, time, objects] of frames) {
      scene[frame] = { frame, time, objects: objects.map((values) => named(SCENE_OBJECT, values)) };
      last = frame;
    }
    store.set({ scene });
    store.touch("scene");
    if (last !== null) store.set({ newest: { object: null, frame: last } });
  },

  scene_events(store, { events, reset }) {
    store.set({ events: reset ? events : [...store.state.events, ...events] });
  },

  counts(store, { objects, totals }) {
    store.set({ counts: { objects, totals } });
  },

  failure(store, { error }) {
    announce(error, "error");
  },
};

/** Return the layers of two answers about the same frame, which may come in any order. */
const together = (old, now) => ({
  ...now,
  rho: now.rho ?? old.rho,
  likelihoods: { ...old.likelihoods, ...now.likelihoods },
  histograms: { ...old.histograms, ...now.histograms },
  orientation: { ...old.orientation, ...now.orientation },
  ...(now.particles.length ? {} : { particles: old.particles, weights: old.weights }),
});

/** Keep the known film if it is the same: views of the film need not be drawn again. */
const sameFilm = (old, film) => (JSON.stringify(old) === JSON.stringify(film) ? old : film);

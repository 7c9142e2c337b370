// Pointing at the stage: drawing, moving by handles, panning, zooming, with mouse, pen or fingers.

import { announce } from "./announce.js";
import { asEllipse, between, contains, dragged, handles, moved } from "./geometry.js";
import { textScale } from "./dom.js";
import { nextColor } from "./colors.js";
import { regionOf, selectedItem, shownItems } from "./derived.js";
import { addCorner, endLine } from "./places.js";

const NEAR = 11; // pixels of the screen around a handle
const FINGER = 24; // those of a finger, which is broader, and hides what is under it
const SLIP = 3; // a pointer that moved less has clicked

/** Let the stage be drawn on. */
export function mountEditing(stage, app) {
  const { store, player, actions } = app;
  const pointers = new Map();
  let gesture = null;
  const at = (event) => [event.offsetX, event.offsetY];

  stage.canvas.addEventListener("pointerdown", (event) => {
    stage.canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, at(event));
    if (pointers.size === 2) {
      store.set({ draft: null });
      gesture = pinch(store, stage, [...pointers.values()]);
    } else if (pointers.size === 1) gesture = begin(event);
  });
  stage.canvas.addEventListener("pointermove", (event) => {
    if (!pointers.has(event.pointerId)) {
      stage.canvas.style.cursor = cursorAt(at(event));
      return;
    }
    pointers.set(event.pointerId, at(event));
    gesture?.move(at(event), [...pointers.values()]);
  });
  const end = (event) => {
    if (!pointers.delete(event.pointerId)) return;
    if (pointers.size === 0) {
      if (event.type === "pointerup") gesture?.end(at(event));
      else store.set({ draft: null });
      gesture = null;
    }
  };
  stage.canvas.addEventListener("pointerup", end);
  stage.canvas.addEventListener("pointercancel", end);
  stage.canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    store.set({ view: stage.view().zoomed(Math.exp(-event.deltaY / 400), at(event)) });
  }, { passive: false });

  function begin(event) {
    const point = stage.view().toFilm(at(event));
    const { tool } = store.state;
    if (event.button === 1 || event.altKey || tool === "hand") return pan(store, stage, at(event));
    if (event.button !== 0) return null;
    player.stay();
    const reach = event.pointerType === "touch" ? FINGER : NEAR;
    if (store.state.draft?.byKeys) return dragDraft(point, reach) ?? pan(store, stage, at(event));
    if (tool === "box" || tool === "ellipse") return draw(point, tool);
    if (tool === "line") return drawLine(point);
    if (tool === "zone" || tool === "ground") return click(point, reach);
    return grab(point, reach) ?? pan(store, stage, at(event), () => store.set({ draft: null }));
  }

  /** Whether a gesture's draft is still the one: Escape may have ended it, and an earlier one may wait for its answer. */
  const isMine = (draft) => draft !== null && store.state.draft === draft;

  /** Draw a new region from corner to corner. */
  function draw(start, kind) {
    const { redrawing, session, pictured } = store.state;
    const item = redrawing ? selectedItem(store.state) : null;
    const color = item?.color ?? nextColor(session.objects);
    const object = item?.object ?? null;
    let draft = null;
    return {
      move(where) {
        draft = { object, frame: pictured, color, region: between(start, stage.view().toFilm(where), kind) };
        store.set({ draft });
      },
      end(where) {
        const [x, y] = stage.view().toScreen(start);
        if (!isMine(draft)) return;
        if (Math.hypot(where[0] - x, where[1] - y) > SLIP) return actions.commit(draft);
        store.set({ draft: null });
        announce("This is too small; drag from one corner of the object to the other.");
      },
    };
  }

  /** Take the handle or the object under the pointer: what is dragged becomes a keyframe. */
  function grab(point, reach) {
    const { selected, pictured } = store.state;
    const items = shownItems(store.state);
    const first = items.filter(({ object }) => object === selected);
    const region = (item) => regionOf(store.state, item, pictured);
    for (const item of first) {
      const handle = handleAt(region(item), point, reach);
      if (handle) return change(item, point, region(item), (start, to) => dragged(start, handle, to));
    }
    const under = [...first, ...items].find((item) => region(item) && contains(region(item), point));
    if (!under) return null;
    store.set({ selected: under.object });
    return change(under, point, region(under), (start, to) => moved(start, to[0] - point[0], to[1] - point[1]));
  }

  function change(item, point, start, shaped) {
    const { object, color } = item;
    const frame = store.state.pictured;
    const [x, y] = stage.view().toScreen(point);
    let draft = null;
    return {
      move(where) {
        if (!draft && Math.hypot(where[0] - x, where[1] - y) < SLIP) return;
        draft = { object, frame, color, region: shaped(start, stage.view().toFilm(where)) };
        store.set({ draft });
      },
      end: () => isMine(draft) && actions.commit(draft),
    };
  }

  /** Move the draft that was begun with keys. */
  function dragDraft(point, reach) {
    const { draft } = store.state;
    const handle = handleAt(draft.region, point, reach);
    if (!handle && !contains(draft.region, point)) return null;
    return {
      move(where) {
        const to = stage.view().toFilm(where);
        const region = handle
          ? dragged(draft.region, handle, to)
          : moved(draft.region, to[0] - point[0], to[1] - point[1]);
        store.set({ draft: { ...draft, region } });
      },
      end: () => {},
    };
  }

  function drawLine(start) {
    return {
      move: (where) => store.set({ corners: [start, stage.view().toFilm(where)] }),
      end: () => endLine(app),
    };
  }

  function click(point, reach) {
    return { move: () => {}, end: () => addCorner(app, point, reach / stage.view().scale) };
  }

  /** Return the handle within reach of a point. Of a small region, at least half is left to move it by. */
  function handleAt(region, point, reach = NEAR) {
    if (!region) return null;
    const scale = stage.view().scale / textScale();
    const away = ([x, y], [u, v]) => Math.hypot(x - u, y - v) * scale;
    const all = handles(region, 22 / scale);
    const half = Math.min(...all.map((handle) => away(handle.point, asEllipse(region)))) / 2;
    const near = Math.max(NEAR, Math.min(reach, half));
    const [found] = all.sort((one, two) => away(one.point, point) - away(two.point, point));
    return away(found.point, point) < near ? found.name : null;
  }

  function cursorAt(where) {
    const { tool, session, pictured } = store.state;
    if (tool === "hand") return "grab";
    if (tool !== "select" || !session) return "crosshair";
    const point = stage.view().toFilm(where);
    const item = selectedItem(store.state);
    const region = item && regionOf(store.state, item, pictured);
    if (item && handleAt(region, point)) return "pointer";
    return region && contains(region, point) ? "move" : "default";
  }
}

function pan(store, stage, start, clicked = () => {}) {
  const view = stage.view();
  let far = false;
  return {
    move([x, y]) {
      far ||= Math.hypot(x - start[0], y - start[1]) > SLIP;
      if (far) store.set({ view: view.panned(x - start[0], y - start[1]) });
    },
    end: () => far || clicked(),
  };
}

function pinch(store, stage, [one, two]) {
  const view = stage.view();
  const middle = (a, b) => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
  const apart = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]) || 1;
  const [start, length] = [middle(one, two), apart(one, two)];
  return {
    move(_, [a, b]) {
      if (!b) return;
      const now = middle(a, b);
      const zoomed = view.zoomed(apart(a, b) / length, start);
      store.set({ view: zoomed.panned(now[0] - start[0], now[1] - start[1]) });
    },
    end: () => {},
  };
}

// The strip of thumbnails: small pictures from the whole film; a drag over it scrubs.

import { color, element, sized } from "./dom.js";
import { announce } from "./announce.js";
import { askPicture } from "./api.js";

export function mountStrip(root, { store, player }) {
  const canvas = element("canvas", { class: "thumbnails", "aria-label": "Thumbnails of the film", role: "img" });
  root.append(canvas);
  let picture = null;
  let of = null;
  const draw = () => paint(canvas, store.state, picture);
  store.on(["film", "session"], async ({ session, film }) => {
    if (!film || of === film) return;
    of = film;
    picture = null;
    try {
      const found = await fetchStrip(session, canvas);
      if (of !== film) return; // another one was opened meanwhile
      picture = found;
    } catch (error) {
      announce(`The thumbnails cannot be shown: ${error.message}`, "error");
    }
    draw();
  });
  store.on(["frame", "film", "looks", "sized"], draw);
  new ResizeObserver(draw).observe(canvas);
  const seek = (event) => {
    const { film } = store.state;
    if (!film) return;
    player.go(Math.floor((event.offsetX / canvas.clientWidth) * film.frames));
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    seek(event);
  });
  canvas.addEventListener("pointermove", (event) => event.buttons && seek(event));
}

/** Return the strip as one picture: thumbnails of the film's shape, as many as fit. */
async function fetchStrip({ id, film }, canvas) {
  const height = Math.round(canvas.clientHeight * Math.min(2, window.devicePixelRatio || 1));
  const shape = (canvas.clientHeight * film.width) / film.height;
  const count = Math.max(4, Math.min(40, Math.ceil(canvas.clientWidth / shape)));
  return askPicture(`/api/sessions/${id}/strip?count=${count}&height=${height}`);
}

function paint(canvas, { film, frame }, picture) {
  const context = sized(canvas);
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  context.fillStyle = color("--empty");
  context.fillRect(0, 0, width, height);
  if (!film) return;
  if (picture) context.drawImage(picture, 0, 0, width, height);
  const x = ((frame + 0.5) / film.frames) * width;
  context.fillStyle = "rgba(0, 0, 0, 0.6)";
  context.fillRect(x - 2, 0, 4, height);
  context.fillStyle = "#fff";
  context.fillRect(x - 1, 0, 2, height);
}

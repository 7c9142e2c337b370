// The strip of thumbnails: small pictures from the whole film; a drag over it scrubs.

import { color, element, scrub, sized } from "./dom.js";
import { tried } from "./announce.js";
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
    const found = await tried(fetchStrip(session, canvas), "The thumbnails cannot be shown: ");
    if (of !== film) return; // another one was opened meanwhile
    picture = found;
    draw();
  });
  store.on(["frame", "film", "looks", "sized"], draw);
  new ResizeObserver(draw).observe(canvas);
  scrub(canvas, (x) => {
    const { film } = store.state;
    if (film) player.go(Math.floor((x / canvas.clientWidth) * film.frames));
  });
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

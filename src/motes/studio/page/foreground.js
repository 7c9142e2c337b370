// The foreground of the many-object mode: a picture whose light pixels move.

import { announce } from "./announce.js";
import { reason } from "./api.js";

/** Fetch the foreground of the frame that is shown, and keep it in the state. */
export async function foregroundOf({ store }) {
  const { session, pictured, film, foreground } = store.state;
  if (pictured === null || foreground?.frame === pictured) return;
  const answer = await fetch(`/api/sessions/${session.id}/foreground/${pictured}.png`);
  if (!answer.ok) {
    announce(await reason(answer), "error");
    return;
  }
  const picture = await createImageBitmap(await answer.blob());
  store.set({ foreground: { frame: pictured, picture, film } });
}

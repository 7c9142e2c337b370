// The foreground of the many-object mode: a picture whose light pixels move.

import { announce } from "./announce.js";
import { askPicture } from "./api.js";

let asked = { address: null, control: null };

/** Fetch the foreground of the frame that is shown, and keep it in the state; an earlier request is given up. */
export async function foregroundOf({ store }) {
  const { session, pictured, film, foreground } = store.state;
  const address = `/api/sessions/${session.id}/foreground/${pictured}.png`;
  if (pictured === null || foreground?.frame === pictured || asked.address === address) return;
  asked.control?.abort();
  const mine = { address, control: new AbortController() };
  asked = mine;
  try {
    const picture = await askPicture(address, mine.control.signal);
    if (asked === mine) store.set({ foreground: { frame: pictured, picture, film } });
  } catch (error) {
    if (error.name !== "AbortError") announce(error.message, "error");
  } finally {
    if (asked === mine) asked = { address: null, control: null };
  }
}

// What comes over HTTP: films, presets, sessions, files. What is refused throws the server's own words.

const SOON = 409; // the film is read anew, and the session comes again with it

/** Return the JSON of an address; null where it has none. */
export async function ask(address, { method = "GET", body, signal } = {}) {
  const answer = await answerOf(address, { method, signal, body: body && JSON.stringify(body) });
  return answer.status === 204 ? null : answer.json();
}

/** Return the picture of an address. */
export async function askPicture(address, signal) {
  const answer = await answerOf(address, { signal });
  return createImageBitmap(await answer.blob());
}

/** Return the answer of an address. */
export async function answerOf(address, options) {
  const answer = await fetch(address, options).catch((error) => {
    throw error.name === "AbortError" ? error : new Error("The server does not answer.");
  });
  if (answer.ok) return answer;
  throw Object.assign(new Error(reason(await answer.text(), answer.status)), { soon: answer.status === SOON });
}

/** Send a file and report the share that has gone; `fetch` knows no progress of what it sends. */
export function send(address, file, progress = () => {}) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open("POST", address);
    request.upload.addEventListener("progress", ({ loaded, total }) => progress(loaded / total));
    request.addEventListener("load", () => {
      const { status, responseText: text } = request;
      if (status < 300) resolve(JSON.parse(text));
      else reject(new Error(reason(text, status)));
    });
    request.addEventListener("error", () => reject(new Error("The connection broke off.")));
    request.send(file);
  });
}

/** Return why a request was refused, in one line. */
function reason(text, status) {
  try {
    return JSON.parse(text).error ?? text;
  } catch {
    return text || `The server answered ${status}.`;
  }
}

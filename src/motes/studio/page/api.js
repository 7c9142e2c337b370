// What comes over HTTP: films, presets, sessions, files.

/** Return the JSON of an address; throw the server's own words if it refuses. */
export async function ask(address, { method = "GET", body = undefined, signal = undefined } = {}) {
  const headers = body === undefined ? {} : { "content-type": "application/json" };
  const answer = await fetch(address, {
    method,
    headers,
    signal,
    body: body === undefined ? undefined : JSON.stringify(body),
  });
  if (!answer.ok) throw new Error(await reason(answer));
  return answer.status === 204 ? null : answer.json();
}

/** Return the picture of an address; throw the server's own words if it refuses. */
export async function askPicture(address, signal) {
  const answer = await fetch(address, { signal });
  if (!answer.ok) throw new Error(await reason(answer));
  return createImageBitmap(await answer.blob());
}

/** Return why a request was refused, in one line. */
export async function reason(answer) {
  const text = await answer.text();
  try {
    return JSON.parse(text).error ?? text;
  } catch {
    return text || `The server answered ${answer.status}.`;
  }
}

/** Send a file and report the share that has gone; `fetch` knows no progress of what it sends. */
export function send(address, file, progress) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open("POST", address);
    request.upload.addEventListener("progress", ({ loaded, total }) => progress(loaded / total));
    request.addEventListener("load", () => {
      const read = () => JSON.parse(request.responseText);
      if (request.status < 300) resolve(request.responseText ? read() : null);
      else {
        let words = request.responseText;
        try {
          words = read().error;
        } catch {
          // plain text is the reason itself
        }
        reject(new Error(words || `The server answered ${request.status}.`));
      }
    });
    request.addEventListener("error", () => reject(new Error("The connection broke off.")));
    request.send(file);
  });
}

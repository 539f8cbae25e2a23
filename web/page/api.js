// The REST routes: one call each, errors as sentences.

let lease = ""; // this page's name in it

/** @param {string} name */
export const goBy = (name) => {
  lease = name;
};

/**
 * @param {string} method
 * @param {string} path below /api/v1
 * @param {object} [body]
 */
export async function ask(method, path, body) {
  const answer = await fetch(`api/v1/${path}`, {
    method,
    headers: { "x-lease": lease, ...(body && { "content-type": "application/json" }) },
    body: body && JSON.stringify(body),
  });
  const data = await answer.json().catch(() => ({}));
  if (!answer.ok) throw new Error(data.detail ?? `${answer.status} ${answer.statusText}`);
  return data;
}

/**
 * Ask, and say what went wrong where something did.
 * @param {(text: string) => void} say
 * @param {string} method
 * @param {string} path
 * @param {object} [body]
 * @returns {Promise<boolean>} whether it was done
 */
export async function order(say, method, path, body) {
  try {
    await ask(method, path, body);
    return true;
  } catch (error) {
    say(error instanceof Error ? error.message : String(error));
    return false;
  }
}

// Doors of the server: a request at a time for what a drag asks, lines for what runs long.

const byId = (id) => document.getElementById(id);

async function door(name, body, signal) {
  try {
    const answer = await fetch(name, { method: 'POST', body, signal });
    byId('gone').hidden = true;
    return answer;
  } catch (error) {
    if (error.name !== 'AbortError') byId('gone').hidden = false;
    throw error;
  }
}

/** Answer in JSON, { refused: [{ key, text }] } for what cannot be. */
export async function ask(name, message) {
  return (await door(name, JSON.stringify(message))).json();
}

/** Facts and numbers of the walker: { facts, positions, legs }, or { refused }. */
export async function askWalker(message) {
  const answer = await door('walker', JSON.stringify(message));
  if (!answer.ok) return answer.json();
  const data = await answer.arrayBuffer();
  const end = new Uint8Array(data).indexOf(10);
  const facts = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 0, end)));
  const positions = new Float32Array(data, end + 1, 9 * facts.triangles);
  const legs = new Uint8Array(data, end + 1 + 36 * facts.triangles, facts.triangles);
  return { facts, positions, legs };
}

/** Files: the answer itself, whose body is the file. */
export const askFile = (message) => door('take', JSON.stringify(message));

export async function upload(file) {
  const kind = file.name.split('.').pop();
  return (await door(`upload?kind=${encodeURIComponent(kind)}`, file)).json();
}

/** Events of what runs long, one by one; aborting the signal ends it on the server. */
export async function* events(name, message, signal) {
  const answer = await door(name, JSON.stringify(message), signal);
  if (!answer.ok) {
    yield { refused: (await answer.json()).refused.map(({ text }) => text) };
    return;
  }
  const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
  let rest = '';
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    const lines = (rest + value).split('\n');
    rest = lines.pop();
    for (const line of lines) yield JSON.parse(line);
  }
}

/**
 * Function that does `work(argument)`, one at a time: while it runs only the last call waits, so
 * that what was asked last is always what is shown last.
 */
export function lastOnly(work) {
  let [busy, next] = [false, null];
  return async function again(...given) {
    next = given;
    if (busy) return;
    busy = true;
    try {
      while (next) {
        const call = next;
        next = null;
        await work(...call);
      }
    } finally {
      busy = false;
    }
  };
}

/** Function that does `work` once nobody has called it for a while. */
export function settled(work, pause) {
  let timer = 0;
  return (...given) => {
    clearTimeout(timer);
    timer = setTimeout(() => work(...given), pause);
  };
}

export { byId };

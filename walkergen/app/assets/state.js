// The document of the page: names of a walker, a scene and a printer, and the keys set anew in them.
// It never changes in place, so that undo is a list of documents.

const KEPT = 'walkergen-document';
const MOST = 500; // steps that can be undone

let now = null;
const [past, future, listeners] = [[], [], []];
let joining = ''; // key that is being dragged: its steps are one

export const current = () => now;
export const canUndo = () => past.length > 0;
export const canRedo = () => future.length > 0;
export const listen = (listener) => listeners.push(listener);

function become(next, why) {
  now = next;
  sessionStorage.setItem(KEPT, JSON.stringify(next));
  for (const listener of listeners) listener(next, why);
}

/** Document of this tab before a reload, or null. */
export function remembered() {
  try {
    return JSON.parse(sessionStorage.getItem(KEPT));
  } catch {
    return null;
  }
}

export const begin = (next) => become(next, 'begin');

/** Change the document; changes of the same key in a row, as of a drag, are undone together. */
export function change(next, why, key = '') {
  if (JSON.stringify(next) === JSON.stringify(now)) return;
  if (!key || key !== joining) past.push(now);
  if (past.length > MOST) past.shift();
  joining = key;
  future.length = 0;
  become(next, why);
}

export const endDrag = () => (joining = '');

function step(from, to) {
  if (!from.length) return;
  to.push(now);
  joining = '';
  become(from.pop(), 'history');
}

export const undo = () => step(past, future);
export const redo = () => step(future, past);

// Table or list among the values in which a key stands, and the steps to it from there.
function holder(values, key) {
  const own = Object.keys(values).find((outer) => key.startsWith(`${outer}.`) || key.startsWith(`${outer}[`));
  if (!own) return null;
  const steps = key.slice(own.length).match(/[A-Za-z_]\w*|\d+(?=\])/g);
  return { own, steps: steps.map((each) => (/^\d+$/.test(each) ? Number(each) - 1 : each)) };
}

// Values in which a key is set anew; undefined leaves it as the file has it.
function withKey(before, key, value) {
  const values = structuredClone(before);
  const inside = holder(values, key);
  if (inside) {
    const last = inside.steps.pop();
    let place = values[inside.own];
    for (const each of inside.steps) place = place[each] ??= {};
    if (value === undefined) delete place[last];
    else place[last] = value;
  } else if (value === undefined) delete values[key];
  else values[key] = value;
  return values;
}

/** Set a key anew; undefined leaves it as the file has it. */
export const set = (key, value, why = 'value') =>
  change({ ...now, values: withKey(now.values, key, value) }, why, why === 'value' ? key : '');

/** Set several keys anew, as one step. */
export function setAll(settings) {
  const values = Object.entries(settings).reduce((kept, [key, value]) => withKey(kept, key, value ?? undefined), now.values);
  change({ ...now, values }, 'shape');
}

/** Values without those of some keys, by the beginnings of their names. */
export const without = (values, ...beginnings) =>
  Object.fromEntries(
    Object.entries(values).filter(([key]) => !beginnings.some((each) => key.startsWith(each))),
  );

/** True where a key is set anew. */
export function isSet(key) {
  if (key in now.values) return true;
  const inside = holder(now.values, key);
  if (!inside) return false;
  let place = now.values[inside.own];
  for (const each of inside.steps) place = place?.[each];
  return place !== undefined;
}

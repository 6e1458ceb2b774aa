// A second design beside the first: its picture, its speed, and in what the two differ.

import { byId } from './ask.js';
import { make, nameOf } from './form.js';
import { viewerOf } from './part.js';
import { change, current } from './state.js';

let held = null; // document and walker
let viewer = null;

const flat = (document) => ({
  walker: document.walker, scene: document.scene, printer: document.printer, ...document.values,
});
const words = (value) => (value === undefined ? 'as it was' : typeof value === 'object' ? JSON.stringify(value) : value);

const speedWords = (speed) => (speed === null ? 'speed not known yet' : `${speed.toFixed(1)} mm/s`);

function differences(one, other) {
  const [a, b] = [flat(one), flat(other)];
  return [...new Set([...Object.keys(a), ...Object.keys(b)])]
    .filter((key) => JSON.stringify(a[key]) !== JSON.stringify(b[key]))
    .map((key) => `${nameOf(key)}: ${words(a[key])} here, ${words(b[key])} in the other`);
}

/** Say anew how the design that is shown differs from the one that is held. */
export function compare(facts) {
  byId('other').hidden = !held;
  for (const id of ['swap', 'release']) byId(id).disabled = !held;
  if (!held) return;
  const { row } = held.walker.facts;
  const [here, there] = [facts.row.speed_mm_s, row.speed_mm_s];
  const change = here === null || there === null ? '' : `, ${here < there ? '' : '+'}${(here - there).toFixed(1)}`;
  byId('other-speed').textContent =
    `The other: ${speedWords(there)}, ${held.walker.facts.mass_g.toPrecision(4)} g. ` +
    `This one: ${speedWords(here)}${change}.`;
  const lines = differences(current(), held.document);
  byId('differences').replaceChildren(
    ...(lines.length ? lines : ['the same design']).map((line) => make('li', { textContent: line })),
  );
}

export function startCompare(shownWalker) {
  const show = () => {
    byId('other').hidden = false;
    const colour = getComputedStyle(document.documentElement).getPropertyValue(`--${held.walker.facts.kind}-part`).trim();
    viewer ??= viewerOf(byId('other-canvas'), held.walker.positions);
    viewer?.replace(held.walker.positions, colour, null);
    compare(shownWalker().facts);
  };
  byId('hold').addEventListener('click', () => {
    if (!shownWalker()) return;
    held = { document: structuredClone(current()), walker: shownWalker() };
    show();
  });
  byId('swap').addEventListener('click', () => {
    const other = held.document;
    held = { document: structuredClone(current()), walker: shownWalker() };
    change(other, 'shape');
    show();
  });
  byId('release').addEventListener('click', () => {
    held = null;
    compare(shownWalker().facts);
  });
}

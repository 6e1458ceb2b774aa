// The form: a control for each key that the server names, in the order of its tables.

import { ask, byId, lastOnly, settled, upload } from './ask.js';
import { change, current, endDrag, isSet, set, setAll, without } from './state.js';

const NARROW = matchMedia('(max-width: 48rem)');
const opens = (title) => !NARROW.matches && ['Shape', 'Legs', 'walker: legs 1'].includes(title);
const SPANS_MS = 500; // without a change after which ends of sliders are asked for
const FAR = 1e5; // limits from which on nobody needs to be told of them
let legs = []; // legs of the walker as a list

const make = (tag, properties = {}, ...children) => {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
};

const rounded = (value) => Number(value.toPrecision(4));

// Round numbers between two, at most six.
function ticks(low, high) {
  const rough = (high - low) / 5;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= 0.999 * rough);
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step - first + 1e-9) + 1 }, (_, k) => Number(((first + k) * step).toPrecision(6)));
}

/** Slider of a control beside its number, over a range; a number beyond it makes it longer. */
function slider(control, number) {
  const range = make('input', { type: 'range', step: 'any', tabIndex: -1 });
  range.setAttribute('aria-hidden', 'true'); // the number beside it says the same
  const marks = make('div', { className: 'ticks' });
  marks.setAttribute('aria-hidden', 'true');
  let step = 1;
  const value = () => Number(number.value || control.value);
  const span = (low, high) => {
    [range.min, range.max] = [Math.min(low, value()), Math.max(high, value())];
    const [bottom, top] = [Number(range.min), Number(range.max)];
    step = 10 ** Math.floor(Math.log10((top - bottom) / 200));
    number.step = Number(step.toPrecision(1));
    range.value = value();
    marks.replaceChildren(...ticks(bottom, top).map((tick) => {
      const mark = make('span', { textContent: tick });
      mark.style.left = `${(100 * (tick - bottom)) / (top - bottom)}%`;
      return mark;
    }));
  };
  span(...control.slider);
  const place = () => {
    const now = value();
    if (now < Number(range.min) || now > Number(range.max)) span(Number(range.min), Number(range.max));
    range.value = now;
  };
  range.addEventListener('input', () => {
    const wanted = Number(range.value);
    const whole = rounded(Math.min(Math.max(Math.round(wanted / step) * step, Number(range.min)), Number(range.max)));
    number.value = whole;
    set(control.key, whole);
  });
  range.addEventListener('change', endDrag);
  number.addEventListener('input', place);
  return { range, marks, place, span };
}

function numberOf(control) {
  const input = make('input', { type: 'number', step: 'any', value: control.value ?? '', readOnly: control.follows });
  if (control.optional) input.placeholder = 'none';
  input.addEventListener('input', () => {
    if (input.value === '') set(control.key, undefined);
    else if (Number.isFinite(input.valueAsNumber)) set(control.key, input.valueAsNumber);
  });
  input.addEventListener('change', endDrag);
  return input;
}

function choiceOf(control) {
  const words = control.kind === 'yes' ? ['false', 'true'] : control.choices;
  const select = make('select');
  if (control.optional) select.append(new Option('as it needs', ''));
  for (const word of words)
    select.append(new Option(control.kind === 'yes' ? { true: 'yes', false: 'no' }[word] : word, word));
  select.value = control.value === null ? '' : String(control.value);
  select.addEventListener('change', () => {
    const value = control.kind === 'yes' ? select.value === 'true' : select.value;
    // legs that a user places begin where they were placed automatically
    const shown = Object.fromEntries(['legs.contact_spacing_mm', 'legs.width_mm'].map((key) => [key, byId(`key-${key}`)?.valueAsNumber]));
    if (control.key === 'legs.placement' && value === 'given') setAll({ ...shown, [control.key]: value });
    else set(control.key, select.value === '' ? undefined : value, 'shape');
  });
  return select;
}

// Text, or a list as JSON.
function textOf(control) {
  const list = control.kind === 'list';
  const shown = control.value === null ? '' : list ? JSON.stringify(control.value) : control.value;
  const input = make('input', { type: 'text', value: shown });
  if (control.optional) input.placeholder = 'none';
  input.addEventListener('change', () => {
    let value = input.value === '' ? undefined : input.value;
    try {
      if (list && value) value = JSON.parse(value);
    } catch {
      // the server says what must be written instead
    }
    set(control.key, value, 'shape');
  });
  return input;
}

function row(control) {
  const id = `key-${control.key}`;
  const makers = { number: numberOf, whole: numberOf, choice: choiceOf, yes: choiceOf };
  const input = (makers[control.kind] ?? textOf)(control);
  input.id = id;
  const label = make('label', { htmlFor: id, textContent: control.name });
  const holder = make('div', { className: 'row' }, label);
  holder.dataset.key = control.key;
  holder.classList.toggle('follows', control.follows);
  holder.classList.toggle('open', control.is_open);
  const near = control.low !== null && control.high !== null && control.high < FAR;
  const limits = near ? `${control.low} to ${control.high} ${control.unit}` : '';
  const help = [control.follows ? 'Set automatically.' : '', control.help, limits].filter(Boolean).join(' ');
  const hint = make('small', { className: 'help', id: `${id}-help`, textContent: help });
  const why = make('p', { className: 'refusal', id: `${id}-why`, hidden: true });
  why.setAttribute('role', 'alert');
  input.setAttribute('aria-describedby', `${id}-help ${id}-why`);
  const unit = make('span', { className: 'unit', textContent: control.unit });
  const back = make('button', {
    type: 'button', className: 'back', textContent: 'reset', title: 'back to the value of the template',
  });
  back.setAttribute('aria-label', `reset ${control.name}`);
  back.hidden = !isSet(control.key);
  back.addEventListener('click', () => set(control.key, undefined, 'shape'));
  holder.append(input, unit, back);
  if (control.slider) {
    const { range, marks, place, span } = slider(control, input);
    holder.append(range, marks);
    Object.assign(holder, { place, span });
  }
  holder.append(why, hint); // the hint opens with the focus, below what a press is aimed at
  return holder;
}

function toolOf(text, work) {
  const button = make('button', { type: 'button', textContent: text });
  button.addEventListener('click', work);
  return button;
}

// Buttons that change how many legs there are.
function legTools(title) {
  const number = Number(title.match(/legs (\d+)$/)?.[1] ?? 0);
  const listed = () => structuredClone(legs);
  const tools = make('div', { className: 'bar' });
  if (!number && legs.length) {
    tools.append(toolOf('Edit each leg by itself', () => {
      const tilt = Number(byId('key-legs.tilt_deg')?.value ?? 10);
      const values = { ...without(current().values, 'legs'), legs: listed(), leg_tilt_deg: tilt };
      change({ ...current(), values }, 'shape');
    }));
  } else if (number) {
    const become = (list) =>
      change({ ...current(), values: { ...without(current().values, 'legs'), legs: list } }, 'shape');
    tools.append(toolOf('Add a leg like this', () => {
      const list = listed();
      const twin = { ...list[number - 1] };
      twin.along_mm = rounded((twin.along_mm ?? 0) + 2);
      list.splice(number, 0, twin);
      become(list);
    }));
    if (legs.length > 1)
      tools.append(toolOf('Remove this leg', () => become(listed().filter((_, k) => k !== number - 1))));
  }
  return tools;
}

function bodyTools(shapes) {
  const select = make('select', { id: 'shape' });
  select.append(new Option('Choose another shape', ''));
  for (const name of Object.keys(shapes)) select.append(new Option(name, name));
  select.addEventListener('change', () => {
    if (!select.value) return;
    const { walker, values } = shapes[select.value];
    const kept = without(current().values, 'body', ...(walker ? ['leg'] : []));
    change({ ...current(), walker: walker ?? current().walker, values: { ...kept, ...values } }, 'shape');
  });
  select.setAttribute('aria-label', 'shape of the body');
  return make('div', { className: 'bar' }, select);
}

// Groups of the form by the keys of their controls. All other keys are under ALL.
const GROUPS = [
  ['Shape', /^body\.(?!repair|scale_mm|legs_below_mm)/],
  ['Legs', /^(legs\b|leg_tilt)(?!.*_sd_mm$)/],
  ['Plate and shaker', /^scene\.(drive\.(kind|frequency_hz|amplitude_um|peak_speed_mm_s|gamma)|contact\.(restitution|friction)|plate\.slope_deg)$/],
  ['Print', /^printer\.(brim_width_mm|nozzle_mm|line_width_mm|layer_height_mm)$/],
];
const ALL = 'All settings';

function foldOf(title, name, isOpen) {
  const details = make('details', { open: isOpen(title) }, make('summary', { textContent: name }));
  details.addEventListener('toggle', () => details.open && askSpans());
  details.dataset.title = title;
  return details;
}

// What a table of the server adds to one of GROUPS: its controls there, with the buttons of its shape or its legs.
function partOf(table, title, controls, shapes, isOpen) {
  const leg = table.title.match(/^walker: legs (\d+)$/);
  const part = leg ? foldOf(table.title, `leg ${leg[1]}`, isOpen) : make('div');
  part.dataset.title = table.title;
  if (title === 'Shape') part.append(bodyTools(shapes));
  if (/^walker: legs/.test(table.title)) part.append(legTools(table.title));
  part.append(...controls.map(row));
  return part;
}

// What is left of a table, under ALL.
function restOf(table, controls, isOpen) {
  const details = foldOf(`all: ${table.title}`, table.title.replace('walker: ', ''), isOpen);
  if (table.absent) {
    const [key, start] = table.absent;
    details.append(toolOf(`Add a ${table.title.replace(/^\w+: /, '')}`, () => set(key, start, 'shape')));
  } else if (table.optional && isSet(table.optional)) {
    details.append(toolOf(`Remove the ${table.title.replace(/^\w+: /, '')}`, () => {
      change({ ...current(), values: without(current().values, table.optional) }, 'shape');
    }));
  }
  details.append(...controls.map(row));
  return details;
}

function groupsOf(tables, shapes, isOpen) {
  const tilt = make('div');
  const folds = new Map([...GROUPS.map(([title]) => title), ALL].map((title) => [title, foldOf(title, title, isOpen)]));
  folds.get(ALL).append(search);
  for (const table of tables) {
    if (table.title === 'tilt') {
      tilt.dataset.title = table.title;
      tilt.append(...table.controls.map(row));
      continue;
    }
    let rest = table.controls;
    for (const [title, keys] of GROUPS) {
      const controls = rest.filter(({ key }) => keys.test(key));
      rest = rest.filter(({ key }) => !keys.test(key));
      if (controls.length) folds.get(title).append(partOf(table, title, controls, shapes, isOpen));
    }
    if (rest.length || table.absent) folds.get(ALL).append(restOf(table, rest, isOpen));
  }
  return [tilt, ...folds.values()];
}

// Box that shows only the controls with its words in their names or keys.
const search = make('input', { type: 'search', id: 'search', placeholder: 'search all settings' });
search.setAttribute('aria-label', 'search all settings');
let openBefore = null; // folds that were open before the search
search.addEventListener('input', () => {
  const folds = [...byId('form').querySelectorAll('details')];
  if (search.value && !openBefore) openBefore = new Map(folds.map((fold) => [fold.dataset.title, fold.open]));
  findRows();
  if (search.value) return;
  for (const fold of folds) fold.open = openBefore?.get(fold.dataset.title) ?? fold.open;
  openBefore = null;
});

function findRows() {
  const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
  for (const each of byId('form').querySelectorAll('.row')) {
    const text = `${each.dataset.key} ${each.firstChild.textContent} ${each.closest('[data-title]').dataset.title}`.toLowerCase();
    each.hidden = !words.every((word) => text.includes(word));
  }
  for (const fold of byId('form').querySelectorAll('details')) {
    const found = Boolean(fold.querySelector('.row:not([hidden])'));
    fold.hidden = words.length > 0 && !found && fold.dataset.title !== ALL;
    if (words.length && found) fold.open = true;
  }
}

/** Open all folds around an element of the form. */
export function reveal(element) {
  for (let fold = element.closest('details'); fold; fold = fold.parentElement.closest('details')) fold.open = true;
}

/** Ask for the form and build it anew, with the same tables open and the same control in focus. */
export const rebuild = lastOnly(async () => {
  const drawn = current();
  const form = byId('form');
  let answer = await ask('form', { document: drawn });
  const unbuildable = answer.refused && !form.querySelector('.row'); // as a reload may bring it back
  if (unbuildable) answer = await ask('form', { document: { ...drawn, values: Object.fromEntries(Object.entries(drawn.values).filter(([key]) => /^(scene|printer)\./.test(key))) } });
  form.ariaBusy = String(drawn !== current());
  if (answer.refused) return; // the last good form stays
  const open = new Map([...form.querySelectorAll('details')].map((each) => [each.dataset.title, each.open]));
  const focused = document.activeElement?.closest('#form') ? document.activeElement.id : '';
  legs = answer.legs;
  form.replaceChildren(...groupsOf(answer.groups, answer.shapes, (title) => open.get(title) ?? opens(title)));
  if (search.value) findRows();
  if (unbuildable) for (const [key, value] of Object.entries(drawn.values)) showValue(key, value);
  refuse(refused); // what stood beside the former controls
  if (focused) byId(focused)?.focus();
  askSpans();
});

// Sliders that are seen, and not held at the moment, run over what can be built.
const askSpans = settled(async () => {
  const rows = [...document.querySelectorAll('#form .row')].filter((row) => row.span && row.checkVisibility() && !row.matches(':active'));
  if (!rows.length) return;
  const asked = current();
  const answer = await ask('spans', { document: asked, keys: rows.map((row) => row.dataset.key) });
  if (answer.refused || asked !== current()) return;
  for (const row of rows) if (answer.spans[row.dataset.key]) row.span(...answer.spans[row.dataset.key]);
}, SPANS_MS);

/** Whether file and page leave the value of a key open, so that it changes with the walker. */
export const isOpen = (key) => !isSet(key) && byId(`key-${key}`)?.closest('.row').classList.contains('open');

/** Show a number that was set elsewhere, as by dragging the marker of the chart. */
export function showValue(key, value) {
  const input = byId(`key-${key}`);
  if (!input || document.activeElement === input) return;
  input.value = value;
  input.closest('.row').place?.();
}

// Buttons that do what helps; what no key does is said.
const helping = (helps) =>
  helps.map(({ words, values }) => {
    if (!Object.keys(values).length) return make('span', { textContent: ` ${words}.` });
    const button = make('button', { type: 'button', className: 'help-out', textContent: words });
    button.addEventListener('click', () => setAll(values));
    return button;
  });

// Picture of a body under which no legs stand, as soon as the server has drawn it.
function drawing() {
  const image = make('img', { className: 'trouble', alt: 'The body from above; red has no room for legs.' });
  ask('trouble', { document: current() }).then(({ picture }) => picture && (image.src = picture));
  return image;
}

let refused = []; // mistakes that are shown

/** Say beside the controls at fault why the walker cannot be built, with what helps; elsewhere what is left. */
export function refuse(mistakes) {
  refused = mistakes;
  for (const why of document.querySelectorAll('.refusal')) why.hidden = true;
  const stray = [];
  for (const { key, text, helps = [], drawn } of mistakes) {
    const said = [`${text} `, ...helping(helps), ...(drawn ? [drawing()] : [])];
    const holder = document.querySelector(`.row[data-key="${CSS.escape(key)}"]`);
    const why = holder?.querySelector('.refusal');
    if (!why) {
      stray.push(make('p', {}, ...said));
      continue;
    }
    why.replaceChildren(...said);
    why.hidden = false;
    reveal(holder);
  }
  byId('stray').replaceChildren(...stray);
  for (const holder of document.querySelectorAll('.row')) {
    holder.querySelector('.back').hidden = !isSet(holder.dataset.key);
    const bad = !holder.querySelector('.refusal').hidden;
    holder.querySelector(`#${CSS.escape(`key-${holder.dataset.key}`)}`).ariaInvalid = String(bad);
  }
}

/** Take a file that was dropped or chosen as the body. */
export async function takeFile(file) {
  const answer = await upload(file);
  if (answer.refused) return refuse(answer.refused);
  const flat = answer.key === 'body.outline';
  const body = flat ? { outline: answer.file, thickness_mm: 3 } : { mesh: answer.file };
  const values = { ...without(current().values, 'body'), body };
  // two equal legs place themselves under it; those of a list stand where they are put
  if (document.querySelector('.row[data-key="legs.tilt_deg"]')) values['legs.placement'] = 'auto';
  change({ ...current(), values }, 'shape');
}

/** Name of a key as its control has it. */
export const nameOf = (key) => document.querySelector(`label[for="${CSS.escape(`key-${key}`)}"]`)?.textContent ?? key.replaceAll(/[._]/g, ' ');

export { askSpans, make, ticks };

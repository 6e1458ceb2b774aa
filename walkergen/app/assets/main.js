// The page: one document, and everything that is shown of it.

import { ask, askWalker, byId, lastOnly, settled } from './ask.js';
import { compare, startCompare } from './compare.js';
import { startDish } from './dish.js';
import { askSpans, isOpen, make, rebuild, refuse, reveal, showValue, takeFile } from './form.js';
import { runShort, startJobs } from './jobs.js';
import { hangs, showCurve, showOutlook, showShares, showSpeed, showUnknown, showWaiting, startChart } from './outlook.js';
import { markFaults, showPart, showStill, startPart } from './part.js';
import * as state from './state.js';

const SETTLED_MS = 150; // without a change after which what is slower is asked for
const RESTED_MS = 700; // and what takes longest
const KEPT_MS = 800;
const SHORT_MS = 500; // after an answer without a speed, before a short run tells it

let walker = null; // the last good one
let stopJobs = () => {};

const refresh = lastOnly(async () => {
  const document = state.current();
  byId('outlook').ariaBusy = 'true';
  const answer = await askWalker({ document });
  byId('outlook').ariaBusy = String(document !== state.current());
  refuse(answer.refused ?? []);
  if (answer.refused && !walker) showUnknown('This walker cannot be built: the form says why. “Reset all” brings back the template.');
  if (answer.refused) return;
  if (carriesAnew(answer.facts)) return state.change({ ...document, scene: table }, 'shape', 'scene');
  walker = answer;
  showSpeed(answer.facts);
  if (!answer.facts.sentence.sure && simulated !== document) {
    showWaiting(0);
    shortSoon(document); // not before: a large file is read for longer than any pause
  }
  compare(answer.facts);
  if (answer.facts.tilt_key && document === state.current()) showValue(answer.facts.tilt_key, answer.facts.tilt_deg);
  for (const [key, value] of Object.entries(answer.facts.lengths)) if (isOpen(key)) showValue(key, value);
  showPart(answer);
});

// A motor that has just come to a shaken plate: such walkers run on a table.
const carriesAnew = ({ motor, shaken, name }) =>
  motor && shaken && arrived && !(walker?.facts.motor && walker.facts.name === name);

const look = lastOnly(async () => {
  const document = state.current();
  const answer = await ask('outlook', { document });
  byId('findings').ariaBusy = String(document !== state.current());
  if (answer.refused) return;
  showOutlook(answer);
  markFaults(answer.legs_at_fault, answer.findings.some(hangs));
});

// The curve does not depend on the walker's own tilt; while other sliders move it has few points.
const untilted = ({ values, ...names }) =>
  JSON.stringify([names, state.without(values, walker?.facts.tilt_key ?? 'legs.tilt_deg')]);
let whole = ''; // what the whole curve was drawn of
const drawCurve = lastOnly(async (rough) => {
  const document = state.current();
  const asked = untilted(document);
  const answer = await ask('curve', { document, rough: rough && asked !== whole });
  byId('chart').ariaBusy = String(document !== state.current());
  if (answer.refused) return;
  if (!rough) whole = asked;
  showCurve(answer.curve);
});

// What to measure next is reckoned where somebody reads it.
const showMeasure = lastOnly(async () => {
  if (!byId('measure-next').open) return;
  const answer = await ask('shares', { document: state.current() });
  showShares(answer.shares ?? []);
});

let short = null; // run that tells what nothing else does
let simulated = null; // document that it was done for
const shortSoon = settled((document) => {
  if (document !== state.current() || simulated === document) return;
  short?.abort();
  short = new AbortController();
  runShort(short.signal).then((told) => {
    if (!told) return;
    simulated = document;
    refresh();
  }, () => {});
}, SHORT_MS);

const lookSoon = settled(() => Promise.all([look(), drawCurve(true)]), SETTLED_MS);
const restSoon = settled(() => Promise.all([drawCurve(false), showMeasure()]), RESTED_MS);
const keepSoon = settled(() => ask('keep', { document: state.current() }), KEPT_MS);
const rebuildSoon = settled(() => rebuild().then(drawTemplates), SETTLED_MS);

function changed(document, why) {
  byId('undo').disabled = !state.canUndo();
  byId('redo').disabled = !state.canRedo();
  for (const button of byId('templates').children)
    button.ariaChecked = String(button.value === document.walker);
  const changedShape = Object.keys(document.values).some((key) => /^(body|legs?\b(?!\.tilt)|description)/.test(key));
  byId('about').textContent = changedShape ? '' : about[document.walker] ?? document.walker;
  for (const [id, name] of [['scene', document.scene], ['printer', document.printer]])
    byId(`choose-${id}`).value = name;
  stopJobs();
  short?.abort();
  arrived ||= why !== 'begin';
  for (const part of ['outlook', 'findings', 'chart']) byId(part).ariaBusy = 'true';
  refresh();
  lookSoon();
  restSoon();
  keepSoon();
  askSpans();
  if (why === 'value') return;
  byId('form').ariaBusy = 'true';
  rebuildSoon();
}

let [about, titles, table, arrived] = [{}, {}, '', false];
const titled = (name) => (titles[name] ? `${titles[name]} (${name})` : name);

function addTemplates(names) {
  for (const name of names) {
    const button = make('button', { type: 'button', value: name, title: about[name] ?? name });
    button.setAttribute('role', 'radio');
    if (about[name]) button.append(make('img', { alt: '', width: 72, height: 36 }));
    button.append(make('span', { textContent: titles[name] ?? name }));
    if (titles[name]) button.append(make('small', { textContent: name }));
    button.addEventListener('click', () => begin(name));
    byId('templates').append(button);
  }
}

// The server draws the templates once it has made the form.
function drawTemplates() {
  for (const image of document.querySelectorAll('#templates img:not([src])'))
    image.src = `picture/${image.closest('button').value}.svg`;
}

// Begin with another walker, on a plate that it runs on.
function begin(name) {
  const now = state.current();
  const values = Object.fromEntries(Object.entries(now.values).filter(([key]) => /^(scene|printer)\./.test(key)));
  const scene = now.scene === table ? fresh.scene : now.scene;
  state.change({ ...now, walker: name, scene, values }, 'shape');
}

// Choice of the scene's or the printer's file; its keys begin afresh.
function addChoice(kind, names) {
  const select = make('select', { id: `choose-${kind}` });
  const nameOf = kind === 'printer' ? (name) => about[name] ?? name : titled;
  select.append(...names.map((name) => new Option(nameOf(name), name)));
  select.addEventListener('change', () => {
    const values = state.without(state.current().values, `${kind}.`);
    const run = kind === 'scene' ? fresh.values : {};
    state.change({ ...state.current(), [kind]: select.value, values: { ...values, ...run } }, 'shape');
  });
  byId('choices').prepend(make('label', {}, { scene: 'where it runs', printer: 'printer' }[kind], select));
}

let fresh = null;

function keys(event) {
  if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== 'z') return;
  event.preventDefault();
  if (event.shiftKey) state.redo();
  else state.undo();
}

// The first visit: three pictures to choose from, which a button shows again.
function startWelcome(isNew) {
  const show = (shown) => {
    byId('welcome').hidden = !shown;
    byId('another').ariaExpanded = String(shown);
  };
  const chosen = (name) => {
    begin(name);
    show(false);
  };
  byId('another').addEventListener('click', () => show(byId('welcome').hidden));
  byId('start-paper').addEventListener('click', () => chosen(fresh.walker));
  byId('start-name').addEventListener('click', async () => {
    chosen('name');
    await formed('key-body.text');
    byId('key-body.text').select();
  });
  byId('start-shape').addEventListener('click', () => byId('file').click());
  byId('file').addEventListener('change', () => show(false));
  show(isNew);
}

// Wait until the form has a control.
async function formed(id) {
  while (!byId(id)) await new Promise((done) => setTimeout(done, 50));
  reveal(byId(id));
}

function listenForFiles() {
  byId('choose-file').addEventListener('click', () => byId('file').click());
  byId('file').addEventListener('change', () => {
    const [file] = byId('file').files;
    if (file) takeFile(file);
    byId('file').value = '';
  });
  for (const name of ['dragover', 'drop'])
    addEventListener(name, (event) => {
      event.preventDefault();
      if (name === 'drop' && event.dataTransfer.files.length) takeFile(event.dataTransfer.files[0]);
    });
}

async function start() {
  if (state.remembered()) showStill(state.remembered().walker);
  const answer = await ask('start', {});
  ({ about, fresh, titles, table } = answer);
  addTemplates(answer.walkers);
  addChoice('printer', answer.printers);
  addChoice('scene', answer.scenes);
  byId('undo').addEventListener('click', state.undo);
  byId('redo').addEventListener('click', state.redo);
  byId('afresh').addEventListener('click', () => state.change({ ...state.current(), values: fresh.values }, 'shape'));
  addEventListener('keydown', keys);
  listenForFiles();
  startPart();
  startChart();
  startCompare(() => walker);
  startDish();
  startWelcome(answer.new && !state.remembered());
  byId('measure-next').addEventListener('toggle', showMeasure);
  stopJobs = startJobs();
  state.listen(changed);
  const begun = state.remembered() ?? answer.document;
  if (!state.remembered()) showStill(begun.walker);
  state.begin(begun);
}

start();

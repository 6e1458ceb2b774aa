// The page: one document, and everything that is shown of it.

import { ask, askWalker, byId, lastOnly, settled } from './ask.js';
import { compare, startCompare } from './compare.js';
import { make, rebuild, refuse, showValue, takeFile } from './form.js';
import { startJobs } from './jobs.js';
import { showOutlook, showSpeed, startChart } from './outlook.js';
import { markLegs, showPart, startPart } from './part.js';
import * as state from './state.js';

const SETTLED_MS = 150; // without a change after which what is slower is asked for
const KEPT_MS = 800;

let walker = null; // the last good one
let stopJobs = () => {};

const refresh = lastOnly(async () => {
  const document = state.current();
  byId('outlook').ariaBusy = 'true';
  const answer = await askWalker({ document });
  byId('outlook').ariaBusy = String(document !== state.current());
  refuse(answer.refused ?? []);
  if (answer.refused) return;
  walker = answer;
  showPart(answer);
  showSpeed(answer.facts);
  compare(answer.facts);
  if (answer.facts.tilt_key && document === state.current()) showValue(answer.facts.tilt_key, answer.facts.tilt_deg);
});

const look = lastOnly(async () => {
  const document = state.current();
  const answer = await ask('outlook', { document });
  byId('findings').ariaBusy = String(document !== state.current());
  if (answer.refused) return;
  showOutlook(answer);
  markLegs(answer.legs_at_fault);
});

const lookSoon = settled(look, SETTLED_MS);
const keepSoon = settled(() => ask('keep', { document: state.current() }), KEPT_MS);
const rebuildSoon = settled(rebuild, SETTLED_MS);

function changed(document, why) {
  byId('undo').disabled = !state.canUndo();
  byId('redo').disabled = !state.canRedo();
  for (const button of byId('templates').children)
    button.ariaChecked = String(button.value === document.walker);
  byId('about').textContent = about[document.walker] ?? document.walker;
  for (const [id, name] of [['scene', document.scene], ['printer', document.printer]])
    byId(`choose-${id}`).value = name;
  stopJobs();
  byId('findings').ariaBusy = 'true';
  refresh();
  lookSoon();
  keepSoon();
  if (why === 'value') return;
  byId('form').ariaBusy = 'true';
  rebuildSoon();
}

let about = {};

function addTemplates(names) {
  for (const name of names) {
    const button = make('button', { type: 'button', value: name, title: about[name] ?? name });
    button.setAttribute('role', 'radio');
    if (about[name]) button.append(make('img', { src: `picture/${name}.svg`, alt: '', width: 72, height: 36 }));
    button.append(make('span', { textContent: name }));
    button.addEventListener('click', () => {
      const values = Object.fromEntries(
        Object.entries(state.current().values).filter(([key]) => /^(scene|printer)\./.test(key)));
      state.change({ ...state.current(), walker: name, values }, 'shape');
    });
    byId('templates').append(button);
  }
}

// Choice of the scene's or the printer's file; its keys begin afresh.
function addChoice(kind, names) {
  const select = make('select', { id: `choose-${kind}` });
  select.append(...names.map((name) => new Option(name, name)));
  select.addEventListener('change', () => {
    const values = state.without(state.current().values, `${kind}.`);
    const run = kind === 'scene' ? fresh.values : {};
    state.change({ ...state.current(), [kind]: select.value, values: { ...values, ...run } }, 'shape');
  });
  byId('drop').after(make('label', { className: 'choice' }, `${kind} `, select));
}

let fresh = null;

function keys(event) {
  if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== 'z') return;
  event.preventDefault();
  if (event.shiftKey) state.redo();
  else state.undo();
}

function listenForFiles() {
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
  const answer = await ask('start', {});
  ({ about, fresh } = answer);
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
  stopJobs = startJobs();
  state.listen(changed);
  state.begin(state.remembered() ?? answer.document);
}

start();

// What takes seconds: runs, searches and files, each with one bar, the time left and a way to stop it.

import { ask, askFile, byId, events } from './ask.js';
import { playCrowd } from './dish.js';
import { showEffects } from './effects.js';
import { make, nameOf } from './form.js';
import { showUnknown, showWaiting, tableRow, withError } from './outlook.js';
import { playRun } from './part.js';
import { change, current, without } from './state.js';

const HONEST = 0.05; // share that must be done before the time left is told
const WORDS = { kernels: 'getting ready', runs: 'running', seconds: 'measuring' };

// A bar and a line that say how far a job is.
function barOf(bar, line) {
  let [begun, from] = [0, null];
  return {
    begin() {
      [begun, from] = [performance.now(), null];
      bar.value = 0;
      bar.hidden = false;
      line.textContent = 'starting';
    },
    tell([what, done, total]) {
      const share = total ? done / total : 0;
      const now = performance.now();
      if (done && !from) from = { share, now }; // what came before was getting ready
      const passed = from ? (now - from.now) / 1000 : 0;
      const gone = from ? share - from.share : 0;
      const left = gone > HONEST && passed > 1 ? (passed * (1 - share)) / gone : null;
      bar.value = share;
      const time = left === null ? `${((now - begun) / 1000).toFixed(0)} s so far` : `about ${inWords(left)} left`;
      line.textContent = `${WORDS[what] ?? what}: ${time}`;
    },
    end(words) {
      bar.hidden = true;
      line.textContent = words;
    },
  };
}

const inWords = (seconds) => (seconds < 100 ? `${Math.max(1, Math.round(seconds))} s` : `${Math.round(seconds / 60)} min`);

/** Do a job whose events the server sends; `work` gets those with something in them. Starting again stops the first. */
function jobOf({ start, stop, bar, tell, name, message, work, again }) {
  let aborter = null;
  const shown = barOf(byId(bar), byId(tell));
  const first = byId(start).textContent;
  const settle = (words) => {
    aborter = null;
    byId(stop).hidden = true;
    shown.end(words);
  };
  byId(start).addEventListener('click', async () => {
    aborter?.abort();
    const own = (aborter = new AbortController());
    byId(stop).hidden = false;
    shown.begin();
    let words = '';
    try {
      for await (const event of events(name, message(), own.signal)) {
        if (aborter !== own) return;
        if (event.progress) shown.tell(event.progress);
        else if (event.refused) words = event.refused.join('\n');
        else words = (await work(event)) ?? words;
      }
      if (!words) byId(start).textContent = again;
    } catch (error) {
      if (own.signal.aborted) return;
      words = 'the server has ended';
      throw error;
    } finally {
      if (aborter === own) settle(words);
    }
  });
  byId(stop).addEventListener('click', () => {
    aborter?.abort();
    settle('stopped');
  });
  return () => {
    byId(start).textContent = first;
    if (!aborter) return false;
    aborter.abort();
    settle('stopped: the design has changed');
    return true;
  };
}

const NEAR = 0.05; // share of a wished speed by which one may differ that meets it
const UNITS = { rad_s: 'rad/s', mm: 'mm', rad2_s: 'rad²/s' };

// Rows of a run: what was measured, with errors or why there is no number, and what it was of.
function showRun({ facts, text, first }) {
  const { motion } = facts;
  const measured = (key, unit) => {
    const value = motion?.[`${key}_${unit}`] ?? null;
    const { refused } = motion ?? {};
    if (value === null) return (typeof refused === 'string' ? refused : refused?.[`${key}_${unit}`]) ?? 'not in this model';
    return `${withError(value, motion[`${key}_se_${unit}`])} ${UNITS[unit]}`;
  };
  const turns = [
    ['turning', measured('turning_bias', 'rad_s')],
    ['how far it keeps its way', measured('persistence_length', 'mm')],
    ['how fast it loses its way', measured('rotational_diffusion', 'rad2_s')],
  ];
  const rows = [
    [first ? 'so far' : 'speed', text],
    ...(first ? [] : turns.every(([, words]) => words === turns[0][1]) ? [['turning', turns[0][1]]] : turns),
    ['of', `${facts.runs} runs, ${facts.simulated_s.toFixed(0)} s in all`],
  ];
  byId('ran').tBodies[0].replaceChildren(...rows.map(([name, words]) => tableRow(name, words)));
}

function showNearest({ nearest, bad }, wished) {
  const rows = nearest.map((row) => {
    const keys = Object.keys(row).filter((key) => key.includes('tilt_deg') || key.includes('.'));
    const words = keys.map((key) => `${nameOf(key)} ${row[key]}`).join(', ');
    const button = make('button', { type: 'button', textContent: 'Use this design' });
    button.addEventListener('click', () => {
      const chosen = Object.fromEntries(keys.map((key) => [key, row[key]]));
      const values = { ...without(current().values, ...keys), ...chosen };
      change({ ...current(), values }, 'shape');
    });
    const ends = 'low_95_mm_s' in row ? ['low_95', 'high_95'] : ['predicted_low_95', 'predicted_high_95'];
    const [speed, low, high] = ['speed', ...ends].map((key) => row[`${key}_mm_s`]?.toPrecision(3) ?? 'unknown');
    const far = Math.abs(row.speed_mm_s - wished) > NEAR * Math.abs(wished) ? ', not what was wished' : '';
    return make('li', {}, `${words}: ${speed} mm/s (95 %: ${low} to ${high})${far} `, button);
  });
  byId('designs').replaceChildren(make('ol', {}, ...rows));
  return rows.length ? '' : Object.keys(bad)[0] ?? 'none of them can be printed';
}

let making = null;

async function take(what) {
  making?.abort();
  const own = (making = new AbortController());
  const shown = barOf(byId('making'), byId('taken'));
  const message = { document: current(), what, copies: byId('copies').valueAsNumber };
  shown.begin();
  try {
    let refused = null;
    for await (const event of events('make', message, own.signal)) {
      if (event.progress) shown.tell(event.progress);
      refused = event.refused ?? refused;
    }
    if (refused) return shown.end(refused.join('\n'));
    const answer = await askFile(message);
    if (!answer.ok) return shown.end((await answer.json()).refused.map(({ text }) => text).join('\n'));
    const name = answer.headers.get('content-disposition').match(/filename="(.*)"/)[1];
    const url = URL.createObjectURL(await answer.blob());
    make('a', { href: url, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(url), 60_000);
    byId('taken').dataset.shells = answer.headers.get('walkergen-shell');
    shown.end(`${name} is in your downloads.`);
  } catch (error) {
    if (!own.signal.aborted) throw error;
  }
}

/** Make the buttons work; returns what stops the jobs of a design that has changed. */
export function startJobs() {
  const message = () => ({ document: current() });
  const stopRun = jobOf({
    start: 'run', stop: 'stop', bar: 'run-bar', tell: 'progress', name: 'run', message, again: 'Simulate again',
    work: (event) => (event.played ? playRun(event.played) : showRun(event)),
  });
  const stopCrowd = jobOf({
    start: 'crowd', stop: 'stop-crowd', bar: 'crowd-bar', tell: 'crowding', name: 'crowd', message, again: 'Simulate ten again',
    work: async () => playCrowd(await ask('crowded', message())),
  });
  const stopEffects = jobOf({
    start: 'measure-effects', stop: 'stop-effects', bar: 'effects-bar', tell: 'effects-told', name: 'effects', message, again: 'Measure the effects again',
    work: async ({ output }) => showEffects(JSON.parse(output), await ask('effects_drawn', message())),
  });
  const wished = byId('wished');
  jobOf({
    start: 'find', stop: 'stop-search', bar: 'search-bar', tell: 'searching', name: 'nearest', again: 'Find designs',
    message: () => ({ document: current(), speed: wished.valueAsNumber }),
    work: ({ output }) => showNearest(JSON.parse(output), wished.valueAsNumber),
  });
  for (const button of document.querySelectorAll('#take button, #take-more button'))
    button.addEventListener('click', () => take(button.dataset.what));
  return () => {
    if (!stopRun()) byId('progress').textContent = '';
    if (!stopCrowd()) byId('crowding').textContent = '';
    byId('ran').tBodies[0].replaceChildren();
    if (!stopEffects()) byId('effects-told').textContent = '';
    byId('dish').hidden = byId('effects').hidden = true;
  };
}

/** Runs of seconds of a walker whose speed nothing else tells; whether the server has them now. */
export async function runShort(signal) {
  for await (const { progress, refused, predicted } of events('run', { document: current(), short: true }, signal)) {
    if (predicted) return true; // a server that ends says nothing
    if (progress?.[2]) showWaiting(progress[1] / progress[2]);
    if (!refused) continue;
    showUnknown(refused.join('\n'));
    break;
  }
  return false;
}

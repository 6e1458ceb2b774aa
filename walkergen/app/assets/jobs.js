// What takes seconds: runs, searches and files, each with its progress and a way to stop it.

import { askFile, byId, events } from './ask.js';
import { make } from './form.js';
import { tableRow } from './outlook.js';
import { playRun } from './part.js';
import { change, current, without } from './state.js';

const refusedIn = (id, lines) => (byId(id).textContent = lines.join('\n'));

/** Do a job whose events the server sends; `work` gets its output. Starting again stops the first. */
function jobOf({ start, stop, tell, name, message, work }) {
  let aborter = null;
  const settle = () => {
    aborter = null;
    byId(stop).hidden = true;
  };
  byId(start).addEventListener('click', async () => {
    aborter?.abort();
    const own = (aborter = new AbortController());
    byId(stop).hidden = false;
    byId(tell).textContent = 'starting';
    try {
      for await (const event of events(name, message(), own.signal)) {
        if (aborter !== own) return;
        if (event.progress) byId(tell).textContent = event.progress;
        if (event.refused) refusedIn(tell, event.refused);
        if (event.output) {
          byId(tell).textContent = 'done';
          work(JSON.parse(event.output));
        }
      }
    } catch (error) {
      if (own.signal.aborted) return;
      byId(tell).textContent = 'the server has ended';
      throw error;
    } finally {
      if (aborter === own) settle();
    }
  });
  byId(stop).addEventListener('click', () => {
    aborter?.abort();
    settle();
    byId(tell).textContent = 'stopped';
  });
  return () => {
    if (!aborter) return false;
    aborter.abort();
    settle();
    byId(tell).textContent = 'stopped: the design has changed';
    return true;
  };
}

const UNITS = { rad_s: 'rad/s', mm: 'mm', rad2_s: 'rad²/s' };

const withError = (value, se) => {
  if (!se) return Number(value.toPrecision(3)).toString();
  const digits = Math.max(0, 1 - Math.floor(Math.log10(se)));
  return `${value.toFixed(digits)} ± ${se.toFixed(digits)}`;
};

// Rows of a run: what was measured, with errors or why there is no number, and what it was of.
function showRun(facts) {
  const { motion } = facts;
  const measured = (key, unit) => {
    const value = motion?.[`${key}_${unit}`] ?? null;
    if (value === null) return motion?.refused?.[`${key}_${unit}`] ?? 'not in this model';
    return `${withError(value, motion[`${key}_se_${unit}`])} ${UNITS[unit]}`;
  };
  const turns = [
    ['turning', measured('turning_bias', 'rad_s')],
    ['persistence length', measured('persistence_length', 'mm')],
    ['rotational diffusion', measured('rotational_diffusion', 'rad2_s')],
  ];
  const rows = [
    ['speed', `${withError(facts.speed_mm_s, facts.speed_se_mm_s)} mm/s`],
    ['95 %, with the model’s error', `${facts.speed_low_95_mm_s.toFixed(1)} to ${facts.speed_high_95_mm_s.toFixed(1)} mm/s`],
    ...(turns.every(([, text]) => text === turns[0][1]) ? [['turning', turns[0][1]]] : turns),
    ['of', `${facts.runs} runs, ${facts.simulated_s.toFixed(0)} s in all, computed in ${facts.wall_s.toFixed(1)} s`],
  ];
  byId('ran').tBodies[0].replaceChildren(...rows.map(([name, text]) => tableRow(name, text)));
}

function showDesigns(facts) {
  const rows = facts.rows.map((row) => {
    const keys = Object.keys(row).filter((key) => key.includes('.'));
    const words = keys.map((key) => `${key} ${row[key]}`).join(', ');
    const button = make('button', { type: 'button', textContent: 'take this one' });
    button.addEventListener('click', () => {
      const chosen = Object.fromEntries(keys.map((key) => [key, row[key]]));
      const values = { ...without(current().values, ...keys), ...chosen };
      change({ ...current(), values }, 'shape');
    });
    const [, wished] = Object.keys(row).join(' ').match(/\bverified_(?!se_|speed)(\w+)_mm\b/) ?? [];
    const other = wished
      ? `${wished.replaceAll('_', ' ')} ${withError(row[`verified_${wished}_mm`], row[`verified_se_${wished}_mm`])} mm, ` : '';
    const speed = withError(row.verified_speed_mm_s ?? row.predicted_mm_s, row.verified_se_speed_mm_s);
    return make('li', {}, `${words}: ${other}${speed} mm/s${row.met ? '' : ', not what was wished'} `, button);
  });
  byId('designs').replaceChildren(make('ol', {}, ...rows));
  if (facts.stopped) byId('searching').textContent = facts.stopped;
}

async function take(what) {
  byId('taken').textContent = 'making the files';
  const copies = byId('copies').valueAsNumber;
  const answer = await askFile({ document: current(), what, copies });
  if (!answer.ok) return refusedIn('taken', (await answer.json()).refused.map(({ text }) => text));
  const name = answer.headers.get('content-disposition').match(/filename="(.*)"/)[1];
  const url = URL.createObjectURL(await answer.blob());
  make('a', { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
  const lines = JSON.parse(answer.headers.get('walkergen-shell'));
  byId('taken').textContent = [`${name} is in your downloads.`, ...lines].join('\n');
}

/** Make the buttons work; returns what stops the jobs of a design that has changed. */
export function startJobs() {
  const message = () => ({ document: current() });
  const stopRun = jobOf({
    start: 'run', stop: 'stop', tell: 'progress', name: 'run', message,
    work: (facts) => {
      showRun(facts);
      if (facts.model === 'space') byId('show').click();
    },
  });
  const stopPlay = jobOf({
    start: 'show', stop: 'stop', tell: 'progress', name: 'play', message, work: playRun,
  });
  const wish = byId('wish');
  jobOf({
    start: 'find', stop: 'stop-search', tell: 'searching', name: 'design', work: showDesigns,
    message: () => ({ document: current(), wish: wish.value, value: byId('wished').valueAsNumber }),
  });
  wish.addEventListener('change', () => {
    const unit = wish.selectedOptions[0].dataset.unit ?? '';
    byId('wished-unit').textContent = unit;
    byId('wished').closest('label').hidden = !unit;
  });
  for (const button of byId('take').querySelectorAll('button'))
    button.addEventListener('click', () => take(button.dataset.what));
  return () => {
    if (![stopRun(), stopPlay()].some(Boolean)) byId('progress').textContent = '';
    byId('ran').tBodies[0].replaceChildren();
  };
}

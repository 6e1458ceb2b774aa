// What each effect changes of the speed, and of the time that a run takes.

import { byId } from './ask.js';
import { tableRow, withError } from './outlook.js';

const signed = (value, se) => (value > 0 ? '+' : '') + withError(value, se);

function words({ change_mm_s: change, change_se_mm_s: se, refused, cpu_ratio: ratio }) {
  const speed = change === null ? refused : `${signed(change, se)} mm/s${refused && `, ${refused}`}`;
  return ratio === null ? speed : `${speed}; takes ${ratio.toFixed(2)} times as long`;
}

/** Show what was measured: { measured, advice, speed_mm_s }, and its picture, an address. */
export function showEffects({ measured, advice, speed_mm_s: speed }, { picture, refused }) {
  if (refused) return refused.map(({ text }) => text).join('\n');
  byId('effects').hidden = false;
  byId('effects-advice').textContent = `${advice.replace(/ \(simulate .*\)$/, '')}.`;
  byId('effects-picture').src = picture;
  byId('effects-rows').tBodies[0].replaceChildren(
    ...(speed === null ? [] : [tableRow('as it is', `${speed.toPrecision(3)} mm/s`)]),
    ...measured.map((row) => tableRow(`${row.effect}: ${row.change}`, words(row))),
  );
  return '';
}

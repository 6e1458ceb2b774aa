// How the walker will run: its speed, the curve against tilt, its masses, and what the printer makes
// of it. The marker on the curve is a slider of the tilt.

import { byId } from './ask.js';
import { make, reveal, ticks } from './form.js';
import { endDrag, set } from './state.js';

const [WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM] = [420, 260, 46, 12, 12, 38];
const SVG = 'http://www.w3.org/2000/svg';

let curve = null;
let walker = null; // facts of the last good one
let scale = null;

function change(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
}

function add(parent, tag, attributes, text = '') {
  const element = document.createElementNS(SVG, tag);
  change(element, attributes);
  element.textContent = text;
  parent.append(element);
  return element;
}

function scaleOf() {
  const { tilt_deg: tilts, high_95: high, low_95: low } = curve;
  const [x0, x1] = [tilts[0], tilts.at(-1)];
  const top = Math.max(1, ...high, walker.row.speed_high_95_mm_s);
  const bottom = Math.min(0, ...low, walker.row.speed_low_95_mm_s);
  return {
    low: x0, high: x1, bottom, top,
    x: (tilt) => LEFT + ((tilt - x0) / (x1 - x0)) * (WIDTH - LEFT - RIGHT),
    y: (speed) => TOP + ((top - speed) / (top - bottom)) * (HEIGHT - TOP - BOTTOM),
    tilt: (x) => x0 + ((x - LEFT) / (WIDTH - LEFT - RIGHT)) * (x1 - x0),
  };
}

function drawAxes(chart) {
  for (const tick of ticks(scale.bottom, scale.top)) {
    const y = scale.y(tick);
    add(chart, 'line', { class: 'grid', x1: LEFT, x2: WIDTH - RIGHT, y1: y, y2: y });
    add(chart, 'text', { x: LEFT - 6, y, dy: '.35em', 'text-anchor': 'end' }, tick);
  }
  for (const tick of ticks(scale.low, scale.high))
    add(chart, 'text', { x: scale.x(tick), y: HEIGHT - BOTTOM + 16, 'text-anchor': 'middle' }, tick);
  add(chart, 'text', { x: (LEFT + WIDTH) / 2, y: HEIGHT - 4, 'text-anchor': 'middle' }, 'tilt of the legs (deg)');
  add(chart, 'text', { transform: `translate(11 ${(TOP + HEIGHT - BOTTOM) / 2}) rotate(-90)`, 'text-anchor': 'middle' }, 'speed (mm/s)');
}

const points = (speeds, [first, last]) =>
  speeds.slice(first, last).map((speed, k) => `${scale.x(curve.tilt_deg[first + k])},${scale.y(speed)}`);

// Stretches of the curve, from an index up to another, between the tilts that a run has yet to tell.
function stretches() {
  const found = [];
  curve.speed.forEach((speed, k) => {
    if (speed === null) return;
    if (found.at(-1)?.[1] === k) found.at(-1)[1] = k + 1;
    else found.push([k, k + 1]);
  });
  return found;
}

function drawBand(chart, name, low, high) {
  for (const part of stretches())
    add(chart, 'polygon', { class: `band ${name}`, points: [...points(low, part), ...points(high, part).reverse()].join(' ') });
}

function drawSpeed(chart) {
  for (const part of stretches())
    add(chart, 'polyline', { class: 'predicted', points: points(curve.speed, part).join(' ') });
  if (curve.speed.includes(null))
    add(chart, 'text', { x: WIDTH - RIGHT, y: TOP + 8, 'text-anchor': 'end' }, 'gaps: a run tells');
}

// Below zero it runs backward.
function drawBackward(chart) {
  const y = scale.y(0);
  if (HEIGHT - BOTTOM - y > 14) add(chart, 'text', { x: WIDTH - RIGHT - 4, y: HEIGHT - BOTTOM - 4, 'text-anchor': 'end' }, 'runs backward');
  add(chart, 'line', { class: 'zero', x1: LEFT, x2: WIDTH - RIGHT, y1: y, y2: y });
}

// The same element for as long as the page lives: who holds it, a hand or a screen reader, keeps it.
const marker = document.createElementNS(SVG, 'g');

function drawMarker(chart) {
  const { tilt_deg: tilt, row } = walker;
  const [x, y] = [scale.x(tilt), scale.y(row.speed_mm_s)];
  marker.replaceChildren();
  change(marker, {
    id: 'marker', tabindex: 0, role: 'slider', 'aria-label': 'tilt of the legs, degrees',
    'aria-valuemin': scale.low, 'aria-valuemax': scale.high, 'aria-valuenow': tilt,
    'aria-valuetext': `${tilt} degrees: ${walker.sentence.text}`,
  });
  if (marker.parentNode !== chart) chart.append(marker);
  if (row.speed_low_95_mm_s !== null) { // else a run has yet to tell
    const [low, high] = [row.speed_low_95_mm_s, row.speed_high_95_mm_s].map(scale.y);
    add(marker, 'path', { d: `M${x} ${low}V${high}M${x - 4} ${low}h8M${x - 4} ${high}h8` });
  }
  add(marker, 'circle', { class: 'touch', cx: x, cy: y, r: 18 });
  add(marker, 'circle', { class: row.speed_mm_s === null ? 'unknown' : '', cx: x, cy: y, r: 6 });
}

let shownCurve = null;
function drawCurve(chart) {
  shownCurve = curve;
  chart.replaceChildren();
  drawAxes(chart);
  drawBand(chart, 'share95', curve.low_95, curve.high_95);
  drawBand(chart, 'share68', curve.low_68, curve.high_68);
  drawSpeed(chart);
  drawBackward(chart);
}

function drawChart() {
  const chart = byId('chart');
  const focused = document.activeElement?.id === 'marker';
  chart.toggleAttribute('hidden', !curve || !walker);
  if (!curve || !walker) return;
  const before = scale;
  scale = scaleOf();
  chart.classList.toggle('unsure', !walker.sentence.sure);
  // A step of the tilt moves the marker alone
  if (shownCurve !== curve || ['low', 'high', 'bottom', 'top'].some((end) => before[end] !== scale[end])) drawCurve(chart);
  drawMarker(chart);
  if (focused) byId('marker').focus();
}

const clamp = (tilt) => Math.min(Math.max(tilt, scale.low), scale.high);

function setTilt(tilt) {
  if (walker.tilt_key && scale) set(walker.tilt_key, Number(clamp(tilt).toFixed(1)));
}

function listen() {
  const chart = byId('chart');
  const tiltAt = (event) => {
    const place = new DOMPoint(event.clientX, event.clientY).matrixTransform(chart.getScreenCTM().inverse());
    return scale.tilt(place.x);
  };
  let dragging = false;
  chart.addEventListener('pointerdown', (event) => {
    if (!scale || !walker?.tilt_key) return;
    dragging = true;
    chart.setPointerCapture(event.pointerId);
    setTilt(tiltAt(event));
  });
  chart.addEventListener('pointermove', (event) => dragging && setTilt(tiltAt(event)));
  for (const name of ['pointerup', 'pointercancel'])
    chart.addEventListener(name, () => {
      dragging = false;
      endDrag();
    });
  chart.addEventListener('keydown', (event) => {
    const by = { ArrowLeft: -0.5, ArrowDown: -0.5, ArrowRight: 0.5, ArrowUp: 0.5, PageDown: -5, PageUp: 5 }[event.key];
    if (by === undefined || !walker?.tilt_key) return;
    event.preventDefault();
    setTilt(walker.tilt_deg + by);
  });
}

const three = (value) => Number(Math.abs(value) < 1e-9 ? 0 : value.toPrecision(4)).toString();
const inUnit = (value, unit) => (value === null ? 'none' : `${three(value)} ${unit}`);
const tableRow = (name, value) => make('tr', {}, make('th', { scope: 'row', textContent: name }), make('td', { textContent: value }));

// Why prints run at another speed than the drawing, by so many mm/s.
function reasonRow(change) {
  const way = change < 0 ? 'less' : 'more';
  const words = `A print runs ${three(Math.abs(change))} mm/s ${way} than the drawing, because its legs, feet and friction always differ a little from the drawn ones.`;
  return make('tr', {}, make('td', { className: 'reason', colSpan: 2, textContent: words }));
}

const range = (low, high) => (low === null || high === null ? 'unknown' : `${low.toFixed(0)} to ${high.toFixed(0)} mm/s`);

const SIMULATED = 'Being simulated';

function say({ text, sure }) {
  byId('speed').textContent = text;
  byId('speed').classList.toggle('unsure', !sure);
  byId('short-bar').hidden = true;
}

/** Show the speed and the masses of a walker. */
export function showSpeed(facts) {
  walker = facts;
  const { row } = facts;
  const legs = row.m_g === null ? [] : [tableRow('m, of one leg', inUnit(row.m_g, 'g')), tableRow('j', inUnit(row.j_g_mm2, 'g mm²'))];
  const drawn = row.nominal_mm_s === undefined ? [] : [tableRow('speed as drawn', inUnit(row.nominal_mm_s, 'mm/s'))];
  if (drawn.length && row.speed_mm_s !== null) drawn.push(reasonRow(row.speed_mm_s - row.nominal_mm_s));
  say(facts.sentence);
  byId('masses').tBodies[0].replaceChildren(
    tableRow('speed, the median of prints', inUnit(row.speed_mm_s, 'mm/s')), ...drawn,
    tableRow('68 % of the prints', range(row.speed_low_68_mm_s, row.speed_high_68_mm_s)),
    tableRow('95 % of the prints', range(row.speed_low_95_mm_s, row.speed_high_95_mm_s)),
    tableRow('theory (eq. 15 of the paper)', inUnit(row.theory_mm_s, 'mm/s')),
    tableRow('mass, as a balance shows it', inUnit(facts.mass_g, 'g')),
    tableRow('M, of the body', inUnit(row.M_g, 'g')), tableRow('J', inUnit(row.J_g_mm2, 'g mm²')),
    ...legs,
  );
  byId('caption').textContent = [facts.note, facts.caption].filter(Boolean).join('. ');
  drawChart();
}

/** Say what keeps the speed of a walker from being known. */
export function showUnknown(text) {
  say({ text, sure: false });
}

/** Say that the walker is being simulated; `share` of that is done, which never shrinks, or null at its start. */
export function showWaiting(share) {
  if (byId('speed').textContent !== SIMULATED) showUnknown(SIMULATED);
  const bar = byId('short-bar');
  bar.hidden = false;
  bar.value = share ? Math.max(bar.value, share) : 0;
}

/** Show the curve, or that there is none. */
export function showCurve(drawn) {
  curve = drawn;
  drawChart();
}

// A button that does as a finding says.
function doing({ key, value, words }) {
  const button = make('button', { type: 'button', textContent: words });
  button.addEventListener('click', () => set(key, value, 'shape'));
  return button;
}

// What a finding means for whoever prints, by the words of the check; $1 is the name of what it found.
const MEANINGS = [
  [/hangs over air/, 'Print this with supports under the body. The orange faces hang over air.'],
  [/(.+?) prints upright, over air/, 'Print this with supports, or tilt $1 less.'],
  [/(.+?) prints as a staircase/, 'The layers of $1 step aside too far. Print lower layers.'],
  [/bend across their layers/, 'The legs print upright, which makes them weaker. The speed is less certain.'],
  [/holds on to the bed/, 'Little of it touches the bed. Print it with a brim.'],
  [/(.+?) prints high and thin/, 'Print $1 with a brim, because it is tall and thin.'],
  [/layers are thick/, 'The layers are too high for this nozzle.'],
  [/lines are not wider/, 'The printed lines must be wider than the layers are high.'],
  [/the window between/, 'The window between leg and brace may close.'],
  [/legs may fuse/, 'Two legs are so close that they may become one.'],
  [/may close up/, 'The marks are finer than a printed line and may close up.'],
  [/^(.+?) is not a whole number of layers/, 'Layers cannot print $1 exactly.'],
  [/^(.+?) is less than half a layer/, 'The printer will leave this out: $1 is too small.'],
  [/exceeds the printer/, 'This is too large for the printer.'],
  [/not one closed body/, 'This is not one closed solid, and slicers cannot print it.'],
  [/not taken as it is/, 'The file was repaired. Look at the picture before you print.'],
  [/may not go into the pocket/, 'The parts may not fit into their pockets.'],
  [/channel of the wires/, 'The channel of the wires may close.'],
  [/wall (between|around) the pocket/, 'A wall of a pocket is too thin to print.'],
  [/floor over air/, 'Print this with supports under the floor of the pocket.'],
  [/^(.+?) (is thinner than|gets no plastic)/, 'The printer will leave out $1, which is too thin.'],
  [/^(.+?) \(.*is more than one line/, 'The printer cannot make $1 exactly this thick.'],
  [/^plastic in (.+?) \(/, 'The printer puts another amount of plastic into $1 than drawn.'],
];

const MARKS = { error: 'This will fail. ', warning: '', advice: 'Good to know: ' };

function meaningOf({ text, level }) {
  for (const [words, meaning] of MEANINGS) {
    const found = text.match(words);
    if (found) return MARKS[level] + meaning.replace('$1', found[1]);
  }
  return MARKS[level] + text;
}

function findingOf(finding, isNew) {
  const numbers = finding.text.replaceAll(/(\d) mm2/g, '$1 mm²').replaceAll(/(\d) deg/g, '$1°');
  const details = make('details', {}, make('summary', { textContent: 'Details' }), make('p', { className: 'hint', textContent: numbers }));
  const tools = finding.does && isNew ? [doing(finding.does)] : [];
  return make('li', { className: finding.level }, make('p', { textContent: meaningOf(finding) }), ...tools, details);
}

/** Whether a finding says that faces of the body hang over air. */
export const hangs = ({ part, text }) => part === 'body' && text.includes('hangs over air');

/** Show what the printer makes of the walker, and words. */
export function showOutlook(outlook) {
  const buttons = outlook.findings.map(({ does }) => does?.words);
  const items = outlook.findings.map((each, k) => findingOf(each, buttons.indexOf(each.does?.words) === k));
  byId('findings').replaceChildren(...(items.length ? items : [make('li', { className: 'good' }, 'It prints as drawn.')]));
  byId('shell').textContent = outlook.shell;
  byId('python').textContent = outlook.python;
}

// A button that leads to the control in which what was measured is written.
function entering(key, name) {
  const button = make('button', { type: 'button', textContent: 'Enter what you measured' });
  button.setAttribute('aria-label', `${name}: enter what you measured`);
  button.addEventListener('click', () => {
    const control = byId(`key-${key}`);
    reveal(control);
    control.scrollIntoView({ block: 'center' });
    control.focus();
  });
  return button;
}

/** Show what makes prints differ, by its part; nothing is known of walkers that only runs know. */
export function showShares(shares) {
  byId('shares').replaceChildren(
    ...shares
      .filter(({ part }) => part > 0.005)
      .map(({ key, name, part }) =>
        make('li', {}, `${name}: ${Math.round(100 * part)} `, ...(byId(`key-${key}`) ? [entering(key, name)] : []))),
  );
  byId('no-shares').hidden = shares.length > 0;
}

/** Number with its standard error, to two digits of it. */
export function withError(value, se) {
  if (!se) return Number(value.toPrecision(3)).toString();
  const digits = Math.max(0, 1 - Math.floor(Math.log10(se)));
  return `${value.toFixed(digits)} ± ${se.toFixed(digits)}`;
}

export { listen as startChart, tableRow };

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

const range = (low, high) => (low === null || high === null ? 'unknown' : `${low.toFixed(0)} to ${high.toFixed(0)} mm/s`);

function say({ text, sure }) {
  byId('speed').textContent = text;
  byId('speed').classList.toggle('unsure', !sure);
}

/** Show the speed and the masses of a walker. */
export function showSpeed(facts) {
  walker = facts;
  const { row } = facts;
  const legs = row.m_g === null ? [] : [tableRow('m, of one leg', inUnit(row.m_g, 'g')), tableRow('j', inUnit(row.j_g_mm2, 'g mm²'))];
  const drawn = row.nominal_mm_s === undefined ? [] : [tableRow('speed as drawn', inUnit(row.nominal_mm_s, 'mm/s'))];
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

/** Say what is to be waited for, of a walker whose speed only runs tell. */
export function showWaiting(text) {
  say({ text, sure: false });
}

/** Show the curve, or that there is none. */
export function showCurve(drawn) {
  curve = drawn;
  drawChart();
}

// A button that does as a finding says.
function doing({ key, value, words }) {
  const button = make('button', { type: 'button', textContent: `make it so: ${words}` });
  button.addEventListener('click', () => set(key, value, 'shape'));
  return button;
}

/** Show what the printer makes of the walker, and words. */
export function showOutlook(outlook) {
  byId('findings').replaceChildren(
    ...(outlook.findings.length ? outlook.findings : [{ level: 'good', text: 'It prints as drawn.' }])
      .map(({ level, text, does }) =>
        make('li', { className: level }, level === 'good' ? text : `${level}: ${text} `, ...(does ? [doing(does)] : []))),
  );
  byId('shell').textContent = outlook.shell;
  byId('python').textContent = outlook.python;
}

// A button that leads to the control in which what was measured is written.
function entering(key, name) {
  const button = make('button', { type: 'button', textContent: 'enter what you measured' });
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

// The part in 3D: as it stands, as it prints, with its lengths, its balance and a run of it.

import { byId } from './ask.js';

const colourOf = (name) =>
  getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

// Corners of the part as it lies on the bed: turned about x, on its side or upside down.
function lying(positions, onSide) {
  const turned = new Float32Array(positions);
  for (let k = 0; k < turned.length; k += 3) {
    const [y, z] = [positions[k + 1], positions[k + 2]];
    [turned[k + 1], turned[k + 2]] = onSide ? [z, -y] : [-y, -z];
  }
  return turned;
}

/** Viewer in a canvas; null where the browser gives no WebGL. */
export function viewerOf(canvas, positions) {
  const viewer = globalThis.walkergenViewer?.create(canvas, [positions]);
  if (!viewer) return null;
  const paint = () =>
    viewer.paint(colourOf('page'), colourOf('plate'), colourOf('edge'), colourOf('fault'), colourOf('ink'));
  paint();
  viewer.repainted(paint);
  return viewer;
}

let viewer = null;
let shown = null; // the last good walker: facts, positions, legs
let [legsAtFault, overhangs] = [false, false];

const STEEP = Math.SQRT1_2 + 1e-6; // upward part of a face's normal from which it prints over air, upside down

// For each triangle whether it is at fault; null where none is.
function faultsOf(positions, legs) {
  if (!overhangs) return legsAtFault ? legs : null;
  const marked = legsAtFault ? legs.slice() : new Uint8Array(legs.length);
  const top = positions.reduce((most, y, k) => (k % 3 === 1 ? Math.max(most, y) : most), -Infinity);
  for (let k = 0; k < legs.length; k += 1) {
    const [ax, ay, az, bx, by, bz, cx, cy, cz] = positions.subarray(9 * k, 9 * k + 9);
    const normal = [
      (by - ay) * (cz - az) - (bz - az) * (cy - ay),
      (bz - az) * (cx - ax) - (bx - ax) * (cz - az),
      (bx - ax) * (cy - ay) - (by - ay) * (cx - ax),
    ];
    if (!legs[k] && Math.min(ay, by, cy) < top - 1e-4 && normal[1] > STEEP * Math.hypot(...normal)) marked[k] = 1;
  }
  return marked;
}

function draw() {
  if (!viewer || !shown) return;
  const { facts, positions, legs } = shown;
  const printed = byId('printed').checked;
  const placed = printed ? lying(positions, facts.prints === 'on its side') : positions;
  viewer.replace(placed, colourOf(`${facts.kind}-part`), faultsOf(positions, legs));
  const way = printed ? 0 : { forward: 1, backward: -1 }[facts.sentence.kind] ?? 0;
  viewer.measure(byId('lengths').checked && !printed ? facts.dimensions : [], byId('layer'), way, 'runs this way');
  viewer.point(byId('balance').checked && !printed ? facts.centre : null);
  const loads = facts.loads.map((each) => `${each.percent.toFixed(1)} % on the feet at ${each.along_mm} mm`);
  const words = byId('balance').checked ? [`Weight at rest: ${loads.join(', ') || 'shared by all feet'}.`] : [];
  if (printed) words.push(`It prints ${facts.prints}.`);
  byId('loads').textContent = words.join(' ');
}

/** Show the walker; what was shown before goes on until a walker can be built. */
export function showPart(walker) {
  if (!viewer && !shown) {
    viewer = viewerOf(byId('canvas'), walker.positions);
    viewer?.scaled(byId('scale'));
    byId('no-webgl').hidden = Boolean(viewer);
    byId('still').hidden = !viewer; // it lies behind the view, and is another walker's soon
  }
  shown = walker;
  stopPlaying();
  draw();
}

/** Draw the legs, and faces of the body that print over air, in the colour of what is at fault, or not. */
export function markFaults(legs, hanging) {
  if (legs === legsAtFault && hanging === overhangs) return;
  [legsAtFault, overhangs] = [legs, hanging];
  draw();
}

// A run that plays in the view, at first as fast as it is.
const LARGER = 20; // times that the plate's motion is shown on wish
let run = null;
let frame = null;
let before = null;

const pace = () => Number(byId('pace').value);

function standAt(time) {
  byId('time').value = time;
  byId('time-shown').textContent = pace() < 10 ? `${time.toFixed(2)} s` : `${(1000 * time).toFixed(1)} ms`;
  run.show(time, pace(), byId('exaggerate').checked ? LARGER : 1);
}

function step(now) {
  const passed = before === null ? 0 : (now - before) / 1000 / pace();
  before = now;
  const time = Number(byId('time').value) + passed;
  standAt(Math.min(time, run.last));
  if (time >= run.last) pause('Play again');
  else frame = requestAnimationFrame(step);
}

function pause(word = 'Play') {
  cancelAnimationFrame(frame);
  [frame, before] = [null, null];
  byId('play').textContent = word;
}

function stopPlaying() {
  pause();
  run = null;
  byId('player').hidden = true;
}

function play() {
  if (!run || frame !== null) return pause();
  if (Number(byId('time').value) >= run.last) standAt(0);
  byId('play').textContent = 'Pause';
  frame = requestAnimationFrame(step);
}

/** Play seconds of the walker's run, as the server packed them. */
export function playRun(packed) {
  if (!viewer) return;
  byId('printed').checked = false;
  draw();
  viewer.measure([], byId('layer'));
  run = viewer.run(packed);
  byId('player').hidden = false;
  byId('exaggerated').hidden = !packed.plate;
  byId('time').max = run.last;
  byId('pace').value = '1';
  byId('played').textContent = `${packed.words}. The line shows where it went; corners glow when they land.`;
  standAt(0);
  play();
}

const STILL = 'walkergen-still'; // picture of this tab's walker before a reload

/** Show a still picture until the view is drawn: of this tab's walker before a reload, or of a template. */
export function showStill(template) {
  const kept = sessionStorage.getItem(STILL);
  if (kept || template !== 'koumakis2016') byId('still').src = kept ?? `picture/${template}.svg`;
}

export function startPart() {
  addEventListener('pagehide', () => viewer && sessionStorage.setItem(STILL, viewer.picture()));
  for (const id of ['printed', 'lengths', 'balance']) byId(id).addEventListener('change', draw);
  const views = { angle: 'From an angle', front: 'From the side', end: 'From the front', above: 'From above', below: 'From below' };
  for (const [name, words] of Object.entries(views)) {
    const button = Object.assign(document.createElement('button'), { type: 'button', textContent: words });
    button.addEventListener('click', () => viewer?.look(name));
    byId('views').append(button);
  }
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', draw);
  byId('play').addEventListener('click', play);
  for (const id of ['pace', 'exaggerate']) byId(id).addEventListener('change', () => run && standAt(Number(byId('time').value)));
  byId('time').addEventListener('input', () => {
    if (!run) return;
    pause();
    standAt(Number(byId('time').value));
  });
}

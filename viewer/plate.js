// The plate: a grid of lines that fade at their ends.

import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments } from 'three';

const PIECES = 32; // of each line

/** Half the plate's length over the part's. */
export const PLATE = 12;

// Spacing of the lines: 1, 2 or 5 times a power of ten, at most a fifth of `length`.
function spacing(length) {
  const power = 10 ** Math.floor(Math.log10(length / 5));
  return power * [5, 2, 1].find((factor) => factor * power <= length / 5);
}

// Lines of `count` cells of `step` wide, in short pieces: the picture fades at their ends.
function grid(step, count) {
  const half = (count * step) / 2;
  const piece = (count * step) / PIECES;
  const points = [];
  for (let k = 0; k <= count; k += 1)
    for (let i = 0; i < PIECES; i += 1) {
      const [at, from, to] = [k * step - half, i * piece - half, (i + 1) * piece - half];
      points.push(at, 0, from, at, 0, to, from, 0, at, to, 0, at);
    }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
  return geometry;
}

/** Plate for parts up to a length: { lines, fit(length), spacing(), under(x, z) }. */
export function create() {
  const lines = new LineSegments(new BufferGeometry(), new LineBasicMaterial());
  let step = 0;

  function fit(length) {
    if (spacing(length) === step) return;
    step = spacing(length);
    lines.geometry.dispose();
    lines.geometry = grid(step, 2 * Math.ceil((PLATE * length) / step));
  }

  /** Put the plate below a place, so that its lines stand still. */
  function under(start, moved) {
    const whole = (distance) => step * Math.round(distance / step);
    lines.position.set(start.x + whole(moved.x), lines.position.y, start.z + whole(moved.z));
  }

  return { lines, fit, under, spacing: () => step };
}

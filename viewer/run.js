// A packed run of a walker: where it is at a time, and how brightly its corners are lit.

const GLOW = 0.25; // seconds on the screen for which a landing is seen
const PRESSED = 0.2; // brightness of a corner that stays on the plate

const bytesOf = (base64) => Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));

function floats(base64) {
  const bytes = bytesOf(base64);
  const view = new DataView(bytes.buffer);
  return Float32Array.from({ length: bytes.length / 4 }, (_, i) => view.getFloat32(4 * i, true));
}

/**
 * Run as the page's data hold it: { last, poseAt(time), plateAt(time), lightsAt(time, slow) }, times
 * in s; the plate's height over its mean is in mm.
 */
export function unpack({ interval, poses: packedPoses, landings: packedLandings, closed, corners, plate }) {
  const [poses, landings, contacts] = [floats(packedPoses), floats(packedLandings), bytesOf(closed)];
  const count = poses.length / 7;
  const heights = plate ? floats(plate) : null;
  const wide = Math.ceil(corners.length / 8); // bytes of a pose: a bit for each corner

  // Numbers of a sample, blended between samples.
  function at(time, values, wide) {
    const low = Math.min(Math.floor(time / interval), count - 2);
    const share = Math.min(Math.max(time / interval - low, 0), 1);
    return Array.from({ length: wide }, (_, i) => {
      const [a, b] = [values[wide * low + i], values[wide * (low + 1) + i]];
      return a + share * (b - a);
    });
  }

  // Shift (mm) and quaternion (x, y, z, w).
  const poseAt = (time) => at(time, poses, 7);
  const plateAt = (time) => (heights ? at(time, heights, 1)[0] : 0);

  // 0..1 for each corner; `slow`: how many times slower than it is the run is shown.
  function lightsAt(time, slow) {
    const row = wide * Math.min(Math.round(time / interval), count - 1);
    const pressed = (corner) => contacts[row + (corner >> 3)] & (128 >> (corner & 7));
    const lit = corners.map((_, corner) => (pressed(corner) ? PRESSED : 0));
    for (let i = 0; i < landings.length && landings[i] <= time; i += 3) {
      const left = 1 - ((time - landings[i]) * slow) / GLOW;
      const corner = landings[i + 1];
      if (left > 0)
        lit[corner] = Math.max(lit[corner], left * (0.25 + 0.75 * Math.sqrt(landings[i + 2])));
    }
    return lit;
  }

  return { last: (count - 1) * interval, poseAt, plateAt, lightsAt };
}

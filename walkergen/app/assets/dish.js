// Ten walkers in a dish, seen from above, as they ran.

import { byId } from './ask.js';

let [crowd, frame, begun] = [null, null, 0];

const colourOf = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

function draw(time) {
  const canvas = byId('dish-canvas');
  const paper = canvas.getContext('2d');
  const last = crowd.times.length - 1;
  const at = Math.min(Math.round(time / (crowd.times[1] - crowd.times[0])), last);
  const scale = canvas.width / 2 / (crowd.radius * 1.04);
  paper.setTransform(1, 0, 0, 1, 0, 0);
  paper.fillStyle = colourOf('page');
  paper.fillRect(0, 0, canvas.width, canvas.height);
  paper.setTransform(scale, 0, 0, -scale, canvas.width / 2, canvas.height / 2);
  paper.strokeStyle = colourOf('soft');
  paper.lineWidth = 1 / scale;
  paper.beginPath();
  paper.arc(0, 0, crowd.radius, 0, 2 * Math.PI);
  paper.stroke();
  crowd.frames[at].forEach(([x, y, heading], number) => {
    paper.strokeStyle = colourOf('plate');
    paper.beginPath(); // where it came from
    for (let k = 0; k <= at; k += 1) paper.lineTo(...crowd.frames[k][number].slice(0, 2));
    paper.stroke();
    paper.save();
    paper.translate(x, y);
    paper.rotate(heading);
    paper.fillStyle = colourOf('flexible-part');
    paper.beginPath();
    for (const [along, across] of crowd.outline) paper.lineTo(along, across);
    paper.closePath();
    paper.fill();
    paper.fillStyle = colourOf('edge'); // its front
    const front = Math.max(...crowd.outline.map(([along]) => along));
    paper.beginPath();
    paper.arc(0.75 * front, 0, 0.12 * front, 0, 2 * Math.PI);
    paper.fill();
    paper.restore();
  });
  byId('dish-time').textContent = `${crowd.times[at].toFixed(1)} s`;
  return at === last;
}

function step(now) {
  begun ||= now;
  if (!draw((now - begun) / 1000)) frame = requestAnimationFrame(step);
}

function play() {
  cancelAnimationFrame(frame);
  begun = 0;
  frame = requestAnimationFrame(step);
}

/** Play a crowd: { radius, outline, times, frames }, mm and s. */
export function playCrowd(answer) {
  if (answer.refused) return answer.refused.map(({ text }) => text).join('\n');
  crowd = answer;
  byId('dish').hidden = false;
  play();
  return '';
}

export const startDish = () => byId('dish-play').addEventListener('click', play);

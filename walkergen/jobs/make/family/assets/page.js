// The page's behaviour: one chosen part, shown alike by viewer, chart and table; a sortable table.
// `walkergenViewer` is the bundle built from viewer/.
'use strict';

(() => {
  const byId = (id) => document.getElementById(id);
  const parts = JSON.parse(byId('parts').textContent);
  const shown = parts.map((part, member) => member);
  const slider = byId('tilt');
  let viewer = null;
  let chosen = null;
  let player = null; // of the run that the page holds, if any

  const bytesOf = (base64) =>
    Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));

  // Link that holds the STL file of a member.
  const linkOf = (member) => document.querySelectorAll('[data-stl]')[shown.indexOf(member)];

  // Corners of a part that prints upside down, z up, turned onto its feet, y up.
  function stood(found) {
    for (let k = 0; k < found.length; k += 3)
      [found[k + 1], found[k + 2]] = [-found[k + 2], found[k + 1]];
    return found;
  }

  // Corners of a binary STL file: an 84 byte header, then 50 bytes a triangle, 12 of them its normal.
  function corners(member) {
    const bytes = bytesOf(linkOf(member).href.split(',')[1]);
    const view = new DataView(bytes.buffer);
    const count = view.getUint32(80, true);
    const found = new Float32Array(9 * count);
    for (let i = 0; i < count; i += 1)
      for (let k = 0; k < 9; k += 1) found[9 * i + k] = view.getFloat32(96 + 50 * i + 4 * k, true);
    return parts[member].legs_up ? stood(found) : found;
  }

  // Members of a kind that have a mesh, by tilt: what the slider runs over.
  function members(legs) {
    return shown
      .filter((member) => parts[member].legs === legs)
      .sort((a, b) => parts[a].tilt_deg - parts[b].tilt_deg);
  }

  // What the chart says of a member's speeds.
  function labels(member) {
    const points = document.querySelectorAll(`.point[data-member="${member}"] title`);
    return [...points].map((title) => title.textContent);
  }

  function choose(member) {
    chosen = member;
    const part = parts[member];
    const row = members(part.legs);
    slider.max = row.length - 1;
    slider.value = row.indexOf(member);
    slider.setAttribute('aria-valuetext', `${part.tilt_deg} degrees`);
    byId('tilt-shown').textContent = `${part.tilt_deg}°`;
    byId('shown').textContent = [part.name, ...labels(member)].join('; ');
    byId('kinds').querySelector(`[value="${CSS.escape(part.legs)}"]`).checked = true;
    for (const marked of document.querySelectorAll('[data-member]'))
      marked.classList.toggle('chosen', Number(marked.dataset.member) === member);
    Object.assign(byId('save').firstElementChild, {
      href: linkOf(member).href, download: linkOf(member).download,
    });
    byId('save').hidden = false;
    viewer?.show(shown.indexOf(member), colourOf(`${part.legs}-part`));
    player?.attend(member);
  }

  const colourOf = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

  // The page's colours, which are others in the dark.
  function paint() {
    viewer.paint(colourOf('page'), colourOf('plate'), colourOf('edge'));
    if (chosen !== null) viewer.colour(colourOf(`${parts[chosen].legs}-part`));
  }

  // The member of a kind whose tilt is nearest to the chosen one's.
  function nearest(legs) {
    const distance = (member) => Math.abs(parts[member].tilt_deg - parts[chosen].tilt_deg);
    return members(legs).reduce((a, b) => (distance(b) < distance(a) ? b : a));
  }

  function addKinds() {
    for (const legs of new Set(shown.map((member) => parts[member].legs))) {
      const radio = Object.assign(document.createElement('input'), {
        type: 'radio', name: 'legs', value: legs,
      });
      radio.addEventListener('change', () => choose(nearest(legs)));
      const label = document.createElement('label');
      label.append(radio, ` ${legs}`);
      byId('kinds').append(label);
    }
  }

  function startViewer() {
    if (!shown.length) {
      byId('no-viewer-reason').textContent = 'No STL file is left in the folder to be shown.';
      return;
    }
    byId('viewer').hidden = false;
    viewer = walkergenViewer.create(byId('canvas'), shown.map(corners));
    if (!viewer) {
      byId('viewer').hidden = true;
      byId('no-viewer-reason').textContent =
        'This browser offers no WebGL, which the 3D viewer needs; everything else is here.';
      return;
    }
    byId('no-viewer').hidden = true;
    paint();
    viewer.repainted(paint);
    byId('spacing').textContent = viewer.spacing;
    for (const button of byId('views').children)
      button.addEventListener('click', () => viewer.look(button.dataset.view));
  }

  // Plays the run, in the viewer's own view.
  function playerOf(run) {
    const { last, show } = viewer.run(run);
    const [button, slider, pace] = ['play', 'time', 'pace'].map(byId);
    let [time, before, frame] = [0, null, null];

    function showAt(at) {
      time = Math.min(Math.max(at, 0), last);
      slider.value = time;
      byId('time-shown').textContent = `${(1e3 * time).toFixed(1)} ms`;
      show(time, Number(pace.value));
    }

    function step(now) {
      showAt(time + (now - (before ?? now)) / 1e3 / Number(pace.value));
      before = now;
      if (time < last) frame = requestAnimationFrame(step);
      else pause();
    }

    function pause() {
      cancelAnimationFrame(frame);
      [frame, before] = [null, null];
      button.textContent = 'play';
    }

    function play() {
      if (frame !== null) return pause();
      showAt(time < last ? time : 0);
      button.textContent = 'pause';
      frame = requestAnimationFrame(step);
    }

    // Another part has no run: it stands still, and the way back is told.
    function attend(member) {
      pause();
      const own = member === run.member;
      byId('player').hidden = !own;
      byId('other').hidden = own;
      if (own) showAt(time);
    }

    slider.max = last;
    button.addEventListener('click', play);
    byId('running').addEventListener('click', () => {
      choose(run.member);
      button.focus();
    });
    slider.addEventListener('input', () => showAt(Number(slider.value)));
    return { attend, member: run.member };
  }

  function startPlayer() {
    if (!byId('run-data')) return;
    const run = JSON.parse(byId('run-data').textContent);
    if (!viewer || !shown.includes(run.member)) byId('run').hidden = true;
    else player = playerOf(run);
  }

  // Numbers by size, words by the alphabet, empty cells last whichever way.
  function compare(a, b, sign) {
    if (a === '' || b === '') return (a === '') - (b === '');
    const difference = Number(a) - Number(b);
    return sign * (Number.isNaN(difference) ? a.localeCompare(b, 'en', { numeric: true }) : difference);
  }

  function sortBy(heading) {
    const ascending = heading.getAttribute('aria-sort') !== 'ascending';
    for (const other of heading.parentNode.children) other.setAttribute('aria-sort', 'none');
    heading.setAttribute('aria-sort', ascending ? 'ascending' : 'descending');
    const body = byId('family').tBodies[0];
    const value = (row) => row.cells[heading.cellIndex].dataset.value;
    const rows = [...body.rows].sort((a, b) => compare(value(a), value(b), ascending ? 1 : -1));
    body.append(...rows);
  }

  function listen() {
    slider.addEventListener('input', () => {
      choose(members(parts[chosen].legs)[slider.value]);
    });
    for (const heading of byId('family').tHead.rows[0].cells)
      heading.firstElementChild.addEventListener('click', () => sortBy(heading));
    for (const row of byId('family').tBodies[0].rows) {
      const member = Number(row.dataset.member);
      const button = row.querySelector('.pick');
      button.disabled = !viewer || !shown.includes(member);
      button.addEventListener('click', () => choose(member));
    }
    for (const mark of document.querySelectorAll('.mark')) {
      const label = mark.querySelector('title').textContent;
      mark.addEventListener('pointerenter', () => (byId('readout').textContent = label));
    }
    for (const point of document.querySelectorAll('.point')) {
      const member = Number(point.dataset.member);
      const label = point.querySelector('title').textContent;
      point.addEventListener('pointerenter', () => (byId('readout').textContent = label));
      point.addEventListener('click', () => {
        byId('readout').textContent = label;
        if (shown.includes(member)) choose(member);
      });
    }
  }

  // What is folded away is printed as well, but for the list of downloads.
  function unfoldOnPaper() {
    const folded = [];
    addEventListener('beforeprint', () => {
      for (const details of document.querySelectorAll('section:not(.downloads) details:not([open])')) {
        details.open = true;
        folded.push(details);
      }
    });
    addEventListener('afterprint', () => {
      for (const details of folded.splice(0)) details.open = false;
    });
  }

  addKinds();
  startViewer();
  unfoldOnPaper();
  listen();
  startPlayer();
  if (player) choose(player.member);
  else if (shown.length) choose(shown[Math.floor(members(parts[shown[0]].legs).length / 4)]);
})();

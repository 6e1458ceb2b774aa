// The part, or one of several, on the plate in a frame or a page. The viewer and the meshes are
// packed (zlib, base64); `walkergenViewer` is the bundle built from viewer/.
'use strict';

(async () => {
  const byId = (id) => document.getElementById(id);
  const tell = (words) => (byId('told').textContent = words);
  const without = (words) => {
    byId('canvas').hidden = byId('bar').hidden = true;
    tell(words);
  };
  const colourOf = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

  async function unpacked(id) {
    const text = byId(id).textContent.trim();
    const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
    return new Response(stream).arrayBuffer();
  }

  // Corners of triangles, nine numbers each, part after part: little-endian, as files have them.
  function cornersOf(buffer, parts) {
    const view = new DataView(buffer);
    let at = 0;
    return parts.map((part) =>
      Float32Array.from({ length: 9 * part.triangles }, () => view.getFloat32(4 * at++, true)),
    );
  }

  const parts = JSON.parse(byId('parts').textContent);
  if (!window.DecompressionStream)
    return without('This browser is too old for the 3D view: it cannot unpack it.');
  const script = document.createElement('script');
  script.textContent = new TextDecoder().decode(await unpacked('viewer'));
  document.head.append(script);
  const viewer = walkergenViewer.create(byId('canvas'), cornersOf(await unpacked('meshes'), parts));
  if (!viewer) return without('This browser offers no WebGL, which the 3D view needs.');

  let chosen = 0;
  function paint() {
    viewer.paint(colourOf('page'), colourOf('plate'), colourOf('edge'));
    viewer.colour(colourOf(parts[chosen].kind));
  }
  function choose(index) {
    chosen = index;
    const { name, kind, words } = parts[index];
    viewer.show(index, colourOf(kind));
    tell(`${name}${words && `: ${words}`}. Drag or press arrow keys to turn; click, then scroll to zoom. ` +
      `Lines are ${viewer.spacing} mm apart.`);
    for (const choice of choices) choice.value = index;
  }
  const choices = document.querySelectorAll('#part, #slide');
  choose(parts.length >> 2);
  paint();
  viewer.repainted(paint);
  for (const choice of choices)
    choice.addEventListener(choice.type === 'range' ? 'input' : 'change', () => choose(Number(choice.value)));
  for (const button of byId('views').children)
    button.addEventListener('click', () => viewer.look(button.dataset.view));
})();

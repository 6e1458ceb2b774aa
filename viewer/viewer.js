// A part on the plate, to be turned by mouse, finger or arrow keys. Lengths in mm, y is up.

import {
  AmbientLight,
  Box3,
  BufferAttribute,
  BufferGeometry,
  DirectionalLight,
  DoubleSide,
  EdgesGeometry,
  Fog,
  Line,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  PerspectiveCamera,
  Quaternion,
  Scene,
  SphereGeometry,
  Spherical,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

import { PLATE, create as createPlate } from './plate.js';
import { unpack } from './run.js';

const FIELD_OF_VIEW = 30; // degrees
const EDGE_ANGLE = 25; // degrees between faces from which their edge is drawn
const EDGED_AT_ONCE = 2_000; // triangles up to which edges are drawn in every frame; those of more, at rest
const REST_MS = 250; // without another part, after which the view is at rest
const MOVING_RATIO = 0.6; // pixels in a row while parts follow each other, over those at rest
const MOST_EDGED = 30_000; // triangles up to which edges are drawn: to find those of 100 000 takes a second
const FILLED = 0.94; // share of the frame that the part takes
const GROWN = 1.15; // change of size from which the view is fitted anew
const KEY_STEP = Math.PI / 24;
const LIGHT_SIZE = 0.035; // radius of a corner's light at its brightest, over the part's size
const POINT_SIZE = 0.5; // radius of a marked point over that of a light
const TRACED = 200; // places of a run that its trace goes through
const ARROW = [-0.5, 0, -0.03, 0.25, 0, -0.03, 0.25, 0, 0.03, -0.5, 0, 0.03, 0.2, 0, -0.1, 0.5, 0, 0, 0.2, 0, 0.1];
const ARROW_LENGTH = 0.4; // over the part's
const ARROW_GAP = 0.35; // from the part's side to its middle, over its length
const LABEL = 20; // height of a length's words, pixels

// Directions from the part to the camera.
const VIEWS = {
  angle: [0.45, 0.29, 0.85],
  front: [0, 0, 1],
  end: [1, 0, 0],
  above: [0, 1, 0.001],
  below: [0, -1, 0.001],
};

// Corners of triangles in a geometry; those that `marked` (a number a triangle) names come last, as
// a second group of their own.
function geometryOf(positions, marked) {
  const geometry = new BufferGeometry();
  let [ordered, plain] = [positions, positions.length / 9];
  if (marked) {
    ordered = new Float32Array(positions.length);
    plain = marked.reduce((count, mark) => count + (mark ? 0 : 1), 0);
    let [front, back] = [0, plain];
    marked.forEach((mark, k) => {
      const place = mark ? back++ : front++;
      ordered.set(positions.subarray(9 * k, 9 * k + 9), 9 * place);
    });
  }
  geometry.setAttribute('position', new BufferAttribute(ordered, 3));
  geometry.addGroup(0, 3 * plain, 0);
  geometry.addGroup(3 * plain, positions.length / 3 - 3 * plain, 1);
  geometry.computeVertexNormals(); // no shared vertices: a normal for each face
  geometry.computeBoundingBox();
  return geometry;
}

/**
 * A viewer in `canvas`, or null where the browser gives no WebGL. `parts`: Float32Arrays of
 * triangles' corners, nine numbers a triangle. Returns { show, replace, look, run, measure, point,
 * scaled, paint, picture, colour, repainted, spacing }.
 */
export function create(canvas, parts) {
  const context = canvas.getContext('webgl2', { antialias: true });
  if (!context) return null;
  const renderer = new WebGLRenderer({ canvas, context, antialias: true });

  const scene = new Scene();
  const plate = createPlate();
  scene.fog = new Fog(0xffffff, 1, 2); // the plate fades out far behind the part
  const sun = new DirectionalLight(0xffffff, 2.6);
  scene.add(plate.lines, new AmbientLight(0xffffff, 1.5));

  const camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 1, 1000);
  camera.add(sun); // it shines over the viewer's left shoulder
  sun.position.set(-0.5, 0.9, 1);
  camera.add(sun.target);
  sun.target.position.set(0, 0, -1);
  scene.add(camera);

  const surface = () => new MeshLambertMaterial({ polygonOffset: true, polygonOffsetFactor: 1 });
  const [material, fault] = [surface(), surface()];
  const part = new Mesh(new BufferGeometry(), [material, fault]);
  const edges = new LineSegments(new BufferGeometry(), new LineBasicMaterial());
  const ruler = new LineSegments(new BufferGeometry(), new LineBasicMaterial());
  const trace = new Line(new BufferGeometry(), new LineBasicMaterial());
  for (const own of [material, fault, edges.material, ruler.material]) own.fog = false;
  scene.add(part.add(edges, ruler), trace);

  // Arrow on the plate that shows where the part will run, one long, along x
  const arrow = new Mesh(new BufferGeometry(), new MeshBasicMaterial({ side: DoubleSide, fog: false }));
  arrow.geometry.setAttribute('position', new BufferAttribute(new Float32Array(ARROW), 3));
  arrow.geometry.setIndex([0, 1, 2, 0, 2, 3, 4, 5, 6]);
  arrow.visible = false;
  scene.add(arrow);

  // Lights at the corners of the feet, and a point, seen through the part.
  const seenThrough = (color, opacity) => {
    const glow = new MeshBasicMaterial({ color, opacity });
    return Object.assign(glow, { transparent: true, depthTest: false, fog: false });
  };
  const glow = seenThrough(0xe8590c, 0.85);
  const sphere = new SphereGeometry(1, 20, 12);
  const lights = [];
  const centreMark = new Mesh(sphere, seenThrough(0xffffff, 0.9));
  centreMark.visible = false;
  part.add(centreMark);

  const controls = new OrbitControls(camera, canvas);
  controls.enablePan = false;
  controls.enableZoom = false; // the wheel scrolls the page until the canvas has the focus

  let size = new Vector3(1, 1, 1);
  let centre = new Vector3();
  let seenSize = 1; // of the part for which the camera's distance was chosen
  let labels = []; // of lengths: element and place in the part
  let scaleBar = null; // element that is as wide as a round length, which stands in it
  let waiting = 0; // for the next frame
  let resting = 0; // timer that ends once no other part has come
  let heads = false; // once an arrow has been shown, for which the frame then has room
  let moving = false; // while one part follows another
  let ratio = 1; // of pixels

  // Fit plate, light and camera to boxes of this size; what stood in the view goes on being seen.
  function fit(whole) {
    size = whole.getSize(new Vector3());
    centre = whole.getCenter(new Vector3()).setY(size.y / 2);
    const radius = size.length() / 2;
    plate.fit(size.x);
    [camera.near, camera.far] = [radius / 20, radius * 60];
    camera.updateProjectionMatrix();
    [controls.minDistance, controls.maxDistance] = [0.5 * radius, radius * 20];
  }

  // Words of the lengths stand beside their lines, whatever the view, within the frame and apart.
  function placeLabels() {
    const { clientWidth: width, clientHeight: height } = canvas;
    const placed = [];
    for (const { label, place } of labels) {
      const at = part.localToWorld(place.clone()).project(camera);
      const half = label.offsetWidth / 2;
      const within = (value, margin, whole) => Math.min(Math.max(value, margin), whole - margin);
      const x = within(((at.x + 1) / 2) * width, half, width);
      let y = within(((1 - at.y) / 2) * height, LABEL / 2, height);
      const over = () => placed.find((own) => Math.abs(own.x - x) < own.half + half && Math.abs(own.y - y) < LABEL);
      for (let tries = 0, own; (own = over()) && tries < labels.length; tries += 1) {
        const below = own.y + LABEL;
        y = below < height - LABEL / 2 ? below : own.y - LABEL;
      }
      placed.push({ x, y, half });
      label.style.transform = `translate(${x}px, ${y}px) translate(-50%, -50%)`;
    }
  }

  // The bar is a round length as it is seen at the part's place, a tenth to a third of the frame.
  function placeScale() {
    if (!scaleBar) return;
    const { clientWidth: width, clientHeight: height } = canvas;
    const distance = camera.position.distanceTo(controls.target);
    const perPixel = (2 * distance * Math.tan((FIELD_OF_VIEW * Math.PI) / 360)) / height;
    const most = (perPixel * width) / 4;
    const power = 10 ** Math.floor(Math.log10(most));
    const length = power * [5, 2, 1].find((factor) => factor * power <= most);
    scaleBar.style.width = `${length / perPixel}px`;
    scaleBar.firstElementChild.textContent = `${Number(length.toPrecision(1))} mm`;
  }

  /** Make an element as wide as a round length, which is told in its first child. */
  function scaled(element) {
    scaleBar = element;
    draw();
  }

  // Once a frame, however much has changed since the last.
  function draw() {
    waiting ||= requestAnimationFrame(render);
  }

  function render() {
    waiting = 0;
    if (!part.geometry.hasAttribute('position')) return; // what lies behind the canvas is seen until then
    const wanted = window.devicePixelRatio * (moving ? MOVING_RATIO : 1);
    if (wanted !== ratio) renderer.setPixelRatio((ratio = wanted));
    const distance = camera.position.distanceTo(controls.target);
    [scene.fog.near, scene.fog.far] = [distance, distance + PLATE * size.x * 0.75];
    renderer.render(scene, camera);
    placeLabels();
    placeScale();
  }

  /** Use these CSS colours for background, lines of the plate, edges of the part, its faults and lengths. */
  function paint(background, lines, edge, faulty = edge, lengths = edge) {
    renderer.setClearColor(background);
    scene.fog.color.setStyle(background);
    plate.lines.material.color.setStyle(lines);
    for (const own of [edges.material, centreMark.material]) own.color.setStyle(edge);
    for (const own of [ruler.material, trace.material, arrow.material]) own.color.setStyle(lengths);
    fault.color.setStyle(faulty);
    render(); // at once: paper waits for no frame
  }

  /** Address of a picture of the view, as data. */
  function picture() {
    render();
    return canvas.toDataURL('image/webp');
  }

  /** Show the part in a CSS colour. */
  function colour(css) {
    material.color.setStyle(css);
    render();
  }

  /**
   * Call `paint` whenever the page's colours become others: dark, light, and light for paper, while
   * the page's root has data-paper. Browsers print the last frame that a screen has shown of WebGL,
   * so that a copy of the view stands in its place as long.
   */
  function repainted(paint) {
    const { dataset } = document.documentElement;
    const copy = document.createElement('canvas');
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', paint);
    addEventListener('beforeprint', () => {
      dataset.paper = '';
      paint();
      const { id, className, width, height, clientWidth, clientHeight } = canvas;
      Object.assign(copy, { id, className, width, height });
      Object.assign(copy.style, { width: `${clientWidth}px`, height: `${clientHeight}px` });
      copy.getContext('2d').drawImage(canvas, 0, 0);
      canvas.replaceWith(copy);
    });
    addEventListener('afterprint', () => {
      delete dataset.paper;
      copy.replaceWith(canvas);
      paint();
    });
  }

  function resize() {
    const { clientWidth: width, clientHeight: height } = canvas;
    if (!width || !height) return;
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    lookFrom(camera.position.clone().sub(controls.target)); // all of it is seen in any frame
  }

  // Distance along a direction from which the box of all parts just fills the frame.
  function distanceOf(direction) {
    const towards = direction.clone().normalize();
    const right = new Vector3(0, 1, 0).cross(towards).normalize();
    const up = towards.clone().cross(right);
    const high = FILLED * Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
    let distance = 0;
    const half = size.clone().multiplyScalar(0.5);
    const corners = Array.from({ length: 8 }, (_, k) => new Vector3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1).multiply(half));
    const beside = half.z + (ARROW_GAP + 0.1) * ARROW_LENGTH * size.x;
    if (heads) corners.push(...[-1, 1].map((end) => new Vector3(end * 0.5 * ARROW_LENGTH * size.x, -half.y, beside)));
    for (const corner of corners) {
      const room = Math.max(
        Math.abs(corner.dot(right)) / (high * camera.aspect),
        Math.abs(corner.dot(up)) / high,
      );
      distance = Math.max(distance, corner.dot(towards) + room);
    }
    return distance;
  }

  // Look from a direction, from where all of the part is seen.
  function lookFrom(direction) {
    seenSize = size.length();
    camera.position.copy(direction).setLength(distanceOf(direction)).add(controls.target);
    controls.update();
    draw();
  }

  /** Look at the part from one of VIEWS. */
  const look = (name) => lookFrom(new Vector3().fromArray(VIEWS[name]));

  // Put a geometry on the plate, in a CSS colour.
  function put(geometry, css) {
    part.geometry.dispose();
    part.geometry = geometry;
    const triangles = geometry.getAttribute('position').count / 3;
    edges.visible = triangles <= EDGED_AT_ONCE;
    if (edges.visible) drawEdges();
    rest();
    material.color.setStyle(css);
    part.position.set(0, -geometry.boundingBox.min.y, 0);
    part.quaternion.identity();
    trace.visible = false;
    plate.lines.position.y = 0;
    for (const light of lights) light.visible = false;
    follow(0, 0);
    draw();
  }

  function drawEdges() {
    edges.geometry.dispose();
    edges.geometry = new EdgesGeometry(part.geometry, EDGE_ANGLE);
    edges.visible = true;
  }

  // Fewer pixels and no edges of large parts until no other part has come for a while
  function rest() {
    moving = resting !== 0;
    clearTimeout(resting);
    resting = setTimeout(() => {
      [resting, moving] = [0, false];
      const triangles = part.geometry.getAttribute('position').count / 3;
      if (!edges.visible && triangles <= MOST_EDGED) drawEdges();
      draw();
    }, REST_MS);
  }

  /** Put part `index` on the plate, in a CSS colour. */
  const show = (index, css) => put(geometryOf(parts[index], null), css);

  /**
   * Put another part on the plate, in a CSS colour; `marked`: a number for each triangle, those that
   * are not 0 are painted as faults, or null. The view stays unless the part has grown or shrunk.
   */
  function replace(positions, css, marked) {
    const geometry = geometryOf(positions, marked);
    fit(geometry.boundingBox.clone());
    put(geometry, css);
    const grown = size.length() / seenSize;
    if (grown > GROWN || grown < 1 / GROWN) lookFrom(camera.position.clone().sub(controls.target));
  }

  // Move the view along the plate, so that it has followed a part by x and z; the lines stand still.
  function follow(x, z) {
    const move = new Vector3(centre.x + x, centre.y, centre.z + z).sub(controls.target);
    camera.position.add(move);
    controls.target.add(move);
    plate.under(centre, { x, z });
  }

  /*
   * Put the part that is shown where a run has it: shifted (mm) after a turn by a quaternion (x, y,
   * z, w). `corners`: places in the part that are lit by `brightness`, 0..1 each.
   */
  function stand(shift, quaternion, corners, brightness) {
    part.position.fromArray(shift);
    part.quaternion.fromArray(quaternion).normalize();
    while (lights.length < corners.length) {
      lights.push(new Mesh(sphere, glow));
      part.add(lights.at(-1));
    }
    lights.forEach((light, k) => {
      light.visible = k < corners.length && brightness[k] > 0;
      if (!light.visible) return;
      light.position.fromArray(corners[k]);
      light.scale.setScalar(LIGHT_SIZE * size.length() * Math.max(brightness[k], 1e-3));
    });
    const moved = centre.clone().applyQuaternion(part.quaternion).add(part.position).sub(centre);
    follow(moved.x, moved.z);
    draw();
  }

  /**
   * Run of the part that is shown: { last, show(time, slow, larger) }, times in s; `larger`: how many
   * times the plate's motion is exaggerated, the part riding on it.
   */
  function run(packed) {
    const { last, poseAt, plateAt, lightsAt } = unpack(packed);
    const path = Array.from({ length: TRACED }, (_, k) => middleOf(poseAt((last * k) / (TRACED - 1))));
    trace.geometry.dispose();
    trace.geometry = new BufferGeometry().setFromPoints(path);
    trace.visible = true;
    arrow.visible = false;
    const showAt = (time, slow, larger = 1) => {
      const pose = poseAt(time);
      const height = plateAt(time);
      pose[1] += (larger - 1) * height;
      plate.lines.position.y = larger === 1 ? 0 : larger * height;
      trace.geometry.setDrawRange(0, Math.max(2, Math.ceil((TRACED * time) / last)));
      stand(pose.slice(0, 3), pose.slice(3), packed.corners, lightsAt(time, slow));
    };
    return { last, show: showAt };
  }

  // Place on the plate below the middle of the part in a pose.
  function middleOf(pose) {
    const turned = new Quaternion().fromArray(pose.slice(3)).normalize();
    return centre.clone().applyQuaternion(turned).add(new Vector3(...pose.slice(0, 3))).setY(0.02 * size.y);
  }

  /**
   * Draw lengths on the part, each { from, to, text }; their words stand in `layer`. `way`: 1 or -1 for
   * a part that will run along x or against it, which an arrow on the plate shows with `heading`; else 0.
   */
  function measure(lengths, layer, way = 0, heading = '') {
    ruler.geometry.dispose();
    ruler.geometry = new BufferGeometry().setFromPoints(
      lengths.flatMap(({ from, to }) => [new Vector3(...from), new Vector3(...to)]),
    );
    const labelled = (text, place) => {
      const label = Object.assign(document.createElement('span'), { className: 'dimension' });
      label.textContent = text;
      return { label, place };
    };
    labels = lengths.map(({ from, to, text }) =>
      labelled(text, new Vector3(...from).add(new Vector3(...to)).multiplyScalar(0.5)),
    );
    arrow.visible = way !== 0;
    if (arrow.visible) {
      const long = ARROW_LENGTH * size.x;
      arrow.scale.set(way * long, 1, long);
      arrow.position.set(centre.x, 0.002 * size.y, centre.z + size.z / 2 + ARROW_GAP * long);
      const tip = new Vector3(way * 0.75 * long, 0, 0).add(arrow.position);
      if (!heads) {
        heads = true;
        lookFrom(camera.position.clone().sub(controls.target));
      }
      labels.push(labelled(heading, part.worldToLocal(tip)));
    }
    layer.replaceChildren(...labels.map(({ label }) => label));
    draw();
  }

  /** Mark a place in the part, or none (null). */
  function point(place) {
    centreMark.visible = Boolean(place);
    if (place) centreMark.position.fromArray(place);
    centreMark.scale.setScalar(POINT_SIZE * LIGHT_SIZE * size.length());
    draw();
  }

  function turn(event) {
    const [azimuth, polar] =
      { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key] ??
      [];
    if (azimuth === undefined) return;
    event.preventDefault();
    const from = new Spherical().setFromVector3(camera.position.clone().sub(controls.target));
    from.theta += azimuth * KEY_STEP;
    from.phi += polar * KEY_STEP;
    camera.position.setFromSpherical(from.makeSafe()).add(controls.target);
    controls.update();
    draw();
  }

  controls.addEventListener('change', draw);
  canvas.addEventListener('keydown', turn);
  canvas.addEventListener('pointerdown', () => canvas.focus({ preventScroll: true }));
  canvas.addEventListener('focus', () => (controls.enableZoom = true));
  canvas.addEventListener('blur', () => (controls.enableZoom = false));
  new ResizeObserver(resize).observe(canvas);
  const whole = new Box3();
  for (const positions of parts) whole.union(geometryOf(positions, null).boundingBox);
  fit(whole);
  follow(0, 0);
  camera.position.add(new Vector3().fromArray(VIEWS.angle));
  resize();
  return {
    show, replace, look, run, measure, point, scaled, paint, picture, colour, repainted,
    spacing: plate.spacing(),
  };
}

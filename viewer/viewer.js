// A part on the plate, to be turned by mouse, finger or arrow keys. Lengths in mm, y is up.

import {
  AmbientLight,
  Box3,
  BufferAttribute,
  BufferGeometry,
  DirectionalLight,
  EdgesGeometry,
  Fog,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  PerspectiveCamera,
  Scene,
  SphereGeometry,
  Spherical,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

const FIELD_OF_VIEW = 30; // degrees
const EDGE_ANGLE = 25; // degrees between faces from which their edge is drawn
const FILLED = 0.94; // share of the frame that the part takes
const PLATE = 12; // half the plate's length over the part's
const PIECES = 32; // of each line of the plate
const KEY_STEP = Math.PI / 24;
const LIGHT_SIZE = 0.035; // radius of a corner's light at its brightest, over the part's size

// Directions from the part to the camera.
const VIEWS = {
  angle: [0.45, 0.29, 0.85],
  front: [0, 0, 1],
  end: [1, 0, 0],
  above: [0, 1, 0.001],
  below: [0, -1, 0.001],
};

// Spacing of the plate's lines: 1, 2 or 5 times a power of ten, at most a fifth of `length`.
function spacing(length) {
  const power = 10 ** Math.floor(Math.log10(length / 5));
  return power * [5, 2, 1].find((factor) => factor * power <= length / 5);
}

// Lines of the plate, `count` cells of `step` wide, in short pieces: the picture fades at their ends.
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
  return new LineSegments(geometry, new LineBasicMaterial());
}

function geometryOf(positions) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  geometry.computeVertexNormals(); // no shared vertices: a normal for each face
  geometry.computeBoundingBox();
  return geometry;
}

/**
 * A viewer in `canvas`, or null where the browser gives no WebGL. `parts`: Float32Arrays of
 * triangles' corners, nine numbers a triangle. Returns { show, look, stand, paint, colour, spacing }.
 */
export function create(canvas, parts) {
  const context = canvas.getContext('webgl2', { antialias: true });
  if (!context) return null;
  const renderer = new WebGLRenderer({ canvas, context, antialias: true });

  const whole = new Box3();
  for (const positions of parts) whole.union(geometryOf(positions).boundingBox);
  const size = whole.getSize(new Vector3());
  const centre = whole.getCenter(new Vector3()).setY(size.y / 2);
  const radius = size.length() / 2;

  const scene = new Scene();
  const step = spacing(size.x);
  const lines = 2 * Math.ceil((PLATE * size.x) / step);
  const plate = grid(step, lines);
  plate.position.set(centre.x, 0, centre.z);
  scene.fog = new Fog(0xffffff, 1, 2); // the plate fades out far behind the part
  const sun = new DirectionalLight(0xffffff, 2.6);
  scene.add(plate, new AmbientLight(0xffffff, 1.5));

  const camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, radius / 20, radius * 60);
  camera.add(sun); // it shines over the viewer's left shoulder
  sun.position.set(-0.5, 0.9, 1);
  camera.add(sun.target);
  sun.target.position.set(0, 0, -1);
  scene.add(camera);

  const material = new MeshLambertMaterial({ polygonOffset: true, polygonOffsetFactor: 1 });
  const body = new Mesh(new BufferGeometry(), material);
  const edges = new LineSegments(new BufferGeometry(), new LineBasicMaterial());
  for (const own of [material, edges.material]) own.fog = false;
  const part = body.add(edges);
  scene.add(part);

  // Lights at the corners of the feet, seen through the part.
  const glow = new MeshBasicMaterial({ color: 0xe8590c, opacity: 0.85 });
  Object.assign(glow, { transparent: true, depthTest: false });
  const sphere = new SphereGeometry(LIGHT_SIZE * size.length(), 20, 12);
  const lights = [];

  const controls = new OrbitControls(camera, canvas);
  controls.enablePan = false;
  controls.enableZoom = false; // the wheel scrolls the page until the canvas has the focus
  controls.minDistance = 0.5 * radius;
  controls.maxDistance = radius * 20;
  controls.target.copy(centre);

  function draw() {
    const distance = camera.position.distanceTo(controls.target);
    [scene.fog.near, scene.fog.far] = [distance, distance + PLATE * size.x * 0.75];
    renderer.render(scene, camera);
  }

  /** Use these CSS colours for background, lines of the plate and edges of the part. */
  function paint(background, lines, edge) {
    renderer.setClearColor(background);
    scene.fog.color.setStyle(background);
    plate.material.color.setStyle(lines);
    edges.material.color.setStyle(edge);
    draw();
  }

  /** Show the part in a CSS colour. */
  function colour(css) {
    material.color.setStyle(css);
    draw();
  }

  function resize() {
    const { clientWidth: width, clientHeight: height } = canvas;
    if (!width || !height) return;
    renderer.setPixelRatio(window.devicePixelRatio);
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    draw();
  }

  // Distance along a direction from which the box of all parts just fills the frame.
  function distanceOf(direction) {
    const towards = new Vector3().fromArray(direction).normalize();
    const right = new Vector3(0, 1, 0).cross(towards).normalize();
    const up = towards.clone().cross(right);
    const high = FILLED * Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
    let distance = 0;
    for (let k = 0; k < 8; k += 1) {
      const corner = new Vector3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1)
        .multiply(size)
        .multiplyScalar(0.5);
      const room = Math.max(
        Math.abs(corner.dot(right)) / (high * camera.aspect),
        Math.abs(corner.dot(up)) / high,
      );
      distance = Math.max(distance, corner.dot(towards) + room);
    }
    return distance;
  }

  /** Look at the part from one of VIEWS, from where all of it is seen. */
  function look(name) {
    camera.position.fromArray(VIEWS[name]).setLength(distanceOf(VIEWS[name])).add(controls.target);
    controls.update();
    draw();
  }

  /** Put part `index` on the plate, in a CSS colour. */
  function show(index, css) {
    body.geometry.dispose();
    edges.geometry.dispose();
    body.geometry = geometryOf(parts[index]);
    edges.geometry = new EdgesGeometry(body.geometry, EDGE_ANGLE);
    material.color.setStyle(css);
    part.position.set(0, -body.geometry.boundingBox.min.y, 0);
    part.quaternion.identity();
    for (const light of lights) light.visible = false;
    follow(0, 0);
    draw();
  }

  // Move the view along the plate, so that it has followed a part by x and z; the lines stand still.
  function follow(x, z) {
    const move = new Vector3(centre.x + x, centre.y, centre.z + z).sub(controls.target);
    camera.position.add(move);
    controls.target.add(move);
    const whole = (distance) => step * Math.round(distance / step);
    plate.position.set(centre.x + whole(x), 0, centre.z + whole(z));
  }

  /**
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
      light.position.fromArray(corners[k]);
      light.visible = brightness[k] > 0;
      light.scale.setScalar(Math.max(brightness[k], 1e-3));
    });
    const moved = centre.clone().applyQuaternion(part.quaternion).add(part.position).sub(centre);
    follow(moved.x, moved.z);
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
  resize();
  look('angle');
  return { show, look, stand, paint, colour, spacing: step };
}

// A part on the plate, to be turned by mouse, finger or arrow keys. Lengths in mm, y is up.

import {
  AmbientLight,
  Box3,
  BufferAttribute,
  BufferGeometry,
  DirectionalLight,
  EdgesGeometry,
  GridHelper,
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

function geometryOf(positions) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  geometry.computeVertexNormals(); // no shared vertices: a normal for each face
  geometry.computeBoundingBox();
  return geometry;
}

/**
 * A viewer in `canvas`, or null where the browser gives no WebGL. `parts`: Float32Arrays of
 * triangles' corners, nine numbers a triangle. Returns { show, look, stand, spacing }.
 */
export function create(canvas, parts) {
  const context = canvas.getContext('webgl2', { antialias: true });
  if (!context) return null;
  const renderer = new WebGLRenderer({ canvas, context, antialias: true });
  renderer.setClearColor(0xffffff);

  const whole = new Box3();
  for (const positions of parts) whole.union(geometryOf(positions).boundingBox);
  const size = whole.getSize(new Vector3());
  const centre = whole.getCenter(new Vector3()).setY(size.y / 2);
  const radius = size.length() / 2;

  const scene = new Scene();
  const step = spacing(size.x);
  const lines = 2 * Math.ceil((0.8 * size.x) / step);
  const plate = new GridHelper(lines * step, lines, 0xd3d8dc, 0xd3d8dc);
  plate.position.set(centre.x, 0, centre.z);
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
  const edges = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: 0x22282d }));
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
  controls.minDistance = radius;
  controls.maxDistance = radius * 20;
  controls.target.copy(centre);

  const draw = () => renderer.render(scene, camera);

  function resize() {
    const { clientWidth: width, clientHeight: height } = canvas;
    if (!width || !height) return;
    renderer.setPixelRatio(window.devicePixelRatio);
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    draw();
  }

  /** Look at the part from one of VIEWS, from where all of it is seen. */
  function look(name) {
    const half = Math.tan((FIELD_OF_VIEW * Math.PI) / 360) * Math.min(1, camera.aspect);
    const distance = (1.02 * radius) / half;
    camera.position.fromArray(VIEWS[name]).setLength(distance).add(controls.target);
    controls.update();
    draw();
  }

  /** Put part `index` on the plate, in a CSS colour. */
  function show(index, colour) {
    body.geometry.dispose();
    edges.geometry.dispose();
    body.geometry = geometryOf(parts[index]);
    edges.geometry = new EdgesGeometry(body.geometry, EDGE_ANGLE);
    material.color.setStyle(colour);
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
  return { show, look, stand, spacing: step };
}

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
  MeshLambertMaterial,
  PerspectiveCamera,
  Scene,
  Spherical,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

const FIELD_OF_VIEW = 30; // degrees
const EDGE_ANGLE = 25; // degrees between faces from which their edge is drawn
const KEY_STEP = Math.PI / 24;

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
 * triangles' corners, nine numbers a triangle. Returns { show, look, spacing }.
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
  const plate = new GridHelper(lines * step, lines, 0xb8bec4, 0xd9dde1);
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
    camera.position.fromArray(VIEWS[name]).setLength(distance).add(centre);
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
    part.position.y = -body.geometry.boundingBox.min.y;
    draw();
  }

  function turn(event) {
    const [azimuth, polar] =
      { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key] ??
      [];
    if (azimuth === undefined) return;
    event.preventDefault();
    const from = new Spherical().setFromVector3(camera.position.clone().sub(centre));
    from.theta += azimuth * KEY_STEP;
    from.phi += polar * KEY_STEP;
    camera.position.setFromSpherical(from.makeSafe()).add(centre);
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
  return { show, look, spacing: step };
}

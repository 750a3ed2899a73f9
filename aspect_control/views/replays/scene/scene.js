"use strict";
// The scene of a replay: meshcat's viewer shows and moves the robots, this adds what meshcat has no word for.

const data = JSON.parse(document.getElementById("replay-data").textContent);
const view = document.getElementById("view");
const viewer = new MeshCat.Viewer(document.getElementById("meshcat-pane"));
const THREE = MeshCat.THREE;

const CALM = new THREE.Color(0xc9ced6);
const LIMIT = new THREE.Color(0xe69f00);
const BEYOND = new THREE.Color(0x8c0d46);
const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000"];

// Robots of the same make come with one set of meshes, which is handed to each of them.
const handle = viewer.handle_command.bind(viewer);
viewer.handle_command = (command) => {
  handle(command);
  for (const [from, to] of data.copies) {
    if (command.path && command.path.startsWith(from + "/")) {
      handle({ ...command, path: to + command.path.slice(from.length) });
    }
  }
};

async function drawScene() {
  const packed = Uint8Array.from(atob(document.getElementById("replay-commands").textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  let start = 0;
  for (const length of data.lengths) {
    viewer.handle_command_bytearray(bytes.slice(start, start + length));
    start += length;
  }
}

// meshcat 0.3.2 merges the meshes of a Collada file, but leaves the materials of a mesh that has several in a list of
// their own, and three.js draws nothing for a list within a list: the first of them stands for all.
function mendMaterials() {
  viewer.scene.traverse((part) => {
    if (Array.isArray(part.material)) part.material = part.material.map((material) => [material].flat()[0]);
  });
}

function drawGround() {
  viewer.set_property(["Background"], "top_color", [1, 1, 1]);
  viewer.set_property(["Background"], "bottom_color", [0.9, 0.92, 0.95]);
  viewer.set_property(["Axes"], "visible", false);
  viewer.set_property(["Grid"], "visible", false);
  const { low, high } = bounds();
  const cell = 0.25;
  const cells = 2 * Math.ceil((0.75 * low.distanceTo(high)) / cell);
  const floor = new THREE.GridHelper(cells * cell, cells, 0xc3cad4, 0xd7dde5);
  floor.rotateX(Math.PI / 2);
  floor.position.copy(low.add(high).multiplyScalar(0.5).divideScalar(cell).round().multiplyScalar(cell));
  floor.position.z = data.ground - 0.002;
  viewer.set_object(["Floor"], floor);
}

function corners() {
  return data.boxes.flatMap((box) =>
    [...Array(8).keys()].map((corner) => new THREE.Vector3(...[0, 1, 2].map((k) => box[(corner >> k) & 1][k]))));
}

function bounds() {
  const box = new THREE.Box3().setFromPoints(corners());
  return { low: box.min, high: box.max };
}

// Puts the camera as near as all boxes allow, looking at the middle of what it sees.
function frameCamera() {
  const toCamera = new THREE.Vector3(...data.view);
  const right = new THREE.Vector3(0, 0, 1).cross(toCamera).normalize();
  const up = toCamera.clone().cross(right);
  const middle = (axis) => {
    const along = corners().map((corner) => corner.dot(axis));
    return (Math.min(...along) + Math.max(...along)) / 2;
  };
  const target = new THREE.Vector3();
  for (const axis of [toCamera, right, up]) target.addScaledVector(axis, middle(axis));
  viewer.camera.fov = 32;
  const tall = Math.tan((viewer.camera.fov * Math.PI) / 360);
  const wide = tall * viewer.camera.aspect;
  let distance = 0;
  for (const corner of corners()) {
    const arm = corner.sub(target);
    const reach = Math.max(Math.abs(arm.dot(right)) / wide, Math.abs(arm.dot(up)) / tall);
    distance = Math.max(distance, 1.15 * reach + arm.dot(toCamera));
  }
  // meshcat's camera lives in a frame whose y axis points up.
  const upright = (p) => new THREE.Vector3(p.x, p.z, -p.y);
  viewer.camera.far = 20 * distance;
  viewer.camera.position.copy(upright(target.clone().addScaledVector(toCamera, distance)));
  viewer.controls.target.copy(upright(target));
  viewer.controls.update();
  viewer.set_dirty();
}

// From an own colour at a tenth of the limit, by way of LIMIT at the limit, to BEYOND at ten times the limit.
function tint(ratio, own = CALM) {
  const level = Math.min(2, Math.max(0, Math.log10(Math.max(ratio, 1e-9)) + 1));
  return level < 1 ? own.clone().lerp(LIMIT, level) : LIMIT.clone().lerp(BEYOND, level - 1);
}

const scale = { low: 0, high: 0 };
function fitScale(torques) {
  if (scale.high === 0) {
    const mark = Math.max(...data.runs.flatMap((run) => run.marks));
    scale.low = Math.pow(10, Math.floor(Math.log10(mark / 100)));
    scale.high = mark;
  }
  const before = scale.high;
  for (const torque of torques) scale.high = Math.max(scale.high, torque);
  return scale.high !== before;
}
const along = (torque) =>
  (100 * Math.max(0, Math.log10(Math.max(torque, 1e-12) / scale.low))) / Math.log10(scale.high / scale.low);

function element(tag, parent, properties = {}) {
  const made = Object.assign(document.createElement(tag), properties);
  parent.appendChild(made);
  return made;
}

"use strict";
// Draws a replay: meshcat's viewer shows and moves the robots, this adds what meshcat has no word for.

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

class RunView {
  constructor(run, index) {
    this.run = run;
    this.colour = COLOURS[index % COLOURS.length];
    this.path = run.node.split("/").filter((part) => part);
    this.node = viewer.scene_tree.find(this.path).object;
    this.shown = null;
    this.drawPath();
    this.drawCard();
    this.label = element("div", document.getElementById("labels"), { textContent: run.label });
    this.label.style.background = this.colour;
  }

  drawPath() {
    const unlit = (colour) => new THREE.MeshBasicMaterial({ color: colour });
    const radius = 0.006 * data.size;
    this.desired = this.tube(this.run.desired, 0.45 * radius, unlit(0x30363f));
    this.trace = this.tube(this.run.samples.map((sample) => sample.tip), 0.8 * radius, unlit(this.colour));
    this.tip = new THREE.Mesh(new THREE.SphereGeometry(2.2 * radius, 24, 16), unlit(this.colour));
    this.node.add(this.tip);
    this.marks = this.run.changes.map((change) => this.mark(change, radius));
  }

  mark(change, radius) {
    const ring = new THREE.Mesh(
      new THREE.TorusGeometry(4 * radius, 0.8 * radius, 12, 36), new THREE.MeshBasicMaterial({ color: 0xb33b00 }));
    ring.position.set(...change.tip);
    ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...data.view));
    this.node.add(ring);
    return ring;
  }

  // A tube along points, none of which is twice in a row, with the length at every point, so that a part can be shown.
  tube(points, radius, material) {
    const lengths = [0];
    const kept = [];
    points.forEach((point, i) => {
      const step = i > 0 ? Math.hypot(...point.map((x, k) => x - points[i - 1][k])) : 0;
      if (i > 0) lengths.push(lengths[i - 1] + step);
      const last = kept[kept.length - 1];
      if (!last || last.distanceTo(new THREE.Vector3(...point)) > 0.1 * radius) kept.push(new THREE.Vector3(...point));
    });
    if (kept.length < 2) return { show: () => undefined, mesh: null };
    const segments = Math.min(600, 3 * kept.length);
    const mesh = new THREE.Mesh(new THREE.TubeGeometry(new THREE.CatmullRomCurve3(kept), segments, radius, 8), material);
    this.node.add(mesh);
    const total = lengths[lengths.length - 1];
    const show = (i) => mesh.geometry.setDrawRange(0, 6 * 8 * Math.round((segments * lengths[i]) / total));
    return { show, mesh };
  }

  drawCard() {
    const card = element("section", document.getElementById("runs"), { className: "run" });
    const heading = element("h2", card);
    element("i", heading).style.background = this.colour;
    element("span", heading, { textContent: this.run.label });
    this.state = element("p", card);
    const table = element("table", card);
    this.rows = this.run.joints.map((joint, j) => {
      const row = element("tr", table);
      element("td", row, { className: "name", textContent: joint, title: joint });
      const bar = element("div", element("td", row), { className: "bar" });
      bar.title = `black line: ${this.run.limited[j] ? "its limit" : data.compared}, ${this.run.marks[j]} ${this.run.units[j]}`;
      return { bar, fill: element("b", bar), value: element("td", row, { className: "value" }) };
    });
  }

  drawDecades() {
    this.rows.forEach((row, j) => {
      row.bar.querySelectorAll("s, u").forEach((line) => line.remove());
      for (let decade = 10 * scale.low; decade < scale.high; decade *= 10) {
        element("s", row.bar).style.left = along(decade) + "%";
      }
      element("u", row.bar).style.left = `min(calc(100% - 2px), ${along(this.run.marks[j])}%)`;
    });
  }

  joint(joint) {
    return viewer.scene_tree.find([...this.path, "robot", `joint${joint + 1}`]).object;
  }

  links(joint) {
    this.materials = this.materials || new Map();
    if (!this.materials.has(joint)) {
      const found = [];
      this.joint(joint).traverse((part) => {
        if (part.isMesh) found.push(...[part.material].flat());
      });
      this.materials.set(joint, found.map((material) => ({ material, own: material.color.clone().lerp(CALM, 0.5) })));
    }
    return this.materials.get(joint);
  }

  show(time) {
    const samples = this.run.samples;
    if (samples.length === 0) return;
    let i = samples.length - 1;
    while (i > 0 && samples[i].t > time + 1e-9) i--;
    if (this.shown === i) return;
    this.shown = i;
    const sample = samples[i];
    sample.torque.forEach((torque, j) => {
      const ratio = torque / this.run.marks[j];
      const { fill, value } = this.rows[j];
      fill.style.width = along(torque) + "%";
      fill.style.background = "#" + tint(ratio).getHexString();
      value.textContent = `${torque.toLocaleString("en", { maximumSignificantDigits: 3 })} ${this.run.units[j]}`;
      for (const { material, own } of this.links(j)) material.color.copy(tint(ratio, own));
    });
    this.trace.show(i);
    this.tip.position.set(...sample.tip);
    const left = this.run.changes.filter((change) => change.t <= sample.t + 1e-9);
    this.marks.forEach((ring, k) => (ring.visible = k < left.length));
    const over = this.run.end && i === samples.length - 1 && time >= sample.t ? this.run.end : "";
    this.state.className = left.length || over ? "left" : "";
    this.state.textContent = over || this.aspect(left);
    this.state.title = [over, ...left.map((change) => `${change.t.toFixed(3)} s: minor ${change.minor}`)].join("\n");
    this.label.textContent = over ? `${this.run.label}: ended` : this.run.label;
  }

  aspect(left) {
    if (left.length === 0) return "in the aspect of its start";
    const first = `left its aspect at ${left[0].t.toFixed(3)} s`;
    return left.length === 1 ? `${first}: minor ${left[0].minor}` : `${first}, ${left.length} sign changes`;
  }

  // One more reading of a run that is under way, or what is new about it.
  receive(message) {
    if (message.change) {
      this.run.changes.push(message.change);
      this.marks.push(this.mark(message.change, 0.006 * data.size));
    } else if (message.end) {
      this.run.end = message.end;
    } else {
      this.run.samples.push(message);
      message.poses.forEach((pose, j) => {
        const joint = this.joint(j);
        joint.position.fromArray(pose);
        joint.quaternion.fromArray(pose, 3);
      });
      if (this.run.samples.length % 3 === 0) this.retrace();
    }
    this.shown = null;
  }

  restart() {
    this.run.samples.length = 0;
    this.run.end = null;
    this.shown = null;
    this.retrace();
  }

  retrace() {
    if (this.trace.mesh) {
      this.node.remove(this.trace.mesh);
      this.trace.mesh.geometry.dispose();
    }
    const tips = this.run.samples.slice(-900).map((sample) => sample.tip);
    this.trace = { ...this.tube(tips, 0.0048 * data.size, this.tip.material), show: () => undefined };
  }

  placeLabel() {
    const anchor = this.node.localToWorld(new THREE.Vector3(...data.anchor)).project(viewer.camera);
    this.label.style.left = `${(50 * (1 + anchor.x)).toFixed(2)}%`;
    this.label.style.top = `${(50 * (1 - anchor.y)).toFixed(2)}%`;
  }
}

function controls(animator) {
  const bar = document.getElementById("controls");
  const button = element("button", bar, { type: "button" });
  const slider = element("input", bar, { type: "range", min: 0, max: data.end, step: 0.001, title: "time" });
  const clock = element("output", bar);
  const speed = element("select", bar, { title: "seconds of motion shown in a second" });
  for (const factor of [...new Set([data.speed, 0.05, 0.1, 0.25, 0.5, 1, 2])].sort((a, b) => a - b)) {
    element("option", speed, { value: factor, textContent: `${factor} ×`, selected: factor === data.speed });
  }
  speed.onchange = () => (animator.mixer.timeScale = Number(speed.value));
  button.onclick = () => (animator.playing ? animator.pause() : animator.play());
  slider.oninput = () => {
    animator.pause();
    seek(Number(slider.value));
  };
  return (time) => {
    button.textContent = animator.playing ? "Pause" : "Play";
    slider.value = Math.min(time, data.end);
    clock.textContent = `t = ${Math.min(time, data.end).toFixed(3)} s`;
  };
}

// Follows runs that are under way: the server sends readings, nothing is sent back.
function listen(views) {
  const bar = document.getElementById("controls");
  const clock = element("output", bar);
  const state = element("span", bar, { textContent: "live" });
  const stream = new WebSocket(`ws://${location.host}/stream`);
  stream.onmessage = (event) => {
    const message = JSON.parse(event.data);
    if (message.restart) views.forEach((each) => each.restart());
    else views[message.run].receive(message);
    if (message.torque && fitScale(message.torque)) views.forEach((each) => each.drawDecades());
    viewer.set_dirty();
  };
  stream.onclose = () => (state.textContent = "the end: the server has stopped");
  return () => {
    const latest = Math.max(0, ...views.map((each) => each.run.samples.at(-1)?.t ?? 0));
    clock.textContent = `t = ${latest.toFixed(3)} s`;
  };
}

// Shows the scene at a time, in seconds, without playing on.
function seek(time) {
  viewer.animator.time = time;
  viewer.animator.seek(time);
}

function legend() {
  const text = document.getElementById("legend");
  const limited = data.runs.some((run) => run.limited.includes(true));
  const colours = element("span", text, { textContent: "torque 0.1 ×" });
  const ramp = [0.1, 0.3, 1, 3, 10].map((ratio) => "#" + tint(ratio).getHexString());
  element("em", colours).style.background = `linear-gradient(90deg, ${ramp.join(",")})`;
  colours.append(`10 × ${limited ? "its limit" : data.compared} (black line)`);
  element("span", text, { textContent: "bars logarithmic, a white line a decade" });
  element("span", text, { textContent: "dark line: desired path" });
  element("span", text, { textContent: "ring: a minor changes sign" });
}

async function main() {
  drawGround();
  await drawScene();
  mendMaterials();
  const views = data.runs.map((run, index) => new RunView(run, index));
  fitScale(data.runs.flatMap((run) => run.samples.flatMap((sample) => sample.torque)));
  views.forEach((each) => each.drawDecades());
  legend();
  const size = viewer.set_3d_pane_size.bind(viewer);
  viewer.set_3d_pane_size = () => {
    size(view.clientWidth, view.clientHeight);
    frameCamera();
    viewer.render();
  };
  view.appendChild(document.getElementById("labels"));
  const showTime = data.live ? listen(views) : controls(viewer.animator);
  viewer.gui.close();
  viewer.set_3d_pane_size();
  if (!data.live) {
    viewer.animator.mixer.timeScale = data.speed;
    viewer.animator.play();
  }
  const update = () => {
    const time = data.live ? Infinity : viewer.animator.time;
    showTime(time);
    views.forEach((each) => {
      each.show(time);
      each.placeLabel();
    });
  };
  const render = viewer.render.bind(viewer);
  viewer.render = () => {
    update();
    render();
  };
  new ResizeObserver(() => viewer.set_3d_pane_size()).observe(view);
  viewer.set_dirty();
  document.body.dataset.ready = "true";
}

main();

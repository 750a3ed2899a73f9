"use strict";
// What is shown of one run: path, trace, torques, changes of the aspect. Uses scene.js.

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

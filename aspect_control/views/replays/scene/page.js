"use strict";
// Time, live or not, and everything put together. Uses scene.js and run_view.js.

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

"use strict";
// One picture of each kind is fetched at a time, the next when it is there: a slow network shows
// fewer pictures and keeps nobody waiting.

const id = (name) => document.getElementById(name);
const pause = (ms) => new Promise((done) => setTimeout(done, ms));
let facts = {};

/** Fetches a picture again and again onto its canvas. */
async function show(name) {
  const canvas = id(name);
  let number = "";
  for (;;) {
    if (document.hidden || id(name + "-part").hidden) {
      await pause(300);
      continue;
    }
    try {
      const answer = await fetch(`/${name}.jpg?after=${number}`);
      if (answer.status !== 200) {
        await pause(answer.status === 204 ? 100 : 1000);
        continue;
      }
      const picture = await createImageBitmap(await answer.blob());
      number = answer.headers.get("x-number");
      if (canvas.width !== picture.width || canvas.height !== picture.height) {
        canvas.width = picture.width;
        canvas.height = picture.height;
      }
      canvas.getContext("2d").drawImage(picture, 0, 0);
      picture.close();
      canvas.dataset.number = number;
      drawCoverage(name, canvas);
    } catch {
      await pause(1000);
    }
  }
}

/** Where the board has been, over an eye. */
function drawCoverage(name, canvas) {
  const cells = facts.coverage && facts.coverage[name];
  if (!cells) return;
  const side = facts.coverage.side;
  const pen = canvas.getContext("2d");
  const [w, h] = [canvas.width / side, canvas.height / side];
  pen.fillStyle = "rgba(0, 158, 115, 0.35)";
  cells.forEach((seen, i) => {
    if (seen) pen.fillRect((i % side) * w, Math.floor(i / side) * h, w - 1, h - 1);
  });
}

/** Position in the picture under a pointer; a pixel's centre is an integer. */
function place(canvas, event) {
  const box = canvas.getBoundingClientRect();
  const x = ((event.clientX - box.left) / box.width) * canvas.width - 0.5;
  const y = ((event.clientY - box.top) / box.height) * canvas.height - 0.5;
  return [x.toFixed(2), y.toFixed(2)];
}

async function direction(eye, [x, y]) {
  const of = eye ? `eye=${eye}&` : "";
  const answer = await fetch(`/direction.json?${of}x=${x}&y=${y}`);
  if (!answer.ok) return null;
  return answer.json();
}

function words(eye, [x, y], found) {
  const of = eye ? `${eye} ` : "";
  if (!found) return `${of}${x},${y}: no direction`;
  const [yaw, pitch] = [found.yaw_deg, found.pitch_deg].map((deg) => deg.toFixed(3));
  return `${of}${x},${y}: yaw ${yaw}° pitch ${pitch}° (${found.eye || "none"})`;
}

/** Reads directions under the pointer, only ever the newest place asked for. */
function follow(name, eye) {
  const canvas = id(name);
  let wanted = null;
  let busy = false;
  const ask = async (event) => {
    wanted = place(canvas, event);
    if (busy) return;
    busy = true;
    while (wanted) {
      const at = wanted;
      wanted = null;
      try {
        id("readout").textContent = words(eye, at, await direction(eye, at));
      } catch {
        id("readout").textContent = "no connection";
      }
    }
    busy = false;
  };
  canvas.addEventListener("pointermove", ask);
  canvas.addEventListener("pointerdown", async (event) => {
    ask(event);
    const at = place(canvas, event);
    const found = await direction(eye, at).catch(() => null);
    id("held").textContent = "target " + words(eye, at, found);
    if (!eye) mark(at);
  });
}

function mark([x, y]) {
  const canvas = id("stitched");
  const target = id("target");
  target.style.left = `${((Number(x) + 0.5) / canvas.width) * 100}%`;
  target.style.top = `${((Number(y) + 0.5) / canvas.height) * 100}%`;
  target.hidden = false;
}

function row(name, value) {
  const line = document.createElement("tr");
  for (const text of [name, value]) {
    const cell = document.createElement("td");
    cell.textContent = text;
    line.append(cell);
  }
  return line;
}

function eyeState(name) {
  const eye = facts[name];
  id(name + "-part").hidden = !eye;
  if (!eye) return;
  const state = id(name + "-state");
  state.classList.toggle("bad", !eye.connected);
  state.textContent = eye.connected
    ? `${eye.source}: ${eye.dropped} dropped, ${eye.corrupt} damaged, ${eye.reconnects} times back`
    : `${eye.source}: not there, waiting for it`;
}

async function watch() {
  for (;;) {
    try {
      facts = await (await fetch("/status.json")).json();
      id("state").textContent = facts.state || "waiting for frames";
      id("state").classList.remove("bad");
      id("stitched-part").hidden = !facts.stitched;
      id("scales").hidden = !facts.stitched || !id("with-scales").checked;
      if (facts.stitched && !id("scales").src) id("scales").src = "/scales.png";
      eyeState("left");
      eyeState("right");
      const figures = Object.entries(facts.figures || {});
      id("figures").replaceChildren(...figures.map(([name, value]) => row(name, value)));
    } catch {
      id("state").textContent = "no connection";
      id("state").classList.add("bad");
    }
    await pause(500);
  }
}

id("with-scales").addEventListener("change", (event) => {
  id("scales").hidden = !event.target.checked;
});
follow("stitched", null);
follow("left", "left");
follow("right", "right");
show("stitched");
show("left");
show("right");
watch();

"use strict";
// Directions under the pointer, and a list of named targets that are marked in all pictures.

const KEPT = "tectum-targets";
let targets = [];

/** Position in the picture under a pointer; a pixel's centre is an integer. */
function place(canvas, event) {
  const box = canvas.getBoundingClientRect();
  const x = ((event.clientX - box.left) / box.width) * canvas.dataset.width - 0.5;
  const y = ((event.clientY - box.top) / box.height) * canvas.dataset.height - 0.5;
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
  return `${of}${x},${y}: ${yawText(found.yaw_deg, 3)}, ${pitchText(found.pitch_deg, 3)}, shown by ${found.eye || "none"}`;
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
  // A click, not a press: a finger that begins to scroll adds no target.
  canvas.addEventListener("click", async (event) => {
    ask(event);
    const found = await direction(eye, place(canvas, event)).catch(() => null);
    if (!found) return;
    const number = targets.reduce((most, target) => Math.max(most, target.number), 0) + 1;
    targets.push({ number, name: `target ${number}`, time: new Date().toISOString(), found });
    keepTargets();
  });
}

/** Marks on a picture, by share of its width and height. */
function markOn(name, pick) {
  const canvas = id(name);
  const figure = canvas.parentElement;
  figure.querySelectorAll(".target").forEach((mark) => mark.remove());
  const box = figure.getBoundingClientRect();
  const on = canvas.getBoundingClientRect();
  if (!canvas.dataset.width || !on.width) return;
  for (const target of targets) {
    const at = pick(target.found);
    if (!at) continue;
    const mark = document.createElement("div");
    mark.className = "target";
    mark.dataset.number = target.number;
    const x = ((at.x + 0.5) / canvas.dataset.width) * on.width + on.left - box.left;
    const y = ((at.y + 0.5) / canvas.dataset.height) * on.height + on.top - box.top;
    mark.style.left = `${x}px`;
    mark.style.top = `${y}px`;
    figure.append(mark);
  }
}

function markTargets() {
  markOn("stitched", (found) => (found.x === null ? null : found));
  for (const name of SIDES) markOn(name, (found) => found[name]);
}

function keepTargets() {
  try {
    localStorage.setItem(KEPT, JSON.stringify(targets));
  } catch {
    // A browser that keeps nothing shows them all the same.
  }
  listTargets();
}

function listTargets() {
  id("targets-part").hidden = targets.length === 0;
  const rows = targets.map((target) => {
    const row = document.createElement("tr");
    const cell = (...content) => {
      const cell = document.createElement("td");
      cell.append(...content);
      row.append(cell);
    };
    const name = document.createElement("input");
    name.value = target.name;
    name.maxLength = 80;
    name.ariaLabel = `name of target ${target.number}`;
    name.addEventListener("change", () => {
      target.name = name.value;
      keepTargets();
    });
    const remove = document.createElement("button");
    remove.textContent = "×";
    remove.ariaLabel = `remove target ${target.number}`;
    remove.addEventListener("click", () => {
      targets = targets.filter((other) => other !== target);
      keepTargets();
    });
    cell(String(target.number));
    cell(name);
    cell(yawText(target.found.yaw_deg, 2));
    cell(pitchText(target.found.pitch_deg, 2));
    cell(remove);
    return row;
  });
  id("targets").replaceChildren(...rows);
  const quoted = (text) => `"${text.replaceAll('"', '""')}"`;
  const lines = targets.map(({ number, name, time, found }) =>
    [number, quoted(name), time, found.yaw_deg, found.pitch_deg].join(","));
  const csv = ["number,name,time_utc,yaw_deg,pitch_deg", ...lines, ""].join("\n");
  URL.revokeObjectURL(id("targets-csv").href);
  id("targets-csv").href = URL.createObjectURL(new Blob([csv], { type: "text/csv" }));
  markTargets();
}

/** Whether something that was kept can be listed and marked. */
function isTarget(kept) {
  const numbers = [kept?.number, kept?.found?.yaw_deg, kept?.found?.pitch_deg];
  return numbers.every(Number.isFinite) && typeof kept.name === "string";
}

try {
  const kept = JSON.parse(localStorage.getItem(KEPT));
  if (Array.isArray(kept)) targets = kept.filter(isTarget);
} catch {
  // Nothing that can be read is kept.
}

"use strict";
// What the operator can do: with the token, change things; without, choose how things look.

const TOKEN = "tectum-token";

/** The token comes behind the address's #, which browsers send to nobody, and leaves it at once. */
function takeToken() {
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (!token) return;
  sessionStorage.setItem(TOKEN, token);
  history.replaceState(null, "", location.pathname);
}

function tokenHeader() {
  const token = sessionStorage.getItem(TOKEN);
  return token ? { "x-tectum-token": token } : {};
}

/** Asks for a change and says what became of it. */
async function change(path) {
  const outcome = id("outcome");
  outcome.textContent = "…";
  let good = false;
  let words = "no connection; nothing is known to have been done";
  try {
    const answer = await fetch(path, { method: "POST", headers: tokenHeader() });
    good = answer.ok;
    words = (await answer.text()).trim();
  } catch {
    // Said already.
  }
  outcome.textContent = words;
  outcome.className = good ? "good" : "bad";
}

function showOperator() {
  const operator = facts.operator;
  id("operator").hidden = !facts.may_change || !(operator || facts.controls);
  id("controls").hidden = !facts.controls;
  id("controls-text").textContent = facts.controls || "";
  if (!operator) return;
  const recording = operator.recording;
  const record = id("record");
  record.hidden = operator.records_itself;
  record.setAttribute("aria-pressed", String(Boolean(recording)));
  record.textContent = recording ? `Stop recording (${recording.frames})` : "Record";
  if (operator.free_mb !== null) {
    const free = operator.free_mb >= 1024 ? `${(operator.free_mb / 1024).toFixed(1)} GB` : `${operator.free_mb} MB`;
    id("figures").append(figure("free disk", operator.folder ? `${free} (${operator.folder})` : free));
  }
}

function operatorAlarms(alarms) {
  const operator = facts.operator;
  if (!operator) return;
  if (operator.failure) alarms.push(operator.failure);
  if (operator.free_mb !== null && operator.free_mb < 2 * operator.needed_mb) {
    alarms.push(`The disk is nearly full: ${operator.free_mb} MB are free.`);
  }
}

/** Scales for the size at which the picture is shown, so that they are sharp there. */
function fitScales() {
  const canvas = id("stitched");
  const scales = id("scales");
  const width = Math.round(canvas.getBoundingClientRect().width / 8) * 8;
  scales.hidden = !id("with-scales").checked || width === 0;
  scales.style.opacity = id("opacity").value / 100;
  const src = `/scales.svg?width=${width}&step=${id("step").value}`;
  if (!scales.hidden && !scales.src.endsWith(src)) scales.src = src;
  const inside = id("stitched-figure").getBoundingClientRect();
  const box = canvas.getBoundingClientRect();
  scales.style.left = `${box.left - inside.left}px`;
  scales.style.top = `${box.top - inside.top}px`;
  scales.style.width = `${box.width}px`;
  scales.style.height = `${box.height}px`;
}

/** A choice that this browser keeps. */
function remembered(name, apply) {
  const choice = id(name);
  try {
    const kept = localStorage.getItem("tectum-" + name);
    if (kept !== null) choice.value = kept;
  } catch {
    // A browser that keeps nothing.
  }
  choice.addEventListener("input", () => {
    try {
      localStorage.setItem("tectum-" + name, choice.value);
    } catch {
      // Likewise.
    }
    apply();
  });
  apply();
}

/** One picture as large as the screen: by the browser where it can, else by the page alone. */
async function enlarge(button) {
  const view = id(button.dataset.of);
  const large = view.classList.toggle("large");
  try {
    if (large) await view.requestFullscreen?.();
    else if (document.fullscreenElement) await document.exitFullscreen();
  } catch {
    // Large inside the window, then.
  }
  fitLarge();
}

/** Keeps a large picture's shape inside the screen. */
function fitLarge() {
  for (const view of document.querySelectorAll(".view")) {
    const canvas = view.querySelector("canvas");
    const large = view.classList.contains("large");
    const scale = Math.min(view.clientWidth / canvas.width, view.clientHeight / canvas.height);
    canvas.style.width = large ? `${Math.floor(canvas.width * scale)}px` : "";
    canvas.style.height = large ? `${Math.floor(canvas.height * scale)}px` : "";
  }
  fitScales();
  markTargets();
}

takeToken();
id("snapshot").addEventListener("click", () => change("/snapshot"));
id("record").addEventListener("click", () => change(`/record?on=${facts.operator?.recording ? 0 : 1}`));
id("mark").addEventListener("click", () => change(`/mark?name=${encodeURIComponent(id("mark-name").value)}`));
id("set-exposure").addEventListener("click", () => change(`/exposure?value=${id("exposure").value}`));
id("lock").addEventListener("click", () => change("/lock"));
document.querySelectorAll(".full").forEach((button) => button.addEventListener("click", () => enlarge(button)));
document.addEventListener("fullscreenchange", () => {
  if (document.fullscreenElement) return fitLarge();
  document.querySelectorAll(".large").forEach((view) => view.classList.remove("large"));
  fitLarge();
});
id("with-scales").addEventListener("change", fitScales);
remembered("quality", () => {});
remembered("step", fitScales);
remembered("opacity", fitScales);
remembered("theme", () => (document.documentElement.dataset.theme = id("theme").value));
const sizes = new ResizeObserver(fitLarge);
for (const name of ["stitched", ...SIDES]) {
  sizes.observe(id(name));
  follow(name, name === "stitched" ? null : name);
  show(name);
}
listTargets();
watch();
setInterval(render, 250);

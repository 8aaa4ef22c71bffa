"use strict";
// Pictures and status. One picture of each kind is fetched at a time, the next when it is there: a
// slow network shows fewer pictures and keeps nobody waiting.

const id = (name) => document.getElementById(name);
const pause = (ms) => new Promise((done) => setTimeout(done, ms));
const SIDES = ["left", "right"];
/** Without an answer for this long, ms, what is on the screen is not live. */
const SILENCE_MS = 2000;
/** So long losses stay an alarm, ms. */
const RECENT_MS = 6000;

let facts = {};
let answered = performance.now();
const losses = {};

/** Fetches a picture again and again onto its canvas. */
async function show(name) {
  const canvas = id(name);
  let number = "";
  let quality = "";
  for (;;) {
    if (document.hidden || id(name + "-part").hidden) {
      await pause(300);
      continue;
    }
    if (quality !== id("quality").value) number = "";
    quality = id("quality").value;
    try {
      const patience = AbortSignal.timeout(8000);
      const answer = await fetch(`/${name}.jpg?after=${number}&quality=${quality}`, { signal: patience });
      if (answer.status !== 200) {
        await pause(answer.status === 204 ? 100 : 500);
        continue;
      }
      const picture = await createImageBitmap(await answer.blob());
      number = answer.headers.get("x-number");
      if (canvas.width !== picture.width || canvas.height !== picture.height) {
        canvas.width = picture.width;
        canvas.height = picture.height;
      }
      canvas.getContext("2d").drawImage(picture, 0, 0, canvas.width, canvas.height);
      picture.close();
      // What is sent may be smaller than what it shows.
      canvas.dataset.width = answer.headers.get("x-width");
      canvas.dataset.height = answer.headers.get("x-height");
      canvas.dataset.number = number;
      drawSession(name, canvas);
    } catch {
      await pause(1000);
    }
  }
}

/** Over an eye: where the board has been, where it is wanted, and the corners that are found. */
function drawSession(name, canvas) {
  const session = facts.session && facts.session[name];
  if (!session) return;
  const side = facts.session.side;
  const pen = canvas.getContext("2d");
  const [w, h] = [canvas.width / side, canvas.height / side];
  const cell = (i) => [(i % side) * w, Math.floor(i / side) * h];
  pen.fillStyle = "rgba(0, 158, 115, 0.35)";
  session.covered.forEach((seen, i) => seen && pen.fillRect(...cell(i), w - 1, h - 1));
  pen.strokeStyle = "#ffc145";
  pen.lineWidth = Math.max(2, canvas.width / 250);
  for (const i of session.wanted) {
    const [x, y] = cell(i);
    pen.strokeRect(x + 2, y + 2, w - 5, h - 5);
  }
  const scale = canvas.width / Number(canvas.dataset.width);
  pen.fillStyle = "#ff3df2";
  const radius = Math.max(2, canvas.width / 160);
  for (const [x, y] of session.corners || []) {
    pen.beginPath();
    pen.arc((x + 0.5) * scale, (y + 0.5) * scale, radius, 0, 7);
    pen.fill();
  }
}

/** Covers a picture that does not show how things are now; nothing to say uncovers it. */
function veil(figure, words, ended) {
  const cover = figure.querySelector(".veil");
  cover.hidden = !words;
  cover.textContent = words || "";
  figure.classList.toggle("stale", Boolean(words) && !ended);
  figure.classList.toggle("ended", Boolean(words) && ended);
}

/** Frames lost or damaged lately; counts what each status adds. */
function recentLosses(name) {
  const eye = facts[name];
  const memory = (losses[name] ??= { total: null, events: [] });
  const total = eye ? eye.dropped + eye.corrupt : 0;
  const now = performance.now();
  if (memory.total !== null && total > memory.total) memory.events.push([now, total - memory.total]);
  memory.total = total;
  memory.events = memory.events.filter(([time]) => now - time < RECENT_MS);
  return memory.events.reduce((sum, [, count]) => sum + count, 0);
}

function eyeState(name, alarms) {
  const eye = facts[name];
  id(name + "-part").hidden = !eye;
  if (!eye) return null;
  const state = id(name + "-state");
  const recent = recentLosses(name);
  const all = `${eye.source}: ${eye.dropped} dropped, ${eye.corrupt} damaged, ${eye.reconnects} times back`;
  state.classList.toggle("bad", !eye.connected || recent > 0);
  state.textContent = eye.connected ? all : `${eye.source}: not there, waiting for it`;
  if (!eye.connected) alarms.push(`The ${name} eye is lost.`);
  else if (recent > 0) alarms.push(`The ${name} eye loses frames: ${recent} in the last seconds.`);
  return eye.connected ? null : `${name.toUpperCase()} EYE LOST`;
}

/** Everything on the page that tells how things are. */
function render() {
  const silence = performance.now() - answered;
  const alarms = [];
  const lost = SIDES.map((name) => eyeState(name, alarms));
  let words = null;
  if (silence > SILENCE_MS) words = `NO CONNECTION for ${Math.round(silence / 1000)} s`;
  else if (facts.stalled) words = `NO NEW PICTURES for ${Math.round(facts.frame_age_ms / 1000)} s`;
  if (words) alarms.unshift(words + ". What you see is not live.");
  operatorAlarms(alarms);
  const ended = !words && facts.ended ? "end of the recording" : null;
  SIDES.forEach((name, i) => veil(id(name + "-part"), lost[i] || words || ended, !lost[i] && !words));
  veil(id("stitched-figure"), words || ended, !words);
  id("alarm").hidden = alarms.length === 0;
  const text = alarms.join(" ");
  if (id("alarm").textContent !== text) id("alarm").textContent = text;
  // A session's own lines say the rest, but not that there are no more frames.
  const state = facts.session && !facts.ended ? (facts.figures || {})["frame rate"] : facts.state;
  id("state").textContent = words ? "not live" : state || "waiting for frames";
  id("state").classList.toggle("bad", Boolean(words));
}

function figure(name, value) {
  const line = document.createElement("tr");
  for (const text of [name, value]) {
    const cell = document.createElement("td");
    cell.textContent = text;
    line.append(cell);
  }
  return line;
}

/** A signed angle with the side that its sign means. */
function angle(deg, digits, positive, negative) {
  const text = deg.toFixed(digits);
  const side = Number(text) === 0 ? "" : deg > 0 ? ` (${positive})` : ` (${negative})`;
  return `${text}°${side}`;
}

const yawText = (deg, digits) => "yaw " + angle(deg, digits, "left", "right");
const pitchText = (deg, digits) => "pitch " + angle(deg, digits, "down", "up");

async function watch() {
  for (;;) {
    try {
      const patience = AbortSignal.timeout(4000);
      const answer = await fetch("/status.json", { headers: tokenHeader(), signal: patience });
      facts = await answer.json();
      answered = performance.now();
      id("stitched-part").hidden = !facts.stitched;
      const turn = facts.attitude;
      id("attitude").hidden = !turn;
      if (turn && turn.yaw_deg === undefined) {
        id("attitude").textContent = "body: the attitude of this moment is not known";
      } else if (turn) {
        const roll = angle(turn.roll_deg, 1, "right side down", "left side down");
        id("attitude").textContent = `body: ${yawText(turn.yaw_deg, 1)}, ${pitchText(turn.pitch_deg, 1)}, roll ${roll}`;
      }
      id("session").hidden = !facts.session;
      document.body.classList.toggle("calibrating", Boolean(facts.session));
      if (facts.session) {
        id("instruction").textContent = facts.session.instruction;
        id("kept").textContent = facts.session.kept;
      }
      const figures = Object.entries(facts.figures || {});
      id("figures").replaceChildren(...figures.map(([name, value]) => figure(name, value)));
      showOperator();
    } catch {
      // Said by the page when it lasts.
    }
    await pause(500);
  }
}

// Orders to the boat. Each goes to the console's server, which sends it as MAVLink; the boat decides.
import { bearing, deg, html, length, rad, say, set, svg } from "./draw.js";
import { onDpClick, setGhost } from "./dp.js";
import { onChartClick, onStationDragged, setChartGhost } from "./chart.js";
import { config, model, parameters, row, toGeodetic } from "./model.js";

const panel = document.getElementById("orders");
const said = html("p", { id: "said", role: "status" });
const TRIMS = [["DP_BW_SURGE", "Bandwidth surge", "rad/s"], ["DP_BW_SWAY", "Bandwidth sway", "rad/s"], ["DP_BW_YAW", "Bandwidth yaw", "rad/s"], ["WP_SPEED", "Mission speed", "m/s"]];
const ANSWER_MS = 20000;
const STEPS = [0.1, 0.5, 1, 2];
let made = false, known = null, picking = false, ghost = null, station = null, dialled = null, step = 0.5;
const element = {};

/** Send an order; shows the boat's answer. */
export async function order(what, label) {
  say(said, `${label}…`);
  said.className = "";
  const { beat } = model, at_s = beat ? beat.at_s + (performance.now() - beat.got_ms) / 1000 : undefined;
  try {
    const answer = await fetch("/api/order", {
      method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ ...what, at_s }), signal: AbortSignal.timeout(ANSWER_MS),
    });
    const { done, text } = await answer.json();
    said.className = done ? "good" : "bad";
    say(said, done ? `${label}: done` : `${label}: ${text}`);
    return done;
  } catch (error) {
    said.className = "bad";
    say(said, `${label}: the console does not answer`);
    return false;
  }
}

const button = (label, act, more = {}) => html("button", { onclick: act, ...more }, label);

function card(title, ...content) {
  return html("section", { class: "card" }, html("h2", {}, title), ...content);
}

function make() {
  made = true;
  element.arm = button("Arm", () => order({ order: "arm" }, "Arm"), { id: "o-arm" });
  element.disarm = button("Disarm", () => order({ order: "disarm" }, "Disarm"), { id: "o-disarm", class: "grave" });
  element.modes = html("div", { id: "modes" });
  element.go = button("Go", go, { id: "o-go", disabled: true });
  element.pick = button("Pick a point", togglePick, { id: "o-pick" });
  element.goText = html("p", { class: "small" }, "Pick, then click the picture or the chart. The outline shows the heading of the dial.");
  element.station = button("Send follow position", sendStation, { id: "o-station", disabled: true });
  element.stationText = html("p", { class: "small" }, "Drag the mark of the follow position on the chart while a leader is heard.");
  element.accept = button("Accept", () => order({ order: "trial_accept" }, "Accept the model"), { id: "o-trial-accept", disabled: true });
  element.undo = button("Undo", () => order({ order: "trial_undo" }, "Undo the model"), { id: "o-trial-undo", disabled: true });
  element.restart = button("Reboot", () => order({ order: "restart" }, "Reboot"), { id: "o-restart" });
  element.trialText = html("p", { class: "small", id: "trial-text" }, "");
  element.take = button("Take control", () => order({ order: "take_control" }, "Operator control"));
  element.release = button("Release", () => order({ order: "release_control" }, "Release control"));
  panel.replaceChildren(
    html("section", { class: "card" }, html("div", { class: "row" }, element.arm, element.disarm, button("Hold here", () => order({ order: "hold" }, "Hold here"), { id: "o-hold" })), said),
    card("Mode", element.modes),
    card("Nudge the held point, along the held heading", pad()),
    card("Heading to hold", dial(), html("div", { class: "row" }, button("Turn to it", turn, { id: "o-heading" }))),
    card("Go to a point, and hold there", html("div", { class: "row" }, element.pick, element.go), element.goText),
    card("Mission", html("div", { class: "row" }, button("Start", () => order({ order: "mission_start" }, "Mission")), button("Pause", () => order({ order: "hold" }, "Pause")), button("Continue", () => order({ order: "continue" }, "Continue")), button("Dock", () => order({ order: "mode", mode: "Dock" }, "Dock")))),
    card("Follow", html("div", { class: "row" }, button("Follow", () => order({ order: "mode", mode: "Follow" }, "Follow")), element.station), element.stationText),
    card("Sea trial", html("div", { class: "row" }, element.accept, element.undo, element.restart), element.trialText),
    card("Trim", ...TRIMS.map(trim)),
    card("Operator control", html("div", { class: "row" }, element.take, element.release)),
  );
  onDpClick((n, e) => pick(n, e));
  onChartClick((n, e) => pick(n, e));
  onStationDragged((turned, far) => {
    station = [turned, far];
    element.station.disabled = false;
    say(element.stationText, `Follow position: ${length(far)} from the leader, bearing ${bearing(turned, 0)} from its bow.`);
  });
}

function pad() {
  const size = html("select", { "aria-label": "Step", onchange: (event) => { step = Number(event.target.value); } }, ...STEPS.map((s) => html("option", { value: s, selected: s === step }, `${s} m`)));
  const arrow = (label, name, ahead, starboard, turn_deg) => button(label, () => nudge(ahead * step, starboard * step, turn_deg), { "aria-label": name, title: name });
  return html("div", { id: "pad" },
    arrow("↶ 5°", "Turn to port", 0, 0, -5), arrow("↑", "Ahead", 1, 0, 0), arrow("5° ↷", "Turn to starboard", 0, 0, 5),
    arrow("←", "To port", 0, -1, 0), size, arrow("→", "To starboard", 0, 1, 0),
    html("span"), arrow("↓", "Astern", -1, 0, 0), html("span"));
}

export const nudge = (ahead_m, starboard_m, turn_deg) => order({ order: "nudge", ahead_m, starboard_m, turn_deg }, "Nudge");
export const nudgeStep = () => step;

function dial() {
  const drawing = svg("svg", { id: "dial", viewBox: "-75 -75 150 150", tabindex: 0, role: "slider", "aria-label": "Heading", "aria-valuemin": 0, "aria-valuemax": 359 });
  svg("circle", { class: "ring", r: 58 }, drawing);
  for (let d = 0; d < 360; d += 30) {
    const g = svg("g", { transform: `rotate(${d})` }, drawing);
    svg("line", { class: "ring", y1: -58, y2: -52 }, g);
    if (d % 90 === 0) svg("text", { "text-anchor": "middle", y: 4, class: "faint", transform: `translate(0 -66) rotate(${-d})` }, g, "NESW"[d / 90]);
  }
  element.present = svg("polygon", { class: "hull", points: "0,-50 5,-38 -5,-38" }, drawing);
  element.needle = svg("polygon", { class: "ghost", points: "0,-56 9,-30 0,-36 -9,-30" }, drawing);
  element.dialText = svg("text", { id: "dial-text", "text-anchor": "middle", y: 6 }, drawing, "–");
  element.dial = drawing;
  const turnTo = (event) => {
    const box = drawing.getBoundingClientRect();
    dialTo(deg(Math.atan2(event.clientX - box.left - box.width / 2, -(event.clientY - box.top - box.height / 2))));
  };
  drawing.addEventListener("pointerdown", (event) => { drawing.setPointerCapture(event.pointerId); turnTo(event); });
  drawing.addEventListener("pointermove", (event) => { if (event.buttons) turnTo(event); });
  drawing.addEventListener("keydown", (event) => {
    const by = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    if (by) { event.preventDefault(); event.stopPropagation(); dialTo((dialled ?? deg(row().yaw_rad)) + by); }
  });
  return drawing;
}

function dialTo(degrees) {
  dialled = Math.round(((degrees % 360) + 360) % 360) % 360;
  if (ghost) pick(ghost[0], ghost[1], true);
  draw();
}

const turn = () => order({ order: "heading", heading_deg: dialled ?? deg(row().yaw_rad) }, `Heading ${dialled ?? Math.round(deg(row().yaw_rad))}°`);

function togglePick() {
  picking = !picking;
  element.pick.classList.toggle("on", picking);
  if (!picking) clearGhost();
}

function clearGhost() {
  ghost = null;
  setGhost(null);
  setChartGhost(null);
  element.go.disabled = true;
}

function pick(north, east, again = false) {
  if (!picking && !again) return;
  ghost = [north, east, dialled === null ? row().yaw_rad : rad(dialled)];
  setGhost(ghost);
  setChartGhost(ghost);
  element.go.disabled = false;
  const away = Math.hypot(north - row().north_m, east - row().east_m);
  say(element.goText, `${length(away)} away, heading ${bearing(ghost[2], 0)}.`);
}

async function go() {
  const [lat_deg, lon_deg] = toGeodetic(ghost[0], ghost[1]);
  const heading_deg = config().limits.sway_n > 0 ? deg(ghost[2]) : null;
  if (await order({ order: "go_to", lat_deg, lon_deg, heading_deg }, "Go to")) togglePick();
}

function sendStation() {
  order({ order: "station", bearing_deg: deg(station[0]), distance_m: station[1] }, "Follow position");
}

function trim([name, label, unit]) {
  const field = html("input", { type: "number", step: 0.01, "aria-label": `${label}, ${unit}`, "data-trim": name });
  const send = button("Set", () => order({ order: "trim", name, value: Number(field.value) }, label));
  element[name] = field;
  return html("div", { class: "trim" }, html("span", { class: "small" }, `${label}, ${unit}`), field, send);
}

function trialWords({ identifying, proposal, in_force }) {
  if (identifying) return "The boat identifies its model from the log.";
  const counts = `From the next start on: ${in_force ?? "the vessel's file alone"}.`;
  return proposal ? `${proposal} waits to be accepted. ${counts} Accept disarmed or in Hold, then reboot disarmed.` : `No result waits: mode Trial sails one. ${counts}`;
}

/** A boat that has begun anew may count its metres from elsewhere: what was picked before would lie at another place. */
function meet() {
  known = model.hello;
  if (picking) togglePick();
  clearGhost();
  station = null;
  element.station.disabled = true;
  element.modes.replaceChildren();
}

export function draw() {
  if (!model.hello?.console.control || !row()) return;
  if (!made) make();
  if (known !== model.hello) meet();
  const now = row(), modes = (model.hello.modes ?? []).filter((mode) => mode.offered);
  if (element.modes.children.length !== modes.length) {
    element.modes.replaceChildren(...modes.map(({ name, text }) => button(name, () => order({ order: "mode", mode: name }, name), { "data-mode": name, title: text })));
  }
  for (const one of element.modes.children) {
    const refusal = model.boat?.refusals?.[one.dataset.mode];
    one.classList.toggle("on", one.dataset.mode === now.mode);
    one.classList.toggle("small", Boolean(refusal));
    one.title = refusal ? `Refused now: ${refusal}` : modes.find((mode) => mode.name === one.dataset.mode).text;
  }
  element.arm.classList.toggle("on", Boolean(now.armed));
  set(element.present, { transform: `rotate(${deg(now.yaw_rad)})` });
  const shown = dialled ?? deg(now.yaw_rad);
  set(element.needle, { transform: `rotate(${shown})` });
  set(element.dial, { "aria-valuenow": Math.round(shown) });
  say(element.dialText, bearing(rad(shown), 0));
  for (const [name] of TRIMS) {
    const value = parameters()[name];
    if (document.activeElement !== element[name] && value !== undefined && element[name].dataset.known !== String(value)) {
      element[name].dataset.known = value;
      element[name].value = value.toFixed(2);
    }
  }
  const trial = model.boat?.trial ?? {};
  element.accept.disabled = !trial.proposal;
  element.undo.disabled = !trial.in_force;
  element.restart.disabled = Boolean(now.armed);
  say(element.trialText, trialWords(trial));
  const owner = model.boat?.control?.system, own = model.hello.console.system;
  element.take.classList.toggle("on", owner === own);
}


// The stream from the console's server, the bar, the tabs, the keys. Views draw what the model holds.
import { html, say } from "./draw.js";
import { model, more, row, take } from "./model.js";
import * as dp from "./dp.js";
import * as chart from "./chart.js";
import * as values from "./values.js";
import * as strips from "./strips.js";
import * as state from "./state.js";
import * as orders from "./orders.js";
import * as replay from "./replay.js";

const STALE_MS = 900, AGAIN_MS = 1000, STRIPS_MS = 250, NEWS_MS = 7000, PALETTES = ["day", "dusk", "night"];
const at = (id) => document.getElementById(id);
const SILENT_MS = 10000, LONGEST_MS = 60000;
let socket = null, due = false, stripsDue = 0, welcomed = 0, patience_ms = SILENT_MS, version = null, letIn = false;

// --- the stream ------------------------------------------------------------------------------------------------------

function open() {
  const opened = socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/api/stream`);
  model.spoke_ms = performance.now();
  opened.onmessage = (event) => {
    if (opened !== socket) return;
    model.spoke_ms = performance.now();
    const message = JSON.parse(event.data);
    if (message.kind === "beat") { patience_ms = SILENT_MS; opened.send(JSON.stringify({ beat: message.number })); }
    take(message);
    if (message.kind === "hello") { greet(message); welcomed = performance.now(); }
    if (message.kind === "event" && performance.now() - welcomed > 1500) tell(message);
    if (message.kind === "tick" || message.kind === "history") request();
  };
  opened.onopen = () => { letIn = true; };
  opened.onclose = () => { if (opened === socket) again(); };
}

function again() {
  socket = null;
  setTimeout(open, AGAIN_MS);
  if (!letIn) mindLogin();
  letIn = false;
}

/** A console that has begun anew knows no session: the page must log in again. */
async function mindLogin() {
  try {
    const answer = await fetch("/", { method: "HEAD", signal: AbortSignal.timeout(SILENT_MS) });
    if (answer.status === 401) location.reload();
  } catch { /* no console, or no network */ }
}

/** A network that comes back does not always bring back a connection, nor say that it is gone. */
function mindSilence() {
  if (!socket || performance.now() - model.spoke_ms < patience_ms) return;
  patience_ms = Math.min(2 * patience_ms, LONGEST_MS); // a slow network may need longer for the first messages
  socket.close();
  again();
}

replay.connect((asked) => { if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(asked)); });

function greet(hello) {
  version ??= hello.console.page;
  if (version !== hello.console.page) { location.hash = document.body.dataset.view; location.reload(); }
  say(at("vessel"), hello.configuration.title);
  say(at("where"), hello.console.replay ? `Log ${hello.console.log}` : "Live");
  document.title = `${hello.configuration.name} console`;
  at("tab-command").hidden = !hello.console.control;
  document.body.classList.remove("waiting");
}

function tell(event) {
  const tone = state.tone(event.severity);
  if (!tone) return;
  const note = html("div", { class: tone }, event.text);
  at("news").append(note);
  while (at("news").children.length > 3) at("news").firstChild.remove();
  setTimeout(() => note.remove(), NEWS_MS);
}

// --- drawing ---------------------------------------------------------------------------------------------------------

function request() {
  if (due) return;
  due = true;
  requestAnimationFrame(drawAll);
}

function drawAll(when) {
  due = false;
  if (!row()) return;
  const view = document.body.dataset.view;
  drawBar();
  if (view === "dp" || view === "command") dp.draw();
  if (view === "dp" || view === "chart") values.draw();
  if (view === "chart") chart.draw();
  if (view === "strips" && when >= stripsDue) { stripsDue = when + STRIPS_MS; strips.draw(); }
  if (view === "state") state.draw();
  orders.draw();
  replay.draw();
  model.drawn++;
  const made = model.tick.made_unix_ns;
  if (made) {
    const delay = performance.timeOrigin + performance.now() - made / 1e6;
    model.delays_ms.push(delay);
    if (model.delays_ms.length > 600) model.delays_ms.shift();
  }
}

function chip(id, text, tone) {
  say(at(id), text);
  at(id).classList.toggle("good", tone === "good");
  at(id).classList.toggle("warn", tone === "warn");
}

function drawBar() {
  const now = row(), boat = model.boat;
  say(at("mode"), now.mode);
  chip("armed", now.armed ? "Armed" : "Disarmed", now.armed ? "warn" : "");
  const alarm = state.alarm(now.failsafes, more().fence);
  at("failsafes").hidden = !alarm;
  say(at("failsafes"), alarm);
  const system = boat?.control?.system;
  say(at("control"), boat?.control ? (system ? `Control: system ${system}` : "Control: open to all") : "");
  at("control").hidden = !boat?.control;
  const time = new Date(now.time_unix_ns / 1e6);
  say(at("clock"), `${time.toISOString().slice(11, 19)} UTC`);
}

/** Stale within a second of silence, whatever the reason. */
function watch() {
  mindSilence();
  const age = performance.now() - model.heard_ms + model.late_ms, stale = Boolean(model.tick) && age > STALE_MS;
  document.body.classList.toggle("stale", stale);
  const lost = model.link && !model.link.feed;
  say(at("age"), !model.tick ? "waiting" : stale ? `stale ${(age / 1000).toFixed(0)} s` : model.recording ? "log" : "live");
  at("age").classList.toggle("bad", stale);
  at("age").title = lost ? model.link.text : "";
  if (!model.tick && lost) say(at("cover-text"), `Waiting for the boat: ${model.link.text}`);
}
setInterval(watch, 100);

// --- tabs, palettes, keys --------------------------------------------------------------------------------------------

function show(view) {
  document.body.dataset.view = view;
  for (const tab of at("tabs").children) tab.setAttribute("aria-selected", String(tab.dataset.view === view));
  stripsDue = 0;
  request();
}
at("tabs").addEventListener("click", (event) => { const view = event.target.dataset.view; if (view) show(view); });

function palette(name) {
  document.documentElement.dataset.palette = name;
  say(at("palette"), name[0].toUpperCase() + name.slice(1));
  try { localStorage.setItem("palette", name); } catch { /* a browser that keeps nothing */ }
  stripsDue = 0;
  request();
}
const next = () => palette(PALETTES[(PALETTES.indexOf(document.documentElement.dataset.palette) + 1) % PALETTES.length]);
at("palette").addEventListener("click", next);

const SCENE_KEYS = { n: "orientation", c: "centre", "+": "in", "=": "in", "-": "out", f: "fit" };
const NUDGES = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowRight: [0, 1], ArrowLeft: [0, -1] };
addEventListener("keydown", (event) => {
  if (event.target.matches("input, select, textarea") || event.ctrlKey || event.metaKey || event.altKey) return;
  const tabs = [...at("tabs").children].filter((tab) => !tab.hidden), view = document.body.dataset.view, key = event.key;
  if (/^[1-5]$/.test(key) && tabs[key - 1]) show(tabs[key - 1].dataset.view);
  else if (key === "p") next();
  else if (key === " " && model.recording) { event.preventDefault(); replay.toggle(); }
  else if (NUDGES[key] && view === "command" && event.shiftKey) {
    event.preventDefault();
    const [ahead, starboard] = NUDGES[key];
    orders.nudge(ahead * orders.nudgeStep(), starboard * orders.nudgeStep(), 0);
  } else if (SCENE_KEYS[key]) {
    if (view === "chart") chart.chartDo(key === "c" ? "follow" : SCENE_KEYS[key]);
    else if (view === "dp" || view === "command") dp.dpDo(SCENE_KEYS[key]);
  }
});
addEventListener("resize", request);

let kept = null;
try { kept = localStorage.getItem("palette"); } catch { /* as above */ }
palette(PALETTES.includes(kept) ? kept : "day");
show(location.hash.slice(1) || "dp");
open();
window.usvConsole = { model, more, pixel: dp.pixel, chartPixel: chart.pixel, dpView: dp.dpView, chartView: chart.chartView, redraw: () => drawAll(Infinity) };

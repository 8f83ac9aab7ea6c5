// State in words and tables: what the boat does and why, arming, failsafes, control, senses, devices, links, events.
import { html, number } from "./draw.js";
import { model, more, row } from "./model.js";

const panel = document.getElementById("state");
const OLD_S = 2; // since a sense was judged
const LEVEL = { EMERGENCY: 0, ALERT: 1, CRITICAL: 2, ERROR: 3, WARNING: 4, NOTICE: 5, INFO: 6, DEBUG: 7 };
export const tone = (severity) => (LEVEL[severity] <= 3 ? "bad" : LEVEL[severity] === 4 ? "warn" : "");
/** What lasts, for the bar. A fence that was left stays there in words for as long as the boat is outside. */
export function alarm(failsafes, fence) {
  const words = (name) => (name !== "fence" ? name.replaceAll("_", " ") : !fence ? "fence" : fence.breached ? "outside the fence" : "fence ahead");
  if (failsafes) return `Failsafe: ${failsafes.split(";").map(words).join(", ")}`;
  return fence?.breached ? "Outside the fence" : "";
}

const content = {}, shown = {};
let made = false;

function card(key, title, wide = false) {
  content[key] = html("div", { id: `s-${key}` });
  return html("section", { class: wide ? "card wide" : "card" }, html("h2", {}, title), content[key]);
}

const search = html("input", { type: "search", placeholder: "Filter events", "aria-label": "Filter events", oninput: () => drawEvents() });
const severity = html("select", { "aria-label": "Severity", onchange: () => drawEvents() },
  html("option", { value: 7 }, "All"), html("option", { value: 4 }, "Warnings and worse"), html("option", { value: 3 }, "Errors and worse"));
const list = html("div", { id: "event-list" });

function make() {
  made = true;
  panel.append(
    card("words", "What it does"), card("arming", "Arming"), card("failsafes", "Failsafes and their timers"), card("control", "Who commands"),
    card("senses", "Senses"), card("satellites", "Satellites, corrections, clock"), card("devices", "Devices", true), card("links", "Links and storage", true),
    html("section", { class: "card wide" }, html("h2", {}, "Events"), html("div", { class: "filter" }, search, severity), list),
  );
}

/** Replace the content of a card, where it has changed. */
function put(key, build, ...facts) {
  const now = JSON.stringify(facts);
  if (shown[key] === now) return;
  shown[key] = now;
  content[key].replaceChildren(...build());
}

export function draw() {
  if (!row()) return;
  if (!made) make();
  if (panel.getBoundingClientRect().width === 0) return;
  const boat = model.boat ?? {}, m = more(), now = row();
  const words = boat.words ?? [`Mode ${now.mode}`, now.armed ? "Armed" : "Disarmed"];
  put("words", () => [html("ul", {}, ...words.map((line) => html("li", {}, line.trim())))], words);
  drawArming(boat, now);
  drawFailsafes(boat, now);
  put("control", () => control(boat, m), boat.control, m.intended_mode, now.mode, boat.speed_mps);
  drawSenses(boat, m);
  const devices = (m.health ?? []).filter((d) => !isLink(d.name)), links = (m.health ?? []).filter((d) => isLink(d.name));
  put("devices", () => [table(devices)], rounded(devices));
  put("links", () => [table(links)], rounded(links));
  drawEvents();
}

const isLink = (name) => name.includes(":") || name === "storage";
const rounded = (rows) => rows.map((d) => [d.name, d.ok, d.age_s === null ? null : d.age_s.toFixed(1), d.text]);

function drawArming(boat, now) {
  const findings = boat.findings ?? [], mine = findings.filter((f) => !f.modes || f.modes.includes(now.mode));
  put("arming", () => {
    if (!boat.findings) return [html("p", { class: "small" }, "Not in a log.")];
    const verdict = now.armed ? "Armed." : mine.some((f) => f.blocks) ? `May not arm in ${now.mode}.` : `May arm in ${now.mode}.`;
    const item = (f) => html("li", {}, html("span", { class: f.blocks ? "bad" : "warn" }, `${f.blocks ? "✕" : "!"} ${f.modes ? `${f.modes.join(", ")}: ` : ""}${f.text}`), html("div", { class: "small" }, f.remedy));
    return [html("p", { class: mine.some((f) => f.blocks) && !now.armed ? "bad" : "good" }, verdict), html("ul", {}, ...findings.map(item))];
  }, findings, now.armed, now.mode);
}

function drawFailsafes(boat, now) {
  const active = now.failsafes ? now.failsafes.split(";") : [];
  const timers = (boat.timers ?? []).map((t) => [t.name, t.age_s === null ? null : Math.max(0, t.age_s).toFixed(1), t.limit_s]);
  put("failsafes", () => {
    const lines = timers.map(([name, age, limit]) => {
      const share = age === null ? 0 : Math.min(1, age / limit);
      const fill = html("i", { class: share >= 1 ? "bad" : share > 0.5 ? "warn" : "" });
      fill.style.width = `${100 * share}%`;
      return html("tr", {}, html("td", {}, name), html("td", {}, html("div", { class: "meter" }, fill)), html("td", { class: "n" }, age === null ? "–" : `${age} of ${number(limit, 1, "s")}`));
    });
    return [html("p", { class: active.length ? "bad" : "good" }, active.length ? `✕ ${active.join(", ").replaceAll("_", " ")}` : "None lasts."), html("table", { class: "timers" }, ...lines)];
  }, active, timers);
}

function control(boat, m) {
  const c = boat.control;
  if (!c) return [html("p", { class: "small" }, "Not in a log.")];
  const who = c.system ? `System ${c.system} has operator control${c.takeover ? "; others may take it over" : ""}.` : "No system has operator control: any may command.";
  const rows = [["Listed operators", c.operators.length ? c.operators.join(", ") : "all"], ["Mode asked for", m.intended_mode ?? "–"], ["Speed set", number(boat.speed_mps, 2, "m/s")]];
  return [html("p", {}, who), html("table", {}, ...rows.map(([a, b]) => html("tr", {}, html("th", {}, a), html("td", {}, b))))];
}

function drawSenses(boat, m) {
  const facts = [boat.sources, m.distrusted, (m.judged ?? []).map((j) => [j.sense, j.accepted, Math.sqrt(Math.max(0, j.square) / j.limit).toFixed(1), j.age_s > OLD_S ? Math.round(j.age_s) : 0])];
  put("senses", () => {
    const used = Object.entries(boat.sources ?? {}).map(([sense, source]) => {
      const last = (m.judged ?? []).find((j) => j.sense === sense);
      const old = last && last.age_s > OLD_S;
      const verdict = !last ? "" : old ? `the last one ${number(last.age_s, 0, "s")} ago` : last.accepted ? `taken, ${number(Math.sqrt(Math.max(0, last.square) / last.limit), 1)} of its gate` : "rejected by its gate";
      return html("tr", {}, html("th", {}, sense), html("td", { class: source ? "" : "small" }, source ?? "none"), html("td", { class: last && (old || !last.accepted) ? "bad" : "small" }, verdict));
    });
    const lies = (m.distrusted ?? []).map((d) => html("li", { class: "bad" }, `✕ ${d.source} (${d.sense}): ${d.fault}${d.excluded ? "; not used" : ""}${d.asks ? "; accept or reject it" : ""}`));
    return [html("table", {}, ...used), html("ul", {}, ...(lies.length ? lies : [html("li", { class: "small" }, m.distrusted ? "None is found to lie." : "Not in a log.")]))];
  }, facts);
  const c = m.corrections;
  const rows = [["Fix", m.fix ? m.fix.replaceAll("_", " ").toLowerCase() : "–"], ["Satellites", String(m.satellites ?? "–")], ["HDOP", number(m.hdop, 1)],
    ["Corrections", c ? `${c.source ? `${c.source}, station ${c.station ?? "–"}, ` : ""}${number(c.age_s, 0, "s")} old` : "none"],
    ["Clock", m.clock === undefined ? "–" : m.clock ? "set by a receiver" : "not set by a receiver"], ["Load of the control thread", row().load === undefined ? "–" : number(100 * row().load, 0, "%")]];
  put("satellites", () => [html("table", {}, ...rows.map(([a, b]) => html("tr", {}, html("th", {}, a), html("td", {}, b))))], rows);
}

const seen = new Map(); // name → [count, when, rate]
function rate(device) {
  if (model.recording) return ""; // a log has their words once a minute
  const count = Number(/(\d+) (?:\S+ )?(?:sentences|messages|frames)/.exec(device.text)?.[1]);
  if (!Number.isFinite(count)) return "";
  const [before, when, known] = seen.get(device.name) ?? [count, row().t_s, null];
  const passed = row().t_s - when;
  if (passed >= 2) { const hz = (count - before) / passed; seen.set(device.name, [count, row().t_s, hz]); return number(hz, hz < 10 ? 1 : 0, "/s"); }
  if (!seen.has(device.name) || passed < 0) seen.set(device.name, [count, row().t_s, null]);
  return known === null ? "" : number(known, known < 10 ? 1 : 0, "/s");
}

function table(devices) {
  if (!devices.length) return html("p", { class: "small" }, "Not in a log.");
  const line = (d) => html("tr", {}, html("td", { class: d.ok ? "good" : "bad" }, d.ok ? "● ok" : "✕ fault"), html("td", {}, d.name),
    html("td", { class: "n" }, d.age_s === null ? "–" : number(d.age_s, 1, "s")), html("td", { class: "n" }, rate(d)), html("td", { class: "small" }, d.text));
  return html("table", { class: "devices" }, html("tr", {}, ...["", "Name", "Delay", "Rate", "What it says"].map((t) => html("th", {}, t))), ...devices.map(line));
}

function drawEvents() {
  const wanted = search.value.trim().toLowerCase(), worst = Number(severity.value);
  const until = model.recording ? row()?.t_s ?? 0 : Infinity;
  const key = `${model.events.length} ${model.events.at(-1)?.t_s} ${wanted} ${worst} ${model.recording ? Math.round(until) : ""}`;
  if (list.dataset.key === key) return;
  list.dataset.key = key;
  const kept = model.events.filter((e) => LEVEL[e.severity] <= worst && e.t_s <= until && (!wanted || `${e.text} ${e.name}`.toLowerCase().includes(wanted)));
  const line = (e) => html("tr", { class: "event" }, html("td", { class: "n" }, `${number(e.t_s, 1, "s")}`), html("td", { class: tone(e.severity) }, e.severity.toLowerCase()), html("td", {}, e.text));
  list.replaceChildren(kept.length ? html("table", {}, ...kept.slice(-200).reverse().map(line)) : html("p", { class: "small" }, "None."));
}


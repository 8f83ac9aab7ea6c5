// The side panel of numbers: errors, motion, wrench, thrusters, weather, capability, battery, position.
import { bearing, deg, html, length, number, place, points, say, set, svg, wrap } from "./draw.js";
import { curve } from "./dp.js";
import { config, model, more, row } from "./model.js";

const panel = document.getElementById("values");
const OLD_S = 1;
let known = null, cell = {}, bars = [], pods = [], polar = null;

function pairs(title, rows) {
  const list = html("dl", { class: "pairs" });
  for (const [key, label, lead] of rows) {
    cell[key] = html("dd", { id: `v-${key}`, class: lead ? "lead" : "" }, "–");
    list.append(html("dt", {}, label), cell[key]);
  }
  return html("section", { class: "card" }, html("h2", {}, title), list);
}

function make(boat) {
  cell = {};
  bars = ["Surge", "Sway", "Yaw"].map((name) => bar(name));
  pods = boat.thrusters.map((thruster) => bar(labelOf(thruster), "measured-fill", "asked-thrust"));
  const stack = (title, list, note) => html("section", { class: "card" }, html("h2", {}, title), ...list.map((one) => one.element), note ? html("div", { class: "small" }, note) : null);
  polar = html("div", { id: "polar" });
  panel.replaceChildren(
    pairs("Off the reference", [["error", "Position", true], ["ahead", "Ahead / to starboard"], ["turn", "Heading"], ["cross", "Cross-track"]]),
    pairs("Motion", [["heading", "Heading"], ["speed", "Speed over ground"], ["course", "Course over ground"], ["body", "Surge / sway"], ["rate", "Turn"], ["sea", "Roll / pitch, half range"]]),
    stack("Wrench: achieved filled, demanded outlined", bars),
    stack("Thrust: measured filled, demanded outlined", pods),
    html("section", { class: "card" }, html("h2", {}, "Capability: wind that it can hold against"), polar),
    pairs("Weather", [["wind", "True wind"], ["current", "Current"]]),
    pairs("Position", [["lat", "Latitude"], ["lon", "Longitude"], ["sigma", "One sigma"], ["fix", "Fix"], ["age", "Age of position / heading"]]),
    pairs("Power", [["charge", "Battery left"], ["volts", "Voltage / current"]]),
  );
}

function labelOf({ name, sail }) {
  const plain = name.replaceAll("_", " ");
  return sail ? `${plain}: ${sail.attack_max_rad === null ? "sheet" : "wing"}, rudder` : plain;
}

function bar(name, filled = "given", outlined = "asked") {
  const drawing = svg("svg", { viewBox: "-100 0 200 18", preserveAspectRatio: "none", "aria-hidden": "true" });
  const given = svg("rect", { class: filled, y: 4, height: 10 }, drawing);
  const asked = svg("rect", { class: outlined, y: 2, height: 14, "vector-effect": "non-scaling-stroke" }, drawing);
  svg("line", { class: "axis", y1: 0, y2: 18, "vector-effect": "non-scaling-stroke" }, drawing);
  const value = html("span", { class: "v" }, "–");
  const label = html("span", { class: "small" }, name);
  return { element: html("div", { class: "bar" }, label, drawing, value), given, asked, value };
}

function setBar({ given, asked, value }, filled, outlined, most, text) {
  for (const [rect, x] of [[given, filled], [asked, outlined]]) {
    const long = Math.max(-100, Math.min(100, (100 * (x ?? 0)) / (most || 1)));
    set(rect, { x: Math.min(0, long), width: Math.abs(long) });
    rect.style.display = x === null || x === undefined ? "none" : "";
  }
  say(value, text);
}

function put(key, text, old = false) {
  say(cell[key], text);
  cell[key].classList.toggle("old", old && text !== "–");
}

export function draw() {
  const now = row(), boat = config();
  if (!now || !boat) return;
  if (known !== model.hello) { known = model.hello; make(boat); }
  drawErrors(now);
  drawMotion(now);
  drawWrench(now, boat);
  drawPlace(now);
  drawPolar(now);
}

function drawErrors(now) {
  const pose = more().pose && now.desired_north_m !== null;
  const n = now.north_m - now.desired_north_m, e = now.east_m - now.desired_east_m;
  const c = Math.cos(now.yaw_rad), s = Math.sin(now.yaw_rad);
  const old = (more().position_age_s ?? 0) > OLD_S || !now.position_valid;
  put("error", pose ? length(Math.hypot(n, e)) : "–", old);
  put("ahead", pose ? `${length(c * n + s * e)} / ${length(c * e - s * n)}` : "–", old);
  put("turn", now.desired_yaw_rad === null ? "–" : number(deg(wrap(now.yaw_rad - now.desired_yaw_rad)), 1, "°"), !now.heading_valid);
  put("cross", length(now.cross_track_error_m), old);
}

function drawMotion(now) {
  const old = !now.heading_valid, moved = !now.position_valid;
  const speed = Math.hypot(now.surge_mps, now.sway_mps);
  put("heading", bearing(now.yaw_rad), old);
  put("speed", number(speed, 2, "m/s"), moved);
  put("course", speed < 0.05 ? "–" : bearing(now.yaw_rad + Math.atan2(now.sway_mps, now.surge_mps)), moved);
  put("body", `${number(now.surge_mps, 2)} / ${number(now.sway_mps, 2, "m/s")}`, moved);
  put("rate", number(deg(now.yaw_rate_radps), 1, "°/s"), old);
  put("sea", swing());
}

const swings = [];
function swing() {
  const { roll_rad: roll, pitch_rad: pitch } = more(), t = row().t_s;
  if (roll === undefined || roll === null) return "–";
  if (swings.length && swings.at(-1)[0] > t) swings.length = 0;
  if (!swings.length || swings.at(-1)[0] < t) swings.push([t, roll, pitch]);
  while (swings[0][0] < t - 30) swings.shift();
  const half = (i) => (Math.max(...swings.map((s) => s[i])) - Math.min(...swings.map((s) => s[i]))) / 2;
  return `${number(deg(half(1)), 1, "°")} / ${number(deg(half(2)), 1, "°")}`;
}

function drawWrench(now, boat) {
  const axes = [["surge_n", "N"], ["sway_n", "N"], ["yaw_nm", "Nm"]];
  axes.forEach(([name, unit], i) => {
    const given = now[`achieved_${name}`], asked = now[`demanded_${name}`], most = boat.limits[name] || boat.limits.surge_n;
    const digits = Math.max(Math.abs(given), Math.abs(asked)) < 100 ? 1 : 0;
    setBar(bars[i], given, asked, most, `${number(given, digits)} / ${number(asked, digits, unit)}`);
    bars[i].value.classList.toggle("warn", Boolean(more().limited?.[i]));
  });
  boat.thrusters.forEach((thruster, i) => (thruster.sail ? drawRig : drawThruster)(now, thruster, i));
}

/** Of a sailing rig the throttle is the sheet, or a wing's angle as a share of its largest; nothing measures its pull. */
function drawRig(now, { name }, i) {
  const asked = now[`${name}_throttle`], real = more().feedback?.[i]?.throttle ?? null, condition = now[`${name}_condition`];
  const share = asked === null || asked === undefined ? null : 100 * asked;
  const words = `${number(share, 0, "%")}  ${number(deg(now[`${name}_azimuth_rad`] ?? NaN), 0, "°")}`;
  setBar(pods[i], real, asked, 1, condition && condition !== "ready" ? condition : words);
  pods[i].value.classList.toggle("bad", condition === "failed");
}

function drawThruster(now, thruster, i) {
  const report = more().feedback?.[i], asked = now[`${thruster.name}_force_n`];
  const real = report && report.throttle !== null ? curve(thruster, report.throttle) : null;
  const azimuth = now[`${thruster.name}_azimuth_rad`];
  const condition = now[`${thruster.name}_condition`];
  const words = condition && condition !== "ready" ? condition : `${number(asked, 1, "N")}${azimuth === null ? "" : `  ${number(deg(azimuth), 0, "°")}`}`;
  setBar(pods[i], real, asked, Math.max(thruster.max_n, -thruster.min_n), words);
  pods[i].value.classList.toggle("bad", condition === "failed");
}

function drawPlace(now) {
  const m = more(), old = (m.position_age_s ?? 0) > OLD_S;
  put("wind", m.wind_speed_mps === null || m.wind_speed_mps === undefined ? "–" : `${number(m.wind_speed_mps, 1, "m/s")} from ${bearing(m.wind_from_rad, 0)}`);
  const flows = m.current_north_mps !== null && m.current_north_mps !== undefined;
  put("current", flows ? `${number(Math.hypot(m.current_north_mps, m.current_east_mps), 2, "m/s")} to ${bearing(Math.atan2(m.current_east_mps, m.current_north_mps), 0)}` : "–");
  put("lat", now.position_valid ? place(m.lat_deg, "lat") : "–", old);
  put("lon", now.position_valid ? place(m.lon_deg, "lon") : "–", old);
  put("sigma", `${length(now.position_accuracy_m)}, ${number(deg(now.heading_accuracy_rad), 2, "°")}`, old);
  put("fix", m.fix ? `${m.fix.replaceAll("_", " ").toLowerCase()}, ${m.satellites ?? "–"} satellites` : "–", old);
  put("age", m.position_age_s === undefined ? "–" : `${number(m.position_age_s, 1)} / ${number(m.heading_age_s, 1, "s")}`, old);
  put("charge", m.battery?.remaining === null || m.battery?.remaining === undefined ? "–" : number(100 * m.battery.remaining, 0, "%"));
  put("volts", m.battery ? `${number(m.battery.voltage_v, 1, "V")} / ${number(m.battery.current_a, 1, "A")}` : "–");
}

// --- capability ------------------------------------------------------------------------------------------------------

function withoutPolar() {
  if (!model.capability) return "–";
  if (config().limits.sway_n > 0) return "The vessel’s file has no wind areas.";
  return "No thruster pushes sideways: in Hold the boat turns its bow to the weather. Its limits: companion check.";
}

let drawn = null;
function drawPolar(now) {
  const made = model.capability;
  if (!made?.from_rad) { polar.textContent = withoutPolar(); drawn = null; return; }
  if (drawn?.made !== made) {
    const top = Math.max(5, Math.ceil(Math.max(...made.holds_mps.map((v) => v ?? 0)) / 5) * 5);
    const k = 82 / top, root = svg("svg", { viewBox: "-118 -106 236 212", id: "polar-drawing", role: "img", "aria-label": "Capability polar" });
    const step = top > 20 ? 10 : 5;
    for (let v = step; v <= top; v += step) {
      svg("circle", { class: "grid", r: v * k }, root);
      svg("text", { class: "faint t10", x: 3, y: -v * k - 2 }, root, v === top ? `${v} m/s` : v);
    }
    svg("path", { class: "grid", d: "M0-84V84M-84 0H84" }, root);
    const at = (v, i) => [v * k * Math.sin(made.from_rad[i]), -v * k * Math.cos(made.from_rad[i])];
    svg("polygon", { class: "holds", id: "polar-holds", points: points(made.holds_mps.map((v, i) => at(v ?? 0, i))) }, root);
    svg("polygon", { class: "worst", id: "polar-worst", points: points(made.worst_mps.map((v, i) => at(v ?? 0, i))) }, root);
    svg("polygon", { class: "hull", points: "0,-11 4,-3 4,10 -4,10 -4,-3" }, root);
    for (const [x, y, text] of [[0, -95, "bow"], [104, 4, "stbd"], [0, 102, "stern"], [-104, 4, "port"]]) svg("text", { class: "faint t10", x, y, "text-anchor": "middle" }, root, text);
    const dot = svg("g", { id: "polar-wind" }, root);
    svg("circle", { class: "wind", r: 4.5 }, dot);
    const words = html("div", { class: "small", id: "polar-words" });
    polar.replaceChildren(root, words);
    drawn = { made, k, dot, words };
  }
  const { wind_speed_mps: wind, wind_from_rad: from } = more();
  const shown = wind !== null && wind !== undefined;
  drawn.dot.style.display = shown ? "" : "none";
  const legend = "Green: all thrusters. Dashed: without the most important one.";
  if (!shown) { say(drawn.words, `${legend} No wind measured.`); return; }
  const a = from - now.yaw_rad, n = made.from_rad.length, i = ((Math.round((a / (2 * Math.PI)) * n) % n) + n) % n;
  set(drawn.dot, { transform: `translate(${wind * drawn.k * Math.sin(a)} ${-wind * drawn.k * Math.cos(a)})` });
  const worst = made.worst_mps[i], holds = made.holds_mps[i];
  const verdict = wind > (holds ?? 0) ? "Too much wind to hold." : wind > (worst ?? 0) ? `Would not hold without ${made.missed[i].replaceAll("_", " ")}.` : "Would hold without any one thruster.";
  say(drawn.words, `${verdict} ${legend}`);
}

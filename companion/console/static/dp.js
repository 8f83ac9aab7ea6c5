// Position and thrust: the boat to scale, its reference, how sure the estimate is, and what each thruster gives.
import { CHI95, arrow, bearing, deg, ellipse, fromBody, handle, number, outline, points, round125, roundLabel, say, set, svg } from "./draw.js";
import { config, model, more, parameters, row } from "./model.js";

const SMALLEST = 0.02, LARGEST = 20000; // pixels a metre: from a kilometre and more to under a centimetre
const root = document.getElementById("dp");
const part = {};
const view = { perM: 0, fitted: true, bowUp: false, onPoint: false, offset: [0, 0], w: 0, h: 0, turn: 0, centre: [0, 0] };
const picked = { ghost: null }; // set by orders.js: [north, east, yaw]
let onClick = null;

export const dpView = view;
export const setGhost = (pose) => { picked.ghost = pose; };
export const onDpClick = (listener) => { onClick = listener; };

for (const name of ["grid", "ring", "circles", "trail", "sectors", "reference", "ellipses", "hull", "thrusters", "ghost", "marks", "labels"]) {
  part[name] = svg("g", { id: `dp-${name}` }, root);
}
const line = (parent, cls, id) => svg("line", { class: cls, ...(id && { id }) }, parent);
const shape = {
  watch: svg("circle", { id: "dp-watch", class: "watch" }, part.circles),
  alarm: svg("circle", { id: "dp-alarm", class: "alarmline" }, part.circles),
  trail: svg("polyline", { id: "dp-trail-line", class: "trail" }, part.trail),
  reference: svg("polygon", { id: "dp-reference-hull", class: "reference" }, part.reference),
  target: svg("path", { id: "dp-target", class: "reference" }, part.reference),
  sigma1: svg("ellipse", { id: "dp-sigma1", class: "sigma1" }, part.ellipses),
  sigma95: svg("ellipse", { id: "dp-sigma95", class: "sigma95" }, part.ellipses),
  hull: svg("polygon", { id: "dp-hull-outline", class: "hull" }, part.hull),
  bowline: line(part.hull, "ring"),
  origin: svg("circle", { id: "dp-origin", r: 2.5, class: "pod" }, part.hull),
  ghost: svg("polygon", { id: "dp-ghost-hull", class: "ghost" }, part.ghost),
  ring: svg("circle", { class: "ring" }, part.ring),
  ticks: svg("g", {}, part.ring),
  heading: svg("polygon", { class: "hull" }, part.marks),
  desired: svg("polygon", { class: "reference" }, part.marks),
};
const weather = ["wind", "current"].map((name) => ({
  name, line: line(part.marks, name, `dp-${name}`), head: svg("polygon", { class: name }, part.marks),
  text: svg("text", { class: "halo" }, part.labels),
}));
for (const one of weather) one.line.setAttribute("stroke-width", 3);
const scale = { bar: svg("path", { id: "dp-scale", fill: "none", stroke: "currentColor", "stroke-width": 1.6 }, part.labels), text: svg("text", { class: "halo", "text-anchor": "middle" }, part.labels) };
const legend = svg("g", { id: "dp-legend" }, part.labels);
let pods = [], known = null;

/** The pixel of a place of the local plane. */
export function pixel(north, east) {
  const n = north - view.centre[0], e = east - view.centre[1], c = Math.cos(view.turn), s = Math.sin(view.turn);
  return [view.w / 2 + view.offset[0] + view.perM * (c * e - s * n), view.h / 2 + view.offset[1] - view.perM * (s * e + c * n)];
}

/** The place of a pixel. */
export function placeOf(x, y) {
  const right = (x - view.w / 2 - view.offset[0]) / view.perM, up = -(y - view.h / 2 - view.offset[1]) / view.perM;
  const c = Math.cos(view.turn), s = Math.sin(view.turn);
  return [view.centre[0] + c * up - s * right, view.centre[1] + s * up + c * right];
}

function fit() {
  const boat = config();
  const circle = Math.min(view.w, view.h) < 420 ? 1.2 * (parameters().DP_WATCH_R ?? 0) : (parameters().DP_ALARM_R ?? 0);
  const most = Math.max(circle, 0.75 * (boat?.length_m ?? 3));
  view.perM = (Math.min(view.w, view.h) / 2 - 58) / most;
  view.offset = [0, 0];
  view.fitted = true;
}

function zoomed(factor, x = view.w / 2, y = view.h / 2) {
  const before = view.perM;
  view.fitted = false;
  view.perM = Math.min(LARGEST, Math.max(SMALLEST, before * factor));
  const real = view.perM / before;
  view.offset = [x - view.w / 2 - (x - view.w / 2 - view.offset[0]) * real, y - view.h / 2 - (y - view.h / 2 - view.offset[1]) * real];
  draw();
}

const DO = {
  orientation: () => { view.bowUp = !view.bowUp; },
  centre: () => { view.onPoint = !view.onPoint; view.offset = [0, 0]; },
  in: () => zoomed(1.4), out: () => zoomed(1 / 1.4), fit,
};
export function dpDo(name) {
  DO[name]?.();
  for (const button of document.querySelectorAll("#dp-tools [data-do]")) {
    if (button.dataset.do === "orientation") say(button, view.bowUp ? "Bow up" : "North up");
    if (button.dataset.do === "centre") say(button, view.onPoint ? "On point" : "On boat");
  }
  draw();
}
document.getElementById("dp-tools").addEventListener("click", (event) => dpDo(event.target.dataset.do));
handle(root, {
  moved: (dx, dy) => { view.fitted = false; view.offset = [view.offset[0] + dx, view.offset[1] + dy]; draw(); },
  zoomed,
  clicked: (x, y) => onClick?.(...placeOf(x, y)),
});

export function draw() {
  const now = row(), boat = config();
  const box = root.getBoundingClientRect();
  if (!now || !boat || box.width === 0) return;
  if (known !== model.hello) { known = model.hello; makePods(boat); view.perM = 0; }
  if (view.perM === 0 && (!model.boat || box.height === 0)) return;
  const same = view.w === box.width && view.h === box.height;
  [view.w, view.h] = [box.width, box.height];
  if (view.perM === 0 || (view.fitted && !same)) fit();
  view.turn = view.bowUp ? -now.yaw_rad : 0;
  const held = heldPoint(now);
  view.centre = view.onPoint && held ? held : [now.north_m, now.east_m];
  drawGrid();
  drawRing(now);
  drawCircles(held);
  drawHull(now, boat);
  drawThrusters(now, boat);
  drawWeather(now);
  drawScale();
  drawLegend(now);
}

/** The hold point or the go-to target; null where the boat holds none. */
function heldPoint(now) {
  if (!more().pose) return null;
  const target = more().progress?.target ?? more().progress?.place;
  return target ?? (now.desired_north_m === null ? null : [now.desired_north_m, now.desired_east_m]);
}

function drawGrid() {
  const step = round125(90 / view.perM), reach = Math.hypot(view.w, view.h) / view.perM, lines = [];
  const [n0, e0] = placeOf(view.w / 2, view.h / 2);
  for (let i = Math.ceil((n0 - reach / 2) / step); i <= (n0 + reach / 2) / step; i++) lines.push([[i * step, e0 - reach], [i * step, e0 + reach]]);
  for (let i = Math.ceil((e0 - reach / 2) / step); i <= (e0 + reach / 2) / step; i++) lines.push([[n0 - reach, i * step], [n0 + reach, i * step]]);
  const path = lines.map(([a, b]) => `M${points([pixel(...a)])}L${points([pixel(...b)])}`).join("");
  if (!part.grid.firstChild) svg("path", { class: "grid" }, part.grid);
  set(part.grid.firstChild, { d: path });
}

const ringRadius = () => Math.min(view.w, view.h) / 2 - (view.h < 420 ? 44 : 34);

/** A compass ring around the middle of the scene, with the heading and the one asked for. */
function drawRing(now) {
  const r = ringRadius(), x = view.w / 2, y = view.h / 2;
  set(shape.ring, { cx: x, cy: y, r });
  if (!shape.ticks.firstChild) {
    for (let d = 0; d < 360; d += 10) {
      const tick = svg("g", {}, shape.ticks);
      svg("line", { class: "ring", y1: 0, y2: d % 30 ? -5 : -9 }, tick);
      if (d % 30 === 0) svg("text", { class: "faint", "text-anchor": "middle", y: 4 }, tick, { 0: "N", 90: "E", 180: "S", 270: "W" }[d] ?? String(d).padStart(3, "0"));
    }
  }
  const small = view.w < 520; // the corners have the scale and the weather
  [...shape.ticks.children].forEach((tick, i) => {
    const turn = 10 * i + deg(view.turn);
    tick.lastChild.style.display = small && (10 * i === 150 || 10 * i === 210) && tick.lastChild.tagName === "text" ? "none" : "";
    set(tick, { transform: `translate(${x} ${y}) rotate(${turn}) translate(0 ${-r})` });
    if (tick.lastChild.tagName === "text") set(tick.lastChild, { transform: `translate(0 -17) rotate(${-turn})` }); // upright
  });
  mark(shape.heading, now.yaw_rad, r - 2, x, y);
  mark(shape.desired, now.desired_yaw_rad, r - 2, x, y);
}

function mark(element, yaw, r, x, y) {
  element.style.display = yaw === null || yaw === undefined ? "none" : "";
  if (yaw === null || yaw === undefined) return;
  set(element, { points: "0,0 -7,14 7,14", transform: `translate(${x} ${y}) rotate(${deg(yaw + view.turn)}) translate(0 ${-r})` });
}

function drawCircles(held) {
  const shown = held && parameters().DP_WATCH_R;
  for (const [element, radius] of [[shape.watch, parameters().DP_WATCH_R], [shape.alarm, parameters().DP_ALARM_R]]) {
    element.style.display = shown ? "" : "none";
    if (shown) {
      const [x, y] = pixel(...held);
      set(element, { cx: x, cy: y, r: radius * view.perM });
    }
  }
  shape.target.style.display = held ? "" : "none";
  if (held) {
    const [x, y] = pixel(...held);
    set(shape.target, { d: `M${x - 8} ${y}H${x + 8}M${x} ${y - 8}V${y + 8}`, "stroke-dasharray": "none" });
  }
  const kept = [];
  let last = null;
  for (const [n, e] of model.trail) {
    const p = pixel(n, e);
    if (!last || Math.abs(p[0] - last[0]) + Math.abs(p[1] - last[1]) > 2) { kept.push(p); last = p; }
  }
  set(shape.trail, { points: points(kept) });
}

function hullPoints(boat, north, east, yaw) {
  return points(outline(boat).map((p) => pixel(...fromBody(p, north, east, yaw))));
}

function drawHull(now, boat) {
  set(shape.hull, { points: hullPoints(boat, now.north_m, now.east_m, now.yaw_rad) });
  const [x, y] = pixel(now.north_m, now.east_m);
  set(shape.origin, { cx: x, cy: y });
  const bow = pixel(...fromBody([boat.length_m / 2, 0], now.north_m, now.east_m, now.yaw_rad));
  set(shape.bowline, { x1: x, y1: y, x2: bow[0], y2: bow[1] });
  const asked = now.desired_north_m !== null && now.desired_yaw_rad !== null && more().pose;
  shape.reference.style.display = asked ? "" : "none";
  if (asked) set(shape.reference, { points: hullPoints(boat, now.desired_north_m, now.desired_east_m, now.desired_yaw_rad) });
  shape.ghost.style.display = picked.ghost ? "" : "none";
  if (picked.ghost) set(shape.ghost, { points: hullPoints(boat, ...picked.ghost) });
  const covariance = more().covariance_m2;
  for (const [element, times] of [[shape.sigma1, 1], [shape.sigma95, CHI95]]) {
    element.style.display = covariance ? "" : "none";
    if (!covariance) continue;
    const [major, minor, from] = ellipse(covariance);
    // ry lies along the major axis, which is up on the page before it is turned
    set(element, { cx: 0, cy: 0, ry: times * major * view.perM, rx: times * minor * view.perM, transform: `translate(${x} ${y}) rotate(${deg(from + view.turn)})`, "data-major-m": times * major, "data-minor-m": times * minor });
  }
}

function makePods(boat) {
  part.thrusters.replaceChildren();
  part.sectors.replaceChildren();
  pods = boat.thrusters.map((thruster, i) => ({
    thruster,
    blade: thruster.sail || thruster.kind === "rudder" ? line(part.thrusters, "blade", `dp-blade-${i}`) : null,
    sectors: forbidden(thruster).map(() => svg("path", { class: "forbidden" }, part.sectors)),
    stops: steers(thruster) ? svg("path", { class: "stops" }, part.sectors) : null,
    line: line(part.thrusters, "thrust", `dp-thrust-${i}`), head: svg("polygon", { class: "thrust-head" }, part.thrusters),
    mline: line(part.thrusters, "measured", `dp-measured-${i}`), mhead: svg("polygon", { class: "measured-head" }, part.thrusters),
    pod: svg("circle", { class: "pod", r: 4.5 }, part.thrusters),
  }));
}

/** Whether it turns to both sides of astern only, as outboards, nozzles and rudders: the page shows its two stops. */
function steers({ kind, sail, azimuth_min_rad: low, azimuth_max_rad: high }) {
  return kind !== "fixed" && !sail && low !== null && high !== null && high - low < Math.PI;
}

/** Sectors in which a thruster must not push: [from, to] in radians from the bow, clockwise. */
function forbidden(thruster) {
  if (thruster.sail) return [];
  const found = [...thruster.forbidden_rad];
  const { azimuth_min_rad: low, azimuth_max_rad: high } = thruster;
  if (thruster.kind !== "fixed" && !steers(thruster) && low !== null && high !== null && high - low < 2 * Math.PI) found.push([high, low + 2 * Math.PI]);
  return found;
}

/** Pixels a newton: the strongest thruster's full thrust is about as long as the hull, within reason. */
export function perNewton(boat) {
  const most = Math.max(...boat.thrusters.filter((t) => !t.sail).map((t) => Math.max(t.max_n, -t.min_n)), 1e-3);
  return Math.min(170, Math.max(80, 0.9 * boat.length_m * view.perM)) / most;
}

function drawThrusters(now, boat) {
  const k = perNewton(boat);
  set(part.thrusters, { "data-px-per-n": k });
  pods.forEach(({ thruster, sectors, stops, blade, line: l, head, mline, mhead, pod }, i) => {
    const [x, y] = pixel(...fromBody([thruster.x_m, thruster.y_m], now.north_m, now.east_m, now.yaw_rad));
    const condition = now[`${thruster.name}_condition`];
    set(pod, { cx: x, cy: y, class: condition === "failed" ? "pod failed" : "pod" });
    if (blade) drawBlade(blade, thruster, more().feedback?.[i]?.azimuth_rad ?? now[`${thruster.name}_azimuth_rad`] ?? 0, now, boat);
    if (thruster.sail) return;
    const towards = (azimuth) => now.yaw_rad + (azimuth ?? thruster.azimuth_rad) + view.turn;
    const force = now[`${thruster.name}_force_n`] ?? 0, angle = towards(now[`${thruster.name}_azimuth_rad`]);
    arrow(l, head, x, y, k * force * Math.sin(angle), -k * force * Math.cos(angle), 10);
    const report = more().feedback?.[i];
    const given = report && report.throttle !== null ? curve(thruster, report.throttle) : 0;
    const real = towards(report?.azimuth_rad);
    arrow(mline, mhead, x, y, k * given * Math.sin(real), -k * given * Math.cos(real), 8);
    const size = Math.min(60, Math.max(22, 0.28 * boat.length_m * view.perM));
    if (stops) set(stops, { d: [thruster.azimuth_min_rad, thruster.azimuth_max_rad].map((stop) => ray(x, y, size, towards(stop) + Math.PI)).join("") });
    forbidden(thruster).forEach(([from, to], n) => set(sectors[n], { d: pie(x, y, size, towards(from), towards(to)) }));
  });
}

/** The rudder of a sailing rig, whose pull nothing measures, or behind a propeller: the blade points away from where it
 * pushes the stern. */
function drawBlade(blade, { sail, rudder, x_m, y_m }, angle, now, boat) {
  const place = ([x, y]) => pixel(...fromBody([x, y], now.north_m, now.east_m, now.yaw_rad)), long = 0.12 * boat.length_m;
  const [x, y] = sail ? [rudder.x_m, 0] : [x_m, y_m];
  const [x1, y1] = place([x, y]), [x2, y2] = place([x - long * Math.cos(angle), y - long * Math.sin(angle)]);
  set(blade, { x1, y1, x2, y2 });
}

function ray(x, y, r, at) {
  return `M${x} ${y}L${x + r * Math.sin(at)} ${y - r * Math.cos(at)}`;
}

function pie(x, y, r, from, to) {
  const wide = (to - from) % (2 * Math.PI) > Math.PI ? 1 : 0;
  const at = (a) => `${x + r * Math.sin(a)} ${y - r * Math.cos(a)}`;
  return `M${x} ${y}L${at(from)}A${r} ${r} 0 ${wide} 1 ${at(to)}Z`;
}

/** Thrust of a throttle that a board reports, by the thruster's curve. */
export const curve = (thruster, throttle) => (throttle >= 0 ? thruster.ahead_n : thruster.astern_n) * throttle * Math.abs(throttle);

function drawWeather(now) {
  const { wind_speed_mps: wind, wind_from_rad: from, current_north_mps: cn, current_east_mps: ce } = more();
  const r = ringRadius(), x = view.w / 2, y = view.h / 2;
  const shown = [
    wind === null || wind === undefined ? null : [from + Math.PI, from, `Wind ${number(wind, 1, "m/s")}${view.w < 520 ? "" : ` from ${bearing(from, 0)}`}`, Math.min(60, 14 + 5 * wind)],
    cn === null || cn === undefined ? null : [Math.atan2(ce, cn), Math.atan2(ce, cn) + Math.PI, `Current ${number(Math.hypot(cn, ce), 2, "m/s")}${view.w < 520 ? "" : ` to ${bearing(Math.atan2(ce, cn), 0)}`}`, Math.min(60, 14 + 60 * Math.hypot(cn, ce))],
  ];
  weather.forEach((one, i) => {
    one.text.style.display = shown[i] ? "" : "none";
    if (!shown[i]) { one.line.style.display = one.head.style.display = "none"; return; }
    const [towards, at, text, long] = shown[i];
    const a = at + view.turn, b = towards + view.turn, start = r - 22;
    const px = x + start * Math.sin(a), py = y - start * Math.cos(a);
    arrow(one.line, one.head, px, py, long * Math.sin(b), -long * Math.cos(b), 11);
    set(one.text, { x: view.w - 12, y: view.h - 14 - 17 * (1 - i), "text-anchor": "end", class: `halo live ${one.name}-text` });
    say(one.text, text);
  });
}

function drawScale() {
  const size = round125(130 / view.perM), long = size * view.perM, x = 16, y = view.h - 16;
  set(scale.bar, { d: `M${x} ${y - 6}V${y}H${x + long}V${y - 6}`, "data-m": size, "data-px": long });
  set(scale.text, { x: x + long / 2, y: y - 8 });
  say(scale.text, roundLabel(size));
}

function drawLegend(now) {
  const wide = view.w > 560;
  const lines = [`Heading ${bearing(now.yaw_rad)}`];
  if (wide) lines.push(`${view.bowUp ? "Bow" : "North"} up, on the ${view.onPoint ? "held point" : "boat"}`);
  while (legend.children.length < lines.length) svg("text", { class: "halo live", x: 14 }, legend);
  [...legend.children].forEach((text, i) => {
    set(text, { y: 22 + 17 * i, "font-weight": i ? "400" : "650" });
    say(text, lines[i] ?? "");
  });
}


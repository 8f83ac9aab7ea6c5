// The chart: plan, zones, home, berth, others around, on a graticule or on tiles from this computer.
import { arrow, bearing, fromBody, handle, length, number, outline, place, points, rad, round125, roundLabel, say, set, svg } from "./draw.js";
import { config, model, more, parameters, row, toGeodetic, toNed, turned } from "./model.js";

const root = document.getElementById("chart");
const view = { perM: 0, fitted: true, centre: [0, 0], follow: true, w: 0, h: 0 };
const SMALLEST = 0.002, LARGEST = 2000, VECTOR_S = 60, WAKE_M = 60, KELVIN = rad(19.47);
const NUMBER_PX = 22, DOT_PX = 13; // from a waypoint to the nearest one whose number is drawn
const layer = {};
for (const name of ["tiles", "graticule", "fence", "corridor", "legs", "path", "trail", "wake", "leader", "ais", "places", "boat", "ghost", "labels"]) layer[name] = svg("g", { id: `chart-${name}` }, root);
const shape = {
  graticule: svg("path", { class: "grid" }, layer.graticule), names: svg("g", {}, layer.graticule),
  corridor: svg("polyline", { id: "chart-corridor-line", class: "corridor" }, layer.corridor),
  legs: svg("polyline", { id: "chart-legs-line", class: "legs" }, layer.legs),
  path: svg("polyline", { id: "chart-path-line", class: "path" }, layer.path),
  trail: svg("polyline", { id: "chart-trail-line", class: "trail" }, layer.trail),
  hull: svg("polygon", { id: "chart-hull", class: "hull" }, layer.boat),
  vector: svg("line", { class: "trail" }, layer.boat),
  ghost: svg("polygon", { id: "chart-ghost-hull", class: "ghost" }, layer.ghost),
  scale: svg("path", { id: "chart-scale", fill: "none", stroke: "currentColor", "stroke-width": 1.6 }, layer.labels),
  scaleText: svg("text", { class: "halo", "text-anchor": "middle" }, layer.labels),
  credit: svg("text", { class: "faint halo", "text-anchor": "end" }, layer.labels),
  wake: svg("polygon", { id: "chart-wake-band", class: "wake" }, layer.wake),
  keepOut: svg("circle", { id: "chart-keep-out", class: "keepout" }, layer.leader),
  leaderTrail: svg("polyline", { class: "leaderline", "stroke-dasharray": "2 3" }, layer.leader),
  leader: svg("polygon", { id: "chart-leader", class: "leader" }, layer.leader),
  leaderLine: svg("line", { class: "leaderline" }, layer.leader), leaderHead: svg("polygon", { class: "leader" }, layer.leader),
  station: svg("path", { id: "chart-station", class: "station" }, layer.leader),
};
let fittedFor = null, drawnPlan = null, ghost = null, onClick = null, onStation = null, dragging = null, targets = new Map();

export const chartView = view;
export const setChartGhost = (pose) => { ghost = pose; };
export const onChartClick = (listener) => { onClick = listener; };
export const onStationDragged = (listener) => { onStation = listener; };

export const pixel = (north, east) => [view.w / 2 + view.perM * (east - view.centre[1]), view.h / 2 - view.perM * (north - view.centre[0])];
const placeOf = (x, y) => [view.centre[0] - (y - view.h / 2) / view.perM, view.centre[1] + (x - view.w / 2) / view.perM];

function fit() {
  const now = row(), seen = [[now.north_m, now.east_m], ...model.trail];
  for (const p of [...(model.boat?.mission ?? []), ...(model.boat?.rally ?? [])]) seen.push([p.north_m, p.east_m]);
  for (const zone of model.boat?.fence ?? []) {
    const r = zone.radius_m ?? 0;
    for (const [n, e] of zone.points) seen.push([n - r, e - r], [n + r, e + r]);
  }
  const { home, leader } = more(), berth = model.boat?.berth;
  seen.push(...(model.boat?.path ?? []));
  if (berth) seen.push([berth.boat[0], berth.boat[1]]);
  if (home) seen.push(toNed(home.lat_deg, home.lon_deg));
  if (leader) seen.push([leader.north_m, leader.east_m]);
  const range = (i) => [Math.min(...seen.map((p) => p[i])), Math.max(...seen.map((p) => p[i]))];
  const [n0, n1] = range(0), [e0, e1] = range(1);
  view.centre = [(n0 + n1) / 2, (e0 + e1) / 2];
  view.perM = Math.min(40, Math.max(SMALLEST, Math.min(view.w / (e1 - e0 + 12), view.h / (n1 - n0 + 12)) * 0.84));
  view.follow = seen.length < 3;
  view.fitted = true;
}

/** Whether the boat is in the picture. A chart that nobody moved is fitted again when it leaves. */
function inSight(now) {
  const [x, y] = pixel(now.north_m, now.east_m);
  return x > 0 && x < view.w && y > 0 && y < view.h;
}

function zoomed(factor, x = view.w / 2, y = view.h / 2) {
  const before = placeOf(x, y);
  view.fitted = false;
  view.perM = Math.min(LARGEST, Math.max(SMALLEST, view.perM * factor));
  const after = placeOf(x, y);
  if (!view.follow) view.centre = [view.centre[0] + before[0] - after[0], view.centre[1] + before[1] - after[1]];
  draw();
}

const DO = { in: () => zoomed(1.5), out: () => zoomed(1 / 1.5), fit, follow: () => { view.follow = !view.follow; } };
export function chartDo(name) {
  DO[name]?.();
  draw();
}
document.getElementById("chart-tools").addEventListener("click", (event) => chartDo(event.target.dataset.do));
document.getElementById("corridor").addEventListener("change", () => draw());
handle(root, {
  moved: (dx, dy, event) => {
    if (dragging) { drag(event); return; }
    view.follow = view.fitted = false;
    view.centre = [view.centre[0] + dy / view.perM, view.centre[1] - dx / view.perM];
    draw();
  },
  zoomed,
  clicked: (x, y) => onClick?.(...placeOf(x, y)),
});
shape.station.addEventListener("pointerdown", () => { if (onStation) dragging = []; });
root.addEventListener("pointerup", () => { if (dragging?.length) onStation(...dragging); dragging = null; });

function drag(event) {
  const box = root.getBoundingClientRect(), leader = more().leader;
  if (!leader) return;
  const [n, e] = placeOf(event.clientX - box.left, event.clientY - box.top);
  const away = [n - leader.north_m, e - leader.east_m];
  dragging = [Math.atan2(away[1], away[0]) - (leader.yaw_rad ?? 0), Math.hypot(...away)];
  draw();
}

export function draw() {
  const now = row(), boat = config(), box = root.getBoundingClientRect();
  if (!now || !boat || box.width === 0) return;
  const same = view.w === box.width && view.h === box.height, boatNew = fittedFor !== model.hello;
  [view.w, view.h] = [box.width, box.height];
  if (!model.boat) return;
  if (boatNew || (view.fitted && (!same || !inSight(now)))) { fittedFor = model.hello; fit(); }
  if (view.follow) view.centre = [now.north_m, now.east_m];
  for (const button of document.querySelectorAll('#chart-tools [data-do="follow"]')) button.classList.toggle("on", view.follow);
  drawTiles();
  drawGraticule();
  drawPlan(now);
  drawBoat(now, boat);
  drawLeader();
  drawTargets(now);
  const size = round125(120 / view.perM), long = size * view.perM, y = view.h - 14;
  set(shape.scale, { d: `M16 ${y - 6}V${y}H${16 + long}V${y - 6}`, "data-m": size, "data-px": long });
  set(shape.scaleText, { x: 16 + long / 2, y: y - 8 });
  say(shape.scaleText, roundLabel(size));
}

// --- ground ----------------------------------------------------------------------------------------------------------

/** [south, west, north, east] of the view. East of the 180th meridian the longitudes go on counting. */
function corners() {
  const [south, west] = toGeodetic(...placeOf(0, view.h)), [north, east] = toGeodetic(...placeOf(view.w, 0));
  return [south, west, north, east < west ? east + 360 : east];
}

function drawGraticule() {
  const [lat0, lon0, lat1, lon1] = corners();
  const steps = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 30, 60].map((minutes) => minutes / 60);
  steps.unshift(0.0001 / 60, 0.0002 / 60, 0.0005 / 60, 0.001 / 60, 0.002 / 60, 0.005 / 60);
  const choose = (span, size, gap) => steps.find((s) => (s / span) * size >= gap) ?? 2;
  const north = choose(lat1 - lat0, view.h, 95), east = choose(lon1 - lon0, view.w, 130);
  let path = "";
  const labels = [];
  const digits = (step) => Math.max(0, Math.ceil(-Math.log10(step * 60) - 1e-9));
  for (let i = Math.ceil(lat0 / north); i * north <= lat1; i++) {
    const y = pixel(...toNed(i * north, lon0))[1];
    path += `M0 ${y}H${view.w}`;
    if (y > 60 && y < view.h - 50) labels.push([6, y - 4, "start", place(i * north, "lat", digits(north))]);
  }
  for (let i = Math.ceil(lon0 / east); i * east <= lon1; i++) {
    const x = pixel(...toNed(lat0, i * east))[0];
    path += `M${x} 0V${view.h}`;
    if (x > 30 && x < view.w - 60) labels.push([x + 4, view.h - 38, "start", place(turned(i * east), "lon", digits(east))]);
  }
  set(shape.graticule, { d: path });
  while (shape.names.children.length < labels.length) svg("text", { class: "faint halo t11" }, shape.names);
  [...shape.names.children].forEach((text, i) => {
    text.style.display = labels[i] ? "" : "none";
    if (labels[i]) { set(text, { x: labels[i][0], y: labels[i][1], "text-anchor": labels[i][2] }); say(text, labels[i][3]); }
  });
}

const images = new Map();
function drawTiles() {
  const known = model.hello.console.tiles;
  if (!known) return;
  const { lat_deg, lon_deg } = model.boat?.frame ?? config().home;
  const metres = (zoom) => (40075016.686 * Math.cos(rad(lat_deg))) / 2 ** zoom;
  let zoom = known.zooms[1];
  while (zoom > known.zooms[0] && metres(zoom) * view.perM < 190) zoom--;
  const column = (lon) => ((lon + 180) / 360) * 2 ** zoom;
  const line = (lat) => ((1 - Math.asinh(Math.tan(rad(lat))) / Math.PI) / 2) * 2 ** zoom;
  const [south, west, north, east] = corners();
  const used = new Set();
  if ((column(east) - column(west)) * (line(south) - line(north)) < 200) {
    for (let x = Math.floor(column(west)); x <= column(east); x++) for (let y = Math.floor(line(north)); y <= line(south); y++) {
      const key = `${zoom}/${x}/${y}`;
      used.add(key);
      if (!images.has(key)) images.set(key, svg("image", { href: `/tiles/${zoom}/${x % 2 ** zoom}/${y}`, preserveAspectRatio: "none" }, layer.tiles));
      const lon = (c) => (c / 2 ** zoom) * 360 - 180, lat = (l) => (Math.atan(Math.sinh(Math.PI * (1 - (2 * l) / 2 ** zoom))) * 180) / Math.PI;
      const [px, py] = pixel(...toNed(lat(y), lon(x))), [qx, qy] = pixel(...toNed(lat(y + 1), lon(x + 1)));
      set(images.get(key), { x: px, y: py, width: qx - px + 0.5, height: qy - py + 0.5 });
    }
  }
  for (const [key, image] of images) if (!used.has(key)) { image.remove(); images.delete(key); }
  set(shape.credit, { x: view.w - 8, y: view.h - 8 });
  say(shape.credit, known.attribution.replace(/<[^>]*>/g, ""));
}

// --- plan ------------------------------------------------------------------------------------------------------------

function drawPlan(now) {
  const plan = model.boat ?? {};
  const legs = (plan.mission ?? []).map((p) => pixel(p.north_m, p.east_m));
  set(shape.legs, { points: points(legs) });
  const half = Number(document.getElementById("corridor").value);
  set(shape.corridor, { points: points(legs), "stroke-width": Math.max(0, 2 * half * view.perM) });
  set(shape.path, { points: points((plan.path ?? []).map((p) => pixel(...p))) });
  if (drawnPlan !== plan) { drawnPlan = plan; makePlan(plan); }
  layer.fence.classList.toggle("breached", Boolean(more().fence?.breached));
  [...layer.fence.children].forEach((element, i) => {
    const zone = plan.fence[i];
    if (zone.radius_m === null) set(element, { points: points(zone.points.map((p) => pixel(...p))) });
    else { const [x, y] = pixel(...zone.points[0]); set(element, { cx: x, cy: y, r: zone.radius_m * view.perM }); }
  });
  drawMarks(now);
}

/** A waypoint without room for its number is a dot, and none where another one's number stands. */
function drawMarks(now) {
  const seq = now.mission_seq, active = now.mode === "Mission", crowd = new Crowd(NUMBER_PX);
  const isCurrent = (mark) => mark.seq !== undefined && mark.seq === seq && (active || more().mission?.state === "PAUSED");
  for (const mark of layer.places.children) if (isCurrent(mark)) crowd.add(...pixel(...mark.at()));
  for (const mark of layer.places.children) {
    const place = mark.at();
    mark.style.display = place ? "" : "none";
    if (!place) continue;
    const [x, y] = pixel(...place);
    set(mark, { transform: `translate(${x} ${y})` });
    if (mark.seq !== undefined) drawWaypoint(mark, isCurrent(mark), active && mark.seq < seq, crowd, x, y);
  }
}

function drawWaypoint(mark, current, done, crowd, x, y) {
  const room = current ? NUMBER_PX : crowd.room(x, y), numbered = room >= NUMBER_PX;
  if (numbered && !current) crowd.add(x, y);
  mark.style.display = room < DOT_PX ? "none" : "";
  set(mark.firstChild, { class: `waypoint${current ? " now" : done ? " done" : ""}`, r: numbered ? 9.5 : 3 });
  set(mark.lastChild, { class: current ? "t11 now" : "t11" });
  mark.lastChild.style.display = numbered ? "" : "none";
}

/** Marks with a number, by squares of `size` pixels: how far a place is from the nearest of them, up to `size`. */
class Crowd {
  constructor(size) { this.size = size; this.squares = new Map(); }

  #near(x, y) {
    const i = Math.floor(x / this.size), j = Math.floor(y / this.size), found = [];
    for (let a = i - 1; a <= i + 1; a++) for (let b = j - 1; b <= j + 1; b++) found.push(...(this.squares.get(`${a} ${b}`) ?? []));
    return found;
  }

  room(x, y) { return Math.min(this.size, ...this.#near(x, y).map(([u, v]) => Math.hypot(u - x, v - y))); }

  add(x, y) {
    const key = `${Math.floor(x / this.size)} ${Math.floor(y / this.size)}`;
    this.squares.set(key, [...(this.squares.get(key) ?? []), [x, y]]);
  }
}

function makePlan(plan) {
  layer.fence.replaceChildren();
  for (const zone of plan.fence ?? []) svg(zone.radius_m === null ? "polygon" : "circle", { class: zone.inclusion ? "fence" : "fence out" }, layer.fence);
  layer.places.replaceChildren();
  const add = (at, draw) => { const mark = svg("g", {}, layer.places); mark.at = at; draw(mark); return mark; };
  const named = (text) => (mark) => {
    svg("path", { class: "mark", d: "M0-8L7 0 0 8-7 0Z" }, mark);
    svg("text", { class: "halo", x: 11, y: 4 }, mark, text);
  };
  for (const p of plan.rally ?? []) add(() => [p.north_m, p.east_m], named(`Rally ${p.number}`));
  if (plan.berth) add(() => [plan.berth.boat[0], plan.berth.boat[1]], named("Berth"));
  add(() => (more().home ? toNed(more().home.lat_deg, more().home.lon_deg) : null), (mark) => {
    svg("path", { class: "mark", d: "M-8 7V-1L0-8 8-1V7Z" }, mark);
    svg("text", { class: "halo", x: 12, y: 5 }, mark, "Home");
  }).id = "chart-home";
  for (const p of plan.mission ?? []) {
    const mark = add(() => [p.north_m, p.east_m], (g) => {
      svg("circle", { class: "waypoint", r: 9.5 }, g);
      svg("text", { "text-anchor": "middle", y: 4, class: "t11" }, g, p.number);
    });
    mark.seq = p.seq;
    mark.setAttribute("data-item", p.number);
  }
}

// --- boats -----------------------------------------------------------------------------------------------------------

const symbol = (x, y, yaw, size = 9) => points([[0, -1.5 * size], [0.75 * size, size], [0, 0.55 * size], [-0.75 * size, size]].map(([a, b]) => [x + Math.cos(yaw) * a - Math.sin(yaw) * b, y + Math.sin(yaw) * a + Math.cos(yaw) * b]));

function boatPoints(boat, north, east, yaw) {
  if (boat.length_m * view.perM > 26) return points(outline(boat).map((p) => pixel(...fromBody(p, north, east, yaw))));
  return symbol(...pixel(north, east), yaw);
}

function drawBoat(now, boat) {
  set(shape.hull, { points: boatPoints(boat, now.north_m, now.east_m, now.yaw_rad) });
  const kept = [];
  let last = null;
  for (const p of model.trail) {
    const q = pixel(...p);
    if (!last || Math.abs(q[0] - last[0]) + Math.abs(q[1] - last[1]) > 2) { kept.push(q); last = q; }
  }
  set(shape.trail, { points: points(kept) });
  const course = now.yaw_rad + Math.atan2(now.sway_mps, now.surge_mps), way = Math.hypot(now.surge_mps, now.sway_mps) * VECTOR_S;
  const [x, y] = pixel(now.north_m, now.east_m), [u, v] = pixel(now.north_m + way * Math.cos(course), now.east_m + way * Math.sin(course));
  set(shape.vector, { x1: x, y1: y, x2: u, y2: v });
  shape.vector.style.display = way > 3 ? "" : "none";
  shape.ghost.style.display = ghost ? "" : "none";
  if (ghost) set(shape.ghost, { points: boatPoints(boat, ...ghost) });
}

function drawLeader() {
  const leader = more().leader;
  layer.leader.style.display = layer.wake.style.display = leader ? "" : "none";
  if (!leader) return;
  const at = [leader.north_m, leader.east_m], [x, y] = pixel(...at), yaw = leader.yaw_rad ?? 0;
  set(shape.leader, { points: symbol(x, y, yaw) });
  set(shape.keepOut, { cx: x, cy: y, r: (parameters().FOLL_MIN_DIST ?? 0) * view.perM });
  set(shape.leaderTrail, { points: points(model.leaderTrail.map((p) => pixel(...p))) });
  const [u, v] = pixel(at[0] + leader.north_mps * VECTOR_S, at[1] + leader.east_mps * VECTOR_S);
  arrow(shape.leaderLine, shape.leaderHead, x, y, u - x, v - y, 9);
  const speed = Math.hypot(leader.north_mps, leader.east_mps), course = Math.atan2(leader.east_mps, leader.north_mps);
  shape.wake.style.display = speed > 0.5 ? "" : "none";
  const arm = (side) => fromBody([-WAKE_M * Math.cos(KELVIN), side * WAKE_M * Math.sin(KELVIN)], ...at, course);
  set(shape.wake, { points: points([at, arm(1), arm(-1)].map((p) => pixel(...p))) });
  const [turn, far] = dragging?.length ? dragging : [model.boat?.station?.bearing_rad, model.boat?.station?.distance_m];
  shape.station.style.display = far ? "" : "none";
  if (far) {
    const [sx, sy] = pixel(at[0] + far * Math.cos(yaw + turn), at[1] + far * Math.sin(yaw + turn));
    set(shape.station, { d: `M${sx - 10} ${sy}a10 10 0 1 0 20 0a10 10 0 1 0 -20 0M${sx - 14} ${sy}H${sx + 14}M${sx} ${sy - 14}V${sy + 14}`, "pointer-events": "all" });
  }
}

/** Closest approach of another vessel: [seconds, metres] on both present courses. */
export function approach(now, at, velocity) {
  const c = Math.cos(now.yaw_rad), s = Math.sin(now.yaw_rad);
  const own = [c * now.surge_mps - s * now.sway_mps, s * now.surge_mps + c * now.sway_mps];
  const d = [at[0] - now.north_m, at[1] - now.east_m], v = [velocity[0] - own[0], velocity[1] - own[1]];
  const speed2 = v[0] ** 2 + v[1] ** 2, t = speed2 < 1e-6 ? 0 : Math.max(0, -(d[0] * v[0] + d[1] * v[1]) / speed2);
  return [t, Math.hypot(d[0] + v[0] * t, d[1] + v[1] * t)];
}

function drawTargets(now) {
  const seen = new Set(), box = root.getBoundingClientRect(), tools = document.getElementById("chart-tools").getBoundingClientRect();
  const taken = [[tools.left - box.left, tools.top - box.top, tools.right - box.left, tools.bottom - box.top]];
  for (const mark of layer.places.children) {
    const place = mark.at();
    if (!place) continue;
    const [x, y] = pixel(...place);
    taken.push([x - 12, y - 12, x + (mark.seq === undefined ? 60 : 12), y + 12]);
  }
  for (const target of more().traffic ?? []) {
    seen.add(target.mmsi);
    if (!targets.has(target.mmsi)) {
      const g = svg("g", { "data-mmsi": target.mmsi }, layer.ais);
      targets.set(target.mmsi, { g, line: svg("line", { class: "aisline" }, g), mark: svg("polygon", { class: "ais" }, g), name: svg("text", { class: "halo" }, layer.labels), close: svg("text", { class: "faint halo t11" }, layer.labels) });
    }
    const { line, mark, name, close } = targets.get(target.mmsi), at = toNed(target.lat_deg, target.lon_deg), [x, y] = pixel(...at);
    const course = target.course_rad ?? 0, speed = target.speed_mps ?? 0, velocity = [speed * Math.cos(course), speed * Math.sin(course)];
    const [u, v] = pixel(at[0] + velocity[0] * VECTOR_S, at[1] + velocity[1] * VECTOR_S);
    set(line, { x1: x, y1: y, x2: u, y2: v });
    set(mark, { points: symbol(x, y, target.heading_rad ?? course, 8) });
    const [t, far] = approach(now, at, velocity);
    say(name, view.w < 520 ? target.name : `${target.name} ${number(target.speed_mps, 1, "m/s")} ${bearing(target.course_rad, 0)}`);
    const known = target.speed_mps !== null && (target.course_rad !== null || speed === 0);
    say(close, !known ? `${number(Math.hypot(at[0] - now.north_m, at[1] - now.east_m), 0, "m")} off, course not known` : t > 0 ? `CPA ${number(far, 0, "m")} in ${number(t / 60, 1, "min")}` : `${number(far, 0, "m")} off, opening`);
    const [dx, dy] = free(x, y, 6.6 * Math.max(name.textContent.length, close.textContent.length), taken);
    set(name, { x: x + dx, y: y + dy });
    set(close, { x: x + dx, y: y + dy + 14 });
  }
  for (const [mmsi, { g, name, close }] of targets) if (!seen.has(mmsi)) { for (const one of [g, name, close]) one.remove(); targets.delete(mmsi); }
}

/** Where a label of two lines beside a mark covers no other mark and no other label; its first choice otherwise. */
function free(x, y, wide, taken) {
  const choices = [[13, -3], [-wide - 13, -3], [-wide / 2, 28], [-wide / 2, -30], [13, 28], [13, -36], [-wide - 13, 28], [-wide - 13, -36], [13, 60], [-wide - 13, 60], [13, -68], [-wide - 13, -68]];
  const box = ([dx, dy]) => [x + dx - 2, y + dy - 13, x + dx + wide, y + dy + 17];
  const inside = ([a, , c]) => a > 0 && c < view.w;
  const clear = ([a, b, c, d]) => inside([a, b, c, d]) && taken.every(([p, q, r, s]) => c < p || a > r || d < q || b > s);
  const chosen = choices.find((one) => clear(box(one))) ?? choices.find((one) => inside(box(one))) ?? choices[0];
  taken.push(box(chosen));
  return chosen;
}

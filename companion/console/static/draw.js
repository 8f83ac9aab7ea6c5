// Small helpers for SVG and HTML, and numbers as people read them.
const NS = "http://www.w3.org/2000/svg";

/** An SVG element with attributes. */
export function svg(tag, attributes = {}, parent = null, text = null) {
  const made = document.createElementNS(NS, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== null) made.textContent = text;
  if (parent) parent.append(made);
  return made;
}

/** An HTML element: attributes, children or text. */
export function html(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === false || value === null || value === undefined) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

/** Set attributes, but only those that change. */
export function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    const text = String(value);
    if (element.getAttribute(name) !== text) element.setAttribute(name, text);
  }
  return element;
}

export function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export const points = (list) => list.map(([x, y]) => `${x.toFixed(2)},${y.toFixed(2)}`).join(" ");
export const deg = (rad) => (rad * 180) / Math.PI;
export const rad = (degrees) => (degrees * Math.PI) / 180;
export const wrap = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));

/** A number with its unit; a dash for one that is missing. */
export function number(value, digits, unit = "") {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const text = value.toFixed(digits).replace(/^-(0(?:\.0*)?)$/, "$1").replace("-", "−");
  return unit === "°" || unit === "" ? text + unit : `${text}\u00a0${unit}`;
}

/** A bearing as three digits: 007.4°. */
export function bearing(angle, digits = 1) {
  if (angle === null || angle === undefined || !Number.isFinite(angle)) return "–";
  let value = ((deg(angle) % 360) + 360) % 360;
  if (value.toFixed(digits) === (360).toFixed(digits)) value = 0;
  return value.toFixed(digits).padStart(digits ? 4 + digits : 3, "0") + "°";
}

/** A length with a unit that suits it. */
export function length(metres) {
  if (metres === null || metres === undefined || !Number.isFinite(metres)) return "–";
  const size = Math.abs(metres);
  if (size < 1) return number(metres * 100, size < 0.1 ? 1 : 0, "cm");
  return size < 1000 ? number(metres, size < 100 ? 2 : 0, "m") : number(metres / 1000, 2, "km");
}

/** The round number (1, 2, 5 times a power of ten) nearest below. */
export function round125(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [5, 2, 1].map((n) => n * power).find((n) => n <= value * 1.0000001) ?? power;
}

export function roundLabel(metres) {
  if (metres >= 1000) return `${+(metres / 1000).toPrecision(3)} km`;
  return metres >= 1 ? `${+metres.toPrecision(3)} m` : `${+(metres * 100).toPrecision(3)} cm`;
}

/** Latitude or longitude in degrees and minutes. */
export function place(degrees, axis, digits = 4) {
  const side = axis === "lat" ? (degrees < 0 ? "S" : "N") : degrees < 0 ? "W" : "E";
  const size = Math.abs(degrees), whole = Math.floor(size + 1e-12), minutes = (size - whole) * 60;
  return `${String(whole).padStart(axis === "lat" ? 2 : 3, "0")}°${minutes.toFixed(digits).padStart(digits ? 3 + digits : 2, "0")}′${side}`;
}

/** The outline of a boat in body axes: one hull, or the two of a catamaran with a deck between them. */
export function outline({ length_m, beam_m, hull }) {
  if (hull?.form !== "catamaran" || !hull.hull_beam_m) return oneHull(length_m, beam_m);
  const y = 0.5 * (hull.hull_spacing_m ?? beam_m - hull.hull_beam_m), inner = -0.5 * hull.hull_beam_m;
  const round = oneHull(length_m, hull.hull_beam_m), inward = round.splice(-2);
  const starboard = [[-0.28 * length_m, inner], ...inward, ...round, [0.1 * length_m, inner]].map(([x, side]) => [x, y + side]);
  return [...starboard, ...starboard.map(([x, side]) => [x, -side]).reverse()];
}

/** A hull with a round bow and straight sides: from its stern to starboard round the bow to its stern to port. */
function oneHull(long_m, wide_m) {
  const half = long_m / 2, side = wide_m / 2, shoulder = half - Math.min(0.9 * wide_m, 0.38 * long_m);
  const bow = [];
  for (let i = 0; i <= 8; i++) {
    const share = i / 8;
    bow.push([shoulder + (half - shoulder) * Math.sin((share * Math.PI) / 2), side * Math.cos((share * Math.PI) / 2)]);
  }
  const starboard = [[-half, side * 0.86], [-half + 0.12 * long_m, side], ...bow];
  return [...starboard, ...starboard.slice(0, -1).reverse().map(([x, y]) => [x, -y])];
}

/** A point of body axes in the local plane. */
export function fromBody([x, y], north_m, east_m, yaw) {
  const c = Math.cos(yaw), s = Math.sin(yaw);
  return [north_m + c * x - s * y, east_m + s * x + c * y];
}

/** Semi-axes (m) and direction (rad from north) of the one-sigma ellipse of a covariance [nn, ne, ee]. */
export function ellipse([nn, ne, ee]) {
  const mean = (nn + ee) / 2, spread = Math.hypot((nn - ee) / 2, ne);
  return [Math.sqrt(Math.max(0, mean + spread)), Math.sqrt(Math.max(0, mean - spread)), 0.5 * Math.atan2(2 * ne, nn - ee)];
}

export const CHI95 = Math.sqrt(5.991464547); // of two degrees of freedom

/** Draw or hide an arrow: a line and a head, from (x, y) along (dx, dy). */
export function arrow(line, head, x, y, dx, dy, size = 9) {
  const long = Math.hypot(dx, dy), shown = long > 1;
  line.style.display = head.style.display = shown ? "" : "none";
  if (!shown) return;
  const ux = dx / long, uy = dy / long, tip = Math.min(size, long);
  set(line, { x1: x, y1: y, x2: x + dx - ux * tip * 0.6, y2: y + dy - uy * tip * 0.6 });
  set(head, {
    points: points([
      [x + dx, y + dy],
      [x + dx - ux * tip - uy * tip * 0.42, y + dy - uy * tip + ux * tip * 0.42],
      [x + dx - ux * tip + uy * tip * 0.42, y + dy - uy * tip - ux * tip * 0.42],
    ]),
  });
}

/** Lets a person drag and zoom a scene: `moved(dx, dy)`, `zoomed(factor, x, y)`, `clicked(x, y, event)`. */
export function handle(element, { moved, zoomed, clicked }) {
  const held = new Map();
  let travelled = 0;
  const at = (event) => {
    const box = element.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoomed(Math.exp(-event.deltaY * 0.0015), ...at(event));
  }, { passive: false });
  element.addEventListener("pointerdown", (event) => {
    held.set(event.pointerId, at(event));
    travelled = 0;
    element.setPointerCapture(event.pointerId);
  });
  element.addEventListener("pointermove", (event) => {
    const before = held.get(event.pointerId);
    if (!before) return;
    const now = at(event);
    travelled += Math.hypot(now[0] - before[0], now[1] - before[1]);
    if (held.size === 2) {
      const other = [...held].find(([id]) => id !== event.pointerId)[1];
      const was = Math.hypot(before[0] - other[0], before[1] - other[1]);
      const is = Math.hypot(now[0] - other[0], now[1] - other[1]);
      if (was > 10 && is > 10) zoomed(is / was, (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
    } else if (travelled > 4) moved(now[0] - before[0], now[1] - before[1], event);
    held.set(event.pointerId, now);
  });
  const release = (event) => {
    if (held.delete(event.pointerId) && travelled <= 4 && event.type === "pointerup" && held.size === 0) clicked?.(...at(event), event);
  };
  element.addEventListener("pointerup", release);
  element.addEventListener("pointercancel", release);
}

// Strips: the last ten minutes as lines, each with its own dash; the time shown can be shortened and held.
import { html, number, say } from "./draw.js";
import { model } from "./model.js";

const panel = document.getElementById("strips"), tools = document.getElementById("strips-tools");
const DASHES = [[], [7, 4], [2, 3], [9, 3, 2, 3], [12, 4], [1, 4]];
const view = { span_s: 600, held_s: null, pointer: null };
let known = null, strips = [];
const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

tools.addEventListener("click", (event) => {
  const button = event.target.closest("button");
  if (!button) return;
  if (button.dataset.span) view.span_s = Number(button.dataset.span);
  if (button.dataset.do === "hold") view.held_s = view.held_s === null ? (model.samples.at(-1)?.[0] ?? null) : null;
  for (const one of tools.querySelectorAll("button")) one.classList.toggle("on", one.dataset.span ? Number(one.dataset.span) === view.span_s : view.held_s !== null);
  draw();
});

function make() {
  const groups = new Map();
  model.hello.series.forEach((series, i) => groups.set(series.strip, [...(groups.get(series.strip) ?? []), { ...series, i }]));
  strips = [...groups].map(([title, series]) => {
    const canvas = html("canvas", { role: "img", "aria-label": title });
    const values = series.map((one, n) => html("span", { class: "live" }, ""));
    const unit = series[0].unit;
    const head = html("div", { class: "head" }, html("b", {}, unit ? `${title}, ${unit}` : title), ...values);
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      view.span_s = Math.min(600, Math.max(10, view.span_s * Math.exp(event.deltaY * 0.002)));
      draw();
    }, { passive: false });
    canvas.addEventListener("pointermove", (event) => { view.pointer = event.offsetX / canvas.clientWidth; draw(); });
    canvas.addEventListener("pointerleave", () => { view.pointer = null; draw(); });
    const element = html("section", { class: "strip", "data-strip": title }, head, canvas);
    return { title, series, canvas, values, element, unit };
  });
  panel.replaceChildren(...strips.map((strip) => strip.element));
}

export function draw() {
  if (!model.hello) return;
  if (known !== model.hello) { known = model.hello; make(); }
  if (panel.getBoundingClientRect().width === 0) return;
  const to = view.held_s ?? model.samples.at(-1)?.[0] ?? 0, begun = model.samples[0]?.[0] ?? 0;
  const from = Math.min(to - Math.min(60, view.span_s), Math.max(to - view.span_s, begun)); // no empty minutes at the start
  let first = 0, last = model.samples.length;
  while (first < last && model.samples[first][0] < from) first++;
  while (last > first && model.samples[last - 1][0] > to) last--;
  const part = model.samples.slice(Math.max(0, first - 1), last);
  for (const strip of strips) {
    strip.filled ||= part.some(([, sample]) => strip.series.some(({ i }) => sample[i] !== null && sample[i] !== undefined));
    strip.element.hidden = !strip.filled; // a boat without that sensor, or a log without it
    if (strip.filled) plot(strip, part, from, to);
  }
}

const COLOURS = ["--s0", "--s1", "--s2", "--s3"];

function plot({ title, series, canvas, values, unit }, samples, from, to) {
  const ratio = window.devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight;
  if (canvas.width !== Math.round(w * ratio) || canvas.height !== Math.round(h * ratio)) [canvas.width, canvas.height] = [Math.round(w * ratio), Math.round(h * ratio)];
  const c = canvas.getContext("2d");
  c.setTransform(ratio, 0, 0, ratio, 0, 0);
  c.clearRect(0, 0, w, h);
  let low = Infinity, high = -Infinity;
  for (const [, sample] of samples) for (const { i } of series) if (sample[i] !== null && sample[i] !== undefined) { low = Math.min(low, sample[i]); high = Math.max(high, sample[i]); }
  if (title.startsWith("Innovation")) { low = 0; high = Math.max(1.1, Math.min(high, 3)); }
  if (low > high) { [low, high] = [0, 1]; }
  const least = { "m": 0.05, "°": 1, "m/s": 0.1, "%": 10, "V": 0.5 }[unit] ?? 0.5;
  if (high - low < least) [low, high] = [(low + high - least) / 2, (low + high + least) / 2];
  if (low < 0.3 * high && low > 0) low = 0;
  const left = 44, bottom = h - 15, x = (t) => left + ((t - from) / (to - from)) * (w - left - 4), y = (v) => 5 + ((high - v) / (high - low)) * (bottom - 8);
  grid(c, { w, left, bottom, from, to, low, high, x, y });
  if (title.startsWith("Innovation")) gateLine(c, left, w, y(1));
  series.forEach(({ i, name }, n) => {
    c.strokeStyle = style(COLOURS[n % COLOURS.length]);
    c.setLineDash(DASHES[n % DASHES.length]);
    c.lineWidth = 1.6;
    c.save();
    c.beginPath();
    c.rect(left, 0, w - left, bottom);
    c.clip();
    c.beginPath();
    let down = false, before = -Infinity;
    for (const [t, sample] of samples) {
      const v = sample[i];
      if (v === null || v === undefined || t - before > 3) down = false;
      before = t;
      if (v === null || v === undefined) continue;
      if (down) c.lineTo(x(t), y(v)); else c.moveTo(x(t), y(v));
      down = true;
    }
    c.stroke();
    c.restore();
    const at = view.pointer === null ? to : from + (to - from) * Math.max(0, (view.pointer * w - left) / (w - left - 4));
    const shown = samples.findLast(([t]) => t <= at + 1e-6)?.[1][i];
    values[n].style.color = c.strokeStyle;
    say(values[n], `${["━", "╍", "┅", "┉"][n % 4]} ${name.replaceAll("_", " ")} ${number(shown, unit === "%" ? 0 : 2)}`);
  });
  c.setLineDash([]);
  if (view.pointer !== null) { c.fillStyle = style("--faint"); c.fillRect(view.pointer * w, 0, 1, bottom); }
}

function grid(c, { w, left, bottom, from, to, low, high, x, y }) {
  c.setLineDash([]);
  c.strokeStyle = style("--grid");
  c.fillStyle = style("--faint");
  c.font = "10.5px system-ui, sans-serif";
  c.lineWidth = 1;
  c.textAlign = "right";
  c.textBaseline = "middle";
  const step = nice((high - low) / 4);
  for (let v = Math.ceil(low / step) * step; v <= high + 1e-9; v += step) {
    c.beginPath(); c.moveTo(left, y(v)); c.lineTo(w, y(v)); c.stroke();
    if (y(v) < bottom - 3) c.fillText(number(v, Math.max(0, Math.ceil(-Math.log10(step) - 1e-9))), left - 5, Math.max(6, y(v)));
  }
  const every = [1, 2, 5, 10, 20, 30, 60, 120].find((s) => ((w - left) * s) / (to - from) > 62) ?? 120;
  c.textAlign = "center";
  c.textBaseline = "alphabetic";
  for (let back = 0; back <= to - from; back += every) {
    const at = x(to - back);
    c.beginPath(); c.moveTo(at, 0); c.lineTo(at, bottom); c.stroke();
    if (at > left + 14 && at < w - 16) c.fillText(back >= 60 ? `−${+(back / 60).toFixed(1)} min` : `−${back} s`, at, bottom + 12);
  }
}

function gateLine(c, left, w, at) {
  c.strokeStyle = style("--alarm");
  c.setLineDash([6, 4]);
  c.lineWidth = 1.2;
  c.beginPath(); c.moveTo(left, at); c.lineTo(w, at); c.stroke();
  c.fillStyle = style("--alarm");
  c.textAlign = "left";
  c.textBaseline = "bottom";
  c.fillText("gate", left + 4, at - 2);
}

function nice(rough) {
  const power = 10 ** Math.floor(Math.log10(rough));
  return [1, 2, 5, 10].map((n) => n * power).find((n) => n >= rough) ?? power;
}

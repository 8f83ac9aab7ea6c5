// The time line of a log: play, speed, seek, jump to an event.
import { html, number, say } from "./draw.js";
import { model } from "./model.js";
import { tone } from "./state.js";

const at = (id) => document.getElementById(id);
const SEEK_MS = 300;
let send = () => {}, known = null, sliding = false, sought_ms = 0;

export function connect(sender) { send = sender; }

at("play").addEventListener("click", () => toggle());
at("speed").addEventListener("change", (event) => send({ speed: Number(event.target.value) }));
at("slide").addEventListener("input", (event) => { sliding = true; seek(event.target, SEEK_MS); });
at("slide").addEventListener("change", (event) => { sliding = false; seek(event.target, 0); });
at("jump").addEventListener("change", (event) => { if (event.target.value) send({ t_s: Number(event.target.value) }); event.target.selectedIndex = 0; });

/** The console makes ten minutes of strips for each place: while the slider moves, not for every pixel. */
function seek(slide, apart_ms) {
  if (performance.now() - sought_ms < apart_ms) return;
  sought_ms = performance.now();
  send({ t_s: Number(slide.value) });
}

export function toggle() {
  const playing = model.tick?.replay?.playing;
  if (playing !== undefined) send({ playing: !playing });
}

/** Seconds as minutes and hours. */
function clock(t_s) {
  const s = Math.max(0, t_s), h = Math.floor(s / 3600), m = Math.floor((s % 3600) / 60);
  return `${h ? `${h}:` : ""}${String(m).padStart(2, "0")}:${(s % 60).toFixed(1).padStart(4, "0")}`;
}

export function draw() {
  const recording = model.recording, tick = model.tick;
  if (!recording || !tick?.replay) return;
  if (known !== recording) {
    known = recording;
    at("replay").hidden = false;
    Object.assign(at("slide"), { min: recording.from_s, max: recording.to_s });
    const span = recording.to_s - recording.from_s || 1;
    at("marks").replaceChildren(...recording.events.map((e) => {
      const mark = html("i", { class: tone(e.severity), title: e.text });
      mark.style.left = `${(100 * (e.t_s - recording.from_s)) / span}%`;
      return mark;
    }));
    at("jump").append(...recording.events.map((e) => html("option", { value: e.t_s }, `${number(e.t_s, 1, "s")}  ${e.text}`)));
  }
  if (!sliding) at("slide").value = tick.replay.t_s;
  say(at("play"), tick.replay.playing ? "Pause" : "Play");
  at("speed").value = String(tick.replay.speed);
  say(at("at"), `${clock(tick.replay.t_s - recording.from_s)} of ${clock(recording.to_s - recording.from_s)}`);
}

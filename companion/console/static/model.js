// What the page knows: the newest message of each kind, the trail and the strips' samples. Views read it, main.js writes.
export const model = {
  hello: null, boat: null, tick: null, capability: null, recording: null, link: null,
  events: [], trail: [], leaderTrail: [], samples: [], heard_ms: -Infinity, late_ms: 0, spoke_ms: 0, beat: null, delays_ms: [], drawn: 0,
};

export const row = () => model.tick?.row ?? null;
export const more = () => model.tick?.more ?? {};
export const config = () => model.hello?.configuration ?? null;
export const parameters = () => model.boat?.parameters ?? {};
export const frame = () => model.boat?.frame ?? (config() ? { lat_deg: config().home.lat_deg, lon_deg: config().home.lon_deg } : null);

const TRAIL_M = 0.02, MOST_TRAIL = 4000, KEPT_S = 600;

export function take(message) {
  switch (message.kind) {
    case "hello":
      Object.assign(model, { hello: message, boat: null, tick: null, capability: null, trail: [], leaderTrail: [], samples: [] });
      if (!message.console.replay) model.events = [];
      break;
    case "boat": model.boat = message; break;
    case "capability": model.capability = message.from_rad ? message : null; break;
    case "recording": model.recording = message; model.events = message.events; break;
    case "link": model.link = message; break;
    case "beat":
      model.beat = { at_s: message.at_s, got_ms: performance.now() };
      model.late_ms = 500 * message.round_s; // half the way there and back
      break;
    case "history":
      model.trail = message.trail.filter((p) => p[0] !== null);
      model.samples = message.t_s.map((t, i) => [t, message.values[i]]);
      break;
    case "event":
      model.events.push(message);
      if (model.events.length > 500) model.events.shift();
      break;
    case "tick": takeTick(message); break;
  }
}

function takeTick(message) {
  const before = model.tick?.row.t_s;
  model.tick = message;
  model.heard_ms = performance.now() - 1000 * (message.age_s ?? 0);
  const { t_s, north_m, east_m } = message.row;
  if (before === t_s) return;
  const last = model.trail.at(-1);
  if (!last || Math.hypot(last[0] - north_m, last[1] - east_m) > TRAIL_M) model.trail.push([north_m, east_m]);
  if (model.trail.length > MOST_TRAIL) model.trail.splice(0, MOST_TRAIL / 4);
  if (message.sample) {
    model.samples.push([t_s, message.sample]);
    while (model.samples.length && model.samples[0][0] < t_s - KEPT_S) model.samples.shift();
  }
  const leader = message.more?.leader;
  if (leader) {
    model.leaderTrail.push([leader.north_m, leader.east_m]);
    if (model.leaderTrail.length > 1200) model.leaderTrail.splice(0, 300);
  }
}

// --- places --------------------------------------------------------------------------------------------------------

const A = 6378137, E2 = 0.00669437999014;

/** Metres for a degree of latitude and of longitude at a latitude: good to millimetres on the few kilometres drawn. */
function perDegree(lat_deg) {
  const lat = (lat_deg * Math.PI) / 180, w2 = 1 - E2 * Math.sin(lat) ** 2, w = Math.sqrt(w2);
  const k = Math.PI / 180;
  return [(k * A * (1 - E2)) / (w2 * w), (k * A * Math.cos(lat)) / w];
}

export function toNed(lat_deg, lon_deg) {
  const f = frame();
  const [ns, ew] = perDegree((f.lat_deg + lat_deg) / 2);
  return [(lat_deg - f.lat_deg) * ns, (lon_deg - f.lon_deg) * ew];
}

export function toGeodetic(north_m, east_m) {
  const f = frame();
  let lat = f.lat_deg + north_m / perDegree(f.lat_deg)[0];
  for (let i = 0; i < 2; i++) lat = f.lat_deg + north_m / perDegree((f.lat_deg + lat) / 2)[0];
  return [lat, f.lon_deg + east_m / perDegree((f.lat_deg + lat) / 2)[1]];
}

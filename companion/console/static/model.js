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
    case "capability": model.capability = message; break;
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

const A = 6378137, E2 = 0.00669437999014, RAD = Math.PI / 180;

/** A longitude from −180° to 180°. */
export const turned = (lon_deg) => lon_deg - 360 * Math.round(lon_deg / 360);

function plane(lat_deg, lon_deg, f) {
  const lat0 = f.lat_deg * RAD, lat = lat_deg * RAD, dlon = turned(lon_deg - f.lon_deg) * RAD, sine = Math.sin(lat);
  const w2 = 1 - E2 * Math.sin((lat0 + lat) / 2) ** 2;
  const meridian = (A * (1 - E2)) / (w2 * Math.sqrt(w2)), vertical = A / Math.sqrt(1 - E2 * sine ** 2);
  const east = vertical * Math.cos(lat) * dlon;
  return [meridian * (lat - lat0) + 0.5 * east * dlon * sine, east - (east * dlon * dlon * sine ** 2) / 6];
}

/** As the boat reckons it (`core/geodesy.py`): a point that is picked must be the one to which it goes. */
export const toNed = (lat_deg, lon_deg) => plane(lat_deg, lon_deg, frame());

/** The inverse of `toNed`. */
export function toGeodetic(north_m, east_m) {
  const f = frame(), lat0 = f.lat_deg * RAD, w2 = 1 - E2 * Math.sin(lat0) ** 2;
  const meridian = (A * (1 - E2)) / (w2 * Math.sqrt(w2)), vertical = A / Math.sqrt(w2);
  let lat = lat0 + north_m / meridian, dlon = east_m / (vertical * Math.cos(lat0));
  for (let i = 0; i < 3; i++) {
    const [north, east] = plane(lat / RAD, f.lon_deg + dlon / RAD, f);
    lat += (north_m - north) / meridian;
    dlon += (east_m - east) / (vertical * Math.cos(lat));
  }
  return [lat / RAD, turned(f.lon_deg + dlon / RAD)];
}

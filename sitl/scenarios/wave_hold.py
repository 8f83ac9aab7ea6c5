"""Station keeping in a sea state, on either beam or bow on: what waves take of accuracy and thrust, and where the boat
loses its place."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from companion.core.angles import wrap_pi
from sitl.gusts import parse_wind
from sitl.scenarios.boat import sideways
from sitl.scenarios.four_corner import SETTLE_S, thrusters_of
from sitl.scenarios.ground_station import BACK_S, GroundStation
from sitl.scenarios.measure import Check, Track, between, distance_to, means, read_truth, rms
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import Scenario, ScenarioError, Settings, number
from sitl.sea_state import parse_sea

_FROM_RAD = math.radians(90.0)  # of a sea or wind without a direction
_LOOK_S = 1.0
_MEAN_S = 10.0  # motion slower than that is the controller's affair
_LOST_LENGTHS = 1.0  # distance in boat lengths beyond which the place counts as lost
_THERE_LENGTHS = 0.5  # so near must the boat be before it is judged


def _from_rad(settings: Settings) -> float:
    """Where the sea comes from; where none is set, the wind."""
    state = parse_sea(settings["waves"])
    if state is None:
        found = parse_wind(settings["wind"])[1] if settings["wind"] else None
        return _FROM_RAD if found is None else found
    return _FROM_RAD if state.from_rad is None else state.from_rad


def _yaw_rad(settings: Settings) -> float:
    """The heading that is held. Raises ScenarioError."""
    from_rad = _from_rad(settings)
    turned = {"beam": -0.5 * math.pi, "port": 0.5 * math.pi, "bow": 0.0}.get(settings["heading"])
    if turned is None:
        raise ScenarioError(f"heading={settings['heading']}: beam (from starboard), port (from there) or bow")
    return wrap_pi(from_rad + turned)


def prepare(conditions: Conditions, settings: Settings) -> Conditions:
    """At home with the heading that is to be held, in waves or wind of a known direction."""
    from_deg = f"@{math.degrees(_from_rad(settings)):g}"
    waves, wind = settings["waves"], settings["wind"]
    if waves and "@" not in waves:
        waves = from_deg.join(_parted(waves))
    if not waves and wind and "@" not in wind:
        wind = from_deg.join(_parted(wind))
    start = (0.0, 0.0, _yaw_rad(settings))
    return replace(conditions, waves=waves or None, wind=wind or None, start=start)


def _parted(text: str) -> tuple[str, str]:
    """What stands before and behind the place of a direction."""
    size, slash, rest = text.partition("/")
    return size, slash + rest


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Hold at home with that heading for the setting `time`, after settling, and once the boat is there: weather has
    driven it off while it was not armed yet."""
    config, yaw_rad = gcs.rig.config, _yaw_rad(settings)
    gcs.ready()
    gcs.set_mode(0x03040000)
    gcs.arm()
    gcs.reposition(config.home.lat_deg, config.home.lon_deg, yaw_rad)
    begin_s = gcs.rig.now_s
    gcs.sail(SETTLE_S)
    while _off_m(gcs) > _THERE_LENGTHS * config.length_m and gcs.rig.now_s < begin_s + SETTLE_S + BACK_S:
        gcs.sail(_LOOK_S)
    from_s = gcs.rig.now_s
    gcs.sail(number(settings, "time"))
    return {
        "begin_s": begin_s, "from_s": from_s, "to_s": gcs.rig.now_s, "yaw_rad": yaw_rad, "length_m": config.length_m,
        "thrusters": thrusters_of(config),
    }  # fmt: skip


def _off_m(gcs: GroundStation) -> float:
    truth = gcs.rig.world.truth
    return math.hypot(truth.north_m, truth.east_m)


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """By the truth: position with and without the first-order motion, heading, the mean force of the thrusters together
    (`used_n`), and their mean share of full force."""
    track = between(read_truth(folder), asked["from_s"], asked["to_s"])
    slow = _slow(track)
    headings = [math.degrees(wrap_pi(row["yaw_rad"] - asked["yaw_rad"])) for row in track]
    used = [_net(row, asked) for row in track]
    given = [sum(abs(row[f"{thruster.name}_force_n"]) for thruster in asked["thrusters"]) for row in track]
    slow_max_m = max(math.hypot(*place) for place in slow)
    metrics = {
        "position_rms_m": rms([distance_to(row, 0.0, 0.0) for row in track]),
        "slow_rms_m": rms([math.hypot(*place) for place in slow]),
        "slow_max_m": slow_max_m,
        "heading_rms_deg": rms(headings),
        "used_n": math.hypot(*(sum(axis) / len(used) for axis in zip(*used, strict=True))),
        "thrust_percent": 100.0 * sum(given) / len(given) / sum(thruster.full_n for thruster in asked["thrusters"]),
        "there_s": asked["from_s"] - asked["begin_s"],
        "kept": float(slow_max_m <= _LOST_LENGTHS * asked["length_m"]),
    }
    limit_m = _LOST_LENGTHS * asked["length_m"]
    return metrics, (Check("position without first-order motion, largest", slow_max_m, limit_m, "m"),)


def _slow(track: Track) -> list[tuple[float, float]]:
    """Place as its mean over `_MEAN_S`."""
    width = max(1, round(_MEAN_S * (len(track) - 1) / (track[-1]["t_s"] - track[0]["t_s"])))
    north, east = (means([row[axis] for row in track], width) for axis in ("north_m", "east_m"))
    return list(zip(north, east, strict=True))


def _net(row: dict[str, float], asked: dict[str, Any]) -> tuple[float, float]:
    """Force of all thrusters ahead and to starboard."""
    pairs = [(row[f"{thruster.name}_force_n"], row[f"{thruster.name}_azimuth_rad"]) for thruster in asked["thrusters"]]
    return sum(n * math.cos(a) for n, a in pairs), sum(n * math.sin(a) for n, a in pairs)


SCENARIO = Scenario(
    name="wave_hold",
    text="300 s of station keeping in a sea state, with (`drift=on`) or without its drift force",
    vessel="revolt",
    defaults={
        "waves": "0.1", "heading": "beam", "drift": "on", "time": "300", "wind": "", "current": "", "gnss": "rtk",
        "model_error": "", "windage_error": "", "plant": "",
    },
    needs=(sideways,),
    sail=sail,
    measure=measure,
    prepare=prepare,
    lasts_s=330.0,
)  # fmt: skip

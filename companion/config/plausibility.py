"""What a vessel's file says that a real boat would hardly be, and what that means for its modes."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from companion.config.dimensions.derivation import top_speed_mps
from companion.config.dimensions.form import GRAVITY_MPS2
from companion.config.dimensions.motors import find
from companion.config.dimensions.receivers import grade_of
from companion.config.hull import humps, usual_damping
from companion.config.kinds import Place
from companion.config.sensor_checks import baseline_m
from companion.config.sensors import SENSORS
from companion.config.top_speed import steady_speed_mps
from companion.config.vessel import VesselConfig

_UNLIKE = 3.0  # times the weaker one of a pair: other propellers or motors differ by less
_MOST_MPS2, _LEAST_MPS2 = 10.0, 0.03  # thrust over mass: a speedboat's, and one that wind carries off
_OVER_HULL_SPEED = 2.5
_WIDE = 1.2  # beam over length
_OVERVOLTED = 1.5  # times the highest voltage in the table of motors
_OUTSIDE = 1.1  # of half the length or beam
_ASIDE_M = 0.01  # a smaller place is in the middle
_CRUISE_MPS = 1.0
_OVER_STEADY = 1.05  # less is rounding
_WIDE_TURN = 10.0  # lengths across: twice the 5 that ships may take (IMO MSC.137(76))
_USUAL_DEG = (30.0, 45.0, 60.0, 90.0, 120.0, 135.0, 150.0, 180.0)  # directions of fixed thrusters
_SLOW_DPS = 4.0  # slower than drives turn; in radians 0.07 to 4 are usual
_PLANES_MOST = 12.0  # times the hull speed: faster than boats plane; in km/h or knots 15 m/s is usual there
_CRAWL = 0.2  # of the hull speed: slower than any boat's top speed
_GYRATION = (0.1, 0.5)  # of the length: a rod has 0.29, a hull with its water 0.2 to 0.3
_OVERHANG = 0.75  # of length and beam, from the middle: on a bowsprit or an outrigger
_LIGHTER = 0.98  # of the mass: less is not rounding
_MASTS = 3.0  # lengths, and 2 m: higher than any mast
_NUMBERED = re.compile(r"/dev/tty(USB|ACM)\d+")
_LONG_S = 60.0  # of silence: no device that is well is silent for so long
_MOST_AH = 1000.0  # more than a boat without a crew carries
DOCK_WITHIN_M = 0.2
"""Default of DOCK_POS_ACC."""
_SBAS_M = 0.3  # one sigma of a receiver without RTK
_PAIR_RAD = math.radians(3.0)  # one sigma of a compass


@dataclass(frozen=True, slots=True)
class Judgement:
    """One finding: the place in the file, what is wrong with it, and what it means for the modes."""

    place: Place
    text: str
    means: str

    def __str__(self) -> str:
        return f"{self.text}. {self.means}"


def judgements(config: VesselConfig) -> list[Judgement]:
    """All findings. Empty for a plausible boat that can do every mode."""
    return [found for judge in _JUDGES for found in judge(config)]


def _damping(config: VesselConfig) -> Iterator[Judgement]:
    d = config.hull.damping
    for axis, terms, means in (
        ("x_u", (d.x_u, d.x_uu, d.x_uuu, *config.hull.resistance), "Missions and Follow: no top speed is known"),
        ("y_v", (d.y_v, d.y_vv, d.y_uv), "No current can be estimated: Missions drift off in a cross current"),
        ("n_r", (d.n_r, d.n_rr, d.n_ur), "All modes: the bow swings, since the model takes its own turn as free"),
    ):
        if not any(terms):
            text = f"no damping of {'surge' if axis[0] == 'x' else 'sway' if axis[0] == 'y' else 'yaw'}"
            yield Judgement(("hull", "damping", axis), text, means)


def _driven_on(config: VesselConfig) -> Iterator[Judgement]:
    """Terms with the speed ahead that outweigh the others at half the hull speed, as the boat slides or turns."""
    d = config.hull.damping
    ahead_mps, others = usual_damping(config.hull, config.length_m)
    for key, factor, other, axis in (("y_uv", d.y_uv, "y_v", "sway"), ("n_ur", d.n_ur, "n_r", "yaw")):
        if factor * ahead_mps + others[other] < 0.0 <= others[other]:
            yield Judgement(
                ("hull", "damping", key),
                f"{key} = {factor:g}: at {ahead_mps:.1f} m/s the damping of {axis} drives the boat on",
                "All modes: it swings under way. Positive is what resists: check the sign",
            )


def _pairs(config: VesselConfig) -> Iterator[Judgement]:
    """Two thrusters opposite each other that push by far not alike."""
    for i, one in enumerate(config.thrusters):
        for other in config.thrusters[:i]:
            beside = abs(one.x_m - other.x_m) < _ASIDE_M and abs(one.y_m) > _ASIDE_M
            opposite = beside and abs(one.y_m + other.y_m) < _ASIDE_M
            weak, strong = sorted((one, other), key=lambda thruster: thruster.max_n)
            if opposite and one.kind == other.kind and _UNLIKE * weak.max_n < strong.max_n:
                yield Judgement(
                    ("thruster", config.thrusters.index(weak), "max_n"),
                    f"'{weak.name}' pushes with {weak.max_n:g} N, '{strong.name}' opposite with {strong.max_n:g} N: "
                    "check both, in N",
                    "All modes: straight ahead the boat has twice the weaker one",
                )


def _inertia(config: VesselConfig) -> Iterator[Judgement]:
    """What no hull of that mass and length can have."""
    hull = config.hull
    for key in ("m11_kg", "m22_kg"):
        value_kg = getattr(hull, key)
        if hull.mass_kg is not None and value_kg < _LIGHTER * hull.mass_kg:
            yield Judgement(
                ("hull", key),
                f"{value_kg:g} kg are less than mass_kg, {hull.mass_kg:g} kg: it is the mass and the water with it",
                "All modes: thrust moves the boat less than the model says",
            )
    gyration_m = math.sqrt(hull.m33_kgm2 / hull.m22_kg)
    least, most = (share * config.length_m for share in _GYRATION)
    if not least <= gyration_m <= most:
        yield Judgement(
            ("hull", "m33_kgm2"),
            f"{hull.m33_kgm2:g} kg m² for {hull.m22_kg:g} kg sideways are a radius of {gyration_m:.2g} m, usual are "
            f"{least:.2g} to {most:.2g} m: check both",
            "All modes: the bow swings, or turns late",
        )


def _thrust(config: VesselConfig) -> Iterator[Judgement]:
    share = config.limits.surge_n / config.hull.m11_kg
    if share > _MOST_MPS2:
        yield Judgement(
            ("limits", "surge_n"),
            f"thrust of {share:.1f} m/s² for its mass: check mass in kg, thrust in N",
            "Hold and Manual: every small error is a leap",
        )
    if share < _LEAST_MPS2:
        yield Judgement(
            ("limits", "surge_n"),
            f"thrust of only {share:.3f} m/s² for its mass",
            "Hold, Missions and RTL: wind and current are stronger than the boat",
        )


def _sides(config: VesselConfig) -> Iterator[Judgement]:
    """Names that contradict the signs of a place, and thrusters ahead that only turn the boat."""
    for i, thruster in enumerate(config.thrusters):
        words = thruster.name.split("_")
        for word, key, value, side in (
            ("port", "y_m", -thruster.y_m, "y_m is positive to starboard"),
            ("starboard", "y_m", thruster.y_m, "y_m is positive to starboard"),
            ("bow", "x_m", thruster.x_m, "x_m is positive ahead of the middle of the boat"),
            ("stern", "x_m", -thruster.x_m, "x_m is positive ahead of the middle of the boat"),
        ):
            if word in words and value < -_ASIDE_M:
                yield Judgement(
                    ("thruster", i, key),
                    f"'{thruster.name}' has {key} = {getattr(thruster, key):g}: {side}",
                    "All modes: the boat turns the wrong way. Change the sign, or the name",
                )
    fixed = [t.y_m for t in config.thrusters if not t.turns and math.cos(t.azimuth_rad) > 0.5]
    if len(fixed) == len(config.thrusters) > 1 and (min(fixed) > 0.0 or max(fixed) < 0.0):
        yield Judgement(
            ("thruster", 0, "y_m"),
            "all thrusters lie on the same side: the boat cannot go straight ahead",
            "All modes: it turns in circles. Check the signs: y_m is negative to port",
        )


def _radians(config: VesselConfig) -> Iterator[Judgement]:
    for i, thruster in enumerate(config.thrusters):
        degrees = math.degrees(thruster.azimuth_rad)
        if any(math.isclose(abs(degrees), math.radians(usual), rel_tol=0.01) for usual in _USUAL_DEG):
            yield Judgement(
                ("thruster", i, "azimuth_deg"),
                f"'{thruster.name}' points {degrees:.4g}° from ahead, which looks like radians: 90 is to starboard",
                "All modes: its thrust goes another way",
            )


def _turns(config: VesselConfig) -> Iterator[Judgement]:
    for i, thruster in enumerate(config.thrusters):
        stops = [stop for stop in (thruster.azimuth_min_rad, thruster.azimuth_max_rad) if stop is not None]
        most_deg = math.degrees(max(map(abs, stops), default=math.tau))
        if thruster.turns and most_deg <= math.pi:
            yield Judgement(
                ("thruster", i, "azimuth_max_deg"),
                f"'{thruster.name}' turns {most_deg:.3g}° at most, which looks like radians",
                "All modes: the boat hardly turns. Give the stops in degrees",
            )
        rate_dps = math.degrees(thruster.azimuth_rate_radps)
        if thruster.turns and 0.0 < rate_dps < _SLOW_DPS:
            yield Judgement(
                ("thruster", i, "azimuth_rate_dps"),
                f"'{thruster.name}' turns {rate_dps:.3g}° in a second, which looks like radians",
                "All modes: every turn begins late, and the boat swings. Give the rate in degrees a second",
            )


def _speed(config: VesselConfig) -> Iterator[Judgement]:
    top_mps = top_speed_mps(config.hull, config.limits.surge_n)
    hull_mps = math.sqrt(GRAVITY_MPS2 * config.length_m / math.tau)
    given_mps = config.hull.top_speed_mps
    if given_mps is not None and given_mps < _CRAWL * hull_mps:
        yield Judgement(
            ("hull", "top_speed_mps"),
            f"{given_mps:g} m/s are {given_mps / hull_mps:.2f} times the hull speed: check it, in m/s",
            "All modes: the model takes the water for much thicker than it is",
        )
    if config.hull.resistance and given_mps is not None and given_mps > _PLANES_MOST * hull_mps:
        yield Judgement(
            ("hull", "top_speed_mps"),
            f"{given_mps:g} m/s is faster than a boat of {config.length_m:g} m planes: check it, in m/s; "
            f"{given_mps:g} km/h are {given_mps / 3.6:.1f} m/s, {given_mps:g} knots {given_mps * 0.5144:.1f} m/s",
            "Missions and RTL: planned for a faster boat",
        )
    if (
        not config.hull.resistance
        and config.hull.damping.x_u >= 0.0
        and hull_mps * _OVER_HULL_SPEED < top_mps < math.inf
    ):
        if given_mps is not None:
            yield Judgement(
                ("hull", "top_speed_mps"),
                f"{given_mps:g} m/s are {given_mps / hull_mps:.1f} times the hull speed: check it, in m/s; "
                f"{given_mps:g} km/h are {given_mps / 3.6:.1f} m/s, {given_mps:g} knots {given_mps * 0.5144:.1f} m/s",
                'Missions and RTL: planned for a faster boat. A hull that planes has form = "planing"',
            )
            return
        yield Judgement(
            ("hull", "damping", "x_uu"),
            f"top speed {top_mps:.1f} m/s by the model, {top_mps / hull_mps:.1f} times the hull speed",
            'Missions: legs take longer than planned. A hull that planes has form = "planing" or a resistance table',
        )


def _planing(config: VesselConfig) -> Iterator[Judgement]:
    table = config.hull.resistance
    hump = next(iter(humps(table)), None)
    top_mps = top_speed_mps(config.hull, config.limits.surge_n)
    if hump is not None and top_mps < hump[0]:
        yield Judgement(
            ("hull", "top_speed_mps"),
            f"does not plane: top speed {top_mps:.1f} m/s by the model, its hump is at {hump[0]:.1f} m/s",
            "Missions, RTL and Follow: planned for a slow boat. If it planes, give its top_speed_mps",
        )


def _shape(config: VesselConfig) -> Iterator[Judgement]:
    if config.beam_m > _WIDE * config.length_m:
        yield Judgement(
            ("beam_m",),
            f"{config.beam_m:g} m wide and {config.length_m:g} m long: length is fore and aft",
            "All modes: speed, turns and drift are those of a boat that goes sideways",
        )


def _volts(config: VesselConfig) -> Iterator[Judgement]:
    for i, thruster in enumerate(config.thrusters):
        motor = find(thruster.motor) if thruster.motor is not None else None
        if motor is None or thruster.voltage_v is None:
            continue
        most_v = motor.thrust[-1][0]
        if thruster.voltage_v > _OVERVOLTED * most_v:
            yield Judgement(
                ("thruster", i, "voltage_v"),
                f"{thruster.voltage_v:g} V at a motor whose thrust is known up to {most_v:g} V: check it, in V",
                "All modes: the thrust is extrapolated, and the motor may not stand it",
            )


def _battery(config: VesselConfig) -> Iterator[Judgement]:
    """Labels are in mAh, meters in mΩ."""
    battery = config.battery
    if battery is None:
        return
    ah, ohm = battery.capacity_ah, battery.resistance_ohm
    if ah > _MOST_AH:
        yield Judgement(
            ("battery", "capacity_ah"),
            f"{ah:g} Ah: check it, in Ah; {ah:g} mAh are {ah / 1000.0:g} Ah",
            "All modes: the charge that is counted hardly falls, so no warning and no failsafe of the battery comes",
        )
    elif ohm * ah > battery.full_v:  # it would not give its charge within an hour, even shorted
        yield Judgement(
            ("battery", "resistance_ohm"),
            f"{ohm:g} Ω let {battery.full_v / ohm:.2g} A through at most: check it, in Ω; {ohm:g} mΩ are "
            f"{ohm / 1000.0:g} Ω",
            "All modes: the battery counts as full at the start, however empty it is",
        )


def _turning(config: VesselConfig) -> Iterator[Judgement]:
    d, moment_nm = config.hull.damping, config.limits.yaw_nm
    linear = d.n_r + d.n_ur * _CRUISE_MPS
    if d.n_rr > 0.0:
        rate_radps = (math.sqrt(linear * linear + 4.0 * d.n_rr * moment_nm) - linear) / (2.0 * d.n_rr)
    else:
        rate_radps = moment_nm / linear if linear > 0.0 else math.inf
    across_m = 2.0 * _CRUISE_MPS / rate_radps
    if across_m < 0.25 * config.length_m:
        yield Judgement(
            ("hull", "damping", "n_rr"),
            f"a turning circle of {across_m:.1f} m at 1 m/s, far under the hull's length",
            "Missions and Follow: the model turns faster than the boat will, and bends are cut",
        )


def _wide_turns(config: VesselConfig) -> Iterator[Judgement]:
    """A jet neither brakes nor turns on the spot: what its nozzle gives at cruise is how it turns."""
    cruise_mps = config.parameters.get("WP_SPEED")
    if cruise_mps is None or not any(thruster.kind == "jet" for thruster in config.thrusters):
        return
    d = config.hull.damping
    linear = d.n_r + d.n_ur * cruise_mps
    root = math.sqrt(max(0.0, linear * linear + 4.0 * d.n_rr * config.limits.yaw_nm))
    across_m = cruise_mps * (root + linear) / config.limits.yaw_nm  # 2 U / r
    if across_m > _WIDE_TURN * config.length_m:
        yield Judgement(
            ("limits", "yaw_nm"),
            f"a turning circle of {across_m:.0f} m at {cruise_mps:.1f} m/s by its nozzle, "
            f"{across_m / config.length_m:.0f} lengths",
            "Missions, RTL and Follow: it swings as wide at corners. Plan for that room, or measure yaw_nm and damping",
        )


def _course(config: VesselConfig) -> Iterator[Judgement]:
    """A hull that leaves its course by itself. Speeds that follow from the dimensions keep within what it can."""
    speed_mps = config.parameters.get("WP_SPEED")
    steady = steady_speed_mps(config)
    if speed_mps is not None and speed_mps > _OVER_STEADY * steady:
        yield Judgement(
            ("parameters", "WP_SPEED"),
            f"{speed_mps:g} m/s: beyond {steady:.2f} m/s the hull leaves its course faster than the thrusters can turn "
            "it back, by the model",
            f"Missions, RTL and Follow: it weaves. Set WP_SPEED to {steady:.2f}, or give it fins or stronger thrusters",
        )


def _places(config: VesselConfig) -> Iterator[Judgement]:
    most_x_m, most_y_m = 0.5 * _OUTSIDE * config.length_m + 0.1, 0.5 * _OUTSIDE * config.beam_m
    for i, thruster in enumerate(config.thrusters):
        if abs(thruster.x_m) > most_x_m or abs(thruster.y_m) > most_y_m:
            yield Judgement(
                ("thruster", i, "x_m"),
                f"'{thruster.name}' at x {thruster.x_m:g} m, y {thruster.y_m:g} m is outside the hull",
                "All modes: its lever is wrong, and so is every turn",
            )
    for i, sensor in enumerate(config.sensors):
        if abs(sensor.x_m) > _OVERHANG * config.length_m or abs(sensor.y_m) > _OVERHANG * config.beam_m + _ASIDE_M:
            yield Judgement(
                ("sensor", i, "x_m"),
                f"'{sensor.name}' at x {sensor.x_m:g} m, y {sensor.y_m:g} m is outside the hull: check both, in m",
                "All modes: the position swings as the boat turns",
            )
        if abs(sensor.z_m) > _MASTS * config.length_m + 2.0:
            yield Judgement(
                ("sensor", i, "z_m"),
                f"'{sensor.name}' is {abs(sensor.z_m):g} m {'above' if sensor.z_m < 0.0 else 'below'} the middle of "
                "the boat: check it, in m",
                "All modes: the position swings as the boat rolls",
            )


def _hulls(config: VesselConfig) -> Iterator[Judgement]:
    for key in ("hull_beam_m", "hull_spacing_m"):
        if getattr(config.hull, key) is not None and config.hull.form not in (None, "catamaran"):
            yield Judgement(
                ("hull", key),
                f"has no effect on one hull, of form {config.hull.form}",
                'All modes: the model is that of one hull. Two hulls have form = "catamaran"',
            )


def _senses(config: VesselConfig) -> Iterator[Judgement]:
    """Known drivers alone are judged: a plug-in may give anything."""
    drivers = {sensor.driver for sensor in config.sensors}
    if drivers <= SENSORS.keys() and "nmea0183" not in drivers:
        text = "no sensor gives a position: a satellite receiver is a [[sensor]] with driver 'nmea0183'"
        yield Judgement(("sensor",), text, "All modes but Manual, Forces and Heading: refused")


def _heading(config: VesselConfig) -> Iterator[Judgement]:
    """A second row of NMEA 0183 may be a compass, which needs no key."""
    rows = config.sensors
    lines = [row for row in rows if row.driver == "nmea0183"]
    if len(lines) != 1 or not {row.driver for row in rows} <= SENSORS.keys():
        return
    if lines[0].antennas < 2 and all(row.heading == "none" for row in rows):
        yield Judgement(
            ("sensor",),
            "no sensor is said to give a heading: a receiver by antennas = 2, or an inertial sensor by "
            "heading = 'magnetic', 'true' or 'ahrs'",
            "All modes but Manual and Forces: unless the receiver's port has HDG or HDT too, the heading is found by "
            "motion, and is some degrees off at rest",
        )


def _antenna_pairs(config: VesselConfig) -> Iterator[Judgement]:
    rows = {row.name: row for row in config.sensors}
    for i, row in enumerate(config.sensors):
        other = rows.get(row.heading_with or "")
        if other is None:
            continue
        length_m = baseline_m(row, other)
        sigma_rad = math.hypot(row.accuracy_floor_m, other.accuracy_floor_m) / length_m
        if sigma_rad > _PAIR_RAD:
            yield Judgement(
                ("sensor", i, "heading_with"),
                f"a baseline of {length_m:.2f} m: one sigma of {math.degrees(sigma_rad):.1f}° at best",
                "All modes: that heading is no better than a compass. Place the antennas further apart",
            )


def _axes(config: VesselConfig) -> Iterator[Judgement]:
    if config.limits.sway_n <= 0.0:
        astern = any(t.pushes_astern for t in config.thrusters)
        hold = "lies bow to the weather at its point" if astern else "drifts and sails back within its watch circle"
        if config.has_rudder:
            hold = "keeps bow to the weather within its watch circle, by its rudder"
        if config.has_sail:
            hold = "sails back and forth within its watch circle"
        yield Judgement(
            ("limits", "sway_n"),
            "no sideways thrust",
            f"Dock: refused. Hold: {hold}, without a heading. Missions, RTL, Follow, Offboard: bow first",
        )


def _dock(config: VesselConfig) -> Iterator[Judgement]:
    """Only receivers with RTK are as sure of their place as Dock asks."""
    within_m = config.parameters.get("DOCK_POS_ACC", DOCK_WITHIN_M)
    known = {row.driver for row in config.sensors} <= SENSORS.keys()
    if config.dock is not None and known and within_m < _SBAS_M and grade_of(config.sensors) == "sbas":
        yield Judgement(
            ("dock",),
            f"Dock asks for a position within {within_m:g} m, and a receiver without RTK gives about {_SBAS_M:g} m",
            "Dock: given up off the berth. Give an RTK receiver rtcm = true, or raise DOCK_POS_ACC where the fenders "
            "allow for that",
        )


def _economy(config: VesselConfig) -> Iterator[Judgement]:
    pods = sum(thruster.turns for thruster in config.thrusters)
    useless = {
        "DP_ECON": ("no sideways thrust", config.limits.sway_n <= 0.0),
        "DP_WEATHERVANE": ("no sideways thrust", config.limits.sway_n <= 0.0),
        "ALLOC_ECON": ("no azimuth thruster beside another", pods == 0 or len(config.thrusters) == 1),
    }
    for name, (lacks, so) in useless.items():
        if so and config.parameters.get(name):
            yield Judgement(("parameters", name), f"has no effect: {lacks}", "Hold: takes the energy that it takes")


def _timeouts(config: VesselConfig) -> Iterator[Judgement]:
    rows = [
        *(("sensor", i, sensor.name, sensor.timeout_s) for i, sensor in enumerate(config.sensors)),
        *(("actuator", i, bridge.name, bridge.timeout_s) for i, bridge in enumerate(config.actuators)),
    ]
    for table, i, name, timeout_s in rows:
        if timeout_s > _LONG_S:
            yield Judgement(
                (table, i, "timeout_s"),
                f"'{name}' counts as lost after {timeout_s:g} s: check it, in s; {timeout_s:g} ms are "
                f"{timeout_s / 1000.0:g} s",
                "All modes: until then its silence goes unnoticed, and no failsafe comes",
            )


def _ports(config: VesselConfig) -> Iterator[Judgement]:
    """Serial ports that the system numbers in the order in which it finds them."""
    rows = [
        *(("sensor", i, sensor.name, sensor.port) for i, sensor in enumerate(config.sensors)),
        *(("actuator", i, bridge.name, bridge.port) for i, bridge in enumerate(config.actuators)),
    ]
    for table, i, name, port in rows:
        path = port.removeprefix("serial:").partition(":")[0].partition("?")[0]
        if _NUMBERED.fullmatch(path):
            yield Judgement(
                (table, i, "port"),
                f"'{name}' at {path}: that number changes with the order of plugging in",
                "Two devices may change places. `companion devices` prints names that stay",
            )


_JUDGES: tuple[Callable[[VesselConfig], Iterator[Judgement]], ...] = (
    _damping,
    _driven_on,
    _inertia,
    _pairs,
    _thrust,
    _sides,
    _radians,
    _turns,
    _speed,
    _planing,
    _shape,
    _volts,
    _battery,
    _turning,
    _wide_turns,
    _course,
    _places,
    _hulls,
    _ports,
    _timeouts,
    _senses,
    _heading,
    _antenna_pairs,
    _axes,
    _dock,
    _economy,
)

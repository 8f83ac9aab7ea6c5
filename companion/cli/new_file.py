"""The text of a new vessel's file from what a person can measure or read off a label."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from companion.config.dimensions.form import WATER_KGPM3

FORMS: Mapping[str, str] = {
    "monohull": "one hull: launch, canoe, kayak, model ship",
    "catamaran": "two hulls",
    "inflatable": "with tubes: dinghy, paddle board",
    "barge": "a box: raft, pontoon, punt",
    "planing": "one hull that planes at speed: speedboat, RIB, jet ski",
}
LAYOUTS: Mapping[str, str] = {
    "twin": "two fixed thrusters at the stern",
    "twin-bow": "two fixed thrusters at the stern and one across the bow",
    "vectored": "four fixed thrusters at the corners that push diagonally",
    "azimuth": "one thruster at the stern that turns, such as an outboard",
    "bow-azimuth": "one thruster at the bow that turns all round, such as a trolling motor that pulls",
    "azimuth-bow": "one at the stern that turns to either side, such as a trolling motor, and one across the bow",
    "two-azimuths": "a turning thruster at either end",
    "rudder": "one fixed propeller at the stern with a rudder behind it",
    "rudder-bow": "the same, and a thruster across the bow",
    "two-rudders": "two fixed propellers at the stern, each with a rudder behind it",
    "jet": "a water jet at the stern with a steered nozzle",
}
_STOPS_DEG = {"azimuth": 35.0, "bow-azimuth": 170.0}  # of turning thrusters; others 90
BOARDS: Mapping[str, str] = {"microcontroller": "an Arduino or another board", "pixhawk": "a Pixhawk with ArduPilot"}
RECEIVERS: Mapping[str, str] = {"one": "one antenna", "two": "two antennas, which give the heading"}


@dataclass(frozen=True, slots=True)
class Answers:
    """What was asked. None: not known, so that it follows from the rest."""

    name: str
    title: str
    form: str
    length_m: float
    beam_m: float
    mass_kg: float
    draft_m: float | None
    hull_beam_m: float | None
    top_speed_mps: float | None
    layout: str
    motor: str
    voltage_v: float | None
    spread_m: float
    board: str
    receiver: str
    lat_deg: float
    lon_deg: float
    rudder_span_m: float | None = None
    rudder_chord_m: float | None = None
    nozzle_m: float | None = None
    bow_motor: str | None = None  # None: as the others


@dataclass(frozen=True, slots=True)
class _Place:
    name: str
    kind: str
    x_m: float
    y_m: float
    azimuth_deg: float = 0.0


def file_text(answers: Answers) -> str:
    """The file, with comments, units and sources."""
    return "\n".join(_lines(answers)) + "\n"


def _lines(a: Answers) -> Iterator[str]:
    yield f"# {a.title}. Written by `companion new`; all lengths in m, masses in kg, forces in N."
    yield "# What is not here follows from the dimensions (docs/reference: A model from dimensions)."
    yield f'name = "{a.name}"'
    yield f'title = "{_escaped(a.title)}"'
    yield f"length_m = {a.length_m:g}{_comment('over all')}"
    yield f"beam_m = {a.beam_m:g}{_comment('over all')}"
    yield f"control_rate_hz = {20.0 if a.layout == 'jet' else 10.0}"
    yield 'links = ["udpout:127.0.0.1:14550", "tcpin:127.0.0.1:5760"]'
    yield ""
    yield "[home]                      # where the boat lives; simulations start here"
    yield f"lat_deg = {a.lat_deg:.6f}"
    yield f"lon_deg = {a.lon_deg:.6f}"
    yield ""
    yield "# Measured figures, such as m11_kg, go here as well: they override what follows from the dimensions."
    yield "[hull]"
    yield f'form = "{a.form}"'
    yield f"mass_kg = {a.mass_kg:g}{_comment('afloat, with batteries')}"
    for key, value, text in (
        ("draft_m", a.draft_m, "depth below the water"),
        ("hull_beam_m", a.hull_beam_m, "one hull, at the waterline"),
        ("top_speed_mps", a.top_speed_mps, "at full thrust"),
    ):
        if value is not None:
            yield f"{key} = {value:g}{_comment(text)}"
    places = _places(a)
    for place in places:
        yield from _thruster(a, place)
    yield from _sensors(a)
    yield from _bridge(a, places)


def _places(a: Answers) -> list[_Place]:
    stern_m, bow_m, half_m = round(-0.45 * a.length_m, 3), round(0.4 * a.length_m, 3), round(0.5 * a.spread_m, 3)
    corner_m = round(0.35 * a.length_m, 3)
    twin = [_Place("port", "fixed", stern_m, -half_m), _Place("starboard", "fixed", stern_m, half_m)]
    by_layout = {
        "twin": twin,
        "twin-bow": [*twin, _Place("bow", "fixed", bow_m, 0.0, 90.0)],
        "vectored": [
            _Place("bow_port", "fixed", corner_m, -half_m, 45.0),
            _Place("bow_starboard", "fixed", corner_m, half_m, -45.0),
            _Place("stern_port", "fixed", -corner_m, -half_m, -45.0),
            _Place("stern_starboard", "fixed", -corner_m, half_m, 45.0),
        ],
        "azimuth": [_Place("stern", "azimuth", stern_m, 0.0)],
        "bow-azimuth": [_Place("bow", "azimuth", -stern_m, 0.0)],
        "azimuth-bow": [_Place("stern", "azimuth", stern_m, 0.0), _Place("bow", "fixed", bow_m, 0.0, 90.0)],
        "rudder": [_Place("propeller", "rudder", stern_m, 0.0)],
        "rudder-bow": [_Place("propeller", "rudder", stern_m, 0.0), _Place("bow", "fixed", bow_m, 0.0, 90.0)],
        "two-rudders": [
            _Place("port", "rudder", stern_m, -half_m),
            _Place("starboard", "rudder", stern_m, half_m),
        ],
        "jet": [_Place("jet", "jet", stern_m, 0.0)],
        "two-azimuths": [_Place("bow", "azimuth", bow_m, 0.0), _Place("stern", "azimuth", stern_m, 0.0)],
    }
    return by_layout[a.layout]


def _thruster(a: Answers, place: _Place) -> Iterator[str]:
    yield ""
    yield "[[thruster]]"
    yield f'name = "{place.name}"'
    yield f'kind = "{place.kind}"'
    yield f"x_m = {place.x_m:g}{_comment('ahead of the middle of the boat: measure it')}"
    yield f"y_m = {place.y_m:g}{_comment('to starboard')}"
    if place.azimuth_deg:
        yield f"azimuth_deg = {place.azimuth_deg:g}{_comment(_pushes(place.azimuth_deg))}"
    if place.kind == "azimuth":
        yield f"azimuth_rate_dps = 60.0{_comment('estimated; companion thruster-test measures it')}"
        stop_deg = _STOPS_DEG.get(a.layout, 90.0)
        yield f"azimuth_min_deg = {-stop_deg}"
        yield f"azimuth_max_deg = {stop_deg}"
        yield "manual_azimuth_deg = 35.0"
    yield from _thrust(a.bow_motor if place.azimuth_deg == 90.0 and a.bow_motor else a.motor, a.voltage_v)
    if place.kind == "rudder":
        yield from _rudder(a)
    if place.kind == "jet":
        yield from _jet(a)


def _pushes(azimuth_deg: float) -> str:
    """Which way a fixed thruster pushes the boat."""
    side = "port" if azimuth_deg < 0.0 else "starboard"
    return f"pushes to {side}" if abs(azimuth_deg) == 90.0 else f"pushes ahead to {side}"


def _rudder(a: Answers) -> Iterator[str]:
    yield f"azimuth_rate_dps = 30.0{_comment('estimated; companion thruster-test measures it')}"
    yield f"azimuth_min_deg = -35.0{_comment('stops of the rudder, from amidships')}"
    yield "azimuth_max_deg = 35.0"
    yield "manual_azimuth_deg = 35.0"
    blade = (("span_m", a.rudder_span_m, "height of the blade"), ("chord_m", a.rudder_chord_m, "width of the blade"))
    if a.rudder_span_m is None and a.rudder_chord_m is None:
        yield "# The blade follows from length, beam and draft; [thruster.rudder] with span_m and chord_m has yours."
        return
    yield "[thruster.rudder]"
    for key, value, text in blade:
        if value is not None:
            yield f"{key} = {value:g}{_comment(text)}"


def _jet(a: Answers) -> Iterator[str]:
    yield f"azimuth_rate_dps = 40.0{_comment('of the nozzle, estimated; companion thruster-test measures it')}"
    yield f"azimuth_min_deg = -24.0{_comment('stops of the nozzle')}"
    yield "azimuth_max_deg = 24.0"
    yield "manual_azimuth_deg = 24.0"
    if a.nozzle_m is None:
        yield "# The jet's curve follows from pull and hull; [thruster.jet] with density_area_kgpm has yours."
        return
    yield "[thruster.jet]"
    area = round(0.25 * math.pi * WATER_KGPM3 * a.nozzle_m**2, 4)
    yield f"density_area_kgpm = {area:g}{_comment(f'density of water times the area of a nozzle of {a.nozzle_m:g} m')}"


def _thrust(motor: str, voltage_v: float | None) -> Iterator[str]:
    try:
        yield f"max_n = {float(motor):g}{_comment('bollard pull ahead')}"
    except ValueError:
        yield f'motor = "{_escaped(motor)}"{_comment("thrust as its maker publishes it")}'
        if voltage_v is not None:
            yield f"voltage_v = {voltage_v:g}"


def _sensors(a: Answers) -> Iterator[str]:
    two = a.receiver == "two"
    yield ""
    yield "[[sensor]]"
    yield 'name = "gnss"'
    yield 'driver = "nmea0183"'
    yield f'port = "serial:/dev/usv-gnss:115200"{_comment("`companion devices` prints yours")}'
    yield f"z_m = {-0.25 * a.length_m:.2f}{_comment('above the middle of the boat: measure x_m, y_m, z_m')}"
    yield f"antennas = {2 if two else 1}"
    yield "rate_hz = 5.0"
    yield ""
    yield "[[sensor]]"
    yield 'name = "imu"'
    if a.board == "pixhawk":
        yield f'driver = "mavlink_imu"{_comment("the IMU and the compass of the Pixhawk")}'
        yield 'port = "serial:/dev/usv-pixhawk:115200"'
        yield "rate_hz = 50.0"
        yield 'heading = "true"'
    else:
        yield f'driver = "mtdata2"{_comment("an Xsens MTi is assumed; others: docs/start/sensors.md; none: delete")}'
        yield 'port = "serial:/dev/usv-imu:115200"'
        yield "rate_hz = 100.0"
        yield "timeout_s = 0.5"
        if not two:
            yield 'heading = "magnetic"'


def _bridge(a: Answers, places: list[_Place]) -> Iterator[str]:
    names = ", ".join(f'"{place.name}"' for place in places)
    yield ""
    yield "[[actuator]]"
    if a.board != "pixhawk":
        yield 'name = "microcontroller"'
        yield 'driver = "microcontroller"'
        yield 'port = "serial:/dev/usv-mcu:115200"'
        yield f"thrusters = [{names}]"
        return
    channels = [1, 3, 5, 7][: len(places)]
    turning = [place.kind != "fixed" for place in places]
    yield 'name = "pixhawk"'
    yield 'driver = "mavlink_servo"'
    yield 'port = "serial:/dev/usv-pixhawk:115200"'
    yield f"thrusters = [{names}]"
    yield "[actuator.mavlink]"
    yield f"channels = {channels}{_comment('servo outputs, in the order of the thrusters')}"
    if any(turning):
        yield f"azimuth_channels = {[2 + 2 * i if turns else 0 for i, turns in enumerate(turning)]}"


def _comment(text: str) -> str:
    return f"    # {text}"


def _escaped(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"')

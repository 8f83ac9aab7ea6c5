"""log-columns.md: what a log folder holds, column by column, from the recorders' own headers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from companion.config.units import unit_of
from companion.config.vessel import bundled, find, load
from companion.core.readings import KINDS
from companion.leader_module.log import COLUMNS as MODULE_COLUMNS
from companion.record.geotags import COLUMNS as GEOTAG_COLUMNS
from companion.record.reading_codec import CODECS
from companion.record.recorded import TICK_COLUMNS
from companion.record.recorder import EVENT_COLUMNS, tick_columns
from docs.generate.markdown import code, page, section, sentence, summary, table
from sitl.camera import COLUMNS as PICTURE_COLUMNS
from sitl.truth_log import LEADER_COLUMNS, truth_columns

THRUSTER, DEVICE = "THRUSTER", "DEVICE"  # stand for the names of the vessel file

_INTRODUCTION = """Each run writes one folder. `companion report`, `companion replay` and `companion export` read it.

`THRUSTER` and `DEVICE` stand for the names in the vessel file. An empty cell is a value that is not there.
`t_s` is the boat's time: seconds since the program started. Positions are in the local frame: north, east and down
from home."""

_POSE: Mapping[str, str] = {
    "north_m": "Position north of home.",
    "east_m": "Position east of home.",
    "yaw_rad": "Heading, clockwise from north.",
    "surge_mps": "Speed ahead.",
    "sway_mps": "Speed to starboard.",
    "yaw_rate_radps": "Rate of turn, clockwise.",
}
_WRENCH: Mapping[str, str] = {
    "surge_n": "Force ahead",
    "sway_n": "Force to starboard",
    "yaw_nm": "Moment, clockwise",
}
_TIME: Mapping[str, str] = {
    "t_s": "The boat's time.",
    "time_unix_ns": "Absolute time.",
}
TICKS: Mapping[str, str] = {
    **_TIME,
    **_POSE,
    **{f"desired_{name}": f"Reference or setpoint: {text[:1].lower()}{text[1:]}" for name, text in _POSE.items()},
    **{f"demanded_{name}": f"{text} that was demanded of the thrusters." for name, text in _WRENCH.items()},
    **{
        f"achieved_{name}": f"{text} that the thrusters gave, as the allocation believes."
        for name, text in _WRENCH.items()
    },
    "mode": "Active mode.",
    "armed": "1: armed.",
    f"{THRUSTER}_throttle": "Throttle that was sent, −1 to 1.",
    f"{THRUSTER}_azimuth_rad": "Azimuth that was sent, clockwise from the bow.",
    f"{THRUSTER}_force_n": "Thrust that was asked for.",
    "position_accuracy_m": "Error of position, one sigma, as the filter believes.",
    "heading_accuracy_rad": "Error of heading, one sigma, as the filter believes.",
    "position_valid": "1: the position is valid.",
    "heading_valid": "1: the heading is valid.",
    "cross_track_error_m": "Distance from the path, positive to starboard.",
    "mission_seq": "MAVLink's sequence number of the current item: one less than the item's number in texts.",
    "failsafes": "Failsafes that last, separated by semicolons, most severe first.",
    "load": "Share of the tick's period spent computing.",
    "lat_deg": "Latitude; empty while the position is not valid.",
    "lon_deg": "Longitude.",
    "fix": "Quality of the satellite fix, as MAVLink's GPS_FIX_TYPE.",
    "satellites": "Satellites used.",
    "corrections_age_s": "Age of the corrections that the receiver uses.",
    "battery_v": "Voltage.",
    "battery_a": "Current out of the battery.",
    "battery_remaining": "Share of charge left, 0 to 1.",
    "wind_speed_mps": "True wind.",
    "wind_from_rad": "Direction from which the true wind comes, clockwise from north.",
    "current_north_mps": "Current towards north, as the filter believes.",
    "current_east_mps": "Current towards east.",
    f"{DEVICE}_ok": "1: the device answers.",
    f"{THRUSTER}_condition": "What the watch of thrusters thinks of it.",
}
TRUTH: Mapping[str, str] = {
    "t_s": "The plant's time.",
    **{name: f"True: {text[:1].lower()}{text[1:]}" for name, text in _POSE.items()},
    "wind_speed_mps": "True wind.",
    "wind_from_rad": "Direction from which the true wind comes, clockwise from north.",
    "current_north_mps": "Current towards north.",
    "current_east_mps": "Current towards east.",
    f"{THRUSTER}_force_n": "Thrust that the plant gives.",
    f"{THRUSTER}_azimuth_rad": "Direction of that thrust, clockwise from the bow.",
    f"{THRUSTER}_down": "Retractable thruster: 0 up, 1 down.",
    "contact_n": "Force of the berth on the hull.",
    "contact_gap_m": "Clear water between hull and berth.",
    "contact_surge_mps": "Speed ahead at the last touch.",
    "contact_sway_mps": "Speed to starboard at the last touch.",
}
EVENTS: Mapping[str, str] = {
    "t_s": "The boat's time at which it happened.",
    "time_unix_ns": "Absolute time of the tick.",
    "severity": "`EMERGENCY` to `DEBUG`, as in MAVLink.",
    "name": "Name for programs; it stays the same when the text changes.",
    "text": "Text for people, in quotation marks.",
}
GEOTAGS: Mapping[str, str] = {
    "t_s": "The boat's time at which the camera was triggered.",
    "time_unix_ns": "Absolute time of it, by the satellite receiver where it gives one.",
    "camera": "Name in the vessel file.",
    "image": "Number of the picture of that camera, from 1.",
    "lat_deg": "Latitude of the lens.",
    "lon_deg": "Longitude of the lens.",
    "altitude_m": "Altitude of the lens above mean sea level.",
    "heading_deg": "Heading of the boat, clockwise from north.",
    "roll_deg": "Roll of the boat, starboard side down.",
    "pitch_deg": "Pitch of the boat, bow up.",
    "speed_mps": "Speed over ground.",
    "position_accuracy_m": "Error of position, one sigma, as the filter believes.",
    "heading_accuracy_deg": "Error of heading, one sigma, as the filter believes.",
}
PICTURES: Mapping[str, str] = {
    "t_s": "The plant's time.",
    "camera": "Name in the vessel file.",
    "north_m": "True place of the lens, north of home.",
    "east_m": "True place of the lens, east of home.",
    "yaw_rad": "True heading, clockwise from north.",
}
LEADER: Mapping[str, str] = {
    **{name: text for name, text in TRUTH.items() if name in LEADER_COLUMNS},
    "speed_mps": "Speed over ground.",
    "placed_north_m": "Where the follower places it, in the plane of its own estimate.",
    "placed_east_m": "The same, east.",
    "fix_north_m": "Where its receiver puts it, north of home, carried on from the last fix.",
    "fix_east_m": "Where its receiver puts it, east of home.",
}
MODULE: Mapping[str, str] = {
    **_TIME,
    "placed": "1: the module has a position.",
    "heading_valid": "1: the heading is valid.",
    "lat_deg": "Latitude.",
    "lon_deg": "Longitude.",
    "north_mps": "Velocity over ground towards north.",
    "east_mps": "Velocity over ground towards east.",
    "yaw_rad": "Heading, clockwise from north.",
    "yaw_rate_radps": "Rate of turn, clockwise.",
    "position_accuracy_m": "Error of position, one sigma.",
    "wish": "Mode that the crew asks for.",
    "presses": "How often the crew has asked.",
    "surge": "Stick ahead, −1 to 1.",
    "yaw": "Stick clockwise, −1 to 1.",
    "link_counter": "Counter of the messages to the follower.",
    "follower_mode": "Mode of the follower.",
    "follower_armed": "1: the follower is armed.",
    "follower_age_s": "Time since the follower was heard.",
    "gap_m": "Distance to the follower.",
    "throttle": "Throttle of the follower.",
    "nozzle_deg": "Nozzle of the follower's jet.",
}
MANIFEST: Mapping[str, str] = {
    "version": "Version of the program.",
    "python": "Version of Python.",
    "vessel": "Name of the vessel.",
    "started_unix_ns": "Absolute time at the start.",
    "command": "Command line of the run.",
    "seed": "Seed of the simulation; null on a boat.",
    "parameters": "Value of every parameter at the start.",
    "defaults": "Defaults that this run changed.",
    "patience": "Factor by which ground stations may be silent for longer, in a simulation faster than real time.",
    "configuration": "The vessel file as it was read, without passwords.",
}
RESULT: Mapping[str, str] = {
    "scenario": "Name of the scenario.",
    "vessel": "Vessel that sailed it.",
    "seed": "Seed of all noise.",
    "settings": "Settings in force.",
    "ok": "Whether all checks hold.",
    "error": "What ended the run early; null where nothing did.",
    "metrics": "Figures, by name.",
    "checks": "Each check: its name, its limit, what was measured, whether it holds.",
}

_FILES = (
    ("ticks.csv", "One row a control step."),
    ("events.csv", "One row an event."),
    (
        "log.mcap",
        "Readings, ticks, events, parameter changes, packets that came in; for a replay and for viewers.",
    ),
    ("telemetry.tlog", "Every MAVLink packet, in and out, as ground stations record it."),
    ("manifest.json", "What ran, and with which configuration."),
    ("state/", "Parameters, plans and keys of the boat when the run began."),
    ("ticks.ulg", "On a boat: the ticks as ULog, for PlotJuggler, Flight Review and pyulog."),
    ("geotags.csv", "With cameras: one row a picture."),
    ("pictures.csv", "In simulation with cameras: where each picture was really taken."),
    ("truth.csv", "In simulation: what the plant really did."),
    ("LEADER.csv", "In simulation with a lead boat: what it really did. The file has the boat's name."),
    ("result.json", "Of a scenario: metrics and checks."),
)
_READINGS = """An MCAP file. Messages are protobuf, described in the file, in chunks compressed with zstd.

| topic | schema | what it is |
|---|---|---|
| `/SOURCE/KIND` | `usv.Kind_FORMS` | the readings of a device in a tick: one column a value, one row a sample |
| `/tick` | `usv.Tick` | the end of a tick: estimate, setpoint, wrench; `order` lists the channel of each reading |
| `/packet` | `usv.MavlinkPacket` | a MAVLink packet that came in |
| `/parameter` | `usv.Parameter` | a parameter that changed under way |
| `/health` | `usv.DeviceHealth` | what a device's driver reports from then on; once a minute of one that is well |
| `/log` | `foxglove.Log` | an event |
| `/position` | `foxglove.LocationFix` | the boat's place, 5 times a second |
| `/pose`, `/tf` | `foxglove.PoseInFrame`, `FrameTransform` | the same in the frame `map`: east, north, up from home |

`FORMS` has one letter a column: `f` float32; `s` float32, of which the shortest decimal is the value; `d` float64;
`q` int64; `u` age in microseconds at the tick, instead of `t_s`. So every value comes back to the last bit.
What is not there is NaN.

The kinds of readings:"""
_TICK_LINE = """`/tick` has these as float64, and more as float32: accuracies, battery, wind, current, each thruster's
command."""

_READING_COLUMNS = {kind: (KINDS[kind], codec.names) for kind, codec in CODECS.items()}


class UndescribedColumn(Exception):
    """A column without a meaning in this file."""


def log_columns() -> str:
    """The page."""
    return page(
        "Log columns",
        _INTRODUCTION,
        table(("file", "what it holds"), ((code(name), text) for name, text in _FILES)),
        section(2, "ticks.csv", columns(tick_columns([THRUSTER], [DEVICE]), TICKS)),
        section(2, "truth.csv", columns(truth_columns([THRUSTER], [THRUSTER], True), TRUTH)),
        section(2, "events.csv", columns(EVENT_COLUMNS, EVENTS)),
        section(2, "geotags.csv", columns(GEOTAG_COLUMNS, GEOTAGS)),
        section(2, "pictures.csv", columns(PICTURE_COLUMNS, PICTURES)),
        section(2, "log.mcap", _READINGS, _kinds(), section(3, "A tick", _TICK_LINE, _names(TICK_COLUMNS))),
        section(2, "manifest.json", _keys(MANIFEST)),
        section(2, "result.json", _keys(RESULT)),
        section(2, "LEADER.csv", columns(LEADER_COLUMNS, LEADER)),
        section(2, "module.csv", "Of a leader module.", columns(MODULE_COLUMNS, MODULE)),
        section(2, "Devices and thrusters of the bundled vessels", _vessels()),
    )


def columns(names: Sequence[str], meanings: Mapping[str, str]) -> str:
    """A table of columns. Raises UndescribedColumn."""
    for name in names:
        if name not in meanings:
            raise UndescribedColumn(f"no meaning for the column {name}: add it to docs/generate/log_columns.py")
    return table(("column", "unit", "meaning"), ((code(name), unit_of(name), meanings[name]) for name in names))


def _keys(meanings: Mapping[str, str]) -> str:
    return table(("key", "unit", "meaning"), ((code(name), unit_of(name), text) for name, text in meanings.items()))


def _kinds() -> str:
    rows = (
        (code(kind), sentence(summary(reading)), _names(names)) for kind, (reading, names) in _READING_COLUMNS.items()
    )
    return table(("kind", "what it is", "values"), rows)


def _names(names: Iterable[str]) -> str:
    return ", ".join(code(name) for name in names)


def _vessels() -> str:
    rows = []
    for vessel in (load(find(name)) for name in bundled()):
        devices = [sensor.name for sensor in vessel.sensors] + [bridge.name for bridge in vessel.actuators]
        rows.append((code(vessel.name), _names(thruster.name for thruster in vessel.thrusters), _names(devices)))
    return table(("vessel", "THRUSTER", "DEVICE"), rows)

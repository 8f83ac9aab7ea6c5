"""readings.csv of older logs: what went in comes out bit by bit, and half a line harms nothing else."""

from __future__ import annotations

import base64
import math
import struct
from dataclasses import dataclass, fields, is_dataclass, replace
from enum import Enum
from pathlib import Path

import pytest

from companion.core import readings
from companion.core.actuation import Deployment, ThrusterCommand, ThrusterFeedback, Wrench
from companion.core.readings import (
    KINDS,
    AisTarget,
    Battery,
    Corrections,
    Depth,
    DepthAhead,
    FixType,
    GnssFix,
    GroundVelocity,
    Heading,
    HeadingBy,
    Imu,
    Int64,
    Leak,
    MagneticField,
    ManualInput,
    Measurement,
    RadarTarget,
    Ranges,
    RcInput,
    Reading,
    RelativeFix,
    TimeOfDay,
    Wind,
)
from companion.core.setpoint import HeadingSetpoint, NeutralSetpoint, PoseSetpoint, ThrusterSetpoint
from companion.record.reading_codec import CODECS, Codec
from companion.record.readings import path_in, read_kind, read_ticks
from companion.record.readings_csv import HEADER
from companion.record.recorded import TICK_COLUMNS, RecordedTick
from tests.unit.record.old_lines import lines, packed, parameter
from tests.unit.record.ticks import tick

THIRD = 1.0 / 3.0
GOLDEN = Path(__file__).parent / "golden" / "readings.csv"
OF_FIRST_LOGS: tuple[Reading, ...] = (
    GnssFix(THIRD, "gnss", 63.438900000000004, 10.399, None, FixType.RTK_FIXED, None, 0.7, None),
    GnssFix(THIRD, "gnss", 63.4389, 10.399, 41.2, FixType.NONE, 18, None, 0.013),
    GroundVelocity(THIRD, "gnss", 0.1, -0.2),
    Heading(THIRD, "gnss", -math.pi, None),
    Heading(THIRD, "imu", 1.0, 0.02, HeadingBy.MAGNETIC),
    Heading(THIRD, "imu", 1.0, None, HeadingBy.COMPASS),
    Imu(THIRD, "imu", 0.1, 0.2, -9.82, 1e-17, -0.0, 3.0),
    Imu(THIRD, "imu", 0.1, 0.2, -9.82, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06),
    MagneticField(THIRD, "imu", 0.3, -0.1, 0.9),
    TimeOfDay(THIRD, "gnss", 1_780_315_200_123_456_789),
    Wind(THIRD, "wind", 3.1, 6.2),
    Battery(THIRD, "board", 12.3, None, 0.5),
    Leak(THIRD, "board", True),
    RcInput(THIRD, "board", (0.1, -1.0, 1.0), False),
    RcInput(THIRD, "board", (), True),
    ThrusterFeedback(THIRD, "board", 2, -0.5, None, False),
    ThrusterFeedback(THIRD, "drives", 1, None, 2.5),
    Depth(THIRD, "sounder", 3.4, None, None),
    Depth(THIRD, "sounder", 3.4, -0.3, 100.0),
    Corrections(THIRD, "gnss", 1.2, None),
    Corrections(THIRD, "gnss", 1.2, 1023),
    Measurement(THIRD, "rudder", -0.1, "rudder_rad"),
    ManualInput(THIRD, "gcs", 0.5, None, -0.25, 3),
    AisTarget(
        THIRD,
        "ais",
        999_999_999,
        60.41,
        -22.07,
        1.0,
        THIRD,
        None,
        -0.01,
        5,
        None,
        None,
        None,
        None,
        None,
        None,
        "NORA, Ä",
    ),
    AisTarget(
        THIRD, "ais", 1, kind=37, bow_m=4.0, stern_m=4.0, port_m=1.0, starboard_m=2.0, callsign="OH1234", name=None
    ),
)
READINGS: tuple[Reading, ...] = (
    *OF_FIRST_LOGS,
    DepthAhead(THIRD, "sounder", 2.3, 15.0),
    Ranges(THIRD, "lidar", -0.1, 0.2, 0.5, 40.0, True, 1.0, -0.2, (3.2, math.inf)),
    RadarTarget(THIRD, "radar", 7, 926.0, 2.1, True, None, None, 4.7, None, True, False, "BUOY"),
    RelativeFix(THIRD, "gnss", -20.3, THIRD, -0.0, FixType.RTK_FIXED, 0.012, 4),
    RelativeFix(THIRD, "gnss", 1.0, 2.0, 3.0, FixType.RTK_FLOAT, None, None),
    RadarTarget(THIRD, "radar", 8, None, None, False, 63.4, 10.4, None, 2.0, False, True, None),
)


class Side(Enum):
    PORT = "port"
    STARBOARD = "starboard"


@dataclass(frozen=True, slots=True)
class Echo:
    """A kind of reading with every type of field."""

    t_s: float
    source: str
    range_m: float
    side: Side | None
    label: str | None
    serial: Int64
    count: int | None
    sure: bool


@dataclass(frozen=True, slots=True)
class Profile:
    t_s: float
    source: str
    depths_m: tuple[float, ...]
    ok: bool


@dataclass(frozen=True, slots=True)
class Gust:
    t_s: float
    source: str
    speed_mps: float
    duration_s: float | None = None


def written(path: Path, data: bytes) -> tuple[list[RecordedTick], list[str]]:
    path.write_bytes(HEADER + data)
    warnings: list[str] = []
    return list(read_ticks(path, warnings)), warnings


def test_every_dataclass_of_a_reading_has_its_row_and_an_example() -> None:
    ours = {
        value
        for value in vars(readings).values()
        if is_dataclass(value) and {"t_s", "source"} <= {field.name for field in fields(value)}
    }
    assert set(KINDS.values()) == ours - {readings.LeaderState}  # a lead boat's messages are in the log as packets
    assert {type(reading) for reading in READINGS} == set(KINDS.values())


def test_the_bytes_are_those_of_the_first_logs(tmp_path: Path) -> None:
    """golden/readings.csv was written before the values were derived from the dataclasses."""
    lowered = ThrusterFeedback(THIRD, "board", 0, 0.25, -1.5, True, Deployment.LOWERED)
    first, second = replace(tick(0.7), readings=(*OF_FIRST_LOGS, lowered)), tick(0.8)
    assert HEADER + lines(first) + lines(second) == GOLDEN.read_bytes()
    warnings: list[str] = []
    assert [t.readings for t in read_ticks(GOLDEN, warnings)] == [first.readings, ()] and warnings == []


def test_a_new_kind_needs_its_dataclass_alone() -> None:
    echo = Echo(THIRD, "sonar", 0.5, Side.PORT, None, 2**62 + 1, None, True)
    codec = Codec("echo", Echo)
    assert codec.names == ("t_s", "range_m", "side", "serial", "count", "sure", "label")
    for reading in (echo, replace(echo, side=None, label="bottom", count=3), replace(echo, side=Side.STARBOARD)):
        assert codec.reading("sonar", packed(codec, reading)) == reading
    profile = Profile(THIRD, "sonar", (1.0, THIRD), False)
    codec = Codec("profile", Profile)
    assert codec.reading("sonar", packed(codec, profile)) == profile and codec.names == ("t_s", "ok", "depths_m")


def test_a_field_added_later_leaves_older_lines_readable() -> None:
    codec = Codec("gust", Gust)
    assert codec.reading("wind", struct.pack("<2d", 1.0, 7.0)) == Gust(1.0, "wind", 7.0)
    assert codec.reading("wind", struct.pack("<3d", 1.0, 7.0, 2.0)) == Gust(1.0, "wind", 7.0, 2.0)
    for damaged in (
        b"",
        struct.pack("<d", 1.0),
        struct.pack("<4d", 1.0, 7.0, 2.0, 0.0),
        struct.pack("<2d", 1.0, 7.0)[:9],
    ):
        with pytest.raises(ValueError, match="values, gust has 3"):
            codec.reading("wind", damaged)


def test_a_field_that_a_line_cannot_hold_is_refused_at_once() -> None:
    @dataclass(frozen=True)
    class Wrong:
        t_s: float
        source: str
        table: dict[str, float]

    with pytest.raises(TypeError, match=r"Wrong\.table: the log holds no dict"):
        Codec("wrong", Wrong)

    @dataclass(frozen=True)
    class Mixed:
        t_s: float
        source: str
        values: tuple[float, ...]
        name: str

    with pytest.raises(TypeError, match="not values and name"):
        Codec("mixed", Mixed)


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_every_field_of_a_reading_is_in_its_line(kind: str) -> None:
    kind_type, names = KINDS[kind], CODECS[kind].names
    assert {*names, "source"} == {field.name for field in fields(kind_type)}


def test_readings_come_back_as_they_were(tmp_path: Path) -> None:
    ticks, warnings = written(tmp_path / "r.csv", lines(replace(tick(0.7), readings=READINGS)))
    assert warnings == [] and ticks[0].readings == READINGS
    assert all(type(a.fix) is FixType for a in ticks[0].readings if isinstance(a, GnssFix))
    imu = next(reading for reading in ticks[0].readings if isinstance(reading, Imu))
    assert math.copysign(1.0, imu.pitch_rate_radps) == -1.0


def test_a_tick_comes_back_as_it_was(tmp_path: Path) -> None:
    thrusters = (ThrusterCommand(0.0, 0.5, None), ThrusterCommand(0.0, -0.1, 1.2))
    setpoints = (
        PoseSetpoint(1.0, THIRD, -3.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6),
        HeadingSetpoint(yaw_rad=0.5, wrench=Wrench(1.0, 2.0, 3.0)),
        ThrusterSetpoint(thrusters=thrusters),
        NeutralSetpoint(),
    )
    data = b"".join(lines(replace(tick(0.1 * n + THIRD), setpoint=setpoint)) for n, setpoint in enumerate(setpoints))
    ticks, _ = written(tmp_path / "r.csv", data)
    assert [t.setpoint for t in ticks] == list(setpoints)
    one = tick(THIRD)
    assert ticks[0].t_s == THIRD and ticks[0].pose == (1.5, -2.0, 0.3, 0.4, 0.0, 0.01) and ticks[0].armed
    assert ticks[0].demanded == one.wrench and ticks[0].achieved == one.allocation.achieved


def test_the_lines_are_what_the_documentation_says() -> None:
    heading, line = lines(replace(tick(2.5), readings=(Heading(1.5, "gnss", 0.25, 0.01),))).splitlines()
    kind, source, text = heading.decode().split(",")
    assert (kind, source) == ("heading", "gnss")
    assert struct.unpack("<4d", base64.b64decode(text)) == (1.5, 0.25, 0.01, 0.0)
    kind, source, text = line.decode().split(",")
    values = struct.unpack(f"<{len(TICK_COLUMNS)}d", base64.b64decode(text))
    assert (kind, source) == ("tick", "") and dict(zip(TICK_COLUMNS, values, strict=True))["demanded_surge_n"] == 3.0


def test_a_heading_logged_before_it_said_what_it_rests_on_is_a_baselines(tmp_path: Path) -> None:
    line = b"heading,gnss," + base64.b64encode(struct.pack("<3d", 1.5, 0.25, math.nan)) + b"\n"
    ticks, warnings = written(tmp_path / "r.csv", line + lines(tick(2.5)))
    assert warnings == [] and ticks[0].readings == (Heading(1.5, "gnss", 0.25, None, HeadingBy.BASELINE),)


def test_a_parameter_belongs_to_the_tick_after_it(tmp_path: Path) -> None:
    ticks, _ = written(tmp_path / "r.csv", lines(tick(0.0)) + parameter("DP_DAMPING", 0.7) + lines(tick(0.1)))
    assert [t.parameters for t in ticks] == [(), (("DP_DAMPING", 0.7),)]


def test_a_file_cut_anywhere_keeps_its_whole_ticks(tmp_path: Path) -> None:
    whole = lines(replace(tick(0.0), readings=READINGS))
    last = lines(replace(tick(0.1), readings=READINGS[:3]))
    for cut in range(1, len(last)):
        ticks, warnings = written(tmp_path / "r.csv", whole + last[:cut])
        assert [t.t_s for t in ticks] == [0.0] and ticks[0].readings == READINGS
        assert warnings and len(warnings) <= 2


@pytest.mark.parametrize(
    "damage",
    [
        b"imu,imu,AAAA\n",
        b"nonsense\n",
        b"imu,imu\n",
        b"\xff\xfe,,\n",
        b"rudder,a,AAAAAAAAAAA=\n",
        b"tick,,AAAAAAAAAAA=\n",
        b"rc,a,\n",
        b"\n",
    ],
)
def test_a_damaged_line_is_left_out_with_its_place(tmp_path: Path, damage: bytes) -> None:
    ticks, warnings = written(tmp_path / "r.csv", damage + lines(replace(tick(0.0), readings=READINGS)))
    assert len(ticks) == 1 and ticks[0].readings == READINGS
    assert len(warnings) == 1 and ":2:" in warnings[0]


def test_an_older_logs_file_is_found_where_there_is_no_newer_one(tmp_path: Path) -> None:
    assert path_in(tmp_path).name == "log.mcap"
    (tmp_path / "readings.csv").write_bytes(HEADER + lines(replace(tick(0.7), readings=READINGS)))
    assert [t.readings for t in read_ticks(path_in(tmp_path), [])] == [READINGS]
    assert read_kind(path_in(tmp_path), "leak", []) == [r for r in READINGS if isinstance(r, Leak)]
    (tmp_path / "log.mcap").touch()
    assert path_in(tmp_path).name == "log.mcap"

"""log.mcap: what goes in comes out bit by bit, others read it, and a file that ends anywhere is read up to there."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from companion.core.actuation import ThrusterCommand, Wrench
from companion.core.decision import Event, TextKind
from companion.core.readings import KINDS, FixType, Heading, Imu, ManualInput, RcInput, Reading, TimeOfDay
from companion.core.setpoint import HeadingSetpoint, NeutralSetpoint, PoseSetpoint, ThrusterSetpoint
from companion.core.tick import DeviceHealth, Tick
from companion.record.mcap_log import CHUNK_S, McapEncoder
from companion.record.mcap_reader import read_kind, read_ticks
from companion.record.recorded import RecordedTick
from tests.unit.record.test_readings import READINGS, THIRD
from tests.unit.record.ticks import tick


def sailed(count: int, seed: int = 0) -> list[Tick]:
    """Ticks whose sensors send what no decimal number is."""
    draws, ticks = random.Random(seed), []
    for n in range(count):
        t_s = round(0.1 * n, 6)
        samples: list[Reading] = [
            Imu(round(t_s - 0.01 * k, 6), "imu", *(float(np.float32(draws.gauss(0.0, 1.0))) for _ in range(6)))
            for k in range(9, -1, -1)
        ]
        samples.insert(4, Heading(t_s - draws.random() / 10, "gnss", draws.uniform(-3.0, 3.0), None))
        ticks.append(replace(tick(t_s), readings=tuple(samples)))
    return ticks


def file_of(ticks: list[Tick], path: Path, end: bool = True) -> Path:
    encoder = McapEncoder()
    parts = [encoder.header()]
    for one in ticks:
        encoder.tick(one, ())
        parts.append(encoder.due())
    path.write_bytes(b"".join([*parts, encoder.end() if end else b""]))
    return path


def back(path: Path) -> tuple[list[RecordedTick], list[str]]:
    warnings: list[str] = []
    return list(read_ticks(path, warnings)), warnings


def test_readings_come_back_as_they_were(tmp_path: Path) -> None:
    path = file_of([replace(tick(0.7), readings=READINGS), replace(tick(0.8), readings=READINGS[::-1])], tmp_path / "a")
    ticks, warnings = back(path)
    assert warnings == [] and [t.readings for t in ticks] == [READINGS, READINGS[::-1]]
    imu = next(reading for reading in ticks[0].readings if isinstance(reading, Imu))
    assert math.copysign(1.0, imu.pitch_rate_radps) == -1.0
    for kind, kind_type in KINDS.items():
        found = read_kind(path, kind, warnings)
        assert found == [reading for t in ticks for reading in t.readings if type(reading) is kind_type]
    assert warnings == []


def test_every_number_keeps_its_last_bit_while_columns_widen(tmp_path: Path) -> None:
    """Float32, short decimals, any float64, infinities and None follow each other in one column."""
    draws = random.Random(7)
    values = [
        0.0,
        0.5,
        -0.1406,
        1e-300,
        1e300,
        math.inf,
        -0.0,
        0.1 + 0.2,
        None,
        *(draws.gauss(0.0, 1e3) for _ in range(50)),
    ]
    times = [round(0.1 * n, 6) for n in range(40)] + [draws.uniform(0.0, 10.0) for _ in range(len(values) - 40)]
    wanted = [
        ManualInput(t, "gcs", value, None, 1.0, n) for n, (t, value) in enumerate(zip(times, values, strict=True))
    ]
    ticks, warnings = back(
        file_of([replace(tick(0.1 * n), readings=(r,)) for n, r in enumerate(wanted)], tmp_path / "a")
    )
    found = [r for t in ticks for r in t.readings]
    assert warnings == [] and found == wanted and [repr(r) for r in found] == [repr(r) for r in wanted]


def test_the_order_of_arrival_is_kept(tmp_path: Path) -> None:
    rc = [RcInput(THIRD * n, "board", tuple(0.1 * k for k in range(n)), bool(n % 2)) for n in range(4)]
    heading = Heading(THIRD, "gnss", 1.0, 0.02)
    mixed = (rc[0], heading, READINGS[0], rc[1], rc[2], heading, rc[3])
    ticks, _ = back(file_of([replace(tick(1.0), readings=mixed)], tmp_path / "a"))
    assert ticks[0].readings == mixed


def test_a_tick_comes_back_as_it_was(tmp_path: Path) -> None:
    thrusters = (ThrusterCommand(0.0, 0.5, None), ThrusterCommand(0.0, -0.1, 1.2))
    setpoints = (
        PoseSetpoint(1.0, THIRD, -3.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6),
        HeadingSetpoint(yaw_rad=0.5, wrench=Wrench(1.0, 2.0, 3.0)),
        ThrusterSetpoint(thrusters=thrusters),
        NeutralSetpoint(),
    )
    ticks, _ = back(
        file_of([replace(tick(0.1 * n + THIRD), setpoint=s) for n, s in enumerate(setpoints)], tmp_path / "a")
    )
    assert [t.setpoint for t in ticks] == list(setpoints)
    one = tick(THIRD)
    assert ticks[0].t_s == THIRD and ticks[0].pose == (1.5, -2.0, 0.3, 0.4, 0.0, 0.01) and ticks[0].armed
    assert ticks[0].demanded == one.wrench and ticks[0].achieved == one.allocation.achieved


def test_parameters_packets_and_health_belong_to_the_tick_after_them(tmp_path: Path) -> None:
    encoder = McapEncoder()
    encoder.tick(tick(0.0), ())
    encoder.parameter("DP_DAMPING", 0.7)
    encoder.packet("px4", "udp 10.0.0.1", 0.05, b"\xfd\x00\x01")
    encoder.tick(tick(0.1), [DeviceHealth("imu", False, None, "silent"), DeviceHealth("gnss", True, None, "")])
    (tmp_path / "a").write_bytes(encoder.header() + encoder.end())
    ticks, _ = back(tmp_path / "a")
    assert [t.parameters for t in ticks] == [(), (("DP_DAMPING", 0.7),)]
    (packet,) = ticks[1].packets
    assert (packet.t_s, packet.persona, packet.endpoint, packet.data) == (0.05, "px4", "udp 10.0.0.1", b"\xfd\x00\x01")
    assert [(h.name, h.ok, h.text) for h in ticks[1].health] == [("imu", False, "silent"), ("gnss", True, "")]


def test_the_mcap_library_reads_every_message(tmp_path: Path) -> None:
    event = Event(0.3, TextKind.ALARM, "leak", "Water ö")
    rows = sailed(30)
    rows[3] = replace(rows[3], events=(event,), readings=(*rows[3].readings, *READINGS))
    found: dict[str, list[object]] = {}
    with file_of(rows, tmp_path / "a.mcap").open("rb") as file:
        for schema, channel, message, decoded in make_reader(
            file, decoder_factories=[DecoderFactory()]
        ).iter_decoded_messages():
            assert schema is not None
            found.setdefault(channel.topic + " " + schema.name.partition("_")[0], []).append(
                (message.log_time, decoded)
            )
    ns, fix = found["/position foxglove.LocationFix"][0]  # type: ignore[misc]
    assert fix.latitude == pytest.approx(63.4, abs=1e-9) and fix.timestamp.seconds * 10**9 == ns
    pose = found["/pose foxglove.PoseInFrame"][0][1].pose  # type: ignore[index]
    assert (pose.position.x, pose.position.y) == pytest.approx((-2.0, 1.5), abs=1e-4), "east, north"
    yaw = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
    assert math.pi / 2 - yaw == pytest.approx(0.3, abs=1e-5), "counter-clockwise from east"
    (said,) = found["/log foxglove.Log"]
    assert (said[1].message, said[1].name, said[1].level) == ("Water ö", "leak", 5)  # type: ignore[index]
    imu = found["/imu/imu usv.Imu"][0][1]  # type: ignore[index]
    assert list(imu.x_mps2) == [r.x_mps2 for r in rows[0].readings if isinstance(r, Imu)]
    assert list(imu.age_us) == [90000 - 10000 * k for k in range(10)]
    assert len(found["/tick usv.Tick"]) == 30 and found["/tick usv.Tick"][5][1].mode == "Hold"  # type: ignore[index]
    assert {topic.split()[0].rpartition("/")[2] for topic in found} >= set(KINDS)


@pytest.mark.parametrize("seed", range(6))
def test_a_file_cut_anywhere_is_read_up_to_its_last_whole_chunk(tmp_path: Path, seed: int) -> None:
    cut_and_read(tmp_path, random.Random(seed))


@pytest.mark.sweep
def test_a_file_cut_at_100_lengths_is_read_up_to_its_last_whole_chunk(tmp_path: Path) -> None:
    draws = random.Random(99)
    for _ in range(100):
        cut_and_read(tmp_path, draws)


def cut_and_read(folder: Path, draws: random.Random) -> None:
    rows = sailed(110)
    encoder, ends = McapEncoder(), []
    data = bytearray(encoder.header())
    for n, one in enumerate(rows):
        encoder.tick(one, ())
        if chunk := encoder.due():
            data += chunk
            ends.append((len(data), n + 1))
    cut = draws.randrange(len(data))
    (folder / "cut.mcap").write_bytes(data[:cut])
    ticks, warnings = back(folder / "cut.mcap")
    whole = max((count for end, count in ends if end <= cut), default=0)
    assert [t.readings for t in ticks] == [one.readings for one in rows[:whole]]
    assert len(warnings) == 1 and "cut.mcap" in warnings[0]
    assert max(b - a for (_, a), (_, b) in pairwise(ends)) <= 10 * CHUNK_S + 1, "little is lost"


def test_a_damaged_chunk_costs_its_own_ticks_alone(tmp_path: Path) -> None:
    rows = sailed(100)
    path = file_of(rows, tmp_path / "a.mcap")
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0x40
    path.write_bytes(data)
    ticks, warnings = back(path)
    assert len(warnings) == 1 and "chunk at byte" in warnings[0]
    assert 100 - 10 * CHUNK_S - 1 <= len(ticks) < 100 and ticks[-1].readings == rows[-1].readings


@pytest.mark.parametrize("data", [b"", b"\x89MCAP", b"kind,source,values\n" * 9])
def test_what_is_no_mcap_file_is_said(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "a.mcap").write_bytes(data)
    ticks, warnings = back(tmp_path / "a.mcap")
    assert ticks == [] and warnings == ["a.mcap: not an MCAP file, or empty"]


def test_a_warning_is_written_at_once(tmp_path: Path) -> None:
    encoder = McapEncoder()
    encoder.tick(tick(0.0), ())
    encoder.tick(replace(tick(0.1), events=(Event(0.1, TextKind.ROUTINE, "said", "a"),)), ())
    assert encoder.due() == b""
    encoder.tick(replace(tick(0.2), events=(Event(0.2, TextKind.ATTENTION, "said", "b"),)), ())
    assert encoder.due() != b"" and encoder.due() == b""


def test_a_file_that_begins_later_knows_all_channels(tmp_path: Path) -> None:
    """A log goes on in a new folder after its medium was full."""
    encoder, rows = McapEncoder(), sailed(60)
    for one in rows[:30]:
        encoder.tick(one, ())
        encoder.due()
    encoder.chunk()
    data = encoder.header()
    for one in rows[30:]:
        encoder.tick(one, ())
        data += encoder.due()
    (tmp_path / "b.mcap").write_bytes(data + encoder.end())
    ticks, warnings = back(tmp_path / "b.mcap")
    assert warnings == [] and [t.readings for t in ticks] == [one.readings for one in rows[30:]]


def test_a_kind_that_has_no_row_yet_ends_nothing(tmp_path: Path) -> None:
    @dataclass(frozen=True)
    class Sonar:
        t_s: float = 0.0
        source: str = "sonar"

    path = file_of([replace(tick(0.0), readings=(Sonar(), READINGS[2]))], tmp_path / "a")  # type: ignore[arg-type]
    assert back(path)[0][0].readings == (READINGS[2],)


def test_a_reading_that_cannot_be_packed_ends_nothing_and_is_said_once(tmp_path: Path) -> None:
    beyond = TimeOfDay(THIRD, "gnss", 2**70)
    rows = [replace(tick(0.1 * n), readings=(READINGS[2], beyond, READINGS[3])) for n in range(3)]
    path = file_of(rows, tmp_path / "a.mcap")
    ticks, warnings = back(path)
    assert warnings == [] and [t.readings for t in ticks] == [(READINGS[2], READINGS[3])] * 3
    with path.open("rb") as file:
        decoded = make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages(topics=["/log"])
        (said,) = [message.message for _, _, _, message in decoded]
    assert said.startswith("gnss: readings left out of the log (error: ")


def test_before_the_first_fix_no_place_is_shown(tmp_path: Path) -> None:
    lost = tick(0.0)
    lost = replace(lost, nav=replace(lost.nav, position_valid=False, position_accuracy_m=math.inf, fix=FixType.NONE))
    path = file_of([lost], tmp_path / "a.mcap")
    with path.open("rb") as file:
        topics = {channel.topic for _, channel, _ in make_reader(file).iter_messages()}
    assert topics == {"/tick"}

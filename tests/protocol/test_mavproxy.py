"""A day's work by MAVProxy, headless, against the running process."""

from __future__ import annotations

import math
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from companion.core.geodesy import LocalFrame
from companion.params.table import TABLE
from tests.protocol.mavproxy import MavProxy
from tests.protocol.process import Companion, free_port

pytestmark = pytest.mark.process

FRAME = LocalFrame(63.4389, 10.3990)
CORNERS = ((8.0, 0.0), (8.0, 8.0), (0.0, 8.0), (0.0, 0.0))


def row(
    seq: int,
    command: int,
    point: tuple[float, float] | None = None,
    params: tuple[float, ...] = (0, 0, 0, 0),
    frame: int = 3,
) -> str:
    lat_deg, lon_deg = FRAME.to_geodetic(*point) if point else (0.0, 0.0)
    cells = [seq, int(seq == 0), frame, command, *params, f"{lat_deg:.7f}", f"{lon_deg:.7f}", 0.0, 1]
    return "\t".join(str(cell) for cell in cells)


def twelve_rows() -> list[str]:
    far = ((20.0, -8.0), (60.0, -8.0), (60.0, -20.0), (20.0, -20.0), (0.0, 0.0))
    rows = [row(0, 178, params=(1.0, 0.9, -1.0, 0.0))]
    rows += [row(n, 16, corner) for n, corner in enumerate(CORNERS, start=1)]
    rows += [row(5, 19, (-4.0, 4.0), (2.0, 0, 0, 0)), row(6, 93, params=(1.0, -1.0, -1.0, -1.0))]
    return rows + [row(n, 16, point) for n, point in enumerate(far, start=7)]


def write(path: Path, rows: list[str]) -> Path:
    path.write_text("QGC WPL 110\n" + "\n".join(rows) + "\n", encoding="utf-8")
    return path


def items_of(path: Path) -> list[list[float]]:
    lines = path.read_text(encoding="utf-8").splitlines()[1:]
    return [[float(cell) for cell in line.split("\t")] for line in lines if line.strip()]


def same_items(first: Path, second: Path) -> bool:
    """Everything but the `current` flag, which is a state of the vehicle, not of the plan. MAVProxy writes six
    decimals."""
    a, b = ([[*item[:1], *item[2:]] for item in items_of(path)] for path in (first, second))
    return len(a) == len(b) and all(
        math.isclose(x, y, abs_tol=1e-6)
        for left, right in zip(a, b, strict=True)
        for x, y in zip(left, right, strict=True)
    )


def test_a_mission_from_upload_to_disarming(tmp_path: Path) -> None:
    with (
        Companion(tmp_path, speed=10.0) as companion,
        MavProxy(f"tcp:127.0.0.1:{companion.tcp_port}", tmp_path / "mavproxy") as station,
    ):
        station.expect("online system 1")
        station.expect(f"Received {len(TABLE)} parameters")
        station.ask("param show PATH_BW_SURGE", r"PATH_BW_SURGE\s+0\.(4|39999)")
        station.say("param set PATH_BW_SURGE 0.5")
        station.ask("param show PATH_BW_SURGE", r"PATH_BW_SURGE\s+0\.5")
        station.say("mode")
        station.expect("Available modes.*MISSION")

        plan = write(tmp_path / "plan.txt", twelve_rows())
        station.say(f"wp load {plan}")
        station.expect(r"Loaded 12 waypoints in")
        station.say("wp list")
        station.expect(r"Saved 12 waypoints to .*way.txt")
        station.say(f"wp save {tmp_path / 'back.txt'}")
        station.expect(r"Saved 12 waypoints to .*back.txt")
        assert same_items(plan, tmp_path / "back.txt")

        rally = write(tmp_path / "rally.txt", [row(0, 5100, (3.0, -3.0)), row(1, 5100, (30.0, 30.0))])
        station.say(f"rally load {rally}")
        station.expect(r"Loaded 2 rally items in")
        box = [
            row(n, 5001, (150.0 * math.cos(a), 150.0 * math.sin(a)), (4.0, 0, 0, 0))
            for n, a in enumerate((0.7, 2.4, 3.9, 5.5))
        ]
        fence = write(tmp_path / "fence.txt", box)
        station.say(f"fence load {fence}")
        station.expect(r"Loaded 4 fence items in")

        station.ask("arm throttle", "Got COMMAND_ACK: COMPONENT_ARM_DISARM: ACCEPTED", again_s=2.0)
        station.say("long DO_SET_MODE 1 4 4")  # by number: its names for PX4 modes fail in MAVProxy itself
        station.expect("Mode MISSION")
        station.expect("waypoint 3")
        station.say("long DO_SET_MODE 1 4 3")
        station.expect("Mode LOITER")
        station.say("guided {} {} 0".format(*FRAME.to_geodetic(-6.0, -6.0)))
        station.expect("Got COMMAND_ACK: DO_REPOSITION: ACCEPTED")
        station.say("long DO_SET_MODE 1 4 4")
        station.expect("Mode MISSION")
        station.expect(r"waypoint \d")
        station.say("long NAV_RETURN_TO_LAUNCH")
        station.expect("Mode RTL")
        station.say("disarm")
        station.expect("Got COMMAND_ACK: COMPONENT_ARM_DISARM: ACCEPTED")
    companion.start()
    try:
        with MavProxy(f"tcp:127.0.0.1:{companion.tcp_port}", tmp_path / "mavproxy2") as station:
            station.expect(f"Received {len(TABLE)} parameters")
            station.ask("param show PATH_BW_SURGE", r"PATH_BW_SURGE\s+0\.5")
    finally:
        companion.kill()


@contextmanager
def rover_station(folder: Path) -> Iterator[MavProxy]:
    """MAVProxy on a link of a running companion that speaks ArduPilot's dialect, with all parameters."""
    tcp_port = free_port(socket.SOCK_STREAM)
    links = (f"tcpin:127.0.0.1:{tcp_port}?dialect=ardupilot",)
    with (
        Companion(folder, speed=10.0, links=links),
        MavProxy(f"tcp:127.0.0.1:{tcp_port}", folder / "mavproxy") as station,
    ):
        station.expect("online system 1")
        station.expect(f"Received {len(TABLE)} parameters")
        yield station


def test_rover_mode_names_on_a_link_that_speaks_ardupilot(tmp_path: Path) -> None:
    """Home is item 0 there, and `auto`, `rtl` and `hold` are words."""
    with rover_station(tmp_path) as station:
        rows = [row(0, 16, (0.0, 0.0))] + [row(n, 16, corner) for n, corner in enumerate(CORNERS, start=1)]
        station.say(f"wp load {write(tmp_path / 'plan.txt', rows)}")
        station.expect("Got MISSION_ACK: TYPE_MISSION: ACCEPTED")
        station.ask("arm throttle", "Got COMMAND_ACK: COMPONENT_ARM_DISARM: ACCEPTED", again_s=2.0)
        station.say("auto")
        station.expect("Mode AUTO")
        station.expect("waypoint 2")
        station.say("mode hold")
        station.expect("Mode HOLD")
        station.say("mode guided")
        station.expect("Mode GUIDED")
        station.say("guided forward 10")
        station.expect("Going to a point 10 m away")
        station.say("mode rtl")
        station.expect("Mode RTL")
        station.say("disarm")
        station.expect("Got COMMAND_ACK: COMPONENT_ARM_DISARM: ACCEPTED")
        assert "ARMED" in station.printed and "Arming checks disabled" not in station.printed


def test_marks_fence_and_guided_limits_by_command(tmp_path: Path) -> None:
    """A mission with JUMP_TAG and DO_FENCE_ENABLE there and back, and their commands as MAVProxy sends them."""
    with rover_station(tmp_path) as station:
        rows = [row(0, 16, (0.0, 0.0)), row(1, 16, (8.0, 0.0)), row(2, 600, params=(7.0, 0, 0, 0))]
        rows += [row(3, 16, (8.0, 8.0)), row(4, 207, params=(1.0, 0, 0, 0)), row(5, 601, params=(7.0, 1.0, 0, 0))]
        plan = write(tmp_path / "plan.txt", rows)
        station.say(f"wp load {plan}")
        station.expect("Got MISSION_ACK: TYPE_MISSION: ACCEPTED")
        back = tmp_path / "back.txt"
        station.say(f"wp save {back}")
        station.expect("Saved 6 waypoints to")
        sent, got = ([item[3:6] for item in items_of(path)[1:]] for path in (plan, back))
        assert sent == got, "commands and their first parameters; item 0 is the boat's own home"
        station.say("long DO_JUMP_TAG 7 0 0 0 0 0 0")
        station.expect("Got COMMAND_ACK: DO_JUMP_TAG: ACCEPTED")
        station.say("long DO_JUMP_TAG 8 0 0 0 0 0 0")
        station.expect("Got COMMAND_ACK: DO_JUMP_TAG: DENIED")
        station.say("long DO_GUIDED_LIMITS 30 0 0 50 0 0 0")
        station.expect("Got COMMAND_ACK: DO_GUIDED_LIMITS: ACCEPTED")
        for value, text in ((0, "Fence off until switched on or disarmed"), (1, "Fence on, but there is none")):
            station.say(f"long DO_FENCE_ENABLE {value} 0 0 0 0 0 0")
            station.expect(text)
        station.say("long DO_SET_REVERSE 1 0 0 0 0 0 0")
        station.expect("Got COMMAND_ACK: DO_SET_REVERSE: TEMPORARILY_REJECTED")
        station.ask("arm throttle", "Got COMMAND_ACK: COMPONENT_ARM_DISARM: ACCEPTED", again_s=2.0)
        station.say("mode SMART_RTL")
        station.expect("Mode SMART_RTL")


def test_circle_by_its_rover_name_by_command_and_in_a_mission(tmp_path: Path) -> None:
    """`mode CIRCLE` knows only ArduPilot's numbers; DO_ORBIT goes out as COMMAND_LONG."""
    with rover_station(tmp_path) as station:
        station.say("param set CIRC_RADIUS 8")
        station.ask("param show CIRC_RADIUS", r"CIRC_RADIUS\s+8\.0")
        station.ask("arm throttle", "Got COMMAND_ACK: COMPONENT_ARM_DISARM: ACCEPTED", again_s=2.0)
        station.say("mode CIRCLE")
        station.expect_all("Mode CIRCLE", "Circle: radius 8.0 m, clockwise")
        station.say("mode hold")
        station.expect("Mode HOLD")
        station.say("long DO_ORBIT -6 0.9 0 3.2 {} {} 0".format(*FRAME.to_geodetic(9.0, 0.0)))
        station.expect_all(
            "Got COMMAND_ACK: DO_ORBIT: ACCEPTED", "Circle: radius 6.0 m, counter-clockwise, 0.509 turns"
        )
        station.expect(r"Circle: 0\.5 turns done, holding")
        rows = [row(0, 16, (0.0, 0.0)), row(1, 16, (15.0, 4.0)), row(2, 18, (15.0, 12.0), (1.0, 0.0, 6.0, 1.0))]
        station.say(f"wp load {write(tmp_path / 'plan.txt', [*rows, row(3, 16, (0.0, 0.0))])}")
        station.expect("Got MISSION_ACK: TYPE_MISSION: ACCEPTED")
        station.say("auto")
        station.expect("Mode AUTO")
        station.expect("waypoint 3")

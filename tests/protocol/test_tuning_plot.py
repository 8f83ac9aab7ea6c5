"""What QGroundControl's tuning pages plot: asked for at 100 Hz by SET_MESSAGE_INTERVAL, sent once a tick, and given back
to the default rates at the end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from pymavlink.rotmat import Matrix3, Vector3

from companion.io.mavlink.wire import messages as mavlink
from tests.protocol.desk import Desk, of

SET_INTERVAL, REPOSITION, ARM = 511, 192, 400
QUATERNION, TARGET, LOCAL, LOCAL_TARGET, NAVIGATION = 31, 83, 32, 85, 62
HOLD = 0x03040000
EVERY_US = 10_000


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    """A boat on its way to a point 12 m to the north-east, bow to the south-east."""
    made = Desk(tmp_path)
    made.ready()
    made.tell(mavlink.MAVLink_set_mode_message(1, 1, HOLD))
    assert made.result(ARM, 1) == 0
    lat_deg, lon_deg = made.vessel.frame.to_geodetic(8.0, 8.0)
    x, y = round(lat_deg * 1e7), round(lon_deg * 1e7)
    made.tell(
        mavlink.MAVLink_command_int_message(1, 1, 0, REPOSITION, 0, 0, -1.0, 1.0, 0.0, math.radians(135.0), x, y, 0.0)
    )
    made.tick(30)
    return made


def plotted(desk: Desk, numbers: Sequence[int], ticks: int = 50) -> list[Any]:
    """As its stream configuration does it: one message after the other, each after the answer to the one before."""
    for number in numbers:
        assert desk.result(SET_INTERVAL, number, EVERY_US) == 0
    return desk.tick(ticks)


def yaw_of(message: Any) -> float:
    """By pymavlink's own rotations."""
    w, x, y, z = message.q if hasattr(message, "q") else (message.q1, message.q2, message.q3, message.q4)
    rows = [
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    ]
    return float(Matrix3(*(Vector3(*row) for row in rows)).to_euler()[2])


def test_yaw_and_yaw_rate(desk: Desk) -> None:
    heard = plotted(desk, (TARGET, QUATERNION))
    done, asked = of(heard, "ATTITUDE_QUATERNION"), of(heard, "ATTITUDE_TARGET")
    assert len(done) == len(asked) == 50, "once a tick, more there is not"
    assert [m.time_boot_ms for m in done] == [m.time_boot_ms for m in asked]
    errors = [abs(math.remainder(yaw_of(a) - yaw_of(d), math.tau)) for a, d in zip(asked, done, strict=True)]
    assert max(errors) < math.radians(40.0) and max(abs(yaw_of(a)) for a in asked) > math.radians(20.0)
    assert max(abs(a.body_yaw_rate) for a in asked) > 0.02
    assert max(abs(a.body_yaw_rate - d.yawspeed) for a, d in zip(asked, done, strict=True)) < 0.3
    assert all(a.type_mask == 3 and -1.0 <= a.thrust <= 1.0 for a in asked)
    tick = desk.vessel.last_tick
    assert tick is not None and yaw_of(done[-1]) == pytest.approx(tick.nav.yaw_rad, abs=1e-5)
    desk.close()


def test_velocity_and_position(desk: Desk) -> None:
    heard = plotted(desk, (LOCAL_TARGET, LOCAL))
    done, asked = of(heard, "LOCAL_POSITION_NED"), of(heard, "POSITION_TARGET_LOCAL_NED")
    assert len(done) == len(asked) == 50
    speeds = [(math.hypot(a.vx, a.vy), math.hypot(d.vx, d.vy)) for a, d in zip(asked, done, strict=True)]
    assert max(asked_mps for asked_mps, _ in speeds) > 0.2
    assert all(abs(asked_mps - done_mps) < 0.2 for asked_mps, done_mps in speeds)
    assert all(math.hypot(a.x - d.x, a.y - d.y) < 1.0 for a, d in zip(asked, done, strict=True))
    desk.close()


def test_speed_error(desk: Desk) -> None:
    output = of(plotted(desk, (NAVIGATION, 74)), "NAV_CONTROLLER_OUTPUT")
    assert len(output) == 50 and max(abs(m.aspd_error) for m in output) < 0.3
    assert any(m.aspd_error for m in output)
    desk.close()


def test_the_default_rates_come_back(desk: Desk) -> None:
    plotted(desk, (TARGET, QUATERNION, LOCAL_TARGET, LOCAL), 5)
    for number in (TARGET, QUATERNION, LOCAL_TARGET, LOCAL):
        assert desk.result(SET_INTERVAL, number, 0) == 0
    desk.tick(1)
    heard = desk.tick(50)
    assert not of(heard, "ATTITUDE_TARGET") and not of(heard, "ATTITUDE_QUATERNION")
    assert 9 <= len(of(heard, "LOCAL_POSITION_NED")) <= 11 and len(of(heard, "ATTITUDE")) == 50
    desk.close()


def test_without_a_heading_to_steer_nothing_is_asked(tmp_path: Path) -> None:
    desk = Desk(tmp_path)
    desk.ready()
    heard = plotted(desk, (TARGET, QUATERNION), 10)
    assert len(of(heard, "ATTITUDE_QUATERNION")) == 10 and not of(heard, "ATTITUDE_TARGET")
    desk.close()

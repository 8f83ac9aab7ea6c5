"""The transmitter's switches as a person sets them up in QGroundControl and throws them: a whole vessel in lockstep, its
receiver on the thruster board."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from companion.io.mavlink.wire import messages as mavlink
from tests.protocol.desk import Desk
from tests.protocol.test_qgroundcontrol import ARM, HOLD, MANUAL, RTL
from tests.protocol.test_qgroundcontrol_pages import write

CENTRED = (1500, 1500, 1500, 1500, 1000, 1000, 1000, 1000)
ON = 2000


class Hand:
    """Holds the transmitter."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        self.pulses = list(CENTRED)
        self.throw()

    def throw(self, **pulses: int) -> None:
        """`c6=2000`: that channel, held for a second."""
        for name, pulse_us in pulses.items():
            self.pulses[int(name[1:]) - 1] = pulse_us
        self.desk.rig.world.set_transmitter(self.pulses)
        self.desk.heartbeat()
        self.desk.tick(round(1.0 / self.desk.vessel.period_s))

    @property
    def armed(self) -> bool:
        return bool(self.desk.latest("HEARTBEAT").base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)

    @property
    def mode(self) -> int:
        return int(self.desk.latest("HEARTBEAT").custom_mode)


@pytest.fixture
def hand(tmp_path: Path) -> Iterator[Hand]:
    desk = Desk(tmp_path)
    desk.tick()
    hand = Hand(desk)
    desk.ready()
    yield hand
    desk.close()


def test_arm_mode_and_kill_by_the_transmitter_alone(hand: Hand) -> None:
    desk = hand.desk
    for name, value in {
        "MAN_RC_SAFE_CH": 0, "RC_MAP_FLTMODE": 5, "RC_MAP_ARM_SW": 6, "RC_MAP_KILL_SW": 7, "RC_MAP_RETURN_SW": 8,
        "COM_FLTMODE1": 0, "COM_FLTMODE6": 4,
    }.items():  # fmt: skip
        assert write(desk, name, value) == value
    hand.throw()
    assert "Mode switch at 1, Manual: it acts when moved" in desk.texts()
    hand.throw(c5=ON)
    assert hand.mode == HOLD and not hand.armed
    hand.throw(c6=ON)
    assert hand.armed
    hand.throw(c8=ON)
    assert hand.mode == RTL
    hand.throw(c8=1000)
    assert hand.mode == HOLD, "back to the mode switch"
    hand.throw(c5=1000)
    assert hand.mode == MANUAL
    hand.throw(c2=1800)
    tick = desk.vessel.last_tick
    assert tick is not None and any(thruster.throttle > 0.1 for thruster in tick.command.thrusters)

    hand.desk.rig.world.set_transmitter([*hand.pulses[:6], ON, hand.pulses[7]])
    desk.tick(2)
    tick = desk.vessel.last_tick
    assert (
        tick is not None and not tick.status.armed and not any(thruster.throttle for thruster in tick.command.thrusters)
    )
    assert "Kill switch is on: thrusters stopped" in desk.texts()
    hand.throw(c7=ON)
    for force in (0.0, 2989.0):
        assert desk.result(ARM, 1.0, force) == mavlink.MAV_RESULT_TEMPORARILY_REJECTED
    hand.throw(c7=1000, c2=1500)
    assert not hand.armed, "it stays disarmed until somebody arms it"
    assert desk.result(ARM, 1.0) == mavlink.MAV_RESULT_ACCEPTED


def test_radio_calibration_as_qgroundcontrol_writes_it(hand: Hand) -> None:
    """A transmitter whose forward stick is reversed, on channel 3, with short travel."""
    desk = hand.desk
    hand.throw(c3=1880)
    assert desk.latest("RC_CHANNELS").chan3_raw == 1880
    for name, value in {"RC3_MIN": 1120, "RC3_TRIM": 1500, "RC3_MAX": 1880, "RC3_REV": -1, "RC_MAP_PITCH": 3}.items():
        assert write(desk, name, value) == value
    hand.throw()
    live = desk.vessel.supervisor.parts.sticks.live(desk.rig.now_s)
    assert live is not None and live.surge == pytest.approx(-1.0)
    assert desk.latest("RC_CHANNELS").chan3_raw == 1880, "the monitor shows the pulse as it comes"

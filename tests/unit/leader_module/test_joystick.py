"""A gamepad's events, from real bytes through real descriptors."""

from __future__ import annotations

import os
import random
import struct
import tty
from pathlib import Path

import pytest

from companion.leader_module.config import JoystickConfig
from companion.leader_module.joystick import Joystick, JoystickDecoder


def event(value: int, kind: int, number: int, t_ms: int = 0) -> bytes:
    """`struct js_event` of linux/joystick.h."""
    return struct.pack("=IhBB", t_ms, value, kind, number)


OPENING = b"".join([event(0, 0x81, n) for n in range(3)] + [event(0, 0x82, n) for n in range(4)])


def test_events_may_be_cut_anywhere() -> None:
    rng = random.Random(4)
    data = OPENING + b"".join(
        event(rng.randrange(-32767, 32768), rng.choice([1, 2]), rng.randrange(4)) for _ in range(500)
    )
    whole, cut = JoystickDecoder(), JoystickDecoder()
    whole.feed(data)
    while data:
        n = rng.randrange(1, 20)
        cut.feed(data[:n])
        data = data[n:]
    assert cut.axes == whole.axes and set(cut.axes) == {0, 1, 2, 3}
    cut.feed(event(-32768, 2, 1))
    assert cut.axes[1] == -1.0
    cut.feed(event(1, 1, 1) + event(16384, 2, 1))
    assert cut.axes[1] == pytest.approx(0.5, abs=1e-4)


def test_sticks_of_a_device_that_comes_and_goes(tmp_path: Path) -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    device = tmp_path / "js0"
    joystick = Joystick(JoystickConfig(device=str(device)))
    assert joystick.read(0.0) is None and not joystick.health(0.0).ok and "No such file" in joystick.health(0.0).text
    device.symlink_to(os.ttyname(slave))
    assert joystick.read(0.5) is None, "it is tried once a second"
    assert joystick.read(1.0) is None and joystick.health(1.0).ok and joystick.fileno() is not None
    os.write(master, OPENING)
    sticks = joystick.read(1.1)
    assert sticks is not None and (sticks.surge, sticks.sway, sticks.yaw) == (0.0, 0.0, 0.0)
    os.write(master, event(-32767, 2, 1) + event(16384, 2, 3) + event(-8192, 2, 0))
    sticks = joystick.read(1.2)
    assert sticks is not None and (sticks.surge, sticks.sway, sticks.yaw) == pytest.approx((1.0, -0.25, 0.5), abs=1e-3)
    sticks = joystick.read(60.0)
    assert sticks is not None and sticks.t_s == 60.0 and sticks.surge == 1.0, "held still, it says nothing"
    os.close(slave)
    os.close(master)
    assert joystick.read(60.1) is None and not joystick.health(60.1).ok
    master, slave = os.openpty()
    tty.setraw(slave)
    device.unlink()
    device.symlink_to(os.ttyname(slave))
    assert joystick.read(61.2) is None, "nothing is known of the new one yet"
    os.write(master, OPENING)
    assert joystick.read(61.3) is not None
    joystick.close()
    os.close(slave)
    os.close(master)


def test_axes_as_configured(tmp_path: Path) -> None:
    device = tmp_path / "js0"
    os.mkfifo(device)
    joystick = Joystick(
        JoystickConfig(device=str(device), surge_axis=2, yaw_axis=0, sway_axis=None, reversed=("surge",))
    )
    writer = os.open(device, os.O_RDWR | os.O_NONBLOCK)
    assert joystick.read(2.0) is None
    os.write(writer, event(16384, 0x82, 2) + event(-16384, 0x82, 0))
    sticks = joystick.read(2.1)
    assert sticks is not None and sticks.sway is None
    assert (sticks.surge, sticks.yaw) == pytest.approx((0.5, -0.5), abs=1e-3)
    os.close(writer)
    assert joystick.read(2.2) is None
    joystick.close()

"""The log of the module on a lead boat: its readings, and the compass that is calibrated from them."""

from __future__ import annotations

import errno
import os
from dataclasses import replace
from pathlib import Path

import pytest

from companion.analysis.log_reader import LogError, open_log, open_sensor_log
from companion.app import load_vessel
from companion.cli.main import main
from companion.clock import SimulatedClock
from companion.config.vessel import HomeConfig
from companion.io.mavlink.wire.links import MemoryLink
from companion.leader_module.app import LeaderSurroundings, build_leader
from companion.leader_module.config import LeaderConfig
from companion.record.mcap_log import FILE
from companion.record.mcap_reader import has_end
from sitl.magnetometer import with_magnetometer
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions
from tests.faulty_disk import FaultyDisk
from tests.protocol.lead_boat_module import NoDisplay

CIRCLES = ((10.0, 0.0), (63.0, 0.2), (63.0, -0.2))  # (s, rad/s)


@pytest.fixture(scope="module")
def turned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log of a module whose boat turned twice to each side; its file says nothing of the iron aboard."""
    folder = tmp_path_factory.mktemp("leader") / "log"
    boat = with_magnetometer(load_vessel("rescuerunner"))
    world, clock = World(boat, WorldConditions(seed=722200)), SimulatedClock(EPOCH_UNIX_NS)
    plain = tuple(
        replace(row, mag_offset=(0.0, 0.0, 0.0), mag_matrix=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
        for row in boat.sensors
    )
    config = LeaderConfig("lead", 42, ("memory:far",), plain, home=HomeConfig(0.0, 0.0))
    around = LeaderSurroundings(clock, world, [MemoryLink("memory:far")], [], NoDisplay(), folder)
    module, step, yaw_rad = build_leader(config, around), 0, 0.0
    for duration_s, rate_radps in CIRCLES:
        for _ in range(round(20 * duration_s)):
            clock.wait(0.05 * step, ())
            world.set_state(0.0, 0.0, yaw_rad, 0.0, 0.0, rate_radps)
            world.advance(clock.now_s())
            module.tick(clock.now_s())
            step, yaw_rad = step + 1, yaw_rad + 0.05 * rate_radps
    module.close()
    return folder


def test_a_compass_is_calibrated_from_the_log_of_a_module(
    turned: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The module recorded no reading, and its manifest was no vessel's."""
    assert main(["calibrate", str(turned), "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr()
    print(printed.out)
    assert "left of" in printed.out and "of deviation remain" not in printed.err
    assert "mag_offset" in (tmp_path / "magnetometer.toml").read_text(encoding="utf-8")


def test_readings_of_a_module_become_tables(turned: Path, tmp_path: Path) -> None:
    assert main(["export", str(turned), "--to", "csv", "--out", str(tmp_path)]) == 0
    lines = (tmp_path / "imu_field.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "t_s,x,y,z" and len(lines) > 1000


def test_the_other_commands_say_whose_log_it_is(turned: Path) -> None:
    assert open_sensor_log(turned).config.sensors
    with pytest.raises(LogError, match="the log of a leader module"):
        open_log(turned)


def test_a_module_starts_on_a_full_medium_and_logs_later(tmp_path: Path) -> None:
    """It ended, and with it the follower's leader."""
    clock, disk, display = SimulatedClock(EPOCH_UNIX_NS), FaultyDisk(), NoDisplay()
    disk.fail_with(errno.ENOSPC)
    boat = load_vessel("rescuerunner")
    around = LeaderSurroundings(
        clock, World(boat, WorldConditions()), [MemoryLink("memory:far")], [], display, tmp_path / "log", disk=disk
    )
    module = build_leader(LeaderConfig("lead", 42, ("memory:far",), boat.sensors), around)
    module.tick(clock.now_s())
    assert f"log: stopped: {os.strerror(errno.ENOSPC)}" in display.said
    disk.fail_with(None)
    clock.wait(100.0, ())
    module.tick(clock.now_s())
    clock.wait(103.0, ())
    module.tick(clock.now_s())
    module.close()
    assert "log: back" in display.said
    assert len((tmp_path / "log" / "module.csv").read_text(encoding="utf-8").splitlines()) > 1
    assert has_end(tmp_path / "log" / FILE)

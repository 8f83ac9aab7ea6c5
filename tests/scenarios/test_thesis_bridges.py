"""ReVolt and ÅBOAT on the bridges that their theses had, as the tables in their files say: steppers on RS485, motors on
NMEA 2000."""

from __future__ import annotations

import math
from importlib import resources
from pathlib import Path

import pytest

from companion.analysis.log_reader import open_log
from companion.cli.rig import LockstepRig
from companion.config.vessel import as_dict
from companion.io.mavlink.wire import messages as mavlink
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.rig import Conditions
from tests.protocol.desk import Desk
from tests.protocol.driver import Driver
from tests.protocol.two_processes import TwoProcesses

HOLD = (1, 4, 3)


def desk_of(vessel: str, folder: Path) -> Desk:
    """The vessel in lockstep, ready to arm."""
    desk = Desk(folder, LockstepRig(Conditions(str(file_of(vessel, folder)), seed=3, wind="2@45"), folder / "log"))
    desk.tick()
    desk.ready()
    return desk


def file_of(vessel: str, folder: Path) -> Path:
    """The vessel's file with its alternative tables."""
    text = resources.files("companion.vessels").joinpath(f"{vessel}.toml").read_text(encoding="utf-8")
    assert "\n#> " in text
    if vessel == "aboat":
        text = text.replace('thrusters = ["bow", "stern"]\n', "", 1)
    file = folder / f"{vessel}.toml"
    file.write_text(text.replace("\n#> ", "\n"), encoding="utf-8")
    return file


def hold(desk: Desk, seconds: int) -> float:
    """How far it is off the point where it was told to hold, at the end."""
    truth = desk.rig.world.truth
    start = truth.north_m, truth.east_m
    for _ in range(seconds):
        desk.tick(10)
        desk.heartbeat()
    truth = desk.rig.world.truth
    return math.hypot(truth.north_m - start[0], truth.east_m - start[1])


def said(desk: Desk, begin: str) -> bool:
    """Whether a text begins so; long ones come in pieces of 50."""
    return any(text.startswith(begin[:45]) for text in desk.texts())


def armed(vessel: str, folder: Path) -> Desk:
    desk = desk_of(vessel, folder)
    assert desk.result(mavlink.MAV_CMD_DO_SET_MODE, *HOLD) == mavlink.MAV_RESULT_ACCEPTED
    assert desk.result(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0) == mavlink.MAV_RESULT_ACCEPTED
    return desk


@pytest.mark.parametrize(("vessel", "thruster", "within_m"), [("revolt", "stern_port", 0.5), ("aboat", "stern", 4.0)])
def test_it_holds_and_with_one_drive_lost_it_goes_on_with_the_rest(
    vessel: str, thruster: str, within_m: float, tmp_path: Path
) -> None:
    desk = armed(vessel, tmp_path)
    assert hold(desk, 12) < within_m
    assert all(device.ok for device in desk.vessel.device_health(desk.rig.now_s))
    tick = desk.vessel.last_tick
    assert tick is not None
    for command, report, truth in zip(
        tick.command.thrusters, tick.feedback, desk.rig.world.truth.thrusters, strict=True
    ):
        assert report is not None and report.ok and report.throttle is not None
        assert command.azimuth_rad is None or report.azimuth_rad == pytest.approx(truth[1], abs=math.radians(3.0))
    desk.rig.world.add_fault(f"drive_{thruster}_lost", 10.0)
    hold(desk, 3)
    assert said(desk, f"Thruster {thruster} failed: not used")
    assert all(device.ok for device in desk.vessel.device_health(desk.rig.now_s)), (
        "the bridge is well: one thruster is not"
    )
    hold(desk, 12)
    assert said(desk, f"Thruster {thruster} works again")
    assert hold(desk, 8) < within_m
    desk.close()
    assert as_dict(open_log(tmp_path / "log").config) == as_dict(desk.rig.config)


@pytest.mark.parametrize(("vessel", "bridge"), [("revolt", "azimuths"), ("aboat", "motors")])
def test_the_line_may_be_unplugged_and_comes_back(vessel: str, bridge: str, tmp_path: Path) -> None:
    desk = armed(vessel, tmp_path)
    hold(desk, 10)
    desk.rig.world.add_fault(f"{bridge}_unplugged", 4.0)
    hold(desk, 1)
    assert said(desk, f"{bridge}: ") and said(desk, f"Thruster bridge silent: {bridge}")
    hold(desk, 3)
    assert [round(thruster.throttle(), 1) for thruster in desk.rig.world.thrusters] == [0.0] * len(
        desk.rig.world.thrusters
    ), "neutral by rule"
    hold(desk, 4)
    assert said(desk, f"{bridge}: back") and all(device.ok for device in desk.vessel.device_health(desk.rig.now_s))
    desk.close()


@pytest.mark.process
@pytest.mark.sweep
@pytest.mark.parametrize(("vessel", "bridge", "within_m"), [("revolt", "azimuths", 1.0), ("aboat", "motors", 4.0)])
def test_it_holds_as_two_processes_and_the_line_may_be_unplugged(
    vessel: str, bridge: str, within_m: float, tmp_path: Path
) -> None:
    """RS485 on a pseudo-terminal; NMEA 2000 in UDP multicast, for the kernel here may have no virtual CAN."""
    with TwoProcesses(tmp_path, str(file_of(vessel, tmp_path)), Driver(0.05), "--wind", "2@45") as rig:
        print("\n".join(line for line in rig.hello if bridge in line))
        station = GroundStation(rig)
        station.ready()
        station.set_mode(0x03040000)
        station.arm()
        station.sail(8.0)
        before, typed_s = len(rig.events()), rig.type(f"{bridge}_unplugged+2.0")
        wanted = {f"{bridge}_lost", "bridge_silent", f"{bridge}_back", "bridge_silent_over"}
        station.wait(
            f"{bridge} lost and back", lambda: wanted <= {event["name"] for event in rig.events()[before:]}, 20.0
        )
        lost_s = next(float(event["t_s"]) for event in rig.events()[before:] if event["name"] == f"{bridge}_lost")
        assert lost_s - typed_s < 1.3, "0.8 s without a frame, and the pace of two processes"
        station.sail(5.0)
        last = rig.truth()[-1]
        assert station.last["HEARTBEAT"].base_mode & 128 and math.hypot(last["north_m"], last["east_m"]) < within_m

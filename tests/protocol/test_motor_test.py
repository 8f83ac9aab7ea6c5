"""Motor tests as QGroundControl's two pages and MAVProxy send them, on a simulated boat, by what its thrusters give."""

from __future__ import annotations

import math
import socket
from pathlib import Path

import pytest

from companion.config import vessel as config_module
from companion.io.mavlink.wire import messages as mavlink
from tests.protocol.afloat import Afloat
from tests.protocol.desk import Desk
from tests.protocol.mavproxy import MavProxy
from tests.protocol.process import free_port
from tests.waiting import wait_until

ACTUATOR_TEST, MOTOR_TEST, ARM, TAKE_CONTROL = 310, 209, 400, 32100
ACCEPTED, REJECTED, DENIED = 0, 1, 2
MOTOR_1 = 1101  # as QGroundControl sends the first motor of the metadata


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    made = Desk(tmp_path)
    made.ready()
    return made


def forces_n(desk: Desk) -> list[float]:
    return [thruster.force_n for thruster in desk.rig.world.thrusters]


def test_a_slider_of_qgroundcontrols_actuators_page(desk: Desk) -> None:
    """It streams the value with a time-out of a second, each after the answer to the one before; at the end NaN, 0."""
    full_n = desk.rig.world.thrusters[0].max_n
    for _ in range(20):
        assert desk.result(ACTUATOR_TEST, 0.2, 1, 0, 0, MOTOR_1) == ACCEPTED
        desk.tick()
    assert 0.02 * full_n < forces_n(desk)[0] < 0.05 * full_n, "a fifth of the throttle gives a 25th of the thrust"
    assert max(map(abs, forces_n(desk)[1:])) < 0.01
    assert not desk.vessel.supervisor.status(desk.rig.now_s).armed
    assert desk.result(ACTUATOR_TEST, math.nan, 0, 0, 0, MOTOR_1) == ACCEPTED
    desk.tick()
    tick = desk.vessel.last_tick
    assert tick is not None and not tick.command.armed and tick.command.thrusters[0].throttle == 0.0
    assert desk.texts().count("Motor test: stern_port at +20%") == 1
    desk.close()


def test_a_stream_that_breaks_off_ends_within_its_time(desk: Desk) -> None:
    assert desk.result(ACTUATOR_TEST, -0.3, 1, 0, 0, 2) == ACCEPTED
    desk.tick(9)
    assert forces_n(desk)[1] < -0.1
    desk.tick(20)
    assert abs(forces_n(desk)[1]) < 0.01
    desk.close()


def test_qgroundcontrols_motors_page(desk: Desk) -> None:
    """On an older one: DO_MOTOR_TEST with percent for 3 s."""
    assert desk.result(MOTOR_TEST, 2, 0, 15, 3, 0, 2) == ACCEPTED
    desk.tick(20)
    assert forces_n(desk)[1] > 0.1 and abs(forces_n(desk)[0]) < 0.01
    desk.until("the end", lambda: "Motor test over: stern_starboard" in desk.texts(), 5.0)
    assert desk.result(MOTOR_TEST, 1, 0, 15, 3) == ACCEPTED
    desk.tick(10)
    assert desk.result(MOTOR_TEST, 1, 0, 0, 0) == ACCEPTED
    desk.tick(20)
    assert abs(forces_n(desk)[0]) < 0.05
    desk.close()


@pytest.mark.parametrize(
    ("command", "params", "text"),
    [
        (ACTUATOR_TEST, (0.5, 1, 0, 0, 1), "Motor test refused: at most 30%"),
        (ACTUATOR_TEST, (0.1, 4, 0, 0, 1), "param 2 of an actuator test should be 0 to 3 s"),
        (ACTUATOR_TEST, (0.1, 1, 0, 0, 33), "motors alone are tested: param 5 from 1"),
        (ACTUATOR_TEST, (0.1, 1, 0, 0, 1104), "Motor test refused: this boat has motors 1 to 3"),
        (MOTOR_TEST, (1, 1, 1600, 1), "a motor test takes percent: param 2 = 0"),
        (MOTOR_TEST, (0, 0, 10, 1), "Motor test refused: this boat has motors 1 to 3"),
        (MOTOR_TEST, (1, 0, 10, 60), "Motor test refused: give more than 0 and at most 10 s"),
    ],
)
def test_what_is_refused(desk: Desk, command: int, params: tuple[float, ...], text: str) -> None:
    assert desk.result(command, *params) == DENIED
    desk.tick(5)
    assert text in "".join(desk.texts()) and max(map(abs, forces_n(desk))) < 0.01
    desk.close()


def test_an_armed_boat_refuses_and_arming_ends_a_test(desk: Desk) -> None:
    assert desk.result(ACTUATOR_TEST, 0.2, 3, 0, 0, 1) == ACCEPTED
    desk.tick(10)
    assert desk.result(ARM, 1) == ACCEPTED
    desk.tick()
    assert not desk.vessel.supervisor.motor_test.running
    assert desk.result(ACTUATOR_TEST, 0.2, 1, 0, 0, 1) == REJECTED
    desk.close()


def test_only_the_operator_in_control(desk: Desk, tmp_path: Path) -> None:
    other = Desk(tmp_path, desk.rig, system=254)  # the same boat
    assert desk.result(TAKE_CONTROL, 1, 1) == ACCEPTED
    assert other.result(ACTUATOR_TEST, 0.2, 1, 0, 0, 1) == DENIED
    assert "Not obeyed: system 255 has control" in other.texts()
    assert desk.result(ACTUATOR_TEST, 0.2, 1, 0, 0, 1) == ACCEPTED
    desk.close()


def test_a_motor_test_is_told_apart_from_an_armed_boat(desk: Desk) -> None:
    desk.result(ACTUATOR_TEST, 0.2, 3, 0, 0, 1)
    desk.tick(15)
    output = desk.latest("ACTUATOR_OUTPUT_STATUS")
    assert output.active and output.actuator[0] == pytest.approx(0.2, abs=0.01)
    assert not desk.latest("HEARTBEAT").base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    desk.close()


@pytest.mark.process
def test_mavproxy_runs_a_motor(tmp_path: Path) -> None:
    config = config_module.load(config_module.find("revolt"))
    port = free_port(socket.SOCK_STREAM)
    with (
        Afloat(tmp_path, config, [f"tcpin:127.0.0.1:{port}?dialect=ardupilot"], speed=5.0) as afloat,
        MavProxy(f"tcp:127.0.0.1:{port}", tmp_path / "mavproxy") as station,
    ):
        station.expect("online system 1")
        station.say("motortest 1 0 20 5 0")
        station.expect(r"Motor test: stern_port at \+20%")
        wait_until(lambda: afloat.world.thrusters[0].force_n > 0.1, "thrust")
        station.expect("Motor test over: stern_port")
        station.say("motortest 1 0 80 5 0")
        station.expect("Motor test refused: at most 30%")

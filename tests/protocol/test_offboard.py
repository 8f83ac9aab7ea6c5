"""MAVSDK's offboard plugin and MAVProxy's one-line setpoints against the running process."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from mavsdk import ComponentType, Configuration, Mavsdk, System
from mavsdk.plugins.action import Action
from mavsdk.plugins.offboard import Offboard, OffboardError, PositionNedYaw, VelocityBodyYawspeed, VelocityNedYaw
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import FlightMode, Telemetry

from sitl.scenarios.measure import read_estimates, read_truth
from tests.protocol.process import Companion
from tests.waiting import CAP_S, wait_until

pytestmark = pytest.mark.process

SPEED = 14.0
VESSELS = {"revolt": (0.4, 0.15), "aboat": (0.8, 0.5)}  # speed; how near to the point it should lie, by RTK and by SBAS


@contextmanager
def connected(companion: Companion) -> Iterator[System]:
    with Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION)) as sdk:
        sdk.add_any_connection(f"udpin://127.0.0.1:{companion.udp_port}")
        system = sdk.first_autopilot(CAP_S)
        assert system is not None
        yield system


class Client:
    """MAVSDK on one boat, as its examples do it: arm, send a setpoint, start."""

    def __init__(self, system: System, companion: Companion) -> None:
        self.companion = companion
        self.telemetry, self.action, self.offboard = Telemetry(system), Action(system), Offboard(system)
        self.param = Param(system)

    def begin(self, timeout_s: float) -> None:
        """`timeout_s`: silence, in the boat's time, after which it no longer obeys; so long that a machine that is
        busy for seconds makes none."""
        self.param.set_param_float("OFFB_TIMEOUT", timeout_s)
        wait_until(lambda: self.telemetry.health().is_armable, "armable")
        with pytest.raises(OffboardError):
            self.offboard.start()  # before a setpoint
        self.action.arm()
        self.offboard.set_velocity_body(VelocityBodyYawspeed(0.0, 0.0, 0.0, 0.0))
        self.offboard.start()
        wait_until(lambda: self.telemetry.flight_mode() is FlightMode.OFFBOARD, "Offboard")

    def destroy(self) -> None:
        for plugin in (self.param, self.offboard, self.telemetry, self.action):
            plugin.destroy()

    def rows(self, last_s: float) -> slice:
        """Of the log: the ticks of the last so many seconds."""
        end = len(read_truth(self.companion.log_folder)) - 1
        return slice(end - round(last_s * 10), end)


@pytest.mark.sweep
def test_the_examples_of_mavsdk_sail_two_boats(tmp_path: Path) -> None:
    """Position, velocity over ground, velocity along the hull with a yaw rate; both boats at once."""
    with ExitStack() as stack:
        clients: dict[str, Client] = {}
        for name in VESSELS:
            folder = tmp_path / name
            folder.mkdir()
            companion = stack.enter_context(Companion(folder, speed=SPEED, vessel=name))
            clients[name] = Client(stack.enter_context(connected(companion)), companion)
        for client in clients.values():
            client.begin(60.0)
        parts: dict[str, list[slice]] = {name: [] for name in clients}
        for part, duration_s in enumerate((70.0, 35.0, 35.0)):
            for name, client in clients.items():
                speed = VESSELS[name][0]
                if part == 0:
                    client.offboard.set_position_ned(PositionNedYaw(4.0, 3.0, 0.0, 30.0))
                elif part == 1:
                    client.offboard.set_velocity_ned(
                        VelocityNedYaw(speed * math.cos(1.0), speed * math.sin(1.0), 0.0, math.degrees(1.0))
                    )
                else:
                    client.offboard.set_velocity_body(VelocityBodyYawspeed(speed, 0.0, 0.0, 2.0))
            for client in clients.values():
                client.companion.sail(duration_s)
            for name, client in clients.items():
                parts[name].append(client.rows(8.0))
        for client in clients.values():
            assert client.telemetry.flight_mode() is FlightMode.OFFBOARD
            client.offboard.stop()
            wait_until(lambda client=client: client.telemetry.flight_mode() is FlightMode.HOLD, "Hold")  # type: ignore[misc]
            client.destroy()
    for name, client in clients.items():
        judge(client.companion.log_folder, parts[name], *VESSELS[name])


def judge(folder: Path, parts: list[slice], speed: float, near_m: float) -> None:
    at_point, known = parts[0], read_estimates(folder)
    assert max(math.hypot(row["north_m"] - 4.0, row["east_m"] - 3.0) for row in known[at_point]) < near_m
    assert max(
        abs(math.remainder(row["yaw_rad"] - math.radians(30.0), math.tau)) for row in known[at_point]
    ) < math.radians(4.0)
    truth = read_truth(folder)
    first, last = truth[parts[1]][0], truth[parts[1]][-1]
    took_s = last["t_s"] - first["t_s"]
    assert (last["north_m"] - first["north_m"]) / took_s == pytest.approx(speed * math.cos(1.0), abs=0.05)
    assert (last["east_m"] - first["east_m"]) / took_s == pytest.approx(speed * math.sin(1.0), abs=0.05)
    body = truth[parts[2]]
    assert sum(row["surge_mps"] for row in body) / len(body) == pytest.approx(speed, abs=0.04)
    assert math.degrees(sum(row["yaw_rate_radps"] for row in body) / len(body)) == pytest.approx(2.0, abs=0.3)


def test_a_client_that_is_cut_off_leaves_the_boat_in_hold(tmp_path: Path) -> None:
    """By the boat's clock, which here runs four times as fast as the client's. The usual time-out is tried in
    lockstep."""
    timeout_s = 12.0
    with Companion(tmp_path, speed=4.0) as companion, connected(companion) as system:
        client = Client(system, companion)
        client.begin(timeout_s)
        client.offboard.set_velocity_ned(VelocityNedYaw(0.3, 0.0, 0.0, 0.0))
        companion.sail(2.0)
        assert client.telemetry.flight_mode() is FlightMode.OFFBOARD
        client.destroy()

        def lost() -> list[dict[str, str]]:
            return [row for row in companion.rows("events.csv") if row["name"] == "offboard_lost"]

        (event,) = wait_until(lost, "the boat leaves Offboard")
        assert event["text"].startswith("Offboard: no setpoint for") and event["text"].endswith(": Hold")
        age_s = float(event["text"].removeprefix("Offboard: no setpoint for ").split()[0])
        assert timeout_s <= age_s <= timeout_s + 0.2
        wait_until(lambda: companion.rows()[-1]["mode"] == "Hold", "Hold")

"""The last gate."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.outputs import RelayConfig, ServoConfig
from companion.config.vessel import find, load
from companion.core.actuation import (
    NO_AUXILIARY,
    ActuatorCommand,
    Allocation,
    Auxiliary,
    Deployment,
    ThrusterCommand,
    ThrusterFeedback,
    Wrench,
)
from companion.safety import Gate as BareGate
from tests.unit.control.simple_boat import REVOLT

DT_S = 0.1
NONE = (False, False, False)
BOW = REVOLT.thrusters[2]


def bow(deployment: Deployment | None) -> tuple[ThrusterFeedback | None, ...]:
    return None, None, ThrusterFeedback(0.0, "board", 2, 0.0, None, True, deployment)


class Gate(BareGate):
    """The gate of a boat whose bow thruster is down."""

    def update(self, allocation: Allocation, armed: bool, now_s: float, dt_s: float, *_: object) -> ActuatorCommand:  # type: ignore[override]
        return super().update(allocation, armed, now_s, dt_s, True, bow(Deployment.LOWERED))


def allocation(*throttles: float, azimuth_rad: float = 0.2) -> Allocation:
    commands = tuple(
        ThrusterCommand(27.0 * u * abs(u), u, azimuth_rad if t.kind == "azimuth" else None)
        for t, u in zip(REVOLT.thrusters, throttles, strict=False)
    )
    return Allocation(commands, Wrench(0.0, 0.0, 0.0), NONE)


def run(gate: Gate, demand: Allocation, cycles: int, armed: bool = True) -> ActuatorCommand:
    for k in range(cycles):
        command = gate.update(demand, armed, DT_S * k, DT_S)
    return command


def test_a_valid_demand_passes_unchanged() -> None:
    gate = Gate(REVOLT)
    run(gate, allocation(0.5, -0.5, 0.3), 10)
    command = gate.update(allocation(0.5, -0.5, 0.3), True, 7.0, DT_S)
    assert command.t_s == 7.0 and command.armed and command.gated == ()
    assert [t.throttle for t in command.thrusters] == [0.5, -0.5, 0.3]
    assert [t.azimuth_rad for t in command.thrusters] == [0.2, 0.2, None]


def test_disarmed_every_throttle_is_zero_at_once() -> None:
    gate = Gate(REVOLT)
    run(gate, allocation(0.5, -0.5, 0.3), 10)
    command = gate.update(allocation(0.5, -0.5, 0.3), False, 1.0, DT_S)
    assert not command.armed
    assert all(t.throttle == 0.0 and t.force_n == 0.0 for t in command.thrusters)
    again = gate.update(allocation(0.9, 0.9, 0.9), True, 1.1, DT_S)
    assert all(t.throttle < 0.9 for t in again.thrusters), "from rest, at the rate allowed"


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_non_finite_demand_is_neutral_for_that_thruster_alone(bad: float) -> None:
    gate = Gate(REVOLT)
    run(gate, allocation(0.5, 0.5, 0.3), 10)
    command = gate.update(allocation(bad, 0.5, 0.3), True, 1.0, DT_S)
    assert [t.throttle for t in command.thrusters] == [0.0, 0.5, 0.3]
    assert command.gated == ("stern_port.finite",)
    command = gate.update(allocation(0.5, 0.5, 0.3, azimuth_rad=bad), True, 1.1, DT_S)
    assert command.thrusters[0].azimuth_rad == 0.2, "the last good azimuth"
    assert "stern_starboard.finite" in command.gated


def test_throttle_and_force_are_within_limits() -> None:
    command = run(Gate(REVOLT), allocation(7.0, -7.0, 7.0), 40)
    port, starboard, bow = command.thrusters
    assert (
        port.force_n == pytest.approx(25.0)
        and starboard.force_n == pytest.approx(-25.0)
        and bow.force_n == pytest.approx(14.0)
    )
    assert all(abs(t.throttle) <= 1.0 for t in command.thrusters)
    assert set(command.gated) == {"stern_port.throttle", "stern_starboard.throttle", "bow.throttle"}


def test_thrust_grows_slowly_and_falls_at_once() -> None:
    gate = Gate(REVOLT)
    first = gate.update(allocation(0.9, 0.0, 0.0), True, 0.0, DT_S)
    assert first.thrusters[0].force_n == pytest.approx(1.5 * 50.0 * DT_S + 0.02 * 25.0)
    assert first.gated == ("stern_port.slew",)
    run(gate, allocation(0.9, 0.0, 0.0), 10)
    back = gate.update(allocation(-0.9, 0.0, 0.0), True, 1.0, DT_S)
    assert back.thrusters[0].force_n == pytest.approx(-8.0), "through zero at once, then at the rate"
    assert gate.update(allocation(0.0, 0.0, 0.0), True, 1.1, DT_S).thrusters[0].throttle == 0.0


@pytest.mark.parametrize("dt_s", [0.0, -1.0, math.nan, math.inf])
def test_an_invalid_time_step_allows_only_the_slack(dt_s: float) -> None:
    command = Gate(REVOLT).update(allocation(0.9, 0.9, 0.9), True, 0.0, dt_s)
    assert all(abs(t.force_n) <= 0.5 + 1e-9 for t in command.thrusters)


@pytest.mark.parametrize("count", [0, 2])
def test_a_wrong_number_of_thrusters_is_neutral(count: int) -> None:
    gate = Gate(REVOLT)
    run(gate, allocation(0.5, 0.5, 0.3), 10)
    demand = replace(allocation(0.5, 0.5, 0.3), thrusters=allocation(0.5, 0.5, 0.3).thrusters[:count])
    command = gate.update(demand, True, 1.0, DT_S)
    assert len(command.thrusters) == 3 and all(t.throttle == 0.0 for t in command.thrusters)
    assert "count" in command.gated


def test_azimuths_stay_in_their_sector() -> None:
    stern = replace(REVOLT.thrusters[0], azimuth_min_rad=math.radians(-45.0), azimuth_max_rad=math.radians(45.0))
    boat = replace(REVOLT, thrusters=(stern, *REVOLT.thrusters[1:]))
    command = Gate(boat).update(allocation(0.1, 0.1, 0.0, azimuth_rad=2.0), True, 0.0, DT_S)
    assert command.thrusters[0].azimuth_rad == pytest.approx(math.radians(45.0))
    assert command.thrusters[1].azimuth_rad == 2.0
    assert command.gated == ("stern_port.azimuth",)


def test_a_thruster_without_astern() -> None:
    jet = replace(REVOLT.thrusters[0], min_n=0.0)
    boat = replace(REVOLT, thrusters=(jet, *REVOLT.thrusters[1:]))
    command = Gate(boat).update(allocation(-0.3, 0.0, 0.0), True, 0.0, DT_S)
    assert command.thrusters[0].throttle == 0.0


@pytest.mark.parametrize("deployment", [Deployment.RETRACTED, Deployment.MOVING])
@pytest.mark.parametrize("lower", [None, True, False])
def test_a_propeller_that_is_not_lowered_never_runs(deployment: Deployment, lower: bool | None) -> None:
    gate = BareGate(REVOLT)
    for k in range(200):
        command = gate.update(allocation(0.5, 0.5, 0.3), True, DT_S * k, DT_S, lower, bow(deployment))
        assert command.thrusters[2] == ThrusterCommand(0.0, 0.0, None) and "bow.retracted" in command.gated
        assert command.lower is lower
    assert command.thrusters[0].throttle == 0.5


def test_ordered_up_it_stops_at_once() -> None:
    gate = BareGate(REVOLT)
    for k in range(10):
        running = gate.update(allocation(0.1, 0.1, 0.3), True, DT_S * k, DT_S, None, bow(Deployment.LOWERED))
    assert running.thrusters[2].throttle == 0.3 and running.gated == ()
    command = gate.update(allocation(0.1, 0.1, 0.3), True, 1.0, DT_S, False, bow(Deployment.LOWERED))
    assert command.thrusters[2].throttle == 0.0


@pytest.mark.parametrize("feedback", [(), bow(None)])
def test_without_a_reported_position_the_travel_time_counts_in_the_gate(
    feedback: tuple[ThrusterFeedback | None, ...],
) -> None:
    gate, demand = BareGate(REVOLT), allocation(0.0, 0.0, 0.1)
    assert gate.update(demand, True, 100.0, DT_S, None, feedback).thrusters[2].throttle == 0.0
    for now_s, lower, runs in (
        (101.0, True, False),
        (101.0 + BOW.travel_s - 0.1, True, False),
        (101.0 + BOW.travel_s, True, True),
        (107.0, False, False),
        (108.0, True, False),
        (108.0 + BOW.travel_s, True, True),
    ):
        assert (gate.update(demand, True, now_s, DT_S, lower, feedback).thrusters[2].throttle != 0.0) == runs


def test_a_retracted_thruster_without_demand_is_not_gated() -> None:
    assert (
        BareGate(REVOLT).update(allocation(0.1, 0.1, 0.0), True, 0.0, DT_S, False, bow(Deployment.RETRACTED)).gated
        == ()
    )


def test_servos_and_relays_are_limited_and_rest_while_disarmed() -> None:
    servos = (
        ServoConfig("winch", 1000.0, 2000.0, 1500.0),
        ServoConfig("flap"),
        ServoConfig("sign", while_disarmed=True),
    )
    boat = replace(REVOLT, servos=servos, relays=(RelayConfig("pump"), RelayConfig("lamp", while_disarmed=True)))
    gate = BareGate(boat)

    def outputs(demand: Auxiliary, armed: bool) -> tuple[Auxiliary, tuple[str, ...]]:
        command = gate.update(allocation(0.0, 0.0, 0.0), armed, 0.0, DT_S, auxiliary=demand)
        return command.auxiliary, command.gated

    asked = Auxiliary((2400.0, math.nan, 1200.0), (True, True))
    assert outputs(asked, True) == (Auxiliary((2000.0, None, 1200.0), (True, True)), ("winch.pulse", "flap.pulse"))
    assert outputs(asked, False) == (Auxiliary((1500.0, None, 1200.0), (False, True)), ())
    for wrong in (NO_AUXILIARY, Auxiliary((1100.0,), (True,))):
        assert outputs(wrong, True)[0] == Auxiliary((1500.0, None, None), (False, False))


def test_the_gate_of_a_jet() -> None:
    """Nothing astern, the nozzle within its stops, and thrust no faster than it may come."""
    vessel = load(find("rescuerunner"))
    (jet,) = vessel.thrusters
    gate, stop_rad, none = BareGate(vessel), math.radians(24.0), Wrench(0.0, 0.0, 0.0)

    def passed(throttle: float, azimuth_rad: float, armed: bool = True) -> tuple[ThrusterCommand, tuple[str, ...]]:
        command = gate.update(Allocation((ThrusterCommand(0.0, throttle, azimuth_rad),), none, NONE), armed, 0.0, 0.05)
        return command.thrusters[0], command.gated

    command, gated = passed(-0.5, 0.6)
    assert command.throttle == 0.0 and command.azimuth_rad == stop_rad and set(gated) == {"jet.throttle", "jet.azimuth"}
    command, gated = passed(1.0, 0.0)
    bollard_n = 5.125 * (6.0 + 27.0 * command.throttle**1.32) ** 2
    assert gated == ("jet.slew",) and bollard_n == pytest.approx(1.5 * 5000.0 * 0.05 + 0.02 * 5582.0, rel=1e-6)
    for _ in range(40):
        command, gated = passed(1.0, 0.1)
    assert gated == () and command.throttle == pytest.approx(1.0, abs=1e-4) and command.force_n <= jet.max_n + 1.0
    assert passed(1.0, 0.1, armed=False)[0].throttle == 0.0
    command, gated = passed(0.05, 0.0)
    assert command.throttle == 0.05 and gated == (), "the impeller may begin at once"

"""The board's own rules, in virtual time: what `microcontroller_frame` promises of a board, held against the compiled
C."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest

from companion.config.vessel import find
from companion.config.vessel import load as load_vessel
from companion.core.actuation import Deployment, Light
from companion.core.microcontroller_auxiliary import AuxiliaryDemand
from companion.core.microcontroller_frame import BoardCommand, BoardStatus, Ident, IdentRequest, ThrusterDemand, encode
from sitl.thrusters import ThrusterModel
from tests.unit.io.actuators.firmware.host import NO_VOLTAGE, Board, DriveConfig, throttle_us

FIXED, WITH_STOPS, ENDLESS = range(3)
CUT, STICKS = 1, 2
PLAIN = {"trim_us": 1500, "ahead_us": 1900, "astern_us": 1100}
CENTRED = (1500, 1500, 1500, 1500, 1000, 1000, 1000, 1000)


def drive(**values: int | bool) -> DriveConfig:
    return DriveConfig(**{**PLAIN, **values})


def ahead(
    throttle: float = 0.5, armed: bool = True, n: int = 1, azimuth_rad: float | None = None, **more: object
) -> BoardCommand:
    return replace(BoardCommand(1, armed, (ThrusterDemand(throttle, azimuth_rad),) * n), **more)  # type: ignore[arg-type]


# --- calibration ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("values", "pulses"),
    [
        ({}, {-10000: 1100, -5000: 1300, 0: 1500, 1: 1500, 5000: 1700, 10000: 1900}),
        ({"trim_us": 1520}, {-10000: 1100, -5000: 1310, 0: 1520, 5000: 1710, 10000: 1900}),
        ({"dead_us": 40}, {-10000: 1100, -5000: 1280, -1: 1460, 0: 1500, 1: 1540, 5000: 1720, 10000: 1900}),
        ({"reversed": True}, {-10000: 1900, 0: 1500, 2500: 1400, 10000: 1100}),
        ({"reversed": True, "dead_us": 40}, {-10000: 1900, 1: 1460, 10000: 1100}),
        (
            {"trim_us": 1000, "astern_us": 1000, "ahead_us": 2000},
            {-10000: 1000, -1: 1000, 0: 1000, 5000: 1500, 10000: 2000},
        ),
    ],
)
def test_a_throttle_becomes_a_pulse_by_the_calibration(values: dict[str, int], pulses: dict[int, int]) -> None:
    config = drive(**values)
    assert {throttle: throttle_us(config, throttle) for throttle in pulses} == pulses


def test_no_throttle_leaves_the_end_points() -> None:
    config = drive(dead_us=25)
    assert {throttle_us(config, throttle) for throttle in (-32768, -20000, 20000, 32767)} == {1100, 1900}


# --- watchdog ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("start_ms", [0, 2**32 - 300])  # the clock wraps every 50 days
def test_neutral_within_half_a_second_of_silence_and_not_before(start_ms: int) -> None:
    board = Board([drive()], now_ms=start_ms)
    assert board.pulses == [1500]
    board.hear(ahead())
    board.run(499, 1)
    assert board.pulses == [1700]
    board.step(1)
    assert board.pulses == [1500] and board.status().neutral_by_watchdog
    board.hear(ahead())
    board.step(1)
    assert board.pulses == [1700] and not board.status().neutral_by_watchdog


def test_a_clock_that_wraps_makes_no_old_command_young() -> None:
    board = Board([drive()])
    board.hear(ahead())
    board.run(600, 1)
    board.step(2**32 - 500)  # 50 days later the clock shows a time close after that of the command
    assert board.pulses == [1500]


def test_disarmed_is_neutral_at_once_whatever_the_throttle() -> None:
    board = Board([drive(rate_per_s=1000)])
    for _ in range(100):
        board.hear(ahead(1.0))
        board.step(100)
    assert board.pulses == [1900]
    board.hear(ahead(1.0, armed=False))
    board.step(1)
    assert board.pulses == [1500] and not board.status().neutral_by_watchdog


def test_a_command_for_another_number_of_thrusters_is_none() -> None:
    board = Board([drive()])
    board.hear(ahead(n=2))
    board.step()
    assert board.pulses == [1500] and board.status().neutral_by_watchdog


def test_garbage_neither_moves_an_output_nor_keeps_the_watchdog_quiet() -> None:
    rng = random.Random(4)
    board = Board([drive(), drive()])
    for _ in range(300):
        board.hear(rng.randbytes(rng.randrange(60)), b"\0")
        board.step(1)
        assert board.pulses == [1500, 1500]
    board.hear(ahead(n=2))
    board.step(1)
    for _ in range(500):
        board.hear(rng.randbytes(30), b"\0")
        board.step(1)
    assert board.pulses == [1500, 1500]


def test_throttle_rises_at_its_rate_and_falls_at_once() -> None:
    board = Board([drive(rate_per_s=10000)])
    board.hear(ahead(1.0))
    board.run(250, 1)
    assert board.pulses == [1600]
    board.hear(ahead(-1.0))
    board.step(10)
    assert board.pulses == [1496]
    board.hear(ahead(0.0))
    board.step(1)
    assert board.pulses == [1500]


# --- azimuth -------------------------------------------------------------------------------------------------------


def test_azimuth_drives_go_where_the_plants_go() -> None:
    """The plant's thruster is a second writing of the same rule, in floats: endless, and with stops at ±270°."""
    aboat, rng = load_vessel(find("aboat")), random.Random(8)
    for limit in (None, 1.5 * math.pi):
        config = replace(
            aboat.thrusters[0],
            azimuth_rate_radps=1.0,
            azimuth_min_rad=None if limit is None else -limit,
            azimuth_max_rad=limit,
        )
        plant = ThrusterModel(config, 0.0)
        ends = (0, 0) if limit is None else (-47124, 47124)
        board = Board(
            [
                drive(
                    azimuth=ENDLESS if limit is None else WITH_STOPS,
                    azimuth_min=ends[0],
                    azimuth_max=ends[1],
                    azimuth_rate=10000,
                )
            ]
        )
        for _ in range(40):
            azimuth_rad = rng.uniform(-math.pi, math.pi)
            for _ in range(rng.randrange(80)):
                board.hear(ahead(0.1, azimuth_rad=azimuth_rad))
                board.step(100)
                plant.demand(0.1, azimuth_rad)
                plant.step(0.1)
                gap_rad = board.outputs.thruster[0].azimuth / 1e4 - plant.azimuth_rad
                assert abs(math.remainder(gap_rad, math.tau) if limit is None else gap_rad) < 0.003
                said_rad = next(
                    message.thrusters[0].azimuth_rad for message in board.said() if isinstance(message, BoardStatus)
                )
                assert said_rad is not None and abs(math.remainder(said_rad - plant.azimuth_rad, math.tau)) < 0.003


def test_a_servo_is_given_the_pulse_between_its_stops() -> None:
    config = drive(
        azimuth=WITH_STOPS,
        azimuth_min=-31416,
        azimuth_max=31416,
        azimuth_min_us=2100,
        azimuth_max_us=900,
        azimuth_rate=60000,
    )
    board = Board([config])
    for azimuth_rad, pulse_us in ((0.0, 1500), (math.pi / 2, 1200), (-math.pi / 2, 1800), (-3.14, 2100)):
        for _ in range(20):
            board.hear(ahead(0.0, azimuth_rad=azimuth_rad))
            board.step(100)
        assert abs(board.outputs.thruster[0].azimuth_us - pulse_us) <= 1


def test_silence_leaves_the_azimuth_where_it_is() -> None:
    board = Board([drive(azimuth=ENDLESS, azimuth_rate=10000)])
    board.hear(ahead(0.5, azimuth_rad=1.5))
    board.run(3000)
    assert board.outputs.thruster[0].azimuth == pytest.approx(5000, abs=60)


# --- retraction ----------------------------------------------------------------------------------------------------


def test_a_thruster_with_end_switches_runs_only_when_it_is_down() -> None:
    board = Board([drive(travel_ms=1000, end_switches=True)])
    board.inputs.thruster[0].switch_up = True
    seen, travels = [], []
    for lower, down_ms in ((None, 0), (True, 700), (False, 0)):
        for ms in range(0, 1500, 100):
            board.inputs.thruster[0].switch_up = (
                lower is None or (lower is True and ms < 100) or (lower is False and ms >= 700)
            )
            board.inputs.thruster[0].switch_down = lower is True and ms >= down_ms
            board.hear(ahead(0.5, lower=lower))
            board.step(100)
            (state,) = board.status().thrusters
            travels.append(board.outputs.thruster[0].travel)
            if not seen or seen[-1][0] is not state.deployment:
                seen.append((state.deployment, board.pulses[0]))
    assert seen == [
        (Deployment.RETRACTED, 1500),
        (Deployment.MOVING, 1500),
        (Deployment.LOWERED, 1700),
        (Deployment.MOVING, 1500),
        (Deployment.RETRACTED, 1500),
    ]
    assert set(travels[:15]) == {0} and 1 in travels[15:30] and -1 in travels[30:] and travels[29] == travels[-1] == 0


def test_without_switches_the_place_is_known_after_a_whole_travel() -> None:
    board = Board([drive(travel_ms=1000)])
    board.hear(ahead(0.5))
    board.step(10)
    assert board.pulses == [1500] and board.status().thrusters[0].deployment is None
    board.hear(ahead(0.5, lower=True))
    board.run(900)
    assert board.status().thrusters[0].deployment is Deployment.MOVING
    board.run(100)  # the travel ends though commands have stopped
    assert board.status().thrusters[0].deployment is Deployment.LOWERED and board.outputs.thruster[0].travel == 0
    board.hear(ahead(0.5))
    board.step(1)
    assert board.pulses == [1700]
    board.hear(ahead(0.5, lower=False))
    board.step(1)
    assert board.pulses == [1500] and board.outputs.thruster[0].travel == -1
    board.hear(ahead(0.5, lower=False))
    board.run(400)
    board.hear(ahead(0.5, armed=False, lower=True))
    board.run(395)
    assert board.status().thrusters[0].deployment is Deployment.LOWERED  # half the way is half the time


def test_a_jammed_travel_ends() -> None:
    board = Board([drive(travel_ms=1000, end_switches=True)])
    for _ in range(300):
        board.hear(ahead(lower=True))
        board.step(10)
    assert board.outputs.thruster[0].travel == 0 and board.status().thrusters[0].deployment is Deployment.MOVING
    board.hear(ahead(lower=False))
    board.step(10)
    assert board.outputs.thruster[0].travel == -1


# --- lamps, inputs, who it is --------------------------------------------------------------------------------------


def test_lamps_blink_at_one_hertz_and_green_is_steady_in_silence() -> None:
    board = Board([drive()])
    board.run(450)
    assert not board.outputs.green
    board.run(100)
    assert board.outputs.green  # nobody has commanded it yet
    command = ahead(armed=False, red=Light.STEADY, yellow=Light.BLINK, green=Light.BLINK)
    seen = []
    for _ in range(40):
        board.hear(command)
        board.step(100)
        seen.append((board.outputs.red, board.outputs.yellow, board.outputs.green))
    assert {red for red, _, _ in seen} == {True}
    assert sum(yellow for _, yellow, _ in seen) == 20 and all(yellow == green for _, yellow, green in seen)
    board.run(600)
    lamps = []
    for _ in range(20):
        board.step(100)
        lamps.append((board.outputs.red, board.outputs.yellow, board.outputs.green))
    assert {(red, green) for red, _, green in lamps} == {(True, True)} and len({yellow for _, yellow, _ in lamps}) == 2


def test_what_it_measures_is_said_and_what_it_does_not_is_unknown() -> None:
    board = Board([drive()])
    nothing = board.status()
    assert (nothing.voltage_v, nothing.current_a, nothing.remaining, nothing.rc_present, nothing.leak_wet) == (
        None,
        None,
        None,
        False,
        False,
    )
    inputs = board.inputs
    inputs.leak_wet, inputs.battery_mv, inputs.current_ma, inputs.remaining = True, 12345, -1500, 127
    inputs.thruster[0].works, inputs.thruster[0].throttle_measured, inputs.thruster[0].throttle = False, True, -2500
    status = board.status()
    assert (status.leak_wet, status.voltage_v, status.current_a, status.remaining) == (True, 12.345, -1.5, 127 / 254)
    assert not status.thrusters[0].ok and status.thrusters[0].throttle == -0.25
    inputs.battery_mv = NO_VOLTAGE
    assert board.status().voltage_v is None


def test_it_says_who_it_is_at_power_up_and_when_asked() -> None:
    board = Board([drive(), drive()], name=b"a name that is longer than the frame has room for")
    assert board.ident() == Ident((1, 1, 0), 2, "a name that is longer than the f")
    board.step()
    assert board.said() == []
    board.hear(IdentRequest())
    assert board.ident().thrusters == 2


def test_status_comes_twenty_times_a_second_in_a_loop_of_any_length() -> None:
    for step_ms in (1, 7, 33):
        board = Board([drive()])
        board.ident()
        count = 0
        for _ in range(10000 // step_ms):
            board.step(step_ms)
            count += len(board.said())
        assert count == pytest.approx(200, abs=2)


def test_servos_and_relays_obey_and_rest_in_silence() -> None:
    board = Board([drive()], relays=2, servos=1)
    assert board.auxiliary() == []
    board.hear(AuxiliaryDemand(4, (1900.0,), (True, False)))
    (state,) = board.auxiliary()
    assert (state.sequence, state.servos_us, state.relays) == (4, (1900.0,), (True, False))
    board.hear(AuxiliaryDemand(5, (), (True, False)))  # for another board
    board.run(500)
    (state,) = board.auxiliary()
    assert (state.servos_us, state.relays, board.outputs.auxiliary.relays) == ((None,), (False, False), 0)


# --- the transmitter -----------------------------------------------------------------------------------------------


def test_a_transmitter_is_passed_on_and_its_loss_is_said() -> None:
    board = Board([drive()])
    board.step(10, CENTRED)
    status = board.status()
    assert status.rc_present and not status.rc_lost and status.rc_us == CENTRED and not status.safe_mode
    board.run(500)
    status = board.status()
    assert status.rc_present and status.rc_lost and status.rc_us == (0,) * 8
    board.step(10, CENTRED)
    assert not board.status().rc_lost
    board.step(10, (1500, 1500, 700, 1500, 1000, 1000, 1000, 1000))  # a receiver's own failsafe
    assert board.status().rc_lost


def test_the_safe_mode_switch_cuts_thrust_without_the_companion() -> None:
    board = Board([drive()], safe_action=CUT, safe_channel=5)
    board.hear(ahead())
    board.step(10, CENTRED)
    assert board.pulses == [1700]
    thrown = (*CENTRED[:4], 2000, 1000, 1000, 1000)
    board.step(10, thrown)
    assert board.pulses == [1500] and board.status().safe_mode
    board.run(3000)  # the transmitter falls silent: the switch stays where it was last seen
    board.hear(ahead())
    board.step(10)
    assert board.pulses == [1500]
    board.step(10, CENTRED)
    assert board.pulses == [1700] and not board.status().safe_mode


def test_in_safe_mode_the_sticks_have_the_thrusters_once_they_were_centred() -> None:
    thrusters = [
        drive(
            mix_surge=100,
            mix_yaw=50,
            azimuth=WITH_STOPS,
            azimuth_min=-7854,
            azimuth_max=7854,
            mix_azimuth=7854,
            azimuth_rate=60000,
        )
    ] * 2
    board = Board(thrusters, safe_action=STICKS, safe_channel=5, surge_channel=3, yaw_channel=4)
    forward = (1500, 1500, 1750, 1500, 2000, 1000, 1000, 1000)
    board.run(200, 5, forward)
    assert board.pulses == [1500, 1500]
    board.step(5, (*CENTRED[:4], 2000, 1000, 1000, 1000))
    board.run(200, 5, forward)
    assert board.pulses == [1700, 1700]
    board.run(500, 5, (1500, 1500, 1500, 2000, 2000, 1000, 1000, 1000))
    assert board.pulses == [1700, 1700] and board.outputs.thruster[0].azimuth == 7854
    board.run(600)  # the transmitter falls silent
    assert board.pulses == [1500, 1500]


def test_a_lost_transmitter_never_throws_the_switch() -> None:
    board = Board([drive()], safe_action=STICKS, safe_channel=5, surge_channel=3)
    board.hear(ahead())
    board.step(10, (1500, 1500, 2000, 1500, 2300, 1000, 1000, 1000))
    assert board.pulses == [1700] and board.status().rc_lost and not board.status().safe_mode


def test_a_long_flood_between_two_frames_costs_neither() -> None:
    board = Board([drive()])
    board.hear(b"\x55" * 3000, encode(ahead()))
    board.step()
    assert board.pulses == [1700]

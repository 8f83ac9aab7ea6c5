from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from companion.core.decision import Home, ModeId, Outcome, Result
from companion.io.mavlink.telemetry.streams import STREAMS
from companion.io.mavlink.wire import messages as mavlink
from companion.mission.tasks import SetActuators, SetRelay, SetServo
from tests.unit.io.mavlink.hub.conftest import Rig
from tests.unit.io.mavlink.slow_storage import SlowStorage

NAN = math.nan
ACCEPTED, REJECTED, DENIED, UNSUPPORTED, FAILED, IN_PROGRESS = range(6)
KNOWN = (400, 176, 262, 20, 21, 22, 300, 192, 193, 178, 179, 224, 245, 246, 401, 185, 512, 520, 410, 511, 510)


def ack(messages: list[Any]) -> Any:
    acks = [message for message in messages if message.get_type() == "COMMAND_ACK"]
    assert len(acks) == 1
    return acks[0]


def ack_or_none(messages: list[Any]) -> Any:
    return next((message for message in messages if message.get_type() == "COMMAND_ACK"), None)


def result(messages: list[Any]) -> int:
    return int(ack(messages).result)


# --- the protocol --------------------------------------------------------------------------------------------------


def test_one_acknowledgement_addressed_to_the_sender(make_rig: type[Rig]) -> None:
    rig = make_rig(["memory:a", "memory:b"])
    for desk in (0, 1):
        answer = ack(rig.command(400, 1.0, desk=desk))
        assert (answer.command, answer.result) == (400, ACCEPTED)
        assert (answer.target_system, answer.target_component) == (255 - desk, 190)


@pytest.mark.parametrize("number", [0, 16, 36, 80, 242, 259, 280, 311, 519, 521, 2510, 5001, 31009, 42006, 65535])
def test_unknown_commands_are_unsupported_at_once(rig: Rig, number: int) -> None:
    assert result(rig.command(number)) == UNSUPPORTED
    assert result(rig.command_int(number, (0, 0, 0, 0), 0, 0)) == UNSUPPORTED


def test_who_speaks_to_everybody_is_not_told_that_it_is_unknown(rig: Rig) -> None:
    assert rig.command(999, target=(0, 0)) == []
    assert result(rig.command(400, 1.0, target=(0, 0))) == ACCEPTED
    assert result(rig.command(410, target=(1, 0))) == ACCEPTED  # as MAVProxy asks for home


@pytest.mark.parametrize("target", [(2, 1), (1, 2), (0, 190), (255, 190)])
def test_commands_for_others_are_left_alone(rig: Rig, target: tuple[int, int]) -> None:
    assert rig.command(400, 1.0, target=target) == []
    assert rig.supervisor.asked == []


@pytest.mark.parametrize("number", KNOWN)
@pytest.mark.parametrize("value", [NAN, math.inf, -math.inf, 1e30, -1.0, 0.5, 16777216.0])
def test_no_number_in_any_place_raises(rig: Rig, number: int, value: float) -> None:
    rig.tick()
    for places in [(i,) for i in range(7)] + [tuple(range(7))]:
        for base in (0.0, 1.0):
            params = [value if i in places else base for i in range(7)]
            assert result(rig.command(number, *params)) in range(5)
            assert result(rig.command_int(number, params[:4], 0x7FFFFFFF, -0x80000000, params[6])) in range(5)
    failed = {"mavlink_handler_failed", "mavlink_service_failed", "telemetry_failed"}
    assert not failed & {event.name for event in rig.vessel.events.drain()}


@pytest.mark.parametrize("outcome", list(Result))
def test_the_outcome_is_the_result(rig: Rig, named: Callable[[Sequence[Any], str], list[Any]], outcome: Result) -> None:
    """The supervisor says its reasons itself, as events for everybody."""
    rig.supervisor.outcome = Outcome(outcome, "because")
    heard = rig.command(20)
    assert result(heard) == outcome.value
    assert named(heard, "STATUSTEXT") == []


def test_a_malformed_command_is_told_why(rig: Rig, named: Callable[[Sequence[Any], str], list[Any]]) -> None:
    heard = rig.command(193, 7.0)
    assert [message.get_type() for message in heard] == ["COMMAND_ACK", "STATUSTEXT"]
    assert heard[1].text == "param 1 of pause should be 0 or 1"


def test_a_repetition_is_acknowledged_but_not_done_again(rig: Rig) -> None:
    rig.now_s = 5.0
    for number, params in ((246, (1.0,)), (300, (2.0, 4.0)), (179, (1.0,)), (224, (1.0, 1.0)), (245, (2.0,))):
        rig.supervisor.asked.clear()
        restarts = rig.vessel.restarts
        for _ in range(4):
            rig.now_s += 0.4
            assert result(rig.command(number, *params)) == ACCEPTED
        assert len(rig.supervisor.asked) + rig.vessel.restarts - restarts == (0 if number == 245 else 1), number


def test_what_is_meant_anew_is_done_anew(rig: Rig, make_rig: type[Rig]) -> None:
    start = (300, 2.0, 4.0)

    def starts(of: Any) -> int:
        return sum(asked[0] == "start_mission" for asked in of.supervisor.asked)

    rig.command(*start)
    rig.now_s += 2.5
    rig.command(*start)
    assert starts(rig) == 2  # later
    rig.command(300, 3.0, 4.0)
    assert starts(rig) == 3  # otherwise
    rig.command(193, 0.0)
    rig.command(300, 3.0, 4.0)
    assert starts(rig) == 4  # after something else
    rig.ask(mavlink.MAVLink_set_mode_message(1, 1, 0x00010000))
    rig.command(300, 3.0, 4.0)
    assert starts(rig) == 5  # the mode has changed since
    rig.supervisor.outcome = Outcome(Result.DENIED)
    rig.command(300, 1.0, 4.0)
    rig.command(300, 1.0, 4.0)
    assert starts(rig) == 7  # refused before
    both = make_rig(["memory:a", "memory:b"])
    both.command(*start)
    both.command(*start, desk=1)
    assert starts(both) == 2  # by another


# --- arming and modes ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("params", "asked"),
    [
        ((1.0,), ("arm", False)),
        ((1.0, 2989.0), ("arm", True)),
        ((1.0, 21196.0), ("arm", True)),
        ((0.0,), ("disarm", False)),
        ((0.0, 21196.0), ("disarm", True)),
        ((1.0, NAN), ("arm", False)),
    ],
)
def test_arming(rig: Rig, params: tuple[float, ...], asked: tuple[Any, ...]) -> None:
    assert result(rig.command(400, *params)) == ACCEPTED
    assert rig.supervisor.asked == [asked]


@pytest.mark.parametrize("value", [2.0, -1.0, 0.5, NAN, math.inf])
def test_arming_neither_way_is_denied(rig: Rig, value: float) -> None:
    assert result(rig.command(400, value)) == DENIED
    assert rig.supervisor.asked == []


@pytest.mark.parametrize(
    ("params", "mode"),
    [
        ((1.0, 4.0, 4.0), ModeId.MISSION),
        ((1.0, 4.0, 3.0), ModeId.HOLD),
        ((129.0, 1.0, 0.0), ModeId.MANUAL),
        ((1.0, 1.0, NAN), ModeId.MANUAL),
        ((1.0, float(0x06040000)), ModeId.DOCK),
    ],
)
def test_modes_by_main_and_sub_or_by_number(rig: Rig, params: tuple[float, ...], mode: ModeId) -> None:
    assert result(rig.command(176, *params)) == ACCEPTED
    assert rig.supervisor.asked == [("request_mode", mode)]


@pytest.mark.parametrize(
    "params",
    [
        (1.0, 4.0, 99.0),
        (0.0, 4.0, 4.0),
        (192.0, 0.0),
        (1.0, NAN),
        (1.0, -1.0),
        (1.0, 1e12),
        (1.0, 4.0, -1.0),
        (NAN, 4.0, 4.0),
    ],
)
def test_modes_that_are_none(rig: Rig, params: tuple[float, ...]) -> None:
    assert result(rig.command(176, *params)) == DENIED
    assert rig.supervisor.asked == []


def test_modes_of_the_ardupilot_persona(make_rig: type[Rig]) -> None:
    rig = make_rig(["memory:?dialect=ardupilot"])
    assert result(rig.command(176, 1.0, 10.0)) == ACCEPTED
    assert result(rig.command(176, 1.0, 5.0)) == ACCEPTED
    assert result(rig.command(176, 1.0, 4.0, 4.0)) == DENIED
    assert result(rig.command(176, 1.0, 999.0)) == DENIED
    assert [asked[1] for asked in rig.supervisor.asked] == [ModeId.MISSION, ModeId.HOLD]


def test_standard_modes(rig: Rig) -> None:
    assert [result(rig.command(262, float(n))) for n in (1, 5, 6, 7, 0)] == [
        ACCEPTED,
        ACCEPTED,
        ACCEPTED,
        FAILED,
        FAILED,
    ]
    assert [asked[1] for asked in rig.supervisor.asked] == [ModeId.HOLD, ModeId.RTL, ModeId.MISSION]


@pytest.mark.parametrize("base_mode", [1, 1 | 128, 9, 137])
@pytest.mark.parametrize("armed", [False, True])
def test_set_mode_never_touches_arming(rig: Rig, base_mode: int, armed: bool) -> None:
    rig.supervisor.change(armed=armed)
    rig.serve()
    heard = rig.ask(mavlink.MAVLink_set_mode_message(1, base_mode, 0x04040000))
    assert [message.get_type() for message in heard] == ["HEARTBEAT", "EXTENDED_SYS_STATE", "CURRENT_MODE"]
    assert rig.supervisor.asked == [("request_mode", ModeId.MISSION)]
    assert rig.supervisor.now.armed == armed


def test_set_mode_that_is_none_says_why(rig: Rig, named: Callable[[Sequence[Any], str], list[Any]]) -> None:
    (text,) = named(rig.ask(mavlink.MAVLink_set_mode_message(1, 1, 0x7F040000)), "STATUSTEXT")
    assert text.text.startswith("no mode number")
    assert len(named(rig.ask(mavlink.MAVLink_set_mode_message(1, 128, 0)), "STATUSTEXT")) == 1
    assert rig.supervisor.asked == []


def test_a_mode_that_cannot_be_selected_is_refused(rig: Rig) -> None:
    mode_type = type(rig.supervisor.modes[0])
    rig.supervisor.modes = tuple(mode_type(mode, selectable=mode is not ModeId.OFFBOARD) for mode in ModeId)
    assert result(rig.command(176, 1.0, 6.0)) == DENIED


def test_return_and_termination(rig: Rig) -> None:
    assert result(rig.command(20)) == ACCEPTED
    assert result(rig.command(185, 0.0)) == ACCEPTED
    assert result(rig.command(185, NAN)) == DENIED
    assert rig.supervisor.asked == [("request_mode", ModeId.RTL)]
    assert result(rig.command(185, 1.0)) == ACCEPTED
    assert rig.supervisor.asked[-1] == ("terminate",)


# --- go-to, mission, speed -----------------------------------------------------------------------------------------


def test_the_pause_pair_of_qgroundcontrol_holds_twice(rig: Rig) -> None:
    assert result(rig.command(192, -1.0, 1.0, 0.0, NAN, NAN, NAN, NAN)) == ACCEPTED
    assert result(rig.command(192, -1.0, 1.0, 0.0, NAN, NAN, NAN, 2.0)) == ACCEPTED
    assert rig.supervisor.asked == [("hold_here",), ("hold_here",)]


def test_go_to_in_both_wrappers_means_the_same_place(rig: Rig) -> None:
    assert result(rig.command(192, -1.0, 1.0, 0.0, NAN, 63.441, 10.405, 1.0)) == ACCEPTED
    assert result(rig.command_int(192, (-1.0, 1.0, 0.0, NAN), 634410000, 104050000, 1.0)) == ACCEPTED
    (_, *long_form), (_, *int_form) = rig.supervisor.asked
    assert int_form == [pytest.approx(63.441, abs=1e-9), pytest.approx(10.405, abs=1e-9), None, None]
    assert long_form == [pytest.approx(63.441, abs=1e-5), pytest.approx(10.405, abs=1e-5), None, None]


@pytest.mark.parametrize("the_frame", [0, 3, 5, 6, 10, 11])
def test_every_global_frame_is_the_same_to_a_boat(rig: Rig, the_frame: int) -> None:
    assert result(rig.command_int(192, (1.5, 1.0, 0.0, 0.5), 634410000, 104050000, the_frame=the_frame)) == ACCEPTED
    assert rig.supervisor.asked[0][3:] == (0.5, 1.5)


@pytest.mark.parametrize("the_frame", [1, 2, 7, 8, 200])
def test_other_frames_are_denied(rig: Rig, the_frame: int) -> None:
    assert result(rig.command_int(192, (-1.0, 1.0, 0.0, NAN), 634410000, 104050000, the_frame=the_frame)) == DENIED
    assert rig.supervisor.asked == []


def test_go_to_nowhere(rig: Rig) -> None:
    for lat, lon in ((NAN, 10.0), (63.0, NAN), (91.0, 10.0), (63.0, 181.0), (0.0, 0.0), (math.inf, 0.0)):
        assert result(rig.command(192, -1.0, 1.0, 0.0, NAN, lat, lon, 0.0)) == DENIED
    assert result(rig.command_int(192, (-1.0, 1.0, 0.0, NAN), 0x7FFFFFFF, 0x7FFFFFFF)) == ACCEPTED
    assert rig.supervisor.asked == [("hold_here",)]


def test_go_to_without_leave_to_change_the_mode(rig: Rig) -> None:
    assert result(rig.command(192, -1.0, 0.0, 0.0, NAN, 63.0, 10.0)) == ACCEPTED  # in Hold already
    rig.supervisor.change(mode=ModeId.MISSION)
    assert result(rig.command(192, -1.0, 0.0, 0.0, NAN, 63.0, 10.0)) == REJECTED


def test_a_yaw_of_zero_is_north_in_px4_and_nothing_in_ardupilot(make_rig: type[Rig]) -> None:
    rig = make_rig(["memory:", "memory:?dialect=ardupilot"])
    for desk in (0, 1):
        rig.command(192, -1.0, 1.0, 0.0, 0.0, 63.0, 10.0, desk=desk)
    assert [asked[3] for asked in rig.supervisor.asked] == [0.0, None]


def test_pause_and_continue(rig: Rig) -> None:
    assert [result(rig.command(193, value)) for value in (0.0, 1.0, 2.0, NAN)] == [ACCEPTED, ACCEPTED, DENIED, DENIED]
    assert rig.supervisor.asked == [("pause",), ("resume",)]


@pytest.mark.parametrize(
    ("params", "first"), [((0.0, 0.0), None), ((NAN, NAN), None), ((2.0, 5.0), 2), ((0.0, 5.0), 0), ((2.0, 0.0), 2)]
)
def test_mission_start(rig: Rig, params: tuple[float, ...], first: int | None) -> None:
    assert result(rig.command(300, *params)) == ACCEPTED
    assert rig.supervisor.asked == [("start_mission", first)]


def test_item_numbers_of_the_ardupilot_persona_count_home(make_rig: type[Rig]) -> None:
    rig = make_rig(["memory:?dialect=ardupilot"])
    rig.command(300, 2.0, 5.0)
    rig.command(224, 3.0)
    rig.command(224, 0.0)
    assert rig.supervisor.asked == [("start_mission", 1), ("set_current", 2, False), ("set_current", 0, False)]


def test_set_current(rig: Rig, named: Callable[[Sequence[Any], str], list[Any]]) -> None:
    rig.tick()
    heard = rig.command(224, 2.0, 1.0)
    assert result(heard) == ACCEPTED
    assert len(named(heard, "MISSION_CURRENT")) == 1
    assert result(rig.command(224, -1.0)) == ACCEPTED
    assert [result(rig.command(224, *params)) for params in ((NAN,), (-2.0,), (1.5,), (1.0, 2.0))] == [DENIED] * 4
    assert rig.supervisor.asked == [("set_current", 2, True), ("set_current", None, False)]


def test_change_speed(rig: Rig) -> None:
    answers = [result(rig.command(178, *params)) for params in ((1.0, 1.5, -1.0), (0.0, 0.8), (1.0, -1.0), (1.0, -2.0))]
    assert answers == [ACCEPTED] * 4
    assert rig.supervisor.asked == [
        ("change_speed", pytest.approx(1.5)),
        ("change_speed", pytest.approx(0.8)),
        ("change_speed", None),
    ]
    bad = [(2.0, 1.0), (3.0, 1.0), (NAN, 1.0), (1.0, NAN), (1.0, math.inf), (1.0, 0.0), (1.0, -3.0)]
    assert [result(rig.command(178, *params)) for params in bad] == [DENIED] * len(bad)


# --- home, storage, restart ----------------------------------------------------------------------------------------


def test_set_home(rig: Rig, named: Callable[[Sequence[Any], str], list[Any]]) -> None:
    rig.tick()
    heard = rig.command(179, 1.0)
    assert result(heard) == ACCEPTED
    assert len(named(heard, "HOME_POSITION")) == 1
    rig.command_int(179, (0.0, 0.0, 0.0, NAN), 634500000, 105000000, 7.0)
    rig.command_int(179, (0.0, 0.0, 0.0, 90.0), 634500000, 105000000, NAN)
    homes = [asked[1] for asked in rig.supervisor.asked]
    assert homes[0] is None
    assert homes[1] == Home(pytest.approx(63.45), pytest.approx(10.5), 7.0, None)
    assert (homes[2].altitude_m, homes[2].yaw_rad) == (1.0, pytest.approx(math.pi / 2))
    for params in ((0.0,), (2.0,), (NAN,), (0.0, 0.0, 0.0, NAN, NAN, 10.0)):
        assert result(rig.command(179, *params)) == DENIED


def test_storage(rig: Rig) -> None:
    rig.vessel.parameters.set("WP_SPEED", 1.25)
    assert [result(rig.command(245, value)) for value in (0.0, 1.0, -1.0, NAN, 3.0, 4.0)] == [ACCEPTED] * 4 + [
        DENIED
    ] * 2
    assert rig.vessel.parameters["WP_SPEED"] == 1.25
    rig.supervisor.change(armed=True)
    assert result(rig.command(245, 2.0)) == REJECTED
    rig.supervisor.change(armed=False)
    assert result(rig.command(245, 2.0, -1.0)) == ACCEPTED
    assert rig.vessel.parameters.changed() == {}


STORED = ((245, (2.0,)), (179, (1.0,)), (224, (1.0, 0.0)))


@pytest.mark.parametrize(("number", "params"), STORED)
def test_what_must_be_stored_is_acknowledged_when_it_is(rig: Rig, number: int, params: tuple[float, ...]) -> None:
    rig.vessel.storage = storage = SlowStorage()
    assert ack_or_none(rig.command(number, *params)) is None
    assert result(rig.command(number, *params)) == IN_PROGRESS, "the client asks again"
    assert len(rig.supervisor.asked) <= 1, "it is done once"
    rig.run(1.0)
    waited = [message.result for message in rig.desk.hear() if message.get_type() == "COMMAND_ACK"]
    assert 1 < len(waited) < 5 and set(waited) == {IN_PROGRESS}
    storage.settle()
    assert result(rig.ask()) == ACCEPTED
    assert ack_or_none(rig.ask()) is None
    assert result(rig.command(number, *params)) == ACCEPTED, "and a repetition only acknowledged again"
    assert len(rig.supervisor.asked) <= 1


@pytest.mark.parametrize(("number", "params"), STORED)
def test_what_cannot_be_stored_has_failed_and_says_why(
    rig: Rig, number: int, params: tuple[float, ...], named: Callable[[Sequence[Any], str], list[Any]]
) -> None:
    rig.vessel.storage = storage = SlowStorage()
    rig.command(number, *params)
    storage.fail()
    heard = rig.ask()
    assert result(heard) == FAILED
    assert [text.text for text in named(heard, "STATUSTEXT")] == ["In force but not stored: No space left on device"]


def test_restart_while_disarmed_only(rig: Rig) -> None:
    assert [result(rig.command(246, value)) for value in (0.0, 2.0, 3.0, NAN)] == [DENIED] * 4
    rig.supervisor.change(armed=True)
    assert result(rig.command(246, 1.0)) == DENIED
    assert rig.vessel.restarts == 0
    rig.supervisor.change(armed=False)
    assert result(rig.command(246, 1.0)) == ACCEPTED
    assert rig.vessel.restarts == 1


def test_prearm_checks(rig: Rig, named: Callable[[Sequence[Any], str], list[Any]]) -> None:
    rig.supervisor.change(arming_refusals=("No position",))
    rig.serve()
    heard = rig.command(401)
    assert result(heard) == ACCEPTED
    assert [message.text for message in named(heard, "STATUSTEXT")] == ["PreArm: No position"]
    rig.supervisor.change(armed=True)
    rig.serve()
    assert result(rig.command(401)) == REJECTED


# --- messages on request -------------------------------------------------------------------------------------------


def test_autopilot_version(make_rig: type[Rig]) -> None:
    rig = make_rig(["memory:", "memory:?dialect=ardupilot"])
    for number, params in ((512, (148.0,)), (520, (1.0,))):
        answer, version = rig.command(number, *params)
        assert (answer.get_type(), answer.result, version.get_type()) == ("COMMAND_ACK", ACCEPTED, "AUTOPILOT_VERSION")
        assert version.capabilities & 0xE1BC == 0xE1BC  # with setpoints, local and global
        assert not version.capabilities & (2 | 131072)
        major_minor_patch = tuple(version.flight_sw_version >> shift & 0xFF for shift in (24, 16, 8))
        assert major_minor_patch >= (1, 4, 1)
        assert version.flight_sw_version & 0xFF == 0  # a development version, never an official one
        assert version.uid != 0
        assert list(version.flight_custom_version[:3]) == [0, 1, 0]
    _, version = rig.command(512, 148.0, desk=1)
    assert version.capabilities & (16 | 131072) == 131072


def test_available_modes_one_by_one(rig: Rig) -> None:
    modes = []
    while not modes or modes[-1].mode_index < modes[-1].number_modes:
        answer, mode = rig.command(512, 435.0, float(len(modes) + 1))
        assert (answer.get_type(), mode.get_type(), mode.mode_index) == (
            "COMMAND_ACK",
            "AVAILABLE_MODES",
            len(modes) + 1,
        )
        modes.append(mode)
    numbers = [mode.custom_mode for mode in modes]
    names = [mode.mode_name for mode in modes]
    assert {0x03040000, 0x04040000, 0x05040000, 0x06040000} <= set(numbers)
    assert len(set(numbers)) == len(set(names)) == len(modes) == len(ModeId)
    assert {mode.standard_mode for mode in modes} <= {0, 6}
    assert not {"Return", "Land", "Takeoff", "Orbit", "VTOL Takeoff"} & set(names)
    assert all(len(name) <= 34 for name in names)
    by_name = {mode.mode_name: mode for mode in modes}
    assert by_name["Mission"].properties & 4 and not by_name["Manual"].properties & 4
    assert not any(mode.properties & 2 for mode in modes)


@pytest.mark.parametrize("index", [0.0, NAN])
def test_available_modes_all_at_once(rig: Rig, index: float) -> None:
    answer, *modes = rig.command(512, 435.0, index)
    assert answer.result == ACCEPTED
    assert [mode.mode_index for mode in modes] == list(range(1, len(ModeId) + 1))


@pytest.mark.parametrize("index", [len(ModeId) + 1.0, 255.0, -1.0, 1.5, math.inf])
def test_available_modes_out_of_range(rig: Rig, index: float) -> None:
    (answer, *more) = rig.command(512, 435.0, index)
    assert answer.result == DENIED
    assert {message.get_type() for message in more} <= {"STATUSTEXT"}


def test_modes_that_cannot_be_selected_are_marked(rig: Rig) -> None:
    mode_type = type(rig.supervisor.modes[0])
    rig.supervisor.modes = (mode_type(ModeId.HOLD), mode_type(ModeId.OFFBOARD, selectable=False))
    modes = rig.command(512, 435.0, 0.0)[1:]
    assert [mode.properties & 2 for mode in modes] == [0, 2]


@pytest.mark.parametrize("number", [395, 259, 280, 1, 999999, 16777215])
def test_messages_that_are_not_there(rig: Rig, number: int) -> None:
    expected = UNSUPPORTED if number != 1 else REJECTED  # SYS_STATUS before the first tick
    assert result(rig.command(512, float(number))) == expected


def test_where_the_parameters_are_described(rig: Rig) -> None:
    answer, described = rig.command(512, 397.0)
    assert answer.result == ACCEPTED
    assert (
        described.get_type() == "COMPONENT_METADATA"
        and described.uri == "mftp:///general.json"
        and described.file_crc != 0
    )


def test_every_streamed_message_can_be_asked_for(rig: Rig) -> None:
    rig.run(0.2)
    for number in STREAMS:
        heard = rig.command(512, float(number))
        assert heard[0].get_type() == "COMMAND_ACK"
        if heard[0].result == ACCEPTED:
            assert heard[1].get_msgId() == number
        else:
            assert heard[0].result == REJECTED
            assert len(heard) == 1


def test_home_on_request(rig: Rig) -> None:
    rig.tick()
    for number, params in ((410, ()), (512, (242.0,))):
        assert [message.get_type() for message in rig.command(number, *params)] == ["COMMAND_ACK", "HOME_POSITION"]
    rig.supervisor.change(home=None)
    rig.serve()
    assert result(rig.command(410)) == REJECTED


def test_intervals_can_be_read(rig: Rig) -> None:
    def interval(number: int) -> int:
        (answer, message) = rig.command(510, float(number))
        assert answer.result == ACCEPTED
        (_, again) = rig.command(512, 244.0, float(number))
        assert (message.message_id, message.interval_us) == (number, again.interval_us)
        return int(message.interval_us)

    assert interval(0) == 1_000_000
    assert interval(30) == 100_000
    assert interval(46) == -1
    assert interval(12345) == 0
    rig.command(511, 30.0, 250_000.0)
    assert interval(30) == 250_000
    rig.command(511, 30.0, -1.0)
    assert interval(30) == -1
    rig.command(511, 30.0, 1.0)
    assert interval(30) == 20_000  # as fast as it gets
    for once_an_hour_or_less in (3.6e9, 3.4e38):
        rig.command(511, 30.0, once_an_hour_or_less)
        assert interval(30) == 2**31 - 1  # the most that the field holds


@pytest.mark.parametrize("params", [(12345.0, 1000.0), (30.0, NAN), (NAN, 1000.0), (30.0, -2.0), (-1.0, 0.0)])
def test_intervals_that_cannot_be(rig: Rig, params: tuple[float, ...]) -> None:
    assert result(rig.command(511, *params)) == DENIED


def test_numbers_beyond_counting_are_no_items(rig: Rig, named: Callable[[Sequence[Any], str], list[Any]]) -> None:
    rig.supervisor.asked.clear()
    for heard in (rig.command(224, 1e38), rig.command(300, 1e38, 2e38)):
        assert result(heard) == DENIED
        assert all("000000" not in message.text for message in named(heard, "STATUSTEXT"))
    assert rig.supervisor.asked == []


# --- servos and relays ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("number", "params", "action"),
    [
        (183, (2.0, 1900.0), SetServo(2, 1900.0)),
        (184, (1.0, 1100.0, 3.0, 2.0), SetServo(1, 1100.0, 3, 2.0)),
        (181, (0.0, 1.0), SetRelay(0, True)),
        (182, (1.0, 4.0, 0.5), SetRelay(1, None, 4, 0.5)),
        (187, (0.5, NAN, -1.0, NAN, NAN, 1.0), SetActuators((0.5, None, -1.0, None, None, 1.0))),
    ],
)
def test_outputs_are_asked_for(rig: Rig, number: int, params: tuple[float, ...], action: Any) -> None:
    assert result(rig.command(number, *params)) == ACCEPTED
    assert rig.supervisor.asked == [("auxiliary", action)]


@pytest.mark.parametrize(
    ("number", "params"),
    [
        (183, (0.0, 1500.0)),
        (183, (1.0, 100.0)),
        (183, (1.0, NAN)),
        (184, (1.0, 1500.0, 0.0, 1.0)),
        (181, (NAN, 1.0)),
        (181, (0.0, 2.0)),
        (182, (0.0, 1.0, 1e9)),
        (187, (2.0,)),
        (187, (NAN, NAN, NAN, NAN, 3.0)),
        (187, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0)),
    ],
)
def test_outputs_asked_for_wrongly_are_denied(rig: Rig, number: int, params: tuple[float, ...]) -> None:
    assert result(rig.command(number, *params)) == DENIED
    assert rig.supervisor.asked == []


def test_a_repetition_that_is_sent_again_is_begun_once(rig: Rig) -> None:
    for _ in range(2):
        assert result(rig.command(182, 0.0, 4.0, 2.0)) == ACCEPTED
    assert len(rig.supervisor.asked) == 1


# --- commands that had piled up ------------------------------------------------------------------------------------


def test_a_command_repeated_before_the_boat_could_answer_gets_one_answer(rig: Rig) -> None:
    """MAVSDK repeats a command after 0.5 s: the answer to the repetition would be one that it does not wait for."""
    ask = mavlink.MAVLink_command_long_message(1, 1, 512, 0, 148.0, *(NAN for _ in range(6)))
    other = mavlink.MAVLink_command_long_message(1, 1, 512, 0, 242.0, *(NAN for _ in range(6)))
    answers = rig.ask(ask, other, ask)
    assert [m.get_type() for m in answers] == ["COMMAND_ACK", "AUTOPILOT_VERSION", "COMMAND_ACK", "HOME_POSITION"]
    assert [m.get_type() for m in rig.ask(ask)] == ["COMMAND_ACK", "AUTOPILOT_VERSION"], "asked anew"


def test_each_sender_of_the_same_command_gets_its_answer(make_rig: type[Rig]) -> None:
    rig = make_rig(["memory:a", "memory:b"])
    ask = mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1.0, *(0.0 for _ in range(6)))
    for desk in rig.desks:
        desk.hear()
        desk.send(ask)
    rig.serve()
    assert [result(desk.hear()) for desk in rig.desks] == [ACCEPTED, ACCEPTED]

"""What the shell answers, word by word where a person reads it; whatever comes in, the answer is short plain text."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.core.decision import Event, ModeId, TextKind
from companion.modes.mode import ModeInfo
from companion.modes.table import DECLARATIONS
from companion.supervisor.shell import COMMANDS, MOST_LINES, WIDTH, Setting, answer
from tests.unit.supervisor.snapshots import snapshot

EVENTS = tuple(Event(float(k), TextKind.ROUTINE, "said", f"Text {k}") for k in range(60))


def lines(line: str, **changes: object) -> tuple[str, ...]:
    return answer(line, snapshot(**changes)).lines


def test_help_names_every_command() -> None:
    assert [line.split()[0] for line in lines("help")] == list(COMMANDS)
    assert lines("HELP") == lines("  help  ")


def test_status() -> None:
    assert lines("status", in_control=245) == (
        "ReVolt 1:20 model ship: disarmed, Hold",
        "Position: 63.440000 10.400000, 0.02 m, rtk fixed",
        "Speed: 0.30 m/s, course 0 deg",
        "Home: 111 m away",
        "Heading: 0 deg, 0.6 deg",
        "Battery: 12.3 V, 56%",
        "Mission: paused, item 3 of 5",
        "Failsafes: none",
        "Operator control: system 245",
        "Load: 0%",
    )
    asked = {"armed": True, "intended_mode": ModeId.RTL, "failsafes": ("leak", "battery_low")}
    told = lines("status", status=asked)
    assert told[0].endswith("armed, Hold (asked for: RTL)") and "Failsafes: leak, battery_low" in told


def test_devices_and_thrusters() -> None:
    assert lines("devices") == (
        "gnss                 ok, 0.1 s",
        "imu                  FAULT: no data",
        "stern_port           ready, +0%",
        "stern_starboard      ready, +0%",
        "bow                  ready, +0%",
    )


def test_sources() -> None:
    sources = {"position": "gnss", "heading": "imu compass", "wind": None}
    assert lines("sources", sources=sources) == (
        "position   gnss, 0.1 s old",
        "heading    imu compass, 0.2 s old",
        "wind       none",
    )


def test_modes_with_their_refusals() -> None:
    modes = tuple(ModeInfo(DECLARATIONS[mode], "") for mode in (ModeId.HOLD, ModeId.FOLLOW))
    assert lines("modes", modes=modes, refusals={ModeId.FOLLOW: "no leader heard"}) == (
        "* Hold       ready",
        "  Follow     refused: no leader heard",
    )


@pytest.mark.parametrize(("line", "first", "count"), [("events", 50, 10), ("events 1", 59, 1), ("events 50", 10, 50)])
def test_events(line: str, first: int, count: int) -> None:
    told = lines(line, events=EVENTS)
    assert len(told) == count and told[0] == f"{first:9.1f} s  INFO     Text {first}"


def test_before_the_first_tick() -> None:
    boat = replace(snapshot(), tick=None)
    assert [len(answer(name, boat).lines) for name in ("status", "devices", "sources", "events")] == [1, 0, 0, 0]


def test_parameters_are_shown() -> None:
    boat = snapshot()
    assert answer("param", boat).lines[0].startswith("0 of ")
    boat.parameters.set("WP_SPEED", 0.7)
    assert answer("param", boat).lines[1:] == ("WP_SPEED          0.7 m/s",)
    assert answer("param wp_speed", boat).lines == (
        "WP_SPEED = 0.7 m/s",
        "  Speed on missions, until the mission sets another",
        "  takes 0.05 to 20 m/s; default 0.6 m/s",
    )
    assert answer("param WP_ST*", boat).lines == ("WP_STUCK_ACT      1 (Hold)", "WP_STUCK_T        120 s")
    assert answer("param WP_NO*", boat).lines == ("WP_NO*: no such parameter; say param WP_N*",)
    assert len(answer("param *", boat).lines) == MOST_LINES and answer("param *", boat).lines[-1] == "... and more"


def test_a_value_is_set_by_who_carries_the_reply_out() -> None:
    boat = snapshot()
    reply = answer("param wp_speed 0.8", boat)
    assert reply.setting == Setting("WP_SPEED", 0.8) and boat.parameters["WP_SPEED"] == pytest.approx(0.6)
    assert reply.lines == ("WP_SPEED = 0.8 m/s (was 0.6 m/s)",)
    assert answer("param MAV_SYS_ID 7", boat).lines == ("MAV_SYS_ID = 7 (was 1), from the next start",)


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("param WP_SPEED 99", "WP_SPEED takes 0.05 to 20 m/s"),
        ("param WP_SPEED nan", "WP_SPEED takes 0.05 to 20 m/s"),
        ("param WP_SPEED fast", "WP_SPEED takes a number: 0.05 to 20 m/s"),
        ("param NAV_DLL_ACT 1.5", "NAV_DLL_ACT takes 0, 1, 2, 3"),
        ("param NAV_DLL_ACT 7", "NAV_DLL_ACT takes 0, 1, 2, 3"),
        ("param SYS_AUTOSTART 5", "SYS_AUTOSTART is read-only"),
        ("param NOTHING 5", "NOTHING: no such parameter"),
        ("param WP_SPEED 1 2", "Say: param [NAME [VALUE]]"),
        ("status now", "Say: status"),
        ("events 51", "events takes a number from 1 to 50"),
        ("events -1", "events takes a number from 1 to 50"),
        ("reboot", "reboot: no such command; say help"),
    ],
)
def test_mistakes_are_named(line: str, text: str) -> None:
    reply = answer(line, snapshot())
    assert reply.lines == (text,) and reply.setting is None


def test_an_empty_line_has_no_answer() -> None:
    assert lines("") == lines("   ") == ()


WORD = st.one_of(st.sampled_from([*COMMANDS, "*", "[", "WP_SPEED", "5", "1e400"]), st.text(max_size=30))
BOAT = snapshot(events=EVENTS)


@given(st.lists(WORD, max_size=4).map(" ".join))
def test_whatever_is_said_the_answer_is_short_and_plain(line: str) -> None:
    reply = answer(line, BOAT)
    assert len(reply.lines) <= MOST_LINES
    assert all(text.isascii() and text.isprintable() and len(text) <= WIDTH for text in reply.lines)
    if reply.setting is not None:
        assert BOAT.parameters.refusal(reply.setting.name, reply.setting.value) is None

"""The shell as consoles use it: QGroundControl's frames, MAVSDK's Shell, MAVProxy's nsh."""

from __future__ import annotations

import re
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from companion.app import program_version
from companion.config import vessel as config_module
from companion.io.mavlink.services.shell import PROMPT
from companion.io.mavlink.wire import messages as mavlink
from tests.protocol.afloat import Afloat
from tests.protocol.desk import Desk, Sender, of
from tests.protocol.mavproxy import MavProxy
from tests.protocol.process import free_port
from tests.waiting import CAP_S, wait_until

SHELL = 10
REPLY, RESPOND, EXCLUSIVE, MULTI = 1, 2, 4, 16
CONSOLE = EXCLUSIVE | RESPOND | MULTI
TAKE_CONTROL = 32100
GREETING = f"USV companion {program_version()}; help lists the commands\n"


@pytest.fixture(scope="module")
def sailing(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    """One for all tests: each opens and closes a session of its own."""
    made = Desk(tmp_path_factory.mktemp("desk"))
    made.ready()
    yield made
    made.close()


@pytest.fixture
def desk(sailing: Desk) -> Iterator[Desk]:
    yield sailing
    close(sailing)
    sailing.tick()


def message(data: bytes, flags: int = CONSOLE, device: int = SHELL) -> Any:
    return mavlink.MAVLink_serial_control_message(device, flags, 0, 0, len(data), list(data.ljust(70, b"\0")), 1, 1)


def close(desk: Desk) -> None:
    desk.tell(message(b"", 0))


def printed(messages: list[Any], system: int = 255) -> str:
    """What a console shows of it."""
    replies = [m for m in of(messages, "SERIAL_CONTROL") if m.target_system == system]
    assert all(m.device == SHELL and m.flags == REPLY and m.target_component == 190 for m in replies)
    return b"".join(bytes(m.data[: m.count]) for m in replies).decode("ascii")


def say(desk: Desk, line: str, ticks: int = 3) -> str:
    """As QGroundControl's console sends a line that somebody has typed."""
    data = line.encode() + b"\n"
    answers = [a for k in range(0, len(data), 70) for a in desk.tell(message(data[k : k + 70]))]
    return printed(answers + desk.tick(ticks))


def test_qgroundcontrols_console(desk: Desk) -> None:
    first = say(desk, "help")
    assert first.startswith(f"{GREETING}{PROMPT}help\n") and first.endswith(f"set one\n{PROMPT}")
    assert say(desk, "") == f"\n{PROMPT}"
    assert say(desk, "why").splitlines()[1] == "Disarmed: nothing speaks against arming"
    close(desk)
    assert say(desk, "").startswith(GREETING), "a new session"


def test_every_command_answers_of_the_boat_itself(desk: Desk) -> None:
    say(desk, "")
    assert "gnss                 ok" in say(desk, "devices")
    assert "position   gnss" in say(desk, "sources")
    assert "* Manual     ready" in say(desk, "modes")
    assert "Home set here" in say(desk, "events 50")
    assert "Position: 63.4389" in say(desk, "status")
    assert "Follow     refused: no leader heard" in say(desk, "modes")


def test_a_line_may_come_in_pieces_and_be_corrected(desk: Desk) -> None:
    say(desk, "")
    for piece in (b"sta", b"tuz\x7f", b"s\x1b"):
        assert printed(desk.tell(message(piece))) == ""
    assert printed(desk.tell(message(b"\r\n"))).startswith("status\nReVolt")


def test_a_parameter_is_set_by_who_may_command(desk: Desk) -> None:
    say(desk, "")
    before = desk.vessel.parameters["WP_SPEED"]
    assert say(desk, "param WP_SPEED 0.75").endswith(f"WP_SPEED = 0.75 m/s (was {before:g} m/s)\n{PROMPT}")
    assert desk.vessel.parameters["WP_SPEED"] == 0.75
    assert desk.latest("PARAM_VALUE").param_id == "WP_SPEED", "all ground stations learn of it"
    other = Sender(system=77)
    desk.rig.send(other.packed(mavlink.MAVLink_command_long_message(1, 1, TAKE_CONTROL, 0, 1, 1, 0, 0, 0, 0, 0)))
    desk.tick()
    assert "Not obeyed: system 77 has control" in say(desk, "param WP_SPEED 0.5")
    assert desk.vessel.parameters["WP_SPEED"] == 0.75
    assert "Operator control: system 77" in say(desk, "status"), "reading is open to all"
    desk.rig.send(other.packed(mavlink.MAVLink_command_long_message(1, 1, TAKE_CONTROL, 0, 0, 0, 0, 0, 0, 0, 0)))
    desk.tick()
    assert "WP_SPEED = 0.5 m/s" in say(desk, "param WP_SPEED 0.5")


def test_each_client_has_its_own_session(desk: Desk) -> None:
    say(desk, "")
    desk.tell(message(b"sta"))
    desk.rig.send(Sender(system=78).packed(message(b"events 1\n")))
    messages = desk.tick(3)
    assert printed(messages, 78).startswith(GREETING) and printed(messages) == ""
    assert printed(desk.tell(message(b"tus\n"))).startswith("status\nReVolt")


def test_no_answer_to_who_wants_none(desk: Desk) -> None:
    """MAVSDK without a subscriber asks for no answer; the value is set all the same."""
    desk.tell(message(b"param WP_SPEED 0.6\n", 0))
    assert printed(desk.tick(3)) == "" and desk.vessel.parameters["WP_SPEED"] == pytest.approx(0.6)


def test_only_the_shell_is_offered(desk: Desk) -> None:
    answers = desk.tell(message(b"x\n", device=2))
    assert not of(answers, "SERIAL_CONTROL")
    assert [m.text for m in of(answers, "STATUSTEXT")] == ["No such serial port: the shell alone (10)"]
    assert not of(desk.tell(message(b"x\n", CONSOLE | REPLY)), "SERIAL_CONTROL"), "another vehicle's reply"


def test_polls_bring_no_prompts(desk: Desk) -> None:
    say(desk, "")
    assert all(printed(desk.tell(message(b""))) == "" for _ in range(20))


def test_a_flood_is_bounded(desk: Desk) -> None:
    say(desk, "")
    answers = [a for _ in range(20) for a in desk.tell(message(b"param *\n" * 8))]
    told = printed(answers + desk.tick(100))
    assert len(told) < 60_000, "of 300 000 that it would be"
    assert "Too much at once" in told
    assert say(desk, "x" * 300).endswith(f"Line longer than 200 characters\n{PROMPT}")
    assert say(desk, "status").startswith("status\nReVolt")


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.binary(max_size=70), st.integers(0, 255), st.sampled_from([SHELL, SHELL, SHELL, 0, 255]), st.integers(0, 255))
def test_whatever_comes_the_boat_goes_on(desk: Desk, data: bytes, flags: int, device: int, count: int) -> None:
    garbled = mavlink.MAVLink_serial_control_message(device, flags, 0, 0, count, list(data.ljust(70, b"\0")), 1, 1)
    desk.tell(garbled)
    failed = {"mavlink_handler_failed", "mavlink_service_failed"}
    assert not failed & {event.name for event in desk.vessel.events.drain()}


def test_too_many_clients_are_refused(desk: Desk) -> None:
    senders = [Sender(system) for system in range(100, 109)]
    for sender in senders:
        desk.rig.send(sender.packed(message(b"")))
    messages = desk.tick(2)
    assert "Shell refused: too many clients use it" in [m.text for m in of(messages, "STATUSTEXT")]
    for sender in senders:
        desk.rig.send(sender.packed(message(b"", 0)))
    desk.tick()


@pytest.mark.process
def test_mavsdks_shell(tmp_path: Path) -> None:
    """As its example does it: it prints what comes, and sends a line for each that is typed."""
    from mavsdk import ComponentType, Configuration, Mavsdk
    from mavsdk.plugins.shell import Device, Shell

    port = free_port()
    config = config_module.load(config_module.find("revolt"))
    with Afloat(tmp_path, config, [f"udpout:127.0.0.1:{port}"], seed=3) as afloat:
        with Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION)) as sdk:
            sdk.add_any_connection(f"udpin://127.0.0.1:{port}")
            system = sdk.first_autopilot(CAP_S)
            assert system is not None
            shell, heard = Shell(system), []
            shell.subscribe_receive(lambda text, _user: heard.append(text.data))
            wait_until(
                lambda: "WP_SPEED = 0.7 m/s (was 0." in "".join(heard),
                "set",
                again=lambda: shell.send("param WP_SPEED 0.7", Device.SHELL),  # MAVSDK may lose the first answer
            )
            shell.send("status\n", Device.SHELL)
            wait_until(lambda: re.search(r"usv> status\nReVolt.*\n(.*\n)+Load: .*\nusv> $", "".join(heard)), "status")
        assert afloat.vessel.parameters["WP_SPEED"] == pytest.approx(0.7)


@pytest.mark.process
@pytest.mark.parametrize("persona", ["px4", "ardupilot"])
def test_mavproxys_console(tmp_path: Path, persona: str) -> None:
    port = free_port(socket.SOCK_STREAM)
    config = config_module.load(config_module.find("revolt"))
    link = f"tcpin:127.0.0.1:{port}?dialect={persona}"
    boat, master = Afloat(tmp_path, config, [link], seed=3), f"tcp:127.0.0.1:{port}"
    with boat as afloat, MavProxy(master, tmp_path / "mavproxy", modules=("nsh",)) as station:
        station.expect("online system 1")
        station.say("nsh start")
        station.expect("help lists the commands\nusv> $")
        station.say("why")
        station.expect(r"why\n(Armed|Disarmed).*\n")
        station.say("param WP_SPEED 0.7")
        station.expect(r"WP_SPEED = 0.7 m/s \(was 0.6 m/s\)\nusv> ")
        station.say(".")
        assert afloat.vessel.parameters["WP_SPEED"] == pytest.approx(0.7)

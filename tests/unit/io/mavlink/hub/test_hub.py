from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.core.decision import Severity
from companion.io.mavlink.assembly import connect
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import Framer

HEARTBEAT = mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_GCS, 8, 0, 0, 4, 3)
ONBOARD = mavlink.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3)


class Recorder:
    """A service that writes down what it is given, and may fail."""

    def __init__(self, hub: Any) -> None:
        self.taken: list[tuple[Any, Any, float]] = []
        self.updates: list[float] = []
        self.error: Exception | None = None
        self.fails: Exception | None = None  # in its own work

    @property
    def handles(self) -> Mapping[int, Any]:
        return {mavlink.MAVLINK_MSG_ID_PING: self._take, mavlink.MAVLINK_MSG_ID_SET_MODE: self._take}

    def _take(self, message: Any, peer: Any, now_s: float) -> None:
        self.taken.append((message, peer, now_s))
        if self.error is not None:
            raise self.error

    def update(self, now_s: float) -> None:
        self.updates.append(now_s)
        self.answer(now_s)

    def answer(self, now_s: float) -> None:
        if self.fails is not None:
            raise self.fails


@pytest.fixture
def recorder() -> list[Recorder]:
    return []


@pytest.fixture
def recording(make_rig: Any, recorder: list[Recorder]) -> Any:
    def services(hub: Any) -> list[Recorder]:
        recorder.append(Recorder(hub))
        return recorder

    return make_rig(["memory:a", "memory:b"], services=services)


def ping(system: int, component: int) -> Any:
    return mavlink.MAVLink_ping_message(1, 2, system, component)


def test_the_handler_learns_who_asked(recording: Any, recorder: list[Recorder]) -> None:
    recording.desks[1].send(ping(1, 1))
    recording.now_s = 3.5
    recording.serve()
    ((message, peer, now_s),) = recorder[0].taken
    assert (message.seq, now_s) == (2, 3.5)
    assert (peer.endpoint, peer.system, peer.component) == (recording.desks[1].endpoint, 254, 190)


@pytest.mark.parametrize(
    ("system", "component", "ours"),
    [
        (0, 0, True),
        (1, 0, True),
        (1, 1, True),
        (0, 1, True),
        (2, 0, False),
        (2, 1, False),
        (1, 100, False),
        (0, 190, False),
        (255, 190, False),
    ],
)
def test_only_what_is_addressed_to_us(
    recording: Any, recorder: list[Recorder], system: int, component: int, ours: bool
) -> None:
    recording.ask(ping(system, component))
    assert bool(recorder[0].taken) == ours


def test_our_own_echo_is_not_obeyed(recording: Any, recorder: list[Recorder]) -> None:
    recording.desk.system, recording.desk.component = 1, 1
    recording.ask(ping(0, 0))
    assert recorder[0].taken == []
    recording.desk.component = 191  # another computer aboard
    recording.ask(ping(0, 0))
    assert len(recorder[0].taken) == 1


def test_the_system_id_is_the_parameter(make_rig: Any) -> None:
    rig = make_rig(["memory:"])
    rig.vessel.parameters.set("MAV_SYS_ID", 42)
    hub = connect(rig.vessel, [rig.desk.link], "0.1.0")
    hub.broadcast(HEARTBEAT)
    hub.serve(0.0)
    assert {(m.get_srcSystem(), m.get_srcComponent()) for m in rig.desk.hear()} == {(42, 1)}


def test_a_failing_handler_becomes_an_event_and_the_next_message_is_served(
    recording: Any, recorder: list[Recorder]
) -> None:
    recorder[0].error = KeyError("odd")
    recording.ask(ping(1, 1), mavlink.MAVLink_set_mode_message(1, 1, 0))
    assert len(recorder[0].taken) == 2
    events = recording.vessel.events.drain()
    assert {event.name for event in events} == {"mavlink_handler_failed"}
    assert [event.text.split()[0] for event in events] == ["PING", "SET_MODE"]
    assert all(event.severity is Severity.ERROR for event in events)


def test_a_service_that_fails_becomes_an_event_and_the_others_go_on(
    recording: Any, recorder: list[Recorder], named: Any
) -> None:
    recorder[0].fails = KeyError("odd")
    recording.run(1.0)
    heard = recording.desk.hear()
    assert len(named(heard, "HEARTBEAT")) >= 1 and len(recorder[0].updates) == 10
    assert [m.text for m in named(heard, "STATUSTEXT")] == ["Recorder not served: KeyError: 'odd'"]
    recording.ask(ping(1, 1))
    assert len(recorder[0].taken) == 1


def test_services_are_updated_each_tick(recording: Any, recorder: list[Recorder]) -> None:
    recording.run(0.5)
    assert recorder[0].updates == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5])


def test_answers_go_to_who_asked_alone_and_broadcasts_to_all(make_rig: Any, named: Any) -> None:
    rig = make_rig(["memory:a", "memory:b"])
    assert len(named(rig.command(999), "COMMAND_ACK")) == 1
    assert named(rig.desks[1].hear(), "COMMAND_ACK") == []
    rig.hub.broadcast(ping(9, 9))
    rig.serve()
    assert [len(named(desk.hear(), "PING")) for desk in rig.desks] == [1, 1]


def test_stations_are_those_that_say_so(recording: Any) -> None:
    recording.ask(ping(1, 1))
    recording.ask(ONBOARD)
    assert recording.supervisor.heard == 0
    recording.ask(HEARTBEAT)
    recording.ask(ping(2, 2))  # any message of theirs counts from now on, also to others
    assert recording.supervisor.heard == 2


def test_a_station_is_greeted_once_for_each_coming(rig: Any, named: Any) -> None:
    rig.supervisor.change(arming_refusals=("No position",))
    rig.now_s = 5.0
    rig.serve()
    greeting = [message.text for message in named(rig.ask(HEARTBEAT), "STATUSTEXT")]
    assert greeting == ["USV companion 0.1.0"]
    rig.now_s = 10.0
    assert named(rig.ask(HEARTBEAT), "STATUSTEXT") == []
    rig.now_s = 40.0
    assert named(rig.ask(HEARTBEAT), "STATUSTEXT")[0].text == "USV companion 0.1.0"


def test_a_station_that_comes_later_is_told_what_was_lost_at_the_start(
    rig: Any, named: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The event of it had passed: nobody heard of a fence whose file was damaged."""
    monkeypatch.setattr(rig.vessel.storage, "lost", lambda: ("Fence lost at start: upload it again",), raising=False)
    rig.run(60.0)
    greeting = named(rig.ask(HEARTBEAT), "STATUSTEXT")
    assert [message.text for message in greeting[:2]] == ["USV companion 0.1.0", "Fence lost at start: upload it again"]


def test_a_boat_that_has_only_just_begun_to_look_is_not_complained_of(rig: Any, named: Any) -> None:
    rig.supervisor.change(arming_refusals=("gnss: nothing received yet",))
    greeting = [message.text for message in named(rig.ask(HEARTBEAT), "STATUSTEXT")]
    rig.run(2.9)
    assert greeting == ["USV companion 0.1.0"]
    assert named(rig.desk.hear(), "STATUSTEXT") == []
    rig.run(2.2)
    assert [message.text for message in named(rig.desk.hear(), "STATUSTEXT")] == ["PreArm: gnss: nothing received yet"]


def test_a_station_of_a_vessel_in_fast_motion_is_not_greeted_at_every_heartbeat(rig: Any, named: Any) -> None:
    rig.hub.patience = 20.0
    greetings = []
    for now_s in (0.0, 20.0, 40.0, 280.0, 600.0):
        rig.now_s = now_s
        greetings.append(len(named(rig.ask(HEARTBEAT), "STATUSTEXT")))
    assert greetings == [1, 0, 0, 0, 1]


def test_news_of_links_become_events(rig: Any) -> None:
    rig.desk.link.news = lambda: ["tcpin: closed a client"]
    rig.serve()
    rig.serve()
    assert [(event.name, event.text) for event in rig.vessel.events.drain()] == [("link", "tcpin: closed a client")]


def test_sequence_numbers_run_on_each_endpoint_by_itself(make_rig: Any) -> None:
    rig = make_rig(["memory:a", "memory:b?dialect=ardupilot"])
    for _ in range(30):
        rig.tick()
        rig.desks[1].send(mavlink.MAVLink_command_long_message(1, 1, 999, 0, 0, 0, 0, 0, 0, 0, 0))
    for desk in rig.desks:
        sequence = [message.get_seq() for message in desk.hear()]
        assert sequence == [i % 256 for i in range(len(sequence))]
        assert len(sequence) > 60


def test_the_tap_gets_whole_packets_both_ways(make_rig: Any, named: Any) -> None:
    packets: list[bytes] = []
    rig = make_rig(["memory:a", "memory:b"], tap=packets.extend)
    rig.tick()
    rig.command(999)
    kinds = []
    for packet in packets:
        (message,) = Framer().feed(packet)
        assert len(message.get_msgbuf()) == len(packet)
        kinds.append(message.get_type())
    assert kinds.count("COMMAND_LONG") == kinds.count("COMMAND_ACK") == 1
    assert kinds.count("HEARTBEAT") == 1  # once, not once an endpoint
    outgoing = [Framer().feed(packet)[0] for packet in packets]
    own = [message.get_seq() for message in outgoing if message.get_srcSystem() == 1]
    assert own == list(range(len(own)))


def test_the_log_is_written_with_no_station_there(make_rig: Any) -> None:
    packets: list[bytes] = []
    rig = make_rig([], tap=packets.extend)
    rig.run(1.0)
    assert len(packets) > 20


@settings(deadline=None, derandomize=True, max_examples=100)
@given(number=st.sampled_from(sorted(mavlink.MESSAGES)), payload=st.binary(max_size=255), target=st.booleans())
def test_no_payload_of_any_message_gets_past_the_hub(number: int, payload: bytes, target: bool) -> None:
    """Every message of the dialect with any payload: nothing raises, nothing reaches the last guard."""
    from pymavlink.dialects.v20 import common

    rig = _RIG[0]
    cls = mavlink.MESSAGES[number]
    payload = payload[: cls.unpacker.size] or b"\x00"
    head = bytes((0xFD, len(payload), 0, 0, 0, 255, 190, number & 0xFF, number >> 8 & 0xFF, number >> 16))
    crc = common.x25crc((head + payload)[1:] + bytes((cls.crc_extra,))).crc
    rig.desk.link.to_vessel(head + payload + bytes((crc & 0xFF, crc >> 8)))
    rig.tick()
    failed = ("mavlink_handler_failed", "mavlink_service_failed", "telemetry_failed")
    assert [event for event in rig.vessel.last_tick.events if event.name in failed] == []


_RIG: list[Any] = []


@pytest.fixture(autouse=True)
def _a_rig(make_rig: Any) -> None:
    _RIG[:] = [make_rig(["memory:"])]


def test_the_health_of_a_link_says_that_it_obeys_anybody(make_rig: Any) -> None:
    rig = make_rig(["memory:a"])
    for name, exposed in (("tcpin:0.0.0.0:5760", True), ("tcpin:127.0.0.1:5760", False)):
        rig.desk.link.name = name
        (health,) = connect(rig.vessel, [rig.desk.link], "0.1.0").health(0.0)
        assert health.ok and ("obeys anybody in the network" in health.text) is exposed

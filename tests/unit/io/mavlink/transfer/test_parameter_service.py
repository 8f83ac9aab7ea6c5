"""Parameters listed, read and set, in both encodings."""

from __future__ import annotations

import math
import struct
from typing import Any

import pytest

from companion.core.storing import Stored, Ticket
from companion.io.mavlink.transfer.parameter_service import ParameterService, parameter_hash
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.hub import Peer
from companion.io.mavlink.wire.personas import GENERIC
from companion.params.spec import integer, real
from companion.params.store import Parameters
from tests.unit.io.mavlink.conftest import Desk
from tests.unit.io.mavlink.slow_storage import SlowStorage

REAL32, INT32, UINT32 = 9, 6, 5
HASH = "_HASH_CHECK"
NO_PLACE = 65535  # param_index of what stands in no list
VALUE, ERROR = mavlink.MAVLINK_MSG_ID_PARAM_VALUE, mavlink.MAVLINK_MSG_ID_PARAM_ERROR


@pytest.fixture(autouse=True)
def service(desk: Desk) -> Any:
    return desk.serve(ParameterService(desk.hub, desk.vessel))


def as_float(number: int, code: str = "<i") -> float:
    return float(struct.unpack("<f", struct.pack(code, number).ljust(4, b"\0"))[0])


def as_int(value: float) -> int:
    return int(struct.unpack("<i", struct.pack("<f", value))[0])


def setting(name: str, value: float, kind: int) -> Any:
    return mavlink.MAVLink_param_set_message(1, 1, name.encode(), value, kind)


def as_bits(message: Any) -> int:
    return int(struct.unpack("<I", struct.pack("<f", message.param_value))[0])


def listed(desk: Desk, peer: Peer, wait_s: float = 2.0) -> list[Any]:
    desk.tell(mavlink.MAVLink_param_request_list_message(1, 0), peer)
    desk.wait(wait_s)
    heard = desk.heard()
    assert all(to == peer and message.id == VALUE for to, message in heard)
    return [message for _, message in heard]


def asked_hash(desk: Desk, peer: str = "qgc") -> Any:
    desk.tell(mavlink.MAVLink_param_request_read_message(1, 1, HASH.encode(), -1), desk.peer(peer))
    ((to, answer),) = desk.heard()
    assert to == desk.peer(peer)
    return answer


def hash_of_cache(values: list[Any]) -> int:
    """As QGroundControl computes it: over what it kept of the list, sorted by name, each name and four bytes of value.
    The CRC bit by bit: reflected 0x04C11DB7, from 0, not inverted."""
    state = 0
    for value in sorted(values, key=lambda one: str(one.param_id)):
        for byte in value.param_id.encode() + struct.pack("<f", value.param_value):
            state ^= byte
            for _ in range(8):
                state = state >> 1 ^ (0xEDB88320 if state & 1 else 0)
    return state


@pytest.mark.parametrize("name", ["qgc", "rover"])
def test_the_list_is_whole_and_in_order(desk: Desk, name: str) -> None:
    values = listed(desk, desk.peer(name))
    if name == "qgc":
        assert values.pop(0).param_id == HASH
    specs = desk.parameters.specs
    assert [v.param_id for v in values] == [spec.name for spec in specs]
    assert [v.param_index for v in values] == list(range(len(specs)))
    assert {v.param_count for v in values} == {len(specs)}
    for value, spec in zip(values, specs, strict=True):
        assert value.param_type == (INT32 if spec.type.value == "Int32" else REAL32)
        bytewise = name == "qgc" and value.param_type == INT32
        assert (as_int(value.param_value) if bytewise else value.param_value) == desk.parameters[spec.name]


def test_negative_whole_numbers_travel_as_bits_too(desk: Desk) -> None:
    desk.tell(mavlink.MAVLink_param_request_read_message(1, 1, b"COM_FLTMODE1", -1))
    (value,) = desk.replies()
    assert as_int(value.param_value) == -1


def test_the_list_is_paced(desk: Desk) -> None:
    desk.tell(mavlink.MAVLink_param_request_list_message(1, 1))
    assert len(desk.heard()) == 40
    desk.wait(0.1)
    assert len(desk.heard()) == 40


def test_repeated_list_requests_do_not_raise_the_rate(desk: Desk) -> None:
    for _ in range(50):
        desk.tell(mavlink.MAVLink_param_request_list_message(1, 1))
    assert len(desk.heard()) == 40
    desk.wait(2.0)
    rest = [m.param_index for m in desk.replies()]
    assert rest == list(range(rest[0], len(desk.parameters.specs)))


def test_two_ground_stations_have_a_list_each(desk: Desk) -> None:
    for name in ("qgc", "other"):
        desk.tell(mavlink.MAVLink_param_request_list_message(1, 1), desk.peer(name))
    desk.wait(2.0)
    heard = desk.heard()
    for name in ("qgc", "other"):
        indices = [m.param_index for to, m in heard if to == desk.peer(name)]
        assert indices == [NO_PLACE, *range(len(desk.parameters.specs))]


def test_a_slow_line_is_not_filled(desk: Desk) -> None:
    slow = Peer(
        Endpoint("radio", desk.peer("qgc").endpoint.persona, lambda data, now_s: 0, bytes_per_s=1000.0), 255, 190
    )
    desk.tell(mavlink.MAVLink_param_request_list_message(1, 1), slow)
    desk.heard()
    desk.wait(1.0)
    assert 8 <= len(desk.heard()) <= 16


def test_a_line_that_is_gone_gets_no_list(desk: Desk) -> None:
    desk.tell(mavlink.MAVLink_param_request_list_message(1, 1))
    desk.heard()
    desk.peer("qgc").endpoint.gone = True
    desk.wait(1.0)
    assert desk.heard() == []


def test_the_hash_before_the_list_is_that_of_the_cache(desk: Desk) -> None:
    assert desk.parameters.set("COM_FLTMODE1", -1) is None and desk.parameters.set("WP_SPEED", 0.7) is None
    desk.wait(0.1)
    desk.heard()
    first, *values = listed(desk, desk.peer("qgc"))
    assert (first.param_id, first.param_type, first.param_count) == (HASH, UINT32, len(desk.parameters.specs))
    assert first.param_index == NO_PLACE
    assert as_bits(first) == hash_of_cache(values)


def test_the_hash_by_name_follows_the_values(desk: Desk) -> None:
    values = listed(desk, desk.peer("qgc"))[1:]
    before = asked_hash(desk)
    assert (before.id, before.param_id, before.param_type, before.param_index) == (VALUE, HASH, UINT32, NO_PLACE)
    assert as_bits(before) == hash_of_cache(values)
    assert desk.parameters.set("WP_SPEED", 0.7) is None
    desk.wait(0.1)
    desk.heard()
    changed = asked_hash(desk)
    assert as_bits(changed) != as_bits(before)
    assert as_bits(changed) == hash_of_cache(listed(desk, desk.peer("qgc"))[1:])
    desk.parameters.reset()
    desk.wait(0.1)
    desk.heard()
    assert as_bits(asked_hash(desk)) == as_bits(before)


def test_the_hash_differs_where_a_name_or_a_type_does() -> None:
    rows = [real("ONE", 1.0, 0.0, 9.0, "", "A", ""), integer("TWO", 2, 0, 9, "", "A", "")]
    others = [
        [rows[0], integer("TOW", 2, 0, 9, "", "A", "")],
        [rows[0], real("TWO", 2.0, 0.0, 9.0, "", "A", "")],
        rows[:1],
    ]
    assert parameter_hash(Parameters(table=rows)) == parameter_hash(Parameters(table=rows[::-1]))
    assert parameter_hash(Parameters(table=rows)) not in [parameter_hash(Parameters(table=other)) for other in others]


def test_setting_the_hash_ends_the_list_without_a_word(desk: Desk) -> None:
    desk.tell(mavlink.MAVLink_param_request_list_message(1, 1))
    desk.tell(mavlink.MAVLink_param_request_list_message(1, 1), desk.peer("other"))
    bits = as_bits(desk.replies()[0])
    desk.tell(setting(HASH, as_float(bits, "<I"), UINT32))
    desk.wait(2.0)
    heard = desk.heard()
    assert {to for to, _ in heard} == {desk.peer("other")}, "the other one's list goes on"
    assert {m.id for _, m in heard} == {VALUE} and desk.texts() == []


@pytest.mark.parametrize("name", ["rover", "plain"])
def test_clients_of_other_personas_have_no_hash(desk: Desk, name: str) -> None:
    desk.add_peer("plain", Peer(Endpoint("plain", GENERIC, lambda data, now_s: len(data)), 255, 190))
    assert {m.param_id for m in listed(desk, desk.peer(name))} == {spec.name for spec in desk.parameters.specs}
    answer = asked_hash(desk, name)
    assert (answer.id, answer.error, answer.param_id) == (ERROR, 1, HASH)
    desk.tell(setting(HASH, 1.0, REAL32), desk.peer(name))
    assert [(m.id, m.error) for m in desk.replies()] == [(ERROR, 1)]


def test_read_by_name_and_by_index(desk: Desk) -> None:
    index = desk.parameters.index["WP_SPEED"]
    desk.tell(mavlink.MAVLink_param_request_read_message(1, 1, b"WP_SPEED", -1))
    desk.tell(mavlink.MAVLink_param_request_read_message(1, 1, b"", index))
    one, two = desk.replies()
    assert (
        (one.param_id, one.param_index, one.param_value)
        == (two.param_id, two.param_index, two.param_value)
        == ("WP_SPEED", index, desk.parameters["WP_SPEED"])
    )


@pytest.mark.parametrize(
    ("name", "index"),
    [(b"FLW_TGT_YP", -1), (b"", 9999), (b"", -2), (b"\xff\xfe\x80", -1), (b"SIXTEEN_CHARS_XX", -1), (b"", -1)],
)
def test_an_unknown_parameter_is_refused_at_once(desk: Desk, name: bytes, index: int) -> None:
    desk.tell(mavlink.MAVLink_param_request_read_message(1, 1, name, index))
    ((to, error),) = desk.heard()
    assert to == desk.peer("qgc") and (error.id, error.error, error.param_index) == (ERROR, 1, index)
    assert (error.target_system, error.target_component) == (255, 190)
    assert name.startswith(b"\xff") or error.param_id == name.decode()
    assert desk.texts() == []


@pytest.mark.parametrize(
    ("peer", "value", "kind"),
    [
        ("qgc", as_float(4), INT32),
        ("qgc", as_float(4, "<I"), 5),
        ("qgc", as_float(4, "<h"), 4),
        ("qgc", as_float(4, "<H"), 3),
        ("qgc", as_float(4, "<b"), 2),
        ("qgc", as_float(4, "<B"), 1),
        ("qgc", 4.0, REAL32),
        ("rover", 4.0, INT32),
        ("rover", 4.0, REAL32),
        ("rover", 4.0, 1),
        ("rover", 4.0, 77),
    ],
)
def test_a_whole_number_is_set_and_sent_to_all_in_their_own_encoding(
    desk: Desk, peer: str, value: float, kind: int
) -> None:
    desk.tell(setting("ALLOC_ITER", value, kind), desk.peer(peer))
    assert desk.parameters["ALLOC_ITER"] == 4
    told = {to.name: m for to, m in desk.heard()}
    assert {m.id for m in told.values()} == {VALUE}
    assert as_int(told["qgc"].param_value) == as_int(told["other"].param_value) == 4
    assert told["rover"].param_value == 4.0 and told["rover"].param_type == INT32
    desk.wait(1.0)
    assert desk.heard() == []  # once


@pytest.mark.parametrize(
    ("peer", "value", "kind"),
    [("qgc", 0.7, REAL32), ("rover", 0.7, REAL32), ("rover", 0.7, 1), ("qgc", as_float(1), INT32)],
)
def test_a_real_number_is_set(desk: Desk, peer: str, value: float, kind: int) -> None:
    desk.tell(setting("WP_SPEED", value, kind), desk.peer(peer))
    assert desk.parameters["WP_SPEED"] == pytest.approx(1.0 if kind == INT32 else 0.7, rel=1e-6)
    assert len(desk.heard()) == 3


@pytest.mark.parametrize(
    ("peer", "name", "value", "kind", "error"),
    [
        ("qgc", "WP_SPEED", 99.0, REAL32, 2),
        ("qgc", "WP_SPEED", math.nan, REAL32, 2),
        ("qgc", "WP_SPEED", math.inf, REAL32, 2),
        ("rover", "WP_SPEED", math.nan, REAL32, 2),
        ("rover", "ALLOC_ITER", math.nan, INT32, 2),
        ("rover", "ALLOC_ITER", -math.inf, INT32, 2),
        ("qgc", "ALLOC_ITER", as_float(99), INT32, 2),
        ("qgc", "ALLOC_ITER", as_float(-1), INT32, 2),
        ("qgc", "ALLOC_ITER", math.nan, REAL32, 2),
        ("qgc", "ALLOC_ITER", 2.5, REAL32, 7),
        ("qgc", "ALLOC_ITER", as_float(4), REAL32, 7),  # bits under the wrong name: a tiny fraction
        ("qgc", "ALLOC_ITER", 4.0, 10, 6),
        ("qgc", "WP_SPEED", 0.5, 0, 6),
        ("qgc", "SYS_AUTOSTART", as_float(3), INT32, 5),
        ("rover", "SYS_AUTOSTART", 3.0, INT32, 5),
        ("qgc", "MAN_RC_SAFE_CH", as_float(3), INT32, 2),
    ],
)
def test_a_refusal_comes_first_and_then_the_value_that_stays(
    desk: Desk, peer: str, name: str, value: float, kind: int, error: int
) -> None:
    before = desk.parameters[name]
    desk.tell(setting(name, value, kind), desk.peer(peer))
    (to_first, first), (to_second, second) = desk.heard()
    assert to_first == to_second == desk.peer(peer)
    assert (first.id, first.error, first.param_id, first.param_index) == (
        ERROR,
        error,
        name,
        desk.parameters.index[name],
    )
    assert second.id == VALUE and second.param_id == name
    bytewise = peer == "qgc" and second.param_type == INT32
    assert (as_int(second.param_value) if bytewise else second.param_value) == before == desk.parameters[name]
    (text,) = desk.texts()
    assert text.startswith(f"{name} stays {before:g}: ")


def test_the_reason_names_the_remedy(desk: Desk) -> None:
    desk.tell(setting("WP_SPEED", 99.0, REAL32))
    desk.tell(setting("MAN_RC_SAFE_CH", as_float(3), INT32))
    assert desk.texts() == [
        "WP_SPEED stays 0.6: it takes 0.05 to 20 m/s",
        "MAN_RC_SAFE_CH stays 5: it takes 0, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16",
    ]


@pytest.mark.parametrize("name", ["NO_SUCH_NAME", "wp_speed", "SIXTEEN_CHARS_XX", "_HASH_CHECKS", ""])
def test_an_unknown_name_cannot_be_set(desk: Desk, name: str) -> None:
    desk.tell(setting(name, 1.0, REAL32))
    ((to, error),) = desk.heard()
    assert to == desk.peer("qgc") and (error.id, error.error, error.param_id) == (ERROR, 1, name)
    assert len(desk.texts()) == 1


def test_other_changes_are_sent_too_and_many_of_them_in_turns(desk: Desk) -> None:
    changed = [
        spec.name
        for spec in desk.parameters.specs
        if not spec.read_only and spec.type.value == "Float" and spec.minimum < spec.default
    ][:30]
    for name in changed:
        assert desk.parameters.set(name, (desk.parameters.spec(name).minimum + desk.parameters[name]) / 2) is None
    desk.wait(0.1)
    told = [m.param_id for to, m in desk.heard() if to.name == "qgc"]
    assert told == changed
    desk.parameters.reset()
    desk.wait(0.5)
    assert sorted(m.param_id for to, m in desk.heard() if to.name == "qgc") == sorted(changed)


def test_sixteen_letters_fit(desk: Desk) -> None:
    desk.tell(setting("ABCDEFGHIJKLMNOP", 1.0, REAL32))
    assert desk.replies()[0].param_id == "ABCDEFGHIJKLMNOP"


class Slow:
    """A desk whose vessel stores when it is told to."""

    def __init__(self, desk: Desk) -> None:
        self.desk, self.storage = desk, SlowStorage()
        desk.vessel.storage = self.storage
        self.service = desk.serve(ParameterService(desk.hub, desk.vessel))

    def set(self, value: float, name: str = "WP_SPEED", peer: str = "qgc") -> None:
        self.desk.tell(setting(name, value, REAL32), self.desk.peer(peer))

    def answers(self) -> list[tuple[Any, Any]]:
        self.service.answer(self.desk.now_s)
        return self.desk.heard()


def test_a_value_is_in_force_at_once_and_acknowledged_when_it_is_stored(desk: Desk) -> None:
    slow = Slow(desk)
    for value in (0.75, 0.5, 0.5):
        slow.set(value)
    assert slow.answers() == [] and desk.parameters["WP_SPEED"] == 0.5
    slow.storage.settle()
    answers = slow.answers()
    assert [message.param_value for _, message in answers] == [0.5] * len(desk.hub.endpoints), "once, to all"
    assert slow.answers() == []


def test_a_newer_value_waits_for_its_own_storing(desk: Desk) -> None:
    slow = Slow(desk)
    slow.set(0.75)
    first = slow.storage.tickets[0]
    first.state = Stored.DURABLE
    slow.set(0.5)
    assert slow.answers() == [], "0.75 is stored, but 0.5 is in force"
    slow.storage.settle()
    assert {message.param_value for _, message in slow.answers()} == {0.5}


def test_another_parameter_does_not_hold_up_the_first(desk: Desk) -> None:
    slow = Slow(desk)
    slow.set(0.75)
    slow.storage.tickets[0].state = Stored.DURABLE
    slow.set(2.0, "NAV_ACC_RAD")
    assert {message.param_id for _, message in slow.answers()} == {"WP_SPEED"}


def test_what_cannot_be_stored_is_told_to_who_asked_and_acknowledged_later(desk: Desk) -> None:
    slow = Slow(desk)
    slow.set(0.75, peer="qgc")
    slow.set(0.75, peer="rover")
    slow.storage.fail()
    errors = slow.answers()
    assert [(to, m.id, m.error) for to, m in errors] == [
        (desk.peer("qgc"), ERROR, mavlink.MAV_PARAM_ERROR_PERMISSION_DENIED),
        (desk.peer("rover"), ERROR, mavlink.MAV_PARAM_ERROR_PERMISSION_DENIED),
    ]
    assert desk.parameters["WP_SPEED"] == 0.75
    assert desk.texts() == ["WP_SPEED not stored: No space left on device"]
    assert slow.answers() == [], "told once"
    slow.storage.tickets[0].state = Stored.DURABLE
    assert {message.id for _, message in slow.answers()} == {VALUE}


class SettledBetween(Ticket):
    """A ticket that the writer's thread settles between two questions about it."""

    __slots__ = ("questions",)

    @property
    def state(self) -> Stored:
        self.questions -= 1
        return Stored.PENDING if self.questions >= 0 else Stored.DURABLE

    @state.setter
    def state(self, state: Stored) -> None:
        self.questions = 0


@pytest.mark.parametrize("questions", range(8))
def test_a_value_that_is_stored_between_two_questions_has_not_failed(desk: Desk, questions: int) -> None:
    slow, ticket = Slow(desk), SettledBetween()
    slow.storage.parameters = lambda: ticket  # type: ignore[method-assign]
    ticket.questions = questions
    slow.set(0.75)
    heard = [desk.heard() + slow.answers() for _ in range(8)]
    assert desk.texts() == [] and {message.id for answers in heard for _, message in answers} == {VALUE}


def test_a_later_change_that_is_stored_acknowledges_the_one_that_was_not(desk: Desk) -> None:
    slow = Slow(desk)
    slow.set(0.75)
    slow.storage.fail()
    slow.answers()
    slow.set(2.0, "NAV_ACC_RAD")
    slow.storage.settle()
    assert {message.param_id for _, message in slow.answers()} == {"WP_SPEED", "NAV_ACC_RAD"}

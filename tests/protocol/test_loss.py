"""Transfers over a bad radio, and two ground stations at once, against a whole vessel in lockstep."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from companion.io.mavlink.wire import messages as mavlink
from companion.mission.plan import PlanKind
from companion.params.table import TABLE
from tests.protocol.desk import Desk, of
from tests.protocol.test_qgroundcontrol import item

LOSS = 0.1
RETRY_S = 1.5  # QGroundControl's acknowledgement time-out; items are read with 0.25 s
TRIES = 7


class BadRadio:
    """A desk whose messages get lost, one by one, in each direction."""

    def __init__(self, desk: Desk, seed: int, loss: float = LOSS) -> None:
        self.desk, self._random, self._loss = desk, random.Random(seed), loss

    def tell(self, *messages: Any) -> list[Any]:
        return self._through(self.desk.tell(*self._through(list(messages))))

    def tick(self) -> list[Any]:
        return self._through(self.desk.tick())

    def _through(self, messages: list[Any]) -> list[Any]:
        return [message for message in messages if self._random.random() >= self._loss]

    def ask(self, message: Any, wanted: Callable[[Any], bool], retry_s: float) -> Any:
        """Ask as a ground station does: again after `retry_s`, `TRIES` times."""
        for _ in range(TRIES):
            answers = self.tell(message)
            for _ in range(round(retry_s / self.desk.vessel.period_s)):
                for answer in answers:
                    if wanted(answer):
                        return answer
                answers = self.tick()
        raise AssertionError(f"no answer to {message.get_type()} in {TRIES} tries")


def upload(radio: BadRadio, items: list[Any]) -> None:
    """QGroundControl's side: an item only ever on request; silence of 1.5 s is a failure unless nothing was asked
    yet."""

    def asked(answer: Any) -> bool:
        return answer.get_type() in ("MISSION_REQUEST_INT", "MISSION_ACK")

    answer = radio.ask(mavlink.MAVLink_mission_count_message(1, 1, len(items), 0), asked, RETRY_S)
    silent_s = 0.0
    while answer.get_type() != "MISSION_ACK":
        answers = [a for a in radio.tell(items[answer.seq]) if asked(a)]
        while not answers:
            assert silent_s < RETRY_S, "silence of 1.5 s: QGroundControl gives up here"
            answers = [a for a in radio.tick() if asked(a)]
            silent_s += radio.desk.vessel.period_s
        answer, silent_s = answers[-1], 0.0
    assert answer.type == mavlink.MAV_MISSION_ACCEPTED


def download(radio: BadRadio) -> list[Any]:
    count = radio.ask(
        mavlink.MAVLink_mission_request_list_message(1, 1, 0), lambda a: a.get_type() == "MISSION_COUNT", RETRY_S
    ).count
    return [
        radio.ask(
            mavlink.MAVLink_mission_request_int_message(1, 1, seq, 0),
            lambda a, seq=seq: a.get_type() == "MISSION_ITEM_INT" and a.seq == seq,
            0.25,
        )
        for seq in range(count)
    ]


@pytest.mark.parametrize("seed", range(6))
def test_missions_and_parameters_get_through(tmp_path: Path, seed: int) -> None:
    desk = Desk(tmp_path)
    radio = BadRadio(desk, seed)
    desk.tick()
    items = [item(n, 16, 10.0 * n, 5.0 * (n % 2)) for n in range(40)]
    upload(radio, items)
    back = download(radio)
    assert [(i.seq, i.x, i.y, i.command) for i in back] == [(i.seq, i.x, i.y, i.command) for i in items]

    values = {v.param_index: v for v in of(radio.tell(mavlink.MAVLink_param_request_list_message(1, 0)), "PARAM_VALUE")}
    for _ in range(40):
        values |= {v.param_index: v for v in of(radio.tick(), "PARAM_VALUE")}
    values.pop(65535, None)  # their hash, which stands in no list
    for index in set(range(len(TABLE))) - set(values):
        answer = radio.ask(
            mavlink.MAVLink_param_request_read_message(1, 1, b"", index),
            lambda a, index=index: a.get_type() == "PARAM_VALUE" and a.param_index == index,
            1.0,
        )
        values[index] = answer
    assert {v.param_id for v in values.values()} == {spec.name for spec in TABLE}
    desk.close()


def test_a_second_station_neither_hears_nor_spoils_the_first_ones_transfer(tmp_path: Path) -> None:
    first = Desk(tmp_path)
    first.tick()
    second = Desk(tmp_path, rig=first.rig, system=254)
    items = [item(n, 16, 10.0 * n, 0.0) for n in range(5)]
    first.tell(mavlink.MAVLink_mission_count_message(1, 1, 5, 0))
    for n in range(4):
        first.tell(items[n])
        refused = second.tell(mavlink.MAVLink_mission_count_message(1, 1, 2, 0))
        assert [a.type for a in of(refused, "MISSION_ACK")] == [mavlink.MAV_MISSION_DENIED]
        assert all(
            m.target_system == 254
            for m in refused
            if hasattr(m, "target_system") and m.get_type().startswith("MISSION_")
        )
    done = of(first.tell(items[4]), "MISSION_ACK")
    assert [(a.type, a.target_system, a.target_component) for a in done] == [(mavlink.MAV_MISSION_ACCEPTED, 255, 190)]
    assert len(first.vessel.plans.items(PlanKind.MISSION)) == 5
    first.close()

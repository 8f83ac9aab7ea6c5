"""A plan that is checked beside the control thread and stored before it is answered."""

from __future__ import annotations

from typing import Any

import pytest

from companion.io.mavlink.transfer.mission_service import MissionService
from companion.io.mavlink.transfer.mission_upload import STORING_S
from companion.io.mavlink.wire import messages as mavlink
from companion.mission.plan import PlanItem, PlanKind, PlanResult
from tests.unit.io.mavlink.conftest import Desk
from tests.unit.io.mavlink.slow_storage import SlowStorage, SlowWorker
from tests.unit.io.mavlink.transfer.test_mission_service import item_int, waypoint

MISSION, FENCE, RALLY = PlanKind
COUNT, CLEAR = mavlink.MAVLink_mission_count_message, mavlink.MAVLink_mission_clear_all_message


class Slow:
    """A desk whose vessel stores and computes when it is told to."""

    def __init__(self, desk: Desk) -> None:
        self.desk, self.storage, self.worker = desk, SlowStorage(), SlowWorker()
        desk.plans.replace(MISSION, [waypoint(0)])
        desk.vessel.storage, desk.vessel.worker = self.storage, self.worker
        self.service = desk.serve(MissionService(desk.hub, desk.vessel))

    @property
    def seqs(self) -> list[int]:
        return [item.x for item in self.desk.plans.items(MISSION)]

    def upload(self, items: list[PlanItem], kind: int = 0, peer: str = "qgc") -> list[Any]:
        """All items, and what was heard after the last."""
        self.desk.tell(COUNT(1, 1, len(items), kind), self.desk.peer(peer))
        for item in items:
            self.desk.heard()
            self.desk.tell(item_int(item, kind), self.desk.peer(peer))
        return self.desk.replies()

    def advance(self) -> list[Any]:
        self.service.answer(self.desk.now_s)
        return self.desk.replies()


@pytest.fixture
def slow(desk: Desk) -> Slow:
    return Slow(desk)


def kinds(messages: list[Any]) -> list[str]:
    return [message.get_type() for message in messages]


def test_a_plan_is_answered_and_in_force_when_it_is_stored(slow: Slow) -> None:
    assert slow.upload([waypoint(0, x=7), waypoint(1)]) == []
    assert slow.advance() == [] and slow.storage.plans == [], "not checked yet"
    slow.worker.work()
    assert slow.advance() == [] and len(slow.storage.plans) == 1 and len(slow.seqs) == 1, "not stored yet"
    slow.storage.settle()
    (answer,) = slow.advance()
    assert answer.type == PlanResult.ACCEPTED and answer.opaque_id == slow.desk.plans.plan_id(MISSION)
    assert slow.seqs[0] == 7 and len(slow.seqs) == 2


def test_a_plan_that_is_wrong_as_a_whole_is_refused_after_the_check(slow: Slow) -> None:
    slow.upload([waypoint(0), waypoint(1, command=177, param1=9.0, param2=1.0)])
    slow.worker.work()
    (answer,) = slow.advance()
    assert answer.type == PlanResult.INVALID_PARAM1 and slow.storage.plans == [] and len(slow.seqs) == 1


@pytest.mark.parametrize(("full", "result"), [(True, PlanResult.NO_SPACE), (False, PlanResult.ERROR)])
def test_a_plan_that_cannot_be_stored_is_refused_and_the_old_one_stored_again(
    slow: Slow, full: bool, result: PlanResult
) -> None:
    old = slow.desk.plans.items(MISSION)
    slow.upload([waypoint(0, x=7)])
    slow.worker.work()
    slow.advance()
    slow.storage.fail("No space left on device", full)
    (answer,) = slow.advance()
    assert answer.type == result and slow.desk.plans.items(MISSION) == old
    assert slow.storage.plans[-1] == (MISSION, old), "another content may have reached the medium"
    (text,) = slow.desk.texts()
    assert text == "mission: not stored (No space left on device); the old one stays in force"


def test_the_client_is_kept_waiting_by_requests_for_the_last_item(slow: Slow) -> None:
    slow.upload([waypoint(0), waypoint(1)])
    slow.desk.wait(10.0 * STORING_S)
    requests = slow.desk.replies()
    assert kinds(requests) == ["MISSION_REQUEST_INT"] * 4 and {request.seq for request in requests} == {1}
    slow.desk.tell(item_int(waypoint(1)))
    assert slow.desk.replies() == [], "it is there already"
    slow.worker.work()
    slow.advance()
    slow.storage.settle()
    assert kinds(slow.advance()) == ["MISSION_ACK"]
    slow.desk.wait(5.0)
    assert slow.desk.replies() == [], "nothing was lost on the way, so the answer is sent once"


def test_a_client_that_falls_silent_after_its_last_item_has_its_plan(slow: Slow) -> None:
    slow.upload([waypoint(0, x=7)])
    slow.desk.wait(30.0)
    slow.worker.work()
    slow.advance()
    slow.desk.wait(30.0)
    slow.storage.settle()
    slow.advance()
    assert slow.seqs == [7]


def test_a_client_that_begins_anew_is_not_answered_for_the_first(slow: Slow) -> None:
    old = slow.desk.plans.items(MISSION)
    slow.upload([waypoint(0, x=7)])
    slow.worker.work()
    slow.advance()
    slow.desk.tell(COUNT(1, 1, 1, 0))
    assert slow.storage.plans[-1] == (MISSION, old), "what the first has stored is undone"
    slow.storage.settle()
    slow.desk.heard()
    assert slow.advance() == [] and slow.desk.plans.items(MISSION) == old
    slow.desk.tell(item_int(waypoint(0, x=8)))
    slow.worker.work()
    slow.advance()
    slow.storage.settle()
    assert kinds(slow.advance()) == ["MISSION_ACK"] and slow.seqs == [8]


def test_a_cancelled_upload_stays_without_effect(slow: Slow) -> None:
    slow.upload([waypoint(0, x=7)])
    slow.desk.tell(mavlink.MAVLink_mission_ack_message(1, 1, PlanResult.OPERATION_CANCELLED, 0))
    slow.worker.work()
    slow.storage.settle()
    assert slow.advance() == [] and len(slow.seqs) == 1 and slow.storage.plans == []


def test_a_client_that_asks_for_what_it_has_just_sent_gets_that(slow: Slow) -> None:
    """MAVProxy does, when somebody types quickly."""
    slow.upload([waypoint(0, x=7), waypoint(1)])
    slow.desk.tell(mavlink.MAVLink_mission_request_list_message(1, 1, 0))
    slow.worker.work()
    assert slow.advance() == []
    slow.storage.settle()
    answer, count = slow.advance()
    assert answer.type == PlanResult.ACCEPTED and slow.seqs[0] == 7
    assert count.get_type() == "MISSION_COUNT" and count.count == 2
    assert slow.advance() == []


def test_a_client_that_is_told_of_another_plan_meanwhile_does_not_lose_its_own(slow: Slow) -> None:
    slow.upload([waypoint(0, x=7)])
    slow.desk.wait(3.0)
    slow.desk.heard()
    slow.desk.tell(mavlink.MAVLink_mission_request_list_message(1, 1, 1))
    assert kinds(slow.desk.replies()) == ["MISSION_COUNT"]
    slow.worker.work()
    slow.advance()
    slow.storage.settle()
    assert kinds(slow.advance()) == ["MISSION_ACK"] and slow.seqs == [7]


def test_a_listing_that_waits_does_not_end_a_newer_upload(slow: Slow) -> None:
    slow.upload([waypoint(0, x=7)])
    slow.desk.tell(mavlink.MAVLink_mission_request_list_message(1, 1, 0))
    slow.desk.tell(COUNT(1, 1, 1, 0))
    slow.desk.heard()
    assert slow.advance() == []
    slow.desk.tell(item_int(waypoint(0, x=8)))
    slow.worker.work()
    slow.advance()
    slow.storage.settle()
    assert kinds(slow.advance()) == ["MISSION_ACK"] and slow.seqs == [8]


def test_another_client_waits_until_the_plan_is_stored(slow: Slow) -> None:
    slow.upload([waypoint(0, x=7)])
    slow.desk.tell(COUNT(1, 1, 1, 0), slow.desk.peer("other"))
    (answer,) = slow.desk.replies()
    assert answer.type == PlanResult.DENIED
    slow.desk.tell(CLEAR(1, 1, 255), slow.desk.peer("other"))
    (answer,) = slow.desk.replies()
    assert answer.type == PlanResult.DENIED and len(slow.seqs) == 1


def test_nor_does_one_who_left_before_his_plan_was_stored_make_room_meanwhile(slow: Slow) -> None:
    slow.upload([waypoint(0, x=7)], peer="other")
    slow.desk.peer("other").endpoint.gone = True
    slow.desk.tell(COUNT(1, 1, 2, 0))
    (answer,) = slow.desk.replies()
    assert answer.type == PlanResult.DENIED
    slow.worker.work()
    slow.advance()
    slow.storage.settle()
    slow.advance()
    assert slow.seqs == [7]
    assert kinds(slow.upload([waypoint(0, x=9)])) == [], "now there is room"
    slow.worker.work()
    slow.advance()
    slow.storage.settle()
    assert kinds(slow.advance()) == ["MISSION_ACK"] and slow.seqs == [9]


@pytest.mark.parametrize("then", ["an upload", "a clearing"])
def test_a_clearing_that_another_change_overtakes_is_answered_all_the_same(slow: Slow, then: str) -> None:
    slow.desk.tell(CLEAR(1, 1, 0), slow.desk.peer("other"))
    slow.worker.work()
    slow.service.answer(slow.desk.now_s)
    if then == "an upload":
        slow.desk.tell(COUNT(1, 1, 1, 0))
        slow.desk.tell(item_int(waypoint(0, x=9)))
    else:
        slow.desk.tell(CLEAR(1, 1, 0))
    slow.worker.work()
    slow.service.answer(slow.desk.now_s)
    slow.storage.settle()
    slow.service.answer(slow.desk.now_s)
    assert [(to, m.type) for to, m in slow.desk.heard() if m.get_type() == "MISSION_ACK"] == [
        (slow.desk.peer("other"), PlanResult.ERROR),
        (slow.desk.peer("qgc"), PlanResult.ACCEPTED),
    ]
    assert slow.seqs == ([9] if then == "an upload" else [])


def test_clearing_everything_is_answered_once_all_is_stored(slow: Slow) -> None:
    slow.desk.plans.replace(RALLY, [waypoint(0, command=5100)])
    slow.desk.tell(CLEAR(1, 1, 255))
    slow.worker.work()
    slow.advance()
    assert sorted(slow.storage.plans) == [(MISSION, ()), (RALLY, ())], "there is no fence"
    slow.storage.tickets[0].state = slow.storage.tickets[0].state.DURABLE
    assert slow.advance() == []
    slow.storage.settle()
    (answer,) = slow.advance()
    assert answer.type == PlanResult.ACCEPTED and answer.mission_type == 255
    assert slow.desk.plans.items(MISSION) == slow.desk.plans.items(RALLY) == ()


def test_a_plan_that_cannot_be_cleared_stays(slow: Slow) -> None:
    for message in (CLEAR(1, 1, 0), COUNT(1, 1, 0, 0)):
        slow.desk.tell(message)
        slow.worker.work()
        slow.advance()
        slow.storage.fail()
        (answer,) = slow.advance()
        assert answer.type == PlanResult.NO_SPACE and len(slow.seqs) == 1
    assert [text.partition(": ")[0] for text in slow.desk.texts()] == ["plan not cleared", "mission"]


def test_clearing_what_is_empty_needs_no_medium(slow: Slow) -> None:
    for message in (CLEAR(1, 1, 1), COUNT(1, 1, 0, 1)):
        slow.desk.tell(message)
        (answer,) = slow.desk.replies()
        assert answer.type == PlanResult.ACCEPTED and slow.storage.plans == []


def test_a_partial_upload_of_a_plan_that_has_changed_meanwhile_is_refused(slow: Slow) -> None:
    slow.desk.tell(mavlink.MAVLink_mission_write_partial_list_message(1, 1, 0, 0, 0))
    slow.desk.tell(item_int(waypoint(0, x=7)))
    slow.desk.plans.replace(MISSION, [waypoint(0, x=5)])
    slow.worker.work()
    slow.desk.heard()
    (answer,) = slow.advance()
    assert answer.type == PlanResult.ERROR and slow.seqs == [5]


def test_a_check_that_fails_is_a_refusal(slow: Slow) -> None:
    def prepare(items: Any) -> Any:
        def work() -> Any:
            raise MemoryError("too large")

        return work

    slow.desk.plans.prepare_by(MISSION, prepare)
    slow.upload([waypoint(0, x=7)])
    slow.worker.work()
    (answer,) = slow.advance()
    assert answer.type == PlanResult.ERROR and len(slow.seqs) == 1


def test_what_was_prepared_comes_into_force_with_the_plan(slow: Slow) -> None:
    done: list[str] = []
    slow.desk.plans.on_change(lambda kind: done.append("in force"))
    slow.desk.plans.prepare_by(
        MISSION,
        lambda items: lambda: done.append("worked") or (lambda: done.append("adopted")),  # type: ignore[func-returns-value]
    )
    slow.upload([waypoint(0, x=7)])
    slow.worker.work()
    slow.advance()
    assert done == ["worked"]
    slow.storage.settle()
    slow.advance()
    assert done == ["worked", "adopted", "in force"]

"""The medium stalls while parameters and a mission come in: no tick waits for it, and nothing is acknowledged early."""

from __future__ import annotations

import errno
import json
import os
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from companion.io.mavlink.wire import messages as mavlink
from companion.mission.plan import PlanKind
from tests.afloat_beside import BoatBeside
from tests.faulty_disk import FaultyDisk
from tests.protocol.desk import Desk, of
from tests.waiting import wait_until

VALUES = {
    "WP_SPEED": 0.7,
    "NAV_ACC_RAD": 3.5,
    "FOLL_LOSS_T": 9.5,
    "FENCE_MARGIN": 2.5,
    "CIRC_RADIUS": 7.5,
    "CIRC_SPEED": 0.45,
}
ITEMS = 20
ACCEPTED, NO_SPACE = 0, 4


class Touches:
    """Which threads have called the medium, by the calls that may wait for it."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.threads: dict[str, set[str]] = {}
        for name in ("fsync", "fdatasync", "replace", "rename", "mkdir", "unlink"):
            monkeypatch.setattr(os, name, self._noted(name, getattr(os, name)))

    def _noted(self, name: str, call: Any) -> Any:
        def noted(*arguments: Any, **more: Any) -> Any:
            self.threads.setdefault(name, set()).add(threading.current_thread().name)
            return call(*arguments, **more)

        return noted


@pytest.fixture
def disk() -> FaultyDisk:
    return FaultyDisk()


@pytest.fixture
def desk(tmp_path: Path, disk: FaultyDisk) -> Iterator[Desk]:
    made = Desk(tmp_path, BoatBeside(tmp_path, disk))  # type: ignore[arg-type]
    made.heartbeat()
    made.tick(5)
    yield made
    disk.go_on()
    disk.fail_with(None)
    made.close()


def parameter(name: str, value: float) -> Any:
    return mavlink.MAVLink_param_set_message(1, 1, name.encode(), value, 9)


def item(seq: int) -> Any:
    x, y = 634389000 + 100 * seq, 103990000
    return mavlink.MAVLink_mission_item_int_message(1, 1, seq, 6, 16, 0, 1, 0.0, 0.0, 0.0, float("nan"), x, y, 0.0)


def upload_all(desk: Desk) -> None:
    """Up to the last item; the answer is still to come."""
    requests = of(desk.tell(mavlink.MAVLink_mission_count_message(1, 1, ITEMS, 0)), "MISSION_REQUEST_INT")
    for seq in range(ITEMS):
        assert [request.seq for request in requests] == [seq]
        requests = of(desk.tell(item(seq)), "MISSION_REQUEST_INT")


def set_all(desk: Desk) -> None:
    desk.tell(*(parameter(name, value) for name, value in VALUES.items()))


def acknowledged(desk: Desk) -> set[str]:
    return {message.param_id for message in of(desk.received, "PARAM_VALUE")}


def wait_for(desk: Desk, what: str, condition: Any) -> None:
    """Serve between ticks until it holds; the messages are kept in `desk.received`."""

    def heard() -> bool:
        desk.tell()
        return bool(condition())

    wait_until(heard, what)


def stored(folder: Path, name: str) -> Any:
    """What a run that began now would find: after a power cut, too."""
    return json.loads((folder / "state" / name).read_text(encoding="utf-8"))


def stored_parameters(folder: Path) -> dict[str, float]:
    return {name: value for name, value in stored(folder, "parameters.json")["parameters"].items() if name in VALUES}


def stored_items(folder: Path) -> int:
    return len(stored(folder, "mission.json")["items"])


@pytest.mark.parametrize("stall_s", [0.3, 2.0])
def test_no_tick_waits_and_nothing_is_acknowledged_before_it_is_stored(
    desk: Desk, disk: FaultyDisk, stall_s: float, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    disk.stall()
    desk.tick()
    disk.wait_for_stall()  # the log's thread
    touches = Touches(monkeypatch)
    set_all(desk)
    upload_all(desk)
    before = desk.vessel.last_tick
    ticks = round(stall_s / desk.vessel.period_s)
    desk.tick(ticks)  # returns at all only because no tick waits: the medium does not answer before `go_on`
    assert before is not None and desk.vessel.last_tick is not None
    assert desk.vessel.last_tick.t_s - before.t_s == pytest.approx(stall_s)
    assert all(desk.vessel.parameters[name] == pytest.approx(value) for name, value in VALUES.items()), "in force"
    assert acknowledged(desk) == set() and of(desk.received, "MISSION_ACK") == []
    assert desk.vessel.plans.items(PlanKind.MISSION) == (), "the old plan, until the new one is stored"
    disk.go_on()
    wait_for(desk, "all acknowledged", lambda: acknowledged(desk) >= set(VALUES) and of(desk.received, "MISSION_ACK"))
    assert [ack.type for ack in of(desk.received, "MISSION_ACK")] == [ACCEPTED]
    assert "MainThread" not in set().union(*touches.threads.values()), touches.threads
    assert touches.threads["fsync"] == {"state-writer"}
    assert stored_parameters(tmp_path) == pytest.approx(VALUES) and stored_items(tmp_path) == ITEMS


def test_a_full_medium_is_told_and_all_is_stored_when_there_is_space(
    desk: Desk, disk: FaultyDisk, tmp_path: Path
) -> None:
    disk.fail_with(errno.ENOSPC)
    set_all(desk)
    wait_for(desk, "refusals", lambda: len(of(desk.received, "PARAM_ERROR")) == len(VALUES))
    assert acknowledged(desk) == set()
    upload_all(desk)
    wait_for(desk, "refusal of the mission", lambda: of(desk.received, "MISSION_ACK"))
    assert [ack.type for ack in of(desk.received, "MISSION_ACK")] == [NO_SPACE]
    assert desk.vessel.plans.items(PlanKind.MISSION) == ()
    desk.tick(2)
    assert desk.vessel.last_tick is not None
    (health,) = [one for one in desk.vessel.last_tick.health if one.name == "storage"]
    assert not health.ok and "parameters.json not saved: No space left on device" in health.text
    disk.fail_with(None)
    wait_for(desk, "the values stored after all", lambda: acknowledged(desk) >= set(VALUES))
    assert stored_parameters(tmp_path) == pytest.approx(VALUES)

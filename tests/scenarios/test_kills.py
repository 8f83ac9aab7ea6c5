"""The process is killed at random instants, over every kind of write, while the medium is full for a while and has
space again: what was acknowledged is there afterwards, and every file can be read.

The boat runs in a child of this process, with a ground station of its own. What the station sees acknowledged goes
through a pipe, which outlives the child.
"""

from __future__ import annotations

import csv
import errno
import json
import os
import random
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.stream_memory import SharedStreamMemory
from companion.mission.plan import PlanKind
from companion.record.signing_file import read_signing
from companion.record.state_file import StateFile
from tests.afloat_beside import BoatBeside
from tests.faulty_disk import FaultyDisk
from tests.protocol.desk import Desk
from tests.scenarios.seeds import seeds

KILLS = 1000
NAMES = ("WP_SPEED", "NAV_ACC_RAD", "FOLL_LOSS_T", "FENCE_MARGIN", "CIRC_RADIUS")
LEAST = {"WP_SPEED": 0.5, "NAV_ACC_RAD": 2.0, "FOLL_LOSS_T": 1.0, "FENCE_MARGIN": 1.0, "CIRC_RADIUS": 5.0}
LATEST_S = 1.0  # after the first request
MISSION, FENCE, RALLY = (int(kind) for kind in PlanKind)


def item(kind: int, seq: int, salt: int) -> Any:
    """An item of a plan that the number `salt` marks."""
    command = {MISSION: 16, FENCE: 5001, RALLY: 5100}[kind]
    corner = ((0, 0), (0, 9000), (9000, 9000), (9000, 0))[seq % 4] if kind == FENCE else (1000 * seq, 0)
    x, y = 634_390_000 + corner[0] + salt, 103_990_000 + corner[1]
    first = 4.0 if kind == FENCE else 0.0
    return mavlink.MAVLink_mission_item_int_message(1, 1, seq, 3, command, 0, 1, first, 0, 0, 0, x, y, 0, kind)


class Station:
    """The ground station in the child: asks at random, and writes what it asks and what is acknowledged."""

    def __init__(self, folder: Path, seed: int, out: int) -> None:
        self._disk, self._draws, self._out = FaultyDisk(), random.Random(seed), out
        boat: Any = BoatBeside(folder, self._disk, link="memory:desk?trusted=yes")
        self._desk = Desk(folder, boat)
        self._salt = 0
        self._uploads: dict[int, int] = {}  # kind → salt

    def run(self) -> None:
        """Until somebody kills the process."""
        self._desk.heartbeat()
        self._desk.tick()
        os.write(self._out, b'["ready"]\n')
        while True:
            self._salt += 1
            self._draws.choice((self._set, self._set, self._plan, self._plan, self._current, self._key, self._full))()
            for _ in range(self._draws.randrange(1, 4)):
                self._hear(self._desk.tick())
            time.sleep(0.002)  # the writer's thread gets its turn

    def _say(self, *row: Any) -> None:
        os.write(self._out, json.dumps(row).encode() + b"\n")

    def _set(self) -> None:
        name = self._draws.choice(NAMES)
        value = LEAST[name] + self._salt / 1024.0
        self._say("asked", name, value)
        self._hear(self._desk.tell(mavlink.MAVLink_param_set_message(1, 1, name.encode(), value, 9)))

    def _plan(self) -> None:
        kind = self._draws.choice((MISSION, FENCE, RALLY))
        self._uploads[kind] = self._salt
        self._say("asked", kind, self._salt)
        self._hear(self._desk.tell(mavlink.MAVLink_mission_count_message(1, 1, 4, kind)))

    def _current(self) -> None:
        self._hear(self._desk.tell(mavlink.MAVLink_mission_set_current_message(1, 1, self._draws.randrange(4))))

    def _key(self) -> None:
        key = [self._draws.randrange(256) for _ in range(32)]
        self._desk.tell(mavlink.MAVLink_setup_signing_message(1, 1, key, 0))

    def _full(self) -> None:
        self._disk.fail_with(errno.ENOSPC if self._draws.random() < 0.5 else None)

    def _hear(self, messages: list[Any]) -> None:
        for message in messages:
            match message.get_type():
                case "PARAM_VALUE" if message.param_id in NAMES:
                    self._say("acknowledged", message.param_id, message.param_value)
                case "MISSION_REQUEST_INT" if message.mission_type in self._uploads:
                    kind = message.mission_type
                    self._hear(self._desk.tell(item(kind, message.seq, self._uploads[kind])))
                case "MISSION_ACK" if message.type == mavlink.MAV_MISSION_ACCEPTED:
                    self._say("acknowledged", message.mission_type, self._uploads.get(message.mission_type))


def killed(folder: Path, seed: int) -> list[list[Any]]:
    """A run that is killed at a random instant; what its station wrote."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(reading)
            silent = os.open(os.devnull, os.O_WRONLY)
            os.dup2(silent, 1)
            os.dup2(silent, 2)
            Station(folder, seed, writing).run()
        finally:
            os.kill(os.getpid(), signal.SIGABRT)  # an error of the child ends it before it is killed
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        rows = [json.loads(pipe.readline() or b'["failed"]')]
        time.sleep(random.Random(seed).uniform(0.0, LATEST_S))
        os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
        rows += [json.loads(line) for line in pipe if line.endswith(b"\n")]
    SharedStreamMemory(folder / "state").path.unlink(missing_ok=True)
    ended_by = os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
    assert ended_by == signal.SIGKILL and rows[0] == ["ready"], "the child ended by itself"
    return rows


def stored(folder: Path) -> Iterator[tuple[str | int, float]]:
    """What the next run finds. There must be nothing to warn of."""
    state = StateFile(folder / "state")
    try:
        parameters, warnings = state.load_parameters()
        plans, more = state.load_plans()
        _, yet_more = state.load_progress()
        assert not warnings and not more and not yet_more
        yield from parameters.items()
        for kind, items in plans.items():
            if items:
                salts = {one.x - item(int(kind), one.seq, 0).x for one in items}
                assert len(salts) == 1 and len(items) == 4, "a plan is whole or not there"
                yield int(kind), salts.pop()
    finally:
        state.close()
    read_signing(folder / "state")


def lost(rows: list[list[Any]], found: dict[str | int, float]) -> list[str]:
    """What was acknowledged, and neither that nor anything asked for later is stored."""
    asked: dict[Any, list[float]] = {}
    least: dict[Any, int] = {}
    for what, *rest in rows:
        if what == "asked":
            asked.setdefault(rest[0], []).append(rest[1])
        elif what == "acknowledged" and rest[1] in asked.get(rest[0], ()):
            least[rest[0]] = asked[rest[0]].index(rest[1])
    return [
        f"{key}: {asked[key][place]} acknowledged, {found.get(key)} stored"
        for key, place in least.items()
        if found.get(key) not in asked[key][place:]
    ]


def check_log(folder: Path) -> None:
    """Rows are whole, but for the last."""
    for path in (folder / "logs").rglob("*.csv"):
        lines = path.read_text(encoding="utf-8").split("\n")[:-1]
        if not lines:
            continue
        widths = {len(row) for row in csv.reader(lines)}
        assert len(widths) <= 1 or path.name == "readings.csv", path


@pytest.mark.parametrize("seed", seeds(2, KILLS))
def test_what_was_acknowledged_is_there_after_a_kill(tmp_path: Path, seed: int) -> None:
    """Three runs on the same files, each killed."""
    rows: list[list[Any]] = []
    for life in range(3 if seed % 10 == 9 else 1):
        rows += killed(tmp_path, seed + 100_000 * life)
    assert not lost(rows, dict(stored(tmp_path)))
    check_log(tmp_path)


def test_a_loss_would_be_seen() -> None:
    rows = [["asked", "A", 1.0], ["acknowledged", "A", 1.0], ["asked", "A", 2.0]]
    assert not lost(rows, {"A": 1.0}) and not lost(rows, {"A": 2.0})
    assert lost(rows, {"A": 0.5}) and lost(rows, {})

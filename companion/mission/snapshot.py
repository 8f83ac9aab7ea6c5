"""Place and state of a mission as JSON values, which survive a restart."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from companion.core.decision import MissionState
from companion.mission.cursor import Cursor
from companion.mission.plan import item_number


class SnapshotError(ValueError):
    """The values are not a valid snapshot."""


@dataclass(frozen=True, slots=True)
class MissionSnapshot:
    """Place and state of the executor: as `Cursor` and `MissionProgress` hold them."""

    state: MissionState
    seq: int
    arrived: bool
    jumps: dict[int, int]
    speed_mps: float | None
    reached: int
    reached_seq: int | None
    held: tuple[int, ...] = ()


def write_snapshot(
    plan_id: int, state: MissionState, cursor: Cursor, arrived: bool, reached: tuple[int, int | None]
) -> dict[str, Any]:
    """The snapshot as JSON values. `reached`: (number of items reached, the last of them)."""
    return {
        "plan_id": plan_id,
        "state": int(state),
        "seq": cursor.seq,
        "arrived": arrived,
        "jumps": {str(seq): taken for seq, taken in cursor.jumps.items()},
        "speed_mps": cursor.speed_mps,
        "reached": reached[0],
        "reached_seq": reached[1],
        "held": list(cursor.held),
    }


def read_snapshot(values: Mapping[str, Any], count: int) -> MissionSnapshot:
    """The snapshot in `values`, for a mission of `count` items; the caller checks that it is the same mission. Raises
    SnapshotError for a value that is missing, of the wrong type or out of range."""
    try:
        state = MissionState(values["state"])
        seq, reached = _whole(values["seq"]), _whole(values["reached"])
        jumps = {_whole(int(key)): _whole(taken) for key, taken in values["jumps"].items()}
        speed_mps = None if values["speed_mps"] is None else _speed(values["speed_mps"])
        reached_seq = None if values["reached_seq"] is None else _whole(values["reached_seq"])
        arrived = bool(values["arrived"])
        held = tuple(_whole(seq) for seq in values.get("held", ()))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise SnapshotError(f"it cannot be read ({error})") from error
    furthest = count if state is MissionState.COMPLETE else count - 1
    if seq > max(0, furthest) or (state is MissionState.NO_MISSION) != (count == 0):
        raise SnapshotError(f"item {item_number(seq)} in state {state.name} does not fit a mission of {count} items")
    if any(seq >= count for seq in held):
        raise SnapshotError(f"items held back that a mission of {count} items does not have")
    return MissionSnapshot(state, seq, arrived, jumps, speed_mps, reached, reached_seq, held)


def _speed(value: Any) -> float:
    speed_mps = float(value)
    if not 0.0 < speed_mps < math.inf:
        raise ValueError(f"{value!r} is no speed")
    return speed_mps


def _whole(value: Any) -> int:
    if not isinstance(value, int) or value < 0:
        raise ValueError(f"{value!r} is no count")
    return value

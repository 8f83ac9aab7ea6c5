"""The mission protocol: upload, download and clearing of plans, and the choice of the current item.

A client may download any item in any order at any time, from the plan as it was when the client asked for its length.
Source: MAVLink guide, "Mission Protocol".
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from companion.core.decision import Home, TextKind
from companion.io.mavlink.transfer.mission_codec import home_item, item_message, with_jump_moved
from companion.io.mavlink.transfer.mission_upload import PlanReceiver, shift_of
from companion.io.mavlink.transfer.plan_store import PlanStore
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.hub import Handler, Hub, Peer
from companion.loop import Vessel
from companion.mission.plan import PlanItem, PlanKind, PlanRefusal, PlanResult

SNAPSHOT_S = 15.0
_MOST_SNAPSHOTS = 64
_ALL_KINDS = 255
_KINDS = {int(kind): kind for kind in PlanKind}


@dataclass(slots=True)
class _Snapshot:
    """The plan that a client is reading, and home, as they were when it began."""

    items: tuple[PlanItem, ...]
    plan_id: int
    home: Home | None
    used_s: float


@dataclass(slots=True)
class _Clearing:
    """A clearing that is being stored: who asked for it, and as what, and which kinds are left."""

    peer: Peer
    asked: int
    left: set[PlanKind]
    refusal: PlanRefusal | None = None


class MissionService:
    """Answers the messages of the mission protocol; sends MISSION_CURRENT to all when the item or a plan changes.

    Remembers the uploads (see PlanReceiver), the clearings and, for each client and kind of plan, the plan that it is
    reading.
    """

    def __init__(self, hub: Hub, vessel: Vessel) -> None:
        self._hub = hub
        self._vessel = vessel
        self._store = PlanStore(vessel)
        self._receiver = PlanReceiver(hub, vessel, self._store, self._announce_current)
        self._clearings: dict[PlanKind, _Clearing] = {}
        self._snapshots: dict[tuple[Peer, PlanKind], _Snapshot] = {}
        self._listings: set[tuple[Peer, PlanKind]] = set()  # asked for while that client's plan is being stored
        self.handles: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_MISSION_COUNT: self._on_count,
            mavlink.MAVLINK_MSG_ID_MISSION_WRITE_PARTIAL_LIST: self._on_write_partial_list,
            mavlink.MAVLINK_MSG_ID_MISSION_ITEM_INT: self._receiver.on_item_int,
            mavlink.MAVLINK_MSG_ID_MISSION_ITEM: self._receiver.on_item,
            mavlink.MAVLINK_MSG_ID_MISSION_ACK: self._on_ack,
            mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_LIST: self._on_request_list,
            mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_PARTIAL_LIST: self._on_request_partial_list,
            mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_INT: self._on_request_int,
            mavlink.MAVLINK_MSG_ID_MISSION_REQUEST: self._on_request,
            mavlink.MAVLINK_MSG_ID_MISSION_CLEAR_ALL: self._on_clear_all,
            mavlink.MAVLINK_MSG_ID_MISSION_SET_CURRENT: self._on_set_current,
        }

    def update(self, now_s: float) -> None:
        """Retries and timeouts."""
        self.answer(now_s)
        self._receiver.update(now_s)
        for key in [
            key
            for key, snapshot in self._snapshots.items()
            if now_s - snapshot.used_s > SNAPSHOT_S * self._hub.patience
        ]:
            del self._snapshots[key]

    def answer(self, now_s: float) -> None:
        """Go on with plans that are being checked and stored."""
        self._store.advance(now_s)
        self._edit(now_s)
        for peer, kind in [(peer, kind) for peer, kind in self._listings if not self._receiver.is_storing(kind, peer)]:
            self._listings.discard((peer, kind))
            self._send_count(kind, peer, now_s)

    def _edit(self, now_s: float) -> None:
        """Store what the transmitter changes in the mission, once nobody else's plan is being stored."""
        edits = self._vessel.supervisor.mission_edits
        if self._store.busy(PlanKind.MISSION) or (items := edits.due()) is None:
            return

        def settled(refusal: PlanRefusal | None, then_s: float) -> None:
            edits.settled(refusal, then_s)
            self._announce_current(then_s)

        base = self._vessel.plans.items(PlanKind.MISSION)
        self._store.put(PlanKind.MISSION, items, settled, now_s, base)

    # --- upload ----------------------------------------------------------------------------------------------------

    def _on_count(self, message: Any, peer: Peer, now_s: float) -> None:
        kind = self._kind(message.mission_type, peer)
        if kind is not None:
            self._forget(peer, kind)
            self._receiver.on_count(kind, message.count, peer, now_s)

    def _forget(self, peer: Peer, kind: PlanKind) -> None:
        """The client begins something new with that plan. It waits for no answer to its clearing any more: one that
        came now would seem to be that of the upload, which many programs begin at once."""
        self._snapshots.pop((peer, kind), None)
        self._listings.discard((peer, kind))
        clearing = self._clearings.get(kind)
        if clearing is not None and clearing.peer == peer:
            del self._clearings[kind]
            clearing.left.discard(kind)
            self._store.drop(kind)

    def _on_write_partial_list(self, message: Any, peer: Peer, now_s: float) -> None:
        kind = self._kind(message.mission_type, peer)
        if kind is not None:
            self._forget(peer, kind)
            self._receiver.on_partial(kind, message.start_index, message.end_index, peer, now_s)

    def _on_ack(self, message: Any, peer: Peer, now_s: float) -> None:
        kind = _KINDS.get(message.mission_type)
        if kind is not None:
            self._snapshots.pop((peer, kind), None)
            self._receiver.on_client_ack(message, peer, now_s)

    # --- download --------------------------------------------------------------------------------------------------

    def _on_request_list(self, message: Any, peer: Peer, now_s: float) -> None:
        kind = self._kind(message.mission_type, peer)
        if kind is None:
            return
        if self._receiver.is_storing(kind, peer):  # MAVProxy asks at once for what it has just sent
            self._listings.add((peer, kind))
            return
        self._receiver.end_uploads(kind, peer, now_s)
        self._send_count(kind, peer, now_s)

    def _send_count(self, kind: PlanKind, peer: Peer, now_s: float) -> None:
        """Begin a download."""
        snapshot = self._snapshot_now(kind, peer, now_s)
        self._snapshots.pop((peer, kind), None)
        if len(self._snapshots) >= _MOST_SNAPSHOTS:
            del self._snapshots[next(iter(self._snapshots))]
        self._snapshots[peer, kind] = snapshot
        count = len(snapshot.items) + shift_of(kind, peer) if snapshot.items else 0
        self._hub.send(
            peer, mavlink.MAVLink_mission_count_message(peer.system, peer.component, count, kind, snapshot.plan_id)
        )

    def _on_request_int(self, message: Any, peer: Peer, now_s: float) -> None:
        self._send_item(message, peer, now_s, as_float=False)

    def _on_request(self, message: Any, peer: Peer, now_s: float) -> None:
        """MISSION_REQUEST, the old form, is answered with MISSION_ITEM, the old form."""
        self._send_item(message, peer, now_s, as_float=True)

    def _on_request_partial_list(self, message: Any, peer: Peer, now_s: float) -> None:
        self._receiver.acknowledge(message.mission_type, peer, PlanResult.UNSUPPORTED)

    def _send_item(self, message: Any, peer: Peer, now_s: float, as_float: bool) -> None:
        """Answer a request for one item."""
        kind = self._kind(message.mission_type, peer)
        if kind is None:
            return
        snapshot = self._snapshots.get((peer, kind)) or self._snapshot_now(kind, peer, now_s)
        snapshot.used_s = now_s
        shift = shift_of(kind, peer)
        seq = message.seq - shift
        if not -shift <= seq < len(snapshot.items):  # home can be read without a mission too: DroneKit does so
            self._receiver.acknowledge(kind, peer, PlanResult.INVALID_SEQUENCE)
            return
        item = home_item(snapshot.home) if seq < 0 else with_jump_moved(snapshot.items[seq], shift)
        self._hub.send(peer, item_message(item, message.seq, peer.system, peer.component, kind, as_float))

    def _snapshot_now(self, kind: PlanKind, peer: Peer, now_s: float) -> _Snapshot:
        plans = self._vessel.plans
        home = self._vessel.supervisor.status(now_s).home if shift_of(kind, peer) else None
        return _Snapshot(plans.items(kind), plans.plan_id(kind), home, now_s)

    # --- clear, current --------------------------------------------------------------------------------------------

    def _on_clear_all(self, message: Any, peer: Peer, now_s: float) -> None:
        asked = message.mission_type
        kind = None if asked == _ALL_KINDS else self._kind(asked, peer)
        if kind is None and asked != _ALL_KINDS:
            return
        kinds = tuple(PlanKind) if kind is None else (kind,)
        if all(one in self._clearings and self._clearings[one].peer == peer for one in kinds):
            return  # it asks again
        if not all(self._receiver.claim(one, peer, now_s) for one in kinds):
            self._receiver.acknowledge(asked, peer, PlanResult.DENIED)
            return
        for one in kinds:
            self._forget(peer, one)
            self._receiver.end_uploads(one, peer, now_s)
        clearing = _Clearing(peer, asked, set(kinds))
        for one in kinds:
            self._clear(clearing, one, now_s)

    def _clear(self, clearing: _Clearing, kind: PlanKind, now_s: float) -> None:
        """Empty one plan; answer once all of that clearing are empty, with a refusal if any of them stays."""

        def cleared(refusal: PlanRefusal | None, then_s: float) -> None:
            if self._clearings.get(kind) is clearing:
                del self._clearings[kind]
            clearing.left.discard(kind)
            clearing.refusal = clearing.refusal or refusal
            if not clearing.left:
                self._answer_clearing(clearing, then_s)

        self._clearings[kind] = clearing
        self._store.put(kind, (), cleared, now_s)

    def _answer_clearing(self, clearing: _Clearing, now_s: float) -> None:
        refusal = clearing.refusal
        if refusal is not None:
            text = f"plan not cleared: {refusal.text}"
            self._vessel.events.say(now_s, TextKind.REFUSAL, "plan_refused", text)
        result = PlanResult.ACCEPTED if refusal is None else refusal.result
        self._receiver.acknowledge(clearing.asked, clearing.peer, result)
        self._announce_current(now_s)

    def _on_set_current(self, message: Any, peer: Peer, now_s: float) -> None:
        seq = max(message.seq - shift_of(PlanKind.MISSION, peer), 0)
        if self._vessel.supervisor.set_current(seq, False, now_s).accepted:  # else the supervisor announces why
            self._announce_current(now_s)

    def _announce_current(self, now_s: float) -> None:
        self._hub.announce(now_s, mavlink.MAVLINK_MSG_ID_MISSION_CURRENT)

    def _kind(self, mission_type: int, peer: Peer) -> PlanKind | None:
        """The kind of plan; None, after a refusal, for an unknown type."""
        kind = _KINDS.get(mission_type)
        if kind is None:
            self._receiver.acknowledge(mission_type, peer, PlanResult.UNSUPPORTED)
        return kind

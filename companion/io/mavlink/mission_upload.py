"""Plans coming in: the vessel asks for one item after the other, and puts the list in force whole or not at all.

Source: MAVLink guide, "Mission Protocol"; timings chosen so that QGroundControl (gives up after 1.5 s without a request) and MAVSDK
(2.5 s) both live with loss.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from companion.core.types import Severity
from companion.io.mavlink import messages as mavlink
from companion.io.mavlink.hub import Hub, Peer
from companion.io.mavlink.mission_codec import item_from_float, item_from_int, with_jump_moved
from companion.io.mavlink.vessel import VesselFace
from companion.mission.plan import PlanItem, PlanKind, PlanRefusal, PlanResult
from companion.mission.validation import CAPACITY, check_item, check_plan

RETRY_S = 0.25
LATER_RETRY_S = 0.5  # after `_QUICK_RETRIES`: MAVSDK gives up at the sixth request for one item
GIVE_UP_S = 5.0
LEFT_LYING_S = 1.0
REPEAT_ANSWER_S = 5.0  # how long the last item of a finished upload still gets its answer again
UNASKED_REPEATS_S = (0.5, 1.0)  # over a link that has lost packets the last answer is sent again: QGroundControl never asks for it

_QUICK_RETRIES = 4
_LEGACY_GUIDED = (2, 3)  # values of `current` that once meant "go there now"


@dataclass(slots=True)
class _Upload:
    """One transfer. Numbers are those on the wire, which run `shift` ahead of the list where item 0 is home."""

    peer: Peer
    kind: PlanKind
    shift: int
    expected: int
    end: int
    heard_s: float
    retry_s: float = 0.0
    retries: int = 0
    lossy: bool = False  # something had to be asked for again
    base: tuple[PlanItem, ...] | None = None  # the list that a partial upload changes
    items: list[PlanItem] = field(default_factory=list)


@dataclass(slots=True)
class _Finished:
    """How a transfer ended, for a sender that missed the answer; `repeats_s`: when it is sent again unasked."""

    last_seq: int
    answer: Any
    until_s: float
    repeats_s: list[float] = field(default_factory=list)


class PlanReceiver:
    """In: MISSION_COUNT, MISSION_WRITE_PARTIAL_LIST, MISSION_ITEM_INT, MISSION_ITEM, the client's MISSION_ACK.

    Out: requests, refusals and the final MISSION_ACK to the sender alone; `vessel.plans` changed, whole, and `on_commit(now_s)` after
    that answer. Remembers one transfer per kind of plan, and for 5 s how the last one of each sender ended.
    """

    def __init__(self, hub: Hub, vessel: VesselFace, on_commit: Callable[[float], None]) -> None:
        self._hub = hub
        self._vessel = vessel
        self._on_commit = on_commit
        self._patience = hub.patience
        self._uploads: dict[int, _Upload] = {}  # by the number of the kind, as it stands in messages
        self._finished: dict[tuple[Peer, int], _Finished] = {}

    # --- what comes in ---------------------------------------------------------------------------------------------

    def on_count(self, kind: PlanKind, count: int, peer: Peer, now_s: float) -> None:
        """Start of an upload; again from the same sender: from the start."""
        if self.busy_with_another(kind, peer):
            self._deny(kind, peer, now_s)
            return
        self.end_uploads(kind, peer, now_s)
        self._finished.pop((peer, kind), None)
        shift = shift_of(kind, peer)
        if count > CAPACITY + shift:
            text = f"{count - shift} items, and there is room for {CAPACITY}"
            self._refuse(kind, peer, PlanRefusal(PlanResult.NO_SPACE, text), shift, now_s)
        elif count == 0:
            self.clear(kind)
            self.acknowledge(kind, peer, PlanResult.ACCEPTED)
            self._on_commit(now_s)
        else:
            self._start(_Upload(peer, kind, shift, 0, count, now_s), now_s)

    def on_partial(self, kind: PlanKind, first: int, last: int, peer: Peer, now_s: float) -> None:
        """Some items of the list in force to be changed; `last` may lie past the end, as MAVProxy sends it."""
        if self.busy_with_another(kind, peer):
            self._deny(kind, peer, now_s)
            return
        self.end_uploads(kind, peer, now_s)
        shift = shift_of(kind, peer)
        base = self._vessel.plans.items(kind)
        count = len(base) + shift
        if not base or first < 0 or first >= count or last < first:
            refusal = PlanRefusal(PlanResult.INVALID_SEQUENCE, f"items {first} to {last} of a list of {count} cannot be changed")
            self._refuse(kind, peer, refusal, shift, now_s)
            return
        self._start(_Upload(peer, kind, shift, first, min(last + 1, count), now_s, base=base), now_s)

    def on_item_int(self, message: Any, peer: Peer, now_s: float) -> None:
        upload = self._uploads.get(message.mission_type)
        if upload is None or upload.peer != peer:
            self._on_stray_item(message, peer, now_s)
            return
        upload.heard_s = now_s
        if message.seq == upload.expected:  # anything else is late or doubled: the retry timer asks for what is missing
            self._take(upload, item_from_int(message, message.seq - upload.shift), now_s)

    def on_item(self, message: Any, peer: Peer, now_s: float) -> None:
        upload = self._uploads.get(message.mission_type)
        if upload is None or upload.peer != peer:
            self._on_stray_item(message, peer, now_s)
            return
        upload.heard_s = now_s
        if message.seq != upload.expected:
            return
        item = item_from_float(message, message.seq - upload.shift)
        if isinstance(item, PlanRefusal):
            self._end_refused(upload, item, now_s)
        else:
            self._take(upload, item, now_s)

    def on_client_ack(self, message: Any, peer: Peer) -> None:
        """Anything but ACCEPTED from the sender ends its upload; the old plan stays."""
        upload = self._uploads.get(message.mission_type)
        if upload is not None and upload.peer == peer and message.type != PlanResult.ACCEPTED:
            del self._uploads[message.mission_type]

    def update(self, now_s: float) -> None:
        """Ask again for what did not come; give up on a sender that has fallen silent."""
        for upload in list(self._uploads.values()):
            if now_s - upload.heard_s >= GIVE_UP_S * self._patience or upload.peer.endpoint.gone:
                del self._uploads[upload.kind]
                text = f"{_name(upload.kind)} upload broke off at item {upload.expected}; the old one stays in force"
                self._vessel.events.say(now_s, Severity.WARNING, "plan_upload_lost", text)
            elif now_s >= upload.retry_s:
                upload.retries += 1
                upload.lossy = True
                upload.retry_s = now_s + self._patience * (RETRY_S if upload.retries < _QUICK_RETRIES else LATER_RETRY_S)
                self._send_request(upload)
        for (peer, kind), finished in list(self._finished.items()):
            if now_s >= finished.until_s or peer.endpoint.gone:
                del self._finished[peer, kind]
            elif finished.repeats_s and now_s >= finished.repeats_s[0]:
                del finished.repeats_s[0]
                self._hub.send(peer, finished.answer)

    # --- what others ask -------------------------------------------------------------------------------------------

    def busy_with_another(self, kind: int, peer: Peer) -> bool:
        upload = self._uploads.get(kind)
        return upload is not None and upload.peer != peer and not upload.peer.endpoint.gone

    def end_uploads(self, kind: PlanKind, peer: Peer, now_s: float) -> None:
        """`peer` turns to something new with `kind`: its upload of that kind is over, and those of others that it has left lying.

        Others still under way go on: MAVProxy sends mission and fence side by side. Requests for a transfer that a client has
        given up would disturb its next one, and so would an answer that it no longer waits for.
        """
        for (waiting, _), finished in self._finished.items():
            if waiting == peer:
                finished.repeats_s.clear()
        for upload in list(self._uploads.values()):
            left_lying = upload.kind is kind or now_s - upload.heard_s >= LEFT_LYING_S * self._patience
            if upload.peer.endpoint.gone or (left_lying and upload.peer == peer):
                del self._uploads[upload.kind]

    def clear(self, kind: PlanKind) -> None:
        if self._vessel.plans.items(kind):
            self._vessel.plans.replace(kind, ())

    def acknowledge(self, mission_type: int, peer: Peer, result: PlanResult, plan_id: int = 0) -> Any:
        """MISSION_ACK to `peer` alone."""
        answer = mavlink.MAVLink_mission_ack_message(peer.system, peer.component, result, mission_type, plan_id)
        self._hub.send(peer, answer)
        return answer

    # --- the transfer ----------------------------------------------------------------------------------------------

    def _start(self, upload: _Upload, now_s: float) -> None:
        self._uploads[upload.kind] = upload
        self._ask(upload, now_s)

    def _ask(self, upload: _Upload, now_s: float) -> None:
        upload.retries = 0
        upload.retry_s = now_s + RETRY_S * self._patience
        self._send_request(upload)

    def _send_request(self, upload: _Upload) -> None:
        peer = upload.peer
        self._hub.send(peer, mavlink.MAVLink_mission_request_int_message(peer.system, peer.component, upload.expected, upload.kind))

    def _take(self, upload: _Upload, item: PlanItem, now_s: float) -> None:
        if item.seq >= 0:  # else it is home, which the vessel knows better
            if upload.shift:
                item = with_jump_moved(item, -upload.shift)
            refusal = check_item(upload.kind, item)
            if refusal is not None:
                self._end_refused(upload, replace(refusal, seq=item.seq), now_s)
                return
            upload.items.append(item)
        upload.expected += 1
        if upload.expected < upload.end:
            self._ask(upload, now_s)
        else:
            self._commit(upload, now_s)

    def _commit(self, upload: _Upload, now_s: float) -> None:
        kind, plans = upload.kind, self._vessel.plans
        items = upload.items
        if upload.base is not None:
            items = list(upload.base)
            for item in upload.items:
                items[item.seq] = item
        config = self._vessel.config
        refusal = check_plan(kind, items, config.limits.sway_n > 0.0, len(config.servos), len(config.relays))
        if refusal is None and upload.base is not None and upload.base is not plans.items(kind):
            refusal = PlanRefusal(PlanResult.ERROR, "the list changed meanwhile; load it again")
        if refusal is not None:
            self._end_refused(upload, refusal, now_s)
            return
        del self._uploads[kind]
        plans.replace(kind, items)
        answer = self.acknowledge(kind, upload.peer, PlanResult.ACCEPTED, plans.plan_id(kind))
        self._finish(upload, upload.end - 1, answer, now_s)
        self._on_commit(now_s)

    def _end_refused(self, upload: _Upload, refusal: PlanRefusal, now_s: float) -> None:
        del self._uploads[upload.kind]
        last_seq = min(upload.expected, upload.end - 1)
        answer = self._refuse(upload.kind, upload.peer, refusal, upload.shift, now_s)
        self._finish(upload, last_seq, answer, now_s)

    def _finish(self, upload: _Upload, last_seq: int, answer: Any, now_s: float) -> None:
        repeats_s = [now_s + after_s * self._patience for after_s in UNASKED_REPEATS_S] if upload.lossy else []
        until_s = now_s + REPEAT_ANSWER_S * self._patience
        self._finished[upload.peer, upload.kind] = _Finished(last_seq, answer, until_s, repeats_s)

    def _refuse(self, kind: PlanKind, peer: Peer, refusal: PlanRefusal, shift: int, now_s: float) -> Any:
        place, text = _name(kind), refusal.text
        if refusal.seq is not None:
            text = text.removeprefix(f"item {refusal.seq}:").lstrip()
            place += f" item {refusal.seq + shift}"  # as that client counts
        self._vessel.events.say(now_s, Severity.WARNING, "plan_refused", f"{place}: {text}")
        return self.acknowledge(kind, peer, refusal.result)

    def _deny(self, kind: PlanKind, peer: Peer, now_s: float) -> None:
        text = f"{_name(kind)}: another station is uploading; try again in a moment"
        self._vessel.events.say(now_s, Severity.WARNING, "plan_refused", text)
        self.acknowledge(kind, peer, PlanResult.DENIED)

    def _on_stray_item(self, message: Any, peer: Peer, now_s: float) -> None:
        finished = self._finished.get((peer, message.mission_type))
        if finished is not None and finished.last_seq == message.seq and now_s < finished.until_s:
            self._hub.send(peer, finished.answer)
        elif message.current in _LEGACY_GUIDED:
            self.acknowledge(message.mission_type, peer, PlanResult.UNSUPPORTED)


def shift_of(kind: PlanKind, peer: Peer) -> int:
    """How far numbers on the wire run ahead of those in the list: 1 where a mission's item 0 is home."""
    return int(kind is PlanKind.MISSION and peer.endpoint.dialect.home_is_item_zero)


def _name(kind: PlanKind) -> str:
    return kind.name.lower()

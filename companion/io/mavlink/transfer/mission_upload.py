"""Upload of plans: the vessel requests one item after the other, and replaces its plan as a whole or not at all.

The last item is answered when the plan is checked, stored and in force. Until then the vessel requests that item again
now and then, which keeps a client from giving up.

Source: MAVLink guide, "Mission Protocol". The timings tolerate loss with QGroundControl, which gives up after 1.5 s
without a request, and with MAVSDK (2.5 s).

Items are requested as MISSION_ITEM_INT. ArduPilot asks by the old MISSION_REQUEST, and DroneKit and most scripts with
pymavlink wait for nothing else: a client that leaves the requests for its first item unanswered is asked by both in
turn, also where it begins again meanwhile, and from then on by the one that it answers. MAVSDK refuses the old form as
unsupported, as PX4 knows it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from companion.core.decision import TextKind
from companion.io.mavlink.transfer.mission_codec import NAV_WAYPOINT, item_from_float, item_from_int, with_jump_moved
from companion.io.mavlink.transfer.plan_store import PlanStore
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.actions import GO_THERE
from companion.io.mavlink.wire.hub import Hub, Peer
from companion.loop import Vessel
from companion.mission.commands import name_of
from companion.mission.plan import PlanItem, PlanKind, PlanRefusal, PlanResult, item_number
from companion.mission.validation import CAPACITY, check_item

RETRY_S = 0.25
LATER_RETRY_S = 0.5  # after `_QUICK_RETRIES`: MAVSDK gives up at the sixth request for one item
STORING_S, _MOST_STORING = 1.0, 4  # requests for the last item while the plan is checked and stored
GIVE_UP_S = 5.0
YIELD_S = 2.0  # without an item that was asked for, after which another ground station may upload in its place
_SLOW_S, _LEAST_ITEMS_PER_S = 30.0, 1.0  # an upload that is slower for so long makes room too
ABANDONED_S = 1.0  # an upload without an item for so long is taken to be abandoned when its sender does something else
REPEAT_ANSWER_S = 5.0  # for so long the last item of a finished upload gets its answer again
# Over a link that has lost packets the last answer is repeated: QGroundControl never asks for it.
UNASKED_REPEATS_S = (0.5, 1.0)

_QUICK_RETRIES = 4
_OLD_FORM_RETRY = 2  # the first that asks by MISSION_REQUEST
_CHANGE_ALTITUDE = 3  # as GO_THERE


@dataclass(slots=True)
class _Upload:
    """One transfer. Item numbers are those on the wire: `shift` higher than in the plan, where item 0 is home.
    `heard_s`: when the last item came that was asked for. `begun_s`: when its sender began first."""

    peer: Peer
    kind: PlanKind
    shift: int
    expected: int
    end: int
    heard_s: float
    begun_s: float
    retry_s: float = 0.0
    retries: int = 0
    lossy: bool = False  # an item had to be requested again
    complete: bool = False  # all items are there; the plan is being checked and stored
    old_form: bool = False  # requests are MISSION_REQUEST
    asked_old: bool = False  # one of them was
    form_known: bool = False  # the client has answered a request, or refused a form
    base: tuple[PlanItem, ...] | None = None  # the plan that a partial upload changes
    items: list[PlanItem] = field(default_factory=list)


@dataclass(slots=True)
class _Finished:
    """How a transfer ended, for a sender that missed the answer. `repeats_s`: times at which it is sent again."""

    last_seq: int
    answer: Any
    until_s: float
    repeats_s: list[float] = field(default_factory=list)


class PlanReceiver:
    """Takes MISSION_COUNT, MISSION_WRITE_PARTIAL_LIST, MISSION_ITEM_INT, MISSION_ITEM and the client's MISSION_ACK.

    Sends requests, refusals and the final MISSION_ACK to the sender only. Gives the whole plan to the store, and calls
    `on_commit(now_s)` after the final answer. Remembers one transfer for each kind of plan, and for
    5 s how the last one of each sender ended.
    """

    def __init__(self, hub: Hub, vessel: Vessel, store: PlanStore, on_commit: Callable[[float], None]) -> None:
        self._hub = hub
        self._vessel = vessel
        self._store = store
        self._on_commit = on_commit
        self._patience = hub.patience
        self._uploads: dict[int, _Upload] = {}  # by mission type
        self._finished: dict[tuple[Peer, int], _Finished] = {}

    # --- messages --------------------------------------------------------------------------------------------------

    def on_count(self, kind: PlanKind, count: int, peer: Peer, now_s: float) -> None:
        """MISSION_COUNT: start an upload; a repeated one from the same sender starts it again."""
        if not self.claim(kind, peer, now_s):
            self._deny(kind, peer, now_s)
            return
        heard_s, begun_s = self._since(kind, peer, now_s)
        old_form = self._was_asked_in_vain(kind, peer)
        self.end_uploads(kind, peer, now_s)
        self._finished.pop((peer, kind), None)
        shift = shift_of(kind, peer)
        if count > CAPACITY + shift:
            text = f"{count - shift} items, room for {CAPACITY}"
            self._refuse(kind, peer, PlanRefusal(PlanResult.NO_SPACE, text), now_s)
        elif count == 0:
            self._uploads[kind] = _Upload(peer, kind, shift, 0, 0, now_s, now_s)
            self._commit(self._uploads[kind], now_s)
        else:
            self._start(_Upload(peer, kind, shift, 0, count, heard_s, begun_s, old_form=old_form), now_s)

    def on_partial(self, kind: PlanKind, first: int, last: int, peer: Peer, now_s: float) -> None:
        """MISSION_WRITE_PARTIAL_LIST: change some items of the plan. `last` may lie past the end, as from MAVProxy."""
        if not self.claim(kind, peer, now_s):
            self._deny(kind, peer, now_s)
            return
        heard_s, begun_s = self._since(kind, peer, now_s)
        self.end_uploads(kind, peer, now_s)
        shift = shift_of(kind, peer)
        base = self._vessel.plans.items(kind)
        count = len(base) + shift
        if not base or first < 0 or first >= count or last < first:
            asked = f"items {item_number(first - shift)} to {item_number(last - shift)}"
            refusal = PlanRefusal(PlanResult.INVALID_SEQUENCE, f"{asked} cannot be changed, there are {len(base)}")
            self._refuse(kind, peer, refusal, now_s)
            return
        self._start(_Upload(peer, kind, shift, first, min(last + 1, count), heard_s, begun_s, base=base), now_s)

    def on_item_int(self, message: Any, peer: Peer, now_s: float) -> None:
        """MISSION_ITEM_INT."""
        upload = self._uploads.get(message.mission_type)
        if upload is None or upload.peer != peer:
            self._on_stray_item(message, item_from_int(message, 0), peer, now_s)
            return
        if message.seq == upload.expected and not upload.complete:
            # others are late or duplicates; the retry timer requests what is missing
            self._take(upload, item_from_int(message, message.seq - upload.shift), now_s)

    def on_item(self, message: Any, peer: Peer, now_s: float) -> None:
        """MISSION_ITEM, the old form with degrees as floats."""
        upload = self._uploads.get(message.mission_type)
        if upload is None or upload.peer != peer:
            self._on_stray_item(message, item_from_float(message, 0), peer, now_s)
            return
        if message.seq != upload.expected or upload.complete:
            return
        item = item_from_float(message, message.seq - upload.shift)
        if isinstance(item, PlanRefusal):
            self._end_refused(upload, item, now_s)
        else:
            self._take(upload, item, now_s)

    def on_client_ack(self, message: Any, peer: Peer, now_s: float) -> None:
        """MISSION_ACK: any other than ACCEPTED from the sender ends its upload; the old plan stays. UNSUPPORTED may be
        about the form of a request: then the other one is used."""
        upload = self._uploads.get(message.mission_type)
        if upload is None or upload.peer != peer or message.type == PlanResult.ACCEPTED:
            return
        if message.type != PlanResult.UNSUPPORTED or (upload.form_known and not upload.asked_old):
            self._drop(upload)
            return
        old_form = not upload.asked_old
        changed = old_form != upload.old_form or not upload.form_known
        upload.old_form, upload.form_known = old_form, True
        if changed and not upload.complete:
            self._ask(upload, now_s)

    def update(self, now_s: float) -> None:
        """Request missing items again; end the upload of a silent sender."""
        for upload in list(self._uploads.values()):
            silent = now_s - upload.heard_s >= GIVE_UP_S * self._patience or upload.peer.endpoint.gone
            if silent and not upload.complete:
                del self._uploads[upload.kind]
                at = item_number(upload.expected - upload.shift)
                text = f"{_plan(upload.kind)} upload broke off at item {at}: old one kept"
                self._vessel.events.say(now_s, TextKind.REFUSAL, "plan_upload_lost", text)
            elif now_s >= upload.retry_s:
                self._retry(upload, now_s)
        for (peer, kind), finished in list(self._finished.items()):
            if now_s >= finished.until_s or peer.endpoint.gone:
                del self._finished[peer, kind]
            elif finished.repeats_s and now_s >= finished.repeats_s[0]:
                del finished.repeats_s[0]
                self._hub.send(peer, finished.answer)

    # --- for the mission service -----------------------------------------------------------------------------------

    def claim(self, kind: int, peer: Peer, now_s: float) -> bool:
        """Whether this client may upload or clear a plan of this kind. Another one that is uploading it goes on, unless
        it sends nothing useful, or this one is trusted and it is not: then its upload ends. A whole plan is put in
        force first, also that of a client that has left."""
        upload = self._uploads.get(kind)
        if upload is None or upload.peer == peer or (upload.peer.endpoint.gone and not upload.complete):
            return True
        if not self._yields(upload, peer, now_s):
            return False
        self._drop(upload)
        self.acknowledge(kind, upload.peer, PlanResult.OPERATION_CANCELLED)
        at = item_number(upload.expected - upload.shift)
        text = f"{_plan(upload.kind)} upload by {upload.peer.system} ended at {at}: {peer.system} asks"
        self._vessel.events.say(now_s, TextKind.REFUSAL, "plan_upload_lost", text)
        return True

    def _yields(self, upload: _Upload, peer: Peer, now_s: float) -> bool:
        """Whether an upload makes room for another client."""
        if upload.complete:
            return False
        if peer.endpoint.trusted and not upload.peer.endpoint.trusted:
            return True
        if now_s - upload.heard_s >= YIELD_S * self._patience:
            return True
        elapsed_s = (now_s - upload.begun_s) / self._patience
        return elapsed_s > _SLOW_S and len(upload.items) < _LEAST_ITEMS_PER_S * elapsed_s

    def _since(self, kind: int, peer: Peer, now_s: float) -> tuple[float, float]:
        """(`heard_s`, `begun_s`) of a new upload. Those of one that begins again stay: beginning is nothing useful."""
        upload = self._uploads.get(kind)
        if upload is None or upload.peer != peer or upload.complete:
            return now_s, now_s
        return upload.heard_s, upload.begun_s

    def _was_asked_in_vain(self, kind: int, peer: Peer) -> bool:
        """Whether this client begins again after requests by MISSION_REQUEST_INT that it did not answer. Who does so
        twice a second would never be asked by the other form."""
        upload = self._uploads.get(kind)
        if upload is None or upload.peer != peer or upload.form_known:
            return False
        return upload.retries > 0 and not upload.asked_old

    def is_storing(self, kind: int, peer: Peer) -> bool:
        """Whether this client has sent a whole plan of this kind, which is being checked and stored."""
        upload = self._uploads.get(kind)
        return upload is not None and upload.peer == peer and upload.complete

    def end_uploads(self, kind: PlanKind, peer: Peer, now_s: float) -> None:
        """`peer` begins something new with `kind`: end its upload of that kind, and its abandoned uploads of other
        kinds.

        Its other uploads go on, because MAVProxy sends mission and fence side by side. Requests and answers for a
        transfer that the client has given up would disturb its next one.
        """
        for (waiting, _), finished in self._finished.items():
            if waiting == peer:
                finished.repeats_s.clear()
        for upload in list(self._uploads.values()):
            abandoned = not upload.complete and now_s - upload.heard_s >= ABANDONED_S * self._patience
            over = upload.peer == peer and (upload.kind is kind or abandoned)
            if over or (upload.peer.endpoint.gone and not upload.complete):
                self._drop(upload)

    def acknowledge(self, mission_type: int, peer: Peer, result: PlanResult, plan_id: int = 0) -> Any:
        """Send MISSION_ACK to `peer` only; returns the message."""
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

    def _retry(self, upload: _Upload, now_s: float) -> None:
        """Nothing has come for a while: request the item again."""
        upload.retries += 1
        if upload.complete:
            upload.retry_s = now_s + STORING_S * self._patience
            if upload.retries > _MOST_STORING or not upload.end:
                return
        else:
            upload.lossy = True
            if not upload.form_known:
                upload.old_form = upload.retries >= _OLD_FORM_RETRY and upload.retries % 2 == 0
            upload.retry_s = now_s + self._patience * (RETRY_S if upload.retries < _QUICK_RETRIES else LATER_RETRY_S)
        self._send_request(upload)

    def _send_request(self, upload: _Upload) -> None:
        peer, old_form = upload.peer, upload.old_form
        upload.asked_old = upload.asked_old or old_form
        request = mavlink.MAVLink_mission_request_message if old_form else mavlink.MAVLink_mission_request_int_message
        self._hub.send(peer, request(peer.system, peer.component, upload.expected, upload.kind))

    def _take(self, upload: _Upload, item: PlanItem, now_s: float) -> None:
        """Add the expected item; request the next one, or put the plan in force."""
        upload.heard_s, upload.form_known = now_s, True
        if item.seq >= 0:  # item −1 is home, and the vessel keeps its own
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
        """All items are there: give the whole plan to the store."""
        upload.complete = True
        upload.expected = max(0, upload.end - 1)
        upload.retries, upload.retry_s = 0, now_s + STORING_S * self._patience
        items = upload.items
        if upload.base is not None:
            items = list(upload.base)
            for item in upload.items:
                items[item.seq] = item
        self._store.put(upload.kind, items, partial(self._settle, upload), now_s, upload.base)

    def _settle(self, upload: _Upload, refusal: PlanRefusal | None, now_s: float) -> None:
        """The plan is in force, or refused: answer."""
        if refusal is not None:
            self._end_refused(upload, refusal, now_s)
            return
        self._forget(upload)
        plan_id = self._vessel.plans.plan_id(upload.kind)
        answer = self.acknowledge(upload.kind, upload.peer, PlanResult.ACCEPTED, plan_id)
        if upload.end:
            self._finish(upload, upload.end - 1, answer, now_s)
        self._on_commit(now_s)

    def _drop(self, upload: _Upload) -> None:
        """Forget an upload that its client has given up."""
        self._forget(upload)
        if upload.complete:
            self._store.drop(upload.kind)

    def _forget(self, upload: _Upload) -> None:
        """It is over. Another one in its place goes on."""
        if self._uploads.get(upload.kind) is upload:
            del self._uploads[upload.kind]

    def _end_refused(self, upload: _Upload, refusal: PlanRefusal, now_s: float) -> None:
        self._forget(upload)
        last_seq = min(upload.expected, upload.end - 1)
        answer = self._refuse(upload.kind, upload.peer, refusal, now_s)
        self._finish(upload, last_seq, answer, now_s)

    def _finish(self, upload: _Upload, last_seq: int, answer: Any, now_s: float) -> None:
        repeats_s = [now_s + after_s * self._patience for after_s in UNASKED_REPEATS_S] if upload.lossy else []
        until_s = now_s + REPEAT_ANSWER_S * self._patience
        self._finished[upload.peer, upload.kind] = _Finished(last_seq, answer, until_s, repeats_s)

    def _refuse(self, kind: PlanKind, peer: Peer, refusal: PlanRefusal, now_s: float) -> Any:
        """Announce a refusal and answer with it; returns the answer."""
        text = f"{_plan(kind)}{': ' if refusal.seq is None else ' '}{refusal}"
        self._vessel.events.say(now_s, TextKind.REFUSAL, "plan_refused", text)
        return self.acknowledge(kind, peer, refusal.result)

    def _deny(self, kind: PlanKind, peer: Peer, now_s: float) -> None:
        text = f"{_plan(kind)}: another ground station uploads; wait"
        self._vessel.events.say(now_s, TextKind.REFUSAL, "plan_refused", text)
        self.acknowledge(kind, peer, PlanResult.DENIED)

    def _on_stray_item(self, message: Any, item: PlanItem | PlanRefusal, peer: Peer, now_s: float) -> None:
        """An item outside an upload: repeat the answer of a finished one, or "go there now" as ArduPilot knows it."""
        finished = self._finished.get((peer, message.mission_type))
        repeated = finished is not None and finished.last_seq == message.seq and now_s < finished.until_s
        if finished is not None and repeated and message.current != GO_THERE:
            self._hub.send(peer, finished.answer)
        elif message.current == GO_THERE and peer.endpoint.persona.offboard_may_wait:
            self.acknowledge(message.mission_type, peer, self._go_there(item, now_s))
        elif message.current in (GO_THERE, _CHANGE_ALTITUDE):
            self.acknowledge(message.mission_type, peer, PlanResult.UNSUPPORTED)

    def _go_there(self, item: PlanItem | PlanRefusal, now_s: float) -> PlanResult:
        """What becomes of a waypoint for Guided; a refusal is an event."""
        refusal = item if isinstance(item, PlanRefusal) else _not_a_waypoint(item)
        if refusal is None and isinstance(item, PlanItem):
            accepted = self._vessel.supervisor.guided.go(item.lat_deg, item.lon_deg, now_s).accepted
            return PlanResult.ACCEPTED if accepted else PlanResult.DENIED
        assert refusal is not None
        self._vessel.events.say(now_s, TextKind.REFUSAL, "refused", f"Go-to refused: {refusal.text}")
        return refusal.result


def _not_a_waypoint(item: PlanItem) -> PlanRefusal | None:
    """Why an item cannot be a point to go to; None if it can."""
    if item.command != NAV_WAYPOINT:
        return PlanRefusal(PlanResult.UNSUPPORTED, f"{name_of(item.command)} is no waypoint")
    if not item.x and not item.y:
        return PlanRefusal(PlanResult.INVALID_PARAM5_X, "no such place")
    return check_item(PlanKind.MISSION, item)


def shift_of(kind: PlanKind, peer: Peer) -> int:
    """By how much item numbers on the wire exceed those of the plan: 1 for a mission whose item 0 is home, else 0."""
    return int(kind is PlanKind.MISSION and peer.endpoint.persona.home_is_item_zero)


def _plan(kind: PlanKind) -> str:
    return kind.name.lower()

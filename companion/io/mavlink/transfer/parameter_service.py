"""The parameter protocol: lists, reads and sets parameters. Source: MAVLink guide, "Parameter Protocol".

A whole number travels as its bits in the float field where the persona is bytewise (PX4, QGroundControl, MAVSDK), else
as the float of the same value (ArduPilot).

A value is in force as soon as it is set, and acknowledged when it is on the medium: PARAM_VALUE to all. Where it cannot
be stored, the client gets PARAM_ERROR and a text. The value stays in force, and PARAM_VALUE follows once the medium
takes it.

QGroundControl keeps the parameters of a PX4 vehicle, and loads them from its cache where their hash is still the same.
It asks for the hash by name, or finds it before the list (5.0 and older), and ends the list by setting it. While the
boat is armed, its newer versions load the parameters in no other way. Source: PX4, `param_hash_check` and
`MavlinkParametersManager`; QGroundControl, `ParameterManager::_tryCacheHashLoad`.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

from companion.core.decision import TextKind
from companion.core.storing import Ticket
from companion.io.mavlink.transfer.component_metadata import crc32
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.actions import HASH_CHECK
from companion.io.mavlink.wire.framer import pack
from companion.io.mavlink.wire.hub import Handler, Hub, Peer
from companion.loop import Vessel
from companion.params.spec import ParamRefusal, ParamSpec, ParamType
from companion.params.store import Parameters

LIST_RATE_HZ = 400.0
LIST_BURST = 40.0
LIST_SHARE = 0.5  # of a slow line; the rest is for telemetry
_MOST_LISTINGS = 64  # at a time; of more the oldest ends, and its client asks for what it misses
_VALUE_BYTES = 37  # a framed PARAM_VALUE
_NO_INDEX = -1
_INDEX_OF_NONE = 0xFFFF  # in PARAM_VALUE, of what stands in no list
_FLOAT, _INT32, _UINT32 = struct.Struct("<f"), struct.Struct("<i"), struct.Struct("<I")
_REAL32_TYPE = 9  # MAV_PARAM_TYPE
_INT32_TYPE = 6
_UINT32_TYPE = 5
_WHOLE_NUMBERS = {
    1: struct.Struct("<B"),
    2: struct.Struct("<b"),
    3: struct.Struct("<H"),
    4: struct.Struct("<h"),
    5: _UINT32,
    6: _INT32,
}


class ParamError(IntEnum):
    """The values of MAV_PARAM_ERROR that occur here. None of them says that a medium fails; PERMISSION_DENIED does not
    blame the value."""

    DOES_NOT_EXIST = 1
    VALUE_OUT_OF_RANGE = 2
    PERMISSION_DENIED = 3
    READ_ONLY = 5
    TYPE_UNSUPPORTED = 6
    TYPE_MISMATCH = 7


@dataclass(slots=True)
class _Change:
    """A change that is not acknowledged yet: who asked for it, and the ticket of its storing."""

    ticket: Ticket
    askers: list[Peer] = field(default_factory=list)


@dataclass(slots=True)
class _Listing:
    """The list of parameters that is being sent to one client. `hash_due`: their hash comes before it."""

    next_index: int
    allowance: float
    since_s: float
    hash_due: bool = False


class ParameterService:
    """Answers PARAM_REQUEST_LIST, PARAM_REQUEST_READ and PARAM_SET with PARAM_VALUE (to all when a value changed), or
    with PARAM_ERROR to the client.

    Remembers how far each client's list was sent, which changes are not acknowledged yet, and the hash of the values.
    """

    def __init__(self, hub: Hub, vessel: Vessel) -> None:
        self._hub = hub
        self._vessel = vessel
        self._parameters = vessel.parameters
        self._storage = vessel.storage
        self._names = tuple(spec.name.encode() for spec in self._parameters.specs)
        self._listings: dict[Peer, _Listing] = {}
        self._changes: dict[str, _Change] = {}
        self._touched: list[str] = []  # by the change that is being made
        self._hash: tuple[int, int] | None = None  # with the version of the values that it is of
        self._parameters.on_change(lambda name, _value: self._touched.append(name))
        self._parameters.after_change(self._note_changes)
        self.handles: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_LIST: self._on_request_list,
            mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_READ: self._on_request_read,
            mavlink.MAVLINK_MSG_ID_PARAM_SET: self._on_set,
        }

    def update(self, now_s: float) -> None:
        """Continue the lists, and send values that changed."""
        for peer, listing in list(self._listings.items()):
            if peer.endpoint.gone:
                del self._listings[peer]
                continue
            rate_hz = min(LIST_RATE_HZ, LIST_SHARE * peer.endpoint.bytes_per_s / _VALUE_BYTES)
            listing.allowance = min(listing.allowance + (now_s - listing.since_s) * rate_hz, LIST_BURST)
            listing.since_s = now_s
            self._send_due(peer, listing)
        self.answer(now_s)

    def answer(self, now_s: float) -> None:
        """Acknowledge changes that are stored; tell who asked for one that could not be. At most 40 in one call."""
        stored = [name for name, change in self._changes.items() if change.ticket.durable]
        for name in stored[: int(LIST_BURST)]:
            self._send_to_all(name)
        failed = [name for name, change in self._changes.items() if change.ticket.failed and change.askers]
        for name in failed[: int(LIST_BURST)]:
            self._tell_not_stored(name, now_s)

    def _on_request_list(self, message: Any, peer: Peer, now_s: float) -> None:
        """Send the list from its start. A client that asks again meanwhile gets no higher rate for it."""
        listing = self._listings.get(peer)
        if listing is None:
            if len(self._listings) >= _MOST_LISTINGS:
                del self._listings[next(iter(self._listings))]
            listing = _Listing(0, LIST_BURST, now_s, hash_due=peer.endpoint.persona.has_parameter_hash)
            self._listings[peer] = listing
        listing.next_index = 0
        self._send_due(peer, listing)

    def _send_due(self, peer: Peer, listing: _Listing) -> None:
        count = len(self._parameters.specs)
        if listing.hash_due and not peer.endpoint.busy:
            listing.hash_due = False
            listing.allowance -= 1.0
            self._hub.send(peer, self._hash_message())
        while listing.next_index < count and listing.allowance >= 1.0 and not peer.endpoint.busy:
            self._hub.send(peer, self._value_message(listing.next_index, peer.endpoint.persona.bytewise_parameters))
            listing.next_index += 1
            listing.allowance -= 1.0
        if listing.next_index >= count:
            self._listings.pop(peer, None)

    def _on_request_read(self, message: Any, peer: Peer, now_s: float) -> None:
        index = message.param_index
        if index == _NO_INDEX and _is_hash(message, peer):
            self._hub.send(peer, self._hash_message())
            return
        if index == _NO_INDEX:
            index = self._parameters.index.get(message.param_id, _NO_INDEX)
        if 0 <= index < len(self._parameters.specs):
            self._hub.send(peer, self._value_message(index, peer.endpoint.persona.bytewise_parameters))
        else:
            self._send_error(peer, message.param_id, message.param_index, ParamError.DOES_NOT_EXIST)

    def _on_set(self, message: Any, peer: Peer, now_s: float) -> None:
        name = message.param_id
        if _is_hash(message, peer):
            self._listings.pop(peer, None)
            return
        spec = self._parameters.spec(name)
        if spec is None:
            self._send_error(peer, name, _NO_INDEX, ParamError.DOES_NOT_EXIST)
            self._announce_refusal(now_s, f"unknown parameter {name}")
            return
        bytewise = peer.endpoint.persona.bytewise_parameters
        value = decoded(spec, message.param_value, message.param_type if bytewise else None)
        refusal = value if isinstance(value, ParamError) else _error_of(self._parameters.set(name, value))
        if refusal is None:
            self._acknowledge(name, peer, now_s)
            return
        index = self._parameters.index[name]
        self._send_error(peer, name, index, refusal)  # first: MAVSDK takes the old value alone for a lost answer
        self._hub.send(peer, self._value_message(index, bytewise))
        self._announce_refusal(now_s, f"{name} stays {self._parameters[name]:g}: {_reason(spec, refusal)}")

    def _acknowledge(self, name: str, peer: Peer, now_s: float) -> None:
        """A value is set: send it to all, now or when it is stored."""
        change = self._changes.setdefault(name, _Change(self._storage.parameters()))
        if peer not in change.askers:
            change.askers.append(peer)
        if change.ticket.durable:
            self._send_to_all(name)
        elif change.ticket.failed:
            self._tell_not_stored(name, now_s)

    def _note_changes(self) -> None:
        """The newest ticket covers all values, so it serves for changes that could not be stored before too."""
        ticket = self._storage.parameters()
        for name in self._touched:
            self._changes.setdefault(name, _Change(ticket)).ticket = ticket
        self._touched.clear()
        for change in self._changes.values():
            if change.ticket.failed:
                change.ticket = ticket

    def _tell_not_stored(self, name: str, now_s: float) -> None:
        change = self._changes[name]
        for peer in change.askers:
            self._send_error(peer, name, self._parameters.index[name], ParamError.PERMISSION_DENIED)
        change.askers.clear()
        text = f"{name} not stored: {change.ticket.reason}"
        self._vessel.events.say(now_s, TextKind.REFUSAL, "parameter_not_stored", text)

    def _send_to_all(self, name: str) -> None:
        self._changes.pop(name, None)
        index = self._parameters.index[name]
        packed = {bytewise: pack(self._value_message(index, bytewise)) for bytewise in (False, True)}
        for outlet in self._hub.listeners:
            self._hub.send_packed(outlet, packed[outlet.persona.bytewise_parameters])

    def _value_message(self, index: int, bytewise: bool) -> Any:
        spec = self._parameters.specs[index]
        value, kind = encoded(spec, self._parameters[spec.name], bytewise)
        return mavlink.MAVLink_param_value_message(self._names[index], value, kind, len(self._names), index)

    def _hash_message(self) -> Any:
        """The hash as PX4 sends it: its bits in the float field, beside the number of parameters."""
        version = self._parameters.version
        if self._hash is None or self._hash[0] != version:
            self._hash = version, parameter_hash(self._parameters)
        bits: float = _FLOAT.unpack(_UINT32.pack(self._hash[1]))[0]
        return mavlink.MAVLink_param_value_message(
            HASH_CHECK.encode(), bits, _UINT32_TYPE, len(self._names), _INDEX_OF_NONE
        )

    def _send_error(self, peer: Peer, name: str, index: int, error: ParamError) -> None:
        identifier = name.encode("ascii", "replace")[:16]
        self._hub.send(peer, mavlink.MAVLink_param_error_message(peer.system, peer.component, identifier, index, error))

    def _announce_refusal(self, now_s: float, text: str) -> None:
        self._vessel.events.say(now_s, TextKind.REFUSAL, "parameter_refused", text)


def parameter_hash(parameters: Parameters) -> int:
    """PX4's hash of all parameters: MAVLink's CRC32 over each name and the four bytes of its value, by name. PX4 leaves
    out what its metadata calls volatile; here nothing is."""
    data = bytearray()
    for spec in parameters.specs:
        value = parameters[spec.name]
        data += spec.name.encode()
        data += _INT32.pack(int(value)) if spec.type is ParamType.INT32 else _FLOAT.pack(value)
    return crc32(bytes(data))


def _is_hash(message: Any, peer: Peer) -> bool:
    return bool(message.param_id == HASH_CHECK) and peer.endpoint.persona.has_parameter_hash


def encoded(spec: ParamSpec, value: float, bytewise: bool) -> tuple[float, int]:
    """(param_value, param_type) of PARAM_VALUE. `bytewise`: whole numbers as their bits in the float field."""
    if spec.type is ParamType.REAL32:
        return value, _REAL32_TYPE
    if not bytewise:
        return float(value), _INT32_TYPE
    return _FLOAT.unpack(_INT32.pack(int(value)))[0], _INT32_TYPE


def decoded(spec: ParamSpec, value: float, param_type: int | None) -> float | ParamError:
    """The value of a PARAM_SET, or the error. `param_type` None: `value` is a plain number, whatever type the message
    has (C-cast)."""
    if param_type is None:
        return value
    whole = _WHOLE_NUMBERS.get(param_type)
    if whole is not None:
        return float(whole.unpack_from(_FLOAT.pack(value))[0])
    if param_type != _REAL32_TYPE:
        return ParamError.TYPE_UNSUPPORTED
    if spec.type is ParamType.INT32 and math.isfinite(value) and value != round(value):
        return ParamError.TYPE_MISMATCH
    return value


def _error_of(refusal: ParamRefusal | None) -> ParamError | None:
    return None if refusal is None else ParamError[refusal.name]


def _reason(spec: ParamSpec, error: ParamError) -> str:
    if error is ParamError.READ_ONLY:
        return "it is read-only"
    if error is ParamError.VALUE_OUT_OF_RANGE:
        return f"it takes {spec.takes}"
    return "it takes whole numbers" if error is ParamError.TYPE_MISMATCH else "that type does not fit"

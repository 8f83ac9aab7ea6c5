"""The companion as one device on an NMEA 2000 network: its address, its name, and what every device owes the others.

What it sends for that:

    60928   address claim, to all, priority 6: at start, on request, and against a claim of its address by a higher
            NAME. To a lower NAME it gives the address up and claims the next that no device is known to have. It uses
            an address 250 ms after claiming it (ISO 11783-5).
    126993  heartbeat, to all, priority 7: every 60 s, the interval that it tells
    126996  product information, fast packet, when asked for (59904)
    59392   "not available", to a device that asked it alone for anything else

PGNs are encoded by the `nmea2000` package from the CANboat database.
"""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING, Any

from companion.core.can_frame import pack

if TYPE_CHECKING:
    from nmea2000 import NMEA2000Field, NMEA2000Message

GLOBAL = 255
CLAIM, REQUEST, ACKNOWLEDGE, HEARTBEAT, PRODUCT = 60928, 59904, 59392, 126993, 126996
_SETTLED_S = 0.25
_HEARTBEAT_S = 60.0
_LAST_ADDRESS = 251
_MANUFACTURER = 2046  # given to nobody
_FUNCTION, _CLASS, _MARINE = 130, 25, 4  # PC gateway, internetwork device


def header(identifier: int) -> tuple[int, int, int]:
    """A 29-bit identifier → (PGN, source, destination), 255 for all."""
    source, specific, group, page = (
        identifier & 0xFF,
        identifier >> 8 & 0xFF,
        identifier >> 16 & 0xFF,
        identifier >> 24 & 1,
    )
    if group < 240:
        return page << 16 | group << 8, source, specific
    return page << 16 | group << 8 | specific, source, GLOBAL


class Node:
    """`start`, then `heard` for each claim and request, and `tick` once a control step. Each returns frames to send, as
    bytes.

    Remembers its address, when it claimed it, and which addresses others have. `address` None: not yet to be used.
    """

    def __init__(self, preferred: int, serial: str, version: str) -> None:
        """Raises ImportError where the `nmea2000` package is not installed."""
        from nmea2000 import NMEA2000Field, NMEA2000Message, create_encoder
        from nmea2000.input_formats import N2KFormat

        self._field: type[NMEA2000Field] = NMEA2000Field
        self._message: type[NMEA2000Message] = NMEA2000Message
        self._encoder: Any = create_encoder(N2KFormat.PYTHON_CAN, units="si")
        self._serial, self._version = serial, version
        self._address = preferred
        self._taken: set[int] = set()
        self._claimed_s: float | None = None
        self._settled = False
        self._heartbeat_s: float | None = None
        self._beats = 0
        self._claim_data = b""

    @property
    def address(self) -> int | None:
        """Its address; None until it may be used."""
        return self._address if self._settled else None

    @property
    def wanted(self) -> int:
        """The address that it has or claims."""
        return self._address

    def field(self, name: str, value: Any) -> NMEA2000Field:
        """A field of a message, with its value in SI units."""
        return self._field(id=name, value=value)

    def encode(
        self, pgn: int, name: str, fields: list[NMEA2000Field], destination: int = GLOBAL, priority: int = 6
    ) -> bytes:
        """The frames of one message from this device, as bytes for its stream."""
        message = self._message(
            PGN=pgn, id=name, fields=fields, source=self._address, destination=destination, priority=priority
        )
        return b"".join([pack(frame.arbitration_id, bytes(frame.data)) for frame in self._encoder.encode(message)])

    def start(self, now_s: float) -> bytes:
        """The claim of its address, on a bus that has just been opened."""
        self._claimed_s, self._settled = now_s, False
        frames = self.encode(CLAIM, "isoAddressClaim", [self.field(name, value) for name, value in self._name()])
        self._claim_data = frames[8:16]
        return frames

    def tick(self, now_s: float) -> bytes:
        """Its heartbeat, as it is due."""
        if self._claimed_s is None:
            return self.start(now_s)
        if not self._settled:
            self._settled = now_s - self._claimed_s >= _SETTLED_S
            return b""
        if self._heartbeat_s is not None and now_s - self._heartbeat_s < _HEARTBEAT_S:
            return b""
        self._heartbeat_s = now_s
        return self._heartbeat()

    def heard(self, pgn: int, source: int, destination: int, data: bytes, now_s: float) -> bytes:
        """The answer to an address claim (60928) or a request (59904) of another device."""
        if pgn == CLAIM and len(data) == 8:
            return self._contest(source, data, now_s)
        if pgn == REQUEST and len(data) >= 3 and destination in (GLOBAL, self._address) and self._claimed_s is not None:
            return self._asked(int.from_bytes(data[:3], "little"), source, destination)
        return b""

    def request(self, pgn: int) -> bytes:
        """Asks all devices for a PGN."""
        return self.encode(REQUEST, "isoRequest", [self.field("pgn", pgn)])

    def _contest(self, source: int, data: bytes, now_s: float) -> bytes:
        if source > _LAST_ADDRESS:
            return b""
        if source != self._address:
            self._taken.add(source)
            return b""
        if self._claimed_s is None or data == self._claim_data:
            return b""
        if int.from_bytes(self._claim_data, "little") < int.from_bytes(data, "little"):
            return self.encode(CLAIM, "isoAddressClaim", [self.field(name, value) for name, value in self._name()])
        self._taken.add(source)
        free = [address for address in range(_LAST_ADDRESS + 1) if address not in self._taken]
        above = [address for address in free if address > source]
        self._address = (above or free or [254])[0]
        return self.start(now_s)

    def _asked(self, pgn: int, source: int, destination: int) -> bytes:
        if pgn == CLAIM:
            return self.encode(CLAIM, "isoAddressClaim", [self.field(name, value) for name, value in self._name()])
        if not self._settled:
            return b""
        if pgn == HEARTBEAT:
            return self._heartbeat()
        if pgn == PRODUCT:
            return self.encode(
                PRODUCT, "productInformation", [self.field(name, value) for name, value in self._product()]
            )
        if destination == GLOBAL:
            return b""
        refusal = (("control", 1), ("groupFunction", 255), ("reserved_16", 0xFFFFFF), ("pgn", pgn))
        return self.encode(
            ACKNOWLEDGE, "isoAcknowledgement", [self.field(name, value) for name, value in refusal], source
        )

    def _heartbeat(self) -> bytes:
        self._beats = (self._beats + 1) % 253
        fields = (
            ("dataTransmitOffset", _HEARTBEAT_S),
            ("sequenceCounter", self._beats),
            ("controller1State", 0),
            ("controller2State", 3),
            ("equipmentStatus", 0),
            ("reserved_30", None),
        )
        return self.encode(HEARTBEAT, "heartbeat", [self.field(name, value) for name, value in fields], priority=7)

    def _name(self) -> tuple[tuple[str, int], ...]:
        return (
            ("uniqueNumber", zlib.crc32(self._serial.encode()) & 0x1FFFFF),
            ("manufacturerCode", _MANUFACTURER),
            ("deviceInstanceLower", 0),
            ("deviceInstanceUpper", 0),
            ("deviceFunction", _FUNCTION),
            ("spare", 0),
            ("deviceClass", _CLASS),
            ("systemInstance", 0),
            ("industryGroup", _MARINE),
            ("arbitraryAddressCapable", 1),
        )

    def _product(self) -> tuple[tuple[str, Any], ...]:
        return (
            ("nmea2000Version", 2.1),
            ("productCode", 1),
            ("modelId", "USV companion"),
            ("softwareVersionCode", self._version),
            ("modelVersion", ""),
            ("modelSerialCode", self._serial),
            ("certificationLevel", 0),
            ("loadEquivalency", 1),
        )

"""Which device sends on a line: to report a device on the wrong port, and to list what is plugged in."""

from __future__ import annotations

from collections import Counter
from collections.abc import Set
from dataclasses import dataclass
from typing import Any

from companion.core.microcontroller_frame import BoardStatus, Ident
from companion.io.formats import BoardFinder, LineFormat, MavlinkFinder, NmeaFinder, RtcmFinder, UbxFinder, XsensFinder

_LOOKED_AT, _OF_BYTES = 8192, 65536
_SAMPLE_BYTES = 40
_TEXT_SHARE = 0.9  # of printable characters, from which on a line carries text
_POSITIONS = frozenset({"GGA", "RMC", "GLL", "GNS", "GSV", "GSA", "VTG", "GST", "ZDA"})
_NMEA_DEVICES = (  # the first whose sentences are among those heard
    ("the GNSS receiver", _POSITIONS),
    ("the wind sensor", frozenset({"MWV", "VWR", "MWD"})),
    ("the compass", frozenset({"HDG", "HDM", "HDT", "THS", "ROT"})),
    ("the echo sounder or log", frozenset({"DBT", "DPT", "VHW", "VBW", "MTW"})),
    ("the rudder sensor", frozenset({"RSA"})),
)
_VECTORNAV = "VN"  # begins the names of its messages
_DEVICES = {
    LineFormat.AIS: "the AIS receiver",
    LineFormat.MTDATA2: "the inertial sensor",
    LineFormat.XSENS: "the inertial sensor",
    LineFormat.MAVLINK: "a telemetry radio or an autopilot",
    LineFormat.BOARD: "the thruster board",
    LineFormat.RTCM: "the radio with the corrections",
    LineFormat.UBX: "the GNSS receiver",
}
_REMEDIES = {
    LineFormat.XSENS: "have it send MTData2 (in MT Manager: output configuration)",
    LineFormat.UBX: "have it send NMEA 0183",
}


@dataclass(frozen=True, slots=True)
class Recognised:
    """What a line carries. `kinds`: how many messages of each kind, the most frequent first. `device`: the name of
    such a device for people. `notes`: its newest message of some kinds (MAVLink heartbeats, a board's identity and
    status)."""

    format: LineFormat
    kinds: tuple[tuple[str, int], ...]
    device: str
    notes: dict[str, Any]

    @property
    def types(self) -> Set[str]:
        """NMEA sentences without their talkers; the kinds of other formats."""
        return frozenset(
            name[2:] if self.format is LineFormat.NMEA and not name.startswith("P") else name for name, _ in self.kinds
        )

    @property
    def text(self) -> str:
        """`NMEA 0183 (GNGGA, GNHDT)`."""
        return f"{self.format.value} ({', '.join(name for name, _ in self.kinds[:4])})"


class Recogniser:
    """Bytes as they come in → `verdict`. Remembers counts, at most some 2 kB of unfinished messages, and the last 40
    bytes."""

    def __init__(self) -> None:
        self.bytes = 0
        self._kinds: dict[LineFormat, Counter[str]] = {each: Counter() for each in LineFormat}
        self._carried: Counter[LineFormat] = Counter()  # bytes
        self._notes: dict[str, Any] = {}
        self._printable = self._lines = 0
        self._sample = b""
        self._nmea = NmeaFinder()
        self._finders = (self._nmea, XsensFinder(), RtcmFinder(), UbxFinder(), MavlinkFinder(), BoardFinder())

    def feed(self, data: bytes) -> None:
        """The next bytes of the line."""
        self.bytes += len(data)
        self._printable += sum(32 <= byte < 127 or byte in b"\r\n\t" for byte in data)
        self._lines += data.count(b"\n") + data.count(b"\r")
        self._sample = (self._sample + data)[-_SAMPLE_BYTES:]
        for finder in self._finders:
            for found in finder.feed(data):
                self._kinds[found.format][found.kind] += 1
                self._carried[found.format] += found.length
                if found.kind == "HEARTBEAT" or isinstance(found.message, Ident | BoardStatus):
                    self._notes[found.kind] = found.message

    @property
    def verdict(self) -> Recognised | None:
        """The format that carried the most bytes; None while no message of any has been seen."""
        if not self._carried:
            return None
        best = max(self._carried, key=lambda each: self._carried[each])
        kinds = tuple(self._kinds[best].most_common())
        return Recognised(best, kinds, self._device(best, kinds), dict(self._notes))

    @property
    def guess(self) -> str:
        """Half a sentence for a driver that expects another format; empty for bytes that show nothing."""
        verdict = self.verdict
        if verdict is not None:
            return (
                f"looks like {verdict.text}: {_REMEDIES.get(verdict.format) or f'is {verdict.device} plugged in here?'}"
            )
        if self._nmea.bad:
            return "sentences of NMEA 0183 with wrong checksums: a bad wire, or two talkers on one line"
        if self._lines and self._printable >= _TEXT_SHARE * self.bytes:
            shown = "".join(chr(byte) if 32 <= byte < 127 else "·" for byte in self._sample).strip("·")
            return f"text, but no NMEA 0183 with checksums: '{shown}'"
        return ""

    def _device(self, best: LineFormat, kinds: tuple[tuple[str, int], ...]) -> str:
        if best is LineFormat.BOARD and isinstance(ident := self._notes.get("identity"), Ident):
            return f"the thruster board '{ident.name}'"
        if best is not LineFormat.NMEA:
            return _DEVICES[best]
        if all(name.startswith(_VECTORNAV) for name, _ in kinds):
            return "the inertial sensor"
        types = {name[2:] for name, _ in kinds}
        return next((device for device, typical in _NMEA_DEVICES if types & typical), "an NMEA device")


class Overheard:
    """What a driver receives on its port and cannot read: perhaps another device's messages. `guess` as of a
    `Recogniser`.

    While the driver's own messages come in it does nothing. Otherwise it looks at the first 8 kB of every 64 kB, so
    that a flood costs little.
    """

    def __init__(self, patience_bytes: int) -> None:
        """`patience_bytes`: fewer bytes without a valid message are normal."""
        self._patience_bytes = patience_bytes
        self._passed = 0
        self._recogniser: Recogniser | None = None

    def hear(self, data: bytes, bytes_since_valid: int) -> None:
        """The next bytes of the line; `bytes_since_valid` counts them."""
        if bytes_since_valid < self._patience_bytes:
            self._recogniser = None
            return
        if self._recogniser is None or self._passed >= _OF_BYTES:
            self._recogniser, self._passed = Recogniser(), 0
        if self._passed < _LOOKED_AT:
            self._recogniser.feed(data[:_LOOKED_AT])
        self._passed += len(data)

    @property
    def guess(self) -> str:
        """Half a sentence about the other device; empty where nothing is known."""
        return "" if self._recogniser is None else self._recogniser.guess

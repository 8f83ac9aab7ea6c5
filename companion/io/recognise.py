"""What speaks on a line: to say that a device is plugged into another one's port, and to list what is plugged in."""

from __future__ import annotations

from collections import Counter
from collections.abc import Set
from dataclasses import dataclass
from typing import Any

from companion.core.microcontroller_frame import BoardStatus, Ident
from companion.io.formats import BoardFinder, Format, MavlinkFinder, NmeaFinder, RtcmFinder, UbxFinder, XsensFinder

_LOOKED_AT, _OF_BYTES = 8192, 65536
_SAMPLE_BYTES = 40
_TEXT_SHARE = 0.9  # of printable characters, from which on a line carries text
_POSITIONS = frozenset({"GGA", "RMC", "GLL", "GNS", "GSV", "GSA", "VTG", "GST", "ZDA"})
_NMEA_DEVICES = (  # the first whose sentences are among those heard
    ("the GNSS receiver", _POSITIONS),
    ("the inertial sensor", frozenset({"YMR"})),  # VectorNav's VNYMR
    ("the wind sensor", frozenset({"MWV", "VWR", "MWD"})),
    ("the compass", frozenset({"HDG", "HDM", "HDT", "THS", "ROT"})),
    ("the echo sounder or log", frozenset({"DBT", "DPT", "VHW", "VBW", "MTW"})),
    ("the rudder sensor", frozenset({"RSA"})),
)
_DEVICES = {
    Format.AIS: "the AIS receiver",
    Format.MTDATA2: "the inertial sensor",
    Format.XSENS: "the inertial sensor",
    Format.MAVLINK: "a telemetry radio or an autopilot",
    Format.BOARD: "the thruster board",
    Format.RTCM: "the radio with the corrections",
    Format.UBX: "the GNSS receiver",
}
_REMEDIES = {
    Format.XSENS: "have it send MTData2 (in MT Manager: output configuration)",
    Format.UBX: "have it send NMEA 0183",
}


@dataclass(frozen=True, slots=True)
class Verdict:
    """`kinds`: how many messages of which kind, the most frequent first; `device`: what people call what speaks so; `notes`: its own
    newest message of each kind, where that matters (MAVLink heartbeats, a board's identity and status)."""

    format: Format
    kinds: tuple[tuple[str, int], ...]
    device: str
    notes: dict[str, Any]

    @property
    def types(self) -> Set[str]:
        """NMEA sentences without their talkers; the kinds of other formats."""
        return frozenset(name[2:] if self.format is Format.NMEA and not name.startswith("P") else name for name, _ in self.kinds)

    @property
    def text(self) -> str:
        """`NMEA 0183 (GNGGA, GNHDT)`."""
        return f"{self.format.value} ({', '.join(name for name, _ in self.kinds[:4])})"


class Recogniser:
    """Bytes as they come in → `verdict`. Remembers counts, some 2 kB of unfinished messages at most, and the last 40 bytes."""

    def __init__(self) -> None:
        self.bytes = 0
        self._kinds: dict[Format, Counter[str]] = {each: Counter() for each in Format}
        self._carried: Counter[Format] = Counter()  # bytes
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
    def verdict(self) -> Verdict | None:
        """The format that carried the most bytes; None while no message of any has been seen."""
        if not self._carried:
            return None
        best = max(self._carried, key=lambda each: self._carried[each])
        kinds = tuple(self._kinds[best].most_common())
        return Verdict(best, kinds, self._device(best, kinds), dict(self._notes))

    @property
    def guess(self) -> str:
        """Half a sentence for who expected something else; empty for bytes that tell nothing."""
        verdict = self.verdict
        if verdict is not None:
            return f"looks like {verdict.text}: {_REMEDIES.get(verdict.format) or f'is {verdict.device} plugged in here?'}"
        if self._nmea.bad:
            return "sentences of NMEA 0183 with wrong checksums: a bad wire, or two talkers on one line"
        if self._lines and self._printable >= _TEXT_SHARE * self.bytes:
            shown = "".join(chr(byte) if 32 <= byte < 127 else "·" for byte in self._sample).strip("·")
            return f"text, but no NMEA 0183 with checksums: '{shown}'"
        return ""

    def _device(self, best: Format, kinds: tuple[tuple[str, int], ...]) -> str:
        if best is Format.BOARD and isinstance(ident := self._notes.get("identity"), Ident):
            return f"the thruster board '{ident.name}'"
        if best is not Format.NMEA:
            return _DEVICES[best]
        types = {name[2:] for name, _ in kinds}
        return next((device for device, tells in _NMEA_DEVICES if types & tells), "an NMEA device")


class Overheard:
    """What a driver hears on its port and cannot read: another device's messages, perhaps. `guess` as of a `Recogniser`.

    While the driver's own messages come in nothing is done; else the first 8 kB of every 64 kB are looked at, so that a flood costs little.
    """

    def __init__(self, patience_bytes: int) -> None:
        """`patience_bytes`: so many without one valid message are nothing to wonder at."""
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
        return "" if self._recogniser is None else self._recogniser.guess

"""Corrections for satellite receivers: RTCM 3 from radios, TCP streams, NTRIP casters and ground stations, to the ports
of the receivers.

Whole frames only, unchanged. Corrections of two base stations must not be mixed: a receiver is given those of one
source, the first in the vessel's file that is alive, ground stations after them.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Callable, Mapping, Sequence

from companion.config.streams import CorrectionsConfig
from companion.core.decision import TextKind
from companion.core.ports import ByteStream
from companion.core.readings import Measurement, Reading
from companion.core.tick import DeviceHealth, Tick
from companion.io.nmea_out import gga
from companion.io.rtcm import RtcmFramer

Say = Callable[[float, TextKind, str, str], None]

RATE = "rtcm_hz"  # the measurement by which a source shows in the log
_TIMEOUT_S = 10.0
_TWICE_S = 5.0  # how late the same frame may come again by another way
_MOST_REMEMBERED = 64
_UNFINISHED_S = 0.5  # a line that pauses this long in mid-frame will not finish it
_RATE_PERIOD_S = 1.0
_PATIENCE_S = 30.0  # after the start, and between two requests that a caster refused
_MOST_HEADER = 2000
_SOON_S, _FIRST_WAIT_S = 10.0, 1.0  # a caster that hangs up so soon after a request is left alone for a while
_RTCM_BEGINS = b"\xd3"


class CorrectionsRelay:
    """Frames of all sources → the receivers' ports. It is a recorder too: once a tick it announces when corrections
    stop and when they are back.

    Remembers for each receiver its source and how long that one keeps it, the frames forwarded lately, and when any
    were heard.
    """

    def __init__(
        self,
        receivers: Mapping[str, ByteStream | None],
        sources: Sequence[str],
        say: Say,
        moving: Sequence[ByteStream | None] = (),
    ) -> None:
        """`receivers`: ports by the names of the sensors, None for one that is not written to (a replay). `sources`:
        those of the vessel's file, in its order. `moving`: ports of the receivers that use a moving base."""
        self._receivers = dict(receivers)
        self._moving = tuple(moving)
        self._ranks = {name: rank for rank, name in enumerate(sources)}
        self._say = say
        self._listens: dict[str, tuple[str, float]] = {}  # receiver → (source, until when no other takes over)
        self._lately: dict[bytes, tuple[str, float]] = {}  # frame → (way, when)
        self._heard_s: float | None = None
        self._lost = False
        self._homeless_announced = False
        self._listeners: list[Callable[[Tick], None]] = []

    def take_moving(self, frames: Sequence[bytes], now_s: float) -> None:
        """Forward the frames of the leader module's receiver, a base that moves, to the receivers for it alone."""
        for stream in self._moving:
            if frames and stream is not None:
                stream.write(b"".join(frames), now_s)

    def every_tick(self, listener: Callable[[Tick], None]) -> None:
        """Call `listener` with each tick: a source that needs the boat's position."""
        self._listeners.append(listener)

    def take(
        self,
        source: str,
        frames: Sequence[bytes],
        now_s: float,
        to: str | None = None,
        way: str = "",
        timeout_s: float = _TIMEOUT_S,
    ) -> None:
        """Forward the frames of a source to the receiver `to`, or to all. `way`: by which of several ways a source came
        in; a frame that comes by two ways goes out once. `timeout_s`: its silence after which another takes over."""
        if not frames:
            return
        if not self._receivers and not self._homeless_announced:
            self._homeless_announced = True
            self._say(
                now_s,
                TextKind.ATTENTION,
                "corrections",
                "RTK corrections unused: no sensor has rtcm = true",
            )
        fresh = [frame for frame in frames if self._is_new(frame, way or source, now_s)]
        for name, stream in self._receivers.items():
            if to in (None, name) and self._chosen(name, source, now_s, timeout_s) and fresh and stream is not None:
                stream.write(b"".join(fresh), now_s)

    def heard(self, now_s: float) -> None:
        """Corrections came in, from any source."""
        if self._lost and self._receivers:
            self._say(now_s, TextKind.ROUTINE, "corrections_back", "RTK corrections are back")
        self._lost = False
        self._heard_s = now_s

    def record(self, tick: Tick) -> None:
        """See `Recorder`."""
        now_s = tick.t_s
        for listener in self._listeners:
            listener(tick)
        for reading in tick.readings:
            if type(reading) is Measurement and reading.name == RATE and reading.source in self._ranks:
                self.heard(now_s)
                break
        never_s = _PATIENCE_S - _TIMEOUT_S if self._ranks else math.inf
        since_s = never_s if self._heard_s is None else self._heard_s
        if not self._lost and self._receivers and now_s - since_s > _TIMEOUT_S:
            self._lost = True
            text = "none yet" if self._heard_s is None else f"none for {_TIMEOUT_S:.0f} s"
            self._say(now_s, TextKind.ATTENTION, "corrections_lost", f"RTK corrections: {text}")

    def close(self) -> None:
        """Nothing to close: the ports belong to the sensors."""

    def _chosen(self, receiver: str, source: str, now_s: float, timeout_s: float) -> bool:
        current, until_s = self._listens.get(receiver, (source, now_s))
        if source != current and now_s <= until_s and self._rank(source) >= self._rank(current):
            return False
        self._listens[receiver] = source, now_s + timeout_s
        return True

    def _rank(self, source: str) -> int:
        return self._ranks.get(source, len(self._ranks))

    def _is_new(self, frame: bytes, way: str, now_s: float) -> bool:
        before, when_s = self._lately.pop(frame, (way, now_s))
        self._lately[frame] = before, now_s
        if len(self._lately) > _MOST_REMEMBERED:
            del self._lately[next(iter(self._lately))]
        if before == way or now_s - when_s > _TWICE_S:
            self._lately[frame] = way, now_s
            return True
        return False


class CorrectionsSource:
    """One source of the vessel's file as a `Sensor`: reads its port, hands whole frames to the relay, and gives their
    rate to the log.

    It is always well, since a boat can do without corrections; its health text tells more. Remembers the unfinished
    frame, counts, and for a caster the request and its answer.
    """

    def __init__(self, config: CorrectionsConfig, name: str, stream: ByteStream, relay: CorrectionsRelay) -> None:
        self.name = name
        self._config = config
        self._stream = stream
        self._relay = relay
        self._framer = RtcmFramer()
        self._caster = None if config.mountpoint is None else Caster(config)
        if self._caster is not None:
            relay.every_tick(self.send_position)
        self._bytes_s = self._frame_s = -math.inf
        self._frames = 0
        self._counted = 0
        self._counted_s: float | None = None

    def read(self, now_s: float) -> Sequence[Reading]:
        """The rate of frames, once a second while they come."""
        frames: list[bytes] = []
        for _, data in self._stream.read(now_s):
            self._bytes_s = now_s
            frames += self._framer.feed(data if self._caster is None else self._caster.stream(data, now_s))
        if self._framer.pending and now_s - self._bytes_s > _UNFINISHED_S:
            frames += self._framer.flush()
        if self._caster is not None:
            request = self._caster.request(self._stream.fault() is None, now_s)
            if request:
                self._stream.write(request, now_s)
        if not frames:
            return ()
        self._frames += len(frames)
        self._frame_s = now_s
        self._relay.take(self.name, frames, now_s, self._config.to, timeout_s=self._config.timeout_s)
        return self._rate(now_s)

    def send_position(self, tick: Tick) -> None:
        """The position for a caster of virtual reference stations, when it is due."""
        if self._caster is not None and self._caster.position_due(tick.t_s) and tick.nav.position_valid:
            self._stream.write(gga(tick), tick.t_s)

    def health(self, now_s: float) -> DeviceHealth:
        """Always ok, with the trouble or the counts."""
        age_s = None if self._frames == 0 else now_s - self._frame_s
        counts = f"{self._frames} RTCM frames, {self._framer.bad} bad"
        return DeviceHealth(
            self.name, True, age_s, f"{trouble} ({counts})" if (trouble := self._trouble(age_s)) else counts
        )

    def _trouble(self, age_s: float | None) -> str:
        if self._caster is not None and self._caster.trouble:
            return self._caster.trouble
        fault = self._stream.fault()
        if fault is not None:
            return fault
        if age_s is not None and age_s <= self._config.timeout_s:
            return ""
        if self._framer.garbage >= 600 and self._frames == 0:
            return f"bytes arrive but no RTCM 3 frames: wrong baud rate in '{self._config.port}', or another protocol"
        return "nothing received yet" if age_s is None else f"silent for {age_s:.0f} s"

    def fileno(self) -> int | None:
        """See `Sensor`."""
        return self._stream.fileno()

    def close(self) -> None:
        """Close the port."""
        self._stream.close()

    def _rate(self, now_s: float) -> Sequence[Reading]:
        if self._counted_s is None:
            self._counted_s = now_s - _RATE_PERIOD_S
        elapsed_s = now_s - self._counted_s
        if elapsed_s < _RATE_PERIOD_S:
            return ()
        rate_hz = (self._frames - self._counted) / elapsed_s
        self._counted, self._counted_s = self._frames, now_s
        return (Measurement(now_s, self.name, rate_hz, RATE),)


class Caster:
    """The beginning of a conversation with an NTRIP caster, version 1: request, answer, then bare RTCM.

    Remembers whether the line was open, the unfinished beginning of the answer, whether that was a refusal, when the
    request went out, for how long a caster that hung up soon is left alone, and when a request may go out again.
    """

    def __init__(self, config: CorrectionsConfig) -> None:
        self._config = config
        self._was_open = False
        self._header: bytes | None = b""  # None once the answer was good
        self._head: bytes | None = None  # of an answer by HTTP, while it is not complete
        self._may_ask_s = self._position_s = self._asked_s = -math.inf
        self._wait_s = 0.0
        self._asked = self._refused = False
        self.trouble = ""

    def request(self, is_open: bool, now_s: float) -> bytes:
        """What to send now; b'' for nothing. `is_open`: whether the line is open."""
        if self._was_open and not is_open and self._asked and not self._refused:
            self._hung_up(now_s)
        anew = not self._was_open or (self._refused and now_s >= self._may_ask_s)  # not every caster hangs up
        if is_open and anew:
            self._header, self._asked, self._refused = b"", False, False
        self._was_open = is_open
        if not is_open or self._asked or now_s < self._may_ask_s:
            return b""
        self._asked, self._asked_s = True, now_s
        config = self._config
        lines = [f"GET /{config.mountpoint} HTTP/1.0", "User-Agent: NTRIP usv-companion/0.1"]
        if config.user is not None:
            lines.append(
                "Authorization: Basic " + base64.b64encode(f"{config.user}:{config.password}".encode()).decode("ascii")
            )
        return ("\r\n".join(lines) + "\r\n\r\n").encode("ascii")

    def _hung_up(self, now_s: float) -> None:
        """The line ended: soon after the request, the next one waits, twice as long each time."""
        soon = now_s - self._asked_s < _SOON_S
        self._wait_s = min(_PATIENCE_S, max(_FIRST_WAIT_S, 2.0 * self._wait_s)) if soon else 0.0
        self._may_ask_s = now_s + self._wait_s

    def stream(self, data: bytes, now_s: float) -> bytes:
        """The part of the bytes that may be RTCM."""
        if self._header is None:
            return self._unless_table(data, now_s)
        if self._refused:
            return b""  # the rest of that answer
        self._header += data
        first, end, rest = self._header.partition(b"\r\n")
        if not end and len(self._header) < _MOST_HEADER:
            return b""
        text = first.decode("ascii", "replace")[:80]
        words = text.split()
        if len(words) >= 2 and words[1] == "200" and not text.startswith("SOURCETABLE"):
            self._header, self.trouble = None, ""
            self._head = end if text.startswith("HTTP/") else None
            return self._unless_table(rest, now_s)
        return self._refuse(None if text.startswith("SOURCETABLE") else text, now_s)

    def _unless_table(self, data: bytes, now_s: float) -> bytes:
        """The bytes of a good answer; none where its head, which may come in pieces, says that a table follows."""
        if self._head is None:
            return data
        self._head += data
        head, ended, _ = self._head.partition(b"\r\n\r\n")
        if b"gnss/sourcetable" in head.lower():
            return self._refuse(None, now_s)
        if ended or _RTCM_BEGINS in head or len(head) >= _MOST_HEADER:
            self._head = None
        return data

    def _refuse(self, text: str | None, now_s: float) -> bytes:
        """The caster answers with `text`; None: with the table of its mountpoints."""
        self._header, self._refused = b"", True
        self._may_ask_s = now_s + _PATIENCE_S
        none_such = f"the caster has no mountpoint {self._config.mountpoint}"
        self.trouble = none_such if text is None else f"the caster refuses: {text}"
        return b""

    def position_due(self, now_s: float) -> bool:
        """Whether the caster should get the position now."""
        if self._header is not None or self._config.gga_s == 0.0 or now_s - self._position_s < self._config.gga_s:
            return False
        self._position_s = now_s
        return True

"""NMEA 0183: satellite receivers, compasses, wind sensors, sounders, logs and transducers of any maker, over serial or
network.

Source: NMEA 0183 version 4.11 as pynmea2 knows it: its tables name the fields, their texts are read here. Sentences
without a checksum are rejected. The two letters of the talker matter only where the vessel's file names them, and where
they tell a magnetic compass. Between the sentences there may be anything, such as RTCM or a maker's binary messages, of
which UBX-NAV-RELPOSNED is read. Proprietary sentences ($P…) and AIS (!…) are ignored.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from companion.config.devices import SensorConfig
from companion.core.ports import ByteStream
from companion.core.readings import Reading, RelativeFix
from companion.core.tick import DeviceHealth
from companion.io.sensors.driver import StreamDriver
from companion.io.sensors.nmea0183_fields import TALKER, checksum
from companion.io.sensors.nmea0183_gnss import GnssSentences, Handler
from companion.io.sensors.nmea0183_hull import TRANSDUCERS, HullSentences, replaces_lesser
from companion.io.sensors.nmea0183_radar import RadarSentences
from companion.io.sensors.nmea0183_sentences import TYPES
from companion.io.sensors.nmea0183_time import SentenceTimes
from companion.io.sensors.ubx_relative import RelativeSolution, RelativeSolutions

_LONGEST = 120  # of a sentence between $ and *: receivers with many digits go past the standard's 82
_SENTENCE = re.compile(rb"([$!])([ -#%%-)+-~]{6,%d})\*([0-9A-Fa-f]{2})" % _LONGEST)
_UNCHECKED = re.compile(rb"\$[A-Z]{2}[A-Z]{3},[ -#%-)+-~]*\r?\n")
_KEPT_BYTES = _LONGEST + 4
_PREFERRED_AGE_S = 2.0  # lesser sentences count only where nothing better came for that long
_MANY = 50
_MOST_OTHERS = 6
_PROPRIETARY, _SATELLITES, _TRANSDUCERS = "P", "GSV", "XDR"


class Nmea0183Sensor(StreamDriver):
    """NMEA sentences → readings; `GnssSentences`, `HullSentences` and `RadarSentences` say which.

    Times: `SentenceTimes`. `RelativeSolutions`: the vector to a moving base.

    Remembers the unfinished sentence, when each type of sentence last came, how many came without a checksum since the
    last with one, and whether any was of use.
    """

    messages = "NMEA sentences"

    def __init__(self, config: SensorConfig, stream: ByteStream) -> None:
        super().__init__(config, stream)
        self._tail = b""
        self._tail_arrival_s = 0.0
        self._seen_s: dict[str, float] = {}
        self._unchecked = 0
        self._used = False  # whether a sentence of any use has come yet
        self._others: set[str] = set()
        self._talkers = frozenset(config.talkers)
        self._times = SentenceTimes(config.latency_s, self._pace)
        self._relative = RelativeSolutions()
        self._relative_of_day_s = math.nan
        self._gnss = GnssSentences(self.name, self._recent)
        self._handlers: Mapping[str, Handler] = {
            **self._gnss.handlers,
            **HullSentences(config, self._recent).handlers,
            **RadarSentences(self.name).handlers,
        }
        self._names = {kind: tuple(field[1] for field in TYPES[kind].fields) for kind in (*self._handlers, _SATELLITES)}
        self._names[_TRANSDUCERS] = TRANSDUCERS

    def health(self, now_s: float) -> DeviceHealth:
        """As every driver's, with the satellites in view."""
        health = super().health(now_s)
        remark = self._gnss.remark(now_s) if health.ok else ""
        return DeviceHealth(health.name, health.ok, health.age_s, f"{health.text}; {remark}") if remark else health

    def _complaint(self, age_s: float | None) -> str:
        complaint = super()._complaint(age_s)
        if complaint or self._used or self._valid < _MANY:
            return complaint
        others = ", ".join(sorted(self._others))
        return f"the device on '{self._config.port}' sends no sentence that is used here, but {others}"

    def _nonsense(self) -> str:
        if self._unchecked:
            return "sentences come without a checksum, or with a wrong one: have the device send checksums"
        return super()._nonsense()

    def _feed(self, arrival_s: float, data: bytes, readings: list[Reading]) -> None:
        self._sentences(arrival_s, data, readings)
        bad = self._relative.bad
        for solution in self._relative.feed(data):
            self._take_relative(solution, arrival_s, readings)
        self._bad += self._relative.bad - bad

    def _take_relative(self, solution: RelativeSolution, arrival_s: float, readings: list[Reading]) -> None:
        """A relative position; one of the same moment as the last is a repetition, and is ignored."""
        self._count_valid(arrival_s, "RELPOSNED")
        self._used = True
        if solution.of_day_s == self._relative_of_day_s:
            return
        self._relative_of_day_s = solution.of_day_s
        t_s = self._times.at(solution.of_day_s, arrival_s)
        vector = solution.north_m, solution.east_m, solution.down_m
        readings.append(RelativeFix(t_s, self.name, *vector, solution.fix, solution.accuracy_m, solution.base))

    def _sentences(self, arrival_s: float, data: bytes, readings: list[Reading]) -> None:
        kept = len(self._tail)
        buffer = self._tail + data if kept else data
        done = 0
        for match in _SENTENCE.finditer(buffer):
            began_s = self._tail_arrival_s if match.start() < kept else arrival_s
            done = match.end()
            body: bytes = match[2]
            if checksum(body) != int(match[3], 16):
                self._bad += 1
            elif match[1] == b"$":
                self._sentence(body.decode("ascii"), began_s, arrival_s, readings)
            else:
                self._count_valid(arrival_s, "AIS")
                self._others.add("AIS")
        if done:
            self._unchecked = 0
        else:
            self._unchecked += len(_UNCHECKED.findall(buffer))
        begin = buffer.rfind(b"$", done)
        unfinished = begin >= 0 and len(buffer) - begin <= _KEPT_BYTES
        if unfinished and begin >= kept:
            self._tail_arrival_s = arrival_s
        self._tail = buffer[begin:] if unfinished else b""

    def _sentence(self, body: str, began_s: float, arrival_s: float, readings: list[Reading]) -> None:
        talker, kind = body[:2], body[2:5]
        if talker[0] == _PROPRIETARY or body[5] != ",":
            self._count_valid(arrival_s, "other")
            self._note_other(body.split(",")[0])
            return
        self._count_valid(arrival_s, kind)
        names = self._names.get(kind)
        if names is None or (self._talkers and talker not in self._talkers):
            self._note_other(body[:5])
            return
        self._used = True
        sentence = dict(zip(names, body[6:].split(","), strict=False))
        sentence[TALKER] = talker
        try:
            t_s = self._times.of(kind, sentence, began_s)
            if kind == _SATELLITES:
                self._gnss.satellites(talker, sentence, t_s)
                return
            self._handlers[kind](sentence, t_s, readings)
        except (ValueError, OverflowError):  # fields that are not what their place says
            self._bad += 1
            return
        if replaces_lesser(kind, sentence):
            self._seen_s[kind] = t_s

    def _note_other(self, name: str) -> None:
        if len(self._others) < _MOST_OTHERS:
            self._others.add(name[:12])

    def _recent(self, kind: str, t_s: float) -> bool:
        return t_s - self._seen_s.get(kind, -math.inf) < _PREFERRED_AGE_S

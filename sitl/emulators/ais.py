"""An AIS receiver that prints what the transponders of the traffic send: position reports, and seldom static data.

Source: ITU-R M.1371-5, tables 48 (message 1), 52 (message 5), 70 (message 18) and 79, 80 (message 24); payload
armouring as in IEC 61162-1, VDM.
"""

from __future__ import annotations

import math

from companion.config.devices import SensorConfig
from companion.core.geodesy import LocalFrame
from sitl.emulators.device import SensedWorld
from sitl.emulators.nmea import KNOTS_PER_MPS, checksum_text
from sitl.memory import MemoryDevice
from sitl.noise import stream
from sitl.traffic import ScriptedVessel, VesselMotion

_POSITION_M = 1.0  # one sigma on each axis of the vessel's receiver
_SPEED_MPS, _COURSE_RAD = 0.03, math.radians(1.0)
_STATIC_S = 360.0
_PAYLOAD = 56  # characters in a sentence
_LETTERS = "@ABCDEFGHIJKLMNOPQRSTUVWXYZ[\\]^_ !\"#$%&'()*+,-./0123456789:;<=>?"

Bits = list[tuple[int, int]]  # (value, width), the most significant first


class AisEmulator:
    """Each vessel reports its motion every `report_s`, at a phase of its own; its name and size once and then every 6
    minutes."""

    def __init__(self, config: SensorConfig, port: MemoryDevice, around: SensedWorld) -> None:
        self.name = config.name
        self.rate_hz = min(config.rate_hz, around.step_hz)
        self._port = port
        self._around = around
        self._latency_s = config.latency_s
        self._frame = LocalFrame(around.home.lat_deg, around.home.lon_deg)
        self._random = stream(around.seed, f"{config.name} white")
        self._due_s: dict[int, float] = {}
        self._static_due_s: dict[int, float] = {}
        self._sequence = 0

    def speak(self, t_s: float) -> None:
        """Print the reports that are due."""
        for vessel in self._around.traffic.vessels:
            if vessel.mmsi not in self._due_s:
                self._due_s[vessel.mmsi] = t_s + self._random.uniform(0.0, vessel.report_s)
                self._static_due_s[vessel.mmsi] = self._due_s[vessel.mmsi] + 1.0
            if t_s >= self._due_s[vessel.mmsi]:
                self._due_s[vessel.mmsi] += vessel.report_s
                self._send([self.position(vessel, vessel.at(t_s), t_s)], t_s)
            if t_s >= self._static_due_s[vessel.mmsi]:
                self._static_due_s[vessel.mmsi] += _STATIC_S
                self._send(static(vessel), t_s)

    def _send(self, messages: list[Bits], t_s: float) -> None:
        for bits in messages:
            self._sequence = (self._sequence + 1) % 10
            self._port.send(sentences(bits, self._sequence).encode("ascii"), t_s + self._latency_s)

    def position(self, vessel: ScriptedVessel, motion: VesselMotion, t_s: float) -> Bits:
        """Message 1 or 18, with the errors of the vessel's own receiver."""
        gauss = self._random.gauss
        lat_deg, lon_deg = self._frame.to_geodetic(
            motion.north_m + gauss(0.0, _POSITION_M), motion.east_m + gauss(0.0, _POSITION_M)
        )
        speed = round(max(0.0, motion.speed_mps + gauss(0.0, _SPEED_MPS)) * KNOTS_PER_MPS * 10.0)
        course = round(math.degrees(motion.course_rad + gauss(0.0, _COURSE_RAD)) * 10.0) % 3600
        heading = round(math.degrees(motion.course_rad)) % 360
        second = int((self._around.epoch_unix_ns // 10**9 + int(t_s)) % 60)
        place: Bits = [(round(lon_deg * 600_000.0), 28), (round(lat_deg * 600_000.0), 27)]
        tail: Bits = [(course, 12), (heading, 9), (second, 6)]
        if vessel.class_a:
            return [
                (1, 6),
                (0, 2),
                (vessel.mmsi, 30),
                (vessel.status, 4),
                (0, 8),
                (speed, 10),
                (1, 1),
                *place,
                *tail,
                (0, 2),
                (0, 3),
                (0, 1),
                (0, 19),
            ]
        return [
            (18, 6),
            (0, 2),
            (vessel.mmsi, 30),
            (0, 8),
            (speed, 10),
            (1, 1),
            *place,
            *tail,
            (0, 2),
            (1, 1),
            (0, 7),
            (0, 20),
        ]


def static(vessel: ScriptedVessel) -> list[Bits]:
    """Message 5, or both parts of message 24; the antenna is amidships."""
    bow, side = round(0.5 * vessel.length_m), round(0.5 * vessel.beam_m)
    stern, starboard = round(vessel.length_m) - bow, round(vessel.beam_m) - side
    size: Bits = [(bow, 9), (stern, 9), (side, 6), (starboard, 6)]
    name, call = _text(vessel.name, 20), _text(f"T{vessel.mmsi % 100000}", 7)
    kind = (37, 8)  # pleasure craft
    if vessel.class_a:
        rest: Bits = [(1, 4), (0, 4), (0, 5), (24, 5), (60, 6), (5, 8), *_text("", 20), (0, 1), (0, 1)]
        return [[(5, 6), (0, 2), (vessel.mmsi, 30), (0, 2), (0, 30), *call, *name, kind, *size, *rest]]
    head: Bits = [(24, 6), (0, 2), (vessel.mmsi, 30)]
    return [[*head, (0, 2), *name, (0, 8)], [*head, (1, 2), kind, *_text("", 7), *call, *size, (0, 6)]]


def _text(text: str, length: int) -> Bits:
    padded = text.upper()[:length].ljust(length, "@")
    return [(max(0, _LETTERS.find(letter)), 6) for letter in padded]


def sentences(bits: Bits, sequence: int) -> str:
    """The bits as VDM sentences of channel A, as many as needed. Negative values are two's complements."""
    digits = "".join(format(value & ((1 << width) - 1), f"0{width}b") for value, width in bits)
    fill = -len(digits) % 6
    digits += "0" * fill
    values = [int(digits[i : i + 6], 2) for i in range(0, len(digits), 6)]
    payload = "".join(chr(value + 48 if value < 40 else value + 56) for value in values)
    parts = [payload[i : i + _PAYLOAD] for i in range(0, len(payload), _PAYLOAD)]
    number = "" if len(parts) == 1 else str(sequence)
    lines = []
    for i, part in enumerate(parts, start=1):
        body = f"AIVDM,{len(parts)},{i},{number},A,{part},{fill if i == len(parts) else 0}"
        lines.append(f"!{body}*{checksum_text(body)}\r\n")
    return "".join(lines)

"""Two messages of `microcontroller_frame` for outputs beside the thrusters: their bodies after version and type.

Type 5, AUXILIARY, host → board, once a control step, if the host's vessel has such outputs:

    2      sequence  u8    counts up by one, wraps
    3      relays    u16   bit i: relay i is on; bits from n are 0
    5      n         u8    relays, 0…16
    6      m         u8    servos, 0…16
    7+2i   pulse     u16   µs of servo i, 500…2500; 0: no pulses

    A board switches its relays off and stops its pulses unless the last valid AUXILIARY is less than 0.5 s old. A
    message for other numbers of outputs than the board has is not valid. The board does not check whether the boat is
    armed: the host decides that.

Type 6, AUXILIARY_STATUS, board → host, with each STATUS after the first AUXILIARY: the same fields, with the true state
of the outputs.

Version 1 of the frame gained both after types 1 to 4. A board without them ignores them as unknown types; a host learns
from the missing answers that its board lacks these outputs.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass

MAX_OUTPUTS = 16
AUXILIARY, AUXILIARY_STATUS = 5, 6
_SHORTEST_US, _LONGEST_US = 500, 2500
_HEAD = struct.Struct("<BHBB")


@dataclass(frozen=True, slots=True)
class AuxiliaryDemand:
    """AUXILIARY: the demanded outputs. Pulse widths in µs, None for no pulses."""

    sequence: int
    servos_us: tuple[float | None, ...]
    relays: tuple[bool, ...]


@dataclass(frozen=True, slots=True)
class AuxiliaryState:
    """AUXILIARY_STATUS: the true outputs. `sequence` is that of the last valid AUXILIARY."""

    sequence: int
    servos_us: tuple[float | None, ...]
    relays: tuple[bool, ...]


def encode_outputs(message: AuxiliaryDemand | AuxiliaryState) -> bytes:
    """The body of the message. Pulses out of range are limited, NaN becomes no pulses. Raises ValueError for more than
    16 of a kind."""
    if max(len(message.servos_us), len(message.relays)) > MAX_OUTPUTS:
        raise ValueError(
            f"{len(message.servos_us)} servos and {len(message.relays)} relays; a frame holds {MAX_OUTPUTS} of each"
        )
    bits = sum(on << i for i, on in enumerate(message.relays))
    pulses = [_pulse(pulse_us) for pulse_us in message.servos_us]
    return _HEAD.pack(message.sequence & 0xFF, bits, len(message.relays), len(pulses)) + struct.pack(
        f"<{len(pulses)}H", *pulses
    )


def decode_outputs(kind: int, body: bytes) -> AuxiliaryDemand | AuxiliaryState | None:
    """The message in a body of type `kind`; None for an invalid one."""
    if len(body) < _HEAD.size:
        return None
    sequence, bits, relays, servos = _HEAD.unpack_from(body)
    if max(relays, servos) > MAX_OUTPUTS or len(body) != _HEAD.size + 2 * servos or bits >> relays:
        return None
    pulses = struct.unpack_from(f"<{servos}H", body, _HEAD.size)
    if not all(pulse == 0 or _SHORTEST_US <= pulse <= _LONGEST_US for pulse in pulses):
        return None
    maker = AuxiliaryDemand if kind == AUXILIARY else AuxiliaryState
    return maker(
        sequence,
        tuple(float(pulse) if pulse else None for pulse in pulses),
        tuple(bool(bits >> i & 1) for i in range(relays)),
    )


def _pulse(pulse_us: float | None) -> int:
    if pulse_us is None or math.isnan(pulse_us):
        return 0
    return round(min(_LONGEST_US, max(_SHORTEST_US, pulse_us)))

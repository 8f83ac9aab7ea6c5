"""What must be true of the port of an SBUS receiver."""

from __future__ import annotations

from companion.config.devices import SensorConfig
from companion.config.kinds import Place, Problem

_SERIAL = "serial:"
_SETTINGS = ("parity=even", "stopbits=2")


def sbus_problems(row: SensorConfig, at: Place) -> list[Problem]:
    """SBUS has even parity and two stop bits; as any other line it is nonsense."""
    if not row.port.startswith(_SERIAL) or all(setting in row.port for setting in _SETTINGS):
        return []
    return [((*at, "port"), "SBUS needs even parity and two stop bits: end it with :100000?parity=even&stopbits=2")]

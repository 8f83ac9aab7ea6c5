"""The light beacon (ReVolt thesis, table 6.4): it shows people on the shore the state of the boat."""

from __future__ import annotations

from collections.abc import Sequence

from companion.core.actuation import Beacon, Light, ThrusterCondition
from companion.core.decision import ModeId, Status
from companion.core.tick import DeviceHealth

CAPSIZED = "capsized"  # the failsafe of that name


def beacon(
    status: Status, wet: bool, health: Sequence[DeviceHealth], conditions: Sequence[ThrusterCondition]
) -> Beacon:
    """Red steady: water in the hull, or capsized. Yellow steady: Manual; blinking: any other mode. Green blinking: no
    error; steady: a failsafe lasts, a device is not ok, or a thruster has failed.

    Yellow shows the chosen mode also while disarmed: a dark lamp may be broken, so it must not mean "safe".
    """
    well = not status.failsafes and ThrusterCondition.FAILED not in conditions
    if well:
        for device in health:
            if not device.ok:
                well = False
                break
    return Beacon(
        red=Light.STEADY if wet or CAPSIZED in status.failsafes else Light.OFF,
        yellow=Light.STEADY if status.mode is ModeId.MANUAL else Light.BLINK,
        green=Light.BLINK if well else Light.STEADY,
    )

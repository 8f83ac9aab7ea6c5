"""The light beacon (ReVolt thesis, table 6.4): what people on the shore are shown of the boat."""

from __future__ import annotations

from collections.abc import Sequence

from companion.core.types import Beacon, Condition, DeviceHealth, Light, ModeId, Status


def beacon(status: Status, wet: bool, health: Sequence[DeviceHealth], conditions: Sequence[Condition]) -> Beacon:
    """Red steady: water in the hull. Yellow steady: Manual; blinking: any other mode. Green blinking: all is well; steady: an error, which
    is a failsafe, a device that is not well or a thruster that has failed.

    Yellow shows the mode chosen also while disarmed: a dark lamp may be broken, and must never be what says that it is safe.
    """
    well = not status.failsafes and Condition.FAILED not in conditions
    if well:
        for device in health:
            if not device.ok:
                well = False
                break
    return Beacon(
        red=Light.STEADY if wet else Light.OFF,
        yellow=Light.STEADY if status.mode is ModeId.MANUAL else Light.BLINK,
        green=Light.BLINK if well else Light.STEADY,
    )

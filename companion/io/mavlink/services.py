"""The table of services that a vessel offers to ground stations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from companion.io.mavlink.commands import CommandService
from companion.io.mavlink.ftp_service import FtpService
from companion.io.mavlink.inputs import InputService
from companion.io.mavlink.mission_service import MissionService
from companion.io.mavlink.parameter_service import ParameterService

if TYPE_CHECKING:
    from companion.io.mavlink.hub import Hub, Service


def default_services(hub: Hub) -> Sequence[Service]:
    """One of each."""
    vessel = hub.vessel
    return (
        CommandService(hub, vessel),
        InputService(hub, vessel),
        MissionService(hub, vessel),
        ParameterService(hub, vessel),
        FtpService(hub),
    )

"""The table of services that a vessel offers to ground stations, and the hub that carries them."""

from __future__ import annotations

from collections.abc import Sequence

from companion.io.corrections import CorrectionsRelay
from companion.io.mavlink.commands import CommandService
from companion.io.mavlink.ftp_service import FtpService
from companion.io.mavlink.hub import Ear, Hub, Service, Tap
from companion.io.mavlink.inputs import InputService
from companion.io.mavlink.links import Link
from companion.io.mavlink.mission_service import MissionService
from companion.io.mavlink.parameter_service import ParameterService
from companion.io.mavlink.rtcm_service import RtcmService
from companion.io.mavlink.telemetry import Telemetry
from companion.io.mavlink.vessel import VesselFace


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


def connect(
    vessel: VesselFace,
    links: Sequence[Link],
    version: str,
    tap: Tap | None = None,
    ear: Ear | None = None,
    patience: float = 1.0,
    relay: CorrectionsRelay | None = None,
) -> Hub:
    """The ground stations' side of a vessel, whole. `tap`, `ear`, `patience`: see Hub; `relay`: takes the corrections that stations send."""

    def services(hub: Hub) -> Sequence[Service]:
        return default_services(hub) if relay is None else (*default_services(hub), RtcmService(relay))

    return Hub(vessel, links, version, telemetry=Telemetry, services=services, tap=tap, ear=ear, patience=patience)

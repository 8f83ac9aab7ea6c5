"""The table of services that a vessel offers to ground stations, and the hub that carries them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from companion.io.corrections import CorrectionsRelay
from companion.io.mavlink.commands import CommandService
from companion.io.mavlink.component_metadata import metadata
from companion.io.mavlink.disk_files import Shelf
from companion.io.mavlink.file_tree import FileTree
from companion.io.mavlink.ftp_service import FtpService
from companion.io.mavlink.hub import COMPONENT, Ear, Hub, Service, Tap
from companion.io.mavlink.inputs import InputService
from companion.io.mavlink.leader import LeaderService
from companion.io.mavlink.links import Link
from companion.io.mavlink.log_service import LogService
from companion.io.mavlink.mission_service import MissionService
from companion.io.mavlink.offboard_service import OffboardService
from companion.io.mavlink.operator_service import OperatorService
from companion.io.mavlink.operators import REQUEST_OPERATOR_CONTROL
from companion.io.mavlink.parameter_service import ParameterService
from companion.io.mavlink.rtcm_service import RtcmService
from companion.io.mavlink.signing import Signing
from companion.io.mavlink.signing_service import SigningService
from companion.io.mavlink.telemetry import Telemetry
from companion.io.mavlink.vessel import VesselFace


def default_services(hub: Hub, logs: Path | None = None) -> Sequence[Service]:
    """One of each. `logs`: the directory of the log folders."""
    vessel = hub.vessel
    described = metadata(vessel.parameters)
    operators = OperatorService(hub, vessel)
    shelf = None if logs is None else Shelf(logs)
    tree = FileTree(vessel, hub.system, COMPONENT, described, shelf)
    return (
        CommandService(hub, vessel, described, {REQUEST_OPERATOR_CONTROL: operators.carry_out}),
        operators,
        InputService(hub, vessel),
        MissionService(hub, vessel),
        ParameterService(hub, vessel),
        FtpService(hub, tree),
        LogService(hub, shelf),
        LeaderService(hub, vessel),
        OffboardService(hub, vessel),
    )


def connect(
    vessel: VesselFace,
    links: Sequence[Link],
    version: str,
    tap: Tap | None = None,
    ear: Ear | None = None,
    patience: float = 1.0,
    logs: Path | None = None,
    relay: CorrectionsRelay | None = None,
    signing: Signing | None = None,
) -> Hub:
    """The ground stations' side of a vessel, whole. `tap`, `ear`, `patience`: see Hub; `logs`: the directory of the log folders; `relay`: takes
    the corrections that stations send; `signing`: has the key, None for a vessel that takes none."""

    def services(hub: Hub) -> Sequence[Service]:
        more: list[Service] = [] if relay is None else [RtcmService(relay)]
        if signing is not None:
            more.append(SigningService(hub, vessel, signing))
        return (*default_services(hub, logs), *more)

    return Hub(vessel, links, version, telemetry=Telemetry, services=services, tap=tap, ear=ear, patience=patience, signing=signing)

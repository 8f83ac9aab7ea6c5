"""The services that a vessel offers to ground stations, and the hub that carries them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from companion.io.corrections import CorrectionsRelay
from companion.io.mavlink.commands.service import CommandService
from companion.io.mavlink.services.corrections import RtcmService
from companion.io.mavlink.services.inputs import InputService
from companion.io.mavlink.services.leader import LeaderService
from companion.io.mavlink.services.offboard import OffboardService
from companion.io.mavlink.services.operator_control import OperatorService
from companion.io.mavlink.services.signing_setup import SigningService
from companion.io.mavlink.telemetry.streams import Telemetry
from companion.io.mavlink.transfer.component_metadata import metadata
from companion.io.mavlink.transfer.disk_files import LogStore
from companion.io.mavlink.transfer.file_tree import FileTree
from companion.io.mavlink.transfer.ftp_service import FtpService
from companion.io.mavlink.transfer.log_service import LogService
from companion.io.mavlink.transfer.mission_service import MissionService
from companion.io.mavlink.transfer.parameter_service import ParameterService
from companion.io.mavlink.wire.actions import REQUEST_OPERATOR_CONTROL
from companion.io.mavlink.wire.hub import COMPONENT, NO_COPIES, Copies, Hub, Service
from companion.io.mavlink.wire.links import Link
from companion.io.mavlink.wire.signing import Signing
from companion.loop import Vessel


def default_services(hub: Hub, logs: Path | None = None) -> Sequence[Service]:
    """One service of each kind. `logs`: the directory of the log folders; None where nothing is logged."""
    vessel = hub.vessel
    described = metadata(vessel.parameters)
    operators = OperatorService(hub, vessel)
    store = None if logs is None else LogStore(logs)
    tree = FileTree(vessel, hub.system, COMPONENT, described, store)
    return (
        CommandService(hub, vessel, described, {REQUEST_OPERATOR_CONTROL: operators.carry_out}),
        operators,
        InputService(hub, vessel),
        MissionService(hub, vessel),
        ParameterService(hub, vessel),
        FtpService(hub, tree),
        LogService(hub, store),
        LeaderService(hub, vessel),
        OffboardService(hub, vessel),
    )


def connect(
    vessel: Vessel,
    links: Sequence[Link],
    version: str,
    copies: Copies = NO_COPIES,
    patience: float = 1.0,
    logs: Path | None = None,
    relay: CorrectionsRelay | None = None,
    signing: Signing | None = None,
) -> Hub:
    """The hub of a vessel with all its services. `copies`, `patience`: see Hub. `logs`: the directory of the log
    folders. `relay`: takes the corrections that ground stations send. `signing`: has the key; None: signatures are
    not used."""

    def services(hub: Hub) -> Sequence[Service]:
        more: list[Service] = [] if relay is None else [RtcmService(relay)]
        if signing is not None:
            more.append(SigningService(hub, vessel, signing))
        return (*default_services(hub, logs), *more)

    return Hub(
        vessel,
        links,
        version,
        telemetry=Telemetry,
        services=services,
        copies=copies,
        patience=patience,
        signing=signing,
    )

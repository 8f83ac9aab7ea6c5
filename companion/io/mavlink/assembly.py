"""The services that a vessel offers to ground stations, and the hub that carries them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from companion.config.vessel import VesselConfig
from companion.io.corrections import CorrectionsRelay
from companion.io.mavlink.commands.service import CommandService
from companion.io.mavlink.services.arming import ArmingService
from companion.io.mavlink.services.calibration import CalibrationService
from companion.io.mavlink.services.corrections import RtcmService
from companion.io.mavlink.services.events import EventBuffer, EventService
from companion.io.mavlink.services.inputs import InputService
from companion.io.mavlink.services.introduction import IntroductionService
from companion.io.mavlink.services.leader import LeaderService
from companion.io.mavlink.services.offboard import OffboardService
from companion.io.mavlink.services.operator_control import OperatorService
from companion.io.mavlink.services.payload import PayloadService
from companion.io.mavlink.services.ranges import RangeService
from companion.io.mavlink.services.shell import ShellService
from companion.io.mavlink.services.signing_setup import SigningService
from companion.io.mavlink.telemetry.arming_events import ArmingEvents
from companion.io.mavlink.telemetry.streams import Telemetry
from companion.io.mavlink.transfer.component_metadata import Descriptions
from companion.io.mavlink.transfer.disk_files import LogStore
from companion.io.mavlink.transfer.file_tree import FileTree
from companion.io.mavlink.transfer.ftp_service import FtpService
from companion.io.mavlink.transfer.log_service import LogService
from companion.io.mavlink.transfer.mission_service import MissionService
from companion.io.mavlink.transfer.parameter_service import ParameterService
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.actions import DO_SEND_BANNER, REQUEST_OPERATOR_CONTROL
from companion.io.mavlink.wire.hub import COMPONENT, NO_COPIES, Copies, Hub, Service
from companion.io.mavlink.wire.links import Link
from companion.io.mavlink.wire.signing import Signing
from companion.loop import Vessel


def default_services(hub: Hub, logs: Path | None = None) -> Sequence[Service]:
    """One service of each kind. `logs`: the log folder of this run, with the others beside it; None where nothing is
    logged."""
    vessel = hub.vessel
    named = ArmingEvents(*_names(vessel.config))
    described = Descriptions(vessel.parameters, named, vessel.config.thrusters)
    operators, events = OperatorService(hub, vessel), EventService(hub, EventBuffer())
    arming, payload = ArmingService(hub, vessel, events, named), PayloadService(hub, vessel)
    introduction = IntroductionService(hub, vessel)
    elsewhere = {
        REQUEST_OPERATOR_CONTROL: operators.carry_out,
        mavlink.MAV_CMD_RUN_PREARM_CHECKS: arming.run_checks,
        DO_SEND_BANNER: introduction.banner,
        **payload.commands,
    }
    store = None if logs is None else LogStore(logs.parent, logs.name)
    tree = FileTree(vessel, hub.system, COMPONENT, described, store)
    return (
        CommandService(hub, vessel, described, elsewhere),
        operators,
        events,
        arming,
        payload,
        introduction,
        InputService(hub, vessel),
        MissionService(hub, vessel),
        ParameterService(hub, vessel),
        FtpService(hub, tree),
        LogService(hub, vessel, store),
        LeaderService(hub, vessel),
        OffboardService(hub, vessel),
        RangeService(hub, vessel),
        CalibrationService(hub, vessel),
        ShellService(hub, vessel),
    )


def _names(config: VesselConfig) -> tuple[list[str], list[str]]:
    """Names of the devices that arming looks at, and of the thrusters."""
    sources = [f"corrections_{number}" for number, _ in enumerate(config.corrections, start=1)]
    devices = [*(row.name for row in config.sensors), *sources, *(row.name for row in config.actuators)]
    return devices, [row.name for row in config.thrusters]


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
    """The hub of a vessel with all its services. `copies`, `patience`: see Hub. `logs`: as for `default_services`.
    `relay`: takes the corrections that ground stations send. `signing`: has the key; None: signatures are
    not used."""

    def services(hub: Hub) -> Sequence[Service]:
        more: list[Service] = [] if relay is None else [RtcmService(relay, lambda: vessel.supervisor.following.module)]
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

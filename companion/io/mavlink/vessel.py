"""What the MAVLink side needs of a vessel: the face that ground stations' requests are turned to."""

from __future__ import annotations

from typing import Any, Protocol

from companion.config import VesselConfig
from companion.core.geodesy import LocalFrame
from companion.core.types import Home, ManualInput, ModeId, Outcome, Status, Tick
from companion.mission.plan import Plans
from companion.mission.tasks import AuxiliaryAction
from companion.modes.events import EventLog
from companion.params import Parameters


class ModeFace(Protocol):
    """One mode that the vessel offers, in display order. `by_stick`: steered by hand; `text`: what it does on this boat."""

    @property
    def id(self) -> ModeId: ...

    @property
    def selectable(self) -> bool: ...

    @property
    def by_stick(self) -> bool: ...

    @property
    def text(self) -> str: ...


class AuxiliaryFace(Protocol):
    """Servo and relay outputs."""

    def request(self, action: AuxiliaryAction, now_s: float) -> Outcome: ...


class SupervisorFace(Protocol):
    """Requests to the supervisor; each is answered with what became of it and, where refused, why."""

    @property
    def version(self) -> int:
        """Changes whenever mode or arming do."""
        ...

    @property
    def modes(self) -> tuple[ModeFace, ...]: ...

    @property
    def auxiliary(self) -> AuxiliaryFace: ...

    def request_mode(self, mode: ModeId, now_s: float) -> Outcome: ...

    def arm(self, now_s: float, force: bool = False) -> Outcome: ...

    def disarm(self, now_s: float, force: bool = False) -> Outcome: ...

    def go_to(self, lat_deg: float, lon_deg: float, yaw_rad: float | None, speed_mps: float | None, now_s: float) -> Outcome: ...

    def hold_here(self, now_s: float) -> Outcome: ...

    def nudge(self, forward_m: float, starboard_m: float, turn_rad: float, now_s: float) -> Outcome: ...

    def set_heading(self, yaw_rad: float, now_s: float) -> Outcome: ...

    def start_mission(self, first: int | None, now_s: float) -> Outcome: ...

    def pause(self, now_s: float) -> Outcome: ...

    def resume(self, now_s: float) -> Outcome: ...

    def set_current(self, seq: int, reset: bool, now_s: float) -> Outcome: ...

    def change_speed(self, speed_mps: float | None, now_s: float) -> Outcome: ...

    def set_home(self, home: Home | None, now_s: float) -> Outcome: ...

    def manual_input(self, manual: ManualInput) -> None: ...

    def station_heard(self, system_id: int, now_s: float) -> None: ...

    def status(self, now_s: float) -> Status: ...

    def terminate(self, now_s: float) -> Outcome: ...


class VesselFace(Protocol):
    """The vessel as the hub and its services see it (`companion.loop.Vessel`)."""

    @property
    def config(self) -> VesselConfig: ...

    @property
    def parameters(self) -> Parameters: ...

    @property
    def plans(self) -> Plans: ...

    @property
    def executor(self) -> Any: ...

    @property
    def events(self) -> EventLog: ...

    @property
    def supervisor(self) -> SupervisorFace: ...

    @property
    def last_tick(self) -> Tick | None: ...

    @property
    def frame(self) -> LocalFrame | None: ...

    def request_restart(self) -> None: ...

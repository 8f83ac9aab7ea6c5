"""Cameras and gimbals: what missions and operators ask of them, and the pictures that are taken."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

from companion.config.outputs import RelayConfig, ServoConfig
from companion.config.payload import CameraConfig
from companion.config.vessel import VesselConfig
from companion.core.decision import ACCEPTED, Outcome, Result, TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.core.payload import Forward, PayloadPart, Shot
from companion.mission.commands import Command, name_of
from companion.mission.payload import payload_of
from companion.mission.plan import Adopt, PlanItem, PlanKind, Plans, item_number
from companion.mission.survey import Survey, has_payload, survey_of, without_camera
from companion.mission.tasks import (
    ByDistance,
    ByTime,
    CameraAction,
    PayloadAction,
    StopPictures,
    TakePicture,
    TriggerAsBefore,
    TriggerControl,
)
from companion.nav.lever_arms import quaternion_of, rotate, rotation
from companion.params.store import Parameters
from companion.payload.odometer import Odometer
from companion.payload.trigger import CameraTrigger
from companion.supervisor.outputs import AuxiliaryOutputs

_SAME_REQUEST_S = 5.0  # within it, a request with the same sequence number is a repetition
_STILL_MODES = (0.0, 2.0)  # CAMERA_MODE: image, survey

Output = ServoConfig | RelayConfig
Press = tuple[Output, float | bool]

PRESSES: Mapping[str, Callable[[CameraConfig, VesselConfig], Press | None]] = {
    "relay": lambda camera, config: (next(row for row in config.relays if row.name == camera.relay), True),
    "servo": lambda camera, config: (
        next(row for row in config.servos if row.name == camera.servo),
        camera.press_us or 0.0,
    ),
    "mavlink": lambda camera, config: None,  # told over its link
}
"""What takes a picture: the output and its value, by kind of camera. One row a kind."""


@dataclass(slots=True)
class _Camera:
    """One camera of the vessel's file."""

    config: CameraConfig
    press: Press | None
    trigger: CameraTrigger
    number: int = 0  # of the last picture
    told: bool = False  # that pictures were left out
    sequence: tuple[int, float] = (0, -math.inf)  # of the last request, and when it came
    switched: bool = False  # its series, by a mission


@dataclass(frozen=True, slots=True)
class _PlanContent:
    """What a mission has for cameras and gimbals. `items`: the mission."""

    items: tuple[PlanItem, ...]
    any: bool = False
    survey: Survey | None = None
    passed_on: tuple[Forward, ...] = ()
    without_camera: str | None = None


def _content_of(items: tuple[PlanItem, ...], cruise_mps: float) -> _PlanContent:
    """Looks at every item, so of a long mission not within a tick."""
    if not has_payload(items):
        return _PlanContent(items)
    passed_on = tuple(action for action in map(payload_of, items) if isinstance(action, Forward))
    return _PlanContent(items, True, survey_of(items, cruise_mps), passed_on, without_camera(items))


class Payload:
    """`request(action, now_s)` → Outcome; `update(nav, armed, mission_runs, now_s, dt_s)` once a tick, then
    `take_shots` and `take_forwards`. None of it raises.

    Remembers the cameras' triggers, the way sailed, the components heard on the links, and what has been said.
    """

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        plans: Plans,
        auxiliary: AuxiliaryOutputs,
        events: EventLog,
        frame_of: Callable[[], LocalFrame],
    ) -> None:
        """`frame_of()`: the local plane of the estimate."""
        self._cameras = tuple(
            _Camera(row, PRESSES[row.kind](row, config), CameraTrigger(row.interval_s)) for row in config.cameras
        )
        self._parameters, self._plans, self._auxiliary = parameters, plans, auxiliary
        self._events, self._frame_of = events, frame_of
        self._odometer = Odometer()
        self._heard: dict[PayloadPart, frozenset[int]] = dict.fromkeys(PayloadPart, frozenset())
        self._shots: list[Shot] = []
        self._forwards: list[Forward] = []
        self._count = 0  # pictures of all cameras
        self._of_mission = 0  # since the mission began
        self._said: set[str] = set()  # refusals of the present mission
        self._new_plan = False
        self._content = _PlanContent(())  # of the mission that was prepared last
        plans.prepare_by(PlanKind.MISSION, self._prepare)
        plans.on_change(self._on_change)

    def hear(self, cameras: Collection[int], gimbals: Collection[int]) -> None:
        """The components of the boat's own system that are heard on the links now."""
        self._heard = {PayloadPart.CAMERA: frozenset(cameras), PayloadPart.GIMBAL: frozenset(gimbals)}

    def component(self, part: PayloadPart, asked: int) -> int | None:
        """The component that a command is passed on to: the one asked for, 0 for the first; None where there is
        none."""
        heard = self._heard[part]
        if asked:
            return asked if asked in heard else None
        configured = [camera.config.component for camera in self._cameras] if part is PayloadPart.CAMERA else []
        return next((one for one in (*configured, *sorted(heard)) if one in heard), None)

    # --- requests --------------------------------------------------------------------------------------------------

    def request(self, action: PayloadAction, now_s: float, by_mission: bool = False) -> Outcome:
        """Carry out an action. A refusal of a mission's item is an event; it is said once a mission."""
        if isinstance(action, Forward):
            outcome = self._pass_on(action)
        else:
            outcome = self._carry_out(action, now_s, by_mission)
        if by_mission and not outcome.accepted and outcome.reason not in self._said:
            self._said.add(outcome.reason)
            self._events.say(now_s, TextKind.REFUSAL, "payload_refused", outcome.reason)
        return outcome

    def mission_ended(self, now_s: float) -> None:
        """Its pictures end with it."""
        for camera in self._cameras:
            camera.trigger.stop(by_mission=True)
        if self._of_mission:
            self._events.say(now_s, TextKind.ROUTINE, "pictures_taken", f"Mission took {self._of_mission} pictures")
        self._of_mission = 0

    def _pass_on(self, action: Forward) -> Outcome:
        """Hand a command of a mission to the links."""
        if (reason := self.lacking(action)) is not None:
            return Outcome(Result.DENIED, reason) if reason else ACCEPTED
        self._forwards.append(action)
        return ACCEPTED

    def lacking(self, action: Forward) -> str | None:
        """Why a command cannot be passed on; "" where nothing need be done, None where it can."""
        if self.component(action.part, action.component) is not None:
            return None
        still = action.command == Command.SET_CAMERA_MODE and action.params[1] in _STILL_MODES
        if still and any(camera.press is not None for camera in self._cameras):
            return ""  # a shutter on a wire knows nothing else
        named = f"{action.part.value} {action.component}" if action.component else action.part.value
        where = f"Item {item_number(action.seq)} " if action.seq >= 0 else ""
        return f"{where}{name_of(action.command)}: no {named} on a link"

    def _carry_out(self, action: CameraAction, now_s: float, by_mission: bool) -> Outcome:
        if isinstance(action, TriggerAsBefore):
            return self._as_before(action, now_s)
        cameras = self._meant(getattr(action, "camera", 0))
        if isinstance(cameras, str):
            return Outcome(Result.DENIED, cameras)
        if isinstance(action, StopPictures | TriggerControl) or (isinstance(action, ByDistance) and not action.at_once):
            reason = None  # nothing moves now
        else:
            reason = next((text for camera in cameras if (text := self._unready(camera)) is not None), None)
        if reason is not None:
            return Outcome(Result.TEMPORARILY_REJECTED, reason)
        for camera in cameras:
            self._set(camera, action, now_s, by_mission)
        self._say_series(action, cameras, now_s, by_mission)
        return ACCEPTED

    def _meant(self, number: int) -> Sequence[_Camera] | str:
        """The cameras that a request is for, or why there is none."""
        count = len(self._cameras)
        if not count:
            return "No camera: add [[camera]] to the vessel file"
        if number == 0:
            return self._cameras
        if number > count:
            return f"No camera {number}: this boat has {'1' if count == 1 else f'1 to {count}'}"
        return self._cameras[number - 1 : number]

    def _unready(self, camera: _Camera) -> str | None:
        """Why the camera cannot take a picture now."""
        config = camera.config
        if camera.press is not None:
            return self._auxiliary.pulse_refusal(camera.press[0])
        if config.component not in self._heard[PayloadPart.CAMERA]:
            return f"Camera {config.name} (component {config.component}) is not heard"
        return None

    def _set(self, camera: _Camera, action: CameraAction, now_s: float, by_mission: bool) -> None:
        trigger = camera.trigger
        match action:
            case TakePicture(sequence=sequence):
                self._take_once(camera, sequence, now_s)
            case ByDistance(spacing_m=spacing_m, at_once=at_once):
                trigger.stop()
                if at_once:
                    trigger.shoot()
                if spacing_m > 0.0:
                    trigger.by_distance(spacing_m, by_mission)
            case ByTime(interval_s=interval_s, count=count):
                trigger.by_time(interval_s, count, by_mission)
            case StopPictures():
                trigger.stop()
            case TriggerControl():
                self._switch(camera, action)
                camera.switched = by_mission

    @staticmethod
    def _take_once(camera: _Camera, sequence: int, now_s: float) -> None:
        """One picture, unless the request is a repetition."""
        before, at_s = camera.sequence
        if not sequence or sequence != before or now_s - at_s > _SAME_REQUEST_S:
            camera.trigger.shoot()
        camera.sequence = (sequence, now_s)

    def _switch(self, camera: _Camera, action: TriggerControl) -> None:
        camera.trigger.enabled = camera.trigger.enabled if action.enable is None else action.enable
        camera.trigger.paused = camera.trigger.paused if action.pause is None else action.pause
        if action.reset:
            camera.number = 0

    def _say_series(self, action: CameraAction, cameras: Sequence[_Camera], now_s: float, by_mission: bool) -> None:
        """What an operator has begun. A mission has told of its pictures at upload."""
        for camera in cameras:
            camera.told = False
        names = "Cameras" if len(cameras) > 1 else f"Camera {cameras[0].config.name}"
        if by_mission:
            return
        match action:
            case ByDistance(spacing_m=spacing_m) if spacing_m > 0.0:
                text = f"{names}: a picture every {spacing_m:g} m"
            case ByTime(interval_s=interval_s):
                text = f"{names}: a picture every {max(interval_s, cameras[0].config.interval_s):g} s"
            case ByDistance() | StopPictures():
                text = f"{names}: no more pictures"
            case _:
                return
        self._events.say(now_s, TextKind.ROUTINE, "camera", text)

    def _as_before(self, action: TriggerAsBefore, now_s: float) -> Outcome:
        """A mission begins: its own series go on as its items say, those that an operator began go on as they are. What
        an earlier mission has switched off is on again."""
        self._said.clear()
        for camera in self._cameras:
            camera.trigger.stop(by_mission=True)
            if camera.switched:
                camera.trigger.enabled, camera.trigger.paused, camera.switched = True, False, False
        return ACCEPTED if action.trigger is None else self._carry_out(action.trigger, now_s, by_mission=True)

    # --- once a tick -----------------------------------------------------------------------------------------------

    def update(self, nav: NavState, armed: bool, mission_runs: bool, now_s: float, dt_s: float) -> None:
        """Take the pictures that are due."""
        if self._new_plan:
            self._new_plan = False
            self._tell_of_plan(now_s)
        speed_mps = math.hypot(nav.north_mps, nav.east_mps)
        valid = nav.position_valid
        way_m = self._odometer.update(nav.north_m, nav.east_m, speed_mps, dt_s) if valid else self._odometer.lose()
        for number, camera in enumerate(self._cameras, start=1):
            if camera.press is not None and not armed and not camera.press[0].while_disarmed:
                camera.trigger.stop()
            if camera.trigger.update(way_m, speed_mps, now_s, dt_s, mission_runs):
                self._shoot(number, camera, nav, now_s)
                self._of_mission += mission_runs
            self._tell_of_left_out(camera, now_s)

    def take_shots(self) -> tuple[Shot, ...]:
        """The pictures since the last call."""
        shots, self._shots = tuple(self._shots), []
        return shots

    def take_forwards(self) -> tuple[Forward, ...]:
        """The commands of missions to pass on, since the last call."""
        forwards, self._forwards = tuple(self._forwards), []
        return forwards

    def _shoot(self, number: int, camera: _Camera, nav: NavState, now_s: float) -> None:
        if camera.press is not None:
            self._auxiliary.pulse(*camera.press, camera.config.pulse_s, now_s)
        camera.number += 1
        self._count += 1
        self._shots.append(self._shot(number, camera, nav, now_s))

    def _shot(self, number: int, camera: _Camera, nav: NavState, now_s: float) -> Shot:
        """The picture, at the place of the lens."""
        config = camera.config
        lens_m = (config.x_m, config.y_m, config.z_m)
        turned = rotate(rotation(quaternion_of(nav.roll_rad, nav.pitch_rad, nav.yaw_rad)), lens_m)
        lat_deg = lon_deg = math.nan
        if nav.position_valid:
            lat_deg, lon_deg = self._frame_of().to_geodetic(nav.north_m + turned[0], nav.east_m + turned[1])
        return Shot(
            t_s=now_s,
            camera=number,
            name=config.name,
            number=camera.number,
            count=self._count,
            lat_deg=lat_deg,
            lon_deg=lon_deg,
            altitude_m=nav.altitude_m - turned[2],
            roll_rad=nav.roll_rad,
            pitch_rad=nav.pitch_rad,
            yaw_rad=nav.yaw_rad,
            speed_mps=math.hypot(nav.north_mps, nav.east_mps),
            position_accuracy_m=nav.position_accuracy_m,
            heading_accuracy_rad=nav.heading_accuracy_rad,
            component=config.component,
        )

    def _tell_of_left_out(self, camera: _Camera, now_s: float) -> None:
        if camera.trigger.left_out and not camera.told:
            camera.told = True
            text = f"Camera {camera.config.name} is too slow: pictures left out"
            self._events.say(now_s, TextKind.ATTENTION, "pictures_left_out", text)
        camera.trigger.left_out = 0

    # --- plans -----------------------------------------------------------------------------------------------------

    def _on_change(self, kind: PlanKind) -> None:
        self._new_plan = self._new_plan or kind is PlanKind.MISSION

    def _prepare(self, items: Sequence[PlanItem]) -> Callable[[], Adopt]:
        """The work that a new mission needs before it comes into force (`Plans.prepare_by`): a look at its items."""
        kept, cruise_mps = tuple(items), self._parameters["WP_SPEED"]

        def work() -> Adopt:
            content = _content_of(kept, cruise_mps)

            def adopt() -> None:
                self._content = content

            return adopt

        return work

    def _tell_of_plan(self, now_s: float) -> None:
        """What a new mission does with cameras and gimbals, and what it lacks."""
        items = self._plans.items(PlanKind.MISSION)
        if self._content.items is not items:
            self._content = _content_of(items, self._parameters["WP_SPEED"])
        content = self._content
        if not content.any:
            for camera in self._cameras:
                camera.trigger.stop(by_mission=True)
            return
        if content.survey is not None and self._cameras:
            self._events.say(now_s, TextKind.ROUTINE, "survey", content.survey.text)
        for text in self._missing(content):
            self._events.say(now_s, TextKind.ATTENTION, "payload_missing", text)

    def _missing(self, content: _PlanContent) -> list[str]:
        """What the items need and the boat has not, for people."""
        told = [self._unready(camera) for camera in self._cameras if camera.press is None]
        for part in PayloadPart:
            lacks = [text for action in content.passed_on if action.part is part and (text := self.lacking(action))]
            told += [f"{lacks[0]}; {len(lacks) - 1} more" if len(lacks) > 1 else lacks[0]] if lacks else []
        return [text for text in (None if self._cameras else content.without_camera, *told) if text is not None]

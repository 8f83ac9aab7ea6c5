"""Trial: a sea trial by itself, inside a circle that the operator accepts, for `companion identify`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from companion.config.vessel import VesselConfig
from companion.core.decision import KnownRefusal, ModeDeclaration, ModeId, ModeInputs, OrbitState, TextKind
from companion.core.estimate import Contact
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.core.setpoint import NEUTRAL_SETPOINT, Setpoint
from companion.fence.guard import FenceGuard
from companion.modes.mode import Mode
from companion.modes.parts.refusals import FENCE_REFUSALS
from companion.modes.trial.approach import Approach
from companion.modes.trial.circle import TrialCircle
from companion.modes.trial.expectation import expected
from companion.modes.trial.manoeuvres.manoeuvre import Begin, Manoeuvre, Scene
from companion.modes.trial.manoeuvres.motor_check import MotorCheck
from companion.modes.trial.manoeuvres.stopping import Stopping
from companion.modes.trial.programme import programme
from companion.params.store import Parameters
from companion.positioning.hold_point import HoldPoint

COMPLETE = "complete"
"""What `TrialMode.ended` says after the last manoeuvre."""

_CORNERS = 24
_CLEAR_S = 10.0  # without traffic before the trial goes on
_LOOK_S = 60.0  # how far ahead vessels are looked for
_LOST = 1.5  # radii from the centre at which a boat does not come back
_MOST_EXITS = 4  # times that the boat may be carried over the circle before the trial gives up


@dataclass(frozen=True, slots=True)
class TrialOrder:
    """A trial as an operator asks for it: centre where the boat is. `radius_m` None: TRIAL_RADIUS."""

    radius_m: float | None = None

    @property
    def mode(self) -> ModeId:
        """As every order's."""
        return ModeId.TRIAL


class _Phase(Enum):
    APPROACH = "approach"
    RUN = "run"
    PAUSE = "pause"
    STOPPED = "stopped"  # the thrusters are not as the file says: no thrust


class TrialMode(Mode):
    """Carries out the programme, manoeuvre by manoeuvre. Remembers the circle, the programme and where it is in it,
    also after it was left: chosen again in the same circle, it goes on there.
    """

    declaration = ModeDeclaration(
        id=ModeId.TRIAL,
        text="Sea trial inside a circle: motor check and manoeuvres for identification",
        px4=0x040C0000,  # AUTO, sub-mode EXTERNAL2
        rover=30,
        again="nothing changes; a trial that was stopped starts again",
        commands=(31014,),  # USER_5
        refusals=(
            KnownRefusal(
                r"circle of .*", "the circle is too small for this boat", "Set <param>TRIAL_RADIUS</param> larger."
            ),
            KnownRefusal(r"a jet has no way astern", "a water jet cannot do a trial", "Identify it by hand."),
            KnownRefusal(r"a sail has no way astern", "a sailing boat cannot do a trial", "Identify it by hand."),
            *FENCE_REFUSALS,
        ),
    )

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        events: EventLog,
        frame: Callable[[], LocalFrame],
        fence: FenceGuard,
    ) -> None:
        self._config, self._parameters, self._events = config, parameters, events
        self._frame, self._fence = frame, fence
        self._expectation = expected(config)
        self._hold_point = HoldPoint(config, parameters, fence)
        self._circle: TrialCircle | None = None
        self._frame_seen: LocalFrame | None = None
        self._active = False
        self._ended: str | None = None
        self._manoeuvres: tuple[Manoeuvre, ...] = ()
        self._index = 0
        self._phase = _Phase.APPROACH
        self._elapsed_s = self._begun_s = self._clear_s = 0.0
        self._exits = 0
        self._outside = False
        self._approach: Approach | None = None

    # --- choosing --------------------------------------------------------------------------------------------------

    def _radius_m(self, inputs: ModeInputs) -> float:
        order = inputs.order if isinstance(inputs.order, TrialOrder) else TrialOrder()
        return order.radius_m or self._parameters["TRIAL_RADIUS"] or self._expectation.radius_m

    def check(self, inputs: ModeInputs) -> str | None:
        """Refuse a boat without way astern, a circle that is too small, and one that leaves the fence."""
        if self._config.thrusters[0].kind == "jet":
            return "a jet has no way astern"
        if self._config.has_sail:
            return "a sail has no way astern"
        if not inputs.nav.position_valid:
            return None
        radius_m, least_m = self._radius_m(inputs), self._expectation.least_radius_m
        if radius_m < least_m:
            return f"circle of {radius_m:.0f} m: this boat needs {least_m:.0f} m"
        goes_on = self._goes_on(inputs)
        centre = self._circle.centre if goes_on and self._circle else (inputs.nav.north_m, inputs.nav.east_m)
        return self._fence_refusal(centre, self._circle.radius_m if goes_on and self._circle else radius_m)

    def _fence_refusal(self, centre: tuple[float, float], radius_m: float) -> str | None:
        angles = [2.0 * math.pi * k / _CORNERS for k in range(_CORNERS)]
        edge = [(centre[0] + radius_m * math.cos(a), centre[1] + radius_m * math.sin(a)) for a in angles]
        return None if all(self._fence.inside([centre, *edge])) else "way crosses the fence"

    def _goes_on(self, inputs: ModeInputs) -> bool:
        """Whether an interrupted trial goes on: same plane, inside its circle, and no other radius asked for."""
        order = inputs.order if isinstance(inputs.order, TrialOrder) else None
        circle = self._circle
        return (
            circle is not None
            and 0 < self._index < len(self._manoeuvres)
            and self._frame_seen == self._frame()
            and circle.distance_m(inputs.nav) <= circle.radius_m
            and (order is None or order.radius_m in (None, circle.radius_m))
        )

    def chosen_again(self, inputs: ModeInputs) -> bool:
        """Begin anew after the motor check has stopped the trial."""
        return self._phase is _Phase.STOPPED

    def enter(self, inputs: ModeInputs) -> str | None:
        """Begin, or go on with the manoeuvre that was interrupted."""
        if (reason := self.check(inputs)) is not None:
            return reason
        nav, e = inputs.nav, self._expectation
        goes_on = self._goes_on(inputs) and self._phase is not _Phase.STOPPED
        if not goes_on:
            self._circle = TrialCircle((nav.north_m, nav.east_m), self._radius_m(inputs), e)
            self._frame_seen = self._frame()
            self._manoeuvres = programme(e, self._hold_point)
            self._index, self._elapsed_s, self._exits = 0, 0.0, 0
        assert self._circle is not None
        self._approach = Approach(self._circle, e, self._config)
        self._active, self._ended, self._outside = True, None, False
        self._begin_approach(inputs, brakes=self._index > 0)
        what = f"goes on at {self._index + 1}" if goes_on else f"circle of {self._circle.radius_m:.0f} m"
        self._say(inputs, TextKind.ROUTINE, "trial_begins", f"{what}, {self._minutes()}")
        return None

    def resume(self, inputs: ModeInputs) -> str | None:
        """Repeat the manoeuvre that a failsafe interrupted."""
        if not self._active or self._approach is None:
            return self.enter(inputs)
        if self._phase is not _Phase.STOPPED:
            self._begin_approach(inputs, brakes=True)
        return None

    def leave(self) -> None:
        """Stop; the place in the programme is kept."""
        self._active = False

    # --- what others ask -------------------------------------------------------------------------------------------

    @property
    def ended(self) -> str | None:
        """Why the trial is over, so that the boat holds; None while it lasts."""
        return self._ended

    @property
    def orbit(self) -> OrbitState | None:
        """The circle of the trial, for ground stations to draw."""
        if not self._active or self._circle is None:
            return None
        return OrbitState(*self._circle.centre, self._circle.radius_m)

    @property
    def time_left_s(self) -> float | None:
        """Time until the last manoeuvre is over; None while no trial runs."""
        if not self._active or self._ended is not None:
            return None
        e = self._expectation
        ahead = sum(m.expected_s(e) for m in self._manoeuvres[self._index :])
        return max(0.0, min(ahead, self._budget_left_s))

    @property
    def _budget_left_s(self) -> float:
        return self._expectation.budget_s - self._elapsed_s

    def mind_fence(self, inputs: ModeInputs) -> str | None:
        """Stop if the circle leaves the new fence."""
        return None if self._circle is None else self._fence_refusal(self._circle.centre, self._circle.radius_m)

    # --- under way -------------------------------------------------------------------------------------------------

    def update(self, inputs: ModeInputs) -> Setpoint:
        """The setpoint of the manoeuvre, or of the way to its start."""
        circle, approach = self._circle, self._approach
        if circle is None or approach is None or self._ended is not None or self._phase is _Phase.STOPPED:
            return NEUTRAL_SETPOINT
        self._elapsed_s += inputs.dt_s
        if (setpoint := self._mind_traffic(inputs, circle, approach)) is not None:
            return setpoint
        if self._phase is _Phase.RUN:
            setpoint = self._run(inputs, circle)
            if setpoint is not None:
                return setpoint
        return self._come(inputs, circle, approach)

    def _scene(self, inputs: ModeInputs) -> Scene:
        circle = self._circle
        out = 0.0 if circle is None else circle.distance_m(inputs.nav) / circle.radius_m
        return Scene(inputs, inputs.now_s - self._begun_s, self._config, self._expectation, out)

    def _come(self, inputs: ModeInputs, circle: TrialCircle, approach: Approach) -> Setpoint:
        """The way to the start of the next manoeuvre."""
        if self._ended is not None or self._phase is _Phase.STOPPED:
            return NEUTRAL_SETPOINT
        self._count_exits(inputs, circle)
        setpoint = approach.update(inputs.nav, inputs.now_s)
        if setpoint is not None:
            return setpoint
        self._phase, self._begun_s = _Phase.RUN, inputs.now_s
        manoeuvre = self._manoeuvres[self._index]
        manoeuvre.start(self._scene(inputs))
        number = f"{self._index + 1}/{len(self._manoeuvres)}"
        self._say(inputs, TextKind.ROUTINE, "trial_runs", f"{number} {manoeuvre.name}, {self._minutes()}")
        return manoeuvre.update(self._scene(inputs)) or NEUTRAL_SETPOINT

    def _run(self, inputs: ModeInputs, circle: TrialCircle) -> Setpoint | None:
        """The manoeuvre; None: it is over, and the way to the next one begins."""
        manoeuvre, scene = self._manoeuvres[self._index], self._scene(inputs)
        checks = isinstance(manoeuvre, MotorCheck)
        if not checks and circle.leaves(inputs.nav, circle.turning_s):
            if not isinstance(manoeuvre, Stopping):
                self._done(inputs, "at the circle")
                return None
            manoeuvre.cut(scene)
        setpoint = manoeuvre.update(scene)
        if setpoint is None:
            self._done(inputs, "done")
        return setpoint

    def _done(self, inputs: ModeInputs, how: str) -> None:
        """The manoeuvre is over."""
        manoeuvre = self._manoeuvres[self._index]
        number = f"{self._index + 1}/{len(self._manoeuvres)}"
        self._say(inputs, TextKind.ROUTINE, "trial_ran", f"{number} {how}")
        if isinstance(manoeuvre, MotorCheck) and manoeuvre.faults:
            self._phase, self._index = _Phase.STOPPED, 0
            for fault in manoeuvre.faults:
                self._say(inputs, TextKind.ALARM, f"trial_{fault.kind}", fault.text)
            self._say(inputs, TextKind.ALARM, "trial_stopped", "no thrust: correct the file or the wires")
            return
        brakes = manoeuvre.brakes
        self._index += 1
        while self._index < len(self._manoeuvres) and self._left_out(self._index):
            self._say(inputs, TextKind.ATTENTION, "trial_skips", f"no time for {self._manoeuvres[self._index].name}")
            self._index += 1
        if self._index >= len(self._manoeuvres):
            self._say(inputs, TextKind.ROUTINE, "trial_ended", f"complete after {self._elapsed_s / 60.0:.1f} min")
            self._ended = COMPLETE
            return
        self._begin_approach(inputs, brakes)

    def _left_out(self, index: int) -> bool:
        """Whether there is no time for a manoeuvre that can be done without."""
        e, manoeuvre = self._expectation, self._manoeuvres[index]
        vital = sum(m.expected_s(e) for m in self._manoeuvres[index:] if m.vital)
        return not manoeuvre.vital and vital + manoeuvre.expected_s(e) > self._budget_left_s

    def _begin_approach(self, inputs: ModeInputs, brakes: bool) -> None:
        assert self._approach is not None
        self._phase = _Phase.APPROACH
        self._approach.begin(inputs.nav, self._manoeuvres[self._index].begins, brakes, inputs.now_s)

    def _count_exits(self, inputs: ModeInputs, circle: TrialCircle) -> None:
        """Give up after the boat was carried out of the circle several times, or far out: it cannot come back."""
        distance_m = circle.distance_m(inputs.nav)
        outside = distance_m > circle.radius_m
        if outside and not self._outside:
            self._exits += 1
            self._say(inputs, TextKind.ATTENTION, "trial_outside", "outside the circle, coming back")
        self._outside = outside
        if self._exits >= _MOST_EXITS or distance_m > _LOST * circle.radius_m:
            far = distance_m > _LOST * circle.radius_m
            self._ended = "carried far out of the circle" if far else "carried out of the circle again and again"
            self._say(inputs, TextKind.ALARM, "trial_ended", self._ended)

    # --- traffic ---------------------------------------------------------------------------------------------------

    def _mind_traffic(self, inputs: ModeInputs, circle: TrialCircle, approach: Approach) -> Setpoint | None:
        """Stay near the centre while a vessel comes near; None while there is none."""
        near = next((c for c in inputs.contacts if self._comes_near(c, circle)), None)
        if near is not None:
            if self._phase is not _Phase.PAUSE:
                self._phase = _Phase.PAUSE
                approach.begin(inputs.nav, Begin.CENTRE, True, inputs.now_s)
                self._say(inputs, TextKind.ATTENTION, "trial_paused", f"paused: {near.label} comes near")
            self._clear_s = inputs.now_s
        if self._phase is not _Phase.PAUSE:
            return None
        if inputs.now_s - self._clear_s > _CLEAR_S:
            self._say(inputs, TextKind.ROUTINE, "trial_goes_on", f"goes on, {self._minutes()}")
            self._begin_approach(inputs, brakes=True)
            return None
        nav, now_s = inputs.nav, inputs.now_s
        return approach.update(nav, now_s) or approach.towards(nav, (0.0, 0.0), nav.yaw_rad, now_s)

    def _comes_near(self, contact: Contact, circle: TrialCircle) -> bool:
        """Whether the vessel comes nearer than CA_DIST to the circle within `_LOOK_S`."""
        north, east = contact.north_m - circle.centre[0], contact.east_m - circle.centre[1]
        speed2 = contact.north_mps**2 + contact.east_mps**2
        closest_s = 0.0 if speed2 < 1e-6 else -(north * contact.north_mps + east * contact.east_mps) / speed2
        t = min(_LOOK_S, max(0.0, closest_s))
        nearest = math.hypot(north + t * contact.north_mps, east + t * contact.east_mps) - contact.radius_m
        return nearest < circle.radius_m + self._parameters["CA_DIST"]

    # --- texts -----------------------------------------------------------------------------------------------------

    def _minutes(self) -> str:
        return f"{(self.time_left_s or 0.0) / 60.0:.0f} min left"

    def _say(self, inputs: ModeInputs, kind: TextKind, name: str, text: str) -> None:
        self._events.say(inputs.now_s, kind, name, f"Trial: {text}")

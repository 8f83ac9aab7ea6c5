"""One stepper drive of Nanotec's SMCI family (PD2-N, PD4-N, SMCI33 …) that turns a thruster: its next command, and
the meaning of its answers.

Commands and answers (Nanotec, Programming Manual V2.7 for SMCI12, SMCI33, SMCI35, SMCI36, SMCI47-S, SMCP33, PD2-N,
PD4-N, PD6-N; section numbers are its own; the forms of the answers as public drivers of these controllers take them):

    |1        1.6.4   answers on                    p2, p4   1.6.6   absolute positions; run to the reference switch
    J0        1.5.33  no status of itself           s<steps> 1.6.7   target, ±100 000 000
    g<mode>   1.5.6   microsteps a full step        u<Hz> o<Hz> 1.6.8, 1.6.9   frequency at the start, and at most
    W1        1.6.17  one run a start               :accel=<Hz/s> :decel=<Hz/s>   ramps without conversion
    A         1.6.1   start, also towards a new target under way
    S1        1.6.2   stop with the brake ramp
    C         1.5.20  position, "C+1234"            :is_referenced   1.5.21   1 after a reference run since power-up
    $         1.5.22  status: bit 0 ready, bit 1 zero position reached, bit 2 position error; "001$161" with the address
                      in three digits
    E, Z<n>E  1.5.18  index of the newest error; that error
    D[<steps>] 1.5.17 forget the position error; the counter becomes this, or the encoder's position
    Zs        1.1     reads back a setting: after a loss of power it is not what was sent

The closed loop, its currents and the input of the reference switch are what NanoPro, the maker's program, has set up.
"""

from __future__ import annotations

import math
from collections import deque
from enum import Enum

from companion.config.actuators.nanotec import StepperConfig, frequency_problems
from companion.config.devices import ThrusterConfig
from companion.config.vessel import ConfigError
from companion.core.angles import TWO_PI, wrap_pi
from companion.io.actuators.calibration import ThrusterOutput

_LEAST_TURN_RAD = math.radians(0.2)  # demands closer than this to the last one are ignored
_STATUS_PERIOD_S = 0.5
_PROBE_PERIOD_S = 1.0  # how often a drive that does not answer is tried
_UNANSWERED = 3  # in a row: the drive is lost
_CLEAR_AFTER_S = 2.0  # a position error is forgotten, and the turn tried anew
_JUMP_RAD = math.radians(
    10.0
)  # a counter that is so far off after a silence has lost its zero; under way it is a digit that was garbled
_FATAL = ("g", "p", "o")  # settings without which its steps are not what they are taken for
_REBASE_STEPS = 50_000_000  # endless turning: whole turns are taken off the counter long before it ends
_HOMING_TURNS, _HOMING_SPARE_S = 1.5, 5.0
_MOST_ERRORS = 32  # that it remembers
_READY, _ERROR = 0x01, 0x04
_ERRORS = {
    1: "low voltage",
    2: "too hot",
    4: "overcurrent of the output stage",
    8: "its memory is faulty",
    16: "does not follow: blocked, or its encoder",
    32: "internal error",
    128: "output stage",
}


class DrivePhase(Enum):
    """What the drive does; the value is for people."""

    ABSENT = "does not answer"
    SETUP = "is being set up"
    HOMING = "turns to its reference switch"
    RUNNING = "runs"
    ASTRAY = "cannot be used"  # until a person has put it right


class Drive:
    """`demand(azimuth_rad)` or `halt()` once a control step, then `request(now_s)` → the next command, or None. Its
    answer comes back by `answered`, `refused` or `unanswered`.

    Angles in here are the drive's own, unwrapped, with whole turns counted. Remembers what was sent.
    """

    def __init__(self, index: int, thruster: ThrusterConfig, config: StepperConfig) -> None:
        """Raises ConfigError for speeds and ramps that the drive does not have."""
        self.index = index
        self.name = thruster.name
        self.address = config.address
        self.phase = DrivePhase.ABSENT
        self._angle_rad: float | None = None  # where it has turned to; None until it is known
        self.error = ""
        self.known = False  # it has run since the start
        self._output = ThrusterOutput(thruster, pulses=False)
        ends = [self._output.drive_azimuth(stop) for stop in (thruster.azimuth_min_rad, thruster.azimuth_max_rad)]
        stops = sorted(end for end in ends if end is not None)
        self._low_rad, self._high_rad = (stops[0], stops[1]) if len(stops) == 2 else (-math.inf, math.inf)
        self._config = config
        self._steps_per_rad = config.steps_per_turn / TWO_PI
        if problems := frequency_problems(config, thruster):
            raise ConfigError([f"drive {config.address} of {thruster.name}: {key} {text}" for key, text in problems])
        self._speed_hz = config.frequency(config.turning_radps(thruster))
        self._homing_hz = config.frequency(config.homing_radps)
        self._ramp_hzps = config.frequency(config.ramp_radps2)
        self._queue: deque[str] = deque()
        self._demand_rad: float | None = None
        self._sent_rad: float | None = None  # target of the run that was started last
        self._sent_steps: int | None = None
        self._moving = self._want_halt = self._want_position = False
        self._failures = 0
        self._next_probe_s = self._next_status_s = 0.0
        self._next_check = "$"
        self._failed_s: float | None = None
        self._homing_until_s: float | None = None
        self._unseen_rad = 0.0  # how far it may have turned while it did not answer
        self._doubtful_rad: float | None = None
        self._positioned_s = 0.0

    @property
    def ok(self) -> bool:
        """Whether it turns its thruster as it should."""
        return self.phase is DrivePhase.RUNNING and not self.error

    @property
    def azimuth_rad(self) -> float | None:
        """Azimuth of its thruster; None while it is unknown."""
        azimuth_rad = self._output.azimuth(self._angle_rad) if self.phase is DrivePhase.RUNNING else None
        return None if azimuth_rad is None else wrap_pi(azimuth_rad)

    @property
    def trouble(self) -> str:
        """One phrase, or an empty one."""
        if self.phase is not DrivePhase.RUNNING:
            return f"drive {self.address} of {self.name} {self.phase.value}{': ' + self.error if self.error else ''}"
        return f"drive {self.address} of {self.name}: {self.error}" if self.error else ""

    def demand(self, azimuth_rad: float) -> None:
        """Turn the thruster to that azimuth. A number that is not finite is ignored."""
        if math.isfinite(azimuth_rad):
            self._demand_rad, self._want_halt = self._output.drive_azimuth(azimuth_rad), False
        self._want_position = True

    def halt(self) -> None:
        """Stay where it is, with its torque."""
        self._want_halt = self._want_halt or self._moving or self._demand_rad is not None
        self._demand_rad, self._want_position = None, True

    # --- commands ---------------------------------------------------------------------------------------------------

    def request(self, now_s: float) -> str | None:
        """The next command, without address; None while there is nothing to ask."""
        if self.phase is DrivePhase.ABSENT:
            if now_s < self._next_probe_s:
                return None
            self._next_probe_s = now_s + _PROBE_PERIOD_S
            return "$"
        if self._queue:
            return self._queue[0]
        if self.phase is not DrivePhase.RUNNING:
            return self._watch(now_s)
        if self._want_halt:
            return "S1"
        if self._turn():
            return self._queue[0]
        if self._want_position:
            return "C"
        return self._watch(now_s)

    def _watch(self, now_s: float) -> str | None:
        if now_s < self._next_status_s:
            return None
        self._next_status_s = now_s + _STATUS_PERIOD_S
        if self._next_check == "Zs" and self._sent_steps is not None and self.phase is DrivePhase.RUNNING:
            return "Zs"
        return "$"

    def _turn(self) -> bool:
        """Queue a new run where the demand asks for one. Returns whether it did."""
        demand_rad, here_rad = self._demand_rad, self._angle_rad
        if demand_rad is None or here_rad is None or self.error or self._doubtful_rad is not None:
            return False
        target_rad = self._reachable(demand_rad, here_rad)
        if self._sent_rad is not None and abs(target_rad - self._sent_rad) < _LEAST_TURN_RAD:
            return False
        self._sent_rad, self._sent_steps = target_rad, self._steps(target_rad)
        self._queue.extend((f"s{self._sent_steps}", "A"))
        return True

    def _reachable(self, demand_rad: float, here_rad: float) -> float:
        """The nearest turn in that direction, within its stops where it has some."""
        nearest = here_rad + wrap_pi(demand_rad - here_rad)
        turns = [
            turn for turn in (nearest, nearest - TWO_PI, nearest + TWO_PI) if self._low_rad <= turn <= self._high_rad
        ]
        return (
            min(turns, key=lambda turn: abs(turn - here_rad))
            if turns
            else min(self._high_rad, max(self._low_rad, nearest))
        )

    def _begin_setup(self) -> None:
        self.phase, self.error = DrivePhase.SETUP, ""
        if self._sent_rad is not None and self._angle_rad is not None:
            self._unseen_rad = abs(self._sent_rad - self._angle_rad)
        self._sent_rad = self._sent_steps = self._failed_s = self._doubtful_rad = None
        start_hz = max(1, min(self._speed_hz // 20, 160_000))
        ramps = (":ramp_mode=0", f":accel={self._ramp_hzps}", f":decel={self._ramp_hzps}")
        mode = ("|1", "J0", f"g{self._config.step_mode}", "p2", "W1", f"u{start_hz}", f"o{self._speed_hz}")
        self._queue = deque((*mode, *ramps, ":is_referenced" if self._config.homing == "switch" else "C"))

    def _begin_homing(self, now_s: float) -> None:
        self.phase = DrivePhase.HOMING
        self._homing_until_s = now_s + _HOMING_TURNS * TWO_PI / self._config.homing_radps + _HOMING_SPARE_S
        self._queue = deque(("p4", f"o{self._homing_hz}", "A"))
        self._next_status_s = now_s + _STATUS_PERIOD_S

    # --- answers ----------------------------------------------------------------------------------------------------

    def answered(self, command: str, value: int | None, now_s: float) -> bool:
        """It has answered `command`, with `value` where the command asks for a number. Returns whether its azimuth was
        measured."""
        self._failures = 0
        if self.phase is DrivePhase.ABSENT:
            self._begin_setup()
            return False
        if self._queue and command == self._queue[0]:
            self._queue.popleft()
        if command == "C" and value is not None:
            return self._positioned(value, now_s)
        if command == "$" and value is not None:
            self._told(value, now_s)
        elif command == ":is_referenced":
            self._referenced(value == 1, now_s)
        elif command.endswith("E") and value is not None:
            self._error_read(command, value)
        else:
            self._confirmed(command, value)
        return False

    def _confirmed(self, command: str, value: int | None) -> None:
        """A run, a stop, or the target that it reads back."""
        if command == "Zs":
            self._next_check = "$"
            if value != self._sent_steps:
                self._begin_setup()  # it has been without power, and knows neither target nor speeds
        elif command == "A":
            self._moving = True
        elif command == "S1":
            self._moving = self._want_halt = False
            self._sent_rad = None

    def _error_read(self, command: str, value: int) -> None:
        """The index of its newest error (`E`), or that error (`Z<n>E`)."""
        if command == "E" and 1 <= value <= _MOST_ERRORS:
            self._queue.append(f"Z{value}E")
        else:
            self.error = _ERRORS.get(value, f"error {value}")

    def refused(self, command: str, now_s: float) -> None:
        """It does not know `command`, or not that value. Only some settings are needed, since older firmware lacks
        others."""
        self._failures = 0
        if self._queue and command == self._queue[0]:
            self._queue.popleft()
        if command == "C":
            self._want_position = False
        if self.phase is DrivePhase.RUNNING and command[:1] in ("s", "A"):
            self.error, self._failed_s = f"refuses '{command}'", now_s
        elif self.phase is not DrivePhase.RUNNING and command[:1] in _FATAL:
            self.phase, self.error = DrivePhase.ASTRAY, f"refuses '{command}': other firmware, or not this drive"
            self._queue.clear()

    def unanswered(self, now_s: float) -> bool:
        """No answer came in time. Returns whether the drive is lost by that."""
        self._failures += 1
        if self._failures < _UNANSWERED or self.phase is DrivePhase.ABSENT:
            return False
        self.phase = DrivePhase.ABSENT
        self._queue.clear()
        self._moving = self._want_halt = False
        self._next_probe_s = now_s + _PROBE_PERIOD_S
        return True

    def _positioned(self, steps: int, now_s: float) -> bool:
        self._want_position = False
        angle_rad = steps / self._steps_per_rad
        if self.phase is DrivePhase.SETUP:
            self._placed(angle_rad)
        elif self._jumped(angle_rad, now_s):
            self._want_position = True  # once more, at once
            return False
        self._angle_rad, self._positioned_s, self._doubtful_rad = angle_rad, now_s, None
        if abs(steps) > _REBASE_STEPS and not self._moving and self.phase is DrivePhase.RUNNING:
            turns = round(steps / self._config.steps_per_turn)
            rest = steps - round(turns * self._config.steps_per_turn)
            self._queue.extend((f"D{rest}", "C"))
            self._angle_rad = rest / self._steps_per_rad
            self._sent_rad = None
        return self.phase is DrivePhase.RUNNING

    def _placed(self, angle_rad: float) -> None:
        """Its first angle, or that after a silence: the same as before, or it has lost its zero."""
        before = self._angle_rad
        if (
            self._config.homing == "here"
            and before is not None
            and abs(angle_rad - before) > _JUMP_RAD + self._unseen_rad
        ):
            self.phase = DrivePhase.ASTRAY
            self.error = (
                "it lost its angle with its power: put the thruster straight, switch the drive off and on, restart"
            )
        else:
            self.phase, self.known = DrivePhase.RUNNING, True
        self._unseen_rad = 0.0

    def _jumped(self, angle_rad: float, now_s: float) -> bool:
        """Whether it cannot have turned so far since: the line has no checksum. A jump that comes twice is true: it has
        lost its zero."""
        if self._angle_rad is None:
            return False
        reach_rad = _JUMP_RAD + 2.0 * (now_s - self._positioned_s) * self._speed_hz / self._steps_per_rad
        if abs(angle_rad - self._angle_rad) <= reach_rad:
            return False
        if self._doubtful_rad is not None and abs(angle_rad - self._doubtful_rad) <= reach_rad:
            self._begin_setup()
        else:
            self._doubtful_rad = angle_rad
        return True

    def _told(self, status: int, now_s: float) -> None:
        ready = bool(status & _READY)
        self._moving = not ready
        self._next_check = "Zs" if self.phase is DrivePhase.RUNNING and ready else "$"
        if status & _ERROR:
            self._stumbled(now_s)
        elif self.phase is DrivePhase.HOMING and ready:
            self._queue.append(":is_referenced")
        elif self.error and self.phase is DrivePhase.RUNNING:
            self.error, self._failed_s = "", None
            self._sent_rad = None
        if self.phase is DrivePhase.HOMING and self._homing_until_s is not None and now_s > self._homing_until_s:
            self._homing_until_s = math.inf
            self.error = self.error or "no reference switch found"
            self._queue.append("S1")

    def _stumbled(self, now_s: float) -> None:
        """A position error: reported, asked about, and cleared after a while."""
        if self._failed_s is None:
            self._failed_s = now_s
            self.error = "does not follow"
            self._queue.append("E")
        elif now_s - self._failed_s >= _CLEAR_AFTER_S:
            self._failed_s = now_s
            self._sent_rad = None
            self._queue.extend(("D", "A" if self.phase is DrivePhase.HOMING else "C"))

    def _referenced(self, known: bool, now_s: float) -> None:
        if known:
            self.phase, self.error, self._homing_until_s = DrivePhase.SETUP, "", None
            self._queue.extend(("p2", f"o{self._speed_hz}", "C"))
        elif self.phase is DrivePhase.SETUP:
            self._begin_homing(now_s)

    def _steps(self, angle_rad: float) -> int:
        return round(angle_rad * self._steps_per_rad)

"""`companion thruster-test VESSEL`: each thruster in turn, at low power, after a person has said so. Nothing else of the companion runs meanwhile.

The bridges alone are opened, and what goes to them passes the last gate. The steps (`Trial`) are arithmetic on time; `conduct` moves them by a clock.
"""

from __future__ import annotations

import argparse
import math
import select
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from companion.allocation.feedback import ThrusterReports
from companion.config import ThrusterConfig, VesselConfig
from companion.core.ports import Actuator, StreamOpener, WaitingClock, World
from companion.core.types import ZERO_WRENCH, ActuatorCommand, Allocation, ThrusterCommand, ThrusterFeedback
from companion.io.actuators import open_actuator
from companion.safety import Gate

_RAMP_S = 0.5
_SWING_RAD = math.radians(60.0)
_SWING_MOST_S = 30.0
_SWING_DONE_RAD = math.radians(3.0)
_ANSWER_S = 8.0  # for the bridges to be heard
_GOOD_THROTTLE = 0.05
MOST_POWER = 0.3


def add_to(commands: Any, command: Callable[[argparse.Namespace], int]) -> None:
    """`commands` as argparse's `add_subparsers` gives it; `command` composes the vessel, real or simulated."""
    test = commands.add_parser("thruster-test", help="turn each thruster in turn, at low power, after a question for each; the companion itself must not run")
    test.add_argument("vessel", metavar="VESSEL")
    test.add_argument("--sitl", action="store_true", help="with the simulated boat in place of its devices")
    test.add_argument("--thruster", action="append", metavar="NAME", help="only these")
    test.add_argument("--power", type=float, default=0.15, metavar="SHARE", help=f"of full throttle, at most {MOST_POWER:g} (default 0.15)")
    test.add_argument("--seconds", type=float, default=3.0, metavar="S", help="for each direction (default 3)")
    test.add_argument("--yes", action="store_true", help="with --sitl: do not ask")
    test.set_defaults(command=command)


class TrialError(Exception):
    """What cannot be tried, and what to do about it."""


@dataclass(frozen=True, slots=True)
class Demand:
    """What one thruster is told for a while, and what that is called."""

    what: str
    throttle: float
    azimuth_rad: float | None
    duration_s: float
    until_there: bool = False  # over as soon as the azimuth has arrived


def demands(thruster: ThrusterConfig, power: float, seconds: float) -> Iterator[Demand]:
    """The steps of one thruster's trial: azimuth to either side without thrust, then a push ahead, then astern where it can."""
    rest = thruster.azimuth_rad if thruster.turns else None
    if thruster.turns and thruster.azimuth_rate_radps > 0.0:
        low = thruster.azimuth_rad - _SWING_RAD if thruster.azimuth_min_rad is None else max(thruster.azimuth_min_rad, thruster.azimuth_rad - _SWING_RAD)
        high = thruster.azimuth_rad + _SWING_RAD if thruster.azimuth_max_rad is None else min(thruster.azimuth_max_rad, thruster.azimuth_rad + _SWING_RAD)
        for name, target in (("to starboard", high), ("to port", low), ("back", thruster.azimuth_rad)):
            yield Demand(f"azimuth {name}", 0.0, target, _SWING_MOST_S, until_there=True)
    yield Demand("ahead", power, rest, seconds)
    if thruster.min_n < 0.0:
        yield Demand("astern", -power, rest, seconds)


@dataclass(frozen=True, slots=True)
class Finding:
    """What one step showed. `measured`: the throttle that came back at the end, None where the bridge does not tell; `rate_radps` of a swing."""

    what: str
    asked: float
    measured: float | None
    rate_radps: float | None
    ok: bool


class Trial:
    """Moves the thrusters of one vessel through demands. `conduct` per thruster; in between `idle` keeps all neutral and disarmed."""

    def __init__(self, config: VesselConfig, actuators: Sequence[Actuator], clock: WaitingClock, world: World) -> None:
        self._config = config
        self._actuators = actuators
        self._clock = clock
        self._world = world
        self._gate = Gate(config)
        self._period_s = 1.0 / config.control_rate_hz
        self._reports = ThrusterReports(len(config.thrusters))
        self._due_s = clock.now_s()

    def connect(self) -> None:
        """Until every bridge answers, and its drives know their angle. Raises TrialError with what each of the silent ones says."""
        homing_s = [math.tau / drive.homing_radps for bridge in self._config.actuators for drive in bridge.drives if drive.homing == "switch"]
        end_s = self._clock.now_s() + _ANSWER_S + max(homing_s, default=0.0)
        while True:
            self.idle()
            ill = [health for actuator in self._actuators if not (health := actuator.health(self._clock.now_s())).ok]
            if not ill:
                return
            if self._clock.now_s() >= end_s:
                raise TrialError("; ".join(f"{health.name}: {health.text}" for health in ill))

    def idle(self) -> None:
        """One cycle of neutral, disarmed."""
        self._cycle(None, 0.0, None, armed=False, lower=None)

    def conduct(self, index: int, power: float, seconds: float, say: Callable[[str], None]) -> list[Finding]:
        """All steps of one thruster; neutral and disarmed at the end, whatever happens."""
        thruster = self._config.thrusters[index]
        found: list[Finding] = []
        try:
            if thruster.retractable:
                say("  lowering")
                self._for(thruster.travel_s + 1.0, index, 0.0, None, lower=True)
            for demand in demands(thruster, power, seconds):
                found.append(self._swing(index, demand) if demand.until_there else self._push(index, demand))
                say(f"  {_told(found[-1])}")
        finally:
            for _ in range(3):
                self.idle()
        return found

    def _swing(self, index: int, demand: Demand) -> Finding:
        target = demand.azimuth_rad or 0.0
        begun: tuple[float, float] | None = None  # when, and how far there was to go, once it moved
        rate: float | None = None
        end_s = self._clock.now_s() + demand.duration_s
        first = self._reports.newest[index]
        whole = abs(_off(first, target)) if first is not None and first.azimuth_rad is not None else 0.0
        while self._clock.now_s() < end_s:
            self._cycle(index, 0.0, target, armed=True, lower=True)
            report = self._reports.newest[index]
            if report is None or report.azimuth_rad is None:
                return Finding(demand.what, target, None, None, True)
            left = abs(_off(report, target))
            if begun is None and left < 0.9 * whole:
                begun = report.t_s, left
            if begun is not None and left <= 0.1 * whole:
                rate = (begun[1] - left) / max(1e-3, report.t_s - begun[0]) if report.t_s > begun[0] else None
                break
            if left <= _SWING_DONE_RAD:
                break
        report = self._reports.newest[index]
        arrived = report is not None and abs(_off(report, target)) <= max(_SWING_DONE_RAD, 0.11 * whole)
        return Finding(demand.what, target, None, rate, arrived)

    def _push(self, index: int, demand: Demand) -> Finding:
        begin_s = self._clock.now_s()
        measured: float | None = None
        while (t_s := self._clock.now_s() - begin_s) < demand.duration_s:
            share = min(1.0, t_s / _RAMP_S, (demand.duration_s - t_s) / _RAMP_S)
            self._cycle(index, share * demand.throttle, demand.azimuth_rad, armed=True, lower=True)
            report = self._reports.newest[index]
            if report is not None and (share >= 1.0 or measured is None):
                measured = report.throttle
        ok = measured is None or abs(measured - demand.throttle) <= max(_GOOD_THROTTLE, 0.5 * abs(demand.throttle))
        return Finding(demand.what, demand.throttle, measured, None, ok)

    def _for(self, duration_s: float, index: int, throttle: float, azimuth_rad: float | None, lower: bool) -> None:
        end_s = self._clock.now_s() + duration_s
        while self._clock.now_s() < end_s:
            self._cycle(index, throttle, azimuth_rad, armed=True, lower=lower)

    def _cycle(self, index: int | None, throttle: float, azimuth_rad: float | None, armed: bool, lower: bool | None) -> None:
        self._due_s = max(self._due_s + self._period_s, self._clock.now_s())
        while self._clock.wait(self._due_s, [fd for actuator in self._actuators if (fd := actuator.fileno()) is not None]):
            self._hear(self._clock.now_s())
        now_s = self._clock.now_s()
        self._world.advance(now_s)
        self._hear(now_s)
        command = self._command(index, throttle, azimuth_rad, armed, lower, now_s)
        for actuator in self._actuators:
            actuator.write(command, now_s)

    def _hear(self, now_s: float) -> None:
        for actuator in self._actuators:
            for reading in actuator.read(now_s):
                if isinstance(reading, ThrusterFeedback):
                    self._reports.take(reading)

    def _command(self, index: int | None, throttle: float, azimuth_rad: float | None, armed: bool, lower: bool | None, now_s: float) -> ActuatorCommand:
        rows = []
        for i, thruster in enumerate(self._config.thrusters):
            mine = i == index
            gain = thruster.ahead_n if throttle >= 0.0 else thruster.astern_n
            azimuth = (azimuth_rad if mine and azimuth_rad is not None else thruster.azimuth_rad) if thruster.turns else None
            rows.append(ThrusterCommand(gain * throttle * abs(throttle) if mine else 0.0, throttle if mine else 0.0, azimuth))
        retracts = any(thruster.retractable for thruster in self._config.thrusters)
        lower = lower if retracts and index is not None and self._config.thrusters[index].retractable else None
        allocation = Allocation(tuple(rows), ZERO_WRENCH, (False, False, False))
        return self._gate.update(allocation, armed, now_s, self._period_s, lower, self._reports.newest)


def _off(report: ThrusterFeedback, target_rad: float) -> float:
    return math.remainder((report.azimuth_rad or 0.0) - target_rad, math.tau)


def _told(finding: Finding) -> str:
    if finding.rate_radps is not None:
        return f"{finding.what}: {math.degrees(finding.rate_radps):.0f}°/s"
    verdict = "" if finding.ok else "  NOT AS ASKED"
    if finding.what.startswith("azimuth"):
        return f"{finding.what}: {'there' if finding.ok else 'not there'}{verdict}"
    back = "the bridge does not say what it does" if finding.measured is None else f"{100.0 * finding.measured:+.0f} % came back"
    return f"{finding.what}: {100.0 * finding.asked:+.0f} % asked, {back}{verdict}"


def run_test(config: VesselConfig, opener: StreamOpener, world: World, clock: WaitingClock, arguments: argparse.Namespace) -> int:
    """The command, on the ports and clock given: exit code 0 where all that was tried did as asked. Raises TrialError."""
    names = [thruster.name for thruster in config.thrusters]
    chosen = arguments.thruster or names
    unknown = [name for name in chosen if name not in names]
    if unknown:
        raise TrialError(f"no thruster '{unknown[0]}'; there is {', '.join(names)}")
    if not 0.0 < arguments.power <= MOST_POWER:
        raise TrialError(f"--power {arguments.power:g}: above 0, at most {MOST_POWER:g}: this is a test of wires, not of strength")
    if not 2.0 * _RAMP_S <= arguments.seconds <= 30.0:
        raise TrialError(f"--seconds {arguments.seconds:g}: {2.0 * _RAMP_S:g} to 30, please")
    if arguments.yes and not arguments.sitl:
        raise TrialError("--yes is for --sitl: at a real boat somebody looks first")
    actuators = [open_actuator(bridge, config, opener.open(bridge.name, bridge.port)) for bridge in config.actuators]
    try:
        trial = Trial(config, actuators, clock, world)
        well = run_trials(config, trial, chosen, arguments.power, arguments.seconds, _agree if arguments.yes else _ask, _say)
    except KeyboardInterrupt:
        _say("Stopped: all thrusters neutral and disarmed.")
        well = False
    finally:
        for actuator in actuators:
            actuator.close()
    return 0 if well else 1


def _say(text: str) -> None:
    print(text, flush=True)


def _agree(question: str, idle: Callable[[], None]) -> str:
    _say(question + "y")
    return "y"


def _ask(question: str, idle: Callable[[], None]) -> str:
    """A line from the terminal; the boards are kept neutral meanwhile. The end of the input is a no for all that is left."""
    print(question, end="", flush=True)
    while not select.select([sys.stdin], [], [], 0.0)[0]:
        idle()
    return sys.stdin.readline() or "q"


def run_trials(
    config: VesselConfig,
    trial: Trial,
    chosen: Sequence[str],
    power: float,
    seconds: float,
    ask: Callable[[str, Callable[[], None]], str],
    say: Callable[[str], None],
) -> bool:
    """Every chosen thruster that the person agrees to. `ask(question, idle)` → its answer, calling `idle` while it waits. Whether all was well."""
    say("Every thruster turns for a moment. Hands, lines and people clear of them; the boat tied up, or out of the water where they may run dry.")
    trial.connect()
    well = True
    for index, thruster in enumerate(config.thrusters):
        if thruster.name not in chosen:
            continue
        answer = ask(f"Turn '{thruster.name}' at {100.0 * power:.0f} %? [y/N/q] ", trial.idle).strip().lower()
        if answer == "q":
            break
        if answer not in ("y", "yes"):
            say("  left out")
            continue
        found = trial.conduct(index, power, seconds, say)
        well = well and all(finding.ok for finding in found)
        rates = [finding.rate_radps for finding in found if finding.rate_radps is not None]
        if rates:
            say(f"  azimuth_rate_dps = {math.degrees(min(rates)):.0f}    # measured, the slower of both ways")
    say("All thrusters are neutral and disarmed.")
    return well

"""`companion thruster-test VESSEL`: each thruster in turn, at low power, after a person agrees.

The companion itself must not run: this opens the bridges alone. Every command passes the safety gate. `Trial` moves the
thrusters on any clock; the functions below it ask and print.
"""

from __future__ import annotations

import argparse
import math
import os
import select
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from companion.allocation.feedback import ThrusterReports
from companion.app import load_vessel
from companion.cli.common import UsageError, boat_folder
from companion.cli.service import STATE_FOLDER, UNIT
from companion.clock import PacedClock, WallClock
from companion.config.devices import ThrusterConfig
from companion.config.vessel import VesselConfig
from companion.core.actuation import ZERO_WRENCH, ActuatorCommand, Allocation, ThrusterCommand, ThrusterFeedback
from companion.core.nearest import did_you_mean
from companion.core.ports import Actuator, StreamOpener, WaitingClock, World
from companion.io.actuators import open_actuator
from companion.io.transport.opener import TransportOpener
from companion.loop import RealWorld
from companion.record.state_file import StateFile, StateFileBusy, lock_of_another
from companion.safety import Gate
from companion.supervisor.motor_test import MOST_POWER, RAMP_S

_SWING_RAD = math.radians(60.0)
_SWING_MOST_S = 30.0
_SWING_DONE_RAD = math.radians(3.0)
_LEAST_S = 0.5
_ANSWER_S = 8.0  # within which every bridge has to answer
_GOOD_THROTTLE = 0.05


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    test = commands.add_parser(
        "thruster-test",
        help="run each thruster in turn, at low power, after a question for each; the companion must not run",
    )
    test.add_argument("vessel", metavar="VESSEL", help="a bundled name or a TOML file")
    test.add_argument("--sitl", action="store_true", help="with the simulated boat in place of its devices")
    test.add_argument("--thruster", action="append", metavar="NAME", help="only this one; may be repeated")
    test.add_argument(
        "--power",
        type=float,
        default=0.15,
        metavar="SHARE",
        help=f"of full throttle, at most {MOST_POWER:g} (default 0.15)",
    )
    test.add_argument(
        "--seconds",
        type=float,
        default=3.0,
        metavar="S",
        help=f"at that power, for each direction, between ramps of {RAMP_S:g} s (default 3)",
    )
    test.add_argument("--yes", action="store_true", help="with --sitl: do not ask")
    test.set_defaults(command=_thruster_test)


def _thruster_test(arguments: argparse.Namespace) -> int:
    """The state folders of this user and of the service are locked meanwhile: a companion that runs this vessel would
    command the same thrusters."""
    config = load_vessel(arguments.vessel)
    service = None if arguments.sitl else _lock_of_service()
    state = StateFile(boat_folder(config.name, arguments.sitl) / "state")
    try:
        if arguments.sitl:
            from sitl.world import EPOCH_UNIX_NS
            from sitl.world import World as SimulatedWorld

            boat = SimulatedWorld(config)
            return run_test(config, boat, boat, PacedClock(1.0, EPOCH_UNIX_NS), arguments)
        return run_test(config, TransportOpener(), RealWorld(), WallClock(), arguments)
    finally:
        state.close()
        if service is not None:
            os.close(service)


def _lock_of_service() -> int | None:
    try:
        return lock_of_another(STATE_FOLDER)
    except StateFileBusy as error:
        raise TrialError(f"the service runs, and commands the thrusters: `sudo systemctl stop {UNIT}` first") from error


class TrialError(UsageError):
    """Why a thruster cannot be tested, and what to do."""


@dataclass(frozen=True, slots=True)
class TrialStep:
    """What one thruster is commanded for a while. `name` is for people."""

    name: str
    throttle: float
    azimuth_rad: float | None
    duration_s: float
    until_there: bool = False  # ends when the azimuth has arrived


def steps_of(thruster: ThrusterConfig, power: float, seconds: float) -> Iterator[TrialStep]:
    """The steps of one thruster's test: azimuth to either side, thrust ahead, thrust astern if it can."""
    rest = thruster.azimuth_rad if thruster.turns else None
    if thruster.turns and thruster.azimuth_rate_radps > 0.0:
        low, high = thruster.azimuth_rad - _SWING_RAD, thruster.azimuth_rad + _SWING_RAD
        if thruster.azimuth_min_rad is not None:
            low = max(thruster.azimuth_min_rad, low)
        if thruster.azimuth_max_rad is not None:
            high = min(thruster.azimuth_max_rad, high)
        for name, target in (("to starboard", high), ("to port", low), ("back", thruster.azimuth_rad)):
            yield TrialStep(f"azimuth {name}", 0.0, target, _SWING_MOST_S, until_there=True)
    yield TrialStep("ahead", power, rest, seconds + 2.0 * RAMP_S)
    if thruster.min_n < 0.0:
        yield TrialStep("astern", -power, rest, seconds + 2.0 * RAMP_S)


@dataclass(frozen=True, slots=True)
class ThrusterFinding:
    """What one step showed.

    `measured`: the throttle that the bridge reported at the end; None where it reports none. `rate_radps`: of a swing.
    """

    name: str
    commanded: float
    measured: float | None
    rate_radps: float | None
    ok: bool


class Trial:
    """Tests the thrusters of one vessel: `conduct` per thruster. In between, call `idle`, which keeps all of them
    neutral and disarmed."""

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
        """Wait until every bridge answers and its drives know their angle. Raises TrialError with what the others
        report."""
        end_s = self._clock.now_s() + _ANSWER_S + max(bridge.starts_in_s for bridge in self._config.actuators)
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

    def conduct(self, index: int, power: float, seconds: float, say: Callable[[str], None]) -> list[ThrusterFinding]:
        """All steps of one thruster. It ends neutral and disarmed, whatever happens. `say` prints a line."""
        thruster = self._config.thrusters[index]
        found: list[ThrusterFinding] = []
        try:
            if thruster.retractable:
                say("  lowering")
                self._for(thruster.travel_s + 1.0, index, 0.0, None, lower=True)
            for step in steps_of(thruster, power, seconds):
                found.append(self._swing(index, step) if step.until_there else self._push(index, step))
                say(f"  {_line_of(found[-1])}")
        finally:
            for _ in range(3):
                self.idle()
        return found

    def _swing(self, index: int, step: TrialStep) -> ThrusterFinding:
        target = step.azimuth_rad or 0.0
        begun: tuple[float, float] | None = None  # when, and how far there was to go, once it moved
        rate: float | None = None
        end_s = self._clock.now_s() + step.duration_s
        first = self._reports.newest[index]
        whole = abs(_off(first, target)) if first is not None and first.azimuth_rad is not None else 0.0
        while self._clock.now_s() < end_s:
            self._cycle(index, 0.0, target, armed=True, lower=True)
            report = self._reports.newest[index]
            if report is None or report.azimuth_rad is None:
                return ThrusterFinding(step.name, target, None, None, True)
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
        return ThrusterFinding(step.name, target, None, rate, arrived)

    def _push(self, index: int, step: TrialStep) -> ThrusterFinding:
        begin_s = self._clock.now_s()
        measured: float | None = None
        while (t_s := self._clock.now_s() - begin_s) < step.duration_s:
            share = min(1.0, t_s / RAMP_S, (step.duration_s - t_s) / RAMP_S)
            self._cycle(index, share * step.throttle, step.azimuth_rad, armed=True, lower=True)
            report = self._reports.newest[index]
            if report is not None and (share >= 1.0 or measured is None):
                measured = report.throttle
        ok = measured is None or abs(measured - step.throttle) <= max(_GOOD_THROTTLE, 0.5 * abs(step.throttle))
        return ThrusterFinding(step.name, step.throttle, measured, None, ok)

    def _for(self, duration_s: float, index: int, throttle: float, azimuth_rad: float | None, lower: bool) -> None:
        end_s = self._clock.now_s() + duration_s
        while self._clock.now_s() < end_s:
            self._cycle(index, throttle, azimuth_rad, armed=True, lower=lower)

    def _cycle(
        self, index: int | None, throttle: float, azimuth_rad: float | None, armed: bool, lower: bool | None
    ) -> None:
        self._due_s = max(self._due_s + self._period_s, self._clock.now_s())
        while self._clock.wait(
            self._due_s, [fd for actuator in self._actuators if (fd := actuator.fileno()) is not None]
        ):
            self._read(self._clock.now_s())
        now_s = self._clock.now_s()
        self._world.advance(now_s)
        self._read(now_s)
        command = self._command(index, throttle, azimuth_rad, armed, lower, now_s)
        for actuator in self._actuators:
            actuator.write(command, now_s)

    def _read(self, now_s: float) -> None:
        for actuator in self._actuators:
            for reading in actuator.read(now_s):
                if isinstance(reading, ThrusterFeedback):
                    self._reports.take(reading)

    def _command(
        self,
        index: int | None,
        throttle: float,
        azimuth_rad: float | None,
        armed: bool,
        lower: bool | None,
        now_s: float,
    ) -> ActuatorCommand:
        rows = []
        for i, thruster in enumerate(self._config.thrusters):
            mine = i == index
            gain = thruster.ahead_n if throttle >= 0.0 else thruster.astern_n
            azimuth = (
                (azimuth_rad if mine and azimuth_rad is not None else thruster.azimuth_rad) if thruster.turns else None
            )
            rows.append(
                ThrusterCommand(gain * throttle * abs(throttle) if mine else 0.0, throttle if mine else 0.0, azimuth)
            )
        retracts = any(thruster.retractable for thruster in self._config.thrusters)
        lower = lower if retracts and index is not None and self._config.thrusters[index].retractable else None
        allocation = Allocation(tuple(rows), ZERO_WRENCH, (False, False, False))
        return self._gate.update(allocation, armed, now_s, self._period_s, lower, self._reports.newest)


def _off(report: ThrusterFeedback, target_rad: float) -> float:
    return math.remainder((report.azimuth_rad or 0.0) - target_rad, math.tau)


def _line_of(finding: ThrusterFinding) -> str:
    if finding.rate_radps is not None:
        return f"{finding.name}: {math.degrees(finding.rate_radps):.0f}°/s"
    verdict = "" if finding.ok else "  NOT AS COMMANDED"
    if finding.name.startswith("azimuth"):
        return f"{finding.name}: {'there' if finding.ok else 'not there'}{verdict}"
    back = (
        "the bridge reports no throttle" if finding.measured is None else f"{100.0 * finding.measured:+.0f} % reported"
    )
    return f"{finding.name}: {100.0 * finding.commanded:+.0f} % commanded, {back}{verdict}"


def run_test(
    config: VesselConfig, opener: StreamOpener, world: World, clock: WaitingClock, arguments: argparse.Namespace
) -> int:
    """The command on the ports and clock given. Exit code 0 where every thruster did as commanded, else 1.

    Raises TrialError.
    """
    names = [thruster.name for thruster in config.thrusters]
    chosen = arguments.thruster or names
    unknown = [name for name in chosen if name not in names]
    if unknown:
        raise TrialError(f"no thruster '{unknown[0]}'; there is {', '.join(names)}{did_you_mean(unknown[0], names)}")
    if not 0.0 < arguments.power <= MOST_POWER:
        raise TrialError(
            f"--power {arguments.power:g}: must be above 0, at most {MOST_POWER:g}: this tests wiring, not thrust"
        )
    if not _LEAST_S <= arguments.seconds <= 30.0:
        raise TrialError(f"--seconds {arguments.seconds:g}: must be {_LEAST_S:g} to 30")
    if arguments.yes and not arguments.sitl:
        raise TrialError("--yes is for --sitl: on a real boat a person must look first")
    actuators = [open_actuator(bridge, config, opener.open(bridge.name, bridge.port)) for bridge in config.actuators]
    try:
        trial = Trial(config, actuators, clock, world)
        ask = _agree if arguments.yes else _ask
        well = run_trials(config, trial, chosen, arguments.power, arguments.seconds, ask, _say)
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
    """A line from the terminal. `idle` keeps the thrusters neutral meanwhile. The end of the input means quit."""
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
    """Test every chosen thruster that the person agrees to. Returns whether all did as commanded.

    `ask(question, idle)` returns the answer, and calls `idle` while it waits.
    """
    say(
        "Every thruster runs for a moment. Keep hands, lines and people clear of them. "
        "Tie the boat up, or have it out of the water if the thrusters may run dry."
    )
    trial.connect()
    well = True
    for index, thruster in enumerate(config.thrusters):
        if thruster.name not in chosen:
            continue
        answer = ask(f"Turn '{thruster.name}' at {100.0 * power:.0f} %? [y/N/q] ", trial.idle).strip().lower()
        if answer == "q":
            break
        if answer not in ("y", "yes"):
            say("  skipped")
            continue
        found = trial.conduct(index, power, seconds, say)
        well = well and all(finding.ok for finding in found)
        rates = [finding.rate_radps for finding in found if finding.rate_radps is not None]
        if rates:
            say(f"  azimuth_rate_dps = {math.degrees(min(rates)):.0f}    # measured; the slower direction")
    say("All thrusters are neutral and disarmed.")
    return well

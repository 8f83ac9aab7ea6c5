"""Boats that differ from their file by up to half, in wind and current: sailed as typed, through a sea trial, as the
trial found them, and with their true model.

    python -m tests.scenarios.hidden_hulls 0-19 --folder /tmp/hulls

prints one line a seed. `--only trial` or `--only typed` sails a part.
"""

from __future__ import annotations

import argparse
import itertools
import math
import threading
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from companion.analysis.gains import NEEDED, designed
from companion.analysis.held_out import AROUND, split
from companion.analysis.hull_model import COUPLING, INERTIA, HullModel
from companion.analysis.log_reader import Log, open_log, parameters_of
from companion.analysis.manoeuvre import Manoeuvre
from companion.analysis.trial_identify import TrialIdentification, identify_trial
from companion.cli.common import seeds
from companion.cli.rig import LockstepRig
from companion.cli.trial_results import FileTrials, finding, identified
from companion.config.dimensions.fins import with_fins
from companion.config.overlay import overlay_name, set_accepted
from companion.config.vessel import VesselConfig, load
from companion.core.trial_results import TrialFinding
from companion.modes.trial.expectation import expected
from sitl.hidden_hull import HiddenHull, hidden_hull
from sitl.scenarios import mission_square
from sitl.scenarios.ground_station import GroundStation, GroundStationTimeout
from sitl.scenarios.measure import between, distance_to, read_truth, rms
from sitl.scenarios.rig import Conditions
from tests.scenarios.hidden_truth import truth_of

PARTS = ("typed", "trial", "after")
MANUAL, HOLD, RTL = 0x00010000, 0x03040000, 0x05040000
USER_5 = 31014
LONGEST_S = 2400.0
WIND, CURRENT_SHARE = "4", 0.25  # m/s; of the top speed
_WRITTEN_S = 3.0  # after a trial, for its log
_QUESTIONS = ("Accept it?", "Accept them?")
_SETTLE_S, _HOLD_S, _RETURN_S = 50.0, 100.0, 400.0
_SIDE_LENGTHS, _LEAST_SIDE_M = 6.0, 20.0
_PATH = "pchip"
_NEAR = 1.3  # times what the true model reaches


@dataclass(frozen=True, slots=True)
class Sailed:
    """A trial. `excess_m`: how far the boat was outside its circle, negative inside."""

    texts: list[str]
    excess_m: float
    seconds: float
    mode: str


@dataclass(frozen=True, slots=True)
class Kept:
    """Hold, a square and RTL with one model. `lost`: what went wrong; empty if control was kept. `station_m`: RMS distance
    from the hold point, `path_m`: RMS cross-track error."""

    lost: str
    station_m: float
    path_m: float


@dataclass(frozen=True, slots=True)
class Weather:
    """`wind`, `waves`: as a scenario takes them; `current_share`: of the boat's top speed."""

    wind: str = WIND
    current_share: float = CURRENT_SHARE
    waves: str = ""


USUAL = Weather()


def rig_of(
    boat: HiddenHull, known: VesselConfig, real: VesselConfig, folder: Path, weather: Weather = USUAL
) -> LockstepRig:
    """The boat in wind and current, with a controller that knows it as `known`."""
    assert boat.known.sitl is not None
    current = weather.current_share * min(expected(boat.known).top_mps, expected(boat.real).top_mps)
    conditions = Conditions(
        vessel=boat.known.name,
        known=known,
        real=real,
        seed=boat.seed,
        wind=weather.wind,
        current=f"{current:.2f}",
        waves=weather.waves,
        gnss=boat.known.sitl.gnss,
    )
    return LockstepRig(conditions, folder)


class Operator:
    """Keeps the file that the owner typed, and accepts by MAVLink command what the boat says that its trial found.

    The boat identifies from the log in a thread as it does beside a real one, which waits here until the log is
    written. `identified`: what it found; None until then, and after a trial that did not end by itself.
    """

    def __init__(self, boat: HiddenHull, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.file = folder / f"{boat.known.name}.toml"
        self.file.write_text(boat.text, encoding="utf-8")
        self.identified: TrialIdentification | None = None
        self._written, self._done = threading.Event(), threading.Event()

    def watch(self, rig: LockstepRig, log_folder: Path) -> None:
        """Before the first tick."""

        def identify() -> TrialFinding:
            self._written.wait()
            try:
                self.identified = identified(log_folder, self.file)
            finally:
                self._done.set()
            return finding(self.identified)

        rig.vessel.supervisor.trial_duty.results = FileTrials(self.file, identify, rig.vessel.worker)

    def accept(self, gcs: GroundStation) -> None:
        """After the trial, in Hold. Raises GroundStationTimeout where it is refused."""
        if "Trial: identifying the boat from the log" not in gcs.texts:
            return
        gcs.sail(_WRITTEN_S)
        self._written.set()
        self._done.wait()
        gcs.wait("what the trial found", lambda: any(text.endswith(_QUESTIONS) for text in gcs.texts[-5:]), 5.0)
        gcs.command(USER_5, 0.0, 1.0)
        gcs.wait("stored", lambda: "Trial: accepted; reboot to use the new model" in gcs.texts, 5.0)


def sail_trial(
    boat: HiddenHull,
    real: VesselConfig,
    folder: Path,
    longest_s: float,
    weather: Weather = USUAL,
    operator: Operator | None = None,
) -> Sailed:
    """A trial, until it ends; its motor check alone where `longest_s` is below 100. `operator`: accepts the result."""
    rig = rig_of(boat, boat.known, real, folder, weather)
    if operator is not None:
        operator.watch(rig, folder)
    gcs = GroundStation(rig)
    gcs.ready()
    gcs.set_mode(MANUAL)
    gcs.arm()
    gcs.sail(1.0)
    start = rig.world.truth
    gcs.command(USER_5, 0.0)
    begin_s, excess_m = rig.now_s, -math.inf
    radius_m = expected(boat.known).radius_m
    while rig.now_s < begin_s + longest_s and rig.vessel.last_tick.status.mode.value == "Trial":
        gcs.step()
        truth = rig.world.truth
        away_m = math.hypot(truth.north_m - start.north_m, truth.east_m - start.east_m)
        excess_m = max(excess_m, away_m - radius_m)
        if longest_s < 100.0 and any("Trial: 1/" in text and text.endswith("done") for text in gcs.texts[-6:]):
            break
    mode, seconds = rig.vessel.last_tick.status.mode.value, rig.now_s - begin_s
    if operator is not None:
        operator.accept(gcs)
    rig.close()
    return Sailed(gcs.texts, excess_m, seconds, mode)


# --- hold, square, return ------------------------------------------------------------------------------------------


def sail_all(boat: HiddenHull, known: VesselConfig, folder: Path, weather: Weather = USUAL) -> Kept:
    """Hold, a square mission and RTL, with the model of `known`."""
    rig = rig_of(boat, known, boat.real, folder, weather)
    gcs = GroundStation(rig)
    side_m = max(_LEAST_SIDE_M, _SIDE_LENGTHS * known.length_m)
    settings = {"side": f"{side_m:.1f}", "limit": "0", "path": _PATH}
    held_s, asked, lost = (0.0, 0.0), None, ""
    try:
        gcs.hold_at_home(_SETTLE_S)
        begun_s = rig.now_s
        gcs.sail(_HOLD_S)
        held_s = begun_s, rig.now_s
        asked = mission_square.sail(gcs, settings)
        _return(gcs, known)
    except GroundStationTimeout as timeout:
        lost = str(timeout)
    finally:
        rig.close()
    return _judged(folder, known, held_s, asked, settings, lost)


def _return(gcs: GroundStation, known: VesselConfig) -> None:
    """RTL until the boat lies near home."""
    near_m = known.parameters["DP_ALARM_R"]
    gcs.set_mode(RTL)

    def home() -> bool:
        truth = gcs.rig.world.truth
        return math.hypot(truth.north_m, truth.east_m) < near_m

    gcs.wait("home by RTL", home, _RETURN_S)
    gcs.sail(_SETTLE_S)
    if not home():
        raise GroundStationTimeout("carried away after RTL")


def _judged(
    folder: Path,
    known: VesselConfig,
    held_s: tuple[float, float],
    asked: Mapping[str, object] | None,
    settings: Mapping[str, str],
    lost: str,
) -> Kept:
    track = between(read_truth(folder), *held_s)
    away = [distance_to(row, 0.0, 0.0) for row in track]
    path_m = math.nan
    if asked is not None:
        metrics, _ = mission_square.measure(folder, dict(asked), settings)
        path_m = metrics["cross_track_rms_m"]
        if metrics["cross_track_max_m"] > 0.5 * float(settings["side"]):
            lost = lost or f"{metrics['cross_track_max_m']:.0f} m off the path"
    if away and max(away) > known.parameters["DP_ALARM_R"]:
        lost = lost or f"{max(away):.1f} m from the hold point"
    return Kept(lost, rms(away), path_m)


# --- models --------------------------------------------------------------------------------------------------------


def loaded_with(boat: HiddenHull, overlay: str, folder: Path) -> VesselConfig:
    """The boat's file with an overlay beside it that was accepted."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{boat.known.name}.toml"
    file.write_text(boat.text, encoding="utf-8")
    beside = folder / overlay_name(file.stem, "2026-01-01")
    beside.write_text(overlay, encoding="utf-8")
    set_accepted(beside, True)
    return load(file)


def true_overlay(boat: HiddenHull, parameters: Mapping[str, float]) -> str:
    """What a perfect identification would write: hull, thrusters, windage, and the bandwidths designed for them."""
    real = boat.real
    hull = with_fins(real.hull, real.thrusters, real.limits.surge_n)
    assert real.sitl is not None
    lag_s = real.sitl.plants[real.sitl.plant].thruster_lag_s
    lines = ["[trial]", "accepted = false", "[hull]"]
    lines += [f"{name} = {getattr(hull, name)!r}" for name in (*INERTIA, COUPLING)]
    lines += ["[hull.damping]", *(f"{name} = {value!r}" for name, value in asdict(hull.damping).items())]
    lines += ["[windage]", f"frontal_m2 = {real.windage.frontal_m2!r}", f"lateral_m2 = {real.windage.lateral_m2!r}"]
    lines += ["[limits]", *(f"{name} = {getattr(real.limits, name)!r}" for name in ("surge_n", "sway_n", "yaw_nm"))]
    for thruster in real.thrusters:
        lines += ["[[thruster]]", f'name = "{thruster.name}"']
        lines += [f"{name} = {getattr(thruster, name)!r}" for name in ("x_m", "max_n", "min_n", "ahead_n", "astern_n")]
        if (rudder := thruster.rudder) is not None:
            blade = {"x_m": rudder.x_m, "lift_scale": rudder.lift_scale, "race_gain": rudder.race_gain}
            lines.append(f"rudder = {{ {', '.join(f'{name} = {value!r}' for name, value in blade.items())} }}")
    designs = designed(real, hull, lag_s, {name: parameters[name] for name in NEEDED})
    lines += ["[parameters]", *(f"{design.name} = {design.value:g}" for design in designs)]
    return "\n".join(lines) + "\n"


def model_errors(boat: HiddenHull, log: Log, held_out: Manoeuvre, found: Mapping[str, float]) -> tuple[float, float]:
    """(as typed, as found): difference of the velocities that each model and the true one predict for the manoeuvres
    that were held out, over the size of the motion. Unlike the error against the log it has no gusts in it."""
    typed = HullModel(log, held_out, mounting=True)
    around = {name: value for name, value in found.items() if name.startswith(AROUND)}
    true = {**typed.model, **truth_of(boat, typed)}
    rows = np.concatenate([np.arange(a, b) for a, b in held_out.stretches])
    size = np.sqrt((held_out.velocity[rows] ** 2).mean(axis=0))
    ours = typed.simulate({**true, **around})[rows]

    def error(values: Mapping[str, float]) -> float:
        wrong = typed.simulate({**values, **around})[rows] - ours
        return float(np.sqrt(((np.sqrt((wrong**2).mean(axis=0)) / size) ** 2).mean()))

    return error(typed.model), error(found)


# --- one seed ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Found:
    """All of one seed. None where it was not sailed."""

    boat: HiddenHull
    typed: Kept | None
    trial: Sailed | None
    identified: TrialIdentification | None
    errors: tuple[float, float] | None
    after: Kept | None
    true: Kept | None

    @property
    def lengths(self) -> float:
        """Largest excess over the circle, in the boat's lengths."""
        return -math.inf if self.trial is None else self.trial.excess_m / self.boat.known.length_m

    @property
    def halved(self) -> bool:
        """Whether the prediction error fell by half."""
        p = None if self.identified is None else self.identified.prediction
        return p is not None and p.ratio <= 0.5

    @property
    def model_halved(self) -> bool:
        """Whether the difference from the true model fell by half."""
        return self.errors is not None and self.errors[1] <= 0.5 * self.errors[0]

    @property
    def near(self) -> bool:
        """Whether station keeping and path error are near what the true model reaches."""
        if self.after is None or self.true is None:
            return False
        a, t = self.after, self.true
        return not a.lost and a.station_m <= _NEAR * t.station_m and a.path_m <= _NEAR * t.path_m

    @property
    def line(self) -> str:
        """One line for people."""
        boat = self.boat
        words = [f"seed {boat.seed:3d} {boat.propulsion:13s} {boat.known.length_m:4.1f} m"]
        if self.typed is not None:
            words.append(f"typed: {self.typed.lost or 'kept'} ({self.typed.station_m:.2f}, {self.typed.path_m:.2f} m)")
        if self.trial is not None:
            words.append(f"trial {self.trial.seconds:.0f} s, {self.lengths:+.2f} L beyond, ends in {self.trial.mode}")
        p = None if self.identified is None else self.identified.prediction
        if p is not None:
            words.append(f"error {p.before:.3f} -> {p.after:.3f} ({p.ratio:.2f})")
        if self.errors is not None:
            before, after = self.errors
            words.append(f"from the true model {before:.3f} -> {after:.3f} ({after / before:.2f})")
        for name, kept in (("after", self.after), ("true", self.true)):
            if kept is not None:
                words.append(f"{name}: {kept.lost or 'kept'} ({kept.station_m:.2f}, {kept.path_m:.2f} m)")
        if self.true is not None:
            words.append("near" if self.near else "NOT NEAR")
        return " | ".join(words)


def sail_seed(seed: int, folder: Path, only: Sequence[str] = PARTS, weather: Weather = USUAL) -> Found:
    """The boat of that seed, through everything that `only` names."""
    boat = hidden_hull(seed)
    typed = sail_all(boat, boat.known, folder / "typed", weather) if "typed" in only else None
    trial = result = errors = after = true = None
    if "trial" in only:
        operator = Operator(boat, folder / "found")
        trial = sail_trial(boat, boat.real, folder / "trial", LONGEST_S, weather, operator)
        result = operator.identified or identify_trial(open_log(folder / "trial"))
        _, held_out = split(result.manoeuvre, result.ran)
        errors = model_errors(boat, result.log, held_out, result.values)
    if result is not None and "after" in only:
        parameters = parameters_of(result.log, [])
        after = sail_all(boat, load(operator.file), folder / "after", weather)
        known = loaded_with(boat, true_overlay(boat, parameters), folder / "told")
        true = sail_all(boat, known, folder / "true", weather)
    return Found(boat, typed, trial, result, errors, after, true)


def main() -> int:
    """Sail the seeds; 0 if all of them passed."""
    parser = argparse.ArgumentParser(description="hidden hulls")
    parser.add_argument("seeds", nargs="+", type=seeds, help="such as 0-19 or 7")
    parser.add_argument("--folder", type=Path, required=True, help="for the logs")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--wind", default=WIND, help="m/s; default %(default)s")
    parser.add_argument(
        "--current", type=float, default=CURRENT_SHARE, help="share of the top speed; default %(default)s"
    )
    arguments = parser.parse_args()
    weather = Weather(arguments.wind, arguments.current)
    found = []
    for seed in itertools.chain.from_iterable(arguments.seeds):
        found.append(sail_seed(seed, arguments.folder / f"seed{seed}", arguments.only, weather))
        print(found[-1].line, flush=True)
    kept = sum(one.typed is None or not one.typed.lost for one in found)
    inside = sum(one.lengths <= 1.0 for one in found)
    print(
        f"{len(found)} boats: control kept {kept}, inside by a length {inside}, "
        f"error halved {sum(one.halved for one in found)} (from the true model {sum(one.model_halved for one in found)}), "
        f"near the true model {sum(one.near for one in found)}"
    )
    return 0 if kept == inside == len(found) else 1


if __name__ == "__main__":
    raise SystemExit(main())

"""Station keeping before and after a trial: measured, and predicted.

For the prediction the boat as it was identified holds a point in simulation, in the wind and current of the trial, with
the controller of before and that of after.
"""

from __future__ import annotations

import math
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from companion.analysis.hull_model import CURRENT
from companion.analysis.keeping import Keeping, kept, measured
from companion.analysis.log_reader import LogError, open_log
from companion.analysis.trial_identify import TrialIdentification
from companion.analysis.trial_report import after
from companion.config.vessel import AS_MODELLED, PlantConfig, VesselConfig

_SETTLE_S, _HOLD_S = 60.0, 120.0
_SEED = 1
_HOLD = 0x03040000


def keepings(found: TrialIdentification, later: Path | None = None, predict: bool = True) -> tuple[Keeping, ...]:
    """All that is known of the station keeping, before and after. `later`: a log with the new gains in force; None: the
    last one beside the trial's. Raises LogError, OSError."""
    folder = found.log.folder
    later = later or _later(found)
    logs = (("before, measured", folder), *(() if later is None else (("after, measured", later),)))
    seen = tuple(one for how, log in logs if (one := measured(log, how)) is not None)
    return (*seen, *(predicted(found) if predict else ()))


def _later(found: TrialIdentification) -> Path | None:
    """The last log beside the trial's, of the same boat, that began with the new gains and kept a place."""
    folder, gains = found.log.folder.resolve(), {design.name: design.value for design in found.designs}
    for other in sorted(folder.parent.iterdir(), reverse=True):
        if other.name <= folder.name:
            continue
        try:
            if not (other / "manifest.json").is_file():
                continue
            log = open_log(other)
            same = log.config.name == found.log.config.name and all(
                math.isclose(log.parameters.get(name, math.nan), value, rel_tol=1e-4) for name, value in gains.items()
            )
            if same and measured(other, "") is not None:
                return other
        except (LogError, OSError):
            continue
    return None


def predicted(found: TrialIdentification) -> tuple[Keeping, ...]:
    """(before, after); without a boat that does not come to Hold. Raises OSError."""
    now = after(found)
    if now.sitl is None:
        return ()
    real = _as_identified(found, now)
    rows = (
        ("before, predicted", found.log.config, {d.name: d.before for d in found.designs}),
        ("after, predicted", now, {d.name: d.value for d in found.designs}),
    )
    made = (_held(found, how, known, real, gains) for how, known, gains in rows)
    return tuple(one for one in made if one is not None)


def _as_identified(found: TrialIdentification, now: VesselConfig) -> VesselConfig:
    """The boat as the trial found it, as a plant."""
    assert now.sitl is not None
    plant = PlantConfig(hull=now.hull, windage=now.windage, thruster_lag_s=max(0.0, found.values["lag_s"]))
    return replace(now, sitl=replace(now.sitl, plant=AS_MODELLED, plants={AS_MODELLED: plant}))


def _held(
    found: TrialIdentification, how: str, known: VesselConfig, real: VesselConfig, gains: dict[str, float]
) -> Keeping | None:
    from companion.cli.rig import LockstepRig
    from sitl.scenarios.ground_station import GroundStation, GroundStationTimeout
    from sitl.scenarios.rig import Conditions

    assert known.sitl is not None
    conditions = Conditions(
        vessel=known.name,
        known=known,
        real=real,
        seed=_SEED,
        wind=_directed(_wind(found), turned=True),
        current=_directed((found.values[CURRENT[0]], found.values[CURRENT[1]])),
        gnss=known.sitl.gnss,
        parameters=gains,
    )
    with tempfile.TemporaryDirectory(prefix="companion-") as folder:
        rig = LockstepRig(conditions, Path(folder))
        try:
            station = GroundStation(rig)
            station.ready()
            station.set_mode(_HOLD)
            station.arm()
            begun_s = rig.now_s
            station.sail(_SETTLE_S + _HOLD_S)
        except GroundStationTimeout:
            return None
        finally:
            rig.close()
        return kept(Path(folder) / "truth.csv", how, begun_s + _SETTLE_S, begun_s + _SETTLE_S + _HOLD_S)


def _wind(found: TrialIdentification) -> tuple[float, float]:
    """Velocity of the air over ground during the trial: as measured, else as the fit has it."""
    wind_mps = found.manoeuvre.wind_mps
    if wind_mps is not None:
        north, east = np.asarray(wind_mps).mean(axis=0).tolist()
        return float(north), float(east)
    north, east = (found.values.get(name, 0.0) for name in ("wind_north_m2ps2", "wind_east_m2ps2"))
    root = math.hypot(north, east) ** 0.5
    return (north / root, east / root) if root > 0.0 else (0.0, 0.0)


def _directed(velocity: tuple[float, float], turned: bool = False) -> str | None:
    """As scenarios write it: a speed and where it goes to; `turned`: where it comes from."""
    speed = math.hypot(*velocity)
    degrees = (math.degrees(math.atan2(velocity[1], velocity[0])) + (180.0 if turned else 0.0)) % 360.0
    return f"{speed:.2f}@{degrees:.0f}" if speed >= 0.01 else None

"""Heading by a magnetometer alone, at speed, in turns and waves: the boat is towed, so that any vessel may be the one that carries the sensors."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sitl.scenarios.measure import Check, read_truth, rms
from sitl.scenarios.scenario import Scenario, Settings, number
from sitl.scenarios.station import Station
from sitl.tow import Leg

_REST_S = 12.0
_JUDGED_MPS = 2.5
_MEAN_DEG, _MAX_DEG = 1.0, 3.0
_WITHIN = 0.9  # share of the time in which the error is to be under two sigma of what the boat believes


def legs(settings: Settings) -> tuple[Leg, ...]:
    """At rest; straight; hard turns to both sides, one after another and once right round; a gentle one; slow; fast again."""
    v, g = number(settings, "speed"), number(settings, "turn")
    slow = max(0.4 * v, _JUDGED_MPS + 0.5)
    return (
        Leg(_REST_S, 0.0), Leg(15.0, v), Leg(17.0, v, g), Leg(12.0, v), Leg(17.0, v, -g), Leg(10.0, v),
        Leg(6.0, v, g), Leg(6.0, v, -g), Leg(6.0, v, g), Leg(25.0, v, 0.3 * g), Leg(12.0, slow), Leg(12.0, slow, -0.3 * g),
        Leg(12.0, v), Leg(34.0, v, -g), Leg(15.0, v),
    )  # fmt: skip


def sail(station: Station, settings: Settings) -> dict[str, Any]:
    station.sail(sum(leg.duration_s for leg in legs(settings)))
    return {"vessel": station.rig.config.name}


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    rows = [row for row in errors(folder) if row[1] > _JUDGED_MPS]
    found = [abs(math.degrees(error)) for _, _, error, _ in rows]
    within = sum(abs(error) <= 2.0 * sigma for _, _, error, sigma in rows) / len(rows)
    metrics = {
        "heading_error_mean_deg": sum(found) / len(found),
        "heading_error_rms_deg": rms(found),
        "heading_error_max_deg": max(found),
        "heading_within_two_sigma": within,
        "heading_sigma_mean_deg": sum(math.degrees(sigma) for _, _, _, sigma in rows) / len(rows),
        "judged_s": len(rows) * (rows[-1][0] - rows[0][0]) / max(len(rows) - 1, 1),
    }
    return metrics, (
        Check(f"mean heading error above {_JUDGED_MPS:g} m/s", metrics["heading_error_mean_deg"], _MEAN_DEG, "deg"),
        Check(f"largest heading error above {_JUDGED_MPS:g} m/s", metrics["heading_error_max_deg"], _MAX_DEG, "deg"),
        Check("share of the time within two sigma of the accuracy stated", within, _WITHIN, "", at_least=True),
    )


def errors(folder: Path) -> list[tuple[float, float, float, float]]:
    """(time, true speed over ground, heading error, heading accuracy as stated) of each tick."""
    with (folder / "ticks.csv").open(encoding="utf-8") as file:
        believed = [(float(row["yaw_rad"]), float(row["heading_accuracy_rad"])) for row in csv.DictReader(file)]
    return [
        (true["t_s"], math.hypot(true["surge_mps"], true["sway_mps"]), math.remainder(yaw - true["yaw_rad"], 2.0 * math.pi), sigma)
        for (yaw, sigma), true in zip(believed, read_truth(folder), strict=True)
    ]


def draw(folder: Path, asked: dict[str, Any], settings: Settings) -> None:
    """Draw `ahrs.png` into the folder. Raises ImportError without matplotlib."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    rows, truth = errors(folder), read_truth(folder)
    t = [row[0] for row in rows]
    figure = Figure(figsize=(12.0, 7.0), layout="constrained")
    FigureCanvasAgg(figure)
    error, turn, speed = figure.subplots(3, 1, sharex=True, height_ratios=(2, 1, 1))
    sigma = [2.0 * math.degrees(row[3]) for row in rows]
    error.fill_between(t, [-s for s in sigma], sigma, color="tab:blue", alpha=0.15, label="two sigma, as stated")
    error.plot(t, [math.degrees(row[2]) for row in rows], color="tab:blue", linewidth=0.9, label="heading error")
    error.set_ylabel("°")
    error.set_ylim(-15.0, 15.0)
    error.legend(loc="upper right")
    turn.plot(t, [math.degrees(row["yaw_rate_radps"]) for row in truth], color="tab:orange")
    turn.set_ylabel("turn, °/s")
    speed.plot(t, [row[1] for row in rows], color="tab:green")
    speed.set_ylabel("speed, m/s")
    speed.set_xlabel("time, s")
    for axes in (error, turn, speed):
        axes.grid(alpha=0.3)
    figure.suptitle(f"{asked['vessel']}: " + ", ".join(f"{key} {value}" for key, value in settings.items() if value), fontsize=10)
    figure.savefig(folder / "ahrs.png", dpi=80)


SCENARIO = Scenario(
    name="ahrs",
    text="heading by a magnetometer alone in turns of 0.3 g and waves, on a boat that is towed at 8 m/s",
    vessel="revolt",
    defaults={
        "speed": "8",
        "turn": "0.3",
        "wind": "5",
        "waves": "0.25",
        "current": "",
        "gnss": "sbas",
        "ahrs": "companion",
        "magnetometer": "calibrated",
    },
    sail=sail,
    measure=measure,
    plot=draw,
    tow=legs,
)

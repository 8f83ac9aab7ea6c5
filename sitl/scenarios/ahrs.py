"""Heading from a magnetometer alone, at speed, in turns and waves. The boat is towed, so any vessel can carry the
sensors."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sitl.scenarios.figure import legend, new_figure, set_title
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check, read_truth, rms
from sitl.scenarios.scenario import Scenario, Settings, number
from sitl.tow import TowLeg

_REST_S = 12.0
_JUDGED_MPS = 2.5
_MEAN_DEG, _MAX_DEG = 1.0, 3.0
_NEES = 3.5  # errors last some 15 s, so a run has seven: chi-square of 7 over 7 is larger once in 1,000 runs


def legs(settings: Settings) -> tuple[TowLeg, ...]:
    """At rest; straight; hard turns to alternate sides, a full circle, a gentle turn; slow; fast again."""
    v, g = number(settings, "speed"), number(settings, "turn")
    slow = max(0.4 * v, _JUDGED_MPS + 0.5)
    return (
        TowLeg(_REST_S, 0.0), TowLeg(15.0, v), TowLeg(17.0, v, g), TowLeg(12.0, v), TowLeg(17.0, v, -g),
        TowLeg(10.0, v), TowLeg(6.0, v, g), TowLeg(6.0, v, -g), TowLeg(6.0, v, g), TowLeg(25.0, v, 0.3 * g),
        TowLeg(12.0, slow), TowLeg(12.0, slow, -0.3 * g),
        TowLeg(12.0, v), TowLeg(34.0, v, -g), TowLeg(15.0, v),
    )  # fmt: skip


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Let the boat be towed along all legs."""
    gcs.sail(sum(leg.duration_s for leg in legs(settings)))
    return {"vessel": gcs.rig.config.name}


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Heading errors at speed, and how well the stated accuracy fits them."""
    rows = [row for row in errors(folder) if row[1] > _JUDGED_MPS]
    found = [abs(math.degrees(error)) for _, _, error, _ in rows]
    within = sum(abs(error) <= 2.0 * sigma for _, _, error, sigma in rows) / len(rows)
    metrics = {
        "heading_error_mean_deg": sum(found) / len(found),
        "heading_error_rms_deg": rms(found),
        "heading_error_max_deg": max(found),
        "heading_within_two_sigma": within,
        "heading_nees": sum((error / sigma) ** 2 for _, _, error, sigma in rows) / len(rows),
        "heading_sigma_mean_deg": sum(math.degrees(sigma) for _, _, _, sigma in rows) / len(rows),
        "judged_s": len(rows) * (rows[-1][0] - rows[0][0]) / max(len(rows) - 1, 1),
    }
    return metrics, (
        Check(f"mean heading error above {_JUDGED_MPS:g} m/s", metrics["heading_error_mean_deg"], _MEAN_DEG, "deg"),
        Check(f"largest heading error above {_JUDGED_MPS:g} m/s", metrics["heading_error_max_deg"], _MAX_DEG, "deg"),
        Check("square of error over accuracy, mean", metrics["heading_nees"], _NEES, ""),
    )


def errors(folder: Path) -> list[tuple[float, float, float, float]]:
    """(time, true speed over ground, heading error, heading accuracy as stated) of each tick."""
    with (folder / "ticks.csv").open(encoding="utf-8") as file:
        estimates = [(float(row["yaw_rad"]), float(row["heading_accuracy_rad"])) for row in csv.DictReader(file)]
    return [
        (
            true["t_s"],
            math.hypot(true["surge_mps"], true["sway_mps"]),
            math.remainder(yaw - true["yaw_rad"], 2.0 * math.pi),
            sigma,
        )
        for (yaw, sigma), true in zip(estimates, read_truth(folder), strict=True)
    ]


def draw(folder: Path, asked: dict[str, Any], settings: Settings) -> None:
    """Draw `ahrs.png` into the folder. Raises ImportError without matplotlib."""
    rows, truth = errors(folder), read_truth(folder)
    t = [row[0] for row in rows]
    figure = new_figure(12.0, 7.0)
    error, turn, speed = figure.subplots(3, 1, sharex=True, height_ratios=(2, 1, 1))
    sigma = [2.0 * math.degrees(row[3]) for row in rows]
    error.fill_between(t, [-s for s in sigma], sigma, color="tab:blue", alpha=0.15, label="two sigma, as stated")
    error.plot(t, [math.degrees(row[2]) for row in rows], color="tab:blue", linewidth=0.9, label="heading error")
    error.set_ylabel("heading error, °")
    error.set_ylim(-15.0, 15.0)
    legend(error)
    turn.plot(t, [math.degrees(row["yaw_rate_radps"]) for row in truth], color="tab:orange")
    turn.set_ylabel("turn, °/s")
    speed.plot(t, [row[1] for row in rows], color="tab:green")
    speed.set_ylabel("speed, m/s")
    speed.set_xlabel("time, s")
    for axes in (error, turn, speed):
        axes.grid(alpha=0.3)
    set_title(figure, settings, asked["vessel"])
    figure.savefig(folder / "ahrs.png", dpi=80)


SCENARIO = Scenario(
    name="ahrs",
    text="heading from a magnetometer alone in turns of 0.3 g and waves, on a boat towed at 8 m/s",
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
    lasts_s=210.0,
)

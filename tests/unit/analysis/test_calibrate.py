"""A magnetometer in known iron, turned, and the calibration that comes of it."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from companion.analysis.calibrate import calibrate
from companion.analysis.log_reader import LogError, open_log
from companion.cli.main import main
from companion.config import vessel as config_module
from companion.config.vessel import VesselConfig
from companion.core.readings import GroundVelocity, Imu, MagneticField, Reading
from companion.nav.field_fit import Array, FieldFit, fit, headings
from companion.record.mcap_log import FILE, McapEncoder
from tests.unit.nav.ahrs_motion import Sailing, sail
from tests.unit.record.ticks import tick

DIP_RAD = math.radians(71.3)
EARTH = np.array([math.cos(DIP_RAD), 0.0, math.sin(DIP_RAD)])  # magnetic north
OFFSET = np.array([9.0, -4.0, 6.0])  # in µT of a field of 50
DISTORTION = 50.0 * np.array([[1.06, 0.03, -0.02], [0.03, 0.94, 0.02], [-0.02, 0.02, 1.03]])


def attitudes(tilt_rad: float, count: int = 2000, span_rad: float = 2 * math.pi) -> tuple[Array, Array]:
    random = np.random.default_rng(3)
    return random.uniform(0.0, span_rad, count), random.uniform(-tilt_rad, tilt_rad, (count, 2))


def body_field(yaw: Array, tilt: Array) -> Array:
    """The Earth's field in body axes, rotation after rotation."""
    (cy, cp, cr), (sy, sp, sr) = (
        (np.cos(a) for a in (yaw, tilt[:, 1], tilt[:, 0])),
        (np.sin(a) for a in (yaw, tilt[:, 1], tilt[:, 0])),
    )
    x, y, z = cy * EARTH[0], -sy * EARTH[0], np.full(len(yaw), EARTH[2])
    x, z = cp * x - sp * z, sp * x + cp * z
    y, z = cr * y + sr * z, cr * z - sr * y
    return np.stack([x, y, z], axis=1)


def measured(yaw: Array, tilt: Array, noise: float = 0.2) -> Array:
    return (
        body_field(yaw, tilt) @ DISTORTION.T + OFFSET + noise * np.random.default_rng(4).standard_normal((len(yaw), 3))
    )


def worst_deg(found: FieldFit, tilt_rad: float) -> float:
    """Largest heading error on all headings with that heel, by the true tilt."""
    yaw = np.linspace(0.0, 2 * math.pi, 72)
    worst = 0.0
    for heel in (-tilt_rad, tilt_rad):
        tilt = np.stack([np.full(72, heel), np.zeros(72)], axis=1)
        heading, _ = headings((measured(yaw, tilt, 0.0) - found.offset) @ found.matrix, tilt)
        worst = max(worst, float(np.max(np.abs(np.remainder(heading - yaw + math.pi, 2 * math.pi) - math.pi))))
    return math.degrees(worst)


def test_tilted_turns_tell_the_whole_ellipsoid() -> None:
    yaw, tilt = attitudes(math.radians(15.0))
    found = fit(measured(yaw, tilt), tilt, DIP_RAD)
    assert not found.flat
    assert np.abs(found.offset - OFFSET).max() < 3.0 * 50.0 * found.offset_sigma < 1.0
    assert np.abs(found.matrix @ DISTORTION - np.eye(3)).max() < 0.01
    assert worst_deg(found, 0.0) < 0.5 and worst_deg(found, math.radians(15.0)) < 0.7
    assert found.residual < 0.006 < 0.03 < found.before


def test_a_flat_circle_is_fitted_in_the_plane_and_says_so() -> None:
    yaw, tilt = attitudes(math.radians(0.5))
    found = fit(measured(yaw, tilt), tilt, DIP_RAD)
    assert found.flat
    assert worst_deg(found, 0.0) < 0.7
    assert np.degrees(np.abs(found.deviation_rad)).max() < 0.7 < 10.0 < np.degrees(np.ptp(found.deviation_before_rad))


def test_passing_iron_does_not_matter_much() -> None:
    yaw, tilt = attitudes(math.radians(15.0))
    field = measured(yaw, tilt)
    field[::25] += [20.0, 5.0, -10.0]
    assert worst_deg(fit(field, tilt, DIP_RAD), math.radians(5.0)) < 1.0


def test_nothing_to_fit_is_said() -> None:
    for field in (np.zeros((50, 3)), np.ones((500, 3))):
        with pytest.raises(ValueError, match="too few"):
            fit(field, np.zeros((len(field), 2)), DIP_RAD)


# --- from a log ----------------------------------------------------------------------------------------------------

CIRCLES = ((12.0, 3.0, 0.0), (20.0, 3.0, 0.1), (20.0, 3.0, -0.1), (20.0, 3.0, 0.1))


def gothenburg() -> VesselConfig:
    config = config_module.load(config_module.find("revolt"))
    return replace(config, home=replace(config.home, lat_deg=57.69, lon_deg=11.80))


def recorded(
    folder: Path,
    parts: tuple[tuple[float, float, float], ...] = CIRCLES,
    with_field: bool = True,
    upside_down: bool = False,
) -> Path:
    """The log of turns. `upside_down`: the magnetometer alone, as CAL_MAG0_ROT tells."""
    sailing = Sailing(
        parts=parts, wave_rad=math.radians(2.0), wave_m=0.05, iron=0.0, heel=0.2, lever_m=(-0.81, 0.0, -0.2)
    )
    motion, encoder = sail(sailing), McapEncoder()
    field = (motion.field @ DISTORTION.T + OFFSET) * ((1.0, -1.0, -1.0) if upside_down else 1.0)
    with (folder / FILE).open("wb") as file:
        file.write(encoder.header())
        readings: list[Reading] = []
        for k in range(0, len(motion.t_s), 2):
            t_s = float(motion.t_s[k])
            readings.append(Imu(t_s, "imu", *motion.force[k].tolist(), *motion.rates[k].tolist()))
            if with_field and k % 8 == 0:
                readings.append(MagneticField(t_s, "imu", *field[k].tolist()))
            if k % 20 == 0:
                readings.append(GroundVelocity(t_s, "gnss", *motion.velocity[k].tolist()))
                encoder.tick(replace(tick(t_s), readings=tuple(readings)), ())
                file.write(encoder.due())
                readings = []
        file.write(encoder.end())
    parameters = {"CAL_MAG0_ROT": 8.0} if upside_down else {}
    entries = {"configuration": config_module.as_dict(gothenburg()), "parameters": parameters}
    (folder / "manifest.json").write_text(json.dumps(entries), encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def circles(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("circles"))


def test_circles_in_a_log_give_the_lines_of_a_vessel(
    circles: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["calibrate", str(circles), "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr()
    assert "mag_offset" in printed.out and "deviation of the heading" in printed.out
    lines = (tmp_path / "magnetometer.toml").read_text(encoding="utf-8")
    text = config_module.find("revolt").read_text(encoding="utf-8")
    text = text.replace('name = "imu"\n', 'name = "imu"\n' + lines)
    config = config_module.parse(text, "revolt.toml")
    row = next(sensor for sensor in config.sensors if sensor.name == "imu")
    assert row.heading == "ahrs"
    found = FieldFit(np.array(row.mag_offset), np.array(row.mag_matrix), True, 0.0, 0.0, np.zeros(1), np.zeros(1), 0.0)
    assert worst_deg(found, 0.0) < 2.0  # uncalibrated: 40°
    assert (tmp_path / "magnetometer.png").stat().st_size > 10_000


def test_a_log_through_the_flat_fit_says_so(circles: Path, tmp_path: Path) -> None:
    found = calibrate(open_log(circles), tmp_path)
    assert (
        found.fit.flat and any("in the plane" in warning for warning in found.warnings) and "plane only" in found.toml
    )


def test_a_turned_magnetometer_is_fitted_in_its_own_axes(circles: Path, tmp_path: Path) -> None:
    """Its turn was not minded: 4 degrees were left, and the heading was off by 120 with a heel of 10."""
    straight = calibrate(open_log(circles), tmp_path).fit
    over = np.diag([1.0, -1.0, -1.0])
    turned = calibrate(open_log(recorded(tmp_path, upside_down=True)), tmp_path).fit
    assert over @ turned.offset == pytest.approx(straight.offset, abs=0.01)
    assert over @ turned.matrix @ over == pytest.approx(straight.matrix, abs=1e-4)


def test_half_a_circle_is_not_enough(circles: Path, tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"no headings to the .* two slow circles"):
        calibrate(open_log(circles), tmp_path, to_s=17.0)


def test_what_is_missing_is_said(circles: Path, tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"no magnetometer named 'compass'.* there is imu"):
        calibrate(open_log(circles), tmp_path, sensor="compass")
    with pytest.raises(LogError, match="no magnetic field in this log"):
        calibrate(open_log(recorded(tmp_path, with_field=False)), tmp_path)

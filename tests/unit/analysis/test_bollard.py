"""Bollard pulls: the fitted curve against known thrusters, against scipy, and what is refused."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import curve_fit

from companion.analysis.bollard import BollardError, fit, plot, read_pulls, report, toml_lines
from companion.app import load_vessel
from companion.cli.main import main

STEPS = [0.05, 0.08, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]


def pulls(
    ahead_n: float, astern_n: float, dead_band: float, noise_n: float, seed: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    draws = random.Random(seed)
    throttle = np.array([*STEPS, *(-u for u in STEPS)])
    force = np.where(throttle > 0.0, ahead_n, astern_n) * throttle * np.abs(throttle)
    force[np.abs(throttle) < dead_band] = 0.0
    return throttle, force + np.array([draws.gauss(0.0, noise_n) for _ in throttle])


@pytest.mark.parametrize("seed", range(8))
def test_a_known_thruster_comes_back(seed: int) -> None:
    found = fit(*pulls(240.0, 180.0, 0.12, 0.3, seed))
    assert found.astern is not None
    assert found.ahead.full_n == pytest.approx(240.0, abs=4.0 * found.ahead.sigma_n)
    assert found.astern.full_n == pytest.approx(180.0, abs=4.0 * found.astern.sigma_n)
    assert found.ahead.sigma_n < 0.5 and found.rms_n < 0.5
    assert 0.1 <= found.dead_band <= 0.15


def test_each_side_agrees_with_scipy() -> None:
    throttle, force = pulls(27.0, 14.0, 0.0, 0.4)
    found = fit(throttle, force)
    at = throttle >= max(found.dead_band, 1e-9)
    (expected,), covariance = curve_fit(lambda u, k: k * u * u, throttle[at], force[at])
    assert found.ahead.full_n == pytest.approx(expected, rel=1e-6)
    assert found.ahead.sigma_n == pytest.approx(float(np.sqrt(covariance[0, 0])), rel=1e-3)


def test_the_revolts_own_figures_from_the_thesis() -> None:
    """K 2.7e-3 N per %² is 27 N at full throttle."""
    percent = np.array([10.0, 20.0, 40.0, 60.0, 80.0, 100.0])
    found = fit(percent / 100.0, 2.7e-3 * percent**2)
    assert found.ahead.full_n == pytest.approx(load_vessel("revolt").thrusters[0].ahead_n, rel=0.01)
    assert found.astern is None and "astern: too few" in report(found)


@pytest.mark.parametrize(
    ("throttle", "force_n"),
    [
        ([1.0] * 4, [50.0, 51.0, 49.0, 50.0]),
        ([0.5] * 4, [50.0, 51.0, 49.0, 50.0]),
        ([0.0, 0.3, 0.5, 0.8, 1.0], [0.0] * 5),
    ],
)
def test_one_throttle_again_and_again_or_no_pull_gives_no_curve(throttle: list[float], force_n: list[float]) -> None:
    """They ended in a traceback, or in a curve of one point."""
    with pytest.raises(BollardError, match="too few measurements ahead: at least 4 throttles that pull"):
        fit(np.array(throttle), np.array(force_n))


def test_a_thruster_that_does_not_pull_astern_gets_no_curve_there() -> None:
    throttle, force = pulls(50.0, 30.0, 0.0, 0.0)
    found = fit(throttle, np.where(throttle < 0.0, 0.0, force))
    assert found.astern is None and "astern_n" not in toml_lines(found, "bow")


def test_a_scale_without_a_sign() -> None:
    throttle, force = pulls(50.0, 30.0, 0.0, 0.0)
    found = fit(throttle, np.abs(force))
    assert found.astern is not None and found.astern.full_n == pytest.approx(30.0)


def test_a_reversed_thruster_and_too_few_points_are_refused() -> None:
    throttle, force = pulls(50.0, 30.0, 0.0, 0.0)
    with pytest.raises(BollardError, match="opposite to the throttle"):
        fit(throttle, -force)
    with pytest.raises(BollardError, match="too few"):
        fit(np.array([0.5, 1.0]), np.array([10.0, 40.0]))
    with pytest.raises(BollardError, match=r"no measurements|too few"):
        fit(np.array([]), np.array([]))
    with pytest.raises(BollardError, match="throttles that pull"):
        fit(throttle, np.zeros_like(force))


def test_a_linear_thruster_is_told() -> None:
    found = fit(np.array(STEPS), 40.0 * np.array(STEPS))
    assert "not as its square" in report(found) and "that is large" in report(found)


def test_the_file_in_percent_with_comments(tmp_path: Path) -> None:
    file = tmp_path / "pull.csv"
    file.write_text(
        "# port motor, 12.6 V\nthrottle, force_n\n20, 9.6\n50, 60\n-100, -180\n\n100, 240\n", encoding="utf-8"
    )
    throttle, force = read_pulls(file)
    assert throttle.tolist() == [0.2, 0.5, -1.0, 1.0] and force.tolist() == [9.6, 60.0, -180.0, 240.0]


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("throttle,pull\n1,2\n", "no column force_n"),
        ("throttle,force_n\n0.5,ten\n", "pull.csv:2: 0.5, ten: must be two numbers"),
        ("# port motor\n\nthrottle,force_n\n0.2,3\n\n# again\n0.5,ten\n", "pull.csv:7: 0.5, ten: must be two numbers"),
        ("throttle,force_n\n0.5\n", "two numbers"),
        ("throttle,force_n\n0.5,nan\n", "not a finite"),
        ("throttle,force_n\n150,3\n20,1\n", "−1 to 1"),
        ("", "no column"),
    ],
)
def test_a_bad_line_is_named(text: str, remedy: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "pull.csv"
    file.write_text(text, encoding="utf-8")
    assert main(["bollard", str(file)]) == 2
    assert remedy in capsys.readouterr().err


def test_a_spreadsheets_own_encoding_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "pull.csv"
    file.write_bytes("throttle,force_n\n0.5,20\n".encode("utf-16"))
    assert main(["bollard", str(file)]) == 2
    assert "not UTF-8 text" in capsys.readouterr().err


def test_a_side_that_was_not_fitted_has_no_curve() -> None:
    found = fit(np.array([0.2, 0.4, 0.6, 1.0, -0.5, -1.0]), np.array([2.0, 8.0, 18.0, 50.0, -5.0, -20.0]))
    assert (
        found.astern is None
        and np.isnan(found.curve_n(np.array([-1.0]))).all()
        and np.isfinite(found.curve_n(np.array([1.0]))).all()
    )


def test_the_command_prints_lines_that_a_vessels_file_takes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import tomllib

    throttle, force = pulls(240.0, 180.0, 0.12, 2.0)
    file = tmp_path / "pull.csv"
    file.write_text(
        "throttle,force_n\n" + "".join(f"{u},{n}\n" for u, n in zip(throttle, force, strict=True)), encoding="utf-8"
    )
    assert main(["bollard", str(file), "--thruster", "bow", "--plot", str(tmp_path / "pull.png")]) == 0
    lines = tomllib.loads(toml_lines(fit(throttle, force), "bow"))
    assert set(lines) == {"ahead_n", "max_n", "astern_n", "min_n", "dead_band"}
    assert lines["min_n"] < 0.0 < lines["max_n"] <= lines["ahead_n"]
    assert "ahead_n = " in capsys.readouterr().out
    assert (tmp_path / "pull.png").stat().st_size > 10_000
    plot(fit(throttle, force), "bow", tmp_path / "again.png")

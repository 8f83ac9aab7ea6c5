"""Whether a covariance is found to be that of the errors, or not, on errors whose distribution is known; what the
command sails and keeps."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from companion.cli.main import main
from companion.config.vessel import find, load
from sitl.evaluate import consistency
from sitl.evaluate.consistency import Case, Run, Sample, all_innovations, spread, verdicts
from sitl.evaluate.consistency_table import figures, lines
from sitl.evaluate.normalised import judge_bias, judge_squares, normalised_squares, square_band
from sitl.evaluate.told_sensors import told
from sitl.sensors import GRADES, YAW_RAD, YAW_TAU_S

RUNS, INSTANTS, TIMES = 20, 6, 200
COVARIANCE = np.array(
    [
        [0.04, 0.01, 0.002, 0.0, 0.001],
        [0.01, 0.09, 0.0, 0.003, -0.002],
        [0.002, 0.0, 0.01, 0.001, 0.0],
        [0.0, 0.003, 0.001, 0.02, 0.0],
        [0.001, -0.002, 0.0, 0.0, 0.005],
    ]
)
CASE = Case(False, (), (9.0, 10.0))


def drawn(seed: int, true: np.ndarray = COVARIANCE, offset: float = 0.0) -> list[Run]:
    """Runs with errors of that covariance, which the filter takes for `COVARIANCE`."""
    rng = np.random.default_rng(seed)
    believed = tuple(map(tuple, COVARIANCE.tolist()))
    errors = rng.multivariate_normal(np.full(5, offset), true, (RUNS, INSTANTS))
    squares = rng.chisquare(2, (RUNS, INSTANTS)) / 2.0
    return [
        Run(
            tuple(
                Sample(60.0 * i, tuple(errors[run, i]), believed, {"position": squares[run, i]})
                for i in range(INSTANTS)
            ),
            {"position": float(squares[run].mean())},
        )
        for run in range(RUNS)
    ]


def test_squares_by_hand() -> None:
    errors = np.array([[3.0, 4.0], [1.0, 1.0], [1.0, -1.0]])
    covariances = np.array([[[9.0, 0.0], [0.0, 4.0]], [[2.0, 1.0], [1.0, 2.0]], [[2.0, 1.0], [1.0, 2.0]]])
    assert normalised_squares(errors, covariances) == pytest.approx([(1.0 + 4.0) / 2.0, 1.0 / 3.0, 1.0])


def test_the_band_is_that_of_the_tables() -> None:
    """Chi-square of 100 degrees of freedom: 74.22 and 129.56."""
    assert square_band(5, 20) == pytest.approx((0.7422, 1.2956), abs=1e-4)
    assert square_band(2, 20) == pytest.approx((24.433 / 40.0, 59.342 / 40.0), abs=1e-4)


def test_a_consistent_filter_is_inside_in_about_95_percent() -> None:
    found = [verdicts(drawn(seed)) for seed in range(TIMES)]
    for kind, parts in found[0].items():
        for part in parts:
            ours = [one[kind][part] for one in found]
            inside = sum(INSTANTS - one.outside for one in ours) / (TIMES * INSTANTS)
            assert 0.93 < inside < 0.97, (kind, part)
            assert sum(one.inside for one in ours) >= 0.94 * TIMES, (kind, part)
            centre = 0.0 if kind == "bias" else 1.0
            covered = sum(abs(one.mean - centre) <= one.half for one in ours) / TIMES
            assert 0.91 < covered < 0.99, (kind, part)


@pytest.mark.parametrize(("factor", "word"), [(1.6, "over-confident"), (0.6, "cautious")])
def test_a_filter_with_another_covariance_is_outside(factor: float, word: str) -> None:
    found = [verdicts(drawn(seed, factor * COVARIANCE))["NEES"]["all five"] for seed in range(40)]
    assert all(one.word == word for one in found)
    assert np.mean([one.mean for one in found]) == pytest.approx(factor, rel=0.02)


def test_a_filter_beside_the_truth_is_biased() -> None:
    found = verdicts(drawn(1, offset=0.1))["bias"]
    assert found["heading"].word == "biased" and found["heading"].mean > 1.0


def test_only_the_part_that_is_wrong_is_outside() -> None:
    wrong = COVARIANCE.copy()
    wrong[4, :4] = wrong[:4, 4] = 0.0
    wrong[4, 4] *= 4.0
    found = verdicts(drawn(2, wrong))
    assert found["NVS"]["heading"].word == found["NEES"]["heading"].word == "over-confident"
    assert found["NEES"]["position"].inside and found["NEES"]["velocity"].inside and found["NVS"]["north"].inside


def test_an_innovation_counts_where_every_run_has_one() -> None:
    runs = drawn(3)
    silent = runs[0].samples[2]
    samples = (*runs[0].samples[:2], Sample(silent.t_s, silent.errors, silent.covariance, {}), *runs[0].samples[3:])
    found = verdicts([Run(samples, runs[0].innovations), *runs[1:]])["NIS"]
    assert len(found["position"].means) == INSTANTS - 1 and "heading" not in found
    assert all_innovations(runs).keys() == {"position"}


def test_errors_beside_their_sigmas() -> None:
    pairs = spread(drawn(4))["heading"]
    assert len(pairs) == INSTANTS
    assert [sigma for _, sigma in pairs] == pytest.approx([math.sqrt(0.005)] * INSTANTS)
    assert np.mean([error for error, _ in pairs]) == pytest.approx(math.sqrt(0.005), rel=0.15)


def test_one_run_is_not_enough() -> None:
    with pytest.raises(ValueError, match="one run"):
        judge_squares([[1.0, 1.0]], 2)
    with pytest.raises(ValueError, match="one run"):
        judge_bias([[0.0]])


def test_what_people_read() -> None:
    text = "\n".join(lines({"hold": figures(CASE, drawn(5, 4.0 * COVARIANCE))}))
    assert "hold, 20 seeds, at 9 10 s" in text
    assert "NEES all five" in text and "in 0.74 to 1.30: over-confident" in text
    assert "NIS of all measurements, position" in text


def test_a_told_file_has_the_figures_of_the_simulated_sensors() -> None:
    gnss, imu = told(load(find("revolt")), "rtk").sensors
    fixed, plain = gnss.rtk_fixed, GRADES["standalone"]
    assert fixed is not None and fixed.wander_m == GRADES["rtk"].slow_m and fixed.velocity_mps == 0.015
    assert gnss.rtk_float is not None and gnss.rtk_float.wander_m == GRADES["float"].slow_m
    assert (gnss.position_wander_m, gnss.velocity_accuracy_mps) == (plain.slow_m, plain.velocity_mps)
    assert gnss.heading_wander_rad == GRADES["rtk"].heading_rad
    assert imu.accelerometer_noise_mps2_rthz == pytest.approx(0.00045)
    sbas = told(load(find("aboat")), "sbas").sensors[0]
    assert sbas.position_wander_m == GRADES["sbas"].slow_m
    assert 0.5 * sbas.velocity_accuracy_mps == GRADES["sbas"].velocity_mps
    assert sbas.heading_wander_rad is None, "one antenna gives no heading"


def test_a_told_file_has_the_yaw_of_an_inertial_sensor_that_serves_as_a_compass() -> None:
    imu = told(load(find("aboat")), "sbas").sensors[1]
    assert (imu.heading_wander_rad, imu.heading_wander_s) == (YAW_RAD, YAW_TAU_S)
    assert imu.heading_noise_rad is not None and imu.heading_noise_rad < 0.01 * YAW_RAD, "its error is slow, not noise"
    assert told(load(find("revolt")), "rtk").sensors[1].heading_noise_rad is None, "its yaw is no heading"


def test_the_command_sails_once_and_keeps_its_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(consistency.CASES, "hold", CASE)  # type: ignore[arg-type]
    words = ["evaluate", "consistency", "revolt", "--case", "hold", "--seeds", "0-1", "--jobs", "1"]
    words += ["--out", str(tmp_path / "runs"), "--json", str(tmp_path / "found.json")]
    assert main(words) == 0
    first = capsys.readouterr().out
    assert "NEES all five" in first and "NIS position" in first
    found = json.loads((tmp_path / "found.json").read_text())
    assert found["seeds"] == [0, 1] and found["cases"]["hold"]["runs"] == 2
    monkeypatch.setattr(consistency, "sail", lambda *_: pytest.fail("sailed again"))
    assert main(words) == 0 and capsys.readouterr().out == first


def test_runs_of_another_file_of_the_same_name_do_not_count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As of a file of one's own whose sensors were told anew since."""
    monkeypatch.setitem(consistency.CASES, "hold", CASE)  # type: ignore[arg-type]
    sail, sailed = consistency.sail, []
    monkeypatch.setattr(consistency, "sail", lambda *words: sailed.append(1) or sail(*words))
    for folder, more in (("a", ""), ("b", "\n"), ("b", "\n")):
        (tmp_path / folder).mkdir(exist_ok=True)
        boat = tmp_path / folder / "boat.toml"
        boat.write_text(find("revolt").read_text(encoding="utf-8") + more, encoding="utf-8")
        words = ["evaluate", "consistency", str(boat), "--case", "hold", "--seeds", "0-1", "--jobs", "1"]
        assert main([*words, "--out", str(tmp_path / "runs")]) == 0
    assert len(sailed) == 4


def test_mistakes_are_said(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evaluate", "consistency", "revolt", "--case", "holt"]) == 2
    assert "did you mean 'hold'" in capsys.readouterr().err
    assert main(["evaluate", "consistency", "revolt", "--seeds", "3"]) == 2
    assert "two or more" in capsys.readouterr().err

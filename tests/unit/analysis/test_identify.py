"""A hull sailed by the plant's own equations, its log with noise, and what is identified from it."""

from __future__ import annotations

import binascii
import json
import math
import random
import struct
import tomllib
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from companion.analysis.force_balance import equation_error
from companion.analysis.hull_fit import HullFit, fit
from companion.analysis.hull_model import HullModel
from companion.analysis.identify import advice, identify, toml_lines, verdict
from companion.analysis.log_reader import Log, LogError, open_log
from companion.analysis.manoeuvre import groups_of, lagged, measured_wind, read_manoeuvre, timely
from companion.cli.main import main
from companion.config import vessel as config_module
from companion.config.hull import DampingConfig, HullConfig, WindageConfig
from companion.config.vessel import VesselConfig, find, load
from sitl.hull import Hull
from sitl.thrusters import build

PERIOD_S = 0.1
TRUE = HullConfig(
    240.0, 330.0, 300.0, 7.0, 7.03, DampingConfig(x_u=40.0, x_uu=20.0, y_v=15.0, y_vv=300.0, n_r=25.0, n_rr=200.0)
)
TRUE_X_M = (-1.4, -1.4, 1.25)
LAG_S = 0.4


def vessel() -> VesselConfig:
    return config_module.load(config_module.find("revolt"))


def sailed(
    folder: Path,
    commands: list[tuple[tuple[float, float], ...]],
    current: tuple[float, float] = (0.0, 0.0),
    gusts: tuple[float, float, float] = (0.0, 0.0, 0.0),
    hull: HullConfig = TRUE,
) -> Log:
    """A log of (throttle, azimuth) commands, one tuple a second, on the hull TRUE or another. Noise as the estimator's; gusts of
    these deviations in N, N and Nm that last 10 s. All seeded."""
    config, chance = replace(vessel(), windage=WindageConfig()), random.Random(7)
    plant, thrusters = Hull(hull), build(config.thrusters, LAG_S, TRUE_X_M)
    plant.set_current(*current)
    names = [t.name for t in config.thrusters]
    parts = ",".join(f"{name}_{part}" for name in names for part in ("throttle", "azimuth_rad", "force_n"))
    rows = [f"t_s,armed,position_valid,yaw_rad,surge_mps,sway_mps,yaw_rate_radps,{parts}"]
    azimuths = [t.azimuth_rad for t in config.thrusters]
    gust = [0.0, 0.0, 0.0]
    for tick in range(len(commands) * 10):
        reach = [t.azimuth_rate_radps * PERIOD_S for t in config.thrusters]  # as the allocation does
        azimuths = [
            a + min(r, max(-r, want - a)) for a, r, (_, want) in zip(azimuths, reach, commands[tick // 10], strict=True)
        ]
        now = [(throttle, azimuth) for (throttle, _), azimuth in zip(commands[tick // 10], azimuths, strict=True)]
        cells = []
        for thruster, limits, (throttle, azimuth) in zip(thrusters, config.thrusters, now, strict=True):
            turns = limits.kind == "azimuth"
            thruster.demand(throttle, azimuth if turns else None)
            force = (limits.ahead_n if throttle >= 0 else limits.astern_n) * throttle * abs(throttle)
            force = min(limits.max_n, max(limits.min_n, force))
            cells.append(f"{throttle:.4f},{f'{azimuth:.5f}' if turns else ''},{force:.3f}")
        u, v = plant.surge_mps + chance.gauss(0.0, 0.004), plant.sway_mps + chance.gauss(0.0, 0.004)
        r = plant.yaw_rate_radps + chance.gauss(0.0, 0.0008)
        rows.append(f"{tick * PERIOD_S:.3f},1,1,{plant.yaw_rad:.5f},{u:.4f},{v:.4f},{r:.5f}," + ",".join(cells))
        gust = [0.99005 * g + chance.gauss(0.0, 0.1407 * size) for g, size in zip(gust, gusts, strict=True)]
        for _ in range(10):
            wrench = list(gust)
            for thruster in thrusters:
                thruster.step(0.01)
                wrench = [a + b for a, b in zip(wrench, thruster.wrench(), strict=True)]
            plant.step(*wrench, 0.01)
    (folder / "ticks.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    entries = {"configuration": config_module.as_dict(config), "parameters": {}}
    (folder / "manifest.json").write_text(json.dumps(entries), encoding="utf-8")
    return open_log(folder)


def lively(seconds: int = 200) -> list[tuple[tuple[float, float], ...]]:
    """Random thrust in all directions, each for some seconds."""
    chance = random.Random(3)
    commands = []
    while len(commands) < seconds:
        azimuth = chance.uniform(-0.3, 0.3) + chance.choice((0.0, 1.3, -1.3))
        one = tuple((chance.uniform(-0.6, 0.6), azimuth) for _ in range(2))
        commands += [(*one, (chance.uniform(-0.6, 0.6), 0.0))] * chance.randint(3, 9)
    return commands[:seconds]


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Log:
    return sailed(tmp_path_factory.mktemp("lively"), lively())


@pytest.fixture(scope="module")
def found(log: Log) -> HullFit:
    return fit(log, read_manoeuvre(log, []))


def drags(hull: HullConfig, speed: float) -> tuple[float, float, float]:
    d = hull.damping
    return tuple(speed * (a + b * speed) for a, b in ((d.x_u, d.x_uu), (d.y_v, d.y_vv), (d.n_r, d.n_rr)))  # type: ignore[return-value]


def test_a_known_hull_is_found(found: HullFit) -> None:
    hull = found.hull
    assert (hull.m11_kg, hull.m22_kg, hull.m33_kgm2) == pytest.approx((240.0, 330.0, 300.0), rel=0.06)
    assert drags(hull, 0.2) == pytest.approx(drags(TRUE, 0.2), rel=0.10)
    assert (found.thrusters[0].x_m, found.thrusters[2].x_m) == pytest.approx((-1.4, 1.25), rel=0.06)
    by_name = {e.name: e for e in found.estimates}
    assert by_name["lag_s"].value == pytest.approx(LAG_S, abs=0.08)
    assert by_name["scale stern_port+stern_starboard"].sigma is None


def test_the_truth_lies_within_the_uncertainties(found: HullFit) -> None:
    truth = {
        "m11_kg": 240.0,
        "m22_kg": 330.0,
        "m33_kgm2": 300.0,
        "x_u": 40.0,
        "x_uu": 20.0,
        "y_v": 15.0,
        "y_vv": 300.0,
        "n_r": 25.0,
        "n_rr": 200.0,
    }
    for estimate in found.estimates:
        if estimate.name in truth and estimate.sigma is not None:
            assert abs(estimate.value - truth[estimate.name]) < 4.0 * estimate.sigma + 0.02 * truth[estimate.name], (
                estimate
            )


def test_what_the_forces_leave_is_the_noise(log: Log, found: HullFit) -> None:
    model = HullModel(log, read_manoeuvre(log, []))
    start = equation_error(model, {f"scale {model.groups[0].name}": ""})
    rest = model.manoeuvre.velocity - model.simulate(start)
    assert all(
        after <= 1.02 * before
        for after, before in zip(found.residual_rms, np.sqrt((rest**2).mean(axis=0)), strict=True)
    )
    assert found.residual_rms == pytest.approx((0.004, 0.004, 0.0008), rel=0.25)


def test_the_two_ways_to_write_the_equations_agree(log: Log) -> None:
    """The imbalance of velocities that the model itself has simulated is nothing but the steps' error."""
    model = HullModel(log, read_manoeuvre(log, []))
    values = {**model.model, "current_north_mps": 0.1, "lag_s": 0.4}
    ideal = HullModel(log, replace(model.manoeuvre, velocity=model.simulate(values)))
    assert np.abs(ideal.imbalance(values)).max(axis=0) == pytest.approx((0.0, 0.0, 0.0), abs=0.015)


def test_the_equations_are_those_of_the_plant(log: Log) -> None:
    """The model with the true numbers follows the plant, which was programmed apart from it."""
    model = HullModel(log, read_manoeuvre(log, []))
    true = {name: getattr(TRUE, name, getattr(TRUE.damping, name, value)) for name, value in model.model.items()}
    true |= {"lag_s": LAG_S, "x_m stern_port+stern_starboard": -1.4, "x_m bow": 1.25}
    rest = model.manoeuvre.velocity - model.simulate(true)
    assert np.sqrt((rest**2).mean(axis=0)) == pytest.approx((0.004, 0.004, 0.0008), rel=0.3)


def test_a_current_does_not_spoil_it(tmp_path: Path) -> None:
    log = sailed(tmp_path, lively(), current=(0.12, -0.08))
    found = fit(log, read_manoeuvre(log, []))
    assert drags(found.hull, 0.2) == pytest.approx(drags(TRUE, 0.2), rel=0.15)
    by_name = {e.name: e.value for e in found.estimates}
    assert (by_name["current_north_mps"], by_name["current_east_mps"]) == pytest.approx((0.12, -0.08), abs=0.02)


def test_gusts_do_not_spoil_it_and_the_uncertainty_knows_of_them(tmp_path: Path, found: HullFit) -> None:
    log = sailed(tmp_path, lively(), gusts=(1.0, 2.5, 1.0))
    gusty = fit(log, read_manoeuvre(log, []))
    assert drags(gusty.hull, 0.2) == pytest.approx(drags(TRUE, 0.2), rel=0.2)
    for drag, calm, truth in zip(
        gusty.drags, found.drags, (drags(TRUE, d.speed)[i] for i, d in enumerate(gusty.drags)), strict=True
    ):
        assert drag.determined and abs(drag.force - truth) < 3.0 * drag.sigma
        assert drag.sigma > 1.2 * calm.sigma
    assert gusty.gusts == pytest.approx((1.0, 2.5, 1.0), rel=0.5)


def test_the_measured_wind_is_that_over_ground(log: Log, tmp_path: Path) -> None:
    """A boat that turns and moves under a steady wind of 5 m/s towards north and −2 m/s towards east."""
    t_s = np.arange(0.0, 60.0, 0.1)
    yaw, velocity = 0.05 * t_s, np.stack([0.3 + 0.0 * t_s, 0.1 * np.sin(t_s), 0.05 + 0.0 * t_s], axis=1)
    lines = [b"kind,source,values\n", b"wind,mast,garbage\n"]
    for when, heading, (u, v, _) in zip(t_s[::2], yaw[::2], velocity[::2], strict=True):
        x = 5.0 * math.cos(heading) - 2.0 * math.sin(heading) - u
        y = -2.0 * math.cos(heading) - 5.0 * math.sin(heading) - v
        values = struct.pack("<3d", when, math.hypot(x, y), math.atan2(-y, -x))
        lines.append(b"wind,mast," + binascii.b2a_base64(values))
    (tmp_path / "readings.csv").write_bytes(b"".join(lines))
    warnings: list[str] = []
    wind = measured_wind(replace(log, folder=tmp_path), warnings, t_s, yaw, velocity)
    assert wind is not None and len(warnings) == 1
    assert wind[20:-20] == pytest.approx(np.tile([5.0, -2.0], (len(t_s) - 40, 1)), abs=0.02)
    (tmp_path / "readings.csv").write_bytes(b"".join(lines[:50]))
    assert (
        measured_wind(replace(log, folder=tmp_path), warnings, t_s, yaw, velocity) is None and "silent" in warnings[-1]
    )


def test_a_yaw_rate_that_is_late_is_put_right() -> None:
    t_s = np.arange(0.0, 60.0, 0.1)
    true, yaw = 0.1 * np.sin(0.6 * t_s), -0.1 / 0.6 * np.cos(0.6 * t_s)
    late = 0.1 * np.sin(0.6 * (t_s - 0.08))
    assert np.abs(late - true).max() > 4e-3
    assert np.abs(timely(late, yaw, ((0, 600),), 0.1) - true)[10:-10].max() < 3e-4


def test_what_the_manoeuvre_does_not_tell_stays_near_the_model_and_is_said(tmp_path: Path) -> None:
    ahead = [((0.5 * (1 if second // 15 % 2 else -1), 0.0),) * 2 + ((0.0, 0.0),) for second in range(45)]
    log = sailed(tmp_path, ahead)
    found = fit(log, read_manoeuvre(log, []))
    by_name = {e.name: e for e in found.estimates}
    model = HullModel(log, read_manoeuvre(log, []))
    for name in ("m22_kg", "m33_kgm2", "y_vv", "n_v", "y_uv", "scale bow", "x_m bow"):
        assert by_name[name].held and by_name[name].sigma is None, by_name[name]
        assert abs(by_name[name].value - by_name[name].model) < model.doubt(name), by_name[name]
    said = " / ".join(advice(model, found))
    assert "go sideways more" in said and "turn more" in said and "surge" not in said
    assert found.hull.m11_kg == pytest.approx(240.0, rel=0.08) and drags(found.hull, 0.3)[0] == pytest.approx(
        drags(TRUE, 0.3)[0], rel=0.08
    )


def test_a_thruster_that_would_push_outside_the_boat_is_doubted(log: Log, found: HullFit) -> None:
    """As the fit has one that is reversed, or that gets the command of another one."""
    model = HullModel(log, read_manoeuvre(log, []))
    assert not any("outside the boat" in line for line in advice(model, found))
    moved = [replace(one, value=-3.6) if one.name == "x_m bow" else one for one in found.estimates]
    (line,) = [line for line in advice(model, replace(found, estimates=tuple(moved))) if "bow" in line]
    assert line.startswith("bow would push at -3.6 m, outside the boat of 3.0 m: is a thruster reversed")


def test_a_coupling_that_the_file_lacks_is_found(tmp_path: Path) -> None:
    """A hull whose drag has its centre ahead of the middle, with lift, against a file that has neither."""
    damping = replace(TRUE.damping, n_v=10.0, n_vv=120.0, y_r=8.0, y_rr=60.0, y_uv=120.0, n_uv=-100.0, n_ur=80.0)
    coupled = replace(TRUE, damping=damping)
    log = sailed(tmp_path, lively(), hull=coupled)
    by_name = {e.name: e for e in fit(log, read_manoeuvre(log, [])).estimates}
    for name in ("n_vv", "y_uv", "n_uv", "n_ur", "n_r", "y_vv"):
        one, true = by_name[name], getattr(damping, name)
        assert one.sigma is not None, one
        assert abs(one.value - true) < 2.5 * one.sigma and abs(one.value - true) < 0.4 * abs(true), (one, true)
    assert abs(by_name["n_vv"].value) > 2.0 * (by_name["n_vv"].sigma or math.inf)  # other than none


def test_a_quantity_is_held_when_asked(log: Log) -> None:
    found = fit(log, read_manoeuvre(log, [], to_s=60.0), hold=("m11_kg",))
    assert found.hull.m11_kg == log.config.hull.m11_kg
    assert next(e for e in found.estimates if e.name == "m11_kg").held == "as asked"


def test_report_toml_and_plot(log: Log, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    assert main(["identify", str(log.folder), "--out", str(tmp_path), "--to", "70"]) == 0
    shown = capsys.readouterr().out
    assert "m33_kgm2" in shown and "of the motion explained" in shown
    assert (tmp_path / "identified.png").read_bytes().startswith(b"\x89PNG") and (
        tmp_path / "identified.png"
    ).stat().st_size > 20_000
    text = config_module.find("revolt").read_text(encoding="utf-8")
    head, _, rest = text.partition("[hull]\n")
    lines = (tmp_path / "identified.toml").read_text(encoding="utf-8")
    vessel = config_module.parse(head + lines + rest[rest.index("[windage]") :], "pasted")
    assert vessel.hull.m11_kg == pytest.approx(240.0, rel=0.15) and vessel.hull.damping.y_vv > 0.0


def test_the_lines_keep_the_form_and_say_whether_they_are_worth_it(log: Log) -> None:
    """Wind areas follow from the form: lines without it would leave the boat without."""
    manoeuvre = read_manoeuvre(log, [], to_s=70.0)
    model, found = HullModel(log, manoeuvre), fit(log, manoeuvre)
    assert verdict(model, found) == []
    doubts = verdict(model, replace(found, simulated=2.0 * manoeuvre.velocity))
    planing = replace(found, hull=replace(found.hull, form="planing", resistance=((0.0, 0.0), (2.0, 30.0))))
    lines = toml_lines(log, planing, doubts)
    assert lines.splitlines()[1].startswith("# keep the figures of the vessel's file")
    hull = tomllib.loads(lines)["hull"]
    assert hull["form"] == "planing" and hull["resistance"] == [[0.0, 0.0], [2.0, 30.0]]


def test_what_cannot_be_identified_is_said(log: Log, tmp_path: Path) -> None:
    with pytest.raises(LogError, match="at least 30 s"):
        read_manoeuvre(log, [], from_s=190.0)
    with pytest.raises(LogError, match="m44"):
        identify(log, tmp_path, to_s=60.0, hold=("m44",))


@pytest.mark.parametrize("every", [2, 15])
def test_a_log_with_a_gap_at_every_moment_is_no_manoeuvre(log: Log, tmp_path: Path, every: int) -> None:
    """As of a computer that is too slow for the control rate, or of a receiver that comes and goes."""
    head, *rows = (log.folder / "ticks.csv").read_text(encoding="utf-8").splitlines()
    kept = [row for number, row in enumerate(rows) if number % every]
    (tmp_path / "ticks.csv").write_text("\n".join([head, *kept]) + "\n", encoding="utf-8")
    with pytest.raises(LogError, match="only 0 s have no gap for 2 s"):
        identify(replace(log, folder=tmp_path), tmp_path)


def test_a_hull_that_no_plant_has_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scenario", "run", "identify", "--set", "hull=raft", "--out", str(tmp_path)]) == 2
    assert "has none of that name; try --set hull=as_sailed" in capsys.readouterr().err


def test_half_a_last_line_is_left_out(log: Log, tmp_path: Path) -> None:
    data = (log.folder / "ticks.csv").read_bytes()
    (tmp_path / "ticks.csv").write_bytes(data[:-20])
    (tmp_path / "manifest.json").write_bytes((log.folder / "manifest.json").read_bytes())
    warnings: list[str] = []
    assert len(read_manoeuvre(open_log(tmp_path), warnings).t_s) == 1999 and len(warnings) == 1


def test_a_gap_begins_a_new_stretch(log: Log, tmp_path: Path) -> None:
    lines = (log.folder / "ticks.csv").read_bytes().splitlines(keepends=True)
    (tmp_path / "ticks.csv").write_bytes(b"".join(lines[:801] + lines[1001:]))
    (tmp_path / "manifest.json").write_bytes((log.folder / "manifest.json").read_bytes())
    assert read_manoeuvre(open_log(tmp_path), []).stretches == ((0, 800), (800, 1800))


def test_groups_and_lag(log: Log) -> None:
    groups = groups_of(log.config.thrusters)
    assert [group.members for group in groups] == [(0, 1), (2,)]
    assert sorted(group.members for group in groups_of(log.config.thrusters, apart=True)) == [(0,), (1,), (2,)]
    manoeuvre = read_manoeuvre(log, [])
    force, target, was = lagged(manoeuvre, 0.5)[:, 0], manoeuvre.force_n[:, 0], manoeuvre.force_n[0, 0]
    expected = []
    for command in target.tolist():  # mean over a tick of the exact response
        expected.append(command + (was - command) * 5.0 * (1.0 - math.exp(-0.2)))
        was = command + (was - command) * math.exp(-0.2)
    assert force == pytest.approx(expected, abs=1e-9)


def test_the_figures_of_a_small_boat_are_not_rounded_away(log: Log, found: HullFit) -> None:
    """A model boat's inertia and damping in yaw were `0.00`, which its file refuses."""
    damping = replace(found.hull.damping, n_r=0.00432)
    small = replace(found, hull=replace(found.hull, m33_kgm2=0.0046, damping=damping))
    hull = tomllib.loads(toml_lines(log, small))["hull"]
    assert (hull["m33_kgm2"], hull["damping"]["n_r"]) == (0.0046, 0.00432)


def test_what_is_held_out_of_a_log_leaves_the_lag_of_the_thrust_as_it_was(log: Log) -> None:
    """Each part that was fitted began as if its first command had lasted for ever. With a lag of 0.9 s that made the
    thrust of a BlueBoat 27 % too small, and its drag by half."""
    whole = read_manoeuvre(log, [])
    parts = replace(whole, stretches=((0, 305), (405, 901), (951, 2000)))
    assert lagged(parts, 0.9) == pytest.approx(lagged(whole, 0.9), abs=1e-9)
    late = read_manoeuvre(log, [], from_s=30.5)
    assert lagged(late, 0.9) == pytest.approx(lagged(whole, 0.9)[305:], abs=1e-9)
    stopped = replace(late, force_n=0.0 * late.force_n)
    assert np.abs(lagged(stopped, 0.9)[0]).max() > 1.0 and np.abs(lagged(stopped, 0.9)[100]).max() < 1e-3


@pytest.mark.parametrize(("name", "reason"), [("rescuerunner", "depend on speed"), ("sailbot", "depends on the wind")])
def test_a_jet_and_a_sail_are_refused_with_the_reason(name: str, reason: str, tmp_path: Path) -> None:
    log = SimpleNamespace(config=load(find(name)), folder=tmp_path)
    with pytest.raises(LogError, match=reason):
        read_manoeuvre(log, [])  # type: ignore[arg-type]

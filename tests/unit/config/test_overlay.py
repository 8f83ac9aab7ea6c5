"""Overlays of a trial: which one counts, what it changes, and the way back."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from companion.cli.main import main
from companion.config.overlay import accepted, in_force, merged, overlay_name, overlays, set_accepted, that_count
from companion.config.vessel import ConfigError, bundled, find, load

OVERLAY = """
[trial]
accepted = false
[hull]
m11_kg = 300.0
[hull.damping]
x_u = 40.0
[[thruster]]
name = "bow"
x_m = 1.12
[parameters]
DP_BW_SURGE = 0.4
"""


@pytest.fixture
def vessel_file(tmp_path: Path) -> Path:
    path = tmp_path / "boat.toml"
    shutil.copyfile(find("revolt"), path)
    return path


def written(vessel_file: Path, date: str = "2026-11-22", text: str = OVERLAY) -> Path:
    path = vessel_file.with_name(overlay_name(vessel_file.stem, date))
    path.write_text(text, encoding="utf-8")
    return path


def test_tables_are_merged_and_rows_matched_by_name() -> None:
    base = {"a": 1, "t": {"x": 1, "y": 2}, "row": [{"name": "p", "k": 1}, {"name": "q", "k": 2}]}
    over = {"t": {"y": 3}, "row": [{"name": "q", "k": 5}, {"name": "gone", "k": 9}]}
    assert merged(base, over) == {
        "a": 1,
        "t": {"x": 1, "y": 3},
        "row": [{"name": "p", "k": 1}, {"name": "q", "k": 5}],
    }


def test_an_overlay_counts_only_once_it_is_accepted(vessel_file: Path) -> None:
    before, overlay = load(vessel_file), written(vessel_file)
    assert load(vessel_file) == before and in_force(vessel_file) is None
    assert main(["trial", "accept", str(overlay)]) == 0
    now = load(vessel_file)
    assert (now.hull.m11_kg, now.hull.m22_kg, now.hull.damping.x_u) == (300.0, before.hull.m22_kg, 40.0)
    assert (now.thrusters[2].x_m, now.thrusters[0]) == (1.12, before.thrusters[0])
    assert now.parameters["DP_BW_SURGE"] == 0.4 and now.parameters["DP_BW_SWAY"] == before.parameters["DP_BW_SWAY"]
    assert now.sitl == before.sitl


def test_undo_goes_back_to_the_one_before(vessel_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = load(vessel_file)
    first, second = written(vessel_file), written(vessel_file, "2026-11-23", OVERLAY.replace("300.0", "310.0"))
    for overlay in (first, second):
        set_accepted(overlay, True)
    assert load(vessel_file).hull.m11_kg == 310.0 and overlays(vessel_file) == (first, second)
    assert main(["trial", "undo", str(vessel_file)]) == 0
    assert load(vessel_file).hull.m11_kg == 300.0
    assert main(["trial", "list", str(vessel_file)]) == 0
    assert "2026-11-22.toml: in force" in capsys.readouterr().out
    assert main(["trial", "undo", str(vessel_file)]) == 0 and load(vessel_file) == before
    assert main(["trial", "undo", str(vessel_file)]) == 2


def test_bandwidths_alone_leave_the_model_of_the_trial_before(
    vessel_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As of a second trial, with the model of the first, that finds no better one. Its overlay took the boat back to
    the file's hull, thrusters and heading offset."""
    before, gains = load(vessel_file), "[trial]\naccepted = true\n[parameters]\nDP_BW_SURGE = 0.3\n"
    oldest = written(vessel_file, "2026-11-21", OVERLAY.replace("300.0", "290.0").replace("false", "true"))
    first = written(vessel_file, text=OVERLAY.replace("false", "true") + "DP_BW_SWAY = 0.2\n")
    second = written(vessel_file, "2026-11-23", gains)
    assert that_count(vessel_file) == (first, second) and in_force(vessel_file) == second
    now = load(vessel_file)
    assert (now.hull.m11_kg, now.hull.damping.x_u, now.thrusters[2].x_m) == (300.0, 40.0, 1.12)
    assert (now.parameters["DP_BW_SURGE"], now.parameters["DP_BW_SWAY"]) == (0.3, 0.2)
    assert main(["trial", "list", str(vessel_file)]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0] == f"{oldest}: accepted, replaced" and said[2] == f"{second}: in force"
    assert said[1] == f"{first}: in force, but for the parameters of later ones"
    assert main(["check", str(vessel_file)]) == 0
    assert f"model: {first.name}, {second.name}, as accepted" in capsys.readouterr().out
    first.write_text("[[", encoding="utf-8")
    assert load(vessel_file).hull.m11_kg == 290.0  # it says nothing of being accepted
    first.write_text("accepted = true\n[[", encoding="utf-8")
    with pytest.raises(ConfigError, match=rf"{first.name}: not valid TOML"):
        load(vessel_file)
    set_accepted(oldest, False)
    first.unlink()
    assert load(vessel_file).hull == before.hull


def test_an_overlay_from_a_log_is_copied_beside_the_vessel(vessel_file: Path, tmp_path: Path) -> None:
    (tmp_path / "log").mkdir()
    away = tmp_path / "log" / "revolt.trial-2026-11-22.toml"
    away.write_text(OVERLAY, encoding="utf-8")
    assert main(["trial", "accept", str(away)]) == 2
    assert main(["trial", "accept", str(away), "--vessel", str(vessel_file)]) == 0
    assert in_force(vessel_file) == vessel_file.with_name("boat.trial-2026-11-22.toml") and not accepted(away)


def test_another_overlay_of_the_same_day_stays_as_it_is(vessel_file: Path, tmp_path: Path) -> None:
    """As of two trials of a day, each identified in its log folder."""
    others = []
    for name, mass in (("a", "300.0"), ("b", "310.0")):
        (tmp_path / name).mkdir()
        others.append(tmp_path / name / "revolt.trial-2026-11-23.toml")
        others[-1].write_text(OVERLAY.replace("300.0", mass), encoding="utf-8")
    for overlay in (*others, others[0], others[1]):
        assert main(["trial", "accept", str(overlay), "--vessel", str(vessel_file)]) == 0
    assert len(overlays(vessel_file)) == 2 and load(vessel_file).hull.m11_kg == 310.0
    assert main(["trial", "undo", str(vessel_file)]) == 0
    assert load(vessel_file).hull.m11_kg == 300.0


def test_an_older_overlay_does_not_claim_to_count(vessel_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    older = written(vessel_file, "2026-11-20")
    newer = written(vessel_file, "2026-11-22", OVERLAY.replace("300.0", "310.0"))
    assert main(["trial", "accept", str(newer)]) == 0
    assert "from the next start on" in capsys.readouterr().out
    assert main(["trial", "accept", str(older)]) == 0
    said = capsys.readouterr().out
    assert "from the next start on" not in said and f"the newer {newer} counts until it is undone" in said
    assert main(["trial", "undo", str(vessel_file)]) == 0
    assert load(vessel_file).hull.m11_kg == 300.0


def test_an_overlay_with_an_error_is_not_accepted(vessel_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    overlay = written(vessel_file, text=OVERLAY.replace("m11_kg = 300.0", "m11_kg = -1.0"))
    assert main(["trial", "accept", str(overlay)]) == 2
    assert not accepted(overlay) and "m11_kg" in capsys.readouterr().err


def test_an_overlay_that_was_edited(vessel_file: Path) -> None:
    """A mark of Windows was no TOML, another encoding and a row without a name ended in a traceback."""
    overlay = written(vessel_file, text=OVERLAY.replace("false", "true") + "[[sensor]]\nx_m = 1.0\n")
    overlay.write_bytes(b"\xef\xbb\xbf" + overlay.read_bytes())
    assert load(vessel_file).hull.m11_kg == 300.0
    overlay.write_bytes(OVERLAY.encode() + "# für das Frühjahr".encode("latin-1"))
    with pytest.raises(ConfigError, match=r"boat\.toml: an overlay beside it is not text in UTF-8"):
        load(vessel_file)


def test_the_place_of_a_mistake_in_an_overlay_is_not_a_line_of_the_vessels_file(vessel_file: Path) -> None:
    overlay = written(vessel_file, text=OVERLAY.replace("false", "true").replace("m11_kg = 300.0", "m11_kg = -1.0"))
    with pytest.raises(ConfigError) as error:
        load(vessel_file)
    assert error.value.problems == (f"{overlay}: hull.m11_kg: should be greater than 0",)


def test_no_vessel_and_no_overlay_by_mistake(vessel_file: Path) -> None:
    assert main(["trial", "accept", str(vessel_file)]) == 2
    overlay = written(vessel_file, text="[hull]\n")
    assert main(["trial", "accept", str(overlay)]) == 2
    overlay.write_text("accepted = true\n[[", encoding="utf-8")
    with pytest.raises(ConfigError, match="not valid TOML"):
        load(vessel_file)
    assert not any(".trial-" in name for name in bundled())


@pytest.mark.parametrize("table", ["[sitl]\nbattery_wh = 500.0\n", "[sitl.plants.laden]\n[sitl.plants.laden.hull]\n"])
def test_a_boat_that_is_simulated_as_modelled_takes_an_overlay(
    tmp_path: Path, table: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A table [sitl] that names no plant means the hull of the file, with an overlay too."""
    vessel_file = tmp_path / "own.toml"
    text = find("heron").read_text(encoding="utf-8")
    assert "[sitl" not in text
    hull = "m11_kg = 40.0\nm22_kg = 60.0\nm33_kgm2 = 12.0\n[sitl.plants.laden.hull.damping]\nx_u = 9.0\ny_v = 9.0\nn_r = 9.0\n"
    vessel_file.write_text(text + table + (hull if "laden" in table else ""), encoding="utf-8")
    before, overlay = load(vessel_file), written(vessel_file, text="[trial]\naccepted = false\n[hull]\nm11_kg = 39.0\n")
    assert main(["trial", "accept", str(overlay)]) == 0
    assert load(vessel_file).hull.m11_kg == 39.0 and load(vessel_file).sitl == before.sitl
    assert main(["check", str(vessel_file)]) == 0
    assert f"model: {overlay.name}, as accepted after a sea trial" in capsys.readouterr().out

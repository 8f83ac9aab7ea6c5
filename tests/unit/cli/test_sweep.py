"""`companion sweep`: what is sailed, what is not sailed again, what it says, and its report."""

from __future__ import annotations

import functools
import json
import re
import shlex
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from companion.cli.main import argument_parser, main
from companion.cli.sweep import sweep
from companion.cli.sweep_progress import SweepProgress
from companion.config.vessel import ConfigError, find
from companion.core.progress import tell_nobody
from sitl.sweep.plan import contents_of
from sitl.sweep.rows import JOURNAL, PARQUET, Row, SweepError, read_parquet, write_parquet
from sitl.sweep.sailing import Sail
from tests.unit.sitl.sweep.fake_sails import TALE, sail, told_sail
from tests.unit.sitl.sweep.made import rows

DESIGN = """
name = "night"
text = "From calm to a gale"
seeds = 5
[[part]]
scenarios = ["hold"]
set = { wind = "{speed}@45" }
levels = { gnss = ["rtk", "sbas"] }
range.speed = { low = 0, high = 6, digits = 1 }
samples = 2
"""


def never() -> bool:
    return False


def design(folder: Path, text: str = DESIGN) -> Path:
    path = folder / "night.toml"
    path.write_text(text, encoding="utf-8")
    return path


def sail_it(
    folder: Path, *options: str, how: Sail = sail, interrupted: Callable[[], bool] = never, text: str = DESIGN
) -> int:
    words = ["sweep", str(design(folder, text)), "--jobs", "1", "--out", str(folder / "out"), *options]
    return sweep(argument_parser().parse_args(words), how, interrupted)


def found(folder: Path) -> list[Row]:
    return [replace(row, duration_s=0.0, cpu_s=0.0) for row in read_parquet(folder / "out" / PARQUET)]


def journalled(folder: Path) -> int:
    path = folder / "out" / JOURNAL
    return len(path.read_bytes().splitlines()) if path.exists() else 0


def test_a_file_alone_is_sailed_and_report_is_a_task() -> None:
    parse = argument_parser().parse_args
    assert parse(["sweep", "night.toml", "--keep"]) == parse(["sweep", "run", "night.toml", "--keep"])
    assert parse(["sweep", "--keep", "night.toml"]) == parse(["sweep", "run", "night.toml", "--keep"])
    assert parse(["sweep", "report", "out"]).folder == Path("out")


def test_the_command_of_the_report_is_what_a_shell_reads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "my sweeps"
    folder.mkdir()
    sail_it(folder)
    (command,) = re.findall("`companion (.*)` reports on it", capsys.readouterr().out)
    assert shlex.split(command) == ["sweep", "report", str(folder / "out")]


def test_a_sweep_that_is_cut_off_goes_on_and_sails_nothing_twice(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cut, whole = tmp_path / "cut", tmp_path / "whole"
    cut.mkdir()
    whole.mkdir()
    how = functools.partial(told_sail, cut)
    sail_it(cut, how=how, interrupted=lambda: journalled(cut) >= 6)
    assert len(found(cut)) == 6
    assert "6 of 20 runs sailed, 0 failed; interrupted: the same command goes on from here" in capsys.readouterr().out
    assert sail_it(cut, how=how) == 1
    assert "20 runs, 6 of them before" in capsys.readouterr().out
    assert sail_it(cut, how=how) == 1
    assert sail_it(whole) == 1
    assert found(cut) == found(whole) and len(found(cut)) == 20
    tale = (cut / TALE).read_text(encoding="utf-8").splitlines()
    assert len(set(tale)) == 20
    assert len(tale) <= 21, "the one that was in hand at the interrupt"


def test_more_seeds_sail_only_what_is_new(tmp_path: Path) -> None:
    how = functools.partial(told_sail, tmp_path)
    assert sail_it(tmp_path, how=how, text=DESIGN.replace("seeds = 5", "seeds = 1")) == 0
    assert sail_it(tmp_path, how=how, text=DESIGN.replace("seeds = 5", "seeds = 2")) == 0
    assert len((tmp_path / TALE).read_text(encoding="utf-8").splitlines()) == 8 == len(found(tmp_path))


def test_a_boat_whose_file_changed_is_not_mixed_with_what_it_was(tmp_path: Path) -> None:
    """The report counted the runs of both as one boat's."""
    boat = tmp_path / "boat.toml"
    boat.write_bytes(find("revolt").read_bytes())
    text = DESIGN.replace('["hold"]', f'["hold"]\nvessels = ["{boat}"]')
    assert sail_it(tmp_path, "--minutes", "60", text=text) == 1
    before = found(tmp_path)
    boat.write_text(boat.read_text(encoding="utf-8") + "# another one\n", encoding="utf-8")
    contents_of.cache_clear()  # a process asks once
    with pytest.raises(SweepError, match=r"boat\.toml before its file changed; choose another --out"):
        sail_it(tmp_path, text=text)
    boat.unlink()
    contents_of.cache_clear()
    with pytest.raises(SweepError, match="before its file changed"):
        sail_it(tmp_path)
    assert found(tmp_path) == before


def test_no_run_is_begun_after_the_minutes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert sail_it(tmp_path, "--minutes", "1e-9") == 0
    assert "0 of 20 runs sailed, 0 failed; the time is over" in capsys.readouterr().out
    assert sail_it(tmp_path, text=f"minutes = 1e-9\n{DESIGN}") == 0
    assert found(tmp_path) == []


def test_runs_of_another_commit_are_not_mixed_in(tmp_path: Path) -> None:
    sail_it(tmp_path, text=DESIGN.replace("seeds = 5", "seeds = 1"))
    path = tmp_path / "out" / JOURNAL
    lines = [{**json.loads(line), "commit": "old"} for line in path.read_text(encoding="utf-8").splitlines()]
    path.write_text("".join(f"{json.dumps(line)}\n" for line in lines), encoding="utf-8")
    with pytest.raises(SweepError, match=r"holds runs of old, .*choose another --out"):
        sail_it(tmp_path)


def test_failures_are_shown_as_they_happen(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sail_it(tmp_path)
    said = capsys.readouterr().out
    assert "FAIL contacts\n     companion scenario run hold --vessel revolt --seed 3 --set gnss=rtk --set wind=" in said
    assert "FAIL ValueError: no such wind\n     companion scenario run hold --vessel revolt --seed 4" in said
    assert "20 of 20 runs sailed, 8 failed" in said
    kept = [row for row in found(tmp_path) if row.log]
    assert all(not row.ok and (tmp_path / "out" / str(row.log)).is_dir() for row in kept) and len(kept) == 8


def test_many_failures_are_counted_and_the_rate_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bad = replace(rows(4, tmp_path)[3], key="x")
    progress = SweepProgress(tell_nobody, 2000, 0.0, lines=True)
    for second in range(1, 101):
        progress.take(bad, float(second))
    said = capsys.readouterr().out
    assert said.count("FAIL") == 10 and "further failures are counted" in said
    assert "60 of 2000 runs, 60 a minute, 32 min left, 60 failed" in said
    assert progress.words(50.0) == "100 of 2000 runs, 120 a minute, 16 min left, 100 failed"
    assert "5 h 17 min left" in progress.words(1000.0)


@pytest.mark.parametrize(
    ("options", "said"),
    [(["--jobs", "0"], "--jobs 0: must be at least 1"), (["--minutes", "0"], "--minutes 0: must be above 0")],
)
def test_options_out_of_range_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], said: str
) -> None:
    assert main(["sweep", str(design(tmp_path)), *options]) == 2
    assert said in capsys.readouterr().err


def test_a_design_with_a_mistake_is_refused_before_anything_is_made(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="did you mean 'hold'"):
        sail_it(tmp_path, text=DESIGN.replace('"hold"', '"holt"'))
    assert not (tmp_path / "out").exists()


def test_a_value_that_the_scenario_refuses_ends_the_sweep(tmp_path: Path) -> None:
    """By the real way to sail: it is refused before the boat is there."""
    from companion.cli.sweep import sail as real

    text = DESIGN.replace('"{speed}@45"', '"{speed}@north"')
    with pytest.raises(SweepError, match=r"companion scenario run hold .*@north.*: "):
        sail_it(tmp_path, how=real, text=text)
    assert found(tmp_path) == []


def test_an_address_without_a_port_is_refused(tmp_path: Path) -> None:
    """Dask's client left a stack trace behind."""
    with pytest.raises(SweepError, match="--scheduler shore-computer: write tcp://HOST:PORT"):
        sail_it(tmp_path, "--scheduler", "shore-computer")


def test_what_is_missing_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(SweepError, match=r"pip install 'usv-companion\[sweep\]'"):
        sail_it(tmp_path, "--scheduler", "tcp://127.0.0.1:1")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(SweepError, match=r"pip install 'usv-companion\[sweep\]'"):
        sail_it(tmp_path)


# --- report --------------------------------------------------------------------------------------------------------


def test_a_report_names_failures_worst_runs_and_figures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sail_it(tmp_path)
    capsys.readouterr()
    assert main(["sweep", "report", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "hold revolt gnss=rtk" in said and "worst of hold revolt gnss=sbas: companion scenario run hold" in said
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "<h1>night: 20 runs, 8 failed</h1>" in page and "From calm to a gale" in page
    assert page.count("--seed 4") == 4 and page.count("--seed 3") == 2, "the worst three of two points"
    assert "4 of 10 failed: 40 % (16.8 to 68.7)" in page
    assert (
        "position rms m" in page
        and "speed +" in page
        and "seed 3, speed " in page
        and page.count("data:image/png") == 2
    )


def test_a_sweep_that_was_killed_is_reported_from_its_journal(tmp_path: Path) -> None:
    sail_it(tmp_path)
    whole = found(tmp_path)
    (tmp_path / "out" / PARQUET).unlink()
    assert main(["sweep", "report", str(tmp_path / "out")]) == 0
    assert found(tmp_path) == whole


def test_a_metric_that_differs_by_rounding_alone_has_its_picture(tmp_path: Path) -> None:
    same = [
        replace(row, metrics={"time_s": value})
        for row, value in zip(rows(2, tmp_path), (171.2, 171.20000000000002), strict=True)
    ]
    write_parquet(same, tmp_path / PARQUET)
    assert main(["sweep", "report", str(tmp_path)]) == 0
    assert (tmp_path / "report.html").read_text(encoding="utf-8").count("data:image/png") == 1


def test_a_report_without_matplotlib_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    sail_it(tmp_path)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert main(["sweep", "report", str(tmp_path / "out"), "--out", str(tmp_path / "page.html")]) == 0
    assert "no pictures: matplotlib is not installed" in capsys.readouterr().out
    assert "data:image" not in (tmp_path / "page.html").read_text(encoding="utf-8")


def shifted(folder: Path) -> Path:
    """A sweep whose errors are smaller and whose failures are gone."""
    other = folder / "other"
    other.mkdir()
    better = [
        replace(row, ok=True, error=None, commit="new", metrics={n: v - 0.01 for n, v in row.metrics.items()})
        for row in read_parquet(folder / "out" / PARQUET)
    ]
    write_parquet(better, other / PARQUET)
    return other


def test_two_sweeps_are_compared_pair_by_pair(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sail_it(tmp_path)
    other = shifted(tmp_path)
    capsys.readouterr()
    assert main(["sweep", "report", str(other), "--against", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert "hold revolt gnss=rtk: 10 pairs, failures 4 → 0, p 0.125" in said
    assert "position_rms_m: median" in said
    assert "median difference" in (other / "report.html").read_text(encoding="utf-8")


def test_sweeps_that_have_several_values_of_a_setting_are_not_paired_without_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sail_it(tmp_path)
    other = shifted(tmp_path)
    capsys.readouterr()
    assert main(["sweep", "report", str(other), "--against", str(tmp_path / "out"), "--by", "gnss"]) == 2
    assert "--by gnss: one sweep has hold with several values of it" in capsys.readouterr().err


def test_the_values_of_a_setting_are_compared(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sail_it(tmp_path)
    capsys.readouterr()
    assert main(["sweep", "report", str(tmp_path / "out"), "--by", "gnss"]) == 0
    assert "gnss=sbas against gnss=rtk" in capsys.readouterr().out
    assert main(["sweep", "report", str(tmp_path / "out"), "--by", "law"]) == 2
    assert "--by law: no run sets that; those that are set: gnss, wind" in capsys.readouterr().err
    assert main(["sweep", "report", str(tmp_path / "out"), "--by", "gns"]) == 2
    assert "did you mean 'gnss'" in capsys.readouterr().err
    assert main(["sweep", "report", str(tmp_path / "out"), "--against", str(tmp_path / "out"), "--by", "law"]) == 2
    assert "--by law: no run sets that" in capsys.readouterr().err


def test_a_folder_without_a_sweep_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sweep", "report", str(tmp_path)]) == 2
    assert "no runs of a sweep there" in capsys.readouterr().err

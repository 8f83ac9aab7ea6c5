"""`companion hunt`: what it says, what it leaves, and that it goes on where it was."""

from __future__ import annotations

import functools
import json
import os
import signal
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from companion.analysis.capability import Capability
from companion.cli.crew import sail_to_the_end
from companion.cli.hunt import FINDINGS, BoatStrength, hunt
from companion.cli.main import argument_parser, main
from companion.config.vessel import VesselConfig, find, load
from sitl.sweep.rows import JOURNAL, PARQUET, read_parquet
from tests.unit.sitl.hunt.made import TALE, sail


def hunted(folder: Path, *options: str) -> int:
    words = ["hunt", "hold", "--jobs", "1", "--seed", "1", "--out", str(folder / "out"), *options]
    return hunt(argument_parser().parse_args(words), functools.partial(sail, folder), lambda: False)


def sailed(folder: Path) -> list[str]:
    return (folder / TALE).read_text(encoding="utf-8").splitlines()


def test_a_hunt_that_was_cut_off_asks_the_same_again_and_sails_only_the_rest(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def quickly(config: VesselConfig, lost: Sequence[str], current_mps: float, directions: int) -> Capability:
        """Less with each thruster that is lost and with the current, to nothing: any boat, since the hunt only asks."""
        held_mps = max(0.0, 8.0 - 3.0 * len(lost) - 9.0 * current_mps)
        return Capability((0.0,) * directions, (held_mps,) * directions, tuple(lost), current_mps)

    monkeypatch.setattr("companion.cli.hunt.capability", quickly)
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    whole.mkdir()
    parts.mkdir()
    code = hunted(whole, "--runs", "40")
    said = capsys.readouterr().out
    hunted(parts, "--runs", "15")
    assert hunted(parts, "--runs", "40") == code
    assert sailed(parts) == sailed(whole) and len(set(sailed(whole))) == 40
    ours = json.loads((parts / "out" / FINDINGS).read_text(encoding="utf-8"))
    assert ours == json.loads((whole / "out" / FINDINGS).read_text(encoding="utf-8"))
    assert code == (1 if ours else 0)
    rows = read_parquet(whole / "out" / PARQUET)
    assert len(rows) == 40 and all(row.safety["disarmed"] == 0.02 and row.log is None for row in rows)
    assert any(row.faults for row in rows)
    assert "fence: " in said and "companion scenario run hold" in said
    assert len((whole / "out" / JOURNAL).read_bytes().splitlines()) == 40
    assert not list((whole / "out" / "logs").glob("*"))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["holt"], "did you mean 'hold'"),
        (["hold", "--property", "fense"], "--property fense: one of fence"),
        (["hold", "--runs", "0"], "--runs 0: must be at least 1"),
        (["hold", "--seed", "-3"], "--seed -3: 0 to"),
        (["hold", "--property", "broke-off"], "return, broke_off"),
        (["hold", "--minutes", "-1"], "--minutes -1: must be above 0"),
        (["hold", "--vessel", "otter"], "hold is not for otter"),
        (["ahrs", "--vessel", "blueboat"], "ahrs is not for blueboat"),
    ],
)
def test_mistakes_are_told(words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["hunt", *words, "--out", str(tmp_path)]) == 2
    assert said in capsys.readouterr().err


def test_strength_is_what_capability_says() -> None:
    revolt = BoatStrength(load(find("revolt")))
    assert 4.0 < revolt.wind_mps(0.0, frozenset()) < 5.0
    assert revolt.wind_mps(0.0, frozenset({"bow"})) < revolt.wind_mps(0.0, frozenset())
    held_mps = revolt.current_mps(1.0, frozenset())
    assert revolt.wind_mps(held_mps, frozenset()) > 0.0 and revolt.wind_mps(held_mps + 0.02, frozenset()) == 0.0
    jet = BoatStrength(load(find("rescuerunner")))
    assert jet.wind_mps(0.3, frozenset()) == 8.0
    otter = BoatStrength(load(find("otter")))
    assert otter.wind_mps(0.0, frozenset()) > 8.0, "its bow lies in the wind"
    assert otter.wind_mps(0.0, frozenset({"port"})) == 0.0, "one fixed thruster drives it in circles"


def test_ctrl_c_ends_a_hunt_with_130_also_while_it_asks_what_the_boat_holds() -> None:
    before = [
        (number, signal.getsignal(number)) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE)
    ]

    def task(interrupted: Callable[[], bool]) -> int:
        assert not interrupted()
        os.kill(os.getpid(), signal.SIGINT)
        assert interrupted()
        with pytest.raises(KeyboardInterrupt):
            BoatStrength(load(find("revolt")), interrupted).wind_mps(0.0, frozenset())
        return 0

    try:
        with pytest.raises(KeyboardInterrupt):
            sail_to_the_end(argument_parser().parse_args(["hunt", "hold"]), task)
    finally:
        for number, handler in before:
            signal.signal(number, handler)

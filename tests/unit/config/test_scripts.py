"""[[script]] in a vessel's file: every fault with its place."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.app import script_problems
from companion.config.vessel import ConfigError, find, parse

REVOLT = find("revolt").read_text(encoding="utf-8")


def problems(rows: str, top: str = "") -> tuple[str, ...]:
    try:
        parse(top + REVOLT + rows, "boat.toml")
    except ConfigError as error:
        return error.problems
    return ()


GOOD = '[[script]]\nname = "a"\nfile = "a.py"\nmay = ["command"]\n'


def test_what_is_left_out_is_as_documented() -> None:
    (script,) = parse(REVOLT + GOOD, "boat.toml").scripts
    assert (script.restart, script.watchdog_s, script.memory_mb, script.arguments) == ("failure", 10.0, 512, ())


@pytest.mark.parametrize(
    ("rows", "top", "problem"),
    [
        ('[[script]]\nname = "a"\n', "", "script[1].file"),
        (GOOD + 'restart = "often"\n', "", "script[1].restart"),
        (GOOD.replace("command", "steer"), "", "script[1].may"),
        (GOOD + "system_id = 1\n", "", "system id 1 is that of the boat"),
        (GOOD + '[[script]]\nname = "b"\nfile = "b.py"\nsystem_id = 231\n', "", "system id 231 is that of 'a'"),
        (GOOD + GOOD, "", "'a' is used twice"),
        (GOOD, "operators = [255]\n", "add its system id 231"),
        (GOOD + "memory_mb = 10\n", "", "script[1].memory_mb"),
    ],
)
def test_every_fault_is_told(rows: str, top: str, problem: str) -> None:
    assert any(problem in one for one in problems(rows, top))


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    file = tmp_path / "boat.toml"
    file.write_text(REVOLT + GOOD, encoding="utf-8")
    (found,) = script_problems(file)
    assert found.startswith(f"{file}:") and "script[1].file: no such file" in found
    (tmp_path / "a.py").touch()
    assert script_problems(file) == []

"""Mistakes on the command line that cost no process."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

import companion.__main__
from companion.cli.main import argument_parser, main, parsed


@pytest.mark.parametrize(
    ("arguments", "remedy"),
    [
        (("run", "revolt", "--sitl", "--devices", "."), "leave out --devices"),
        (("run", "revolt", "--devices", ".", "--wind", "3"), "belongs to `companion sitl`"),
        (("capability", "revolt", "--current", "nan"), "--current nan: must be a number"),
        (("run", "revolt", "--plant", "slender"), "--plant needs --sitl"),
        (("run", "revolt", "--sitl", "--plant", "slendr"), "did you mean 'slender'?"),
        (("sitl", "otter", "--plant", "publishd"), "did you mean 'published'?"),
        (("run", "revolt", "--speed", "2"), "needs --sitl or --devices"),
        (("sitl", "revlot"), "no vessel named"),
        (("sitl", "revlot"), "did you mean 'revolt'?"),
        (("scenario", "run", "hodl"), "did you mean 'hold'?"),
        (("run", "revolt", "--sitl", "--fault", "gnss_lots@5"), "did you mean 'gnss_lost'?"),
        (("run", "revolt", "--sitl", "--home", "63,4"), "write LAT,LON,HEADING_DEG"),
        (("sitl", "revolt", "--speed", "0"), "above 0"),
        (("sitl", "revolt", "--speed", "inf"), "--speed inf: a number above 0"),
        (("run", "revolt", "--sitl", "--speed", "inf"), "--speed inf: a number above 0"),
        (("sitl", "revolt", "--dir", "pyproject.toml"), "it is a file, not a folder; choose another folder by --dir"),
        (("sitl", "revolt", "--duration", "nan"), "--duration nan: must be above 0"),
        (("sitl", "revolt", "--duration", "-5"), "--duration -5: must be above 0"),
        (("sitl", "revolt", "--leader", "thesis@8+nan"), "write SCRIPT@MPS+SECONDS"),
        (("evaluate", "hold", "revolt", "a=.", "--heading", "nan"), "--heading nan: in degrees"),
        (("evaluate", "route", "revolt", "a=.", "--plan", "a.plan", "--radius", "-1"), "--radius -1: must be above 0"),
        (("evaluate", "consistency", "revolt", "--jobs", "0"), "--jobs 0: must be at least 1"),
        (("evaluate", "consistency", "revolt", "--gnss", "rkt"), "gnss 'rkt': one of rtk"),
        (("hunt", "hold", "--minutes", "nan"), "--minutes nan: must be above 0"),
        (("run", "revolt", "--sitl", "--console", "99999"), "--console 99999: 0 to 65535"),
        (("run", "revolt", "--sitl", "--control"), "--control needs --console"),
        (("run", "revolt", "--sitl", "--wind", "5 m/s"), "write MPS@DEG, as 2@45, or MPS alone, without a unit"),
        (("run", "revolt", "--sitl", "--link", "udp:127.0.0.1:1"), "udpout: sends to that address, udpin: listens"),
        (("scenario", "run", "hold", "--set", "tme=60"), "did you mean 'time'?"),
        (("sitl", "rescuerunner", "--leader", "kraken"), "one of straight, thesis"),
        (("devices", "--seconds", "0"), "0.5 to 600"),
        (("thruster-test", "revolt", "--yes"), "--yes is for --sitl"),
        (("check", "companion/leader_module/viknes.toml"), "`companion leader"),
        (("leader", "companion/vessels/revolt.toml"), "`companion run"),
    ],
)
def test_a_mistake_is_one_line_that_says_what_to_do(
    arguments: tuple[str, ...],
    remedy: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "home"))
    extra = ("--state", str(tmp_path / "state"), "--log", str(tmp_path / "log")) if arguments[0] == "run" else ()
    assert main([*arguments, *extra]) == 2
    errors = capsys.readouterr().err
    assert remedy in errors and len(errors.strip().splitlines()) == 1, errors


@pytest.mark.parametrize(
    ("right", "wrong", "remedy"),
    [
        (
            "[parameters]",
            "[parameters]\nDP_ECONN = 1.0",
            "parameters.DP_ECONN: 1: does not exist; did you mean 'DP_ECON'?",
        ),
        (
            'gnss = "sbas"',
            'gnss = "sbass"',
            "sitl.gnss: should be 'rtk', 'float', 'sbas', 'standalone' or 'basin'",
        ),
        (
            "links = [",
            'links = "udpout:127.0.0.1:14550"  # [',
            "links: should be a list in square brackets",
        ),
    ],
)
def test_a_mistake_in_a_file_is_one_line_that_says_what_to_do(
    right: str, wrong: str, remedy: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "boat.toml"
    text = Path("companion/vessels/aboat.toml").read_text(encoding="utf-8")
    file.write_text(text.replace(right, wrong, 1), encoding="utf-8")
    assert main(["check", str(file)]) == 2
    errors = capsys.readouterr().err
    assert remedy in errors and len(errors.strip().splitlines()) == 1, errors


def test_a_misspelt_command_is_guessed(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["chekc", "revolt"])
    assert "mean 'check'?" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (
            ("run", "revolt", "--duraton", "3"),
            "companion run: error: unrecognized arguments: --duraton 3; did you mean",
        ),
        (("sweep", "run", "night.toml", "more"), "usage: companion sweep run"),
    ],
)
def test_an_argument_too_many_is_told_with_the_commands_own_usage(
    words: Sequence[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """It was told with that of the program, which names commands alone."""
    with pytest.raises(SystemExit, match="2"):
        main(words)
    assert told in capsys.readouterr().err


def test_bad_weather_is_refused_before_the_state_is_taken(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "revolt", "--sitl", "--wind", "strong", "--state", str(tmp_path / "state")]) == 2
    assert "write MPS@DEG" in capsys.readouterr().err
    assert not (tmp_path / "state").exists()


def test_a_log_that_cannot_be_written_is_said_before_the_state_is_taken(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "log").touch()
    assert main(["run", "revolt", "--sitl", "--log", str(tmp_path / "log"), "--state", str(tmp_path / "state")]) == 2
    assert capsys.readouterr().err.startswith(f"companion: no log can be written in {tmp_path / 'log'}: ")
    assert not (tmp_path / "state").exists()


def test_devices_on_a_port_that_is_not_there_fails(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["devices", "--port", "/dev/no-such-port", "--seconds", "0.5"]) == 1
    assert "no such device" in capsys.readouterr().out


def test_a_usual_boat_starts_without_what_it_does_not_use() -> None:
    heavy = {
        "scipy",
        "shapely",
        "rich",
        "aiohttp",
        "pandas",
        "pymavlink.dialects.v20.ardupilotmega",
        "companion.cli.sweep",
    }
    script = (
        "import sys\n"
        "from companion.cli.main import parsed\n"
        "parsed(['run', 'revolt', '--sitl'])\n"
        "import sitl.emulators, sitl.world\n"
        f"print(sorted({heavy!r} & set(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_help_and_mistakes_know_all_commands(capsys: pytest.CaptureFixture[str]) -> None:
    for command in ("", "thrustertest"):
        with pytest.raises(SystemExit):
            argument_parser(command).parse_args([command or "--help"])
        written = "".join(capsys.readouterr())
        assert "thruster-test" in written
        assert "scenario" in written


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["check"], "Every error of a vessel's file at once"),
        (["trial", "undo"], "The overlay in force no longer counts"),
        (["sitl"], "While it runs, type a fault's name"),
    ],
)
def test_the_help_of_a_command_says_what_it_does(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It listed the options alone."""
    monkeypatch.setenv("COLUMNS", "200")
    with pytest.raises(SystemExit):
        parsed([*words, "--help"])
    assert said in capsys.readouterr().out


def test_ctrl_c_ends_any_command_with_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`companion identify` and others left a traceback."""

    def interrupted() -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(companion.__main__, "_carried_out", interrupted)
    assert companion.__main__.main() == 130
    assert capsys.readouterr().err == "companion: ended by Ctrl-C\n"


@pytest.mark.process
def test_a_reader_that_has_enough_is_no_mistake() -> None:
    """`companion check revolt | head -1` said that the system has a broken pipe."""
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "companion", "check", "revolt"]
    with os.fdopen(writing, "w") as nobody:
        done = subprocess.run(command, stdout=nobody, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (141, "")


def test_libraries_compute_with_one_thread_where_a_tick_waits_for_them() -> None:
    """The fit of a compass took 7 s of a tick beside other programs; with one thread 0.2 s."""
    threads = {word: _threads_of_a_product(word) for word in ("run", "leader")}
    assert threads == {"run": 1, "leader": 1}


def _threads_of_a_product(command: str) -> int:
    program = (
        "import os, sys; from companion.__main__ import spare_threads; assert 'numpy' not in sys.modules; "
        f"spare_threads(['{command}', 'revolt']); import numpy as np; a = np.ones((500, 500)); a @ a; "
        "print(len(os.listdir('/proc/self/task')))"
    )
    several = {k: v for k, v in os.environ.items() if not k.endswith("_NUM_THREADS")}
    return int(subprocess.check_output([sys.executable, "-c", program], env=several))

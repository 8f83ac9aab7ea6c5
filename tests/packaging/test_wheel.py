"""The wheel as a stranger gets it: what it holds, and that it sails away from the source."""

from __future__ import annotations

import csv
import json
import re
import socket
import tarfile
import zipfile
from pathlib import Path, PurePosixPath

import pytest

from tests.packaging.installed import ROOT, Environment, build
from tests.protocol.process import free_port

ROOMS = ("companion", "sitl", "gcs_plugins", "mission_files")
HOME = "63.4389,10.3990,0"


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build(tmp_path_factory.mktemp("wheel"), "wheel")


@pytest.fixture(scope="module")
def environment(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Environment:
    return Environment(tmp_path_factory.mktemp("environment"), wheel)


def held(wheel: Path) -> set[str]:
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


def test_the_wheel_holds_every_file_of_its_rooms_and_no_other(wheel: Path) -> None:
    source = {str(path.relative_to(ROOT)) for room in ROOMS for path in (ROOT / room).rglob("*") if path.is_file()}
    source = {name for name in source if "__pycache__" not in name and not name.endswith(".pyc")}
    assert {name for name in held(wheel) if ".dist-info/" not in name} == source


@pytest.mark.parametrize(
    "pattern",
    [
        "companion/**/revolt.toml",
        "companion/**/viknes.toml",
        "companion/**/usv_board.ino",
        "companion/**/usv_frame.c",
        "companion/py.typed",
        "sitl/py.typed",
        "gcs_plugins/py.typed",
        "gcs_plugins/**/cockpit_extras.json",
        "mission_files/trondheim_square.plan",
        "*.dist-info/licenses/LICENSE",
    ],
)
def test_what_is_not_python_is_in_the_wheel(wheel: Path, pattern: str) -> None:
    whole = re.compile(re.escape(pattern).replace(r"\*\*/", "(?:.+/)?").replace(r"\*", "[^/]*"))
    assert [name for name in held(wheel) if whole.fullmatch(name)]


def test_the_source_archive_can_test_itself(tmp_path: Path) -> None:
    with tarfile.open(build(tmp_path, "sdist")) as archive:
        names = {str(PurePosixPath(*PurePosixPath(name).parts[1:])) for name in archive.getnames()}
    needed = {
        "Makefile",
        ".ci/make_venv.py",
        ".ci/constraints.txt",
        "uv.lock",
        "pyproject.toml",
        "tests/conftest.py",
        "mission_files/laps.plan",
    }
    assert needed <= names


def test_everything_is_imported_from_the_wheel(environment: Environment) -> None:
    program = "import sys, companion.params, sitl, gcs_plugins"
    program += "; print(*(sys.modules[name].__file__ for name in sys.argv[1:]), sep='\\n')"
    found = environment.run("python", "-c", program, "companion", "companion.params", "sitl", "gcs_plugins")
    assert found.returncode == 0, found.stderr
    assert [Path(line).is_relative_to(environment.packages) for line in found.stdout.splitlines()] == [True] * 4
    assert str(ROOT) not in environment.run("python", "-c", "import sys; print(sys.path)").stdout


def test_extras_are_not_in_the_environment(environment: Environment) -> None:
    assert environment.run("python", "-c", "import matplotlib").returncode != 0
    assert environment.run("python", "-c", "import pytest").returncode != 0


def test_the_version_is_that_of_the_wheel(environment: Environment, wheel: Path) -> None:
    assert environment.run("companion", "--version").stdout.split()[2].rstrip(",") == wheel.name.split("-")[1]


@pytest.mark.process
def test_a_scenario_sails(environment: Environment, tmp_path: Path) -> None:
    words = ("scenario", "run", "hold", "--set", "time=20", "--out", str(tmp_path / "out"))
    sailed = environment.run("companion", *words)
    assert sailed.returncode == 0, sailed.stdout + sailed.stderr
    result = json.loads((tmp_path / "out" / "result.json").read_text(encoding="utf-8"))
    assert result["checks"] and all(check["ok"] for check in result["checks"])


@pytest.mark.process
def test_a_simulated_boat_runs_and_leaves_its_log(environment: Environment, tmp_path: Path) -> None:
    links = [f"udpout:127.0.0.1:{free_port()}", f"tcpin:127.0.0.1:{free_port(socket.SOCK_STREAM)}"]
    arguments = ["run", "revolt", "--sitl", "--duration", "5", "--speed", "5", "--home", HOME]
    arguments += [
        "--state",
        str(tmp_path / "state"),
        "--log",
        str(tmp_path / "logs"),
        "--link",
        links[0],
        "--link",
        links[1],
    ]
    run = environment.run("companion", *arguments)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "ReVolt" in run.stdout and all(link in run.stdout for link in links)
    (folder,) = (tmp_path / "logs").iterdir()
    assert str(folder) in run.stdout
    assert {"ticks.csv", "truth.csv", "events.csv", "telemetry.tlog", "manifest.json"} <= {
        path.name for path in folder.iterdir()
    }
    assert json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    with (folder / "ticks.csv").open(encoding="utf-8", newline="") as file:
        ticks = list(csv.DictReader(file))
    assert float(ticks[-1]["t_s"]) - float(ticks[0]["t_s"]) > 4.0
    assert (tmp_path / "state").is_dir()


def test_a_mission_of_the_wheel_is_named_without_its_folder(environment: Environment) -> None:
    summary = environment.run("companion", "mission", "trondheim_square.plan")
    assert summary.returncode == 0, summary.stderr
    assert "fence" in summary.stdout

"""The reference firmware, compiled for this machine."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.unit.io.actuators.firmware.host import build, load


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("firmware")


@pytest.fixture(scope="session")
def host_codec(folder: Path) -> Path:
    return build("host_codec", folder)


@pytest.fixture(scope="session")
def host_board(folder: Path) -> Path:
    return build("host_board", folder)


@pytest.fixture(scope="session", autouse=True)
def library(folder: Path) -> None:
    load(build("host_library", folder))

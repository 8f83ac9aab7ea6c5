"""How ArduRover is set up on each boat: `rover_setup.toml`, tuned for this plant on seeds from 100 on."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

FILE = Path(__file__).with_name("rover_setup.toml")


@dataclass(frozen=True, slots=True)
class RoverSetup:
    """Which servo channel drives what, as `companion sitl --outputs` takes it, and ArduRover's parameters."""

    outputs: str
    parameters: Mapping[str, float]


def setups(file: Path = FILE) -> Mapping[str, RoverSetup]:
    """By the vessel's name. The parameters of `[common]` hold for all; a boat's own come before them."""
    data = tomllib.loads(file.read_text(encoding="utf-8"))
    common = data["common"]
    return {name: RoverSetup(boat["outputs"], {**common, **boat["parameters"]}) for name, boat in data["boats"].items()}

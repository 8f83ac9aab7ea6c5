"""What every manoeuvre of a trial is: a small program from a start in the circle to its end."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum

from companion.config.vessel import VesselConfig
from companion.core.actuation import Wrench
from companion.core.decision import ModeInputs
from companion.core.estimate import NavState
from companion.core.setpoint import HeadingSetpoint, Setpoint, WrenchSetpoint
from companion.modes.trial.expectation import Expectation


class Begin(Enum):
    """Where a manoeuvre begins."""

    HERE = "where the boat is"
    FACING = "bow to the centre"
    CENTRE = "at the centre"


@dataclass(frozen=True, slots=True)
class Scene:
    """What a manoeuvre sees in a tick. `t_s`: since it began. `out_share`: distance from the centre of the circle, as a
    share of its radius."""

    inputs: ModeInputs
    t_s: float
    config: VesselConfig
    expectation: Expectation
    out_share: float = 0.0

    @property
    def nav(self) -> NavState:
        """The estimate."""
        return self.inputs.nav


class Manoeuvre(ABC):
    """`start`, then `update` every tick → setpoint; None: it is done. The circle may end it before.

    `name`: for people and the analysis. `brakes`: the boat comes to rest before the next one. `vital`: a trial without
    it says little, so it is not left out for want of time.
    """

    name: str
    begins: Begin = Begin.FACING
    brakes: bool = True
    vital: bool = False

    @abstractmethod
    def expected_s(self, expectation: Expectation) -> float:
        """How long it takes, with the way to its start."""

    def start(self, scene: Scene) -> None:  # noqa: B027  some remember nothing
        """Begin."""

    @abstractmethod
    def update(self, scene: Scene) -> Setpoint | None:
        """The setpoint of this tick; None at the end."""


def straight(yaw_rad: float, surge_n: float, sway_n: float = 0.0) -> Setpoint:
    """Forces with the heading held."""
    return HeadingSetpoint(yaw_rad, Wrench(surge_n, sway_n, 0.0))


def pushed(surge_n: float, sway_n: float, yaw_nm: float) -> Setpoint:
    """Forces and moment, past the control laws."""
    return WrenchSetpoint(Wrench(surge_n, sway_n, yaw_nm))

"""What `water = "rough"` makes of a simulated boat and its weather."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal

from pydantic import Field

from companion.config.fields import STRICT, Positive, means
from companion.config.losses import LossConfig
from companion.config.sensor_errors import SensorErrorConfig

WaterKind = Literal["usual", "rough"]
USUAL: WaterKind = "usual"
ROUGH: WaterKind = "rough"


@dataclass(frozen=True, slots=True)
class RoughWaterConfig:
    """The choices of `water = "rough"`: which hull, what it loses, and how wind and waves go together."""

    __pydantic_config__ = STRICT
    plant: Annotated[str, means("The plant that is used: a name in `[sitl.plants]`. Left out: as in usual water.")] = ""
    losses: Annotated[
        LossConfig | None,
        means("Losses of a plant without any. Left out: all of them, of propellers by their thrust."),
    ] = None
    sensor_errors: Annotated[SensorErrorConfig, means("Errors of the sensors of a plant without any.")] = field(
        default_factory=SensorErrorConfig
    )
    windage_error: Annotated[
        float, Field(ge=0.0, lt=1.0), means("Share by which the wind areas differ, each up or down by the seed.")
    ] = 0.2
    gusts: Annotated[
        Literal["davenport", "kaimal", "npd"], means("Spectrum of the gusts, where the wind does not name one.")
    ] = "davenport"
    current_share: Annotated[
        float,
        Field(ge=0.0, le=1.0),
        means("Slow variation of the current on each axis: one sigma over the mean. 0.2 turns it by 11°."),
    ] = 0.2
    fetch_m: Annotated[Positive, means("Open water to windward in which the wind raises the waves.")] = 1000.0

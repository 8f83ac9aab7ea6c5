"""Streams beside the devices, as a vessel's file describes them: corrections for satellite receivers, NMEA sentences for others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from companion.config.devices import ActuatorConfig, SensorConfig
from companion.config.fields import STRICT, Positive

Sentence = Literal["GGA", "RMC", "VTG", "HDT", "ZDA", "XTE", "APB", "RSA"]


@dataclass(frozen=True, slots=True)
class CorrectionsConfig:
    """A source of RTCM 3: a radio on a serial port, a TCP stream, or with `mountpoint` an NTRIP caster at the TCP address of `port`.

    `to` names the receiver that is given them; None: every sensor with `rtcm = true`. `gga_s`: how often the caster is told the position
    (virtual reference stations need it); 0: never.
    """

    __pydantic_config__ = STRICT
    port: str
    to: str | None = None
    timeout_s: Positive = 10.0
    mountpoint: Annotated[str, Field(pattern=r"^[!-~]{1,100}$")] | None = None
    user: Annotated[str, Field(pattern=r"^[!-9;-~]{1,100}$")] | None = None
    password: Annotated[str, Field(max_length=100)] = ""
    gga_s: Annotated[float, Field(ge=0.0)] = 10.0


@dataclass(frozen=True, slots=True)
class NmeaOutConfig:
    """Where NMEA 0183 sentences go, how often, and which."""

    __pydantic_config__ = STRICT
    port: str
    rate_hz: Annotated[float, Field(gt=0.0, le=50.0)] = 1.0
    sentences: tuple[Sentence, ...] = ("GGA", "RMC", "VTG", "HDT", "XTE", "APB", "RSA")
    talker: Annotated[str, Field(pattern=r"^[A-Z]{2}$")] = "GP"


def stream_problems(
    sensors: Sequence[SensorConfig], bridges: Sequence[ActuatorConfig], corrections: Sequence[CorrectionsConfig]
) -> list[tuple[tuple[str | int, ...], str]]:
    """Places and texts of what no single field can know."""
    problems: list[tuple[tuple[str | int, ...], str]] = []
    taken = {sensor.port: (sensor.name, sensor.driver) for sensor in sensors}
    for i, bridge in enumerate(bridges):
        name, driver = taken.setdefault(bridge.port, (bridge.name, bridge.driver))
        both_mavlink = driver.startswith("mavlink") and bridge.driver.startswith("mavlink")  # one autopilot is sensor and bridge
        if name != bridge.name and not both_mavlink and not bridge.port.startswith("memory:"):
            problems.append((("actuator", i, "port"), f"'{name}' has it too: only sensors, and what speaks MAVLink, can share a port"))
    names = [sensor.name for sensor in sensors]
    for i, row in enumerate(corrections):
        if row.to is not None and row.to not in names:
            problems.append((("corrections", i, "to"), f"no sensor named '{row.to}'; there is {', '.join(names)}"))
        elif row.to is None and not any(sensor.rtcm for sensor in sensors):
            problems.append((("corrections", i), "no receiver for them: give a sensor rtcm = true, or name one with to = \"…\""))
        if row.user is not None and row.mountpoint is None:
            problems.append((("corrections", i, "user"), "a user is for an NTRIP caster: give its mountpoint too"))
        if row.mountpoint is not None and not row.port.startswith("tcpout:"):
            problems.append((("corrections", i, "port"), "an NTRIP caster is reached by tcpout:ADDRESS:PORT"))
    return problems

"""Streams beside the devices, as a vessel's file describes them: corrections for satellite receivers, NMEA sentences
for others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from companion.config.devices import ActuatorConfig, SensorConfig
from companion.config.fields import STRICT, Positive, means

Sentence = Literal["GGA", "RMC", "VTG", "HDT", "ZDA", "XTE", "APB", "RSA"]


@dataclass(frozen=True, slots=True)
class CorrectionsConfig:
    """A source of RTCM 3: a radio on a serial port, a TCP stream, or an NTRIP caster. The first source in the file that
    is alive is used."""

    __pydantic_config__ = STRICT
    port: Annotated[
        str,
        means(
            "Where the corrections come from: a radio's `serial:`, a stream's `tcpout:`, or the address of "
            "an NTRIP caster."
        ),
    ]
    to: Annotated[str | None, means("Sensor that is given them. Left out: every sensor with `rtcm = true`.")] = None
    timeout_s: Annotated[Positive, means("Silence after which the next source in the file is used.")] = 10.0
    mountpoint: Annotated[
        Annotated[str, Field(pattern=r"^[!-~]{1,100}$")] | None,
        means("Mountpoint of an NTRIP caster. Left out: `port` is a plain stream."),
    ] = None
    user: Annotated[Annotated[str, Field(pattern=r"^[!-9;-~]{1,100}$")] | None, means("User at the caster.")] = None
    password: Annotated[str, Field(max_length=100), means("Password at the caster. No log holds it.")] = ""
    gga_s: Annotated[
        float,
        Field(ge=0.0),
        means("Period at which the position is sent to the caster, which virtual reference stations need. 0: never."),
    ] = 10.0


@dataclass(frozen=True, slots=True)
class NmeaOutConfig:
    """NMEA 0183 sentences for chart plotters and survey software."""

    __pydantic_config__ = STRICT
    port: Annotated[str, means("Where the sentences go, such as `udpout:192.168.1.30:10110`.")]
    rate_hz: Annotated[float, Field(gt=0.0, le=50.0), means("How often each sentence is sent.")] = 1.0
    sentences: Annotated[
        tuple[Sentence, ...],
        means("Which sentences are sent."),
    ] = ("GGA", "RMC", "VTG", "HDT", "XTE", "APB", "RSA")
    talker: Annotated[str, Field(pattern=r"^[A-Z]{2}$"), means("Talker of the sentences.")] = "GP"


_SPOKEN = {"nmea0183": "NMEA 0183", "ais": "NMEA 0183", "mavlink_imu": "MAVLink", "mavlink_range": "MAVLink"}
"""What a port of these drivers speaks. Of the other built-in ones each has its own. Others are unknown."""
_OWN = ("mtdata2", "vectornav", "sbus", "crsf")


def _shared_by_strangers(sensors: Sequence[SensorConfig]) -> list[tuple[tuple[str | int, ...], str]]:
    """Sensors on one serial port that speak differently."""
    problems: list[tuple[tuple[str | int, ...], str]] = []
    known = [(i, s, _SPOKEN.get(s.driver, s.driver)) for i, s in enumerate(sensors) if s.driver in (*_SPOKEN, *_OWN)]
    for at, (i, sensor, spoken) in enumerate(known):
        for _, other, others in known[:at]:
            if sensor.port.startswith("serial:") and sensor.port == other.port and spoken != others:
                text = f"'{other.name}' has it too, and speaks {others}, not {spoken}: give each its own port"
                problems.append((("sensor", i, "port"), text))
                break
    return problems


def stream_problems(
    sensors: Sequence[SensorConfig], bridges: Sequence[ActuatorConfig], corrections: Sequence[CorrectionsConfig]
) -> list[tuple[tuple[str | int, ...], str]]:
    """Ports that two devices cannot share, and sources of corrections without a receiver, with their places."""
    problems = _shared_by_strangers(sensors)
    taken = {sensor.port: (sensor.name, sensor.driver) for sensor in sensors}
    for i, bridge in enumerate(bridges):
        name, driver = taken.setdefault(bridge.port, (bridge.name, bridge.driver))
        both_mavlink = driver.startswith("mavlink") and bridge.driver.startswith(
            "mavlink"
        )  # one autopilot is sensor and bridge
        if name != bridge.name and not both_mavlink and not bridge.port.startswith("memory:"):
            problems.append(
                (
                    ("actuator", i, "port"),
                    f"'{name}' has it too: only sensors, and what speaks MAVLink, can share a port",
                )
            )
    names = [sensor.name for sensor in sensors]
    for i, row in enumerate(corrections):
        if row.to is not None and row.to not in names:
            problems.append((("corrections", i, "to"), f"no sensor named '{row.to}'; there is {', '.join(names)}"))
        elif row.to is None and not any(sensor.rtcm for sensor in sensors):
            problems.append(
                (("corrections", i), 'no receiver for them: give a sensor rtcm = true, or name one with to = "…"')
            )
        if row.user is not None and row.mountpoint is None:
            problems.append((("corrections", i, "user"), "a user is for an NTRIP caster: give its mountpoint too"))
        if row.mountpoint is not None and not row.port.startswith("tcpout:"):
            problems.append((("corrections", i, "port"), "an NTRIP caster is reached by tcpout:ADDRESS:PORT"))
    return problems

"""Scripts of a boat's owner, as a vessel's file describes them: what runs, what it may ask for, and its limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from companion.config.fields import STRICT, Name, NonNegative, Positive, means

Problem = tuple[tuple[str | int, ...], str]
Grant = Literal["command", "setpoint", "upload", "parameter"]
FIRST_SYSTEM = 231
"""MAVLink system id of the first script in the file; the next have the next ones."""


@dataclass(frozen=True, slots=True)
class ScriptConfig:
    """A Python program of the boat's owner, which runs in a process of its own while the companion runs."""

    __pydantic_config__ = STRICT
    name: Annotated[Name, means("Name of the script. Events and its log are named after it.")]
    file: Annotated[str, Field(min_length=1), means("The Python file; a relative path counts from the vessel's file.")]
    arguments: Annotated[tuple[str, ...], means("Words that the script is given.")] = ()
    may: Annotated[
        tuple[Grant, ...],
        means(
            "What it may ask of the boat: `command` (modes, arming, go-to, mission control), `setpoint` (Offboard), "
            "`upload` (plans), `parameter`. Empty: it reads only."
        ),
    ] = ()
    restart: Annotated[
        Literal["never", "failure", "always"],
        means("When it is started again after it has ended: `never`, after a `failure`, or `always`."),
    ] = "failure"
    watchdog_s: Annotated[
        NonNegative,
        means("It is killed when it has asked nothing of its interface for so long. 0: never."),
    ] = 10.0
    memory_mb: Annotated[
        int, Field(ge=64, le=65536), means("Address space of each of its processes, in 10⁶ bytes.")
    ] = 512
    disk_mb: Annotated[int, Field(ge=1, le=65536), means("Largest file that it can write, in 10⁶ bytes.")] = 64
    restart_s: Annotated[Positive, means("Pause before it is started again; doubled after each failure in a row.")] = (
        2.0
    )
    system_id: Annotated[
        Annotated[int, Field(ge=1, le=250)] | None,
        means("Its MAVLink system id. Left out: 231 for the first script in the file, 232 for the second, and so on."),
    ] = None


def script_system(scripts: Sequence[ScriptConfig], i: int) -> int:
    """The MAVLink system id of script `i`."""
    return scripts[i].system_id or FIRST_SYSTEM + i


def script_problems(
    scripts: Sequence[ScriptConfig], operators: Sequence[int], parameters: Mapping[str, float]
) -> list[Problem]:
    """What is wrong with `[[script]]`, with its place."""
    problems: list[Problem] = []
    taken = {int(parameters.get("MAV_SYS_ID", 1)): "the boat"}
    for i, script in enumerate(scripts):
        system = script_system(scripts, i)
        place = ("script", i) if script.system_id is None else ("script", i, "system_id")
        if system in taken:
            problems.append((place, f"system id {system} is that of {taken[system]}"))
        taken[system] = f"'{script.name}'"
        if script.may and operators and system not in operators:
            problems.append(
                (("script", i, "may"), f"add its system id {system} to `operators`, which lists others only")
            )
    return problems

"""Drivers of other packages. Such a package names them in its entry points, in its pyproject.toml:

    [project.entry-points."usv_companion.actuators"]
    my_bridge = "my_package.bridge:DRIVER"

    [project.entry-points."usv_companion.sensors"]
    my_sonar = "my_package.sonar:DRIVER"

The name on the left is the `driver` in a vessel's file. The object on the right is a
`companion.io.actuators.ActuatorDriver` or a `companion.io.sensors.SensorDriver`. A package is imported only when a
file names its driver.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from importlib.metadata import EntryPoint, entry_points
from typing import TypeVar

from companion.config.vessel import ConfigError

D = TypeVar("D")
T = TypeVar("T")


def refusal(driver: str, built_in: Collection[str], group: str) -> str | None:
    """Why a file cannot name that driver, with those that it can; None for a driver that is there. Imports nothing."""
    if driver in built_in:
        return None
    others = entry_points(group=group).names
    return None if driver in others else f"no driver '{driver}'; known: {', '.join(sorted({*built_in, *others}))}"


def loaded(driver: str, group: str, kind: type[D]) -> D:
    """The plug-in for that driver. Raises ConfigError that names its package where it cannot be loaded, is no `kind`,
    or is in two packages."""
    found = tuple(entry_points(group=group, name=driver))
    packages = " and ".join(sorted({_package(entry) for entry in found}))
    if len(found) != 1:
        raise ConfigError([f"driver '{driver}' is in {len(found)} packages, {packages}: remove all but one"])
    plugin = guarded(driver, found[0].load, group)
    if not isinstance(plugin, kind):
        text = f"'{found[0].value}' is no {kind.__name__}: update or remove the package"
        raise ConfigError([f"driver '{driver}' of {packages}: {text}"])
    return plugin


def guarded(driver: str, call: Callable[[], T], group: str) -> T:
    """What a plug-in's function returns. Raises ConfigError that names its package for all that it raises."""
    try:
        return call()
    except ConfigError:
        raise
    except Exception as error:
        packages = " and ".join(_package(entry) for entry in entry_points(group=group, name=driver))
        text = f"{type(error).__name__}: {error}; update or remove the package"
        raise ConfigError([f"driver '{driver}' of {packages} fails: {text}"]) from error


def _package(entry: EntryPoint) -> str:
    return "a package without a name" if entry.dist is None else f"{entry.dist.name} {entry.dist.version}"

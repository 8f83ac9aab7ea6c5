"""platforms.md: for which platforms and Pythons each package of a boat has a wheel, from uv.lock."""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from packaging.markers import Marker
from packaging.tags import Tag, compatible_tags, cpython_tags
from packaging.utils import parse_wheel_filename

from docs.generate.markdown import code, page, section, table
from docs.generate.source import ROOT

LOCK = ROOT / "uv.lock"
PROJECT = "usv-companion"
PYTHONS = ((3, 11), (3, 12), (3, 13), (3, 14))
EXTRAS = ("can", "console", "export", "report", "sweep", "usvctl")
_OLDEST_GLIBC = 17

_INTRODUCTION = """Where every package has a wheel, `pip` needs no compiler. These tables are made from `uv.lock`, which
names every wheel on pypi.org of the versions that are tested together. A package that is named has none there, and has
to be compiled on the spot, with its compilers and libraries."""
_END = "Containers for both 64-bit machines, and BlueOS: [Installation](../start/installation.md#container)."


@dataclass(frozen=True, slots=True)
class Platform:
    """A kind of computer. `glibc`: the minor version of glibc 2; `musl`: that of musl 1, instead."""

    name: str
    machine: str
    glibc: int | None = None
    musl: int | None = None

    @property
    def tags(self) -> list[str]:
        """Names of platforms whose wheels run here, best first."""
        if self.musl is not None:
            return [f"musllinux_1_{minor}_{self.machine}" for minor in range(self.musl, 0, -1)]
        assert self.glibc is not None
        newer = [f"manylinux_2_{minor}_{self.machine}" for minor in range(self.glibc, _OLDEST_GLIBC - 1, -1)]
        older = ["manylinux_2_12_x86_64", "manylinux2010_x86_64", "manylinux_2_5_x86_64", "manylinux1_x86_64"]
        return [*newer, f"manylinux2014_{self.machine}", *(older if self.machine == "x86_64" else ())]


PLATFORMS = (
    Platform("64-bit PC: Debian 12, Ubuntu 22.04 and newer", "x86_64", glibc=35),
    Platform("64-bit ARM: Raspberry Pi OS, Debian 12, Jetson with Ubuntu 22.04, and newer", "aarch64", glibc=35),
    Platform("64-bit PC: Alpine 3.19 and newer", "x86_64", musl=2),
    Platform("64-bit ARM: Alpine 3.19 and newer", "aarch64", musl=2),
    Platform("32-bit ARM (armv7): 32-bit Raspberry Pi OS, older BlueOS", "armv7l", glibc=36),
)


def platforms() -> str:
    """The page."""
    core = table(("platform", *(f"Python {major}.{minor}" for major, minor in PYTHONS)), map(_core_row, PLATFORMS))
    extras = table(("platform", *map(code, EXTRAS)), map(_extras_row, PLATFORMS))
    words = "What each extra needs beyond the boat, with any of these Pythons."
    return page("Platforms", _INTRODUCTION, section(2, "The boat", core), section(2, "Extras", words, extras), _END)


def _core_row(platform: Platform) -> tuple[str, ...]:
    return _named(platform), *(_cell(missing(platform, python)) for python in PYTHONS)


def _extras_row(platform: Platform) -> tuple[str, ...]:
    cells = []
    for extra in EXTRAS:
        lacking = {
            name
            for python in PYTHONS
            for name in set(missing(platform, python, (extra,))) - set(missing(platform, python))
        }
        cells.append(_cell(sorted(lacking)))
    return _named(platform), *cells


def _named(platform: Platform) -> str:
    return f"{platform.name} ({code(platform.machine)})"


def _cell(lacking: Sequence[str]) -> str:
    return f"not {', '.join(lacking)}" if lacking else "all wheels"


@functools.cache
def missing(platform: Platform, python: tuple[int, int], extras: tuple[str, ...] = ()) -> list[str]:
    """Names of the packages that have no wheel there, of those that the boat and the extras need."""
    supported = frozenset(_tags(platform, python))
    needed = _needed(extras, _environment(platform, python))
    return sorted(name for name, wheels in needed.items() if not any(_fits(wheel, supported) for wheel in wheels))


def _tags(platform: Platform, python: tuple[int, int]) -> Iterator[Tag]:
    yield from cpython_tags(python, platforms=platform.tags)
    yield from compatible_tags(python, f"cp{python[0]}{python[1]}", platforms=platform.tags)


def _fits(wheel: str, supported: frozenset[Tag]) -> bool:
    return not supported.isdisjoint(_wheel_tags(wheel))


@functools.cache
def _wheel_tags(wheel: str) -> frozenset[Tag]:
    return parse_wheel_filename(wheel)[3]


def _environment(platform: Platform, python: tuple[int, int]) -> dict[str, str]:
    """What markers of dependencies ask about."""
    return {
        "implementation_name": "cpython",
        "implementation_version": f"{python[0]}.{python[1]}.6",
        "os_name": "posix",
        "platform_machine": platform.machine,
        "platform_python_implementation": "CPython",
        "platform_release": "",
        "platform_system": "Linux",
        "platform_version": "",
        "python_full_version": f"{python[0]}.{python[1]}.6",
        "python_version": f"{python[0]}.{python[1]}",
        "sys_platform": "linux",
        "extra": "",
    }


@functools.cache
def _packages() -> Mapping[str, Sequence[Mapping[str, Any]]]:
    """The packages of the lock by name: several of a name where the version depends on the platform."""
    found: dict[str, list[Mapping[str, Any]]] = {}
    for package in tomllib.loads(LOCK.read_text(encoding="utf-8"))["package"]:
        found.setdefault(package["name"], []).append(package)
    return found


def _needed(extras: Sequence[str], environment: dict[str, str]) -> dict[str, list[str]]:
    """Names of wheels by package, of all that the project needs there."""
    (project,) = _packages()[PROJECT]
    waiting = list(project["dependencies"])
    for extra in extras:
        waiting += project["optional-dependencies"][extra]
    found: dict[str, list[str]] = {}
    while waiting:
        needed = waiting.pop()
        if needed["name"] in found or not _applies(needed, environment):
            continue
        package = _chosen(needed, environment)
        found[needed["name"]] = [wheel["url"].rpartition("/")[2] for wheel in package.get("wheels", ())]
        waiting += package.get("dependencies", ())
        for extra in needed.get("extra", ()):
            waiting += package.get("optional-dependencies", {}).get(extra, ())
    return found


def _applies(needed: Mapping[str, Any], environment: dict[str, str]) -> bool:
    return "marker" not in needed or Marker(needed["marker"]).evaluate(environment)


def _chosen(needed: Mapping[str, Any], environment: dict[str, str]) -> Mapping[str, Any]:
    """The version of a package that counts there."""
    versions = [
        package
        for package in _packages()[needed["name"]]
        if package.get("version") == needed.get("version", package.get("version"))
    ]
    for package in versions:
        markers = package.get("resolution-markers", ())
        if not markers or any(Marker(marker).evaluate(environment) for marker in markers):
            return package
    return versions[0]

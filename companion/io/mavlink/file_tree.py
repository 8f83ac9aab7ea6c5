"""The files that a vessel shows over MAVLink FTP, all read-only: metadata, parameters, plans, logs.

    general.json  parameters.json.xz
    @PARAM/    param.pck  usv.params
    plans/     mission.dat  fence.dat  rally.dat  current.plan
    logs/      one folder a run, as on the disk

ArduPilot's names for the same (@MISSION/mission.dat, @FENCE/fence.dat, @RALLY/rally.dat, @MAV_LOG) are understood and not listed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from typing import Any, Protocol

from companion.io.mavlink.component_metadata import GENERAL, PARAMETERS, Metadata, crc32
from companion.io.mavlink.dialects import Dialect
from companion.io.mavlink.disk_files import Entry, Shelf
from companion.io.mavlink.parameter_file import packed, text
from companion.io.mavlink.plan_data import plan_data
from companion.io.mavlink.vessel import VesselFace
from companion.mission import qgc_plan
from companion.mission.plan import PlanKind
from companion.mission.plan_file import PlanFile

_LOGS = "logs"
_ALIASES = {"@MAV_LOG": _LOGS, "@MISSION": "plans", "@FENCE": "plans", "@RALLY": "plans"}


class OpenFile(Protocol):
    """A file that is being read. `read` gives None while the bytes are being fetched."""

    size: int

    def read(self, offset: int, count: int) -> bytes | None: ...

    def crc32(self) -> Future[int]: ...

    def close(self) -> None: ...


class MemoryFile:
    """Bytes made when the file was opened: they stay as they were, whatever happens meanwhile."""

    def __init__(self, data: bytes) -> None:
        self.size = len(data)
        self._data = data

    def read(self, offset: int, count: int) -> bytes:
        return self._data[offset : offset + max(0, count)]

    def crc32(self) -> Future[int]:
        return _known(crc32(self._data))

    def close(self) -> None:
        """Nothing is held."""


class FileTree:
    """`entries` and `open` by a path as a client writes it; each gives a future, None in it for what is not there."""

    def __init__(self, vessel: VesselFace, system: int, component: int, metadata: Metadata, shelf: Shelf | None) -> None:
        """`shelf`: the log folders; None where nothing is logged."""
        self._vessel = vessel
        self._address = (system, component)
        self._shelf = shelf
        self._folders: Mapping[str, Mapping[str, Callable[[Dialect], bytes]]] = {
            "": {GENERAL: lambda _: metadata.general, PARAMETERS: lambda _: metadata.parameters},
            "@PARAM": {
                "param.pck": lambda _: packed(vessel.parameters),
                "usv.params": lambda _: text(vessel.parameters, *self._address).encode(),
            },
            "plans": {
                "mission.dat": lambda dialect: self._plan(PlanKind.MISSION, dialect),
                "fence.dat": lambda dialect: self._plan(PlanKind.FENCE, dialect),
                "rally.dat": lambda dialect: self._plan(PlanKind.RALLY, dialect),
                "current.plan": lambda _: self._plan_file(),
            },
        }

    def entries(self, path: str, dialect: Dialect) -> Future[Sequence[Entry] | None]:
        names, _ = split(path)
        if names is None:
            return _known(None)
        if names and names[0] == _LOGS and self._shelf is not None:
            return self._shelf.entries(names[1:])  # type: ignore[return-value]  # a list is a sequence
        folder = self._folders.get("/".join(names))
        if folder is None:
            return _known(None)
        entries = [Entry(name, len(make(dialect))) for name, make in folder.items()]
        if not names:
            entries += [Entry(name) for name in self._folders if name] + ([] if self._shelf is None else [Entry(_LOGS)])
        return _known(entries)

    def open(self, path: str, dialect: Dialect) -> Future[OpenFile | None]:
        names, query = split(path)
        if not names:
            return _known(None)
        if names[0] == _LOGS and self._shelf is not None:
            return self._shelf.open(names[1:])  # type: ignore[return-value]  # a disk file is an open file
        if names == ["@PARAM", "param.pck"] and query == "withdefaults=1":
            return _known(MemoryFile(packed(self._vessel.parameters, with_defaults=True)))
        make = self._folders.get("/".join(names[:-1]), {}).get(names[-1])
        return _known(None if make is None else MemoryFile(make(dialect)))

    def _plan(self, kind: PlanKind, dialect: Dialect) -> bytes:
        home = None if self._vessel.last_tick is None else self._vessel.last_tick.status.home
        return plan_data(kind, self._vessel.plans.items(kind), home, dialect, *self._address)

    def _plan_file(self) -> bytes:
        plans = self._vessel.plans
        plan = PlanFile(plans.items(PlanKind.MISSION), plans.items(PlanKind.FENCE), plans.items(PlanKind.RALLY))
        return qgc_plan.write("current.plan", plan).encode()


def split(path: str) -> tuple[list[str] | None, str]:
    """(names, what stood behind a "?"): slashes at the ends and doubled ones do not count. None for a path that leads upwards."""
    plain, _, query = path.strip("\0").partition("?")
    names = [name for name in plain.split("/") if name not in ("", ".")]
    if ".." in names or any("\0" in name or "\\" in name for name in names):
        return None, query
    if names and names[0] in _ALIASES:
        names[0] = _ALIASES[names[0]]
    return names, query


def _known(value: Any) -> Future[Any]:
    """A future that has come."""
    future: Future[Any] = Future()
    future.set_result(value)
    return future

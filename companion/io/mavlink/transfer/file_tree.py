"""The files that a vessel offers over MAVLink FTP, all read-only: metadata, parameters, plans, logs.

    general.json  parameters.json.xz  actuators.json.xz  events.json.xz
    @PARAM/    param.pck  usv.params
    plans/     mission.dat  fence.dat  rally.dat  current.plan
    logs/      one folder for each run, as on the disk

ArduPilot's names for them (@MISSION/mission.dat, @FENCE/fence.dat, @RALLY/rally.dat, @MAV_LOG) work too, but are not
listed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from functools import partial
from typing import Any, Protocol

from companion.io.mavlink.transfer.component_metadata import Descriptions, crc32
from companion.io.mavlink.transfer.disk_files import Entry, LogStore
from companion.io.mavlink.transfer.mission_codec import plan_data
from companion.io.mavlink.transfer.parameter_file import param_pck, params_text
from companion.io.mavlink.wire.personas import Persona
from companion.loop import Vessel
from companion.mission import qgc_plan
from companion.mission.plan import PlanKind
from companion.mission.plan_file import PlanFile, PlanFileError

_MOST_MADE = 6
_LOGS = "logs"
_ALIASES = {"@MAV_LOG": _LOGS, "@MISSION": "plans", "@FENCE": "plans", "@RALLY": "plans"}

Make = Callable[[], bytes]
"""Makes the content of a file, from what the vessel had when it was asked for."""


class OpenFile(Protocol):
    """An open file."""

    size: int

    def read(self, offset: int, count: int) -> bytes | None:
        """Up to `count` bytes from `offset`; None while they are being read. Raises OSError when the disk fails."""
        ...

    def crc32(self) -> Future[int]:
        """MAVLink's CRC32 of the whole file, as a future."""
        ...

    def close(self) -> None:
        """Close the file."""
        ...


class MemoryFile:
    """An `OpenFile` of bytes made when the file was opened; later changes do not affect it."""

    def __init__(self, data: bytes) -> None:
        self.size = len(data)
        self._data = data

    def read(self, offset: int, count: int) -> bytes:
        """As `OpenFile.read`; never None."""
        return self._data[offset : offset + max(0, count)]

    def crc32(self) -> Future[int]:
        """As `OpenFile.crc32`; done at once."""
        return _done(crc32(self._data))

    def close(self) -> None:
        """Nothing to close."""


class FileTree:
    """`entries` and `open` by a path as a client writes it. Each returns a future; its result is None for a path that
    does not exist."""

    def __init__(
        self, vessel: Vessel, system: int, component: int, described: Descriptions, store: LogStore | None
    ) -> None:
        """`store`: the log folders; None where nothing is logged."""
        self._vessel = vessel
        self._address = (system, component)
        self._store = store
        self._described = described
        self._made: dict[tuple[object, ...], bytes] = {}  # files of plans, the newest last; used by the worker alone
        self._folders: Mapping[str, Mapping[str, Callable[[Persona], Make]]] = {
            "@PARAM": {
                "param.pck": lambda _: _ready(param_pck(vessel.parameters)),
                "usv.params": lambda _: _ready(params_text(vessel.parameters, *self._address).encode()),
            },
            "plans": {
                "mission.dat": lambda persona: self._plan(PlanKind.MISSION, persona),
                "fence.dat": lambda persona: self._plan(PlanKind.FENCE, persona),
                "rally.dat": lambda persona: self._plan(PlanKind.RALLY, persona),
                "current.plan": lambda _: self._plan_file(),
            },
        }

    def entries(self, path: str, persona: Persona) -> Future[Sequence[Entry] | None]:
        """The entries of a directory, as that persona sees them."""
        names, _ = split(path)
        if names is None:
            return _done(None)
        if names and names[0] == _LOGS and self._store is not None:
            return self._store.entries(names[1:])  # type: ignore[return-value]  # a list is a sequence
        if not names:
            entries = [Entry(name, len(content)) for name, content in self._described.of(persona).files.items()]
            folders = [*self._folders, *(() if self._store is None else (_LOGS,))]
            return _done([*entries, *map(Entry, folders)])
        folder = self._folders.get("/".join(names))
        if folder is None:
            return _done(None)
        files = [(name, make(persona)) for name, make in folder.items()]

        def listed() -> Sequence[Entry] | None:
            made = [(name, _attempt(make)) for name, make in files]
            return [Entry(name, len(data)) for name, data in made if data is not None]

        return self._vessel.worker.submit(listed)

    def open(self, path: str, persona: Persona) -> Future[OpenFile | None]:
        """Open a file, made for that persona."""
        names, query = split(path)
        if not names:
            return _done(None)
        if names[0] == _LOGS and self._store is not None:
            return self._store.open(names[1:])  # type: ignore[return-value]  # a disk file is an open file
        if names == ["@PARAM", "param.pck"] and query == "withdefaults=1":
            return _done(MemoryFile(param_pck(self._vessel.parameters, with_defaults=True)))
        if len(names) == 1:
            content = self._described.of(persona).files.get(names[0])
            return _done(None if content is None else MemoryFile(content))
        maker = self._folders.get("/".join(names[:-1]), {}).get(names[-1])
        if maker is None:
            return _done(None)
        make = maker(persona)

        def opened() -> OpenFile | None:
            data = _attempt(make)
            return None if data is None else MemoryFile(data)

        return self._vessel.worker.submit(opened)

    def _plan(self, kind: PlanKind, persona: Persona) -> Make:
        plans, tick = self._vessel.plans, self._vessel.last_tick
        items, home = plans.items(kind), None if tick is None else tick.status.home
        key = (kind, plans.plan_id(kind), len(items), home, persona.name)
        return partial(self._kept, key, lambda: plan_data(kind, items, home, persona, *self._address))

    def _plan_file(self) -> Make:
        plans = self._vessel.plans
        plan = PlanFile(plans.items(PlanKind.MISSION), plans.items(PlanKind.FENCE), plans.items(PlanKind.RALLY))
        key = tuple((plans.plan_id(kind), len(plans.items(kind))) for kind in PlanKind)
        return partial(self._kept, key, lambda: qgc_plan.write("current.plan", plan).encode())

    def _kept(self, key: tuple[object, ...], make: Make) -> bytes:
        """A file as it was made before, else made now: who lists a folder usually opens a file next."""
        data = self._made.pop(key, None)
        data = self._made[key] = make() if data is None else data
        if len(self._made) > _MOST_MADE:
            del self._made[next(iter(self._made))]
        return data


def _attempt(make: Make) -> bytes | None:
    """The content of a file; None for a plan that its format cannot hold."""
    try:
        return make()
    except (PlanFileError, ValueError):
        return None


def _ready(data: bytes) -> Make:
    return lambda: data


def split(path: str) -> tuple[list[str] | None, str]:
    """(names of the path's parts, what follows a "?"). Slashes at the ends and double ones are ignored. The names are
    None for an invalid path, or one that leads upwards."""
    plain, _, query = path.strip("\0").partition("?")
    names = [name for name in plain.split("/") if name not in ("", ".")]
    if ".." in names or any("\0" in name or "\\" in name for name in names):
        return None, query
    if names and names[0] in _ALIASES:
        names[0] = _ALIASES[names[0]]
    return names, query


def _done(value: Any) -> Future[Any]:
    """A future that is done."""
    future: Future[Any] = Future()
    future.set_result(value)
    return future

"""What a vessel stores over a restart: changed parameters, the three plans, mission progress, the thrusters' wear, the
signing key.

One small JSON file each, in one directory that one process locks at a time. A file is replaced whole (`replacing.py`),
so a power cut leaves the old content or the new. A file that cannot be read is renamed, with a warning. A file that
cannot be written gives a warning, and is tried again (`writer.py`). After the directory is locked, nothing here raises.
"""

from __future__ import annotations

import fcntl
import json
import math
import os
import struct
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from companion.core.storing import Ticket
from companion.mission.plan import PlanItem, PlanKind, item_number
from companion.params.table import TABLE
from companion.record import signing_file
from companion.record.signing_file import Kept, SigningFileError, read_signing
from companion.record.writer import USUAL, Access, DirectWriter, Writer

_FORMAT = 1
_LOCK_NAME = "lock"
_PARAMETERS = "parameters.json"
_PROGRESS = "progress.json"
_WEAR = "wear.json"
_PLANS = {PlanKind.MISSION: "mission.json", PlanKind.FENCE: "fence.json", PlanKind.RALLY: "rally.json"}
_LOST = {
    _PARAMETERS: "Parameters lost at start: the defaults count",
    _PLANS[PlanKind.MISSION]: "Mission lost at start: upload it again",
    _PLANS[PlanKind.FENCE]: "Fence lost at start: upload it again",
    _PLANS[PlanKind.RALLY]: "Rally points lost at start: upload them again",
}
_COLUMNS = ("command", "frame", "param1", "param2", "param3", "param4", "x", "y", "z", "autocontinue", "current")
_INT32 = range(-(2**31), 2**31)
_FLOAT32 = struct.Struct("<f")
_LARGEST_FLOAT32 = 3.4028234663852886e38
_USUAL_NAN = _FLOAT32.pack(math.nan)

T = TypeVar("T")


class StateFileBusy(Exception):
    """Another companion has locked the state directory; the text says what to do."""


def lock_of_another(directory: Path) -> int | None:
    """The lock of a state directory of another user, to be closed; None where no companion has run there. Raises
    StateFileBusy while one runs there."""
    try:
        fd = os.open(directory / _LOCK_NAME, os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return None
    _lock(fd, directory)
    return fd


def _lock(fd: int, directory: Path) -> None:
    """Lock it, or close it and raise StateFileBusy."""
    try:
        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(fd)
        raise StateFileBusy(
            f"state directory {directory} is in use by another companion; "
            "stop that one, or give this one its own with --state DIR"
        ) from None


class StateFile:
    """The state directory of one vessel. Every load returns the content, and a warning for each problem.

    Every save returns a ticket at once. Remembers parameters of other versions, and values that this one refuses, so
    that they are still there when that version runs again; what it has loaded, in case somebody removes the directory;
    and what it could not load, until that is stored anew. `on_warning` receives problems of saving, and of the
    constructor; `on_good_news` that they are over.
    """

    def __init__(
        self,
        directory: Path,
        on_warning: Callable[[str], None] = lambda text: None,
        known_parameters: Collection[str] | None = None,
    ) -> None:
        """Create and lock `directory`. Raises StateFileBusy where another process has it; any other problem is a
        warning.

        `known_parameters`: names that this version knows; None: those of the table.
        """
        self.directory = directory
        self.on_warning = on_warning
        self.on_good_news: Callable[[str], None] = lambda text: None
        self._known = (
            frozenset(spec.name for spec in TABLE) if known_parameters is None else frozenset(known_parameters)
        )
        self._strangers: dict[str, float] = {}
        self._loaded: dict[str, bytes] = {}
        self._lost: dict[str, str] = {}
        self._lock_fd: int | None = None
        self._writer: Writer = DirectWriter(directory)
        try:
            directory.mkdir(parents=True, exist_ok=True)
            self._hold()
        except OSError as error:
            why = f"{error.strerror}; nothing is stored over a restart"
            self.on_warning(f"state directory {directory}: {why}; choose another by --state")

    @property
    def writer(self) -> Writer:
        """What writes the files: at once, unless `write_with` was called."""
        return self._writer

    def write_with(self, writer: Writer) -> None:
        """Let `writer` write the files from now on."""
        self._writer = writer
        for name, content in self._loaded.items():
            writer.known(name, content)

    @property
    def lost(self) -> Sequence[str]:
        """A line for operators for each file that was stored and does not count, until it is stored anew."""
        return tuple(self._lost.values())

    def tell_news(self) -> None:
        """Pass on what the writer has met with since the last call."""
        for news in self._writer.news():
            (self.on_good_news if news.good else self.on_warning)(news.text)

    def close(self) -> None:
        """Write what waits, and unlock the directory."""
        self._writer.close()
        self.tell_news()
        fd, self._lock_fd = self._lock_fd, None
        if fd is not None:
            os.close(fd)

    def copy_to(self, folder: Path) -> None:
        """Copy the stored files, so that the run can be repeated from its start. What cannot be read is left out;
        loading it has given a warning. Raises OSError where the folder cannot be written."""
        folder.mkdir(parents=True, exist_ok=True)
        for name in (_PARAMETERS, *_PLANS.values(), _PROGRESS):
            try:
                content = (self.directory / name).read_bytes()
            except OSError:
                continue
            (folder / name).write_bytes(content)

    # --- parameters ------------------------------------------------------------------------------------------------

    def load_parameters(self) -> tuple[dict[str, float], list[str]]:
        """(values by name, warnings), of the names that this version knows."""
        warnings: list[str] = []
        values = self._load(_PARAMETERS, _parameters_of, warnings) or {}
        self._strangers = {name: value for name, value in values.items() if name not in self._known}
        if self._strangers:
            warnings.append(f"parameters of another version, not used: {', '.join(sorted(self._strangers))}")
        return {name: value for name, value in values.items() if name in self._known}, warnings

    def keep_aside(self, name: str, value: float) -> None:
        """Keep a loaded value that this version refuses: another may take it."""
        self._strangers[name] = value

    def let_go(self, name: str) -> bool:
        """Forget a value kept aside, for the operator has set another; returns whether there was one."""
        return self._strangers.pop(name, None) is not None

    def save_parameters(self, values: Mapping[str, float]) -> Ticket:
        """Store exactly `values`, those that differ from the defaults."""
        content = {"format": _FORMAT, "parameters": {**self._strangers, **values}}
        return self._save(_PARAMETERS, lambda: _json(content))

    # --- plans -----------------------------------------------------------------------------------------------------

    def load_plans(self) -> tuple[dict[PlanKind, tuple[PlanItem, ...]], list[str]]:
        """(the three plans, warnings); a missing plan is empty."""
        warnings: list[str] = []
        plans = {kind: self._load(name, _items_of, warnings) or () for kind, name in _PLANS.items()}
        return plans, warnings

    def plan_refused(self, kind: PlanKind) -> None:
        """This version does not take the plan that was loaded; it stays in its file."""
        self._lose(_PLANS[kind])

    def save_plan(self, kind: PlanKind, items: Sequence[PlanItem]) -> Ticket:
        """Store `items`, bit for bit."""
        kept = tuple(items)
        return self._save(_PLANS[kind], lambda: _plan_json(kept))

    # --- progress --------------------------------------------------------------------------------------------------

    def load_progress(self) -> tuple[dict[str, Any], list[str]]:
        """(mission progress, warnings); {} where it is unknown."""
        warnings: list[str] = []
        return self._load(_PROGRESS, _progress_of, warnings) or {}, warnings

    def save_progress(self, progress: Mapping[str, Any]) -> Ticket:
        """Store `progress`: names with numbers, texts, None, or lists of them."""
        content = {"format": _FORMAT, "progress": dict(progress)}
        return self._save(_PROGRESS, lambda: _json(content))

    # --- wear ------------------------------------------------------------------------------------------------------

    def load_wear(self) -> tuple[dict[str, dict[str, Any]], list[str]]:
        """(rows of wear by thruster, warnings); {} where it is unknown."""
        warnings: list[str] = []
        return self._load(_WEAR, _wear_of, warnings) or {}, warnings

    def save_wear(self, rows: Mapping[str, Mapping[str, Any]]) -> Ticket:
        """Store the rows: numbers by name, by thruster."""
        content = {"format": _FORMAT, "thrusters": dict(rows)}
        return self._save(_WEAR, lambda: _json(content))

    # --- signing ---------------------------------------------------------------------------------------------------

    def load_signing(self) -> tuple[Kept, list[str]]:
        """((key, horizon), warnings); (None, 0) where there is no file, or it is not safe."""
        try:
            return read_signing(self.directory), []
        except SigningFileError as error:
            return (None, 0), [str(error)]

    def save_signing(self, key: bytes | None, horizon: int) -> Ticket:
        """Store both."""
        access = signing_file.access(self.directory)
        return self._save(signing_file.FILE, lambda: signing_file.encoded(key, horizon), access)

    # --- files -----------------------------------------------------------------------------------------------------

    def _hold(self) -> None:
        fd = os.open(self.directory / _LOCK_NAME, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        _lock(fd, self.directory)
        self._lock_fd = fd

    def _save(self, name: str, content: Callable[[], bytes], access: Access = USUAL) -> Ticket:
        self._lost.pop(name, None)
        ticket = self._writer.submit(name, content, access)
        self.tell_news()
        return ticket

    def _load(self, name: str, understand: Callable[[dict[str, Any]], T], warnings: list[str]) -> T | None:
        """The content of a file; None where there is none. A bad file is renamed, with a warning."""
        path = self.directory / name
        try:
            data = path.read_bytes()
            content = json.loads(data)
            if not isinstance(content, dict) or content.get("format") != _FORMAT:
                raise ValueError("unknown format")
            understood = understand(content)
            self._loaded[name] = data
            self._writer.known(name, data)
            return understood
        except (FileNotFoundError, NotADirectoryError):
            return None
        except OSError as error:
            reason = error.strerror or "unreadable"
        except (ValueError, TypeError, KeyError, OverflowError, RecursionError) as error:
            reason = f"corrupt ({error})"
        warnings.append(f"{path}: {reason}; {self._set_aside(path)}")
        self._lose(name)
        return None

    def _lose(self, name: str) -> None:
        if name in _LOST:
            self._lost[name] = _LOST[name]

    @staticmethod
    def _set_aside(path: Path) -> str:
        number = 1
        while path.with_name(f"{path.name}.corrupt-{number}").exists():
            number += 1
        aside = path.with_name(f"{path.name}.corrupt-{number}")
        try:
            path.rename(aside)
        except OSError as error:
            return f"could not be set aside: {error.strerror}"
        return f"set aside as {aside.name}"


def read_plan(directory: Path, kind: PlanKind) -> tuple[PlanItem, ...]:
    """The plan in a state directory or its copy in a log folder; empty where it is missing or unreadable."""
    try:
        return _items_of(json.loads((directory / _PLANS[kind]).read_text(encoding="utf-8")))
    except (OSError, ValueError, KeyError, TypeError):
        return ()


def _json(content: Any) -> bytes:
    return json.dumps(content, separators=(",", ":")).encode()


def _plan_json(items: Sequence[PlanItem]) -> bytes:
    """A plan's file. It is made row by row, so that a long plan does not keep the other threads waiting."""
    head = _json({"format": _FORMAT, "columns": _COLUMNS, "items": []})
    return head.removesuffix(b"]}") + b",".join([_json(_row(item)) for item in items]) + b"]}"


def _parameters_of(content: dict[str, Any]) -> dict[str, float]:
    values = content["parameters"]
    if not isinstance(values, dict):
        raise ValueError("no parameters in it")
    for name, value in values.items():
        if not _is_number(value) or not math.isfinite(value):
            raise ValueError(f"{name} is not a number")
    return values


def _progress_of(content: dict[str, Any]) -> dict[str, Any]:
    progress = content["progress"]
    if not isinstance(progress, dict):
        raise ValueError("no progress in it")
    return progress


def _wear_of(content: dict[str, Any]) -> dict[str, dict[str, Any]]:
    rows = content["thrusters"]
    if not isinstance(rows, dict) or not all(isinstance(row, dict) for row in rows.values()):
        raise ValueError("no thrusters in it")
    return rows


def _items_of(content: dict[str, Any]) -> tuple[PlanItem, ...]:
    if tuple(content["columns"]) != _COLUMNS:
        raise ValueError("other columns")
    return tuple(_item(seq, row) for seq, row in enumerate(content["items"]))


def _row(item: PlanItem) -> list[float | str | None]:
    params = (item.param1, item.param2, item.param3, item.param4)
    return [
        item.command,
        item.frame,
        *(p if p == p else _nan(p) for p in params),
        item.x,
        item.y,
        item.z if item.z == item.z else _nan(item.z),
        item.autocontinue,
        item.current,
    ]


def _nan(value: float) -> str | None:
    """JSON has no NaN: null for the usual NaN, else its bits, since the plan's id depends on them."""
    bits = _FLOAT32.pack(value)
    return None if bits == _USUAL_NAN else bits.hex()


def _item(seq: int, row: Sequence[Any]) -> PlanItem:
    command, frame, param1, param2, param3, param4, x, y, z, autocontinue, current = row
    for value, top in ((command, 0xFFFF), (frame, 0xFF), (autocontinue, 0xFF), (current, 0xFF)):
        if type(value) is not int or not 0 <= value <= top:
            raise ValueError(f"item {item_number(seq)} is out of range")
    if type(x) is not int or type(y) is not int or x not in _INT32 or y not in _INT32:
        raise ValueError(f"item {item_number(seq)} is out of range")
    return PlanItem(
        seq, command, frame, _real(param1), _real(param2), _real(param3), _real(param4), x, y, _real(z),
        autocontinue, current,
    )  # fmt: skip


def _real(value: Any) -> float:
    if value is None:
        return math.nan
    if isinstance(value, str):
        bits = bytes.fromhex(value)
        if len(bits) == _FLOAT32.size and math.isnan(_FLOAT32.unpack(bits)[0]):
            return float(_FLOAT32.unpack(bits)[0])
    if not _is_number(value) or (abs(value) > _LARGEST_FLOAT32 and math.isfinite(value)):
        raise ValueError(f"{value!r} is not a number that MAVLink can carry")
    return float(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)

"""Imports the compiled arithmetic where it is built and as new as its sources; otherwise all runs interpreted.

`python -m sitl.native` compiles most modules of `companion` and `sitl` into one library in `companion/_native`. It
counts only while every file that it was made of is still the same, for this Python: by size and time of change, or else
to the last byte. The environment variable USV_NATIVE decides: 0 leaves it, `require` refuses to start without it,
anything else takes it where it counts.
"""

from __future__ import annotations

import ctypes
import hashlib
import importlib.machinery
import importlib.util
import json
import os
import sys
from collections.abc import Iterable, Sequence
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
FOLDER = Path(__file__).resolve().parent / "_native"
LIBRARY = "usv__mypyc"  # as mypyc names the library of the group "usv"
SUFFIX = importlib.machinery.EXTENSION_SUFFIXES[0]

status = "interpreted"
"""How this process does its arithmetic, for people: `companion --version` and the log's manifest show it."""


def digest(root: Path, files: Iterable[str]) -> str:
    """One number for the contents of `files`, which are relative to `root`. Raises OSError for one that is missing."""
    total = hashlib.sha256()
    for name in files:
        total.update(f"{name}\n".encode())
        total.update(hashlib.sha256((root / name).read_bytes()).digest())
    return total.hexdigest()


def stamp(root: Path, files: Iterable[str]) -> str:
    """One number for the sizes and the times of change of `files`: while it stays, so have their contents. Raises
    OSError for one that is missing."""
    total, place = hashlib.sha256(), str(root)
    for name in files:
        found = os.stat(f"{place}/{name}")  # noqa: PTH116  a third of the time
        total.update(f"{name} {found.st_size} {found.st_mtime_ns}\n".encode())
    return total.hexdigest()


def install(root: Path = ROOT, folder: Path = FOLDER, wish: str | None = None) -> str:
    """Let the import system take the compiled modules of `folder`. Returns the status, and keeps it in `status`.

    `wish`: as USV_NATIVE. Raises ImportError where that requires a build that there is not.
    """
    global status
    wish = os.environ.get("USV_NATIVE", "") if wish is None else wish
    if wish == "0":
        status = "interpreted, by USV_NATIVE=0"
        return status
    modules, status = usable(root, folder)
    if modules:
        sys.meta_path.insert(0, _Finder(folder / f"{LIBRARY}{SUFFIX}", modules))
    elif wish == "require":
        raise ImportError(f"USV_NATIVE=require, but the arithmetic is {status}: `make native` builds it")
    return status


def usable(root: Path, folder: Path) -> tuple[Sequence[str], str]:
    """The modules of a build that counts, or none; and the status."""
    try:
        index = json.loads((folder / "index.json").read_text())
        if not (folder / f"{LIBRARY}{SUFFIX}").is_file():
            return (), f"interpreted: the native build is for another Python ({index['for']})"
        files = index["files"]
        if stamp(root, files) != index.get("stamp") and digest(root, files) != index["digest"]:
            return (), "interpreted: the native build is older than the sources"
    except (OSError, ValueError, KeyError):
        return (), "interpreted"
    return index["modules"], f"native ({len(index['modules'])} modules, {index['by']})"


class _Finder:
    """Finds the compiled modules, and makes them from the library, which is loaded with the first of them."""

    def __init__(self, library: Path, modules: Sequence[str]) -> None:
        self._library = library
        self._modules = frozenset(modules)
        self._loaded: ModuleType | None = None

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        """As `importlib.abc.MetaPathFinder`."""
        return ModuleSpec(name, self, origin=str(self._library)) if name in self._modules else None  # type: ignore[arg-type]

    def create_module(self, spec: ModuleSpec) -> Any:
        """The module, whose statements have run. As the shims do that mypyc makes beside its library, one a module."""
        if self._loaded is None:
            self._loaded = self._load()
        name = f"init_{spec.name.replace('.', '___')}"
        pointer_of = ctypes.pythonapi.PyCapsule_GetPointer
        pointer_of.restype, pointer_of.argtypes = ctypes.c_void_p, (ctypes.py_object, ctypes.c_char_p)
        pointer = pointer_of(getattr(self._loaded, name), f"{LIBRARY}.{name}".encode())
        return ctypes.PYFUNCTYPE(ctypes.py_object)(pointer)()

    def exec_module(self, module: ModuleType) -> None:
        """Nothing is left to do."""

    def _load(self) -> ModuleType:
        spec = importlib.util.spec_from_file_location(LIBRARY, self._library)
        assert spec is not None and spec.loader is not None
        library = importlib.util.module_from_spec(spec)
        sys.modules[LIBRARY] = library
        spec.loader.exec_module(library)
        return library

"""The reduced rights of a script's process, which it gives itself before the script is loaded and cannot take back.

Address space, file size, descriptors and core files are limited (`setrlimit`); it gains no rights by programs that it
starts (`PR_SET_NO_NEW_PRIVS`); it comes after all other programs (`nice`, no real-time priority); it dies with its
keeper (`PR_SET_PDEATHSIG`); where the kernel has Landlock, it writes below its own folder only.

That holds accidents, not attacks. The process is the same user's as the companion: it can read what that user reads
(the signing key among it), reach the network, and open a link of its own, as every program of that user can.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import resource
import signal
import struct
from pathlib import Path

_NICE = 10
_DESCRIPTORS = 128
_PR_SET_PDEATHSIG, _PR_SET_NO_NEW_PRIVS = 1, 38
_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446  # system calls, the same numbers on all of Linux
_RULE_PATH_BENEATH, _VERSION = 1, 1
_WRITING_1 = 0b1111111110010  # write, remove, make of ABI 1: all of it that is not reading
_REFER, _TRUNCATE = 1 << 13, 1 << 14  # of ABI 2 and 3
_FILE_ONLY = (1 << 1) | _TRUNCATE  # that can be granted on a file or device

MEGABYTE = 1_000_000


def reduce_rights(memory_mb: int, disk_mb: int, keeper: int) -> None:
    """Limit this process. `keeper`: process id of its keeper; where that is gone already, this process ends."""
    for name, most in (
        (resource.RLIMIT_AS, memory_mb * MEGABYTE),
        (resource.RLIMIT_FSIZE, disk_mb * MEGABYTE),
        (resource.RLIMIT_NOFILE, _DESCRIPTORS),
        (resource.RLIMIT_CORE, 0),
    ):
        hard = resource.getrlimit(name)[1]
        least = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(name, (least, least))
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    with contextlib.suppress(OSError):
        os.nice(_NICE)
    library = _library()
    library.prctl(_PR_SET_NO_NEW_PRIVS, *map(ctypes.c_ulong, (1, 0, 0, 0)))
    library.prctl(_PR_SET_PDEATHSIG, *map(ctypes.c_ulong, (signal.SIGKILL, 0, 0, 0)))
    if os.getppid() != keeper:
        raise SystemExit("the keeper is gone")


def write_only_below(folder: Path) -> bool:
    """Let this process write below `folder` and to /dev/null only. Whether the kernel can do that (Landlock)."""
    library = _library()
    version = _call(library, _CREATE_RULESET, None, 0, _VERSION)
    if version < 1:
        return False
    handled = _WRITING_1 | (_REFER if version >= 2 else 0) | (_TRUNCATE if version >= 3 else 0)
    attributes = struct.pack("<Q", handled)
    ruleset = _call(library, _CREATE_RULESET, attributes, len(attributes), 0)
    if ruleset < 0:
        return False
    try:
        granted = (folder, handled), (Path("/dev/null"), handled & _FILE_ONLY)
        allowed = all(_add(library, ruleset, path, rights) for path, rights in granted)
        return allowed and _call(library, _RESTRICT_SELF, ruleset, 0) == 0
    finally:
        os.close(ruleset)


def _add(library: ctypes.CDLL, ruleset: int, path: Path, rights: int) -> bool:
    descriptor = os.open(path, os.O_PATH | os.O_CLOEXEC)
    try:
        rule = struct.pack("<Qi", rights, descriptor)  # packed, as the kernel's struct is
        return _call(library, _ADD_RULE, ruleset, _RULE_PATH_BENEATH, rule, 0) == 0
    finally:
        os.close(descriptor)


def _call(library: ctypes.CDLL, number: int, *arguments: int | bytes | None) -> int:
    """A system call; −1 where the kernel refuses it."""
    words = (ctypes.c_long(word) if isinstance(word, int) else word for word in arguments)
    result: int = library.syscall(ctypes.c_long(number), *words)
    return result


def _library() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)

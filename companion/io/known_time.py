"""The time of day, where it is known to be right: by satellites, or by a computer whose clock is synchronised."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

from companion.core.plausible_time import EARLIEST_UNIX_NS

_TIME_ERROR = 5  # adjtimex(2): the clock is not synchronised
_TIMEX_BYTES = 512  # struct timex has 208 on 64-bit Linux; all zeros: change nothing
_AGREE_NS = 30_000_000_000


class KnownTime:
    """`unix_ns()`: the time where it is known. Two clocks that both say to be right, and differ by more than 30 s,
    make it unknown."""

    def __init__(
        self,
        synchronised: Callable[[], bool],
        host_unix_ns: Callable[[], int],
        satellites_unix_ns: Callable[[], int | None] | None = None,
    ) -> None:
        """`synchronised`: whether `host_unix_ns` is right. `satellites_unix_ns`: None where there is no receiver, and
        while it has no time."""
        self._synchronised = synchronised
        self._host_unix_ns = host_unix_ns
        self._satellites_unix_ns = satellites_unix_ns

    def unix_ns(self) -> int | None:
        """Unix time, ns; None: unknown."""
        satellites = None if self._satellites_unix_ns is None else self._satellites_unix_ns()
        if satellites is not None and satellites < EARLIEST_UNIX_NS:
            satellites = None
        if not self._synchronised():
            return satellites
        host = self._host_unix_ns()
        if host < EARLIEST_UNIX_NS:
            return satellites
        return None if satellites is not None and abs(host - satellites) > _AGREE_NS else host


def host_synchronised() -> bool:
    """Whether the kernel says that its clock is synchronised, by NTP for instance; False where it cannot say."""
    adjtimex = _adjtimex()
    return adjtimex is not None and 0 <= adjtimex(ctypes.create_string_buffer(_TIMEX_BYTES)) < _TIME_ERROR


@cache
def _adjtimex() -> Any:
    """The C library's function; None where it has none."""
    return getattr(ctypes.CDLL(None), "adjtimex", None)

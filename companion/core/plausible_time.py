"""Which times of day a receiver can mean."""

from __future__ import annotations

EARLIEST_UNIX_NS = 1_767_225_600_000_000_000
"""2026-01-01, before any release. A receiver that says less has no almanac yet, or counts weeks from 1024 too few."""
_YEAR_NS = 31_556_952_000_000_000  # on average
_LATEST_UNIX_NS = 4_102_444_800_000_000_000  # 2100-01-01


def is_plausible(unix_ns: int) -> bool:
    """Whether that many ns since 1970 may be now."""
    return EARLIEST_UNIX_NS <= unix_ns < _LATEST_UNIX_NS


def year_of(unix_ns: int) -> int:
    """The year in which that many ns since 1970 lie, for people: within a day of New Year it may be the next one's."""
    return 1970 + int(unix_ns // _YEAR_NS)

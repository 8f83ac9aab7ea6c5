"""How far a sweep has come: a bar on a terminal, else a line now and then; and its first failures as they happen."""

from __future__ import annotations

from typing import TYPE_CHECKING

from companion.core.progress import Told

if TYPE_CHECKING:
    from sitl.sweep.rows import Row

_MOST_SHOWN = 10  # failures; the report has all
_LINE_EVERY_S = 60.0


class SweepProgress:
    """Is told each row. `count`: how many are awaited; `told`: the bar; `now_s`: of any clock, the same in `take`;
    `lines`: whether nobody sees the bar, so that lines are printed."""

    def __init__(self, told: Told, count: int, now_s: float, lines: bool) -> None:
        self._told = told
        self._count = count
        self._begun_s = self._line_s = now_s
        self._done = 0
        self._failed = 0
        self._lines = lines

    def take(self, row: Row, now_s: float) -> None:
        """A run has ended."""
        self._done += 1
        if not row.ok:
            self._failed += 1
            self._show(row)
        self._told(self.words(now_s), self._done / self._count)
        if self._lines and now_s >= self._line_s + _LINE_EVERY_S and self._done < self._count:
            self._line_s = now_s
            print(self.words(now_s), flush=True)

    def words(self, now_s: float) -> str:
        """`34 of 8000 runs, 12.5 a minute, 10 h 37 min left, 2 failed`."""
        per_s = self._done / max(1e-3, now_s - self._begun_s)
        left = _time((self._count - self._done) / per_s) if per_s else "?"
        failed = f", {self._failed} failed" if self._failed else ""
        return f"{self._done} of {self._count} runs, {60.0 * per_s:.3g} a minute, {left} left{failed}"

    def _show(self, row: Row) -> None:
        if self._failed <= _MOST_SHOWN:
            why = row.error or ", ".join(row.failed_checks) or "no check failed"
            print(f"FAIL {why}\n     {row.run.command}", flush=True)
        if self._failed == _MOST_SHOWN:
            print("further failures are counted; the report has the worst of each point", flush=True)


def _time(seconds: float) -> str:
    if seconds < 60.0:
        return f"{seconds:.0f} s"
    hours, minutes = divmod(round(seconds / 60.0), 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min"

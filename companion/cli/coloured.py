"""The screen of a run for a person at a terminal, by rich: colours, and a status line below the lines."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.live import Live
from rich.text import Text

from companion.cli.terminal import Descriptor
from companion.core.decision import Severity, TextKind

_COLOURS: Mapping[TextKind, str] = {
    TextKind.DANGER: "bold white on red",
    TextKind.ALARM: "bold red",
    TextKind.REFUSAL: "red",
    TextKind.ATTENTION: "yellow",
}
_STYLES: Mapping[Severity, str] = {kind.severity: colour for kind, colour in _COLOURS.items()}


class ColouredScreen:
    """A `terminal.Screen`. `console`: where to; its `is_terminal` decides about colours and the status line."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._live: Live | None = None

    @property
    def has_status(self) -> bool:
        """See `Screen`."""
        return self._console.is_terminal

    def begin(self) -> None:
        """See `Screen`."""
        if self.has_status:
            self._live = Live(console=self._console, auto_refresh=False, transient=True)
            self._live.start()

    def end(self) -> None:
        """See `Screen`."""
        if self._live is not None:
            self._live.stop()

    def line(self, text: str, severity: Severity | None) -> None:
        """See `Screen`."""
        style = "" if severity is None else _STYLES.get(severity, "")
        self._console.print(Text(text, style=style), soft_wrap=True)

    def status(self, text: str) -> None:
        """See `Screen`."""
        if self._live is not None:
            self._live.update(Text(text, style="reverse", no_wrap=True, overflow="ellipsis"), refresh=True)


def console_on(fd: int, **settings: Any) -> Console:
    """A rich console that writes to a descriptor."""
    return Console(file=Descriptor(fd), highlight=False, **settings)  # type: ignore[arg-type]  # all that rich uses

"""The feed of a running companion → the board. Comes back by itself when the companion does."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path

from companion.console.board import Board
from companion.record.feed import address_of

_AGAIN_S = 1.0
_LONGEST_LINE = 8 * 1024 * 1024


async def read_feed(path: Path, board: Board) -> None:
    """Read the socket at `path` for ever."""
    while True:
        try:
            with address_of(path) as address:
                reader, writer = await asyncio.open_unix_connection(address, limit=_LONGEST_LINE)
        except OSError as error:
            board.tell("link", {"feed": False, "text": f"no companion runs: {path}: {error.strerror}"})
            await asyncio.sleep(_AGAIN_S)
            continue
        board.tell("link", {"feed": True, "text": ""})
        try:
            while text := await reader.readline():
                board.take(json.loads(text))
        except (OSError, ValueError):  # it ended in the middle of a line
            pass
        finally:
            writer.close()
        board.tell("link", {"feed": False, "text": "the companion has ended"})
        await asyncio.sleep(_AGAIN_S)

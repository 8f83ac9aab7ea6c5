"""A bad network between the companion and a client: datagrams vanish, each way, by a seeded stream."""

from __future__ import annotations

import random
import select
import socket
import threading
from types import TracebackType
from typing import Any


class LossyNetwork:
    """Between a companion that sends to `port` and a client that listens at `client_port`."""

    def __init__(self, client_port: int, loss: float, seed: int) -> None:
        self._client = ("127.0.0.1", client_port)
        self._loss, self._draws = loss, random.Random(seed)
        self._boat_side = self._socket()
        self._client_side = self._socket()
        self.port: int = self._boat_side.getsockname()[1]
        self.lost = 0
        self._boat: Any = None
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._carry, name="lossy")

    def __enter__(self) -> LossyNetwork:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._over.set()
        self._thread.join()
        self._boat_side.close()
        self._client_side.close()

    @staticmethod
    def _socket() -> socket.socket:
        made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        made.bind(("127.0.0.1", 0))
        return made

    def _carry(self) -> None:
        while not self._over.is_set():
            for readable in select.select([self._boat_side, self._client_side], [], [], 0.1)[0]:
                try:
                    data, sender = readable.recvfrom(65535)
                except OSError:  # nobody listens there yet
                    continue
                if readable is self._boat_side:
                    self._boat = sender
                if self._draws.random() < self._loss:
                    self.lost += 1
                elif readable is self._boat_side:
                    self._client_side.sendto(data, self._client)
                elif self._boat is not None:
                    self._boat_side.sendto(data, self._boat)

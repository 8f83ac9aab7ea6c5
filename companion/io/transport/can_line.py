"""`can:` ports: CAN frames through python-can, as `companion.core.can_frame` lays them out.

can:can0                                            SocketCAN; first `ip link set can0 up type can bitrate 250000`
can:239.74.163.2:43113?interface=udp_multicast      frames in UDP multicast, between processes without virtual CAN
can:boat?interface=virtual                          within this process
"""

from __future__ import annotations

import errno
from typing import TYPE_CHECKING, Any

from companion.core.can_frame import SIZE, TROUBLE, pack, unpack
from companion.io.transport.line import Line

if TYPE_CHECKING:
    import can

_FRAMES_PER_READ = 64
_QUEUE_FULL = (None, errno.ENOBUFS, errno.EAGAIN)  # no other device acknowledges
_NO_KERNEL = (errno.EAFNOSUPPORT, errno.EPROTONOSUPPORT)


class CanLine(Line):
    """A CAN bus. Frames that the bus cannot take now are lost, as on any bus without a listener. The driver reports a
    bus that does not answer."""

    _bus: can.BusABC | None = None

    def _connect(self) -> None:
        try:
            import can
        except ImportError:
            raise OSError("python-can is not installed: pip install 'usv-companion[can]'") from None
        endpoint, interface = self._endpoint, self._endpoint.options.get("interface", "socketcan")
        options: dict[str, Any] = {"port": endpoint.port} if interface == "udp_multicast" and endpoint.port else {}
        try:
            self._bus = can.Bus(interface=interface, channel=endpoint.path, **options)
        except can.CanError as error:
            raise _os_error(error) from error

    def _disconnect(self) -> None:
        bus, self._bus = self._bus, None
        if bus is not None:
            bus.shutdown()

    def _descriptor(self) -> int | None:
        try:
            return None if self._bus is None else int(self._bus.fileno())
        except NotImplementedError:  # how python-can says that an interface has no descriptor to wait on
            return None

    def _receive(self) -> bytes:
        import can

        assert self._bus is not None
        received = b""
        try:
            for _ in range(_FRAMES_PER_READ):
                message = self._bus.recv(timeout=0)
                if message is None:
                    break
                if message.is_error_frame:
                    received += TROUBLE
                elif message.is_extended_id and not (message.is_remote_frame or message.is_fd):
                    received += pack(message.arbitration_id, bytes(message.data))
        except can.CanError as error:
            raise _os_error(error) from error
        return received

    def _transmit(self, data: bytes) -> int:
        import can

        assert self._bus is not None
        for identifier, content in unpack(data[: len(data) - len(data) % SIZE])[0]:
            try:
                self._bus.send(can.Message(arbitration_id=identifier, data=content, is_extended_id=True), timeout=0)
            except can.CanTimeoutError:
                break
            except can.CanOperationError as error:
                if error.error_code in _QUEUE_FULL:
                    break
                raise _os_error(error) from error
        return len(data)

    def _explain(self, error: BaseException) -> str:
        number, channel = getattr(error, "errno", None), self._endpoint.path
        if number in (errno.ENODEV, errno.ENXIO, errno.ENETDOWN):
            remedy = f"`sudo ip link set {channel} up type can bitrate 250000`"
            return f"{self._url}: no such CAN interface, or it is down; {remedy}"
        if number in _NO_KERNEL:
            remedy = "load its modules (`sudo modprobe can_raw`), or use ?interface=udp_multicast"
            return f"{self._url}: this kernel has no CAN; {remedy}"
        return super()._explain(error)


def _os_error(error: can.CanError) -> OSError:
    number = error.error_code
    return OSError(str(error)) if number is None else OSError(number, str(error))

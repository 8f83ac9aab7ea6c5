"""Names of serial ports that stay the same when cables are pulled and the computer restarts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from serial.tools import list_ports

DEV = Path("/dev")


@dataclass(frozen=True, slots=True)
class PortName:
    """`device`: its name in the kernel now; `name`: the one to write into a vessel's file; `about`: the adapter's own
    description; `note`: a warning about the name, or empty."""

    device: Path
    name: Path
    about: str
    note: str


def ports() -> list[PortName]:
    """The serial ports of this computer, by name."""
    found = list_ports.comports()
    identities = [(port.vid, port.pid, port.serial_number) for port in found]
    names = []
    for port in found:
        identity = (port.vid, port.pid, port.serial_number)
        twin = port.vid is not None and identities.count(identity) > 1
        about = port.product or port.description or ""
        names.append(named(Path(port.device), "" if about == "n/a" else about, twin))
    return sorted(names, key=lambda port: str(port.name))


def named(device: Path, about: str = "", twin: bool = False, dev: Path = DEV) -> PortName:
    """The lasting name of `device`: by the adapter's own identity, else one that udev rules give, else by the socket
    that it is plugged into.

    `twin`: another adapter has the same identity, so that only the socket tells them apart.
    """
    by_id, by_rule, by_path = (
        _links(dev / "serial" / "by-id", device),
        _links(dev, device),
        _links(dev / "serial" / "by-path", device),
    )
    if by_id and not twin:
        return PortName(device, by_id[0], about, "")
    if by_rule:
        return PortName(device, by_rule[0], about, "")
    if by_path:
        why = "two adapters call themselves the same" if twin else "the adapter has no name of its own"
        return PortName(device, by_path[0], about, f"{why}: it is known by the socket that it is plugged into")
    return PortName(device, device, about, "")


def _links(folder: Path, device: Path) -> Sequence[Path]:
    if not folder.is_dir():
        return ()
    target = device.resolve()
    return sorted(link for link in folder.iterdir() if link.is_symlink() and link.resolve() == target)

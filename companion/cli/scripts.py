"""The scripts of a vessel's file beside `companion run`: their private links, and their keeper."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from companion.config.scripts import ScriptConfig, script_system
from companion.core.decision import TextKind
from companion.io.mavlink.wire.script_link import ScriptLink
from companion.loop import Vessel
from companion.record.feed import SOCKET

FOLDER = "scripts"  # in the state folder: what the scripts write


def script_links(scripts: Sequence[ScriptConfig]) -> list[ScriptLink]:
    """A private link for each script."""
    return [ScriptLink(script.name, script_system(scripts, i), script.may) for i, script in enumerate(scripts)]


def keep_scripts(
    vessel: Vessel, vessel_file: Path, links: Sequence[ScriptLink], state: Path, log_folder: Path, now_s: float
) -> None:
    """Start the scripts of the vessel, and keep them. One whose folder cannot be made is left out, with a warning: the
    boat runs."""
    scripts = vessel.config.scripts
    if not scripts:
        return  # most boats have none: what keeps them is not loaded then
    from companion.scripting.keeper import KeptScript, ScriptKeeper
    from companion.scripting.keeping import Keeping
    from companion.scripting.runner import Settings

    kept = []
    for i, (script, link) in enumerate(zip(scripts, links, strict=True)):
        folder = (state / FOLDER / script.name).absolute()
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            link.fault = f"no folder: {error.strerror or error}"
            vessel.events.say(
                now_s, TextKind.ATTENTION, f"script_{script.name}", f"Script {script.name}: {link.fault}"[:50]
            )
            continue
        settings = Settings(
            file=str((vessel_file.parent / script.file).absolute()),
            arguments=script.arguments,
            system=script_system(scripts, i),
            feed=str((state / SOCKET).absolute()),
            folder=str(folder),
            keeper=0,
            status=-1,
            memory_mb=script.memory_mb,
            disk_mb=script.disk_mb,
        )
        keeping = Keeping(script.name, script.restart, script.watchdog_s, script.restart_s)
        log = log_folder.absolute() / f"script-{script.name}.log"
        kept.append(KeptScript(script.name, keeping, settings, log, link.theirs.fileno(), _shows(link)))
    parameters = vessel.parameters
    vessel.add_recorder(ScriptKeeper(kept, vessel.events.say, lambda: bool(parameters["SCR_ENABLE"])))


def _shows(link: ScriptLink) -> Callable[[str | None], None]:
    def show(fault: str | None) -> None:
        link.fault = fault

    return show

"""What MkDocs calls while it builds: the generated pages come in, and nothing that is fetched from elsewhere goes
out."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files

_ELSEWHERE = r"""["']?(?:https?:)?//"""
_LOADED = re.compile(
    rf"<(?:script|img|iframe|source)\b[^>]*\ssrc={_ELSEWHERE}[^>]*>"
    rf"|<link\b(?![^>]*canonical)[^>]*\shref={_ELSEWHERE}[^>]*>"
    rf"|url\({_ELSEWHERE}[^)]*\)"
)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages. An error in one of them ends the build with its name."""
    from mkdocs.exceptions import PluginError
    from mkdocs.structure.files import File

    sys.path.insert(0, str(Path(config.config_file_path).parent))
    from docs.generate.pages import PAGES

    for place, make in PAGES.items():
        try:
            files.append(File.generated(config, place, content=make()))
        except Exception as error:
            raise PluginError(f"{place} cannot be generated: {type(error).__name__}: {error}") from error
    return files


def on_post_build(config: MkDocsConfig) -> None:
    """No page may load anything from another server: the site is read on boats, without a network."""
    from mkdocs.exceptions import PluginError

    for page in sorted(Path(config.site_dir).rglob("*.html")):
        found = _LOADED.search(page.read_text(encoding="utf-8"))
        if found:
            raise PluginError(f"{page} loads from another server: {found[0]}")

"""`python -m docs.generate DIR`: the generated pages as files."""

from __future__ import annotations

import sys
from pathlib import Path

from docs.generate.pages import PAGES, write

if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
    sys.exit("usage: python -m docs.generate DIR")
write(Path(sys.argv[1]))
sys.stdout.write(f"{len(PAGES)} files in {sys.argv[1]}\n")

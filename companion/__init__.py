"""The boat's program. What it imports from here on comes compiled where that is built: see `native.py`."""

from companion import native

native.install()

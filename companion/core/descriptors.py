"""File descriptors, of which a process has a limited number."""

from __future__ import annotations

import errno

NO_DESCRIPTORS = (errno.EMFILE, errno.ENFILE)
"""Errors of a process, and of a system, that has none left. What asked for one may be tried again later."""

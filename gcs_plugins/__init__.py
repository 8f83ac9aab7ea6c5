"""Plug-ins for ground stations, made from the table of actions in `commands.py`."""

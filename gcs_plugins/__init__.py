"""What ground stations load, made from the one table of commands in `commands.py`."""

"""Commands that have a file of their own: each offers `add_to(commands)`, which hangs it into the command line."""

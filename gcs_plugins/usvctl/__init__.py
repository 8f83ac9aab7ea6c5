"""`usvctl`: the boat from the command line, and an example of how to script it with MAVSDK.

boat.py        connect, command, hear what it says: begin here
plans.py       missions, fences and rally points from and to files
parameters.py  get, set, save, load
files.py       logs and files
live.py        waiting for the boat, and watching it
cli.py         the commands
"""

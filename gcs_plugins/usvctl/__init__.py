"""`usvctl`: the boat from the command line, and an example of how to script it with MAVSDK.

boat.py        connect, command, read the answers: begin here
plans.py       missions, fences and rally points from and to files
parameters.py  get, set, save, load
files.py       logs and files
live.py        wait for the boat, and watch it
cli.py         the commands
"""

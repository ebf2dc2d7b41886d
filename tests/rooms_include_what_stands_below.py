#!/usr/bin/env python3
"""Fails where a file includes one of a folder that its own does not stand on, where a folder claims to stand on one that
it does not use, and where a file beside the rooms is in none.

    rooms_include_what_stands_below.py ROOT room=room,room...

A room is a folder and all below it that is no room itself. A file of another room may be included where that room, or a
folder around it, is named, and what lies in a folder around a room always.
"""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
below = {}
for argument in sys.argv[2:]:
    room, _, others = argument.partition("=")
    below[room] = set(filter(None, others.split(",")))


def folders(path):
    return [str(folder) for folder in pathlib.PurePath(path).parents]


def room_of(path):
    return next((folder for folder in folders(path) if folder in below), None)


houses = {pathlib.PurePath(room).parts[0] for room in below}
wrong = []
used = {room: set() for room in below}
for file in sorted(root.glob("*/**/*.[ch]pp")):
    name = str(file.relative_to(root))
    room = room_of(name)
    if room is None:
        if pathlib.PurePath(name).parts[0] in houses:
            wrong.append(f"{name}: no room")
        continue
    for number, line in enumerate(file.read_text().splitlines(), 1):
        include = re.match(r'\s*#\s*include\s*"(.*)"', line)
        if not include or room_of(include[1]) in (room, *folders(room)):
            continue
        arrow = next((folder for folder in folders(include[1]) if folder in below[room]), None)
        if arrow is None:
            wrong.append(f"{name}:{number}: {room} does not stand on {include[1]}")
        used[room].add(arrow)
wrong += [f"{room} does not use {other}" for room in below for other in sorted(below[room] - used[room])]
print("\n".join(wrong))
sys.exit(bool(wrong))

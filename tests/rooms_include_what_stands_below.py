#!/usr/bin/env python3
"""Fails where a file includes one of a folder that its own does not stand on, where a folder claims to stand on one that
it does not use, and where a file is in no room.

    rooms_include_what_stands_below.py ROOT

A room is a folder and all below it that is no room itself. A file of another room may be included where that room, or a
folder around it, is named, and what lies in a folder around a room always.
"""
import pathlib
import re
import sys

# What a room may include. The pages of the reports, which the daemon serves and the commands write alike, are made of
# documents: they include core and proto alone.
ROOMS = {
    "core": "",
    "core/kernels": "",
    "core/math": "core/kernels",
    "core/arm": "core/math core/kernels",
    "core/field": "core/math",
    "core/data": "core/arm core/math",
    "core/fit": "core/data core/field core/arm core/math core/kernels",
    "core/diagnosis": "core/fit core/data core/arm core/math",
    "core/calibrate": "core/diagnosis core/fit core/data core/field core/math",
    "core/frames": "core/fit core/data core/arm core/math",
    "core/change": "core/diagnosis core/frames core/fit core/data core/arm core/math",
    "core/quality": "core/change core/calibrate core/frames core/fit core/data core/arm core/math",
    "core/compensate": "core/data core/arm core/math",
    "core/plan": "core/quality core/fit core/data core/arm core/math core/kernels",
    "core/simulate": "core/data core/arm core/math",
    "proto": "core",
    "config": "config/table core proto",
    "config/table": "core",
    "config/import": "config/table core proto",
    "drivers": "core drivers/net proto",
    "drivers/net": "",
    "daemon": "config core daemon/report drivers drivers/net proto",
    "daemon/report": "core proto",
    "tools/bench": "core daemon drivers proto tools/truepose",
    "tools/experiment": "config core daemon/report proto tools/steering tools/truepose",
    "tools/proxy": "config core drivers/net proto tools/steering",
    "tools/sim": "config core drivers drivers/net proto tools/steering",
    "tools/steering": "drivers/net proto",
    "tools/truepose": "config core daemon/cell daemon/control daemon/replay daemon/report daemon/store drivers proto "
    "tools/steering tools/truepose/cell tools/truepose/doctor",
    "tools/truepose/cell": "config daemon proto",
    "tools/truepose/doctor": "config core daemon drivers proto",
}

root = pathlib.Path(sys.argv[1])
below = {room: set(others.split()) for room, others in ROOMS.items()}


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

#!/usr/bin/env python3
"""Checks the layout of the C++ sources against layers.txt.

    check_layers.py [ROOT]

* A room (src/remaps/ROOM/, or cli/) includes only headers of itself and of the rooms on its line.
* The lines of layers.txt form no circle, and every room has a line.
* Inside src/remaps every quoted include is written "remaps/ROOM/FILE".
* No two C++ files of the repository share a name.

Prints one line per offence, "file:line: what", and exits with 1 if there is any.
"""

import re
import sys
from pathlib import Path

SUFFIXES = {".h", ".cpp"}
SKIPPED = {"build", "out", "node_modules"}
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"')


def read_layers(path):
    """Returns {room: (line number, [rooms it may include])} and the offences in the file."""
    layers, offences = {}, []
    for number, line in enumerate(path.read_text().splitlines(), 1):
        line = line.split("#")[0].strip()
        if not line:
            continue
        room, colon, allowed = line.partition(":")
        if not colon or room in layers:
            offences.append(f"{path.name}:{number}: expected one line \"room: rooms\" per room")
            continue
        layers[room] = (number, allowed.split())
    for room, (number, allowed) in layers.items():
        for other in allowed:
            if other not in layers:
                offences.append(f"{path.name}:{number}: {room} may include {other}, "
                                "which has no line")
    return layers, offences


def find_circle(layers):
    """Returns the rooms of a circle of allowed includes, or nothing."""
    done, path = set(), []

    def visit(room):
        if room in path:
            return path[path.index(room):] + [room]
        if room in done or room not in layers:
            return None
        path.append(room)
        for other in layers[room][1]:
            circle = visit(other)
            if circle:
                return circle
        done.add(path.pop())
        return None

    for room in layers:
        circle = visit(room)
        if circle:
            return circle
    return None


def sources(root):
    """All C++ files of the repository, as paths relative to its root, in order."""
    found = []
    for path in root.rglob("*"):
        parts = path.relative_to(root).parts
        hidden = any(part.startswith(".") or part in SKIPPED for part in parts[:-1])
        if path.suffix in SUFFIXES and not hidden:
            found.append(path.relative_to(root))
    return sorted(found)


def room_of(source):
    if source.parts[:2] == ("src", "remaps") and len(source.parts) > 3:
        return source.parts[2]
    return "cli" if source.parts[0] == "cli" else None


def check_includes(root, source, room, allowed):
    offences = []
    for number, line in enumerate((root / source).read_text().splitlines(), 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        parts = match[1].split("/")
        if parts[0] == "remaps" and len(parts) >= 3:
            if parts[1] != room and parts[1] not in allowed:
                offences.append(f"{source}:{number}: {room} may not include {match[1]}")
        elif room != "cli":
            offences.append(f"{source}:{number}: write \"remaps/ROOM/FILE\" for {match[1]}")
    return offences


def check(root):
    layers, offences = read_layers(root / "layers.txt")
    circle = find_circle(layers)
    if circle:
        offences.append(f"layers.txt:{layers[circle[0]][0]}: rooms in a circle: "
                        + " -> ".join(circle))
    by_name = {}
    for source in sources(root):
        twin = by_name.setdefault(source.name, source)
        if twin != source:
            offences.append(f"{source}:1: has the name of {twin}")
        room = room_of(source)
        if room is None:
            continue
        if room not in layers:
            offences.append(f"{source}:1: room {room} has no line in layers.txt")
            continue
        offences += check_includes(root, source, room, layers[room][1])
    return offences


def main():
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent
    offences = check(root)
    for offence in offences:
        print(offence)
    return 1 if offences else 0


if __name__ == "__main__":
    sys.exit(main())

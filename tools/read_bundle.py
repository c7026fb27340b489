#!/usr/bin/env python3
"""Reads a bundle without any code of remaps and checks it against itself.

    tools/read_bundle.py scan.remaps [--points N]

Written from docs/formats alone: container, logs, tiles, map.bin, base.ply, sphere, manifest. Follows N removed
vertices through the logs to the base, in ordinary floating point, and compares with map.bin. Needs the
zstd command. Checks every size, count and range; the XXH3 checksums are left to `remaps verify`.
Exit code 1 and a line on standard error if something does not fit.
"""

import argparse
import bisect
import json
import pathlib
import struct
import subprocess
import sys

MAGIC = b"remapsSF"
NONE = 0xFFFFFFFF


class Mismatch(Exception):
    pass


def expect(condition, message):
    if not condition:
        raise Mismatch(message)


class SectionFile:
    """docs/formats/sections.md"""

    def __init__(self, path, kind):
        self.name = path.name
        self.data = path.read_bytes()
        magic, found, version = struct.unpack_from("<8s4sI", self.data, 0)
        expect(magic == MAGIC and found == kind and version == 1, f"{self.name}: bad header")
        at, count, _, magic = struct.unpack_from("<QQQ8s", self.data, len(self.data) - 32)
        expect(magic == MAGIC and at + 32 * count + 32 == len(self.data), f"{self.name}: bad trailer")
        self.index = [struct.unpack_from("<QQQQ", self.data, at + 32 * i) for i in range(count)]
        end = 16
        for offset, stored, _, _ in self.index:
            expect(offset == end, f"{self.name}: sections are not end to end")
            end += stored
        expect(end == at, f"{self.name}: bytes between sections and index")

    def __len__(self):
        return len(self.index)

    def section(self, i):
        offset, stored, raw, _ = self.index[i]
        done = subprocess.run(["zstd", "-dqc"], input=self.data[offset:offset + stored],
                              stdout=subprocess.PIPE, check=True)
        expect(len(done.stdout) == raw, f"{self.name}: section {i} has another size")
        return Reader(done.stdout, f"{self.name}: section {i}")


class Reader:
    """Little-endian values, one after the other."""

    def __init__(self, data, name):
        self.data, self.name, self.at = data, name, 0

    def array(self, code, count):
        values = struct.unpack_from(f"<{count}{code}", self.data, self.at)
        self.at += struct.calcsize(f"<{count}{code}")
        return values

    def u32(self):
        return self.array("I", 1)[0]

    def signed(self):
        value = shift = 0
        while True:
            byte = self.data[self.at]
            self.at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return (value >> 1) ^ -(value & 1)

    def running_sums(self, count):
        values, total = [], 0
        for _ in range(count):
            total += self.signed()
            values.append(total)
        return values

    def end(self):
        expect(self.at == len(self.data), f"{self.name}: {len(self.data) - self.at} bytes are left over")


class Segment:
    """docs/formats/log.md"""

    def __init__(self, records, survivors, level):
        r = records
        found, self.faces, origins, count, words = (r.u32() for _ in range(5))
        expect(found == level and origins == (self.faces if level else 0), f"{r.name}: bad counts")
        self.origin = r.array("I", 2 * origins)
        word = r.array("I", words)
        self.removed = r.running_sums(count)
        r.end()
        self.record = []  # (k, n, apex, turns, faces, ring)
        at = 0
        while at < words:
            k, apex = word[at] & 15, word[at] >> 8 & 15
            n = k + (word[at] >> 4 & 1)
            turns = [word[at + 1] >> 2 * i & 3 for i in range(k)]
            ring = [struct.unpack("<hh", struct.pack("<I", w)) for w in word[at + 2 + k:at + 2 + k + n]]
            self.record.append((k, n, apex, turns, word[at + 2:at + 2 + k], ring))
            at += 2 + k + n
        expect(at == words and len(self.record) == count, f"{r.name}: records and words differ")
        s = survivors
        left = s.u32()
        self.survivor = s.array("I", left)
        self.next = dict(zip(self.survivor, zip(*[iter(s.array("I", 2 * left))] * 2)))
        s.end()
        dropped = sum(k - (n - 2) for k, n, *_ in self.record)
        expect(left + dropped == self.faces, f"{s.name}: faces are neither dropped nor left")
        self.later = {}  # face -> ascending records that touch it
        for number, record in enumerate(self.record):
            for face in record[4]:
                self.later.setdefault(face, []).append(number)

    def carry(self, face, weights, first):
        """A point through the records from number `first` on. weights: three, of the face's corners."""
        while True:
            touching = self.later.get(face, [])
            at = bisect.bisect_left(touching, first)
            if at == len(touching):
                return face, weights
            number = touching[at]
            face, weights = step(self.record[number], face, weights)
            first = number + 1


def step(record, face, weights):
    """docs/formats/log.md, "Following a record forward", with signs as the doubles have them."""
    _, n, apex, turns, faces, ring = record
    slot = faces.index(face)
    b1, b2 = weights[(turns[slot] + 1) % 3], weights[(turns[slot] + 2) % 3]
    p1, p2 = ring[slot], ring[(slot + 1) % n]
    p = b1 * p1[0] + b2 * p2[0], b1 * p1[1] + b2 * p2[1]

    def area(a, b):
        return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])

    best = None
    for j in range(n - 2):
        a, b, c = ring[apex], ring[(apex + 1 + j) % n], ring[(apex + 2 + j) % n]
        w = area(b, c), area(c, a), area(a, b)
        if best is None or min(w) > min(best[1]):
            best = faces[j], w
        if min(w) >= 0:
            break
    w = [max(x, 0.0) for x in best[1]]
    return best[0], [x / sum(w) for x in w]


def read_tile(r):
    """docs/formats/tiles.md"""
    own, vertices, faces = (r.u32() for _ in range(3))
    position = list(zip(*[iter(r.array("f", 3 * vertices))] * 3))
    corner = r.running_sums(3 * faces)
    vertex_id = r.running_sums(vertices)
    face_id = r.running_sums(faces)
    r.end()
    expect(own <= vertices and all(0 <= v < vertices for v in corner), f"{r.name}: bad corner")
    return own, position, corner, vertex_id, face_id


SIZE = {"int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4, "uint32": 4, "int64": 8, "uint64": 8,
        "float32": 4, "float64": 8}


def read_attributes(path, given, vertices):
    """docs/formats/attributes.md. Returns the rows as bytes, by element."""
    sections = SectionFile(path, b"attr")
    rows, section = {}, 0
    for per, count in (("vertex", given["vertices"]), ("face", given["faces"]), ("corner", given["faces"])):
        width = sum(SIZE[c["type"]] for a in given["list"] if a["per"] == per for c in a["components"])
        rows[per] = []
        if width == 0:
            continue
        whole = 3 * (8 + width) if per == "corner" else width
        block = 1 << 14
        while block > 1 and block * whole > 1 << 20:
            block //= 2
        for first in range(0, count, block):
            data = sections.section(section).data
            expect(len(data) == whole * min(block, count - first), f"{path.name}: block {section} has another size")
            rows[per] += [data[at:at + whole] for at in range(0, len(data), whole)]
            section += 1
    expect(section == len(sections), f"{path.name}: {len(sections) - section} blocks too many")
    for row in rows["corner"]:
        for at in range(0, len(row), len(row) // 3):
            expect(struct.unpack_from("<Q", row, at)[0] < vertices, f"{path.name}: a corner has no vertex")
    return rows


def read_base(path):
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    counts = {}
    for line in data[:end].decode().splitlines():
        if line.startswith("element"):
            counts[line.split()[1]] = int(line.split()[2])
    n, m = counts["vertex"], counts["face"]
    position = list(struct.iter_unpack("<3f", data[end:end + 12 * n]))
    faces = list(struct.iter_unpack("<B3I", data[end + 12 * n:end + 12 * n + 13 * m]))
    expect(all(f[0] == 3 and max(f[1:]) < n for f in faces), f"{path.name}: bad face")
    return position, [f[1:] for f in faces]


def place(position, triangle, weights):
    return [sum(w * position[v][i] for w, v in zip(weights, triangle)) for i in range(3)]


def read_sphere(path, position, base, mapped):
    """Follows each vertex of map.bin to the sphere and compares with sphere.bin; all triangles turn one way."""
    said = json.loads((path / "sphere.json").read_bytes())
    expect(said["format"] == "remaps-sphere" and said["version"] == 1, "sphere.json: another format")
    data = (path / "sphere-base.bin").read_bytes()
    expect(len(data) == 24 * len(position), "sphere-base.bin: another size than 24 bytes a base vertex")
    corner = list(struct.iter_unpack("<3q", data))
    data = (path / "sphere.bin").read_bytes()
    expect(len(data) == 24 * len(mapped), "sphere.bin: another size than 24 bytes a vertex")

    def volume(a, b, c):  # six times, exactly: Python's integers are of any length
        return sum(a[i] * (b[(i + 1) % 3] * c[(i + 2) % 3] - b[(i + 2) % 3] * c[(i + 1) % 3]) for i in range(3))
    on_sphere = [volume(*(corner[v] for v in face)) > 0 for face in base]
    expect(sum(on_sphere) == sum(c["faces"] for c in said["components"]), "sphere-base.bin: faces that are turned over")
    found, worst = 0, 0.0
    for v, ((face, a, b), there) in enumerate(zip(mapped, struct.iter_unpack("<3d", data))):
        if face == NONE or not on_sphere[face]:
            expect(all(x != x for x in there), f"sphere.bin: vertex {v} is somewhere")
            continue
        here = place([tuple(x / 2**40 for x in c) for c in (corner[i] for i in base[face])], (0, 1, 2),
                     (1 - a - b, a, b))
        length = sum(x * x for x in here) ** 0.5
        worst = max(worst, max(abs(x / length - y) for x, y in zip(here, there)))
        found += 1
    expect(found == said["vertices"] and worst < 1e-12, f"sphere.bin: a vertex is {worst:.1e} from its direction")
    print(f"sphere    {found} vertices on {len(said['components'])} spheres: at most {worst:.1e} from their directions")


def read_bundle(path, wanted):
    manifest = json.loads((path / "manifest.json").read_bytes())
    expect(manifest["format"] == "remaps-bundle" and manifest["version"] == 2, "another format")
    given = manifest["input"]
    print(f"input     {given['name']}: {given['vertices']} vertices, {given['file_faces']} faces")

    position, base = read_base(path / "base.ply")
    print(f"base      {len(position)} vertices, {len(base)} faces")

    data = (path / "map.bin").read_bytes()
    expect(len(data) == 12 * given["vertices"], "map.bin: another size than 12 bytes a vertex")
    mapped = list(struct.iter_unpack("<Iff", data))
    for v, (face, a, b) in enumerate(mapped):
        expect(face == NONE or (face < len(base) and a >= 0 and b >= 0 and a + b <= 1 + 1e-6),
               f"map.bin: vertex {v} lies nowhere")
    without = sum(face == NONE for face, _, _ in mapped)
    copies = given["copied_vertices"]
    expect(len(mapped) - without + copies == given["referenced_vertices"], "map.bin: another count of vertices")
    print(f"map.bin   {len(mapped) - without} vertices on the base, {without} without a face")
    if (path / "sphere.json").exists():
        read_sphere(path, position, base, mapped)

    tiles = SectionFile(path / "tiles.bin", b"tile")
    own_ids, face_ids = [], []
    for i in range(len(tiles)):
        own, _, _, vertex_id, face_id = read_tile(tiles.section(i))
        own_ids += vertex_id[:own]
        face_ids += face_id
    for what, ids, count, end in (
            ("vertices", own_ids, given["vertices"] + copies - given["absent_vertices"], given["vertices"] + copies),
            ("faces", face_ids, given["faces"], given["file_faces"] + given["filled_faces"])):
        expect(len(ids) == len(set(ids)) == count and max(ids) < end, f"tiles: {what} are missing or doubled")
    print(f"tiles     {len(tiles)}: every vertex and face that repair left once, and {copies} copied vertices")

    if "attributes" in manifest:
        rows = read_attributes(path / "attributes.bin", manifest["attributes"], given["vertices"])
        print(f"carries   {', '.join(a['name'] for a in manifest['attributes']['list'])}: rows of "
              f"{len(rows['vertex'])} vertices, {len(rows['face'])} faces, corners of {len(rows['corner'])}")
    expect(("attributes" in manifest) == (path / "attributes.bin").exists(), "attributes.bin and manifest differ")

    points = []  # (segment, face, weights, vertex) on their way
    removed_in_all = 0
    worst, followed = 0.0, 0
    for level, entry in enumerate(manifest["levels"]):
        log = SectionFile(path / entry["log"], b"log1")
        expect(len(log) == 2 * entry["segments"], f"{log.name}: another number of segments")
        arriving, points = points, []
        records = 0
        for i in range(entry["segments"]):
            segment = Segment(log.section(2 * i), log.section(2 * i + 1), level)
            records += len(segment.record)
            stride = max(1, given["vertices"] // wanted)
            starts = [(f, w, 0, v) for s, f, w, v in arriving if s == i]
            for number, record in enumerate(segment.record):
                if (removed_in_all + number) % stride == 0:
                    weights = [0.0, 0.0, 0.0]
                    weights[record[3][0]] = 1.0
                    starts.append((record[4][0], weights, number, segment.removed[number]))
            removed_in_all += len(segment.record)
            for face, weights, first, vertex in starts:
                face, weights = segment.carry(face, weights, first)
                expect(face in segment.next, f"{log.name}: vertex {vertex} ends on a dropped face")
                points.append((*segment.next[face], weights, vertex))
        print(f"{entry['log']} {entry['segments']} segments, {records} records")
    for _, face, weights, vertex in points:
        if vertex >= given["vertices"]:
            continue  # a copy
        at, u, v = mapped[vertex]
        a, b = place(position, base[face], weights), place(position, base[at], (1 - u - v, u, v))
        distance = sum((x - y) ** 2 for x, y in zip(a, b)) ** 0.5 / given["bbox_diagonal"]
        expect(distance < 1e-6, f"vertex {vertex}: map.bin and log lie {distance:.1e} diagonals apart")
        worst, followed = max(worst, distance), followed + 1
    expect(removed_in_all + len(position) == given["referenced_vertices"],
           "removed and base vertices are not all")
    print(f"followed  {followed} vertices to the base: at most {worst:.1e} diagonals from map.bin")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bundle", type=pathlib.Path)
    parser.add_argument("--points", type=int, default=1000, help="vertices to follow, about")
    a = parser.parse_args()
    try:
        read_bundle(a.bundle, max(a.points, 1))
    except (Mismatch, OSError, struct.error, IndexError, KeyError, ValueError,
            subprocess.CalledProcessError) as error:
        sys.exit(f"read_bundle: {error}")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Decodes an archive, or the beginning of one, to a PLY.

    tools/decode_archive.py scan.remapsa scan.ply [--bytes N] [--level J]

Written from docs/formats/archive.md alone, and to be read, not for speed: it takes some 0.3 s a
thousand vertices. The XXH3 checksums are left to `remaps decode`. Signals are printed as text with
--signals FILE: a row a vertex.
"""

import argparse
import math
import pathlib
import struct
import sys

import dyadic_numbering

BLOCK = 4096
MASK = 0xFFFFFFFF
LOOP_UPDATE = 2.916, 2.537, 2.292, 2.168, 2.117, 2.104, 2.115, 2.134, 2.16, 2.192


class Ended(Exception):
    """A bit needs a byte that is not there."""


def make_tables():
    power, squash = 1.0, [0] * 4095
    for x in range(2048):
        for at, share in ((2047 + x, power / (1 + power)), (2047 - x, 1 / (1 + power))):
            squash[at] = int(min(max(share * 65536, 1.0), 65535.0))
        power *= 1.0039138893383475
    stretch, x = [], -2047
    for i in range(4096):
        while x < 2047 and squash[x + 2047] < 16 * i + 8:
            x += 1
        stretch.append(x)
    return squash, stretch


SQUASH, STRETCH = make_tables()


class BitDecoder:
    def __init__(self, code):
        self.code, self.at = code, 0
        self.low, self.high, self.value = 0, MASK, 0
        self.started = False

    def next(self):
        if self.at == len(self.code):
            raise Ended
        self.at += 1
        return self.code[self.at - 1]

    def bit(self, p):
        if not self.started:
            for _ in range(4):
                self.value = self.value << 8 | self.next()
            self.started = True
        while self.low >> 24 == self.high >> 24:
            self.low = self.low << 8 & MASK
            self.high = (self.high << 8 & MASK) | 255
            self.value = (self.value << 8 & MASK) | self.next()
        middle = self.low + ((self.high - self.low) * p >> 16)
        if self.value <= middle:
            self.high = middle
            return 1
        self.low = middle + 1
        return 0

    def even(self):
        return self.bit(32768)


class MixedBit:
    def __init__(self, decoder, inputs):
        self.decoder = decoder
        self.tables = [{} for _ in range(inputs)]
        self.sets = {}
        self.first = 65536 if inputs == 1 else 5 * 65536 // (4 * inputs)

    def decode(self, contexts, weights=0):
        w = self.sets.setdefault(weights, [self.first] * len(contexts))
        bits = [table.setdefault(c, [1 << 23, 0]) for table, c in zip(self.tables, contexts)]
        x = [STRETCH[b[0] >> 12] for b in bits]
        total = sum(a * b for a, b in zip(w, x)) >> 16
        p = SQUASH[min(max(total, -2047), 2047) + 2047]
        bit = self.decoder.bit(p)
        error = (65535 if bit else 0) - p
        for i, b in enumerate(bits):
            w[i] += (x[i] * error + 16384) >> 15
            s = (1 << 17) // (2 * b[1] + 3)
            if bit:
                b[0] += (0xFFFFFF - b[0]) * s >> 16
            else:
                b[0] -= b[0] * s >> 16
            b[1] = min(b[1] + 1, 120)
        return bit


class BaseDecoder:
    """Faces and cells of the base mesh."""

    def __init__(self, code, vertices, faces):
        d = BitDecoder(code)
        self.decoder = d
        self.exists, self.new = MixedBit(d, 1), MixedBit(d, 2)
        self.is_before, self.is_after = MixedBit(d, 1), MixedBit(d, 1)
        self.longer, self.digit = MixedBit(d, 1), MixedBit(d, 1)
        self.face, self.cell, self.degree, self.side = [], [], [], {}
        stack = []
        while len(self.face) < faces:
            if not stack:
                corners = [self.vertex(self.cell[-1] if self.cell else (0, 0, 0)) for _ in range(3)]
                stack += [(len(self.face), k) for k in (2, 1, 0)]
                self.add(tuple(corners))
                continue
            gate = stack.pop()
            a, b = self.ends(gate)
            if (b, a) in self.side:
                continue
            third = self.across(gate, a, b)
            if third is None:
                continue
            stack += [(len(self.face), k) for k in (2, 1)]
            self.add((b, a, third))
        if len(self.cell) != vertices:
            sys.exit("the base mesh has not the vertices that the header says")

    def ends(self, side):
        f, k = side
        return self.face[f][k], self.face[f][(k + 1) % 3]

    def add(self, face):
        for k in range(3):
            key = face[k], face[(k + 1) % 3]
            if key in self.side or key[0] == key[1]:
                sys.exit("the base mesh has two faces on one side")
            self.side[key] = len(self.face), k
            self.degree[face[k]] += 1
        self.face.append(face)

    def turn(self, side, step):
        """The open side that is reached from a side about one of its ends."""
        f, k = side
        while True:
            k = (k + step) % 3
            a, b = self.ends((f, k))
            if (b, a) not in self.side:
                return a, b
            f, k = self.side[b, a]

    def across(self, gate, a, b):
        at_a, at_b = min(self.degree[a], 11), min(self.degree[b], 11)
        before, after = self.turn(gate, 2)[0], self.turn(gate, 1)[1]
        if not self.exists.decode([(at_a, at_b)]):
            return None
        context = at_a, at_b, before == after
        if self.new.decode([context, min(at_a + at_b, 23)]):
            c = self.face[gate[0]][(gate[1] + 2) % 3]
            sums = (3 * (p + q) - 2 * r for p, q, r in zip(self.cell[a], self.cell[b], self.cell[c]))
            return self.vertex([s // 4 if s >= 0 else -(-s // 4) for s in sums])
        if self.is_before.decode([context]):
            return before
        if self.is_after.decode([context]):
            return after
        number = 0
        for _ in range(len(self.cell).bit_length()):
            number = number << 1 | self.decoder.even()
        return number

    def vertex(self, guess):
        self.cell.append(tuple(g + self.difference() for g in guess))
        self.degree.append(0)
        return len(self.cell) - 1

    def difference(self):
        n = 0
        while n < 31 and self.longer.decode([n]):
            n += 1
        if n == 0:
            return 0
        size = 1
        for i in range(n - 2, -1, -1):
            size = size << 1 | self.digit.decode([(n, min(n - 2 - i, 3))])
        return -size if self.decoder.even() else size


class Level:
    """vertices, face (corners), edge (of each side of each face), side (of each edge), twin."""

    def __init__(self, vertices, face, edge, side):
        self.vertices, self.face, self.edge, self.side = vertices, face, edge, side
        at = {(f[k], f[(k + 1) % 3]): (i, k) for i, f in enumerate(face) for k in range(3)}
        self.twin = [[at.get((f[(k + 1) % 3], f[k])) for k in range(3)] for f in face]

    def ends(self, s):
        return self.face[s[0]][s[1]], self.face[s[0]][(s[1] + 1) % 3]

    def opposite(self, s):
        return self.face[s[0]][(s[1] + 2) % 3]

    def twin_of(self, s):
        return self.twin[s[0]][s[1]]

    def vertex_on(self, s):
        return self.vertices + self.edge[s[0]][s[1]]

    def finer(self):
        halves = 2 * len(self.side)
        face, number = [], {}
        side = [None] * (halves + 3 * len(self.face))
        for f, corners in enumerate(self.face):
            ab, bc, ca = (self.vertices + e for e in self.edge[f])
            a, b, c = corners
            face += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (bc, ca, ab)]
            for k in range(3):
                side[halves + 3 * f + k] = 4 * f + 3, k
        for e, s in enumerate(self.side):  # child k has the start of side k, child k + 1 its end
            f, k = s
            side[2 * e], side[2 * e + 1] = (4 * f + k, k), (4 * f + (k + 1) % 3, k)
        for e, (f, k) in enumerate(side):
            number[frozenset((face[f][k], face[f][(k + 1) % 3]))] = e
        edge = [[number[frozenset((f[k], f[(k + 1) % 3]))] for k in range(3)] for f in face]
        return Level(self.vertices + len(self.side), face, edge, side)


def subdivide(vertices, faces, levels):
    number, edge, side = {}, [], []
    for f, corners in enumerate(faces):
        edge.append([])
        for k in range(3):
            key = frozenset((corners[k], corners[(k + 1) % 3]))
            if key not in number:
                number[key] = len(side)
                side.append((f, k))
            edge[-1].append(number[key])
    result = [Level(vertices, faces, edge, side)]
    for _ in range(levels):
        result.append(result[-1].finer())
    return result


class Details:
    """Magnitudes, signs, and lowest known planes of the coefficients of all vertices."""

    def __init__(self, levels, code, planes):
        self.levels, self.top = levels, len(levels) - 1
        n = levels[-1].vertices
        self.magnitude = [[0, 0, 0] for _ in range(n)]
        self.negative = [[0, 0, 0] for _ in range(n)]
        self.known = [[planes] * 3 for _ in range(n)]
        self.open = [[False, False] for _ in range(n)]
        self.decoder = BitDecoder(code)
        self.base, self.significance = MixedBit(self.decoder, 1), MixedBit(self.decoder, 4)
        self.tree, self.sign = MixedBit(self.decoder, 3), MixedBit(self.decoder, 2)
        self.refinement = MixedBit(self.decoder, 2)
        self.history = [0, 0]
        self.list = [[[], []] for _ in range(self.top + 1)]
        if self.top > 0:
            own = range(levels[0].vertices, levels[1].vertices)
            self.list[1] = [list(own), list(own)]
        try:
            for self.plane in range(planes - 1, -1, -1):
                self.decode_plane()
        except Ended:
            pass

    def decode_plane(self):
        for v in range(self.levels[0].vertices):
            for c in range(3):
                s = self.magnitude[v][c] >> self.plane
                bit = self.base.decode([(self.plane, min(s, 3))])
                if bit and s == 0:
                    self.negative[v][c] = self.decoder.even()
                self.take(v, c, bit)
        for m in range(1, self.top + 1):
            for g in range(2):
                for v in self.list[m][g]:
                    self.decode_vertex(v, m, g)

    def take(self, v, c, bit):
        self.magnitude[v][c] |= bit << self.plane
        self.known[v][c] = self.plane

    def seen(self, v, g):
        size = self.magnitude[v]
        return (size[0] if g == 0 else max(size[1], size[2])) >> self.plane

    def parent(self, v, m):
        level = self.levels[m - 2]
        e = v - self.levels[m - 1].vertices
        if e < 2 * len(level.side):
            return level.vertices + e // 2
        f, k = divmod(e - 2 * len(level.side), 3)
        return level.vertices + level.edge[f][k]

    def children(self, v, m):
        level, first = self.levels[m - 1], self.levels[m].vertices
        e = v - level.vertices
        inner = first + 2 * len(level.side)
        sides = [s for s in (level.side[e], level.twin_of(level.side[e])) if s]
        return [first + 2 * e, first + 2 * e + 1] + [inner + 3 * f + k for f, k in sides]

    def decode_vertex(self, v, m, g):
        level = self.levels[m - 1]
        side = level.side[v - level.vertices]
        twin = level.twin_of(side)
        near = [level.vertex_on((side[0], (side[1] + d) % 3)) for d in (1, 2)]
        near += [level.vertex_on((twin[0], (twin[1] + d) % 3)) for d in (1, 2)] if twin else near
        n = [self.seen(u, g) for u in near]
        total = sum(min(x, 8) for x in n)
        around = total if total < 3 else 3 if total <= 4 else 4 if total <= 8 else 5
        parent = self.parent(v, m) if m > 1 else None
        p = self.seen(parent, g) if m > 1 else 0
        p4 = p if p < 2 else 2 if p < 4 else 3
        grand = self.seen(self.parent(parent, m - 1), g) if m > 2 else 0
        other = self.seen(v, 1 - g)
        face = side[0] >> 2 * (m - 1)
        for c in (0,) if g == 0 else (1, 2):
            s = self.magnitude[v][c] >> self.plane
            if s:
                bit = self.refinement.decode(
                    [(m, g, around), (min(s // 2, 3), min(p, 3), min(max(n), 3), g)], g)
                self.take(v, c, bit)
                continue
            sibling = 0 if g == 0 else (min(self.magnitude[v][3 - c] >> self.plane, 1), c)
            bit = self.significance.decode(
                [(m, g, p4, sibling, around), (m, g) + tuple(min(x, 3) for x in n),
                 (face, g, min(m - 1, 3)), (self.history[g], min(other, 3), min(grand, 3))], (m, g))
            self.history[g] = (self.history[g] << 1 | bit) & 255
            if bit:
                signs = sum(self.sign_of(u, c) for u in near)
                d = 0 if signs == 0 else 1 if signs < 0 else 2
                q = (0, 2, 1)[self.sign_of(parent, c)] if m > 1 else 0
                self.negative[v][c] = self.sign.decode([(d, q, g), (m, d, q)], g)
            self.take(v, c, bit)
        if m == self.top or self.open[v][g]:
            return
        s = min(self.seen(v, g), 3)
        marks = sum(self.open[u][g] for u in near)
        if self.tree.decode([(m, g, s, min(p, 3), around), (m, g, s, marks, p4, other != 0),
                             (face, g, s)], (m, g)):
            self.open[v][g] = True
            self.list[m + 1][g] += self.children(v, m)

    def sign_of(self, v, c):
        return 0 if self.magnitude[v][c] == 0 else -1 if self.negative[v][c] else 1

    def values(self, vertices, step, ratio, tangential):
        result = []
        m, level_step = 0, step
        for v in range(vertices):
            while v >= self.levels[m].vertices:
                m += 1
                level_step = step * (ratio / 64) ** (m - 1)
            value = []
            for c in range(3):
                size = level_step if m == 0 or c == 0 else level_step * 256 / tangential
                x = self.magnitude[v][c]
                x = (x + 2 ** self.known[v][c] / 2) * size if x else 0.0
                value.append(-x if self.negative[v][c] else x)
            result.append(tuple(value))
        return result


def add(*terms):
    """Σ weight · vector over pairs."""
    return tuple(sum(w * x[i] for w, x in terms) for i in range(3))


def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def to_global(level, e, x):
    side = level.side[e]
    twin = level.twin_of(side)
    a, b = level.ends(side)
    u = add((1, x[b]), (-1, x[a]))
    n = cross(u, add((1, x[level.opposite(side)]), (-1, x[level.opposite(twin)] if twin else x[a])))
    u2, n2 = sum(t * t for t in u), sum(t * t for t in n)
    detail = x[level.vertices + e]
    if not n2 > 1e-12 * u2 * u2:
        return detail
    along = tuple(t / math.sqrt(u2) for t in u)
    normal = tuple(t / math.sqrt(n2) for t in n)
    return add((detail[0], normal), (detail[1], along), (detail[2], cross(normal, along)))


class Synthesis:
    def __init__(self, levels, kind):
        self.levels, self.kind = levels, kind
        base = levels[0]
        self.valence = [0] * base.vertices
        for s in base.side:
            for v in base.ends(s):
                self.valence[v] += 1
        self.boundary = set()
        for level in levels:
            for s in level.side:
                if not level.twin_of(s):
                    self.boundary.update(level.ends(s))

    def rule(self, v):
        """update, mean, keep, share"""
        edge = v in self.boundary
        n = self.valence[v] if v < len(self.valence) else 4 if edge else 6
        if self.kind == 1:
            return 0.75 / (n - 1 if edge else n), 0, 1, 0
        if edge:
            return 0.437, 0.28, 0.5, 0.25
        w = 0.625 - (0.375 + 0.25 * math.cos(2 * math.pi / n)) ** 2
        return LOOP_UPDATE[min(n, 12) - 3] / n, 0.9 / n, 1 - 1.6 * w, 1.6 * w / n

    def step(self, j, x):
        """From the values of level j and the details of level j + 1 to the values of level j + 1."""
        level = self.levels[j]
        new = level.vertices
        rules = [self.rule(v) for v in range(new)] if self.kind > 0 else []
        if self.kind == 1:
            for e, s in enumerate(level.side):
                half = 1 if level.twin_of(s) else 0.5
                for v in level.ends(s):
                    x[v] = add((1, x[v]), (-half * rules[v][0], x[new + e]))
        if self.kind == 2:
            self.mix(level, rules, x)
            x[:new] = [add((1, x[v]), (-1, f)) for v, f in enumerate(self.fit(level, rules, x))]
        for e, s in enumerate(level.side):
            x[new + e] = add((1, x[new + e]), (1, self.predict(level, s, x)))
        if self.kind == 2:
            x[:new] = self.smooth(level, rules, x[:new], x[new:])

    def own_ends(self, level, s):
        return [v for v in level.ends(s) if not level.twin_of(s) or v not in self.boundary]

    def own_opposite(self, level, s):
        if not level.twin_of(s):
            return []
        return [v for v in (level.opposite(s), level.opposite(level.twin_of(s))) if v not in self.boundary]

    def mix(self, level, rules, x):
        new = level.vertices
        mean = [(0, 0, 0)] * new
        for e, s in enumerate(level.side):
            for v in self.own_ends(level, s):
                mean[v] = add((1, mean[v]), (rules[v][1], x[new + e]))
        for e, s in enumerate(level.side):
            x[new + e] = add((0.7, x[new + e]), *((1, mean[v]) for v in self.own_ends(level, s)))

    def smooth(self, level, rules, even, odd):
        even = [add((r[2], v)) for r, v in zip(rules, even)]
        for s, y in zip(level.side, odd):
            for v in self.own_ends(level, s):
                even[v] = add((1, even[v]), (rules[v][3], y))
        return even

    def fit(self, level, rules, x):
        detail = x[level.vertices:level.vertices + len(level.side)]
        f = [(0, 0, 0)] * level.vertices
        for s, d in zip(level.side, detail):
            for v in self.own_ends(level, s):
                f[v] = add((1, f[v]), (rules[v][0], d))
            for v in self.own_opposite(level, s):
                f[v] = add((1, f[v]), (-0.54 * rules[v][0], d))
        move, rho, middle, half = [(0, 0, 0)] * level.vertices, 0, 2.225, 1.975
        for i in range(4):
            odd = [add((1, d), (-1, self.predict(level, s, f))) for s, d in zip(level.side, detail)]
            even = self.smooth(level, rules, [add((-1, v)) for v in f], odd)
            rest = [add((r[2], v)) for r, v in zip(rules, even)]
            for s, o in zip(level.side, odd):
                q = add((1, o), *((rules[v][3], even[v]) for v in self.own_ends(level, s)))
                for v in self.own_ends(level, s):
                    rest[v] = add((1, rest[v]), (3 / 8 if level.twin_of(s) else 1 / 2, q))
                for v in self.own_opposite(level, s):
                    rest[v] = add((1, rest[v]), (1 / 8, q))
            sigma = 1 / (2 * middle / half - rho) if i else half / middle
            move = [add((sigma * rho, m), ((2 if i else 1) * sigma / half, r)) for m, r in zip(move, rest)]
            f = [add((1, v), (1, m)) for v, m in zip(f, move)]
            rho = sigma
        return f

    def predict(self, level, s, x):
        twin = level.twin_of(s)
        a, b = level.ends(s)
        if self.kind == 2:
            if not twin:
                return add((0.5, x[a]), (0.5, x[b]))
            return add((0.375, x[a]), (0.375, x[b]), (0.125, x[level.opposite(s)]),
                       (0.125, x[level.opposite(twin)]))
        if not twin:
            before, after = (s[0], (s[1] + 2) % 3), (s[0], (s[1] + 1) % 3)
            while level.twin_of(before):
                f, k = level.twin_of(before)
                before = f, (k + 2) % 3
            while level.twin_of(after):
                f, k = level.twin_of(after)
                after = f, (k + 1) % 3
            return add((9 / 16, x[a]), (9 / 16, x[b]), (-1 / 16, x[level.ends(before)[0]]),
                       (-1 / 16, x[level.ends(after)[1]]))
        rings = [self.ring(level, t, x) for t, v in ((s, a), (twin, b)) if self.extraordinary(v)]
        if rings:
            return add(*((1 / len(rings), r) for r in rings))
        terms = [(0.5, x[a]), (0.5, x[b])]
        for f, k in (s, twin):
            terms.append((0.125, x[level.opposite((f, k))]))
            for outer in ((f, (k + 1) % 3), (f, (k + 2) % 3)):
                beyond = level.twin_of(outer)
                p, q = level.ends(outer)
                wing = (x[level.opposite(beyond)] if beyond else
                        add((1, x[p]), (1, x[q]), (-1, x[level.opposite(outer)])))
                terms.append((-1 / 16, wing))
        return add(*terms)

    def extraordinary(self, v):
        return v < len(self.valence) and v not in self.boundary and self.valence[v] != 6

    def ring(self, level, s, x):
        centre = level.ends(s)[0]
        n = self.valence[centre]
        terms = [(0.75, x[centre])]
        for i in range(n):
            turn = 2 * math.pi * i / n
            if n == 3:
                w = (5 / 12, -1 / 12, -1 / 12)[i]
            elif n == 4:
                w = (3 / 8, 0, -1 / 8, 0)[i]
            else:
                w = (0.25 + math.cos(turn) + 0.5 * math.cos(2 * turn)) / n
            terms.append((w, x[level.ends(s)[1]]))
            s = level.twin_of((s[0], (s[1] + 2) % 3))
        return add(*terms)


def in_blocks(size):
    return size + 4 * ((size + BLOCK - 1) // BLOCK)


def code_of_blocks(data, at, size):
    """As much of a code as is there."""
    code = b""
    while len(code) < size and at < len(data):
        part = min(BLOCK, size - len(code))
        code += data[at:at + part]
        at += part + 4
    return code


class Archive:
    """base_faces, position, signals: a list of kind, values."""

    def __init__(self, data, level=None):
        if data[:8] != b"remapsGA" or len(data) < 72:
            sys.exit("not an archive")
        (version, kind, self.levels, planes, ratio, tangential, shift, _, *origin, step, vertices, faces,
         base_bytes, geometry_bytes, signal_bytes) = struct.unpack("<8B4d5I", data[8:68])
        if version != 1:
            sys.exit(f"version {version}, not 1")
        least = 72 + base_bytes + 4
        if len(data) < least:
            sys.exit(f"{len(data)} bytes, but header and base take {least}")
        self.level = self.levels if level is None else min(level, self.levels)
        base = BaseDecoder(data[72:72 + base_bytes], vertices, faces)
        self.base_faces = base.face
        levels = subdivide(vertices, base.face, self.levels)
        self.faces = levels[self.level].face
        count = levels[self.level].vertices
        synthesis = Synthesis(levels, kind)
        details = Details(levels, code_of_blocks(data, least, geometry_bytes), planes)
        x = details.values(count, step, ratio, tangential)
        cell = step * 2 ** shift
        for v, c in enumerate(base.cell):
            x[v] = tuple(o + (i + 0.5) * cell + d for o, i, d in zip(origin, c, x[v]))
        for j in range(self.level):
            for e in range(len(levels[j].side)):
                x[levels[j].vertices + e] = to_global(levels[j], e, x)
            synthesis.step(j, x)
        self.position, self.signals = x, []
        at = least + in_blocks(geometry_bytes)
        end = at + signal_bytes
        while at < end and at + 20 <= len(data):
            signal, planes, ratio, tangential, step, size = struct.unpack("<4BdI", data[at:at + 16])
            details = Details(levels, code_of_blocks(data, at + 20, size), planes)
            x = details.values(count, step, ratio, tangential)
            for j in range(self.level):
                synthesis.step(j, x)
            self.signals.append((signal, [to_colour(v) if signal == 1 else to_unit(v) for v in x]))
            at += 20 + in_blocks(size)

    def in_file_order(self):
        """For each vertex of docs/formats/semi-regular.md its number here, and the faces there."""
        _, faces, count = dyadic_numbering.number_faces(self.base_faces, self.level)
        here = [None] * count
        for there, own in zip(faces, self.faces):
            for k in range(3):
                if here[there[k]] not in (None, own[k]):
                    sys.exit("the numberings do not agree")
                here[there[k]] = own[k]
        return here, faces


def to_colour(v):
    middle = v[0] + 0.5 - v[2] / 2
    blue = middle - v[1] / 2
    return tuple(min(max(t, 0.0), 1.0) for t in (blue + v[1], v[2] + middle, blue))


def to_unit(v):
    length = math.sqrt(sum(t * t for t in v))
    return tuple(t / length for t in v) if length > 0 else v


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("archive")
    parser.add_argument("output")
    parser.add_argument("--bytes", type=int)
    parser.add_argument("--level", type=int)
    parser.add_argument("--signals", help="file for the values of signals, as text")
    a = parser.parse_args()
    archive = Archive(pathlib.Path(a.archive).read_bytes()[:a.bytes], a.level)
    here, faces = archive.in_file_order()
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(here)}\n" +
              "".join(f"property float {c}\n" for c in "xyz") +
              f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    rows = [struct.pack("<3f", *archive.position[v]) for v in here]
    rows += [struct.pack("<B3i", 3, *f) for f in faces]
    pathlib.Path(a.output).write_bytes(header.encode() + b"".join(rows))
    if a.signals:
        lines = [" ".join(f"{t:.9g}" for _, values in archive.signals for t in values[v]) for v in here]
        pathlib.Path(a.signals).write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()

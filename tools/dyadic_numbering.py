#!/usr/bin/env python3
"""Says how the vertices and faces of a semi-regular mesh are numbered, from its base alone.

    tools/dyadic_numbering.py scan.remaps/base.ply 5 remesh.ply   # check a mesh; silent if it fits
    tools/dyadic_numbering.py --faces "0,1,2 2,1,3" 2             # print the numbers of a small base

Written from docs/formats/semi-regular.md alone, by sorting instead of arithmetic.
"""

import argparse
import pathlib
import struct
import sys


def read_ply(path):
    """Vertex positions and triangles of a PLY as remaps writes it."""
    data = pathlib.Path(path).read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    counts = {}
    for line in data[:end].decode().splitlines():
        if line.startswith("element"):
            counts[line.split()[1]] = int(line.split()[2])
    n, m = counts["vertex"], counts["face"]
    position = list(struct.iter_unpack("<3f", data[end:end + 12 * n]))
    return position, [f[1:] for f in struct.iter_unpack("<B3i", data[end + 12 * n:end + 12 * n + 13 * m])]


def number_points(faces, level):
    """A dictionary a base face: (i, j) -> vertex number."""
    n = 1 << level

    def new_at(m):  # the level that first has a point at m / n
        return next(l for l in range(level + 1) if m % (n >> l) == 0)

    numbers = [{} for _ in faces]
    count = 1 + max(v for face in faces for v in face)
    edges = {}
    for face in faces:
        for k in range(3):
            edges.setdefault(frozenset((face[k], face[(k + 1) % 3])), None)
    for edge in edges:  # in order of first appearance
        steps = sorted(range(1, n), key=lambda m: (new_at(m), m))
        edges[edge] = {m: count + at for at, m in enumerate(steps)}
        count += len(steps)
    for number, face in zip(numbers, faces):
        corner = ((0, 0), (n, 0), (0, n))
        for k in range(3):
            number[corner[k]] = face[k]
            a, b = face[k], face[(k + 1) % 3]
            (ai, aj), (bi, bj) = corner[k], corner[(k + 1) % 3]
            for m in range(1, n):
                point = ai + (bi - ai) * m // n, aj + (bj - aj) * m // n
                number[point] = edges[frozenset((a, b))][m if a < b else n - m]
        inner = [(i, j) for j in range(1, n) for i in range(1, n - j)]
        inner.sort(key=lambda p: (max(new_at(p[0]), new_at(p[1])), p[1], p[0]))
        for point in inner:
            number[point] = count
            count += 1
    return numbers, count


def children(a, b, c, level):
    """The corners of the small faces of one base face, in order."""
    if level == 0:
        yield a, b, c
        return
    ab, bc, ca = (((p[0] + q[0]) // 2, (p[1] + q[1]) // 2) for p, q in ((a, b), (b, c), (c, a)))
    for triangle in (a, ab, ca), (ab, b, bc), (ca, bc, c), (bc, ca, ab):
        yield from children(*triangle, level - 1)


def number_faces(faces, level):
    n = 1 << level
    numbers, vertices = number_points(faces, level)
    result = [tuple(number[p] for p in triangle) for number in numbers
              for triangle in children((0, 0), (n, 0), (0, n), level)]
    return numbers, result, vertices


def show(faces, level):
    numbers, triangles, vertices = number_faces(faces, level)
    n = 1 << level
    print(f"{vertices} vertices, {len(triangles)} faces")
    for f, number in enumerate(numbers):
        print(f"\nbase face {f}: vertices {faces[f]}; rows of j from {n} down to 0, i from 0")
        for j in range(n, -1, -1):
            print("  " + "  " * j + "".join(f"{number[i, j]:4}" for i in range(n - j + 1)))
        each = 4 ** level
        print("  faces " + " ".join(f"{k}:{triangles[k]}".replace(" ", "") for k in range(f * each, (f + 1) * each)))


def check(base, level, mesh):
    base_position, faces = read_ply(base)
    position, found = read_ply(mesh)
    numbers, triangles, vertices = number_faces(faces, level)
    if len(position) != vertices or len(found) != len(triangles):
        sys.exit(f"{mesh}: {len(position)} vertices and {len(found)} faces, not {vertices} and {len(triangles)}")
    for f, (got, wanted) in enumerate(zip(found, triangles)):
        if got != wanted:
            sys.exit(f"{mesh}: face {f} is {got}, not {wanted}")
    if position[:len(base_position)] != base_position:
        sys.exit(f"{mesh}: does not start with the base vertices")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("base", nargs="?", help="base.ply of a bundle")
    parser.add_argument("level", type=int)
    parser.add_argument("mesh", nargs="?", help="PLY to check, not fitted")
    parser.add_argument("--faces", help="base faces instead of base.ply, as in the example")
    a = parser.parse_args()
    if a.faces:
        show([tuple(map(int, face.split(","))) for face in a.faces.split()], a.level)
    elif a.base and a.mesh:
        check(a.base, a.level, a.mesh)
    else:
        parser.error("a base and a mesh, or --faces")


if __name__ == "__main__":
    main()

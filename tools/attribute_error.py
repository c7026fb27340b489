#!/usr/bin/python3
"""How well an attribute of a mesh is carried to its remesh.

Each vertex of the remesh is compared with the nearest vertex of the input, and with the nearest point of the
input's surface, where the attribute is interpolated; each vertex of the input with the nearest of the
remesh. The controls know nothing of what was carried: they compare the input with itself, its surface at the
places of the remesh's vertices, and at as many points spread evenly, with its nearest vertices. Both are PLY files of remaps or alike: binary little-endian, a vertex before its faces, triangles.
Needs numpy and scipy (Debian: python3-numpy, python3-scipy).
"""

import argparse
import pathlib
import sys

import numpy
from scipy.spatial import cKDTree

TYPES = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "<i2", "int16": "<i2",
         "ushort": "<u2", "uint16": "<u2", "int": "<i4", "int32": "<i4", "uint": "<u4", "uint32": "<u4",
         "float": "<f4", "float32": "<f4", "double": "<f8", "float64": "<f8"}


def read_ply(path):
    """Vertices as a structured array, and triangles; faces may have one list only."""
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    elements = []
    for line in data[:end].decode().splitlines():
        words = line.split()
        if words[0] == "format" and words[1] != "binary_little_endian":
            sys.exit(f"{path}: expected binary_little_endian, found {words[1]}")
        if words[0] == "element":
            elements.append((words[1], int(words[2]), []))
        if words[0] == "property" and words[1] == "list":
            elements[-1][2].extend([("count", TYPES[words[2]]), ("corner", TYPES[words[3]], 3)])
        elif words[0] == "property":
            elements[-1][2].append((words[2], TYPES[words[1]]))
    found = {}
    for name, count, fields in elements:
        found[name] = numpy.frombuffer(data, numpy.dtype(fields), count, end)
        end += found[name].nbytes
    if numpy.any(found["face"]["count"] != 3):
        sys.exit(f"{path}: expected triangles")
    return found["vertex"], found["face"]["corner"].astype(numpy.int64)


def columns(vertices, names, path):
    for name in names:
        if name not in vertices.dtype.names:
            sys.exit(f"{path}: has no property '{name}', there are {', '.join(vertices.dtype.names)}")
    return numpy.stack([vertices[name].astype(float) for name in names], axis=1)


def closest_weights(p, a, b, c):
    """Weights of the closest points of triangles (Ericson, Real-Time Collision Detection, 5.1.5)."""
    ab, ac = b - a, c - a

    def dots(x):
        return (ab * x).sum(1), (ac * x).sum(1)
    (d1, d2), (d3, d4), (d5, d6) = dots(p - a), dots(p - b), dots(p - c)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    with numpy.errstate(all="ignore"):
        total = va + vb + vc
        weight = numpy.stack([va / total, vb / total, vc / total], axis=1)
        on_bc = (va <= 0) & (d4 - d3 >= 0) & (d5 - d6 >= 0)
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        weight[on_bc] = numpy.stack([0 * t, 1 - t, t], axis=1)[on_bc]
        on_ac = (vb <= 0) & (d2 >= 0) & (d6 <= 0)
        t = d2 / (d2 - d6)
        weight[on_ac] = numpy.stack([1 - t, 0 * t, t], axis=1)[on_ac]
        on_ab = (vc <= 0) & (d1 >= 0) & (d3 <= 0)
        t = d1 / (d1 - d3)
        weight[on_ab] = numpy.stack([1 - t, t, 0 * t], axis=1)[on_ab]
    weight[(d6 >= 0) & (d5 <= d6)] = [0, 0, 1]
    weight[(d3 >= 0) & (d4 <= d3)] = [0, 1, 0]
    weight[(d1 <= 0) & (d2 <= 0)] = [1, 0, 0]
    return weight


def on_surface(points, position, value, triangle, tree, candidates=6):
    """The attribute at the closest points of the surface, looked for on faces of the nearest vertices."""
    order = numpy.argsort(triangle.ravel(), kind="stable")
    face_of = order // 3
    first = numpy.searchsorted(triangle.ravel()[order], numpy.arange(len(position) + 1))
    most = int((first[1:] - first[:-1]).max())
    best = numpy.full(len(points), numpy.inf)
    result = numpy.zeros((len(points), value.shape[1]))
    _, near = tree.query(points, k=candidates)
    for k in range(candidates):
        for turn in range(most):
            at = first[near[:, k]] + turn
            rows = numpy.flatnonzero(at < first[near[:, k] + 1])
            t = triangle[face_of[at[rows]]]
            corners = [position[t[:, i]] for i in range(3)]
            weight = closest_weights(points[rows], *corners)
            place = sum(weight[:, i:i + 1] * corners[i] for i in range(3))
            distance = numpy.linalg.norm(place - points[rows], axis=1)
            better = distance < best[rows]
            best[rows[better]] = distance[better]
            found = sum(weight[:, i:i + 1] * value[t[:, i]] for i in range(3))
            result[rows[better]] = found[better]
    return result


def spread(count, position, value, triangle):
    """Points spread evenly over the surface, and the attribute there."""
    a, b, c = (position[triangle[:, i]] for i in range(3))
    area = numpy.linalg.norm(numpy.cross(b - a, c - a), axis=1)
    random = numpy.random.default_rng(1)
    t = triangle[random.choice(len(triangle), count, p=area / area.sum())]
    u, v = random.random((2, count, 1))
    turned = u + v > 1
    u, v = numpy.where(turned, 1 - u, u), numpy.where(turned, 1 - v, v)
    return [(1 - u - v) * x[t[:, 0]] + u * x[t[:, 1]] + v * x[t[:, 2]] for x in (position, value)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("original", type=pathlib.Path)
    parser.add_argument("remesh", type=pathlib.Path)
    parser.add_argument("--properties", default="red,green,blue", help="of the vertices, separated by commas")
    a = parser.parse_args()
    names = a.properties.split(",")
    original, triangle = read_ply(a.original)
    remesh, _ = read_ply(a.remesh)
    p, q = (columns(m, ["x", "y", "z"], a.original) for m in (original, remesh))
    value, carried = columns(original, names, a.original), columns(remesh, names, a.remesh)
    tree = cKDTree(p)

    def tell(what, difference):
        difference = numpy.abs(difference)
        print(f"{what:<42} mean {difference.mean():.4f}   rms {numpy.sqrt((difference ** 2).mean()):.4f}   "
              f"max {difference.max():.1f}")
    tell("remesh to the nearest vertex of the input", carried - value[tree.query(q)[1]])
    surface = on_surface(q, p, value, triangle, tree)
    tell("remesh to the nearest point of the input", carried - surface)
    tell("input to the nearest vertex of the remesh", value - carried[cKDTree(q).query(p)[1]])
    points, there = spread(len(q), p, value, triangle)
    tell("control: input to its vertices, there", surface - value[tree.query(q)[1]])
    tell("control: input to its vertices, evenly", there - value[tree.query(points)[1]])


if __name__ == "__main__":
    main()

"""Counts the topology of a triangle mesh with numpy: what tools/survey.py holds outputs against.

It shares no code and no method with the library, which counts on a stream: here everything follows
from one sorted array of half-edges. Half-edge 3 f + i goes from corner i of face f to the next one, and
also stands for that corner.
"""

import dataclasses

import numpy


@dataclasses.dataclass
class Topology:
    vertices: int = 0  # with a face
    faces: int = 0
    unreferenced: int = 0  # vertices without a face
    edges: int = 0
    components: int = 0
    boundary_loops: int = 0
    # What makes the mesh no oriented manifold, in words; the counts above mean little then.
    defects: list = dataclasses.field(default_factory=list)

    @property
    def euler_characteristic(self):
        return self.vertices - self.edges + self.faces


def read_ply(path):
    """Positions (n, 3) and triangles (m, 3) of a PLY as remaps writes it.

    Raises ValueError when it is another kind of PLY, or has more or fewer bytes than it announces.
    """
    data = path.read_bytes()
    mark = b"end_header\n"
    end = data.find(mark)
    if not data.startswith(b"ply\nformat binary_little_endian 1.0\n") or end < 0:
        raise ValueError("not a binary little-endian PLY")
    header = data[:end].decode("ascii", "replace").splitlines()
    elements = [line.split() for line in header if line.startswith("element ")]
    properties = [line.split()[1:] for line in header if line.startswith("property ")]
    if [e[1] for e in elements] != ["vertex", "face"] or len(properties) != 4 or [
            p[:1] for p in properties[:3]] != [["float"]] * 3 or properties[3][:2] != ["list", "uchar"]:
        raise ValueError("not a PLY of float positions and triangles")
    vertices, faces = (int(e[2]) for e in elements)
    index = {"int": "<i4", "uint": "<u4", "uint64": "<u8"}[properties[3][2]]
    face = numpy.dtype([("corners", "u1"), ("corner", index, 3)])
    start = end + len(mark)
    if len(data) != start + 12 * vertices + face.itemsize * faces:
        raise ValueError(f"{len(data)} bytes, but the header announces "
                         f"{start + 12 * vertices + face.itemsize * faces}")
    positions = numpy.frombuffer(data, "<f4", 3 * vertices, start).reshape(-1, 3)
    records = numpy.frombuffer(data, face, faces, start + 12 * vertices)
    if (records["corners"] != 3).any():
        raise ValueError("a face has not three corners")
    return positions, records["corner"].astype(numpy.int64)


def count_cycles(following):
    """Number of cycles of a permutation; every element learns the least of its cycle by doubling."""
    least = numpy.arange(len(following))
    jump = following
    for _ in range(max(1, int(len(following)).bit_length())):
        least = numpy.minimum(least, least[jump])
        jump = jump[jump]
    return int((least == numpy.arange(len(following))).sum())


def count_components(start, end, vertices):
    """Connected components of the vertices that these edges join, those without an edge left out."""
    parent = numpy.arange(vertices)
    while True:
        a, b = parent[start], parent[end]
        apart = a != b
        if not apart.any():
            break
        # Always from the higher root to the lower one, so no circle can arise; any of several will do.
        parent[numpy.maximum(a, b)[apart]] = numpy.minimum(a, b)[apart]
        while True:
            grand = parent[parent]
            if (grand == parent).all():
                break
            parent = grand
    return len(numpy.unique(parent[start]))


def count_fans(start, twin, vertices):
    """The number of fans of faces at each vertex: 1 where the surface is a manifold."""
    corner = numpy.arange(len(start))
    previous = corner - corner % 3 + (corner + 2) % 3
    following = twin[previous]  # the next corner around the vertex; -1 at a boundary
    at_end = following < 0
    fans = numpy.bincount(start[at_end], minlength=vertices)
    least = corner.copy()
    jump = numpy.where(at_end, corner, following)
    rounds = int(numpy.bincount(start, minlength=1).max()).bit_length() if len(start) else 0
    for _ in range(rounds):
        least = numpy.minimum(least, least[jump])
        jump = jump[jump]
    closed = ~at_end[jump]
    return fans + numpy.bincount(start[closed & (least == corner)], minlength=vertices)


def count_topology(triangles, vertices):
    """Counts (m, 3) triangles of `vertices` vertices. Raises ValueError for an index out of range."""
    corners = numpy.asarray(triangles, dtype=numpy.int64).reshape(-1, 3)
    if corners.size and (corners.min() < 0 or corners.max() >= vertices):
        raise ValueError("a face names a vertex that does not exist")
    start = corners.ravel()
    end = numpy.roll(corners, -1, axis=1).ravel()
    result = Topology(faces=len(corners))

    def defect(number, what):
        if number:
            result.defects.append(f"{int(number)} {what}")

    defect((corners == numpy.roll(corners, 1, axis=1)).any(axis=1).sum(), "faces name a vertex twice")
    key = numpy.minimum(start, end) * vertices + numpy.maximum(start, end)
    order = numpy.argsort(key, kind="stable")
    new = numpy.ones(len(key), dtype=bool)
    new[1:] = key[order][1:] != key[order][:-1]
    first = numpy.flatnonzero(new)
    faces_at = numpy.diff(numpy.append(first, len(key)))
    result.edges = len(first)
    defect((faces_at > 2).sum(), "edges of more than two faces")

    pair = first[faces_at == 2]
    one, other = order[pair], order[pair + 1]
    opposed = start[one] != start[other]
    defect((~opposed).sum(), "edges between faces of opposite orientation")
    twin = numpy.full(len(key), -1, dtype=numpy.int64)
    twin[one[opposed]] = other[opposed]
    twin[other[opposed]] = one[opposed]

    fans = count_fans(start, twin, vertices)
    result.vertices = int((fans > 0).sum())
    result.unreferenced = vertices - result.vertices
    result.components = count_components(start, end, vertices)
    if not result.defects:
        defect((fans > 1).sum(), "vertices where fans touch")
    if not result.defects:
        boundary = order[first[faces_at == 1]]
        leaving = numpy.full(vertices, -1, dtype=numpy.int64)
        leaving[start[boundary]] = numpy.arange(len(boundary))
        result.boundary_loops = count_cycles(leaving[end[boundary]]) if len(boundary) else 0
    return result

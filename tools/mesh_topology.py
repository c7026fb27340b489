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
    records = {"vertex": [], "face": []}
    counts = {}
    element = None
    for line in data[:end].decode("ascii", "replace").splitlines():
        words = line.split()
        if words[:1] == ["element"]:
            element = words[1]
            counts[element] = int(words[2])
        elif words[:1] == ["property"] and element in records:
            records[element] += fields_of(words[1:])
    if list(counts) != ["vertex", "face"] or [f[:2] for f in records["vertex"][:3]] != [
            (axis, "<f4") for axis in "xyz"] or ("vertex_indices_count", "u1") not in records["face"]:
        raise ValueError("not a PLY of float positions and triangles")
    vertex, face = (numpy.dtype(records[name]) for name in ("vertex", "face"))
    start = end + len(mark)
    announced = start + vertex.itemsize * counts["vertex"] + face.itemsize * counts["face"]
    if len(data) != announced:
        raise ValueError(f"{len(data)} bytes, but the header announces {announced}")
    points = numpy.frombuffer(data, vertex, counts["vertex"], start)
    faces = numpy.frombuffer(data, face, counts["face"], start + vertex.itemsize * counts["vertex"])
    if (faces["vertex_indices_count"] != 3).any():
        raise ValueError("a face has not three corners")
    positions = numpy.stack([points[axis] for axis in "xyz"], axis=1)
    return positions, faces["vertex_indices"].astype(numpy.int64)


TYPES = {"char": "i1", "uchar": "u1", "short": "<i2", "ushort": "<u2", "int": "<i4", "uint": "<u4", "int64": "<i8",
         "uint64": "<u8", "float": "<f4", "double": "<f8"}
LENGTHS = {"vertex_indices": 3, "texcoord": 6}  # of the lists that remaps writes


def fields_of(words):
    """A property's fields in a record: a value, or the count of a list and its values."""
    if words[0] != "list":
        return [(words[1], TYPES[words[0]])]
    if words[3] not in LENGTHS:
        raise ValueError(f"not a PLY as remaps writes it: a list {words[3]}")
    return [(words[3] + "_count", TYPES[words[1]]), (words[3], TYPES[words[2]], LENGTHS[words[3]])]


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

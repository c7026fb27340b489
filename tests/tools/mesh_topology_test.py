"""Checks the counter in tools/mesh_topology.py on surfaces whose topology is known."""

import pathlib
import struct
import sys
import tempfile
import unittest

try:
    import numpy
except ImportError:
    print("skipped: this Python has no numpy")
    sys.exit(77)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
import mesh_topology  # noqa: E402

TETRAHEDRON = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]


def torus(n, m):
    """An n x m torus of 2 n m faces."""
    faces = []
    for i in range(n):
        for j in range(m):
            a, b = i * m + j, (i + 1) % n * m + j
            c, d = (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m
            faces += [(a, b, c), (a, c, d)]
    return faces


def shifted(faces, by):
    return [tuple(v + by for v in face) for face in faces]


def count(faces, vertices=None):
    found = mesh_topology.count_topology(faces, 1 + max(map(max, faces)) if vertices is None else vertices)
    return found


class CountTopology(unittest.TestCase):
    def expect(self, found, vertices, edges, faces, components, loops):
        self.assertEqual(found.defects, [])
        self.assertEqual((found.vertices, found.edges, found.faces), (vertices, edges, faces))
        self.assertEqual((found.components, found.boundary_loops), (components, loops))
        self.assertEqual(found.euler_characteristic, vertices - edges + faces)

    def test_counts_a_sphere(self):
        self.expect(count(TETRAHEDRON), 4, 6, 4, 1, 0)

    def test_counts_a_torus(self):
        self.expect(count(torus(7, 5)), 35, 105, 70, 1, 0)

    def test_counts_loops_of_a_torus_with_holes_apart(self):
        faces = torus(9, 8)
        # The faces at vertices 0 and 36, whose stars are apart: two holes of six edges.
        left = [f for f in faces if 0 not in f and 36 not in f]
        found = count(left)
        self.expect(found, 70, 3 * 72 - 12, 144 - 12, 1, 2)
        self.assertEqual(found.unreferenced, 2)

    def test_counts_a_disc_of_one_face(self):
        self.expect(count([(0, 1, 2)]), 3, 3, 1, 1, 1)

    def test_counts_components_whatever_the_order_of_their_vertices(self):
        generator = numpy.random.default_rng(5)
        faces = []
        for k in range(40):
            faces += shifted(torus(5, 4), 20 * k)
        places = generator.permutation(800)
        mixed = places[numpy.array(faces)][generator.permutation(len(faces))]
        self.expect(count(mixed.tolist()), 800, 2400, 1600, 40, 0)

    def test_counts_a_long_strip_as_one_component(self):
        faces = [(i, i + 1, i + 2) if i % 2 == 0 else (i + 1, i, i + 2) for i in range(5000)]
        self.expect(count(faces), 5002, 10001, 5000, 1, 1)

    def test_counts_vertices_without_a_face(self):
        self.assertEqual(count(TETRAHEDRON, 9).unreferenced, 5)

    def test_counts_an_empty_mesh(self):
        self.expect(mesh_topology.count_topology([], 0), 0, 0, 0, 0, 0)

    def test_sees_an_edge_of_three_faces(self):
        self.assertEqual(count([(0, 1, 2), (1, 0, 3), (0, 1, 4)]).defects, ["1 edges of more than two faces"])

    def test_sees_a_face_turned_round(self):
        self.assertEqual(count([(0, 1, 2), (0, 1, 3)]).defects,
                         ["1 edges between faces of opposite orientation"])

    def test_sees_a_moebius_strip(self):
        faces = [(i, (i + 1) % 7, (i + 2) % 7) if i % 2 == 0 else ((i + 1) % 7, i, (i + 2) % 7)
                 for i in range(7)]
        self.assertTrue(count(faces).defects)

    def test_sees_closed_fans_that_touch(self):
        other = [tuple(v if v == 0 else v + 3 for v in face) for face in TETRAHEDRON]
        self.assertEqual(count(TETRAHEDRON + other).defects, ["1 vertices where fans touch"])

    def test_sees_open_fans_that_touch(self):
        self.assertEqual(count([(0, 1, 2), (0, 3, 4)]).defects, ["1 vertices where fans touch"])

    def test_sees_a_vertex_twice_in_a_face(self):
        self.assertIn("1 faces name a vertex twice", count(TETRAHEDRON + [(0, 0, 1)]).defects)

    def test_refuses_an_index_out_of_range(self):
        with self.assertRaises(ValueError):
            count(TETRAHEDRON, 3)


class ReadPly(unittest.TestCase):
    HEADER = ("ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n"
              "property float y\nproperty float z\nelement face {}\n"
              "property list uchar int vertex_indices\nend_header\n")

    def read(self, data):
        with tempfile.TemporaryDirectory() as directory:
            path = pathlib.Path(directory) / "mesh.ply"
            path.write_bytes(data)
            return mesh_topology.read_ply(path)

    def mesh(self, vertices=4, faces=4):
        data = self.HEADER.format(vertices, faces).encode()
        data += struct.pack("<12f", *range(12))
        return data + b"".join(struct.pack("<B3i", 3, *face) for face in TETRAHEDRON)

    def test_reads_what_it_should(self):
        positions, triangles = self.read(self.mesh())
        self.assertEqual(positions[1].tolist(), [3, 4, 5])
        self.assertEqual([tuple(t) for t in triangles.tolist()], TETRAHEDRON)

    def test_refuses_bytes_too_many_or_too_few(self):
        for data in (self.mesh()[:-1], self.mesh() + b"x", self.mesh(faces=5)):
            with self.assertRaises(ValueError):
                self.read(data)

    def test_refuses_text(self):
        with self.assertRaises(ValueError):
            self.read(self.mesh().replace(b"binary_little_endian", b"ascii"))


if __name__ == "__main__":
    unittest.main()

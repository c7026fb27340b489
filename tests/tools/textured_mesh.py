"""A torus that carries everything: colours, normals, a scalar, labels of faces, and texture coordinates with seams."""

import math

AROUND, ACROSS = 48, 24


def point(i, k):
    a, b = 2 * math.pi * i / AROUND, 2 * math.pi * k / ACROSS
    out = (math.cos(a) * math.cos(b), math.sin(a) * math.cos(b), math.sin(b))
    ring = (3 * math.cos(a), 3 * math.sin(a), 0)
    return [r + n for r, n in zip(ring, out)], out


def colour_of(position):
    """Linear in the position, so that interpolation does not change it but for rounding."""
    return [127.5 + 30 * x for x in position]


def write_textured_mesh(path):
    lines = ["ply", "format ascii 1.0", f"element vertex {AROUND * ACROSS}"]
    lines += [f"property float {name}" for name in ("x", "y", "z", "nx", "ny", "nz")]
    lines += [f"property uchar {name}" for name in ("red", "green", "blue")] + ["property float height"]
    lines += [f"element face {2 * AROUND * ACROSS}", "property list uchar int vertex_indices",
              "property list uchar float texcoord", "property int part", "end_header"]
    for i in range(AROUND):
        for k in range(ACROSS):
            p, n = point(i, k)
            lines.append(" ".join([f"{x:.9g}" for x in p + list(n)] + [str(round(c)) for c in colour_of(p)] +
                                  [f"{p[2]:.9g}"]))
    for i in range(AROUND):
        for k in range(ACROSS):
            for corners in (((0, 0), (1, 0), (1, 1)), ((0, 0), (1, 1), (0, 1))):
                at = [(i + a) % AROUND * ACROSS + (k + b) % ACROSS for a, b in corners]
                uv = [x for a, b in corners for x in ((i + a) / AROUND, (k + b) / ACROSS)]
                lines.append(" ".join(map(str, [3, *at, 6, *uv, i % 5])))
    path.write_text("\n".join(lines) + "\n")

#!/usr/bin/python3
"""How much nearer to the input's normals a normal map is than the geometry image that it is put on.

    tools/normal_map_error.py scan.remaps...

Each argument is a bundle with a map to the sphere. At 3 x 3 points in each pixel of a normal map the normal of
the input's face is looked up, and compared with the map, bilinear and at the nearest pixel, and with the 257 x 257
geometry image as a mesh, with the normals of its faces and with smooth ones (area-weighted at vertices, interpolated).
Printed are mean angles over the area of the mesh, in degrees. Needs numpy.
"""

import argparse
import pathlib
import subprocess
import tempfile

import numpy

GEOMETRY, POINTS = 257, 3


def unit(vectors):
    length = numpy.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / numpy.where(length > 0, length, 1)


def image(remaps, bundle, kind, size, supersampling, directory):
    path = directory / "image.npy"
    subprocess.run([remaps, "image", bundle, path, "--kind", kind, "--size", str(size), "--supersampling",
                    str(supersampling), "--no-measure", "--memory", "2G", "--quiet"], check=True)
    return numpy.load(path).astype(float)


def bilinear(pixels, x, y):
    """Pixels at places in units of pixels, (0, 0) the middle of the first; clamped at the sides."""
    last = len(pixels) - 1
    x, y = numpy.clip(x, 0, last), numpy.clip(y, 0, last)
    i, j = (numpy.minimum(numpy.floor(t).astype(int), last - 1) for t in (y, x))
    s, t = (y - i)[..., None], (x - j)[..., None]
    return ((1 - s) * ((1 - t) * pixels[i, j] + t * pixels[i, j + 1]) +
            s * ((1 - t) * pixels[i + 1, j] + t * pixels[i + 1, j + 1]))


class Mesh:
    """A geometry image with its cells cut along their shorter diagonals."""

    def __init__(self, p):
        self.a, self.b, self.c, self.d = p[1:, :-1], p[1:, 1:], p[:-1, 1:], p[:-1, :-1]
        along = ((self.a - self.c)**2).sum(-1) <= ((self.b - self.d)**2).sum(-1)
        self.along = along
        # Of each cell the lower and the upper triangle, as normals of twice their area.
        self.lower = numpy.where(along[..., None], numpy.cross(self.b - self.a, self.c - self.a),
                                 numpy.cross(self.b - self.a, self.d - self.a))
        self.upper = numpy.where(along[..., None], numpy.cross(self.c - self.a, self.d - self.a),
                                 numpy.cross(self.c - self.b, self.d - self.b))
        self.area = 0.5 * (numpy.linalg.norm(self.lower, axis=-1) + numpy.linalg.norm(self.upper, axis=-1))
        both, smooth = self.lower + self.upper, numpy.zeros_like(p)
        for rows in (slice(1, None), slice(None, -1)):
            for columns in (slice(1, None), slice(None, -1)):
                smooth[rows, columns] += both
        # Across the sides, which fold at their middles.
        for side in (smooth[0], smooth[-1], smooth[:, 0], smooth[:, -1]):
            side[:] = side + side[::-1]
        self.smooth = unit(smooth)

    def at(self, x, y):
        """Flat and smooth normals, and areas of cells, at places in units of cells."""
        last = len(self.area) - 1
        i, j = (numpy.clip(numpy.floor(t).astype(int), 0, last) for t in (y, x))
        s, t = y - i, x - j
        below = numpy.where(self.along[i, j], s > 1 - t, s > t)  # below the diagonal from a to c, or from d to b
        # a is at the lower left: rows run downwards.
        flat = numpy.where(below[..., None], self.lower[i, j], self.upper[i, j])
        return unit(flat), unit(bilinear(self.smooth, x, y)), self.area[i, j]


def mean_angle(a, b, weight):
    angle = numpy.degrees(numpy.arccos(numpy.clip((a * b).sum(-1), -1, 1)))
    return float((angle * weight).sum() / weight.sum())


def measure(remaps, bundle, size):
    with tempfile.TemporaryDirectory() as name:
        directory = pathlib.Path(name)
        truth = unit(image(remaps, bundle, "normal", size * POINTS, 1, directory))
        normal = image(remaps, bundle, "normal", size, 4, directory)
        mesh = Mesh(image(remaps, bundle, "geometry", GEOMETRY, 1, directory))
    place = (numpy.arange(size * POINTS) + 0.5) / (size * POINTS)
    x, y = numpy.meshgrid(place, place)
    flat, smooth, weight = mesh.at(x * (GEOMETRY - 1), y * (GEOMETRY - 1))
    nearest = normal[(y * size).astype(int), (x * size).astype(int)]
    mapped = unit(bilinear(normal, x * size - 0.5, y * size - 0.5))
    return [mean_angle(truth, other, weight) for other in (unit(nearest), mapped, flat, smooth)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bundles", nargs="+", type=pathlib.Path)
    parser.add_argument("--remaps", default="build/release/cli/remaps", help="the binary")
    parser.add_argument("--size", type=int, default=512, help="pixels along a side of the map (512)")
    parsed = parser.parse_args()
    print("| bundle | map, nearest | map, bilinear | mesh, flat | mesh, smooth | bilinear / flat | bilinear / smooth |")
    print("|---|---|---|---|---|---|---|")
    for bundle in parsed.bundles:
        nearest, mapped, flat, smooth = measure(parsed.remaps, bundle, parsed.size)
        print(f"| {bundle.stem} | {nearest:.2f} | {mapped:.2f} | {flat:.2f} | {smooth:.2f} | {mapped / flat:.2f} | "
              f"{mapped / smooth:.2f} |", flush=True)


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""The relief of the Earth as a closed mesh: ETOPO5 (NOAA, public domain) from Debian's ferret-datasets.

    bench/make_earth.py /usr/share/ferret-vis/data/etopo5.cdf earth.ply --stride 4

Heights are exaggerated 20 times, as they would hardly show. Every STRIDE-th sample of both directions
makes a vertex, and each pole one: 9.3, 2.3 and 0.58 million vertices for strides 1, 2 and 4. Lengths
are kilometres. Needs numpy and scipy, hence Debian's own interpreter.
"""

import argparse

import numpy
from scipy.io import netcdf_file

EARTH_RADIUS_M = 6_371_000.0
EXAGGERATION = 20.0

HEADER = """\
ply
format binary_little_endian 1.0
comment ETOPO5 relief times %g (NOAA), from Debian's ferret-datasets
element vertex %d
property float x
property float y
property float z
element face %d
property list uchar int vertex_indices
end_header
"""


def read_relief(path):
    """Heights in metres (rows from south to north), latitudes and longitudes in degrees."""
    with netcdf_file(path, "r", mmap=False) as file:
        relief = file.variables["ROSE"]
        latitudes, longitudes = (file.variables[name][:].astype(float) for name in relief.dimensions)
        heights = numpy.asarray(relief[:], numpy.float32)
    if longitudes[-1] - longitudes[0] >= 360 - 1e-6:  # the first meridian is there twice
        heights, longitudes = heights[:, :-1], longitudes[:-1]
    if abs(latitudes[0] + 90) > 1e-6 or abs(latitudes[-1] - 90) > 1e-6:
        raise SystemExit(f"make_earth: {path}: expected rows from pole to pole")
    return heights, latitudes, longitudes


def radius_km(height_m):
    return (EARTH_RADIUS_M + EXAGGERATION * height_m) / 1000


def make_positions(heights, latitudes, longitudes, south, north):
    """(rows x columns + 2, 3): the grid row by row, then the poles."""
    latitude, longitude = numpy.radians(latitudes)[:, None], numpy.radians(longitudes)[None, :]
    radius = radius_km(heights)
    positions = numpy.empty((heights.size + 2, 3), "<f4")
    positions[:-2, 0] = (radius * numpy.cos(latitude) * numpy.cos(longitude)).ravel()
    positions[:-2, 1] = (radius * numpy.cos(latitude) * numpy.sin(longitude)).ravel()
    positions[:-2, 2] = (radius * numpy.sin(latitude)).ravel()
    positions[-2] = (0, 0, -radius_km(south))
    positions[-1] = (0, 0, radius_km(north))
    return positions


def make_faces(rows, columns):
    """Two triangles a cell of the grid, and a fan at each pole."""
    here = numpy.arange(rows * columns, dtype=numpy.int32).reshape(rows, columns)
    east = numpy.roll(here, -1, axis=1)
    a, b, c, d = here[:-1], east[:-1], east[1:], here[1:]
    south, north = (numpy.full(columns, rows * columns + pole) for pole in (0, 1))
    parts = [(a, b, c), (a, c, d), (south, east[0], here[0]), (north, here[-1], east[-1])]
    return numpy.concatenate([numpy.stack(part, axis=-1).reshape(-1, 3) for part in parts]).astype("<i4")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("relief", help="etopo5.cdf")
    parser.add_argument("output", help="the PLY to write")
    parser.add_argument("--stride", type=int, default=1, help="take every so many-th sample")
    arguments = parser.parse_args()

    heights, latitudes, longitudes = read_relief(arguments.relief)
    south, north = heights[0].mean(), heights[-1].mean()
    rows, columns = slice(1, -1, arguments.stride), slice(None, None, arguments.stride)
    heights, latitudes, longitudes = heights[rows, columns], latitudes[rows], longitudes[columns]

    positions = make_positions(heights, latitudes, longitudes, south, north)
    faces = make_faces(*heights.shape)
    records = numpy.empty(len(faces), dtype=[("corners", "u1"), ("vertices", "<i4", 3)])
    records["corners"], records["vertices"] = 3, faces
    with open(arguments.output, "wb") as file:
        file.write((HEADER % (EXAGGERATION, len(positions), len(faces))).encode())
        positions.tofile(file)
        records.tofile(file)


if __name__ == "__main__":
    main()

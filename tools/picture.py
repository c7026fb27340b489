#!/usr/bin/python3
"""Draws a scan, its base mesh and its remesh side by side, with a colour for each base face.

    tools/picture.py data/koala.ply docs/images/koala.png --remaps build/release/cli/remaps

Needs numpy. Draws in software: orthographic, with a depth buffer, shaded, a few samples a pixel.
"""

import argparse
import pathlib
import struct
import subprocess
import tempfile
import zlib

import numpy as np

SAMPLES = 3  # along each side of a pixel
CLAY = (0.80, 0.77, 0.73)
PALETTE = np.array([(0.93, 0.55, 0.42), (0.98, 0.80, 0.45), (0.56, 0.76, 0.55), (0.42, 0.70, 0.78),
                    (0.55, 0.58, 0.82), (0.82, 0.58, 0.76), (0.86, 0.86, 0.80), (0.70, 0.60, 0.50)])
LINE = np.array((0.16, 0.15, 0.18))


def read_ply(path):
    """Vertices (n, 3) and triangles (m, 3) of a little-endian PLY of floats and triangles."""
    data = pathlib.Path(path).read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    counts = {}
    for line in data[:end].decode().splitlines():
        words = line.split()
        if words[0] == "element":
            counts[words[1]] = int(words[2])
    n, m = counts["vertex"], counts["face"]
    vertices = np.frombuffer(data, "<f4", 3 * n, end).reshape(n, 3).astype(float)
    faces = np.frombuffer(data, [("n", "u1"), ("v", "<i4", 3)], m, end + 12 * n)
    assert (faces["n"] == 3).all(), f"{path}: not triangles"
    return vertices, faces["v"].astype(np.int64)


def write_png(path, image):
    """image: (h, w, 3) bytes."""
    h, w, _ = image.shape
    # Filter "up" compresses smooth pictures well.
    before = np.vstack([np.zeros((1, w, 3), np.uint8), image[:-1]])
    rows = np.hstack([np.full((h, 1), 2, np.uint8), (image - before).reshape(h, 3 * w)])

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    pathlib.Path(path).write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", w, h, 8, 2, 0, 0, 0)) +
        chunk(b"IDAT", zlib.compress(rows.tobytes(), 9)) + chunk(b"IEND", b""))


def view_matrix(azimuth, elevation, up):
    """Rows: right, up, towards the eye. Angles in degrees."""
    a, e = np.radians(azimuth), np.radians(elevation)
    toward = np.array([np.sin(a) * np.cos(e), -np.cos(a) * np.cos(e), np.sin(e)])
    right = np.array([np.cos(a), np.sin(a), 0.0])
    m = np.array([right, np.cross(toward, right), toward])
    turn = {"z": np.eye(3), "y": np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0.0]])}[up]
    return m @ turn


def rasterize(screen, faces, width, height):
    """The nearest face and its corner weights at each pixel: (h * w) ids, -1 for none, and (h * w, 3)."""
    depth = np.full(width * height, -np.inf)
    nearest = np.full(width * height, -1)
    weights = np.zeros((width * height, 3))
    corner = screen[faces]
    low = np.floor(corner[:, :, :2].min(1)).astype(int)
    size = np.ceil(corner[:, :, :2].max(1)).astype(int) - low
    level = np.ceil(np.log2(np.maximum(size.max(1), 1))).astype(int)
    for k in np.unique(level):
        side = 1 << k
        dy, dx = np.divmod(np.arange(side * side), side)
        ids = np.flatnonzero(level == k)
        step = max(1, (1 << 21) // (side * side))
        for first in range(0, len(ids), step):
            f = ids[first:first + step]
            a, b, c = (corner[f, i, None, :] for i in range(3))
            x = low[f, 0, None] + dx
            y = low[f, 1, None] + dy
            area = (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])
            px, py = x + 0.5, y + 0.5
            w1 = ((px - a[..., 0]) * (c[..., 1] - a[..., 1]) - (py - a[..., 1]) * (c[..., 0] - a[..., 0]))
            w2 = ((b[..., 0] - a[..., 0]) * (py - a[..., 1]) - (b[..., 1] - a[..., 1]) * (px - a[..., 0]))
            with np.errstate(divide="ignore", invalid="ignore"):
                w1, w2 = w1 / area, w2 / area
                w0 = 1 - w1 - w2
            inside = (w0 >= 0) & (w1 >= 0) & (w2 >= 0) & (x >= 0) & (x < width) & (y >= 0) & (y < height)
            row, cell = np.nonzero(inside)
            w = np.stack([w0[row, cell], w1[row, cell], w2[row, cell]], 1)
            z = (w * corner[f[row], :, 2]).sum(1)
            pixel = y[row, cell] * width + x[row, cell]
            order = np.argsort(z, kind="stable")
            order = order[z[order] > depth[pixel[order]]]
            depth[pixel[order]] = z[order]
            nearest[pixel[order]] = f[row[order]]
            weights[pixel[order]] = w[order]
    return nearest, weights, depth


def blurred(image, radius):
    """Gaussian blur by the FFT."""
    fy = np.fft.fftfreq(image.shape[0])[:, None]
    fx = np.fft.rfftfreq(image.shape[1])[None, :]
    kernel = np.exp(-2 * (np.pi * radius) ** 2 * (fx * fx + fy * fy))
    return np.fft.irfft2(np.fft.rfft2(image) * kernel, image.shape)


def differs(ids, reach):
    """True where a pixel within `reach` to the right or below has another id."""
    result = np.zeros(ids.shape, bool)
    for d in range(1, reach + 1):
        result[:, :-d] |= ids[:, :-d] != ids[:, d:]
        result[:-d] |= ids[:-d] != ids[d:]
    return result


def colour_patches(faces):
    """A palette index for each face: those with a common vertex differ where possible."""
    at_vertex = {}
    for f, triangle in enumerate(faces):
        for v in triangle:
            at_vertex.setdefault(v, []).append(f)
    colour = np.full(len(faces), -1)
    used = np.zeros(len(PALETTE), int)
    for f, triangle in enumerate(faces):
        near = [colour[g] for v in triangle for g in at_vertex[v] if colour[g] >= 0]
        count = np.bincount(near, minlength=len(PALETTE)) * 1000 + used
        colour[f] = count.argmin()
        used[colour[f]] += 1
    return colour


def draw(mesh, transform, width, height, face_colour, smooth, lines):
    """One panel. lines: (ids a face, reach in samples, strength)."""
    vertices, faces = mesh
    width, height = SAMPLES * width, SAMPLES * height
    rotation, scale, centre = transform
    seen = (vertices - centre) @ rotation.T * (scale * SAMPLES)
    screen = np.stack([width / 2 + seen[:, 0], height / 2 - seen[:, 1], seen[:, 2]], 1)
    nearest, weights, depth = rasterize(screen, faces, width, height)
    hit = nearest >= 0

    edge1, edge2 = seen[faces[:, 1]] - seen[faces[:, 0]], seen[faces[:, 2]] - seen[faces[:, 0]]
    face_normal = np.cross(edge1, edge2)
    if smooth:
        normal = np.zeros_like(seen)
        for i in range(3):
            np.add.at(normal, faces[:, i], face_normal)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
        n = (weights[hit, :, None] * normal[faces[nearest[hit]]]).sum(1)
    else:
        n = face_normal[nearest[hit]]
    n /= np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-30)

    key = np.array([-0.45, 0.65, 0.62]) / np.linalg.norm([-0.45, 0.65, 0.62])
    rim = np.array([0.8, 0.1, 0.2]) / np.linalg.norm([0.8, 0.1, 0.2])
    half = (key + [0, 0, 1]) / np.linalg.norm(key + [0, 0, 1])
    light = 0.47 + 0.12 * n[:, 1] + 0.55 * np.maximum(n @ key, 0) + 0.12 * np.maximum(n @ rim, 0)
    shine = 0.10 * np.maximum(n @ half, 0) ** 24

    # Depth darkening [Luft, Colditz, Deussen 2006]: what lies before brighter things is darker around.
    filled = np.where(hit, depth, depth[hit].min()).reshape(height, width)
    shade = np.zeros(height * width)
    for radius in (0.008 * height, 0.03 * height):
        gap = (blurred(filled, radius) - filled).ravel()
        shade += np.clip(gap / (0.06 * height), 0, 1)
    light *= 1 - 0.40 * np.clip(shade[hit], 0, 1)

    image = np.ones((height * width, 3))
    image[hit] = np.clip(face_colour[nearest[hit]] * light[:, None] + shine[:, None], 0, 1)
    image = image.reshape(height, width, 3)
    inner = hit.reshape(height, width)
    for ids, reach, strength in lines:
        on_line = differs(np.where(hit, ids[nearest], -1).reshape(height, width), reach) & inner
        image[on_line] += strength * (LINE - image[on_line])
    return image.reshape(height // SAMPLES, SAMPLES, width // SAMPLES, SAMPLES, 3).mean((1, 3))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("input", help="PLY, binary, floats, triangles")
    parser.add_argument("output", help="PNG to write")
    parser.add_argument("--remaps", default="build/release/cli/remaps", help="the binary")
    parser.add_argument("--level", type=int, default=5)
    parser.add_argument("--panel", type=int, nargs=2, default=(440, 356), help="pixels of each of three")
    parser.add_argument("--azimuth", type=float, default=40)
    parser.add_argument("--elevation", type=float, default=12)
    parser.add_argument("--up", choices="yz", default="y")
    a = parser.parse_args()
    with tempfile.TemporaryDirectory() as directory:
        remesh, bundle = f"{directory}/remesh.ply", f"{directory}/bundle"
        subprocess.run([a.remaps, "remesh", a.input, remesh, "--bundle", bundle, "--level",
                        str(a.level), "--no-measure", "--quiet"], check=True)
        scan, base, fine = read_ply(a.input), read_ply(f"{bundle}/base.ply"), read_ply(remesh)

    width, height = a.panel
    rotation = view_matrix(a.azimuth, a.elevation, a.up)
    turned = scan[0] @ rotation.T
    low, high = turned.min(0), turned.max(0)
    scale = 0.96 * min(width / (high - low)[0], height / (high - low)[1])
    transform = rotation, scale, (low + high) / 2 @ rotation

    patch = PALETTE[colour_patches(base[1])]
    base_face = np.arange(len(fine[1])) >> 2 * a.level
    cell = np.arange(len(fine[1])) >> 2 * max(a.level - 3, 0)
    clay = np.tile(CLAY, (len(scan[1]), 1))
    panels = [
        draw(scan, transform, width, height, clay, True, []),
        draw(base, transform, width, height, patch, False, [(np.arange(len(base[1])), 3, 0.75)]),
        draw(fine, transform, width, height, patch[base_face], True,
             [(cell, 1, 0.33), (base_face, 3, 0.75)]),
    ]
    write_png(a.output, np.rint(255 * np.hstack(panels)).astype(np.uint8))


if __name__ == "__main__":
    main()

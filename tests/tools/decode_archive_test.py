#!/usr/bin/env python3
"""Makes archives with the binary, and decodes them and beginnings of them with the decoder in tools/, which
shares no code with it: docs/formats/archive.md, from which it was written, says what an archive is.

Arguments: the binary, a mesh.
"""

import math
import pathlib
import struct
import subprocess
import sys
import tempfile

TOOLS = pathlib.Path(__file__).resolve().parents[2] / "tools"
FLOAT = 2.0 ** -23


def run(*command):
    done = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} ended with exit code {done.returncode}:\n{done.stdout}")
    return done.stdout


def write_open_mesh(path):
    """A coloured wavy annulus: two boundary loops."""
    around, across = 60, 25
    lines = ["ply", "format ascii 1.0", f"element vertex {around * across}"]
    lines += [f"property float {c}" for c in "xyz"] + [f"property uchar {c}" for c in ("red", "green", "blue")]
    lines += [f"element face {2 * around * (across - 1)}", "property list uchar int vertex_indices", "end_header"]
    for i in range(around):
        for j in range(across):
            t, r = 2 * math.pi * i / around, 2 + 0.1 * j
            z = 0.2 * math.sin(3 * t) + 0.1 * math.cos(2 * r)
            lines.append(f"{r * math.cos(t)} {r * math.sin(t)} {z} {4 * i} {10 * j} {200 - 3 * i}")
    for i in range(around):
        for j in range(across - 1):
            a, b, c, d = ((i + x) % around * across + j + y for x, y in ((0, 0), (0, 1), (1, 1), (1, 0)))
            lines += [f"3 {a} {c} {b}", f"3 {a} {d} {c}"]
    path.write_text("\n".join(lines) + "\n")


def read_mesh(path):
    """Positions, colours and faces of a PLY of remaps."""
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    lines = data[:end].decode().splitlines()
    n, m = (int(line.split()[2]) for line in lines if line.startswith("element"))
    row = struct.Struct("<3f3B" if "property uchar red" in lines else "<3f")
    rows = list(row.iter_unpack(data[end:end + n * row.size]))
    at = end + n * row.size
    return [r[:3] for r in rows], [r[3:] for r in rows], data[at:at + 13 * m]


def compare(remaps, archive, options, directory):
    a, b, text = directory / "a.ply", directory / "b.ply", directory / "signals.txt"
    run(remaps, "decode", archive, a, "--quiet", *options)
    run(sys.executable, TOOLS / "decode_archive.py", archive, b, "--signals", text, *options)
    position, colour, faces = read_mesh(a)
    other, _, other_faces = read_mesh(b)
    what = f"{archive.name} {' '.join(map(str, options))}"
    if faces != other_faces:
        sys.exit(f"{what}: the faces differ")
    size = max(abs(t) for p in position for t in p)
    worst = max(abs(s - t) for p, q in zip(position, other) for s, t in zip(p, q))
    if worst > 2 * FLOAT * size:
        sys.exit(f"{what}: positions differ by {worst}")
    if colour[0]:
        rows = [tuple(map(float, line.split())) for line in text.read_text().splitlines()]
        worst = max(abs(s - 255 * t) for p, q in zip(colour, rows) for s, t in zip(p, q))
        if not worst <= 0.5 + 1e-4:
            sys.exit(f"{what}: colours differ by {worst} of 255")
    print(f"{what}: {len(position)} vertices, {'with colours, ' if colour[0] else ''}the same")
    return bool(colour[0])


def main():
    remaps, mesh = sys.argv[1:]
    with tempfile.TemporaryDirectory() as name:
        directory = pathlib.Path(name)
        write_open_mesh(directory / "open.ply")
        for source, path, vertices in (("closed", mesh, 30), ("open", directory / "open.ply", 12)):
            bundle = directory / f"{source}.remaps"
            run(remaps, "parameterize", path, bundle, "--base-vertices", vertices, "--quiet")
            for wavelet in ("butterfly", "butterfly-lifted", "loop"):
                archive = directory / f"{source}.{wavelet}"
                run(remaps, "encode", bundle, archive, "--level", 3, "--wavelet", wavelet, "--no-measure", "--quiet")
                data = archive.read_bytes()
                least = 72 + struct.unpack("<I", data[56:60])[0] + 4
                coloured = compare(remaps, archive, (), directory)
                if coloured != (source == "open"):
                    sys.exit(f"{archive.name}: colours are not where they should be")
                for size in (least, least + 3, least + 4, least + 37, (least + len(data)) // 2, len(data) - 1):
                    compare(remaps, archive, ("--bytes", size), directory)
                compare(remaps, archive, ("--level", 1), directory)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Makes a bundle and a mesh with the binary, and reads both with the readers in tools/, which share no
code with it: docs/formats, from which they were written, says what the binary writes.

Arguments: the binary, a mesh.
"""

import math
import pathlib
import subprocess
import sys
import tempfile

TOOLS = pathlib.Path(__file__).resolve().parents[2] / "tools"


def run(*command):
    done = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} ended with exit code {done.returncode}:\n{done.stdout}")
    return done.stdout


def write_torus(path):
    """A mesh that carries something for vertices, faces and corners."""
    m, n = 40, 20
    lines = ["ply", "format ascii 1.0", f"element vertex {m * n}"]
    lines += [f"property float {c}" for c in "xyz"] + [f"property uchar {c}" for c in ("red", "green", "blue")]
    lines += [f"element face {2 * m * n}", "property list uchar int vertex_indices",
              "property list uchar float texcoord", "property short part", "end_header"]
    for i in range(m):
        for j in range(n):
            a, b = 2 * math.pi * i / m, 2 * math.pi * j / n
            r = 3 + math.cos(b) + 0.1 * math.sin(5 * a)
            lines.append(f"{r * math.cos(a)} {r * math.sin(a)} {math.sin(b)} {i} {j} 255")
    for i in range(m):
        for j in range(n):
            a, b, c, d = ((i + x) % m * n + (j + y) % n for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)))
            lines.append(f"3 {a} {b} {c} 6 {i} {j} {i + 1} {j} {i + 1} {j + 1} {i - 20}")
            lines.append(f"3 {a} {c} {d} 6 {i} {j} {i + 1} {j + 1} {i} {j + 1} {i - 20}")
    path.write_text("\n".join(lines) + "\n")


def dirty_mesh(directory):
    """A grid whose middle is a fin of three faces, with a face twice and one turned."""
    side = 30
    lines = [f"v {x} {y} {(x * x + y * y) / 50}" for y in range(side) for x in range(side)]
    at = lambda x, y: y * side + x + 1
    for y in range(side - 1):
        for x in range(side - 1):
            lines += [f"f {at(x, y)} {at(x + 1, y)} {at(x + 1, y + 1)}", f"f {at(x, y)} {at(x + 1, y + 1)} {at(x, y + 1)}"]
    lines += ["v 15 15 40", f"f {at(15, 15)} {at(16, 15)} {side * side + 1}", lines[side * side + 7]]
    corners = lines[side * side + 300].split()
    lines[side * side + 300] = " ".join(["f", corners[2], corners[1], corners[3]])
    path = directory / "dirty.obj"
    path.write_text("\n".join(lines) + "\n")
    return path


def main():
    remaps, mesh = sys.argv[1:]
    with tempfile.TemporaryDirectory() as name:
        directory = pathlib.Path(name)
        for buffer, mesh in (("0", mesh), ("5000", mesh), ("1000", dirty_mesh(directory))):
            bundle, output = directory / f"{buffer}.remaps", directory / f"{buffer}.ply"
            run(remaps, "remesh", mesh, output, "--bundle", bundle, "--level", 3, "--domain-buffer", buffer,
                "--no-measure", "--quiet")
            print(run(sys.executable, TOOLS / "read_bundle.py", bundle, "--points", 500))
            run(sys.executable, TOOLS / "dyadic_numbering.py", bundle / "base.ply", 3, output)
            whole = (bundle / "map.bin").read_bytes()
            (bundle / "map.bin").write_bytes(whole[:-1])
            if subprocess.run([sys.executable, TOOLS / "read_bundle.py", bundle], stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, check=False).returncode != 1:
                sys.exit("read_bundle.py takes a map.bin that is a byte short")
            (bundle / "map.bin").write_bytes(whole)
        run(remaps, "sphere", directory / "5000.remaps", directory / "sphere.remaps", "--quiet")
        said = run(sys.executable, TOOLS / "read_bundle.py", directory / "sphere.remaps", "--points", 100)
        print(said)
        if "sphere    49999 vertices on 1 spheres" not in said:
            sys.exit("read_bundle.py does not follow vertices to the sphere")
        sphere = directory / "sphere.remaps" / "sphere.bin"
        data = bytearray(sphere.read_bytes())
        data[24 * 1000 + 6] ^= 1  # a double's 13th bit behind the point
        sphere.write_bytes(data)
        if subprocess.run([sys.executable, TOOLS / "read_bundle.py", directory / "sphere.remaps"],
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode != 1:
            sys.exit("read_bundle.py takes a direction that is off")
        write_torus(directory / "torus.ply")
        run(remaps, "parameterize", directory / "torus.ply", directory / "torus.remaps", "--quiet")
        said = run(sys.executable, TOOLS / "read_bundle.py", directory / "torus.remaps", "--points", 100)
        print(said)
        if "carries   colour, part, uv: rows of 800 vertices, 1600 faces, corners of 1600" not in said:
            sys.exit("read_bundle.py does not say what the torus carries")


if __name__ == "__main__":
    main()

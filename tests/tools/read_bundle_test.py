#!/usr/bin/env python3
"""Makes a bundle and a mesh with the binary, and reads both with the readers in tools/, which share no
code with it: docs/formats, from which they were written, says what the binary writes.

Arguments: the binary, a mesh.
"""

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
            (bundle / "map.bin").write_bytes((bundle / "map.bin").read_bytes()[:-1])
            if subprocess.run([sys.executable, TOOLS / "read_bundle.py", bundle], stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, check=False).returncode != 1:
                sys.exit("read_bundle.py takes a map.bin that is a byte short")


if __name__ == "__main__":
    main()

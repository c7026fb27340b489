#!/usr/bin/python3
"""Codes every mesh of some folders, and holds what comes back against what was coded.

    tools/codec_identity.py MESHES/scans --markdown docs/codec-identity.md

Each mesh is parameterized and resampled; the samples go through `remaps encode` and `remaps decode` with each
wavelet. Of every archive it is required that

    topology     what it decodes to is a manifold with the components, boundary loops and Euler characteristic
                 of the mesh, by a counter of its own (mesh_topology.py), and so is every prefix;
    cells        no point of the surface coded lies farther from the surface decoded, and none of this from that,
                 than the quantization explains: the sum, over the levels, of the diagonal of a cell;
    stable       the mesh decoded, encoded and decoded again, is the same bit for bit, up to the order of its
                 vertices;
    prefixes     as bytes grow, the PSNR against the mesh itself falls by at most 0.05 dB;
    independent  tools/decode_archive.py, which was written from the format's description, decodes the same.

What follows -- is passed on to `remaps parameterize`. Needs numpy and zstd. Exit code 1 if anything fails.
"""

import argparse
import concurrent.futures
import dataclasses
import json
import math
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

import numpy

import mesh_topology

WAVELETS = ("butterfly-lifted", "butterfly", "loop")
TOOLS = pathlib.Path(__file__).resolve().parent
MOST_FALL = 0.05  # dB
FLOAT = 2.0**-23


class Failed(Exception):
    """A requirement that is not met, or a program that ended with an error."""


@dataclasses.dataclass
class Row:
    mesh: str
    wavelet: str
    topology: str = ""
    faces: int = 0
    bytes: int = 0
    cells: float = math.nan  # largest distance over what the quantization explains
    fall: float = math.nan  # the PSNR's largest, in dB
    first: float = math.nan  # PSNR of the shortest prefix and of the whole archive
    last: float = math.nan
    apart: float = math.nan  # of the independent decoder's vertices, as a fraction of the largest coordinate
    failure: str = ""


@dataclasses.dataclass
class Settings:
    remaps: str
    level: int
    prefixes: int
    options: list
    scratch: str | None


def run(*command):
    done = subprocess.run(list(map(str, command)), stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          check=False)
    if done.returncode != 0:
        message = (done.stderr.strip() or done.stdout.strip()).splitlines()
        raise Failed(f"`{pathlib.Path(str(command[0])).name} {command[1]}` ended with {done.returncode}: "
                     f"{message[-1] if message else ''}")
    return done.stdout


def require(true, what):
    if not true:
        raise Failed(what)


def topology_of(path):
    """Components, boundary loops and Euler characteristic; positions and triangles."""
    positions, triangles = mesh_topology.read_ply(path)
    found = mesh_topology.count_topology(triangles, len(positions))
    require(not found.defects, f"{path.name}: {'; '.join(found.defects)}")
    require(found.unreferenced == 0, f"{path.name}: {found.unreferenced} vertices without a face")
    require(bool(numpy.isfinite(positions).all()), f"{path.name}: coordinates that are not finite")
    return (found.components, found.boundary_loops, found.euler_characteristic), positions, triangles


def sorted_rows(rows):
    """The rows in an order that tells two sets of them apart."""
    return rows[numpy.lexsort(rows.T[::-1])]


def sorted_faces(positions, triangles):
    """The faces by their corners' places, each begun at its least one: an order of vertices changes nothing."""
    corners = positions[triangles]
    order = numpy.lexsort(corners.reshape(-1, 3).T[::-1])
    rank = numpy.empty(len(order), dtype=numpy.int64)
    rank[order] = numpy.arange(len(order))
    first = rank.reshape(-1, 3).argmin(axis=1)
    turned = numpy.take_along_axis(corners, ((first[:, None] + numpy.arange(3)) % 3)[:, :, None], axis=1)
    return sorted_rows(turned.reshape(-1, 9))


def least_prefix(data):
    (base,) = struct.unpack_from("<I", data, 56)
    return 72 + base + 4


def cells_of(data):
    """The sum over the levels of the diagonal of a cell, in model units: docs/formats/archive.md, Details.

    A coefficient that is not 0 lies within half a step of what stands for it, one that is 0 within a step.
    """
    levels, ratio, tangential = data[10], data[12] / 64, data[13] / 256
    (step,) = struct.unpack_from("<d", data, 40)
    total = step * math.sqrt(3)
    for level in range(1, levels + 1):
        total += step * ratio**(level - 1) * math.sqrt(1 + 2 / tangential**2)
    return total


def prefix_sizes(least, size, count):
    """Sizes from the least to all, each a like factor above the last."""
    return sorted({round(least * (size / least)**(i / (count - 1))) for i in range(count)})


def check_prefixes(row, archive, sampled, topology, directory, settings):
    data = archive.read_bytes()
    best, worst = -math.inf, 0.0
    for size in prefix_sizes(least_prefix(data), len(data), settings.prefixes):
        prefix, mesh = directory / "prefix.archive", directory / "prefix.ply"
        prefix.write_bytes(data[:size])
        run(settings.remaps, "decode", prefix, mesh, "--quiet")
        require(topology_of(mesh)[0] == topology, f"the prefix of {size} bytes has another topology")
        psnr = json.loads(run(settings.remaps, "measure", sampled, mesh, "--samples", "100k", "--threads", 1,
                              "--json"))["psnr"]
        row.first = psnr if math.isnan(row.first) else row.first
        row.last = psnr
        worst, best = max(worst, best - psnr), max(best, psnr)
    row.fall = worst
    require(worst <= MOST_FALL, f"the PSNR falls by {worst:.2f} dB")


def check_independent(row, archive, directory, settings):
    """The other decoder is slow: the coarse levels of the whole archive, which exercise all of it but more of the
    same."""
    ours, theirs = directory / "ours.ply", directory / "theirs.ply"
    level = min(2, settings.level)
    run(settings.remaps, "decode", archive, ours, "--level", level, "--quiet")
    run(sys.executable, TOOLS / "decode_archive.py", archive, theirs, "--level", level)
    a, faces = mesh_topology.read_ply(ours)
    b, other_faces = mesh_topology.read_ply(theirs)
    require(numpy.array_equal(faces, other_faces), "decode_archive.py finds other faces")
    row.apart = float(abs(a.astype(float) - b).max() / abs(a).max())
    require(row.apart <= 2 * FLOAT, f"decode_archive.py's vertices are {row.apart:.1e} away")


def check_archive(row, sampled, topology, directory, settings):
    archive, decoded = directory / "whole.archive", directory / "decoded.ply"
    again, decoded_again = directory / "again.archive", directory / "again.ply"
    options = ["--wavelet", row.wavelet, "--attributes", "none", "--no-measure", "--threads", 1, "--quiet"]
    run(settings.remaps, "encode", sampled, archive, *options)
    run(settings.remaps, "decode", archive, decoded, "--quiet")
    data = archive.read_bytes()
    row.bytes = len(data)
    found, positions, triangles = topology_of(decoded)
    row.faces = len(triangles)
    require(found == topology, f"decoded: components, loops, Euler characteristic {found}, not {topology}")

    away = json.loads(run(settings.remaps, "measure", sampled, decoded, "--samples", "200k", "--threads", 1, "--json"))
    farthest = max(away["max_forward"], away["max_backward"]) * away["diagonal"]
    row.cells = farthest / cells_of(data)
    require(row.cells <= 1, f"{row.cells:.2f} of what the quantization explains away from what was coded")

    run(settings.remaps, "encode", decoded, again, *options)
    run(settings.remaps, "decode", again, decoded_again, "--quiet")
    _, positions_again, triangles_again = topology_of(decoded_again)
    require(numpy.array_equal(sorted_rows(positions), sorted_rows(positions_again)), "encoded again: other vertices")
    require(numpy.array_equal(sorted_faces(positions, triangles), sorted_faces(positions_again, triangles_again)),
            "encoded again: other faces")
    check_prefixes(row, archive, sampled, topology, directory, settings)
    check_independent(row, archive, directory, settings)


def name_of(path):
    return path.name.removesuffix(".zst")


def check_mesh(path, settings):
    rows = []
    with tempfile.TemporaryDirectory(dir=settings.scratch) as name:
        directory = pathlib.Path(name)
        bundle, sampled = directory / "mesh.remaps", directory / "sampled.ply"
        try:
            run(settings.remaps, "parameterize", path, bundle, "--threads", 1, "--attributes", "none", "--quiet",
                *settings.options)
            run(settings.remaps, "resample", bundle, sampled, "--level", settings.level, "--no-measure", "--quiet")
            topology = topology_of(sampled)[0]
        except (Failed, ValueError) as error:
            return [Row(name_of(path), "", failure=str(error))]
        for wavelet in WAVELETS:
            row = Row(name_of(path), wavelet, " / ".join(f"{n:,}" for n in topology))
            try:
                check_archive(row, sampled, topology, directory, settings)
            except (Failed, ValueError) as error:
                row.failure = str(error)
            rows.append(row)
    return rows


def table_row(row):
    if row.failure:
        numbers = [f"FAILED: {row.failure}"] + [""] * 6
    else:
        numbers = [f"{row.faces:,}", f"{row.bytes:,}", f"{row.cells:.2f}", f"{row.first:.1f} … {row.last:.1f}",
                   f"{row.fall:.3f}", "yes", f"{row.apart / FLOAT:.1f}"]
    return "| " + " | ".join([row.mesh, row.topology, row.wavelet, *numbers]) + " |"


def markdown(rows, command, settings):
    good = sum(not row.failure for row in rows)
    lines = ["# Identity of the codec", "",
             f"What comes back of every mesh of a folder, by `{command}`. {good} of {len(rows)} rows as it should be.", "",
             f"Each mesh was resampled at level {settings.level}, and the samples coded with 12 bitplanes. *Topology*: components / "
             "boundary loops / Euler characteristic, the same for what the archive", f"decodes to and for each of "
             f"{settings.prefixes} prefixes, from the shortest on, counted by `tools/mesh_topology.py`. *Cells*: "
             "the largest distance between the surfaces coded and decoded,", "in terms of the sum over the levels of "
             "the diagonal of a quantization cell. *PSNR*: of the shortest prefix and of all, against the samples, in dB; "
             "*fall*: the largest as", "bytes grow. *Stable*: encoded and decoded again, the same bit for bit. "
             "*Independent*: how far `tools/decode_archive.py`'s vertices lie away, in units of a float's last place.", "",
             "| mesh | topology | wavelet | faces | bytes | cells | PSNR | fall | stable | independent |",
             "|---|---|---|---|---|---|---|---|---|---|", *map(table_row, rows)]
    return "\n".join(lines) + "\n"


def meshes_of(places):
    found = []
    for place in map(pathlib.Path, places):
        if place.is_dir():
            found += sorted(path for path in place.rglob("*") if path.is_file())
        elif place.is_file():
            found.append(place)
        else:
            sys.exit(f"codec_identity: {place}: expected a mesh or a folder of meshes")
    return found


def parse_arguments(arguments):
    options = []
    if "--" in arguments:
        at = arguments.index("--")
        arguments, options = arguments[:at], arguments[at + 1:]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0],
                                     epilog="What follows -- is passed on to `remaps parameterize`.")
    parser.add_argument("meshes", nargs="+", help="meshes, or folders of them, searched in depth")
    parser.add_argument("--remaps", default="build/release/cli/remaps", help="the binary")
    parser.add_argument("--level", type=int, default=4, help="of the samples (4)")
    parser.add_argument("--prefixes", type=int, default=12, help="of each archive (12)")
    parser.add_argument("--jobs", type=int, default=2, help="meshes at a time (2)")
    parser.add_argument("--markdown", help="where to write the table")
    parser.add_argument("--scratch", help="folder for temporary files (the system's)")
    return parser.parse_args(arguments), options


def main():
    parsed, options = parse_arguments(sys.argv[1:])
    if shutil.which(parsed.remaps) is None:
        sys.exit(f"codec_identity: {parsed.remaps} is missing; ./dev build makes it")
    settings = Settings(parsed.remaps, parsed.level, max(2, parsed.prefixes), options, parsed.scratch)
    rows = []
    with concurrent.futures.ThreadPoolExecutor(parsed.jobs) as pool:
        for done in [pool.submit(check_mesh, path, settings) for path in meshes_of(parsed.meshes)]:
            for row in done.result():
                rows.append(row)
                print(table_row(row), flush=True)
    if parsed.markdown:
        places = " ".join(f"MESHES/{pathlib.Path(place).resolve().name}" for place in parsed.meshes)
        command = f"tools/codec_identity.py {places}"
        if options:
            command += f" -- {' '.join(options)}"
        pathlib.Path(parsed.markdown).write_text(markdown(rows, command, settings), encoding="utf-8")
    bad = sum(bool(row.failure) for row in rows)
    print(f"{len(rows) - bad} of {len(rows)} as they should be")
    return 1 if bad or not rows else 0


if __name__ == "__main__":
    sys.exit(main())

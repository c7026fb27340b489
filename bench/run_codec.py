#!/usr/bin/env python3
"""Measures the codec next to its rivals, stores the results, writes docs/rate-distortion.md with its figures.

    ./dev bench codec [SET] [MESH...] [OPTIONS] [-- ENCODE OPTIONS]

Sets: small (the default), large; they differ in the numbers of bytes that are measured, and in their meshes where
none are named. MESH is a file that remaps reads, or one of the bench's models; the mesh is called by the name of its
file. What follows -- is passed on to `remaps encode`. A mesh that is measured again replaces its rows. A run that
fails is a row that says why, and the others go on; the exit code is then 1.
"""

import argparse
import concurrent.futures
import datetime
import os
import shutil
import subprocess
import sys
from pathlib import Path

import codec_page
from codec_runs import Mesh, Settings
from models import MODELS, ROOT, ModelStore
from process import RunFailed
from results import Table
from run_bench import machine, revision

COLUMNS = ["set", "model", "run", "status", "session", "revision", "machine", "command", "vertices", "faces", "size",
           "bytes", "psnr", "l2", "coded_faces", "bits", "base_vertices", "level", "output_vertices", "cpu_seconds",
           "repeats", "peak_rss"]
# A set: its usual meshes, the bytes that are measured at, and the bases that are tried, as vertices.
SETS = {
    "small": (("koala",), (3_500, 5_000, 7_000, 10_000, 14_000, 20_000, 28_000, 40_000, 60_000, 90_000),
              (100, 200, 400, 800)),
    "large": (("earth4", "g3"), (20_000, 40_000, 90_000, 180_000, 360_000), (400, 1_600, 3_200, 6_400)),
}


def name_of(path):
    """The name of a file without its extensions."""
    return path.name.split(".")[0]


def arguments(words):
    encode_options = []
    if "--" in words:
        at = words.index("--")
        words, encode_options = words[:at], words[at + 1:]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], prog="./dev bench codec",
                                     epilog="What follows -- is passed on to remaps encode.")
    parser.add_argument("meshes", nargs="*", metavar="[SET] MESH",
                        help=f"{' or '.join(SETS)}, files and models; default: small, {' '.join(SETS['small'][0])}; "
                             f"of large: {' '.join(SETS['large'][0])}")
    parser.add_argument("--bases", nargs="+", type=int, metavar="N",
                        help="vertices of base meshes that are tried, instead of the set's; the best is taken")
    parser.add_argument("--samples", default="300k", metavar="N", help="sample points of a measurement; default 300k")
    parser.add_argument("--sizes", nargs="+", type=int, metavar="BYTES", help="bytes to measure at")
    parser.add_argument("--memory", default="1G", metavar="SIZE", help="memory budget of remaps; default 1G")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), metavar="N",
                        help="meshes at a time; default one a processor")
    parser.add_argument("--repeat", type=int, default=3, metavar="N",
                        help="take the least CPU time of so many runs; default 3")
    parser.add_argument("--parameterize", default="", metavar="OPTIONS",
                        help="further options of remaps parameterize, in one word")
    parser.add_argument("--cache", type=Path, default=ROOT / "build/bench", metavar="DIR",
                        help="where models and temporary files go; default build/bench")
    parser.add_argument("--build", type=Path, default=ROOT / "build/bench", metavar="DIR",
                        help="where the programs were built; default build/bench")
    parser.add_argument("--results", type=Path, default=ROOT / "bench/results", metavar="DIR",
                        help="where codec.csv is; default bench/results")
    parser.add_argument("--docs", type=Path, default=ROOT / "docs", metavar="DIR",
                        help="where rate-distortion.md and images/ are written; default docs")
    parser.add_argument("--page-only", action="store_true", help="run nothing; write the page from the results")
    parsed = parser.parse_args(words)
    parsed.set = parsed.meshes.pop(0) if parsed.meshes and parsed.meshes[0] in SETS else "small"
    usual, sizes, bases = SETS[parsed.set]
    parsed.bases = parsed.bases or list(bases)
    parsed.meshes = parsed.meshes or list(usual)
    parsed.sizes = sorted(parsed.sizes or sizes)
    parsed.encode_options = encode_options
    for mesh in parsed.meshes:
        if mesh not in MODELS and not Path(mesh).is_file():
            parser.error(f"{mesh} is neither a file nor a model; models are {', '.join(MODELS)}")
    names = [mesh if mesh in MODELS else name_of(Path(mesh)) for mesh in parsed.meshes]
    for name in names:
        if names.count(name) > 1:
            parser.error(f"two meshes are called {name}")
    if min(parsed.repeat, parsed.jobs, *parsed.sizes, *parsed.bases) < 1:
        parser.error("numbers must be positive")
    parsed.names = names
    return parsed


def plain_mesh(mesh, name, store, programs, work):
    """The path of a mesh as the peers read it."""
    source = store.path(mesh) if mesh in MODELS else Path(mesh)
    path = work / f"{name}.plain.ply"
    try:
        done = subprocess.run([programs / "write_plain_mesh", source, path], stderr=subprocess.PIPE, text=True,
                              check=False)
    except OSError as error:
        raise RunFailed(f"write_plain_mesh cannot be started: {error.strerror}") from error
    if done.returncode != 0:
        raise RunFailed(f"{name}: {done.stderr.strip()}")
    return path


def measure(mesh):
    """Curves of a mesh, in a thread of its own. Returns the base that was chosen, or None."""
    chosen = mesh.measure_curves()
    print(f"{mesh.name}: {len(mesh.rows)} points, base {chosen}", file=sys.stderr, flush=True)
    return chosen


def run(args, stored):
    """Measures all meshes and stores their rows. Returns how many runs failed."""
    remaps, programs, work = args.build / "cli/remaps", args.build / "bench", args.cache / "work-codec"
    store = ModelStore(args.cache / "models", remaps, programs)
    work.mkdir(parents=True, exist_ok=True)
    settings = Settings(remaps, programs, work, args.samples, args.memory, tuple(args.sizes),
                        tuple(size for size in args.sizes if size in codec_page.TABLE_SIZES) or tuple(args.sizes),
                        tuple(args.bases), args.encode_options, args.parameterize.split(), args.repeat)
    common = {"set": args.set, "session": datetime.datetime.now().isoformat(timespec="seconds"),
              "revision": revision(), "machine": machine()}

    def store_rows(mesh):
        stored.replace([{**row, **common} for row in mesh.rows])

    try:
        plains = [plain_mesh(mesh, name, store, programs, work) for mesh, name in zip(args.meshes, args.names)]
        meshes = [Mesh(name, plain, settings) for name, plain in zip(args.names, plains)]
        chosen = []
        with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
            for mesh, base in zip(meshes, pool.map(measure, meshes)):
                chosen.append(base)
                store_rows(mesh)
        for mesh, base in zip(meshes, chosen):
            if base is not None:
                mesh.measure_speed(base)
                store_rows(mesh)
    finally:
        shutil.rmtree(work, ignore_errors=True)
    return sum(row["status"] != "ok" for mesh in meshes for row in mesh.rows)


def main():
    args = arguments(sys.argv[1:])
    stored = Table(args.results / "codec.csv", COLUMNS, key=("model",))
    failed = 0
    if not args.page_only:
        try:
            failed = run(args, stored)
        except RunFailed as error:
            print(f"./dev bench codec: {error}", file=sys.stderr)
            return 1
    codec_page.write(stored, args.docs)
    print(f"wrote {args.docs / 'rate-distortion.md'}", file=sys.stderr)
    if failed:
        print(f"{failed} of the runs failed; the page says why", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Remeshes files and prints a Markdown table of how good the results are.

    tools/quality_table.py --remaps build/release/cli/remaps data/koala.ply scans/*.ply -- --level 5

What follows `--` is passed on to `remaps remesh`. Every file is remeshed twice, plainly and with --fit.
Errors are root mean squares over the surface, the larger of both directions, in 1e-4 of the diagonal of
the input's bounding box. `area` is the input area on the largest base face over that on the median one,
`stretch` the L2 stretch of the map from the base to the surface, 1 at best; both of the plain result.
`CPU s` is user and system time of the plain run without the measurement of the error.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

HEADER = """\
| mesh | vertices | base | output | L2 plain | L2 fitted | max plain | area | stretch | sweeps | CPU s | peak MiB |
|---|---|---|---|---|---|---|---|---|---|---|---|"""


def run(remaps, mesh, output, options):
    """The report of one run."""
    command = [remaps, "remesh", mesh, output, "--json", "--quiet", *options]
    done = subprocess.run(command, stdout=subprocess.PIPE, check=False)
    if done.returncode != 0:
        sys.exit(f"quality_table: {' '.join(map(str, command))} ended with exit code {done.returncode}")
    return json.loads(done.stdout)


def row(remaps, mesh, options):
    with tempfile.TemporaryDirectory() as directory:
        output = pathlib.Path(directory) / "remesh.ply"
        plain = run(remaps, mesh, output, options)
        fitted = run(remaps, mesh, output, [*options, "--fit"])
        unmeasured = run(remaps, mesh, output, [*options, "--no-measure"])
    cells = [
        pathlib.Path(mesh).name,
        f"{plain['input']['vertices']:,}",
        f"{plain['base']['vertices']:,}",
        f"{plain['output']['vertices']:,}",
        f"{1e4 * plain['error']['l2']:.2f}",
        f"{1e4 * fitted['error']['l2']:.2f}",
        f"{1e4 * max(plain['error']['max_forward'], plain['error']['max_backward']):.1f}",
        f"{plain['quality']['area_ratio']:.1f}",
        f"{plain['quality']['l2_stretch']:.2f}",
        f"{len(plain['sweeps'])}",
        f"{unmeasured['cpu_seconds']:.1f}",
        f"{unmeasured['peak_rss_bytes'] / 2**20:.0f}",
    ]
    return "| " + " | ".join(cells) + " |"


def main():
    arguments = sys.argv[1:]
    options = []
    if "--" in arguments:
        at = arguments.index("--")
        arguments, options = arguments[:at], arguments[at + 1:]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--remaps", default="build/release/cli/remaps", help="the binary")
    parser.add_argument("meshes", nargs="+", help="files to remesh")
    parsed = parser.parse_args(arguments)
    print(HEADER)
    for mesh in parsed.meshes:
        print(row(parsed.remaps, mesh, options), flush=True)


if __name__ == "__main__":
    main()

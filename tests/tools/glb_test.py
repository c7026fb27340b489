#!/usr/bin/env python3
"""Makes .glb files with the binary and has Khronos' validator check them: no error, no warning.

Arguments: the binary, a mesh. Exits with 77 if the validator is not set up, which is no failure.
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile

VALIDATOR = pathlib.Path(__file__).resolve().parents[2] / "tools" / "gltf_validator"


def run(*command):
    done = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} ended with exit code {done.returncode}:\n{done.stdout}")
    return done.stdout


def main():
    remaps, mesh = sys.argv[1:]
    if shutil.which("node") is None:
        print("skipped: no node; Debian has it as nodejs, with npm as npm")
        sys.exit(77)
    if not (VALIDATOR / "node_modules" / "gltf-validator").is_dir():
        print("skipped: gltf-validator is not installed; npm ci --prefix tools/gltf_validator does it")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as name:
        directory = pathlib.Path(name)
        bundle = directory / "b.remaps"
        run(remaps, "parameterize", mesh, bundle, "--quiet")
        run(remaps, "resample", bundle, directory / "out.glb", "--levels", "0..5", "--no-measure", "--quiet")
        run(remaps, "resample", bundle, directory / "fit.glb", "--level", "2", "--fit", "--no-measure", "--quiet")
        run(remaps, "generate", directory / "scan.glb", "--vertices", "5k", "--base", "torus", "--quiet")
        files = sorted(directory.glob("*.glb"))
        if len(files) != 8:
            sys.exit(f"8 files were expected, there are {len(files)}")
        print(run("node", VALIDATOR / "validate.js", *files))
        # The validator must be heard when it complains.
        content = files[0].read_bytes()
        files[0].write_bytes(content.replace(b'"max":[', b'"max":[1e3+', 1)[:len(content)])
        if subprocess.run(["node", str(VALIDATOR / "validate.js"), str(files[0])], stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL, check=False).returncode != 1:
            sys.exit("validate.js takes a damaged file")


if __name__ == "__main__":
    main()

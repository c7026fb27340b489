#!/usr/bin/env python3
"""Makes .glb files with the binary and has Khronos' validator check them: no error, no warning.

Arguments: the binary, a mesh. Exits with 77 if the validator is not set up, which is no failure.
"""

import json
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import textured_mesh  # noqa: E402

VALIDATOR = pathlib.Path(__file__).resolve().parents[2] / "tools" / "gltf_validator"


def run(*command):
    done = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} ended with exit code {done.returncode}:\n{done.stdout}")
    return done.stdout


def read_glb(path):
    """Returns {attribute: values of vertices} and the triangles, of a mesh as remaps writes them."""
    content = path.read_bytes()
    (length,) = struct.unpack_from("<I", content, 12)
    root, data = json.loads(content[20:20 + length]), content[28 + length:]

    def values(number):
        accessor = root["accessors"][number]
        view = root["bufferViews"][accessor["bufferView"]]
        code = {5121: "B", 5123: "H", 5125: "I", 5126: "f"}[accessor["componentType"]]
        code = "<" + code * (1 if accessor["type"] == "SCALAR" else int(accessor["type"][3]))
        first = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", struct.calcsize(code))
        return [struct.unpack_from(code, data, first + i * stride) for i in range(accessor["count"])]
    primitive = root["meshes"][0]["primitives"][0]
    corners = [v for (v,) in values(primitive["indices"])]
    return ({name: values(number) for name, number in primitive["attributes"].items()},
            list(zip(*[iter(corners)] * 3)))


def check_textured(path):
    """Colours are where they belong, and no face goes through all of the texture."""
    vertices, triangles = read_glb(path)
    if sorted(vertices) != ["COLOR_0", "NORMAL", "POSITION", "TEXCOORD_0"]:
        sys.exit(f"{path}: has {sorted(vertices)}")
    for position, colour in zip(vertices["POSITION"], vertices["COLOR_0"]):
        if max(abs(a - b) for a, b in zip(colour, textured_mesh.colour_of(position))) > 2:
            sys.exit(f"{path}: colour {colour} at {position}")
    texture = vertices["TEXCOORD_0"]
    for triangle in triangles:
        for axis in (0, 1):
            along = [texture[v][axis] for v in triangle]
            if max(along) - min(along) > 0.4:
                sys.exit(f"{path}: face {triangle} lies across a seam: {[texture[v] for v in triangle]}")
    places = len(set(vertices["POSITION"]))
    if not places < len(texture) < 1.3 * places:
        sys.exit(f"{path}: {len(texture)} vertices at {places} places")


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
        textured_mesh.write_textured_mesh(directory / "torus.ply")
        options = ["--base-vertices", "40", "--level", "4", "--no-measure", "--quiet"]
        run(remaps, "remesh", directory / "torus.ply", directory / "textured.glb", *options)
        run(remaps, "remesh", directory / "textured.glb", directory / "textured-again.glb", *options)
        for name in ("textured.glb", "textured-again.glb"):
            check_textured(directory / name)
        files = sorted(directory.glob("*.glb"))
        if len(files) != 10:
            sys.exit(f"10 files were expected, there are {len(files)}")
        print(run("node", VALIDATOR / "validate.js", *files))
        # The validator must be heard when it complains.
        content = files[0].read_bytes()
        files[0].write_bytes(content.replace(b'"max":[', b'"max":[1e3+', 1)[:len(content)])
        if subprocess.run(["node", str(VALIDATOR / "validate.js"), str(files[0])], stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL, check=False).returncode != 1:
            sys.exit("validate.js takes a damaged file")


if __name__ == "__main__":
    main()

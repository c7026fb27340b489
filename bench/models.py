"""The meshes of the bench. Each is made when first needed, and kept in the cache folder."""

import gzip
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import nifti
from process import RunFailed

ROOT = Path(__file__).resolve().parent.parent
RELIEF = "/usr/share/ferret-vis/data/etopo5.cdf"
HEAD = "/usr/share/mricron/templates/ch2better.nii.gz"
HEAD_LEVEL = "80.5"
# Debian's interpreter, since numpy and scipy are Debian's; another python3 may be first on PATH.
DEBIAN_PYTHON = "/usr/bin/python3"
SHUFFLED = "-shuffled"


@dataclass(frozen=True)
class Model:
    title: str
    vertices: int  # about, for the check of free space
    kind: str
    argument: object = None


MODELS = {
    "koala": Model("Koala", 50_000, "bundled", "data/koala.ply"),
    "earth4": Model("Earth, every 4th sample", 583_202, "earth", 4),
    "earth2": Model("Earth, every 2nd sample", 2_333_522, "earth", 2),
    "earth1": Model("Earth", 9_326_882, "earth", 1),
    "head": Model("MRI head", 2_015_000, "head"),
    "tiny": Model("Generated, 5 k", 5_000, "generated", "5k"),
    "g1": Model("Generated, 1.4 M", 1_440_000, "generated", "1.44M"),
    "g3": Model("Generated, 3 M", 3_000_000, "generated", "3M"),
    "g14": Model("Generated, 14.4 M", 14_400_000, "generated", "14.4M"),
    "g150": Model("Generated, 150 M", 150_000_000, "generated", "150M"),
}


def binary_bytes(vertices, faces):
    """Size of a mesh as binary PLY: 12 bytes a vertex, 13 a triangle."""
    return 12 * vertices + 13 * faces


def model_named(name):
    """A model, or RunFailed. NAME-shuffled is a generated one in random order."""
    plain = name.removesuffix(SHUFFLED)
    model = MODELS.get(plain)
    if model is None or (plain != name and model.kind != "generated"):
        raise RunFailed(f"no model {name}; there are {', '.join(MODELS)}, and -shuffled of the generated ones")
    return model


def about_bytes(name):
    vertices = model_named(name).vertices
    return binary_bytes(vertices, 2 * vertices)


def require_space(directory, needed, what):
    free = shutil.disk_usage(directory).free
    if free < needed:
        raise RunFailed(f"{what} needs {needed / 2**30:.1f} GiB in {directory}, {free / 2**30:.1f} are free")


class ModelStore:
    """Makes models, and copies of them in other formats, in a folder."""

    def __init__(self, folder, remaps, programs):
        self._folder = Path(folder)
        self._remaps = remaps
        self._programs = Path(programs)
        self._folder.mkdir(parents=True, exist_ok=True)

    def path(self, name):
        """The binary PLY of a model; made if it is not there."""
        model = model_named(name)
        if model.kind == "bundled":
            return ROOT / model.argument
        return self._keep(f"{name}.ply", about_bytes(name), lambda path: self._make(name, model, path))

    def copy_path(self, name, form):
        """The model as .text.{ply,obj,off,stl}, .binary.stl or .glb; or its binary PLY compressed, .ply.gz or .ply.zst."""
        source = self.path(name)

        def make(path):
            if path.suffix == ".gz":
                with open(source, "rb") as plain, gzip.open(path, "wb", compresslevel=6) as packed:
                    shutil.copyfileobj(plain, packed, 1 << 20)
            elif path.suffix == ".zst":
                self._run(["zstd", "-q", source, "-o", path], f"{form} of {name}")
            else:
                self._run([self._programs / "write_mesh_copy", source, path], f"{form} of {name}")
        return self._keep(f"{name}{form}", 12 * source.stat().st_size, make)

    def _keep(self, file_name, needed, make):
        path = self._folder / file_name
        if not path.exists():
            require_space(self._folder, needed, file_name)
            print(f"making {path}", file=sys.stderr, flush=True)
            # Beside its place, with its extension, so that half a file never has its name.
            partial = path.with_name(f"partial-{file_name}")
            make(partial)
            os.replace(partial, path)
        return path

    def _make(self, name, model, path):
        if model.kind == "earth":
            self._need(RELIEF, "ferret-datasets")
            self._run([DEBIAN_PYTHON, ROOT / "bench/make_earth.py", RELIEF, path, "--stride", model.argument], name)
        elif model.kind == "head":
            self._need(HEAD, "mricron-data")
            self._make_head(path)
        else:
            order = ["--shuffled"] if name.endswith(SHUFFLED) else []
            self._run([self._remaps, "generate", path, "--vertices", model.argument, "--quiet", *order], name)

    def _make_head(self, path):
        volume = nifti.read_volume(HEAD)
        raw = path.with_suffix(".raw")
        try:
            raw.write_bytes(volume.values)
            self._run([self._programs / "isosurface", raw, *volume.size, *volume.spacing, HEAD_LEVEL, path], "head")
        finally:
            raw.unlink(missing_ok=True)

    @staticmethod
    def _need(path, package):
        if not os.path.exists(path):
            raise RunFailed(f"{path} is missing: apt-get install {package}")

    @staticmethod
    def _run(command, what):
        command = [str(part) for part in command]
        try:
            done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
        except OSError as error:
            raise RunFailed(f"{what}: {command[0]} cannot be started: {error.strerror}") from error
        if done.returncode != 0:
            lines = done.stderr.strip().splitlines() or ["no message"]
            raise RunFailed(f"{what}: {os.path.basename(command[0])} failed: {lines[-1]}")

"""Runs of the codec and its rivals on one mesh: rows of bench/results/codec.csv."""

import json
import shutil
from dataclasses import dataclass
from pathlib import Path

import rate_distortion as rd
from process import RunFailed, run_measured
from runs import shortened

RIVAL, FULL, LIMIT = "decimated, Draco", "Draco", "unquantized"
CHECK, ENCODE, DECODE = "check", "encode", "decode"
BITS = range(6, 17)  # that Draco is tried with
FULL_BITS = range(7, 15)
FIRST_BITS, FIRST_FACE_BYTES = 9, 1.2  # of a search that knows nothing yet
BYTES_SHOWN = 4  # times the largest size: where the curves of the full mesh end


def ours(base_vertices):
    """The run's name of an archive with such a base."""
    return f"remaps, base {base_vertices}"


@dataclass
class Settings:
    remaps: Path
    programs: Path
    work: Path
    samples: str
    memory: str
    sizes: tuple  # bytes that curves are measured at
    table_sizes: tuple  # those of them that the tables show
    bases: tuple  # vertices of the base meshes that are tried
    encode_options: list
    parameterize_options: list
    repeat: int


class Mesh:
    """One mesh, and all that is measured of it."""

    def __init__(self, name, plain, settings):
        """plain: the mesh as PLY that the peers read"""
        self.name = name
        self.rows = []
        self._plain = plain
        self._settings = settings
        self._folder = settings.work / name
        shutil.rmtree(self._folder, ignore_errors=True)
        self._folder.mkdir(parents=True)
        self._decoded = self._folder / "decoded.ply"
        self._input = None  # (vertices, faces)
        self._least_bytes = {}  # of an archive, by base: shorter beginnings are no mesh

    def measure_curves(self):
        """Fills rows; a run that fails is a row that says why. Returns the base that was chosen, or None."""
        self._guarded(CHECK, self._count)
        return None if self._input is None else self._measure_all()

    def _count(self):
        info = json.loads(self._run([self._settings.remaps, "check", self._plain, "--json"]).stdout)
        self._input = (info["vertices"], info["faces"])

    def _measure_all(self):
        self._guarded(RIVAL, self._measure_decimated)
        self._guarded(FULL, self._measure_full)
        for base in self._settings.bases:
            self._guarded(ours(base), self._measure_archive, base, self._settings.table_sizes)
        chosen = chosen_base(self.rows, self._settings.table_sizes)
        if chosen is not None:
            rest = [size for size in self._settings.sizes if size not in self._settings.table_sizes]
            self._guarded(ours(chosen), self._measure_beginnings, chosen, [*rest, None])
            self._guarded(LIMIT, self._measure_limit, chosen)
        return chosen

    def measure_speed(self, base):
        """Encodes and decodes once more, with nothing else running."""
        self._guarded(ENCODE, self._time, ENCODE, base)
        self._guarded(DECODE, self._time, DECODE, base)

    def _guarded(self, run, work, *arguments):
        try:
            work(*arguments)
        except (RunFailed, OSError, KeyError, ValueError) as error:
            self._add(run, status=str(error) or type(error).__name__)

    def _add(self, run, *, status="ok", **cells):
        vertices, faces = self._input or (None, None)
        self.rows.append({"model": self.name, "run": run, "status": status, "vertices": vertices, "faces": faces,
                          "size": None, **cells})

    def _run(self, command):
        return run_measured(command, self._folder)

    def _remaps(self, *words):
        return [self._settings.remaps, *words, "--threads", 1, "--memory", self._settings.memory]

    def _error(self):
        """l2 and psnr of the decoded mesh against the input."""
        said = self._run(self._remaps("measure", self._plain, self._decoded, "--json", "--samples",
                                      self._settings.samples, "--temp-dir", self._folder)).stdout
        l2 = rd.l2_of(json.loads(said))
        return {"l2": l2, "psnr": rd.psnr_db(l2)}

    # The rivals.

    def _draco(self, source, bits):
        """What Draco makes of a mesh; it is left decoded."""
        return json.loads(self._run([self._settings.programs / "peer_draco", source, self._folder / "mesh.drc",
                                     self._decoded, bits]).stdout)

    def _decimated_bytes(self, faces, bits):
        source = self._plain
        if faces < self._input[1]:
            source = self._folder / "decimated.ply"
            self._run([self._settings.programs / "peer_meshoptimizer", self._plain, faces, source])
        return self._draco(source, bits)["bytes"]

    def _measure_decimated(self):
        bits, faces_of = FIRST_BITS, {}  # bits: (faces, bytes) of the size before

        def psnr_of(bits, size):
            near = min(faces_of, key=lambda b: abs(b - bits), default=None)
            faces, taken = faces_of.get(near, (1, FIRST_FACE_BYTES))
            faces = rd.most_faces_within(lambda n: self._decimated_bytes(n, bits), size, self._input[1],
                                         faces * size / taken)
            if faces is None:
                return None
            taken = self._decimated_bytes(faces, bits)
            faces_of[bits] = (faces, taken)
            error = self._error()
            self._add(RIVAL, size=size, bytes=taken, coded_faces=faces, bits=bits, **error)
            return error["psnr"]

        for size in self._settings.sizes:
            bits = rd.climb(lambda b, size=size: psnr_of(b, size), bits, BITS[0], BITS[-1]) or bits

    def _measure_full(self):
        for bits in FULL_BITS:
            taken = self._draco(self._plain, bits)["bytes"]
            if taken > BYTES_SHOWN * self._settings.sizes[-1]:
                break
            self._add(FULL, bytes=taken, coded_faces=self._input[1], bits=bits, **self._error())

    # remaps.

    def _bundle(self, base):
        return self._folder / f"base-{base}.remaps"

    def _archive(self, base):
        return self._folder / f"base-{base}.archive"

    def _parameterize(self, base):
        return self._remaps("parameterize", self._plain, self._bundle(base), "--base-vertices", base, "--quiet",
                            *self._settings.parameterize_options)

    def _encode(self, base):
        return self._remaps("encode", self._bundle(base), self._archive(base), "--no-measure", "--json", "--quiet",
                            "--temp-dir", self._folder, *self._settings.encode_options)

    def _decode(self, base, size=None):
        limit = [] if size is None else ["--bytes", size]
        return [self._settings.remaps, "decode", self._archive(base), self._decoded, *limit, "--json", "--quiet",
                "--memory", self._settings.memory]

    def _measure_archive(self, base, sizes):
        self._run(self._parameterize(base))
        self._least_bytes[base] = json.loads(self._run(self._encode(base)).stdout)["least_bytes"]
        self._measure_beginnings(base, sizes)

    def _measure_beginnings(self, base, sizes):
        """Decodes and measures beginnings of an archive; None is all of it."""
        whole = self._archive(base).stat().st_size
        for size in sizes:
            if size is not None and size < self._least_bytes[base]:
                continue
            said = json.loads(self._run(self._decode(base, size)).stdout)
            self._add(ours(base), size=size, bytes=min(size or whole, whole), level=said["level"],
                      coded_faces=said["faces"], base_vertices=base, command=self._commands(base), **self._error())

    def _commands(self, base):
        return shortened(self._parameterize(base)) + " && " + shortened(self._encode(base))

    def _measure_limit(self, base):
        """The surface that the archive would end at, had it no end."""
        level = next(row["level"] for row in self.rows if row["run"] == ours(base) and row["status"] == "ok")
        self._run(self._remaps("resample", self._bundle(base), self._decoded, "--level", level, "--no-measure",
                               "--quiet"))
        self._add(LIMIT, base_vertices=base, level=level, **self._error())

    def _time(self, what, base):
        command = self._encode(base) if what == ENCODE else self._decode(base)
        usages = [self._run(command) for _ in range(self._settings.repeat)]
        cpu = min(usage.cpu_seconds for usage in usages)
        decoded = json.loads(self._run(self._decode(base)).stdout)
        self._add(what, base_vertices=base, level=decoded["level"], bytes=self._archive(base).stat().st_size,
                  output_vertices=decoded["vertices"], cpu_seconds=cpu, repeats=len(usages),
                  peak_rss=max(u.peak_rss for u in usages),
                  command=shortened(command))


def chosen_base(rows, sizes):
    """The base whose archive is best on average over the sizes that all of them have; None if there is no archive."""
    by_base = {}
    for row in rows:
        if row["run"].startswith("remaps, ") and row["status"] == "ok" and row["size"] in sizes:
            by_base.setdefault(row["base_vertices"], {})[row["size"]] = row["psnr"]
    if not by_base:
        return None
    # A larger base may not fit the smallest sizes: what is without a result there cannot be chosen for them.
    most = max(len(of) for of in by_base.values())
    complete = {base: of for base, of in by_base.items() if len(of) == most}
    return max(complete, key=lambda base: (sum(complete[base].values()), -base))

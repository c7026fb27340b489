"""Runs jobs and makes rows of them."""

import hashlib
import json
import os
import shutil
from pathlib import Path

import sets
from models import about_bytes, binary_bytes, require_space
from process import RunFailed, allocated_bytes, run_measured
from results import thinned

# A run may take so many times its binary input and output on disk, temporary files and results together.
SPACE_FACTOR = 8


def hash_files(path):
    """One checksum of a file, or of all files below a directory with their names."""
    digest = hashlib.sha256()
    for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
        digest.update(file.name.encode())
        with open(file, "rb") as stream:
            while block := stream.read(1 << 20):
                digest.update(block)
    return digest.hexdigest()[:16]


def warm(path):
    """Reads a file once, so that every run finds it in the system's cache, as far as it fits."""
    with open(path, "rb") as file:
        while file.read(1 << 22):
            pass


def shortened(command):
    """A command without the places of files."""
    return " ".join(os.path.basename(str(part)) for part in command)


class Runner:
    """Runs jobs one at a time in a work folder of its own."""

    def __init__(self, store, remaps, programs, work, settings):
        """settings: level and samples that overrule the jobs', or None; peer_error: measure the peers."""
        self._store = store
        self._remaps = remaps
        self._programs = Path(programs)
        self._work = Path(work)
        self._settings = settings
        self._faces = {}  # of the output of a model's remesh: what its peers are asked for
        self._inputs = {}  # (vertices, faces) of a model, as remaps counts them
        self.trace = None  # of the last run that was asked to keep one

    def start_group(self):
        shutil.rmtree(self._work, ignore_errors=True)
        for folder in ("temp", "result", "log", "kept"):
            (self._work / folder).mkdir(parents=True)

    def finish_group(self):
        shutil.rmtree(self._work, ignore_errors=True)

    def run(self, job):
        """The row of a job. Raises RunFailed."""
        self.trace = None
        for folder in ("temp", "result"):
            shutil.rmtree(self._work / folder)
            (self._work / folder).mkdir()
        row = {"model": job.model, "run": job.run}
        row.update(getattr(self, f"_run_{job.kind}")(job))
        row["status"] = "ok"
        return row

    def _measured(self, command):
        """Cells of any run."""
        usage = run_measured(command, self._work / "log",
                             {"temp": self._work / "temp", "result": self._work / "result"})
        row = {
            "command": shortened(command),
            "seconds": usage.seconds,
            "cpu_seconds": usage.cpu_seconds,
            "peak_rss": usage.peak_rss,
            "bytes_read": usage.bytes_read,
            "bytes_written": usage.bytes_written,
            "peak_temp": usage.peak_disk["temp"],
            "peak_disk": usage.peak_disk["all"],
            "result_bytes": allocated_bytes(self._work / "result"),
        }
        return row, usage

    def _reported(self, command, options):
        """Cells of a run of remaps, with what its report says."""
        path = self._work / "log/report.json"
        command = [self._remaps, *command, "--quiet", "--report", path, "--temp-dir", self._work / "temp",
                   "--memory", options["memory"]]
        if "threads" in options:
            command += ["--threads", options["threads"]]
        row, _ = self._measured(command)
        with open(path, encoding="utf-8") as file:
            report = json.load(file)
        row.update({
            "vertices": report["input"]["vertices"],
            "faces": report["input"]["faces"],
            "input_bytes": binary_bytes(report["input"]["vertices"], report["input"]["faces"]),
            "base_vertices": report["base"]["vertices"],
            "level": report["level"],
            "memory_budget": report["memory_budget_bytes"],
            "threads": report["threads"],
            "output_vertices": report["output"]["vertices"],
            "output_faces": report["output"]["faces"],
            "reported_io": report["io"]["bytes_read"] + report["io"]["bytes_written"],
            "l2": report.get("error", {}).get("l2"),
        })
        row.update({phase: report["seconds"][phase] for phase in ("ingest", "sweeps", "map", "resample", "measure")})
        if options.get("trace"):
            self.trace = thinned([(s["seconds"], s["rss_bytes"]) for s in report["memory_trace"]])
        return row

    def _run_remesh(self, job):
        options = job.options
        base_vertices, level = options.get("base_vertices", sets.BASE_VERTICES), self._level(options)
        source = self._input(job.model, base_vertices * 4**level)
        output, bundle = self._work / "result/remesh.ply", self._work / "result/map.remaps"
        command = ["remesh", source, output, "--base-vertices", base_vertices, "--level", level, *self._samples()]
        if options["bundle"]:
            command += ["--bundle", bundle]
        row = self._reported(command, options)
        self._faces[job.model] = row["output_faces"]
        self._inputs[job.model] = {key: row[key] for key in ("vertices", "faces", "input_bytes")}
        if options.get("hashes"):
            row["output_hash"], row["bundle_hash"] = hash_files(output), hash_files(bundle)
        return row

    def _run_parameterize(self, job):
        source = self._input(job.model)
        bundle = self._work / "result/map.remaps"
        row = self._reported(["parameterize", source, bundle, "--base-vertices", sets.BASE_VERTICES], job.options)
        shutil.rmtree(self._kept_bundle(job.model), ignore_errors=True)
        os.replace(bundle, self._kept_bundle(job.model))
        return row

    def _run_resample(self, job):
        bundle = self._kept_bundle(job.model)
        if not bundle.exists():
            raise RunFailed("there is no bundle, since parameterize failed")
        return self._reported(["resample", bundle, self._work / "result/remesh.ply", "--level",
                               self._level(job.options), "--no-measure"], job.options)

    def _run_peer(self, job):
        if job.model not in self._faces:
            raise RunFailed("the number of faces is not known, since remesh failed")
        if self._faces[job.model] >= self._inputs[job.model]["faces"]:
            raise RunFailed(f"nothing to do: the remesh has {self._faces[job.model]:,} faces, no fewer than the input")
        source = self._input(job.model)
        output = self._work / "result/peer.ply"
        row, usage = self._measured([self._programs / job.options["program"], source, self._faces[job.model], output])
        reached = json.loads(usage.stdout)
        row.update(self._inputs[job.model])
        row.update({"output_vertices": reached["vertices"], "output_faces": reached["faces"]})
        if self._settings.peer_error:
            measure = [self._remaps, "measure", source, output, "--json", "--quiet", "--temp-dir", self._work / "temp",
                       *self._samples()]
            row["l2"] = json.loads(run_measured(measure, self._work / "log").stdout)["l2"]
        return row

    def _run_read(self, job):
        form = job.options["form"]
        source = self._store.copy_path(job.model, form) if form else self._store.path(job.model)
        warm(source)
        row, usage = self._measured([self._programs / "read_mesh", source])
        said = json.loads(usage.stdout)
        row.update({
            "vertices": said["positions"]["elements"],
            "faces": said["triangles"]["elements"],
            "file_bytes": said["bytes"],
            "positions_cpu": said["positions"]["cpu_seconds"],
            "triangles_cpu": said["triangles"]["cpu_seconds"],
        })
        return row

    def _input(self, model, output_vertices=0):
        source = self._store.path(model)
        needed = SPACE_FACTOR * (about_bytes(model) + binary_bytes(output_vertices, 2 * output_vertices))
        require_space(self._work, needed, f"a run on {model}")
        warm(source)
        return source

    def _kept_bundle(self, model):
        return self._work / "kept" / f"{model}.remaps"

    def _level(self, options):
        return options["level"] if self._settings.level is None else self._settings.level

    def _samples(self):
        return [] if self._settings.samples is None else ["--samples", self._settings.samples]

"""Results on disk: a CSV a set, a row a model and run. Running again replaces rows."""

import csv
import os
from pathlib import Path

COLUMNS = [
    "model", "run", "status",
    # Which run of the bench: ratios are made within one only.
    "session", "revision", "machine", "load", "repeats", "command",
    "vertices", "faces", "input_bytes", "base_vertices", "level", "memory_budget", "threads",
    "output_vertices", "output_faces",
    "seconds", "cpu_seconds", "peak_rss", "bytes_read", "bytes_written", "peak_temp", "peak_disk", "result_bytes",
    "ingest", "sweeps", "map", "resample", "measure", "reported_io", "l2",
    "output_hash", "bundle_hash",
    "file_bytes", "positions_cpu", "triangles_cpu",
]
TEXT = {"set", "model", "run", "status", "session", "revision", "machine", "command", "output_hash", "bundle_hash"}


def to_value(column, text):
    if column in TEXT:
        return text
    if text == "":
        return None
    return float(text) if any(c in text for c in ".en") else int(text)


def to_text(value):
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


class Table:
    """The rows of one CSV: dictionaries by column, None where nothing is known."""

    def __init__(self, path, columns=None, key=("model", "run")):
        self.path = Path(path)
        self.columns = columns or COLUMNS
        self._key = key
        self.rows = []
        if self.path.exists():
            with open(self.path, newline="", encoding="utf-8") as file:
                for row in csv.DictReader(file):
                    self.rows.append({c: to_value(c, row.get(c) or "") for c in self.columns})

    def replace(self, rows):
        """Puts rows where the ones of the same key were, new keys at the end, and stores the table."""
        by_key = {}
        for row in rows:
            by_key.setdefault(self._key_of(row), []).append(row)
        kept = []
        for row in self.rows:
            key = self._key_of(row)
            if key not in by_key:
                kept.append(row)
            else:
                kept.extend(by_key[key])
                by_key[key] = []
        for left in by_key.values():
            kept.extend(left)
        self.rows = kept
        self._store()

    def find(self, model, run):
        """The row, if there is one and it is sound."""
        for row in self.rows:
            if row["model"] == model and row["run"] == run and row.get("status") == "ok":
                return row
        return None

    def models(self):
        return list(dict.fromkeys(row["model"] for row in self.rows))

    def _key_of(self, row):
        return tuple(row[c] for c in self._key)

    def _store(self):
        self.path.parent.mkdir(parents=True, exist_ok=True)
        partial = self.path.with_name(self.path.name + ".partial")
        with open(partial, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(self.columns)
            for row in self.rows:
                writer.writerow([to_text(row.get(c)) for c in self.columns])
        os.replace(partial, self.path)


TRACE_COLUMNS = ["model", "run", "seconds", "rss_bytes"]
TRACE_POINTS = 160


def trace_table(folder):
    return Table(Path(folder) / "memory_trace.csv", TRACE_COLUMNS)


def thinned(trace):
    """At most TRACE_POINTS of a trace of (seconds, bytes): the largest of each stretch."""
    if len(trace) <= TRACE_POINTS:
        return trace
    bounds = [i * len(trace) // TRACE_POINTS for i in range(TRACE_POINTS + 1)]
    return [max(trace[a:b], key=lambda sample: sample[1]) for a, b in zip(bounds, bounds[1:])]

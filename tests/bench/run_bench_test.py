#!/usr/bin/env python3
"""Runs the benchmark on a mesh of 5,000 vertices, and its parts on still less.

    run_bench_test.py BUILD [--programs]

BUILD is a build tree with the binary; --programs says that bench/ was built there too, with the peers.
Without it their rows must say that they are missing, and the rest must go on.
"""

import csv
import gzip
import json
import random
import struct
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BENCH = ROOT / "bench"
sys.path.insert(0, str(BENCH))

import goals  # noqa: E402  (found by the line above)
import nifti  # noqa: E402
import process  # noqa: E402
import results  # noqa: E402
import tables  # noqa: E402

BUILD = Path()
PROGRAMS = False
PEERS = {"meshoptimizer", "openmesh"}


def needs_programs(row):
    return row["run"] in PEERS or row["run"].startswith("read ")


class Folder(unittest.TestCase):
    """A test with a directory of its own."""

    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.folder = Path(directory.name)


class Driver(Folder):
    def bench(self, *arguments, build=None, level=2):
        """Runs the driver; returns its exit code."""
        command = [sys.executable, BENCH / "run_bench.py", *arguments, "--models", "tiny", "--level", level, "--samples",
                   "2000", "--build", build or BUILD, "--cache", self.folder / "cache", "--results",
                   self.folder / "results", "--docs", self.folder / "docs"]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        return done.returncode

    def rows(self, name):
        with open(self.folder / f"results/{name}.csv", newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def test_every_set_fills_its_rows_and_the_page(self):
        sets = ("quick", "memory", "order", "output", "readers", "huge")
        code = self.bench(*sets)
        self.assertEqual(code, 0 if PROGRAMS else 1)
        for name in sets:
            for row in self.rows(name):
                self.check_row(row)
        one, two = (row for row in self.rows("memory") if row["run"].startswith("threads"))
        self.assertEqual((one["threads"], two["threads"]), ("1", "2"))
        self.assertEqual(one["output_hash"], two["output_hash"])
        self.assertEqual(one["bundle_hash"], two["bundle_hash"])
        page = (self.folder / "docs/benchmarks.md").read_text(encoding="utf-8")
        self.assertNotIn("{{", page)
        self.assertIn("| Generated, 5 k, shuffled |", page)
        self.assertIn("`./dev bench standard`", page)
        root = xml.etree.ElementTree.parse(self.folder / "docs/images/memory-tiny.svg").getroot()
        self.assertEqual(len(root.findall("{http://www.w3.org/2000/svg}polyline")), 4)
        self.assertEqual(list((self.folder / "cache").iterdir()), [self.folder / "cache/models"])

    def check_row(self, row):
        if needs_programs(row) and not PROGRAMS:
            self.assertNotEqual(row["status"], "ok")
            return
        self.assertEqual(row["status"], "ok", row)
        self.assertGreater(float(row["cpu_seconds"]), 0)
        self.assertGreater(int(row["peak_rss"]), 2**20)
        if row["run"] in PEERS:
            self.assertTrue(6000 < int(row["output_faces"]) <= 6336, row)
        if row["run"] not in ("parameterize", "resample") and not row["run"].startswith("read "):
            self.assertTrue(0 < float(row["l2"]) < 0.01, row)

    def test_peers_are_not_asked_for_more_faces_than_there_are(self):
        self.bench("quick", "--runs", "map", "openmesh", level=4)
        self.assertEqual([row["run"] for row in self.rows("quick") if row["status"] == "ok"], ["map"])
        self.assertIn("nothing to do", self.rows("quick")[1]["status"])

    def test_a_run_again_replaces_its_rows(self):
        self.bench("order")
        before = self.rows("order")
        (self.folder / "results/order.csv").write_text(
            (self.folder / "results/order.csv").read_text().replace(before[0]["session"], "before"))
        self.assertEqual(self.bench("order"), 0)
        after = self.rows("order")
        self.assertEqual([row["model"] for row in after], [row["model"] for row in before])
        self.assertNotIn("before", [row["session"] for row in after])

    def test_failing_runs_are_rows_that_say_why(self):
        self.bench("order")
        self.assertEqual(self.bench("order", build=self.folder / "nowhere"), 1)
        for row in self.rows("order"):
            self.assertIn("cannot be started", row["status"])
        page = (self.folder / "docs/benchmarks.md").read_text(encoding="utf-8")
        self.assertIn("No result:", page)


class Measuring(Folder):
    def test_counts_processor_time_bytes_and_disk_of_a_process(self):
        (self.folder / "watched").mkdir()
        code = ("import sys, time\n"
                "sum(i for i in range(2000000))\n"
                "f = open(sys.argv[1], 'wb'); f.write(bytes(3 << 20)); f.flush()\n"
                "import os; os.remove(sys.argv[1]); time.sleep(0.5); print('done')\n")
        usage = process.run_measured([sys.executable, "-c", code, self.folder / "watched/file"], self.folder,
                                     {"temp": self.folder / "watched"})
        self.assertEqual(usage.stdout, "done\n")
        self.assertGreater(usage.cpu_seconds, 0.01)
        self.assertGreater(usage.seconds, 0.5)
        # Although the file has no name any more.
        self.assertGreaterEqual(usage.peak_disk["temp"], 3 << 20)
        self.assertEqual(usage.peak_disk["all"], usage.peak_disk["temp"])
        if usage.bytes_written is not None:
            self.assertTrue(3 << 20 <= usage.bytes_written < 4 << 20, usage.bytes_written)

    def test_says_how_a_process_failed(self):
        with self.assertRaisesRegex(process.RunFailed, "exit code 3: last words"):
            process.run_measured(["sh", "-c", "echo last words >&2; exit 3"], self.folder)
        with self.assertRaisesRegex(process.RunFailed, "signal 9"):
            process.run_measured(["sh", "-c", "kill -9 $$"], self.folder)
        with self.assertRaisesRegex(process.RunFailed, "cannot be started"):
            process.run_measured([self.folder / "nothing"], self.folder)


class Results(Folder):
    def test_replaces_rows_in_place_and_returns_what_was_stored(self):
        table = results.Table(self.folder / "t.csv")
        table.replace([{"model": m, "run": "map", "status": "ok", "seconds": 1.5, "vertices": 7} for m in "abc"])
        table.replace([{"model": "b", "run": "map", "status": "exit code 5: no, \"too small\""},
                       {"model": "d", "run": "map", "status": "ok"}])
        again = results.Table(self.folder / "t.csv")
        self.assertEqual(again.models(), ["a", "b", "c", "d"])
        self.assertEqual(again.find("a", "map")["seconds"], 1.5)
        self.assertEqual(again.find("a", "map")["vertices"], 7)
        self.assertIsNone(again.find("a", "map")["l2"])
        self.assertIsNone(again.find("b", "map"))
        self.assertEqual(again.rows[1]["status"], "exit code 5: no, \"too small\"")

    def test_ratios_are_made_within_a_session_only(self):
        a, b = ({"session": "noon", "cpu_seconds": seconds} for seconds in (3.0, 2.0))
        self.assertEqual(tables.ratio(a, b, "cpu_seconds"), "1.50")
        self.assertEqual(tables.ratio(a, {**b, "session": "night"}, "cpu_seconds"), tables.NONE)
        self.assertEqual(tables.ratio(a, None, "cpu_seconds"), tables.NONE)

    def test_goals_show_the_worst_of_the_tables(self):
        def row(model, run, **cells):
            return {"model": model, "run": run, "status": "ok", "session": "noon", "vertices": 14_400_000,
                    "input_bytes": 10**6, "bytes_read": 5 * 10**6, "bytes_written": 10**6, "peak_temp": 10**6,
                    "peak_rss": 9 * 2**20, "memory_budget": 7 * 2**20, "output_faces": 8, "l2": 1e-4, **cells}
        results.Table(self.folder / "standard.csv").replace([
            row("g14", "map", cpu_seconds=10.0), row("g14", "meshoptimizer", cpu_seconds=8.0, memory_budget=None),
            row("g1", "map", cpu_seconds=0.8, vertices=1_440_000),
            row("g1", "meshoptimizer", cpu_seconds=0.1, vertices=1_440_000, memory_budget=None)])
        results.Table(self.folder / "memory.csv").replace([
            row("g14", "threads 1", seconds=9.0), row("g14", "threads 2", seconds=5.0),
            row("earth1", "threads 1", seconds=8.0), row("earth1", "threads 2", seconds=5.0)])
        text = goals.table(self.folder)
        self.assertRegex(text, r"above the budget.* \| 2 \| ")
        self.assertRegex(text, r"with map and error \| 1\.25 \| g14 ")
        self.assertRegex(text, r"CPU a vertex.* \| 1\.25 \| g14 to g1 ")
        self.assertRegex(text, r"bytes read and written.* \| 6\.0 \| g14 ")
        self.assertRegex(text, r"speed of two threads.* \| 1\.60 \| earth1 ")
        self.assertRegex(text, r"shuffled.* \| – \| not measured yet ")

    def test_thinned_traces_keep_their_peak(self):
        trace = [(i / 10, 100 + (i * 7919) % 1000) for i in range(500)]
        thin = results.thinned(trace)
        self.assertEqual(len(thin), results.TRACE_POINTS)
        self.assertEqual(max(b for _, b in thin), max(b for _, b in trace))
        self.assertEqual(thin, sorted(thin))


class Models(Folder):
    def volume_file(self, size, values, kind=2):
        header = bytearray(352)
        struct.pack_into("<i", header, 0, 348)
        struct.pack_into("<8h", header, 40, 3, *size, 1, 1, 1, 1)
        struct.pack_into("<h", header, 70, kind)
        struct.pack_into("<8f", header, 76, 1, -0.5, 1, 2, 0, 0, 0, 0)
        struct.pack_into("<f", header, 108, 352)
        path = self.folder / "volume.nii.gz"
        path.write_bytes(gzip.compress(bytes(header) + values))
        return path

    def test_reads_volumes_and_refuses_damaged_ones(self):
        volume = nifti.read_volume(self.volume_file((2, 3, 4), bytes(range(24))))
        self.assertEqual((volume.size, volume.spacing), ((2, 3, 4), (0.5, 1.0, 2.0)))
        self.assertEqual(volume.values, bytes(range(24)))
        with self.assertRaisesRegex(ValueError, "ends before its last voxel"):
            nifti.read_volume(self.volume_file((2, 3, 4), bytes(23)))
        with self.assertRaisesRegex(ValueError, "expected unsigned bytes"):
            nifti.read_volume(self.volume_file((2, 3, 4), bytes(48), kind=4))

    def test_isosurfaces_of_noise_are_closed_manifolds(self):
        if not PROGRAMS:
            self.skipTest("bench/ is not built")
        for seed in range(3):
            volume, mesh = self.folder / "noise.raw", self.folder / "noise.ply"
            volume.write_bytes(random.Random(seed).randbytes(9 * 10 * 11))
            subprocess.run([BUILD / "bench/isosurface", volume, "9", "10", "11", "1", "1", "1", "127.5", mesh],
                           check=True)
            # remaps refuses what is no oriented manifold.
            done = subprocess.run([BUILD / "cli/remaps", "parameterize", mesh, self.folder / "noise.remaps", "--json",
                                   "--quiet"], stdout=subprocess.PIPE, check=True)
            self.assertEqual(json.loads(done.stdout)["input"]["boundary_loops"], 0)


if __name__ == "__main__":
    BUILD = Path(sys.argv.pop(1)).resolve()
    PROGRAMS = "--programs" in sys.argv
    if PROGRAMS:
        sys.argv.remove("--programs")
    unittest.main()

#!/usr/bin/env python3
"""Checks the pure parts of the codec's benchmark, and with --programs all of it on a mesh of 5,000 vertices.

    codec_bench_test.py BUILD [--programs]

BUILD is a build tree with the binary; --programs says that bench/ was built there too, with the peers.
"""

import csv
import math
import random
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BENCH = ROOT / "bench"
sys.path.insert(0, str(BENCH))

import codec_page  # noqa: E402  (found by the line above)
import codec_runs  # noqa: E402
import plot_rate  # noqa: E402
import rate_distortion as rd  # noqa: E402
import results  # noqa: E402
import run_codec  # noqa: E402

BUILD = Path()
PROGRAMS = False
SVG = "{http://www.w3.org/2000/svg}"


def points(*pairs):
    return [{"bytes": taken, "psnr": psnr} for taken, psnr in pairs]


class Folder(unittest.TestCase):
    """A test with a directory of its own."""

    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.folder = Path(directory.name)


class Distortion(unittest.TestCase):
    def test_psnr_of_errors(self):
        self.assertAlmostEqual(rd.psnr_db(1e-4), 80)
        self.assertAlmostEqual(rd.psnr_db(0.5e-4) - rd.psnr_db(1e-4), 20 * math.log10(2))
        self.assertEqual(rd.psnr_db(0), math.inf)

    def test_takes_the_larger_direction_of_a_report(self):
        self.assertEqual(rd.l2_of({"l2_forward": 1e-4, "l2_backward": 3e-4, "l2": 1e-4}), 3e-4)
        self.assertEqual(rd.l2_of({"l2_forward": 4e-4, "l2_backward": 3e-4}), 4e-4)

    def test_refuses_reports_without_an_error(self):
        with self.assertRaises(KeyError):
            rd.l2_of({"l2_forward": 1e-4})
        for bad in (math.nan, math.inf, -1e-4):
            with self.assertRaises(ValueError):
                rd.l2_of({"l2_forward": bad, "l2_backward": bad})


class Envelope(unittest.TestCase):
    def test_leaves_out_what_is_beaten_in_fewer_bytes(self):
        cloud = points((30, 70), (10, 60), (20, 58), (10, 55), (40, 70), (50, 71))
        self.assertEqual(rd.upper_envelope(cloud), points((10, 60), (30, 70), (50, 71)))
        self.assertEqual(rd.upper_envelope([]), [])

    def test_agrees_with_the_best_within_every_size(self):
        for seed in range(20):
            source = random.Random(seed)
            cloud = points(*((source.randrange(50), source.randrange(50)) for _ in range(30)))
            envelope = rd.upper_envelope(cloud)
            for size in range(-1, 52):
                best, held = rd.best_within(cloud, size), rd.best_within(envelope, size)
                self.assertEqual(best and best["psnr"], held and held["psnr"], f"seed {seed}, size {size}")

    def test_the_best_of_equals_is_the_shortest(self):
        self.assertEqual(rd.best_within(points((9, 60), (5, 60), (7, 60)), 9)["bytes"], 5)
        self.assertIsNone(rd.best_within(points((9, 60)), 8))

    def test_the_largest_fall_counts_from_the_highest_before(self):
        self.assertEqual(rd.largest_fall(points((1, 60), (2, 61), (3, 61))), 0)
        self.assertAlmostEqual(rd.largest_fall(points((1, 60), (4, 59.25), (2, 60.5), (3, 60))), 1.25)


class Searching(unittest.TestCase):
    def test_finds_nearly_the_most_faces_that_fit(self):
        for exponent in (0.8, 0.95, 1.0, 1.1):
            for size in (700, 5_000, 90_000):
                def code(faces, exponent=exponent):
                    return round(60 + 2.5 * faces**exponent)
                for guess in (10, 3_000, 10**6):
                    faces = rd.most_faces_within(code, size, 10**6, guess)
                    self.assertLessEqual(code(faces), size)
                    self.assertGreater(code(faces), 0.98 * size - 8, (exponent, size, guess))

    def test_takes_all_faces_where_they_fit_and_none_where_nothing_does(self):
        self.assertEqual(rd.most_faces_within(lambda n: 2 * n, 10**6, 500, 9), 500)
        self.assertIsNone(rd.most_faces_within(lambda n: 100 + n, 100, 500, 9))

    def test_asks_little(self):
        asked = []
        rd.most_faces_within(lambda n: asked.append(n) or round(60 + 1.3 * n**0.97), 40_000, 10**6, 20_000)
        self.assertLessEqual(len(asked), 4)

    def test_climbs_to_the_peak_and_asks_once(self):
        for peak in range(6, 17):
            for start in range(6, 17):
                asked = []
                best = rd.climb(lambda i, peak=peak: asked.append(i) or -abs(i - peak), start, 6, 16)
                self.assertEqual(best, peak)
                self.assertEqual(len(asked), len(set(asked)))
                self.assertTrue({peak - 1, peak, peak + 1} & set(range(6, 17)) <= set(asked))

    def test_climbs_down_from_where_nothing_fits(self):
        self.assertEqual(rd.climb(lambda i: i if i < 9 else None, 12, 6, 16), 8)
        self.assertIsNone(rd.climb(lambda i: None, 12, 6, 16))


class Choosing(unittest.TestCase):
    def rows(self, base, *psnrs, status="ok"):
        return [{"run": codec_runs.ours(base), "status": status, "size": size, "base_vertices": base, "psnr": psnr}
                for size, psnr in zip((5_000, 10_000), psnrs)]

    def test_takes_the_best_base_on_average(self):
        rows = self.rows(50, 70, 70) + self.rows(100, 69, 72) + self.rows(200, 99, 99, status="exit code 5")
        self.assertEqual(codec_runs.chosen_base(rows, (5_000, 10_000)), 100)

    def test_takes_no_base_that_lacks_a_size(self):
        rows = self.rows(50, 70, 75) + [self.rows(400, 0, 90)[1]]
        self.assertEqual(codec_runs.chosen_base(rows, (5_000, 10_000)), 50)
        self.assertIsNone(codec_runs.chosen_base([], (5_000,)))


class Figure(unittest.TestCase):
    def draw(self, limit):
        curves = plot_rate.curves_of(points((5_000, 70), (90_000, 90)), [("remaps, base <50>", points((5_000, 69)))],
                                     points((4_990, 64), (89_000, 85)), points((100_000, 80)))
        return xml.etree.ElementTree.fromstring(plot_rate.draw("a & b", curves, limit, "limit"))

    def test_draws_every_curve_within_the_axes(self):
        root = self.draw(95.0)
        labels = [text.text for text in root.findall(f"{SVG}text")]
        for label in ("remaps", "decimated × Draco, best", "Draco, full mesh", "remaps, base <50>", "a & b",
                      "PSNR, dB", "10 kB", "50 kB", "80", "limit: 95.0 dB"):
            self.assertIn(label, labels)
        circles = root.findall(f"{SVG}circle")
        self.assertEqual(len(circles), 5)
        for circle in circles:
            self.assertTrue(plot_rate.LEFT <= float(circle.get("cx")) <= plot_rate.LEFT + plot_rate.PLOT_WIDTH)
            self.assertTrue(plot_rate.TOP <= float(circle.get("cy")) <= plot_rate.TOP + plot_rate.PLOT_HEIGHT)

    def test_names_a_limit_that_is_far_above(self):
        labels = [text.text for text in self.draw(120.0).findall(f"{SVG}text")]
        self.assertIn("limit: 120.0 dB, above this figure", labels)

    def test_labels_keep_apart_and_inside(self):
        for seed in range(20):
            source = random.Random(seed)
            places = plot_rate.spread([source.uniform(0, 200) for _ in range(8)], 0, 200)
            self.assertTrue(all(-1e-9 <= place <= 200 for place in places), f"seed {seed}")
            for a, b in zip(sorted(places), sorted(places)[1:]):
                self.assertGreaterEqual(b - a, plot_rate.LABEL_HEIGHT - 1e-9, f"seed {seed}")


class Page(Folder):
    def row(self, run, **cells):
        return {"set": "small", "model": "cow", "run": run, "status": "ok", "session": "now", "revision": "abc",
                "machine": "m", "vertices": 1000, "faces": 2000, "command": "remaps encode", **cells}

    def write(self, rows):
        stored = results.Table(self.folder / "codec.csv", run_codec.COLUMNS, key=("model",))
        stored.replace(rows)
        codec_page.write(results.Table(self.folder / "codec.csv", run_codec.COLUMNS, key=("model",)), self.folder)
        return (self.folder / "rate-distortion.md").read_text(encoding="utf-8")

    def test_shows_both_their_difference_and_the_limit(self):
        page = self.write([
            self.row(codec_runs.ours(100), size=5000, bytes=5000, psnr=70.04, l2=3.1e-4, base_vertices=100, level=4),
            self.row(codec_runs.ours(50), size=5000, bytes=5000, psnr=68.0, l2=4e-4, base_vertices=50, level=4),
            self.row(codec_runs.RIVAL, size=5000, bytes=4990, psnr=64.0, l2=6.3e-4, coded_faces=1500, bits=9),
            self.row(codec_runs.FULL, bytes=4000, psnr=66.0, l2=5e-4, coded_faces=2000, bits=8),
            self.row(codec_runs.LIMIT, psnr=99.0, l2=1e-5, base_vertices=100, level=4),
            self.row(codec_runs.DECODE, base_vertices=100, bytes=9000, level=4, output_vertices=4_000_000,
                     cpu_seconds=1.6, repeats=3, peak_rss=50 << 20),
            self.row(codec_runs.ENCODE, status="exit code 5: too small"),
        ])
        self.assertIn("| cow | 1,000 | 70.0 / 66.0 / **+4.0** | ", page)
        self.assertIn("| 99.0 |", page)
        self.assertIn("2,000 × 8", page)
        self.assertIn("50: 68.00; 100: 70.04", page)
        self.assertIn("1.60 | 2.50 M | 50 | 3 |", page)
        self.assertIn("* cow, encode: exit code 5: too small", page)
        self.assertNotIn("{{", page)

    def test_is_written_where_nothing_or_only_failures_were_measured(self):
        codec_page.write(results.Table(self.folder / "none.csv", run_codec.COLUMNS), self.folder)
        self.assertIn("Not measured yet", (self.folder / "rate-distortion.md").read_text(encoding="utf-8"))
        page = self.write([self.row(codec_runs.CHECK, status="exit code 3: no", vertices=None, faces=None)])
        self.assertIn("* cow, check: exit code 3: no", page)


class Driver(Folder):
    def bench(self, *arguments):
        command = [sys.executable, BENCH / "run_codec.py", *arguments, "--samples", "5k", "--repeat", "1", "--build",
                   BUILD, "--cache", self.folder / "cache", "--results", self.folder / "results", "--docs",
                   self.folder / "docs"]
        return subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)

    def test_measures_a_mesh_and_writes_the_page(self):
        if not PROGRAMS:
            self.skipTest("bench/ is not built")
        done = self.bench("large", "tiny", "--sizes", "3000", "5000", "--bases", "20", "40")
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.folder / "results/codec.csv", newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertLessEqual({codec_runs.RIVAL, codec_runs.FULL, codec_runs.LIMIT, codec_runs.ENCODE,
                              codec_runs.DECODE, codec_runs.ours(20), codec_runs.ours(40)},
                             {row["run"] for row in rows})
        for row in rows:
            self.assertEqual(row["status"], "ok", row)
            if row["size"] and row["run"] == codec_runs.RIVAL:
                self.assertTrue(0.9 * int(row["size"]) < int(row["bytes"]) <= int(row["size"]), row)
            if row["psnr"]:
                self.assertTrue(30 < float(row["psnr"]) < 200, row)
        page = (self.folder / "docs/rate-distortion.md").read_text(encoding="utf-8")
        self.assertIn("## Large meshes", page)
        self.assertIn("--base-vertices", page)
        root = xml.etree.ElementTree.parse(self.folder / "docs/images/rate-tiny.svg").getroot()
        self.assertGreater(len(root.findall(f"{SVG}circle")), 5)
        self.assertEqual(list((self.folder / "cache").iterdir()), [self.folder / "cache/models"])

    def test_refuses_what_is_no_mesh(self):
        done = self.bench(self.folder / "nothing.ply")
        self.assertEqual(done.returncode, 2)
        self.assertIn("neither a file nor a model", done.stderr)
        bad = self.folder / "bad.ply"
        bad.write_text("no mesh")
        done = self.bench(bad)
        self.assertEqual(done.returncode, 1)
        self.assertIn("bad: write_plain_mesh" if PROGRAMS else "cannot be started", done.stderr)


if __name__ == "__main__":
    BUILD = Path(sys.argv.pop(1)).resolve()
    PROGRAMS = "--programs" in sys.argv
    if PROGRAMS:
        sys.argv.remove("--programs")
    unittest.main()

"""Checks what tools/survey.py makes of a program that behaves well or badly, as the file tells it to."""

import csv
import pathlib
import subprocess
import sys
import tempfile
import unittest

try:
    import numpy  # noqa: F401
except ImportError:
    print("skipped: this Python has no numpy")
    sys.exit(77)

SURVEY = pathlib.Path(__file__).resolve().parents[2] / "tools" / "survey.py"

# Stands in for remaps. The first line of a "mesh" says what is to become of it.
FAKE = """#!{python}
import json, os, pathlib, signal, struct, sys, time
verb, mesh, *rest = sys.argv[1:]
if verb != "remesh":
    sys.exit(2)
deed = pathlib.Path(mesh).read_text().split()[0]
output, report = pathlib.Path(rest[0]), pathlib.Path(rest[rest.index("--report") + 1])
faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
if deed == "pinched":
    faces += [tuple(v and v + 3 for v in face) for face in faces]
if deed == "turned":
    faces[0] = (0, 1, 2)
count = 1 + max(map(max, faces))
said = {{"vertices": 4, "faces": 4, "components": 2 if deed == "lying" else 1, "boundary_loops": 0,
        "euler_characteristic": 2}}
peak = 100 << 20 if deed == "greedy" else 10 << 20
text = {{"input": said, "repairs": {{"duplicate_faces": 7 if deed == "dirty" else 0}},
        "base": {{"vertices": count, "faces": len(faces)}}, "output": {{"vertices": count, "faces": len(faces)}},
        "error": {{"l2": 1e-4, "max_forward": 1e-3, "max_backward": 2e-3}}, "seconds": {{"total": 0.1}},
        "peak_rss_bytes": peak, "memory_budget_bytes": 32 << 20}}
data = ("ply\\nformat binary_little_endian 1.0\\nelement vertex %d\\nproperty float x\\nproperty float y\\n"
        "property float z\\nelement face %d\\nproperty list uchar int vertex_indices\\nend_header\\n"
        % (count, len(faces))).encode()
data += b"".join(struct.pack("<3f", v, 0, 0) for v in range(count))
data += b"".join(struct.pack("<B3i", 3, *face) for face in faces)
if deed in ("untidy", "cut"):
    data = data[:-5]
if deed not in ("refused", "mute", "silent", "crash", "hang", "odd"):
    output.write_bytes(data)
    report.write_text(json.dumps(text))
if deed in ("refused", "untidy", "vague"):
    report.unlink(missing_ok=True)
    if deed != "untidy":
        output.unlink(missing_ok=True)
    print("remaps: error: " + ("no" if deed == "vague" else mesh + ": line 3: expected a face"), file=sys.stderr)
    sys.exit(3)
if deed == "crash":
    os.kill(os.getpid(), signal.SIGSEGV)
if deed == "hang":
    time.sleep(600)
sys.exit({{"odd": 9, "mute": 4}}.get(deed, 0))
"""

EXPECTED = {
    "good": ("handled", ""),
    "dirty": ("repaired", "7 duplicate faces"),
    "refused": ("refused", "refused.off: line 3: expected a face"),
    "vague": ("refused", "no"),
    "mute": ("BAD", "refused without a message"),
    "silent": ("BAD", "exit code 0 without output and report"),
    "untidy": ("BAD", "left behind: out.ply"),
    "cut": ("BAD", "the output is malformed"),
    "pinched": ("BAD", "1 vertices where fans touch"),
    "turned": ("BAD", "opposite orientation"),
    "lying": ("BAD", "1 components instead of 2"),
    "greedy": ("BAD", "36 MiB of memory more than allowed"),
    "crash": ("BAD", "signal 11"),
    "odd": ("BAD", "exit code 9"),
    "hang": ("BAD", "no end after 5 s"),
}


class Survey(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.directory = tempfile.TemporaryDirectory()
        root = pathlib.Path(cls.directory.name)
        fake = root / "fake"
        fake.write_text(FAKE.format(python=sys.executable))
        fake.chmod(0o755)
        meshes = root / "meshes"
        (meshes / "inner").mkdir(parents=True)
        for deed in EXPECTED:
            (meshes / f"{deed}.off").write_text(f"{deed}\n")
        packed = meshes / "inner" / "packed.off"
        packed.write_text("good\n")
        subprocess.run(["zstd", "-q", "--rm", packed], check=True)
        cls.done = subprocess.run(
            [sys.executable, SURVEY, meshes, "--remaps", fake, "--level", "0", "--seconds", "5", "--csv",
             root / "all.csv", "--markdown", root / "all.md", "--", "--memory", "32M"],
            capture_output=True, text=True, check=False)
        with open(root / "all.csv", encoding="utf-8", newline="") as file:
            cls.rows = {row["file"]: row for row in csv.DictReader(file)}
        cls.markdown = (root / "all.md").read_text()

    @classmethod
    def tearDownClass(cls):
        cls.directory.cleanup()

    def test_judges_every_kind_of_end(self):
        for deed, (result, what) in EXPECTED.items():
            row = self.rows[f"{deed}.off"]
            self.assertEqual(row["result"], result, (deed, row["what"]))
            self.assertIn(what, row["what"])

    def test_unpacks_files_and_names_them_by_their_folder(self):
        self.assertEqual(self.rows["inner/packed.off.zst"]["result"], "handled")

    def test_counts_by_folder(self):
        self.assertIn("| meshes | 16 | 2 | 1 | 2 | 11 |", self.markdown)
        self.assertIn("2 handled, 1 repaired, 2 refused, 11 BAD of 16 files", self.done.stdout)

    def test_ends_with_1_when_something_is_bad(self):
        self.assertEqual(self.done.returncode, 1, self.done.stderr)

    def test_tells_refusals_that_name_no_place(self):
        self.assertIn("vague  meshes/vague.off: no", self.done.stdout)
        self.assertNotIn("vague  meshes/refused.off", self.done.stdout)

    def test_names_no_folder_of_the_machine(self):
        self.assertIn("`tools/survey.py MESHES/meshes --level 0 -- --memory 32M`", self.markdown)
        for text in (self.markdown, str(self.rows)):
            self.assertNotIn(self.directory.name, text)
            self.assertNotIn(tempfile.gettempdir() + "/", text)


if __name__ == "__main__":
    unittest.main()

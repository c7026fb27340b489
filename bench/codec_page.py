"""docs/rate-distortion.md and its figures, from bench/results/codec.csv and the text in rate_distortion.md."""

import re
from pathlib import Path

import plot_rate
import rate_distortion as rd
from codec_runs import DECODE, ENCODE, FULL, LIMIT, RIVAL, chosen_base, ours
from tables import NONE

TEMPLATE = Path(__file__).resolve().parent / "rate_distortion.md"
PLACE = re.compile(r"\{\{(\w+)\}\}")
TABLE_SIZES = (5_000, 10_000, 20_000, 40_000, 90_000)
GOALS = {ENCODE: 0.5e6, DECODE: 2e6}  # output vertices a second and core


class Measured:
    """What the table has of one mesh."""

    def __init__(self, name, rows):
        self.name = name
        self.rows = [row for row in rows if row["model"] == name]
        sound = [row for row in self.rows if row["status"] == "ok"]
        self.set, self.vertices, self.faces = (self.rows[0][key] for key in ("set", "vertices", "faces"))
        measured = {row["size"] for row in sound if row["size"] is not None}
        self.sizes = measured & set(TABLE_SIZES) or measured  # that the base was chosen by
        self.base = chosen_base(sound, self.sizes)
        self.archive = self._of(sound, ours(self.base))
        self.decimated, self.full = self._of(sound, RIVAL), self._of(sound, FULL)
        self.limit = next(iter(self._of(sound, LIMIT)), None)
        self.times = {what: next(iter(self._of(sound, what)), None) for what in (ENCODE, DECODE)}
        self.bases = sorted({row["base_vertices"] for row in sound if row["run"].startswith("remaps, ")})

    @staticmethod
    def _of(rows, run):
        return [row for row in rows if row["run"] == run]

    def archive_of(self, base):
        return [row for row in self.rows if row["run"] == ours(base) and row["status"] == "ok"]

    def rival(self, size):
        return rd.best_within(self.decimated + self.full, size)

    def ours(self, size):
        return rd.best_within(self.archive, size)

    def difference(self, size):
        mine, theirs = self.ours(size), self.rival(size)
        return None if mine is None or theirs is None else mine["psnr"] - theirs["psnr"]


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def decibels(point):
    return NONE if point is None else f"{point['psnr']:.1f}"


def counted(count):
    return NONE if count is None else f"{count:,}"


def l2_text(l2):
    return f"{1e4 * l2:.2f}"


def psnr_table(meshes):
    rows = []
    for mesh in meshes:
        cells = [mesh.name, counted(mesh.vertices)]
        for size in TABLE_SIZES:
            difference = mesh.difference(size)
            sign = NONE if difference is None else f"**{difference:+.1f}**"
            cells.append(f"{decibels(mesh.ours(size))} / {decibels(mesh.rival(size))} / {sign}")
        rows.append(cells + [decibels(mesh.limit)])
    return table(["mesh", "vertices", *(f"{size:,} bytes" for size in TABLE_SIZES), "unquantized"], rows)


def differences_text(meshes):
    found = [(mesh.difference(size), mesh.name, size) for mesh in meshes for size in TABLE_SIZES
             if mesh.difference(size) is not None]
    if not found:
        return ""
    mean = sum(d for d, _, _ in found) / len(found)
    least, name, size = min(found)
    up_to_40k = [d for d, _, size in found if size <= 40_000]
    below = f", {sum(up_to_40k) / len(up_to_40k):+.1f} dB up to 40,000 bytes" if up_to_40k else ""
    return (f"On average over the {len(found)} cells {mean:+.1f} dB{below}; the least is {least:+.1f} dB, of {name} at "
            f"{size:,} bytes.")


def l2_table(meshes):
    rows = [[mesh.name, *(NONE if (p := mesh.ours(size)) is None else l2_text(p["l2"]) for size in TABLE_SIZES),
             NONE if mesh.limit is None else l2_text(mesh.limit["l2"])] for mesh in meshes]
    return table(["mesh", *(f"{size:,}" for size in TABLE_SIZES), "unquantized"], rows)


def choices_table(meshes):
    rows = []
    for mesh in meshes:
        levels = sorted({row["level"] for row in mesh.archive})
        means = []
        for base in mesh.bases:
            points = [row["psnr"] for row in mesh.archive_of(base) if row["size"] in mesh.sizes]
            means.append(f"{base}: {sum(points) / len(points):.2f}" if points else f"{base}: {NONE}")
        rows.append([mesh.name, f"{mesh.base or NONE}", ", ".join(map(str, levels)), "; ".join(means),
                     f"{rd.largest_fall(mesh.archive):.2f}"])
    return table(["mesh", "base", "level", "mean PSNR by base asked for", "largest fall, dB"], rows)


def commands_text(meshes):
    """The commands that made the archives, with N for the base; those of all meshes are one, as a rule."""
    found = {}
    for mesh in meshes:
        if mesh.archive:
            text = mesh.archive[0]["command"]
            for old, new in ((f"{mesh.name}.plain.ply", "MESH.ply"), (f"base-{mesh.base}.", "N."),
                             (f"--base-vertices {mesh.base}", "--base-vertices N"), (f" --temp-dir {mesh.name}", ""),
                             (" --json", ""), (" --quiet", "")):
                text = text.replace(old, new)
            found.setdefault(text, []).append(mesh.name)
    return "\n\n".join(f"`{text}`" + (f" ({', '.join(names)})" if len(found) > 1 else "")
                       for text, names in found.items())


def rivals_table(meshes):
    rows = []
    for mesh in meshes:
        cells = [mesh.name]
        for size in TABLE_SIZES:
            best = mesh.rival(size)
            cells.append(NONE if best is None else f"{best['coded_faces']:,} × {best['bits']}")
        rows.append(cells)
    return table(["mesh", *(f"{size:,}" for size in TABLE_SIZES)], rows)


def speed_table(meshes):
    rows = []
    for mesh in meshes:
        cells = [mesh.name]
        for what in (ENCODE, DECODE):
            row = mesh.times[what]
            cells += [NONE] * 3 if row is None else [
                f"{row['cpu_seconds']:.2f}", f"{row['output_vertices'] / row['cpu_seconds'] / 1e6:.2f} M",
                f"{row['peak_rss'] / 2**20:.0f}"]
        row = mesh.times[DECODE] or mesh.times[ENCODE]
        rows.append([cells[0], NONE if row is None else f"{row['output_vertices']:,}",
                     NONE if row is None else f"{row['bytes']:,}", *cells[1:],
                     NONE if row is None else f"{row['repeats']}"])
    return table(["mesh", "output vertices", "archive bytes", "encode CPU s", "vertices/s", "peak MiB",
                  "decode CPU s", "vertices/s", "peak MiB", "runs"], rows)


def failures(meshes):
    lines = [f"* {mesh.name}, {row['run']}: {row['status']}" for mesh in meshes for row in mesh.rows
             if row["status"] != "ok"]
    return "No result:\n\n" + "\n".join(lines) if lines else ""


def draw(mesh, folder):
    """The file of a mesh's figure; None if there is nothing to draw."""
    if not (mesh.archive or mesh.decimated):
        return None
    largest = max((row["bytes"] for row in mesh.archive + mesh.decimated if row["size"] is not None), default=0)
    others = [(f"remaps, base {base}", mesh.archive_of(base)) for base in mesh.bases if base != mesh.base]
    decimated = [point for size in sorted({row["size"] for row in mesh.decimated})
                 if (point := rd.best_within(mesh.decimated, size)) is not None]
    curves = plot_rate.curves_of(mesh.archive, others, rd.upper_envelope(decimated),
                                 [row for row in mesh.full if row["bytes"] <= 2 * largest])
    label = "" if mesh.limit is None else f"remesh of level {mesh.limit['level']}, unquantized"
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"rate-{mesh.name}.svg"
    path.write_text(plot_rate.draw(f"{mesh.name}: {mesh.vertices:,} vertices, {mesh.faces:,} faces", curves,
                                   mesh.limit and mesh.limit["psnr"], label), encoding="utf-8")
    return path


def figures(meshes, docs):
    links = [f"![PSNR over bytes of {mesh.name}](images/{path.name})" for mesh in meshes
             if (path := draw(mesh, docs / "images"))]
    return "\n\n".join(links)


def section(title, meshes, docs):
    notes = {(row["session"], row["revision"], row["machine"]) for mesh in meshes for row in mesh.rows}
    said = "; ".join(f"{revision or 'unknown revision'}, {session.replace('T', ' ')}, {machine}"
                     for session, revision, machine in sorted(notes))
    parts = [f"## {title}", "PSNR in dB, **remaps / best rival / difference**:", psnr_table(meshes),
             differences_text(meshes), "L2 of remaps in 1e-4 of the diagonal:", l2_table(meshes),
             "The archives were made by the following, with the base N that is best on average over the sizes above:",
             commands_text(meshes), choices_table(meshes),
             "What the best rival is, faces × bits of quantization:", rivals_table(meshes),
             "Speed, on one core:", speed_table(meshes), failures(meshes), f"*{said}*", figures(meshes, docs)]
    return "\n\n".join(part for part in parts if part)


def write(stored, docs):
    """Writes rate-distortion.md and its images."""
    meshes = [Measured(name, stored.rows) for name in stored.models()]
    sections = [section(title, of, docs) for key, title in (("small", "Scans"), ("large", "Large meshes"))
                if (of := [mesh for mesh in meshes if mesh.set == key])]
    filled = {"sections": "\n\n".join(sections) or "Not measured yet: `./dev bench codec`.",
              "encode_goal": f"{GOALS[ENCODE] / 1e6:g} M", "decode_goal": f"{GOALS[DECODE] / 1e6:g} M"}
    docs.mkdir(parents=True, exist_ok=True)
    text = PLACE.sub(lambda match: filled[match.group(1)], TEMPLATE.read_text(encoding="utf-8"))
    (docs / "rate-distortion.md").write_text(text, encoding="utf-8")

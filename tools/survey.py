#!/usr/bin/python3
"""Runs every file of some folders through remaps, and says what became of each.

    tools/survey.py MESHES/scans MESHES/broken --markdown docs/survey.md --csv out/survey.csv
    tools/survey.py MESHES/scans --markdown docs/survey-48m.md -- --memory 48M --domain-buffer 5000

Each file is given to `remaps check FILE --json`, where there is that verb, and to `remaps remesh FILE out.ply
--level 3`; what follows `--` is passed on to the latter. A file is

    handled    exit code 0, and a counter of its own (mesh_topology.py) finds the output to be a manifold with
               the components, boundary loops and Euler characteristic that the report states for the input
    repaired   the same, and the report counts repairs
    refused    exit code 3, 4 or 5, a message, and no file left behind
    BAD        anything else: a signal, no end, another exit code, no output, a wrong one

Files ending in .zst are unpacked to the scratch folder first, unless remaps reads them. Names in the
tables are relative to the folders. Needs numpy and zstd. Exit code 1 if anything is BAD.
"""

import argparse
import collections
import concurrent.futures
import csv
import dataclasses
import json
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

import mesh_topology

REFUSALS = {3: "input", 4: "geometry", 5: "memory or disk"}
CODE_MIB = 32  # of program and libraries, beyond --memory
# glTF files have JSON paths for places: asset, meshes[0].primitives[1].
PLACE = re.compile(r"\b(byte|line|header|vertex|face|edge|accessor|node|mesh|facet|asset|scene)\b|\w\[\d+\]")
TETRAHEDRON = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n"


@dataclasses.dataclass
class Outcome:
    folder: str
    name: str
    size: int = 0
    result: str = ""  # handled, repaired, refused or BAD
    what: str = ""  # repairs, the reason of a refusal, or what is bad
    exit_code: int | None = None  # negative: a signal; None: stopped after the time allowed
    check_code: int | None = None
    report: dict = dataclasses.field(default_factory=dict)
    messages: str = ""


@dataclasses.dataclass
class Settings:
    remaps: str
    level: int
    seconds: float
    options: list
    scratch: pathlib.Path
    checks: bool = False
    reads_zst: bool = False


def run(command, seconds):
    """(exit code or None, standard output, standard error) of a command that may take so long."""
    try:
        done = subprocess.run(list(map(str, command)), stdin=subprocess.DEVNULL, capture_output=True, text=True,
                              errors="replace", timeout=seconds, check=False)
        return done.returncode, done.stdout, done.stderr
    except subprocess.TimeoutExpired:
        return None, "", ""


def with_defaults(options):
    """One thread a file, and no more samples of the error than a glance needs, unless asked otherwise."""
    given = [] if "--threads" in options else ["--threads", "1"]
    given += [] if "--samples" in options else ["--samples", "100k"]
    return [*given, *options]


def look_at_binary(settings):
    """Finds out what this binary can do."""
    with tempfile.TemporaryDirectory(dir=settings.scratch) as directory:
        mesh = pathlib.Path(directory) / "mesh.off"
        mesh.write_text(TETRAHEDRON)
        settings.checks = run([settings.remaps, "check", mesh, "--json"], 60)[0] == 0
        subprocess.run(["zstd", "-q", mesh], check=True)
        settings.reads_zst = run([settings.remaps, "info", f"{mesh}.zst"], 60)[0] == 0


def prepare(path, directory, settings):
    """The file to give to remaps: the path itself, or unpacked into the directory."""
    if path.suffix != ".zst" or settings.reads_zst:
        return path
    unpacked = directory / path.stem
    subprocess.run(["zstd", "-q", "-d", path, "-o", unpacked], check=True)
    return unpacked


def last_error(messages, path, directory, name):
    """The error of a run, without the names of this machine's folders."""
    lines = [line for line in messages.splitlines() if line.strip()]
    errors = [line for line in lines if line.startswith("remaps: error: ")]
    text = (errors or lines or [""])[-1].removeprefix("remaps: ").removeprefix("error: ")
    for machine in (str(path), str(directory / pathlib.Path(name).name)):
        text = text.replace(machine, pathlib.Path(name).name)
    return text.replace(f"{directory}/", "").replace(f"{path.parent}/", "")


def wrong_output(output, report, level):
    """What is wrong with the output, by the counter's own count; nothing if all is well."""
    try:
        positions, triangles = mesh_topology.read_ply(output)
        found = mesh_topology.count_topology(triangles, len(positions))
    except ValueError as error:
        return [f"the output is malformed: {error}"]
    wrong = list(found.defects)
    expected = {
        "vertices": (len(positions), report["output"]["vertices"]),
        "faces": (found.faces, report["output"]["faces"]),
        "faces, by the base": (found.faces, 4**level * report["base"]["faces"]),
        "components": (found.components, report["input"]["components"]),
        "boundary loops": (found.boundary_loops, report["input"]["boundary_loops"]),
        "as Euler characteristic": (found.euler_characteristic, report["input"]["euler_characteristic"]),
        "vertices without a face": (found.unreferenced, 0),
    }
    wrong += [f"{got} {what} instead of {wanted}" for what, (got, wanted) in expected.items() if got != wanted]
    if len(positions) and not abs(positions).max() < float("inf"):
        wrong.append("coordinates that are not finite")
    return wrong


def over_budget(report):
    over = report["peak_rss_bytes"] - report["memory_budget_bytes"] - (CODE_MIB << 20)
    return [f"{over >> 20} MiB of memory more than allowed"] if over > 0 else []


def words_of_repairs(report):
    done = {key: count for key, count in report.get("repairs", {}).items() if isinstance(count, int) and count}
    return ", ".join(f"{count:,} {key.replace('_', ' ')}" for key, count in done.items())


def judge(outcome, output, settings, leftovers):
    """Sets result and what, from what is known of the run of remesh."""
    code = outcome.exit_code
    bad = []
    if code is None:
        bad.append(f"no end after {settings.seconds:g} s")
    elif code < 0:
        bad.append(f"signal {-code}")
    elif code != 0 and code not in REFUSALS:
        bad.append(f"exit code {code}: {outcome.what}")
    elif code == 0 and not (output.is_file() and outcome.report):
        bad.append("exit code 0 without output and report")
    elif code == 0:
        bad += wrong_output(output, outcome.report, settings.level) + over_budget(outcome.report)
    elif not outcome.what:
        bad.append("refused without a message")
    if leftovers and code is not None and code >= 0:
        bad.append(f"left behind: {', '.join(leftovers)}")
    if settings.checks and outcome.check_code not in (0, *REFUSALS):
        bad.append(f"check ended with {outcome.check_code}")
    if bad:
        outcome.result, outcome.what = "BAD", "; ".join(bad)
    elif code != 0:
        outcome.result = "refused"
    else:
        outcome.what = words_of_repairs(outcome.report)
        outcome.result = "repaired" if outcome.what else "handled"


def run_check(path, settings):
    """The exit code of `remaps check`; 1 where it says 0 without JSON."""
    code, text, _ = run([settings.remaps, "check", path, "--json"], settings.seconds)
    if code == 0:
        try:
            json.loads(text)
        except ValueError:
            return 1
    return code


def survey_file(root, path, settings):
    outcome = Outcome(root.name, path.relative_to(root).as_posix(), path.stat().st_size)
    with tempfile.TemporaryDirectory(dir=settings.scratch) as name:
        directory = pathlib.Path(name)
        mesh = prepare(path, directory, settings)
        results = directory / "results"
        results.mkdir()
        if settings.checks:
            outcome.check_code = run_check(mesh, settings)
        output, report = results / "out.ply", results / "report.json"
        outcome.exit_code, _, messages = run(
            [settings.remaps, "remesh", mesh, output, "--level", settings.level, "--report", report, "--quiet",
             *with_defaults(settings.options)], settings.seconds)
        outcome.what = last_error(messages, mesh, directory, outcome.name) if outcome.exit_code else ""
        wanted = {"out.ply", "report.json"} if outcome.exit_code == 0 else set()
        leftovers = sorted({entry.name for entry in results.iterdir()} - wanted)
        if outcome.exit_code == 0 and report.is_file():
            outcome.report = json.loads(report.read_text())
        judge(outcome, output, settings, leftovers)
    return outcome


def survey(files, settings, jobs):
    """Outcomes in the order of the files; says on the way what is not handled."""
    outcomes = []
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        runs = [pool.submit(survey_file, root, path, settings) for root, path in files]
        for done in runs:
            outcome = done.result()
            outcomes.append(outcome)
            if outcome.result in ("refused", "BAD"):
                code = "" if outcome.result == "BAD" else f" {outcome.exit_code}"
                print(f"{outcome.result}{code}  {outcome.folder}/{outcome.name}: {outcome.what}", flush=True)
    return outcomes


def compare_same(prefix, outcomes, paths, settings):
    """Holds the files whose names begin so to be one surface: a sentence, and whether they are."""
    group = [o for o in outcomes if f"{o.folder}/{o.name}".startswith(prefix)]
    good = [o for o in group if o.result in ("handled", "repaired")]
    numbers = {tuple(o.report["input"][key] for key in
                     ("faces", "components", "boundary_loops", "euler_characteristic")) for o in good}
    farthest = 0.0
    with tempfile.TemporaryDirectory(dir=settings.scratch) as name:
        meshes = []
        for o in good:
            directory = pathlib.Path(name) / str(len(meshes))
            directory.mkdir()
            meshes.append(prepare(paths[o.folder, o.name], directory, settings))
        for mesh in meshes[1:]:
            code, text, _ = run([settings.remaps, "measure", meshes[0], mesh, "--samples", "100k", "--json"],
                                settings.seconds)
            error = json.loads(text) if code == 0 else {}
            error = error.get("error", error)
            farthest = max(farthest, *(error.get(key, float("inf")) for key in ("max_forward", "max_backward")))
    same = len(good) == len(group) and len(numbers) == 1 and farthest < 1e-6
    counts = "the same counts" if len(numbers) == 1 else f"{len(numbers)} different counts"
    return (f"`{prefix}*`: {len(good)} of {len(group)} files handled, with {counts} of faces, components, loops and "
            f"Euler characteristic; the surfaces are at most {farthest:.1e} of the diagonal apart."), same


def cell(text):
    return str(text).replace("|", "\\|").replace("\n", " ")


def topology_words(report):
    if not report:
        return ""
    given = report["input"]
    return f"{given['components']:,} / {given['boundary_loops']:,} / {given['euler_characteristic']:,}"


def table_row(o):
    what = f"{o.exit_code}: {o.what}" if o.result == "refused" else o.what
    faces = f"{o.report['input']['faces']:,}" if o.report else ""
    base = f"{o.report['base']['vertices']:,}" if o.report else ""
    error = f"{1e4 * o.report['error']['l2']:.2f}" if o.report.get("error") else ""
    return "| " + " | ".join(map(cell, (o.name, o.result, faces, topology_words(o.report), base, error, what))) + " |"


def markdown(outcomes, command, level, same):
    lines = ["# Survey", "", f"What becomes of every file of some folders, by `{command}`, where MESHES is the "
             "folder that holds them.", "",
             f"Each file was remeshed to level {level}. *Handled*: the output is a manifold with the components, "
             "boundary loops and Euler characteristic of the (repaired) input, counted by",
             "`tools/mesh_topology.py`, which shares nothing with remaps. *Repaired*: the same, and something was "
             "set right first. *Refused*: exit code and reason. *BAD*: anything else.", "",
             "| folder | files | handled | repaired | refused | BAD |", "|---|---|---|---|---|---|"]
    folders = list(dict.fromkeys(o.folder for o in outcomes))
    for folder in [*folders, None]:
        of = [o for o in outcomes if folder in (o.folder, None)]
        count = collections.Counter(o.result for o in of)
        row = [folder or "all", len(of), *(count[r] for r in ("handled", "repaired", "refused", "BAD"))]
        lines.append("| " + " | ".join(map(str, row)) + " |")
    lines += ["", *[line for sentence in same for line in (sentence, "")]]
    lines.append("*Topology*: components / boundary loops / Euler characteristic. *L2*: of the output, in 1e-4 of "
                 "the diagonal.")
    for folder in folders:
        lines += ["", f"## {folder}", "", "| file | result | faces | topology | base vertices | L2 | what |",
                  "|---|---|---|---|---|---|---|"]
        lines += [table_row(o) for o in outcomes if o.folder == folder]
    return "\n".join(lines) + "\n"


def write_csv(outcomes, path):
    with open(path, "w", encoding="utf-8", newline="") as file:
        out = csv.writer(file)
        out.writerow(["folder", "file", "bytes", "result", "exit_code", "check_exit_code", "what", "vertices", "faces",
                      "components", "boundary_loops", "euler_characteristic", "base_vertices", "output_faces", "l2",
                      "max", "seconds", "peak_mib"])
        for o in outcomes:
            r = o.report
            given = [r["input"][key] for key in ("vertices", "faces", "components", "boundary_loops",
                                                 "euler_characteristic")] if r else [""] * 5
            error = r.get("error")
            made = [r["base"]["vertices"], r["output"]["faces"], error["l2"] if error else "",
                    max(error["max_forward"], error["max_backward"]) if error else "",
                    f"{r['seconds']['total']:.2f}", r["peak_rss_bytes"] >> 20] if r else [""] * 6
            code = "none" if o.exit_code is None else o.exit_code
            out.writerow([o.folder, o.name, o.size, o.result, code, o.check_code, o.what, *given, *made])


def files_of(folders):
    found = []
    for folder in folders:
        root = pathlib.Path(folder).resolve()
        if not root.is_dir():
            sys.exit(f"survey: {folder}: expected a folder")
        found += [(root, path) for path in sorted(root.rglob("*")) if path.is_file()]
    return found


def command_line(parsed, options):
    """The command as others can give it: folders by their last name."""
    words = ["tools/survey.py", *(f"MESHES/{pathlib.Path(f).resolve().name}" for f in parsed.folders)]
    if parsed.level != 3:
        words += ["--level", str(parsed.level)]
    for prefix in parsed.same:
        words += ["--same", prefix]
    return shlex.join([*words, *(["--", *options] if options else [])])


def parse_arguments(arguments):
    options = []
    if "--" in arguments:
        at = arguments.index("--")
        arguments, options = arguments[:at], arguments[at + 1:]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0],
                                     epilog="What follows -- is passed on to `remaps remesh`.")
    parser.add_argument("folders", nargs="+", help="folders of meshes, searched in depth")
    parser.add_argument("--remaps", default="build/release/cli/remaps", help="the binary")
    parser.add_argument("--level", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=300, help="allowed for each file and verb (300)")
    parser.add_argument("--jobs", type=int, default=2, help="files at a time (2)")
    parser.add_argument("--markdown", help="where to write the tables; they are not printed")
    parser.add_argument("--csv", help="where to write all numbers")
    parser.add_argument("--scratch", help="folder for unpacked files and results (the system's)")
    parser.add_argument("--same", action="append", default=[], metavar="PREFIX",
                        help="the files FOLDER/NAME that begin so are one surface")
    return parser.parse_args(arguments), options


def main():
    parsed, options = parse_arguments(sys.argv[1:])
    if shutil.which(parsed.remaps) is None or shutil.which("zstd") is None:
        sys.exit(f"survey: {parsed.remaps} or zstd is missing; ./dev build makes the one, ./dev setup installs the other")
    files = files_of(parsed.folders)
    with tempfile.TemporaryDirectory(dir=parsed.scratch) as scratch:
        settings = Settings(parsed.remaps, parsed.level, parsed.seconds, options, pathlib.Path(scratch))
        look_at_binary(settings)
        outcomes = survey(files, settings, parsed.jobs)
        paths = {(root.name, path.relative_to(root).as_posix()): path for root, path in files}
        same = [compare_same(prefix, outcomes, paths, settings) for prefix in parsed.same]
    if parsed.csv:
        write_csv(outcomes, parsed.csv)
    if parsed.markdown:
        text = markdown(outcomes, command_line(parsed, options), parsed.level, [sentence for sentence, _ in same])
        pathlib.Path(parsed.markdown).write_text(text, encoding="utf-8")
    count = collections.Counter(o.result for o in outcomes)
    print(", ".join(f"{count[r]} {r}" for r in ("handled", "repaired", "refused", "BAD")), f"of {len(outcomes)} files")
    for sentence, good in same:
        print(sentence if good else f"NOT THE SAME  {sentence}")
    vague = [o for o in outcomes if o.result == "refused" and o.exit_code == 3
             and not (PLACE.search(o.what) and pathlib.Path(o.name).stem.split(".")[0] in o.what)]
    for o in vague:
        print(f"vague  {o.folder}/{o.name}: {o.what}")
    return 1 if count["BAD"] or not all(good for _, good in same) else 0


if __name__ == "__main__":
    sys.exit(main())

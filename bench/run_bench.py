#!/usr/bin/env python3
"""Runs the benchmark: measures remaps and its peers, stores the results, writes docs/benchmarks.md.

    ./dev bench [SET...] [OPTIONS]      installs and builds what is needed, then calls this
    ./dev bench codec ...               the codec has its own: run_codec.py

Sets: quick, standard (the default), memory, order, output, readers, huge. Every set stands alone and
can be run again; its rows then replace the old ones. A run that fails is a row that says why, and the
others go on; the exit code is then 1. Models are made when first needed, and kept in the cache.
"""

import argparse
import datetime
import os
import platform
import subprocess
import sys
from pathlib import Path

import page
import tables
from models import ROOT, ModelStore, model_named
from process import RunFailed
from results import Table, trace_table
from runs import Runner
from sets import SETS, jobs_of


def machine():
    """Processor and how many of them this process may use."""
    name = platform.machine()
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            name = next(line.split(":", 1)[1].strip() for line in file if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    count = len(os.sched_getaffinity(0))
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    return f"{name}, {count} processors, {memory:.0f} GiB"


def revision():
    """The commit that is measured, with + when files differ from it."""
    def git(*words):
        done = subprocess.run(["git", "-C", ROOT, *words], capture_output=True, text=True, check=True)
        return done.stdout.strip()
    try:
        changed = git("status", "--porcelain", "--untracked-files=no", "--", "src", "cli", "cmake", "CMakeLists.txt")
        return git("rev-parse", "--short", "HEAD") + ("+" if changed else "")
    except (OSError, subprocess.CalledProcessError):
        return ""


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], prog="./dev bench")
    parser.add_argument("sets", nargs="*", metavar="SET", help=f"{', '.join(SETS)}; default: standard")
    parser.add_argument("--models", nargs="+", metavar="MODEL", help="run the sets on these models instead")
    parser.add_argument("--runs", nargs="+", metavar="RUN", help="only these runs of the sets, as the CSV names them")
    parser.add_argument("--repeat", type=int, default=1, metavar="N",
                        help="run everything N times in turn and keep each run's least CPU time; default 1")
    parser.add_argument("--cache", type=Path, default=ROOT / "build/bench", metavar="DIR",
                        help="where models and temporary files go; default build/bench")
    parser.add_argument("--build", type=Path, default=ROOT / "build/bench", metavar="DIR",
                        help="where the programs were built; default build/bench")
    parser.add_argument("--results", type=Path, default=ROOT / "bench/results", metavar="DIR",
                        help="where the CSV files are; default bench/results")
    parser.add_argument("--docs", type=Path, default=ROOT / "docs", metavar="DIR",
                        help="where benchmarks.md and images/ are written; default docs")
    parser.add_argument("--level", type=int, metavar="N", help="subdivisions, instead of the sets'")
    parser.add_argument("--samples", type=int, metavar="N", help="sample points when errors are measured")
    parser.add_argument("--no-peer-error", dest="peer_error", action="store_false",
                        help="do not measure the error of the peers' results")
    parser.add_argument("--page-only", action="store_true", help="run nothing; write the page from the results")
    parsed = parser.parse_args()
    parsed.sets = parsed.sets or ["standard"]
    for name in parsed.sets:
        if name not in SETS:
            parser.error(f"no set {name}; there are {', '.join(SETS)}")
    for name in parsed.models or ():
        try:
            model_named(name)
        except RunFailed as error:
            parser.error(str(error))
    runs = {job.run for name in parsed.sets for jobs in jobs_of(name, parsed.models) for job in jobs}
    for run in parsed.runs or ():
        if run not in runs:
            parser.error(f"no run \"{run}\" in {', '.join(parsed.sets)}; there are {', '.join(sorted(runs))}")
    if parsed.repeat < 1:
        parser.error("--repeat must be at least 1")
    return parsed


def run_once(runner, job):
    """The row of a job, whether it goes well or not."""
    try:
        row = runner.run(job)
    except (RunFailed, OSError, KeyError, ValueError) as error:
        row = {"model": job.model, "run": job.run, "status": str(error) or type(error).__name__}
    print(tables.progress_line(row), file=sys.stderr, flush=True)
    return row


def better(row, other):
    """Whether a row replaces the one of an earlier repetition."""
    if other is None or other["status"] != "ok":
        return True
    return row["status"] == "ok" and row["cpu_seconds"] < other["cpu_seconds"]


def run_group(runner, jobs, repeat):
    """Rows of jobs that belong together, in turn, and their memory traces."""
    rows, traces = {}, {}
    runner.start_group()
    try:
        for _ in range(repeat):
            for job in jobs:
                row = run_once(runner, job)
                if better(row, rows.get(job.run + job.model)):
                    rows[job.run + job.model] = row
                    if runner.trace:
                        traces[job.run + job.model] = [
                            {"model": job.model, "run": job.run, "seconds": s, "rss_bytes": b} for s, b in runner.trace]
    finally:
        runner.finish_group()
    return list(rows.values()), [sample for trace in traces.values() for sample in trace]


def run_set(name, args, runner, common):
    """Runs a set and stores its rows model by model. Returns how many failed."""
    print(f"set {name}", file=sys.stderr)
    table, failed = Table(args.results / f"{name}.csv"), 0
    for jobs in jobs_of(name, args.models):
        jobs = [job for job in jobs if not args.runs or job.run in args.runs]
        if not jobs:
            continue
        load = f"{os.getloadavg()[0]:.2f}"
        rows, traces = run_group(runner, jobs, args.repeat)
        for row in rows:
            row.update(common, load=float(load), repeats=args.repeat)
        failed += sum(row["status"] != "ok" for row in rows)
        table.replace(rows)
        if traces:
            trace_table(args.results).replace(traces)
    print("\n" + tables.for_set(name, table) + "\n", flush=True)
    return failed


def main():
    args = arguments()
    failed = 0
    if not args.page_only:
        remaps, programs = args.build / "cli/remaps", args.build / "bench"
        store = ModelStore(args.cache / "models", remaps, programs)
        common = {"session": datetime.datetime.now().isoformat(timespec="seconds"), "revision": revision(),
                  "machine": machine()}
        for name in args.sets:
            runner = Runner(store, remaps, programs, args.cache / "work", args)
            failed += run_set(name, args, runner, common)
    page.write(args.results, args.docs)
    print(f"wrote {args.docs / 'benchmarks.md'}", file=sys.stderr)
    if failed:
        print(f"{failed} of the runs failed; their rows say why", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

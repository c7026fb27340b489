"""What the project set out to show, next to what the stored results say."""

import tables
from results import Table
from sets import TRACE_BUDGETS

MIB = 2**20
LARGE = 9_000_000  # vertices: Earth and the generated mesh of 14.4 M


def worst(pairs):
    """Largest of (value, name) as text, or nothing."""
    known = [(value, name) for value, name in pairs if value is not None]
    return max(known) if known else None


def quotient(a, b, column):
    return a[column] / b[column] if tables.together(a, b) else None


def remeshes(results):
    """All sound runs of remesh in all sets."""
    for name in tables.TABLES:
        for row in Table(results / f"{name}.csv").rows:
            if row["status"] == "ok" and row["memory_budget"] and row["output_faces"] and row["run"] != "resample":
                yield f"{row['model']}, {row['run']}", row


def large_runs(table):
    """Models of the goals that are set for large ones, with their remesh."""
    for model in table.models():
        row = table.find(model, "map")
        if row is not None and row["vertices"] >= LARGE:
            yield model, row


def of_peers(table, run):
    return [(quotient(row, table.find(model, "meshoptimizer"), "cpu_seconds"), model)
            for model, _ in large_runs(table) if (row := table.find(model, run)) is not None]


def map_and_remesh_of_peers(table):
    """The map and the remesh, but no error: the peers do not measure theirs either."""
    for model, _ in large_runs(table):
        peer = table.find(model, "meshoptimizer")
        steps = [quotient(row, peer, "cpu_seconds")
                 for run in ("parameterize", "resample") if (row := table.find(model, run)) is not None]
        if len(steps) == 2 and None not in steps:
            yield sum(steps), model


def growth(table):
    small, large = table.find("g1", "map"), table.find("g14", "map")
    value = quotient(large, small, "cpu_seconds")
    return [] if value is None else [(value * small["vertices"] / large["vertices"], "g14 to g1")]


def io_factors(table):
    for model, row in large_runs(table):
        if tables.io_bytes(row) is not None:
            yield tables.io_bytes(row) / row["input_bytes"], model


def slowdown(table, budget):
    return [(quotient(table.find(m, f"memory {budget}"), table.find(m, "memory 230M"), "seconds"), m)
            for m in table.models()]


def error_growth(table):
    for model in table.models():
        unlimited = table.find(model, "memory 4G")
        for budget in TRACE_BUDGETS:
            row = table.find(model, f"memory {budget}")
            if row is not None and unlimited is not None and row["l2"] and unlimited["l2"]:
                yield row["l2"] / unlimited["l2"], f"{model} in {budget}"


def shuffled(table):
    for row in table.rows:
        coherent = row["model"].removesuffix(tables.SHUFFLED)
        if coherent != row["model"]:
            yield quotient(table.find(row["model"], row["run"]), table.find(coherent, row["run"]), "seconds"), coherent


def table(results):
    """Markdown: goal, worst value measured, and on what."""
    standard, memory, order = (Table(results / f"{name}.csv") for name in ("standard", "memory", "order"))
    threads = worst((-value, name) for value, name in (
        (quotient(memory.find(m, "threads 1"), memory.find(m, "threads 2"), "seconds"), m) for m in memory.models())
        if value is not None)
    runs = list(remeshes(results))
    lines = [
        ("peak memory, above the budget, in MiB: at most 32",
         worst(((row["peak_rss"] - row["memory_budget"]) / MIB, name) for name, row in runs), 0),
        ("peak temporary disk, times the binary input: at most 4",
         worst((row["peak_temp"] / row["input_bytes"], name) for name, row in runs if row["run"] != "output"), 1),
        ("CPU of remesh with error, times meshoptimizer's, above 9 M vertices: at most 1.5",
         worst(of_peers(standard, "plain")), 2),
        ("the same of parameterize and resample together: with the map, without the error",
         worst(map_and_remesh_of_peers(standard)), 2),
        ("the same of remesh with map and error", worst(of_peers(standard, "map")), 2),
        ("CPU a vertex at 14.4 M, times that at 1.4 M: at most 1.15", worst(growth(standard)), 2),
        ("bytes read and written, times the binary input, above 9 M vertices: at most 10",
         worst(io_factors(standard)), 1),
        ("time in 64M, times that in 230M: at most 1.5", worst(slowdown(memory, "64M")), 2),
        ("L2, times that in 4G: at most 1.10", worst(error_growth(memory)), 2),
        ("time of shuffled input, times that of coherent: at most 3", worst(shuffled(order)), 2),
        ("speed of two threads, times that of one: at least 1.7", threads and (-threads[0], threads[1]), 2),
    ]
    return tables.markdown(["goal", "worst measured", "on"], [
        [goal, tables.NONE, "not measured yet"] if found is None
        else [goal, f"{found[0]:,.{digits}f}", found[1]] for goal, found, digits in lines])

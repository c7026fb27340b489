"""docs/benchmarks.md and its figures, from the stored results and the text in page.md."""

import re
from pathlib import Path

import goals
import plot_memory
import tables
from results import Table, trace_table

TEMPLATE = Path(__file__).resolve().parent / "page.md"
PLACE = re.compile(r"^\{\{(\w+)(?:\.(\w+))?\}\}$", re.MULTILINE)


def not_run(name):
    return f"Not measured yet: `./dev bench {name}`."


def figure_runs(table, traces, model):
    runs = []
    for row in table.rows:
        if row["model"] != model or row["status"] != "ok":
            continue
        trace = [(t["seconds"], t["rss_bytes"]) for t in traces.rows
                 if (t["model"], t["run"]) == (model, row["run"])]
        if trace:
            runs.append(plot_memory.Run(row["run"].removeprefix("memory "), row["memory_budget"], trace,
                                        {phase: row[phase] for phase in plot_memory.PHASES}, row["peak_rss"]))
    return runs


def figures(results, docs):
    """Draws resident memory over time, a figure a model; returns the links."""
    table, traces = Table(results / "memory.csv"), trace_table(results)
    links = []
    for model in table.models():
        runs = figure_runs(table, traces, model)
        if not runs:
            continue
        path = docs / "images" / f"memory-{model}.svg"
        path.parent.mkdir(parents=True, exist_ok=True)
        vertices = next(row["vertices"] for row in table.rows if row["model"] == model and row["vertices"])
        path.write_text(plot_memory.draw(f"{tables.title(model)}: {vertices:,} vertices, remesh with map and error",
                                         runs), encoding="utf-8")
        links.append(f"![Resident memory of remesh over time on {tables.title(model)}, a line a budget]"
                     f"(images/{path.name})")
    return "\n\n".join(links) or not_run("memory")


def write(results, docs):
    """Writes benchmarks.md and its images.

    Lines {{set.table}}, {{set}} (its notes), {{goals}} and {{figures}} of the template are filled in.
    """
    def fill(match):
        name, which = match.groups()
        if name == "figures":
            return figures(results, docs)
        if name == "goals":
            return goals.table(results)
        table = Table(results / f"{name}.csv")
        if not table.rows:
            return not_run(name) if which else ""
        return tables.TABLES[name][which](table) if which else tables.notes(table)

    docs.mkdir(parents=True, exist_ok=True)
    text = PLACE.sub(fill, TEMPLATE.read_text(encoding="utf-8"))
    # A place left empty leaves no gap.
    (docs / "benchmarks.md").write_text(re.sub(r"\n{3,}", "\n\n", text), encoding="utf-8")

"""Markdown tables from results."""

from models import MODELS, SHUFFLED
from sets import TRACE_BUDGETS

MIB = 2**20
NONE = "–"


def title(model):
    plain = model.removesuffix(SHUFFLED)
    name = MODELS[plain].title if plain in MODELS else plain
    return f"{name}, shuffled" if plain != model else name


def number(value, digits=1):
    return NONE if value is None else f"{value:,.{digits}f}"


def count(value):
    return NONE if value is None else f"{value:,}"


def mib(value):
    return NONE if value is None else f"{value / MIB:,.0f}"


def cell(row, column, form=number, *arguments):
    """A cell of a row that may be missing."""
    return NONE if row is None else form(row.get(column), *arguments)


def error(row):
    """L2 in 1e-4 of the diagonal."""
    value = row and row.get("l2")
    return NONE if value is None else f"{1e4 * value:.2f}"


def times(a, b, digits=2):
    return NONE if a is None or not b else f"{a / b:.{digits}f}"


def together(a, b):
    """Whether two rows come from one session: only then is their ratio worth stating."""
    return a is not None and b is not None and a["session"] == b["session"]


def ratio(a, b, column, digits=2):
    return times(a[column], b[column], digits) if together(a, b) else NONE


def io_bytes(row):
    if row is None or row["bytes_read"] is None:
        return None
    return row["bytes_read"] + row["bytes_written"]


def of_input(row, value):
    """Bytes as MiB, and as a multiple of the binary input."""
    return NONE if row is None or value is None else f"{mib(value)} ({times(value, row['input_bytes'], 1)}×)"


def markdown(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(cells) + " |" for cells in rows])


def notes(table):
    """Under a table: which runs failed, and where and when it was measured."""
    failed = [f"* {title(row['model'])}, {row['run']}: {row['status']}" for row in table.rows
              if row["status"] != "ok"]
    parts = ["No result:", "\n".join(failed)] if failed else []
    measured = {}
    for row in table.rows:
        key = (row["session"], row["machine"], row["revision"], row["repeats"])
        measured.setdefault(key, []).append(row)
    for (session, machine, revision, repeats), rows in measured.items():
        models = ", ".join(dict.fromkeys(row["model"] for row in rows))
        loads = [row["load"] for row in rows if row["load"] is not None]
        often = f"; least CPU time of {repeats} runs" if repeats and repeats > 1 else ""
        parts.append(f"*{models}: {session}, {revision or 'no revision'}, on {machine}; load at the start "
                     f"{min(loads):.1f} to {max(loads):.1f}{often}.*")
    return "\n\n".join(parts)


def remesh_table(table):
    head = ["model", "vertices", "base", "level", "parameterize s", "CPU s", "resample s", "CPU s", "remesh s", "CPU s",
            "CPU µs a vertex", "peak MiB", "read + written MiB", "peak temporary MiB", "L2"]
    rows = []
    for model in table.models():
        run, parameterize, resample = (table.find(model, name) for name in ("map", "parameterize", "resample"))
        per_vertex = NONE if run is None else f"{1e6 * run['cpu_seconds'] / run['vertices']:.2f}"
        rows.append([
            title(model), cell(run, "vertices", count), cell(run, "base_vertices", count),
            cell(run, "level", count), cell(parameterize, "seconds"), cell(parameterize, "cpu_seconds"),
            cell(resample, "seconds"), cell(resample, "cpu_seconds"),
            cell(run, "seconds"), cell(run, "cpu_seconds"), per_vertex, cell(run, "peak_rss", mib),
            of_input(run, io_bytes(run)), of_input(run, run and run["peak_temp"]), error(run)])
    return markdown(head, rows)


def plain_table(table):
    head = ["model", "remesh s", "CPU s", "peak MiB", "read + written MiB", "peak temporary MiB", "L2"]
    rows = []
    for model in table.models():
        run = table.find(model, "plain")
        rows.append([title(model), cell(run, "seconds"), cell(run, "cpu_seconds"), cell(run, "peak_rss", mib),
                     of_input(run, io_bytes(run)), of_input(run, run and run["peak_temp"]), error(run)])
    return markdown(head, rows)


PROGRAMS = {"map": "remaps, with map", "plain": "remaps, without map", "meshoptimizer": "meshoptimizer",
            "openmesh": "OpenMesh"}


def peer_table(table):
    head = ["model", "program", "faces", "s", "CPU s", "CPU µs a vertex", "peak MiB", "L2",
            "CPU of remaps with map / its", "CPU of remaps without map / its"]
    rows = []
    for model in table.models():
        run, plain = table.find(model, "map"), table.find(model, "plain")
        for name in PROGRAMS:
            row = table.find(model, name)
            if row is None:
                continue
            peer = name in ("meshoptimizer", "openmesh")
            rows.append([
                title(model), PROGRAMS[name], count(row["output_faces"]),
                number(row["seconds"]), number(row["cpu_seconds"]),
                f"{1e6 * row['cpu_seconds'] / row['vertices']:.2f}", mib(row["peak_rss"]), error(row),
                ratio(run, row, "cpu_seconds") if peer else "", ratio(plain, row, "cpu_seconds") if peer else ""])
    return markdown(head, rows)


def memory_table(table):
    head = ["model", "budget", "s", "CPU s", "CPU / that of 230M", "peak MiB", "read + written MiB",
            "peak temporary MiB", "L2", "L2 / that of 4G"]
    rows = []
    for model in table.models():
        usual, unlimited = table.find(model, "memory 230M"), table.find(model, "memory 4G")
        for budget in TRACE_BUDGETS:
            run = table.find(model, f"memory {budget}")
            rows.append([
                title(model), budget, cell(run, "seconds"), cell(run, "cpu_seconds"), ratio(run, usual, "cpu_seconds"),
                cell(run, "peak_rss", mib), of_input(run, io_bytes(run)), of_input(run, run and run["peak_temp"]),
                error(run), times(run["l2"], unlimited["l2"]) if run and unlimited else NONE])
    return markdown(head, rows)


def thread_table(table):
    head = ["model", "1 thread s", "CPU s", "2 threads s", "CPU s", "speed-up", "remesh", "bundle"]
    rows = []
    for model in table.models():
        one, two = table.find(model, "threads 1"), table.find(model, "threads 2")

        def same(column):
            if not together(one, two):
                return NONE
            return "same bytes" if one[column] == two[column] else "**differs**"
        rows.append([
            title(model), cell(one, "seconds"), cell(one, "cpu_seconds"),
            cell(two, "seconds"), cell(two, "cpu_seconds"),
            ratio(one, two, "seconds"), same("output_hash"), same("bundle_hash")])
    return markdown(head, rows)


def order_table(table):
    head = ["model", "s", "CPU s", "s / coherent", "CPU / coherent", "peak MiB", "read + written MiB",
            "peak temporary MiB", "L2"]
    rows = []
    for model in table.models():
        names = [row["run"] for row in table.rows if row["model"] == model]
        for name in dict.fromkeys(names):
            run, coherent = table.find(model, name), table.find(model.removesuffix(SHUFFLED), name)
            rows.append([
                title(model), cell(run, "seconds"), cell(run, "cpu_seconds"), ratio(run, coherent, "seconds"),
                ratio(run, coherent, "cpu_seconds"), cell(run, "peak_rss", mib), of_input(run, io_bytes(run)),
                of_input(run, run and run["peak_temp"]), error(run)])
    return markdown(head, rows)


def output_table(table):
    head = ["model", "base faces", "level", "output faces", "output MiB", "s", "CPU s", "resample s", "budget MiB",
            "peak MiB", "peak temporary MiB", "L2"]
    rows = []
    for row in table.rows:
        if row["status"] != "ok":
            continue
        rows.append([
            title(row["model"]), count(row["output_faces"] // 4 ** row["level"]), count(row["level"]),
            count(row["output_faces"]), mib(row["result_bytes"]), number(row["seconds"]), number(row["cpu_seconds"]),
            number(row["resample"]), mib(row["memory_budget"]), mib(row["peak_rss"]), mib(row["peak_temp"]),
            error(row)])
    return markdown(head, rows)


def reader_table(table):
    head = ["model", "file", "MB", "vertices pass CPU s", "faces pass CPU s", "MB a CPU second",
            "million faces a CPU second"]
    rows = []
    for row in table.rows:
        if row["status"] != "ok":
            continue
        cpu = row["positions_cpu"] + row["triangles_cpu"]
        rows.append([
            title(row["model"]), row["run"].removeprefix("read "), number(row["file_bytes"] / 1e6, 0),
            number(row["positions_cpu"], 2), number(row["triangles_cpu"], 2), times(row["file_bytes"] / 1e6, cpu, 0),
            times(row["faces"] / 1e6, cpu, 1)])
    return markdown(head, rows)


def huge_table(table):
    head = ["model", "vertices", "base", "budget MiB", "s", "CPU s", "CPU µs a vertex", "peak MiB",
            "read + written MiB", "peak temporary MiB", "peak on disk MiB", "L2"]
    rows = []
    for row in table.rows:
        if row["status"] != "ok":
            continue
        rows.append([
            title(row["model"]), count(row["vertices"]), count(row["base_vertices"]), mib(row["memory_budget"]),
            number(row["seconds"]), number(row["cpu_seconds"]), f"{1e6 * row['cpu_seconds'] / row['vertices']:.2f}",
            mib(row["peak_rss"]), of_input(row, io_bytes(row)), of_input(row, row["peak_temp"]),
            of_input(row, row["peak_disk"]), error(row)])
    return markdown(head, rows)


TABLES = {
    "quick": {"remesh": remesh_table, "plain": plain_table, "peers": peer_table},
    "standard": {"remesh": remesh_table, "plain": plain_table, "peers": peer_table},
    "memory": {"budgets": memory_table, "threads": thread_table},
    "order": {"order": order_table},
    "output": {"output": output_table},
    "readers": {"readers": reader_table},
    "huge": {"huge": huge_table},
}


def for_set(name, table):
    """All tables of a set and the notes under them."""
    parts = [make(table) for make in TABLES[name].values()]
    return "\n\n".join([*parts, notes(table)])


def progress_line(row):
    """What the terminal shows when a run has ended."""
    start = f"  {row['model']:14} {row['run']:15}"
    if row["status"] != "ok":
        return f"{start} FAILED: {row['status']}"
    line = f"{start} {row['seconds']:8.1f} s  CPU {row['cpu_seconds']:8.1f} s  peak {mib(row['peak_rss']):>6} MiB"
    return line if row.get("l2") is None else f"{line}  L2 {error(row)}e-4"

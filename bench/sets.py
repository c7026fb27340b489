"""What each set runs on which models."""

from dataclasses import dataclass, field

from models import model_named

BUDGET = "230M"  # the paper's: 230 MB
SMALL_BUDGET = "64M"
TRACE_BUDGETS = ("32M", "64M", "230M", "4G")
HUGE_BUDGET = "256M"
BASE_VERTICES = 200
LEVEL = 5
# The head has 359 components and hence a base of thousands of vertices: level 5 would have more faces than it.
LEVELS = {"head": 3}
OPENMESH_VERTICES = 2_500_000  # it is run on no larger ones


@dataclass(frozen=True)
class Job:
    """One measured run: a row of the results, by model and run."""

    model: str
    run: str
    kind: str  # remesh, parameterize, resample, peer, read
    options: dict = field(default_factory=dict)


def remesh(model, run, memory, *, bundle, **options):
    level = LEVELS.get(model, LEVEL)
    return Job(model, run, "remesh", {"memory": memory, "bundle": bundle, "level": level, **options})


def table_jobs(model):
    """A row of the large table: remaps in four ways, and the peers, one after the other."""
    jobs = [
        remesh(model, "map", BUDGET, bundle=True),
        Job(model, "meshoptimizer", "peer", {"program": "peer_meshoptimizer"}),
        remesh(model, "plain", BUDGET, bundle=False),
        Job(model, "parameterize", "parameterize", {"memory": BUDGET}),
        Job(model, "resample", "resample", {"memory": BUDGET, "level": LEVELS.get(model, LEVEL)}),
    ]
    if model_named(model).vertices <= OPENMESH_VERTICES:
        jobs.append(Job(model, "openmesh", "peer", {"program": "peer_openmesh"}))
    return jobs


def memory_jobs(model):
    """The same run in several budgets, and on one and two threads."""
    budgets = [remesh(model, f"memory {b}", b, bundle=True, trace=True) for b in TRACE_BUDGETS]
    threads = [remesh(model, f"threads {n}", BUDGET, bundle=True, threads=n, hashes=True) for n in (1, 2)]
    return budgets + threads


def order_jobs(model):
    """Coherent and shuffled; without a bundle, so that all that is stored is temporary."""
    return [remesh(name, f"order {SMALL_BUDGET}", SMALL_BUDGET, bundle=False)
            for name in (model, f"{model}-shuffled")]


def output_jobs(model):
    """An output far larger than the budget: level 8 of 400 faces on a sphere, 26 million faces."""
    return [remesh(model, "output", SMALL_BUDGET, bundle=False, base_vertices=202, level=8)]


def reader_jobs(model):
    return [Job(model, f"read {name}", "read", {"form": form})
            for name, form in (("binary PLY", None), ("text PLY", ".text.ply"), ("OBJ", ".text.obj"),
                               ("OFF", ".text.off"), ("binary STL", ".binary.stl"), ("text STL", ".text.stl"),
                               ("GLB", ".glb"), ("binary PLY, gzip", ".ply.gz"), ("binary PLY, Zstandard", ".ply.zst"))]


def huge_jobs(model):
    return [remesh(model, "map", HUGE_BUDGET, bundle=True)]


# A set: its jobs for a model, and its models.
SETS = {
    "quick": (table_jobs, ("earth4", "g1")),
    "standard": (table_jobs, ("earth4", "earth2", "earth1", "head", "g1", "g14")),
    "memory": (memory_jobs, ("earth1", "g14")),
    "order": (order_jobs, ("g1", "g14")),
    "output": (output_jobs, ("koala", "earth4")),
    "readers": (reader_jobs, ("g1",)),
    "huge": (huge_jobs, ("g150",)),
}


def jobs_of(name, models=None):
    """Lists of jobs, one a model; the jobs of a list are run together and belong together."""
    make, usual = SETS[name]
    return [make(model) for model in models or usual]

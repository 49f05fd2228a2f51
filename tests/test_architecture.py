"""The floors of the design, enforced: who may import whom, what is pure, what each may use."""

import ast
import subprocess
import sys
from fnmatch import fnmatch
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parent.parent
FLOORS = ("wire", "world_server", "swarm_agent", "tower", "deploy", "tests")

MAY_IMPORT = {
    "wire": ("wire",),
    "world_server": ("wire", "world_server"),
    "swarm_agent": ("wire", "swarm_agent"),
    "tower": (
        "wire",
        "tower",
        "swarm_agent.node",
        "swarm_agent.knowledge",
        "swarm_agent.behaviour",
        "swarm_agent.startup",
        "swarm_agent.line_radio",
        "swarm_agent.graph_copy",
        "swarm_agent.sweep.radio",
    ),
    "deploy": ("wire", "world_server", "swarm_agent", "tower", "deploy"),
    "tests": FLOORS,
}

ONLY_IN = {
    "zenoh": ("wire/link.py",),
    # What is drawn and how it is laid out: one file for both would be too long. Pictures need a viewer.
    "rerun": ("deploy/drawing.py", "deploy/layout.py", "deploy/picture.py"),
    "signal": ("deploy/process.py",),
    "subprocess": ("deploy/process.py",),
    "multiprocessing": (),
    "pty": (),
    # Polygons are the world's and the operator's: a robot knows no map.
    "shapely": ("world_server/*.py", "deploy/*.py"),
}

PROCESS_CALLS = {
    "os.kill",
    "os.killpg",
    "os.fork",
    "os.forkpty",
    "os.system",
    "os.popen",
    "os.posix_spawn",
    "os.posix_spawnp",
    "os.execv",
    "os.execve",
    "os.execvp",
    "os.execvpe",
    "os.spawnv",
    "os.pidfd_open",
    "signal.pidfd_send_signal",
}

PURE = (
    "swarm_agent/behaviours/*.py",
    "swarm_agent/company.py",
    "swarm_agent/sweep/*.py",
    "swarm_agent/knowledge.py",
    "swarm_agent/line_radio.py",
    "swarm_agent/relay_posts.py",
    "swarm_agent/ways.py",
    "wire/line.py",
    "swarm_agent/surveillance_graph.py",
    "swarm_agent/graph_clear.py",
    "swarm_agent/cut_sets.py",
    "swarm_agent/graph_copy.py",
    *(
        f"tower/{name}.py"
        for name in "base_station desk orders queue recall roster dispatch line_keeper graph_keeper".split()
    ),
    "deploy/metrics/*.py",
    "deploy/graph_file.py",
    "deploy/pattern_search.py",
    "deploy/scene.py",
    "deploy/scenes/*.py",
    *(
        f"world_server/{name}.py"
        for name in """
        world clock area polyline motion path_following traffic radio cells passes sensing nodes records
        chance battery edges floorplan plan_checks random_plans sight referee raster_referee frontline
        mission clear deployment discs walls perception judges fault_plan
        """.split()
    ),
)
IMPURE = set(
    """
    time datetime random threading asyncio socket os sys pathlib subprocess io secrets uuid tempfile
    shutil concurrent queue ctypes select glob urllib http logging zenoh rerun rich
    """.split()
)
IMPURE_CALLS = {"open", "print", "input", "exec", "eval", "__import__", "breakpoint", "id", "hash"}
RANDOM_TYPES = {"Generator", "Philox", "SeedSequence"}


class Import(NamedTuple):
    """One imported module, with `from a import b` as both a and a.b."""

    line: int
    module: str
    name: str


@cache
def files() -> tuple[str, ...]:
    """Every Python file of the project, as git knows it, or as it lies there where there is no git."""
    listed = subprocess.run(
        ["git", "ls-files", "*.py"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    names = listed.stdout.split() or [
        str(path.relative_to(ROOT)) for floor in FLOORS for path in (ROOT / floor).rglob("*.py")
    ]
    return tuple(name for name in names if (ROOT / name).exists())


@cache
def tree(name: str) -> ast.Module:
    return ast.parse((ROOT / name).read_text("utf-8"), name)


@cache
def imports(name: str) -> tuple[Import, ...]:
    """All imports of a file, inside functions too, and those made by name with a constant."""
    package = name.removesuffix(".py").split("/")[:-1]
    found = []
    for node in ast.walk(tree(name)):
        if isinstance(node, ast.Import):
            found += [Import(node.lineno, one.name, "") for one in node.names]
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else []
            module = ".".join([*above, *([node.module] if node.module else [])])
            found += [Import(node.lineno, module, one.name) for one in node.names]
        elif isinstance(node, ast.Call) and dotted(node.func) in ("importlib.import_module", "__import__"):
            found += [
                Import(node.lineno, one.value, "") for one in node.args[:1] if isinstance(one, ast.Constant)
            ]
    return tuple(found)


def dotted(node: ast.expr) -> str:
    """`a.b.c` for an attribute chain, empty for anything else."""
    if isinstance(node, ast.Attribute):
        inner = dotted(node.value)
        return f"{inner}.{node.attr}" if inner else ""
    return node.id if isinstance(node, ast.Name) else ""


def calls(name: str) -> list[tuple[int, str]]:
    """Line and full name of everything called or referred to by name, imports resolved."""
    known = {}
    for node in ast.walk(tree(name)):
        if isinstance(node, ast.Import):
            known |= {(one.asname or one.name): one.name for one in node.names}
        elif isinstance(node, ast.ImportFrom):
            known |= {(one.asname or one.name): f"{node.module}.{one.name}" for one in node.names}
    found = []
    for node in ast.walk(tree(name)):
        if isinstance(node, (ast.Attribute, ast.Name)) and (full := dotted(node)):
            first, _, rest = full.partition(".")
            found.append((node.lineno, ".".join(filter(None, (known.get(first, first), rest)))))
    return found


def within(module: str, allowed: tuple[str, ...]) -> bool:
    return any(module == one or module.startswith(f"{one}.") for one in allowed)


def is_pure(name: str) -> bool:
    return any(fnmatch(name, pattern) for pattern in PURE)


def none_of(complaints: list[str]) -> None:
    assert not complaints, "\n" + "\n".join(complaints)


def test_there_are_files_to_look_at():
    assert len(files()) > 20
    assert any(is_pure(name) for name in files())


def test_every_floor_imports_only_what_it_may():
    complaints = []
    for name in files():
        floor = name.split("/")[0]
        for line, module, imported in imports(name):
            full = f"{module}.{imported}" if imported else module
            ours = module.split(".")[0] in FLOORS
            if ours and not within(full, MAY_IMPORT[floor]) and not within(module, MAY_IMPORT[floor]):
                complaints.append(f"{name}:{line}: {floor} may not import {full}")
    none_of(complaints)


@pytest.mark.parametrize("package", ONLY_IN)
def test_a_dangerous_package_is_imported_in_its_one_place(package):
    none_of(
        [
            f"{name}:{line}: {package} may be imported only in {' or '.join(ONLY_IN[package]) or 'no file'}"
            for name in files()
            for line, module, _ in imports(name)
            if within(module, (package,))
            and not any(fnmatch(name, pattern) for pattern in (*ONLY_IN[package], "tests/*"))
        ]
    )


def test_only_one_file_has_signals_and_starts_processes():
    none_of(
        [
            f"{name}:{line}: {call} belongs into deploy/process.py"
            for name in files()
            if name != "deploy/process.py" and not name.startswith("tests/")
            for line, call in calls(name)
            if call in PROCESS_CALLS
        ]
    )


def test_what_is_pure_imports_no_clock_no_chance_and_no_outer_world():
    none_of(
        [
            f"{name}:{line}: {module} is not pure; time comes in percepts, chance in the generator"
            for name in filter(is_pure, files())
            for line, module, _ in imports(name)
            if module.split(".")[0] in IMPURE
        ]
    )


def test_what_is_pure_calls_nothing_that_reads_writes_or_varies_between_processes():
    none_of(
        [
            f"{name}:{node.lineno}: {node.func.id}() is not pure"
            for name in filter(is_pure, files())
            for node in ast.walk(tree(name))
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in IMPURE_CALLS
        ]
    )


def test_nothing_of_ours_draws_from_global_randomness():
    complaints = []
    for name in files():
        if name.startswith("tests/"):
            continue
        for line, call in calls(name):
            package, _, rest = call.replace("np.", "numpy.", 1).partition("numpy.random.")
            if package == "" and rest.split(".")[0] not in {"", *RANDOM_TYPES}:
                complaints.append(f"{name}:{line}: {call} is global; use a generator of world_server.chance")
        complaints += [
            f"{name}:{line}: the module random is global"
            for line, module, _ in imports(name)
            if module == "random"
        ]
    none_of(complaints)


@pytest.mark.parametrize(
    "main",
    [
        "swarm_agent.startup",
        "swarm_agent.__main__",
        "tower.__main__",
        "swarm_agent.behaviours.lr_pt",
        "tower.base_station",
        "tower.line_keeper",
        "tower.graph_keeper",
    ],
)
def test_a_robot_process_stays_lean(main):
    heavy = (
        "shapely",
        "rerun",
        "pyarrow",
        "rich",
        "matplotlib",
        "pandas",
        "scipy",
        "deploy",
        "world_server",
        "tests",
    )
    code = f"import sys, {main}; print(*sorted(name for name in sys.modules if '.' not in name))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert not set(heavy) & set(done.stdout.split()), (
        f"{main} pulls in {set(heavy) & set(done.stdout.split())}"
    )

"""How long things may be, that they say what they are, and that nothing else lies about."""

import ast
import subprocess

from tests.test_architecture import FLOORS, ROOT, files, none_of, tree
from wire import channels

TOP_LEVEL = {
    "pyproject.toml",
    "README.md",
    *FLOORS,
    "LICENSE",
    "docs",
    "uv.lock",
    "requirements.lock",
    ".ci",
    ".github",
    ".gitignore",
    ".gitattributes",
}
LONGEST_FILE, LONGEST_FUNCTION, LONGEST_MAIN, LONGEST_LINE = 300, 50, 60, 110


def test_the_top_level_holds_nothing_else_to_learn():
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    found = {line.split("/")[0] for line in listed.stdout.splitlines()} or TOP_LEVEL
    none_of([f"{name}: does not belong to the top level" for name in sorted(found - TOP_LEVEL)])


def test_no_file_is_too_long():
    sizes = {name: len((ROOT / name).read_text("utf-8").splitlines()) for name in files()}
    complaints = [
        f"{name}: {size} lines, at most {LONGEST_FILE}; split it"
        for name, size in sizes.items()
        if size > LONGEST_FILE
    ]
    mains = {name: size for name, size in sizes.items() if name.endswith("__main__.py")}
    complaints += [
        f"{name}: {size} lines, a main has fewer than {LONGEST_MAIN}"
        for name, size in mains.items()
        if size >= LONGEST_MAIN
    ]
    none_of(complaints)


def test_no_function_is_too_long():
    none_of(
        [
            f"{name}:{node.lineno}: {node.name} has {node.end_lineno - node.lineno + 1} lines, "
            f"a function has fewer than {LONGEST_FUNCTION}"
            for name in files()
            for node in ast.walk(tree(name))
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
            and node.end_lineno - node.lineno + 1 >= LONGEST_FUNCTION
        ]
    )


def test_no_line_is_too_long():
    none_of(
        [
            f"{name}:{number}: {len(line)} characters, at most {LONGEST_LINE}"
            for name in files()
            for number, line in enumerate((ROOT / name).read_text("utf-8").splitlines(), start=1)
            if len(line) > LONGEST_LINE
        ]
    )


def test_every_file_class_and_public_function_says_what_it_is():
    complaints = []
    for name in files():
        if name.startswith("tests/"):
            continue
        for node in [tree(name), *_public(tree(name))]:
            if not ast.get_docstring(node):
                complaints.append(
                    f"{name}:{getattr(node, 'lineno', 1)}: {getattr(node, 'name', 'the file')} "
                    "has no docstring"
                )
    none_of(complaints)


def _public(node: ast.AST) -> list[ast.AST]:
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
    found = [
        one for one in getattr(node, "body", []) if isinstance(one, kinds) and not one.name.startswith("_")
    ]
    return found + [inner for one in found if isinstance(one, ast.ClassDef) for inner in _public(one)]


def test_the_readme_shows_the_address_book():
    readme = ROOT / "README.md"
    assert readme.exists(), "there is no README.md"
    assert channels.table() in readme.read_text("utf-8"), (
        "README.md: paste the output of wire.channels.table()"
    )


def test_the_address_book_covers_every_channel_once():
    keys = [channel.key for channel in channels.CHANNELS]
    assert len(set(keys)) == len(keys)
    assert channels.key("run1", channels.PERCEPT, "r7") == "picket/run1/node/r7/percept"
    assert channels.key("run1", channels.PERCEPT) == "picket/run1/node/*/percept"
    assert channels.node_of("picket/run1/node/r7/action") == "r7"
    assert all(f"`{key.format(node='<id>')}`" in channels.table() for key in keys)
    assert sorted(["r10", "r2", "base1", "r100"], key=channels.number_of) == ["base1", "r2", "r10", "r100"]

"""From the text of a patrolling_sim `.graph` file to a checked PatrolGraph.

A file is whitespace-separated tokens: number of nodes, image width and height in pixels, metres per pixel,
offset on both axes in metres; then for each node its id, pixel position and degree, and for each of its arcs
the neighbour, a compass direction and the cost in pixels. Files from before 2017 have no offsets.
"""

import re
from typing import NamedTuple, NoReturn

import msgspec

DIRECTIONS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")
MOST_NODES, MOST_ARCS = 200, 8  # what patrolling_sim itself can hold
MOST_WHOLE = 2**32 - 1  # its whole numbers are unsigned int
MOST_NUMBER = 1e9  # ours: products of two such numbers are finite
WRONG_HEADER_FAILS_BY = 9  # the token where a file read with the other header has always gone wrong

WHOLE = re.compile(r"[0-9]{1,20}")
NUMBER = re.compile(r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?")
NOT_TEXT = re.compile(r"[^\t\n\v\f\r -~]")


class GraphFileError(Exception):
    """A damaged graph file, in one line: the file, the line, the field, the value and what would be right."""

    def __init__(self, text: str) -> None:
        super().__init__(" ".join(text.splitlines()))


class Arc(msgspec.Struct, frozen=True):
    """One way from a node to a neighbour. The way back is the neighbour's, and may cost something else.

    The cost is no distance: it was measured along corridors or set by hand.
    """

    neighbour: int
    direction: str
    cost_px: int
    cost_m: float


class GraphNode(msgspec.Struct, frozen=True):
    """A place to visit; its id is its index in the graph. At most one arc leads to each neighbour."""

    id: int
    x_m: float
    y_m: float
    arcs: tuple[Arc, ...]


class PatrolGraph(msgspec.Struct, frozen=True):
    """Nodes and arcs over the image of a map, whose bottom left corner is at `offset_m`; y points up."""

    width_px: int
    height_px: int
    metres_per_px: float
    offset_m: tuple[float, float]
    nodes: tuple[GraphNode, ...]

    def edges(self) -> list[tuple[int, int]]:
        """Every pair of nodes with an arc in at least one direction, once, lower id first, sorted."""
        return sorted(
            {
                (min(node.id, arc.neighbour), max(node.id, arc.neighbour))
                for node in self.nodes
                for arc in node.arcs
            }
        )


def read_graph(content: str | bytes, file: str) -> PatrolGraph:
    """The graph in the content of a `.graph` file; `file` is its name in complaints. Raises GraphFileError.

    A second arc to the same neighbour is dropped if it costs the same (the shipped `example` has four).
    Whether there are offsets no file says: only one length of the header fits the number of tokens.
    """
    tokens = _tokens(content, file)
    complaints = []
    for with_offset in (True, False):
        cursor = _Cursor(tokens, file)
        try:
            return _graph(cursor, with_offset)
        except GraphFileError as error:
            beyond = cursor.at > WRONG_HEADER_FAILS_BY
            likely = (beyond, _count_fits(tokens, with_offset), cursor.at)
            complaints.append((likely, error))
    raise max(complaints, key=lambda one: one[0])[1]


def _tokens(content: str | bytes, file: str) -> list[tuple[int, str]]:
    """Every token with the number of its line."""
    text = content.decode("latin-1") if isinstance(content, bytes) else content
    alien = NOT_TEXT.search(text)
    if alien:
        line = text.count("\n", 0, alien.start()) + 1
        raise GraphFileError(
            f"{file}: line {line}: must be plain ASCII text, got the character {ascii(alien.group())}"
        )
    tokens = [(line, one) for line, words in enumerate(text.split("\n"), start=1) for one in words.split()]
    if not tokens:
        raise GraphFileError(f"{file}: line 1: the file is empty; it must begin with the number of nodes")
    return tokens


def _count_fits(tokens: list[tuple[int, str]], with_offset: bool) -> bool:
    """Whether a file of so many tokens can have this header: nodes have 4 tokens, arcs 3."""
    first = tokens[0][1]
    nodes = int(first) if WHOLE.fullmatch(first) else 0
    return (len(tokens) - (6 if with_offset else 4) - 4 * nodes) % 3 == 0


class _Cursor:
    """Takes token after token, each checked against what must stand there."""

    def __init__(self, tokens: list[tuple[int, str]], file: str) -> None:
        self.tokens, self.file, self.at = tokens, file, 0

    @property
    def line(self) -> int:
        """Line of the next token, or the last line where there is none."""
        return self.tokens[min(self.at, len(self.tokens) - 1)][0]

    def fail(self, field: str, right: str, suspect: str = "") -> NoReturn:
        """Refuse the next token, or its absence."""
        place = f"{self.file}: line {self.line}: {field} must be {right}"
        if self.at == len(self.tokens):
            raise GraphFileError(
                f"{place}, but the file ends here; it is cut off, or a count in it is too high"
            )
        value = self.tokens[self.at][1]
        also = f"; or is {suspect} wrong?" if suspect else ""
        shown = value if len(value) <= 24 else value[:24] + "..."
        raise GraphFileError(f"{place}, got {shown}{also}")

    def whole(self, field: str, least: int = 0, most: int = MOST_WHOLE, suspect: str = "") -> int:
        """Take a whole number."""
        right = f"a whole number from {least} to {most}" if least < most else f"{least}"
        text = self._next(field, right)
        if not WHOLE.fullmatch(text) or not least <= int(text) <= most:
            self.fail(field, right, suspect)
        self.at += 1
        return int(text)

    def number(self, field: str, least: float = -MOST_NUMBER, above: bool = False) -> float:
        """Take a number that is at least `least`, or, with `above`, more than that."""
        right = f"a number {'>' if above else '>='} {least:g} and <= {MOST_NUMBER:g}"
        text = self._next(field, right)
        value = float(text) if NUMBER.fullmatch(text) else None
        if value is None or not least <= value <= MOST_NUMBER or (above and value == least):
            self.fail(field, right)
        self.at += 1
        return value

    def direction(self, field: str, suspect: str) -> str:
        """Take a compass direction."""
        right = f"one of {' '.join(DIRECTIONS)}"
        text = self._next(field, right)
        if text not in DIRECTIONS:
            self.fail(field, right, suspect)
        self.at += 1
        return text

    def _next(self, field: str, right: str) -> str:
        if self.at == len(self.tokens):
            self.fail(field, right)
        return self.tokens[self.at][1]


class _Header(NamedTuple):
    count: int
    count_line: int
    width_px: int
    height_px: int
    metres_per_px: float
    offset_m: tuple[float, float]


def _graph(cursor: _Cursor, with_offset: bool) -> PatrolGraph:
    header = _header(cursor, with_offset)
    nodes = []
    suspect = ""
    for number in range(header.count):
        node, suspect = _node(cursor, header, number, suspect)
        nodes.append(node)
    if cursor.at < len(cursor.tokens):
        suspect = f"the number of nodes {header.count} (line {header.count_line}) or {suspect}"
        cursor.fail(f"what follows node {header.count - 1}", "nothing", suspect)
    return PatrolGraph(header.width_px, header.height_px, header.metres_per_px, header.offset_m, tuple(nodes))


def _header(cursor: _Cursor, with_offset: bool) -> _Header:
    line = cursor.line
    count = cursor.whole("number of nodes", 1, MOST_NODES)
    width_px, height_px = cursor.whole("image width in pixels", 1), cursor.whole("image height in pixels", 1)
    metres_per_px = cursor.number("metres per pixel", 0, above=True)
    offset_m = (0.0, 0.0)
    if with_offset:
        offset_m = (cursor.number("offset x in metres"), cursor.number("offset y in metres"))
    return _Header(count, line, width_px, height_px, metres_per_px, offset_m)


def _node(cursor: _Cursor, header: _Header, number: int, suspect: str) -> tuple[GraphNode, str]:
    """The node and what to suspect where the next one goes wrong."""
    place = f"node {number}:"
    cursor.whole(f"{place} id", number, number, suspect)
    x_px, y_px = cursor.number(f"{place} x in pixels", 0), cursor.number(f"{place} y in pixels", 0)
    degree_line = cursor.line
    degree = cursor.whole(f"{place} degree", 0, MOST_ARCS)
    suspect = f"the degree {degree} of node {number} (line {degree_line})"
    arcs: dict[int, Arc] = {}
    for one in range(1, degree + 1):
        arc = _arc(cursor, header, number, f"{place} arc {one}:", suspect)
        first = arcs.setdefault(arc.neighbour, arc)
        if first.cost_px != arc.cost_px:
            cursor.at -= 1
            right = f"{first.cost_px} as in the first arc to node {arc.neighbour}"
            cursor.fail(f"{place} arc {one}: cost", right)
    x_m = x_px * header.metres_per_px + header.offset_m[0]
    y_m = y_px * header.metres_per_px + header.offset_m[1]
    return GraphNode(number, x_m, y_m, tuple(arcs.values())), suspect


def _arc(cursor: _Cursor, header: _Header, origin: int, place: str, suspect: str) -> Arc:
    neighbour = cursor.whole(f"{place} neighbour", 0, header.count - 1, suspect)
    if neighbour == origin:
        cursor.at -= 1
        cursor.fail(f"{place} neighbour", "another node", suspect)
    direction = cursor.direction(f"{place} direction", suspect)
    cost_px = cursor.whole(f"{place} cost", 1, suspect=suspect)
    return Arc(neighbour, direction, cost_px, cost_px * header.metres_per_px)

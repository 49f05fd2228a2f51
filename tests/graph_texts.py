"""Texts of small patrol graphs, written here."""

HEADINGS = {(1, 0): "E", (-1, 0): "W", (0, 1): "N", (0, -1): "S"}

# Two header lines, then a node and its arcs per line. Node 1 lists node 0 twice; 1 to 2 costs 30, back 40.
SMALL = """\
4 200 100 0.05
-2.5 1.25
0 10 20 1  1 E 50
1 60.5 20 4  0 W 50  2 N 30  0 NW 50  3 SE 35
2 60 50 1  1 S 40
3 80 0 1  1 NW 35
"""
WITHOUT_OFFSET = SMALL.replace("-2.5 1.25\n", "")


def grid_text() -> str:
    """The `grid` of patrolling_sim: 5 columns of 5, numbered column by column from the top left."""
    lines = ["25 344 344 0.075 0 0"]
    for column in range(5):
        for row in range(5):
            arcs = [
                f"{5 * (column + right) + row - up} {heading} 76"
                for (right, up), heading in HEADINGS.items()
                if 0 <= column + right < 5 and 0 <= row - up < 5
            ]
            place = f"{5 * column + row} {19 + 76 * column} {325 - 76 * row}"
            lines.append(" ".join([place, str(len(arcs)), *arcs]))
    return "\n".join(lines) + "\n"

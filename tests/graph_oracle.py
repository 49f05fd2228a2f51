"""Patrol on a graph as a queue of arrivals: what a run with shared last visits must come to. No ticks here.

Source: M2Bench, arXiv 2605.09633: all robots know all last visits, those that arrive together decide on what
is known after all of them have arrived, the first best neighbour in ascending order wins, and the run ends
with the first arrival at or after the horizon. Times are exact fractions.
"""

import heapq
from collections.abc import Sequence
from fractions import Fraction

from wire.fields import Graph


def patrol(
    graph: Graph, starts: Sequence[int], rule: str, horizon_s: Fraction, exact_m: Fraction
) -> list[float]:
    """End, IGI, AGI, IWI and WI in seconds, at 1 m/s. `exact_m`: what all lengths are whole multiples of."""
    ways: list[dict[int, Fraction]] = [{} for _ in graph.nodes_m]
    for start, end, length_m in reversed(graph.edges):
        ways[start][end] = round(length_m / exact_m) * exact_m
        ways[end].setdefault(start, ways[start][end])
    for start, end, length_m in graph.edges:
        ways[start][end] = round(length_m / exact_m) * exact_m
    last_s = [Fraction(0)] * len(ways)

    def decide(here: int, now_s: Fraction) -> int:
        idle_s = {node: float(now_s - last_s[node]) for node in ways[here]}
        farthest_m, idlest_s = float(max(ways[here].values())), max(idle_s.values())

        def worth(node: int) -> float:
            if rule == "conscientious_reactive":
                return idle_s[node]
            near = (farthest_m - float(ways[here][node])) / farthest_m
            return near + (idle_s[node] / idlest_s if idlest_s > 0 else 0.0)

        return max(sorted(ways[here]), key=worth)

    coming = []
    for robot, here in enumerate(starts):
        node = decide(here, Fraction(0))
        heapq.heappush(coming, (ways[here][node], robot, node))
    before_s, area, worst_s = Fraction(0), Fraction(0), Fraction(0)
    while True:
        now_s = coming[0][0]
        idle_s = [now_s - one for one in last_s]
        mean_s = sum(idle_s) / len(idle_s)
        area, worst_s = area + mean_s * (now_s - before_s), max(worst_s, *idle_s)
        if now_s >= horizon_s:
            return [float(one) for one in (now_s, mean_s, area / now_s, max(idle_s), worst_s)]
        before_s, arrived = now_s, []
        while coming and coming[0][0] == now_s:
            arrived.append(heapq.heappop(coming)[1:])
        for _, node in arrived:
            last_s[node] = now_s
        for robot, here in arrived:
            node = decide(here, now_s)
            heapq.heappush(coming, (now_s + ways[here][node], robot, node))

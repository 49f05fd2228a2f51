"""`kill -9` of the line's tower: in the middle of recalls, at any moment, and within a grant."""

import random
import sqlite3
from itertools import pairwise
from pathlib import Path

import msgspec
import pytest

from deploy.run_folder import LEDGER
from swarm_agent.line_radio import Envelope, Order
from swarm_agent.node import Mind
from tests.line_courses import (
    NOISE,
    Doing,
    Run,
    desks_of,
    line_run,
    lives,
    rehearsed_deaths,
    rehearsed_line,
    run_of,
    times,
)
from tests.live_runs import launched, run_hash
from tower.ledger import Ledger
from wire import codec
from wire.messages import Facts, Frame, Percept
from wire.scenario import PlannedFault, Scenario
from world_server.journal import commits

RULES = ("base", "proactive", "leapfrog", "leapfrog+proactive")
DYING = "tower.behaviour=tests.dying_keeper:DyingKeeper"
DEAD_S = 600


def with_deaths(given: Scenario, deaths: list[tuple[int, str]]) -> Scenario:
    """The scenario with these deaths of its tower, for as long as they may take and somewhat longer."""
    tower = msgspec.structs.replace(given.tower, parameters=given.tower.parameters | {"deaths": deaths})
    return msgspec.structs.replace(given, tower=tower)


def moments(seed: int, given: Scenario, ways: list[str]) -> list[tuple[int, str]]:
    """When each life of the tower ends: at random, later lives not before the bound after their beginning."""
    chance, bound = random.Random(seed), int(times(given).after_birth) + 1
    first, *later = ways
    return [(chance.randint(0, 300), first), *((bound + chance.randint(0, 250), way) for way in later)]


def assert_well_survived(run: Run, copy: Path) -> list[int]:
    """All that must hold of a run whose tower died; returns how long coverage took after each rebirth."""
    allowed, slowest = times(run.scenario), []
    for begin, end in lives(run)[1:]:
        took = run.covered_after(begin)
        if end - begin > allowed.after_birth:
            assert set(took) == {1, 2, 3, 4}, f"after the start at tick {begin}"
            assert max(took.values()) <= allowed.after_birth, f"after the start at tick {begin}: {took}"
            slowest.append(max(took.values()))
    assert run.longest_double() <= NOISE * allowed.lap
    assert run.flat() == set()
    assert not [one for facts in run.facts for one in facts.incidents]
    assert_robots_obey_nobody_while_it_is_dead(run)
    assert_ledger_is_the_history(run, copy)
    return slowest


def assert_robots_obey_nobody_while_it_is_dead(run: Run) -> None:
    """They keep their segments, go home when low, and wait there; what was ordered before is finished."""
    lap = NOISE * times(run.scenario).lap
    dead = [(before[1], after[0]) for before, after in pairwise(lives(run))]
    known = {}
    for tick, node, word in run.words():
        before, known[node] = known.get(node), word
        since = next((begin for begin, end in dead if begin < tick < end), None)
        if since is None or (before.state, before.segment) == (word.state, word.segment):
            continue
        change = (before.state, word.state)
        of_itself = change in {("out", "patrol"), ("home", "queue")} or (change[1] == "home" and word.low)
        told_before = word.order // 1000 <= since and tick <= since + 2 * lap
        assert of_itself or told_before, f"{node} at tick {tick}, tower dead since {since}: {change}"


def assert_ledger_is_the_history(run: Run, copy: Path) -> None:
    """It has what a tower writes that is told what this one was told in committed grants, and no more."""
    rows = history(run.folder / LEDGER)
    said, granted = relived(run, copy)
    assert rows == history(copy)
    assert {grant for grant, *_ in rows} <= granted
    assert {tuple(row[2:]) for row in rows if row[1] == "order"} == said


def history(path: Path) -> list[tuple]:
    """All rows of a ledger."""
    with sqlite3.connect(path) as base:
        columns = '"grant", kind, node, segment, number, place, tick, battery_v, text'
        rows = base.execute(f'SELECT {columns} FROM history ORDER BY "grant", place').fetchall()
    base.close()
    return [
        (grant, kind, node, segment, number) + tuple(rest) * (kind != "order")
        for grant, kind, node, segment, number, *rest in rows
    ]


def relived(run: Run, copy: Path) -> tuple[set[tuple], set[int]]:
    """Let new minds live through what the tower was told, with a ledger of their own.

    Returns what was ordered in committed actions, as (robot, segment, number), and the committed grants.
    """
    tower, mind, payloads, ordered, granted = run.scenario.tower.id, Mind("tower"), {}, set(), set()
    for one in commits(run.folder / "journal"):
        for grant, action in zip(one.grants, one.actions, strict=True):
            for index, payload in enumerate(action.outbox):
                payloads[grant.node, one.tick, index] = payload
            if grant.node != tower:
                continue
            if grant.configuration is not None:
                mind = Mind("tower", Ledger(copy))
            inbox = tuple(
                Frame(ref.sender, ref.sent_tick, payloads[ref.sender, ref.sent_tick, ref.index])
                for ref in grant.inbox
            )
            told = Percept(one.tick, grant.grant, grant.why, grant.senses, inbox, grant.configuration)
            assert mind.answer(codec.encode(told)) == codec.encode(action)
            granted.add(grant.grant)
            messages = [codec.decode(Envelope, payload).message for payload in action.outbox]
            ordered |= {(word.to, word.segment, word.number) for word in messages if isinstance(word, Order)}
    return ordered, granted


def in_the_middle_of_three_recalls(folder: Path, rule: str) -> Scenario:
    """Batteries for ten minutes; the tower is killed as three robots are called home or on their way.

    Robots that go by themselves, under the other rules, are counted on their way: they say so as they leave.
    Proactive recall never lets three be on their way together; with a round every ten seconds it recalls
    three before the first of them is in the queue.
    """
    recalls = "proactive" in rule
    often = ["robots.parameters.report_laps=1", "tower.parameters.round_s=10", "tower.parameters.low_v=8.6"]
    together = ["battery.start_sd_v=0"]
    given = line_run("6r4s", 3600, 9.0, f"tower.parameters.rule={rule}", *(often if recalls else together))

    def three(facts: Facts, doing: Doing) -> bool:
        if recalls:
            return any(len(desk.recalled) == 3 for desk in desks_of(facts, "r1"))
        return [state for state, _ in doing.values()].count("home") >= 3

    run = rehearsed_line(folder / "undisturbed", given, until=three)
    tick = run.facts[-1].tick + 1
    assert tick < given.last_tick, "three were never away"
    faults = (
        PlannedFault(float(tick), "kill", ("r1",)),
        PlannedFault(float(tick + DEAD_S), "restart", ("r1",)),
    )
    duration_s = tick + DEAD_S + times(given).after_birth + 30
    return msgspec.structs.replace(given, faults=faults, duration_s=duration_s)


@pytest.mark.parametrize("rule", RULES)
def test_killed_in_the_middle_of_three_recalls_and_started_ten_minutes_later(rule, tmp_path):
    run = rehearsed_line(tmp_path / "run", in_the_middle_of_three_recalls(tmp_path, rule))
    slowest = assert_well_survived(run, tmp_path / "copy.sqlite")
    assert len(slowest) == 1
    (_, died), (born, _) = lives(run)
    words = [(node, word) for tick, node, word in run.words() if died < tick < born]
    low, last = {node for node, word in words if word.low}, dict(words)
    assert low, "somebody's battery ran low meanwhile"
    assert sum(word.state == "queue" for word in last.values()) >= 3
    assert {last[node].state for node in low} <= {"home", "queue"}


def test_the_processes_do_as_the_rehearsal_when_the_tower_is_killed_and_started_again(tmp_path):
    given = in_the_middle_of_three_recalls(tmp_path, "base")
    rehearsal, live = rehearsed_line(tmp_path / "run", given), run_of(given, launched(tmp_path, given))
    assert run_hash(live.folder) == run_hash(rehearsal.folder)
    assert history(live.folder / LEDGER) == history(rehearsal.folder / LEDGER)


WAYS = [
    ["boundary", "write", "action", "write", "boundary"],
    ["write", "action", "boundary", "action", "write"],
    ["action", "boundary", "write", "boundary", "action"],
    ["boundary", "action", "write", "action", "write"],
]


@pytest.mark.parametrize(("seed", "rule"), list(enumerate(RULES, start=1)))
def test_killed_at_five_random_moments_within_and_between_grants(seed, rule, tmp_path):
    """Twenty moments in all, each ten minutes before the next start."""
    settings = DYING, f"tower.parameters.rule={rule}"
    given = line_run("6r4s", 9000, 5.0 if seed % 2 else 9.0, *settings, seed=seed)
    given = with_deaths(given, moments(seed, given, WAYS[seed - 1]))
    run = rehearsed_deaths(tmp_path / "run", given, DEAD_S)
    slowest = assert_well_survived(run, tmp_path / "copy.sqlite")
    assert len(slowest) == len(lives(run)) - 1 == 5


def test_processes_that_kill_themselves_within_grants_do_as_the_rehearsal(tmp_path):
    """Three real SIGKILLs between ledger write and action, and three between action and grant."""
    given = line_run("6r4s", 9000, 14.0, DYING, "tower.parameters.rule=base")
    given = with_deaths(given, [(40 * life, ("write", "action")[life % 2]) for life in range(6)])
    rehearsal = rehearsed_deaths(tmp_path / "rehearsal", given, 60)
    assert len(rehearsal.faults("kill")) == len(rehearsal.faults("restart")) == 6
    folder = launched(tmp_path, rehearsal.scenario)
    assert run_hash(folder) == run_hash(rehearsal.folder)
    assert history(folder / LEDGER) == history(rehearsal.folder / LEDGER)
    assert_ledger_is_the_history(run_of(rehearsal.scenario, folder), tmp_path / "copy.sqlite")
    log = (folder / "events.jsonl").read_text()
    assert log.count("killed by signal 9") == 6

"""The trials of `picket reproduce lr-pt`: names, order, seeds, and what their scenarios say."""

from collections import Counter

import pytest

from deploy.scenario_file import ScenarioError
from deploy.studies.lr_pt import plan
from deploy.studies.trial import Trial, guest
from wire.scenario import Range


@pytest.fixture(scope="module")
def everything() -> list[Trial]:
    return plan.trials(plan.FULL, 10)


def named(trials: list[Trial], name: str) -> Trial:
    (found,) = (one for one in trials if one.name == name)
    return found


def test_every_kind_has_as_many_trials_as_it_should(everything):
    counts = Counter(one.kind for one in everything)
    assert counts == {
        "main": 5 * 3 * 10,
        "s8": 3 * 10,
        "s8-newest": 3 * 3,
        "literal": 3 * 3,
        "processes": 5,
        "failures-kept": 3,
        "failures-lost": 3,
    }
    assert len({one.name for one in everything}) == len(everything)


def test_seeds_follow_each_other_so_that_a_part_of_a_campaign_is_a_comparison(everything):
    seeds = [one.seed for one in everything]
    assert seeds == sorted(seeds) and set(seeds) == set(range(1, 11))
    first = [one.name for one in everything if one.seed == 1 and one.kind == "main"]
    algorithms = ["lr_pt", "expected_reactive", "expected_reactive-relay", "dtap", "chain_connected"]
    assert first == [f"{one}-n{nodes}-seed1" for nodes in (5, 10, 15) for one in algorithms]


def test_a_trial_is_the_field_of_the_paper_with_its_own_team_seed_and_times(everything):
    given = named(everything, "lr_pt-n15-seed7").scenario()
    assert (given.robots.count, given.seed, given.duration_s, given.metrics_from_s) == (14, 7, 43200, 10000)
    assert len(given.field.sites_m()) == 400 and given.radio.rules == (Range(180.0),)
    assert given.robots.parameters["report_priority_max_s"] == 425.0, "as published for N = 15"
    assert given.robots.parameters["lock_breaker"] == "excl" and given.faults == ()


def test_variants_say_what_they_vary(everything):
    few = named(everything, "lr_pt-s8-n5-seed10").scenario()
    letter = named(everything, "lr_pt-s8-newest-n5-seed3").scenario()
    for one, items in ((few, "unsent"), (letter, "newest")):
        assert one.robots.parameters["items_per_tick"] == one.tower.parameters["items_per_tick"] == 8
        assert one.robots.parameters["items"] == items
    literal = named(everything, "lr_pt-literal-n10-seed1").scenario()
    assert literal.robots.parameters["lock_breaker"] == "none"
    relay = named(everything, "expected_reactive-relay-n10-seed1").scenario()
    assert relay.robots.parameters["relay"] is True


def test_failures_are_real_kills_at_the_thirds_of_the_run(everything):
    for memory in ("kept", "lost"):
        trial = named(everything, f"lr_pt-failures-{memory}-n10-seed1")
        given = trial.scenario()
        assert trial.as_processes and given.duration_s == 129600
        assert [(one.verb, one.at_s) for one in given.faults] == [("kill", 43200), ("restart", 86400)]
        assert given.nodes_of(given.faults[0]) == ("r9", "r10") and given.faults[1].memory == memory


def test_what_is_rehearsed_can_all_run_as_processes_and_then_needs_no_sample():
    trials = plan.trials(plan.QUICK, 2, all_processes=True)
    assert all(one.as_processes for one in trials) and "processes" not in {one.kind for one in trials}


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("lr_pt-n5-seed1", 2),  # and the sample, not seed 10
        ("failures", 6),
        ("n5-", 10 * 5 + 10 + 3 + 3 + 5 + 2),
        ("dtap", 31),
        ("seed10", 18),
    ],
)
def test_only_takes_trials_by_a_part_of_their_name(text, count):
    assert len(plan.trials(plan.FULL, 10, only=text)) == count


def test_only_something_that_is_nowhere_is_a_mistake():
    with pytest.raises(ScenarioError, match="--only lrpt: no trial has this in its name"):
        plan.trials(plan.FULL, 1, only="lrpt")


def test_tuned_parameters_reach_their_algorithm_at_their_size_only(monkeypatch):
    monkeypatch.setattr(plan, "TUNED", {("expected_reactive", 10): {"distance_min_m": 12.5}})
    trials = plan.trials(plan.FULL, 1, only="expected_reactive-n")
    distances = {one.nodes: one.scenario().robots.parameters["distance_min_m"] for one in trials}
    assert distances == {5: 0.0, 10: 12.5, 15: 0.0}


def test_a_changed_source_gives_a_guest_another_name(tmp_path, monkeypatch):
    """Trials of an earlier version are not taken for trials of this one."""
    monkeypatch.syspath_prepend(str(tmp_path))
    source = (
        "from swarm_agent.behaviours.stand_still import StandStill\nclass Guest(StandStill):\n    '''{}'''\n"
    )
    names = []
    for version in ("one", "two"):
        (tmp_path / f"guest_{version}.py").write_text(source.format(version))
        names.append(guest(f"guest_{version}:Guest", ()).name)
    fingerprints = [name.split("-")[1] for name in names]
    assert names[0].startswith("guest_one.Guest-") and fingerprints[0] != fingerprints[1]


def test_who_is_in_the_comparison_already_is_no_guest():
    with pytest.raises(ScenarioError, match="--behaviour dtap: is in the comparison already"):
        guest("dtap", plan.ALGORITHMS)

"""What the README tells a newcomer to do, done."""

import re
import sys
from pathlib import Path

from deploy.metrics.area import AreaMetrics
from deploy.scenario_file import load_scenario
from tests.live_runs import as_processes, rehearsed, run_hash, small
from world_server.journal import commits

README = (Path(__file__).parent.parent / "README.md").read_text("utf-8")


def test_the_behaviour_of_the_readme_runs_from_a_file_of_its_own(tmp_path, monkeypatch):
    """As processes and rehearsed alike; it visits cells, and sleeps on the way."""
    (tmp_path / "wanderer.py").write_text(re.search(r"```python\n(.*?)```", README, re.DOTALL).group(1))
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}:{Path(__file__).parent.parent}")
    path = small(tmp_path, duration_s=400, behaviour="wanderer:Wanderer")
    live = as_processes(tmp_path, path)
    sys.modules.pop("wanderer", None)
    assert run_hash(live) == run_hash(rehearsed(tmp_path, path))
    metrics, grants = AreaMetrics(load_scenario(path)), 0
    for commit in commits(live / "journal"):
        metrics.feed(commit.facts)
        grants += sum(grant.node != "r1" for grant in commit.grants)
    assert metrics.visited_tick.max() > 0
    assert grants < 4 * 400 / 5

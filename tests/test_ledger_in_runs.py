"""The ledger of a run: in its folder, found again by a restarted tower, absent where nothing is written."""

from pathlib import Path

import pytest

from deploy.run_folder import LEDGER
from tests.builders import course, scripted
from tests.diarist import Diary
from tower.ledger import Ledger
from wire import codec
from wire.scenario import PlannedFault, TowerSection


def diary(folder: Path, *faults: PlannedFault) -> dict[int, Diary]:
    """What the tower reported by tick, in a rehearsal of twenty ticks."""
    tower = TowerSection(behaviour="tests.diarist:Diarist")
    given = scripted({}, [(5, 0)], tower=tower, faults=faults, duration_s=20.0)
    facts = course(given, folder).facts
    return {
        one.tick: codec.decode(Diary, told) for one in facts for node, told in one.reports if node == "r1"
    }


def test_a_run_whose_tower_writes_nothing_has_no_ledger(tmp_path: Path):
    course(scripted({}, [(5, 0)]), tmp_path, 5)
    assert not (tmp_path / LEDGER).exists()


@pytest.mark.parametrize("memory", ["lost", "kept"])
def test_a_killed_tower_finds_its_ledger_again(tmp_path: Path, memory: str):
    faults = [PlannedFault(5.0, "kill", ("r1",)), PlannedFault(9.0, "restart", ("r1",), memory=memory)]
    told = diary(tmp_path, *faults)
    assert told[4] == Diary(0, -1)
    assert told[9] == (Diary(5, 4) if memory == "lost" else Diary(0, -1))
    written = [one.tick for one in Ledger(tmp_path / LEDGER).read(10**6)]
    assert written == [*range(5), *range(9, 21)]


def test_a_new_run_in_an_old_folder_begins_anew(tmp_path: Path):
    diary(tmp_path)
    assert diary(tmp_path)[0] == Diary(0, -1)

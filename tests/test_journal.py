"""The journal: what was committed is read back, and whatever is not is detected."""

import io
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deploy.scenario_file import to_toml
from tests.builders import AWAKE, Course, course, facts, planned, scenario, scripted
from wire import codec
from wire.messages import Action, Senses
from wire.scenario import Loss, PlannedFault, RadioSection, Range
from world_server.clock import Clock
from world_server.journal import Journal, JournalError, commits, read
from world_server.records import Commit, End, Grant, Header
from world_server.world import World

# The journal


def records_of(path: Path) -> list[Header | Commit | End]:
    return list(read(path))


@pytest.fixture(scope="module")
def sound(tmp_path_factory) -> Course:
    """A run with loss and a death, whose journal tests damage."""
    plan = scenario(
        3,
        duration_s=12.0,
        radio=RadioSection((Range(180.0), Loss(0.3))),
        faults=(PlannedFault(5, "kill", ("r3",)),),
    )
    return course(plan, tmp_path_factory.mktemp("sound"))


def test_what_was_committed_is_read_back(tmp_path, monkeypatch):
    written: list[Commit] = []
    append = Journal.append
    monkeypatch.setattr(
        Journal, "append", lambda self, commit: (written.append(commit), append(self, commit))
    )
    run = course(scenario(2), tmp_path)
    header, *middle, end = records_of(run.journal)
    assert middle == written
    assert [one.facts for one in middle] == run.facts
    assert isinstance(header, Header) and header.nodes == ("r1", "r2", "r3")
    assert end == End(40, True, run.run_hash)


@given(st.data())
def test_a_journal_cut_anywhere_yields_only_whole_records(sound, tmp_path, data):
    whole, everything = sound.journal.read_bytes(), records_of(sound.journal)
    cut = data.draw(st.integers(0, len(whole)))
    (tmp_path / "cut").write_bytes(whole[:cut])
    found = records_of(tmp_path / "cut")
    assert found == everything[: len(found)]
    assert cut < len(whole) or found == everything


def test_a_journal_is_readable_up_to_the_last_commit_while_it_is_written(tmp_path):
    plan, stream = scenario(2), io.BytesIO()
    journal = Journal(stream, plan, to_toml(plan), b"")
    run = course(plan, tmp_path / "a", 8)
    for count, commit in enumerate(commits(run.journal), start=1):
        journal.append(commit)
        (tmp_path / "half").write_bytes(stream.getvalue())
        assert len(records_of(tmp_path / "half")) == count + 1


@settings(max_examples=300)
@given(st.data())
def test_a_flipped_bit_is_an_error_or_ends_the_journal_but_never_changes_a_record(sound, tmp_path, data):
    damaged, everything = bytearray(sound.journal.read_bytes()), records_of(sound.journal)
    place = data.draw(st.integers(0, len(damaged) - 1))
    damaged[place] ^= 1 << data.draw(st.integers(0, 7))
    (tmp_path / "damaged").write_bytes(damaged)
    try:
        found = records_of(tmp_path / "damaged")
    except JournalError as error:
        assert "damaged" in str(error)
    else:
        assert found == everything[: len(found)]


@pytest.mark.parametrize("what", ["toml", "poses", "end", "commit", "kind"])
def test_a_changed_record_is_detected(sound, tmp_path, what):
    damaged = _rewritten(sound.journal, what)
    (tmp_path / "damaged").write_bytes(damaged)
    with pytest.raises(JournalError, match="damaged"):
        records_of(tmp_path / "damaged")


def _rewritten(path: Path, what: str) -> bytes:
    """The journal with one byte of one record's content flipped, compressed anew."""
    import zstandard

    plain = bytearray(zstandard.ZstdDecompressor().decompressobj().decompress(path.read_bytes()))
    header, *_, end = records_of(path)
    place = {
        "toml": plain.find(b"duration_s"),
        "poses": plain.find(header.first_poses) + 30,
        "end": plain.rfind(codec.encode(end)) + 2,
        "commit": plain.find(b"lr_pt", plain.find(header.first_poses)),
        "kind": plain.rfind(codec.encode(end)) - 21,
    }[what]
    plain[place] ^= 1
    return zstandard.ZstdCompressor().compress(bytes(plain))


def test_a_file_that_is_no_journal_is_an_error_that_names_it(tmp_path):
    (tmp_path / "other").write_text("something else entirely, and long enough to be sure")
    with pytest.raises(JournalError, match="other"):
        records_of(tmp_path / "other")


def test_a_payload_is_stored_once_however_many_hear_it(tmp_path):
    letters = np.random.Generator(np.random.Philox(1)).integers(97, 123, 20_000)
    words = "".join(map(chr, letters))
    crowd = {f"r{number}": AWAKE for number in range(3, 12)}
    sizes = {}
    for name, listeners in (("many", 10), ("one", 2)):
        scripts = {"r2": {"say": {"0": [words]}}} | crowd
        sizes[name] = (
            course(scripted(scripts, [(0, 0)] * listeners), tmp_path / name, 10).journal.stat().st_size
        )
    assert sizes["many"] - sizes["one"] < 6_000
    assert sizes["one"] > 10_000


def test_the_clock_jumps_to_a_planned_fault_while_all_sleep(tmp_path):
    run = course(planned(PlannedFault(25, "kill", ("r2",)), scripts={}), tmp_path)
    assert [one.tick for one in run.facts] == [0, 25, 40]


def test_a_run_that_is_finished_early_ends_at_a_tick_boundary(tmp_path):
    plan = scenario(2)
    stream = io.BytesIO()

    class Finishing:
        finishing = False

        def exchange(self, tick, percepts):
            return {node: Action(tick, one.grant, wake_tick=tick + 1) for node, one in percepts.items()}

        def boundary(self, tick):
            return ()

        def show(self, commit):
            self.finishing = commit.tick == 7

    journal = Journal(stream, plan, "", b"")
    assert Clock(World(plan), Finishing(), journal, 40).run() == (7, False)
    (tmp_path / "journal").write_bytes(stream.getvalue())
    assert records_of(tmp_path / "journal")[-1] == End(7, False, journal.run_hash)


def test_a_commit_larger_than_any_message_is_read_back(tmp_path):
    """The bound on messages protects listeners; the journal of a large, loquacious swarm has its own."""
    plan, stream = scenario(2), io.BytesIO()
    grants = (Grant("r2", 0, "wake", Senses(), (), None),)
    said = Action(0, 0, outbox=(bytes(codec.MAX_BYTES + 1),))
    big = Commit(0, grants, (said,), (b"", b"", b"", b""), facts(0))
    Journal(stream, plan, "", b"").append(big)
    (tmp_path / "journal").write_bytes(stream.getvalue())
    assert records_of(tmp_path / "journal")[1] == big

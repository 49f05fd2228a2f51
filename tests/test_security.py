"""A robot cannot hear or speak out of turn, whoever joins its run and whatever is said there."""

import asyncio
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest
import zstandard

from deploy.launcher import Launcher
from deploy.recorder import events
from deploy.rehearsal import rehearse
from deploy.scenario_file import load_scenario, to_toml
from tests.insider import Loot
from tests.live_runs import as_processes, run_folder, run_hash, small
from tests.oracle import Oracle
from tests.siege import OTHER_SPARE, OVERSIZE, SCENARIO, SPARE, TICKS, Siege, attack
from wire import codec
from world_server.journal import commits, read


@pytest.fixture(scope="module")
def siege(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Siege]:
    """One live run, attacked by every rogue at once while it goes on."""
    place = tmp_path_factory.mktemp("siege")
    (place / "siege.toml").write_text(SCENARIO)
    scenario = load_scenario(place / "siege.toml")
    folder = run_folder(place, "besieged", scenario)
    (place / "private").mkdir(mode=0o700)
    ticks: list[int] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_RUNTIME_DIR", str(place / "private"))
        launcher = Launcher(scenario, folder, TICKS, lambda facts: ticks.append(facts.tick))

        async def run() -> dict[str, Any]:
            async with asyncio.TaskGroup() as both:  # an attack that fails ends the run
                both.create_task(launcher.run(None, print))
                attacking = both.create_task(asyncio.to_thread(attack, launcher, ticks, folder))
            return attacking.result()

        seen = asyncio.run(run())
    left = any((place / "private").glob("picket-*/*"))
    yield Siege(folder, launcher.book, events=events(folder), operator_file_left=left, **seen)


@pytest.mark.parametrize("rogue", ["nobody", "guesser", "twin", "twin of the launcher"])
def test_whoever_has_no_password_or_a_session_that_is_taken_is_refused(siege: Siege, rogue: str) -> None:
    assert siege.rogues[rogue]["joined"] is False


@pytest.mark.parametrize("rogue", ["spare", "thief", "thief of the launcher"])
def test_a_rogue_that_may_join_hears_nothing_that_is_not_its_own(siege: Siege, rogue: str) -> None:
    assert siege.rogues[rogue]["tried"]
    assert siege.heard_by(rogue) == set()


def test_an_observer_hears_the_world_and_nothing_else(siege: Siege) -> None:
    assert siege.heard_by("observer") == {"world/truth", "world/event"}


def test_an_operator_is_answered_and_hears_nothing(siege: Siege) -> None:
    assert siege.heard_by("operator") == {"control"}


def test_the_attacked_run_ends_with_the_hash_of_a_run_without_rogues(siege: Siege, tmp_path: Path) -> None:
    *_, end = read(siege.folder / "journal")
    scenario = load_scenario(siege.folder / "scenario.toml")
    undisturbed = rehearse(scenario, to_toml(scenario), tmp_path, TICKS).run_hash
    assert (end.tick, end.completed, end.run_hash) == (TICKS, True, undisturbed)


def test_what_a_spare_says_on_its_own_key_is_an_event_with_its_id(siege: Siege) -> None:
    refused = [one for one in siege.events if one["kind"] == "refused"]
    assert {one["node"] for one in refused} == {SPARE}
    assert {one["data"]["count"] for one in refused if "bytes" in one["data"]} == {1, 10, 100}


def test_a_deletion_does_not_reach_the_world_even_on_its_own_key(siege: Siege) -> None:
    """It was sent first; the first that arrived is the first message after it."""
    first = next(one for one in siege.events if "bytes" in one["data"])
    assert first["data"]["bytes"] == OVERSIZE


def test_nothing_but_the_spares_own_words_reached_the_world(siege: Siege) -> None:
    kinds = {one["kind"] for one in siege.events} - {"late", "watchdog"}  # a busy machine may be told of
    assert kinds == {"refused", "stranger", "end"}


def test_a_foreign_token_neither_raises_nor_ends_a_life(siege: Siege) -> None:
    assert siege.alive_after == ["r1", "r2", "r3", "r4", "r5"]


def test_a_borrowed_password_is_reported_with_the_process_that_uses_it(siege: Siege) -> None:
    told = [one["text"] for one in siege.events if one["kind"] == "stranger"]
    assert len(told) == 2
    for rogue in ("thief", "thief of the launcher"):
        assert any(
            f"process {siege.rogues[rogue]['pid']} (" in text and "tests.rogue" in text for text in told
        )


def test_an_agent_process_holds_no_socket_but_its_link(siege: Siege) -> None:
    port = int(siege.book.endpoint.rpartition(":")[2])
    for node in siege.book.nodes.keys() - {SPARE, OTHER_SPARE}:
        (only,) = siege.sockets[node]
        assert (only.status, only.raddr) == (psutil.CONN_ESTABLISHED, ("127.0.0.1", port)), node


def test_nothing_of_a_run_listens_beyond_loopback(siege: Siege) -> None:
    listening = [one for all_of_one in siege.sockets.values() for one in all_of_one if not one.raddr]
    port = int(siege.book.endpoint.rpartition(":")[2])
    assert [tuple(one.laddr) for one in listening] == [("127.0.0.1", port)]


def test_no_secret_is_in_a_command_line_an_environment_or_the_run_folder(siege: Siege) -> None:
    places = siege.public | {
        str(place): place.read_bytes() for place in siege.folder.rglob("*") if place.is_file()
    }
    places["journal, expanded"] = (
        zstandard.ZstdDecompressor().decompressobj().decompress((siege.folder / "journal").read_bytes())
    )
    assert len(places) > 15
    for one in siege.book.everyone:
        for secret in (one.password, one.session):
            assert not [name for name, data in places.items() if secret.encode() in data]


def test_the_operators_file_is_private_and_gone_after_the_run(siege: Siege) -> None:
    assert siege.operator_file == (0o600, 0o700)
    assert not siege.operator_file_left


def rehearsed_apart(folder: Path, team: Path) -> Path:
    """A rehearsal in a process without a link for the insider to find; this one has had several."""
    out = folder / "apart"
    command = [sys.executable, "-m", "deploy", "run", str(team), "--in-process", "--dashboard", "off"]
    subprocess.run([*command, "--out", str(out)], check=True, capture_output=True)
    return next(out.iterdir())


def test_a_robot_that_misuses_its_own_link_hears_nothing_and_changes_nothing(tmp_path: Path) -> None:
    team = small(tmp_path, duration_s=60, behaviour="tests.insider:Insider")
    live = as_processes(tmp_path, team)
    reports = [
        report for one in commits(live / "journal") for node, report in one.facts.reports if node != "r1"
    ]
    assert {codec.decode(Loot, report).keys for report in reports} == {()}
    assert run_hash(live) == run_hash(rehearsed_apart(tmp_path, team))
    refused = [one for one in events(live) if one["kind"] == "refused"]
    assert {one["node"] for one in refused} == {"r2", "r3", "r4", "r5"}
    whys = ("no grant is open", "malformed", "stale")
    assert all(any(why in one["text"] for why in whys) for one in refused)
    Oracle(load_scenario(team)).check(live / "journal")

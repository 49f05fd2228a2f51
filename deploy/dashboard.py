"""The dashboard: an ear and no mouth. Makes recordings of runs, and shows live ones."""

import argparse
import math
import os
import sys
from pathlib import Path

import msgspec

from deploy.drawing import FileSink, LiveSink
from deploy.following import Follower, Handover, Sink, read_events
from deploy.scene import Scene
from deploy.viewer import ViewerError, choose_mode, launch
from wire import channels
from wire.credentials import Ticket, die_with_parent, receive
from wire.link import LinkError, open_client
from wire.messages import Event, TruthBlock
from wire.scenario import Scenario
from world_server.journal import JournalError, commits, read

SNAPSHOTS_AT_MOST = 750
FLUSH_WITHIN_S = 5.0


def record(folder: Path, every_s: float | None = None) -> Path:
    """Make `recording.rrd` of a run folder from its journal and event log, whole or cut off.

    `every_s`: time between snapshots; None: as many as SNAPSHOTS_AT_MOST allows. Raises JournalError.
    """
    journal = folder / "journal"
    header = next(read(journal), None)
    if header is None:
        raise JournalError(f"{journal}: empty; the run was killed before its first tick")
    scene = Scene(msgspec.toml.decode(header.scenario_toml, type=Scenario))
    events = read_events(folder / "events.jsonl")
    for event in events:
        scene.note(event)
    last_tick = _last_tick(events, journal)
    period = _period_ticks(scene.scenario, last_tick, every_s)
    part = folder / "recording.rrd.part"
    sink = FileSink(part, folder.name, scene, last_tick * scene.scenario.tick_s)
    due, shown_s = 0, -1.0
    for commit in commits(journal):
        scene.take(commit.facts)
        if commit.tick >= due:
            sink.show(scene.snapshot())
            due, shown_s = commit.tick + period, scene.time_s
    if scene.time_s > shown_s:
        sink.show(scene.snapshot())
    sink.close()
    return part.replace(folder / "recording.rrd")


def _last_tick(events: list[Event], journal: Path) -> int:
    ends = [event.tick for event in events if event.kind == "end"]
    return ends[-1] if ends else max((commit.tick for commit in commits(journal)), default=0)


def _period_ticks(scenario: Scenario, last_tick: int, every_s: float | None) -> int:
    if every_s is not None:
        return max(1, scenario.tick_of(every_s))
    return math.ceil((last_tick + 1) / SNAPSHOTS_AT_MOST)


def main() -> int:
    """The live dashboard of one run, started by the launcher."""
    parser = argparse.ArgumentParser(description="The live dashboard of one run; started by the launcher.")
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--ticket-fd", type=int, required=True)
    parser.add_argument("--parent-pid", type=int, required=True)
    parser.add_argument("--mode", choices=("auto", "native", "web", "file"), default="auto")
    parser.add_argument("--say-fd", type=int)
    parser.add_argument("--linger", action="store_true", help="stay until the viewer is closed")
    given = parser.parse_args()
    die_with_parent(given.parent_pid)
    ticket = receive(given.ticket_fd, Ticket)
    scene = Scene(msgspec.toml.decode((given.folder / "scenario.toml").read_text("utf-8"), type=Scenario))
    mode, whole_s = choose_mode(given.mode), scene.scenario.duration_s
    viewer = None if mode == "file" else launch(mode, given.folder / "logs" / "viewer.log")

    def make() -> Sink:
        if viewer is None:
            sink, address = FileSink(given.folder / "live.rrd", ticket.run, scene, whole_s), "live.rrd"
        else:
            viewer.wait_until_open()
            sink, address = LiveSink(viewer.url, ticket.run, scene), viewer.address
        if given.say_fd is not None:
            os.write(given.say_fd, f"{address}\n".encode())
        return sink

    link = open_client(ticket)
    handover = Handover(make)
    follower = Follower(scene, handover.put, given.folder)
    truth, events = channels.key(ticket.run, channels.TRUTH), channels.key(ticket.run, channels.EVENT)
    link.subscribe(truth, lambda _, data: follower.enqueue(TruthBlock, data))
    link.subscribe(events, lambda _, data: follower.enqueue(Event, data))
    follower.follow(lambda: not handover.trouble and (viewer is None or viewer.process.poll() is None))
    if viewer is not None and viewer.process.poll() is not None:
        return viewer.explain_end()
    flushed = handover.finish(FLUSH_WITHIN_S)
    if handover.trouble or not flushed:
        raise ViewerError(handover.trouble or "the viewer hangs; it did not take the last picture")
    return viewer.process.wait() if given.linger and viewer is not None else 0


if __name__ == "__main__":
    try:
        status = main()
    except KeyboardInterrupt:
        status = 0
    except (LinkError, ViewerError) as error:
        print(error, file=sys.stderr, flush=True)
        status = 3
    os._exit(status)  # a sink that hangs, or Zenoh's threads, must not keep us here

"""The world process: `python -m world_server RUN_FOLDER --book-fd N --ready-fd M --parent-pid P`."""

import argparse
import gc
import os
import sys
from pathlib import Path

import msgspec

from wire.credentials import Book, die_with_parent, fresh, receive
from wire.link import LinkError, open_router
from wire.messages import Event
from wire.scenario import Scenario
from world_server.access import access_control
from world_server.clock import Abort, Clock
from world_server.events import EventLog
from world_server.exchange import LiveSwarm
from world_server.journal import Journal
from world_server.world import World


def main() -> int:
    """Open the router, gather the nodes, run the clock; everything that lasts is in the run folder."""
    parser = argparse.ArgumentParser(description="The world of one run; started by the launcher.")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--book-fd", type=int, required=True)
    parser.add_argument("--ready-fd", type=int, required=True)
    parser.add_argument("--last-tick", type=int, required=True)
    parser.add_argument("--parent-pid", type=int, required=True)
    given = parser.parse_args()
    die_with_parent(given.parent_pid)
    book = receive(given.book_fd, Book)
    text = (given.folder / "scenario.toml").read_text("utf-8")
    scenario = msgspec.toml.decode(text, type=Scenario)
    world = World(scenario)
    with (given.folder / "journal").open("wb") as stream, (given.folder / "events.jsonl").open("w") as events:
        journal = Journal(stream, scenario, text, world.poses().tobytes())
        link = open_router(book, access_control(book), fresh("world"))
        swarm = LiveSwarm(link, book, scenario, EventLog(events, scenario.tick_s).write)
        os.write(given.ready_fd, b"ready\n")
        swarm.gather()
        gc.freeze()
        tick, completed = Clock(world, swarm, journal, given.last_tick).run()
        swarm.tell(Event(tick, "end", "", f"run hash {journal.run_hash}", {"completed": completed}))
        swarm.finish(tick)
        link.close()
    return 0


if __name__ == "__main__":
    try:
        status = main()
    except (Abort, LinkError) as error:
        print(error, file=sys.stderr, flush=True)
        status = 3
    sys.stdout.flush()
    os._exit(status)

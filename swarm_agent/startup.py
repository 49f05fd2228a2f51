"""How a node process begins: die with the parent, take the ticket, remember a former life, live."""

import argparse
import os

from swarm_agent.node import live, percepts_of
from wire.credentials import Ticket, die_with_parent, receive


def run_node(package: str) -> None:
    """Main of a robot or a tower; `package` is where its behaviours are found by name."""
    parser = argparse.ArgumentParser(description="One node of a run; started by the launcher.")
    parser.add_argument("node", help="its id, for those who read a list of processes")
    parser.add_argument("--ticket-fd", type=int, required=True)
    parser.add_argument("--memory-fd", type=int)
    parser.add_argument("--parent-pid", type=int, required=True)
    given = parser.parse_args()
    die_with_parent(given.parent_pid)
    ticket = receive(given.ticket_fd, Ticket)
    memory = b""
    if given.memory_fd is not None:
        with os.fdopen(given.memory_fd, "rb") as stream:
            memory = stream.read()
    live(ticket, package, percepts_of(memory))
    os._exit(0)  # Zenoh's threads may outlive a closed session; there is nothing left to save

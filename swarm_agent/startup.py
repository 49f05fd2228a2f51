"""How a node process begins: die with the parent, take the ticket, remember a former life, live."""

import argparse
import os
from collections.abc import Callable

from swarm_agent.behaviour import Ledger
from swarm_agent.node import live, percepts_of
from wire.credentials import Ticket, die_with_parent, receive


def run_node(package: str, open_ledger: Callable[[str], Ledger] | None = None) -> None:
    """Main of a robot or a tower; `package` is where its behaviours are found by name.

    `open_ledger` makes a ledger of the path behind --ledger, for a node that can have one.
    """
    parser = argparse.ArgumentParser(description="One node of a run; started by the launcher.")
    parser.add_argument("node", help="its id, for those who read a list of processes")
    parser.add_argument("--ticket-fd", type=int, required=True)
    parser.add_argument("--memory-fd", type=int)
    parser.add_argument("--parent-pid", type=int, required=True)
    if open_ledger is not None:
        parser.add_argument("--ledger", help="the file in which the node writes down what it must not forget")
    given = parser.parse_args()
    die_with_parent(given.parent_pid)
    ticket = receive(given.ticket_fd, Ticket)
    memory = b""
    if given.memory_fd is not None:
        with os.fdopen(given.memory_fd, "rb") as stream:
            memory = stream.read()
    ledger = open_ledger(given.ledger) if open_ledger is not None and given.ledger else None
    live(ticket, package, percepts_of(memory), ledger)
    os._exit(0)  # Zenoh's threads may outlive a closed session; there is nothing left to save

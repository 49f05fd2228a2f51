"""The bare wire, to compare with: messages of given sizes from a router to N clients and back, no more.

The same link, credentials, access rules and lockstep as a run, but no codec, no world and no minds.
`python -m deploy.floor coordinator|node --plan-fd N ...`; started by the bench.
"""

import argparse
import os
import time
from queue import SimpleQueue
from typing import Any

import msgspec

from wire import channels
from wire.credentials import Book, Credential, Ticket, die_with_parent, receive
from wire.link import open_client, open_router

Sizes = tuple[tuple[int, ...], ...]


class CoordinatorPlan(msgspec.Struct, frozen=True):
    """`percept_bytes`: for every tick the size of each node's percept, in the order of the book's nodes."""

    book: Book
    access_control: dict[str, Any]
    world: Credential
    percept_bytes: Sizes


class NodePlan(msgspec.Struct, frozen=True):
    """`action_bytes`: for every tick the size of this node's action."""

    ticket: Ticket
    action_bytes: tuple[int, ...]


def coordinate(plan: CoordinatorPlan, order_fd: int, report_fd: int) -> None:
    """Wait for all nodes; then, for every number of ticks that is ordered, run them and tell the seconds."""
    link = open_router(plan.book, plan.access_control, plan.world)
    run, nodes = plan.book.run, tuple(plan.book.nodes)
    actions, tokens = SimpleQueue(), SimpleQueue()
    percepts = [link.publisher(channels.key(run, channels.PERCEPT, node)) for node in nodes]
    link.subscribe(channels.key(run, channels.ACTION), lambda _, data: actions.put(data))
    link.watch_tokens(channels.key(run, channels.ALIVE), lambda key, alive: tokens.put(key))
    with os.fdopen(order_fd) as orders, os.fdopen(report_fd, "w", buffering=1) as reports:
        print("listening", file=reports)
        for _ in nodes:
            tokens.get()
        print("ready", file=reports)
        blob, rest = bytes(max(map(max, plan.percept_bytes))), iter(plan.percept_bytes)
        for order in orders:
            began = time.perf_counter()
            for _ in range(int(order)):
                for percept, size in zip(percepts, next(rest), strict=True):
                    percept.put(blob[:size])
                for _ in percepts:
                    actions.get()
            print(time.perf_counter() - began, file=reports)
    link.close()


def answer(plan: NodePlan) -> None:
    """Answer every percept with an action of the planned size."""
    ticket, received = plan.ticket, SimpleQueue()
    node, blob = ticket.credential.user, bytes(max(plan.action_bytes))
    link = open_client(ticket)
    action = link.publisher(channels.key(ticket.run, channels.ACTION, node))
    link.subscribe(channels.key(ticket.run, channels.PERCEPT, node), lambda _, data: received.put(data))
    link.announce(channels.key(ticket.run, channels.ALIVE, node))
    for size in plan.action_bytes:
        received.get()
        action.put(blob[:size])
    received.get()  # none comes: the bench ends this process


def main() -> None:
    """One process of the floor."""
    parser = argparse.ArgumentParser(description="One process of the bare wire; started by the bench.")
    parser.add_argument("role", choices=("coordinator", "node"))
    parser.add_argument("--plan-fd", type=int, required=True)
    parser.add_argument("--order-fd", type=int)
    parser.add_argument("--report-fd", type=int)
    parser.add_argument("--parent-pid", type=int, required=True)
    given = parser.parse_args()
    die_with_parent(given.parent_pid)
    if given.role == "node":
        answer(receive(given.plan_fd, NodePlan))
    else:
        coordinate(receive(given.plan_fd, CoordinatorPlan), given.order_fd, given.report_fd)
    os._exit(0)  # Zenoh's threads may outlive a closed session


if __name__ == "__main__":
    main()

"""Who may say and hear what: the router's access rules, default deny, made from the address book.

A right belongs to a user name together with the session id of its one process, so a second connection with
the same password has no rights. Which Zenoh messages each kind of subject needs was measured with 1.10.2:
a query needs `query` inwards and `reply` outwards, and no declaration.
"""

from typing import Any

from wire import channels
from wire.credentials import OBSERVERS, OPERATORS, SUPERVISOR, Book

Need = tuple[str, str, str]
"""A Zenoh message type, its direction as the router sees it, and a key expression."""


def access_control(book: Book) -> dict[str, Any]:
    """Zenoh's `access_control` section for all credentials of a run, spares included."""
    run = book.run
    needs = {node: _node(run, node) for node in book.nodes}
    needs |= {observer: _observer(run) for observer in OBSERVERS}
    needs |= {operator: _operator(run) for operator in OPERATORS}
    needs[SUPERVISOR] = _supervisor(run)
    rules = [
        {
            "id": f"{user}-{number}",
            "permission": "allow",
            "messages": [message],
            "flows": [flow],
            "key_exprs": [key],
        }
        for user, wanted in needs.items()
        for number, (message, flow, key) in enumerate(wanted)
    ]
    subjects = [{"id": one.user, "usernames": [one.user], "zids": [one.session]} for one in book.everyone]
    policies = [
        {"id": f"policy-{user}", "rules": [f"{user}-{n}" for n in range(len(wanted))], "subjects": [user]}
        for user, wanted in needs.items()
    ]
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": subjects,
        "policies": policies,
    }


def _hears(key: str) -> list[Need]:
    return [("declare_subscriber", "ingress", key), ("put", "egress", key)]


def _says(key: str, declared: str) -> list[Need]:
    """`declared` is the world's own subscription, which the sender's publisher waits to learn of."""
    return [("put", "ingress", key), ("declare_subscriber", "egress", declared)]


def _node(run: str, node: str) -> list[Need]:
    alive = channels.key(run, channels.ALIVE, node)
    return [
        *_says(channels.key(run, channels.ACTION, node), channels.key(run, channels.ACTION)),
        *_hears(channels.key(run, channels.PERCEPT, node)),
        ("liveliness_token", "ingress", alive),
    ]


def _observer(run: str) -> list[Need]:
    return [*_hears(channels.key(run, channels.TRUTH)), *_hears(channels.key(run, channels.EVENT))]


def _operator(run: str) -> list[Need]:
    control = channels.key(run, channels.CONTROL)
    return [("query", "ingress", control), ("reply", "egress", control)]


def _supervisor(run: str) -> list[Need]:
    notice = channels.key(run, channels.NOTICE)
    return [*_hears(channels.key(run, channels.ORDER)), *_says(notice, notice), *_observer(run)]

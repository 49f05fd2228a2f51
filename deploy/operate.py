"""An operator's requests to a live run, from any terminal of the user who started it."""

import secrets

from deploy.run_folder import RunError, find_live
from wire import channels, codec
from wire.credentials import Ticket
from wire.link import LinkError, open_client
from wire.messages import Reply, Request

ATTEMPTS = 3
ANSWER_WITHIN_S = 600.0  # a node restarted with its memory lives through all of it first


def request(run: str, wanted: Request) -> Reply:
    """Ask a live run for something and return its answer. Raises RunError."""
    for ticket in secrets.SystemRandom().sample(find_live(run).tickets, ATTEMPTS):
        data = _ask(run, ticket, wanted)
        if data is not None:
            return codec.decode(Reply, data)
        find_live(run)  # a session of the same id that is not quite gone yet can swallow a question
    raise RunError(f"{run}: the run ended before it answered")


def _ask(run: str, ticket: Ticket, wanted: Request) -> bytes | None:
    try:
        link = open_client(ticket)
    except LinkError as error:
        raise RunError(f"{run}: {error}") from None
    try:
        control = channels.key(ticket.run, channels.CONTROL)
        return link.ask(control, codec.encode(wanted), ANSWER_WITHIN_S)
    finally:
        link.close()

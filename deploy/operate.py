"""An operator's requests to a live run, from any terminal of the user who started it."""

from deploy.run_folder import RunError, find_live
from wire import channels, codec
from wire.link import LinkError, open_client
from wire.messages import Reply, Request

ANSWER_WITHIN_S = 600.0  # a node restarted with its memory lives through all of it first


def request(run: str, wanted: Request) -> Reply:
    """Ask a live run for something and return its answer. Raises RunError."""
    live = find_live(run)
    try:
        link = open_client(live.ticket)
    except LinkError as error:
        raise RunError(f"{run}: {error}") from None
    try:
        data = link.ask(
            channels.key(live.ticket.run, channels.CONTROL), codec.encode(wanted), ANSWER_WITHIN_S
        )
    finally:
        link.close()
    if data is None:
        raise RunError(f"{run}: the run ended before it answered")
    return codec.decode(Reply, data)

"""The tower: `python -m tower NODE --ticket-fd N --parent-pid P [--memory-fd M] [--ledger FILE]`."""

from swarm_agent.startup import run_node
from tower.ledger import Ledger

if __name__ == "__main__":
    run_node("tower", Ledger)

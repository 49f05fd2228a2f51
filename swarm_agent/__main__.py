"""A robot process: `python -m swarm_agent NODE --ticket-fd N --parent-pid P [--memory-fd M]`."""

from swarm_agent.startup import run_node

if __name__ == "__main__":
    run_node("swarm_agent.behaviours")

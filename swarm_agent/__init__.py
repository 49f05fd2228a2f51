"""Inside a robot process: the node loop, the behaviours, and what robots know."""

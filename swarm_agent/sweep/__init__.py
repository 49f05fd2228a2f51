"""Inside a robot of a sweep team: what it sees, whom it stands beside, and how it moves."""

"""The tower: base station, queue and recall. A node that cannot move and merges what it hears."""

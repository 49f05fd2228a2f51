"""The world: physics, sensing, radio and clock; the only process that knows the truth."""

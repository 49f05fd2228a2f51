"""What is wrong with a scenario whose types are right."""


class Mistake(Exception):
    """Field, value, and what would be right."""

"""Deterministic property tests: the same examples on every machine, and no deadline that load could miss."""

from hypothesis import HealthCheck, settings

settings.register_profile(
    "picket",
    derandomize=True,
    deadline=None,
    database=None,
    max_examples=40,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
settings.load_profile("picket")

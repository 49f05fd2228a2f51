"""That no part of a scenario belongs to another mission than its own."""

from deploy.mistake import Mistake
from wire.fields import FloorPlan, Graph, Grid, Polyline
from wire.scenario import Cluster, Fan, InQueue, PlannedFault, Poses, Scenario

FIELDS = {"area": (Grid, Graph), "line": (Polyline,), "clear": (FloorPlan,)}
STARTS = {"area": (Fan, Poses, tuple), "line": (InQueue, Poses), "clear": (Cluster, Poses)}


def check_mission(scenario: Scenario) -> None:
    """Raises Mistake where a part belongs to another mission."""
    mission, robots = scenario.mission, scenario.robots
    kinds = FIELDS[mission]
    if not isinstance(scenario.field, kinds):
        right, got = " or ".join(map(_kind, kinds)), _kind(type(scenario.field))
        raise Mistake(f"field.kind must be {right} for mission {mission}, got {got}")
    if not isinstance(robots.start, STARTS[mission]):
        right = " or ".join(_kind(one) for one in STARTS[mission] if one is not tuple)
        is_list = isinstance(robots.start, tuple)
        place, got = ("", "a list of sites") if is_list else (".kind", _kind(type(robots.start)))
        raise Mistake(f"robots.start{place} must be {right} for mission {mission}, got {got}")
    if mission != "area" and robots.shared_last_visit:
        raise Mistake("robots.shared_last_visit is for mission area only")
    if mission != "line" and scenario.battery is not None:
        raise Mistake("battery is for mission line only")
    if mission != "clear" and scenario.sensors is not None:
        raise Mistake("sensors is for mission clear only")
    for number, fault in enumerate(scenario.faults):
        _check_fault(mission, fault, f"faults[{number}]")


def _check_fault(mission: str, fault: PlannedFault, place: str) -> None:
    if mission != "line" and fault.place == "queue":
        raise Mistake(f"{place}.place must be here for mission {mission}, got queue")
    if mission != "clear" and fault.role:
        raise Mistake(f"{place}.role is for mission clear only")
    if mission != "clear" and fault.when_cleared_share is not None:
        raise Mistake(f"{place}.when_cleared_share is for mission clear only")


def _kind(variant: type) -> str:
    return variant.__struct_config__.tag

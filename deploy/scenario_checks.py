"""What the types of a scenario cannot say: that its parts fit together."""

from deploy.field_checks import check_field, check_start
from deploy.line_checks import check_line
from deploy.mission_checks import check_mission
from deploy.mistake import Mistake
from wire.channels import number_of
from wire.messages import BEFALLS
from wire.scenario import Latency, Partition, PlannedFault, Poses, Scenario

MAX_TICKS = 2**32 - 1  # times of visits travel as uint32

AFTER = {"kill": "dead", "restart": "alive", "freeze": "frozen", "thaw": "alive", "slow": "alive"}


def check(scenario: Scenario) -> None:
    """Raises Mistake for the first part that does not fit."""
    check_mission(scenario)
    _check_names(scenario)
    _check_sizes(scenario)
    if scenario.mission == "line":
        check_line(scenario)
    elif scenario.mission == "clear":
        from deploy.clear_checks import check_clear  # polygons take a while to import

        check_clear(scenario)
    else:
        check_field(scenario.field)
        check_start(scenario)
    _check_radio(scenario)
    _check_faults(scenario)


def _check_names(scenario: Scenario) -> None:
    robots = scenario.robots
    counted = robots.count is not None or isinstance(robots.start, tuple)
    if robots.ids is not None and robots.count is not None or robots.ids is None and not counted:
        raise Mistake("robots needs either count or ids, or a list of sites as start")
    numbers: dict[int, str] = {}
    for node in (scenario.tower.id, *(scenario.robots.ids or ())):
        number = number_of(node)
        if numbers.get(number) == node:
            raise Mistake(f"robots.ids: there are two nodes {node}; ids are unique")
        if number in numbers:
            both = f"{node} and {numbers[number]}"
            raise Mistake(f"robots.ids: {both} share the number {number}; numbers are unique")
        numbers[number] = node
    if any(number_of(node) > 9999 for node in scenario.spare_ids):
        raise Mistake(f"robots.spares must leave ids within r9999, got {scenario.robots.spares}")


def _check_sizes(scenario: Scenario) -> None:
    duration_s, start = scenario.duration_s, scenario.robots.start
    if duration_s / scenario.tick_s > MAX_TICKS:
        raise Mistake(f"duration_s must be <= {MAX_TICKS} ticks of {scenario.tick_s} s, got {duration_s}")
    if scenario.metrics_from_s > duration_s:
        raise Mistake(f"metrics_from_s must be <= duration_s ({duration_s}), got {scenario.metrics_from_s}")
    robots = len(scenario.robot_ids)
    if isinstance(start, Poses) and len(start.poses) != robots:
        got = len(start.poses)
        raise Mistake(f"robots.start.poses must have one pose for each of {robots} robots, got {got}")


def _check_radio(scenario: Scenario) -> None:
    rules = scenario.radio.rules
    for number, rule in enumerate(rules):
        place = f"radio.rules[{number}]"
        if isinstance(rule, Latency) and number < len(rules) - 1:
            raise Mistake(f"{place}: a latency decides about every frame, so it must be the last rule")
        if isinstance(rule, Partition):
            _check_partition(scenario, rule, place)


def _check_partition(scenario: Scenario, rule: Partition, place: str) -> None:
    if rule.until_s is not None and rule.until_s <= rule.from_s:
        raise Mistake(f"{place}.until_s must be > from_s ({rule.from_s}), got {rule.until_s}")
    placed: set[str] = set()
    for node in (node for group in rule.groups for node in group):
        if node not in scenario.node_ids:
            known = ", ".join(scenario.node_ids)
            raise Mistake(f"{place}.groups: there is no node {node}; nodes are {known}")
        if node in placed:
            raise Mistake(f"{place}.groups: {node} is in two places; a node is in one group at most")
        placed.add(node)


def _check_faults(scenario: Scenario) -> None:
    """Every fault has a node, a time within the run, and a state of the node in which it makes sense."""
    for number, fault in enumerate(scenario.faults):
        _check_fault(scenario, fault, f"faults[{number}]")
    if any(one.role or one.at_s is None for one in scenario.faults):
        return  # whom they befall, and when, only the run will tell
    timed = list(enumerate(scenario.faults))
    state = dict.fromkeys(scenario.node_ids, "alive")
    for number, fault in sorted(timed, key=lambda one: one[1].at_s):
        place = f"faults[{number}]"
        for node in scenario.nodes_of(fault):
            if state[node] not in BEFALLS[fault.verb]:
                when = f"at {fault.at_s} s, it is {state[node]} then"
                raise Mistake(f"{place}: cannot {fault.verb} {node} {when}")
            state[node] = AFTER[fault.verb]


def _check_fault(scenario: Scenario, fault: PlannedFault, place: str) -> None:
    if fault.verb is None:
        raise Mistake(f"{place}.verb is missing")
    if fault.at_s is None and scenario.mission != "clear":
        raise Mistake(f"{place}.at_s is missing")
    if (fault.at_s is None) == (fault.when_cleared_share is None):
        got = "neither" if fault.at_s is None else "both"
        raise Mistake(f"{place} needs either at_s or when_cleared_share, got {got}")
    if [bool(fault.nodes), fault.highest_ids_share is not None, bool(fault.role)].count(True) != 1:
        others = ", highest_ids_share or role" if scenario.mission == "clear" else " or highest_ids_share"
        raise Mistake(f"{place} needs either nodes{others}")
    if fault.at_s is not None and scenario.tick_of(fault.at_s) > scenario.last_tick:
        raise Mistake(f"{place}.at_s must be <= duration_s ({scenario.duration_s}), got {fault.at_s}")
    if fault.every != 1 and fault.verb != "slow":
        raise Mistake(f"{place}.every is for slow, got {fault.every} for {fault.verb}")
    for node in fault.nodes:
        if node not in scenario.node_ids:
            known = ", ".join(scenario.node_ids)
            raise Mistake(f"{place}.nodes: there is no node {node}; nodes are {known}")

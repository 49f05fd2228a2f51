"""Behaviours of third parties, and names that name none."""

import sys

import msgspec
import pytest

from swarm_agent.behaviour import BehaviourError, find_behaviour, settled_parameters
from swarm_agent.node import Mind
from tests.builders import configuration, percept
from wire import codec
from wire.messages import Action

THEIRS = """
from swarm_agent.behaviour import Behaviour, Move, Parameters
from wire.messages import GoTo

class Given(Parameters, frozen=True):
    x_m: float = 7.0

class Theirs(Behaviour):
    Parameters = Given

    def step(self, percept, heard):
        return Move(GoTo(self.parameters.x_m, self.generator.random()), (), percept.tick + 3)

class Another(Theirs):
    pass

class NoBehaviour:
    pass

a_function = print
"""


@pytest.fixture
def their_package(tmp_path, monkeypatch):
    (tmp_path / "their_package").mkdir()
    (tmp_path / "their_package" / "module.py").write_text(THEIRS)
    (tmp_path / "their_package" / "broken.py").write_text("def oh(:\n")
    (tmp_path / "their_package" / "failing.py").write_text("1 / 0\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield
    for name in [one for one in sys.modules if one.startswith("their_package")]:
        del sys.modules[name]


def test_a_third_party_gives_a_module_and_a_class(their_package):
    told = configuration("r2", "their_package.module:Theirs", {"x_m": 3.5})
    answer = Mind("swarm_agent.behaviours").answer(codec.encode(percept(4, why="start", configuration=told)))
    action = codec.decode(Action, answer)
    assert action.motion.x_m == 3.5
    assert action.wake_tick == 7


@pytest.mark.parametrize(
    "name",
    [
        "lr_ptt",
        "",
        ".",
        "..",
        ".lr_pt",
        "lr_pt.",
        "lr pt",
        "lr_pt:",
        ":LrPt",
        ":",
        "..x:Y",
        "their_package.module",
        "their_package.module:Nobody",
        "their_package.module:NoBehaviour",
        "their_package.module:a_function",
        "their_package.nothing:Theirs",
        "their_package.broken:X",
        "their_package.failing:X",
        "no_package.module:X",
        "swarm_agent.behaviour:Behaviour",
        "a\0b",
        "\0:X",
        "__init__",
        "os",
    ],
)
def test_a_name_that_names_no_behaviour_is_an_error_that_says_it(their_package, name):
    with pytest.raises(BehaviourError) as caught:
        find_behaviour(name, "swarm_agent.behaviours")
    assert repr(name) in str(caught.value)


def test_a_file_with_two_behaviours_needs_the_name_of_a_class(their_package):
    with pytest.raises(BehaviourError, match="exactly one"):
        find_behaviour("module", "their_package")
    assert find_behaviour("their_package.module:Another", "their_package").__name__ == "Another"


def test_unknown_and_wrong_parameters_are_refused(their_package):
    theirs = find_behaviour("their_package.module:Theirs", "x")
    with pytest.raises(msgspec.ValidationError, match="y_m"):
        settled_parameters(theirs, {"y_m": 1.0}, 5)
    with pytest.raises(msgspec.ValidationError, match="float"):
        settled_parameters(theirs, {"x_m": "far"}, 5)
    assert settled_parameters(theirs, {"x_m": 2}, 5).x_m == 2.0

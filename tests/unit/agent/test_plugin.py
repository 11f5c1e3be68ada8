"""Plug-ins: classes by a known name or an import path."""

import sys

import pytest
from missions import SCENARIOS

from grex_agent.core import AgentCore
from grex_agent.plugin import load_plugin
from grex_link.errors import ConfigError
from grex_link.scenario import load

KNOWN = {"line": "grex_agent.path:Line", "arc": "grex_agent.path:Arc"}


def test_known_name():
    """A known name is its class."""
    assert load_plugin("$.x", "arc", KNOWN).__qualname__ == "Arc"


def test_import_path(tmp_path, monkeypatch):
    """A class of the user's own is found in the user's own module."""
    (tmp_path / "users_own_module.py").write_text("class Mine:\n    pass\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    try:
        assert load_plugin("$.x", "users_own_module:Mine", KNOWN).__qualname__ == "Mine"
    finally:
        sys.modules.pop("users_own_module")


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("circle", "'circle' is not one of line, arc, nor your_package.module:YourClass"),
        (
            "no_such_module:Mine",
            "cannot import 'no_such_module': ModuleNotFoundError: No module named 'no_such_module'",
        ),
        ("grex_agent.path:Spiral", "module 'grex_agent.path' has no 'Spiral'"),
        ("grex_agent.path:TWO_PI", "'grex_agent.path:TWO_PI' is not a class"),
    ],
)
def test_faults_are_named(name, problem):
    """What cannot be loaded is refused in one line that begins with the path in the scenario."""
    with pytest.raises(ConfigError) as caught:
        load_plugin("$.team.estimator", name, KNOWN)
    assert str(caught.value) == f"$.team.estimator: {problem}"


@pytest.mark.parametrize("table", [{"estimator": "math:sqrt"}, {"controller": "math:sqrt"}])
def test_what_cannot_be_built_is_refused(table):
    """Something else than an estimator or a controller is one line with the path, and not a traceback."""
    scenario = load(SCENARIOS / "paper-d.toml", [f"team.{name}={value}" for name, value in table.items()])
    (name,) = table
    with pytest.raises(ConfigError, match=rf"^\$\.team\.{name}: 'math:sqrt' cannot be built from a \w+: TypeError: "):
        AgentCore(scenario, "auv1")


def test_a_controller_without_its_method_is_refused():
    """What is built, but orders no speed, is refused at the start."""
    scenario = load(SCENARIOS / "paper-d.toml", ["team.controller=builtins:repr"])
    with pytest.raises(ConfigError, match=r"^\$\.team\.controller: 'builtins:repr' has no method 'speed'"):
        AgentCore(scenario, "auv1")

"""From the words of `grex task` to a task."""

import pytest
from task_bench import habitat

from grex_link.errors import ConfigError
from grex_link.tasks import Follow, GoTo, Hold, Inspect, Return, Surface
from grex_sim.task_words import build_task


@pytest.mark.parametrize(
    ("craft", "what", "options", "task"),
    [
        ("aid", "goto", {"at": "10,-20.5"}, GoTo((10.0, -20.5, 5.0))),
        ("low", "goto", {"at": "10,20", "speed": 0.5}, GoTo((10.0, 20.0, 10.0), 0.5)),
        ("aid", "goto", {"at": "1,2,3"}, GoTo((1.0, 2.0, 3.0))),
        ("low", "follow", {"track": 1}, Follow(1)),
        ("aid", "hold", {"for": 60.0}, Hold(60.0)),
        ("aid", "surface", {}, Surface()),
        ("aid", "return", {}, Return()),
        (
            "aid",
            "inspect",
            {"at": "1,2,3", "for": 60.0, "radius": 9.0, "shape": "box", "speed": 1.5, "then": "hold"},
            Inspect((1.0, 2.0, 3.0), 60.0, 9.0, "box", 1.5, "hold"),
        ),
    ],
)
def test_words_to_tasks(craft, what, options, task):
    """Each option is a field of the task; without a depth it is that at which the craft began."""
    assert build_task(habitat(), craft, what, options) == task


@pytest.mark.parametrize(
    ("what", "options", "path"),
    [
        ("goto", {}, "--at"),
        ("goto", {"at": "1"}, "--at"),
        ("goto", {"at": "1,2,3,4"}, "--at"),
        ("goto", {"at": "1,two"}, "--at"),
        ("goto", {"at": "nan,0"}, "--at"),
        ("hold", {"radius": 3.0}, "--radius"),
        ("inspect", {"at": "1,2", "for": -1.0}, "inspect"),
        ("hold", {"for": 1e7}, "hold"),
    ],
)
def test_wrong_words(what, options, path):
    """What is wrong, missing, or does not fit into an order is named."""
    with pytest.raises(ConfigError) as caught:
        build_task(habitat(), "aid", what, options)
    assert caught.value.path == path

"""One table says who writes and reads what; an agent reads its own keys and nobody else's."""

from typing import get_args

import pytest
import zenoh

from grex_link import messages
from grex_link.topics import (
    RESERVED,
    TOPICS,
    frontseat_place,
    is_presence,
    is_reserved,
    key,
    modem_place,
    place_of,
    presence_key,
    subscriptions,
    who_of,
)

TEAM = ["auv1", "auv2", "auv3"]
ROWS = list(TOPICS.values())


def keys_read(role: str, who: str) -> set[str]:
    return {key("grex", topic, craft) for topic, craft in subscriptions(role, who)}


def test_an_agent_reads_its_own_keys() -> None:
    """An agent subscribes to its fix, its modem, its clock, its orders and its oracle, and to nothing else."""
    assert keys_read("agent", "auv1") == {
        f"grex/grex/auv1/{name}" for name in ("fix", "modem/rx", "clock", "task", "oracle")
    }


@pytest.mark.parametrize("who", TEAM)
def test_no_agent_reads_anothers_keys_or_the_truth(who: str) -> None:
    """By Zenoh's own rules, no subscription of an agent meets a key of another craft, of the link, or the truth."""
    others = [key("grex", row.name, craft) for row in ROWS for craft in [*TEAM, "link"] if craft != who]
    others = [other for other in others if not other.startswith(f"grex/grex/{who}/")]
    assert len(others) > 20
    assert "grex/grex/truth" in others
    for own in keys_read("agent", who):
        assert not any(zenoh.KeyExpr(own).intersects(zenoh.KeyExpr(other)) for other in others)


def test_four_keys_are_the_hardware_boundary() -> None:
    """Between a craft's hardware and its agent there are four keys; bench clock and hardware to hardware aside."""
    hardware = {"frontseat", "modem"}
    ours = [row for row in ROWS if {"agent", "link", *hardware} & {*row.writers} and row.name != "clock"]
    boundary = {row.key for row in ours if hardware & {*row.writers, *row.readers}}
    assert boundary == {"{craft}/fix", "{craft}/setpoint", "{craft}/modem/tx", "{craft}/modem/rx"}


def test_a_modem_driver_reads_its_craft_and_the_clock() -> None:
    """The driver of a craft's own modem hears that craft's requests and its own clock, and no craft has its name."""
    assert keys_read("modem", modem_place("auv2")) == {"grex/grex/auv2/modem/tx", "grex/grex/modem_auv2/clock"}
    assert is_reserved(modem_place("auv2"))


def test_a_frontseat_reads_its_craft_and_the_clock() -> None:
    """What steers a real craft hears its agent, what navigates it and its own clock, and no craft has its name."""
    below = {"auv2/setpoint", "auv2/nav", "frontseat_auv2/clock"}
    assert keys_read("frontseat", frontseat_place("auv2")) == {"grex/grex/" + name for name in below}
    assert is_reserved(frontseat_place("auv2"))


def test_the_link_reads_all_transmissions_and_the_truth() -> None:
    """The water hears every craft's modem, and is told where all are."""
    expected = {"*/modem/tx", "link/clock", "truth", "link/advance"}
    assert keys_read("link", "link") == {"grex/grex/" + below for below in expected}


def test_the_simulator_reads_all_craft() -> None:
    """The bench hears every craft's outputs, where real craft are, the link's reports and its ledger."""
    expected = {"*/fix", "*/setpoint", "*/modem/tx", "*/modem/rx", "*/state", "*/port"}
    expected |= {"*/task/news", "link/report", "link/ledger"}
    assert keys_read("sim", "sim") == {"grex/grex/" + below for below in expected}


def test_an_operator_gives_orders_and_hears_news() -> None:
    """An operator writes orders and nothing else, and reads what becomes of tasks and nothing else."""
    assert [row.name for row in ROWS if "operator" in row.writers] == ["task"]
    assert keys_read("operator", "operator") == {"grex/grex/*/task/news"}
    assert is_reserved("operator")


def kinds(of) -> tuple[type, ...]:
    """Return the Structs that may travel on a topic."""
    return get_args(of) or (of,)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_row(row) -> None:
    """Every row has its name once, a Struct of the contract, a writer for every reader, and a way to be used."""
    assert TOPICS[row.name] is row
    assert all(issubclass(kind, messages.Message) for kind in kinds(row.type))
    assert bool(row.writers) == bool(row.readers)
    assert row.readers or row.recorded
    assert row.per_craft == ("{craft}" in row.key)
    assert row.recorded is None or {kind.__name__ for kind in kinds(row.recorded)} <= set(vars(messages))


def test_an_agent_writes_its_own_keys_only() -> None:
    """What an agent writes lies below its own craft."""
    assert all(row.key.startswith("{craft}/") for row in ROWS if "agent" in row.writers)


def test_keys_are_different() -> None:
    """No two topics share a key, whatever craft there are."""
    names = [key("grex", row.name, craft) for row in ROWS for craft in (TEAM if row.per_craft else [""])]
    assert len(set(names)) == len(names)


def test_reserved_names_cover_the_table() -> None:
    """No craft can have a name that begins a key of another participant."""
    taken = {row.key.partition("/")[0] for row in ROWS if not row.per_craft} | {"up", "sim", "operator"}
    assert taken == RESERVED


def test_keys() -> None:
    """A key begins with the team, so that two teams can share a bus."""
    assert key("north", "modem_rx", "auv1") == "grex/north/auv1/modem/rx"
    assert key("north", "truth", "") == "grex/north/truth"
    assert key("north", "state", "*") == "grex/north/*/state"
    assert presence_key("north", "auv1", "0123") == "grex/north/up/auv1/0123"


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_newer_writers_are_understood(row) -> None:
    """A message with a field that this version does not know is read all the same."""
    assert all(kind.__struct_config__.forbid_unknown_fields is False for kind in kinds(row.type))


def test_every_key_is_told_apart() -> None:
    """Whatever is put on the bus can be told from its key: team, topic, craft. Other keys are none of ours."""
    for row in ROWS:
        craft = "auv1" if row.per_craft else ""
        assert place_of(key("t7", row.name, craft)) == ("t7", row, craft)
    for name in ("grex/t7/auv1/nothing", "grex/t7", "other/t7/truth", "", presence_key("t7", "auv1", "f00")):
        assert place_of(name) is None


def test_tokens_are_told_from_messages() -> None:
    """The key of a liveliness token says who it is, and no key of a message looks like one."""
    token = presence_key("t7", modem_place("auv1"), "f00")
    assert is_presence(token)
    assert who_of(token) == ("t7", "modem_auv1")
    assert not any(is_presence(key("t7", row.name, "auv1")) for row in ROWS)

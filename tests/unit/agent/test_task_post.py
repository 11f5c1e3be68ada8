"""Orders that are repeated until their echo has come, and done once (literal times; a has orders for b)."""

import pytest
from task_bench import NS, Line

from grex_agent.tasks.post import REPORTS, TaskPost
from grex_link.errors import WireError
from grex_link.messages import Received, TxEvent
from grex_link.task_wire import Order, pack_order
from grex_link.tasks import GoTo, Hold, Return

TASK = Hold(40.0)


def test_without_losses_one_order_and_one_echo_do():
    """An order is queued, on air, echoed and started; one message each way."""
    line = Line(lambda who, number: False)
    line.posts["a"].order(0, "x", "b", TASK)
    line.run(30)
    assert line.words == ["queued", "on_air", "echoed", "started"]
    assert [(arrival.name, arrival.task) for arrival in line.arrived] == [("a#0", TASK)]
    assert line.sent == {"a": 1, "b": 1}


def test_the_end_is_said_several_times():
    """What has become of a task in the end is said by itself, as often as that is set, and learned once."""
    line = Line(lambda who, number: False)
    line.posts["a"].order(0, "x", "b", TASK)
    line.run(10)
    line.posts["b"].answer("a#0", "done", line.now_s * NS)
    line.run(40)
    assert line.words[-1] == "done"
    assert line.words.count("done") == 1
    assert line.sent["b"] == 1 + REPORTS
    line.posts["b"].answer("a#0", "returned", line.now_s * NS)
    line.run(40)
    assert line.words[-1] == "returned"


def test_a_lost_order_is_sent_again():
    """Two orders lost: the third try is echoed."""
    line = Line(lambda who, number: who == "a" and number < 2)
    line.posts["a"].order(0, "x", "b", TASK)
    line.run(60)
    assert line.words == ["queued", "on_air", "echoed", "started"]
    assert line.sent["a"] == 3


def test_a_lost_echo_does_not_make_it_twice():
    """Echoes lost: the order comes again, is echoed again, and is not done again."""
    line = Line(lambda who, number: who == "b" and number < 3)
    line.posts["a"].order(0, "x", "b", TASK)
    line.run(60)
    assert line.words[-1] == "started"
    assert len(line.arrived) == 1
    assert line.sent == {"a": 4, "b": 4}


def test_it_gives_up_with_one_word():
    """A craft that never echoes: as many tries as are set, then it has failed, which is said once."""
    line = Line(lambda who, number: who == "a", tries=3)
    line.posts["a"].order(0, "x", "b", TASK)
    line.run(100)
    assert line.words == ["queued", "on_air", "failed"]
    assert line.sent["a"] == 3
    assert not line.posts["a"].unanswered("b")


def test_a_refusal_is_told():
    """A refused order is echoed as refused, and comes to an end."""
    line = Line(lambda who, number: False)
    line.posts["a"].order(0, "x", "b", TASK)
    for _ in range(20):
        line.step(lambda name: "refused")
    assert line.words == ["queued", "on_air", "echoed", "refused"]


def test_a_late_echo_takes_nothing_back():
    """An echo that says "started" and comes after "done" changes nothing."""
    a, b = (TaskPost(who, ["a", "b"], 8, NS) for who in "ab")
    mail: list[tuple[bytes, str]] = []
    a.order(0, "x", "b", TASK)
    a.step(0, lambda payload, to: mail.append((payload, to)) or 0)
    b.on_received(Received("a", mail.pop()[0]))
    b.answer("a#0", "started", 0)
    b.step(0, lambda payload, to: mail.append((payload, to)) or 0)
    b.answer("a#0", "done", NS)
    b.step(NS, lambda payload, to: mail.append((payload, to)) or 0)
    (started, _), (done, _) = mail
    for payload in (done, started, started):
        a.on_received(Received("b", payload))
    assert [word.status for word in a.words] == ["queued", "echoed", "started", "done"]


def test_a_newer_order_to_the_same_craft_replaces_it():
    """Of two orders to one craft the older is over: it is said, and not sent again."""
    line = Line(lambda who, number: number == 0)
    line.posts["a"].order(0, "old", "b", TASK)
    line.run(3)
    line.posts["a"].order(3 * NS, "new", "b", Return())
    line.run(40)
    assert line.words == ["queued", "on_air", "interrupted", "queued", "on_air", "echoed", "started"]
    assert [arrival.task for arrival in line.arrived] == [Return()]


def test_what_the_modem_cannot_send_fails_at_once():
    """A modem that refuses the payload for its size is not asked again."""
    post = TaskPost("a", ["a", "b"], 8, NS)
    post.order(0, "x", "b", TASK)
    post.step(0, lambda payload, to: 5)
    post.on_status(TxEvent(5, "FAILED", "size"), NS)
    post.step(100 * NS, lambda payload, to: pytest.fail("sent again"))
    assert (post.words[-1].status, post.words[-1].detail) == ("failed", "the modem cannot send it: size")


def test_a_busy_modem_is_asked_again():
    """A try that the modem could not send is a try; the next one follows."""
    post = TaskPost("a", ["a", "b"], 2, NS)
    post.order(0, "x", "b", TASK)
    asked: list[int] = []
    for second in range(12):
        post.step(second * NS, lambda payload, to: asked.append(len(asked)) or len(asked) - 1)
        post.on_status(TxEvent(len(asked) - 1, "FAILED", "busy"), second * NS)
    assert asked == [0, 1]
    assert post.words[-1].status == "failed"


def test_a_modem_that_says_nothing_does_not_stop_it():
    """Without any word of the modem the tries go on, slower, and come to an end."""
    post = TaskPost("a", ["a", "b"], 2, NS)
    post.order(0, "x", "b", TASK)
    asked: list[int] = []
    for second in range(20):
        post.step(second * NS, lambda payload, to, now=second: asked.append(now) or 0)
    assert asked == [0, 4]
    assert post.words[-1].status == "failed"


def test_mail_for_others_is_left_alone():
    """An order for somebody else that is overheard is not done, and not echoed."""
    post = TaskPost("c", ["a", "b", "c"], 8, NS)
    assert post.on_received(Received("a", pack_order(Order(1, 0, TASK)))) is None
    post.step(0, lambda payload, to: pytest.fail("said something"))
    assert post.bad == 0


FIFTY = [f"craft{number}" for number in range(50)]


def test_in_a_team_of_fifty_only_the_addressed_craft_takes_an_order():
    """Three craft have the same place modulo 16: of an order that all of them hear, one does it, and one echoes."""
    order = Received("craft0", pack_order(Order(FIFTY.index("craft20"), 7, TASK)), "craft20")
    posts = {craft: TaskPost(craft, FIFTY, 8, NS) for craft in ("craft4", "craft20", "craft36", "craft5")}
    arrived = {craft: post.on_received(order) for craft, post in posts.items()}
    assert [craft for craft, arrival in arrived.items() if arrival] == ["craft20"]
    echoes: list[str] = []
    for craft, post in posts.items():
        post.answer("craft0#7", "started", 0)
        post.step(0, lambda payload, to, craft=craft: echoes.append(f"{craft}>{to}") or 0)
        assert post.bad == 0
    assert echoes == ["craft20>craft0"]


def test_what_could_be_for_two_is_for_nobody():
    """Without an address an order is taken where one craft only has that place modulo 16, else by none, and counted."""
    order = Received("craft0", pack_order(Order(20, 7, TASK)))
    for craft in ("craft4", "craft20", "craft36"):
        post = TaskPost(craft, FIFTY, 8, NS)
        assert post.on_received(order) is None
        assert post.bad == 1
    alone = TaskPost("craft4", FIFTY[:20], 8, NS)
    assert alone.on_received(order) is not None
    assert alone.bad == 0


def test_an_echo_for_another_craft_acknowledges_nothing():
    """craft1 and craft17 send craft2 the same order under the same number: the echo to one is not one to the other."""
    posts = {craft: TaskPost(craft, FIFTY, 8, NS) for craft in ("craft1", "craft17")}
    sent: dict[str, bytes] = {}
    for craft, post in posts.items():
        post.order(0, "x", "craft2", TASK)
        post.step(0, lambda payload, to, craft=craft: sent.update({craft: payload}) or 0)
    assert sent["craft1"] == sent["craft17"]
    receiver = TaskPost("craft2", FIFTY, 8, NS)
    receiver.on_received(Received("craft17", sent["craft17"], "craft2"))
    receiver.answer("craft17#0", "started", 0)
    receiver.step(0, lambda payload, to: sent.update({to: payload}) or 0)
    for post in posts.values():
        post.on_received(Received("craft2", sent["craft17"], "craft17"))
    assert posts["craft1"].unanswered("craft2")
    assert not posts["craft17"].unanswered("craft2")


def test_a_number_that_comes_round_again_is_another_order():
    """After 256 orders the numbers begin again; the hash tells an old order from a new one."""
    line = Line(lambda who, number: False)
    tasks = [GoTo((float(n), 0.0, 0.0)) for n in range(257)]
    for n, task in enumerate(tasks):
        line.posts["a"].order(line.now_s * NS, f"x{n}", "b", task)
        line.run(5)
    assert [arrival.task for arrival in line.arrived] == tasks


def test_rubbish_is_counted():
    """What is no order, or of nobody in the team, is counted and dropped."""
    post = TaskPost("b", ["a", "b"], 8, NS)
    post.on_received(Received("a", b"\x30" + bytes(11)))
    post.on_received(Received("stranger", pack_order(Order(1, 0, TASK))))
    assert post.bad == 2


def test_a_task_that_cannot_be_told_is_refused():
    """A place outside of what an order can say is refused before it is numbered."""
    post = TaskPost("a", ["a", "b"], 8, NS)
    with pytest.raises(WireError):
        post.order(0, "x", "b", GoTo((1e5, 0.0, 0.0)))
    assert not post.words

"""Rows of `grex study team` for talk by events: what it saves of messages, bytes and energy, and what it costs in FD.

The paper's modem has no published source level, so that nobody knows its energy. What is said of energy is therefore
measured on `s2c_im`, in the paper's mission. A slot of that modem comes round every 1.6 s and not every 30 s; the
longest silence is given in slots, so that the same number of slots is a twentieth of the time there. Both are flown:
the same slots, and (``quiet``) about the same seconds.
"""

from collections.abc import Iterator

from grex_sim.study.figures import Cost, Flight, cost, cost_share, ratio
from grex_sim.study.rows import S0, p_law
from grex_sim.study.rows_beyond import best
from grex_sim.study.table import AtMost, Row

_LASTING = "team.speed_model.error_time_s=20000.0"
#: The paper's law and messages, sent only when they would tell the mates something new; speed errors are taken to last,
#: or they would be forgotten in a long silence. Chosen on seeds 201 to 230.
EVENT = ('team.talk={type="event", threshold_m=0.3, repeats=2, heartbeat_slots=15}', _LASTING)
#: A modem with a source level.
S2C_IM = ("link.profile=s2c_im",)
#: The longest silence of 450 s on `s2c_im`, and that of 270 s of the best law.
_QUIET = ('team.talk={type="event", threshold_m=0.3, repeats=2, heartbeat_slots=288}', _LASTING)
_BEST_QUIET = ('team.talk={type="event", threshold_m=0.5, heartbeat_slots=198}',)
_COSTS: tuple[tuple[str, Cost, str], ...] = (
    ("message", "messages_sent", "messages"),
    ("byte", "bytes_sent", "bytes"),
    ("energy", "team_sound_j", "energy of the sound"),
)


def on_s2c_im(talk: str, loss: float = 0.0) -> Flight:
    """Fly the paper's mission with a modem whose energy is known.

    Parameters
    ----------
    talk : str
        ``periodic``, ``event`` or ``event_quiet`` under the paper's law, with `along_track`; ``best`` or ``best_quiet``
        under the best law.
    loss : float
        Share of messages lost.
    """
    if talk.startswith("best"):
        return best("s0", loss, (*S2C_IM, *(_BEST_QUIET if talk == "best_quiet" else ())))
    more = {"periodic": (), "event": EVENT, "event_quiet": _QUIET}[talk]
    return p_law(S0, "along_track", loss=loss, more=(*more, *S2C_IM))


def _papers_modem() -> Iterator[Row]:
    periodic = p_law(S0, "along_track")
    about = "paper's mission, K 0.8, along_track, event-triggered"
    for row, loss in (("event_message_share", 0.0), ("event_message_share_loss30", 0.3)):
        event = p_law(S0, "along_track", loss=loss, more=EVENT)
        share = cost_share(event, periodic, "messages_sent")
        yield Row(row, f"{about}, {100 * loss:.0f} % loss: share of the messages", share, AtMost(0.20))
    for loss in (0.0, 0.3):
        flight, ideal = p_law(S0, "along_track", loss=loss, more=EVENT), p_law(S0, "ideal", loss=loss)
        row = f"event_ratio_loss{100 * loss:.0f}"
        yield Row(row, f"{about}, {100 * loss:.0f} % loss: FD / FD of ideal", ratio(flight, ideal), AtMost(1.02))
    for name, what, words in _COSTS[:2]:
        share = cost_share(best("s0"), periodic, what)
        yield Row(f"best_{name}_share", f"paper's mission, best law: share of the {words} of periodic talk", share)


def _modem_with_energy() -> Iterator[Row]:
    periodic = on_s2c_im("periodic")
    for talk in ("periodic", "event", "event_quiet", "best", "best_quiet"):
        about = f"paper's mission, s2c_im, {talk}"
        share_target, ratio_target = (AtMost(0.20), AtMost(1.02)) if talk == "event" else (None, None)
        for name, what, words in _COSTS:
            flight = on_s2c_im(talk)
            yield Row(f"{talk}_{name}_s2c_im", f"{about}: {words}", cost(flight, what))
            if talk != "periodic":
                share = cost_share(flight, periodic, what)
                yield Row(f"{talk}_{name}_share_s2c_im", f"{about}: {words}, share of periodic", share, share_target)
        for loss in (0.0, 0.3):
            figure = ratio(on_s2c_im(talk, loss), p_law(S0, "ideal", more=S2C_IM))
            row = f"{talk}_ratio_s2c_im_loss{100 * loss:.0f}"
            yield Row(row, f"{about}, {100 * loss:.0f} % loss: FD / FD of ideal", figure, ratio_target)
        if talk != "periodic":
            share = cost_share(on_s2c_im(talk, 0.3), periodic, "team_sound_j")
            row = f"{talk}_energy_share_s2c_im_loss30"
            yield Row(row, f"{about}, 30 % loss: energy, share of periodic", share, share_target)


TALK = (*_papers_modem(), *_modem_with_energy())

"""Commands: what is done, and which ACK comes back. The component they are for is not looked at, as on real ones."""

import math
from collections.abc import Callable

from grex_sim.autopilot import telemetry
from grex_sim.autopilot.brain import Brain
from grex_sim.autopilot.message import Command, Message, Result, whole
from grex_sim.autopilot.setpoints import Order

_REBOOT_AFTER_S = 0.2
_CALIBRATION_S = 5.1
_ALTITUDE_MAX_M = 20_000.0
_FORCE = 21196
_EVENT_ARMING_REFUSED = 0x01000000
_EVENT_BYTES = 40


def obey(brain: Brain, message: Message, link: int, now_s: float) -> None:
    """Obey COMMAND_LONG or COMMAND_INT, and answer.

    Parameters
    ----------
    brain : Brain
        Who obeys.
    message : Message
        The command.
    link : int
        Where it came from; answers go there.
    now_s : float
        Autopilot time.
    """
    number = message["command"]
    handler = _HANDLERS.get(number)
    result = Result.UNSUPPORTED if handler is None else handler(brain, message, link, now_s)
    after_s = _CALIBRATION_S if number == Command.CALIBRATE and result == Result.ACCEPTED else 0.0
    brain.ack(number, result, message, link, now_s, after_s)


def change_mode(brain: Brain, number: int, now_s: float) -> Result:
    """Change the mode because somebody on a link wants it."""
    position, streamed = brain.estimator.aiding, brain.control.streamed(now_s)
    result, text = brain.modes.ask(number, now_s, position=position, streamed=streamed)
    if result == Result.ACCEPTED:
        brain.control.left = False
    if text:
        brain.text(text, now_s)
    return result


def _set_mode(brain: Brain, message: Message, link: int, now_s: float) -> Result:
    del link
    if not whole(message["param1"]) & 1:
        return Result.DENIED
    number = whole(message["param2"])
    if brain.family.own_mode_encoding:
        number = number << 16 | whole(message["param3"]) << 24
    return change_mode(brain, number, now_s)


def _arm(brain: Brain, message: Message, link: int, now_s: float) -> Result:
    del link
    if message["param1"] == 0.0:
        brain.modes.disarm()
        return Result.ACCEPTED
    if message["param1"] != 1.0:
        return Result.DENIED if brain.family.reject_event else Result.FAILED
    if brain.body.faults.value("refuse", now_s):
        return _refuse(brain, "Arm: Logging failed", now_s)
    if message["param2"] == _FORCE:
        brain.modes.armed = True
        return Result.ACCEPTED
    position, streamed = brain.estimator.aiding, brain.control.streamed(now_s)
    result, text = brain.modes.arm(now_s, position=position, streamed=streamed)
    return result if result == Result.ACCEPTED else _refuse(brain, text, now_s)


def _refuse(brain: Brain, text: str, now_s: float) -> Result:
    if not brain.family.reject_event:
        brain.text(text, now_s)
        return Result.FAILED
    # The reason is only in a message that hardly anybody decodes.
    fields = {
        "id": _EVENT_ARMING_REFUSED,
        "event_time_boot_ms": int(brain.boot.age_s(now_s) * 1000.0),
        "arguments": [0] * _EVENT_BYTES,
    }
    brain.say("EVENT", fields, None, now_s)
    return Result.TEMPORARILY_REJECTED


def _set_interval(brain: Brain, message: Message, link: int, now_s: float) -> Result:
    name = telemetry.name_of(brain, whole(message["param1"]))
    if name is None:
        return Result(brain.family.unknown_interval)
    return brain.streams[link].ask(name, message["param2"], now_s)


def _get_interval(brain: Brain, message: Message, link: int, now_s: float) -> Result:
    number = whole(message["param1"])
    name = telemetry.name_of(brain, number)
    interval = 0 if name is None else brain.streams[link].interval_us(name)
    brain.say("MESSAGE_INTERVAL", {"message_id": number, "interval_us": interval}, link, now_s)
    return Result.ACCEPTED


def _request(brain: Brain, message: Message, link: int, now_s: float) -> Result:
    return _send(brain, telemetry.name_of(brain, whole(message["param1"])), link, now_s)


def _send(brain: Brain, name: str | None, link: int, now_s: float) -> Result:
    fields = None if name is None else telemetry.build(brain, name, now_s)
    if name is None or fields is None:
        return Result.FAILED
    brain.say(name, fields, link, now_s)
    return Result.ACCEPTED


def _capabilities(brain: Brain, message: Message, link: int, now_s: float) -> Result:
    del message
    return _send(brain, "AUTOPILOT_VERSION", link, now_s)


def _get_home(brain: Brain, message: Message, link: int, now_s: float) -> Result:
    del message
    return _send(brain, "HOME_POSITION", link, now_s)


def _set_home(brain: Brain, message: Message, link: int, now_s: float) -> Result:
    """Move home, and with it relative_alt; not the local frame."""
    if message["param1"] == 1.0:
        pose = brain.pose
        brain.home = pose.north_m, pose.east_m, pose.down_m
    else:
        latitude, longitude, altitude = _position(message)
        if not (abs(latitude) <= 90.0 and abs(longitude) <= 180.0 and abs(altitude) <= _ALTITUDE_MAX_M):
            return Result.DENIED
        brain.home = (*brain.place.local(latitude, longitude), -altitude)
    _send(brain, "HOME_POSITION", link, now_s)
    return Result.ACCEPTED


def _position(message: Message) -> tuple[float, float, float]:
    if message.name == "COMMAND_INT":
        return message["x"] * 1e-7, message["y"] * 1e-7, message["z"]
    return message["param5"], message["param6"], message["param7"]


def _reposition(brain: Brain, message: Message, link: int, now_s: float) -> Result:
    del link
    if message.name != "COMMAND_INT" and not brain.family.reposition_long:
        return Result.UNSUPPORTED
    latitude, longitude, _ = _position(message)
    if not (abs(latitude) <= 90.0 and abs(longitude) <= 180.0):
        return Result.DENIED
    target = brain.place.local(latitude, longitude)
    streams = brain.family.setpoints.positions_streamed
    wanted = brain.family.known(brain.family.point if streams else brain.family.guided)
    if brain.modes.mode != wanted:
        result = change_mode(brain, wanted.number, now_s)
        if result != Result.ACCEPTED:
            return result
    if streams:
        brain.control.goto(target)
    else:
        brain.control.take(Order(target=target, streamed=False), now_s)
    return Result.ACCEPTED


def _change_speed(brain: Brain, message: Message, link: int, now_s: float) -> Result:
    del link, now_s
    if brain.family.change_speed == "after_position" and not brain.control.had_position:
        return Result.FAILED
    if not (math.isfinite(message["param2"]) and message["param2"] > 0.0):
        return Result.DENIED
    brain.control.cruise_mps = message["param2"]
    return Result.ACCEPTED


def _loiter(brain: Brain, message: Message, link: int, now_s: float) -> Result:
    del message, link
    return change_mode(brain, brain.family.known(brain.family.point).number, now_s)


def _go_home(brain: Brain, message: Message, link: int, now_s: float) -> Result:
    del message, link
    mode = brain.family.named("RTL")
    return Result.UNSUPPORTED if mode is None else change_mode(brain, mode.number, now_s)


def _calibrate(brain: Brain, message: Message, link: int, now_s: float) -> Result:
    del message, link, now_s
    return Result.FAILED if brain.modes.armed else Result.ACCEPTED


def _reboot(brain: Brain, message: Message, link: int, now_s: float) -> Result:
    del link
    if message["param1"] not in {1.0, 3.0}:
        return Result.UNSUPPORTED
    if brain.modes.armed:
        return Result.FAILED
    brain.reboot_at_s = now_s + _REBOOT_AFTER_S
    return Result.ACCEPTED


def _external_position(brain: Brain, message: Message, link: int, now_s: float) -> Result:
    """Take a position that is only needed now and then, as a craft with a DVL does."""
    del link
    if message.name != "COMMAND_INT":
        return Result.UNSUPPORTED
    if not math.isnan(message["z"]):
        return Result.DENIED
    if not brain.estimator.aiding:
        return Result.FAILED
    latitude, longitude, _ = _position(message)
    if not (abs(latitude) <= 90.0 and abs(longitude) <= 180.0):
        return Result.DENIED
    brain.estimator.on_fix(*brain.place.local(latitude, longitude), brain.craft.truth, now_s)
    return Result.ACCEPTED


_HANDLERS: dict[int, Callable[[Brain, Message, int, float], Result]] = {
    Command.LOITER_UNLIM: _loiter,
    Command.RETURN_TO_LAUNCH: _go_home,
    Command.SET_MODE: _set_mode,
    Command.CHANGE_SPEED: _change_speed,
    Command.SET_HOME: _set_home,
    Command.REPOSITION: _reposition,
    Command.CALIBRATE: _calibrate,
    Command.REBOOT: _reboot,
    Command.ARM: _arm,
    Command.GET_HOME: _get_home,
    Command.GET_INTERVAL: _get_interval,
    Command.SET_INTERVAL: _set_interval,
    Command.REQUEST_MESSAGE: _request,
    Command.REQUEST_CAPABILITIES: _capabilities,
    Command.EXTERNAL_POSITION: _external_position,
}

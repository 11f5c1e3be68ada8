"""What an autopilot makes of every other message it hears: set-points, heartbeats, parameters, fixes, questions."""

import math
from collections.abc import Callable

from grex_sim.autopilot.brain import Brain
from grex_sim.autopilot.commands import change_mode, obey
from grex_sim.autopilot.message import Message
from grex_sim.autopilot.setpoints import Order, from_attitude, from_global, from_local

_FAR_M = 1e6
#: Of x, y, z, roll, pitch and yaw, in the upper triangle row by row.
_VARIANCES = (0, 6, 11, 15, 18, 20)


def hear(brain: Brain, message: Message, link: int, now_s: float) -> None:
    """Take one message that is for this autopilot, or for everybody; what nobody knows is passed over."""
    if not _is_for(brain, message):
        return
    handler = _HANDLERS.get(message.name)
    if handler is not None:
        handler(brain, message, link, now_s)


def _is_for(brain: Brain, message: Message) -> bool:
    """System 0 is everybody. Components are not looked at: one that is absent is obeyed all the same."""
    if message.fields.get("target_system", 0) not in {0, brain.settings.system}:
        return False
    enforced = int(brain.parameters.get("SYSID_ENFORCE"))
    return not enforced or message.system == int(brain.parameters.get("SYSID_MYGCS"))


def _heartbeat(brain: Brain, message: Message, link: int, now_s: float) -> None:
    del link
    text = brain.gcs.on_heartbeat(message, now_s)
    if text:
        # Its mode does not come back.
        brain.text(text, now_s)


def _local_setpoint(brain: Brain, message: Message, link: int, now_s: float) -> None:
    del link
    rules, origin = brain.family.setpoints, brain.estimator.origin or (0.0, 0.0, 0.0)
    guided = brain.modes.mode.kind == "guided"
    if message["coordinate_frame"] in rules.fatal_frames and guided:
        brain.modes.force(brain.family.hold)
        return
    _take(brain, from_local(message, rules, brain.pose, origin), now_s, wanted=guided)


def _global_setpoint(brain: Brain, message: Message, link: int, now_s: float) -> None:
    del link
    kind = brain.modes.mode.kind
    if not _on_earth(message["lat_int"], message["lon_int"]):
        return
    order = from_global(
        message,
        brain.family.setpoints,
        brain.pose,
        brain.place.local,
        depth_only=kind == "depth" and brain.family.dives,
    )
    _take(brain, order, now_s, wanted=kind in {"guided", "depth"})


def _attitude_setpoint(brain: Brain, message: Message, link: int, now_s: float) -> None:
    del link
    kind = brain.modes.mode.kind
    order = from_attitude(message, brain.family, depth_holding=kind == "depth")
    _take(brain, order, now_s, wanted=kind in {"guided", "depth"})


def _take(brain: Brain, order: Order | None, now_s: float, *, wanted: bool) -> None:
    """Take an order in a mode that obeys it; a PX4 also counts the others, and comes back to them."""
    if order is not None and (wanted or brain.family.setpoints.on_timeout == "leave"):
        brain.control.take(order, now_s)


def _sticks(brain: Brain, message: Message, link: int, now_s: float) -> None:
    del link
    if message["target"] == brain.settings.system:
        brain.control.sticks(message, now_s)


def _set_mode(brain: Brain, message: Message, link: int, now_s: float) -> None:
    """Obey the old SET_MODE, which has no ACK."""
    del link
    change_mode(brain, message["custom_mode"], now_s)


def _parameter_list(brain: Brain, message: Message, link: int, now_s: float) -> None:
    del message
    for at_s, answer in brain.parameters.listed(now_s):
        brain.outbox.put(at_s, answer, link)


def _parameter_read(brain: Brain, message: Message, link: int, now_s: float) -> None:
    answer = brain.parameters.read(message)
    if answer is not None:
        brain.outbox.put(now_s, answer, link)


def _parameter_write(brain: Brain, message: Message, link: int, now_s: float) -> None:
    del link
    answer = brain.parameters.write(message)
    if answer is None:
        return
    brain.body.faults.on_parameter(message["param_id"], message["param_value"], now_s)
    # What has changed is told to everybody.
    brain.outbox.put(now_s, answer)


def _data_stream(brain: Brain, message: Message, link: int, now_s: float) -> None:
    group, rate, start = message["req_stream_id"], message["req_message_rate"], message["start_stop"]
    if not brain.family.own_mode_encoding:
        brain.streams[link].ask_group(group, rate, start=start == 1, now_s=now_s)


def _timesync(brain: Brain, message: Message, link: int, now_s: float) -> None:
    if message["tc1"] != 0:
        if brain.family.timesync_asks_hz:
            brain.stamps[link].on_answer(message["tc1"] * 1e-9, message["ts1"] * 1e-9, brain.boot.age_s(now_s))
        return
    answer = {"tc1": round(brain.boot.age_s(now_s) * 1e9), "ts1": message["ts1"]}
    brain.say("TIMESYNC", answer, link, now_s + brain.family.timesync_s)


def _ping(brain: Brain, message: Message, link: int, now_s: float) -> None:
    answer = {
        "time_usec": message["time_usec"],
        "seq": message["seq"],
        "target_system": message.system,
        "target_component": message.component,
    }
    if message["target_system"] == 0:
        brain.say("PING", answer, link, now_s)


def _gps_input(brain: Brain, message: Message, link: int, now_s: float) -> None:
    del link
    if "GPS_INPUT" in brain.family.external_messages and message["fix_type"] >= 2 and _external(brain, "GPS1_TYPE"):
        if not _on_earth(message["lat"], message["lon"]):
            return
        north, east = brain.place.local(message["lat"] * 1e-7, message["lon"] * 1e-7)
        brain.estimator.on_fix(north, east, brain.craft.truth, now_s)


def _vision(brain: Brain, message: Message, link: int, now_s: float) -> None:
    """Take a position in the autopilot's own frame: it needs an origin, which somebody sets."""
    origin = brain.estimator.origin
    stamped = brain.stamps[link].usable(message["usec"] * 1e-6, brain.boot.age_s(now_s))
    near = max(abs(message["x"]), abs(message["y"])) < _FAR_M
    if origin is not None and near and stamped and _takes_vision(brain) and _has_accuracy(brain, message):
        brain.estimator.on_fix(origin[0] + message["x"], origin[1] + message["y"], brain.craft.truth, now_s)


def _takes_vision(brain: Brain) -> bool:
    """Whether vision is a source; an ArduPilot also needs the driver that listens to it, which is there from boot."""
    return _external(brain, "EKF2_EV_CTRL") or (_external(brain, "EK3_SRC1_POSXY") and brain.listens_to_vision)


def _has_accuracy(brain: Brain, message: Message) -> bool:
    """Whether its variances are numbers: an ArduPilot adds all of them up if the first one is, and NaN spoils it."""
    covariance = message.fields.get("covariance") or [math.nan]
    if brain.family.own_mode_encoding or math.isnan(covariance[0]):
        return True
    return not any(math.isnan(covariance[k]) for k in _VARIANCES)


def _on_earth(latitude: int, longitude: int) -> bool:
    """Whether these are a latitude and a longitude, in 1e-7 degrees."""
    return abs(latitude) <= 900_000_000 and abs(longitude) <= 1_800_000_000


def _external(brain: Brain, name: str) -> bool:
    return any(key == name and int(brain.parameters.get(key)) == value for key, value in brain.family.external_fix)


def _set_origin(brain: Brain, message: Message, link: int, now_s: float) -> None:
    """Set the origin of the local frame: an ArduPilot that has one ignores it silently, a PX4 moves it."""
    del link
    if not _on_earth(message["latitude"], message["longitude"]):
        return
    north, east = brain.place.local(message["latitude"] * 1e-7, message["longitude"] * 1e-7)
    down = -message["altitude"] / 1000.0
    if brain.estimator.set_origin((north, east, down), moves=brain.family.origin_moves):
        fields = {key: message[key] for key in ("latitude", "longitude", "altitude")}
        for _ in range(1 if brain.family.origin_moves else 2):
            brain.say("GPS_GLOBAL_ORIGIN", fields, None, now_s)


def _no_mission(brain: Brain, message: Message, link: int, now_s: float) -> None:
    kind = message.fields.get("mission_type", 0)
    fields = {
        "target_system": message.system,
        "target_component": message.component,
        "count": 0,
        "mission_type": kind,
    }
    brain.say("MISSION_COUNT", fields, link, now_s)


_HANDLERS: dict[str, Callable[[Brain, Message, int, float], None]] = {
    "COMMAND_INT": obey,
    "COMMAND_LONG": obey,
    "GPS_INPUT": _gps_input,
    "HEARTBEAT": _heartbeat,
    "MANUAL_CONTROL": _sticks,
    "MISSION_REQUEST_LIST": _no_mission,
    "PARAM_REQUEST_LIST": _parameter_list,
    "PARAM_REQUEST_READ": _parameter_read,
    "PARAM_SET": _parameter_write,
    "PING": _ping,
    "REQUEST_DATA_STREAM": _data_stream,
    "SET_ATTITUDE_TARGET": _attitude_setpoint,
    "SET_GPS_GLOBAL_ORIGIN": _set_origin,
    "SET_MODE": _set_mode,
    "SET_POSITION_TARGET_GLOBAL_INT": _global_setpoint,
    "SET_POSITION_TARGET_LOCAL_NED": _local_setpoint,
    "TIMESYNC": _timesync,
    "VISION_POSITION_ESTIMATE": _vision,
}

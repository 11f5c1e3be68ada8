"""A run as Foxglove's messages for map and scene (protobuf): Foxglove, Lichtblick and Rerun draw them untold.

Frames: ``map`` is east, north, up about the datum; ``mission`` is the same place in NED; each craft has a frame of its
name. Without a datum there is no map, and all else is the same.
"""

import math
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any, NamedTuple

from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.LocationFix_pb2 import LocationFix
from foxglove_schemas_protobuf.Point3_pb2 import Point3
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.descriptor import FileDescriptor
from google.protobuf.descriptor_pb2 import FileDescriptorSet

from grex_agent.frontseat.geodesy import to_degrees
from grex_agent.mission import TeamPlan
from grex_link.config import DatumConfig, Scenario
from grex_link.messages import Pose, Truth
from grex_link.units import NS
from grex_sim.outline import outline

#: A run has so many moments in it at most: they cost the time of the simulator.
_MOMENTS = 600
_LEAST_S = 1.0
#: A track is drawn in pieces of so many moments, so that none is sent twice.
_PIECE = 25
#: Okabe and Ito's colours, as in the pictures: red, green, blue from 0 to 1.
_COLOURS = ((0.0, 0.447, 0.698), (0.835, 0.369, 0.0), (0.0, 0.62, 0.451), (0.8, 0.475, 0.655), (0.902, 0.624, 0.0),
            (0.337, 0.706, 0.914), (0.5, 0.5, 0.5))  # fmt: skip
_LENGTH_M = 4.0


class Encoded(NamedTuple):
    """One protobuf message for a recording, or for Foxglove's socket."""

    topic: str
    schema: str
    """Full name of its type."""
    descriptors: bytes
    """Its FileDescriptorSet."""
    t_ns: int
    data: bytes


class FoxgloveScene:
    """Turns true poses into map, frames and scene, now and then.

    Parameters
    ----------
    scenario : Scenario
        Datum and length of the run.
    plan : TeamPlan
        The planned tracks.
    apart_s : float or None
        Mission seconds between two moments; what a recording can afford if None.
    """

    def __init__(self, scenario: Scenario, plan: TeamPlan, apart_s: float | None = None) -> None:
        self._degrees = None if scenario.datum is None else _Degrees(scenario.datum)
        self._plan = plan
        if apart_s is None:
            apart_s = max(_LEAST_S, (scenario.duration_s or plan.duration_s) / _MOMENTS)
        self._apart_ns = round(apart_s * NS)
        self._due_ns = 0
        self._begun = False
        self._tracks: dict[str, list[Point3]] = {craft: [] for craft in plan.everybody}
        self._pieces = 0

    def at(self, truth: Truth) -> Iterator[Encoded]:
        """Return what is to be written at true poses: mostly nothing."""
        if truth.t_ns < self._due_ns:
            return
        self._due_ns = truth.t_ns + self._apart_ns
        if not self._begun:
            self._begun = True
            yield self._planned(truth)
        frames = FrameTransforms(transforms=[self._chart(truth.t_ns)])
        for pose in truth.poses:
            if not all(map(math.isfinite, (pose.north_m, pose.east_m, pose.down_m))):
                continue
            frames.transforms.append(_frame(truth.t_ns, pose))
            self._tracks.setdefault(pose.craft, []).append(Point3(x=pose.north_m, y=pose.east_m, z=pose.down_m))
            if self._degrees is not None:
                yield _location(truth.t_ns, pose, self._degrees)
        yield _encode("/tf", truth.t_ns, frames)
        if any(len(points) > _PIECE for points in self._tracks.values()):
            yield self._sailed(truth.t_ns)

    def begin_again(self) -> None:
        """Send the plan once more at the next moment: somebody new is looking."""
        self._begun = False

    def end(self, t_ns: int) -> Iterator[Encoded]:
        """Return the last pieces of the tracks."""
        if any(len(points) > 1 for points in self._tracks.values()):
            yield self._sailed(t_ns)

    def _chart(self, t_ns: int) -> FrameTransform:
        """Turn east, north, up into north, east, down: half a turn about the line to the north-east."""
        chart = FrameTransform(parent_frame_id="map", child_frame_id="mission")
        chart.timestamp.FromNanoseconds(t_ns)
        chart.rotation.x = chart.rotation.y = math.sqrt(0.5)
        return chart

    def _planned(self, truth: Truth) -> Encoded:
        """Draw the plan, and each craft in its own frame: it moves with that."""
        update = SceneUpdate()
        for place, (craft, plan) in enumerate(self._plan.everybody.items()):
            points = [Point3(x=north, y=east, z=plan.start_depth_m) for north, east in outline(plan)]
            update.entities.append(_line(truth.t_ns, f"plan/{craft}", points, _colour(place, 0.35), 1.0))
            body = SceneEntity(frame_id=craft, id=f"craft/{craft}", frame_locked=True)
            body.timestamp.FromNanoseconds(truth.t_ns)
            arrow = body.arrows.add(
                shaft_length=0.5 * _LENGTH_M, shaft_diameter=0.25 * _LENGTH_M, head_length=0.5 * _LENGTH_M,
                head_diameter=0.5 * _LENGTH_M, color=_colour(place, 1.0),
            )  # fmt: skip
            arrow.pose.orientation.w = 1.0
            arrow.pose.position.x = -0.5 * _LENGTH_M
            update.entities.append(body)
        return _encode("/scene", truth.t_ns, update)

    def _sailed(self, t_ns: int) -> Encoded:
        update = SceneUpdate()
        for place, (craft, points) in enumerate(self._tracks.items()):
            if len(points) > 1:
                name = f"track/{craft}/{self._pieces}"
                update.entities.append(_line(t_ns, name, points, _colour(place, 1.0), 2.0))
                self._tracks[craft] = points[-1:]
        self._pieces += 1
        return _encode("/scene", t_ns, update)


class _Degrees:
    """Degrees of places in the mission frame, to some centimetres: the exact way takes a tenth of a millisecond."""

    _NEAR_M = 500.0

    def __init__(self, datum: DatumConfig) -> None:
        self._datum = datum
        self._take_up(0.0, 0.0)

    def _take_up(self, north_m: float, east_m: float) -> None:
        """Make the earth flat about a place."""
        self._north_m, self._east_m = north_m, east_m
        self._here = here = to_degrees(self._datum, north_m, east_m)
        beyond, beside = to_degrees(self._datum, north_m + 1.0, east_m), to_degrees(self._datum, north_m, east_m + 1.0)
        self._a_metre_north = beyond[0] - here[0], beyond[1] - here[1]
        self._a_metre_east = beside[0] - here[0], beside[1] - here[1]

    def of(self, north_m: float, east_m: float) -> tuple[float, float]:
        """Return latitude and longitude of a place."""
        if math.dist((north_m, east_m), (self._north_m, self._east_m)) > self._NEAR_M:
            self._take_up(north_m, east_m)
        north, east = north_m - self._north_m, east_m - self._east_m
        latitude, longitude = (
            here + north * up + east * across
            for here, up, across in zip(self._here, self._a_metre_north, self._a_metre_east, strict=True)
        )
        return latitude, longitude


def _location(t_ns: int, pose: Pose, degrees: _Degrees) -> Encoded:
    latitude, longitude = degrees.of(pose.north_m, pose.east_m)
    fix = LocationFix(frame_id=pose.craft, latitude=latitude, longitude=longitude, altitude=-pose.down_m)
    fix.timestamp.FromNanoseconds(t_ns)
    return _encode(f"/{pose.craft}/location", t_ns, fix)


def _frame(t_ns: int, pose: Pose) -> FrameTransform:
    frame = FrameTransform(parent_frame_id="mission", child_frame_id=pose.craft)
    frame.timestamp.FromNanoseconds(t_ns)
    frame.translation.x, frame.translation.y, frame.translation.z = pose.north_m, pose.east_m, pose.down_m
    rotation = frame.rotation
    rotation.x, rotation.y, rotation.z, rotation.w = _quaternion(pose.roll_rad, pose.pitch_rad, pose.heading_rad)
    return frame


def _quaternion(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """Quaternion x, y, z, w of a turn by yaw, then pitch, then roll (aerospace order)."""
    cr, sr = math.cos(roll / 2.0), math.sin(roll / 2.0)
    cp, sp = math.cos(pitch / 2.0), math.sin(pitch / 2.0)
    cy, sy = math.cos(yaw / 2.0), math.sin(yaw / 2.0)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def _line(t_ns: int, name: str, points: Sequence[Point3], colour: Color, thickness_px: float) -> SceneEntity:
    entity = SceneEntity(frame_id="mission", id=name)
    entity.timestamp.FromNanoseconds(t_ns)
    line = entity.lines.add(
        type=LinePrimitive.Type.LINE_STRIP, thickness=thickness_px, scale_invariant=True, points=points, color=colour
    )
    line.pose.orientation.w = 1.0
    return entity


def _colour(place: int, alpha: float) -> Color:
    red, green, blue = _COLOURS[place % len(_COLOURS)]
    return Color(r=red, g=green, b=blue, a=alpha)


def _encode(topic: str, t_ns: int, message: Any) -> Encoded:
    descriptor = message.DESCRIPTOR
    return Encoded(topic, descriptor.full_name, _descriptors(descriptor.file), t_ns, message.SerializeToString())


@cache
def _descriptors(file: FileDescriptor) -> bytes:
    """Return a file of types with all it depends on, as the MCAP format wants them."""
    found: dict[str, FileDescriptor] = {}

    def collect(entry: FileDescriptor) -> None:
        for needed in entry.dependencies:
            collect(needed)
        found.setdefault(entry.name, entry)

    collect(file)
    files = FileDescriptorSet()
    for entry in found.values():
        entry.CopyToProto(files.file.add())
    encoded: bytes = files.SerializeToString()
    return encoded

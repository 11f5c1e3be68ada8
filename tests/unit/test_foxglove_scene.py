"""Recordings hold a map and a scene that other people's readers open."""

import itertools
import math

import foxglove_schemas_protobuf.FrameTransforms_pb2 as frames_pb2
import foxglove_schemas_protobuf.LocationFix_pb2 as location_pb2
import foxglove_schemas_protobuf.SceneUpdate_pb2 as scene_pb2
import pymap3d
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.reader import make_reader
from missions import SCENARIOS, fly
from recordings import recorded_messages

from grex_agent.mission import plan_mission
from grex_link.messages import Pose, Truth
from grex_link.scenario import load
from grex_sim.foxglove_scene import FoxgloveScene

DATUM = "datum={latitude_deg=54.37,longitude_deg=10.16}"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    fly("paper-d", "duration_s=300", DATUM, out=folder)
    return folder / "run.mcap"


def by_topic(path):
    """Messages by topic, each decoded with nothing but the schema that is in the file."""
    found = {}
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            if channel.message_encoding != "protobuf":
                continue
            files = descriptor_pb2.FileDescriptorSet.FromString(schema.data)
            pool = descriptor_pool.DescriptorPool()
            for entry in files.file:
                pool.Add(entry)
            kind = message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name))
            found.setdefault(channel.topic, []).append((message.log_time, schema.name, kind.FromString(message.data)))
    return found


def test_the_file_alone_says_how_to_read_it(run) -> None:
    """With the schemas in the file, and nothing else, every message is decoded: fixes, frames, scene."""
    names = {topic: {name for _, name, _ in messages} for topic, messages in by_topic(run).items()}
    assert names == {
        "/tf": {"foxglove.FrameTransforms"},
        "/scene": {"foxglove.SceneUpdate"},
        **{f"/auv{number}/location": {"foxglove.LocationFix"} for number in (1, 2, 3)},
    }


def test_places_on_earth_are_those_of_the_truth(run) -> None:
    """Latitude and longitude are the true places about the datum, to a few centimetres; times are mission times."""
    truths = {truth.t_ns: truth for truth in recorded_messages(run, "truth")}
    locations = by_topic(run)["/auv2/location"]
    assert len(locations) == 301
    for t_ns, _, fix in locations:
        pose = truths[t_ns].poses[1]
        north, east, _ = pymap3d.geodetic2ned(fix.latitude, fix.longitude, 0.0, 54.37, 10.16, 0.0)
        assert (north, east) == pytest.approx((pose.north_m, pose.east_m), abs=0.05)
        assert fix.timestamp.ToNanoseconds() == t_ns
        assert fix.frame_id == "auv2"


def test_the_scene_has_plan_craft_and_tracks(run) -> None:
    """The plan is drawn first, each craft in its own frame, and the pieces of a track join without a gap."""
    entities = [entity for _, _, update in by_topic(run)["/scene"] for entity in update.entities]
    names = [entity.id for entity in entities]
    assert names[:2] == ["plan/auv1", "craft/auv1"]
    assert {f"craft/auv{number}" for number in (1, 2, 3)} <= set(names)
    assert all(entity.frame_id == entity.id.partition("/")[2] for entity in entities if entity.id.startswith("craft/"))
    pieces = [list(entity.lines[0].points) for entity in entities if entity.id.startswith("track/auv3/")]
    assert len(pieces) > 5
    for before, after in itertools.pairwise(pieces):
        assert (before[-1].x, before[-1].y, before[-1].z) == (after[0].x, after[0].y, after[0].z)
    last = recorded_messages(run, "truth")[-1].poses[2]
    assert (pieces[-1][-1].x, pieces[-1][-1].y) == pytest.approx((last.north_m, last.east_m))


def rotated(q, vector):
    """Vector after the turn of a quaternion: v + 2 q × (q × v + w v)."""
    x, y, z = vector
    cx, cy, cz = q.y * z - q.z * y + q.w * x, q.z * x - q.x * z + q.w * y, q.x * y - q.y * x + q.w * z
    return x + 2 * (q.y * cz - q.z * cy), y + 2 * (q.z * cx - q.x * cz), z + 2 * (q.x * cy - q.y * cx)


def test_frames_turn_as_they_should() -> None:
    """North of the mission is north of the map, down is down; the bow of a craft points where its heading says."""
    scenario = load(SCENARIOS / "paper-d.toml")
    pose = Pose("auv1", 1.0, 2.0, 3.0, 0.1, 0.2, math.radians(30.0), 1.0)
    encoded = list(FoxgloveScene(scenario, plan_mission(scenario)).at(Truth(0, 0, [pose])))
    assert [entry.topic for entry in encoded] == ["/scene", "/tf"]  # without a datum there is no map
    chart, craft = frames_pb2.FrameTransforms.FromString(encoded[1].data).transforms
    assert rotated(chart.rotation, (1.0, 0.0, 0.0)) == pytest.approx((0.0, 1.0, 0.0))  # north is map's y
    assert rotated(chart.rotation, (0.0, 0.0, 1.0)) == pytest.approx((0.0, 0.0, -1.0))
    bow = rotated(craft.rotation, (1.0, 0.0, 0.0))
    assert math.degrees(math.atan2(bow[1], bow[0])) == pytest.approx(30.0)
    assert math.asin(-bow[2]) == pytest.approx(0.2)  # nose up is up
    assert (craft.translation.x, craft.translation.y, craft.translation.z) == (1.0, 2.0, 3.0)


def test_a_pose_that_is_none_is_left_out() -> None:
    """A craft whose place is no number has no frame at that moment; the others have."""
    scenario = load(SCENARIOS / "paper-d.toml", [DATUM])
    poses = [Pose(name, north, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0) for name, north in (("auv1", math.nan), ("auv2", 1.0))]
    encoded = {entry.topic: entry for entry in FoxgloveScene(scenario, plan_mission(scenario)).at(Truth(0, 0, poses))}
    assert "/auv1/location" not in encoded
    assert location_pb2.LocationFix.FromString(encoded["/auv2/location"].data).latitude > 54.37
    assert len(frames_pb2.FrameTransforms.FromString(encoded["/tf"].data).transforms) == 2
    assert len(scene_pb2.SceneUpdate.FromString(encoded["/scene"].data).entities) == 6

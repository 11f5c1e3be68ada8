"""grex view --foxglove, as Foxglove's own connection sees it."""

import json
import struct

import foxglove_schemas_protobuf.FrameTransforms_pb2 as frames_pb2
import foxglove_schemas_protobuf.SceneUpdate_pb2 as scene_pb2
import pytest
from launching import running
from missions import fly

pytest.importorskip("foxglove", reason="install the extra 'foxglove'")
connect = pytest.importorskip("websockets.sync.client", reason="install the extra 'view'").connect


def test_a_recording_is_played_to_foxglove(tmp_path):
    """Channels are advertised with their schemas; who subscribes gets the plan and moving frames, in mission time."""
    fly("paper-d", "duration_s=60", out=tmp_path)
    with running("view", str(tmp_path), "--foxglove", "--port", "0") as process:
        address = process.stdout.readline().strip()
        with connect(address, subprotocols=["foxglove.sdk.v1"]) as socket:
            topics = {}
            while {"/tf", "/scene"} - topics.keys():
                words = json.loads(socket.recv(timeout=60))
                if words["op"] == "advertise":
                    topics |= {channel["topic"]: channel for channel in words["channels"]}
            assert topics["/tf"]["schemaName"] == "foxglove.FrameTransforms"
            wanted = [{"id": number, "channelId": topics[name]["id"]} for number, name in enumerate(("/tf", "/scene"))]
            socket.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))
            frames, plan = [], None
            while len(frames) < 2 or plan is None:
                data = socket.recv(timeout=60)
                if isinstance(data, str):
                    continue
                kind, number, t_ns = struct.unpack_from("<BIQ", data)
                if kind == 1 and number == 0:
                    frames.append((t_ns, frames_pb2.FrameTransforms.FromString(data[13:])))
                elif kind == 1:
                    plan = scene_pb2.SceneUpdate.FromString(data[13:])
    assert plan.entities[0].id == "plan/auv1"
    assert 0 < frames[1][0] <= 60 * 10**9
    assert frames[1][0] > frames[0][0]
    assert [frame.child_frame_id for frame in frames[0][1].transforms] == ["mission", "auv1", "auv2", "auv3"]
    assert frames[1][1].transforms[1].translation.x > frames[0][1].transforms[1].translation.x

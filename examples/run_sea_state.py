"""Run a sea state on a server (`./owt serve` in another terminal): goal, progress, result."""

from __future__ import annotations

import json
import sys
from typing import Any

import rclpy
from owt_msgs.action import RunSeaState
from rclpy.action import ActionClient

CASE = {"sea_state": {"hs_m": 4.0, "tp_s": 8.0, "seed": 3}, "time": {"n": 300}}


def show(message: Any) -> None:
    at = message.feedback
    print(f"{at.time_s:5.1f} of {at.duration_s:.1f} s, {at.speed:.0f} times real time")


def main(bag: str) -> None:
    rclpy.init(args=sys.argv)  # takes --ros-args -r __ns:=/north, for the server of a namespace
    node = rclpy.create_node("operator")
    client = ActionClient(node, RunSeaState, "owt/run_sea_state")
    assert client.wait_for_server(30.0), "no server: start ./owt serve in the same ROS domain"
    sent = client.send_goal_async(
        RunSeaState.Goal(case_json=json.dumps(CASE), bag=bag), feedback_callback=show
    )
    rclpy.spin_until_future_complete(node, sent)
    assert sent.result().accepted, "another run is under way"
    answer = sent.result().get_result_async()
    rclpy.spin_until_future_complete(node, answer)
    result = answer.result().result
    assert result.status == RunSeaState.Result.SUCCEEDED, result.message
    damage = json.loads(result.statistics_json)["fatigue"]["max_damage"]
    print(f"largest damage {damage:.3g} in {result.bag}")
    assert damage > 0.0
    rclpy.shutdown()


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "bags/operator")

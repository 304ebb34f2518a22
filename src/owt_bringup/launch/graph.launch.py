"""The graph on a ROS 2 machine: ``ros2 launch owt_bringup graph.launch.py hs:=4.0 bag:=bags/mine``.

Each node is configured when its process starts and activated when that has succeeded; the nodes wait for
each other, so the order does not matter. When one ends, all end.
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch.actions import DeclareLaunchArgument, EmitEvent, OpaqueFunction, RegisterEventHandler, Shutdown
from launch.event_handlers import OnProcessStart
from launch.events import matches_action
from launch_ros.actions import LifecycleNode
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState
from lifecycle_msgs.msg import Transition

from launch import LaunchDescription
from owt_bringup.arguments import LAUNCH_ARGUMENTS, parameter_overrides
from owt_bringup.nodes import NODES
from owt_bringup.security import enclave_arguments
from owt_ros.topics import POSTPROC


def change(node, transition):
    """Ask `node` for a transition."""
    return EmitEvent(event=ChangeState(lifecycle_node_matcher=matches_action(node), transition_id=transition))


def start(context):
    """Make the nodes and what drives them."""
    given = {entry.name: context.launch_configurations[entry.name] for entry in LAUNCH_ARGUMENTS}
    default = Path(get_package_share_directory("owt_bringup")) / "config" / "default.yaml"
    case = [given["parameters"] or str(default), parameter_overrides(given)]
    bag = {"bag": str(Path(given["bag"]).absolute()), "overwrite": given["overwrite"].lower() == "true"}
    actions = []
    for spec in NODES:
        node = LifecycleNode(
            package=spec.package,
            executable=spec.name,
            name=spec.name,
            namespace=given["namespace"],
            output="screen",
            ros_arguments=enclave_arguments(spec.name),
            parameters=[*case, bag] if spec.name == POSTPROC else case,
            on_exit=Shutdown(reason=f"{spec.name} ended"),
        )
        configure = change(node, Transition.TRANSITION_CONFIGURE)
        activate = change(node, Transition.TRANSITION_ACTIVATE)
        configured = OnStateTransition(
            target_lifecycle_node=node, start_state="configuring", goal_state="inactive", entities=[activate]
        )
        started = OnProcessStart(target_action=node, on_start=[configure])
        actions += [RegisterEventHandler(configured), RegisterEventHandler(started), node]
    return actions


def generate_launch_description():
    """Declare the arguments and start."""
    declared = [
        DeclareLaunchArgument(entry.name, default_value=entry.default, description=entry.description)
        for entry in LAUNCH_ARGUMENTS
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])

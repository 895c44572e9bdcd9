"""Programs that judge the bridge to ROS 2 by software of others; each runs in an environment of its own, without lbr.

    pip install pyzeros zenoh-ros2-sdk                          LBR_ROS_SIDES is its python; the first start takes minutes
    pip install --only-binary :all: --no-binary empy,lark ros-rclpy \
        ros-rmw-fastrtps-cpp ros-geometry-msgs ros-sensor-msgs ros-nav-msgs ros-std-srvs     LBR_RCLPY, Python 3.12
"""

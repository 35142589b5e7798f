//! Takes and plans as ROS 2 bags: MCAP with profile `ros2`, messages in CDR, definitions in `ros2msg`.
//!
//! | topic | message | content |
//! | --- | --- | --- |
//! | `/<body>/pose` | `geometry_msgs/msg/PoseStamped` | a rigid body in `world` |
//! | `/<marker>/point` | `geometry_msgs/msg/PointStamped` | a marker in `world` |
//! | `/tf`, `/tf_static` | `tf2_msgs/msg/TFMessage` | bodies in `world`; `world` in `upright`, whose z points up |
//! | `/markers` | `visualization_msgs/msg/MarkerArray` | markers, bodies, object, generated fingertips, at most 50 a second |
//! | `/generated/<method>/trajectory` | `trajectory_msgs/msg/MultiDOFJointTrajectory` | fingertips in the frame of the hand, with velocities |
//! | `/annotations` | `std_msgs/msg/String` | events as JSON |
//!
//! * A sample that is missing has no message: ROS tools refuse coordinates that are not numbers.
//! * Names become parts of topics and frames: every other character than a letter, a digit or `_` is a `_`.
//! * The frame of the hand is that of its rigid body, else `hand`.
//! * Stamps and log times are those of the samples.

mod bag;
mod cdr;
mod content;
mod definitions;
mod scene;
mod take;

pub use bag::Ros2Bag;
pub use content::{Colour, Ros2Method, Ros2Take};
pub use take::{write_ros2, write_ros2_markers};

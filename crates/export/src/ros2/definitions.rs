//! Definitions of the messages that are written, as a bag holds them for readers without ROS.

/// Fields of each type, without comments. `visualization_msgs` is that of Humble and later.
const TYPES: [(&str, &str); 22] = [
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"),
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec\n"),
    (
        "std_msgs/Header",
        "builtin_interfaces/Time stamp\nstring frame_id\n",
    ),
    ("std_msgs/String", "string data\n"),
    (
        "std_msgs/ColorRGBA",
        "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n",
    ),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"),
    (
        "geometry_msgs/Quaternion",
        "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
    ),
    (
        "geometry_msgs/Pose",
        "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
    ),
    (
        "geometry_msgs/PoseStamped",
        "std_msgs/Header header\ngeometry_msgs/Pose pose\n",
    ),
    (
        "geometry_msgs/PointStamped",
        "std_msgs/Header header\ngeometry_msgs/Point point\n",
    ),
    (
        "geometry_msgs/Transform",
        "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
    ),
    (
        "geometry_msgs/TransformStamped",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
    ),
    (
        "geometry_msgs/Twist",
        "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n",
    ),
    (
        "tf2_msgs/TFMessage",
        "geometry_msgs/TransformStamped[] transforms\n",
    ),
    (
        "trajectory_msgs/MultiDOFJointTrajectoryPoint",
        "geometry_msgs/Transform[] transforms\ngeometry_msgs/Twist[] velocities\n\
         geometry_msgs/Twist[] accelerations\nbuiltin_interfaces/Duration time_from_start\n",
    ),
    (
        "trajectory_msgs/MultiDOFJointTrajectory",
        "std_msgs/Header header\nstring[] joint_names\n\
         trajectory_msgs/MultiDOFJointTrajectoryPoint[] points\n",
    ),
    (
        "visualization_msgs/MarkerArray",
        "visualization_msgs/Marker[] markers\n",
    ),
    (
        "visualization_msgs/Marker",
        "int32 ARROW=0\nint32 CUBE=1\nint32 SPHERE=2\nint32 CYLINDER=3\nint32 LINE_STRIP=4\n\
         int32 LINE_LIST=5\nint32 CUBE_LIST=6\nint32 SPHERE_LIST=7\nint32 POINTS=8\n\
         int32 TEXT_VIEW_FACING=9\nint32 MESH_RESOURCE=10\nint32 TRIANGLE_LIST=11\n\
         int32 ARROW_STRIP=12\nint32 ADD=0\nint32 MODIFY=0\nint32 DELETE=2\nint32 DELETEALL=3\n\
         std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n\
         geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n\
         builtin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n\
         std_msgs/ColorRGBA[] colors\nstring texture_resource\n\
         sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\n\
         string text\nstring mesh_resource\nvisualization_msgs/MeshFile mesh_file\n\
         bool mesh_use_embedded_materials\n",
    ),
    (
        "sensor_msgs/CompressedImage",
        "std_msgs/Header header\nstring format\nuint8[] data\n",
    ),
    ("visualization_msgs/UVCoordinate", "float32 u\nfloat32 v\n"),
    (
        "visualization_msgs/MeshFile",
        "string filename\nuint8[] data\n",
    ),
];

/// The definition of a type, and of all that it is made of.
///
/// # Panics
///
/// Where a type is not in the table.
pub(super) fn definition(name: &str) -> String {
    let mut needed = vec![name];
    let mut text = String::new();
    let mut next = 0;
    while let Some(&name) = needed.get(next) {
        let (_, fields) = (TYPES.iter().find(|(known, _)| *known == name))
            .unwrap_or_else(|| panic!("{name} has a definition"));
        if next > 0 {
            text += &format!("{}\nMSG: {name}\n", "=".repeat(80));
        }
        text += fields;
        for line in fields.lines() {
            let kind = line.split([' ', '[']).next().unwrap_or_default();
            if kind.contains('/') && !needed.contains(&kind) {
                needed.push(kind);
            }
        }
        next += 1;
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definition_holds_each_type_that_it_needs_once() {
        let text = definition("tf2_msgs/TFMessage");
        let parts: Vec<&str> = text.lines().filter(|l| l.starts_with("MSG: ")).collect();
        assert_eq!(
            parts,
            [
                "MSG: geometry_msgs/TransformStamped",
                "MSG: std_msgs/Header",
                "MSG: geometry_msgs/Transform",
                "MSG: builtin_interfaces/Time",
                "MSG: geometry_msgs/Vector3",
                "MSG: geometry_msgs/Quaternion",
            ]
        );
        for (name, _) in TYPES {
            assert!(!definition(name).is_empty());
        }
    }
}

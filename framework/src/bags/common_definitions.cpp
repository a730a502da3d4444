// Fields of common messages, as their packages declare them: what a recording of ROS 2 from before Iron does not hold.
#include "bags/message_schema.hpp"

namespace gripline::bags {

const Definitions& common_definitions() {
  static const Definitions all = {
      {"std_msgs/Header", "uint32 seq\ntime stamp\nstring frame_id\n"},
      {"std_msgs/Bool", "bool data\n"},
      {"std_msgs/Int8", "int8 data\n"},
      {"std_msgs/UInt8", "uint8 data\n"},
      {"std_msgs/Int16", "int16 data\n"},
      {"std_msgs/UInt16", "uint16 data\n"},
      {"std_msgs/Int32", "int32 data\n"},
      {"std_msgs/UInt32", "uint32 data\n"},
      {"std_msgs/Int64", "int64 data\n"},
      {"std_msgs/UInt64", "uint64 data\n"},
      {"std_msgs/Float32", "float32 data\n"},
      {"std_msgs/Float64", "float64 data\n"},
      {"std_msgs/MultiArrayDimension", "string label\nuint32 size\nuint32 stride\n"},
      {"std_msgs/MultiArrayLayout", "MultiArrayDimension[] dim\nuint32 data_offset\n"},
      {"std_msgs/Float32MultiArray", "MultiArrayLayout layout\nfloat32[] data\n"},
      {"std_msgs/Float64MultiArray", "MultiArrayLayout layout\nfloat64[] data\n"},
      {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
      {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
      {"geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"},
      {"geometry_msgs/Pose", "Point position\nQuaternion orientation\n"},
      {"geometry_msgs/Pose2D", "float64 x\nfloat64 y\nfloat64 theta\n"},
      {"geometry_msgs/PoseWithCovariance", "Pose pose\nfloat64[36] covariance\n"},
      {"geometry_msgs/Twist", "Vector3 linear\nVector3 angular\n"},
      {"geometry_msgs/TwistWithCovariance", "Twist twist\nfloat64[36] covariance\n"},
      {"geometry_msgs/Accel", "Vector3 linear\nVector3 angular\n"},
      {"geometry_msgs/AccelWithCovariance", "Accel accel\nfloat64[36] covariance\n"},
      {"geometry_msgs/Transform", "Vector3 translation\nQuaternion rotation\n"},
      {"geometry_msgs/PointStamped", "std_msgs/Header header\nPoint point\n"},
      {"geometry_msgs/Vector3Stamped", "std_msgs/Header header\nVector3 vector\n"},
      {"geometry_msgs/QuaternionStamped", "std_msgs/Header header\nQuaternion quaternion\n"},
      {"geometry_msgs/PoseStamped", "std_msgs/Header header\nPose pose\n"},
      {"geometry_msgs/PoseWithCovarianceStamped", "std_msgs/Header header\nPoseWithCovariance pose\n"},
      {"geometry_msgs/TwistStamped", "std_msgs/Header header\nTwist twist\n"},
      {"geometry_msgs/TwistWithCovarianceStamped", "std_msgs/Header header\nTwistWithCovariance twist\n"},
      {"geometry_msgs/AccelStamped", "std_msgs/Header header\nAccel accel\n"},
      {"geometry_msgs/AccelWithCovarianceStamped", "std_msgs/Header header\nAccelWithCovariance accel\n"},
      {"geometry_msgs/TransformStamped", "std_msgs/Header header\nstring child_frame_id\nTransform transform\n"},
      {"nav_msgs/Odometry",
       "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
       "geometry_msgs/TwistWithCovariance twist\n"},
      {"sensor_msgs/Imu",
       "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
       "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
       "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n"},
      {"sensor_msgs/NavSatStatus", "int8 status\nuint16 service\n"},
      {"sensor_msgs/NavSatFix",
       "std_msgs/Header header\nNavSatStatus status\nfloat64 latitude\nfloat64 longitude\nfloat64 altitude\n"
       "float64[9] position_covariance\nuint8 position_covariance_type\n"},
      {"sensor_msgs/JointState",
       "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n"},
      {"ackermann_msgs/AckermannDrive",
       "float32 steering_angle\nfloat32 steering_angle_velocity\nfloat32 speed\nfloat32 acceleration\nfloat32 jerk\n"},
      {"ackermann_msgs/AckermannDriveStamped", "std_msgs/Header header\nAckermannDrive drive\n"},
  };
  return all;
}

}  // namespace gripline::bags

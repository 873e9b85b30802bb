//! The standard messages of ROS 2 that are read from a log, decoded from CDR in the order of their definitions in `common_interfaces`.
//!
//! Every function returns `None` when the message is shorter than its type, or is not what the type allows.

use localizer::Pose;

use crate::artefacts::recording::cdr::Fields;

/// A `std_msgs/Header`: the stamp in nanoseconds, and the frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Header {
    pub(super) stamp_ns: i64,
    pub(super) frame: String,
}

/// Position and attitude of a body in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SpatialPose {
    pub(super) position_m: [f64; 3],
    /// Attitude as a quaternion x, y, z, w.
    pub(super) attitude: [f64; 4],
}

/// The content of a `sensor_msgs/NavSatFix`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SatelliteFix {
    /// −1 for no fix, 0 for an unaugmented one, 1 for one with corrections from satellites, 2 for one with corrections from the ground.
    pub(super) status: i8,
    pub(super) latitude_deg: f64,
    pub(super) longitude_deg: f64,
    pub(super) altitude_m: f64,
    /// Covariance of the position east, north and up, 3 × 3 in rows; `None` where it is not known.
    pub(super) covariance_m2: Option<[f64; 9]>,
}

/// The content of a `sensor_msgs/CameraInfo`, as far as it describes the lens.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LensInfo {
    pub(super) size_px: [u32; 2],
    /// Name of the model of distortion, such as `plumb_bob`.
    pub(super) model: String,
    /// Coefficients of the distortion; for `plumb_bob` k1, k2, p1, p2, k3.
    pub(super) distortion: Vec<f64>,
    /// Focal lengths along u and v.
    pub(super) focal_px: [f64; 2],
    pub(super) principal_point_px: [f64; 2],
}

/// The content of a `sensor_msgs/Image`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RawImage<'a> {
    pub(super) size_px: [u32; 2],
    pub(super) encoding: &'a str,
    pub(super) is_big_endian: bool,
    /// Number of bytes from the begin of one row to that of the next.
    pub(super) step: usize,
    pub(super) data: &'a [u8],
}

impl SpatialPose {
    /// The pose in the plane; `None` where the attitude is no unit quaternion. The heading is that of the body's x axis, seen from above.
    pub(super) fn planar(&self) -> Option<Pose> {
        let [x, y, z, w] = self.attitude;
        let squared = x * x + y * y + z * z + w * w;
        // A quaternion that was rounded to single precision has a length within 1e-6 of 1; what is off by a hundredth was never normalised.
        if !(0.98..1.02).contains(&squared) {
            return None;
        }
        let heading_rad = (2.0 * (w * z + x * y)).atan2(w * w + x * x - y * y - z * z);
        Some(Pose { x_m: self.position_m[0], y_m: self.position_m[1], heading_rad })
    }
}

/// The header of a message whose first field is a header.
pub(super) fn header(message: &[u8]) -> Option<Header> {
    header_of(&mut Fields::of_others(message)?)
}

/// Stamp in nanoseconds, name and sentence of a `rcl_interfaces/Log`.
pub(super) fn log(message: &[u8]) -> Option<(i64, String, String)> {
    let mut fields = Fields::of_others(message)?;
    let (seconds, nanoseconds, _level) = (fields.i32()?, fields.u32()?, fields.u8()?);
    let stamp_ns = i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds);
    Some((stamp_ns, fields.text()?.to_owned(), fields.text()?.to_owned()))
}

/// The pose of a `nav_msgs/Odometry`.
pub(super) fn odometry(message: &[u8]) -> Option<(Header, SpatialPose)> {
    let mut fields = Fields::of_others(message)?;
    let header = header_of(&mut fields)?;
    let _child_frame = fields.text()?;
    Some((header, pose_of(&mut fields)?))
}

/// The pose of a `geometry_msgs/PoseStamped` or `geometry_msgs/PoseWithCovarianceStamped`, which begin alike.
pub(super) fn pose_stamped(message: &[u8]) -> Option<(Header, SpatialPose)> {
    let mut fields = Fields::of_others(message)?;
    Some((header_of(&mut fields)?, pose_of(&mut fields)?))
}

/// The names and the positions of a `sensor_msgs/JointState`.
pub(super) fn joint_state(message: &[u8]) -> Option<(Header, Vec<(String, f64)>)> {
    let mut fields = Fields::of_others(message)?;
    let header = header_of(&mut fields)?;
    let names = fields.sequence(|fields| fields.text().map(str::to_owned))?;
    let positions = fields.sequence(Fields::f64)?;
    // Joints of which only velocities or efforts are known have no position.
    Some((header, names.into_iter().zip(positions).collect()))
}

/// The turn rates about the axes of the sensor of a `sensor_msgs/Imu`; `None` inside where the message says that they are not measured.
pub(super) fn imu(message: &[u8]) -> Option<(Header, Option<[f64; 3]>)> {
    let mut fields = Fields::of_others(message)?;
    let header = header_of(&mut fields)?;
    let _orientation = (fields.f64s::<4>()?, fields.f64s::<9>()?);
    let rates_rad_per_s = fields.f64s::<3>()?;
    let [first, ..] = fields.f64s::<9>()?;
    // By the definition of the message the first element of the covariance is −1 where the quantity is not measured.
    Some((header, (first != -1.0).then_some(rates_rad_per_s)))
}

/// The position of a `sensor_msgs/NavSatFix`.
pub(super) fn satellite_fix(message: &[u8]) -> Option<(Header, SatelliteFix)> {
    let mut fields = Fields::of_others(message)?;
    let header = header_of(&mut fields)?;
    let status = i8::from_le_bytes([fields.u8()?]);
    let _service = fields.u16()?;
    let [latitude_deg, longitude_deg, altitude_m] = fields.f64s()?;
    let covariance_m2 = fields.f64s::<9>()?;
    let is_known = fields.u8()? != 0;
    let covariance_m2 = is_known.then_some(covariance_m2);
    Some((header, SatelliteFix { status, latitude_deg, longitude_deg, altitude_m, covariance_m2 }))
}

/// The content of a `sensor_msgs/LaserScan` without its intensities.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LaserScan {
    /// Bearing of the first beam, counter-clockwise from the scanner's forward axis.
    pub(super) first_rad: f64,
    /// Angle from one beam to the next.
    pub(super) step_rad: f64,
    /// Time from the measurement of one beam to that of the next.
    pub(super) step_s: f64,
    /// Least and greatest distance that a beam measures. Other numbers among the distances stand for a beam that measured nothing.
    pub(super) between_m: [f64; 2],
    pub(super) distances_m: Vec<f64>,
}

/// The distances of a `sensor_msgs/LaserScan`, with the stamp of the first beam.
pub(super) fn laser_scan(message: &[u8]) -> Option<(Header, LaserScan)> {
    let mut fields = Fields::of_others(message)?;
    let header = header_of(&mut fields)?;
    let mut number = || fields.f32().map(f64::from);
    let (first_rad, _last_rad, step_rad) = (number()?, number()?, number()?);
    let (step_s, _period_s) = (number()?, number()?);
    let between_m = [number()?, number()?];
    let distances_m = fields.sequence(|fields| fields.f32().map(f64::from))?;
    Some((header, LaserScan { first_rad, step_rad, step_s, between_m, distances_m }))
}

/// The lens of a `sensor_msgs/CameraInfo`.
pub(super) fn camera_info(message: &[u8]) -> Option<(Header, LensInfo)> {
    let mut fields = Fields::of_others(message)?;
    let header = header_of(&mut fields)?;
    let (height, width) = (fields.u32()?, fields.u32()?);
    let model = fields.text()?.to_owned();
    let distortion = fields.sequence(Fields::f64)?;
    let [fu, _, cu, _, fv, cv, ..] = fields.f64s::<9>()?;
    let (focal_px, principal_point_px) = ([fu, fv], [cu, cv]);
    Some((header, LensInfo { size_px: [width, height], model, distortion, focal_px, principal_point_px }))
}

/// The pixels of a `sensor_msgs/Image`.
pub(super) fn image(message: &[u8]) -> Option<(Header, RawImage<'_>)> {
    let mut fields = Fields::of_others(message)?;
    let header = header_of(&mut fields)?;
    let (height, width) = (fields.u32()?, fields.u32()?);
    let encoding = fields.text()?;
    let is_big_endian = fields.bool()?;
    let step = usize::try_from(fields.u32()?).ok()?;
    let data = fields.bytes()?;
    Some((header, RawImage { size_px: [width, height], encoding, is_big_endian, step, data }))
}

/// The format and the file of a `sensor_msgs/CompressedImage`.
pub(super) fn compressed_image(message: &[u8]) -> Option<(Header, &str, &[u8])> {
    let mut fields = Fields::of_others(message)?;
    let header = header_of(&mut fields)?;
    Some((header, fields.text()?, fields.bytes()?))
}

fn header_of(fields: &mut Fields<'_>) -> Option<Header> {
    let (seconds, nanoseconds) = (i64::from(fields.i32()?), i64::from(fields.u32()?));
    Some(Header { stamp_ns: seconds * 1_000_000_000 + nanoseconds, frame: fields.text()?.to_owned() })
}

fn pose_of(fields: &mut Fields<'_>) -> Option<SpatialPose> {
    Some(SpatialPose { position_m: fields.f64s()?, attitude: fields.f64s()? })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// `std_msgs/Header` with the stamp 1.5 s and the frame `f`, followed by the numbers of a pose, written by hand: the text of two bytes ends at
    /// byte 14, and the first number of eight bytes begins at byte 16.
    fn pose_message(is_big_endian: bool) -> Vec<u8> {
        let mut bytes = vec![0, u8::from(!is_big_endian), 0, 3];
        let mut put = |mut number: Vec<u8>| {
            if is_big_endian {
                number.reverse();
            }
            bytes.extend(number);
        };
        put(1_i32.to_le_bytes().to_vec());
        put(500_000_000_u32.to_le_bytes().to_vec());
        put(2_u32.to_le_bytes().to_vec());
        bytes.extend([b'f', 0, 0, 0]);
        let mut put = |number: f64| {
            bytes.extend(if is_big_endian { number.to_be_bytes() } else { number.to_le_bytes() });
        };
        [1.0, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8].into_iter().for_each(&mut put);
        bytes
    }

    #[test]
    fn a_pose_is_read_in_either_order_of_bytes() {
        for is_big_endian in [false, true] {
            let (header, pose) = pose_stamped(&pose_message(is_big_endian)).unwrap();
            assert_eq!((header.stamp_ns, header.frame.as_str()), (1_500_000_000, "f"));
            // The quaternion (0, 0, 0.6, 0.8) is a turn about z by 2·asin 0.6.
            let planar = pose.planar().unwrap();
            assert_eq!((planar.x_m, planar.y_m), (1.0, 2.0));
            assert!((planar.heading_rad - 2.0 * 0.6_f64.asin()).abs() < 1e-15);
        }
    }

    #[test]
    fn a_message_that_ends_too_early_is_none() {
        let whole = pose_message(false);
        for length in 0..whole.len() {
            assert_eq!(pose_stamped(&whole[..length]), None);
        }
    }

    #[test]
    fn an_attitude_of_zeros_is_no_heading() {
        let unset = SpatialPose { position_m: [0.0; 3], attitude: [0.0; 4] };
        assert_eq!(unset.planar(), None);
    }

    #[test]
    fn the_heading_of_a_leaning_body_is_that_of_its_x_axis_seen_from_above() {
        // A turn about the vertical by 0.7 rad of a body that pitches by 0.3 rad and rolls about its own x axis by 0.2 rad: the product of the three
        // quaternions about z, y and x.
        let [(sz, cz), (sy, cy), (sx, cx)] = [0.35_f64, 0.15, 0.1].map(f64::sin_cos);
        let attitude = [
            cz * cy * sx - sz * sy * cx,
            cz * sy * cx + sz * cy * sx,
            sz * cy * cx - cz * sy * sx,
            cz * cy * cx + sz * sy * sx,
        ];
        let heading_rad = SpatialPose { position_m: [0.0; 3], attitude }.planar().unwrap().heading_rad;
        assert!((heading_rad - 0.7).abs() < 1e-12, "{heading_rad}");
    }

    /// A header with the stamp 0 and the frame `f`, of 18 bytes; numbers lie at multiples of their length from its fifth byte on.
    fn header_bytes() -> Vec<u8> {
        vec![0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, b'f', 0]
    }

    fn bytes_of(numbers: &[f64]) -> Vec<u8> {
        numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
    }

    #[test]
    fn turn_rates_are_measured_unless_their_own_covariance_begins_with_minus_one() {
        let rates_with = |unmeasured: usize| {
            // Orientation, turn rates and acceleration, each with its covariance.
            let mut numbers = [0.0; 4 + 9 + 3 + 9 + 3 + 9];
            numbers[13..16].copy_from_slice(&[0.1, 0.2, 0.3]);
            numbers[[4, 16, 28][unmeasured]] = -1.0;
            imu(&[header_bytes(), vec![0; 2], bytes_of(&numbers)].concat()).unwrap().1
        };
        let measured = Some([0.1, 0.2, 0.3]);
        assert_eq!([0, 1, 2].map(rates_with), [measured, None, measured]);
    }

    #[test]
    fn a_positions_covariance_is_known_unless_its_type_is_0() {
        let covariance_m2 = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];
        let fix_with = |kind: u8| {
            // The status is a byte, the service a number of two bytes at the 16th, and latitude begins at the 24th.
            let status = vec![2, 0, 9, 9, 0, 0, 0, 0, 0, 0];
            let numbers = [&[45.0, 9.0, 100.0], &covariance_m2[..]].concat();
            satellite_fix(&[header_bytes(), status, bytes_of(&numbers), vec![kind]].concat()).unwrap().1
        };
        assert_eq!(fix_with(0).covariance_m2, None);
        for kind in [1, 2, 3] {
            assert_eq!(fix_with(kind).covariance_m2, Some(covariance_m2));
        }
        let SatelliteFix { status, latitude_deg, longitude_deg, altitude_m, .. } = fix_with(0);
        assert_eq!((status, latitude_deg, longitude_deg, altitude_m), (2, 45.0, 9.0, 100.0));
    }
}

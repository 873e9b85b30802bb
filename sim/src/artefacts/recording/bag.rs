//! The file `metadata.yaml`, without which ROS 2 tools do not recognise an MCAP file as a bag.

use std::fmt::Write;

/// What a bag's `metadata.yaml` says about one topic.
pub(super) struct Topic<'a> {
    pub(super) name: &'a str,
    /// Message type, as `package/msg/Type`.
    pub(super) kind: &'a str,
    pub(super) n_messages: u32,
}

/// Quality of service of static transforms, in the numbers of ROS 2's `rmw`: keep last, reliable, transient local, automatic liveliness.
/// With it, subscribers that join late still receive the static transforms.
const LATCHED: &str = concat!(
    "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 9223372036\n    nsec: 854775807\n",
    "  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: 1\n  liveliness_lease_duration:\n",
    "    sec: 9223372036\n    nsec: 854775807\n  avoid_ros_namespace_conventions: false"
);

/// The quality of service under which a topic is offered, as YAML. The bag's description and the MCAP channel must state the same one:
/// readers look up a channel's topic by it.
pub(super) fn offered_qos_profiles(topic: &str) -> &'static str {
    if topic == "/tf_static" { LATCHED } else { "" }
}

/// The description of a bag that consists of one file, in version 5 as ROS 2 Humble writes it.
pub(super) fn metadata_yaml(file_name: &str, topics: &[Topic<'_>], duration_ns: u64) -> String {
    let n_messages: u32 = topics.iter().map(|topic| topic.n_messages).sum();
    let mut text = format!(
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  duration:\n    nanoseconds: {duration_ns}\n  \
         starting_time:\n    nanoseconds_since_epoch: 0\n  message_count: {n_messages}\n  topics_with_message_count:\n"
    );
    for Topic { name, kind, n_messages } in topics {
        let qos = offered_qos_profiles(name).replace('\n', "\\n");
        // Writing to a `String` cannot fail.
        let _ = write!(
            text,
            "    - topic_metadata:\n        name: {name}\n        type: {kind}\n        serialization_format: cdr\n        \
             offered_qos_profiles: \"{qos}\"\n      message_count: {n_messages}\n"
        );
    }
    let _ = write!(
        text,
        "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - {file_name}\n  files:\n    \
         - path: {file_name}\n      starting_time:\n        nanoseconds_since_epoch: 0\n      duration:\n        \
         nanoseconds: {duration_ns}\n      message_count: {n_messages}\n"
    );
    text
}

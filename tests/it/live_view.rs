//! Tests of the live stream: a viewer of Foxglove's WebSocket protocol (github.com/foxglove/ws-protocol), written for the tests, watches
//! while a scene runs.

use std::{
    collections::BTreeMap,
    fs,
    io::{BufRead, BufReader},
    net::TcpStream,
    path::Path,
    process::Stdio,
    time::Instant,
};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket, client::IntoClientRequest, http::HeaderValue, stream::MaybeTlsStream};

use crate::command::{blind_scene, folder, outcome, wherein};

/// Messages that were received, by topic: simulated time in nanoseconds, and content.
type Heard = BTreeMap<String, Vec<(u64, Vec<u8>)>>;

/// Subscribes to every channel and listens until the run is over. Returns the messages, and the announced channels by topic.
fn listen(mut socket: WebSocket<MaybeTlsStream<TcpStream>>) -> (Heard, BTreeMap<String, Value>) {
    let (mut heard, mut channels, mut topics) = (Heard::new(), BTreeMap::new(), BTreeMap::new());
    while let Ok(message) = socket.read() {
        match message {
            Message::Text(text) => {
                let told: Value = serde_json::from_str(&text).unwrap();
                for channel in told["channels"].as_array().filter(|_| told["op"] == "advertise").into_iter().flatten() {
                    let (id, topic) = (channel["id"].as_u64().unwrap(), channel["topic"].as_str().unwrap().to_owned());
                    topics.insert(u32::try_from(id).unwrap(), topic.clone());
                    channels.insert(topic, channel.clone());
                    let wish = json!({ "op": "subscribe", "subscriptions": [{ "id": id, "channelId": id }] });
                    socket.send(Message::text(wish.to_string())).unwrap();
                }
            }
            // Messages with the opcode 1 hold a subscription (u32), a time (u64) and the content, all little-endian.
            Message::Binary(bytes) if bytes[0] == 1 => {
                let id = u32::from_le_bytes(bytes[1..5].try_into().unwrap());
                let time_ns = u64::from_le_bytes(bytes[5..13].try_into().unwrap());
                heard.entry(topics[&id].clone()).or_default().push((time_ns, bytes[13..].to_vec()));
            }
            _ => {}
        }
    }
    (heard, channels)
}

/// Messages and channels of a run of three seconds as a viewer receives them; it takes three seconds.
fn viewed(place: &Path) -> (Heard, BTreeMap<String, Value>) {
    let mut command = wherein(place, &["run", "scene.toml", "--live=127.0.0.1:0", "--record"]);
    let mut child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    let mut errors = BufReader::new(child.stderr.take().unwrap()).lines();
    let line = errors.by_ref().map(Result::unwrap).find(|line| line.contains("Waiting for a viewer")).unwrap();
    let address = line.split_whitespace().last().unwrap();
    let mut request = address.into_client_request().unwrap();
    request.headers_mut().insert("Sec-WebSocket-Protocol", HeaderValue::from_static("foxglove.sdk.v1"));
    let (socket, _) = tungstenite::connect(request).unwrap();
    let began = Instant::now();
    let seen = listen(socket);
    let rest: Vec<String> = errors.map_while(Result::ok).collect();
    assert!(child.wait().unwrap().success(), "{rest:?}");
    assert!(began.elapsed().as_secs_f64() > 2.7, "{:?}", began.elapsed());
    seen
}

#[test]
fn a_viewer_sees_a_run_in_real_time_with_definitions_and_mounts() {
    let place = folder("live_view");
    let scene = blind_scene(3.0, "").replace("floor_camera = false\n", "");
    fs::write(place.join("scene.toml"), scene + "[floor.tiles]\n").unwrap();
    // On a machine that is busy for seconds a connection may be lost; then the viewer connects again.
    let (mut heard, mut channels) = viewed(&place);
    for _ in 0..4 {
        if heard.get("/estimate").is_some_and(|shown| shown.len() > 250) && heard.len() >= 9 {
            break;
        }
        (heard, channels) = viewed(&place);
    }
    for (topic, kind) in [
        ("/floor_camera/image", "sensor_msgs/msg/Image"),
        ("/estimate", "geometry_msgs/msg/PoseStamped"),
        ("/tf_static", "tf2_msgs/msg/TFMessage"),
        ("/boxes", "foxglove_msgs/msg/SceneUpdate"),
    ] {
        let channel = &channels[topic];
        assert_eq!((&channel["encoding"], &channel["schemaName"]), (&json!("cdr"), &json!(kind)));
        assert!(channel["schema"].as_str().unwrap().contains("MSG: ") && channel["schemaEncoding"] == "ros2msg");
        assert!(!heard[topic].is_empty(), "{topic}");
    }
    assert!(!channels.keys().any(|topic| topic.starts_with("/wherein/")), "{channels:?}");
    // The estimates that the viewer was shown live must be the same messages as those in the recording.
    let bytes = fs::read(place.join("renders/scene/0/recording.mcap")).unwrap();
    let recorded: Vec<(u64, Vec<u8>)> = mcap::MessageStream::new(&bytes)
        .unwrap()
        .map(Result::unwrap)
        .filter(|message| message.channel.topic == "/estimate")
        .map(|message| (message.log_time, message.data.to_vec()))
        .collect();
    let shown = &heard["/estimate"];
    assert!(shown.len() > 250 && recorded.ends_with(shown), "{} of {}", shown.len(), recorded.len());
}

#[test]
fn an_address_that_is_taken_is_told_and_nothing_runs() {
    let place = folder("live_taken");
    fs::write(place.join("scene.toml"), blind_scene(1.0, "")).unwrap();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let live = format!("--live={}", taken.local_addr().unwrap());
    let (code, _, errors) = outcome(&mut wherein(&place, &["run", "scene.toml", &live]));
    assert_eq!(code, 2, "{errors}");
    assert!(errors.contains("failed to listen at 127.0.0.1:") && !place.join("renders/scene").exists(), "{errors}");
    let (code, _, errors) = outcome(&mut wherein(&place, &["run", "scene.toml", "--live=nowhere"]));
    assert!(code == 2 && errors.contains("nowhere"), "{errors}");
}

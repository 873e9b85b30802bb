//! A localizer in a process of its own, for tests: it answers that the robot has not moved, until it misbehaves as its arguments say.
//!
//! The first argument is the kind of its answers (`pose`, `gaussian`, `samples`, `boxes`); the second, if any, is what it does instead of the third
//! answer.

use std::{
    collections::BTreeMap,
    env,
    io::{self, Read, Write},
    process::{Command, exit},
    thread,
    time::Duration,
};

/// Number of the answer in place of which it misbehaves: that for 0.02 s.
const MISBEHAVES_AT: usize = 3;

fn main() -> io::Result<()> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let (kind, misdeed) = (arguments.first().map_or("pose", String::as_str), arguments.get(1).map(String::as_str));
    let mut input = io::stdin().lock();
    let (mut magic, mut topics, mut start, mut n_asked) = ([0; 8], BTreeMap::new(), String::new(), 0);
    input.read_exact(&mut magic)?;
    while let Some((kind_of_record, record)) = record(&mut input)? {
        let channel = [record[0], record[1]];
        match kind_of_record {
            // A channel: its number, that of its schema, the length of its topic and the topic.
            4 => {
                let length = u32::from_le_bytes([record[4], record[5], record[6], record[7]]) as usize;
                topics.insert(channel, String::from_utf8_lossy(&record[8..8 + length]).into_owned());
            }
            // A message: its channel, 20 bytes of numbers and times, its content.
            5 => {
                let content = String::from_utf8_lossy(&record[22..]).into_owned();
                match topics.get(&channel).map_or("", String::as_str) {
                    "/wherein/start" => start = content,
                    "/wherein/ask" => {
                        n_asked += 1;
                        let time_s = value(&content, "time_s");
                        match misdeed {
                            Some(misdeed) if n_asked == MISBEHAVES_AT => misbehave(misdeed, &time_s)?,
                            _ => say(&answer(kind, &time_s, &value(&start, "box")))?,
                        }
                    }
                    _ => {}
                }
            }
            _ => {}
        }
    }
    Ok(())
}

/// The next record of an MCAP stream: its kind and its content; `None` at the end.
fn record(input: &mut impl Read) -> io::Result<Option<(u8, Vec<u8>)>> {
    let mut head = [0; 9];
    match input.read_exact(&mut head) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
        read => read?,
    }
    let mut length = [0; 8];
    length.copy_from_slice(&head[1..]);
    let mut content = vec![0; u64::from_le_bytes(length) as usize];
    input.read_exact(&mut content)?;
    Ok(Some((head[0], content)))
}

/// Text of the value of the last key in a JSON object.
fn value(json: &str, key: &str) -> String {
    let from = json.find(&format!("\"{key}\":")).map_or(json.len(), |at| at + key.len() + 3);
    json[from..].trim_end_matches('}').to_owned()
}

fn say(line: &str) -> io::Result<()> {
    let mut output = io::stdout().lock();
    writeln!(output, "{line}").and_then(|()| output.flush())
}

/// The answer that the robot stands in the start box.
fn answer(kind: &str, time_s: &str, start: &str) -> String {
    let sides: Vec<f64> = start.split(|c: char| "[],".contains(c)).filter_map(|number| number.parse().ok()).collect();
    let middle: Vec<f64> = sides.chunks(2).map(|side| side.iter().sum::<f64>() / 2.0).collect();
    match kind {
        "gaussian" => {
            let covariance = "[[1e-4, 0, 0], [0, 1e-4, 0], [0, 0, 1e-4]]";
            // As if every reading took 20 ms to be taken into account.
            let newest_s = time_s.parse().unwrap_or(f64::NAN) - 0.02;
            format!(
                "{{\"time_s\": {time_s}, \"newest_s\": {newest_s}, \"mean\": {middle:?}, \"covariance\": {covariance}}}"
            )
        }
        "samples" => {
            let [x_m, y_m, heading_rad] = [middle[0], middle[1], middle[2]];
            format!("{{\"time_s\": {time_s}, \"samples\": [[{x_m}, {y_m}, {heading_rad}, 0.5], [{x_m}, 0, 0, 0]]}}")
        }
        "boxes" => format!("{{\"time_s\": {time_s}, \"boxes\": [{start}], \"status\": \"sound\"}}"),
        _ => format!("{{\"time_s\": {time_s}, \"pose\": {middle:?}}}"),
    }
}

/// Does something wrong. What ends this process or lets it hang does not return.
fn misbehave(misdeed: &str, time_s: &str) -> io::Result<()> {
    let gaussian =
        |covariance: &str| say(&format!("{{\"time_s\": {time_s}, \"mean\": [0, 0, 0], \"covariance\": {covariance}}}"));
    match misdeed {
        "exit" => exit(7),
        "abort" => std::process::abort(),
        "hang" => loop {
            thread::sleep(Duration::from_secs(1));
        },
        "garbage" => say("\u{7}what?"),
        "nan" => gaussian("[[NaN, 0, 0], [0, 1, 0], [0, 0, 1]]"),
        "lopsided" => gaussian("[[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]"),
        "negative" => gaussian("[[1, 0, 0], [0, -1, 0], [0, 0, 1]]"),
        "future" => say("{\"time_s\": 5, \"pose\": [0, 0, 0]}"),
        "past" => say("{\"time_s\": 0.01, \"pose\": [0, 0, 0]}"),
        "flood" => {
            let megabyte = vec![b'x'; 1 << 20];
            (0..10).try_for_each(|_| io::stdout().lock().write_all(&megabyte))
        }
        // Leaves a process behind that does nothing for long, names it, and then answers with garbage.
        "brood" => {
            let child = Command::new("sleep").arg("1000").spawn()?;
            eprintln!("brood {}", child.id());
            say("garbage")
        }
        other => panic!("no such misdeed: {other}"),
    }
}

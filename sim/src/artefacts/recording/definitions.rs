//! Definitions of messages of ROS 2, of Foxglove and of this project, as recordings include them.

/// Text of every message definition: blocks that begin with `MSG: package/Type`, separated by [`SEPARATOR`].
const DEFINITIONS: &str = include_str!("definitions.msg");
/// The line that ROS 2 puts between a message definition and the definitions that it refers to.
const SEPARATOR: &str = "================================================================================\n";

/// The definition of the message type `package/Type`, followed by all definitions that it refers to, each once: the content of a `ros2msg` schema.
pub(super) fn definition(name: &str) -> String {
    let mut names = vec![name.to_owned()];
    let mut text = String::new();
    let mut index = 0;
    while let Some(name) = names.get(index).cloned() {
        let block = block(&name);
        if index > 0 {
            text += &format!("{SEPARATOR}MSG: {name}\n");
        }
        text += block;
        for referred in block.lines().filter_map(referred) {
            if !names.contains(&referred) {
                names.push(referred);
            }
        }
        index += 1;
    }
    text
}

/// The lines of one message definition; empty when the name is unknown.
fn block(name: &str) -> &'static str {
    let has_name = |block: &&str| block.lines().next().and_then(|line| line.strip_prefix("MSG: ")) == Some(name);
    let block = DEFINITIONS.split(SEPARATOR).find(has_name).unwrap_or_default();
    block.split_once('\n').map_or("", |(_, fields)| fields)
}

/// Name of the message definition that a field's type refers to.
fn referred(line: &str) -> Option<String> {
    let kind = line.split_whitespace().next()?;
    (kind.contains('/') && !kind.starts_with('#')).then(|| kind.split('[').next().unwrap_or(kind).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definition_brings_along_all_that_it_refers_to() {
        for line in DEFINITIONS.lines().filter_map(|line| line.strip_prefix("MSG: ")) {
            let text = definition(line);
            for name in text.lines().filter_map(referred) {
                assert_eq!(text.matches(&format!("MSG: {name}\n")).count(), 1, "{name} in {line}");
            }
        }
    }
}

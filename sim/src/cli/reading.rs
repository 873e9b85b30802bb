//! What is shown while scenes are read.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Time between two steps of what is shown: often enough that a reader sees that the program works.
const STEP: Duration = Duration::from_millis(200);

/// Does `read` while a line on the terminal says that scenes are read, and for how long already: to lay out the markers of a large hall for the first
/// time takes many seconds. Nothing is shown when standard error is no terminal.
pub(super) fn while_reading<T>(read: impl FnOnce() -> T) -> T {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    let style =
        ProgressStyle::with_template("{spinner} reading scenes, and laying out markers where asked  {elapsed_precise}");
    // The template is fixed text; should the library refuse it, the default style serves.
    let bar = bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
    bar.enable_steady_tick(STEP);
    let done = read();
    bar.finish_and_clear();
    done
}

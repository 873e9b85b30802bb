//! The paper's own pipeline.

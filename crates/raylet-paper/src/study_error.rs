//! What ends a study early.

/// Any error that a study meets. Each says what was found and what was expected.
pub type StudyError = Box<dyn std::error::Error + Send + Sync>;

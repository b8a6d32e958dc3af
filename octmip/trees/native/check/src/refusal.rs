//! The refusal of a log.

/// The line of a log (from 1) that is refused, and the reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// Number of the line.
    pub line: usize,
    /// The reason why it is refused.
    pub reason: String,
}

/// Result of a step of checking.
pub(crate) type Checked<T> = Result<T, Refusal>;

/// Refuse a line unless something holds.
macro_rules! ensure {
    ($is_so:expr, $line:expr, $($reason:tt)*) => {
        if !$is_so { return Err($crate::refusal::Refusal { line: $line, reason: format!($($reason)*) }); }
    };
}
pub(crate) use ensure;

/// The first characters of a line, as they are shown in a reason.
pub(crate) fn shown(text: &str) -> String {
    format!("{:?}", text.chars().take(80).collect::<String>())
}

//! The date in the model description. It is the date of the sources, so that equal sources give
//! equal archives.

use crate::compile::workspace;
use std::process::{Command, Stdio};

/// `generationDateAndTime` (xs:dateTime, UTC): the time of `SOURCE_DATE_EPOCH` (seconds since
/// 1970, as defined by reproducible-builds.org), otherwise the time of the last commit if the
/// workspace is a git repository. `None` without both; the attribute is then left out.
pub fn of_sources() -> Option<String> {
    let given = std::env::var("SOURCE_DATE_EPOCH").ok();
    given.or_else(last_commit).and_then(|seconds| Some(utc(seconds.trim().parse().ok()?)))
}

/// Seconds since 1970 of the last commit.
fn last_commit() -> Option<String> {
    let mut git = Command::new("git");
    git.args(["log", "-1", "--format=%ct"]).current_dir(workspace()).stderr(Stdio::null());
    let output = git.output().ok().filter(|output| output.status.success())?;
    String::from_utf8(output.stdout).ok()
}

/// Seconds since 1970 as date and time. Years are counted from 1 March, so that a leap day is the
/// last day of a year: 400 years have 146097 days, and five months from March on have 153 days.
fn utc(seconds: u64) -> String {
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    let since_march_0 = days + 719_468;
    let (era, day) = (since_march_0 / 146_097, since_march_0 % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let of_year = day - (365 * year + year / 4 - year / 100);
    let from_march = (5 * of_year + 2) / 153;
    let (month, day) = ((from_march + 2) % 12 + 1, of_year - (153 * from_march + 2) / 5 + 1);
    let year = 400 * era + year + u64::from(month <= 2);
    let (hour, minute) = (second / 3600, second / 60 % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{:02}Z", second % 60)
}

#[cfg(test)]
mod tests {
    use super::utc;

    /// Values of `date --utc --date=@…`.
    #[test]
    fn golden_values_of_dates() {
        for (seconds, expected) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_709_251_199, "2024-02-29T23:59:59Z"),
            (1_709_251_200, "2024-03-01T00:00:00Z"),
            (4_102_444_799, "2099-12-31T23:59:59Z"),
        ] {
            assert_eq!(utc(seconds), expected);
        }
    }
}

//! `--limit`: the time and the memory after which the program stops as it does after Ctrl-C.

use std::time::Duration;

/// Enough for normal use, and a bound on what a spec from an unknown source can take.
const DEFAULT: Limit = Limit { time: Some(Duration::from_secs(24 * 3600)), memory: Some(8_000_000_000) };
/// Seconds in each unit of time.
const TIMES: &[(&str, f64)] = &[("ms", 1e-3), ("s", 1.0), ("min", 60.0), ("h", 3600.0), ("d", 86400.0)];
/// Bytes in each unit of memory.
const MEMORIES: &[(&str, f64)] = &[("MB", 1e6), ("GB", 1e9)];

/// Limits of time and memory; `None` for no limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Limit {
    /// Time since the start of the program.
    pub(crate) time: Option<Duration>,
    /// Bytes.
    pub(crate) memory: Option<u64>,
}

impl Default for Limit {
    fn default() -> Limit {
        DEFAULT
    }
}

impl Limit {
    /// No limit: for work that a user ends, not the program.
    pub(crate) const fn none() -> Limit {
        Limit { time: None, memory: None }
    }

    /// Parses `10min`, `4GB`, both separated by a comma, or `none`; a limit that is not named has its
    /// default.
    ///
    /// # Errors
    /// In words.
    pub(crate) fn parse(text: &str) -> Result<Limit, String> {
        if text.trim() == "none" {
            return Ok(Limit::none());
        }
        let (mut time, mut memory) = (None, None);
        for part in text.split(',').map(str::trim) {
            let unit = part.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
            let number = part[..part.len() - unit.len()].parse::<f64>().ok().filter(|x| *x > 0.0 && *x < 1e9);
            let factor =
                |table: &[(&str, f64)]| table.iter().find(|(name, _)| *name == unit.trim()).map(|(_, f)| *f);
            let twice = match (number, factor(TIMES), factor(MEMORIES)) {
                (Some(x), Some(seconds), _) => time.replace(Duration::from_secs_f64(x * seconds)).is_some(),
                (Some(x), _, Some(bytes)) => memory.replace((x * bytes) as u64).is_some(),
                _ => return Err(
                    "expected a time (30s, 10min, 2h), a memory (500MB, 4GB), both as in 10min,4GB, or none"
                        .into(),
                ),
            };
            if twice {
                return Err("expected one time and one memory at most, as in 10min,4GB".into());
            }
        }
        Ok(Limit { time: time.or(DEFAULT.time), memory: memory.or(DEFAULT.memory) })
    }
}

/// Resident memory of the program in bytes; `None` on systems without `/proc/self/status`.
pub(crate) fn resident_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<u64>().ok()? * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_as_people_write_them() {
        let limit = |text: &str| Limit::parse(text).expect(text);
        assert_eq!(limit("10min"), Limit { time: Some(Duration::from_secs(600)), ..DEFAULT });
        assert_eq!(limit("4 GB"), Limit { memory: Some(4_000_000_000), ..DEFAULT });
        assert_eq!(
            limit("1.5h, 500MB"),
            Limit { time: Some(Duration::from_secs(5400)), memory: Some(500_000_000) }
        );
        assert_eq!(limit("none"), Limit { time: None, memory: None });
        for wrong in [
            "",
            "10",
            "min",
            "-1s",
            "0s",
            "4TB",
            "1e3s",
            "10min;4GB",
            "10min,",
            "nan s",
            "10min,20min",
            "1GB,2h,2GB",
        ] {
            assert!(Limit::parse(wrong).is_err(), "{wrong}");
        }
    }
}

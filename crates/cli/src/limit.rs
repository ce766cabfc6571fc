//! `--limit`: how long the program may work and how much memory it may hold before it stops as Ctrl-C stops it.

use std::time::Duration;

/// What a normal user never meets, and what stops a spec from somebody else from taking a machine.
const DEFAULT: Limit = Limit { time: Some(Duration::from_secs(24 * 3600)), memory: Some(8_000_000_000) };
/// Seconds in each unit of time.
const TIMES: &[(&str, f64)] = &[("ms", 1e-3), ("s", 1.0), ("min", 60.0), ("h", 3600.0), ("d", 86400.0)];
/// Bytes in each unit of memory.
const MEMORIES: &[(&str, f64)] = &[("MB", 1e6), ("GB", 1e9)];

/// Time and memory; none: as much as there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Limit {
    /// Since the program started.
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
    /// `10min`, `4GB`, both with a comma between, or `none`; what is not named stays at its default.
    ///
    /// # Errors
    /// In words.
    pub(crate) fn parse(text: &str) -> Result<Limit, String> {
        if text.trim() == "none" {
            return Ok(Limit { time: None, memory: None });
        }
        let mut limit = DEFAULT;
        for part in text.split(',').map(str::trim) {
            let unit = part.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
            let number = part[..part.len() - unit.len()].parse::<f64>().ok().filter(|x| *x > 0.0 && *x < 1e9);
            let factor =
                |table: &[(&str, f64)]| table.iter().find(|(name, _)| *name == unit.trim()).map(|(_, f)| *f);
            match (number, factor(TIMES), factor(MEMORIES)) {
                (Some(x), Some(seconds), _) => limit.time = Some(Duration::from_secs_f64(x * seconds)),
                (Some(x), _, Some(bytes)) => limit.memory = Some((x * bytes) as u64),
                _ => return Err(
                    "expected a time (30s, 10min, 2h), a memory (500MB, 4GB), both as in 10min,4GB, or none"
                        .into(),
                ),
            }
        }
        Ok(limit)
    }
}

/// Bytes of memory that the program holds now; none where the system does not say it in a file (it does on Linux).
pub(crate) fn held() -> Option<u64> {
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
        for wrong in ["", "10", "min", "-1s", "0s", "4TB", "1e3s", "10min;4GB", "10min,", "nan s"] {
            assert!(Limit::parse(wrong).is_err(), "{wrong}");
        }
    }
}

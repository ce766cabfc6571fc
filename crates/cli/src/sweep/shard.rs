//! A part of a sweep, for one of many programs that share its work.

/// The runs whose number leaves `index` when it is divided by `count`: neighbouring seeds go to different
/// programs, so that each has its share of every cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    /// From 0.
    index: u64,
    /// How many there are.
    count: u64,
}

impl Shard {
    /// Reads `3/16`, the third of sixteen.
    ///
    /// # Errors
    /// What is expected.
    pub(crate) fn parse(text: &str) -> Result<Shard, String> {
        let number = |word: &str| word.parse::<u64>().ok();
        match text.split_once('/').and_then(|(k, n)| Some((number(k)?, number(n)?))) {
            Some((k, n)) if 1 <= k && k <= n => Ok(Shard { index: k - 1, count: n }),
            _ => Err("expected which one of how many, such as 3/16, from 1/16 to 16/16".to_owned()),
        }
    }

    /// Whether a run belongs to it, by its number among all runs of the sweep.
    pub(crate) fn holds(self, number: u64) -> bool {
        number % self.count == self.index
    }

    /// The name of its journal.
    pub(crate) fn journal(self) -> String {
        format!("sweep-{}-of-{}.jsonl", self.index + 1, self.count)
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index + 1, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_belongs_to_one_shard() {
        let all: Vec<Shard> =
            ["1/3", "2/3", "3/3"].iter().map(|s| Shard::parse(s).expect("a shard")).collect();
        for number in 0..10 {
            assert_eq!(all.iter().filter(|s| s.holds(number)).count(), 1);
        }
        assert_eq!((all[1].to_string(), all[1].journal()), ("2/3".into(), "sweep-2-of-3.jsonl".into()));
        for wrong in ["0/3", "4/3", "1", "1/0", "a/b", "-1/3", "1/3/5", ""] {
            assert!(Shard::parse(wrong).is_err(), "{wrong}");
        }
    }
}

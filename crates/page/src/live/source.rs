//! Where a growing record comes from, and its bytes as whole lines.

use serial2::SerialPort;
use std::fmt;
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::net::TcpStream;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::{Duration, Instant};

/// Rate of a serial port where nobody says one: that of most boards.
const BAUD: u32 = 115_200;
/// Longest wait for bytes: the end is asked for in between.
const PATIENCE: Duration = Duration::from_millis(100);
/// Time between two attempts to open a source that broke off.
const AGAIN: Duration = Duration::from_secs(1);
/// Longest line: what has no end is no table.
const LONGEST: usize = 1 << 16;

/// Where a growing record comes from.
///
/// ```
/// use phisindy_page::Source;
/// let port: Source = "serial:/dev/ttyUSB0@921600".parse()?;
/// assert_eq!(port.to_string(), "serial:/dev/ttyUSB0@921600");
/// assert!("tcp://no-port".parse::<Source>().is_err());
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A serial port and its baud rate: `serial:/dev/ttyUSB0`, `serial:COM3@9600`.
    Serial(String, u32),
    /// A program that listens: `tcp://HOST:PORT`.
    Tcp(String),
    /// A file that another program writes.
    File(PathBuf),
}

impl FromStr for Source {
    type Err = String;

    fn from_str(text: &str) -> Result<Source, String> {
        if let Some(port) = text.strip_prefix("serial:") {
            let (port, baud) = port.rsplit_once('@').unwrap_or((port, ""));
            let baud = if baud.is_empty() { Ok(BAUD) } else { baud.parse() };
            let baud = baud.ok().filter(|b| *b > 0).ok_or("behind @ stands the baud rate, such as 115200")?;
            return if port.is_empty() {
                Err("the port is missing: serial:/dev/ttyUSB0".into())
            } else {
                Ok(Source::Serial(port.into(), baud))
            };
        }
        if let Some(address) = text.strip_prefix("tcp://") {
            let port = address.rsplit_once(':').and_then(|(_, port)| port.parse::<u16>().ok());
            return port
                .map(|_| Source::Tcp(address.into()))
                .ok_or_else(|| "the port is missing: tcp://192.168.0.7:5000".into());
        }
        Ok(Source::File(text.into()))
    }
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Source::Serial(port, BAUD) => write!(f, "serial:{port}"),
            Source::Serial(port, baud) => write!(f, "serial:{port}@{baud}"),
            Source::Tcp(address) => write!(f, "tcp://{address}"),
            Source::File(path) => path.display().fmt(f),
        }
    }
}

impl Source {
    /// Opens it.
    ///
    /// # Errors
    /// There is none, or it may not be read; the message names it.
    pub(crate) fn open(&self) -> io::Result<Stream> {
        let opened = self
            .opened()
            .map_err(|why| io::Error::new(why.kind(), format!("cannot read `{self}`: {why}")))?;
        Ok(Stream {
            source: self.clone(),
            from: Some(opened),
            rest: vec![],
            starts: true,
            ended: false,
            tried: Instant::now(),
        })
    }

    fn opened(&self) -> io::Result<From> {
        Ok(match self {
            Source::Serial(port, baud) => {
                let mut port = SerialPort::open(port, *baud)?;
                port.set_read_timeout(PATIENCE)?;
                From::Serial(port)
            }
            Source::Tcp(address) => {
                let stream = TcpStream::connect(address)?;
                stream.set_read_timeout(Some(PATIENCE))?;
                From::Tcp(stream)
            }
            Source::File(path) => From::File(File::open(path)?),
        })
    }
}

#[derive(Debug)]
enum From {
    Serial(SerialPort),
    Tcp(TcpStream),
    File(File),
}

/// The lines of a source.
#[derive(Debug)]
pub(crate) struct Stream {
    source: Source,
    /// None while a source that broke off is away.
    from: Option<From>,
    /// What came and is not handed on.
    rest: Vec<u8>,
    /// Whether a line may have begun before the first byte of it was read.
    starts: bool,
    ended: bool,
    tried: Instant,
}

impl Stream {
    /// Whether the sender has closed the connection.
    pub(crate) fn has_ended(&self) -> bool {
        self.ended
    }

    /// Adds the whole lines that come within a moment.
    ///
    /// # Errors
    /// The source broke off. It is opened again until it is back; the line that was cut is dropped.
    pub(crate) fn lines(&mut self, to: &mut Vec<u8>) -> io::Result<()> {
        let mut piece = vec![0; LONGEST];
        let read = match &mut self.from {
            Some(From::Serial(port)) => port.read(&mut piece),
            Some(From::Tcp(stream)) => stream.read(&mut piece),
            Some(From::File(file)) => file.read(&mut piece),
            None => return self.opened_again(),
        };
        let n = match read {
            Ok(0) if matches!(self.from, Some(From::File(_))) => {
                std::thread::sleep(PATIENCE);
                0
            }
            Ok(0) if matches!(self.from, Some(From::Tcp(_))) => {
                self.ended = true;
                0
            }
            Ok(0) => return self.broke_off(&io::Error::from(ErrorKind::UnexpectedEof)),
            Ok(n) => n,
            Err(why)
                if matches!(
                    why.kind(),
                    ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
                ) =>
            {
                0
            }
            Err(why) => return self.broke_off(&why),
        };
        self.rest.extend_from_slice(&piece[..n]);
        self.handed_on(to)
    }

    /// Adds the whole lines that are there already.
    ///
    /// # Errors
    /// As of [`Stream::lines`].
    pub(crate) fn rest(&mut self, to: &mut Vec<u8>) -> io::Result<()> {
        let since = Instant::now();
        loop {
            let before = to.len() + self.rest.len();
            self.lines(to)?;
            if to.len() + self.rest.len() == before || self.ended || since.elapsed() > AGAIN {
                // Nothing will come that tells whether the first line was whole.
                self.starts = false;
                return self.handed_on(to);
            }
        }
    }

    fn handed_on(&mut self, to: &mut Vec<u8>) -> io::Result<()> {
        if self.starts && matches!(self.source, Source::Serial(..)) {
            let lines: Vec<&[u8]> = self.rest.split_inclusive(|b| *b == b'\n').collect();
            let [first, second, third, ..] = lines[..] else { return Ok(()) };
            if !third.ends_with(b"\n") {
                return Ok(());
            }
            if !begins_whole([first, second, third]) {
                self.rest.drain(..first.len());
            }
            self.starts = false;
        }
        let whole = self.rest.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
        to.extend(self.rest.drain(..whole));
        if self.rest.len() >= LONGEST {
            self.rest.clear();
            return Err(io::Error::other(format!(
                "`{}` sends no lines: is the baud rate right?",
                self.source
            )));
        }
        Ok(())
    }

    fn broke_off(&mut self, why: &io::Error) -> io::Result<()> {
        (self.from, self.starts, self.tried) = (None, true, Instant::now());
        self.rest.clear();
        Err(io::Error::other(format!(
            "`{}` broke off ({why}); it is opened again when it is back",
            self.source
        )))
    }

    fn opened_again(&mut self) -> io::Result<()> {
        std::thread::sleep(PATIENCE);
        if self.tried.elapsed() >= AGAIN {
            self.tried = Instant::now();
            self.from = self.source.opened().ok();
        }
        match self.from {
            Some(_) => Ok(()),
            None => Err(io::Error::other(format!(
                "`{}` broke off; it is opened again when it is back",
                self.source
            ))),
        }
    }
}

/// Whether the first line of a port is a whole one: who begins to listen may come in the middle of it. A heading has
/// letters. A row has as many cells as the next, and its first number, the time, is one step before that of the next.
fn begins_whole(lines: [&[u8]; 3]) -> bool {
    let [first, second, third] = lines.map(|line| String::from_utf8_lossy(line).trim().to_owned());
    if first.chars().any(|c| c.is_alphabetic() && !matches!(c, 'e' | 'E')) {
        return true;
    }
    let cells = |line: &str| line.split([',', ';', '\t', ' ']).filter(|c| !c.is_empty()).count();
    let time = |line: &str| line.split([',', ';', '\t', ' ']).next().and_then(|c| c.parse::<f64>().ok());
    let steps = match (time(&first), time(&second), time(&third)) {
        (Some(a), Some(b), Some(c)) if c > b => (b - a) > 0.0 && (b - a) <= 3.0 * (c - b),
        _ => true,
    };
    cells(&first) == cells(&second) && steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_first_line_that_was_cut_is_dropped() {
        let whole = |a: &str, b: &str, c: &str| begins_whole([a, b, c].map(|line| line.as_bytes()));
        assert!(
            whole("t_s,x_m\n", "0.0,1.0\n", "0.1,1.0\n") && whole("# a board\n", "0.0,1.0\n", "0.1,1.0\n")
        );
        assert!(whole("9.9,1\n", "10.0,1\n", "10.1,1\n") && whole("5 3\n", "7 2\n", "6 1\n"));
        assert!(!whole(".9,1\n", "10.0,1\n", "10.1,1\n") && !whole("1\n", "10.0,1\n", "10.1,1\n"));
        assert!(!whole("-3,4\n", "10.0,1\n", "10.1,1\n") && !whole("\n", "10.0,1\n", "10.1,1\n"));
    }
}

//! Where a growing record comes from, and its bytes as whole lines.

use super::row::{cells, first_number};
use phisindy::files::open_plain_file;
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
        if let Some((kind, _)) = text.split_once("://") {
            return Err(format!("`{kind}://` is not read: tcp://HOST:PORT, serial:PORT, or a file"));
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
            skips: false,
            anew: false,
            read: 0,
            ended: false,
            tried: Instant::now(),
        })
    }

    fn opened(&self) -> io::Result<From> {
        Ok(match self {
            Source::Serial(port, baud) => {
                let mut port = SerialPort::open(port, *baud)?;
                port.set_read_timeout(PATIENCE)?;
                let held = held(&port)?;
                From::Serial(port, held)
            }
            Source::Tcp(address) => {
                let stream = TcpStream::connect(address)?;
                stream.set_read_timeout(Some(PATIENCE))?;
                From::Tcp(stream)
            }
            // A pipe would be waited for.
            Source::File(path) => From::File(open_plain_file(path)?),
        })
    }
}

#[derive(Debug)]
enum From {
    /// The second one holds it: two readers would get half of the bytes each.
    Serial(SerialPort, #[expect(dead_code, reason = "held until it is dropped")] Option<File>),
    Tcp(TcpStream),
    File(File),
}

/// Holds a port until it is dropped.
///
/// # Errors
/// Another program of this kind reads it.
#[cfg(unix)]
fn held(port: &SerialPort) -> io::Result<Option<File>> {
    use std::os::fd::AsFd;
    let held = File::from(port.as_fd().try_clone_to_owned()?);
    match held.try_lock() {
        Ok(()) => Ok(Some(held)),
        Err(_) => Err(io::Error::new(ErrorKind::ResourceBusy, "another program reads it")),
    }
}

/// There the system gives a port to one program alone.
#[cfg(not(unix))]
fn held(_: &SerialPort) -> io::Result<Option<File>> {
    Ok(None)
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
    /// Whether the present line is too long to be one: it is left out.
    skips: bool,
    /// Whether it broke off and is back.
    anew: bool,
    /// Bytes of a file that were read.
    read: u64,
    ended: bool,
    tried: Instant,
}

impl Stream {
    /// Whether the sender has closed the connection.
    pub(crate) fn has_ended(&self) -> bool {
        self.ended
    }

    /// Adds the whole lines that come within a moment; whether the source broke off before and is back.
    ///
    /// # Errors
    /// The source broke off. It is opened again until it is back; the line that was cut is dropped.
    pub(crate) fn lines(&mut self, to: &mut Vec<u8>) -> io::Result<bool> {
        let mut piece = vec![0; LONGEST];
        let read = match &mut self.from {
            Some(From::Serial(port, _)) => port.read(&mut piece),
            Some(From::Tcp(stream)) => stream.read(&mut piece),
            Some(From::File(file)) => file.read(&mut piece),
            None => return self.opened_again().map(|()| false),
        };
        let n = match read {
            Ok(0) if matches!(self.from, Some(From::File(_))) => {
                if !self.is_the_same_file() {
                    return self.broke_off(&io::Error::other("another file has its name")).map(|()| false);
                }
                std::thread::sleep(PATIENCE);
                0
            }
            Ok(0) if matches!(self.from, Some(From::Tcp(_))) => {
                self.ended = true;
                0
            }
            Ok(0) => return self.broke_off(&io::Error::from(ErrorKind::UnexpectedEof)).map(|()| false),
            Ok(n) => n,
            Err(why)
                if matches!(
                    why.kind(),
                    ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
                ) =>
            {
                0
            }
            Err(why) => return self.broke_off(&why).map(|()| false),
        };
        self.read += n as u64;
        // What comes after a break is another record: it waits for the file of that.
        if self.anew && n > 0 {
            self.anew = false;
            self.rest.extend_from_slice(&piece[..n]);
            return Ok(true);
        }
        self.rest.extend_from_slice(&piece[..n]);
        self.handed_on(to).map(|()| false)
    }

    /// Whether the file still has its name, and has not become shorter.
    fn is_the_same_file(&self) -> bool {
        let (Source::File(path), Some(From::File(file))) = (&self.source, &self.from) else { return true };
        let (Ok(named), Ok(own)) = (std::fs::metadata(path), file.metadata()) else { return false };
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            if (named.dev(), named.ino()) != (own.dev(), own.ino()) {
                return false;
            }
        }
        named.len() >= self.read && own.len() >= self.read
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
        if self.skips {
            let end = self.rest.iter().position(|b| *b == b'\n').map_or(self.rest.len(), |at| at + 1);
            self.skips = self.rest.get(end.wrapping_sub(1)) != Some(&b'\n');
            self.rest.drain(..end);
        }
        if self.starts && matches!(self.source, Source::Serial(..)) && self.rest.len() < LONGEST {
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
            self.skips = true;
        }
        if self.skips {
            let hint =
                if matches!(self.source, Source::Serial(..)) { "; is the baud rate right?" } else { "" };
            let why = format!("`{}` sends no ends of lines (\\n), so nothing is kept{hint}", self.source);
            return Err(io::Error::other(why));
        }
        Ok(())
    }

    fn broke_off(&mut self, why: &io::Error) -> io::Result<()> {
        (self.from, self.starts, self.tried) = (None, true, Instant::now());
        (self.anew, self.skips, self.read) = (true, false, 0);
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
fn begins_whole([first, second, third]: [&[u8]; 3]) -> bool {
    if String::from_utf8_lossy(first).chars().any(|c| c.is_alphabetic() && !matches!(c, 'e' | 'E')) {
        return true;
    }
    let [a, b, c] = [first, second, third].map(first_number);
    // A first column that does not grow is no time.
    let steps = if c > b { b - a > 0.0 && b - a <= 3.0 * (c - b) } else { true };
    cells(first) == cells(second) && steps
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

//! Bytes taken out, doubled, turned and put in, the lines of a text in another order.

use crate::dice::Dice;

/// What breaks readers of texts and numbers.
const PIECES: &[&str] = &[
    "",
    "\0",
    "\n",
    "\r",
    "\"",
    "'",
    "(",
    ")",
    "{",
    "}",
    "[",
    "]",
    ",",
    ";",
    ":",
    ".",
    "-",
    "+",
    "1e999",
    "-1e-400",
    "NaN",
    "inf",
    "99999999999999999999",
    "0",
    "/*",
    "*/",
    "//",
    "\u{feff}",
    "é",
    "\u{202e}",
    "=",
    "0x7f",
    "^",
    "|",
    "sgn(",
    "Find(",
    "Csv(",
    "\t",
    "null",
];

/// One to four damages.
pub(super) fn damaged(bytes: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for _ in 0..dice.whole(1, 4) {
        let (a, b) = (dice.whole(0, out.len()), dice.whole(0, out.len()));
        // Most damages are small.
        let (from, to) =
            if dice.chance(0.2) { (a.min(b), a.max(b)) } else { (a, (a + dice.whole(0, 12)).min(out.len())) };
        match dice.whole(0, 5) {
            0 => drop(out.drain(from..to)),
            1 => {
                let piece = out[from..to].to_vec();
                out.splice(b..b, piece);
            }
            2 => out.truncate(a),
            3 if a < out.len() => out[a] ^= 1 << dice.whole(0, 7),
            4 => {
                let mut lines: Vec<Vec<u8>> = out.split(|&b| b == b'\n').map(<[u8]>::to_vec).collect();
                let (i, j) = (dice.whole(0, lines.len() - 1), dice.whole(0, lines.len() - 1));
                lines.swap(i, j);
                out = lines.join(&b'\n');
            }
            _ => drop(out.splice(from..to, dice.pick(PIECES).bytes())),
        }
        // A text that doubles each time is no damage but a flood.
        out.truncate(1 << 20);
    }
    out
}

//! `phisindy fmt` changes white space and the comma in front of a closing bracket, and nothing else; and it has nothing to
//! say to what it wrote.

use phisindy_phys::{Diagnostic, Law, SourceId, format, spec};
use proptest::prelude::*;
use std::path::{Path, PathBuf};

/// All specs and laws of the project that are RON, wrong ones too.
fn texts() -> Vec<(PathBuf, String)> {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folders =
        ["specs", "specs/laws", "specs/wrong", "specs/wrong/law", "docs/guides", "crates/phys/tests/spec"];
    let folders = folders.iter().map(|folder| top.join(folder));
    let files =
        folders.flat_map(|f| std::fs::read_dir(f).expect("a folder").map(|e| e.expect("an entry").path()));
    let mut files: Vec<PathBuf> = files.filter(|p| p.extension().is_some_and(|e| e == "ron")).collect();
    files.push(top.join("crates/cli/src/commands/law_template.ron"));
    files.sort();
    let read = |path: PathBuf| std::fs::read_to_string(&path).map(|text| (path, text));
    files.into_iter().map(|path| read(path).expect("a text")).collect()
}

/// What a text is made of, and whether that is a comment.
fn lexemes(text: &str) -> Vec<(bool, &str)> {
    let mut all = Vec::new();
    let mut rest = text;
    while let Some(first) = {
        rest = rest.trim_start();
        rest.chars().next()
    } {
        let hashes = rest[1..].bytes().take_while(|b| *b == b'#').count();
        let raw = first == 'r' && rest[1 + hashes..].starts_with('"');
        let (comment, length) = if rest.starts_with("//") {
            (true, rest.find('\n').unwrap_or(rest.len()))
        } else if rest.starts_with("/*") {
            let (mut depth, mut at) = (1, 2);
            while depth > 0 {
                let here = &rest[at..];
                depth += i32::from(here.starts_with("/*")) - i32::from(here.starts_with("*/"));
                at += if here.starts_with("/*") || here.starts_with("*/") {
                    2
                } else {
                    here.chars().next().expect("an end").len_utf8()
                };
            }
            (true, at)
        } else if raw {
            let end = format!("\"{}", "#".repeat(hashes));
            let open = hashes + 2;
            (false, open + rest[open..].find(&end).expect("an end") + end.len())
        } else if first == '"' || first == '\'' {
            let mut escaped = false;
            let ends = |c: char| {
                let end = c == first && !escaped;
                escaped = c == '\\' && !escaped;
                end
            };
            (false, 2 + rest[1..].find(ends).expect("an end"))
        } else if "()[]{},:".contains(first) {
            (false, 1)
        } else {
            let ends = |c: char| c.is_whitespace() || "()[]{},:\"/".contains(c);
            (false, rest.find(ends).unwrap_or(rest.len()).max(1))
        };
        all.push((comment, rest[..length].trim_end()));
        rest = &rest[length..];
    }
    all
}

/// The lexemes of one kind; commas in front of closing brackets say nothing.
fn of(kind: bool, text: &str) -> Vec<String> {
    let all: Vec<&str> =
        lexemes(text).into_iter().filter(|(comment, _)| *comment == kind).map(|(_, t)| t).collect();
    let says =
        |k: &usize| !(all[*k] == "," && all.get(k + 1).is_some_and(|next| [")", "]", "}"].contains(next)));
    (0..all.len()).filter(says).map(|k| all[k].to_owned()).collect()
}

/// The text as `fmt` writes it, after a look at all that it promises; none of a text that is no RON.
fn formatted(text: &str) -> Option<String> {
    let out = format(text, SourceId(0)).ok()?;
    assert_eq!(of(true, text), of(true, &out), "comments of\n{text}\nbecame\n{out}");
    assert_eq!(of(false, text), of(false, &out), "\n{text}\nbecame\n{out}");
    let value = |text: &str| ron::from_str::<ron::Value>(text).map(|v| format!("{v:?}")).map_err(|e| e.code);
    assert_eq!(value(text), value(&out), "{text}");
    let again = format(&out, SourceId(0)).expect("RON");
    let differ = out.lines().zip(again.lines()).position(|(a, b)| a != b).unwrap_or(0);
    let about =
        |text: &str| text.lines().skip(differ.saturating_sub(2)).take(5).collect::<Vec<_>>().join("\n");
    assert!(again == out, "what it wrote\n{}\nis written otherwise\n{}", about(&out), about(&again));
    assert!(!out.lines().any(|l| l.ends_with(' ')) || text.lines().any(|l| l.ends_with(' ')), "{out}");
    Some(out)
}

#[test]
fn all_specs_and_laws_keep_their_meaning_and_comments() {
    let mut seen = 0;
    for (path, text) in texts() {
        let Some(out) = formatted(&text) else { continue };
        seen += 1;
        // What is told, without advice: that on `801,5` sees that no space is behind the comma.
        let plain = |found: Vec<Diagnostic>| found.into_iter().map(|d| d.message).collect::<Vec<_>>();
        let read = |text: &str| spec::read(text, SourceId(0)).map(|_| ()).map_err(plain);
        let law = |text: &str| Law::checked(text, SourceId(0)).map(|_| ()).map_err(plain);
        assert_eq!((read(&text), law(&text)), (read(&out), law(&out)), "{}", path.display());
    }
    assert!(seen > 130, "{seen}");
}

#[test]
fn odd_spellings_stay() {
    let odd = [
        "#![enable(implicit_some)]\n#![enable(unwrap_newtypes)] // both\n(a:1,)",
        "(title:\"a \\\"quoted\\\" one // no comment\",b:r#\"/* \"( */\"#,c:'\\'',d:',')",
        "(a:[1,2,],b:X(3,),c:Some(None),d:{},e:(),f:[/* nothing */],)// end\n",
        "(a: \"two\nlines\", b: { \"k\": [1, /* a\n b */ 2] })",
        "[1\n//c\n, /*d*/ 2 // e\n , // f\n 3]",
        "{ // why\n\n\n \"x\" /* b */ : /* c */ -1e-3, }",
        "\r\n\r\n(a: 1, // one\r\n\r\n\r\n b: 2)\r\n// end",
        "()",
    ];
    for text in odd {
        assert!(formatted(text).is_some(), "{text}");
    }
    let aligned = "(\n    a: 1,       // one\n    long: 2.50, // two\n)\n";
    assert_eq!(formatted(aligned).as_deref(), Some(aligned));
    let dos = formatted("(\r\n a: 1, b: 2)").expect("RON");
    assert_eq!(dos, "(\r\n    a: 1,\r\n    b: 2,\r\n)\r\n");
    assert!(format("(a: 1 b: 2)", SourceId(0)).is_err() && format("", SourceId(0)).is_err());
}

/// White space and comments of all kinds.
const BETWEEN: &[&str] = &[
    " ",
    "",
    "\n",
    "\n\n\n",
    "\r\n",
    "\t",
    "   ",
    " /* a */ ",
    "/* b\n  c */",
    " // d\n",
    "\n// e (\n",
    "\n  // \" f\n\n",
    "   // g\r\n",
];

/// The text with other white space and more comments.
fn spread(text: &str, choices: &[usize]) -> String {
    let mut choices = choices.iter().cycle();
    let mut out = String::new();
    for (comment, word) in lexemes(text) {
        let ends = |c: char| c.is_alphanumeric() || "_.+-#\"!'".contains(c);
        // Two words, or a word and a text, would be one.
        let joins = out.ends_with(ends) && word.starts_with(ends);
        let between = BETWEEN[choices.next().expect("a choice") % BETWEEN.len()];
        out += if between.is_empty() && joins { " " } else { between };
        out += word;
        out += if comment && word.starts_with("//") { "\n" } else { "" };
    }
    out + BETWEEN[choices.next().expect("a choice") % BETWEEN.len()]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn white_space_and_comments_of_any_kind_are_put_in_order(which in 0_usize..1000, choices in proptest::collection::vec(0_usize..50, 40..400)) {
        let all = texts();
        let (path, text) = &all[which % all.len()];
        let text = spread(text, &choices);
        if ron::from_str::<ron::Value>(&text).is_ok() {
            prop_assert!(formatted(&text).is_some(), "{}", path.display());
        }
    }
}

/// Two comments behind the last entry stand apart at once, and a text that would be too long to be read stays as it is.
#[test]
fn comments_stand_apart_and_what_grows_too_long_is_refused() {
    let text = "(a: { \"x\": \"y\", /*x*//*y*/ }, b: 1)";
    let once = format(text, SourceId(0)).expect("RON");
    assert!(once.contains("/*x*/ /*y*/"), "{once}");
    assert_eq!(format(&once, SourceId(0)).expect("RON"), once);
    let deep = std::format!("{}1,\n{}", "[".repeat(62), "]".repeat(62));
    let long = format(&std::format!("[{}]", vec![deep; 600].join(",")), SourceId(0));
    assert!(long.is_err_and(|mistake| mistake.message.contains("longer than 1 MiB")));
}

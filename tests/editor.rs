//! A scripted session of an editor with `phisindy lsp`, and the schema of `phisindy schema`.

#![allow(missing_docs)]

use crate::common::{Scratch, files, phisindy, program, top};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Stdio};

/// An editor that talks to the program.
struct Editor {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    requests: i32,
}

impl Editor {
    fn start() -> Editor {
        let mut child =
            program(&["lsp"]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("it starts");
        let (to, from) = (child.stdin.take().expect("a pipe"), child.stdout.take().expect("a pipe"));
        let mut editor = Editor { child, to, from: BufReader::new(from), requests: 0 };
        let able = editor.ask("initialize", json!({ "capabilities": {} }))["capabilities"].clone();
        assert_eq!(able["hoverProvider"], true, "{able}");
        editor.tell("initialized", json!({}));
        editor
    }

    fn send(&mut self, message: &Value) {
        let text = message.to_string();
        write!(self.to, "Content-Length: {}\r\n\r\n{text}", text.len()).expect("it listens");
        self.to.flush().expect("it listens");
    }

    fn tell(&mut self, method: &str, params: Value) {
        self.send(&json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    fn next(&mut self) -> Value {
        let mut length = 0;
        loop {
            let mut line = String::new();
            assert!(self.from.read_line(&mut line).expect("it speaks") > 0, "it has ended");
            match line.trim().split_once(": ") {
                Some(("Content-Length", value)) => length = value.parse().expect("a number"),
                Some(_) => {}
                None => break,
            }
        }
        let mut text = vec![0; length];
        self.from.read_exact(&mut text).expect("a message");
        serde_json::from_slice(&text).expect("JSON")
    }

    /// The answer to a request; what is published before it is passed over.
    fn ask(&mut self, method: &str, params: Value) -> Value {
        self.requests += 1;
        let id = self.requests;
        self.send(&json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": params }));
        loop {
            let message = self.next();
            if message["id"] == id {
                assert!(message["error"].is_null(), "{method}: {message}");
                return message["result"].clone();
            }
        }
    }

    fn open(&mut self, file: &File) -> Vec<Value> {
        let document = json!({ "uri": file.uri, "languageId": "phisindy", "version": 1, "text": file.text });
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
        self.published()
    }

    fn published(&mut self) -> Vec<Value> {
        loop {
            let message = self.next();
            if message["method"] == "textDocument/publishDiagnostics" {
                return message["params"]["diagnostics"].as_array().expect("a list").clone();
            }
        }
    }

    /// What can stand where this text ends in the file.
    fn completions(&mut self, file: &File, before: &str) -> Vec<Value> {
        let all = self.ask("textDocument/completion", file.at(before, before.len()));
        all.as_array().expect("a list").clone()
    }

    fn hover(&mut self, file: &File, word: &str) -> String {
        let said = self.ask("textDocument/hover", file.at(word, 0));
        said["contents"]["value"].as_str().unwrap_or_else(|| panic!("nothing of {word}: {said}")).to_owned()
    }

    fn end(mut self) {
        self.ask("shutdown", Value::Null);
        self.tell("exit", Value::Null);
        assert!(self.child.wait().expect("it ends").success());
    }
}

/// A text in an editor.
struct File {
    uri: String,
    text: String,
}

impl File {
    fn new(path: &str, text: &str) -> File {
        File { uri: format!("file://{path}"), text: text.to_owned() }
    }

    /// The position of a byte of the first place of a text, in units of UTF-16.
    fn position(&self, word: &str, more: usize) -> Value {
        let at = self.text.find(word).unwrap_or_else(|| panic!("no {word} in {}", self.text)) + more;
        let before = &self.text[..at];
        let line = before.rfind('\n').map_or(0, |end| end + 1);
        json!({ "line": before.matches('\n').count(), "character": before[line..].encode_utf16().count() })
    }

    fn at(&self, word: &str, more: usize) -> Value {
        json!({ "textDocument": { "uri": self.uri }, "position": self.position(word, more) })
    }
}

const RIG: &str = r#"// Eine Kiste rutscht.
(
    constants: { "m": (2.0, "kg"), "k": 4.0, "µ": (0.1, ""), "g": (9.81, "m/s^2") },
    states: { "x": "m", "v": "m/s" },
    known: { "x": "v", "v": "-k*x/m - µ*g*sgn(w)" },
    contacts: ["v"],
    data: [Csv(path: "none.csv", time: ("t", "ms"), columns: { "x": "x" })],
)
"#;

fn labels(items: &[Value]) -> Vec<&str> {
    items.iter().map(|item| item["label"].as_str().expect("a label")).collect()
}

#[test]
fn an_editor_is_told_of_mistakes_names_and_units() {
    let scratch = Scratch::new("editor");
    let mut editor = Editor::start();
    let mut file = File::new(&scratch.path("rig.ron"), RIG);
    // A misspelt name: its place, and what to do.
    let found = editor.open(&file);
    assert_eq!(found.len(), 1, "{found:?}");
    let range = json!({ "start": file.position("w)", 0), "end": file.position("w)", 1) });
    assert_eq!((&found[0]["range"], &found[0]["severity"]), (&range, &json!(1)), "{found:?}");
    let said = found[0]["message"].as_str().expect("words");
    assert!(said.contains("unknown name `w`") && said.contains("help: "), "{said}");
    // Without it the data file that is not there is told of, as `check` does.
    file.text = RIG.replace("sgn(w)", "sgn(v)");
    let changed = |file: &File| json!({ "textDocument": { "uri": file.uri, "version": 2 }, "contentChanges": [{ "text": file.text }] });
    editor.tell("textDocument/didChange", changed(&file));
    let found = editor.published();
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(
        (&found[0]["severity"], &found[0]["range"]["start"]),
        (&json!(2), &file.position("none.csv", 0))
    );
    // Units: what is written, what follows, what it is in SI.
    assert_eq!(editor.hover(&file, "v\", \"v\": \"-k"), "**v**: state, m/s");
    assert_eq!(editor.hover(&file, "k*x"), "**k**: constant, N/m (that follows from the equations)");
    assert_eq!(editor.hover(&file, "µ*g"), "**µ**: constant, 1 (that follows from the equations)");
    assert_eq!(editor.hover(&file, "sgn("), "**sgn(x)**: -1, 0 or 1 with the sign of x");
    assert_eq!(editor.hover(&file, "ms\""), "**ms**: 0.001 s");
    assert!(editor.hover(&file, "contacts").starts_with("**contacts** of the spec: velocities"));
    assert!(editor.hover(&file, "columns").starts_with("**columns** of `Csv`: map of states"));
    // Half typed: fields that are not there yet, names in expressions, units, words, laws.
    file.text = RIG.replace("    contacts", "    unk\n    contacts");
    editor.tell("textDocument/didChange", changed(&file));
    let fields = editor.completions(&file, "unk");
    let unknown = fields.iter().find(|f| f["label"] == "unknown").expect("a field");
    assert_eq!(
        (&unknown["textEdit"]["newText"], &unknown["textEdit"]["range"]["start"]),
        (&json!("unknown: "), &file.position("unk", 0))
    );
    assert!(
        unknown["documentation"]["value"]
            .as_str()
            .is_some_and(|about| about.contains("If absent: nothing is missing"))
    );
    assert!(!labels(&fields).contains(&"states"), "{:?}", labels(&fields));
    let names = editor.completions(&file, "-k*x/m - ");
    assert_eq!(labels(&names)[..6], ["m", "k", "µ", "g", "x", "v"]);
    assert!(labels(&names).contains(&"tanh") && names[0]["detail"] == "constant, kg", "{}", names[0]);
    assert!(labels(&editor.completions(&file, "\"ms")).contains(&"rpm"));
    for (typed, before, due) in [
        ("role: ", "role: ", "Validate"),
        ("sensors: { \"", "sensors: { \"", "v"),
        ("detrend: { \"x\": Me", ": Me", "Mean"),
        ("noise", "noise", "missing"),
    ] {
        file.text = RIG.replace("{ \"x\": \"x\" })", &format!("{{ \"x\": \"x\" }}, {typed})"));
        editor.tell("textDocument/didChange", changed(&file));
        let found = editor.completions(&file, before);
        assert!(labels(&found).contains(&due), "{typed}: {:?}", labels(&found));
    }
    file.text = RIG.replace("    contacts", "    unknown: { \"v\": (laws: [\"str\"]) },\n    contacts");
    editor.tell("textDocument/didChange", changed(&file));
    let laws = editor.completions(&file, "[\"str");
    let stribeck = laws.iter().find(|law| law["label"] == "stribeck").expect("the law");
    assert!(
        stribeck["documentation"]["value"]
            .as_str()
            .is_some_and(|about| about.starts_with("Stribeck friction."))
    );
    assert_eq!(stribeck["textEdit"]["newText"], "stribeck");
    assert_eq!(editor.completions(&file, "Kiste "), Vec::<Value>::new());
    // Symbols: fields, and the names in them.
    let symbols = editor.ask("textDocument/documentSymbol", json!({ "textDocument": { "uri": file.uri } }));
    assert_eq!(
        (&symbols[0]["name"], &symbols[0]["children"][1]["name"]),
        (&json!("constants"), &json!("k")),
        "{symbols}"
    );
    editor.end();
}

#[test]
fn an_editor_formats_and_knows_laws() {
    let mut editor = Editor::start();
    let scratch = Scratch::new("editor-law");
    let law = r#"(name: "Drag", roles: {"v": "m/s"}, parameters: { "d": (unit: "N*s/m", within: (0.0, 9.0)) }, force: "d*v*abs(v)", simpler: ["none"])"#;
    let mut file = File::new(&scratch.path("a law.ron").replace(' ', "%20"), law);
    let found = editor.open(&file);
    assert_eq!((found.len(), &found[0]["range"]["start"]), (1, &file.position("d*v*abs(v)", 0)), "{found:?}");
    assert_eq!(editor.hover(&file, "d*v"), "**d**: parameter: a number to be found, N*s/m");
    let edits = editor.ask(
        "textDocument/formatting",
        json!({ "textDocument": { "uri": file.uri }, "options": { "tabSize": 2, "insertSpaces": true } }),
    );
    let new = edits[0]["newText"].as_str().expect("an edit");
    assert!(new.starts_with("(\n    name: \"Drag\",\n    roles: { \"v\": \"m/s\" },\n"), "{new}");
    assert_eq!(
        edits[0]["range"],
        json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 0, "character": law.len() } })
    );
    // What is no law of the catalogue is told once the law is one.
    file.text = law.replace("N*s/m", "N*s^2/m^2");
    editor.tell("textDocument/didChange", json!({ "textDocument": { "uri": file.uri, "version": 2 }, "contentChanges": [{ "text": file.text }] }));
    let found = editor.published();
    assert!(found[0]["message"].as_str().is_some_and(|m| m.contains("there is no law `none`")), "{found:?}");
    // A file that is closed has no mistakes any more.
    editor.tell("textDocument/didClose", json!({ "textDocument": { "uri": file.uri } }));
    assert!(editor.published().is_empty());
    editor.end();
}

/// Each spec cut at many places, each law at all: every question has an answer.
#[test]
fn half_typed_texts_have_answers() {
    use phisindy_editor::{Document, Known, complete, hover};
    let texts = files("specs", "ron").into_iter().chain(files("specs/laws", "ron"));
    for (n, name) in texts.enumerate() {
        let text = std::fs::read_to_string(top().join(&name)).expect("a text");
        let step = if name.contains("laws") { 1 } else { 5 };
        for at in (n % step..=text.len()).step_by(step).filter(|at| text.is_char_boundary(*at)) {
            // Cut off there, and with the rest in other lines.
            for half in [
                text[..at].to_owned(),
                format!(
                    "{}\n{}",
                    &text[..at],
                    &text[(at + 20).min(text.len())..].trim_start_matches(|c: char| !c.is_ascii())
                ),
            ] {
                let document = Document::new(&half, Path::new("rig.ron"));
                let _ = (complete(&document, &Known::default(), at), hover(&document, &Known::default(), at));
                let _ = document.declared();
            }
        }
    }
}

/// A value of RON as JSON, as the schema says: tuples are arrays, `Name(...)` is an object with one field.
fn as_json(text: &str, node: &phisindy_phys::outline::Node) -> Value {
    use phisindy_phys::outline::Shape;
    let slice = &text[node.span.range()];
    let entries = || -> Value {
        let keyed = node.entries.iter().any(|e| e.key.is_some()) || node.shape == Shape::Map;
        let key = |e: &phisindy_phys::outline::Entry| {
            let key = &text[e.key.as_ref().expect("a key").span.range()];
            key.trim_matches('"').to_owned()
        };
        match keyed {
            true => Value::Object(node.entries.iter().map(|e| (key(e), as_json(text, &e.value))).collect()),
            false if node.shape == Shape::Group && node.entries.is_empty() => json!({}),
            false => node.entries.iter().map(|e| as_json(text, &e.value)).collect(),
        }
    };
    match node.shape {
        Shape::Number => ron::from_str::<f64>(slice)
            .map_or(Value::Null, |x| if slice.contains(['.', 'e']) { json!(x) } else { json!(x as i64) }),
        Shape::Text => json!(ron::from_str::<String>(slice).expect("a text")),
        Shape::Char => json!(ron::from_str::<char>(slice).expect("a character")),
        Shape::Name => serde_json::from_str(slice).unwrap_or_else(|_| json!(slice)),
        _ => match (node.name, entries()) {
            (None, inside) => inside,
            (Some(name), Value::Array(parts)) if parts.len() == 1 => json!({ &text[name.range()]: parts[0] }),
            (Some(name), inside) => json!({ &text[name.range()]: inside }),
        },
    }
}

/// Whether a value fits a schema, of which it knows the words that ours have.
fn fits(value: &Value, schema: &Value, all: &Value) -> Result<(), String> {
    let told = |what: &str| Err(format!("{what}: {value} and {schema}"));
    if let Some(place) = schema["$ref"].as_str() {
        return fits(value, all.pointer(&place[1..]).expect("a definition"), all);
    }
    for (key, rule) in schema.as_object().expect("a schema") {
        let list = || rule.as_array().expect("a list");
        let good = match key.as_str() {
            "type" => match rule.as_str().expect("a type") {
                "object" => value.is_object(),
                "array" => value.is_array(),
                "string" => value.is_string(),
                "boolean" => value.is_boolean(),
                "integer" => value.is_i64(),
                "number" => value.is_number(),
                other => panic!("{other}"),
            },
            "const" => value == rule,
            "anyOf" => list().iter().any(|one| fits(value, one, all).is_ok()),
            "allOf" => list().iter().all(|one| fits(value, one, all).is_ok()),
            "required" => list().iter().all(|name| value.get(name.as_str().expect("a name")).is_some()),
            "prefixItems" => {
                value.as_array().is_some_and(|v| v.iter().zip(list()).all(|(v, s)| fits(v, s, all).is_ok()))
            }
            "items" if rule == false => {
                value.as_array().map(Vec::len) == schema["prefixItems"].as_array().map(Vec::len)
            }
            "items" => value.as_array().is_some_and(|v| v.iter().all(|v| fits(v, rule, all).is_ok())),
            "properties" => {
                for (name, inner) in value.as_object().into_iter().flatten() {
                    match (rule.get(name), &schema["additionalProperties"]) {
                        (Some(rule), _) => fits(inner, rule, all)?,
                        (None, Value::Object(_)) => fits(inner, &schema["additionalProperties"], all)?,
                        (None, _) => return told(name),
                    }
                }
                true
            }
            "additionalProperties" if rule.is_object() && schema.get("properties").is_none() => {
                value.as_object().is_some_and(|v| v.values().all(|v| fits(v, rule, all).is_ok()))
            }
            "additionalProperties" | "description" | "minimum" | "minLength" | "maxLength" | "minItems" => {
                true
            }
            other => panic!("{other}"),
        };
        if !good {
            return told(key);
        }
    }
    Ok(())
}

#[test]
fn all_specs_and_laws_fit_the_schema_and_mistakes_do_not() {
    let schema = |of: &[&str]| -> Value {
        let said = phisindy(&[&["schema"], of].concat());
        assert_eq!(said.code, 0, "{}", said.err);
        serde_json::from_str(&said.out).expect("JSON")
    };
    let (spec, law) = (schema(&[]), schema(&["law"]));
    let against = |name: &str, schema: &Value| {
        let text = std::fs::read_to_string(top().join(name)).expect("a text");
        let text = text.replace("#![enable(implicit_some)]", "");
        fits(
            &as_json(&text, &phisindy_phys::outline::read(&text)),
            &json!({ "$ref": schema["$ref"] }),
            schema,
        )
    };
    for name in files("specs", "ron").iter().chain(&["docs/guides/accelerometer.ron".to_owned()]) {
        against(name, &spec).unwrap_or_else(|why| panic!("{name}: {why}"));
    }
    for name in files("specs/laws", "ron") {
        against(&name, &law).unwrap_or_else(|why| panic!("{name}: {why}"));
    }
    for name in ["unknown_field", "unknown_learn_field", "unknown_variant", "wrong_type"] {
        assert!(against(&format!("specs/wrong/{name}.ron"), &spec).is_err(), "{name}");
    }
}

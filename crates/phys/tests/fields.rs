//! The table of fields is what the reader takes: each field in each of its forms.

use phisindy_phys::fields::{Absent, Field, Form, Group, LAW, SPEC};
use phisindy_phys::{Diagnostic, Files, Law, Numbers, SourceId, named_files, outline, spec};

/// A text of each form that may stand somewhere, the plainest first. `k` is the place in a tuple: bounds go up.
fn samples(form: &Form, k: usize) -> Vec<String> {
    let quoted = |text: &str| vec![format!("\"{text}\"")];
    let first = |form: &Form| samples(form, 0).remove(0);
    match form {
        Form::Number => vec![format!("{}.5", k + 1)],
        Form::Whole => vec!["3".to_owned()],
        Form::Truth => vec!["true".to_owned()],
        Form::Character => vec!["';'".to_owned()],
        Form::Expression => quoted("1"),
        Form::Unit => quoted("m"),
        Form::File => quoted("a.csv"),
        Form::Prose | Form::Header | Form::LawId | Form::Free | Form::Declares(_) | Form::Name(_) => {
            quoted("x")
        }
        Form::Word(word) => vec![(*word).to_owned()],
        Form::Quoted(word) => quoted(word),
        Form::Group(group) => groups(group),
        Form::Tuple(parts) => {
            let parts = parts.iter().enumerate().map(|(k, form)| samples(form, k).remove(0));
            vec![format!("({})", parts.collect::<Vec<_>>().join(", "))]
        }
        Form::Call(name, parts) => {
            let rest: String = parts[1..].iter().map(|form| format!(", {}", first(form))).collect();
            samples(&parts[0], 0).into_iter().map(|part| format!("{name}({part}{rest})")).collect()
        }
        Form::List(item) => samples(item, 0).into_iter().map(|item| format!("[{item}]")).collect(),
        Form::Map(key, value) => {
            samples(value, 0).into_iter().map(|value| format!("{{ {}: {value} }}", first(key))).collect()
        }
        Form::Mixed(group, key, value) => {
            let fields = group.fields.iter().map(|field| format!("{}: {}", field.0, first(field.form())));
            vec![format!("{{ {}: {}, {} }}", first(key), first(value), fields.collect::<Vec<_>>().join(", "))]
        }
        Form::One(forms) => forms.iter().flat_map(|form| samples(form, k)).collect(),
    }
}

/// What must be there, and each field in each of its forms.
fn groups(group: &Group) -> Vec<String> {
    let written = |field: &Field, value: &str| format!("{}: {value}", field.0);
    let needed = |field: &&Field| !matches!(field.3, Absent::Is(_));
    let needed: Vec<&Field> = group.fields.iter().filter(needed).collect();
    let with = |one: Option<(&Field, String)>| {
        let others = needed.iter().filter(|field| one.as_ref().is_none_or(|(own, _)| own.0 != field.0));
        let mut all: Vec<String> = others.map(|field| written(field, &samples(field.form(), 0)[0])).collect();
        all.extend(one.map(|(field, value)| written(field, &value)));
        format!("{}({})", group.variant.unwrap_or(""), all.join(", "))
    };
    let each =
        group.fields.iter().flat_map(|field| samples(field.form(), 0).into_iter().map(move |v| (field, v)));
    std::iter::once(with(None)).chain(each.map(|one| with(Some(one)))).collect()
}

/// Whether something is not taken that the table has.
fn refused(found: &[Diagnostic]) -> Option<&Diagnostic> {
    found.iter().find(|d| {
        let words = ["expected ", "unknown field", "unknown kind", "` takes ", "is missing"];
        words.iter().any(|word| d.message.contains(word)) || d.message.starts_with("unknown role")
    })
}

#[test]
fn the_reader_takes_each_field_in_each_of_its_forms() {
    let (specs, laws) = (groups(&SPEC), groups(&LAW));
    assert!(specs.len() > 500 && laws.len() > 30, "{} {}", specs.len(), laws.len());
    for text in specs {
        // Every file that it names holds a matrix.
        let matrix = Numbers {
            columns: 3,
            values: vec![2.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 4.0],
            headings: vec![],
        };
        let files: Files = named_files(&text).into_iter().map(|file| (file, matrix.clone())).collect();
        let found = spec::read_with_files(&text, SourceId(0), &files)
            .map_or_else(|found| found, |(_, warnings)| warnings);
        assert!(refused(&found).is_none(), "{text}\n{:?}", refused(&found));
    }
    for text in laws {
        let found = Law::checked(&text, SourceId(0)).err().unwrap_or_default();
        assert!(refused(&found).is_none(), "{text}\n{:?}", refused(&found));
    }
}

#[test]
fn the_outline_of_a_cut_text_has_its_places() {
    let text = include_str!("spec/case7.ron");
    let whole = outline::read(text);
    assert_eq!(whole.entries.len(), 9);
    for at in (0..text.len()).filter(|at| text.is_char_boundary(*at)) {
        let mut nodes = vec![outline::read(&text[..at])];
        while let Some(node) = nodes.pop() {
            assert!(
                node.span.start <= node.span.end
                    && node.span.end <= at
                    && text.get(node.span.range()).is_some()
            );
            nodes.extend(node.entries.into_iter().flat_map(|e| [Some(e.value), e.key]).flatten());
        }
    }
}

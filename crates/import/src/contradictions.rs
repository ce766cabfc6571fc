//! Contradictions between headings and the spec: another unit (`x_mm` read in m), or swapped columns.

use crate::headings::{COUNT, Heading};
use phisindy_phys::spec::{ColumnSpec, CsvSpec, Text};
use phisindy_phys::unit::Unit;
use phisindy_phys::{Diagnostic, SourceId};

/// A column as the spec states it.
pub(crate) struct StatedColumn<'a> {
    /// The state or input; `None` for the time.
    pub(crate) name: Option<&'a Text>,
    pub(crate) column: &'a ColumnSpec,
    pub(crate) unit: Unit,
}

/// Warns if the heading states another unit. `row` is the cell of a second heading line that holds units.
pub(crate) fn unit_contradiction(
    stated_column: &StatedColumn<'_>,
    heading: &str,
    row: Option<&str>,
    spec: SourceId,
) -> Option<Diagnostic> {
    let StatedColumn { name, column, unit } = stated_column;
    let parsed = Heading::parse(heading);
    let parsed = if let Some(row) = row { parsed.with_unit(row) } else { parsed };
    let said = parsed.unit?;
    let theirs = Unit::parse(&said).ok()?;
    let stated = column.unit.as_ref().map(|u| u.value.as_str());
    // A spec that states no unit is not checked.
    if stated == Some("") || (stated.is_none() && name.is_some() && *unit == Unit::ONE) {
        return None;
    }
    let what = name.map_or("time", |n| n.value.as_str());
    let read = stated.map_or_else(|| format!("the unit of `{what}`"), str::to_owned);
    let at = column.unit.as_ref().unwrap_or(&column.header).span;
    let warning = |message: String, help: String| {
        Diagnostic::warning(message).at(spec, at, format!("read in {read}")).help(help)
    };
    let counts = said.strip_prefix(COUNT).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'));
    if theirs.dimension != unit.dimension && !counts {
        // A single letter may belong to the name: `F_N` may be a normal force, `v_s` a sliding velocity.
        let letter = said.len() == 1 && heading.ends_with(&format!("_{said}"));
        let message =
            format!("the heading `{heading}` says {said}, but the spec reads it as `{what}` in {read}");
        let help =
            format!("is `{heading}` the column that is `{what}`? if it is, write it with a unit of its kind");
        return (!letter).then(|| warning(message, help));
    }
    if counts {
        // `rev/4096` says what a count is.
        let told = stated.is_none_or(|s| s == said || s.contains(|c: char| c.is_ascii_digit()));
        let message =
            format!("the heading `{heading}` says counts, but the spec reads it as `{what}` in {read}");
        let help = "say what a count is, as in (\"HEADING\", \"rev/4096\") for 4096 counts a turn".to_owned();
        return (!told).then(|| warning(message, help));
    }
    let factor = unit.factor / theirs.factor;
    let message = format!(
        "the heading `{heading}` says {said}, but the spec reads it in {read}: {} as much",
        times(factor)
    );
    let help = format!(
        "write (\"{heading}\", \"{said}\") if the heading is right, or rename the column if the spec is"
    );
    ((factor - 1.0).abs() > 1e-9).then(|| warning(message, help))
}

/// Warns if the headings of two columns are the names of each other.
pub(crate) fn swapped_columns(csv: &CsvSpec, spec: SourceId) -> Option<Diagnostic> {
    let called = |c: &ColumnSpec, name: &Text| {
        let heading = c.header.value.as_str();
        heading == name.value || Heading::parse(heading).name == name.value.to_lowercase()
    };
    let columns = &csv.columns;
    let pairs =
        (0..columns.len()).flat_map(|i| (i + 1..columns.len()).map(move |j| (&columns[i], &columns[j])));
    let swapped = pairs
        .into_iter()
        .find(|((x, a), (y, b))| called(a, y) && called(b, x) && !called(a, x) && !called(b, y));
    swapped.map(|((x, a), (y, b))| {
        let (x, y, a, b) = (&x.value, &y.value, &a.header, &b.header);
        Diagnostic::warning(format!(
            "`{x}` is read from `{}` and `{y}` from `{}`: the two columns are probably swapped",
            a.value, b.value
        ))
        .at(spec, a.span, format!("the name of `{y}`"))
        .also(spec, b.span, format!("the name of `{x}`"))
        .help("exchange the two headings, or rename the columns of the file")
    })
}

/// A factor as text: `1000 times`, `1/60 times`.
fn times(factor: f64) -> String {
    let digits = |x: f64| format!("{}", (x * 1e6).round() / 1e6);
    if factor >= 1.0 {
        format!("{} times", digits(factor))
    } else {
        format!("1/{} times", digits(1.0 / factor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_expr::Span;
    use phisindy_phys::spec::Spanned;

    /// The warning for a column `x` with this heading, a second heading line, and the unit that the spec
    /// states.
    fn warning(heading: &str, row: Option<&str>, stated: Option<&str>) -> String {
        let text = |value: &str| Spanned { value: value.to_owned(), span: Span::new(0, 1) };
        let column = ColumnSpec { header: text(heading), unit: stated.map(text) };
        let unit = Unit::parse(stated.unwrap_or("m")).expect("a unit");
        let name = text("x");
        let stated_column = StatedColumn { name: Some(&name), column: &column, unit };
        unit_contradiction(&stated_column, heading, row, SourceId(0)).map_or(String::new(), |d| d.message)
    }

    #[test]
    fn another_unit_in_the_heading_is_told() {
        assert!(warning("x_mm", None, Some("m")).ends_with("it in m: 1000 times as much"));
        assert!(warning("x [mm]", None, None).ends_with("in the unit of `x`: 1000 times as much"));
        assert!(warning("v (mm/s)", None, Some("km/s")).ends_with("1000000 times as much"));
        assert!(warning("F_N", None, Some("mN")).ends_with("1/1000 times as much"));
        assert!(warning("phi_deg", None, Some("rad")).contains("says deg"));
        assert!(warning("x", Some("[mm]"), Some("m")).contains("says mm"));
        assert!(warning("v_mm_s", None, Some("mm")).contains("reads it as `x` in mm"));
        assert!(warning("u [V]", None, Some("mm")).contains("says V"));
        assert!(warning("enc_cnt", None, Some("rad")).contains("says counts"));
        assert!(warning("enc [counts]", None, Some("mm")).contains("says counts"));
        assert_eq!(warning("enc_cnt", None, Some("rev/4096")), "");
    }

    #[test]
    fn a_heading_that_agrees_or_says_nothing_is_not_told() {
        for (heading, stated) in [
            ("x_mm", Some("mm")),
            ("x_m", None),
            ("x", Some("mm")),
            ("v_m_per_s", Some("m/s")),
            ("v_ms", Some("m/s")),
            ("phi_rad", Some("")),
            ("phi_deg", Some("")),
            // North, not newton: one letter may be a part of the name.
            ("x_N", Some("mm")),
            ("torque [Nm]", Some("N*m")),
        ] {
            assert_eq!(warning(heading, None, stated), "", "{heading}");
        }
    }

    #[test]
    fn headings_that_name_each_other_are_told() {
        let warning = |columns: &str| {
            let text = format!(
                "(states: {{ \"x\": \"m\" }}, known: {{ \"x\": \"1\" }}, data: [Csv(path: \"a.csv\", time: \"t\", columns: {{ {columns} }})])"
            );
            let (spec, _) = phisindy_phys::spec::read(&text, SourceId(0)).expect("well formed");
            let phisindy_phys::spec::DataSpec::Csv(csv) = &spec.data[0] else { panic!("a Csv record") };
            swapped_columns(csv, SourceId(0)).map_or(String::new(), |d| d.message)
        };
        for swapped in [
            r#""x": ("u_mm", "mm"), "u": ("x_mm", "mm")"#,
            r#""x": "F [N]", "v": "v", "F": "x""#,
            r#""x1": "x2", "x2": "x1""#,
        ] {
            assert!(warning(swapped).ends_with("probably swapped"), "{swapped}");
        }
        for good in [
            r#""x": ("x_mm", "mm"), "u": ("u_mm", "mm")"#,
            r#""x": "u", "u": "base""#,
            r#""x": "a", "v": "b""#,
        ] {
            assert_eq!(warning(good), "", "{good}");
        }
    }
}

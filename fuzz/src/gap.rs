//! The search for a missing law.

use phisindy::{Case, Catalogue, Format, Options, Record, Status};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// A mass on a spring that is believed complete.
const RIG: &str = r#"(states: { "x": "m", "v": "m/s" }, constants: { "m": (1.0, "kg"), "k": (1.0, "N/m") },
    known: { "x": "v", "v": "-k*x/m" }, inertia: { "v": "m" })"#;

/// The rig, its record, and a catalogue without laws.
static SEARCHED: LazyLock<(Case, Record, Catalogue)> = LazyLock::new(|| {
    let case = Case::read(RIG).expect("a spec");
    // Friction of 0.05 N moves the centre of each half swing; the readings are whole tenths of a millimetre.
    let time: Vec<f64> = (0..70).map(|k| 0.15 * f64::from(k)).collect();
    let swing = |t: f64| (t / PI).floor();
    let exact = |t: f64| 0.05 * (-1f64).powf(swing(t)) + (0.95 - 0.1 * swing(t)) * t.cos();
    let x: Vec<f64> = time.iter().map(|&t| (1e4 * exact(t)).round() / 1e4).collect();
    let record = case.record(&[("t", &time), ("x", &x)]).expect("a record");
    let all = Catalogue::built_in();
    let ids: Vec<String> = all.laws().iter().map(|law| law.id.clone()).collect();
    (case, record, all.without(&ids))
});

/// A law, as the only one of a catalogue in which `gap` searches: the search ends with a verdict or an error in words, and what it found can be
/// printed and read back as a model.
pub fn gap(input: &[u8]) {
    let Ok(text) = std::str::from_utf8(input) else { return };
    let (case, record, none) = &*SEARCHED;
    let laws = match none.clone().with("odd", text) {
        Ok(laws) => laws,
        Err(why) => return assert!(!why.to_string().is_empty(), "refused without a reason"),
    };
    match phisindy::gap(
        case,
        std::slice::from_ref(record),
        &Options { laws: Some(&laws), ..Options::default() },
    ) {
        Ok(found) => {
            let laws = found.steps().len();
            match found.status() {
                Status::NothingMissing => panic!("a spring alone explains no friction"),
                Status::Explained | Status::Undetermined => {
                    assert!(laws > 0 && found.after().0 <= found.before().0, "{:?}", found.after())
                }
                Status::Described | Status::Unexplained => {}
            }
            [Format::Latex, Format::Text, Format::Json]
                .into_iter()
                .for_each(|form| assert!(!found.written(form, 0.0).is_empty()));
            assert!(!found.folder(0.0).files.is_empty());
            if let Err(why) = found.case() {
                panic!("{why}");
            }
        }
        Err(why) => assert!(!why.to_string().is_empty(), "refused without a reason"),
    }
}

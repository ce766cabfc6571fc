//! Logs in the layouts of many programs and devices: a draft gets time, units and roles right, or asks.
#![allow(missing_docs)]

use phisindy_expr::Span;
use phisindy_import::{DataFile, Draft, Input, accepted, spec_text, table};
use phisindy_phys::Sources;
use std::f64::consts::TAU;
use std::fmt::Write;

/// The motion (m, or rad) of 2 kg on 300 N/m that two tones drive, and the force (N).
fn rig(t: f64) -> (f64, f64) {
    let tone = |w: f64, a: f64| {
        let (x, v) = (a * (w * t).sin(), a * w * (w * t).cos());
        (x, 2.0 * -w * w * x + 5.0 * v + 300.0 * x)
    };
    let ((x, f), (y, g)) = (tone(TAU * 1.1, 0.02), tone(TAU * 3.7, 0.004));
    // A little noise, the same in every run.
    let mixed = ((t * 1e6) as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let noise = (mixed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
    (x + y + 1e-6 * noise, f + g + 0.02 * noise)
}

/// The acceleration of a phone on a spring that was let go, and that across (m/s^2).
fn ringing(t: f64) -> (f64, f64) {
    let of = |w: f64| (-0.25 * t).exp() * (w * t).cos();
    (4.0 * of(9.0) + 0.003 * (4e3 * t).sin(), 0.3 * of(13.0))
}

/// A heading, and so many rows at a rate (Hz), each written by `row` from its number, time, motion and force.
fn log(head: &str, rate: f64, row: impl Fn(usize, f64, f64, f64) -> String) -> String {
    let mut text = head.to_owned();
    for k in 0..1500 {
        let t = k as f64 / rate;
        let (x, f) = rig(t);
        let _ = writeln!(text, "{}", row(k, t, x, f));
    }
    text
}

fn comma(text: &str) -> String {
    text.replace('.', ",")
}

/// What a draft takes of a file: rows per second, motion and input with their units, and what it asks.
struct Taken {
    rate: f64,
    motion: String,
    input: String,
    asks: Vec<String>,
}

fn taken(content: &str) -> Result<Taken, String> {
    let mut sources = Sources::default();
    let at = (sources.add("command line", "log.csv"), Span::new(0, 7));
    let words = |d: &phisindy_phys::Diagnostic| format!("{} | {}", d.message, d.help.join(" | "));
    let table = table(DataFile::of_bytes("log.csv", content.as_bytes()), None, at, &mut sources)
        .map_err(|d| words(&d))?;
    let draft = Draft::of(table).map_err(|why| words(&why.diagnostic("log.csv", at)))?;
    let text = spec_text(&draft, "log.csv", "log.ron");
    accepted(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let column = |k: usize| {
        let heading = &draft.table.columns[k].heading;
        format!("{} | {}", heading.raw, heading.unit.as_deref().unwrap_or("-"))
    };
    let unit = |text: &str| phisindy_phys::unit::Unit::parse(text).expect("a unit").scale().si("1");
    let heading = &draft.table.columns[draft.time.column].heading;
    let second = heading.unit.as_deref().and_then(unit).unwrap_or(1.0);
    let rate = if draft.time.counted { draft.time.rate } else { 1.0 / (draft.time.step * second) };
    let roles = &draft.roles;
    let motion = roles.displacement.or(roles.velocity).or(roles.acceleration).map_or(String::new(), column);
    let kind = match roles.input {
        Input::None => "",
        Input::Base(_) | Input::BaseAcceleration(_) => "base: ",
        Input::Force(_) => "force: ",
        Input::Drive(_) => "drive: ",
        Input::Reaction(_) => "reaction: ",
    };
    let input = roles.input.column().map_or(String::new(), |c| format!("{kind}{}", column(c)));
    let asks = draft.questions.iter().map(ToString::to_string).collect();
    Ok(Taken { rate, motion, input, asks })
}

/// What is right: a draft, or a question or refusal with these words.
enum Right {
    Draft(f64, &'static str, &'static str),
    Asks(&'static str),
}
use Right::{Asks, Draft as Drafts};

fn layouts() -> Vec<(&'static str, String, Right)> {
    let of = |head: &str, rate: f64, row: &dyn Fn(usize, f64, f64, f64) -> String| log(head, rate, row);
    vec![
        (
            "a post in a forum",
            of(
                "Hi, this is what my rig gave:\n\nTime Position Force\n(s) (mm) (N)\n",
                200.0,
                &|_, t, x, f| format!("{t:.3} {:.4} {f:.3}", 1e3 * x),
            ),
            Drafts(200.0, "Position | mm", "force: Force | N"),
        ),
        (
            "numpy.savetxt",
            of("# t_s x_m F_N\n", 250.0, &|_, t, x, f| format!("{t:.18e} {x:.18e} {f:.18e}")),
            Drafts(250.0, "x_m | m", "force: F_N | N"),
        ),
        (
            "LabVIEW measurement file",
            of(
                "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n\
                 Multi_Headings\tNo\nX_Columns\tOne\nTime_Pref\tRelative\nOperator\tlab\nDate\t2024/03/11\n\
                 Time\t14:02:11.3219\n***End_of_Header***\t\n\t\nChannels\t2\t\t\nSamples\t1500\t1500\t\n\
                 Date\t2024/03/11\t2024/03/11\t\nY_Unit_Label\tmm\tN\t\nX_Dimension\tTime\tTime\t\n\
                 X0\t0.0000000000000000E+0\t0.0000000000000000E+0\t\nDelta_X\t0.001000\t0.001000\t\n\
                 ***End_of_Header***\t\t\t\nX_Value\tDisplacement (mm)\tForce (N)\tComment\n",
                1000.0,
                &|_, t, x, f| format!("{t:.6}\t{:.6}\t{f:.6}\t", 1e3 * x),
            ),
            Drafts(1000.0, "Displacement (mm) | mm", "force: Force (N) | N"),
        ),
        (
            "serial monitor of an Arduino",
            of("micros\tenc\tpwm\n", 500.0, &|k, t, x, f| {
                format!("{:.0}\t{:.0}\t{:.0}", 1e6 * t + 8_123_456.0 + (k % 3) as f64 * 4.0, 4e4 * x, f)
            }),
            Asks("`enc` counts: how many counts are a turn or a millimetre?"),
        ),
        (
            "ROS topic as CSV",
            of(
                "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.name0,field.position0,field.velocity0,field.effort0\n",
                125.0,
                &|k, t, x, f| {
                    let stamp = 1_700_000_000_000_000_000_u64 + (1e9 * t) as u64;
                    let v = (rig(t + 1e-4).0 - rig(t - 1e-4).0) / 2e-4;
                    format!("{stamp},{k},{stamp},,joint_1,{:.7},{:.5},{f:.4}", 10.0 * x, 10.0 * v)
                },
            ),
            Asks("`field.position0` has no unit"),
        ),
        (
            "decoded CAN messages, one channel a row",
            {
                let mut text = "Timestamp;Drive.Angle[deg];Drive.Torque[Nm]\n".to_owned();
                for k in 0..3000 {
                    let t = f64::from(k) / 400.0;
                    let (x, f) = rig(t);
                    let (angle, torque) = match k % 2 {
                        0 => (format!("{:.4}", 57.3 * x), String::new()),
                        _ => (String::new(), format!("{f:.3}")),
                    };
                    let _ = writeln!(text, "{:.6};{angle};{torque}", 1_710_000_000.0 + t);
                }
                text
            },
            Drafts(200.0, "Drive.Angle[deg] | deg", "force: Drive.Torque[Nm] | N*m"),
        ),
        (
            "phyphox",
            of(
                "\"Time (s)\",\"Linear Acceleration x (m/s^2)\",\"Linear Acceleration y (m/s^2)\",\"Linear Acceleration z (m/s^2)\",\"Absolute acceleration (m/s^2)\"\n",
                100.0,
                &|_, t, _, _| {
                    let (a, b) = ringing(t);
                    format!("{t:.9E},{a:.9E},{b:.9E},{:.9E},{:.9E}", 0.7 * b, a.hypot(b))
                },
            ),
            Drafts(100.0, "Linear Acceleration x (m/s^2) | m/s^2", ""),
        ),
        (
            "German Excel",
            of(
                "Prüfstand 3;;\nMessung vom 03.04.2024;;\nZeit [ms];Weg [mm];Kraft [N]\n",
                500.0,
                &|_, t, x, f| comma(&format!("{:.1};{:.4};{f:.3}", 1e3 * t, 1e3 * x)),
            ),
            Drafts(500.0, "Weg [mm] | mm", "force: Kraft [N] | N"),
        ),
        (
            "writetable of MATLAB",
            of("Time_s_,Angle_deg_,Torque_Nm_\n", 200.0, &|_, t, x, f| {
                format!("{t:.15},{:.15},{f:.15}", 57.3 * x)
            }),
            Drafts(200.0, "Angle_deg_ | deg", "force: Torque_Nm_ | N*m"),
        ),
        (
            "Saleae Logic, analogue",
            of("Time [s],Channel 0,Channel 1\n", 1000.0, &|_, t, x, f| {
                format!("{t:.9},{:.4},{:.4}", 2.5 + 40.0 * x, 1.6 + 0.02 * f)
            }),
            Asks("no heading says what `Channel 0`, `Channel 1` are"),
        ),
        (
            "Rigol",
            of(
                "X,CH1,CH2,Start,Increment,\nSequence,VOLT,VOLT,-7.500000e-01,1.000000e-03\n",
                1000.0,
                &|k, _, x, f| format!("{k},{:.3e},{:.3e},,", 40.0 * x, 0.02 * f),
            ),
            Asks("How many are there in a second?"),
        ),
        (
            "Tektronix",
            of(
                "Model,MSO44\nFirmware Version,1.26\n\nWaveform Type,ANALOG\nHorizontal Units,s\nSample Interval,1e-03\n\
                 Record Length,1500\nVertical Units,V,V\n,\nLabels,position,motor current\nTIME,CH1,CH2\n",
                1000.0,
                &|_, t, x, f| format!("{:.6e},{:.5},{:.5}", t - 0.75, 40.0 * x, 0.02 * f),
            ),
            Asks("no heading says what `CH1`, `CH2` are"),
        ),
        (
            "Keysight",
            of("x-axis,1,2\nsecond,Volt,Volt\n", 1000.0, &|_, t, x, f| {
                format!("{:+.8E},{:+.5E},{:+.5E}", t - 0.75, 40.0 * x, 0.02 * f)
            }),
            Asks("no heading says what `1`, `2` are"),
        ),
        (
            "catman",
            of(
                "HBM_CATMANFILE\t7.1\nT0=03.04.2024 09:12:55\nAnzahl Kanäle:\t3\n\nZeit 1 - Standardmessrate [s]\tWeg WA50 [mm]\tKraft U9B [kN]\n",
                300.0,
                &|_, t, x, f| comma(&format!("{t:.5}\t{:.5}\t{:.6}", 1e3 * x, 1e-3 * f)),
            ),
            Drafts(300.0, "Weg WA50 [mm] | mm", "force: Kraft U9B [kN] | kN"),
        ),
        (
            "ControlDesk of dSPACE",
            of(
                "type,\"Float64\",\"Float64\",\"Float64\"\npath,\"Time\",\"Model Root/Plant\",\"Model Root/Plant\"\n\
                 name,\"Time\",\"x\",\"F\"\nunit,\"s\",\"m\",\"N\"\n",
                1000.0,
                &|_, t, x, f| format!("trace_values,{t:.4},{x:.7},{f:.4}"),
            ),
            Drafts(1000.0, "x | m", "force: F | N"),
        ),
        (
            "data inspector of Simulink",
            of("time,Plant/Position (m),Plant/Force (N)\n", 100.0, &|_, t, x, f| format!("{t},{x},{f}")),
            Drafts(100.0, "Plant/Position (m) | m", "force: Plant/Force (N) | N"),
        ),
        (
            "candump, decoded, a signal a row",
            {
                let mut text = "timestamp,signal,value\n".to_owned();
                for k in 0..3000 {
                    let t = f64::from(k) / 400.0;
                    let (x, f) = rig(t);
                    let (name, value) = if k % 2 == 0 { ("angle_deg", 57.3 * x) } else { ("torque_Nm", f) };
                    let _ = writeln!(text, "{t:.6},{name},{value:.5}");
                }
                text
            },
            Asks("signal"),
        ),
        (
            "an IMU with nanoseconds since 1970",
            of(
                "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2]\n",
                200.0,
                &|_, t, _, _| {
                    let (stamp, (w, a)) =
                        (1_403_636_579_758_555_392_u64 + (1e9 * t).round() as u64, ringing(t));
                    format!("{stamp},{w:.9},{:.9},{:.6},{:.6}", 1e-3 * (9.0 * t).cos(), 9.81 + a, 0.1 * a)
                },
            ),
            Drafts(200.0, "w_RS_S_x [rad s^-1] | rad*s^-1", ""),
        ),
        (
            "microseconds without a unit",
            of("t,pos_mm,force_N\n", 1000.0, &|_, t, x, f| format!("{:.0},{:.4},{f:.3}", 1e6 * t, 1e3 * x)),
            Drafts(1000.0, "pos_mm | mm", "force: force_N | N"),
        ),
        (
            "a heading of two lines",
            of("time;position;force\n[ms];[mm];[N]\n", 100.0, &|_, t, x, f| {
                format!("{:.0};{:.4};{f:.3}", 1e3 * t, 1e3 * x)
            }),
            Drafts(100.0, "position | mm", "force: force | N"),
        ),
        (
            "a rate in the header",
            of("# NI 9215\n# fs = 1000 Hz\nforce_N displacement_mm\n", 1000.0, &|_, _, x, f| {
                format!("{f:.3} {:.4}", 1e3 * x)
            }),
            Drafts(1000.0, "displacement_mm | mm", "force: force_N | N"),
        ),
        (
            "suffixes that are units",
            of("t_ms,enc_cnt,T_Nm\n", 1000.0, &|k, _, x, f| format!("{k},{:.0},{f:.3}", 4e4 * x)),
            Asks("`enc_cnt` counts"),
        ),
        (
            "DAQami",
            of("Sample,Date/Time,Position (mm),Load (lbf),Events\n", 100.0, &|k, t, x, f| {
                let (s, ms) = (t as u32, (1e3 * t).round() as u32 % 1000);
                format!("{k},03/11/2024 02:05:{:02}.{ms:03} PM,{:.4},{:.4},", s % 60, 1e3 * x, f / 4.448)
            }),
            Drafts(100.0, "Position (mm) | mm", "force: Load (lbf) | lbf"),
        ),
        (
            "testXpert of Zwick",
            of(
                "\"Prüfzeit\";\"Standardweg\";\"Standardkraft\"\n\"s\";\"mm\";\"N\"\n",
                50.0,
                &|_, t, x, f| comma(&format!("{t:.3};{:.5};{f:.4}", 1e3 * x)),
            ),
            Drafts(50.0, "Standardweg | mm", "force: Standardkraft | N"),
        ),
        (
            "pandas, with its index",
            of(",time,theta,torque\n", 200.0, &|k, t, x, f| format!("{k},{t},{x},{f}")),
            Drafts(200.0, "theta | -", "drive: torque | -"),
        ),
        (
            "stamps of ISO 8601",
            of("timestamp,position_mm,force_N\n", 250.0, &|_, t, x, f| {
                let (s, ms) = (t as u32, (1e3 * t).round() as u32 % 1000);
                format!("2024-05-17T10:32:{s:02}.{ms:03}Z,{:.4},{f:.3}", 1e3 * x)
            }),
            Drafts(250.0, "position_mm | mm", "force: force_N | N"),
        ),
        (
            "write.table of R, with its row names",
            of("\"t_s\" \"x_m\" \"F_N\"\n", 100.0, &|k, t, x, f| format!("\"{}\" {t} {x} {f}", k + 1)),
            Drafts(100.0, "x_m | m", "force: F_N | N"),
        ),
        (
            "a temperature beside a speed",
            log("time_s,speed_rpm,temp\n", 100.0, |_, t, _, _| {
                let noise = 1e-3 * (977.0_f64 * t).sin();
                format!("{t},{:.3},{:.4}", 1500.0 - 60.0 * t + noise, 31.0 + 0.4 * t)
            }),
            Drafts(100.0, "speed_rpm | rpm", ""),
        ),
        (
            "three axes of a phone, of which the last one moves",
            log(
                "\"Time (s)\",\"Acceleration x (m/s^2)\",\"Acceleration y (m/s^2)\",\"Acceleration z (m/s^2)\"\n",
                200.0,
                |_, t, _, _| {
                    let (a, across) = ringing(t);
                    format!("{t:.4},{:.4},{:.4},{a:.4}", 0.1 * across, 0.05 * across)
                },
            ),
            Drafts(200.0, "Acceleration z (m/s^2) | m/s^2", ""),
        ),
        (
            "three axes without a word",
            log("time,seconds_elapsed,z,y,x\n", 100.0, |_, t, x, _| {
                let stamp = 1_700_000_000_123_000_000_u64 + (1e9 * t) as u64;
                format!("{stamp},{t:.4},{x:.5},{:.5},{:.5}", 0.1 * x, 0.2 * x)
            }),
            Asks("`z`"),
        ),
        (
            "a difference of pandas, whose first cell is empty",
            log("time_s,angle_deg,speed\n", 100.0, |k, t, x, _| {
                let before = rig(t - 0.01).0;
                let speed = if k == 0 { String::new() } else { format!("{:.4}", 1e3 * (x - before)) };
                format!("{t},{:.4},{speed}", 1e3 * x)
            }),
            Asks("does not die out"),
        ),
        (
            "a data frame that is printed, with the numbers of its rows",
            log("     time_s  x_mm    F_N\n", 100.0, |k, t, x, f| {
                format!("{k:<5} {t:.2}  {:.4}  {f:.4}", 1e3 * x)
            }),
            Drafts(100.0, "x_mm | mm", "force: F_N | N"),
        ),
        (
            "Simulation Data Inspector",
            log(
                "time,Position,Force Command\n\"\",\"Type: double\",\"Type: double\"\n\"\",\"Unit: mm\",\"Unit: kN\"\n\
                 \"\",\"BlockPath: rig/x\",\"BlockPath: rig/F\"\n",
                500.0,
                |_, t, x, f| format!("{t},{:.5},{:.7}", 1e3 * x, 1e-3 * f),
            ),
            Drafts(500.0, "Position | mm", "force: Force Command | kN"),
        ),
        (
            "the serial monitor of Arduino, with two numbers in a line",
            log("", 100.0, |_, t, x, f| {
                let (second, thousandth) = (10 + t as u32, (1e3 * t).round() as u32 % 1000);
                format!("12:03:{second:02}.{thousandth:03} -> {},{}", (1e5 * x) as i32, (10.0 * f) as i32)
            }),
            Asks("how many counts are a turn or a millimetre?"),
        ),
        (
            "a row of dashes in the place of units",
            log("time_s,x_mm,F_N\n-,-,-\n", 100.0, |_, t, x, f| format!("{t},{:.4},{f:.4}", 1e3 * x)),
            Drafts(100.0, "x_mm | mm", "force: F_N | N"),
        ),
        (
            "an angle of some forty of something",
            log("timestamp_ms,angle\n", 100.0, |k, _, x, _| format!("{},{:.3}", 10 * k, 2e3 * x)),
            Asks("`angle` has no unit, and may be another thing than rad"),
        ),
        (
            "a joint whose torque is measured",
            log("time_s,position,torque\n", 100.0, |_, t, x, f| format!("{t},{:.5},{:.4}", 10.0 * x, f)),
            Drafts(100.0, "position | -", "drive: torque | -"),
        ),
        (
            "an analyser with an accelerometer on the base",
            log("Time (s),ACC mass (m/s2),ACC base (m/s2)\n", 200.0, |_, t, x, f| {
                format!("{t},{:.5},{:.5}", 100.0 * x, 0.1 * f)
            }),
            Asks("is `ACC base (m/s2)` the acceleration of the base that drives it?"),
        ),
        (
            "an accelerometer as its converter has it",
            log("t_ms,ax,ay,az\n", 100.0, |k, t, _, _| {
                let (a, across) = ringing(t);
                let [x, y, z] = [40.0 * across, 20.0 * across, 1670.0 * (a + 9.81)].map(|a| a as i32);
                format!("{},{x},{y},{z}", 10 * k)
            }),
            Asks("`az` counts: how many counts are the acceleration of gravity?"),
        ),
        (
            "PicoScope, with names of its channels",
            of("Time,Position,Motor current\n(ms),(V),(A)\n\n", 1000.0, &|_, t, x, f| {
                format!("{:.6},{:.6},{:.6}", 1e3 * t - 200.0, 40.0 * x, 0.05 * f)
            }),
            Drafts(1000.0, "Position | V", "drive: Motor current | A"),
        ),
    ]
}

#[test]
fn logs_are_read_as_they_are() {
    let mut wrong = vec![];
    for (name, content, right) in layouts() {
        let head: String = content.lines().take(3).collect::<Vec<_>>().join(" / ");
        let got = taken(&content);
        let told = match &got {
            Ok(t) => format!("{:.4} Hz, `{}`, `{}`, asks {:?}", t.rate, t.motion, t.input, t.asks),
            Err(why) => why.clone(),
        };
        let good = match (&right, &got) {
            (Drafts(rate, motion, input), Ok(t)) => {
                // Stamps are rounded.
                (t.rate / rate - 1.0).abs() < 2e-3
                    && t.motion == *motion
                    && t.input == *input
                    && t.asks.is_empty()
            }
            (Asks(what), Ok(t)) => t.asks.iter().any(|asked| asked.contains(what)),
            (Asks(what), Err(why)) => why.contains(what),
            (Drafts(..), Err(_)) => false,
        };
        if !good {
            wrong.push(format!("{name}: {told}\n    of {head}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

//! The command line: names, help, and what clap can check by itself (a mistake ends with exit code 2).

use crate::limit::Limit;
use crate::sweep::shard::Shard;
use anyhow::{Context as _, anyhow};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{CommandFactory, Parser, Subcommand, ValueEnum};
use phisindy::files::{Assignment, Naming, Request, open_plain_file};
use phisindy_import::{Answers, CountUnit, Rig};
use phisindy_page::Source;
use phisindy_phys::spec::Method;
use phisindy_report::export::{EXPORTERS, Exporter};
use phisindy_report::{Look, Plan, RESULT};
use std::io;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  phisindy go run1.csv                        all at once, to the report
  phisindy new run1.csv --out run1.ron        a spec for a data file
  phisindy run run1.ron --out first           the friction with error bars
  phisindy gap run1.ron --out found           what else is missing?
  phisindy run specs/case7.ron                a case that needs no data
  phisindy run case.ron --set learn.cutoff=.1 one field of the spec changed
  phisindy laws stribeck                      a law of the catalogue";

/// The commands by what they are for.
const GROUPS: &str = "\
To begin
  go           from a data file to the report at once
  new          look at a data file, write a commented spec for it
  open         do all of this on a local page; --live follows a rig
To ask the data
  check        say what is wrong with a spec and its data
  run          find the terms of a dictionary: equation, intervals, verdict
  gap          find the law that is missing, add it, show the gap shrink
  compare      what changed on a machine, or which of many stands out
  next         design the run that decides, or that narrows a number
To use what was found
  simulate     the motion as CSV
  export       the model in Python, C, MATLAB, Modelica, FMU, JSON
  sweep        many seeds: how often right, how accurate
  verify       make a result again: the same bits?
To write specs and laws
  laws         list the laws, show one, begin one of your own
  fmt          put their white space in order
  lsp, schema  for your editor
  completions, man  for your shell

`phisindy COMMAND --help` says what a command takes.";

const CODES: &str = "\
The result goes to standard output, everything else to standard error.
Exit codes: 0 identified; 1 ran, but the result is rejected; 2 the spec, its files or the command line are wrong; \
3 the numerics failed, or --limit was met (what was finished is printed); 130 interrupted (the same).";

/// Find the missing part of a mechanical model - above all friction - in measured motion.
#[derive(Debug, Parser)]
#[command(name = "phisindy", version, disable_help_flag = true, before_help = EXAMPLES, after_help = CODES, max_term_width = 110)]
pub(crate) struct Args {
    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Command,
    /// How to do it.
    #[command(flatten)]
    pub(crate) options: Options,
    /// Print help
    #[arg(long, short, global = true, action = clap::ArgAction::HelpShort)]
    help: Option<bool>,
}

/// The command line. The help of a command begins with what it takes, its examples come last; the help of the
/// program begins with examples, and has the commands in groups.
pub(crate) fn command_line() -> clap::Command {
    let reordered = |command: clap::Command| {
        let parts =
            [command.get_before_help(), command.get_after_help()].map(|part| part.map(ToString::to_string));
        let [examples, rest] = parts.map(Option::unwrap_or_default);
        let after =
            [rest, examples].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("\n\n");
        command.before_help(None::<&str>).after_help(after).hide(true)
    };
    let whole = format!(
        "{{before-help}}{{about}}\n\n{{usage-heading}} {{usage}}\n\n{GROUPS}\n\n{{all-args}}{{after-help}}"
    );
    description()
        .mut_subcommands(reordered)
        .override_usage("phisindy [OPTIONS] <COMMAND>")
        .help_template(whole)
}

/// The command line as manual pages and completions show it: no command has options that mean nothing to it.
pub(crate) fn description() -> clap::Command {
    let options = <Options as clap::Args>::augment_args(clap::Command::new(""));
    let fitting = |command: clap::Command| {
        let name = command.get_name().to_owned();
        let unused = options.get_arguments().filter(|arg| !is_taken(arg.get_id().as_str(), &name));
        unused.fold(command, |command, arg| command.arg(arg.clone().hide(true)))
    };
    Args::command().mut_subcommands(fitting)
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Identify: print the equations as LaTeX, then the coefficients with their intervals
    #[command(
        display_order = 3,
        before_help = "\
Examples:
  phisindy run specs/case1a.ron                              the equation, then a table of coefficients
  phisindy run specs/case1a.ron --out case1a                 also case1a/report.html and the numbers as files
  phisindy run specs/frame_250g.ron --data DIR               measured files lie in DIR
  phisindy run specs/*.ron --format json --quiet             for a program: one object per spec
  phisindy run case.ron --set 'contacts=[]' --set 'unknown.y.candidates=[\"1\"]'",
        after_help = "\
Exit codes: 0 identified; 1 rejected; 2 the spec or its files are wrong; 3 the numerics failed, or --limit was met.
If a warning says that something is still missing, `phisindy gap SPEC` looks for it."
    )]
    Run {
        /// Spec files
        #[arg(required = true, value_name = "SPEC")]
        specs: Vec<PathBuf>,
    },
    /// Print the spec's synthetic data, or the free run of a model without unknown part along measured
    /// records, as CSV
    #[command(
        display_order = 5,
        before_help = "\
Examples:
  phisindy simulate specs/case5.ron > case5.csv
  phisindy simulate specs/case5.ron --seed 7 --set 'data.0.noise=Relative(0)'
  phisindy run specs/emps.ron --data DIR --out emps
  phisindy simulate emps/identified.ron --data DIR > emps.csv",
        after_help = "\
Columns: NAME as recorded (synthetic: with noise), NAME_true the exact state of synthetic data, NAME_model the free run of the model along a \
measured record, from the record's `start` or else its first sample; then the inputs."
    )]
    Simulate {
        /// Spec file
        #[arg(value_name = "SPEC")]
        spec: PathBuf,
        /// Only this record, by name or place (0 is the first one) [default: all]
        #[arg(long, value_name = "NAME")]
        record: Option<String>,
    },
    /// Say what is wrong with specs and their data, without running them
    #[command(
        display_order = 2,
        before_help = "\
Examples:
  phisindy check specs/*.ron
  phisindy check specs/frame_250g.ron --data DIR    (reads the data files in DIR too)"
    )]
    Check {
        /// Spec files
        #[arg(required = true, value_name = "SPEC")]
        specs: Vec<PathBuf>,
    },
    /// Look at a data file and write a commented spec for it, ready to edit
    #[command(
        display_order = 1,
        before_help = "\
Examples:
  phisindy new run1.csv                         what is in it, and a spec, on standard output
  phisindy new run1.csv --out run1.ron          the spec into a file, which must not exist yet
  phisindy new run1.csv --out run1.ron --force  the same in place of what is there
  phisindy new acc.txt --rate 1000 --out a.ron  a file without times: 1000 rows per second
  phisindy new arm.urdf --data log.csv          a robot of URDF or MJCF: energies, and the columns of its joints",
        after_help = "\
Guessed are the separator, the decimal mark, units in the headings (`x_mm`, `x [mm]`, `t/s`), which column is time, displacement, base motion or force, \
rows to leave out, and numbers to start from. What the guess rests on stands in comments; what must be looked at is marked EDIT. At most one million \
rows are read."
    )]
    New(NewArgs),
    /// From a data file to the report at once: `new`, then `gap`, then the report in the browser
    #[command(
        display_order = 0,
        before_help = "\
Examples:
  phisindy go run1.csv                 run1-found/run1.ron, the spec, and run1-found/report.html
  phisindy go run1.csv                 again, after lines of run1-found/run1.ron were edited
  phisindy go run1.csv --out found --no-open",
        after_help = "\
The spec is a guess: what must be looked at is marked EDIT. A spec that is there is used as it is.
Exit codes: those of `phisindy gap`."
    )]
    Go(GoArgs),
    /// List the laws of the catalogue, or show one
    #[command(
        display_order = 8,
        before_help = "\
Examples:
  phisindy laws                                       all of them
  phisindy laws dieterich-ruina                       one: its force, its parameters, its source
  phisindy laws --laws my-laws/                       with those of a folder
  phisindy laws new my-damper --out laws              laws/my-damper.ron: a law of your own to fill in
  phisindy laws --out docs/laws                       a picture of each, and a page of them"
    )]
    Laws {
        /// Id of a law; or `new` and the name of a law of your own, for a file to fill in
        #[arg(value_name = "NAME", num_args = 0..=2)]
        words: Vec<String>,
    },
    /// Find where model and data disagree, name the missing effect, add it, show the gap shrink
    #[command(
        display_order = 4,
        before_help = "\
Examples:
  phisindy gap rig.ron                            name what is missing, with its numbers
  phisindy gap rig.ron --out found                also found/report.html, and found/completed.ron: the spec with it
  phisindy run found/completed.ron --data .       its data files are where rig.ron had them
  phisindy gap both.ron --planned plan            the run of `phisindy next --out plan` was made: what did it decide?
  phisindy gap specs/silverbox.ron --data DIR --laws my-laws",
        after_help = "\
Tries every law of the catalogue (`phisindy laws`) at every place where it fits: velocities, differences of velocities, sensors.
Where none explains the data it looks for a formula, which --out keeps as laws/discovered-1.ron.
Exit codes: 0 nothing is missing, or what is missing was found; 1 something is missing that no law and no formula explains."
    )]
    Gap {
        /// The spec
        #[arg(value_name = "SPEC")]
        spec: PathBuf,
        /// Leave a law of the catalogue out; repeatable
        #[arg(long, value_name = "LAW")]
        without: Vec<String>,
    },
    /// Write an identified model so that it runs elsewhere: Python, C, Modelica, FMU, URDF, MJCF, JSON
    #[command(
        display_order = 6,
        before_help = "\
Examples:
  phisindy run specs/case7.ron --out case7                  identify, and keep the result
  phisindy export case7 --to python --out case7.py          what was identified as a Python module
  phisindy simulate case7/identified.ron > motion.csv
  python3 case7.py < motion.csv                             the same motion
  phisindy export case7 --to c --out case7.c
  cc -O2 -std=c99 -DPHISINDY_MAIN case7.c -o case7m -lm
  phisindy export case7 --to fmu --out case7.fmu            for Simulink, Dymola, OpenModelica: FMI 3.0
  phisindy export found --to mjcf --model arm.xml --out arm-found.xml   friction of the joints back into a robot
  phisindy export found/completed.ron --to json             what `gap` found, as data, on standard output",
        after_help = "\
The file holds the rates as a plain function, its constants by name, and the rule that decides when a contact sticks; Python and C simulate too, with \
the events that `phisindy simulate` finds. All numbers are in SI. --out is a file, or a folder in which it becomes model.py, model.c, Model.mo, \
model.fmu or model.json; what is there is replaced only with --force. Modelica is written for tools that know the friction elements of its standard library."
    )]
    Export(ExportArgs),
    /// Identify with many seeds in parallel: how often the terms are right, how accurate the numbers and
    /// their intervals are
    #[command(
        display_order = 7,
        before_help = "\
Examples:
  phisindy sweep specs/case1a.ron --seeds 100
  phisindy sweep specs/case1a.ron --seeds 100 --noise 'Relative(0.1), Additive(0.02)' --out sweep
  phisindy sweep specs/case1b.ron --seeds 20 --method step --cutoffs 0.02,0.05,0.1
  phisindy sweep specs/case1a.ron --seeds 20 --vary 'unknown.y.candidates=[\"1\"];[\"1\", \"x\", \"y\"]'
  phisindy sweep specs/case1a.ron --seeds 1000 --shard 3/16 --out parts   the third of sixteen programs, on any machine
  phisindy sweep --merge parts --out sweep                                the table of all of them",
        after_help = "\
Seeds run from S to S+N-1, S from --seed or the spec. Every combination of --noise, --cutoffs and --vary is a cell of its own. With --out DIR every \
finished run is kept in DIR/sweep.jsonl, so that the same command goes on after an interruption; the table is in DIR/sweep.json at the end.
A shard is kept in DIR/sweep-K-of-N.jsonl; --merge makes the same table of them as one program would, to the bit. docs/cluster has examples \
for Slurm, Snakemake and Nextflow.
Exit code 1: a truth lies outside of its dictionary, or no run came to a result."
    )]
    Sweep(SweepArgs),
    /// Say what changed on a machine since an earlier record, or which of many machines stands out
    #[command(
        display_order = 9,
        before_help = "\
Examples:
  phisindy compare march.ron june.ron          which numbers changed, by how much, how surely; is there a new cause?
  phisindy compare march-found june.ron        the older is a result of `gap --out` or `run --out`
  phisindy compare fleet/*.ron --out care      three or more: spread, who stands out; care/report.html shows it",
        after_help = "\
With two, the model of the older one is fitted to the records of the newer one. With three or more, each is judged by its own model, and the \
numbers are set beside each other. A machine that did not change is called changed once in a hundred comparisons.
Exit codes: 0 nothing changed, nobody stands out; 1 something did."
    )]
    Compare {
        /// Specs, or folders that `run --out` or `gap --out` wrote: the older one first
        #[arg(value_names = ["OLD", "NEW"], num_args = 2.., required = true)]
        paths: Vec<PathBuf>,
    },
    /// Design the next run: the one that best tells the models apart that are left, or best narrows a number
    #[command(
        display_order = 9,
        before_help = "\
Examples:
  phisindy next found                     which run decides between the laws that the records of found leave?
  phisindy next rig.ron --narrow Fc       which run narrows Fc best?
  phisindy next rig.ron --set 'limits={ \"F\": (-5.0, 5.0), \"x\": (-0.02, 0.02), duration: 30.0 }'
  phisindy next found --out plan          plan/drive.csv, plan/motion.csv (what each model predicts), plan/report.html",
        after_help = "\
The spec says what the rig can do: `limits: { \"F\": (-5.0, 5.0), \"x\": (-0.02, 0.02), duration: 60.0, band: (0.1, 10.0) }`: inputs, states, outputs, and \
constants that can be set. What it does not say is what the records have shown. No run leaves the limits under any model that is left.
Exit codes: 0 a run was found; 2 no model or no run is left, and why."
    )]
    Next {
        /// Spec, or folder that `run --out` or `gap --out` wrote
        #[arg(value_name = "DIR|SPEC")]
        path: PathBuf,
        /// The number to narrow, in place of telling models apart
        #[arg(long, value_name = "NAME")]
        narrow: Option<String>,
    },
    /// Make a result again and say whether it has the same bits, or what differs
    #[command(
        display_order = 10,
        before_help = "\
Examples:
  phisindy verify found                    the folder that `phisindy gap rig.ron --out found` wrote
  phisindy verify found --data elsewhere   its data files are there now",
        after_help = "\
The folder keeps the spec as it was given (spec.ron), and the SHA-256 of its data and laws, the version and the options (provenance.json).
Exit codes: 0 all as it was; 1 something differs: which file, which line, which value; 2 the folder holds no result."
    )]
    Verify {
        /// Folder that `run --out` or `gap --out` wrote
        #[arg(value_name = "DIR")]
        folder: PathBuf,
    },
    /// Work on a local page: drop a file, edit the model, run it, watch the gap shrink
    #[command(
        display_order = 11,
        before_help = "\
Examples:
  phisindy open                 the working folder is this one
  phisindy open rig.csv         begin with a data file; its folder is the working folder
  phisindy open rig.ron         begin with a spec
  phisindy open --no-open       only print the address
  phisindy open rig.ron --live serial:/dev/ttyUSB0   follow a board, and say when the record is enough",
        after_help = "\
The page is for this machine and this user alone: it listens on 127.0.0.1 and answers only to the address with the token that is printed.
It loads nothing from the network. Data, spec and results are files in the working folder. End it with Ctrl-C; nothing is lost."
    )]
    Open(OpenArgs),
    /// Put the white space of specs and laws in order; values and comments stay
    #[command(
        display_order = 12,
        before_help = "\
Examples:
  phisindy fmt rig.ron laws/*.ron     rewrite these files
  phisindy fmt --check specs/*.ron    only name those that would change
  phisindy fmt - < rig.ron            from standard input to standard output",
        after_help = "\
Brackets stay on one line where they fit into 110 columns, unless a new line \
follows the opening one; what begins a line goes on to do so. A file with a \
mistake of syntax is left as it is.
Exit codes: 0 in order now; 1 --check found a file that is not; 2 a file cannot \
be read or has a mistake."
    )]
    Fmt {
        /// Specs and laws, or - for standard input
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
        /// Change nothing; print the names of files that are not in order
        #[arg(long)]
        check: bool,
    },
    /// Serve an editor: mistakes, completions, units, formatting (LSP)
    #[command(
        display_order = 13,
        before_help = "\
Examples:
  phisindy lsp                  an editor starts it so
  phisindy lsp --data DIR       data files are there, not beside the specs",
        after_help = "\
It speaks the language server protocol over standard input and output. The \
folder editors/vscode is an extension for VS Code; docs/guides/editors.md has \
the lines for others."
    )]
    Lsp,
    /// Print a JSON schema of the fields of a spec or a law
    #[command(
        display_order = 14,
        before_help = "\
Examples:
  phisindy schema > spec.schema.json
  phisindy schema law",
        after_help = "\
Draft 2020-12, of a spec as JSON: a tuple is an array, and Name(...) is an \
object with the one field Name."
    )]
    Schema {
        /// Of what
        #[arg(value_enum, value_name = "WHAT", default_value_t = Written::Spec, hide_default_value = true)]
        of: Written,
    },
    /// Print what a shell needs to complete this command line
    #[command(
        display_order = 15,
        before_help = "\
Examples:
  phisindy completions bash > ~/.local/share/bash-completion/completions/phisindy
  phisindy completions zsh > ~/.zfunc/_phisindy                      (with ~/.zfunc in fpath)
  phisindy completions fish > ~/.config/fish/completions/phisindy.fish
  phisindy completions powershell >> $PROFILE"
    )]
    Completions {
        /// Shell
        #[arg(value_enum, value_name = "SHELL")]
        shell: clap_complete::Shell,
    },
    /// Print the manual, or write its pages into --out
    #[command(
        display_order = 16,
        before_help = "\
Examples:
  phisindy man > phisindy.1                         the whole program on one page
  man ./phisindy.1
  phisindy man --out ~/.local/share/man/man1        a page for it and one for each subcommand: man phisindy-run"
    )]
    Man,
}

impl Command {
    /// Whether the work asks if it should end early, and keeps what it has then.
    pub(crate) fn keeps(&self) -> bool {
        use Command::{Compare, Gap, Go, Next, Open, Run, Sweep, Verify};
        matches!(
            self,
            Compare { .. }
                | Next { .. }
                | Run { .. }
                | Gap { .. }
                | Go(_)
                | Sweep(_)
                | Open(_)
                | Verify { .. }
        )
    }
}

/// For which file to find what is missing.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct GoArgs {
    /// Data files, as for `phisindy new`
    #[arg(value_name = "DATA", required = true)]
    pub(crate) paths: Vec<PathBuf>,
    /// Sheet of a workbook, or variable, structure, group of another file
    #[arg(long, value_name = "NAME")]
    pub(crate) sheet: Option<String>,
    #[command(flatten)]
    pub(crate) said: Said,
    /// Do not open the report
    #[arg(long)]
    pub(crate) no_open: bool,
}

/// For which file to write a spec.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct NewArgs {
    /// Data file: text with any separator, a workbook, MATLAB, NumPy, TDMS, universal file, HDF5, Parquet; or several of
    /// one rig. Or a robot, URDF or MJCF, whose log --data names
    #[arg(value_name = "DATA", required = true)]
    pub(crate) paths: Vec<PathBuf>,
    /// Sheet of a workbook, or variable, structure, group of another file
    #[arg(long, value_name = "NAME")]
    pub(crate) sheet: Option<String>,
    #[command(flatten)]
    pub(crate) said: Said,
}

/// What the user says of a data file beside what it holds.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Said {
    /// Rows per second, of a file without times or in place of them
    #[arg(long, value_name = "HZ", value_parser = phisindy_import::rate)]
    pub(crate) rate: Option<f64>,
    /// Names of the columns with their units, in the place of the headings; - for one that is not used
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', allow_hyphen_values = true)]
    pub(crate) columns: Vec<String>,
    /// Unit of the column of time, where its heading gives none or a wrong one
    #[arg(long, value_name = "UNIT", value_parser = phisindy_import::time_unit)]
    pub(crate) time_unit: Option<String>,
    /// Counts of an encoder in a turn or a length, 4096/rev, 200/mm; of one of several, enc_motor=4096/rev
    #[arg(long, value_name = "N/UNIT", value_parser = CountUnit::parse)]
    pub(crate) counts: Vec<CountUnit>,
    /// Kind of rig: slider, pendulum, motor, base-excited, quarter-car, tester, robot-joint, free [default: guessed]
    #[arg(long, value_name = "KIND", value_parser = Rig::parse)]
    pub(crate) rig: Option<Rig>,
}

impl Said {
    /// Whether anything is said.
    pub(crate) fn is_something(&self) -> bool {
        self.answers() != Answers::default()
    }

    /// For a draft.
    pub(crate) fn answers(&self) -> Answers {
        Answers {
            rate: self.rate,
            columns: self.columns.clone(),
            time_unit: self.time_unit.clone(),
            counts: self.counts.clone(),
            rig: self.rig,
            ..Answers::default()
        }
    }
}

/// Where to work on a page.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct OpenArgs {
    /// Spec or data file to begin with; its folder is the working folder [default: this folder]
    #[arg(value_name = "SPEC|DATA")]
    pub(crate) path: Option<PathBuf>,
    /// Port of 127.0.0.1 [default: a free one]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub(crate) port: u16,
    /// Only print the address; open no browser
    #[arg(long)]
    pub(crate) no_open: bool,
    /// Follow a record that grows: serial:/dev/ttyUSB0[@BAUD], tcp://HOST:PORT, or a file that another program writes
    #[arg(long, value_name = "SOURCE")]
    pub(crate) live: Option<Source>,
}

/// What to export.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct ExportArgs {
    /// Folder that `run --out` or `gap --out` wrote, or a spec without unknown part
    #[arg(value_name = "DIR|SPEC")]
    pub(crate) path: PathBuf,
    /// Language
    #[arg(long, value_name = "LANGUAGE", value_parser = exporter())]
    pub(crate) to: &'static Exporter,
    /// Record whose start state and constants are written, by name or place [default: 0, the first one]
    #[arg(long, value_name = "NAME")]
    pub(crate) record: Option<String>,
    /// Of urdf and mjcf: the file of the robot that `phisindy new` drafted the spec from
    #[arg(long, value_name = "FILE")]
    pub(crate) model: Option<PathBuf>,
}

/// A language to export to, by its name.
fn exporter() -> impl TypedValueParser<Value = &'static Exporter> {
    let names = EXPORTERS.iter().map(|e| PossibleValue::new(e.name).help(e.about));
    let named = |name: String| EXPORTERS.iter().find(|e| e.name == name).ok_or("there is no such language");
    PossibleValuesParser::new(names).try_map(named)
}

/// What to sweep over.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct SweepArgs {
    /// Spec file with synthetic data
    #[arg(value_name = "SPEC", required_unless_present = "merge", conflicts_with = "merge")]
    pub(crate) spec: Option<PathBuf>,
    /// Number of seeds
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub(crate) seeds: u64,
    /// Noise of all synthetic records, as in 'Relative(0.1), Additive(0.02)'
    #[arg(long, value_name = "LIST")]
    pub(crate) noise: Option<String>,
    /// Cut-offs, as in 0.02,0.05,0.1 (method trajectory: in place of its own selection)
    #[arg(long, value_name = "LIST")]
    pub(crate) cutoffs: Option<String>,
    /// Values of any field of the spec; repeatable
    #[arg(long, value_name = "PATH=V1;V2;...", value_parser = assignment)]
    pub(crate) vary: Vec<Assignment>,
    /// Do only the K-th of N parts, whose journal --out keeps; --merge puts all of them together
    #[arg(long, value_name = "K/N", value_parser = Shard::parse, conflicts_with = "merge")]
    pub(crate) shard: Option<Shard>,
    /// In place of a spec: the table of the sweep whose shards lie in these folders
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["noise", "cutoffs", "vary", "seeds"])]
    pub(crate) merge: Vec<PathBuf>,
}

/// To which commands an option means something, by its id.
const TAKEN: &[(&str, &[&str])] = &[
    // Every command takes a format, so that a script can ask all of them alike; these print text whatever it is.
    (
        "format",
        &["run", "gap", "go", "sweep", "new", "check", "simulate", "export", "verify", "compare", "next"],
    ),
    ("out", &["run", "gap", "go", "new", "export", "sweep", "laws", "man", "compare", "next"]),
    ("force", &["run", "gap", "go", "new", "export", "sweep", "laws", "compare", "next"]),
    (
        "data",
        &[
            "run", "gap", "go", "new", "simulate", "check", "export", "sweep", "open", "verify", "compare",
            "next", "lsp",
        ],
    ),
    (
        "laws",
        &[
            "run", "gap", "go", "simulate", "check", "export", "sweep", "laws", "open", "compare", "next",
            "lsp",
        ],
    ),
    ("planned", &["run", "gap"]),
    ("seed", &["run", "gap", "simulate", "check", "export", "sweep"]),
    ("method", &["run", "sweep"]),
    ("jobs", &["run", "gap", "go", "new", "simulate", "check", "sweep", "open", "verify", "compare", "next"]),
    (
        "limit",
        &[
            "run", "gap", "go", "new", "simulate", "check", "export", "sweep", "open", "verify", "compare",
            "next",
        ],
    ),
    (
        "quiet",
        &[
            "run", "gap", "go", "new", "simulate", "check", "export", "sweep", "laws", "open", "verify",
            "compare", "next",
        ],
    ),
    ("sets", &["run", "gap", "go", "new", "simulate", "check", "export", "sweep", "next"]),
];

/// Whether an option means something to a command.
fn is_taken(option: &str, command: &str) -> bool {
    TAKEN.iter().any(|(id, by)| *id == option && by.contains(&command))
}

/// Refuses options that mean nothing to the command: whoever gives one expects something of it.
pub(crate) fn refuse_unused(matches: &clap::ArgMatches) -> Result<(), clap::Error> {
    let Some((command, own)) = matches.subcommand() else { return Ok(()) };
    let given = |id: &str| own.value_source(id) == Some(ValueSource::CommandLine);
    let Some((id, by)) = TAKEN.iter().find(|(id, _)| given(id) && !is_taken(id, command)) else {
        return Ok(());
    };
    let line = command_line();
    let long =
        line.get_arguments().find(|arg| arg.get_id() == id).and_then(clap::Arg::get_long).unwrap_or(id);
    let why =
        format!("`--{long}` means nothing to `phisindy {command}`; it is an option of {}\n", by.join(", "));
    Err(clap::Error::raw(ErrorKind::UnknownArgument, why).with_cmd(&line))
}

/// Most threads for each core: more only take turns.
const MOST_THREADS: usize = 16;

/// A number of threads that this machine can use.
fn threads(text: &str) -> Result<usize, String> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    match text.parse::<usize>() {
        Ok(n) if (1..=MOST_THREADS * cores).contains(&n) => Ok(n),
        _ => Err(format!(
            "expected a number from 1 to {}, as this machine has {cores} core{}",
            MOST_THREADS * cores,
            if cores == 1 { "" } else { "s" }
        )),
    }
}

/// How to do it. Help shows a command the options that mean something to it.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Common options")]
pub(crate) struct Options {
    /// Form of the result
    #[arg(long, global = true, value_enum, default_value_t = Format::Latex, value_name = "FORMAT")]
    pub(crate) format: Format,
    /// Write the results into this folder, too; `new` and `export`: into this file
    #[arg(
        long,
        global = true,
        value_name = "DIR",
        long_help = "Write the results into this folder, too (made if needed): report.html with its figures and result.json;\n\
                     `run`: equation.tex, identified.ron; `gap`: gap.txt, completed.ron; `sweep`: sweep.json; `laws`: pictures;\n\
                     `man`: its pages; `new`: the spec's file; `export`: the model's file, or its folder"
    )]
    pub(crate) out: Option<PathBuf>,
    /// Use a folder of --out that holds other files too, which stay; `new`, `export`, `laws`: replace the file that is there
    #[arg(long, global = true)]
    pub(crate) force: bool,
    /// Folder of the data files [else: PHISINDY_DATA, then beside the spec]; `new ROBOT`: its log, a file
    #[arg(long, global = true, value_name = "DIR")]
    pub(crate) data: Option<PathBuf>,
    /// Folder of further laws
    #[arg(long, global = true, value_name = "DIR")]
    pub(crate) laws: Option<PathBuf>,
    /// Seed of synthetic data, in place of the spec's
    #[arg(long, global = true, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// How to identify, in place of the spec's
    #[arg(long, global = true, value_enum, value_name = "METHOD")]
    pub(crate) method: Option<MethodArg>,
    /// Number of threads [default: all]
    #[arg(long, global = true, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub(crate) jobs: Option<usize>,
    /// Longest time and most memory, as in 10min, 4GB or 10min,4GB, or none [default: 24h,8GB]
    #[arg(long, global = true, value_name = "LIMIT", value_parser = Limit::parse)]
    pub(crate) limit: Option<Limit>,
    /// No progress and no warnings
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// Change a field of the spec, as in learn.cutoff=0.1 or data.0.noise=Additive(0.02); repeatable
    #[arg(long = "set", global = true, value_name = "PATH=VALUE", value_parser = assignment)]
    pub(crate) sets: Vec<Assignment>,
    /// Folder of `next --out` whose run was made: say what it decided, beside what was promised
    #[arg(long, global = true, value_name = "DIR")]
    pub(crate) planned: Option<PathBuf>,
    /// The words of the command line after the name of the program.
    #[arg(skip)]
    pub(crate) line: Vec<String>,
    /// What the terminal can show that reads the result; `None` for a pipe, and where `--format` asks for a
    /// form.
    #[arg(skip)]
    pub(crate) look: Option<Look>,
}

impl Options {
    /// The plan of `--planned`.
    pub(crate) fn plan(&self) -> Result<Option<Plan>, anyhow::Error> {
        let Some(folder) = &self.planned else { return Ok(None) };
        let file = folder.join(RESULT);
        let told = || format!("--planned {}: cannot read {}", folder.display(), file.display());
        let text = open_plain_file(&file).and_then(io::read_to_string).with_context(told)?;
        let none = || {
            anyhow!("--planned {}: {} is no plan of `phisindy next --out`", folder.display(), file.display())
        };
        Plan::read(&text).ok_or_else(none).map(Some)
    }

    /// What is asked for when a spec is read. The environment is looked at here alone.
    pub(crate) fn request(&self) -> Request {
        let environment = std::env::var_os("PHISINDY_DATA").filter(|v| !v.is_empty());
        Request {
            assignments: self.sets.clone(),
            data: self.data.clone(),
            naming: Naming::Option,
            further_data: environment.map(PathBuf::from),
            named_data: None,
            laws: self.laws.clone(),
            seed: self.seed,
            tables: vec![],
        }
    }
}

/// What is written in RON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Written {
    /// A spec [default]
    Spec,
    /// A law of the catalogue
    Law,
}

/// Form of the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Equations as LaTeX, the rest as comments.
    Latex,
    /// Equations in the language of the specs.
    Text,
    /// One JSON object per spec.
    Json,
}

impl From<Format> for phisindy_report::Format {
    fn from(format: Format) -> phisindy_report::Format {
        match format {
            Format::Latex => phisindy_report::Format::Latex,
            Format::Text => phisindy_report::Format::Text,
            Format::Json => phisindy_report::Format::Json,
        }
    }
}

/// A method by its name on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum MethodArg {
    /// The one-step loss of the paper.
    Step,
    /// Fit of the simulated trajectory.
    Trajectory,
}

impl From<MethodArg> for Method {
    fn from(method: MethodArg) -> Method {
        match method {
            MethodArg::Step => Method::Step,
            MethodArg::Trajectory => Method::Trajectory,
        }
    }
}

fn assignment(text: &str) -> Result<Assignment, String> {
    match text.split_once('=') {
        Some((path, value)) if !path.trim().is_empty() && !value.trim().is_empty() => {
            Ok(Assignment { path: path.trim().to_owned(), value: value.trim().to_owned() })
        }
        _ => Err("expected PATH=VALUE, such as learn.cutoff=0.1".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        command_line().debug_assert();
    }

    #[test]
    fn every_command_is_in_a_group_of_the_help() {
        let named = |name: &str| {
            GROUPS
                .lines()
                .any(|line| line.starts_with("  ") && line.split([' ', ',']).any(|word| word == name))
        };
        for command in description().get_subcommands().map(clap::Command::get_name) {
            assert!(named(command), "{command}");
        }
        assert!([GROUPS, EXAMPLES].iter().all(|text| text.lines().all(|line| line.chars().count() <= 80)));
    }

    #[test]
    fn an_assignment_splits_at_the_first_equals_sign() {
        let a = assignment("known.y=\"-k*x\"").expect("a good assignment");
        assert_eq!((a.path.as_str(), a.value.as_str()), ("known.y", "\"-k*x\""));
        assert!(assignment("known.y").is_err());
        assert!(assignment("=1").is_err());
    }
}

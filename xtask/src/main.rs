//! `cargo xtask`: one named command for each chore and CI step.

mod aarch64;
mod campaign;
mod cargo;
mod fuzz;
mod jobs;
mod programs;
mod record;
mod seen;
mod steps;
mod tally;

use std::process::ExitCode;

use anyhow::bail;
use pico_args::Arguments;
use xtask::Outcome;

const HELP: &str = "\
One named command for each chore and CI step.

cargo xtask test [--install] [--only STEP] [--all] [--list]
    Everything that must pass. --list names the steps and what each proves; --only runs one of them
    (`--only host/calibrate/chessboard`: one test program). Missing Debian packages are installed with
    --install or where CI=true; otherwise the steps that need them are skipped and say so. Firmware
    and aarch64 are left out while their sources are those that campaigns `boards` and `aarch64`
    passed on, and test programs while nothing has changed since they passed in this target
    folder; --all or --only NAME runs them.
cargo xtask campaign NAME | --list
    What takes too long for `test`: --list says what each proves, how long it takes and whether its
    part has changed since it passed.
cargo xtask tables [--bless]       bakes the shipped tables again and compares them byte for byte
cargo xtask figures [--bless]      compares the measured figures of README and docs/firmware.md, or writes them
cargo xtask firmware test|report   the core on emulated Cortex-M boards (--help says more)
cargo xtask aarch64                tables, core and bake on emulated aarch64
cargo xtask cameras                the program with the kernel's virtual cameras, in a machine
cargo xtask fuzz [--seconds N]     fuzzes the table parser (nightly Rust and cargo-fuzz)

Examples:
    cargo xtask test
    cargo xtask test --only lint
    cargo xtask firmware test --board m7 stitch
";

fn main() -> ExitCode {
    match run() {
        Ok(Outcome::Passed) => ExitCode::SUCCESS,
        Ok(Outcome::Skipped(why)) => {
            println!("{}{why}", xtask::SKIPPED);
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> anyhow::Result<Outcome> {
    let mut args = Arguments::from_env();
    if args.contains(["-h", "--help"]) && std::env::args().nth(1).as_deref() != Some("firmware") {
        print!("{HELP}");
        return Ok(Outcome::Passed);
    }
    let Some(command) = args.subcommand()? else {
        print!("{HELP}");
        bail!("which command?");
    };
    let outcome = match command.as_str() {
        "test" => {
            let options = steps::Options {
                install: args.contains("--install"),
                list: args.contains("--list"),
                all: args.contains("--all"),
                only: args.opt_value_from_str("--only")?,
            };
            end(args)?;
            return steps::run(&options).map(|()| Outcome::Passed);
        }
        "campaign" => {
            let list = args.contains("--list");
            let name: Option<String> = args.opt_free_from_str()?;
            end(args)?;
            campaign::run(list, name.as_deref())?
        }
        "fuzz" => {
            let seconds = args.opt_value_from_str("--seconds")?;
            end(args)?;
            fuzz::run(seconds.unwrap_or(fuzz::SECONDS))?
        }
        "aarch64" => {
            end(args)?;
            aarch64::run()?
        }
        // Their arguments are read where they are used.
        "tables" | "figures" | "firmware" | "cameras" => {
            let rest = args.finish();
            cargo::check(&command, &rest)?
        }
        other => bail!("no command `{other}`: `cargo xtask --help` lists them"),
    };
    Ok(outcome)
}

/// Refuses what is left over.
fn end(args: Arguments) -> anyhow::Result<()> {
    let rest = args.finish();
    if !rest.is_empty() {
        bail!("not understood: {rest:?} (`cargo xtask --help`)");
    }
    Ok(())
}

//! `cargo run -p barrelman-manuals -- DIR`: writes the completions for bash, fish and zsh into a folder, and
//! the manual pages into a folder below it for each package, from the definitions of the command line that
//! the program itself uses.
//!
//! A crate of its own, so that the program holds neither of the generators.

use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context as _, Result, bail};
use barrelman_ros2::cli::Cli as Ros2Cli;
use barrelman_station::cli::Cli;
use clap::{Command, CommandFactory as _};
use clap_complete::Shell;
use clap_complete::aot::generate_to;

/// The shells that get completions.
const SHELLS: [Shell; 3] = [Shell::Bash, Shell::Fish, Shell::Zsh];

/// The node of ROS 2: its package and its program.
const ROS2: &str = "barrelman-ros2";

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            use std::io::Write as _;
            let _ = writeln!(std::io::stderr(), "{error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<()> {
    let [folder] = &std::env::args_os().skip(1).collect::<Vec<_>>()[..] else {
        bail!("usage: cargo run -p barrelman-manuals -- DIR");
    };
    write(Path::new(folder))
}

/// Writes all files into a folder, which is made if it is missing.
fn write(folder: &Path) -> Result<()> {
    let context = || format!("the manuals cannot be written into {}", folder.display());
    for (package, program) in [
        ("barrelman", Cli::command()),
        ("barrelman", guard()),
        ("barrelman-media", media()),
        (ROS2, Ros2Cli::command()),
    ] {
        let pages = folder.join(package);
        std::fs::create_dir_all(&pages).with_context(context)?;
        clap_mangen::generate_to(program, pages).with_context(context)?;
    }
    for shell in SHELLS {
        generate_to(shell, &mut Cli::command(), "barrelman", folder).with_context(context)?;
        generate_to(shell, &mut Ros2Cli::command(), ROS2, folder).with_context(context)?;
    }
    Ok(())
}

/// The guard, which has no command line.
fn guard() -> Command {
    Command::new("barrelman-guard")
        .version(env!("CARGO_PKG_VERSION"))
        .disable_help_flag(true)
        .disable_version_flag(true)
        .about("Owns the port of a vehicle or a boat for barrelman, and stops it when barrelman is gone")
        .long_about(
            "barrelman starts this program for each vehicle that keeps its last rate, and for each boat. The guard alone has the \
             port open. When barrelman is killed, crashes, hangs or is silent for a second, the guard sends zeros and the \
             vehicle's own stop, and ends. It is not started by hand, and must not be killed together with barrelman.",
        )
}

/// The program with GStreamer, which has no command line.
fn media() -> Command {
    Command::new("barrelman-media")
        .version(env!("CARGO_PKG_VERSION"))
        .disable_help_flag(true)
        .disable_version_flag(true)
        .about("Reads and decodes video for barrelman with GStreamer")
        .long_about(
            "barrelman starts this program, in a process of its own, for each video that its built-in engine does not read or decode, \
             and for the annotated video that other programs read. It is not started by hand.",
        )
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "a test reads the files that it had written")]
mod tests {

    use super::*;

    /// A new folder with all files, removed at the end.
    struct Written(std::path::PathBuf);

    impl Written {
        fn new(name: &str) -> Self {
            let folder =
                std::env::temp_dir().join(format!("barrelman-manuals-{name}-{}", std::process::id()));
            write(&folder).unwrap();
            Self(folder)
        }

        fn text(&self, file: &str) -> String {
            let bytes = std::fs::read(self.0.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
            String::from_utf8(bytes).unwrap()
        }
    }

    impl Drop for Written {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    /// The names of the commands, as the user types them.
    fn commands() -> Vec<String> {
        let names: Vec<_> =
            Cli::command().get_subcommands().map(|command| command.get_name().to_owned()).collect();
        assert!(names.contains(&"run".to_owned()) && names.contains(&"demo".to_owned()), "{names:?}");
        names
    }

    #[test]
    fn every_command_has_a_manual_page_that_the_page_of_the_program_names() {
        let written = Written::new("pages");
        let program = written.text("barrelman/barrelman.1");
        for command in commands() {
            assert!(program.contains(&format!("barrelman\\-{command}(1)")), "{command}: not in {program}");
            let page = written.text(&format!("barrelman/barrelman-{command}.1"));
            assert!(page.contains(&format!("\\fBbarrelman {command}\\fR")), "{command}: {page}");
        }
        for (page, word) in [
            ("barrelman/barrelman-guard.1", "zeros"),
            ("barrelman-media/barrelman-media.1", "GStreamer"),
            ("barrelman-ros2/barrelman-ros2.1", "rmw_cyclonedds_cpp"),
        ] {
            assert!(written.text(page).contains(word), "{page}");
        }
    }

    #[test]
    fn every_shell_completes_every_command() {
        let written = Written::new("shells");
        for file in ["barrelman-ros2.bash", "barrelman-ros2.fish", "_barrelman-ros2"] {
            assert!(written.text(file).contains("dds-address"), "{file}");
        }
        for command in commands() {
            for (file, line) in [
                ("barrelman.bash", format!("barrelman,{command})")),
                ("barrelman.fish", format!("-a \"{command}\"")),
                ("_barrelman", format!("({command})")),
            ] {
                assert!(written.text(file).contains(&line), "{file} does not complete {command}");
            }
        }
    }
}

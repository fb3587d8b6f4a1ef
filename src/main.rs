use std::process::ExitCode;

fn main() -> ExitCode {
    phototaxis::cli::run()
}

//! What compilers made of loops over lanes, for tests: a loop that is no longer made of vector instructions gives the same numbers,
//! only slower, so that no other test would notice.

use std::path::Path;
use std::process::Command;

/// Arithmetic of floating-point numbers in a function.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Arithmetic {
    /// Instructions that work on several numbers at once.
    pub(crate) packed: usize,
    /// Instructions that work on one.
    pub(crate) scalar: usize,
}

/// A function of this test's own program, by the parts that its name has.
pub(crate) struct Function {
    pub(crate) name: String,
    pub(crate) arithmetic: Arithmetic,
}

/// All functions whose names have these `parts`. `None`, said aloud, where nothing can be told: of builds that are not optimised or
/// for processors without AVX-512, and where there is no `objdump`.
pub(crate) fn functions(parts: &[&str]) -> Option<Vec<Function>> {
    let optimised = !cfg!(debug_assertions) && matches!(env!("PHOTOTAXIS_OPT_LEVEL"), "2" | "3");
    if !optimised || !cfg!(target_feature = "avx512vl") || !cfg!(target_os = "linux") {
        eprintln!("SKIPPED: whether loops run in vectors can be told of optimised builds for AVX-512 on Linux only");
        return None;
    }
    let program = std::env::current_exe().expect("a test knows its program");
    let Some(symbols) = objdump(&program, &["--syms".into()]) else {
        eprintln!("SKIPPED: no objdump to see whether loops run in vectors (Debian: binutils)");
        return None;
    };
    Some(symbols.lines().filter_map(|line| function(&program, line, parts)).collect())
}

/// The function of a line of the symbol table: place, flags and section; then size, perhaps visibility, and name.
fn function(program: &Path, line: &str, parts: &[&str]) -> Option<Function> {
    let (place, rest) = line.split_once('\t')?;
    let (start, flags) = place.split_once(' ')?;
    let (size, name) = (rest.split_whitespace().next()?, rest.split_whitespace().last()?);
    if !parts.iter().all(|part| name.contains(part)) || !flags.contains(" F ") {
        return None;
    }
    let [start, size] = [start, size].map(|number| u64::from_str_radix(number, 16).ok());
    let (start, end) = (start?, start? + size?);
    let (from, to) = (format!("--start-address={start:#x}"), format!("--stop-address={end:#x}"));
    let text = objdump(program, &["--disassemble".into(), "--no-show-raw-insn".into(), from, to])?;
    Some(Function { name: name.to_string(), arithmetic: counted(&text) })
}

fn counted(text: &str) -> Arithmetic {
    let mut counts = Arithmetic::default();
    for line in text.lines() {
        let Some(instruction) = line.split_once(':').and_then(|(_, rest)| rest.split_whitespace().next()) else {
            continue;
        };
        let operation = instruction.strip_prefix('v').unwrap_or(instruction);
        let Some((operation, kind)) = operation.split_at_checked(operation.len().saturating_sub(2)) else { continue };
        if ["add", "sub", "mul", "div", "sqrt", "min", "max"].contains(&operation) {
            counts.packed += matches!(kind, "ps" | "pd") as usize;
            counts.scalar += matches!(kind, "ss" | "sd") as usize;
        }
    }
    counts
}

fn objdump(program: &Path, arguments: &[String]) -> Option<String> {
    let output = Command::new("objdump").args(arguments).arg(program).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

#[test]
fn instructions_are_told_apart() {
    let text = "  10:\tvaddps %ymm0,%ymm1,%ymm2\n  14:\tvmulss (%rax),%xmm0,%xmm1\n  18:\tvsqrtps %zmm0,%zmm1\n  1c:\tret\n\
                  20:      \tmulsd\t%xmm0, %xmm1\n  24:\tvmovss %xmm0,(%rax)\n  28:\tvdivpd %ymm0,%ymm1,%ymm2\nfunction:\n";
    let counts = counted(text);
    assert_eq!((counts.packed, counts.scalar), (3, 2));
}

//! Makes the Rust declarations of Embree's C API from the headers that the system has, and asks git which commit this is.
//!
//! Embree 4 is taken where it is found, else Embree 3. `EMBREE_DIR` names the root of any other
//! install (`include/embree4/rtcore.h` and `lib/libembree4.so` below it).

use std::path::{Path, PathBuf};
use std::process::Command;

const ADVICE: [&str; 3] = [
    "Phototaxis needs Embree 3.13 or 4, headers and library, and libclang to read the headers.",
    "On Debian or Ubuntu: apt-get install libembree-dev libclang-dev",
    "For an Embree elsewhere, set EMBREE_DIR to the folder that holds its include/ and lib/.",
];

struct Embree {
    major: u32,
    root: PathBuf,
}

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=EMBREE_DIR");
    println!("cargo::rerun-if-env-changed=LIBCLANG_PATH");
    println!("cargo::rustc-check-cfg=cfg(embree3)");
    println!("cargo::rustc-check-cfg=cfg(embree4)");

    let embree = find_embree();
    // The version is in there: after an upgrade of the system's Embree the declarations are made again.
    let config = header(&embree.root, embree.major).with_file_name("rtcore_config.h");
    println!("cargo::rerun-if-changed={}", config.display());
    println!("cargo::rustc-cfg=embree{}", embree.major);
    link(&embree);
    generate(&embree);
    name_commit();
    // Tests that look at instructions ask how far the program was optimised.
    println!("cargo::rustc-env=PHOTOTAXIS_OPT_LEVEL={}", std::env::var("OPT_LEVEL").unwrap_or_default());
}

/// Sets PHOTOTAXIS_COMMIT to the commit that this folder is at, with `-dirty` where what the program is made of has been
/// changed since. Without git, or outside of a repository of its own (unpacked below another), nothing is set.
fn name_commit() {
    // With these the script runs again, and asks again, whenever the answer may be another.
    ["src", "Cargo.toml", "Cargo.lock"].iter().for_each(|path| println!("cargo::rerun-if-changed={path}"));
    let own = std::env::current_dir().and_then(|folder| folder.canonicalize()).ok();
    let top = git(&["rev-parse", "--show-toplevel"]).and_then(|path| PathBuf::from(path).canonicalize().ok());
    if top.is_none() || top != own {
        return;
    }
    for file in ["HEAD", "logs/HEAD"] {
        let path = git(&["rev-parse", "--git-path", file]).filter(|path| Path::new(path).exists());
        path.iter().for_each(|path| println!("cargo::rerun-if-changed={path}"));
    }
    let changed = git(&["status", "--porcelain", "--", "src", "build.rs", "Cargo.toml", "Cargo.lock"]);
    if let Some(commit) = git(&["rev-parse", "--short=12", "HEAD"]) {
        let dirty = if changed.is_none_or(|files| !files.is_empty()) { "-dirty" } else { "" };
        println!("cargo::rustc-env=PHOTOTAXIS_COMMIT={commit}{dirty}");
    }
}

/// What git prints; `None` where it fails, or is not there.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").arg("--no-optional-locks").args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_string())
}

fn find_embree() -> Embree {
    let roots = match std::env::var_os("EMBREE_DIR") {
        Some(dir) => vec![PathBuf::from(dir)],
        None => vec![PathBuf::from("/usr"), PathBuf::from("/usr/local")],
    };
    let has_header = |root: &Path, major: u32| header(root, major).is_file();
    let found = [4, 3].into_iter().find_map(|major| {
        let root = roots.iter().find(|root| has_header(root, major))?;
        Some(Embree { major, root: root.clone() })
    });
    found.unwrap_or_else(|| {
        let places: Vec<String> = roots.iter().map(|root| root.join("include").display().to_string()).collect();
        fail(&format!("neither embree4/rtcore.h nor embree3/rtcore.h is in {}", places.join(" or ")))
    })
}

fn header(root: &Path, major: u32) -> PathBuf {
    root.join(format!("include/embree{major}/rtcore.h"))
}

fn link(embree: &Embree) {
    let name = format!("embree{}", embree.major);
    let own = std::env::var_os("EMBREE_DIR").is_some();
    let library_dir = ["lib", "lib64"]
        .map(|lib| embree.root.join(lib))
        .into_iter()
        .find(|dir| dir.join(format!("lib{name}.so")).exists());
    match library_dir {
        Some(dir) if own => {
            println!("cargo::rustc-link-search=native={}", dir.display());
            println!("cargo::rustc-link-arg=-Wl,-rpath,{}", dir.display());
        }
        None if own => fail(&format!("lib{name}.so was not found below {}", embree.root.display())),
        // A system library lies on the linker's own path (Debian: /usr/lib/<triplet>).
        _ => {}
    }
    println!("cargo::rustc-link-lib=dylib={name}");
}

fn generate(embree: &Embree) {
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR")).join("embree.rs");
    let builder = bindgen::Builder::default()
        .header(header(&embree.root, embree.major).display().to_string())
        .clang_arg(format!("-I{}", embree.root.join("include").display()))
        .allowlist_function("rtc.*")
        .allowlist_type("RTC.*")
        .allowlist_var("RTC_.*")
        // A newer library may return enumerators that these headers lack: in a Rust enum that would be undefined behaviour.
        .default_enum_style(bindgen::EnumVariation::Consts)
        .prepend_enum_name(false)
        .derive_default(true)
        .merge_extern_blocks(true)
        .generate_comments(false);
    // bindgen panics where libclang is missing; what it says then is told in `fail`, without a backtrace.
    std::panic::set_hook(Box::new(|_| ()));
    let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| builder.generate()));
    drop(std::panic::take_hook());
    match result {
        Ok(Ok(bindings)) => bindings.write_to_file(out).expect("OUT_DIR is writable"),
        Ok(Err(error)) => fail(&format!("rtcore.h could not be read: {error}")),
        Err(panic) => fail(panic.downcast_ref::<String>().map_or("bindgen gave up", String::as_str)),
    }
}

/// Stops the build: cargo fails for the sake of `cargo::error`, and then shows these lines only.
fn fail(why: &str) -> ! {
    why.lines().chain(ADVICE).for_each(|line| println!("cargo::error={line}"));
    std::process::exit(0)
}

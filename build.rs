//! Makes the Rust declarations of Embree's C API from the headers that the system has.
//!
//! Embree 4 is taken where it is found, else Embree 3. `EMBREE_DIR` names the root of any other
//! install (`include/embree4/rtcore.h` and `lib/libembree4.so` below it).

use std::path::{Path, PathBuf};

const MISSING: &str = "\n\nPhototaxis needs Embree's headers and library, and libclang to read the headers.\n\
    On Debian or Ubuntu:\n\n    apt-get install libembree-dev libclang-dev\n\n\
    For an Embree elsewhere, set EMBREE_DIR to the folder that holds its include/ and lib/.\n";

struct Embree {
    major: u32,
    root: PathBuf,
}

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=EMBREE_DIR");
    println!("cargo::rustc-check-cfg=cfg(embree3)");
    println!("cargo::rustc-check-cfg=cfg(embree4)");

    let Some(embree) = find_embree() else {
        fail("embree4/rtcore.h and embree3/rtcore.h were not found");
    };
    println!("cargo::rustc-cfg=embree{}", embree.major);
    link(&embree);
    generate(&embree);
}

fn find_embree() -> Option<Embree> {
    let roots = match std::env::var_os("EMBREE_DIR") {
        Some(dir) => vec![PathBuf::from(dir)],
        None => vec![PathBuf::from("/usr"), PathBuf::from("/usr/local")],
    };
    let has_header = |root: &Path, major: u32| header(root, major).is_file();
    [4, 3].into_iter().find_map(|major| {
        let root = roots.iter().find(|root| has_header(root, major))?;
        Some(Embree { major, root: root.clone() })
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
    // bindgen panics where libclang is missing.
    match std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| builder.generate())) {
        Ok(Ok(bindings)) => bindings.write_to_file(out).expect("OUT_DIR is writable"),
        Ok(Err(error)) => fail(&format!("bindgen could not read rtcore.h: {error}")),
        Err(_) => fail("libclang was not found"),
    }
}

fn fail(why: &str) -> ! {
    println!("cargo::error={}", format!("{why}{MISSING}").replace('\n', " "));
    eprintln!("{why}{MISSING}");
    std::process::exit(1)
}

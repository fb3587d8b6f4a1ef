# Two commands for a fresh Debian machine:
#   make demo   installs what is missing, builds, renders scenes/door.toml with the guide on
#   make test   runs all tests
# and one to give away what was built:
#   make portable   builds out/phototaxis, which runs on any x86-64 and uses what it finds
# and two for those who keep it:
#   make install     puts the program, its manual and its completions below PREFIX (/usr/local); DESTDIR goes before it
#   make uninstall   takes them away again
# and one for Blender:
#   make blender-addon   packs out/phototaxis-blender.zip, which Blender installs; needs no Blender

# All but `make portable` and `make blender-addon` build for the processor at hand. Rust never fuses a product and a sum by itself, so what the program
# computes is the same at every level. A RUSTFLAGS that is set, be it empty, is respected.
RUSTFLAGS ?= -Ctarget-cpu=native
export RUSTFLAGS

SHELL := /bin/bash
CARGO := $(shell command -v cargo || echo $$HOME/.cargo/bin/cargo)
SUDO := $(shell [ "$$(id -u)" = 0 ] || echo sudo)
HEADERS := $(wildcard $(EMBREE_DIR)/include/embree[34]/rtcore.h /usr/include/embree[34]/rtcore.h /usr/local/include/embree[34]/rtcore.h)
LIBCLANG := $(wildcard $(foreach dir,$(LIBCLANG_PATH) /usr/lib/llvm-*/lib /usr/lib/*-linux-gnu,$(dir)/libclang.so* $(dir)/libclang-[0-9]*.so*))
STDDEF := $(wildcard /usr/lib/llvm-*/lib/clang/*/include/stddef.h)
FETCHER := $(or $(wildcard $(CARGO)),$(shell command -v curl))
RUST := $(shell sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)

# The levels of x86-64: v3 has AVX2 (most machines there are), v4 AVX-512, where packets of rays are native to Embree; v2 has
# rounding and blending of vectors, for processors of 2008 to 2013; the first is for all others.
LEVELS := x86-64 x86-64-v2 x86-64-v3 x86-64-v4

.PHONY: demo build lab figures figures-quick portable install uninstall blender-addon test check setup

# What is installed, and where: PROGRAM is what `make build`, `make lab` or `make portable` has made.
PROGRAM ?= $(or $(CARGO_TARGET_DIR),target)/release/phototaxis
LAB := $(or $(CARGO_TARGET_DIR),target)/release/phototaxis
PREFIX ?= /usr/local
BIN := $(DESTDIR)$(PREFIX)/bin
MAN := $(DESTDIR)$(PREFIX)/share/man/man1
BASH_COMPLETION := $(DESTDIR)$(PREFIX)/share/bash-completion/completions/phototaxis
ZSH_COMPLETION := $(DESTDIR)$(PREFIX)/share/zsh/site-functions/_phototaxis
FISH_COMPLETION := $(DESTDIR)$(PREFIX)/share/fish/vendor_completions.d/phototaxis.fish

demo: build
	mkdir -p out
	target/release/phototaxis render scenes/door.toml --time 20 -o out/door.exr -o out/door.png
	@echo "The picture is out/door.png; all layers are in out/door.exr."

build: setup
	$(CARGO) build --release --locked

# The program with its laboratory: bench, compare, generate, paper, rates.
lab: setup
	$(CARGO) build --release --locked --features lab

# Every picture, chart and table of README and docs anew, from this build; docs/results.md says how long it takes. `make figures
# FIGURES="--only results --runs 3"` does less of it, and `make figures-quick` all of it with tiny budgets, into another folder.
figures: lab
	$(LAB) figures $(FIGURES)

figures-quick: lab
	mkdir -p out/figures-quick/docs && cp docs/*.md out/figures-quick/docs
	$(LAB) figures --quick --work out/figures-quick/work --output out/figures-quick/docs $(FIGURES)

portable: setup
	CARGO="$(CARGO)" launcher/build out/phototaxis portable $(LEVELS)

# Builds nothing, so that no compiler runs as root.
install:
	@test -x $(PROGRAM) || { echo "$(PROGRAM) is missing: make build makes it" >&2; exit 1; }
	install -D -m 755 $(PROGRAM) $(BIN)/phototaxis
	install -d $(MAN) $(dir $(BASH_COMPLETION) $(ZSH_COMPLETION) $(FISH_COMPLETION))
	$(PROGRAM) man --output $(MAN)
	$(PROGRAM) completions bash >$(BASH_COMPLETION)
	$(PROGRAM) completions zsh >$(ZSH_COMPLETION)
	$(PROGRAM) completions fish >$(FISH_COMPLETION)
	chmod 644 $(MAN)/phototaxis*.1 $(BASH_COMPLETION) $(ZSH_COMPLETION) $(FISH_COMPLETION)

uninstall:
	rm -f $(BIN)/phototaxis $(MAN)/phototaxis.1 $(MAN)/phototaxis-*.1 $(BASH_COMPLETION) $(ZSH_COMPLETION) $(FISH_COMPLETION)

blender-addon:
	python3 addons/blender/pack.py out/phototaxis-blender.zip

# What tests skip they say, and cargo would keep it to itself. Link-time optimisation makes the program 8 % faster, and would be done
# anew for each of the programs that tests consist of.
test: setup
	CARGO_PROFILE_RELEASE_LTO=off $(CARGO) test --release --locked --features lab -- --show-output

check: setup
	$(CARGO) fmt --check
	$(CARGO) clippy --release --locked --all-targets --features lab -- -D warnings
	$(CARGO) clippy --release --locked -- -D warnings

# Embree, libclang (bindgen reads Embree's headers with it), a linker and Rust, each only where it is missing.
setup:
ifeq (,$(and $(HEADERS),$(LIBCLANG),$(STDDEF),$(shell command -v cc),$(FETCHER)))
	$(SUDO) apt-get update
	$(SUDO) apt-get install -y --no-install-recommends libembree-dev libclang-dev gcc libc6-dev ca-certificates curl
endif
ifeq (,$(wildcard $(CARGO)))
	@echo "Rust is missing: installing it with rustup (https://rustup.rs) into $$HOME/.cargo"
	curl --proto '=https' --tlsv1.2 -sSf https://sh.rustup.rs | sh -s -- -y --profile minimal --component rustfmt --component clippy
endif
	@found=$$($(CARGO) --version | cut -d' ' -f2); printf '%s\n' $(RUST) "$$found" | sort -VC || \
		{ echo "Rust $(RUST) or newer is needed, $(CARGO) is $${found:-broken}. With rustup: rustup update stable" >&2; exit 1; }

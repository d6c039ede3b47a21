//! What each crate that a manifest of ours names is there for.

/// Crate, and what it does here that the standard library or a few lines would not.
pub(super) const WHY: &[(&str, &str)] = &[
    ("arbitrary", "draws robots from the bytes of a fuzzer"),
    (
        "astro-float",
        "sines of 200 bits, which tests measure ours against",
    ),
    ("bytes", "the slices that the Parquet reader takes"),
    ("clap", "options of the command line, their help and errors"),
    ("clap_complete", "`sesc completions`"),
    ("clap_mangen", "`sesc man`"),
    ("criterion", "times of benches"),
    ("csv", "posture logs as text"),
    ("faer", "a peer that benches of least squares compare with"),
    ("flate2", "gzip; decoded in Rust by miniz_oxide"),
    ("glob", "patterns of log names"),
    ("indicatif", "progress on a terminal"),
    ("libfuzzer-sys", "the fuzzer"),
    (
        "libm",
        "one sine for every machine, where code is generated",
    ),
    (
        "lz4_flex",
        "chunks of MCAP and pages of Parquet packed with LZ4",
    ),
    ("memchr", "ends of lines in text"),
    (
        "minijinja",
        "templates of generated C and of report pages, which escape names in HTML",
    ),
    (
        "nalgebra",
        "small matrices, QR, SVD and symmetric eigenvalues",
    ),
    ("numpy", "arrays of the Python package"),
    ("parquet", "logs of data frames and tables of fleets"),
    ("parry3d-f64", "self-collision of planned postures"),
    ("prettyplease", "layout of generated Rust"),
    ("proc-macro2", "tokens of generated Rust"),
    (
        "public-api",
        "lists of public items from what rustdoc knows",
    ),
    ("pyo3", "the Python package"),
    ("quote", "generated Rust is written as Rust"),
    ("rand", "seeded draws of postures and noise"),
    (
        "rand_chacha",
        "a generator with the same numbers on every machine",
    ),
    ("rand_distr", "Gaussian noise"),
    ("rayon", "studies and long tests on all cores"),
    (
        "roxmltree",
        "XML of URDFs, with the place of each element for error messages",
    ),
    ("rustc-hash", "tables of the nodes of a program"),
    ("ruzstd", "chunks of MCAP packed with zstd; decoded in Rust"),
    ("serde", "files and results as types"),
    ("serde_json", "results as JSON; numbers to the last bit"),
    ("signal-hook", "Ctrl-C and SIGTERM leave no temporary file"),
    ("statrs", "quantiles of χ², F and Student's t"),
    (
        "strsim",
        "\"did you mean\" for names of links, joints and columns",
    ),
    (
        "syn",
        "generated Rust is parsed before it is printed; tables of keys are read from types",
    ),
    ("tempfile", "folders of tests"),
    ("terminal_size", "tables as wide as the terminal"),
    ("thiserror", "error enums with a sentence each"),
    ("toml", "model files, priors, settings and sidecars"),
    (
        "twox-hash",
        "XXH64 of logs, by which results name what they were made of",
    ),
    ("urdf-rs", "numbers of URDFs as other programs read them"),
];

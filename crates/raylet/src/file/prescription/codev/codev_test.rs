//! Scratch.
use std::fs;
use std::path::Path;
use crate::file::prescription::import::{ImportChoices, import_bytes};
#[test]
fn survey() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/prescriptions");
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).filter(|p| p.extension().is_some_and(|e| e == "seq")).collect();
    files.sort();
    let mut out = String::new();
    for file in files {
        let bytes = fs::read(&file).unwrap();
        out += &format!("=== {}\n", file.file_name().unwrap().to_string_lossy());
        match import_bytes(&bytes, &file, &ImportChoices::default()) {
            Ok(lens) => out += &format!("{}\n", lens.report),
            Err(fault) => out += &format!("{fault}\n"),
        }
    }
    fs::write("/tmp/survey.txt", out).unwrap();
}

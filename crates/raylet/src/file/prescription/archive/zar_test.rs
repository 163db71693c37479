//! Tests: archives byte by byte, their lenses, glasses and faults.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use crate::file::prescription::archive::zar_archive::Archive;
use crate::file::prescription::archive::zar_writer::{block, block_of, packed_run};
use crate::file::prescription::import::{ImportChoices, ImportedLens, import_bytes, import_lens};
use crate::file::prescription::optiland_test::folder;
use crate::file::scene::element::Element;
use crate::file::scene::material::Material;

/// A singlet of a glass that no catalogue of raylet has.
pub(super) const LENS: &str = "MODE SEQ\nUNIT MM X W X CM MR CPMM\nENPD 2\nGCAT OTHER MINE\nFTYP 0 0 1 1\nXFLN 0\nYFLN 0\n\
    WAVM 1 0.5 1\nPWAV 1\nSURF 0\n  DISZ INFINITY\nSURF 1\n  STOP\n  CURV 0.05\n  DISZ 3\n  GLAS HOUSE 0 0 1.5 40\n  DIAM 2 1\n\
    SURF 2\n  DISZ 40\n  DIAM 2 1\nSURF 3\n  DISZ 0\n";

/// A catalogue with a glass of the same index at every wavelength.
pub(super) fn catalogue(index: f64) -> String {
    let square = index * index;
    format!("CC test\nNM HOUSE 1 0 0 0\nCD {square} 0 0 0 0 0\nLD 0.4 0.8\n")
}

pub(super) fn archive(version: u32, files: &[(&str, &[u8])]) -> Vec<u8> {
    let blocks = files
        .iter()
        .map(|(name, content)| block(version, name, content));
    blocks.collect::<Vec<_>>().concat()
}

fn imported(bytes: &[u8]) -> ImportedLens {
    let lens = import_bytes(bytes, Path::new("a.zar"), &ImportChoices::default());
    lens.unwrap_or_else(|fault| panic!("{fault}"))
}

#[track_caller]
fn refused(bytes: &[u8], start: &str) {
    let lens = import_bytes(bytes, Path::new("a.zar"), &ImportChoices::default());
    let message = lens.unwrap_err().to_string();
    assert!(message.starts_with(start), "{message}");
}

/// The index of the first surface's glass at 0.5 µm.
fn index(lens: &ImportedLens) -> f64 {
    let surface = lens.scene.element.iter().find_map(|element| match element {
        Element::Surface(surface) => Some(surface),
        _ => None,
    });
    let surface = surface.unwrap();
    let Some(Material::Own(own)) = &surface.glass else {
        panic!("{:?}", surface.glass);
    };
    own.medium().unwrap().index(0.5e-3).unwrap()
}

#[test]
fn a_lens_comes_with_the_glasses_of_its_archive() {
    let [mine, other, third] = [1.7, 1.6, 1.5].map(catalogue);
    for version in [1002, 1004] {
        // Catalogues come in the order in which the lens names them, whatever their order in the archive.
        let bytes = archive(
            version,
            &[
                ("lens.ZMX.LZW", LENS.as_bytes()),
                ("COATING.DAT.LZW", b"not used"),
                ("third.agf", third.as_bytes()),
                ("MINE.AGF.LZW", mine.as_bytes()),
                ("C:\\glass\\other.agf.lzw", other.as_bytes()),
            ],
        );
        let lens = imported(&bytes);
        assert!((index(&lens) - 1.6).abs() < 1e-9, "{}", index(&lens));
        let report = lens.report.to_string();
        for sentence in [
            "The lens is lens.ZMX of the archive a.zar, and glasses of third.agf, MINE.AGF, other.agf come first.",
            "Glass HOUSE: line 2 of other.agf, by its formula Schott",
            "Files of the archive that are not used: COATING.DAT.",
        ] {
            assert!(report.contains(sentence), "{report}");
        }
    }
}

/// Every file of the folder of examples is the same lens inside an archive.
#[test]
fn lenses_are_the_same_inside_and_outside() {
    for name in ["lens1.zmx", "US08011793-1.zmx", "ACL3026U-Zemax(ZMX).zmx"] {
        let path = folder().join(name);
        let outside = import_lens(&path, &ImportChoices::default()).unwrap();
        let content = fs::read(&path).unwrap();
        let packed = format!("{name}.LZW");
        for version in [1002, 1004] {
            for name in [name, &packed] {
                let inside = imported(&archive(version, &[(name, content.as_slice())]));
                assert_eq!(inside.scene, outside.scene, "{name}");
            }
        }
    }
}

/// Headers by hand, so that the layout stands in a test twice.
#[test]
fn files_stand_behind_their_headers() {
    let mut bytes = vec![0u8; 332];
    bytes[..4].copy_from_slice(&[0xea, 3, 0, 0]);
    bytes[12] = 3;
    bytes[32..37].copy_from_slice(b"a.txt");
    bytes.extend(b"abc");
    let mut second = vec![0u8; 648];
    second[..4].copy_from_slice(&[0xec, 3, 0, 0]);
    (second[16], second[24]) = (2, 2);
    second[48..58].copy_from_slice(b"b\0.\0d\0a\0t\0");
    bytes.extend(second);
    bytes.extend(b"de");
    let mut archive = Archive::open(Cursor::new(&bytes), Path::new("a.zar")).unwrap();
    assert_eq!(archive.names().collect::<Vec<_>>(), ["a.txt", "b.dat"]);
    let (path, text) = archive.file(1).unwrap();
    assert_eq!(
        (path.as_path(), text.as_slice()),
        (Path::new("a.zar/b.dat"), &b"de"[..])
    );
    assert_eq!(archive.file(0).unwrap().1, b"abc");
    assert!(archive.file(2).is_err());
}

#[test]
fn faults_name_the_archive_and_the_file() {
    let lens = ("a.zmx", LENS.as_bytes());
    refused(
        b"",
        "a.zar: found 0 bytes, expected an archive of OpticStudio",
    );
    refused(
        b"\n<!DOCTYPE html><html>",
        "a.zar: found a web page (HTML), expected an archive",
    );
    refused(
        b"PK\x03\x04rest",
        "a.zar: found a ZIP file, expected an archive",
    );
    refused(
        &[0xeb, 3, 0, 0, 0],
        "a.zar: found a header of version 1003, expected",
    );
    let good = archive(1004, &[lens]);
    let tail = [good.as_slice(), &[1, 2, 3]].concat();
    let start = format!("a.zar: found 3 bytes, at byte {}, expected", good.len());
    refused(&tail, &start);
    let length = LENS.len();
    let start = format!(
        "a.zar: found a.zmx of {length} bytes where {} are left, expected",
        length - 1
    );
    refused(&good[..good.len() - 1], &start);
    refused(
        &good[..500],
        "a.zar: found a header of 500 bytes, expected 648 bytes",
    );
    refused(
        &archive(1002, &[("", b"a")]),
        "a.zar: found a file without a name",
    );
    refused(
        &archive(1002, &[("a.agf", b"a"), ("b.zos", b"b")]),
        "a.zar: found no lens file among a.agf, b.zos, expected one lens file of Zemax (.zmx)",
    );
    refused(
        &archive(1004, &[lens, ("b.ZMX", b"")]),
        "a.zar: found several lens files: a.zmx, b.ZMX, expected one",
    );
    refused(
        &archive(1004, &[("x/a.zmx", b"MODE NSC")]),
        "a.zar/a.zmx:1:",
    );
    refused(
        &archive(1004, &[lens, ("MINE.AGF", b"NM HOUSE 99\n")]),
        "a.zar/MINE.AGF:1:10: found a formula of number 99",
    );
}

/// A length that the header states and the file has not, and a code without a word.
#[test]
fn lengths_and_codes_that_do_not_fit_are_refused() {
    let length = LENS.len();
    let mut bytes = archive(1004, &[("a.zmx.lzw", LENS.as_bytes())]);
    bytes[24] ^= 1;
    let start = format!(
        "a.zar/a.zmx: found {length} bytes, expected {} bytes, as its header states",
        length ^ 1
    );
    refused(&bytes, &start);
    let mut bytes = archive(1002, &[("a.zmx.lzw", LENS.as_bytes())]);
    bytes[332..340].fill(0xff);
    refused(
        &bytes,
        "a.zar/a.zmx: found code 511 behind 0 unpacked bytes",
    );
}

/// A lens of 10 kB in the archive would have 20 MB and more.
#[test]
fn what_grows_too_large_is_refused() {
    let (codes, length) = (6325, 6325 * 6326 / 2);
    let packed = packed_run(codes);
    let stated = block_of(1004, "a.zmx.lzw", &packed, length);
    refused(&stated, "a.zar/a.zmx: found a file larger than 20 MB");
    let hidden = block_of(1004, "a.zmx.lzw", &packed, 1000);
    let start = "a.zar/a.zmx: found a file that is unpacked to more than 20000000 bytes";
    refused(&hidden, start);
}

/// Six catalogues of 19 MB are more than all files together may have.
#[test]
fn all_files_together_have_a_limit_slow() {
    let catalogue = block_of(1002, "a.agf.lzw", &packed_run(6163), 0);
    let mut bytes = archive(1004, &[("a.zmx", LENS.as_bytes())]);
    (0..6).for_each(|_| bytes.extend(&catalogue));
    let start = "a.zar/a.agf: found a file that is unpacked to more than 50";
    refused(&bytes, start);
}

#[test]
fn black_boxes_are_said_and_refused() {
    let text = LENS.replace("  CURV 0.05\n", "  TYPE BLACKBOX\n  COMM lens.zbb\n");
    let bytes = archive(1004, &[("a.zmx", text.as_bytes()), ("lens.zbb", b"secret")]);
    refused(
        &bytes,
        "a.zar/a.zmx:14:3: found a black box, whose file (.zbb) is encrypted, on surface 1, expected surfaces whose shapes",
    );
}

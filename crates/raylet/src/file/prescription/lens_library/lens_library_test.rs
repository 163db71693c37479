//! Tests: the catalogue, and folders of lens files.

use std::fs;
use std::path::Path;

use crate::file::prescription::import::ImportChoices;
use crate::file::prescription::lens_library::lens_catalog::{catalog_lens, lenses};
use crate::file::prescription::lens_library::lens_folder::{LensFolder, LensSearch};
use crate::file::prescription::optiland_test::folder;

#[test]
fn lenses_of_the_catalogue_have_the_focal_lengths_of_their_makers() {
    // Focal lengths and diameters in mm as the makers print them, and how far the files may be off.
    for (name, focal_length, within, diameter) in [
        ("32-327", 100.0, 0.1, 25.0),
        ("Edmund Optics 65564", 1.5, 0.01, 1.0),
        ("EO 65988", 15.0, 0.05, 12.0),
        ("49-663", 35.0, 0.05, 25.0),
        ("acl3026u", 26.5, 0.8, 30.0),
        ("LA1131-A", 50.0, 0.3, 25.4),
    ] {
        let lens = catalog_lens(name).unwrap();
        let facts = lens.facts().unwrap();
        let found = facts.focal_length_mm.unwrap();
        assert!((found - focal_length).abs() < within, "{name}: {facts:?}");
        assert!(
            (facts.diameter_mm - diameter).abs() < 1e-9,
            "{name}: {facts:?}"
        );
        assert_eq!(facts.maker.as_deref(), Some(lens.maker));
    }
    for lens in lenses() {
        let imported = lens.import(&ImportChoices::default()).unwrap();
        assert!(imported.scene.element.len() > 1, "{}", lens.part);
        // The bytes are those of the files that tests read, but for the table.
        if !lens.file.ends_with(".csv") {
            assert_eq!(fs::read(folder().join(lens.file)).unwrap(), lens.bytes());
        }
    }
    let error = catalog_lens("LA1131-B").unwrap_err();
    assert_eq!(error.nearest[0], "LA1131-A");
    assert!(error.to_string().contains("named 'LA1131-B'"));
}

#[test]
fn a_folder_lists_all_its_files_with_their_facts_or_faults() {
    let all = LensFolder::open(&folder(), None).unwrap();
    assert_eq!(all.lenses.len(), 52);
    let faults: Vec<(&Path, &str)> = all.faults().collect();
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert!(faults[0].0.ends_with("US08427765-1.ZMX"));
    assert!(faults.iter().all(|(_, fault)| fault.contains("glass")));

    let search = LensSearch {
        focal_length_mm: Some([90.0, 110.0]),
        text: Some("achromatic LENS".to_owned()),
        ..LensSearch::default()
    };
    let found = all.search(&search);
    assert_eq!(found.len(), 1, "{found:?}");
    let (path, facts) = found[0];
    assert!(path.ends_with("CODV_32327.seq"));
    assert!((facts.focal_length_mm.unwrap() - 100.03).abs() < 0.02);
    assert_eq!((facts.diameter_mm, facts.surfaces), (25.0, 3));
    let search = LensSearch {
        maker: Some("edmund".to_owned()),
        diameter_mm: Some([0.0, 100.0]),
        f_number: Some([0.0, 100.0]),
        ..LensSearch::default()
    };
    assert_eq!(all.search(&search).len(), 5);
}

#[test]
fn an_index_saves_reading_and_follows_changes() {
    let room = tempfile::tempdir().unwrap();
    let (lenses, index) = (room.path().join("lenses"), room.path().join("index.json"));
    fs::create_dir_all(lenses.join("deep/er")).unwrap();
    let copy = |from: &str, to: &str| fs::copy(folder().join(from), lenses.join(to)).unwrap();
    copy("CODV_32327.seq", "a.SEQ");
    copy("lens1.zmx", "deep/er/b.zmx");
    fs::write(lenses.join("broken.zmx"), "SURF 0\n").unwrap();
    fs::write(lenses.join("other.txt"), "nothing").unwrap();
    let first = LensFolder::open(&lenses, Some(&index)).unwrap();
    assert_eq!((first.lenses.len(), first.read), (3, 3));
    let second = LensFolder::open(&lenses, Some(&index)).unwrap();
    assert_eq!((second.read, &second.lenses), (0, &first.lenses));
    fs::remove_file(lenses.join("a.SEQ")).unwrap();
    copy("lens1.zmx", "broken.zmx");
    let third = LensFolder::open(&lenses, Some(&index)).unwrap();
    assert_eq!(
        (third.lenses.len(), third.read, third.faults().count()),
        (2, 1, 0)
    );

    // A folder that is not listed is a fault of its own: this one lies too deep.
    let deep = lenses.join("d/".repeat(42));
    fs::create_dir_all(&deep).unwrap();
    let fourth = LensFolder::open(&lenses, None).unwrap();
    let faults: Vec<(&Path, &str)> = fourth.faults().collect();
    assert_eq!((fourth.lenses.len(), faults.len()), (3, 1));
    assert!(faults[0].1.contains("41 folders deep"), "{}", faults[0].1);

    // A file that is no index is neither read nor replaced.
    let foreign = room.path().join("mine.json");
    fs::write(&foreign, "{}").unwrap();
    let fault = LensFolder::open(&lenses, Some(&foreign)).unwrap_err();
    assert!(fault.to_string().contains("mine.json"), "{fault}");
    assert!(LensFolder::open(&room.path().join("nowhere"), None).is_err());
}

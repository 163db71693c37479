//! Results whose writers are killed at any moment: the old one is whole, or the new one.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::file::storage::folder::{OutputFolder, RESULT_FILE};
use crate::file::storage::hidden::Exchange;
use crate::file::storage::parent_folders::exchange;
use crate::file::storage::seal::Sealed;

/// The folder of a writer in a process of its own, and whether folders change places there at one stroke.
const ROOM: &str = "RAYLET_TEST_KILLED_ROOM";
const STROKE: &str = "RAYLET_TEST_KILLED_STROKE";

/// Files of a result, and the size of the largest: a large field and many pictures.
const FILES: usize = 12;
const LARGEST: usize = 1 << 20;

/// Writes one result after another until it is killed: what the other test starts.
#[test]
#[ignore = "runs until it is killed"]
fn writer() {
    let Ok(room) = std::env::var(ROOM) else {
        return;
    };
    let by_stroke = std::env::var(STROKE).is_ok();
    let swap: Exchange = match by_stroke {
        true => &exchange,
        false => &|_, _| Ok(false),
    };
    let target = OutputFolder::claim(&Path::new(&room).join("out")).unwrap();
    for run in 0_u64.. {
        publish(&target, run, swap);
    }
}

/// A result whose every byte says which run it is of.
fn publish(target: &OutputFolder, run: u64, swap: Exchange) {
    let mut draft = target.draft().unwrap();
    for file in 0..FILES {
        let size = if file == 0 { LARGEST } else { LARGEST / 64 };
        let content = run.to_le_bytes().repeat(size / 8);
        draft.write(&format!("{file}.npy"), &content).unwrap();
    }
    draft
        .publish_by(swap, &format!("{{\"run\": {run}}}"))
        .unwrap();
}

/// Starts the writer.
fn start(room: &Path, by_stroke: bool) -> Child {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command
        .args(["--exact", "file::storage::killed_test::writer", "--ignored"])
        .env(ROOM, room)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    if by_stroke {
        command.env(STROKE, "yes");
    }
    command.spawn().unwrap()
}

/// Asserts that one whole result stands there, and nothing else.
fn assert_whole(out: &Path) {
    let sealed = Sealed::read(out, RESULT_FILE).expect("a document as it was written");
    assert_eq!(sealed.stranger(out).unwrap(), None);
    assert_eq!(fs::read_dir(out).unwrap().count(), FILES + 1);
    let text = fs::read_to_string(out.join(RESULT_FILE)).unwrap();
    let document: serde_json::Value = serde_json::from_str(&text).unwrap();
    let run = document["run"].as_u64().unwrap();
    for file in 0..FILES {
        let content = fs::read(out.join(format!("{file}.npy"))).unwrap();
        let mut words = content.as_chunks::<8>().0.iter();
        assert!(words.all(|word| *word == run.to_le_bytes()), "{file}");
    }
}

/// Looks as often as it can, for so long, whether there is no result; then at once.
fn is_absent(out: &Path, patience: Duration) -> bool {
    let clock = Instant::now();
    while out.exists() {
        if clock.elapsed() > patience {
            return false;
        }
    }
    true
}

/// Kills a writer so many times, at moments spread over some results, or where it is seen that there is none; looks at
/// what it leaves. Returns how often a draft was left, and how often there was no result for a moment.
fn kill(times: u32, by_stroke: bool) -> [u32; 2] {
    let room = tempfile::tempdir().unwrap();
    let out = room.path().join("out");
    publish(&OutputFolder::claim(&out).unwrap(), 0, &exchange);
    let mut counts = [0; 2];
    for time in 0..times {
        let mut writer = start(room.path(), by_stroke);
        let clock = Instant::now();
        let lock = room.path().join(".raylet-out.lock");
        while !lock.exists() && clock.elapsed() < Duration::from_secs(60) {
            sleep(Duration::from_millis(1));
        }
        // Golden steps fill the span of a few results evenly; a gap is waited for.
        let share = (f64::from(time) * 0.618_033_988_75).fract();
        let patience = if by_stroke { 0.06 * share } else { 0.4 };
        let was_absent = is_absent(&out, Duration::from_secs_f64(patience));
        writer.kill().unwrap();
        writer.wait().unwrap();
        let names = fs::read_dir(room.path()).unwrap();
        counts[0] += u32::from(names.count() > 2 - usize::from(!out.exists()));
        counts[1] += u32::from(was_absent);

        // In two steps the next start puts back what stood aside.
        if !by_stroke {
            drop(OutputFolder::claim(&out).unwrap());
        }
        assert_whole(&out);
    }

    // The next start removes everything that was left.
    drop(OutputFolder::claim(&out).unwrap());
    assert_eq!(fs::read_dir(room.path()).unwrap().count(), 1);
    counts
}

#[test]
fn killed_a_hundred_times_it_leaves_a_whole_result_slow() {
    let [drafts, gaps] = kill(100, true);
    assert!(drafts > 50, "{drafts} of 100 left a draft");
    assert_eq!(gaps, 0, "of 100 saw no result");
}

#[test]
fn in_two_steps_the_next_start_puts_it_back_slow() {
    let [drafts, gaps] = kill(25, false);
    assert!(
        drafts > 12 && gaps > 0,
        "of 25: {drafts} left a draft, {gaps} saw no result"
    );
}

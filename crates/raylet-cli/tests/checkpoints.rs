//! Forged and torn checkpoints: whatever their content, a design goes on from its own alone.

use std::fs;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use ndarray::Array2;
use serde_json::{Value, json};

use crate::stage::{SCENE, Stage, complaint};

/// What stands behind the small scene.
const DESIGN: &str = r#"
[hologram]
target = "picture.png"
element = "pixels"
size_mm = [0.05, 0.04]
[design]
iterations = 8
checkpoint = 4
"#;

/// By L-BFGS with a parameter of the system, by Adam, and by Adam with control variates.
const KINDS: [&str; 3] = [
    "[[design.variable]]\npath = \"element[1].thickness_mm\"\n",
    "optimizer = \"adam\"\n",
    "optimizer = \"adam\"\nestimator = { kind = \"control_variate\", each = 4, refresh = 3 }\n",
];

/// A scene whose design has left its checkpoints.
fn designed(more: &str) -> Stage {
    let few = SCENE
        .replace("phase.npy\"", "found.npy\"\nsize = [10, 10]")
        .replace("radius_mm = 0.09", "radius_mm = 0.03")
        .replace("[48, 40]", "[12, 10]");
    let stage = Stage::new(&format!("{few}{DESIGN}{more}"));
    let picture = Array2::from_shape_fn((8, 8), |(y, x)| f64::from(u8::from(x < 3 || y == 5)));
    let file = stage.join("picture.png");
    raylet::file::arrays::image::write_gray16(file, picture.view(), [0.0, 1.0]).unwrap();
    let run = stage.raylet(&["design", "scene.toml", "--out", "run"]);
    assert!(run.status.success(), "{}", complaint(&run));
    stage
}

/// What is done to a value of a checkpoint.
enum Forge {
    /// It is left out.
    Omit,
    /// It becomes another one.
    Set(Value),
    /// A list loses its last number.
    Cut,
    /// The first number of a list becomes this one.
    Put(f64),
    /// A number becomes this one.
    Bits(f64),
}

impl Forge {
    fn apply(&self, body: &mut Value, pointer: &str) {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        if let Forge::Omit = self {
            let parent = body.pointer_mut(parent).unwrap().as_object_mut().unwrap();
            assert!(parent.remove(key).is_some(), "{pointer}");
            return;
        }
        let value = body.pointer_mut(pointer);
        let value = value.unwrap_or_else(|| panic!("no {pointer}"));
        let list = |value: &Value| BASE64_STANDARD.decode(value.as_str().unwrap()).unwrap();
        *value = match self {
            Forge::Omit => return,
            Forge::Set(other) => other.clone(),
            Forge::Cut => {
                let bytes = list(value);
                json!(BASE64_STANDARD.encode(&bytes[..bytes.len() - 8]))
            }
            Forge::Put(number) => {
                let mut bytes = list(value);
                bytes[..8].copy_from_slice(&number.to_le_bytes());
                json!(BASE64_STANDARD.encode(bytes))
            }
            Forge::Bits(number) => json!(number.to_bits() as i64),
        };
    }
}

/// What no design leaves: the kind of design, the place in its checkpoint, and what is done there.
fn forgeries() -> Vec<(usize, String, Forge)> {
    use Forge::{Bits, Cut, Omit, Put, Set};
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    let mut list = Vec::new();

    // Lists of another length, and what is no number.
    let lists = [
        (0, "search/Lbfgs/point"),
        (0, "search/Lbfgs/base"),
        (0, "search/Lbfgs/gradient"),
        (0, "search/Lbfgs/direction"),
        (0, "search/Lbfgs/pairs/0/step"),
        (0, "search/Lbfgs/pairs/1/change"),
        (0, "search/Lbfgs/space/lower"),
        (0, "search/Lbfgs/space/upper"),
        (0, "search/Lbfgs/space/scale"),
        (0, "planned"),
        (1, "search/Descent/point"),
        (1, "search/Descent/first"),
        (1, "search/Descent/second"),
        (1, "search/Descent/best"),
        (2, "last_exact"),
    ];
    for (kind, path) in lists {
        list.extend([(kind, path, Cut), (kind, path, Put(nan))]);
    }
    list.extend([
        // Numbers out of their range.
        (0, "search/Lbfgs/point", Put(inf)),
        (0, "search/Lbfgs/space/scale", Put(-1.0)),
        (0, "search/Lbfgs/space/lower", Put(7.0)),
        (0, "search/Lbfgs/point", Put(1e300)),
        (0, "search/Lbfgs/direction", Put(1e300)),
        (0, "search/Lbfgs/gradient", Put(-1e300)),
        (0, "search/Lbfgs/value", Bits(1e300)),
        (0, "planned", Put(1e13)),
        (1, "search/Descent/first", Put(1e300)),
        (0, "search/Lbfgs/value", Bits(inf)),
        (0, "search/Lbfgs/value", Bits(nan)),
        (0, "search/Lbfgs/settings/memory", Set(json!(0))),
        (0, "search/Lbfgs/settings/first", Bits(nan)),
        (0, "search/Lbfgs/pairs/0/curvature", Bits(-1.0)),
        (0, "search/Lbfgs/pairs/0/square", Bits(0.0)),
        (0, "search/Lbfgs/search/trial", Bits(nan)),
        (0, "search/Lbfgs/search/most", Bits(-1.0)),
        (0, "search/Lbfgs/search/from", Bits(1e300)),
        (0, "search/Lbfgs/search/start/slope", Bits(1.0)),
        (
            0,
            "search/Lbfgs/search/trials",
            Set(json!(4_000_000_000_u32)),
        ),
        (0, "share", Bits(nan)),
        (0, "share", Bits(2.0)),
        (1, "search/Descent/second", Put(-1.0)),
        (1, "search/Descent/best_value", Bits(nan)),
        (1, "search/Descent/rule/Adam/beta1", Bits(1.0)),
        (1, "search/Descent/steps", Set(json!(1_000_000))),
        (1, "search/Descent/steps", Set(json!(-1))),
        (2, "last_exact", Set(json!(""))),
        // Counts that are none, and an end that is not there.
        (0, "search/Lbfgs/iteration", Set(json!(-3))),
        (0, "search/Lbfgs/iteration", Set(json!(u64::MAX))),
        (0, "evaluations", Set(json!(-1))),
        (0, "evaluations", Set(json!(0))),
        (0, "evaluations", Set(json!(1e300))),
        (0, "planned_after", Set(json!(100_000))),
        (0, "stop", Set(json!("Flat"))),
        (0, "stop", Set(json!("Enough"))),
        // Keys that are missing, and other kinds of values.
        (0, "search/Lbfgs/point", Omit),
        (0, "search/Lbfgs/space", Omit),
        (0, "search/Lbfgs/pairs", Omit),
        (0, "search", Omit),
        (0, "planned", Omit),
        (0, "search/Lbfgs/point", Set(json!("not base64!"))),
        (0, "search/Lbfgs/point", Set(json!([0.0, 1.0]))),
        (0, "search/Lbfgs/pairs", Set(json!(7))),
        (0, "search", Set(json!({ "Newton": {} }))),
        (0, "search", Set(json!(null))),
    ]);
    let mut list: Vec<(usize, String, Forge)> = list
        .into_iter()
        .map(|(kind, path, forge)| (kind, format!("/1/state/{path}"), forge))
        .collect();

    // The course, and the whole.
    let rows = [
        ("/1/rows/1/loss", Set(json!(null))),
        ("/1/rows/1/loss", Set(json!(1e300))),
        ("/1/rows/1/ncc", Set(json!(1e308))),
        ("/1/rows/1/loss", Omit),
        ("/1/rows/1/iteration", Set(json!(5000))),
        ("/1/rows/1/evaluations", Set(json!(-1))),
        ("/1/rows", Set(json!([]))),
        ("/1/rows", Omit),
        ("/1/state", Omit),
        ("/1", Set(json!(null))),
        ("/0", Set(json!("the scene of somebody else"))),
    ];
    list.extend(rows.map(|(path, forge)| (0, path.to_owned(), forge)));
    list
}

/// A checkpoint of this body, with the right checksum.
fn write(stage: &Stage, body: &Value) {
    let body = body.to_string();
    let text = format!("{:08x}\n{body}", crc32fast::hash(body.as_bytes()));
    fs::write(stage.join("run/checkpoint.json"), text).unwrap();
}

/// The body of the newest checkpoint.
fn body(stage: &Stage) -> Value {
    let text = fs::read_to_string(stage.join("run/checkpoint.json")).unwrap();
    serde_json::from_str(text.split_once('\n').unwrap().1).unwrap()
}

/// What is wrong with how a checkpoint is refused, if anything.
fn wrong(stage: &Stage, what: &str) -> Option<String> {
    let before = stage.names();
    let run = stage.raylet(&["design", "scene.toml", "--out", "run", "--resume"]);
    let message = complaint(&run);
    let fine = run.status.code() == Some(2)
        && message.starts_with("error: ")
        && message.matches("error:").count() == 1
        && message.contains("checkpoint.json: found ")
        && !message.contains("panicked")
        && stage.names() == before;
    (!fine).then(|| format!("{what}: {:?}, {message}", run.status.code()))
}

#[test]
fn forged_checkpoints_are_refused() {
    let stages = KINDS.map(designed);
    let genuine = [0, 1, 2].map(|kind: usize| body(&stages[kind]));
    let list = forgeries();
    assert!(list.len() >= 68, "{}", list.len());
    let mut all = Vec::new();
    for (kind, pointer, forge) in &list {
        let mut forged = genuine[*kind].clone();
        forge.apply(&mut forged, pointer);
        write(&stages[*kind], &forged);
        all.extend(wrong(&stages[*kind], pointer));
    }

    // The state of another method under this one's name, and texts that are no checkpoint.
    let mut other = genuine[1].clone();
    other[0] = genuine[0][0].clone();
    for whole in [other, json!([]), json!({}), json!(7), json!("text")] {
        write(&stages[0], &whole);
        all.extend(wrong(&stages[0], "another text"));
    }
    assert!(all.is_empty(), "{}", all.join("\n"));

    // What was forged is the only thing that was wrong.
    for (stage, genuine) in stages.iter().zip(&genuine) {
        write(stage, genuine);
        let run = stage.raylet(&["design", "scene.toml", "--out", "run", "--resume"]);
        assert!(run.status.success(), "{}", complaint(&run));
    }
}

#[test]
fn a_torn_checkpoint_is_reported_and_the_one_before_it_is_taken() {
    let stage = designed(KINDS[1]);
    let checkpoint = stage.join("run/checkpoint.json");
    let whole = fs::read(&checkpoint).unwrap();
    let found = fs::read(stage.join("found.npy")).unwrap();
    let resume = || stage.raylet(&["design", "scene.toml", "--out", "run", "--resume"]);
    for torn in [&[0xff, 0xfe, 0x00, 0x80], &whole[..whole.len() / 2], b""] {
        fs::write(&checkpoint, torn).unwrap();
        let run = resume();
        let message = complaint(&run);
        assert!(run.status.success(), "{message}");
        assert!(message.contains("the newest checkpoint is torn (run/checkpoint.json)"));
        assert!(
            message.contains("the one before it (run/checkpoint.before.json)"),
            "{message}"
        );
        assert!(fs::read(stage.join("found.npy")).unwrap() == found);
    }

    // Without the one before it there is nothing to go on from; a new design does not replace what is no checkpoint.
    fs::write(&checkpoint, [0xff]).unwrap();
    fs::remove_file(stage.join("run/checkpoint.before.json")).unwrap();
    let run = resume();
    assert_eq!(run.status.code(), Some(2));
    let message = complaint(&run);
    assert!(
        message.contains("checkpoint.json: found a torn file"),
        "{message}"
    );
    let fresh = stage.raylet(&["design", "scene.toml", "--out", "run"]);
    assert_eq!(fresh.status.code(), Some(2));
    assert!(complaint(&fresh).contains("--overwrite"));
    assert_eq!(fs::read(&checkpoint).unwrap(), [0xff]);
    let fresh = stage.raylet(&["design", "scene.toml", "--out", "run", "--overwrite"]);
    assert!(fresh.status.success(), "{}", complaint(&fresh));
}

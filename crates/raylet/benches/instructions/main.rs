//! Counts the instructions of the hot loops and compares them with `counts.toml`: a guard of their speed that needs no clock.
//!
//! Each loop runs in a process of its own, step by step, once for each kind of vector instructions that the machine has. A loop
//! may take 3 % more than its count. A loop that takes less passes, and the test prints it: a change elsewhere makes the compiler divide
//! the library in another way, and counts move by up to 5 %. `make instruction-counts` writes the file, as after an intended gain or
//! a change of the compiler. The results of a loop are compared between the kinds of instructions.
//!
//! With `--operations` it prints, for each loop and kind of instructions, how many instructions an item of its rate takes, how many
//! sums and products of double precision are among them, and how many quotients and roots: `make performance` compares these with what
//! the machine can do. What a loop takes besides its items is left out, as the difference between two sizes of its input.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `loops` | The loops, and their inputs |
//! | `stepping` | Counting the instructions of another process |
//! | `operations` | What instructions do with numbers of double precision |

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod loops;

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod operations;

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod stepping;

/// Where loops are not counted.
#[cfg(not(all(target_os = "linux", target_arch = "x86_64")))]
fn main() {
    println!("skipped: instructions are counted on Linux with x86-64 alone");
}

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
fn main() {
    counted::main();
}

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod counted {
    use std::collections::BTreeMap;
    use std::io::ErrorKind;
    use std::path::{Path, PathBuf};
    use std::process::exit;
    use std::{env, fs};

    use crate::loops::{LOOPS, items, run_loop};
    use crate::stepping::{Counted, count_steps, stay_on_one_processor};

    /// Kinds of vector instructions, the narrowest first.
    const LEVELS: [&str; 3] = ["baseline", "avx2", "avx512"];

    /// Part by which a count may grow: where arrays lie decides on a few instructions.
    const TOLERANCE: f64 = 0.03;

    /// Part by which results may differ between kinds of instructions, of the largest.
    const SAME: f64 = 1e-13;

    /// So many times the least input is added to tell what an item takes.
    const FURTHER: u32 = 1;

    /// Errors of systems that do not let one process follow another.
    const REFUSED: [ErrorKind; 2] = [ErrorKind::PermissionDenied, ErrorKind::Unsupported];

    /// Counts by loop and kind of instructions.
    type Counts = BTreeMap<String, BTreeMap<String, u64>>;

    /// Counts and compares, or is the process that is counted.
    pub(crate) fn main() {
        let words: Vec<String> = env::args().skip(1).collect();
        match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
            ["--loop", name, level, times] => {
                return run_loop(name, level, times.parse().expect("a number"));
            }
            ["--write"] => return write(&counts()),
            ["--operations"] => return operations(),
            _ => {}
        }
        // Other profiles have other instructions, and a name on the command line means another test.
        let is_release =
            env::current_exe().is_ok_and(|exe| exe.iter().any(|part| part == "release"));
        if !is_release || words.iter().any(|word| !word.starts_with('-')) {
            println!("skipped: instructions are counted in the profile `release`, with all tests");
            return;
        }
        let known: Counts =
            toml::from_str(&fs::read_to_string(place()).expect("counts.toml")).expect("counts");
        let faults = faults(&known, &counts());
        faults.iter().for_each(|fault| println!("{fault}"));
        exit(i32::from(!faults.is_empty()));
    }

    /// Counts of all loops, with each kind of instructions that the processor has. Results are compared on the way.
    fn counts() -> Counts {
        if let Err(error) = stay_on_one_processor() {
            println!("on any processor, which takes longer: {error}");
        }
        let mut counts = Counts::new();
        for name in LOOPS {
            let mut narrow: Option<Vec<f64>> = None;
            for level in LEVELS {
                let Counted { steps, results, .. } = match count_steps(name, level, 1) {
                    Ok(Some(counted)) => counted,
                    Ok(None) => continue,
                    Err(error) if REFUSED.contains(&error.kind()) => {
                        println!("skipped: no process may be counted here: {error}");
                        exit(0);
                    }
                    Err(error) => {
                        println!("{name}, {level}: {error}");
                        exit(1);
                    }
                };
                println!("{name}, {level}: {steps} instructions");
                let first = narrow.get_or_insert_with(|| results.clone());
                let largest = first.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
                let differs = |(a, b): (&f64, &f64)| (a - b).abs() > SAME * largest;
                if first.len() != results.len() || first.iter().zip(&results).any(differs) {
                    println!(
                        "{name}: results with {level} differ from those with {}",
                        LEVELS[0]
                    );
                    exit(1);
                }
                counts
                    .entry(name.to_owned())
                    .or_default()
                    .insert(level.to_owned(), steps);
            }
        }
        counts
    }

    /// Prints what an item of each loop takes, by two sizes of its input.
    fn operations() {
        let counted = |name, level, times| match count_steps(name, level, times) {
            Ok(counted) => counted,
            Err(error) => {
                println!("{name}, {level}: {error}");
                exit(1);
            }
        };
        for name in LOOPS.iter().filter(|name| **name != "chirp") {
            for level in LEVELS {
                let (Some(one), Some(more)) =
                    (counted(name, level, 1), counted(name, level, 1 + FURTHER))
                else {
                    continue;
                };
                let sum = |counted: &Counted| counted.results.iter().sum::<f64>();
                let count = match items(name) {
                    Some(count) => f64::from(FURTHER * count),
                    None => sum(&more) - sum(&one),
                };
                let each = |of: fn(&Counted) -> u64| (of(&more) - of(&one)) as f64 / count;
                println!(
                    "{name}\t{level}\t{:.2}\t{:.2}\t{:.3}",
                    each(|counted| counted.steps),
                    each(|counted| counted.operations.sums_and_products),
                    each(|counted| counted.operations.quotients_and_roots)
                );
            }
        }
    }

    /// What is wrong with counts, in sentences.
    fn faults(known: &Counts, found: &Counts) -> Vec<String> {
        let mut faults = Vec::new();
        for (name, levels) in found {
            for (level, count) in levels {
                let levels = known.get(name);
                let Some(usual) = levels.and_then(|levels| levels.get(level)) else {
                    match levels {
                        Some(_) => {
                            println!("{name}, {level}: not compared, as counts.toml has none")
                        }
                        None => faults.push(format!("{name}: no count in counts.toml")),
                    }
                    continue;
                };
                let change = *count as f64 / *usual as f64 - 1.0;
                let told = format!(
                    "{name}, {level}: {count} instructions, {usual} before ({:+.1} %, allowed +{:.0} %); \
                     if that is meant, make instruction-counts",
                    100.0 * change,
                    100.0 * TOLERANCE
                );
                if change > TOLERANCE {
                    faults.push(told);
                } else if change < -TOLERANCE {
                    println!("{told}");
                }
            }
        }
        faults
    }

    /// Writes the counts; those with instructions that this processor does not have stay.
    fn write(found: &Counts) {
        let known = fs::read_to_string(place()).unwrap_or_default();
        let mut all: Counts = toml::from_str(&known).unwrap_or_default();
        for (name, levels) in found {
            all.entry(name.clone()).or_default().extend(levels.clone());
        }
        all.retain(|name, _| found.contains_key(name));
        let text = toml::to_string(&all).expect("counts as text");
        fs::write(place(), text).expect("counts.toml is written");
    }

    fn place() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/instructions/counts.toml")
    }
}

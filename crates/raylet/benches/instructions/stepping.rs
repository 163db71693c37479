//! Counting the instructions of another process, which says by a signal where its loop begins and ends.

use std::collections::HashMap;
use std::io::{self, Read, Write};
use std::ops::Range;
use std::process::{Child, Command, Stdio};
use std::{env, fs};

use nix::sched::{CpuSet, sched_getcpu, sched_setaffinity};
use nix::sys::ptrace;
use nix::sys::signal::{Signal, raise};
use nix::sys::wait::{WaitStatus, waitpid};
use nix::unistd::Pid;

use crate::operations::Operations;

/// The signal at the begin and the end of a loop. It never arrives: the process that counts takes it.
const MARK: Signal = Signal::SIGUSR1;

/// The status of a process that has not the instructions.
pub(crate) const WITHOUT: i32 = 3;

/// What a loop took, and what came of it.
pub(crate) struct Counted {
    /// Instructions.
    pub steps: u64,
    /// Operations with numbers of double precision among them.
    pub operations: Operations,
    /// Results.
    pub results: Vec<f64>,
}

/// Keeps this process and those that it starts on one processor: they take turns at every step.
///
/// # Errors
/// A system that refuses it.
pub(crate) fn stay_on_one_processor() -> io::Result<()> {
    let mut here = CpuSet::new();
    here.set(sched_getcpu()?)?;
    Ok(sched_setaffinity(Pid::from_raw(0), &here)?)
}

/// Counts the instructions of a loop in a process of its own, which this program starts with `--loop`, the name of the loop, that
/// of the vector instructions and how many times larger its input is; nothing where the processor has not these instructions.
///
/// # Errors
/// A process that cannot be followed, or ends otherwise.
pub(crate) fn count_steps(name: &str, level: &str, times: u32) -> io::Result<Option<Counted>> {
    let mut child = Command::new(env::current_exe()?)
        .args(["--loop", name, level, &times.to_string()])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()?;
    let mut out = child.stdout.take().ok_or_else(|| fault("no output"))?;

    // The process says that it is ready, or ends.
    let mut ready = [0];
    if out.read(&mut ready)? == 0 {
        return match child.wait()?.code() {
            Some(WITHOUT) => Ok(None),
            code => Err(fault(&format!("ended with {code:?} before its loop"))),
        };
    }
    let (steps, operations) = steps(&mut child)?;
    let mut text = String::new();
    out.read_to_string(&mut text)?;
    let status = child.wait()?;
    if !status.success() {
        return Err(fault(&format!("ended with {status}")));
    }
    let results = text
        .split_whitespace()
        .map(|bits| u64::from_str_radix(bits, 16).map(f64::from_bits));
    Ok(Some(Counted {
        steps,
        operations,
        results: results
            .collect::<Result<_, _>>()
            .map_err(io::Error::other)?,
    }))
}

/// The instructions of the program itself between two marks of a process that waits for a byte, and their operations.
fn steps(child: &mut Child) -> io::Result<(u64, Operations)> {
    let pid = Pid::from_raw(child.id() as i32);
    ptrace::attach(pid)?;
    expect(pid, Signal::SIGSTOP)?;
    child
        .stdin
        .take()
        .ok_or_else(|| fault("no input"))?
        .write_all(b".")?;
    ptrace::cont(pid, None)?;
    expect(pid, MARK)?;
    let own = own_code(pid)?;
    let (mut steps, mut operations) = (0, Operations::default());
    let mut known: HashMap<u64, Operations> = HashMap::new();
    loop {
        ptrace::step(pid, None)?;
        match waitpid(pid, None)? {
            WaitStatus::Stopped(_, Signal::SIGTRAP) => {
                let place = ptrace::getregs(pid)?.rip;
                if own.contains(&place) {
                    steps += 1;
                    let here = match known.get(&place) {
                        Some(here) => *here,
                        None => Operations::of(&code_at(pid, place)?),
                    };
                    known.insert(place, here);
                    operations.add(here);
                }
            }
            WaitStatus::Stopped(_, MARK) => break,
            other => return Err(fault(&format!("{other:?} within its loop"))),
        }
    }
    ptrace::detach(pid, None)?;
    Ok((steps, operations))
}

/// The bytes of an instruction, and of what stands behind it.
fn code_at(pid: Pid, place: u64) -> io::Result<[u8; 16]> {
    let mut code = [0; 16];
    for (word, at) in code.chunks_exact_mut(8).zip([place, place + 8]) {
        word.copy_from_slice(&ptrace::read(pid, at as ptrace::AddressType)?.to_ne_bytes());
    }
    Ok(code)
}

/// Where the code of the program itself lies in a process. That of the system's libraries differs from machine to machine.
fn own_code(pid: Pid) -> io::Result<Range<u64>> {
    let maps = fs::read_to_string(format!("/proc/{pid}/maps"))?;
    let program = env::current_exe()?;
    let ends = maps.lines().find_map(|line| {
        let is_code = line.contains(" r-xp ") && line.ends_with(&*program.to_string_lossy());
        let (first, end) = line.split_whitespace().next()?.split_once('-')?;
        let number = |text| u64::from_str_radix(text, 16).ok();
        is_code.then_some(number(first)?..number(end)?)
    });
    ends.ok_or_else(|| fault("no code of its own"))
}

/// Waits until a process stops by a signal.
fn expect(pid: Pid, signal: Signal) -> io::Result<()> {
    match waitpid(pid, None)? {
        WaitStatus::Stopped(_, found) if found == signal => Ok(()),
        other => Err(fault(&format!("{other:?}, expected {signal}"))),
    }
}

/// Runs a loop between two marks, once another process counts, and prints its results as bits.
///
/// # Errors
/// No process that counts.
pub(crate) fn between_marks(run: impl FnOnce() -> Vec<f64>) -> io::Result<()> {
    let mut out = io::stdout();
    out.write_all(b"\n")?;
    out.flush()?;
    io::stdin().read_exact(&mut [0])?;
    raise(MARK)?;
    let results = run();
    raise(MARK)?;
    for result in results {
        writeln!(out, "{:x}", result.to_bits())?;
    }
    Ok(())
}

fn fault(words: &str) -> io::Error {
    io::Error::other(words.to_owned())
}

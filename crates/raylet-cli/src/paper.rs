//! `raylet paper NAME`: a study of the source paper, done again.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use raylet::file::storage::folder::OutputFolder;
use raylet_paper::fig5::fig5;
use raylet_paper::mirrors::fig6::fig6;
use raylet_paper::mirrors::fig6_foci::fig6_foci;
use raylet_paper::mirrors::fig6_s::fig6_s;
use raylet_paper::patches::fig2::fig2;
use raylet_paper::patches::fig3::fig3;
use raylet_paper::study::{Effort, STUDY_FILE, Study};
use raylet_paper::study_error::StudyError;
use raylet_paper::systems::system_table::clear;
use raylet_paper::systems::system1::system1;
use raylet_paper::systems::system2::system2;
use raylet_paper::systems::system3::system3;

use crate::failure::Failure;
use crate::overrides::start_threads;
use crate::say::say;
use crate::study_display::StudyDisplay;

/// Does a study of the source paper again: numbers on standard output, and pictures of them.
#[derive(Args)]
pub(crate) struct Paper {
    /// The study.
    #[arg(value_enum)]
    name: Name,
    /// Smaller elements and fewer repetitions: seconds instead of minutes.
    #[arg(long)]
    quick: bool,
    /// Writes paper.json, the pictures and scenes of the elements into this folder. A system or a design that was
    /// stopped goes on where it was when it runs again. Until then DIR.parts keeps its results.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Does only so many of the parts (20 or fewer) of each long random run of a system, for a first look. The
    /// parts are kept in DIR.parts; with a larger N the run goes on from them.
    #[arg(long, value_name = "N", requires = "out", value_parser = clap::value_parser!(u16).range(1..))]
    parts: Option<u16>,
    /// Threads to use; all processors by default. Results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

/// The studies, by the paper's figures.
#[derive(Clone, Copy, ValueEnum)]
enum Name {
    /// Patches that cover a hologram, by rules of position; periods; flat patches on a curved mirror.
    Fig2,
    /// Error against secondary rays of one patch: a metalens and a hologram of a Siemens star.
    Fig3,
    /// A hologram before a lens: designed with a thin lens, with principal planes, and through the real lens.
    Fig5,
    /// A conformal diffractive mirror that shows two foci or a letter, on two substrates.
    Fig6,
    /// The curved mirror of figure 6 with two foci, designed by gradients.
    Fig6Foci,
    /// The curved mirror of figure 6 with the letter, designed by gradients.
    #[value(name = "fig6-s")]
    Fig6S,
    /// Figure 4, system 1: a grating and a lens.
    System1,
    /// Figure 4, system 2: a hologram in free space.
    System2,
    /// Figure 4, system 3: a hologram and a lens.
    System3,
}

impl Paper {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        start_threads(self.threads)?;
        let claim = |path: &PathBuf| OutputFolder::claim_as(path, STUDY_FILE);
        let target = self.out.as_ref().map(claim).transpose()?;
        // Where a study keeps what it has, to go on with if it is stopped.
        let keep = self.out.as_ref().map(|out| parts(out));
        let effort = Effort {
            quick: self.quick,
            keep: keep.as_deref(),
            most: self.parts.map_or(usize::MAX, usize::from),
            display: &StudyDisplay,
        };
        let study = self.study(effort).map_err(message)?;
        if let Some(target) = target {
            study.publish(&target).map_err(message)?;
        }
        if self.parts.is_none() {
            let cleared = keep.iter().try_for_each(|keep| clear(keep));
            cleared.map_err(message)?;
        }
        say(&study.text)
    }

    fn study(&self, effort: Effort) -> Result<Study, StudyError> {
        match self.name {
            Name::Fig2 => fig2(self.quick),
            Name::Fig3 => fig3(self.quick),
            Name::Fig5 => fig5(effort),
            Name::Fig6 => fig6(self.quick),
            Name::Fig6Foci => fig6_foci(effort),
            Name::Fig6S => fig6_s(effort),
            Name::System1 => system1(effort),
            Name::System2 => system2(effort),
            Name::System3 => system3(effort),
        }
    }
}

/// What a study that ended early says.
fn message(error: StudyError) -> Failure {
    Failure::new(error.to_string())
}

/// The folder beside `--out` with the parts of a run.
fn parts(out: &Path) -> PathBuf {
    let out: PathBuf = out.components().collect();
    let mut name = out.into_os_string();
    name.push(".parts");
    PathBuf::from(name)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::paper::parts;

    #[test]
    fn each_folder_has_parts_of_its_own() {
        let parts = |out: &str| parts(Path::new(out));
        assert_eq!(parts("runs/pp.v1"), Path::new("runs/pp.v1.parts"));
        assert_eq!(parts("runs/pp.v2/"), Path::new("runs/pp.v2.parts"));
    }
}

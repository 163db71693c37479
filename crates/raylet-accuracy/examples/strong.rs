//! scratch
use raylet_accuracy::problems::*;
use raylet_accuracy::strong::*;
fn main() {
    let which: String = std::env::args().nth(1).unwrap_or_default();
    let list = vec![
        before_lens("random λ/2 pixels", random_pixels(120, 0.5), 375.0, QUICK),
        before_lens("random λ/2 pixels", random_pixels(120, 0.5), 250.0, QUICK),
        before_lens("random 2λ pixels", random_pixels(30, 2.0), 375.0, QUICK),
        before_lens(
            "grating of sine 0.25",
            grating_pixels(120, 0.5, 0.25),
            375.0,
            QUICK,
        ),
        after_lens(
            "random 2λ pixels",
            random_pixels(30, 2.0),
            40.0,
            50.0,
            200.0,
            QUICK,
        ),
        between_lenses(
            "random 2λ pixels",
            random_pixels(30, 2.0),
            40.0,
            20.0,
            180.0,
            QUICK,
        ),
    ];
    for p in list {
        if !p.name.contains(&which) {
            continue;
        }
        let t = std::time::Instant::now();
        println!(
            "{}: {:?} total {:?}",
            p.name,
            p.measure().unwrap(),
            t.elapsed()
        );
        let out = raylet::engine::simulate::simulate(&p.system, &p.settings, &|_| {}).unwrap();
        for hop in &out.hops {
            if let raylet::engine::plan::Plan::Beamlets(b) = &hop.plan {
                println!(
                    "   sigma {:.3} bands {:?} correct {} eta {:.1e} {:.1e} tally {:.1e} {:.1e} dropped {:.1e} t {:.2}",
                    b.sigma,
                    b.bands.map(|b| b.count),
                    b.correct,
                    b.eta,
                    b.eta_corrected,
                    hop.tally.eta(),
                    hop.tally.eta_corrected(),
                    hop.tally.dropped(),
                    hop.seconds
                );
            }
            print!("  ");
            for f in raylet::engine::tally::FATES {
                let s = hop.tally.share(f);
                if s > 0.0 {
                    print!(" {} {:.4} ({})", f.name(), s, hop.tally.rays(f));
                }
            }
            println!();
        }
    }
}

//! Verbs that raylet does not have, and what there is instead.

use clap::error::{ContextKind, ContextValue};

/// Verbs that somebody may look for, and what to say of them.
const ABSENT: [(&[&str], &str); 6] = [
    (
        &["image", "imaging"],
        "raylet makes no images of objects (docs/limits.md): `raylet simulate SCENE --field X,Y` gives the light of each \
         direction or point, and the weighted sum of their intensities is the image",
    ),
    (
        &["psf", "spot"],
        "the point spread function is the intensity that `raylet simulate SCENE` leaves, for one point or direction of light",
    ),
    (
        &["mtf", "otf"],
        "raylet does not compute it: it is the Fourier transform of the intensity that `raylet simulate SCENE` leaves",
    ),
    (
        &["polari", "jones", "birefring"],
        "waves are scalar: there is no polarisation (docs/limits.md)",
    ),
    (
        &["trace", "rays"],
        "single rays are traced in Python: raylet.load(\"SCENE\").trace(Px=0.5)",
    ),
    (
        &["optimi"],
        "`raylet design SCENE` finds phases and parameters by gradients",
    ),
];

/// What there is instead of the verb that a command line asks for, if raylet does not have it on purpose.
pub(crate) fn instead(error: &clap::Error) -> Option<String> {
    let Some(ContextValue::String(verb)) = error.get(ContextKind::InvalidSubcommand) else {
        return None;
    };
    let asked = |starts: &[&str]| starts.iter().any(|start| verb.starts_with(start));
    let (_, text) = ABSENT.iter().find(|(starts, _)| asked(starts))?;
    Some(format!("no verb is called `{verb}`: {text}"))
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use crate::Arguments;
    use crate::absent::instead;

    fn told(verb: &str) -> Option<String> {
        let error = Arguments::try_parse_from(["raylet", verb, "scene.toml"]).err();
        error.and_then(|error| instead(&error))
    }

    #[test]
    fn absent_verbs_say_what_there_is() {
        for (verb, words) in [
            ("image", "raylet simulate SCENE --field"),
            ("psf", "point spread function"),
            ("mtf", "Fourier transform"),
            ("polarization", "waves are scalar"),
            ("trace", "in Python"),
            ("optimize", "raylet design SCENE"),
        ] {
            assert!(
                told(verb).is_some_and(|text| text.contains(words)),
                "{verb}"
            );
        }
        assert_eq!(told("simulat"), None);
    }
}

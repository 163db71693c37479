//! What instructions do with numbers of double precision.

use iced_x86::{Decoder, DecoderOptions, Register};

/// How many operations with single numbers some instructions do.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Operations {
    /// Sums, differences and products, and of fused ones both.
    pub sums_and_products: u64,
    /// Quotients and square roots, which take several times as long.
    pub quotients_and_roots: u64,
}

impl Operations {
    /// Those of the instruction at the beginning of some code.
    pub(crate) fn of(code: &[u8]) -> Self {
        let instruction = Decoder::new(64, code, DecoderOptions::NONE).decode();
        let name = format!("{:?}", instruction.mnemonic()).to_lowercase();
        // Names of vector instructions begin with v, those of fused ones end with the order of their operands before the type.
        let name = name.strip_prefix('v').unwrap_or(&name);
        let (kind, lanes) = match (name.strip_suffix("pd"), name.strip_suffix("sd")) {
            (Some(kind), _) => (kind, lanes(instruction.op0_register())),
            (None, Some(kind)) => (kind, 1),
            (None, None) => return Self::default(),
        };
        let fused = ["fmadd", "fmsub", "fnmadd", "fnmsub"];
        let [sums_and_products, quotients_and_roots] = match kind {
            "add" | "sub" | "mul" | "addsub" => [lanes, 0],
            "div" | "sqrt" => [0, lanes],
            _ if fused.iter().any(|begin| kind.starts_with(begin)) => [2 * lanes, 0],
            _ => [0; 2],
        };
        Self {
            sums_and_products,
            quotients_and_roots,
        }
    }

    /// Adds those of another instruction.
    pub(crate) fn add(&mut self, other: Self) {
        self.sums_and_products += other.sums_and_products;
        self.quotients_and_roots += other.quotients_and_roots;
    }
}

/// Numbers of a vector register.
fn lanes(register: Register) -> u64 {
    register.size() as u64 / 8
}

//! Runs of a whole system: hop after hop, forward and back.
//!
//! | file | what it holds |
//! | --- | --- |
//! | [`arriving_light`] | The light that arrives at a screen as a whole field, and its grids |
//! | `attempt` | One attempt to propagate the light of a system: its rims, its method, and the run |
//! | `backend` | The interface between fields and rays: everything that crosses it adds |
//! | [`control_variate`] | A control variate for drawn beamlets: only the change since an exact run is estimated |
//! | `beamlet_propagation` | The backend that carries beamlets of a range of patches on the threads of this machine |
//! | [`forward_pass`] | The record of a forward pass, which the adjoint reads, and the gradient |
//! | [`forecast`] | What a run will take: plans, samples and memory of every hop |
//! | `hop_run` | The run of one hop, from the field behind the first screen to the light before the second |
//! | [`local_band_run`] | A whole run by local bands |
//! | `linearised_bands` | Fields and gradients of a system with frozen windows, by local bands |
//! | `linearised_fields` | Fields and gradients of a system with frozen plans of whole fields |
//! | [`linearised_system`] | A system with frozen plans: its fields and its gradients |
//! | [`linearised_system_error`] | Why a system cannot be differentiated |
//! | `missed_target` | Further attempts where a run misses its target error |
//! | [`needed_memory`] | The memory limit at which a refused system would be carried, and what needs less |
//! | [`outcome`] | The result of a run, and how far it has come |
//! | `patch_cutter` | The patches of a field that beamlets carry: their places, spectra and modes |
//! | [`mod@reference`] | A whole run without rays, or with one geometrical ray per pixel, as a reference |
//! | [`reference_forecast`] | What a reference will take: method, reason and seconds of every step |
//! | `rimmed_variations` | Perturbed systems with a screen at every rim of the planned one |
//! | [`screen_sensitivity`] | How the light on a screen changes with the parameters of its source and element |
//! | [`simulate`] | A whole run from the source to the sensor |
//! | [`simulate_error`] | Why a run is impossible |
//! | `whole_field_run` | A whole run from fields that are sampled as a whole |

pub mod arriving_light;
pub(crate) mod attempt;
pub(crate) mod backend;
pub(crate) mod beamlet_propagation;
pub mod control_variate;
pub mod forecast;
pub mod forward_pass;
pub(crate) mod hop_run;
pub(crate) mod linearised_bands;
pub(crate) mod linearised_fields;
pub mod linearised_system;
pub mod linearised_system_error;
pub mod local_band_run;
pub(crate) mod missed_target;
pub mod needed_memory;
pub mod outcome;
pub(crate) mod patch_cutter;
pub mod reference;
pub mod reference_forecast;
pub(crate) mod rimmed_variations;
pub mod screen_sensitivity;
pub mod simulate;
pub mod simulate_error;
pub(crate) mod whole_field_run;

//! Which code draws: kernels, compiled for sets of effects.
//!
//! In: settings whose effects are those that a scene calls for. Out: the same, where what the kernel has no code for is known
//! to be off when it is compiled, so that nothing of it is linked. The kernel for all effects is the specification: a
//! narrower one gives the same bytes wherever its effects are enough, as it differs in what it leaves out alone.

use core::marker::PhantomData;
use core::ops::Deref;

use super::Settings;
use crate::effects::Effects;
use crate::trace::Query;

/// The effects that code is compiled for: a set of one's own, or one of those below.
///
/// ```
/// use voxdag::effects::Effects;
/// use voxdag::render::Kernel;
///
/// struct Shiny;
/// impl Kernel for Shiny {
///     const EFFECTS: Effects = Effects::SPECULAR.union(Effects::EMISSION);
/// }
/// ```
pub trait Kernel {
    /// What it can draw.
    const EFFECTS: Effects;

    /// What time it is, in any unit, never less than before: for [`Counters`](super::Counters) to say how long effects took.
    /// Without a clock all is over at once.
    #[inline(always)]
    fn now() -> u64 {
        0
    }

    /// Told of rays that are about to be followed to anything in their way: to lights, or the short ones to where those start.
    #[inline(always)]
    fn follows(_rays: &[Query], _to_light: bool) {}
}

/// What no ray but the camera's is needed for: highlights, and light of its own, which [`Effects::PHONG`] is without.
#[derive(Clone, Copy, Debug)]
pub struct Phong;

impl Kernel for Phong {
    const EFFECTS: Effects = Effects::SPECULAR.union(Effects::EMISSION);
}

/// The same, shadows, and textures.
#[derive(Clone, Copy, Debug)]
pub struct Shadows;

impl Kernel for Shadows {
    const EFFECTS: Effects = Phong::EFFECTS.union(Effects::SHADOWS).union(Effects::TEXTURES);
}

/// All effects.
#[derive(Clone, Copy, Debug)]
pub struct Full;

impl Kernel for Full {
    const EFFECTS: Effects = Effects::ALL;
}

/// The time since `start`.
#[inline(always)]
pub(super) fn since<K: Kernel>(start: u64) -> u64 {
    K::now().saturating_sub(start)
}

/// Settings as a kernel has them.
pub(super) struct Chosen<K> {
    settings: Settings,
    kernel: PhantomData<K>,
}

impl<K: Kernel> Chosen<K> {
    /// With these effects, or as many of them as the kernel can draw.
    pub fn new(settings: &Settings, effects: Effects) -> Chosen<K> {
        let effects = effects.intersection(K::EFFECTS);
        Chosen { settings: Settings { effects, ..*settings }, kernel: PhantomData }
    }

    /// What is drawn. The intersection changes nothing, but tells the compiler what is off.
    #[inline(always)]
    pub fn effects(&self) -> Effects {
        self.settings.effects.intersection(K::EFFECTS)
    }
}

impl<K> Deref for Chosen<K> {
    type Target = Settings;

    #[inline(always)]
    fn deref(&self) -> &Settings {
        &self.settings
    }
}

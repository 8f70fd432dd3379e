//! Numbers of up to 16 bits, one after the other in words, low bits first; one may begin in a word and end in the next.

/// Bits that numbers up to `max` take; 0 for 0.
pub(super) const fn width(max: u32) -> u32 {
    u32::BITS - max.leading_zeros()
}

/// Words that so many numbers take; `u64::MAX` if that is more than there can be.
pub(super) const fn words_for(count: u64, width: u32) -> u64 {
    match count.checked_mul(width as u64) {
        Some(bits) => bits.div_ceil(32),
        None => u64::MAX,
    }
}

/// The number at `index`; 0 beyond the words.
#[inline]
pub(super) fn get(words: &[u32], index: u64, width: u32) -> u32 {
    let bit = index * u64::from(width);
    let word = |i: u64| words.get(i as usize).map_or(0, |w| u64::from(*w));
    let two = word(bit / 32) | word(bit / 32 + 1) << 32;
    (two >> (bit % 32)) as u32 & ((1 << width) - 1)
}

/// Writes the number at `index`, where the bits are 0 as yet.
#[cfg(feature = "alloc")]
pub(super) fn set(words: &mut [u32], index: u64, width: u32, value: u32) {
    let bit = index * u64::from(width);
    let (at, value) = ((bit / 32) as usize, u64::from(value) << (bit % 32));
    for (word, part) in words[at..].iter_mut().zip([value as u32, (value >> 32) as u32]) {
        *word |= part;
    }
}

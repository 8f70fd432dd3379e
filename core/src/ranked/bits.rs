//! Numbers of up to 24 bits, one after the other in words, low bits first; one may begin in a word and end in the next.

/// Bits that numbers up to `max` take; 0 for 0.
pub(crate) const fn width(max: u32) -> u32 {
    u32::BITS - max.leading_zeros()
}

/// Words that so many numbers take; `u64::MAX` if that is more than there can be.
pub(crate) const fn words_for(count: u64, width: u32) -> u64 {
    match count.checked_mul(width as u64) {
        Some(bits) => bits.div_ceil(32),
        None => u64::MAX,
    }
}

/// The number at `index`; 0 beyond the words.
#[inline]
pub(crate) fn get(words: &[u32], index: u64, width: u32) -> u32 {
    let bit = index * u64::from(width);
    let word = |i: u64| words.get(i as usize).map_or(0, |w| u64::from(*w));
    let two = word(bit / 32) | word(bit / 32 + 1) << 32;
    (two >> (bit % 32)) as u32 & ((1 << width) - 1)
}

/// Writes the number at `index`, where the bits are 0 as yet.
#[cfg(feature = "alloc")]
pub(crate) fn set(words: &mut [u32], index: u64, width: u32, value: u32) {
    let bit = index * u64::from(width);
    let (at, value) = ((bit / 32) as usize, u64::from(value) << (bit % 32));
    for (word, part) in words[at..].iter_mut().zip([value as u32, (value >> 32) as u32]) {
        *word |= part;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_those_of_the_largest_number() {
        assert_eq!([0, 1, 2, 3, 4, 255, 256, 65535].map(width), [0, 1, 2, 2, 3, 8, 9, 16]);
        assert_eq!((words_for(0, 16), words_for(3, 11), words_for(1 << 63, 0)), (0, 2, 0));
        assert_eq!((words_for(1 << 60, 16), words_for(1 << 59, 16)), (u64::MAX, 1 << 58));
    }

    #[cfg(feature = "alloc")]
    #[test]
    fn numbers_come_back_across_words() {
        for width in 1..=24 {
            let number = |i: u64| (i as u32 * 0x9e37 + 5) & ((1 << width) - 1);
            let mut words = [0; 40];
            let count = 1280 / u64::from(width);
            (0..count).for_each(|i| set(&mut words, i, width, number(i)));
            assert!((0..count).all(|i| get(&words, i, width) == number(i)), "{width} bits");
        }
        assert_eq!((get(&[], 7, 3), get(&[u32::MAX], 1 << 40, 16)), (0, 0));
    }
}

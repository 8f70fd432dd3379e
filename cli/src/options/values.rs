//! How the values of flags are read: what is expected stands in every refusal.

use std::ops::RangeInclusive;
use std::time::Duration;

use voxdag::effects::Effects;
use voxdag::render::Samples;
use voxdag::shade::LightKind;

use super::picture::{LightArg, SupersampleArg};
use crate::report::number as number_text;

fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err(format!("`{text}` is not a finite number")),
        Err(_) => Err(format!("`{text}` is not a number")),
    }
}

fn numbers(text: &str) -> Result<Vec<f64>, String> {
    text.split(',').map(number).collect()
}

pub fn triple(text: &str) -> Result<[f64; 3], String> {
    triple_of(&numbers(text)?)
}

pub fn triple_of(found: &[f64]) -> Result<[f64; 3], String> {
    <[f64; 3]>::try_from(found).map_err(|_| format!("expected three numbers x,y,z, found {}", found.len()))
}

fn linear(parts: &[f64]) -> Result<[f32; 3], String> {
    let mut color = [0.0; 3];
    for (to, &from) in color.iter_mut().zip(parts) {
        *to = from as f32;
        if from < 0.0 || !to.is_finite() {
            let from = number_text(from);
            return Err(format!("a colour of {from}: expected 0 (none), 1 (full) or more, at most 3.4e38"));
        }
    }
    Ok(color)
}

pub fn colour(text: &str) -> Result<[f32; 3], String> {
    colour_of(&numbers(text)?)
}

pub fn colour_of(found: &[f64]) -> Result<[f32; 3], String> {
    match *found {
        [grey] => linear(&[grey; 3]),
        [r, g, b] => linear(&[r, g, b]),
        _ => Err(format!("expected one number or three r,g,b, found {}", found.len())),
    }
}

pub fn light(text: &str) -> Result<LightArg, String> {
    let (position, color) = placed(text)?;
    Ok(LightArg { kind: LightKind::Point(position), color, shadow: false })
}

pub fn sun(text: &str) -> Result<LightArg, String> {
    let (towards, color) = placed(text)?;
    Ok(LightArg { kind: LightKind::Directional(direction_of(&towards)?), color, shadow: false })
}

/// Three numbers, and a colour if there are three more.
fn placed(text: &str) -> Result<([f64; 3], [f32; 3]), String> {
    match numbers(text)?[..] {
        [x, y, z] => Ok(([x, y, z], [1.0; 3])),
        [x, y, z, r, g, b] => Ok(([x, y, z], linear(&[r, g, b])?)),
        ref found => Err(format!("expected three numbers x,y,z or six x,y,z,r,g,b, found {}", found.len())),
    }
}

pub fn positive(text: &str) -> Result<f64, String> {
    let x = number(text)?;
    if x > 0.0 { Ok(x) } else { Err("expected a number greater than 0".to_owned()) }
}

pub fn field_of_view(text: &str) -> Result<f64, String> {
    field_of_view_of(number(text)?)
}

pub fn field_of_view_of(x: f64) -> Result<f64, String> {
    if x > 0.0 && x < 180.0 { Ok(x) } else { Err("expected degrees above 0 and below 180".to_owned()) }
}

pub fn direction(text: &str) -> Result<[f64; 3], String> {
    direction_of(&numbers(text)?)
}

pub fn direction_of(found: &[f64]) -> Result<[f64; 3], String> {
    match triple_of(found)? {
        [0.0, 0.0, 0.0] => Err("expected a direction, such as 0,1,0: it cannot be 0,0,0".to_owned()),
        v => Ok(v),
    }
}

pub fn resolution(text: &str) -> Result<u32, String> {
    let found = text.parse().ok().filter(|n| (1..=1 << 21).contains(n));
    found.ok_or_else(|| "expected a whole number from 1 to 2097152".to_owned())
}

/// Reads a time such as `100ms` or `1.5s`: crates for that know no fractions, or far more units than a picture needs.
pub fn duration(text: &str) -> Result<Duration, String> {
    let expected = || "expected a time such as 100ms or 1.5s, from 1ms to 1000s".to_owned();
    let (value, ms) = match text.strip_suffix("ms") {
        Some(value) => (value, 1.0),
        None => (text.strip_suffix('s').ok_or_else(expected)?, 1000.0),
    };
    let ms = ms * number(value).map_err(|_| expected())?;
    if (1.0..=1e6).contains(&ms) { Ok(Duration::from_secs_f64(ms / 1000.0)) } else { Err(expected()) }
}

/// Reads an error that a picture may have.
pub fn error(text: &str) -> Result<f64, String> {
    match number(text)? {
        x if (0.001..=1.0).contains(&x) => Ok(x),
        _ => Err("expected 0.001 (what 8 bits cost) to 1 (black for white)".to_owned()),
    }
}

pub fn threads(text: &str) -> Result<u16, String> {
    let found = text.parse().ok().filter(|n| (1..=1024).contains(n));
    found.ok_or_else(|| "expected a whole number from 1 to 1024".to_owned())
}

pub fn samples(text: &str) -> Result<Samples, String> {
    text.parse().ok().and_then(Samples::new).ok_or_else(|| "expected 1, 4, 5, 16 or 64".to_owned())
}

/// Reads which pixels take all samples.
pub fn supersample(text: &str) -> Result<SupersampleArg, String> {
    let (name, value) = text.split_once(':').map_or((text, None), |(name, value)| (name, Some(value)));
    let within = |value: Option<&str>, usual: f64, largest: f64| match value.map_or(Ok(usual), number)? {
        x if (0.0..=largest).contains(&x) => Ok(x),
        _ => Err(format!("expected a number from 0 to {largest} after `{name}:`")),
    };
    match (name, value) {
        ("all", None) => Ok(SupersampleArg::All),
        ("near", _) => Ok(SupersampleArg::Near(within(value, 0.5, 1.0)?)),
        ("adaptive", _) => Ok(SupersampleArg::Adaptive(within(value, 2.0, 90.0)? as f32)),
        ("region", Some(value)) => {
            let expected = || "expected region:X0,Y0,X1,Y1 in pixels, X0 below X1 and Y0 below Y1".to_owned();
            let corners =
                value.split(',').map(|x| x.parse().ok()).collect::<Option<Vec<u32>>>().ok_or_else(expected)?;
            match corners[..] {
                [x0, y0, x1, y1] if x0 < x1 && y0 < y1 => Ok(SupersampleArg::Region([x0, y0, x1, y1])),
                _ => Err(expected()),
            }
        }
        _ => Err("expected all, near[:SHARE], region:X0,Y0,X1,Y1 or adaptive[:DEGREES]".to_owned()),
    }
}

/// The last frame there can be: their numbers have four digits.
pub const LAST_FRAME: u32 = 9999;

/// Reads `FIRST-LAST`, or one frame.
pub fn frames(text: &str) -> Result<RangeInclusive<u32>, String> {
    let expected = || format!("expected frames such as 1-48, or one, each 1 to {LAST_FRAME}");
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let frame = |text: &str| text.parse().ok().filter(|n| (1..=LAST_FRAME).contains(n)).ok_or_else(expected);
    match (frame(first)?, frame(last)?) {
        (first, last) if first <= last => Ok(first..=last),
        (first, last) => Err(format!("expected the first frame before the last: {last}-{first}")),
    }
}

/// Reads a set of effects: one by name, then changes to it; without a name changes to all.
pub fn effects(text: &str) -> Result<Effects, String> {
    let (first, changes) = text.split_once(',').unwrap_or((text, ""));
    let (set, changes) = match first {
        "auto" | "all" => (Effects::ALL, changes),
        "phong" => (Effects::PHONG, changes),
        _ => (Effects::ALL, text),
    };
    let change = |set: Effects, change: &str| {
        let effect = change.get(1..).and_then(Effects::named);
        match (change.as_bytes().first(), effect) {
            (Some(b'+'), Some(effect)) => Ok(set.union(effect)),
            (Some(b'-'), Some(effect)) => Ok(set.difference(effect)),
            _ => {
                let names: Vec<_> = Effects::ALL.names().collect();
                let expected = "expected auto, phong or all, or +NAME and -NAME by commas";
                Err(format!("{expected}, with the names {}; found {change:?}", names.join(", ")))
            }
        }
    };
    let named_alone = changes.is_empty() && changes.len() != text.len() && !text.ends_with(',');
    if named_alone { Ok(set) } else { changes.split(',').try_fold(set, change) }
}

/// Reads a height in steps.
pub fn lift(text: &str) -> Result<f32, String> {
    let found = text.parse().ok().filter(|x| (0.0..=LARGEST_LIFT).contains(x));
    found.ok_or_else(|| format!("expected a number from 0 to {LARGEST_LIFT}"))
}

/// Beyond it things do not touch their shadows.
const LARGEST_LIFT: f32 = 16.0;

/// Largest side of a picture: PNG readers and graphics cards stop there.
const MAX_SIDE: u32 = 32768;

/// Reads `WIDTHxHEIGHT`.
pub fn picture_size(text: &str) -> Result<[u32; 2], String> {
    let expected = || format!("expected WIDTHxHEIGHT, such as 1280x720, each 1 to {MAX_SIDE}");
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(expected)?;
    let side = |text: &str| text.parse().ok().filter(|n| (1..=MAX_SIDE).contains(n)).ok_or_else(expected);
    Ok([side(width)?, side(height)?])
}

pub fn memory_size(text: &str) -> Result<u64, String> {
    let expected = || "expected a size such as 512M, 4G or 1.5GiB (K, M, G, T: powers of 1024)".to_owned();
    let unit_at = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (value, unit) = text.split_at(unit_at);
    let scale: u64 = match unit.to_ascii_lowercase().as_str() {
        "" | "b" => 1,
        "k" | "kib" => 1 << 10,
        "m" | "mib" => 1 << 20,
        "g" | "gib" => 1 << 30,
        "t" | "tib" => 1 << 40,
        "kb" => 1_000,
        "mb" => 1_000_000,
        "gb" => 1_000_000_000,
        "tb" => 1_000_000_000_000,
        _ => return Err(expected()),
    };
    let bytes = value.parse::<f64>().map_err(|_| expected())? * scale as f64;
    if bytes >= 1.0 && bytes < u64::MAX as f64 { Ok(bytes as u64) } else { Err(expected()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_of_memory() {
        assert_eq!(memory_size("512M"), Ok(512 << 20));
        assert_eq!(memory_size("1.5GiB"), Ok(3 << 29));
        assert_eq!(memory_size("2gb"), Ok(2_000_000_000));
        assert_eq!(memory_size("77"), Ok(77));
        for wrong in ["", "0", "G", "4X", "-1G", "1e3", "1..2", "99999999999T"] {
            assert!(memory_size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn times_and_errors() {
        for (text, ms) in [("100ms", 100), ("2s", 2000), ("1.5s", 1500), ("1ms", 1), ("1000s", 1_000_000)] {
            assert_eq!(duration(text), Ok(Duration::from_millis(ms)));
        }
        for wrong in ["", "s", "100", "0ms", "-1s", "1 minute", "1e9s", "nans", "infs", "1001s", "0.1ms"] {
            assert!(duration(wrong).is_err(), "{wrong}");
        }
        assert_eq!([error("0.001"), error("1")], [Ok(0.001), Ok(1.0)]);
        assert!(["0", "0.0009", "1.1", "nan", "x"].iter().all(|wrong| error(wrong).is_err()));
    }

    #[test]
    fn vectors_are_finite_and_have_the_right_length() {
        assert_eq!(triple("-1,2.5,3e2"), Ok([-1.0, 2.5, 300.0]));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,nan", "inf,0,0", "1e999,0,0", "a,b,c", "1,,2"] {
            assert!(triple(wrong).is_err(), "{wrong}");
        }
        assert_eq!(colour("0.5"), Ok([0.5; 3]));
        assert!(colour("-0.1").is_err() && colour("1,2").is_err() && colour("1e300").is_err());
        assert_eq!(light("1,2,3").unwrap().color, [1.0; 3]);
        assert!(light("1,2,3,4").is_err());
    }

    #[test]
    fn pixels_to_supersample() {
        use SupersampleArg::*;
        for (text, which) in [
            ("all", All),
            ("near", Near(0.5)),
            ("near:0.25", Near(0.25)),
            ("region:0,1,2,3", Region([0, 1, 2, 3])),
            ("adaptive", Adaptive(2.0)),
            ("adaptive:7.5", Adaptive(7.5)),
        ] {
            assert_eq!(supersample(text), Ok(which));
            assert_eq!(supersample(&which.to_string()), Ok(which));
        }
        for wrong in ["", "none", "all:1", "near:", "near:1.5", "near:-1", "near:nan", "adaptive:91", "adaptive:x"] {
            assert!(supersample(wrong).is_err(), "{wrong}");
        }
        for wrong in
            ["region", "region:1,2,3", "region:1,2,3,4,5", "region:3,0,3,9", "region:0,9,9,0", "region:-1,0,3,9"]
        {
            assert!(supersample(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn directions_of_suns_and_ranges_of_frames() {
        assert_eq!(sun("0,-1,0,1,2,3").unwrap().kind, LightKind::Directional([0.0, -1.0, 0.0]));
        assert!(sun("0,0,0").is_err() && sun("1,2").is_err());
        assert_eq!((frames("1-48"), frames("7")), (Ok(1..=48), Ok(7..=7)));
        for wrong in ["", "-", "1-", "-3", "0-3", "3-1", "1-10000", "1-2-3", "a"] {
            assert!(frames(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn sets_of_effects() {
        let (all, phong, mirror) = (Effects::ALL, Effects::PHONG, Effects::MIRROR);
        for (text, set) in [
            ("auto", all),
            ("all", all),
            ("phong", phong),
            ("phong,+mirror", phong.union(mirror)),
            ("-mirror", all.difference(mirror)),
            ("-mirror,-specular,+mirror", all.difference(phong)),
            ("auto,-emission", all.difference(Effects::EMISSION)),
            ("+mirror", all),
        ] {
            assert_eq!(effects(text), Ok(set), "{text}");
        }
        for (text, wrong) in [
            ("", ""),
            (",", ""),
            ("auto,", ""),
            ("none", "none"),
            ("mirror", "mirror"),
            ("phong,mirror", "mirror"),
            ("-", "-"),
            ("+phong", "+phong"),
            ("-mirror,auto", "auto"),
            ("-mirror,", ""),
            ("\u{e9}", "\u{e9}"),
        ] {
            assert!(effects(text).is_err_and(|why| why.ends_with(&format!("; found {wrong:?}"))), "{text}");
        }
    }

    #[test]
    fn sizes_of_pictures() {
        assert_eq!(picture_size("640x480"), Ok([640, 480]));
        for wrong in ["640", "0x1", "1x0", "40000x1", "-1x5", "axb"] {
            assert!(picture_size(wrong).is_err(), "{wrong}");
        }
    }
}

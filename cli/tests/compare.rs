//! `compare` on pictures whose errors are known.

mod common;
use common::Sandbox;
use image::{DynamicImage, GrayAlphaImage, ImageBuffer, Luma, Rgb, RgbImage, RgbaImage};

/// Keys that are numbers in every build.
const KEYS: [&str; 5] = ["width", "height", "rmse", "ssim", "differing"];
const FLIP: bool = cfg!(feature = "flip");

/// Writes a picture as a PNG.
fn png(s: &Sandbox, name: &str, picture: impl Into<DynamicImage>) {
    picture.into().save_with_format(s.path(name), image::ImageFormat::Png).unwrap();
}

/// `a.png` is grey; `b.png` is the same but for one white pixel of 24 x 16.
fn one_pixel_apart() -> Sandbox {
    let s = Sandbox::new();
    let a = RgbImage::from_pixel(24, 16, Rgb([188; 3]));
    let mut b = a.clone();
    b.put_pixel(10, 5, Rgb([255; 3]));
    png(&s, "a.png", a);
    png(&s, "b.png", b);
    s
}

/// The RMSE of those.
fn known() -> f64 {
    let grey = libm::pow((188.0 / 255.0 + 0.055) / 1.055, 2.4);
    (1.0 - grey) / (24.0 * 16.0_f64).sqrt()
}

#[test]
fn errors_are_known() {
    let s = one_pixel_apart();
    let report = s.ok("compare a.png b.png --json").json();
    for key in KEYS {
        assert!(report[key].is_number(), "{key} in {report}");
    }
    assert_eq!((&report["width"], &report["height"], &report["differing"]), (&24.into(), &16.into(), &1.into()));
    assert!((report["rmse"].as_f64().unwrap() - known()).abs() < 1e-12, "{report}");
    assert!((report["psnr"].as_f64().unwrap() + 20.0 * libm::log10(known())).abs() < 1e-9, "{report}");
    assert!((0.5..0.999).contains(&report["ssim"].as_f64().unwrap()), "{report}");
    assert_eq!(report["flip"].as_f64().is_some_and(|flip| (0.001..0.1).contains(&flip)), FLIP, "{report}");

    let run = s.ok("compare a.png b.png");
    for word in ["24x16", "RMSE", "0.025", "PSNR", "dB", "SSIM", "FLIP", "1 of 384 pixels (0.3 %)"] {
        assert!(run.stdout.contains(word), "no `{word}` in\n{}", run.stdout);
    }
    assert_eq!(run.stderr.contains("compare a.png b.png --map difference.png"), FLIP, "{}", run.stderr);
}

#[test]
fn equal_pictures_have_no_error_in_any_encoding() {
    let s = Sandbox::new();
    let grey = |x: u32, y: u32| (x * 9 + y * 5) as u8;
    png(&s, "rgb.png", RgbImage::from_fn(20, 12, |x, y| Rgb([grey(x, y); 3])));
    png(&s, "rgba.png", RgbaImage::from_fn(20, 12, |x, y| [grey(x, y), grey(x, y), grey(x, y), x as u8].into()));
    png(&s, "grey.png", ImageBuffer::from_fn(20, 12, |x, y| Luma([grey(x, y)])));
    png(&s, "greya.png", GrayAlphaImage::from_fn(20, 12, |x, y| [grey(x, y), 0].into()));
    png(&s, "grey16.png", ImageBuffer::from_fn(20, 12, |x, y| Luma([u16::from(grey(x, y)) * 257])));
    png(&s, "rgb16.png", ImageBuffer::from_fn(20, 12, |x, y| Rgb([u16::from(grey(x, y)) * 257; 3])));
    for other in ["rgb", "rgba", "grey", "greya", "grey16", "rgb16"] {
        let run = s.ok(&format!("compare rgb.png {other}.png --json --max-rmse 0"));
        let report = run.json();
        assert_eq!((report["rmse"].as_f64(), report["ssim"].as_f64()), (Some(0.0), Some(1.0)), "{other}: {report}");
        assert!(report["psnr"].is_null() && report["differing"] == 0, "{other}: {report}");
        assert_eq!(report["flip"].as_f64(), FLIP.then_some(0.0), "{other}: {report}");
        assert_eq!(run.stderr, "");
    }
    assert!(s.ok("compare rgb.png grey.png").stdout.contains("no pixel differs"));
}

#[test]
fn a_bound_on_the_error_is_an_exit_code() {
    let s = one_pixel_apart();
    let bound = |factor: f64| format!("compare a.png b.png --max-rmse {}", factor * known());
    s.ok(&bound(1.001));
    let run = s.run(&bound(0.999));
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.stdout.contains("RMSE"), "the report comes first: {}", run.stdout);
    assert!(run.stderr.starts_with("error: b.png: the RMSE of 0.02"), "{}", run.stderr);
    assert_eq!(run.stderr.contains("--map"), FLIP, "{}", run.stderr);
    for bad in ["-1", "2", "nan", "x"] {
        s.run(&format!("compare a.png b.png --max-rmse {bad}")).fails(2, &["expected a number from 0 to 1"]);
    }
}

#[test]
#[cfg(feature = "flip")]
fn the_map_shows_where() {
    let s = one_pixel_apart();
    s.ok("compare a.png b.png --map map.png");
    let map = image::open(s.path("map.png")).unwrap().into_rgb8();
    assert_eq!(map.dimensions(), (24, 16));
    let light = |x, y| map.get_pixel(x, y).0.iter().map(|&c| u32::from(c)).sum::<u32>();
    assert!((0..16).all(|y| (0..24).all(|x| light(x, y) <= light(10, 5))));
    assert!(light(10, 5) > 150 && map.get_pixel(23, 15).0 == [0, 0, 4], "{:?}", map.get_pixel(10, 5));

    // Also where the bound fails; and never in place of a picture.
    assert_eq!(s.run("compare a.png b.png --map again.png --max-rmse 0").code, 1);
    assert!(s.read("again.png") == s.read("map.png"));
    s.run("compare a.png b.png --map ./b.png").fails(2, &["b.png", "never overwritten"]);
    s.run("compare a.png b.png --map map.jpg").fails(2, &["map.jpg", ".png"]);
}

#[test]
#[cfg(not(feature = "flip"))]
fn without_flip_there_is_no_map() {
    let s = one_pixel_apart();
    s.run("compare a.png b.png --map map.png").fails(2, &["--map", "without FLIP", "C++"]);
}

#[test]
fn pictures_that_cannot_be_compared_are_named() {
    let s = one_pixel_apart();
    png(&s, "wide.png", RgbImage::new(25, 16));
    let whole = s.read("a.png");
    s.write("cut.png", &whole[..whole.len() - 30]);
    s.write("head.png", &whole[..20]);
    let mut flipped = whole.clone();
    flipped[20] ^= 1; // of the width: the checksum no longer fits
    s.write("flipped.png", &flipped);
    s.write("mesh.png", common::OBJ);
    s.write("empty.png", "");
    // A head alone, right in itself: 100,000 x 100,000 pixels of one bit.
    s.write("huge.png", huge());
    let before = s.files();
    for (line, code, words) in [
        ("compare a.png wide.png", 3, &["wide.png", "25x16", "a.png", "24x16"][..]),
        ("compare a.png cut.png", 3, &["cut.png", "broken PNG"]),
        ("compare head.png a.png", 3, &["head.png", "broken PNG"]),
        ("compare a.png flipped.png", 3, &["flipped.png", "broken PNG"]),
        ("compare mesh.png a.png", 3, &["mesh.png", "not a PNG"]),
        ("compare a.png empty.png", 3, &["empty.png", "not a PNG"]),
        ("compare a.png none.png", 3, &["none.png", "no such file"]),
        ("compare . a.png", 3, &["cannot read"]),
        ("compare huge.png huge.png", 4, &["huge.png", "100000x100000", "67108864"]),
        ("compare a.png", 2, &["B.png"]),
    ] {
        s.run(line).fails(code, words);
        if FLIP && code != 2 {
            s.run(&format!("{line} --map map.png")).fails(code, words);
        }
    }
    assert_eq!(s.files(), before);
}

/// A PNG with a head and the start of its data.
fn huge() -> Vec<u8> {
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |name: &[u8; 4], data: &[u8]| {
        let body = [name, data].concat();
        file.extend((data.len() as u32).to_be_bytes());
        file.extend(&body);
        file.extend(crc(&body).to_be_bytes());
    };
    let side = 100_000_u32.to_be_bytes();
    chunk(b"IHDR", &[&side[..], &side, &[1, 0, 0, 0, 0]].concat());
    chunk(b"IDAT", &[0x78, 1]);
    file
}

/// The checksum of PNG's chunks, bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
    })
}

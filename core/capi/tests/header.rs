//! `voxdag.h` is what cbindgen makes of the sources. To renew it: `VOXDAG_HEADER=write cargo test -p voxdag-capi --test header`.

use std::path::Path;

use cbindgen::{Builder, Config, DocumentationStyle, ExportConfig, Language, RenameRule, Style};

const HEAD: &str = "\
/* voxdag: sparse voxel DAGs with materials, for C99 and later and C++.
 *
 * Made by cbindgen from the sources in core/capi/src; see core/capi/tests/header.rs. How to build and link the library, and
 * a first program: docs/embedding.md.
 *
 * What holds for every function:
 *
 * - Memory is the caller's: arrays are read and written during the call only, except for the words of
 *   voxdag_scene_open(). What is written must not overlap anything else that the call reads or writes. It need not be
 *   cleared before. Pointers may be null where that is said, and where the count beside them is 0.
 * - Null pointers, pointers that are not aligned, sizes that overflow, numbers that are not finite or out of range are
 *   answered by a status; flags that are not 0 count as 1, and codes of voxels from 2^63 on, but for VOXDAG_NONE, as any
 *   voxel: they break nothing. A pointer to less memory than the count says, or to memory that was freed, cannot be noticed.
 * - The status is VOXDAG_STATUS_OK (0) or says what is wrong. `error` may be null; otherwise more is written to it where the
 *   status is not OK. Output other than the error is then undefined, but for what is said to be written.
 * - A scene never changes: any number of threads may use it at the same time. Functions keep nothing between calls.
 * - Queries take nothing from the heap, and give the same bits on every machine.
 * - The thread's floating-point environment is the default one: rounding to nearest, subnormals not flushed to 0 (no FTZ or
 *   DAZ), nothing linked with -ffast-math.
 * - No panic crosses the border: a defect of the library ends as VOXDAG_STATUS_PANIC, with a message on standard error. */";

/// What cbindgen makes of the sources, in the order in which one reads them.
fn generate() -> String {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs");
    let numbers =
        ["Arithmetic", "Face", "Up", "Normals", "LightKind", "Supersample", "Effects", "Cover", "Keep", "Colors"];
    let mut config = Config {
        language: Language::C,
        cpp_compat: true,
        header: Some(HEAD.to_owned()),
        include_guard: Some("VOXDAG_H".to_owned()),
        style: Style::Both,
        line_length: 120,
        documentation_style: DocumentationStyle::C99,
        no_includes: true,
        sys_includes: vec!["stddef.h".to_owned(), "stdint.h".to_owned()],
        usize_is_size_t: true,
        export: ExportConfig {
            include: numbers.map(|name| format!("Voxdag{name}")).to_vec(),
            ..ExportConfig::default()
        },
        ..Config::default()
    };
    config.enumeration.rename_variants = RenameRule::ScreamingSnakeCase;
    config.enumeration.prefix_with_name = true;
    config.function.sort_by = Some(cbindgen::SortKey::None);
    let builder = Builder::new().with_config(config).with_src(source);
    let mut text = Vec::new();
    builder.generate().expect("cbindgen reads the sources").write(&mut text);
    String::from_utf8(text).expect("a header is text")
}

#[test]
fn the_header_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("voxdag.h");
    let made = generate();
    if std::env::var_os("VOXDAG_HEADER").is_some_and(|value| value == "write") {
        std::fs::write(&path, &made).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
    assert!(
        kept == made,
        "voxdag.h is not what the sources say. Renew it: VOXDAG_HEADER=write cargo test -p voxdag-capi --test header"
    );
}

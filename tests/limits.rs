//! Scarce memory: an allocator that refuses each allocation in turn, and one that counts what an import takes.
//!
//! Every way of the core to the heap gives an error with a number of bytes, never an abort (which would end this program).
//! The OBJ and MTL importers are the exception: tobj, `String` and the maps of `std` cannot fail softly. Their memory is
//! in proportion to their input, which is tested here instead.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::Path;

use voxdag::build::{BuildError, DagBuilder};
use voxdag::file::{self, LoadError, Parts, WriteError};
use voxdag::grid::UpAxis;

use voxdag::rank::{MoxelDagBuf, OffsetsBuf, Prefix};
use voxdag::ranked::{MoxelsBuf, PackedBuf, PalettesBuf};
use voxdag::scene::{Build, MaterialMode, Options, SceneError};
use voxdag::svo::SvoBuf;
use voxdag::table::{Entry, InsertError, TableBuf};
use voxdag::trace::TopBuf;
use voxdag::triangulate::Triangulator;
use voxdag::voxelize::{Cover, VoxelizeError, Voxelizer};
use voxdag::{Grid, Material, Morton, obj};
use voxdag_oracle::scenes;

/// The system's allocator, but for threads that ask for less.
struct Scarce;

thread_local! {
    /// Allocations that this thread still gets, and how many are refused after them.
    static LEFT: Cell<(u64, u64)> = const { Cell::new((u64::MAX, 0)) };
    /// Size of the last allocation that was refused.
    static REFUSED: Cell<usize> = const { Cell::new(0) };
    /// Bytes in use by this thread, and the most there were. (What one thread takes and another gives back does not count.)
    static USED: Cell<(isize, isize)> = const { Cell::new((0, 0)) };
}

fn refuses(size: usize) -> bool {
    let (given, refused) = LEFT.get();
    if given > 0 {
        LEFT.set((given - 1, refused));
        return false;
    }
    LEFT.set(if refused > 1 { (0, refused - 1) } else { (u64::MAX, 0) });
    REFUSED.set(size);
    true
}

fn count(change: isize) {
    let (used, most) = USED.get();
    USED.set((used + change, most.max(used + change)));
}

// SAFETY: every call goes to `System` as it is, or gives null, as an allocator may.
unsafe impl GlobalAlloc for Scarce {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if refuses(layout.size()) {
            return std::ptr::null_mut();
        }
        count(layout.size() as isize);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if refuses(size) {
            return std::ptr::null_mut();
        }
        count(size as isize - layout.size() as isize);
        unsafe { System.realloc(memory, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Scarce = Scarce;

/// Runs something again and again: the first allocation is refused, the second, and so on, until it gets through. Each
/// time the error must name a number of bytes, no more than were asked for; once with a single refusal, once with nothing
/// but refusals from there on. Gives what came out, and says how many allocations there were.
fn with_each_refused<T: PartialEq, E: core::fmt::Display>(
    name: &str,
    run: impl Fn() -> Result<T, E>,
    bytes: impl Fn(&E) -> Option<u64>,
) -> T {
    let expected = run().unwrap_or_else(|e| panic!("{name}: {e}"));
    for refusals in [1, u64::MAX] {
        let mut given = 0;
        loop {
            LEFT.set((given, refusals));
            let result = run();
            LEFT.set((u64::MAX, 0));
            let asked = REFUSED.take();
            match result {
                Ok(found) => {
                    assert!(asked == 0, "{name}: allocation {given} was refused, and nothing noticed");
                    assert!(found == expected, "{name}: another result after {given} allocations");
                    break;
                }
                Err(error) => {
                    let named = bytes(&error).unwrap_or_else(|| panic!("{name}, allocation {given}: {error}"));
                    assert!(named > 0 && named <= asked as u64, "{name}, allocation {given} of {asked} bytes: {error}");
                }
            }
            given += 1;
        }
        assert!(given > 0, "{name}: there was nothing to refuse");
    }
    expected
}

fn of_builder(error: &BuildError) -> Option<u64> {
    if let BuildError::Memory { bytes } = error { Some(*bytes) } else { None }
}

fn of_table(error: &InsertError) -> Option<u64> {
    if let InsertError::Memory { bytes } = error { Some(*bytes) } else { None }
}

fn of_voxelizer(error: &VoxelizeError) -> Option<u64> {
    if let VoxelizeError::Memory { bytes } = error { Some(*bytes) } else { None }
}

fn of_scene(error: &SceneError) -> Option<u64> {
    match error {
        SceneError::Voxelize(error) => of_voxelizer(error),
        SceneError::Reduce(error) => of_builder(error),
        SceneError::Table(error) => of_table(error),
        SceneError::Limit { .. } => None,
    }
}

fn some_bricks(count: u64) -> impl Iterator<Item = (Morton, u64)> {
    (0..count).map(|i| (Morton(64 * i * i), i.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1))
}

#[test]
fn d01_builders_survive_refusals() {
    let build = || {
        let mut builder = DagBuilder::new(9)?;
        some_bricks(120).try_for_each(|(code, mask)| builder.push(code, mask))?;
        let part = builder.finish()?;
        let mut builder = DagBuilder::new(10)?;
        builder.push(Morton(0), 3)?;
        builder.append(Morton(1 << 27), &part.dag())?;
        builder.append(Morton(2 << 27), &part.dag())?;
        builder.finish()
    };
    let built = with_each_refused("DagBuilder", build, of_builder);
    assert_eq!(
        built.dag().stats().unwrap().voxels,
        2 + 2 * some_bricks(120).map(|b| u64::from(b.1.count_ones())).sum::<u64>()
    );
    let named = |bytes: &usize| Some(*bytes as u64);
    let stats = || built.dag().stats();
    with_each_refused("stats", stats, named);
    for bits in 0..4 {
        let make = || TopBuf::new(&built.dag(), bits).map(|_| ());
        with_each_refused("TopBuf", make, named);
    }
}

#[test]
fn d01_tables_survive_refusals() {
    for normals in [false, true] {
        let entry = |i: u64| (Morton(i * i), Entry { material: i as u16, normal: Some([0.0, 0.0, 1.0]) });
        let fill = || {
            let mut table = TableBuf::new(3, normals)?;
            (0..40).try_for_each(|i| table.insert(entry(i).0, entry(i).1))?;
            table.insert_all((30..400).map(entry))?;
            Ok(table.into_words())
        };
        with_each_refused("TableBuf", fill, of_table);
    }
    // A refusal to grow leaves the table as it was, and it goes on when there is memory again.
    let mut table = TableBuf::new(1, false).unwrap();
    table.insert(Morton(1), Entry { material: 1, normal: None }).unwrap();
    LEFT.set((0, 1));
    let refused = table.insert(Morton(2), Entry { material: 2, normal: None });
    LEFT.set((u64::MAX, 0));
    assert!(matches!(refused, Err(InsertError::Memory { .. })));
    assert_eq!((table.as_table().len(), table.as_table().get(Morton(2))), (1, None));
    table.insert(Morton(2), Entry { material: 2, normal: None }).unwrap();
    assert_eq!(table.as_table().get(Morton(2)).map(|entry| entry.material), Some(2));
}

#[test]
fn d01_ranks_and_their_arrays_survive_refusals() {
    let mut builder = DagBuilder::new(9).unwrap();
    some_bricks(120).try_for_each(|(code, mask)| builder.push(code, mask)).unwrap();
    let built = builder.finish().unwrap();
    let dag = built.dag();
    with_each_refused("Prefix", || Prefix::build(&dag), of_builder);
    with_each_refused("OffsetsBuf", || OffsetsBuf::build(&dag), of_builder);
    with_each_refused("MoxelDagBuf", || MoxelDagBuf::build(&dag), of_builder);
    with_each_refused("SvoBuf", || SvoBuf::build(&dag, 1 << 20), of_builder);
    let entries = || {
        dag.voxels().zip(0u64..).map(|(voxel, i)| (voxel, Entry { material: (i * i / 7 % 1500) as u16, normal: None }))
    };
    with_each_refused("PackedBuf", || PackedBuf::from_entries(entries()), of_builder);
    with_each_refused("PalettesBuf", || PalettesBuf::from_entries(entries()), of_builder);
    with_each_refused("MoxelsBuf", || MoxelsBuf::from_entries(entries(), true), of_builder);
}

#[test]
fn d01_voxelisation_survives_refusals() {
    let shape = scenes::sphere([0.0; 3], 1.0, 2);
    let mesh = shape.mesh();
    let grid = Grid::fit(&mesh.validate().unwrap(), 40).unwrap();
    for cover in [Cover::Exact, Cover::Thin, Cover::Inflated] {
        let voxelize = || {
            let voxelizer = Voxelizer::new(&mesh, &grid, cover)?;
            let mut sum = 0u64;
            for subtree in 0..voxelizer.subtrees() {
                voxelizer.voxelize::<VoxelizeError>(subtree, |brick| {
                    sum = sum.wrapping_mul(31).wrapping_add(brick.code.0 ^ brick.mask);
                    Ok(())
                })?;
            }
            Ok(sum)
        };
        with_each_refused("Voxelizer", voxelize, of_voxelizer);
    }
}

#[test]
fn d01_scenes_survive_refusals() {
    let shape = scenes::sphere([0.0; 3], 1.0, 1);
    let materials: Vec<u16> = (0..shape.triangles.len() as u16).map(|i| i % 3).collect();
    let mesh = voxdag::Mesh { materials: &materials, ..shape.mesh() };
    let bounds = mesh.validate().unwrap();
    let grid = Grid::fit(&bounds, 20).unwrap();
    for mode in [MaterialMode::None, MaterialMode::Tree, MaterialMode::Table, MaterialMode::TableNormals] {
        let options = Options { materials: mode, ..Options::default() };
        let build = || {
            let built = Build::new(&mesh, &grid, &options)?.run()?;
            Ok((built.dag, built.materials))
        };
        let (dag, materials) = with_each_refused("Build", build, of_scene);

        // And to a file and back.
        let parts = Parts {
            grid,
            bounds,
            up: UpAxis::Y,
            metres_per_unit: 0.0,
            geometry: dag.dag().into(),
            voxel_materials: materials.as_materials(None).unwrap(),
            colors: None,
            materials: &[Material::GREY; 3],
            names: &["a", "b", "c"],
        };
        let write = || parts.to_vec();
        let of_file = |error: &WriteError| if let WriteError::Memory { bytes } = error { Some(*bytes) } else { None };
        let words = with_each_refused("Parts", write, of_file);
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let read = || file::words_from_bytes(&bytes);
        let of_words = |error: &LoadError| if let LoadError::Memory { bytes } = error { Some(*bytes) } else { None };
        assert!(file::read(&with_each_refused("words_from_bytes", read, of_words)).is_ok());
    }
}

#[test]
fn d01_triangulation_survives_refusals() {
    let polygon: Vec<[f64; 3]> = (0..50).map(|i| [f64::from(i), f64::from(i % 7), 0.0]).collect();
    let named = |bytes: &usize| Some(*bytes as u64);
    for corners in [3, 4, 50] {
        let cut = || Triangulator::default().triangulate(&polygon[..corners]).map(<[_]>::len);
        assert_eq!(with_each_refused("Triangulator", cut, named), corners - 2);
    }
}

/// The files of a fuzz target.
fn corpus(target: &str) -> Vec<Vec<u8>> {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz");
    let folders = ["corpus", "regressions"].map(|folder| fuzz.join(folder).join(target));
    let files = folders.into_iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten();
    files.map(|entry| std::fs::read(entry.unwrap().path()).unwrap()).collect()
}

/// The most bytes that were in use at a time while something ran, beside those before.
fn most_bytes<T>(run: impl FnOnce() -> T) -> (T, usize) {
    let before = USED.get().0;
    USED.set((before, before));
    let result = run();
    (result, (USED.get().1 - before) as usize)
}

/// Importing takes memory in proportion to the input: a constant for each byte of it, and a little.
#[test]
fn imports_take_memory_in_proportion() {
    // Doubled ten times over, so that what is in proportion shows.
    let repeated = |bytes: Vec<u8>| [bytes.repeat(40), bytes];
    let mut worst = 0.0f64;
    for file in corpus("obj").into_iter().chain(corpus("mtl")).flat_map(repeated) {
        let (_, most) =
            most_bytes(|| _ = obj::import(&file, |path| (path.len().is_multiple_of(2)).then(|| file.clone())));
        worst = worst.max((most as f64 - 20_000.0) / file.len() as f64);
        assert!(most <= 20_000 + 200 * file.len(), "{most} bytes for {}", String::from_utf8_lossy(&file));
    }
    println!("at most {worst:.1} bytes per byte of input, and 20,000");
}

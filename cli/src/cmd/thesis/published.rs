//! What the thesis prints in its tables 5.1 to 5.8 (Pineda 2021), for its five scenes at 256, 512 and 1024 voxels a side;
//! measured on a MacBook Air of 2020 with four cores.

/// Resolutions of the thesis, in the order of every array below.
pub const RESOLUTIONS: [u32; 3] = [256, 512, 1024];

/// A number per resolution.
type Row = [u32; 3];

/// The figures of one scene.
pub struct Published {
    pub name: &'static str,
    /// Names of files that hold it or a reconstruction of it.
    files: &'static [&'static str],
    pub triangles: u32,
    pub materials: u32,
    /// KB.
    pub dag: Row,
    pub moxel_dag: Row,
    /// MB.
    pub hash_table: Row,
    pub moxel_table: Row,
    pub hash_table_without_normals: Row,
    /// Build, ms.
    pub voxelization_and_hash_table: Row,
    pub dag_construction: Row,
    pub moxel_voxelization: Row,
    pub moxel_dag_construction: Row,
    pub moxel_table_construction: Row,
    /// Render, ms: five samples.
    pub render_dag: Row,
    pub render_moxel: Row,
    pub render_calculated: Row,
    /// Render, ms: 1 sample, 16, 16 on the nearer half.
    pub samples_1: Row,
    pub samples_16: Row,
    pub samples_near: Row,
}

impl Published {
    /// The scene that a file of this name (without its ending) and so many triangles is, if it is one of the five.
    pub fn of(stem: &str, triangles: usize) -> Option<&'static Published> {
        let alike = |scene: &&Published| {
            let of_thesis = scene.triangles as usize;
            scene.files.contains(&stem) && triangles.abs_diff(of_thesis) <= of_thesis / 20
        };
        SCENES.iter().find(alike)
    }
}

const SCENES: [Published; 5] = [
    Published {
        name: "bunny",
        files: &["bunny"],
        triangles: 29_822,
        materials: 1,
        dag: [144, 497, 1712],
        moxel_dag: [178, 639, 2262],
        hash_table: [12, 47, 188],
        moxel_table: [8, 31, 125],
        hash_table_without_normals: [6, 23, 94],
        voxelization_and_hash_table: [248, 957, 4028],
        dag_construction: [61, 842, 9439],
        moxel_voxelization: [440, 2306, 16_032],
        moxel_dag_construction: [303, 3282, 37_443],
        moxel_table_construction: [1368, 11_590, 101_376],
        render_dag: [4104, 4769, 6446],
        render_moxel: [6856, 8277, 10_117],
        render_calculated: [7008, 8996, 11_180],
        samples_1: [1798, 2056, 2574],
        samples_16: [30_587, 35_206, 41_169],
        samples_near: [14_569, 17_481, 21_275],
    },
    Published {
        name: "buddha",
        files: &["buddha", "buddha_room"],
        triangles: 100_014,
        materials: 1,
        dag: [100, 377, 1378],
        moxel_dag: [127, 487, 1806],
        hash_table: [11, 44, 177],
        moxel_table: [7, 30, 118],
        hash_table_without_normals: [5, 22, 89],
        voxelization_and_hash_table: [290, 979, 3929],
        dag_construction: [41, 678, 9497],
        moxel_voxelization: [608, 3154, 20_371],
        moxel_dag_construction: [331, 3391, 39_008],
        moxel_table_construction: [1380, 11_708, 100_898],
        render_dag: [3850, 4580, 7086],
        render_moxel: [6555, 8058, 9308],
        render_calculated: [6740, 8219, 10_453],
        samples_1: [1766, 2013, 2492],
        samples_16: [29_720, 35_002, 39_399],
        samples_near: [13_189, 15_937, 19_203],
    },
    Published {
        name: "dragon",
        files: &["dragon_box"],
        triangles: 100_012,
        materials: 5,
        dag: [156, 566, 1987],
        moxel_dag: [196, 727, 2610],
        hash_table: [10, 42, 169],
        moxel_table: [7, 28, 113],
        hash_table_without_normals: [5, 21, 84],
        voxelization_and_hash_table: [315, 1007, 4236],
        dag_construction: [59, 900, 11_872],
        moxel_voxelization: [567, 2745, 18_762],
        moxel_dag_construction: [282, 3062, 37_292],
        moxel_table_construction: [1183, 10_506, 92_286],
        render_dag: [3915, 4600, 7054],
        render_moxel: [5651, 7051, 8744],
        render_calculated: [6652, 8215, 10_117],
        samples_1: [1642, 1976, 2477],
        samples_16: [26_831, 34_787, 40_861],
        samples_near: [15_667, 17_388, 20_802],
    },
    Published {
        name: "sponza",
        files: &["sponza", "sponza_328131"],
        triangles: 328_131,
        materials: 19,
        dag: [144, 368, 828],
        moxel_dag: [221, 598, 1365],
        hash_table: [14, 56, 226],
        moxel_table: [10, 38, 151],
        hash_table_without_normals: [7, 28, 113],
        voxelization_and_hash_table: [651, 1618, 5313],
        dag_construction: [45, 440, 4238],
        moxel_voxelization: [956, 3946, 26_689],
        moxel_dag_construction: [289, 2839, 33_785],
        moxel_table_construction: [1155, 9511, 90_293],
        render_dag: [11_589, 12_814, 18_826],
        render_moxel: [23_998, 28_934, 35_867],
        render_calculated: [18_300, 20_372, 23_080],
        samples_1: [3985, 4634, 5526],
        samples_16: [72_406, 80_157, 94_320],
        samples_near: [61_177, 65_439, 75_672],
    },
    Published {
        name: "conference",
        files: &["conference"],
        triangles: 322_457,
        materials: 32,
        dag: [76, 212, 634],
        moxel_dag: [104, 303, 905],
        hash_table: [5, 20, 87],
        moxel_table: [3, 14, 58],
        hash_table_without_normals: [2, 10, 43],
        voxelization_and_hash_table: [284, 653, 2191],
        dag_construction: [15, 156, 1703],
        moxel_voxelization: [441, 1070, 4963],
        moxel_dag_construction: [211, 1987, 22_444],
        moxel_table_construction: [839, 7536, 74_245],
        render_dag: [4426, 5214, 7888],
        render_moxel: [8256, 10_165, 13_925],
        render_calculated: [8525, 9366, 11_132],
        samples_1: [1906, 2286, 2793],
        samples_16: [34_974, 39_620, 43_847],
        samples_near: [17_506, 21_124, 23_397],
    },
];

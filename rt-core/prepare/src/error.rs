//! Errors of recipes and meshes, and of scenes that cannot be built.

/// A recipe that cannot be used. The message says where the problem is and what to write instead.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}: {key}: {problem}", self.place())]
pub struct RecipeError {
    /// The file's name as it was given, or the name of a built-in recipe.
    pub file: String,
    /// Line in the file, from 1; 0 if the error concerns no line.
    pub line: usize,
    /// The key with its table, such as `organ[1].spheres`.
    pub key: String,
    /// The problem, with the value and the allowed range.
    pub problem: String,
}

impl RecipeError {
    /// The file, and the line if the error concerns one.
    fn place(&self) -> String {
        match self.line {
            0 => self.file.clone(),
            line => format!("{}:{line}", self.file),
        }
    }
}

/// A mesh that cannot be used. The message names the mesh, its fault and the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{mesh}: {problem}")]
pub struct MeshError {
    /// The file and the parts taken from it, or `built-in shape`.
    pub mesh: String,
    /// The problem and its remedy.
    pub problem: MeshProblem,
}

/// A fault of a mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum MeshProblem {
    #[error("cannot be read ({0}); check the path, or pass the folder with --meshes DIR")]
    Unreadable(String),
    #[error("unknown mesh format '{0}'; use .obj, .stl, .ply, .gltf or .glb")]
    UnknownFormat(String),
    #[error("is not a valid {format} file ({detail}); export it again")]
    Malformed {
        format: &'static str,
        detail: String,
    },
    #[error(
        "{bytes} bytes announce {triangles} triangles; allowed: at most {max}; decimate the mesh"
    )]
    TooLarge {
        bytes: u64,
        triangles: u64,
        max: u64,
    },
    #[error("has no triangles; export a triangle surface, not points or lines")]
    NoTriangles,
    #[error(
        "has {points} points and no triangles; export the surface, or make one of a point cloud (MeshLab: Filters, Remeshing, Screened Poisson)"
    )]
    OnlyPoints { points: usize },
    #[error("uses the glTF extension {extension}, which {because}")]
    Extension {
        extension: String,
        because: &'static str,
    },
    #[error("has no part named '{wanted}'; its parts are: {available}")]
    NoSuchPart { wanted: String, available: String },
    #[error("vertex {index} has a coordinate that is not finite; mend the mesh")]
    NotFinite { index: usize },
    #[error(
        "triangle {triangle} uses vertex {vertex}, but there are only {vertices}; the file is damaged"
    )]
    IndexOutOfRange {
        triangle: usize,
        vertex: u64,
        vertices: usize,
    },
    #[error(
        "is {extent_m:.4} m across; allowed: {min_m} to {max_m} m{hint}; set `unit` (\"m\", \"cm\", \"mm\" or \"in\") or `scale` in the recipe, or give --unit or --scale"
    )]
    Extent {
        extent_m: f64,
        min_m: f64,
        max_m: f64,
        hint: &'static str,
    },
    #[error(
        "overlaps itself: {percent:.1} % of its volume is enclosed twice or inside out, most at {at_m:.3?} m; set `closing = \"auto\"` (or --closing) or \"wrap\", or mend the mesh there"
    )]
    Overlaps { percent: f64, at_m: [f64; 3] },
    #[error(
        "comes in {count} separate pieces, up to {gap_mm:.1} mm from each other; set `pieces = \"largest\"` (--pieces largest) to drop the others, or \"join\" to link them across the gap"
    )]
    FarPieces { count: usize, gap_mm: f64 },
    #[error(
        "comes in {count} separate pieces larger than dust; allowed: at most {max}; take fewer `parts` (--part), set `closing = \"solid\"` (or --closing), or join them in the mesh"
    )]
    ManyPieces { count: usize, max: usize },
    #[error(
        "is open: {loops} loops, {edges} open edges; set `closing = \"fill\"` (or --closing) or \"wrap\""
    )]
    Open { loops: usize, edges: usize },
    #[error(
        "is an open sheet, not the surface of a body: the lids that close its {loops} loops have {percent:.0} % of its area; give it a thickness in the mesh (Blender: modifier Solidify), or give a surface around a body"
    )]
    Sheet { loops: usize, percent: f64 },
    #[error(
        "is not a surface: {edges} edges join more than two triangles; set `closing = \"wrap\"` (or --closing)"
    )]
    NonManifold { edges: usize },
    #[error(
        "contradicts itself: it cannot be oriented (like a Moebius band); set `closing = \"solid\"` (or --closing), or mend the mesh"
    )]
    NotOrientable,
    #[error(
        "encloses no volume ({volume_ml:.4} mL), as a flat sheet, or because half of it is inside out; set `closing = \"solid\"` (or --closing), or give a surface around a body"
    )]
    NoVolume { volume_ml: f64 },
}

/// Failure to prepare a scene.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum PrepareError {
    #[error("organ '{organ}': {source}")]
    Mesh { organ: String, source: MeshError },
    #[error("organ '{organ}': {problem}")]
    Organ { organ: String, problem: String },
    #[error("{0}")]
    Room(String),
    #[error("compiled scene: {0}")]
    Scene(#[from] shared_mem::scene::SceneError),
    #[error("the realtime process would refuse the scene: {0}")]
    Refused(rt_core::scene::SceneError),
}

//! What a scene file says, before anything is loaded: every importer ends here, [`super::Scene`] begins here.

use crate::math::Rgb;
use glam::{Affine3A, Vec3};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A whole scene as written. Paths are already resolved against the file that names them.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// `None`: the camera is placed so that the whole scene is seen.
    pub camera: Option<CameraDescription>,
    pub film: FilmDescription,
    pub meshes: Vec<MeshDescription>,
    /// By name as in `usemtl`; they replace what the MTL says of that name.
    pub materials: BTreeMap<String, MaterialDescription>,
    pub lights: Vec<LightDescription>,
    pub integrator: IntegratorSettings,
    pub guiding: GuidingSettings,
    pub render: RenderSettings,
}

/// A perspective camera.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraDescription {
    pub origin: Vec3,
    pub target: Vec3,
    pub up: Vec3,
    /// Vertical field of view in degrees, in (0, 180).
    pub vfov: f32,
    /// The picture is flipped left to right (scene formats with a left-handed camera).
    pub mirrored: bool,
}

#[derive(Clone, Debug, PartialEq)]
pub struct FilmDescription {
    pub width: u32,
    pub height: u32,
    pub filter: Filter,
    /// Of the PNG only: stops by which the picture is brightened.
    pub exposure: f32,
}

impl Default for FilmDescription {
    fn default() -> FilmDescription {
        FilmDescription { width: 1280, height: 720, filter: Filter::Box, exposure: 0.0 }
    }
}

/// Pixel reconstruction filters. They are importance sampled, so that a sample belongs to one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// One pixel wide.
    Box,
    /// Radius one pixel.
    Tent,
    /// Truncated at the radius 1.5 pixels, standard deviation 0.5 pixels.
    Gaussian,
}

/// A file of triangles and where it stands.
#[derive(Clone, Debug)]
pub struct MeshDescription {
    pub path: PathBuf,
    pub transform: Affine3A,
    /// Replaces every material of the file.
    pub material: Option<String>,
}

/// A surface material.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialDescription {
    pub bsdf: BsdfDescription,
    /// Scatters alike on both sides; else the back of an opaque material is black.
    pub two_sided: bool,
    /// Share of light that is stopped; the rest passes straight through.
    pub opacity: Option<ScalarTexture>,
    /// Radiance (W/(sr·m²)) leaving the side of the face's winding.
    pub emission: Rgb,
    /// Both sides emit.
    pub emission_two_sided: bool,
}

impl Default for MaterialDescription {
    fn default() -> MaterialDescription {
        MaterialDescription {
            bsdf: BsdfDescription::Diffuse { reflectance: ColorTexture::Constant(Rgb::splat(0.5)) },
            two_sided: true,
            opacity: None,
            emission: Rgb::ZERO,
            emission_two_sided: false,
        }
    }
}

/// The kinds of scattering. `alpha` is the roughness of the microfacet distribution; 0 is smooth.
#[derive(Clone, Debug, PartialEq)]
pub enum BsdfDescription {
    Diffuse {
        reflectance: ColorTexture,
    },
    /// Two Lambertian lobes, one on each side.
    DiffuseTransmitter {
        reflectance: ColorTexture,
        transmittance: ColorTexture,
    },
    /// Metal: complex index of refraction `eta` + i`k`; `None` reflects all (a perfect mirror for `alpha` 0).
    Conductor {
        eta_k: Option<(Rgb, Rgb)>,
        specular_reflectance: ColorTexture,
        alpha: f32,
        distribution: MicrofacetDistribution,
    },
    /// Glass and water. `thin`: a pane whose two sides are one surface, so rays pass without bending.
    Dielectric {
        int_ior: f32,
        ext_ior: f32,
        specular_reflectance: Rgb,
        specular_transmittance: Rgb,
        alpha: f32,
        distribution: MicrofacetDistribution,
        thin: bool,
    },
    /// A diffuse base under a dielectric coat.
    Plastic {
        reflectance: ColorTexture,
        specular_reflectance: Rgb,
        int_ior: f32,
        ext_ior: f32,
        alpha: f32,
        distribution: MicrofacetDistribution,
        /// Colour shifts by internal scattering are taken into account.
        nonlinear: bool,
    },
    /// Disney's principled model (Burley 2012), opaque, isotropic: diffuse, metallic and clear-coat lobes.
    Principled {
        base_color: ColorTexture,
        metallic: f32,
        roughness: f32,
        specular: f32,
        spec_tint: f32,
        clearcoat: f32,
        clearcoat_gloss: f32,
        sheen: f32,
        sheen_tint: f32,
    },
    /// Lets everything through.
    Null,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum MicrofacetDistribution {
    #[default]
    Ggx,
    Beckmann,
}

/// A colour, constant or from a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum ColorTexture {
    Constant(Rgb),
    Image(ImageTexture),
}

/// A number, constant or from a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum ScalarTexture {
    Constant(f32),
    /// The alpha channel where the picture has one, else its luminance as stored (not decoded from sRGB).
    Image(ImageTexture),
    /// The luminance as stored, whatever the alpha channel says.
    Luminance(ImageTexture),
}

/// A picture on a surface. v points up: (0, 0) is the lower left corner. Outside of [0, 1) it repeats.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageTexture {
    pub path: PathBuf,
    /// Multiplies (u, v) first.
    pub scale: [f32; 2],
    /// Then added.
    pub offset: [f32; 2],
    /// Nearest texel instead of bilinear.
    pub nearest: bool,
    /// Multiplies the picture.
    pub tint: Rgb,
}

/// Lights that are not surfaces.
#[derive(Clone, Debug, PartialEq)]
pub enum LightDescription {
    /// Lat-long picture (EXR, linear): u = atan2(x, −z)/2π, v = acos(y)/π, row 0 is +y, in the light's own frame.
    Environment { path: PathBuf, scale: Rgb, to_world: Affine3A },
    /// The same radiance from everywhere.
    Constant { radiance: Rgb },
    /// `intensity` in W/sr.
    Point { position: Vec3, intensity: Rgb },
    /// Light travels along `direction`; `irradiance` in W/m² on a surface that faces it.
    Directional { direction: Vec3, irradiance: Rgb },
}

/// How paths are built.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegratorSettings {
    /// Path segments from the camera, at most: 1 sees emitters only, 2 direct light.
    pub max_depth: u32,
    /// Next-event estimation: every vertex looks at a light ("path reuse" in the paper).
    pub next_event: bool,
    /// Emitters that are hit count by the power heuristic; without it only what next-event estimation cannot reach counts.
    pub mis: bool,
    pub roulette: Roulette,
    /// Segments before roulette may end a path.
    pub rr_depth: u32,
    /// Guided roulette splits a path into at most this many.
    pub max_split: f32,
}

impl Default for IntegratorSettings {
    fn default() -> IntegratorSettings {
        IntegratorSettings {
            max_depth: 16,
            next_event: true,
            mis: true,
            roulette: Roulette::Guided,
            rr_depth: 5,
            max_split: 8.0,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Roulette {
    None,
    /// By what scattering alone would leave of the path's throughput, so that a guide's choices do not end its paths.
    Throughput,
    /// By what the guide expects of going on, against what it costs and what the pixel holds (Rath et al. 2022); where
    /// that is much, the path is split.
    Guided,
}

/// The guide: what is learnt, where, and how it is used.
#[derive(Clone, Debug, PartialEq)]
pub struct GuidingSettings {
    pub method: GuidingMethod,
    pub table: DirectionTable,
    /// Cells along the longest side of the scene; of an adaptive grid, the coarsest.
    pub resolution: u32,
    /// Quantised facing normals are part of a cell's key.
    pub normals: bool,
    /// Strata of the hemisphere along each side of its square: K = strata², and 2·strata² on the sphere.
    pub strata: u32,
    /// How often an adaptive grid halves its cells at most.
    pub levels: u8,
    /// Visits in an iteration, for each state, from which an adaptive grid cuts a cell.
    pub refine_visits: f32,
    /// Relative difference between neighbouring states from which an adaptive grid cuts a cell.
    pub refine_difference: f32,
    /// Share of a state's irradiance from which a tree cuts a cell of directions.
    pub split_share: f32,
    /// Visits that such a cell needs.
    pub split_visits: f32,
    pub rule: LearningRule,
    /// Of the blend: visits of a state at which its own estimate counts as much as what the path found.
    pub blend_visits: f32,
    pub rate: Rate,
    pub updates: Updates,
    pub sampling: GuideSampling,
    /// Share of directions drawn from the BSDF, in (0, 1]. Below 1 the mixture is defensive.
    pub bsdf_fraction: f32,
    /// That share is learnt, state by state; tables begin at one half, an SD-tree at `bsdf_fraction`. `None` stands for
    /// what is usual: an SD-tree learns it (Müller 2019), tables do not.
    pub learned_fraction: Option<bool>,
    /// Voronoi sites; 0 stands for as many as the memory has room for, which is the most in any case.
    pub sites: u32,
    pub placement: Placement,
    /// Of an SD-tree: a leaf is halved that got more than this many samples, times √(spp/4), in an iteration of spp
    /// samples per pixel.
    pub leaf_samples: f32,
    /// Of an SD-tree: share of a leaf's energy from which a cell of directions is divided.
    pub rho: f32,
    /// Of an SD-tree: records spread over a box as large as their cell of directions.
    pub directional_filter: bool,
    /// The guide leaves out what the BSDF's share of directions already covers.
    pub mis_compensation: bool,
    /// Share that a stratum's neighbours have in its estimate, in [0, 1).
    pub smoothing: f32,
    /// Look-ups are moved at random along the surface, so that neighbouring states blend; in an SD-tree, records are.
    pub jitter: bool,
    /// Bytes that tables and counts may take; beyond it no state is added.
    pub memory: u64,
}

impl Default for GuidingSettings {
    fn default() -> GuidingSettings {
        GuidingSettings {
            method: GuidingMethod::Adaptive,
            table: DirectionTable::Tree,
            resolution: 16,
            normals: true,
            strata: 12,
            levels: 4,
            refine_visits: 4000.0,
            refine_difference: 0.1,
            split_share: 0.02,
            split_visits: 32.0,
            rule: LearningRule::ExpectedSarsa,
            blend_visits: 1000.0,
            rate: Rate::Forgetting(0.5),
            updates: Updates::Frozen,
            sampling: GuideSampling::QCos,
            bsdf_fraction: 0.5,
            learned_fraction: None,
            sites: 2048,
            placement: Placement::Paths,
            leaf_samples: 12_000.0,
            rho: 0.01,
            directional_filter: true,
            mis_compensation: false,
            smoothing: 0.0,
            jitter: true,
            memory: 256 << 20,
        }
    }
}

impl GuidingSettings {
    /// Whether the share of directions drawn from the BSDF is learnt.
    pub fn learns_fraction(&self) -> bool {
        self.learned_fraction.unwrap_or(matches!(self.method, GuidingMethod::Adaptive | GuidingMethod::SdTree))
    }

    /// What is learnt of a path that went on: an SD-tree learns from whole paths, the rule is one of tables.
    pub fn rule_in_use(&self) -> LearningRule {
        if self.method == GuidingMethod::SdTree { LearningRule::MonteCarlo } else { self.rule }
    }
}

/// How the scene's surfaces are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuidingMethod {
    None,
    /// Cells of one size.
    Grid,
    /// Cells that refine where it pays.
    Adaptive,
    /// Sites on the surfaces, and what is nearest to each (Dahm & Keller 2017).
    Voronoi,
    /// Leaves of a spatial tree, each with a quadtree of directions in place of a table (Müller et al. 2017).
    SdTree,
}

impl GuidingMethod {
    /// All of them, by the names that scene files have for them.
    pub const NAMES: [(&'static str, GuidingMethod); 5] = [
        ("adaptive", GuidingMethod::Adaptive),
        ("grid", GuidingMethod::Grid),
        ("voronoi", GuidingMethod::Voronoi),
        ("sdtree", GuidingMethod::SdTree),
        ("none", GuidingMethod::None),
    ];

    pub fn name(self) -> &'static str {
        let named = GuidingMethod::NAMES.iter().find(|(_, method)| *method == self);
        named.expect("all have names").0
    }
}

/// Where Voronoi sites are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// Where the paths of the first iteration went: as dense as they are.
    Paths,
    /// On both sides of all surfaces, evenly by area.
    Area,
}

/// How the directions of a state are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DirectionTable {
    /// Strata of the hemisphere about the state's normal.
    Hemisphere,
    /// Strata of the sphere, the hemisphere being taken out at each query.
    Sphere,
    /// Cells of the hemisphere that are cut where the light is.
    Tree,
}

/// What is learnt of a path that went on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LearningRule {
    /// What the next vertex emits, and what its table expects to arrive there (Dahm & Keller 2017).
    ExpectedSarsa,
    /// The same with the table's best direction for all (Watkins; the paper's eq. 3).
    QLearning,
    /// What the whole path brought.
    MonteCarlo,
    /// Expectation and finding, weighed by the visits behind the expectation.
    Blend,
}

/// How much a visit changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rate {
    /// 1/n.
    Vanishing,
    /// The same always.
    Constant(f32),
    /// 1/n, n keeping only this share of itself when an iteration ends.
    Forgetting(f32),
}

/// When what is learnt is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Updates {
    /// From the next iteration on.
    Frozen,
    /// From the next few blocks on.
    Online,
}

/// What guided directions are drawn in proportion to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuideSampling {
    /// Q (Dahm & Keller 2017).
    Q,
    /// Q cosθ.
    QCos,
    /// Q f cosθ, stratum by stratum; a Lambertian surface needs no more than Q cosθ for it.
    Product,
}

/// How long, from which numbers, and what becomes of the iterations.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Samples per pixel over all iterations.
    pub spp: u32,
    /// Seconds after loading; rendering stops at whichever of `spp` and `time` comes first.
    pub time: Option<f64>,
    pub seed: u64,
    pub combine: Combine,
    pub order: Order,
    /// Watertight ray queries: no ray slips between two triangles that share an edge, for about a quarter of the speed.
    pub robust: bool,
}

impl Default for RenderSettings {
    fn default() -> RenderSettings {
        RenderSettings {
            spp: 64,
            time: None,
            seed: 0,
            combine: Combine::InverseVariance,
            order: Order::Progressive,
            robust: false,
        }
    }
}

/// Which samples come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Passes over the whole picture, in iterations of doubling length.
    Progressive,
    /// One block after the other, each with all of its samples, from the middle outwards: a single iteration.
    Blocks,
}

/// What becomes of the iterations' pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Combine {
    /// Only the last counts (the paper).
    Last,
    /// All samples count alike.
    All,
    /// Each picture is weighted by the inverse of its estimated variance (Müller et al. 2017).
    InverseVariance,
}

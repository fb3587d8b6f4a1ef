//! How the guide is asked for.

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
    /// That share is learnt, region by region (Müller 2019), beginning at `bsdf_fraction`. `None` stands for what is usual:
    /// adaptive grids and SD-trees learn it, others do not.
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
            method: GuidingMethod::Auto,
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
        self.learned_fraction.unwrap_or(matches!(self.method.model(), GuidingMethod::Adaptive | GuidingMethod::SdTree))
    }

    /// What is learnt of a path that went on: an SD-tree learns from whole paths, the rule is one of tables.
    pub fn rule_in_use(&self) -> LearningRule {
        if self.method == GuidingMethod::SdTree { LearningRule::MonteCarlo } else { self.rule }
    }
}

/// How the scene's surfaces are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuidingMethod {
    /// `Adaptive`, for as long as it pays.
    Auto,
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
    pub const NAMES: [(&'static str, GuidingMethod); 6] = [
        ("auto", GuidingMethod::Auto),
        ("adaptive", GuidingMethod::Adaptive),
        ("grid", GuidingMethod::Grid),
        ("voronoi", GuidingMethod::Voronoi),
        ("sdtree", GuidingMethod::SdTree),
        ("none", GuidingMethod::None),
    ];

    /// How states are told apart.
    pub fn model(self) -> GuidingMethod {
        if self == GuidingMethod::Auto { GuidingMethod::Adaptive } else { self }
    }

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
    /// Q cosθ, times what glossy metal reflects, along the path that a draw takes through a tree.
    GlossyProduct,
    /// Q f cosθ, stratum by stratum; a Lambertian surface needs no more than Q cosθ for it.
    Product,
}

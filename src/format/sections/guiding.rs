//! `[guiding]`. The guide itself knows nothing of documents, so that it could be a crate of its own; its keys are read here.

use crate::document::{Bounds, Fault, Key, NOT_NEGATIVE, Reader, UNIT, key};
use crate::guiding::settings::{
    DirectionTable, GuideSampling, GuidingMethod, GuidingSettings, LearningRule, Placement, Rate, Updates,
};

/// Without any share for the BSDF, light that the guide does not know of would be missing.
const FRACTION: Bounds = Bounds::new(|x| x > 0.0 && x <= 1.0, "greater than 0 and at most 1");
/// An adaptive guide holds a number for each of its coarse cells, empty ones too.
const MAX_COARSE: u32 = 128;

/// The methods, as users choose them.
pub(crate) const METHODS: [(&str, &str); 6] = [
    ("auto", "`adaptive` for as long as that pays: judged by the variance and the cost of the first iterations"),
    ("adaptive", "cells of a grid that refine where it pays, by position and facing normal"),
    ("grid", "cells of a uniform grid (Dahm & Keller 2017)"),
    ("voronoi", "cells about sites on the surfaces (Dahm & Keller 2017)"),
    (
        "sdtree",
        "leaves of a spatial tree, learnt from whole paths (Practical Path Guiding: Müller et al. 2017, Müller 2019)",
    ),
    ("none", "no guide: directions from the material, and next-event estimation"),
];

const TABLES: &[(&str, DirectionTable)] =
    &[("tree", DirectionTable::Tree), ("hemisphere", DirectionTable::Hemisphere), ("sphere", DirectionTable::Sphere)];
const SAMPLINGS: &[(&str, GuideSampling)] =
    &[("q-cos", GuideSampling::QCos), ("product", GuideSampling::Product), ("q", GuideSampling::Q), GLOSSY_SAMPLING];
/// With trees alone.
const GLOSSY_SAMPLING: (&str, GuideSampling) = ("glossy-product", GuideSampling::GlossyProduct);
const RULES: &[(&str, LearningRule)] = &[
    ("expected-sarsa", LearningRule::ExpectedSarsa),
    ("q-learning", LearningRule::QLearning),
    ("monte-carlo", LearningRule::MonteCarlo),
    ("blend", LearningRule::Blend),
];

const GUIDED: &str = "`method` other than `\"none\"`";
const TABULAR: &str = "`method` other than `\"sdtree\"` and `\"none\"`";
const CELLS: &str = "`method` one of `\"auto\"`, `\"adaptive\"` and `\"grid\"`";
const VORONOI: &str = "`method = \"voronoi\"`";
const STRATA: &str = "`table = \"hemisphere\"` or `\"sphere\"`";
const TREE: &str = "`table = \"tree\"`";
const HEMISPHERE: &str = "`table = \"tree\"` or `\"hemisphere\"`";
const LEARNED: &str = "the share of directions drawn from the BSDF is learnt, state by state (Müller 2019), beginning at \
    `bsdf_fraction`; without this key, adaptive states and SD-trees learn it, others do not";
const ADAPTIVE: &str = "`method = \"auto\"` or `\"adaptive\"`";

/// Reads the section over what there is. A key that means nothing with the method, table or rule in use is refused.
pub(in crate::format) fn guiding(t: &mut Reader, s: &mut GuidingSettings) -> Result<(), Fault> {
    t.choice(
        key("method", "where the guide keeps what it learns, as described above"),
        &GuidingMethod::NAMES,
        &mut s.method,
    )?;
    space(t, s)?;
    directions(t, s)?;
    learning(t, s)?;
    sampling(t, s)?;
    sd_tree(t, s)?;
    let memory = "what tables and counts may take; with a unit (B, KiB, MiB, GiB, TiB, kB, MB, GB, TB) if it is a string; more \
        than there is free is refused";
    t.memory(key("memory", memory).unit("bytes").only(s.method != GuidingMethod::None, GUIDED), &mut s.memory)?;
    check_updates(t, s)
}

/// Whether directions are kept in tables, of fixed strata or of trees, and not in an SD-tree's quadtrees.
fn tabular(s: &GuidingSettings) -> bool {
    !matches!(s.method, GuidingMethod::SdTree | GuidingMethod::None)
}

fn uses(s: &GuidingSettings, methods: &[GuidingMethod]) -> bool {
    methods.contains(&s.method.model())
}

/// Where states are told apart.
fn space(t: &mut Reader, s: &mut GuidingSettings) -> Result<(), Fault> {
    use GuidingMethod::{Adaptive, Grid, Voronoi};
    let (grid, adaptive, voronoi) = (uses(s, &[Grid]), uses(s, &[Adaptive]), uses(s, &[Voronoi]));
    let resolution = "along the longest side of the scene; of `\"adaptive\"` the coarsest, 128 at most, and smaller from the start \
                      where most paths stay within a small part";
    let resolution = key("resolution", resolution);
    t.integer(resolution.unit("cells").only(grid || adaptive, CELLS), 1..=8192, &mut s.resolution)?;
    let normals = "surfaces that face elsewhere have their own states; `\"adaptive\"` always does so";
    t.flag(key("normals", normals).only(grid, "`method = \"grid\"`"), &mut s.normals)?;
    let levels = key("levels", "of a cell of `\"adaptive\"` at most").unit("halvings");
    t.integer(levels.only(adaptive, ADAPTIVE), 0..=4, &mut s.levels)?;
    let visits = "to each state of a cell in an iteration, above which `\"adaptive\"` may halve it";
    let visits = key("refine_visits", visits).unit("visits").only(adaptive, ADAPTIVE);
    t.number(visits, NOT_NEGATIVE, &mut s.refine_visits)?;
    let difference = "mean relative difference between a cell's states and their neighbours, above which `\"adaptive\"` may halve it";
    t.number(key("refine_difference", difference).only(adaptive, ADAPTIVE), UNIT, &mut s.refine_difference)?;
    let sites =
        "sites at most; 0 is as many as `memory` has room for with the tables, and more than that there never are";
    t.integer(key("sites", sites).only(voronoi, VORONOI), 0..=1 << 24, &mut s.sites)?;
    let placements = [("paths", Placement::Paths), ("area", Placement::Area)];
    let placement = "sites are placed where the paths of the first iteration went, which then learns nothing else (at most one \
        site for 4 vertices), or evenly on both sides of all surfaces";
    t.choice(key("placement", placement).only(voronoi, VORONOI), &placements, &mut s.placement)?;
    if adaptive && s.resolution > MAX_COARSE {
        let message =
            format!("`resolution` must be at most {MAX_COARSE} with method `adaptive`, found {}", s.resolution);
        return Err(Fault::new(t.place(&["resolution", "method"]), message));
    }
    Ok(())
}

/// The table of a state.
fn directions(t: &mut Reader, s: &mut GuidingSettings) -> Result<(), Fault> {
    let table = "directions of a state: cells of the hemisphere that are cut where the light is, fixed strata of the hemisphere, or \
        fixed strata of the sphere, out of which the hemisphere is taken at each look-up";
    t.choice(key("table", table).only(tabular(s), TABULAR), TABLES, &mut s.table)?;
    let tree = tabular(s) && s.table == DirectionTable::Tree;
    let strata =
        "along each side of the hemisphere's square: its square is the number of strata, twice that on the sphere";
    t.integer(key("strata", strata).only(tabular(s) && !tree, STRATA), 1..=256, &mut s.strata)?;
    let share = "of a state's irradiance, above which a `\"tree\"` cuts a cell of directions";
    t.number(key("split_share", share).only(tree, TREE), UNIT, &mut s.split_share)?;
    let visits = key("split_visits", "that such a cell needs").unit("visits");
    t.number(visits.only(tree, TREE), NOT_NEGATIVE, &mut s.split_visits)?;
    let smoothing = "share that a stratum's neighbours have in its estimate";
    t.number(key("smoothing", smoothing).only(tabular(s) && !tree, STRATA), UNIT, &mut s.smoothing)
}

/// What a table learns, and when.
fn learning(t: &mut Reader, s: &mut GuidingSettings) -> Result<(), Fault> {
    let tabular = tabular(s);
    let rule = "what is learnt of a direction: what the next vertex adds and its table expects (in the mean, or of its best \
        direction for all), what the whole path brought, or both by the visits behind the expectation";
    t.choice(key("rule", rule).only(tabular, TABULAR), RULES, &mut s.rule)?;
    let blend = tabular && s.rule == LearningRule::Blend;
    let visits = key("blend_visits", "where expectation and finding count alike").unit("visits");
    t.number(visits.only(blend, "`rule = \"blend\"`"), NOT_NEGATIVE, &mut s.blend_visits)?;
    rate(t, s, tabular)?;
    let updates = [("frozen", Updates::Frozen), ("online", Updates::Online)];
    let when = "when what is learnt is used: in the next iteration, or from the next few blocks on; only the former with `\"auto\"` and `\"sdtree\"`";
    t.choice(key("updates", when).only(s.method != GuidingMethod::None, GUIDED), &updates, &mut s.updates)
}

/// `rate`, and the number that it has.
fn rate(t: &mut Reader, s: &mut GuidingSettings, tabular: bool) -> Result<(), Fault> {
    let (mut alpha, mut retain) = (0.1, 0.5);
    match s.rate {
        Rate::Constant(a) => alpha = a,
        Rate::Forgetting(r) => retain = r,
        Rate::Vanishing => {}
    }
    let names = ["forgetting", "vanishing", "constant"];
    let current = match s.rate {
        Rate::Forgetting(_) => 0,
        Rate::Vanishing => 1,
        Rate::Constant(_) => 2,
    };
    let numbered = [(names[0], 0), (names[1], 1), (names[2], 2)];
    let mut chosen = current;
    let meaning = "weight of a visit: 1/n with visits that fade, 1/n, or always the same";
    t.choice(key("rate", meaning).only(tabular, TABULAR), &numbered, &mut chosen)?;
    let constant =
        key("alpha", "the weight that `\"constant\"` gives").only(tabular && chosen == 2, "`rate = \"constant\"`");
    t.number(constant, UNIT, &mut alpha)?;
    let fading = key(
        "retain",
        "of `\"forgetting\"`: share of the weight that visits keep each time that the paths learnt from double",
    );
    t.number(fading.only(tabular && chosen == 0, "`rate = \"forgetting\"`"), UNIT, &mut retain)?;
    s.rate = [Rate::Forgetting(retain), Rate::Vanishing, Rate::Constant(alpha)][chosen];
    Ok(())
}

/// How directions are drawn.
fn sampling(t: &mut Reader, s: &mut GuidingSettings) -> Result<(), Fault> {
    let (guided, tabular) = (s.method != GuidingMethod::None, tabular(s));
    let what = "what directions are drawn in proportion to: expected radiance times cosine, the same times the guided lobes of the \
        BSDF (for surfaces that are not Lambertian; the look-up asks the BSDF for every stratum), radiance alone, or, with `table = \"tree\"`, \
        as the first and for glossy metal times what it reflects ([guide.md](guide.md#glossy-surfaces))";
    let known = if s.table == DirectionTable::Tree { SAMPLINGS } else { &SAMPLINGS[..SAMPLINGS.len() - 1] };
    t.choice(key("sampling", what).only(tabular, TABULAR), known, &mut s.sampling)?;
    let mut learned = s.learns_fraction();
    t.flag(key("learned_fraction", LEARNED).optional().only(guided, GUIDED), &mut learned)?;
    s.learned_fraction = if t.has("learned_fraction") { Some(learned) } else { s.learned_fraction };
    let fraction = "of the directions of guided lobes, the share drawn from the BSDF where the guide knows a state; where it is \
        learnt, learning begins with it";
    t.number(key("bsdf_fraction", fraction).only(guided, GUIDED), FRACTION, &mut s.bsdf_fraction)?;
    let compensation = "the guide leaves out what the BSDF's share already covers";
    let hemisphere = tabular && s.table != DirectionTable::Sphere;
    t.flag(key("mis_compensation", compensation).only(hemisphere, HEMISPHERE), &mut s.mis_compensation)?;
    let jitter = "look-ups are moved at random along the surface, so that neighbouring states blend";
    t.flag(key("jitter", jitter).only(guided, GUIDED), &mut s.jitter)
}

fn sd_tree(t: &mut Reader, s: &mut GuidingSettings) -> Result<(), Fault> {
    let own = |k: Key| k.only(s.method == GuidingMethod::SdTree, "`method = \"sdtree\"`");
    let samples = "a leaf is halved that got more than this many times √(n/3686400) in an iteration of n paths, which are 4 samples per pixel of 1280 × 720";
    t.number(own(key("leaf_samples", samples).unit("samples")), NOT_NEGATIVE, &mut s.leaf_samples)?;
    let rho = "share of a leaf's energy from which a cell of directions is divided";
    t.number(own(key("rho", rho)), UNIT, &mut s.rho)?;
    let filter = "a record spreads over a box as large as its cell of directions";
    t.flag(own(key("directional_filter", filter)), &mut s.directional_filter)
}

/// An SD-tree's snapshots are of whole iterations, and of whole iterations is judged whether a guide pays.
fn check_updates(t: &Reader, s: &GuidingSettings) -> Result<(), Fault> {
    if matches!(s.method, GuidingMethod::SdTree | GuidingMethod::Auto) && s.updates == Updates::Online {
        let at = t.place(&["updates", "method"]);
        let message = format!("`updates` must be \"frozen\" where `method` is \"{}\"", s.method.name());
        return Err(Fault::new(at, message));
    }
    Ok(())
}

//! What is made of the list of BSDFs in [`super`].

/// Matches a kind of scattering and evaluates an expression with what it holds.
macro_rules! dispatch {
    ($enum:ident, $value:expr, [$($Kind:ident)*], $b:ident => $e:expr) => {
        match $value { $($enum::$Kind($b) => $e,)* }
    };
}

/// Each line of the list is a type of material: the name in scene files, the variant and the file with its parameters as
/// written, and the kinds of scattering that they may become ([`Prepared`](super::model::Prepared)), by their variants.
macro_rules! bsdfs {
    ($($name:literal = $Type:ident($module:ident::$Parameters:ident) => $($Kind:ident($prepared:ty)),+;)*) => {
        $(pub use $module::$Parameters;)*

        /// The types of scattering as written.
        #[derive(Clone, Debug, PartialEq)]
        pub enum BsdfDescription { $($Type($Parameters),)* }

        /// The same without parameters: the values of a material's `type`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum BsdfType { $($Type,)* }

        impl BsdfType {
            /// All types, by name.
            pub(crate) const NAMES: &'static [(&'static str, BsdfType)] = &[$(($name, BsdfType::$Type),)*];

            pub(crate) fn name(self) -> &'static str {
                match self { $(BsdfType::$Type => $name,)* }
            }

            /// As of [`BsdfParameters::OPAQUE`].
            pub(crate) fn is_opaque(self) -> bool {
                match self { $(BsdfType::$Type => $Parameters::OPAQUE,)* }
            }

            /// As of [`BsdfParameters::IS_SURFACE`].
            pub(crate) fn is_surface(self) -> bool {
                match self { $(BsdfType::$Type => $Parameters::IS_SURFACE,)* }
            }

            /// The type with its defaults.
            pub(crate) fn bsdf(self) -> BsdfDescription {
                match self { $(BsdfType::$Type => BsdfDescription::$Type($Parameters::default()),)* }
            }
        }

        impl BsdfDescription {
            pub(crate) fn bsdf_type(&self) -> BsdfType {
                match self { $(BsdfDescription::$Type(_) => BsdfType::$Type,)* }
            }

            /// As of [`BsdfParameters::NUMBER`].
            pub(crate) fn number(&self) -> u32 {
                match self { $(BsdfDescription::$Type(_) => $Parameters::NUMBER,)* }
            }

            fn model(&self, tables: &mut BsdfTables) -> Result<Model> {
                match self { $(BsdfDescription::$Type(p) => p.model(tables),)* }
            }
        }

        impl Fields for BsdfDescription {
            fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error> {
                match self { $(BsdfDescription::$Type(p) => p.fields(visitor),)* }
            }
        }

        $(impl From<$Parameters> for BsdfDescription {
            fn from(parameters: $Parameters) -> BsdfDescription {
                BsdfDescription::$Type(parameters)
            }
        })*

        /// The kinds of scattering for a whole material: what does not depend on the place.
        #[derive(Clone, Debug)]
        pub(crate) enum Model { $($($Kind($prepared),)+)* }

        $($(impl From<$prepared> for Model {
            fn from(prepared: $prepared) -> Model {
                Model::$Kind(prepared)
            }
        })+)*

        impl Model {
            /// What is worth to be computed once for a place.
            #[inline(never)]
            fn colors(&self, colors: [Rgb; 2]) -> [Rgb; 2] {
                dispatch!(Model, self, [$($($Kind)+)*], m => m.colors(colors))
            }

            fn in_lanes(&self) -> bool {
                dispatch!(Model, self, [$($($Kind)+)*], m => m.in_lanes())
            }

            fn draws_in_lanes(&self) -> bool {
                dispatch!(Model, self, [$($($Kind)+)*], m => m.draws_in_lanes())
            }

            fn draw_lanes(&self, surfaces: &SameMaterial, numbers: &LobeNumbers, wi: &mut Vec3Lanes) {
                dispatch!(Model, self, [$($($Kind)+)*], m => m.draw_lanes(surfaces, numbers, wi))
            }

            fn eval_pdf_lanes(&self, surfaces: &SameMaterial, wi: &Vec3Lanes, f: &mut Vec3Lanes, pdf: &mut Lanes) {
                dispatch!(Model, self, [$($($Kind)+)*], m => m.eval_pdf_lanes(surfaces, wi, f, pdf))
            }

            fn albedo_lanes(&self, surfaces: &SameMaterial, albedo: &mut Vec3Lanes) {
                dispatch!(Model, self, [$($($Kind)+)*], m => m.albedo_lanes(surfaces, albedo))
            }

            /// With the colours of [`Self::colors`].
            #[inline(always)]
            fn at(&self, colors: [Rgb; 2]) -> BsdfKind<'_> {
                match self { $($(Model::$Kind(m) => BsdfKind::$Kind(m.at(colors)),)+)* }
            }
        }

        /// The kinds of scattering at one point of a surface: textures are evaluated, tables are borrowed.
        #[derive(Clone, Copy, Debug)]
        pub(crate) enum BsdfKind<'s> { $($($Kind(<$prepared as Prepared>::At<'s>),)+)* }

        impl BsdfKind<'_> {
            /// Whether any lobe is smooth, whether light never crosses, and [`Bsdf::roughness`]: the same for all colours.
            fn traits(&self) -> (bool, bool, f32) {
                fn of<S: Scatter>(b: &S) -> (bool, bool, f32) {
                    (S::SMOOTH, S::OPAQUE, b.roughness().min(1.0))
                }
                dispatch!(BsdfKind, self, [$($($Kind)+)*], b => of(b))
            }

            #[inline(always)]
            fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
                dispatch!(BsdfKind, self, [$($($Kind)+)*], b => b.eval_pdf(wo, wi))
            }

            #[inline(always)]
            fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
                dispatch!(BsdfKind, self, [$($($Kind)+)*], b => b.sample(wo, u_lobe, u))
            }

            #[inline(always)]
            fn albedo(&self, wo: Vec3) -> Rgb {
                dispatch!(BsdfKind, self, [$($($Kind)+)*], b => b.albedo(wo))
            }

            #[inline(always)]
            fn sharp_probability(&self, wo: Vec3, alpha: f32) -> f32 {
                dispatch!(BsdfKind, self, [$($($Kind)+)*], b => b.sharp_probability(wo, alpha))
            }

            #[inline(always)]
            fn eval_pdf_rough(&self, wo: Vec3, wi: Vec3, alpha: f32) -> (Rgb, f32) {
                dispatch!(BsdfKind, self, [$($($Kind)+)*], b => b.eval_pdf_rough(wo, wi, alpha))
            }

            #[inline(always)]
            fn gloss(&self, wo: Vec3) -> Option<Gloss> {
                dispatch!(BsdfKind, self, [$($($Kind)+)*], b => b.gloss(wo))
            }

            #[inline(always)]
            fn diffuse_albedo(&self, wo: Vec3) -> Rgb {
                dispatch!(BsdfKind, self, [$($($Kind)+)*], b => b.diffuse_albedo(wo))
            }
        }
    };
}

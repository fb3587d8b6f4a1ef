//! What is made of the list of lights in [`super`].

/// Each line of the list is a type of light: the name in scene files, the variant, the file with its parameters as written,
/// and what samples it ([`LightSource`](super::source::LightSource)).
macro_rules! lights {
    ($($name:literal = $Type:ident($module:ident::$Parameters:ident) => $ready:ty;)*) => {
        $(pub use $module::$Parameters;)*

        /// Lights that are not surfaces, as written.
        #[derive(Clone, Debug, PartialEq)]
        pub enum LightDescription { $($Type($Parameters),)* }

        /// The same without parameters: the values of a light's `type`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum LightType { $($Type,)* }

        impl LightType {
            /// All types, by name.
            pub(crate) const NAMES: &'static [(&'static str, LightType)] = &[$(($name, LightType::$Type),)*];

            /// The type before anything is said of it.
            pub(crate) fn light(self) -> LightDescription {
                match self { $(LightType::$Type => LightDescription::$Type($Parameters::default()),)* }
            }
        }

        impl LightDescription {
            /// The name of its type.
            pub fn type_name(&self) -> &'static str {
                match self { $(LightDescription::$Type(_) => $name,)* }
            }

            /// As of [`LightParameters::NUMBER`].
            pub(crate) fn number(&self) -> u32 {
                match self { $(LightDescription::$Type(_) => $Parameters::NUMBER,)* }
            }

            /// As of [`LightParameters::translate`].
            pub(crate) fn translate(&mut self, by: DVec3) {
                match self { $(LightDescription::$Type(p) => p.translate(by),)* }
            }

            /// As of [`LightParameters::load`].
            pub(crate) fn load(&self, findings: &mut Findings) -> Result<Light> {
                match self { $(LightDescription::$Type(p) => p.load(findings).map(Light::$Type),)* }
            }
        }

        impl Fields for LightDescription {
            fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error> {
                match self { $(LightDescription::$Type(p) => p.fields(visitor),)* }
            }
        }

        $(impl From<$Parameters> for LightDescription {
            fn from(parameters: $Parameters) -> LightDescription {
                LightDescription::$Type(parameters)
            }
        })*

        /// A light that is not a surface.
        #[derive(Clone, Debug)]
        pub(crate) enum Light { $($Type($ready),)* }

        $(impl From<$ready> for Light {
            fn from(light: $ready) -> Light {
                Light::$Type(light)
            }
        })*

        impl LightSource for Light {
            fn checked(self) -> Result<Light> {
                match self { $(Light::$Type(light) => light.checked().map(Light::$Type),)* }
            }

            fn power(&self, section: f64) -> f64 {
                match self { $(Light::$Type(light) => light.power(section),)* }
            }

            fn extent(&self) -> Extent {
                match self { $(Light::$Type(light) => light.extent(),)* }
            }

            fn brightness(&self, scene_radius: f64) -> f64 {
                match self { $(Light::$Type(light) => light.brightness(scene_radius),)* }
            }

            fn scaled(self, factor: f64) -> Light {
                match self { $(Light::$Type(light) => Light::$Type(light.scaled(factor)),)* }
            }

            fn sample(&self, p: Vec3, u_cell: f64, u: [f32; 2]) -> Option<LightSample> {
                match self { $(Light::$Type(light) => light.sample(p, u_cell, u),)* }
            }

            fn sample_lanes(
                &self,
                lanes: Mask,
                p: &Vec3Lanes,
                u_cell: &[f64; LANES],
                u: &[Lanes; 2],
                samples: &mut [Option<LightSample>; LANES],
            ) {
                match self { $(Light::$Type(light) => light.sample_lanes(lanes, p, u_cell, u, samples),)* }
            }

            fn surrounds(&self) -> bool {
                match self { $(Light::$Type(light) => light.surrounds(),)* }
            }

            fn radiance(&self, wi: Vec3) -> Rgb {
                match self { $(Light::$Type(light) => light.radiance(wi),)* }
            }

            fn pdf(&self, wi: Vec3) -> f32 {
                match self { $(Light::$Type(light) => light.pdf(wi),)* }
            }
        }
    };
}

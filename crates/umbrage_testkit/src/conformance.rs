//! Promises that every part makes, held by one call.
//!
//! ```no_run
//! use umbrage_testkit::{Limits, conformance};
//!
//! # fn package() -> Result<umbrage_compose::Package, umbrage_compose::Error> { umbrage_shader_lib::package() }
//! # fn registry() -> umbrage_shadow::Registry { umbrage_shadow::Registry::new() }
//! // A package of shaders and a registry with parts of one's own, and the table that lists variants of them.
//! let limits = Limits::built_in()?;
//! let held = conformance([package()?], registry(), &limits, &["pssm hpsm"])?;
//! assert!(held.pictures > 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::{error::Error, fmt, sync::Arc};

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use umbrage_compose::{Composer, Library, Package, Target};
use umbrage_measure::{
    cases::{self, Limits},
    study::{Config, Lab, stress},
};
use umbrage_render::{
    Camera, Gpu, Material, Mesh, Object, Path, Picture, RenderOptions, Rendered, Renderer, Scene,
    SceneLight, What,
};
use umbrage_shadow::{Field, Light, LightKind, Registry, Support, look_along};

/// Counts of what was tried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Held {
    /// Variants.
    pub variants: usize,
    /// Kinds of light under which variants cast shadows, added up.
    pub lights: usize,
    /// Pictures of the small scene.
    pub pictures: usize,
    /// Hard cases, each with each variant.
    pub cases: usize,
}

/// Promises that are broken: of which variant, under which light, and how.
#[derive(Clone, Debug)]
pub struct Broken(pub Vec<String>);

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.join("\n"))
    }
}

impl Error for Broken {}

/// Holds variants of parts to what all parts promise, and in the hard cases to `limits`: those of the table that are `named`,
/// or all of it where none is. `packages` have the parts' shaders, our own shader library among them.
///
/// Under each kind of light that a variant supports, in a small scene:
/// - it plans for a scene without objects, and twice the same for one frame;
/// - shadow terms are numbers from 0 to 1, some of which are dark and some light;
/// - a thousand kilometres from the origin, shadows lie where they lie at it;
/// - a second renderer draws the same bits, and in a still scene no pass is run again;
/// - no pixel takes more fetches than the plan says;
/// - the mask path, and one shader for all lights, draw what the forward path draws.
///
/// # Errors
/// [`Broken`] with all that does not hold; shaders that cannot be linked, a device that there is not.
pub fn conformance(
    packages: impl IntoIterator<Item = Package>,
    registry: Registry,
    limits: &Limits,
    named: &[&str],
) -> Result<Held, Box<dyn Error>> {
    let library = Library::new(packages)?;
    let composer = Arc::new(Composer::new(library, Target::webgpu()));
    let gpu = Arc::new(Gpu::new()?);
    let methods: Vec<_> = registry.methods.names().map(str::to_owned).collect();
    let mut variants = limits.variants_of(&methods, &registry, composer.library())?;
    variants.retain(|variant| named.is_empty() || named.contains(&variant.name.as_str()));
    let mut kit = Kit {
        registry: &registry,
        composer: &composer,
        gpu: &gpu,
        held: Held::default(),
        broken: Vec::new(),
    };
    let listed = limits
        .variants()
        .iter()
        .map(|variant| variant.name.as_str());
    let wanted: Vec<_> = match named {
        [] => listed.collect(),
        named => named.to_vec(),
    };
    for name in wanted {
        if variants.iter().all(|variant| variant.name != name) {
            kit.broken
                .push(format!("no method has the variant `{name}`"));
        }
    }
    for variant in &variants {
        kit.variant(variant)?;
    }
    kit.hard_cases(limits, &variants)?;
    match kit.broken.is_empty() {
        true => Ok(kit.held),
        false => Err(Broken(kit.broken).into()),
    }
}

struct Kit<'a> {
    registry: &'a Registry,
    composer: &'a Arc<Composer>,
    gpu: &'a Arc<Gpu>,
    held: Held,
    broken: Vec<String>,
}

/// A thousand kilometres, in a step that numbers near it hold exactly.
const FAR: f64 = 1_048_576.0;

/// The most that a mask's shadow term may be off: a rasteriser's positions are on a grid of 1/256 pixel.
const STEP: f32 = 1.0 / 256.0;

/// The share of pixels that may differ by more: where the grid's width decides.
const DECISIONS: f64 = 1e-3;

/// Pixels of a picture.
const SIZE: [u32; 2] = [120, 80];

impl Kit<'_> {
    fn renderer(&self) -> Renderer {
        let (gpu, composer) = (Arc::clone(self.gpu), Arc::clone(self.composer));
        Renderer::new(gpu, composer, self.registry.clone())
    }

    fn variant(&mut self, variant: &Config) -> Result<(), Box<dyn Error>> {
        self.held.variants += 1;
        let before = self.held.lights;
        let library = self.composer.library();
        let checked = variant.shadow.check(self.registry, library)?;
        for kind in kinds() {
            let light = Light {
                kind,
                color: Vec3::splat(8.0),
            };
            if let Support::No(_) = checked.method().supports(&light) {
                continue;
            }
            let choices = checked.choices(&light);
            if library
                .key(choices.chain([("pass", "shadow_term")]))
                .is_err()
            {
                continue;
            }
            self.held.lights += 1;
            if let Err(problem) = self.lit(variant, &light) {
                let name = light.kind.name();
                self.broken
                    .push(format!("{} under a {name} light: {problem}", variant.name));
            }
        }
        if self.held.lights == before {
            self.broken
                .push(format!("{} supports no light", variant.name));
        }
        Ok(())
    }

    /// Holds a variant to its promises under one light.
    fn lit(&mut self, variant: &Config, light: &Light) -> Result<(), Box<dyn Error>> {
        let scene = scene(light, DVec3::ZERO);
        let options = |what, path| RenderOptions {
            width: SIZE[0],
            height: SIZE[1],
            what,
            path,
            shadow: variant.shadow.clone(),
            ..RenderOptions::default()
        };
        let term = options(What::ShadowTerm, Path::Forward);
        let mut renderer = self.renderer();
        let mut draw = |scene: &Scene, options: &RenderOptions| {
            self.held.pictures += 1;
            renderer.render(scene, options)
        };

        let bare = Scene {
            objects: Vec::new(),
            ..scene.clone()
        };
        draw(&bare, &term).map_err(|e| format!("a scene without objects is refused: {e}"))?;

        let first = draw(&scene, &term)?;
        let own = terms(&first);
        if let Some(bad) = own.iter().find(|term| !(0.0..=1.0).contains(*term)) {
            return Err(format!("a shadow term is {bad}").into());
        }
        let dark = own.iter().filter(|term| **term < 0.25).count();
        let bright = own.iter().filter(|term| **term > 0.75).count();
        if dark < 100 || bright < 1000 {
            return Err(format!("{dark} pixels are dark, {bright} are bright").into());
        }

        let still = draw(&scene, &term)?;
        let ran = still.report.caster_passes + still.report.derived_passes;
        if ran > 0 {
            return Err(format!("in a still scene, {ran} passes are run again").into());
        }
        if terms(&still) != own {
            return Err("in a still scene, the picture changes".into());
        }

        let away = draw(&self::scene(light, DVec3::new(FAR, 0.0, -FAR)), &term)?;
        let apart = own.iter().zip(terms(&away));
        let apart: f64 = apart.map(|(a, b)| f64::from((a - b).abs())).sum();
        let mean = apart / own.len() as f64;
        // Texels lie elsewhere there: edges move by a part of one.
        if mean.is_nan() || mean > 0.02 {
            return Err(format!("{FAR} m from the origin, terms are {mean} apart").into());
        }

        let mask = draw(&scene, &options(What::ShadowTerm, Path::Mask))?;
        let apart = own.iter().zip(terms(&mask));
        // NaN is apart.
        let near = apart.filter(|(a, b)| (*a - *b).abs() <= STEP).count();
        let share = 1.0 - near as f64 / own.len() as f64;
        if share > DECISIONS {
            return Err(format!("a mask's term is another in {share} of the pixels").into());
        }

        let shaded = |rendered: &Rendered| match &rendered.picture {
            Picture::Shaded(pixels) => pixels.as_flattened().to_vec(),
            _ => Vec::new(),
        };
        let several = self::several(light);
        let each = shaded(&draw(&several, &options(What::Shaded, Path::Forward))?);
        let all = shaded(&draw(&several, &options(What::Shaded, Path::ForwardAll))?);
        // Half floats, rounded once for each light: normal ones by their place, small ones by the least step.
        let rounding = |value: f32| 3.0 * (value / 1024.0).max(2f32.powi(-24));
        let alike = |(a, b): (&f32, &f32)| (a - b).abs() <= rounding(a.max(*b));
        if each.is_empty() || !each.iter().zip(&all).all(alike) {
            return Err("two such lights in one shader are not the sum of each".into());
        }

        let counted = draw(&scene, &options(What::Fetches, Path::Forward))?;
        if let Picture::Fetches(counts) = &counted.picture {
            let most = counts.iter().flatten().fold(0.0, |a: f32, b| a.max(*b));
            let plans = counted.report.plans.iter().flatten();
            let told = plans.map(|plan| plan.fetches_per_pixel).max().unwrap_or(0);
            if f64::from(most) > f64::from(told) {
                return Err(format!("{most} fetches for a pixel, but the plan says {told}").into());
            }
        }

        let plans = [&first, &still, &mask].map(|rendered| &rendered.report.plans);
        if plans.iter().any(|plan| *plan != plans[0]) {
            return Err("one frame is planned in two ways".into());
        }
        let again = self.renderer().render(&scene, &term)?;
        self.held.pictures += 1;
        if terms(&again) != own {
            return Err("a second renderer draws other bits".into());
        }
        Ok(())
    }

    /// Holds variants to their limits in the hard cases, and the table to what they need.
    fn hard_cases(&mut self, limits: &Limits, variants: &[Config]) -> Result<(), Box<dyn Error>> {
        let (gpu, composer) = (Arc::clone(self.gpu), Arc::clone(self.composer));
        let mut lab = Lab::new(gpu, composer, self.registry.clone());
        let cases = cases::all();
        let stressed = stress(&mut lab, variants, &cases, limits, None, &())?;
        self.held.cases = stressed.results.len();
        for result in &stressed.results {
            let (case, variant, verdict) = (result.case, &result.variant, &result.verdict);
            for miss in verdict.missed.iter().filter(|miss| miss.excepted.is_none()) {
                self.broken.push(format!(
                    "{variant} in {case}: {} is {:?}, not {}",
                    miss.figure, miss.found, miss.limit
                ));
            }
            for figure in &verdict.unnecessary {
                self.broken.push(format!(
                    "{variant} in {case}: the exception for {figure} is not needed; take it out of the table"
                ));
            }
        }
        let spared = |variant: &str, figure: &str| {
            let mut own = stressed.results.iter().filter(|r| r.variant == variant);
            own.any(|result| result.verdict.spared.iter().any(|f| f == figure))
        };
        let tried = |name: &str| variants.iter().any(|variant| variant.name == name);
        for (variant, figure) in limits.throughout().filter(|(variant, _)| tried(variant)) {
            if !spared(variant, figure) {
                self.broken.push(format!(
                    "{variant}: its own limit of {figure} is not needed throughout; take it out of the table"
                ));
            }
        }
        // Nothing is passed over in silence.
        let all = stressed.results.len() + stressed.skipped.len();
        if all != cases.len() * variants.len() {
            self.broken.push(format!(
                "{all} results for {} cases and {} variants",
                cases.len(),
                variants.len()
            ));
        }
        Ok(())
    }
}

fn terms(rendered: &Rendered) -> &[f32] {
    match &rendered.picture {
        Picture::ShadowTerm(lights) => lights.first().map_or(&[], Vec::as_slice),
        _ => &[],
    }
}

fn kinds() -> [LightKind; 3] {
    let position = DVec3::new(-1.1, 2.7, 1.4);
    let direction = (DVec3::new(0.1, 0.2, 0.0) - position).normalize();
    [
        LightKind::Directional { direction },
        LightKind::Spot {
            position,
            direction,
            inner_angle: 0.5,
            outer_angle: 0.7,
            range: 12.0,
        },
        LightKind::Point {
            position,
            range: 12.0,
        },
    ]
}

/// A post and a ball on the ground, and a plate that stands free, around `origin`.
fn scene(light: &Light, origin: DVec3) -> Scene {
    let object = |name: &str, mesh: Mesh, at: DVec3, surface: &str| {
        let transform = DAffine3::from_translation(origin + at);
        Object {
            name: name.to_owned(),
            bounds: mesh.bounds(&transform),
            mesh: Arc::new(mesh),
            material: Arc::new(Material::plain(surface)),
            transform,
        }
    };
    let eye = DVec3::new(1.2, 3.1, 3.6);
    let mut light = light.clone();
    match &mut light.kind {
        LightKind::Spot { position, .. } | LightKind::Point { position, .. } => *position += origin,
        LightKind::Directional { .. } => {}
    }
    Scene {
        objects: vec![
            object(
                "ground",
                Mesh::plane(Vec2::splat(12.0), Vec2::ONE),
                DVec3::ZERO,
                "lambert",
            ),
            object(
                "post",
                Mesh::cuboid(Vec3::new(0.3, 1.4, 0.3)),
                DVec3::new(-0.5, 0.7, -0.2),
                "lambert",
            ),
            object(
                "ball",
                Mesh::sphere(0.4, 24),
                DVec3::new(0.7, 0.4, 0.3),
                "ggx",
            ),
            object(
                "plate",
                Mesh::cuboid(Vec3::new(0.8, 0.05, 0.8)),
                DVec3::new(0.2, 1.2, -0.7),
                "lambert",
            ),
        ],
        lights: vec![SceneLight {
            name: "light".to_owned(),
            light,
            cookie: None,
            shadow: None,
        }],
        camera: Camera {
            position: origin + eye,
            rotation: look_along(DVec3::new(0.0, 0.3, 0.0) - eye).unwrap_or(DQuat::IDENTITY),
            field: Field::Perspective { fov_y: 0.87 },
            near: 0.1,
            far: 50.0,
        },
        ambient: Vec3::ZERO,
        background: Vec3::ZERO,
        medium: None,
        left_out: Vec::new(),
    }
}

/// The same in two lights of the kind, from either side.
fn several(light: &Light) -> Scene {
    let mut scene = scene(light, DVec3::ZERO);
    let mut other = scene.lights[0].clone();
    other.name = "other".to_owned();
    let mirrored = DVec3::new(-1.0, 1.0, 1.0);
    match &mut other.light.kind {
        LightKind::Directional { direction } => *direction *= mirrored,
        LightKind::Spot {
            position,
            direction,
            ..
        } => {
            *position *= mirrored;
            *direction *= mirrored;
        }
        LightKind::Point { position, .. } => *position *= mirrored,
    }
    scene.lights.push(other);
    scene
}

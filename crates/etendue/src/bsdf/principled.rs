//! A layered surface with the parameters that artists' formats share (Burley, "Physically Based Shading at Disney", 2012,
//! and "Extending the Disney BRDF to a BSDF", 2015), made reciprocal and safe in energy.
//!
//! From the top:
//! - coat: GGX with Schlick's reflectance, index 1.5;
//! - sheen: see [`sheen`];
//! - base, a mixture by `metallic` and `transmission` of
//!   - metal: GGX with Schlick's reflectance (Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", 1994)
//!     from the base colour along the normal to white at grazing angles;
//!   - an opaque dielectric: the same facets with F0 = ((ior - 1) / (ior + 1))^2 times `specular`, over a diffuse body that
//!     gets what they let through, f = base / pi (1 - E(wo)) (1 - E(wi)) / (1 - mean E) with E the facets' directional
//!     albedo (Kelemen and Szirmay-Kalos, "A Microfacet Based Coupled Specular-Matte BRDF Model with Importance Sampling",
//!     2001);
//!   - a clear dielectric: [`RoughGlass`] of the same width, by Fresnel's exact equations, whose refracted light is tinted
//!     by the base colour at each crossing.
//!
//! A layer lets through 1 - E of its light, of two directions the smaller share: so it is the same there and back, and
//! never passes what the layer has scattered (Estevez and Kulla 2017).
//!
//! Facets scatter once; what would meet a second facet is lost, save in the diffuse body. Widths are alpha =
//! roughness^2; `anisotropic` makes the aspect sqrt(1 - 0.9 anisotropic) (Burley 2012), longer along x, the tangent, turned
//! about the normal by `rotation`.

use super::{
    BsdfEval, BsdfSample, RoughGlass, Scatter,
    directional_albedo::{self, Facets, Width, schlick_weight},
    fresnel, ggx,
    ggx::Ggx,
    glass::{refracted_by_surface, relative_index},
    mirrored, on_side, sheen,
};
use crate::{
    math::{PI, Vec3, sin_cos_turns},
    sampling::warp,
    spectrum::Spectrum,
};

/// Normal reflectance of the coat, index 1.5.
const COAT_F0: f32 = 0.04;
/// Least weight of a lobe of facets, so that none that has a value has no samples.
const LEAST: f32 = 0.01;

/// The parameters of [`Principled`]; `C` and `N` are what colours and numbers are, see
/// [`Scattering`](crate::material::Scattering).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipledParameters<C = Spectrum, N = f32> {
    /// Albedo of the diffuse body, normal reflectance of the metal, tint of refraction; in [0, 1].
    pub base_color: C,
    /// Share of metal, in [0, 1].
    pub metallic: N,
    /// In [0, 1].
    pub roughness: N,
    /// In [0, 1].
    pub anisotropic: N,
    /// Radians from x towards y.
    pub rotation: N,
    /// Index of refraction behind the surface (z < 0) over that before it.
    pub ior: N,
    /// Factor of the opaque dielectric's reflection, in [0, 1].
    pub specular: N,
    /// Share of clear dielectric in what is not metal, in [0, 1].
    pub transmission: N,
    /// Weight of the coat, in [0, 1].
    pub coat: N,
    /// In [0, 1].
    pub coat_roughness: N,
    /// Weight of the sheen, in [0, 1].
    pub sheen: C,
    /// In [0, 1].
    pub sheen_roughness: N,
}

/// Layers over a mixture of metal, opaque and clear dielectric, the same from both sides but for the index of refraction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled {
    base_color: Spectrum,
    sheen: Spectrum,
    /// Shares of the three bases; together 1.
    metal: f32,
    opaque: f32,
    clear: f32,
    /// Of the opaque dielectric.
    specular: f32,
    f0: f32,
    ior: f32,
    alpha: [f32; 2],
    widths: [Width; 2],
    coat: f32,
    coat_alpha: f32,
    coat_width: Width,
    sheen_alpha: f32,
    /// Sine and cosine of the tangent's turn.
    turn: (f32, f32),
}

/// Probabilities of the lobes, or weights before they are divided by their sum.
#[derive(Clone, Copy, Debug, Default)]
struct Lobes {
    coat: f32,
    sheen: f32,
    facets: f32,
    diffuse: f32,
    glass: f32,
    mirror: f32,
    refraction: f32,
}

/// What the layers scatter and let through, in one direction.
#[derive(Clone, Copy, Debug)]
struct Layers {
    coat: f32,
    sheen: f32,
    past_coat: f32,
    past_sheen: f32,
}

impl Principled {
    /// See [`PrincipledParameters`] for the ranges.
    #[inline]
    pub fn new(p: &PrincipledParameters) -> Self {
        let aspect = (1.0 - 0.9 * p.anisotropic).sqrt();
        let alpha = p.roughness * p.roughness;
        let alpha = [(alpha / aspect).min(1.0), alpha * aspect];
        // Of two widths the narrower counts as the least that facets may have.
        let widths = match Ggx::new(alpha[0], alpha[1]) {
            None => [Width::Mirror; 2],
            Some(_) => alpha.map(|a| Width::of_alpha(a.max(ggx::ALPHA_MIN))),
        };
        let coat_alpha = p.coat_roughness * p.coat_roughness;
        let dielectric = 1.0 - p.metallic;
        let root_f0 = (p.ior - 1.0) / (p.ior + 1.0);
        Self {
            base_color: p.base_color,
            sheen: p.sheen,
            metal: p.metallic,
            opaque: dielectric * (1.0 - p.transmission),
            clear: dielectric * p.transmission,
            specular: p.specular,
            f0: root_f0 * root_f0,
            ior: p.ior,
            alpha,
            widths,
            coat: p.coat,
            coat_alpha,
            coat_width: Width::of_alpha(coat_alpha),
            sheen_alpha: (p.sheen_roughness * p.sheen_roughness).max(sheen::ALPHA_MIN),
            turn: sin_cos_turns(p.rotation * (0.5 / PI)),
        }
    }

    /// Into the frame whose x is the turned tangent.
    #[inline]
    fn turned(&self, v: Vec3) -> Vec3 {
        let (sin, cos) = self.turn;
        Vec3::new(v.x * cos + v.y * sin, v.y * cos - v.x * sin, v.z)
    }

    /// Back from it.
    #[inline]
    fn turned_back(&self, v: Vec3) -> Vec3 {
        let (sin, cos) = self.turn;
        Vec3::new(v.x * cos - v.y * sin, v.x * sin + v.y * cos, v.z)
    }

    #[inline]
    fn ggx(&self) -> Option<Ggx> {
        Ggx::new(self.alpha[0], self.alpha[1])
    }

    /// The facets of the coat, if there are any.
    #[inline]
    fn coat_ggx(&self) -> Option<Ggx> {
        if self.coat > 0.0 { Ggx::new(self.coat_alpha, self.coat_alpha) } else { None }
    }

    /// The clear dielectric, if there is any and it is rough.
    #[inline]
    fn rough_glass(&self) -> Option<RoughGlass> {
        if self.clear <= 0.0 {
            return None;
        }
        RoughGlass::new(self.ior, self.alpha, Spectrum::ONE, self.base_color).ok()
    }

    /// True if there are facets that reflect as metal or opaque dielectric.
    #[inline]
    fn has_facets(&self) -> bool {
        self.metal > 0.0 || self.opaque * self.specular > 0.0
    }

    /// Reflectance of a facet, for both bases that share it.
    #[inline]
    fn reflectance(&self, cos: f32) -> Spectrum {
        let rise = schlick_weight(cos);
        let schlick = |f0: f32| f0 + (1.0 - f0) * rise;
        let dielectric = self.opaque * self.specular * schlick(self.f0);
        self.base_color.map(|f0| self.metal * schlick(f0) + dielectric)
    }

    /// What the opaque dielectric's facets keep from the body, given their directional albedo. Anisotropic facets keep at
    /// most what the wider and the narrower of the isotropic ones do.
    #[inline]
    fn kept(&self, facets: impl Fn(Width) -> Facets) -> f32 {
        let of = |width| facets(width).at(self.f0);
        let [a, b] = self.widths;
        self.specular * if a != b { of(a).max(of(b)) } else { of(a) }
    }

    #[inline]
    fn kept_at(&self, cos: f32) -> f32 {
        self.kept(|width| width.facets(cos)).min(1.0)
    }

    #[inline]
    fn layers(&self, cos: f32) -> Layers {
        let coat = if self.coat > 0.0 { self.coat * self.coat_width.facets(cos).at(COAT_F0) } else { 0.0 };
        let most = self.sheen.max_component();
        let sheen = if most > 0.0 { directional_albedo::sheen(cos, self.sheen_alpha) } else { 0.0 };
        let let_through = |share: f32| (1.0 - share).max(0.0);
        Layers { coat, sheen, past_coat: let_through(coat), past_sheen: let_through(most * sheen) }
    }

    /// Weights of the lobes as seen from `wo`, turned; `eta` the index beyond the surface over that on this side.
    fn lobes(&self, wo: Vec3, eta: f32) -> Lobes {
        let cos = wo.z.abs();
        let layers = self.layers(cos);
        let past = layers.past_coat * layers.past_sheen;
        let base = self.base_color.mean();
        let facets = self.widths[0].facets(cos);
        let metal = self.metal * facets.at(base).max(LEAST);
        let dielectric = self.opaque * self.specular * facets.at(self.f0).max(LEAST);
        let mut lobes = Lobes {
            coat: if self.coat_ggx().is_some() { layers.coat.max(LEAST * self.coat) } else { 0.0 },
            sheen: layers.past_coat * self.sheen.mean() * layers.sheen.clamp(LEAST, 1.0),
            facets: if self.ggx().is_some() { past * (metal + dielectric) } else { 0.0 },
            diffuse: past * self.opaque * base * (1.0 - self.kept_at(cos)),
            ..Lobes::default()
        };
        let (reflection, refraction) = self.discrete(wo, eta, layers);
        lobes.mirror = reflection.mean();
        lobes.refraction = refraction.mean();
        if self.rough_glass().is_some() {
            let reflected = fresnel::dielectric(cos, eta).reflectance;
            lobes.glass = past * self.clear * (reflected + (1.0 - reflected) * base).max(LEAST);
        }
        lobes.normalised()
    }

    /// Shares of the mirror direction and the refracted one.
    #[inline]
    fn discrete(&self, wo: Vec3, eta: f32, layers: Layers) -> (Spectrum, Spectrum) {
        let cos = wo.z.abs();
        let past = layers.past_coat * layers.past_sheen;
        let mut reflection = Spectrum::BLACK;
        let mut refraction = Spectrum::BLACK;
        if self.coat > 0.0 && self.coat_ggx().is_none() {
            reflection += Spectrum::splat(layers.coat);
        }
        if self.ggx().is_none() {
            reflection += self.reflectance(cos) * past;
        }
        if self.clear > 0.0 && self.rough_glass().is_none() {
            let interface = fresnel::dielectric(cos, eta);
            reflection += Spectrum::splat(past * self.clear * interface.reflectance);
            let beyond = self.layers(interface.cos_t);
            let both = layers.past_coat.min(beyond.past_coat) * layers.past_sheen.min(beyond.past_sheen);
            refraction = self.base_color * (both * self.clear * (1.0 - interface.reflectance));
        }
        (reflection, refraction)
    }

    /// The continuous lobes; directions turned, `lobes` those of `wo`.
    fn eval_lobes(&self, lobes: &Lobes, wo: Vec3, wi: Vec3) -> BsdfEval {
        if wo.z == 0.0 || wi.z == 0.0 {
            return BsdfEval::ZERO;
        }
        let (seen, lit) = (self.layers(wo.z.abs()), self.layers(wi.z.abs()));
        let past_coat = seen.past_coat.min(lit.past_coat);
        let past = past_coat * seen.past_sheen.min(lit.past_sheen);
        let mut total = BsdfEval::ZERO;
        if lobes.glass > 0.0
            && let Some(glass) = self.rough_glass()
        {
            let BsdfEval { value, pdf } = Scatter::eval(&glass, wo, wi);
            total.add(value * (past * self.clear), lobes.glass * pdf);
        }
        let side = 1.0f32.copysign(wo.z);
        let (wo, wi) = (on_side(wo, side), on_side(wi, side));
        if wi.z < 0.0 {
            return total;
        }
        if lobes.diffuse > 0.0 {
            let spread = (1.0 - self.kept_at(wo.z)) * (1.0 - self.kept_at(wi.z)) / (1.0 - self.kept(Width::average));
            let cosine = wi.z * (1.0 / PI);
            total.add(self.base_color * (past * self.opaque * spread * cosine), lobes.diffuse * cosine);
        }
        if lobes.sheen > 0.0 {
            let lobe = sheen::lobe(wo, wi, self.sheen_alpha) * sheen::ceiling(seen.sheen, lit.sheen);
            total.add(self.sheen * (past_coat * lobe), lobes.sheen * warp::UNIFORM_HEMISPHERE_PDF);
        }
        let (m, true) = ggx::half_vector(wo, wi) else { return total };
        let cos_m = wo.dot(m);
        if lobes.facets > 0.0
            && let Some(ggx) = self.ggx()
        {
            let (value, pdf) = ggx.bounded_reflection(wo, wi, m);
            total.add(self.reflectance(cos_m) * (past * value), lobes.facets * pdf);
        }
        if lobes.coat > 0.0
            && let Some(ggx) = self.coat_ggx()
        {
            let (value, pdf) = ggx.bounded_reflection(wo, wi, m);
            let reflectance = COAT_F0 + (1.0 - COAT_F0) * schlick_weight(cos_m);
            total.add(Spectrum::splat(self.coat * reflectance * value), lobes.coat * pdf);
        }
        total
    }

    /// A direction of the continuous lobe that `rest` falls into, or what is left of `rest` above them all; `wo` turned.
    fn sample_lobe(&self, lobes: &Lobes, wo: Vec3, mut rest: f32, u: [f32; 2]) -> Result<Option<Vec3>, f32> {
        let side = 1.0f32.copysign(wo.z);
        let up = on_side(wo, side);
        let mut is_chosen = |probability: f32| {
            let before = rest;
            rest -= probability;
            (rest < 0.0).then(|| before / probability)
        };
        let facets = |ggx: Option<Ggx>| ggx.map(|ggx| ggx::reflected(up, ggx.sample_bounded(up, u)));
        let wi = if is_chosen(lobes.coat).is_some() {
            facets(self.coat_ggx())
        } else if is_chosen(lobes.sheen).is_some() {
            Some(warp::uniform_hemisphere(u))
        } else if is_chosen(lobes.facets).is_some() {
            facets(self.ggx())
        } else if is_chosen(lobes.diffuse).is_some() {
            Some(warp::cosine_hemisphere(u))
        } else if let Some(within) = is_chosen(lobes.glass) {
            let glass =
                self.rough_glass().and_then(|glass| Scatter::sample(&glass, wo, within.min(1.0 - f32::EPSILON), u));
            return Ok(glass.map(|sample| sample.wi));
        } else {
            return Err(rest);
        };
        Ok(wi.filter(|wi| wi.z > 0.0).map(|wi| on_side(wi, side)))
    }

    /// One of the lobes without extent; `wo` turned.
    fn sample_discrete(&self, lobes: &Lobes, wo: Vec3, eta: f32, rest: f32) -> Option<BsdfSample> {
        let (reflection, refraction) = self.discrete(wo, eta, self.layers(wo.z.abs()));
        let sample = if rest >= lobes.mirror {
            let cos_t = fresnel::dielectric(wo.z.abs(), eta).cos_t;
            BsdfSample::refracted(refracted_by_surface(wo, cos_t, eta), refraction, lobes.refraction, eta)
        } else {
            BsdfSample::reflected(mirrored(wo), reflection, lobes.mirror)
        }?;
        Some(BsdfSample { wi: self.turned_back(sample.wi).normalize(), ..sample })
    }
}

impl Lobes {
    fn normalised(self) -> Self {
        let sum = self.coat + self.sheen + self.facets + self.diffuse + self.glass + self.mirror + self.refraction;
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        Self {
            coat: self.coat * scale,
            sheen: self.sheen * scale,
            facets: self.facets * scale,
            diffuse: self.diffuse * scale,
            glass: self.glass * scale,
            mirror: self.mirror * scale,
            refraction: self.refraction * scale,
        }
    }
}

impl BsdfEval {
    #[inline]
    fn add(&mut self, value: Spectrum, pdf: f32) {
        self.value += value;
        self.pdf += pdf;
    }
}

impl Scatter for Principled {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let (wo, wi) = (self.turned(wo), self.turned(wi));
        self.eval_lobes(&self.lobes(wo, relative_index(self.ior, wo)), wo, wi)
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let wo = self.turned(wo);
        let eta = relative_index(self.ior, wo);
        let lobes = self.lobes(wo, eta);
        let wi = match self.sample_lobe(&lobes, wo, u_lobe, u) {
            Ok(wi) => wi?,
            Err(rest) => return self.sample_discrete(&lobes, wo, eta, rest),
        };
        let transmitted = (wi.z > 0.0) != (wo.z > 0.0);
        let wi = self.turned_back(wi).normalize();
        // Of the direction as it leaves here, so that rounding cannot come between this density and that of `eval`.
        BsdfSample::continuous(wi, self.eval_lobes(&lobes, wo, self.turned(wi)), transmitted, eta)
    }

    #[inline]
    fn is_delta(&self) -> bool {
        let rough = self.ggx().is_some();
        let diffuse = self.opaque > 0.0 && !self.base_color.is_black();
        let facets = rough && self.has_facets();
        !(diffuse || facets || !self.sheen.is_black() || self.coat_ggx().is_some() || self.rough_glass().is_some())
    }

    #[inline]
    fn transmits(&self) -> bool {
        self.rough_glass().is_some() && !self.base_color.is_black()
    }

    #[inline]
    fn albedo(&self) -> Spectrum {
        let layers = self.layers(1.0);
        let past = layers.past_coat * layers.past_sheen;
        let [wide, narrow] = self.widths.map(|width| width.facets(1.0));
        let facets = Facets { scale: 0.5 * (wide.scale + narrow.scale), bias: 0.5 * (wide.bias + narrow.bias) };
        let kept = self.specular * facets.at(self.f0);
        let reflected = fresnel::dielectric(1.0, self.ior).reflectance;
        let base = self.base_color.map(|base| {
            let opaque = kept + (1.0 - kept) * base;
            let clear = reflected + (1.0 - reflected) * base;
            past * (self.metal * facets.at(base) + self.opaque * opaque + self.clear * clear)
        });
        (base + self.sheen * (layers.past_coat * layers.sheen.min(1.0)) + Spectrum::splat(layers.coat))
            .map(|share| share.min(1.0))
    }

    #[inline]
    fn is_anisotropic(&self) -> bool {
        self.ggx().is_some_and(|ggx| ggx.is_anisotropic())
    }
}

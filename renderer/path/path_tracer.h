#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <new>
#include <optional>
#include <span>
#include <type_traits>

#include "renderer/math/frame.h"
#include "renderer/path/light_end.h"
#include "renderer/sampler/path_sampler.h"
#include "renderer/scene/view_bounds.h"

namespace pathfit::renderer {

/// Everything a path needs, prepared once per view.
struct PathContext {
  const World* world = nullptr;
  LightSet lights;
  PixelBounds bounds;  ///< rays of pixels outside meet nothing
  int max_bounces = 1;
  int rr_depth = 5;
  bool antithetic = false;  ///< paths come in pairs, the second mirrored at its first rough vertex

  [[nodiscard]] bool HasExtendedLights() const {
    return lights.environment.has_value() || !lights.areas.empty();
  }
};

/// Light that reaches a vertex directly, as light sampling (or, for the environment, a BSDF sample
/// that escapes) meets it. Adds bsdf(w, wo) * factor * radiance to what leaves the vertex; at a
/// delta vertex the delta weight stands for bsdf.
struct DirectContribution {
  SeenLight light;
  double factor = 0.0;  ///< cosine * MIS weight / light.pdf
};

/// How a path goes on: radiance beyond is weighted with bsdf(wi, wo) * factor, or with the delta
/// weight * factor.
struct Continuation {
  Vec3 wi;
  double factor = 0.0;
  bool delta = false;
  bool transmit = false;  ///< delta only
};

/// Listens to one path; vertices come in order from the sensor.
template <class L>
concept PathListener = requires(L& listener,
                                const L& constant,
                                const SurfacePoint& p,
                                const DirectContribution& direct,
                                const Continuation& on,
                                const Rgb& radiance,
                                double mis_weight,
                                int bounces) {
  /// Whether contributions of value zero are wanted, too: their derivative may not vanish.
  { L::kDifferentiates } -> std::convertible_to<bool>;
  listener.OnVertex(p);
  /// The last vertex shines towards its viewer.
  listener.OnEmission(mis_weight);
  listener.OnDirect(direct);
  listener.OnContinue(on);
  /// Radiance was added that was reflected so many times.
  listener.OnRadiance(bounces, radiance);
  /// Whether light that arrives at the path's last vertex matters.
  { constant.WantsLight() } -> std::same_as<bool>;
};

/// Hears nothing, at no cost: what images need.
struct NullListener {
  static constexpr bool kDifferentiates = false;
  void OnVertex(const SurfacePoint&) {}
  void OnEmission(double) {}
  void OnDirect(const DirectContribution&) {}
  void OnContinue(const Continuation&) {}
  void OnRadiance(int, const Rgb&) {}
  [[nodiscard]] static bool WantsLight() { return true; }
};

/// Russian roulette survival probability from the path's throughput.
inline double SurvivalProbability(const Rgb& throughput) {
  return std::min(0.95, std::max(0.05, MaxChannel(throughput)));
}

/// The family of directions that one vertex draws from.
struct DirectionFamily {
  DirectionDraw draw = DirectionDraw::kBsdf;
  bool paired = false;    ///< BSDF samples of two paths, the second mirrored
  bool mirrored = false;  ///< this is the second
};

/// Density of the directions of a family, as MIS sees it.
inline double ScatterPdf(const SurfacePoint& p,
                         const BsdfCosines& cosines,
                         const DirectionFamily& family) {
  const Bsdf& bsdf = p.material->bsdf;
  const double pdf =
      family.paired ? MirroredPairPdf(bsdf, p.inputs, cosines) : BsdfPdf(bsdf, p.inputs, cosines);
  if (family.draw == DirectionDraw::kBsdf) {
    return pdf;
  }
  const double spread = IsTransmissive(bsdf) ? 2.0 : 1.0;
  return 0.5 * (pdf + UniformHemispherePdf() / spread);
}

/// The next direction at a vertex; its density is the family's, and 0 if it is absorbed.
template <PathSampler Sampler>
[[gnu::always_inline]] inline BsdfSample SampleDirection(const SurfacePoint& p,
                                                         int bounce,
                                                         const DirectionFamily& family,
                                                         Sampler& sampler) {
  const Bsdf& bsdf = p.material->bsdf;
  const double u0 = sampler.NextDirection(bounce, 0);
  const double u1 = sampler.NextDirection(bounce, 1);
  const double u2 = sampler.Next();
  BsdfSample sample;
  if (family.draw == DirectionDraw::kMixedUniform) {
    Vec3 local =
        IsTransmissive(bsdf) ? SampleUniformSphere(u0, u1) : SampleUniformHemisphere(u0, u1);
    if (family.mirrored) {
      local = {-local.x, -local.y, local.z};
    }
    sample.wi = Frame::FromNormal(p.n).ToWorld(local);
  } else {
    const auto own = SampleBsdf(bsdf, p.inputs, p.n, p.wo, u0, u1, u2, family.mirrored);
    if (!own) {
      return sample;
    }
    sample.wi.x = own->wi.x;
    sample.wi.y = own->wi.y;
    sample.wi.z = own->wi.z;
    sample.pdf = own->pdf;
    sample.delta = own->delta;
  }
  if ((family.paired || family.draw != DirectionDraw::kBsdf) && !sample.delta) {
    sample.pdf = ScatterPdf(p, p.Cosines(sample.wi), family);
  }
  return sample;
}

/// Share of a sample drawn with density `own` that `other` could have drawn, too. The square,
/// rather than the density itself, leaves narrow lobes to the samples that follow them: their
/// derivatives are large, and only those samples cancel in antithetic pairs. [Veach1995]
inline double PowerHeuristic(double own, double other) {
  return own * own / (own * own + other * other);
}

/// The same over `own`.
inline double PowerHeuristicOverPdf(double own, double other) {
  return own / (own * own + other * other);
}

/// How far a path goes and what it counts.
struct PathRange {
  int max_bounces = 1;        ///< light that was reflected up to so many times
  bool with_emission = true;  ///< the first vertex' own emission
  bool mirrored = false;      ///< the second path of an antithetic pair
  /// Of several paths that are alike up to this bounce, one adds the light that they see directly
  /// at vertices up to there, times `light_share`; for the others that is 0. Listeners that
  /// differentiate only.
  int alike = 0;
  double light_share = 1.0;
};

/// Draws the numbers of light sampling.
template <PathSampler Sampler>
void SkipLights(const PathContext& context, Sampler& sampler) {
  const int extended =
      (context.lights.environment ? 1 : 0) + (context.lights.areas.empty() ? 0 : 1);
  for (int i = 0; i < 2 * extended; ++i) {
    sampler.NextLight();
  }
}

/// What a vertex finds of the environment; of a map in steps, too: see EnvironmentSampler.
struct EnvironmentSight {
  const LightSet::Environment& environment;

  template <class Accepts, PathSampler Sampler>
  [[gnu::always_inline]] std::optional<SeenLight> operator()(const SurfacePoint& p,
                                                             const Accepts& accepts,
                                                             Sampler& sampler) const {
    const double u0 = sampler.NextLight();
    const double u1 = sampler.NextLight();
    const Vec3 normal = environment.light_from_world * p.n;
    return SeeEnvironment(environment, environment.sampler->Sample(normal, u0, u1), accepts);
  }

  [[nodiscard]] bool HasSteps() const { return environment.sampler->IsMap(); }
  template <PathSampler Sampler>
  [[nodiscard]] EnvironmentSampler::Draft Draw(Sampler& sampler) const {
    const double u0 = sampler.NextLight();
    const double u1 = sampler.NextLight();
    return environment.sampler->ChooseRow(u0, u1);
  }
  template <class Accepts>
  [[gnu::always_inline]] std::optional<SeenLight> Finish(const EnvironmentSampler::Draft& draft,
                                                         const Accepts& accepts) const {
    return SeeEnvironment(environment, environment.sampler->Finish(draft), accepts);
  }
};

/// One path on its way from the sensor, a vertex at a time, in stages between which its rays are
/// traced.
template <PathSampler Sampler, PathListener Listener>
class TracedPath {
 public:
  /// From the surface point that make_first() returns, which is made in its place. All must outlive
  /// the path.
  template <class MakeFirst>
  TracedPath(const PathContext& context,
             const MakeFirst& make_first,
             Sampler& sampler,
             Listener& listener,
             const PathRange& range)
      : context_(context),
        sampler_(sampler),
        listener_(listener),
        range_(range),
        p_(make_first()),
        paired_(context.antithetic),
        emission_weight_(range.with_emission ? 1.0 : 0.0) {}

  /// Radiance so far.
  [[nodiscard]] const Rgb& radiance() const { return radiance_; }

  /// Adds what the vertex emits. False if the path ends here.
  bool Emit() {
    listener_.OnVertex(p_);
    if (const auto* light = context_.lights.AreaLightOf(p_.id.mesh);
        light != nullptr && emission_weight_ > 0.0) {
      listener_.OnEmission(emission_weight_);
      Add(bounce_ - 1,
          throughput_ * AreaRadiance(*light, p_.id.triangle, p_.b1, p_.b2, p_.side) *
              emission_weight_);
    }
    if (bounce_ > range_.max_bounces || !p_.Reflects()) {
      return false;
    }
    delta_ = IsDelta(p_.material->bsdf);
    family_ = {sampler_.DrawAt(bounce_), paired_, paired_ && range_.mirrored};
    const bool wants_light = listener_.WantsLight();
    if (!wants_light && IsLast()) {
      return false;
    }
    lit_ = !delta_ && wants_light;
    if constexpr (Listener::kDifferentiates) {
      lit_ = lit_ && (bounce_ > range_.alike || range_.light_share > 0.0);
    }
    direct_ = {};
    if (!delta_ && !lit_) {
      SkipLights(context_, sampler_);
    }
    return true;
  }

  /// Light sampling, for one light after another: what see(point, accepts, sampler) finds. If it
  /// counts, calls found(light, factor, value, shadow ray), which calls AddLight if it is visible.
  template <class See, class Found>
  [[gnu::always_inline]] void Look(const See& see, Found found) {
    if (!lit_) {
      return;
    }
    const auto light = see(
        p_, [this](const Vec3& w) { return p_.Accepts(w); }, sampler_);
    if (!light) {
      return;
    }
    const BsdfCosines cosines = p_.Cosines(light->w);
    const double cosine = std::abs(cosines.cos_i);
    const double factor =
        light->has_extent
            ? cosine * PowerHeuristicOverPdf(light->pdf, ScatterPdf(p_, cosines, family_))
            : cosine / light->pdf;
    const Rgb reflected = EvalBsdf(p_.material->bsdf, p_.inputs, cosines) * light->radiance;
    if (!Listener::kDifferentiates && IsBlack(reflected)) {
      return;
    }
    if (light->is_visible) {
      AddLight(*light, factor, reflected);
    } else {
      found(*light, factor, reflected, ShadowRay(context_.world->caster(), p_, *light));
    }
  }
  /// The numbers that Look would draw first; whether it would.
  bool Draw(const EnvironmentSight& sight, EnvironmentSampler::Draft& draft) {
    if (lit_) {
      draft = sight.Draw(sampler_);
    }
    return lit_;
  }
  template <class Light>
  void AddLight(const Light& light, double factor, const Rgb& reflected) {
    if constexpr (Listener::kDifferentiates) {
      listener_.OnDirect({light, bounce_ > range_.alike ? factor : factor * range_.light_share});
    }
    direct_ += reflected * factor;
  }

  /// Draws the next direction. False if the path ends here.
  bool Turn() {
    if (lit_) {
      Add(bounce_, throughput_ * direct_);
    }
    if (!delta_ && IsLast() && !context_.HasExtendedLights()) {
      return false;
    }
    const BsdfSample sample = SampleDirection(p_, bounce_, family_, sampler_);
    // Mirroring a second vertex, too, would pair only two of the four combinations of densities.
    paired_ = paired_ && delta_;
    if (!(sample.pdf > 0.0) || !p_.Accepts(sample.wi)) {
      return false;
    }
    ray_.origin = RayStart(p_, sample.wi);
    ray_.direction = sample.wi;
    may_only_escape_ = IsLast() && !delta_ && !context_.lights.MayMeetArea(ray_, p_.offset);
    if (may_only_escape_ && !context_.lights.environment) {
      return false;
    }
    const BsdfCosines cosines = p_.Cosines(sample.wi);
    pdf_ = sample.pdf;
    above_ = cosines.cos_i > 0.0;
    // Member by member, here and below: what is written in parts must not be read as a whole soon,
    // which a processor has to wait for.
    on_.wi = sample.wi;
    on_.factor = delta_ ? 1.0 / pdf_ : std::abs(cosines.cos_i) / pdf_;
    on_.delta = delta_;
    on_.transmit = cosines.cos_i < 0.0;
    bsdf_ = delta_ ? EvalDelta(p_.material->bsdf, p_.inputs, cosines.cos_o, on_.transmit).value
                   : EvalBsdf(p_.material->bsdf, p_.inputs, cosines);
    return true;
  }

  /// The next ray; after Turn.
  [[nodiscard]] const Ray& ray() const { return ray_; }
  /// Whether the path ends with the next ray, whatever that meets.
  [[nodiscard]] bool MayOnlyEscape() const { return may_only_escape_; }

  /// Adds the environment where the ray escaped; else goes to the next vertex, unless there is no
  /// hit. False if the path ends.
  bool Connect(const std::optional<Hit>& hit, bool escaped) {
    if (escaped && context_.lights.environment) {
      Escape(*context_.lights.environment);
    }
    const bool goes_on = hit && (bounce_ < range_.max_bounces || Shines(hit->id));
    if (!goes_on) {
      return false;
    }
    Continuation next = on_;
    throughput_ *= bsdf_ * on_.factor;
    if (bounce_ >= context_.rr_depth) {
      const double survival = SurvivalProbability(throughput_);
      if (sampler_.Next() >= survival) {
        return false;
      }
      next.factor /= survival;
      throughput_ *= 1.0 / survival;
    }
    listener_.OnContinue(next);
    const Vec3 from = p_.x;
    // Made in its place: a copy would wait for the parts it has just been written in.
    ::new (&p_) SurfacePoint(MakeSurfacePoint(*context_.world, *hit, ray_));
    emission_weight_ = 1.0;
    if (!on_.delta && Shines(p_.id)) {
      const double cos_light = std::abs(Dot(p_.ng, ray_.direction));
      const double squared = hit->distance * hit->distance;
      const double other = context_.lights.area_sampler->PdfTowards(
                               from, p_.id, ray_.direction, cos_light / squared) *
                           squared;
      emission_weight_ = PowerHeuristic(pdf_ * cos_light, other);
    }
    ++bounce_;
    return true;
  }

 private:
  [[nodiscard]] bool IsLast() const { return bounce_ == range_.max_bounces; }
  void Add(int bounces, const Rgb& value) {
    radiance_ += value;
    listener_.OnRadiance(bounces, value);
  }
  [[nodiscard]] bool Shines(TriangleId id) const {
    return context_.lights.AreaLightOf(id.mesh) != nullptr;
  }
  void Escape(const LightSet::Environment& environment) {
    const Vec2 uv = UvTowards(environment, on_.wi);
    DirectContribution direct;
    direct.light.end = &environment;
    direct.light.w = on_.wi;
    direct.light.radiance = EnvironmentRadianceAt(*environment.light, uv);
    direct.light.has_extent = true;
    direct.light.pdf = on_.delta ? 0.0 : environment.sampler->Pdf(uv, above_);
    direct.factor = on_.factor * PowerHeuristic(pdf_, direct.light.pdf);
    if (on_.delta) {
      listener_.OnContinue(on_);
    }
    listener_.OnDirect(direct);
    Add(bounce_, throughput_ * bsdf_ * direct.light.radiance * direct.factor);
  }

  const PathContext& context_;
  Sampler& sampler_;
  Listener& listener_;
  const PathRange range_;
  SurfacePoint p_;
  int bounce_ = 1;  // of the light that reaches p_
  Rgb throughput_{1.0, 1.0, 1.0};
  Rgb radiance_;
  bool paired_;
  double emission_weight_;  // MIS weight of what p_ emits
  // The vertex, from Emit on.
  bool delta_ = false;
  bool lit_ = false;  // lights are sampled
  DirectionFamily family_;
  Rgb direct_;  // from lights
  // The next ray, between Turn and Connect.
  Ray ray_;
  Continuation on_;
  Rgb bsdf_;
  double pdf_ = 0.0;
  bool above_ = true;  // on the side of the normal
  bool may_only_escape_ = false;
};

/// Calls add(see) for every light that a vertex samples: one sample of the environment and one of
/// the area lights (MIS with the BSDF, power heuristic), all point and directional lights.
/// see(point, accepts, sampler) is for TracedPath::Look.
template <PathSampler Sampler, class Add>
void ForEachLight(const PathContext& context, Add add) {
  const LightSet& lights = context.lights;
  if (lights.environment) {
    add(EnvironmentSight{*lights.environment});
  }
  if (!lights.areas.empty()) {
    add([&](const SurfacePoint& p, const auto& accepts, Sampler& sampler) {
      const double u0 = sampler.NextLight();
      const double u1 = sampler.NextLight();
      return SeeArea(
          *context.world, lights, lights.area_sampler->SampleTowards(p.x, u0, u1), p, accepts);
    });
  }
  for (const auto& light : lights.points) {
    add([&](const SurfacePoint& p, const auto& accepts, Sampler& /*sampler*/) {
      return SeePointLight(light, p.x, accepts);
    });
  }
  for (const auto& light : lights.directionals) {
    add([&](const SurfacePoint& /*p*/, const auto& accepts, Sampler& /*sampler*/) {
      return SeeDirectional(light, accepts);
    });
  }
}

/// Up to N paths that take their stages side by side: each as if it were alone, bit for bit, but
/// their rays are traced together.
template <std::size_t N, PathSampler Sampler, PathListener Listener>
class PathBatch {
 public:
  /// Must outlive the batch.
  explicit PathBatch(const PathContext& context) : context_(context) {}

  /// Path number i < N; in order of their numbers. All must outlive Trace.
  void Start(std::size_t i,
             const Hit& first,
             const Ray& ray,
             Sampler& sampler,
             Listener& listener,
             const PathRange& range) {
    const auto make_first = [&] { return MakeSurfacePoint(*context_.world, first, ray); };
    paths_[i].emplace(context_, make_first, sampler, listener, range);
    active_[count_++] = i;
  }
  void Start(std::size_t i,
             const SurfacePoint& first,
             Sampler& sampler,
             Listener& listener,
             const PathRange& range) {
    paths_[i].emplace(
        context_, [&first] { return first; }, sampler, listener, range);
    active_[count_++] = i;
  }
  /// All paths to their ends, once.
  void Trace() {
    while (count_ > 0) {
      Keep([](Path& path) { return path.Emit(); });
      ForEachLight<Sampler>(context_, [&](const auto& see) { AddLight(see); });
      Keep([](Path& path) { return path.Turn(); });
      Extend();
    }
  }
  /// Of path number i, which was started.
  [[nodiscard]] const Rgb& radiance(std::size_t i) const { return paths_[i]->radiance(); }

 private:
  using Path = TracedPath<Sampler, Listener>;

  /// Those of the active paths for which stage(path) is true stay active.
  template <class Stage>
  void Keep(Stage stage) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if (stage(*paths_[active_[i]])) {
        active_[kept++] = active_[i];
      }
    }
    count_ = kept;
  }

  /// Choices of the active paths on a map, which is larger than fast memory, side by side.
  void Draft(const EnvironmentSight& sight) {
    const EnvironmentSampler& sampler = *sight.environment.sampler;
    std::array<EnvironmentSampler::Draft*, N> drawn;
    std::size_t count = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      drawn[count] = &drafts_[i];
      count += paths_[active_[i]]->Draw(sight, drafts_[i]) ? 1 : 0;
    }
    for (std::size_t i = 0; i < count; ++i) {
      sampler.LookForColumn(*drawn[i]);
    }
    for (std::size_t i = 0; i < count; ++i) {
      sampler.ChooseColumn(*drawn[i]);
    }
  }

  template <class See>
  void AddLight(const See& see) {
    constexpr bool kMayHaveSteps = std::is_same_v<See, EnvironmentSight>;
    bool has_steps = false;
    if constexpr (kMayHaveSteps) {
      has_steps = see.HasSteps();
      if (has_steps) {
        Draft(see);
      }
    }
    std::size_t count = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      Path& path = *paths_[active_[i]];
      const auto look = [&](const SurfacePoint& p, const auto& accepts, Sampler& sampler) {
        if constexpr (kMayHaveSteps) {
          if (has_steps) {
            return see.Finish(drafts_[i], accepts);
          }
        }
        return see(p, accepts, sampler);
      };
      path.Look(look,
                [&](const auto& light, double factor, const Rgb& value, const Segment& shadow) {
                  sightings_[count] = Sighting(path, light, factor, value);
                  segments_[count++] = shadow;
                });
    }
    context_.world->caster().Occluded({segments_.data(), count}, {occluded_.data(), count});
    for (std::size_t i = 0; i < count; ++i) {
      if (!occluded_[i]) {
        sightings_[i].Add();
      }
    }
  }

  /// To what the next rays meet.
  void Extend() {
    std::size_t num_rays = 0;
    std::size_t num_escapes = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const Path& path = *paths_[active_[i]];
      if (path.MayOnlyEscape()) {
        segments_[num_escapes++] = {path.ray(), std::numeric_limits<double>::infinity()};
      } else {
        rays_[num_rays++] = path.ray();
      }
    }
    const RayCaster& caster = context_.world->caster();
    caster.Intersect({rays_.data(), num_rays}, false, {hits_.data(), num_rays});
    caster.Occluded({segments_.data(), num_escapes}, {occluded_.data(), num_escapes});
    const std::optional<Hit>* hit = hits_.data();
    const bool* occluded = occluded_.data();
    Keep([&](Path& path) {
      if (path.MayOnlyEscape()) {
        return path.Connect({}, !*occluded++);
      }
      const std::optional<Hit>& met = *hit++;
      return path.Connect(met, !met);
    });
  }

  /// Light whose shadow ray is on its way; which light it is only listeners to derivatives need.
  class Sighting {
   public:
    Sighting() = default;
    Sighting(Path& path, const SeenLight& light, double factor, const Rgb& value)
        : path_(&path), factor_(factor), value_(value) {
      if constexpr (Listener::kDifferentiates) {
        light_ = light;
      }
    }
    void Add() const { path_->AddLight(light_, factor_, value_); }

   private:
    struct Nothing {};
    Path* path_ = nullptr;
    double factor_ = 0.0;
    Rgb value_;
    [[no_unique_address]] std::conditional_t<Listener::kDifferentiates, SeenLight, Nothing> light_;
  };

  const PathContext& context_;
  std::array<std::optional<Path>, N> paths_;
  std::array<std::size_t, N> active_;  // the first count_: numbers of the paths that go on
  std::size_t count_ = 0;
  // Scratch space of a stage.
  std::array<EnvironmentSampler::Draft, N> drafts_;  // by place in active_
  std::array<Sighting, N> sightings_;
  std::array<Ray, N> rays_;
  std::array<std::optional<Hit>, N> hits_;
  std::array<Segment, N> segments_;
  std::array<bool, N> occluded_{};
};

/// Radiance leaving a surface point towards where it is seen from: unidirectional path tracing with
/// light sampling and MIS at every vertex.
template <PathSampler Sampler, PathListener Listener>
Rgb TraceRadiance(const PathContext& context,
                  const SurfacePoint& p,
                  Sampler& sampler,
                  Listener& listener,
                  const PathRange& range) {
  // Not a PathBatch of one: of a derivative, that takes half a percent more instructions.
  const RayCaster& caster = context.world->caster();
  TracedPath<Sampler, Listener> path(
      context, [&p] { return p; }, sampler, listener, range);
  const auto extend = [&] {
    if (path.MayOnlyEscape()) {
      return path.Connect({},
                          !caster.Occluded(path.ray(), std::numeric_limits<double>::infinity()));
    }
    const auto hit = caster.Intersect(path.ray());
    return path.Connect(hit, !hit);
  };
  do {
    if (!path.Emit()) {
      break;
    }
    ForEachLight<Sampler>(context, [&](const auto& see) {
      path.Look(see,
                [&](const auto& light, double factor, const Rgb& value, const Segment& shadow) {
                  if (!caster.Occluded(shadow.ray, shadow.length)) {
                    path.AddLight(light, factor, value);
                  }
                });
    });
  } while (path.Turn() && extend());
  return path.radiance();
}

}  // namespace pathfit::renderer

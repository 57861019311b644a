#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "renderer/core/parallel.h"

namespace pathfit::renderer {

struct RenderStats;

/// The parts of the derivative, each with an estimator and samples of its own.
enum class DerivativeTerm : std::uint8_t {
  kInterior,
  kPrimary,   ///< edges seen by the sensor
  kDirect,    ///< edges between a light and a surface
  kIndirect,  ///< edges between two surfaces
  kPixel,     ///< pixel borders: material form under a box filter only
};
/// All of them in their order, with the words that configs and tables call them by.
inline constexpr std::array<std::pair<const char*, DerivativeTerm>, 5> kDerivativeTerms = {
    {{"interior", DerivativeTerm::kInterior},
     {"primary", DerivativeTerm::kPrimary},
     {"direct", DerivativeTerm::kDirect},
     {"indirect", DerivativeTerm::kIndirect},
     {"pixel", DerivativeTerm::kPixel}}};
inline constexpr std::size_t kNumDerivativeTerms = kDerivativeTerms.size();
constexpr const char* NameOf(DerivativeTerm term) {
  return kDerivativeTerms[static_cast<std::size_t>(term)].first;
}

/// A set of terms.
class DerivativeTerms {
 public:
  constexpr DerivativeTerms() = default;  ///< all
  constexpr DerivativeTerms(std::initializer_list<DerivativeTerm> terms) : bits_(0) {
    for (const DerivativeTerm term : terms) Set(term, true);
  }
  [[nodiscard]] constexpr bool Has(DerivativeTerm term) const { return (bits_ & Bit(term)) != 0; }
  constexpr void Set(DerivativeTerm term, bool on) {
    bits_ = on ? bits_ | Bit(term) : bits_ & ~Bit(term);
  }
  bool operator==(const DerivativeTerms&) const = default;

 private:
  static constexpr unsigned Bit(DerivativeTerm term) { return 1U << static_cast<unsigned>(term); }
  unsigned bits_ = (1U << kNumDerivativeTerms) - 1U;
};

/// What is kept fixed when the camera vertex is differentiated (path_space 1.5). Both give the same
/// derivative in expectation and split it differently.
enum class DerivativeForm {
  kImage,     ///< its place in the image: less noise, the default
  kMaterial,  ///< its place on the surface
};

/// How boundary samples are drawn.
enum class GuideKind {
  kNone,      ///< by edge length and uniform directions
  kGrid,      ///< a regular grid over the primary samples
  kAdaptive,  ///< cells split where the samples are large
};

/// Samples of one image and its derivative. Names follow the field: spp interior samples per pixel;
/// the boundary budgets are per pixel of the image, too.
struct SampleBudget {
  int spp = 16;
  double sppe = 4.0;          ///< primary-edge samples per pixel of edge length
  double spp_direct = 1.0;    ///< direct-boundary samples per pixel
  double spp_indirect = 1.0;  ///< indirect-boundary samples per pixel
  double spp_pixel = 4.0;     ///< pixel-border samples per pixel; material form only

  /// All budgets times `factor`; spp is rounded down, to 1 at least.
  [[nodiscard]] SampleBudget Scaled(double factor) const {
    return {std::max(1, static_cast<int>(spp * factor)),
            sppe * factor,
            spp_direct * factor,
            spp_indirect * factor,
            spp_pixel * factor};
  }
};
/// The budgets of the boundary terms, those behind the interior, in their order.
inline constexpr std::array kBoundaryBudgets = {&SampleBudget::sppe,
                                                &SampleBudget::spp_direct,
                                                &SampleBudget::spp_indirect,
                                                &SampleBudget::spp_pixel};

/// Budgets of boundary terms that are given; the others are found.
struct BoundaryBudgets {
  std::optional<double> sppe, spp_direct, spp_indirect, spp_pixel;

  /// In the order of kBoundaryBudgets.
  [[nodiscard]] std::array<std::optional<double>, kBoundaryBudgets.size()> All() const {
    return {sppe, spp_direct, spp_indirect, spp_pixel};
  }
  [[nodiscard]] bool HasAll() const {
    return std::ranges::all_of(All(), &std::optional<double>::has_value);
  }
  /// Replaces what is given.
  void ApplyTo(SampleBudget& budget) const {
    for (std::size_t t = 0; t < kBoundaryBudgets.size(); ++t) {
      budget.*kBoundaryBudgets[t] = All()[t].value_or(budget.*kBoundaryBudgets[t]);
    }
  }
};

/// What a sample of a term costs, derivatives and all, in interior samples, by DerivativeTerm;
/// measured in time. Fits of few unknowns hang on what shadows get (decision 0009).
inline constexpr std::array<double, kNumDerivativeTerms> kPathsPerSample = {
    1.0, 1.5, 1.5, 3.0, 0.5};

/// How images and derivatives are estimated, whatever the number of samples.
struct EstimatorOptions {
  int max_bounces = 1;    ///< 0 = only what shines towards the sensor, 1 = direct light
  int rr_depth = 5;       ///< Russian roulette from this bounce on
  DerivativeTerms terms;  ///< whose estimators run
  DerivativeForm form = DerivativeForm::kImage;
  GuideKind guide = GuideKind::kAdaptive;
  double guide_share = 0.25;  ///< share of the boundary samples spent on building the guide
  /// Interior samples come in pairs that share their numbers, the second with mirrored BSDF
  /// samples: derivatives of glossy reflections by normals and positions lose most of their noise
  /// (path_space 1.10), images gain nothing.
  bool antithetic = false;

  /// Whether a term that is on can be there, with this form and number of bounces.
  [[nodiscard]] bool Has(DerivativeTerm term) const {
    switch (term) {
      case DerivativeTerm::kDirect:
        return terms.Has(term) && max_bounces > 0;
      case DerivativeTerm::kIndirect:
        return terms.Has(term) && max_bounces > 1;
      case DerivativeTerm::kPixel:
        return terms.Has(term) && form == DerivativeForm::kMaterial;
      default:
        return terms.Has(term);
    }
  }
};

/// What an image or derivative is a function of, besides scene and camera.
struct RenderOptions : SampleBudget, EstimatorOptions {
  std::uint64_t seed = 0;
  std::uint64_t view = 0;  ///< key of the random streams; usually the index of the view
  /// Derivatives only: whether the image of their interior samples is wanted, too. Without it paths
  /// that no parameter touches are cut short; the derivative is the same, bit for bit.
  bool with_image = true;
};

/// What of a derivative's estimator is given; the rest is found (renderer/budget_search.h).
struct DerivativeChoice : BoundaryBudgets {
  std::optional<DerivativeForm> form;

  /// Replaces what is given; without a form it is that of the image.
  void ApplyTo(RenderOptions& options) const {
    BoundaryBudgets::ApplyTo(options);
    options.form = form.value_or(DerivativeForm::kImage);
  }
};

/// Guides of boundary samples that outlive a pass: later passes of the same view draw by them and
/// spend nothing on pilots, until Clear. A guide that no longer fits the scene costs variance,
/// never the mean. Not safe for passes that run at once.
class GuideStore {
 public:
  GuideStore();
  ~GuideStore();
  GuideStore(const GuideStore&) = delete;
  GuideStore& operator=(const GuideStore&) = delete;
  void Clear();

  struct Guides;  ///< the renderer's own
  [[nodiscard]] Guides& guides() { return *guides_; }

 private:
  std::unique_ptr<Guides> guides_;
};

/// What a rendering uses or fills of its caller's; null: nothing. Not owned.
struct RenderServices {
  /// Keeps guides between passes; null: learned in every pass.
  GuideStore* guides = nullptr;
  const CancelFlag* cancel = nullptr;  ///< polled per image row; throws Cancelled
  RenderStats* stats = nullptr;        ///< added to
};

}  // namespace pathfit::renderer

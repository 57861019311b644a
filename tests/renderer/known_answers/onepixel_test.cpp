#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "tests/renderer/known_answers/known_answer.h"
#include "tests/renderer/known_answers/one_pixel_scene.h"

// Path_space 6.5: one pixel in which every kind of direct-light term is at work. The truth is the
// scene's own measurement without random numbers, differenced; the splits are the printed ones.
namespace pathfit::tests::onepixel_test {
namespace {

using renderer::DerivativeForm;
using renderer::ParameterKind;
using Object = OnePixelScene::Object;

constexpr int kReplicates = 20;

/// A part of the derivative and what the table says about it: interior, primary, direct, pixel.
struct PrintedSplit {
  double interior, primary, direct, pixel, sigma;
};
struct Row {
  std::string name;
  /// Velocity of a point of an object; unset objects rest.
  std::map<Object, std::function<Vec3(Vec3)>> moves;
  Vec3 eye;  ///< velocity of the camera
  /// By filter (box, tent) and form (image, material), where the table has it.
  std::map<std::pair<bool, DerivativeForm>, PrintedSplit> printed;
  /// Of what cancels within terms (the camera: between the pixel's borders).
  double scale = 0.0;
};

std::vector<Row> Rows() {
  const OnePixelScene s;
  const Vec3 occluder = s.Centroid(Object::kOccluder);
  const Vec3 light = s.Centroid(Object::kLight);
  const Vec3 corner = s.points[Object::kOccluder][1];
  const Vec3 shift{0.3, -0.2, 0.4};
  const auto rigid = [=](const Vec3&) { return shift; };
  constexpr auto kImage = DerivativeForm::kImage;
  constexpr auto kMaterial = DerivativeForm::kMaterial;
  return {{"OccluderTranslation",
           {{Object::kOccluder,
             [](Vec3) {
               return Vec3{0.7, 0.4, 0.3};
             }}},
           {},
           {{{false, kImage}, {0.01186, 0.00387, -0.00971, 0.0, 0.00016}},
            {{false, kMaterial}, {0.01958, -0.00389, -0.00971, 0.0, 0.00014}},
            {{true, kImage}, {0.01705, 0.02171, -0.00191, 0.0, 0.00033}},
            {{true, kMaterial}, {0.05834, -0.01990, -0.00179, 0.0, 0.00045}}}},
          {"OccluderVertex",
           {{Object::kOccluder,
             [=](Vec3 p) {
               return p == corner ? Vec3{0.5, -0.3, 0.4} : Vec3{};
             }}},
           {},
           {{{false, kImage}, {0.00080, 0.01342, -0.01457, 0.0, 0.00004}},
            {{false, kMaterial}, {0.02624, -0.01200, -0.01468, 0.0, 0.00007}},
            {{true, kImage}, {0.00298, 0.03190, -0.01008, 0.0, 0.00006}},
            {{true, kMaterial}, {0.06296, -0.02798, -0.01012, 0.0, 0.00020}}}},
          {"OccluderRotation",
           {{Object::kOccluder,
             [=](Vec3 p) {
               return Cross(Vec3{0.3, 0.5, 0.8}, p - occluder);
             }}},
           {},
           {}},
          {"LightTranslationAndRotation",
           {{Object::kLight,
             [=](Vec3 p) {
               return Vec3{0.5, 0.3, -0.4} + Cross(Vec3{0.4, 0.6, 0.2}, p - light);
             }}},
           {},
           {{{false, kImage}, {0.03654, 0.0, -0.00065, 0.0, 0.00004}},
            {{false, kMaterial}, {0.03656, 0.0, -0.00065, 0.0, 0.00004}},
            {{true, kImage}, {0.03829, 0.0, -0.00306, 0.0, 0.00008}},
            {{true, kMaterial}, {0.03827, 0.0, -0.00304, 0.0, 0.00010}}}},
          {"LightScale",
           {{Object::kLight, [=](Vec3 p) { return p - light; }}},
           {},
           {{{false, kImage}, {0.23770, 0.0, 0.00767, 0.0, 0.00018}},
            {{false, kMaterial}, {0.23763, 0.0, 0.00768, 0.0, 0.00015}},
            {{true, kImage}, {0.25626, 0.0, 0.00750, 0.0, 0.00026}},
            {{true, kMaterial}, {0.25652, 0.0, 0.00754, 0.0, 0.00032}}}},
          {"FloorTiltAndShift",
           {{Object::kFloor,
             [](Vec3 p) {
               return Vec3{0.3, 0.5, 0.2} + Cross(Vec3{0.2, 0.15, 0.0}, p);
             }}},
           {},
           {{{false, kImage}, {0.02773, 0.0, -0.00670, 0.0, 0.00002}},
            {{false, kMaterial}, {0.03572, 0.00183, 0.01398, -0.03075, 0.00015}},
            {{true, kImage}, {0.02363, 0.0, -0.01556, 0.0, 0.00005}},
            {{true, kMaterial}, {-0.00596, -0.01303, 0.02684, 0.0, 0.00026}}}},
          {"Camera", {}, {0.4, 0.3, -0.2}, {}, 0.0107},
          {"Everything",
           {{Object::kFloor, rigid}, {Object::kLight, rigid}, {Object::kOccluder, rigid}},
           shift,
           {}}};
}

Motion MotionOf(const Row& row, const renderer::Scene& scene) {
  Motion motion(scene);
  for (const auto& [object, velocity] : row.moves) motion.Vertices(object, velocity);
  if (Norm(row.eye) > 0.0) motion.Add(ParameterKind::kCameraPosition, 0, row.eye);
  return motion;
}

double TrueDerivative(const Row& row, bool tent) {
  const auto moved = [&](double h) {
    OnePixelScene s;
    s.tent = tent;
    s.eye += row.eye * h;
    for (const auto& [object, velocity] : row.moves) {
      for (Vec3& p : s.points[object]) p += velocity(p) * h;
    }
    return s.Measure();
  };
  constexpr double kStep = 1e-3;
  return (moved(kStep) - moved(-kStep)) / (2.0 * kStep);
}

renderer::RenderOptions OptionsOf(DerivativeForm form) {
  renderer::RenderOptions options;
  options.max_bounces = 1;
  options.form = form;
  options.guide = renderer::GuideKind::kNone;
  options.spp = form == DerivativeForm::kMaterial ? 16384 : 4096;  // the filter's slope is noisy
  options.sppe = 16384;
  options.spp_direct = 65536;
  options.spp_pixel = 65536;
  return options;
}

void RecordTerm(const std::string& name, const MeanAndError& term) {
  std::ostringstream text;
  text << term.mean << " sigma " << term.error;
  ::testing::Test::RecordProperty(name, text.str());
}

class OnePixel : public ::testing::TestWithParam<std::tuple<int, bool, DerivativeForm>> {};

TEST_P(OnePixel, TermsAndTotalAreRightAndNoneIsMissing) {
  const auto [index, tent, form] = GetParam();
  const Row row = Rows()[static_cast<std::size_t>(index)];
  OnePixelScene s;
  s.tent = tent;
  const renderer::Renderer renderer(s.ToScene());
  const renderer::Camera& camera = renderer.scene().sensors[0];
  const TermReplicates replicates = DerivativeByTerm(
      renderer, camera, MotionOf(row, renderer.scene()), OptionsOf(form), kReplicates);
  if (row.name == "Everything") {
    for (const auto& term : replicates.terms) {
      for (const double value : term) EXPECT_LT(std::abs(value), 1e-12);
    }
    return;
  }
  const double exact = TrueDerivative(row, tent);
  double size = row.scale;  // of what cancels in the total
  std::array<MeanAndError, kNumTerms> terms;
  for (std::size_t t = 0; t < kNumTerms; ++t) {
    terms[t] = EstimateMean(replicates.terms[t]);
    RecordTerm(renderer::kDerivativeTerms[t].first, terms[t]);
    size = std::max(size, std::abs(terms[t].mean));
  }
  ExpectKnown("derivative", replicates.Total(), {exact, size});
  if (const auto found = row.printed.find({tent, form}); found != row.printed.end()) {
    const PrintedSplit& p = found->second;
    const std::array<double, kNumTerms> printed{p.interior, p.primary, p.direct, 0.0, p.pixel};
    for (std::size_t t = 0; t < kNumTerms; ++t) {
      // 5e-6: the table's last digit
      EXPECT_NEAR(terms[t].mean, printed[t], 4.0 * std::hypot(terms[t].error, p.sigma) + 5e-6)
          << renderer::kDerivativeTerms[t].first;
    }
  }
  for (std::size_t t = 0; t < kNumTerms; ++t) {
    if (std::abs(terms[t].mean) <= 10.0 * terms[t].error) continue;
    for (const double factor : {0.0, -1.0}) {
      std::array<double, kNumTerms> mutant{1, 1, 1, 1, 1};
      mutant[t] = factor;
      const MeanAndError m = EstimateMean(replicates.Total(mutant));
      EXPECT_GT(std::abs(m.mean - exact), 4.0 * m.error)
          << renderer::kDerivativeTerms[t].first << " times " << factor;
    }
  }
}

std::string NameOf(const ::testing::TestParamInfo<OnePixel::ParamType>& info) {
  const auto [index, tent, form] = info.param;
  return Rows()[static_cast<std::size_t>(index)].name + (tent ? "Tent" : "Box") +
         (form == DerivativeForm::kImage ? "Image" : "Material");
}

INSTANTIATE_TEST_SUITE_P(PathSpace65,
                         OnePixel,
                         ::testing::Combine(::testing::Range(0, 8),
                                            ::testing::Bool(),
                                            ::testing::Values(DerivativeForm::kImage,
                                                              DerivativeForm::kMaterial)),
                         NameOf);

/// Two ways to say the same motion: all estimates are the same numbers.
void ExpectSame(const renderer::Renderer& renderer,
                const Motion& one,
                const Motion& other,
                double factor,
                DerivativeForm form,
                double tolerance) {
  renderer::RenderOptions options = OptionsOf(form);
  options.spp = 64;
  options.sppe = options.spp_direct = options.spp_pixel = 512;
  const renderer::Camera& camera = renderer.scene().sensors[0];
  const TermReplicates a = DerivativeByTerm(renderer, camera, one, options, 2);
  const TermReplicates b = DerivativeByTerm(renderer, camera, other, options, 2);
  double largest = 0.0;
  for (std::size_t t = 0; t < kNumTerms; ++t) {
    for (std::size_t i = 0; i < a.terms[t].size(); ++i) {
      EXPECT_NEAR(a.terms[t][i], factor * b.terms[t][i], tolerance)
          << renderer::kDerivativeTerms[t].first;
      largest = std::max(largest, std::abs(a.terms[t][i]));
    }
  }
  EXPECT_GT(largest, 1e-4);  // something moves
}

class OnePixelForms : public ::testing::TestWithParam<DerivativeForm> {};

TEST_P(OnePixelForms, PosesMoveAsVerticesDo) {
  OnePixelScene s;
  std::array<Vec3, 3> pivots;
  for (int i = 0; i < 3; ++i) {
    pivots[static_cast<std::size_t>(i)] = s.Centroid(static_cast<Object>(i));
  }
  const renderer::Renderer renderer(s.ToScene(pivots));
  const renderer::Scene& scene = renderer.scene();
  const Vec3 shift{0.7, 0.4, 0.3};
  const Vec3 turn{0.3, 0.5, 0.8};
  for (const Object object : {Object::kFloor, Object::kLight, Object::kOccluder}) {
    SCOPED_TRACE(object);
    const Vec3 pivot = pivots[object];
    ExpectSame(renderer,
               Motion(scene)
                   .Add(ParameterKind::kObjectTranslation, object, shift)
                   .Add(ParameterKind::kObjectRotation, object, turn)
                   .Add(ParameterKind::kObjectScale, object, std::vector{0.6}),
               Motion(scene).Vertices(object,
                                      [&](const Vec3& p) {
                                        return shift + Cross(turn, p - pivot) + (p - pivot) * 0.6;
                                      }),
               1.0,
               GetParam(),
               1e-11);
  }
}

TEST_P(OnePixelForms, C27CameraMovesAsTheWorldDoesTheOtherWay) {
  for (const bool tent : {false, true}) {
    OnePixelScene s;
    s.tent = tent;
    const renderer::Renderer renderer(s.ToScene());
    const renderer::Scene& scene = renderer.scene();
    const Vec3 shift{0.4, 0.3, -0.2};
    const Vec3 turn{0.2, -0.1, 0.3};
    const auto moved = [&](const Vec3& p) { return shift + Cross(turn, p - s.eye); };
    ExpectSame(renderer,
               Motion(scene)
                   .Add(ParameterKind::kCameraPosition, 0, shift)
                   .Add(ParameterKind::kCameraRotation, 0, turn),
               Motion(scene).Vertices(0, moved).Vertices(1, moved).Vertices(2, moved),
               -1.0,
               GetParam(),
               1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(PathSpace65,
                         OnePixelForms,
                         ::testing::Values(DerivativeForm::kImage, DerivativeForm::kMaterial));

}  // namespace
}  // namespace pathfit::tests::onepixel_test

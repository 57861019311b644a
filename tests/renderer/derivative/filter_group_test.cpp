#include <array>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/sensor/pixel_filter.h"
#include "tests/support/probe.h"
#include "tests/support/quadrature.h"

// Path_space 6.6: the slope of a smooth filter times what moves under it. A pixel's samples come in
// fours, mirrored about its axes; one sample alone is an independent one, two are mirrored along u.
// Samples cover the filter's support evenly. So do the table's for the tent; its Gaussian is
// sampled by its own density, which gains less.
namespace pathfit::renderer::filter_group_test {
namespace {

constexpr int kRows = 4096;  // pixels that all see the same; each with numbers of its own
constexpr double kStep = 0.2;

struct Row {
  const char* name;
  PixelFilter filter;
  bool step;
  double printed_ratio;  ///< variance of two independent samples over that of a mirrored pair
  double printed_mean;
};
constexpr std::array<Row, 4> kTable{
    {{"tent, smooth", {PixelFilter::Shape::kTent, 1.0}, false, 76.5, -0.3001},
     {"tent, step", {PixelFilter::Shape::kTent, 1.0}, true, 9.61, -0.5603},
     {"gauss, smooth", {PixelFilter::Shape::kGaussian, 1.5, 0.5}, false, 16.8, -0.2919},
     {"gauss, step", {PixelFilter::Shape::kGaussian, 1.5, 0.5}, true, 4.41, -0.5109}}};

/// Radiance at this many pixels from the centre.
double Smooth(double d) { return 1.0 + 0.3 * d + 0.2 * d * d; }
double Radiance(const Row& row, double d) {
  if (!row.step) return Smooth(d);
  return d < kStep ? 0.3 : 1.0;
}

/// Moments of the derivative by a shift along one axis: of one sample and of a mirrored pair in one
/// variable, and of the weight by the other axis.
struct Moments {
  double mean, single2, pair2, weight2;

  [[nodiscard]] double Ratio() const {
    return 0.5 * (single2 - mean * mean) / (pair2 - mean * mean);
  }
};
/// `value`, `slope`: of the filter. `density`: of the samples.
template <class Value, class Slope, class Density>
Moments MomentsOf(const Row& row, Value value, Slope slope, Density density) {
  const auto sample = [&](double d) { return slope(d) / density(d) * Radiance(row, d); };
  const auto average = [&](auto f) {
    const double r = row.filter.radius;
    const std::array<double, 5> cuts{-r, -kStep, 0.0, kStep, r};
    double sum = 0.0;
    for (std::size_t i = 1; i < cuts.size(); ++i) {
      sum += tests::Integrate([&](double d) { return density(d) * f(d); }, cuts[i - 1], cuts[i]);
    }
    return sum;
  };
  return {average(sample),
          average([&](double d) { return sample(d) * sample(d); }),
          average([&](double d) { return std::pow(0.5 * (sample(d) + sample(-d)), 2); }),
          average([&](double d) { return std::pow(value(d) / density(d), 2); })};
}
/// What the program does.
Moments Exact(const Row& row) {
  return MomentsOf(
      row,
      [&](double d) { return FilterProfile(row.filter, d); },
      [&](double d) { return FilterSlope(row.filter, d); },
      [&](double) { return 0.5 / row.filter.radius; });
}
/// What the table's Gaussian is: cut, but not lowered to zero, and sampled by its own density.
Moments ByItsDensity(const Row& row) {
  const double sigma = row.filter.sigma;
  const auto bell = [&](double d) { return std::exp(-0.5 * d * d / (sigma * sigma)); };
  const double norm = tests::Integrate(bell, -row.filter.radius, row.filter.radius);
  const auto value = [&](double d) { return bell(d) / norm; };
  return MomentsOf(
      row, value, [&](double d) { return -d / (sigma * sigma) * value(d); }, value);
}

/// A shining plane of which every pixel of one column (or row) of pixels sees the same.
Scene ShiningPlane(const Row& row, bool along_u) {
  Scene scene;
  scene.materials = {{"black", LambertBsdf{}, {0.0, 0.0, 0.0}}};
  const double reach = 3.0;
  const double length = 0.5 * kRows + reach;
  const auto add = [&](double from, double to, double radiance, int texture) {
    Mesh mesh;  // v runs down
    for (const auto& [d, s] :
         {std::pair{from, -length}, {to, -length}, {to, length}, {from, length}}) {
      mesh.positions.push_back(along_u ? Vec3{d, s, 0} : Vec3{s, -d, 0});
    }
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    mesh.uv_triangles = mesh.triangles;
    AreaEmitter light;
    light.mesh = static_cast<int>(scene.meshes.size());
    light.intensity = Rgb::Constant(radiance);
    light.texture = texture;
    light.two_sided = true;
    scene.meshes.push_back({"plane", mesh, 0, {}});
    scene.emitters.push_back({"light", LightFrame::kWorld, {}, light});
  };
  if (row.step) {
    add(-reach, kStep, Radiance(row, 0.0), -1);
    add(kStep, reach, Radiance(row, 1.0), -1);
  } else {
    Texture ramp;
    ramp.name = "ramp";
    ramp.width = 1024;
    ramp.wrap = TextureWrap::kClamp;
    ramp.texels.clear();
    for (int i = 0; i < ramp.width; ++i) {
      ramp.texels.push_back(Rgb::Constant(Smooth(reach * ((2.0 * i + 1.0) / ramp.width - 1.0))));
    }
    scene.textures = {ramp};
    add(-reach, reach, 1.0, 0);
  }
  Camera camera =
      tests::CameraAt({0, 0, 1}, {0, 0, 0}, 1.0, along_u ? 1 : kRows, along_u ? kRows : 1);
  camera.projection = ProjectionKind::kOrthographic;
  camera.filter = row.filter;
  scene.sensors = {camera};
  return scene;
}

/// Mean, second moment, and its standard error, of the pixels' derivatives.
struct Measured {
  double mean, mean_error, second, second_error;
};
Measured Measure(const Row& row, bool along_u, int spp, int renderings) {
  const Scene scene = ShiningPlane(row, along_u);
  const Renderer renderer(scene);
  tests::Motion motion(scene);
  for (int i = 0; i < static_cast<int>(scene.meshes.size()); ++i) {
    motion.Add(ParameterKind::kObjectTranslation, i, along_u ? Vec3{1, 0, 0} : Vec3{0, -1, 0});
  }
  RenderOptions options;
  options.form = DerivativeForm::kMaterial;
  options.terms = {DerivativeTerm::kInterior};
  options.max_bounces = 0;
  options.spp = spp;
  const Camera& camera = scene.sensors[0];
  double n = 0.0;
  std::array<double, 3> sums{};  // of powers 1, 2, 4
  for (int i = 0; i < renderings; ++i) {
    options.seed = static_cast<std::uint64_t>(i) + 1000 * static_cast<std::uint64_t>(spp);
    FilmSink sink(motion.layout, motion.direction, camera.width, camera.height);
    renderer.RenderDerivative(camera, 0, options, motion.layout, sink);
    for (const Rgba& pixel : sink.film().pixels) {
      const double square = pixel.r * pixel.r;
      sums[0] += pixel.r;
      sums[1] += square;
      sums[2] += square * square;
      n += 1.0;
    }
  }
  const double mean = sums[0] / n;
  const double second = sums[1] / n;
  return {mean,
          std::sqrt((second - mean * mean) / n),
          second,
          std::sqrt((sums[2] / n - second * second) / n)};
}

class FilterGroup : public ::testing::TestWithParam<int> {};

/// The table's figures are those of 200000 samples or so.
TEST_P(FilterGroup, TheTableIsWhatItSays) {
  const Row& row = kTable[static_cast<std::size_t>(GetParam())];
  const bool tent = row.filter.shape == PixelFilter::Shape::kTent;
  const Moments printed = tent ? Exact(row) : ByItsDensity(row);
  EXPECT_NEAR(printed.mean, row.printed_mean, 1e-3);
  EXPECT_NEAR(printed.Ratio(), row.printed_ratio, 0.01 * row.printed_ratio);
  EXPECT_GE(Exact(row).Ratio(), printed.Ratio());
}

TEST_P(FilterGroup, MirroredSamplesReachTheKnownVarianceRatios) {
  const Row& row = kTable[static_cast<std::size_t>(GetParam())];
  const Moments exact = Exact(row);
  const double ratio = exact.Ratio();
  // The weight by the other axis is taken out: what is left is one variable's variance.
  const auto variance = [&](double second) {
    return second / exact.weight2 - exact.mean * exact.mean;
  };
  struct Case {
    bool along_u;
    int spp, renderings, singles;
    double sigma;  ///< largest share of the ratio
  };
  for (const Case& c :
       {Case{true, 2, 48, 32, 0.02}, {true, 4, 224, 64, 0.01}, {false, 4, 56, 32, 0.02}}) {
    const Measured single = Measure(row, c.along_u, 1, c.singles);
    const Measured group = Measure(row, c.along_u, c.spp, c.renderings);
    const double found = 0.5 * variance(single.second) / variance(group.second);
    const double error =
        found * std::hypot(single.second_error / exact.weight2 / variance(single.second),
                           group.second_error / exact.weight2 / variance(group.second));
    std::ostringstream text;
    text << row.name << (c.along_u ? " along u, " : " along v, ") << c.spp << " samples: mean "
         << group.mean << " +- " << group.mean_error << ", exact " << exact.mean << "; ratio "
         << found << " +- " << error << ", exact " << ratio << ", printed " << row.printed_ratio;
    RecordProperty(std::string(c.along_u ? "u" : "v") + std::to_string(c.spp), text.str());
    EXPECT_NEAR(group.mean, exact.mean, 4.0 * group.mean_error) << text.str();
    EXPECT_NEAR(found, ratio, 4.0 * error) << text.str();
    EXPECT_LT(error, c.sigma * ratio) << text.str();
  }
}

INSTANTIATE_TEST_SUITE_P(PathSpace66, FilterGroup, ::testing::Range(0, 4));

}  // namespace
}  // namespace pathfit::renderer::filter_group_test

#include "renderer/derivative/film_sink.h"

#include <gtest/gtest.h>

#include "renderer/renderer.h"
#include "renderer/sampler/counter_rng.h"
#include "tests/support/recording_sink.h"
#include "tests/support/test_scenes.h"

namespace pathfit::renderer::film_sink_test {
namespace {

// Both sides sum the same numbers in different orders: a few thousand roundings.
constexpr double kSummation = 1e-11;

class SinksOfOneRendering : public ::testing::Test {
 protected:
  SinksOfOneRendering() : renderer_(tests::BallAndWall()), layout_(renderer_.scene()) {
    for (const auto& [kind, object] : {std::pair{ParameterKind::kVertexPositions, 0},
                                       std::pair{ParameterKind::kVertexPositions, 1},
                                       std::pair{ParameterKind::kVertexColors, 0},
                                       std::pair{ParameterKind::kBaseColor, 1},
                                       std::pair{ParameterKind::kRoughness, 1},
                                       std::pair{ParameterKind::kMetallic, 1},
                                       std::pair{ParameterKind::kLightIntensity, 1},
                                       std::pair{ParameterKind::kEnvironmentTexels, 0},
                                       std::pair{ParameterKind::kExposure, 0}}) {
      layout_.Add(kind, object);
    }
    options_.spp = 4;
    options_.max_bounces = 2;
    options_.seed = 3;
  }
  void Render(DerivativeSink& sink) const {
    renderer_.RenderDerivative(Sensor(), 0, options_, layout_, sink);
  }
  [[nodiscard]] const Camera& Sensor() const { return renderer_.scene().sensors[0]; }
  [[nodiscard]] std::size_t NumPixels() const {
    return static_cast<std::size_t>(Sensor().width) * static_cast<std::size_t>(Sensor().height);
  }

  Renderer renderer_;
  ParameterLayout layout_;
  RenderOptions options_;
};

TEST_F(SinksOfOneRendering, FilmSinkIsTheJacobianTimesADirection) {
  std::vector<double> direction;
  CounterRng rng(1);
  for (std::int64_t i = 0; i < layout_.NumScalars(); ++i)
    direction.push_back(2.0 * rng.Next() - 1.0);
  FilmSink film(layout_, direction, Sensor().width, Sensor().height);
  tests::RecordingSink record(NumPixels());
  Render(film);
  Render(record);
  double largest = 0.0;
  for (std::size_t pixel = 0; pixel < NumPixels(); ++pixel) {
    Rgba expected;
    for (const ParameterDerivative& entry : record.pixels[pixel]) {
      const int size = layout_.GroupOfBlock(entry.block).block_size;
      for (int c = 0; c < size; ++c) {
        expected +=
            entry.d[static_cast<std::size_t>(c)] *
            direction[static_cast<std::size_t>(layout_.FirstScalarOfBlock(entry.block) + c)];
      }
    }
    for (int c = 0; c < 4; ++c) {
      EXPECT_NEAR(
          film.film().pixels[pixel][c], expected[c], kSummation * (1.0 + std::abs(expected[c])));
      largest = std::max(largest, std::abs(expected[c]));
    }
  }
  EXPECT_GT(largest, 0.1) << "the comparison is not of zeros";
}

TEST_F(SinksOfOneRendering, SeveralDirectionsAreTheSameAsEachAlone) {
  std::vector<std::vector<double>> directions(
      2, std::vector<double>(static_cast<std::size_t>(layout_.NumScalars())));
  for (std::size_t i = 0; i < directions[0].size(); ++i) directions[i % 2][i] = 1.0;
  FilmSinks together(layout_, directions, Sensor().width, Sensor().height);
  Render(together);
  for (std::size_t d = 0; d < directions.size(); ++d) {
    FilmSink alone(layout_, directions[d], Sensor().width, Sensor().height);
    Render(alone);
    double largest = 0.0;
    for (std::size_t pixel = 0; pixel < NumPixels(); ++pixel) {
      EXPECT_EQ(together.film(d).pixels[pixel], alone.film().pixels[pixel]);
      largest = std::max(largest, std::abs(alone.film().pixels[pixel].g));
    }
    EXPECT_GT(largest, 0.0);
  }
}

TEST_F(SinksOfOneRendering, ComponentsBeyondTheBlockSizeAreZero) {
  tests::RecordingSink record(NumPixels());
  Render(record);
  for (const auto& pixel : record.pixels) {
    for (const ParameterDerivative& entry : pixel) {
      ASSERT_GE(entry.block, 0);
      ASSERT_LT(entry.block, layout_.NumBlocks());
      for (auto c = static_cast<std::size_t>(layout_.GroupOfBlock(entry.block).block_size); c < 3;
           ++c) {
        EXPECT_EQ(entry.d[c], Rgba());
      }
    }
  }
}

}  // namespace
}  // namespace pathfit::renderer::film_sink_test

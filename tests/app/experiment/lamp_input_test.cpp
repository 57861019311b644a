#include "app/experiment/lamp_input.h"

#include <fstream>
#include <stdexcept>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "app/config/experiment_config.h"
#include "app/experiment/experiment.h"
#include "app/experiment/lamp_draft.h"
#include "app/experiment/start_check.h"
#include "renderer/core/error.h"
#include "renderer/image/color.h"
#include "renderer/io/image_file.h"
#include "renderer/io/ply_file.h"
#include "tests/optim/observation/lit_ball.h"
#include "tests/optim/observation/observation_files.h"

namespace pathfit::app::lamp_input_test {
namespace {

namespace fs = std::filesystem;
using renderer::Image;
using renderer::Vec3;

/// Photos of a ball, a lamp for each, in a folder.
class LampInputTest : public ::testing::Test {
 protected:
  /// `number` of the first; then by ones, so that ten comes after nine.
  void WritePhotos(const fs::path& photos, int number, bool encode = false) {
    fs::create_directories(photos);
    for (std::size_t k = 0; k < tests::BallLamps().size(); ++k) {
      Image photo = tests::LitBall(tests::BallLamps()[k], tests::kBallStrengths[k], 0.6);
      for (float& value : photo.data) {
        if (encode)
          value = static_cast<float>(renderer::SrgbFromLinear(static_cast<double>(value)));
      }
      names_.push_back(fmt::format("p_{}.png", number + static_cast<int>(k)));
      renderer::WritePng8(photos / names_.back(), photo);
    }
  }
  /// `flip`: y down.
  static std::string Directions(bool flip = false) {
    std::string text;
    for (const Vec3& lamp : tests::BallLamps()) {
      text += fmt::format("{} {} {}\n", lamp.x, flip ? -lamp.y : lamp.y, lamp.z);
    }
    return text;
  }
  void WriteMask(const fs::path& path) { renderer::WritePng8(path, tests::BallMask()); }
  [[nodiscard]] const fs::path& top() const { return folder_.path(); }
  fs::path Write(const std::string& name, const std::string& text) {
    return folder_.WriteText(name, text);
  }
  static std::string Refusal(const LampPlaces& places) {
    try {
      static_cast<void>(FindLamps(places));
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }
  std::vector<std::string> names_;

 private:
  optim::TempFolder folder_;
};

bool Guesses(const FoundLamps& found, const std::string& part) {
  return std::ranges::any_of(found.guesses, [&](const std::string& guess) {
    return guess.find(part) != std::string::npos;
  });
}

TEST_F(LampInputTest, NumbersStrengthsAndLinearValuesAreFound) {
  WritePhotos(top() / "photos", 8);
  WriteMask(top() / "photos/mask.png");
  Write("photos/light_directions.txt", Directions());
  EXPECT_EQ(FindLampFile(top() / "photos"), top() / "photos/light_directions.txt");
  const FoundLamps found =
      FindLamps({.photos = top() / "photos", .lamps = FindLampFile(top() / "photos")});
  ASSERT_EQ(found.lamps.size(), 5U);
  EXPECT_EQ(found.lamps[2].photo, "p_10.png");
  EXPECT_EQ(found.options.transfer, optim::Transfer::kLinear);
  EXPECT_FALSE(found.strengths_known);
  EXPECT_FALSE(found.mask_made);
  EXPECT_FALSE(found.all_pictures);
  EXPECT_EQ(found.pattern, "p_*");
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_NEAR(found.lamps[k].strength.g, tests::kBallStrengths[k], 0.02);
    EXPECT_NEAR(found.lamps[k].towards.y, tests::BallLamps()[k].y, 1e-9);
  }
}

TEST_F(LampInputTest, TheDraftIsOneThatCanBeFitted) {
  WritePhotos(top() / "photos", 1);
  Write(
      "photos/dome.lp", "5\n" + [&] {
        std::string text;
        for (std::size_t k = 0; k < 5; ++k) {
          const Vec3& lamp = tests::BallLamps()[k];
          text += fmt::format("C:\\dome\\{} {} {} {}\n", names_[k], lamp.x, lamp.y, lamp.z);
        }
        return text;
      }());
  const FoundLamps found =
      FindLamps({.photos = top() / "photos", .lamps = FindLampFile(top() / "photos")});
  EXPECT_TRUE(found.mask_made);
  EXPECT_TRUE(found.all_pictures);
  const LampDraftFiles files{.config = top() / "ball.yaml",
                             .mesh = top() / "ball_start.ply",
                             .mask = top() / "ball_mask.png"};
  renderer::WritePly(files.mesh, LampStart(found));
  renderer::WritePng8(files.mask, found.mask);
  std::ofstream(files.config) << DraftLampConfig(found, files, "ball");
  const ExperimentConfig config = LoadExperimentConfig(files.config, {});
  const Experiment experiment = BuildExperiment(config);
  const StartCheck check = CheckStart(config, experiment);
  EXPECT_TRUE(check.warnings.empty());
  ASSERT_EQ(check.views.size(), 5U);
  EXPECT_GT(check.views.front().iou, 0.95);

  std::ofstream(files.config) << DraftLampConfig(found, files, "ball", DraftSurface::kShiny);
  EXPECT_EQ(BuildExperiment(LoadExperimentConfig(files.config, {})).fit.unknowns.size(),
            experiment.fit.unknowns.size() + 1);
}

TEST_F(LampInputTest, EncodedPhotosAndLampsWithYDown) {
  WritePhotos(top(), 1, true);
  WriteMask(top() / "the_mask.png");
  const fs::path lamps = Write("lights/l.txt", Directions(true));
  EXPECT_TRUE(FindLampFile(top()).empty());
  const FoundLamps found = FindLamps({.photos = top(), .lamps = lamps});
  EXPECT_EQ(found.options.transfer, optim::Transfer::kSrgb);
  EXPECT_TRUE(Guesses(found, "y of the lamps"));
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_NEAR(found.lamps[k].towards.y, tests::BallLamps()[k].y, 1e-9);
  }
}

TEST_F(LampInputTest, NamesAndStrengthsBesideTheDirections) {
  WritePhotos(top(), 1);
  WriteMask(top() / "mask.png");
  const fs::path lamps = Write("light_directions.txt", Directions());
  Write("light_intensities.txt", "1.4 1.4 1.4\n2.6 2.6 2.6\n2 2 2\n2.4 2.4 2.4\n1.6 1.6 1.6\n");
  Write("filenames.txt", "p_1.png\np_2.png\np_3.png\np_4.png\np_5.png\n");
  const FoundLamps found = FindLamps({.photos = top(), .lamps = lamps});
  EXPECT_TRUE(found.strengths_known);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_NEAR(found.lamps[k].strength.b, tests::kBallStrengths[k], 1e-9);
  }
  EXPECT_LT(found.shading.residual, 0.01);
}

TEST_F(LampInputTest, ABallTellsTheLamps) {
  WritePhotos(top() / "photos", 8);
  WriteMask(top() / "photos/mask.png");
  const fs::path ball = top() / "ball";
  fs::create_directories(ball);
  for (std::size_t k = 0; k < 5; ++k) {
    renderer::WritePng8(ball / fmt::format("b{}.png", k + 8),
                        tests::ShinyBall(tests::BallLamps()[k], 0.7, 0.2));
  }
  const LampPlaces places{.photos = top() / "photos", .ball = ball};
  EXPECT_NE(Refusal(places).find("0 masks of the ball"), std::string::npos);
  WriteMask(ball / "ball_mask.png");
  const auto expect_lamps = [](const FoundLamps& found) {
    ASSERT_EQ(found.lamps.size(), 5U);
    EXPECT_TRUE(found.by_ball);
    for (std::size_t k = 0; k < 5; ++k) {
      EXPECT_GT(renderer::Dot(found.lamps[k].towards, tests::BallLamps()[k]), 0.999);
    }
    EXPECT_EQ(found.lamps[2].photo, "p_10.png");
  };
  expect_lamps(FindLamps(places));

  // A ball in the photos themselves, which are of nothing else here.
  for (std::size_t k = 0; k < 5; ++k) {
    renderer::WritePng8(top() / "photos" / names_[k],
                        tests::ShinyBall(tests::BallLamps()[k], 0.7, 0.2));
  }
  expect_lamps(FindLamps({.photos = top() / "photos", .ball = ball / "ball_mask.png"}));

  renderer::WritePng8(ball / "b9.png", Image(tests::kBallSize, tests::kBallSize, 3));
  EXPECT_NE(Refusal(places).find("b9.png: the ball has no highlight"), std::string::npos);
}

TEST_F(LampInputTest, NumbersInTheMiddleOfNamesCount) {
  WritePhotos(top() / "photos", 8);
  WriteMask(top() / "photos/mask.png");
  for (std::size_t k = 0; k < 5; ++k) {
    fs::rename(top() / "photos" / names_[k], top() / fmt::format("photos/lamp{}_f8.png", k + 8));
  }
  const fs::path lamps = Write("l.txt", Directions());
  const FoundLamps found = FindLamps({.photos = top() / "photos", .lamps = lamps});
  EXPECT_EQ(found.lamps[0].photo, "lamp8_f8.png");
  EXPECT_EQ(found.lamps[2].photo, "lamp10_f8.png");
  EXPECT_FALSE(Guesses(found, "in their order"));
  // Another order is noticed.
  std::string turned = "lamp9_f8.png 0.48 0 0.877\nlamp8_f8.png -0.3 0.4 0.866\n";
  turned +=
      "lamp12_f8.png 0 -0.5 0.866\nlamp10_f8.png 0.2 0.3 0.9327\nlamp11_f8.png -0.4 -0.2 0.894\n";
  EXPECT_TRUE(Guesses(FindLamps({.photos = top() / "photos", .lamps = Write("t.txt", turned)}),
                      "explains the photos badly"));
}

TEST_F(LampInputTest, TheMaskOfAnotherObjectIsNotTaken) {
  WritePhotos(top() / "dog", 1);
  WriteMask(top() / "cat_mask.png");
  const fs::path lamps = Write("l.txt", Directions());
  EXPECT_TRUE(FindLamps({.photos = top() / "dog", .lamps = lamps}).mask_made);
  WriteMask(top() / "dog_mask.png");
  const FoundLamps found = FindLamps({.photos = top() / "dog", .lamps = lamps});
  EXPECT_EQ(found.options.masks.folder, top() / "dog_mask.png");
}

TEST_F(LampInputTest, ThreeLampsDoNotTellTheTransfer) {
  WritePhotos(top() / "photos", 1);
  WriteMask(top() / "photos/mask.png");
  fs::remove(top() / "photos/p_4.png");
  fs::remove(top() / "photos/p_5.png");
  const fs::path lamps = Write("l.txt", "0.48 0 0.877\n-0.3 0.4 0.866\n0 -0.5 0.866\n");
  const FoundLamps found = FindLamps({.photos = top() / "photos", .lamps = lamps});
  EXPECT_EQ(found.options.transfer, optim::Transfer::kSrgb);
  EXPECT_TRUE(Guesses(found, "do not tell"));
  EXPECT_TRUE(Guesses(found, "the shading does not tell them"));
  EXPECT_NE(Refusal({.photos = top() / "photos", .lamps = Write("two.txt", "0 0 1\n0 1 1\n")})
                .find("by 3 or more"),
            std::string::npos);
}

TEST_F(LampInputTest, RefusesPhotosThatAreNotThoseOfTheLamps) {
  WritePhotos(top() / "photos", 1);
  const fs::path six = Write("six.txt", Directions() + "0 0 1\n");
  const std::string text = Refusal({.photos = top() / "photos", .lamps = six});
  EXPECT_NE(text.find("6 lamps"), std::string::npos) << text;
  EXPECT_NE(text.find("5 pictures"), std::string::npos) << text;
  const fs::path named = Write("named.txt", "p_1.png 0 0 1\nq.png 0 1 1\np_3.png 1 0 1\n");
  EXPECT_NE(Refusal({.photos = top() / "photos", .lamps = named}).find("q.png"), std::string::npos);
  const fs::path twice = Write("twice.txt", "p_1.png 0 0 1\np_1.png 0 1 1\np_3.png 1 0 1\n");
  EXPECT_NE(Refusal({.photos = top() / "photos", .lamps = twice}).find("two lamps"),
            std::string::npos);
  renderer::WritePng8(top() / "photos/p_3.png",
                      Image(2 * tests::kBallSize, 2 * tests::kBallSize, 3));
  const fs::path five = Write("five.txt", Directions());
  EXPECT_NE(Refusal({.photos = top() / "photos", .lamps = five}).find("are of one size"),
            std::string::npos);
  EXPECT_NE(Refusal({.photos = top() / "none", .lamps = six}).find("no such folder"),
            std::string::npos);
}

}  // namespace
}  // namespace pathfit::app::lamp_input_test

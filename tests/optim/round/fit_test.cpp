#include "optim/round/fit.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "optim/checkpoint/checkpoint.h"
#include "optim/problem/problem_size.h"
#include "optim/round/memory_forecast.h"
#include "optim/round/mesh_levels.h"
#include "optim/round/round_policy.h"
#include "renderer/core/error.h"
#include "renderer/geometry/mesh_folds.h"
#include "tests/optim/round/synthetic_fit.h"
#include "tests/support/sanitized.h"

namespace pathfit::fit_test {
namespace {

namespace fs = std::filesystem;
using optim::FitControls;
using optim::FitResult;
using optim::FitSpec;
using optim::FitStatus;
using optim::UnknownSpec;
using renderer::ParameterKind;
using tests::RecordingObserver;

FitSpec SmallSpec() {
  FitSpec spec;
  spec.seed = 11;
  UnknownSpec vertices;
  vertices.name = "ball.vertices";
  vertices.laplacian_weight = 1e-3;
  vertices.large_steps_lambda = 5.0;
  UnknownSpec texels;
  texels.name = "sky.texels";
  texels.kind = ParameterKind::kEnvironmentTexels;
  texels.parameterization = optim::Parameterization::kLog;
  UnknownSpec exposure;
  exposure.name = "exposure";
  exposure.kind = ParameterKind::kExposure;
  exposure.object = -1;
  spec.unknowns = {vertices, texels, exposure};
  optim::StageSpec stage;
  stage.name = "light";
  stage.free = {1, 2};
  stage.image_scale = 0.5;
  stage.max_rounds = 3;
  stage.samples.spp = 4;
  stage.max_spp = 8;
  spec.stages.push_back(stage);
  stage.name = "all";
  stage.free = {0, 1, 2};
  stage.image_scale = 1.0;
  spec.stages.push_back(stage);
  return spec;
}

class FitTest : public testing::Test {
 protected:
  FitTest() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("pathfit_fit_" + std::to_string(getpid()) + "_" + info->name());
    fs::remove_all(folder_);
    renderer::Scene truth = start_;
    tests::Bump(truth);
    for (std::size_t i = 0; i < truth.sensors.size(); ++i) {
      truth.sensors[i].gain = 1.0 + 0.1 * static_cast<double>(i % 3);
    }
    observations_ = tests::Photograph(truth, 16);
  }
  ~FitTest() override { fs::remove_all(folder_); }
  FitTest(const FitTest&) = delete;
  FitTest& operator=(const FitTest&) = delete;

  // Everything that can move, for comparison to the last bit.
  static std::vector<double> Bits(const renderer::Scene& scene) {
    std::vector<double> values;
    for (const renderer::Vec3& p : scene.meshes[0].mesh.positions) {
      values.insert(values.end(), {p.x, p.y, p.z});
    }
    for (const renderer::Rgb& t :
         std::get<renderer::EnvironmentEmitter>(scene.emitters[0].light).texels) {
      values.insert(values.end(), {t.r, t.g, t.b});
    }
    for (const renderer::Camera& sensor : scene.sensors) {
      values.push_back(sensor.gain);
    }
    return values;
  }

  FitResult Fit(optim::FitObserver& observer, const FitControls& controls = {}) const {
    return optim::RunFit(start_, observations_, spec_, observer, controls);
  }
  [[nodiscard]] std::optional<optim::FitState> Newest(const fs::path& folder) const {
    return optim::ReadNewestCheckpoint(folder, {start_, spec_.unknowns}).state;
  }

  /// Stopped after each round and resumed, the fit ends as it does in one go.
  void ExpectSameBitsFromEveryRound(const FitResult& straight) const {
    ExpectSameBitsFromRounds(
        tests::kSanitized ? straight.rounds - 1 : 1, straight.rounds, straight);
  }
  void ExpectSameBitsFromRounds(int first_round, int last_round, const FitResult& straight) const {
    for (int round = first_round; round <= last_round; ++round) {
      FitControls controls;
      controls.checkpoint_folder = folder_ / std::to_string(round);
      RecordingObserver first;
      first.cancel_after = round;
      controls.cancel = &first.cancel;
      const FitResult stopped = Fit(first, controls);
      EXPECT_EQ(stopped.status, FitStatus::kCancelled);
      EXPECT_EQ(stopped.rounds, round);
      controls.cancel = nullptr;
      controls.resume = Newest(controls.checkpoint_folder);
      ASSERT_TRUE(controls.resume.has_value());
      const renderer::ThreadLimit limit(1 + round % 2);
      RecordingObserver second;
      const FitResult resumed = Fit(second, controls);
      EXPECT_EQ(resumed.status, FitStatus::kFinished);
      EXPECT_EQ(resumed.scene.meshes[0].mesh.triangles, straight.scene.meshes[0].mesh.triangles);
      EXPECT_EQ(Bits(resumed.scene), Bits(straight.scene)) << "after round " << round;
      EXPECT_GT(resumed.wall_s, controls.resume->wall_s);
    }
  }

  renderer::Scene start_ = tests::BallScene(1, 4, 24);
  optim::ObservationSet observations_;
  FitSpec spec_ = SmallSpec();
  fs::path folder_;
};

TEST_F(FitTest, ContinuesToTheSameBitsFromEveryRound) {
  RecordingObserver observer;
  const FitResult straight = Fit(observer);
  ASSERT_EQ(straight.rounds, 6);
  ASSERT_EQ(straight.status, FitStatus::kFinished);
  EXPECT_NE(Bits(straight.scene), Bits(start_));
  ExpectSameBitsFromEveryRound(straight);
}

TEST_F(FitTest, ContinuesToTheSameBitsAcrossLevelsOfTheMesh) {
  spec_.unknowns[0].mesh_detail = optim::MeshDetail::kLevels;
  spec_.stages[0].free = {0};
  spec_.stages[0].max_rounds = spec_.stages[1].max_rounds = 2;
  spec_.stages[0].samples.spp = spec_.stages[1].samples.spp = 12;  // the second round decides
  spec_.stages[0].max_spp = spec_.stages[1].max_spp = 12;
  RecordingObserver observer;
  const FitResult straight = Fit(observer);
  EXPECT_GT(straight.scene.meshes[0].mesh.positions.size(),
            2 * start_.meshes[0].mesh.positions.size());
  EXPECT_LT(tests::BumpError(straight.scene), tests::BumpError(start_));
  ExpectSameBitsFromEveryRound(straight);
}

TEST_F(FitTest, EndsWhereTheCostNoLongerFallsThoughEachPixelIsNoise) {
  // A pattern that no light explains, on enough pixels that steps do not follow their noise.
  start_ = tests::BallScene(1, 4, 72);
  renderer::Scene truth = start_;
  tests::Bump(truth);
  observations_ = tests::Photograph(truth, 16);
  const auto edit = [](renderer::Image& photo) {
    for (std::size_t i = 0; i < photo.data.size(); ++i)
      photo.data[i] *= i / 3 % 2 == 0 ? 1.2F : 0.8F;
  };
  tests::EditPhotos(edit, observations_);
  spec_.stages = {spec_.stages[0]};
  spec_.stages[0].image_scale = 1.0;
  spec_.stages[0].coarse_to_fine = false;
  spec_.stages[0].max_rounds = 40;
  spec_.stages[0].samples.spp = spec_.stages[0].max_spp = 2;
  RecordingObserver observer;
  const FitResult result = Fit(observer);
  EXPECT_GT(observer.rounds.back().noise_relative, 0.5);
  EXPECT_GE(result.rounds, optim::kSignsOfEnd) << "each round is a small sign";
  EXPECT_LT(result.rounds, 30);
  EXPECT_EQ(observer.stages.back().stop_reason, "cost no longer falls");
}

TEST_F(FitTest, EndsWhereManyUnknownsHardlyFitTheirOwnSamplesBetter) {
  spec_.linear_solver = optim::LinearSolverChoice::kSparseGram;
  spec_.stages.resize(1);
  optim::StageSpec& stage = spec_.stages[0];
  stage.coarse_to_fine = false;
  stage.max_rounds = 40;
  stage.stop_relative_cost = 0.999;
  RecordingObserver observer;
  EXPECT_EQ(Fit(observer).rounds, 2) << "means of rounds take six";
  EXPECT_EQ(observer.stages.back().stop_reason, "cost no longer falls");
}

TEST_F(FitTest, ContinuesToTheSameBitsAcrossMendedMeshes) {
  spec_.unknowns[0].mesh_detail = optim::MeshDetail::kLevels;
  spec_.stages = {spec_.stages[1]};
  spec_.stages[0].free = {0};
  spec_.stages[0].coarse_to_fine = false;
  start_ = optim::RefineMeshes(start_, spec_.unknowns, {0}, optim::MakeFitViews(observations_, 1.0))
               .scene;
  renderer::Vec3& pulled = start_.meshes[0].mesh.positions.Edit()[7];
  pulled = pulled * 2.0;
  RecordingObserver observer;
  const FitResult straight = Fit(observer);
  EXPECT_NE(straight.scene.meshes[0].mesh.triangles, start_.meshes[0].mesh.triangles);
  // Not the mean over vertices, of which the spike has more now.
  EXPECT_LT(straight.stages.back().cost_after, 0.7 * straight.stages.back().cost_before);
  ExpectSameBitsFromEveryRound(straight);
}

class NeedleTest : public FitTest {
 protected:
  /// A ball with needles: those of one side, which its photo shows, or of the other, and a photo
  /// that no shape explains.
  void PullNeedles(bool seen) {
    start_ = tests::BallScene(1, 2, 64);
    observations_ = tests::Photograph(start_, 16);
    spec_.unknowns[0].mesh_detail = optim::MeshDetail::kLevels;
    spec_.stages = {spec_.stages[1]};
    spec_.stages[0].free = {0};
    spec_.stages[0].max_rounds = 15;
    spec_.stages[0].stop_relative_cost = 0.0;
    start_ =
        optim::RefineMeshes(start_, spec_.unknowns, {0}, optim::MakeFitViews(observations_, 0.5))
            .scene;
    const renderer::Vec3 to_camera = Normalized(renderer::CameraModel(start_.sensors[0]).Origin());
    tests::PullNeedles(start_.meshes[0].mesh, [&](const renderer::Vec3& p) {
      const double depth = Dot(p, to_camera);
      return seen ? depth > 0.0 : depth < -0.7;  // not even behind the outline
    });
    if (seen) {
      observations_ = tests::Photograph(start_, 16);
    } else {
      tests::EditPhotos(
          [](renderer::Image& photo) {
            for (float& value : photo.data) value *= 0.7F;
          },
          observations_);
    }
    ASSERT_GE(renderer::CountNeedles(start_.meshes[0].mesh), optim::kManyNeedles);
  }
  static bool BeganAgain(const RecordingObserver& observer) {
    return std::ranges::any_of(observer.messages, [](const std::string& text) {
      return text.find("the level begins again") != std::string::npos;
    });
  }
};

TEST_F(NeedleTest, OfWhichPhotosShowNothingAreSmoothedAwayInALevelBegunAgain) {
  PullNeedles(false);
  RecordingObserver observer;
  const FitResult straight = Fit(observer);
  EXPECT_TRUE(BeganAgain(observer));
  EXPECT_LT(renderer::CountNeedles(straight.scene.meshes[0].mesh), optim::kManyNeedles);
  ExpectSameBitsFromRounds(4, 7, straight);
}

TEST_F(NeedleTest, ThatPhotosShowStay) {
  PullNeedles(true);
  RecordingObserver observer;
  Fit(observer);
  EXPECT_FALSE(BeganAgain(observer));
}

TEST_F(FitTest, ResumingAFinishedFitReturnsItsScene) {
  RecordingObserver observer;
  FitControls controls;
  controls.checkpoint_folder = folder_;
  const FitResult done = Fit(observer, controls);
  controls.resume = Newest(folder_);
  const FitResult again = Fit(observer, controls);
  EXPECT_EQ(again.rounds, 6);
  EXPECT_EQ(Bits(again.scene), Bits(done.scene));
}

TEST_F(FitTest, RefusesACheckpointOfAnotherExperiment) {
  RecordingObserver observer;
  FitControls controls;
  controls.checkpoint_folder = folder_;
  Fit(observer, controls);
  controls.resume = Newest(folder_);
  spec_.seed = 12;
  EXPECT_THROW(Fit(observer, controls), renderer::IoError);
}

TEST_F(FitTest, RefusesStatesThatNoFitCanHaveWritten) {
  RecordingObserver observer;
  FitControls controls;
  controls.checkpoint_folder = folder_;
  Fit(observer, controls);
  const optim::FitState finished = Newest(folder_).value();
  const auto refuses = [&](const auto& change) {
    controls.resume = finished;
    change(*controls.resume);
    EXPECT_THROW(Fit(observer, controls), renderer::IoError);
  };
  refuses([](optim::FitState& state) { state.stage = -1; });
  refuses([](optim::FitState& state) { state.stage = 3; });
  refuses([](optim::FitState& state) { state.round = -1; });
  refuses([](optim::FitState& state) { state.costs.push_back(1.0); });
  refuses([](optim::FitState& state) { state.damping = std::nan(""); });
  refuses([](optim::FitState& state) { state.step_share = 0.0; });
  refuses([](optim::FitState& state) { state.promised_cost = std::nan(""); });
  refuses([](optim::FitState& state) { state.average.newer.weight = std::nan(""); });
  refuses([](optim::FitState& state) { state.average.newer_start = 2000000000; });
  refuses([](optim::FitState& state) {
    ++state.round;
    state.costs.push_back(1.0);
  });
}

TEST_F(FitTest, ContinuesWithAMeshOfAnotherConnectivity) {
  // What a stage that remeshes between rounds will leave: the scene's ball is finer than the
  // start's, with all else as it was.
  RecordingObserver first;
  first.cancel_after = 4;
  FitControls controls;
  controls.cancel = &first.cancel;
  controls.checkpoint_folder = folder_;
  Fit(first, controls);
  const optim::FitOrigin origin{start_, spec_.unknowns};
  optim::FitState state = optim::ReadNewestCheckpoint(folder_, origin).state.value();
  renderer::Mesh finer = renderer::MakeIcosphere(2, 1.01);
  renderer::SetUniformVertexColors({0.5, 0.4, 0.3}, finer);
  state.scene.meshes[0].mesh = finer;
  ++state.sequence;
  optim::WriteCheckpoint(folder_, origin, state);
  controls.cancel = nullptr;
  controls.resume = optim::ReadNewestCheckpoint(folder_, origin).state;
  EXPECT_EQ(controls.resume->scene.meshes[0].mesh.triangles, finer.triangles);
  EXPECT_EQ(Bits(controls.resume->scene), Bits(state.scene));
  EXPECT_EQ(Bits(controls.resume->stage_start), Bits(state.stage_start));
  RecordingObserver second;
  const FitResult result = Fit(second, controls);
  EXPECT_EQ(result.status, FitStatus::kFinished);
  EXPECT_EQ(result.rounds, 6);
  EXPECT_LE(second.stages.back().cost_after, second.stages.back().cost_before);
  if (second.stages.back().kept == "averaged" || second.stages.back().kept == "last") {
    EXPECT_EQ(result.scene.meshes[0].mesh.triangles, finer.triangles);
    EXPECT_NE(result.scene.meshes[0].mesh.positions, finer.positions);
  }
}

TEST_F(FitTest, NeverEndsWorseThanItStarted) {
  // The start is the truth, and the rounds are noise: whatever they do, the stage must not lose by
  // it. (The prior still pulls a little: the cost is what must not rise.)
  renderer::Scene truth = start_;
  tests::Bump(truth);
  observations_ = tests::Photograph(truth, 256);
  for (optim::StageSpec& stage : spec_.stages) {
    stage.samples.spp = stage.max_spp = 2;
  }
  for (std::uint64_t seed = 0; seed < (tests::kSanitized ? 1 : 5); ++seed) {
    spec_.seed = seed;
    RecordingObserver observer;
    const FitResult result = optim::RunFit(truth, observations_, spec_, observer, {});
    ASSERT_EQ(result.stages.size(), 3U);
    for (const optim::StageReport& stage : result.stages) {
      EXPECT_LE(stage.cost_after, stage.cost_before) << stage.stage << ", kept " << stage.kept;
    }
    // What the prior takes, of 42 to 44 dB, by as many samples at both ends: 1.6 to 2.3.
    EXPECT_GT(result.stages.back().psnr_linear_fit, result.stages.front().psnr_linear_fit - 2.5);
  }
}

TEST_F(FitTest, ReportsEveryRoundAndStage) {
  RecordingObserver observer;
  const FitResult result = Fit(observer);
  ASSERT_EQ(observer.rounds.size(), 6U);
  ASSERT_EQ(observer.stages.size(), 3U);
  EXPECT_EQ(observer.stages[0].stage, "start");
  EXPECT_EQ(observer.num_images, 4U);
  EXPECT_EQ(result.stages[2].stop_reason, "max_rounds");
  const optim::RoundReport& last = observer.rounds.back();
  EXPECT_EQ(last.step, 6);
  EXPECT_EQ(last.stage, "all");
  EXPECT_EQ(last.round, 3);
  EXPECT_EQ(last.samples.spp, 6);
  EXPECT_NEAR(last.cost_total, last.cost_image + last.cost_silhouette + last.cost_priors, 1e-15);
  EXPECT_GT(last.psnr_linear_val, 5.0);
  EXPECT_GT(last.iou_val, 0.5);
  EXPECT_GT(last.noise_relative, 0.0);
  EXPECT_GT(last.jacobian_mb, 0.0);
  EXPECT_GT(last.peak_rss_mb, 1.0);
  EXPECT_EQ(last.linear_solver, "gram");
  ASSERT_EQ(observer.stages[2].views.size(), 4U);
  EXPECT_TRUE(observer.stages[2].views[3].validation);
  for (const optim::RoundReport& round : observer.rounds) {
    EXPECT_TRUE(round.accepted ? round.cost_change_rel < 0.0 : round.cost_change_rel == 0.0)
        << "a step is accepted when the cost falls";
  }
}

TEST_F(FitTest, GoesFromSmallPhotosToLargeOnesAndReportsErrors) {
  spec_.stages.erase(spec_.stages.begin());
  spec_.unknowns[0].kind = ParameterKind::kObjectTranslation;
  spec_.unknowns[0].name = "ball.translation";
  spec_.unknowns[0].laplacian_weight = spec_.unknowns[0].large_steps_lambda = 0.0;
  spec_.stages[0].free = {0};
  spec_.stages[0].max_rounds = 40;
  observations_ = tests::Photograph(start_, 256);
  start_.meshes[0].pose.translation = {0.1, -0.05, 0.0};
  RecordingObserver observer;
  const FitResult result = Fit(observer);
  for (std::size_t i = 1; i < observer.rounds.size(); ++i) {
    EXPECT_GE(observer.rounds[i].image_scale, observer.rounds[i - 1].image_scale);
  }
  EXPECT_EQ(observer.rounds.back().image_scale, 1.0);
  EXPECT_LE(observer.rounds.front().motion, 1.0);
  EXPECT_LT(Norm(result.scene.meshes[0].pose.translation), 0.01);
  const std::vector<double>& errors = result.standard_errors.at("ball.translation");
  ASSERT_EQ(errors.size(), 3U);
  for (const double error : errors) {
    EXPECT_GT(error, 1e-6);
    EXPECT_LT(error, 0.02);
  }
  EXPECT_TRUE(observer.warnings.empty());
}

TEST_F(FitTest, FiguresOfHeldOutViewsAreNotNumbersWithoutThem) {
  for (optim::View& view : observations_.views) view.validation = false;
  spec_.stages.resize(1);
  RecordingObserver observer;
  const FitResult result = Fit(observer);
  EXPECT_TRUE(std::isnan(observer.rounds.back().psnr_linear_val));
  EXPECT_TRUE(std::isnan(observer.rounds.back().iou_val));
  EXPECT_TRUE(std::isnan(result.stages.back().psnr_srgb_val));
  EXPECT_TRUE(std::isnan(result.stages.back().iou_val));
}

TEST_F(FitTest, StopsInTimeWithAUsableScene) {
  spec_.time_limit_s = 1e-6;
  RecordingObserver observer;
  const FitResult result = Fit(observer);
  EXPECT_EQ(result.status, FitStatus::kTimeLimit);
  EXPECT_EQ(result.stages.back().stop_reason, "time limit");
  EXPECT_EQ(result.scene.meshes[0].mesh.positions, start_.meshes[0].mesh.positions);
}

TEST_F(FitTest, RefusesWhatCannotBeFitted) {
  RecordingObserver observer;
  optim::ObservationSet held_out = observations_;
  for (optim::View& view : held_out.views) {
    view.validation = true;
  }
  EXPECT_THROW(optim::RunFit(start_, held_out, spec_, observer, {}), renderer::SceneError);
  renderer::Scene fewer = start_;
  fewer.sensors.pop_back();
  EXPECT_THROW(optim::RunFit(fewer, observations_, spec_, observer, {}), renderer::SceneError);
  spec_.max_memory_bytes = 1000.0;
  EXPECT_THROW(Fit(observer), optim::MemoryError);
  EXPECT_THROW(optim::ForecastStages(start_, observations_, spec_), optim::MemoryError);
  spec_.linear_solver = optim::LinearSolverChoice::kSparseGram;
  RecordingObserver again;
  EXPECT_THROW(Fit(again), optim::MemoryError);
  EXPECT_THROW(optim::ForecastStages(start_, observations_, spec_), optim::MemoryError);
}

TEST_F(FitTest, RefusesByAllThatItsForecastLists) {
  const std::vector<optim::StageMemory> stages =
      optim::ForecastStages(start_, observations_, spec_, optim::ForecastParts::kMemory);
  const std::vector<optim::MemoryItem>& items = stages.back().items;
  // Enough for the solve, which the rounds themselves look at, but not for what is there before;
  // rows of all rounds are given up where memory is scarce.
  const auto rows = std::ranges::find(items, "rows of all rounds", &optim::MemoryItem::what);
  ASSERT_NE(rows, items.end());
  spec_.max_memory_bytes = optim::TotalBytes(items) - rows->bytes - 0.5 * items.front().bytes;
  try {
    optim::ForecastStages(start_, observations_, spec_, optim::ForecastParts::kMemory);
    ADD_FAILURE() << "not refused";
  } catch (const optim::MemoryError& error) {
    EXPECT_NE(std::string(error.what()).find("MB  scene and photos as loaded"), std::string::npos);
  }
}

TEST_F(FitTest, ForecastsSparseNormalEquations) {
  spec_.linear_solver = optim::LinearSolverChoice::kSparseGram;
  const std::vector<optim::StageMemory> stages =
      optim::ForecastStages(start_, observations_, spec_);
  RecordingObserver observer;
  Fit(observer);
  EXPECT_EQ(observer.rounds.back().linear_solver, "sparse_gram");
  const double kept = stages.back().jacobian_bytes / 1e6;
  EXPECT_NEAR(kept, observer.rounds.back().jacobian_mb, 0.2 * kept);
}

TEST_F(FitTest, ForecastsTheRootsOfAllViewsFromAFew) {
  spec_.linear_solver = optim::LinearSolverChoice::kCgnr;
  const std::vector<optim::StageMemory> stages =
      optim::ForecastStages(start_, observations_, spec_);
  ASSERT_EQ(stages.size(), spec_.stages.size());
  RecordingObserver observer;
  Fit(observer);
  for (const optim::StageMemory& stage : stages) {
    EXPECT_EQ(stage.solver, optim::LinearSolverKind::kCgnr);
    EXPECT_GT(optim::TotalBytes(stage.items), stage.items.front().bytes);
  }
  const double kept = stages.back().jacobian_bytes / 1e6;
  EXPECT_NEAR(kept, observer.rounds.back().jacobian_mb, 0.2 * kept);
}

TEST_F(FitTest, ForecastsTimesThatGrowWithWhatIsToBeDone) {
  const std::vector<optim::StageMemory> few = optim::ForecastStages(start_, observations_, spec_);
  for (optim::StageSpec& stage : spec_.stages) {
    stage.max_rounds *= 20;
  }
  const std::vector<optim::StageMemory> many = optim::ForecastStages(start_, observations_, spec_);
  for (std::size_t i = 0; i < few.size(); ++i) {
    EXPECT_GT(few[i].times.first_round_s, 0.0);
    EXPECT_GT(few[i].times.likely_s, few[i].times.first_round_s);
    EXPECT_GE(few[i].times.most_s, few[i].times.likely_s);
    EXPECT_GT(many[i].likely_half_size_s, 0.0);
    EXPECT_LT(many[i].likely_half_size_s, many[i].times.likely_s);
    EXPECT_GT(many[i].times.most_s, 2.0 * few[i].times.most_s);
    EXPECT_GT(many[i].times.most_s, 2.0 * many[i].times.likely_s);
  }
}

}  // namespace
}  // namespace pathfit::fit_test

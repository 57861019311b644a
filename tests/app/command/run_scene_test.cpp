#include "app/command/run_scene.h"

#include <gtest/gtest.h>

namespace pathfit::app::run_scene_test {
namespace {

TEST(ExportedViews, NamePhotosWhereTheyWereRead) {
  ExperimentConfig config;
  config.input.emplace();
  Experiment experiment;
  experiment.input_files = {"/set/transforms.json",
                            "/set/left/a.png",
                            "/set/masks/a.png",
                            "/set/right/a.png",
                            "/set/b.jpg"};
  for (const char* name : {"left/a.png", "right/a.png", "b.jpg"}) {
    experiment.observations.views.emplace_back().name = name;
  }
  experiment.observations.views[1].validation = true;
  const std::vector<ExportedView> views = ExportedViews(experiment, config);
  ASSERT_EQ(views.size(), 3U);
  EXPECT_EQ(views[0].image_path, "/set/left/a.png");
  EXPECT_EQ(views[1].image_path, "/set/right/a.png");
  EXPECT_TRUE(views[1].validation);
  EXPECT_EQ(views[2].image_path, "/set/b.jpg");
}

}  // namespace
}  // namespace pathfit::app::run_scene_test

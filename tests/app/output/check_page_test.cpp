#include "app/output/check_page.h"

#include <gtest/gtest.h>

#include "app/output/report.h"
#include "tests/app/experiment/ball_start.h"
#include "tests/app/output/html_check.h"

namespace pathfit::app::check_page_test {
namespace {

using renderer::Emitter;
using renderer::LightFrame;
using renderer::Vec3;

class CheckPageTest : public BallStart {
 protected:
  [[nodiscard]] Json Page() const {
    const Json summary = {{"stages", Json::array()}};
    return CheckJson(config_, experiment_, CheckStart(config_, experiment_), summary);
  }
};

TEST_F(CheckPageTest, DrawsAxesWhereTheObjectIs) {
  const Json page = Page();
  ASSERT_EQ(page["views"].size(), 5U);
  for (const Json& view : page["views"]) {
    ASSERT_EQ(view["axes"].size(), 3U);
    const double width = view["size"][0], height = view["size"][1];
    for (const Json& axis : view["axes"]) {
      EXPECT_EQ(axis[0], view["axes"][0][0]) << "all from the middle";
      EXPECT_NEAR(axis[0][0], 0.5 * width, 0.2 * width);
      EXPECT_NEAR(axis[0][1], 0.5 * height, 0.2 * height);
    }
    EXPECT_TRUE(view["outline"].get<std::string>().starts_with("M"));
    EXPECT_TRUE(
        view["pictures"]["photo"].get<std::string>().starts_with("data:image/jpeg;base64,"));
  }
  EXPECT_EQ(page["model"]["result"]["meshes"].size(), experiment_.scene.meshes.size());
}

TEST_F(CheckPageTest, PointsToLightsOfWorldAndCamera) {
  auto& scene = experiment_.scene;
  const Vec3 of_first = renderer::CameraPose(scene.sensors[0]).translation;
  scene.emitters = {
      Emitter{"lamp", LightFrame::kWorld, {}, renderer::PointEmitter{.position = of_first}},
      Emitter{"flash", LightFrame::kCamera, {}, renderer::PointEmitter{.position = {0.1, 0, -1}}},
      Emitter{
          "sun", LightFrame::kCamera, {}, renderer::DirectionalEmitter{.direction = {-1, 0, 0}}}};
  scene.sensors[1].lights_off = {1};
  const Json page = Page();
  const Json& lights = page["views"][0]["lights"];
  ASSERT_EQ(lights.size(), 3U);
  EXPECT_TRUE(lights[0]["at"].is_null()) << "at the camera itself";
  EXPECT_FALSE(lights[1]["at"].is_null());
  // Towards the sun is to the right in every picture.
  for (const Json& view : page["views"]) {
    const Json& arrow = view["lights"].back()["arrow"];
    EXPECT_GT(arrow[1][0].get<double>(), arrow[0][0].get<double>());
    EXPECT_NEAR(arrow[1][1].get<double>(), arrow[0][1].get<double>(), 1.0);
  }
  EXPECT_EQ(page["views"][1]["lights"].size(), 2U) << "the flash is off";
  EXPECT_EQ(page["lights"][1]["photos"], 4);
  EXPECT_EQ(page["lights"][2]["place"], "from the direction [1, 0, 0]");
  EXPECT_EQ(page["lights"][2]["frame"], "camera");
}

TEST_F(CheckPageTest, IsAPage) {
  config_.name = "</script><b>";
  EXPECT_EQ(HtmlFault(ReportPage(Page())), "");
}

}  // namespace
}  // namespace pathfit::app::check_page_test

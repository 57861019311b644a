#include "optim/observation/located_point.h"

#include <cmath>

#include <gtest/gtest.h>

#include "renderer/core/error.h"

namespace pathfit::optim::located_point_test {
namespace {

using renderer::Vec3;

/// Photos of 600 x 400 pixels, kept at a third, from around the origin through a lens.
std::vector<View> ViewsAround(const std::vector<double>& degrees) {
  std::vector<View> views;
  for (const double angle : degrees) {
    View& view = views.emplace_back();
    view.name = "at" + std::to_string(static_cast<int>(angle)) + ".jpg";
    view.file_width = 600;
    view.file_height = 400;
    renderer::Camera camera;
    camera.width = 600;
    camera.height = 400;
    camera.fx = camera.fy = 700.0;
    camera.cx = 310.0;
    camera.cy = 190.0;
    camera.distortion = {.k1 = -0.1, .k2 = 0.02, .p1 = 1e-3};
    const double radians = angle * std::acos(-1.0) / 180.0;
    camera.world_from_camera = renderer::LookAt(
        {5.0 * std::sin(radians), 1.0, 5.0 * std::cos(radians)}, {0.0, 0.0, 0.0}, {0.0, 1.0, 0.0});
    view.camera = renderer::ScaledCamera(camera, 200, 133);
  }
  return views;
}

std::vector<PickedPoint> PicksOf(const std::vector<View>& views, const Vec3& point) {
  std::vector<PickedPoint> picks;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto seen = renderer::CameraModel(views[i].camera).Project(point);
    picks.push_back({i, seen->u * 600.0 / 200.0, seen->v * 400.0 / 133.0});
  }
  return picks;
}

std::string ErrorOf(const std::vector<View>& views, const std::vector<PickedPoint>& picks) {
  try {
    LocatePoint(views, picks);
  } catch (const renderer::SceneError& error) {
    return error.what();
  }
  return "none";
}

TEST(LocatedPoint, IsWhereExactPicksMeet) {
  const Vec3 point{0.7, -0.4, 0.3};
  for (const std::vector<double>& angles : {std::vector<double>{0.0, 40.0}, {0.0, 30.0, 70.0}}) {
    const std::vector<View> views = ViewsAround(angles);
    const LocatedPoint located = LocatePoint(views, PicksOf(views, point));
    EXPECT_LT(Norm(located.position - point), 1e-8);
    ASSERT_EQ(located.off_px.size(), angles.size());
    for (const double off : located.off_px) EXPECT_LT(off, 1e-6);
  }
}

TEST(LocatedPoint, IsNearestInPixelsOfTheFiles) {
  const std::vector<View> views = ViewsAround({0.0, 35.0, 80.0});
  std::vector<PickedPoint> picks = PicksOf(views, {0.1, 0.2, -0.3});
  picks[0].y += 2.0;
  picks[1].x -= 1.0;
  const LocatedPoint located = LocatePoint(views, picks);
  const auto cost = [&](const Vec3& point) {
    double sum = 0.0;
    for (const PickedPoint& pick : picks) {
      const auto seen = renderer::CameraModel(views[pick.view].camera).Project(point);
      sum += std::pow(seen->u * 3.0 - pick.x, 2) + std::pow(seen->v * 400.0 / 133.0 - pick.y, 2);
    }
    return sum;
  };
  double off = 0.0;
  for (const double px : located.off_px) off += px * px;
  EXPECT_NEAR(off, cost(located.position), 1e-9);
  EXPECT_GT(off, 0.5);
  constexpr double kStep = 1e-3;
  for (const Vec3& step : {Vec3{kStep, 0, 0}, Vec3{0, kStep, 0}, Vec3{0, 0, kStep}}) {
    EXPECT_GT(cost(located.position + step), off);
    EXPECT_GT(cost(located.position - step), off);
  }
}

TEST(LocatedPoint, RefusesRaysThatAreNearlyParallel) {
  const std::vector<View> views = ViewsAround({0.0, 1.5});
  const std::string error = ErrorOf(views, PicksOf(views, {0.0, 0.0, 0.0}));
  EXPECT_NE(error.find("1.471 degrees apart"), std::string::npos) << error;
}

TEST(LocatedPoint, RefusesPicksOfDifferentMarks) {
  const std::vector<View> views = ViewsAround({0.0, 40.0});
  std::vector<PickedPoint> picks = PicksOf(views, {0.3, 0.2, 0.1});
  picks[1].y += 5.0;  // half of it is left in each photo
  EXPECT_EQ(ErrorOf(views, picks), "none");
  picks[1].y += 40.0;
  const std::string error = ErrorOf(views, picks);
  EXPECT_NE(error.find("do not belong together"), std::string::npos) << error;
  EXPECT_NE(error.find("(at most 6)"), std::string::npos) << error;
}

TEST(LocatedPoint, RefusesRaysThatMeetBehindACamera) {
  const std::vector<View> views = ViewsAround({0.0, 20.0});
  std::vector<PickedPoint> picks = PicksOf(views, {0.0, 0.0, 0.0});
  picks[0].x = 50.0;
  picks[1].x = 590.0;
  const std::string error = ErrorOf(views, picks);
  EXPECT_NE(error.find("does not see"), std::string::npos) << error;
}

}  // namespace
}  // namespace pathfit::optim::located_point_test

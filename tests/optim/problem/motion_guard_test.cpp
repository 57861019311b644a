#include "optim/problem/motion_guard.h"

#include <gtest/gtest.h>

#include "tests/support/test_scenes.h"

namespace pathfit::motion_guard_test {
namespace {

using renderer::ParameterKind;

class MotionGuardTest : public testing::Test {
 protected:
  MotionGuardTest() {
    scene_.sensors.resize(2, scene_.sensors.front());
    optim::ObservationSet observations;
    for (int i = 0; i < 2; ++i) {
      optim::View view;
      view.camera = scene_.sensors.front();
      view.photo = renderer::Image(view.camera.width, view.camera.height, 3);
      view.validation = i == 1;
      observations.views.push_back(view);
    }
    views_ = optim::MakeFitViews(observations, 1.0);
  }

  [[nodiscard]] optim::ParameterSet SetOf(ParameterKind kind, int object) const {
    optim::UnknownSpec unknown;
    unknown.kind = kind;
    unknown.object = object;
    return {scene_, {unknown}, {0}, {0, 1}, {}};
  }

  /// Motion by adding `step` to the first scalar.
  [[nodiscard]] double Motion(const optim::ParameterSet& set, double step) const {
    std::vector<double> values = set.layout().Gather(scene_);
    const optim::MotionGuard guard(scene_, set, views_, values);
    values[0] += step;
    EXPECT_EQ(guard.Admits(values), guard.LargestMotion(values) <= optim::MotionGuard::kMaxPixels);
    return guard.LargestMotion(values);
  }

  renderer::Scene scene_ = tests::BallAndWall();
  optim::FitViews views_;
};

TEST_F(MotionGuardTest, MeasuresMotionInTheFittedImagesInPixels) {
  const optim::ParameterSet moved = SetOf(ParameterKind::kObjectTranslation, 0);
  EXPECT_EQ(Motion(moved, 0.0), 0.0);
  const double small = Motion(moved, 0.001);
  EXPECT_GT(small, 0.0);
  EXPECT_NEAR(Motion(moved, 0.002), 2.0 * small, 0.02 * small) << "linear where it is small";
  EXPECT_GT(Motion(moved, 1e6), optim::MotionGuard::kMaxPixels);
  // About f / depth pixels per metre, if across the view.
  const renderer::CameraModel camera(scene_.sensors.front());
  const renderer::Vec3 middle{};
  const auto at = camera.Project(middle);
  ASSERT_TRUE(at.has_value());
  EXPECT_NEAR(small / 0.001, std::hypot(at->du.x, at->dv.x), 0.5 * small / 0.001);
}

TEST_F(MotionGuardTest, SeesCamerasThatMoveButNoColours) {
  EXPECT_GT(Motion(SetOf(ParameterKind::kCameraPosition, 0), 0.01), 0.0);
  EXPECT_EQ(Motion(SetOf(ParameterKind::kCameraPosition, 1), 0.01), 0.0) << "held out";
  EXPECT_EQ(Motion(SetOf(ParameterKind::kLightIntensity, 0), 0.1), 0.0);
}

}  // namespace
}  // namespace pathfit::motion_guard_test

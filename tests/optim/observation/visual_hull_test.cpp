#include "optim/observation/visual_hull.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "optim/observation/load_observations.h"
#include "optim/observation/silhouette_field.h"
#include "optim/observation/voxel_surface.h"
#include "renderer/core/error.h"
#include "renderer/geometry/mesh_topology.h"
#include "renderer/io/image_file.h"
#include "tests/optim/observation/ball_views.h"
#include "tests/optim/observation/observation_files.h"

namespace pathfit::optim::visual_hull_test {
namespace {

using renderer::Camera;
using renderer::CameraModel;
using renderer::Image;
using renderer::Mesh;
using renderer::Vec3;

std::string MessageOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const renderer::SceneError& error) {
    return error.what();
  }
  return "(no error)";
}

void ExpectMessage(const ObservationSet& set,
                   const VisualHullOptions& options,
                   const std::string& part) {
  const std::string message = MessageOf([&] { CarveVisualHull(set, options); });
  EXPECT_NE(message.find(part), std::string::npos) << message;
}

void ExpectHullOfTheBall(const Mesh& mesh) {
  ASSERT_NO_THROW(ValidateMesh(mesh, "hull"));
  const renderer::MeshTopology topology = renderer::MeshTopology::Build(mesh);
  EXPECT_TRUE(topology.closed);
  EXPECT_EQ(static_cast<long>(mesh.positions.size() + mesh.triangles.size()),
            static_cast<long>(topology.edges.size()) + 2);
  // Twelve cones of half angle asin(1/6) about the ball: nowhere inside it, nowhere far outside.
  constexpr double kPixel = 3.0 / 180.0;
  const auto [nearest, farthest] = std::minmax_element(
      mesh.positions.begin(), mesh.positions.end(), [](const Vec3& a, const Vec3& b) {
        return Norm(a - kCenter) < Norm(b - kCenter);
      });
  EXPECT_GT(Norm(*nearest - kCenter), kRadius - 0.7 * kPixel);
  EXPECT_LT(Norm(*farthest - kCenter), 1.25 * kRadius);
  const double ball = 4.0 / 3.0 * std::numbers::pi * kRadius * kRadius * kRadius;
  EXPECT_GT(SignedVolume(mesh), 0.98 * ball);  // flat triangles cut corners at 16 voxels
  EXPECT_LT(SignedVolume(mesh), 1.2 * ball);
}

TEST(SilhouetteField, IsZeroWhereTheConeTouchesTheBall) {
  const ObservationSet set = BallFromAllSides();
  const SilhouetteField field(set);
  EXPECT_NEAR(Norm(field.Center() - kCenter), 0.0, 8e-3);  // half a pixel
  EXPECT_GT(field.Radius(kCenter), kRadius);
  EXPECT_LT(field.Radius(kCenter), 1.6 * kRadius);
  // On the circle of contact of the first camera.
  const Vec3 axis = Normalized(set.views[0].camera.world_from_camera.translation - kCenter);
  const Vec3 across = Normalized(Cross(axis, {0.3, 0.5, 0.8}));
  const double sine = kRadius / 3.0;
  const Vec3 contact = kCenter + (axis * sine + across * std::sqrt(1.0 - sine * sine)) * kRadius;
  EXPECT_NEAR(field.ValueAndGradient(contact).value, 0.0, 0.01);  // 0.6 pixels
  EXPECT_NEAR(field.ValueAndGradient(kCenter).value, kRadius, 0.03);
  EXPECT_LT(field.Value(kCenter + Vec3{100.0, 0.0, 0.0}, -1e9), -1.0);
}

TEST(SilhouetteField, GradientIsThatOfTheValue) {
  const SilhouetteField field(BallFromAllSides());
  for (const Vec3& x : {kCenter + Vec3{0.31, 0.12, 0.42}, kCenter + Vec3{-0.52, 0.21, -0.1}}) {
    const SilhouetteField::Sample sample = field.ValueAndGradient(x);
    EXPECT_EQ(sample.value, field.Value(x, -1e9));
    for (int a = 0; a < 3; ++a) {
      Vec3 step;
      step[a] = 1e-6;
      const double slope = (field.Value(x + step, -1e9) - field.Value(x - step, -1e9)) / 2e-6;
      EXPECT_NEAR(sample.gradient[a], slope, 1e-6);
    }
  }
}

TEST(CarveVisualHull, EnclosesTheBallTightly) {
  const ObservationSet set = BallFromAllSides();
  for (const int resolution : {16, 40, 64}) {
    SCOPED_TRACE(resolution);
    ExpectHullOfTheBall(CarveVisualHull(set, {.resolution = resolution}));
  }
}

TEST(CarveVisualHull, HasCellsAsWideAsAPixelUnlessTold) {
  // The box is 2.2 radii wide, seen with 180 pixels per unit from three units away.
  const ObservationSet set = BallFromAllSides();
  const std::size_t found = CarveVisualHull(set, {}).positions.size();
  const double pixels = 2.2 * kRadius * 60.0;
  const auto of = [&](double resolution) {
    return CarveVisualHull(set, {.resolution = static_cast<int>(resolution)}).positions.size();
  };
  EXPECT_GT(found, of(0.9 * pixels));
  EXPECT_LT(found, of(1.1 * pixels));
}

TEST(CarveVisualHull, OneMaskThatMissesAPartCarvesNothingWhereItMayDissent) {
  ObservationSet set = BallFromAllSides();
  View& view = set.views[4];
  Image half = view.mask.Unpack();
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize / 2; ++x) half.At(x, y, 0) = 0.0F;
  }
  view.mask = half;
  const double ball = 4.0 / 3.0 * std::numbers::pi * kRadius * kRadius * kRadius;
  EXPECT_LT(SignedVolume(CarveVisualHull(set, {.resolution = 32})), 0.7 * ball);
  const Mesh hull = CarveVisualHull(set, {.resolution = 32, .dissent = 0.1});  // 1 of 12
  EXPECT_GT(SignedVolume(hull), 0.98 * ball);
  EXPECT_LT(SignedVolume(hull), 1.5 * ball) << "each point is still bounded by eleven cones";
  ExpectMessage(set, {.dissent = 0.5}, "may dissent is 0.5");
}

TEST(CarveVisualHull, BordersOfPhotosCarveNothingOffWhatTheyCut) {
  ObservationSet set = BallFromAllSides();
  for (const std::size_t i : {2U, 7U}) {
    View& view = set.views[i];
    view.camera.cx -= 0.45 * kSize;
    view.mask = BallMask(view.camera, kCenter, kRadius);
    EXPECT_EQ(view.mask.Unpack().At(0, kSize / 2, 0), 1.0F);
  }
  ExpectHullOfTheBall(CarveVisualHull(set, {.resolution = 40}));
}

TEST(CarveVisualHull, IsTheSameEachTime) {
  const ObservationSet set = BallFromAllSides();
  const Mesh a = CarveVisualHull(set, {.resolution = 32});
  const Mesh b = CarveVisualHull(set, {.resolution = 32});
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.triangles, b.triangles);
}

TEST(CarveVisualHull, IgnoresValidationViews) {
  ObservationSet set = BallFromAllSides();
  set.views[3].mask = ConstantImage(kSize, kSize, 1, 0.0F);
  ExpectMessage(set, {.resolution = 32}, "view4 is black everywhere");
  set.views[3].validation = true;
  ExpectHullOfTheBall(CarveVisualHull(set, {.resolution = 32}));
}

/// With a second ball beside the first.
void AddBall(const Vec3& center, double radius, ObservationSet& set) {
  for (View& view : set.views) {
    const Image second = BallMask(view.camera, center, radius);
    Image both = view.mask.Unpack();
    std::ranges::transform(
        second.data, both.data, both.data.begin(), [](float a, float b) { return std::max(a, b); });
    view.mask = both;
  }
}

TEST(CarveVisualHull, LeavesSpecksAway) {
  ObservationSet set = BallFromAllSides();
  AddBall(kCenter + Vec3{0.0, 0.62, 0.0}, 0.05, set);
  ExpectHullOfTheBall(CarveVisualHull(set, {.resolution = 48}));
}

TEST(CarveVisualHull, KeepsEveryBodyThatMasksShow) {
  ObservationSet set = BallFromAllSides();
  AddBall(kCenter + Vec3{0.0, 0.7, 0.0}, 0.15, set);
  const MeshParts parts = PartsByVolume(CarveVisualHull(set, {.resolution = 64}));
  ASSERT_EQ(parts.volumes.size(), 2U);
  EXPECT_NEAR(std::cbrt(parts.volumes[0] / parts.volumes[1]), kRadius / 0.15, 0.3);
}

TEST(CarveVisualHull, LeavesAwayWhatNoMaskIsOf) {
  // Of two balls, by two cameras: their cones meet in four places, and either pair of them explains
  // all masks.
  ObservationSet set;
  set.mask_meaning = MaskMeaning::kSilhouette;
  for (const Vec3& direction : {Vec3{1, 0, 0}, Vec3{0, 0, 1}}) {
    set.views.push_back(BallView(direction));
    set.views.back().name = "view" + std::to_string(set.views.size());
  }
  AddBall(kCenter + Vec3{0.7, 0.0, 0.7}, 0.15, set);
  EXPECT_EQ(PartsByVolume(CarveVisualHull(set, {.resolution = 64})).volumes.size(), 2U);
}

TEST(CarveVisualHull, IsAsGoodFarFromTheOrigin) {
  ObservationSet set = BallFromAllSides();
  const double volume = SignedVolume(CarveVisualHull(set, {.resolution = 32}));
  for (View& view : set.views) {
    view.camera.world_from_camera.translation += Vec3{4e5, 200.0, 5.8e6};
  }
  Mesh hull = CarveVisualHull(set, {.resolution = 32});
  std::vector<Vec3> positions = hull.positions;
  for (Vec3& p : positions) p -= Vec3{4e5, 200.0, 5.8e6};
  hull.positions = positions;
  EXPECT_NEAR(SignedVolume(hull), volume, 1e-3 * volume);
}

TEST(CarveVisualHull, WorksFromFiles) {
  const TempFolder folder;
  const ObservationSet ball = BallFromAllSides();
  std::string frames;
  for (std::size_t i = 0; i < ball.views.size(); ++i) {
    const View& view = ball.views[i];
    const std::string name = "v" + std::to_string(10 + i) + ".png";
    renderer::WritePng8(folder.WriteText(name, ""), view.photo.Unpack());
    renderer::WritePng8(folder.WriteText("masks/" + name, ""), view.mask.Unpack());
    const renderer::Transform& t = view.camera.world_from_camera;
    frames += std::string(i == 0 ? "" : ",") + "{\"file_path\": \"" + name +
              "\", \"transform_matrix\": [";
    for (int r = 0; r < 3; ++r) {
      char row[160];
      std::snprintf(row,
                    sizeof row,
                    "[%.17g, %.17g, %.17g, %.17g], ",
                    t.linear.x[r],
                    t.linear.y[r],
                    t.linear.z[r],
                    t.translation[r]);
      frames += row;
    }
    frames += "[0, 0, 0, 1]]}";
  }
  ObservationOptions options;
  options.cameras =
      folder.WriteText("transforms.json",
                       "{\"fl_x\": 180, \"cx\": 51, \"cy\": 46, \"k1\": 0.1, \"w\": 96, \"h\": 96, "
                       "\"frames\": [" +
                           frames + "]}");
  options.masks.meaning = MaskMeaning::kSilhouette;
  options.masks.folder = folder.path() / "masks";
  options.validation_every = 0;
  ExpectHullOfTheBall(CarveVisualHull(LoadObservations(options), {.resolution = 32}));
}

TEST(CarveVisualHull, SaysWhatIsMissing) {
  const ObservationSet ball = BallFromAllSides();
  ObservationSet set = ball;
  ExpectMessage(set, {.resolution = 15}, "the resolution is 15 (allowed: 16 to 512)");
  ExpectMessage(set, {.resolution = 513}, "513");
  set.mask_meaning = MaskMeaning::kIgnore;
  ExpectMessage(set, {}, "meaning 'silhouette'");
  set = ball;
  for (View& view : set.views) {
    view.mask = Image();
  }
  ExpectMessage(set, {}, "0 fitted photos have a silhouette mask");
  set.views = {ball.views[0]};
  ExpectMessage(set, {}, "1 fitted photos");
  set.views = {ball.views[0], ball.views[0]};
  ExpectMessage(set, {}, "nearly the same direction");
}

TEST(CarveVisualHull, RefusesViewsThatDoNotBoundTheObject) {
  ObservationSet set;
  set.mask_meaning = MaskMeaning::kSilhouette;
  set.views = {BallView({0.0, 0.0, 1.0}), BallView({0.08, 0.0, 1.0})};
  ExpectMessage(set, {.resolution = 32}, "do not bound the object");
}

TEST(CarveVisualHull, RefusesMasksThatContradictEachOther) {
  ObservationSet set;
  set.mask_meaning = MaskMeaning::kSilhouette;
  for (const Vec3& direction :
       {Vec3{0.0, 0.0, 1.0}, Vec3{1.0, 0.0, 0.0}, Vec3{0.0, 1.0, 0.1}, Vec3{-1.0, 0.1, 0.5}}) {
    set.views.push_back(BallView(direction));
  }
  set.views[0].mask = BallMask(set.views[0].camera, kCenter + Vec3{0.6, 0.0, 0.0}, 0.1);
  set.views[3].mask = BallMask(set.views[3].camera, kCenter + Vec3{0.0, 0.6, 0.0}, 0.1);
  ExpectMessage(set, {.resolution = 32}, "nothing is left");
}

}  // namespace
}  // namespace pathfit::optim::visual_hull_test

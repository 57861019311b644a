#include "app/experiment/draft_config.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <utility>

#include <gtest/gtest.h>

#include "app/experiment/experiment.h"
#include "app/experiment/start_check.h"
#include "app/output/export_cameras.h"
#include "app/output/fields.h"
#include "app/output/report_images.h"
#include "optim/observation/camera_import.h"
#include "renderer/core/error.h"
#include "renderer/image/color.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/exr_file.h"
#include "renderer/io/image_file.h"
#include "renderer/io/raw_file.h"
#include "tests/optim/observation/exif_bytes.h"
#include "tests/optim/observation/observation_files.h"
#include "tests/optim/round/synthetic_fit.h"
#include "tests/renderer/io/dng_bytes.h"

namespace pathfit::app::draft_config_test {
namespace {

namespace fs = std::filesystem;
using renderer::Image;

constexpr int kViews = 6;

/// Photos of a ball and their cameras in a folder.
class DraftConfigTest : public ::testing::Test {
 protected:
  enum class Cameras { kTransforms, kColmap };

  void WriteSet(const fs::path& set, Cameras kind) {
    renderer::Scene scene = tests::BallScene(2, kViews, 48);
    for (std::size_t i = 0; i < kViews; ++i) {
      const std::string name = "view" + std::to_string(i) + ".png";
      names_.push_back(name);
      paths_.push_back("images/" + name);
    }
    views_ = tests::Photograph(scene, 4).views;
    fs::create_directories(set / "images");
    for (std::size_t i = 0; i < kViews; ++i) {
      renderer::WritePng8(set / paths_[i], EncodedImage(views_[i].photo.Unpack()));
    }
    if (kind == Cameras::kColmap) {
      fs::create_directories(set / "sparse/0");
      WriteCameras(set / "sparse/0", scene.sensors, names_, paths_);
      fs::remove(set / "sparse/0/transforms.json");
    } else {
      std::ofstream(set / "transforms.json") << TransformsJson(scene.sensors, paths_);
    }
  }
  void WriteMasks(const fs::path& folder, bool inverted, std::size_t count = kViews) const {
    fs::create_directories(folder);
    for (std::size_t i = 0; i < count; ++i) {
      Image mask = views_[i].mask.Unpack();
      for (float& v : mask.data) v = inverted ? 1.0F - v : v;
      renderer::WritePng8(folder / (names_[i] + ".png"), mask);
    }
  }
  /// The experiment of the draft for this input.
  [[nodiscard]] Experiment Built(const FoundInput& input,
                                 DraftLight light = DraftLight::kWorld) const {
    const fs::path path = top() / "draft.yaml";
    std::ofstream(path) << DraftConfig(input, LightAsSaid(light), path, "ball", {});
    return BuildExperiment(LoadExperimentConfig(path, {}));
  }
  [[nodiscard]] static std::string Refusal(const InputPlaces& places) {
    try {
      static_cast<void>(FindInput(places));
    } catch (const renderer::IoError& error) {
      return error.what();
    }
    return "";
  }

  [[nodiscard]] const fs::path& top() const { return folder_.path(); }

  optim::TempFolder folder_;
  std::vector<std::string> names_, paths_;
  std::vector<optim::View> views_;
};

bool Says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(DraftConfigTest, FindsPhotosCamerasAndMasks) {
  WriteSet(top(), Cameras::kTransforms);
  WriteMasks(top() / "masks", false);
  const FoundInput input = FindInput({.photos = top()});
  EXPECT_EQ(input.options.images_dir, top() / "images");
  EXPECT_EQ(input.options.masks.folder, top() / "masks");
  EXPECT_EQ(input.options.masks.require, optim::MaskRequirement::kAll);
  EXPECT_FALSE(input.options.masks.invert);
  EXPECT_EQ(input.num_masks, std::size_t{kViews});
  EXPECT_EQ(input.num_without_camera, 0U);
  ASSERT_TRUE(input.layout);
  EXPECT_LT(Norm(input.layout->centre), 1e-9);

  const Experiment experiment = Built(input);
  EXPECT_EQ(experiment.observations.views.size(), std::size_t{kViews});
  EXPECT_EQ(experiment.fit.stages.size(), 2U);
  EXPECT_EQ(experiment.fit.unknowns.size(), 4U);
  const StartCheck start = CheckStart(LoadExperimentConfig(top() / "draft.yaml", {}), experiment);
  EXPECT_TRUE(start.warnings.empty()) << start.warnings.front();
  for (const ViewStart& view : start.views) EXPECT_GT(view.iou, 0.85) << "a hull";
}

TEST_F(DraftConfigTest, FewPhotosAreAllFitted) {
  WriteSet(top(), Cameras::kTransforms);
  WriteMasks(top() / "masks", false);
  EXPECT_FALSE(Says(DraftConfig(FindInput({.photos = top()}),
                                LightAsSaid(DraftLight::kWorld),
                                top() / "draft.yaml",
                                "ball",
                                {}),
                    "validation"));
  Json cameras = Json::parse(renderer::ReadWholeFile(top() / "transforms.json"));
  Json& frames = cameras["frames"];
  frames.erase(frames.begin() + 4, frames.end());
  std::ofstream(top() / "transforms.json") << cameras;
  const Experiment experiment = Built(FindInput({.photos = top()}));
  EXPECT_EQ(experiment.observations.views.size(), 4U);
  EXPECT_TRUE(std::ranges::none_of(experiment.observations.views, &optim::View::validation));
}

TEST_F(DraftConfigTest, NamesTheLensWhichMayChangeToo) {
  WriteSet(top(), Cameras::kTransforms);
  const fs::path path = top() / "draft.yaml";
  std::string text = DraftConfig(FindInput({.photos = top()}), UsualLight({}), path, "ball", {});
  for (std::size_t at = 0; (at = text.find("# camera.", at)) != std::string::npos;) {
    text.erase(at, 2);
  }
  std::ofstream(path) << text;
  const optim::FitSpec fit = BuildExperiment(LoadExperimentConfig(path, {})).fit;
  ASSERT_EQ(fit.unknowns.size(), 7U);
  for (std::size_t i = 4; i < 7; ++i) {
    EXPECT_EQ(fit.unknowns[i].sharing, std::vector<int>(kViews, 0)) << fit.unknowns[i].name;
  }
  EXPECT_EQ(fit.stages.back().free.size(), 7U);
}

TEST_F(DraftConfigTest, FindsCamerasAbovePhotosAndStartsFromASphereWithoutMasks) {
  WriteSet(top() / "a set, it's odd", Cameras::kColmap);
  std::ofstream(top() / "a set, it's odd/images/extra.jpg") << "no camera";
  const FoundInput input = FindInput({.photos = top() / "a set, it's odd/images"});
  EXPECT_EQ(input.options.masks.meaning, optim::MaskMeaning::kNone);
  EXPECT_EQ(input.num_without_camera, 1U);
  const Experiment experiment = Built(input);
  EXPECT_TRUE(experiment.scene.environment_visible);
  ASSERT_EQ(experiment.scene.meshes.size(), 1U);
  const renderer::Mesh mesh = renderer::WorldMesh(experiment.scene.meshes[0]);
  for (const renderer::Vec3& p : mesh.positions) {
    EXPECT_NEAR(Norm(p), 0.5 * input.layout->radius, 1e-3);
  }
}

TEST_F(DraftConfigTest, MakesMasksOfWhatTheCamerasLookAt) {
  WriteSet(top(), Cameras::kTransforms);
  FoundInput input = FindInput({.photos = top()});
  FoundInput one_side = input;
  one_side.observations.views.resize(1);
  EXPECT_FALSE(MakeMasks(top() / "none", one_side)) << "bounds no body";
  EXPECT_FALSE(fs::exists(top() / "none"));

  ASSERT_TRUE(MakeMasks(top() / "made", input));
  ASSERT_TRUE(input.mask_agreement);
  EXPECT_GT(*input.mask_agreement, 0.8);
  EXPECT_EQ(input.num_masks, std::size_t{kViews});
  for (std::size_t i = 0; i < kViews; ++i) {
    const Image made = input.observations.views[i].mask.Unpack();
    EXPECT_GT(optim::MaskIou(made, views_[i].mask.Unpack()), 0.9) << names_[i];
  }
  const std::string draft = DraftConfig(input, UsualLight({}), top() / "draft.yaml", "ball", {});
  EXPECT_TRUE(Says(draft, "masks: {path: made, meaning: silhouette}")) << draft;
  EXPECT_TRUE(Says(draft, "visual_hull: {dissent: 0.1}")) << draft;
  EXPECT_EQ(Built(input).scene.meshes.size(), 1U);
}

TEST_F(DraftConfigTest, StartsFromTheSparsePointsOfTheCameras) {
  WriteSet(top(), Cameras::kColmap);
  FoundInput none = FindInput({.photos = top()});
  EXPECT_FALSE(MakeStart(top() / "start.ply", top() / "region", none)) << "there are no points";
  const fs::path model = top() / "sparse/0";
  std::ofstream points(model / "points3D.txt");
  int id = 0;
  const renderer::Scene ball = tests::BallScene(4, kViews, 48);
  for (const renderer::Vec3& p : ball.meshes[0].mesh.positions) {
    points << ++id << ' ' << p.x << ' ' << p.y << ' ' << p.z << " 0 0 0 0.1\n";
  }
  points.close();
  FoundInput input = FindInput({.photos = top()});
  EXPECT_EQ(input.points, model / "points3D.txt");
  ASSERT_TRUE(MakeStart(top() / "start.ply", top() / "region", input));
  EXPECT_EQ(input.num_masks, std::size_t{kViews});
  for (std::size_t i = 0; i < kViews; ++i) {
    const Image region = input.observations.views[i].mask.Unpack();
    const Image object = views_[i].mask.Unpack();
    double seen = 0.0, all = 0.0;
    for (std::size_t p = 0; p < object.data.size(); ++p) {
      seen += static_cast<double>(object.data[p] * region.data[p]);
      all += static_cast<double>(object.data[p]);
    }
    EXPECT_GT(seen, 0.95 * all) << names_[i];
    EXPECT_GT(optim::MaskIou(region, object), 0.6) << "few photos bound it loosely";
  }
  const std::string draft =
      DraftConfig(input, UsualLight({}), top() / "draft.yaml", "ball", top() / "start.ply");
  EXPECT_TRUE(Says(draft, "masks: {path: region, meaning: ignore}")) << draft;
  EXPECT_TRUE(Says(draft, "object: {file: start.ply, material: surface}")) << draft;
  std::ofstream(top() / "draft.yaml") << draft;
  const ExperimentConfig config = LoadExperimentConfig(top() / "draft.yaml", {});
  const Experiment experiment = BuildExperiment(config);
  EXPECT_EQ(experiment.observations.mask_meaning, optim::MaskMeaning::kIgnore);
  EXPECT_TRUE(CheckStart(config, experiment).warnings.empty());
}

TEST_F(DraftConfigTest, MasksThatWereMadeAreKnownAgain) {
  WriteSet(top(), Cameras::kTransforms);
  FoundInput input = FindInput({.photos = top()});
  ASSERT_TRUE(MakeMasks(top() / "ball_masks", input));
  const FoundInput again = FindInput({.photos = top()});
  EXPECT_EQ(again.num_masks, std::size_t{kViews});
  ASSERT_TRUE(again.mask_agreement);
  EXPECT_NEAR(*again.mask_agreement, *input.mask_agreement, 1e-3);
  const auto draft = [&](const FoundInput& found) {
    return DraftConfig(found, UsualLight({}), top() / "draft.yaml", "ball", {});
  };
  EXPECT_EQ(draft(again), draft(input));
  WriteMasks(top() / "masks", false);
  EXPECT_FALSE(FindInput({.photos = top()}).mask_agreement) << "somebody's are better";
  fs::remove_all(top() / "masks");
  fs::remove(top() / "ball_masks/made_masks.txt");
  EXPECT_FALSE(FindInput({.photos = top()}).mask_agreement) << "corrected and taken over";
}

// Not the first photo decides.
TEST_F(DraftConfigTest, FindsObjectsThatSomeAlphaChannelsTell) {
  WriteSet(top(), Cameras::kTransforms);
  Json cameras = Json::parse(renderer::ReadWholeFile(top() / "transforms.json"));
  const auto with_alpha = [&](std::size_t i) {
    const Image photo = views_[i].photo.Unpack();
    const Image mask = views_[i].mask.Unpack();
    Image rgba(photo.width, photo.height, 4);
    for (std::size_t p = 0; p < mask.data.size(); ++p) {
      for (std::size_t c = 0; c < 3; ++c) rgba.data[4 * p + c] = photo.data[3 * p + c];
      rgba.data[4 * p + 3] = mask.data[p];
    }
    cameras["frames"][i]["file_path"] = "images/alpha" + std::to_string(i) + ".exr";
    WriteExr(top() / "images" / ("alpha" + std::to_string(i) + ".exr"), rgba);
    std::ofstream(top() / "transforms.json") << cameras;
  };
  for (const std::size_t i : {1U, 2U, 4U, 5U}) with_alpha(i);
  const FoundInput some = FindInput({.photos = top()});
  EXPECT_TRUE(some.options.masks.alpha);
  EXPECT_EQ(some.num_masks, 4U);
  EXPECT_EQ(some.options.masks.require, optim::MaskRequirement::kSome);
  EXPECT_EQ(Built(some).observations.views.size(), std::size_t{kViews});
  for (const std::size_t i : {0U, 3U}) with_alpha(i);
  const FoundInput all = FindInput({.photos = top()});
  EXPECT_EQ(all.num_masks, std::size_t{kViews});
  EXPECT_EQ(all.options.masks.require, optim::MaskRequirement::kAll);
}

// Labels without an ending, as some programs write them, may have dots.
TEST_F(DraftConfigTest, FindsPhotosByLabelsWithDots) {
  WriteSet(top(), Cameras::kTransforms);
  Json cameras = Json::parse(renderer::ReadWholeFile(top() / "transforms.json"));
  for (std::size_t i = 0; i < kViews; ++i) {
    const std::string label = "set." + std::to_string(i);
    fs::rename(top() / paths_[i], top() / "images" / (label + ".PNG"));
    cameras["frames"][i]["file_path"] = "images/" + label;
  }
  std::ofstream(top() / "transforms.json") << cameras;
  EXPECT_EQ(FindInput({.photos = top()}).observations.views.size(), std::size_t{kViews});
}

TEST_F(DraftConfigTest, MasksBesideThePhotosAreNotPhotos) {
  WriteSet(top(), Cameras::kTransforms);
  WriteMasks(top() / "images", false);
  std::ofstream(top() / "images/other.mask.png") << "of a photo that is not there";
  FoundInput input = FindInput({.photos = top()});
  EXPECT_EQ(input.num_masks, std::size_t{kViews});
  EXPECT_EQ(input.num_without_camera, 0U);
  fs::copy(top() / paths_[0], top() / "images/other.png");
  input = FindInput({.photos = top()});
  EXPECT_EQ(input.num_without_camera, 1U);
}

TEST_F(DraftConfigTest, NothingStandsInForAPhotoThatIsMissing) {
  WriteSet(top(), Cameras::kTransforms);
  // Masks of the photos' names, all of them.
  fs::create_directories(top() / "masks");
  for (const std::string& name : names_) {
    fs::copy_file(top() / "images" / name, top() / "masks" / name);
  }
  fs::remove(top() / paths_[2]);
  EXPECT_TRUE(
      Says(Refusal({.photos = top()}), "1 of its 6 photos are missing, the first is " + paths_[2]));
  // Two folders with photos of the same names.
  fs::remove_all(top() / "masks");
  Json cameras = Json::parse(renderer::ReadWholeFile(top() / "transforms.json"));
  fs::create_directories(top() / "images/other");
  for (std::size_t i : {2, 3}) {
    fs::copy_file(top() / paths_[i + 2], top() / "images/other" / names_[i - 2]);
    cameras["frames"][i]["file_path"] = "images/other/" + names_[i - 2];
  }
  std::ofstream(top() / "transforms.json") << cameras;
  EXPECT_EQ(FindInput({.photos = top()}).observations.views.size(), std::size_t{kViews});
  fs::remove(top() / "images/other" / names_[1]);
  EXPECT_TRUE(Says(Refusal({.photos = top()}), "the first is images/other/" + names_[1]));
}

TEST_F(DraftConfigTest, SeesInvertedMasksAndThatSomeAreMissing) {
  WriteSet(top(), Cameras::kTransforms);
  WriteMasks(top() / "object_masks", true, kViews - 1);
  const FoundInput input = FindInput({.photos = top()});
  EXPECT_TRUE(input.options.masks.invert);
  EXPECT_EQ(input.options.masks.require, optim::MaskRequirement::kSome);
  const Experiment experiment = Built(input);
  EXPECT_LT(experiment.observations.views[0].mask.Unpack().At(0, 0, 0), 0.5F);
  EXPECT_TRUE(experiment.observations.views.back().mask.Empty());
}

TEST_F(DraftConfigTest, TakesPlacesThatAreNamed) {
  WriteSet(top() / "photos here", Cameras::kTransforms);
  WriteMasks(top() / "elsewhere", false);
  fs::create_directories(top() / "poses");
  fs::rename(top() / "photos here/transforms.json", top() / "poses/mine.json");
  const FoundInput input = FindInput({.photos = top() / "photos here",
                                      .cameras = top() / "poses/mine.json",
                                      .masks = top() / "elsewhere"});
  EXPECT_EQ(Built(input).input_files.size(), std::size_t{1 + 2 * kViews});
}

TEST_F(DraftConfigTest, ABackgroundShowsWhoTurned) {
  WriteSet(top(), Cameras::kTransforms);
  WriteMasks(top() / "masks", false);
  const auto repaint = [&](auto grey) {  // the background: grey(photo, column)
    for (std::size_t i = 0; i < kViews; ++i) {
      Image photo = views_[i].photo.Unpack();
      const Image mask = views_[i].mask.Unpack();
      for (int y = 0; y < photo.height; ++y) {
        for (int x = 0; x < photo.width; ++x) {
          if (mask.At(x, y, 0) > 0.0F) continue;
          for (int c = 0; c < 3; ++c) photo.At(x, y, c) = grey(static_cast<float>(i), x);
        }
      }
      renderer::WritePng8(top() / paths_[i], EncodedImage(photo));
    }
    return *FindInput({.photos = top()}).background;
  };
  const Background curtain =
      repaint([](float, int x) { return 0.2F + 0.05F * static_cast<float>(x % 12); });
  EXPECT_TRUE(curtain.IsStill());
  EXPECT_TRUE(curtain.ShowsThatItIsStill());
  const Background even = repaint([](float, int) { return 0.5F; });
  EXPECT_TRUE(even.IsStill());
  EXPECT_FALSE(even.ShowsThatItIsStill()) << "an even one looks so from everywhere";
  const Background changes = repaint([](float i, int) { return 0.1F + 0.15F * i; });
  EXPECT_FALSE(changes.IsStill());
}

TEST_F(DraftConfigTest, AFlashThatFiredInAllPhotosIsOnTheCamera) {
  WriteSet(top(), Cameras::kTransforms);
  WriteMasks(top() / "masks", false);
  const auto write = [&](std::size_t i, std::uint16_t flash) {
    folder_.WriteText(
        paths_[i],
        optim::WithExif(renderer::EncodeJpeg(EncodedImage(views_[i].photo.Unpack()), 95),
                        optim::ExifBlock({.flash = flash})));
  };
  for (std::size_t i = 0; i < kViews; ++i) write(i, 0x19);
  const FoundInput input = FindInput({.photos = top()});
  const auto choice = LightBySigns(input);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->light, DraftLight::kFlash);
  EXPECT_TRUE(Says(choice->reason, "a flash fired in all photos"));
  write(2, 0x18);  // it did not fire in one
  const auto other = LightBySigns(FindInput({.photos = top()}));
  EXPECT_TRUE(!other || !Says(other->reason, "flash fired"));
}

TEST_F(DraftConfigTest, WritesEachLight) {
  WriteSet(top(), Cameras::kTransforms);
  WriteMasks(top() / "masks", false);
  FoundInput input = FindInput({.photos = top()});
  for (const DraftLight light : {DraftLight::kWorld, DraftLight::kCamera}) {
    const Experiment experiment = Built(input, light);
    ASSERT_EQ(experiment.scene.emitters.size(), 1U);
    EXPECT_EQ(experiment.scene.emitters[0].frame == renderer::LightFrame::kCamera,
              light == DraftLight::kCamera);
  }
  const Experiment flash = Built(input, DraftLight::kFlash);
  ASSERT_EQ(flash.scene.emitters.size(), 2U);
  EXPECT_EQ(flash.scene.emitters[0].frame, renderer::LightFrame::kCamera);
  EXPECT_EQ(flash.scene.emitters[1].frame, renderer::LightFrame::kWorld);
  input.background = Background{.change = 0.01, .structure = 0.1};
  EXPECT_EQ(Built(input, DraftLight::kFlash).scene.emitters[1].frame, renderer::LightFrame::kCamera)
      << "the object turned before the camera and all else";
  EXPECT_EQ(flash.fit.unknowns.size(), 6U);
  EXPECT_EQ(flash.fit.stages.front().free.size(), 3U);
  EXPECT_EQ(flash.fit.stages.back().free.size(), 6U);

  const std::string text = DraftConfig(
      input, {DraftLight::kWorld, std::string(300, 'a') + " long word"}, top() / "a.yaml", "a", {});
  EXPECT_TRUE(Says(text, "    # long word.\n")) << "long lines are broken";
  input.layout.reset();
  EXPECT_THROW(DraftConfig(input, LightAsSaid(DraftLight::kFlash), top() / "a.yaml", "a", {}),
               renderer::SceneError);
}

TEST_F(DraftConfigTest, AFolderWithoutPicturesHasNoCamerasAboveIt) {
  WriteSet(top(), Cameras::kTransforms);
  fs::create_directories(top() / "empty");
  EXPECT_TRUE(Says(Refusal({.photos = top() / "empty"}), "no cameras were found"));
  EXPECT_EQ(FindInput({.photos = top() / "images"}).observations.views.size(), std::size_t{kViews});
}

bool AnySays(const std::vector<std::string>& texts, const std::string& part) {
  return std::ranges::any_of(texts, [&](const std::string& t) { return Says(t, part); });
}

TEST_F(DraftConfigTest, ExposuresStartAsExifSays) {
  WriteSet(top(), Cameras::kTransforms);
  WriteMasks(top() / "masks", false);
  const auto write = [&](std::size_t i, const std::string& block) {
    const Image photo = EncodedImage(views_[i].photo.Unpack());
    folder_.WriteText(paths_[i], optim::WithExif(renderer::EncodeJpeg(photo, 95), block));
  };
  for (std::uint32_t i = 0; i < kViews; ++i) {
    write(i, optim::ExifBlock({.time = {i % 2 + 1, 60}}));
  }
  const FoundInput input = FindInput({.photos = top()});
  EXPECT_TRUE(AnySays(input.observations.assumptions, "they differ by 1 EV"));
  const fs::path config = top() / "draft.yaml";
  const std::string text = DraftConfig(input, UsualLight({}), config, "ball", {});
  EXPECT_TRUE(Says(text, "which starts as EXIF says"));
  const auto gains = [&](std::string changed, const std::string& old, const std::string& now) {
    for (auto at = changed.find(old); at != std::string::npos; at = changed.find(old)) {
      changed.replace(at, old.size(), now);
    }
    std::ofstream(config) << changed;
    const Experiment experiment = BuildExperiment(LoadExperimentConfig(config, {}));
    EXPECT_TRUE(AnySays(experiment.assumptions, "Exposure: "));
    return std::pair(experiment.scene.sensors[0].gain, experiment.scene.sensors[1].gain);
  };
  const auto used = gains(text, "(not there)", "");
  EXPECT_NEAR(used.first, std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(used.second, std::sqrt(2.0), 1e-6);
  const auto none = std::pair(1.0, 1.0);
  EXPECT_EQ(gains(text, "{model: gain}", "{model: gain, ev: {\"*\": 0}}"), none);
  const std::string unfitted = text.substr(0, text.find("unknowns:"));
  EXPECT_EQ(gains(unfitted, "model: gain", "model: none"), none);
  std::ofstream(config) << text;

  // A grey background in photos that differ by their exposure stood still.
  for (std::uint32_t i = 0; i < kViews; ++i) {
    Image photo = EncodedImage(views_[i].photo.Unpack());
    const Image mask = views_[i].mask.Unpack();
    const double grey = renderer::SrgbFromLinear(i % 2 == 0 ? 0.2 : 0.4);
    for (std::size_t c = 0; c < photo.data.size(); ++c) {
      if (mask.data[c / 3] == 0.0F) photo.data[c] = static_cast<float>(grey);
    }
    folder_.WriteText(paths_[i],
                      optim::WithExif(renderer::EncodeJpeg(photo, 95),
                                      optim::ExifBlock({.time = {i % 2 + 1, 60}})));
  }
  EXPECT_TRUE(FindInput({.photos = top()}).background->IsStill());

  // One photo whose block is cut off: all as without EXIF.
  write(3, optim::ExifBlock({}).substr(0, 50));
  const Experiment experiment = BuildExperiment(LoadExperimentConfig(config, {}));
  EXPECT_EQ(experiment.scene.sensors[1].gain, 1.0);
  EXPECT_TRUE(AnySays(experiment.assumptions, "the others have none"));
}

TEST(DraftConfig, PlacesTheSphereOfFarAwayCamerasToItsRadius) {
  FoundInput input;
  input.options.images_dir = "/set/images";
  input.options.cameras = "/set/transforms.json";
  input.options.masks.meaning = optim::MaskMeaning::kNone;
  input.observations.views.resize(1);
  input.layout = CameraLayout{.centre = {500123.456, 4649776.25, 12.5}, .distance = 8.0};
  input.layout->radius = 2.0;
  EXPECT_TRUE(Says(DraftConfig(input, UsualLight({}), "/set/a.yaml", "a", {}),
                   "translate_m: [500123.46, 4649776.25, 12.50]"));
  input.layout->radius = 2e-3;
  EXPECT_TRUE(Says(DraftConfig(input, UsualLight({}), "/set/a.yaml", "a", {}), "500123.45600,"));
}

TEST_F(DraftConfigTest, FindsRawPhotosBesideJpegsByWhatTheCameraFileNames) {
  if (renderer::LibRawVersion().empty()) GTEST_SKIP() << "built without LibRaw";
  renderer::DngCamera dng;
  dng.width = dng.height = 48;
  WriteSet(top() / "set", Cameras::kTransforms);
  for (const std::string& name : names_) {
    const std::string stem = "set/images/" + fs::path(name).stem().string();
    folder_.WriteText(stem + ".DNG", renderer::GreyDng(dng, 0.25));
  }
  const FoundInput beside = FindInput({.photos = top() / "set"});
  EXPECT_EQ(beside.num_without_camera, 0U) << "each photo is there twice";
  EXPECT_EQ(beside.observations.views[0].files.photo.extension(), ".png");
  EXPECT_FALSE(Says(DraftConfig(beside, UsualLight({}), top() / "a.yaml", "a", {}), "RAW"));
  for (const std::string& name : names_) fs::remove(top() / "set/images" / name);
  const FoundInput alone = FindInput({.photos = top() / "set"});
  EXPECT_EQ(alone.observations.views[0].files.photo.extension(), ".DNG");
  EXPECT_TRUE(
      Says(DraftConfig(alone, UsualLight({}), top() / "a.yaml", "a", {}), "6 RAW, white balance"));
}

TEST_F(DraftConfigTest, AShinySurfaceHasARoughnessAndFinerLight) {
  WriteSet(top(), Cameras::kTransforms);
  WriteMasks(top() / "masks", false);
  const FoundInput input = FindInput({.photos = top()});
  const fs::path path = top() / "draft.yaml";
  const std::string text =
      DraftConfig(input, UsualLight({}), path, "ball", {}, DraftSurface::kShiny);
  EXPECT_TRUE(Says(text, "with highlights; metallic 1: a metal"));
  EXPECT_TRUE(Says(text, "metallic: {constant: 0}"));
  EXPECT_TRUE(Says(text, "size_px: [32, 16]"));
  EXPECT_FALSE(Says(text, "A matt surface sees"));
  std::ofstream(path) << text;
  const Experiment shiny = BuildExperiment(LoadExperimentConfig(path, {}));
  const auto frees_roughness = [](const Experiment& experiment) {
    return std::ranges::any_of(experiment.fit.unknowns, [](const optim::UnknownSpec& unknown) {
      return unknown.kind == renderer::ParameterKind::kRoughness;
    });
  };
  EXPECT_TRUE(frees_roughness(shiny));
  const std::string metal =
      DraftConfig(input, UsualLight({}), path, "ball", {}, SurfaceOf("metal"));
  EXPECT_TRUE(Says(metal, "metallic: {constant: 1}"));
  EXPECT_TRUE(Says(metal, "surface.roughness: {}"));
  EXPECT_FALSE(frees_roughness(Built(input)));
}

TEST_F(DraftConfigTest, SaysWhatIsMissing) {
  const std::string no_cameras = Refusal({.photos = top()});
  EXPECT_TRUE(Says(no_cameras, "no cameras were found. Looked for"));
  EXPECT_TRUE(Says(no_cameras, "--lamps FILE, or a shiny ball")) << no_cameras;
  EXPECT_FALSE(Says(no_cameras, "not read"));
  folder_.WriteText("phone/a.HEIC", "x");
  folder_.WriteText("phone/b.webp", "x");
  EXPECT_TRUE(
      Says(Refusal({.photos = top() / "phone"}), "pictures that are not read (.heic, .webp)"));
  fs::remove_all(top() / "phone");
  EXPECT_TRUE(Says(Refusal({.photos = top() / "nowhere"}), "no such folder"));
  WriteSet(top() / "one", Cameras::kTransforms);
  EXPECT_EQ(Refusal({.photos = top()}), "") << "one set in a folder is that set";
  EXPECT_TRUE(Says(Refusal({.photos = top(), .masks = top() / "one"}), "holds no mask of a photo"));
  fs::copy(top() / "one", top() / "two", fs::copy_options::recursive);
  EXPECT_TRUE(Says(Refusal({.photos = top()}), "several sets of cameras"));
  fs::remove(top() / "two" / paths_[3]);
  const std::string text = Refusal({.photos = top() / "two"});
  EXPECT_TRUE(Says(text, "1 of its 6 photos are missing, the first is images/view3.png")) << text;
  EXPECT_TRUE(Says(text, "leave out the cameras of photos that are gone")) << text;
  folder_.WriteText("three/cameras.bin", "x");
  EXPECT_TRUE(Says(Refusal({.photos = top() / "three"}), "cameras.bin: the file ends too early"));
}

}  // namespace
}  // namespace pathfit::app::draft_config_test

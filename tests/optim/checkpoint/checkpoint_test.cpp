#include "optim/checkpoint/checkpoint.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "tests/support/test_scenes.h"

namespace pathfit::checkpoint_test {
namespace {

namespace fs = std::filesystem;
using renderer::ParameterKind;

class CheckpointTest : public testing::Test {
 protected:
  CheckpointTest() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("pathfit_checkpoint_" + std::to_string(getpid()) + "_" + info->name());
    fs::remove_all(folder_);
  }
  ~CheckpointTest() override { fs::remove_all(folder_); }
  CheckpointTest(const CheckpointTest&) = delete;
  CheckpointTest& operator=(const CheckpointTest&) = delete;

  static std::vector<optim::UnknownSpec> Unknowns() {
    std::vector<optim::UnknownSpec> unknowns(4);
    unknowns[0].kind = ParameterKind::kVertexPositions;
    unknowns[1].kind = ParameterKind::kEnvironmentTexels;
    unknowns[2].kind = ParameterKind::kExposure;
    unknowns[2].object = -1;
    unknowns[3].kind = ParameterKind::kRoughness;
    unknowns[3].object = 1;
    unknowns[3].hold = true;  // neither stored nor read
    return unknowns;
  }

  optim::FitState State(int sequence) {
    optim::FitState state;
    state.fingerprint = "views \"3\"\n\\";
    state.sequence = sequence;
    state.step = 17;
    state.stage = 1;
    state.round = 4;
    state.wall_s = 1.0 / 3.0;
    state.radius_factor = 0.1;
    state.step_share = 0.4;
    state.damping = std::nextafter(1e-3, 1.0);
    state.rejected_in_row = 2;
    state.level = 2;
    state.level_start = 1;
    state.restarts = 2;
    state.accepted = 3;
    state.within_error = 4;
    state.still = 5;
    state.precise = true;
    state.rounds.model = optim::QuadraticModel(1);
    state.rounds.model.weight = 3.0;
    state.rounds.model.product = {1.0 / 3.0};
    state.rounds.apart = state.rounds.model;
    state.rounds.apart.weight = 1.0;
    state.rounds.rows = optim::RowHistory(2, 1);
    state.rounds.rows.weight = 2.0;
    state.rounds.rows.theta = {1.0 / 7.0};
    state.rounds.rows.views[1] = {{5}, {1.0 / 9.0, -0.0}, {1.0F / 3.0F, 1e-38F}};
    state.standard_errors = {{"ball.translation", {0.1, 0.2, 0.3}}, {"lamp.power", {}}};
    state.costs = {0.3, 0.2, 0.1, -1e-3};
    state.scene = state.stage_start = state.level_scene = start_;
    state.scene.meshes[0].mesh.positions[1] = {1.0 / 3.0, -0.0, 5e-324};
    state.scene.sensors[0].gain = std::nextafter(2.0, 3.0);
    state.average.newer = {12.0, state.scene};
    state.average.newer_start = 8;
    return state;
  }

  void Write(const optim::FitState& state) const {
    optim::WriteCheckpoint(folder_, {start_, unknowns_}, state);
  }
  optim::NewestCheckpoint Read() const {  // NOLINT(modernize-use-nodiscard): some reads throw
    return optim::ReadNewestCheckpoint(folder_, {start_, unknowns_});
  }
  [[nodiscard]] fs::path PathOf(const std::string& number) const {
    return folder_ / ("state_" + number + ".cbor");
  }

  fs::path folder_;
  renderer::Scene start_ = tests::BallAndWall();
  std::vector<optim::UnknownSpec> unknowns_ = Unknowns();
};

std::string BytesOf(const fs::path& path) { return renderer::ReadWholeFile(path); }

void ExpectSameMesh(const renderer::Mesh& a, const renderer::Mesh& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.uvs, b.uvs);
  EXPECT_EQ(a.colors, b.colors);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.normal_triangles, b.normal_triangles);
  EXPECT_EQ(a.uv_triangles, b.uv_triangles);
  EXPECT_EQ(a.color_triangles, b.color_triangles);
}

TEST_F(CheckpointTest, ReturnsEveryBit) {
  const optim::FitState state = State(3);
  Write(state);
  const optim::FitState read = Read().state.value();
  EXPECT_EQ(read.fingerprint, state.fingerprint);
  EXPECT_EQ(read.sequence, 3);
  EXPECT_EQ(read.step, 17);
  EXPECT_EQ(read.stage, 1);
  EXPECT_EQ(read.round, 4);
  EXPECT_EQ(read.wall_s, state.wall_s);
  EXPECT_EQ(read.rounds.model.product, state.rounds.model.product);
  EXPECT_EQ(read.rounds.apart.weight, 1.0);
  ASSERT_EQ(read.rounds.rows.views.size(), 2u);
  EXPECT_EQ(read.rounds.rows.weight, 2.0);
  EXPECT_EQ(read.rounds.rows.theta, state.rounds.rows.theta);
  EXPECT_TRUE(read.rounds.rows.views[0].units.empty());
  EXPECT_EQ(read.rounds.rows.views[1].units, state.rounds.rows.views[1].units);
  EXPECT_EQ(read.rounds.rows.views[1].residuals, state.rounds.rows.views[1].residuals);
  EXPECT_EQ(read.rounds.rows.views[1].jacobians, state.rounds.rows.views[1].jacobians);
  EXPECT_EQ(read.radius_factor, state.radius_factor);
  EXPECT_EQ(read.step_share, state.step_share);
  EXPECT_EQ(read.damping, state.damping);
  EXPECT_EQ(read.rejected_in_row, 2);
  EXPECT_EQ(read.level, 2);
  EXPECT_EQ(read.level_start, 1);
  EXPECT_EQ(read.restarts, 2);
  EXPECT_EQ(read.accepted, 3);
  EXPECT_EQ(read.within_error, 4);
  EXPECT_EQ(read.still, 5);
  EXPECT_TRUE(read.precise);
  EXPECT_EQ(read.standard_errors, state.standard_errors);
  EXPECT_EQ(read.costs, state.costs);
  ExpectSameMesh(read.scene.meshes[0].mesh, state.scene.meshes[0].mesh);
  EXPECT_TRUE(std::signbit(read.scene.meshes[0].mesh.positions[1].y));
  EXPECT_EQ(read.scene.sensors[0].gain, state.scene.sensors[0].gain);
  ExpectSameMesh(read.stage_start.meshes[0].mesh, start_.meshes[0].mesh);
  EXPECT_EQ(read.average.older.weight, 0.0);
  EXPECT_EQ(read.average.newer.weight, 12.0);
  ExpectSameMesh(read.average.newer.scene.meshes[0].mesh, state.scene.meshes[0].mesh);
  EXPECT_EQ(read.average.newer_start, 8);
}

TEST_F(CheckpointTest, HoldsShapesThatAreNotTheStarts) {
  optim::FitState state = State(1);
  renderer::Mesh& ball = state.scene.meshes[0].mesh;
  ball = renderer::MakeIcosphere(3, 0.7);
  renderer::SetUniformVertexColors({0.1, 0.2, 0.3}, ball);
  auto& sky = std::get<renderer::EnvironmentEmitter>(state.scene.emitters[0].light);
  sky.width = 3;
  sky.height = 2;
  sky.texels.assign(6, {1.0, 2.0, 1.0 / 3.0});
  EXPECT_FALSE(optim::SameShapes(state.scene, start_));
  Write(state);
  const optim::FitState read = Read().state.value();
  EXPECT_TRUE(optim::SameShapes(read.scene, state.scene));
  ExpectSameMesh(read.scene.meshes[0].mesh, ball);
  const auto& read_sky = std::get<renderer::EnvironmentEmitter>(read.scene.emitters[0].light);
  EXPECT_EQ(read_sky.texels, sky.texels);
  ExpectSameMesh(read.stage_start.meshes[0].mesh, start_.meshes[0].mesh);
}

TEST_F(CheckpointTest, StoresEqualArraysOnceAndTheStartNever) {
  optim::FitState state = State(1);
  state.scene = start_;
  state.average = {};
  Write(state);
  const auto as_start = fs::file_size(PathOf("000001"));
  EXPECT_LT(as_start, 1500U);
  Write(State(2));  // moves the ball in two of the three scenes
  const std::size_t positions = 24 * start_.meshes[0].mesh.positions.size();
  EXPECT_LT(fs::file_size(PathOf("000002")), as_start + positions + 500);
}

TEST_F(CheckpointTest, FindsEveryFlippedBit) {
  unknowns_.erase(unknowns_.begin(), unknowns_.begin() + 2);  // a small file
  Write(State(1));
  const std::string whole = BytesOf(PathOf("000001"));
  ASSERT_TRUE(Read().state.has_value());
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    std::string flipped = whole;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << (bit % 8)));
    renderer::WriteFileAtomically(PathOf("000001"), flipped);
    ASSERT_THROW(Read(), renderer::IoError) << "bit " << bit << " of " << 8 * whole.size();
  }
  for (std::size_t length = 0; length < whole.size(); length += 7) {
    renderer::WriteFileAtomically(PathOf("000001"), whole.substr(0, length));
    ASSERT_THROW(Read(), renderer::IoError) << "cut after " << length;
  }
}

TEST_F(CheckpointTest, KeepsTheTwoNewestAndFallsBackToTheOlderWithAReason) {
  for (int sequence = 1; sequence <= 12; ++sequence) {
    Write(State(sequence));
  }
  const auto count = std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  EXPECT_EQ(count, 2);
  EXPECT_EQ(Read().state->sequence, 12);
  EXPECT_TRUE(Read().damaged.empty());
  fs::resize_file(PathOf("000012"), 130);
  const optim::NewestCheckpoint older = Read();
  EXPECT_EQ(older.state->sequence, 11);
  ASSERT_EQ(older.damaged.size(), 1U);
  EXPECT_NE(older.damaged[0].find("state_000012.cbor: it is damaged"), std::string::npos)
      << older.damaged[0];
  std::ofstream(PathOf("000011")) << "{";
  try {
    Read();
    FAIL() << "not refused";
  } catch (const renderer::IoError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("state_000011.cbor"), std::string::npos) << text;
    EXPECT_NE(text.find("state_000012.cbor"), std::string::npos) << text;
  }
}

TEST_F(CheckpointTest, RefusesAveragesWithWeightsOfNoRounds) {
  Write(State(1));
  const auto refuses = [&](double older, double newer) {
    optim::FitState state = State(2);
    state.average.older = {older, state.scene};
    state.average.newer = {newer, state.scene};
    Write(state);
    const optim::NewestCheckpoint read = Read();
    EXPECT_EQ(read.state->sequence, 1) << older << " " << newer;
    ASSERT_EQ(read.damaged.size(), 1U);
    EXPECT_NE(read.damaged[0].find("state_000002.cbor: it is damaged"), std::string::npos);
  };
  const double nan = std::nan("");
  refuses(0.0, nan);
  refuses(nan, 8.0);
  refuses(0.0, -1.0);
  refuses(-8.0, 8.0);
  refuses(-4.0, 8.0);
  refuses(0.0, 1e12);
  refuses(1e300, 8.0);
  refuses(0.0, std::numeric_limits<double>::infinity());
  refuses(8.0, 0.0);
}

TEST_F(CheckpointTest, RefusesNestedListsBeforeItReadsThem) {
  fs::create_directories(folder_);
  const std::string start(
      "\xa3\x66"
      "crc32c\x01\x66"
      "format\x6f"
      "pathfit state 2\x67"
      "payload");
  for (const std::string& bytes : {std::string(5000000, '\x81'),
                                   start + std::string(5000000, '\x81'),
                                   start + std::string(5000000, '\x5f')}) {
    renderer::WriteFileAtomically(PathOf("000001"), bytes);
    try {
      Read();
      FAIL() << "not refused";
    } catch (const renderer::IoError& error) {
      EXPECT_NE(std::string(error.what()).find("it is damaged"), std::string::npos);
    }
  }
}

TEST_F(CheckpointTest, RefusesWhatIsNotItsOwn) {
  EXPECT_FALSE(Read().state.has_value());
  Write(State(1));
  unknowns_[0].hold = true;
  EXPECT_THROW(Read(), renderer::IoError);  // other unknowns
  unknowns_[0].hold = false;
  start_.meshes[0].mesh.positions[3].x += 1e-9;
  EXPECT_THROW(Read(), renderer::IoError);  // another start
  fs::remove(PathOf("000001"));
  fs::create_directories(folder_ / "state_000002");
  std::ofstream(folder_ / "state_000002" / "state.json") << "{\"version\": 1}";
  try {
    Read();
    FAIL() << "not refused";
  } catch (const renderer::IoError& error) {
    EXPECT_NE(std::string(error.what()).find("earlier version"), std::string::npos);
  }
}

TEST_F(CheckpointTest, SaysWhereItCannotWrite) {
  std::ofstream(folder_) << "a file where the folder should be";
  EXPECT_THROW(Write(State(1)), renderer::IoError);
}

}  // namespace
}  // namespace pathfit::checkpoint_test

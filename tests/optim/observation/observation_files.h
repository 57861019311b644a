#pragma once

#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include <gtest/gtest.h>
#include <unistd.h>

#include "renderer/image/image.h"

namespace pathfit::optim {

/// An empty folder below the system's temporary folder, removed at the end. It has a parent of its
/// own: what is looked for beside it is not found among the files of tests that run at the same
/// time.
class TempFolder {
 public:
  TempFolder() {
    static std::atomic<int> count = 0;
    const auto* const test = ::testing::UnitTest::GetInstance()->current_test_info();
    top_ = std::filesystem::temp_directory_path() /
           ("pathfit_" + std::string(test->test_suite_name()) + "_" + test->name() + "_" +
            std::to_string(getpid()) + "_" + std::to_string(count++));
    path_ = top_ / "files";
    std::filesystem::remove_all(top_);
    std::filesystem::create_directories(path_);
  }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(top_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Writes bytes to a file, with the folders it needs.
  std::filesystem::path WriteText(const std::string& name, const std::string& text) const {
    std::filesystem::path file = path_ / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }

 private:
  std::filesystem::path top_, path_;
};

/// An image of one value in all pixels and channels.
inline renderer::Image ConstantImage(int width, int height, int channels, float value) {
  renderer::Image image(width, height, channels);
  image.data.assign(image.data.size(), value);
  return image;
}

}  // namespace pathfit::optim

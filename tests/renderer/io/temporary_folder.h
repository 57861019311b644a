#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>

#include <gtest/gtest.h>
#include <unistd.h>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::renderer {

/// A new folder that disappears with the object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "pathfit-io-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) ADD_FAILURE() << "cannot make " << name;
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& Path() const { return path_; }

  /// Path of a new file with these bytes.
  std::filesystem::path Write(const std::string& name, std::string_view bytes) const {
    std::ofstream(path_ / name, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

/// Message of the IoError that `run` throws; empty, with a failure, when it throws none.
inline std::string IoErrorOf(const std::function<void()>& run) {
  try {
    run();
  } catch (const IoError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no IoError";
  return "";
}

/// Every proper beginning of the file, up to `max_cuts` of them, must be refused.
inline void ExpectCutFilesRefused(const std::filesystem::path& whole,
                                  std::size_t shortest_whole,
                                  std::size_t max_cuts,
                                  const std::function<void(const std::filesystem::path&)>& read) {
  const std::string bytes = ReadWholeFile(whole);
  const std::filesystem::path cut = whole.parent_path() / ("cut" + whole.extension().string());
  const std::size_t step = shortest_whole / max_cuts + 1;
  for (std::size_t size = 0; size < shortest_whole; size += step) {
    std::ofstream(cut, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(size));
    EXPECT_THROW(read(cut), IoError) << "cut at " << size << " of " << bytes.size();
  }
}

/// Flipped bytes may be read or refused, but nothing else may happen.
inline void ExpectDamagedFilesSurvived(
    const std::filesystem::path& whole,
    int rounds,
    const std::function<void(const std::filesystem::path&)>& read) {
  const std::string bytes = ReadWholeFile(whole);
  const std::filesystem::path bad = whole.parent_path() / ("bad" + whole.extension().string());
  std::size_t state = 1;
  const auto next = [&state](std::size_t below) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return (state >> 33) % below;
  };
  for (int round = 0; round < rounds; ++round) {
    std::string damaged = bytes;
    for (std::size_t k = next(4) + 1; k > 0; --k) {
      damaged[next(damaged.size())] = static_cast<char>(static_cast<unsigned char>(next(256)));
    }
    std::ofstream(bad, std::ios::binary)
        .write(damaged.data(), static_cast<std::streamsize>(damaged.size()));
    try {
      read(bad);
    } catch (const IoError&) {
    }
  }
}

}  // namespace pathfit::renderer

#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace pathfit::tests {

/// Files by name that are read together.
using FileSet = std::map<std::string, std::string>;

/// A reader, what it reads when nothing is wrong, and what means something there.
struct FuzzTarget {
  std::string name;
  std::vector<FileSet> seeds;
  std::vector<std::string> words;
  /// Reads the files of one seed, damaged, in the folder. What readers may throw passes through.
  std::function<void(const std::filesystem::path& folder)> read;
  /// Puts right what a damaged file would be refused for at once, such as checksums; may be empty.
  std::function<void(std::string& bytes)> mend;
  double weight = 1.0;  ///< inputs of it for each of the others
};

/// All of them. `folder` is an empty one to make seeds in.
std::vector<FuzzTarget> FuzzTargets(const std::filesystem::path& folder);

}  // namespace pathfit::tests

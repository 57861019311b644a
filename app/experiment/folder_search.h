#pragma once

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "renderer/core/lower_case.h"

namespace pathfit::app {

inline bool IsFolder(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

/// Entries of a folder that pass, by name; none where it cannot be read.
template <class Predicate>
std::vector<std::filesystem::path> EntriesOf(const std::filesystem::path& folder,
                                             Predicate predicate) {
  std::vector<std::filesystem::path> found;
  std::error_code error;
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    if (predicate(it->path())) found.push_back(it->path());
  }
  std::ranges::sort(found);
  return found;
}

/// Without a slash at its end; empty: where the program runs.
inline std::filesystem::path AbsolutePath(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::path absolute =
      std::filesystem::absolute(path.empty() ? std::filesystem::path(".") : path, error)
          .lexically_normal();
  return absolute.has_filename() ? absolute : absolute.parent_path();
}

/// "a, b".
inline std::string PathList(const std::vector<std::filesystem::path>& paths) {
  std::string text;
  for (const auto& path : paths) text += (text.empty() ? "" : ", ") + path.string();
  return text;
}

/// Whether the last name of a path has one of the words in it, in either case.
inline bool SpeaksOf(const std::filesystem::path& path,
                     std::initializer_list<std::string_view> words) {
  const std::string name = renderer::LowerCase(path.filename().string());
  return std::ranges::any_of(
      words, [&](std::string_view word) { return name.find(word) != std::string::npos; });
}
inline bool SpeaksOfMasks(const std::filesystem::path& path) {
  return SpeaksOf(path, {"mask", "silhouette", "matte", "segment"});
}

}  // namespace pathfit::app

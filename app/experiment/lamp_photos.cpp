#include "app/experiment/lamp_photos.h"

#include <algorithm>
#include <cctype>
#include <map>

#include <fmt/format.h>

#include "app/experiment/folder_search.h"
#include "optim/observation/photo_file.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/text_scanner.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;
using optim::LampList;
using optim::PhotoLamp;
using renderer::IoError;

bool SpeaksOfOthers(const fs::path& path) {
  return SpeaksOfMasks(path) || SpeaksOf(path, {"normal", "albedo", "depth", "ambient"});
}

bool IsDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// "img_#.png" of img_12.png.
std::string WithoutNumbers(const fs::path& path) {
  std::string text;
  for (const char c : path.filename().string()) {
    if (!IsDigit(c)) {
      text += c;
    } else if (text.empty() || text.back() != '#') {
      text += '#';
    }
  }
  return text;
}

/// As people count: 2 before 10, wherever the number stands.
bool NaturalLess(const fs::path& first, const fs::path& second) {
  const std::string a = first.filename().string(), b = second.filename().string();
  std::size_t i = 0, j = 0;
  const auto run = [](const std::string& text, std::size_t& at) {
    while (at + 1 < text.size() && text[at] == '0' && IsDigit(text[at + 1])) ++at;
    const std::size_t begin = at;
    while (at < text.size() && IsDigit(text[at])) ++at;
    return text.substr(begin, at - begin);
  };
  while (i < a.size() && j < b.size()) {
    if (IsDigit(a[i]) && IsDigit(b[j])) {
      const std::string m = run(a, i), n = run(b, j);
      if (m.size() != n.size()) return m.size() < n.size();
      if (m != n) return m < n;
    } else if (a[i] != b[j]) {
      return a[i] < b[j];
    } else {
      ++i;
      ++j;
    }
  }
  return a.size() - i != b.size() - j ? a.size() - i < b.size() - j : a < b;
}

/// Pictures of a folder by their numbers.
std::vector<fs::path> NumberedPictures(const fs::path& folder) {
  std::vector<fs::path> pictures = optim::WithoutRawTwins(optim::PicturesIn(folder));
  std::ranges::sort(pictures, NaturalLess);
  return pictures;
}
/// So many pictures of a folder: all, all photos, else those whose names differ by their numbers
/// alone. Empty: there are others.
std::vector<fs::path> SoManyPhotos(const fs::path& folder, std::size_t count) {
  const std::vector<fs::path> all = NumberedPictures(folder);
  for (const std::vector<fs::path>& some : {NumberedPhotos(folder), all}) {
    if (some.size() == count) return some;
  }
  std::map<std::string, std::vector<fs::path>> groups;
  for (const fs::path& picture : all) groups[WithoutNumbers(picture)].push_back(picture);
  std::erase_if(groups, [&](const auto& group) { return group.second.size() != count; });
  return groups.size() == 1 ? groups.begin()->second : std::vector<fs::path>();
}

/// The photo of this name or, without extension, stem.
fs::path PhotoNamed(const fs::path& folder, const std::string& name) {
  std::string plain = name;
  std::ranges::replace(plain, '\\', '/');
  const fs::path file = fs::path(plain).filename();
  if (optim::IsPicture(folder / file)) return folder / file;
  std::vector<fs::path> alike = optim::WithoutRawTwins(optim::PicturesIn(folder));
  std::erase_if(alike, [&](const fs::path& path) {
    return path.stem() != file && path.stem() != file.stem();
  });
  return alike.size() == 1 ? alike.front() : fs::path();
}

/// Names in a filenames.txt, one for each lamp; empty without it.
std::vector<std::string> ListedNames(const fs::path& lamp_file) {
  const fs::path path = lamp_file.parent_path() / "filenames.txt";
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return {};
  const std::string text = renderer::ReadWholeFile(path);
  std::vector<std::string> names;
  renderer::LineReader lines(text);
  for (std::string_view line; lines.Next(line);) {
    if (const std::string_view name = renderer::NextToken(line); !name.empty()) {
      names.emplace_back(name);
    }
  }
  return names;
}

/// Of the photos; empty where their numbers tell.
std::vector<std::string> NamesOfLamps(const LampList& list, const fs::path& lamp_file) {
  std::vector<std::string> names;
  for (const PhotoLamp& lamp : list.lamps) names.push_back(lamp.photo);
  const bool by_ball = IsFolder(lamp_file);
  if (!by_ball && std::ranges::all_of(names, [](const std::string& n) { return n.empty(); })) {
    names = ListedNames(lamp_file);
    if (!names.empty() && names.size() != list.lamps.size()) {
      throw IoError(fmt::format("{}: has {} names for {} lamps",
                                (lamp_file.parent_path() / "filenames.txt").string(),
                                names.size(),
                                list.lamps.size()));
    }
  }
  if (!names.empty() && names.front().empty()) names.clear();
  return names;
}

}  // namespace

std::vector<fs::path> NumberedPhotos(const fs::path& folder) {
  std::vector<fs::path> pictures = NumberedPictures(folder);
  std::erase_if(pictures, SpeaksOfOthers);
  return pictures;
}

std::vector<fs::path> PhotosOfLamps(const fs::path& top,
                                    const LampList& list,
                                    const fs::path& lamp_file) {
  if (!IsFolder(top)) throw IoError(top.string() + ": no such folder");
  std::vector<fs::path> folders =
      EntriesOf(top, [&](const fs::path& path) { return IsFolder(path) && path != lamp_file; });
  folders.insert(folders.begin(), top);
  const std::vector<std::string> names = NamesOfLamps(list, lamp_file);
  std::vector<std::vector<fs::path>> found;
  std::string missing;
  for (const fs::path& folder : folders) {
    if (names.empty()) {
      found.push_back(SoManyPhotos(folder, list.lamps.size()));
    } else {
      auto& photos = found.emplace_back();
      for (const std::string& name : names) {
        const fs::path photo = PhotoNamed(folder, name);
        if (photo.empty() && folder == top) missing = name;
        if (photo.empty()) break;
        photos.push_back(photo);
      }
      if (photos.size() != names.size()) photos.clear();
    }
    if (found.back().empty()) found.pop_back();
    if (!found.empty() && folder == top) return found.front();
  }
  if (found.size() == 1) return found.front();
  if (found.size() > 1) {
    throw IoError(top.string() + ": several folders in it have a photo for each of the " +
                  std::to_string(list.lamps.size()) + " lamps; name one");
  }
  throw IoError(fmt::format(
      "{}: has {} lamps, but {} has {} pictures{}. There must be one photo for each lamp: by the "
      "names in that file or in a filenames.txt beside it, else in the order of their numbers",
      lamp_file.string(),
      list.lamps.size(),
      top.string(),
      optim::PicturesIn(top).size(),
      missing.empty() ? "" : ", none of them " + missing));
}

std::string PatternOf(const std::vector<std::string>& names,
                      const std::vector<fs::path>& pictures) {
  std::string common = names.front();
  for (const std::string& name : names) {
    const auto end = std::ranges::mismatch(common, name).in1;
    common.erase(end, common.end());
  }
  // Not within a letter of several bytes.
  while (!common.empty() && static_cast<unsigned char>(common.back()) >= 0x80U) common.pop_back();
  const auto count = std::ranges::count_if(pictures, [&](const fs::path& picture) {
    return picture.filename().string().starts_with(common);
  });
  const bool is_plain = common.find_first_of("*?[\\") == std::string::npos;
  return is_plain && !common.empty() && count == static_cast<std::ptrdiff_t>(names.size())
             ? common + "*"
             : "";
}

fs::path PhotoFolder(const fs::path& top, const fs::path& other) {
  if (!NumberedPhotos(top).empty()) return top;
  const std::vector<fs::path> with = EntriesOf(top, [&](const fs::path& path) {
    return IsFolder(path) && path != other && !NumberedPhotos(path).empty();
  });
  return with.size() == 1 ? with.front() : top;
}

}  // namespace pathfit::app

#include "app/output/run_directory.h"

#include <map>
#include <set>
#include <system_error>
#include <utility>

#include <fmt/chrono.h>
#include <unistd.h>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxAttempts = 10000;

std::string Replaced(std::string text, const std::string& what, const std::string& with) {
  for (std::size_t at = text.find(what); at != std::string::npos;
       at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
  return text;
}

/// The path with its placeholders replaced; folders that are there already are called so.
fs::path FilledIn(const fs::path& pattern,
                  const std::string& name,
                  std::chrono::system_clock::time_point time) {
  const std::string timestamp =
      fmt::format("{:%Y-%m-%d_%H%M%S}", fmt::gmtime(std::chrono::system_clock::to_time_t(time)));
  fs::path path;
  for (const fs::path& part : pattern) {
    std::error_code error;
    if (fs::is_directory(path / part, error)) {
      path /= part;
    } else {
      path /=
          Replaced(Replaced(part.string(), "{name}", SafeFileName(name)), "{timestamp}", timestamp);
    }
  }
  return path;
}

[[noreturn]] void ThrowCannotCreate(const fs::path& path, const std::error_code& error) {
  throw renderer::IoError(path.string() + ": cannot be created: " + error.message());
}

/// Creates the first of path, path-2, path-3 ... that does not exist, or is an empty folder.
fs::path CreateNewFolder(const fs::path& path) {
  for (int attempt = 1; attempt <= kMaxAttempts; ++attempt) {
    fs::path candidate = path;
    if (attempt > 1) candidate += "-" + std::to_string(attempt);
    std::error_code error;
    if (fs::create_directory(candidate, error)) return candidate;
    if (!error && fs::is_empty(candidate, error)) return candidate;
    if (error && error != std::errc::file_exists) ThrowCannotCreate(candidate, error);
  }
  throw renderer::IoError(path.string() + ": no free name for a new run directory");
}

void CheckLatest(const fs::path& link) {
  std::error_code error;
  const fs::file_status status = fs::symlink_status(link, error);
  if (fs::exists(status) && !fs::is_symlink(status)) {
    throw renderer::IoError(link.string() +
                            ": must be a symbolic link to the newest run, but is something else; "
                            "rename it, or write the run elsewhere (-o)");
  }
}

void PointLatestTo(const fs::path& run) {
  const fs::path link = run.parent_path() / "latest";
  std::error_code error;
  const fs::path temporary = run.parent_path() / (".latest." + std::to_string(getpid()));
  fs::remove(temporary, error);
  fs::create_directory_symlink(run.filename(), temporary, error);
  if (error) ThrowCannotCreate(temporary, error);
  fs::rename(temporary, link, error);
  if (error) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    ThrowCannotCreate(link, error);
  }
}

}  // namespace

RunDirectory::RunDirectory(fs::path root) : root_(std::move(root)) {
  std::error_code error;
  if (!fs::is_directory(root_, error)) {
    throw renderer::IoError(root_.string() + ": there is no such run directory");
  }
}

RunDirectory CreateRunDirectory(const fs::path& pattern,
                                const std::string& name,
                                std::chrono::system_clock::time_point time) {
  fs::path path = FilledIn(pattern, name, time).lexically_normal();
  if (path.filename().empty()) path = path.parent_path();
  if (!path.has_parent_path()) path = fs::path(".") / path;
  renderer::CreateFolders(path.parent_path());
  CheckLatest(path.parent_path() / "latest");
  RunDirectory run(CreateNewFolder(path));
  for (const fs::path& folder : {run.Checkpoints(), run.Images(), run.Result()}) {
    renderer::CreateFolders(folder);
  }
  PointLatestTo(run.root());
  return run;
}

RunDirectory OpenRunDirectory(const fs::path& path) {
  std::error_code error;
  for (const fs::path& candidate : {path, path / "latest"}) {
    if (fs::is_regular_file(candidate / "run.json", error)) return RunDirectory(candidate);
  }
  throw renderer::IoError(path.string() +
                          ": is not a run directory (run.json is missing); give the folder that "
                          "`pathfit fit` printed, or the folder above it");
}

std::string SafeFileName(const std::string& name) {
  std::string safe;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '.' || c == '-' || c == '_';
    safe += plain ? c : '_';
  }
  constexpr std::size_t kMaxLength = 100;
  if (safe.size() > kMaxLength) safe.resize(kMaxLength);
  if (safe.empty() || safe.front() == '.') safe.insert(safe.begin(), '_');
  return safe;
}

std::vector<std::string> ViewFolderNames(const std::vector<std::string>& view_names) {
  std::map<std::string, int> stem_count;
  for (const std::string& name : view_names) ++stem_count[fs::path(name).stem().string()];
  std::set<std::string> taken;
  std::vector<std::string> folders;
  for (const std::string& name : view_names) {
    const std::string stem = fs::path(name).stem().string();
    const std::string wanted = SafeFileName(stem_count[stem] == 1 ? stem : name);
    std::string folder = wanted;
    for (int suffix = 2; !taken.insert(folder).second; ++suffix) {
      folder = wanted + "-" + std::to_string(suffix);
    }
    folders.push_back(std::move(folder));
  }
  return folders;
}

}  // namespace pathfit::app

#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace pathfit::app {

/// The folder of one run and where things are in it.
class RunDirectory {
 public:
  /// A run that exists already. Throws IoError when `root` is not a directory.
  explicit RunDirectory(std::filesystem::path root);

  [[nodiscard]] const std::filesystem::path& root() const { return root_; }
  [[nodiscard]] std::filesystem::path Config() const { return root_ / "config.yaml"; }
  [[nodiscard]] std::filesystem::path ResolvedConfig() const {
    return root_ / "config.resolved.yaml";
  }
  [[nodiscard]] std::filesystem::path Record() const { return root_ / "run.json"; }
  [[nodiscard]] std::filesystem::path LogFile() const { return root_ / "log.txt"; }
  [[nodiscard]] std::filesystem::path Metrics() const { return root_ / "metrics.csv"; }
  [[nodiscard]] std::filesystem::path History() const { return root_ / "history.json"; }
  [[nodiscard]] std::filesystem::path Checkpoints() const { return root_ / "checkpoints"; }
  [[nodiscard]] std::filesystem::path Images() const { return root_ / "images"; }
  [[nodiscard]] std::filesystem::path Result() const { return root_ / "result"; }
  /// What the report's 3-D view draws (viewed_model.h): of the start, and of the newest scene that
  /// was reported.
  [[nodiscard]] std::filesystem::path StartModel() const { return root_ / "model_start.json"; }
  [[nodiscard]] std::filesystem::path Model() const { return root_ / "model.json"; }
  [[nodiscard]] std::filesystem::path Report() const { return root_ / "report.html"; }

 private:
  std::filesystem::path root_;
};

/// Creates the folder of a new run and its checkpoints, images and result folders.
/// `pattern`: path in which {name} and {timestamp} (UTC, yyyy-mm-dd_HHMMSS) are replaced. An
/// existing folder is never taken: -2, -3 ... is appended. A symbolic link `latest` beside it is
/// made to point to it, in one step. Throws IoError when something cannot be created.
RunDirectory CreateRunDirectory(const std::filesystem::path& pattern,
                                const std::string& name,
                                std::chrono::system_clock::time_point time);

/// The run meant by an argument: the folder itself, or, given a folder of runs, its `latest`.
/// Throws IoError when there is no run.json.
RunDirectory OpenRunDirectory(const std::filesystem::path& path);

/// Letters, digits, '.', '-' and '_' of a name; others become '_'. Never empty and never starts
/// with a dot.
std::string SafeFileName(const std::string& name);

/// One folder name per view, all different: the photo's name without folder and extension where
/// that tells the views apart, the whole name otherwise.
std::vector<std::string> ViewFolderNames(const std::vector<std::string>& view_names);

}  // namespace pathfit::app

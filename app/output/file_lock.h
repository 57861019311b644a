#pragma once

#include <filesystem>

namespace pathfit::app {

/// A lock on a file or folder that ends with the last process that has it open.
class FileLock {
 public:
  /// `open_flags` and `operation`: of open(2) and flock(2). Throws IoError if it cannot be opened.
  FileLock(const std::filesystem::path& path, int open_flags, int operation);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

  [[nodiscard]] bool IsTaken() const { return taken_; }  ///< by another process
  [[nodiscard]] bool IsHeld() const { return held_; }    ///< here; neither: there are no locks

 private:
  int file_;
  bool taken_ = false;
  bool held_ = false;
};

}  // namespace pathfit::app

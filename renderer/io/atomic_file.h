#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace pathfit::renderer {

/// Fails: IoError when `path` is missing or not a regular file (a folder, a pipe).
void CheckRegularFile(const std::filesystem::path& path);

/// Makes the folder and those it lies in, if they are not there. Fails: IoError.
void CreateFolders(const std::filesystem::path& path);

/// All bytes of a regular file. Fails: IoError when it is missing, unreadable or not a regular
/// file.
std::string ReadWholeFile(const std::filesystem::path& path);

/// Calls `write` with an unused name beside `path` (same extension), then renames it to `path`, so
/// that a reader sees the old file or the new one, never a part. On any failure the temporary file
/// is removed. Fails: IoError when the folder is missing or the rename fails; exceptions of `write`
/// pass through.
void WriteThroughTemporary(const std::filesystem::path& path,
                           const std::function<void(const std::filesystem::path&)>& write);

void WriteFileAtomically(const std::filesystem::path& path, std::string_view bytes);

}  // namespace pathfit::renderer

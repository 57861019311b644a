#pragma once

#include <filesystem>

namespace pathfit::app {

/// `path` (absolute) as seen from the folder `from`, so that both can be moved together; as it is
/// where only the root is above both. Where the folder is reached through a symbolic link, from
/// where it really is: that is where ".." leads.
std::filesystem::path NearPath(const std::filesystem::path& path,
                               const std::filesystem::path& from);

}  // namespace pathfit::app

#pragma once

#include <filesystem>
#include <vector>

namespace pathfit::optim {

/// One-dimensional little-endian float64 arrays in NumPy's format, version 1.0. Throw
/// renderer::IoError naming the file.
void WriteNpy(const std::filesystem::path& path, const std::vector<double>& values);
std::vector<double> ReadNpy(const std::filesystem::path& path);

}  // namespace pathfit::optim

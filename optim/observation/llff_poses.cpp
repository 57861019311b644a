#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

#include "optim/observation/camera_import.h"
#include "optim/observation/image_size.h"
#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "renderer/io/text_scanner.h"

namespace pathfit::optim {
namespace {

namespace fs = std::filesystem;
using renderer::IoError;
using renderer::Vec3;

constexpr std::size_t kColumns = 17;  // a 3 x 5 matrix and two depths
constexpr std::size_t kMaxPoses = 1000000;

/// Rows of kColumns numbers.
using Rows = std::vector<std::array<double, kColumns>>;

/// What stands behind 'key': in the header, a Python dictionary, up to the next key.
std::string_view HeaderValue(std::string_view header,
                             std::string_view key,
                             const std::string& name) {
  const std::size_t at = header.find("'" + std::string(key) + "'");
  const std::size_t colon = at == std::string_view::npos ? at : header.find(':', at);
  if (colon == std::string_view::npos) {
    throw IoError(name + ": its header has no '" + std::string(key) + "'; this is no .npy file");
  }
  std::string_view value = header.substr(colon + 1);
  value.remove_prefix(std::min(value.find_first_not_of(' '), value.size()));
  // A shape has commas of its own.
  return value.substr(0, value.starts_with('(') ? value.find(')') : value.find_first_of(",}"));
}

/// The rows of a shape "(N, 17" of numpy.
std::size_t NumRows(std::string_view shape, const std::string& name) {
  const std::size_t comma = shape.find(',');
  std::string_view first = shape.substr(0, comma).substr(std::min<std::size_t>(1, shape.size()));
  std::string_view second = comma == std::string_view::npos ? "" : shape.substr(comma + 1);
  const auto rows = renderer::ParseInteger(renderer::NextToken(first));
  const auto columns = renderer::ParseInteger(renderer::NextToken(second));
  if (!rows || !columns || !second.empty() || *rows < 1 ||
      *rows > static_cast<std::int64_t>(kMaxPoses) || *columns != kColumns) {
    throw IoError(name + ": has the shape " + std::string(shape.substr(0, 40)) +
                  "), not (number of photos, 17)");
  }
  return static_cast<std::size_t>(*rows);
}

/// A .npy file of 32 or 64 bit floats, little endian, in either order.
Rows ReadRows(const fs::path& path) {
  static_assert(std::endian::native == std::endian::little);
  constexpr std::string_view kMagic = "\x93NUMPY";
  constexpr std::size_t kVersion = kMagic.size();
  const std::string name = path.string();
  const std::string bytes = renderer::ReadWholeFile(path);
  if (!bytes.starts_with(kMagic) || bytes.size() < kVersion + 6) {
    throw IoError(name + ": does not start as a .npy file of numpy");
  }
  const bool is_first = bytes[kVersion] == 1;
  std::uint32_t header_size = 0;
  const std::size_t size_bytes = is_first ? 2 : 4;
  std::memcpy(&header_size, bytes.data() + kVersion + 2, size_bytes);
  const std::size_t start = kVersion + 2 + size_bytes;
  if (header_size > bytes.size() - start) throw IoError(name + ": the file ends in its header");
  const std::string_view header(bytes.data() + start, header_size);
  const std::string_view type = HeaderValue(header, "descr", name);
  const bool is_double = type.starts_with("'<f8'");
  if (!is_double && !type.starts_with("'<f4'")) {
    throw IoError(name + ": holds " + std::string(type.substr(0, 20)) +
                  ", not floats ('<f8' or '<f4')");
  }
  const bool by_columns = HeaderValue(header, "fortran_order", name).starts_with("True");
  const std::size_t count = NumRows(HeaderValue(header, "shape", name), name);
  const std::size_t each = is_double ? sizeof(double) : sizeof(float);
  const std::string_view data = std::string_view(bytes).substr(start + header_size);
  if (data.size() != count * kColumns * each) {
    throw IoError(name + ": has " + std::to_string(data.size()) + " bytes of numbers, but " +
                  std::to_string(count) + " x 17 need " + std::to_string(count * kColumns * each));
  }
  Rows rows(count);
  for (std::size_t r = 0; r < count; ++r) {
    for (std::size_t c = 0; c < kColumns; ++c) {
      const char* at = data.data() + each * (by_columns ? c * count + r : r * kColumns + c);
      float single = 0.0F;
      if (is_double) {
        std::memcpy(&rows[r][c], at, sizeof(double));
      } else {
        std::memcpy(&single, at, sizeof single);
        rows[r][c] = static_cast<double>(single);
      }
      if (!std::isfinite(rows[r][c])) {
        throw IoError(name + ": row " + std::to_string(r) + " holds a number that is not finite");
      }
    }
  }
  return rows;
}

}  // namespace

ImportedCameras ReadLlffPoses(const fs::path& path, const fs::path& photos) {
  const Rows rows = ReadRows(path);
  const std::vector<fs::path> pictures = PicturesOf(path, photos, rows.size());
  ImportedCameras result;
  result.folder = path.parent_path();
  result.image_folders = {pictures.front().parent_path()};
  result.files = {path};
  result.notes.emplace_back(
      "Photos: poses_bounds.npy names none; its poses belong to the pictures in " +
      result.image_folders.front().string() + " in the order of their names.");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::array<double, kColumns>& row = rows[i];
    // Rows of a 3 x 5 matrix: columns down, right, backwards, position, size.
    const auto column = [&row](std::size_t c) { return Vec3{row[c], row[c + 5], row[c + 10]}; };
    ImportedCamera& imported = result.cameras.emplace_back();
    imported.place = path.string() + ": row " + std::to_string(i);
    imported.image = pictures[i].filename().string();
    renderer::Camera& camera = imported.camera;
    camera.name = imported.image;
    const Vec3 size = column(4);
    camera.height = CheckedImageSize(size.x, imported.place + ": height");
    camera.width = CheckedImageSize(size.y, imported.place + ": width");
    if (!(size.z > 0.0)) throw IoError(imported.place + ": the focal length must be positive");
    camera.fx = camera.fy = size.z;
    imported.has_principal_point = false;
    camera.world_from_camera = {ExactRotation({column(1), -column(0), column(2)}, imported.place),
                                CheckedCentre(column(3), imported.place)};
  }
  return result;
}

}  // namespace pathfit::optim

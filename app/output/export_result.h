#pragma once

#include <array>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/output/fit_history.h"
#include "app/output/parameter_table.h"
#include "optim/observation/observation.h"
#include "optim/round/fit_spec.h"
#include "renderer/scene/scene.h"

namespace pathfit::app {

/// What belongs to the scene's sensors, one entry each in their order.
struct ExportedView {
  std::string name;        ///< file name of the photo
  std::string image_path;  ///< where it is; transforms.json names it as seen from there (NearPath)
  bool validation = false;
  int width = 0, height = 0;  ///< of the photo's file; 0: that of its sensor
  double gain_error = std::numeric_limits<double>::quiet_NaN();  ///< standard error of its gain
};

enum class MeshFormat { kGlb, kPly, kObj };
/// With the words that name them.
inline constexpr std::array<std::pair<const char*, MeshFormat>, 3> kMeshFormats = {
    {{"glb", MeshFormat::kGlb}, {"obj", MeshFormat::kObj}, {"ply", MeshFormat::kPly}}};

/// The scene's sensors at the sizes of the photos' files, which the fit may have reduced.
std::vector<renderer::Camera> CamerasOfPhotos(const renderer::Scene& scene,
                                              const std::vector<ExportedView>& views);

/// A file for each mesh of the scene, where their poses place them, and what it refers to. Returns
/// the files: of each mesh in the scene's order, its own first. GLB files are in metres where
/// `metres_per_unit` is known, not 0 (WriteGlb). Throws as ExportResult.
std::vector<std::filesystem::path> WriteMeshes(const std::filesystem::path& folder,
                                               const renderer::Scene& scene,
                                               MeshFormat format,
                                               double metres_per_unit = 0.0);

/// All meshes in one file, nodes called as they are: scene.glb, or scene-all.glb where a mesh's own
/// file has that name. The file; `metres_per_unit` and errors as of WriteMeshes.
std::filesystem::path WriteSceneGlb(const std::filesystem::path& folder,
                                    const renderer::Scene& scene,
                                    double metres_per_unit = 0.0);

/// environment.exr and .hdr, as ExportResult writes them; returns no files without an environment.
std::vector<std::filesystem::path> WriteEnvironment(const std::filesystem::path& folder,
                                                    const renderer::Scene& scene);

/// Writes a result folder, in the frame and unit of the scene, but for GLB files, which are in
/// metres where `metres_per_unit` is known: <mesh>.glb and <mesh>.ply, where their poses place
/// them, with vertex colours or the base-colour texture (inside the GLB; <mesh>.png for the PLY,
/// sRGB, clamped to 0..1), the GLB also with those of roughness and metallic and with what shines;
/// textures/<name>.exr with linear values; environment.exr and .hdr (intensity times texels, in the
/// light's own frame) and lights.json, which says how they are turned; cameras/; exposure.csv;
/// parameters.csv. Throws IoError (not writable, a value that a format cannot hold), NumericalError
/// (not finite).
void ExportResult(const std::filesystem::path& folder,
                  const renderer::Scene& scene,
                  const std::vector<ExportedView>& views,
                  const std::vector<ParameterSummary>& parameters,
                  double metres_per_unit = 0.0);

/// textures/<name>_seen.png beside each texture that was made for the fit: white where a fitted
/// photo shows the surface, grey where none does and texels were filled from their neighbours,
/// black beside the surface. Photos are those of the last stage.
void WriteTexelSights(const std::filesystem::path& folder,
                      const renderer::Scene& scene,
                      const optim::FitSpec& fit,
                      const optim::ObservationSet& observations);

/// textures/<name>_standard_error.exr of each texture with unknown texels whose errors are known:
/// the root of the channels' summed squares, 1 where no photo tells the texel.
void WriteTexelErrors(const std::filesystem::path& folder,
                      const renderer::Scene& scene,
                      const optim::FitSpec& fit,
                      const StandardErrorsByName& errors);

std::string LightsJson(const renderer::Scene& scene, double metres_per_unit = 0.0);
std::string ExposureCsv(const renderer::Scene& scene, const std::vector<ExportedView>& views);

}  // namespace pathfit::app

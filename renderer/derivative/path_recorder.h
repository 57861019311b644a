#pragma once

#include <limits>
#include <vector>

#include "renderer/derivative/color_gradient.h"
#include "renderer/path/path_tracer.h"

namespace pathfit::renderer {

/// One path as the tracer built it: what the reverse sweep needs to differentiate it.
class PathRecorder {
 public:
  static constexpr bool kDifferentiates = true;

  struct Vertex {
    SurfacePoint p;
    double emission_weight = 0.0;  ///< of the vertex' own emission, 0 if it has none
    std::size_t first_direct = 0, end_direct = 0;  ///< range in directs
    bool continues = false;
    Continuation on;

    // Filled by the sweep; adjoints of the path's radiance.
    Rgb throughput;
    ColorGradient d_x, d_ng;  ///< by position and by the geometric normal on the side of wo
    ColorGradient d_n;        ///< by the shading normal on the side of wo
    ColorGradient d_wo;       ///< by the direction to the viewer
    ColorGradient d_wi;       ///< delta vertices: by the direction of the next ray
    Rgb d_log_area;           ///< by log of the area ratio J
    Rgb d_base_color, d_roughness, d_metallic, d_eta, d_k;
    Rgb emission;  ///< throughput * weight, the factor of the radiance it emits
  };

  /// Keeps everything.
  PathRecorder() = default;
  /// Asks for no light until a path has met a mesh with `touches`, which must outlive the recorder.
  explicit PathRecorder(const std::vector<bool>& touches) : touches_(&touches) {}

  void Clear() {
    vertices.clear();
    directs.clear();
    contact = std::numeric_limits<std::size_t>::max();
    wants_light_ = touches_ == nullptr;
  }
  void OnVertex(const SurfacePoint& p) {
    wants_light_ = wants_light_ || (*touches_)[static_cast<std::size_t>(p.id.mesh)];
    vertices.emplace_back();
    vertices.back().p = p;
    vertices.back().first_direct = vertices.back().end_direct = directs.size();
  }
  void OnEmission(const LightSet::AreaLight&, double weight) {
    vertices.back().emission_weight = weight;
  }
  void OnDirect(const DirectContribution& direct) {
    directs.push_back(direct);
    vertices.back().end_direct = directs.size();
  }
  void OnContinue(const Continuation& on) {
    vertices.back().continues = true;
    vertices.back().on = on;
  }
  void OnRadiance(int, const Rgb&) {}
  [[nodiscard]] bool WantsLight() const { return wants_light_; }

  std::vector<Vertex> vertices;
  std::vector<DirectContribution> directs;
  /// Directions away from this vertex are kept fixed, and vertices behind it do not move.
  std::size_t contact = std::numeric_limits<std::size_t>::max();

 private:
  const std::vector<bool>* touches_ = nullptr;
  bool wants_light_ = true;
};

}  // namespace pathfit::renderer

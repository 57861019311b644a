#pragma once

#include <vector>

#include "renderer/derivative/color_gradient.h"
#include "renderer/path/path_tracer.h"

namespace pathfit::renderer {

/// One path as the tracer built it: what its derivative needs.
struct PathRecord {
  struct Vertex {
    SurfacePoint p;
    double emission_weight = 0.0;  ///< of the vertex' own emission, 0 if it has none
    std::size_t first_direct = 0, end_direct = 0;  ///< range in directs
    bool continues = false;
    Continuation on;
  };
  std::vector<Vertex> vertices;  ///< from the sensor
  std::vector<DirectContribution> directs;
};

/// Adjoints of a path's radiance by what its vertex is, its material included: they lie beside the
/// record, one per vertex.
struct VertexAdjoint : MaterialPartials {
  Rgb throughput;           ///< from the vertex to the pixel
  ColorGradient d_x, d_ng;  ///< by position and by the geometric normal on the side of wo
  ColorGradient d_n;        ///< by the shading normal on the side of wo
  ColorGradient d_wo;       ///< by the direction to the viewer
  ColorGradient d_wi;       ///< delta vertices: by the direction of the next ray
  Rgb d_log_area;           ///< by log of the area ratio J
  Rgb emission;             ///< throughput * weight, the factor of the radiance it emits

  VertexAdjoint& operator+=(const VertexAdjoint& d) {
    AddScaled({1.0, 1.0, 1.0}, d);
    throughput += d.throughput;
    d_x += d.d_x;
    d_ng += d.d_ng;
    d_n += d.d_n;
    d_wo += d.d_wo;
    d_wi += d.d_wi;
    d_log_area += d.d_log_area;
    emission += d.emission;
    return *this;
  }
};

/// Writes a PathRecord.
class PathRecorder {
 public:
  static constexpr bool kDifferentiates = true;

  /// Keeps everything.
  PathRecorder() = default;
  /// Asks for no light until a path has met a mesh with `touches`, which must outlive the recorder.
  explicit PathRecorder(const std::vector<bool>& touches) : touches_(&touches) {}

  /// Of the path since Clear.
  [[nodiscard]] const PathRecord& record() const { return record_; }
  void Clear() {
    record_.vertices.clear();
    record_.directs.clear();
    wants_light_ = touches_ == nullptr;
  }

  void OnVertex(const SurfacePoint& p) {
    wants_light_ = wants_light_ || (*touches_)[static_cast<std::size_t>(p.id.mesh)];
    PathRecord::Vertex& v = record_.vertices.emplace_back();
    v.p = p;
    v.first_direct = v.end_direct = record_.directs.size();
  }
  void OnEmission(double weight) { record_.vertices.back().emission_weight = weight; }
  void OnDirect(const DirectContribution& direct) {
    record_.directs.push_back(direct);
    record_.vertices.back().end_direct = record_.directs.size();
  }
  void OnContinue(const Continuation& on) {
    record_.vertices.back().continues = true;
    record_.vertices.back().on = on;
  }
  void OnRadiance(int, const Rgb&) {}
  [[nodiscard]] bool WantsLight() const { return wants_light_; }

 private:
  PathRecord record_;
  const std::vector<bool>* touches_ = nullptr;
  bool wants_light_ = true;
};

}  // namespace pathfit::renderer

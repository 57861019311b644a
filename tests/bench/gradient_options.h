#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/render_options.h"

namespace pathfit::bench {

/// Command line of gradient_bench.
struct GradientOptions {
  std::vector<std::string> cases;  ///< all, unless named
  std::filesystem::path meshes;
  std::filesystem::path out;         ///< empty: no images
  std::filesystem::path references;  ///< empty: no comparison
  renderer::RenderOptions render;    ///< max_bounces comes from the case
  renderer::DerivativeChoice given;  ///< the rest is found anew for each image
  int repeats = 8;
  int threads = 0;  ///< 0: what the machine offers
  bool finite_differences = false;
  double step = 0.0;    ///< of finite differences; 0: the case's
  bool primal = false;  ///< images only
  bool jacobian = false;
};

/// Usage text with all options.
const char* GradientUsage();

/// Fails: std::invalid_argument naming the option and what is allowed.
GradientOptions ParseGradientOptions(int argc, const char* const* argv);

/// "none", "grid", "adaptive"; "image", "material".
const char* NameOf(renderer::GuideKind guide);
const char* NameOf(renderer::DerivativeForm form);

}  // namespace pathfit::bench

// Time and noise of derivative images on the scenes of the side-by-side benchmark, one JSON line
// per case. gradient_bench --meshes DIR [options]; see README.md beside this file.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "optim/problem/jacobian_sink.h"
#include "renderer/budget_search.h"
#include "renderer/core/parallel.h"
#include "renderer/derivative/film_sink.h"
#include "renderer/io/exr_file.h"
#include "renderer/renderer.h"
#include "tests/bench/gradient_options.h"
#include "tests/bench/peer_scenes.h"
#include "tests/bench/repeated_images.h"

namespace pathfit::bench {
namespace {

using nlohmann::json;
using renderer::Film;
using renderer::ParameterLayout;
using renderer::Renderer;
using renderer::RenderOptions;

/// Of all threads of the process, so far.
double CpuSeconds() {
  std::timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Of several runs: what else the machine does moves the least CPU time least.
struct Seconds {
  double median = 0.0;
  double least_cpu = 0.0;
};

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

/// Of the process so far.
double PeakMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

json TermsJson(const renderer::DerivativeTerms& terms) {
  json result;
  for (const auto& [name, term] : renderer::kDerivativeTerms) result[name] = terms.Has(term);
  return result;
}

json SettingsOf(const GradientOptions& options, const RenderOptions& r) {
  return {{"spp", r.spp},
          {"sppe", r.sppe},
          {"spp_direct", r.spp_direct},
          {"spp_indirect", r.spp_indirect},
          {"spp_pixel", r.spp_pixel},
          {"guide", NameOf(r.guide)},
          {"guide_share", r.guide_share},
          {"form", NameOf(r.form)},
          {"terms", TermsJson(r.terms)},
          {"repeats", options.repeats},
          {"threads", options.threads}};
}

/// Without the reference's error bars there are no z-scores.
json ToJson(const RepeatedImages::Agreement& a, const ReferenceImage& reference) {
  json result = {{"relative_total", a.relative_total},
                 {"relative_l2", a.relative_l2},
                 {"blocks", a.num_blocks},
                 {"reference_mean_square", reference.MeanSquare()}};
  if (reference.has_variance) {
    result["z_rms"] = a.z_rms;
    result["z_mean"] = a.z_mean;
    result["z_total"] = a.z_total;
    result["noise_l2"] = a.noise_l2;
  }
  return result;
}

/// One case with everything its runs need.
class CaseRun {
 public:
  CaseRun(const PeerCase& peer_case, const GradientOptions& options)
      : case_(peer_case),
        options_(options),
        renderer_(peer_case.scene),
        camera_(peer_case.scene.sensors.front()),
        layout_(peer_case.scene) {
    options_.render.max_bounces = case_.max_bounces;
    options_.given.ApplyTo(options_.render);
    found_ = options_.render;
    layout_.Add(case_.kind, case_.mover);
  }

  json Measure() {
    json result = options_.jacobian ? MeasureJacobian() : MeasureImages();
    result["case"] = case_.name;
    result["settings"] = SettingsOf(options_, found_);
    result["peak_mb"] = PeakMegabytes();
    return result;
  }

 private:
  [[nodiscard]] RenderOptions OptionsOf(int repeat) const {
    RenderOptions options = options_.render;
    options.seed += static_cast<std::uint64_t>(repeat);
    return options;
  }
  /// Calls run(repeat); the first call only warms up. What the renderer keeps between passes is
  /// dropped before each: set-up counts.
  template <class Run>
  Seconds SecondsOf(Run run) {
    run(-1);
    std::vector<double> seconds;
    std::vector<double> cpu;
    for (int i = 0; i < options_.repeats; ++i) {
      renderer_.SetParameters(layout_, Moved(0.0));
      const auto start = std::chrono::steady_clock::now();
      const double cpu_start = CpuSeconds();
      run(i);
      cpu.push_back(CpuSeconds() - cpu_start);
      seconds.push_back(
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    return {Median(seconds), *std::min_element(cpu.begin(), cpu.end())};
  }
  [[nodiscard]] double NanosecondsPerPath(const Seconds& seconds) const {
    return seconds.least_cpu * 1e9 /
           (static_cast<double>(camera_.width) * camera_.height * options_.render.spp);
  }
  [[nodiscard]] std::vector<double> Moved(double amount) const {
    std::vector<double> values = layout_.Gather(case_.scene);
    for (int i = 0; i < 3; ++i) {
      values[static_cast<std::size_t>(i)] += amount * case_.direction[i];
    }
    return values;
  }

  void AddDerivative(int repeat, RepeatedImages& images) {
    RenderOptions options = OptionsOf(repeat);
    options.with_image = false;
    const std::vector<double> direction = {case_.direction.x, case_.direction.y, case_.direction.z};
    options = renderer::ChooseDerivative(
        renderer_, {camera_, -1, layout_, {&direction, 1}}, options, options_.given);
    found_ = options;
    renderer::FilmSink sink(layout_, direction, camera_.width, camera_.height);
    renderer_.RenderDerivative(camera_, -1, options, layout_, sink);
    if (repeat >= 0) {
      images.Add(sink.film());
    }
  }
  /// Both sides with the same random numbers.
  void AddDifference(int repeat, RepeatedImages& images) {
    const double step = options_.step > 0.0 ? options_.step : case_.finite_difference_step;
    renderer_.SetParameters(layout_, Moved(-0.5 * step));
    const Film low = renderer_.RenderPrimal(camera_, OptionsOf(repeat));
    renderer_.SetParameters(layout_, Moved(0.5 * step));
    const Film high = renderer_.RenderPrimal(camera_, OptionsOf(repeat));
    if (repeat >= 0) {
      images.AddDifference(low, high, step);
    }
  }

  json MeasureImages() {
    RepeatedImages primal;
    const Seconds primal_s = SecondsOf([&](int i) {
      const Film film = renderer_.RenderPrimal(camera_, OptionsOf(i));
      if (i >= 0) {
        primal.Add(film);
      }
    });
    json result = {{"method", "primal"},
                   {"primal_s", primal_s.median},
                   {"primal_variance", primal.MeanVariance()},
                   {"path_ns", NanosecondsPerPath(primal_s)}};
    if (options_.primal) {
      Compare("_primal", primal, "primal_agreement", result);
      return result;
    }
    RepeatedImages derivative;
    const Seconds gradient_s = SecondsOf([&](int i) {
      options_.finite_differences ? AddDifference(i, derivative) : AddDerivative(i, derivative);
    });
    const double variance = derivative.MeanVariance();
    result.update({{"method", options_.finite_differences ? "finite_differences" : "estimator"},
                   {"gradient_s", gradient_s.median},
                   {"ratio", gradient_s.median / primal_s.median},
                   {"cpu_ratio", gradient_s.least_cpu / primal_s.least_cpu},
                   {"variance", variance},
                   {"efficiency", 1.0 / (variance * gradient_s.median)},
                   {"mean_square_of_derivative", derivative.MeanSquare()}});
    Compare("_fd", derivative, "agreement", result);
    Compare("_primal", primal, "primal_agreement", result);
    if (!options_.out.empty()) {
      const auto write = [&](const char* what, const renderer::Image& image) {
        renderer::WriteExr(options_.out / (case_.name + what), image);
      };
      write("_primal.exr", primal.Mean());
      write("_derivative.exr", derivative.Mean());
      write("_derivative_variance.exr", derivative.VarianceOfMean());
    }
    return result;
  }
  /// Adds the agreement with a reference if there is one.
  void Compare(const char* what,
               const RepeatedImages& images,
               const char* key,
               json& result) const {
    const std::string stem = case_.name + what;
    if (options_.references.empty() ||
        !std::filesystem::exists(options_.references / (stem + ".exr"))) {
      return;
    }
    const ReferenceImage reference = ReadReference(options_.references, stem);
    result[key] = ToJson(images.CompareWith(reference.mean, reference.variance_of_mean), reference);
  }

  json MeasureJacobian() {
    ParameterLayout vertices(case_.scene);
    vertices.Add(renderer::ParameterKind::kVertexPositions, case_.mover);
    const Seconds primal_s =
        SecondsOf([&](int i) { (void)renderer_.RenderPrimal(camera_, OptionsOf(i)); });
    std::size_t bytes = 0;
    std::size_t blocks = 0;
    const Seconds jacobian_s = SecondsOf([&](int i) {
      optim::JacobianSink sink(camera_.width, camera_.height);
      renderer_.RenderDerivative(camera_, -1, OptionsOf(i), vertices, sink);
      sink.Finish();
      bytes = sink.MemoryBytes();
      blocks = 0;
      for (std::size_t p = 0; p < static_cast<std::size_t>(camera_.width * camera_.height); ++p) {
        blocks += sink.Pixel(p).size();
      }
    });
    return {{"method", "jacobian"},
            {"vertices", vertices.NumBlocks()},
            {"blocks", blocks},
            {"jacobian_mb", static_cast<double>(bytes) / 1048576.0},
            {"primal_s", primal_s.median},
            {"path_ns", NanosecondsPerPath(primal_s)},
            {"gradient_s", jacobian_s.median},
            {"ratio", jacobian_s.median / primal_s.median},
            {"cpu_ratio", jacobian_s.least_cpu / primal_s.least_cpu}};
  }

  const PeerCase& case_;
  GradientOptions options_;
  Renderer renderer_;
  renderer::Camera camera_;
  ParameterLayout layout_;
  RenderOptions found_;  ///< for the last derivative image
};

int Run(int argc, const char* const* argv) {
  GradientOptions options = ParseGradientOptions(argc, argv);
  if (options.threads == 0) {
    options.threads = renderer::DefaultNumThreads();
  }
  const renderer::ThreadLimit limit(options.threads);
  for (const std::string& name : options.cases) {
    const PeerCase peer_case = MakePeerCase(name, options.meshes);
    std::printf("%s\n", CaseRun(peer_case, options).Measure().dump().c_str());
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace pathfit::bench

int main(int argc, char** argv) {
  try {
    return pathfit::bench::Run(argc, argv);
  } catch (const std::invalid_argument& e) {
    std::fprintf(stderr, "gradient_bench: %s\n%s", e.what(), pathfit::bench::GradientUsage());
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "gradient_bench: %s\n", e.what());
    return 3;
  }
}

// The Python module `pathfit`; what its names mean for Python stands in pathfit.pyi beside it.
#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "app/config/config_error.h"
#include "app/config/experiment_config.h"
#include "app/config/nearest_name.h"
#include "app/config/thread_count.h"
#include "app/experiment/direction.h"
#include "app/experiment/experiment.h"
#include "app/experiment/fittable.h"
#include "app/experiment/parameter_names.h"
#include "app/experiment/start_check.h"
#include "app/output/export_result.h"
#include "app/output/figures.h"
#include "app/output/terminal.h"
#include "optim/problem/jacobian_sink.h"
#include "optim/problem/problem_size.h"
#include "optim/round/fit.h"
#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/derivative/derivative_limits.h"
#include "renderer/derivative/film_sink.h"
#include "renderer/renderer.h"

namespace pathfit::app {
namespace {

namespace fs = std::filesystem;
namespace py = pybind11;

constexpr std::size_t kChannels = 4;  // of a film: red, green, blue, coverage

/// An array that owns what `values` held.
template <class Value>
py::array_t<Value> ArrayOf(std::vector<Value> values, std::vector<py::ssize_t> shape) {
  auto owned = std::make_unique<std::vector<Value>>(std::move(values));
  const Value* data = owned->data();
  const py::capsule owner(owned.release(),
                          [](void* p) { delete static_cast<std::vector<Value>*>(p); });
  return py::array_t<Value>(std::move(shape), data, owner);
}

py::array_t<double> ArrayOf(renderer::Film film) {
  static_assert(sizeof(renderer::Rgba) == kChannels * sizeof(double));
  const std::vector<py::ssize_t> shape = {film.height, film.width, py::ssize_t{kChannels}};
  auto owned = std::make_unique<renderer::Film>(std::move(film));
  const double* data = &owned->pixels.data()->r;
  const py::capsule owner(owned.release(), [](void* p) { delete static_cast<renderer::Film*>(p); });
  return py::array_t<double>(shape, data, owner);
}

py::array_t<float> ArrayOf(renderer::Image image) {
  const std::vector<py::ssize_t> shape = {image.height, image.width, image.channels};
  return ArrayOf(std::move(image.data), shape);
}

/// The figures of a report by their names in metrics.csv.
template <class Report>
py::dict DictOf(const Report& report) {
  py::dict dict;
  Fields<Report>::Visit(report, [&](const auto& figure, const auto& value) {
    if constexpr (requires { py::cast(value); }) dict[figure.key] = py::cast(value);
  });
  return dict;
}

/// J^T w of one view. Rows of the image are summed apart, then in their order: the same bits for
/// any number of threads.
class GradientSink final : public renderer::DerivativeSink {
 public:
  GradientSink(const renderer::ParameterLayout& layout,
               const double* weights,
               int width,
               int height)
      : layout_(layout),
        weights_(weights),
        width_(width),
        rows_(static_cast<std::size_t>(height)) {}

  void Add(std::int64_t pixel,
           std::span<const renderer::ParameterDerivative> derivatives) override {
    auto& row = rows_[static_cast<std::size_t>(pixel / width_)];
    const double* w = weights_ + static_cast<std::size_t>(pixel) * kChannels;
    for (const renderer::ParameterDerivative& derivative : derivatives) {
      std::array<double, 3>& sum = row[derivative.block];
      for (std::size_t c = 0; c < sum.size(); ++c) {
        const renderer::Rgba& d = derivative.d[c];
        sum[c] += w[0] * d.r + w[1] * d.g + w[2] * d.b + w[3] * d.a;
      }
    }
  }
  [[nodiscard]] std::vector<double> Sum() const {
    std::vector<double> sum(static_cast<std::size_t>(layout_.NumScalars()));
    for (const auto& row : rows_) {
      for (const auto& [block, values] : row) {
        const auto first = static_cast<std::size_t>(layout_.FirstScalarOfBlock(block));
        const auto size = static_cast<std::size_t>(layout_.GroupOfBlock(block).block_size);
        for (std::size_t c = 0; c < size; ++c) sum[first + c] += values[c];
      }
    }
    return sum;
  }

 private:
  const renderer::ParameterLayout& layout_;
  const double* weights_;
  int width_;
  /// By image row and block.
  std::vector<std::unordered_map<std::int32_t, std::array<double, 3>>> rows_;
};

/// Which numbers of a scene are meant, in which order.
class Parameters {
 public:
  Parameters(const renderer::Scene& scene, const std::vector<std::string>& names) : layout_(scene) {
    for (const std::string& name : names) {
      const ParameterName found = FindParameter(scene, name);
      if (!found.problem.empty()) throw renderer::SceneError(name + ": " + found.problem);
      layout_.Add(found.parameter.kind, found.parameter.object);
    }
  }
  [[nodiscard]] const renderer::ParameterLayout& layout() const { return layout_; }
  [[nodiscard]] std::int64_t size() const { return layout_.NumScalars(); }
  [[nodiscard]] py::list Groups() const {
    py::list groups;
    for (const renderer::ParameterGroup& group : layout_.groups()) {
      py::dict dict;
      dict["name"] = group.name;
      dict["first"] = group.first_scalar;
      dict["shape"] = py::make_tuple(group.num_blocks, group.block_size);
      groups.append(dict);
    }
    return groups;
  }
  [[nodiscard]] std::string NameOf(std::int64_t scalar) const {
    if (scalar < 0 || scalar >= size()) throw py::index_error("no such number");
    const auto& groups = layout_.groups();
    const auto after =
        std::ranges::upper_bound(groups, scalar, {}, [](const auto& g) { return g.first_scalar; });
    const renderer::ParameterGroup& group = *std::prev(after);
    const std::int64_t inside = scalar - group.first_scalar;
    return layout_.ScalarName(
        static_cast<std::int32_t>(group.first_block + inside / group.block_size),
        static_cast<int>(inside % group.block_size));
  }

 private:
  renderer::ParameterLayout layout_;
};

/// Hands what a fit reports to a function of Python, which stops it by returning False; a pending
/// Ctrl-C or an exception of the function stops it, too.
class PythonObserver final : public optim::FitObserver {
 public:
  PythonObserver(py::object on_round, renderer::CancelFlag& cancel)
      : on_round_(std::move(on_round)), cancel_(cancel) {}

  void OnRound(const optim::RoundReport& report) override { Tell(report); }
  void OnView(const std::string& /*stage*/,
              std::size_t /*view*/,
              const renderer::Film& /*image*/,
              const optim::ViewLevel& /*observed*/) override {}
  void OnStage(const optim::StageReport& /*report*/) override {}
  void OnMessage(const std::string& text) override { messages.push_back(text); }
  void OnWarning(const std::string& text) override { warnings.push_back(text); }

  std::vector<std::string> messages, warnings;

 private:
  void Tell(const optim::RoundReport& report) {
    const py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (on_round_.is_none()) return;
    const py::object answer = on_round_(DictOf(report));
    if (answer.is(py::bool_(false))) cancel_ = true;
  }

  py::object on_round_;
  renderer::CancelFlag& cancel_;
};

/// The experiment of a config with a renderer of its scene's present state.
class Scene {
 public:
  Scene(const fs::path& path, const py::dict& overrides, int threads) {
    std::vector<ConfigOverride> list;
    for (const auto& [key, value] : overrides) {
      const std::string name = py::str(key);
      const bool is_bool = py::isinstance<py::bool_>(value);
      const std::string text = is_bool ? (value.cast<bool>() ? "true" : "false") : py::str(value);
      list.push_back({"overrides[" + name + "]", name + "=" + text});
    }
    const std::string variable = ProcessEnvironment(kThreadsVariable);
    std::optional<int> in_environment;
    if (!variable.empty()) in_environment = RequireThreadCount(kThreadsVariable, variable);
    if (threads < 0) throw py::value_error("threads must be at least 0");
    const auto asked = threads > 0 ? std::optional(threads) : std::nullopt;
    const py::gil_scoped_release release;
    config_ = LoadExperimentConfig(path, list);
    threads_ = NumThreads(asked, config_.threads, in_environment);
    const renderer::ThreadLimit limit(threads_);
    experiment_ = BuildExperiment(config_);
    renderer_ = std::make_unique<renderer::Renderer>(experiment_.scene);
  }

  [[nodiscard]] std::vector<std::string> Views() const {
    std::vector<std::string> names;
    for (const renderer::Camera& camera : renderer_->scene().sensors) names.push_back(camera.name);
    return names;
  }
  [[nodiscard]] std::vector<std::string> Messages() const { return experiment_.assumptions; }
  [[nodiscard]] std::vector<std::string> Warnings() const { return experiment_.warnings; }

  [[nodiscard]] py::array_t<float> Photo(const py::object& view) const {
    return ArrayOf(ObservedView(view).photo.Unpack());
  }
  [[nodiscard]] py::object Mask(const py::object& view) const {
    const optim::View& observed = ObservedView(view);
    if (observed.mask.Empty()) return py::none();
    return ArrayOf(observed.mask.Unpack());
  }

  [[nodiscard]] Parameters ParametersNamed(const std::vector<std::string>& names) const {
    return {renderer_->scene(), names};
  }
  [[nodiscard]] py::array_t<double> Values(const Parameters& parameters) const {
    std::vector<double> values = parameters.layout().Gather(renderer_->scene());
    const auto size = static_cast<py::ssize_t>(values.size());
    return ArrayOf(std::move(values), {size});
  }
  void SetValues(const Parameters& parameters,
                 const py::array_t<double, py::array::c_style | py::array::forcecast>& values) {
    if (values.size() != parameters.size()) {
      throw py::value_error(std::to_string(values.size()) + " values for " +
                            std::to_string(parameters.size()) + " parameters");
    }
    renderer::Scene changed = renderer_->scene();
    parameters.layout().Scatter({values.data(), values.data() + values.size()}, changed);
    const py::gil_scoped_release release;
    const renderer::ThreadLimit limit(threads_);
    renderer_ = std::make_unique<renderer::Renderer>(std::move(changed));
  }

  [[nodiscard]] py::array_t<double> Render(const py::object& view,
                                           std::optional<int> spp,
                                           std::optional<std::uint64_t> seed) const {
    const std::size_t index = IndexOf(view);
    renderer::Film film;
    {
      const py::gil_scoped_release release;
      const renderer::ThreadLimit limit(threads_);
      film = renderer_->RenderPrimal(CameraOf(index), OptionsOf(index, spp, seed));
    }
    return ArrayOf(std::move(film));
  }

  [[nodiscard]] py::array_t<double> Derivative(const py::object& view,
                                               const std::string& name,
                                               std::optional<int> spp,
                                               std::optional<std::uint64_t> seed) const {
    const std::size_t index = IndexOf(view);
    renderer::Film film;
    {
      const py::gil_scoped_release release;
      const Direction direction = ParseDirection(renderer_->scene(), name);
      const renderer::Camera& camera = CameraOf(index);
      renderer::FilmSink sink(direction.layout, direction.values, camera.width, camera.height);
      Differentiate(index, direction.layout, spp, seed, sink);
      film = sink.film();
    }
    return ArrayOf(std::move(film));
  }

  [[nodiscard]] py::array_t<double> Gradient(
      const py::object& view,
      const Parameters& parameters,
      const py::array_t<double, py::array::c_style | py::array::forcecast>& weights,
      std::optional<int> spp,
      std::optional<std::uint64_t> seed) const {
    const std::size_t index = IndexOf(view);
    const renderer::Camera& camera = CameraOf(index);
    if (weights.ndim() != 3 || weights.shape(0) != camera.height ||
        weights.shape(1) != camera.width || weights.shape(2) != py::ssize_t{kChannels}) {
      throw py::value_error("weights must have the shape of the picture: (" +
                            std::to_string(camera.height) + ", " + std::to_string(camera.width) +
                            ", 4)");
    }
    std::vector<double> gradient;
    {
      const double* data = weights.data();
      const py::gil_scoped_release release;
      GradientSink sink(parameters.layout(), data, camera.width, camera.height);
      Differentiate(index, parameters.layout(), spp, seed, sink);
      gradient = sink.Sum();
    }
    const auto size = static_cast<py::ssize_t>(gradient.size());
    return ArrayOf(std::move(gradient), {size});
  }

  /// Compressed sparse rows, one of each channel of each pixel.
  [[nodiscard]] py::object Jacobian(const py::object& view,
                                    const Parameters& parameters,
                                    std::optional<int> spp,
                                    std::optional<std::uint64_t> seed) const {
    const std::size_t index = IndexOf(view);
    const renderer::Camera& camera = CameraOf(index);
    const std::size_t pixels =
        static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    std::vector<double> data;
    std::vector<std::int64_t> columns;
    std::vector<std::int64_t> row_ends{0};
    {
      const py::gil_scoped_release release;
      const renderer::ParameterLayout& layout = parameters.layout();
      optim::JacobianSink sink(camera.width, camera.height);
      Differentiate(index, layout, spp, seed, sink);
      sink.Finish();
      row_ends.reserve(pixels * kChannels + 1);
      for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
        for (std::size_t channel = 0; channel < kChannels; ++channel) {
          for (const optim::PixelDerivative& entry : sink.Pixel(pixel)) {
            const std::int64_t first = layout.FirstScalarOfBlock(entry.block);
            const int size = layout.GroupOfBlock(entry.block).block_size;
            for (int c = 0; c < size; ++c) {
              const float d = entry.d[static_cast<std::size_t>(c) * kChannels + channel];
              if (d == 0.0F) continue;
              data.push_back(static_cast<double>(d));
              columns.push_back(first + c);
            }
          }
          row_ends.push_back(static_cast<std::int64_t>(data.size()));
        }
      }
    }
    const auto count = static_cast<py::ssize_t>(data.size());
    const auto num_ends = static_cast<py::ssize_t>(row_ends.size());
    const py::tuple parts = py::make_tuple(ArrayOf(std::move(data), {count}),
                                           ArrayOf(std::move(columns), {count}),
                                           ArrayOf(std::move(row_ends), {num_ends}));
    return py::module_::import("scipy.sparse")
        .attr("csr_matrix")(parts, py::make_tuple(pixels * kChannels, parameters.size()));
  }

  [[nodiscard]] std::vector<std::string> NotInTheDerivative(const Parameters& parameters) const {
    return renderer::DerivativeLimits(renderer_->scene(), parameters.layout());
  }

  /// From the present state, which becomes that of the result.
  py::dict Fit(py::object on_round, double time_limit_s) {
    RequireFittable(config_, "");
    renderer::CancelFlag cancel = false;
    PythonObserver observer(std::move(on_round), cancel);
    optim::FitSpec spec = experiment_.fit;
    spec.time_limit_s = time_limit_s;
    optim::FitControls controls;
    controls.cancel = &cancel;
    optim::FitResult result;
    {
      const py::gil_scoped_release release;
      const renderer::ThreadLimit limit(threads_);
      experiment_.scene = renderer_->scene();
      observer.warnings = CheckStart(config_, experiment_).warnings;
      result =
          optim::RunFit(renderer_->scene(), experiment_.observations, spec, observer, controls);
      renderer_ = std::make_unique<renderer::Renderer>(result.scene);
    }
    py::dict errors;
    for (auto& [name, values] : result.standard_errors) {
      const auto size = static_cast<py::ssize_t>(values.size());
      errors[py::str(name)] = ArrayOf(std::move(values), {size});
    }
    py::dict answer;
    answer["status"] = result.status == optim::FitStatus::kFinished    ? "finished"
                       : result.status == optim::FitStatus::kTimeLimit ? "time limit"
                                                                       : "stopped";
    answer["rounds"] = result.rounds;
    answer["wall_s"] = result.wall_s;
    answer["standard_errors"] = errors;
    py::list stages;
    for (const optim::StageReport& stage : result.stages) stages.append(DictOf(stage));
    answer["stages"] = stages;
    answer["messages"] = observer.messages;
    answer["warnings"] = observer.warnings;
    return answer;
  }

  std::vector<fs::path> WriteMeshes(const fs::path& folder, const std::string& format) const {
    std::vector<std::string> names;
    for (const auto& [name, value] : kMeshFormats) {
      names.emplace_back(name);
      if (format != name) continue;
      fs::create_directories(folder);
      return app::WriteMeshes(folder, renderer_->scene(), value);
    }
    throw py::value_error("format '" + format + "' is not one of: " + JoinNames(names));
  }

 private:
  [[nodiscard]] const renderer::Camera& CameraOf(std::size_t index) const {
    return renderer_->scene().sensors[index];
  }
  /// By name, or by number from 0.
  [[nodiscard]] std::size_t IndexOf(const py::object& view) const {
    const auto& sensors = renderer_->scene().sensors;
    if (py::isinstance<py::int_>(view)) {
      const auto index = view.cast<std::int64_t>();
      if (index >= 0 && index < static_cast<std::int64_t>(sensors.size())) {
        return static_cast<std::size_t>(index);
      }
      throw py::index_error("no view " + std::to_string(index) + "; there are " +
                            std::to_string(sensors.size()));
    }
    const std::string name = py::str(view);
    const auto found = std::ranges::find(sensors, name, &renderer::Camera::name);
    if (found == sensors.end()) throw py::key_error("no view is called '" + name + "'");
    return static_cast<std::size_t>(found - sensors.begin());
  }
  [[nodiscard]] const optim::View& ObservedView(const py::object& view) const {
    const std::size_t index = IndexOf(view);
    if (experiment_.observations.views.empty()) {
      throw py::value_error(config_.path.string() + ": has no photos");
    }
    return experiment_.observations.views[index];
  }
  [[nodiscard]] renderer::RenderOptions OptionsOf(std::size_t index,
                                                  std::optional<int> spp,
                                                  std::optional<std::uint64_t> seed) const {
    renderer::RenderOptions options = config_.render;
    if (spp) {
      if (*spp < 1) throw py::value_error("spp must be at least 1");
      options.spp = *spp;
    }
    if (seed) options.seed = *seed;
    options.view = index;
    return options;
  }
  void Differentiate(std::size_t index,
                     const renderer::ParameterLayout& layout,
                     std::optional<int> spp,
                     std::optional<std::uint64_t> seed,
                     renderer::DerivativeSink& sink) const {
    renderer::RenderOptions options = OptionsOf(index, spp, seed);
    options.with_image = false;
    renderer::CheckDerivative(renderer_->scene(), layout, options);
    const renderer::ThreadLimit limit(threads_);
    renderer_->RenderDerivative(CameraOf(index), static_cast<int>(index), options, layout, sink);
  }

  ExperimentConfig config_;
  Experiment experiment_;
  std::unique_ptr<renderer::Renderer> renderer_;
  int threads_ = 1;
};

}  // namespace

PYBIND11_MODULE(pathfit, m) {
  m.doc() =
      "Path-space differentiable rendering and fits to photographs. Scenes come from the configs "
      "of the program; pathfit.pyi says what everything takes and gives.";
  m.attr("__version__") = PATHFIT_VERSION;
  py::register_exception<ConfigError>(m, "ConfigError", PyExc_ValueError);
  py::register_exception<renderer::SceneError>(m, "SceneError", PyExc_ValueError);
  py::register_exception<renderer::IoError>(m, "IoError", PyExc_OSError);
  py::register_exception<optim::MemoryError>(m, "MemoryError", PyExc_MemoryError);
  py::register_exception<renderer::NumericalError>(m, "NumericalError", PyExc_ArithmeticError);

  py::class_<Parameters>(m, "Parameters", "Which numbers of a scene are meant, in which order.")
      .def("__len__", &Parameters::size)
      .def_property_readonly("groups", &Parameters::Groups)
      .def("name_of", &Parameters::NameOf, py::arg("index"));

  const auto spp = py::arg("spp") = py::none();
  const auto seed = py::arg("seed") = py::none();
  py::class_<Scene>(m, "Scene", "The scene of a config, its photos and stages.")
      .def(py::init<const fs::path&, const py::dict&, int>(),
           py::arg("config"),
           py::arg("overrides") = py::dict(),
           py::arg("threads") = 0)
      .def_property_readonly("views", &Scene::Views)
      .def_property_readonly("messages", &Scene::Messages)
      .def_property_readonly("warnings", &Scene::Warnings)
      .def("photo", &Scene::Photo, py::arg("view"))
      .def("mask", &Scene::Mask, py::arg("view"))
      .def("parameters", &Scene::ParametersNamed, py::arg("names"))
      .def("values", &Scene::Values, py::arg("parameters"))
      .def("set_values", &Scene::SetValues, py::arg("parameters"), py::arg("values"))
      .def("render", &Scene::Render, py::arg("view"), spp, seed)
      .def("derivative", &Scene::Derivative, py::arg("view"), py::arg("direction"), spp, seed)
      .def("gradient",
           &Scene::Gradient,
           py::arg("view"),
           py::arg("parameters"),
           py::arg("weights"),
           spp,
           seed)
      .def("jacobian", &Scene::Jacobian, py::arg("view"), py::arg("parameters"), spp, seed)
      .def("not_in_the_derivative", &Scene::NotInTheDerivative, py::arg("parameters"))
      .def("fit", &Scene::Fit, py::arg("on_round") = py::none(), py::arg("time_limit_s") = 0.0)
      .def("write_meshes", &Scene::WriteMeshes, py::arg("folder"), py::arg("format") = "glb");
}

}  // namespace pathfit::app

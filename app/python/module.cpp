// The Python module `pathfit`; what its names mean for Python stands in pathfit.pyi beside it.
#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
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
#include "app/python/dict_document.h"
#include "app/python/docstrings.h"
#include "optim/checkpoint/checkpoint.h"
#include "optim/problem/jacobian_sink.h"
#include "optim/problem/problem_size.h"
#include "optim/round/fit.h"
#include "renderer/budget_search.h"
#include "renderer/core/error.h"
#include "renderer/core/parallel.h"
#include "renderer/derivative/derivative_limits.h"
#include "renderer/derivative/film_sink.h"
#include "renderer/io/atomic_file.h"
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

/// What the stub says of a name: one that it does not have is not compiled.
consteval const char* Doc(std::string_view name) {
  for (const Docstring& docstring : kDocstrings) {
    if (docstring.name == name) return docstring.text;
  }
  throw "not in pathfit.pyi";
}

/// Functions of Python, or None.
struct FitCallbacks {
  py::object round, message, warning, stage, view;
};

/// Hands what a fit reports to functions of Python, which stop it by returning False; a pending
/// Ctrl-C or an exception of a function stops it, too.
class PythonObserver final : public optim::FitObserver {
 public:
  PythonObserver(FitCallbacks callbacks,
                 const std::vector<optim::View>& views,
                 renderer::CancelFlag& cancel)
      : callbacks_(std::move(callbacks)), views_(views), cancel_(cancel) {}

  void OnRound(const optim::RoundReport& report) override {
    Tell(callbacks_.round, [&](const py::object& call) { return call(DictOf(report)); });
  }
  void OnView(const std::string& stage,
              std::size_t view,
              const renderer::Film& image,
              const optim::ViewLevel& observed) override {
    Tell(callbacks_.view, [&](const py::object& call) {
      return call(stage, views_[view].name, ArrayOf(image), ArrayOf(observed.photo));
    });
  }
  void OnStage(const optim::StageReport& report) override {
    Tell(callbacks_.stage, [&](const py::object& call) { return call(DictOf(report)); });
  }
  void OnMessage(const std::string& text) override {
    messages.push_back(text);
    Tell(callbacks_.message, [&](const py::object& call) { return call(text); });
  }
  void OnWarning(const std::string& text) override {
    warnings.push_back(text);
    Tell(callbacks_.warning, [&](const py::object& call) { return call(text); });
  }

  std::vector<std::string> messages, warnings;

 private:
  template <class Call>
  void Tell(const py::object& callback, const Call& call) {
    const py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (callback.is_none()) return;
    const py::object answer = call(callback);
    const bool is_bool =  // NumPy's comparisons have a type of their own
        py::isinstance<py::bool_>(answer) ||
        py::isinstance(answer, py::module_::import("numpy").attr("bool_"));
    if (is_bool && !answer.cast<bool>()) cancel_ = true;
  }

  FitCallbacks callbacks_;
  const std::vector<optim::View>& views_;
  renderer::CancelFlag& cancel_;
};

/// Derivatives of a view as compressed sparse rows, one of each channel of each pixel. Index: what
/// can count the entries.
template <class Index>
struct SparseRows {
  std::vector<float> data;
  std::vector<Index> columns, row_ends;

  SparseRows(const optim::JacobianSink& sink,
             const renderer::ParameterLayout& layout,
             std::size_t num_pixels,
             std::size_t num_entries) {
    data.reserve(num_entries);
    columns.reserve(num_entries);
    row_ends.reserve(num_pixels * kChannels + 1);
    row_ends.push_back(0);
    for (std::size_t pixel = 0; pixel < num_pixels; ++pixel) {
      for (std::size_t channel = 0; channel < kChannels; ++channel) {
        for (const optim::PixelDerivative entry : sink.Pixel(pixel)) {
          const std::int64_t first = layout.FirstScalarOfBlock(entry.block);
          const int size = layout.GroupOfBlock(entry.block).block_size;
          for (int c = 0; c < size; ++c) {
            const float d = entry.d[static_cast<std::size_t>(c) * kChannels + channel];
            if (d == 0.0F) continue;
            data.push_back(d);
            columns.push_back(static_cast<Index>(first + c));
          }
        }
        row_ends.push_back(static_cast<Index>(data.size()));
      }
    }
  }
};

/// Of scipy, without copies.
template <class Index>
py::object CsrMatrix(SparseRows<Index> rows, std::size_t num_columns) {
  const auto count = static_cast<py::ssize_t>(rows.data.size());
  const auto num_ends = static_cast<py::ssize_t>(rows.row_ends.size());
  const py::tuple parts = py::make_tuple(ArrayOf(std::move(rows.data), {count}),
                                         ArrayOf(std::move(rows.columns), {count}),
                                         ArrayOf(std::move(rows.row_ends), {num_ends}));
  return py::module_::import("scipy.sparse")
      .attr("csr_matrix")(parts, py::make_tuple(num_ends - 1, num_columns));
}

/// The experiment of a config with a renderer of its scene's present state.
class Scene {
 public:
  using Load = std::function<ExperimentConfig(const std::vector<ConfigOverride>&)>;

  static std::unique_ptr<Scene> FromFile(const fs::path& path,
                                         const py::dict& overrides,
                                         int threads) {
    return std::make_unique<Scene>(
        [&](const auto& list) { return LoadExperimentConfig(path, list); }, overrides, threads);
  }
  static std::unique_ptr<Scene> FromString(const std::string& text,
                                           const fs::path& folder,
                                           const py::dict& overrides,
                                           int threads) {
    const char* const name = "<string>";
    const auto load = [&](const auto& list) {
      return ReadExperimentConfig(ParseYaml(text, name), folder / name, list);
    };
    return std::make_unique<Scene>(load, overrides, threads);
  }
  static std::unique_ptr<Scene> FromDict(const py::dict& config,
                                         const fs::path& folder,
                                         const py::dict& overrides,
                                         int threads) {
    const char* const name = "<dict>";
    YamlDocument document = DocumentOf(config, name);
    const auto load = [&](const auto& list) {
      return ReadExperimentConfig(std::move(document), folder / name, list);
    };
    return std::make_unique<Scene>(load, overrides, threads);
  }

  Scene(const Load& load, const py::dict& overrides, int threads) {
    std::vector<ConfigOverride> list;
    for (const auto& [key, value] : overrides) {
      const std::string name = py::str(key);
      list.push_back({"overrides[" + name + "]", name + "=" + OverrideText(value)});
    }
    const std::string variable = ProcessEnvironment(kThreadsVariable);
    std::optional<int> in_environment;
    if (!variable.empty()) in_environment = RequireThreadCount(kThreadsVariable, variable);
    if (threads < 0) throw py::value_error("threads must be at least 0");
    const auto asked = threads > 0 ? std::optional(threads) : std::nullopt;
    const py::gil_scoped_release release;
    config_ = load(list);
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
  /// Throws SceneError if they are of another scene: objects by those numbers, of other sizes.
  [[nodiscard]] const renderer::ParameterLayout& LayoutOf(const Parameters& parameters) const {
    renderer::ParameterLayout own(renderer_->scene());
    for (const renderer::ParameterGroup& group : parameters.layout().groups()) {
      own.Add(group.kind, group.object, group.sharing);
      const renderer::ParameterGroup& same = own.groups().back();
      if (same.name != group.name || same.num_blocks != group.num_blocks ||
          same.block_size != group.block_size) {
        throw renderer::SceneError("the parameters are of another scene: '" + group.name + "'");
      }
    }
    return parameters.layout();
  }
  [[nodiscard]] py::array_t<double> Values(const Parameters& parameters) const {
    std::vector<double> values = LayoutOf(parameters).Gather(renderer_->scene());
    const auto size = static_cast<py::ssize_t>(values.size());
    return ArrayOf(std::move(values), {size});
  }
  void SetValues(const Parameters& parameters,
                 const py::array_t<double, py::array::c_style | py::array::forcecast>& values) {
    if (values.size() != parameters.size()) {
      throw py::value_error(std::to_string(values.size()) + " values for " +
                            std::to_string(parameters.size()) + " parameters");
    }
    const renderer::ParameterLayout& layout = LayoutOf(parameters);
    const std::vector<double> numbers(values.data(), values.data() + values.size());
    const py::gil_scoped_release release;
    const renderer::ThreadLimit limit(threads_);
    renderer_->SetCheckedParameters(layout, numbers);
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
      renderer::RenderOptions options = OptionsOf(index, spp, seed);
      const renderer::ThreadLimit limit(threads_);
      options = renderer::ChooseDerivative(
          *renderer_,
          {camera, static_cast<int>(index), direction.layout, {&direction.values, 1}},
          options,
          config_.derivative);
      Differentiate(index, direction.layout, options, sink);
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
    const renderer::ParameterLayout& layout = LayoutOf(parameters);
    std::vector<double> gradient;
    {
      const double* data = weights.data();
      const py::gil_scoped_release release;
      GradientSink sink(layout, data, camera.width, camera.height);
      Differentiate(index, layout, OptionsFor(layout, index, spp, seed), sink);
      gradient = sink.Sum();
    }
    const auto size = static_cast<py::ssize_t>(gradient.size());
    return ArrayOf(std::move(gradient), {size});
  }

  [[nodiscard]] py::object Jacobian(const py::object& view,
                                    const Parameters& parameters,
                                    std::optional<int> spp,
                                    std::optional<std::uint64_t> seed) const {
    const std::size_t index = IndexOf(view);
    const renderer::Camera& camera = CameraOf(index);
    const std::size_t num_pixels =
        static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    const auto num_columns = static_cast<std::size_t>(parameters.size());
    const renderer::ParameterLayout& layout = LayoutOf(parameters);
    std::optional<SparseRows<std::int32_t>> narrow;
    std::optional<SparseRows<std::int64_t>> wide;
    {
      const py::gil_scoped_release release;
      optim::JacobianSink sink(camera.width, camera.height);
      Differentiate(index, layout, OptionsFor(layout, index, spp, seed), sink);
      sink.Finish();
      std::size_t count = 0;
      for (std::size_t pixel = 0; pixel < num_pixels; ++pixel) {
        for (const optim::PixelDerivative entry : sink.Pixel(pixel)) {
          count += entry.d.size() - static_cast<std::size_t>(std::ranges::count(entry.d, 0.0F));
        }
      }
      // scipy wants one type for columns and ends, and makes it the narrow one where that fits.
      if (std::max({count, num_columns, num_pixels * kChannels}) <=
          static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max())) {
        narrow.emplace(sink, layout, num_pixels, count);
      } else {
        wide.emplace(sink, layout, num_pixels, count);
      }
    }
    return narrow ? CsrMatrix(*std::move(narrow), num_columns)
                  : CsrMatrix(*std::move(wide), num_columns);
  }

  [[nodiscard]] std::vector<std::string> NotInTheDerivative(const Parameters& parameters) const {
    return renderer::DerivativeLimits(
        renderer_->scene(), LayoutOf(parameters), config_.derivative.form);
  }

  /// From the present state, which becomes that of the result.
  py::dict Fit(FitCallbacks callbacks,
               double time_limit_s,
               const std::optional<fs::path>& checkpoints,
               bool resume) {
    RequireFittable(config_, "");
    if (resume && !checkpoints) throw py::value_error("resume needs the folder of checkpoints");
    if (!(time_limit_s >= 0.0)) throw py::value_error("time_limit_s must be at least 0");
    renderer::CancelFlag cancel = false;
    PythonObserver observer(std::move(callbacks), experiment_.observations.views, cancel);
    optim::FitSpec spec = experiment_.fit;
    spec.time_limit_s = time_limit_s;
    optim::FitControls controls;
    controls.cancel = &cancel;
    optim::FitResult result;
    {
      const py::gil_scoped_release release;
      const renderer::ThreadLimit limit(threads_);
      experiment_.scene = renderer_->scene();
      for (const std::string& text : CheckStart(config_, experiment_).warnings) {
        observer.OnWarning(text);
      }
      if (checkpoints) PrepareCheckpoints(*checkpoints, resume, spec, controls, observer);
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
      renderer::CreateFolders(folder);
      return app::WriteMeshes(folder, renderer_->scene(), value);
    }
    throw py::value_error("format '" + format + "' is not one of: " + JoinNames(names));
  }

 private:
  void PrepareCheckpoints(const fs::path& folder,
                          bool resume,
                          const optim::FitSpec& spec,
                          optim::FitControls& controls,
                          PythonObserver& observer) const {
    controls.checkpoint_folder = folder;
    renderer::CreateFolders(folder);
    if (fs::is_empty(folder)) return;
    if (!resume) {
      throw renderer::IoError(folder.string() +
                              ": is not empty; resume=True continues from the checkpoints there");
    }
    auto [state, damaged] =
        optim::ReadNewestCheckpoint(folder, {renderer_->scene(), spec.unknowns});
    for (const std::string& reason : damaged) {
      observer.OnWarning("a checkpoint is left out, and an older one continued: " + reason);
    }
    controls.resume = std::move(state);
  }
  [[nodiscard]] const renderer::Camera& CameraOf(std::size_t index) const {
    return renderer_->scene().sensors[index];
  }
  /// By name, or by number from 0.
  [[nodiscard]] std::size_t IndexOf(const py::object& view) const {
    const auto& sensors = renderer_->scene().sensors;
    if (PyIndex_Check(view.ptr()) != 0) {  // also NumPy's whole numbers, of any size
      const py::object number = py::reinterpret_steal<py::object>(PyNumber_Index(view.ptr()));
      if (!number) throw py::error_already_set();
      int overflow = 0;
      const long long index = PyLong_AsLongLongAndOverflow(number.ptr(), &overflow);
      if (overflow == 0 && index >= 0 && index < static_cast<long long>(sensors.size())) {
        return static_cast<std::size_t>(index);
      }
      throw py::index_error("no view " + std::string(py::str(number)) + "; there are " +
                            std::to_string(sensors.size()));
    }
    if (!py::isinstance<py::str>(view)) throw py::type_error("a view is a name or a whole number");
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
  /// Of derivatives whose samples are not looked for.
  [[nodiscard]] renderer::RenderOptions OptionsFor(const renderer::ParameterLayout& layout,
                                                   std::size_t index,
                                                   std::optional<int> spp,
                                                   std::optional<std::uint64_t> seed) const {
    renderer::RenderOptions options = OptionsOf(index, spp, seed);
    if (!config_.derivative.form) {
      options.form = renderer::DefaultForm(renderer_->scene(), layout);
    }
    return options;
  }
  void Differentiate(std::size_t index,
                     const renderer::ParameterLayout& layout,
                     renderer::RenderOptions options,
                     renderer::DerivativeSink& sink) const {
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
  m.doc() = Doc("");
  m.attr("__version__") = PATHFIT_VERSION;
  const auto error = [&]<class Error>(const char* name, PyObject* base, const char* doc) {
    py::register_exception<Error>(m, name, base).attr("__doc__") = doc;
  };
  error.operator()<ConfigError>("ConfigError", PyExc_ValueError, Doc("ConfigError"));
  error.operator()<renderer::SceneError>("SceneError", PyExc_ValueError, Doc("SceneError"));
  error.operator()<renderer::IoError>("IoError", PyExc_OSError, Doc("IoError"));
  error.operator()<optim::MemoryError>("MemoryError", PyExc_MemoryError, Doc("MemoryError"));
  error.operator()<renderer::NumericalError>(
      "NumericalError", PyExc_ArithmeticError, Doc("NumericalError"));

  py::class_<Parameters>(m, "Parameters", Doc("Parameters"))
      .def("__len__", &Parameters::size, Doc("Parameters.__len__"))
      .def_property_readonly("groups", &Parameters::Groups, Doc("Parameters.groups"))
      .def("name_of", &Parameters::NameOf, Doc("Parameters.name_of"), py::arg("index"));

  const auto view = py::arg("view");
  const auto parameters = py::arg("parameters");
  const auto spp = py::arg("spp") = py::none();
  const auto seed = py::arg("seed") = py::none();
  const auto folder = py::arg("folder") = ".";
  const auto overrides = py::arg("overrides") = py::dict();
  const auto threads = py::arg("threads") = 0;
  const auto none = [](const char* name) { return py::arg(name) = py::none(); };
  const auto fit = [](Scene& scene,
                      py::object on_round,
                      double time_limit_s,
                      py::object on_message,
                      py::object on_warning,
                      py::object on_stage,
                      py::object on_view,
                      const std::optional<fs::path>& checkpoints,
                      bool resume) {
    return scene.Fit({std::move(on_round),
                      std::move(on_message),
                      std::move(on_warning),
                      std::move(on_stage),
                      std::move(on_view)},
                     time_limit_s,
                     checkpoints,
                     resume);
  };
  py::class_<Scene>(m, "Scene", Doc("Scene"))
      .def(py::init(&Scene::FromFile), Doc("Scene.__init__"), py::arg("config"), overrides, threads)
      .def_static("from_string",
                  &Scene::FromString,
                  Doc("Scene.from_string"),
                  py::arg("text"),
                  folder,
                  overrides,
                  threads)
      .def_static("from_dict",
                  &Scene::FromDict,
                  Doc("Scene.from_dict"),
                  py::arg("config"),
                  folder,
                  overrides,
                  threads)
      .def_property_readonly("views", &Scene::Views, Doc("Scene.views"))
      .def_property_readonly("messages", &Scene::Messages, Doc("Scene.messages"))
      .def_property_readonly("warnings", &Scene::Warnings, Doc("Scene.warnings"))
      .def("photo", &Scene::Photo, Doc("Scene.photo"), view)
      .def("mask", &Scene::Mask, Doc("Scene.mask"), view)
      .def("parameters", &Scene::ParametersNamed, Doc("Scene.parameters"), py::arg("names"))
      .def("values", &Scene::Values, Doc("Scene.values"), parameters)
      .def("set_values", &Scene::SetValues, Doc("Scene.set_values"), parameters, py::arg("values"))
      .def("render", &Scene::Render, Doc("Scene.render"), view, spp, seed)
      .def("derivative",
           &Scene::Derivative,
           Doc("Scene.derivative"),
           view,
           py::arg("direction"),
           spp,
           seed)
      .def("gradient",
           &Scene::Gradient,
           Doc("Scene.gradient"),
           view,
           parameters,
           py::arg("weights"),
           spp,
           seed)
      .def("jacobian", &Scene::Jacobian, Doc("Scene.jacobian"), view, parameters, spp, seed)
      .def("not_in_the_derivative",
           &Scene::NotInTheDerivative,
           Doc("Scene.not_in_the_derivative"),
           parameters)
      .def("fit",
           fit,
           Doc("Scene.fit"),
           none("on_round"),
           py::arg("time_limit_s") = 0.0,
           none("on_message"),
           none("on_warning"),
           none("on_stage"),
           none("on_view"),
           none("checkpoints"),
           py::arg("resume") = false)
      .def("write_meshes",
           &Scene::WriteMeshes,
           Doc("Scene.write_meshes"),
           py::arg("folder"),
           py::arg("format") = "glb");
}

}  // namespace pathfit::app

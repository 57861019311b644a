#include "tests/bench/gradient_options.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <sstream>
#include <stdexcept>

#include "tests/bench/peer_scenes.h"

namespace pathfit::bench {

using renderer::DerivativeForm;
using renderer::DerivativeTerms;
using renderer::GuideKind;

namespace {

[[noreturn]] void Refuse(const std::string& option,
                         const std::string& value,
                         const std::string& allowed) {
  throw std::invalid_argument(option + " " + value + ": " + allowed);
}

double ParseNumber(const std::string& option, const std::string& text, double low, double high) {
  double value = 0.0;
  std::size_t used = 0;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used != text.size() || text.empty() || !(value >= low && value <= high)) {
    std::ostringstream allowed;
    allowed << "a number from " << low << " to " << high << " is needed";
    Refuse(option, text, allowed.str());
  }
  return value;
}

int ParseInt(const std::string& option, const std::string& text, int low, int high) {
  const double value = ParseNumber(option, text, low, high);
  if (value != std::floor(value)) {
    Refuse(option, text, "a whole number is needed");
  }
  return static_cast<int>(value);
}

template <class Enum>
Enum ParseName(const std::string& option,
               const std::string& text,
               std::initializer_list<Enum> values) {
  std::string allowed = "allowed are";
  for (const Enum value : values) {
    if (text == NameOf(value)) {
      return value;
    }
    allowed += std::string(" ") + NameOf(value);
  }
  Refuse(option, text, allowed);
}

DerivativeTerms ParseTerms(const std::string& text) {
  DerivativeTerms terms = {};
  for (const auto& [name, term] : renderer::kDerivativeTerms) terms.Set(term, false);
  std::istringstream list(text);
  for (std::string word; std::getline(list, word, ',');) {
    const auto found = std::ranges::find_if(renderer::kDerivativeTerms,
                                            [&](const auto& term) { return word == term.first; });
    if (found == renderer::kDerivativeTerms.end()) {
      Refuse("--terms", text, "allowed are interior,primary,direct,indirect,pixel");
    }
    terms.Set(found->second, true);
  }
  return terms;
}

}  // namespace

const char* NameOf(GuideKind guide) {
  switch (guide) {
    case GuideKind::kNone:
      return "none";
    case GuideKind::kGrid:
      return "grid";
    case GuideKind::kAdaptive:
      return "adaptive";
  }
  return "";
}

const char* NameOf(DerivativeForm form) {
  return form == DerivativeForm::kImage ? "image" : "material";
}

const char* GradientUsage() {
  return "gradient_bench --meshes DIR [options]\n"
         "  --case NAME               once per case; all four by default\n"
         "  --spp N                   interior samples per pixel\n"
         "  --sppe X                  primary-edge samples per pixel of edge length\n"
         "  --spp-direct X            direct-boundary samples per pixel\n"
         "  --spp-indirect X          indirect-boundary samples per pixel\n"
         "  --spp-pixel X             pixel-border samples per pixel\n"
         "  --guide none|grid|adaptive\n"
         "  --guide-share X           share of the boundary samples that build the guide\n"
         "  --form image|material\n"
         "  --terms LIST              interior,primary,direct,indirect,pixel\n"
         "  --repeats N --threads N --seed N\n"
         "  --finite-differences X    central differences of the primal instead; X is the whole\n"
         "                            step, 0 the case's own\n"
         "  --primal                  images only\n"
         "  --jacobian                sparse derivative by all vertices of the moving mesh\n"
         "  --references DIR          CASE_fd.exr, CASE_primal.exr, each with _variance.exr,\n"
         "                            to compare with\n"
         "  --out DIR                 mean images as EXR\n";
}

GradientOptions ParseGradientOptions(int argc, const char* const* argv) {
  GradientOptions options;
  auto& render = options.render;
  constexpr double kMost = 1e6;
  using Text = const std::string&;
  const std::map<std::string, std::function<void(Text)>> setters = {
      {"--case", [&](Text t) { options.cases.push_back(t); }},
      {"--meshes", [&](Text t) { options.meshes = t; }},
      {"--out", [&](Text t) { options.out = t; }},
      {"--references", [&](Text t) { options.references = t; }},
      {"--spp", [&](Text t) { render.spp = ParseInt("--spp", t, 1, 1000000); }},
      {"--sppe", [&](Text t) { options.given.sppe = ParseNumber("--sppe", t, 0, kMost); }},
      {"--spp-direct",
       [&](Text t) { options.given.spp_direct = ParseNumber("--spp-direct", t, 0, kMost); }},
      {"--spp-indirect",
       [&](Text t) { options.given.spp_indirect = ParseNumber("--spp-indirect", t, 0, kMost); }},
      {"--spp-pixel",
       [&](Text t) { options.given.spp_pixel = ParseNumber("--spp-pixel", t, 0, kMost); }},
      {"--guide",
       [&](Text t) {
         render.guide =
             ParseName("--guide", t, {GuideKind::kNone, GuideKind::kGrid, GuideKind::kAdaptive});
       }},
      {"--guide-share",
       [&](Text t) { render.guide_share = ParseNumber("--guide-share", t, 0.0, 0.9); }},
      {"--form",
       [&](Text t) {
         options.given.form =
             ParseName("--form", t, {DerivativeForm::kImage, DerivativeForm::kMaterial});
       }},
      {"--terms", [&](Text t) { render.terms = ParseTerms(t); }},
      {"--repeats", [&](Text t) { options.repeats = ParseInt("--repeats", t, 2, 100000); }},
      {"--threads", [&](Text t) { options.threads = ParseInt("--threads", t, 0, 4096); }},
      {"--seed",
       [&](Text t) {
         render.seed = static_cast<std::uint64_t>(ParseInt("--seed", t, 0, 1000000000));
       }},
      {"--finite-differences",
       [&](Text t) {
         options.finite_differences = true;
         options.step = ParseNumber("--finite-differences", t, 0.0, 1.0);
       }},
  };
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--jacobian" || name == "--primal") {
      (name == "--primal" ? options.primal : options.jacobian) = true;
      continue;
    }
    const auto setter = setters.find(name);
    if (setter == setters.end() || i + 1 >= argc) {
      throw std::invalid_argument(name + ": unknown option or missing value");
    }
    setter->second(argv[++i]);
  }
  if (options.meshes.empty()) {
    throw std::invalid_argument("--meshes is needed: the folder of the benchmark's mesh files");
  }
  if (options.cases.empty()) {
    options.cases = PeerCaseNames();
  }
  return options;
}

}  // namespace pathfit::bench

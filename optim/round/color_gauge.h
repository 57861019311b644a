#pragma once

#include <optional>
#include <vector>

#include "optim/parameter/parameter_set.h"
#include "optim/round/fit_report.h"
#include "optim/round/fit_spec.h"
#include "renderer/scene/scene.h"

namespace pathfit::optim {

/// Mean base colour over the surfaces of a material, of all materials if it is -1; without meshes
/// that shine.
renderer::Rgb MeanBaseColor(const renderer::Scene& scene, int material);

/// What tells the scale in a stage that frees `set`; nothing if all colours or all lights are
/// known.
std::optional<GaugeReport> SourceOfGauge(const ParameterSet& set,
                                         const FitSpec& spec,
                                         const renderer::Scene& scene);

/// Where the rule holds, brings the mean base colour to that of the rule, and the factor into the
/// lights. Colours stay within their bounds, and the others move by more for it; does nothing if
/// that does not reach the mean, or a light would leave its bounds.
void FixColorGauge(const ParameterSet& set,
                   const FitSpec& spec,
                   const renderer::Scene& start,
                   renderer::Scene& scene);

/// Where the rule holds, slopes of the mean base colour by theta, a vector by channel; else
/// nothing.
std::vector<std::vector<double>> SlopesOfRule(const ParameterSet& set,
                                              const FitSpec& spec,
                                              const renderer::Scene& scene);

/// Of the last stage that frees colours and lights at once, for the result of a fit.
std::optional<GaugeReport> ReportGauge(const FitSpec& spec,
                                       const ExposureModel& exposure,
                                       const renderer::Scene& start,
                                       const renderer::Scene& result);

}  // namespace pathfit::optim

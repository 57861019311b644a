#pragma once

#include "renderer/boundary/boundary_segment.h"

namespace pathfit::renderer {

/// Runs the boundary estimators that the options ask for and feeds the sink. Estimators run in
/// parallel; the sink is fed in an order that does not depend on threads.
void EmitBoundaries(const PathContext& interior,
                    const CameraModel& camera,
                    const ActiveParameters& active,
                    const RenderOptions& options,
                    const RenderServices& services,
                    DerivativeSink& sink,
                    RenderStats& stats);

}  // namespace pathfit::renderer

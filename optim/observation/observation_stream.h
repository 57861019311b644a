#pragma once

#include "optim/observation/load_observations.h"
#include "optim/observation/observation.h"
#include "optim/ranks/byte_stream.h"

namespace pathfit::optim {

/// Everything of observations but the numbers of their images, for other processes.
Bytes EncodeObservations(const ObservationSet& observations);

/// The same observations, whose images are read from their files when they are first needed.
/// `options` are those that they were loaded by. Throws renderer::IoError; so does an image whose
/// file has become unreadable or has another size.
ObservationSet DecodeObservations(const Bytes& bytes, const ObservationOptions& options);

}  // namespace pathfit::optim

#pragma once

namespace pathfit::optim {

/// Largest resident memory of this process so far, MB; 0 where the system does not tell.
double PeakResidentMegabytes();

}  // namespace pathfit::optim

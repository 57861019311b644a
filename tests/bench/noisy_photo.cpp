// A photo with noise: noisy_photo IN.exr OUT.exr --gaussian SIGMA --shot VARIANCE --seed N. A value
// v gets normal noise of variance SIGMA^2 + VARIANCE max(v, 0); for random_fits.py.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>

#include "renderer/io/exr_file.h"
#include "renderer/sampler/counter_rng.h"

namespace pathfit::bench {
namespace {

double Normal(renderer::CounterRng& rng) {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - rng.Next()));
  return radius * std::cos(2.0 * std::numbers::pi * rng.Next());
}

void Main(int argc, char** argv) {
  std::map<std::string, double> options{{"--gaussian", 0.0}, {"--shot", 0.0}, {"--seed", 0.0}};
  if (argc < 3 || argc % 2 == 0) {
    throw std::invalid_argument("usage: IN.exr OUT.exr [--gaussian S] [--shot V] [--seed N]");
  }
  for (int i = 3; i < argc; i += 2) {
    options.at(argv[i]) = std::stod(argv[i + 1]);
  }
  const double sigma = options["--gaussian"], shot = options["--shot"];
  renderer::Image image = renderer::ReadExr(argv[1]);
  renderer::CounterRng rng(static_cast<std::uint64_t>(options["--seed"]));
  for (float& v : image.data) {
    const double variance = sigma * sigma + shot * std::max(0.0, static_cast<double>(v));
    v += static_cast<float>(std::sqrt(variance) * Normal(rng));
  }
  renderer::WriteExr(argv[2], image);
}

}  // namespace
}  // namespace pathfit::bench

int main(int argc, char** argv) {
  try {
    pathfit::bench::Main(argc, argv);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "noisy_photo: %s\n", error.what());
    return 1;
  }
}

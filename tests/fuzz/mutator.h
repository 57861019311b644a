#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace pathfit::tests {

/// Damages bytes: a few edits each time, the same ones for the same seed.
class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}

  std::size_t Below(std::size_t count) { return count < 2 ? 0 : random_() % count; }

  /// `other`: a file of the same kind, of which parts may be put in; `words`: what means something
  /// in files of this kind.
  std::string Mutate(std::string bytes,
                     const std::string& other,
                     const std::vector<std::string>& words);

 private:
  void Edit(const std::string& other, const std::vector<std::string>& words, std::string& bytes);
  void PutNumber(std::string& bytes);
  void ReplaceDigits(std::string& bytes);

  std::mt19937_64 random_;
};

}  // namespace pathfit::tests

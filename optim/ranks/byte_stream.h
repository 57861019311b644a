#pragma once

#include <cstddef>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "renderer/core/error.h"

namespace pathfit::optim {

/// What travels between processes of one program on machines alike: numbers as they are in memory.
using Bytes = std::vector<char>;

template <class T>
concept PlainBytes = std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>;

class ByteWriter {
 public:
  template <PlainBytes T>
  void Put(const T& value) {
    Append(&value, sizeof(T));
  }
  template <PlainBytes T>
  void Put(const std::vector<T>& values) {
    Put(values.size());
    Append(values.data(), values.size() * sizeof(T));
  }
  void Put(const std::string& text) {
    Put(text.size());
    Append(text.data(), text.size());
  }
  [[nodiscard]] Bytes Take() { return std::move(bytes_); }

 private:
  void Append(const void* from, std::size_t size) {
    if (size == 0) return;
    const std::size_t at = bytes_.size();
    bytes_.resize(at + size);
    std::memcpy(bytes_.data() + at, from, size);
  }
  Bytes bytes_;
};

/// Reads what a ByteWriter put, in its order. Throws renderer::IoError beyond the end.
class ByteReader {
 public:
  /// `bytes` must outlive it.
  explicit ByteReader(const Bytes& bytes) : bytes_(bytes) {}

  template <PlainBytes T>
  void Get(T& value) {
    Copy(&value, sizeof(T));
  }
  template <PlainBytes T>
  void Get(std::vector<T>& values) {
    values.resize(Count(sizeof(T)));
    Copy(values.data(), values.size() * sizeof(T));
  }
  void Get(std::string& text) {
    text.resize(Count(1));
    Copy(text.data(), text.size());
  }

 private:
  std::size_t Count(std::size_t size_of_each) {
    std::size_t count = 0;
    Get(count);
    Require(count <= (bytes_.size() - at_) / size_of_each);
    return count;
  }
  void Copy(void* to, std::size_t size) {
    Require(size <= bytes_.size() - at_);
    if (size > 0) {
      std::memcpy(to, bytes_.data() + at_, size);
    }
    at_ += size;
  }
  static void Require(bool is_there) {
    if (!is_there) throw renderer::IoError("a message between ranks is cut off");
  }

  const Bytes& bytes_;
  std::size_t at_ = 0;
};

}  // namespace pathfit::optim

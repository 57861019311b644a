#pragma once

#include <array>
#include <cstddef>
#include <cstring>
#include <optional>
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

/// What a type that is no plain bytes is made of, once for both directions: calls visit(part) for
/// each. A type says it by a static VisitParts(auto& value, const auto& visit).
template <class T>
struct Parts {
  static void Visit(auto& value, const auto& visit) { T::VisitParts(value, visit); }
};
template <class A, class B>
struct Parts<std::pair<A, B>> {
  static void Visit(auto& pair, const auto& visit) {
    visit(pair.first);
    visit(pair.second);
  }
};
template <class T, std::size_t kSize>
struct Parts<std::array<T, kSize>> {
  static void Visit(auto& values, const auto& visit) {
    for (auto& value : values) visit(value);
  }
};

class ByteWriter {
 public:
  template <class T>
  void Put(const T& value) {
    if constexpr (PlainBytes<T>) {
      Append(&value, sizeof(T));
    } else {
      Parts<T>::Visit(value, [this](const auto& part) { this->Put(part); });
    }
  }
  template <class T>
  void Put(const std::vector<T>& values) {
    Put(values.size());
    if constexpr (PlainBytes<T>) {
      Append(values.data(), values.size() * sizeof(T));
    } else {
      for (const T& value : values) Put(value);
    }
  }
  template <class T>
  void Put(const std::optional<T>& value) {
    Put(value.has_value());
    if (value) Put(*value);
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

  template <class T>
  void Get(T& value) {
    if constexpr (PlainBytes<T>) {
      Copy(&value, sizeof(T));
    } else {
      Parts<T>::Visit(value, [this](auto& part) { this->Get(part); });
    }
  }
  template <class T>
  void Get(std::vector<T>& values) {
    if constexpr (PlainBytes<T>) {
      values.resize(Count(sizeof(T)));
      Copy(values.data(), values.size() * sizeof(T));
    } else {
      values.clear();
      for (std::size_t rest = Count(1); rest > 0; --rest) Get(values.emplace_back());
    }
  }
  template <class T>
  void Get(std::optional<T>& value) {
    bool has_value = false;
    Get(has_value);
    if (!has_value) return value.reset();
    T part;
    Get(part);
    value = std::move(part);
  }
  void Get(std::string& text) {
    text.resize(Count(1));
    Copy(text.data(), text.size());
  }

 private:
  /// Of things that take so many bytes each, or more.
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

#pragma once

#include <atomic>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

namespace pathfit::renderer {

/// A std::vector whose copies share their elements until one of them is changed: a scene that
/// differs from another by some vertices shares its textures with it. Copies take constant time and
/// no memory.
///
/// Constant members never copy elements and may be called from several threads at once, also on
/// copies that share. Every other member first makes the elements this object's own, which takes
/// time in proportion to their number if they are shared: read through a reference to const. A
/// reference or iterator from a member that is not constant must not be written through after the
/// object was copied, which would change the copy, too.
template <class T>
class SharedVector {
 public:
  using value_type = T;
  using size_type = std::size_t;
  using const_iterator = typename std::vector<T>::const_iterator;
  using iterator = typename std::vector<T>::iterator;

  SharedVector() = default;
  SharedVector(std::vector<T> items)  // NOLINT(google-explicit-constructor)
      : items_(std::make_shared<std::vector<T>>(std::move(items))) {}
  SharedVector(std::initializer_list<T> items) : SharedVector(std::vector<T>(items)) {}
  explicit SharedVector(std::size_t count, const T& value = T())
      : SharedVector(std::vector<T>(count, value)) {}

  [[nodiscard]] const std::vector<T>& Items() const {
    static const std::vector<T> kNone;
    return items_ == nullptr ? kNone : *items_;
  }
  operator const std::vector<T>&() const { return Items(); }  // NOLINT(google-explicit-constructor)
  /// The elements, to be changed at will.
  std::vector<T>& Edit() {
    if (items_ == nullptr) {
      items_ = std::make_shared<std::vector<T>>();
    } else if (items_.use_count() > 1) {
      items_ = std::make_shared<std::vector<T>>(*items_);
    } else {
      // What another thread did with its copy before it gave that up has happened.
      std::atomic_thread_fence(std::memory_order_acquire);
    }
    return *items_;
  }

  [[nodiscard]] std::size_t size() const { return items_ == nullptr ? 0 : items_->size(); }
  [[nodiscard]] bool empty() const { return size() == 0; }
  const T& operator[](std::size_t i) const { return (*items_)[i]; }
  T& operator[](std::size_t i) { return Edit()[i]; }
  const T& at(std::size_t i) const { return Items().at(i); }
  T& at(std::size_t i) { return Edit().at(i); }
  const T& front() const { return items_->front(); }
  T& front() { return Edit().front(); }
  const T& back() const { return items_->back(); }
  T& back() { return Edit().back(); }
  [[nodiscard]] const T* data() const { return Items().data(); }
  [[nodiscard]] const_iterator begin() const { return Items().begin(); }
  [[nodiscard]] const_iterator end() const { return Items().end(); }
  [[nodiscard]] iterator begin() { return Edit().begin(); }
  [[nodiscard]] iterator end() { return Edit().end(); }

  void clear() { items_ = nullptr; }
  void reserve(std::size_t count) { Edit().reserve(count); }
  void resize(std::size_t count) { Edit().resize(count); }
  void assign(std::size_t count, const T& value) { *this = SharedVector(count, value); }
  void push_back(const T& item) { Edit().push_back(item); }
  template <class... Arguments>
  T& emplace_back(Arguments&&... arguments) {
    return Edit().emplace_back(std::forward<Arguments>(arguments)...);
  }
  void pop_back() { Edit().pop_back(); }
  template <class Iterator>
  void insert(const_iterator at, Iterator first, Iterator last) {
    Edit().insert(at, first, last);
  }
  void insert(const_iterator at, std::initializer_list<T> items) { Edit().insert(at, items); }

  friend bool operator==(const SharedVector& a, const SharedVector& b) {
    return a.items_ == b.items_ || a.Items() == b.Items();
  }

 private:
  std::shared_ptr<std::vector<T>> items_;  // null: no elements
};

}  // namespace pathfit::renderer
